//! Single shapes with more digits, where those of all at once do not do.

use eigentone_digits::{Ball, DoubleDouble, Magnitude, Real};

use crate::inclusion::exactly::exact;
use crate::inclusion::gram::UPWARD;
use crate::inclusion::pencil::Pencil;
use crate::inclusion::shape::{self, Disc, Enclosed, Kind, Shaper};
use crate::system::System;

/// Finds single shapes with more digits where those of all at once do not do.
pub(super) struct Closer {
    unit: i32,
    goal: shape::Goal,
    /// Few enough coordinates for an elimination at every root.
    pencil: Option<Pencil>,
}

impl Closer {
    pub(super) fn of(system: &System, squares: &[DoubleDouble], tolerance: f64) -> Closer {
        const LARGEST: usize = 64;
        let sizes = squares.iter().map(|square| square.to_f64().abs());
        let largest = sizes.fold(f64::MIN_POSITIVE, f64::max);
        Closer {
            unit: (largest.log2() / 2.0).round() as i32,
            goal: shape::Goal {
                tolerance,
                symmetric: true,
                roots: squares.len(),
            },
            pencil: (system.len() <= LARGEST).then(|| Pencil::of(system, true)),
        }
    }

    /// The shape of the only root at σ, as found already or better.
    pub(super) fn shape(
        &self,
        sigma: DoubleDouble,
        reach: f64,
        found: Option<Enclosed>,
    ) -> Option<Enclosed> {
        let good = |shape: &Enclosed| shape.meets(self.goal.tolerance);
        let enough = found.as_ref().is_some_and(good);
        let Some(pencil) = self.pencil.as_ref().filter(|_| !enough) else {
            return found;
        };
        let kind = Kind {
            is_simple: true,
            is_real: true,
        };
        // λ² = −σ = 4^unit·μ.
        let scale = -2 * i64::from(self.unit);
        let centre = exact(-sigma.scale(scale), DoubleDouble::ZERO).middle();
        let reach = Real::scale(reach * UPWARD, scale).max(f64::MIN_POSITIVE);
        let disc = Disc::of(Ball::new(centre, Magnitude::from(reach)));
        let closer = Shaper::of(pencil, self.unit, self.goal).shapes(disc, kind);
        let closer = closer.map(|shapes| shapes.right);
        match (found, closer) {
            (Some(found), Some(closer))
                if !good(&closer) && found.looseness() < closer.looseness() =>
            {
                Some(found)
            }
            (found, closer) => closer.or(found),
        }
    }
}
