//! The eigenvalues λ = ω² of K x = λ M x nearest to a shift, and whether any was missed.
//!
//! The number of eigenvalues in an interval is the difference of the numbers of negative pivots of
//! K − τM at its ends. Where that is more than were found, Lanczos' method is run again with those that
//! were found locked (Grimes, Lewis & Simon 1994, *SIAM J. Matrix Anal. Appl.* 15, "A shifted block
//! Lanczos algorithm for solving sparse symmetric generalized eigenproblems").

use super::SparseError;
use super::factor::Factor;
use super::lanczos::{Found, Goal, lanczos};
use super::operator::{Rigid, ShiftInvert};
use super::pencil::Pencil;

/// What is looked for.
#[derive(Clone, Debug)]
pub(crate) struct Wanted<'a> {
    pub(crate) pencil: &'a Pencil,
    /// Parts with mass that no spring ties to the ground.
    pub(crate) floating: &'a [Vec<usize>],
    /// How many parts without mass no spring ties to the ground.
    pub(crate) idle: usize,
    pub(crate) count: usize,
}

/// An eigenvector other than the rigid ones.
#[derive(Clone, Debug)]
pub(crate) struct Vector {
    /// 1/(λ − σ).
    pub(crate) inverse: f64,
    pub(crate) shape: Vec<f64>,
}

/// What was found about a shift.
#[derive(Debug)]
pub(crate) struct Answer<'a> {
    pub(crate) operator: ShiftInvert<'a>,
    /// The nearest first.
    pub(crate) vectors: Vec<Vector>,
    /// The nearest inverse of what was not found.
    pub(crate) next: Option<f64>,
    /// Whether the signs of pivots confirm that none is missing.
    pub(crate) counted: bool,
    pub(crate) applied: usize,
    pub(crate) factorised: usize,
}

impl Answer<'_> {
    /// The nearest `count` vectors with those that lie as near as the last of them, and the nearest inverse of
    /// all others.
    pub(crate) fn needed(&mut self, count: usize) -> (Vec<Vector>, Option<f64>) {
        const AS_NEAR: f64 = 0.999;
        let mut vectors = std::mem::take(&mut self.vectors);
        if let Some(last) = vectors.get(count.saturating_sub(1)) {
            let edge = AS_NEAR * last.inverse.abs();
            let kept = vectors.partition_point(|vector| vector.inverse.abs() >= edge);
            let next = vectors.get(kept).map(|vector| vector.inverse);
            vectors.truncate(kept);
            return (vectors, next.or(self.next));
        }
        (vectors, self.next)
    }
}

/// Residuals at which a vector counts as found, relative to μ: shapes are then good to that, over
/// the distance to the next eigenvalue.
const TOLERANCE: f64 = 1e-12;

/// Eigenvalues nearest together than this part of their distance from the shift are not parted by a
/// count.
const APART: f64 = 1e-6;

/// The eigenvalues of smallest size.
pub(crate) fn lowest<'a>(wanted: &Wanted<'a>) -> Result<Answer<'a>, SparseError> {
    let factor = Factor::of(wanted.pencil, 0.0);
    let zeros = wanted.floating.len() + wanted.idle;
    let exact = wanted.pencil.stiffness.is_non_negative() && factor.zeros == zeros;
    if exact || (zeros == wanted.idle && factor.zeros == zeros && factor.least > FIRM) {
        return about(wanted, factor, 0.0, 1);
    }
    below_zero(wanted)
}

/// Pivots that are smaller in proportion to their terms make K as good as singular.
const FIRM: f64 = 1e-10;

/// From a shift below 0 of about a tenth of the largest eigenvalue looked for, for K that is singular
/// or nearly so.
fn below_zero<'a>(wanted: &Wanted<'a>) -> Result<Answer<'a>, SparseError> {
    let pencil = wanted.pencil;
    let diagonals = pencil.stiffness.diagonal().into_iter();
    let rates = diagonals
        .zip(pencil.mass.diagonal())
        .filter(|(_, mass)| *mass > 0.0)
        .map(|(stiffness, mass)| stiffness.abs() / mass);
    let mut shift = -1e-6 * rates.fold(0.0, f64::max);
    let mut factorised = 0;
    for _ in 0..8 {
        let factor = Factor::of(pencil, shift);
        factorised += 1;
        if !factor.is_finite() {
            break;
        }
        let operator = operator(wanted, factor.clone(), shift)?;
        let goal = Goal {
            wanted: wanted.count + 1,
            tolerance: 1e-3,
            seed: 3,
        };
        let found = lanczos(&operator, &[], goal).ok_or(SparseError::NoConvergence)?;
        let values = found
            .values
            .iter()
            .map(|inverse| (shift + 1.0 / inverse).abs());
        let largest = values.fold(0.0, f64::max);
        let fits = largest == 0.0 || (0.01..=1.0).contains(&(-shift / largest));
        if fits {
            return about(wanted, factor, shift, factorised);
        }
        shift = -0.1 * largest;
    }
    Err(SparseError::OutOfRange)
}

/// The eigenvalues nearest to `shift`, which is moved a little where it meets one.
pub(crate) fn nearest<'a>(wanted: &Wanted<'a>, shift: f64) -> Result<Answer<'a>, SparseError> {
    const MOVES: [f64; 5] = [0.0, 1e-9, -1e-8, 1e-7, 1e-6];
    for (tried, part) in MOVES.iter().enumerate() {
        let moved = shift * (1.0 + part);
        let factor = Factor::of(wanted.pencil, moved);
        if factor.zeros == wanted.idle && factor.least > FIRM {
            return about(wanted, factor, moved, tried + 1);
        }
    }
    Err(SparseError::OutOfRange)
}

fn operator<'a>(
    wanted: &Wanted<'a>,
    factor: Factor<'a>,
    shift: f64,
) -> Result<ShiftInvert<'a>, SparseError> {
    let operator = ShiftInvert::new(factor, wanted.pencil, shift);
    if wanted.floating.is_empty() {
        return Ok(operator);
    }
    let rigid = Rigid::of(wanted.floating, &wanted.pencil.mass);
    let rigid = rigid.ok_or(SparseError::TooManyParts {
        count: wanted.floating.len(),
    })?;
    Ok(operator.without(rigid))
}

fn about<'a>(
    wanted: &Wanted<'a>,
    factor: Factor<'a>,
    shift: f64,
    factorised: usize,
) -> Result<Answer<'a>, SparseError> {
    if !factor.is_finite() {
        return Err(SparseError::OutOfRange);
    }
    let mut search = Search {
        operator: operator(wanted, factor, shift)?,
        wanted,
        shapes: Vec::new(),
        inverses: Vec::new(),
        next: 0.0,
        exhausted: false,
        applied: 0,
        factorised,
    };
    // Of rigid motions as many as there are come for nothing.
    let rigid = wanted.floating.len();
    let besides = if shift <= 0.0 {
        wanted.count.saturating_sub(rigid)
    } else {
        wanted.count
    };
    if besides > 0 {
        search.run(besides)?;
    }
    let mut counted = false;
    for _ in 0..ROUNDS {
        if besides == 0 {
            // All that is wanted is exactly 0.
            counted = shift == 0.0;
            break;
        }
        match search.missing() {
            Missing::None => {
                counted = true;
                break;
            }
            Missing::Some(count) => search.run(count)?,
            Missing::Unknown => break,
        }
    }
    Ok(search.answer(counted))
}

/// So many times Lanczos' method is run again.
const ROUNDS: usize = 24;

struct Search<'a, 'w> {
    operator: ShiftInvert<'a>,
    wanted: &'w Wanted<'a>,
    shapes: Vec<Vec<f64>>,
    inverses: Vec<f64>,
    /// The largest inverse seen, in size, that was not found.
    next: f64,
    exhausted: bool,
    applied: usize,
    factorised: usize,
}

enum Missing {
    None,
    Some(usize),
    Unknown,
}

impl<'a> Search<'a, '_> {
    /// Finds so many more.
    fn run(&mut self, count: usize) -> Result<(), SparseError> {
        let goal = Goal {
            wanted: count,
            tolerance: TOLERANCE,
            seed: 0x9e37_79b9_7f4a_7c15 ^ (self.shapes.len() as u64 + 1),
        };
        let found = lanczos(&self.operator, &self.shapes, goal);
        let Found {
            values,
            vectors,
            next,
            applied,
            exhausted,
        } = found.ok_or(SparseError::NoConvergence)?;
        self.applied += applied;
        self.inverses.extend(values);
        self.shapes.extend(vectors);
        self.exhausted = exhausted;
        self.next = next.unwrap_or(0.0);
        Ok(())
    }

    /// How many eigenvalues are missing among the nearest.
    fn missing(&mut self) -> Missing {
        let shift = self.operator.shift;
        let mut distances: Vec<f64> = self
            .inverses
            .iter()
            .map(|inverse| 1.0 / inverse.abs())
            .collect();
        distances.extend(self.wanted.floating.iter().map(|_| shift.abs()));
        distances.sort_by(f64::total_cmp);
        let edge = if self.exhausted {
            f64::INFINITY
        } else {
            1.0 / self.next.abs()
        };
        let known = distances.len();
        if known < self.wanted.count && !self.exhausted {
            return Missing::Some(self.wanted.count - known);
        }
        let least = self.wanted.count.min(known);
        distances.retain(|distance| *distance <= edge);
        if distances.len() < least {
            return Missing::Some(2);
        }
        let upper = |at: usize| distances.get(at).copied().unwrap_or(edge);
        let gap = (least..=distances.len())
            .map(|at| (at, distances[at - 1], upper(at)))
            .find(|(_, below, above)| above - below > APART * below);
        let Some((expected, below, above)) = gap else {
            return Missing::Some(2);
        };
        // Beyond the last one there is room.
        let above = if above.is_finite() {
            above
        } else {
            1.5 * below
        };
        for part in [0.5, 0.37, 0.71] {
            let radius = below + part * (above - below);
            let Some(count) = self.count(shift, radius) else {
                continue;
            };
            return match count.cmp(&expected) {
                std::cmp::Ordering::Equal => Missing::None,
                std::cmp::Ordering::Greater => Missing::Some(count - expected),
                std::cmp::Ordering::Less => Missing::Unknown,
            };
        }
        Missing::Unknown
    }

    /// How many eigenvalues lie so near to the shift.
    fn count(&mut self, shift: f64, radius: f64) -> Option<usize> {
        let pencil = self.wanted.pencil;
        let mut below = |at: f64| {
            if at < 0.0 && pencil.stiffness.is_non_negative() {
                return Some(0);
            }
            self.factorised += 1;
            let factor = Factor::of(pencil, at);
            let clear =
                factor.is_finite() && factor.zeros == self.wanted.idle && factor.least > CLEAR;
            clear.then_some(factor.negative)
        };
        below(shift + radius)?.checked_sub(below(shift - radius)?)
    }

    fn answer(self, counted: bool) -> Answer<'a> {
        let pairs = self.inverses.into_iter().zip(self.shapes);
        let mut vectors: Vec<Vector> = pairs
            .map(|(inverse, shape)| Vector { inverse, shape })
            .collect();
        vectors.sort_by(|a, b| b.inverse.abs().total_cmp(&a.inverse.abs()));
        Answer {
            operator: self.operator,
            vectors,
            next: (!self.exhausted && self.next != 0.0).then_some(self.next),
            counted,
            applied: self.applied,
            factorised: self.factorised,
        }
    }
}

/// Pivots nearer to 0 in proportion to their terms have signs that rounding may have made.
const CLEAR: f64 = 1e-13;
