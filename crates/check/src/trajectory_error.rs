//! How far one motion lies from another.

use eigentone_response::Trajectory;
use faer::MatRef;

/// How far a trajectory lies from a reference: at each instant, the largest difference over the
/// coordinates, relative to the largest value of any coordinate of the reference up to then; over
/// the instants, the largest of these. Instants before the reference moves at all are counted with
/// the first at which it does; if it never does, any difference is infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrajectoryError {
    /// Of the displacements.
    pub displacement: f64,
    /// Of the velocities.
    pub velocity: f64,
}

impl TrajectoryError {
    /// The larger of the two.
    pub fn worst(&self) -> f64 {
        self.displacement.max(self.velocity)
    }

    /// The distance of `trajectory` from `reference`, which must be of the same problem.
    ///
    /// # Panics
    /// If the two differ in coordinates or instants.
    pub fn between(trajectory: &Trajectory, reference: &Trajectory) -> TrajectoryError {
        assert_eq!(trajectory.steps(), reference.steps(), "the same instants");
        // The running maximum follows time, not the order in which instants were asked for.
        let mut order: Vec<usize> = (0..reference.len()).collect();
        order.sort_by_key(|column| reference.steps()[*column]);
        TrajectoryError {
            displacement: distance(trajectory.displacement(), reference.displacement(), &order),
            velocity: distance(trajectory.velocity(), reference.velocity(), &order),
        }
    }
}

fn distance(values: MatRef<'_, f64>, reference: MatRef<'_, f64>, order: &[usize]) -> f64 {
    assert_eq!(values.nrows(), reference.nrows(), "the same coordinates");
    let (mut largest, mut worst, mut at_rest) = (0.0f64, 0.0f64, 0.0f64);
    for &column in order {
        let mut off = at_rest;
        for i in 0..reference.nrows() {
            let (value, truth) = (values[(i, column)], reference[(i, column)]);
            largest = largest.max(truth.abs());
            let difference = (value - truth).abs();
            off = match difference.is_nan() {
                true => f64::INFINITY,
                false => off.max(difference),
            };
        }
        if largest > 0.0 {
            worst = worst.max(off / largest);
            at_rest = 0.0;
        } else {
            at_rest = off;
        }
    }
    if at_rest > 0.0 { f64::INFINITY } else { worst }
}
