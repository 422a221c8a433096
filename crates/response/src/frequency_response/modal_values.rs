//! Values of functions and their derivatives by power series from modes (see `modal_series`), in O(n) each: at a frequency, or
//! throughout a short range of them.

use eigentone_digits::{Ball, DoubleDouble, Magnitude, WideComplex};

use super::dynamic_stiffness::Frequency;
use super::elimination::scaled;
use super::modal_functions::ModalFunctions;
use super::power_series::Number;
use super::refinement::UPWARD;

impl ModalFunctions<'_> {
    /// All outputs, each with its derivative with respect to Ω; `None` where the modes prove nothing.
    pub(super) fn enclosed(&self, frequency: Frequency) -> Option<Vec<[Number; 2]>> {
        /// The least ρ in parts of Ω: nearer to a pole there are no digits.
        const NEAREST: f64 = 1e-26;
        /// The least ρ in parts of the range.
        const WIDE: f64 = 4.0;
        let place = frequency.middle.to_f64();
        if frequency.scale != 0 || !Self::RANGE.contains(&place) {
            return None;
        }
        let least = (place * NEAREST).max(WIDE * frequency.radius);
        let count = if frequency.radius > 0.0 { 3 } else { 2 };
        let all = self.series::<DoubleDouble>(frequency.middle, least, count)?;
        let each = all.into_iter().map(|series| {
            let [value, change] = [0, 1].map(|k| series.coefficients[k]);
            let normal = value.radius().to_f64() >= Self::SMALLEST;
            let power = series.radius.log2().round() as i64;
            let per_unit = |change: Number| scaled(change, -power);
            let reach = frequency.radius / series.radius * UPWARD;
            if frequency.radius == 0.0 {
                return normal.then_some([value, per_unit(change)]);
            }
            // Of Σ cₖtᵏ and Σ kcₖtᵏ⁻¹, with |cₖ| at most that of all in the disc (Cauchy).
            let curve = series.coefficients[2].upper();
            let beyond = series.largest * Magnitude::from((1.0 - reach).powi(-2) * UPWARD);
            let [first, second, third] =
                [1, 2, 3].map(|power| Magnitude::from(reach.powi(power) * UPWARD));
            let around = change.upper() * first + curve * second + beyond * third;
            let turned = (curve + curve) * first + Magnitude::from(3.0) * beyond * second;
            let within = |middle: Number, radius| middle + Ball::new(WideComplex::ZERO, radius);
            normal.then(|| [within(value, around), per_unit(within(change, turned))])
        });
        each.collect()
    }
}
