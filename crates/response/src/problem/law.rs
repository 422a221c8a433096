//! What one load does from an instant on.

use eigentone_digits::{Magnitude, Real};

use super::instant::{Fraction, Instant};
use super::straight_load::{StraightLoad, units};

/// What a load that runs straight does from an instant on, without rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Law {
    /// Which load, from 0; its next law ends this one.
    pub(crate) load: usize,
    pub(crate) coordinate: usize,
    pub(crate) since: Instant,
    pub(super) run: Run,
}

/// The force as a function of the time τ since the law set in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Run {
    Constant(f64),
    /// rate·(τ + lead).
    Growing {
        rate: f64,
        lead: f64,
    },
    /// from + (to − from)·τ/(steps·step).
    Towards {
        from: f64,
        to: f64,
        steps: Fraction,
        step: f64,
    },
}

impl Law {
    pub(crate) fn is_sloped(&self) -> bool {
        !matches!(self.run, Run::Constant(_))
    }

    /// Force and slope when the law sets in.
    pub(crate) fn start<T: Real>(&self) -> StraightLoad<T> {
        let known = |value: f64| (T::from(value), Magnitude::ZERO);
        match self.run {
            Run::Constant(force) => StraightLoad {
                value: known(force),
                slope: known(0.0),
            },
            Run::Growing { rate, lead } => {
                let start = T::from(rate) * T::from(lead);
                let error = match lead == 0.0 || rate == 0.0 {
                    true => Magnitude::ZERO,
                    false => start.upper() * T::unit() + T::floor(),
                };
                StraightLoad {
                    value: (start, error),
                    slope: known(rate),
                }
            }
            Run::Towards {
                from,
                to,
                steps,
                step,
            } => {
                let slope = (T::from(to) - T::from(from)) / (steps.value::<T>() * T::from(step));
                let error = slope.upper() * units::<T>() + T::floor();
                StraightLoad {
                    value: known(from),
                    slope: (slope, error),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::TimeGrid;
    use eigentone_digits::{DoubleDouble, Wide};

    /// Forces of 106 bits against those of 1024: what is rounded is within the errors stated, in units
    /// small and large.
    #[test]
    fn rounding_of_loads_is_counted() {
        let grid = TimeGrid::new(0.1, 1.0).expect("a grid");
        let time = DoubleDouble::from(1.0) / DoubleDouble::from(7.0);
        let mut rounded = 0;
        for unit in [1e-12, 1.0, 1e12] {
            for run in [
                Run::Growing {
                    rate: 0.3 * unit,
                    lead: 0.7,
                },
                Run::Towards {
                    from: 0.1 * unit,
                    to: 0.7 * unit,
                    steps: Fraction::of(1, 3),
                    step: 0.1,
                },
            ] {
                let law = Law {
                    load: 0,
                    coordinate: 0,
                    since: Instant::on_grid(&grid, 0),
                    run,
                };
                let coarse = law.start::<DoubleDouble>();
                let coarse = coarse.after((time, Magnitude::ZERO));
                let exact = law.start::<Wide<16>>();
                let exact = exact.after((Wide::from(time), Magnitude::ZERO));
                let (value, error) = coarse.value;
                let off = (exact.value.0 - Wide::from(value)).to_f64().abs();
                assert!(
                    off <= error.to_f64(),
                    "{run:?}: {off:e} {:e}",
                    error.to_f64()
                );
                assert!(error.to_f64() <= 1e-29 * exact.value.0.to_f64());
                rounded += usize::from(off > 0.0);
                let (slope, error) = coarse.slope;
                let off = (exact.slope.0 - Wide::from(slope)).to_f64().abs();
                assert!(
                    off <= error.to_f64(),
                    "{run:?}: {off:e} {:e}",
                    error.to_f64()
                );
            }
        }
        assert!(rounded >= 4, "these are to be rounded");
    }
}
