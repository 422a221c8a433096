//! Damping that couples shapes: roots near a few shifts come from Arnoldi's method on the whole equation, are refined
//! together with those beside them, and are counted in a ring about the target where that can be proved.

use eigentone_digits::sort_by_number;
use num_complex::Complex;

use super::answer::{Answer, Root, keep_nearest};
use super::arnoldi::Arnoldi;
use super::eigenpair::Eigenpair;
use super::error::SparseError;
use super::form::Form;
use super::inertia::{Inertia, Side};
use super::newton;
use super::pencil::Pencil;
use super::undamped::{Facts, Undamped};
use super::winding::{MANY, Winding};
use crate::modes::Repeats;

/// Natural frequencies about the target.
struct Ring {
    target: f64,
    /// How far from the target the last root that is wanted lies, and the next one.
    apart: [f64; 2],
    /// How many roots were found inside.
    found: usize,
}

impl Ring {
    /// The smallest and largest natural frequencies, with rims so far between the roots on either side.
    fn within(&self, part: f64) -> [f64; 2] {
        let [inner, outer] = self.apart;
        let reach = inner + part * (outer - inner);
        [(self.target - reach).max(0.0), self.target + reach]
    }
}

/// Those of damping that couples shapes.
pub(crate) fn coupled(
    found: &Undamped,
    undamped: &Pencil,
    damping: &Form,
) -> Result<Answer, SparseError> {
    const ROUNDS: usize = 6;
    let facts = &found.facts;
    let Pencil {
        stiffness, mass, ..
    } = undamped;
    let pencil = Pencil::of(stiffness.clone(), damping.clone(), mass.clone());
    let pencil = pencil.ok_or(SparseError::TooDense)?;
    let zeros = zeros(found, damping);
    // Motions that rounding alone holds are no measure.
    const HELD: f64 = 1e-4;
    /// So far from the target, in proportion to it, undamped modes have a shift of their own; nearer ones where they lie
    /// so many times as far from it as from each other.
    const FAR: f64 = 0.1;
    const LESS_FAR: f64 = 1e-3;
    const CROWDED: f64 = 10.0;
    let own = found.squares.iter().map(|square| square.abs().sqrt());
    let largest = own.clone().fold(0.0, f64::max);
    let held = own.clone().filter(|rate| *rate > HELD * largest);
    let rate = match facts.target {
        0.0 => held.fold(f64::INFINITY, f64::min),
        target => target,
    };
    let rate = match rate.is_finite() {
        true => rate,
        false => held_rate(undamped, facts).unwrap_or(1.0),
    };
    let shifts = match facts.target {
        0.0 => vec![Complex::from(0.1 * rate)],
        target => {
            const BESIDE: f64 = 1.0 + 1e-4;
            let oscillating = Complex::new(-1e-3, 1.0);
            let directions = [
                oscillating,
                Complex::new(-0.7, 0.7),
                Complex::new(-1.0, 0.0),
            ];
            let mut shifts = directions
                .map(|direction| direction * target * BESIDE)
                .to_vec();
            // From a target far from all modes they lie too close together to be parted.
            let apart = |rate: f64| (rate - target).abs();
            let rates = own.enumerate();
            let nearest = rates.min_by(|a, b| apart(a.1).total_cmp(&apart(b.1)));
            let farthest = found
                .squares
                .iter()
                .map(|square| apart(square.abs().sqrt()));
            let farthest = farthest.fold(0.0, f64::max);
            let is_far = |apart: f64| {
                apart > FAR * target
                    || apart > LESS_FAR * target && apart > CROWDED * (farthest - apart)
            };
            if let Some((at, rate)) = nearest
                && rate > 0.0
                && is_far(apart(rate))
            {
                let shape: Vec<f64> = found.shapes.col(at).iter().copied().collect();
                let half = Complex::from(0.5 * damping.quadratic(&shape));
                let root = (half * half - rate * rate).sqrt() - half;
                shifts.push(root * (1.0 + 1e-5));
            }
            shifts
        }
    };
    let wanted = match facts.target {
        0.0 => 2 * facts.count + zeros.roots + 6,
        _ => facts.count + 4,
    };
    let about = shifts.into_iter();
    let mut searches: Vec<Arnoldi<'_>> = about
        .filter_map(|shift| Arnoldi::about(&pencil, shift, rate))
        .collect();
    if searches.is_empty() {
        return Err(SparseError::OutOfRange);
    }
    let still = zeros.still(damping);
    searches.iter_mut().for_each(|search| search.lock(&still));
    let winding = winding(facts, undamped, damping);
    // Of hundreds that coincide all would have to be found, and refined together, for a few that are wanted.
    let bound = 2 * facts.count + 64;
    let mut more = wanted;
    let mut rounds = 0..ROUNDS;
    let (groups, count) = loop {
        let round = rounds.next();
        let came: usize = searches.iter_mut().map(|search| search.run(more)).sum();
        let goes_on = came > 0 && round.is_some();
        let groups = grouped(&searches, &zeros, facts.target);
        let all = groups.iter().flatten().map(pairs).sum::<usize>() + zeros.roots;
        let has_all_wanted =
            groups.iter().map(Vec::len).sum::<usize>() + zeros.roots >= facts.count;
        if facts.finite == Some(all) {
            let within = [0.0, f64::INFINITY];
            break (groups, Ok(Count { within, roots: all }));
        }
        let count = match (ring(&groups, zeros.roots, facts), &winding) {
            (None, _) if goes_on => continue,
            (None, _) => Err(unbounded(&groups, zeros.roots, facts)),
            (Some(_), Err(reason)) => Err(*reason),
            (Some(ring), Ok(winding)) => match counted(winding, &ring) {
                Some(count) if count.roots > ring.found && goes_on => {
                    let missing = count.roots - ring.found;
                    if missing > bound && has_all_wanted {
                        break (groups, Err(TOO_MANY));
                    }
                    more = missing.min(bound) + 2;
                    continue;
                }
                count => count.ok_or(NOT_ENCLOSED),
            },
        };
        // A second run finds second shapes of multiple roots.
        if count.is_err() && round == Some(0) && goes_on {
            more = 4;
            continue;
        }
        break (groups, count);
    };
    let entries = groups.iter().map(Vec::len).sum::<usize>() + zeros.roots;
    let known = groups.iter().flatten().map(pairs).sum::<usize>() + zeros.roots;
    let are_more = facts.finite.map_or(entries == 0, |finite| known < finite);
    if count.is_err() && entries < facts.count && are_more {
        return Err(SparseError::NoConvergence);
    }
    let mut roots: Vec<(usize, Root)> = zeros.entries().into_iter().map(|root| (0, root)).collect();
    let mut listed = roots.len();
    let still = if facts.target == 0.0 { 0 } else { listed };
    let mut of_group = 0;
    for group in groups {
        let size = group[0].value.norm();
        let inside = count
            .as_ref()
            .is_ok_and(|count| count.within[0] <= size && size <= count.within[1]);
        if listed >= facts.count + still && !inside {
            break;
        }
        listed += group.len();
        for part in parted(&pencil, group) {
            of_group += 1;
            let part = settled(part, facts.passive);
            roots.extend(part.into_iter().map(|root| (of_group, root)));
        }
    }
    let complete = count.and_then(|count| confirmed(&roots, &count));
    let mut roots: Vec<Root> = roots.into_iter().map(|(_, root)| root).collect();
    if complete.is_err() {
        roots.iter_mut().for_each(Root::may_have_more_beside);
    }
    keep_nearest(&mut roots, facts.target, facts.count);
    Ok(Answer { roots, complete })
}

/// The smallest natural frequency without damping of what is held, within a factor of 4, where none was looked for.
fn held_rate(undamped: &Pencil, facts: &Facts) -> Option<f64> {
    const STEP: f64 = 1.0 / 16.0;
    const STEPS: usize = 40;
    let inertia = Inertia::new(undamped, &facts.idle);
    let rows = undamped.stiffness.sizes().into_iter();
    let squares = rows.zip(undamped.mass.diagonal());
    let squares = squares.filter(|(_, mass)| *mass > 0.0);
    let mut square = squares.map(|(k, m)| k / m).fold(0.0, f64::max);
    let below = |square| inertia.below::<f64>(square, Side::AtLeast);
    let mut more = below(square)?;
    let mut lowest = None;
    // Counts fall as long as there is something lower that is held.
    for _ in 0..STEPS {
        let Some(fewer) = below(STEP * square) else {
            break;
        };
        if fewer < more {
            lowest = Some(square);
        }
        if facts.rigid == Some(fewer) {
            break;
        }
        (square, more) = (STEP * square, fewer);
    }
    lowest.map(f64::sqrt)
}

/// Refines a group; where that does not converge, as where another root lies hardly farther away than those of the
/// group, the parts of it that lie nearer together, each by itself, unless two of them lead to one root.
fn parted(pencil: &Pencil, group: Vec<Eigenpair>) -> Vec<Vec<newton::Root>> {
    const STEP: f64 = 1.0 / 16.0;
    /// What lies nearer together is not parted.
    const LEAST: f64 = 1e-9;
    let is_lost = |roots: &[newton::Root]| roots.iter().any(|root| root.error.is_none());
    let whole = newton::refined(pencil, group.clone());
    if !is_lost(&whole) {
        return vec![whole];
    }
    let mut done: Vec<Vec<newton::Root>> = Vec::new();
    let mut left = vec![(group, newton::NEAR)];
    while let Some((group, mut near)) = left.pop() {
        let mut parts = vec![group];
        while parts.len() == 1 && parts[0].len() > 1 && near > LEAST {
            near *= STEP;
            parts = joined(parts.remove(0), near, |root| root.value);
        }
        let is_last = parts.len() == 1;
        for part in parts {
            let refined = newton::refined(pencil, part.clone());
            match !is_last && part.len() > 1 && is_lost(&refined) {
                true => left.push((part, near)),
                false => done.push(refined),
            }
        }
    }
    let error = |root: &newton::Root| root.error.map_or(0.0, |(whole, _)| whole);
    let overlap = |one: &newton::Root, other: &newton::Root| {
        (one.value - other.value).norm() <= 4.0 * (error(one) + error(other))
    };
    let meets = |(k, part): (usize, &Vec<newton::Root>)| {
        let others = || done[..k].iter().flatten();
        part.iter()
            .any(|one| others().any(|other| overlap(one, other)))
    };
    match done.iter().enumerate().any(meets) {
        true => vec![whole],
        false => done,
    }
}

/// Those together that are joined by distances within a part of their size.
pub(crate) fn joined<T>(
    roots: impl IntoIterator<Item = T>,
    part: f64,
    value: impl Fn(&T) -> Complex<f64>,
) -> Vec<Vec<T>> {
    let mut groups: Vec<Vec<T>> = Vec::new();
    for root in roots {
        let at = value(&root);
        let near = |other: &T| (value(other) - at).norm() <= part * at.norm();
        let (beside, apart): (Vec<_>, Vec<_>) =
            groups.into_iter().partition(|group| group.iter().any(near));
        groups = apart;
        groups.push(beside.into_iter().flatten().chain([root]).collect());
    }
    groups
}

/// A count of roots in a ring that has those that are wanted of these groups, the nearest first.
pub(crate) fn count(
    groups: &[Vec<Eigenpair>],
    zeros: &Zeros,
    facts: &Facts,
    undamped: &Pencil,
    damping: &Form,
) -> Result<Count, &'static str> {
    let winding = winding(facts, undamped, damping)?;
    let lacks = || unbounded(groups, zeros.roots, facts);
    let ring = ring(groups, zeros.roots, facts).ok_or_else(lacks)?;
    counted(&winding, &ring).ok_or(NOT_ENCLOSED)
}

/// What counts lack.
const TOO_FEW: &str = "fewer roots were found than were asked for";
const ALL_AS_NEAR: &str =
    "no root was found beyond those that were asked for, up to which others could be counted";
const TOO_MANY: &str = "many more roots lie about as near as those that were asked for";
const NOT_ENCLOSED: &str = "the determinant along a circle could not be enclosed";

/// Why there is no ring.
fn unbounded(groups: &[Vec<Eigenpair>], zeros: usize, facts: &Facts) -> &'static str {
    let entries = groups.iter().map(Vec::len).sum::<usize>() + zeros;
    match entries < facts.count {
        true => TOO_FEW,
        false => ALL_AS_NEAR,
    }
}

/// How many roots have natural frequencies between two numbers.
pub(crate) struct Count {
    within: [f64; 2],
    roots: usize,
}

/// What counts roots in discs, or what a proof lacks.
fn winding<'a>(
    facts: &Facts,
    undamped: &'a Pencil,
    damping: &Form,
) -> Result<Winding<'a>, &'static str> {
    if !facts.has_sound_mass {
        return Err("the mass matrix is not proved to be positive semidefinite");
    }
    if !facts.passive && !damping.is_non_negative() {
        return Err("the damping matrix is not proved to be positive semidefinite");
    }
    if !facts.idle.is_empty() {
        return Err("a part has neither mass nor a spring to others");
    }
    Winding::of(undamped, damping).ok_or(MANY)
}

/// Counts roots in a ring, with rims near which det(λ²M + K) has no root.
fn counted(winding: &Winding<'_>, ring: &Ring) -> Option<Count> {
    [0.5, 0.37, 0.71].into_iter().find_map(|part| {
        let within = ring.within(part);
        let inside = |radius: f64| match radius > 0.0 {
            true => winding.inside(radius),
            false => Some(0),
        };
        let roots = inside(within[1])?.checked_sub(inside(within[0])?)?;
        Some(Count { within, roots })
    })
}

/// Whether refined roots, each with the group it belongs to, are all that were counted.
pub(crate) fn confirmed(roots: &[(usize, Root)], count: &Count) -> Result<(), &'static str> {
    let [low, high] = count.within;
    let mut inside: Vec<(usize, &Root, f64)> = Vec::new();
    for (group, root) in roots {
        let Some((error, _)) = root.error else {
            return Err("a root among them has no bound");
        };
        let size = root.value.norm();
        if size + error < high && (low == 0.0 || size - error > low) {
            inside.push((*group, root, error));
        } else if size - error <= high && size + error >= low {
            return Err("a root is not shown to lie inside or outside of the circle");
        }
    }
    for (k, (group, root, error)) in inside.iter().enumerate() {
        let same = |(other_group, other, other_error): &(usize, &Root, f64)| {
            group != other_group && (root.value - other.value).norm() <= error + other_error
        };
        if inside[..k].iter().any(same) {
            return Err("two roots among them are not separated");
        }
    }
    let known = |(_, root, _): &(usize, &Root, f64)| match root.value.im == 0.0 {
        true => root.roots,
        false => 2 * root.roots,
    };
    match inside.iter().map(known).sum::<usize>() == count.roots {
        true => Ok(()),
        false => Err("not as many roots were found as the count proves to be there"),
    }
}

/// Motions at λ = 0: K x = 0, with two roots where C x = 0 as well.
pub(crate) struct Zeros {
    shapes: Vec<Vec<f64>>,
    pub(crate) roots: usize,
    /// Whether some shape stands for two of them.
    double: bool,
}

pub(crate) fn zeros(found: &Undamped, damping: &Form) -> Zeros {
    let still = (0..found.squares.len())
        .filter(|&k| found.squares[k] == 0.0 && found.errors[k] == Some(0.0));
    let shapes: Vec<Vec<f64>> = still
        .map(|k| found.shapes.col(k).iter().copied().collect())
        .collect();
    let mut zeros = Zeros {
        shapes,
        roots: 0,
        double: false,
    };
    if zeros.shapes.is_empty() {
        return zeros;
    }
    let each = || {
        let still = zeros.still(damping).into_iter();
        still.map(|(_, is_free)| 1 + usize::from(is_free)).sum()
    };
    zeros.roots = found.facts.zero_roots.unwrap_or_else(each);
    zeros.double = zeros.roots > found.facts.rigid.unwrap_or(zeros.shapes.len());
    zeros
}

impl Zeros {
    /// The shapes, and whether no damper resists each.
    fn still(&self, damping: &Form) -> Vec<(&[f64], bool)> {
        let mut product = vec![0.0; self.shapes.first().map_or(0, Vec::len)];
        let mut is_free = |shape: &[f64]| {
            damping.apply(shape, &mut product);
            product.iter().all(|force| *force == 0.0)
        };
        let shapes = self.shapes.iter();
        shapes.map(|shape| (&shape[..], is_free(shape))).collect()
    }

    pub(crate) fn entries(&self) -> Vec<Root> {
        let count = self.roots;
        let root = |shape: &Vec<f64>, defective, roots| Root {
            value: Complex::ZERO,
            error: Some((0.0, 0.0)),
            shape: [shape.clone(), vec![0.0; shape.len()]],
            repeats: Repeats::Exactly {
                count,
                defective: Some(defective),
            },
            roots,
        };
        let shapes = self.shapes.iter();
        match self.double {
            true => shapes
                .take(1)
                .map(|shape| root(shape, true, count))
                .collect(),
            false => shapes.map(|shape| root(shape, false, 1)).collect(),
        }
    }
}

/// The roots that all searches found, those together that nearly coincide, the nearest to the target first, without
/// those at 0.
fn grouped(searches: &[Arnoldi<'_>], zeros: &Zeros, target: f64) -> Vec<Vec<Eigenpair>> {
    const SMALL: f64 = 1e-3;
    let each = searches.iter().enumerate().flat_map(|(k, search)| {
        let mut roots = search.roots();
        sort_by_number(&mut roots, |root| root.value.norm());
        let still = roots
            .iter()
            .take(zeros.roots)
            .filter(|root| root.value.norm() <= SMALL * search.rate())
            .count();
        roots.into_iter().skip(still).map(move |root| (k, root))
    });
    let groups = joined(each, newton::NEAR, |(_, root)| root.value);
    // Of what several searches found the one that found most is taken.
    let most = |group: Vec<(usize, Eigenpair)>| -> Vec<Eigenpair> {
        let found = |k: usize| group.iter().filter(|(search, _)| *search == k).count();
        let best = (0..searches.len()).rev().max_by_key(|&k| found(k));
        let own = |(k, root)| (Some(k) == best).then_some(root);
        group.into_iter().filter_map(own).collect()
    };
    let mut groups: Vec<Vec<Eigenpair>> = groups.into_iter().map(most).collect();
    let apart = |group: &Vec<Eigenpair>| (group[0].value.norm() - target).abs();
    sort_by_number(&mut groups, apart);
    groups
}

/// How many roots an approximate one stands for: with its conjugate, unless it is real.
fn pairs(root: &Eigenpair) -> usize {
    match root.value.im.abs() <= 1e-7 * root.value.norm() {
        true => 1,
        false => 2,
    }
}

/// A ring of natural frequencies about the target with at least so many entries as are wanted; `None` where too few were found.
fn ring(groups: &[Vec<Eigenpair>], zeros: usize, facts: &Facts) -> Option<Ring> {
    const APART: f64 = 1e-6;
    let mut sizes: Vec<(f64, usize)> = groups
        .iter()
        .flatten()
        .map(|root| (root.value.norm(), pairs(root)))
        .collect();
    sizes.extend((0..zeros).map(|_| (0.0, 1)));
    let apart = |size: f64| (size - facts.target).abs();
    sort_by_number(&mut sizes, |size| apart(size.0));
    let last = facts.count.min(sizes.len()).checked_sub(1)?;
    let whole = facts.target.max(sizes[last].0);
    let at = (last..sizes.len() - 1)
        .find(|&at| apart(sizes[at + 1].0) - apart(sizes[at].0) > APART * whole)?;
    Some(Ring {
        target: facts.target,
        apart: [apart(sizes[at].0), apart(sizes[at + 1].0)],
        found: sizes[..=at].iter().map(|(_, roots)| roots).sum(),
    })
}

/// Roots of a group, those that are not distinguished from real or imaginary ones made so, and without conjugates.
pub(crate) fn settled(roots: Vec<newton::Root>, passive: bool) -> Vec<Root> {
    let values: Vec<Complex<f64>> = roots.iter().map(|root| root.value).collect();
    let separated = |k: usize, error: f64| {
        let others = values.iter().enumerate().filter(|(j, _)| *j != k);
        others
            .map(|(_, other)| (values[k] - other).norm())
            .all(|apart| apart > 4.0 * error)
    };
    let mut all = Vec::new();
    for (k, root) in roots.into_iter().enumerate() {
        let mut value = root.value;
        let mut error = root.error;
        let mut repeats = Repeats::SIMPLE;
        if let Some((whole, real)) = &mut error {
            if !separated(k, *whole) {
                repeats = Repeats::Cluster(values.len());
            } else if value.im.abs() <= *whole {
                // The conjugate would be another root as near.
                value.im = 0.0;
            }
            if value.re.abs() <= *real || passive && value.re > 0.0 {
                *real += value.re.abs();
                *whole += value.re.abs();
                value.re = 0.0;
            }
        }
        if value.im < 0.0 {
            let whole = error.map_or(0.0, |(whole, _)| whole);
            let mate = |other: &Complex<f64>| (other.conj() - value).norm() <= 4.0 * whole;
            if values.iter().any(mate) {
                continue;
            }
            value = value.conj();
        }
        let (re, im) = root.shape.iter().map(|x| (x.re, x.im)).unzip();
        all.push(Root {
            value,
            error,
            shape: [re, im],
            repeats,
            roots: 1,
        });
    }
    all
}
