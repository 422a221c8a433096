//! Choices read from bytes: the same generators then serve random tests, which draw the bytes, and fuzzing,
//! which breeds them. Fewer or smaller bytes make simpler cases, so that both can shrink what they find.

/// Bytes on their way to become choices. Once they run out, every choice is the first one.
#[derive(Debug)]
pub struct Choices<'a>(&'a [u8]);

impl<'a> Choices<'a> {
    pub fn of(bytes: &'a [u8]) -> Choices<'a> {
        Choices(bytes)
    }

    pub fn byte(&mut self) -> u8 {
        match self.0 {
            [first, rest @ ..] => {
                self.0 = rest;
                *first
            }
            [] => 0,
        }
    }

    /// A whole number below `count`, which is at most 256.
    pub fn below(&mut self, count: usize) -> usize {
        usize::from(self.byte()) % count
    }

    /// True once in so many times.
    pub fn once_in(&mut self, times: usize) -> bool {
        self.below(times) == times - 1
    }

    pub fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }

    pub fn bits(&mut self) -> u64 {
        (0..8).fold(0, |bits, _| bits << 8 | u64::from(self.byte()))
    }

    /// From 0 to just below 1, in 65536 steps.
    pub fn fraction(&mut self) -> f64 {
        (f64::from(self.byte()) * 256.0 + f64::from(self.byte())) / 65536.0
    }

    #[allow(dead_code)] // only some of those who share this ask
    pub fn is_over(&self) -> bool {
        self.0.is_empty()
    }
}
