//! Steps that wait to be taken together.

use eigentone_digits::DoubleDouble;
use faer::{Mat, MatMut};

use crate::problem::{Instant, Piece};

/// Steps in their order, and the instants on the way that are asked for.
#[derive(Default)]
pub(super) struct Queue<'a> {
    lengths: Vec<DoubleDouble>,
    /// Those of the steps that wait, one after the other.
    signals: Vec<f64>,
    pub(super) marks: Vec<Mark<'a>>,
    taken: usize,
}

/// An instant to be recorded, in this piece of the timeline, after so many of the steps that wait.
pub(super) struct Mark<'a> {
    pub(super) after: usize,
    pub(super) instant: Instant,
    pub(super) piece: &'a Piece,
}

impl<'a> Queue<'a> {
    pub(super) fn len(&self) -> usize {
        self.lengths.len()
    }

    /// How many steps were taken before those that wait.
    pub(super) fn taken(&self) -> usize {
        self.taken
    }

    pub(super) fn push(&mut self, h: DoubleDouble, signals: &[f64]) {
        self.signals.extend_from_slice(signals);
        self.lengths.push(h);
    }

    pub(super) fn mark(&mut self, instant: Instant, piece: &'a Piece) {
        let after = self.len();
        self.marks.push(Mark {
            after,
            instant,
            piece,
        });
    }

    /// Takes all steps from z; the states before the first and after each, column by column, and how long each step was.
    /// `advance` takes several steps of one length, from z to the last state, and fills in the states after each.
    pub(super) fn take(
        &mut self,
        mut advance: impl FnMut(DoubleDouble, &mut [f64], &[f64], MatMut<'_, f64>),
        z: &mut [f64],
    ) -> (Mat<f64>, Vec<f64>) {
        let mut states = Mat::<f64>::zeros(z.len(), self.len() + 1);
        states.col_as_slice_mut(0).copy_from_slice(z);
        let width = self.signals.len() / self.len().max(1);
        let mut done = 0;
        for run in self.lengths.chunk_by(|a, b| a == b) {
            let signals = &self.signals[done * width..(done + run.len()) * width];
            let columns = states.subcols_mut(done + 1, run.len());
            advance(run[0], z, signals, columns);
            done += run.len();
        }
        self.taken += done;
        self.signals.clear();
        let lengths = self.lengths.drain(..).map(|h| h.to_f64()).collect();
        (states, lengths)
    }
}
