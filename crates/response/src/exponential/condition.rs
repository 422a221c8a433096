//! How far rounding of the matrix moves its exponential.

use faer::MatRef;

use super::ExpmError;
use super::aligned::Aligned;
use super::dense::Dense;
use super::dual::{Dual, Pair};
use super::expm::check;
use super::growth::Growth;
use super::norm::{column_sums, largest, norm_one};
use super::polynomial::{Degree, Powers, evaluate};
use super::scaling::needed;
use super::squaring::square;
use super::taylor::first_shift;

/// The relative condition number of e^A in the 1-norm: κ = max ‖L(A, E)‖·‖A‖ / (‖E‖·‖e^A‖) over
/// all E, where L is the Fréchet derivative of the exponential (Higham 2008, *Functions of Matrices*,
/// section 3.1). Rounding A to doubles alone may change e^A by κ·2^-53, relative to its norm.
///
/// L(A, E) comes from the products and squarings of the exponential itself with matrices A + εE, ε² =
/// 0 (Al-Mohy & Higham 2009, *Computing the Fréchet derivative of the matrix exponential*, SIAM J.
/// Matrix Anal. 30). Up to order 4 the maximum is taken over all extreme points E of the unit ball of
/// the norm, and exact up to rounding. Beyond, it is a lower bound, nearly always within a small
/// factor: Boyd's power method for mixed norms (1974, *Linear Algebra Appl.* 9; Higham 1992,
/// *Numer. Math.* 62), where the adjoint of L(A, ·) is Lᵀ(A, ·ᵀ). It costs about as much as thirty
/// exponentials. It is 0 for A = 0, at least ‖A‖ always, and not changed by balancing: what
/// [`expm`](super::expm) gains there shows as an error below κ·2^-53.
///
/// # Errors
/// [`ExpmError`] for a matrix that is not square or has an entry that is not finite.
pub fn expm_condition(a: MatRef<'_, f64>) -> Result<f64, ExpmError> {
    check(a)?;
    if a.norm_max() == 0.0 || a.nrows() == 0 {
        return Ok(0.0);
    }
    let derivative = Derivative::of(a);
    Ok(if a.nrows() <= EXACT {
        derivative.largest()
    } else {
        derivative.power_method()
    })
}

/// Up to this order all extreme points are tried.
const EXACT: usize = 4;

/// E ↦ ‖A‖ L(A, E) / ‖e^A‖.
struct Derivative<'a> {
    a: MatRef<'a, f64>,
    n: usize,
    scaled: Aligned,
    norm: f64,
    squarings: u32,
}

impl Derivative<'_> {
    fn of(a: MatRef<'_, f64>) -> Derivative<'_> {
        let n = a.nrows();
        let first = first_shift(a);
        let mut dense = Dense::new(n);
        let start = dense.load(a, first);
        // The plain norm serves: squarings to spare cost time, not digits.
        let shift = first + needed(norm_one(n, &start));
        let scaled = dense.load(a, shift);
        Derivative {
            a,
            n,
            norm: norm_one(n, &scaled),
            scaled,
            squarings: shift.unsigned_abs(),
        }
    }

    /// The derivative in direction `e`, column by column. With 2^-s A and e, not 2^-s e, it comes out
    /// 2^s times too large, which ‖2^-s A‖ in place of ‖A‖ makes good.
    fn along(&self, e: &[f64]) -> Aligned {
        let mut algebra = Dual::new(self.n);
        let a = Pair {
            value: self.scaled.clone(),
            derivative: Aligned::from(e),
        };
        let (a2, a3) = (None, None);
        let powers = Powers {
            a,
            a2,
            a3,
            factor: 1.0,
        };
        let less_one = evaluate(&mut algebra, Degree::TwentyOne, powers);
        let result = square(&mut algebra, less_one, self.squarings, || {
            Growth::of(self.a)
        });
        let Pair {
            value,
            mut derivative,
        } = result.element;
        let factor = self.norm / norm_one(self.n, &value);
        derivative.iter_mut().for_each(|entry| *entry *= factor);
        derivative
    }

    /// The adjoint, on the matrix that is `signs` in column `j` and 0 elsewhere.
    fn adjoint(&self, signs: &[f64], j: usize) -> Vec<f64> {
        let n = self.n;
        let mut transposed = vec![0.0; n * n];
        for (i, sign) in signs.iter().enumerate() {
            transposed[i * n + j] = *sign;
        }
        let result = self.along(&transposed);
        (0..n * n)
            .map(|index| result[(index % n) * n + index / n])
            .collect()
    }

    /// The norm, by all extreme points: one signed unit vector a column.
    fn largest(&self) -> f64 {
        let n = self.n;
        let unit = |index: usize| {
            let mut e = vec![0.0; n * n];
            e[index] = 1.0;
            self.along(&e)
        };
        let all: Vec<Aligned> = (0..n * n).map(unit).collect();
        let mut best = 0.0;
        for j in 0..n {
            for signs in 0..1u32 << (n - 1) {
                let entry = |index: usize| -> f64 {
                    let column = &all[index][j * n..(j + 1) * n];
                    let signed = column.iter().enumerate().map(|(row, entry)| {
                        if signs >> row & 1 == 1 {
                            -entry
                        } else {
                            *entry
                        }
                    });
                    signed.sum()
                };
                let columns = (0..n).map(|k| {
                    let sizes: Vec<f64> = (0..n).map(|i| entry(k * n + i).abs()).collect();
                    largest(&sizes)
                });
                best = largest(&[best, columns.sum()]);
            }
        }
        best
    }

    /// A lower bound of the norm by ascents from the identity and from even columns.
    fn power_method(&self) -> f64 {
        const ASCENTS: usize = 4;
        let n = self.n;
        let identity = (0..n * n).map(|index| f64::from(u8::from(index % (n + 1) == 0)));
        let even = vec![1.0 / n as f64; n * n];
        let mut best = 0.0;
        for start in [identity.collect(), even] {
            let mut e: Vec<f64> = start;
            let mut reached = 0.0;
            for _ in 0..ASCENTS {
                let image = self.along(&e);
                let sums = column_sums(n, &image);
                let norm = largest(&sums);
                if norm.is_nan() {
                    return norm;
                }
                best = largest(&[best, norm]);
                if norm <= reached {
                    break;
                }
                reached = norm;
                let j = position_of_largest(&sums);
                let signs: Vec<f64> = image[j * n..(j + 1) * n]
                    .iter()
                    .map(|entry| if *entry < 0.0 { -1.0 } else { 1.0 })
                    .collect();
                let gradient = self.adjoint(&signs, j);
                e = vec![0.0; n * n];
                for (column, gradient) in e.chunks_exact_mut(n).zip(gradient.chunks_exact(n)) {
                    let sizes: Vec<f64> = gradient.iter().map(|entry| entry.abs()).collect();
                    let i = position_of_largest(&sizes);
                    column[i] = if gradient[i] < 0.0 { -1.0 } else { 1.0 };
                }
            }
        }
        best
    }
}

fn position_of_largest(values: &[f64]) -> usize {
    (0..values.len()).fold(0, |best, i| if values[i] > values[best] { i } else { best })
}
