//! The `eigentone` command from outside: what it prints and writes, and what it ends with.

#[path = "cli/fit.rs"]
mod fit;
#[path = "cli/front.rs"]
mod front;
#[path = "cli/matrices.rs"]
mod matrices;
#[path = "cli/slepc.rs"]
mod slepc;
#[path = "cli/typed.rs"]
mod typed;

use std::fs;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::LazyLock;

use eigentone::gallery::{Case, cases};
use serde_json::Value;

fn eigentone(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_eigentone"))
        .args(arguments)
        .output()
        .expect("the binary runs")
}

/// What it prints, once it has ended well and said nothing else.
fn printed(arguments: &[&str]) -> String {
    let output = eigentone(arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {error}");
    assert_eq!(error, "", "{arguments:?}");
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// What it says on standard error, once it has ended with this status and printed nothing.
fn refused(arguments: &[&str], status: i32) -> String {
    let output = eigentone(arguments);
    let error = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {error}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    assert!(error.starts_with("error: "), "{arguments:?}: {error}");
    assert!(!error.contains("panicked"), "{arguments:?}: {error}");
    error
}

fn parsed(arguments: &[&str]) -> Value {
    serde_json::from_str(&printed(arguments)).expect("JSON")
}

fn scene(name: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let file = root.join(format!("tests/gallery/scenes/{name}.json"));
    file.to_str().expect("a UTF-8 path").to_owned()
}

/// A directory of this test's own that does not exist yet.
fn fresh(name: &str) -> PathBuf {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    if directory.exists() {
        fs::remove_dir_all(&directory).expect("it can be removed");
    }
    directory
}

fn has_time(case: &Case) -> bool {
    case.scene().problem().is_some()
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

fn numbers(value: &Value) -> Vec<f64> {
    let array = value
        .as_array()
        .unwrap_or_else(|| panic!("{value} is no array"));
    array.iter().map(number).collect()
}

/// The keys of an object, which must be in this order in the text.
fn assert_keys(text: &str, value: &Value, keys: &[&str]) {
    let object = value.as_object().expect("an object");
    assert_eq!(object.len(), keys.len(), "{:?}", object.keys());
    let places = keys.iter().map(|key| {
        let place = text.find(&format!("\"{key}\":"));
        place.unwrap_or_else(|| panic!("no {key}"))
    });
    assert!(places.is_sorted(), "{keys:?}");
}

/// What is printed of a scene of the gallery. That of a million seconds takes seconds, and is asked for once.
fn analysis(name: &str) -> String {
    static LONG: LazyLock<String> =
        LazyLock::new(|| printed(&["analyze", &scene("undamped-long")]));
    match name {
        "undamped-long" => LONG.clone(),
        _ => printed(&["analyze", &scene(name)]),
    }
}

#[test]
fn every_scene_of_the_gallery_is_answered() {
    for case in cases() {
        let file = scene(case.name());
        let analysis = analysis(case.name());
        let title = case.scene().title().expect("a title").to_owned();
        assert!(analysis.starts_with(&title), "{analysis}");
        for part in ["Structure", "Plan", "Modes", "Bounds", "proven"] {
            assert!(analysis.contains(part), "{}: no {part}", case.name());
        }
        let table = printed(&["modes", &file]);
        let header = table.lines().next().expect("a header");
        for column in ["λ, 1/s", "ω_n, rad/s", "f_n, Hz", "f_d, Hz", "ζ", "motion"] {
            assert!(header.contains(column), "{header}");
        }
        assert!(analysis.contains(table.lines().nth(1).expect("a mode")));
        if !has_time(case) {
            assert!(analysis.contains("no `time`"));
            let error = refused(&["response", &file], 2);
            assert!(
                error.contains("no `time`") && error.contains(&file),
                "{error}"
            );
        }
    }
}

#[test]
fn modes_have_the_shape_that_was_agreed_on() {
    for case in cases() {
        let text = printed(&["modes", &scene(case.name()), "--json"]);
        let json: Value = serde_json::from_str(&text).expect("JSON");
        assert_keys(
            &text,
            &json,
            &["bounds", "eigenvalues", "infinite", "complete", "modes"],
        );
        assert_eq!(json["bounds"], "proven");
        assert_eq!(json["complete"], true);
        let doubles = printed(&[
            "modes",
            &scene(case.name()),
            "--json",
            "--precision",
            "double",
        ]);
        assert!(doubles.starts_with(r#"{"bounds":"estimated""#), "{doubles}");
        let n = case.scene().system().len();
        let roots = json["eigenvalues"].as_array().expect("an array");
        let infinite = json["infinite"].as_u64().expect("a count") as usize;
        assert_eq!(roots.len() + infinite, 2 * n, "{}", case.name());
        let values: Vec<(f64, f64)> = roots
            .iter()
            .map(|root| {
                assert_keys(&text, root, &["re", "im", "bound", "real_bound"]);
                for bound in [&root["bound"], &root["real_bound"]] {
                    assert!(bound.is_null() || number(bound) >= 0.0);
                }
                (number(&root["re"]), number(&root["im"]))
            })
            .collect();
        // Sorted by size, up to the rounding of the size itself; conjugates side by side, + first.
        let size = |(re, im): (f64, f64)| re.hypot(im);
        for pair in values.windows(2) {
            assert!(size(pair[0]) <= size(pair[1]) * (1.0 + 4.0 * f64::EPSILON));
        }
        let mut rest = values.iter();
        while let Some(&(re, im)) = rest.next() {
            if im != 0.0 {
                assert!(im > 0.0, "{}: {values:?}", case.name());
                assert_eq!(rest.next(), Some(&(re, -im)), "{}", case.name());
            }
        }
        let mut covered = 0;
        for mode in json["modes"].as_array().expect("an array") {
            covered += check_mode(&text, mode, n, &values);
        }
        assert_eq!(covered, roots.len(), "{}", case.name());
    }
}

/// Checks one mode, and says how many roots it stands for.
fn check_mode(text: &str, mode: &Value, n: usize, values: &[(f64, f64)]) -> usize {
    let keys = [
        "motion",
        "natural_frequency",
        "damped_frequency",
        "damping_ratio",
        "time_constant",
        "eigenvalue",
        "multiplicity",
        "defective",
        "shape",
        "shape_bound",
        "backward_error",
        "condition",
    ];
    assert_keys(
        &text[text.find("\"modes\":").expect("modes")..],
        mode,
        &keys,
    );
    let root = &mode["eigenvalue"];
    let (re, im) = (number(&root["re"]), number(&root["im"]));
    assert!(values.contains(&(re, im)) && im >= 0.0);
    let motion = mode["motion"].as_str().expect("a word");
    let wanted = match (re, im) {
        (0.0, 0.0) => "rigid",
        (re, _) if re > 0.0 => "growing",
        (_, 0.0) => "decaying",
        _ => "oscillating",
    };
    assert_eq!(motion, wanted);
    let size = re.hypot(im);
    let frequency = number(&mode["natural_frequency"]);
    assert!((frequency - size).abs() <= 2.0 * f64::EPSILON * size);
    assert_eq!(number(&mode["damped_frequency"]), im);
    assert_eq!(mode["damping_ratio"].is_null(), im == 0.0);
    if im != 0.0 {
        let ratio = number(&mode["damping_ratio"]);
        assert!((ratio + re / size).abs() <= 4.0 * f64::EPSILON * ratio.abs());
    }
    assert_eq!(mode["time_constant"].is_null(), re >= 0.0);
    let shape = mode["shape"].as_array().expect("an array");
    assert_eq!(shape.len(), n);
    let sizes: Vec<f64> = shape
        .iter()
        .map(|one| number(&one["re"]).hypot(number(&one["im"])))
        .collect();
    let first_largest = sizes.iter().position(|size| *size == 1.0);
    let largest = &shape[first_largest.expect("a component of size 1")];
    assert_eq!((number(&largest["re"]), number(&largest["im"])), (1.0, 0.0));
    // Components that rounding alone separates are ties.
    assert!(sizes.iter().all(|size| *size <= 1.0 + 2e-12));
    assert!(number(&mode["backward_error"]) >= 0.0);
    let multiplicity = mode["multiplicity"].as_u64().expect("a count") as usize;
    assert!(multiplicity >= 1);
    let defective = mode["defective"].as_bool().expect("yes or no");
    let roots = if defective { multiplicity } else { 1 };
    if im == 0.0 { roots } else { 2 * roots }
}

#[test]
fn responses_have_the_shape_that_was_agreed_on() {
    for case in cases().iter().filter(|case| has_time(case)) {
        let text = printed(&["response", &scene(case.name()), "--json"]);
        let json: Value = serde_json::from_str(&text).expect("JSON");
        let keys = [
            "bounds",
            "step",
            "time",
            "displacement",
            "velocity",
            "displacement_bound",
            "velocity_bound",
        ];
        assert_keys(&text, &json, &keys);
        assert_eq!(json["bounds"], "proven");
        let scene = case.scene();
        let problem = scene.problem().expect("a time").expect("a problem");
        let count = problem.grid().last() as usize + 1;
        let steps = json["step"].as_array().expect("an array");
        assert!((0..count as u64).eq(steps.iter().map(|step| step.as_u64().expect("an index"))));
        for (k, time) in numbers(&json["time"]).into_iter().enumerate() {
            assert_eq!(time, k as f64 * problem.grid().step());
        }
        for quantity in ["displacement", "velocity"] {
            let by_name = json[quantity].as_object().expect("an object");
            assert_eq!(by_name.len(), scene.system().len());
            for name in scene.system().names() {
                assert_eq!(numbers(&by_name[name]).len(), count, "{name}");
            }
            let bounds = json[format!("{quantity}_bound")]
                .as_array()
                .expect("an array");
            assert_eq!(bounds.len(), count);
            assert!(
                bounds
                    .iter()
                    .all(|bound| bound.is_null() || number(bound) >= 0.0)
            );
        }
        let table = printed(&["response", &self::scene(case.name())]);
        assert_eq!(table.lines().count(), count + 1);
    }
}

#[test]
fn steps_come_in_the_order_asked_for() {
    let file = scene("two-mass-forced");
    let all = parsed(&["response", &file, "--json"]);
    let some = parsed(&["response", &file, "--json", "--steps", "400,1,400,0"]);
    assert_eq!(some["step"], serde_json::json!([400, 1, 400, 0]));
    let (all, some) = (
        numbers(&all["displacement"]["m2"]),
        numbers(&some["displacement"]["m2"]),
    );
    for (value, step) in some.iter().zip([400, 1, 400, 0]) {
        assert!((value - all[step]).abs() < 1e-12, "step {step}");
    }
    assert_eq!(some[0], some[2]);
    let table = printed(&["response", &file, "--steps", "400,1"]);
    let steps = table.lines().skip(1);
    let steps: Vec<&str> = steps
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert_eq!(steps, ["400", "1"]);
}

#[test]
fn the_analysis_shows_the_known_numbers() {
    let settled = printed(&["analyze", &scene("three-mass-1")]);
    for (mass, end) in [("m1", "2.93130"), ("m2", "5.01527"), ("m3", "6.41221")] {
        let mut response = settled
            .lines()
            .skip_while(|line| !line.starts_with("Response"));
        let line = response.find(|line| line.trim_start().starts_with(mass));
        let line = line.expect("a line for each mass");
        assert_eq!(line.split_whitespace().nth(1), Some(end), "{line}");
    }
    let roots = printed(&["modes", &scene("two-mass-free")]);
    for root in ["−0.220067 ± 0.770082i", "−0.105537", "−2.954328"] {
        assert!(roots.contains(root), "no {root}:\n{roots}");
    }
    let ends = |name: &str, word: &str| {
        let analysis = analysis(name);
        assert!(analysis.contains(word), "{analysis}");
    };
    ends("undamped-long", "keeps oscillating");
    ends("free-free", "drifts");
    ends("one-mass-resonance", "grows");
}

#[test]
fn wrong_input_ends_with_2_and_one_message() {
    let file = scene("two-mass-free");
    for command in ["analyze", "modes", "response", "check"] {
        let error = refused(&[command, "no/such/scene.json"], 2);
        assert!(error.contains("no/such/scene.json"), "{error}");
        for tolerance in ["1.1e-16", "0", "-1e-9", "NaN", "inf", "1e400", "tight"] {
            refused(&[command, &file, &format!("--tolerance={tolerance}")], 2);
        }
        let both = ["--precision", "double", "--tolerance", "1e-9"];
        refused(&[&[command, &file], &both[..]].concat(), 2);
        refused(&[command, &file, "--precision", "single"], 2);
        refused(&[command, &file, "--jsn"], 2);
        refused(&[command], 2);
    }
    let error = refused(&["response", &file, "--steps", "3,1001"], 2);
    assert!(error.contains("1001") && error.contains(&file), "{error}");
    refused(&["response", &file, "--steps", "-1"], 2);
    refused(&["response", &file, "--steps", ""], 2);
    refused(&["tabulate", &file], 2);
}

/// Numbers that are none for anybody, far beyond what they are of: refused at once, in words that have no infinite number.
#[test]
fn options_far_out_of_range_are_refused() {
    let file = scene("three-mass-1");
    let directory = fresh("options_far_out_of_range_are_refused");
    fs::create_dir_all(&directory).expect("it can be made");
    let write = |name: &str, text: &str| {
        let path = directory.join(name);
        fs::write(&path, text).expect("it can be written");
        path.to_str().expect("UTF-8").to_owned()
    };
    let record = write("record", "0\n1\n");
    let late = r#"{"masses": [{"name": "m", "mass": 1}], "time": {"end": 1.7e308, "step": 1e308}}"#;
    let late = write("late.json", late);
    let cases: [(&[&str], &str); 6] = [
        (
            &["export", &file, "--hold", "zero", "--step", "1e308"],
            "a shorter step",
        ),
        (&["cycle", &file, "--period", "1e300"], "ask for less time"),
        (
            &["spectrum", &record, "--step", "1e300"],
            "leaves the range of doubles",
        ),
        (
            &[
                "spectrum", &record, "--step", "1", "--to", "1e300", "--count", "3",
            ],
            "leaves the range of doubles",
        ),
        (
            &["spectrum", &record, "--step", "1", "--ratio", "1e300"],
            "leaves the range of doubles",
        ),
        (
            &["response", &late],
            "time: the last instant, after 2 steps of 1e308 s, is beyond",
        ),
    ];
    for (asked, right) in cases {
        let error = refused(asked, 2);
        assert!(error.contains(right) && !error.contains(" inf "), "{error}");
    }
}

#[test]
fn either_precision_and_any_tolerance_it_may_have_are_taken() {
    let file = scene("two-mass-free");
    for options in [
        &["--precision", "certified"][..],
        &["--precision", "double"],
        &["--tolerance", "1.1102230246251565e-16"],
        &["--precision", "certified", "--tolerance", "1e-9"],
    ] {
        printed(&[&["modes", &file], options].concat());
    }
    assert!(printed(&["--version"]).starts_with("eigentone "));
    assert!(printed(&["--help"]).contains("analyze"));
}

#[test]
fn a_directory_gets_every_file_whole() {
    let directory = fresh("a_directory_gets_every_file_whole/new");
    let out = directory.to_str().expect("a UTF-8 path");
    for name in ["three-mass-1", "triple-defect"] {
        let file = scene(name);
        assert_eq!(
            printed(&["analyze", &file, "--out", out]),
            printed(&["analyze", &file])
        );
    }
    let read = |name: &str| fs::read_to_string(directory.join(name)).expect(name);
    let mut names: Vec<String> = fs::read_dir(&directory)
        .expect("it exists")
        .map(|entry| {
            entry
                .expect("an entry")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    names.sort();
    let wanted = [
        "acceleration.svg",
        "accelerations.csv",
        "displacement.svg",
        "energy.csv",
        "forces.csv",
        "forces.svg",
        "frf-imaginary.svg",
        "frf-magnitude.svg",
        "frf-nyquist.svg",
        "frf-phase.svg",
        "frf-real.svg",
        "frf.csv",
        "modes.csv",
        "modes.json",
        "modes.md",
        "peaks.csv",
        "report.html",
        "response.csv",
        "response.json",
        "velocity.svg",
    ];
    assert_eq!(names, wanted);
    // The second scene has no response, and has replaced the modes alone.
    assert_eq!(
        read("modes.json"),
        printed(&["modes", &scene("triple-defect"), "--json"])
    );
    assert_eq!(
        read("response.json"),
        printed(&["response", &scene("three-mass-1"), "--json"])
    );
    assert_eq!(read("modes.csv").lines().count(), 1 + 1);
    assert_eq!(read("response.csv").lines().count(), 201 + 1);
    for (name, columns) in [
        (
            "energy.csv",
            "kinetic [J],potential [J],dissipated [J],work [J],bound [J]",
        ),
        ("forces.csv", "spring ground–m1 [N]"),
        ("accelerations.csv", "acceleration m1 [m/s²]"),
    ] {
        let table = read(name);
        assert_eq!(table.lines().count(), 201 + 1, "{name}");
        let mut rows = table.lines().map(|row| row.matches(',').count());
        let cells = rows.next().expect("a header");
        assert!(rows.all(|row| row == cells), "{name}");
        assert!(table.contains(columns), "{table}");
    }
    assert!(
        read("modes.md")
            .lines()
            .any(|line| line.starts_with("| --:"))
    );
    for plot in ["displacement.svg", "velocity.svg"] {
        assert_well_formed(&read(plot));
        assert!(read(plot).contains("viewBox") && read(plot).contains(">m3<"));
    }
    assert!(read("displacement.svg").contains(">displacement, m<"));
    assert!(read("velocity.svg").contains(">velocity, m/s<"));
}

#[test]
fn a_check_compares_every_method() {
    let directory = fresh("a_check_compares_every_method");
    let out = directory.to_str().expect("a UTF-8 path");
    let table = printed(&["check", &scene("three-mass-1"), "--out", out]);
    let read = |name: &str| fs::read_to_string(directory.join(name)).expect(name);
    let json: Value = serde_json::from_str(&read("check.json")).expect("JSON");
    let solvers = json["modes"]["solvers"].as_array().expect("an array");
    let methods = json["response"]["methods"].as_array().expect("an array");
    let listed = solvers.iter().map(|row| &row["solver"]);
    for name in listed.chain(methods.iter().map(|row| &row["method"])) {
        let name = name.as_str().expect("a name");
        assert!(
            table.contains(name) && read("check.md").contains(name),
            "{name}"
        );
    }
    // Tighter tolerances cost more and err less, over the seven decades that separate them.
    let runs: Vec<&Value> = methods
        .iter()
        .filter(|row| row["method"] == "DOP853")
        .collect();
    let (loose, tight) = (runs[0], runs[runs.len() - 1]);
    let error = |row: &Value| number(&row["displacement_error"]);
    assert!(error(tight) < 1e-3 * error(loose));
    let work = |row: &Value| number(&row["work"]["evaluations"]);
    assert!(work(tight) > work(loose));
    assert!(number(&tight["time"]["median"]) > 0.0);
    let plot = read("work-precision.svg");
    assert_well_formed(&plot);
    assert!(plot.contains(">DOP853<") && plot.contains(">run time, s<"));
    // Without a response, the mode solvers are left.
    let modes_only = printed(&["check", &scene("triple-defect")]);
    assert!(modes_only.contains("no `time`") && modes_only.contains("compared with reference"));
    // The pick is given with its reason, and stands on a diagram of its own right.
    let pick = &json["response"]["pick"];
    assert_eq!(pick["method"], "certified exponential");
    assert!(table.contains("The plan picks certified exponential: proven bounds"));
    assert!(plot.contains(">picked<"));
    assert!(number(&methods[0]["displacement_error"]) <= 1.2e-16);
}

#[test]
fn a_study_shows_where_methods_break() {
    let directory = fresh("a_study_shows_where_methods_break");
    let out = directory.to_str().expect("a UTF-8 path");
    let table = printed(&["stability", "--only", "damping", "--out", out]);
    let read = |name: &str| fs::read_to_string(directory.join(name)).expect(name);
    let json: Value = serde_json::from_str(&read("stability.json")).expect("JSON");
    let families = json["families"].as_array().expect("an array");
    assert_eq!(families.len(), 1);
    let methods = families[0]["methods"].as_array().expect("an array");
    for row in methods {
        let name = row["method"].as_str().expect("a name");
        assert!(table.contains(name) && read("stability.md").contains(name));
        let cells = row["cells"].as_array().expect("an array");
        assert_eq!(
            cells.len(),
            families[0]["values"].as_array().expect("an array").len()
        );
        // What is not run says how many steps it would take.
        let not_run = |cell: &&Value| cell["verdict"] == "not run";
        for cell in cells.iter().filter(not_run) {
            assert!(number(&cell["predicted_steps"]) > 1e5);
        }
        if row["planned"] == true {
            assert!(
                cells.iter().all(|cell| cell["verdict"] == "accurate"),
                "{row}"
            );
        }
    }
    let map = read("stability-damping.svg");
    assert_well_formed(&map);
    assert!(map.contains(">damping ratio<") && map.contains(">10⁻¹⁶<") && map.contains(">×<"));
    let error = refused(&["stability", "--only", "friction"], 2);
    assert!(
        error.contains("the families are stiffness, damping"),
        "{error}"
    );
}

/// Every element is closed, in order, and no text has a loose & or <.
fn assert_well_formed(svg: &str) {
    let mut open = Vec::new();
    let mut rest = svg;
    while let Some(start) = rest.find('<') {
        for entity in rest[..start].split('&').skip(1) {
            assert!(
                ["amp;", "lt;", "gt;", "quot;"]
                    .iter()
                    .any(|one| entity.starts_with(one))
            );
        }
        let end = start + rest[start..].find('>').expect("a tag ends");
        let tag = &rest[start + 1..end];
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        let mut attributes: Vec<&str> = tag.split('"').step_by(2).collect();
        let count = attributes.len();
        attributes.sort_unstable();
        attributes.dedup();
        assert_eq!(attributes.len(), count, "an attribute stands twice: {tag}");
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') {
            open.push(tag.split_whitespace().next().expect("a name"));
        }
        rest = &rest[end + 1..];
    }
    assert!(open.is_empty(), "{open:?}");
}

#[test]
fn nothing_is_written_where_something_is_wrong() {
    let directory = fresh("nothing_is_written_where_something_is_wrong");
    let out = directory.to_str().expect("a UTF-8 path");
    refused(&["analyze", "no/such/scene.json", "--out", out], 2);
    assert!(!directory.exists());
    // A directory that is a file.
    fs::write(&directory, "mine").expect("it can be written");
    let error = refused(&["analyze", &scene("two-mass-free"), "--out", out], 1);
    assert!(error.contains(out), "{error}");
    assert_eq!(fs::read(&directory).expect("it is there"), b"mine");
    fs::remove_file(&directory).expect("it can be removed");
    // A file that cannot be replaced: the others are not left in part.
    fs::create_dir_all(directory.join("velocity.svg/inside")).expect("it can be made");
    refused(&["analyze", &scene("two-mass-free"), "--out", out], 1);
    let left = fs::read_dir(&directory).expect("it is there");
    let left = left.map(|entry| entry.expect("an entry").file_name());
    assert!(
        left.into_iter()
            .all(|name| !name.to_string_lossy().ends_with(".tmp"))
    );
}

#[test]
fn a_reader_that_stops_early_is_no_error() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_eigentone"))
        .args(["response", &scene("undamped-long")])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary runs");
    let mut out = child.stdout.take().expect("a pipe");
    out.read_exact(&mut [0; 100]).expect("it prints");
    drop(out);
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}

#[test]
fn names_command_neither_terminal_nor_document() {
    let directory = fresh("names_command_neither_terminal_nor_document");
    fs::create_dir_all(&directory).expect("it can be made");
    let file = directory.join("scene.json");
    let name = "<b>&\\\"\\u001b[2J\\n";
    let text = r#"{"title": "NAME", "masses": [{"name": "NAME", "mass": 1}],
        "springs": [{"between": ["ground", "NAME"], "stiffness": 1}],
        "time": {"end": 1, "step": 0.5}}"#;
    fs::write(&file, text.replace("NAME", name)).expect("it can be written");
    let (file, out) = (
        file.to_str().expect("UTF-8"),
        directory.to_str().expect("UTF-8"),
    );
    let analysis = printed(&["analyze", file, "--out", out]);
    let table = printed(&["response", file]);
    assert!(!analysis.contains('\u{1b}') && !table.contains('\u{1b}'));
    assert_eq!(table.lines().count(), 4);
    for plot in ["displacement.svg", "velocity.svg"] {
        let svg = fs::read_to_string(directory.join(plot)).expect("a plot");
        assert_well_formed(&svg);
        assert!(!svg.contains("<b>") && !svg.contains('\u{1b}'));
    }
    let json = parsed(&["response", file, "--json"]);
    let names = json["displacement"].as_object().expect("an object").keys();
    assert!(names.eq(["<b>&\"\u{1b}[2J\n"]));
}

/// Every file of every command, of a title and names that mean something to a browser, a spreadsheet, Markdown and TeX.
#[test]
fn titles_and_names_stay_text_in_every_file() {
    let directory = fresh("titles_and_names_stay_text_in_every_file");
    let out = directory.join("out");
    fs::create_dir_all(&out).expect("it can be made");
    let file = directory.join("scene.json");
    let names = ["=cmd|'/C calc'!A1", "@a", "+1", "-<i>b</i>", "[c](d) *e*"];
    let masses = names.map(|name| format!("{{\"name\": \"{name}\", \"mass\": 1}}"));
    let springs =
        names.map(|name| format!("{{\"between\": [\"ground\", \"{name}\"], \"stiffness\": 1}}"));
    let text = format!(
        "{{\"title\": \"<script>alert(1)</script> # *t* | \\\\input{{x}}\", \"masses\": [{}], \"springs\": [{}], \"time\": {{\"end\": 1, \"step\": 0.5}}}}",
        masses.join(", "),
        springs.join(", ")
    );
    fs::write(&file, text).expect("it can be written");
    let (file, out) = (file.to_str().expect("UTF-8"), out.to_str().expect("UTF-8"));
    for command in ["analyze", "check", "tables"] {
        printed(&[command, file, "--out", out]);
    }
    let mut seen = 0;
    for name in listed(Path::new(out)) {
        let text = fs::read_to_string(Path::new(out).join(&name)).expect("text");
        let ending = name.rsplit('.').next().unwrap_or_default();
        match ending {
            "html" | "svg" | "md" => {
                assert!(
                    !text.contains("<script>a") && !text.contains("<i>"),
                    "{name}"
                );
            }
            "tex" => assert!(!text.contains("\\input"), "{name}"),
            "csv" => {
                // No name of these has a comma, so that every cell stands between two.
                for cell in text.lines().flat_map(|line| line.split(',')) {
                    let formula = cell.trim_matches('"').starts_with(['=', '+', '-', '@']);
                    assert!(!formula || cell.parse::<f64>().is_ok(), "{name}: {cell}");
                }
            }
            _ => {}
        }
        if ending == "md" {
            assert!(!text.contains("*t*") && !text.contains("*e*") && !text.contains("[c](d)"));
            seen += 1;
        }
    }
    assert_eq!(seen, 3);
}

/// A scene whose names all begin as a formula does: a spreadsheet takes them for formulas.
fn with_names_like_formulas(mut scene: Value) -> Value {
    fn named(value: &Value, names: &mut Vec<String>) {
        match value {
            Value::Object(map) => {
                names.extend(map.get("name").and_then(Value::as_str).map(str::to_owned));
                names.extend(
                    map.get("supports")
                        .and_then(Value::as_array)
                        .into_iter()
                        .flatten()
                        .map(|name| name.as_str().expect("a name").to_owned()),
                );
                map.values().for_each(|value| named(value, names));
            }
            Value::Array(list) => list.iter().for_each(|value| named(value, names)),
            _ => {}
        }
    }
    fn renamed(value: &mut Value, names: &[String]) {
        let new = |text: &str| match names.iter().any(|name| name == text) {
            true => format!("={text}"),
            false => text.to_owned(),
        };
        match value {
            Value::String(text) => *text = new(text),
            Value::Array(list) => list.iter_mut().for_each(|value| renamed(value, names)),
            Value::Object(map) => {
                let entries = std::mem::take(map).into_iter();
                map.extend(entries.map(|(key, mut value)| {
                    renamed(&mut value, names);
                    (new(&key), value)
                }));
            }
            _ => {}
        }
    }
    let mut names = Vec::new();
    named(&scene, &mut names);
    renamed(&mut scene, &names);
    scene
}

/// Every table of every command, in the files and on standard output; what `frf` writes is read again by `fit`.
#[test]
fn no_cell_of_any_table_is_a_formula() {
    let directory = fresh("no_cell_of_any_table_is_a_formula");
    fs::create_dir_all(&directory).expect("it can be made");
    let written = |name: &str, text: &str| {
        let scene = serde_json::from_str(text).expect("JSON");
        let file = directory.join(name);
        fs::write(&file, with_names_like_formulas(scene).to_string()).expect("it can be written");
        file.to_str().expect("UTF-8").to_owned()
    };
    let car = written(
        "car.json",
        r#"{"masses": [{"name": "wheel", "mass": 40}, {"name": "body", "mass": 400}], "supports": ["road"],
            "springs": [{"name": "tyre", "between": ["road", "wheel"], "stiffness": 2e5},
                        {"name": "coil", "between": ["wheel", "body"], "stiffness": 2e4}],
            "dampers": [{"name": "damper", "between": ["wheel", "body"], "damping": 1500}],
            "outputs": [{"name": "grip", "force": "tyre"}, {"name": "comfort", "acceleration": {"body": 1}}],
            "noise": [{"of": "road", "velocity": 1e-3}], "frequencies": {"from": 1, "to": 100, "count": 5},
            "motions": [{"of": "road", "displacement": {"versine": {"height": 0.1, "duration": 0.5}}}],
            "time": {"end": 1, "step": 0.25}}"#,
    );
    let switched = include_str!("gallery/switches/scenes/belt-stick-slip.json");
    let switched = written("switched.json", switched);
    let rotor = written(
        "rotor.json",
        r#"{"matrices": {"mass": [[1, 0], [0, 1]], "damping": [[0, 2], [-2, 0]], "stiffness": [[5, 0], [0, 5]]}}"#,
    );
    let record = directory.join("record.csv");
    fs::write(&record, "t,=ax\n0,0\n0.1,2\n0.2,0\n").expect("it can be written");
    let record = record.to_str().expect("UTF-8");
    let folders = ["a", "b", "c", "d", "e", "f", "g", "h", "i"].map(|name| directory.join(name));
    let folders = folders.each_ref().map(|path| path.to_str().expect("UTF-8"));
    let [
        analyzed,
        with_events,
        tables,
        frf,
        random,
        spectrum,
        campbell,
        sweep,
        front,
    ] = folders;
    let vary = ["--vary", "=coil.stiffness=1e4:3e4:2"];
    let metrics = ["--metric", "gain =road =body", "--metric", "rms =comfort"];
    printed(&["analyze", &car, "--out", analyzed]);
    // A note says that frequencies are of the scene without its switches.
    let noted = eigentone(&["analyze", &switched, "--out", with_events]);
    assert!(noted.status.success());
    printed(&["tables", &car, "--out", tables]);
    printed(&["frf", &car, "--out", frf]);
    printed(&["random", &car, "--out", random]);
    let asked = ["--step", "0.1", "--column", "=ax", "--count", "3", "--out"];
    printed(&[&["spectrum", record], &asked[..], &[spectrum]].concat());
    printed(&[
        "campbell",
        &rotor,
        "--speeds",
        "0:5:3",
        "--given-at",
        "1",
        "--out",
        campbell,
    ]);
    for shard in ["1/2", "2/2"] {
        let part = ["--shard", shard, "--out", sweep];
        printed(&[&["sweep", &car], &vary[..], &metrics, &part].concat());
    }
    printed(&["merge", sweep]);
    let aims = [
        "--minimise",
        "rms =comfort",
        "--minimise",
        "rms =grip",
        "--front",
        "2",
        "--out",
        front,
    ];
    printed(
        &[
            &["optimise", &car, "--vary", "=damper.damping=1000:2000"],
            &aims[..],
        ]
        .concat(),
    );
    let mut all: Vec<(String, String)> = Vec::new();
    for folder in folders {
        for name in listed(Path::new(folder)) {
            let file = Path::new(folder).join(name);
            if file.extension().is_some_and(|ending| ending == "csv") {
                let text = fs::read_to_string(&file).expect("text");
                let name = file.file_name().expect("a name").to_string_lossy();
                all.push((name.into_owned(), text));
            }
        }
    }
    for command in ["modes", "response", "frf", "random"] {
        all.push((command.to_owned(), printed(&[command, &car, "--csv"])));
    }
    all.push(("cycle".to_owned(), printed(&["cycle", &switched, "--csv"])));
    let asked = ["--step", "0.1", "--column", "=ax", "--count", "3", "--csv"];
    let spectrum = printed(&[&["spectrum", record], &asked[..]].concat());
    all.push(("spectrum".to_owned(), spectrum));
    let mut escaped: Vec<&str> = Vec::new();
    for (name, text) in &all {
        // No name of these has a comma, so that every cell stands between two.
        for cell in text.lines().flat_map(|line| line.split(',')) {
            let formula = cell.trim_matches('"').starts_with(['=', '+', '-', '@']);
            assert!(!formula || cell.parse::<f64>().is_ok(), "{name}: {cell}");
            if cell.starts_with("'=") {
                escaped.push(name);
            }
        }
    }
    escaped.sort_unstable();
    escaped.dedup();
    let begin_with_names = [
        "car-response.csv",
        "car-shapes.csv",
        "cycle",
        "frf",
        "frf.csv",
        "front.csv",
        "random",
        "random.csv",
        "spectra.csv",
        "sweep.1-of-2.csv",
        "sweep.2-of-2.csv",
        "sweep.csv",
    ];
    assert_eq!(escaped, begin_with_names);
    assert_eq!(all.len(), 32);
    let measured = directory.join("measured.csv");
    fs::write(&measured, printed(&["frf", &car, "--csv"])).expect("it can be written");
    let measured = measured.to_str().expect("UTF-8");
    let vary = ["--vary", "=coil.stiffness", "--to", measured, "--json"];
    // A note says that the columns of bounds are left out.
    let answer = eigentone(&[&["fit", &car], &vary[..]].concat()).stdout;
    let answer: Value = serde_json::from_slice(&answer).expect("JSON");
    let found = number(&answer["parameters"]["=coil.stiffness"]);
    assert!((found / 2e4 - 1.0).abs() < 1e-10, "{found}");
}

/// A pipe that nobody writes to would be waited for without end.
#[cfg(unix)]
#[test]
fn only_regular_files_are_scenes() {
    let directory = fresh("only_regular_files_are_scenes");
    fs::create_dir_all(&directory).expect("it can be made");
    let pipe = directory.join("pipe.json");
    let made = Command::new("mkfifo").arg(&pipe).status();
    assert!(made.expect("mkfifo runs").success());
    for path in [pipe.as_path(), Path::new("/dev/zero")] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_eigentone"))
            .arg("modes")
            .arg(path)
            .stdin(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the binary runs");
        let started = std::time::Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().expect("it can be asked") {
                break status;
            }
            if started.elapsed().as_secs() > 20 {
                child.kill().expect("it can be ended");
                panic!("{} is waited for", path.display());
            }
            std::thread::sleep(std::time::Duration::from_millis(20));
        };
        assert_eq!(status.code(), Some(2), "{}", path.display());
    }
    let message = refused(&["modes", pipe.to_str().expect("UTF-8")], 2);
    assert!(message.contains("is not a regular file"), "{message}");
}

/// Free masses, nodes without mass, and what grows faster than numbers can follow: an answer, or a clear word, at once.
#[test]
fn systems_at_the_edge_pass_every_command() {
    let directory = fresh("systems_at_the_edge_pass_every_command");
    fs::create_dir_all(&directory).expect("it can be made");
    let out = directory.join("out");
    let out = out.to_str().expect("UTF-8");
    let scene = |name: &str, text: &str| {
        let file = directory.join(name);
        fs::write(&file, text).expect("it can be written");
        file.to_str().expect("UTF-8").to_owned()
    };
    let free = scene("free.json", r#"{"masses": [{"name": "m", "mass": 1}]}"#);
    for command in ["analyze", "check", "tables"] {
        printed(&[command, &free, "--out", out]);
    }
    let table = fs::read_to_string(Path::new(out).join("free.md")).expect("a table");
    assert!(table.contains("| 1 | rigid | 2 |"), "{table}");
    let grows = r#"{"masses": [{"name": "a", "mass": 1}, {"name": "b", "mass": 1}],
        "springs": [{"between": ["ground", "a"], "stiffness": -1e14}, {"between": ["ground", "b"], "stiffness": -1e14},
            {"between": ["a", "b"], "stiffness": JOINT}],
        "initial": {"a": {"displacement": 1}, "b": {"displacement": -1}}, "time": {"end": 2, "step": 1}}"#;
    // Against each other they swing in the second, where what grows together is 0.
    for joint in ["1e13", "1e14"] {
        let file = scene("grows.json", &grows.replace("JOINT", joint));
        let started = std::time::Instant::now();
        let message = refused(&["analyze", &file, "--out", out], 1);
        assert!(message.contains("grow"), "{message}");
        // What is said of the modes is given all the same.
        for (command, result) in [("check", "check.md"), ("tables", "grows.md")] {
            let output = eigentone(&[command, &file, "--out", out]);
            assert_eq!(output.status.code(), Some(1), "{command}");
            let message = String::from_utf8(output.stderr).expect("UTF-8");
            assert!(message.contains("grow"), "{message}");
            let text = fs::read_to_string(Path::new(out).join(result)).expect("it is written");
            assert!(text.contains("## Modes"), "{text}");
            let reason = text
                .lines()
                .find(|line| line.contains("one") && line.contains("grow"));
            assert!(reason.is_some(), "{text}");
        }
        let json = fs::read_to_string(Path::new(out).join("check.json")).expect("it is written");
        let json: Value = serde_json::from_str(&json).expect("JSON");
        assert!(json["response"].is_null() && json["response_error"].is_string());
        let json = fs::read_to_string(Path::new(out).join("grows.json")).expect("it is written");
        let json: Value = serde_json::from_str(&json).expect("JSON");
        assert!(json["response"].is_null() && json["response_error"].is_string());
        assert!(started.elapsed().as_secs() < 30, "{:?}", started.elapsed());
    }
}

#[test]
fn what_would_not_fit_in_memory_is_refused_at_once() {
    let directory = fresh("what_would_not_fit_in_memory_is_refused_at_once");
    fs::create_dir_all(&directory).expect("it can be made");
    let file = directory.join("scene.json");
    let text = r#"{"masses": [{"name": "m", "mass": 1}], "springs": [],
        "time": {"end": 1e12, "step": 0.001}}"#;
    fs::write(&file, text).expect("it can be written");
    let file = file.to_str().expect("UTF-8");
    let error = refused(&["response", file], 2);
    assert!(error.contains("GB"), "{error}");
    refused(&["analyze", file], 2);
    let one = parsed(&["response", file, "--json", "--steps", "1000000000000000"]);
    assert_eq!(numbers(&one["time"]), [1e12]);
}

#[test]
fn harmonic_loads_have_a_steady_state() {
    let directory = fresh("harmonic_loads_have_a_steady_state");
    fs::create_dir_all(&directory).expect("it can be made");
    let file = directory.join("scene.json");
    // k − Ω²m = 4 − 9·1 = −5 and Ωc = 12, so that the amplitude of 26 N is 26/13 m.
    let text = r#"{"masses": [{"name": "m", "mass": 1}],
        "springs": [{"between": ["ground", "m"], "stiffness": 4}],
        "dampers": [{"between": ["ground", "m"], "damping": 4}],
        "loads": [{"on": "m", "harmonic": {"amplitude": 26, "frequency": 3}}],
        "time": {"end": 1, "step": 0.5}}"#;
    fs::write(&file, text).expect("it can be written");
    let (file, out) = (
        file.to_str().expect("UTF-8"),
        directory.to_str().expect("UTF-8"),
    );
    let analysis = printed(&["analyze", file, "--out", out]);
    let (_, steady) = analysis
        .split_once("Steady state under the harmonic loads\n")
        .expect("a table");
    let row = steady.lines().nth(1).expect("a row");
    assert!(row.trim_start().starts_with("3"), "{row}");
    assert!(row.contains("2.00000") && row.contains("−112.620"), "{row}");
    let asked = printed(&["response", file, "--json", "--steps", "0"]);
    let written = fs::read_to_string(directory.join("response.json")).expect("it is there");
    for text in [asked, written] {
        let json: Value = serde_json::from_str(&text).expect("JSON");
        let motion = &json["steady_state"][0];
        assert_eq!(number(&motion["frequency"]), 3.0);
        let x = &motion["amplitude"]["m"];
        let off = (number(&x["re"]) + 10.0 / 13.0).hypot(number(&x["im"]) + 24.0 / 13.0);
        assert!(off <= f64::EPSILON && number(&x["bound"]) <= f64::EPSILON);
    }
    let resonance = printed(&["analyze", &scene("one-mass-resonance")]);
    assert!(resonance.contains("none: 2.0 rad/s is a natural frequency"));
    let free = printed(&["analyze", &scene("three-mass-1")]);
    assert!(!free.contains("Steady state"));
    // Of a frequency 0, beside 8 N that last and 4 N that are 4·sin(π/2) for ever: about 2 m and with 1 m, 3 m in all.
    let constant = r#"{"step": {"force": 8}}, {"on": "m", "harmonic":
        {"amplitude": 4, "frequency": 0, "phase": 1.5707963267948966}}"#;
    let both = text.replace(
        "{\"on\": \"m\", ",
        &format!("{{\"on\": \"m\", {}, {{\"on\": \"m\", ", &constant[1..]),
    );
    fs::write(file, both).expect("it can be written");
    let analysis = printed(&["analyze", file]);
    let (_, steady) = analysis
        .split_once("Steady state under the harmonic loads\n")
        .expect("a table");
    let cells = |row: usize| steady.lines().nth(row).expect("a row").split_whitespace();
    assert_eq!(cells(1).nth(3), Some("2.00000"), "{steady}");
    assert!(
        steady.contains("  About the displacement given each mass moves"),
        "{steady}"
    );
}

/// What is in a directory, which may not exist.
fn listed(directory: &Path) -> Vec<String> {
    let entries = fs::read_dir(directory).into_iter().flatten();
    let name = |entry: std::io::Result<fs::DirEntry>| entry.expect("an entry").file_name();
    entries
        .map(|entry| name(entry).to_string_lossy().into_owned())
        .collect()
}

#[test]
fn few_of_many_steps_take_no_time() {
    let directory = fresh("few_of_many_steps_take_no_time");
    fs::create_dir_all(&directory).expect("it can be made");
    let file = directory.join("scene.json");
    let text = r#"{"masses": [{"name": "m", "mass": 1}],
        "springs": [{"between": ["ground", "m"], "stiffness": 4}],
        "initial": {"m": {"displacement": 1}}, "time": {"end": 2.5e8, "step": 0.25}}"#;
    fs::write(&file, text).expect("it can be written");
    let file = file.to_str().expect("UTF-8");
    let began = std::time::Instant::now();
    let steps = "1000000000,0,999999999,500000000";
    let json = parsed(&["response", file, "--json", "--steps", steps]);
    assert!(began.elapsed().as_secs() < 20);
    let found = numbers(&json["displacement"]["m"]);
    let bounds = numbers(&json["displacement_bound"]);
    // cos 2t, of t = 2.5e8, 0, 2.5e8 − 1/4 and 1.25e8, from 30 digits.
    let known = [
        -0.958_615_455_061_074_6,
        1.0,
        -0.977_758_610_574_923_3,
        0.143_848_088_167_562,
    ];
    for ((found, bound), known) in found.iter().zip(bounds).zip(known) {
        assert!(
            (found - known).abs() <= bound + 1e-16 && bound < 1e-15,
            "{found} {known}"
        );
    }
    refused(&["response", file, "--memory-limit", "0.5"], 2);
}

#[test]
fn memory_is_refused_before_it_is_taken() {
    let file = scene("three-mass-1");
    for command in ["analyze", "modes", "response", "check"] {
        let error = refused(&[command, &file, "--memory-limit", "1e-7"], 2);
        assert!(error.contains("GB of memory, more than the"), "{error}");
        // It is for the matrices of all modes, of which no command takes fewer.
        assert!(error.contains("allowed: allow more with"), "{error}");
        for limit in ["0", "-1", "NaN", "much"] {
            refused(&[command, &file, &format!("--memory-limit={limit}")], 2);
        }
    }
    printed(&["modes", &file, "--memory-limit", "0.001"]);
    // Tables of one scene, and of all, which are none where one is refused.
    let directory = fresh("memory_is_refused_before_it_is_taken");
    let out = directory.to_str().expect("UTF-8");
    for scene in [&[][..], &[file.as_str()]] {
        let limited = [&["tables", "--out", out, "--memory-limit", "1e-7"], scene].concat();
        let error = refused(&limited, 2);
        assert!(error.contains("GB of memory, more than the"), "{error}");
        assert!(!directory.exists());
    }
    // Each instant asked for counts.
    let asked = |count: usize| {
        let steps = vec!["7"; count].join(",");
        let asked = ["tables", &file, "--out", out, "--steps", &steps];
        eigentone(&[&asked[..], &["--memory-limit", "0.002"]].concat())
    };
    assert!(asked(2).status.success());
    assert_eq!(asked(2000).status.code(), Some(2));
    // So does each speed of a rotor.
    let speeds = |range: &str| {
        let asked = ["campbell", &file, "--speeds", range];
        eigentone(&[&asked[..], &["--memory-limit", "0.1"]].concat())
    };
    assert!(speeds("0:1:10").status.success());
    let refusal = speeds("0:1:1000000");
    assert_eq!(refusal.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refusal.stderr).contains("ask for fewer speeds, or allow"));
}

#[test]
fn what_is_out_of_range_is_said_alike() {
    let file = scene("three-mass-1");
    let directory = fresh("what_is_out_of_range_is_said_alike");
    fs::create_dir_all(&directory).expect("it can be made");
    let record = directory.join("record");
    fs::write(&record, "0\n1\n").expect("it can be written");
    let record = record.to_str().expect("UTF-8");
    let vary = ["--vary", "/masses/0/mass=1:2", "--minimise", "frequency 1"];
    let front = [&["optimise", &file][..], &vary].concat();
    for (command, option, wrong, right) in [
        (
            &["cycle", &file][..],
            "--cycles",
            ["0", "1.5"],
            "from 1 to 10000",
        ),
        (
            &["spectrum", record, "--step", "0.1"],
            "--count",
            ["0", "1.5"],
            "from 1 to 1000000",
        ),
        (&front, "--front", ["1", "2.5"], "from 2 to 1000"),
    ] {
        for wrong in wrong {
            let error = refused(&[command, &[option, wrong]].concat(), 2);
            let right = format!("it must be a whole number {right}");
            assert!(error.contains(&right), "{error}");
        }
    }
    let error = refused(&[&front[..], &["--front", "3"]].concat(), 2);
    assert!(error.contains("--front is for the designs between the bests of two metrics"));
    for tolerance in ["1", "2", "inf"] {
        let error = refused(&["modes", &file, "--tolerance", tolerance], 2);
        assert!(error.contains("below 1"), "{error}");
    }
    for count in ["0", "3000000", "1000000000"] {
        let text = format!(
            r#"{{"masses": [{{"name": "m", "mass": 1}}], "frequencies": {{"from": 1, "to": 2, "count": {count}}}}}"#
        );
        let scene = directory.join("frequencies.json");
        fs::write(&scene, text).expect("it can be written");
        let error = refused(&["frf", scene.to_str().expect("UTF-8")], 2);
        assert!(
            error.contains("expected a whole number from 1 to 1000000\n"),
            "{error}"
        );
    }
}

#[test]
fn a_method_may_be_named_twice() {
    printed(&[
        "check",
        &scene("three-mass-1"),
        "--methods",
        "DOP853,dop853",
    ]);
}

#[test]
fn results_replace_results_and_never_the_scene() {
    let directory = fresh("results_replace_results_and_never_the_scene");
    fs::create_dir_all(&directory).expect("it can be made");
    let text = fs::read_to_string(scene("two-mass-free")).expect("a scene");
    let out = directory.to_str().expect("UTF-8");
    for (command, name) in [
        ("analyze", "modes.json"),
        ("check", "check.json"),
        ("tables", "own.json"),
    ] {
        let file = directory.join(name);
        fs::write(&file, &text).expect("it can be written");
        let file = file.to_str().expect("UTF-8");
        let error = refused(&[command, file, "--out", out], 2);
        assert!(error.contains("would replace the scene itself"), "{error}");
        assert_eq!(fs::read_to_string(file).expect("it is there"), text);
        assert_eq!(listed(&directory), [name]);
        fs::remove_file(file).expect("it can be removed");
    }
    // A directory in the place of one of them leaves nothing of the others.
    let file = scene("two-mass-free");
    fs::create_dir(directory.join("modes.csv")).expect("it can be made");
    let error = refused(&["analyze", &file, "--out", out], 1);
    assert!(
        error.contains("modes.csv: cannot be written: a directory has this name"),
        "{error}"
    );
    assert_eq!(listed(&directory), ["modes.csv"]);
    fs::remove_dir(directory.join("modes.csv")).expect("it is empty");
    // Twice into one place: the second results stand, and nothing else does.
    for _ in 0..2 {
        printed(&["analyze", &file, "--out", out]);
    }
    assert!(listed(&directory).iter().all(|name| !name.starts_with('.')));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_one_error() {
    let file = scene("two-mass-free");
    let full = fs::File::options().write(true).open("/dev/full");
    let output = Command::new(env!("CARGO_BIN_EXE_eigentone"))
        .args(["response", &file])
        .stdout(full.expect("Linux has it"))
        .output()
        .expect("the binary runs");
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(
        error.starts_with("error: standard output cannot be written: "),
        "{error}"
    );
    assert_eq!(error.lines().count(), 1);
    // Where no directory can be made.
    let error = refused(&["analyze", &file, "--out", "/dev/null/results"], 1);
    assert!(
        error.contains("/dev/null/results: cannot be written"),
        "{error}"
    );
}

/// Interrupted at any moment: all results are there, or none, and no temporary file.
#[cfg(unix)]
#[test]
fn an_interrupt_leaves_nothing_half_done() {
    let sorted = |directory: &Path| {
        let mut names = listed(directory);
        names.sort();
        names
    };
    let whole = fresh("an_interrupt_leaves_nothing_half_done");
    printed(&["tables", "--out", whole.to_str().unwrap()]);
    let all = sorted(&whole);
    for (round, wait) in [2, 5, 10, 20, 50, 100, 200, 400, 800]
        .into_iter()
        .enumerate()
    {
        let directory = fresh(&format!("an_interrupt_leaves_nothing_half_done_{round}"));
        let mut child = Command::new(env!("CARGO_BIN_EXE_eigentone"))
            .args(["tables", "--out"])
            .arg(&directory)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the binary runs");
        std::thread::sleep(std::time::Duration::from_millis(wait));
        let kill = Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .status();
        assert!(kill.expect("every Unix has it").success());
        let status = child.wait().expect("it ends");
        let left = sorted(&directory);
        match status.code() {
            Some(0) => assert_eq!(left, all),
            // Before the handler is there, the signal itself ends it. It may come once all files have their names, too.
            Some(130) | None => assert!(left.is_empty() || left == all, "{wait} ms: {left:?}"),
            other => panic!("{other:?}"),
        }
    }
}

/// A million seconds take longer than anybody waits, and another way is said.
#[cfg(unix)]
#[test]
fn who_interrupts_is_shown_what_is_quicker() {
    let directory = fresh("quicker");
    fs::create_dir(&directory).expect("it can be made");
    let file = directory.join("scene.json");
    let scene = r#"{"masses": [{"name": "m", "mass": 1}], "springs": [{"between": ["ground", "m"], "stiffness": 1}],
        "dampers": [{"between": ["ground", "m"], "damping": 1e-9}], "initial": {"m": {"displacement": 1}},
        "time": {"end": 3e6, "step": 1}}"#;
    fs::write(&file, scene).expect("it can be written");
    let child = Command::new(env!("CARGO_BIN_EXE_eigentone"))
        .args(["response", "--json"])
        .arg(&file)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary runs");
    std::thread::sleep(std::time::Duration::from_millis(300));
    let kill = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(kill.expect("every Unix has it").success());
    let output = child.wait_with_output().expect("it ends");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(
        said.starts_with("interrupted; quicker: --precision double"),
        "{said}"
    );
}

/// A chain of 66 with a dashpot and a node without mass on springs that push, which is more than is proven.
#[test]
fn why_bounds_are_not_proven_is_said() {
    let directory = fresh("estimated");
    fs::create_dir(&directory).expect("it can be made");
    let file = directory.join("chain.json");
    let mass = |i: usize| format!(r#"{{"name": "m{i}", "mass": {}}}"#, u8::from(i != 20));
    let spring = |i: usize| {
        format!(
            r#"{{"between": ["m{i}", "m{}"], "stiffness": {}}}"#,
            i + 1,
            if i == 19 || i == 20 {
                -1
            } else {
                1 + i as i32 % 3
            }
        )
    };
    let masses: Vec<String> = (0..66).map(mass).collect();
    let springs: Vec<String> = (0..65).map(spring).collect();
    let scene = format!(
        r#"{{"masses": [{}], "springs": [{}], "dampers": [{{"between": ["ground", "m7"], "damping": 0.5}}]}}"#,
        masses.join(", "),
        springs.join(", ")
    );
    fs::write(&file, scene).expect("it can be written");
    let output = eigentone(&["modes", file.to_str().expect("a UTF-8 path")]);
    assert!(output.status.success());
    let note = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(
        note.starts_with("note: ") && note.contains("bounds are estimated"),
        "{note}"
    );
    assert!(
        note.contains("66 coordinates are more than the 64"),
        "{note}"
    );
}

/// −1 three times and another root 2^-42.4 beside it twice, which doubles do not separate.
const NEARLY_FIVE_FOLD: &str = r#"{"matrices": {
    "mass": [[1, 0, -1], [0, 0, 0], [0, 0, 1]],
    "damping": [[2.0000000000001705, 0, -2.0000000000001705], [2, 1, -3.999999999999943], [0, 0, 2.0000000000001705]],
    "stiffness": [[1.0000000000001705, 0, -1.0000000000001705], [2, 1, -4], [0, 0, 1.0000000000001705]]}}"#;

/// A free body is no spring: there is no table of forces without columns.
#[test]
fn forces_of_no_elements_are_not_written() {
    let folder = fresh("no-elements");
    fs::create_dir(&folder).expect("it can be made");
    let path = folder.join("free.json");
    let scene = r#"{"masses": [{"name": "m", "mass": 1}], "initial": {"m": {"velocity": 1}}, "time": {"end": 1, "step": 0.5}}"#;
    fs::write(&path, scene).expect("it can be written");
    let out = folder.join("out");
    let [path, results] = [&path, &out].map(|path| path.to_str().expect("a UTF-8 path"));
    printed(&["analyze", path, "--out", results]);
    assert!(out.join("accelerations.csv").exists());
    assert!(!out.join("forces.csv").exists());
}

/// Doubles give one root of two overdamped masses on a soft negative spring 35 times too large: it is named, and so is what helps.
#[test]
fn doubtful_roots_of_a_sweep_are_named() {
    let folder = fresh("sweep-doubtful");
    fs::create_dir(&folder).expect("it can be made");
    let path = folder.join("two.json");
    let scene = r#"{"masses": [{"name": "a", "mass": 0.001}, {"name": "b", "mass": 0.001}],
        "springs": [{"between": ["ground", "a"], "stiffness": -1e-6}, {"between": ["a", "b"], "stiffness": 2e4}],
        "dampers": [{"between": ["a", "b"], "damping": 5e5}, {"between": ["ground", "b"], "damping": 300}]}"#;
    fs::write(&path, scene).expect("it can be written");
    let path = path.to_str().expect("a UTF-8 path");
    let ask = |more: &[&str]| {
        let start = ["sweep", path, "--vary", "/springs/0/stiffness=-1e-6,1e9"];
        let output = eigentone(&[&start, more].concat());
        assert!(output.status.success(), "{output:?}");
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
        [text(output.stdout), text(output.stderr)]
    };
    let [lines, note] = ask(&["--json"]);
    let lines: Vec<Value> = lines
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    // 1e-6 N/m over 300 N·s/m.
    let right = 1e-6 / 300.0;
    let roots = lines[0]["eigenvalues"].as_array().expect("roots");
    let wrong = (1..=roots.len()).zip(roots).filter(|(_, root)| {
        let value = root[0].as_f64().expect("a number");
        value > 0.0 && (value - right).abs() > 1e-6 * right
    });
    let wrong: Vec<usize> = wrong.map(|(number, _)| number).collect();
    let doubtful = lines[0]["doubtful_roots"].as_array().expect("some are");
    assert!(
        !wrong.is_empty(),
        "the scene is no example any more: {}",
        lines[0]
    );
    for number in wrong {
        assert!(doubtful.contains(&Value::from(number)), "{}", lines[0]);
    }
    assert_eq!(lines[1]["doubtful_roots"], Value::Null, "all have a bound");
    assert!(
        note.contains("roots of 1 of 2 designs are doubtful")
            && note.contains("take --precision certified"),
        "{note}"
    );
    let out = folder.join("out");
    let [table, _] = ask(&["--out", out.to_str().expect("a UTF-8 path")]);
    let numbers: Vec<String> = doubtful.iter().map(Value::to_string).collect();
    let marked: Vec<bool> = table
        .lines()
        .map(|line| line.ends_with(&format!("doubtful: {}", numbers.join(", "))))
        .collect();
    assert_eq!(marked, [false, true, false], "{table}");
    let csv = fs::read_to_string(out.join("sweep.csv")).expect("a table");
    let lines: Vec<&str> = csv.lines().collect();
    assert!(lines[0].ends_with(",doubtful,doubtful roots"), "{csv}");
    assert!(
        lines[1].ends_with(&format!(",false,{}", numbers.join(" "))),
        "{csv}"
    );
    assert!(lines[2].ends_with(",true,"), "{csv}");
    let page = fs::read_to_string(out.join("sweep.html")).expect("a page");
    assert!(page.contains("Roots of 1 of 2 designs are doubtful and not drawn"));
    let [_, note] = ask(&["--precision", "certified"]);
    assert_eq!(note, "");
}

#[test]
fn doubtful_roots_are_marked_wherever_they_are_shown() {
    let directory = fresh("doubtful");
    fs::create_dir(&directory).expect("it can be made");
    let file = directory.join("five.json");
    fs::write(&file, NEARLY_FIVE_FOLD).expect("it can be written");
    let file = file.to_str().expect("a UTF-8 path");
    let in_doubles = |more: &[&str]| {
        let arguments = [&["modes", file, "--precision", "double"], more].concat();
        let output = eigentone(&arguments);
        assert!(output.status.success());
        let note = String::from_utf8(output.stderr).expect("UTF-8");
        assert!(note.starts_with("note: ") && note.contains("5 of 5 roots are doubtful"));
        assert!(note.contains("leave out --precision double"), "{note}");
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    let table = in_doubles(&[]);
    let rows = table
        .lines()
        .skip(1)
        .filter(|line| line.contains("doubtful"));
    let rows: Vec<&str> = rows.filter(|line| !line.starts_with('?')).collect();
    assert!(!rows.is_empty());
    assert!(rows.iter().all(|row| row.contains('?')), "{table}");
    for word in ["decaying", "oscillating", "fold", "defective"] {
        assert!(!table.contains(word), "{table}");
    }
    assert!(table.contains("?: 5 of 5 roots are doubtful"), "{table}");
    let json: Value = serde_json::from_str(&in_doubles(&["--json"])).expect("JSON");
    assert_eq!(json["complete"], false);
    for root in json["eigenvalues"].as_array().expect("roots") {
        assert_eq!(
            (&root["bound"], &root["doubtful"]),
            (&Value::Null, &Value::Bool(true))
        );
    }
    for mode in json["modes"].as_array().expect("modes") {
        assert_eq!(mode["motion"], "doubtful");
        for key in [
            "damping_ratio",
            "time_constant",
            "multiplicity",
            "defective",
        ] {
            assert_eq!(mode[key], Value::Null, "{key}");
        }
        assert!(mode["cluster"].is_u64());
    }
    let out = directory.join("report");
    let results = out.to_str().expect("a UTF-8 path");
    let output = eigentone(&["analyze", file, "--precision", "double", "--out", results]);
    assert!(output.status.success() && !output.stderr.is_empty());
    let page = fs::read_to_string(out.join("report.html")).expect("a page");
    assert!(page.contains("<span>doubtful</span>") && !page.contains("<span>decaying</span>"));
    // With proof each is what it is.
    let json = parsed(&["modes", file, "--json"]);
    let counts = json["modes"].as_array().expect("modes").iter();
    let counts: Vec<u64> = counts
        .filter_map(|mode| mode["multiplicity"].as_u64())
        .collect();
    assert_eq!(
        (counts, &json["complete"]),
        (vec![3, 2, 2], &Value::Bool(true))
    );
}

/// Matrices have the sizes of the names; a discrete form steps where `response` goes; the files are what is printed.
#[test]
fn state_space_forms_have_the_shape_that_was_agreed_on() {
    let directory = fresh("export");
    fs::create_dir_all(&directory).expect("it can be made");
    let file = directory.join("car.json");
    let text = r#"{"masses": [{"name": "body", "mass": 290}, {"name": "wheel", "mass": 59}], "supports": ["road"],
        "springs": [{"between": ["wheel", "body"], "stiffness": 16812}, {"between": ["road", "wheel"], "stiffness": 190000, "name": "tyre"}],
        "dampers": [{"between": ["wheel", "body"], "damping": 1000}, {"between": ["road", "wheel"], "damping": 50}],
        "motions": [{"of": "road", "displacement": {"step": {"height": 0.05}}}],
        "outputs": [{"name": "tyre force", "force": "tyre"}], "time": {"end": 0.1, "step": 0.01}}"#;
    fs::write(&file, text).expect("it can be written");
    let file = file.to_str().expect("a UTF-8 path");
    let json = printed(&["export", file, "--json"]);
    let form: Value = serde_json::from_str(&json).expect("JSON");
    let keys = [
        "bounds", "A", "B", "C", "D", "states", "inputs", "outputs", "bound",
    ];
    assert_keys(&json, &form, &keys);
    assert_eq!(form["bounds"], "proven");
    assert_eq!(form["inputs"], serde_json::json!(["road displacement"]));
    let outputs = ["body displacement", "wheel displacement", "tyre force"];
    assert_eq!(form["outputs"], serde_json::json!(outputs));
    let matrix = |form: &Value, key: &str| -> Vec<Vec<f64>> {
        form[key]
            .as_array()
            .expect("rows")
            .iter()
            .map(numbers)
            .collect()
    };
    for (key, rows, columns) in [("A", 4, 4), ("B", 4, 1), ("C", 3, 4), ("D", 3, 1)] {
        let matrix = matrix(&form, key);
        assert_eq!((matrix.len(), matrix[0].len()), (rows, columns), "{key}");
    }

    let out = directory.join("out");
    let out = out.to_str().expect("a UTF-8 path");
    let held = parsed(&[
        "export", file, "--hold", "zero", "--step", "0.01", "--json", "--out", out,
    ]);
    assert_eq!(
        (&held["hold"], number(&held["step"])),
        (&"zero".into(), 0.01)
    );
    let [a, b, c, d] = ["A", "B", "C", "D"].map(|key| matrix(&held, key));
    let motion = parsed(&["response", file, "--json"]);
    let force = numbers(&motion["outputs"]["tyre force"]);
    let mut state = [0.0; 4];
    for wanted in force {
        let dot = |row: &Vec<f64>| row.iter().zip(state).map(|(a, x)| a * x).sum::<f64>();
        let output = dot(&c[2]) + d[2][0] * 0.05;
        assert!((output - wanted).abs() < 1e-9, "{output} {wanted}");
        let next: Vec<f64> = a
            .iter()
            .zip(&b)
            .map(|(a, b)| dot(a) + b[0] * 0.05)
            .collect();
        state.copy_from_slice(&next);
    }
    let market = fs::read_to_string(Path::new(out).join("B.mtx")).expect("a file");
    let lines: Vec<&str> = market.lines().collect();
    assert_eq!(
        lines[..2],
        ["%%MatrixMarket matrix array real general", "4 1"]
    );
    assert_eq!(lines[5].parse(), Ok(b[3][0]));
    let mut files = listed(Path::new(out));
    files.sort();
    assert_eq!(files, ["A.mtx", "B.mtx", "C.mtx", "D.mtx", "export.json"]);

    // The wheel's velocity jumps with the road: its acceleration follows the road's velocity.
    let text = text.replace(r#""force": "tyre""#, r#""acceleration": {"wheel": 1}"#);
    let kerb = directory.join("kerb.json");
    fs::write(&kerb, text).expect("it can be written");
    let raised = eigentone(&["export", kerb.to_str().expect("a UTF-8 path"), "--json"]);
    let said = String::from_utf8_lossy(&raised.stderr);
    assert!(
        raised.status.success() && said.contains("the input is the velocity of road"),
        "{said}"
    );
    let form: Value = serde_json::from_slice(&raised.stdout).expect("JSON");
    assert_eq!(form["inputs"], serde_json::json!(["road velocity"]));

    let table = printed(&["export", file, "--from", "body", "--to", "tyre force"]);
    assert!(
        table.contains("body force") && table.contains("D: 1 × 1"),
        "{table}"
    );
    let named = [
        "export",
        file,
        "--json",
        "--to",
        "tyre force",
        "--to",
        "body",
    ];
    let form: Value = serde_json::from_str(&printed(&named)).expect("JSON");
    let outputs = serde_json::json!(["tyre force", "body displacement"]);
    assert_eq!(form["outputs"], outputs, "in the order named");
    // A node without mass on one support alone: B is 0, within a bound that is said.
    let text = r#"{"masses": [{"name": "a", "mass": 0}], "supports": ["r"],
        "springs": [{"between": ["r", "a"], "stiffness": 1}], "dampers": [{"between": ["r", "a"], "damping": 3}]}"#;
    let node = directory.join("node.json");
    fs::write(&node, text).expect("it can be written");
    let node = node.to_str().expect("a UTF-8 path");
    let asked = [
        "export", node, "--from", "r", "--hold", "zero", "--step", "0.1",
    ];
    let held = parsed(&[&asked[..], &["--json"]].concat());
    assert_eq!(number(&held["A"][0][0]), (-0.1f64 / 3.0).exp());
    let (zero, bound) = (number(&held["B"][0][0]), number(&held["bound"]["B"][0][0]));
    assert!(zero == 0.0 && bound > 0.0 && bound < 1e-60, "{bound:e}");
    let table = printed(&asked);
    let (_, said) = table
        .split_once("but for 1 entry that is proven within an absolute error of ")
        .expect("how well 0 is known");
    let said = said.split(';').next().expect("a number");
    let said: f64 = said.replace('−', "-").parse().expect("a number");
    assert!(said >= bound && said <= 1.1 * bound, "{said:e} {bound:e}");

    let error = refused(&["export", file, "--from", "wall"], 2);
    assert!(error.contains("known are \"body\", \"wheel\""), "{error}");
    let error = refused(&["export", file, "--hold", "zero"], 2);
    assert!(error.contains("belong together"), "{error}");
    refused(&["export", file, "--hold", "zero", "--step", "-1"], 2);
    // Its entries have all digits anyway.
    let error = refused(&["export", file, "--precision", "double"], 2);
    assert!(error.contains("unexpected argument"), "{error}");
}

/// Each quantity by names, with bounds or null and a reason; files; what is refused.
#[test]
fn root_mean_squares_have_the_shape_that_was_agreed_on() {
    let directory = fresh("random");
    fs::create_dir_all(&directory).expect("it can be made");
    let file = directory.join("mast.json");
    let text = r#"{"masses": [{"name": "m1", "mass": 2}], "supports": ["soil"],
        "springs": [{"between": ["soil", "m1"], "stiffness": 8, "name": "mast"}],
        "dampers": [{"between": ["soil", "m1"], "damping": 0.5}],
        "outputs": [{"name": "sway", "displacement": {"m1": 1, "soil": -1}}, {"name": "pull", "force": "mast"}],
        "noise": [{"of": "soil", "acceleration": 1}]}"#;
    fs::write(&file, text).expect("it can be written");
    let name = file.to_str().expect("a UTF-8 path");
    let out = directory.join("out");
    let out = out.to_str().expect("a UTF-8 path");
    let json = printed(&["random", name, "--json", "--out", out]);
    let answer: Value = serde_json::from_str(&json).expect("JSON");
    assert_keys(&json, &answer, &["bounds", "rms", "zero_crossings"]);
    let crossings = &answer["zero_crossings"];
    assert_eq!(crossings["displacement"]["m1"], Value::Null);
    // σ_v/2πσ_x = ω₀/2π.
    let rate = number(&crossings["outputs"]["sway"]["value"]);
    assert!((rate - std::f64::consts::FRAC_1_PI).abs() < 1e-15, "{rate}");
    assert_eq!(answer["bounds"], "proven");
    let rms = &answer["rms"];
    let quantities = ["displacement", "velocity", "acceleration", "outputs"];
    assert_keys(&json, rms, &quantities);
    // S m²/4ck and k² as much.
    assert_eq!(number(&rms["outputs"]["sway"]["value"]), 0.5);
    assert_eq!(number(&rms["outputs"]["pull"]["value"]), 4.0);
    assert!(number(&rms["acceleration"]["m1"]["bound"]) < 1e-15);
    let body = &rms["displacement"]["m1"];
    assert_eq!(
        (&body["value"], &body["bound"]),
        (&Value::Null, &Value::Null)
    );
    let reason = "infinite, by the noise in soil acceleration";
    assert_eq!(body["reason"], reason);
    let mut files = listed(Path::new(out));
    files.sort();
    assert_eq!(
        files,
        ["random.csv", "random.json", "spectra.csv", "spectra.svg"]
    );
    let spectra = fs::read_to_string(Path::new(out).join("spectra.csv")).expect("it is there");
    assert!(
        spectra.contains(",m1 acceleration [(m/s²)²/Hz],"),
        "{spectra}"
    );
    assert!(
        spectra.contains(",sway [m²/Hz],sway bound [m²/Hz],pull [N²/Hz],"),
        "{spectra}"
    );

    let table = printed(&["random", name]);
    assert!(table.contains("sway") && table.contains(reason), "{table}");
    assert!(!table.contains("peak"), "{table}");
    let json = printed(&["random", name, "--peak-in", "600", "--json"]);
    let answer: Value = serde_json::from_str(&json).expect("JSON");
    let peaks = &answer["expected_peak"];
    assert_eq!(peaks["duration"], 600.0);
    let peak = number(&peaks["outputs"]["sway"]["value"]);
    let root = (2.0 * (1200.0 * rate).ln()).sqrt();
    assert!(
        (peak - 0.5 * (root + 0.577_215_664_9 / root)).abs() < 1e-10,
        "{peak}"
    );
    refused(&["random", name, "--peak-in", "-1"], 2);
    let undamped = text.replace("0.5", "0");
    fs::write(&file, undamped).expect("it can be written");
    let error = refused(&["random", name], 2);
    assert!(
        error.contains("an undamped mode does not come to rest"),
        "{error}"
    );
    let (quiet, _) = text.split_once(r#""noise""#).expect("it has noise");
    let quiet = format!(r#"{quiet}"title": "quiet"}}"#);
    fs::write(&file, quiet).expect("it can be written");
    let error = refused(&["random", name], 2);
    assert!(error.contains("it has no `noise`"), "{error}");
}

/// An overhung disc with I_p = 2 I_d: backward, forward, backward, and nothing else by proof; files in both units.
#[test]
fn campbell_diagrams_have_critical_speeds_and_files() {
    let directory = fresh("campbell");
    fs::create_dir_all(&directory).expect("it can be made");
    let file = directory.join("rotor.json");
    let text = r#"{"matrices": {
        "mass": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]],
        "damping": [[0,0,0,0],[0,0,0,200],[0,0,0,0],[0,-200,0,0]],
        "stiffness": [[5,3,0,0],[3,5,0,0],[0,0,5,3],[0,0,3,5]]}}"#;
    fs::write(&file, text).expect("it can be written");
    let file = file.to_str().expect("a UTF-8 path");
    let out = directory.join("out");
    let path = out.to_str().expect("a UTF-8 path");
    let asked = ["campbell", file, "--speeds", "0:5:11", "--given-at", "100"];
    let json = printed(&[&asked[..], &["--json", "--out", path]].concat());
    let diagram: Value = serde_json::from_str(&json).expect("JSON");
    let keys = [
        "bounds", "complete", "followed", "speed", "orders", "critical", "branches",
    ];
    assert_keys(&json, &diagram, &keys);
    assert_eq!(
        (&diagram["bounds"], &diagram["complete"]),
        (&"proven".into(), &true.into())
    );
    let critical = diagram["critical"].as_array().expect("a list");
    let senses: Vec<&str> = critical
        .iter()
        .filter_map(|found| found["whirl"].as_str())
        .collect();
    assert_eq!(senses, ["backward", "forward", "backward"]);
    let [speed, bound] = ["speed", "bound"].map(|key| number(&critical[1][key]));
    assert!(
        (speed - 2.0).abs() <= bound && bound < 1e-14,
        "{speed} ± {bound}"
    );
    assert_eq!(diagram["branches"].as_array().map(Vec::len), Some(4));
    let mut found = listed(&out);
    found.sort();
    assert_eq!(
        found,
        [
            "campbell-rpm.svg",
            "campbell.csv",
            "campbell.json",
            "campbell.svg"
        ]
    );
    for name in ["campbell-rpm.svg", "campbell.svg"] {
        assert_well_formed(&fs::read_to_string(out.join(name)).expect("it was written"));
    }
    let csv = fs::read_to_string(out.join("campbell.csv")).expect("it was written");
    assert_eq!(csv.lines().count(), 12);
    let text = printed(&asked);
    assert!(
        text.contains("there are no others of these orders") && text.contains("19.09859"),
        "{text}"
    );
    for (speeds, wrong) in [("3,1", "speeds must rise"), ("0:1e300:3", "at 1e300 rad/s")] {
        let error = refused(&["campbell", file, "--speeds", speeds], 2);
        assert!(error.contains(wrong), "{error}");
    }
}

/// Values, bounds and times of a record with a single pulse, at as many frequencies as were asked for; files; places of faults.
#[test]
fn spectra_have_the_shape_that_was_agreed_on() {
    let directory = fresh("spectrum");
    fs::create_dir_all(&directory).expect("it can be made");
    let file = directory.join("quake.csv");
    fs::write(&file, "t,ax\n0,0\n0.1,2\n0.2,0\n").expect("it can be written");
    let file = file.to_str().expect("a UTF-8 path");
    let out = directory.join("out");
    let arguments = [
        "spectrum", file, "--step", "0.1", "--column", "ax", "--ratio", "0", "--from", "1e-3",
    ];
    let rest = [
        "--to",
        "1000",
        "--count",
        "7",
        "--json",
        "--out",
        out.to_str().expect("a UTF-8 path"),
    ];
    let json = printed(&[&arguments[..], &rest[..]].concat());
    let spectrum: Value = serde_json::from_str(&json).expect("JSON");
    let quantities = [
        "displacement",
        "pseudo_velocity",
        "pseudo_acceleration",
        "acceleration",
    ];
    let keys = [
        &["bounds", "ratio", "frequency"],
        &quantities[..],
        &["record"],
    ]
    .concat();
    assert_keys(&json, &spectrum, &keys);
    let frequencies = numbers(&spectrum["frequency"]);
    assert_eq!(
        (frequencies[0], frequencies[6], frequencies.len()),
        (1e-3, 1e3, 7)
    );
    for quantity in quantities {
        let [values, bounds, times] =
            ["value", "bound", "time"].map(|part| numbers(&spectrum[quantity][part]));
        assert_eq!([values.len(), bounds.len(), times.len()], [7; 3]);
        let pairs = bounds.iter().zip(&values);
        assert!(
            pairs
                .clone()
                .all(|(bound, value)| *bound <= 1.2e-16 * value),
            "{quantity}"
        );
    }
    // Without damping pseudo and absolute accelerations are the same; a soft system swings by ωv.
    assert_eq!(
        spectrum["acceleration"]["value"],
        spectrum["pseudo_acceleration"]["value"]
    );
    let soft = numbers(&spectrum["pseudo_velocity"]["value"])[0];
    assert!((soft - 0.2).abs() < 1e-6, "{soft}");
    assert_eq!(number(&spectrum["record"]["final_velocity"]), 0.2);
    let files = [
        "spectrum-acceleration.svg",
        "spectrum-displacement.svg",
        "spectrum-tripartite.svg",
        "spectrum.csv",
        "spectrum.json",
    ];
    let mut found = listed(&out);
    found.sort();
    assert_eq!(found, files);
    for name in &files[..3] {
        assert_well_formed(&fs::read_to_string(out.join(name)).expect("a plot"));
    }
    assert_eq!(
        fs::read_to_string(out.join("spectrum.csv"))
            .expect("rows")
            .lines()
            .count(),
        8
    );
    let table = printed(&[
        "spectrum",
        file,
        "--step",
        "0.1",
        "--column",
        "2",
        "--count",
        "3",
        "--precision",
        "double",
    ]);
    assert!(
        table.starts_with("Record: 0.200000 s, largest acceleration 2.00000 m/s²"),
        "{table}"
    );

    let error = refused(&["spectrum", file, "--step", "0.1", "--column", "ay"], 2);
    assert!(
        error.contains("quake.csv:1:1: there is no column named \"ay\""),
        "{error}"
    );
    refused(&["spectrum", file, "--step", "0.1"], 2);
    refused(&["spectrum", file, "--column", "ax"], 2);
    refused(
        &[
            "spectrum", file, "--step", "0.1", "--column", "ax", "--ratio", "-1",
        ],
        2,
    );
    refused(&["spectrum", "lost.csv", "--step", "0.1"], 2);
}

/// Two oscillators joined by a spring of 1e-6, of which the first is varied past the second; noise of 1 on it.
fn veering(name: &str) -> String {
    let folder = fresh(name);
    fs::create_dir_all(&folder).expect("it can be made");
    let file = folder.join("veering.json");
    let text = r#"{"masses": [{"name": "a", "mass": 1}, {"name": "b", "mass": 1}],
        "springs": [{"name": "soil", "between": ["ground", "a"], "stiffness": 1},
                    {"between": ["ground", "b"], "stiffness": 4}, {"between": ["a", "b"], "stiffness": 1e-6}]}"#;
    fs::write(&file, text).expect("it can be written");
    file.to_str().expect("a UTF-8 path").to_owned()
}

#[test]
fn a_sweep_follows_roots_and_its_parts_are_the_whole() {
    let scene = veering("sweep");
    let vary = [
        "--vary",
        "soil.stiffness=1,3,5,7",
        "--vary",
        "/masses/1/mass=1,1.01",
    ];
    let ask = |more: &[&str]| printed(&[&["sweep", &scene], &vary[..], &["--json"], more].concat());
    let whole = ask(&[]);
    let lines: Vec<Value> = whole
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    assert_eq!(lines.len(), 8);
    for (i, line) in lines.iter().enumerate() {
        let stiffness = [1.0, 3.0, 5.0, 7.0][i / 2];
        let mass = [1.0, 1.01][i % 2];
        assert_eq!(line["index"], i);
        assert_eq!(line["parameters"]["soil.stiffness"], stiffness);
        assert_eq!(line["parameters"]["/masses/1/mass"], mass);
        assert_eq!(line["metrics"], serde_json::json!({}));
        // The roots veer: the lower stays the lower, whatever its shape.
        let ends = [f64::sqrt(stiffness), f64::sqrt(4.0 / mass)];
        for (place, own) in [(0, ends[0].min(ends[1])), (2, ends[0].max(ends[1]))] {
            let im = line["eigenvalues"][place][1].as_f64().expect("a number");
            assert!((im - own).abs() < 1e-5, "{line}");
            assert_eq!(line["eigenvalues"][place + 1][1], -im);
        }
    }
    let parts = ["1/3", "2/3", "3/3"].map(|part| ask(&["--shard", part]));
    assert_eq!(parts.concat(), whole);
    let table = printed(&[&["sweep", &scene], &vary[..]].concat());
    assert_eq!(table.lines().count(), 9);
    let out = fresh("sweep-out");
    let place = out.to_str().expect("a UTF-8 path");
    ask(&["--out", place, "--metric", "damping"]);
    let csv = fs::read_to_string(out.join("sweep.csv")).expect("a table");
    assert_eq!(csv.lines().count(), 9);
    assert!(
        csv.starts_with("design,soil.stiffness,/masses/1/mass,damping,re 1,im 1,"),
        "{csv}"
    );
    for plot in ["metric-1.svg", "roots.svg"] {
        let plot = fs::read_to_string(out.join(plot)).expect("a plot");
        assert!(plot.starts_with("<svg"), "{plot}");
    }
    assert!(
        table.contains("soil.stiffness") && table.contains("  3.00000 "),
        "{table}"
    );
}

#[test]
fn metrics_of_a_sweep_are_those_of_closed_forms() {
    let folder = fresh("sweep-metrics");
    fs::create_dir_all(&folder).expect("it can be made");
    let file = folder.join("one.json");
    let text = r#"{"masses": [{"name": "m", "mass": 2}], "springs": [{"between": ["ground", "m"], "stiffness": 8}],
        "dampers": [{"name": "d", "between": ["ground", "m"], "damping": 1}], "noise": [{"on": "m", "force": 3}]}"#;
    fs::write(&file, text).expect("it can be written");
    let scene = file.to_str().expect("a UTF-8 path");
    let metrics = ["damping", "frequency 1", "gain m m", "rms m"];
    let mut arguments = vec!["sweep", scene, "--json", "--vary", "d.damping=0.5,1,2"];
    arguments.extend(metrics.iter().flat_map(|metric| ["--metric", *metric]));
    for precision in ["double", "certified"] {
        let printed = printed(&[&arguments[..], &["--precision", precision]].concat());
        for (line, c) in printed.lines().zip([0.5, 1.0, 2.0]) {
            let line: Value = serde_json::from_str(line).expect("JSON");
            let ratio = c / 8.0; // c / 2√(km)
            let gain = 1.0 / (8.0 * 2.0 * ratio * f64::sqrt(1.0 - ratio * ratio));
            let rms = f64::sqrt(3.0 / (4.0 * c * 8.0)); // one-sided density per Hz
            for (metric, right) in metrics.iter().zip([ratio, 2.0, gain, rms]) {
                let value = line["metrics"][metric].as_f64().expect("a number");
                assert!(
                    (value / right - 1.0).abs() < 1e-12,
                    "{metric}: {value} for {right}"
                );
            }
        }
    }
    // An error leaves nothing on standard output.
    let error = |more: &[&str]| refused(&[&["sweep", scene], more].concat(), 2);
    assert!(
        error(&["--vary", "d.damping=1,2", "--metric", "peak ground"])
            .contains("there is no output, mass or point \"ground\"")
    );
    assert!(error(&["--vary", "d.dampin=1:2:3"]).contains("did you mean \"d.damping\"?"));
    assert!(error(&["--vary", "d.damping=1:2"]).contains("is no range"));
    assert!(error(&["--vary", "/masses/1/mass=1,2"]).contains("no number"));
    let vary = ["--vary", "d.damping=1,2"];
    assert!(
        error(&[&vary[..], &["--vary", "/dampers/0/damping=1,2"]].concat())
            .contains("varies already")
    );
    assert!(error(&[&vary[..], &["--shard", "3/2"]].concat()).contains("i from 1 to N"));
    assert!(
        error(&[&vary[..], &["--metric", "peak m"]].concat())
            .contains("design 0 (d.damping = 1.0): peak m: the scene has no `time`")
    );
    assert!(
        error(&[&vary[..], &["--metric", "gain m wall"]].concat())
            .contains("design 0 (d.damping = 1.0): gain m wall")
    );
    assert!(error(&["--vary", "m.mass=-1,1"]).contains("design 0 (m.mass = -1.0): masses[0].mass"));
}

/// Parts of more than there are designs, the first of them empty, and one of as many as can be numbered.
#[test]
fn parts_without_designs_are_merged() {
    let scene = veering("empty-parts");
    let out = fresh("empty-parts-out");
    let place = out.to_str().expect("a UTF-8 path");
    let sweep = |part: &str| {
        let vary = ["--vary", "soil.stiffness=1,3", "--out", place];
        printed(&[&["sweep", &scene], &vary[..], &["--shard", part]].concat())
    };
    let lines: usize = ["1/3", "2/3", "3/3"]
        .map(|part| sweep(part).lines().count())
        .iter()
        .sum();
    assert_eq!(lines, 4); // two designs, each below a header
    assert!(printed(&["merge", place]).ends_with("sweep.csv: 2 designs\n"));
    let csv = fs::read_to_string(out.join("sweep.csv")).expect("a table");
    let starts: Vec<&str> = csv.lines().map(|line| &line[..2]).collect();
    assert_eq!(starts, ["de", "0,", "1,"]);
    fs::remove_dir_all(&out).expect("it can be removed");
    sweep("3/18446744073709551615");
    let error = refused(&["merge", place], 2);
    assert!(
        error.contains("of 18446744073709551615 parts these are missing: 1, 2, 4, 5, ")
            && error.contains("…"),
        "{error}"
    );
}

/// At the low end of a band the last mass of a chain moves by 1/Ω⁸ of what the first feels, and a mass that a stiff spring joins to
/// another is held by doubles to eight digits: gains are those of exact solutions.
#[test]
fn gains_of_a_sweep_have_all_their_digits() {
    let folder = fresh("sweep-gains");
    fs::create_dir_all(&folder).expect("it can be made");
    let file = folder.join("chain.json");
    let chain = r#"{"masses": [{"name": "m1", "mass": 4.54}, {"name": "m2", "mass": 0.5}, {"name": "m3", "mass": 0.12}, {"name": "m4", "mass": 2.0}],
        "springs": [{"name": "k0", "between": ["ground", "m1"], "stiffness": 3.0}, {"between": ["m1", "m2"], "stiffness": 0.16},
                    {"between": ["m2", "m3"], "stiffness": 0.04985}, {"between": ["m1", "m4"], "stiffness": 0.135}],
        "dampers": [{"between": ["m2", "m1"], "damping": 0.002461}, {"between": ["ground", "m2"], "damping": 0.01}]}"#;
    let stiff = r#"{"masses": [{"name": "m1", "mass": 0.24}, {"name": "m2", "mass": 8.92}, {"name": "m3", "mass": 5.0}],
        "points": [{"name": "p", "moves": {"m1": -1.2, "m2": -0.3}, "mass": 3.04}],
        "springs": [{"name": "k0", "between": ["ground", "m1"], "stiffness": 3.0}, {"between": ["ground", "m2"], "stiffness": 3.8234},
                    {"between": ["m1", "m3"], "stiffness": 541848762.9062144}]}"#;
    for (text, metric, right) in [
        (chain, "gain m3 m4 9.61:288.3", 2.795_564_610_380_524_4e-11),
        (stiff, "gain m1 m1 0.815:1.2225", 0.316_775_260_175_806_04),
    ] {
        fs::write(&file, text).expect("it can be written");
        let scene = file.to_str().expect("a UTF-8 path");
        let vary = ["--vary", "k0.stiffness=3", "--metric", metric];
        for precision in ["double", "certified"] {
            let more = ["--json", "--precision", precision];
            let line = parsed(&[&["sweep", scene], &vary[..], &more].concat());
            let gain = number(&line["metrics"][metric]);
            assert!((gain / right - 1.0).abs() < 1e-9, "{precision}: {line}");
        }
    }
}

/// A mass on a spring with an absorber of a twentieth of its mass, in units of so much mass, length and time; noise on it.
fn absorber(folder: &Path, name: &str, mass: f64, length: f64, time: f64) -> String {
    let file = folder.join(name);
    let (stiffness, damping) = (mass / time.powi(2), mass / time);
    let noise = (mass * length / time.powi(2)).powi(2) * time;
    let text = format!(
        r#"{{"masses": [{{"name": "m", "mass": {mass:?}}}, {{"name": "a", "mass": {:?}}}],
        "springs": [{{"between": ["ground", "m"], "stiffness": {stiffness:?}}},
                    {{"name": "absorber", "between": ["m", "a"], "stiffness": {:?}}}],
        "dampers": [{{"name": "d", "between": ["m", "a"], "damping": {:?}}}],
        "noise": [{{"on": "m", "force": {noise:?}}}]}}"#,
        0.05 * mass,
        0.04 * stiffness,
        0.01 * damping
    );
    fs::write(&file, text).expect("it can be written");
    file.to_str().expect("a UTF-8 path").to_owned()
}

#[test]
fn the_best_absorber_is_that_of_closed_forms_in_any_units() {
    let folder = fresh("optimise");
    fs::create_dir_all(&folder).expect("it can be made");
    let mu: f64 = 0.05;
    // H∞, exactly: Nishihara & Asami 2002. Frequency ratio and damping ratio of the absorber.
    let r = f64::sqrt(4.0 + 3.0 * mu);
    let many = 16.0 + 23.0 * mu + 9.0 * mu * mu + 2.0 * (2.0 + mu) * r;
    let ratio =
        2.0 / (1.0 + mu) * f64::sqrt(2.0 * many / (3.0 * (64.0 + 80.0 * mu + 27.0 * mu * mu)));
    let zeta = f64::sqrt((8.0 + 9.0 * mu - 4.0 * r) / (1.0 + mu)) / 4.0;
    // Den Hartog's fixed points are near.
    assert!((ratio - 0.95238).abs() < 1e-5 && (zeta - 0.1336).abs() < 5e-4);
    // H2 under a white force: Crandall & Mark 1963, Warburton 1982.
    let ratio_2 = f64::sqrt((2.0 + mu) / 2.0) / (1.0 + mu);
    let zeta_2 = f64::sqrt(mu * (4.0 + 3.0 * mu) / (8.0 * (1.0 + mu) * (2.0 + mu)));
    let closed = [("gain m m", ratio, zeta), ("rms m", ratio_2, zeta_2)];
    for (name, mass, length, time) in [
        ("si.json", 1.0, 1.0, 1.0),
        ("tonnes.json", 2.7e6, 1e3, 1.0),
        ("micro.json", 3e-9, 1e-6, 1e-5),
    ] {
        let scene = absorber(&folder, name, mass, length, time);
        let (k, c) = (mass / time.powi(2), mass / time);
        let stiffness = format!("absorber.stiffness={:?}:{:?}", 0.01 * k, 0.1 * k);
        let damping = format!("d.damping={:?}:{:?}", 0.001 * c, 0.1 * c);
        for (metric, ratio, zeta) in closed {
            let answer = printed(&[
                "optimise",
                &scene,
                "--vary",
                &stiffness,
                "--vary",
                &damping,
                "--minimise",
                metric,
                "--json",
            ]);
            let answer: Value = serde_json::from_str(&answer).expect("JSON");
            let number = |value: &Value| value.as_f64().expect("a number");
            let parameters = &answer["parameters"];
            let right = mu * ratio * ratio * k;
            let error = number(&parameters["absorber.stiffness"]) / right - 1.0;
            assert!(error.abs() < 1e-11, "{metric}: {answer}");
            let right = 2.0 * zeta * mu * ratio * c;
            let error = number(&parameters["d.damping"]) / right - 1.0;
            assert!(error.abs() < 1e-11, "{metric}: {answer}");
            let certificate = &answer["certificate"];
            assert_eq!(certificate["local_optimum"], true, "{answer}");
            assert!(number(&certificate["curvature"]) > 0.0);
            assert_eq!(answer["metric"]["name"], metric);
            if metric == "gain m m" {
                assert_eq!(certificate["active"].as_array().map(Vec::len), Some(2));
                assert!(number(&certificate["spread"]) < 1e-12);
                let (r, mu) = (r, mu);
                let square = (8.0 + 9.0 * mu).powi(2) * (16.0 + 9.0 * mu) - 128.0 * r.powi(3);
                let right =
                    f64::sqrt(square) / (3.0 * mu * f64::sqrt(32.0 + 27.0 * mu) * 3.0f64.sqrt());
                let error = number(&answer["metric"]["value"]) * k / right - 1.0;
                assert!(error.abs() < 1e-11, "{right} {answer}");
            }
        }
    }
}

/// The gain of one mass is 1/(c √(1 − c²/4)) below c = √2 and 1 from there on: between 0 and 100 nearly all values are of the second
/// kind.
#[test]
fn limits_from_0_are_searched_near_0_too() {
    let folder = fresh("optimise-from-0");
    fs::create_dir_all(&folder).expect("it can be made");
    let file = folder.join("one.json");
    let text = r#"{"masses": [{"name": "m", "mass": 1}], "springs": [{"between": ["ground", "m"], "stiffness": 1}],
        "dampers": [{"name": "c", "between": ["ground", "m"], "damping": 10}]}"#;
    fs::write(&file, text).expect("it can be written");
    let file = file.to_str().expect("a UTF-8 path");
    let asked = [
        "optimise",
        file,
        "--vary",
        "c.damping=0:100",
        "--maximise",
        "gain m m",
        "--json",
    ];
    let answer = parsed(&asked);
    assert!(
        answer["metric"]["value"].as_f64().expect("a gain") > 10.0,
        "{answer}"
    );
    assert_eq!(answer["certificate"]["constant"], false, "{answer}");
}

#[test]
fn what_cannot_be_optimised_is_refused() {
    let folder = fresh("optimise-refused");
    fs::create_dir_all(&folder).expect("it can be made");
    let scene = absorber(&folder, "si.json", 1.0, 1.0, 1.0);
    let error = |more: &[&str]| refused(&[&["optimise", &scene], more].concat(), 2);
    let gain = ["--minimise", "gain m m"];
    let with = |vary: &str| error(&[&["--vary", vary], &gain[..]].concat());
    for vary in [
        "d.damping=1:1",
        "d.damping=2:1",
        "d.damping=nan:1",
        "d.damping=1",
        "d.damping=-1e308:1e308",
    ] {
        assert!(with(vary).contains("write PATH=lo:hi"), "{vary}");
    }
    assert!(with("d.dampin=1:2").contains("did you mean \"d.damping\"?"));
    assert!(with("a.mass=-2:-1").contains("masses[1].mass"));
    let vary = ["--vary", "d.damping=0.001:0.1"];
    assert!(error(&vary).contains("--minimise"));
    let both = ["--minimise", "damping", "--maximise", "damping"];
    error(&[&vary[..], &both].concat());
    let metric = |metric: &str| error(&[&vary[..], &["--minimise", metric]].concat());
    assert!(metric("weight").contains("metrics are"));
    assert!(metric("gain m wall").contains("wall"));
    assert!(metric("peak m").contains("no `time`"));
    assert!(metric("frequency 9").contains("only 2 modes"));
    let nine: Vec<String> = (0..9).map(|i| format!("/x{i}=1:2")).collect();
    let nine: Vec<&str> = nine.iter().flat_map(|vary| ["--vary", vary]).collect();
    assert!(error(&[&nine[..], &gain].concat()).contains("no number"));
}

#[test]
fn peaks_and_settling_of_a_sweep_lie_between_the_samples() {
    let folder = fresh("sweep-motion");
    fs::create_dir_all(&folder).expect("it can be made");
    let file = folder.join("step.json");
    let text = r#"{"masses": [{"name": "m", "mass": 1}], "springs": [{"name": "s", "between": ["ground", "m"], "stiffness": 4}],
        "dampers": [{"name": "d", "between": ["ground", "m"], "damping": 0.4}], "loads": [{"on": "m", "step": {"force": 8}}],
        "outputs": [{"name": "pull", "force": "s"}], "time": {"end": 60, "step": 0.7}}"#;
    fs::write(&file, text).expect("it can be written");
    let scene = file.to_str().expect("a UTF-8 path");
    let lines = printed(&[
        "sweep",
        scene,
        "--json",
        "--vary",
        "d.damping=0.4,1,2",
        "--metric",
        "peak m",
        "--metric",
        "peak pull",
        "--metric",
        "settling m",
    ]);
    for (line, c) in lines.lines().zip([0.4, 1.0, 2.0]) {
        let line: Value = serde_json::from_str(line).expect("JSON");
        let zeta: f64 = c / 4.0;
        let over = 1.0 + f64::exp(-std::f64::consts::PI * zeta / f64::sqrt(1.0 - zeta * zeta));
        let value = |metric: &str| line["metrics"][metric].as_f64().expect("a number");
        assert!(
            (value("peak m") / (2.0 * over) - 1.0).abs() < 1e-11,
            "{line}"
        );
        assert!(
            (value("peak pull") / (8.0 * over) - 1.0).abs() < 1e-11,
            "{line}"
        );
        // At the last instant outside, the deviation is 2 % of the largest.
        let (decay, turn) = (zeta * 2.0, 2.0 * f64::sqrt(1.0 - zeta * zeta));
        let t = value("settling m");
        let left = f64::exp(-decay * t) * (f64::cos(turn * t) + decay / turn * f64::sin(turn * t));
        assert!((left.abs() - 0.02).abs() < 1e-8, "{line}: {left}");
    }
    let error = |metric: &str| {
        refused(
            &[
                "sweep",
                scene,
                "--vary",
                "d.damping=1,2",
                "--metric",
                metric,
            ],
            2,
        )
    };
    assert!(error("peak wall").contains("wall"));
    // Without the spring it drifts, which is said.
    let drifting = text.replace(r#""stiffness": 4"#, r#""stiffness": 0"#);
    fs::write(&file, drifting).expect("it can be written");
    let asked = ["--vary", "d.damping=0.4,1,2", "--metric", "settling m"];
    let output = eigentone(&[&["sweep", scene, "--json"], &asked[..]].concat());
    let lines = String::from_utf8_lossy(&output.stdout);
    assert_eq!(lines.matches(r#""settling m": null"#).count(), 3, "{lines}");
    let note = String::from_utf8_lossy(&output.stderr);
    assert!(
        note.contains("settling m: no value in 3 of 3 designs, where it drifts"),
        "{note}"
    );
    let vary = ["--vary", "d.damping=0.4:2", "--minimise", "settling m"];
    let error_of_drift = refused(&[&["optimise", scene], &vary[..]].concat(), 2);
    assert!(
        error_of_drift.contains("limits: it drifts"),
        "{error_of_drift}"
    );
    fs::write(&file, text).expect("it can be written");
    assert!(error("settling mm").contains("there is no output, mass or point"));
}

/// A mass on a base that is moved by 1 at once; its names have spaces.
#[test]
fn names_in_metrics_may_have_spaces_and_outputs_settle() {
    let folder = fresh("sweep-spaces");
    fs::create_dir_all(&folder).expect("it can be made");
    let file = folder.join("base.json");
    let text = r#"{"masses": [{"name": "front axle", "mass": 1}, {"name": "idle", "mass": 1}], "supports": ["the base"],
        "springs": [{"name": "s", "between": ["the base", "front axle"], "stiffness": 4}, {"between": ["ground", "idle"], "stiffness": 1}],
        "dampers": [{"name": "d", "between": ["ground", "front axle"], "damping": 0.8}, {"between": ["ground", "idle"], "damping": 1}],
        "points": [{"name": "twice", "moves": {"front axle": 2}}],
        "motions": [{"of": "the base", "displacement": {"step": {"height": 1}}}],
        "outputs": [{"name": "its travel", "displacement": {"front axle": 1, "the base": -1}},
                    {"name": "its speed", "velocity": {"front axle": 1}}, {"name": "a pull", "force": "s"}],
        "noise": [{"on": "front axle", "force": 1}], "time": {"end": 30, "step": 0.3}}"#;
    fs::write(&file, text).expect("it can be written");
    let scene = file.to_str().expect("a UTF-8 path");
    let ask = |metrics: &[&str]| {
        let metrics = metrics.iter().flat_map(|metric| ["--metric", *metric]);
        let start = ["sweep", scene, "--json", "--vary", "s.stiffness=4"];
        let arguments: Vec<&str> = start.into_iter().chain(metrics).collect();
        let line = parsed(&arguments);
        move |metric: &str| number(&line["metrics"][metric])
    };
    let value = ask(&[
        "peak front axle",
        "rms front axle",
        "settling front axle",
        "settling twice",
        "settling its travel",
        "settling a pull",
        "settling its speed",
        "settling idle",
        "gain the base front axle",
        "gain front axle its travel 1:3",
        "gain the base a pull",
    ]);
    let (zeta, omega): (f64, f64) = (0.2, 2.0);
    let root = f64::sqrt(1.0 - zeta * zeta);
    let (decay, turn) = (zeta * omega, omega * root);
    let over = 1.0 + f64::exp(-std::f64::consts::PI * zeta / root);
    assert!((value("peak front axle") / over - 1.0).abs() < 1e-11);
    assert!((value("rms front axle") / f64::sqrt(1.0 / (4.0 * 0.8 * 4.0)) - 1.0).abs() < 1e-12);
    // The displacement, twice it, its difference from the base and the pull of the spring settle at one time.
    let t = value("settling front axle");
    let left = f64::exp(-decay * t) * (f64::cos(turn * t) + decay / turn * f64::sin(turn * t));
    assert!((left.abs() - 0.02).abs() < 1e-8, "{left}");
    for other in ["settling twice", "settling its travel", "settling a pull"] {
        assert!((value(other) / t - 1.0).abs() < 1e-8, "{other}");
    }
    let speed = |t: f64| f64::exp(-decay * t) * f64::sin(turn * t);
    let fastest = speed(f64::acos(zeta) / turn);
    let t = value("settling its speed");
    assert!((speed(t).abs() / fastest - 0.02).abs() < 1e-8, "{t}");
    // What never moves is settled from the start.
    assert_eq!(value("settling idle"), 0.0);
    let peak = 1.0 / (2.0 * zeta * root);
    assert!((value("gain the base front axle") / peak - 1.0).abs() < 1e-12);
    assert!((value("gain front axle its travel 1:3") * 4.0 / peak - 1.0).abs() < 1e-12);
    assert!(value("gain the base a pull") > 4.0);
    let error = |metric: &str| {
        let vary = ["--vary", "s.stiffness=4", "--metric", metric];
        refused(&[&["sweep", scene], &vary[..]].concat(), 2)
    };
    assert!(error("gain front axle wall").contains("no two names of the scene"));
    assert!(error("gain idle twice 3").contains("write the frequencies of a gain"));
    assert!(error("peak front axl").contains("did you mean \"front axle\"?"));
    assert!(error("settling").contains("metrics are"));
}

/// What is infinite in one design, or not there, is no number, and does not end the sweep.
#[test]
fn designs_without_a_value_have_none() {
    let folder = fresh("sweep-null");
    fs::create_dir_all(&folder).expect("it can be made");
    let file = folder.join("one.json");
    let text = r#"{"masses": [{"name": "m", "mass": 1}], "springs": [{"name": "s", "between": ["ground", "m"], "stiffness": 1}],
        "dampers": [{"name": "d", "between": ["ground", "m"], "damping": 1}], "noise": [{"on": "m", "force": 1}]}"#;
    fs::write(&file, text).expect("it can be written");
    let scene = file.to_str().expect("a UTF-8 path");
    let metrics_of = |vary: &str, metrics: &[&str]| -> Vec<Vec<Option<f64>>> {
        let asked = metrics.iter().flat_map(|metric| ["--metric", *metric]);
        let start = ["sweep", scene, "--json", "--vary", vary];
        let output = eigentone(&start.into_iter().chain(asked).collect::<Vec<_>>());
        assert!(output.status.success(), "{output:?}");
        let line = |line: &str| -> Vec<Option<f64>> {
            let line: Value = serde_json::from_str(line).expect("JSON");
            let metrics = metrics.iter();
            metrics.map(|name| line["metrics"][name].as_f64()).collect()
        };
        let text = String::from_utf8_lossy(&output.stdout);
        let all: Vec<Vec<Option<f64>>> = text.lines().map(line).collect();
        // Each metric that some have not is named, with their number.
        let notes = metrics.iter().enumerate().filter_map(|(k, name)| {
            let missing = all.iter().filter(|one| one[k].is_none()).count();
            let count = all.len();
            let note = format!("{name}: no value in {missing} of {count} designs, where ");
            (missing > 0).then_some(note)
        });
        let notes: Vec<String> = notes.collect();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(said.lines().count(), notes.len(), "{said}");
        assert!(notes.iter().all(|note| said.contains(note)), "{said}");
        all
    };
    let all = metrics_of("d.damping=-1,0,1", &["rms m", "gain m m", "damping"]);
    assert_eq!(all[0], [None, None, Some(-0.5)]);
    assert_eq!(all[1][..2], [None, None]);
    // A frequency response of what grows is none, small as it would be.
    let vary = [
        "--vary",
        "d.damping=-5:0.5",
        "--minimise",
        "gain m m",
        "--json",
    ];
    let best = parsed(&[&["optimise", scene], &vary[..]].concat());
    assert_eq!(number(&best["parameters"]["d.damping"]), 0.5, "{best}");
    assert!((all[2][0].expect("a value") - 0.5).abs() < 1e-12);
    // Beyond critical damping there is a second mode.
    let all = metrics_of("d.damping=1,3", &["frequency 1", "frequency 2"]);
    assert_eq!(all[0], [Some(1.0), None]);
    let slow = (3.0 - f64::sqrt(5.0)) / 2.0;
    for (found, right) in all[1].iter().zip([slow, 1.0 / slow]) {
        assert!((found.expect("a value") / right - 1.0).abs() < 1e-14);
    }
    let vary = ["--vary", "d.damping=1,3", "--metric", "frequency 3"];
    let error = refused(&[&["sweep", scene], &vary[..]].concat(), 2);
    assert!(error.contains("there is only 1 mode"), "{error}");
    let error = refused(&["merge", "no-such-directory"], 2);
    assert!(error.contains("cannot be read"), "{error}");
}

/// What it prints when this is on standard input, once it has ended well.
fn piped(arguments: &[&str], input: &str) -> String {
    let mut child = Command::new(env!("CARGO_BIN_EXE_eigentone"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary runs");
    let mut stdin = child.stdin.take().expect("piped");
    // Who refuses its arguments reads nothing.
    let _ = stdin.write_all(input.as_bytes());
    drop(stdin);
    let output = child.wait_with_output().expect("it ends");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {error}");
    String::from_utf8(output.stdout).expect("UTF-8")
}

#[test]
fn a_scene_may_come_on_standard_input() {
    let file = scene("three-mass-1");
    let text = fs::read_to_string(&file).expect("a scene");
    let commands: [&[&str]; 7] = [
        &["modes"],
        &["modes", "--json"],
        &["response", "--json", "--steps", "0,7"],
        &["analyze"],
        &["frf", "--from", "m1", "--at", "1,2"],
        &["export", "--json"],
        &["sweep", "--json", "--vary", "/springs/0/stiffness=1:2:3"],
    ];
    for command in commands {
        let with = |scene| [&command[..1], &[scene], &command[1..]].concat();
        assert_eq!(
            piped(&with("-"), &text),
            printed(&with(&file)),
            "{command:?}"
        );
    }
    let mut refusing = Command::new(env!("CARGO_BIN_EXE_eigentone"));
    let refusing = refusing.args(["modes", "-"]).stdin(Stdio::null());
    let output = refusing.output().expect("the binary runs");
    assert_eq!(output.status.code(), Some(2));
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(error.starts_with("error: <stdin>: is empty"), "{error}");
}

#[test]
fn frequencies_take_units() {
    let file = scene("three-mass-1");
    let near = |arguments: &[&str]| {
        let all = [
            &["modes", &file, "--count", "1", "--json", "--near"],
            arguments,
        ]
        .concat();
        numbers_of(&parsed(&all)["modes"], "natural_frequency")
    };
    let second = near(&["1.13"]);
    assert_eq!(near(&["0.18Hz"]), second);
    assert_eq!(near(&["0.18", "--hz"]), second);
    assert_eq!(near(&["1.13rad/s", "--hz"]), second);
    let at = |arguments: &[&str]| {
        let all = [&["frf", &file, "--from", "m1", "--json", "--at"], arguments].concat();
        numbers(&parsed(&all)["frequency"])
    };
    let tau = std::f64::consts::TAU;
    assert_eq!(at(&["1Hz,2"]), [tau, 2.0]);
    assert_eq!(at(&["1,2rad/s", "--hz"]), [tau, 2.0]);
}

fn numbers_of(list: &Value, key: &str) -> Vec<f64> {
    let list = list.as_array().expect("a list");
    list.iter().map(|entry| number(&entry[key])).collect()
}

#[test]
fn tables_come_as_comma_separated_values() {
    let file = scene("three-mass-1");
    let commands: [(&[&str], usize); 3] = [
        (&["modes", &file], 3),
        (&["response", &file, "--steps", "0,1,2,3"], 4),
        (
            &["frf", &file, "--from", "m1", "--to", "m2", "--at", "1,2,3"],
            3,
        ),
    ];
    for (command, rows) in commands {
        let text = printed(&[command, &["--csv"]].concat());
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), rows + 1, "{text}");
        let columns = lines[0].split(',').count();
        assert!(lines[0].contains('[') && columns > 3, "{text}");
        assert!(
            lines.iter().all(|line| line.split(',').count() == columns),
            "{text}"
        );
    }
    refused(&["modes", &file, "--csv", "--json"], 2);
}

#[test]
fn new_scenes_are_answered_without_a_note() {
    for kind in ["quarter-car", "building", "absorber", "chain", "rotor"] {
        let text = printed(&["new", kind]);
        let analysis = piped(&["analyze", "-"], &text);
        assert!(analysis.contains("\nBounds\n  modes proven"), "{analysis}");
        assert!(analysis.contains("response proven"), "{analysis}");
        piped(&["frf", "-"], &text);
        let scene: Value = serde_json::from_str(&text).expect("JSON");
        assert!(scene["$schema"].is_string() && scene["title"].is_string());
    }
    assert!(refused(&["new", "quarter-cart"], 2).contains("quarter-car"));
}

#[test]
fn the_gallery_is_listed_and_printed() {
    let list = printed(&["scenes"]);
    let all = || cases().iter().chain(eigentone::gallery::machines());
    assert_eq!(list.lines().count(), all().count());
    for (line, case) in list.lines().zip(all()) {
        assert!(line.starts_with(case.name()), "{line}");
    }
    for case in all() {
        assert_eq!(printed(&["scenes", case.name()]), case.scene_text());
    }
    let schema =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/scene.schema.json"));
    assert_eq!(
        printed(&["scenes", "--schema"]),
        schema.expect("it is there")
    );
    let error = refused(&["scenes", "three-mas-1"], 2);
    assert!(error.contains("did you mean \"three-mass-1\"?"), "{error}");
}

#[test]
fn shells_and_man_know_every_command() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let text = printed(&["completions", shell]);
        assert!(
            text.contains("frf") && text.contains("precision"),
            "{shell}"
        );
    }
    let page = printed(&["man"]);
    for command in ["analyze", "frf", "spectrum", "sweep"] {
        assert!(
            page.contains(&format!(".TH eigentone-{command} ")),
            "{command}"
        );
    }
}

#[test]
fn near_names_are_suggested() {
    let file = scene("three-mass-1");
    let cases: [(&[&str], &str); 6] = [
        (
            &["frf", &file, "--from", "m11"],
            "--from \"m11\" is no name of the scene: did you mean \"m1\"?",
        ),
        (
            &["frf", &file, "--to", "x"],
            "known are \"m1\", \"m2\" and \"m3\"",
        ),
        (&["export", &file, "--to", "m33"], "did you mean \"m3\"?"),
        (
            &["check", &file, "--methods", "newmork"],
            "did you mean \"Newmark\"?",
        ),
        (&["anlyze", &file], "'analyze'"),
        (&["frf", &file, "--form", "m1"], "'--from'"),
    ];
    for (arguments, message) in cases {
        let error = refused(arguments, 2);
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn a_check_of_some_methods_prints_json() {
    let file = scene("one-mass-critical");
    let all = ["check", &file, "--json", "--methods", "exponential,newmark"];
    let answer = parsed(&all);
    let rows = answer["response"]["methods"].as_array();
    let rows = rows.unwrap_or_else(|| panic!("{answer}"));
    let methods: Vec<&str> = rows
        .iter()
        .filter_map(|row| row["method"].as_str())
        .collect();
    assert!(
        methods.contains(&"exponential") && methods.contains(&"Newmark"),
        "{methods:?}"
    );
    assert!(
        !methods.contains(&"DOP853") && !methods.contains(&"superposition"),
        "{methods:?}"
    );
}

#[test]
fn a_check_says_of_integrators_that_they_are_unstable() {
    let text = r#"{ "masses": [{"name": "m", "mass": 1}],
                    "springs": [{"between": ["ground", "m"], "stiffness": 1e6}],
                    "initial": {"m": {"displacement": 1}}, "time": {"end": 40, "step": 0.1} }"#;
    let table = piped(&["check", "-"], text);
    assert!(
        table.contains("it is unstable with steps as long as these"),
        "{table}"
    );
    assert!(!table.contains("it grows too fast"), "{table}");
}

#[test]
fn an_analysis_shows_shapes_and_forces_and_explains_itself_when_asked() {
    let text = r#"{ "masses": [{"name": "m", "mass": 1}],
                    "springs": [{"between": ["ground", "m"], "stiffness": 4}],
                    "initial": {"m": {"displacement": 1}}, "time": {"end": 1.5, "step": 0.5} }"#;
    let short = piped(&["analyze", "-"], text);
    let line = "\nPlan\n  modes by spring factor; response by certified exponential (--explain says why)\n";
    assert!(short.contains(line), "{short}");
    assert!(!short.contains("left out"), "{short}");
    assert!(
        short.contains("\nShapes\n  mass        1\n  m     1.00000\n"),
        "{short}"
    );
    let row = |start: &str| -> Vec<&str> {
        let found = short
            .lines()
            .find(|line| line.trim_start().starts_with(start));
        let found = found.unwrap_or_else(|| panic!("{start}: {short}"));
        found.trim_start()[start.len()..]
            .split_whitespace()
            .collect()
    };
    // x = cos 2t: the acceleration is −4 cos 2t, the tension 4 cos 2t.
    assert_eq!(
        row("acceleration m")[..3],
        ["m/s²", "−4.00000", "0"],
        "{short}"
    );
    assert_eq!(
        row("spring ground–m")[..3],
        ["N", "4.00000", "0"],
        "{short}"
    );
    let long = piped(&["analyze", "-", "--explain"], text);
    assert!(
        long.contains("\n  left out symmetric eigenproblem: "),
        "{long}"
    );
    let but_plan = |text: &str| {
        let (before, rest) = text.split_once("\nPlan\n").expect("a plan");
        let (_, after) = rest.split_once("\nModes\n").expect("modes");
        format!("{before}{after}")
    };
    assert_eq!(but_plan(&short), but_plan(&long));
}

/// By what they join, points among it; elements that join the same have their numbers too.
#[test]
fn forces_have_the_names_of_what_their_springs_join() {
    let text = r#"{ "masses": [{"name": "heave", "mass": 900}, {"name": "pitch", "mass": 1300, "unit": "rad"}],
                    "points": [{"name": "front", "moves": {"heave": 1, "pitch": -1}},
                               {"name": "rear", "moves": {"heave": 1, "pitch": 1}}, {"name": "low", "moves": {"heave": 1}}],
                    "springs": [{"between": ["ground", "front"], "stiffness": 20000},
                                {"between": ["ground", "rear"], "stiffness": 22000},
                                {"between": ["ground", "low"], "stiffness": 10},
                                {"between": ["low", "ground"], "stiffness": 10},
                                {"between": ["ground", "low"], "stiffness": 20}],
                    "dampers": [{"between": ["ground", "rear"], "damping": 5, "name": "strut"}],
                    "initial": {"heave": {"displacement": 0.1}}, "time": {"end": 1, "step": 0.5} }"#;
    let short = piped(&["analyze", "-"], text);
    let rows = short.lines().map(str::trim_start);
    let rows = rows.filter(|line| line.starts_with("spring ") || line.starts_with("damper "));
    let names: Vec<&str> = rows
        .filter_map(|line| line.split_once("  ").map(|(name, _)| name))
        .collect();
    let wanted = [
        "spring ground–front",
        "spring ground–rear",
        "spring ground–low (2)",
        "spring low–ground",
        "spring ground–low (4)",
        "damper strut",
    ];
    assert_eq!(names, wanted, "{short}");
}

/// A force of 1e312 N cannot be shown, the motion can: what is left out of an analysis is said.
#[test]
fn what_cannot_be_shown_is_left_out_with_a_word() {
    let folder = fresh("too-strong");
    fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("strong.json");
    let text = r#"{"masses": [{"name": "m", "mass": 1e10}],
            "springs": [{"between": ["ground", "m"], "stiffness": 1e300}],
            "initial": {"m": {"displacement": 1e12}},
            "time": {"step": 1e-146, "end": 1e-145}}"#;
    fs::write(&file, text).expect("it can be written");
    let out = folder.join("out");
    let [file, into] = [&file, &out].map(|path| path.to_str().expect("a UTF-8 path"));
    let output = eigentone(&["analyze", file, "--out", into]);
    assert!(output.status.success());
    let notes = String::from_utf8(output.stderr).expect("UTF-8");
    for what in ["accelerations and forces", "energies"] {
        let note = format!("{what} are left out: ");
        assert!(notes.contains(&note), "{notes}");
    }
    for name in ["accelerations.csv", "forces.csv", "energy.csv"] {
        assert!(!out.join(name).exists(), "{name}");
    }
}

/// The peaks of a ball that is thrown against a ceiling lie between the samples, and the plots say when it hits.
#[test]
fn motions_with_switches_are_analysed_between_the_samples() {
    let folder = fresh("switched");
    fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("ball.json");
    let text = r#"{"masses": [{"name": "ball", "mass": 2}],
            "initial": {"ball": {"velocity": 3}},
            "loads": [{"on": "ball", "step": {"force": 4}}],
            "frictions": [{"between": ["ground", "ball"], "force": 1}],
            "impacts": [{"between": ["ground", "ball"], "gap": 0.5, "restitution": 0.5}],
            "time": {"end": 0.25, "step": 0.125}}"#;
    fs::write(&file, text).expect("it can be written");
    let out = folder.join("out");
    let [file, into] = [&file, &out].map(|path| path.to_str().expect("a UTF-8 path"));
    let output = eigentone(&["analyze", file, "--out", into]);
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    // 3 t + 0.75 t² = 0.5 at the ceiling.
    let impact = (10.5f64.sqrt() - 3.0) / 1.5;
    let mut lines = text
        .lines()
        .map(|line| line.split_whitespace().collect::<Vec<_>>());
    assert!(
        lines.any(|line| line == ["ball", "0.500000", "0.160247"]),
        "{text}"
    );
    let peaks = fs::read_to_string(out.join("peaks.csv")).expect("it was written");
    let row = |label: &str| -> Vec<f64> {
        let row = peaks
            .lines()
            .find(|line| line.starts_with(label))
            .expect("a row");
        row.split(',')
            .filter_map(|cell| cell.parse().ok())
            .collect()
    };
    assert_eq!(row("acceleration ball")[0], 2.5);
    let friction = row("frictions[0]");
    assert!(friction[0] == 1.0 && (friction[1] - impact).abs() < 1e-12 && friction[3] == -1.0);
    let forces = fs::read_to_string(out.join("forces.csv")).expect("it was written");
    assert!(
        forces.starts_with("step,time [s],frictions[0] [N],impacts[0] [N],bound frictions[0]"),
        "{forces}"
    );
    for name in [
        "displacement.svg",
        "velocity.svg",
        "forces.svg",
        "acceleration.svg",
    ] {
        assert_well_formed(&fs::read_to_string(out.join(name)).expect("it was written"));
    }
    let plot = fs::read_to_string(out.join("velocity.svg")).expect("it was written");
    assert!(plot.contains(">impacts[0]<"), "{plot}");
}

/// A block on a belt: its cycle, and the scene that starts on it and comes back.
#[test]
fn the_cycle_of_a_block_on_a_belt_repeats_itself() {
    let scene = r#"{"masses": [{"name": "block", "mass": 1}], "supports": ["belt"],
            "motions": [{"of": "belt", "displacement": {"ramp": {"rate": 0.5}}}],
            "springs": [{"between": ["ground", "block"], "stiffness": 100}],
            "frictions": [{"between": ["belt", "block"], "force": 3, "static": 5}],
            "initial": {"block": {"velocity": 0.5}},
            "time": {"end": 4, "step": 0.01}}"#;
    let text = piped(&["cycle", "-"], scene);
    assert!(text.contains("\nstable: "), "{text}");
    let json: Value = serde_json::from_str(&piped(&["cycle", "-", "--json"], scene)).expect("JSON");
    let period = json["period"].as_f64().expect("a number");
    let slip = 2.0 * (std::f64::consts::PI - 0.4f64.atan()) / 10.0;
    assert!((period - slip - 0.08).abs() < 1e-15, "{period}");
    assert_eq!(json["stable"], true);
    assert_eq!(json["events"].as_array().expect("a list").len(), 2);
    let csv = piped(&["cycle", "-", "--csv"], scene);
    assert_eq!(csv.lines().count(), 2);
    let started = piped(&["cycle", "-", "--as-scene"], scene);
    let motion: Value =
        serde_json::from_str(&piped(&["response", "-", "--json"], &started)).expect("JSON");
    let x = motion["displacement"]["block"].as_array().expect("a list");
    let x: Vec<f64> = x.iter().filter_map(Value::as_f64).collect();
    assert_eq!(x.len(), 257);
    assert!((x[0] - x[256]).abs() < 1e-12 && (x[0] - x[100]).abs() > 1e-3);
    let error = refused(&["cycle", "tests/gallery/scenes/two-mass-free.json"], 2);
    assert!(error.contains("nothing switches"), "{error}");
    // Of a frequency 0, nothing repeats itself; such a motion would be followed for long.
    let file = fresh("cycle-of-none").with_extension("json");
    let swings = r#"{"masses": [{"name": "m", "mass": 1}], "springs": [{"between": ["ground", "m"], "stiffness": 1e6}],
        "loads": [{"on": "m", "harmonic": {"amplitude": 1, "frequency": 0, "phase": 1}}],
        "initial": {"m": {"displacement": 1}}, "time": {"end": 1e6, "step": 1e3}}"#;
    fs::write(&file, swings).expect("it can be written");
    let error = refused(&["cycle", file.to_str().expect("UTF-8")], 2);
    assert!(error.contains("nothing switches"), "{error}");
}

/// What is said of switches that an answer leaves out is no second message beside an error.
#[test]
fn noise_that_is_missing_is_one_message() {
    let text = r#"{"masses": [{"name": "m", "mass": 1}], "springs": [{"between": ["ground", "m"], "stiffness": 4}],
        "dampers": [{"between": ["ground", "m"], "damping": 1}], "frictions": [{"between": ["ground", "m"], "force": 2}]"#;
    let file = fresh("no-noise").with_extension("json");
    fs::write(&file, format!("{text}}}")).expect("it can be written");
    let path = file.to_str().expect("UTF-8");
    let error = refused(&["random", path], 2);
    assert_eq!(error.lines().count(), 1, "{error}");
    let noise = r#", "noise": [{"on": "m", "force": 1}]}"#;
    fs::write(&file, format!("{text}{noise}")).expect("it can be written");
    let output = eigentone(&["random", path]);
    assert!(output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).starts_with("note: "));
}

/// 1e5 designs in eight parts, of which two are killed and go on: the whole is that of one run, to the byte.
#[test]
fn a_sweep_in_parts_that_were_killed_is_that_of_one_run() {
    let scene = veering("sweep-killed");
    let whole = fresh("sweep-whole");
    let parts = fresh("sweep-parts");
    let [whole, parts] = [&whole, &parts].map(|path| path.to_str().expect("a UTF-8 path"));
    let arguments = |more: &[&str]| -> Vec<String> {
        let vary = ["soil.stiffness=1:7:100", "/masses/1/mass=1:1.5:1000"];
        let start = ["sweep", &scene, "--vary", vary[0], "--vary", vary[1]];
        let all = start.iter().chain(&["--metric", "damping"]).chain(more);
        all.map(|text| (*text).to_owned()).collect()
    };
    let run = |more: &[&str]| {
        let arguments = arguments(more);
        let output = eigentone(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
        assert!(output.status.success(), "{output:?}");
        output
    };
    run(&["--out", whole]);
    let part = |i: u32| format!("{i}/8");
    for i in (1..=8).filter(|i| ![3, 6].contains(i)) {
        run(&["--out", parts, "--shard", &part(i)]);
    }
    for i in [3, 6] {
        let growing = Path::new(parts).join(format!("sweep.{i}-of-8.csv.part"));
        let mut child = Command::new(env!("CARGO_BIN_EXE_eigentone"))
            .args(arguments(&["--out", parts, "--shard", &part(i)]))
            .stdout(Stdio::null())
            .spawn()
            .expect("the binary runs");
        while fs::metadata(&growing).map_or(0, |file| file.len()) < 10_000 {
            let ended = child.try_wait().expect("a child");
            assert!(ended.is_none(), "it was to be killed");
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        child.kill().expect("it runs");
        child.wait().expect("it ended");
        assert!(growing.exists());
    }
    let error = refused(&["merge", parts], 2);
    assert!(
        error.contains("3 (not complete: --resume goes on), 6 (not complete"),
        "{error}"
    );
    let other = arguments(&["--out", parts, "--shard", "3/8", "--resume"]);
    let other: Vec<&str> = other
        .iter()
        .map(|text| match text.as_str() {
            "soil.stiffness=1:7:100" => "soil.stiffness=1:8:100",
            text => text,
        })
        .collect();
    let error = refused(&other, 2);
    assert!(error.contains("another \"vary\""), "{error}");
    for i in [3, 6] {
        run(&["--out", parts, "--shard", &part(i), "--resume"]);
    }
    let again = run(&["--out", parts, "--shard", "3/8", "--resume"]);
    assert!(again.stdout.is_empty());
    assert!(String::from_utf8_lossy(&again.stderr).contains("complete already"));
    let printed_text = printed(&["merge", parts]);
    assert!(
        printed_text.ends_with("sweep.csv: 100000 designs\n"),
        "{printed_text}"
    );
    let names = [
        "sweep.csv",
        "sweep.json",
        "sweep.html",
        "metric-1.svg",
        "stability.svg",
        "roots.svg",
    ];
    for name in names {
        let [one, other] = [whole, parts].map(|place| {
            fs::read(Path::new(place).join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
        });
        assert!(one == other && !one.is_empty(), "{name}");
    }
    fs::remove_file(Path::new(parts).join("sweep.5-of-8.csv")).expect("it is there");
    assert!(refused(&["merge", parts], 2).contains("missing: 5"));
    assert!(refused(&["merge", whole], 2).contains("no part of a sweep"));
}

#[test]
fn a_part_that_was_cut_is_named_and_mended() {
    let scene = veering("cut-part.json");
    let parts = fresh("cut-part");
    let parts = parts.to_str().expect("a UTF-8 path");
    let vary = ["--vary", "soil.stiffness=1:7:9", "--out", parts];
    let run = |part: &str| {
        let output = eigentone(
            &[
                &["sweep", &scene],
                &vary[..],
                &["--shard", part, "--resume"],
            ]
            .concat(),
        );
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stderr).expect("UTF-8")
    };
    for part in ["1/3", "2/3", "3/3"] {
        run(part);
    }
    printed(&["merge", parts]);
    let whole = fs::read_to_string(Path::new(parts).join("sweep.csv")).expect("a table");
    for (part, name) in [("1/3", "sweep.1-of-3.csv"), ("3/3", "sweep.3-of-3.csv")] {
        let file = Path::new(parts).join(name);
        let text = fs::read_to_string(&file).expect("a table");
        let lines: Vec<&str> = text.split_inclusive('\n').collect();
        assert_eq!(lines.len(), 4);
        // Behind a design, within one, within the columns, and all of it.
        let ends = [lines[0].len() + lines[1].len(), text.len() - 3, 5, 0];
        for end in ends {
            fs::write(&file, &text[..end]).expect("it can be written");
            let error = refused(&["merge", parts], 2);
            let right = format!("missing: {} (not complete: --resume goes on)", &part[..1]);
            assert!(error.contains(&right), "{end}: {error}");
            assert!(!run(part).contains("complete already"), "{end}");
            assert_eq!(fs::read_to_string(&file).expect("a table"), text, "{end}");
            assert!(run(part).contains("complete already"));
            printed(&["merge", parts]);
            let merged = fs::read_to_string(Path::new(parts).join("sweep.csv"));
            assert_eq!(merged.expect("a table"), whole);
        }
        fs::write(&file, text.clone() + lines[3]).expect("it can be written");
        let error = refused(&["merge", parts], 2);
        let last = if part == "1/3" { 2 } else { 8 };
        let right =
            format!("{name}: line 5: its part of the sweep ends with design {last}: remove");
        assert!(error.contains(&right), "{error}");
        // A line that is damaged, is missing, or is of another design is found before anything is computed.
        let damaged = [
            (lines[0].to_owned() + lines[2] + lines[3], 2),
            (lines[..2].concat() + "x,y\n" + lines[3], 3),
            (
                lines[..3].concat() + &lines[3].replace(",false", ",1,false"),
                4,
            ),
            (
                text.replacen(lines[2], &lines[2].replacen('.', ".1", 1), 1),
                3,
            ),
        ];
        for (content, line) in damaged {
            let right = format!("{name}: line {line}: design {} of this", last - 4 + line);
            for ending in ["", ".part"] {
                let place = file.with_extension(format!("csv{ending}"));
                fs::write(&place, &content).expect("it can be written");
                let again = [
                    &["sweep", &scene],
                    &vary[..],
                    &["--shard", part, "--resume"],
                ]
                .concat();
                let error = refused(&again, 2);
                assert!(
                    error.contains(
                        &right.replace(name, &place.file_name().expect("a name").to_string_lossy())
                    ),
                    "{error}"
                );
                assert_eq!(fs::read_to_string(&place).expect("it is left"), content);
            }
            fs::remove_file(file.with_extension("csv.part")).expect("it is there");
            assert!(refused(&["merge", parts], 2).contains(&right));
        }
        fs::write(
            &file,
            [&text.as_bytes()[..text.len() - 9], b"\xff\xfe\n"].concat(),
        )
        .expect("it can be written");
        assert!(refused(&["merge", parts], 2).contains(": line 4: design "));
        fs::write(&file, text).expect("it can be written");
    }
}

#[test]
fn axes_of_designs_have_units() {
    let folder = fresh("sweep-units");
    fs::create_dir_all(&folder).expect("it can be made");
    let file = folder.join("car.json");
    let text = r#"{"masses": [{"name": "body", "mass": 300}, {"name": "wheel", "mass": 40}, {"name": "disc", "mass": 2, "unit": "rad"}],
        "supports": ["road"],
        "springs": [{"name": "k", "between": ["wheel", "body"], "stiffness": 16000}, {"between": ["road", "wheel"], "stiffness": 160000},
                    {"name": "t", "between": ["ground", "disc"], "stiffness": 5}],
        "dampers": [{"name": "c", "between": ["wheel", "body"], "damping": 1000}, {"between": ["ground", "disc"], "damping": 1}],
        "outputs": [{"name": "comfort", "acceleration": {"body": 1}}, {"name": "grip", "force": "k"}],
        "noise": [{"of": "road", "velocity": 1e-3}]}"#;
    fs::write(&file, text).expect("it can be written");
    let out = folder.join("out");
    let [scene, out] = [&file, &out].map(|path| path.to_str().expect("UTF-8"));
    let metrics = [
        ("damping", ">damping<"),
        ("frequency 2", ">frequency 2, rad/s<"),
        ("gain body comfort", ">gain body comfort, m/s²/N<"),
        ("gain road grip", ">gain road grip, N/m<"),
        ("gain disc disc", ">gain disc disc, rad/(N·m)<"),
        ("rms comfort", ">rms comfort, m/s²<"),
    ];
    let asked = metrics.iter().flat_map(|(metric, _)| ["--metric", metric]);
    let asked: Vec<&str> = asked.chain(["--out", out]).collect();
    for (vary, axis) in [
        ("c.damping=800:1200:3", ">c.damping, N·s/m<"),
        ("t.stiffness=4,5", ">t.stiffness, N·m/rad<"),
        ("wheel.mass=30,40", ">wheel.mass, kg<"),
        ("disc.mass=1,2", ">disc.mass, kg·m²<"),
    ] {
        printed(&[&["sweep", scene, "--vary", vary], &asked[..]].concat());
        for (k, (_, label)) in metrics.iter().enumerate() {
            let drawing = Path::new(out).join(format!("metric-{}.svg", k + 1));
            let drawing = fs::read_to_string(drawing).expect("a drawing");
            // Of small values the axis has a power of ten.
            let powers = |label: &str| label.replace(", 10⁻³ ", ", ").replace(", 10⁻⁶ ", ", ");
            let drawing = powers(&drawing);
            assert!(
                drawing.contains(axis) && drawing.contains(label),
                "{label} {drawing}"
            );
        }
    }
}

/// Random trees of masses, heavily and hardly damped: the largest gain that doubles find is the proven one.
#[test]
fn gains_in_doubles_are_the_proven_ones() {
    let folder = fresh("sweep-gains-proven");
    fs::create_dir_all(&folder).expect("a folder");
    let mut state = 20_261_123u64;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1u64 << 24) as f64
    };
    for k in 0..12 {
        let n = 1 + (6.0 * next()) as usize;
        let mut number = |low: f64, high: f64| 10f64.powf(low + (high - low) * next());
        let (mut masses, mut springs, mut dampers) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..n {
            let name = format!("m{i}");
            let other = match i {
                0 => "ground".to_owned(),
                _ => format!("m{}", (number(0.0, 3.0) as usize) % i),
            };
            masses.push(serde_json::json!({"name": name, "mass": number(-2.0, 2.0)}));
            springs.push(serde_json::json!({"name": format!("s{i}"), "between": [other, name], "stiffness": number(-2.0, 4.0)}));
            dampers
                .push(serde_json::json!({"between": [other, name], "damping": number(-5.0, 2.0)}));
        }
        let scene = serde_json::json!({"masses": masses, "springs": springs, "dampers": dampers});
        let file = folder.join(format!("{k}.json"));
        fs::write(&file, scene.to_string()).expect("it can be written");
        let (file, metric) = (file.to_str().expect("UTF-8"), format!("gain m0 m{}", n - 1));
        let gains = |precision: &str| -> Vec<f64> {
            let vary = "s0.stiffness=0.01:10000:4:log";
            let arguments = ["sweep", file, "--vary", vary, "--metric", &metric, "--json"];
            let text = printed(&[&arguments[..], &["--precision", precision]].concat());
            let lines = text
                .lines()
                .map(|line| serde_json::from_str::<Value>(line).expect("JSON"));
            lines
                .map(|line| line["metrics"][&metric].as_f64().expect("a gain"))
                .collect()
        };
        for (quick, proven) in gains("double").into_iter().zip(gains("certified")) {
            assert!(
                (quick - proven).abs() <= 1e-8 * proven,
                "{k}: {quick} for {proven}"
            );
        }
    }
}
