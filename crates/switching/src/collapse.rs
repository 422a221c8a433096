//! Which frictions give way where more of them hold than the motion has freedoms, so that their forces are not unique.
//!
//! They hold as long as some forces within their limits do (the static theorem of limit analysis: Prager and Hodge, Theory of
//! Perfectly Plastic Solids, 1951). Beyond that the forces are those of a convex quadratic program in a box (Moreau, C. R. Acad.
//! Sci. Paris 256, 1963, for Gauss's principle with constraints): accelerations are unique where forces are not. Principal
//! pivots at the least index solve it (Murty, Opsearch 11, 1974).

use eigentone_digits::Cholesky;
use faer::Mat;

/// What is added to the answer of each friction to its own force, so that forces are unique.
const COMPLIANCE: f64 = 1e-10;
/// What accelerates by more than this part of what the limits can do moves.
const MOVES: f64 = 1e-7;

/// And where something does, what accelerates by more than this part of that.
const ALONG: f64 = 1e-2;

/// Frictions whose ends are at rest to each other. Accelerations and forces are in units in which each force of 1 accelerates its
/// own ends by 1.
pub(crate) struct Grips {
    /// The accelerations of unit forces, by rows.
    answers: Vec<f64>,
    /// The unit of force of each, in those of the limits.
    units: Vec<f64>,
    /// The forces while sliding, and at rest.
    limits: Vec<[f64; 2]>,
}

/// What those can do that slid until now.
#[derive(Clone, Copy)]
pub(crate) enum Turned<'a> {
    /// Hold as all others.
    Rest,
    /// No more than while sliding.
    Sliding(&'a [bool]),
}

/// Forces, and the signs of accelerations.
struct Balance {
    forces: Vec<f64>,
    moves: Vec<i8>,
}

impl Grips {
    /// From the accelerations of unit forces, by rows, and the forces of sliding and at rest; `None` where a force moves nothing.
    pub(crate) fn of(mut answers: Vec<f64>, mut limits: Vec<[f64; 2]>) -> Option<Grips> {
        let count = limits.len();
        let units = (0..count).map(|i| answers[i * count + i].sqrt().recip());
        let units: Vec<f64> = units.collect();
        if !units.iter().all(|unit| unit.is_finite() && *unit > 0.0) {
            return None;
        }
        for (at, answer) in answers.iter_mut().enumerate() {
            *answer *= units[at / count] * units[at % count];
        }
        for (limits, unit) in limits.iter_mut().zip(&units) {
            *limits = limits.map(|limit| limit / unit);
        }
        Some(Grips {
            answers,
            units,
            limits,
        })
    }

    /// Which slide, by the signs of their rates, as accelerations without their forces run from `before` to `after`; `None` where
    /// that is not found.
    pub(crate) fn giving(
        &self,
        before: &[f64],
        after: &[f64],
        turned: Turned<'_>,
    ) -> Option<Vec<i8>> {
        /// How often a part of the way is halved.
        const HALVINGS: usize = 40;
        let mut slides = vec![0; self.units.len()];
        let on_the_way = |share: f64| -> Vec<f64> {
            let pairs = before.iter().zip(after).zip(&self.units);
            pairs
                .map(|((before, after), unit)| (before + share * (after - before)) * unit)
                .collect()
        };
        let mut from = 0.0;
        loop {
            let more = |share: f64, slides: &[i8]| {
                let moves = self.balance(&on_the_way(share), slides, turned)?.moves;
                let more: Vec<i8> = moves
                    .iter()
                    .zip(slides)
                    .map(|(moves, slides)| if *slides == 0 { *moves } else { 0 })
                    .collect();
                Some(more)
            };
            let mut until = 1.0;
            let mut gives = more(from, &slides)?;
            if gives.iter().any(|sign| *sign != 0) {
                until = from;
            } else {
                gives = more(until, &slides)?;
                if gives.iter().all(|sign| *sign == 0) {
                    return Some(slides);
                }
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (from + until);
                    let own = more(middle, &slides)?;
                    if own.iter().all(|sign| *sign == 0) {
                        from = middle;
                    } else {
                        (until, gives) = (middle, own);
                    }
                }
            }
            from = until;
            for (slides, gives) in slides.iter_mut().zip(gives) {
                *slides += gives;
            }
        }
    }

    /// Those that cannot hold beside the others, of those that slide, at accelerations without their forces. They are asked in
    /// this order, together with those that feel the same.
    pub(crate) fn returned(&self, free: &[f64], slides: &[i8], order: &[usize]) -> Option<Vec<i8>> {
        const SAME: f64 = 1.0 - 1e-9;
        let count = slides.len();
        let free: Vec<f64> = free.iter().zip(&self.units).map(|(a, b)| a * b).collect();
        let mut slides = slides.to_vec();
        let mut holds = |some: &dyn Fn(usize) -> bool| {
            let mut fewer = slides.clone();
            (0..count).filter(|k| some(*k)).for_each(|k| fewer[k] = 0);
            if fewer != slides {
                let moves = self.balance(&free, &fewer, Turned::Rest)?.moves;
                if (0..count).all(|k| fewer[k] != 0 || moves[k] == 0) {
                    slides = fewer;
                }
            }
            Some(())
        };
        for k in order {
            holds(&|other| self.answers[k * count + other].abs() > SAME)?;
            holds(&|other| other == *k)?;
        }
        Some(slides)
    }

    /// How those that do not slide share what they hold: `None` of those whose forces follow, of others the sign of a force at its
    /// limit.
    pub(crate) fn shares(&self, free: &[f64], slides: &[i8]) -> Option<Vec<Option<i8>>> {
        /// Beside 1, what is left of a force that others make up.
        const DEPENDENT: f64 = 1e-8;
        const NEAR: f64 = 1e-9;
        let count = slides.len();
        let free: Vec<f64> = free.iter().zip(&self.units).map(|(a, b)| a * b).collect();
        let mut forces = self.balance(&free, slides, Turned::Rest)?.forces;
        let most = |k: usize| self.limits[k][1];
        let mut fixed: Vec<Option<i8>> = vec![None; count];
        let mut basis: Vec<usize> = Vec::new();
        let mut rest: Vec<usize> = (0..count).filter(|k| slides[*k] == 0).collect();
        // Those farthest from their limits come first.
        let strain = |k: &usize| forces[*k].abs() / most(*k).max(f64::MIN_POSITIVE);
        rest.sort_by(|a, b| strain(a).total_cmp(&strain(b)));
        for k in rest {
            let mut way = self.made_up(&basis, k)?;
            let own = self.answers[k * count + k];
            let column = |j: &usize| self.answers[k * count + j];
            let left = own
                - basis
                    .iter()
                    .zip(&way)
                    .map(|(j, w)| column(j) * w)
                    .sum::<f64>();
            if left > DEPENDENT * own {
                basis.push(k);
                continue;
            }
            // A change of the forces that nothing feels, until one of them is at its limit.
            way.iter_mut().for_each(|way| *way = -*way);
            way.push(1.0);
            basis.push(k);
            if forces[k] < 0.0 {
                way.iter_mut().for_each(|way| *way = -*way);
            }
            let room = |at: usize| {
                let (force, way) = (forces[basis[at]], way[at]);
                match way.abs() > NEAR {
                    true => ((most(basis[at]) - way.signum() * force) / way.abs()).max(0.0),
                    false => f64::INFINITY,
                }
            };
            let first = (0..basis.len()).min_by(|a, b| room(*a).total_cmp(&room(*b)))?;
            let far = room(first);
            for (j, way) in basis.iter().zip(&way) {
                forces[*j] += far * way;
            }
            let at_limit = basis.remove(first);
            fixed[at_limit] = Some(if forces[at_limit] > 0.0 { 1 } else { -1 });
        }
        Some(fixed)
    }

    /// The forces of some that make up a unit force of another.
    fn made_up(&self, basis: &[usize], k: usize) -> Option<Vec<f64>> {
        let count = self.units.len();
        let right = |j: usize| self.answers[j * count + k];
        self.solve(basis, 0.0, &right)
    }

    /// The forces of some that answer with these accelerations.
    fn solve(&self, some: &[usize], more: f64, right: &dyn Fn(usize) -> f64) -> Option<Vec<f64>> {
        if some.is_empty() {
            return Some(Vec::new());
        }
        let count = self.units.len();
        let matrix = Mat::from_fn(some.len(), some.len(), |i, j| {
            let own = if i == j { more } else { 0.0 };
            self.answers[some[i] * count + some[j]] + own
        });
        let mut found = Mat::from_fn(some.len(), 1, |i, _| right(some[i]));
        let factor = Cholesky::of(matrix.as_ref())?;
        factor.divide_by_lower(found.as_mut());
        factor.divide_by_upper(found.as_mut());
        Some((0..some.len()).map(|i| found[(i, 0)]).collect())
    }

    /// The forces of least work at some accelerations without them; those that slide have the forces of that.
    fn balance(&self, free: &[f64], slides: &[i8], turned: Turned<'_>) -> Option<Balance> {
        /// How many pivots are tried.
        const MOST: usize = 2000;
        let count = slides.len();
        let limit = |k: usize| match turned {
            _ if slides[k] != 0 => self.limits[k][0],
            Turned::Sliding(slid) if slid[k] => self.limits[k][0],
            _ => self.limits[k][1],
        };
        // Of each, the sign of a force at its limit.
        let mut at: Vec<i8> = slides.iter().map(|sign| -sign).collect();
        for _ in 0..MOST {
            let inside: Vec<usize> = (0..count).filter(|k| at[*k] == 0).collect();
            let outside = |k: usize| -> f64 {
                let others = (0..count).filter(|j| at[*j] != 0);
                let pushed =
                    others.map(|j| self.answers[k * count + j] * f64::from(at[j]) * limit(j));
                free[k] + pushed.sum::<f64>()
            };
            let own = self.solve(&inside, COMPLIANCE, &|k| -outside(k))?;
            let mut forces: Vec<f64> = (0..count).map(|k| f64::from(at[k]) * limit(k)).collect();
            for (k, force) in inside.iter().zip(own) {
                forces[*k] = force;
            }
            let rate = |k: usize| {
                let row = &self.answers[k * count..(k + 1) * count];
                free[k] + row.iter().zip(&forces).map(|(a, f)| a * f).sum::<f64>()
            };
            let wrong = (0..count)
                .filter(|k| slides[*k] == 0)
                .find_map(|k| match at[k] {
                    0 if forces[k].abs() > limit(k) => {
                        Some((k, if forces[k] > 0.0 { 1 } else { -1 }))
                    }
                    0 => None,
                    // One at its limit is against what moves.
                    sign => {
                        let against = rate(k) + COMPLIANCE * forces[k];
                        (f64::from(sign) * against > 0.0).then_some((k, 0))
                    }
                });
            if let Some((k, sign)) = wrong {
                at[k] = sign;
                continue;
            }
            let size = (0..count).map(|k| self.limits[k][1]).fold(0.0, f64::max);
            let rates: Vec<f64> = (0..count).map(rate).collect();
            let largest = rates
                .iter()
                .fold(0.0, |most: f64, rate| most.max(rate.abs()));
            // Beside what just sets out, what goes with it more slowly does so too.
            let least = match largest > MOVES * size {
                true => (MOVES * size).min(ALONG * largest),
                false => f64::INFINITY,
            };
            let sign = |rate: &f64| {
                if rate.abs() <= least {
                    0
                } else {
                    rate.signum() as i8
                }
            };
            let moves = rates.iter().map(sign).collect();
            return Some(Balance { forces, moves });
        }
        None
    }
}
