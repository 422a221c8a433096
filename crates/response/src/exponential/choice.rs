//! Degree and squarings for matrices of second-order form.

use super::norm::largest;

/// Degrees m of the Taylor polynomial, with the θ_m of Al-Mohy & Higham 2011 (*Computing the action of
/// the matrix exponential*, SIAM J. Sci. Comput. 33, table 3.1): up to this norm it is the exponential
/// of a matrix that differs by at most 2^-53 ‖A‖.
const DEGREES: [(u32, f64); 3] = [
    (15, 0.641_083_523_304_119_9),
    (20, 1.438_252_596_804_337),
    (25, 2.428_582_524_442_826_5),
];

/// The largest norm that needs no squaring.
pub(super) const THETA: f64 = DEGREES[2].1;

/// Degree and number of squarings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Choice {
    pub(super) degree: u32,
    pub(super) squarings: i32,
}

impl Choice {
    /// For a matrix of this size, and this largest diagonal entry of C; `None` where so many squarings are due
    /// that [`Taylor`](super::Taylor) must watch over their growth.
    pub(super) fn of(size: &Size, damping: f64) -> Option<Choice> {
        const MOST: i32 = 45;
        if damping <= 1.0
            && let Some((degree, _)) = DEGREES.iter().find(|(_, theta)| size.is_within(*theta))
        {
            return Some(Choice {
                degree: *degree,
                squarings: 0,
            });
        }
        let size = size.bound();
        if !size.is_finite() {
            return None;
        }
        let halvings = |excess: f64| match excess > 1.0 {
            true => excess.log2().ceil() as i32,
            false => 0,
        };
        let squarings = halvings(size / THETA).max(halvings(damping));
        if squarings > MOST {
            return None;
        }
        let scaled = size * 2f64.powi(-squarings);
        let enough = DEGREES.iter().find(|(_, theta)| scaled <= *theta);
        let (degree, _) = enough.unwrap_or(&DEGREES[2]);
        Some(Choice {
            degree: *degree,
            squarings,
        })
    }
}

/// The column sums of the first powers of |A|, the largest of each, in the unit of time in which both halves
/// of A are alike.
pub(super) struct Size([f64; 5]);

impl Size {
    /// The powers themselves: `weighted` takes w to wᵀ|K| and wᵀ|C|; `scratch` has room for four columns.
    #[inline(always)]
    pub(super) fn of(
        g: &[f64],
        stiffness: f64,
        scratch: [&mut [f64]; 4],
        mut weighted: impl FnMut(&[f64], &mut [f64], &mut [f64]),
    ) -> Size {
        let unit = match stiffness > 0.0 {
            true => root(stiffness / largest(g)),
            false => 1.0,
        };
        let inverse = 1.0 / unit;
        let [mut x, mut v, mut by_k, mut by_c] = scratch;
        x.fill(1.0);
        v.fill(1.0);
        let mut sums = [0.0; 5];
        for sum in &mut sums {
            weighted(v, by_k, by_c);
            for (((k, c), x), g) in by_k.iter_mut().zip(&mut *by_c).zip(&*x).zip(g) {
                *k *= inverse;
                *c += unit * x * g;
            }
            std::mem::swap(&mut x, &mut by_k);
            std::mem::swap(&mut v, &mut by_c);
            *sum = largest(&[largest(x), largest(v)]);
        }
        Size(sums)
    }

    /// A bound of ‖A^k‖^{1/k} for all k ≥ 12 (Al-Mohy & Higham 2009, SIAM J. Matrix Anal. 31, theorem 4.2).
    pub(super) fn bound(&self) -> f64 {
        let Size(sums) = self;
        // A NaN is to be found.
        if sums.iter().any(|sum| sum.is_nan()) {
            return f64::NAN;
        }
        let third = sums[2].cbrt();
        let fourth = sums[3].sqrt().sqrt();
        let fifth = sums[4].powf(0.2);
        sums[0].min(third.max(fourth)).min(fourth.max(fifth))
    }

    /// Whether the bound is at most `theta`, by powers instead of roots.
    pub(super) fn is_within(&self, theta: f64) -> bool {
        let Size([first, _, third, fourth, fifth]) = *self;
        let square = theta * theta;
        let by_fourth = fourth <= square * square;
        first <= theta
            || (by_fourth && (third <= square * theta || fifth <= square * square * theta))
    }
}

/// A power of two within a factor of two of the root of a positive number.
fn root(square: f64) -> f64 {
    const BIAS: i32 = 1023;
    // Below normal numbers this is not so, but only time is lost.
    let exponent = ((square.to_bits() >> 52) & 0x7ff) as i32 - BIAS;
    let half = (exponent + 1).div_euclid(2);
    f64::from_bits(((half + BIAS) as u64) << 52)
}

/// Whether column j of the upper half is that of [0 G].
pub(super) fn is_upper(m: usize, j: usize, left: &[f64], right: &[f64]) -> bool {
    let others = |i: usize| left[i] == 0.0 && (i == j || right[i] == 0.0);
    right[j] > 0.0 && (0..m).all(others)
}
