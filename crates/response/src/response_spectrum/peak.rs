//! What is looked for: the largest size of a linear form of (p, v).

use eigentone_digits::Real;

use super::maps::Place;
use super::oscillator::{Oscillator, SLACK};

/// p + κv: with κ = 0 the relative displacement times ω, with κ = 2ζ the absolute acceleration over ω, but for the sign.
#[derive(Clone, Copy, Debug)]
pub(super) struct Form<T> {
    kappa: T,
    /// The same in doubles, and the norm of (1, κ), rounded up.
    factor: f64,
    norm: f64,
}

impl<T: Real> Form<T> {
    pub(super) fn of(kappa: f64) -> Form<T> {
        Form {
            kappa: T::from(kappa),
            factor: kappa,
            norm: (1.0 + kappa * kappa).sqrt() * (1.0 + SLACK),
        }
    }

    pub(super) fn norm(&self) -> f64 {
        self.norm
    }

    pub(super) fn rough(&self, p: f64, v: f64) -> f64 {
        p + self.factor * v
    }

    pub(super) fn value(&self, z: &[T; 2]) -> T {
        match self.factor == 0.0 {
            true => z[0],
            false => z[0] + self.kappa * z[1],
        }
    }

    /// The derivative, per interval.
    pub(super) fn slope(&self, of: &Oscillator, (z, x): &Place<T>) -> f64 {
        let (high, low) = of.parts();
        let w = T::from(high) + T::from(low);
        let along = w * z[1];
        let rate = match self.factor == 0.0 {
            true => along,
            false => {
                let drag = T::from(2.0 * of.ratio) * along;
                along - self.kappa * (w * z[0] + drag + x[0])
            }
        };
        rate.to_f64()
    }

    /// The second derivative, about.
    pub(super) fn curvature(&self, of: &Oscillator, (z, x): &Place<T>) -> f64 {
        let (p, v) = (z[0].to_f64(), z[1].to_f64());
        let (a, b) = (x[0].to_f64(), x[1].to_f64());
        let rate = if of.turn == 0.0 { b } else { of.turn * b };
        let pulled = -of.w * p - 2.0 * of.ratio * of.w * v - a;
        let pulled_later = -of.w * of.w * v - 2.0 * of.ratio * of.w * pulled - rate;
        of.w * pulled + self.factor * pulled_later
    }

    /// No value within a part of an interval, `length` long, is larger in size: from its two ends.
    pub(super) fn bound(&self, of: &Oscillator, length: f64, from: &Place<T>, to: &Place<T>) -> T {
        let (first, last) = (self.value(&from.0), self.value(&to.0));
        let ends = larger(first.abs(), last.abs());
        let [d0, d1] = [from, to].map(|place| self.slope(of, place) * length);
        let rise = (last - first).to_f64();
        let sizes = d0.abs() + d1.abs() + rise.abs();
        // What is left of slopes of which the parts cancel.
        let lost = T::unit().to_f64() * 16.0 * length;
        let [_, fourth] = self.higher(of, length, from);
        let within = fourth * length.powi(4) / 384.0
            + SLACK * sizes
            + lost * (self.grain(of, from) + self.grain(of, to));
        let above = [1.0, -1.0].map(|sign: f64| {
            let most = cubic_maximum(sign * rise, sign * d0, sign * d1);
            T::from(sign) * first + T::from(most)
        });
        let cubic = larger(above[0], above[1]) + T::from(within * (1.0 + SLACK));
        let apart = T::from(self.apart(of, length, from));
        let mut least = if apart < cubic { apart } else { cubic };
        if let Some(split) = self.split(of, length, from, to).filter(|of| *of < least) {
            least = split;
        }
        larger(ends, if least.is_finite() { least } else { apart })
    }

    /// A bound of an overdamped motion under a straight law from its two parts: what the fast root s₂ leaves, β e^(s₂t), which only
    /// dies out, and the straight line with α e^(s₁t), which bends no faster than the slow root does. With m = ζ + √(ζ² − 1) the roots
    /// are −W/m and −Wm, and of free motions α = (v + m p)(1 − κ/m)/(m − 1/m), β = (v + p/m)(κm − 1)/(m − 1/m).
    fn split(&self, of: &Oscillator, length: f64, from: &Place<T>, to: &Place<T>) -> Option<T> {
        /// Nearer to critical damping both roots are alike, and shares are large and opposite.
        const APART: f64 = 1.5;
        /// More than the roundings of all products here, in units of the digits.
        const ROUNDINGS: f64 = 64.0;
        let is_straight = of.turn == 0.0 || from.1.iter().all(|part| part.is_zero());
        if of.ratio < APART || !is_straight {
            return None;
        }
        let (high, low) = of.parts();
        let w = T::from(high) + T::from(low);
        let ratio = T::from(of.ratio);
        let m = ratio + (ratio * ratio - T::ONE).sqrt();
        let apart = m - T::ONE / m;
        let slow_factor = (T::ONE - self.kappa / m) / apart;
        let fast_factor = (self.kappa * m - T::ONE) / apart;
        let (twice, double_m) = (2.0 * of.ratio, m.to_f64());
        // Shares of the two roots, and how far they may be off.
        let shares = |(z, x): &Place<T>| {
            let even_p = (T::from(twice) * x[1] / w - x[0]) / w;
            let even_v = -(x[1] / w) / w;
            let (p, v) = (z[0] - even_p, z[1] - even_v);
            let drag = twice * (x[1] / w / w).to_f64().abs();
            let size_p = z[0].to_f64().abs() + (x[0] / w).to_f64().abs() + drag;
            let size_v = z[1].to_f64().abs() + drag;
            let grain = ROUNDINGS * T::unit().to_f64();
            let slow = slow_factor * (v + m * p);
            let fast = fast_factor * (v + p / m);
            let slow_off = grain * slow_factor.to_f64().abs() * (size_v + double_m * size_p);
            let fast_off = grain * fast_factor.to_f64().abs() * (size_v + size_p / double_m);
            [(slow, slow_off), (fast, fast_off)]
        };
        let [first, last] = [from, to].map(shares);
        let slow_rate = of.w / double_m;
        let straight = -(from.1[1] / w).to_f64();
        // Slopes of the slow part at both ends, and how far they may be off.
        let slope = |(slow, off): (T, f64)| {
            let along = -slow_rate * slow.to_f64();
            let off = SLACK * (straight.abs() + along.abs()) + slow_rate * off;
            ((straight + along) * length, off * length)
        };
        let ((d0, off0), (d1, off1)) = (slope(first[0]), slope(last[0]));
        let [begin, end] =
            [(from, first), (to, last)].map(|(place, [_, (fast, _)])| self.value(&place.0) - fast);
        let rise = (end - begin).to_f64();
        let size = begin.to_f64().abs() + end.to_f64().abs();
        let fourth = first[0].0.to_f64().abs() + first[0].1;
        let within = fourth * (slow_rate * length).powi(4) / 384.0
            + SLACK * (rise.abs() + d0.abs() + d1.abs())
            + ROUNDINGS * T::unit().to_f64() * size
            + off0
            + off1
            + 2.0 * (first[1].1 + last[1].1);
        let above = [1.0, -1.0].map(|sign: f64| {
            let most = cubic_maximum(sign * rise, sign * d0, sign * d1);
            // It may be 0 before the part ends.
            let fast = [first, last].map(|[_, (fast, _)]| T::from(sign) * fast);
            let fast = larger(larger(fast[0], fast[1]), T::ZERO);
            T::from(sign) * begin + T::from(most) + fast
        });
        let bound = larger(above[0], above[1]) + T::from(within * (1.0 + SLACK));
        bound.is_finite().then_some(bound)
    }

    /// Bounds of the third and fourth derivative: of free motions derivatives do not grow either.
    pub(super) fn higher(&self, of: &Oscillator, length: f64, (z, x): &Place<T>) -> [f64; 2] {
        let [p, v] = z.map(T::to_f64);
        let [a, b, c] = x.map(T::to_f64);
        let (w, drag) = (of.w, 2.0 * of.ratio * of.w);
        let rate = if of.turn == 0.0 { b } else { of.turn * b };
        let (along, pulled) = (w * v, -w * p - drag * v - a);
        let (along, later) = (w * pulled, -w * along - drag * pulled - rate);
        let radius = (a - c).hypot(b);
        let (second, third) = (of.turn.powi(2) * radius, of.turn.powi(3) * radius);
        let sizes = of.norm * (of.norm * (p.abs() + v.abs()) + a.abs()) + rate.abs();
        let most = along.hypot(later) + length * second + SLACK * sizes;
        let cubed = of.norm * most + second;
        [cubed, of.norm * cubed + third].map(|size| self.norm * size * (1.0 + SLACK))
    }

    /// What roundings may leave of a slope or curvature here, per unit of the digits.
    pub(super) fn grain(&self, of: &Oscillator, (z, x): &Place<T>) -> f64 {
        let parts = z.iter().chain(x).map(|part| part.to_f64().abs());
        self.norm * (of.norm + 1.0) * parts.sum::<f64>()
    }

    /// A bound from the motion that would go on evenly and what is free beside it, which does not grow.
    fn apart(&self, of: &Oscillator, length: f64, (z, x): &Place<T>) -> f64 {
        let [p, v] = z.map(T::to_f64);
        let [a, b, c] = x.map(T::to_f64);
        if of.turn != 0.0 {
            let most = c.abs() + (a - c).hypot(b);
            return self.norm * (p.hypot(v) + length * most) * (1.0 + SLACK);
        }
        let w = of.w;
        let even = |a: f64| (-a / w + 2.0 * of.ratio * b / (w * w), -b / (w * w));
        let (from, to) = (even(a), even(a + b * length));
        let sizes = (a.abs() + b.abs() * length) / w + (1.0 + 2.0 * of.ratio) * b.abs() / (w * w);
        let free = (p - from.0).hypot(v - from.1) + SLACK * (p.abs() + v.abs() + sizes);
        let ends = [from, to].map(|(p, v)| self.rough(p, v).abs());
        (ends[0].max(ends[1]) + self.norm * (free + SLACK * sizes)) * (1.0 + SLACK)
    }
}

/// The largest value on [0, 1] of the cubic that is 0 at 0 and `rise` at 1, with these slopes there.
fn cubic_maximum(rise: f64, d0: f64, d1: f64) -> f64 {
    // In a unit of their own size, so that squares stay in the range of doubles.
    let unit = rise.abs().max(d0.abs()).max(d1.abs());
    if unit == 0.0 || !unit.is_finite() {
        return unit;
    }
    let [rise, d0, d1] = [rise, d0, d1].map(|of| of / unit);
    let square = 3.0 * rise - 2.0 * d0 - d1;
    let cube = d0 + d1 - 2.0 * rise;
    let value = |s: f64| s * (d0 + s * (square + s * cube));
    let mut most = rise.max(0.0);
    // 3 cube s² + 2 square s + d0 = 0.
    let inside = square * square - 3.0 * cube * d0;
    if inside >= 0.0 {
        let q = -(square + inside.sqrt().copysign(square));
        for s in [q / (3.0 * cube), d0 / q] {
            if (0.0..=1.0).contains(&s) {
                most = most.max(value(s));
            }
        }
    }
    most * unit
}

fn larger<T: Real>(a: T, b: T) -> T {
    if a < b { b } else { a }
}
