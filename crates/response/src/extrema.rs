//! The extrema of a motion and when it settles, between the instants too.

use crate::certified::follow::{INVISIBLE, Point, Stretch, follow};
use crate::problem::Problem;
use crate::trajectory::Trajectory;

/// The highest and the lowest displacement of each coordinate from 0 to the end, at any time and not
/// only at the instants of the grid.
///
/// Between the instants the exact solution is halved until it is, to nine digits of its range, a
/// polynomial of degree five through displacement, velocity and acceleration at both ends. Each
/// extremum is then a root of the exact velocity, found by bisection. All is done in doubles, from
/// steps that are right to their last digits: values are good to about 12 digits, and times to half of
/// them, for there a motion is flat. [`ByCertifiedExponential::at`](crate::ByCertifiedExponential::at)
/// gives the displacement at such a time with a proven bound.
///
/// ```
/// use eigentone_modes::{GROUND, System};
/// use eigentone_response::{Extrema, Response, State};
///
/// let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 1.0).build()?;
/// let from = State::at_rest().push("m", 3.0);
/// let problem = Response::of(&system).from(from).every(1.0).until(6.0).problem()?;
/// let trajectory = eigentone_response::ResponsePlan::of(&problem)?.run(&problem)?;
/// let extrema = Extrema::of(&problem, &trajectory).expect("it is easily followed");
/// let highest = extrema.highest()[0];
/// assert!((highest.displacement - 3.0).abs() < 1e-12);
/// assert!((highest.time - std::f64::consts::FRAC_PI_2).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Extrema {
    highest: Vec<Extremum>,
    lowest: Vec<Extremum>,
}

/// A displacement and when it is reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremum {
    /// In m.
    pub displacement: f64,
    /// In s; the first time, where it is reached more than once.
    pub time: f64,
}

impl Extrema {
    /// The extrema of a motion, of which `trajectory` has the instants. `None` where it asks for
    /// too many points in between, such as a motion of very many oscillations from one instant to the
    /// next, or for more digits than 32 to set out, and for a [large](eigentone_modes::System::is_large) system.
    pub fn of(problem: &Problem<'_>, trajectory: &Trajectory) -> Option<Extrema> {
        if problem.system().is_large() {
            return None;
        }
        let x = trajectory.displacement();
        let n = x.nrows();
        let first = |i: usize| Extremum {
            displacement: problem.initial_displacement()[i],
            time: 0.0,
        };
        let mut extrema = Extrema {
            highest: (0..n).map(first).collect(),
            lowest: (0..n).map(first).collect(),
        };
        let mut seen = false;
        follow(problem, 0, ranges(trajectory), &mut |stretch| {
            if !seen {
                // A node without mass does not begin where it is not told to.
                seen = true;
                for i in 0..n {
                    let displacement = stretch.left.x(i);
                    let start = Extremum {
                        displacement,
                        time: 0.0,
                    };
                    (extrema.highest[i], extrema.lowest[i]) = (start, start);
                }
            }
            for i in 0..n {
                raise(stretch, i, 1.0, &mut extrema.highest[i]);
                raise(stretch, i, -1.0, &mut extrema.lowest[i]);
            }
        })?;
        Some(extrema)
    }

    /// The highest displacement of each coordinate.
    pub fn highest(&self) -> &[Extremum] {
        &self.highest
    }

    /// The lowest displacement of each coordinate.
    pub fn lowest(&self) -> &[Extremum] {
        &self.lowest
    }

    /// The extremum of larger size, the first one on ties, of each coordinate.
    pub fn peak(&self, coordinate: usize) -> Extremum {
        let (high, low) = (self.highest[coordinate], self.lowest[coordinate]);
        let (up, down) = (high.displacement.abs(), low.displacement.abs());
        if up > down || up == down && high.time <= low.time {
            high
        } else {
            low
        }
    }
}

/// The largest displacement of each coordinate among the instants.
fn ranges(trajectory: &Trajectory) -> Vec<f64> {
    let x = trajectory.displacement();
    let range = |i: usize| x.row(i).iter().fold(0.0, |top: f64, x| top.max(x.abs()));
    (0..x.nrows()).map(range).collect()
}

/// Takes the highest (`sign` 1) or lowest (−1) displacement of a stretch if it beats the best.
fn raise(stretch: &mut Stretch<'_>, i: usize, sign: f64, best: &mut Extremum) {
    // What is equal but for rounding is reached first where it is reached first.
    let beats = |x: f64, best: &Extremum| sign * (x - best.displacement) > 1e-12 * x.abs();
    let (left, right) = (stretch.left, stretch.right);
    if beats(right.x(i), best) {
        *best = Extremum {
            displacement: right.x(i),
            time: stretch.start + stretch.length,
        };
    }
    let turns = sign * left.v(i) > 0.0 && sign * right.v(i) < 0.0;
    if !turns {
        return;
    }
    let about = stretch.turning_value(i);
    if sign * (about - best.displacement) < -INVISIBLE * about.abs() {
        return;
    }
    let (time, point) = stretch.bisect(|point: &Point| sign * point.v(i) <= 0.0);
    if beats(point.x(i), best) {
        *best = Extremum {
            displacement: point.x(i),
            time,
        };
    }
}

/// A band about a displacement, in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Band {
    pub(crate) centre: f64,
    pub(crate) half_width: f64,
}

impl Band {
    pub(crate) fn excludes(&self, x: f64) -> bool {
        (x - self.centre).abs() > self.half_width
    }
}

/// When each coordinate that has a band was last outside it, in s, at any time from the instant
/// `from` of the grid on: 0 if it never was, `None` if it is at the very end. `None` in place of all
/// where the motion cannot be followed.
pub(crate) fn last_outside(
    problem: &Problem<'_>,
    trajectory: &Trajectory,
    from: u64,
    bands: &[Option<Band>],
) -> Option<Vec<Option<f64>>> {
    /// A stretch is looked at in so many places.
    const PLACES: u32 = 32;
    let mut last = vec![Some(0.0); bands.len()];
    follow(problem, from, ranges(trajectory), &mut |stretch| {
        for (i, band) in bands.iter().enumerate() {
            let Some(band) = band else { continue };
            let excludes = |s: f64| band.excludes(stretch.polynomial(i, s));
            let mut places = (0..=PLACES).rev().map(|k| f64::from(k) / f64::from(PLACES));
            let Some(mut out) = places.find(|s| excludes(*s)) else {
                continue;
            };
            if out == 1.0 {
                last[i] = None;
                continue;
            }
            // It comes in between this place and the next.
            let mut inside = out + 1.0 / f64::from(PLACES);
            for _ in 0..50 {
                let middle = 0.5 * (out + inside);
                if excludes(middle) {
                    out = middle;
                } else {
                    inside = middle;
                }
            }
            last[i] = Some(stretch.start + out * stretch.length);
        }
    })?;
    Some(last)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Response, ResponsePlan, State, Step};
    use eigentone_modes::{GROUND, System};

    fn extrema(system: &System, ask: impl Fn(Response<'_>) -> Response<'_>) -> Extrema {
        let problem = ask(Response::of(system)).problem().expect("a problem");
        let trajectory = ResponsePlan::of(&problem).expect("a plan").run(&problem);
        Extrema::of(&problem, &trajectory.expect("a motion")).expect("it can be followed")
    }

    #[test]
    fn the_overshoot_of_a_step_is_that_of_the_closed_form() {
        // x″ + 2ζωx′ + ω²x = ω² from rest peaks at π/ω_d with 1 + e^(−πζ/√(1−ζ²)); a grid of one
        // instant a period sees little of it.
        for zeta in [0.001f64, 0.1, 0.5, 0.9] {
            let omega = 7.0;
            let system = System::builder()
                .mass("m", 1.0)
                .spring(GROUND, "m", omega * omega)
                .damper(GROUND, "m", 2.0 * zeta * omega)
                .build()
                .expect("a system");
            let found = extrema(&system, |r| {
                r.load("m", Step::of(omega * omega)).every(0.9).until(18.0)
            });
            let root = (1.0 - zeta * zeta).sqrt();
            let peak = found.peak(0);
            let wanted = 1.0 + (-std::f64::consts::PI * zeta / root).exp();
            assert!(
                (peak.displacement - wanted).abs() < 1e-12,
                "{zeta}: {peak:?}"
            );
            let time = std::f64::consts::PI / (omega * root);
            assert!((peak.time - time).abs() < 1e-6, "{zeta}: {peak:?} {time}");
            assert!(found.lowest()[0].displacement.abs() < 1e-12);
        }
    }

    #[test]
    fn a_grid_of_whole_periods_hides_nothing() {
        let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 1.0);
        let system = system.build().expect("a system");
        let step = 2.0 * std::f64::consts::TAU;
        let found = extrema(&system, |r| {
            r.from(State::at_rest().push("m", 1.0))
                .every(step)
                .until(2.0 * step)
        });
        assert!((found.highest()[0].displacement - 1.0).abs() < 1e-12);
        assert!((found.highest()[0].time - std::f64::consts::FRAC_PI_2).abs() < 1e-6);
        assert!((found.lowest()[0].displacement + 1.0).abs() < 1e-12);
    }

    #[test]
    fn peaks_between_events_are_seen() {
        // Pulled by 1 for 2 s and then let go: afterwards it swings by 2·sin 1.
        let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 1.0);
        let system = system.build().expect("a system");
        let off = Step::of(-1.0).starting_at(2.0);
        let found = extrema(&system, |r| {
            r.load("m", Step::of(1.0))
                .load("m", off)
                .every(3.0)
                .until(30.0)
        });
        let swing = 2.0 * 1f64.sin();
        assert!((found.highest()[0].displacement - swing).abs() < 1e-12);
        assert!((found.lowest()[0].displacement + swing).abs() < 1e-12);
    }
}
