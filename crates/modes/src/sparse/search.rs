//! The eigenvalues λ = ω² of K x = λ M x nearest to a shift, and whether any was missed.
//!
//! The number of eigenvalues in an interval is the difference of the numbers of negative pivots of
//! K − τM at its ends, each proven from both sides. Where that is more than were found, Lanczos' method is run again with those that
//! were found locked (Grimes, Lewis & Simon 1994, *SIAM J. Matrix Anal. Appl.* 15, "A shifted block
//! Lanczos algorithm for solving sparse symmetric generalized eigenproblems").

use super::entry::Entry;
use super::error::SparseError;
use super::factor::{Factor, Sum};
use super::inertia::{Inertia, Side};
use super::lanczos::{Found, Goal, lanczos};
use super::operator::{Rigid, ShiftInvert};
use super::pencil::Pencil;
use eigentone_digits::{DoubleDouble, sort_by_number};

/// What is looked for.
#[derive(Clone, Debug)]
pub(crate) struct Wanted<'a> {
    pub(crate) pencil: &'a Pencil,
    /// Parts with mass that no spring ties to the ground.
    pub(crate) floating: &'a [Vec<usize>],
    /// Parts without mass that no spring ties to the ground.
    pub(crate) idle: &'a [Vec<usize>],
    /// Whether K is proved to be positive semidefinite, but for what lies far from the target.
    pub(crate) semidefinite: bool,
    /// The frequency they are to be near; 0 for the lowest.
    pub(crate) target: f64,
    pub(crate) count: usize,
}

impl Wanted<'_> {
    /// How far the natural frequency of ω² is from the target.
    pub(crate) fn apart(&self, square: f64) -> f64 {
        (square.abs().sqrt() - self.target).abs()
    }

    /// How far from the shift an eigenvalue can lie whose natural frequency is so near to the target, where
    /// none lies above the shift or some may.
    fn reach(&self, apart: f64, shift: f64, none_above: bool) -> f64 {
        let (low, high) = ((self.target - apart).max(0.0), self.target + apart);
        let above = match none_above {
            true => 0.0,
            false => high * high - shift,
        };
        let below = match self.semidefinite {
            true => shift - low * low,
            false => shift + high * high,
        };
        above.max(below).max(0.0)
    }
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
    /// Between which numbers the signs of pivots prove that none is missing.
    pub(crate) counted: Option<[f64; 2]>,
    pub(crate) applied: usize,
    pub(crate) factorised: usize,
}

impl Answer<'_> {
    /// The vectors that are wanted with all that lie as near to the shift, and the nearest inverse of all
    /// others.
    pub(crate) fn needed(&mut self, wanted: &Wanted<'_>) -> (Vec<Vector>, Option<f64>) {
        const AS_NEAR: f64 = 0.999;
        let mut vectors = std::mem::take(&mut self.vectors);
        let shift = self.operator.shift;
        let apart = |vector: &Vector| wanted.apart(shift + 1.0 / vector.inverse);
        let mut all: Vec<f64> = vectors.iter().map(apart).collect();
        sort_by_number(&mut all, |one| *one);
        if let Some(last) = all.get(wanted.count.saturating_sub(1)) {
            let near = vectors.iter().filter(|vector| apart(vector) <= *last);
            let edge = near
                .map(|vector| vector.inverse.abs())
                .fold(f64::INFINITY, f64::min);
            let kept = vectors.partition_point(|vector| vector.inverse.abs() >= AS_NEAR * edge);
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

/// Where a search starts.
struct Start<'a> {
    /// Of K − σM.
    factor: Factor<'a>,
    shift: f64,
    /// How many factors it took.
    factorised: usize,
    /// Up to here no eigenvalue lies above the shift, and what lies beyond is not wanted.
    empty_to: Option<f64>,
    /// Whether no eigenvalue is proved to lie below the shift.
    none_below: bool,
}

impl<'a> Start<'a> {
    fn at(shift: f64, factor: Factor<'a>, factorised: usize) -> Start<'a> {
        Start {
            factor,
            shift,
            factorised,
            empty_to: None,
            none_below: false,
        }
    }
}

/// The eigenvalues of smallest size.
pub(crate) fn lowest<'a>(wanted: &Wanted<'a>) -> Result<Answer<'a>, SparseError> {
    let factor = Factor::of(wanted.pencil, 0.0);
    if !is_regular(wanted, &factor) {
        return below_zero(wanted);
    }
    match about(wanted, Start::at(0.0, factor, 1)) {
        Err(SparseError::NoConvergence) => {
            about(wanted, raised(wanted).ok_or(SparseError::NoConvergence)?)
        }
        answer => answer,
    }
}

/// A start just below the smallest eigenvalue, where all lie far above 0: from there 1/(λ − σ) of those that lie close
/// together are parted, which they are not from 0.
fn raised<'a>(wanted: &Wanted<'a>) -> Option<Start<'a>> {
    /// Nearer to the smallest one doubles do not come.
    const NARROW: f64 = 1e-10;
    const STEPS: usize = 200;
    if !wanted.semidefinite || !wanted.floating.is_empty() {
        return None;
    }
    let inertia = Inertia::new(wanted.pencil, wanted.idle);
    let Pencil {
        stiffness, mass, ..
    } = wanted.pencil;
    // Some eigenvalue is as low as that of a coordinate that moves alone.
    let alone = stiffness.diagonal().into_iter().zip(mass.diagonal());
    let alone = alone.filter(|(_, mass)| *mass > 0.0);
    let lowest = alone.map(|(k, m)| k / m).fold(f64::INFINITY, f64::min);
    let (mut low, mut high) = (0.0, 2.0 * lowest);
    let mut factorised = 1;
    for _ in 0..STEPS {
        if high - low <= NARROW * high {
            break;
        }
        let middle = match low == 0.0 {
            true => high / 16.0,
            false => f64::midpoint(low, high),
        };
        if !middle.is_normal() {
            return None;
        }
        factorised += 1;
        match inertia.below::<f64>(middle, Side::AtMost) {
            Some(0) => low = middle,
            _ => high = middle,
        }
    }
    let factor = Factor::of(wanted.pencil, low);
    let start = Start::at(low, factor, factorised + 1);
    (low > 0.0 && is_firm(wanted, &start.factor)).then_some(Start {
        none_below: true,
        ..start
    })
}

/// Whether a factor of K serves, but for parts that nothing holds; one with more digits, where doubles lose too many.
fn is_regular(wanted: &Wanted<'_>, factor: &Factor<'_>) -> bool {
    let zeros = wanted.floating.len() + wanted.idle.len();
    let exact = wanted.pencil.stiffness.is_non_negative() && factor.zeros == zeros;
    let held = || wanted.floating.is_empty();
    exact || (held() && (is_firm(wanted, factor) || is_firm_long(wanted, factor, 0.0)))
}

/// Whether no pivot of a factor in doubles is 0 or nearly so, but those of parts without mass that nothing holds.
fn is_firm(wanted: &Wanted<'_>, factor: &Factor<'_>) -> bool {
    factor.zeros == wanted.idle.len() && factor.least > FIRM
}

/// The same of a factor with more digits than this one in doubles, where it is not too large for that.
fn is_firm_long(wanted: &Wanted<'_>, factor: &Factor<'_>, shift: f64) -> bool {
    /// So many multiplications for each entry of the factor cost no more in double-double than some solves in doubles.
    const CHEAP: f64 = 16.0;
    let ordering = &wanted.pencil.ordering;
    if !factor.is_finite() || ordering.work() > CHEAP * ordering.rows.len() as f64 {
        return false;
    }
    let long = Factor::<DoubleDouble>::sum(wanted.pencil, Sum::shifted(shift), &[]);
    long.zeros == wanted.idle.len() && long.least > FIRM * f64::EPSILON
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
            .take(goal.wanted)
            .map(|inverse| (shift + 1.0 / inverse).abs());
        let largest = values.fold(0.0, f64::max);
        let fits = largest == 0.0 || (0.01..=1.0).contains(&(-shift / largest));
        if fits {
            return about(wanted, Start::at(shift, factor, factorised));
        }
        shift = -0.1 * largest;
    }
    Err(SparseError::OutOfRange)
}

/// The eigenvalues nearest to that of the target.
pub(crate) fn nearest<'a>(wanted: &Wanted<'a>) -> Result<Answer<'a>, SparseError> {
    about(wanted, beside(wanted)?)
}

/// A start at the target, or beside it where K − σM is singular or a leading part of it is; or just above the
/// eigenvalues below the target, where none above it is wanted.
fn beside<'a>(wanted: &Wanted<'a>) -> Result<Start<'a>, SparseError> {
    const MOVES: [f64; 10] = [
        0.0, 1e-9, -1e-8, 1e-7, 1e-6, -1e-5, 1e-4, -3e-4, 1e-3, -3e-3,
    ];
    let shift = wanted.target * wanted.target;
    let shifts = MOVES.map(|part| shift * (1.0 + part));
    let mut factorised = 0;
    for moved in shifts {
        let factor = Factor::of(wanted.pencil, moved);
        factorised += 1;
        if is_firm(wanted, &factor) {
            let negative = factor.negative;
            let start = Start::at(moved, factor, factorised);
            return Ok(match lowered(wanted, negative) {
                Some(lowered) => Start {
                    factorised: factorised + lowered.factorised,
                    ..lowered
                },
                None => start,
            });
        }
    }
    for moved in shifts {
        let factor = Factor::of(wanted.pencil, moved);
        factorised += 2;
        if is_firm_long(wanted, &factor, moved) {
            return Ok(Start::at(moved, factor, factorised));
        }
    }
    Err(SparseError::OutOfRange)
}

/// A start just above the highest eigenvalue below the target, of which so many are expected, where they are enough and
/// none lies between the target and twice the target, beyond which all are farther than what lies below.
///
/// From a target far above them all 1/(λ − σ) are nearly alike, and Lanczos' method does not part them.
fn lowered<'a>(wanted: &Wanted<'a>, expected: usize) -> Option<Start<'a>> {
    /// Nearer to the highest one doubles do not come.
    const NARROW: f64 = 1e-10;
    const STEPS: usize = 200;
    let target = wanted.target * wanted.target;
    let empty_to = 4.0 * target;
    if !wanted.semidefinite || expected < wanted.count || !empty_to.is_finite() {
        return None;
    }
    let inertia = Inertia::new(wanted.pencil, wanted.idle);
    let mut factorised = 2;
    let most = inertia.below::<f64>(empty_to, Side::AtMost)?;
    if most != expected || inertia.below::<f64>(target, Side::AtLeast)? != most {
        return None;
    }
    let (mut low, mut high) = (0.0f64, target);
    let mut above = most;
    let mut ratio: f64 = 0.25;
    let mut further = 0;
    for _ in 0..STEPS {
        if further == 2 || high - low <= NARROW * high {
            break;
        }
        let middle = if low == 0.0 {
            ratio *= ratio;
            high * ratio
        } else if high > 4.0 * low {
            low.sqrt() * high.sqrt()
        } else {
            f64::midpoint(low, high)
        };
        if !middle.is_normal() {
            return None;
        }
        factorised += 1;
        match inertia.below::<f64>(middle, Side::AtLeast) {
            Some(below) if below >= most => high = middle,
            below => {
                low = middle;
                above = below.map_or(above, |below| most - below);
            }
        }
        further += usize::from(above <= wanted.count && high <= 4.0 * low);
    }
    let mut moved = high;
    let mut step = high - low;
    while moved < target {
        let factor = Factor::of(wanted.pencil, moved);
        factorised += 1;
        if is_firm(wanted, &factor) {
            return Some(Start {
                empty_to: Some(empty_to),
                ..Start::at(moved, factor, factorised)
            });
        }
        moved += step;
        step *= 4.0;
    }
    None
}

/// A search with nothing found yet, for eigenvalues of about such a size where the lowest are wanted.
pub(crate) fn begin<'a, 'w>(
    wanted: &'w Wanted<'a>,
    size: f64,
) -> Result<Search<'a, 'w>, SparseError> {
    let start = match wanted.target {
        0.0 => {
            let factor = Factor::of(wanted.pencil, 0.0);
            let below = -0.1 * size;
            match is_regular(wanted, &factor) {
                true => Start::at(0.0, factor, 1),
                false => Start::at(below, Factor::of(wanted.pencil, below), 2),
            }
        }
        _ => beside(wanted)?,
    };
    Search::new(wanted, start)
}

fn operator<'a>(
    wanted: &Wanted<'a>,
    factor: Factor<'a>,
    shift: f64,
) -> Result<ShiftInvert<'a>, SparseError> {
    let operator = ShiftInvert::new(factor, wanted.pencil, shift);
    let operator = match wanted.floating {
        [] => operator,
        parts => {
            let rigid = Rigid::of(parts, &wanted.pencil.mass);
            let count = parts.len();
            operator.without(rigid.ok_or(SparseError::TooManyParts { count })?)
        }
    };
    operator.accurate().ok_or(SparseError::OutOfRange)
}

fn about<'a>(wanted: &Wanted<'a>, start: Start<'a>) -> Result<Answer<'a>, SparseError> {
    let shift = start.shift;
    let mut search = Search::new(wanted, start)?;
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
    let counted = match besides {
        // All that is wanted is exactly 0.
        0 => (shift == 0.0 && wanted.semidefinite).then_some([0.0; 2]),
        _ => search.complete()?,
    };
    if search.lacks_some() {
        return Err(SparseError::NoConvergence);
    }
    Ok(search.answer(counted))
}

/// So many times Lanczos' method is run again.
const ROUNDS: usize = 24;

/// A search about a shift.
pub(crate) struct Search<'a, 'w> {
    pub(crate) operator: ShiftInvert<'a>,
    wanted: &'w Wanted<'a>,
    inertia: Inertia<'a>,
    shapes: Vec<Vec<f64>>,
    inverses: Vec<f64>,
    /// Up to here no eigenvalue lies above the shift, and what lies beyond is not wanted.
    empty_to: Option<f64>,
    /// Whether no eigenvalue is proved to lie below the shift.
    none_below: bool,
    /// The largest inverse seen, in size, that was not found.
    next: f64,
    exhausted: bool,
    applied: usize,
    factorised: usize,
}

enum Missing {
    /// None between these numbers.
    None([f64; 2]),
    Some(usize),
    Unknown,
}

impl<'a, 'w> Search<'a, 'w> {
    fn new(wanted: &'w Wanted<'a>, start: Start<'a>) -> Result<Search<'a, 'w>, SparseError> {
        let Start {
            factor,
            shift,
            factorised,
            empty_to,
            none_below,
        } = start;
        if !factor.is_finite() {
            return Err(SparseError::OutOfRange);
        }
        Ok(Search {
            operator: operator(wanted, factor, shift)?,
            wanted,
            inertia: Inertia::new(wanted.pencil, wanted.idle),
            shapes: Vec::new(),
            inverses: Vec::new(),
            empty_to,
            none_below,
            next: 0.0,
            exhausted: false,
            applied: 0,
            factorised,
        })
    }

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

    /// From shapes of M-norm 1 that are found, none of them rigid, with their eigenvalues: finds those among the wanted that
    /// a count says are missing.
    pub(crate) fn beside(mut self, found: Vec<(f64, Vec<f64>)>) -> Result<Answer<'a>, SparseError> {
        let shift = self.operator.shift;
        let known = found.len();
        for (square, shape) in found {
            self.inverses.push(1.0 / (square - shift));
            self.shapes.push(shape);
        }
        let counted = self.complete()?;
        if let (true, Some([low, _])) = (self.shapes.len() == known, counted) {
            // Beyond what was counted there may be others.
            self.next = 1.0 / (shift - low);
        }
        Ok(self.answer(counted))
    }

    /// Runs again until a count finds none missing; between which numbers.
    fn complete(&mut self) -> Result<Option<[f64; 2]>, SparseError> {
        for _ in 0..ROUNDS {
            match self.missing() {
                Missing::None(between) => return Ok(Some(between)),
                Missing::Some(count) => self.run(count)?,
                Missing::Unknown => break,
            }
        }
        Ok(None)
    }

    /// Whether fewer were found than are wanted although there are more, or none at all.
    fn lacks_some(&self) -> bool {
        let known = self.inverses.len() + self.wanted.floating.len();
        if known == 0 || known >= self.wanted.count {
            return known == 0;
        }
        let shift = self.operator.shift;
        let found = self.inverses.iter().map(|inverse| shift + 1.0 / inverse);
        let largest = found.fold(shift.abs(), |size, square| size.max(square.abs()));
        let least = self.inertia.below_either(4.0 * largest, Side::AtLeast);
        least.is_some_and(|least| least > known)
    }

    /// How many eigenvalues are missing among those that are wanted.
    fn missing(&mut self) -> Missing {
        let (wanted, shift) = (self.wanted, self.operator.shift);
        let found = self.inverses.iter().map(|inverse| shift + 1.0 / inverse);
        let squares: Vec<f64> = found.chain(wanted.floating.iter().map(|_| 0.0)).collect();
        let known = squares.len();
        if known < wanted.count && !self.exhausted {
            return Missing::Some(wanted.count - known);
        }
        let edge = match self.exhausted {
            true => f64::INFINITY,
            false => 1.0 / self.next.abs(),
        };
        let mut apart: Vec<f64> = squares.iter().map(|square| wanted.apart(*square)).collect();
        sort_by_number(&mut apart, |one| *one);
        let last = apart.get(wanted.count.min(known).saturating_sub(1));
        let reach = last.map_or(0.0, |last| match self.none_below {
            true => (wanted.target + last).powi(2) - shift,
            false => wanted.reach(*last, shift, self.empty_to.is_some()),
        });
        let mut distances: Vec<f64> = squares.iter().map(|s| (s - shift).abs()).collect();
        sort_by_number(&mut distances, |one| *one);
        distances.retain(|distance| *distance <= edge);
        let least = distances.partition_point(|d| *d <= reach * (1.0 + APART));
        if edge <= reach || distances.len() < wanted.count.min(known) {
            return Missing::Some(2 + known / 4);
        }
        let upper = |at: usize| distances.get(at).copied().unwrap_or(edge);
        let gap = (least.max(1)..=distances.len())
            .map(|at| (at, distances[at - 1].max(reach), upper(at)))
            .find(|(_, below, above)| above - below > APART * below);
        let Some((expected, below, above)) = gap else {
            return Missing::Some(2);
        };
        // Beyond the last one there is room.
        let above = match above.is_finite() {
            true => above,
            false => 1.5 * below,
        };
        for part in [0.5, 0.37, 0.71] {
            let radius = below + part * (above - below);
            let room = part.min(1.0 - part) * (above - below);
            match self.count(shift, radius, expected, room) {
                Some([least, most]) if least == expected && most == expected => {
                    let high = (shift + radius).max(self.empty_to.unwrap_or(0.0));
                    let low = match self.none_below {
                        true => (shift - radius).min(0.0),
                        false => shift - radius,
                    };
                    return Missing::None([low, high]);
                }
                Some([_, most]) if most > expected => return Missing::Some(most - expected),
                _ => {}
            }
        }
        Missing::Unknown
    }

    /// At least and at most how many eigenvalues lie so near to the shift. Doubles are trusted where they confirm
    /// what is expected, or what they round is small beside the room that there is.
    fn count(&mut self, shift: f64, radius: f64, expected: usize, room: f64) -> Option<[usize; 2]> {
        let count = self.between::<f64>(shift, radius);
        if count == Some([expected; 2]) {
            return count;
        }
        let noise = |shape: &Vec<f64>| self.inertia.noise(shift.abs() + radius, shape);
        let noise = self.shapes.iter().map(noise).fold(0.0, f64::max);
        if count.is_some() && noise < 0.1 * room {
            return count;
        }
        self.between::<DoubleDouble>(shift, radius)
    }

    fn between<T: Entry>(&mut self, shift: f64, radius: f64) -> Option<[usize; 2]> {
        let none_below = self.none_below || shift - radius < 0.0 && self.wanted.semidefinite;
        self.factorised += 2;
        let most = self.inertia.below::<T>(shift + radius, Side::AtMost)?;
        let least = self.inertia.below::<T>(shift + radius, Side::AtLeast)?;
        if none_below {
            return Some([least, most]);
        }
        self.factorised += 2;
        let most_below = self.inertia.below::<T>(shift - radius, Side::AtMost)?;
        let least_below = self.inertia.below::<T>(shift - radius, Side::AtLeast)?;
        Some([
            least.saturating_sub(most_below),
            most.saturating_sub(least_below),
        ])
    }

    fn answer(self, counted: Option<[f64; 2]>) -> Answer<'a> {
        let pairs = self.inverses.into_iter().zip(self.shapes);
        let mut vectors: Vec<Vector> = pairs
            .map(|(inverse, shape)| Vector { inverse, shape })
            .collect();
        sort_by_number(&mut vectors, |vector| -vector.inverse.abs());
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
