//! Motions from outside.
//!
//! They are one program, which takes less time to build than one of each file.

mod between;
mod closed_form;
mod decay_to_rest;
#[path = "elements/main.rs"]
mod elements;
mod energy;
#[path = "expm/main.rs"]
mod expm;
mod exponential;
mod frequency_response;
mod history;
mod machines;
mod modal_truncation;
#[path = "response_spectrum/main.rs"]
mod response_spectrum;
#[path = "state_space/main.rs"]
mod state_space;
mod steady_state;

/// What no line above names would not run.
#[test]
fn every_file_is_a_part() {
    let own = include_str!("main.rs");
    let here = concat!(env!("CARGO_MANIFEST_DIR"), "/tests");
    for entry in std::fs::read_dir(here).expect("the tests are here") {
        let name = entry.expect("it can be read").file_name();
        let name = name.to_string_lossy().replace(".rs", "");
        let is_apart = ["main", "sweep", "sweep_memory"].contains(&name.as_str());
        assert!(is_apart || own.contains(&format!("mod {name};")), "{name}");
    }
}
