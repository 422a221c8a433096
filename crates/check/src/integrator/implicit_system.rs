//! The linear system of equations that an implicit step solves.

use faer::Mat;

use super::Work;
use super::equation::EquationOfMotion;
use super::number::Number;

/// (I + α M⁻¹C + β M⁻¹K) x = b, factorised once for each α and β.
///
/// The inverse is kept: for matrices of this size a product with it is several times quicker than
/// two triangular solves, and the errors of either are small beside those of a step.
pub(super) struct ImplicitSystem<T> {
    inverse: Option<((T, T), Mat<T>)>,
    factorisations: u64,
    solves: u64,
}

impl<T: Number> ImplicitSystem<T> {
    pub(super) fn new() -> ImplicitSystem<T> {
        ImplicitSystem {
            inverse: None,
            factorisations: 0,
            solves: 0,
        }
    }

    /// Factorises it, unless it was the last one already, or says that it is singular.
    pub(super) fn factorise(
        &mut self,
        equation: &EquationOfMotion,
        alpha: T,
        beta: T,
    ) -> Result<(), String> {
        let of = (alpha, beta);
        if self.inverse.as_ref().is_some_and(|(last, _)| *last == of) {
            return Ok(());
        }
        self.factorisations += 1;
        let inverse = equation.implicit_inverse(alpha, beta);
        if !inverse.is_all_finite() {
            return Err("its equations for a step are singular".to_owned());
        }
        self.inverse = Some((of, inverse));
        Ok(())
    }

    /// x for b, by what was last factorised.
    pub(super) fn solve(&mut self, b: &[T], x: &mut [T]) {
        self.solves += 1;
        x.fill(T::zero_impl());
        if let Some((_, inverse)) = &self.inverse {
            for (j, b) in b.iter().enumerate() {
                for (x, entry) in x.iter_mut().zip(inverse.col_as_slice(j)) {
                    *x += *entry * *b;
                }
            }
        }
    }

    /// Factorisations and solves.
    pub(super) fn work(&self) -> Work {
        Work {
            factorisations: self.factorisations,
            solves: self.solves,
            ..Work::default()
        }
    }
}
