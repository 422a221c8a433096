//! How far one motion lies from another.

use eigentone_response::Trajectory;
use faer::MatRef;

/// How far a trajectory lies from a reference: the largest difference at any instant and coordinate,
/// relative to the peak of the reference, which is its largest value at any instant and coordinate. Where the
/// reference does not move at all, any difference is infinite.
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
        // The same indices of another grid are other instants.
        assert_eq!(trajectory.times(), reference.times(), "the same instants");
        TrajectoryError {
            displacement: distance(trajectory.displacement(), reference.displacement()),
            velocity: distance(trajectory.velocity(), reference.velocity()),
        }
    }
}

fn distance(values: MatRef<'_, f64>, reference: MatRef<'_, f64>) -> f64 {
    assert_eq!(values.nrows(), reference.nrows(), "the same coordinates");
    let places = (0..reference.ncols()).flat_map(|k| (0..reference.nrows()).map(move |i| (i, k)));
    relative(places.map(|place| {
        let truth = reference[place];
        ((values[place] - truth).abs(), truth.abs())
    }))
}

/// The largest of some errors relative to the largest of the sizes beside them; infinite where one is
/// NaN, and where all sizes are 0 and an error is not.
pub(crate) fn relative(errors_and_sizes: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (off, peak) = errors_and_sizes.fold((0.0, 0.0), |(off, peak), (error, size)| {
        (greater(off, error), greater(peak, size))
    });
    match off {
        0.0 => 0.0,
        off if off.is_finite() && peak > 0.0 => off / peak,
        _ => f64::INFINITY,
    }
}

/// The larger one; infinite if one is NaN.
pub(crate) fn greater(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() {
        f64::INFINITY
    } else {
        a.max(b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    #[test]
    #[should_panic(expected = "the same instants")]
    fn motions_of_other_grids_are_not_compared() {
        let still = |step: f64| {
            let rest = || Mat::zeros(1, 2);
            Trajectory::new("rest", vec![0, 1], vec![0.0, step], rest(), rest())
        };
        TrajectoryError::between(&still(0.1), &still(0.2));
    }
}
