//! Every mode solver on the same system: how far off their eigenvalues are, and how long they take.

use eigentone_modes::{Bounds, Modes, ModesError, System, solvers};

use crate::reference::EigenvalueError;
use crate::run_time::RunTime;
use crate::truth::ModesTruth;
use crate::work_precision::Progress;

/// Mode solvers that solved the same system.
#[derive(Clone, Debug)]
pub struct ModeComparison {
    /// What the eigenvalues are compared with: the reference with more digits, or the modes with bounds
    /// where that is too expensive.
    pub reference: &'static str,
    /// The modes with bounds, as [`System::modes`] gives them, then one row for each solver in doubles,
    /// in the plan's order of preference.
    pub rows: Vec<ModeComparisonRow>,
    /// The solver that the plan picks.
    pub pick: &'static str,
    /// Why it is the right one.
    pub reason: String,
}

/// One mode solver.
#[derive(Clone, Debug)]
pub struct ModeComparisonRow {
    /// The solver's name.
    pub solver: &'static str,
    /// What came of it.
    pub outcome: ModeOutcome,
}

/// What came of one mode solver.
#[derive(Clone, Debug)]
pub enum ModeOutcome {
    /// It answered.
    Measured {
        /// How far off it is; `None` for the reference itself.
        error: Option<EigenvalueError>,
        /// What its bounds are worth.
        bounds: Bounds,
        /// How long it takes.
        time: RunTime,
    },
    /// It does not apply.
    Refused {
        /// Why not.
        reason: String,
    },
    /// It gave up.
    Failed(ModesError),
}

/// The name of the row with bounds.
const PROVEN: &str = "plan, with bounds";

impl ModeComparison {
    /// Solves for the modes of `system` by every solver that applies; `progress` is reported before
    /// each.
    ///
    /// # Errors
    /// What the plan's choice reports; everything else is a [`ModeOutcome`].
    pub fn measure(
        system: &System,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<ModeComparison, ModesError> {
        let total = solvers().len() + 1;
        let mut done = 0;
        let mut report = |method| {
            progress(Progress {
                done,
                total,
                method,
                knob: None,
            });
            done += 1;
        };
        report(PROVEN);
        let truth = ModesTruth::of(system)?;
        let reference = truth.name(PROVEN);
        let (chosen, time) = RunTime::of(|| system.modes())?;
        let error = (reference != PROVEN).then(|| truth.error_of(&chosen));
        let mut rows = vec![ModeComparisonRow {
            solver: PROVEN,
            outcome: measured(error, &chosen, time),
        }];
        for solver in solvers() {
            report(solver.name());
            let outcome = match solver.refuses(system) {
                Some(reason) => ModeOutcome::Refused { reason },
                None => match RunTime::of(|| solver.solve(system)) {
                    Ok((modes, time)) => measured(Some(truth.error_of(&modes)), &modes, time),
                    Err(error) => ModeOutcome::Failed(error),
                },
            };
            rows.push(ModeComparisonRow {
                solver: solver.name(),
                outcome,
            });
        }
        Ok(ModeComparison {
            reference,
            rows,
            pick: chosen.plan().solver,
            reason: chosen.plan().reason.clone(),
        })
    }
}

fn measured(error: Option<EigenvalueError>, modes: &Modes, time: RunTime) -> ModeOutcome {
    ModeOutcome::Measured {
        error,
        bounds: modes.bounds(),
        time,
    }
}
