//! The history of a combination of motions.

/// The values of a combination at the instants asked for, each with a bound.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Combined {
    pub(crate) values: Vec<f64>,
    pub(crate) bounds: Vec<Option<f64>>,
}

impl Combined {
    pub(super) fn push(&mut self, value: f64, bound: Option<f64>) {
        self.values.push(value);
        self.bounds.push(bound);
    }

    /// Those at some of the instants.
    pub(super) fn picked(&self, instants: &[usize]) -> Combined {
        Combined {
            values: instants.iter().map(|k| self.values[*k]).collect(),
            bounds: instants.iter().map(|k| self.bounds[*k]).collect(),
        }
    }
}
