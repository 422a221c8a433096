//! Equations in which motions that K leaves free have rows and columns of their own, and the powers of λ that a column has in
//! common are divided out: with Z = K + λC + λ²M, K r = 0 and a row c that reads nothing of r, (Z, c) r = λ(C r + λM r, 0), so that
//! the equations are regular at 0 wherever what c reads has a limit there. With rows that are sums of rows by r, and a column
//! that is one of columns, no determinant changes.

use std::collections::BTreeMap;

use eigentone_digits::DoubleDouble;

use super::dynamic_stiffness::polynomial;
use super::orders::{Terms, parts};
use super::power_series::Polynomial;

/// Row and column, and by powers of λ the doubles whose sums stand there.
type Placed = ((usize, usize), [Vec<f64>; 3]);

/// The equations of n coordinates, bordered by input and output, in Ω.
pub(super) struct Split {
    pub(super) entries: BTreeMap<(usize, usize), Polynomial>,
    /// The powers that columns were divided by, with the columns.
    pub(super) lowered: Vec<(usize, usize)>,
}

impl Split {
    /// By vectors that begin with a 1 where all others are 0; `None` where a product is not exact.
    pub(super) fn of(n: usize, terms: &[Terms], free: &[Vec<(usize, f64)>]) -> Option<Split> {
        let mut all: BTreeMap<(usize, usize), [Vec<f64>; 3]> = BTreeMap::new();
        for (row, column, powers) in terms {
            let entry = all.entry((*row, *column)).or_default();
            for (sum, own) in entry.iter_mut().zip(powers) {
                sum.extend(own);
            }
        }
        // Of columns, and then of rows.
        for transposed in [false, true] {
            let turn = |(i, j): (usize, usize)| if transposed { (j, i) } else { (i, j) };
            for vector in free {
                let (own, others) = vector.split_first()?;
                let added: Vec<Placed> = all
                    .iter()
                    .filter_map(|(place, powers)| {
                        let (along, across) = turn(*place);
                        let (_, by) = others.iter().find(|(i, _)| *i == across)?;
                        let scaled = powers.each_ref().map(|sum| products(sum, *by));
                        Some((turn((along, own.0)), scaled))
                    })
                    .map(|(place, scaled)| {
                        let [a, b, c] = scaled;
                        Some((place, [a?, b?, c?]))
                    })
                    .collect::<Option<_>>()?;
                for (place, powers) in added {
                    let entry = all.entry(place).or_default();
                    for (sum, more) in entry.iter_mut().zip(powers) {
                        sum.extend(more);
                        *sum = parts(sum);
                    }
                }
            }
        }
        for sum in all.values_mut().flatten() {
            *sum = parts(sum);
            if !sum.iter().all(|part| part.is_finite()) {
                return None;
            }
        }
        let common = |column: usize| {
            let own = all.iter().filter(|((_, at), _)| *at == column);
            let least = own.filter_map(|(_, powers)| powers.iter().position(|sum| !sum.is_empty()));
            least.min().unwrap_or(0)
        };
        let places = free.iter().filter_map(|vector| Some(vector.first()?.0));
        let lowered: Vec<(usize, usize)> = places
            .filter(|column| *column < n)
            .map(|column| (column, common(column)))
            .filter(|(_, power)| *power > 0)
            .collect();
        let entries = all.into_iter().map(|(place, powers)| {
            let mut polynomial = polynomial(&powers);
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

/// Doubles whose sum is that of some others times a factor; `None` where these are not exact.
fn products(terms: &[f64], factor: f64) -> Option<Vec<f64>> {
    if factor == 1.0 {
        return Some(terms.to_vec());
    }
    let terms = terms.iter().filter(|term| **term != 0.0);
    let products = terms.map(|term| {
        let product = DoubleDouble::product(*term, factor);
        let is_exact = (1e-200..f64::INFINITY).contains(&product.high().abs());
        is_exact.then_some([product.high(), product.low()])
    });
    let products: Option<Vec<[f64; 2]>> = products.collect();
    Some(products?.concat())
}
