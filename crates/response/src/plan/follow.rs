//! The way to few outputs of a response.

use eigentone_modes::Precision;

use super::choice::ResponsePlan;
use crate::answer::{History, Output, ResponseMethod, Trajectory};
use crate::certified::ByCertifiedExponential;
use crate::march::Course;
use crate::problem::{Problem, ResponseError};

impl History {
    /// The outputs of the problem's answer.
    ///
    /// # Errors
    /// [`ResponseError::NoCoordinate`] for an index that the system does not have, and what the method
    /// reports.
    pub fn of(problem: &Problem<'_>, outputs: &[Output]) -> Result<History, ResponseError> {
        let coordinates = problem.system().len();
        let mut indices = outputs.iter().map(|output| output.coordinate());
        if let Some(index) = indices.find(|index| *index >= coordinates) {
            return Err(ResponseError::NoCoordinate { index, coordinates });
        }
        let proven = matches!(problem.precision(), Precision::Certified { .. })
            && ByCertifiedExponential.refuses(problem).is_none();
        if !proven
            && let Some(course) = Course::of(problem, outputs)
            && let Some(strides) = course.strides()
        {
            return course.run(strides);
        }
        let plan = ResponsePlan::of(problem)?;
        let trajectory = plan.run(problem)?;
        Ok(History::picked(problem, outputs, &trajectory))
    }

    fn picked(problem: &Problem<'_>, outputs: &[Output], trajectory: &Trajectory) -> History {
        let (x, v) = (trajectory.displacement(), trajectory.velocity());
        let instants = 0..trajectory.len();
        let values = instants.flat_map(|j| {
            outputs.iter().map(move |output| match output {
                Output::Displacement(i) => x[(*i, j)],
                Output::Velocity(i) => v[(*i, j)],
            })
        });
        let bounds = trajectory.displacement_bound().iter();
        let bounds = bounds.zip(trajectory.velocity_bound());
        History {
            outputs: outputs.to_vec(),
            grid: *problem.grid(),
            steps: problem.instants().map(<[u64]>::to_vec),
            values: values.collect(),
            estimates: bounds.map(|(x, v)| [*x, *v]).collect(),
            every: 1,
            bounds: trajectory.bounds(),
            operations: trajectory.operations(),
            method: trajectory.method(),
        }
    }
}
