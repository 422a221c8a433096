//! What happens between the instants, and the estimates that hold there and at them.

use eigentone_modes::{GROUND, Precision, System};
use eigentone_response::{
    ByCertifiedExponential, BySuperposition, Extrema, Impulse, Response, ResponseMethod,
    ResponsePlan, State, Step,
};

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
    let [blow] = extrema.jumps(0) else {
        panic!("{:?}", extrema.jumps(0));
    };
    assert_eq!(blow.time, 2.0);
    near(blow.displacement, [0.5 * 4f64.sin(); 2]);
    near(blow.velocity, [4f64.cos(), 4f64.cos() + 1.5]);
    let [blow] = extrema.jumps(1) else {
        panic!("{:?}", extrema.jumps(1));
    };
    assert_eq!(blow.time, 0.25);
    near(blow.displacement, [0.0, 2.0]);
    near(blow.velocity, [0.0, -4.0]);
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
    let mut telling = 0;
    for (heavy, light, spring) in [
        (1.9e7, 3.3e-6, 6.5e-16),
        (2.3e3, 1.7e-5, 3e-9),
        (7.0, 0.3, 1e-3),
        (1e5, 3e-2, 1e-12),
    ] {
        let system = System::builder()
            .mass("a", heavy)
            .mass("b", light)
            .spring(GROUND, "a", spring)
            .spring("a", "b", spring)
            .damper(GROUND, "a", 5.0)
            .damper("a", "b", 4.0)
            .damper(GROUND, "b", 9.0)
            .build()
            .expect("a system");
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
                telling += usize::from(k == 0 && off > 0.0);
            }
        }
    }
    // An exact 0 would say nothing.
    assert!(telling > 0);
}
