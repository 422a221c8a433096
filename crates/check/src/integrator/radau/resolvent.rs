//! (I/τ − A)⁻¹ for the state matrix A = [0 I; −M⁻¹K −M⁻¹C], by a system of half its size.

use super::super::Work;
use super::super::equation::EquationOfMotion;
use super::super::implicit_system::ImplicitSystem;
use super::super::number::Number;

/// The resolvent of the state matrix at 1/τ.
pub(super) struct Resolvent<'e, T> {
    equation: &'e EquationOfMotion,
    tau: T,
    system: ImplicitSystem<T>,
    rest: Vec<T>,
}

impl<T: Number> Resolvent<'_, T> {
    pub(super) fn of(equation: &EquationOfMotion) -> Resolvent<'_, T> {
        Resolvent {
            equation,
            tau: T::zero_impl(),
            system: ImplicitSystem::new(),
            rest: vec![T::zero_impl(); equation.len()],
        }
    }

    pub(super) fn factorise(&mut self, tau: T) -> Result<(), String> {
        self.tau = tau;
        self.system.factorise(self.equation, tau, tau * tau)
    }

    /// Replaces [r; s] by the solution [p; q]: p/τ − q = r and M⁻¹K p + q/τ + M⁻¹C q = s, that is
    /// (I + τ M⁻¹C + τ² M⁻¹K) q = τ (s − τ M⁻¹K r) and p = τ (r + q), where nothing cancels.
    pub(super) fn apply(&mut self, state: &mut [T]) {
        let tau = self.tau;
        let (r, s) = state.split_at_mut(self.equation.len());
        self.equation.stiffness_times(r, &mut self.rest);
        for (rest, s) in self.rest.iter_mut().zip(&*s) {
            *rest = (*s - *rest * tau) * tau;
        }
        self.system.solve(&self.rest, s);
        for (r, q) in r.iter_mut().zip(&*s) {
            *r = (*r + *q) * tau;
        }
    }

    pub(super) fn work(&self) -> Work {
        self.system.work()
    }
}
