//! What springs and dampers carry while the system moves.

use eigentone_modes::{Element, Node, System};
use faer::{Mat, MatRef};

use crate::answer::Trajectory;
use crate::problem::ResponseError;

/// The force in every spring and damper at the instants of a trajectory, in N.
///
/// Between x_i and x_j, the first and the second end of the element, it is k·(x_j − x_i) in a spring
/// and c·(v_j − v_i) in a damper; the ground has x = v = 0. Tension is positive where the second end
/// lies ahead of the first: the element pulls its first end forward and its second end back. Each
/// force is rounded twice; an error of b in the displacements can make one of 2kb in the force, which
/// shows in stiff springs.
///
/// ```
/// use eigentone_modes::{GROUND, System};
/// use eigentone_response::{ElementForces, Response, Step};
///
/// let system = System::builder()
///     .mass("m", 1.0)
///     .spring(GROUND, "m", 4.0)
///     .damper(GROUND, "m", 4.0)
///     .build()?;
/// let trajectory = Response::of(&system)
///     .load("m", Step::of(3.0))
///     .every(0.5)
///     .until(50.0)
///     .run()?;
/// let forces = ElementForces::along(&system, &trajectory)?;
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
    /// The forces along a trajectory of `system`; those of added matrices are not elements.
    ///
    /// # Errors
    /// [`ResponseError::NotApplicable`] where the trajectory has another number of coordinates, or a force leaves the
    /// range of doubles.
    pub fn along(system: &System, trajectory: &Trajectory) -> Result<ElementForces, ResponseError> {
        let refuse = |reason: &str| ResponseError::NotApplicable {
            method: "element forces",
            reason: reason.to_owned(),
        };
        if trajectory.displacement().nrows() != system.len() {
            return Err(refuse("the trajectory is that of another system"));
        }
        let springs = forces(system.springs(), trajectory.displacement());
        let dampers = forces(system.dampers(), trajectory.velocity());
        match springs.is_all_finite() && dampers.is_all_finite() {
            true => Ok(ElementForces { springs, dampers }),
            false => Err(refuse("a force leaves the range of doubles")),
        }
    }

    /// Row i is the i-th of [`System::springs`], column j the j-th instant.
    pub fn springs(&self) -> MatRef<'_, f64> {
        self.springs.as_ref()
    }

    /// Row i is the i-th of [`System::dampers`], column j the j-th instant.
    pub fn dampers(&self) -> MatRef<'_, f64> {
        self.dampers.as_ref()
    }
}

/// coefficient·(second end − first end).
fn forces(elements: &[Element], motion: MatRef<'_, f64>) -> Mat<f64> {
    Mat::from_fn(elements.len(), motion.ncols(), |row, column| {
        let element = &elements[row];
        let at = |node: Node| node.coordinate().map_or(0.0, |i| motion[(i, column)]);
        element.coefficient * (at(element.second) - at(element.first))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_modes::GROUND;

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
        let x = Mat::from_fn(2, 2, |i, j| [[1.0, 0.0], [1.5, -1.0]][i][j]);
        let v = Mat::from_fn(2, 2, |i, j| [[0.0, 4.0], [2.0, 0.0]][i][j]);
        let trajectory = Trajectory::new("by hand", vec![0, 1], vec![0.0, 1.0], x, v);
        let forces = ElementForces::along(&system, &trajectory).expect("it fits");
        let springs = [[2.0, 0.0], [5.0, -10.0], [-4.5, 3.0]];
        assert_eq!(forces.springs(), Mat::from_fn(3, 2, |i, j| springs[i][j]));
        assert_eq!(forces.dampers(), Mat::from_fn(1, 2, |_, j| [-1.0, 2.0][j]));
        let one = System::builder().mass("a", 1.0).build().expect("a system");
        assert!(ElementForces::along(&one, &trajectory).is_err());
        let stiff = System::builder().mass("a", 1.0).mass("b", 1.0);
        let stiff = stiff
            .spring(GROUND, "b", 1.5e308)
            .build()
            .expect("a system");
        assert!(ElementForces::along(&stiff, &trajectory).is_err());
    }
}
