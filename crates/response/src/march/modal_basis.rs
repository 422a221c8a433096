//! The states of a system as sums of modes, each of which moves by itself.

use eigentone_digits::{DoubleDouble, Lu, Magnitude, product};
use eigentone_modes::{ClassicalModes, FirstOrder, Modes, ModesError, Precision, System};
use faer::{Mat, MatRef, Scale};
use thiserror::Error;

use super::estimate::{Detour, size};
use crate::enclosed::{Normed, exponential};
use crate::exponential::by_taylor;
use crate::hold::{Laws, exact};

/// z = T ζ with A T = T diag(blocks).
pub(crate) struct Basis {
    pub(crate) form: FirstOrder,
    pub(crate) t: Mat<f64>,
    pub(crate) inverse: Mat<f64>,
    pub(crate) blocks: Vec<Block>,
    /// By how much rounding errors of displacements or velocities may grow on the way to modes and back.
    pub(crate) enlargement: f64,
    /// What that way leaves of them.
    pub(crate) detour: Detour,
}

/// One or two states that move by themselves, with the generator by rows.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    pub(crate) width: usize,
    generator: Vec<DoubleDouble>,
}

impl Block {
    /// One state of this rate.
    pub(crate) fn of_one(rate: DoubleDouble) -> Block {
        Block {
            width: 1,
            generator: vec![rate],
        }
    }

    /// Its generator, by rows.
    pub(crate) fn generator(&self) -> &[DoubleDouble] {
        &self.generator
    }
}

/// Why there is no basis.
#[derive(Debug, Error)]
pub(crate) enum BasisError {
    #[error("{0}")]
    Refused(String),
    #[error(transparent)]
    Modes(#[from] ModesError),
}

/// Complex shapes are refused where going to modes and back would enlarge rounding errors of
/// displacements or velocities more than this.
const LARGEST_CONDITION: f64 = 1e8;

impl Basis {
    /// The blocks, standing still where none of the `moving` states takes part.
    pub(crate) fn blocks(&self, moving: &[bool]) -> Vec<Block> {
        let mut first = 0;
        let each = self.blocks.iter().map(|block| {
            let rows = first..first + block.width;
            first = rows.end;
            let takes_part =
                |k: usize| (0..moving.len()).any(|j| moving[j] && self.inverse[(k, j)] != 0.0);
            match rows.clone().any(takes_part) {
                true => block.clone(),
                false => Block {
                    width: block.width,
                    generator: vec![DoubleDouble::ZERO; block.generator.len()],
                },
            }
        });
        each.collect()
    }

    /// Real shapes where the damping is proved to be classical, else complex ones from roots of this precision.
    pub(crate) fn of(system: &System, precision: Precision) -> Result<Basis, BasisError> {
        let form =
            FirstOrder::of(system).map_err(|error| BasisError::Refused(error.to_string()))?;
        match ClassicalModes::of(system)? {
            // Rounding at the ends of the range of doubles can leave fewer shapes.
            Some(modes) if modes.shapes().ncols() < form.massive().len() => Err(
                BasisError::Refused("the shapes do not span the motion".to_owned()),
            ),
            Some(modes) => Ok(Basis::classical(form, system, &modes)),
            None => Basis::complex(form, &system.modes_to(precision)?).map_err(BasisError::Refused),
        }
    }

    /// Blocks [0 1; −k/m −c/m] of real shapes.
    fn classical(form: FirstOrder, system: &System, modes: &ClassicalModes) -> Basis {
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
        let rows = row_norms(&t);
        Basis {
            blocks: blocks.collect(),
            enlargement: enlargement(&t, &inverse, &rows, nf),
            detour: detour(&form, &t, &size(inverse.as_ref())),
            form,
            t,
            inverse,
        }
    }

    /// Blocks [α β; −β α] of conjugate pairs and [α] of real roots.
    fn complex(form: FirstOrder, modes: &Modes) -> Result<Basis, String> {
        if modes.iter().any(|mode| mode.roots() > 1) {
            return Err(
                "roots that have one shape in common: the shapes do not span the motion".to_owned(),
            );
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
        // Rows of unlike units are evened out before they are factored and judged.
        let rows = row_norms(&t);
        if rows.contains(&0.0) {
            return Err("the shapes do not span the motion".to_owned());
        }
        let even = Mat::from_fn(n, n, |i, j| t[(i, j)] / rows[i]);
        let mut inverse = Lu::of(even.as_ref()).inverse();
        // A step of Newton's method: what an elimination leaves of T T⁻¹ − 1 may be larger than what products round.
        let left = Mat::<f64>::identity(n, n) - product(even.as_ref(), inverse.as_ref());
        // It leaves the square of that, and rounds by units of the entries before it, which may be all that there is.
        let (mut sizes, left_size) = (size(inverse.as_ref()), size(left.as_ref()));
        let square = product(left_size.as_ref(), left_size.as_ref());
        sizes += product(sizes.as_ref(), square.as_ref()) * Scale(f64::EPSILON.recip());
        inverse += product(inverse.as_ref(), left.as_ref());
        let uneven = |even: &Mat<f64>| Mat::from_fn(n, n, |i, j| even[(i, j)] / rows[j]);
        let (inverse, sizes) = (uneven(&inverse), uneven(&sizes));
        let half = form.massive().len();
        let enlargement = enlargement(&t, &inverse, &rows, half);
        if enlargement.is_nan() || enlargement > LARGEST_CONDITION {
            return Err(format!(
                "its complex shapes are ill-conditioned ({enlargement:.0e})"
            ));
        }
        Ok(Basis {
            detour: detour(&form, &t, &sizes),
            form,
            t,
            inverse,
            blocks,
            enlargement,
        })
    }
}

fn row_norms(t: &Mat<f64>) -> Vec<f64> {
    (0..t.nrows()).map(|i| t.row(i).norm_l2()).collect()
}

/// By how much rounding errors may grow on the way to modal coordinates and back: sums of |D⁻¹T||T⁻¹D| along
/// the rows, D the diagonal matrix of these norms of the rows of T, over displacements for displacements (the first
/// `half` states) and over the other states for those. Unlike a norm of T times one of T⁻¹, it does not hold
/// it against fast modes that they move much faster than slow ones (Skeel 1979, *J. ACM* 26).
fn enlargement(t: &Mat<f64>, inverse: &Mat<f64>, rows: &[f64], half: usize) -> f64 {
    let n = t.nrows();
    let into = |alike: std::ops::Range<usize>| -> Vec<f64> {
        let sum = |k: usize| -> f64 {
            let entries = alike.clone().map(|j| (inverse[(k, j)] * rows[j]).abs());
            entries.sum()
        };
        (0..n).map(sum).collect()
    };
    let (first, other) = (into(0..half), into(half..n));
    let sum = |i: usize| -> f64 {
        let into = if i < half { &first } else { &other };
        let terms = into.iter().enumerate();
        terms
            .map(|(k, into)| (t[(i, k)] / rows[i]).abs() * into)
            .sum()
    };
    // A NaN is to be found.
    (0..n)
        .map(sum)
        .fold(0.0, |top, sum| if sum <= top { top } else { sum })
}

/// The largest sums along a row of |X||T||T⁻¹| and |XA||T||T⁻¹|, from displacements and from velocities to either of all
/// coordinates, given sizes of T⁻¹ in units of which it is rounded. Of the states the second `massive` are velocities.
fn detour(form: &FirstOrder, t: &Mat<f64>, inverse: &Mat<f64>) -> Detour {
    let (n, half) = (t.nrows(), form.massive().len());
    let kind = |i: usize| usize::from((half..2 * half).contains(&i));
    let mut into = Mat::<f64>::zeros(n, 2);
    for k in 0..n {
        (0..n).for_each(|j| into[(k, kind(j))] += inverse[(k, j)]);
    }
    let states = size(t.as_ref()) * into;
    let leaves = |map: Mat<f64>| {
        let rows = size(map.as_ref()) * &states;
        [0, 1].map(|from| rows.col(from).norm_max())
    };
    let x = form.x().to_owned();
    let v = product(x.as_ref(), form.a());
    Detour {
        leaves: [leaves(x), leaves(v)],
    }
}

/// The hold of one block.
pub(crate) struct HeldBlock {
    pub(crate) width: usize,
    /// By rows.
    pub(crate) phi: Vec<DoubleDouble>,
    /// What the loads add, law by law.
    pub(crate) gamma: Vec<Mat<f64>>,
}

impl HeldBlock {
    pub(crate) fn of(block: &Block, h: DoubleDouble, laws: &Laws) -> HeldBlock {
        let width = block.width;
        let exactly = Normed::new(width, width, block.generator.clone(), Magnitude::ZERO);
        let power = exponential(&exactly, h, Magnitude::ZERO);
        HeldBlock {
            width,
            phi: power.entries().to_vec(),
            gamma: integrated(block, h, laws, 0),
        }
    }
}

/// What unit loads on the states of a block add, law by law, where they are integrated so many times first, from 0 on.
pub(crate) fn integrated(
    block: &Block,
    h: DoubleDouble,
    laws: &Laws,
    times: usize,
) -> Vec<Mat<f64>> {
    let width = block.width;
    let size = width * (times + 1);
    let generator = Mat::from_fn(size, size, |i, j| match i < width && j < width {
        true => block.generator[i * width + j].to_f64(),
        false => f64::from(u8::from(j == i + width)),
    });
    let unit = Mat::from_fn(size, width, |i, j| {
        f64::from(u8::from(i == size - width + j))
    });
    let held = exact(
        by_taylor,
        generator.as_ref(),
        unit.as_ref(),
        h.to_f64(),
        laws,
    );
    let own = held
        .gamma
        .iter()
        .map(|gamma| gamma.subrows(0, width).to_owned());
    own.collect()
}

/// sum += matrix · vector, for one or two states.
pub(crate) fn add_to_block(matrix: MatRef<'_, f64>, vector: &[f64], sum: &mut [f64; 2]) {
    for (j, factor) in vector.iter().enumerate() {
        for i in 0..vector.len() {
            sum[i] += matrix[(i, j)] * factor;
        }
    }
}

#[cfg(test)]
mod tests {
    use eigentone_modes::GROUND;

    use super::*;

    /// Shapes without imaginary parts make no displacement of a velocity; what the inversion leaves of one is within its estimate.
    #[test]
    fn what_the_inversion_leaves_is_estimated() {
        for n in 2..12 {
            let mut builder = System::builder();
            for i in 0..n {
                let before = match i {
                    0 => GROUND.to_owned(),
                    _ => format!("m{}", i - 1),
                };
                let (name, stiffness) = (format!("m{i}"), 7.3 * 1.9f64.powi(i));
                builder = builder.mass(&name, 0.1 * f64::from(i * i % 7 + 1));
                builder = builder.spring(&before, &name, stiffness);
                builder = builder.damper(&before, &name, stiffness / 1024.0);
            }
            let system = builder.build().expect("a system");
            let form = FirstOrder::of(&system).expect("masses");
            let modes = system.modes().expect("modes");
            let basis = Basis::complex(form, &modes).expect("well conditioned");
            let (half, from) = (n as usize, n as usize);
            let moved = &basis.t * basis.inverse.col(from);
            let left = moved.subrows(0, half).norm_max();
            let [[_, leaves], _] = basis.detour.leaves;
            assert!(
                left <= 8.0 * f64::EPSILON * leaves,
                "{n}: {left:e} {leaves:e}"
            );
            assert!(leaves < 1.0, "{n}: {leaves:e}");
        }
    }
}
