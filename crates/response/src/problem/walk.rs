//! The way through time, from instant to instant, past everything that begins in between.

use super::instant::Instant;
use super::question::Problem;
use super::timeline::Piece;

/// Goes from t = 0 to one target after the other, stopping where a piece of the timeline begins.
pub(crate) struct Walk<'a> {
    pieces: &'a [Piece],
    index: usize,
    now: Instant,
}

/// What comes next on the way.
pub(crate) enum Leg {
    /// Time passes within a piece.
    Pass { from: Instant, to: Instant },
    /// The next piece begins.
    Begin,
}

impl<'a> Walk<'a> {
    /// At t = 0, where the first piece has begun.
    pub(crate) fn of(problem: &'a Problem<'_>) -> Walk<'a> {
        Walk {
            pieces: problem.timeline().pieces(),
            index: 0,
            now: Instant::on_grid(problem.grid(), 0),
        }
    }

    /// The piece that lasts.
    pub(crate) fn piece(&self) -> &'a Piece {
        &self.pieces[self.index]
    }

    /// Its index.
    pub(crate) fn index(&self) -> usize {
        self.index
    }

    /// What comes next on the way to `target`, at which pieces that begin there have begun; `None` once it is
    /// reached.
    pub(crate) fn towards(&mut self, target: &Instant) -> Option<Leg> {
        let begins = self.pieces.get(self.index + 1).map(|next| next.start);
        let stop = begins.filter(|start| start.order(target).is_le());
        let to = stop.unwrap_or(*target);
        if self.now.order(&to).is_lt() {
            let from = std::mem::replace(&mut self.now, to);
            return Some(Leg::Pass { from, to });
        }
        // One instant may be given in two ways: as an event, and as part of a step.
        self.now = to;
        stop?;
        self.index += 1;
        Some(Leg::Begin)
    }
}
