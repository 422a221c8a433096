//! (K + sC + s²M) x = f of large systems on the imaginary axis, refined with residuals in double-double.

use eigentone_digits::{ComplexDoubleDouble, DoubleDouble, WideComplex};
use num_complex::Complex;

use super::SparseError;
use super::factor::{Factor, Sum};
use super::form::Form;
use super::pencil::Pencil;
use crate::model::MatrixKind;
use crate::system::System;

/// The dynamic stiffness K − Ω²M + iΩC of a symmetric system without dense matrices: one sparse factor for each frequency.
#[derive(Clone, Debug)]
pub struct SparseDynamicStiffness {
    pencil: Pencil,
}

/// Amplitudes, and an estimate of how far each may be off; `None` where refinement did not settle.
pub type Amplitudes = (Vec<ComplexDoubleDouble>, Option<Vec<f64>>);

impl SparseDynamicStiffness {
    /// Orders the elimination.
    ///
    /// # Errors
    /// [`SparseError::NotSymmetric`], and [`SparseError::TooDense`] where the factor would not fit into memory.
    pub fn of(system: &System) -> Result<SparseDynamicStiffness, SparseError> {
        let form = |kind| Form::of(system, kind).ok_or(SparseError::NotSymmetric { kind });
        let (stiffness, damping) = (form(MatrixKind::Stiffness)?, form(MatrixKind::Damping)?);
        let pencil = Pencil::of(stiffness, damping, form(MatrixKind::Mass)?);
        let pencil = pencil.ok_or(SparseError::TooDense)?;
        Ok(SparseDynamicStiffness { pencil })
    }

    /// The amplitudes under each right-hand side at `frequency` rad/s, refined until the next correction, which is the
    /// estimate of their error, is less than the last digit of a double. `None` where a pivot is 0 or the factor leaves the
    /// range of doubles: at a natural frequency without damping, or too close to it.
    pub fn solve(&self, frequency: f64, right: &[Vec<Complex<f64>>]) -> Option<Vec<Amplitudes>> {
        let s = Complex::new(0.0, frequency);
        let factor = Factor::sum(&self.pencil, Sum::at(s), &[]);
        (factor.zeros == 0 && factor.is_finite()).then(|| {
            right
                .iter()
                .map(|right| self.refined(&factor, frequency, right))
                .collect()
        })
    }

    fn refined(
        &self,
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
                missing.norm()
                    <= f64::EPSILON / 64.0 * Complex::new(x.re.high(), x.im.high()).norm()
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
            missing = self.residual(frequency, right, &x);
        }
        factor.solve(&mut missing, &mut work);
        let errors = missing.iter().map(|missing| 2.0 * missing.norm());
        (x, Some(errors.collect()))
    }

    /// f − (K + iΩC − Ω²M)x.
    fn residual(
        &self,
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
        } = &self.pencil;
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
                damping.accumulate_long(sign * frequency, part, &mut rests[other]);
            }
        }
        let [re, im] = rests;
        let pairs = re.into_iter().zip(im);
        pairs
            .map(|(re, im)| Complex::new(re.to_f64(), im.to_f64()))
            .collect()
    }
}
