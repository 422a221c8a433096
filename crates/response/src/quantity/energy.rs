//! Where the energy of a motion is, what took it and what brought it.

mod driven_form;
mod gramian;
mod squares;
mod state_matrix;

use std::collections::HashMap;

use eigentone_digits::{DoubleDouble, Real};
use eigentone_modes::{FirstOrder, MatrixKind, Term};
use faer::MatRef;

use crate::answer::Trajectory;
use crate::problem::{Instant, Leg, Load, Problem, ResponseError, Walk};

use driven_form::{DrivenForm, Layout};
use gramian::{Square, gramians};

/// The energies of a motion at the instants of its trajectory, in J.
///
/// At every instant kinetic + potential + dissipated = initial + work.
///
/// - Kinetic ½vᵀMv and potential ½xᵀKx come from the trajectory, element by element, with the motions of supports: a spring
///   counts with ½k(Δx)², so that stiff springs do not cancel, nor does what the ground carries along.
/// - The energy that dampers took, ∫vᵀCv dt, and the work of loads and of the forces that move the supports are quadratic
///   forms of exponentials. Each is integrated in closed form from one instant to the next, with loads by
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
    /// without mass or a support jumps at a damper, for that takes infinite work, where states and signals are more than some
    /// thousands, and where an energy or a rate of the states leaves the range of doubles.
    pub fn along(problem: &Problem<'_>, trajectory: &Trajectory) -> Result<Energy, ResponseError> {
        /// States and signals for which more digits are quick.
        const FEW: usize = 80;
        /// And for which forms of them all are.
        const MANY: usize = 2_000;
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
        if let Some(reason) = without_limit(problem) {
            return Err(refuse(reason));
        }
        let form = FirstOrder::of(system).map_err(|error| refuse(error.to_string()))?;
        let layout = Layout::of(problem, &form);
        let count = layout.len();
        if count > MANY {
            let what = "entries of states and signals take too long, more than";
            return Err(refuse(format!("{count} {what} {MANY}")));
        }
        let energy = match count <= FEW {
            true => Account::<DoubleDouble>::of(problem, &form, layout)
                .map(|account| account.keep(trajectory)),
            false => {
                Account::<f64>::of(problem, &form, layout).map(|account| account.keep(trajectory))
            }
        };
        energy
            .filter(Energy::is_finite)
            .ok_or_else(|| refuse("it leaves the range of doubles".to_owned()))
    }

    fn is_finite(&self) -> bool {
        let parts = [&self.kinetic, &self.potential, &self.dissipated, &self.work];
        let mut values = parts.into_iter().flatten();
        self.initial.is_finite() && values.all(|value| value.is_finite())
    }

    /// The energy at t = 0, before loads, impulses and motions of supports set in.
    pub fn initial(&self) -> f64 {
        self.initial
    }

    /// ½vᵀMv at each instant.
    pub fn kinetic(&self) -> &[f64] {
        &self.kinetic
    }

    /// ½xᵀKx at each instant, springs to moving supports included; negative springs make it negative.
    pub fn potential(&self) -> &[f64] {
        &self.potential
    }

    /// ∫vᵀCv dt from 0 to each instant: what the dampers took.
    pub fn dissipated(&self) -> &[f64] {
        &self.dissipated
    }

    /// ∫fᵀv dt from 0 to each instant, impulses included: what the loads brought, and the forces that move the supports.
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

/// What takes infinite work: an impulse on a damped node without mass, or a support that jumps at a damper.
fn without_limit(problem: &Problem<'_>) -> Option<String> {
    let (system, channels) = (problem.system(), problem.channels());
    let massless = system.structure().massless();
    let channel = |on: usize| on.checked_sub(system.len()).map(|at| &channels[at]);
    problem.drives().iter().find_map(|drive| {
        let acts_on = |row: usize, share: f64| share != 0.0 && massless.contains(&row);
        let on = match (&drive.load, channel(drive.coordinate)) {
            (Load::Impulse(impulse), _) if impulse.magnitude == 0.0 => None,
            (Load::Impulse(_), None) => Some(drive.coordinate).filter(|row| acts_on(*row, 1.0)),
            (Load::Impulse(_), Some(channel)) => {
                let mut shares = channel.directions[0].iter();
                let found = shares.find(|(row, share)| acts_on(*row, *share));
                found.map(|(row, _)| *row)
            }
            (load, Some(channel)) => {
                let support = channel.support?;
                let at = |term: &Term| term.column == support;
                let damping = MatrixKind::Damping;
                let mut terms = system.coupling(damping).iter();
                let damped = terms.any(at) || system.between_supports(damping).iter().any(at);
                let jumps = channel.integrals == 0 && load.jumps() && damped;
                return jumps.then(|| {
                    let name = &system.supports()[support];
                    format!("a jump of {name:?} through a damper does infinite work")
                });
            }
            _ => None,
        };
        on.map(|row| {
            let name = &system.names()[row];
            format!("an impulse on {name:?}, which has no mass, does infinite work")
        })
    })
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
    /// `None` where the rates of the states leave the range of doubles.
    fn of(problem: &'a Problem<'b>, form: &'a FirstOrder, layout: Layout) -> Option<Self> {
        let driven = DrivenForm::of(problem, form, layout)?;
        Some(Account {
            problem,
            form,
            dissipation: driven.dissipation(),
            power: driven.power(),
            driven,
            intervals: HashMap::new(),
            dissipated: T::ZERO,
            work: T::ZERO,
        })
    }

    /// Goes through the instants in their order in time.
    fn keep(mut self, trajectory: &Trajectory) -> Energy {
        let problem = self.problem;
        let grid = problem.grid();
        let mut walk = Walk::of(problem);
        let count = trajectory.len();
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by_key(|k| trajectory.steps()[*k]);
        let z = self
            .form
            .state(problem.initial_displacement(), problem.initial_velocity());
        let mut state = self.driven.at_rest();
        self.driven.set(&mut state, &z);
        let [kinetic, potential] = self.driven.stored(self.driven.motion(&state, None));
        let mut energy = Energy {
            initial: kinetic + potential,
            kinetic: vec![0.0; count],
            potential: vec![0.0; count],
            dissipated: vec![0.0; count],
            work: vec![0.0; count],
        };
        self.begin(&mut state, &walk);
        for k in order {
            let target = Instant::on_grid(grid, trajectory.steps()[k]);
            let mut piece = walk.piece();
            while let Some(leg) = walk.towards(&target) {
                if let Leg::Pass { from, to } = leg {
                    self.advance(&mut state, &from, &to);
                    continue;
                }
                let event = walk.piece().start_instant();
                self.driven.load(&mut state, problem, &event, piece);
                self.begin(&mut state, &walk);
                piece = walk.piece();
            }
            let column = |of: MatRef<'_, f64>| of.col(k).iter().copied().collect::<Vec<f64>>();
            let (x, v) = (
                column(trajectory.displacement()),
                column(trajectory.velocity()),
            );
            let z = self.form.state(&x, &v);
            self.driven.set(&mut state, &z);
            self.driven.load(&mut state, problem, &target, piece);
            let motion = self.driven.motion(&state, Some([&x, &v]));
            [energy.kinetic[k], energy.potential[k]] = self.driven.stored(motion);
            energy.dissipated[k] = self.dissipated.to_f64();
            energy.work[k] = self.work.to_f64();
        }
        energy
    }

    /// What jumps at the start of a piece.
    fn begin(&mut self, state: &mut [T], walk: &Walk<'_>) {
        let (problem, piece) = (self.problem, walk.piece());
        let before = state.to_vec();
        let event = piece.start_instant();
        self.driven.load(state, problem, &event, piece);
        let jump = self.driven.jump(&before, state);
        let impulses = self
            .driven
            .apply_impulses(problem, walk.index(), &before, state);
        self.work = self.work + jump + impulses;
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
