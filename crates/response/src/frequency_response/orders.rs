//! How often the determinants of a function vanish at 0 and at ∞, in exact arithmetic: with K + λC + λ²M bordered by input and
//! output, H is minus the ratio of the two determinants.

use std::cell::OnceCell;
use std::collections::BTreeMap;

use eigentone_digits::DoubleDouble;
use eigentone_modes::{BuildError, MatrixKind, System};
use faer::Mat;

/// More take too long.
const MOST: usize = 64;

/// Row, column and, by powers of λ, the doubles whose sums stand there.
pub(super) type Terms = (usize, usize, [Vec<f64>; 3]);

/// The bordered equations as real matrices.
pub(super) struct Orders {
    /// The number of coordinates: one less than there are rows.
    n: usize,
    terms: Option<Vec<Terms>>,
    known: OnceCell<[Option<Order>; 2]>,
}

/// Of a determinant as a polynomial in λ.
#[derive(Clone, Copy)]
pub(super) struct Order {
    /// The least power.
    pub(super) least: usize,
    /// The largest.
    pub(super) most: usize,
}

impl Orders {
    /// `None` for what is not real.
    pub(super) fn of(n: usize, terms: Option<Vec<Terms>>) -> Orders {
        Orders {
            n,
            terms,
            known: OnceCell::new(),
        }
    }

    /// Whether H is 0 at every λ, as the bordered determinant is.
    pub(super) fn is_zero(&self) -> bool {
        let bordered = || matches!(&self.terms, Some(terms) if system(self.n + 1, terms).is_err_and(|error| error == BuildError::Singular));
        self.n <= MOST && self.get()[1].is_none() && bordered()
    }

    /// Those of the determinant of the system, and of the bordered one; `None` where they are not proved.
    pub(super) fn get(&self) -> [Option<Order>; 2] {
        let find = || match &self.terms {
            Some(terms) if self.n <= MOST => [self.n, self.n + 1].map(|size| order(size, terms)),
            _ => [None; 2],
        };
        *self.known.get_or_init(find)
    }
}

/// That of the first rows and columns.
fn order(size: usize, terms: &[Terms]) -> Option<Order> {
    let system = system(size, terms).ok()?;
    let structure = system.structure();
    Some(Order {
        least: structure.zero_roots()?,
        most: structure.finite_roots()?,
    })
}

/// What has this determinant. What a sum has beside one double stands in a copy of its column: another coordinate without mass, which
/// equals the first and changes no determinant.
fn system(size: usize, terms: &[Terms]) -> Result<System, BuildError> {
    let mut copies = BTreeMap::new();
    let mut entries = Vec::new();
    let own = terms.iter();
    for (row, column, powers) in own.filter(|(row, column, _)| *row < size && *column < size) {
        for (power, terms) in powers.iter().enumerate() {
            for (k, part) in parts(terms).into_iter().enumerate() {
                let next = size + copies.len();
                let at = match k {
                    0 => *column,
                    _ => *copies.entry((*column, k)).or_insert(next),
                };
                entries.push((power, row, at, part));
            }
        }
    }
    let size = size + copies.len();
    let mut matrices = [(); 3].map(|()| Mat::<f64>::zeros(size, size));
    for (power, row, column, part) in entries {
        matrices[power][(*row, column)] = part;
    }
    for ((column, _), copy) in copies {
        matrices[0][(copy, copy)] = 1.0;
        matrices[0][(copy, column)] = -1.0;
    }
    let kinds = [MatrixKind::Stiffness, MatrixKind::Damping, MatrixKind::Mass];
    let all = kinds.into_iter().zip(&matrices);
    let builder = all.fold(System::builder(), |builder, (kind, matrix)| {
        builder.matrix(kind, matrix.as_ref())
    });
    builder.build()
}

/// Doubles with the same sum, most often fewer; not finite where it leaves their range.
pub(super) fn parts(terms: &[f64]) -> Vec<f64> {
    let mut parts: Vec<f64> = Vec::new();
    for &term in terms {
        let mut rest = term;
        for part in &mut parts {
            let sum = DoubleDouble::from(*part) + DoubleDouble::from(rest);
            (*part, rest) = (sum.high(), sum.low());
        }
        parts.push(rest);
        parts.retain(|part| *part != 0.0);
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_the_same_sum() {
        assert_eq!(parts(&[0.1, -0.1]), Vec::<f64>::new());
        assert_eq!(parts(&[16_812.0, 190_000.0, 0.5]), [206_812.5]);
        assert_eq!(parts(&[1.0, 1e-40]), [1.0, 1e-40]);
        assert_eq!(parts(&[1e300, 1.0, -1e300]), [1.0]);
    }

    /// (0.1 + 0.2 − s)(1 + λ) with s = 0.1 + 0.2 as the doubles are, and with the double nearest to it.
    #[test]
    fn sums_that_are_no_double_are_exact() {
        let of = |s: &[f64]| {
            let sum: Vec<f64> = [0.1, 0.2].iter().chain(s).copied().collect();
            let terms = [
                (0, 0, [vec![1.0], vec![1.0], vec![]]),
                (0, 1, [vec![], vec![], vec![0.1, 0.2]]),
                (1, 1, [sum, vec![0.1, 0.2], vec![]]),
            ];
            order(2, &terms).map(|order| (order.least, order.most))
        };
        assert_eq!(of(&[-0.1, -0.2]), Some((1, 2)));
        assert_eq!(of(&[-(0.1 + 0.2)]), Some((0, 2)));
    }
}
