//! The amplitudes of all coordinates under forces of one frequency, with proven bounds.

use eigentone_digits::{Ball, DoubleDouble, Magnitude, Real, Wide, WideComplex};
use eigentone_modes::{System, dense_gigabytes};
use num_complex::Complex;
use thiserror::Error;

use super::dynamic_stiffness::DynamicStiffness;
use super::elimination::{Outcome, scaled, solve};
use super::phasor::phasor;

/// A motion x(t) = Im(X e^{iΩt}) of all coordinates with one frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct HarmonicMotion {
    frequency: f64,
    displacement: Vec<Complex<f64>>,
    bound: Vec<f64>,
}

impl HarmonicMotion {
    /// Ω in rad/s.
    pub fn frequency(&self) -> f64 {
        self.frequency
    }

    /// X: the complex amplitude of each coordinate, in m.
    pub fn displacement(&self) -> &[Complex<f64>] {
        &self.displacement
    }

    /// For each coordinate a proven bound of how far [`displacement`](Self::displacement) is from
    /// the exact amplitude, in m. It is a few units in the last place of the amplitude itself,
    /// unless that is less than 1e-30 of the largest one.
    pub fn bound(&self) -> &[f64] {
        &self.bound
    }

    /// iΩX: the amplitudes of the velocities, in m/s, rounded once more.
    pub fn velocity(&self) -> Vec<Complex<f64>> {
        let turned = |x: &Complex<f64>| Complex::new(-x.im, x.re) * self.frequency;
        self.displacement.iter().map(turned).collect()
    }

    /// −Ω²X: the amplitudes of the accelerations, in m/s², rounded twice more.
    pub fn acceleration(&self) -> Vec<Complex<f64>> {
        let twice = |x: &Complex<f64>| -*x * self.frequency * self.frequency;
        self.displacement.iter().map(twice).collect()
    }

    /// X_to / X_from, the transmissibility from one coordinate to another, by their indices; `None`
    /// where an index is out of range or the first coordinate stands still.
    pub fn transmissibility(&self, from: usize, to: usize) -> Option<Complex<f64>> {
        let (from, to) = (self.displacement.get(from)?, self.displacement.get(to)?);
        let ratio = to / from;
        ratio.is_finite().then_some(ratio)
    }
}

/// Why there is no steady state.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SteadyStateError {
    /// K − Ω²M + iΩC is proved to be singular.
    #[error(
        "{frequency:?} rad/s is a natural frequency without damping: the motion there grows or is not determined"
    )]
    Resonance {
        /// Ω in rad/s.
        frequency: f64,
    },
    /// K is proved to be singular, and a constant load asks for an equilibrium.
    #[error("a load of frequency 0 is constant, and no springs hold what it acts on")]
    Unsupported,
    /// The highest precision does not tell K − Ω²M + iΩC from a singular matrix.
    #[error(
        "{frequency:?} rad/s cannot be told from a natural frequency without damping, even with {digits} digits"
    )]
    Undecided {
        /// Ω in rad/s.
        frequency: f64,
        /// The digits that were tried.
        digits: usize,
    },
    /// A sinusoid moves a support, or acts on a point.
    #[error(
        "a sinusoid moves a support or acts on a point: only forces on single coordinates are counted"
    )]
    Channel,
    /// An amplitude exceeds the largest double.
    #[error("an amplitude at {frequency:?} rad/s exceeds the largest double")]
    OutOfRange {
        /// Ω in rad/s.
        frequency: f64,
    },
    /// The system is [large](System::is_large).
    #[error(
        "amplitudes need all {coordinates} coordinates as dense matrices with many digits, {gigabytes:.1} GB in doubles alone: look at its lowest modes, by ModalTruncation"
    )]
    TooLarge {
        /// How many coordinates there are.
        coordinates: usize,
        /// What M, C, K and one state matrix would take.
        gigabytes: f64,
    },
    /// A frequency is infinite or NaN.
    #[error("the frequency is {frequency:?}: it must be a finite number")]
    FrequencyNotFinite {
        /// The frequency given.
        frequency: f64,
    },
    /// A name that is no coordinate.
    #[error("{name:?} is not a coordinate: known are {known}")]
    UnknownCoordinate {
        /// The name given.
        name: String,
        /// The names that exist.
        known: String,
    },
}

/// How a force of some phase turns.
#[derive(Clone, Copy, Debug)]
pub(super) enum Sense {
    /// amplitude·e^{i·phase}.
    Forward,
    /// The frequency is negative: sin(−Ωt + φ) = Im(−e^{−iφ} e^{iΩt}).
    Backward,
    /// The frequency is 0, and only amplitude·sin(phase) acts.
    Still,
}

/// A harmonic force on one coordinate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Force {
    pub(super) coordinate: usize,
    pub(super) amplitude: f64,
    pub(super) phase: f64,
    pub(super) sense: Sense,
}

impl Force {
    fn phasor<T: Real>(&self) -> Ball<T> {
        let ball = phasor::<T>(self.phase);
        let (mut middle, radius) = (ball.middle(), ball.radius());
        match self.sense {
            Sense::Forward => {}
            Sense::Backward => middle.re = -middle.re,
            Sense::Still => middle.re = T::ZERO,
        }
        Ball::new(middle, radius) * self.amplitude
    }
}

/// One precision of the ladder.
struct Rung {
    limbs: u64,
    digits: usize,
    run: fn(&DynamicStiffness, &[Force]) -> (Answer, u64),
}

const LADDER: [Rung; 6] = [
    Rung {
        limbs: 2,
        digits: 32,
        run: answer::<DoubleDouble>,
    },
    Rung {
        limbs: 4,
        digits: 77,
        run: answer::<Wide<4>>,
    },
    Rung {
        limbs: 8,
        digits: 154,
        run: answer::<Wide<8>>,
    },
    Rung {
        limbs: 16,
        digits: 308,
        run: answer::<Wide<16>>,
    },
    Rung {
        limbs: 32,
        digits: 616,
        run: answer::<Wide<32>>,
    },
    Rung {
        limbs: 64,
        digits: 1233,
        run: answer::<Wide<64>>,
    },
];

/// Limbwise products that a rung beyond the first may take.
const MOST_WORK: u64 = 1_000_000_000;

/// What one precision gives.
enum Answer {
    /// Amplitudes with bounds, and whether they are as good as doubles can be.
    Found(Vec<(Complex<f64>, f64)>, bool),
    /// The matrix is proved to be singular.
    Singular,
    /// It may be singular.
    Unknown,
}

/// The amplitudes under forces of one frequency.
pub(super) fn motion(
    system: &System,
    frequency: f64,
    forces: &[Force],
) -> Result<HarmonicMotion, SteadyStateError> {
    if system.is_large() {
        let coordinates = system.len();
        return Err(SteadyStateError::TooLarge {
            coordinates,
            gigabytes: dense_gigabytes(coordinates),
        });
    }
    let loaded = forces.iter().filter(|force| force.amplitude != 0.0);
    let loaded: Vec<usize> = loaded.map(|force| force.coordinate).collect();
    let stiffness = DynamicStiffness::of(system, frequency, &loaded);
    let mut found = None;
    let (mut digits, mut work) = (0, 0u64);
    for rung in &LADDER {
        if work.saturating_mul(rung.limbs * rung.limbs + 20) > MOST_WORK {
            break;
        }
        let (answer, products) = (rung.run)(&stiffness, forces);
        (digits, work) = (rung.digits, products);
        match answer {
            Answer::Found(amplitudes, good) => {
                found = Some(amplitudes);
                if good {
                    break;
                }
            }
            Answer::Singular if frequency == 0.0 => return Err(SteadyStateError::Unsupported),
            Answer::Singular => return Err(SteadyStateError::Resonance { frequency }),
            Answer::Unknown => {}
        }
    }
    let found = found.ok_or(SteadyStateError::Undecided { frequency, digits })?;
    if found
        .iter()
        .any(|(x, bound)| !(x.is_finite() && bound.is_finite()))
    {
        return Err(SteadyStateError::OutOfRange { frequency });
    }
    let mut displacement = vec![Complex::ZERO; system.len()];
    let mut bound = vec![0.0; system.len()];
    for (&coordinate, (x, off)) in stiffness.coordinates().iter().zip(found) {
        (displacement[coordinate], bound[coordinate]) = (x, off);
    }
    Ok(HarmonicMotion {
        frequency,
        displacement,
        bound,
    })
}

/// One rung: the amplitudes in the precision of T, and the products it took.
fn answer<T: Real>(stiffness: &DynamicStiffness, forces: &[Force]) -> (Answer, u64) {
    let (rows, exponents) = stiffness.rows::<T>();
    let mut right = vec![Ball::ZERO; exponents.len()];
    for force in forces.iter().filter(|force| force.amplitude != 0.0) {
        let place = stiffness.coordinates().binary_search(&force.coordinate);
        let place = place.expect("what is loaded is reached");
        right[place] = right[place] + scaled(force.phasor::<T>(), -exponents[place]);
    }
    let (outcome, work) = solve(rows, right);
    let answer = match outcome {
        Outcome::Solved(x) => {
            let x = x.into_iter().zip(exponents);
            let x: Vec<Ball<T>> = x.map(|(x, power)| scaled(x, -power)).collect();
            let good = is_good(&x);
            Answer::Found(x.into_iter().map(rounded).collect(), good)
        }
        Outcome::Singular(determinant) => {
            let shift: i64 = exponents.iter().map(|power| 2 * power).sum();
            let least = Magnitude::power_of_two(stiffness.grain() - shift);
            if determinant < least {
                Answer::Singular
            } else {
                Answer::Unknown
            }
        }
    };
    (answer, work)
}

/// Whether every number is known to a double's last digit, or is nothing beside the largest.
fn is_good<T: Real>(x: &[Ball<T>]) -> bool {
    const LAST_DIGIT: i64 = -56;
    const NOTHING: f64 = 1e-30;
    let largest = x.iter().map(|x| x.lower());
    let largest = largest.fold(Magnitude::ZERO, |a, b| if a < b { b } else { a });
    let nothing = largest * Magnitude::from(NOTHING);
    x.iter().all(|x| {
        let least = x.lower() * Magnitude::power_of_two(LAST_DIGIT);
        x.radius() <= least || x.radius() <= nothing
    })
}

/// The double nearest to a ball's middle, each part 0 if it cannot be told from 0, and how far the
/// ball reaches from that.
fn rounded<T: Real>(x: Ball<T>) -> (Complex<f64>, f64) {
    let middle = x.middle();
    let part = |part: T| {
        if part.magnitude() <= x.radius() {
            0.0
        } else {
            part.to_f64()
        }
    };
    let value = Complex::new(part(middle.re), part(middle.im));
    let back = Ball::from(WideComplex {
        re: T::from(value.re),
        im: T::from(value.im),
    });
    (value, (x - back).upper().to_f64())
}
