//! From approximate roots to proven discs, sweep by sweep and with more digits where they demand it.

use super::ball::{Ball, Real};
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
        let size = centre.re.to_f64().hypot(centre.im.to_f64());
        let radius = centre.radius;
        if disc.members.len() > 1 {
            return radius <= self.limit * size;
        }
        let whole = radius <= 0.25 * self.tolerance * size;
        let re = centre.re.to_f64().abs();
        let real = radius <= 0.25 * self.tolerance * re || radius <= 0.5 * self.limit * size;
        whole && (real || !self.real_parts || centre.im.to_f64().abs() <= radius)
    }
}

/// Improves the points in the precision of T until all discs meet the goal, or the digits run out.
pub(crate) fn refine<T: Real>(
    polynomial: &Polynomial<T>,
    points: &mut Points<T>,
    goal: &Goal,
) -> Level<T> {
    const SWEEPS: usize = 80;
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
            best = Some(discs);
        }
        let mut moved = false;
        let mut progress = 0f64;
        for group in &groups {
            moved |= if group.len() == 1 || sweep < PLAIN {
                group
                    .iter()
                    .fold(false, |moved, i| step(points, *i) || moved)
            } else {
                gather(points, group, goal)
            };
            for &i in group {
                let z = points.z[i];
                let size = z.re.to_f64().hypot(z.im.to_f64());
                progress = progress.max(points.corrections[i].upper() / size);
            }
        }
        if !moved {
            break;
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

/// Points that coincide exactly are set apart.
fn separate<T: Real>(points: &mut Points<T>) {
    for i in 0..points.z.len() {
        for j in 0..i {
            let (a, b) = (points.z[i], points.z[j]);
            if (a.re - b.re).to_f64() == 0.0 && (a.im - b.im).to_f64() == 0.0 {
                let size = a.re.to_f64().hypot(a.im.to_f64()).max(f64::MIN_POSITIVE);
                let angle = i as f64;
                let shift = Ball::exact(
                    T::from_f64(1e-9 * size * angle.cos()),
                    T::from_f64(1e-9 * size * angle.sin()),
                );
                points.place(i, a + shift);
            }
        }
    }
}

/// Moves a point to z − W, unless W is known to no digit; whether it moved.
fn step<T: Real>(points: &mut Points<T>, i: usize) -> bool {
    let w = points.corrections[i];
    let middle = w.re.to_f64().hypot(w.im.to_f64());
    let z = points.z[i];
    let size = z.re.to_f64().hypot(z.im.to_f64());
    if middle <= 4.0 * w.radius || middle <= 4.0 * T::unit() * size {
        return false;
    }
    let next = points.improved(i);
    points.place(i, next);
    true
}

/// Moves a group of points that do not stand clear of each other. If the corrections are no larger
/// than the group, its roots lie closer together than its points: the points are gathered on a
/// smaller circle about their corrected mean. Else each takes its own step.
fn gather<T: Real>(points: &mut Points<T>, group: &[usize], goal: &Goal) -> bool {
    let m = group.len();
    let mut centre = Ball::from_f64(0.0);
    for &i in group {
        let improved = points.improved(i);
        centre = centre + Ball::exact(improved.re, improved.im);
    }
    let Some(share) = Ball::<T>::from_f64(1.0).divide(Ball::from_f64(m as f64)) else {
        return false;
    };
    let centre = centre * share;
    let size = centre.re.to_f64().hypot(centre.im.to_f64());
    let spread = group
        .iter()
        .map(|i| (points.z[*i] - centre).upper())
        .fold(0.0, f64::max);
    let known = group.iter().all(|i| {
        let w = points.corrections[*i];
        w.re.to_f64().hypot(w.im.to_f64()) > 4.0 * w.radius
    });
    if !known {
        return false;
    }
    let correction = group
        .iter()
        .map(|i| points.corrections[*i].upper())
        .fold(0.0, f64::max);
    let tight = correction <= 1.5 * spread;
    let floor = goal.limit * size / (64.0 * points.z.len() as f64);
    if tight && spread > floor {
        let radius = (spread / 16.0).max(0.5 * floor);
        for (k, &i) in group.iter().enumerate() {
            let angle = 0.7 + std::f64::consts::TAU * k as f64 / m as f64;
            let arm = Ball::exact(
                T::from_f64(radius * angle.cos()),
                T::from_f64(radius * angle.sin()),
            );
            points.place(i, centre + arm);
        }
        return true;
    }
    let mut moved = false;
    for &i in group {
        moved |= step(points, i);
    }
    moved
}
