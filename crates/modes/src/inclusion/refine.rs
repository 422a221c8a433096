//! From approximate roots to proven discs, sweep by sweep and with more digits where they demand it.

use eigentone_digits::{Ball, Real};

use super::exactly::{exact, middle, radius, real, size, upper};
use super::weierstrass::{Inclusion, Points, Polynomial};

/// What a level of precision achieved.
pub(crate) enum Level<T> {
    /// Every disc meets the goal.
    Done(Vec<Inclusion<T>>),
    /// Proven discs, not all as small as asked.
    Proven(Vec<Inclusion<T>>),
    /// Nothing could be proved.
    Failed,
}

/// How small discs must become.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// Relative to |λ| and to |Re λ|.
    pub(crate) tolerance: f64,
    /// Where digits end, relative to |λ|: a real part below is not told from 0, and roots nearer to
    /// each other are one cluster.
    pub(crate) limit: f64,
    /// Whether real parts count.
    pub(crate) real_parts: bool,
}

impl Goal {
    /// Whether the disc is small enough: half of the tolerance, which leaves the other half for the
    /// rounding to double.
    pub(crate) fn meets<T: Real>(&self, disc: &Inclusion<T>) -> bool {
        let centre = disc.centre;
        let size = size(centre);
        let radius = radius(centre);
        if disc.members.len() > 1 {
            return radius <= self.limit * size;
        }
        let whole = radius <= 0.25 * self.tolerance * size;
        let re = centre.middle().re.to_f64().abs();
        let real = radius <= 0.25 * self.tolerance * re || radius <= 0.5 * self.limit * size;
        whole && (real || !self.real_parts || centre.middle().im.to_f64().abs() <= radius)
    }
}

/// Improves the points in the precision of T until all discs meet the goal, or the digits run out.
pub(crate) fn refine<T: Real>(
    polynomial: &Polynomial<T>,
    points: &mut Points<T>,
    goal: &Goal,
) -> Level<T> {
    const SWEEPS: usize = 150;
    const PLAIN: usize = 6;
    let mut best: Option<Vec<Inclusion<T>>> = None;
    let mut stuck = 0;
    let mut previous = f64::INFINITY;
    for sweep in 0..SWEEPS {
        separate(points);
        if points.correct(polynomial).is_none() {
            break;
        }
        let groups = points.groups();
        if let Some(discs) = points.include(&groups) {
            if discs.iter().all(|disc| goal.meets(disc)) {
                return Level::Done(discs);
            }
            if best.as_ref().is_none_or(|best| is_finer(&discs, best)) {
                best = Some(discs);
            }
        }
        let mut moved = false;
        let mut progress = 0f64;
        for group in &groups {
            moved |= if group.len() > 1 && sweep >= PLAIN {
                gather(points, group, goal)
            } else {
                step_all(points, group)
            };
            for &i in group {
                progress = progress.max(upper(points.corrections[i]) / size(points.z[i]));
            }
        }
        if !moved {
            break;
        }
        if sweep % PLAIN == PLAIN - 1 {
            break_symmetry(points);
        }
        stuck = if progress > 0.7 * previous {
            stuck + 1
        } else {
            0
        };
        previous = progress.min(previous);
        if stuck > 25 {
            break;
        }
    }
    match best {
        Some(discs) => Level::Proven(discs),
        None => Level::Failed,
    }
}

/// Real points cannot become a complex pair, nor a pair two different real points, as long as they
/// mirror each other: those far from any root are turned about 0 by angles of their own.
fn break_symmetry<T: Real>(points: &mut Points<T>) {
    const FAR: f64 = 1e-2;
    for i in 0..points.z.len() {
        if upper(points.corrections[i]) > FAR * size(points.z[i]) {
            let angle = if i % 2 == 0 { 0.5 } else { -0.3 } + 0.01 * i as f64;
            let turn = exact(T::from(angle.cos()), T::from(angle.sin()));
            points.place(i, points.z[i] * turn);
        }
    }
}

/// Points that coincide exactly are set apart.
fn separate<T: Real>(points: &mut Points<T>) {
    for i in 0..points.z.len() {
        for j in 0..i {
            let a = points.z[i];
            if a.middle() == points.z[j].middle() {
                let size = size(a).max(f64::MIN_POSITIVE);
                let angle = i as f64;
                let shift = exact(
                    T::from(1e-9 * size * angle.cos()),
                    T::from(1e-9 * size * angle.sin()),
                );
                points.place(i, a + shift);
            }
        }
    }
}

/// Moves a point to z − W, unless W is known to no digit; whether it moved.
fn step<T: Real>(points: &mut Points<T>, i: usize) -> bool {
    let w = points.corrections[i];
    let negligible = 2f64.powi(2 + T::UNIT_LOG2.max(-1000)) * size(points.z[i]);
    if size(w) <= 4.0 * radius(w) || size(w) <= negligible {
        return false;
    }
    let next = points.improved(i);
    points.place(i, next);
    true
}

/// Whether discs tell more roots apart than others, or as many within about as much.
fn is_finer<T: Real>(discs: &[Inclusion<T>], others: &[Inclusion<T>]) -> bool {
    let widest = |discs: &[Inclusion<T>]| {
        let relative = discs
            .iter()
            .map(|disc| radius(disc.centre) / size(disc.centre));
        relative.fold(0.0, f64::max)
    };
    let (more, as_many) = (discs.len() > others.len(), discs.len() == others.len());
    more || as_many && widest(discs) <= 2.0 * widest(others)
}

/// Moves a group of points that do not stand clear of each other; whether any moved. If its roots lie much closer
/// together than its points, these are gathered on a circle about their corrected mean that is as wide as the roots are apart;
/// else each takes its own step.
fn gather<T: Real>(points: &mut Points<T>, group: &[usize], goal: &Goal) -> bool {
    let m = group.len();
    let mut centre = Ball::ZERO;
    for &i in group {
        centre = centre + middle(points.improved(i));
    }
    let Some(share) = real::<T>(1.0).checked_div(real(m as f64)) else {
        return false;
    };
    let centre = middle(centre * share);
    let largest = |of: &dyn Fn(usize) -> f64| group.iter().map(|i| of(*i)).fold(0.0, f64::max);
    let spread = largest(&|i| upper(points.z[i] - centre));
    let correction = largest(&|i| upper(points.corrections[i]));
    // A point may stand on a root already: its own correction is then nothing but uncertainty.
    if largest(&|i| 5.0 * radius(points.corrections[i])) >= correction {
        return false;
    }
    let floor = goal.limit * size(centre) / (64.0 * points.z.len() as f64);
    let near = correction <= 1.5 * spread && spread <= 1e-2 * size(centre);
    if !near || spread <= floor {
        return step_all(points, group);
    }
    let reach = extent(points, group, centre).max(0.5 * floor);
    if reach > 0.5 * spread {
        return step_all(points, group);
    }
    for (k, &i) in group.iter().enumerate() {
        let angle = 0.7 + std::f64::consts::TAU * k as f64 / m as f64;
        let arm = exact(T::from(reach * angle.cos()), T::from(reach * angle.sin()));
        points.place(i, centre + arm);
    }
    true
}

/// How far the roots of a group lie from a centre, as far as digits tell: they are those of
///
/// q(c + x) = Π (x − (z_i − c)) + Σ W_i Π_{j≠i} (x − (z_j − c)) = x^m + q_1 x^(m−1) + … + q_m
///
/// but for what the points outside add, and the largest root x is max (|q_k|/(m over k))^(1/k) at least and a few times that
/// at most (Birkhoff 1914, *Bull. AMS* 21).
fn extent<T: Real>(points: &Points<T>, group: &[usize], centre: Ball<T>) -> f64 {
    let m = group.len();
    let arms: Vec<Ball<T>> = group.iter().map(|i| points.z[*i] - centre).collect();
    // Π (x − arm) of the first few, and what is added to it, by falling powers.
    let (mut whole, mut added) = (vec![real::<T>(1.0)], vec![Ball::ZERO]);
    for (arm, &i) in arms.iter().zip(group) {
        let times = |q: &[Ball<T>]| -> Vec<Ball<T>> {
            let shifted = (0..=q.len()).map(|k| {
                let kept = q.get(k).copied().unwrap_or(Ball::ZERO);
                match k.checked_sub(1) {
                    Some(before) => kept - q[before] * *arm,
                    None => kept,
                }
            });
            shifted.collect()
        };
        added = times(&added);
        for (k, coefficient) in whole.iter().enumerate() {
            added[k + 1] = added[k + 1] + *coefficient * points.corrections[i];
        }
        whole = times(&whole);
    }
    let mut choices = 1.0;
    let mut reach = 0f64;
    for k in 1..=m {
        choices *= (m + 1 - k) as f64 / k as f64;
        let q = whole[k] + added[k];
        // Roots that the digits leave open may be as far apart.
        let size = (size(q) + 16.0 * radius(q)) / choices;
        reach = reach.max(size.powf(1.0 / k as f64));
    }
    reach
}

/// Moves each point of a group; whether any moved.
fn step_all<T: Real>(points: &mut Points<T>, group: &[usize]) -> bool {
    let mut moved = false;
    for &i in group {
        moved |= step(points, i);
    }
    moved
}
