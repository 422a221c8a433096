//! The roots of a squarefree polynomial, each in a disc of its own.
//!
//! The disc about z with radius N |p(z)/p′(z)|, N the degree, holds a root (E. Laguerre; P. Henrici,
//! *Applied and Computational Complex Analysis* I, theorem 6.4e), for p′/p is the sum of the N terms
//! 1/(z − root). Where N such discs do not touch, each holds exactly one. A disc about a real number
//! that holds one root of a real polynomial holds a real one: its conjugate would be another.

use super::aberth::{evaluate, improve, start};
use super::ball::Ball;
use super::complex::Complex;
use super::error::ReferenceError;
use super::integer_polynomial::IntegerPolynomial;

const FIRST_BITS: u64 = 128;
const MOST_BITS: u64 = 1 << 14;

/// All roots of a squarefree polynomial with p(0) ≠ 0, real ones with an imaginary part that is 0
/// exactly, others in conjugate pairs; every part to `digits` digits of itself, or to 2·`digits` of
/// the modulus.
pub(super) fn roots(
    polynomial: &IntegerPolynomial,
    digits: u32,
) -> Result<Vec<Complex>, ReferenceError> {
    let mut approximations = start(polynomial);
    let mut bits = FIRST_BITS;
    loop {
        improve(polynomial, &mut approximations, bits);
        let isolated = isolate(polynomial, &approximations, bits);
        if let Some(roots) =
            isolated.filter(|roots| roots.iter().all(|root| is_known(root, digits)))
        {
            return Ok(roots);
        }
        if bits >= MOST_BITS {
            return Err(ReferenceError::TooManyBits { digits, bits });
        }
        bits *= 2;
    }
}

/// Whether both parts have their digits.
pub(super) fn is_known(root: &Complex, digits: u32) -> bool {
    let digits = f64::from(digits) * std::f64::consts::LOG2_10;
    let least = root.log2() - digits;
    let known = |part: &Ball| part.radius_log2() <= part.log2().max(least) - digits;
    known(&root.re) && known(&root.im)
}

/// A root in each disc, if they are disjoint.
fn isolate(
    polynomial: &IntegerPolynomial,
    approximations: &[Complex],
    bits: u64,
) -> Option<Vec<Complex>> {
    let degree = Ball::from(polynomial.degree() as i64);
    let mut discs = Vec::with_capacity(approximations.len());
    for centre in approximations {
        let (value, slope) = evaluate(polynomial, &centre.rounded(bits));
        let radius = &degree * (&value.modulus() / slope.modulus());
        if radius.is_unknown() {
            return None;
        }
        // A disc that meets the real axis is replaced by one about a real number that covers it.
        let meets = !(centre.im.abs() - &radius).is_positive();
        let (centre, radius) = match meets {
            true => (Complex::real(centre.re.clone()), radius + centre.im.abs()),
            false => (centre.clone(), radius),
        };
        discs.push((centre, radius));
    }
    for (i, (centre, radius)) in discs.iter().enumerate() {
        for (other, reach) in &discs[..i] {
            let distance = (centre - other).modulus();
            if !(distance - radius - reach).is_positive() {
                return None;
            }
        }
    }
    let mut roots = Vec::with_capacity(discs.len());
    for (centre, radius) in discs {
        if centre.im.is_zero() {
            roots.push(Complex::real(centre.re.widened(&radius)));
        } else if centre.im.is_positive() {
            let root = Complex {
                re: centre.re.widened(&radius),
                im: centre.im.widened(&radius),
            };
            roots.push(root.clone());
            roots.push(root.conjugate());
        }
    }
    Some(roots)
}
