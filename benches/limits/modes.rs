//! Modes in doubles, everything included, beside NumPy, SciPy and faer.

use eigentone::modes::{Design, FirstOrder, ModesWorkspace, Precision, balance};
use eigentone::prelude::*;

use crate::peers::Peers;
use crate::systems::Chain;
use crate::timing::{Runs, slope};

/// How a chain is damped.
const KINDS: [&str; 4] = ["damped", "three dampers", "classical", "undamped"];

fn chain(n: usize, kind: &str) -> Chain {
    let mut chain = Chain::of(n);
    match kind {
        "three dampers" => {
            let chosen = [3, n / 2, n - 3];
            for (i, damper) in chain.dampers.iter_mut().enumerate() {
                *damper = if chosen.contains(&i) { 0.5 } else { 0.0 };
            }
        }
        // A power of two, so that the proportion is exact.
        "classical" => {
            let springs = chain.springs.iter();
            chain.dampers = springs.map(|stiffness| stiffness / 8192.0).collect();
        }
        "undamped" => chain.dampers.fill(0.0),
        _ => {}
    }
    chain
}

pub fn show(runs: &Runs, peers: &Peers) {
    let sizes: &[usize] = if runs.once {
        &[3, 20]
    } else {
        &[3, 20, 100, 200, 500]
    };
    println!("\nModes of chains in doubles, from the system with nothing known of it, µs");
    println!(
        "masses  damping             ours        eig   gain  eig(A, B)   gain       eigh   gain  faer eigen   gain"
    );
    let mut growth = KINDS.map(|kind| (kind, Vec::new()));
    for &n in sizes {
        for (kind, points) in &mut growth {
            if n < 20 && *kind == "three dampers" {
                continue;
            }
            let chain = chain(n, kind);
            let system = chain.system();
            let modes = system.modes_to(Precision::Double).expect("it has modes");
            check(&system, &modes);
            let ours = runs.best_after(
                || chain.system(),
                |system| system.modes_to(Precision::Double).expect("it has modes"),
            );
            let form = FirstOrder::of(&system).expect("every mass is positive");
            let balanced = balance(form.a());
            let faer = runs.best(|| balanced.matrix.as_ref().eigen().expect("it converges"));
            println!(
                "{n:>6}  {kind:13} {ours:>10.1} {} {} {} {faer:>11.1} {:>5.1}×",
                peers.beside(&format!("eig {n}"), ours),
                peers.beside(&format!("eig(A, B) {n}"), ours),
                peers.beside(&format!("eigh {n}"), ours),
                faer / ours,
            );
            if n > 3 {
                points.push((n as f64, ours));
            }
        }
    }
    let fits = growth.map(|(kind, points)| format!("{kind} n^{:.2}", slope(&points)));
    println!("growth with the masses: {}", fits.join(", "));

    println!("\nThe same chains again and again in one workspace, µs");
    println!("masses       ours        eig   gain");
    for n in [3, 6, 12, 20] {
        let system = chain(n, "damped").system();
        let design = Design::of(&system).expect("springs, dampers and masses alone");
        let mut workspace = ModesWorkspace::of(&design);
        let ours = runs.best(|| workspace.solve(&design).expect("it has modes"));
        let known = system.modes().expect("it has modes");
        for (found, known) in workspace.eigenvalues().iter().zip(&known) {
            let known = known.eigenvalue().value;
            assert!(
                (found - known).norm() <= 1e-13 * known.norm(),
                "{found} {known}"
            );
        }
        println!(
            "{n:>6} {ours:>10.2} {}",
            peers.beside(&format!("eig {n}"), ours)
        );
    }
}

/// All roots are there, and solve their equation.
fn check(system: &System, modes: &Modes) {
    assert_eq!(modes.eigenvalues().len(), 2 * system.len());
    for mode in modes {
        assert!(mode.backward_error() <= 20.0 * 2f64.powi(-53));
    }
}
