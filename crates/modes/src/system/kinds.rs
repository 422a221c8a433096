//! What points, supports and elements measure, as far as it can be determined.

use std::collections::HashMap;

use super::given::Joint;
use crate::model::{CoordinateKind, GROUND, Point};

/// What each of them measures; `None` where it cannot be determined.
pub(super) struct Kinds {
    pub(super) points: Vec<Option<CoordinateKind>>,
    pub(super) supports: Vec<CoordinateKind>,
    pub(super) elements: Vec<Option<CoordinateKind>>,
}

impl Kinds {
    /// A point that moves with any displacement is one: rotations come in by their arms. The arm of a point that moves
    /// with rotations alone may be a length or the ratio of a gear, so that it, like a support, measures what springs and
    /// dampers join to it. A support that these do not decide is a displacement.
    pub(super) fn of(
        names: &[String],
        is_rotation: &[bool],
        points: &[Point],
        supports: &[String],
        elements: &[Joint],
    ) -> Kinds {
        let kind = |rotates: bool| match rotates {
            true => CoordinateKind::Rotation,
            false => CoordinateKind::Displacement,
        };
        let of_coordinate = |i: usize| kind(is_rotation.get(i) == Some(&true));
        let mut known: HashMap<&str, CoordinateKind> = HashMap::new();
        known.extend(
            names
                .iter()
                .enumerate()
                .map(|(i, name)| (name.as_str(), of_coordinate(i))),
        );
        for point in points {
            let mut coordinates = point.form.coordinates.iter();
            let moved = coordinates.any(|&(i, _)| of_coordinate(i) == CoordinateKind::Displacement);
            let kind = point.kind.or(moved.then_some(CoordinateKind::Displacement));
            known.extend(kind.map(|kind| (point.name.as_str(), kind)));
        }
        let joined = |known: &HashMap<&str, CoordinateKind>, name: &str, other: &str| {
            (!known.contains_key(name))
                .then(|| known.get(other).copied())
                .flatten()
        };
        // What all ends of the elements at a place of these names agree on.
        let agreed = |known: &HashMap<&str, CoordinateKind>| {
            let mut kinds: HashMap<String, Option<CoordinateKind>> = HashMap::new();
            if points.is_empty() && supports.is_empty() {
                return kinds;
            }
            for [a, b] in elements.iter().map(|element| &element.ends) {
                for (name, other) in [(a, b), (b, a)] {
                    if let Some(kind) = joined(known, name, other) {
                        let kinds = kinds.entry(name.clone()).or_insert(Some(kind));
                        *kinds = kinds.filter(|before| *before == kind);
                    }
                }
            }
            kinds
        };
        let kinds = agreed(&known);
        for name in supports {
            let kind = kinds.get(name).copied().flatten();
            known.insert(name, kind.unwrap_or(CoordinateKind::Displacement));
        }
        let kinds = agreed(&known);
        for point in points {
            if let Some(kind) = kinds.get(&point.name).copied().flatten() {
                known.insert(&point.name, kind);
            }
        }
        let between = |[a, b]: &[String; 2]| match (known.get(a.as_str()), known.get(b.as_str())) {
            (Some(a), Some(b)) if a == b => Some(*a),
            (Some(kind), None) if b == GROUND => Some(*kind),
            (None, Some(kind)) if a == GROUND => Some(*kind),
            _ => None,
        };
        let of = |name: &String| known.get(name.as_str()).copied();
        Kinds {
            points: points.iter().map(|point| of(&point.name)).collect(),
            supports: supports.iter().map(|name| known[name.as_str()]).collect(),
            elements: elements
                .iter()
                .map(|element| between(&element.ends))
                .collect(),
        }
    }
}
