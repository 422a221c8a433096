//! Frequency response functions: full matrices in doubles and proven, and a long chain; root mean squares of chains under
//! white noise and within a band.
//!
//! `benches/peers.py frf` times SciPy on the same full matrices.

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};
use eigentone::modes::{ElementKind, GROUND, Precision, System};
use eigentone::response::{FrequencyResponse, Noise, RandomVibration};

/// Every coordinate is joined to every other.
fn full(n: usize) -> System {
    let mut builder = System::builder();
    let mut state = 1u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 24)
    };
    for i in 0..n {
        builder = builder.mass(format!("m{i}"), 0.5 + random());
    }
    for i in 0..n {
        builder = builder.spring(GROUND, format!("m{i}"), 10.0 + random());
        for j in 0..i {
            let (a, b) = (format!("m{i}"), format!("m{j}"));
            builder = builder.spring(&a, &b, random());
            if (i + j) % 5 == 0 {
                builder = builder.damper(&a, &b, 0.05 * random());
            }
        }
    }
    builder.build().expect("a system")
}

fn chain(n: usize) -> System {
    let mut builder = System::builder();
    for i in 0..n {
        let before = if i == 0 {
            GROUND.to_owned()
        } else {
            format!("m{}", i - 1)
        };
        builder = builder
            .mass(format!("m{i}"), 1.0)
            .spring(&before, format!("m{i}"), 100.0)
            .damper(&before, format!("m{i}"), 0.3);
    }
    builder.build().expect("a chain")
}

fn frequencies(count: usize, last: f64) -> Vec<f64> {
    (1..=count)
        .map(|k| last * k as f64 / count as f64)
        .collect()
}

fn responses(c: &mut Criterion) {
    let mut group = c.benchmark_group("frequency");
    group.sample_size(10);
    group.measurement_time(Duration::from_secs(2));
    group.warm_up_time(Duration::from_millis(300));
    for n in [50, 200] {
        let system = full(n);
        // The structure is proved once for all.
        system.structure();
        let at = frequencies(2000, 15.0);
        let doubles = FrequencyResponse::of(&system)
            .from("m0")
            .precision(Precision::Double);
        group.bench_function(format!("full {n}, 2000 frequencies, doubles"), |b| {
            b.iter(|| doubles.at(black_box(&at)).expect("a response"));
        });
        let few = frequencies(20, 15.0);
        let proven = FrequencyResponse::of(&system).from("m0");
        group.bench_function(format!("full {n}, 20 frequencies, proven"), |b| {
            b.iter(|| proven.at(black_box(&few)).expect("a response"));
        });
        let springs = system.elements(ElementKind::Spring).len();
        let lossy = proven.loss_factors(vec![0.02; springs]);
        let what = format!("full {n}, 20 frequencies, proven, with loss factors");
        group.bench_function(what, |b| {
            b.iter(|| lossy.at(black_box(&few)).expect("a response"));
        });
    }
    for n in [10, 30] {
        let system = chain(n);
        system.structure();
        for (what, noise) in [
            ("white", Noise::white(1.0)),
            ("within a band", Noise::within(1.0, [0.2, 3.0])),
        ] {
            let asked = RandomVibration::of(&system).force("m0", noise);
            group.bench_function(format!("chain {n}, noise {what}"), |b| {
                b.iter(|| black_box(&asked).solve().expect("it comes to rest"));
            });
        }
    }
    let long = chain(100_000);
    let at = frequencies(4, 25.0);
    let asked = FrequencyResponse::of(&long)
        .from("m0")
        .to("m0")
        .to("m99999");
    group.bench_function("chain 1e5, 4 frequencies", |b| {
        b.iter(|| asked.at(black_box(&at)).expect("a response"));
    });
    group.finish();
}

criterion_group!(benches, responses);
criterion_main!(benches);
