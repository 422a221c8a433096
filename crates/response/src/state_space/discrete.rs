//! The exact discrete form: one exponential of the matrix bordered by the inputs' own course (Van Loan 1978, *IEEE Trans.
//! Automat. Control* 23), never A⁻¹(e^{Ah} − I)B.

use eigentone_digits::{BallMatrix, Magnitude, Real};

use super::asked::Asked;
use super::bounded::BoundedMatrix;
use super::coordinates::{Coordinates, kept};
use super::ladder::{Found, Question};
use super::realisation::Realisation;
use crate::enclosed::{Normed, of_any_size};
use crate::problem::Hold;

/// A matrix below 2^-LEAST is as good as none.
const LEAST: f64 = 1e15;
/// An error beyond three digits leaves nothing of a matrix.
const WORTH: i64 = -10;

pub(super) struct Discrete<'a> {
    pub(super) asked: &'a Asked<'a>,
    pub(super) step: f64,
    pub(super) hold: Hold,
}

impl Question for Discrete<'_> {
    /// A_d, B_d, C_d, D_d.
    type Answer = [BoundedMatrix; 4];

    fn attempt<T: Real>(&self) -> Found<[BoundedMatrix; 4]> {
        let Some(form) = Realisation::<T>::of(self.asked) else {
            return Ok(None);
        };
        let Some(coordinates) = Coordinates::of(self.asked, &form, self.step) else {
            return Ok(None);
        };
        let (n, m) = (form.a.rows(), form.b.columns());
        let borders = match self.hold {
            Hold::Zero => 1,
            Hold::First => 2,
        };
        let size = n + borders * m;
        let mut w = BallMatrix::<T>::zeros(size, size);
        w.put(0, 0, &coordinates.a);
        w.put(0, n, &coordinates.b);
        if self.hold == Hold::First {
            // An input's growth in a step.
            let slope = T::ONE / T::from(self.step);
            let error = slope.upper() * T::unit() + T::floor();
            (0..m).for_each(|i| w.set(n + i, n + m + i, slope, error));
        }
        let w = Normed::of(&w, n).with_more_error(coordinates.a_error);
        let w = w.times_scalar(T::from(self.step), Magnitude::ZERO);
        // What decays beyond the range of T is 0.
        let power = match of_any_size(&w, LEAST) {
            None => return Ok(None),
            Some((_, exponent)) if (exponent as f64) < -LEAST => {
                let nothing = Magnitude::power_of_two(-LEAST as i64);
                Normed::new(size, n, vec![T::ZERO; size * size], nothing)
            }
            Some((power, exponent)) => power.scaled(exponent),
        };
        let error = power.error();
        // Of states of size 1, of which a decaying map leaves less.
        let size = Magnitude::from(1.0) + power.sizes();
        if !error.is_finite() || error > size * Magnitude::power_of_two(WORTH) {
            return Ok(None);
        }
        let a = coordinates.map(&kept(&power, 0, n, n), error);
        let input = |column| coordinates.map_of_inputs(&kept(&power, column, n, m), error);
        let (mut b, mut d) = (input(n), form.d.clone());
        if self.hold == Hold::First {
            // z(t + h) = A_d z + Γ₁u₀ + Γ₂(u₁ − u₀), and the state is z − Γ₂u.
            let growing = input(n + m);
            let rest = a.times(&growing).plus(&growing.clone().negated());
            b = b.plus(&rest);
            d = d.plus(&form.c.times(&growing));
        }
        let of_output = |i: usize, j: usize| {
            let parts =
                (0..n).map(|k| form.c.middle(i, k).upper() * coordinates.scale_of_input(k, j));
            parts.fold(form.d.middle(i, j).upper(), |sum, part| sum + part)
        };
        let matrices = [
            BoundedMatrix::of(&a, "A", |i, j| coordinates.scale(i, j))?,
            BoundedMatrix::of(&b, "B", |i, j| coordinates.scale_of_input(i, j))?,
            BoundedMatrix::by_itself(&form.c, "C")?,
            BoundedMatrix::of(&d, "D", of_output)?,
        ];
        let [Some(a), Some(b), Some(c), Some(d)] = matrices else {
            return Ok(None);
        };
        let good = a.1 && b.1 && c.1 && d.1;
        Ok(Some(([a.0, b.0, c.0, d.0], good)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_digits::{DoubleDouble, Wide};
    use eigentone_modes::{GROUND, System};

    /// Squares of rotations double their error, and their bound once more: 1e15 radians leave less than a digit of 32.
    #[test]
    fn digits_that_leave_nothing_give_no_answer() {
        let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 1.0);
        let system = system.build().expect("a system");
        let mut asked = Asked::of(&system);
        asked.force("m").expect("it is a coordinate");
        let question = |step| Discrete {
            asked: &asked,
            step,
            hold: Hold::Zero,
        };
        let found = |found: Found<_>| found.expect("nothing is wrong").is_some();
        assert!(found(question(1e12).attempt::<DoubleDouble>()));
        assert!(!found(question(1e15).attempt::<DoubleDouble>()));
        assert!(found(question(1e15).attempt::<Wide<4>>()));
    }
}
