//! Exponentials of second-order systems and of general matrices.

use eigentone::response::{Exponential, SecondOrder, Taylor};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use nalgebra::DMatrix;

use crate::peers::Peers;
use crate::systems::Chain;
use crate::timing::{Runs, slope};

fn of(method: &dyn Exponential, a: &Mat<f64>) -> Mat<f64> {
    method.exponential(a.as_ref()).expect("square and finite")
}

pub fn show(runs: &Runs, peers: &Peers) {
    println!("\nExponential of a chain's state matrix, µs");
    println!(
        "states  second order      SciPy  gain    nalgebra   gain     Taylor  faer product  in products"
    );
    let mut growth = [Vec::new(), Vec::new()];
    for n in [3, 20, 100, 200] {
        let chain = Chain::of(n);
        let a = chain.state_matrix(chain.step);
        let states = 2 * n;
        let theirs = DMatrix::from_fn(states, states, |i, j| a[(i, j)]);
        let found = of(&SecondOrder, &a);
        let other = theirs.exp();
        let other = Mat::from_fn(states, states, |i, j| other[(i, j)]);
        for (known, tolerance) in [(of(&Taylor, &a), 1e-12), (other, 1e-9)] {
            let off = (&found - &known).norm_l2() / known.norm_l2();
            assert!(off < tolerance, "{states} states: {off:e}");
        }
        let ours = runs.best(|| SecondOrder.exponential(a.as_ref()));
        let taylor = runs.best(|| Taylor.exponential(a.as_ref()));
        let nalgebra = runs.best(|| theirs.exp());
        let product = product(runs, states);
        println!(
            "{states:>6} {ours:>13.2} {}  {nalgebra:>9.2} {:>5.1}× {taylor:>10.2} {product:>13.2} {:>12.2}",
            peers.beside(&format!("expm {states}"), ours),
            nalgebra / ours,
            ours / product,
        );
        if n > 3 {
            growth[0].push((states as f64, ours));
            growth[1].push((states as f64, taylor));
        }
    }
    let [ours, taylor] = growth.map(|points| slope(&points));
    println!("growth with the states: second order n^{ours:.2}, Taylor n^{taylor:.2}");

    println!("\nExponential of a full matrix by Taylor, µs");
    println!("order      time  products and squarings  faer product   time/products  their share");
    for n in [100, 200, 400, 600] {
        if runs.once && n > 200 {
            continue;
        }
        let entry =
            |i: usize, j: usize| ((i * 7919 + j * 104_729 + 13) % 1009) as f64 / 504.5 - 1.0;
        let a = Mat::from_fn(n, n, |i, j| 0.1 * entry(i, j));
        let (found, counted) = Taylor.counted(a.as_ref()).expect("square and finite");
        let back = &found * of(&Taylor, &(&a * faer::Scale(-1.0)));
        let off = (back - Mat::<f64>::identity(n, n)).norm_max();
        assert!(off < 1e-9, "order {n}: {off:e}");
        let ours = runs.best(|| Taylor.exponential(a.as_ref()));
        let product = product(runs, n);
        println!(
            "{n:>5} {ours:>9.0} {counted:>23} {product:>13.0} {:>15.3} {:>11.0}%",
            ours / (counted * product),
            100.0 * counted * product / ours,
        );
    }
}

/// One product of full matrices by faer.
fn product(runs: &Runs, n: usize) -> f64 {
    let x = Mat::from_fn(n, n, |i, j| ((i * 7 + j * 3) % 11) as f64 * 0.1);
    let mut out = Mat::zeros(n, n);
    runs.best(|| {
        matmul(
            out.as_mut(),
            Accum::Replace,
            x.as_ref(),
            x.as_ref(),
            1.0,
            Par::Seq,
        );
        out[(0, 0)]
    })
}
