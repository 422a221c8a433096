//! A chain of equal masses on equal springs, in any number of digits (R. D. Blevins, *Formulas for
//! Natural Frequency and Mode Shape*, table 6-2).
//!
//! A motion sin(ωt) of the shape φ(i) = cos(iθ + const.) in an endless chain has
//! ω = 2 √(k/m) sin(θ/2); the ends choose θ and the constant:
//!
//! | ends | θ_j, j = 1 … n | φ_j(i), i = 1 … n | Σ_i φ_j(i)² |
//! |---|---|---|---|
//! | both to ground | jπ/(n + 1) | sin iθ_j | (n + 1)/2 |
//! | the first to ground | (2j − 1)π/(2n + 1) | sin iθ_j | (2n + 1)/4 |
//! | free | (j − 1)π/n | cos (i − ½)θ_j | n/2, for j = 1 n |
//!
//! All masses being equal, shapes are orthogonal, and a free motion is
//! x_i(t) = Σ_j φ_j(i) (a_j cos ω_j t + b_j sin(ω_j t)/ω_j) with a_j = Σ_i φ_j(i) x_i(0)/Σ_i φ_j(i)² and
//! b_j likewise from the velocities; for ω = 0 it is a_j + b_j t.

use num_rational::BigRational;

use super::digits::{ClosedFormError, ExactMotion, coefficient, exactly, mass, motions, to_digits};
use crate::reference::{Ball, pi};

/// How a chain is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChainEnds {
    /// By a spring to ground at each end.
    BothGrounded,
    /// By a spring to ground at the first mass.
    FirstGrounded,
    /// Not at all.
    Free,
}

/// Equal masses in a row, each joined to the next by one of equal springs; undamped.
#[derive(Clone, Debug, PartialEq)]
pub struct UniformChain {
    ends: ChainEnds,
    count: usize,
    /// k/m.
    rate_squared: BigRational,
    digits: u32,
}

/// One mode: ω, and φ for each mass divided by the square root of Σφ².
struct Shape {
    frequency: Ball,
    components: Vec<Ball>,
    square: Ball,
}

impl UniformChain {
    /// A chain of `count` masses of `m` kg on springs of `stiffness` N/m; 34 digits.
    ///
    /// # Errors
    /// [`ClosedFormError`] unless there is a mass, both are finite, the mass positive and the stiffness not negative.
    pub fn new(
        ends: ChainEnds,
        count: usize,
        m: f64,
        stiffness: f64,
    ) -> Result<UniformChain, ClosedFormError> {
        if count == 0 {
            return Err(ClosedFormError::NoMasses);
        }
        Ok(UniformChain {
            ends,
            count,
            rate_squared: coefficient(stiffness)? / mass(m)?,
            digits: 34,
        })
    }

    /// The same to another number of decimal digits of every value.
    pub fn with_digits(self, digits: u32) -> UniformChain {
        UniformChain { digits, ..self }
    }

    /// All natural frequencies in rad/s, ascending.
    pub fn natural_frequencies(&self) -> Vec<Ball> {
        let frequency = |bits| move |j| self.frequency(j, bits);
        to_digits(self.digits, |bits| {
            (1..=self.count).map(frequency(bits)).collect()
        })
    }

    /// The motion of every mass at `t` s from displacements `x0` in m and velocities `v0` in m/s.
    ///
    /// # Errors
    /// [`ClosedFormError::State`] unless there is one of each for every mass.
    pub fn free(
        &self,
        x0: &[f64],
        v0: &[f64],
        t: f64,
    ) -> Result<Vec<ExactMotion>, ClosedFormError> {
        let mut motions = self.free_at(x0, v0, &[t])?;
        Ok(motions.pop().expect("one for each time"))
    }

    /// The same at several `times`, for which shapes are computed once.
    ///
    /// # Errors
    /// As for [`free`](Self::free).
    pub fn free_at(
        &self,
        x0: &[f64],
        v0: &[f64],
        times: &[f64],
    ) -> Result<Vec<Vec<ExactMotion>>, ClosedFormError> {
        for state in [x0, v0] {
            if state.len() != self.count {
                return Err(ClosedFormError::State {
                    given: state.len(),
                    masses: self.count,
                });
            }
        }
        let values = to_digits(self.digits, |bits| self.superpose(x0, v0, times, bits));
        let instants = values.chunks(2 * self.count);
        Ok(instants.map(|values| motions(values.to_vec())).collect())
    }

    /// For each time displacements, then velocities.
    fn superpose(&self, x0: &[f64], v0: &[f64], times: &[f64], bits: u64) -> Vec<Ball> {
        let width = 2 * self.count;
        let mut values = vec![Ball::zero().with_bits(bits); width * times.len()];
        for j in 1..=self.count {
            let shape = self.shape(j, bits);
            let share = |state: &[f64]| {
                let terms = shape.components.iter().zip(state);
                let terms = terms.map(|(phi, value)| phi * exactly(*value, bits));
                terms.fold(Ball::zero(), |sum, term| sum + term) / &shape.square
            };
            let (a, b) = (share(x0), share(v0));
            let omega = &shape.frequency;
            for (values, t) in values.chunks_mut(width).zip(times) {
                let time = exactly(*t, bits);
                let (sin, cos) = (omega * &time).sin_cos();
                let drift = if omega.is_zero() { time } else { &sin / omega };
                let displacement = &a * &cos + &b * drift;
                let velocity = &b * cos - &a * omega * sin;
                for (i, phi) in shape.components.iter().enumerate() {
                    values[i] = &values[i] + phi * &displacement;
                    values[self.count + i] = &values[self.count + i] + phi * &velocity;
                }
            }
        }
        values
    }

    fn shape(&self, j: usize, bits: u64) -> Shape {
        let n = self.count as i64;
        let half = self.half_angle(j, bits);
        let component = |i: i64| match self.ends {
            ChainEnds::Free => (&half * Ball::from(2 * i - 1)).sin_cos().1,
            _ => (&half * Ball::from(2 * i)).sin_cos().0,
        };
        let four_times = match self.ends {
            ChainEnds::BothGrounded => 2 * (n + 1),
            ChainEnds::FirstGrounded => 2 * n + 1,
            ChainEnds::Free if j == 1 => 4 * n,
            ChainEnds::Free => 2 * n,
        };
        Shape {
            frequency: self.frequency(j, bits),
            components: (1..=n).map(component).collect(),
            square: Ball::from(four_times).with_bits(bits).scaled(-2),
        }
    }

    /// ω_j = 2 √(k/m) sin(θ_j/2).
    fn frequency(&self, j: usize, bits: u64) -> Ball {
        let rate = Ball::rational(&self.rate_squared, bits).sqrt();
        rate.scaled(1) * self.half_angle(j, bits).sin_cos().0
    }

    /// θ_j/2.
    fn half_angle(&self, j: usize, bits: u64) -> Ball {
        let (j, n) = (j as i64, self.count as i64);
        let (numerator, denominator) = match self.ends {
            ChainEnds::BothGrounded => (j, n + 1),
            ChainEnds::FirstGrounded => (2 * j - 1, 2 * n + 1),
            ChainEnds::Free => (j - 1, n),
        };
        (pi(bits) * Ball::from(numerator) / Ball::from(denominator)).scaled(-1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_has_a_mass() {
        for ends in [
            ChainEnds::BothGrounded,
            ChainEnds::FirstGrounded,
            ChainEnds::Free,
        ] {
            let none = UniformChain::new(ends, 0, 1.0, 1.0);
            assert_eq!(none, Err(ClosedFormError::NoMasses));
            let one = UniformChain::new(ends, 1, 1.0, 1.0).expect("a chain");
            assert_eq!(one.natural_frequencies().len(), 1);
        }
    }
}
