//! Twenty lowest modes of long chains and of grids: run time, error, memory, and how they grow with n.
//!
//! `cargo bench --bench sparse`; with `-- --test`, the smallest sizes once.

use std::f64::consts::PI;
use std::time::Instant;

use eigentone::modes::{SparseModes, System};
use eigentone::prelude::*;

const MODES: usize = 20;

fn name(node: usize) -> String {
    match node {
        0 => GROUND.to_owned(),
        i => format!("m{i}"),
    }
}

/// Unit masses joined by unit springs.
fn network(n: usize, springs: impl Iterator<Item = (usize, usize)>) -> System {
    let masses = (1..=n).fold(System::builder(), |builder, i| builder.mass(name(i), 1.0));
    let joined = springs.fold(masses, |builder, (a, b)| {
        builder.spring(name(a), name(b), 1.0)
    });
    joined.build().expect("a network is a system")
}

fn chain(n: usize) -> (System, Vec<f64>) {
    let system = network(n, (0..=n).map(|i| (i, (i + 1) % (n + 1))));
    let angle = |j: usize| j as f64 * PI / (2.0 * (n as f64 + 1.0));
    (system, (1..=MODES).map(|j| 2.0 * angle(j).sin()).collect())
}

/// A square with its rim held.
fn grid(side: usize) -> (System, Vec<f64>) {
    let inside = |i: usize| (1..=side).contains(&i);
    let node = |i: usize, j: usize| {
        if inside(i) && inside(j) {
            (i - 1) * side + j
        } else {
            0
        }
    };
    let along = (0..=side).flat_map(|i| (1..=side).map(move |j| (i, j)));
    let springs =
        along.flat_map(|(i, j)| [(node(i, j), node(i + 1, j)), (node(j, i), node(j, i + 1))]);
    let system = network(side * side, springs);
    let square = |i: usize| {
        let sine = (i as f64 * PI / (2.0 * (side as f64 + 1.0))).sin();
        4.0 * sine * sine
    };
    let mut squares: Vec<f64> = (1..=MODES)
        .flat_map(|i| (1..=MODES).map(move |j| square(i) + square(j)))
        .collect();
    squares.sort_by(f64::total_cmp);
    let lowest = squares.into_iter().take(MODES);
    (system, lowest.map(f64::sqrt).collect())
}

/// The most memory taken so far, in MB, where the system reports it.
fn peak() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes / 1e3)
}

fn measure(what: &str, sizes: &[usize], system: impl Fn(usize) -> (System, Vec<f64>)) {
    println!("{what}: {MODES} lowest modes");
    println!("        n  build, s  modes, s  products  entries of L  worst error  peak, MB");
    let mut times = Vec::new();
    for &size in sizes {
        let start = Instant::now();
        let (system, exact) = system(size);
        let built = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let modes = SparseModes::lowest(&system, MODES).expect("the system is sparse");
        let taken = start.elapsed().as_secs_f64();
        let found = modes.frequencies();
        let errors = found.iter().zip(&exact);
        let worst = errors
            .map(|(found, exact)| (found.radians_per_second() / exact - 1.0).abs())
            .fold(0.0, f64::max);
        assert!(worst <= 1e-12, "{what} of {}: {worst:e}", system.len());
        assert!(modes.is_counted(), "{what} of {}", system.len());
        let work = modes.work();
        let peak = peak().map_or("–".to_owned(), |peak| format!("{peak:.0}"));
        println!(
            "{:9}  {built:8.3}  {taken:8.3}  {:8}  {:12}  {worst:11.1e}  {peak:>8}",
            system.len(),
            work.products,
            work.entries,
        );
        times.push((system.len() as f64, taken));
    }
    if let [(n, first), .., (most, last)] = times[..] {
        let power = (last / first).ln() / (most / n).ln();
        println!("run time grows as n^{power:.2}");
    }
    println!();
}

fn main() {
    let test = std::env::args().any(|argument| argument == "--test");
    let (chains, grids): (&[usize], &[usize]) = if test {
        (&[10_000], &[50])
    } else {
        (&[10_000, 100_000, 1_000_000], &[100, 200, 400])
    };
    // The large ones last, since memory is that of the largest so far.
    measure("square grids", grids, grid);
    measure("chains", chains, chain);
}
