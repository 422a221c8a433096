//! How often the determinants of a function vanish at 0 and at ∞, in exact arithmetic: with K + λC + λ²M bordered by input and
//! output, H is minus the ratio of the two determinants. Springs with losses make the coefficients complex, A + iB. The real matrix of
//! twice the size with rows (A, −B) and (B, A) has the determinant D·D̄, D̄ with the conjugate coefficients of D, so that it vanishes
//! twice as often.

use std::cell::OnceCell;
use std::collections::BTreeMap;

use eigentone_digits::parts;
use eigentone_modes::{BuildError, MatrixKind, System, null_vectors};
use faer::Mat;

/// More rows take too long.
const MOST: usize = 65;

/// Row, column and, by powers of λ, the doubles whose sums stand there.
pub(super) type Terms = (usize, usize, [Vec<f64>; 3]);

/// The bordered equations as exact sums.
pub(super) struct Orders {
    /// The number of coordinates: one less than there are rows.
    n: usize,
    equations: Option<Equations>,
    known: OnceCell<[Option<Order>; 2]>,
}

/// Their coefficients, real for real λ but for losses.
#[derive(Debug, Default)]
pub(super) struct Equations {
    pub(super) real: Vec<Terms>,
    pub(super) imaginary: Vec<Terms>,
}

impl Equations {
    /// Adds doubles times i^turns λ^power; `None` for powers that no quantity has.
    pub(super) fn add(
        &mut self,
        (row, column): (usize, usize),
        (power, turns): (i32, u8),
        doubles: impl IntoIterator<Item = f64>,
    ) -> Option<()> {
        let terms = match turns % 2 {
            0 => &mut self.real,
            _ => &mut self.imaginary,
        };
        let sign = if turns % 4 < 2 { 1.0 } else { -1.0 };
        let at = terms
            .iter()
            .position(|term| (term.0, term.1) == (row, column));
        let at = at.unwrap_or_else(|| {
            terms.push((row, column, Default::default()));
            terms.len() - 1
        });
        let sum = terms[at].2.get_mut(usize::try_from(power).ok()?)?;
        sum.extend(doubles.into_iter().map(|value| sign * value));
        Some(())
    }

    /// The motion of n coordinates that balances the input at rest, as a vector of all columns; none where losses aside it is no short
    /// binary fraction.
    pub(super) fn carried(&self, n: usize) -> Vec<Vec<(usize, f64)>> {
        let real = self.real.iter().filter(|(row, ..)| *row < n);
        let parts = real.flat_map(|(row, column, powers)| {
            let own = powers[0].iter();
            own.map(|part| (*row, *column, *part))
        });
        null_vectors(n + 1, parts.collect())
    }

    /// How many times as often the determinant of the real matrices vanishes.
    fn copies(&self) -> usize {
        if self.imaginary.is_empty() { 1 } else { 2 }
    }

    /// Real matrices for the first rows and columns.
    fn leading(&self, size: usize) -> Result<System, BuildError> {
        let within = |(row, column, _): &&Terms| *row < size && *column < size;
        let real = self.real.iter().filter(within);
        if self.copies() == 1 {
            let terms: Vec<Terms> = real.cloned().collect();
            return system(size, &terms);
        }
        let moved = |(row, column, powers): &Terms, [down, right]: [usize; 2], sign: f64| {
            let powers = powers.each_ref();
            let powers = powers.map(|sum| sum.iter().map(|value| sign * value).collect());
            (row + down, column + right, powers)
        };
        let real = real.flat_map(|term| [0, size].map(|by| moved(term, [by; 2], 1.0)));
        let imaginary = self.imaginary.iter().filter(within);
        let imaginary =
            imaginary.flat_map(|term| [moved(term, [0, size], -1.0), moved(term, [size, 0], 1.0)]);
        let terms: Vec<Terms> = real.chain(imaginary).collect();
        system(2 * size, &terms)
    }

    /// That of the first rows and columns.
    fn order(&self, size: usize) -> Option<Order> {
        let system = self.leading(size).ok()?;
        let structure = system.structure();
        Some(Order {
            least: structure.zero_roots()? / self.copies(),
            most: structure.finite_roots()? / self.copies(),
        })
    }
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
    /// `None` for what is not exact.
    pub(super) fn of(n: usize, equations: Option<Equations>) -> Orders {
        Orders {
            n,
            equations,
            known: OnceCell::new(),
        }
    }

    /// Those that do not take too long.
    fn equations(&self) -> Option<&Equations> {
        let few = |equations: &&Equations| (self.n + 1) * equations.copies() <= MOST;
        self.equations.as_ref().filter(few)
    }

    /// Whether H is 0 at every λ, as the bordered determinant is.
    pub(super) fn is_zero(&self) -> bool {
        let singular = |equations: &Equations| {
            let bordered = equations.leading(self.n + 1);
            bordered.is_err_and(|error| error == BuildError::Singular)
        };
        self.get()[1].is_none() && self.equations().is_some_and(singular)
    }

    /// Those of the determinant of the system, and of the bordered one; `None` where they are not proved.
    pub(super) fn get(&self) -> [Option<Order>; 2] {
        let find = || {
            let equations = self.equations();
            [self.n, self.n + 1].map(|size| equations?.order(size))
        };
        *self.known.get_or_init(find)
    }
}

/// What has this determinant. What a sum has beside one double stands in a copy of its column: another coordinate without mass, which
/// equals the first and changes no determinant.
fn system(size: usize, terms: &[Terms]) -> Result<System, BuildError> {
    let mut copies = BTreeMap::new();
    let mut entries = Vec::new();
    for (row, column, powers) in terms {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// (0.1 + 0.2 − s)(1 + λ) with s = 0.1 + 0.2 as the doubles are, and with the double nearest to it.
    #[test]
    fn sums_that_are_no_double_are_exact() {
        let of = |s: &[f64]| {
            let sum: Vec<f64> = [0.1, 0.2].iter().chain(s).copied().collect();
            let real = vec![
                (0, 0, [vec![1.0], vec![1.0], vec![]]),
                (0, 1, [vec![], vec![], vec![0.1, 0.2]]),
                (1, 1, [sum, vec![0.1, 0.2], vec![]]),
            ];
            let equations = Equations {
                real,
                ..Equations::default()
            };
            let order = equations.order(2);
            order.map(|order| (order.least, order.most))
        };
        assert_eq!(of(&[-0.1, -0.2]), Some((1, 2)));
        assert_eq!(of(&[-(0.1 + 0.2)]), Some((0, 2)));
    }
    /// i(0.1 + 0.2)(1 + λ) − i s with s = 0.1 + 0.2 as the doubles are, and with the double nearest to it.
    #[test]
    fn complex_coefficients_count_once() {
        let of = |s: &[f64]| {
            let mut equations = Equations::default();
            equations.add((0, 0), (0, 0), [1.0]).unwrap();
            equations.add((0, 0), (1, 0), [1.0]).unwrap();
            equations.add((0, 1), (0, 1), s.iter().copied()).unwrap();
            equations.add((1, 0), (0, 2), [-1.0]).unwrap();
            equations.add((1, 1), (0, 3), [-0.1, -0.2]).unwrap();
            let order = equations.order(2);
            order.map(|order| (order.least, order.most))
        };
        assert_eq!(of(&[0.1, 0.2]), Some((1, 1)));
        assert_eq!(of(&[0.1 + 0.2]), Some((0, 1)));
    }
}
