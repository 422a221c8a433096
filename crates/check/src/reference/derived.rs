//! What follows from an eigenvalue, each with a radius of its own.

use super::ball::Ball;
use super::elementary::pi;
use super::modes::ReferenceEigenvalue;

impl ReferenceEigenvalue {
    /// ω_n = |λ|, in rad/s.
    pub fn natural_frequency(&self) -> Ball {
        // A part that is 0 exactly needs no root of a square, which would cost an exact value.
        match (self.re.is_zero(), self.im.is_zero()) {
            (true, _) => self.im.abs(),
            (_, true) => self.re.abs(),
            _ => (&self.re * &self.re + &self.im * &self.im).sqrt(),
        }
    }

    /// ω_n/2π, in Hz.
    pub fn hertz(&self) -> Ball {
        let natural = self.natural_frequency();
        let turn = pi(natural.bits() + 32).scaled(1);
        natural / turn
    }

    /// ω_d = |Im λ|, in rad/s.
    pub fn damped_frequency(&self) -> Ball {
        self.im.abs()
    }

    /// ζ = −Re λ/|λ| of a complex root; `None` for a real one.
    pub fn damping_ratio(&self) -> Option<Ball> {
        match (self.re.is_zero(), self.im.is_zero()) {
            (_, true) => None,
            (true, false) => Some(Ball::zero()),
            _ => Some(-(&self.re / &self.natural_frequency())),
        }
    }

    /// −Re λ, in 1/s.
    pub fn decay_rate(&self) -> Ball {
        -&self.re
    }

    /// 1/(−Re λ) in s, of a root that is known to decay.
    pub fn time_constant(&self) -> Option<Ball> {
        let rate = self.decay_rate();
        rate.is_positive().then(|| Ball::from(1) / rate)
    }
}

#[cfg(test)]
mod tests {
    use eigentone_modes::{GROUND, System};

    use crate::reference::Reference;

    #[test]
    fn a_textbook_mass_has_its_textbook_numbers() {
        // m = 1, k = 4, c = 1: λ = −1/2 ± i √15/2, ω_n = 2, ζ = 1/4.
        let system = System::builder()
            .mass("m", 1.0)
            .spring(GROUND, "m", 4.0)
            .damper(GROUND, "m", 1.0)
            .build()
            .expect("a system");
        let modes = Reference::default().modes(&system).expect("it is small");
        let root = &modes.eigenvalues()[0];
        let digits = |ball: super::Ball| ball.decided(20).expect("34 digits are known");
        assert_eq!(digits(root.natural_frequency()), "2.0000000000000000000e0");
        assert_eq!(digits(root.damped_frequency()), "1.9364916731037084426e0");
        assert_eq!(digits(root.decay_rate()), "5.0000000000000000000e-1");
        let time = root.time_constant().expect("it decays");
        assert_eq!(digits(time), "2.0000000000000000000e0");
        let ratio = root.damping_ratio().expect("it oscillates");
        assert_eq!(digits(ratio), "2.5000000000000000000e-1");
        // 1/π, from mpmath.
        assert_eq!(digits(root.hertz()), "3.1830988618379067154e-1");
    }
}
