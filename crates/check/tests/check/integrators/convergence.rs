//! The order of every method, against the proven response: its error is in proportion to h^order.
//! Three masses with dampers under a harmonic load and a constant one, which is sampled at every
//! instant. So every method restarts at every instant, and those that size their steps by a
//! tolerance, here one that allows anything, step from instant to instant like the others.

use eigentone_check::{
    Dop853, DormandPrince5, GeneralizedAlpha, HhtAlpha, Integrator, Limit, Newmark, Radau5,
    RungeKutta4, TrajectoryError,
};
use eigentone_modes::System;
use eigentone_response::{
    ByCertifiedExponential, Harmonic, Hold, Load, Problem, Response, Samples, State, Step,
    Trajectory,
};

use super::{chain, run};

const END: f64 = 40.0;

fn problem(system: &System, steps: u32, constant: Load) -> Problem<'_> {
    let response = Response::of(system)
        .from(State::at_rest().displace("a", 1.0).push("c", -0.5))
        .load("b", Harmonic::of(2.0, 1.7).with_phase(0.3))
        .load("a", constant)
        .every(END / f64::from(steps))
        .until(END);
    response.problem().expect("valid")
}

/// The proven motion at so many steps.
fn truth(system: &System, steps: u32) -> Trajectory {
    let problem = problem(system, steps, Step::of(3.0).into());
    run(&ByCertifiedExponential, &problem)
}

/// The largest error on the way, with so many steps.
fn error(method: &dyn Integrator, system: &System, steps: u32, truth: &Trajectory) -> f64 {
    let constant = Samples {
        step: END / f64::from(steps),
        values: vec![3.0; steps as usize],
        hold: Hold::Zero,
    };
    let problem = problem(system, steps, constant.into());
    let answer = method.integrate(&problem, Limit::default());
    let (answer, work) = answer.expect("applies");
    // Some begin with a few shorter ones.
    assert!(u64::from(steps) <= work.accepted && work.accepted < u64::from(steps) + 8);
    assert_eq!(work.rejected, 0);
    let error = TrajectoryError::between(&answer, truth);
    error.displacement.max(error.velocity)
}

/// The slope of the line through points, by least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let x = points.iter().map(|point| point.0).sum::<f64>() / count;
    let y = points.iter().map(|point| point.1).sum::<f64>() / count;
    let rises = points
        .iter()
        .map(|point| (point.0 - x) * (point.1 - y))
        .sum::<f64>();
    let runs = points.iter().map(|point| (point.0 - x).powi(2));
    rises / runs.sum::<f64>()
}

/// Prints the errors and the order that they show; says what is wrong with it.
fn observe(
    system: &System,
    method: &dyn Integrator,
    grids: &[(u32, Trajectory)],
    order: f64,
) -> Option<String> {
    let mut points = Vec::new();
    println!("{}", method.name());
    for (steps, truth) in grids {
        let error = error(method, system, *steps, truth);
        println!("{steps:>8} steps: {error:.2e}");
        points.push((f64::from(*steps).ln(), error.ln()));
    }
    let observed = -slope(&points);
    println!("   order {observed:.3} of {order}");
    let wrong = (observed - order).abs() > 0.1;
    wrong.then(|| format!("{}: {observed}", method.name()))
}

/// Truths at some numbers of steps.
fn grids(system: &System, steps: [u32; 5]) -> [(u32, Trajectory); 5] {
    steps.map(|steps| (steps, truth(system, steps)))
}

#[test]
fn methods_have_their_order() {
    let system = chain();
    // Where the error follows its leading term, and is far above what is rounded.
    let long = grids(&system, [260, 320, 400, 500, 640]);
    let short = grids(&system, [640, 800, 1000, 1280, 1600]);
    let undamped_at_infinity = GeneralizedAlpha {
        substeps: 1,
        spectral_radius: 1.0,
    };
    let cases: [(f64, _, &dyn Integrator); 11] = [
        (2.0, &short, &Newmark::with_substeps(1)),
        (2.0, &short, &Newmark::linear_acceleration(1)),
        (2.0, &short, &Newmark::central_difference(1)),
        (2.0, &short, &HhtAlpha::with_substeps(1)),
        (2.0, &short, &HhtAlpha::with_spectral_radius(1, 0.5)),
        (2.0, &short, &GeneralizedAlpha::with_substeps(1)),
        (2.0, &short, &undamped_at_infinity),
        (4.0, &short, &RungeKutta4::with_substeps(1)),
        (5.0, &short, &DormandPrince5::with_tolerance(1.0)),
        (5.0, &short, &Radau5::with_tolerance(1.0)),
        (8.0, &long, &Dop853::with_tolerance(1.0)),
    ];
    let wrong = cases.map(|(order, grids, method)| observe(&system, method, grids, order));
    let wrong: Vec<String> = wrong.into_iter().flatten().collect();
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[cfg(feature = "stiff")]
#[test]
fn diagonally_implicit_methods_have_their_order() {
    use eigentone_check::{Esdirk34, TrBdf2};
    let system = chain();
    let grids = grids(&system, [1600, 2000, 2500, 3200, 4000]);
    let cases: [(f64, &dyn Integrator); 2] = [
        (2.0, &TrBdf2::with_tolerance(1.0)),
        (3.0, &Esdirk34::with_tolerance(1.0)),
    ];
    let wrong = cases.map(|(order, method)| observe(&system, method, &grids, order));
    let wrong: Vec<String> = wrong.into_iter().flatten().collect();
    assert!(wrong.is_empty(), "{wrong:?}");
}
