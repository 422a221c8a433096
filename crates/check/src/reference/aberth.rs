//! Approximations of all roots of a polynomial at once, by the iteration of Ehrlich and Aberth from
//! starting values on the Newton polygon (D. A. Bini, *Numerical computation of polynomial zeros by
//! means of Aberth's method*, Numer. Algorithms 13, 1996).

use super::ball::Ball;
use super::complex::Complex;
use super::integer_polynomial::IntegerPolynomial;

/// The bits of the sum over all other roots, which only steers.
const STEERING_BITS: u64 = 64;

/// Sweeps after which what is left is left to more bits.
const MOST_SWEEPS: usize = 200;

/// p(z) and p′(z), by Horner's rule.
pub(super) fn evaluate(polynomial: &IntegerPolynomial, z: &Complex) -> (Complex, Complex) {
    let zero = || Complex::real(Ball::zero());
    let mut pair = (zero(), zero());
    for coefficient in polynomial.coefficients().iter().rev() {
        let (value, slope) = &pair;
        let slope = &(slope * z) + value;
        let mut value = value * z;
        value.re = value.re + Ball::from(coefficient.clone());
        pair = (value, slope);
    }
    pair
}

/// Starting values for the roots of a polynomial with p(0) ≠ 0: on each edge of the upper hull of
/// the points (k, log₂|a_k|) as many as it is wide, on a circle whose radius is its slope.
pub(super) fn start(polynomial: &IntegerPolynomial) -> Vec<Complex> {
    let sizes: Vec<f64> = polynomial
        .coefficients()
        .iter()
        .map(|c| Ball::from(c.clone()).log2())
        .collect();
    let slope = |a: usize, b: usize| (sizes[b] - sizes[a]) / (b - a) as f64;
    let mut hull: Vec<usize> = Vec::new();
    for k in (0..sizes.len()).filter(|k| sizes[*k].is_finite()) {
        while let [.., a, b] = hull[..]
            && slope(a, b) <= slope(b, k)
        {
            hull.pop();
        }
        hull.push(k);
    }
    let circle = |edge: &[usize]| {
        let (from, to) = (edge[0], edge[1]);
        let log = -slope(from, to);
        let (power, size) = (log.floor(), (log - log.floor()).exp2());
        (from..to).map(move |j| {
            // An offset keeps them away from the real axis, and from each other's conjugates.
            let turn = std::f64::consts::TAU / (to - from) as f64;
            let (sin, cos) = (turn * (j - from) as f64 + 0.7 + from as f64).sin_cos();
            let part = |value: f64| {
                let part = Ball::exactly(size * value).unwrap_or_else(Ball::zero);
                part.scaled(power as i64)
            };
            Complex {
                re: part(cos),
                im: part(sin),
            }
        })
    };
    hull.windows(2).flat_map(circle).collect()
}

/// Moves `roots` towards the roots of the polynomial until each is one to `bits` bits.
pub(super) fn improve(polynomial: &IntegerPolynomial, roots: &mut [Complex], bits: u64) {
    let mut moving: Vec<usize> = (0..roots.len()).collect();
    for root in roots.iter_mut() {
        *root = root.rounded(bits).midpoint();
    }
    for _ in 0..MOST_SWEEPS {
        moving.retain(|&i| {
            let (value, slope) = evaluate(polynomial, &roots[i]);
            if value.contains_zero() {
                return false;
            }
            let newton = (&value.midpoint() / &slope.midpoint()).midpoint();
            let one = Complex::real(Ball::from(1).with_bits(STEERING_BITS));
            let mut others = Complex::real(Ball::zero());
            for (_, root) in roots.iter().enumerate().filter(|(j, _)| *j != i) {
                let gap = (&roots[i] - root).midpoint().rounded(STEERING_BITS);
                others = &others + &(&one / &gap);
            }
            let step = &newton / &(&one - &(&newton * &others.midpoint()));
            if step.re.is_unknown() || step.im.is_unknown() {
                // Two coincide, or the slope vanishes: any move helps.
                let aside = Complex {
                    re: Ball::from(1025),
                    im: Ball::from(1),
                };
                let moved = &roots[i] * &aside;
                roots[i] = Complex {
                    re: moved.re.scaled(-10),
                    im: moved.im.scaled(-10),
                }
                .rounded(bits)
                .midpoint();
                return true;
            }
            let moved = (&roots[i] - &step.midpoint()).rounded(bits).midpoint();
            let settled = step.log2() < moved.log2() - bits as f64 + 4.0;
            roots[i] = moved;
            !settled
        });
        if moving.is_empty() {
            break;
        }
    }
}
