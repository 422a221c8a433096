//! The parts a system is built from: coordinates, and the springs and dampers between them.

/// The reserved name of the fixed frame of reference: what does not move.
pub const GROUND: &str = "ground";

/// What a coordinate measures, and in which unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CoordinateKind {
    /// A displacement in m, with a mass in kg.
    Displacement,
    /// An angle in rad, with an inertia in kg·m².
    Rotation,
}

/// One end of a spring or damper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Node {
    /// The fixed frame of reference.
    Ground,
    /// The coordinate with this index, in the order in which masses were given.
    Coordinate(usize),
}

impl Node {
    /// The coordinate's index, or `None` for the ground.
    pub fn coordinate(self) -> Option<usize> {
        match self {
            Node::Ground => None,
            Node::Coordinate(index) => Some(index),
        }
    }
}

/// A spring or a damper: it pulls its two ends together with `coefficient` times the difference of
/// their displacements (spring) or velocities (damper).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element {
    /// One end.
    pub first: Node,
    /// The other end; never the same as `first`.
    pub second: Node,
    /// Stiffness in N/m or damping in N·s/m. It may be negative.
    pub coefficient: f64,
}

/// Which of the two kinds of element between nodes is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ElementKind {
    /// A force in proportion to the difference of displacements.
    Spring,
    /// A force in proportion to the difference of velocities.
    Damper,
}

impl std::fmt::Display for ElementKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            ElementKind::Spring => "spring",
            ElementKind::Damper => "damper",
        })
    }
}

/// Which of the three matrices of M x″ + C x′ + K x = f is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatrixKind {
    /// M, the mass matrix.
    Mass,
    /// C, the damping matrix.
    Damping,
    /// K, the stiffness matrix.
    Stiffness,
}

impl std::fmt::Display for MatrixKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            MatrixKind::Mass => "mass",
            MatrixKind::Damping => "damping",
            MatrixKind::Stiffness => "stiffness",
        })
    }
}
