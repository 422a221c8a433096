//! Full matrices and finite elements: nothing of their structure saves work. Beside NumPy and SciPy.

use eigentone::modes::{MatrixKind, Precision};
use eigentone::prelude::*;
use eigentone::response::{Hold, Samples};
use faer::Mat;

use crate::peers::Peers;
use crate::timing::{Runs, slope};

/// GGᵀ·12/n + shift·I for numbers without a pattern: as in `benches/peers.py`.
fn definite(n: usize, seed: usize, shift: f64) -> Mat<f64> {
    let entry = |i: usize, j: usize| {
        let number =
            (i * i * 31 + i * 7919 + j * j * 17 + j * 104_729 + i * j * 13 + seed) % 10_007;
        number as f64 / 10_007.0 - 0.5
    };
    let g = Mat::from_fn(n, n, entry);
    let square = &g * g.transpose();
    Mat::from_fn(n, n, |i, j| {
        let both = 0.5 * (square[(i, j)] + square[(j, i)]);
        12.0 / n as f64 * both + if i == j { shift } else { 0.0 }
    })
}

/// M, C and K.
struct Matrices([Mat<f64>; 3]);

impl Matrices {
    fn full(n: usize) -> Matrices {
        let times = |a: Mat<f64>, factor: f64| Mat::from_fn(n, n, |i, j| factor * a[(i, j)]);
        Matrices([
            definite(n, 1, 1.0),
            times(definite(n, 2, 0.1), 0.05),
            times(definite(n, 3, 0.5), 100.0),
        ])
    }

    /// A beam clamped at one end, of n/2 elements, with a dashpot at a third of its length.
    fn beam(n: usize) -> Matrices {
        const STIFFNESS: f64 = 2.1e5;
        const MASS: f64 = 7.8;
        let l = 20.0 / n as f64;
        let k = [
            [12.0, 6.0 * l, -12.0, 6.0 * l],
            [6.0 * l, 4.0 * l * l, -6.0 * l, 2.0 * l * l],
            [-12.0, -6.0 * l, 12.0, -6.0 * l],
            [6.0 * l, 2.0 * l * l, -6.0 * l, 4.0 * l * l],
        ];
        let m = [
            [156.0, 22.0 * l, 54.0, -13.0 * l],
            [22.0 * l, 4.0 * l * l, 13.0 * l, -3.0 * l * l],
            [54.0, 13.0 * l, 156.0, -22.0 * l],
            [-13.0 * l, -3.0 * l * l, -22.0 * l, 4.0 * l * l],
        ];
        let mut all = [0, 1, 2].map(|_| Mat::<f64>::zeros(n, n));
        for element in 0..n / 2 {
            for a in 0..4 {
                for b in 0..4 {
                    let at = |end: usize| (2 * element + end).checked_sub(2);
                    if let (Some(i), Some(j)) = (at(a), at(b)) {
                        all[0][(i, j)] += MASS * l / 420.0 * m[a][b];
                        all[2][(i, j)] += STIFFNESS / l.powi(3) * k[a][b];
                    }
                }
            }
        }
        let at = n / 6 * 2;
        all[1][(at, at)] = 50.0;
        Matrices(all)
    }

    fn system(&self, is_damped: bool) -> System {
        let Matrices([m, c, k]) = self;
        let builder = System::builder()
            .matrix(MatrixKind::Mass, m.as_ref())
            .matrix(MatrixKind::Stiffness, k.as_ref());
        let builder = match is_damped {
            true => builder.matrix(MatrixKind::Damping, c.as_ref()),
            false => builder,
        };
        builder.build().expect("a system")
    }
}

pub fn show(runs: &Runs, peers: &Peers) {
    let sizes = |all: &'static [usize]| if runs.once { &all[..1] } else { all };
    println!(
        "\nFull matrices and finite elements in doubles, from the system with nothing known of it, µs"
    );
    println!("coordinates  what                          ours       peer   gain");
    let row = |n: usize, what: &str, peer: &str, ours: f64| {
        let beside = peers.beside(&format!("{peer} {n}"), ours);
        println!("{n:>11}  {what:24} {ours:>9.0} {beside}");
        (n as f64, ours)
    };
    let modes = |matrices: &Matrices, is_damped: bool| {
        runs.best_after(
            || matrices.system(is_damped),
            |system| {
                let modes = system.modes_to(Precision::Double).expect("it has modes");
                assert_eq!(modes.eigenvalues().len(), 2 * system.len());
                modes
            },
        )
    };
    let mut growth = Vec::new();
    let mut rows = |what: &str, sizes: &[usize], time: &dyn Fn(usize) -> f64| {
        let each = sizes.iter().map(|n| row(*n, what, what, time(*n)));
        growth.push((what.to_owned(), slope(&each.collect::<Vec<_>>())));
    };
    rows("full, damped", sizes(&[50, 100, 200, 300]), &|n| {
        modes(&Matrices::full(n), true)
    });
    rows("full, undamped", sizes(&[50, 100, 200, 300]), &|n| {
        modes(&Matrices::full(n), false)
    });
    rows("beam with a dashpot", sizes(&[100, 200, 400, 600]), &|n| {
        modes(&Matrices::beam(n), true)
    });
    rows("full, 2000 held steps", sizes(&[50, 100, 200]), &|n| {
        let matrices = Matrices::full(n);
        runs.best_after(|| matrices.system(true), |system| response(system))
    });
    let fits = growth
        .iter()
        .map(|(what, slope)| format!("{what} n^{slope:.2}"));
    println!("growth: {}", fits.collect::<Vec<_>>().join(", "));
}

/// Three sampled forces, held over each step; all displacements and velocities.
fn response(system: &System) -> Trajectory {
    const STEP: f64 = 0.01;
    let samples = |force: usize| Samples {
        step: STEP,
        values: (0..2000)
            .map(|k| ((k * (force + 3)) as f64 * STEP).sin())
            .collect(),
        hold: Hold::Zero,
    };
    let asked = Response::of(system)
        .every(STEP)
        .until(2000.0 * STEP)
        .to(Precision::Double);
    let asked = (0..3).fold(asked, |asked, force| {
        asked.load(format!("x{}", force + 1), samples(force))
    });
    asked.run().expect("it moves")
}
