//! Whether an instant is as good as asked for.

use eigentone_digits::Magnitude;

use crate::grid::TimeGrid;

/// Where digits end, relative to the largest motion so far.
const LIMIT: f64 = 1e-30;

/// Where they end while there has been no motion of a kind: relative to what the other kind makes of
/// it, over all the time for velocities, within a step for displacements.
const STILL: f64 = 1e-60;

/// Compares errors with what is asked of displacements and velocities.
#[derive(Clone, Debug)]
pub(crate) struct Judge {
    /// What is left of the tolerance when the result has been rounded to a double.
    relative: f64,
    /// The largest displacement and the largest velocity so far.
    largest: [f64; 2],
    /// Seconds to a displacement's velocity, and to a velocity's displacement.
    times: [f64; 2],
}

impl Judge {
    /// For a tolerance relative to the largest coordinate of each instant of a grid.
    pub(crate) fn new(tolerance: f64, grid: &TimeGrid) -> Judge {
        const UNIT: f64 = f64::EPSILON / 2.0;
        Judge {
            relative: (tolerance - UNIT).max(UNIT / 1024.0),
            largest: [0.0; 2],
            times: [grid.time(grid.last().max(1)), grid.step()],
        }
    }

    /// Whether an instant is good enough: of its displacements and of its velocities, the largest one
    /// and the error before it is rounded.
    pub(crate) fn judge(&mut self, motion: [(f64, Magnitude); 2]) -> bool {
        for (largest, (size, _)) in self.largest.iter_mut().zip(motion) {
            *largest = largest.max(size);
        }
        let [displacement, velocity] = self.largest.map(Magnitude::from);
        let [end, step] = self.times.map(Magnitude::from);
        let still = [velocity * step, displacement / end];
        let good = |kind: usize| {
            let (size, error) = motion[kind];
            let allowed = if self.largest[kind] == 0.0 {
                Magnitude::from(STILL) * still[kind]
            } else {
                Magnitude::from((self.relative * size).max(LIMIT * self.largest[kind]))
            };
            error.is_zero() || error <= allowed
        };
        good(0) && good(1)
    }
}
