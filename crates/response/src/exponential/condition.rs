//! How far rounding of the matrix moves its exponential.

use std::cell::Cell;

use eigentone_digits::{Magnitude, Real};
use faer::{Mat, MatRef};

use super::aligned::Aligned;
use super::dense::Dense;
use super::dual::{Dual, Pair};
use super::error::{ExpmError, check};
use super::growth::Growth;
use super::norm::{column_sums, largest, norm, norm_one};
use super::paths::Paths;
use super::polynomial::{Degree, Powers, evaluate};
use super::precise::{Judge, LIMIT, precisely};
use super::scales::scales;
use super::scaling::needed;
use super::squaring::{MEANINGFUL, square};
use super::taylor::{first_shift, otherwise, taylor};
use crate::enclosed::Normed;

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
/// [`expm`](super::expm) gains there shows as an error below κ·2^-53. It is infinite beyond the largest double.
///
/// Where doubles lose the exponential, L comes from that of [A, E; 0, A] with more digits.
///
/// # Errors
/// [`ExpmError`] for a matrix that is not square or has an entry that is not finite, and where that takes more
/// digits than can be afforded.
pub fn expm_condition(a: MatRef<'_, f64>) -> Result<f64, ExpmError> {
    check(a)?;
    if a.norm_max() == 0.0 || a.nrows() == 0 {
        return Ok(0.0);
    }
    if a.nrows() == 1 {
        return Ok(a[(0, 0)].abs());
    }
    let derivative = Derivative::of(a);
    let found = if a.nrows() <= EXACT {
        derivative.largest()
    } else {
        derivative.power_method()
    };
    found.ok_or(ExpmError::TooManyDigits { order: a.nrows() })
}

/// Up to this order all extreme points are tried.
const EXACT: usize = 4;

/// E ↦ ‖A‖ L(A, E) / ‖e^A‖.
struct Derivative<'a> {
    a: MatRef<'a, f64>,
    n: usize,
    scaled: Aligned,
    norm: f64,
    shift: i32,
    /// Those of [`scales`], where doubles do not serve.
    exponents: Option<Vec<i64>>,
    /// What may still be spent on more digits.
    left: Cell<f64>,
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
        let serve = shift.unsigned_abs() <= MEANINGFUL && doubles_serve(a);
        Derivative {
            a,
            n,
            norm: norm_one(n, &scaled),
            scaled,
            shift,
            exponents: (!serve).then(|| scales(a, &Paths::of(a).classes())),
            left: Cell::new(LIMIT),
        }
    }

    /// The derivative in direction `e`, column by column.
    fn along(&self, e: &[f64]) -> Option<Aligned> {
        match &self.exponents {
            None => Some(self.in_doubles(e)),
            Some(exponents) => self.precisely(e, exponents),
        }
    }

    fn precisely(&self, e: &[f64], exponents: &[i64]) -> Option<Aligned> {
        let n = self.n;
        let shift = |i: usize, j: usize| exponents[j] - exponents[i];
        let unscaled = (0..n * n).filter(|at| e[*at] != 0.0);
        let sizes = unscaled.map(|at| e[at].abs().log2().ceil() as i64 + shift(at % n, at / n));
        let size = sizes.max()?;
        let mut entries = Vec::with_capacity(4 * n * n);
        for i in 0..2 * n {
            entries.extend((0..2 * n).map(|j| match (i < n, j < n) {
                (true, true) => (self.a[(i, j)], shift(i, j)),
                (true, false) => (e[i + n * (j - n)], shift(i, j - n) - size),
                (false, true) => (0.0, 0),
                (false, false) => (self.a[(i - n, j - n)], shift(i - n, j - n)),
            }));
        }
        let quotient = Quotient { exponents, size };
        let mut left = self.left.get();
        let result = precisely(2 * n, 3 * n * n, &entries, &quotient, &mut left);
        self.left.set(left);
        let mut result = result?;
        // ‖A‖ may be beyond the largest double where the product is not.
        let factor = self.norm;
        let undone = i64::from(self.shift);
        result
            .iter_mut()
            .for_each(|entry| *entry = (*entry * factor).scale(undone));
        Some(Aligned::from(&result[..]))
    }

    /// With 2^-s A and e, not 2^-s e, it comes out
    /// 2^s times too large, which ‖2^-s A‖ in place of ‖A‖ makes good.
    fn in_doubles(&self, e: &[f64]) -> Aligned {
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
        let result = square(&mut algebra, less_one, self.shift.unsigned_abs(), || {
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
    fn adjoint(&self, signs: &[f64], j: usize) -> Option<Vec<f64>> {
        let n = self.n;
        let mut transposed = vec![0.0; n * n];
        for (i, sign) in signs.iter().enumerate() {
            transposed[i * n + j] = *sign;
        }
        let result = self.along(&transposed)?;
        let back = (0..n * n).map(|index| result[(index % n) * n + index / n]);
        Some(back.collect())
    }

    /// The norm, by all extreme points: one signed unit vector a column.
    fn largest(&self) -> Option<f64> {
        let n = self.n;
        let unit = |index: usize| {
            let mut e = vec![0.0; n * n];
            e[index] = 1.0;
            self.along(&e)
        };
        let all: Vec<Aligned> = (0..n * n).map(unit).collect::<Option<_>>()?;
        // Sums of what is beyond the doubles would not be numbers.
        if all
            .iter()
            .any(|image| image.iter().any(|entry| entry.is_infinite()))
        {
            return Some(f64::INFINITY);
        }
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
        Some(best)
    }

    /// A lower bound of the norm by ascents from the identity and from even columns.
    fn power_method(&self) -> Option<f64> {
        const ASCENTS: usize = 4;
        let n = self.n;
        let identity = (0..n * n).map(|index| f64::from(u8::from(index % (n + 1) == 0)));
        let even = vec![1.0 / n as f64; n * n];
        let (mut best, mut ascended) = (0.0, false);
        for start in [identity.collect(), even] {
            let mut e: Vec<f64> = start;
            let mut reached = 0.0;
            for ascent in 0..ASCENTS {
                // The best of one ascent is a lower bound, as that of four is.
                let Some(image) = self.along(&e) else {
                    return ascended.then_some(best);
                };
                let sums = column_sums(n, &image);
                let norm = largest(&sums);
                if norm.is_nan() {
                    return None;
                }
                if norm.is_infinite() {
                    return Some(norm);
                }
                best = largest(&[best, norm]);
                ascended |= ascent > 0;
                if norm <= reached {
                    break;
                }
                reached = norm;
                let j = position_of_largest(&sums);
                let signs: Vec<f64> = image[j * n..(j + 1) * n]
                    .iter()
                    .map(|entry| if *entry < 0.0 { -1.0 } else { 1.0 })
                    .collect();
                let Some(gradient) = self.adjoint(&signs, j) else {
                    return ascended.then_some(best);
                };
                e = vec![0.0; n * n];
                for (column, gradient) in e.chunks_exact_mut(n).zip(gradient.chunks_exact(n)) {
                    let sizes: Vec<f64> = gradient.iter().map(|entry| entry.abs()).collect();
                    let i = position_of_largest(&sizes);
                    column[i] = if gradient[i] < 0.0 { -1.0 } else { 1.0 };
                }
            }
        }
        Some(best)
    }
}

/// Whether two ways in doubles find the same exponential, of A less its mean growth.
fn doubles_serve(a: MatRef<'_, f64>) -> bool {
    const VISIBLE: f64 = 1e-6;
    let n = a.nrows();
    let mean = (0..n).map(|i| a[(i, i)] / n as f64).sum::<f64>();
    let moved = Mat::from_fn(n, n, |i, j| a[(i, j)] - if i == j { mean } else { 0.0 });
    let (found, _, _) = taylor(moved.as_ref());
    let size = norm(found.as_ref());
    size.is_finite() && norm((&found - otherwise(moved.as_ref())).as_ref()) <= VISIBLE * size
}

/// 2^`size` L(A, E)/‖e^A‖ from the exponential of [A, 2^-`size` E; 0, A], scaled by `exponents`; column by column.
struct Quotient<'a> {
    exponents: &'a [i64],
    size: i64,
}

impl Judge for Quotient<'_> {
    type Verdict = Vec<f64>;

    fn least(&self) -> f64 {
        // However small it is, its digits count.
        f64::INFINITY
    }

    fn judge<T: Real>(&self, power: &Normed<T>, _: i64) -> Option<(Vec<f64>, bool)> {
        /// Six digits are plenty.
        const ENOUGH: i64 = -20;
        let n = self.exponents.len();
        let largest_column = |first: usize, more: i64| {
            let mut largest = [Magnitude::ZERO; 2];
            for j in 0..n {
                let mut sums = [Magnitude::ZERO; 2];
                for i in 0..n {
                    let shift = self.exponents[i] - self.exponents[j] + more;
                    let factor = Magnitude::power_of_two(shift);
                    sums[0] = sums[0] + power.row(i)[first + j].upper() * factor;
                    sums[1] = sums[1] + power.error() * factor;
                }
                for (largest, sum) in largest.iter_mut().zip(sums) {
                    *largest = if sum > *largest { sum } else { *largest };
                }
            }
            largest
        };
        let ([value, value_error], [size, error]) =
            (largest_column(0, 0), largest_column(n, self.size));
        // In the direction of the identity it is e^A itself: beside that it counts.
        let scale = if size > value { size } else { value };
        let enough = Magnitude::power_of_two(ENOUGH);
        if value_error > value * enough || error > scale * enough {
            return None;
        }
        let exponent = value.exponent();
        let divisor = (value * Magnitude::power_of_two(-exponent)).to_f64();
        let mut result = Vec::with_capacity(n * n);
        for j in 0..n {
            result.extend((0..n).map(|i| {
                let shift = self.exponents[i] - self.exponents[j] + self.size - exponent;
                power.row(i)[n + j].scale(shift).to_f64() / divisor
            }));
        }
        Some((result, true))
    }
}

fn position_of_largest(values: &[f64]) -> usize {
    (0..values.len()).fold(0, |best, i| if values[i] > values[best] { i } else { best })
}
