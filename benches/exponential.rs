//! Matrix exponentials e^(At) of gallery scenes and of chains.

mod chain;

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use eigentone::gallery::cases;
use eigentone::modes::{FirstOrder, balance};
use eigentone::response::{Exponential, Pade13, SecondOrder, Taylor};
use faer::Mat;

use chain::Chain;

const METHODS: [&dyn Exponential; 3] = [&SecondOrder, &Taylor, &Pade13];

/// Scenes that only their initial state moves.
const SCENES: [&str; 4] = [
    "mass-ratio",
    "one-mass-critical",
    "one-mass-underdamped",
    "two-mass-free",
];

/// Of the largest displacement.
const TOLERANCE: f64 = 1e-12;

/// Checks e^(At)·`start` against displacements that `start` leads to, for each method.
fn compare(
    c: &mut Criterion,
    name: &str,
    form: &FirstOrder,
    t: f64,
    start: &Mat<f64>,
    end: &Mat<f64>,
) {
    let mut group = c.benchmark_group("exponential");
    group.sample_size(10);
    let balanced = balance(form.a());
    let n = form.states();
    let at = Mat::from_fn(n, n, |i, j| balanced.matrix[(i, j)] * t);
    for method in METHODS {
        let compute = || {
            let found = method.exponential(black_box(at.as_ref()));
            found.expect("square and finite")
        };
        let scale = &balanced.scale;
        let found = compute();
        let found = Mat::from_fn(n, n, |i, j| scale[i] * found[(i, j)] / scale[j]) * start;
        let off = (found.subrows(0, end.nrows()) - end).norm_max();
        let allowed = TOLERANCE * start.subrows(0, end.nrows()).norm_max();
        assert!(off <= allowed, "{name} by {}: {off:e}", method.name());
        group.bench_function(BenchmarkId::new(method.name(), name), |bencher| {
            bencher.iter(compute);
        });
    }
}

/// The first interval that the gallery's truth spans.
fn gallery(c: &mut Criterion) {
    for case in cases().iter().filter(|case| SCENES.contains(&case.name())) {
        let (scene, truth) = (case.scene(), case.truth());
        let form = FirstOrder::of(scene.system()).expect("every mass is positive");
        let problem = scene.problem().expect("it has instants");
        let problem = problem.expect("checked when it was read");
        assert!(problem.loads().is_empty());
        let start = form.state(problem.initial_displacement(), problem.initial_velocity());
        let start = Mat::from_fn(start.len(), 1, |i, _| start[i]);
        let sample = &truth.response[0];
        let n = sample.displacement.len();
        let end = Mat::from_fn(n, 1, |i, _| sample.displacement[i].to_f64());
        let t = problem.grid().time(sample.step);
        compare(c, case.name(), &form, t, &start, &end);
    }
}

/// All shapes of a chain at once.
fn chains(c: &mut Criterion) {
    for masses in [3, 20, 100, 200] {
        let chain = Chain {
            masses,
            damping: 0.1,
        };
        let form = FirstOrder::of(&chain.system()).expect("every mass is positive");
        for t in [0.25, 16.0] {
            let start = Mat::from_fn(2 * masses, masses, |i, j| {
                if i < masses {
                    chain.shape(j + 1, i + 1)
                } else {
                    0.0
                }
            });
            let end = Mat::from_fn(masses, masses, |i, j| {
                chain.shape(j + 1, i + 1) * chain.motion(j + 1, t).0
            });
            compare(
                c,
                &format!("chain of {masses} over {t} s"),
                &form,
                t,
                &start,
                &end,
            );
        }
    }
}

criterion_group!(benches, gallery, chains);
criterion_main!(benches);
