//! The polynomial of degree five that has a motion's value and first two derivatives at both ends of a stretch.

/// Its coefficients: of 1, s, s², … s⁵, for s from 0 to 1 along the stretch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quintic([f64; 6]);

impl Quintic {
    /// From value and derivatives by time at both ends of a stretch of so many seconds.
    pub(super) fn between([x, v, a]: [f64; 3], right: [f64; 3], length: f64) -> Quintic {
        let (v, a) = (length * v, length * length * a);
        let rise = right[0] - x - v - a / 2.0;
        let slope = length * right[1] - v - a;
        let bend = length * length * right[2] - a;
        Quintic([
            x,
            v,
            a / 2.0,
            10.0 * rise - 4.0 * slope + bend / 2.0,
            -15.0 * rise + 7.0 * slope - bend,
            6.0 * rise - 3.0 * slope + bend / 2.0,
        ])
    }

    /// The integral of the polynomial of degree three that has a motion's velocity and acceleration at both ends of a stretch:
    /// so short that differences of places are rounding.
    pub(super) fn short([x, v, a]: [f64; 3], right: [f64; 3], length: f64) -> Quintic {
        let (rise, a, b) = (right[1] - v, length * a, length * right[2]);
        let velocity = [v, a, 3.0 * rise - 2.0 * a - b, a + b - 2.0 * rise];
        let [v, a, c, d] = velocity.map(|coefficient| length * coefficient);
        Quintic([x, v, a / 2.0, c / 3.0, d / 4.0, 0.0])
    }

    /// Its value at s.
    pub(crate) fn at(&self, s: f64) -> f64 {
        let highest_first = self.0.iter().rev();
        highest_first.fold(0.0, |sum, coefficient| sum * s + coefficient)
    }

    /// What the polynomial between two ends does not fall below, and what it does not exceed: its coefficients in
    /// Bernstein's polynomials, of which it is a mean at each s.
    pub(super) fn limits(left: [f64; 3], right: [f64; 3], length: f64) -> [f64; 2] {
        let all = Quintic::controls(left, right, length);
        let low = all.into_iter().fold(all[0], f64::min);
        [low, all.into_iter().fold(all[0], f64::max)]
    }

    /// What its derivative by time does not exceed in size.
    pub(super) fn speed_limit(left: [f64; 3], right: [f64; 3], length: f64) -> f64 {
        let all = Quintic::controls(left, right, length);
        let steps = all.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        5.0 * steps.fold(0.0, f64::max) / length
    }

    fn controls([x, v, a]: [f64; 3], [y, w, b]: [f64; 3], length: f64) -> [f64; 6] {
        let (v, w) = (0.2 * length * v, 0.2 * length * w);
        let (a, b) = (0.05 * length * length * a, 0.05 * length * length * b);
        [x, x + v, x + 2.0 * v + a, y - 2.0 * w + b, y - w, y]
    }

    /// As often as its slope changes sign between 0 and 1, or an even number more often (Descartes).
    pub(crate) fn turns(&self) -> usize {
        let slopes = self.slope().bernstein().into_iter();
        let signs: Vec<bool> = slopes
            .filter(|slope| *slope != 0.0)
            .map(|slope| slope > 0.0)
            .collect();
        signs.windows(2).filter(|pair| pair[0] != pair[1]).count()
    }

    /// Its coefficients in Bernstein's polynomials.
    fn bernstein(&self) -> [f64; 6] {
        // (j over k)/(5 over k).
        let mut shares = [[0.0; 6]; 6];
        for (j, shares) in shares.iter_mut().enumerate() {
            shares[0] = 1.0;
            for k in 1..=j {
                shares[k] = shares[k - 1] * (j + 1 - k) as f64 / (6 - k) as f64;
            }
        }
        shares.map(|shares| shares.iter().zip(&self.0).map(|(a, b)| a * b).sum())
    }

    /// Its derivative by s.
    pub(crate) fn slope(&self) -> Quintic {
        let mut slope = [0.0; 6];
        for k in 1..6 {
            slope[k - 1] = k as f64 * self.0[k];
        }
        Quintic(slope)
    }

    /// Where its slope changes sign, as it does between 0 and 1, and its value there.
    pub(crate) fn turn(&self) -> (f64, f64) {
        let slope = self.slope();
        let (mut low, mut high) = (0.0, 1.0);
        let rises = slope.at(low) > 0.0;
        for _ in 0..f64::MANTISSA_DIGITS {
            let middle = 0.5 * (low + high);
            if (slope.at(middle) > 0.0) == rises {
                low = middle;
            } else {
                high = middle;
            }
        }
        (low, self.at(low))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// t⁵/5 − t⁴/2 + t about t = 1, where its slope t⁴ − 2t³ + 1 changes sign.
    #[test]
    fn a_polynomial_of_degree_five_is_itself() {
        let knot = |t: f64| {
            let value = t.powi(5) / 5.0 - t.powi(4) / 2.0 + t;
            let slope = t.powi(4) - 2.0 * t.powi(3) + 1.0;
            [value, slope, 4.0 * t.powi(3) - 6.0 * t.powi(2)]
        };
        let quintic = Quintic::between(knot(0.5), knot(1.5), 1.0);
        for s in [0.0, 0.3, 0.8, 1.0] {
            let [value, slope, _] = knot(0.5 + s);
            assert!((quintic.at(s) - value).abs() < 1e-14, "{s}");
            assert!((quintic.slope().at(s) - slope).abs() < 1e-13, "{s}");
        }
        let all = quintic.bernstein();
        let wanted = [f64::min, f64::max].map(|further| all.into_iter().fold(all[0], further));
        let limits = Quintic::limits(knot(0.5), knot(1.5), 1.0);
        for (limit, wanted) in limits.into_iter().zip(wanted) {
            assert!((limit - wanted).abs() < 1e-14, "{limit} {wanted}");
        }
        assert!(limits[1] >= 0.7 && limits[0] <= quintic.at(1.0) && quintic.turns() == 1);
        let (at, value) = quintic.turn();
        assert!((at - 0.5).abs() < 1e-13, "{at}");
        assert!((value - 0.7).abs() < 1e-14, "{value}");
        // A velocity of degree three: of 2t³ − t² + t⁴/4 it is 0 where t² + 6t = 2.
        let velocity = |t: f64| 6.0 * t * t - 2.0 * t + t * t * t;
        let knot_of = |t: f64| {
            let place = 2.0 * t.powi(3) - t * t + t.powi(4) / 4.0;
            [place, velocity(t), 12.0 * t - 2.0 + 3.0 * t * t]
        };
        let (at, value) = Quintic::short(knot_of(0.25), knot_of(0.5), 0.25).turn();
        let zero = 11f64.sqrt() - 3.0;
        assert!((0.25 + 0.25 * at - zero).abs() < 1e-15, "{at}");
        assert!((value - knot_of(zero)[0]).abs() < 1e-16, "{value}");
        // The slope is least where t = 3/2.
        let (at, value) = Quintic::between(knot(1.2), knot(1.7), 0.5).slope().turn();
        assert!((at - 0.6).abs() < 1e-10, "{at}");
        assert!((value / 0.5 + 0.6875).abs() < 1e-13, "{value}");
    }
}
