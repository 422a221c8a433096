//! What a tolerance is relative to.

use super::Allowed;

/// The largest displacement and velocity so far, which a tolerance is relative to.
#[derive(Default)]
pub(super) struct Scale {
    displacement: f64,
    velocity: f64,
}

impl Scale {
    pub(super) fn include(&mut self, state: &[f64]) {
        let (displacement, velocity) = state.split_at(state.len() / 2);
        self.displacement = self.displacement.max(largest(displacement));
        self.velocity = self.velocity.max(largest(velocity));
    }

    /// Where something does not move yet, what an acceleration in m/s² does within `time` s.
    pub(super) fn include_acceleration(&mut self, acceleration: f64, time: f64) {
        let at_least = |value: f64| value.max(f64::MIN_POSITIVE);
        self.velocity = at_least(self.velocity.max(acceleration * time));
        self.displacement = at_least(self.displacement.max(self.velocity * time));
    }

    pub(super) fn allowed(&self, tolerance: f64) -> Allowed {
        Allowed {
            displacement: tolerance * self.displacement,
            velocity: tolerance * self.velocity,
        }
    }
}

/// The largest magnitude.
pub(super) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most: f64, x| most.max(x.abs()))
}
