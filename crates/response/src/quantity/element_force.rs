//! What springs and dampers carry while the system moves.

use eigentone_modes::ElementKind;
use faer::{Mat, MatRef};

use crate::answer::Trajectory;
use crate::problem::{Instant, Problem, ResponseError};

/// The force in every spring and damper at the instants of a trajectory, in N.
///
/// Between x_i and x_j, the first and the second end of the element, it is k·(x_j − x_i) in a spring
/// and c·(v_j − v_i) in a damper; the ground has x = v = 0, and the ends may be points and moving supports. Tension is positive where the second end
/// lies ahead of the first: the element pulls its first end forward and its second end back. Each
/// force is rounded twice; an error of b in the displacements can make one of 2kb in the force, which
/// shows in stiff springs.
///
/// ```
/// use eigentone_modes::{GROUND, System};
/// use eigentone_response::{ElementForces, Response, ResponsePlan, Step};
///
/// let system = System::builder()
///     .mass("m", 1.0)
///     .spring(GROUND, "m", 4.0)
///     .damper(GROUND, "m", 4.0)
///     .build()?;
/// let problem = Response::of(&system)
///     .load("m", Step::of(3.0))
///     .every(0.5)
///     .until(50.0)
///     .problem()?;
/// let trajectory = ResponsePlan::of(&problem)?.run(&problem)?;
/// let forces = ElementForces::along(&problem, &trajectory)?;
/// // At rest the spring alone carries the load.
/// assert!((forces.springs()[(0, 100)] - 3.0).abs() < 1e-14);
/// assert!(forces.dampers()[(0, 100)].abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ElementForces {
    springs: Mat<f64>,
    dampers: Mat<f64>,
}

impl ElementForces {
    /// The forces along a trajectory of `problem`; those of added matrices, and of damping that is given as a whole, are no
    /// elements.
    ///
    /// # Errors
    /// [`ResponseError::NotApplicable`] where the trajectory has another number of coordinates, or a force leaves the
    /// range of doubles.
    pub fn along(
        problem: &Problem<'_>,
        trajectory: &Trajectory,
    ) -> Result<ElementForces, ResponseError> {
        let refuse = |reason: &str| ResponseError::NotApplicable {
            method: "element forces",
            reason: reason.to_owned(),
        };
        if trajectory.displacement().nrows() != problem.system().len() {
            return Err(refuse("the trajectory is that of another system"));
        }
        let supports = supports(problem, trajectory);
        let forces = |kind: ElementKind, motion: MatRef<'_, f64>| {
            let elements = problem.system().elements(kind);
            Mat::from_fn(elements.len(), motion.ncols(), |row, column| {
                let stretch = &elements[row].stretch;
                let held = stretch.supports.iter();
                let held = held.map(|&(s, factor)| factor * supports[column][s][kind as usize]);
                let moved = stretch.coordinates.iter();
                let moved = moved.map(|&(i, factor)| factor * motion[(i, column)]);
                elements[row].coefficient * moved.chain(held).sum::<f64>()
            })
        };
        let springs = forces(ElementKind::Spring, trajectory.displacement());
        let dampers = forces(ElementKind::Damper, trajectory.velocity());
        match springs.is_all_finite() && dampers.is_all_finite() {
            true => Ok(ElementForces { springs, dampers }),
            false => Err(refuse("a force leaves the range of doubles")),
        }
    }

    /// Row i is the i-th spring of [`System::elements`](eigentone_modes::System::elements), column j the j-th instant.
    pub fn springs(&self) -> MatRef<'_, f64> {
        self.springs.as_ref()
    }

    /// Row i is the i-th damper of [`System::elements`](eigentone_modes::System::elements), column j the j-th instant.
    pub fn dampers(&self) -> MatRef<'_, f64> {
        self.dampers.as_ref()
    }
}

/// Displacement, velocity and acceleration of each support at each instant.
fn supports(problem: &Problem<'_>, trajectory: &Trajectory) -> Vec<Vec<[f64; 3]>> {
    let count = problem.system().supports().len();
    if count == 0 || problem.channels().is_empty() {
        return vec![vec![[0.0; 3]; count]; trajectory.len()];
    }
    let (grid, pieces) = (problem.grid(), problem.timeline().pieces());
    let at = |k: usize| {
        let time = trajectory.times()[k];
        let step = trajectory.steps().get(k);
        let instant = step.map_or_else(
            || Instant::event(grid, time),
            |step| Instant::on_grid(grid, *step),
        );
        let begun = pieces.partition_point(|piece| piece.start_instant().order(&instant).is_le());
        problem.supports(begun.saturating_sub(1), time)
    };
    (0..trajectory.len()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Quantity, Ramp, Response};
    use eigentone_modes::{GROUND, System};

    #[test]
    fn tension_is_positive() {
        let system = System::builder()
            .mass("a", 1.0)
            .mass("b", 1.0)
            .spring(GROUND, "a", 2.0)
            .spring("a", "b", 10.0)
            .spring("b", GROUND, 3.0)
            .damper("b", "a", 0.5)
            .build()
            .expect("a system");
        let asked = |system| {
            let problem = Response::of(system).every(1.0).until(1.0).problem();
            problem.expect("a problem")
        };
        let x = Mat::from_fn(2, 2, |i, j| [[1.0, 0.0], [1.5, -1.0]][i][j]);
        let v = Mat::from_fn(2, 2, |i, j| [[0.0, 4.0], [2.0, 0.0]][i][j]);
        let trajectory = Trajectory::new("by hand", vec![0, 1], vec![0.0, 1.0], x, v);
        let forces = ElementForces::along(&asked(&system), &trajectory).expect("it fits");
        let springs = [[2.0, 0.0], [5.0, -10.0], [-4.5, 3.0]];
        assert_eq!(forces.springs(), Mat::from_fn(3, 2, |i, j| springs[i][j]));
        assert_eq!(forces.dampers(), Mat::from_fn(1, 2, |_, j| [-1.0, 2.0][j]));
        let one = System::builder().mass("a", 1.0).build().expect("a system");
        assert!(ElementForces::along(&asked(&one), &trajectory).is_err());
        let stiff = System::builder().mass("a", 1.0).mass("b", 1.0);
        let stiff = stiff
            .spring(GROUND, "b", 1.5e308)
            .build()
            .expect("a system");
        assert!(ElementForces::along(&asked(&stiff), &trajectory).is_err());
    }

    /// What a moving support, and a point, make of a stretch.
    #[test]
    fn supports_and_points_stretch_elements() {
        let system = System::builder()
            .mass("a", 1.0)
            .support("s")
            .point("p", [("a", 2.0)], 0.0)
            .spring("s", "p", 10.0)
            .damper("s", "a", 3.0)
            .build()
            .expect("a system");
        let road = Ramp::of(0.5).starting_at(1.0);
        let asked = Response::of(&system).motion("s", Quantity::Displacement, road);
        let problem = asked.every(1.0).until(3.0).problem().expect("a problem");
        let zero = Mat::zeros(1, 3);
        let times = vec![0.0, 1.0, 3.0];
        let still = Trajectory::new("by hand", vec![0, 1, 3], times, zero.clone(), zero);
        let forces = ElementForces::along(&problem, &still).expect("it fits");
        assert_eq!(
            forces.springs(),
            Mat::from_fn(1, 3, |_, j| [0.0, 0.0, -10.0][j])
        );
        assert_eq!(
            forces.dampers(),
            Mat::from_fn(1, 3, |_, j| [0.0, -1.5, -1.5][j])
        );
    }
}
