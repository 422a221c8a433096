//! Damped modes by projection: λ²y + λ ΦᵀCΦ y + ΦᵀKΦ y = 0 on the undamped shapes Φ that were found.
//!
//! The projected equation is exact for the damping of each shape by itself; what is left out is how damping
//! couples the shapes that were found with those that were not. The residual r = Q(λ)Φy is orthogonal to Φ
//! and tells of it: to second order λ is off by |rᵀ(K − σM)⁻¹r| / |xᵀ(2λM + C)x|, as far as the
//! shapes left out follow without inertia.

use num_complex::Complex;

use crate::modes::{Bounds, Eigenvalue, Mode, Modes, Motion, Precision, Repeats, listed, order};
use crate::plan::ModePlan;
use crate::solver::{ModesError, normalised};
use crate::system::System;
use faer::Mat;

use super::SparseModes;
use super::basis::dot;
use super::factor::Factor;
use super::form::Form;
use super::operator::ShiftInvert;

/// A vector by its real and imaginary parts.
type Parts = [Vec<f64>; 2];

/// A root with its shape, its residual and what is known of its error.
struct Root {
    value: Complex<f64>,
    /// Estimated |λ̂ − λ| and that of the real part.
    error: Option<(f64, f64)>,
    shape: Parts,
    repeats: Repeats,
    /// How many roots it stands for.
    roots: usize,
}

/// All modes of the projected equation, with their residuals in the whole one.
pub(crate) fn modes(found: &SparseModes, damping: &Form) -> Result<Modes, ModesError> {
    let judge = Judge::of(found, damping);
    let mut roots = if damping.is_zero() {
        undamped(found)
    } else {
        projected(found, damping, &judge)?
    };
    let mut modes: Vec<Mode> = roots.drain(..).map(|root| judge.mode(root)).collect();
    modes.sort_by(|a, b| order(&a.eigenvalue, &b.eigenvalue));
    Ok(Modes {
        eigenvalues: listed(&modes),
        modes,
        infinite: found.infinite,
        bounds: Bounds::Estimated,
        complete: found.counted,
        plan: plan(found, damping),
    })
}

fn plan(found: &SparseModes, damping: &Form) -> ModePlan {
    let count = found.len();
    let counted = if found.is_counted() {
        "the signs of pivots confirm that none between them is missing"
    } else {
        "that none between them is missing is not confirmed"
    };
    let mut left_out = vec![("other modes", format!("{count} were asked for; {counted}"))];
    if !damping.is_zero() {
        let reason = "damping is projected on the shapes found: their coupling to others is in the residuals";
        left_out.push(("coupling to other modes", reason.to_owned()));
    }
    ModePlan {
        solver: "sparse Lanczos",
        reason: "some modes, without dense matrices".to_owned(),
        bounds: "estimated from residuals, in doubles".to_owned(),
        left_out,
    }
}

fn undamped(found: &SparseModes) -> Vec<Root> {
    let rigid = found
        .squares
        .iter()
        .filter(|square| **square == 0.0)
        .count();
    let mut roots = Vec::new();
    let mut listed = false;
    for (k, (&square, error)) in found.squares.iter().zip(&found.errors).enumerate() {
        let zeros = vec![0.0; found.shapes.nrows()];
        let shape = [found.shapes.col(k).iter().copied().collect(), zeros];
        let size = square.abs().sqrt();
        // Where ω² is not told from 0, its root is 0 within that of the bound.
        let unclear = error.is_some_and(|error| square.abs() <= error);
        let error = error.map(|error| match unclear {
            true => (square.abs() + error).sqrt(),
            false => error / size / 2.0,
        });
        let root = |value, error, roots| Root {
            value,
            error,
            shape: shape.clone(),
            repeats: match roots {
                1 => Repeats::SIMPLE,
                count if error == Some((0.0, 0.0)) => Repeats::Exactly {
                    count,
                    defective: Some(true),
                },
                count => Repeats::Cluster(count),
            },
            roots,
        };
        if unclear {
            // One entry for all rigid motions, as every two roots of one share a shape.
            match square == 0.0 {
                true if !std::mem::replace(&mut listed, true) => {
                    roots.push(root(Complex::ZERO, Some((0.0, 0.0)), 2 * rigid));
                }
                true => {}
                false => roots.push(root(Complex::ZERO, error.map(|e| (e, e)), 2)),
            }
        } else if square > 0.0 {
            roots.push(root(Complex::new(0.0, size), error.map(|e| (e, 0.0)), 1));
        } else {
            for value in [size, -size] {
                roots.push(root(Complex::from(value), error.map(|e| (e, e)), 1));
            }
        }
    }
    roots
}

/// The projected equation.
pub(crate) fn reduced(found: &SparseModes, damping: &Form) -> Result<System, ModesError> {
    let count = found.len();
    let shapes = columns(found);
    let mut coupling = Mat::<f64>::zeros(count, count);
    if !damping.is_zero() {
        for j in 0..count {
            for i in (0..=j).filter(|&i| i == j || !found.classical) {
                coupling[(i, j)] = damping.bilinear(&shapes[i], &shapes[j]);
                coupling[(j, i)] = coupling[(i, j)];
            }
        }
    }
    let unit = Mat::<f64>::identity(count, count);
    let squares = Mat::from_fn(count, count, |i, j| match i == j {
        true => found.squares[i],
        false => 0.0,
    });
    System::from_matrices(unit.as_ref(), coupling.as_ref(), squares.as_ref()).map_err(|_| {
        ModesError::OutOfRange {
            method: "sparse Lanczos",
        }
    })
}

fn columns(found: &SparseModes) -> Vec<Vec<f64>> {
    let column = |k| found.shapes.col(k).iter().copied().collect();
    (0..found.len()).map(column).collect()
}

fn projected(
    found: &SparseModes,
    damping: &Form,
    judge: &Judge<'_>,
) -> Result<Vec<Root>, ModesError> {
    let shapes = columns(found);
    let small = reduced(found, damping)?;
    let small = small.modes_to(Precision::Double)?;
    let root = |mode: &Mode| {
        let combine = |part: fn(&Complex<f64>) -> f64| {
            let mut sum = vec![0.0; found.shapes.nrows()];
            for (shape, factor) in shapes.iter().zip(mode.shape()) {
                let factor = part(factor);
                sum.iter_mut()
                    .zip(shape)
                    .for_each(|(sum, x)| *sum += factor * x);
            }
            sum
        };
        let shape = [combine(|z| z.re), combine(|z| z.im)];
        let eigenvalue = mode.eigenvalue();
        let of_residual = judge.error(eigenvalue.value, &shape);
        // What the squares may be off shows in λ as it does without damping.
        let own = found.relative_error();
        let error = match (mode.motion(), eigenvalue.bound, of_residual, own) {
            (Motion::Rigid, bound, ..) => bound.map(|bound| (bound, bound)),
            (_, Some(bound), Some(residual), Some(own)) => {
                let whole = bound + residual + own * eigenvalue.value.norm();
                Some((
                    whole,
                    eigenvalue.real_bound.map_or(whole, |real| real + residual),
                ))
            }
            _ => None,
        };
        Root {
            value: eigenvalue.value,
            error: error.filter(|_| mode.roots() == 1 || eigenvalue.value.norm() == 0.0),
            shape,
            repeats: mode.repeats,
            roots: mode.roots,
        }
    };
    Ok(small.iter().map(root).collect())
}

/// Measures residuals in the whole equation.
struct Judge<'a> {
    found: &'a SparseModes,
    damping: &'a Form,
    operator: ShiftInvert<'a>,
    /// Frobenius norms of M, C and K.
    norms: [f64; 3],
}

impl<'a> Judge<'a> {
    fn of(found: &'a SparseModes, damping: &'a Form) -> Judge<'a> {
        let pencil = &*found.pencil;
        Judge {
            found,
            damping,
            operator: ShiftInvert::new(Factor::of(pencil, found.shift), pencil, found.shift),
            norms: [&pencil.mass, damping, &pencil.stiffness].map(Form::norm),
        }
    }

    /// Q(λ)x.
    fn residual(&self, value: Complex<f64>, shape: &Parts) -> Parts {
        let n = shape[0].len();
        let mut rest = [vec![0.0; n], vec![0.0; n]];
        let mut product = vec![0.0; n];
        let pencil = &self.found.pencil;
        let one = Complex::ONE;
        for (form, factor) in [
            (&pencil.mass, value * value),
            (self.damping, value),
            (&pencil.stiffness, one),
        ] {
            for (part, unit) in shape.iter().zip([one, Complex::I]) {
                form.apply(part, &mut product);
                let factor = factor * unit;
                for (rest, factor) in rest.iter_mut().zip([factor.re, factor.im]) {
                    let pairs = rest.iter_mut().zip(&product);
                    pairs.for_each(|(rest, value)| *rest += factor * value);
                }
            }
        }
        rest
    }

    /// How far damping that couples the shape to those left out moves λ, to second order.
    fn error(&self, value: Complex<f64>, shape: &Parts) -> Option<f64> {
        let rest = self.residual(value, shape);
        let mut answer = rest.clone();
        let mut work = vec![0.0; rest[0].len()];
        for part in &mut answer {
            self.operator.solve(part, &mut work);
        }
        let inner = |x: &Parts, y: &Parts| {
            let re = dot(&x[0], &y[0]) - dot(&x[1], &y[1]);
            Complex::new(re, dot(&x[0], &y[1]) + dot(&x[1], &y[0]))
        };
        // Shapes left out follow with inertia, most that of the nearest.
        let shift = self.found.shift;
        let inertia = self.found.next.map_or(1.0, |next| {
            (next - shift).abs() / ((next - shift).abs() - (value.norm_sqr() - shift).abs())
        });
        let error = 2.0 * inertia * inner(&rest, &answer).norm() / self.slope(value, shape);
        (inertia >= 1.0 && error <= 1e-2 * value.norm()).then_some(error)
    }

    fn mode(&self, root: Root) -> Mode {
        let Root {
            value,
            error,
            shape,
            repeats,
            roots,
        } = root;
        let rest = self.residual(value, &shape);
        let squared = |x: &Parts| dot(&x[0], &x[0]) + dot(&x[1], &x[1]);
        let [mass, damping, stiffness] = self.norms;
        let size = value.norm();
        let scale = (size * mass + damping) * size + stiffness;
        let condition = (roots == 1 && size != 0.0)
            .then(|| scale * squared(&shape) / (size * self.slope(value, &shape)));
        let backward_error = (squared(&rest) / squared(&shape)).sqrt() / scale;
        let pairs = shape[0].iter().zip(&shape[1]);
        let shape: Vec<Complex<f64>> = pairs.map(|(re, im)| Complex::new(*re, *im)).collect();
        let shape = normalised(&shape);
        Mode {
            eigenvalue: Eigenvalue {
                value,
                bound: error.map(|(whole, _)| whole),
                real_bound: error.map(|(_, real)| real),
            },
            repeats,
            roots,
            left_shape: Some(shape.iter().map(|entry| entry.conj()).collect()),
            left_shape_bound: None,
            shape,
            shape_bound: None,
            backward_error,
            condition: condition.filter(|condition| condition.is_finite()),
        }
    }

    /// |xᵀ(2λM + C)x|.
    fn slope(&self, value: Complex<f64>, [re, im]: &Parts) -> f64 {
        let form = |form: &Form| {
            let real = form.bilinear(re, re) - form.bilinear(im, im);
            Complex::new(real, 2.0 * form.bilinear(re, im))
        };
        (form(&self.found.pencil.mass) * value * 2.0 + form(self.damping)).norm()
    }
}
