//! Every mode solver on the same system: how far apart their eigenvalues are, and how long they
//! take.

use eigentone_modes::{Eigenvalue, ModesError, System, solvers};

use crate::run_time::RunTime;
use crate::work_precision::Progress;

/// Mode solvers that solved the same system.
#[derive(Clone, Debug)]
pub struct ModeComparison {
    /// The solver that the plan picks, whose eigenvalues the others are measured from.
    pub reference: &'static str,
    /// One row for each solver, in the plan's order of preference.
    pub rows: Vec<ModeComparisonRow>,
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
        /// The largest |λ − μ|/|μ| between its eigenvalues λ and those of the reference, μ, each
        /// matched with the nearest that is left; infinite where one finds a zero, or a number of
        /// eigenvalues, that the other does not. `None` for the reference itself.
        distance: Option<f64>,
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
        let chosen = system.modes()?;
        let reference = chosen.plan().solver;
        let total = solvers().len();
        let row = |(done, solver): (usize, &&'static dyn eigentone_modes::ModeSolver)| {
            progress(Progress {
                done,
                total,
                method: solver.name(),
                knob: None,
            });
            let outcome = match solver.refuses(system, structure) {
                Some(reason) => ModeOutcome::Refused { reason },
                None => match RunTime::of(|| solver.solve(system, structure)) {
                    Ok((modes, time)) => ModeOutcome::Measured {
                        distance: (solver.name() != reference)
                            .then(|| distance(modes.eigenvalues(), chosen.eigenvalues())),
                        time,
                    },
                    Err(error) => ModeOutcome::Failed(error),
                },
            };
            ModeComparisonRow {
                solver: solver.name(),
                outcome,
            }
        };
        Ok(ModeComparison {
            reference,
            rows: solvers().iter().enumerate().map(row).collect(),
        })
    }
}

fn distance(eigenvalues: &[Eigenvalue], reference: &[Eigenvalue]) -> f64 {
    if eigenvalues.len() != reference.len() {
        return f64::INFINITY;
    }
    let mut left: Vec<_> = eigenvalues.iter().map(|one| one.value).collect();
    let mut worst = 0.0f64;
    for truth in reference.iter().map(|one| one.value) {
        let distances = left.iter().map(|value| (value - truth).norm());
        let nearest = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((position, off)) = nearest else {
            break;
        };
        left.swap_remove(position);
        if off > 0.0 {
            worst = worst.max(off / truth.norm());
        }
    }
    worst
}
