//! The rooms of a crate: which of them knows which, read from the paths in its files, is what docs/design.md and the first
//! lines of each room say; nothing knows a room above it, and files do not know each other in circles.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A crate, and its rooms from the lowest up: folders with a `mod.rs`, or single files.
struct House {
    source: &'static str,
    rooms: &'static [&'static str],
}

const HOUSES: [House; 2] = [
    House {
        source: "crates/modes/src",
        rooms: &[
            "linear",
            "model",
            "exact",
            "structure",
            "system",
            "modes",
            "first_order",
            "quality",
            "inclusion",
            "solver",
            "sparse",
            "sweep",
            "sensitivity",
            "participation",
            "assurance",
        ],
    },
    House {
        source: "crates/response/src",
        rooms: &[
            "problem",
            "answer",
            "enclosed",
            "exponential",
            "hold",
            "march",
            "certified",
            "plan",
            "quantity",
            "frequency_response",
            "response_spectrum",
            "state_space",
            "sweep",
        ],
    },
];

type Arrows<T> = BTreeMap<T, BTreeSet<T>>;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn files_below(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            files_below(&path, into);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            into.push(path);
        }
    }
}

/// The code of a file: without comments, and without its tests, which come last.
fn code(text: &str) -> String {
    let lines = text.lines().take_while(|line| *line != "mod tests {");
    let lines = lines.map(|line| line.split("//").next().unwrap_or_default());
    lines.collect::<Vec<_>>().join("\n")
}

/// Every path in some code from `start` on, such as `crate::`, with lists in braces taken apart: what follows `start`.
fn paths(code: &str, start: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (at, _) in code.match_indices(start) {
        let before = code[..at].chars().next_back();
        if before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
            continue;
        }
        let rest = &code[at + start.len()..];
        let word = |text: &str| -> String {
            let text = text.trim_start();
            text.chars()
                .take_while(|c| c.is_alphanumeric() || "_:".contains(*c))
                .collect()
        };
        match rest.strip_prefix('{') {
            Some(list) => {
                let list = list.split('}').next().unwrap_or_default();
                found.extend(list.split(',').map(word).filter(|path| !path.is_empty()));
            }
            None => found.push(word(rest)),
        }
    }
    found
}

/// The modules that a file declares for tests only.
fn for_tests(text: &str) -> Vec<String> {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let pairs = lines.windows(2).filter(|pair| pair[0] == "#[cfg(test)]");
    let names = pairs.filter_map(|pair| {
        pair[1]
            .trim_start_matches("pub(crate) ")
            .strip_prefix("mod ")?
            .strip_suffix(';')
    });
    names.map(str::to_owned).collect()
}

/// The files of a crate but for those of tests, by their paths as modules: `room::file`, and `room` for its `mod.rs`.
fn modules(house: &House) -> BTreeMap<String, String> {
    let source = root().join(house.source);
    let mut files = Vec::new();
    files_below(&source, &mut files);
    let mut modules = BTreeMap::new();
    let mut left_out = BTreeSet::new();
    for file in files {
        let name = file
            .strip_prefix(&source)
            .expect("below it")
            .with_extension("");
        let parts: Vec<_> = name.iter().map(|part| part.to_string_lossy()).collect();
        let name = parts.join("::").trim_end_matches("::mod").to_owned();
        let text = fs::read_to_string(&file).expect("text");
        for module in for_tests(&text) {
            left_out.insert(format!("{name}::{module}"));
        }
        modules.insert(name, text);
    }
    modules.retain(|name, _| name != "lib" && !left_out.contains(name));
    modules
}

fn room(module: &str) -> &str {
    module.split("::").next().unwrap_or_default()
}

/// Which rooms know which.
fn rooms(house: &House) -> Arrows<String> {
    let mut arrows: Arrows<String> = BTreeMap::new();
    for (module, text) in modules(house) {
        let own = room(&module).to_owned();
        let known = arrows.entry(own.clone()).or_default();
        for path in paths(&code(&text), "crate::") {
            let other = room(&path);
            assert!(
                house.rooms.contains(&other),
                "{module}: crate::{path} is in no room: take it from the room that has it"
            );
            if other != own {
                known.insert(other.to_owned());
            }
        }
    }
    arrows
}

/// The names in backticks of the first paragraph of a file.
fn named(text: &str) -> BTreeSet<String> {
    let lines = text.lines().map_while(|line| line.strip_prefix("//!"));
    let opening: Vec<&str> = lines.take_while(|line| !line.trim().is_empty()).collect();
    let opening = opening.join(" ");
    let names = opening.split('`').skip(1).step_by(2);
    names.map(str::to_owned).collect()
}

#[test]
fn no_room_knows_one_above_it() {
    for house in &HOUSES {
        let arrows = rooms(house);
        let found: BTreeSet<&str> = arrows.keys().map(String::as_str).collect();
        let listed: BTreeSet<&str> = house.rooms.iter().copied().collect();
        assert_eq!(found, listed, "{}: the list of rooms", house.source);
        let floor = |name: &str| house.rooms.iter().position(|room| *room == name);
        for (room, known) in &arrows {
            for other in known {
                let up = floor(other) > floor(room);
                assert!(
                    !up,
                    "{}: {room} knows {other}, which is above it",
                    house.source
                );
            }
        }
    }
}

#[test]
fn every_room_says_what_it_knows() {
    let design = fs::read_to_string(root().join("docs/design.md")).expect("the page");
    for house in &HOUSES {
        let modules = modules(house);
        let heading = format!(
            "## The rooms of `{}`",
            house.source.trim_end_matches("/src")
        );
        let (_, table) = design.split_once(&heading).expect(&heading);
        let table = table.split("\n## ").next().unwrap_or_default();
        for (room, known) in rooms(house) {
            let said = named(&modules[&room]);
            assert_eq!(
                said, known,
                "{}/{room}/mod.rs: its first lines",
                house.source
            );
            let start = format!("| `{room}/` | ");
            let row = table.lines().find(|line| line.starts_with(&start));
            let row = row.unwrap_or_else(|| panic!("docs/design.md has no row of {room}"));
            let cell = row[start.len()..].split('|').next().unwrap_or_default();
            let drawn = cell.split('`').skip(1).step_by(2);
            let drawn: BTreeSet<String> = drawn.map(str::to_owned).collect();
            assert_eq!(drawn, known, "docs/design.md: the row of {room}");
        }
    }
}

/// Which files know which, within rooms; between them that is settled. What a `mod.rs` only hands on is no arrow.
fn files(house: &House) -> Arrows<String> {
    let modules = modules(house);
    let mut arrows: Arrows<String> = BTreeMap::new();
    for (module, text) in &modules {
        let code = code(text);
        let lines: Vec<&str> = code
            .lines()
            .filter(|line| !line.starts_with("pub"))
            .collect();
        let own = lines.join("\n");
        let above = module.rsplit_once("::").map(|(above, _)| above);
        let mut known: Vec<String> = Vec::new();
        for path in paths(&own, "super::") {
            known.extend(above.map(|above| format!("{above}::{path}")));
        }
        known.extend(
            paths(&own, "crate::")
                .into_iter()
                .filter(|path| room(path) == room(module)),
        );
        for child in paths(&own, "use ") {
            known.push(format!("{module}::{child}"));
        }
        // The longest part of a path that is a file.
        let file = |path: &String| {
            let mut path = path.as_str();
            loop {
                if modules.contains_key(path) {
                    return Some(path.to_owned());
                }
                path = path.rsplit_once("::")?.0;
            }
        };
        let known = known.iter().filter_map(file).filter(|file| file != module);
        arrows.insert(module.clone(), known.collect());
    }
    arrows
}

#[test]
fn files_do_not_know_each_other_in_circles() {
    for house in &HOUSES {
        let mut left = files(house);
        // Those that know nobody who is left are in no circle.
        loop {
            let free = left
                .iter()
                .filter(|(_, known)| known.iter().all(|one| !left.contains_key(one)));
            let free: Vec<String> = free.map(|(file, _)| file.clone()).collect();
            if free.is_empty() {
                break;
            }
            free.iter().for_each(|file| drop(left.remove(file)));
        }
        assert!(
            left.is_empty(),
            "{}: in circles, or above one: {left:#?}",
            house.source
        );
    }
}

/// Who wants modes and motions alone builds neither the command line nor scenes, reports or integrators.
#[test]
fn modes_and_response_alone_take_few_packages() {
    let cargo = std::process::Command::new(env!("CARGO"))
        .args(["tree", "--offline", "--edges", "normal", "--prefix", "none"])
        .args(["--package", "eigentone", "--no-default-features"])
        .arg("--manifest-path")
        .arg(root().join("Cargo.toml"))
        .output()
        .expect("cargo runs");
    let said = String::from_utf8_lossy(&cargo.stderr);
    assert!(cargo.status.success(), "{said}");
    let list = String::from_utf8_lossy(&cargo.stdout).into_owned();
    let name = |line: &str| line.split(" (").next().unwrap_or_default().to_owned();
    let packages: BTreeSet<String> = list.lines().map(name).collect();
    assert!(packages.len() < 60, "{}: {packages:#?}", packages.len());
    for foreign in ["clap", "serde", "eigentone-check"] {
        let starts = |package: &String| package.starts_with(&format!("{foreign} "));
        assert!(!packages.iter().any(starts), "{foreign}");
    }
}

#[test]
fn paths_are_found_wherever_they_stand() {
    let text = "use crate::b::{C, d::E};\n// crate::no::One\nlet x = crate::f::g();\nuse other_crate::h;\n#[cfg(test)]\nmod tests {\n    use crate::z::Z;\n}\n";
    assert_eq!(paths(&code(text), "crate::"), ["b::", "f::g"]);
    assert_eq!(paths("use super::{a::B, c}", "super::"), ["a::B", "c"]);
    assert_eq!(
        for_tests("#[cfg(test)]\nmod agreement;\nmod other;"),
        ["agreement"]
    );
}

/// Tests of a crate are one program, which takes less time to build than one of each file: what neither it nor the manifest
/// names would not run.
#[test]
fn every_file_of_tests_is_run() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for house in fs::read_dir(root.join("crates")).expect("the crates are here") {
        let house = house.expect("it can be read").path();
        let tests = house.join("tests");
        let Ok(parts) = fs::read_to_string(tests.join("main.rs")) else {
            continue;
        };
        let manifest = fs::read_to_string(house.join("Cargo.toml")).expect("it has a manifest");
        for entry in fs::read_dir(&tests).expect("the tests are here") {
            let name = entry.expect("it can be read").file_name();
            let name = name.to_string_lossy().replace(".rs", "");
            let is_part = name == "main" || parts.contains(&format!("mod {name};"));
            let is_apart = manifest.contains(&format!("name = \"{name}\""));
            assert!(is_part || is_apart, "{}", tests.join(name).display());
        }
    }
}

/// Each fault that is written by hand replaces a text that occurs once in its file (the marks « and » are around the part that is
/// replaced), no two are the same, and the page lists all of them.
#[test]
fn faults_written_by_hand_find_their_place() {
    let read = |path: &str| fs::read_to_string(root().join(path)).unwrap_or_default();
    let list = read("tests/faults/by_hand.json");
    let faults: Vec<BTreeMap<String, String>> = serde_json::from_str(&list).expect("a list");
    let page = read("docs/testing.md");
    assert!(page.contains(&format!("written by hand: {} faults", faults.len())));
    let mut changes = BTreeSet::new();
    for fault in &faults {
        let [title, file, old, new] = ["fault", "file", "old", "new"].map(|key| &fault[key]);
        let found = read(file).matches(&old.replace(['«', '»'], "")).count();
        assert_eq!(
            found, 1,
            "{title:?}: {file} holds {old:?} so many times: write \"old\" and \"new\" in tests/faults/by_hand.json for the code of \
             today"
        );
        let part = old.split(['«', '»']).nth(1).unwrap_or(old);
        assert!(
            changes.insert((file, part, new)),
            "{title:?}: another fault in tests/faults/by_hand.json makes the same of {file}: take one of them out"
        );
        let place = file.replacen("crates/", "", 1).replacen("/src", "", 1);
        assert!(
            page.contains(&format!("\n| {title} | `{place}` | ")),
            "{title:?}: docs/testing.md does not list it, in `{place}`: write a row, with the test that notices it"
        );
    }
}

/// The Python package, which the workspace does not build, asks for every part of the facade that it names.
#[test]
fn the_python_package_asks_for_the_features_that_it_needs() {
    let read = |path: &str| fs::read_to_string(root().join(path)).expect("text");
    let facade = read("crates/eigentone/lib.rs");
    let gated: BTreeMap<&str, Vec<&str>> = facade
        .split("#[cfg(")
        .skip(1)
        .filter_map(|rest| {
            let (condition, item) = rest.split_once(")]\n")?;
            let line = item.lines().next()?.trim_end_matches(';');
            let name = line.rsplit([' ', ':']).next()?;
            let features = condition.split('"').skip(1).step_by(2);
            line.starts_with("pub ").then(|| (name, features.collect()))
        })
        .collect();
    assert_eq!(gated["scene"], ["scene"]);
    let manifest = read("crates/python/Cargo.toml");
    let asked = manifest
        .lines()
        .find(|line| line.starts_with("eigentone = "));
    let asked = asked.expect("it depends on the facade");
    for path in paths(&code(&read("crates/python/src/lib.rs")), "eigentone::") {
        for feature in gated.get(room(&path)).into_iter().flatten() {
            assert!(asked.contains(&format!("\"{feature}\"")), "{path}: {asked}");
        }
    }
}
