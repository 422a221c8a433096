//! Two masses and three springs, ground – m₁ – m₂ – ground, in any number of digits (S. S. Rao,
//! *Mechanical Vibrations*, §5.3).
//!
//! The squares of the natural frequencies solve
//! m₁m₂ ω⁴ − (m₁(k₂ + k₁₂) + m₂(k₁ + k₁₂)) ω² + k₁k₂ + k₁k₁₂ + k₂k₁₂ = 0. With
//! Δ = (m₁(k₂ + k₁₂) − m₂(k₁ + k₁₂))² + 4 m₁m₂ k₁₂², the discriminant without its cancellation,
//!
//! ω₊² = (m₁(k₂ + k₁₂) + m₂(k₁ + k₁₂) + √Δ)/2m₁m₂,  ω₋² = (k₁k₂ + k₁k₁₂ + k₂k₁₂)/(m₁m₂ ω₊²).
//!
//! With W = M⁻¹K, every motion is a function of W applied to a vector, and by Sylvester's formula
//! f(W) = f(ω₋²) I + (f(ω₊²) − f(ω₋²))/(ω₊² − ω₋²) (W − ω₋² I), where Δ ≠ 0:
//!
//! | motion | f(ω²) | its rate |
//! |---|---|---|
//! | released | cos ωt | −ω sin ωt |
//! | pushed off | sin(ωt)/ω | cos ωt |
//! | under constant forces, from M⁻¹F | (1 − cos ωt)/ω² | sin(ωt)/ω |

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::Zero;

use super::digits::{ClosedFormError, ExactMotion, coefficient, exactly, mass, motions, to_digits};
use crate::reference::Ball;

/// Two masses, a spring between them and one from each to ground, all of which may be missing;
/// undamped.
#[derive(Clone, Debug, PartialEq)]
pub struct UndampedPair {
    masses: [BigRational; 2],
    /// K by rows.
    stiffness: [[BigRational; 2]; 2],
    /// det K, without cancellation.
    determinant: BigRational,
    digits: u32,
}

/// ω₋² and ω₊² with what is made of them after some time.
struct Swing {
    square: Ball,
    /// cos ωt, sin(ωt)/ω, (1 − cos ωt)/ω².
    cos: Ball,
    sin: Ball,
    step: Ball,
}

impl UndampedPair {
    /// Masses m₁ and m₂ in kg, springs in N/m from m₁ to ground, between the two, and from m₂ to
    /// ground; 34 digits.
    ///
    /// # Errors
    /// [`ClosedFormError`] unless all are finite, masses positive and springs not negative.
    pub fn new(masses: [f64; 2], springs: [f64; 3]) -> Result<UndampedPair, ClosedFormError> {
        let [k1, k12, k2] = [
            coefficient(springs[0])?,
            coefficient(springs[1])?,
            coefficient(springs[2])?,
        ];
        Ok(UndampedPair {
            masses: [mass(masses[0])?, mass(masses[1])?],
            determinant: &k1 * &k2 + &k1 * &k12 + &k2 * &k12,
            stiffness: [[&k1 + &k12, -&k12], [-&k12, &k2 + &k12]],
            digits: 34,
        })
    }

    /// The same to another number of decimal digits of every value.
    pub fn with_digits(self, digits: u32) -> UndampedPair {
        UndampedPair { digits, ..self }
    }

    /// Both natural frequencies in rad/s, ascending.
    pub fn natural_frequencies(&self) -> [Ball; 2] {
        let roots = |bits| self.squares(bits).map(|square| square.sqrt()).to_vec();
        let mut found = to_digits(self.digits, roots).into_iter();
        [0, 1].map(|_| found.next().unwrap_or_else(Ball::zero))
    }

    /// The motion of both masses at `t` s from displacements `x0` in m and velocities `v0` in m/s.
    pub fn free(&self, x0: [f64; 2], v0: [f64; 2], t: f64) -> Vec<ExactMotion> {
        self.motion(t, |pair, bits| {
            let (x0, v0) = (x0.map(|x| exactly(x, bits)), v0.map(|v| exactly(v, bits)));
            let back = |swing: &Swing| -(&swing.square * &swing.sin);
            let displacement = plus(
                pair.apply(|f| f.cos.clone(), &x0),
                pair.apply(|f| f.sin.clone(), &v0),
            );
            let velocity = plus(pair.apply(back, &x0), pair.apply(|f| f.cos.clone(), &v0));
            [displacement, velocity]
        })
    }

    /// The motion from rest of both masses `t` s after constant forces in N set in.
    pub fn step(&self, forces: [f64; 2], t: f64) -> Vec<ExactMotion> {
        self.motion(t, |pair, bits| {
            let pull =
                [0, 1].map(|i| exactly(forces[i], bits) / Ball::rational(&self.masses[i], bits));
            [
                pair.apply(|f| f.step.clone(), &pull),
                pair.apply(|f| f.sin.clone(), &pull),
            ]
        })
    }

    fn motion(&self, t: f64, form: impl Fn(&Pair, u64) -> [[Ball; 2]; 2]) -> Vec<ExactMotion> {
        motions(to_digits(self.digits, |bits| {
            form(&self.pair(t, bits), bits)
                .into_iter()
                .flatten()
                .collect()
        }))
    }

    /// ω₋² and ω₊².
    fn squares(&self, bits: u64) -> [Ball; 2] {
        let [m1, m2] = &self.masses;
        let (a, b) = (m1 * &self.stiffness[1][1], m2 * &self.stiffness[0][0]);
        let root = Ball::rational(&self.discriminant(), bits).sqrt();
        let product = Ball::rational(&(m1 * m2), bits);
        let upper = (Ball::rational(&(a + b), bits) + root) / product.clone().scaled(1);
        let lower = match self.determinant.is_zero() {
            true => Ball::zero().with_bits(bits),
            false => Ball::rational(&self.determinant, bits) / (product * &upper),
        };
        [lower, upper]
    }

    /// Δ.
    fn discriminant(&self) -> BigRational {
        let [m1, m2] = &self.masses;
        let difference = m1 * &self.stiffness[1][1] - m2 * &self.stiffness[0][0];
        let coupling = &self.stiffness[0][1] * &self.stiffness[1][0];
        &difference * &difference + m1 * m2 * coupling * BigInt::from(4)
    }

    fn pair(&self, t: f64, bits: u64) -> Pair {
        let time = exactly(t, bits);
        let swings = self.squares(bits).map(|square| {
            let omega = square.sqrt();
            let (sin, cos) = (&omega * &time).sin_cos();
            match omega.is_zero() {
                true => Swing {
                    sin: time.clone(),
                    step: (&time * &time).scaled(-1),
                    cos,
                    square,
                },
                false => Swing {
                    sin: sin / omega,
                    step: (Ball::from(1) - &cos) / &square,
                    cos,
                    square,
                },
            }
        });
        let entry =
            |i: usize, j: usize| Ball::rational(&(&self.stiffness[i][j] / &self.masses[i]), bits);
        Pair {
            swings,
            alike: self.discriminant().is_zero(),
            matrix: [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]],
        }
    }
}

/// W and its two eigenvalues, which may be one.
struct Pair {
    swings: [Swing; 2],
    alike: bool,
    matrix: [[Ball; 2]; 2],
}

impl Pair {
    /// f(W) u.
    fn apply(&self, f: impl Fn(&Swing) -> Ball, u: &[Ball; 2]) -> [Ball; 2] {
        let [slow, fast] = &self.swings;
        let plain = f(slow);
        if self.alike {
            return [0, 1].map(|i| &plain * &u[i]);
        }
        let slope = (f(fast) - &plain) / (&fast.square - &slow.square);
        [0, 1].map(|i| {
            let image = &self.matrix[i][0] * &u[0] + &self.matrix[i][1] * &u[1];
            &plain * &u[i] + &slope * (image - &slow.square * &u[i])
        })
    }
}

fn plus(a: [Ball; 2], b: [Ball; 2]) -> [Ball; 2] {
    [0, 1].map(|i| &a[i] + &b[i])
}
