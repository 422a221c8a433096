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

    /// From values and derivatives by time at both ends and in the middle of a stretch of so many seconds, by Newton's divided
    /// differences.
    pub(super) fn through(knots: [[f64; 2]; 3], length: f64) -> Quintic {
        let [[x, a], [y, b], [z, c]] = knots.map(|[value, rate]| [value, length * rate]);
        let (first, second) = (2.0 * (y - x), 2.0 * (z - y));
        let [ab, ba, bc, cb] = [first - a, b - first, second - b, c - second].map(|d| 2.0 * d);
        let (left, middle, right) = (2.0 * (ba - ab), bc - ba, 2.0 * (cb - bc));
        let fourth = middle - left;
        let fifth = right - middle - fourth;
        Quintic([
            x,
            a,
            ab - left / 2.0 + (fourth - fifth) / 4.0,
            left - fourth + 1.25 * fifth,
            fourth - 2.0 * fifth,
            fifth,
        ])
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

    /// Its integral from 0 to s.
    pub(super) fn integral(&self, s: f64) -> f64 {
        let shares = [0, 1, 2, 3, 4, 5].map(|k| self.0[k] / (k + 1) as f64);
        s * Quintic(shares).at(s)
    }

    /// Where it changes sign, as it does between 0 and 1.
    pub(super) fn zero(&self) -> f64 {
        let (mut low, mut high) = (0.0, 1.0);
        let is_above = self.at(low) > 0.0;
        for _ in 0..f64::MANTISSA_DIGITS {
            let middle = 0.5 * (low + high);
            if (self.at(middle) > 0.0) == is_above {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }

    /// Where its slope changes sign, as it does between 0 and 1, and its value there.
    pub(crate) fn turn(&self) -> (f64, f64) {
        let s = self.slope().zero();
        (s, self.at(s))
    }
}

/// Where the first or second derivative of a quantity changes sign between the ends of a short stretch, as a part of it, and the
/// quantity or its first derivative there: from the quantity and both derivatives at the beginning, in the middle and at the end.
/// The last number is how far the quantity may be off: the most by which its polynomial misses it at the knots.
pub(super) fn turn_of(knots: &[[f64; 3]; 3], derivative: usize, length: f64) -> (f64, f64, f64) {
    let velocity = Quintic::through(knots.map(|[_, v, a]| [v, a]), length);
    let (s, value, off) = match derivative {
        1 => {
            let s = velocity.zero();
            let at = |s: f64| knots[0][0] + length * velocity.integral(s);
            let missed = |knot: usize| (at(0.5 * knot as f64) - knots[knot][0]).abs();
            (s, at(s), missed(1).max(missed(2)))
        }
        _ => {
            let (s, value) = velocity.turn();
            (s, value, 0.0)
        }
    };
    // Where the derivatives are rounding, as those of stiff parts at rest are, what they are taken of is not.
    let near = knots.map(|knot| knot[derivative - 1]);
    let [low, high] = [f64::min, f64::max].map(|further| near.into_iter().fold(near[1], further));
    let spread = high - low;
    if (low - spread..=high + spread).contains(&value) {
        return (s, value, off);
    }
    let farthest = if knots[0][derivative] > 0.0 {
        high
    } else {
        low
    };
    let place = near.iter().position(|value| *value == farthest);
    (0.5 * place.unwrap_or(1) as f64, farthest, spread)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1 − (t − 0.3)² is highest at 0.3, and −cos lowest at 0, as a quantity and as the velocity of one.
    #[test]
    fn a_turn_is_found_from_three_places() {
        let knots = [0.0, 0.5, 1.0].map(|t: f64| [1.0 - (t - 0.3).powi(2), 0.6 - 2.0 * t, -2.0]);
        let (s, value, _) = turn_of(&knots, 1, 1.0);
        assert!((s - 0.3).abs() < 1e-14 && (value - 1.0).abs() < 1e-15);
        let length = 0.2;
        let knots = [0.0, 0.5, 1.0].map(|s| {
            let (sine, cosine) = f64::sin_cos(-0.07 + length * s);
            [-cosine, sine, cosine]
        });
        let (s, value, _) = turn_of(&knots, 1, length);
        assert!((length * s - 0.07).abs() < 1e-9 && (value + 1.0).abs() < 1e-11);
        // A longer one shows what its polynomial misses.
        let knots_of = |length: f64| {
            [0.0, 0.5, 1.0].map(|s| {
                let (sine, cosine) = f64::sin_cos(-0.4 + length * s);
                [-cosine, sine, cosine]
            })
        };
        for length in [0.5, 1.0, 2.0] {
            let (_, value, off) = turn_of(&knots_of(length), 1, length);
            let error = (value + 1.0).abs();
            assert!(
                error > 1e-11 && error <= off && off < 1e-3,
                "{length}: {error:e} {off:e}"
            );
        }
        let knots = knots.map(|[x, v, _]| [0.0, x, v]);
        let (s, value, _) = turn_of(&knots, 2, length);
        assert!((length * s - 0.07).abs() < 1e-6 && (value + 1.0).abs() < 1e-9);
    }

    /// Of a part that hardly moves only rounding is left in velocities and accelerations.
    #[test]
    fn a_turn_by_derivatives_that_are_rounding_goes_no_further_than_the_values() {
        let knots = [
            [2e-12, 1e-4, 3e7],
            [2.1e-12, 3e-5, -1e8],
            [1.9e-12, -2e-4, 5e7],
        ];
        let (s, value, _) = turn_of(&knots, 1, 0.01);
        assert_eq!((s, value), (0.5, 2.1e-12));
    }

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
        // The same through three places.
        let places = [0.5, 1.0, 1.5].map(|t| [knot(t)[0], knot(t)[1]]);
        let same = Quintic::through(places, 1.0);
        for (coefficient, same) in quintic.0.iter().zip(&same.0) {
            assert!((coefficient - same).abs() < 1e-13, "{quintic:?} {same:?}");
        }
        // Its integral from t = 0.5 is t⁶/30 − t⁵/10 + t²/2, less 1/1920 − 1/320 + 1/8.
        for s in [0.0, 0.3, 1.0] {
            let t: f64 = 0.5 + s;
            let wanted = t.powi(6) / 30.0 - t.powi(5) / 10.0 + t * t / 2.0;
            let wanted = wanted - 1.0 / 1920.0 + 1.0 / 320.0 - 0.125;
            assert!((same.integral(s) - wanted).abs() < 1e-14, "{s}");
        }
        // The slope is least where t = 3/2.
        let (at, value) = Quintic::between(knot(1.2), knot(1.7), 0.5).slope().turn();
        assert!((at - 0.6).abs() < 1e-10, "{at}");
        assert!((value / 0.5 + 0.6875).abs() < 1e-13, "{value}");
    }
}
