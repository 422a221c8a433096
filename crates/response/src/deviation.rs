//! Motions as deviations from where constant loads would let them rest.

use crate::equilibrium::rest;
use crate::problem::Problem;
use crate::timeline::{Instant, Piece};

/// ζ = ζ_rest + ζ_deviation in pieces of time in which every load but harmonics is constant: then what decays towards
/// rest keeps its digits, and is not lost in the roundings of what balances the load.
pub(crate) struct Deviation {
    rest: Option<Rest>,
    /// How many more pieces may be split.
    left: usize,
}

struct Rest {
    /// In m.
    displacement: Vec<f64>,
    /// The same as a state in the method's own coordinates.
    state: Vec<f64>,
}

/// In a piece of fewer steps nothing comes to rest.
const LASTING: u64 = 32;

impl Deviation {
    pub(crate) fn new(problem: &Problem<'_>) -> Deviation {
        /// An equilibrium costs as much as some steps, or an exponential.
        const PIECES: usize = 64;
        let small = problem.system().len() <= PIECES;
        Deviation {
            rest: None,
            left: if small { PIECES } else { 1 },
        }
    }

    /// The displacements from which ζ deviates, where it does.
    pub(crate) fn rest(&self) -> Option<&[f64]> {
        self.rest.as_ref().map(|rest| rest.displacement.as_slice())
    }

    /// Turns ζ into the deviation for the piece of this index, if that lasts.
    pub(crate) fn split(
        &mut self,
        problem: &Problem<'_>,
        index: usize,
        zeta: &mut [f64],
        state: impl Fn(&[f64]) -> Vec<f64>,
    ) {
        let pieces = problem.timeline().pieces();
        let piece = &pieces[index];
        if self.rest.is_some() || self.left == 0 || !is_constant(piece) {
            return;
        }
        let grid = problem.grid();
        let last = Instant::on_grid(grid, grid.last());
        let end = pieces.get(index + 1).map_or(last, |next| next.start);
        if end.since(&piece.start, grid) < LASTING as f64 * grid.step() {
            return;
        }
        let mut force = vec![0.0; problem.system().len()];
        for straight in piece.straight() {
            force[straight.coordinate] += straight.value;
        }
        self.left -= 1;
        if let Some(displacement) = rest(problem.system(), &force) {
            let state = state(&displacement);
            for (zeta, rest) in zeta.iter_mut().zip(&state) {
                *zeta -= rest;
            }
            self.rest = Some(Rest {
                displacement,
                state,
            });
        }
    }

    /// Turns the deviation back into ζ where this piece, which begins now, has other loads.
    pub(crate) fn join(&mut self, begins: &Piece, zeta: &mut [f64]) {
        if begins.changes().is_empty() {
            return;
        }
        if let Some(rest) = self.rest.take() {
            for (zeta, rest) in zeta.iter_mut().zip(&rest.state) {
                *zeta += rest;
            }
        }
    }
}

/// Whether some load acts, and none that acts grows.
fn is_constant(piece: &Piece) -> bool {
    let mut straight = piece.straight().iter();
    straight.clone().any(|load| load.value != 0.0) && straight.all(|load| load.slope == 0.0)
}
