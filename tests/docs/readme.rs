//! The README shows what the command prints and draws.

use std::fs;
use std::path::Path;
use std::process::Command;

const SCENE: &str = "tests/gallery/scenes/three-mass-1.json";

#[test]
fn readme_is_up_to_date() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("readme");
    let output = Command::new(env!("CARGO_BIN_EXE_eigentone"))
        .current_dir(root)
        .args(["analyze", SCENE, "--out"])
        .arg(&folder)
        .output()
        .expect("the binary runs");
    let printed = String::from_utf8(output.stdout).expect("UTF-8");

    let readme = fs::read_to_string(root.join("README.md")).expect("it is there");
    assert!(readme.contains(&format!("cargo run --release -- analyze {SCENE}\n")));
    let (_, rest) = readme.split_once("```text\n").expect("it shows the output");
    let (shown, _) = rest.split_once("```").expect("the block ends");
    assert_eq!(shown, printed, "paste this into README.md:\n{printed}");

    let shown = "docs/images/three-mass-1-displacement.svg";
    assert!(readme.contains(&format!("({shown})")));
    let shown = fs::read_to_string(root.join(shown)).expect("it is there");
    let drawn = fs::read_to_string(folder.join("displacement.svg")).expect("it was drawn");
    assert!(shown == drawn, "copy {} to docs/images", folder.display());
}
