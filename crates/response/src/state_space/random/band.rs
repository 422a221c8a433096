//! The integral of the resolvent over a band of frequencies, Φ = Re ∫ (iω − A)⁻¹ dω, for an A of which nothing grows.
//!
//! Along any way from iω₁ to iω₂ on which no pole lies it is the same. A piece from m − h to m + h gives 2 artanh X with
//! X = h(m − A)⁻¹ where X contracts: the logarithm of the two ends' quotient, exact for multiple poles too, with no branch to
//! be chosen. Where poles stand close to the band, the way leads through the right half-plane, where their distance grows
//! with each piece: as many pieces as there are powers of 4 between the width of the band and the distance of its ends from
//! the nearest pole.

use eigentone_digits::{BallMatrix, Magnitude, Real};

use crate::enclosed::Normed;
use crate::problem::Known;

/// The most that X may be.
const CONTRACTION: f64 = 0.8;

/// How many pieces a way may have, and how often one is shortened.
const PIECES: usize = 4000;

/// Φ for the band of angular frequencies; `None` where the digits of T do not suffice.
pub(super) fn of_band<T: Real>(a: &Normed<T>, band: [Known<T>; 2]) -> Option<Normed<T>> {
    let n = a.len();
    let way = Way { a, n };
    let [(low, below), (high, above)] = band;
    let half = T::from(0.5);
    let (middle, width) = ((low + high) * half, high - low);
    let off = below + above + high.upper() * T::unit() * Magnitude::from(8.0);
    let mut right = T::ZERO;
    // The piece along the band itself, or parallel to it at a distance at which X contracts.
    let along = loop {
        if let Some(piece) = way.piece([right, middle], [T::ZERO, width * half]) {
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
    let along = along.integral.with_more_error(moved + moved);
    let all = match right.is_zero() {
        true => along,
        false => {
            let (there, back) = (way.leg(low, below, right)?, way.leg(high, above, right)?);
            let back = back.times_scalar(T::from(-1.0), Magnitude::ZERO);
            there.plus(&along).plus(&back)
        }
    };
    // ∫ (iω − A)⁻¹ dω = −i ∫ (z − A)⁻¹ dz.
    let entries = (0..n * n).map(|at| all.row(n + at / n)[at % n]);
    Some(Normed::new(n, n, entries.collect(), all.error()))
}

/// Matrices of complex numbers x + iy as [x −y; y x].
struct Way<'a, T> {
    a: &'a Normed<T>,
    n: usize,
}

struct Piece<T> {
    integral: Normed<T>,
    /// A bound of the resolvent at both ends.
    ends: Magnitude,
}

impl<T: Real> Way<'_, T> {
    /// (m − A)⁻¹.
    fn resolvent(&self, [re, im]: [T; 2]) -> Option<Normed<T>> {
        let n = self.n;
        let mut shifted = BallMatrix::zeros(2 * n, 2 * n);
        let mut rounding = Magnitude::ZERO;
        for i in 0..n {
            for j in 0..n {
                let mut entry = -self.a.row(i)[j];
                if i == j {
                    entry = re + entry;
                    let unit = entry.upper() * T::unit();
                    rounding = if rounding < unit { unit } else { rounding };
                }
                shifted.set(i, j, entry, Magnitude::ZERO);
                shifted.set(n + i, n + j, entry, Magnitude::ZERO);
            }
            shifted.set(i, n + i, -im, Magnitude::ZERO);
            shifted.set(n + i, i, im, Magnitude::ZERO);
        }
        let inverse = shifted.solve(&BallMatrix::identity(2 * n))?;
        let inverse = Normed::of(&inverse, 2 * n);
        // ‖(B + E)⁻¹ − B⁻¹‖ ≤ ‖B⁻¹‖²‖E‖/(1 − ‖B⁻¹‖‖E‖).
        let size = inverse.true_norm();
        let off = size * (self.a.error() + rounding);
        let least = Magnitude::from(1.0).minus(off);
        let error = size * off / least;
        (!least.is_zero() && error.is_finite()).then(|| inverse.with_more_error(error))
    }

    /// The integral from m − h to m + h; `None` where X does not contract.
    fn piece(&self, middle: [T; 2], [re, im]: [T; 2]) -> Option<Piece<T>> {
        let resolvent = self.resolvent(middle)?;
        let (size, n) = (resolvent.true_norm(), self.n);
        let x = match im.is_zero() {
            true => resolvent.times_scalar(re, Magnitude::ZERO),
            false => {
                let entry = |at: usize| match (at / (2 * n), at % (2 * n)) {
                    (i, j) if i < n => -resolvent.row(n + i)[j],
                    (i, j) => resolvent.row(i - n)[j],
                };
                let entries = (0..4 * n * n).map(entry).collect();
                let turned = Normed::new(2 * n, 2 * n, entries, resolvent.error());
                turned.times_scalar(im, Magnitude::ZERO)
            }
        };
        let least = Magnitude::from(1.0).minus(x.true_norm());
        let contracts = x.true_norm() <= Magnitude::from(CONTRACTION);
        contracts.then(|| Piece {
            integral: twice_artanh(&x),
            ends: size / least,
        })
    }

    /// The integral from iω to iω + `right`, for an ω known to `off`.
    fn leg(&self, frequency: T, off: Magnitude, right: T) -> Option<Normed<T>> {
        let start = self.resolvent([T::ZERO, frequency])?.true_norm();
        let half = T::from(0.5);
        let mut done = T::ZERO;
        let mut next = T::ONE.scale(-start.exponent());
        let mut sum: Option<Normed<T>> = None;
        for _ in 0..PIECES {
            if right < next {
                next = right;
            }
            let ends = [(done + next) * half, (next - done) * half];
            let Some(piece) = self.piece([ends[0], frequency], [ends[1], T::ZERO]) else {
                next = done + (next - done).scale(-1);
                continue;
            };
            sum = Some(match sum {
                None => piece.integral,
                Some(sum) => sum.plus(&piece.integral),
            });
            if next == right {
                let least = Magnitude::from(1.0).minus(start * off);
                return sum
                    .filter(|_| !least.is_zero())
                    .map(|sum| sum.with_more_error(start * off / least));
            }
            (done, next) = (next, next.scale(2));
        }
        None
    }
}

/// 2 artanh X = 2X(I + X²/3 + X⁴/5 + …) by blocks of powers (Paterson & Stockmeyer 1973, *SIAM J. Comput.* 2), ‖X‖ < 1.
fn twice_artanh<T: Real>(x: &Normed<T>) -> Normed<T> {
    let square = x.times(x);
    let size = x.true_norm() * x.true_norm();
    let size = if square.true_norm() < size {
        square.true_norm()
    } else {
        size
    };
    // Σ_{k ≥ count} yᵏ/(2k + 1) ≤ y^count/(1 − y).
    let count = match size.is_zero() {
        true => 1,
        false => (f64::from(T::UNIT_LOG2) / size.log2()).ceil().max(1.0) as usize,
    };
    let width = (count as f64).sqrt().ceil() as usize;
    let n = x.len();
    let mut powers = vec![Normed::identity(n, n), square];
    while powers.len() <= width {
        let next = powers[powers.len() - 1].times(&powers[1]);
        powers.push(next);
    }
    let block = |first: usize| {
        let terms = (first..count.min(first + width)).zip(&powers);
        let of = |(k, power): (usize, &Normed<T>)| {
            let coefficient = T::ONE / T::from((2 * k + 1) as f64);
            power.times_scalar(coefficient, T::unit())
        };
        let mut terms = terms.map(of);
        let start = terms.next().unwrap_or_else(|| Normed::identity(n, n));
        terms.fold(start, |sum, term| sum.plus(&term))
    };
    let mut firsts = (0..count).step_by(width).rev();
    let mut sum = block(firsts.next().unwrap_or(0));
    for first in firsts {
        sum = sum.times(&powers[width]).plus(&block(first));
    }
    let least = Magnitude::from(1.0).minus(size);
    let tail = (0..count).fold(Magnitude::from(1.0), |tail, _| tail * size) / least;
    let twice = x.times(&sum.with_more_error(tail));
    twice.times_scalar(T::from(2.0), Magnitude::ZERO)
}
