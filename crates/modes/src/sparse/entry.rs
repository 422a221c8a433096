//! Numbers that a factor can be made of.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Sub, SubAssign};

use eigentone_digits::{DoubleDouble, Real, settle};
use faer::linalg::matmul::matmul;
use faer::traits::ComplexField;
use faer::{Accum, MatMut, MatRef, Par};
use num_complex::Complex;

/// A number that a factor can be made of.
pub(crate) trait Entry:
    Copy
    + Debug
    + PartialEq
    + From<f64>
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + SubAssign
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// The relative error of one operation, rounded up.
    const UNIT: f64;

    fn rounded(value: DoubleDouble) -> Self;

    /// |x|, in doubles.
    fn size(self) -> f64;

    /// Whether sums of such numbers do not cancel: x ≥ 0, or within an eighth of a turn of that.
    fn adds_up(self) -> bool;

    /// Whether x is real and negative.
    fn is_negative(self) -> bool;

    /// C − A Bᵀ in place of C, whose columns are needed from the diagonal down.
    fn subtract_product(c: MatMut<'_, Self>, a: MatRef<'_, Self>, b: MatRef<'_, Self>) {
        subtract_each(c, a, b);
    }
}

/// Entry by entry.
fn subtract_each<T: Entry>(mut c: MatMut<'_, T>, a: MatRef<'_, T>, b: MatRef<'_, T>) {
    for j in 0..c.ncols() {
        let rows = c.nrows() - j;
        for k in 0..a.ncols() {
            let factor = b[(j, k)];
            let target = c.as_mut().col_mut(j).subrows_mut(j, rows);
            let pairs = target.iter_mut().zip(a.col(k).subrows(j, rows).iter());
            pairs.for_each(|(y, x)| *y -= *x * factor);
        }
    }
}

/// By faer's product, unless it is small.
fn subtract_whole<T: Entry + ComplexField>(c: MatMut<'_, T>, a: MatRef<'_, T>, b: MatRef<'_, T>) {
    const SMALL: usize = 2000;
    if c.nrows() * c.ncols() * a.ncols() < SMALL {
        return subtract_each(c, a, b);
    }
    let minus = T::from(-1.0);
    matmul(c, Accum::Add, a, b.transpose(), minus, Par::Seq);
    settle();
}

impl Entry for f64 {
    const UNIT: f64 = f64::EPSILON / 2.0;

    fn rounded(value: DoubleDouble) -> f64 {
        value.high()
    }

    fn size(self) -> f64 {
        self.abs()
    }

    fn adds_up(self) -> bool {
        self >= 0.0
    }

    fn is_negative(self) -> bool {
        self < 0.0
    }

    fn subtract_product(c: MatMut<'_, Self>, a: MatRef<'_, Self>, b: MatRef<'_, Self>) {
        subtract_whole(c, a, b);
    }
}

impl Entry for DoubleDouble {
    const UNIT: f64 = {
        assert!(<DoubleDouble as Real>::UNIT_LOG2 <= -98);
        // 2^-98.
        f64::from_bits((1023 - 98) << 52)
    };

    fn rounded(value: DoubleDouble) -> DoubleDouble {
        value
    }

    fn size(self) -> f64 {
        self.high().abs()
    }

    fn adds_up(self) -> bool {
        self.high() >= 0.0
    }

    fn is_negative(self) -> bool {
        self.high() < 0.0
    }
}

impl Entry for Complex<f64> {
    const UNIT: f64 = 4.0 * f64::EPSILON;

    fn rounded(value: DoubleDouble) -> Complex<f64> {
        Complex::from(value.high())
    }

    fn size(self) -> f64 {
        self.norm()
    }

    fn adds_up(self) -> bool {
        self.re >= self.im.abs()
    }

    fn is_negative(self) -> bool {
        false
    }

    fn subtract_product(c: MatMut<'_, Self>, a: MatRef<'_, Self>, b: MatRef<'_, Self>) {
        subtract_whole(c, a, b);
    }
}
