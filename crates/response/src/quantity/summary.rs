//! What becomes of each coordinate: its peak, where it ends up, and when it has settled there.

use std::borrow::Cow;

use eigentone_digits::{Lu, svd};
use eigentone_modes::{Bounds, Modes, Motion, System};
use faer::Mat;

use super::afterwards::{Afterwards, afterwards};
use super::extrema::{Band, Extrema, Extremum, Fastest, followed, last_outside};
use super::later::stays;
use super::persistence::{Persistence, Sustained, sustained};
use crate::answer::Trajectory;
use crate::certified::follow::{Digits, Follower};
use crate::problem::{Floating, Load, Problem, equilibrium, equilibrium_rounding, reduced_angle};

/// Beside the largest displacement of the coordinate, a motion below this cannot be seen in a table
/// of six digits.
const VISIBLE: f64 = 1e-9;
/// Beside the largest displacement of all coordinates, a motion below this is rounding.
const ROUNDING: f64 = 1e-12;
/// Half a unit in the last of six digits.
const SHOWN: f64 = 5e-7;
/// The band around the end, in parts of the largest deviation from it, inside which a coordinate
/// counts as settled.
const BAND: f64 = 0.02;

/// A coordinate overshoots where it goes some way to its end: at least this part of its largest deviation from it.
const WAY: f64 = 0.1;

/// A trajectory in a few numbers for each coordinate.
///
/// ```
/// use eigentone_modes::{GROUND, System};
/// use eigentone_response::{Destination, Response, ResponsePlan, Step, Summary};
///
/// let system = System::builder()
///     .mass("m", 1.0)
///     .spring(GROUND, "m", 4.0)
///     .damper(GROUND, "m", 0.8)
///     .build()?;
/// let problem = Response::of(&system)
///     .load("m", Step::of(2.0))
///     .every(0.5)
///     .until(50.0)
///     .problem()?;
/// let motion = ResponsePlan::of(&problem)?.run(&problem)?;
/// let summary = Summary::of(&problem, &motion, &system.modes()?).ok_or("no instants")?;
/// match summary.coordinates()[0].destination {
///     Destination::Rest { displacement, settled, .. } => {
///         assert_eq!(displacement, 0.5);
///         assert!(settled < Some(10.0));
///     }
///     other => panic!("{other:?}"),
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    coordinates: Vec<CoordinateSummary>,
    means: Vec<Option<f64>>,
    /// Whether it is left open if a coordinate has settled.
    open: Vec<bool>,
    /// How far the places of rest may be off, about.
    about: Vec<f64>,
    extrema: Option<Extrema>,
}

/// One coordinate's motion in a few numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoordinateSummary {
    /// The displacement of largest magnitude, in m, with its sign; the first one on ties.
    pub peak: f64,
    /// When that is, in s.
    pub peak_time: f64,
    /// The velocity of largest magnitude, in m/s, with its sign; the first one on ties.
    pub fastest: f64,
    /// When that is, in s.
    pub fastest_time: f64,
    /// Where it ends up.
    pub destination: Destination,
}

/// Where a coordinate ends up under all loads, those to come after the last instant too.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Destination {
    /// It comes to rest.
    Rest {
        /// At this displacement in m, the equilibrium under the final constant loads.
        displacement: f64,
        /// The last time in s at which it is farther away than 2 % of the largest deviation until the end, 0 if
        /// there is none. `None` if it still is at the end or goes out again later, under all loads to come, and where
        /// [`Summary::is_open`] says that this is not known.
        settled: Option<f64>,
        /// How far it goes beyond the end, in parts of the way there from where it starts; `None`
        /// if it starts there, or so near that this way is less than a tenth of the largest deviation from the end.
        overshoot: Option<f64>,
    },
    /// It keeps oscillating.
    Oscillation,
    /// It moves away steadily, or ever faster, along a motion that no spring resists or under a
    /// load that grows steadily.
    Drift,
    /// It grows without limit: the system is unstable, or driven in resonance without damping.
    Growth,
    /// It is not known: a load changes so late that following the motion until then takes too long, or a damper is so small
    /// beside others that rounding decides where a body on it stops.
    Unknown,
}

/// Where a combination comes to rest under all loads, those to come after the last instant too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CombinationRest {
    /// At this value, in the unit of the combination.
    pub value: f64,
    /// The last time in s at which it is farther away than 2 % of the largest deviation until the end, 0 if there is none;
    /// `None` unless it is shown to stay nearer for all time after.
    pub settled: Option<f64>,
}

impl Summary {
    /// Sums up a trajectory of the problem; `modes` are those of its system. Peaks, velocities and settling are
    /// those of the motion itself, also between the instants, if the trajectory goes to the end of the
    /// grid, its bounds are proven and the motion can be followed; else those of the instants:
    /// [`is_between`](Self::is_between) says which. The last instant decides what keeps moving, of which
    /// what is too small to be seen in six digits is left out. `None` if there are no instants, or
    /// none by its index, for a [large](eigentone_modes::System::is_large) system, of which not all modes
    /// can be computed, and where the trajectory or the modes have another number of coordinates.
    pub fn of(problem: &Problem<'_>, trajectory: &Trajectory, modes: &Modes) -> Option<Summary> {
        let system = problem.system();
        let n = system.len();
        let (x, v) = (trajectory.displacement(), trajectory.velocity());
        let is_foreign = x.nrows() != n || modes.iter().any(|mode| mode.shape().len() != n);
        if system.is_large() || is_foreign {
            return None;
        }
        let latest = (0..trajectory.steps().len()).max_by_key(|&k| trajectory.steps()[k])?;
        let last = Last {
            time: trajectory.times()[latest],
            x: (0..n).map(|i| x[(i, latest)]).collect(),
            v: (0..n).map(|i| v[(i, latest)]).collect(),
            speed: v.norm_max(),
        };
        // What loads to come make of the motion they make after the last instant.
        let changes = problem.last_change() > last.time;
        let later = changes.then(|| afterwards(problem)).flatten();
        let is_known = !changes || later.is_some();
        let (lasting_problem, late) = match later {
            Some(Afterwards {
                problem,
                time,
                x,
                v,
            }) => {
                let speed = v.iter().fold(last.speed, |top, v| top.max(v.abs()));
                (Cow::Owned(problem), Last { time, x, v, speed })
            }
            None => (Cow::Borrowed(problem), last.clone()),
        };
        let now = sustained(&lasting_problem, late.time);
        let rigid = modes.iter().any(|mode| mode.motion() == Motion::Rigid);
        let floating = Floating::of(system, rigid);
        let state = (late.x.as_slice(), late.v.as_slice());
        let persistence = Persistence::of(system, modes, state, &now);
        let resisted = Resisted::of(system, &floating);
        let led = Course::of(system, &floating, &resisted, finally(&lasting_problem));
        let force = &led.force;
        let beside = led.taken_from(&late);
        let rest = come_to_rest(system, &floating, &resisted, force, &beside, &now);

        let all = x.norm_max();
        let end = problem.grid().time(problem.grid().last());
        let horizon = if end > 0.0 { end } else { 1.0 };
        let whole = trajectory.steps()[latest] == problem.grid().last();
        let mut follower = Follower::of(problem);
        let mut between = (whole && trajectory.bounds() == Bounds::Proven)
            .then(|| Extrema::with(&mut follower, Digits::Once, trajectory))
            .flatten();
        let mut ranges = Range::all(between.as_ref(), trajectory);
        let about = rest.rounding(system, &floating, force, &late);
        let seen = |i: usize| (VISIBLE * ranges[i].peak.displacement.abs()).max(ROUNDING * all);
        let course = |i: usize| {
            let seen = seen(i);
            let moved = led.moves(i, horizon) > seen || led.driven[i];
            if !is_known {
                Destination::Unknown
            } else if persistence.growth[i] > seen {
                Destination::Growth
            } else if rest.drifts[i] || moved {
                Destination::Drift
            } else if persistence.oscillation[i] > seen || !rest.displacement[i].is_finite() {
                Destination::Oscillation
            } else if rest.is_lost(i, about[i].min(VISIBLE * all)) {
                Destination::Unknown
            } else {
                Destination::Rest {
                    displacement: shown(rest.displacement[i], about[i]),
                    settled: None,
                    overshoot: None,
                }
            }
        };
        let mut destinations: Vec<Destination> = (0..n).map(course).collect();
        let end_of = |destination: Destination| match destination {
            Destination::Rest { displacement, .. } => Some(displacement),
            _ => None,
        };
        let ends: Vec<Option<f64>> = destinations.iter().copied().map(end_of).collect();
        // How far the distance of a coordinate from its end may be off.
        let noise = |between: Option<&Extrema>, i: usize| {
            let of_motion = match between {
                Some(extrema) => extrema.rounding(i),
                None => of_instants(trajectory).max(ROUNDING * all),
            };
            about[i] + of_motion
        };
        let width = |ranges: &[Range], between: Option<&Extrema>, i: usize, end: f64| {
            let (farthest, noise) = (ranges[i].deviation(end), noise(between, i));
            let is_outside = (last.x[i] - end).abs() > BAND * (farthest + noise) + noise;
            let stands = x.row(i).iter().all(|x| (x - end).abs() <= about[i]);
            Width::of(farthest, noise, [stands, is_outside])
        };
        let is_hard = ends.iter().enumerate().any(|(i, end)| {
            end.is_some_and(|end| width(&ranges, between.as_ref(), i, end).is_hard())
        });
        if let Some(closer) = between
            .as_ref()
            .filter(|_| is_hard)
            .and_then(|_| Extrema::with(&mut follower, Digits::Twice, trajectory))
        {
            ranges = Range::all(Some(&closer), trajectory);
            between = Some(closer);
        }
        for (i, destination) in destinations.iter_mut().enumerate() {
            if let Destination::Rest {
                displacement,
                overshoot,
                ..
            } = destination
            {
                let (start, noise) = (start(trajectory, i), noise(between.as_ref(), i));
                *overshoot = ranges[i].overshoot(start, *displacement, noise);
            }
        }
        let mean = |i: usize| match destinations[i] {
            Destination::Drift | Destination::Growth | Destination::Unknown => None,
            _ if rest.displacement[i].abs()
                <= noise(between.as_ref(), i).max(VISIBLE * ranges[i].peak.displacement.abs()) =>
            {
                Some(0.0)
            }
            _ => Some(rest.displacement[i]).filter(|mean| mean.is_finite()),
        };
        let means = (0..n).map(mean).collect();
        let mut lost = vec![false; n];
        let mut bands: Vec<Option<Band>> = vec![None; n];
        for (i, end) in ends.iter().enumerate() {
            let Some(centre) = *end else { continue };
            let width = width(&ranges, between.as_ref(), i, centre);
            lost[i] = width.is_lost();
            bands[i] = width.band(centre);
        }
        let digits = between.as_ref().map_or(Digits::Once, Extrema::digits);
        let between_samples = between.as_ref().and_then(|_| {
            let seen = bands.iter().enumerate().flat_map(|(i, band)| {
                band.map(|band| {
                    last_sample_outside(trajectory, i, &band).map_or(0, |(step, _)| step)
                })
            });
            // The step before is still outside, or the first. Samples have a bound that is common to all.
            let from = seen.min()?;
            let from = if digits == Digits::Once { from } else { 0 };
            last_outside(&mut follower, trajectory, from, digits, &bands)
        });
        let step = trajectory.steps()[latest];
        let mut settled: Vec<Option<f64>> = vec![None; n];
        for (i, band) in bands.iter().enumerate() {
            let Some(band) = band else { continue };
            let sample = last_sample_outside(trajectory, i, band);
            let at_the_end = sample.is_some_and(|(last, _)| last == step);
            settled[i] = match &between_samples {
                Some(last) if digits == Digits::Twice => last[i],
                _ if at_the_end => None,
                Some(last) => last[i],
                None => Some(sample.map_or(0.0, |(_, time)| time)),
            };
        }
        let inside: Vec<Option<Band>> = bands.into_iter().zip(&settled).map(inside).collect();
        let sizes = followed(problem, trajectory, n);
        let state = (last.x, last.v);
        let stays = stays(follower, modes, step, state, (&sizes, digits), &inside);
        let open = (0..n).map(|i| lost[i] || settled[i].is_some() && stays[i].is_none());
        let open = open.collect();
        for (i, destination) in destinations.iter_mut().enumerate() {
            if let Destination::Rest { settled: known, .. } = destination {
                *known = settled[i].filter(|_| stays[i] == Some(true));
            }
        }
        let peak = |i: usize| {
            let peak = ranges[i].peak;
            let noise = between.as_ref().map_or(0.0, |extrema| extrema.rounding(i));
            match shown(peak.displacement, noise) {
                0.0 => (0.0, 0.0),
                value => (value, peak.time),
            }
        };
        let coordinates = ranges.iter().zip(destinations).enumerate();
        let coordinates = coordinates.map(|(i, (range, destination))| CoordinateSummary {
            peak: peak(i).0,
            peak_time: peak(i).1,
            fastest: range.fastest.velocity,
            fastest_time: range.fastest.time,
            destination,
        });
        Some(Summary {
            coordinates: coordinates.collect(),
            means,
            open,
            about,
            extrema: between,
        })
    }

    /// Whether peaks and settling times are those of the motion itself, and not of its instants only.
    pub fn is_between(&self) -> bool {
        self.extrema.is_some()
    }

    /// The extrema and jumps that they come from, where they do not come from the instants.
    pub fn extrema(&self) -> Option<&Extrema> {
        self.extrema.as_ref()
    }

    /// One entry for each coordinate, in order.
    pub fn coordinates(&self) -> &[CoordinateSummary] {
        &self.coordinates
    }

    /// The displacement in m about which a coordinate moves once what decays has died out: the equilibrium under the loads
    /// that last, apart from what swings, that the motion leads to. 0 where it could not be seen. `None` where the coordinate
    /// drifts or grows, and where that is not known.
    pub fn mean(&self, coordinate: usize) -> Option<f64> {
        self.means[coordinate]
    }

    /// Whether it is left open when a coordinate settles: it is within its band at the end, and it is not known whether it stays
    /// there for all time, or its motion is so small beside the others that the digits do not show it.
    pub fn is_open(&self, coordinate: usize) -> bool {
        self.open[coordinate]
    }

    /// Where each combination of the problem comes to rest, as all that it combines does; else there is none, as for a
    /// difference of two that go away together. `problem`, `trajectory` and `modes` are those that were summed up. `None` where
    /// [`is_between`](Self::is_between) says so, and where combinations cannot be followed.
    pub fn combinations(
        &self,
        problem: &Problem<'_>,
        trajectory: &Trajectory,
        modes: &Modes,
    ) -> Option<Vec<Option<CombinationRest>>> {
        let extrema = self.extrema.as_ref()?;
        let n = self.coordinates.len();
        let supports = supports_at_rest(problem);
        let place = |i: usize| match i.checked_sub(n) {
            Some(support) => supports[support],
            None => match self.coordinates[i].destination {
                Destination::Rest { displacement, .. } => Some(displacement),
                _ => None,
            },
        };
        let before = if problem.wants_acceleration() {
            2 * n
        } else {
            n
        };
        let centres: Vec<Option<f64>> = problem
            .sources()
            .iter()
            .map(|source| {
                let terms = source.terms.iter().enumerate();
                let terms =
                    terms.flat_map(|(order, terms)| terms.iter().map(move |term| (order, term)));
                let values = terms.map(|(order, (i, [a, b]))| {
                    let place = place(*i)?;
                    Some(if order == 0 { a * b * place } else { 0.0 })
                });
                values.sum()
            })
            .collect();
        let width = |extrema: &Extrema, k: usize, centre: f64| {
            let peaks = extrema.output(k)?;
            let (high, low) = (peaks.highest, peaks.lowest);
            let farthest = (high.value - centre).abs().max((low.value - centre).abs());
            let places = problem.sources()[k].terms[0].iter();
            let about =
                places.map(|(i, [a, b])| (a * b * self.about.get(*i).unwrap_or(&0.0)).abs());
            let about: f64 = about.sum();
            let noise = high.bound.max(low.bound) + about;
            let mut values = trajectory.output(k).iter();
            let stands = values.all(|value| (value - centre).abs() <= about);
            Some(Width::of(farthest, noise, [stands, false]))
        };
        let asked = || {
            centres
                .iter()
                .take(problem.combinations().len())
                .enumerate()
        };
        let is_hard = asked().any(|(k, centre)| {
            let width = centre.and_then(|centre| width(extrema, k, centre));
            width.is_some_and(|width| width.is_hard())
        });
        let mut follower = Follower::of(problem);
        let closer = (is_hard && extrema.digits() == Digits::Once)
            .then(|| Extrema::with(&mut follower, Digits::Twice, trajectory))
            .flatten();
        let extrema = closer.as_ref().unwrap_or(extrema);
        let digits = extrema.digits();
        let mut bands = vec![None; before + problem.sources().len()];
        for (k, centre) in asked() {
            let Some(centre) = *centre else { continue };
            bands[before + k] = width(extrema, k, centre)?.band(centre);
        }
        let outputs = before..before + problem.combinations().len();
        let steps = trajectory.steps();
        let is_outside = |i: usize, k: usize| {
            let value = trajectory.output(i - before)[k];
            bands[i].is_some_and(|band: Band| band.excludes(value))
        };
        let latest = (0..steps.len()).max_by_key(|k| steps[*k])?;
        let last_seen = outputs.clone().filter(|i| bands[*i].is_some()).map(|i| {
            let outside = (0..steps.len()).filter(|k| is_outside(i, *k));
            outside.map(|k| steps[k]).max().unwrap_or(0)
        });
        let Some(from) = last_seen.min() else {
            let rest = |centre: &Option<f64>| {
                centre.map(|value| CombinationRest {
                    value,
                    settled: None,
                })
            };
            return Some(asked().map(|(_, centre)| rest(centre)).collect());
        };
        let from = if digits == Digits::Once { from } else { 0 };
        let last = last_outside(&mut follower, trajectory, from, digits, &bands)?;
        let is_within = |i: usize| digits == Digits::Twice || !is_outside(i, latest);
        let settled: Vec<Option<f64>> = (0..bands.len())
            .map(|i| last[i].filter(|_| outputs.contains(&i) && is_within(i)))
            .collect();
        let within: Vec<Option<Band>> = bands.iter().copied().zip(&settled).map(inside).collect();
        let state = [trajectory.displacement(), trajectory.velocity()];
        let [x, v] = state.map(|of| (0..n).map(|i| of[(i, latest)]).collect());
        let sizes = followed(problem, trajectory, bands.len());
        let step = steps[latest];
        let stays = stays(follower, modes, step, (x, v), (&sizes, digits), &within);
        let rests = outputs.map(|i| {
            Some(CombinationRest {
                value: centres[i - before]?,
                settled: settled[i].filter(|_| stays[i] == Some(true)),
            })
        });
        Some(rests.collect())
    }
}

/// A band of what seems to have settled.
fn inside((band, settled): (Option<Band>, &Option<f64>)) -> Option<Band> {
    band.filter(|_| settled.is_some())
}

/// The latest state, when that is in s, and the largest velocity of all.
#[derive(Clone, Debug)]
struct Last {
    time: f64,
    x: Vec<f64>,
    v: Vec<f64>,
    speed: f64,
}

/// The forces in N and all their derivatives, as of t = 0, once every load has begun and every sample has passed.
fn finally(problem: &Problem<'_>) -> Vec<Vec<f64>> {
    let n = problem.system().len();
    let end = problem.grid().time(problem.grid().last());
    let last = problem.timeline().pieces().len() - 1;
    let mut forces = problem.steady(last, end, true).to_vec();
    for order in 0..forces.len() {
        let (now, later) = forces.split_at_mut(order + 1);
        let mut way = 1.0;
        for (derivative, times) in later.iter().zip(1..) {
            way *= -end / f64::from(times);
            let pairs = now[order].iter_mut().zip(derivative);
            pairs.for_each(|(force, growth)| *force += growth * way);
        }
    }
    for (signal, [value, growth]) in lasting(problem) {
        let Some(channel) = signal.checked_sub(n) else {
            forces[0][signal] += value;
            forces[1][signal] += growth;
            continue;
        };
        let channel = &problem.channels()[channel];
        if channel.integrals == 0 {
            for &(row, factor) in &channel.directions[0] {
                forces[0][row] += factor * value;
                forces[1][row] += factor * growth;
            }
            let resisted = channel.directions[1].iter();
            resisted.for_each(|&(row, factor)| forces[0][row] += factor * growth);
        }
    }
    forces
}

/// What forces lead the system to, from them and all their derivatives as of t = 0.
struct Course {
    /// The force that springs hold, in N.
    force: Vec<f64>,
    /// The derivatives of the motion that follows the forces, from the velocity on.
    derivatives: Vec<Vec<f64>>,
    /// What moves because no spring holds it.
    driven: Vec<bool>,
}

impl Course {
    /// From the last derivative on, M x⁽ᵏ⁺²⁾ + C x⁽ᵏ⁺¹⁾ + K x⁽ᵏ⁾ = f⁽ᵏ⁾. What springs do not hold of a force is held by dampers, in a
    /// part of x⁽ᵏ⁺¹⁾ that no spring resists, or by masses, in one of x⁽ᵏ⁺²⁾ that no damper resists either; what these drag along
    /// springs hold back.
    fn of(
        system: &System,
        floating: &Floating,
        resisted: &Resisted,
        mut forces: Vec<Vec<f64>>,
    ) -> Course {
        let n = system.len();
        while forces.len() > 1
            && forces
                .last()
                .is_some_and(|force| force.iter().all(|f| *f == 0.0))
        {
            forces.pop();
        }
        let (mass, damping) = (system.mass_matrix(), system.damping_matrix());
        let free = Free::of(floating, resisted, &mass);
        let mut motions = vec![Mat::<f64>::zeros(n, 1); forces.len() + 2];
        let mut driven = vec![false; n];
        let mut drive = |motion: &Mat<f64>| {
            let moves = |(i, driven): (usize, &mut bool)| {
                *driven |= motion[(i, 0)].abs() > VISIBLE * motion.norm_max();
            };
            driven.iter_mut().enumerate().for_each(moves);
        };
        let mut held = Vec::new();
        for (order, force) in forces.into_iter().enumerate().rev() {
            let mut force = Mat::from_fn(n, 1, |i, _| force[i]);
            let mut sizes: Vec<f64> = (0..n).map(|i| force[(i, 0)].abs()).collect();
            for (matrix, motion) in [
                (&damping, &motions[order + 1]),
                (&mass, &motions[order + 2]),
            ] {
                force -= matrix * motion;
                for (i, size) in sizes.iter_mut().enumerate() {
                    let each = (0..n).map(|j| (matrix[(i, j)] * motion[(j, 0)]).abs());
                    *size += each.sum::<f64>();
                }
            }
            let along = resisted.left.transpose() * net(floating, &force, &sizes);
            let faster = free.motion(&along);
            drive(&faster);
            let inertia = &mass * &faster;
            let left = along - resisted.left.transpose() * (floating.left.transpose() * &inertia);
            let speeds = Mat::from_fn(left.nrows(), 1, |k, _| match resisted.values[k] {
                0.0 => 0.0,
                value => left[(k, 0)] / value,
            });
            let motion = &resisted.right * speeds;
            drive(&motion);
            force -= inertia + &damping * &motion;
            motions[order + 2] += faster;
            motions[order + 1] += motion;
            held = (0..n).map(|i| force[(i, 0)]).collect();
            let springs = equilibrium(system, floating, &held);
            motions[order] += Mat::from_fn(n, 1, |i, _| springs[i]);
        }
        // Without momentum.
        let momentum = free.left.transpose() * (&mass * &motions[1]);
        motions[1] -= &free.right * free.factors.solve(momentum);
        let derivatives = motions[1..].iter();
        let derivatives = derivatives.map(|motion| (0..n).map(|i| motion[(i, 0)]).collect());
        Course {
            force: held,
            derivatives: derivatives.collect(),
            driven,
        }
    }

    /// A state without what its derivatives have moved since t = 0.
    fn taken_from(&self, last: &Last) -> Last {
        let mut beside = last.clone();
        let mut way = 1.0;
        for (derivative, order) in self.derivatives.iter().zip(1..) {
            for (v, x) in beside.v.iter_mut().zip(derivative) {
                *v -= x * way;
            }
            way *= last.time / f64::from(order);
            for (place, x) in beside.x.iter_mut().zip(derivative) {
                *place -= x * way;
            }
        }
        beside
    }

    /// By how much a coordinate moves in a time, at most.
    fn moves(&self, i: usize, time: f64) -> f64 {
        let mut way = 1.0;
        let sizes = self.derivatives.iter().zip(1..).map(|(derivative, order)| {
            way *= time / f64::from(order);
            derivative[i].abs() * way
        });
        sizes.fold(0.0, f64::max)
    }
}

/// What loads leave of each signal, apart from what swings: as of t = 0, and its growth.
fn lasting<'a>(problem: &'a Problem<'_>) -> impl Iterator<Item = (usize, [f64; 2])> + 'a {
    problem.drives().iter().filter_map(|applied| {
        let of = match &applied.load {
            Load::Step(step) => [step.force, 0.0],
            // Forces that grow and stop growing leave what they have grown to.
            Load::Ramp(ramp) => [-ramp.rate * ramp.start, ramp.rate],
            Load::Samples(samples) => [samples.values.last().copied().unwrap_or(0.0), 0.0],
            Load::Harmonic(load) if load.frequency == 0.0 => {
                [load.amplitude * load.phase.sin(), 0.0]
            }
            Load::Harmonic(_)
            | Load::Impulse(_)
            | Load::HalfSine(_)
            | Load::Versine(_)
            | Load::Polynomial(_) => return None,
        };
        Some((applied.coordinate, of))
    })
}

/// Where each support stays; `None` where it does not, or where its velocity or acceleration is given.
fn supports_at_rest(problem: &Problem<'_>) -> Vec<Option<f64>> {
    let n = problem.system().len();
    let count = problem.system().supports().len();
    let mut motions = vec![Some([0.0; 2]); count];
    let support = |signal: usize| {
        let channel = &problem.channels()[signal.checked_sub(n)?];
        Some((channel.support?, channel.integrals == 0))
    };
    for applied in problem.drives() {
        let swings = matches!(&applied.load, Load::Harmonic(load) if load.frequency != 0.0);
        if let Some((support, is_given)) = support(applied.coordinate)
            && (swings || !is_given)
        {
            motions[support] = None;
        }
    }
    for (signal, [value, growth]) in lasting(problem) {
        if let Some([sum, rate]) = support(signal).and_then(|(at, _)| motions[at].as_mut()) {
            *sum += value;
            *rate += growth;
        }
    }
    let rest = |motion: Option<[f64; 2]>| motion.filter(|[_, rate]| *rate == 0.0);
    motions
        .into_iter()
        .map(|motion| Some(rest(motion)?[0]))
        .collect()
}

/// A value, or 0 where it is no more than what rounding may have made of 0.
fn shown(value: f64, rounding: f64) -> f64 {
    match value.abs() <= rounding {
        true => 0.0,
        false => value,
    }
}

/// Where the coordinates stay, and which of them do not.
struct Rest {
    displacement: Vec<f64>,
    drifts: Vec<bool>,
    /// How far rounding may have moved each place along what dampers alone resist: the smaller a damper beside others, the
    /// farther.
    carried: Vec<f64>,
}

impl Rest {
    /// Whether the place is known neither to six digits nor to be 0, which places below `nothing` are.
    fn is_lost(&self, i: usize, nothing: f64) -> bool {
        let place = self.displacement[i].abs();
        self.carried[i] > SHOWN * place && place.max(self.carried[i]) > nothing
    }

    /// What rounding may have moved each place, about.
    fn rounding(
        &self,
        system: &System,
        floating: &Floating,
        force: &[f64],
        last: &Last,
    ) -> Vec<f64> {
        let mut rounding = equilibrium_rounding(system, floating, force);
        if floating.right.ncols() > 0 {
            let all = self.displacement.iter().chain(&last.x);
            let all = all.fold(0.0f64, |top, x| top.max(x.abs()));
            let own = rounding.iter_mut().zip(&self.carried);
            own.for_each(|(own, carried)| *own += ROUNDING * all + carried);
        }
        rounding
    }
}

/// The motions that no spring resists, seen through the dampers: the singular values and vectors
/// of WᵀCN, descending; as many as are proved to be 0 are, or where that is not proved those that are rounding errors.
struct Resisted {
    values: Vec<f64>,
    left: Mat<f64>,
    right: Mat<f64>,
}

impl Resisted {
    /// Without floating parts, or should the decomposition fail, there are none.
    fn of(system: &System, floating: &Floating) -> Resisted {
        let damping = system.damping_matrix();
        let reduced = floating.left.transpose() * &damping * &floating.right;
        let d = reduced.nrows();
        // For K, C ⪰ 0 there are dim N(K) + dim (N(K) ∩ N(C)) roots at 0.
        let structure = system.structure();
        let applies = structure.is_passive()
            && structure.is_symmetric()
            && structure.rigid_motions_counted() == Some(d);
        let proved = structure.zero_roots().filter(|_| applies);
        let proved = proved.and_then(|zeros| zeros.checked_sub(d));
        let limit = 4.0 * (system.len() * d) as f64 * f64::EPSILON * damping.norm_max();
        match svd(reduced.as_ref()) {
            Some(svd) if d > 0 => Resisted {
                values: (0..d)
                    .map(|k| (k, svd.S().column_vector()[k]))
                    .map(|(k, value)| match proved {
                        Some(free) if k + free >= d => 0.0,
                        None if value <= limit => 0.0,
                        _ => value,
                    })
                    .collect(),
                left: svd.U().to_owned(),
                right: &floating.right * svd.V(),
            },
            _ => Resisted {
                values: Vec::new(),
                left: Mat::zeros(d, 0),
                right: Mat::zeros(system.len(), 0),
            },
        }
    }
}

/// The motions that neither springs nor dampers resist.
struct Free {
    /// Their places among those that no spring resists.
    places: Vec<usize>,
    left: Mat<f64>,
    right: Mat<f64>,
    /// Of the mass matrix in them.
    factors: Lu<f64>,
}

impl Free {
    fn of(floating: &Floating, resisted: &Resisted, mass: &Mat<f64>) -> Free {
        let values = resisted.values.iter().enumerate();
        let places = values.filter(|(_, value)| **value == 0.0);
        let places: Vec<usize> = places.map(|(k, _)| k).collect();
        let chosen = |of: &Mat<f64>| {
            let count = places.len();
            Mat::from_fn(of.nrows(), count, |i, k| of[(i, places[k])])
        };
        let left = chosen(&(&floating.left * &resisted.left));
        let right = chosen(&resisted.right);
        let factors = Lu::of((left.transpose() * mass * &right).as_ref());
        Free {
            places,
            left,
            right,
            factors,
        }
    }

    /// The acceleration under a force with these parts along all that no spring resists.
    fn motion(&self, along: &Mat<f64>) -> Mat<f64> {
        let own = Mat::from_fn(self.places.len(), 1, |k, _| along[(self.places[k], 0)]);
        &self.right * self.factors.solve(own)
    }
}

/// The equilibrium under `force`, which springs hold, that the latest state leads to, were there only decaying motions
/// and those that no spring resists. Along these, WᵀCx + WᵀMv does not change; where no damper
/// resists either, that is a momentum, and without one the centre of mass stays.
fn come_to_rest(
    system: &System,
    floating: &Floating,
    resisted: &Resisted,
    force: &[f64],
    last: &Last,
    now: &Sustained,
) -> Rest {
    let n = system.len();
    let mut x = equilibrium(system, floating, force);
    let mut drifts = vec![false; n];
    let mut carried = vec![0.0; n];
    if resisted.values.is_empty() {
        return Rest {
            displacement: x,
            drifts,
            carried,
        };
    }
    let (mass, damping) = (system.mass_matrix(), system.damping_matrix());
    let away = |x: &[f64]| Mat::from_fn(n, 1, |i, _| last.x[i] - x[i]);
    let velocity = Mat::from_fn(n, 1, |i, _| last.v[i]);
    let mut sizes = size(&damping) * size(&away(&x)) + size(&mass) * size(&velocity);
    let mut kept = floating.left.transpose() * (&damping * away(&x) + &mass * velocity);
    for (coordinate, load) in &now.harmonics {
        // A sinusoidal load swings it about this mean.
        let angle = reduced_angle(load.frequency, now.time, load.phase);
        let swing = load.amplitude / load.frequency * angle.cos();
        (0..kept.nrows()).for_each(|k| kept[(k, 0)] += floating.left[(*coordinate, k)] * swing);
        sizes[(*coordinate, 0)] += swing.abs();
    }
    let kept = resisted.left.transpose() * kept;
    let left = &floating.left * &resisted.left;
    // Of several singular vectors no entry is closer than a unit of the largest.
    let count = resisted.values.len();
    let mixed = Mat::from_fn(count, count, |_, _| if count > 1 { 1.0 } else { 0.0 });
    let right = size(&resisted.right) + size(&floating.right) * &mixed;
    let sides = (size(&left) + size(&floating.left) * &mixed)
        .transpose()
        .to_owned();
    let (sizes, dampers) = (&sides * sizes, &sides * size(&damping) * &right);
    let unit = 4.0 * n as f64 * f64::EPSILON;
    let still = ROUNDING * last.speed * n as f64 * mass.norm_max();
    let mut centred = Vec::new();
    for (k, value) in resisted.values.iter().enumerate() {
        if *value != 0.0 {
            let far = kept[(k, 0)] / value;
            let lost = unit * (sizes[(k, 0)] + far.abs() * dampers[(k, k)]) / value;
            let moved = (0..n).map(|i| (resisted.right[(i, k)], right[(i, k)]));
            for ((x, carried), (by, around)) in x.iter_mut().zip(&mut carried).zip(moved) {
                *x += far * by;
                *carried += lost * by.abs() + unit * far.abs() * (around - by.abs());
            }
        } else if kept[(k, 0)].abs() > still {
            for (i, drifts) in drifts.iter_mut().enumerate() {
                *drifts |= resisted.right[(i, k)].abs() > VISIBLE;
            }
        } else {
            centred.push(k);
        }
    }
    let left = Mat::from_fn(n, centred.len(), |i, k| left[(i, centred[k])]);
    let right = Mat::from_fn(n, centred.len(), |i, k| resisted.right[(i, centred[k])]);
    let moment = left.transpose() * &mass;
    let factors = Lu::of((&moment * &right).as_ref());
    let shift = &right * factors.solve(moment * away(&x));
    let scale = last.x.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    for (i, x) in x.iter_mut().enumerate() {
        *x += shift[(i, 0)];
        if x.abs() <= ROUNDING * scale {
            *x = 0.0; // what differences of places leave
        }
    }
    Rest {
        displacement: x,
        drifts,
        carried,
    }
}

/// The absolute value of each entry.
fn size(of: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(of.nrows(), of.ncols(), |i, j| of[(i, j)].abs())
}

/// The net force on each floating motion; what is rounding beside the sizes of what it is made of is 0.
fn net(floating: &Floating, force: &Mat<f64>, sizes: &[f64]) -> Mat<f64> {
    let net = floating.left.transpose() * force;
    Mat::from_fn(net.nrows(), 1, |k, _| {
        let parts = (0..sizes.len()).map(|i| floating.left[(i, k)].abs() * sizes[i]);
        shown(net[(k, 0)], ROUNDING * parts.sum::<f64>())
    })
}

/// How wide a band is beside what is not known of a distance.
enum Width {
    /// It stands at every instant, and nothing shows that it moves between them: so wide that it does not.
    Still(f64),
    /// Known well enough, or not but outside at the end in any case.
    Known(f64),
    /// Known to three digits and not to six.
    Hard(f64),
    /// Not known to three digits.
    Lost,
}

impl Width {
    /// For the largest distance, how far it may be off, and whether it stands at all instants, and is outside at the end in any
    /// case.
    fn of(farthest: f64, noise: f64, [stands, is_outside]: [bool; 2]) -> Width {
        const SIX: f64 = 1e5;
        const THREE: f64 = 1e3;
        let half_width = BAND * farthest;
        if stands && farthest <= noise && noise.is_finite() {
            Width::Still(noise)
        } else if is_outside || half_width >= SIX * noise {
            Width::Known(half_width)
        } else if half_width >= THREE * noise {
            Width::Hard(half_width)
        } else {
            Width::Lost
        }
    }

    /// Whether more digits would tell more.
    fn is_hard(&self) -> bool {
        !matches!(self, Width::Still(_) | Width::Known(_))
    }

    fn is_lost(&self) -> bool {
        matches!(self, Width::Lost)
    }

    fn band(&self, centre: f64) -> Option<Band> {
        match *self {
            Width::Still(half_width) | Width::Known(half_width) | Width::Hard(half_width) => {
                Some(Band { centre, half_width })
            }
            Width::Lost => None,
        }
    }
}

/// How far any displacement at an instant may be off.
fn of_instants(trajectory: &Trajectory) -> f64 {
    let bounds = trajectory.displacement_bound().iter();
    bounds.fold(0.0, |top, bound| bound.unwrap_or(f64::INFINITY).max(top))
}

/// Where a coordinate goes.
struct Range {
    peak: Extremum,
    highest: f64,
    lowest: f64,
    fastest: Fastest,
}

impl Range {
    /// Of all coordinates, at any time or among the instants alone.
    fn all(between: Option<&Extrema>, trajectory: &Trajectory) -> Vec<Range> {
        let count = trajectory.displacement().nrows();
        let range = |i: usize| match between {
            Some(extrema) => Range {
                peak: extrema.peak(i),
                highest: extrema.highest()[i].displacement,
                lowest: extrema.lowest()[i].displacement,
                fastest: extrema.fastest()[i],
            },
            None => Range::of_instants(trajectory, i),
        };
        (0..count).map(range).collect()
    }

    /// Among the instants alone.
    fn of_instants(trajectory: &Trajectory, i: usize) -> Range {
        let first = Extremum {
            displacement: 0.0,
            time: trajectory.times()[0],
        };
        let x = trajectory.displacement();
        let start = x[(i, 0)];
        let mut range = Range {
            peak: first,
            highest: start,
            lowest: start,
            fastest: Fastest {
                velocity: 0.0,
                time: trajectory.times()[0],
            },
        };
        for (k, &time) in trajectory.times().iter().enumerate() {
            let displacement = x[(i, k)];
            range.highest = range.highest.max(displacement);
            range.lowest = range.lowest.min(displacement);
            if displacement.abs() > range.peak.displacement.abs() {
                range.peak = Extremum { displacement, time };
            }
            let velocity = trajectory.velocity()[(i, k)];
            if velocity.abs() > range.fastest.velocity.abs() {
                range.fastest = Fastest { velocity, time };
            }
        }
        range
    }

    /// The largest distance from `end`.
    fn deviation(&self, end: f64) -> f64 {
        (self.highest - end).abs().max((self.lowest - end).abs())
    }

    /// How far it goes beyond `end` in parts of the way from `start`, unless that is too short to overshoot.
    fn overshoot(&self, start: f64, end: f64, rounding: f64) -> Option<f64> {
        let way = end - start;
        let beyond = if way > 0.0 {
            self.highest - end
        } else {
            end - self.lowest
        };
        let least = rounding.max(WAY * self.deviation(end));
        (way.abs() > least).then(|| (beyond / way.abs()).max(0.0))
    }
}

/// The displacement at the earliest instant.
fn start(trajectory: &Trajectory, i: usize) -> f64 {
    let steps = trajectory.steps();
    let earliest = (0..steps.len()).min_by_key(|k| steps[*k]);
    earliest.map_or(0.0, |k| trajectory.displacement()[(i, k)])
}

/// Step and time of the last instant that a band excludes.
fn last_sample_outside(trajectory: &Trajectory, i: usize, band: &Band) -> Option<(u64, f64)> {
    let x = trajectory.displacement();
    let instants = trajectory.steps().iter().zip(trajectory.times());
    let outside = instants
        .enumerate()
        .filter(|(k, _)| band.excludes(x[(i, *k)]));
    let last = outside.max_by_key(|(_, (step, _))| **step);
    last.map(|(_, (step, time))| (*step, *time))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Harmonic, Impulse, Polynomial, Quantity, Ramp, Response, State, Step};
    use eigentone_modes::{GROUND, MatrixKind, Precision, System, SystemBuilder};

    fn summary(builder: SystemBuilder, ask: impl Fn(Response<'_>) -> Response<'_>) -> Summary {
        let system = builder.build().expect("a system");
        let problem = ask(Response::of(&system)).problem().expect("a problem");
        let plan = crate::ResponsePlan::of(&problem).expect("a plan");
        let trajectory = plan.run(&problem).expect("a response");
        let modes = system.modes().expect("modes");
        Summary::of(&problem, &trajectory, &modes).expect("instants")
    }

    fn destinations(summary: &Summary) -> Vec<Destination> {
        let coordinates = summary.coordinates().iter();
        coordinates
            .map(|coordinate| coordinate.destination)
            .collect()
    }

    fn assert_rests(destination: Destination, wanted: f64) {
        match destination {
            Destination::Rest { displacement, .. } => {
                let off = (displacement - wanted).abs();
                assert!(off < 1e-12, "{displacement} {wanted}");
            }
            other => panic!("{other:?} instead of a rest at {wanted}"),
        }
    }

    /// When a coordinate is settled where it comes to rest.
    #[track_caller]
    fn settled(summary: &Summary, coordinate: usize) -> Option<f64> {
        match summary.coordinates()[coordinate].destination {
            Destination::Rest { settled, .. } => settled,
            other => panic!("{other:?}"),
        }
    }

    fn one() -> SystemBuilder {
        System::builder().mass("m", 2.0).spring(GROUND, "m", 8.0)
    }

    #[test]
    fn an_exponential_leaves_the_band_at_the_logarithm_of_50() {
        let node = System::builder().mass("m", 0.0).spring(GROUND, "m", 1.0);
        let summary = summary(node.damper(GROUND, "m", 1.0), |response| {
            let response = response.from(State::at_rest().displace("m", 3.0));
            response.load("m", Step::of(1.0)).every(0.01).until(20.0)
        });
        let course = summary.coordinates()[0];
        assert_eq!((course.peak, course.peak_time), (3.0, 0.0));
        let settled = settled(&summary, 0).expect("it settles");
        assert!((settled - 50f64.ln()).abs() < 1e-9, "{settled}");
        assert!(summary.is_between());
        assert_rests(course.destination, 1.0);
    }

    /// A power of time has no end, whatever its value and its rate are at the last instant, or where it begins there; what dampers drag
    /// after what it moves drifts too: under 0.2t² on a, b follows at 4·a′/20 m.
    #[test]
    fn powers_of_time_have_no_end() {
        let one = || {
            let system = System::builder().mass("a", 1.0).spring(GROUND, "a", 20.0);
            system.damper(GROUND, "a", 4.0)
        };
        for (coefficients, start) in [
            (vec![0.0, 0.4, -0.01], 0.0),
            (vec![8.0, -1.2, 0.06, -0.001], 0.0),
            (vec![0.0, 0.0, 1.0], 20.0),
            (vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], 20.0),
        ] {
            let load = Polynomial::of(coefficients).starting_at(start);
            let summary = summary(one(), |response| {
                let response = response.load("a", load.clone());
                response.every(0.1).until(20.0)
            });
            let course = summary.coordinates()[0];
            assert_eq!(course.destination, Destination::Drift, "{load:?}");
            assert_eq!(summary.mean(0), None);
        }
        let two = one().mass("b", 2.0).spring(GROUND, "b", 20.0);
        let summary = summary(two.damper("a", "b", 4.0), |response| {
            let load = Polynomial::of([0.0, 0.0, 0.2]);
            response.load("a", load).every(0.1).until(40.0)
        });
        for course in summary.coordinates() {
            assert_eq!(course.destination, Destination::Drift);
        }
    }

    /// By mass alone: x₁″ = 0.04 under 0.2t² on a spring of 10 N/m, so that x₂ of 20 N/m is held −0.04/20 away; under 0.2t³ it drifts.
    #[test]
    fn masses_that_are_coupled_follow_accelerations() {
        let ends = |power: usize| {
            let [mass, damping, stiffness] = [
                [[2.0, 1.0], [1.0, 2.0]],
                [[1.0, 0.0], [0.0, 1.0]],
                [[10.0, 0.0], [0.0, 20.0]],
            ]
            .map(|rows: [[f64; 2]; 2]| Mat::from_fn(2, 2, |i, j| rows[i][j]));
            let system = System::builder().matrix(MatrixKind::Mass, mass.as_ref());
            let system = system.matrix(MatrixKind::Damping, damping.as_ref());
            let system = system.matrix(MatrixKind::Stiffness, stiffness.as_ref());
            let mut coefficients = vec![0.0; power];
            coefficients.push(0.2);
            summary(system, |response| {
                let load = Polynomial::of(coefficients.clone());
                response.load("x1", load).every(0.1).until(60.0)
            })
        };
        assert_rests(ends(2).coordinates()[1].destination, -0.002);
        assert_eq!(ends(3).coordinates()[1].destination, Destination::Drift);
    }

    /// The middle of a beam under a force there does not turn, but for rounding.
    #[test]
    fn what_rounding_makes_of_0_is_0() {
        let beam = eigentone_modes::Beam {
            name: "b".to_owned(),
            length: 4.0,
            elements: 4,
            flexural_rigidity: 17.0,
            mass_per_length: 0.612,
            ends: [eigentone_modes::BeamEnd::Pinned; 2],
            lumped: true,
        };
        let system = System::builder().beam(beam).rayleigh(0.19, 0.0079, None);
        let system = system.build().expect("a beam");
        let ask = Response::of(&system).load("b.2.w", Step::of(1.0));
        let ask = ask.every(0.083).until(1.66);
        let (problem, motion) = (ask.clone().problem().expect("a problem"), ask.run());
        let (motion, modes) = (motion.expect("a motion"), system.modes().expect("modes"));
        let summary = Summary::of(&problem, &motion, &modes).expect("instants");
        let at = system.index_of("b.2.r").expect("a coordinate");
        let turn = &summary.coordinates()[at];
        assert_eq!((turn.peak, turn.peak_time), (0.0, 0.0));
        let Destination::Rest { displacement, .. } = turn.destination else {
            panic!("{turn:?}");
        };
        assert_eq!(displacement, 0.0);
        assert!(summary.coordinates()[at - 1].peak > 0.1);
    }

    /// Two nodes that are joined do not pull at a body which only a damper holds: it stays at 0, unless that damper is so small
    /// that rounding moves it.
    #[test]
    fn a_damper_lost_in_rounding_leaves_the_end_open() {
        let course = |damping: f64| {
            let system = System::builder().mass("a", 1.0).mass("b", 0.0);
            let system = system.mass("c", 0.0).damper(GROUND, "a", damping);
            let system = system.damper("a", "b", 0.5).damper("b", "c", 0.7);
            let summary = summary(system.spring("b", "c", 1.0), |response| {
                let response = response.from(State::at_rest().displace("b", 2.5));
                response.every(0.1).until(10.0)
            });
            summary.coordinates()[0].destination
        };
        assert_rests(course(3e-3), 0.0);
        assert_eq!(course(3e-12), Destination::Unknown);
    }

    /// An impulse on a damped node without mass displaces it at once: x = 2e^(−2(t − ¼)).
    #[test]
    fn a_jump_between_samples_is_a_peak_and_unsettles() {
        let node = || System::builder().mass("p", 0.0).spring(GROUND, "p", 1.0);
        let jump = |at: f64| {
            summary(node().damper(GROUND, "p", 0.5), |response| {
                let impulse = Impulse::of(1.0).at(at);
                response.load("p", impulse).every(1.0).until(10.0)
            })
        };
        for at in [0.0, 0.25, 3.0, 7.5] {
            let course = jump(at).coordinates()[0];
            assert!((course.peak - 2.0).abs() < 1e-12, "{at}: {course:?}");
            assert_eq!(course.peak_time, at);
            assert!((course.fastest + 4.0).abs() < 1e-12 && course.fastest_time == at);
            let Destination::Rest {
                settled, overshoot, ..
            } = course.destination
            else {
                panic!("{course:?}");
            };
            let settled = settled.expect("it settles");
            assert!((settled - at - 50f64.ln() / 2.0).abs() < 1e-9, "{settled}");
            // Where it is there from the start, there is no way to go beyond.
            assert_eq!(overshoot, (at == 0.0).then_some(0.0));
        }
        // At the end itself, where it is not settled.
        let last = jump(10.0);
        let course = last.coordinates()[0];
        assert!((course.peak - 2.0).abs() < 1e-12 && course.peak_time == 10.0);
        assert_eq!(settled(&last, 0), None);
    }

    /// Held by springs alone, a node without mass follows its load at once: to 2 m at 0.5 s and back at 1.5 s,
    /// to −3 m at 2.25 s and back at 2.75 s.
    #[test]
    fn jumps_there_and_back_are_seen() {
        let node = System::builder().mass("p", 0.0).spring(GROUND, "p", 1.0);
        let summary = summary(node, |response| {
            let steps = [(2.0, 0.5), (-2.0, 1.5), (-3.0, 2.25), (3.0, 2.75)];
            let loads = steps.into_iter().fold(response, |response, (force, at)| {
                response.load("p", Step::of(force).starting_at(at))
            });
            loads.every(1.0).until(10.0)
        });
        let course = summary.coordinates()[0];
        assert_eq!((course.peak, course.peak_time), (-3.0, 2.25));
        assert_eq!(settled(&summary, 0), Some(2.75));
    }

    /// Springs alone, and no load: without any state there is nothing to follow.
    #[test]
    fn what_has_no_state_is_at_rest() {
        let node = System::builder().mass("p", 0.0).spring(GROUND, "p", 1.0);
        let summary = summary(node, |response| response.every(0.5).until(2.0));
        assert_eq!(summary.coordinates()[0].peak, 0.0);
        assert_rests(summary.coordinates()[0].destination, 0.0);
    }

    /// A jump at the last instant, of a displacement and of a velocity; and a motion that is that instant alone.
    #[test]
    fn jumps_at_the_end_are_seen() {
        for end in [4.0, 0.0] {
            let pair = one().mass("p", 0.0).spring(GROUND, "p", 1.0);
            let summary = summary(pair, |response| {
                let response = response.load("p", Step::of(5.0).starting_at(end));
                response
                    .load("m", Impulse::of(-6.0).at(end))
                    .every(1.0)
                    .until(end)
            });
            let [m, p] = [0, 1].map(|i| summary.coordinates()[i]);
            assert!(summary.is_between());
            assert_eq!((m.fastest, m.fastest_time), (-3.0, end));
            assert_eq!((p.peak, p.peak_time), (5.0, end));
        }
    }

    /// The summary of the proven motion, and where combinations come to rest.
    fn rests_of(problem: &Problem<'_>) -> (Summary, Vec<Option<CombinationRest>>) {
        let modes = problem.system().modes().expect("modes");
        let plan = crate::ResponsePlan::of(problem).expect("a plan");
        let motion = plan.run(problem).expect("a response");
        let summary = Summary::of(problem, &motion, &modes).expect("instants");
        let rests = summary.combinations(problem, &motion, &modes);
        (summary, rests.expect("they are followed"))
    }

    /// When x″ + 0.8x′ + 16x = const from rest leaves 2 % about its end for the last time: of its way there it then lacks
    /// e^(−at)(cos wt + a/w·sin wt).
    fn settling_of_a_step() -> f64 {
        let (a, w) = (0.4f64, (16.0f64 - 0.16).sqrt());
        let lacks = |t: f64| (-a * t).exp() * ((w * t).cos() + a / w * (w * t).sin());
        let is_outside = |t: f64| lacks(t).abs() > 0.02;
        let mut times = (0..40_000).rev().map(|k| f64::from(k) * 1e-3);
        let mut low = times.find(|t| is_outside(*t)).expect("it is at 0");
        let mut high = low + 1e-3;
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            *(if is_outside(middle) {
                &mut low
            } else {
                &mut high
            }) = middle;
        }
        low
    }

    /// It crosses its end again and again; an end of the grid beside a crossing settles nothing.
    #[test]
    fn a_crossing_at_the_end_is_no_rest() {
        let truth = settling_of_a_step();
        for end in [
            1.98, 1.99, 2.0, 2.01, 3.56, 6.0, 9.5, 9.55, 9.6, 9.65, 10.0, 20.0,
        ] {
            let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 16.0);
            let summary = summary(system.damper(GROUND, "m", 0.8), |response| {
                response
                    .load("m", Step::of(4.0))
                    .every(end / 4.0)
                    .until(end)
            });
            assert!(!summary.is_open(0));
            match settled(&summary, 0) {
                Some(time) => assert!(end > truth && (time - truth).abs() < 1e-8, "{end}: {time}"),
                None => assert!(end < truth, "{end}"),
            }
        }
    }

    /// Beside a mass that an impulse moves so many times as far, uncoupled and by a spring so soft that it matters little: the
    /// closed form, and what the proven motion says there.
    #[test]
    fn a_small_motion_settles_beside_a_large_one() {
        for (size, coupling) in [
            (1e3, 0.0),
            (1e6, 0.0),
            (1e10, 0.0),
            (1e12, 0.0),
            (1e13, 0.0),
            (1e15, 0.0),
            (1e20, 0.0),
            (1e12, 1e-12),
            (1e15, 1e-14),
        ] {
            let pair = System::builder().mass("m", 1.0).mass("b", 1.0);
            let pair = pair.spring(GROUND, "m", 16.0).damper(GROUND, "m", 0.8);
            let pair = pair.spring(GROUND, "b", 16.0).damper(GROUND, "b", 0.8);
            let system = pair.spring("m", "b", coupling).build().expect("a system");
            let problem = Response::of(&system)
                .load("m", Step::of(16.0))
                .load("b", Impulse::of(size))
                .sum("x", [(Quantity::Displacement, "m", 1.0)])
                .every(0.5)
                .until(20.0)
                .problem()
                .expect("a problem");
            let (summary, rests) = rests_of(&problem);
            let rest = rests[0].expect("it rests");
            let [m, b] = [0, 1].map(|i| settled(&summary, i).expect("it settles"));
            let of_output = rest.settled.expect("it settles");
            let off = (m - of_output).abs();
            assert!(off < 1e-8, "{size} {coupling}: {m} {of_output}");
            assert!((b - 9.965_33).abs() < 1e-5, "{size}: {b}");
            if coupling == 0.0 {
                assert!((m - settling_of_a_step()).abs() < 1e-8, "{size}: {m}");
            }
            let exact = crate::ByCertifiedExponential
                .at(&problem, &[m])
                .expect("a motion");
            let extrema = summary.extrema().expect("it is followed");
            let (high, low) = (extrema.highest()[0], extrema.lowest()[0]);
            let far = (high.displacement - rest.value).max(rest.value - low.displacement);
            let there = (exact.output(0)[0] - rest.value).abs() / far;
            assert!((there - 0.02).abs() < 1e-8, "{size} {coupling}: {there}");
        }
    }

    /// What moves less than the motion is known to has not stood still: beside a mass so much larger that nothing is left of it,
    /// and in doubles that know no bound.
    #[test]
    fn what_moves_beneath_what_is_known_is_left_open() {
        let pair = ["m", "b"].iter().fold(System::builder(), |pair, name| {
            let pair = pair.mass(*name, 1.0).spring(GROUND, *name, 4.0);
            pair.damper(GROUND, *name, 1.0)
        });
        let known = |summary: &Summary, i: usize| (settled(summary, i), summary.is_open(i));
        for (coupling, open) in [(1e-25, true), (1e-27, true), (0.0, false)] {
            let summary = summary(pair.clone().spring("m", "b", coupling), |response| {
                let state = State::at_rest().displace("m", 1.0);
                response.from(state).every(0.1).until(40.0)
            });
            let still = if open { None } else { Some(0.0) };
            assert_eq!(known(&summary, 1), (still, open), "{coupling}");
        }
        let free = System::builder().mass("m", 1.0).damper(GROUND, "m", 1.0);
        let summary = summary(free, |response| {
            let response = response.from(State::at_rest().push("m", 1.0));
            response.every(0.1).until(10.0).to(Precision::Double)
        });
        let truth = 50f64.ln();
        match known(&summary, 0) {
            (None, open) => assert!(open),
            (Some(time), _) => assert!((time - truth).abs() < 0.1, "{time}"),
        }
    }

    /// An impulse at the end, and after it, moves what has been at rest.
    #[test]
    fn what_is_still_to_come_unsettles() {
        for at in [4.0, 4.5, 400.0] {
            let summary = summary(one().damper(GROUND, "m", 4.0), |response| {
                let impulse = Impulse::of(1.0).at(at);
                response.load("m", impulse).every(1.0).until(4.0)
            });
            assert_eq!(settled(&summary, 0), None, "{at}");
        }
    }

    /// An impulse at the end leaves a displacement where it is and makes the velocity and the force in a damper jump.
    #[test]
    fn what_an_impulse_at_the_end_moves_has_not_settled() {
        // With 8 N·s/m damping is critical.
        for (at, damping, settles) in [(20.0, 4.0, false), (0.0, 4.0, true), (0.0, 8.0, true)] {
            let system = one().damper(GROUND, "m", damping);
            let system = system.build().expect("a system");
            let problem = Response::of(&system)
                .load("m", Impulse::of(1.0).at(at))
                .sum("x", [(Quantity::Displacement, "m", 1.0)])
                .sum("v", [(Quantity::Velocity, "m", 1.0)])
                .sum("a", [(Quantity::Acceleration, "m", 1.0)])
                .every(0.5)
                .until(20.0)
                .problem()
                .expect("a problem");
            let (_, rests) = rests_of(&problem);
            for rest in rests {
                let rest = rest.expect("it comes to rest");
                assert_eq!(rest.settled.is_some(), settles, "{at}: {rest:?}");
            }
        }
    }

    /// Critical damping has one shape for two roots: e^(−2t)(1 + 2t) = 0.02.
    #[test]
    fn critical_damping_settles() {
        let critical = one().damper(GROUND, "m", 8.0);
        let summary = summary(critical, |response| {
            let response = response.from(State::at_rest().displace("m", 1.0));
            response.every(0.5).until(4.0)
        });
        let time = settled(&summary, 0).expect("it settles");
        let off = ((-2.0 * time).exp() * (1.0 + 2.0 * time) - 0.02).abs();
        assert!(off < 1e-9, "{time}");
    }

    /// Beside what swings for ever.
    #[test]
    fn what_settles_beside_what_does_not() {
        let pair = one().damper(GROUND, "m", 0.8);
        let pair = pair.mass("n", 3.0).spring(GROUND, "n", 5.0);
        for end in [20.0, 40.0] {
            let summary = summary(pair.clone(), |response| {
                let state = State::at_rest().displace("m", 1.0).displace("n", 7.0);
                response
                    .from(state)
                    .load("n", Harmonic::of(1.0, 3.0))
                    .every(0.5)
                    .until(end)
            });
            // e^(−t/5): the last of its waves leaves at most once more within a period of π.
            let time = settled(&summary, 0).expect("it settles");
            assert!(
                time < 5.0 * 50f64.ln() + 0.1 && time > 5.0 * 50f64.ln() - 3.2,
                "{time}"
            );
        }
    }

    /// A quake ends with some small value that holds: 1e-9 N on 8 N/m. Its way to there is no step, and what goes beyond
    /// it no overshoot.
    #[test]
    fn a_way_that_cannot_be_seen_has_no_overshoot() {
        let quake = |last: f64| {
            let summary = summary(one().damper(GROUND, "m", 4.0), |response| {
                let values = vec![0.0, 3.0, -5.0, 4.0, last];
                let (step, hold) = (0.5, crate::Hold::Zero);
                let samples = crate::Samples { step, values, hold };
                response.load("m", samples).every(0.1).until(60.0)
            });
            match summary.coordinates()[0].destination {
                Destination::Rest { overshoot, .. } => overshoot,
                other => panic!("{other:?}"),
            }
        };
        assert_eq!(quake(1e-9), None);
        assert_eq!(quake(0.0), None);
        assert!(quake(8.0).is_some_and(|beyond| (0.0..10.0).contains(&beyond)));
    }

    #[test]
    fn what_has_not_settled_by_the_end_is_not_said_to_have() {
        let summary = summary(one().damper(GROUND, "m", 0.01), |response| {
            let response = response.from(State::at_rest().displace("m", 1.0));
            response.every(0.1).until(10.0)
        });
        let course = summary.coordinates()[0];
        let Destination::Rest {
            settled, overshoot, ..
        } = course.destination
        else {
            panic!("{course:?}");
        };
        assert_rests(course.destination, 0.0);
        assert_eq!(settled, None);
        // c/2√(km) = 0.01/8: e^(−πζ/√(1−ζ²)) beyond the end.
        let zeta: f64 = 0.01 / 8.0;
        let wanted = (-std::f64::consts::PI * zeta / (1.0 - zeta * zeta).sqrt()).exp();
        assert!((overshoot.expect("it passes") - wanted).abs() < 1e-11);
    }

    #[test]
    fn a_chain_damped_in_its_middle_goes_on_at_its_ends() {
        let mut chain = System::builder();
        for name in ["a", "b", "c"] {
            chain = chain.mass(name, 1.0).spring(GROUND, name, 1.0);
        }
        let chain = chain.spring("a", "b", 2.0).spring("b", "c", 2.0);
        let summary = summary(chain.damper(GROUND, "b", 0.5), |response| {
            let response = response.from(State::at_rest().displace("a", 1.0));
            response.load("b", Step::of(7.0)).every(0.1).until(300.0)
        });
        let ends = destinations(&summary);
        assert_eq!(ends[0], Destination::Oscillation);
        // K x = (0, 7, 0): 3 x_a = 2 x_b and 5 x_b − 4 x_a = 7.
        assert_rests(ends[1], 3.0);
        assert_eq!(ends[2], Destination::Oscillation);
    }

    #[test]
    fn an_undamped_mass_that_is_not_disturbed_rests() {
        let undisturbed = summary(one(), |response| {
            let response = response.from(State::at_rest().displace("m", 0.5));
            response.load("m", Step::of(4.0)).every(0.1).until(10.0)
        });
        assert_rests(destinations(&undisturbed)[0], 0.5);
        let disturbed = summary(one(), |response| {
            response.load("m", Step::of(4.0)).every(0.1).until(10.0)
        });
        assert_eq!(destinations(&disturbed), [Destination::Oscillation]);
    }

    #[test]
    fn a_dashpot_without_a_spring_stops_where_the_momentum_is_spent() {
        let mass = System::builder().mass("m", 2.0).damper(GROUND, "m", 4.0);
        let state = || State::at_rest().displace("m", 1.0).push("m", 3.0);
        let stopped = summary(mass.clone(), |response| {
            response.from(state()).every(0.1).until(5.0)
        });
        assert_rests(destinations(&stopped)[0], 1.0 + 2.0 * 3.0 / 4.0);
        let pulled = summary(mass, |response| {
            response.load("m", Step::of(1.0)).every(0.1).until(5.0)
        });
        assert_eq!(destinations(&pulled), [Destination::Drift]);
    }

    #[test]
    fn a_free_pair_keeps_its_centre_or_drifts() {
        let pair = || {
            let pair = System::builder().mass("a", 1.0).mass("b", 3.0);
            pair.spring("a", "b", 5.0).damper("a", "b", 1.0)
        };
        let parted = summary(pair(), |response| {
            let state = State::at_rest().displace("a", 4.0);
            response
                .from(state.push("a", 3.0).push("b", -1.0))
                .every(0.1)
                .until(40.0)
        });
        for destination in destinations(&parted) {
            assert_rests(destination, 1.0);
        }
        let pushed = summary(pair(), |response| {
            response
                .from(State::at_rest().push("a", 1.0))
                .every(0.1)
                .until(40.0)
        });
        assert_eq!(destinations(&pushed), [Destination::Drift; 2]);
    }

    /// A body that 3 N push on moves at last by 3 m/s beside one that a damper of 1 N·s/m joins it to: springs hold these 3 N. With a
    /// damper to the ground, by (3 − ½·3)/1; under a ramp that body moves on as well.
    #[test]
    fn what_moves_on_drags_what_springs_hold() {
        let two = |to_ground: f64| {
            let two = System::builder().mass("a", 2.0).mass("b", 3.0);
            let two = two.spring("b", GROUND, 3.0).damper("a", "b", 1.0);
            match to_ground {
                0.0 => two,
                _ => two.damper("a", GROUND, to_ground),
            }
        };
        for (to_ground, end) in [(0.0, -1.0), (1.0, -0.5)] {
            let dragged = summary(two(to_ground), |response| {
                response.load("a", Step::of(-3.0)).every(0.7).until(70.0)
            });
            let [a, b] = destinations(&dragged)[..] else {
                panic!("two");
            };
            assert_eq!(a, Destination::Drift);
            assert_rests(b, end);
        }
        let swinging = summary(two(0.0), |response| {
            let response = response.load("a", Step::of(-3.0));
            let response = response.load("b", crate::Harmonic::of(0.1, 1.0));
            response.every(0.7).until(70.0)
        });
        assert_eq!(destinations(&swinging)[1], Destination::Oscillation);
        let mean = swinging.mean(1).expect("about a place");
        assert!((mean + 1.0).abs() < 1e-12, "{mean}");
        let faster = summary(two(0.0), |response| {
            let response = response.load("a", crate::Ramp::of(-3.0));
            response.every(0.7).until(70.0)
        });
        assert_eq!(destinations(&faster), [Destination::Drift; 2]);
    }

    /// Ramps that cancel as forces on a free pair part it, each mass by its share: the centre stays.
    #[test]
    fn ramps_part_both_masses_of_a_free_pair() {
        for damping in [0.0, 2.0] {
            let pair = System::builder().mass("a", 5.0).mass("b", 2.0);
            let pair = pair.spring("a", "b", 3.0).damper("a", "b", damping);
            let parted = summary(pair, |response| {
                let response = response.load("a", crate::Ramp::of(-1.0));
                response
                    .load("b", crate::Ramp::of(1.0))
                    .every(0.5)
                    .until(40.0)
            });
            assert_eq!(destinations(&parted), [Destination::Drift; 2]);
        }
    }

    #[test]
    fn growth_is_named_where_it_is_excited() {
        let unstable = || one().damper(GROUND, "m", -0.1);
        let still = summary(unstable(), |response| response.every(0.1).until(5.0));
        assert_rests(destinations(&still)[0], 0.0);
        let moved = summary(unstable(), |response| {
            let response = response.from(State::at_rest().push("m", 1e-3));
            response.every(0.1).until(5.0)
        });
        assert_eq!(destinations(&moved), [Destination::Growth]);
        let driven = |frequency: f64| {
            summary(one(), |response| {
                let load = Harmonic::of(1.0, frequency);
                response.load("m", load).every(0.1).until(50.0)
            })
        };
        assert_eq!(destinations(&driven(2.0)), [Destination::Growth]);
        assert_eq!(destinations(&driven(2.1)), [Destination::Oscillation]);
    }

    /// A load that grows for 2 s and then holds is two ramps: 8 N on 8 N/m.
    #[test]
    fn ramps_that_stop_leave_a_constant_force() {
        let summary = summary(one().damper(GROUND, "m", 4.0), |response| {
            let response = response.load("m", Ramp::of(4.0).starting_at(1.0));
            let response = response.load("m", Ramp::of(-4.0).starting_at(3.0));
            response.every(0.1).until(60.0)
        });
        assert_rests(destinations(&summary)[0], 1.0);
    }

    #[test]
    fn sustained_loads_move_only_what_they_reach() {
        let apart = |load: fn(Response<'_>) -> Response<'_>| {
            let two = one().mass("n", 1.0).spring(GROUND, "n", 2.0);
            let two = two.damper(GROUND, "m", 1.0).damper(GROUND, "n", 1.0);
            destinations(&summary(two, |response| {
                let response = response.load("n", Step::of(4.0));
                load(response).every(0.1).until(80.0)
            }))
        };
        let ramped = apart(|response| response.load("m", Ramp::of(0.1)));
        assert_eq!(ramped[0], Destination::Drift);
        assert_rests(ramped[1], 2.0);
        let shaken = apart(|response| response.load("m", Harmonic::of(0.1, 3.0)));
        assert_eq!(shaken[0], Destination::Oscillation);
        assert_rests(shaken[1], 2.0);
    }

    #[test]
    fn loads_go_on_from_where_they_are() {
        let system = one().build().expect("a system");
        let response = Response::of(&system).load("m", Ramp::of(4.0).starting_at(1.0));
        let response = response.load("m", Step::of(5.0).starting_at(100.0));
        let problem = response.every(0.5).until(200.0).problem();
        let problem = problem.expect("a problem");
        for (time, force, rate) in [(0.5, 0.0, 0.0), (3.0, 8.0, 4.0), (101.0, 405.0, 4.0)] {
            let now = sustained(&problem, time);
            assert_eq!((now.force, now.rate), (vec![force], vec![rate]));
        }
    }

    /// A constant force beside the sinusoid: 16/8. A support whose velocity swings from its largest value on, sin t, moves
    /// about 1; one whose acceleration does so goes away. A mass on a dashpot goes on about a/ωc.
    #[test]
    fn what_keeps_swinging_does_so_about_a_mean() {
        let damped = one().damper(GROUND, "m", 4.0);
        let held = summary(damped, |response| {
            let response = response.load("m", Step::of(16.0));
            response
                .load("m", Harmonic::of(1.0, 1.0))
                .every(0.5)
                .until(60.0)
        });
        assert_eq!(destinations(&held), [Destination::Oscillation]);
        assert_eq!(held.mean(0), Some(2.0));
        let free = System::builder().mass("m", 1.0).damper(GROUND, "m", 4.0);
        let free = summary(free, |response| {
            response
                .load("m", Harmonic::of(1.0, 1.0))
                .every(0.5)
                .until(60.0)
        });
        assert!((free.mean(0).expect("it stays") - 0.25).abs() < 1e-12);
        let shaken = |quantity: Quantity| {
            let shaken = System::builder().mass("m", 2.0).support("s");
            let shaken = shaken.spring("s", "m", 8.0).damper("s", "m", 4.0);
            summary(shaken, |response| {
                let course = Harmonic::of(1.0, 1.0);
                response
                    .motion("s", quantity, course)
                    .every(0.5)
                    .until(60.0)
            })
        };
        let mean = shaken(Quantity::Velocity).mean(0);
        assert!((mean.expect("it stays") - 1.0).abs() < 1e-12);
        assert_eq!(shaken(Quantity::Acceleration).mean(0), None);
    }

    /// m·v₀ and the mean momentum a/ω of the shaking, over the dashpot's coefficient; it swings too little to be seen.
    #[test]
    fn a_shaken_mass_on_a_dashpot_ends_where_its_momentum_brings_it() {
        let free = System::builder().mass("m", 2.0).damper(GROUND, "m", 0.5);
        let summary = summary(free, |response| {
            let response = response.from(State::at_rest().push("m", 0.25));
            let response = response.load("m", Harmonic::of(1e-5, 100.0));
            response.every(0.5).until(10.0)
        });
        assert_rests(destinations(&summary)[0], 1.0 + 1e-5 / 100.0 / 0.5);
    }

    /// The same where the angle Ωt of the latest instant is about 3e16, which no double holds: the force's mean momentum a/Ω is
    /// that since it began.
    #[test]
    fn the_angle_of_a_load_after_very_many_turns_is_known() {
        let frequency = 1e16 / 3.0;
        let free = System::builder().mass("m", 2.0).damper(GROUND, "m", 0.5);
        let summary = summary(free, |response| {
            let response = response.from(State::at_rest().push("m", 0.25));
            let response = response.load("m", Harmonic::of(0.1 * frequency, frequency));
            response.every(0.97).until(9.7)
        });
        assert_rests(destinations(&summary)[0], 1.0 + 0.1 / 0.5);
    }

    /// Pushed so that the load alone moves it, mv = −a/Ω, an undamped mass that a constant force holds at 16/8 stays there but for
    /// what the load swings it by, a/(mΩ²): nothing is seen to oscillate.
    #[test]
    fn a_mass_in_step_with_a_very_fast_load_rests() {
        let frequency = 1e16 / 3.0;
        let held = System::builder().mass("m", 2.0).spring(GROUND, "m", 8.0);
        let summary = summary(held, |response| {
            let response = response.from(State::at_rest().displace("m", 2.0).push("m", -0.05));
            let response = response.load("m", Step::of(16.0));
            let response = response.load("m", Harmonic::of(0.1 * frequency, frequency));
            response.every(0.97).until(9.7)
        });
        assert_rests(destinations(&summary)[0], 2.0);
    }

    #[test]
    fn a_follower_force_needs_left_shapes() {
        let identity = Mat::<f64>::identity(2, 2);
        let stiffness = Mat::from_fn(2, 2, |i, j| [[1.0, 0.0], [1.0, 4.0]][i][j]);
        let builder = System::builder()
            .matrix(eigentone_modes::MatrixKind::Mass, identity.as_ref())
            .matrix(eigentone_modes::MatrixKind::Stiffness, stiffness.as_ref());
        // x1 feels nothing of x2, but x2 of x1.
        let summary = summary(builder, |response| {
            let response = response.from(State::at_rest().displace("x2", 1.0));
            response.every(0.1).until(30.0)
        });
        let ends = destinations(&summary);
        assert_rests(ends[0], 0.0);
        assert_eq!(ends[1], Destination::Oscillation);
    }
}
