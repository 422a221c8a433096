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
    /// Of each combination, the largest so far: what it came to, and what it was made of.
    combinations: Vec<(f64, Magnitude)>,
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
            combinations: Vec::new(),
            rate: if slowest < fastest { slowest } else { fastest },
        }
    }

    /// Whether an instant is good enough: of its displacements and of its velocities, the largest one
    /// and the error before it is rounded. `accelerates` says whether any acceleration is not 0.
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

    /// Whether a combination is good enough: its size, that of what it is made of, and the error before it is rounded.
    pub(crate) fn judge_combination(
        &mut self,
        index: usize,
        size: f64,
        made_of: Magnitude,
        error: Magnitude,
    ) -> bool {
        if self.combinations.len() <= index {
            self.combinations.resize(index + 1, (0.0, Magnitude::ZERO));
        }
        let (largest, whole) = &mut self.combinations[index];
        *largest = largest.max(size);
        if *whole < made_of {
            *whole = made_of;
        }
        let allowed = Magnitude::from(self.relative * *largest);
        let hidden = *whole * Magnitude::from(LIMIT);
        error.is_zero() || error <= allowed || error <= hidden
    }
}
