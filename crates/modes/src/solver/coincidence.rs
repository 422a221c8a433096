//! Which roots coincide, decided exactly where their bounds leave it open.
//!
//! Discs, of which each holds one root at least, are as many as there are different roots: then each holds one
//! root alone, as often as it holds roots. How many different roots there are is counted in exact arithmetic.

use faer::Mat;
use num_complex::Complex;

use crate::model::MatrixKind;
use crate::modes::{Bounds, Eigenvalue, Mode, Modes, Repeats, listed, sort};
use crate::structure::DistinctRoots;
use crate::system::System;

use super::cluster;
use super::rigid::null_vectors;
use super::roots::{normalised, together};

/// Multiplications that a proof may take: below a second beside certified bounds, a few milliseconds beside doubles.
fn most_work(bounds: Bounds) -> u64 {
    match bounds {
        Bounds::Proven => 200_000_000,
        Bounds::Estimated => 1_000_000,
    }
}

/// Decides which clusters of one part are one root.
pub(crate) fn settle(system: &System, modes: &mut Modes) {
    let groups = clusters(&modes.modes);
    if groups.is_empty() {
        return;
    }
    let Some(count) = places(&modes.modes, &groups) else {
        return;
    };
    let proved = |roots: DistinctRoots<'_>| roots.are_at_most(count, most_work(modes.bounds));
    if !DistinctRoots::of(&[system.structure()]).is_some_and(proved) {
        return;
    }
    let mut each: Vec<Option<Mode>> = modes.modes.drain(..).map(Some).collect();
    for group in groups {
        let mut members: Vec<Mode> = group.iter().filter_map(|i| each[*i].take()).collect();
        unite(system, &mut members, modes.bounds);
        modes.modes.extend(members);
    }
    modes.modes.extend(each.into_iter().flatten());
    sort(&mut modes.modes);
    modes.eigenvalues = listed(&modes.modes);
}

/// The modes of each cluster whose roots all have bounds.
fn clusters(modes: &[Mode]) -> Vec<Vec<usize>> {
    let is_open =
        |mode: &Mode| matches!(mode.cluster(), Some(k) if k > 1) && !mode.eigenvalue.is_doubtful();
    let open: Vec<usize> = (0..modes.len()).filter(|i| is_open(&modes[*i])).collect();
    let root = |i: &usize| modes[*i].eigenvalue;
    let values: Vec<Complex<f64>> = open.iter().map(|i| root(i).value).collect();
    let reaches: Vec<f64> = open.iter().filter_map(|i| root(i).bound).collect();
    let groups = cluster::groups(&values, &reaches).into_iter();
    groups
        .map(|group| group.into_iter().map(|at| open[at]).collect())
        .collect()
}

/// How many places other than 0 hold roots, conjugates included; `None` where a root has no bound.
fn places(modes: &[Mode], groups: &[Vec<usize>]) -> Option<usize> {
    let mut alone = vec![true; modes.len()];
    groups.iter().flatten().for_each(|i| alone[*i] = false);
    let meets_axis = |mode: &Mode| {
        mode.eigenvalue
            .bound
            .is_none_or(|bound| mode.eigenvalue.value.im <= bound)
    };
    let mut count = 0;
    for (mode, _) in modes.iter().zip(alone).filter(|(_, alone)| *alone) {
        if mode.eigenvalue.value.norm() > 0.0 {
            mode.multiplicity()?;
            count += if meets_axis(mode) { 1 } else { 2 };
        }
    }
    for group in groups {
        let on_axis = group.iter().any(|i| meets_axis(&modes[*i]));
        count += if on_axis { 1 } else { 2 };
    }
    Some(count)
}

/// Makes the modes of a cluster those of one root.
fn unite(system: &System, members: &mut Vec<Mode>, bounds: Bounds) {
    let all: Vec<usize> = (0..members.len()).collect();
    let count = match together(members, &all) {
        Repeats::Cluster(count) | Repeats::AtLeast(count) | Repeats::Exactly { count, .. } => count,
    };
    let on_axis = members
        .iter()
        .any(|mode| mode.eigenvalue.value.im <= mode.eigenvalue.bound.unwrap_or(0.0));
    // It lies in the disc of each of them.
    let bound = |mode: &Mode| mode.eigenvalue.bound.unwrap_or(f64::INFINITY);
    let nearest = members.iter().min_by(|a, b| bound(a).total_cmp(&bound(b)));
    let mut root = nearest.expect("a cluster has a member").eigenvalue;
    if bounds == Bounds::Estimated {
        // Of estimates the least is no better than the others.
        let reach = |of: fn(&Eigenvalue) -> Option<f64>| {
            let each = members.iter().map(|mode| {
                let apart = (mode.eigenvalue.value - root.value).norm();
                of(&mode.eigenvalue).map_or(f64::INFINITY, |bound| bound + apart)
            });
            Some(each.fold(0.0, f64::max))
        };
        (root.bound, root.real_bound) = (reach(|root| root.bound), reach(|root| root.real_bound));
    }
    if on_axis {
        root.value.im = 0.0;
    }
    let defective = is_defective(system, members, (root.value, count));
    if defective == Some(true) {
        members.truncate(1);
    } else if defective == Some(false)
        && members.len() < count
        && on_axis
        && let Some(found) = null_vectors(at(system, root.value.re).as_ref(), count)
    {
        let first = members[0].clone();
        let each = found.into_iter().map(|shape| Mode {
            shape: normalised(&shape),
            left_shape: None,
            ..first.clone()
        });
        *members = each.collect();
    }
    let entries = members.len();
    for mode in members {
        mode.roots = match entries {
            1 => count,
            entries if entries == count => 1,
            _ if on_axis && mode.eigenvalue.value.im != 0.0 => 2 * mode.roots,
            _ => mode.roots,
        };
        mode.eigenvalue = root;
        mode.repeats = Repeats::Exactly { count, defective };
    }
}

/// Whether the root of this value and multiplicity has fewer shapes, where that is known.
fn is_defective(
    system: &System,
    members: &[Mode],
    (value, count): (Complex<f64>, usize),
) -> Option<bool> {
    let structure = system.structure();
    // Where Q(λ) is proved to have rank n − 1 on the whole disc, its one shape is bounded.
    let has_one_shape = |mode: &Mode| mode.roots > 1 && mode.shape_bound.is_some();
    if system.len() == 1 || members.iter().any(has_one_shape) {
        return Some(count > 1);
    }
    if structure.is_semisimple() {
        return Some(false);
    }
    let shapes = (value.im == 0.0).then(|| structure.shapes_at(value.re))?;
    shapes
        .filter(|shapes| *shapes > 0)
        .map(|shapes| shapes < count)
}

/// λ²M + λC + K for a real λ.
fn at(system: &System, value: f64) -> Mat<f64> {
    let scaled = |matrix: Mat<f64>, factor| matrix * faer::Scale(factor);
    scaled(system.mass_matrix(), value * value)
        + scaled(system.damping_matrix(), value)
        + system.stiffness_matrix()
}

/// Decides which roots of different parts coincide, where they may: the modes stand one part after the other, and each
/// part ends where `ends` says.
pub(crate) fn settle_between(parts: &[System], modes: &mut [Mode], ends: &[usize], bounds: Bounds) {
    let part = |mode: usize| ends.partition_point(|end| *end <= mode);
    let is_moving = |mode: &Mode| mode.eigenvalue.value.norm() > 0.0;
    // Entries of one root of a part.
    let same = |i: usize, j: usize| {
        let (a, b) = (&modes[i], &modes[j]);
        part(i) == part(j) && a.repeats != Repeats::SIMPLE && a.eigenvalue == b.eigenvalue
    };
    let label = cluster::labels(modes.len(), |i, j| {
        let (a, b) = (&modes[i], &modes[j]);
        let meets = part(i) != part(j) && is_moving(a) && is_moving(b) && touch(a, b);
        meets || same(i, j)
    });
    let mut first = vec![None; parts.len()];
    let mut decided = Vec::new();
    for at in (0..modes.len()).filter(|at| label[*at] == *at) {
        let members: Vec<usize> = (at..modes.len()).filter(|i| label[*i] == at).collect();
        if members.iter().all(|i| part(*i) == part(at)) {
            continue;
        }
        // The first part that is like that of a mode, and the mode's twin there.
        let mut twin = |i: usize| {
            let p = part(i);
            let like = *first[p]
                .get_or_insert_with(|| (0..p).find(|q| alike(&parts[*q], &parts[p])).unwrap_or(p));
            let start = |part: usize| part.checked_sub(1).map_or(0, |before| ends[before]);
            start(like) + i - start(p)
        };
        let twins: Vec<usize> = members.iter().map(|i| twin(*i)).collect();
        let is_one = twins.iter().all(|i| *i == twins[0] || same(*i, twins[0]));
        let mut involved: Vec<usize> = twins.iter().map(|i| part(*i)).collect();
        involved.sort_unstable();
        involved.dedup();
        let all: Vec<usize> = (0..modes.len())
            .filter(|i| involved.contains(&part(*i)) && is_moving(&modes[*i]))
            .collect();
        let are_known = || {
            all.iter()
                .chain(&members)
                .all(|i| modes[*i].multiplicity().is_some())
        };
        let structures = || {
            involved
                .iter()
                .map(|p| parts[*p].structure())
                .collect::<Vec<_>>()
        };
        let roots = (!is_one && are_known()).then(|| DistinctRoots::of(&structures()));
        let count = |same: &dyn Fn(usize, usize) -> bool| -> usize {
            let is_new = |k: &usize| !all[..*k].iter().any(|j| same(*j, all[*k]));
            let each = (0..all.len()).filter(is_new).map(|k| &modes[all[k]]);
            each.map(|mode| {
                if mode.eigenvalue.value.im == 0.0 {
                    1
                } else {
                    2
                }
            })
            .sum()
        };
        let fewest = || count(&|i, j| label[i] == label[j]);
        if is_one && members.iter().all(|i| modes[*i].multiplicity().is_some()) {
            decided.push((members, true));
            continue;
        }
        match roots.flatten() {
            // Only those of parts that are alike coincide.
            Some(roots) if roots.are_at_least(count(&same)) => {
                for (k, twin) in twins.iter().enumerate() {
                    let like = |j: &usize| *j == *twin || same(*j, *twin);
                    if !twins[..k].iter().any(like) {
                        let alike = members.iter().zip(&twins).filter(|(_, j)| like(j));
                        decided.push((alike.map(|(i, _)| *i).collect(), true));
                    }
                }
            }
            Some(roots) if roots.are_at_most(fewest(), most_work(bounds)) => {
                decided.push((members, true))
            }
            _ => decided.push((members, false)),
        }
    }
    for (members, coincide) in decided {
        let each = || members.iter().map(|i| modes[*i].is_defective());
        let repeats = match together(modes, &members) {
            Repeats::Cluster(count) if coincide => Repeats::Exactly {
                count,
                defective: match each().any(|defective| defective == Some(true)) {
                    true => Some(true),
                    false => each()
                        .all(|defective| defective == Some(false))
                        .then_some(false),
                },
            },
            repeats => repeats,
        };
        members.iter().for_each(|i| modes[*i].repeats = repeats);
    }
}

/// Whether two roots may coincide.
pub(crate) fn touch(a: &Mode, b: &Mode) -> bool {
    let (a, b) = (a.eigenvalue, b.eigenvalue);
    let (Some(bound), Some(reach)) = (a.bound, b.bound) else {
        return true;
    };
    (a.value - b.value).norm() <= (bound + reach) * (1.0 + 8.0 * f64::EPSILON)
}

/// Whether two systems differ by names alone.
fn alike(a: &System, b: &System) -> bool {
    let mut kinds = [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness].into_iter();
    a.masses() == b.masses()
        && a.springs() == b.springs()
        && a.dampers() == b.dampers()
        && kinds.all(|kind| {
            let tails = [a, b].map(|system| system.model().tails(kind));
            a.added(kind) == b.added(kind) && tails[0] == tails[1]
        })
}
