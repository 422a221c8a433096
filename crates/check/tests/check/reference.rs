//! The reference in more digits: against closed forms, its own laws, and what it refuses.

use approx::assert_relative_eq;
use eigentone_check::{
    Ball, ChainEnds, ExactMass, ExactMotion, Reference, ReferenceError, ReferenceModes,
    ReferenceResponse, UndampedPair, UniformChain,
};
use eigentone_modes::{GROUND, System};
use eigentone_response::{
    Harmonic, Hold, Impulse, Load, Problem, Ramp, Response, Samples, State, Step, Trajectory,
};
use faer::{Mat, mat};
use proptest::prelude::*;

use crate::row::in_a_row;
use crate::scenes;

/// Within this part of each other, and both within their radii.
const AGREEMENT: f64 = 1e-32;

#[track_caller]
fn assert_same(a: &Ball, b: &Ball) {
    let near = a.nearest();
    let off = (a.minus(near) - b.minus(near)).abs();
    let slack = AGREEMENT * near.abs();
    assert!(
        off <= slack + a.radius() + b.radius(),
        "{a} and {b} differ by {off:e}"
    );
    assert!(a.radius() <= 1e-33 * near.abs(), "{a}");
}

fn response(problem: &Problem<'_>) -> ReferenceResponse {
    Reference::default()
        .response(problem)
        .expect("within reach")
}

fn modes(system: &System) -> ReferenceModes {
    Reference::default().modes(system).expect("within reach")
}

fn loaded<'a>(system: &'a System, load: impl Into<Load>) -> Problem<'a> {
    let response = Response::of(system).load("m1", load).every(0.5).until(4.0);
    response
        .problem()
        .expect("valid")
        .at(&[1, 8])
        .expect("on the grid")
}

/// Steps of 1/2 s: every instant is a double, so that the closed form is of the same one.
#[test]
fn one_mass_moves_as_its_closed_form() {
    for (m, c, k) in [
        (1.0, 0.0, 4.0),
        (1.3, 0.4, 4.1),
        (1.0, 2.0, 1.0),
        (0.7, 9.0, 4.0),
        (2.5, 0.0, 0.0),
        (2.5, 0.3, 0.0),
        (1.0, 4f64.next_up(), 4.0),
        (1.0, 0.0, 1e-300),
        (1.0, 1e8, 1.0),
    ] {
        let system = scenes::system(m, c, k);
        let exact = ExactMass::new(m, c, k).expect("valid");
        let check = |problem: Problem<'_>, form: &dyn Fn(f64) -> ExactMotion| {
            let found = response(&problem);
            for (position, step) in found.steps().iter().enumerate() {
                let truth = form(0.5 * *step as f64);
                assert_same(&found.displacement(position)[0], &truth.displacement);
                assert_same(&found.velocity(position)[0], &truth.velocity);
            }
        };
        check(loaded(&system, Step::of(1.5)), &|t| exact.step(1.5, t));
        check(loaded(&system, Ramp::of(0.7)), &|t| exact.ramp(0.7, t));
        check(loaded(&system, Impulse::of(1.1)), &|t| {
            exact.impulse(1.1, t)
        });
        for (omega, phase) in [(1.7, 0.3), (2.0, 0.0), (2.0 * (1.0 + 1e-12), 1e3)] {
            let load = Harmonic::of(2.0, omega).with_phase(phase);
            check(loaded(&system, load), &|t| {
                exact.harmonic(2.0, omega, phase, t)
            });
        }
        let released = Response::of(&system)
            .from(State::at_rest().displace("m1", 1.0).push("m1", -0.3))
            .every(0.5)
            .until(4.0);
        check(released.problem().expect("valid"), &|t| {
            exact.free(1.0, -0.3, t)
        });
    }
}

/// A step that starts between two instants, and one that has run since before 0.
#[test]
fn loads_act_from_their_exact_starts() {
    let system = scenes::system(1.3, 0.4, 4.1);
    let exact = ExactMass::new(1.3, 0.4, 4.1).expect("valid");
    let found = response(&loaded(&system, Step::of(1.0).starting_at(0.375)));
    for (position, elapsed) in [0.125, 3.625].into_iter().enumerate() {
        let truth = exact.step(1.0, elapsed);
        assert_same(&found.displacement(position)[0], &truth.displacement);
    }
    let found = response(&loaded(&system, Step::of(1.0).starting_at(-3.0)));
    assert_same(
        &found.displacement(1)[0],
        &exact.step(1.0, 4.0).displacement,
    );
    // 0.1 + 0.2 is no instant of the grid, 3·0.1 is one: there the impulse comes just before.
    let velocity_after = |at: f64| {
        let response = Response::of(&system).load("m1", Impulse::of(1.3).at(at));
        let problem = response.every(0.1).until(1.0).problem();
        response_at(problem.expect("valid"), 3)
    };
    assert_eq!(
        velocity_after(3.0 * 0.1).to_decimal(20),
        "1.0000000000000000000e0"
    );
    assert_eq!(velocity_after((3.0 * 0.1f64).next_up()).to_decimal(20), "0");
}

fn response_at(problem: Problem<'_>, step: u64) -> Ball {
    let found = response(&problem.at(&[step]).expect("on the grid"));
    found.velocity(0)[0].clone()
}

/// Held samples are steps, and straight ones ramps, that end where the next one begins.
#[test]
fn samples_are_sums_of_steps_and_ramps() {
    let system = scenes::system(1.3, 0.4, 4.1);
    let sampled = |hold| Samples {
        step: 0.25,
        values: vec![1.0, 3.0, 2.0],
        hold,
    };
    let sum = |loads: Vec<Load>| {
        let start = Response::of(&system).every(0.5).until(4.0);
        let loaded = loads
            .into_iter()
            .fold(start, |response, load| response.load("m1", load));
        response(&loaded.problem().expect("valid"))
    };
    let step = |force, start| Load::from(Step::of(force).starting_at(start));
    let ramp = |rate, start| Load::from(Ramp::of(rate).starting_at(start));
    let held = vec![step(1.0, 0.0), step(2.0, 0.25), step(-1.0, 0.5)];
    let straight = vec![
        step(1.0, 0.0),
        ramp(8.0, 0.0),
        ramp(-12.0, 0.25),
        ramp(4.0, 0.5),
    ];
    for (hold, parts) in [(Hold::Zero, held), (Hold::First, straight)] {
        let (found, truth) = (sum(vec![sampled(hold).into()]), sum(parts));
        for position in 0..found.steps().len() {
            assert_same(
                &found.displacement(position)[0],
                &truth.displacement(position)[0],
            );
            assert_same(&found.velocity(position)[0], &truth.velocity(position)[0]);
        }
    }
}

fn chain(ends: ChainEnds, count: usize, mass: f64, stiffness: f64) -> System {
    let name = |i: usize| format!("m{i}");
    let mut builder = System::builder();
    for i in 1..=count {
        builder = builder.mass(name(i), mass);
    }
    for i in 1..count {
        builder = builder.spring(name(i), name(i + 1), stiffness);
    }
    if ends != ChainEnds::Free {
        builder = builder.spring(GROUND, name(1), stiffness);
    }
    if ends == ChainEnds::BothGrounded {
        builder = builder.spring(name(count), GROUND, stiffness);
    }
    builder.build().expect("valid")
}

#[test]
fn uniform_chains_have_the_frequencies_and_motions_of_their_closed_form() {
    for ends in [
        ChainEnds::BothGrounded,
        ChainEnds::FirstGrounded,
        ChainEnds::Free,
    ] {
        let system = chain(ends, 12, 0.3, 7.1);
        let form = UniformChain::new(ends, 12, 0.3, 7.1).expect("valid");
        let found = modes(&system);
        let upper = found
            .eigenvalues()
            .iter()
            .filter(|root| root.im.nearest() > 0.0);
        let rigid = usize::from(ends == ChainEnds::Free);
        let frequencies = form.natural_frequencies();
        assert_eq!(upper.clone().count(), 12 - rigid);
        for (root, frequency) in upper.zip(&frequencies[rigid..]) {
            assert_same(&root.im, frequency);
            assert_eq!((root.re.nearest(), root.re.radius()), (0.0, 0.0));
        }
        let problem = Response::of(&system)
            .from(State::at_rest().displace("m1", 1.0).push("m5", 0.5))
            .every(0.5)
            .until(20.0)
            .problem();
        let found = response(&problem.expect("valid").at(&[40]).expect("on the grid"));
        let (mut x0, mut v0) = ([0.0; 12], [0.0; 12]);
        (x0[0], v0[4]) = (1.0, 0.5);
        for (i, truth) in form
            .free(&x0, &v0, 20.0)
            .expect("12 masses")
            .iter()
            .enumerate()
        {
            assert_same(&found.displacement(0)[i], &truth.displacement);
            assert_same(&found.velocity(0)[i], &truth.velocity);
        }
    }
}

#[test]
fn pairs_have_the_frequencies_and_motions_of_their_closed_form() {
    for ([m1, m2], [k1, k12, k2]) in [
        ([2.0, 0.5], [3.0, 0.7, 0.0]),
        ([1.0, 1.0], [1.0, 1e16, 0.0]),
        ([1.0, 1.0], [1.0, 1e-14, 1.0]),
    ] {
        let system = in_a_row(&[("m1", m1), ("m2", m2)], &[k1, k12, k2], &[]);
        let form = UndampedPair::new([m1, m2], [k1, k12, k2]).expect("valid");
        let found = modes(&system);
        let upper = found
            .eigenvalues()
            .iter()
            .filter(|root| root.im.nearest() > 0.0);
        for (root, frequency) in upper.zip(form.natural_frequencies()) {
            assert_same(&root.im, &frequency);
        }
        let found = response(&loaded(&system, Step::of(1.0)));
        for (i, truth) in form.step([1.0, 0.0], 4.0).iter().enumerate() {
            assert_same(&found.displacement(1)[i], &truth.displacement);
            assert_same(&found.velocity(1)[i], &truth.velocity);
        }
    }
}

/// −1 three times: what loses two thirds of the digits of a double.
#[test]
fn multiplicities_are_exact() {
    let system = System::from_matrices(
        mat![[9.0, 0.0], [0.0, 0.0]].as_ref(),
        mat![[0.0, 0.0], [0.0, 8.0]].as_ref(),
        mat![[27.0, -24.0], [-24.0, 24.0]].as_ref(),
    );
    let found = modes(&system.expect("valid"));
    assert_eq!((found.eigenvalues().len(), found.infinite()), (1, 1));
    let root = &found.eigenvalues()[0];
    assert_eq!(root.multiplicity, 3);
    assert_eq!(
        root.re.to_decimal(34),
        "-1.000000000000000000000000000000000e0"
    );
    // Three free masses: 0 twice, and two repeated pairs of an equilateral triangle.
    let triangle = System::builder()
        .mass("a", 1.0)
        .mass("b", 1.0)
        .mass("c", 1.0)
        .spring("a", "b", 2.0)
        .spring("b", "c", 2.0)
        .spring("c", "a", 2.0)
        .build();
    let found = modes(&triangle.expect("valid"));
    let counts: Vec<usize> = found
        .eigenvalues()
        .iter()
        .map(|root| root.multiplicity)
        .collect();
    assert_eq!(counts, [2, 2, 2]);
    assert!(
        found.eigenvalues()[0].re.nearest() == 0.0 && found.eigenvalues()[0].im.radius() == 0.0
    );
}

/// A motion asked for in any order, with repeats, is the same motion.
#[test]
fn instants_come_in_the_order_asked_for() {
    let system = scenes::system(1.3, 0.4, 4.1);
    let problem = loaded(&system, Step::of(1.0))
        .at(&[8, 0, 3, 8])
        .expect("on the grid");
    let found = response(&problem);
    assert_eq!(found.steps(), [8, 0, 3, 8]);
    let sorted = response(&problem.at(&[0, 3, 8]).expect("on the grid"));
    for (position, other) in [(0, 2), (1, 0), (2, 1), (3, 2)] {
        assert_same(
            &found.displacement(position)[0],
            &sorted.displacement(other)[0],
        );
    }
}

/// Asked for more digits, it agrees with itself to those that were there before.
#[test]
fn more_digits_continue_fewer() {
    let system = chain(ChainEnds::FirstGrounded, 4, 1.0, 2.0);
    let problem = loaded(&system, Ramp::of(1.0));
    let few = Reference::with_digits(20)
        .response(&problem)
        .expect("within reach");
    let many = Reference::with_digits(60)
        .response(&problem)
        .expect("within reach");
    assert!(many.bits() > few.bits());
    for (few, many) in few.displacement(1).iter().zip(many.displacement(1)) {
        assert!((few.nearest() - many.nearest()).abs() <= few.radius() + many.radius());
        assert!(many.radius() <= 1e-60 * many.nearest().abs());
        let near = many.nearest();
        assert!((few.minus(near) - many.minus(near)).abs() <= 1.01 * few.radius() + 1e-40);
    }
}

/// λ² = −2 is met exactly, in fewer bits than its root needs.
#[test]
fn exact_squares_have_roots_of_any_number_of_digits() {
    let system = in_a_row(&[("m1", 1.0)], &[2.0], &[]);
    let modes = Reference::with_digits(100).modes(&system).expect("found");
    let digits = "1.414213562373095048801688724209698078569671875376948073176679737990732478462107038850387534327641573e0";
    assert_eq!(modes.eigenvalues()[0].im.to_decimal(100), digits);
}

/// Errors planted below the last place of a double's neighbours are found as they are.
#[test]
fn errors_are_measured_from_the_truth_and_not_from_its_rounding() {
    let system = scenes::system(1.0, 0.0, 3.0);
    let problem = loaded(&system, Step::of(1.0));
    let reference = response(&problem);
    let truth = |k: usize| (&reference.displacement(k)[0], &reference.velocity(k)[0]);
    let answer = |off: f64| {
        let x = Mat::from_fn(1, 2, |_, k| {
            truth(k).0.nearest() + if k == 1 { off } else { 0.0 }
        });
        let v = Mat::from_fn(1, 2, |_, k| truth(k).1.nearest());
        Trajectory::new("planted", vec![1, 8], vec![0.5, 4.0], x, v)
    };
    let largest = truth(0).0.nearest().max(truth(1).0.nearest());
    let error = reference.error_of(&answer(1e-3)).expect("the same problem");
    assert_relative_eq!(error.displacement, 1e-3 / largest, max_relative = 1e-12);
    let error = reference.error_of(&answer(0.0)).expect("the same problem");
    let rounding = |k: usize| truth(k).0.minus(truth(k).0.nearest()).abs();
    let expected = (rounding(0) / truth(0).0.nearest()).max(rounding(1) / largest);
    assert!(expected > 1e-19 && expected <= f64::EPSILON / 2.0);
    assert_relative_eq!(error.displacement, expected, max_relative = 1e-12);
    let nan = reference
        .error_of(&answer(f64::NAN))
        .expect("the same problem");
    assert_eq!(nan.displacement, f64::INFINITY);
    let other = problem.at(&[1]).expect("on the grid");
    let other = response(&other).error_of(&answer(0.0));
    assert_eq!(other.err(), Some(ReferenceError::OtherProblem));
}

#[test]
fn eigenvalues_of_doubles_are_measured() {
    let system = chain(ChainEnds::BothGrounded, 6, 0.3, 7.1);
    let found = modes(&system).error_of(&system.modes().expect("it has modes"));
    let error = found.expect("the same system");
    assert!(error.modulus > 1e-18 && error.modulus <= 4e-16, "{error:?}");
    assert_eq!(error.real_part, 0.0);
    let other = chain(ChainEnds::BothGrounded, 5, 0.3, 7.1);
    let wrong = modes(&system).error_of(&other.modes().expect("it has modes"));
    assert_eq!(wrong, Err(ReferenceError::OtherProblem));
}

#[test]
fn what_it_cannot_do_is_refused() {
    let large = chain(ChainEnds::BothGrounded, 400, 1.0, 1.0);
    let refusal = Reference::default().modes(&large);
    assert!(
        matches!(refusal, Err(ReferenceError::TooMuchWork { .. })),
        "{refusal:?}"
    );
    let refusal = Reference::default().response(&loaded(&large, Step::of(1.0)));
    assert!(matches!(refusal, Err(ReferenceError::TooMuchWork { .. })));
    let small = chain(ChainEnds::BothGrounded, 3, 1.0, 1.0);
    let refusal = Reference::default().within(100.0).modes(&small);
    assert!(matches!(refusal, Err(ReferenceError::TooMuchWork { .. })));
    let long = Response::of(&small).every(1.0).until(1e15).problem();
    let refusal = Reference::default().response(&long.expect("valid"));
    assert!(matches!(refusal, Err(ReferenceError::TooMuchWork { .. })));
    // A mass matrix of rank 1 without an empty row.
    let singular = System::from_matrices(
        mat![[1.0, 1.0], [1.0, 1.0]].as_ref(),
        mat![[0.0, 0.0], [0.0, 0.0]].as_ref(),
        mat![[2.0, 0.0], [0.0, 3.0]].as_ref(),
    );
    let singular = singular.expect("valid");
    let problem = Response::of(&singular).every(0.1).until(1.0).problem();
    let refusal = Reference::default().response(&problem.expect("valid"));
    assert_eq!(refusal.err(), Some(ReferenceError::SingularMass));
    assert_eq!(modes(&singular).infinite(), 2);
    // Two nodes without mass, joined by a damper: an impulse displaces both without limit.
    let joined = System::builder()
        .mass("m1", 1.0)
        .mass("p", 0.0)
        .mass("q", 0.0)
        .spring("m1", "p", 1.0)
        .damper("p", "q", 1.0)
        .spring("q", GROUND, 1.0)
        .build()
        .expect("valid");
    let problem = Response::of(&joined)
        .load("p", Impulse::of(1.0))
        .every(0.1)
        .until(1.0)
        .problem();
    let refusal = Reference::default().response(&problem.expect("valid"));
    assert_eq!(
        refusal.err(),
        Some(ReferenceError::ImpulseGivesWay { load: 0 })
    );
}

/// Free masses have roots at 0 alone, nodes without mass on springs none that is finite.
#[test]
fn systems_without_any_other_root_than_0_are_answered() {
    let free = in_a_row(&[("a", 1.0), ("b", 2.0)], &[], &[]);
    let found = modes(&free);
    let [root] = found.eigenvalues() else {
        panic!("{found:?}");
    };
    assert_eq!((root.multiplicity, found.infinite()), (4, 0));
    assert!(root.re.minus(0.0) == 0.0 && root.im.minus(0.0) == 0.0);
    let still = in_a_row(&[("p", 0.0)], &[1.0], &[]);
    assert!(modes(&still).eigenvalues().is_empty());
    assert_eq!(modes(&still).infinite(), 2);
}

/// By a factor of e^(2e7), which no number of bits in reach holds; what is moved and what is not.
#[test]
fn what_grows_too_fast_is_refused_at_once() {
    let unstable = System::builder()
        .mass("m1", 1.0)
        .mass("still", 1.0)
        .spring(GROUND, "m1", -1e14)
        .spring(GROUND, "still", 1.0);
    let unstable = unstable.build().expect("valid");
    for name in ["m1", "still"] {
        let asked = Response::of(&unstable).from(State::at_rest().displace(name, 1.0));
        let problem = asked.every(1.0).until(2.0).problem().expect("valid");
        let refusal = Reference::default().response(&problem);
        assert_eq!(refusal.err(), Some(ReferenceError::TooFast));
    }
    // e^1000 is beyond the doubles, and no trouble.
    let asked = Response::of(&unstable).from(State::at_rest().displace("m1", 1.0));
    let problem = asked.every(1e-4).until(1e-4).problem().expect("valid");
    let found = response(&problem);
    assert_eq!(found.displacement(1)[0].to_decimal(5), "9.8504e433");
}

#[test]
fn no_instants_and_only_the_first_are_answered() {
    let system = scenes::system(1.3, 0.4, 4.1);
    let problem = loaded(&system, Impulse::of(2.6));
    assert!(
        response(&problem.clone().at(&[]).expect("none"))
            .steps()
            .is_empty()
    );
    let found = response(&problem.at(&[0]).expect("on the grid"));
    assert_eq!(found.displacement(0)[0].to_decimal(5), "0");
    assert_eq!(found.velocity(0)[0].to_decimal(5), "2.0000e0");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// The proven bounds of the library hold for random chains, by what shares no code with them.
    #[test]
    fn proven_bounds_of_doubles_hold(
        masses in prop::array::uniform3(-2.0..2.0f64),
        springs in prop::array::uniform3(-4.0..6.0f64),
        dampers in prop::array::uniform3(-6.0..3.0f64),
        start in 0.0..3.0f64,
        frequency in 0.0..20.0f64,
    ) {
        let power = |exponent: f64| 10f64.powf(exponent);
        let system = System::builder()
            .mass("m1", power(masses[0]))
            .mass("m2", power(masses[1]))
            .mass("m3", power(masses[2]))
            .spring(GROUND, "m1", power(springs[0]))
            .spring("m1", "m2", power(springs[1]))
            .spring("m2", "m3", power(springs[2]))
            .damper("m1", "m2", power(dampers[0]))
            .damper("m2", "m3", power(dampers[1]))
            .damper("m3", GROUND, power(dampers[2]))
            .build()
            .expect("valid");
        let asked = Response::of(&system)
            .from(State::at_rest().displace("m2", 1.0))
            .load("m1", Step::of(2.0).starting_at(start))
            .load("m3", Ramp::of(-0.3))
            .load("m2", Harmonic::of(1.5, frequency))
            .every(0.05)
            .until(5.0);
        let reference = response(&asked.clone().problem().expect("valid"));
        let found = asked.run().expect("it has a response");
        for k in 0..found.len() {
            let kinds = [
                (reference.displacement(k), found.displacement(), found.displacement_bound()),
                (reference.velocity(k), found.velocity(), found.velocity_bound()),
            ];
            for (truth, values, bound) in kinds {
                let bound = bound[k].expect("it is proven");
                for (i, truth) in truth.iter().enumerate() {
                    let off = truth.minus(values[(i, k)]).abs();
                    prop_assert!(off <= bound, "{off:e} > {bound:e} at instant {k}");
                }
            }
        }
        let truth = modes(&system);
        let found = system.modes().expect("it has modes");
        let count: usize = truth.eigenvalues().iter().map(|root| root.multiplicity).sum();
        prop_assert_eq!(count, found.eigenvalues().len());
        for root in found.eigenvalues() {
            let bound = root.bound.expect("it is proven");
            let holds = |truth: &eigentone_check::ReferenceEigenvalue| {
                truth.re.minus(root.value.re).hypot(truth.im.minus(root.value.im)) <= bound
            };
            prop_assert!(truth.eigenvalues().iter().any(holds), "{root:?}");
        }
    }
}
