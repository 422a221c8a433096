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
    // Sweeps for which points take plain steps after gathering them went too far.
    let mut pause = PLAIN;
    let mut gathered = false;
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
            best = Some(discs);
        }
        let mut moved = false;
        let mut now_gathered = false;
        let mut progress = 0f64;
        for group in &groups {
            if group.len() > 1 && pause == 0 {
                match gather(points, group, goal) {
                    Move::Gathered => (moved, now_gathered) = (true, true),
                    Move::Stepped => {
                        moved = true;
                        pause = if gathered {
                            2 * PLAIN + group.len()
                        } else {
                            pause
                        };
                    }
                    Move::None => {}
                }
            } else {
                moved |= step_all(points, group);
            }
            for &i in group {
                progress = progress.max(upper(points.corrections[i]) / size(points.z[i]));
            }
        }
        if !moved {
            break;
        }
        pause = pause.saturating_sub(1);
        gathered = now_gathered;
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

/// What became of a group.
enum Move {
    Gathered,
    Stepped,
    None,
}

/// Moves a group of points that do not stand clear of each other. If the corrections are no larger
/// than the group, its roots lie closer together than its points: the points are gathered on a
/// smaller circle about their corrected mean. Else each takes its own step.
fn gather<T: Real>(points: &mut Points<T>, group: &[usize], goal: &Goal) -> Move {
    let m = group.len();
    let mut centre = Ball::ZERO;
    for &i in group {
        centre = centre + middle(points.improved(i));
    }
    let Some(share) = real::<T>(1.0).checked_div(real(m as f64)) else {
        return Move::None;
    };
    let centre = centre * share;
    let spread = group
        .iter()
        .map(|i| upper(points.z[*i] - centre))
        .fold(0.0, f64::max);
    let correction = group
        .iter()
        .map(|i| upper(points.corrections[*i]))
        .fold(0.0, f64::max);
    // A point may stand on a root already: its own correction is then nothing but uncertainty.
    let known = group
        .iter()
        .all(|i| 5.0 * radius(points.corrections[*i]) < correction);
    if !known {
        return Move::None;
    }
    let tight = correction <= 1.5 * spread && spread <= 1e-2 * size(centre);
    let floor = goal.limit * size(centre) / (64.0 * points.z.len() as f64);
    if tight && spread > floor {
        let reach = (spread / 16.0).max(0.5 * floor);
        for (k, &i) in group.iter().enumerate() {
            let angle = 0.7 + std::f64::consts::TAU * k as f64 / m as f64;
            let arm = exact(T::from(reach * angle.cos()), T::from(reach * angle.sin()));
            points.place(i, centre + arm);
        }
        return Move::Gathered;
    }
    if step_all(points, group) {
        Move::Stepped
    } else {
        Move::None
    }
}

/// Moves each point of a group; whether any moved.
fn step_all<T: Real>(points: &mut Points<T>, group: &[usize]) -> bool {
    let mut moved = false;
    for &i in group {
        moved |= step(points, i);
    }
    moved
}
