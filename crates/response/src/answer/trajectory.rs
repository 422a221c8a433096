//! The answer: displacement and velocity at the instants asked for.

use eigentone_modes::{Bounds, ElementKind, Names, NoCoordinate};
use faer::{Mat, MatRef, RowRef};

use super::combined::Combined;
use super::operations::Operations;

/// The motion at the instants asked for.
///
/// ```
/// use eigentone_modes::{Bounds, GROUND, System};
/// use eigentone_response::{Response, State};
///
/// let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 1.0).build()?;
/// let asked = Response::of(&system).from(State::at_rest().push("m", 1.0));
/// let answer = asked.every(0.25).until(1.0).with_acceleration().run()?;
/// assert_eq!(answer.times(), [0.0, 0.25, 0.5, 0.75, 1.0]);
/// // Rows are coordinates, columns are instants.
/// assert_eq!(answer.displacement().nrows(), 1);
/// assert!((answer.displacement()[(0, 4)] - 1f64.sin()).abs() < 2e-16);
/// assert!((answer.velocity()[(0, 4)] - 1f64.cos()).abs() < 2e-16);
/// assert_eq!(answer.velocity_of("m")?, answer.velocity().row(0));
/// assert_eq!(answer.bounds(), Bounds::Proven);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    names: Names,
    steps: Vec<u64>,
    times: Vec<f64>,
    displacement: Mat<f64>,
    velocity: Mat<f64>,
    acceleration: Option<Mat<f64>>,
    displacement_bound: Vec<Option<f64>>,
    velocity_bound: Vec<Option<f64>>,
    /// Empty where accelerations were not asked for.
    acceleration_bound: Vec<Option<f64>>,
    /// By name.
    combined: Vec<(String, Combined)>,
    /// Of springs and of dampers, where they were asked for.
    forces: Option<[Vec<Combined>; 2]>,
    bounds: Bounds,
    digits: usize,
    operations: Operations,
    method: &'static str,
}

impl Trajectory {
    /// An answer from its parts: step indices, their instants in s, and n × N matrices with one
    /// column for each instant. Instants off the grid have no step index: then there are none at all.
    /// Bounds are absent until [`with_bounds`](Self::with_bounds), names until [`with_names`](Self::with_names).
    ///
    /// # Panics
    /// If the number of columns, or of step indices other than 0, is not the number of instants.
    pub fn new(
        method: &'static str,
        steps: Vec<u64>,
        times: Vec<f64>,
        displacement: Mat<f64>,
        velocity: Mat<f64>,
    ) -> Trajectory {
        let count = times.len();
        assert!(steps.is_empty() || steps.len() == count);
        assert!(displacement.ncols() == count && velocity.ncols() == count);
        Trajectory {
            names: Names::default(),
            steps,
            times,
            displacement,
            velocity,
            acceleration: None,
            displacement_bound: vec![None; count],
            velocity_bound: vec![None; count],
            acceleration_bound: Vec::new(),
            combined: Vec::new(),
            forces: None,
            bounds: Bounds::Estimated,
            digits: 16,
            operations: Operations::default(),
            method,
        }
    }

    /// The same with the names of its coordinates, which are those of the system that moves.
    ///
    /// # Panics
    /// If there are not as many as coordinates.
    pub fn with_names(self, names: &Names) -> Trajectory {
        assert_eq!(names.len(), self.displacement.nrows());
        Trajectory {
            names: names.clone(),
            ..self
        }
    }

    /// The same with accelerations (n × N).
    pub fn with_acceleration(self, acceleration: Mat<f64>) -> Trajectory {
        Trajectory {
            acceleration: Some(acceleration),
            acceleration_bound: vec![None; self.times.len()],
            ..self
        }
    }

    /// The same with bounds of the accelerations, one for each instant.
    pub fn with_acceleration_bound(self, acceleration: Vec<Option<f64>>) -> Trajectory {
        Trajectory {
            acceleration_bound: acceleration,
            ..self
        }
    }

    /// The same with the forces in so many springs, and in dampers after them: of each the values at the instants, and their
    /// bounds.
    ///
    /// # Panics
    /// If there are fewer forces than springs.
    pub fn with_forces(
        self,
        springs: usize,
        forces: impl IntoIterator<Item = (Vec<f64>, Vec<Option<f64>>)>,
    ) -> Trajectory {
        let forces = forces.into_iter();
        let mut forces: Vec<Combined> = forces
            .map(|(values, bounds)| Combined { values, bounds })
            .collect();
        let dampers = forces.split_off(springs);
        Trajectory {
            forces: Some([forces, dampers]),
            ..self
        }
    }

    /// What a spring or damper carries at the instants, in N, by its place in
    /// [`System::elements`](eigentone_modes::System::elements): its coefficient times the stretch x_b − x_a, or the rate of
    /// it. `None` where forces [were not asked for](crate::Response::with_forces), or there is no such element.
    pub fn force(&self, kind: ElementKind, index: usize) -> Option<&[f64]> {
        self.carried(kind, index).map(|force| &force.values[..])
    }

    /// How far each of its values may be off, as [`output_bound`](Self::output_bound) says it of combinations.
    pub fn force_bound(&self, kind: ElementKind, index: usize) -> Option<&[Option<f64>]> {
        self.carried(kind, index).map(|force| &force.bounds[..])
    }

    fn carried(&self, kind: ElementKind, index: usize) -> Option<&Combined> {
        self.forces.as_ref()?[usize::from(kind == ElementKind::Damper)].get(index)
    }

    /// The same with estimated bounds, one for each instant, over all coordinates.
    pub fn with_bounds(self, displacement: Vec<Option<f64>>, velocity: Vec<Option<f64>>) -> Self {
        Trajectory {
            displacement_bound: displacement,
            velocity_bound: velocity,
            ..self
        }
    }

    /// The same with named combinations of motions: of each the values at the instants, and their bounds.
    pub fn with_outputs<N: Into<String>>(
        self,
        outputs: impl IntoIterator<Item = (N, Vec<f64>, Vec<Option<f64>>)>,
    ) -> Trajectory {
        let outputs = outputs.into_iter();
        let outputs =
            outputs.map(|(name, values, bounds)| (name.into(), Combined { values, bounds }));
        self.with_combined(outputs.collect())
    }

    pub(super) fn with_combined(self, combined: Vec<(String, Combined)>) -> Trajectory {
        Trajectory { combined, ..self }
    }

    /// The names of the [combinations](crate::Combination) that were asked for, in their order.
    pub fn outputs(&self) -> impl Iterator<Item = &str> {
        self.combined.iter().map(|(name, _)| name.as_str())
    }

    /// A combination by its place: its values at the instants.
    ///
    /// # Panics
    /// If there is no such combination.
    pub fn output(&self, index: usize) -> &[f64] {
        &self.combined[index].1.values
    }

    /// How far each of its values may be off: proven or a first-order estimate, as [`bounds`](Self::bounds) says; `None`
    /// where none can be given.
    ///
    /// # Panics
    /// If there is no such combination.
    pub fn output_bound(&self, index: usize) -> &[Option<f64>] {
        &self.combined[index].1.bounds
    }

    /// All combinations, then the forces in springs and dampers.
    pub(crate) fn combined(&self) -> impl Iterator<Item = &[f64]> {
        let forces = self.forces.iter().flatten().flatten();
        let outputs = self.combined.iter().map(|(_, combined)| combined);
        outputs.chain(forces).map(|one| &one.values[..])
    }

    /// The same with bounds that are proven, computed with so many decimal digits.
    pub fn proven(self, digits: usize) -> Trajectory {
        Trajectory {
            bounds: Bounds::Proven,
            digits,
            ..self
        }
    }

    /// The same with what it took.
    pub(crate) fn after(self, operations: Operations) -> Trajectory {
        Trajectory { operations, ..self }
    }

    /// What it took, if it was computed by an exact method; else nothing is counted.
    pub fn operations(&self) -> Operations {
        self.operations
    }

    /// What the bounds are worth.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// With how many decimal digits it was computed.
    pub fn digits(&self) -> usize {
        self.digits
    }

    /// How many instants it has.
    #[allow(clippy::len_without_is_empty)] // `times().is_empty()` says it where it matters
    pub fn len(&self) -> usize {
        self.times.len()
    }

    /// The name of the method that computed it.
    pub fn method(&self) -> &'static str {
        self.method
    }

    /// The step index of each instant; empty where the instants were asked for by their times.
    pub fn steps(&self) -> &[u64] {
        &self.steps
    }

    /// Each instant in s.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Displacements in m: row i is coordinate i, column j the j-th instant.
    pub fn displacement(&self) -> MatRef<'_, f64> {
        self.displacement.as_ref()
    }

    /// Velocities in m/s, laid out as the displacements.
    pub fn velocity(&self) -> MatRef<'_, f64> {
        self.velocity.as_ref()
    }

    /// Accelerations in m/s², laid out as the displacements, where they were asked for.
    pub fn acceleration(&self) -> Option<MatRef<'_, f64>> {
        self.acceleration.as_ref().map(Mat::as_ref)
    }

    /// The displacements of the coordinate of a name, one for each instant.
    ///
    /// # Errors
    /// [`NoCoordinate`], which names those that there are.
    pub fn displacement_of(&self, name: &str) -> Result<RowRef<'_, f64>, NoCoordinate> {
        Ok(self.displacement().row(self.names.find(name)?))
    }

    /// Its velocities.
    ///
    /// # Errors
    /// [`NoCoordinate`].
    pub fn velocity_of(&self, name: &str) -> Result<RowRef<'_, f64>, NoCoordinate> {
        Ok(self.velocity().row(self.names.find(name)?))
    }

    /// Its accelerations, where they were asked for.
    ///
    /// # Errors
    /// [`NoCoordinate`].
    pub fn acceleration_of(&self, name: &str) -> Result<Option<RowRef<'_, f64>>, NoCoordinate> {
        let row = self.names.find(name)?;
        Ok(self.acceleration().map(|all| all.row(row)))
    }

    /// How far any displacement may be off at each instant, in m: proven or a first-order estimate,
    /// as [`bounds`](Self::bounds) says; `None` where none can be given.
    pub fn displacement_bound(&self) -> &[Option<f64>] {
        &self.displacement_bound
    }

    /// The same for the velocities, in m/s.
    pub fn velocity_bound(&self) -> &[Option<f64>] {
        &self.velocity_bound
    }

    /// The same for the accelerations, in m/s²; empty where they were not asked for.
    pub fn acceleration_bound(&self) -> &[Option<f64>] {
        &self.acceleration_bound
    }

    /// Whether no bound of the displacements or none of the velocities is known at an instant, by its place: what is given
    /// there may be far from the motion.
    ///
    /// # Panics
    /// If there is no such instant.
    pub fn is_doubtful(&self, instant: usize) -> bool {
        self.displacement_bound[instant].is_none() || self.velocity_bound[instant].is_none()
    }

    /// At how many instants.
    pub fn doubtful(&self) -> usize {
        (0..self.len()).filter(|k| self.is_doubtful(*k)).count()
    }
}
