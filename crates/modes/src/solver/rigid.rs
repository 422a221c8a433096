//! The roots λ = 0 of systems that nothing holds in place.

use eigentone_digits::{sort_by_number, svd};
use faer::MatRef;
use num_complex::Complex;

use crate::modes::Repeats;
use crate::system::System;

use super::roots::{Root, normalised};

/// `count` roots at 0 with the given shapes, of which every one is a motion that no spring
/// resists. If there are more roots than shapes, the root is defective: some shape keeps the
/// velocity that it is given, since no damper holds it either.
pub(crate) fn roots(shapes: Vec<Vec<Complex<f64>>>, count: usize) -> Vec<Root> {
    let defective = count > shapes.len();
    let root = |shape, each| Root {
        count: each,
        repeats: Some(Repeats::Exactly {
            count,
            defective: Some(defective),
        }),
        error: Some((0.0, 0.0)),
        ..Root::simple(Complex::ZERO, shape)
    };
    let listed = if defective { 1 } else { count };
    let each = if defective { count } else { 1 };
    shapes
        .into_iter()
        .take(listed)
        .map(|shape| root(shape, each))
        .collect()
}

/// Takes the `count` smallest of all roots, conjugates included, away: they are 0 but for rounding.
///
/// Rounding may join a root at 0 and a small real one to a conjugate pair. Of such a pair one stays behind, as
/// the real root that it then is: the sum of both, which rounding moves far less than either. Its shape is the part
/// of the pair's that is out of phase with the motion at rest.
pub(crate) fn removed(found: &mut Vec<Root>, count: usize) -> Vec<Root> {
    sort_by_number(found, |root| root.value.norm());
    let removed: Vec<Root> = found.drain(..count.min(found.len())).collect();
    let split = removed.iter().find(|root| {
        let conjugates = |list: &[Root]| {
            let equal = |other: &&Root| other.value == root.value.conj();
            list.iter().filter(equal).count()
        };
        root.value.im != 0.0 && conjugates(&removed) < conjugates(found)
    });
    if let Some(twin) = split.map(|root| root.value.conj())
        && let Some(left_over) = found.iter_mut().find(|root| root.value == twin)
    {
        left_over.value = Complex::from(2.0 * twin.re);
        left_over.shape = out_of_phase(&left_over.shape);
        left_over.left = left_over.left.as_deref().map(out_of_phase);
    }
    removed
}

/// The imaginary parts, once the largest component is real; the real ones where there are no others.
fn out_of_phase(shape: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let shape = normalised(shape);
    let part = |of: fn(&Complex<f64>) -> f64| shape.iter().map(|z| Complex::from(of(z))).collect();
    if shape.iter().all(|entry| entry.im == 0.0) {
        part(|z| z.re)
    } else {
        part(|z| z.im)
    }
}

/// The shapes that no spring resists: exact ones, such as those of parts that move as a whole; where these are not all, an
/// orthonormal basis of them.
pub(crate) fn shapes(system: &System) -> Vec<Vec<Complex<f64>>> {
    let structure = system.structure();
    let exact = structure.null_vectors();
    match structure.rigid_motions_counted() {
        Some(count) if count > exact.len() => {
            null_vectors(system.stiffness_matrix().as_ref(), count).unwrap_or_default()
        }
        _ => {
            let dense = exact.iter().map(|vector| vector.dense(system.len()));
            dense
                .map(|shape| shape.into_iter().map(Complex::from).collect())
                .collect()
        }
    }
}

/// An orthonormal basis of the `count` vectors that the matrix takes to 0, or nearly.
pub(crate) fn null_vectors(
    matrix: MatRef<'_, f64>,
    count: usize,
) -> Option<Vec<Vec<Complex<f64>>>> {
    let n = matrix.nrows();
    let svd = svd(matrix)?;
    let vector = |j: usize| svd.V().col(j).iter().map(|x| Complex::from(*x)).collect();
    Some((n - count.min(n)..n).map(vector).collect())
}
