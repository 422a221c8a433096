//! Motions as deviations from where constant loads would let them rest.

use crate::problem::{Instant, Piece, Problem, rest};

/// ζ = ζ_rest + ζ_deviation in pieces of time in which every load but harmonics is constant, once the motion has come
/// near: then what decays towards rest keeps its digits, and is not lost in the roundings of what balances the
/// load. Before, it is the smaller numbers of the motion itself that keep theirs.
pub(crate) struct Deviation {
    rest: Option<Rest>,
    /// Whether ζ is the deviation from it.
    split: bool,
    /// The piece that the rest belongs to, or that has none.
    known: Option<usize>,
    /// How many more rests may be looked for.
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
            split: false,
            known: None,
            left: if small { PIECES } else { 1 },
        }
    }

    /// The displacements from which ζ deviates, where it does.
    pub(crate) fn rest(&self) -> Option<&[f64]> {
        let rest = self.rest.as_ref().filter(|_| self.split);
        rest.map(|rest| rest.displacement.as_slice())
    }

    /// Whether the piece of this index lasts and has a rest that ζ may come near to.
    pub(crate) fn waits(
        &mut self,
        problem: &Problem<'_>,
        index: usize,
        state: impl Fn(&[f64]) -> Vec<f64>,
    ) -> bool {
        if !self.split && self.known != Some(index) {
            self.known = Some(index);
            self.rest = self.look(problem, index, state);
        }
        !self.split && self.rest.is_some()
    }

    /// Turns ζ into the deviation, if it is near to the rest that it waits for.
    pub(crate) fn split(&mut self, zeta: &mut [f64]) {
        if let Some(rest) = self.rest.as_ref().filter(|rest| is_near(zeta, &rest.state)) {
            for (zeta, rest) in zeta.iter_mut().zip(&rest.state) {
                *zeta -= rest;
            }
            self.split = true;
        }
    }

    fn look(
        &mut self,
        problem: &Problem<'_>,
        index: usize,
        state: impl Fn(&[f64]) -> Vec<f64>,
    ) -> Option<Rest> {
        let (pieces, grid) = (problem.timeline().pieces(), problem.grid());
        let piece = &pieces[index];
        let last = Instant::on_grid(grid, grid.last());
        let end = pieces.get(index + 1).map_or(last, |next| next.start);
        let lasts = end.since(&piece.start, grid) >= LASTING as f64 * grid.step();
        let coordinates = problem.system().len();
        let forces = piece.straight().iter();
        let alone = forces
            .clone()
            .all(|straight| straight.coordinate < coordinates);
        if self.left == 0 || !lasts || !alone || !is_constant(piece) {
            return None;
        }
        self.left -= 1;
        let mut force = vec![0.0; problem.system().len()];
        for straight in forces {
            force[straight.coordinate] += straight.value;
        }
        let displacement = rest(problem.system(), &force)?;
        Some(Rest {
            state: state(&displacement),
            displacement,
        })
    }

    /// Whether ζ is a deviation that ends where the piece of this index begins, which has other loads.
    pub(crate) fn ends(&self, problem: &Problem<'_>, index: usize) -> bool {
        self.split && !problem.timeline().pieces()[index].changes().is_empty()
    }

    /// Turns the deviation back into ζ where the piece of this index, which begins now, has other loads.
    pub(crate) fn join(&mut self, problem: &Problem<'_>, index: usize, zeta: &mut [f64]) {
        let same = problem.timeline().pieces()[index].changes().is_empty();
        if self.split && same {
            self.known = Some(index);
        } else if let Some(rest) = self.rest.take().filter(|_| self.split) {
            for (zeta, rest) in zeta.iter_mut().zip(&rest.state) {
                *zeta += rest;
            }
            self.split = false;
        }
    }
}

/// Whether the deviation is at most half as large as the rest itself, so that no digits are lost to it.
pub(crate) fn is_near(state: &[f64], rest: &[f64]) -> bool {
    let pairs = state.iter().zip(rest);
    let away: f64 = pairs.map(|(state, rest)| (state - rest).powi(2)).sum();
    let far: f64 = rest.iter().map(|rest| rest * rest).sum();
    away <= 0.25 * far
}

/// Whether some load acts, and none that acts grows.
fn is_constant(piece: &Piece) -> bool {
    let mut straight = piece.straight().iter();
    straight.clone().any(|load| load.value != 0.0) && straight.all(|load| load.slope == 0.0)
}
