//! Roots of the whole equation with what is known of them.

use eigentone_digits::sort_by_number;
use num_complex::Complex;

use crate::modes::Repeats;

/// A vector by its real and imaginary parts.
pub(crate) type Parts = [Vec<f64>; 2];

/// A root with its shape and what is known of its error.
pub(crate) struct Root {
    pub(crate) value: Complex<f64>,
    /// Estimated |λ̂ − λ| and that of the real part.
    pub(crate) error: Option<(f64, f64)>,
    pub(crate) shape: Parts,
    pub(crate) repeats: Repeats,
    /// How many roots it stands for.
    pub(crate) roots: usize,
}

impl Root {
    /// Has a cluster it is in say no more than was found, where that none of it is missing is not proved.
    pub(crate) fn may_have_more_beside(&mut self) {
        if let Repeats::Cluster(count) = self.repeats {
            self.repeats = Repeats::AtLeast(count);
        }
    }
}

/// Roots, and whether it is proved that none is missing between them, or else what the proof lacks.
pub(crate) struct Answer {
    pub(crate) roots: Vec<Root>,
    pub(crate) complete: Result<(), &'static str>,
}

/// What a proof lacks where eigenvalues of (K, M) were not counted.
pub(crate) const NOT_COUNTED: &str =
    "the pivots of K - sM are rounded too much to count the undamped modes";

/// Keeps so many entries whose natural frequencies are nearest to the target; how far the last one is.
pub(crate) fn keep_nearest(roots: &mut Vec<Root>, target: f64, count: usize) -> Option<f64> {
    let apart = |root: &Root| (root.value.norm() - target).abs();
    sort_by_number(roots, apart);
    roots.truncate(count);
    roots.last().map(apart)
}
