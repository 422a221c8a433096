//! `modes --engine slepc`: SLEPc itself where it is installed, on one and two ranks; and stand-ins for it that fail in every
//! way there is.

use std::f64::consts::PI;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::{fresh, number};

/// The command, with what MPI asks of root.
fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_eigentone"));
    command.args(arguments);
    for name in ["OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM"] {
        command.env(name, "1");
    }
    command
}

fn run(arguments: &[&str]) -> Output {
    command(arguments).output().expect("the binary runs")
}

fn folder(name: &str) -> PathBuf {
    let folder = fresh(&format!("slepc-{name}"));
    fs::create_dir_all(&folder).expect("it can be made");
    folder
}

fn written(file: &Path, text: &str) -> String {
    fs::write(file, text).expect("it can be written");
    file.to_str().expect("a UTF-8 path").to_owned()
}

/// n masses between walls; damping of spring i by its number.
fn chain(
    file: &Path,
    n: usize,
    [mass, stiffness]: [f64; 2],
    damping: impl Fn(usize) -> f64,
) -> String {
    let ends = |i: usize| {
        let name = |i: usize| match i {
            0 => "ground".to_owned(),
            i if i == n + 1 => "ground".to_owned(),
            i => format!("m{i}"),
        };
        format!("\"between\": [\"{}\", \"{}\"]", name(i), name(i + 1))
    };
    let masses: Vec<String> = (1..=n)
        .map(|i| format!("{{\"name\": \"m{i}\", \"mass\": {mass:?}}}"))
        .collect();
    let springs: Vec<String> = (0..=n)
        .map(|i| format!("{{{}, \"stiffness\": {stiffness:?}}}", ends(i)))
        .collect();
    let dampers: Vec<String> = (0..=n)
        .filter(|i| damping(*i) != 0.0)
        .map(|i| format!("{{{}, \"damping\": {:?}}}", ends(i), damping(i)))
        .collect();
    let [masses, springs, dampers] = [masses, springs, dampers].map(|parts| parts.join(",\n"));
    written(
        file,
        &format!(
            "{{\"masses\": [{masses}],\n\"springs\": [{springs}],\n\"dampers\": [{dampers}]}}"
        ),
    )
}

/// Whether SLEPc and MPI are there; if not, this is written to standard error.
fn is_there(folder: &Path, test: &str) -> bool {
    let scene = chain(&folder.join("two.json"), 2, [1.0, 1.0], |_| 0.0);
    let output = run(&["modes", &scene, "--lowest", "1", "--engine", "slepc"]);
    let error = String::from_utf8_lossy(&output.stderr);
    let missing = error.contains("SLEPc is not there") || error.contains("cannot be started");
    if missing {
        let _ = writeln!(std::io::stderr(), "skipped {test}: {}", error.trim());
    }
    !missing
}

/// The roots of modes, once the command has ended well, and what it said besides.
fn modes(arguments: &[&str]) -> (Vec<Value>, String) {
    let output = run(&[arguments, &["--json"]].concat());
    let error = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(output.status.success(), "{arguments:?}: {error}");
    let answer: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let roots = answer["eigenvalues"].as_array().expect("roots");
    let upper = roots.iter().filter(|root| number(&root["im"]) >= 0.0);
    (upper.cloned().collect(), error)
}

/// λ of a mode and its bound.
fn root(mode: &Value) -> ([f64; 2], f64) {
    let part = |name: &str| number(&mode[name]);
    ([part("re"), part("im")], part("bound"))
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Asserts that two answers agree within both bounds, and those of the first are small.
fn assert_same(found: &[Value], own: &[Value], within: f64, what: &str) {
    assert_eq!(found.len(), own.len(), "{what}");
    for (found, own) in found.iter().zip(own) {
        let ((found, bound), (own, own_bound)) = (root(found), root(own));
        let error = apart(found, own);
        assert!(
            error <= bound + own_bound,
            "{what}: {found:?} {own:?} {error:e} {bound:e}"
        );
        assert!(
            bound <= within * own[0].hypot(own[1]),
            "{what}: {found:?} {bound:e}"
        );
    }
}

/// SDLD27 of the guide of validation that `docs/validation.md` names, with what it prints.
#[test]
fn eight_masses_with_dampers_that_couple_modes() {
    const FREQUENCIES: [f64; 8] = [5.53, 10.90, 15.93, 20.45, 24.34, 27.49, 29.84, 31.29];
    let folder = folder("sdld27");
    if !is_there(&folder, "SDLD27 by SLEPc") {
        return;
    }
    let damping = |i: usize| match i {
        0 => 250.0,
        8 => 25.0,
        _ => 50.0,
    };
    let scene = chain(&folder.join("sdld27.json"), 8, [10.0, 1e5], damping);
    let own = modes(&["modes", &scene]).0;
    for ranks in ["1", "2"] {
        let asked = [
            "modes", &scene, "--lowest", "8", "--engine", "slepc", "--ranks", ranks,
        ];
        let (found, said) = modes(&asked);
        assert_eq!(said, "");
        assert_same(&found, &own, 1e-14, ranks);
        for ((found, own), printed) in found.iter().zip(&own).zip(FREQUENCIES) {
            let ((found, _), (own, _)) = (root(found), root(own));
            assert!(apart(found, own) <= 1e-11 * own[1], "{found:?} {own:?}");
            assert!(
                (found[1] / 2.0 / PI / printed - 1.0).abs() < 1e-3,
                "{found:?}"
            );
        }
    }
}

#[test]
fn a_damped_chain_of_twenty_thousand_masses() {
    let folder = folder("chain");
    if !is_there(&folder, "a chain of 20000 masses by SLEPc") {
        return;
    }
    let (n, mass, stiffness, damping) = (20_000, 2.0, 50.0, 0.5);
    let scene = chain(&folder.join("chain.json"), n, [mass, stiffness], |_| {
        damping
    });
    for ranks in ["1", "2"] {
        let asked = [
            "modes", &scene, "--lowest", "5", "--engine", "slepc", "--ranks", ranks,
        ];
        let (found, said) = modes(&asked);
        assert_eq!((found.len(), said.as_str()), (5, ""));
        for (j, mode) in (1..).zip(&found) {
            let sine = (j as f64 * PI / 2.0 / (n as f64 + 1.0)).sin();
            let omega = 2.0 * (stiffness / mass).sqrt() * sine;
            let ratio = damping / (stiffness * mass).sqrt() * sine;
            let exact = [-ratio * omega, omega * (1.0 - ratio * ratio).sqrt()];
            let (found, bound) = root(mode);
            assert!(
                apart(found, exact) <= 1e-14 * omega,
                "{j}: {found:?} {exact:?}"
            );
            assert!(
                (found[0] / exact[0] - 1.0).abs() < 1e-10,
                "{j}: {found:?} {exact:?}"
            );
            assert!(bound <= 1e-14 * omega, "{j}: {bound:e}");
        }
    }
    // One dashpot couples modes.
    let scene = chain(&folder.join("dashpot.json"), n, [mass, stiffness], |i| {
        if i == 0 { 9.0 } else { 0.0 }
    });
    let own = modes(&["modes", &scene, "--lowest", "4"]).0;
    let (found, said) = modes(&[
        "modes", &scene, "--lowest", "4", "--engine", "slepc", "--ranks", "2",
    ]);
    assert_eq!(said, "");
    assert_same(&found, &own, 1e-13, "one dashpot");
}

#[test]
fn damped_modes_near_a_frequency() {
    let folder = folder("near");
    if !is_there(&folder, "damped modes near a frequency by SLEPc") {
        return;
    }
    let scene = chain(&folder.join("near.json"), 600, [1.0, 1.0], |i| {
        if i % 200 == 3 { 0.3 } else { 0.0 }
    });
    let asked = ["modes", &scene, "--near", "0.5", "--count", "4"];
    let own = modes(&asked).0;
    let by_slepc = [&asked[..], &["--engine", "slepc"]].concat();
    let output = run(&by_slepc);
    let error = String::from_utf8_lossy(&output.stderr);
    if error.contains("complex ones") || error.contains("-complex") {
        let _ = writeln!(
            std::io::stderr(),
            "skipped damped modes near a frequency by SLEPc: {}",
            error.trim()
        );
        return;
    }
    let (found, said) = modes(&by_slepc);
    assert_eq!(said, "");
    assert_same(&found, &own, 1e-13, "near");
}

/// A simply supported square plate by finite differences: K = L², L the stencil of five points.
#[test]
fn a_plate_of_forty_thousand_coordinates() {
    let folder = folder("plate");
    if !is_there(&folder, "a plate of 40000 coordinates by SLEPc") {
        return;
    }
    let side = 200usize;
    let n = side * side;
    let mut entries: Vec<(usize, usize, i32)> = Vec::new();
    for at in 0..n {
        let (i, j) = (at / side, at % side);
        // L² by two steps of L.
        let mut row = std::collections::BTreeMap::new();
        let stencil = |i: usize, j: usize| {
            let mut all = vec![(i, j, 4)];
            let steps = [
                (i > 0, i.wrapping_sub(1), j),
                (i + 1 < side, i + 1, j),
                (j > 0, i, j.wrapping_sub(1)),
                (j + 1 < side, i, j + 1),
            ];
            all.extend(
                steps
                    .iter()
                    .filter(|step| step.0)
                    .map(|step| (step.1, step.2, -1)),
            );
            all
        };
        for (a, b, first) in stencil(i, j) {
            for (c, d, second) in stencil(a, b) {
                *row.entry(c * side + d).or_insert(0) += first * second;
            }
        }
        entries.extend(
            row.into_iter()
                .filter(|(column, value)| *column <= at && *value != 0)
                .map(|(column, value)| (at + 1, column + 1, value)),
        );
    }
    let mut text = format!(
        "%%MatrixMarket matrix coordinate integer symmetric\n{n} {n} {}\n",
        entries.len()
    );
    for (row, column, value) in entries {
        text += &format!("{row} {column} {value}\n");
    }
    written(&folder.join("k.mtx"), &text);
    let mut text = format!("%%MatrixMarket matrix coordinate integer symmetric\n{n} {n} {n}\n");
    (1..=n).for_each(|i| text += &format!("{i} {i} 1\n"));
    written(&folder.join("m.mtx"), &text);
    let scene = written(
        &folder.join("plate.json"),
        r#"{"matrices": {"mass": "m.mtx", "stiffness": "k.mtx"}}"#,
    );
    let (found, said) = modes(&[
        "modes", &scene, "--lowest", "4", "--engine", "slepc", "--ranks", "2",
    ]);
    assert_eq!(said, "");
    let own = modes(&["modes", &scene, "--lowest", "4"]).0;
    assert_same(&found, &own, 1e-12, "plate");
    let sine = |j: f64| (j * PI / 2.0 / (side as f64 + 1.0)).sin().powi(2);
    let exact =
        [(1.0, 1.0), (1.0, 2.0), (2.0, 1.0), (2.0, 2.0)].map(|(i, j)| 4.0 * (sine(i) + sine(j)));
    for (mode, exact) in found.iter().zip(exact) {
        let (value, bound) = root(mode);
        assert!(
            (value[1] - exact).abs() <= bound + 1e-15,
            "{value:?} {exact}"
        );
    }
}

/// A stand-in for a program: a script.
#[cfg(unix)]
fn script(file: &Path, lines: &str) -> String {
    use std::os::unix::fs::PermissionsExt;
    let name = written(file, &format!("#!/bin/sh\n{lines}\n"));
    fs::set_permissions(file, fs::Permissions::from_mode(0o755)).expect("it can be made a program");
    name
}

/// What is said by a command that has SLEPc replaced: Python by one that has everything, the launcher by a script.
#[cfg(unix)]
fn replaced(name: &str, launcher: &str, more: &[&str]) -> (Option<i32>, String, Duration) {
    let folder = folder(name);
    let scene = chain(&folder.join("two.json"), 2, [1.0, 1.0], |_| 0.0);
    let python = script(&folder.join("python"), "echo eigentone f");
    let launcher = script(&folder.join("launcher"), launcher);
    let scratch = folder.join("scratch");
    fs::create_dir_all(&scratch).expect("it can be made");
    let start = Instant::now();
    let options = [
        "--lowest",
        "1",
        "--engine",
        "slepc",
        "--python",
        &python,
        "--launcher",
        &launcher,
    ];
    let output = run(&[
        &["modes", &scene],
        &options[..],
        &["--scratch", scratch.to_str().unwrap()],
        more,
    ]
    .concat());
    assert!(output.stdout.is_empty(), "{name}");
    let left = fs::read_dir(&scratch).expect("it is there").count();
    assert_eq!(left, 0, "{name}: files are left");
    let error = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(error.lines().count(), 1, "{name}: {error}");
    (output.status.code(), error, start.elapsed())
}

#[cfg(unix)]
#[test]
fn what_fails_is_said_in_one_line_and_leaves_nothing() {
    // The directory is the last argument, after -n, ranks, Python and driver.
    let cases = [
        ("killed", "kill -9 $$", "ended without an answer (signal: 9"),
        (
            "failed",
            "echo 'eigentone: failed: out of memory' >&2; echo later >&2; exit 1",
            "out of memory",
        ),
        ("silent", "exit 0", "ended without an answer"),
        (
            "root",
            "echo 'mpirun has detected an attempt to run as root.' >&2; exit 1",
            "OMPI_ALLOW_RUN_AS_ROOT=1",
        ),
        (
            "slots",
            "echo 'There are not enough slots available' >&2; exit 1",
            "no room for 1 ranks",
        ),
        ("empty", ": > $5/answer.bin", "cannot be read"),
        (
            "garbage",
            "echo this is no answer, though long enough > $5/answer.bin",
            "does not begin as one does",
        ),
        (
            "short",
            "printf 'EIGENT\\001\\n\\002\\0\\0\\0\\0\\0\\0\\0\\001\\0\\0\\0\\0\\0\\0\\0' > $5/answer.bin",
            "cannot be read",
        ),
        (
            "other",
            "printf 'EIGENT\\001\\n\\003\\0\\0\\0\\0\\0\\0\\0\\001\\0\\0\\0\\0\\0\\0\\0' > $5/answer.bin",
            "3 entries instead of 2",
        ),
        (
            "nothing",
            "printf 'EIGENT\\001\\n\\002\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0' > $5/answer.bin",
            "found no eigenpair",
        ),
    ];
    for (name, launcher, said) in cases {
        let (status, error, _) = replaced(name, launcher, &[]);
        assert_eq!(status, Some(1), "{name}: {error}");
        assert!(error.contains(said), "{name}: {error}");
    }
    let (status, error, time) = replaced("hung", "exec sleep 600", &["--time-limit", "0.3"]);
    assert_eq!(status, Some(1));
    assert!(error.contains("longer than the 0.3 s allowed"), "{error}");
    assert!(time < Duration::from_secs(30));
    // Ignores the request to end.
    let deaf = "trap '' TERM; while true; do sleep 0.05; done";
    let (_, error, time) = replaced("deaf", deaf, &["--time-limit", "0.3"]);
    assert!(error.contains("allowed"), "{error}");
    assert!(time < Duration::from_secs(30));
}

#[cfg(unix)]
#[test]
fn what_is_no_mode_is_left_out_and_said() {
    // One pair, λ = i and x = (1, 1), which is a mode; and one that is none.
    let bytes = |word: [u8; 8]| word.map(|byte| format!("\\{byte:03o}")).concat();
    let whole = |value: u64| bytes(value.to_le_bytes());
    let pair = |words: [f64; 4]| whole(1) + &words.map(|word| bytes(word.to_le_bytes())).concat();
    let pairs = pair([0.0, 1.0, 1.0, 1.0]) + &pair([0.0, 1.3, 1.0, 0.2]);
    let text = format!("EIGENT\\001\\n{}{}{pairs}", whole(2), whole(2));
    let folder = folder("unfit");
    let scene = chain(&folder.join("two.json"), 2, [1.0, 1.0], |_| 0.0);
    let python = script(&folder.join("python"), "echo eigentone f");
    let launcher = script(
        &folder.join("launcher"),
        &format!("printf '{text}' > $5/answer.bin"),
    );
    let (found, said) = modes(&[
        "modes",
        &scene,
        "--lowest",
        "1",
        "--engine",
        "slepc",
        "--python",
        &python,
        "--launcher",
        &launcher,
    ]);
    assert_eq!(root(&found[0]).0, [0.0, 1.0]);
    assert!(
        said.contains("1 of the pairs that SLEPc gave are no modes"),
        "{said}"
    );
}

#[cfg(unix)]
#[test]
fn who_interrupts_leaves_no_process_and_no_file() {
    let folder = folder("interrupt");
    let scene = chain(&folder.join("two.json"), 2, [1.0, 1.0], |_| 0.0);
    let python = script(&folder.join("python"), "echo eigentone f");
    let launcher = script(
        &folder.join("launcher"),
        &format!(
            "echo $$ > {0}/pid.part; mv {0}/pid.part {0}/pid; exec sleep 600",
            folder.display()
        ),
    );
    let scratch = folder.join("scratch");
    fs::create_dir_all(&scratch).expect("it can be made");
    let options = [
        "--lowest",
        "1",
        "--engine",
        "slepc",
        "--python",
        &python,
        "--launcher",
        &launcher,
    ];
    let mut child = command(
        &[
            &["modes", &scene],
            &options[..],
            &["--scratch", scratch.to_str().unwrap()],
        ]
        .concat(),
    )
    .stdout(Stdio::null())
    .stderr(Stdio::null())
    .spawn()
    .expect("the binary runs");
    let start = Instant::now();
    let pid = folder.join("pid");
    while !pid.exists() && start.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(10));
    }
    let kill = Command::new("kill").arg(child.id().to_string()).status();
    assert!(kill.expect("every Unix has it").success());
    assert_eq!(child.wait().expect("it ends").code(), Some(130));
    let launcher = fs::read_to_string(&pid).expect("it was written");
    let alive = Command::new("kill")
        .args(["-0", launcher.trim()])
        .stderr(Stdio::null())
        .status();
    assert!(
        !alive.expect("every Unix has it").success(),
        "the launcher goes on"
    );
    assert_eq!(fs::read_dir(&scratch).expect("it is there").count(), 0);
}
