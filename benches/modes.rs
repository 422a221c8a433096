//! Mode solvers, and the proofs that choose among them, on the gallery and on chains.

mod chain;

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use eigentone::gallery::cases;
use eigentone::modes::solvers;
use eigentone::prelude::*;
use num_complex::Complex;

use chain::Chain;

const SCENES: [&str; 5] = [
    "micro-units",
    "one-mass-critical",
    "one-mass-undamped",
    "three-mass-1",
    "two-mass-free",
];

/// Relative; what every solver reaches on these systems.
const TOLERANCE: f64 = 1e-12;

/// Every true root is met by one of those found.
fn assert_right(modes: &Modes, truth: &[Complex<f64>]) {
    let mut left = modes.eigenvalues().to_vec();
    assert_eq!(left.len(), truth.len());
    for root in truth {
        let met = |found: &Eigenvalue| (found.value - root).norm() <= TOLERANCE * root.norm();
        let index = left.iter().position(met);
        left.swap_remove(index.unwrap_or_else(|| panic!("{root} was not found")));
    }
}

fn compare(c: &mut Criterion, name: &str, system: &System, truth: &[Complex<f64>]) {
    let structure = system.structure();
    assert_eq!(structure.finite_roots(), Some(truth.len()));
    assert!(structure.is_passive());
    let mut group = c.benchmark_group("modes");
    group.sample_size(10);
    group.bench_function(BenchmarkId::new("proofs", name), |bencher| {
        bencher.iter(|| black_box(system).structure());
    });
    for solver in solvers() {
        if solver.refuses(system, &structure).is_some() {
            continue;
        }
        let solve = || solver.solve(black_box(system), black_box(&structure));
        assert_right(&solve().expect("it does not refuse"), truth);
        group.bench_function(BenchmarkId::new(solver.name(), name), |bencher| {
            bencher.iter(solve);
        });
    }
}

fn gallery(c: &mut Criterion) {
    for case in cases().iter().filter(|case| SCENES.contains(&case.name())) {
        let roots = case.truth().eigenvalues.into_iter();
        let truth: Vec<_> = roots
            .map(|root| Complex::new(root.re.to_f64(), root.im.to_f64()))
            .collect();
        compare(c, case.name(), case.scene().system(), &truth);
    }
}

fn chains(c: &mut Criterion) {
    for (masses, damping) in [3, 20, 100].into_iter().flat_map(|n| [(n, 0.0), (n, 0.1)]) {
        let chain = Chain { masses, damping };
        let roots = (1..=masses).map(|j| chain.root(j));
        let truth: Vec<_> = roots.flat_map(|root| [root, root.conj()]).collect();
        let kind = if damping == 0.0 { "undamped" } else { "damped" };
        let name = format!("{kind} chain of {masses}");
        compare(c, &name, &chain.system(), &truth);
    }
}

criterion_group!(benches, gallery, chains);
criterion_main!(benches);
