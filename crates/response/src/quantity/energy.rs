//! Where the energy of a motion is, what took it and what brought it.

mod squares;

use eigentone_digits::{Magnitude, Real};
use eigentone_modes::{MatrixKind, Term};
use faer::MatRef;

use crate::answer::Trajectory;
use crate::certified::quadratic::Course;
use crate::problem::{Known, Load, Problem, ResponseError, sum};

use squares::squares;

/// The energies of a motion at the instants of a trajectory, in J, each with a proven bound.
///
/// At every instant kinetic + potential + dissipated = initial + work.
///
/// - Kinetic ½vᵀMv and potential ½xᵀKx are sums over elements, with the motions of supports: a spring counts with ½k(Δx)²,
///   so that stiff springs do not cancel, nor does what the ground carries along.
/// - The energy that dampers took, ∫vᵀCv dt, is a quadratic form of the state and the loads, integrated in closed form by its
///   Gramian from one instant to the next (Smith 1968, *SIAM J. Appl. Math.* 16).
/// - The work of loads and of the forces that move the supports is what these three have gained.
///
/// All follow the exact motion of the problem, with 32 or 77 digits, whatever the precision of the trajectory.
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
/// assert!(energy.bound()[600] < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Energy {
    initial: f64,
    kinetic: Vec<f64>,
    potential: Vec<f64>,
    dissipated: Vec<f64>,
    work: Vec<f64>,
    bound: Vec<f64>,
}

impl Energy {
    /// The energies at the instants of `trajectory`, an answer to `problem`.
    ///
    /// # Errors
    /// [`ResponseError::NotApplicable`] where the trajectory has another number of coordinates or instants that are not of the
    /// grid, where M or K is not symmetric, so that there is no such energy, where an impulse acts on a damped node
    /// without mass or a support jumps at a damper, for that takes infinite work, where there are too many states or instants,
    /// and where 77 digits do not show an energy to a millionth of the largest.
    pub fn along(problem: &Problem<'_>, trajectory: &Trajectory) -> Result<Energy, ResponseError> {
        /// What an energy has to be known to, beside the largest.
        const KNOWN: f64 = 1e-6;
        /// And beside what cancels in it.
        const CANCELLED: f64 = 1e-26;
        let refuse = |reason: &str| {
            Err(ResponseError::NotApplicable {
                method: "energy",
                reason: reason.to_owned(),
            })
        };
        let system = problem.system();
        if trajectory.displacement().nrows() != system.len() {
            return refuse("the trajectory is that of another system");
        }
        let (steps, last) = (trajectory.steps(), problem.grid().last());
        if steps.len() != trajectory.len() || steps.iter().any(|step| *step > last) {
            return refuse("the trajectory has instants that are not of the problem's grid");
        }
        for kind in [MatrixKind::Mass, MatrixKind::Stiffness] {
            if !system.added(kind).is_none_or(is_symmetric) {
                return refuse(&format!("the {kind} matrix is not symmetric"));
            }
        }
        if let Some(reason) = without_limit(problem) {
            return refuse(&reason);
        }
        let found = Course::of(problem).and_then(|course| Energy::of(course, problem, steps));
        // What springs would hold if only one of their ends were displaced: where all of it cancels nothing is left.
        let displaced = problem.initial_displacement().iter();
        let farthest = trajectory.displacement().norm_max();
        let displaced = displaced.fold(farthest, |most, x| most.max(x.abs()));
        let springs = system.terms(MatrixKind::Stiffness);
        let springs = springs.map(|term| term.value.abs()).sum::<f64>();
        let cancelled = CANCELLED * springs * displaced * displaced;
        let cancelled = Some(cancelled).filter(|size| size.is_finite());
        let found = match found {
            Ok(energy) if energy.is_known_to(f64::EPSILON, 0.0) => Ok(energy),
            few => {
                let more = Course::with_more(problem);
                let more = more.and_then(|course| Energy::of(course, problem, steps));
                more.or(few)
            }
        };
        match found {
            Ok(energy) if energy.is_known_to(KNOWN, cancelled.unwrap_or(0.0)) => Ok(energy),
            Ok(_) => refuse("no number of digits in reach suffices to follow it"),
            Err(reason) => refuse(reason),
        }
    }

    fn of<T: Real>(
        course: Course<'_, '_, T>,
        problem: &Problem<'_>,
        steps: &[u64],
    ) -> Result<Energy, &'static str> {
        let mut order: Vec<usize> = (0..steps.len()).collect();
        order.sort_by_key(|k| steps[*k]);
        let instants: Vec<u64> = order.iter().map(|k| steps[*k]).collect();
        let [mass, damping, stiffness] =
            [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness]
                .map(|kind| squares(problem.system(), kind));
        let (initially, found) = course.sums(&instants, [&mass, &stiffness], &damping)?;
        let half = |(value, off): Known<T>| (value.scale(-1), off * Magnitude::power_of_two(-1));
        let [kinetic, potential, _] = initially.map(half);
        let initial = sum(kinetic, potential);
        let drives = !problem.drives().is_empty();
        let nothing = vec![0.0; steps.len()];
        let mut energy = Energy {
            initial: known(initial).0,
            kinetic: nothing.clone(),
            potential: nothing.clone(),
            dissipated: nothing.clone(),
            work: nothing.clone(),
            bound: nothing,
        };
        for (k, [kinetic, potential, dissipated]) in order.into_iter().zip(found) {
            let (kinetic, potential) = (half(kinetic), half(potential));
            let held = sum(sum(kinetic, potential), dissipated);
            let work = match drives {
                true => sum(held, (-initial.0, initial.1)),
                false => (T::ZERO, Magnitude::ZERO),
            };
            let all = [kinetic, potential, dissipated, work].map(known);
            [energy.kinetic[k], energy.potential[k]] = [all[0].0, all[1].0];
            [energy.dissipated[k], energy.work[k]] = [all[2].0, all[3].0];
            energy.bound[k] = all.iter().fold(0.0, |most, one| one.1.max(most));
        }
        Ok(energy)
    }

    /// Whether all bounds are at most so much of the largest energy, or `absolute`.
    fn is_known_to(&self, relative: f64, absolute: f64) -> bool {
        let parts = [&self.kinetic, &self.potential, &self.dissipated, &self.work];
        let sizes = parts.into_iter().flatten().map(|value| value.abs());
        let largest = sizes.fold(self.initial.abs(), f64::max);
        let least = (relative * largest).max(absolute) + f64::MIN_POSITIVE / f64::EPSILON;
        largest.is_finite() && self.bound.iter().all(|bound| *bound <= least)
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

    /// A proven bound for each of these four at each instant, rounding to doubles included.
    pub fn bound(&self) -> &[f64] {
        &self.bound
    }
}

/// The nearest double, or 0 where the error hides it, and how far it may be off.
fn known<T: Real>((exact, error): Known<T>) -> (f64, f64) {
    let size = exact.upper();
    if size <= error {
        return (0.0, (error + size).to_f64());
    }
    let value = exact.to_f64();
    let off = (exact - T::from(value)).upper();
    (value, (error + off).to_f64())
}

/// What takes infinite work: an impulse on a damped node without mass, or a support that jumps at a damper.
fn without_limit(problem: &Problem<'_>) -> Option<String> {
    let (system, channels) = (problem.system(), problem.channels());
    let massless = system.structure().massless();
    let channel = |on: usize| on.checked_sub(system.len()).map(|at| &channels[at]);
    problem.drives().iter().find_map(|drive| {
        let acts_on = |row: usize, share: f64| share != 0.0 && massless.contains(&row);
        let on = match (&drive.load, channel(drive.coordinate)) {
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
