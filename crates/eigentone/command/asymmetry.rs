//! Matrices that rounding may have left unsymmetric.

use std::io::{self, Write};
use std::path::Path;

use eigentone::modes::{MatrixKind, System};

/// Says on standard error which added matrices differ from their transposes by no more than rounding leaves: sums of
/// elements in another order do.
pub(super) fn report(scene: &Path, system: &System) {
    /// Of √(a_ii a_jj).
    const ROUNDING: f64 = 1e-12;
    for kind in [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness] {
        let off = asymmetry(system, kind);
        if off > 0.0 && off <= ROUNDING {
            // If standard error is closed, nobody can be informed.
            let _ = writeln!(
                io::stderr(),
                "note: {}: the {kind} matrix differs from its transpose by {off:.1e} of √(a_ii a_jj) at most, as by rounding, \
                 and counts as unsymmetric; where it is to be symmetric, give (A + Aᵀ)/2",
                scene.display()
            );
        }
    }
}

/// The largest |a_ij − a_ji|, of √(a_ii a_jj) or of the larger of both entries, of a matrix that is not sparse.
fn asymmetry(system: &System, kind: MatrixKind) -> f64 {
    let Some(matrix) = system.added(kind) else {
        return 0.0;
    };
    let size = |i: usize| matrix[(i, i)].abs().sqrt();
    let pairs = (0..matrix.nrows()).flat_map(|i| (0..i).map(move |j| (i, j)));
    pairs.fold(0.0, |largest, (i, j)| {
        let (a, b) = (matrix[(i, j)], matrix[(j, i)]);
        if a == b {
            return largest;
        }
        let whole = a.abs().max(b.abs()).max(size(i) * size(j));
        largest.max((a - b).abs() / whole)
    })
}
