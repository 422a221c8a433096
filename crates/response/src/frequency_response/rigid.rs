//! Equations in which motions that K leaves free have rows and columns of their own, and the powers of λ that a column has in
//! common are divided out: with Z = K + λC + λ²M, K r = 0 and a row c that reads nothing of r, (Z, c) r = λ(C r + λM r, 0), so that
//! the equations are regular at 0 wherever what c reads has a limit there. With rows that are sums of rows by r, and a column
//! that is one of columns, no determinant changes.

use std::collections::BTreeMap;

use eigentone_digits::parts;

use super::dynamic_stiffness::{complex_polynomial, products};
use super::orders::Equations;
use super::power_series::Polynomial;

/// By powers of λ the doubles whose sums multiply 1, and those that multiply i.
type Powers = [[Vec<f64>; 3]; 2];

/// What stands in a row and column.
type Placed = ((usize, usize), Powers);

/// The equations of n coordinates, bordered by input and output, in Ω.
pub(super) struct Split {
    pub(super) entries: BTreeMap<(usize, usize), Polynomial>,
    /// The powers that columns were divided by, with the columns.
    pub(super) lowered: Vec<(usize, usize)>,
}

impl Split {
    /// By vectors that begin with a 1 where all others are 0, one of which may begin in the column of the input; `None` where a product is
    /// not exact.
    pub(super) fn of(n: usize, exact: &Equations, free: &[Vec<(usize, f64)>]) -> Option<Split> {
        let mut all: BTreeMap<(usize, usize), Powers> = BTreeMap::new();
        for (kind, terms) in [&exact.real, &exact.imaginary].into_iter().enumerate() {
            for (row, column, powers) in terms {
                let entry = &mut all.entry((*row, *column)).or_default()[kind];
                for (sum, own) in entry.iter_mut().zip(powers) {
                    sum.extend(own);
                }
            }
        }
        // Of columns, and then of rows.
        for transposed in [false, true] {
            let turn = |(i, j): (usize, usize)| if transposed { (j, i) } else { (i, j) };
            for vector in free {
                let (own, others) = vector.split_first()?;
                if transposed && own.0 == n {
                    continue; // the output stays
                }
                let added: Vec<Placed> = all
                    .iter()
                    .filter_map(|(place, powers)| {
                        let (along, across) = turn(*place);
                        let (_, by) = others.iter().find(|(i, _)| *i == across)?;
                        Some((turn((along, own.0)), scaled(powers, *by)))
                    })
                    .map(|(place, scaled)| Some((place, scaled?)))
                    .collect::<Option<_>>()?;
                for (place, powers) in added {
                    let entry = all.entry(place).or_default().iter_mut().flatten();
                    for (sum, more) in entry.zip(powers.into_iter().flatten()) {
                        sum.extend(more);
                        *sum = parts(sum);
                    }
                }
            }
        }
        for sum in all.values_mut().flatten().flatten() {
            *sum = parts(sum);
            if !sum.iter().all(|part| part.is_finite()) {
                return None;
            }
        }
        let common = |column: usize| {
            let own = all.iter().filter(|((_, at), _)| *at == column);
            let least = own.flat_map(|(_, powers)| powers).filter_map(|powers| {
                let mut sums = powers.iter();
                sums.position(|sum| !sum.is_empty())
            });
            least.min().unwrap_or(0)
        };
        let places = free.iter().filter_map(|vector| Some(vector.first()?.0));
        let lowered: Vec<(usize, usize)> = places
            .filter(|column| *column < n)
            .map(|column| (column, common(column)))
            .filter(|(_, power)| *power > 0)
            .collect();
        let entries = all.into_iter().map(|(place, [real, imaginary])| {
            let mut polynomial = complex_polynomial(&real, &imaginary);
            let down = lowered.iter().find(|(column, _)| *column == place.1);
            if let Some((_, power)) = down {
                polynomial.rotate_left(*power);
            }
            (place, polynomial)
        });
        let entries = entries.collect();
        Some(Split { entries, lowered })
    }
}

/// All of them times a factor; `None` where that is not exact.
fn scaled(powers: &Powers, factor: f64) -> Option<Powers> {
    let mut scaled = powers.clone();
    for sum in scaled.iter_mut().flatten() {
        *sum = products(sum, factor)?;
    }
    Some(scaled)
}
