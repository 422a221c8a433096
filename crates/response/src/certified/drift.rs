//! How the errors of many steps add up.

use std::ops::Range;

use eigentone_digits::{Magnitude, Real};

use crate::enclosed::Normed;
use crate::problem::MOST_INTEGRALS;

/// The most levels that ζ has: the state of the system, integrals of signals of each order, and what turns by itself.
pub(crate) const LEVELS: usize = MOST_INTEGRALS + 2;

/// A bound of the error of each level of ζ, in the 2-norm.
pub(crate) type Errors = [Magnitude; LEVELS];

/// How a step carries errors on: bounds of the 2-norms of its blocks. A level is moved by itself and by later ones alone, so that
/// what loads add up to grows in proportion to time, where powers of one norm of the whole would grow without measure.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Carried {
    levels: usize,
    norms: [[Magnitude; LEVELS]; LEVELS],
}

impl Carried {
    /// That of a step whose levels are these entries of ζ, from the first on.
    pub(crate) fn of<T: Real>(step: &Normed<T>, levels: &[Range<usize>]) -> Carried {
        let mut norms = [[Magnitude::ZERO; LEVELS]; LEVELS];
        for (a, rows) in levels.iter().enumerate() {
            let before = rows.clone().flat_map(|i| &step.row(i)[..rows.start]);
            debug_assert!(before.clone().all(|entry| entry.is_zero()), "levels");
            norms[a][a] = step.part(rows.clone()).true_norm();
            for (b, columns) in levels.iter().enumerate().skip(a + 1) {
                norms[a][b] = step.between(rows.clone(), columns.clone());
            }
        }
        let levels = levels.len();
        Carried { levels, norms }
    }

    /// Of a step of which nothing is known.
    const UNKNOWN: Carried = Carried {
        levels: LEVELS,
        norms: [[Magnitude::INFINITY; LEVELS]; LEVELS],
    };

    /// By how much a level lengthens its own errors, at most.
    pub(crate) fn growth(&self) -> Magnitude {
        let own = (0..self.levels).map(|level| self.norms[level][level]);
        own.fold(
            Magnitude::ZERO,
            |most, norm| if most < norm { norm } else { most },
        )
    }

    /// Errors become what is left of them after the step.
    pub(crate) fn carry(&self, errors: &mut Errors) {
        for (a, row) in self.norms.iter().enumerate().take(self.levels) {
            let later = row.iter().zip(&*errors).take(self.levels).skip(a);
            errors[a] = later.fold(Magnitude::ZERO, |sum, (norm, error)| sum + *norm * *error);
        }
    }

    /// That of this step after another of the same levels.
    fn after(&self, other: &Carried) -> Carried {
        let mut norms = [[Magnitude::ZERO; LEVELS]; LEVELS];
        for (a, row) in norms.iter_mut().enumerate().take(self.levels) {
            for (b, sum) in row.iter_mut().enumerate().take(self.levels).skip(a) {
                for middle in a..=b {
                    *sum = *sum + self.norms[a][middle] * other.norms[middle][b];
                }
            }
        }
        Carried { norms, ..*self }
    }
}

/// Errors made along the way, each carried on by the steps after it.
///
/// An error met `m` steps ago counts by the norms of Φ^m now. Errors are kept by segments of the way, each
/// with the error it alone has made at its end; two segments join as soon as the later one is as
/// long as the earlier, so that no error passes through more than a few norms for each doubling of
/// the way, and damping that shows only over many steps is made use of.
#[derive(Clone, Debug)]
pub(crate) struct Drift {
    levels: usize,
    /// From before the first segment.
    base: Errors,
    /// Steps and error of each segment, the earliest first.
    segments: Vec<(u64, Errors)>,
    /// How Φ^{2^j} carries errors on.
    powers: Vec<Carried>,
}

impl Drift {
    pub(crate) fn new(levels: usize, base: Errors) -> Drift {
        Drift {
            levels,
            base,
            segments: Vec::new(),
            powers: Vec::new(),
        }
    }

    /// Notes how Φ^{2^j} carries errors on, for j = 0, 1, … in turn.
    pub(crate) fn know(&mut self, j: usize, power: Carried) {
        self.powers.truncate(j);
        self.powers.push(power);
    }

    /// Errors become what is left of them after so many steps, and more.
    fn carry(&mut self, mut steps: u64, errors: &mut Errors, more: &Errors) {
        while steps > 0 {
            let j = steps.trailing_zeros() as usize;
            steps &= steps - 1;
            while self.powers.len() <= j {
                let last = self.powers.last().unwrap_or(&Carried::UNKNOWN);
                self.powers.push(last.after(last));
            }
            self.powers[j].carry(errors);
        }
        let pairs = errors.iter_mut().zip(more).take(self.levels);
        pairs.for_each(|(error, more)| *error = *error + *more);
    }

    /// After so many more steps, which made this error by themselves.
    pub(crate) fn step(&mut self, steps: u64, error: Errors) {
        let (mut steps, mut error) = (steps, error);
        while let Some((before, mut earlier)) = self.segments.pop_if(|(before, _)| *before <= steps)
        {
            self.carry(steps, &mut earlier, &error);
            error = earlier;
            steps += before;
        }
        self.segments.push((steps, error));
    }

    /// The error now.
    pub(crate) fn total(&mut self) -> Errors {
        let mut total = self.base;
        let segments = std::mem::take(&mut self.segments);
        for (steps, error) in &segments {
            self.carry(*steps, &mut total, error);
        }
        self.segments = segments;
        total
    }

    /// Starts anew from this error.
    pub(crate) fn restart(&mut self, base: Errors) {
        self.segments.clear();
        self.base = base;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_digits::DoubleDouble;

    fn errors(first: f64, second: f64) -> Errors {
        let mut errors = [Magnitude::ZERO; LEVELS];
        (errors[0], errors[1]) = (first.into(), second.into());
        errors
    }

    fn lengthens(norm: f64) -> Carried {
        let mut norms = [[Magnitude::ZERO; LEVELS]; LEVELS];
        norms[0][0] = norm.into();
        Carried { levels: 1, norms }
    }

    fn first(errors: Errors) -> f64 {
        errors[0].to_f64()
    }

    #[test]
    fn errors_add_up_linearly_where_nothing_grows() {
        let mut drift = Drift::new(2, errors(0.0, 0.0));
        drift.know(0, lengthens(1.0));
        (0..1000).for_each(|_| drift.step(1, errors(1.0, 0.0)));
        assert!((first(drift.total()) - 1000.0).abs() < 1e-9);
    }

    #[test]
    fn early_errors_fade_under_damping() {
        let mut drift = Drift::new(2, errors(1e9, 0.0));
        (0..10usize).for_each(|j| drift.know(j, lengthens(0.5f64.powi(1 << j))));
        (0..100).for_each(|_| drift.step(1, errors(1.0, 0.0)));
        assert!((first(drift.total()) - 2.0).abs() < 1e-9);
        drift.step(8, errors(0.0, 0.0));
        assert!((first(drift.total()) - 2.0 / 256.0).abs() < 1e-9);
    }

    /// Norms of more steps than are known are squares of what is: eight steps of ½ leave 2⁻⁸.
    #[test]
    fn many_steps_at_once_are_bounded_by_fewer() {
        let mut drift = Drift::new(2, errors(1.0, 0.0));
        drift.know(0, lengthens(0.5));
        drift.step(8, errors(0.0, 0.0));
        assert!((first(drift.total()) * 256.0 - 1.0).abs() < 1e-9);
        let mut drift = Drift::new(2, errors(1.0, 0.0));
        drift.know(0, lengthens(2.0));
        drift.step(5, errors(3.0, 0.0));
        assert!((first(drift.total()) - 35.0).abs() < 1e-6);
    }

    /// Under a load that errs by 2 from the start on, of which a step adds three times as much, an error grows by 6 in each step, by
    /// whatever strides; and one that the load makes anew in each step comes to 3·(1 + 2 + … + 99) after a hundred.
    #[test]
    fn what_loads_add_grows_in_proportion_to_time() {
        let step = [1.0, 3.0, 0.0, 1.0].map(DoubleDouble::from).to_vec();
        let step = Carried::of(&Normed::new(2, 1, step, Magnitude::ZERO), &[0..1, 1..2]);
        for stride in [1, 8, 100] {
            let mut drift = Drift::new(2, errors(5.0, 2.0));
            drift.know(0, step);
            (0..800 / stride).for_each(|_| drift.step(stride, errors(0.0, 0.0)));
            assert!((first(drift.total()) - 4805.0).abs() < 1e-6, "{stride}");
        }
        let mut drift = Drift::new(2, errors(0.0, 0.0));
        drift.know(0, step);
        (0..100).for_each(|_| drift.step(1, errors(0.0, 1.0)));
        assert!((first(drift.total()) - 3.0 * 4950.0).abs() < 1e-6);
    }
}
