//! General damping: the standard eigenproblem of the balanced state matrix.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd;
use faer::{Mat, MatRef, Par};
use num_complex::Complex;

use crate::balance::balance;
use crate::first_order::FirstOrder;
use crate::modes::Modes;
use crate::quality::pencil::{Pencil, norm};
use crate::quality::rayleigh::Forms;
use crate::structure::Structure;
use crate::system::System;

use super::roots::{Root, collect};
use super::{ModeSolver, ModesError, admit, cluster, rigid};

/// Eigenvalues of the state matrix A of z′ = A z, balanced, by the QR algorithm; each simple one is
/// then improved by the Rayleigh functional of its shapes (Lancaster 1966, §5.5). For every system
/// with a [first-order form](crate::FirstOrder).
#[derive(Clone, Copy, Debug)]
pub struct StateMatrix;

impl ModeSolver for StateMatrix {
    fn name(&self) -> &'static str {
        "state matrix"
    }

    fn refuses(&self, system: &System, _structure: &Structure) -> Option<String> {
        FirstOrder::of(system).err().map(|error| error.to_string())
    }

    fn reason(&self) -> &'static str {
        "generally damped: eigenvalues of the 2n states"
    }

    fn solve(&self, system: &System, structure: &Structure) -> Result<Modes, ModesError> {
        admit(self, system, structure)?;
        let form = FirstOrder::of(system)?;
        let left = (!structure.is_symmetric()).then(|| form.b());
        let mut found = eigen(self, form.a(), &|_, z| combined(form.x(), z), left)?;
        let mut roots = Vec::new();
        if let Some(zeros) = structure.zero_roots().filter(|zeros| *zeros > 0) {
            found.sort_by(|a, b| a.value.norm().total_cmp(&b.value.norm()));
            let removed: Vec<Root> = found.drain(..zeros.min(found.len())).collect();
            let mut shapes = rigid::shapes(system, structure);
            if shapes.is_empty() {
                shapes = removed.into_iter().map(|root| root.shape).collect();
                shapes.truncate(1);
            }
            roots.extend(rigid::roots(shapes, zeros));
        }
        roots.extend(refine(system, structure, found));
        Ok(collect(self, system, roots))
    }
}

/// The shape x that belongs to a root and the vector z of its state.
pub(crate) type ShapeOf<'a> = dyn Fn(Complex<f64>, &[Complex<f64>]) -> Vec<Complex<f64>> + 'a;

/// X z.
pub(crate) fn combined(x: MatRef<'_, f64>, z: &[Complex<f64>]) -> Vec<Complex<f64>> {
    (0..x.nrows())
        .map(|i| (0..z.len()).map(|s| z[s] * x[(i, s)]).sum())
        .collect()
}

/// All eigenvalues of A (N × N), conjugates included, with the shapes that `shape` makes of a root
/// and its vector z; with B, also the left shapes y = B*w.
pub(crate) fn eigen(
    solver: &dyn ModeSolver,
    a: MatRef<'_, f64>,
    shape: &ShapeOf<'_>,
    b: Option<MatRef<'_, f64>>,
) -> Result<Vec<Root>, ModesError> {
    let method = solver.name();
    let symmetric = b.is_none();
    let n = a.nrows();
    let balanced = balance(a);
    if !balanced.matrix.norm_max().is_finite() {
        return Err(ModesError::OutOfRange { method });
    }
    let (mut right, mut left) = (Mat::<f64>::zeros(n, n), Mat::<f64>::zeros(n, n));
    let (mut re, mut im) = (Diag::<f64>::zeros(n), Diag::<f64>::zeros(n));
    let wanted = evd::ComputeEigenvectors::Yes;
    let wanted_left = if symmetric {
        evd::ComputeEigenvectors::No
    } else {
        wanted
    };
    let scratch = evd::evd_scratch::<f64>(n, wanted_left, wanted, Par::Seq, Default::default());
    evd::evd_real(
        balanced.matrix.as_ref(),
        re.as_mut(),
        im.as_mut(),
        (!symmetric).then_some(left.as_mut()),
        Some(right.as_mut()),
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(scratch)),
        Default::default(),
    )
    .map_err(|_| ModesError::NoConvergence { method })?;

    let mut roots = Vec::with_capacity(n);
    let mut j = 0;
    while j < n {
        let value = Complex::new(re[j], im[j]);
        let pair = value.im != 0.0 && j + 1 < n;
        let vector = |vectors: &Mat<f64>, i: usize| {
            Complex::new(
                vectors[(i, j)],
                if pair { vectors[(i, j + 1)] } else { 0.0 },
            )
        };
        let z: Vec<Complex<f64>> = (0..n)
            .map(|i| vector(&right, i) * balanced.scale[i])
            .collect();
        let shape = shape(value, &z);
        let left = b.map(|b| {
            let w: Vec<Complex<f64>> = (0..n)
                .map(|i| vector(&left, i) / balanced.scale[i])
                .collect();
            let entry = |i| (0..n).map(|s| w[s] * b[(s, i)]).sum();
            (0..b.ncols()).map(entry).collect::<Vec<Complex<f64>>>()
        });
        let root = Root {
            left,
            ..Root::simple(value, shape)
        };
        if pair {
            let conjugate = |v: &[Complex<f64>]| v.iter().map(|z| z.conj()).collect::<Vec<_>>();
            roots.push(Root {
                value: value.conj(),
                shape: conjugate(&root.shape),
                left: root.left.as_deref().map(conjugate),
                ..root.clone()
            });
            j += 1;
        }
        roots.push(root);
        j += 1;
    }
    Ok(roots)
}

/// Improves simple roots by their Rayleigh functional and replaces groups that belong to one
/// defective root by their mean; keeps the half with Im ≥ 0.
pub(crate) fn refine(system: &System, structure: &Structure, found: Vec<Root>) -> Vec<Root> {
    let pencil = Pencil::of(system);
    let states = found.len() as f64;
    let lefts: Vec<Vec<Complex<f64>>> = found.iter().map(Root::left).collect();
    let radii: Vec<f64> = found
        .iter()
        .zip(&lefts)
        .map(|(root, left)| {
            let condition = pencil.condition(root.value, &root.shape, left);
            let size = root.value.norm();
            // A defective root of multiplicity m scatters by u^(1/m) with condition u^(1/m − 1).
            condition.map_or(size, |k| (8.0 * states * f64::EPSILON * k).min(1e-2) * size)
        })
        .collect();
    let values: Vec<Complex<f64>> = found.iter().map(|root| root.value).collect();
    let mut roots = Vec::new();
    for group in cluster::groups(&values, &radii) {
        let count = group.len();
        let first = group[0];
        let parallel = group
            .iter()
            .all(|i| collinearity(&found[*i], &found[first]) > 1.0 - 1e-6);
        if count == 1 || !parallel {
            for &i in group.iter().filter(|i| values[**i].im >= 0.0) {
                roots.push(improved(system, structure, &pencil, &found[i], radii[i]));
            }
            continue;
        }
        let mean = group.iter().map(|i| values[*i]).sum::<Complex<f64>>() / count as f64;
        let straddles = group.iter().any(|i| values[*i].im >= 0.0)
            && group.iter().any(|i| values[*i].im <= 0.0);
        let mean = if straddles {
            Complex::from(mean.re)
        } else {
            mean
        };
        if mean.im < 0.0 {
            continue;
        }
        let spread = group
            .iter()
            .map(|i| (values[*i] - mean).norm() + radii[*i])
            .fold(0.0, f64::max);
        let (mut shape, mut left) = (found[first].shape.clone(), found[first].left.clone());
        if let Some([x, y]) = pencil.null_vectors(mean) {
            shape = x;
            left = left.map(|_| y);
        }
        roots.push(Root {
            value: mean,
            shape,
            left,
            count,
            defective: true,
            error: Some((spread, spread)),
        });
    }
    roots
}

/// |x*y|/(‖x‖‖y‖) of two shapes.
fn collinearity(a: &Root, b: &Root) -> f64 {
    let product: Complex<f64> = a
        .shape
        .iter()
        .zip(&b.shape)
        .map(|(x, y)| x.conj() * y)
        .sum();
    product.norm() / (norm(&a.shape) * norm(&b.shape))
}

/// The root moved to that of its Rayleigh functional, where that is near and well defined; where its
/// shape then fails the equations, with the shape that fulfils them best.
fn improved(
    system: &System,
    structure: &Structure,
    pencil: &Pencil,
    root: &Root,
    radius: f64,
) -> Root {
    const UNITS: f64 = 8.0 * f64::EPSILON;
    let mut better = moved(system, structure, root, radius);
    if pencil.backward_error(better.value, &better.shape) > UNITS
        && let Some([x, y]) = pencil.null_vectors(better.value)
    {
        let left = better.left.is_some().then_some(y);
        let again = moved(
            system,
            structure,
            &Root {
                shape: x,
                left,
                ..better.clone()
            },
            radius,
        );
        let error = |root: &Root| pencil.backward_error(root.value, &root.shape);
        if error(&again) < error(&better) {
            better = again;
        }
    }
    better
}

/// The root of the Rayleigh functional of the given root's shapes.
fn moved(system: &System, structure: &Structure, root: &Root, radius: f64) -> Root {
    let forms = Forms::of(system, &root.left(), &root.shape);
    let mut value = root.value;
    if let Some(better) = forms.root(root.value)
        && (better - root.value).norm() <= radius.max(1e-12 * root.value.norm())
    {
        value = better;
    }
    if root.value.im == 0.0 {
        value.im = 0.0;
    }
    if structure.is_passive() && value.re > 0.0 {
        value.re = 0.0;
    }
    Root {
        value,
        ..root.clone()
    }
}
