//! Sweeps of three-mass designs, modes and 200 instants each.

use eigentone::modes::{DesignError, Parameter};
use eigentone::prelude::*;
use eigentone::response::Sweep;

use crate::peers::Peers;
use crate::systems::Chain;
use crate::timing::Runs;

const DESIGNS: usize = 10_000;

/// The spring and the damper of design k.
fn values(k: usize) -> [f64; 2] {
    let part = (0.618_033_988_749_894_9 * (k + 1) as f64).fract();
    [3.5 + 7.0 * part, 0.05 + 0.1 * part]
}

fn set(sweep: &mut Sweep, k: usize) -> Result<(), DesignError> {
    let [spring, damper] = values(k);
    sweep.set(Parameter::Spring(1), spring)?;
    sweep.set(Parameter::Damper(2), damper)
}

/// From a stretched start, under constant forces.
fn ask(system: &System) -> Response<'_> {
    let start = State::at_rest()
        .displace("m1", 6.0)
        .displace("m2", 7.0)
        .displace("m3", 8.0);
    Response::of(system)
        .from(start)
        .load("m1", Step::of(3.0))
        .load("m2", Step::of(9.0))
        .load("m3", Step::of(12.0))
        .every(0.1)
        .until(19.9)
}

/// Some designs as systems of their own.
fn check(sweep: &mut Sweep) {
    for k in [0, 3, 8] {
        let mut chain = Chain::of(3);
        [chain.springs[1], chain.dampers[2]] = values(k);
        let known = ask(&chain.system()).run().expect("it is well posed");
        set(sweep, k).expect("in range");
        let found = sweep.solve().expect("it has an answer").displacement();
        let off = (found - known.displacement()).norm_max();
        assert!(off <= 1e-13 * known.displacement().norm_max(), "{off:e}");
    }
}

pub fn show(runs: &Runs, peers: &Peers) {
    let system = Chain::of(3).system();
    let problem = ask(&system).problem().expect("it is well posed");
    let mut sweep = Sweep::of(&problem).expect("it can be swept");
    check(&mut sweep);
    let designs = if runs.once { 10 } else { DESIGNS };
    let sum = |sweep: &mut Sweep| -> f64 {
        let answers = sweep.each(0..designs, set, |answer| answer.displacement()[(0, 199)]);
        answers.map(|answer| answer.expect("in range")).sum()
    };
    let once = sum(&mut sweep);
    assert!(once.is_finite() && once == sum(&mut sweep));
    let ours = runs.best(|| sum(&mut sweep)) / designs as f64;
    println!("\nSweep of {designs} three-mass designs, modes and 200 instants each, µs a design");
    println!("threads       ours     SciPy   gain");
    println!("      1 {ours:>10.2} {}", peers.beside("sweep", ours));
    #[cfg(feature = "rayon")]
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.expect("threads can be started");
        let time = runs.best(|| {
            let all = (0..designs).collect();
            let read = |answer: eigentone::response::Answer<'_>| answer.displacement()[(0, 199)];
            pool.install(|| sweep.each_in_parallel(all, set, read))
        });
        println!("rayon {threads} {:>10.2}", time / designs as f64);
    }
}
