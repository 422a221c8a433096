//! Exact times on the grid and between its instants.

use eigentone_digits::{Magnitude, Real};

use crate::problem::{Base, Fraction, Instant, Problem};

/// Where the walker stands, or a law set in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Moment {
    /// So many unit steps after 0.
    Units(u64),
    /// A part of a step of the grid that is no whole number of units.
    Part(Fraction),
    /// An event by itself, in s.
    Event(f64),
    /// So many seconds after the start of a pulse.
    Later(Base, f64),
}

/// Exact times: whole multiples of a unit, of which a step of the grid has a whole number, and
/// what lies between them.
pub(super) struct Clock {
    step: f64,
    /// How many units a step of the grid has.
    pub(super) division: u64,
}

impl Clock {
    /// The coarsest unit of which every instant that samples add is a multiple, but for those that
    /// would make it too fine to be counted.
    pub(super) fn of(problem: &Problem<'_>) -> Clock {
        let steps = problem.grid().last().max(1);
        let pieces = problem.timeline().pieces().iter();
        let fractions = pieces.filter_map(|piece| piece.start_instant().fraction());
        let division = fractions.fold(1u64, |all, Fraction { denominator, .. }| {
            let finer = all.checked_mul(denominator / common_divisor(all, denominator));
            let counted = finer.filter(|finer| finer.checked_mul(steps).is_some());
            counted.unwrap_or(all)
        });
        Clock {
            step: problem.grid().step(),
            division,
        }
    }

    pub(super) fn moment(&self, instant: &Instant) -> Moment {
        match instant.fraction() {
            Some(fraction) if self.division.is_multiple_of(fraction.denominator) => {
                Moment::Units(fraction.numerator * (self.division / fraction.denominator))
            }
            Some(fraction) => Moment::Part(fraction),
            None => match instant.parts() {
                (Base::Event(time), 0.0) => Moment::Event(time),
                (base, later) => Moment::Later(base, later),
            },
        }
    }

    /// From 0 to a part of a step, and a bound of the error.
    fn part<T: Real>(&self, numerator: u64, denominator: u64) -> (T, Magnitude) {
        let product = exactly::<T>(numerator) * T::from(self.step);
        let time = if denominator == 1 {
            product
        } else {
            product / exactly::<T>(denominator)
        };
        let rounding = time.upper() * T::unit() * Magnitude::from(2.5);
        let floor = T::floor() * Magnitude::from(2.0);
        (
            time,
            if numerator == 0 {
                Magnitude::ZERO
            } else {
                rounding + floor
            },
        )
    }

    /// From one moment to another, and a bound of the error.
    pub(super) fn seconds<T: Real>(&self, from: Moment, to: Moment) -> (T, Magnitude) {
        if let (Moment::Units(from), Moment::Units(to)) = (from, to) {
            return self.part(to.saturating_sub(from), self.division);
        }
        let of = |moment| match moment {
            Moment::Units(units) => self.part::<T>(units, self.division),
            Moment::Part(Fraction {
                numerator,
                denominator,
            }) => self.part(numerator, denominator),
            Moment::Event(time) => (T::from(time), Magnitude::ZERO),
            Moment::Later(base, later) => {
                let (start, error) = match base {
                    Base::Steps(Fraction {
                        numerator,
                        denominator,
                    }) => self.part::<T>(numerator, denominator),
                    Base::Event(time) => (T::from(time), Magnitude::ZERO),
                };
                let time = start + T::from(later);
                (time, error + time.upper() * T::unit())
            }
        };
        let ((from, before), (to, after)) = (of(from), of(to));
        let time = to - from;
        (time, before + after + time.upper() * T::unit())
    }
}

/// A whole number, in two parts that are doubles.
fn exactly<T: Real>(whole: u64) -> T {
    T::from((whole >> 32) as f64).scale(32) + T::from((whole & 0xffff_ffff) as f64)
}

fn common_divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { common_divisor(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_digits::{DoubleDouble, Wide};

    /// Instants of 106 bits against those of 1024: k·step and parts of it are rounded, and that counts.
    #[test]
    fn instants_are_within_their_bounds() {
        let clock = Clock {
            step: 0.1,
            division: 3,
        };
        let part = |numerator, denominator| {
            Moment::Part(Fraction {
                numerator,
                denominator,
            })
        };
        let spans = [
            (Moment::Units(0), Moment::Units(1)),
            (Moment::Units(2), Moment::Units(1_000_000_000_003)),
            (part(1, 7), part(22, 7)),
            (part(5, 11), Moment::Event(0.3)),
            (Moment::Event(1e-20), Moment::Units(4)),
        ];
        let mut rounded = 0;
        for (from, to) in spans {
            let (exact, least) = clock.seconds::<Wide<16>>(from, to);
            let (coarse, bound) = clock.seconds::<DoubleDouble>(from, to);
            let off = (exact - Wide::from(coarse)).to_f64().abs();
            let bound = bound.to_f64();
            assert!(
                off <= bound + least.to_f64(),
                "{from:?} {to:?}: {off:e} {bound:e}"
            );
            assert!(
                bound <= 1e-30 * exact.to_f64(),
                "{from:?} {to:?}: {bound:e}"
            );
            rounded += usize::from(off > 0.0);
        }
        assert!(rounded >= 4, "these are to be rounded");
    }
}
