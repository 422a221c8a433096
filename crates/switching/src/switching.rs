//! The question and its answer.

use eigentone_digits::{DoubleDouble, Wide};
use eigentone_modes::Precision;
use eigentone_response::{Problem, ResponseError, Trajectory};

use crate::error::SwitchingError;
use crate::event::Event;
use crate::losses::Losses;
use crate::march::{Doubt, Found, Halt, Question, march};
use crate::outputs::SwitchForce;
use crate::peaks::SwitchedPeaks;
use crate::switch::Switch;

/// A problem whose system has switches.
#[derive(Clone, Debug)]
pub struct Switching<'a, 'b> {
    question: Question<'a, 'b>,
}

/// The motion of a system with switches.
#[derive(Clone, Debug, PartialEq)]
pub struct SwitchedMotion {
    trajectory: Trajectory,
    events: Vec<Event>,
    losses: Option<Losses>,
    peaks: Option<SwitchedPeaks>,
    forces: Vec<SwitchForce>,
}

impl SwitchedMotion {
    /// The motion at the instants asked for. At an event it is what comes just after.
    pub fn trajectory(&self) -> &Trajectory {
        &self.trajectory
    }

    /// All events, by time.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Where energy went, if [asked for](Switching::with_losses).
    pub fn losses(&self) -> Option<&Losses> {
        self.losses.as_ref()
    }

    /// The highest and lowest values between the instants too, if [asked for](Switching::with_peaks).
    pub fn peaks(&self) -> Option<&SwitchedPeaks> {
        self.peaks.as_ref()
    }

    /// The force of a switch on b along its stretch at the instants, in N, apart from the impulses of impacts. `None` where
    /// forces [were not asked for](eigentone_response::Problem::with_forces), or there is no such switch.
    pub fn switch_force(&self, switch: usize) -> Option<&[f64]> {
        self.forces.get(switch).map(|(values, _)| &values[..])
    }

    /// How far each of its values may be off, as the bounds of the motion say; `None` where nothing is known.
    pub fn switch_force_bound(&self, switch: usize) -> Option<&[Option<f64>]> {
        self.forces.get(switch).map(|(_, bounds)| &bounds[..])
    }
}

impl<'a, 'b> Switching<'a, 'b> {
    /// The problem with these switches in its system.
    ///
    /// # Errors
    /// [`SwitchingError::Switch`] naming the first that is wrong.
    pub fn new(
        problem: &'a Problem<'b>,
        switches: Vec<Switch>,
    ) -> Result<Switching<'a, 'b>, SwitchingError> {
        let forms = switches.iter().enumerate().map(|(switch, given)| {
            let wrong = |fault| SwitchingError::Switch { switch, fault };
            given.forms(problem.system()).map_err(wrong)
        });
        let question = Question {
            forms: forms.collect::<Result<_, _>>()?,
            problem,
            switches,
            with_losses: false,
            with_peaks: false,
        };
        Ok(Switching { question })
    }

    /// With the energy that each damper and switch takes: integrals of products of power series, exact but for the rounding of
    /// the digits taken. It costs more than the motion.
    pub fn with_losses(mut self) -> Switching<'a, 'b> {
        self.question.with_losses = true;
        self
    }

    /// With the highest and lowest displacements, velocities, accelerations and forces between the instants.
    pub fn with_peaks(mut self) -> Switching<'a, 'b> {
        self.question.with_peaks = true;
        self
    }

    pub(crate) fn question(&self) -> &Question<'a, 'b> {
        &self.question
    }

    /// The exact motion. With [`Precision::Certified`] everything is computed with 32 digits or more, as many as the
    /// tolerance and the events ask for, and all bounds are proven; what half of the digits cannot distinguish from a coincidence is
    /// taken as one, as two events at one time are. With [`Precision::Double`] the digits that decide the events do, and bounds are
    /// given as estimates; where no digits do, as in chaotic motions after some time, the motion goes on as rounding has it,
    /// with bounds that show it.
    ///
    /// # Errors
    /// [`SwitchingError`].
    pub fn run(&self) -> Result<SwitchedMotion, SwitchingError> {
        type Run = fn(&Question<'_, '_>, f64, Doubt) -> Result<Found, Halt>;
        const UNIT: f64 = f64::EPSILON / 2.0;
        admit(self.question.problem, self.question.switches.len())?;
        let (relative, proven) = match self.question.problem.precision() {
            Precision::Certified { tolerance } => ((tolerance - UNIT).max(UNIT / 1024.0), true),
            Precision::Double => (f64::INFINITY, false),
        };
        let found = |found: Found, digits: usize| SwitchedMotion {
            trajectory: match proven {
                true => found.trajectory.proven(digits),
                false => found.trajectory,
            },
            events: found.events,
            losses: found.losses,
            peaks: found.peaks,
            forces: found.forces,
        };
        let rungs: [(Run, usize, Doubt); 3] = [
            (march::<DoubleDouble, Wide<4>>, 32, Doubt::Refused),
            (march::<Wide<4>, Wide<4>>, 77, Doubt::Coincidence),
            match proven {
                true => (march::<Wide<8>, Wide<8>>, 154, Doubt::Coincidence),
                // Chaos takes all digits.
                false => (march::<Wide<4>, Wide<4>>, 77, Doubt::Ignored),
            },
        ];
        let mut loose = None;
        for (at, (run, digits, doubt)) in rungs.into_iter().enumerate() {
            let last = at + 1 == rungs.len();
            match run(&self.question, relative, doubt) {
                Ok(answer) if answer.good || last => return Ok(found(answer, digits)),
                Ok(answer) => loose = Some(found(answer, digits)),
                Err(halt) if last || !halt.is_undecided() => {
                    // More digits take too long: what there is has its bounds.
                    let error = SwitchingError::from(halt);
                    let too_long = matches!(error, SwitchingError::TooLong { .. });
                    return loose.filter(|_| too_long).ok_or(error);
                }
                Err(_) => {}
            }
        }
        Err(SwitchingError::Stuck)
    }
}

/// Refuses instants that would take more memory than one motion may.
fn admit(problem: &Problem<'_>, switches: usize) -> Result<(), ResponseError> {
    /// In GB.
    const LIMIT: f64 = 2.0;
    let instants = match problem.instants() {
        Some(indices) => indices.len() as u64,
        None => problem.grid().last() + 1,
    };
    let coordinates = problem.system().len();
    let kinds = 2 + usize::from(problem.wants_acceleration());
    let forces = if problem.wants_forces() { switches } else { 0 };
    // Each output has a bound; beside them are bounds of coordinates, and indices of instants.
    let numbers = kinds * coordinates + 2 * (problem.combinations().len() + forces) + 8;
    let gigabytes = instants as f64 * numbers as f64 * 8e-9;
    if gigabytes > LIMIT {
        return Err(ResponseError::TooLarge {
            instants,
            coordinates,
            gigabytes,
            limit: LIMIT,
        });
    }
    Ok(())
}
