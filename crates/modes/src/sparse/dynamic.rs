//! (K + sC + s²M) x = f of large systems on the imaginary axis, refined with residuals in double-double.

use eigentone_digits::{ComplexDoubleDouble, DoubleDouble, WideComplex};
use num_complex::Complex;

use super::SparseError;
use super::factor::{Factor, Sum};
use super::form::Form;
use super::pencil::Pencil;
use crate::model::MatrixKind;
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
    /// Orders the elimination; `loss_factors` are those of the [springs](System::springs) in their order, or none.
    ///
    /// # Errors
    /// [`SparseError::NotSymmetric`], and [`SparseError::TooDense`] where the factor would not fit into memory.
    pub fn of(
        system: &System,
        loss_factors: &[f64],
    ) -> Result<SparseDynamicStiffness, SparseError> {
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
        let mut damping = self.losses.clone();
        damping.add(frequency, &self.damping);
        let pencil = self.pencil.with_damping(damping);
        let sum = Sum {
            damping: Complex::I,
            mass: Complex::new(-frequency * frequency, 0.0),
        };
        let factor = Factor::sum(&pencil, sum, &[]);
        (factor.zeros == 0 && factor.is_finite()).then(|| {
            right
                .iter()
                .map(|right| refined(&factor, frequency, right))
                .collect()
        })
    }
}

fn refined(
    factor: &Factor<'_, Complex<f64>>,
    frequency: f64,
    right: &[Complex<f64>],
) -> Amplitudes {
    const STEPS: usize = 5;
    /// A correction that is not so much smaller than the one before says nothing of the error.
    const SETTLES: f64 = 0.1;
    let n = right.len();
    let mut work = vec![Complex::ZERO; n];
    let mut x = vec![ComplexDoubleDouble::ZERO; n];
    let mut missing = right.to_vec();
    let mut before = f64::INFINITY;
    for _ in 0..STEPS {
        factor.solve(&mut missing, &mut work);
        let size = missing.iter().map(|x| x.norm_sqr()).sum::<f64>().sqrt();
        let enough = x.iter().zip(&missing).all(|(x, missing)| {
            missing.norm() <= f64::EPSILON / 64.0 * Complex::new(x.re.high(), x.im.high()).norm()
        });
        let settles = size <= SETTLES * before;
        if enough || !settles {
            let errors = missing.iter().map(|missing| 2.0 * missing.norm());
            return (x, settles.then(|| errors.collect()));
        }
        before = size;
        for (x, missing) in x.iter_mut().zip(&missing) {
            *x += WideComplex::new(missing.re, missing.im);
        }
        missing = residual(factor.pencil, frequency, right, &x);
    }
    factor.solve(&mut missing, &mut work);
    let errors = missing.iter().map(|missing| 2.0 * missing.norm());
    (x, Some(errors.collect()))
}

/// f − (K + i(ΩC + L) − Ω²M)x.
fn residual(
    pencil: &Pencil,
    frequency: f64,
    right: &[Complex<f64>],
    x: &[ComplexDoubleDouble],
) -> Vec<Complex<f64>> {
    let n = x.len();
    let Pencil {
        stiffness,
        damping,
        mass,
        ..
    } = pencil;
    let square = DoubleDouble::product(frequency, frequency);
    let part = |part: fn(&ComplexDoubleDouble) -> DoubleDouble| -> Vec<DoubleDouble> {
        x.iter().map(part).collect()
    };
    let parts = [part(|x| x.re), part(|x| x.im)];
    let mut rests = [
        right
            .iter()
            .map(|f| f.re.into())
            .collect::<Vec<DoubleDouble>>(),
        right.iter().map(|f| f.im.into()).collect(),
    ];
    for (own, part) in parts.iter().enumerate() {
        stiffness.accumulate_long(-1.0, part, &mut rests[own]);
        let mut moved = vec![DoubleDouble::ZERO; n];
        mass.accumulate_long(1.0, part, &mut moved);
        for (rest, moved) in rests[own].iter_mut().zip(moved) {
            *rest += square * moved;
        }
        if !damping.is_zero() {
            // i(a + ib) = −b + ia.
            let (other, sign) = if own == 0 { (1, -1.0) } else { (0, 1.0) };
            damping.accumulate_long(sign, part, &mut rests[other]);
        }
    }
    let [re, im] = rests;
    let pairs = re.into_iter().zip(im);
    pairs
        .map(|(re, im)| Complex::new(re.to_f64(), im.to_f64()))
        .collect()
}
