//! Where methods are accurate, where they lose digits and where they break: every method on families
//! of systems whose parameter is taken to extremes.

mod contender;
mod explanation;
mod family;

use std::time::Instant;

use contender::{Contender, contenders};
pub use family::{Difficulty, Family};

/// How methods did on several families.
#[derive(Clone, Debug)]
pub struct StabilityStudy {
    /// One table for each family.
    pub families: Vec<FamilyStudy>,
}

/// How methods did on one family.
#[derive(Clone, Debug)]
pub struct FamilyStudy {
    /// The family.
    pub family: Family,
    /// One row for each method, this project's own first.
    pub rows: Vec<StabilityRow>,
}

/// How one method did.
#[derive(Clone, Debug)]
pub struct StabilityRow {
    /// The method, with its setting.
    pub method: String,
    /// Whether it is what the plan picks.
    pub planned: bool,
    /// Whether it solves for modes; otherwise it answers for the motion.
    pub modes: bool,
    /// One cell for each value of the parameter.
    pub cells: Vec<Cell>,
    /// Why it loses digits, breaks or takes too long, if it does.
    pub explanation: Option<String>,
}

/// One method at one value of the parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// It answered.
    Answered {
        /// How far it is off: of motions, the largest error of a displacement relative to the peak; of
        /// modes, the largest |λ − μ|/|μ|.
        error: f64,
        /// How long it took, in s.
        time: f64,
    },
    /// It lost its stability: the motion grew beyond ten times what it should be.
    Unstable,
    /// It gave up.
    Failed {
        /// What it reported.
        reason: String,
    },
    /// It does not apply.
    Refused {
        /// Why not.
        reason: String,
    },
    /// It was not run, for it would take longer than a cell may.
    NotRun {
        /// How many steps it would take.
        steps: f64,
        /// How long, in s.
        time: f64,
    },
}

/// What a cell is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Four digits or more, as much as a plot shows.
    Accurate,
    /// One to four digits.
    Degraded,
    /// No digit, no stability, or no answer.
    Broken,
    /// It does not apply.
    Refused,
    /// It would take too long.
    NotRun,
}

impl Cell {
    /// What it is worth.
    pub fn verdict(&self) -> Verdict {
        match self {
            Cell::Answered { error, .. } if *error <= 1e-4 => Verdict::Accurate,
            Cell::Answered { error, .. } if *error <= 0.1 => Verdict::Degraded,
            Cell::Answered { .. } | Cell::Unstable | Cell::Failed { .. } => Verdict::Broken,
            Cell::Refused { .. } => Verdict::Refused,
            Cell::NotRun { .. } => Verdict::NotRun,
        }
    }
}

/// How far a study has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StudyProgress<'a> {
    /// Cells finished.
    pub done: usize,
    /// Cells in all.
    pub total: usize,
    /// The family under study.
    pub family: &'a str,
    /// The value of its parameter.
    pub value: f64,
    /// The method that runs next.
    pub method: &'a str,
}

impl StabilityStudy {
    /// Runs every method on every member of the families. A cell that is predicted to take longer than 2 s
    /// is not run. `progress` is reported before each cell.
    pub fn run(families: &[Family], progress: &mut dyn FnMut(StudyProgress<'_>)) -> StabilityStudy {
        let contenders: Vec<Vec<Contender>> = families.iter().map(contenders).collect();
        let total = families.iter().zip(&contenders);
        let total = total
            .map(|(family, all)| family.values.len() * all.len())
            .sum();
        let mut done = 0;
        let mut studies = Vec::with_capacity(families.len());
        for (family, contenders) in families.iter().zip(&contenders) {
            let mut cells: Vec<Vec<Cell>> = vec![Vec::new(); contenders.len()];
            for &value in &family.values {
                let member = contender::Member::of(family, value);
                for (contender, cells) in contenders.iter().zip(&mut cells) {
                    progress(StudyProgress {
                        done,
                        total,
                        family: family.name,
                        value,
                        method: &contender.name,
                    });
                    cells.push(match &member {
                        Ok(member) => member.answer(contender),
                        Err(reason) => Cell::Failed {
                            reason: reason.clone(),
                        },
                    });
                    done += 1;
                }
            }
            let rows = contenders.iter().zip(cells).map(|(contender, cells)| {
                let explanation = explanation::of(contender, family.difficulty, &cells);
                StabilityRow {
                    method: contender.name.clone(),
                    planned: contender.is_planned(),
                    modes: contender.is_for_modes(),
                    cells,
                    explanation,
                }
            });
            studies.push(FamilyStudy {
                family: family.clone(),
                rows: rows.collect(),
            });
        }
        StabilityStudy { families: studies }
    }
}

/// Seconds since a start.
fn seconds(start: Instant) -> f64 {
    start.elapsed().as_secs_f64()
}
