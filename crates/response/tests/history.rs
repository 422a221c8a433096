//! Few outputs of a response, in blocks of steps, against the whole motion step by step.

use eigentone_modes::{GROUND, Precision, System};
use eigentone_response::{
    ByCertifiedExponential, ByExponential, Harmonic, History, Hold, Impulse, Load, Output, Problem,
    Quantity, Ramp, Response, ResponseError, ResponseMethod, Samples, State, Step, Trajectory,
};

use crate::systems::{chain_of, in_a_row};

const OUTPUTS: [Output; 3] = [
    Output::Displacement(1),
    Output::Velocity(0),
    Output::Displacement(2),
];

/// A chain of `n` unequal masses whose dampers couple its modes.
fn chain(n: usize) -> System {
    chain_of(n, |i| {
        let stiffness = 50.0 + (7 * i % 11) as f64;
        [1.0 + (i % 3) as f64, stiffness, 0.1 + (i % 2) as f64]
    })
}

fn samples(every: f64, hold: Hold) -> Samples {
    let values = (0..40).map(|j| ((3 * j) % 7) as f64 - 2.5).collect();
    Samples {
        step: 0.05 * every,
        values,
        hold,
    }
}

fn problem<'a>(system: &'a System, loads: &[(&str, Load)]) -> Problem<'a> {
    let response = Response::of(system)
        .from(State::at_rest().displace("m2", 0.3).push("m1", -2.0))
        .every(0.05)
        .until(30.0)
        .to(Precision::Double);
    let loaded = loads.iter().fold(response, |response, (name, load)| {
        response.load(*name, load.clone())
    });
    loaded.problem().expect("well posed")
}

/// The worst difference over the largest value of each output.
fn difference(history: &History, trajectory: &Trajectory) -> f64 {
    assert_eq!(history.len(), trajectory.len());
    let mut worst = 0.0f64;
    for (i, output) in history.outputs().iter().enumerate() {
        let known = match output {
            Output::Displacement(row) => trajectory.displacement().row(*row),
            Output::Velocity(row) => trajectory.velocity().row(*row),
        };
        let off = (history.values().row(i) - known).norm_max();
        worst = worst.max(off / known.norm_max());
    }
    worst
}

fn agree(system: &System, loads: &[(&str, Load)]) {
    let problem = problem(system, loads);
    let history = History::of(&problem, &OUTPUTS).expect("well posed");
    let trajectory = ByExponential.run(&problem);
    let trajectory = trajectory.expect("well posed");
    let off = difference(&history, &trajectory);
    assert!(off < 1e-12, "{loads:?}: {off:e}");
    for j in [0, 1, 17, 300, 600] {
        assert_eq!(history.step(j), j as u64);
        assert_eq!(history.time(j), trajectory.times()[j]);
        let bound = history.bound(0, j).expect("passive and supported");
        let other = trajectory.displacement_bound()[j].expect("passive and supported");
        let off = (history.values()[(0, j)] - trajectory.displacement()[(1, j)]).abs();
        assert!(off <= bound, "instant {j}: {off:e}, {bound:e}");
        // It holds up to the end of some steps, here of all.
        let alike = other / 8.0..8.0 * other;
        assert!(j < 600 || alike.contains(&bound), "{bound:e}, {other:e}");
    }
}

#[test]
fn blocks_give_what_steps_give() {
    for n in [3, 8, 40] {
        let system = chain(n);
        let every_kind: [(&str, Load); 9] = [
            ("m1", Step::of(3.0).into()),
            ("m2", Step::of(-1.0).starting_at(0.35).into()),
            ("m3", Ramp::of(0.5).starting_at(-2.0).into()),
            ("m3", Ramp::of(-0.5).starting_at(10.0).into()),
            ("m1", samples(1.0, Hold::First).into()),
            ("m2", samples(1.0, Hold::Zero).into()),
            ("m2", samples(3.0, Hold::First).into()),
            ("m1", Harmonic::of(2.0, 3.0).with_phase(0.4).into()),
            ("m3", Impulse::of(4.0).into()),
        ];
        agree(&system, &[]);
        for load in &every_kind {
            agree(&system, std::slice::from_ref(load));
        }
        agree(&system, &every_kind);
    }
}

/// The largest difference to a proven answer, of displacements and velocities in proportion to the largest of each.
fn off_truth(history: &History, problem: &Problem<'_>) -> f64 {
    let known = ByCertifiedExponential.run(problem).expect("it applies");
    difference(history, &known)
}

/// Mode by mode: classical damping, with every kind of load.
#[test]
fn modes_give_what_is_proven() {
    let system = chain_of(5, |i| {
        let stiffness = 48.0 + (8 * i % 32) as f64;
        [1.0 + (i % 3) as f64, stiffness, stiffness / 256.0]
    });
    let loads: [(&str, Load); 6] = [
        ("m1", Step::of(3.0).into()),
        ("m3", Ramp::of(0.5).starting_at(10.0).into()),
        ("m1", samples(1.0, Hold::First).into()),
        ("m2", samples(2.0, Hold::Zero).into()),
        ("m5", Harmonic::of(2.0, 3.0).with_phase(0.4).into()),
        ("m3", Impulse::of(4.0).into()),
    ];
    for loads in [&[][..], &loads[..1], &loads[2..3], &loads] {
        let problem = problem(&system, loads);
        let history = History::of(&problem, &OUTPUTS).expect("well posed");
        assert_eq!(history.method(), "modal recurrence");
        let off = off_truth(&history, &problem);
        assert!(off < 1e-13, "{loads:?}: {off:e}");
        assert!(
            history.bound(1, 600) < Some(1e-9),
            "{:?}",
            history.bound(1, 600)
        );
    }
}

/// A road through a spring and a damper, whose samples do not begin at 0: the jump is an impulse, and slopes act too.
#[test]
fn roads_through_dampers_go_in_strides() {
    let system = System::builder()
        .mass("m1", 290.0)
        .mass("m2", 59.0)
        .mass("m3", 7.0)
        .support("road")
        .spring("m1", "m2", 16812.0)
        .damper("m1", "m2", 1000.0)
        .spring("m2", "m3", 9e3)
        .damper("m2", "m3", 30.0)
        .spring("m2", "road", 190_000.0)
        .damper("m2", "road", 50.0)
        .build()
        .expect("a system");
    for every in [1.0, 3.0] {
        let problem = Response::of(&system)
            .motion("road", Quantity::Displacement, samples(every, Hold::First))
            .load("m1", Step::of(3.0))
            .every(0.05)
            .until(10.0)
            .to(Precision::Double)
            .problem()
            .expect("well posed");
        let history = History::of(&problem, &OUTPUTS).expect("well posed");
        let operations = history.operations();
        assert!(operations.steps < history.len() as u64, "{operations:?}");
        let off = off_truth(&history, &problem);
        assert!(off < 1e-13, "{every}: {off:e}");
    }
}

/// Stiff, with damping that couples the real modes, some of which relax: single real roots.
#[test]
fn stiff_motions_go_by_modes() {
    let system = chain_of(6, |i| {
        let stiffness = 2e4 + 1e3 * i as f64;
        let damping = if i == 4 { 2e3 } else { 0.25 };
        [1.0 + 0.125 * i as f64, stiffness, damping]
    });
    let real = |root: &eigentone_modes::Eigenvalue| root.value.im == 0.0;
    let modes = system.modes().expect("it has modes");
    assert!(modes.eigenvalues().iter().any(real));
    let problem = problem(&system, &[("m6", samples(1.0, Hold::First).into())]);
    let history = History::of(&problem, &OUTPUTS).expect("well posed");
    assert_eq!(history.method(), "modal recurrence");
    let off = off_truth(&history, &problem);
    assert!(off < 1e-11, "{off:e}");
}

/// What blocks cannot do is picked from the whole motion.
#[test]
fn other_problems_are_answered_too() {
    let system = chain(4);
    let between: [(&str, Load); 3] = [
        ("m1", Step::of(1.0).starting_at(0.123).into()),
        ("m2", Impulse::of(1.0).at(2.0).into()),
        ("m3", samples(0.5, Hold::First).into()),
    ];
    for load in &between {
        agree(&system, std::slice::from_ref(load));
    }
    let chosen = problem(&system, &between).at(&[500, 3, 3]).expect("within");
    let history = History::of(&chosen, &OUTPUTS).expect("well posed");
    assert_eq!(history.values().shape(), (3, 3));
    let whole = History::of(&problem(&system, &between), &OUTPUTS).expect("well posed");
    let off = (history.values().col(0) - whole.values().col(500)).norm_max();
    assert!(off < 1e-12);
    assert_eq!(history.step(1), 3);

    let beyond = History::of(&chosen, &[Output::Velocity(4)]);
    let error = ResponseError::NoCoordinate {
        index: 4,
        coordinates: 4,
    };
    assert_eq!(beyond, Err(error));
}

/// A motion that leaves the range of doubles is an error, and one that would do so only after the end
/// is not.
#[test]
fn growth_is_watched() {
    let system = System::builder()
        .mass("a", 1.0)
        .mass("b", 1.0)
        .spring(GROUND, "a", -400.0)
        .spring("a", "b", 1.0)
        .damper("a", "b", 0.3)
        .build()
        .expect("a system");
    let until = |end: f64| {
        Response::of(&system)
            .from(State::at_rest().displace("a", 1.0))
            .every(0.0625)
            .until(end)
            .to(Precision::Double)
            .follow(&[Output::Displacement(0), Output::Displacement(1)])
    };
    // e^{20 t} reaches the largest double after 35.5 s.
    assert!(until(35.0).is_ok());
    assert!(matches!(until(37.0), Err(ResponseError::Overflow { .. })));
}

/// A stride that ends at rest has bounds for what came before.
#[test]
fn bounds_hold_where_a_stride_ends_at_rest() {
    let system = in_a_row(&[("m", 1.0)], &[1.0], &[1.0]);
    let samples = Samples {
        step: 1.0,
        values: vec![1.0, 0.0],
        hold: Hold::Zero,
    };
    let asked = Response::of(&system).load("m", samples);
    let asked = asked.every(0.05).until(40.0).to(Precision::Double);
    let problem = asked.problem().expect("well posed");
    let history = History::of(&problem, &[Output::Displacement(0)]).expect("well posed");
    for j in 0..history.len() {
        let value = history.values()[(0, j)];
        let bound = history.bound(0, j).expect("passive and held");
        // Half a unit in the last place.
        assert!(
            bound >= value.abs() * f64::EPSILON / 4.0,
            "{j}: {value:e} {bound:e}"
        );
    }
}
