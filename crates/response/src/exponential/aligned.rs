//! Buffers that begin on a cache line.

use std::ops::{Deref, DerefMut};

/// Doubles whose first one begins a cache line: products of matrices that do not are up to a sixth
/// slower, as their vectors lie across two lines.
#[derive(Clone, Debug)]
pub(super) struct Aligned {
    buffer: Vec<f64>,
    first: usize,
    len: usize,
}

impl Aligned {
    /// `len` zeros.
    pub(super) fn zeros(len: usize) -> Aligned {
        const LINE: usize = 64;
        let buffer = vec![0.0; len + LINE / size_of::<f64>()];
        // An address that cannot be aligned is left as it is: only time is lost.
        let first = buffer.as_ptr().align_offset(LINE);
        let first = if first < LINE / size_of::<f64>() {
            first
        } else {
            0
        };
        Aligned { buffer, first, len }
    }
}

impl From<&[f64]> for Aligned {
    fn from(values: &[f64]) -> Aligned {
        let mut copy = Aligned::zeros(values.len());
        copy.copy_from_slice(values);
        copy
    }
}

impl Deref for Aligned {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.buffer[self.first..self.first + self.len]
    }
}

impl DerefMut for Aligned {
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.buffer[self.first..self.first + self.len]
    }
}
