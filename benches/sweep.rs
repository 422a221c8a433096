//! 10 000 designs of three masses, modes and 200 instants each: one thread, two, and each design as a
//! system of its own.

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use eigentone::gallery::cases;
use eigentone::modes::{DesignError, Parameter, Precision};
use eigentone::prelude::*;
use eigentone::response::{Answer, Problem, Sweep};

const DESIGNS: usize = 10_000;

/// The springs and dampers of design k.
fn values(k: usize) -> ([f64; 4], [f64; 4]) {
    let part = |factor: f64| (factor * (k + 1) as f64).fract();
    let springs = [6.0, 7.0, 4.0, 1.0];
    let dampers = [1.0, 0.2, 0.1, 2.0];
    let vary = |value: f64, factor: f64| value * (0.5 + part(factor));
    (
        std::array::from_fn(|i| vary(springs[i], 0.618 + 0.1 * i as f64)),
        std::array::from_fn(|i| vary(dampers[i], 0.414 + 0.1 * i as f64)),
    )
}

fn set(sweep: &mut Sweep, k: usize) -> Result<(), DesignError> {
    let (springs, dampers) = values(k);
    for i in 0..4 {
        sweep.set(Parameter::Spring(i), springs[i])?;
        sweep.set(Parameter::Damper(i), dampers[i])?;
    }
    Ok(())
}

/// The lowest frequency and the last displacement of the first mass.
fn read(answer: Answer<'_>) -> [f64; 2] {
    let last = answer.displacement().ncols() - 1;
    [
        answer.eigenvalues()[0].norm(),
        answer.displacement()[(0, last)],
    ]
}

/// The same numbers by the ordinary way, in doubles.
fn apart(problem: &Problem<'_>, k: usize) -> [f64; 2] {
    let base = problem.system();
    let (springs, dampers) = values(k);
    let name = |node: eigentone::modes::Node| match node.coordinate() {
        Some(i) => base.names()[i].clone(),
        None => GROUND.to_owned(),
    };
    let mut builder = System::builder();
    for (name, mass) in base.names().iter().zip(base.masses()) {
        builder = builder.mass(name, *mass);
    }
    for (spring, value) in base.springs().iter().zip(springs) {
        builder = builder.spring(name(spring.first), name(spring.second), value);
    }
    for (damper, value) in base.dampers().iter().zip(dampers) {
        builder = builder.damper(name(damper.first), name(damper.second), value);
    }
    let system = builder.build().expect("it is one");
    let mut state = State::at_rest();
    for (name, x) in base.names().iter().zip(problem.initial_displacement()) {
        state = state.displace(name, *x);
    }
    let loads = problem.loads().to_vec();
    let problem = Problem::new(&system, &state, loads, *problem.grid()).expect("as the first");
    let modes = system.modes_to(Precision::Double).expect("it has modes");
    let motion = eigentone::response::ByExponential;
    let motion = eigentone::response::ResponseMethod::run(&motion, &problem).expect("it moves");
    let last = motion.len() - 1;
    [
        modes.as_slice()[0].natural_frequency().radians_per_second(),
        motion.displacement()[(0, last)],
    ]
}

fn sweeps(c: &mut Criterion) {
    let mut cases = cases().iter();
    let case = cases.find(|case| case.name() == "three-mass-1");
    let scene = case.expect("it is in the gallery").scene();
    let whole = scene.problem().expect("it has instants").expect("checked");
    let grid = eigentone::response::TimeGrid::new(0.1, 19.9).expect("it is one");
    let mut state = State::at_rest();
    for (name, x) in scene
        .system()
        .names()
        .iter()
        .zip(whole.initial_displacement())
    {
        state = state.displace(name, *x);
    }
    let problem =
        Problem::new(scene.system(), &state, whole.loads().to_vec(), grid).expect("as the scene");
    assert_eq!(problem.grid().last(), 199);
    let mut sweep = Sweep::of(&problem).expect("it can be swept");
    for k in (0..DESIGNS).step_by(997) {
        set(&mut sweep, k).expect("in range");
        let found = read(sweep.solve().expect("it has an answer"));
        for (found, known) in found.into_iter().zip(apart(&problem, k)) {
            assert!(
                (found - known).abs() <= 1e-13 * known.abs().max(1.0),
                "{found} {known}"
            );
        }
    }

    let mut group = c.benchmark_group("sweep of 10 000 three-mass designs");
    group.sample_size(10);
    group.measurement_time(Duration::from_secs(3));
    group.throughput(Throughput::Elements(DESIGNS as u64));
    group.bench_function("one thread", |bencher| {
        bencher.iter(|| {
            let answers = sweep.each(0..DESIGNS, set, read);
            let sum: f64 = answers.map(|answer| answer.expect("in range")[0]).sum();
            assert!(sum.is_finite());
            black_box(sum)
        });
    });
    #[cfg(feature = "rayon")]
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.expect("threads can be started");
        group.bench_function(format!("rayon, {threads}"), |bencher| {
            bencher.iter(|| {
                let designs = (0..DESIGNS).collect();
                pool.install(|| sweep.each_in_parallel(designs, set, read))
            });
        });
    }
    group.throughput(Throughput::Elements(100));
    group.bench_function("100 systems of their own, in doubles", |bencher| {
        bencher.iter(|| (0..100).map(|k| apart(&problem, k)[1]).sum::<f64>());
    });
    group.finish();
}

criterion_group!(benches, sweeps);
criterion_main!(benches);
