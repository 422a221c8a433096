//! M and K in many digits, without the coordinates that have no mass.

use eigentone_digits::Real;

use crate::linear::wide::{Rows, solve};
use crate::model::{MatrixKind, Model};

/// M and K of the coordinates with mass, which those without mass follow.
pub(crate) struct Condensed<T> {
    pub(crate) massless: Vec<usize>,
    pub(crate) massive: Vec<usize>,
    pub(crate) mass: Rows<T>,
    pub(crate) stiffness: Rows<T>,
    /// How those without mass follow the others: x of the former is −`follow`·x of the latter.
    pub(crate) follow: Rows<T>,
}

impl<T: Real> Condensed<T> {
    /// `None` where springs do not hold the coordinates without mass.
    pub(crate) fn of(model: &Model) -> Option<Condensed<T>> {
        let n = model.len();
        let [mass, stiffness] =
            [MatrixKind::Mass, MatrixKind::Stiffness].map(|kind| dense(model, kind));
        let (massless, massive): (Vec<usize>, Vec<usize>) =
            (0..n).partition(|&i| mass[i].iter().all(|entry: &T| *entry == T::ZERO));
        let block = |rows: &Rows<T>, of: &[usize], with: &[usize]| -> Rows<T> {
            let row = |i: &usize| with.iter().map(|j| rows[*i][*j]).collect();
            of.iter().map(row).collect()
        };
        let mut condensed = block(&stiffness, &massive, &massive);
        let mut follow = Vec::new();
        if !massless.is_empty() {
            follow = solve(
                block(&stiffness, &massless, &massless),
                block(&stiffness, &massless, &massive),
            )?;
            for (row, beside) in condensed
                .iter_mut()
                .zip(block(&stiffness, &massive, &massless))
            {
                for (force, moved) in beside.into_iter().zip(&follow) {
                    for (entry, moved) in row.iter_mut().zip(moved) {
                        *entry = *entry - force * *moved;
                    }
                }
            }
        }
        let mass = block(&mass, &massive, &massive);
        Some(Condensed {
            massless,
            massive,
            mass,
            stiffness: condensed,
            follow,
        })
    }
}

/// One of the matrices with all its digits.
pub(crate) fn dense<T: Real>(model: &Model, kind: MatrixKind) -> Rows<T> {
    let n = model.len();
    let mut rows: Rows<T> = vec![vec![T::ZERO; n]; n];
    for term in model.terms(kind) {
        let entry = &mut rows[term.row][term.column];
        *entry = *entry + T::from(term.value);
    }
    rows
}
