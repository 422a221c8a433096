//! Whether an instant is as good as asked for.

use eigentone_digits::Magnitude;

/// Where digits end, relative to the largest motion so far.
const LIMIT: f64 = 1e-30;

/// Where they end for the velocities of what has always been still and is not accelerated, relative to
/// the largest displacement over all the time, or over that of the fastest motion.
const STILL: f64 = 1e-60;

/// Compares errors with what is asked of displacements and velocities.
#[derive(Clone, Debug)]
pub(crate) struct Judge {
    /// What is left of the tolerance when the result has been rounded to a double.
    relative: f64,
    /// The largest displacement and the largest velocity so far.
    largest: [f64; 2],
    /// The slowest rate that is seen, in 1/s: once in all the time, if not the fastest there is.
    rate: Magnitude,
}

impl Judge {
    /// For a tolerance relative to the largest coordinate of each instant until `end` s, of motions
    /// no faster than `fastest` 1/s.
    pub(crate) fn new(tolerance: f64, end: f64, fastest: Magnitude) -> Judge {
        const UNIT: f64 = f64::EPSILON / 2.0;
        let slowest = Magnitude::from(1.0) / Magnitude::from(end);
        Judge {
            relative: (tolerance - UNIT).max(UNIT / 1024.0),
            largest: [0.0; 2],
            rate: if slowest < fastest { slowest } else { fastest },
        }
    }

    /// Whether an instant is good enough: of its displacements and of its velocities, the largest one
    /// and the error before it is rounded. `accelerates` tells whether any acceleration is not 0.
    pub(crate) fn judge(
        &mut self,
        motion: [(f64, Magnitude); 2],
        accelerates: impl FnOnce() -> bool,
    ) -> bool {
        for (largest, (size, _)) in self.largest.iter_mut().zip(motion) {
            *largest = largest.max(size);
        }
        let good = |kind: usize| {
            let (size, error) = motion[kind];
            let allowed = (self.relative * size).max(LIMIT * self.largest[kind]);
            error.is_zero() || error <= Magnitude::from(allowed)
        };
        let [displacement, velocity] = self.largest;
        let still = Magnitude::from(STILL) * Magnitude::from(displacement) * self.rate;
        good(0) && (good(1) || velocity == 0.0 && motion[1].1 <= still && !accelerates())
    }
}
