//! The laws that loads follow within an interval.

/// The laws that the loads follow within an interval.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Laws {
    /// Some load is constant or grows steadily.
    pub(crate) straight: bool,
    /// Some load grows steadily.
    pub(crate) sloped: bool,
    /// The angular frequencies of the harmonic loads, in rad/s.
    pub(crate) frequencies: Vec<f64>,
}

impl Laws {
    /// How many blocks of inputs they make.
    pub(crate) fn blocks(&self) -> usize {
        usize::from(self.straight) + usize::from(self.sloped) + 2 * self.frequencies.len()
    }
}
