//! `fit`: parameters from tables of measurements, as the other commands write them.

use std::fs;
use std::path::Path;

use num_complex::Complex;

use super::{eigentone, fresh, number, parsed, printed, refused};

/// The parameters that are looked for, and what they are where measured and where the search starts.
const SOUGHT: [(&str, f64, f64); 3] = [
    ("k.stiffness", 1.1, 1.0),
    ("absorber.stiffness", 0.04, 0.05),
    ("dashpot.damping", 0.01, 0.02),
];

fn scene(file: &Path, [k, absorber, dashpot]: [f64; 3]) -> String {
    let text = format!(
        r#"{{
  "masses": [{{"name": "m", "mass": 1.0}}, {{"name": "a", "mass": 0.05}}],
  "springs": [{{"name": "k", "between": ["ground", "m"], "stiffness": {k:?}}},
              {{"name": "absorber", "between": ["m", "a"], "stiffness": {absorber:?}}}],
  "dampers": [{{"name": "dashpot", "between": ["m", "a"], "damping": {dashpot:?}}}],
  "outputs": [{{"name": "stretch", "displacement": {{"a": 1, "m": -1}}}}],
  "initial": {{"m": {{"displacement": 1}}}},
  "time": {{"end": 10, "step": 0.5}}
}}"#
    );
    fs::write(file, text).expect("it can be written");
    file.to_str().expect("a UTF-8 path").to_owned()
}

/// The columns of a table whose header passes, without quotes around any.
fn kept(table: &str, keep: impl Fn(&str) -> bool) -> String {
    let names: Vec<&str> = table.lines().next().expect("a header").split(',').collect();
    let row = |line: &str| {
        let cells = line.split(',').zip(&names);
        let cells = cells.filter(|(_, name)| keep(name)).map(|(cell, _)| cell);
        cells.collect::<Vec<_>>().join(",") + "\n"
    };
    table.lines().map(row).collect()
}

#[test]
fn planted_parameters_come_back_from_every_kind_of_measurement() {
    let folder = fresh("fit");
    fs::create_dir_all(&folder).expect("it can be made");
    let truth = scene(
        &folder.join("truth.json"),
        SOUGHT.map(|(_, right, _)| right),
    );
    let start = scene(&folder.join("start.json"), SOUGHT.map(|(.., start)| start));
    let at = ["--at", "0.5,0.8,1.0,1.2"];
    let frf = |more: &[&str]| printed(&[&["frf", &truth, "--csv"], &at[..], more].concat());
    let modes = printed(&["modes", &truth, "--csv"]);
    let response = printed(&["response", &truth, "--csv"]);
    let no_bound = |name: &str| !name.contains("bound");
    let tables = [
        kept(&modes, |name| {
            name == "natural_frequency [Hz]" || name == "damping_ratio"
        }),
        kept(&modes, |name| {
            name == "damped_frequency [rad/s]" || name == "damping_ratio"
        }),
        kept(&response, |name| name != "step" && no_bound(name)),
        kept(&response, |name| {
            name == "time [s]" || name == "output stretch [m]"
        }),
        kept(&frf(&[]), no_bound),
        kept(&frf(&["--quantity", "acceleration"]), |name| {
            name == "frequency [Hz]" || name.starts_with("m → a") && no_bound(name)
        }),
    ];
    for (k, table) in tables.iter().enumerate() {
        let file = folder.join(format!("{k}.csv"));
        fs::write(&file, table).expect("it can be written");
        let file = file.to_str().expect("UTF-8");
        let varied = SOUGHT.iter().flat_map(|(name, ..)| ["--vary", *name]);
        let varied: Vec<&str> = varied.collect();
        let arguments = [&["fit", &start, "--to", file], &varied[..]].concat();
        let answer = parsed(&[&arguments[..], &["--json"]].concat());
        for (name, right, _) in SOUGHT {
            let found = answer["parameters"][name].as_f64().expect("a number");
            assert!((found / right - 1.0).abs() < 1e-10, "{table}{answer}");
            let reach = answer["interval"][name].as_f64().expect("an interval");
            assert!(reach < 1e-10 * right, "{answer}");
        }
        assert_eq!(answer["local_minimum"], true, "{answer}");
        let text = printed(&arguments);
        assert!(text.contains("fitted to") && text.contains("95 % confidence intervals"));
        // The scene that is found is one, and answers as the one that was measured.
        let scene = printed(&[&arguments[..], &["--as-scene"]].concat());
        let file = folder.join("found.json");
        fs::write(&file, scene).expect("it can be written");
        let roots = |file: &str| {
            let answer = parsed(&["modes", file, "--json"]);
            let all = answer["modes"].as_array().expect("modes").clone();
            let all = all
                .iter()
                .map(|mode| ["re", "im"].map(|part| number(&mode["eigenvalue"][part])));
            all.collect::<Vec<_>>()
        };
        let found = roots(file.to_str().expect("UTF-8"));
        for (found, right) in found.concat().iter().zip(roots(&truth).concat()) {
            assert!((found - right).abs() < 1e-9);
        }
    }
}

#[test]
fn what_measurements_do_not_determine_is_said() {
    let folder = fresh("fit-undetermined");
    fs::create_dir_all(&folder).expect("it can be made");
    let start = scene(&folder.join("start.json"), SOUGHT.map(|(.., start)| start));
    let file = folder.join("modes.csv");
    let file = file.to_str().expect("UTF-8");
    let fit = |table: &str, vary: &[&str]| -> Vec<String> {
        fs::write(file, table).expect("it can be written");
        let varied = vary.iter().flat_map(|name| ["--vary", *name]);
        let all = ["fit", &start, "--to", file].into_iter().chain(varied);
        all.map(str::to_owned).collect()
    };
    let strs = |all: &[String]| -> Vec<String> { all.to_vec() };
    // Frequencies alone determine no masses beside stiffnesses.
    let all = [
        "k.stiffness",
        "m.mass",
        "a.mass",
        "absorber.stiffness",
        "dashpot.damping",
    ];
    let table = "natural_frequency [rad/s],damping_ratio\n0.86,0.083\n1.09,0.031\n";
    let arguments = strs(&fit(table, &all));
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let text = printed(&arguments);
    assert!(
        text.contains("not determined: no measurement changes with k.stiffness by +100.000 %"),
        "{text}"
    );
    assert!(
        text.contains("a.mass by +100.000 %") && text.contains("± ?"),
        "{text}"
    );
    // Deviations that are given decide the weights and the intervals.
    let table = "mode,natural_frequency [rad/s],sd natural_frequency [rad/s]\n2,1.09,0.01\n1,,\n";
    let arguments = strs(&fit(table, &["k.stiffness"]));
    let mut arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    arguments.push("--json");
    let answer = parsed(&arguments);
    assert_eq!(answer["known_deviations"], true);
    let reach = answer["interval"]["k.stiffness"]
        .as_f64()
        .expect("an interval");
    // 1.96 deviations over dω/dk of the second mode, by two other fits.
    let other = |measured: f64| {
        let table = format!("mode,natural_frequency [rad/s]\n2,{measured:?}\n");
        let arguments = fit(&table, &["k.stiffness"]);
        let mut arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        arguments.push("--json");
        let answer = parsed(&arguments);
        assert!(answer["interval"]["k.stiffness"].is_null(), "{answer}");
        answer["parameters"]["k.stiffness"]
            .as_f64()
            .expect("a number")
    };
    let slope = (other(1.09001) - other(1.08999)) / 0.00002;
    assert!(
        (reach / (1.959_964 * 0.01 * slope) - 1.0).abs() < 1e-4,
        "{answer}"
    );
}

#[test]
fn measurements_that_do_not_fit_the_scene_are_refused() {
    let folder = fresh("fit-refused");
    fs::create_dir_all(&folder).expect("it can be made");
    let start = scene(&folder.join("start.json"), SOUGHT.map(|(.., start)| start));
    let file = folder.join("data.csv");
    let file = file.to_str().expect("UTF-8");
    for (table, vary, says) in [
        (
            "natural_frequency [Hz],damping_ratio\n0.1,0.02\n-0.2,0.03\n",
            "k.stiffness",
            "data.csv:3:1: a frequency is a number from 0 on",
        ),
        (
            "natural_frequency [Hz],damping_ratio\n0.1,2.0\n0.2,3.0\n",
            "k.stiffness",
            "data.csv:2:1: a damping ratio is −Re λ/|λ|, a number from -1 to 1",
        ),
        (
            "time [s],displacement b [m]\n0,1\n",
            "k.stiffness",
            "\"displacement b [m]\" is none: did you mean \"displacement m [m]\"?",
        ),
        (
            "time [s],displacement m [mm]\n0,1\n",
            "k.stiffness",
            "did you mean \"displacement m [m]\"?",
        ),
        (
            "time [s],displacement m [m]\n0,1\n0.3,1\n",
            "k.stiffness",
            "data.csv:3:1: 0.3 s is no multiple of 0.5 s",
        ),
        (
            "time [s],displacement m [m]\n0,1\n10.5,1\n",
            "k.stiffness",
            "data.csv:3:1: 10.5 s is not between 0 and 10.0 s",
        ),
        (
            "time [s],displacement m [m]\n,1\n",
            "k.stiffness",
            "data.csv:2:1: each row needs its time",
        ),
        (
            "frequency [Hz],m → m re [m/N]\n-1,1\n",
            "k.stiffness",
            "data.csv:2:1: each row needs its frequency",
        ),
        (
            "frequency [Hz],m → b re [m/N]\n1,1\n",
            "k.stiffness",
            "is none",
        ),
        (
            "natural_frequency [Hz]\nx\n",
            "k.stiffness",
            "data.csv:2:1: \"x\" is not a finite number",
        ),
        (
            "mode,natural_frequency [Hz]\n0,1\n",
            "k.stiffness",
            "a mode is a whole number from 1 on",
        ),
        (
            "mode,natural_frequency [Hz]\n3,1\n",
            "k.stiffness",
            "data.csv:2:1: this is mode 3, and the scene has 2",
        ),
        (
            "natural_frequency [Hz]\n\n",
            "k.stiffness",
            "the columns are empty",
        ),
        (
            "natural_frequency [Hz],damping_ratio,sd damping_ratio\n1,0.1,0.01\n",
            "k.stiffness",
            "give a column \"sd natural_frequency [Hz]\" too",
        ),
        (
            "natural_frequency [Hz],sd natural_frequency [Hz]\n1,0\n",
            "k.stiffness",
            "must be greater than 0",
        ),
        (
            "1,2\n",
            "k.stiffness",
            "the first line needs the name of each column",
        ),
        (
            "natural_frequency [Hz]\n1\n",
            "initial.m",
            "no number of the scene has this name",
        ),
        (
            "natural_frequency [Hz]\n1\n",
            "/outputs/0/displacement/x",
            "no number of the scene is there",
        ),
    ] {
        fs::write(file, table).expect("it can be written");
        let error = refused(&["fit", &start, "--vary", vary, "--to", file], 2);
        assert!(error.contains(says), "{table}: {error}");
    }
    // A mode that does not swing has no damping ratio.
    let creeping = scene(&folder.join("creeping.json"), [1.0, 0.05, 9.0]);
    fs::write(file, "mode,damping_ratio\n2,0.03\n1,0.25\n").expect("it can be written");
    let error = refused(
        &["fit", &creeping, "--vary", "k.stiffness", "--to", file],
        2,
    );
    let says = "no good number in place of 0.25 in column \"damping_ratio\", line 3";
    assert!(error.contains(says), "{error}");
    let lost = refused(
        &["fit", &start, "--vary", "k.stiffness", "--to", "lost.csv"],
        2,
    );
    assert!(lost.contains("lost.csv"), "{lost}");
}

/// Numbers on which no measurement depends: a mass that stays where its spring holds a force, and halves that move alike, between
/// which nothing is stretched.
#[test]
fn what_nothing_depends_on_is_not_determined() {
    let folder = fresh("fit-independent");
    fs::create_dir_all(&folder).expect("it can be made");
    let write = |name: &str, text: &str| {
        let file = folder.join(name);
        fs::write(&file, text).expect("it can be written");
        file.to_str().expect("a UTF-8 path").to_owned()
    };
    let held = write(
        "held.json",
        r#"{"masses": [{"name": "a", "mass": 1}],
  "springs": [{"name": "k", "between": ["ground", "a"], "stiffness": 4}],
  "dampers": [{"name": "c", "between": ["ground", "a"], "damping": 1}],
  "initial": {"a": {"displacement": 1}}, "loads": [{"on": "a", "step": {"force": 4}}],
  "time": {"end": 0.5, "step": 0.25}}"#,
    );
    let alike = write(
        "alike.json",
        r#"{"masses": [{"name": "a", "mass": 1.3}, {"name": "b", "mass": 1.3}], "supports": ["s"],
  "springs": [{"between": ["s", "a"], "stiffness": 4.1}, {"between": ["s", "b"], "stiffness": 4.1},
              {"name": "k", "between": ["a", "b"], "stiffness": 0.77}],
  "dampers": [{"between": ["s", "a"], "damping": 0.1}, {"between": ["s", "b"], "damping": 0.1},
              {"name": "c", "between": ["a", "b"], "damping": 0.1}],
  "initial": {"a": {"displacement": 0.3}, "b": {"displacement": 0.3}}, "time": {"end": 1, "step": 0.5}}"#,
    );
    let still =
        "time [s],displacement a [m],velocity a [m/s]\n0,1,0.001\n0.25,1,-0.001\n0.5,1,0.0005\n";
    let mode = "mode,natural_frequency [rad/s],damping_ratio\n1,1.7759,0.0217\n";
    let moves = "time [s],displacement a [m],velocity b [m/s]\n0.5,0.19,-0.41\n1,-0.05,-0.5\n";
    let passes = "frequency [rad/s],s → a re [m/m],s → a im [m/m]\n0.3,1.03,-0.001\n1,1.4,-0.01\n";
    for (scene, table, named) in [
        (&held, still, "c.damping"),
        (&alike, mode, "k.stiffness"),
        (&alike, mode, "c.damping"),
        (&alike, moves, "k.stiffness"),
        (&alike, moves, "c.damping"),
        (&alike, passes, "k.stiffness"),
        (&alike, passes, "c.damping"),
    ] {
        let file = write("data.csv", table);
        let text = printed(&["fit", scene, "--to", &file, "--vary", named]);
        let says = format!("not determined: no measurement changes with {named}");
        assert!(
            text.contains("± ?") && text.contains(&says) && !text.contains("best found"),
            "{table}{text}"
        );
    }
}

#[test]
fn measurements_far_from_the_model_leave_finite_residuals() {
    let folder = fresh("fit-far");
    fs::create_dir_all(&folder).expect("it can be made");
    let scene = scene(&folder.join("scene.json"), [1.0, 0.04, 0.01]);
    let table = folder.join("table.csv");
    let rows = "time [s],displacement m [m]\n0,0\n1,1e-300\n2,1e-300\n3,1e-300\n";
    fs::write(&table, rows).expect("it can be written");
    let table = table.to_str().expect("UTF-8");
    let text = printed(&["fit", &scene, "--vary", "k.stiffness", "--to", table]);
    assert!(
        text.contains("residuals: ") && !text.contains("inf"),
        "{text}"
    );
}

/// What doubles do not show: a mass that no spring holds, m x″ + c x′ = 0 in closed form, and ratios below the rounding of other roots.
#[test]
fn what_doubles_do_not_show_is_fitted_with_proof() {
    let folder = fresh("fit-proven");
    fs::create_dir_all(&folder).expect("it can be made");
    let found = |scene: &str, table: &str, named: &str| {
        let [to, from] = ["data.csv", "scene.json"].map(|name| folder.join(name));
        fs::write(&to, table).expect("it can be written");
        fs::write(&from, scene).expect("it can be written");
        let [to, from] = [&to, &from].map(|file| file.to_str().expect("a UTF-8 path"));
        let answer = parsed(&["fit", from, "--to", to, "--vary", named, "--json"]);
        assert_eq!(answer["local_minimum"], true, "{answer}");
        answer["parameters"][named].as_f64().expect("a number")
    };
    let free = r#"{"masses": [{"name": "a", "mass": 1}], "dampers": [{"name": "c", "between": ["ground", "a"], "damping": 0.7}],
  "initial": {"a": {"velocity": 1}}, "time": {"end": 2, "step": 0.25}}"#;
    let mut table = "time [s],displacement a [m],velocity a [m/s]\n".to_owned();
    for k in 0..=8 {
        let time = 0.25 * f64::from(k);
        let (x, v) = ((1.0 - (-0.5 * time).exp()) / 0.5, (-0.5 * time).exp());
        table += &format!("{time:?},{x:?},{v:?}\n");
    }
    assert!((found(free, &table, "c.damping") - 0.5).abs() < 1e-13);
    // The beam is damped by what moves with its end alone.
    let beam = |stiffness: f64| {
        format!(
            r#"{{"masses": [{{"name": "a", "mass": 2.7}}, {{"name": "b", "mass": 0.43}}],
  "springs": [{{"name": "k", "between": ["ground", "a"], "stiffness": {stiffness:?}}},
              {{"between": ["a", "b"], "stiffness": 2.89}}, {{"between": ["a", "beam.2.w"], "stiffness": 1}}],
  "dampers": [{{"between": ["ground", "a"], "damping": 0.1}}, {{"between": ["a", "b"], "damping": 0.04}}],
  "beams": [{{"name": "beam", "length": 1.3, "elements": 2, "flexural_rigidity": 2, "mass_per_length": 0.5,
             "ends": ["clamped", "free"]}}]}}"#
        )
    };
    let file = folder.join("truth.json");
    fs::write(&file, beam(3.16)).expect("it can be written");
    let modes = printed(&["modes", file.to_str().expect("a UTF-8 path"), "--csv"]);
    let table = kept(&modes, |name| {
        name == "natural_frequency [rad/s]" || name == "damping_ratio"
    });
    assert!((found(&beam(3.3), &table, "k.stiffness") - 3.16).abs() < 1e-12);
}

/// Numbers of any size come back: the differences that derivatives come from are spaced in parts of the number.
#[test]
fn no_size_of_a_number_ends_the_search() {
    let folder = fresh("fit-large");
    fs::create_dir_all(&folder).expect("it can be made");
    for (mass, stiffness) in [(1e12, 1e20), (1e-3, 1e16), (1e12, 1e100)] {
        let damping = 0.1 * f64::sqrt(mass * stiffness);
        let write = |name: &str, factor: f64| {
            let (k, c) = (factor * stiffness, factor * damping);
            let text = format!(
                r#"{{"masses": [{{"name": "m", "mass": {mass:?}}}],
  "springs": [{{"name": "k", "between": ["ground", "m"], "stiffness": {k:?}}}],
  "dampers": [{{"name": "c", "between": ["ground", "m"], "damping": {c:?}}}]}}"#
            );
            let file = folder.join(name);
            fs::write(&file, text).expect("it can be written");
            file.to_str().expect("a UTF-8 path").to_owned()
        };
        let (truth, start) = (write("truth.json", 1.0), write("start.json", 0.95));
        let table = folder.join("data.csv");
        fs::write(&table, printed(&["modes", &truth, "--csv"])).expect("it can be written");
        let table = table.to_str().expect("a UTF-8 path");
        let vary = ["--vary", "k.stiffness", "--vary", "c.damping"];
        // It notes which columns it leaves out.
        let output = eigentone(&[&["fit", &start, "--to", table, "--json"], &vary[..]].concat());
        assert!(output.status.success(), "{output:?}");
        let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let found = &found["parameters"];
        for (name, wanted) in [("k.stiffness", stiffness), ("c.damping", damping)] {
            let value = number(&found[name]);
            assert!(
                (value / wanted - 1.0).abs() < 1e-9,
                "{stiffness:?}: {found}"
            );
        }
    }
}

/// The receptance of one mass of 0.9 kg on 95.1 N/m with 0.05 N s/m, and beside it that of another part, at 25 frequencies.
fn receptance(beside: f64) -> String {
    let mut table = "frequency [rad/s],m → m re [m/N],m → m im [m/N]\n".to_owned();
    for i in 0..25 {
        let w = 3.0 + 13.0 * f64::from(i) / 24.0;
        let of = |k: f64, m: f64| Complex::new(k - m * w * w, 0.05 * w).inv();
        let h = of(95.1, 0.9) + beside * of(140.0, 1.0);
        table += &format!("{w:?},{:?},{:?}\n", h.re, h.im);
    }
    table
}

/// A fit of the stiffness of one mass from a start.
fn of_one_mass(folder: &Path, start: f64, table: &str) -> Vec<String> {
    let scene = format!(
        r#"{{"masses": [{{"name": "m", "mass": 0.9}}], "springs": [{{"name": "k", "between": ["ground", "m"], "stiffness": {start:?}}}],
  "dampers": [{{"between": ["ground", "m"], "damping": 0.05}}]}}"#
    );
    let [to, from] = ["data.csv", "scene.json"].map(|name| folder.join(name));
    fs::write(&to, table).expect("it can be written");
    fs::write(&from, scene).expect("it can be written");
    let [to, from] = [&to, &from].map(|file| file.to_str().expect("a UTF-8 path"));
    ["fit", from, "--vary", "k.stiffness", "--to", to]
        .map(str::to_owned)
        .into()
}

/// Between samples a resonance is narrow, and least squares have a minimum beside every one of them.
#[test]
fn a_start_far_from_the_resonance_finds_it() {
    let folder = fresh("fit-far-start");
    fs::create_dir_all(&folder).expect("it can be made");
    for start in [60.0, 70.0, 85.59, 140.0] {
        let mut asked = of_one_mass(&folder, start, &receptance(0.0));
        asked.push("--json".to_owned());
        let answer = parsed(&asked.iter().map(String::as_str).collect::<Vec<_>>());
        let off = number(&answer["parameters"]["k.stiffness"]) - 95.1;
        assert!(off.abs() < 1e-9, "{start}: {answer}");
        assert!(answer["misfit"].is_null(), "{start}: {answer}");
    }
}

/// One mass has no second resonance.
#[test]
fn what_a_model_does_not_describe_is_doubtful() {
    let folder = fresh("fit-misfit");
    fs::create_dir_all(&folder).expect("it can be made");
    let mut asked = of_one_mass(&folder, 95.0, &receptance(1.0));
    let text = printed(&asked.iter().map(String::as_str).collect::<Vec<_>>());
    assert!(text.contains("\ndoubtful: "), "{text}");
    asked.push("--json".to_owned());
    let answer = parsed(&asked.iter().map(String::as_str).collect::<Vec<_>>());
    assert!(answer["misfit"].is_string(), "{answer}");
}

/// The minimum that is found leaves an eighth of what was measured, with the next mode out of step: residuals swing as it does.
#[test]
fn residuals_that_swing_are_doubtful() {
    let folder = fresh("fit-column");
    fs::create_dir_all(&folder).expect("it can be made");
    let place = |name: &str| folder.join(name).to_str().expect("UTF-8").to_owned();
    let write = |mass: f64| {
        let text = format!(
            r#"{{"supports": ["soil"], "beams": [{{"name": "b", "length": 0.782, "elements": 2, "flexural_rigidity": 2.0, "mass_per_length": {mass},
                "ends": ["clamped", "pinned"]}}], "springs": [{{"between": ["soil", "b.1.w"], "stiffness": 0.96}}],
                "dampers": [{{"between": ["soil", "b.1.w"], "damping": 0.05}}], "outputs": [{{"name": "acc", "acceleration": {{"b.1.w": 1}}}}],
                "motions": [{{"of": "soil", "velocity": {{"versine": {{"height": 1.0, "duration": 1.5}}}}}}], "time": {{"end": 5, "step": 0.1}}}}"#
        );
        fs::write(place("beam.json"), text).expect("it can be written");
    };
    write(1.66);
    let table = printed(&["response", &place("beam.json"), "--csv"]);
    let table = kept(&table, |name| name != "step" && !name.contains("bound"));
    fs::write(place("beam.csv"), table).expect("it can be written");
    write(1.826);
    let (scene, table) = (place("beam.json"), place("beam.csv"));
    let asked = [
        "fit",
        &scene,
        "--vary",
        "b.mass_per_length",
        "--to",
        &table,
        "--json",
    ];
    let answer = parsed(&asked);
    let off = answer["parameters"]["b.mass_per_length"]
        .as_f64()
        .expect("a number")
        - 1.66;
    let misfit = answer["misfit"].as_str().unwrap_or_default();
    assert!(
        off.abs() < 1e-9 || misfit.contains("have the correlation"),
        "{off} {misfit}"
    );
}

/// Where the unit of a function is not known, its columns name the quantity, so that a velocity is none of the displacement.
#[test]
fn functions_without_units_are_those_of_their_quantity() {
    let folder = fresh("fit-without-units");
    fs::create_dir_all(&folder).expect("it can be made");
    let place = |name: &str| folder.join(name).to_str().expect("UTF-8").to_owned();
    let write = |stiffness: f64| {
        let text = format!(
            r#"{{"masses": [{{"name": "a", "mass": 1}}, {{"name": "b", "mass": 2, "unit": "rad"}}], "points": [{{"name": "p", "moves": {{"b": 2}}}}],
                "springs": [{{"name": "s", "between": ["a", "b"], "stiffness": {stiffness}}}, {{"between": ["a", "ground"], "stiffness": 2.5}}],
                "dampers": [{{"between": ["a", "b"], "damping": 0.4}}]}}"#
        );
        fs::write(place("mixed.json"), text).expect("it can be written");
    };
    let (scene, table) = (place("mixed.json"), place("mixed.csv"));
    for quantity in ["displacement", "velocity", "acceleration"] {
        write(2.5);
        let frf = [
            "frf",
            &scene,
            "--from",
            "p",
            "--to",
            "b",
            "--quantity",
            quantity,
            "--at",
            "1,2,3",
            "--csv",
        ];
        let functions = kept(&printed(&frf), |name| !name.contains("bound"));
        fs::write(&table, functions).expect("it can be written");
        write(2.6);
        let answer = parsed(&[
            "fit",
            &scene,
            "--vary",
            "s.stiffness",
            "--to",
            &table,
            "--json",
        ]);
        let found = answer["parameters"]["s.stiffness"]
            .as_f64()
            .expect("a number");
        assert!((found - 2.5).abs() < 1e-9, "{quantity}: {answer}");
    }
}
