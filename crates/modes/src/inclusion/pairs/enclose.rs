//! Shapes of single roots with bounds, refined as long as these gain by it.

use eigentone_digits::{Ball, Magnitude};

use super::discs::Disc;
use super::pair::Pairs;
use super::rows::Rows;
use crate::inclusion::exactly::exact;
use crate::inclusion::shape::Enclosed;
use crate::structure::Structure;

impl Pairs<'_> {
    /// The discs of all roots, with the shape of each single one where its bounds are proved, after as many more steps as
    /// help.
    pub(super) fn enclosed(
        &mut self,
        rows: Rows,
        structure: &Structure,
        tolerance: f64,
    ) -> Option<Vec<(Disc, Option<Enclosed>)>> {
        const STEPS: usize = 1;
        /// Little is gained below.
        const LEAST: f64 = 1e-25;
        let good = |(_, shape): &(Disc, Option<Enclosed>)| {
            let shape = shape.as_ref();
            shape.is_none_or(|shape| shape.meets(tolerance))
        };
        let mut rows = rows;
        let mut found = self.with_shapes(&rows, structure)?;
        for _ in 0..STEPS {
            if rows.spread() <= LEAST || found.iter().all(good) {
                break;
            }
            let before = self.pairs.clone();
            let next = self.advanced(&rows);
            let better = next.and_then(|(next, slow)| {
                let found = self.with_shapes(&next, structure)?;
                Some((next, slow, found))
            });
            let Some((next, slow, closer)) = better else {
                self.pairs = before;
                break;
            };
            (rows, found) = (next, closer);
            if slow {
                break;
            }
        }
        Some(found)
    }

    fn with_shapes(
        &self,
        rows: &Rows,
        structure: &Structure,
    ) -> Option<Vec<(Disc, Option<Enclosed>)>> {
        let discs = rows.discs()?;
        let undamped = self.are_undamped(structure, discs.iter());
        let errors = rows.shape_errors(&self.pairs, &discs);
        let shape = |(disc, errors): (Disc, Option<Vec<f64>>)| {
            let shape = errors.and_then(|errors| {
                let pair = &self.pairs[disc.members[0]];
                let ball = |(row, error): (usize, f64)| {
                    let im = pair.im.get(row).copied().unwrap_or_default();
                    Ball::new(exact(pair.re[row], im).middle(), Magnitude::from(error))
                };
                let balls: Vec<_> = errors.into_iter().enumerate().map(ball).collect();
                // With C x = 0, x belongs to real matrices and a real ω².
                Enclosed::of(&balls, pair.is_real() || undamped && disc.is_on_axis())
            });
            (disc, shape)
        };
        Some(discs.into_iter().zip(errors).map(shape).collect())
    }
}
