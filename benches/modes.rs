//! Mode solvers, and the proofs that choose among them, on the gallery and on chains; the time to
//! a proven answer, and that to one in doubles beside the bare eigenproblem of its state matrix.

mod chain;

use std::hint::black_box;
use std::time::Duration;

use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use eigentone::gallery::cases;
use eigentone::modes::{Bounds, FirstOrder, Precision, SystemBuilder, balance, solvers};
use eigentone::prelude::*;
use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{self, ComputeEigenvectors};
use faer::{Mat, MatRef, Par};
use num_complex::Complex;

use chain::Chain;

/// Relative; what every solver reaches on all but a few extreme systems.
const TOLERANCE: f64 = 1e-12;

/// Whether every true root is met by one of those found.
fn is_right(modes: &Modes, truth: &[Complex<f64>]) -> bool {
    let mut left = modes.eigenvalues().to_vec();
    let all = truth.iter().all(|root| {
        let met = |found: &Eigenvalue| (found.value - root).norm() <= TOLERANCE * root.norm();
        let index = left.iter().position(met);
        index.map(|index| left.swap_remove(index)).is_some()
    });
    all && left.is_empty()
}

fn compare(c: &mut Criterion, name: &str, system: &System, truth: &[Complex<f64>]) {
    assert_eq!(system.structure().finite_roots(), Some(truth.len()));
    let proven = system.modes().expect("it has modes");
    assert!(is_right(&proven, truth), "{name}");
    let mut group = c.benchmark_group("modes");
    group.sample_size(10);
    group.measurement_time(Duration::from_secs(1));
    group.warm_up_time(Duration::from_millis(300));
    let mut timed = 0;
    for solver in solvers() {
        if solver.refuses(system).is_some() {
            continue;
        }
        let solve = || solver.solve(black_box(system));
        // A wrong answer has no run time.
        if !solve().is_ok_and(|modes| is_right(&modes, truth)) {
            continue;
        }
        timed += 1;
        group.bench_function(BenchmarkId::new(solver.name(), name), |bencher| {
            bencher.iter(solve);
        });
    }
    // The gallery's one defective root is beyond doubles.
    assert!(timed > 0 || name == "triple-defect", "{name}");
}

fn gallery(c: &mut Criterion) {
    for case in cases() {
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

/// A chain of n masses between two walls whose dampers are in no proportion to its masses or
/// springs, so that every mode moves every other.
fn uneven(n: usize) -> System {
    let name = |i: usize| match i {
        i if i == 0 || i == n + 1 => GROUND.to_owned(),
        i => format!("m{i}"),
    };
    // Masses that never repeat: no two modes are nearly the same.
    let mass =
        |builder: SystemBuilder, i: usize| builder.mass(name(i), 1.0 + (0.618 * i as f64).fract());
    let join = |builder: SystemBuilder, i: usize| {
        builder
            .spring(name(i), name(i + 1), 1.0 + 0.5 * (i % 3) as f64)
            .damper(name(i), name(i + 1), 0.02 * (1 + i % 5) as f64)
    };
    let builder = (1..=n).fold(System::builder(), mass);
    (0..=n)
        .fold(builder, join)
        .build()
        .expect("a chain is a system")
}

/// `modes()` with its proven bounds, of a system that nothing is known of yet.
fn certified(c: &mut Criterion) {
    let mut group = c.benchmark_group("certified");
    group.sample_size(10);
    for n in [3, 12, 50] {
        let modes = uneven(n).modes().expect("a chain has modes");
        assert_eq!(modes.bounds(), Bounds::Proven);
        assert_eq!(modes.eigenvalues().len(), 2 * n);
        group.bench_function(BenchmarkId::new("general damping", n), |bencher| {
            bencher.iter_batched_ref(
                || uneven(n),
                |system| black_box(system).modes(),
                BatchSize::LargeInput,
            );
        });
    }
}

/// The eigenvalues of A with right and left vectors, by faer, as good as bare.
fn eigen(a: MatRef<'_, f64>) -> Diag<f64> {
    let n = a.nrows();
    let (mut right, mut left) = (Mat::<f64>::zeros(n, n), Mat::<f64>::zeros(n, n));
    let (mut re, mut im) = (Diag::<f64>::zeros(n), Diag::<f64>::zeros(n));
    let wanted = ComputeEigenvectors::Yes;
    let scratch = evd::evd_scratch::<f64>(n, wanted, wanted, Par::Seq, Default::default());
    evd::evd_real(
        a,
        re.as_mut(),
        im.as_mut(),
        Some(left.as_mut()),
        Some(right.as_mut()),
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(scratch)),
        Default::default(),
    )
    .expect("it converges");
    re
}

/// `modes_to(Precision::Double)`, proofs of structure included, beside faer's eigenproblem of the
/// balanced state matrix.
fn doubles(c: &mut Criterion) {
    let mut group = c.benchmark_group("double");
    group.sample_size(10);
    for n in [3, 6, 12, 20, 50, 100, 200] {
        let form = FirstOrder::of(&uneven(n)).expect("every mass is positive");
        let balanced = balance(form.a());
        group.bench_function(BenchmarkId::new("faer eigen", n), |bencher| {
            bencher.iter(|| eigen(black_box(balanced.matrix.as_ref())));
        });
        group.bench_function(BenchmarkId::new("modes", n), |bencher| {
            bencher.iter_batched_ref(
                || uneven(n),
                |system| black_box(system).modes_to(Precision::Double),
                BatchSize::LargeInput,
            );
        });
    }
}

/// The same chain with three dampers alone.
fn sparsely_damped(n: usize) -> System {
    let name = |i: usize| match i {
        i if i == 0 || i == n + 1 => GROUND.to_owned(),
        i => format!("m{i}"),
    };
    let mass =
        |builder: SystemBuilder, i: usize| builder.mass(name(i), 1.0 + (0.618 * i as f64).fract());
    let spring = |builder: SystemBuilder, i: usize| {
        builder.spring(name(i), name(i + 1), 1.0 + 0.5 * (i % 3) as f64)
    };
    let chain = (0..=n).fold((1..=n).fold(System::builder(), mass), spring);
    chain
        .damper(GROUND, name(3), 0.3)
        .damper(name(n / 3), name(n / 3 + 1), 0.5)
        .damper(name(n - 2), name(n / 2), 0.2)
        .build()
        .expect("a chain is a system")
}

/// `modes_to(Precision::Double)` of a system with three dampers, beside faer's eigenproblem of its
/// state matrix, balanced, with right vectors alone.
fn few_dampers(c: &mut Criterion) {
    let mut group = c.benchmark_group("three dampers");
    group.sample_size(10);
    for n in [50, 200, 500] {
        let form = FirstOrder::of(&sparsely_damped(n)).expect("every mass is positive");
        let balanced = balance(form.a());
        group.bench_function(BenchmarkId::new("faer eigen", n), |bencher| {
            bencher.iter(|| black_box(balanced.matrix.as_ref()).eigen());
        });
        group.bench_function(BenchmarkId::new("modes", n), |bencher| {
            bencher.iter_batched_ref(
                || sparsely_damped(n),
                |system| black_box(system).modes_to(Precision::Double),
                BatchSize::LargeInput,
            );
        });
    }
}

/// The proofs of structure alone.
fn proofs(c: &mut Criterion) {
    let mut group = c.benchmark_group("proofs");
    group.sample_size(10);
    for n in [3, 20, 100] {
        group.bench_function(BenchmarkId::new("general damping", n), |bencher| {
            bencher.iter_batched_ref(
                || uneven(n),
                |system| {
                    black_box(system).structure();
                },
                BatchSize::LargeInput,
            );
        });
    }
}

criterion_group!(
    benches,
    gallery,
    chains,
    certified,
    doubles,
    few_dampers,
    proofs
);
criterion_main!(benches);
