//! What the loads and the instants ask of every design alike: steps, signals, impulses.

use crate::hold::{Inputs, Laws};
use crate::problem::{Instant, Leg, Piece, Problem, Walk};

/// The way from t = 0 through all instants that are asked for. It does not depend on the parameters of the
/// system.
#[derive(Clone, Debug)]
pub(super) struct Course {
    /// Indices of the coordinates that any load but an impulse acts on.
    pub(super) loaded: Vec<usize>,
    pub(super) laws: Laws,
    /// Steps of different length, in s.
    pub(super) lengths: Vec<f64>,
    /// Different values of the loads, one for each block of the hold and each loaded coordinate.
    pub(super) signals: Vec<Vec<f64>>,
    pub(super) moves: Vec<Move>,
    /// How many moves end in a [`Move::Record`].
    pub(super) instants: usize,
}

/// What happens next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Move {
    /// An impulse on a coordinate, in N·s.
    Impulse { coordinate: usize, magnitude: f64 },
    /// One of the lengths passes, under one of the signals.
    Step { length: usize, signal: usize },
    /// An instant that is asked for.
    Record,
}

impl Course {
    pub(super) fn of(problem: &Problem<'_>) -> Course {
        let inputs = Inputs::of(problem);
        let mut course = Course {
            loaded: inputs.loaded.clone(),
            laws: inputs.laws.clone(),
            lengths: Vec::new(),
            signals: Vec::new(),
            moves: Vec::new(),
            instants: 0,
        };
        let grid = problem.grid();
        let mut values = inputs.empty_signals();
        let mut walk = Walk::of(problem);
        course.add_impulses(walk.piece());
        for index in 0..=grid.last() {
            let target = Instant::on_grid(grid, index);
            while let Some(leg) = walk.towards(&target) {
                let Leg::Pass { from, to } = leg else {
                    course.add_impulses(walk.piece());
                    continue;
                };
                let h = to.elapsed(&from, grid);
                inputs.signals(&from, walk.piece(), h, &mut values);
                let length = place(&mut course.lengths, h.to_f64());
                let signal = place(&mut course.signals, values.values.clone());
                course.moves.push(Move::Step { length, signal });
            }
            course.moves.push(Move::Record);
            course.instants += 1;
        }
        course
    }

    fn add_impulses(&mut self, piece: &Piece) {
        let impulses = piece.impulses().iter();
        self.moves
            .extend(impulses.map(|&(coordinate, magnitude)| Move::Impulse {
                coordinate,
                magnitude,
            }));
    }
}

/// Where a value stands in a list; at its end, if it is new. The last ones are looked at first.
fn place<T: PartialEq>(list: &mut Vec<T>, value: T) -> usize {
    const NEAR: usize = 8;
    let first = list.len().saturating_sub(NEAR);
    let known = list[first..].iter().rposition(|other| *other == value);
    known.map_or_else(
        || {
            list.push(value);
            list.len() - 1
        },
        |at| first + at,
    )
}
