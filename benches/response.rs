//! Exact methods, and an integrator to compare with, on the gallery and on chains.

mod chain;

use std::hint::black_box;
use std::time::Duration;

use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use eigentone::check::{Dop853, Integrator};
use eigentone::gallery::cases;
use eigentone::prelude::*;
use eigentone::response::{
    ByExponential, History, Output, Problem, Quantity, ResponsePlan, methods,
};
use faer::Mat;

use chain::Chain;

/// What the integrator is asked for, and what methods without bounds reach, of the largest displacement.
const ASKED: f64 = 1e-10;
const UNBOUNDED: f64 = 1e-7;
/// Systems that it would take long over.
const STIFF: f64 = 1e5;

/// Columns of displacements at some steps, and how far they are off, relative to the largest entry of each.
struct Truth {
    steps: Vec<u64>,
    columns: Mat<f64>,
    error: f64,
}

/// Exact methods are held to their bounds.
fn compare(c: &mut Criterion, name: &str, problem: &Problem<'_>, truth: &Truth) {
    let mut group = c.benchmark_group("response");
    group.sample_size(10);
    group.measurement_time(Duration::from_secs(1));
    group.warm_up_time(Duration::from_millis(300));
    let integrator = Dop853::with_tolerance(ASKED);
    let exact = methods().iter().copied();
    let predicted = integrator.predict(problem).map(|predicted| predicted.steps);
    let affordable = predicted.is_ok_and(|steps| steps < STIFF);
    let integrators = affordable.then_some(&integrator as &dyn ResponseMethod);
    for method in exact.chain(integrators) {
        if method.refuses(problem).is_some() {
            continue;
        }
        let run = || method.run(black_box(problem));
        let motion = run().expect("it does not refuse");
        let columns = &truth.columns;
        let mut right = true;
        for (j, step) in truth.steps.iter().enumerate() {
            let column = motion.steps().iter().position(|known| known == step);
            let column = column.expect("it was asked for");
            let off = (columns.col(j) - motion.displacement().col(column)).norm_max();
            let rounding = truth.error * columns.col(j).norm_max();
            match motion.displacement_bound()[column] {
                Some(bound) => assert!(
                    off <= bound + rounding,
                    "{name} by {}: {off:e}",
                    method.name()
                ),
                None => right &= off <= UNBOUNDED * columns.norm_max(),
            }
        }
        // A wrong answer, which nothing vouched for, has no run time.
        if !right {
            continue;
        }
        group.bench_function(BenchmarkId::new(method.name(), name), |bencher| {
            bencher.iter(run);
        });
    }
}

fn gallery(c: &mut Criterion) {
    /// Of a longer grid, only the instants whose truth is known.
    const LONGEST: u64 = 10_000;
    for case in cases() {
        let (scene, samples) = (case.scene(), case.truth().response);
        let Some(problem) = scene.problem() else {
            continue;
        };
        let steps: Vec<u64> = samples.iter().map(|sample| sample.step).collect();
        let columns = Mat::from_fn(scene.system().len(), samples.len(), |i, j| {
            samples[j].displacement[i].to_f64()
        });
        let problem = problem.expect("checked when it was read");
        let problem = match problem.grid().last() {
            last if last > LONGEST => problem.at(&steps).expect("within the grid"),
            _ => problem,
        };
        let truth = Truth {
            steps,
            columns,
            error: f64::EPSILON,
        };
        compare(c, case.name(), &problem, &truth);
    }
}

fn chains(c: &mut Criterion) {
    for masses in [3, 20, 100] {
        let chain = Chain {
            masses,
            damping: 0.1,
        };
        let system = chain.system();
        // A middle mode, so that all masses move and none for long.
        let (j, h) = (masses / 3 + 1, 0.25);
        let asked = Response::of(&system)
            .from(chain.state(j))
            .every(h)
            .until(50.0);
        let problem = asked.problem().expect("well posed");
        let steps: Vec<u64> = vec![1, 10, 50, 200];
        let columns = Mat::from_fn(masses, steps.len(), |i, column| {
            chain.motion(j, h * steps[column] as f64).0 * chain.shape(j, i + 1)
        });
        // The closed form is computed in doubles.
        let truth = Truth {
            steps,
            columns,
            error: 1e-13,
        };
        compare(c, &format!("chain of {masses}"), &problem, &truth);
    }
}

/// A quarter car with a damper at a road of a million samples, in doubles: one output, then all of the motion, as it is planned
/// and by exponentials.
fn roads(c: &mut Criterion) {
    const SAMPLES: u32 = 1_000_000;
    let car = System::builder()
        .mass("body", 290.0)
        .mass("wheel", 59.0)
        .support("road")
        .spring("wheel", "body", 16_812.0)
        .damper("wheel", "body", 1000.0)
        .spring("road", "wheel", 190_000.0)
        .damper("road", "wheel", 50.0)
        .build()
        .expect("a system");
    let road = Samples {
        step: 0.01,
        values: (0..SAMPLES)
            .map(|j| f64::from(j * 79 % 1009) / 2e4)
            .collect(),
        hold: Hold::First,
    };
    let asked = Response::of(&car).motion("road", Quantity::Displacement, road);
    let asked = asked.every(0.01).until(0.01 * f64::from(SAMPLES));
    let asked = asked.to(Precision::Double);
    let fresh = || asked.clone().problem().expect("well posed");
    let followed = |problem: &Problem<'_>| {
        let outputs = [Output::Displacement(0)];
        let history = History::of(problem, &outputs).expect("a history");
        history.values()[(0, SAMPLES as usize)]
    };
    let last = |motion: Trajectory| motion.displacement()[(0, SAMPLES as usize)];
    let planned = |problem: &Problem<'_>| {
        let plan = ResponsePlan::of(problem).expect("a plan");
        last(plan.run(problem).expect("a motion"))
    };
    let stepped = |problem: &Problem<'_>| last(ByExponential.run(problem).expect("a motion"));
    type Way<'a> = &'a dyn Fn(&Problem<'_>) -> f64;
    let ways = [
        ("one output", &followed as Way<'_>),
        ("whole, planned", &planned),
        ("whole, exponential", &stepped),
    ];
    let mut group = c.benchmark_group("road of a million samples");
    group.sample_size(10);
    group.throughput(Throughput::Elements(SAMPLES.into()));
    for (name, way) in ways {
        // What was nearly forgotten by the end is the same for all.
        assert!((way(&fresh()) - followed(&fresh())).abs() < 1e-12);
        group.bench_function(name, |bencher| {
            bencher.iter_batched(fresh, |problem| way(&problem), BatchSize::PerIteration);
        });
    }
}

criterion_group!(benches, gallery, chains, roads);
criterion_main!(benches);
