//! Coordinates for the exponential: those of the energy for the system, powers of two for what drives it.

use eigentone_digits::{BallMatrix, Magnitude, Real};

use super::asked::Asked;
use super::realisation::Realisation;
use crate::enclosed::{Energy, Normed, frobenius};

pub(super) struct Coordinates<T> {
    /// R and Y ≈ R⁻¹ of all states.
    enter: BallMatrix<T>,
    leave: BallMatrix<T>,
    /// A bound of ‖(RY)⁻¹ − I‖.
    inexact: Magnitude,
    /// R A Y.
    pub(super) a: BallMatrix<T>,
    /// How far that is from R A R⁻¹ beside its radii, in the 2-norm.
    pub(super) a_error: Magnitude,
    /// R B with unit inputs 2^unit.
    pub(super) b: BallMatrix<T>,
    units: Vec<i64>,
    /// Norms of the rows of Y and the columns of R.
    rows: Vec<Magnitude>,
    columns: Vec<Magnitude>,
}

impl<T: Real> Coordinates<T> {
    /// For steps of `step` s; `None` where the digits do not suffice.
    pub(super) fn of(
        asked: &Asked<'_>,
        form: &Realisation<T>,
        step: f64,
    ) -> Option<Coordinates<T>> {
        let structure = asked.system.structure();
        let supported = structure.is_passive() && structure.zero_roots() == Some(0);
        let energy = Energy::of(&form.form, supported, 1.0 / step)?;
        let (own, size) = (form.form.states(), form.a.rows());
        let inputs = asked.channels.len();
        let epoch = Magnitude::from(step).exponent();

        let mut enter = BallMatrix::zeros(size, size);
        let mut leave = BallMatrix::zeros(size, size);
        enter.put(0, 0, &energy.r);
        leave.put(0, 0, &energy.y);
        // What a unit of each makes of the states in a step, or before they swing back.
        let swing = frobenius(&energy.r.times(form.form.a()).times(&energy.y));
        let within = Magnitude::from(1.0) / swing;
        let within = match within < Magnitude::from(step) {
            true => within,
            false => Magnitude::from(step),
        };
        let strength = |column: &BallMatrix<T>, time: Magnitude| {
            let pushed = energy.r.times(&column.block(0, 0, own, 1));
            let (norm, spread) = (frobenius(&pushed), pushed.spread());
            // A column of rounding alone has the unit of the terms that cancel in it. In one of its own size its error would be 1
            // with any number of digits, and the exponential has one error for all columns.
            let norm = match norm <= spread + spread {
                true => spread / T::unit(),
                false => norm,
            };
            (!norm.is_zero()).then(|| (norm * time).exponent())
        };
        let mut units = vec![0; size - own];
        for at in 0..size - own {
            let column = form.a.block(0, own + at, size, 1);
            let feeds = (0..at).filter(|row| !column.is_zero(own + row, 0));
            // Integrals add up over a step. What also acts on itself, or by later states, lasts until it has died out.
            let rates = (own + at..size).map(|row| column.middle(row, 0).upper());
            let slowest = rates
                .filter(|rate| !rate.is_zero())
                .reduce(|a, b| if b < a { b } else { a });
            let (lasting, adding) = match slowest {
                None => (within, epoch),
                Some(rate) => (Magnitude::from(1.0) / rate, 0),
            };
            let fed = feeds.map(|row| units[row] + adding).max();
            units[at] = strength(&column, lasting).max(fed).unwrap_or(0);
            let (there, back) = (T::ONE.scale(units[at]), T::ONE.scale(-units[at]));
            enter.set(own + at, own + at, there, Magnitude::ZERO);
            leave.set(own + at, own + at, back, Magnitude::ZERO);
        }
        let of_input = |input: usize| {
            let column = form.b.block(0, input, size, 1);
            let feeds = (own..size).filter(|row| !column.is_zero(*row, 0));
            let fed = feeds.map(|row| units[row - own] + epoch).max();
            strength(&column, within).max(fed).unwrap_or(0)
        };
        let units: Vec<i64> = (0..inputs).map(of_input).collect();
        let mut scales = BallMatrix::zeros(inputs, inputs);
        for (i, unit) in units.iter().enumerate() {
            scales.set(i, i, T::ONE.scale(-unit), Magnitude::ZERO);
        }

        // R⁻¹ = Y (RY)⁻¹ and ‖(RY)⁻¹ − I‖ ≤ δ/(1 − δ) ≤ 2δ.
        let inexact = energy.defect + energy.defect;
        let a = enter.times(&form.a).times(&leave);
        Some(Coordinates {
            a_error: inexact * frobenius(&a.block(0, 0, own, own)),
            b: enter.times(&form.b).times(&scales),
            rows: row_norms(&leave),
            columns: row_norms(&transposed(&enter)),
            a,
            enter,
            leave,
            inexact,
            units,
        })
    }

    /// A map into the states, in these coordinates.
    pub(super) fn entered(&self, map: &BallMatrix<T>) -> BallMatrix<T> {
        self.enter.times(map)
    }

    /// What a map of states into states in these coordinates is in those of the form.
    pub(super) fn map(&self, block: &BallMatrix<T>, error: Magnitude) -> BallMatrix<T> {
        let back = self.leave.times(block).times(&self.enter);
        self.widened(back, block, error, |i| self.rows[i], |j| self.columns[j])
    }

    /// The same of a map of the inputs.
    pub(super) fn map_of_inputs(&self, block: &BallMatrix<T>, error: Magnitude) -> BallMatrix<T> {
        let mut scales = BallMatrix::zeros(self.units.len(), self.units.len());
        for (i, unit) in self.units.iter().enumerate() {
            scales.set(i, i, T::ONE.scale(*unit), Magnitude::ZERO);
        }
        let back = self.leave.times(block).times(&scales);
        self.widened(back, block, error, |i| self.rows[i], |j| self.unit(j))
    }

    /// The covariance, of what `readings` make of the states of the form, and how large each reading of a state of size 1
    /// here may be.
    pub(super) fn covariance(
        &self,
        readings: &BallMatrix<T>,
        block: &BallMatrix<T>,
        error: Magnitude,
    ) -> (BallMatrix<T>, Vec<Magnitude>) {
        let leave = readings.times(&self.leave);
        let rows = row_norms(&leave);
        let back = leave.times(block).times(&transposed(&leave));
        // Both sides are inexact: (1 + ε)² − 1 ≤ 3ε.
        let twice = self.inexact + self.inexact;
        let more = twice * (frobenius(block) + error);
        let back = self.widened(back, block, error + more, |i| rows[i], |j| rows[j]);
        (back, rows)
    }

    /// Adds what an error of the block in the 2-norm, and Y in place of R⁻¹, make of each entry.
    fn widened(
        &self,
        mut back: BallMatrix<T>,
        block: &BallMatrix<T>,
        error: Magnitude,
        left: impl Fn(usize) -> Magnitude,
        right: impl Fn(usize) -> Magnitude,
    ) -> BallMatrix<T> {
        let off = error + self.inexact * (frobenius(block) + error);
        for i in 0..back.rows() {
            for j in 0..back.columns() {
                let radius = back.radius(i, j) + left(i) * off * right(j);
                let middle = back.middle(i, j);
                back.set(i, j, middle, radius);
            }
        }
        back
    }

    fn unit(&self, input: usize) -> Magnitude {
        Magnitude::power_of_two(self.units[input])
    }

    /// How large entries of a map of states and of inputs of size 1 here may be there.
    pub(super) fn scale(&self, i: usize, j: usize) -> Magnitude {
        self.rows[i] * self.columns[j]
    }

    pub(super) fn scale_of_input(&self, i: usize, input: usize) -> Magnitude {
        self.rows[i] * self.unit(input)
    }
}

/// Bounds of the 2-norms of the rows.
fn row_norms<T: Real>(a: &BallMatrix<T>) -> Vec<Magnitude> {
    let norm = |i: usize| {
        let entries = (0..a.columns()).map(|j| a.middle(i, j).upper() + a.radius(i, j));
        let squares = entries.map(|entry| entry * entry);
        squares.fold(Magnitude::ZERO, |a, b| a + b).sqrt()
    };
    (0..a.rows()).map(norm).collect()
}

pub(super) fn transposed<T: Real>(a: &BallMatrix<T>) -> BallMatrix<T> {
    let mut transposed = BallMatrix::zeros(a.columns(), a.rows());
    for i in 0..a.rows() {
        for j in 0..a.columns() {
            transposed.set(j, i, a.middle(i, j), a.radius(i, j));
        }
    }
    transposed
}

/// What is kept of a block of a matrix.
pub(super) fn kept<T: Real>(
    whole: &Normed<T>,
    column: usize,
    rows: usize,
    columns: usize,
) -> BallMatrix<T> {
    let mut block = BallMatrix::zeros(rows, columns);
    for i in 0..rows {
        for j in 0..columns {
            block.set(i, j, whole.row(i)[column + j], Magnitude::ZERO);
        }
    }
    block
}
