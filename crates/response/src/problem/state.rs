//! Where the coordinates are, and how fast they move, at t = 0.

/// Displacements and velocities at t = 0, by the names of the coordinates; what is not named is 0.
/// Names and values are checked where the state meets its system, in
/// [`Problem::new`](crate::Problem::new).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    pub(crate) displacements: Vec<(String, f64)>,
    pub(crate) velocities: Vec<(String, f64)>,
}

impl State {
    /// All displacements and velocities 0.
    pub fn at_rest() -> State {
        State::default()
    }

    /// The same state with the coordinate `name` displaced by `displacement` m; the last value
    /// given for a name counts.
    pub fn displace(mut self, name: impl Into<String>, displacement: f64) -> State {
        self.displacements.push((name.into(), displacement));
        self
    }

    /// The same state with the coordinate `name` moving at `velocity` m/s; the last value given
    /// for a name counts.
    pub fn push(mut self, name: impl Into<String>, velocity: f64) -> State {
        self.velocities.push((name.into(), velocity));
        self
    }
}
