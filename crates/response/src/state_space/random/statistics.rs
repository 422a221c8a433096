//! What is known of a stationary motion: root mean squares, how often it passes through 0, and its expected peaks.

use eigentone_digits::{Magnitude, Real};

/// The root of the mean square of a stationary motion.
#[derive(Clone, Debug, PartialEq)]
pub enum Rms {
    /// It is within `bound` of `value`.
    Finite {
        /// The nearest double.
        value: f64,
        /// How far it may be off, its rounding included.
        bound: f64,
    },
    /// It is infinite: white noise passes on at once, or what it moves wanders without end.
    Infinite {
        /// The noise that makes it so.
        by: String,
    },
    /// No digits in reach decide whether it is finite.
    Undecided {
        /// The noise of which they do not decide whether it passes on at once.
        by: String,
    },
}

impl Rms {
    /// √variance; `None` where nothing is known of it, or where it is beyond the doubles.
    pub(super) fn of_variance<T: Real>(variance: T, radius: Magnitude) -> Option<Rms> {
        let size = variance.upper();
        let [value, bound] = if variance <= T::ZERO || size <= radius {
            [0.0, (size + radius).sqrt().to_f64()]
        } else {
            let root = variance.sqrt();
            let value = root.to_f64();
            // |√t − √v| ≤ |t − v|/√v, and √v is within four quotients' errors of what is computed for it.
            let least = (root * T::from(0.99)).upper();
            let rounding = root.upper() * T::unit() * Magnitude::from(4.0) + T::floor();
            let off = radius / least + rounding + (root - T::from(value)).upper();
            [value, off.to_f64()]
        };
        let known = value.is_finite() && bound.is_finite();
        known.then_some(Rms::Finite { value, bound })
    }

    /// The value and how far it may be off, where it is finite.
    pub fn finite(&self) -> Option<(f64, f64)> {
        match self {
            Rms::Finite { value, bound } => Some((*value, *bound)),
            Rms::Infinite { .. } | Rms::Undecided { .. } => None,
        }
    }
}

/// What is known of one stationary motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics {
    /// Of which coordinate, point or output.
    pub name: String,
    /// Its root mean square.
    pub rms: Rms,
    /// The root mean square of its rate of change.
    pub rate: Rms,
}

impl Statistics {
    /// How often a second it passes through 0 upwards on average, σ_ẏ/2πσ_y, in Hz, and a bound of the error, where both are
    /// finite and not 0: Rice's formula (1944, *Bell Syst. Tech. J.* 23), for noise that is Gaussian.
    pub fn zero_crossings(&self) -> Option<(f64, f64)> {
        let ((y, a), (rate, b)) = (self.rms.finite()?, self.rate.finite()?);
        // (1 + ε)/(1 − δ) is within 2(ε + δ) of 1, and there are four roundings.
        let value = rate / y / std::f64::consts::TAU;
        let off = 2.0 * (a / y + b / rate) + 4.0 * f64::EPSILON;
        let bound = (value * off).next_up();
        let known = off <= 0.5 && value >= f64::MIN_POSITIVE / f64::EPSILON && bound.is_finite();
        known.then_some((value, bound))
    }

    /// The largest |y| to be expected within `duration` s on average, and a bound of what rounding and the errors of σ and ν
    /// make of it: σ(√(2 ln νT) + γ/√(2 ln νT)) with ν the rate of zero crossings on both sides of 0, twice that of those
    /// upwards, and γ = 0.5772… (Davenport 1964, *Proc. Inst. Civ. Eng.* 28). The formula takes peaks for independent and
    /// holds for many: `None` below νT = 10, where crossings are not known, and for a duration that is not finite.
    pub fn expected_peak(&self, duration: f64) -> Option<(f64, f64)> {
        const EULER: f64 = 0.577_215_664_901_532_9;
        let ((sigma, a), (rate, b)) = (self.rms.finite()?, self.zero_crossings()?);
        let count = 2.0 * rate * duration;
        if !(count.is_finite() && count >= 10.0) {
            return None;
        }
        let root = (2.0 * count.ln()).sqrt();
        let factor = root + EULER / root;
        let value = sigma * factor;
        // d factor/d ln νT = (1 − γ/root²)/root < 1/root; each function errs by an ulp or two.
        let bound = a * factor + sigma * 2.0 * (b / rate) / root + value * 16.0 * f64::EPSILON;
        (value.is_finite() && bound.is_finite()).then_some((value, bound.next_up()))
    }
}
