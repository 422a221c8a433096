//! Marches: sampled loads on few masses, and many masses with few outputs.

use eigentone::modes::Precision;
use eigentone::prelude::*;
use eigentone::response::{Exponential, History, Hold, Output, Problem, Samples, SecondOrder};
use faer::linalg::matmul::matmul;
use faer::linalg::solvers::Solve;
use faer::{Accum, Mat, Par};

use crate::peers::Peers;
use crate::systems::Chain;
use crate::timing::{Runs, slope};

pub fn show(runs: &Runs, peers: &Peers) {
    println!("\nSpeed of writing to memory: {:.1} GB/s", writing(runs));
    sampled(runs, peers);
    long(runs);
}

/// In GB/s, to pages that are already there.
fn writing(runs: &Runs) -> f64 {
    const SIZE: usize = 1 << 25;
    let mut buffer = vec![1.0f64; SIZE];
    let mut value = 0.0;
    let time = runs.best(|| {
        value += 1.0;
        buffer.fill(value);
        buffer[SIZE / 2]
    });
    (SIZE * 8) as f64 / time * 1e-3
}

/// Three masses under three sampled forces that stay constant, as for `lsim`.
fn sampled(runs: &Runs, peers: &Peers) {
    let chain = Chain::of(3);
    let system = chain.system();
    let count = if runs.once { 2_000 } else { 100_001 };
    let force = [3.0, 9.0, 12.0];
    let names = ["m1", "m2", "m3"];
    let start = State::at_rest()
        .displace("m1", 6.0)
        .displace("m2", 7.0)
        .displace("m3", 8.0);
    let asked = |hold: Hold| {
        let response = Response::of(&system)
            .from(start.clone())
            .every(0.1)
            .until(0.1 * (count - 1) as f64)
            .to(Precision::Double);
        names
            .iter()
            .zip(force)
            .fold(response, |response, (name, force)| {
                let values = vec![force; count];
                let step = 0.1;
                response.load(*name, Samples { step, values, hold })
            })
    };
    let outputs = [0, 1, 2].map(Output::Displacement);
    println!("\nThree masses, three sampled forces, {count} instants, ns a step");
    println!("hold    three displacements      lsim   gain   blocks of  bytes written");
    for (name, hold) in [("first", Hold::First), ("zero", Hold::Zero)] {
        let problem = asked(hold).problem().expect("well posed");
        let history = History::of(&problem, &outputs).expect("well posed");
        let k = system.stiffness_matrix();
        let f = Mat::from_fn(3, 1, |i, _| force[i]);
        let rest = k.partial_piv_lu().solve(&f);
        let last = history.values().col(count - 1);
        let off = (last - rest.col(0)).norm_max() / rest.norm_max();
        assert!(off < 1e-12 || runs.once, "{off:e}");
        let time = runs.best(|| History::of(&problem, &outputs)) * 1e3 / count as f64;
        let size = (count as f64 / history.operations().steps as f64).round();
        let lsim = peers.beside("lsim 100001", time * 1e-3 * count as f64);
        println!("{name:5} {time:>21.2} {lsim:>18} {size:>10} {:>14}", 24);
    }
}

/// Motion of long chains at many instants towards three outputs, finding the way and preparing it included,
/// beside one product of matrix and vector a step.
fn long(runs: &Runs) {
    println!("\nFree chains, three displacements, µs a step");
    println!("masses  instants  plain march  few outputs   gain  without preparation  by");
    let mut growth = [Vec::new(), Vec::new()];
    let sizes: &[usize] = if runs.once { &[20] } else { &[20, 100, 400] };
    for &n in sizes {
        let chain = Chain::of(n);
        let system = chain.system();
        let count = if runs.once { 500 } else { 50_000 };
        let outputs = [0, n / 2, n - 1].map(Output::Displacement);
        let ask = |last: usize| -> Problem<'_> {
            let response = Response::of(&system).from(State::at_rest().displace("m2", 1.0));
            let response = response.every(0.01).until(0.01 * last as f64);
            response
                .to(Precision::Double)
                .problem()
                .expect("well posed")
        };
        let (problem, twice) = (ask(count), ask(2 * count));
        let phi = SecondOrder.exponential(chain.state_matrix(0.01).as_ref());
        let phi = phi.expect("square and finite");
        let history = History::of(&problem, &outputs).expect("well posed");
        // The plain march, for some steps.
        let some = 400.min(count);
        let mut states = Mat::<f64>::zeros(2 * n, some + 1);
        states[(1, 0)] = 1.0;
        let plain = runs.best(|| {
            for k in 0..some {
                let (before, after) = states.as_mut().split_at_col_mut(k + 1);
                let (now, next) = (before.col(k), after.col_mut(0));
                matmul(
                    next.as_mat_mut(),
                    Accum::Replace,
                    phi.as_ref(),
                    now.as_mat(),
                    1.0,
                    Par::Seq,
                );
            }
        }) / some as f64;
        for (i, output) in outputs.iter().enumerate() {
            let Output::Displacement(row) = output else {
                continue;
            };
            for k in [1, some / 2, some] {
                let off = (history.values()[(i, k)] - states[(*row, k)]).abs();
                assert!(off < 1e-11, "{n} masses, step {k}: {off:e}");
            }
        }
        let once = runs.best(|| History::of(&problem, &outputs));
        let more = runs.best(|| History::of(&twice, &outputs));
        let same =
            History::of(&twice, &outputs).is_ok_and(|other| other.method() == history.method());
        let time = once / count as f64;
        println!(
            "{n:>6} {count:>9} {plain:>12.3} {time:>12.4} {:>5.1}× {:>20} {}",
            plain / time,
            match same {
                true => format!("{:.4}", (more - once) / count as f64),
                false => "–".to_owned(),
            },
            history.method(),
        );
        growth[0].push((n as f64, plain));
        growth[1].push((n as f64, time));
    }
    if sizes.len() > 1 {
        let [plain, few] = growth.map(|points| slope(&points));
        println!("growth with the masses: plain n^{plain:.2}, few outputs n^{few:.2}");
    }
}
