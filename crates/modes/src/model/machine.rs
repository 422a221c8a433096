//! What a model has beside coordinates: points that move with them, supports whose motion is prescribed, and elements as
//! they were given.

use super::{CoordinateKind, ElementKind, Form, Term};

/// A place that moves with coordinates and supports: a point of a rigid body, the end of a lever, a belt on a pulley.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Its name.
    pub name: String,
    /// Its displacement.
    pub form: Form,
    /// Its mass in kg (or an inertia in kg·m²).
    pub mass: f64,
    /// What it measures; `None` where it moves with rotations alone and nothing distinguishes an arm from the ratio of a gear.
    pub kind: Option<CoordinateKind>,
}

/// A spring or a damper as it was given: it pulls with `coefficient` times its stretch (spring) or the rate of its
/// stretch (damper).
#[derive(Clone, Debug, PartialEq)]
pub struct GivenElement {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// The names of a and b, between which it was given: masses, points, supports or the ground.
    pub ends: [String; 2],
    /// x_b − x_a of an element between a and b.
    pub stretch: Form,
    /// Stiffness in N/m or damping in N·s/m, between rotations in N·m/rad or N·m·s/rad. It may be negative.
    pub coefficient: f64,
    /// What its stretch measures; `None` where its ends differ or are not known.
    pub kind: Option<CoordinateKind>,
}

/// Ends of beams and rods that do not move, as far as mass reaches them: what shakes the ground shakes them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Held {
    /// What each measures.
    pub(crate) kinds: Vec<CoordinateKind>,
    /// What a unit motion of each, whose index is the column, would add to M x″.
    pub(crate) coupling: Vec<Term>,
    /// The forces that their unit motions would take at themselves.
    pub(crate) between: Vec<Term>,
}

/// Points, supports and elements as given, of a model that has more than coordinates and elements between them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Machine {
    pub(crate) points: Vec<Point>,
    pub(crate) supports: Vec<String>,
    /// What each support measures.
    pub(crate) support_kinds: Vec<CoordinateKind>,
    pub(crate) springs: Vec<GivenElement>,
    pub(crate) dampers: Vec<GivenElement>,
    /// By matrix: what a unit motion of each support, whose index is the column, adds to M x″, C x′ and K x.
    pub(crate) couplings: [Vec<Term>; 3],
    /// By matrix: the forces that unit motions of the supports take at the supports themselves.
    pub(crate) between_supports: [Vec<Term>; 3],
    pub(crate) held: Held,
    /// Whether each coordinate is a rotation; empty where none is.
    pub(crate) is_rotation: Vec<bool>,
}

impl Machine {
    pub(crate) fn elements(&self, kind: ElementKind) -> &[GivenElement] {
        match kind {
            ElementKind::Spring => &self.springs,
            ElementKind::Damper => &self.dampers,
        }
    }
}
