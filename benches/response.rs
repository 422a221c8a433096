//! Exact methods, and an integrator to compare with, on the gallery and on chains.

mod chain;

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use eigentone::check::{Dop853, Integrator};
use eigentone::gallery::cases;
use eigentone::prelude::*;
use eigentone::response::{Problem, methods};
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
    let predicted = integrator.predict(problem).map(|told| told.steps);
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

criterion_group!(benches, gallery, chains);
criterion_main!(benches);
