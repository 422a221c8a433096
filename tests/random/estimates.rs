//! Estimated bounds against proven ones. Estimates are no theorem and may be too small for awkward numbers, so that this
//! belongs to random tests of ordinary numbers; fuzzing, which breeds the awkward ones, holds to proofs alone.

use eigentone::modes::{Bounds, MatrixKind};
use eigentone::scene::Scene;

use super::examine::{Answers, beyond, matched};

/// Estimates are to first order: so many times as much may be missed by them.
const ROOM: f64 = 16.0;

/// Whether products of a system's numbers stay within the doubles, which estimates rest on.
fn is_ordinary(scene: &Scene) -> bool {
    const ORDINARY: std::ops::Range<f64> = 1e-100..1e100;
    let system = scene.system();
    let elements = system.springs().iter().chain(system.dampers());
    let values = elements.map(|element| element.coefficient);
    let mut values = values.chain(system.masses().iter().copied());
    let matrices = [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness];
    values.all(|value| value == 0.0 || ORDINARY.contains(&value.abs()))
        && matrices.iter().all(|kind| {
            let added = system.added(*kind);
            added.is_none_or(|matrix| matrix.norm_max() < ORDINARY.end)
        })
}

/// That the answers in doubles lie within their estimates of the proven ones, where the numbers are such that
/// doubles can decide.
pub fn agree_with_estimates(scene: &Scene, answers: &Answers) {
    if !is_ordinary(scene) {
        return;
    }
    let proven = |bounds: Bounds| bounds == Bounds::Proven;
    if let (Some(certified), Some(estimated)) = (&answers.certified, &answers.estimated)
        && proven(certified.bounds())
    {
        let (certified, estimated) = (certified.eigenvalues(), estimated.eigenvalues());
        assert!(
            matched(certified, estimated, ROOM),
            "{certified:?}\n{estimated:?}"
        );
    }
    if let (Some(certified), Some(estimated)) = (&answers.motion, &answers.estimated_motion)
        && proven(certified.bounds())
    {
        assert_eq!(beyond(certified, estimated, ROOM), None);
    }
}
