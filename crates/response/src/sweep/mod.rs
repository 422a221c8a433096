//! Modes and responses of many designs that differ in their parameters alone. It knows `problem` and `hold`.

mod course;
mod propagator;

use eigentone_modes::{Design, DesignError, ModesWorkspace, Parameter};
use faer::{Mat, MatRef};
use num_complex::Complex;
use pulp::Arch;
use thiserror::Error;

use crate::problem::Problem;
use course::{Course, Move};
use propagator::Propagator;

/// Answers one design after another: its modes, and its motion at the instants of a [`Problem`] from the
/// same initial state under the same loads. After the first design nothing is allocated.
///
/// The modes are those of [`ModesWorkspace`]. The motion is exact at every instant but for the
/// rounding of doubles, by the exponential of the whole state, O((2n)³) for each length of step and O(n²) for
/// each step. There are no bounds, and very stiff systems cost digits: look at the designs that a sweep
/// brings forward by [`Response`](crate::Response), which proves its answers.
///
/// ```
/// use eigentone_modes::{GROUND, Parameter, System};
/// use eigentone_response::{Problem, State, Sweep, TimeGrid};
///
/// let system = System::builder()
///     .mass("m1", 2.0)
///     .mass("m2", 1.0)
///     .spring(GROUND, "m1", 2.0)
///     .spring("m1", "m2", 0.2)
///     .damper("m1", "m2", 0.1)
///     .build()?;
/// let start = State::at_rest().displace("m1", 1.0);
/// let problem = Problem::new(&system, &start, Vec::new(), TimeGrid::new(0.05, 50.0)?)?;
/// let mut sweep = Sweep::of(&problem)?;
/// let mut best = (f64::INFINITY, 0.0);
/// for damping in [0.05, 0.1, 0.2, 0.4] {
///     sweep.set(Parameter::Damper(0), damping)?;
///     let answer = sweep.solve()?;
///     let last = answer.displacement().ncols() - 1;
///     let left = answer.displacement()[(0, last)].abs();
///     if left < best.0 {
///         best = (left, damping);
///     }
/// }
/// println!("{} N·s/m leaves {} m", best.1, best.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Sweep {
    design: Design,
    modes: ModesWorkspace,
    course: Course,
    propagators: Vec<Propagator>,
    start: Vec<f64>,
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    z: Vec<f64>,
    next: Vec<f64>,
    drive: Vec<f64>,
    displacement: Mat<f64>,
    velocity: Mat<f64>,
}

/// The answer to one design, until the next one.
#[derive(Clone, Copy, Debug)]
pub struct Answer<'a> {
    sweep: &'a Sweep,
}

/// Why a sweep cannot answer.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SweepError {
    /// The design is not one of those that sweeps answer.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// The problem asks for more than displacements and velocities at all instants of its grid, loads a point or moves a
    /// support.
    #[error(
        "a sweep answers all instants of a grid under loads on coordinates, without accelerations, outputs and forces: \
         ask for those alone"
    )]
    Wanted,
    /// The answer would not fit in memory at a sensible size.
    #[error(
        "instants {instants}, coordinates {coordinates}: together more than the {limit} numbers that a sweep keeps: choose fewer instants"
    )]
    TooLarge {
        /// The instants of the grid.
        instants: u64,
        /// The coordinates of the system.
        coordinates: usize,
        /// The most numbers.
        limit: usize,
    },
    /// The motion leaves the range of doubles.
    #[error("the motion leaves the range of doubles: choose other units, or a shorter time")]
    Overflow,
}

/// The most displacements that are kept.
const LIMIT: usize = 1 << 24;

impl Sweep {
    /// A sweep over designs of the problem's system. Its precision does not matter.
    ///
    /// # Errors
    /// [`SweepError::Design`] for systems with whole matrices, massless nodes or negative values,
    /// [`SweepError::Wanted`] for chosen instants, accelerations, outputs, forces, loads at points or motions of supports, [`SweepError::TooLarge`].
    pub fn of(problem: &Problem<'_>) -> Result<Sweep, SweepError> {
        let design = Design::of(problem.system())?;
        let more = problem.wants_acceleration() || !problem.sources().is_empty();
        if problem.instants().is_some() || more || !problem.channels().is_empty() {
            return Err(SweepError::Wanted);
        }
        let (n, last) = (design.len(), problem.grid().last());
        if last >= (LIMIT / n) as u64 {
            return Err(SweepError::TooLarge {
                instants: last.saturating_add(1),
                coordinates: n,
                limit: LIMIT,
            });
        }
        let course = Course::of(problem);
        let propagator = Propagator::new(2 * n, course.loaded.len(), &course.laws);
        let room = (2 * n).next_multiple_of(8);
        let initial = [problem.initial_displacement(), problem.initial_velocity()];
        Ok(Sweep {
            modes: ModesWorkspace::of(&design),
            design,
            propagators: vec![propagator; course.lengths.len()],
            start: initial.concat(),
            stiffness: vec![0.0; n * n],
            damping: vec![0.0; n * n],
            z: vec![0.0; room],
            next: vec![0.0; room],
            drive: vec![0.0; room],
            displacement: Mat::zeros(n, course.instants),
            velocity: Mat::zeros(n, course.instants),
            course,
        })
    }

    /// Sets one parameter of the next design; the others stay as they are.
    ///
    /// # Errors
    /// [`DesignError`].
    pub fn set(&mut self, parameter: Parameter, value: f64) -> Result<(), DesignError> {
        self.design.set(parameter, value)
    }

    /// The design as it is set.
    pub fn design(&self) -> &Design {
        &self.design
    }

    /// Modes and motion of the design as it is set.
    ///
    /// # Errors
    /// [`SweepError::Design`] where springs do not hold every coordinate or the modes leave the range of
    /// doubles, [`SweepError::Overflow`].
    pub fn solve(&mut self) -> Result<Answer<'_>, SweepError> {
        self.modes.solve(&self.design)?;
        self.prepare()?;
        Arch::new().dispatch(|| self.run());
        let rows = [&self.displacement, &self.velocity];
        let finite = |matrix: &Mat<f64>| {
            let mut columns = matrix.col_iter();
            columns.all(|column| column.iter().all(|entry| entry.is_finite()))
        };
        if !rows.into_iter().all(finite) {
            return Err(SweepError::Overflow);
        }
        Ok(Answer { sweep: self })
    }

    /// The holds over all lengths of step.
    fn prepare(&mut self) -> Result<(), SweepError> {
        let n = self.design.len();
        self.design.stiffness_matrix(&mut self.stiffness);
        self.design.damping_matrix(&mut self.damping);
        let (masses, course) = (self.design.masses(), &self.course);
        let a = |i: usize, j: usize| match (i.checked_sub(n), j.checked_sub(n)) {
            (None, Some(j)) if i == j => 1.0,
            (None, _) => 0.0,
            (Some(i), None) => -self.stiffness[i + n * j] / masses[i],
            (Some(i), Some(j)) => -self.damping[i + n * j] / masses[i],
        };
        let force = |i: usize, j: usize| {
            let at = course.loaded[j];
            if i == n + at { 1.0 / masses[at] } else { 0.0 }
        };
        for (propagator, h) in self.propagators.iter_mut().zip(&course.lengths) {
            if !propagator.prepare(*h, &course.laws, a, force) {
                return Err(SweepError::Overflow);
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn run(&mut self) {
        let n = self.design.len();
        let masses = self.design.masses();
        self.z.fill(0.0);
        self.z[..2 * n].copy_from_slice(&self.start);
        let mut known = None;
        let mut column = 0;
        for step in &self.course.moves {
            match *step {
                Move::Impulse {
                    coordinate,
                    magnitude,
                } => self.z[n + coordinate] += magnitude / masses[coordinate],
                Move::Step { length, signal } => {
                    let propagator = &self.propagators[length];
                    if known != Some((length, signal)) {
                        propagator.drive(&self.course.signals[signal], &mut self.drive);
                        known = Some((length, signal));
                    }
                    propagator.advance(&mut self.z, &self.drive, &mut self.next);
                }
                Move::Record => {
                    let (x, v) = self.z[..2 * n].split_at(n);
                    self.displacement
                        .col_as_slice_mut(column)
                        .copy_from_slice(x);
                    self.velocity.col_as_slice_mut(column).copy_from_slice(v);
                    column += 1;
                }
            }
        }
    }

    /// Answers designs one after another: `set` makes each of them, `read` takes from its answer
    /// what is wanted. A design that cannot be answered gives its error, and the others go on.
    pub fn each<D, R>(
        &mut self,
        designs: impl IntoIterator<Item = D>,
        set: impl Fn(&mut Sweep, D) -> Result<(), DesignError>,
        read: impl Fn(Answer<'_>) -> R,
    ) -> impl Iterator<Item = Result<R, SweepError>> {
        designs.into_iter().map(move |design| {
            set(self, design)?;
            self.solve().map(&read)
        })
    }

    /// [`each`](Self::each) with all threads of the current rayon pool, in the order of the designs. Every thread
    /// works on its own copy of the sweep, so that `set` should set all that differs between
    /// designs; the answers have the same bits for any number of threads.
    #[cfg(feature = "rayon")]
    pub fn each_in_parallel<D, R>(
        &self,
        designs: Vec<D>,
        set: impl Fn(&mut Sweep, D) -> Result<(), DesignError> + Sync,
        read: impl Fn(Answer<'_>) -> R + Sync,
    ) -> Vec<Result<R, SweepError>>
    where
        D: Send,
        R: Send,
    {
        use rayon::iter::{IntoParallelIterator, ParallelIterator};
        let answer = |sweep: &mut Sweep, design: D| {
            set(sweep, design)?;
            sweep.solve().map(&read)
        };
        designs
            .into_par_iter()
            .map_init(|| self.clone(), answer)
            .collect()
    }
}

impl<'a> Answer<'a> {
    /// λ of each mode in 1/s, with Im λ ≥ 0, as [`ModesWorkspace::eigenvalues`] gives them.
    pub fn eigenvalues(&self) -> &'a [Complex<f64>] {
        self.sweep.modes.eigenvalues()
    }

    /// The shape of mode j, one entry for each coordinate, the largest of them 1.
    ///
    /// # Panics
    /// If there is no mode j.
    pub fn shape(&self, j: usize) -> &'a [Complex<f64>] {
        self.sweep.modes.shape(j)
    }

    /// Displacements in m: a row for each coordinate, a column for each instant of the grid.
    pub fn displacement(&self) -> MatRef<'a, f64> {
        self.sweep.displacement.as_ref()
    }

    /// Velocities in m/s, as the displacements.
    pub fn velocity(&self) -> MatRef<'a, f64> {
        self.sweep.velocity.as_ref()
    }
}
