//! Parts of a system that nothing joins are solved each by itself.

use num_complex::Complex;

use crate::model::{Element, MatrixKind, Node};
use crate::modes::{Bounds, Mode, ModePlan, Modes, Repeats, order, sort};
use crate::system::System;

use super::coincidence::{settle_between, touch};

const KINDS: [MatrixKind; 3] = [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness];

/// The coordinates in groups that no spring, damper or matrix entry joins, each rising. Damping by modes is that of the whole: which mode
/// has which ratio is a matter of all frequencies.
pub(crate) fn parts(system: &System) -> Vec<Vec<usize>> {
    match system.model().by_modes() {
        Some(_) => vec![(0..system.len()).collect()],
        None => groups(system, &KINDS),
    }
}

/// The same, with the matrices of these kinds only.
pub(crate) fn groups(system: &System, kinds: &[MatrixKind]) -> Vec<Vec<usize>> {
    let n = system.len();
    let elements = system.springs().iter().chain(system.dampers());
    let elements = elements.filter_map(|element| {
        let joins = element.coefficient != 0.0;
        let ends = (element.first.coordinate()?, element.second.coordinate()?);
        joins.then_some(ends)
    });
    let matrices = kinds.iter().filter_map(|kind| system.added(*kind));
    let entries = matrices.flat_map(|matrix| {
        let places = (0..n).flat_map(move |j| (0..n).map(move |i| (i, j)));
        places.filter(move |at| matrix[*at] != 0.0)
    });
    joined_by(n, elements.chain(entries))
}

/// The numbers below n in groups that pairs join, each rising.
pub(crate) fn joined_by(n: usize, pairs: impl Iterator<Item = (usize, usize)>) -> Vec<Vec<usize>> {
    let mut parent: Vec<usize> = (0..n).collect();
    fn root(parent: &mut [usize], mut i: usize) -> usize {
        while parent[i] != i {
            parent[i] = parent[parent[i]];
            i = parent[i];
        }
        i
    }
    let mut apart = n;
    for (i, j) in pairs {
        let (a, b) = (root(&mut parent, i), root(&mut parent, j));
        parent[a.max(b)] = a.min(b);
        apart -= usize::from(a != b);
        if apart == 1 {
            break;
        }
    }
    let mut groups = vec![Vec::new(); n];
    for i in 0..n {
        groups[root(&mut parent, i)].push(i);
    }
    groups.retain(|group| !group.is_empty());
    groups
}

/// The part of the system on the given coordinates.
pub(crate) fn part(system: &System, coordinates: &[usize]) -> System {
    let place = |node: Node| match node {
        Node::Ground => Some(Node::Ground),
        Node::Coordinate(i) => coordinates.binary_search(&i).ok().map(Node::Coordinate),
    };
    let within = |elements: &[Element]| {
        let moved = elements.iter().filter_map(|element| {
            let (first, second) = (place(element.first)?, place(element.second)?);
            Some(Element {
                first,
                second,
                ..*element
            })
        });
        moved.collect()
    };
    System::assemble(
        coordinates
            .iter()
            .map(|i| system.names()[*i].clone())
            .collect(),
        coordinates.iter().map(|i| system.masses()[*i]).collect(),
        within(system.springs()),
        within(system.dampers()),
        KINDS.map(|kind| system.model().added_whole(kind).block(coordinates)),
    )
}

/// The modes of the whole from those of its parts.
pub(crate) fn joined(system: &System, solved: Vec<(Vec<usize>, System, Modes)>) -> Modes {
    let mut modes: Vec<Mode> = Vec::new();
    let mut eigenvalues = Vec::new();
    let (mut infinite, mut proven, mut complete) = (0, true, true);
    let mut some_proven = false;
    // What is said of all is said of the one that is known least, and of the largest of those.
    let mut told: Option<((bool, usize), ModePlan)> = None;
    let mut ends = Vec::new();
    let count = solved.len();
    let mut parts = Vec::with_capacity(count);
    for (coordinates, own, part) in solved {
        parts.push(own);
        infinite += part.infinite;
        let is_proven = part.bounds == Bounds::Proven;
        (proven, some_proven) = (proven && is_proven, some_proven || is_proven);
        complete &= part.complete;
        eigenvalues.extend(part.eigenvalues);
        let spread = |entries: &[Complex<f64>]| {
            let mut shape = vec![Complex::ZERO; system.len()];
            for (&i, entry) in coordinates.iter().zip(entries) {
                shape[i] = *entry;
            }
            shape
        };
        let spread_bound = |bounds: Vec<f64>| {
            let mut bound = vec![0.0; system.len()];
            for (&i, entry) in coordinates.iter().zip(bounds) {
                bound[i] = entry;
            }
            bound
        };
        modes.extend(part.modes.into_iter().map(|mode| Mode {
            names: system.coordinate_names().clone(),
            shape: spread(&mode.shape),
            shape_bound: mode.shape_bound.map(spread_bound),
            left_shape: mode.left_shape.as_deref().map(spread),
            left_shape_bound: mode.left_shape_bound.map(spread_bound),
            ..mode
        }));
        ends.push(modes.len());
        let rank = (!is_proven, coordinates.len());
        if told.as_ref().is_none_or(|(other, _)| rank > *other) {
            told = Some((rank, part.plan));
        }
    }
    let bounds = if proven {
        Bounds::Proven
    } else {
        Bounds::Estimated
    };
    forget_shared(&mut modes, &ends, proven);
    settle_between(&parts, &mut modes, &ends, bounds);
    let (_, mut plan) = told.expect("a system has a coordinate");
    let which = match some_proven && !proven {
        true => "the largest without proof",
        false => "the largest",
    };
    plan.reason = format!(
        "{}; {count} parts that nothing joins are solved apart: this is {which}",
        plan.reason
    );
    // The roots at 0 of several parts are one root: defective if any of them is.
    let (zeros, mut modes): (Vec<Mode>, Vec<Mode>) = modes
        .into_iter()
        .partition(|mode| mode.eigenvalue.value.norm() == 0.0);
    let count: usize = zeros.iter().map(|zero| zero.roots).sum();
    let defective = zeros.iter().any(|zero| zero.is_defective() == Some(true));
    let listed = if defective { 1 } else { zeros.len() };
    modes.extend(zeros.into_iter().take(listed).map(|zero| Mode {
        repeats: Repeats::Exactly {
            count,
            defective: Some(defective),
        },
        roots: if defective { count } else { 1 },
        ..zero
    }));
    sort(&mut modes);
    eigenvalues.sort_by(order);
    Modes {
        modes,
        eigenvalues,
        infinite,
        bounds,
        complete,
        plan,
    }
}

/// Shapes of roots that may be roots of other parts as well are not determined. The modes of each part end where
/// `ends` says.
fn forget_shared(modes: &mut [Mode], ends: &[usize], proven: bool) {
    let part = |mode: usize| ends.partition_point(|end| *end <= mode);
    let others = |i: usize| (0..modes.len()).filter(move |j| part(*j) != part(i));
    let is_shared = |i: usize| others(i).any(|j| touch(&modes[i], &modes[j]));
    let shared: Vec<bool> = (0..modes.len()).map(is_shared).collect();
    for (mode, shared) in modes.iter_mut().zip(shared) {
        if shared || !proven {
            mode.shape_bound = None;
            mode.left_shape_bound = None;
        }
    }
}
