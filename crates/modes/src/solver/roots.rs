//! From roots and raw shapes to ordered modes with their quality.

use num_complex::Complex;

use crate::inclusion::shape::Shapes;
use crate::modes::ModePlan;
use crate::modes::{Bounds, Eigenvalue, Mode, Modes, Repeats, listed, sort};
use crate::quality::pencil::{Approximate, Pencil, Quality};
use crate::system::System;

use super::cluster;
use super::mode_solver::ModeSolver;

/// A root with Im λ ≥ 0 as a solver finds it; its conjugate is understood.
#[derive(Clone, Debug)]
pub(crate) struct Root {
    pub(crate) value: Complex<f64>,
    /// x, of any length and phase.
    pub(crate) shape: Vec<Complex<f64>>,
    /// y, or `None` where M, C, K are symmetric and y is the conjugate of x.
    pub(crate) left: Option<Vec<Complex<f64>>>,
    /// How many roots this entry stands for: one, or several that have a shape in common.
    pub(crate) count: usize,
    /// Whether it is distinguished from all others, where that is proved; else the estimates decide.
    pub(crate) repeats: Option<Repeats>,
    /// Estimated |λ̂ − λ|, and that of the real part, where the solver knows; else the condition
    /// gives it.
    pub(crate) error: Option<(f64, f64)>,
    /// Where it was computed already.
    pub(crate) quality: Option<Quality>,
    /// How far each component of x may be off, where that is proved: x has its largest component 1 then.
    pub(crate) shape_bound: Option<Vec<f64>>,
    /// The same of y where it is given.
    pub(crate) left_bound: Option<Vec<f64>>,
}

impl Root {
    /// A simple root of symmetric M, C, K.
    pub(crate) fn simple(value: Complex<f64>, shape: Vec<Complex<f64>>) -> Root {
        Root {
            value,
            shape,
            left: None,
            count: 1,
            repeats: None,
            error: None,
            quality: None,
            shape_bound: None,
            left_bound: None,
        }
    }

    /// The root, leaving one without a shape in its place.
    pub(crate) fn take(&mut self) -> Root {
        std::mem::replace(self, Root::simple(Complex::ZERO, Vec::new()))
    }

    /// Gives it shapes with bounds.
    pub(crate) fn enclose(&mut self, shapes: Shapes) {
        self.shape = shapes.right.shape;
        self.shape_bound = Some(shapes.right.bounds);
        (self.left, self.left_bound) = shapes.left.map(|y| (y.shape, y.bounds)).unzip();
    }

    /// What its quality is judged by.
    pub(crate) fn approximate(&self) -> Approximate<'_> {
        Approximate {
            value: self.value,
            shape: &self.shape,
            left: self.left.as_deref(),
        }
    }

    /// y, given or by symmetry.
    pub(crate) fn left(&self) -> Vec<Complex<f64>> {
        match &self.left {
            Some(left) => left.clone(),
            None => self.shape.iter().map(|entry| entry.conj()).collect(),
        }
    }
}

/// What bounds in doubles rest on.
pub(crate) const DOUBLES: &str = "estimated from backward error and condition, in doubles";

/// Sorts the roots, normalises the shapes and adds the quality of each. Errors are estimates.
pub(crate) fn collect(solver: &dyn ModeSolver, system: &System, roots: Vec<Root>) -> Modes {
    collected(solver, system, roots, Bounds::Estimated)
}

/// The same of roots whose errors are proven, and stand however large they are.
pub(crate) fn collect_proven(solver: &dyn ModeSolver, system: &System, roots: Vec<Root>) -> Modes {
    collected(solver, system, roots, Bounds::Proven)
}

/// Of a mode that the estimates are still to separate from others.
const UNKNOWN: Repeats = Repeats::Cluster(0);

/// Takes the bounds of all roots but those at 0, which are counted exactly.
pub(crate) fn doubt(modes: &mut Modes) {
    let moving = |mode: &&mut Mode| mode.eigenvalue.value.norm() > 0.0;
    for mode in modes.modes.iter_mut().filter(moving) {
        (mode.eigenvalue.bound, mode.eigenvalue.real_bound) = (None, None);
        mode.repeats = UNKNOWN;
    }
    separate(&mut modes.modes);
    modes.eigenvalues = listed(&modes.modes);
}

/// Puts the modes whose estimated discs touch, directly or through others, into clusters.
fn separate(modes: &mut [Mode]) {
    let open: Vec<usize> = (0..modes.len())
        .filter(|i| modes[*i].repeats == UNKNOWN)
        .collect();
    let root = |i: &usize| modes[*i].eigenvalue;
    let values: Vec<Complex<f64>> = open.iter().map(|i| root(i).value).collect();
    // What is doubtful may be anywhere about there.
    let reach = |i: &usize| root(i).bound.unwrap_or(0.1 * root(i).value.norm());
    let reaches: Vec<f64> = open.iter().map(reach).collect();
    let is_sure = |i: &usize| {
        let (im, bound) = (root(i).value.im, root(i).bound);
        modes[*i].roots == 1 && bound.is_some_and(|bound| im == 0.0 || im > bound)
    };
    if open.iter().all(is_sure) && cluster::are_apart(&values, &reaches) {
        open.iter()
            .for_each(|i| modes[*i].repeats = Repeats::SIMPLE);
        return;
    }
    for group in cluster::groups(&values, &reaches) {
        let members: Vec<usize> = group.iter().map(|at| open[*at]).collect();
        let repeats = together(modes, &members);
        members.iter().for_each(|i| modes[*i].repeats = repeats);
    }
}

/// What is known of modes that are distinguished from all others but not from each other.
pub(crate) fn together(modes: &[Mode], members: &[usize]) -> Repeats {
    let root = |i: &usize| modes[*i].eigenvalue;
    let meets_axis = |i: &usize| root(i).value.im <= root(i).bound.unwrap_or(f64::INFINITY);
    let on_axis = members.iter().any(meets_axis);
    let roots = |i: &usize| {
        let pair = on_axis && root(i).value.im != 0.0;
        if pair {
            2 * modes[*i].roots
        } else {
            modes[*i].roots
        }
    };
    let count = members.iter().map(roots).sum();
    let is_sure = !members.iter().any(|i| root(i).is_doubtful());
    if count == 1 && is_sure {
        Repeats::SIMPLE
    } else {
        Repeats::Cluster(count)
    }
}

fn collected(solver: &dyn ModeSolver, system: &System, roots: Vec<Root>, bounds: Bounds) -> Modes {
    let roots: Vec<Root> = roots.into_iter().map(normalised_root).collect();
    let unknown = roots.iter().filter(|root| root.quality.is_none());
    let unknown: Vec<Approximate<'_>> = unknown.map(Root::approximate).collect();
    let mut computed = if unknown.is_empty() {
        Vec::new()
    } else {
        Pencil::of(system).qualities(&unknown)
    }
    .into_iter();
    let qualities: Vec<Quality> = roots
        .iter()
        .filter_map(|root| root.quality.or_else(|| computed.next()))
        .collect();
    let values: Vec<Complex<f64>> = roots.iter().map(|root| root.value).collect();
    let with_quality = roots.into_iter().zip(qualities).enumerate();
    let mut modes: Vec<Mode> = with_quality
        .map(|(i, (root, quality))| {
            let error = match bounds {
                Bounds::Proven => root.error,
                Bounds::Estimated => root.error.or_else(|| estimate(&root, quality, &values, i)),
            };
            mode(
                system,
                root,
                quality,
                error.filter(|error| bounds == Bounds::Proven || is_small(*error, values[i])),
            )
        })
        .collect();
    sort(&mut modes);
    separate(&mut modes);
    let eigenvalues = listed(&modes);
    let infinite = (2 * system.len()).saturating_sub(eigenvalues.len());
    let plan = ModePlan {
        solver: solver.name(),
        reason: "asked for by name".to_owned(),
        bounds: DOUBLES.to_owned(),
        left_out: Vec::new(),
        incomplete: None,
    };
    Modes {
        modes,
        eigenvalues,
        infinite,
        bounds,
        complete: bounds == Bounds::Proven,
        plan,
    }
}

fn normalised_root(root: Root) -> Root {
    if root.shape_bound.is_some() {
        return root;
    }
    Root {
        shape: normalised(&root.shape),
        left: root.left.as_deref().map(normalised),
        ..root
    }
}

/// Estimated errors, relative, that are small.
pub(crate) const SMALL: f64 = 1e-3;

/// Whether an estimate is so small against the root that it means something; one of the least double there is always
/// does.
fn is_small((error, _): (f64, f64), value: Complex<f64>) -> bool {
    error <= (SMALL * value.norm()).max(f64::from_bits(1))
}

/// How far a root may move where p(z) = (z − z_i) Π (z − z_j) changes by so much: on a circle about it, |p| must be larger than the
/// change (Rouché's theorem). Given the other factors' product at least at a distance from the root, up to an end.
pub(crate) fn moved_by(change: f64, others: impl Fn(f64) -> f64, end: f64) -> f64 {
    const STEP: f64 = 1.125;
    // From 0 it would not grow.
    let mut reach = change.max(f64::MIN_POSITIVE);
    while reach < end {
        if reach * others(reach) >= change {
            break;
        }
        reach *= STEP;
    }
    reach
}

/// Twice the first-order error, which leaves room for the second order where the first is small. Where others lie so
/// near that it is not, the change of p is the one that would move the root so far if it [stood alone](moved_by).
fn estimate(
    root: &Root,
    quality: Quality,
    values: &[Complex<f64>],
    i: usize,
) -> Option<(f64, f64)> {
    // No root so well conditioned has others as near as that beside it.
    const GOOD: f64 = 1e-13;
    if root.count > 1 {
        return None;
    }
    let size = root.value.norm();
    quality.condition.filter(|_| size != 0.0)?;
    let first = 2.0 * quality.first_order() * size;
    if first <= GOOD * size || !is_small((first, first), root.value) {
        return Some((first, first));
    }
    let conjugate = |z: &Complex<f64>| {
        [*z, z.conj()]
            .into_iter()
            .take(if z.im == 0.0 { 1 } else { 2 })
    };
    let own = |(j, k, _): &(usize, usize, Complex<f64>)| (*j, *k) == (i, 0);
    let all = values.iter().enumerate();
    let all = all.flat_map(|(j, z)| conjugate(z).enumerate().map(move |(k, z)| (j, k, z)));
    let gaps: Vec<f64> = all
        .filter(|each| !own(each))
        .map(|(.., z)| (z - root.value).norm())
        .collect();
    let others = |reach: f64| gaps.iter().map(|gap| (1.0 - reach / gap).abs()).product();
    let reach = moved_by(first, others, size);
    Some((reach, reach))
}

fn mode(system: &System, root: Root, quality: Quality, error: Option<(f64, f64)>) -> Mode {
    let Quality {
        backward_error,
        condition,
    } = quality;
    let condition = condition.filter(|_| root.count == 1 && root.value.norm() != 0.0);
    let (left_shape, left_shape_bound) = match root.left {
        None if system.structure().is_symmetric() => (
            Some(root.shape.iter().map(|entry| entry.conj()).collect()),
            root.shape_bound.clone(),
        ),
        left => (left, root.left_bound),
    };
    Mode {
        eigenvalue: Eigenvalue {
            value: root.value,
            bound: error.map(|(whole, _)| whole),
            real_bound: error.map(|(_, real)| real),
        },
        repeats: root.repeats.unwrap_or(UNKNOWN),
        roots: root.count,
        names: system.coordinate_names().clone(),
        shape: root.shape,
        shape_bound: root.shape_bound,
        left_shape,
        left_shape_bound,
        backward_error,
        condition,
    }
}

/// The shape with its largest component made 1 + 0i: the first of those that are within rounding
/// of the largest.
pub(crate) fn normalised(shape: &[Complex<f64>]) -> Vec<Complex<f64>> {
    const TIE: f64 = 1.0 - 1e-12;
    // Squares near the ends of the range of doubles lose digits, or have left it.
    const SAFE: std::ops::Range<f64> = 1e-280..1e280;
    let squares = shape.iter().map(Complex::norm_sqr);
    let square = squares.fold(0.0, |a: f64, b| if b > a { b } else { a });
    if !SAFE.contains(&square) || shape.iter().any(|entry| entry.is_nan()) {
        let parts = shape
            .iter()
            .flat_map(|entry| [entry.re.abs(), entry.im.abs()]);
        let largest = parts.fold(0.0, |a: f64, b| if b > a || b.is_nan() { b } else { a });
        if largest == 0.0 || !largest.is_finite() {
            return shape.to_vec();
        }
        // Both factors are powers of two, and neither leaves the doubles.
        let half = (-0.5 * largest.log2()).round().exp2();
        let scaled: Vec<Complex<f64>> = shape.iter().map(|entry| entry * half * half).collect();
        return normalised(&scaled);
    }
    let pivot = shape
        .iter()
        .position(|entry| entry.norm_sqr() >= TIE * TIE * square);
    let pivot = pivot.expect("the largest is one of them");
    let divisor = shape[pivot];
    let mut result: Vec<Complex<f64>> = if shape.iter().all(|entry| entry.im == 0.0) {
        let real = |entry: &Complex<f64>| Complex::from(entry.re / divisor.re + 0.0);
        shape.iter().map(real).collect()
    } else {
        let quotient = |entry: &Complex<f64>| entry / divisor + Complex::ZERO;
        shape.iter().map(quotient).collect()
    };
    result[pivot] = Complex::ONE;
    result
}

#[cfg(test)]
mod tests {
    use super::super::StateMatrix;
    use super::*;
    use crate::model::GROUND;

    /// Without a change, and beside roots whose distance is not known.
    #[test]
    fn how_far_a_root_moves_is_always_given() {
        assert!(moved_by(0.0, |_| 1.0, 1.0) <= f64::MIN_POSITIVE);
        assert!(moved_by(0.0, |_| f64::NAN, 1.0) >= 1.0);
        assert!(moved_by(1e-6, |_| f64::NAN, 1.0) >= 1.0);
    }

    /// Large errors are no estimates, but they are bounds.
    #[test]
    fn proven_errors_stand_however_large() {
        let system = System::builder().mass("a", 1.0).spring(GROUND, "a", 4.0);
        let system = system.build().expect("a system");
        let known = |error| Root {
            error: Some((error, 0.5 * error)),
            ..Root::simple(Complex::new(0.0, 2.0), vec![Complex::ONE])
        };
        for (error, estimated) in [(1e-4, Some(1e-4)), (0.1, None)] {
            let modes = collect(&StateMatrix, &system, vec![known(error)]);
            assert_eq!(modes.bounds(), Bounds::Estimated);
            assert_eq!(modes.eigenvalues()[0].bound, estimated);
            let modes = collect_proven(&StateMatrix, &system, vec![known(error)]);
            assert_eq!(modes.bounds(), Bounds::Proven);
            assert_eq!(modes.eigenvalues()[1].bound, Some(error));
            assert_eq!(modes.eigenvalues()[1].real_bound, Some(0.5 * error));
        }
    }
}
