//! Points, springs and dampers by the names of what they join, as they were given.

use crate::model::{CoordinateKind, ElementKind};

/// A point as it was given.
#[derive(Clone, Debug)]
pub(super) struct GivenPoint {
    pub(super) name: String,
    pub(super) moves: Vec<(String, f64)>,
    pub(super) mass: f64,
    pub(super) kind: Option<CoordinateKind>,
}

/// A spring or a damper as it was given.
#[derive(Clone, Debug)]
pub(super) struct Joint {
    pub(super) kind: ElementKind,
    pub(super) ends: [String; 2],
    pub(super) coefficient: f64,
    pub(super) name: Option<String>,
}
