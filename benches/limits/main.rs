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
mod marches;
mod memory;
mod modes;
mod peers;
mod sweeps;
mod systems;
mod timing;

use peers::Peers;
use timing::Runs;

type Part = fn(&Runs, &Peers);

const PARTS: [(&str, Part); 5] = [
    ("memory", |runs, _| memory::show(runs)),
    ("exponentials", exponentials::show),
    ("modes", modes::show),
    ("marches", marches::show),
    ("sweeps", sweeps::show),
];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let once = arguments.iter().any(|argument| argument == "--test");
    let named = arguments
        .iter()
        .filter(|argument| !argument.starts_with('-'));
    let chosen: Vec<&str> = named.map(String::as_str).collect();
    let runs = Runs { once };
    let peers = Peers::measure(once);
    for (name, show) in PARTS {
        if chosen.is_empty() || chosen.contains(&name) {
            show(&runs, &peers);
        }
    }
}
