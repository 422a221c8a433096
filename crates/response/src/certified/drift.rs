//! How the errors of many steps add up.

use eigentone_digits::Magnitude;

/// Errors made along the way, each carried on by the steps after it.
///
/// An error met `m` steps ago counts by ‖Φ^m‖ now. Errors are kept by segments of the way, each
/// with the error it alone has made at its end; two segments join as soon as the later one is as
/// long as the earlier, so that no error passes through more than a few norms for each doubling of
/// the way, and damping that shows only over many steps is made use of.
#[derive(Clone, Debug)]
pub(crate) struct Drift {
    /// From before the first segment.
    base: Magnitude,
    /// Steps and error of each segment, the earliest first.
    segments: Vec<(u64, Magnitude)>,
    /// Bounds of ‖Φ^{2^j}‖.
    norms: Vec<Magnitude>,
}

impl Drift {
    pub(crate) fn new(base: Magnitude) -> Drift {
        Drift {
            base,
            segments: Vec::new(),
            norms: Vec::new(),
        }
    }

    /// Notes that ‖Φ^{2^j}‖ is at most `norm`, for j = 0, 1, … in turn.
    pub(crate) fn know(&mut self, j: usize, norm: Magnitude) {
        self.norms.truncate(j);
        self.norms.push(norm);
    }

    /// A bound of ‖Φ^steps‖.
    fn norm(&mut self, mut steps: u64) -> Magnitude {
        let mut product = Magnitude::from(1.0);
        while steps > 0 {
            let j = steps.trailing_zeros() as usize;
            steps &= steps - 1;
            while self.norms.len() <= j {
                let last = *self.norms.last().unwrap_or(&Magnitude::INFINITY);
                self.norms.push(last * last);
            }
            product = product * self.norms[j];
        }
        product
    }

    /// After so many more steps, which made this error by themselves.
    pub(crate) fn step(&mut self, steps: u64, error: Magnitude) {
        let (mut steps, mut error) = (steps, error);
        while let Some(&(before, earlier)) = self.segments.last() {
            if before > steps {
                break;
            }
            self.segments.pop();
            error = self.norm(steps) * earlier + error;
            steps += before;
        }
        self.segments.push((steps, error));
    }

    /// The error now.
    pub(crate) fn total(&mut self) -> Magnitude {
        let mut total = self.base;
        for at in 0..self.segments.len() {
            let (steps, error) = self.segments[at];
            total = self.norm(steps) * total + error;
        }
        total
    }

    /// Starts anew from this error.
    pub(crate) fn restart(&mut self, base: Magnitude) {
        self.segments.clear();
        self.base = base;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_add_up_linearly_where_nothing_grows() {
        let mut drift = Drift::new(Magnitude::ZERO);
        drift.know(0, Magnitude::from(1.0));
        (0..1000).for_each(|_| drift.step(1, Magnitude::from(1.0)));
        assert!((drift.total().to_f64() - 1000.0).abs() < 1e-9);
    }

    #[test]
    fn early_errors_fade_under_damping() {
        let mut drift = Drift::new(Magnitude::from(1e9));
        (0..10usize).for_each(|j| drift.know(j, Magnitude::from(0.5f64.powi(1 << j))));
        (0..100).for_each(|_| drift.step(1, Magnitude::from(1.0)));
        assert!((drift.total().to_f64() - 2.0).abs() < 1e-9);
        drift.step(8, Magnitude::ZERO);
        assert!((drift.total().to_f64() - 2.0 / 256.0).abs() < 1e-9);
    }

    /// Norms of more steps than are known are squares of what is: eight steps of ½ leave 2⁻⁸.
    #[test]
    fn many_steps_at_once_are_bounded_by_fewer() {
        let mut drift = Drift::new(Magnitude::from(1.0));
        drift.know(0, Magnitude::from(0.5));
        drift.step(8, Magnitude::ZERO);
        assert!((drift.total().to_f64() * 256.0 - 1.0).abs() < 1e-9);
        let mut drift = Drift::new(Magnitude::from(1.0));
        drift.know(0, Magnitude::from(2.0));
        drift.step(5, Magnitude::from(3.0));
        assert!((drift.total().to_f64() - 35.0).abs() < 1e-6);
    }
}
