//! From approximate roots to proven discs, sweep by sweep and with more digits where they demand it.

use eigentone_digits::{Ball, Magnitude, Real, sort_by_number};

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
pub(crate) struct Goal<'a> {
    /// Relative to |λ| and to |Re λ|.
    pub(crate) tolerance: f64,
    /// Where digits end, relative to |λ|: a real part below is not distinguished from 0, and roots nearer to
    /// each other are one cluster.
    pub(crate) limit: f64,
    /// Whether real parts count.
    pub(crate) real_parts: bool,
    /// Which points have roots that are wanted; others only need discs apart from these.
    pub(crate) wanted: &'a [bool],
    /// After so many products no further sweep begins.
    pub(crate) most: u64,
}

impl Goal<'_> {
    /// Whether the disc of some points is small enough, or holds no root that is wanted: half of the tolerance, which leaves the other half for the
    /// rounding to double.
    pub(crate) fn meets<T: Real>(&self, members: &[usize], centre: Ball<T>) -> bool {
        if !members.iter().any(|member| self.wanted[*member]) {
            return true;
        }
        let size = size(centre);
        let radius = radius(centre);
        if members.len() > 1 {
            return radius <= self.limit * size;
        }
        let whole = radius <= 0.25 * self.tolerance * size;
        let re = centre.middle().re.to_f64().abs();
        let real = radius <= 0.25 * self.tolerance * re || radius <= 0.5 * self.limit * size;
        whole && (real || !self.real_parts || centre.middle().im.to_f64().abs() <= radius)
    }
}

/// Discs, and the points that they were found from.
type Found<T> = (Vec<Inclusion<T>>, Vec<Ball<T>>);

/// Improves the points in the precision of T until all discs meet the goal, or the digits run out.
pub(crate) fn refine<T: Real>(
    polynomial: &Polynomial<T>,
    points: &mut Points<T>,
    goal: &Goal<'_>,
) -> Level<T> {
    const SWEEPS: usize = 150;
    const PLAIN: usize = 6;
    let mut best: Option<Found<T>> = None;
    let mut scattered = false;
    let mut stuck = 0;
    let mut previous = f64::INFINITY;
    // How wide the last circle was that each point was put on.
    let mut circles = vec![f64::INFINITY; points.z.len()];
    for sweep in 0..SWEEPS {
        separate(points);
        if points.products >= goal.most || points.correct(polynomial).is_none() {
            break;
        }
        let groups = points.groups();
        if let Some(discs) = points.include(&groups) {
            if discs
                .iter()
                .all(|disc| goal.meets(&disc.members, disc.centre))
            {
                return Level::Done(discs);
            }
            if best.as_ref().is_none_or(|(best, _)| is_finer(&discs, best)) {
                best = Some((discs, points.z.clone()));
            }
        }
        // Before what is far off has led others away.
        scattered = (scattered || sweep % PLAIN == 0) && scatter(points);
        if scattered {
            continue;
        }
        let mut moved = false;
        let mut progress = 0f64;
        for group in &groups {
            moved |= if group.len() > 1 && sweep >= PLAIN {
                gather(points, group, &mut circles, goal)
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
        Some((discs, z)) => {
            // Where digits end, steps may have led away again.
            (0..z.len()).for_each(|i| points.place(i, z[i]));
            Level::Proven(discs)
        }
        None => Level::Failed,
    }
}

/// Whether the correction of a point is so large that no root is near it.
fn is_far<T: Real>(points: &Points<T>, i: usize) -> bool {
    const FAR: f64 = 1e-2;
    upper(points.corrections[i]) > FAR * size(points.z[i])
}

/// Places points far from any root whose size cannot be that of a root; whether there were any. Steps would take a point that is
/// orders of magnitude off back by a constant factor each, and lead others away.
///
/// The logarithms of the sizes of the roots of x^N + q_1 x^(N−1) + … + q_N are those slopes of the least concave majorant of log |q_k|
/// over k, to within a factor of 2N (Ostrowski 1940, *Acta Math.* 72), and good starting points (Bini 1996, *Numer. Algorithms* 13).
fn scatter<T: Real>(points: &mut Points<T>) -> bool {
    let mut order: Vec<usize> = (0..points.z.len()).collect();
    if !order.iter().any(|i| is_far(points, *i)) {
        return false;
    }
    let count = order.len();
    let heights = coefficients(points, &order, Ball::ZERO);
    let is_known = |height: &f64| !height.is_nan() && *height < f64::INFINITY;
    if !heights[count].is_finite() || !heights.iter().all(is_known) {
        return false;
    }
    sort_by_number(&mut order, |i| -size(points.z[*i]));
    let most = 4.0 * count as f64;
    let mut moved = false;
    let mut from = 0;
    while from < count {
        let slope = |to: usize| (heights[to] - heights[from]) / (to - from) as f64;
        // The last of equal slopes.
        let steeper = |a: &usize, b: &usize| slope(*a).total_cmp(&slope(*b)).then(a.cmp(b));
        let to = (from + 1..=count).max_by(steeper).expect("one lies beyond");
        let reach = slope(to).exp2();
        for (turn, &i) in order[from..to].iter().enumerate() {
            let ratio = size(points.z[i]) / reach;
            if is_far(points, i) && !(1.0 / most..=most).contains(&ratio) {
                let angle = 0.7 + std::f64::consts::TAU * turn as f64 / (to - from) as f64;
                let place = exact(T::from(reach * angle.cos()), T::from(reach * angle.sin()));
                points.place(i, place);
                moved = true;
            }
        }
        from = to;
    }
    moved
}

/// Real points cannot become a complex pair, nor a pair two different real points, as long as they
/// mirror each other: those far from any root are turned about 0 by angles of their own.
fn break_symmetry<T: Real>(points: &mut Points<T>) {
    for i in 0..points.z.len() {
        if is_far(points, i) {
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

/// Whether discs separate more roots than others, or as many within about as much.
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
/// else each takes its own step. So it does where the circle is not much narrower than the last one: where one root lies far from the
/// others, points on that circle are thrown out each time as far.
fn gather<T: Real>(
    points: &mut Points<T>,
    group: &[usize],
    circles: &mut [f64],
    goal: &Goal<'_>,
) -> bool {
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
    let narrowest = group.iter().map(|i| circles[*i]).fold(spread, f64::min);
    if reach > 0.5 * narrowest {
        return step_all(points, group);
    }
    for (k, &i) in group.iter().enumerate() {
        let angle = 0.7 + std::f64::consts::TAU * k as f64 / m as f64;
        let arm = exact(T::from(reach * angle.cos()), T::from(reach * angle.sin()));
        points.place(i, centre + arm);
        circles[i] = reach;
    }
    true
}

/// How far the roots of a group lie from a centre, as far as digits show: the largest root x of its
/// [polynomial](coefficients) is max (|q_k|/(m over k))^(1/k) at least and a few times that at most (Birkhoff 1914, *Bull. AMS* 21).
fn extent<T: Real>(points: &Points<T>, group: &[usize], centre: Ball<T>) -> f64 {
    let m = group.len();
    let mut choices = 1.0;
    let mut reach = 0f64;
    for (k, height) in coefficients(points, group, centre)
        .into_iter()
        .enumerate()
        .skip(1)
    {
        choices *= (m + 1 - k) as f64 / k as f64;
        reach = reach.max(((height - choices.log2()) / k as f64).exp2());
    }
    reach
}

/// log₂ |q_k| for k = 0 … m, as far as digits show, of the polynomial that has the roots of a group of m points,
///
/// q(c + x) = Π (x − (z_i − c)) + Σ W_i Π_{j≠i} (x − (z_j − c)) = x^m + q_1 x^(m−1) + … + q_m
///
/// but for what the points outside add.
fn coefficients<T: Real>(points: &Points<T>, group: &[usize], centre: Ball<T>) -> Vec<f64> {
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
    let sums = whole.into_iter().zip(added).map(|(a, b)| a + b);
    // Roots that the digits leave open may be as far apart.
    let size = |q: Ball<T>| q.upper() + q.radius() * Magnitude::power_of_two(4);
    sums.map(|q| size(q).log2()).collect()
}

/// Moves each point of a group; whether any moved.
fn step_all<T: Real>(points: &mut Points<T>, group: &[usize]) -> bool {
    let mut moved = false;
    for &i in group {
        moved |= step(points, i);
    }
    moved
}
