//! The inverse of the dynamic stiffness at one frequency, in doubles, and a proven bound of what it leaves.

use eigentone_digits::{Ball, ComplexDoubleDouble, DoubleDouble, Lu, WideComplex};
use faer::Mat;
use num_complex::Complex;

use super::columns::Columns;
use super::elimination::Row;
use super::refinement::{ApproximateInverse, FLOOR, UPWARD, largest};

/// S ≈ Z⁻¹.
pub(super) struct Inverse {
    /// The real and the imaginary part of Z.
    parts: [Columns<DoubleDouble>; 2],
    inverse: Mat<Complex<f64>>,
    /// |S|.
    size: Mat<f64>,
    lengths: Vec<f64>,
    norm: f64,
}

impl Inverse {
    /// Of rows whose entries are about 1 at most; `None` where their inverse in doubles proves nothing.
    pub(super) fn of(rows: &[Row<DoubleDouble>]) -> Option<Inverse> {
        let n = rows.len();
        let mut z = Mat::<Complex<f64>>::zeros(n, n);
        let mut z_size = Mat::<f64>::zeros(n, n);
        // By how much the doubles are off, apart from rounding.
        let mut off = Mat::<f64>::zeros(n, n);
        for (i, row) in rows.iter().enumerate() {
            for &(j, entry) in row {
                let middle = entry.middle();
                z[(i, j)] = Complex::new(middle.re.to_f64(), middle.im.to_f64());
                z_size[(i, j)] = entry.upper().to_f64();
                off[(i, j)] = entry.radius().to_f64() + FLOOR;
                if !z_size[(i, j)].is_finite() {
                    return None;
                }
            }
        }
        let inverse = Lu::of(z.as_ref()).inverse();
        let size = Mat::from_fn(n, n, |i, j| inverse[(i, j)].norm() * UPWARD);
        let defect = &inverse * z;
        let one = Mat::from_fn(n, 1, |_, _| 1.0);
        let lengths = &size * one;
        // Rounding of Z and of sums of complex products (Higham 2002, section 3.6).
        let rounding = (4 * n + 32) as f64 * f64::EPSILON;
        let lost = (faer::Scale(rounding) * z_size + off) * &lengths;
        let lost = &size * lost;
        let ratios = (0..n).map(|i| {
            let terms = (0..n).map(|j| {
                let own = if i == j { 1.0 } else { 0.0 };
                (defect[(i, j)] - own).norm() * lengths[(j, 0)]
            });
            (terms.sum::<f64>() + lost[(i, 0)]) / lengths[(i, 0)]
        });
        let norm = largest(ratios) * UPWARD;
        let lengths = lengths.col_as_slice(0).to_vec();
        let entries = || {
            let rows = rows.iter().enumerate();
            rows.flat_map(|(i, row)| row.iter().map(move |&(j, entry)| (i, j, entry)))
        };
        let imaginary = entries().map(|(i, j, entry)| {
            let part = WideComplex {
                re: entry.middle().im,
                im: DoubleDouble::ZERO,
            };
            (i, j, Ball::from(part))
        });
        (norm < 0.5).then(|| Inverse {
            parts: [Columns::of(n, entries()), Columns::of(n, imaginary)],
            inverse,
            size,
            lengths,
            norm,
        })
    }
}

impl ApproximateInverse<DoubleDouble> for Inverse {
    fn apply(&self, right: &[Complex<f64>]) -> Vec<ComplexDoubleDouble> {
        let mut x = vec![Complex::<f64>::ZERO; right.len()];
        for (j, value) in right
            .iter()
            .enumerate()
            .filter(|(_, f)| **f != Complex::ZERO)
        {
            let column = self.inverse.col_as_slice(j);
            x.iter_mut()
                .zip(column)
                .for_each(|(x, entry)| *x += entry * value);
        }
        x.into_iter()
            .map(|x| ComplexDoubleDouble::new(x.re, x.im))
            .collect()
    }

    fn sizes(&self, right: &[f64]) -> Vec<f64> {
        let mut x = vec![FLOOR; right.len()];
        for (j, value) in right.iter().enumerate() {
            let column = self.size.col_as_slice(j);
            x.iter_mut()
                .zip(column)
                .for_each(|(x, size)| *x += size * value);
        }
        x.iter().map(|size| size * UPWARD).collect()
    }

    fn times(&self, x: &[Ball<DoubleDouble>]) -> Vec<Ball<DoubleDouble>> {
        let turned = |x: &Ball<DoubleDouble>| {
            let WideComplex { re, im } = x.middle();
            Ball::new(WideComplex { re: -im, im: re }, x.radius())
        };
        let turned: Vec<Ball<DoubleDouble>> = x.iter().map(turned).collect();
        let [real, imaginary] = &self.parts;
        let parts = real.times(x).into_iter().zip(imaginary.times(&turned));
        parts.map(|(real, imaginary)| real + imaginary).collect()
    }

    fn defect(&self) -> (&[f64], f64) {
        (&self.lengths, self.norm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frequency_response::elimination::{Factor, Outcome};
    use crate::frequency_response::random::Random;
    use eigentone_digits::{Magnitude, Real, Wide};

    fn ball<T: Real>(value: Complex<f64>) -> Ball<T> {
        Ball::from(WideComplex {
            re: value.re.into(),
            im: value.im.into(),
        })
    }

    fn rows<T: Real>(of: &Mat<Complex<f64>>) -> Vec<Row<T>> {
        let row = |i| (0..of.ncols()).map(move |j| (j, ball(of[(i, j)])));
        (0..of.nrows()).map(|i| row(i).collect()).collect()
    }

    /// A matrix of random numbers, its last row the first one but for this difference.
    fn nearly_singular(n: usize, difference: f64) -> Mat<Complex<f64>> {
        let mut numbers = Random(7);
        let mut random = || 0.5 * numbers.signed();
        let mut matrix = Mat::from_fn(n, n, |_, _| Complex::new(random(), random()));
        for j in 0..n {
            let change = Complex::new(random(), random()) * difference;
            matrix[(n - 1, j)] = matrix[(0, j)] + change;
        }
        matrix
    }

    #[test]
    fn solutions_of_more_digits_are_enclosed() {
        for (n, difference) in [(3, 1.0), (20, 1.0), (40, 1e-5), (24, 1e-9)] {
            let matrix = nearly_singular(n, difference);
            let (rows, exact) = (rows(&matrix), rows::<Wide<8>>(&matrix));
            let inverse = Inverse::of(&rows).expect("it is regular");
            let (Outcome::Regular(factor), _) = Factor::of(exact) else {
                panic!("it is regular");
            };
            let right = |i: usize| Complex::new(1.0 / (1.0 + i as f64), 0.25);
            let found = inverse.solve(&(0..n).map(|i| ball(right(i))).collect::<Vec<_>>());
            let truth = factor.solve((0..n).map(|i| ball(right(i))).collect());
            for (found, truth) in found.expect("finite").into_iter().zip(truth) {
                let middle = found.middle();
                let middle = Ball::from(WideComplex {
                    re: Wide::<8>::from(middle.re.high()) + Wide::from(middle.re.low()),
                    im: Wide::<8>::from(middle.im.high()) + Wide::from(middle.im.low()),
                });
                let off = (truth - middle).upper();
                assert!(off <= found.radius(), "{n} {difference}: {off:?}");
                let size = truth.upper().to_f64();
                assert!(
                    found.radius().to_f64() < 1e-20 * size / difference,
                    "{n} {difference}"
                );
            }
        }
    }

    /// A row of zeros as well: its inverse is no number.
    #[test]
    fn nothing_is_proved_of_a_singular_matrix() {
        for difference in [0.0, 1e-16] {
            assert!(Inverse::of(&rows(&nearly_singular(9, difference))).is_none());
        }
        for empty in [0, 4, 8] {
            let mut matrix = nearly_singular(9, 1.0);
            (0..9).for_each(|j| matrix[(empty, j)] = Complex::ZERO);
            assert!(Inverse::of(&rows(&matrix)).is_none());
        }
    }

    #[test]
    fn the_radius_of_an_entry_is_counted() {
        let matrix = nearly_singular(6, 1.0);
        let mut rows: Vec<Row<DoubleDouble>> = rows(&matrix);
        rows[2][4].1 = Ball::new(rows[2][4].1.middle(), 1e-9.into());
        let inverse = Inverse::of(&rows).expect("it is regular");
        let right: Vec<_> = (0..6).map(|_| ball(Complex::ONE)).collect();
        let found = inverse.solve(&right).expect("finite");
        for change in [1e-9, -1e-9] {
            let mut other = matrix.clone();
            other[(2, 4)] += change;
            let rows = self::rows(&other);
            let moved = Inverse::of(&rows).and_then(|inverse| inverse.solve(&right));
            for (found, moved) in found.iter().zip(moved.expect("it is regular")) {
                let off = Ball::from(found.middle()) - Ball::from(moved.middle());
                let most = found.radius() + moved.radius();
                assert!(off.lower() <= most, "{off:?}");
                assert!(found.radius() < Magnitude::from(1e-7), "{found:?}");
            }
        }
    }
}
