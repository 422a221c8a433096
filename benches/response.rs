//! Exact methods, and an integrator to compare with, on the gallery and on chains.

mod chain;

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use eigentone::check::Dop853;
use eigentone::gallery::cases;
use eigentone::prelude::*;
use eigentone::response::{Problem, methods};
use faer::Mat;

use chain::Chain;

const SCENES: [&str; 5] = [
    "micro-units",
    "one-mass-resonance",
    "sampled-first",
    "three-mass-1",
    "two-mass-free",
];

/// What exact methods reach on these systems, and what the integrator is asked for and reaches, of
/// the largest displacement.
const EXACT: f64 = 1e-12;
const ASKED: f64 = 1e-10;
const INTEGRATED: f64 = 1e-8;

/// `truth` holds some columns of the displacement and their step indices.
fn compare(c: &mut Criterion, name: &str, problem: &Problem<'_>, truth: &(Vec<u64>, Mat<f64>)) {
    let mut group = c.benchmark_group("response");
    group.sample_size(10);
    let integrator = Dop853::with_tolerance(ASKED);
    let exact = methods().iter().map(|method| (*method, EXACT));
    let all: Vec<(&dyn ResponseMethod, f64)> =
        exact.chain([(&integrator as _, INTEGRATED)]).collect();
    for (method, tolerance) in all {
        if method.refuses(problem).is_some() {
            continue;
        }
        let run = || method.run(black_box(problem));
        let motion = run().expect("it does not refuse");
        let (steps, columns) = truth;
        for (j, step) in steps.iter().enumerate() {
            assert_eq!(motion.steps()[*step as usize], *step);
            let found = motion.displacement().col(*step as usize);
            let off = (columns.col(j) - found).norm_max();
            let allowed = tolerance * columns.norm_max();
            assert!(off <= allowed, "{name} by {}: {off:e}", method.name());
        }
        group.bench_function(BenchmarkId::new(method.name(), name), |bencher| {
            bencher.iter(run);
        });
    }
}

fn gallery(c: &mut Criterion) {
    for case in cases().iter().filter(|case| SCENES.contains(&case.name())) {
        let (scene, samples) = (case.scene(), case.truth().response);
        let steps = samples.iter().map(|sample| sample.step).collect();
        let columns = Mat::from_fn(scene.system().len(), samples.len(), |i, j| {
            samples[j].displacement[i].to_f64()
        });
        let problem = scene.problem().expect("it has instants");
        let problem = problem.expect("checked when it was read");
        compare(c, case.name(), &problem, &(steps, columns));
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
        compare(
            c,
            &format!("chain of {masses}"),
            &problem,
            &(steps, columns),
        );
    }
}

criterion_group!(benches, gallery, chains);
criterion_main!(benches);
