//! From approximate roots of λ²M + λC + K and their shapes to all digits that the matrices determine.
//!
//! For symmetric M, C, K the root of xᵀQ(θ)x nearest to λ errs by the square of the error of x (Lancaster 1961,
//! *Quart. J. Mech. Appl. Math.* 14). Residual inverse iteration, x − Q(σ)⁻¹Q(θ)x with a σ near λ, makes the
//! error of x less by |λ − σ| over the distance to the next root each time (Neumaier 1985, *SIAM J. Numer. Anal.*
//! 22). Residuals are formed in double-double, so that this goes on far beyond the digits of a double; roots that
//! nearly coincide are refined together, by the eigenvectors of Q(θ) in the span of their shapes.

use eigentone_digits::{ComplexDoubleDouble, DoubleDouble, Lu, eigen};
use faer::Mat;
use num_complex::Complex;

use super::eigenpair::Eigenpair;
use super::entry::Entry;
use super::factor::{Factor, Sum};
use super::form::Form;
use super::pencil::Pencil;

type Long = ComplexDoubleDouble;

/// A root with its shape, and how far each part of it may be off; an estimate, and `None` where the iteration
/// does not converge as it must near a root.
#[derive(Clone, Debug)]
pub(crate) struct Root {
    pub(crate) value: Complex<f64>,
    /// Of the root, and of its real part.
    pub(crate) error: Option<(f64, f64)>,
    pub(crate) shape: Vec<Complex<f64>>,
}

/// A shape with its products with M, C and K.
struct Shape {
    x: Vec<Long>,
    products: [Vec<Long>; 3],
    value: Long,
}

/// At most so many steps.
const STEPS: usize = 16;

/// Roots that lie nearer together are refined together.
pub(crate) const NEAR: f64 = 1e-4;

/// Refines roots that lie near each other.
pub(crate) fn refined(pencil: &Pencil, cluster: Vec<Eigenpair>) -> Vec<Root> {
    const APART: f64 = 1e-6;
    let count = cluster.len() as f64;
    let centre = cluster.iter().map(|root| root.value).sum::<Complex<f64>>() / count;
    let shift = centre * (1.0 + APART);
    let factor = Factor::sum(pencil, Sum::at(shift), &[]);
    let mut block = Block::of(pencil.forms(), &cluster, centre);
    let ends = factor.is_finite() && block.improve(&factor);
    block
        .shapes
        .iter()
        .zip(&cluster)
        .map(|(shape, given)| block.root(shape, given, ends))
        .collect()
}

/// The same without a factor: roots of xᵀQ(θ)x in the span of the shapes as they are, with errors that their
/// residuals allow to first order, ‖Q(θ)x‖ ‖x‖/|xᵀQ′(θ)x| in the norms of the weights (Tisseur 2000, *Linear Algebra
/// Appl.* 309, §2).
pub(crate) fn measured(forms: [&Form; 3], cluster: Vec<Eigenpair>) -> Vec<Root> {
    const PART: f64 = 0.1;
    let count = cluster.len() as f64;
    let centre = cluster.iter().map(|root| root.value).sum::<Complex<f64>>() / count;
    let mut block = Block::of(forms, &cluster, centre);
    for shape in &mut block.shapes {
        shape.measure(forms, &block.weights);
    }
    let found = block.separate() && block.shapes.iter_mut().all(Shape::quotient);
    let inverse: Vec<f64> = block.weights.iter().map(|weight| weight.recip()).collect();
    let root = |(shape, given): (&Shape, Eigenpair)| {
        let value = short(shape.value);
        let rest = shape.residual();
        let rest = length(rest.into_iter().map(short), &inverse);
        let whole = length(shape.x.iter().map(|x| short(*x)), &block.weights);
        let own = rest * whole / short(shape.slope()).norm() + f64::EPSILON * value.norm();
        match found && own <= PART * value.norm() {
            true => Root {
                value,
                error: Some((own, own)),
                shape: shape.x.iter().map(|x| short(*x)).collect(),
            },
            false => Root {
                value: given.value,
                error: None,
                shape: given.shape,
            },
        }
    };
    block.shapes.iter().zip(cluster).map(root).collect()
}

fn long(value: Complex<f64>) -> Long {
    Long::new(value.re, value.im)
}

fn short(value: Long) -> Complex<f64> {
    Complex::new(value.re.to_f64(), value.im.to_f64())
}

struct Block<'a> {
    /// M, C and K.
    forms: [&'a Form; 3],
    /// By which shapes are measured.
    weights: Vec<f64>,
    shapes: Vec<Shape>,
    /// By how much the last step moved roots, and shapes in proportion.
    moved: f64,
    step: f64,
}

fn length(x: impl Iterator<Item = Complex<f64>>, weights: &[f64]) -> f64 {
    let sizes = x.zip(weights).map(|(x, weight)| weight * x.norm_sqr());
    sizes.sum::<f64>().sqrt()
}

impl<'a> Block<'a> {
    fn of(forms: [&'a Form; 3], cluster: &[Eigenpair], centre: Complex<f64>) -> Block<'a> {
        let [mass, _, stiffness] = forms;
        let diagonals = stiffness.diagonal().into_iter().zip(mass.diagonal());
        let shape = |root: &Eigenpair| Shape {
            x: root.shape.iter().map(|x| long(*x)).collect(),
            products: [Vec::new(), Vec::new(), Vec::new()],
            value: long(root.value),
        };
        Block {
            forms,
            weights: diagonals
                .map(|(k, m)| k.abs() + centre.norm_sqr() * m.abs())
                .collect(),
            shapes: cluster.iter().map(shape).collect(),
            moved: f64::INFINITY,
            step: f64::INFINITY,
        }
    }

    /// `false` where that does not converge.
    fn improve(&mut self, factor: &Factor<'_, Complex<f64>>) -> bool {
        const ENOUGH: f64 = 1e-28;
        const SMALL: f64 = 1e-8;
        for step in 0..STEPS {
            for shape in &mut self.shapes {
                shape.measure(self.forms, &self.weights);
            }
            let before: Vec<Long> = self.shapes.iter().map(|shape| shape.value).collect();
            if !self.separate() {
                return false;
            }
            let mut corrections = Vec::new();
            let (mut moved, mut part): (f64, f64) = (0.0, 0.0);
            for shape in &mut self.shapes {
                if !shape.quotient() {
                    return false;
                }
                let apart = before.iter().map(|before| (shape.value - *before).norm());
                moved = moved.max(apart.fold(f64::INFINITY, f64::min));
                let mut correction: Vec<Complex<f64>> =
                    shape.residual().into_iter().map(short).collect();
                let mut work = vec![Complex::ZERO; correction.len()];
                factor.solve(&mut correction, &mut work);
                let taken = length(correction.iter().copied(), &self.weights);
                let whole = length(shape.x.iter().map(|x| short(*x)), &self.weights);
                part = part.max(taken / whole);
                corrections.push(correction);
            }
            if !(part.is_finite() && moved.is_finite()) {
                return false;
            }
            // Rounding ends what shrinks from step to step.
            if step > 1 && part > 0.5 * self.step {
                self.step = self.step.max(part);
                break;
            }
            (self.moved, self.step) = (moved, part);
            for (shape, correction) in self.shapes.iter_mut().zip(&corrections) {
                for (x, correction) in shape.x.iter_mut().zip(correction) {
                    *x = *x - long(*correction);
                }
            }
            if part <= ENOUGH {
                break;
            }
        }
        self.step <= SMALL
    }

    /// Makes the shapes eigenvectors of Q near their roots in their span.
    fn separate(&mut self) -> bool {
        let count = self.shapes.len();
        if count == 1 {
            return true;
        }
        let sum = self
            .shapes
            .iter()
            .fold(Long::ZERO, |sum, shape| sum + shape.value);
        let centre = sum * (1.0 / count as f64);
        let mut forms = [Mat::zeros(count, count), Mat::zeros(count, count)];
        let [value, slope] = &mut forms;
        for i in 0..count {
            for j in 0..count {
                let [m, c, k] =
                    [0, 1, 2].map(|p| dot(&self.shapes[i].x, &self.shapes[j].products[p]));
                value[(i, j)] = short((m * centre + c) * centre + k);
                slope[(i, j)] = short(m * centre * 2.0 + c);
            }
        }
        let solved = Lu::of(slope.as_ref()).solve(value.clone());
        let Some((values, vectors)) = eigen(solved.as_ref()) else {
            return false;
        };
        let combined = |part: &dyn Fn(&Shape) -> &Vec<Long>, k: usize| -> Vec<Long> {
            let mut sum = vec![Long::ZERO; self.shapes[0].x.len()];
            for (i, shape) in self.shapes.iter().enumerate() {
                let factor = long(vectors[(i, k)]);
                sum.iter_mut()
                    .zip(part(shape))
                    .for_each(|(sum, x)| *sum += *x * factor);
            }
            sum
        };
        let shapes: Vec<Shape> = (0..count)
            .map(|k| Shape {
                x: combined(&|shape| &shape.x, k),
                products: [0, 1, 2].map(|p| combined(&|shape| &shape.products[p], k)),
                value: centre - long(values[k]),
            })
            .collect();
        self.shapes = shapes;
        true
    }

    fn root(&self, shape: &Shape, given: &Eigenpair, ends: bool) -> Root {
        if !ends {
            return Root {
                value: given.value,
                error: None,
                shape: given.shape.clone(),
            };
        }
        let value = short(shape.value);
        let size = value.norm();
        let slope = short(shape.slope()).norm();
        // Rounding of forms in double-double.
        let [mass, damping, stiffness] = self.forms;
        let terms = |form: &Form| {
            let terms = form.sizes().into_iter().zip(&shape.x);
            terms.map(|(w, x)| w * short(*x).norm_sqr()).sum::<f64>()
        };
        let whole = (terms(mass) * size + terms(damping)) * size + terms(stiffness);
        let rounding = 8.0 * DoubleDouble::UNIT * whole / slope;
        // What is left after the last step, by the square of what that step took.
        let left = self.step * self.step * (whole / slope);
        let own = 4.0 * (self.moved.min(left) + left * self.step) + rounding;
        let half = f64::EPSILON / 2.0;
        let error = own + half * size * 1.5;
        let real = own + half * value.re.abs();
        let known = error <= 1e-6 * size;
        Root {
            value,
            error: known.then_some((error, real)),
            shape: shape.x.iter().map(|x| short(*x)).collect(),
        }
    }
}

fn dot(x: &[Long], y: &[Long]) -> Long {
    x.iter()
        .zip(y)
        .fold(Long::ZERO, |sum, (x, y)| sum + *x * *y)
}

impl Shape {
    /// Makes the shape of length 1, and forms its products.
    fn measure(&mut self, forms: [&Form; 3], weights: &[f64]) {
        let norm = length(self.x.iter().map(|x| short(*x)), weights);
        self.x.iter_mut().for_each(|x| *x = *x * (1.0 / norm));
        let parts: [Vec<DoubleDouble>; 2] = [
            self.x.iter().map(|x| x.re).collect(),
            self.x.iter().map(|x| x.im).collect(),
        ];
        self.products = forms.map(|form| {
            let [re, im] = parts.each_ref().map(|part| {
                let mut product = vec![DoubleDouble::ZERO; part.len()];
                form.accumulate_long(1.0, part, &mut product);
                product
            });
            re.into_iter()
                .zip(im)
                .map(|(re, im)| Long { re, im })
                .collect()
        });
    }

    /// xᵀ(2λM + C)x.
    fn slope(&self) -> Long {
        dot(&self.x, &self.products[0]) * self.value * 2.0 + dot(&self.x, &self.products[1])
    }

    /// Takes λ to the root of xᵀQ(λ)x near it; `false` where that has none.
    fn quotient(&mut self) -> bool {
        let [a, b, c] = [0, 1, 2].map(|p| dot(&self.x, &self.products[p]));
        for _ in 0..6 {
            let value = (a * self.value + b) * self.value + c;
            let slope = a * self.value * 2.0 + b;
            let step = value / slope;
            if !step.is_finite() {
                return false;
            }
            self.value = self.value - step;
        }
        true
    }

    /// Q(λ)x.
    fn residual(&self) -> Vec<Long> {
        let [m, c, k] = &self.products;
        let value = self.value;
        m.iter()
            .zip(c)
            .zip(k)
            .map(|((m, c), k)| (*m * value + *c) * value + *k)
            .collect()
    }
}
