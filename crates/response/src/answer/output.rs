//! What may be followed along a response.

/// A quantity to follow along a response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// The displacement of the coordinate of this index, in m.
    Displacement(usize),
    /// The velocity of the coordinate of this index, in m/s.
    Velocity(usize),
}

impl Output {
    pub(crate) fn coordinate(self) -> usize {
        match self {
            Output::Displacement(coordinate) | Output::Velocity(coordinate) => coordinate,
        }
    }
}
