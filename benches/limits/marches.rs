//! Marches: sampled loads on few masses, and many masses with few outputs.

use eigentone::modes::Precision;
use eigentone::prelude::*;
use eigentone::response::{
    BySuperposition, Exponential, History, Hold, Output, Problem, Samples, SecondOrder,
};
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
    println!(
        "hold    three displacements      lsim   gain   blocks of  multiplications  bytes written"
    );
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
        let loads = if hold == Hold::First { 6.0 } else { 3.0 };
        let lsim = match hold {
            Hold::First => peers.beside("lsim 100001", time * 1e-3 * count as f64),
            Hold::Zero => String::new(),
        };
        println!(
            "{name:5} {time:>21.2} {lsim:>18} {size:>10} {:>16.0} {:>14}",
            (3.0 * size + 6.0) * (6.0 + loads * size) / size,
            24,
        );
    }
}

/// Free motion of long chains at many instants: three outputs in blocks, beside one product of matrix
/// and vector a step.
fn long(runs: &Runs) {
    println!("\nFree chains, three displacements, µs a step");
    println!(
        "masses  instants  plain march  in blocks   gain  of  all by superposition   gain  GFMA/s"
    );
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
        let problem = ask(count);
        let phi = SecondOrder.exponential(chain.state_matrix(0.01).as_ref());
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
        let blocked = runs.best(|| History::of(&problem, &outputs)) / count as f64;
        let size = (count as f64 / history.operations().steps as f64).round();
        let modal = (n <= 100).then(|| {
            let few = ask(some);
            let run = || BySuperposition.run(&few);
            run().ok().map(|_| runs.best(run) / some as f64)
        });
        let modal = modal.flatten();
        let multiplications = (3.0 * size + 2.0 * n as f64) * 2.0 * n as f64 / size;
        println!(
            "{n:>6} {count:>9} {plain:>12.3} {blocked:>10.4} {:>5.0}× {size:>4} {:>20} {:>6} {:>7.2}",
            plain / blocked,
            modal.map_or("–".to_owned(), |time| format!("{time:.3}")),
            modal.map_or("–".to_owned(), |time| format!("{:.1}×", plain / time)),
            multiplications / blocked * 1e-3,
        );
        growth[0].push((n as f64, plain));
        growth[1].push((n as f64, blocked));
    }
    if sizes.len() > 1 {
        let [plain, blocked] = growth.map(|points| slope(&points));
        println!("growth with the masses: plain n^{plain:.2}, in blocks n^{blocked:.2}");
    }
}
