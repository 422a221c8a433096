//! A first-order estimate of how far a response computed in doubles is off.

use eigentone_digits::{Lu, product};
use eigentone_modes::{Balanced, FirstOrder, MatrixKind, System, balance};
use faer::{Mat, MatRef};

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
/// the fastest motion turns, times the condition of A; where terms of A cancel, their size counts in place of the fastest
/// motion. Massless nodes are eliminated in double-double, and err by the condition of the springs on them in units of
/// that. Loads of which parts cancel err in units of the parts. Modes come from the elements, so that nothing cancels in
/// them; a [`Detour`] by way of them enlarges what is rounded on it, but not what the rounding of A makes of the motion. For
/// other systems no estimate is given.
#[derive(Clone, Debug)]
pub(crate) struct Estimate {
    applies: bool,
    /// The largest rate in 1/s: the norm of the balanced state matrix.
    rate: f64,
    /// The same for the sizes of the terms that the state matrix is the sum of: more where they cancel.
    assembled: f64,
    /// The condition of the balanced state matrix.
    condition: f64,
    states: f64,
    /// The units of rounding that the elimination of massless nodes makes, the sums that give back their motion, and the
    /// division by masses that are not lumped; 0 without any.
    at_once: f64,
    /// Of a method that goes by way of modes.
    pub(super) detour: Option<Detour>,
    steps: f64,
    elapsed: f64,
    displacement: f64,
    velocity: f64,
    acceleration: f64,
}

impl Estimate {
    pub(crate) fn of(system: &System, form: &FirstOrder) -> Estimate {
        let structure = system.structure();
        let balanced = balance(form.a());
        let rate = norm(&balanced.matrix);
        let applies = structure.is_passive() && structure.zero_roots() == Some(0);
        let condition = if applies {
            rate * norm(&Lu::of(balanced.matrix.as_ref()).inverse())
        } else {
            f64::INFINITY
        };
        let massless: Vec<usize> = (0..system.len())
            .filter(|i| !form.massive().contains(i))
            .collect();
        let count = massless.len();
        let at_once = form.d().map_or(0.0, |d| {
            let k = system.stiffness_matrix();
            let springs = Mat::from_fn(count, count, |i, j| k[(massless[i], massless[j])]);
            norm(&springs) * norm(&d.to_owned()) * count as f64
        });
        let [mass, damping, stiffness] =
            [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness]
                .map(|kind| sizes_of_terms(system, kind));
        let inverse = norm(&product(size(form.b()).as_ref(), mass.as_ref()));
        let follows = norm(&form.x().transpose().to_owned()).max(1.0) * count as f64;
        let assembled = uncancelled(form, &balanced, &[mass, damping, stiffness]);
        // Nodes are eliminated in double-double.
        let unit = if count > 0 { f64::EPSILON } else { 1.0 };
        Estimate {
            applies,
            rate,
            assembled: rate.max(norm(&assembled) * unit),
            condition,
            states: form.states() as f64,
            at_once: at_once * unit + follows + (inverse - 1.0).max(0.0),
            detour: None,
            steps: 0.0,
            elapsed: 0.0,
            displacement: 0.0,
            velocity: 0.0,
            acceleration: 0.0,
        }
    }

    /// What the rounding of A alone makes of the motion over `elapsed` seconds, relative to its
    /// size; `None` where no estimate is given.
    pub(crate) fn of_rounding(&self, elapsed: f64) -> Option<f64> {
        self.applies.then_some(self.turned(elapsed) * f64::EPSILON)
    }

    /// The units of rounding that the rounding of A makes of the motion over `elapsed` seconds.
    fn turned(&self, elapsed: f64) -> f64 {
        let rate = match self.detour {
            Some(_) => self.rate,
            None => self.assembled,
        };
        4.0 * rate * elapsed * self.condition
    }

    /// The period of the slowest motion, over 2π, in s.
    fn slowest(&self) -> f64 {
        self.condition / self.rate
    }

    /// Notes a step of `h` seconds under loads whose parts cancel, each of which by itself would displace by `at_once[0]` and
    /// move by `at_once[1]` and accelerate by `at_once[2]`.
    pub(crate) fn cancel(&mut self, at_once: [f64; 3], h: f64) {
        let [displacement, velocity, acceleration] = at_once;
        let h = h.min(self.slowest());
        let velocity = velocity + h * acceleration;
        self.displacement = self.displacement.max(displacement + h * velocity);
        self.velocity = self.velocity.max(velocity);
    }

    /// Notes a sinusoidal load of `frequency` rad/s that by itself would displace by `at_once[0]` and move by `at_once[1]`
    /// and accelerate by `at_once[2]`. One that is much faster than the system leaves little of its displacements, but
    /// the velocities that it makes are rounded in each step, and each of these errors moves the system as an impulse would.
    pub(crate) fn swing(&mut self, at_once: [f64; 3], frequency: f64) {
        let [displacement, velocity, acceleration] = at_once;
        let frequency = frequency.abs();
        if frequency > 2.0 * self.rate {
            let velocity = velocity + acceleration / frequency;
            self.displacement = self
                .displacement
                .max(displacement + self.slowest() * velocity);
            self.velocity = self.velocity.max(velocity);
        }
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

    /// Bounds for displacements, velocities and accelerations of an instant at which these are the largest ones, or the sums
    /// of the sizes of what is added up to them.
    pub(crate) fn bounds(&mut self, reached: [f64; 3]) -> [Option<f64>; 3] {
        let [displacement, velocity, acceleration] = reached;
        self.displacement = self.displacement.max(displacement);
        self.velocity = self.velocity.max(velocity);
        self.acceleration = self.acceleration.max(acceleration);
        if !self.applies {
            return [None; 3];
        }
        let roundings = 8.0 * (self.steps + 1.0);
        let units = roundings * self.states + 8.0 * self.at_once + self.turned(self.elapsed);
        let factor = units * f64::EPSILON;
        let detour = self.detour.unwrap_or_default();
        let detour = detour.leaves.map(|[of_displacement, of_velocity]| {
            let left = of_displacement * self.displacement + of_velocity * self.velocity;
            roundings * f64::EPSILON * left
        });
        let displacement = factor * self.displacement + detour[0];
        let velocity = factor * (self.velocity + self.rate * self.displacement) + detour[1];
        // Beyond the size of the motion, a first-order estimate says nothing.
        let usable = |bound: f64| (factor < 1.0 && bound.is_finite()).then_some(bound);
        // A row of A² is no larger than a row of A times the rate; what cancels in A does so in it.
        let rounded = 8.0 * (self.states + self.at_once) * self.acceleration
            + 4.0 * self.assembled * (self.velocity + self.rate * self.displacement);
        let acceleration =
            self.rate * (velocity + self.rate * displacement) + f64::EPSILON * rounded;
        [displacement, velocity, acceleration].map(usable)
    }
}

/// The largest sum of sizes in a column; infinite where an entry is no number, as in the inverse of what is singular in doubles.
fn norm(matrix: &Mat<f64>) -> f64 {
    let columns = (0..matrix.ncols()).map(|j| matrix.col(j).norm_l1());
    columns.fold(0.0, |top: f64, sum| match sum.is_nan() {
        true => f64::INFINITY,
        false => top.max(sum),
    })
}

/// The sizes of all entries.
pub(super) fn size(matrix: MatRef<'_, f64>) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)].abs())
}

/// The sums of the sizes of the terms of a matrix.
fn sizes_of_terms(system: &System, kind: MatrixKind) -> Mat<f64> {
    let mut sum = Mat::<f64>::zeros(system.len(), system.len());
    let terms = system.terms(kind);
    terms.for_each(|term| sum[(term.row, term.column)] += term.value.abs());
    sum
}

/// What the entries of A would be if nothing cancelled where M, C and K are assembled and massless nodes are eliminated, in
/// the coordinates of the balanced A, given the sums of the sizes of their terms. For small changes, A changes as
/// z′ = A z + B f does by forces that act in place of changed matrices: δA = −B (δM X A² + δC X A + δK X), and each matrix is
/// off by units of what it is the sum of.
fn uncancelled(form: &FirstOrder, balanced: &Balanced, sizes: &[Mat<f64>; 3]) -> Mat<f64> {
    let (a, x) = (form.a(), form.x());
    let v = product(x, a);
    let accelerations = product(v.as_ref(), a);
    let [mass, damping, stiffness] = sizes;
    let b = size(form.b());
    let times = |a: &Mat<f64>, b: Mat<f64>| product(a.as_ref(), b.as_ref());
    let elastic = times(stiffness, size(x)) + times(damping, size(v.as_ref()));
    let elastic = times(&b, elastic);
    let inertial = times(&b, times(mass, size(accelerations.as_ref())));
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| {
        let size = a[(i, j)].abs().max(elastic[(i, j)]).max(inertial[(i, j)]);
        size * balanced.scale[j] / balanced.scale[i]
    })
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
        let [first, second] = [&mut together, &mut each].map(|e| e.bounds([3.0, 2.0, 0.0]));
        assert_eq!(first, second);
        let (displacement, velocity) = (first[0].expect("a bound"), first[1].expect("a bound"));
        let units = f64::from(STEPS) * f64::EPSILON;
        assert!(displacement >= 3.0 * units && velocity >= 2.0 * units);
        // k off by half a unit turns it by a quarter of one for each second.
        each.step(1e6);
        let turned = 1e6 * f64::EPSILON / 4.0;
        assert!(each.bounds([3.0, 3.0, 0.0])[0].expect("a bound") >= 3.0 * turned);
    }
}
