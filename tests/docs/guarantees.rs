//! What docs/guarantees.md promises and no other test looks at.

use std::process::Command;

fn printed(arguments: &[&str]) -> Vec<u8> {
    let output = Command::new(env!("CARGO_BIN_EXE_eigentone"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(arguments)
        .output()
        .expect("the binary runs");
    assert!(output.status.success(), "{arguments:?}");
    output.stdout
}

/// Hash tables get another seed in every process, so two runs would show an order that leaks.
#[test]
fn every_byte_repeats() {
    for case in eigentone::gallery::cases() {
        let scene = format!("tests/gallery/scenes/{}.json", case.name());
        let modes = ["modes", &scene, "--json"];
        assert_eq!(printed(&modes), printed(&modes), "{scene}");
        let Some(Ok(grid)) = case
            .scene()
            .problem()
            .map(|problem| problem.map(|problem| *problem.grid()))
        else {
            continue;
        };
        for precision in ["certified", "double"] {
            let response = [
                "response",
                &scene,
                "--json",
                "--steps",
                "1,7,20",
                "--precision",
                precision,
            ];
            assert_eq!(printed(&response), printed(&response), "{scene}");
        }
        // To follow a motion through very many swings takes long.
        let end = grid.time(grid.last());
        let fastest = case
            .truth()
            .eigenvalues
            .iter()
            .map(|root| root.im.to_f64())
            .fold(0.0, f64::max);
        if fastest * end < 1e4 {
            assert_eq!(
                printed(&["analyze", &scene]),
                printed(&["analyze", &scene]),
                "{scene}"
            );
        }
    }
}
