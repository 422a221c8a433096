//! Matrices of exact numbers, and the eliminations that are exact in rational ones.

use std::ops::{AddAssign, Mul};

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Zero};

/// A matrix of exact numbers, stored by rows.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Matrix<T> {
    rows: Vec<Vec<T>>,
    columns: usize,
}

/// A matrix of rational numbers.
pub(super) type RationalMatrix = Matrix<BigRational>;

impl<T: Clone + Zero + One> Matrix<T> {
    pub(super) fn zeros(rows: usize, columns: usize) -> Matrix<T> {
        Matrix::from_fn(rows, columns, |_, _| T::zero())
    }

    pub(super) fn from_fn(
        rows: usize,
        columns: usize,
        entry: impl Fn(usize, usize) -> T,
    ) -> Matrix<T> {
        let row = |i| (0..columns).map(|j| entry(i, j)).collect();
        Matrix {
            rows: (0..rows).map(row).collect(),
            columns,
        }
    }

    /// Row r has its only entry, 1, in column `chosen[r]`.
    pub(super) fn selection(chosen: &[usize], columns: usize) -> Matrix<T> {
        Matrix::from_fn(chosen.len(), columns, |i, j| match j == chosen[i] {
            true => T::one(),
            false => T::zero(),
        })
    }

    pub(super) fn nrows(&self) -> usize {
        self.rows.len()
    }

    pub(super) fn at(&self, i: usize, j: usize) -> &T {
        &self.rows[i][j]
    }

    pub(super) fn at_mut(&mut self, i: usize, j: usize) -> &mut T {
        &mut self.rows[i][j]
    }

    /// The entries that are not 0, with their places.
    pub(super) fn nonzeros(&self) -> impl Iterator<Item = (usize, usize, &T)> {
        let entries = self.rows.iter().enumerate();
        let entries =
            entries.flat_map(|(i, row)| row.iter().enumerate().map(move |(j, e)| (i, j, e)));
        entries.filter(|(_, _, entry)| !entry.is_zero())
    }

    pub(super) fn is_zero(&self) -> bool {
        self.nonzeros().next().is_none()
    }

    /// The block at these rows and columns.
    pub(super) fn block(&self, rows: &[usize], columns: &[usize]) -> Matrix<T> {
        Matrix::from_fn(rows.len(), columns.len(), |i, j| {
            self.at(rows[i], columns[j]).clone()
        })
    }

    pub(super) fn times(&self, other: &Matrix<T>) -> Matrix<T>
    where
        T: AddAssign,
        for<'a> &'a T: Mul<&'a T, Output = T>,
    {
        let mut product = Matrix::zeros(self.nrows(), other.columns);
        for (i, k, left) in self.nonzeros() {
            for (j, right) in other.rows[k].iter().enumerate() {
                if !right.is_zero() {
                    *product.at_mut(i, j) += left * right;
                }
            }
        }
        product
    }
}

impl RationalMatrix {
    /// The rows of this matrix, then those of `below`.
    pub(super) fn over(mut self, below: RationalMatrix) -> RationalMatrix {
        self.rows.extend(below.rows);
        self
    }

    pub(super) fn transposed(&self) -> RationalMatrix {
        RationalMatrix::from_fn(self.columns, self.nrows(), |i, j| self.at(j, i).clone())
    }

    pub(super) fn plus(mut self, other: &RationalMatrix) -> RationalMatrix {
        for (i, j, entry) in other.nonzeros() {
            *self.at_mut(i, j) += entry;
        }
        self
    }

    pub(super) fn minus(mut self, other: &RationalMatrix) -> RationalMatrix {
        for (i, j, entry) in other.nonzeros() {
            *self.at_mut(i, j) -= entry;
        }
        self
    }

    /// X with `self` X = `right`, where `self` is square; `None` where it is singular. By Gauss and
    /// Jordan's elimination without fractions (E. H. Bareiss, *Sylvester's identity and multistep
    /// integer-preserving Gaussian elimination*, Math. Comp. 22, 1968).
    pub(super) fn solve(&self, right: &RationalMatrix) -> Option<RationalMatrix> {
        let n = self.nrows();
        if self.nonzeros().all(|(i, j, _)| i == j) {
            let regular = (0..n).all(|i| !self.at(i, i).is_zero());
            let quotient = |i: usize, j: usize| right.at(i, j) / self.at(i, i);
            return regular.then(|| RationalMatrix::from_fn(n, right.columns, quotient));
        }
        let mut rows: Vec<Vec<BigInt>> = (0..n)
            .map(|i| whole(self.rows[i].iter().chain(&right.rows[i])))
            .collect();
        let mut before = BigInt::one();
        for k in 0..n {
            let pivot = (k..n).find(|i| !rows[*i][k].is_zero())?;
            rows.swap(k, pivot);
            let leading = rows[k].clone();
            for (_, row) in rows.iter_mut().enumerate().filter(|(i, _)| *i != k) {
                let factor = row[k].clone();
                for (entry, above) in row.iter_mut().zip(&leading) {
                    // Each entry becomes a minor of the matrix, so that the division is exact.
                    *entry = (&*entry * &leading[k] - &factor * above) / &before;
                }
            }
            before = leading[k].clone();
        }
        let quotient =
            |i: usize, j: usize| BigRational::new(rows[i][n + j].clone(), rows[i][i].clone());
        Some(RationalMatrix::from_fn(n, right.columns, quotient))
    }

    /// Columns that span what `self` maps to 0, and its independent columns.
    pub(super) fn null_space(&self) -> (RationalMatrix, Vec<usize>) {
        let mut reduced = self.clone();
        let pivots = reduced.reduce();
        let free: Vec<usize> = (0..self.columns).filter(|j| !pivots.contains(j)).collect();
        let mut space = RationalMatrix::zeros(self.columns, free.len());
        for (column, &j) in free.iter().enumerate() {
            *space.at_mut(j, column) = BigRational::one();
            for (row, &pivot) in pivots.iter().enumerate() {
                *space.at_mut(pivot, column) = -reduced.at(row, j);
            }
        }
        (space, pivots)
    }

    /// Brings it to reduced row echelon form; the columns of its pivots.
    fn reduce(&mut self) -> Vec<usize> {
        let mut pivots = Vec::new();
        for column in 0..self.columns {
            let top = pivots.len();
            let below = (top..self.nrows()).filter(|i| !self.rows[*i][column].is_zero());
            // The shortest pivot keeps the numbers short.
            let length = |i: &usize| {
                let entry = &self.rows[*i][column];
                entry.numer().bits() + entry.denom().bits()
            };
            let Some(pivot) = below.min_by_key(length) else {
                continue;
            };
            self.rows.swap(top, pivot);
            let inverse = self.rows[top][column].recip();
            for entry in self.rows[top].iter_mut().filter(|entry| !entry.is_zero()) {
                *entry *= &inverse;
            }
            let leading = self.rows[top].clone();
            for (i, row) in self.rows.iter_mut().enumerate() {
                if i == top || row[column].is_zero() {
                    continue;
                }
                let factor = row[column].clone();
                for (entry, above) in row.iter_mut().zip(&leading) {
                    if !above.is_zero() {
                        *entry -= &factor * above;
                    }
                }
            }
            pivots.push(column);
        }
        pivots
    }
}

/// Fractions times their least common denominator.
fn whole<'a>(fractions: impl Iterator<Item = &'a BigRational> + Clone) -> Vec<BigInt> {
    let denominators = fractions.clone().map(BigRational::denom);
    let common = denominators.fold(BigInt::one(), |lcm, denominator| lcm.lcm(denominator));
    let numerators = fractions.map(|fraction| fraction.numer() * (&common / fraction.denom()));
    numerators.collect()
}
