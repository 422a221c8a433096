//! How close exponentials and marches come to the limit of the machine, beside their peers, in one run
//! and on one thread.
//!
//! ```sh
//! cargo bench --bench limits
//! PEERS_PYTHON=python3 cargo bench --bench limits   # with SciPy, by benches/peers.py
//! cargo bench --bench limits -- marches sweeps      # these parts alone
//! ```
//!
//! Every time is the best of several runs, and every answer is checked. With `--test` each body runs
//! once, on smaller systems.

mod exponentials;
mod full;
mod marches;
mod memory;
mod modes;
mod peers;
mod sweeps;
mod systems;
mod timing;

use peers::Peers;
use timing::Runs;

/// What shows a part, beside what is measured of SciPy for it.
type Part = (&'static str, &'static [&'static str], fn(&Runs, &Peers));

const PARTS: [Part; 6] = [
    ("memory", &[], |runs, _| memory::show(runs)),
    ("exponentials", &["expm"], exponentials::show),
    ("modes", &["eig"], modes::show),
    ("full", &["full"], full::show),
    ("marches", &["lsim"], marches::show),
    ("sweeps", &["sweep"], sweeps::show),
];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let once = arguments.iter().any(|argument| argument == "--test");
    let named = arguments
        .iter()
        .filter(|argument| !argument.starts_with('-'));
    let named: Vec<&str> = named.map(String::as_str).collect();
    let chosen = |(name, ..): &&Part| named.is_empty() || named.contains(name);
    let runs = Runs { once };
    let sections = PARTS.iter().filter(chosen);
    let sections: Vec<&str> = sections.flat_map(|(_, peers, _)| *peers).copied().collect();
    let peers = Peers::measure(once, &sections);
    for (_, _, show) in PARTS.iter().filter(chosen) {
        show(&runs, &peers);
    }
}
