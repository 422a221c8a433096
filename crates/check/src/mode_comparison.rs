//! Every mode solver on the same system: how far off their eigenvalues are, and how long they take.

use eigentone_modes::{Bounds, Eigenvalue, Modes, ModesError, System, solvers};

use crate::run_time::RunTime;
use crate::work_precision::Progress;

/// Mode solvers that solved the same system.
#[derive(Clone, Debug)]
pub struct ModeComparison {
    /// What the eigenvalues are compared with.
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
        error: Option<ModeError>,
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

/// How far eigenvalues λ lie from those of a reference, μ, each matched with the nearest that is left;
/// infinite where one finds a zero, or a number of eigenvalues, that the other does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeError {
    /// The largest |λ − μ|/|μ|.
    pub eigenvalue: f64,
    /// The largest |Re λ − Re μ|/|Re μ|, which is what a damping ratio is off by.
    pub real_part: f64,
}

/// The name of the row with bounds.
const PROVEN: &str = "plan, with bounds";

impl ModeComparison {
    /// Solves for the modes of `system` by every solver that applies; `progress` is told before
    /// each.
    ///
    /// # Errors
    /// What the plan's choice reports; everything else is a [`ModeOutcome`].
    pub fn measure(
        system: &System,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<ModeComparison, ModesError> {
        let structure = system.structure();
        let total = solvers().len() + 1;
        let mut told = 0;
        let mut tell = |method| {
            progress(Progress {
                done: told,
                total,
                method,
                knob: None,
            });
            told += 1;
        };
        tell(PROVEN);
        let (chosen, time) = RunTime::of(|| system.modes())?;
        let truth = chosen.eigenvalues();
        let mut rows = vec![ModeComparisonRow {
            solver: PROVEN,
            outcome: measured(None, &chosen, time),
        }];
        for solver in solvers() {
            tell(solver.name());
            let outcome = match solver.refuses(system, structure) {
                Some(reason) => ModeOutcome::Refused { reason },
                None => match RunTime::of(|| solver.solve(system, structure)) {
                    Ok((modes, time)) => {
                        let error = ModeError::between(modes.eigenvalues(), truth);
                        measured(Some(error), &modes, time)
                    }
                    Err(error) => ModeOutcome::Failed(error),
                },
            };
            rows.push(ModeComparisonRow {
                solver: solver.name(),
                outcome,
            });
        }
        Ok(ModeComparison {
            reference: PROVEN,
            rows,
            pick: chosen.plan().solver,
            reason: chosen.plan().reason.clone(),
        })
    }
}

fn measured(error: Option<ModeError>, modes: &Modes, time: RunTime) -> ModeOutcome {
    ModeOutcome::Measured {
        error,
        bounds: modes.bounds(),
        time,
    }
}

impl ModeError {
    /// The distance of `eigenvalues` from those of a `reference`.
    pub fn between(eigenvalues: &[Eigenvalue], reference: &[Eigenvalue]) -> ModeError {
        let mut worst = ModeError {
            eigenvalue: 0.0,
            real_part: 0.0,
        };
        if eigenvalues.len() != reference.len() {
            return ModeError {
                eigenvalue: f64::INFINITY,
                real_part: f64::INFINITY,
            };
        }
        let mut left: Vec<_> = eigenvalues.iter().map(|one| one.value).collect();
        for truth in reference.iter().map(|one| one.value) {
            let distances = left.iter().map(|value| (value - truth).norm());
            let nearest = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((position, _)) = nearest else {
                break;
            };
            let off = left.swap_remove(position) - truth;
            let relative = |off: f64, of: f64| if off == 0.0 { 0.0 } else { off / of };
            worst.eigenvalue = worst.eigenvalue.max(relative(off.norm(), truth.norm()));
            let real = relative(off.re.abs(), truth.re.abs());
            worst.real_part = worst.real_part.max(real);
        }
        worst
    }
}
