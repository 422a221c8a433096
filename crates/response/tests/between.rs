//! What happens between the instants, and the estimates that hold there and at them.

use eigentone_modes::{Bounds, ElementKind, GROUND, Precision, System};
use eigentone_response::{
    ByCertifiedExponential, BySuperposition, Extrema, HalfSine, Impulse, Problem, Quantity,
    Response, ResponseMethod, ResponsePlan, State, Step, Summary, Trajectory,
};

use crate::systems::in_a_row;

fn answered(problem: &Problem<'_>) -> Trajectory {
    let plan = ResponsePlan::of(problem).expect("a plan");
    plan.run(problem).expect("a motion")
}

#[test]
fn what_is_of_another_system_has_no_extrema() {
    let systems = [2, 4].map(|n: usize| {
        let masses = (0..n).fold(System::builder(), |all, i| all.mass(format!("m{i}"), 1.0));
        let tied = (1..n).fold(masses.spring(GROUND, "m0", 2.0), |all, i| {
            all.spring(format!("m{}", i - 1), format!("m{i}"), 3.0)
        });
        tied.build().expect("a system")
    });
    let modes = systems
        .each_ref()
        .map(|system| system.modes().expect("modes"));
    let asked = systems.each_ref().map(|system| {
        let asked = Response::of(system).load("m0", Step::of(1.0));
        asked.every(0.1).until(2.0).problem().expect("a problem")
    });
    let motions = asked.each_ref().map(answered);
    for (own, other) in [(0, 1), (1, 0)] {
        let problem = &asked[own];
        assert!(Summary::of(problem, &motions[own], &modes[own]).is_some());
        assert!(Extrema::of(problem, &motions[other]).is_none());
        assert!(Summary::of(problem, &motions[other], &modes[own]).is_none());
        assert!(Summary::of(problem, &motions[own], &modes[other]).is_none());
    }
}

/// A step F on m, k at 1/3 s: x″ = F/m·cos ωt and kx = F(1 − cos ωt) from there, ω = 2. The acceleration jumps between
/// the instants, and an impulse at the end makes the damper's force jump there.
#[test]
fn accelerations_and_forces_have_extrema_with_their_jumps() {
    let system = System::builder()
        .mass("m", 0.5)
        .mass("n", 2.0)
        .spring("m", GROUND, 2.0)
        .damper(GROUND, "n", 3.0)
        .build()
        .expect("a system");
    let (start, end) = (1.0 / 3.0, 7.0);
    let asked = Response::of(&system)
        .load("m", Step::of(5.0).starting_at(start))
        .load("n", Impulse::of(-4.0).at(end))
        .with_acceleration()
        .with_forces()
        .sum("jolt", [(Quantity::Acceleration, "m", -2.0)]);
    let problem = asked.every(1.75).until(end).problem().expect("a problem");
    let motion = answered(&problem);
    let extrema = Extrema::of(&problem, &motion).expect("it is easily followed");
    let half = start + std::f64::consts::FRAC_PI_2;
    let [spring, damper] = [ElementKind::Spring, ElementKind::Damper].map(|kind| {
        let peaks = extrema.force(kind, 0).expect("asked for");
        assert_eq!(extrema.force(kind, 1), None);
        peaks
    });
    let [acceleration, jolt] = [extrema.acceleration(0), extrema.output(0)];
    let (acceleration, jolt) = (acceleration.expect("asked for"), jolt.expect("asked for"));
    for (peak, value, time) in [
        (acceleration.highest, 10.0, start),
        (acceleration.lowest, -10.0, half),
        (jolt.highest, 20.0, half),
        (jolt.lowest, -20.0, start),
        // The pull from m towards the ground.
        (spring.highest, 0.0, 0.0),
        (spring.lowest, -10.0, half),
        (damper.highest, 0.0, 0.0),
        (damper.lowest, -6.0, end),
    ] {
        assert!((peak.value - value).abs() <= peak.bound, "{peak:?} {value}");
        assert!((peak.time - time).abs() < 1e-6, "{peak:?} {time}");
        assert!(peak.bound < 5e-12 * value.abs().max(1.0), "{peak:?}");
    }
    assert_eq!(acceleration.highest.time, start);
    assert_eq!(spring.largest(), spring.lowest);
    // What was not asked for is not there.
    let plain = Response::of(&system)
        .every(1.0)
        .until(end)
        .problem()
        .expect("a problem");
    let plain = Extrema::of(&plain, &answered(&plain)).expect("it is easily followed");
    assert!(plain.acceleration(0).is_none() && plain.force(ElementKind::Spring, 0).is_none());
}

/// A car over a bump, by a moving support, a point that carries mass, a stiff and a soft spring: no sample of a fine grid
/// lies beyond an extremum, and at its instant the proven value is the one given; samples have proven bounds.
#[test]
fn extrema_of_a_machine_are_those_of_its_proven_motion() {
    let car = System::builder()
        .mass("body", 290.0)
        .mass("pitch", 40.0)
        .mass("wheel", 59.0)
        .support("road")
        .point("front", [("body", 1.0), ("pitch", -1.25)], 3.0)
        .spring("front", "wheel", 16_812.0)
        .damper("front", "wheel", 1000.0)
        .spring("road", "wheel", 1.9e7)
        .spring(GROUND, "pitch", 800.0)
        .build()
        .expect("a system");
    let bump = HalfSine {
        force: 0.05,
        duration: 0.11,
        start: 0.3,
    };
    let asked = |step| {
        let asked = Response::of(&car).motion("road", Quantity::Displacement, bump);
        let asked = asked.sum(
            "travel",
            [
                (Quantity::Displacement, "front", 1.0),
                (Quantity::Displacement, "road", -1.0),
            ],
        );
        let asked = asked
            .with_acceleration()
            .with_forces()
            .every(step)
            .until(1.0);
        asked.problem().expect("a problem")
    };
    let (coarse, fine) = (asked(0.25), answered(&asked(1.0 / 4096.0)));
    assert_eq!(fine.bounds(), Bounds::Proven);
    let extrema = Extrema::of(&coarse, &answered(&coarse)).expect("it can be followed");
    type Values = Box<dyn Fn(&Trajectory, usize) -> (f64, Option<f64>)>;
    let mut all: Vec<(_, Values)> = vec![(
        extrema.output(0),
        Box::new(|of: &Trajectory, k: usize| (of.output(0)[k], of.output_bound(0)[k])),
    )];
    for i in 0..car.len() {
        let at = move |of: &Trajectory, k: usize| {
            let values = of.acceleration().expect("asked for");
            (values[(i, k)], of.acceleration_bound()[k])
        };
        all.push((extrema.acceleration(i), Box::new(at)));
    }
    for (kind, count) in [(ElementKind::Spring, 3), (ElementKind::Damper, 1)] {
        for i in 0..count {
            let at = move |of: &Trajectory, k: usize| {
                let values = of.force(kind, i).expect("asked for");
                (values[k], of.force_bound(kind, i).expect("asked for")[k])
            };
            all.push((extrema.force(kind, i), Box::new(at)));
        }
    }
    assert_eq!(all.len(), 8);
    for (row, (peaks, at)) in all.iter().enumerate() {
        let peaks = peaks.expect("asked for");
        let most = peaks.largest().value.abs();
        // Bounds of accelerations are those of all coordinates.
        let whole = all[1..4].iter().filter_map(|(peaks, _)| *peaks);
        let whole = whole.map(|peaks| peaks.largest().value.abs());
        let scale = match row {
            1..4 => whole.fold(0.0, f64::max),
            _ => most,
        };
        let slack = 1e-12 * most;
        for k in 0..fine.len() {
            let (value, bound) = at(&fine, k);
            assert!(
                bound.expect("proven") <= 2e-15 * scale,
                "{row} {k}: {bound:?} of {scale}"
            );
            let (high, low) = (peaks.highest, peaks.lowest);
            assert!(
                value <= high.value + high.bound + slack,
                "{row} {k}: {value} {high:?}"
            );
            assert!(
                value >= low.value - low.bound - slack,
                "{row} {k}: {value} {low:?}"
            );
        }
        for peak in [peaks.highest, peaks.lowest] {
            let there = ByCertifiedExponential
                .at(&coarse, &[peak.time])
                .expect("a motion");
            let (value, bound) = at(&there, 0);
            let off = (value - peak.value).abs();
            // An acceleration that jumps has another value before the event.
            let jumps = (1..4).contains(&row) && [0.3, 0.41].contains(&peak.time);
            assert!(
                jumps || off <= peak.bound + bound.expect("proven"),
                "{row}: {off:e} {peak:?}"
            );
            assert!(peak.bound <= 1e-9 * most, "{row}: {peak:?} of {most}");
        }
    }
}

/// Impulses let velocities jump, on dampers without mass displacements too; loads on springs without mass let both jump.
#[test]
fn jumps_are_listed_with_both_sides() {
    let system = System::builder()
        .mass("m", 2.0)
        .mass("p", 0.0)
        .mass("q", 0.0)
        .spring(GROUND, "m", 8.0)
        .spring(GROUND, "p", 1.0)
        .damper(GROUND, "p", 0.5)
        .spring(GROUND, "q", 4.0)
        .build()
        .expect("a system");
    let response = Response::of(&system)
        .from(State::at_rest().push("m", 1.0))
        .load("m", Impulse::of(3.0).at(2.0))
        .load("p", Impulse::of(1.0).at(0.25))
        .load("q", Step::of(8.0).starting_at(1.5))
        .load("q", Step::of(-2.0).starting_at(6.0));
    let problem = response.every(1.0).until(6.0).problem().expect("a problem");
    let plan = ResponsePlan::of(&problem).expect("a plan");
    let trajectory = plan.run(&problem).expect("a motion");
    let extrema = Extrema::of(&problem, &trajectory).expect("it is easily followed");
    let near = |found: [f64; 2], wanted: [f64; 2]| {
        let off = (found[0] - wanted[0])
            .abs()
            .max((found[1] - wanted[1]).abs());
        assert!(off < 1e-12, "{found:?} {wanted:?}");
    };
    let [impulse] = extrema.jumps(0) else {
        panic!("{:?}", extrema.jumps(0));
    };
    assert_eq!(impulse.time, 2.0);
    near(impulse.displacement, [0.5 * 4f64.sin(); 2]);
    near(impulse.velocity, [4f64.cos(), 4f64.cos() + 1.5]);
    let [impulse] = extrema.jumps(1) else {
        panic!("{:?}", extrema.jumps(1));
    };
    assert_eq!(impulse.time, 0.25);
    near(impulse.displacement, [0.0, 2.0]);
    near(impulse.velocity, [0.0, -4.0]);
    let [first, last] = extrema.jumps(2) else {
        panic!("{:?}", extrema.jumps(2));
    };
    assert_eq!((first.time, last.time), (1.5, 6.0));
    near(first.displacement, [0.0, 2.0]);
    near(last.displacement, [2.0, 1.5]);
}

/// Two shapes that are nearly one, of roots far apart: what a push makes of them cancels in the displacement, but for the
/// rounding of both.
#[test]
fn superposition_allows_for_what_cancels_after_a_push() {
    let mut nonzero = 0;
    for (heavy, light, spring) in [
        (1.9e7, 3.3e-6, 6.5e-16),
        (2.3e3, 1.7e-5, 3e-9),
        (7.0, 0.3, 1e-3),
        (1e5, 3e-2, 1e-12),
    ] {
        let system = in_a_row(
            &[("a", heavy), ("b", light)],
            &[spring, spring],
            &[5.0, 4.0, 9.0],
        );
        for pushed in ["a", "b"] {
            let from = State::at_rest().push(pushed, 0.7);
            let response = Response::of(&system).from(from).every(0.1).until(1.0);
            let problem = response.to(Precision::Double).problem().expect("a problem");
            let found = BySuperposition.run(&problem).expect("it applies");
            let known = ByCertifiedExponential.run(&problem).expect("it applies");
            for k in 0..found.len() {
                let off = found.displacement().col(k) - known.displacement().col(k);
                let proven = known.displacement_bound()[k].expect("it is proven");
                let Some(bound) = found.displacement_bound()[k] else {
                    continue;
                };
                let off = off.norm_max() - proven;
                assert!(off <= bound, "{heavy} {light} {k}: {off:e} {bound:e}");
                nonzero += usize::from(k == 0 && off > 0.0);
            }
        }
    }
    // An exact 0 would say nothing.
    assert!(nonzero > 0);
}
