//! The motion at an instant after which no load changes its law any more, also beyond the end of what was asked for.

use crate::answer::{ResponseMethod, Wanted};
use crate::certified::{ByCertifiedExponential, work};
use crate::problem::{MAX_STEPS, Problem};

/// A problem until the instant, its time in s, and displacements and velocities there.
pub(super) struct Afterwards<'a> {
    pub(super) problem: Problem<'a>,
    pub(super) time: f64,
    pub(super) x: Vec<f64>,
    pub(super) v: Vec<f64>,
}

/// The motion once all loads have changed for the last time. `None` where it takes too long to get there, or no digits do.
pub(super) fn afterwards<'a>(problem: &Problem<'a>) -> Option<Afterwards<'a>> {
    /// So many operations with 32 digits, about half a second.
    const MOST_WORK: f64 = 1e9;
    let step = problem.grid().step();
    let index = (problem.last_change() / step).ceil() + 1.0;
    if !(index <= MAX_STEPS as f64 && (index * step).is_finite()) {
        return None;
    }
    let index = index as u64;
    let problem = problem.until(index).at(&[index]).ok()?;
    if work(&problem, &Wanted::by(&problem), [1, 1], 0.0) > MOST_WORK {
        return None;
    }
    let motion = ByCertifiedExponential.run(&problem).ok()?;
    let [x, v] = [motion.displacement(), motion.velocity()]
        .map(|of| of.col(0).iter().copied().collect::<Vec<f64>>());
    Some(Afterwards {
        time: problem.grid().time(index),
        problem,
        x,
        v,
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use eigentone_modes::{GROUND, System};

    use crate::certified::ByCertifiedExponential;
    use crate::{
        Destination, HalfSine, Harmonic, Hold, Impulse, Load, Quantity, Response, ResponseMethod,
        Samples, Step, Summary, Versine,
    };

    /// Where a mass of 1 kg ends up, and about what it moves, asked for until `end` s: on a spring and a dashpot on a road, or on
    /// a dashpot alone.
    fn of(end: f64, spring: f64, loads: &[(Option<Quantity>, Load)]) -> (Destination, Option<f64>) {
        let system = System::builder().mass("m", 1.0).support("road");
        let system = match spring {
            0.0 => system.damper(GROUND, "m", 2.0),
            _ => system.spring("road", "m", spring).damper("road", "m", 2.0),
        };
        let system = system.build().expect("a system");
        let mut ask = Response::of(&system);
        for (quantity, load) in loads {
            ask = match quantity {
                Some(quantity) => ask.motion("road", *quantity, load.clone()),
                None => ask.load("m", load.clone()),
            };
        }
        let problem = ask.every(0.1).until(end).problem().expect("a problem");
        let motion = ByCertifiedExponential.run(&problem).expect("a motion");
        let modes = system.modes().expect("modes");
        let summary = Summary::of(&problem, &motion, &modes).expect("instants");
        (summary.coordinates()[0].destination, summary.mean(0))
    }

    /// Rests at the place.
    fn assert_rests((destination, mean): (Destination, Option<f64>), place: f64) {
        match destination {
            Destination::Rest { displacement, .. } => {
                let off = (displacement - place).abs();
                assert!(off < 1e-12, "{displacement} {place}");
            }
            other => panic!("{other:?}, not at {place}"),
        }
        assert!((mean.expect("a place") - place).abs() < 1e-12, "{mean:?}");
    }

    fn samples(values: Vec<f64>) -> Load {
        let (step, hold) = (0.5, Hold::Zero);
        Samples { step, values, hold }.into()
    }

    /// A road is where the integral of its velocity has brought it.
    #[test]
    fn a_road_that_goes_on_after_the_end_takes_its_mass_along() {
        let velocity = |load: Load| (Some(Quantity::Velocity), load);
        let displacement = |load: Load| (Some(Quantity::Displacement), load);
        let ends = |loads: &[(Option<Quantity>, Load)]| of(0.4, 30.0, loads);
        let half_sine = || velocity(HalfSine::of(1.0, 2.0).into());
        assert_rests(ends(&[half_sine()]), 4.0 / PI);
        assert_rests(ends(&[velocity(Versine::of(1.0, 2.0).into())]), 1.0);
        let back = Step::of(-1.0).starting_at(2.0);
        assert_rests(
            ends(&[velocity(Step::of(1.0).into()), velocity(back.into())]),
            2.0,
        );
        assert_rests(ends(&[velocity(samples(vec![1.0, 2.0, -0.5, 0.0]))]), 1.25);
        let kerb = || displacement(Step::of(1.0).into());
        let (later, _) = ends(&[kerb(), velocity(Step::of(-0.6).starting_at(30.0).into())]);
        assert_eq!(later, Destination::Drift);
        let later = HalfSine::of(-0.6, 2.0).starting_at(3.0);
        assert_rests(ends(&[kerb(), velocity(later.into())]), 1.0 - 2.4 / PI);
        // Of one that swings besides, the mean.
        let swings = displacement(Harmonic::of(0.1, 3.0).into());
        let (destination, mean) = ends(&[half_sine(), swings]);
        assert_eq!(destination, Destination::Oscillation);
        let off = (mean.expect("a place") - 4.0 / PI).abs();
        assert!(off < 1e-12, "{mean:?}");
    }

    /// A dashpot of c stops a mass where it has taken all momentum: after J/c.
    #[test]
    fn forces_after_the_end_push_on() {
        let ends = |end: f64, loads: &[Load]| {
            let loads: Vec<_> = loads.iter().map(|load| (None, load.clone())).collect();
            of(end, 0.0, &loads)
        };
        let back = Step::of(-3.0).starting_at(2.0).into();
        assert_rests(ends(1.0, &[Step::of(3.0).into(), back]), 3.0);
        assert_rests(ends(1.0, &[HalfSine::of(3.0, 2.0).into()]), 6.0 / PI);
        let impulses = [0.0, 100.0].map(|at| Impulse::of(3.0).at(at).into());
        assert_rests(ends(20.0, &impulses), 3.0);
        assert_rests(ends(1.0, &[samples(vec![1.0, 2.0, -0.5, 0.0])]), 0.625);
        let swings = [Harmonic::of(1.0, 2.0).into(), HalfSine::of(3.0, 8.0).into()];
        let (destination, mean) = ends(5.0, &swings);
        assert_eq!(destination, Destination::Oscillation);
        let mean = mean.expect("a place");
        assert!((mean - (48.0 / PI + 0.5) / 2.0).abs() < 1e-11, "{mean}");
    }

    /// What would take too long to follow is not guessed.
    #[test]
    fn changes_far_away_are_not_known() {
        let late = Step::of(1.0).starting_at(1e300).into();
        let (destination, mean) = of(1.0, 30.0, &[(None, late)]);
        assert_eq!((destination, mean), (Destination::Unknown, None));
    }
}
