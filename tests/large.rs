//! Scenes that are too large for dense matrices, from the command line.

use std::f64::consts::PI;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

fn eigentone(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_eigentone"))
        .args(arguments)
        .output()
        .expect("the binary runs")
}

fn parsed(arguments: &[&str]) -> Value {
    let output = eigentone(arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {error}");
    serde_json::from_slice(&output.stdout).expect("JSON")
}

fn refused(arguments: &[&str], status: i32) -> String {
    let output = eigentone(arguments);
    let error = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {error}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    error
}

fn directory(name: &str) -> PathBuf {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("large")
        .join(name);
    fs::create_dir_all(&directory).expect("a directory");
    directory
}

/// A chain of n unit masses on unit springs, held at both ends, by elements.
fn chain(name: &str, n: usize, rest: &str) -> String {
    let mut masses = Vec::new();
    let mut springs = vec![r#"{"between": ["ground", "m1"], "stiffness": 1}"#.to_owned()];
    for i in 1..=n {
        masses.push(format!(r#"{{"name": "m{i}", "mass": 1}}"#));
        let next = if i == n {
            "ground".to_owned()
        } else {
            format!("m{}", i + 1)
        };
        springs.push(format!(
            r#"{{"between": ["m{i}", "{next}"], "stiffness": 1}}"#
        ));
    }
    let text = format!(
        r#"{{"masses": [{}], "springs": [{}]{rest}}}"#,
        masses.join(","),
        springs.join(",")
    );
    let path = directory(name).join("chain.json");
    fs::write(&path, text).expect("written");
    path.to_str().expect("a UTF-8 path").to_owned()
}

/// The same by Matrix Market files beside the scene.
fn chain_of_matrices(n: usize) -> String {
    let directory = directory("matrices");
    let mut mass = format!("%%MatrixMarket matrix coordinate integer symmetric\n{n} {n} {n}\n");
    let mut stiffness = format!(
        "%%MatrixMarket matrix coordinate real symmetric\n{n} {n} {}\n",
        2 * n - 1
    );
    for i in 1..=n {
        writeln!(mass, "{i} {i} 1").expect("a string");
        writeln!(stiffness, "{i} {i} 2.0").expect("a string");
        if i < n {
            writeln!(stiffness, "{} {i} -1.0", i + 1).expect("a string");
        }
    }
    fs::write(directory.join("m.mtx"), mass).expect("written");
    fs::write(directory.join("k.mtx"), stiffness).expect("written");
    let path = directory.join("scene.json");
    let text = r#"{"matrices": {"mass": "m.mtx", "stiffness": "k.mtx"}}"#;
    fs::write(&path, text).expect("written");
    path.to_str().expect("a UTF-8 path").to_owned()
}

fn frequency(n: usize, j: usize) -> f64 {
    2.0 * (j as f64 * PI / (2.0 * (n as f64 + 1.0))).sin()
}

fn assert_lowest(json: &Value, n: usize, count: usize) {
    assert_eq!(json["bounds"], if n > 400 { "estimated" } else { "proven" });
    assert_eq!(json["infinite"], 0);
    assert_eq!(json["selected"]["of"], 2 * n);
    assert_eq!(json["selected"]["counted"], true);
    let roots = json["eigenvalues"].as_array().expect("a list");
    assert_eq!(roots.len(), 2 * count);
    for (k, root) in roots.iter().enumerate() {
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        let exact = sign * frequency(n, k / 2 + 1);
        let found = root["im"].as_f64().expect("a number");
        assert_eq!(root["re"], 0.0);
        assert_eq!(root["real_bound"], 0.0);
        assert!(
            (found / exact - 1.0).abs() < 1e-14,
            "{found} is not {exact}"
        );
        assert!(root["bound"].as_f64().expect("a bound") < 1e-14 * exact.abs());
    }
    let modes = json["modes"].as_array().expect("a list");
    assert_eq!(modes.len(), count);
    assert_eq!(modes[0]["motion"], "oscillating");
    assert_eq!(modes[0]["shape"].as_array().expect("a list").len(), n);
}

#[test]
fn lowest_modes_of_elements_and_of_matrices() {
    let n = 5000;
    let by_elements = chain("elements", n, "");
    assert_lowest(
        &parsed(&["modes", &by_elements, "--lowest", "4", "--json"]),
        n,
        4,
    );
    let by_matrices = chain_of_matrices(n);
    assert_lowest(
        &parsed(&["modes", &by_matrices, "--lowest", "4", "--json"]),
        n,
        4,
    );
    let table = eigentone(&["modes", &by_elements, "--lowest", "4"]);
    let table = String::from_utf8(table.stdout).expect("UTF-8");
    assert!(
        table.contains("8 of 10000 roots; none between them is missing"),
        "{table}"
    );
}

/// Two waves run round a ring of equal masses with the same frequency. Where one of them alone is listed, that is said.
#[test]
fn a_double_frequency_that_is_cut_in_two_is_told() {
    for (n, one_more) in [(8, "1 more equals"), (450, "1 more is not separated from")] {
        let masses = (0..n).map(|i| format!(r#"{{"name": "m{i}", "mass": 1}}"#));
        let masses: Vec<String> = masses.collect();
        let springs = (0..n).map(|i| {
            let next = (i + 1) % n;
            let around = format!(r#"{{"between": ["m{i}", "m{next}"], "stiffness": 1}}"#);
            around + &format!(r#", {{"between": ["ground", "m{i}"], "stiffness": 0.5}}"#)
        });
        let springs: Vec<String> = springs.collect();
        let (masses, springs) = (masses.join(","), springs.join(","));
        let path = directory("ring").join(format!("{n}.json"));
        let text = format!(r#"{{"masses": [{masses}], "springs": [{springs}]}}"#);
        fs::write(&path, text).expect("written");
        let path = path.to_str().expect("a UTF-8 path");
        let last_line = |options: &[&str]| {
            let output = eigentone(&[&["modes", path], options].concat());
            let table = String::from_utf8(output.stdout).expect("UTF-8");
            table.lines().next_back().expect("a line").to_owned()
        };
        let missing = |roots: usize| {
            let of = 2 * n;
            format!("{roots} of {of} roots; none between them is missing")
        };
        let cut = format!("{}, but {one_more} the last", missing(4));
        assert_eq!(last_line(&["--lowest", "2"]), cut);
        assert_eq!(last_line(&["--lowest", "3"]), missing(6));
        if n == 8 {
            // √(½ + 4 sin²(πj/8)) is 1.04 and 1.58 for j = 1 and 2.
            let near = last_line(&["--near", "1.35", "--count", "3"]);
            assert_eq!(near, format!("{}, but {one_more} the first", missing(6)));
        }
    }
}

#[test]
fn modes_near_a_frequency() {
    let n = 5000;
    let scene = chain("near", n, "");
    let json = parsed(&["modes", &scene, "--near", "1.0", "--count", "3", "--json"]);
    let mut nearest: Vec<f64> = (1..=n).map(|j| frequency(n, j)).collect();
    nearest.sort_by(|a, b| (a - 1.0).abs().total_cmp(&(b - 1.0).abs()));
    nearest.truncate(3);
    nearest.sort_by(f64::total_cmp);
    let modes = json["modes"].as_array().expect("a list");
    assert_eq!(modes.len(), 3);
    for (mode, exact) in modes.iter().zip(nearest) {
        let found = mode["natural_frequency"].as_f64().expect("a number");
        assert!(
            (found / exact - 1.0).abs() < 1e-13,
            "{found} is not {exact}"
        );
    }
}

#[test]
fn the_selection_serves_small_scenes_too() {
    let scene = chain("small", 30, "");
    let json = parsed(&["modes", &scene, "--lowest", "2", "--json"]);
    assert_lowest(&json, 30, 2);
    assert!(
        parsed(&["modes", &scene, "--json"])
            .get("selected")
            .is_none()
    );
}

/// The quarter car's lowest mode is that of the whole system, not what a projection makes of it.
#[test]
fn the_lowest_of_a_damped_scene_are_its_own() {
    let path = std::env::temp_dir().join("eigentone-large-quarter-car.json");
    let scene = r#"{"masses": [{"name": "body", "mass": 300}, {"name": "wheel", "mass": 40}],
        "springs": [{"between": ["body", "wheel"], "stiffness": 18000},
                    {"between": ["wheel", "ground"], "stiffness": 180000}],
        "dampers": [{"between": ["body", "wheel"], "damping": 1000}]}"#;
    fs::write(&path, scene).expect("written");
    let path = path.to_str().expect("UTF-8");
    let all = parsed(&["modes", path, "--json"]);
    let lowest = parsed(&["modes", path, "--lowest", "1", "--json"]);
    assert_eq!(lowest["modes"][0], all["modes"][0]);
    assert_eq!(lowest["modes"].as_array().expect("a list").len(), 1);
    assert_eq!(lowest["eigenvalues"].as_array().expect("a list").len(), 2);
    assert_eq!(lowest["selected"]["of"], 4);
    let near = parsed(&["modes", path, "--near", "60", "--count", "1", "--json"]);
    assert_eq!(near["modes"][0], all["modes"][1]);
}

#[test]
fn what_dense_matrices_cannot_do_is_refused_with_the_way_out() {
    let scene = chain("refused", 5000, r#", "time": {"end": 1, "step": 0.1}"#);
    for command in ["modes", "response", "analyze"] {
        let error = refused(&[command, &scene], 2);
        assert!(
            error.contains("5000 coordinates are too many"),
            "{command}: {error}"
        );
        assert!(error.contains("1.4 GB"), "{command}: {error}");
        assert!(error.contains("--lowest 20"), "{command}: {error}");
    }
}

#[test]
fn options_that_make_no_sense() {
    let scene = chain("options", 3, "");
    for options in [
        &["--lowest", "0"][..],
        &["--lowest", "-1"],
        &["--near", "-1"],
        &["--near", "inf"],
        &["--lowest", "2", "--near", "1"],
        &["--count", "2"],
    ] {
        let mut arguments = vec!["modes", &scene];
        arguments.extend(options);
        refused(&arguments, 2);
    }
}

#[test]
fn a_response_by_some_modes() {
    // The first mode alone, released from its shape: it swings as cos ωt.
    let n = 4200;
    let shape = |i: usize| (i as f64 * PI / (n as f64 + 1.0)).sin();
    let initial: Vec<String> = (1..=n)
        .map(|i| format!(r#""m{i}": {{"displacement": {:?}}}"#, shape(i)))
        .collect();
    let rest = format!(
        r#", "initial": {{{}}}, "time": {{"end": 4000, "step": 500}}"#,
        initial.join(",")
    );
    let scene = chain("response", n, &rest);
    let json = parsed(&[
        "response", &scene, "--modes", "3", "--steps", "8,1", "--json",
    ]);
    assert_eq!(json["bounds"], "estimated");
    assert_eq!(json["step"], serde_json::json!([8, 1]));
    for (column, t) in [4000.0, 500.0].into_iter().enumerate() {
        let swing = (frequency(n, 1) * t).cos();
        for i in [1, 1000, 2100, n] {
            let found = json["displacement"][format!("m{i}")][column]
                .as_f64()
                .expect("a number");
            assert!(
                (found - swing * shape(i)).abs() < 1e-10,
                "m{i} at {t}: {found}"
            );
        }
    }
    let bound = json["displacement_bound"][0].as_f64().expect("a bound");
    assert!(bound < 1e-6, "{bound:e}");
}

/// A ring of unit masses on unit springs, with a dashpot on the first.
fn ring(name: &str, n: usize, dashpot: f64) -> String {
    let masses: Vec<String> = (0..n)
        .map(|i| format!(r#"{{"name": "m{i}", "mass": 1}}"#))
        .collect();
    let springs: Vec<String> = (0..n)
        .map(|i| {
            format!(
                r#"{{"between": ["m{i}", "m{}"], "stiffness": 1}}"#,
                (i + 1) % n
            )
        })
        .collect();
    let text = format!(
        r#"{{"masses": [{}], "springs": [{}],
            "dampers": [{{"between": ["ground", "m0"], "damping": {dashpot}}}]}}"#,
        masses.join(","),
        springs.join(",")
    );
    let path = directory(name).join("ring.json");
    fs::write(&path, text).expect("written");
    path.to_str().expect("a UTF-8 path").to_owned()
}

#[test]
fn near_an_exact_eigenvalue() {
    for dashpot in [0.0, 0.25] {
        let scene = ring("ring-near", 600, dashpot);
        for target in ["1", "1.4142135623730951"] {
            let json = parsed(&["modes", &scene, "--near", target, "--count", "4", "--json"]);
            assert_eq!(json["complete"], true, "{dashpot}, {target}");
            let target: f64 = target.parse().expect("a number");
            let hit = |mode: &&Value| {
                let found = mode["natural_frequency"].as_f64().expect("a number");
                (found - target).abs() < 1e-15
            };
            let modes = json["modes"].as_array().expect("a list");
            // Double without the dashpot, and once beside it.
            let hits = modes.iter().filter(hit).count();
            assert_eq!(hits, if dashpot == 0.0 { 2 } else { 1 }, "{target}");
        }
    }
}

#[test]
fn a_passive_ring_does_not_grow() {
    let scene = ring("ring-lowest", 600, 0.25);
    let json = parsed(&["modes", &scene, "--lowest", "11", "--json"]);
    assert_eq!(json["complete"], true);
    for mode in json["modes"].as_array().expect("a list") {
        assert_ne!(mode["motion"], "growing");
        assert!(mode["eigenvalue"]["re"].as_f64().expect("a number") <= 0.0);
    }
}

#[test]
fn damping_without_a_proof_says_so() {
    let mut dampers = Vec::new();
    for i in 1..=500 {
        let damping = 0.001 * (1 + i % 7) as f64;
        dampers.push(format!(
            r#"{{"between": ["ground", "m{i}"], "damping": {damping}}}"#
        ));
    }
    let rest = format!(r#", "dampers": [{}]"#, dampers.join(","));
    let scene = chain("many-dampers", 500, &rest);
    let json = parsed(&["modes", &scene, "--lowest", "5", "--json"]);
    assert_eq!(json["complete"], false);
    assert_eq!(json["selected"]["counted"], false);
    let table = eigentone(&["modes", &scene, "--lowest", "5"]);
    let table = String::from_utf8(table.stdout).expect("UTF-8");
    assert!(
        table.contains("whether some between them are missing is not known"),
        "{table}"
    );
}
