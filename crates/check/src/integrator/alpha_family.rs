//! One step of the generalized-α family, of which Newmark's methods and HHT-α are members (Chung &
//! Hulbert 1993, *J. Appl. Mech.* 60; notation of theirs):
//!
//! M a(n+1−α_m) + C v(n+1−α_f) + K d(n+1−α_f) = F(t(n+1−α_f)), where x(n+1−α) stands for
//! (1−α) x(n+1) + α x(n), and
//! d(n+1) = d + h v + h²((½−β) a + β a(n+1)), v(n+1) = v + h((1−γ) a + γ a(n+1)).

use super::Work;
use super::equation::{EquationOfMotion, Forces};
use super::fixed_step::FixedStep;
use super::implicit_system::ImplicitSystem;

/// What distinguishes the members of the family.
#[derive(Clone, Copy)]
pub(super) struct Weights {
    pub(super) alpha_m: f64,
    pub(super) alpha_f: f64,
    pub(super) gamma: f64,
    pub(super) beta: f64,
}

impl Weights {
    /// γ and β that make the order 2 and damp the highest frequencies most, given the α.
    pub(super) fn optimal(alpha_m: f64, alpha_f: f64) -> Weights {
        let shift = alpha_f - alpha_m;
        Weights {
            alpha_m,
            alpha_f,
            gamma: 0.5 + shift,
            beta: 0.25 * (1.0 + shift) * (1.0 + shift),
        }
    }
}

/// A member of the family, for one equation.
pub(super) struct AlphaMethod<'e> {
    equation: &'e EquationOfMotion,
    weights: Weights,
    system: ImplicitSystem<f64>,
    /// a(n), and the length of step for which it stands, once there is one.
    acceleration: Vec<f64>,
    length: Option<f64>,
    /// The state that the equation of motion is asked at.
    within: Vec<f64>,
    /// What the equation of motion leaves over for the new acceleration.
    rest: Vec<f64>,
    evaluations: u64,
}

impl AlphaMethod<'_> {
    pub(super) fn of(equation: &EquationOfMotion, weights: Weights) -> AlphaMethod<'_> {
        let zeros = vec![0.0; equation.len()];
        AlphaMethod {
            equation,
            weights,
            system: ImplicitSystem::new(),
            acceleration: zeros.clone(),
            length: None,
            within: vec![0.0; 2 * equation.len()],
            rest: zeros,
            evaluations: 0,
        }
    }

    /// The acceleration to begin with. In the course of equal steps a(n) comes to stand for the
    /// acceleration at t(n) + (α_m − α_f) h; so must the first, or every restart costs an error of
    /// h² (Jay & Negrut 2008, *Numer. Algorithms* 47; Arnold & Brüls 2007, *Multibody Syst. Dyn.*
    /// 18). Its slope is taken through the system of equations of a step, which changes it by a
    /// factor of 1 + O(h) and keeps that of motions too fast for h from swamping all others.
    fn begin(&mut self, state: &[f64], forces: &Forces<'_>, elapsed: f64, h: f64) {
        let shift = (self.weights.alpha_m - self.weights.alpha_f) * h;
        if self.length == Some(h) || (self.length.is_some() && shift == 0.0) {
            return;
        }
        self.length = Some(h);
        self.evaluations += 1;
        self.equation
            .acceleration(state, forces, elapsed, &mut self.acceleration);
        if shift != 0.0 {
            self.evaluations += 1;
            let n = self.equation.len();
            self.within[..n].copy_from_slice(&state[n..]);
            self.within[n..].copy_from_slice(&self.acceleration);
            self.equation
                .derivative(1, &self.within, forces, elapsed, &mut self.rest);
            let mut jerk = vec![0.0; n];
            self.system.solve(&self.rest, &mut jerk);
            for (acceleration, jerk) in self.acceleration.iter_mut().zip(&jerk) {
                *acceleration += shift * jerk;
            }
        }
    }
}

impl FixedStep for AlphaMethod<'_> {
    fn restart(&mut self) {
        self.length = None;
    }

    fn step(
        &mut self,
        state: &mut [f64],
        forces: &Forces<'_>,
        elapsed: f64,
        h: f64,
    ) -> Result<(), String> {
        let n = self.equation.len();
        let Weights {
            alpha_m,
            alpha_f,
            gamma,
            beta,
        } = self.weights;
        let share = (1.0 - alpha_f) / (1.0 - alpha_m);
        self.system
            .factorise(self.equation, share * gamma * h, share * beta * h * h)?;
        self.begin(state, forces, elapsed, h);
        self.within.copy_from_slice(state);
        for (i, acceleration) in self.acceleration.iter().enumerate() {
            state[i] += h * (state[n + i] + h * (0.5 - beta) * acceleration);
            state[n + i] += h * (1.0 - gamma) * acceleration;
        }
        for (within, predicted) in self.within.iter_mut().zip(&*state) {
            *within = (1.0 - alpha_f) * predicted + alpha_f * *within;
        }
        self.evaluations += 1;
        let at = elapsed + (1.0 - alpha_f) * h;
        self.equation
            .acceleration(&self.within, forces, at, &mut self.rest);
        for (rest, acceleration) in self.rest.iter_mut().zip(&self.acceleration) {
            *rest = (*rest - alpha_m * acceleration) / (1.0 - alpha_m);
        }
        self.system.solve(&self.rest, &mut self.acceleration);
        for (i, acceleration) in self.acceleration.iter().enumerate() {
            state[i] += beta * h * h * acceleration;
            state[n + i] += gamma * h * acceleration;
        }
        Ok(())
    }

    fn work(&self) -> Work {
        Work {
            evaluations: self.evaluations,
            ..self.system.work()
        }
    }
}
