//! Designs of which none is better in one of two aims without being worse in the other (Pareto).
//!
//! The ends are the least of each aim. Between them each point is the least maximum of both above a point of the straight line
//! between the ends, in parts of the line's extent (Pascoletti & Serafini 1984, *Scalarizing vector optimization problems*), so
//! that hollow parts of the front are reached too.

use crate::minimax::{OptimumError, Piece, ROUNDING, inside, minimise_from, surpasses};

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

/// The same with gradients, as [`minimise_with`](crate::minimise_with) takes them.
///
/// # Errors
/// [`OptimumError`].
pub fn front_with(
    limits: &[(f64, f64)],
    count: usize,
    aims: impl FnMut(&[f64]) -> Option<[Vec<Piece>; 2]>,
    gradients: impl FnMut(&[f64]) -> Option<[Vec<(Piece, Vec<f64>)>; 2]>,
) -> Result<Vec<FrontPoint>, OptimumError> {
    let mut searches = Searches {
        limits,
        aims,
        gradients,
        seen: Vec::new(),
    };
    let of_one = [Goal::of(0), Goal::of(1)];
    let mut ends = Vec::new();
    for goal in &of_one {
        ends.push(searches.search(None, goal)?);
    }
    for (aim, end) in ends.iter_mut().enumerate() {
        searches.improve(&of_one[aim], end)?;
        searches.choose(aim, end)?;
    }
    let extent = [
        ends[1].aims[0] - ends[0].aims[0],
        ends[0].aims[1] - ends[1].aims[1],
    ];
    // An end that is no worse in the aim of the other is the best for both.
    for (end, aim) in [(0, 1), (1, 0)] {
        if extent[aim] <= 1e-9 * ends[0].aims[aim].abs() {
            return Ok(vec![ends.swap_remove(end)]);
        }
    }
    let best = [ends[0].aims[0], ends[1].aims[1]];
    let mut points = Vec::new();
    let goals = (1..count.saturating_sub(1)).map(|k| {
        let part = k as f64 / (count - 1) as f64;
        let start = [
            best[0] + part * extent[0],
            best[1] + (1.0 - part) * extent[1],
        ];
        // 1 on the line: what is relative to it stays so.
        Goal {
            scales: [0, 1].map(|aim| Some([start[aim] - extent[aim], extent[aim]])),
            most: [f64::INFINITY; 2],
        }
    });
    let goals: Vec<Goal> = goals.collect();
    for goal in &goals {
        points.push(searches.search(None, goal)?);
    }
    for (goal, point) in goals.iter().zip(&mut points) {
        searches.improve(goal, point)?;
    }
    points.splice(0..0, ends.drain(..1));
    points.append(&mut ends);
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

/// What one search makes least: the largest of some aims, each by a scale of its own.
struct Goal {
    /// For each aim that counts, what is 0 on its scale and how much is 1.
    scales: [Option<[f64; 2]>; 2],
    /// Designs with more in an aim are left out.
    most: [f64; 2],
}

impl Goal {
    fn of(aim: usize) -> Goal {
        let mut scales = [None; 2];
        scales[aim] = Some([0.0, 1.0]);
        Goal {
            scales,
            most: [f64::INFINITY; 2],
        }
    }

    fn admits(&self, aims: [f64; 2]) -> bool {
        (0..2).all(|aim| aims[aim] <= self.most[aim])
    }

    fn value(&self, aims: [f64; 2]) -> f64 {
        let values = self.scales.iter().zip(aims);
        let values = values.map(|(scale, value)| scale.map(|[zero, one]| (value - zero) / one));
        values.flatten().fold(f64::NEG_INFINITY, f64::max)
    }

    /// Functions of both aims, which `scaled` makes others of by the scale of each.
    fn functions<T>(&self, both: [Vec<T>; 2], scaled: impl Fn(T, usize, [f64; 2]) -> T) -> Vec<T> {
        let scaled = &scaled;
        let each = both.into_iter().zip(self.scales).enumerate();
        let each = each.filter_map(|(aim, (all, scale))| Some((aim, all, scale?)));
        let each = each
            .flat_map(|(aim, all, scale)| all.into_iter().map(move |one| scaled(one, aim, scale)));
        each.collect()
    }
}

fn scaled(piece: Piece, aim: usize, [zero, one]: [f64; 2]) -> Piece {
    Piece {
        place: piece.place + APART * aim as f64,
        value: (piece.value - zero) / one,
    }
}

/// Searches that know of each other what they have looked at.
struct Searches<'a, A, G> {
    limits: &'a [(f64, f64)],
    aims: A,
    gradients: G,
    /// All designs, with both aims.
    seen: Vec<(Vec<f64>, [f64; 2])>,
}

impl<A, G> Searches<'_, A, G>
where
    A: FnMut(&[f64]) -> Option<[Vec<Piece>; 2]>,
    G: FnMut(&[f64]) -> Option<[Vec<(Piece, Vec<f64>)>; 2]>,
{
    fn search(&mut self, start: Option<&[f64]>, goal: &Goal) -> Result<FrontPoint, OptimumError> {
        let (aims, gradients, seen) = (&mut self.aims, &mut self.gradients, &mut self.seen);
        let found = minimise_from(
            start,
            self.limits,
            |x| {
                let both = aims(x)?;
                let values = both.each_ref().map(|pieces| worst(pieces));
                if values.iter().all(|value| value.is_finite()) {
                    seen.push((x.to_vec(), values));
                }
                let functions = || goal.functions(both, scaled);
                goal.admits(values).then(functions)
            },
            |x| {
                let sloped = |(piece, mut gradient): (Piece, Vec<f64>), aim, scale: [f64; 2]| {
                    gradient.iter_mut().for_each(|slope| *slope /= scale[1]);
                    (scaled(piece, aim, scale), gradient)
                };
                Some(goal.functions(gradients(x)?, sloped))
            },
        )?;
        let values = aims(&found.point).map(|both| both.each_ref().map(|pieces| worst(pieces)));
        let tried = found.evaluations;
        Ok(FrontPoint {
            is_shown: found.is_shown(),
            point: found.point,
            aims: values.ok_or(OptimumError::Nowhere { tried })?,
        })
    }

    /// Goes on from a design that another search has looked at, where one is better.
    fn improve(&mut self, goal: &Goal, point: &mut FrontPoint) -> Result<(), OptimumError> {
        let value = |(_, aims): &&(Vec<f64>, [f64; 2])| goal.value(*aims);
        let least = self
            .seen
            .iter()
            .min_by(|a, b| value(a).total_cmp(&value(b)));
        let better = least.filter(|least| surpasses(value(least), goal.value(point.aims)));
        if let Some((start, _)) = better.cloned() {
            *point = self.search(Some(&start), goal)?;
        }
        Ok(())
    }

    /// The end that is best in the other aim, where designs far from each other are as good in its own.
    fn choose(&mut self, aim: usize, end: &mut FrontPoint) -> Result<(), OptimumError> {
        /// In parts of the ranges: the least function that is smooth and not flat has changed by more than rounding there.
        const FAR: f64 = 1e-2;
        let other = 1 - aim;
        let mut goal = Goal::of(other);
        goal.most[aim] = end.aims[aim] + ROUNDING * end.aims[aim].abs();
        let here = inside(self.limits, &end.point);
        let is_far = |point: &[f64]| {
            let there = inside(self.limits, point);
            here.iter().zip(there).any(|(a, b)| (a - b).abs() > FAR)
        };
        let equal = self.seen.iter().filter(|(point, aims)| {
            goal.admits(*aims) && surpasses(aims[other], end.aims[other]) && is_far(point)
        });
        let best = equal.min_by(|(_, a), (_, b)| a[other].total_cmp(&b[other]));
        if let Some((start, _)) = best.cloned() {
            *end = self.search(Some(&start), &goal)?;
        }
        Ok(())
    }
}

fn worst(pieces: &[Piece]) -> f64 {
    let values = pieces.iter().map(|piece| piece.value);
    values.fold(f64::NEG_INFINITY, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(value: f64) -> Vec<Piece> {
        vec![Piece { place: 0.0, value }]
    }

    #[test]
    fn an_end_where_the_first_aim_is_flat_is_the_best_in_the_other() {
        // Flat up to 1, where the front begins.
        let flat = |x: f64| 2.0 + (x - 1.0).max(0.0).powi(2);
        let falling = |x: f64| 10.0 - x;
        let points = front(&[(-4.0, 4.0)], 5, |x| {
            Some([piece(flat(x[0])), piece(falling(x[0]))])
        });
        let points = points.unwrap();
        assert_eq!(points.len(), 5);
        assert!((points[0].point[0] - 1.0).abs() < 1e-5, "{points:?}");
        let points = front(&[(-4.0, 4.0)], 5, |x| {
            Some([piece(falling(x[0])), piece(flat(x[0]))])
        });
        let points = points.unwrap();
        assert_eq!(points.len(), 5);
        assert!((points[4].point[0] - 1.0).abs() < 1e-5, "{points:?}");
    }

    #[test]
    fn an_end_that_is_better_in_both_is_the_only_one() {
        // A well so narrow that no search for the first aim finds it, but one for the second comes by.
        let well = |x: f64| (x * x).min(1e8 * (x - 3.0).powi(2) - 1.0);
        let points = front(&[(-4.0, 4.0)], 5, |x| {
            Some([piece(well(x[0])), piece((x[0] - 3.0).powi(2))])
        });
        let points = points.unwrap();
        assert_eq!(points.len(), 1);
        assert!((points[0].point[0] - 3.0).abs() < 1e-9, "{points:?}");
        assert!((points[0].aims[0] + 1.0).abs() < 1e-9, "{points:?}");
    }
}
