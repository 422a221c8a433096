//! The exact response by modal superposition: small blocks instead of one large state.

use std::collections::HashMap;

use eigentone_digits::{DoubleDouble, Magnitude};
use eigentone_modes::{ClassicalModes, FirstOrder, Modes};
use faer::linalg::solvers::{DenseSolveCore, Solve};
use faer::{Mat, MatRef};

use crate::by_exponential::accumulate;
use crate::certified::{Normed, exponential};
use crate::estimate::Estimate;
use crate::exponential::Taylor;
use crate::hold::{Laws, exact};
use crate::march::{Flow, Inputs, Outputs, Signals, march};
use crate::method::ResponseMethod;
use crate::operations::Operations;
use crate::problem::{Problem, ResponseError};
use crate::trajectory::Trajectory;

/// The state as a sum of modes, each of which moves by itself and exactly: O(n) a step, and without
/// drift over any number of them.
///
/// Classically damped systems use their real shapes and keep displacement and velocity of each, so
/// that rigid-body motion, resonance and critical damping stay exact. Other systems use pairs of
/// complex shapes, where those are well conditioned; at defective roots it refuses.
#[derive(Clone, Copy, Debug)]
pub struct BySuperposition;

/// Complex shapes are refused where going to modes and back would enlarge rounding errors of
/// displacements or velocities more than this.
const LARGEST_CONDITION: f64 = 1e8;

impl ResponseMethod for BySuperposition {
    fn name(&self) -> &'static str {
        "superposition"
    }

    fn refuses(&self, problem: &Problem<'_>) -> Option<String> {
        Basis::of(problem).err().map(|error| match error {
            ResponseError::NotApplicable { reason, .. } => reason,
            other => other.to_string(),
        })
    }

    fn run(&self, problem: &Problem<'_>) -> Result<Trajectory, ResponseError> {
        let basis = Basis::of(problem)?;
        let inputs = Inputs::of(problem);
        let form = &basis.form;
        let z = form.state(problem.initial_displacement(), problem.initial_velocity());
        let mut modal = vec![0.0; z.len()];
        accumulate(&basis.inverse, &z, &mut modal);
        let b = &basis.inverse * form.b();
        let outputs = Outputs::of(form, Some(basis.t.as_ref()));
        let estimate = Estimate::of(problem.system(), form);
        let mut flow = Blocks {
            blocks: basis.blocks,
            low: vec![0.0; modal.len()],
            u: inputs.columns(b.as_ref()),
            inputs,
            held: HashMap::new(),
            operations: Operations::default(),
            modal: Vec::new(),
        };
        march(
            self.name(),
            problem,
            &mut flow,
            modal,
            b.as_ref(),
            &outputs,
            estimate,
        )
    }
}

/// z = T ζ with A T = T diag(blocks).
struct Basis {
    form: FirstOrder,
    t: Mat<f64>,
    inverse: Mat<f64>,
    blocks: Vec<Block>,
}

/// One or two states that move by themselves, with the generator by rows.
#[derive(Clone, Debug)]
struct Block {
    width: usize,
    generator: Vec<DoubleDouble>,
}

impl Basis {
    fn of(problem: &Problem<'_>) -> Result<Basis, ResponseError> {
        let system = problem.system();
        let refused = |reason: String| ResponseError::NotApplicable {
            method: BySuperposition.name(),
            reason,
        };
        let form = FirstOrder::of(system).map_err(|error| refused(error.to_string()))?;
        match ClassicalModes::of(system)? {
            Some(modes) => Ok(Basis::classical(form, system, &modes)),
            None => Basis::complex(form, &system.modes()?).map_err(refused),
        }
    }

    /// Blocks [0 1; −k/m −c/m] of real shapes.
    fn classical(
        form: FirstOrder,
        system: &eigentone_modes::System,
        modes: &ClassicalModes,
    ) -> Basis {
        let nf = form.massive().len();
        let n = 2 * nf;
        let mass = system.mass_matrix();
        let massive = form.massive();
        let shapes = Mat::from_fn(nf, nf, |i, j| modes.shapes()[(massive[i], j)]);
        let mass = Mat::from_fn(nf, nf, |i, j| mass[(massive[i], massive[j])]);
        let weighted = shapes.transpose() * mass;
        let (mut t, mut inverse) = (Mat::<f64>::zeros(n, n), Mat::<f64>::zeros(n, n));
        for j in 0..nf {
            for i in 0..nf {
                let back = weighted[(j, i)] / modes.mass()[j];
                for half in 0..2 {
                    t[(half * nf + i, 2 * j + half)] = shapes[(i, j)];
                    inverse[(2 * j + half, half * nf + i)] = back;
                }
            }
        }
        let blocks = modes.rates().iter().map(|[stiffness, damping]| Block {
            width: 2,
            generator: vec![
                DoubleDouble::ZERO,
                DoubleDouble::from(1.0),
                -*stiffness,
                -*damping,
            ],
        });
        Basis {
            blocks: blocks.collect(),
            form,
            t,
            inverse,
        }
    }

    /// Blocks [α β; −β α] of conjugate pairs and [α] of real roots.
    fn complex(form: FirstOrder, modes: &Modes) -> Result<Basis, String> {
        if modes.iter().any(|mode| mode.is_defective()) {
            return Err("a root is defective: its shapes do not span the motion".to_owned());
        }
        let n = form.states();
        let mut t = Mat::<f64>::zeros(n, n);
        let mut blocks = Vec::new();
        let mut column = 0;
        for mode in modes {
            let lambda = mode.eigenvalue().value;
            let width = if lambda.im == 0.0 { 1 } else { 2 };
            if column + width > n {
                return Err("there are more roots than states".to_owned());
            }
            let parts = |part: fn(&num_complex::Complex<f64>) -> f64| {
                let x: Vec<f64> = mode.shape().iter().map(part).collect();
                let v: Vec<f64> = mode.shape().iter().map(|x| part(&(x * lambda))).collect();
                form.state(&x, &v)
            };
            let real = parts(|z| z.re);
            let imaginary = parts(|z| z.im);
            let size = real
                .iter()
                .chain(&imaginary)
                .fold(0.0f64, |a, b| a.hypot(*b));
            for i in 0..n {
                t[(i, column)] = real[i] / size;
                if width == 2 {
                    t[(i, column + 1)] = imaginary[i] / size;
                }
            }
            let generator = match width {
                1 => vec![lambda.re],
                _ => vec![lambda.re, lambda.im, -lambda.im, lambda.re],
            };
            blocks.push(Block {
                width,
                generator: generator.into_iter().map(DoubleDouble::from).collect(),
            });
            column += width;
        }
        if column != n {
            return Err("there are fewer roots than states".to_owned());
        }
        // Rows of unlike units are evened out before the condition is judged.
        let rows: Vec<f64> = (0..n).map(|i| t.row(i).norm_l2()).collect();
        if rows.contains(&0.0) {
            return Err("the shapes do not span the motion".to_owned());
        }
        let even = Mat::from_fn(n, n, |i, j| t[(i, j)] / rows[i]);
        let lu = even.partial_piv_lu();
        let inverse = lu.inverse();
        let condition = enlargement(&even, &inverse, form.massive().len());
        if condition.is_nan() || condition > LARGEST_CONDITION {
            return Err(format!(
                "its complex shapes are ill-conditioned ({condition:.0e})"
            ));
        }
        let scaled = Mat::from_fn(n, n, |i, j| if i == j { 1.0 / rows[i] } else { 0.0 });
        let inverse = lu.solve(scaled);
        Ok(Basis {
            form,
            t,
            inverse,
            blocks,
        })
    }
}

/// By how much rounding errors may grow on the way to modal coordinates and back: sums of |T||T⁻¹| along
/// the rows, over displacements for displacements (the first `half` states) and over the other states for those. Unlike
/// a norm of T times one of T⁻¹, it does not hold it against fast modes that they move much faster than
/// slow ones (Skeel 1979, *J. ACM* 26).
fn enlargement(t: &Mat<f64>, inverse: &Mat<f64>, half: usize) -> f64 {
    let n = t.nrows();
    let sum = |i: usize| -> f64 {
        let alike = if i < half { 0..half } else { half..n };
        let entries = alike.map(|j| {
            let terms = (0..n).map(|k| (t[(i, k)] * inverse[(k, j)]).abs());
            terms.sum::<f64>()
        });
        entries.sum()
    };
    // A NaN is to be found.
    (0..n)
        .map(sum)
        .fold(0.0, |top, sum| if sum <= top { top } else { sum })
}

/// Independent blocks of one or two states. Each is carried on in double-double, so that rounding
/// does not add up over any number of steps.
struct Blocks {
    blocks: Vec<Block>,
    /// What the states have beyond doubles.
    low: Vec<f64>,
    /// T⁻¹B for the loaded coordinates.
    u: Mat<f64>,
    inputs: Inputs,
    held: HashMap<[u64; 2], Vec<HeldBlock>>,
    operations: Operations,
    modal: Vec<f64>,
}

/// The hold of one block.
struct HeldBlock {
    width: usize,
    /// By rows.
    phi: Vec<DoubleDouble>,
    /// What the loads add, law by law.
    gamma: Vec<Mat<f64>>,
}

impl HeldBlock {
    fn of(block: &Block, h: DoubleDouble, laws: &Laws) -> HeldBlock {
        let width = block.width;
        let exactly = Normed::new(width, width, block.generator.clone(), Magnitude::ZERO);
        let power = exponential(&exactly, h, Magnitude::ZERO);
        let generator = Mat::from_fn(width, width, |i, j| block.generator[i * width + j].to_f64());
        let unit = Mat::<f64>::identity(width, width);
        let held = exact(&Taylor, generator.as_ref(), unit.as_ref(), h.to_f64(), laws);
        HeldBlock {
            width,
            phi: power.entries().to_vec(),
            gamma: held.gamma,
        }
    }
}

/// So many lengths of step are kept.
const KEPT: usize = 64;

impl Flow for Blocks {
    fn advance(&mut self, h: DoubleDouble, z: &mut [f64], signals: &Signals) {
        let key = [h.high(), h.low()].map(f64::to_bits);
        if self.held.len() >= KEPT && !self.held.contains_key(&key) {
            self.held.clear();
        }
        let held = self.held.entry(key).or_insert_with(|| {
            self.operations.exponentials += self.blocks.len() as u64;
            let hold = |block: &Block| HeldBlock::of(block, h, &self.inputs.laws);
            self.blocks.iter().map(hold).collect()
        });
        self.operations.steps += 1;
        // The forces on each modal coordinate, law by law.
        let laws = signals.values.len();
        self.modal.clear();
        self.modal.resize(laws * z.len(), 0.0);
        for (law, values) in signals.values.iter().enumerate() {
            accumulate(
                &self.u,
                values,
                &mut self.modal[law * z.len()..(law + 1) * z.len()],
            );
        }
        let mut first = 0;
        for held in held.iter() {
            let width = held.width;
            let range = first..first + width;
            let mut pushed = [0.0; 2];
            for (law, gamma) in held.gamma.iter().enumerate() {
                let at = law * z.len() + first;
                add(gamma.as_ref(), &self.modal[at..at + width], &mut pushed);
            }
            let mut next = pushed.map(DoubleDouble::from);
            for (i, next) in next.iter_mut().enumerate().take(width) {
                for (j, at) in range.clone().enumerate() {
                    let state = DoubleDouble::new(z[at], self.low[at]);
                    *next += held.phi[i * width + j] * state;
                }
            }
            for (at, next) in range.zip(next) {
                (z[at], self.low[at]) = (next.high(), next.low());
            }
            first += width;
        }
    }

    fn preparation(&self) -> u64 {
        256
    }

    fn operations(&self) -> Operations {
        self.operations
    }
}

/// sum += matrix · vector, for one or two states.
fn add(matrix: MatRef<'_, f64>, vector: &[f64], sum: &mut [f64; 2]) {
    for (j, factor) in vector.iter().enumerate() {
        for i in 0..vector.len() {
            sum[i] += matrix[(i, j)] * factor;
        }
    }
}
