//! What decays to rest under a constant load keeps its digits in doubles: velocities against 80-digit
//! exponentials by mpmath.

use eigentone_modes::{Precision, System};
use eigentone_response::{
    ByExponential, BySuperposition, Output, Problem, Response, ResponseMethod, State, Step,
};

use crate::systems::in_a_row;

fn system(damper: f64) -> System {
    in_a_row(&[("a", 1.5), ("b", 0.75)], &[20.0, 12.0], &[2.5, damper])
}

fn loaded(system: &System) -> Problem<'_> {
    Response::of(system)
        .from(
            State::at_rest()
                .displace("a", 0.5)
                .displace("b", -0.25)
                .push("b", 2.0),
        )
        .load("b", Step::of(7.0))
        .every(0.0625)
        .until(100.0)
        .to(Precision::Double)
        .problem()
        .expect("well posed")
}

/// Step, and both velocities.
type Truth = [(usize, [f64; 2]); 3];

/// Dampers that couple the modes, and such that are in proportion to the springs.
const COUPLED: (f64, Truth) = (
    1.25,
    [
        (16, [0.221_888_661_453_720_08, -0.736_021_774_445_950_6]),
        (640, [-5.280_400_221_380_941e-8, -9.360_407_409_420_26e-8]),
        (
            1600,
            [-5.333_730_874_473_183e-19, -9.378_776_763_451_596e-19],
        ),
    ],
);
const CLASSICAL: (f64, Truth) = (
    1.5,
    [
        (16, [0.198_505_596_551_130_15, -0.564_305_543_219_994_2]),
        (
            640,
            [-2.400_133_928_500_469_3e-8, -4.287_358_391_265_764e-8],
        ),
        (
            1600,
            [-8.177_979_268_572_387e-20, -1.460_832_148_755_003_2e-19],
        ),
    ],
);

/// Rounding of the step matrix alone makes up 1600 units; beside the resting displacements, the last velocities
/// are smaller than one unit.
const NEAR: f64 = 2e-12;

fn check(name: &str, truth: &Truth, found: impl Fn(usize, usize) -> f64) {
    for (step, known) in truth {
        let size = known[0].abs().max(known[1].abs());
        for (i, known) in known.iter().enumerate() {
            let off = (found(i, *step) - known).abs() / size;
            assert!(off < NEAR, "{name}, step {step}: {off:e}");
        }
    }
}

#[test]
fn velocities_keep_their_digits() {
    for (damper, truth) in [COUPLED, CLASSICAL] {
        let system = system(damper);
        let problem = loaded(&system);
        let methods: [&dyn ResponseMethod; 2] = [&ByExponential, &BySuperposition];
        for method in methods {
            let motion = method.run(&problem).expect("it applies");
            check(method.name(), &truth, |i, step| {
                motion.velocity()[(i, step)]
            });
            let rest = motion.displacement()[(0, 1600)];
            assert!((rest - 0.35).abs() < 1e-16, "{}: {rest}", method.name());
        }
    }
}

#[test]
fn so_do_those_of_few_outputs() {
    let outputs = [0, 1].map(Output::Velocity);
    for ((damper, truth), method) in [(COUPLED, "exponential"), (CLASSICAL, "modal recurrence")] {
        let system = system(damper);
        let history = eigentone_response::History::of(&loaded(&system), &outputs);
        let history = history.expect("well posed");
        assert_eq!(history.method(), method);
        check(method, &truth, |i, step| history.values()[(i, step)]);
    }
}

/// A load that comes later, and one that changes, move the rest.
#[test]
fn rests_follow_the_load() {
    let system = system(1.25);
    let ask = |end: f64| {
        Response::of(&system)
            .load("b", Step::of(7.0))
            .load("b", Step::of(-7.0).starting_at(100.0))
            .load("a", Step::of(2.0).starting_at(200.0))
            .every(0.0625)
            .until(end)
            .to(Precision::Double)
    };
    let motion = ask(300.0).run_by(&ByExponential).expect("it applies");
    let x = motion.displacement();
    // K⁻¹ of springs in a row.
    for (step, rest) in [
        (1600, [0.35, 0.35 + 7.0 / 12.0]),
        (3200, [0.0; 2]),
        (4800, [0.1; 2]),
    ] {
        for (i, rest) in rest.into_iter().enumerate() {
            assert!(
                (x[(i, step)] - rest).abs() < 1e-15,
                "{i}, {step}: {}",
                x[(i, step)]
            );
        }
    }
}
