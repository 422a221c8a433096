//! General damping: the standard eigenproblem of the balanced state matrix.

use eigentone_digits::DoubleDouble;
use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd;
use faer::linalg::solvers::Solve;
use faer::{Mat, MatRef, Par};
use num_complex::Complex;

use crate::balance::balance;
use crate::first_order::FirstOrder;
use crate::modes::Modes;
use crate::quality::pencil::{Approximate, Pencil, norm, products};
use crate::quality::rayleigh::Forms;
use crate::structure::Structure;
use crate::system::System;
use crate::vector::settle;

use super::newton::{FEW, resolved};
use super::roots::{Root, SMALL, collect};
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
        let mut found = eigen(self, form.a(), form.x(), &|_, z| z, left)?;
        let mut roots = Vec::new();
        if let Some(zeros) = structure.zero_roots().filter(|zeros| *zeros > 0) {
            let removed = rigid::removed(&mut found, zeros);
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

/// The amplitudes of a basis of shapes that belong to a root and the vector z of its state.
pub(crate) type Amplitudes<'a> = dyn Fn(Complex<f64>, Vec<Complex<f64>>) -> Vec<Complex<f64>> + 'a;

/// All eigenvalues of A (N × N), conjugates included, with the shapes that a basis (n × any) has
/// with the amplitudes of each; with B, also the left shapes y = B*w.
pub(crate) fn eigen(
    solver: &dyn ModeSolver,
    a: MatRef<'_, f64>,
    basis: MatRef<'_, f64>,
    amplitudes: &Amplitudes<'_>,
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
    settle();

    // One of each conjugate pair: its column, its root, and whether it is a pair.
    let mut found = Vec::with_capacity(n);
    let mut j = 0;
    while j < n {
        let value = Complex::new(re[j], im[j]);
        let pair = value.im != 0.0 && j + 1 < n;
        found.push((j, value, pair));
        j += if pair { 2 } else { 1 };
    }
    let vectors = |vectors: &Mat<f64>, scale: &dyn Fn(usize) -> f64| -> Vec<Vec<Complex<f64>>> {
        let vector = |(j, _, pair): &(usize, Complex<f64>, bool)| {
            let im = |i| if *pair { vectors[(i, j + 1)] } else { 0.0 };
            let entry = |i| Complex::new(vectors[(i, *j)], im(i)) * scale(i);
            of_size_one((0..n).map(entry).collect())
        };
        found.iter().map(vector).collect()
    };
    let mut right = vectors(&right, &|i| balanced.scale[i]);
    for ((_, value, _), z) in found.iter().zip(&mut right) {
        if !is_direction(z) {
            let z_balanced = by_inverse_iteration(balanced.matrix.as_ref(), *value);
            let entries = z_balanced.iter().zip(&balanced.scale);
            *z = of_size_one(entries.map(|(z, scale)| z * scale).collect());
        }
    }
    let right: Vec<Vec<Complex<f64>>> = found
        .iter()
        .zip(right)
        .map(|((_, value, _), z)| amplitudes(*value, z))
        .collect();
    let right: Vec<&[Complex<f64>]> = right.iter().map(Vec::as_slice).collect();
    let shapes: Vec<Vec<Complex<f64>>> = products(basis, &right)
        .into_iter()
        .map(of_size_one)
        .collect();
    // Motions at rest need none: their shapes are known.
    let mut moving = found.iter().zip(&shapes);
    if moving.any(|((_, value, _), shape)| *value != Complex::ZERO && !is_direction(shape)) {
        return Err(ModesError::OutOfRange { method });
    }
    let lefts = b.map(|b| {
        let left = vectors(&left, &|i| 1.0 / balanced.scale[i]);
        let left: Vec<&[Complex<f64>]> = left.iter().map(Vec::as_slice).collect();
        products(b.transpose(), &left)
    });

    let mut roots = Vec::with_capacity(n);
    let mut lefts = lefts.map(Vec::into_iter);
    for ((_, value, pair), shape) in found.into_iter().zip(shapes) {
        let root = Root {
            left: lefts.as_mut().and_then(Iterator::next),
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
        }
        roots.push(root);
    }
    Ok(roots)
}

/// Whether a vector is finite and not 0.
fn is_direction(vector: &[Complex<f64>]) -> bool {
    let size: f64 = vector.iter().map(Complex::l1_norm).sum();
    size.is_finite() && size > 0.0
}

/// The vector of a root, by inverse iteration: where roots coincide, the substitution that follows the QR algorithm
/// may divide by 0. Half of the digits away from the root no pivot vanishes, not even that of a Jordan block, whose
/// vector is known to no more.
fn by_inverse_iteration(a: MatRef<'_, f64>, value: Complex<f64>) -> Vec<Complex<f64>> {
    let n = a.nrows();
    let shift = value + Complex::from(f64::EPSILON.sqrt() * a.norm_l2());
    let shifted = Mat::from_fn(n, n, |i, j| {
        let own = if i == j { shift } else { Complex::ZERO };
        Complex::from(a[(i, j)]) - own
    });
    let factors = shifted.partial_piv_lu();
    settle();
    let mut z = Mat::from_fn(n, 1, |_, _| Complex::from(1.0));
    for _ in 0..3 {
        let next = factors.solve(&z);
        settle();
        let largest = next.norm_max();
        z = Mat::from_fn(n, 1, |i, _| next[(i, 0)] / largest);
    }
    (0..n).map(|i| z[(i, 0)]).collect()
}

/// The vector times the power of two that brings its largest entry to about 1: components in units far
/// apart, squared or multiplied, would leave the doubles.
fn of_size_one(mut vector: Vec<Complex<f64>>) -> Vec<Complex<f64>> {
    let sizes = vector.iter().map(Complex::l1_norm);
    let largest = sizes.fold(0.0, f64::max);
    if largest > 0.0 && largest.is_finite() {
        // In two factors, of which neither leaves the doubles.
        let half = (-0.5 * largest.log2()).round().exp2();
        vector
            .iter_mut()
            .for_each(|entry| *entry = *entry * half * half);
    }
    vector
}

/// Improves simple roots by their Rayleigh functional and replaces groups that belong to one
/// defective root by their mean; keeps the half with Im ≥ 0.
pub(crate) fn refine(system: &System, structure: &Structure, found: Vec<Root>) -> Vec<Root> {
    let pencil = Pencil::of(system);
    let states = found.len() as f64;
    let radii = radii(&pencil, &found, states);
    let values: Vec<Complex<f64>> = found.iter().map(|root| root.value).collect();
    let mut roots = Vec::new();
    // Those that stand by themselves, with their radii.
    let mut alone = Vec::new();
    for group in cluster::groups(&values, &radii) {
        let count = group.len();
        let first = group[0];
        let parallel = group
            .iter()
            .all(|i| collinearity(&found[*i], &found[first]) > 1.0 - 1e-6);
        if count == 1 || !parallel {
            alone.extend(group.into_iter().filter(|i| values[*i].im >= 0.0));
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
        // A defective root of multiplicity m scatters by u^(1/m) (Lidskii 1966).
        let scatter = (8.0 * states * f64::EPSILON).powf(1.0 / count as f64) * mean.norm();
        let spread = group
            .iter()
            .map(|i| (values[*i] - mean).norm() + radii[*i].min(scatter))
            .fold(0.0, f64::max);
        let mut root = Root {
            value: mean,
            count,
            defective: true,
            error: Some((spread, spread)),
            ..found[first].clone()
        };
        if let Some([x, y]) = pencil.null_vectors(&root.approximate()) {
            root.shape = x;
            root.left = root.left.map(|_| y);
        }
        roots.push(root);
    }
    roots.extend(improved(system, structure, &pencil, &found, &radii, &alone));
    roots
}

/// Improves roots that are known to be simple, given with Im ≥ 0 and how far off each may be.
pub(crate) fn refine_simple(
    system: &System,
    structure: &Structure,
    found: Vec<Root>,
    radii: &[f64],
) -> Vec<Root> {
    let pencil = Pencil::of(system);
    let all: Vec<usize> = (0..found.len()).collect();
    improved(system, structure, &pencil, &found, radii, &all)
}

/// How far off each root may be, from its backward error and condition.
fn radii(pencil: &Pencil, found: &[Root], states: f64) -> Vec<f64> {
    let upper: Vec<usize> = (0..found.len())
        .filter(|i| found[*i].value.im >= 0.0)
        .collect();
    let approximate: Vec<Approximate<'_>> = upper.iter().map(|i| found[*i].approximate()).collect();
    let mut radii = vec![0.0; found.len()];
    for (&i, quality) in upper.iter().zip(pencil.qualities(&approximate)) {
        let size = found[i].value.norm();
        // Where a root is defective this is endless.
        radii[i] = quality.condition.map_or(size, |condition| {
            let error = 8.0 * states * f64::EPSILON + 2.0 * quality.backward_error;
            (error * condition).min(1e-2) * size
        });
    }
    for i in 0..found.len() {
        if found[i].value.im < 0.0 {
            let conjugate = found[i].value.conj();
            let twin = upper.iter().find(|j| found[**j].value == conjugate);
            radii[i] = twin.map_or(found[i].value.norm(), |j| radii[*j]);
        }
    }
    radii
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

/// The chosen roots moved to those of their Rayleigh functionals, where these are near and well
/// defined; where the shape then fails the equations, with the shape that fulfils them best.
fn improved(
    system: &System,
    structure: &Structure,
    pencil: &Pencil,
    found: &[Root],
    radii: &[f64],
    chosen: &[usize],
) -> Vec<Root> {
    const UNITS: f64 = 8.0 * f64::EPSILON;
    const ROUNDS: usize = 12;
    const DOUBTFUL: f64 = 1e-11;
    let rated = |roots: &mut [Root]| {
        let approximate: Vec<Approximate<'_>> = roots.iter().map(Root::approximate).collect();
        let qualities = pencil.qualities(&approximate);
        for (root, quality) in roots.iter_mut().zip(qualities) {
            root.quality = Some(quality);
        }
    };
    let error = |root: &Root| root.quality.map_or(f64::INFINITY, |q| q.backward_error);
    let doubt = |root: &Root| root.quality.map_or(f64::INFINITY, |q| q.first_order());
    let mut roots: Vec<Root> = chosen
        .iter()
        .map(|i| moved(system, structure, found[*i].clone(), radii[*i]))
        .collect();
    rated(&mut roots);
    let before = roots.clone();
    // A root may have lost most of its digits, but not so many that it passes for another.
    let reach = |i: usize| {
        let start = found[i].value;
        let others = found
            .iter()
            .flat_map(|other| [other.value, other.value.conj()])
            .map(|other| (other - start).norm());
        let gap = others.filter(|gap| *gap > 0.0).fold(start.norm(), f64::min);
        radii[i].max(0.5 * gap)
    };
    for (root, &i) in roots.iter_mut().zip(chosen) {
        for _ in 0..ROUNDS {
            let last = error(root);
            for search in [Pencil::inverse_iteration, Pencil::null_vectors] {
                if error(root) <= UNITS {
                    break;
                }
                let Some([x, y]) = search(pencil, &root.approximate()) else {
                    continue;
                };
                let again = Root {
                    shape: x,
                    left: root.left.is_some().then_some(y),
                    ..root.clone()
                };
                let mut again = moved(system, structure, again, reach(i));
                rated(std::slice::from_mut(&mut again));
                let near = (again.value - found[i].value).norm() <= reach(i);
                if near && error(&again) < error(root) {
                    *root = again;
                }
            }
            if error(root) <= UNITS || error(root) > 0.9 * last {
                break;
            }
        }
    }
    let vague = covered(&roots);
    for ((root, &i), vague) in roots.iter_mut().zip(chosen).zip(vague) {
        if vague {
            root.error = Some((f64::INFINITY, f64::INFINITY));
        }
        let doubtful = system.len() <= FEW && (vague || doubt(root) > DOUBTFUL);
        if doubtful && let Some(mut better) = resolved(system, root, reach(i)) {
            rated(std::slice::from_mut(&mut better));
            *root = better;
        }
    }
    apart(&mut roots, before);
    roots
}

/// Which roots others may be as well, as far as doubles tell: there the shapes, and so κ and η, can
/// be those of neither.
fn covered(roots: &[Root]) -> Vec<bool> {
    let reach = |root: &Root| {
        let error = root.quality.map_or(f64::INFINITY, |q| q.first_order());
        (error > SMALL).then_some((root.value, 2.0 * error * root.value.norm()))
    };
    let vague: Vec<(Complex<f64>, f64)> = roots.iter().filter_map(reach).collect();
    let within = |root: &Root| {
        let mut vague = vague.iter();
        vague.any(|(value, reach)| (root.value - value).norm() <= *reach)
    };
    roots.iter().map(within).collect()
}

/// Takes back what moved a root onto another one.
fn apart(roots: &mut [Root], before: Vec<Root>) {
    const COLLINEAR: f64 = 1.0 - 1e-6;
    let shift = |i: usize, roots: &[Root]| (roots[i].value - before[i].value).norm();
    let meets = |i: usize, roots: &[Root]| {
        (0..roots.len()).any(|j| {
            let square = |roots: &[Root]| (roots[i].value - roots[j].value).norm_sqr();
            j != i
                && square(roots) < 1e-4 * square(&before)
                && shift(j, roots) <= shift(i, roots)
                && collinearity(&roots[i], &roots[j]) > COLLINEAR
        })
    };
    for i in 0..roots.len() {
        if shift(i, roots) > 0.0 && meets(i, roots) {
            roots[i] = before[i].clone();
        }
    }
}

/// The root of the Rayleigh functional of the given root's shapes. Those of a lightly damped mode
/// are turned to be nearly real: rounding then is small against the imaginary parts, and so against
/// Re λ.
fn moved(system: &System, structure: &Structure, mut root: Root, radius: f64) -> Root {
    if root.left.is_none() {
        let sum: Complex<f64> = root.shape.iter().map(|x| x * x).sum();
        let turn = (sum.conj() / sum.norm()).sqrt();
        if turn.is_finite() {
            root.shape.iter_mut().for_each(|x| *x *= turn);
        }
    }
    let left = root.left();
    let better = if system.len() <= FEW {
        Forms::<DoubleDouble>::of(system, &left, &root.shape).root(root.value)
    } else {
        Forms::<f64>::of(system, &left, &root.shape).root(root.value)
    };
    let mut value = root.value;
    // Across the real axis lies the conjugate, which is another root.
    let same_side = |better: Complex<f64>| root.value.im == 0.0 || better.im * root.value.im > 0.0;
    if let Some(better) = better
        && same_side(better)
        && (better - root.value).norm() <= radius.max(1e-12 * root.value.norm())
    {
        value = better;
    }
    if root.value.im == 0.0 {
        value.im = 0.0;
    }
    // What does not grow lies on the other side: nearer to where these are.
    if structure.is_passive() && value.re > 0.0 {
        value.re = if value.im == 0.0 { -value.re } else { 0.0 };
    }
    Root { value, ..root }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::GROUND;

    #[test]
    fn nearly_repeated_roots_keep_their_shapes() {
        // Two ends alike, with modes of their own 60 masses apart: pairs of roots 1e-14 apart.
        let n = 120;
        let name = |i: usize| format!("m{i}");
        let masses = (0..n).fold(System::builder(), |builder, i| {
            builder.mass(name(i), 1.0 + 0.25 * (i % 4) as f64)
        });
        let joined = (0..=n).fold(masses, |builder, i| {
            let from = if i == 0 {
                GROUND.to_owned()
            } else {
                name(i - 1)
            };
            let to = if i == n { GROUND.to_owned() } else { name(i) };
            builder
                .spring(from.clone(), to.clone(), 1.0 + 0.5 * (i % 3) as f64)
                .damper(from, to, 0.02 * (1 + i % 5) as f64)
        });
        let system = joined.build().unwrap();
        let modes = StateMatrix.solve(&system, system.structure()).unwrap();
        assert_eq!(modes.eigenvalues().len(), 2 * n);
        for mode in &modes {
            assert!(mode.backward_error() <= 8.0 * f64::EPSILON);
        }
    }

    /// One vector for a root that is there twice, and its own for another.
    #[test]
    fn a_jordan_block_has_its_one_vector() {
        let a = faer::mat![[-1.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -3.0]];
        for (value, own) in [(-1.0, 0), (-3.0, 2)] {
            let vector = by_inverse_iteration(a.as_ref(), Complex::from(value));
            assert_eq!(vector.len(), 3);
            for (i, entry) in vector.iter().enumerate() {
                let share = entry.norm() / vector[own].norm();
                assert!(i == own || share < 1e-6, "{value}: {share:e}");
            }
        }
    }

    #[test]
    fn what_is_0_or_not_finite_points_nowhere() {
        let points = |parts: [f64; 2]| is_direction(&parts.map(Complex::from));
        assert!(points([0.0, -1e-300]));
        for nowhere in [0.0, f64::NAN, f64::INFINITY] {
            assert!(!points([0.0, nowhere]));
        }
    }
}
