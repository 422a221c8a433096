//! The points of a motion's line: its samples, and what they miss.

use eigentone_digits::sort_by_number;
use eigentone_modes::CoordinateKind;
use eigentone_response::{Jump, Peaks, Summary, Trajectory};

use super::axis::Axis;
use super::unit;

/// What a line shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    Displacement,
    Velocity,
}

impl Quantity {
    /// What it is called of coordinates of this kind.
    pub(super) fn name(self, kind: CoordinateKind) -> &'static str {
        match (self, kind) {
            (Quantity::Displacement, CoordinateKind::Displacement) => "displacement",
            (Quantity::Velocity, CoordinateKind::Displacement) => "velocity",
            (Quantity::Displacement, CoordinateKind::Rotation) => "rotation",
            (Quantity::Velocity, CoordinateKind::Rotation) => "angular velocity",
        }
    }

    /// Its axis for coordinates of this kind.
    pub(super) fn axis(self, kind: CoordinateKind) -> Axis {
        let quantity = match self {
            Quantity::Displacement => eigentone_response::Quantity::Displacement,
            Quantity::Velocity => eigentone_response::Quantity::Velocity,
        };
        Axis::linear(self.name(kind), unit::motion(Some(kind), quantity))
    }
}

/// The samples of one quantity and, where they are known, both sides of its jumps and its extrema in between, by time.
pub(super) struct Outline<'a> {
    times: &'a [f64],
    sample: Box<dyn Fn(usize) -> f64 + 'a>,
    /// What stands between the samples, and at which place of the line.
    between: Vec<(usize, (f64, f64))>,
}

impl<'a> Outline<'a> {
    /// Of a coordinate.
    pub(super) fn of(
        quantity: Quantity,
        trajectory: &'a Trajectory,
        summary: &Summary,
        row: usize,
    ) -> Outline<'a> {
        let (mut jumps, mut most) = (Vec::new(), Vec::new());
        if let Some(extrema) = summary.extrema() {
            let jump = |jump: &Jump| match quantity {
                Quantity::Displacement => (jump.time, jump.displacement),
                Quantity::Velocity => (jump.time, jump.velocity),
            };
            jumps.extend(extrema.jumps(row).iter().map(jump));
            let (high, low) = (extrema.highest()[row], extrema.lowest()[row]);
            let fastest = extrema.fastest()[row];
            match quantity {
                Quantity::Displacement => {
                    most.extend([high, low].map(|x| (x.time, x.displacement)))
                }
                Quantity::Velocity => most.push((fastest.time, fastest.velocity)),
            }
        }
        let samples = match quantity {
            Quantity::Displacement => trajectory.displacement(),
            Quantity::Velocity => trajectory.velocity(),
        };
        let sample = move |k| samples[(row, k)];
        Outline::through(trajectory.times(), sample, jumps, most)
    }

    /// Of what has these peaks.
    pub(super) fn of_peaks(
        times: &'a [f64],
        sample: impl Fn(usize) -> f64 + 'a,
        peaks: Option<&Peaks>,
    ) -> Outline<'a> {
        let (mut jumps, mut most) = (Vec::new(), Vec::new());
        if let Some(peaks) = peaks {
            jumps.extend(peaks.jumps.iter().map(|jump| (jump.time, jump.values)));
            most.extend([peaks.highest, peaks.lowest].map(|peak| (peak.time, peak.value)));
        }
        Outline::through(times, sample, jumps, most)
    }

    fn through(
        times: &'a [f64],
        sample: impl Fn(usize) -> f64 + 'a,
        jumps: Vec<(f64, [f64; 2])>,
        most: Vec<(f64, f64)>,
    ) -> Outline<'a> {
        let sides = |(time, sides): (f64, [f64; 2])| sides.map(|side| (time, side));
        let mut points: Vec<(f64, f64)> = jumps.into_iter().flat_map(sides).collect();
        // One that a jump or a sample has already would turn the line back.
        let new = |(time, _): &(f64, f64)| {
            !times.contains(time) && points.iter().all(|(known, _)| known != time)
        };
        let most: Vec<(f64, f64)> = most.into_iter().filter(new).collect();
        points.extend(most);
        // Stable, so that what is before a jump stays before what is after it.
        sort_by_number(&mut points, |point| point.0);
        let earlier = |time: f64| times.partition_point(|sample| *sample < time);
        let between = points.into_iter().enumerate();
        Outline {
            times,
            sample: Box::new(sample),
            between: between
                .map(|(k, point)| (k + earlier(point.0), point))
                .collect(),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.times.len() + self.between.len()
    }

    /// Time in s, and the value then.
    pub(super) fn point(&self, k: usize) -> (f64, f64) {
        match self.between.binary_search_by_key(&k, |(place, _)| *place) {
            Ok(found) => self.between[found].1,
            Err(before) => {
                let sample = k - before;
                (self.times[sample], (self.sample)(sample))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_modes::{GROUND, System};
    use eigentone_response::{Impulse, Response, ResponsePlan};

    /// An impulse on a damped node without mass displaces it at once: x = 2e^(−2(t − ¼)). Samples stand at 0, 1, 2, ….
    #[test]
    fn a_jump_between_samples_is_a_part_of_the_line() {
        let node = System::builder().mass("p", 0.0).spring(GROUND, "p", 1.0);
        let system = node.damper(GROUND, "p", 0.5).build().expect("a system");
        let response = Response::of(&system).load("p", Impulse::of(1.0).at(0.25));
        let problem = response.every(1.0).until(4.0).problem().expect("a problem");
        let plan = ResponsePlan::of(&problem).expect("a plan");
        let trajectory = plan.run(&problem).expect("a motion");
        let modes = system.modes().expect("modes");
        let summary = Summary::of(&problem, &trajectory, &modes).expect("an instant");
        let outline = Outline::of(Quantity::Displacement, &trajectory, &summary, 0);
        let points: Vec<(f64, f64)> = (0..outline.len()).map(|k| outline.point(k)).collect();
        let first: Vec<(f64, f64)> = points.iter().copied().take(4).collect();
        assert_eq!(first[..2], [(0.0, 0.0), (0.25, 0.0)]);
        assert_eq!(first[2].0, 0.25);
        assert!((first[2].1 - 2.0).abs() < 1e-12, "{points:?}");
        assert_eq!(first[3].0, 1.0);
        assert_eq!(points.len(), 7);
        let velocity = Outline::of(Quantity::Velocity, &trajectory, &summary, 0);
        assert!((velocity.point(2).1 + 4.0).abs() < 1e-12);
    }
}
