//! Shapes of single roots with bounds, refined as long as these gain by it.

use eigentone_digits::{Ball, Magnitude};

use super::discs::Disc;
use super::mixing::Side;
use super::pair::{Pair, Pairs, Parts};
use super::rows::Rows;
use crate::inclusion::exactly::exact;
use crate::inclusion::shape::{Enclosed, Shapes};
use crate::structure::Structure;

impl Pairs<'_> {
    /// The discs of all roots, with the shapes of each single one where their bounds are proved, after as many more steps as
    /// help.
    pub(super) fn enclosed(
        &mut self,
        rows: Rows,
        structure: &Structure,
        tolerance: f64,
    ) -> Option<Vec<(Disc, Option<Shapes>)>> {
        const STEPS: usize = 1;
        /// Little is gained below.
        const LEAST: f64 = 1e-25;
        let good = |(_, shapes): &(Disc, Option<Shapes>)| {
            let shapes = shapes.as_ref();
            shapes.is_none_or(|shapes| shapes.meet(tolerance))
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
    ) -> Option<Vec<(Disc, Option<Shapes>)>> {
        let discs = rows.discs()?;
        let undamped = self.are_undamped(structure, discs.iter());
        let enclosed = |disc: &Disc, side: fn(&Pair) -> &Parts, errors: Vec<f64>| {
            let pair = &self.pairs[disc.members[0]];
            if pair.origin.is_counted() {
                return None;
            }
            let parts = side(pair);
            let ball = |(row, error): (usize, f64)| {
                let im = parts.im.get(row).copied().unwrap_or_default();
                Ball::new(exact(parts.re[row], im).middle(), Magnitude::from(error))
            };
            let balls: Vec<_> = errors.into_iter().enumerate().map(ball).collect();
            // With C x = 0, x belongs to real matrices and a real ω²; y need not.
            Enclosed::of(
                &balls,
                pair.is_real() || undamped && !self.has_left() && disc.is_on_axis(),
            )
        };
        let shapes = |side: Side, parts: fn(&Pair) -> &Parts| -> Vec<Option<Enclosed>> {
            // What follows at once is not bounded.
            if self.inert.count() > 0 {
                return discs.iter().map(|_| None).collect();
            }
            let errors = rows.shape_errors(&self.pairs, &discs, side);
            let each = discs.iter().zip(errors);
            each.map(|(disc, errors)| enclosed(disc, parts, errors?))
                .collect()
        };
        let right = shapes(Side::Right, Pair::right);
        let found: Vec<Option<Shapes>> = if self.has_left() {
            let left = shapes(Side::Left, Pair::left);
            let both = right.into_iter().zip(left);
            // y*Q = 0 for the conjugate.
            let both = both.map(|(right, left)| {
                let left = Some(left?.conjugate());
                Some(Shapes {
                    right: right?,
                    left,
                })
            });
            both.collect()
        } else {
            let alone = |right| Shapes { right, left: None };
            right.into_iter().map(|right| right.map(alone)).collect()
        };
        Some(discs.into_iter().zip(found).collect())
    }
}
