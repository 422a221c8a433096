//! Elimination by fronts (Duff & Reid 1983, *ACM Trans. Math. Softw.* 9, "The multifrontal solution of indefinite
//! sparse symmetric linear equations"; Liu 1992, *SIAM Review* 34).
//!
//! The columns of a supernode share their rows, so that they are eliminated as a dense matrix, the front. What that
//! leaves for later columns waits on a stack for the supernode with the first of them; in a postorder all that one supernode
//! waits for lies on top of it. Diagonals are kept apart, as sums or as joins to the ground: what is beside them follows by plain
//! products of matrices, which add up terms of one sign alone where no join is negative.

use std::ops::Range;

use faer::{MatMut, MatRef};

use super::entry::Entry;
use super::ordering::Ordering;

/// So many columns are eliminated one by one before the rest of a front follows by a product.
const BLOCK: usize = 32;

/// So many columns of the rest follow at once, from the first one's diagonal down.
const COLUMNS: usize = 96;

/// What a column is divided by.
pub(crate) struct Pivot<T> {
    pub(crate) value: T,
    /// 1/d, and 0 where d is exactly 0.
    pub(crate) inverse: T,
    /// The sizes of the terms that d is the sum of.
    pub(crate) terms: f64,
}

/// The front that is worked on, and what those before have left.
pub(crate) struct Fronts<'a, T> {
    ordering: &'a Ordering,
    star_mesh: bool,
    /// Joins to the ground, or else the diagonal, by places; and the sizes of their terms.
    rest: Vec<T>,
    terms: Vec<f64>,
    /// The columns that are eliminated, and the order of the front.
    columns: Range<usize>,
    height: usize,
    /// Where in the front each place is.
    local: Vec<u32>,
    /// By columns; what is below the diagonal counts.
    front: Vec<T>,
    /// The same of `rest` and `terms` as far as the front changes them.
    own_rest: Vec<T>,
    own_terms: Vec<f64>,
    /// The columns of a block times their pivots.
    scaled: Vec<T>,
    /// What fronts have left: squares by columns.
    stack: Vec<T>,
    /// Of which supernodes.
    waiting: Vec<Range<usize>>,
}

impl<'a, T: Entry> Fronts<'a, T> {
    /// Of a matrix with these joins to the ground, or with this diagonal unless it is a `star_mesh`.
    pub(crate) fn new(ordering: &'a Ordering, rest: Vec<T>, star_mesh: bool) -> Fronts<'a, T> {
        Fronts {
            ordering,
            star_mesh,
            terms: rest.iter().map(|rest| rest.size()).collect(),
            columns: 0..0,
            height: 0,
            local: vec![0; rest.len()],
            rest,
            front: Vec::new(),
            own_rest: Vec::new(),
            own_terms: Vec::new(),
            scaled: Vec::new(),
            stack: Vec::new(),
            waiting: Vec::new(),
        }
    }

    /// Begins with the next supernode.
    pub(crate) fn open(&mut self, columns: Range<usize>) {
        let zero = T::from(0.0);
        let rows = self.ordering.below(&columns);
        let own = columns.clone().zip(0..);
        own.for_each(|(place, at)| self.local[place] = at);
        let later = rows.iter().zip(columns.len() as u32..);
        later.for_each(|(&place, at)| self.local[place as usize] = at);
        self.height = columns.len() + rows.len();
        let height = self.height;
        self.front.clear();
        self.front.resize(height * height, zero);
        self.own_rest.clear();
        self.own_rest.extend(&self.rest[columns.clone()]);
        self.own_rest.resize(height, zero);
        self.own_terms.clear();
        self.own_terms.extend(&self.terms[columns.clone()]);
        self.own_terms.resize(height, 0.0);
        self.columns = columns;
        // What earlier fronts have left for these columns.
        while let Some(before) = self.waiting.last() {
            let rows = self.ordering.below(before);
            if rows[0] as usize >= self.columns.end {
                break;
            }
            let start = self.stack.len() - rows.len() * rows.len();
            let squares = self.stack[start..].chunks_exact(rows.len());
            for (k, (column, entries)) in rows.iter().zip(squares).enumerate() {
                let at = self.local[*column as usize] as usize * height;
                let target = &mut self.front[at..at + height];
                for (row, entry) in rows[k + 1..].iter().zip(&entries[k + 1..]) {
                    target[self.local[*row as usize] as usize] += *entry;
                }
            }
            self.stack.truncate(start);
            self.waiting.pop();
        }
    }

    /// Adds an entry of the matrix below the diagonal, in a column of the front.
    pub(crate) fn enter(&mut self, column: usize, row: u32, value: T) {
        let at = (column - self.columns.start) * self.height;
        self.front[at + self.local[row as usize] as usize] += value;
    }

    /// Eliminates the columns of the front, and hands over each with its pivot and the column of L.
    pub(crate) fn eliminate(&mut self, mut finished: impl FnMut(usize, Pivot<T>, &[T])) {
        let (height, width) = (self.height, self.columns.len());
        for block in (0..width).step_by(BLOCK) {
            let end = width.min(block + BLOCK);
            self.scaled.clear();
            for k in block..end {
                let pivot = self.divide(k, end);
                let column = &self.front[k * height + k + 1..(k + 1) * height];
                finished(self.columns.start + k, pivot, column);
            }
            let (before, after) = self.front.split_at_mut(end * height);
            let inner = end - block;
            let of = |entries, from: usize, count| {
                MatRef::from_column_major_slice(entries, height, inner).subrows(from, count)
            };
            let (factor, scaled) = (&before[block * height..], &self.scaled[..]);
            for column in (end..height).step_by(COLUMNS) {
                let count = COLUMNS.min(height - column);
                let target = &mut after[(column - end) * height..][..count * height];
                let target = MatMut::from_column_major_slice_mut(target, height, count);
                T::subtract_product(
                    target.subrows_mut(column, height - column),
                    of(scaled, column, height - column),
                    of(factor, column, count),
                );
            }
        }
        let rows = self.ordering.below(&self.columns);
        for (k, &row) in rows.iter().enumerate() {
            self.rest[row as usize] += self.own_rest[width + k];
            self.terms[row as usize] += self.own_terms[width + k];
            let at = (width + k) * height + width;
            self.stack
                .extend_from_slice(&self.front[at..at + rows.len()]);
        }
        if !rows.is_empty() {
            self.waiting.push(self.columns.clone());
        }
    }

    /// Divides column k by its pivot, and eliminates it from those before `end`.
    fn divide(&mut self, k: usize, end: usize) -> Pivot<T> {
        let (zero, height) = (T::from(0.0), self.height);
        let (before, after) = self.front.split_at_mut((k + 1) * height);
        let column = &mut before[k * height..];
        let mut value = self.own_rest[k];
        let mut terms = self.own_terms[k];
        if self.star_mesh {
            for entry in &column[k + 1..] {
                value -= *entry;
                terms += entry.size();
            }
        }
        let inverse = match value == zero {
            true => zero,
            false => T::from(1.0) / value,
        };
        let start = self.scaled.len();
        self.scaled.resize(start + k + 1, zero);
        self.scaled.extend_from_slice(&column[k + 1..]);
        let scaled = &self.scaled[start..];
        let ground = self.own_rest[k];
        let sums = self.own_rest.iter_mut().zip(&mut self.own_terms);
        for (entry, (rest, terms)) in column[k + 1..].iter_mut().zip(sums.skip(k + 1)) {
            let multiplier = *entry * inverse;
            let update = match self.star_mesh {
                true => multiplier * ground,
                false => multiplier * *entry,
            };
            *entry = multiplier;
            *rest -= update;
            *terms += update.size();
        }
        for (other, target) in (k + 1..end).zip(after.chunks_exact_mut(height)) {
            let factor = column[other];
            let pairs = target[other + 1..].iter_mut().zip(&scaled[other + 1..]);
            pairs.for_each(|(y, x)| *y -= *x * factor);
        }
        Pivot {
            value,
            inverse,
            terms,
        }
    }
}
