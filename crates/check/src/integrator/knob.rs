//! What the accuracy of an integrator is set by.

/// What the accuracy of an integrator is set by.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Knob {
    /// The error allowed in each step, relative to the largest displacement (or velocity) so far.
    Tolerance(f64),
    /// How many equal steps are taken between two neighbouring instants of the grid.
    Substeps(u32),
}

impl Knob {
    /// Why it is out of range.
    pub(super) fn misfit(self) -> Option<String> {
        match self {
            Knob::Tolerance(tolerance) => (!(1e-15..=1.0).contains(&tolerance))
                .then(|| format!("its tolerance is {tolerance}: it must lie between 1e-15 and 1")),
            Knob::Substeps(substeps) => {
                (substeps == 0).then(|| "it has 0 substeps: it needs at least 1".to_owned())
            }
        }
    }
}

impl std::fmt::Display for Knob {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Knob::Tolerance(tolerance) => write!(f, "tolerance {tolerance:e}"),
            Knob::Substeps(1) => f.write_str("1 substep"),
            Knob::Substeps(count) => write!(f, "{count} substeps"),
        }
    }
}
