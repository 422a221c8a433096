//! Why a method loses digits, breaks or takes too long.

use super::contender::{Contender, Kind, Order};
use super::{Cell, Difficulty, Verdict};

/// One sentence for a method that does not stay accurate over a family, or `None` if it does.
pub(super) fn of(contender: &Contender, difficulty: Difficulty, cells: &[Cell]) -> Option<String> {
    let first = |verdict: Verdict| cells.iter().find(|cell| cell.verdict() == verdict);
    let lost = first(Verdict::Broken)
        .or_else(|| first(Verdict::NotRun))
        .or_else(|| first(Verdict::Refused))
        .or_else(|| first(Verdict::Degraded))?;
    if let Cell::Failed { reason } | Cell::Refused { reason } = lost {
        return Some(reason.clone());
    }
    Some(sentence(&contender.kind, difficulty, lost).to_owned())
}

fn sentence(kind: &Kind, difficulty: Difficulty, lost: &Cell) -> &'static str {
    match kind {
        Kind::Exact(_) => match difficulty {
            Difficulty::Horizon => {
                "Each step rounds the state, and the errors of so many steps add up: the phase drifts."
            }
            _ => {
                "It starts from the state matrix in doubles: what is soft, slow or light is rounded away beside what is stiff, fast or heavy before anything is computed."
            }
        },
        Kind::Solver(_) => {
            "It starts from the state matrix in doubles: small eigenvalues keep an error of 1e-16 of the largest, not of themselves."
        }
        Kind::Fixed { order, .. } => fixed(*order, difficulty, lost),
        Kind::Adaptive { explicit: true, .. } => match difficulty {
            Difficulty::Stiffness | Difficulty::Damping | Difficulty::Mass | Difficulty::Step => {
                "Explicit: however slow the visible motion, its steps must stay within a few 1/|λ| of the fastest mode, and their number is in proportion to the spread."
            }
            Difficulty::Horizon => {
                "Its steps are as many as there are turns, and the error of each is carried on: long before the steps take too long, the tolerance of one is not that of the sum."
            }
            Difficulty::Size => "Its steps times n² operations for each evaluation take too long.",
        },
        Kind::Adaptive { .. } => match (difficulty, lost) {
            (Difficulty::Size, _) => {
                "Its steps times n² operations for each solution take too long."
            }
            (Difficulty::Stiffness | Difficulty::Mass, Cell::Answered { .. }) => {
                "It starts from matrices in doubles, where soft springs are rounded away beside a stiff one."
            }
            (Difficulty::Stiffness | Difficulty::Mass, _) => {
                "It stays stable, but to meet its tolerance fast motion that is not damped has to be followed turn by turn."
            }
            _ => "What still moves has to be followed turn by turn until the end.",
        },
        Kind::Plan(_) | Kind::PlannedModes(_) => {
            "In doubles, the elements themselves keep their digits, but some of the motion hangs on their differences."
        }
    }
}

fn fixed(order: Order, difficulty: Difficulty, lost: &Cell) -> &'static str {
    match (order, lost) {
        (Order::Explicit, Cell::Unstable) => {
            "Explicit: beyond a step of two or three times 1/|λ| of the fastest mode every rounding error of that mode grows from step to step."
        }
        (_, Cell::NotRun { .. }) => match difficulty {
            Difficulty::Size => "Its steps times n² operations each take too long.",
            _ => "A step that resolves one period has to be taken for every period until the end.",
        },
        (Order::Explicit, _) => {
            "Its steps resolve the slow motion only; what turns faster is damped away or out of phase."
        }
        (Order::Second, _) => match difficulty {
            Difficulty::Horizon => {
                "It turns a share of (ωh)²/12 too slowly, and the phase it lacks adds up over the periods."
            }
            _ => {
                "It stays stable, but a fast mode advances by at most half a turn a step: its motion is wrong from the first step, the slow motion stays right."
            }
        },
    }
}
