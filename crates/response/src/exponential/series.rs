//! The Taylor series of the exponential of a second-order system.

use super::sparse::{LANES, LowerHalf, Panel, accumulate};
use pulp::{Simd, WithSimd};

/// R and Q of the Taylor polynomial of this degree for A = [0 I; −KG −C], where e^A is [I − RKG, Q;
/// −QKG, I − RKG − QC].
///
/// With K for KG, Horner's scheme Z ← (A + Z A)/k for the top row Z = (R, Q) of the polynomial, where (R, Q) A is (Q,
/// −RK − QC): Q_k = (I − Q_{k+2} K/(k + 1) − Q_{k+1} C)/k, and in the end R = Q_2.
pub(super) struct Series<'a> {
    pub(super) m: usize,
    pub(super) lower: &'a LowerHalf,
    pub(super) g: &'a [f64],
    pub(super) degree: u32,
}

impl WithSimd for Series<'_> {
    /// R and Q.
    type Output = [Panel; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [Panel; 2] {
        let Series {
            m,
            lower,
            g,
            degree,
        } = self;
        let step = lower.band();
        let (mut next, mut older, mut newer) = (Panel::zeros(m), Panel::zeros(m), Panel::zeros(m));
        let mut band = 0;
        for k in (1..=degree).rev() {
            // Q_{k+2} is `older`, Q_{k+1} is `newer`; neither has entries beyond the band.
            let factor = 1.0 / f64::from(k);
            let before = if k == degree {
                0.0
            } else {
                1.0 / f64::from(k + 1)
            };
            for (j, g) in g.iter().enumerate() {
                let groups = next.near(j, band);
                let out = next.part_mut(j, groups.clone());
                out.fill([0.0; LANES]);
                let stiffness = -factor * before * g;
                accumulate(simd, out, &older, groups.clone(), stiffness, lower.k(j));
                accumulate(simd, out, &newer, groups, -factor, lower.c(j));
                next.column_mut(j)[j] += factor;
            }
            // (older, newer, next) → (newer, next, free).
            std::mem::swap(&mut older, &mut newer);
            std::mem::swap(&mut newer, &mut next);
            band = (band + step).min(m);
        }
        [older, newer]
    }
}
