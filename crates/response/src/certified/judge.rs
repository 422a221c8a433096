//! Whether an instant is as good as asked for.

use eigentone_digits::Magnitude;

/// Where digits end, relative to the largest motion so far.
const LIMIT: f64 = 1e-30;

/// Compares errors with what is asked of displacements and velocities.
#[derive(Clone, Debug)]
pub(crate) struct Judge {
    /// What is left of the tolerance when the result has been rounded to a double.
    relative: f64,
    /// The largest displacement and the largest velocity so far.
    largest: [f64; 2],
}

impl Judge {
    /// For a tolerance relative to the largest coordinate of each instant.
    pub(crate) fn new(tolerance: f64) -> Judge {
        const UNIT: f64 = f64::EPSILON / 2.0;
        Judge {
            relative: (tolerance - UNIT).max(UNIT / 1024.0),
            largest: [0.0; 2],
        }
    }

    /// Whether an instant of largest coordinate `size` is good enough with this error before it is
    /// rounded; `kind` is 0 for displacements and 1 for velocities.
    pub(crate) fn judge(&mut self, kind: usize, size: f64, error: Magnitude) -> bool {
        self.largest[kind] = self.largest[kind].max(size);
        let allowed = (self.relative * size).max(LIMIT * self.largest[kind]);
        error.is_zero() || error <= Magnitude::from(allowed)
    }
}
