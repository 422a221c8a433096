//! Roots that doubles found, improved: by the Rayleigh functionals of their shapes, by better shapes, and where they
//! belong to one defective root by their mean.

use eigentone_digits::{DoubleDouble, sort_by_number};
use num_complex::Complex;

use crate::model::MatrixKind;
use crate::quality::pencil::{Approximate, Pencil, norm};
use crate::quality::rayleigh::Forms;
use crate::structure::Structure;
use crate::system::System;

use super::cluster;
use super::newton::{FEW, resolved};
use super::roots::{Root, SMALL, moved_by};

/// So many operations may go into better shapes, all roots together. A root that they do not reach keeps the
/// estimate that its own shape gives.
const MOST_WORK: f64 = 3e10;

type Search = fn(&Pencil, &Approximate<'_>) -> Option<[Vec<Complex<f64>>; 2]>;

/// Ways to a better shape, and how many operations each takes, in n³.
const SEARCHES: [(Search, f64); 2] = [
    (Pencil::inverse_iteration, 3.0),
    (Pencil::null_vectors, 90.0),
];

/// Improves simple roots by their Rayleigh functional and replaces groups that belong to one
/// defective root by their mean; keeps the half with Im ≥ 0.
pub(crate) fn refine(system: &System, mut found: Vec<Root>) -> Vec<Root> {
    let pencil = Pencil::of(system);
    let states = found.len() as f64;
    let firsts = first_order(&pencil, &found, states);
    let values: Vec<Complex<f64>> = found.iter().map(|root| root.value).collect();
    let radius = |(first, value): (&f64, &Complex<f64>)| match first.is_finite() {
        true => first.min(1e-2 * value.norm()),
        false => value.norm(),
    };
    let radii: Vec<f64> = firsts.iter().zip(&values).map(radius).collect();
    let mut roots = Vec::new();
    let groups = if cluster::are_apart(&values, &radii) {
        Vec::new()
    } else {
        cluster::groups(&values, &radii)
    };
    // Those that stand by themselves.
    let mut alone: Vec<usize> = if groups.is_empty() {
        (0..values.len()).filter(|i| values[*i].im >= 0.0).collect()
    } else {
        Vec::new()
    };
    // How far from each of these the others reach that it may be as well.
    let mut crowd = vec![0.0; values.len()];
    for group in groups {
        let count = group.len();
        let first = group[0];
        let parallel = group
            .iter()
            .all(|i| collinearity(&found[*i], &found[first]) > 1.0 - 1e-6);
        if count == 1 || !parallel {
            for &i in group.iter().filter(|_| count > 1) {
                let reach = |j: &usize| (values[*j] - values[i]).norm() + radii[*j];
                crowd[i] = group.iter().map(reach).fold(0.0, f64::max);
            }
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
            .fold(reach_of_all(&values, &firsts, &group, mean), f64::max);
        let mut root = Root {
            value: mean,
            count,
            error: Some((spread, spread)),
            ..found[first].clone()
        };
        if let Some([x, y]) = pencil.null_vectors(&root.approximate()) {
            root.shape = x;
            root.left = root.left.map(|_| y);
        }
        roots.push(root);
    }
    let reaches: Vec<f64> = alone.iter().map(|i| radii[*i]).collect();
    let taken = alone.iter().map(|i| found[*i].take());
    let mut better = improved(system, &pencil, taken.collect(), &values, &reaches);
    // Of few coordinates discs tell more.
    for (root, i) in better.iter_mut().zip(alone) {
        if system.len() > FEW && crowd[i] > 0.0 {
            let reach = crowd[i] + (root.value - values[i]).norm();
            let (whole, real) = root.error.unwrap_or((0.0, 0.0));
            root.error = Some((whole.max(reach), real.max(reach)));
        }
    }
    roots.extend(better);
    roots
}

/// Improves roots that are known to be simple, given with Im ≥ 0 and how far off each may be.
pub(crate) fn refine_simple(system: &System, found: Vec<Root>, radii: &[f64]) -> Vec<Root> {
    let values: Vec<Complex<f64>> = found.iter().map(|root| root.value).collect();
    improved(system, &Pencil::of(system), found, &values, radii)
}

/// The radius about the mean of a group within which its roots stay when the product of all z − z_j changes by as much as moves
/// one of them by its first-order error: there the product must be larger (Rouché's theorem).
fn reach_of_all(
    values: &[Complex<f64>],
    firsts: &[f64],
    group: &[usize],
    mean: Complex<f64>,
) -> f64 {
    let size = mean.norm();
    if size == 0.0 {
        return 0.0;
    }
    let change = |i: &usize| {
        let others = group.iter().filter(|j| *j != i);
        let gaps = others.map(|j| (values[*j] - values[*i]).norm() / size);
        firsts[*i] / size * gaps.product::<f64>()
    };
    let change = group.iter().map(change).filter(|change| change.is_finite());
    let change = change.fold(0.0, f64::max);
    let distances = group.iter().map(|i| (values[*i] - mean).norm() / size);
    let mut distances: Vec<f64> = distances.collect();
    sort_by_number(&mut distances, |one| *one);
    let farthest = distances.pop().unwrap_or(0.0);
    let others = |beyond: f64| {
        let each = distances.iter();
        each.map(|distance| farthest + beyond - distance).product()
    };
    (farthest + moved_by(change, others, 1.0)) * size
}

/// How far off each root may be to first order, from its backward error and condition; ∞ where it has none.
fn first_order(pencil: &Pencil, found: &[Root], states: f64) -> Vec<f64> {
    let upper: Vec<usize> = (0..found.len())
        .filter(|i| found[*i].value.im >= 0.0)
        .collect();
    let approximate: Vec<Approximate<'_>> = upper.iter().map(|i| found[*i].approximate()).collect();
    let mut firsts = vec![f64::INFINITY; found.len()];
    for (&i, quality) in upper.iter().zip(pencil.qualities(&approximate)) {
        // Where a root is defective this is endless.
        if let Some(condition) = quality.condition {
            let error = 8.0 * states * f64::EPSILON + 2.0 * quality.backward_error;
            firsts[i] = error * condition * found[i].value.norm();
        }
    }
    for i in 0..found.len() {
        if found[i].value.im < 0.0 {
            let conjugate = found[i].value.conj();
            let twin = upper.iter().find(|j| found[**j].value == conjugate);
            firsts[i] = twin.map_or(f64::INFINITY, |j| firsts[*j]);
        }
    }
    firsts
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

/// Roots moved to those of their Rayleigh functionals, where these are near and well defined; where
/// the shape then fails the equations, with the shape that fulfils them best. Given with all roots that were
/// found, and how far off each of its own may be.
fn improved(
    system: &System,
    pencil: &Pencil,
    mut roots: Vec<Root>,
    found: &[Complex<f64>],
    radii: &[f64],
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
    let starts: Vec<Complex<f64>> = roots.iter().map(|root| root.value).collect();
    move_all(system, &mut roots, radii);
    rated(&mut roots);
    let vague = covered(&roots);
    let is_doubtful =
        |root: &Root, vague: bool| system.len() <= FEW && (vague || doubt(root) > DOUBTFUL);
    let is_good = |(root, vague): (&Root, &bool)| {
        !vague && error(root) <= UNITS && !is_doubtful(root, *vague)
    };
    if roots.iter().zip(&vague).all(is_good) {
        return roots;
    }
    let before = roots.clone();
    // A root may have lost most of its digits, but not so many that it passes for another.
    let reach = |i: usize| {
        let start = starts[i];
        let others = found
            .iter()
            .flat_map(|other| [*other, other.conj()])
            .map(|other| (other - start).norm());
        let gap = others.filter(|gap| *gap > 0.0).fold(start.norm(), f64::min);
        radii[i].max(0.5 * gap)
    };
    // The worst first, as far as the work goes.
    let mut order: Vec<usize> = (0..roots.len()).collect();
    sort_by_number(&mut order, |i| -error(&roots[*i]));
    let cube = (system.len() as f64).powi(3);
    let mut work = 0.0;
    for i in order {
        let root = &mut roots[i];
        for _ in 0..ROUNDS {
            let last = error(root);
            for (search, operations) in SEARCHES {
                if error(root) <= UNITS || work + operations * cube > MOST_WORK {
                    break;
                }
                work += operations * cube;
                let Some([x, y]) = search(pencil, &root.approximate()) else {
                    continue;
                };
                let again = Root {
                    shape: x,
                    left: root.left.is_some().then_some(y),
                    ..root.clone()
                };
                let mut again = [again];
                move_all(system, &mut again, &[reach(i)]);
                rated(&mut again);
                let [again] = again;
                let near = (again.value - starts[i]).norm() <= reach(i);
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
    let mut closer = Vec::new();
    for (i, (root, vague)) in roots.iter_mut().zip(vague).enumerate() {
        if vague {
            root.error = Some((f64::INFINITY, f64::INFINITY));
        }
        if is_doubtful(root, vague)
            && let Some(mut better) = resolved(system, root, reach(i))
        {
            rated(std::slice::from_mut(&mut better));
            *root = better;
            closer.push(i);
        }
    }
    let reaches: Vec<f64> = closer.iter().map(|i| hidden(&roots, *i)).collect();
    for (i, reach) in closer.into_iter().zip(reaches) {
        if let Some((whole, real)) = &mut roots[i].error {
            (*whole, *real) = (whole.max(reach), real.max(reach));
        }
    }
    apart(&mut roots, before);
    roots
}

/// How far off a root may be that Newton's method found in double-double, beside others so near that p(z) = Π (z − z_j) is below
/// its rounding there.
fn hidden(roots: &[Root], i: usize) -> f64 {
    const ROUNDING: f64 = 1e-28;
    /// Of the root; what lies farther away shows in its condition alone.
    const CLOSE: f64 = 1e-2;
    let (value, size) = (roots[i].value, roots[i].value.norm());
    let all = roots.iter().enumerate().flat_map(|(j, root)| {
        let own = (j != i).then_some(root.value);
        let conjugate = (root.value.im != 0.0).then(|| root.value.conj());
        own.into_iter().chain(conjugate)
    });
    let gaps: Vec<f64> = all.map(|z| (z - value).norm() / size).collect();
    let others = |reach: f64| {
        let each = gaps.iter().filter(|gap| **gap < CLOSE);
        each.map(|gap| (reach - gap).abs() / CLOSE).product()
    };
    let reach = moved_by(ROUNDING, others, 1.0);
    if reach > ROUNDING { reach * size } else { 0.0 }
}

/// Which roots others may be as well, as far as doubles show: there the shapes, and so κ and η, can
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

/// Moves roots to those of the Rayleigh functionals of their shapes. Those of a lightly damped mode are turned to be
/// nearly real: rounding then is small against the imaginary parts, and so against Re λ.
fn move_all(system: &System, roots: &mut [Root], radii: &[f64]) {
    for root in roots.iter_mut().filter(|root| root.left.is_none()) {
        let sum: Complex<f64> = root.shape.iter().map(|x| x * x).sum();
        let turn = (sum.conj() / sum.norm()).sqrt();
        if turn.is_finite() {
            root.shape.iter_mut().for_each(|x| *x *= turn);
        }
    }
    let kinds = [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness];
    let elements_alone = kinds.iter().all(|kind| system.added(*kind).is_none());
    let shapes: Vec<&[Complex<f64>]> = roots.iter().map(|root| root.shape.as_slice()).collect();
    let near: Vec<Option<Complex<f64>>> = if elements_alone {
        let forms = Forms::of_elements(system, &shapes);
        let each = forms.iter().zip(roots.iter());
        each.map(|(forms, root)| forms.root(root.value)).collect()
    } else if system.len() <= FEW {
        let near = |root: &Root| {
            Forms::<DoubleDouble>::of(system, &root.left(), &root.shape).root(root.value)
        };
        roots.iter().map(near).collect()
    } else {
        let left: Vec<Vec<Complex<f64>>> = roots.iter().map(Root::left).collect();
        let forms = Forms::of_many(system, &left, &shapes);
        let each = forms.iter().zip(roots.iter());
        each.map(|(forms, root)| forms.root(root.value)).collect()
    };
    for ((root, near), radius) in roots.iter_mut().zip(near).zip(radii) {
        root.value = admitted(system.structure(), root.value, near, *radius);
    }
}

/// The root that was found near a value, where it can be the same one; else the value.
fn admitted(
    structure: &Structure,
    value: Complex<f64>,
    near: Option<Complex<f64>>,
    radius: f64,
) -> Complex<f64> {
    // Across the real axis lies the conjugate, which is another root.
    let same_side = |near: &Complex<f64>| value.im == 0.0 || near.im * value.im > 0.0;
    let is_near = |near: &Complex<f64>| (near - value).norm() <= radius.max(1e-12 * value.norm());
    let near = near.filter(|near| same_side(near) && is_near(near));
    let mut better = near.unwrap_or(value);
    if value.im == 0.0 {
        better.im = 0.0;
    }
    // What does not grow lies on the other side: nearer to where these are.
    if structure.is_passive() && better.re > 0.0 {
        better.re = if better.im == 0.0 { -better.re } else { 0.0 };
    }
    better
}
