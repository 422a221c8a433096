//! Designs of which none is better in one of two aims without being worse in the other (Pareto).
//!
//! The ends are the least of each aim. Between them each point is the least maximum of both above a point of the straight line
//! between the ends, in parts of the line's extent (Pascoletti & Serafini 1984, *Scalarizing vector optimization problems*), so
//! that hollow parts of the front are reached too.

use crate::minimax::{Optimum, OptimumError, Piece, minimise_with};

/// A design on the front.
#[derive(Clone, Debug, PartialEq)]
pub struct FrontPoint {
    /// The parameters.
    pub point: Vec<f64>,
    /// Both aims there.
    pub aims: [f64; 2],
    /// Whether derivatives show that no small change makes one aim better and not the other worse.
    pub is_shown: bool,
}

/// What distinguishes the functions of the second aim from those of the first.
const APART: f64 = 1e6;

/// Finds `count` designs between the least of the first aim and that of the second, in this order, without those that others
/// surpass. `aims` gives the functions of which each aim is the largest, as for [`minimise`](crate::minimise). Where one design is best for both,
/// it is the only one.
///
/// ```
/// use eigentone_design::{Piece, front};
///
/// let piece = |value: f64| vec![Piece { place: 0.0, value }];
/// let points = front(&[(-4.0, 4.0)], 3, |x| {
///     Some([piece(x[0] * x[0]), piece((x[0] - 2.0).powi(2))])
/// })?;
/// assert_eq!(points.len(), 3);
/// assert!((points[1].point[0] - 1.0).abs() < 1e-9);
/// # Ok::<(), eigentone_design::OptimumError>(())
/// ```
///
/// # Errors
/// [`OptimumError`].
pub fn front(
    limits: &[(f64, f64)],
    count: usize,
    aims: impl FnMut(&[f64]) -> Option<[Vec<Piece>; 2]>,
) -> Result<Vec<FrontPoint>, OptimumError> {
    front_with(limits, count, aims, |_| None)
}

/// The same with gradients, as [`minimise_with`] takes them.
///
/// # Errors
/// [`OptimumError`].
pub fn front_with(
    limits: &[(f64, f64)],
    count: usize,
    mut aims: impl FnMut(&[f64]) -> Option<[Vec<Piece>; 2]>,
    mut gradients: impl FnMut(&[f64]) -> Option<[Vec<(Piece, Vec<f64>)>; 2]>,
) -> Result<Vec<FrontPoint>, OptimumError> {
    let first = minimise_with(
        limits,
        |x| aims(x).map(|[first, _]| first),
        |x| gradients(x).map(|[first, _]| first),
    )?;
    let second = minimise_with(
        limits,
        |x| aims(x).map(|[_, second]| second),
        |x| gradients(x).map(|[_, second]| second),
    )?;
    let mut at = |optimum: Optimum| -> Option<FrontPoint> {
        let values = aims(&optimum.point)?.map(|pieces| worst(&pieces));
        Some(FrontPoint {
            is_shown: optimum.is_shown(),
            point: optimum.point,
            aims: values,
        })
    };
    let tried = first.evaluations + second.evaluations;
    let (Some(first), Some(second)) = (at(first), at(second)) else {
        return Err(OptimumError::Nowhere { tried });
    };
    let extent = [
        second.aims[0] - first.aims[0],
        first.aims[1] - second.aims[1],
    ];
    if (0..2).any(|aim| extent[aim] <= 1e-9 * first.aims[aim].abs()) {
        return Ok(vec![first]);
    }
    let best = [first.aims[0], second.aims[1]];
    let mut points = vec![first];
    for k in 1..count.saturating_sub(1) {
        let part = k as f64 / (count - 1) as f64;
        let start = [
            best[0] + part * extent[0],
            best[1] + (1.0 - part) * extent[1],
        ];
        // 1 on the line: what is relative to it stays so.
        let above = |aim: usize, piece: Piece| Piece {
            place: piece.place + APART * aim as f64,
            value: 1.0 + (piece.value - start[aim]) / extent[aim],
        };
        let found = minimise_with(
            limits,
            |x| {
                let all = aims(x)?.into_iter().enumerate();
                let all = all.flat_map(|(aim, pieces)| {
                    let each = pieces.into_iter();
                    each.map(move |piece| above(aim, piece))
                });
                Some(all.collect())
            },
            |x| {
                let all = gradients(x)?.into_iter().enumerate();
                let all = all.flat_map(|(aim, pieces)| {
                    pieces.into_iter().map(move |(piece, gradient)| {
                        let parts = gradient.into_iter().map(|slope| slope / extent[aim]);
                        (above(aim, piece), parts.collect())
                    })
                });
                Some(all.collect())
            },
        )?;
        if let Some(pieces) = aims(&found.point) {
            points.push(FrontPoint {
                is_shown: found.is_shown(),
                point: found.point,
                aims: pieces.map(|pieces| worst(&pieces)),
            });
        }
    }
    points.push(second);
    let surpassed = |one: &FrontPoint| {
        let better = |other: &FrontPoint| {
            let [a, b] = [0, 1].map(|aim| other.aims[aim] - one.aims[aim]);
            a <= 0.0 && b <= 0.0 && (a < 0.0 || b < 0.0)
        };
        points.iter().any(better)
    };
    let kept = points.iter().filter(|one| !surpassed(one)).cloned();
    Ok(kept.collect())
}

fn worst(pieces: &[Piece]) -> f64 {
    let values = pieces.iter().map(|piece| piece.value);
    values.fold(f64::NEG_INFINITY, f64::max)
}
