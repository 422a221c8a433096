//! Where the energy of a motion is, what took it and what brought it.

mod driven_form;
mod gramian;
mod state_matrix;

use std::collections::HashMap;

use eigentone_digits::{DoubleDouble, Real};
use eigentone_modes::{FirstOrder, MatrixKind, Node, System};
use faer::MatRef;

use crate::answer::Trajectory;
use crate::problem::{Instant, Leg, Load, Problem, ResponseError, Walk};

use driven_form::DrivenForm;
use gramian::{Square, gramians};

/// The energies of a motion at the instants of its trajectory, in J.
///
/// At every instant kinetic + potential + dissipated = initial + work.
///
/// - Kinetic ½vᵀMv and potential ½xᵀKx come from the trajectory, element by element: a spring counts
///   with ½k(Δx)², so that stiff springs do not cancel.
/// - The energy that dampers took, ∫vᵀCv dt, and the work of the loads, ∫fᵀv dt, are quadratic forms of
///   exponentials. Each is integrated in closed form from one instant to the next, with loads by
///   their exact laws and starting from the trajectory's own state; there is no discretisation
///   error. Neither follows from the other, so that the balance is a check.
///
/// Up to 32 coordinates without massless nodes and with lumped masses this is done in double-double
/// from the elements, and what is left is the rounding of the trajectory. In all other cases each
/// interval of h seconds errs by the order of ‖A‖h·2^-53 of the energy in it, where ‖A‖ is the
/// fastest rate of the system.
///
/// ```
/// use eigentone_modes::{GROUND, System};
/// use eigentone_response::{Energy, Response, State};
///
/// let system = System::builder()
///     .mass("m", 2.0)
///     .spring(GROUND, "m", 8.0)
///     .damper(GROUND, "m", 1.0)
///     .build()?;
/// let asked = Response::of(&system).from(State::at_rest().displace("m", 0.5));
/// let asked = asked.every(0.1).until(60.0);
/// let (problem, trajectory) = (asked.clone().problem()?, asked.run()?);
/// let energy = Energy::along(&problem, &trajectory)?;
/// assert_eq!(energy.potential()[0], 1.0);
/// // In the end the damper has it all.
/// assert!((energy.dissipated()[600] - 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Energy {
    initial: f64,
    kinetic: Vec<f64>,
    potential: Vec<f64>,
    dissipated: Vec<f64>,
    work: Vec<f64>,
}

impl Energy {
    /// The energies along `trajectory`, an answer to `problem`.
    ///
    /// # Errors
    /// [`ResponseError::NotApplicable`] where the trajectory has another number of coordinates, where
    /// M or K is not symmetric, so that there is no such
    /// energy, where there is no first-order form, where an impulse acts on a damped node
    /// without mass, for that takes infinite work, and where an energy leaves the range of doubles.
    pub fn along(problem: &Problem<'_>, trajectory: &Trajectory) -> Result<Energy, ResponseError> {
        /// States and loads for which more digits are quick.
        const FEW: usize = 80;
        let refuse = |reason: String| ResponseError::NotApplicable {
            method: "energy",
            reason,
        };
        let system = problem.system();
        if trajectory.displacement().nrows() != system.len() {
            return Err(refuse(
                "the trajectory is that of another system".to_owned(),
            ));
        }
        for kind in [MatrixKind::Mass, MatrixKind::Stiffness] {
            if !system.added(kind).is_none_or(is_symmetric) {
                return Err(refuse(format!("the {kind} matrix is not symmetric")));
            }
        }
        let pulses = problem.timeline().pulses();
        if !problem.channels().is_empty() || !pulses.is_empty() {
            let what = "what moving supports, forces on points and pulses do";
            return Err(refuse(format!("{what} is not counted")));
        }
        let massless = system.structure().massless().to_vec();
        let blow = |load: &Load| matches!(load, Load::Impulse(impulse) if impulse.magnitude != 0.0);
        let struck = problem
            .loads()
            .iter()
            .find(|applied| blow(&applied.load) && massless.contains(&applied.coordinate));
        if let Some(applied) = struck {
            let name = &system.names()[applied.coordinate];
            return Err(refuse(format!(
                "an impulse on {name:?}, which has no mass, does infinite work"
            )));
        }
        let form = FirstOrder::of(system).map_err(|error| refuse(error.to_string()))?;
        let energy = if form.states() + 4 * problem.loads().len() <= FEW {
            Account::<DoubleDouble>::of(problem, &form).keep(trajectory)
        } else {
            Account::<f64>::of(problem, &form).keep(trajectory)
        };
        match energy.is_finite() {
            true => Ok(energy),
            false => Err(refuse("it leaves the range of doubles".to_owned())),
        }
    }

    fn is_finite(&self) -> bool {
        let parts = [&self.kinetic, &self.potential, &self.dissipated, &self.work];
        let mut values = parts.into_iter().flatten();
        self.initial.is_finite() && values.all(|value| value.is_finite())
    }

    /// The energy at t = 0 before any impulse.
    pub fn initial(&self) -> f64 {
        self.initial
    }

    /// ½vᵀMv at each instant.
    pub fn kinetic(&self) -> &[f64] {
        &self.kinetic
    }

    /// ½xᵀKx at each instant; negative springs make it negative.
    pub fn potential(&self) -> &[f64] {
        &self.potential
    }

    /// ∫vᵀCv dt from 0 to each instant: what the dampers took.
    pub fn dissipated(&self) -> &[f64] {
        &self.dissipated
    }

    /// ∫fᵀv dt from 0 to each instant, impulses included: what the loads brought.
    pub fn work(&self) -> &[f64] {
        &self.work
    }

    /// kinetic + potential + dissipated − initial − work at each instant: 0 but for rounding.
    pub fn imbalance(&self) -> Vec<f64> {
        let at = |k: usize| {
            let parts = [
                self.kinetic[k],
                self.potential[k],
                self.dissipated[k],
                -self.initial,
                -self.work[k],
            ];
            let parts = parts.into_iter().map(DoubleDouble::from);
            parts
                .fold(DoubleDouble::ZERO, |sum, part| sum + part)
                .to_f64()
        };
        (0..self.work.len()).map(at).collect()
    }
}

/// ½vᵀMv.
fn kinetic(system: &System, v: &[f64]) -> f64 {
    let lumped = system.masses().iter().zip(v);
    let lumped: f64 = lumped.map(|(mass, v)| mass * v * v).sum();
    (lumped + added(system.added(MatrixKind::Mass), v)) / 2.0
}

/// ½xᵀKx.
fn potential(system: &System, x: &[f64]) -> f64 {
    let place = |node: Node| node.coordinate().map_or(0.0, |i| x[i]);
    let stretched = system.springs().iter().map(|spring| {
        let stretch = place(spring.second) - place(spring.first);
        spring.coefficient * stretch * stretch
    });
    (stretched.sum::<f64>() + added(system.added(MatrixKind::Stiffness), x)) / 2.0
}

/// xᵀAx of a matrix that may be absent.
fn added(matrix: Option<MatRef<'_, f64>>, x: &[f64]) -> f64 {
    let form = |matrix: MatRef<'_, f64>| -> f64 {
        let row = |i: usize| (0..x.len()).map(move |j| matrix[(i, j)] * x[j]);
        (0..x.len()).map(|i| x[i] * row(i).sum::<f64>()).sum()
    };
    matrix.map_or(0.0, form)
}

fn is_symmetric(matrix: MatRef<'_, f64>) -> bool {
    let n = matrix.nrows();
    (0..n).all(|i| (0..i).all(|j| matrix[(i, j)] == matrix[(j, i)]))
}

/// e^{Ah} and the two integrals over h seconds.
struct Interval<T> {
    exponential: Square<T>,
    dissipated: Square<T>,
    work: Square<T>,
}

/// The energies as they are added up.
struct Account<'a, 'b, T> {
    problem: &'a Problem<'b>,
    form: &'a FirstOrder,
    driven: DrivenForm<T>,
    dissipation: Square<T>,
    power: Square<T>,
    /// By the bits of their length, rounded: lengths that differ only in their last digits are the
    /// same but for rounding.
    intervals: HashMap<u64, Interval<T>>,
    dissipated: T,
    work: T,
}

/// So many lengths of interval are kept.
const KEPT: usize = 64;

impl<'a, 'b, T: Real> Account<'a, 'b, T> {
    fn of(problem: &'a Problem<'b>, form: &'a FirstOrder) -> Account<'a, 'b, T> {
        let driven = DrivenForm::of(problem, form);
        Account {
            problem,
            form,
            dissipation: driven.dissipation(problem.system()),
            power: driven.power(),
            driven,
            intervals: HashMap::new(),
            dissipated: T::ZERO,
            work: T::ZERO,
        }
    }

    /// Goes through the instants in their order in time.
    fn keep(mut self, trajectory: &Trajectory) -> Energy {
        let problem = self.problem;
        let (system, grid) = (problem.system(), problem.grid());
        let mut walk = Walk::of(problem);
        let count = trajectory.len();
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by_key(|k| trajectory.steps()[*k]);
        let start = Instant::on_grid(grid, 0);
        let z = self
            .form
            .state(problem.initial_displacement(), problem.initial_velocity());
        let mut state = self.driven.state(&z, problem, &start, walk.piece());
        let (x, v) = self.driven.motion(&state);
        let mut energy = Energy {
            initial: kinetic(system, &v) + potential(system, &x),
            kinetic: vec![0.0; count],
            potential: vec![0.0; count],
            dissipated: vec![0.0; count],
            work: vec![0.0; count],
        };
        self.work = self.driven.strike(&mut state, walk.piece().impulses());
        for k in order {
            let target = Instant::on_grid(grid, trajectory.steps()[k]);
            let mut piece = walk.piece();
            while let Some(leg) = walk.towards(&target) {
                if let Leg::Pass { from, to } = leg {
                    self.advance(&mut state, &from, &to);
                    continue;
                }
                let next = walk.piece();
                let event = next.start_instant();
                // The harmonic parts go on; only straight ones may jump.
                self.driven.load(&mut state, problem, &event, piece);
                let before = state.clone();
                self.driven.load(&mut state, problem, &event, next);
                let jump = self.driven.jump(&before, &state);
                self.work = self.work + jump + self.driven.strike(&mut state, next.impulses());
                piece = next;
            }
            let column = |of: MatRef<'_, f64>| of.col(k).iter().copied().collect::<Vec<f64>>();
            let (x, v) = (
                column(trajectory.displacement()),
                column(trajectory.velocity()),
            );
            let z = self.form.state(&x, &v);
            state = self.driven.state(&z, problem, &target, piece);
            energy.kinetic[k] = kinetic(system, &v);
            energy.potential[k] = potential(system, &x);
            energy.dissipated[k] = self.dissipated.to_f64();
            energy.work[k] = self.work.to_f64();
        }
        energy
    }

    /// Moves the state to a later instant, within one piece, and adds up what passes.
    fn advance(&mut self, state: &mut Vec<T>, now: &Instant, end: &Instant) {
        let h = end.elapsed(now, self.problem.grid());
        let key = h.high().to_bits();
        if self.intervals.len() >= KEPT && !self.intervals.contains_key(&key) {
            self.intervals.clear();
        }
        let interval = self.intervals.entry(key).or_insert_with(|| {
            let forms = [&self.dissipation, &self.power].map(|form| scaled(form, h));
            let (exponential, [dissipated, work]) = gramians(&self.driven.over(h), forms);
            Interval {
                exponential,
                dissipated,
                work,
            }
        });
        self.dissipated = self.dissipated + interval.dissipated.form(state);
        self.work = self.work + interval.work.form(state);
        *state = interval.exponential.apply(state);
    }
}

/// The form times h.
fn scaled<T: Real>(form: &Square<T>, h: DoubleDouble) -> Square<T> {
    let h = T::from(h.high()) + T::from(h.low());
    let entries = form.entries.iter().map(|entry| *entry * h);
    Square {
        n: form.n,
        entries: entries.collect(),
    }
}
