//! The exact response by the matrix exponential of the whole state.

use std::collections::HashMap;

use eigentone_digits::DoubleDouble;
use eigentone_modes::FirstOrder;
use faer::Mat;

use super::estimate::Detour;
use super::flow::{Coordinates, Flow, Outputs, march};
use crate::answer::{Operations, ResponseMethod, Trajectory};
use crate::exponential::second_order;
use crate::hold::{Held, Inputs, Signals, exact};
use crate::problem::{Plant, Problem, ResponseError};

/// z(t + h) = e^{Ah} z(t) + what the loads add, each exactly: for every system with a first-order
/// form, at resonance, at critical damping and without supports. One exponential for each length of
/// step, then a matrix–vector product a step.
#[derive(Clone, Copy, Debug)]
pub struct ByExponential;

impl ResponseMethod for ByExponential {
    fn name(&self) -> &'static str {
        "exponential"
    }

    fn refuses(&self, problem: &Problem<'_>) -> Option<String> {
        FirstOrder::of(problem.system())
            .err()
            .map(|error| error.to_string())
    }

    fn run(&self, problem: &Problem<'_>) -> Result<Trajectory, ResponseError> {
        let form =
            FirstOrder::of(problem.system()).map_err(|error| ResponseError::NotApplicable {
                method: self.name(),
                reason: error.to_string(),
            })?;
        let plant = Plant::of(problem, &form);
        let inputs = Inputs::of(problem);
        let mut flow = Dense {
            u: inputs.columns(plant.b.as_ref()),
            inputs,
            held: HashMap::new(),
            operations: Operations::default(),
            next: vec![0.0; plant.a.nrows()],
            a: plant.a.clone(),
        };
        let coordinates = Coordinates {
            detour: Detour::default(),
            b: plant.b.as_ref(),
            enter: &<[f64]>::to_vec,
            outputs: &Outputs::of(&plant, None),
            integrals: plant.integrals,
        };
        march(self.name(), problem, &mut flow, &form, &coordinates)
    }
}

/// The whole state matrix, with the holds computed so far by the bits of their length.
struct Dense {
    a: Mat<f64>,
    u: Mat<f64>,
    inputs: Inputs,
    held: HashMap<u64, Held>,
    operations: Operations,
    next: Vec<f64>,
}

/// So many lengths of step are kept.
const KEPT: usize = 64;

impl Flow for Dense {
    fn advance(&mut self, h: DoubleDouble, z: &mut [f64], signals: &Signals) {
        let h = h.to_f64();
        if self.held.len() >= KEPT && !self.held.contains_key(&h.to_bits()) {
            self.held.clear();
        }
        let held = self.held.entry(h.to_bits()).or_insert_with(|| {
            let held = exact(
                second_order,
                self.a.as_ref(),
                self.u.as_ref(),
                h,
                &self.inputs.laws,
            );
            self.operations.exponentials += 1;
            self.operations.products += held.products;
            held
        });
        self.operations.steps += 1;
        self.next.fill(0.0);
        accumulate(&held.phi, z, &mut self.next);
        for (gamma, values) in held.gamma.iter().zip(&signals.values) {
            accumulate(gamma, values, &mut self.next);
        }
        z.copy_from_slice(&self.next);
    }

    fn preparation(&self) -> u64 {
        32 * self.a.nrows() as u64
    }

    fn operations(&self) -> Operations {
        self.operations
    }
}

/// sum += matrix · vector.
pub(crate) fn accumulate(matrix: &Mat<f64>, vector: &[f64], sum: &mut [f64]) {
    for (j, factor) in vector.iter().enumerate() {
        if *factor != 0.0 {
            for (entry, column) in sum.iter_mut().zip(matrix.col(j).iter()) {
                *entry += column * factor;
            }
        }
    }
}
