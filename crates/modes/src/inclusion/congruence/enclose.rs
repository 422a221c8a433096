//! Shapes with bounds, refined as long as these gain by it.

use super::forms::{Basis, Forms};
use super::mixing;
use crate::inclusion::shape::Enclosed;

impl Basis<'_> {
    /// The elastic shapes with bounds, where these are proved, after as many more steps as help, and the forms
    /// then.
    pub(super) fn enclosed(
        &mut self,
        mut forms: Forms,
        tolerance: f64,
    ) -> (Forms, Vec<Option<Enclosed>>) {
        const STEPS: usize = 1;
        /// Little is gained below.
        const LEAST: f64 = 1e-25;
        let good = |shape: &Option<Enclosed>| {
            let shape = shape.as_ref();
            shape.is_none_or(|shape| shape.meets(tolerance))
        };
        let mut shapes = self.shapes(&forms);
        for _ in 0..STEPS {
            if forms.spread <= LEAST || shapes.iter().all(good) {
                break;
            }
            let Some((next, slow)) = self.advanced(&forms) else {
                break;
            };
            forms = next;
            shapes = self.shapes(&forms);
            if slow {
                break;
            }
        }
        (forms, shapes)
    }

    fn shapes(&self, forms: &Forms) -> Vec<Option<Enclosed>> {
        // What follows at once is not bounded.
        if self.inert.count() > 0 {
            return vec![None; self.elastic];
        }
        let errors = mixing::errors(forms, &self.columns);
        let each = self.columns.iter().zip(errors);
        each.map(|(column, errors)| Enclosed::real(column, &errors?))
            .collect()
    }
}
