//! What a long response of few outputs keeps in memory.

use std::time::Instant;

use eigentone::modes::Precision;
use eigentone::prelude::*;
use eigentone::response::{History, Output};

use crate::systems::Chain;
use crate::timing::Runs;

pub fn show(runs: &Runs) {
    let (n, count) = if runs.once {
        (60, 1_000)
    } else {
        (1_000, 100_000)
    };
    let chain = Chain::of(n);
    let system = chain.system();
    let problem = Response::of(&system)
        .from(State::at_rest().displace("m2", 1.0))
        .load("m5", Step::of(100.0))
        .every(0.01)
        .until(0.01 * count as f64)
        .to(Precision::Double)
        .problem()
        .expect("well posed");
    let outputs = [0, n / 2, n - 1].map(Output::Displacement);
    let before = peak();
    let began = Instant::now();
    let history = History::of(&problem, &outputs).expect("well posed");
    let time = began.elapsed().as_secs_f64();
    assert_eq!(history.values().shape(), (3, count + 1));
    let largest = history.values().norm_max();
    assert!(largest > 0.0 && largest < 2.0, "{largest}");
    let all = (count + 1) as f64 * 2.0 * n as f64 * 8.0;
    println!(
        "{n} masses, {count} steps to 3 displacements: {time:.2} s; the states would take {:.0} MB, the peak is {}",
        all * 1e-6,
        match (before, peak()) {
            (Some(before), Some(after)) => format!("{after:.0} MB ({before:.0} MB before)"),
            _ => "not reported by this system".to_owned(),
        }
    );
}

/// The most memory that this process had so far, in MB, where the system reports it.
fn peak() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1e-3)
}
