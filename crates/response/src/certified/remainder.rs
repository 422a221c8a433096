//! How far a motion may be from the polynomials of degree five through its ends, at most.

use eigentone_digits::product;
use faer::Mat;

use super::products::multiply;

/// What bounds the sixth derivatives of quantities x = cᵀζ, ζ′ = Wζ, over any stretch that is not too long: of absolute values,
/// |x⁽⁶⁾| ≤ |c″|ᵀ|W|⁴ e^{|W|h} |ζ| with c″ᵀ = cᵀW², entry by entry, so that what is far from all that moves is known to stand.
///
/// A polynomial of degree five through value and two derivatives at both ends of a stretch of length h is within h⁶/46080 of a
/// function with a sixth derivative of at most 1, and its slope within √5 h⁵/30000 (Birkhoff & Priver 1967, *Hermite
/// interpolation errors for derivatives*, J. Math. and Phys. 46).
pub(super) struct Remainder {
    /// The longest stretch, in s.
    longest: f64,
    /// By quantities: h⁶/46080 times that bound, for the longest stretch, without |ζ|.
    rows: Vec<f64>,
    count: usize,
}

impl Remainder {
    /// Of so many quantities whose second derivatives are these rows times ζ, by rows, for W by rows.
    pub(super) fn of(count: usize, second: &[f64], w: &[f64]) -> Remainder {
        /// ‖|W|‖h in the maximum norm.
        const TURN: f64 = 2.0;
        /// TURN³¹/31! < 1e-24.
        const TERMS: usize = 30;
        const MORE: f64 = 1e-24;
        /// More than rounding takes from sums of what is not negative.
        const ROUNDING: f64 = 1.0 + 1e-9;
        let size = w.len().isqrt();
        let row_sum = |row: &[f64]| row.iter().map(|entry| entry.abs()).sum::<f64>();
        let norm = w.chunks_exact(size.max(1)).map(row_sum).fold(0.0, f64::max);
        let longest = TURN / norm;
        let turn = Mat::from_fn(size, size, |i, j| longest * w[i * size + j].abs());
        let mut term = Mat::from_fn(count, size, |i, j| {
            longest * (longest * second[i * size + j].abs())
        });
        for _ in 0..4 {
            term = product(term.as_ref(), turn.as_ref());
        }
        let rest: Vec<f64> = (0..count)
            .map(|i| MORE * term.row(i).iter().sum::<f64>())
            .collect();
        let mut sum = term.clone();
        for k in 1..=TERMS {
            term = product(term.as_ref(), turn.as_ref());
            term *= faer::Scale(1.0 / k as f64);
            sum += &term;
        }
        let rows = (0..count * size).map(|at| {
            let (i, j) = (at / size, at % size);
            (sum[(i, j)] + rest[i]) * ROUNDING / 46080.0
        });
        Remainder {
            longest,
            rows: rows.collect(),
            count,
        }
    }

    /// How far each quantity, and how far its slope may be off on a stretch of this length that begins with these sizes of ζ.
    /// `None` where it is too long.
    pub(super) fn along(&self, length: f64, sizes: &[f64]) -> Option<Vec<[f64; 2]>> {
        /// That of slopes, beside that of values over the length.
        const SLOPE: f64 = 46080.0 * 2.23606797749979 / 30000.0;
        let part = length / self.longest;
        (part <= 1.0).then(|| {
            let share = part.powi(6);
            let mut off = vec![0.0; self.count];
            multiply(&self.rows, sizes, &mut off);
            let both = |off: f64| [share * off, SLOPE * share * off / length];
            off.into_iter().map(both).collect()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::certified::quintic::Quintic;

    /// Of ½ sin 3t, and of a second oscillator that is at rest.
    #[test]
    fn what_a_polynomial_misses_is_bounded_and_not_by_much_more() {
        let w = [
            [0.0, 3.0, 0.0, 0.0],
            [-3.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 3.0],
            [0.0, 0.0, -3.0, 0.0],
        ];
        let second = [[-4.5, 0.0, 0.0, 0.0], [0.0, 0.0, -4.5, 0.0]];
        let remainder = Remainder::of(2, second.as_flattened(), w.as_flattened());
        assert!(remainder.along(0.7, &[0.0; 4]).is_none());
        for (from, length) in [(0.0, 0.6), (0.3, 0.2), (1.1, 0.02)] {
            let knot = |t: f64| {
                let (sine, cosine) = (3.0 * t).sin_cos();
                [0.5 * sine, 1.5 * cosine, -4.5 * sine]
            };
            let polynomial = Quintic::between(knot(from), knot(from + length), length);
            let missed = |k: usize| {
                let s = f64::from(k as u32) / 64.0;
                let [x, v, _] = knot(from + s * length);
                let slope = polynomial.slope().at(s) / length;
                [(polynomial.at(s) - x).abs(), (slope - v).abs()]
            };
            let most = (0..=64).map(missed).fold([0.0f64; 2], |most, missed| {
                [0, 1].map(|order| most[order].max(missed[order]))
            });
            let (sine, cosine) = (3.0 * from).sin_cos();
            let sizes = [sine.abs(), cosine.abs(), 0.0, 0.0];
            let off = remainder.along(length, &sizes).expect("it is short");
            for (off, most) in off[0].iter().zip(most) {
                assert!(most <= off + 1e-15, "{length}: {most:e} {off:e}");
                assert!(*off <= 40.0 * most + 1e-15, "{length}: {most:e} {off:e}");
            }
            assert!(off[1].iter().all(|off| *off < 1e-22), "{off:?}");
        }
    }
}
