//! Modal masses, dampings and stiffnesses of real shapes, summed over the elements.
//!
//! A spring contributes k·(x_a − x_b)², which keeps soft springs beside stiff ones, as the assembled
//! K does not; the quotient k/m is stationary in x, so that it errs by the square of what the shape
//! does (Rayleigh).

use std::cell::LazyCell;

use eigentone_digits::{DoubleDouble, Lanes, Real, product};
use faer::{ColRef, Mat, MatRef};
use pulp::Arch;

use crate::model::{Element, MatrixKind, Node};
use crate::system::System;

/// xᵀMx, xᵀCx and xᵀKx of a real shape x.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RealForms {
    pub(crate) m: DoubleDouble,
    pub(crate) c: DoubleDouble,
    pub(crate) k: DoubleDouble,
    /// About how far m, c and k may be off where full matrices are summed in doubles; 0 elsewhere.
    pub(crate) rounding: [f64; 3],
}

/// Shapes that are taken at a time.
const LANES: usize = 8;

/// How the entries of given matrices are summed; elements always are in double-double.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Entries {
    /// In doubles, by products of whole matrices, where there are many coordinates: no better than
    /// the frequencies that come from such matrices in doubles.
    Plain,
    /// In double-double.
    Exact,
    /// In double-double, for shapes that are right to the last digit.
    Refined,
}

impl RealForms {
    /// Those of many shapes, together.
    pub(crate) fn of(system: &System, shapes: &[&[f64]], entries: Entries) -> Vec<RealForms> {
        RealForms::with_products(system, shapes, entries).0
    }

    /// The same with MX and KX in doubles, of shapes as columns of X, where they were computed on the way.
    pub(crate) fn with_products(
        system: &System,
        shapes: &[&[f64]],
        entries: Entries,
    ) -> (Vec<RealForms>, Option<[Mat<f64>; 2]>) {
        let mut all = of_elements(system, shapes);
        let kinds = [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness];
        let n = system.len();
        let columns = LazyCell::new(|| Mat::from_fn(n, shapes.len(), |i, j| shapes[j][i]));
        let mut applied = [None, None, None];
        for (kind, matrix) in kinds.into_iter().enumerate() {
            let tails = system.model().tails(matrix);
            let alone = system.model().is_added_alone(matrix);
            let Some(matrix) = system.added(matrix) else {
                continue;
            };
            let sums: Vec<(DoubleDouble, f64)> = if entries == Entries::Plain && is_full(matrix) {
                let columns = columns.as_ref();
                let products = product(matrix, columns);
                let sums = forms_of(matrix, columns, &products);
                applied[kind] = Some(products).filter(|_| alone);
                sums
            } else {
                let columns = entries_of(matrix);
                let exact = |x: &&[f64]| (quadratic_form(&columns, x), 0.0);
                shapes.iter().map(exact).collect()
            };
            for ((forms, x), (mut sum, rounding)) in all.iter_mut().zip(shapes).zip(sums) {
                for tail in tails {
                    sum += DoubleDouble::product(x[tail.row], x[tail.column]).mul_f64(tail.value);
                }
                *[&mut forms.m, &mut forms.c, &mut forms.k][kind] += sum;
                forms.rounding[kind] = rounding;
            }
        }
        let applied = match applied {
            [Some(m), _, Some(k)] => Some([m, k]),
            _ => None,
        };
        (all, applied)
    }

    /// k/m in doubles.
    pub(crate) fn quotient(&self) -> f64 {
        (self.k / self.m).to_f64()
    }

    /// How far k/m may be off, relative.
    pub(crate) fn quotient_error(&self) -> f64 {
        let [m, _, k] = self.rounding;
        m / self.m.to_f64().abs() + k / self.k.to_f64().abs()
    }
}

/// The elements' shares of the forms of all shapes.
fn of_elements(system: &System, shapes: &[&[f64]]) -> Vec<RealForms> {
    let zero = RealForms {
        m: DoubleDouble::ZERO,
        c: DoubleDouble::ZERO,
        k: DoubleDouble::ZERO,
        rounding: [0.0; 3],
    };
    let is_of_matrices = system.masses().iter().all(|mass| *mass == 0.0)
        && system.dampers().is_empty()
        && system.springs().is_empty();
    if is_of_matrices {
        return vec![zero; shapes.len()];
    }
    let mut columns = vec![[0.0; LANES]; system.len()];
    let mut all = Vec::with_capacity(shapes.len());
    for block in shapes.chunks(LANES) {
        for (lane, x) in block.iter().enumerate() {
            for (column, x) in columns.iter_mut().zip(*x) {
                column[lane] = *x;
            }
        }
        let [m, c, k] = Arch::new().dispatch(|| sums(system, &columns));
        all.extend(block.iter().enumerate().map(|(lane, x)| {
            let forms = RealForms {
                m: m.get(lane),
                c: c.get(lane),
                k: k.get(lane),
                ..zero
            };
            let parts = [forms.m, forms.c, forms.k];
            if !parts.iter().all(|part| part.to_f64().is_finite()) {
                return by_elements(system, x);
            }
            forms
        }));
    }
    all
}

/// The elements' shares of the three forms.
#[inline(always)]
fn sums(system: &System, columns: &[[f64; LANES]]) -> [Lanes<LANES>; 3] {
    const GROUND: [f64; LANES] = [0.0; LANES];
    let at = |node: Node| node.coordinate().map_or(&GROUND, |i| &columns[i]);
    let elements = |elements: &[Element]| {
        let mut sum = Lanes::ZERO;
        for element in elements {
            sum.add_square(element.coefficient, at(element.first), at(element.second));
        }
        sum
    };
    let mut mass = Lanes::ZERO;
    for (factor, column) in system.masses().iter().zip(columns) {
        mass.add_square(*factor, column, &GROUND);
    }
    [mass, elements(system.dampers()), elements(system.springs())]
}

/// The elements' shares where numbers leave the range of the splitting.
fn by_elements(system: &System, x: &[f64]) -> RealForms {
    let at = |node: Node| DoubleDouble::from(node.coordinate().map_or(0.0, |i| x[i]));
    let elements = |elements: &[Element]| {
        elements.iter().fold(DoubleDouble::ZERO, |sum, element| {
            let stretch = at(element.first) - at(element.second);
            sum + (stretch * stretch).mul_f64(element.coefficient)
        })
    };
    let masses = system.masses().iter().zip(x);
    RealForms {
        m: masses.fold(DoubleDouble::ZERO, |sum, (mass, x)| {
            sum + DoubleDouble::product(*x, *x).mul_f64(*mass)
        }),
        c: elements(system.dampers()),
        k: elements(system.springs()),
        rounding: [0.0; 3],
    }
}

/// Whether a product with all entries is quicker than one that skips zeros.
fn is_full(matrix: MatRef<'_, f64>) -> bool {
    const MANY: usize = 32;
    const FULL: usize = 8;
    let n = matrix.nrows();
    let filled: usize = matrix
        .col_iter()
        .map(|column| column.iter().filter(|entry| **entry != 0.0).count())
        .sum();
    n > MANY && FULL * filled > n * n
}

/// xᵀAx of all columns x from AX, and about how far each may be off: roundings of so many terms are seen to add up to few
/// units of |x|ᵀ|A||x|. This is summed over blocks of rows, in which the norms of a column of A and of x stand for their entries
/// (Cauchy's inequality).
fn forms_of(
    matrix: MatRef<'_, f64>,
    columns: MatRef<'_, f64>,
    products: &Mat<f64>,
) -> Vec<(DoubleDouble, f64)> {
    const UNITS: f64 = 2.0 * f64::EPSILON;
    const ROWS: usize = 8;
    let n = matrix.nrows();
    // Squares stay within the range of doubles.
    let unit = matrix.norm_max();
    let norm = |entries: ColRef<'_, f64>, unit: f64| {
        let squares = entries.iter().map(|x| (x / unit) * (x / unit));
        unit * squares.sum::<f64>().sqrt()
    };
    let block = |matrix: MatRef<'_, f64>, row: usize, j: usize, unit: f64| {
        let rows = ROWS.min(n - row);
        norm(matrix.col(j).subrows(row, rows), unit)
    };
    let norms = Mat::from_fn(n.div_ceil(ROWS), n, |i, j| block(matrix, ROWS * i, j, unit));
    let sizes = Mat::from_fn(n, columns.ncols(), |i, j| columns[(i, j)].abs());
    let shares = product(norms.as_ref(), sizes.as_ref());
    let each = (0..columns.ncols()).map(|j| {
        let sum = products.col(j).transpose() * columns.col(j);
        let blocks = shares.col(j).iter().enumerate();
        let size: f64 = blocks
            .map(|(i, share)| block(columns, ROWS * i, j, 1.0) * share)
            .sum();
        (DoubleDouble::from(sum), UNITS * size)
    });
    each.collect()
}

/// The rows and values of the entries that are not 0, column by column.
fn entries_of(matrix: MatRef<'_, f64>) -> Vec<Vec<(usize, f64)>> {
    let column = |j| {
        let entries = matrix.col(j).iter().copied().enumerate();
        entries.filter(|(_, entry)| *entry != 0.0).collect()
    };
    (0..matrix.ncols()).map(column).collect()
}

/// xᵀAx.
fn quadratic_form(columns: &[Vec<(usize, f64)>], x: &[f64]) -> DoubleDouble {
    let mut form = DoubleDouble::ZERO;
    for (column, xj) in columns.iter().zip(x) {
        let products = column
            .iter()
            .map(|(i, entry)| DoubleDouble::product(*entry, x[*i]));
        let sum = products.fold(DoubleDouble::ZERO, |sum, product| sum + product);
        form += sum.mul_f64(*xj);
    }
    form
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::samples::network;

    /// Sums of powers of two, beyond those that can be split: the soft spring is 70 bits below the stiff one, and the
    /// light mass 60 below the heavy one.
    #[test]
    fn coefficients_near_the_end_of_the_range_keep_their_digits() {
        let two = |power: i32| 2f64.powi(power);
        let springs = [(1, 2, two(1010)), (0, 1, two(940))];
        let system = network(&[two(1000), two(940)], &springs, &[(2, 0, two(1005))]);
        let shapes: [&[f64]; 2] = [&[1.0, -0.5], &[0.25, 1.0]];
        let found = RealForms::of(&system, &shapes, Entries::Exact);
        for (forms, [x, y]) in found.iter().zip([[1.0, -0.5], [0.25, 1.0]]) {
            assert_eq!(
                (forms.m.high(), forms.m.low()),
                (x * x * two(1000), y * y * two(940))
            );
            assert_eq!((forms.c.high(), forms.c.low()), (y * y * two(1005), 0.0));
            let stiff = (x - y) * (x - y) * two(1010);
            assert_eq!((forms.k.high(), forms.k.low()), (stiff, x * x * two(940)));
        }
    }

    /// Of a matrix of ones xᵀAx is (Σx)², in doubles and with more digits.
    #[test]
    fn full_matrices_are_summed_by_products_too() {
        let n = 40;
        let ones = Mat::from_fn(n, n, |_, _| 1.0);
        let system = (0..n)
            .fold(System::builder(), |b, i| b.mass(format!("m{i}"), 1.0))
            .matrix(MatrixKind::Stiffness, ones.as_ref())
            .build()
            .unwrap();
        let rising: Vec<f64> = (0..n).map(|i| i as f64).collect();
        let alternating: Vec<f64> = (0..n).map(|i| [3.0, -2.0][i % 2]).collect();
        for entries in [Entries::Plain, Entries::Exact] {
            let found = RealForms::of(&system, &[&rising, &alternating], entries);
            let k: Vec<f64> = found.iter().map(|forms| forms.k.to_f64()).collect();
            assert_eq!(k, [780.0 * 780.0, 20.0 * 20.0], "{entries:?}");
        }
    }

    /// 12 N/m over 3 kg.
    #[test]
    fn the_quotient_is_the_square_of_the_frequency() {
        let system = network(&[3.0], &[(0, 1, 12.0)], &[]);
        let forms = RealForms::of(&system, &[&[1.0]], Entries::Exact);
        assert_eq!(forms[0].quotient(), 4.0);
    }
}
