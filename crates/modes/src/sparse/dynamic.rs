//! (K + sC + s²M) x = f of large systems on the imaginary axis, refined with residuals in double-double.

use eigentone_digits::{ComplexDoubleDouble, DoubleDouble, WideComplex};
use num_complex::Complex;

use super::SparseError;
use super::factor::{Factor, Sum};
use super::form::Form;
use super::pencil::Pencil;
use crate::model::{ElementKind, MatrixKind};
use crate::system::System;

/// The dynamic stiffness K − Ω²M + i(ΩC + L) of a symmetric system without dense matrices, where L is the sum of the
/// springs, each times its loss factor: one sparse factor for each frequency.
#[derive(Clone, Debug)]
pub struct SparseDynamicStiffness {
    /// With C + L in place of C.
    pencil: Pencil,
    damping: Form,
    losses: Form,
}

/// Amplitudes, and an estimate of how far each may be off; `None` where refinement did not settle.
pub type Amplitudes = (Vec<ComplexDoubleDouble>, Option<Vec<f64>>);

impl SparseDynamicStiffness {
    /// Orders the elimination; `loss_factors` are those of the springs in the order of [`System::elements`], or none.
    ///
    /// # Errors
    /// [`SparseError::LossFactors`] where there are not as many as springs, [`SparseError::NotSymmetric`], and [`SparseError::TooDense`] where the factor would not fit into memory.
    pub fn of(
        system: &System,
        loss_factors: &[f64],
    ) -> Result<SparseDynamicStiffness, SparseError> {
        let springs = system.elements(ElementKind::Spring).len();
        let given = loss_factors.len();
        if given != 0 && given != springs {
            return Err(SparseError::LossFactors { given, springs });
        }
        let form = |kind| Form::of(system, kind).ok_or(SparseError::NotSymmetric { kind });
        let (stiffness, damping) = (form(MatrixKind::Stiffness)?, form(MatrixKind::Damping)?);
        let losses = Form::of_springs(system, loss_factors);
        let mut both = losses.clone();
        both.add(1.0, &damping);
        let pencil = Pencil::of(stiffness, both, form(MatrixKind::Mass)?);
        Ok(SparseDynamicStiffness {
            pencil: pencil.ok_or(SparseError::TooDense)?,
            damping,
            losses,
        })
    }

    /// The amplitudes under each right-hand side at `frequency` rad/s, refined until the next correction, which is the
    /// estimate of their error, is less than the last digit of a double. `None` where a pivot is 0 or the factor leaves the
    /// range of doubles: at a natural frequency without damping, or too close to it.
    pub fn solve(&self, frequency: f64, right: &[Vec<Complex<f64>>]) -> Option<Vec<Amplitudes>> {
        let frequency = DoubleDouble::from(frequency);
        let pencil = self.at(frequency);
        let factor = factored(&pencil, frequency)?;
        let solved = right.iter().map(|right| refined(&factor, frequency, right));
        Some(solved.collect())
    }

    /// The same for one right-hand side and its derivative with respect to Ω: the amplitudes, and their derivatives.
    pub fn solve_with_slope(
        &self,
        frequency: DoubleDouble,
        right: &[Complex<f64>],
        slope: &[Complex<f64>],
    ) -> Option<[Amplitudes; 2]> {
        let pencil = self.at(frequency);
        let factor = factored(&pencil, frequency)?;
        let amplitudes = refined(&factor, frequency, right);
        // Z x′ = f′ − Z′x, Z′ = iC − 2ΩM.
        let mut rests = parts(slope);
        for (own, part) in split(&amplitudes.0).into_iter().enumerate() {
            let mut moved = vec![DoubleDouble::ZERO; part.len()];
            pencil.mass.accumulate_long(2.0, &part, &mut moved);
            for (rest, moved) in rests[own].iter_mut().zip(moved) {
                *rest += frequency * moved;
            }
            turned(&self.damping, own, &part, &mut rests);
        }
        let (slopes, errors) = refined(&factor, frequency, &joined(rests));
        // The right-hand side is rounded.
        let size = |x: &ComplexDoubleDouble| Complex::new(x.re.high(), x.im.high()).norm();
        let rounded = 4.0 * f64::EPSILON * slopes.iter().map(size).fold(0.0, f64::max);
        let errors = errors.map(|errors| errors.iter().map(|error| error + rounded).collect());
        Some([amplitudes, (slopes, errors)])
    }

    /// K, M, and ΩC + L in place of C.
    fn at(&self, frequency: DoubleDouble) -> Pencil {
        let mut damping = self.losses.clone();
        for part in [frequency.high(), frequency.low()] {
            if part != 0.0 {
                damping.add(part, &self.damping);
            }
        }
        self.pencil.with_damping(damping)
    }
}

fn factored(pencil: &Pencil, frequency: DoubleDouble) -> Option<Factor<'_, Complex<f64>>> {
    let sum = Sum {
        damping: Complex::I,
        mass: Complex::new(-frequency.high() * frequency.high(), 0.0),
    };
    let factor = Factor::sum(pencil, sum, &[]);
    (factor.zeros == 0 && factor.is_finite()).then_some(factor)
}

/// Real and imaginary parts.
fn parts(vector: &[Complex<f64>]) -> [Vec<DoubleDouble>; 2] {
    [
        vector.iter().map(|x| x.re.into()).collect(),
        vector.iter().map(|x| x.im.into()).collect(),
    ]
}

fn split(vector: &[ComplexDoubleDouble]) -> [Vec<DoubleDouble>; 2] {
    [
        vector.iter().map(|x| x.re).collect(),
        vector.iter().map(|x| x.im).collect(),
    ]
}

fn joined([re, im]: [Vec<DoubleDouble>; 2]) -> Vec<Complex<f64>> {
    let pairs = re.into_iter().zip(im);
    pairs
        .map(|(re, im)| Complex::new(re.to_f64(), im.to_f64()))
        .collect()
}

/// Subtracts iAx of a real (0) or imaginary (1) part x: i(a + ib) = −b + ia.
fn turned(form: &Form, own: usize, part: &[DoubleDouble], rests: &mut [Vec<DoubleDouble>; 2]) {
    if !form.is_zero() {
        let (other, sign) = if own == 0 { (1, -1.0) } else { (0, 1.0) };
        form.accumulate_long(sign, part, &mut rests[other]);
    }
}

fn refined(
    factor: &Factor<'_, Complex<f64>>,
    frequency: DoubleDouble,
    right: &[Complex<f64>],
) -> Amplitudes {
    const STEPS: usize = 5;
    /// A correction that is not so much smaller than the one before says nothing of the error.
    const SETTLES: f64 = 0.1;
    /// Of the size of the solution, corrections that are small enough not to shrink further.
    const ENDS: f64 = 1e-17;
    let n = right.len();
    let mut work = vec![Complex::ZERO; n];
    let mut x = vec![ComplexDoubleDouble::ZERO; n];
    let mut missing = right.to_vec();
    let plain = |x: &ComplexDoubleDouble| Complex::new(x.re.high(), x.im.high());
    let norm =
        |sum: &mut dyn Iterator<Item = Complex<f64>>| sum.map(|x| x.norm_sqr()).sum::<f64>().sqrt();
    let mut before = f64::INFINITY;
    for step in 0..=STEPS {
        factor.solve(&mut missing, &mut work);
        let size = norm(&mut missing.iter().copied());
        let each = x.iter().zip(&missing);
        let enough = each
            .into_iter()
            .all(|(x, missing)| missing.norm() <= f64::EPSILON / 64.0 * plain(x).norm());
        let shrinks = size <= SETTLES * before;
        // Corrections stop to shrink where double-doubles end: what remains is of that size in every component.
        let remains = if shrinks { 0.0 } else { 4.0 * size };
        let settles = shrinks || size <= ENDS * norm(&mut x.iter().map(plain));
        if enough || !shrinks || step == STEPS {
            let errors = missing.iter().map(|missing| 2.0 * missing.norm() + remains);
            return (x, settles.then(|| errors.collect()));
        }
        before = size;
        for (x, missing) in x.iter_mut().zip(&missing) {
            *x += WideComplex::new(missing.re, missing.im);
        }
        missing = residual(factor.pencil, frequency, right, &x);
    }
    (x, None)
}

/// f − (K + i(ΩC + L) − Ω²M)x.
fn residual(
    pencil: &Pencil,
    frequency: DoubleDouble,
    right: &[Complex<f64>],
    x: &[ComplexDoubleDouble],
) -> Vec<Complex<f64>> {
    let square = frequency * frequency;
    let mut rests = parts(right);
    for (own, part) in split(x).into_iter().enumerate() {
        pencil
            .stiffness
            .accumulate_long(-1.0, &part, &mut rests[own]);
        let mut moved = vec![DoubleDouble::ZERO; part.len()];
        pencil.mass.accumulate_long(1.0, &part, &mut moved);
        for (rest, moved) in rests[own].iter_mut().zip(moved) {
            *rest += square * moved;
        }
        turned(&pencil.damping, own, &part, &mut rests);
    }
    joined(rests)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::GROUND;

    /// Two masses of 1 kg; a spring of 3 N/m holds the point 2·a, another of 1 N/m each mass.
    fn on_a_point() -> System {
        let builder = System::builder().mass("a", 1.0).mass("b", 1.0);
        let builder = builder.point("p", [("a", 2.0)], 0.0);
        let builder = builder.spring(GROUND, "p", 3.0);
        let builder = builder.spring(GROUND, "a", 1.0).spring(GROUND, "b", 1.0);
        builder.build().expect("a system")
    }

    /// (1 + 4·3(1 + η i) − Ω²) x = 1: the loss is that of the spring at the point, which is the first that was given.
    #[test]
    fn losses_belong_to_springs_as_they_were_given() {
        let stiffness = SparseDynamicStiffness::of(&on_a_point(), &[0.5, 0.0, 0.0]);
        let force = [Complex::ONE, Complex::ZERO].to_vec();
        let solved = stiffness.expect("symmetric").solve(0.5, &[force]);
        let (x, errors) = solved.expect("a factor").remove(0);
        let value = Complex::new(x[0].re.high(), x[0].im.high());
        let right = Complex::new(12.75, 6.0).inv();
        assert!((value - right).norm() < 1e-16, "{value}");
        assert!(errors.expect("settled")[0] < 1e-16);
    }

    #[test]
    fn loss_factors_are_as_many_as_springs() {
        let error = SparseDynamicStiffness::of(&on_a_point(), &[0.5]).expect_err("one of three");
        let (given, springs) = (1, 3);
        assert_eq!(error, SparseError::LossFactors { given, springs });
    }
}
