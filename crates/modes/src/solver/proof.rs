//! What proves roots, and the better of two proofs for each root.
//!
//! The discs of a proof hold all nonzero roots, so each root lies in a disc of either proof, and these two touch. Discs of both
//! that touch, directly or through others, therefore hold the same roots whichever proof they are taken from, and the proofs of
//! different groups can be chosen apart from each other. Where a group is one disc of one root in either, the root
//! lies in both.

use crate::inclusion::LIMIT;
use crate::inclusion::shape::Enclosed;
use crate::modes::Repeats;

use super::cluster;
use super::roots::Root;

/// A little more than rounding takes.
const UPWARD: f64 = 1.0 + 1e-9;

/// Roots with proven bounds, without those at 0, and what proves them.
pub(super) struct Proof {
    pub(super) roots: Vec<Root>,
    pub(super) claim: String,
    /// Whether an elimination at every root may bound components of shapes that are bounded already better.
    pub(super) shapes_may_gain: bool,
}

impl Proof {
    /// Whether every bound is within `tolerance` of |λ|, and that of its real part of |Re λ|.
    pub(super) fn is_within(&self, tolerance: f64) -> bool {
        self.roots.iter().all(|root| width(root) <= tolerance)
    }

    /// The better of both for each root, or for each group of roots that their discs do not separate.
    pub(super) fn merged(self, other: Proof, tolerance: f64) -> Proof {
        let first = self.roots.len();
        let mut roots: Vec<Option<Root>> = self
            .roots
            .into_iter()
            .chain(other.roots)
            .map(Some)
            .collect();
        let each = || roots.iter().flatten();
        let values: Vec<_> = each().map(|root| root.value).collect();
        let radii: Vec<f64> = each().map(|root| bounds(root).0 * UPWARD).collect();
        let mut best = Vec::with_capacity(first);
        let mut taken = [false; 2];
        for group in cluster::groups(&values, &radii) {
            let (ours, theirs): (Vec<usize>, Vec<usize>) =
                group.into_iter().partition(|i| *i < first);
            let mut take = |members: Vec<usize>| -> Vec<Root> {
                members
                    .into_iter()
                    .filter_map(|i| roots[i].take())
                    .collect()
            };
            let (mut ours, mut theirs) = (take(ours), take(theirs));
            if let ([a], [b]) = (ours.as_slice(), theirs.as_slice())
                && [a, b].map(|root| root.repeats) == [Some(Repeats::SIMPLE); 2]
                && (a.value.im == 0.0) == (b.value.im == 0.0)
            {
                best.push(intersection(ours.remove(0), theirs.remove(0)));
                taken = [true; 2];
                continue;
            }
            let better = rank(&theirs, tolerance) < rank(&ours, tolerance) && !theirs.is_empty();
            taken[usize::from(better)] = true;
            best.extend(if better { theirs } else { ours });
        }
        let claims = [self.claim, other.claim].into_iter().zip(taken);
        let claims: Vec<String> = claims
            .filter_map(|(claim, taken)| taken.then_some(claim))
            .collect();
        Proof {
            roots: best,
            claim: claims.join("; and "),
            shapes_may_gain: self.shapes_may_gain || other.shapes_may_gain,
        }
    }
}

/// The bounds of a root and of its real part.
fn bounds(root: &Root) -> (f64, f64) {
    root.error.unwrap_or((f64::INFINITY, f64::INFINITY))
}

/// The larger of the relative bounds of a root and of its real part, but for a real part that may stay hidden.
pub(super) fn width(root: &Root) -> f64 {
    let (bound, real_bound) = bounds(root);
    let relative = |bound: f64, size: f64| if bound == 0.0 { 0.0 } else { bound / size };
    let whole = relative(bound, root.value.norm());
    let real = relative(real_bound, root.value.re.abs());
    if real_bound <= LIMIT * root.value.norm() {
        whole
    } else {
        whole.max(real)
    }
}

/// The largest relative bound of a component of its shape, or infinity where there are none.
pub(super) fn looseness(root: &Root) -> f64 {
    let Some(bounds) = root.shape_bound.clone() else {
        return f64::INFINITY;
    };
    let shape = root.shape.clone();
    Enclosed { shape, bounds }.looseness()
}

/// How many roots of a group are wider than the tolerance, how many stand in clusters, and how wide the widest is.
fn rank(group: &[Root], tolerance: f64) -> (usize, usize, f64) {
    let count = |is: &dyn Fn(&Root) -> bool| -> usize {
        let those = group.iter().filter(|root| is(root));
        those.map(|root| root.count).sum()
    };
    (
        count(&|root| width(root) > tolerance),
        count(&|root| root.repeats != Some(Repeats::SIMPLE)),
        group.iter().map(width).fold(0.0, f64::max),
    )
}

/// One root from two discs that hold it alone, with the shape that is bounded more closely.
fn intersection(a: Root, b: Root) -> Root {
    let shape_is_firsts = looseness(&a) <= looseness(&b);
    let (near, far) = if bounds(&a).0 <= bounds(&b).0 {
        (&a, &b)
    } else {
        (&b, &a)
    };
    let ((bound, real_bound), (far_bound, far_real_bound)) = (bounds(near), bounds(far));
    let (mut value, mut error) = (near.value, (bound, real_bound));
    if far_real_bound < real_bound {
        let moved = (near.value.re - far.value.re).abs();
        let bound = if moved == 0.0 {
            bound
        } else {
            (bound + moved) * UPWARD
        };
        if bound <= far_bound {
            value.re = far.value.re;
            error = (bound, far_real_bound);
        } else if width(far) < width(near) {
            (value, error) = (far.value, (far_bound, far_real_bound));
        }
    }
    Root {
        value,
        error: Some(error),
        quality: None,
        ..if shape_is_firsts { a } else { b }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_digits::sort_by_number;
    use num_complex::Complex;

    fn root(value: [f64; 2], error: (f64, f64), repeats: Repeats) -> Root {
        Root {
            error: Some(error),
            repeats: Some(repeats),
            ..Root::simple(Complex::new(value[0], value[1]), vec![Complex::ONE])
        }
    }

    fn proof(claim: &str, roots: Vec<Root>) -> Proof {
        Proof {
            roots,
            claim: claim.to_owned(),
            shapes_may_gain: false,
        }
    }

    /// −1 ± i in both: one knows |λ| better, the other Re λ. Of 3 and 3.1 one separates the two; −5 the other knows better.
    #[test]
    fn the_better_of_both_is_taken_root_by_root() {
        let (single, double) = (Repeats::SIMPLE, Repeats::Cluster(2));
        let first = vec![
            root([-1.0, 1.0], (1e-10, 1e-10), single),
            root([-3.05, 0.0], (0.06, 0.06), double),
            root([-3.05, 0.0], (0.06, 0.06), double),
            root([-5.0, 0.0], (1e-12, 1e-12), single),
        ];
        let second = vec![
            root([-1.0 + 2f64.powi(-40), 1.0 + 1e-8], (1e-7, 1e-12), single),
            root([-3.0, 0.0], (1e-3, 1e-3), single),
            root([-3.1, 0.0], (1e-3, 1e-3), single),
            root([-5.01, 0.0], (0.02, 0.02), single),
        ];
        for turn in [false, true] {
            let (a, b) = (proof("a", first.clone()), proof("b", second.clone()));
            let merged = if turn {
                b.merged(a, 1e-16)
            } else {
                a.merged(b, 1e-16)
            };
            let mut found = merged.roots;
            sort_by_number(&mut found, |root| -root.value.re);
            let values: Vec<_> = found
                .iter()
                .map(|root| (root.value.re, root.value.im))
                .collect();
            assert_eq!(
                values,
                [
                    (-1.0 + 2f64.powi(-40), 1.0),
                    (-3.0, 0.0),
                    (-3.1, 0.0),
                    (-5.0, 0.0)
                ]
            );
            let (bound, real_bound) = found[0].error.expect("it is bounded");
            assert!(real_bound == 1e-12 && bound >= 1e-10 + 2f64.powi(-40) && bound <= 1.02e-10);
            assert_eq!(found[3].error, Some((1e-12, 1e-12)));
            assert!(merged.claim.contains('a') && merged.claim.contains('b'));
        }
    }

    /// Roots within the tolerance in one disc are better than the same separated but wide.
    #[test]
    fn what_is_within_the_tolerance_comes_first() {
        let close = root([-1.0, 0.0], (1e-13, 1e-13), Repeats::Cluster(2));
        let wide = |re: f64| root([re, 0.0], (1e-9, 1e-9), Repeats::SIMPLE);
        let both = |tolerance: f64| {
            let close = proof("close", vec![close.clone(), close.clone()]);
            let wide = proof("wide", vec![wide(-1.0 - 1e-9), wide(-1.0 + 1e-9)]);
            close.merged(wide, tolerance).claim
        };
        assert_eq!(both(1e-12), "close");
        assert_eq!(both(1e-8), "wide");
    }
}
