//! A first-order estimate of how far a response computed in doubles is off.

use eigentone_modes::{FirstOrder, System, balance};
use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;

use crate::problem::TimeGrid;

/// What going to coordinates of a method's own and back makes of rounding errors on the way.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Detour {
    /// What they leave of displacements and of velocities, as displacements and then as velocities: what comes of one in
    /// the coordinates need not be small where it cancels.
    pub(crate) leaves: [[f64; 2]; 2],
}

/// Counts the rounding errors met so far.
///
/// In a passive system that is held in place the energy of an error does not grow, so that errors
/// add up at most linearly: a few units of rounding for each step and state, and for the rounding of
/// A itself, which acts like a force for as long as the motion lasts, one unit for each radian that
/// the fastest motion turns, times the condition of A. What undamped massless nodes do at once errs by the condition of
/// the springs on them. A [`Detour`] by way of modes enlarges what is rounded on it, but not what the rounding of A makes of
/// the motion. For other systems no estimate is given.
#[derive(Clone, Debug)]
pub(crate) struct Estimate {
    applies: bool,
    /// The largest rate in 1/s: the norm of the balanced state matrix.
    rate: f64,
    /// The condition of the balanced state matrix.
    condition: f64,
    states: f64,
    /// The condition of the springs on undamped massless nodes, times the number of nodes; 0 without any.
    at_once: f64,
    detour: Detour,
    steps: f64,
    elapsed: f64,
    displacement: f64,
    velocity: f64,
}

impl Estimate {
    pub(crate) fn of(system: &System, form: &FirstOrder) -> Estimate {
        let structure = system.structure();
        let balanced = balance(form.a());
        let norm = |matrix: &Mat<f64>| {
            let columns = (0..matrix.ncols()).map(|j| matrix.col(j).norm_l1());
            columns.fold(0.0, f64::max)
        };
        let rate = norm(&balanced.matrix);
        let applies = structure.is_passive() && structure.zero_roots() == Some(0);
        let condition = if applies {
            rate * norm(&balanced.matrix.partial_piv_lu().inverse())
        } else {
            f64::INFINITY
        };
        let massless: Vec<usize> = (0..system.len())
            .filter(|i| !form.massive().contains(i))
            .collect();
        let at_once = form.d().map_or(0.0, |d| {
            let k = system.stiffness_matrix();
            let count = massless.len();
            let springs = Mat::from_fn(count, count, |i, j| k[(massless[i], massless[j])]);
            norm(&springs) * norm(&d.to_owned()) * count as f64
        });
        Estimate {
            applies,
            rate,
            condition,
            states: form.states() as f64,
            at_once,
            detour: Detour::default(),
            steps: 0.0,
            elapsed: 0.0,
            displacement: 0.0,
            velocity: 0.0,
        }
    }

    /// The same for a method that goes by way of other coordinates.
    pub(crate) fn by_way_of(self, detour: Detour) -> Estimate {
        Estimate { detour, ..self }
    }

    /// What the rounding of A alone makes of the motion over `elapsed` seconds, relative to its
    /// size; `None` where no estimate is given.
    pub(crate) fn of_rounding(&self, elapsed: f64) -> Option<f64> {
        let units = 4.0 * self.rate * elapsed * self.condition;
        self.applies.then_some(units * f64::EPSILON)
    }

    /// Notes a step of `h` seconds.
    pub(crate) fn step(&mut self, h: f64) {
        self.steps += 1.0;
        self.elapsed += h;
    }

    /// Notes `count` steps of `h` seconds each.
    pub(crate) fn steps(&mut self, count: u64, h: f64) {
        self.steps += count as f64;
        self.elapsed += count as f64 * h;
    }

    /// Bounds for the largest displacement, velocity and acceleration of the instant reached.
    pub(crate) fn bounds(&mut self, displacement: f64, velocity: f64) -> [Option<f64>; 3] {
        self.displacement = self.displacement.max(displacement);
        self.velocity = self.velocity.max(velocity);
        if !self.applies {
            return [None; 3];
        }
        let roundings = 8.0 * (self.steps + 1.0);
        let units = roundings * self.states
            + 8.0 * self.at_once
            + 4.0 * self.rate * self.elapsed * self.condition;
        let factor = units * f64::EPSILON;
        let detour = self.detour.leaves.map(|[of_displacement, of_velocity]| {
            let left = of_displacement * self.displacement + of_velocity * self.velocity;
            roundings * f64::EPSILON * left
        });
        let displacement = factor * self.displacement + detour[0];
        let velocity = factor * (self.velocity + self.rate * self.displacement) + detour[1];
        // Beyond the size of the motion, a first-order estimate says nothing.
        let telling = |bound: f64| (factor < 1.0 && bound.is_finite()).then_some(bound);
        // A row of A² is no larger than a row of A times the rate.
        let acceleration = self.rate * (velocity + self.rate * displacement);
        [displacement, velocity, acceleration].map(telling)
    }
}

/// Whether rounding the assembled state matrix is estimated to spoil the motion visibly.
pub(crate) fn is_stiff(estimate: &Estimate, grid: &TimeGrid) -> bool {
    const VISIBLE: f64 = 1e-9;
    estimate
        .of_rounding(grid.time(grid.last()))
        .is_some_and(|error| error > VISIBLE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_modes::GROUND;

    /// Each step may be off by a unit, and errors add up.
    #[test]
    fn many_steps_count_like_as_many_single_ones() {
        const STEPS: u32 = 1000;
        let system = System::builder()
            .mass("m", 1.0)
            .spring(GROUND, "m", 1.0)
            .build()
            .expect("a system");
        let form = FirstOrder::of(&system).expect("a mass");
        let mut together = Estimate::of(&system, &form);
        let mut each = together.clone();
        // So short that the rounding of A does not count.
        let h = 2f64.powi(-40);
        together.steps(u64::from(STEPS), h);
        (0..STEPS).for_each(|_| each.step(h));
        let [first, second] = [&mut together, &mut each].map(|e| e.bounds(3.0, 2.0));
        assert_eq!(first, second);
        let (displacement, velocity) = (first[0].expect("a bound"), first[1].expect("a bound"));
        let units = f64::from(STEPS) * f64::EPSILON;
        assert!(displacement >= 3.0 * units && velocity >= 2.0 * units);
        // k off by half a unit turns it by a quarter of one for each second.
        each.step(1e6);
        let turned = 1e6 * f64::EPSILON / 4.0;
        assert!(each.bounds(3.0, 3.0)[0].expect("a bound") >= 3.0 * turned);
    }
}
