//! Studies of designs from outside.
//!
//! They are one program, which takes less time to build than one of each file.

mod campbell;
mod fit;
mod follower;

/// What no line above names would not run.
#[test]
fn every_file_is_a_part() {
    let own = include_str!("main.rs");
    let here = concat!(env!("CARGO_MANIFEST_DIR"), "/tests");
    for entry in std::fs::read_dir(here).expect("the tests are here") {
        let name = entry.expect("it can be read").file_name();
        let name = name.to_string_lossy().replace(".rs", "");
        let is_apart = ["main"].contains(&name.as_str());
        assert!(is_apart || own.contains(&format!("mod {name};")), "{name}");
    }
}
