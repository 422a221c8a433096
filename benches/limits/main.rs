//! How close exponentials and marches come to the limit of the machine, beside their peers, in one run
//! and on one thread.
//!
//! ```sh
//! cargo bench --bench limits
//! PEERS_PYTHON=python3 cargo bench --bench limits   # with SciPy, by benches/peers.py
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

fn main() {
    let once = std::env::args().any(|argument| argument == "--test");
    let runs = timing::Runs { once };
    let peers = peers::Peers::measure(once);
    memory::show(&runs);
    exponentials::show(&runs, &peers);
    modes::show(&runs, &peers);
    marches::show(&runs, &peers);
    sweeps::show(&runs, &peers);
}
