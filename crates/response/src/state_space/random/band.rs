//! The integral of the resolvent over a band of frequencies, Φ = Re ∫ (iω − A)⁻¹ dω, for an A of which nothing grows.
//!
//! Along any way from iω₁ to iω₂ on which no pole lies it is the same. A piece from m − h to m + h gives 2 artanh X with
//! X = h(m − A)⁻¹ where a power of X contracts: the logarithm of the two ends' quotient, exact for multiple poles too, with no branch to
//! be chosen. Where poles stand close to the band, the way leads through the right half-plane, where their distance grows
//! with each piece: as many pieces as there are powers of 4 between the width of the band and the distance of its ends from
//! the nearest pole.

use eigentone_digits::{BallMatrix, Magnitude, Real};

use crate::enclosed::Normed;
use crate::problem::Known;

/// The most that X may be, or the root of one of its powers.
const CONTRACTION: f64 = 0.8;

/// How many pieces a way may have, and how often one is shortened.
const PIECES: usize = 4000;

/// Φ for the band of angular frequencies; `None` where the digits of T do not suffice.
pub(super) fn of_band<T: Real>(a: &Normed<T>, band: [Known<T>; 2]) -> Option<Normed<T>> {
    let way = Way { a };
    let [(low, below), (high, above)] = band;
    let half = T::from(0.5);
    let (middle, width) = ((low + high) * half, high - low);
    let off = below + above + high.upper() * T::unit() * Magnitude::from(8.0);
    let mut right = T::ZERO;
    // The piece along the band itself, or parallel to it at a distance at which X contracts.
    let along = loop {
        if let Some(piece) = way.piece([right, middle], Half::Up(width * half)) {
            break piece;
        }
        right = match right.is_zero() {
            true => T::ONE.scale(width.upper().exponent()),
            false => right.scale(2),
        };
        if right.upper().exponent() > width.upper().exponent() + 64 {
            return None;
        }
    };
    // Ends that are off by so much change it by ‖R‖off/(1 − ‖R‖off).
    let moved = along.ends * off;
    if moved >= Magnitude::from(0.5) {
        return None;
    }
    let along = along.integral.im.with_more_error(moved + moved);
    // ∫ (iω − A)⁻¹ dω = −i ∫ (z − A)⁻¹ dz.
    if right.is_zero() {
        return Some(along);
    }
    let (there, back) = (way.leg(low, below, right)?, way.leg(high, above, right)?);
    Some(there.plus(&along).plus(&negated(&back)))
}

/// A matrix of complex numbers.
#[derive(Clone)]
struct Complex<T> {
    re: Normed<T>,
    im: Normed<T>,
}

impl<T: Real> Complex<T> {
    fn plus(&self, other: &Complex<T>) -> Complex<T> {
        Complex {
            re: self.re.plus(&other.re),
            im: self.im.plus(&other.im),
        }
    }

    /// Three real products (Karatsuba).
    fn times(&self, other: &Complex<T>) -> Complex<T> {
        let both = self.re.plus(&self.im).times(&other.re.plus(&other.im));
        let (re, im) = (self.re.times(&other.re), negated(&self.im.times(&other.im)));
        Complex {
            im: both.plus(&negated(&re)).plus(&im),
            re: re.plus(&im),
        }
    }

    fn times_scalar(&self, factor: T, error: Magnitude) -> Complex<T> {
        Complex {
            re: self.re.times_scalar(factor, error),
            im: self.im.times_scalar(factor, error),
        }
    }

    /// i times it.
    fn turned(self) -> Complex<T> {
        Complex {
            re: negated(&self.im),
            im: self.re,
        }
    }

    fn with_more_error(self, error: Magnitude) -> Complex<T> {
        Complex {
            re: self.re.with_more_error(error),
            im: self.im.with_more_error(error),
        }
    }

    /// A bound of the 2-norm, that of [re −im; im re].
    fn norm(&self) -> Magnitude {
        let n = self.re.len();
        let entry = |at: usize| match (at / (2 * n), at % (2 * n)) {
            (i, j) if (i < n) == (j < n) => self.re.row(i % n)[j % n],
            (i, j) if i < n => -self.im.row(i)[j - n],
            (i, j) => self.im.row(i - n)[j],
        };
        let entries = (0..4 * n * n).map(entry).collect();
        let error = self.re.error() + self.im.error();
        Normed::new(2 * n, 2 * n, entries, error).true_norm()
    }
}

fn negated<T: Real>(matrix: &Normed<T>) -> Normed<T> {
    matrix.times_scalar(T::from(-1.0), Magnitude::ZERO)
}

/// Half of the way between the ends of a piece: along the real axis, or along the imaginary one.
enum Half<T> {
    Right(T),
    Up(T),
}

struct Piece<T> {
    integral: Complex<T>,
    /// A bound of the resolvent at both ends.
    ends: Magnitude,
}

struct Way<'a, T> {
    a: &'a Normed<T>,
}

impl<T: Real> Way<'_, T> {
    /// (m − A)⁻¹, and a bound of its norm: with ρ = ‖I − Z(m − A)‖ < 1 it is within ‖Z‖ρ/(1 − ρ) of Z.
    fn resolvent(&self, [re, im]: [T; 2]) -> Option<(Complex<T>, Magnitude)> {
        let n = self.a.len();
        let mut shifted = BallMatrix::zeros(2 * n, 2 * n);
        let mut entries = Vec::new();
        let mut rounding = Magnitude::ZERO;
        for i in 0..n {
            for j in 0..n {
                let mut entry = -self.a.row(i)[j];
                if i == j {
                    entry = re + entry;
                    let unit = entry.upper() * T::unit();
                    rounding = if rounding < unit { unit } else { rounding };
                }
                entries.push(entry);
                shifted.set(i, j, entry, Magnitude::ZERO);
                shifted.set(n + i, n + j, entry, Magnitude::ZERO);
            }
            shifted.set(i, n + i, -im, Magnitude::ZERO);
            shifted.set(n + i, i, im, Magnitude::ZERO);
        }
        let real = Normed::new(n, n, entries, self.a.error() + rounding);
        let inverse = shifted.approximate_inverse()?;
        let part = |row: usize| Normed::of(&inverse.block(row, 0, n, n), n);
        let inverse = Complex {
            re: part(0),
            im: part(n),
        };
        let by_real = Complex {
            re: inverse.re.times(&real),
            im: inverse.im.times(&real),
        };
        let by_both = Complex {
            re: inverse.re.times_scalar(im, Magnitude::ZERO),
            im: inverse.im.times_scalar(im, Magnitude::ZERO),
        };
        let product = by_real.plus(&by_both.turned());
        let rest = negated(&Normed::identity(n, n)).plus(&product.re);
        let off = rest.true_norm() + product.im.true_norm();
        let least = Magnitude::from(1.0).minus(off);
        let size = inverse.norm();
        let error = size * off / least;
        let known = !least.is_zero() && error.is_finite();
        known.then(|| (inverse.with_more_error(error), size + error))
    }

    /// The integral from m − h to m + h; `None` where no power of X contracts.
    fn piece(&self, middle: [T; 2], half: Half<T>) -> Option<Piece<T>> {
        let (resolvent, size) = self.resolvent(middle)?;
        let x = match half {
            Half::Right(half) => resolvent.times_scalar(half, Magnitude::ZERO),
            Half::Up(half) => resolvent.times_scalar(half, Magnitude::ZERO).turned(),
        };
        let (integral, all) = twice_artanh(&x)?;
        // (m ± h − A)⁻¹ = (m − A)⁻¹ Σ (∓X)ᵏ.
        let ends = size * all;
        Some(Piece { integral, ends })
    }

    /// The imaginary part of the integral from iω to iω + `right`, for an ω known to `off`.
    fn leg(&self, frequency: T, off: Magnitude, right: T) -> Option<Normed<T>> {
        let n = self.a.len();
        let mut sum = Normed::new(n, n, vec![T::ZERO; n * n], Magnitude::ZERO);
        if frequency.is_zero() && off.is_zero() {
            return Some(sum);
        }
        let (_, start) = self.resolvent([T::ZERO, frequency])?;
        let half = T::from(0.5);
        let mut done = T::ZERO;
        let mut next = T::ONE.scale(-start.exponent());
        for _ in 0..PIECES {
            if right < next {
                next = right;
            }
            let middle = [(done + next) * half, frequency];
            let Some(piece) = self.piece(middle, Half::Right((next - done) * half)) else {
                next = done + (next - done).scale(-1);
                continue;
            };
            sum = sum.plus(&piece.integral.im);
            if next == right {
                let least = Magnitude::from(1.0).minus(start * off);
                return (!least.is_zero()).then(|| sum.with_more_error(start * off / least));
            }
            (done, next) = (next, next.scale(2));
        }
        None
    }
}

/// 2 artanh X = 2X(I + X²/3 + X⁴/5 + …) by blocks of powers (Paterson & Stockmeyer 1973, *SIAM J. Comput.* 2), and a bound
/// of Σ‖Xᵏ‖; `None` unless a power of X² contracts: where A is far from normal, X itself does only for pieces much shorter than
/// the distance of the poles.
fn twice_artanh<T: Real>(x: &Complex<T>) -> Option<(Complex<T>, Magnitude)> {
    /// The highest power of X² that is looked at.
    const HIGHEST: usize = 32;
    let n = x.re.len();
    let nothing = || Normed::new(n, n, vec![T::ZERO; n * n], Magnitude::ZERO);
    let identity = Complex {
        re: Normed::identity(n, n),
        im: nothing(),
    };
    let square = x.times(x);
    let (mut power, mut degree) = (square.clone(), 1);
    let contracted = loop {
        let size = power.norm().log2() / (2 * degree) as f64;
        if size <= CONTRACTION.log2() {
            break size;
        }
        if degree == HIGHEST || !size.is_finite() {
            return None;
        }
        power = power.times(&power);
        degree *= 2;
    };
    // About so many terms count.
    let count = (f64::from(T::UNIT_LOG2) / (2.0 * contracted))
        .ceil()
        .max(1.0);
    let width = (count.sqrt() / degree as f64).ceil().max(1.0) as usize * degree;
    let mut powers = vec![identity, square];
    while powers.len() <= width {
        let next = powers[powers.len() - 1].times(&powers[1]);
        powers.push(next);
    }
    // ‖Y^{wq + r}‖ ≤ ‖Y^w‖^q ‖Yʳ‖ for Y = X².
    let sizes = powers[..width].iter().map(Complex::norm);
    let sizes = sizes.fold(Magnitude::ZERO, |sum, size| sum + size);
    let last = powers[width].norm();
    let least = Magnitude::from(1.0).minus(last);
    if least.is_zero() {
        return None;
    }
    let mut tail = sizes / least;
    let all = tail * (Magnitude::from(1.0) + x.norm());
    let mut blocks = 0;
    while blocks == 0 || T::unit() < tail {
        tail = tail * last;
        blocks += 1;
    }
    let block = |first: usize| {
        let start = Complex {
            re: nothing(),
            im: nothing(),
        };
        let terms = (first..first + width).zip(&powers);
        terms.fold(start, |sum, (k, power)| {
            let coefficient = T::ONE / T::from((2 * k + 1) as f64);
            sum.plus(&power.times_scalar(coefficient, T::unit()))
        })
    };
    let mut firsts = (0..blocks).rev().map(|at| at * width);
    let mut sum = block(firsts.next().unwrap_or(0));
    for first in firsts {
        sum = sum.times(&powers[width]).plus(&block(first));
    }
    let twice = x.times(&sum.with_more_error(tail));
    Some((twice.times_scalar(T::from(2.0), Magnitude::ZERO), all))
}
