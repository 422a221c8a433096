//! `eigentone frf`: values against answers to 34 digits that another program gave, and what it refuses; root mean squares
//! under noise against partial fractions.

use std::path::Path;
use std::process::{Command, Output};

use eigentone::gallery::Decimal;
use eigentone::scene::Scene;
use serde_json::Value;

fn frf(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_eigentone"))
        .arg("frf")
        .args(arguments)
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests"))
        .output()
        .expect("it runs")
}

fn json(arguments: &[&str]) -> Value {
    let output = frf(arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {error}");
    serde_json::from_slice(&output.stdout).expect("it is JSON")
}

fn text(arguments: &[&str]) -> String {
    let output = frf(arguments);
    assert!(output.status.success(), "{arguments:?}");
    String::from_utf8(output.stdout).expect("it is text")
}

#[test]
fn values_are_right_to_the_last_digits() {
    let truth = include_str!("frequency/truth.json");
    let cases: Vec<Value> = serde_json::from_str(truth).expect("it is JSON");
    assert!(cases.len() > 10);
    for case in &cases {
        let of = |key: &str| case[key].as_str().expect("a text");
        let scene = format!("{}.json", of("scene"));
        let rows = case["rows"].as_array().expect("rows");
        let at: Vec<String> = rows
            .iter()
            .map(|row| row["frequency"].to_string())
            .collect();
        let answer = json(&[
            &scene,
            "--from",
            of("from"),
            "--at",
            &at.join(","),
            "--json",
        ]);
        assert_eq!(answer["bounds"], "proven");
        let mut compared = 0;
        for function in answer["functions"].as_array().expect("functions") {
            let to = function["to"].as_str().expect("a name");
            let name = match function["quantity"].as_str() {
                Some("output") => format!("output {to}"),
                _ => to.to_owned(),
            };
            for (k, row) in rows.iter().enumerate() {
                let parts = &row["values"][&name];
                let exact = |i: usize| -> Decimal {
                    serde_json::from_value(parts[i].clone()).expect("a decimal")
                };
                let (re, im) = (exact(0), exact(1));
                let found = |key: &str| function[key][k].as_f64().expect("a number");
                let off = re.minus(found("re")).hypot(im.minus(found("im")));
                let size = re.to_f64().hypot(im.to_f64());
                assert!(
                    off <= 4.0 * f64::EPSILON / 2.0 * size,
                    "{scene} {name}: {off:e} of {size:e}"
                );
                assert!(
                    off <= found("bound") * (1.0 + 1e-12),
                    "{scene} {name} {k}: {off:e}"
                );
                // What is 0 is known to 1e-30 of what it is the sum of.
                let least = if size == 0.0 { 1e-25 } else { 0.0 };
                assert!(
                    found("bound") <= 4.0 * f64::EPSILON / 2.0 * size + least,
                    "{scene} {name} {k}"
                );
                compared += 1;
            }
        }
        assert_eq!(
            compared,
            rows.len() * rows[0]["values"].as_object().expect("values").len()
        );
    }
}

#[test]
fn tables_show_peaks_and_values() {
    let scene = "gallery/machines/scenes/quarter-car-bump.json";
    let peaks = text(&[scene, "--to", "body"]);
    assert!(
        peaks.contains("peak") && peaks.contains("dip") && peaks.contains("m/m"),
        "{peaks}"
    );
    let values = text(&[
        scene,
        "--to",
        "body",
        "--quantity",
        "acceleration",
        "--at",
        "1,2",
    ]);
    assert!(
        values.contains("m/s²/m") && values.contains("proven within"),
        "{values}"
    );
    assert_eq!(values.lines().count(), 3);
    // The frequencies of the scene.
    let own = json(&["frequency/lossy-springs.json", "--json"]);
    let frequencies = own["frequency"].as_array().expect("frequencies");
    assert_eq!(frequencies.len(), 10);
    assert_eq!(frequencies[9].as_f64(), Some(100.0));
    let functions = own["functions"].as_array().expect("functions");
    assert_eq!(
        functions.len(),
        6,
        "from each of two masses, to two masses and an output"
    );
    assert!(functions[0]["peaks"][0]["gain"].is_number());
}

/// In doubles a beam of 40 coordinates is answered by a Hessenberg form where that has digits enough, else by modes.
#[test]
fn doubles_say_how_they_were_found() {
    fn with<'a>(more: &[&'a str]) -> Vec<&'a str> {
        let scene = "frequency/mast.json";
        let asked = [scene, "--from", "tip", "--to", "tip", "--at", "500,1,2000"];
        asked.iter().chain(more).copied().collect()
    }
    let proven = json(&with(&["--json"]));
    let doubles = json(&with(&["--json", "--precision", "double"]));
    let method = |of: &Value| {
        of["methods"][0]["method"]
            .as_str()
            .expect("a text")
            .to_owned()
    };
    assert!(method(&proven).starts_with("modes"), "{proven}");
    assert!(method(&doubles).starts_with("Hessenberg form"), "{doubles}");
    // So stiff a beam leaves that form too few digits at low frequencies.
    let counts = [0, 1].map(|k| doubles["methods"][k]["frequencies"].as_u64());
    assert_eq!(counts, [Some(2), Some(1)], "{doubles}");
    assert_eq!(doubles["bounds"].as_str(), Some("estimated"));
    for k in 0..3 {
        let of =
            |answer: &Value, key: &str| answer["functions"][0][key][k].as_f64().expect("known");
        let parts = ["re", "im"].map(|key| of(&proven, key) - of(&doubles, key));
        let bound = of(&doubles, "bound");
        assert!(
            parts[0].hypot(parts[1]) <= bound + of(&proven, "bound"),
            "{k}"
        );
        assert!(bound <= 1e-6 * of(&doubles, "re").abs(), "{k}: {bound:e}");
    }
    let text = text(&with(&["--precision", "double"]));
    assert!(text.contains("2 frequencies by Hessenberg form"), "{text}");
}

/// Beyond 400 coordinates there are values around the lowest modes, and peaks: the poles of a chain, ω = 20 sin((2k − 1)π/(4n + 2)).
/// Where they would take too long there is a word on it.
#[test]
fn large_systems_have_peaks_around_the_lowest_modes() {
    let names: Vec<String> = (0..500).map(|i| format!("m{i}")).collect();
    let masses = names
        .iter()
        .map(|name| serde_json::json!({"name": name, "mass": 1.0}));
    let below = std::iter::once("ground").chain(names.iter().map(String::as_str));
    let springs = below
        .zip(&names)
        .map(|(a, b)| serde_json::json!({"between": [a, b], "stiffness": 100.0}));
    let scene = serde_json::json!({
        "masses": masses.collect::<Vec<_>>(),
        "springs": springs.collect::<Vec<_>>(),
    });
    let file = std::env::temp_dir().join(format!("eigentone-many-{}.json", std::process::id()));
    std::fs::write(&file, scene.to_string()).expect("it is written");
    let path = file.to_str().expect("a path");
    let output = frf(&[path, "--from", "m0", "--to", "m499", "--json"]);
    let all = frf(&[path, "--from", "m0", "--json"]);
    let _ = std::fs::remove_file(&file);
    let note = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{note}");
    let answer: Value = serde_json::from_slice(&output.stdout).expect("it is JSON");
    let method = answer["methods"][0]["method"].as_str().expect("a text");
    assert!(method.starts_with("sparse factors"), "{method}");
    let peaks = answer["functions"][0]["peaks"].as_array().expect("peaks");
    assert_eq!(peaks.len(), 20);
    for (k, peak) in (0u8..).zip(peaks) {
        let angle = f64::from(2 * k + 1) * std::f64::consts::PI / 2002.0;
        let (pole, found) = (20.0 * angle.sin(), &peak["frequency"]);
        let off = (found.as_f64().expect("a number") - pole).abs();
        assert!(off <= 1e-12 * pole, "{found} for {pole}");
        assert!(peak["gain"].is_null(), "{peak}");
    }
    let note = String::from_utf8_lossy(&all.stderr);
    assert!(note.contains("would take minutes"), "{note}");
    let answer: Value = serde_json::from_slice(&all.stdout).expect("it is JSON");
    assert!(answer["functions"][0]["peaks"].is_null());
}

#[test]
fn files_appear_together() {
    let folder = std::env::temp_dir().join(format!("eigentone-frf-{}", std::process::id()));
    let out = folder.to_str().expect("a path");
    let scene = "gallery/machines/scenes/quarter-car-bump.json";
    text(&[scene, "--out", out]);
    let names = ["magnitude", "phase", "real", "imaginary", "nyquist"];
    for name in names.map(|name| format!("frf-{name}.svg")) {
        let svg = std::fs::read_to_string(folder.join(&name)).expect("it is written");
        assert!(svg.starts_with("<svg") && !svg.contains("NaN"), "{name}");
        // Displacements, accelerations and forces have no unit in common; phases have.
        let has_units = svg.contains("[m/m]") && svg.contains("[N/m]");
        assert_eq!(has_units, name != "frf-phase.svg", "{name}");
    }
    let csv = std::fs::read_to_string(folder.join("frf.csv")).expect("it is written");
    let widths = csv.lines().map(|line| line.split(',').count());
    let widths: std::collections::BTreeSet<usize> = widths.collect();
    assert_eq!(widths.len(), 1, "all rows are equally long");
    let _ = std::fs::remove_dir_all(&folder);
}

#[test]
fn wrong_questions_are_refused() {
    let scene = "gallery/machines/scenes/quarter-car-bump.json";
    for (arguments, message) in [
        (
            vec![scene, "--from", "nowhere"],
            "--from \"nowhere\" is no name of the scene",
        ),
        (
            vec![scene, "--to", "ground"],
            "--to \"ground\" is no name of the scene",
        ),
        (vec![scene, "--at=-1"], "0 or more"),
        (vec![scene, "--at", "nan"], "0 or more"),
        (vec![scene, "--quantity", "jerk"], "displacement"),
    ] {
        let output = frf(&arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(error.contains(message), "{arguments:?}: {error}");
        assert!(output.stdout.is_empty());
    }
}

/// Root mean squares of random systems under noise within bands, truths by partial fractions over eigenvalues of 1500 bits, and
/// of the galleries under white noise, truths by linear equations of 4000 bits (FLINT for both), as the nearest doubles.
#[test]
fn root_mean_squares_are_right_to_the_last_digit() {
    let cases = include_str!("frequency/noise.json");
    let cases: Vec<Value> = serde_json::from_str(cases).expect("it is JSON");
    assert!(cases.len() > 60);
    for case in &cases {
        let scene = Scene::parse(&case["scene"].to_string(), "scene.json".as_ref());
        let scene = scene.expect("a scene");
        let motion = scene.noise().expect("it has noise").solve();
        let motion = motion.expect("it comes to rest");
        let motions = [
            ("displacement", motion.displacement()),
            ("velocity", motion.velocity()),
            ("acceleration", motion.acceleration()),
        ];
        for (key, all) in motions {
            let Some(truths) = case["rms"][key].as_array() else {
                assert_eq!(key, "acceleration", "{}", case["scene"]);
                continue;
            };
            assert_eq!(truths.len(), all.len());
            for (truth, of) in truths.iter().zip(all) {
                let truth = truth.as_f64().expect("a number");
                let (value, bound) = of.rms.finite().expect("within a band");
                let (off, unit) = ((value - truth).abs(), truth * f64::EPSILON / 2.0);
                assert!(
                    off <= bound + unit,
                    "{}: {value:e} ± {bound:e}, not {truth:e}",
                    case["scene"]
                );
                assert!(bound <= 1.6 * unit, "{value:e} ± {bound:e}");
            }
        }
    }
}
