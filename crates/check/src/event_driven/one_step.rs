//! One step of a method over a motion without events.

use std::cell::Cell;

use differential_equations::methods::{DormandPrince, ExplicitRungeKutta, Ordinary};
use differential_equations::ode::{ODE, OrdinaryNumericalMethod};
use differential_equations::status::Status;
use eigentone_digits::Lu;
use faer::Mat;

use super::law::{Law, Phase, Place};

/// A method that looks at nothing but the state at the start of its step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OneStep {
    /// Kutta's classical method of order 4.
    RungeKutta4,
    /// The formula of order 8 of DOP853 (Hairer, Nørsett & Wanner, *Solving Ordinary Differential Equations I*, §II.5).
    Dop853,
    /// Radau IIA of order 5 (Hairer & Wanner, *Solving Ordinary Differential Equations II*, §IV.5).
    Radau5,
}

impl OneStep {
    /// All of them.
    pub const ALL: [OneStep; 3] = [OneStep::RungeKutta4, OneStep::Dop853, OneStep::Radau5];

    /// Its name, with that it finds events.
    pub fn name(self) -> &'static str {
        match self {
            OneStep::RungeKutta4 => "Runge–Kutta 4 with events",
            OneStep::Dop853 => "DOP853 with events",
            OneStep::Radau5 => "Radau IIA 5 with events",
        }
    }

    /// The state `h` s after `elapsed`.
    pub(super) fn step(self, flow: &Flow<'_>, elapsed: f64, state: &[f64], h: f64) -> Vec<f64> {
        match self {
            OneStep::RungeKutta4 => runge_kutta(flow, elapsed, state, h),
            OneStep::Dop853 => dop853(flow, elapsed, state, h),
            OneStep::Radau5 => radau(flow, elapsed, state, h),
        }
    }
}

/// [x; x′]′ while phases last, over the seconds since their piece began.
pub(super) struct Flow<'a> {
    pub(super) law: &'a Law<'a>,
    pub(super) phases: &'a [Phase],
    pub(super) piece: usize,
    pub(super) evaluations: &'a Cell<u64>,
}

impl Flow<'_> {
    fn rate(&self, elapsed: f64, state: &[f64], rate: &mut [f64]) {
        self.evaluations.set(self.evaluations.get() + 1);
        let n = state.len() / 2;
        rate[..n].copy_from_slice(&state[n..]);
        let place = Place {
            piece: self.piece,
            elapsed,
            state,
        };
        match self.law.moment(self.phases, place) {
            Some(moment) => rate[n..].copy_from_slice(&moment.accelerations),
            None => rate[n..].fill(f64::NAN),
        }
    }
}

impl ODE<f64, Vec<f64>> for Flow<'_> {
    fn diff(&self, t: f64, y: &Vec<f64>, dydt: &mut Vec<f64>) {
        self.rate(t, y, dydt);
    }
}

fn runge_kutta(flow: &Flow<'_>, elapsed: f64, state: &[f64], h: f64) -> Vec<f64> {
    let mut slope = vec![0.0; state.len()];
    let mut stage = state.to_vec();
    let mut next = state.to_vec();
    for (ahead, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
        for ((stage, value), slope) in stage.iter_mut().zip(state).zip(&slope) {
            *stage = value + ahead * h * slope;
        }
        flow.rate(elapsed + ahead * h, &stage, &mut slope);
        for (next, slope) in next.iter_mut().zip(&slope) {
            *next += weight / 6.0 * h * slope;
        }
    }
    next
}

fn dop853(flow: &Flow<'_>, elapsed: f64, state: &[f64], h: f64) -> Vec<f64> {
    type Method = ExplicitRungeKutta<Ordinary, DormandPrince, f64, Vec<f64>, 8, 12, 16>;
    // No error is too large, and none so small that its square is lost.
    let large = state
        .iter()
        .fold(1.0, |large: f64, value| large.max(1e3 * value.abs()));
    let state = state.to_vec();
    let mut solver = Method::dop853().rtol(0.0).atol(large).h0(h).max_steps(2);
    if solver
        .init(flow, elapsed, elapsed + 2.0 * h, &state)
        .is_err()
    {
        return vec![f64::NAN; state.len()];
    }
    solver.set_status(Status::Solving);
    solver.set_h(h);
    match solver.step(flow) {
        Ok(_) if !matches!(solver.status(), Status::RejectedStep) => solver.y().clone(),
        _ => vec![f64::NAN; state.len()],
    }
}

/// The stages' slopes k of y′ = A y + b(t): kᵢ − h A Σⱼ aᵢⱼ kⱼ = A y + b(t + cᵢ h).
fn radau(flow: &Flow<'_>, elapsed: f64, state: &[f64], h: f64) -> Vec<f64> {
    let root = 6f64.sqrt();
    let nodes = [(4.0 - root) / 10.0, (4.0 + root) / 10.0, 1.0];
    let weights = [
        [
            (88.0 - 7.0 * root) / 360.0,
            (296.0 - 169.0 * root) / 1800.0,
            (-2.0 + 3.0 * root) / 225.0,
        ],
        [
            (296.0 + 169.0 * root) / 1800.0,
            (88.0 + 7.0 * root) / 360.0,
            (-2.0 - 3.0 * root) / 225.0,
        ],
        [(16.0 - root) / 36.0, (16.0 + root) / 36.0, 1.0 / 9.0],
    ];
    let size = state.len();
    // The matrix, from what unit states do.
    let (mut none, mut slope) = (vec![0.0; size], vec![0.0; size]);
    let zero = vec![0.0; size];
    flow.rate(elapsed, &zero, &mut none);
    let mut matrix = Mat::<f64>::zeros(size, size);
    for j in 0..size {
        let mut unit = zero.clone();
        unit[j] = 1.0;
        flow.rate(elapsed, &unit, &mut slope);
        for i in 0..size {
            matrix[(i, j)] = slope[i] - none[i];
        }
    }
    let mut all = Mat::<f64>::identity(3 * size, 3 * size);
    let mut right = Mat::<f64>::zeros(3 * size, 1);
    for (stage, (node, row)) in nodes.iter().zip(&weights).enumerate() {
        flow.rate(elapsed + node * h, state, &mut slope);
        for i in 0..size {
            right[(stage * size + i, 0)] = slope[i];
            for (other, weight) in row.iter().enumerate() {
                for j in 0..size {
                    all[(stage * size + i, other * size + j)] -= h * weight * matrix[(i, j)];
                }
            }
        }
    }
    let slopes = Lu::of(all.as_ref()).solve(right);
    let next = state.iter().enumerate().map(|(i, value)| {
        let each = weights[2].iter().enumerate();
        value
            + h * each
                .map(|(stage, weight)| weight * slopes[(stage * size + i, 0)])
                .sum::<f64>()
    });
    next.collect()
}
