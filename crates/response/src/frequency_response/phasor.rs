//! e^{iφ} in ball arithmetic, for any double φ.

use eigentone_digits::{Ball, Magnitude, Real, WideComplex};

/// What a harmonic force of amplitude 1 is multiplied by, for its phase.
#[derive(Clone, Copy, Debug)]
pub(super) enum Phase {
    /// 1.
    Zero,
    /// e^{iφ}.
    Forward(f64),
    /// The frequency is negative: sin(−Ωt + φ) = Im(−e^{−iφ} e^{iΩt}).
    Backward(f64),
    /// The frequency is 0, and only sin φ acts.
    Still(f64),
}

impl Phase {
    pub(super) fn factor<T: Real>(self) -> Ball<T> {
        let phase = match self {
            Phase::Zero => 0.0,
            Phase::Forward(phase) | Phase::Backward(phase) | Phase::Still(phase) => phase,
        };
        let ball = phasor::<T>(phase);
        let WideComplex { re, im } = ball.middle();
        let re = match self {
            Phase::Zero | Phase::Forward(_) => re,
            Phase::Backward(_) => -re,
            Phase::Still(_) => T::ZERO,
        };
        Ball::new(WideComplex { re, im }, ball.radius())
    }
}

/// e^{iφ}: Taylor's series of φ/2^k, squared k times. No reduction by turns is needed, so that π
/// need not be known: each squaring costs about a bit, which a larger precision makes up for.
fn phasor<T: Real>(phase: f64) -> Ball<T> {
    /// Below it the series gains as many bits with each term.
    const SMALL: i64 = -8;
    let halvings = (Magnitude::from(phase).exponent() - SMALL).max(0);
    let angle = T::from(phase).scale(-halvings);
    let angle = Ball::new(
        WideComplex {
            re: T::ZERO,
            im: angle,
        },
        T::floor(),
    );
    let one = Ball::from(WideComplex {
        re: T::ONE,
        im: T::ZERO,
    });
    let (mut sum, mut term, mut index) = (one, one, 1.0);
    while term.upper() > T::unit() {
        let divisor = Ball::from(WideComplex {
            re: T::from(index),
            im: T::ZERO,
        });
        term = (term * angle)
            .checked_div(divisor)
            .expect("the index is not 0");
        sum = sum + term;
        index += 1.0;
    }
    // What is left out is less than the last term, of which each one is less than half the former.
    let mut result = Ball::new(sum.middle(), sum.radius() + term.upper());
    for _ in 0..halvings {
        result = result * result;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_digits::{DoubleDouble, Wide};

    /// |re − cos|, |im − sin| against 17 or more digits from elsewhere.
    fn assert_phasor<T: Real>(phase: f64, cosine: [f64; 2], sine: [f64; 2]) {
        let z = phasor::<T>(phase);
        let truth = Ball::from(WideComplex {
            re: T::from(cosine[0]) + T::from(cosine[1]),
            im: T::from(sine[0]) + T::from(sine[1]),
        });
        let off = (z - truth).upper();
        // The truth is a sum of two doubles.
        let allowed = z.radius() + Magnitude::from(1e-32);
        assert!(off <= allowed * Magnitude::from(1.01), "{phase}: {z:?}");
        assert!(z.radius() < Magnitude::from(1e-20));
    }

    #[test]
    fn cosine_and_sine_to_32_digits() {
        // mpmath, 40 digits, split in two doubles.
        let cosine = [0.955336489125606, 4.1935600297907467e-17];
        let sine = [0.29552020666133955, 1.8315357276792536e-17];
        assert_phasor::<DoubleDouble>(0.3, cosine, sine);
        assert_phasor::<Wide<4>>(0.3, cosine, sine);
        let cosine = [0.523214785395139, -4.7143201076575164e-17];
        let sine = [-0.8522008497671888, -6.7806825896773284e-18];
        assert_phasor::<Wide<4>>(1e22, cosine, sine);
        assert_phasor::<Wide<4>>(-1e22, cosine, sine.map(|part| -part));
    }

    #[test]
    fn any_phase_ends_on_the_unit_circle() {
        for phase in [0.0, 5e-324, -1.0, 1e6, f64::MAX] {
            let z = phasor::<Wide<32>>(phase);
            assert!(z.radius() < Magnitude::from(1e-30), "{phase:e}");
            let size = z.middle().norm();
            assert!((size - 1.0).abs() < 1e-15, "{phase:e}: {size}");
        }
        assert_eq!(phasor::<DoubleDouble>(0.0).middle().im.to_f64(), 0.0);
    }
}
