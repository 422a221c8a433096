//! `optimise` with two metrics, gains between two frequencies, and an absorber for a building.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use super::{fresh, number, parsed, printed, refused};

const BODY: f64 = 300.0;
const WHEEL: f64 = 40.0;
const TYRE: f64 = 160_000.0;
/// One-sided density of the road's velocity, m²/s² per Hz.
const DENSITY: f64 = 1e-3;

fn written(file: &Path, scene: &Value) -> String {
    fs::write(file, scene.to_string()).expect("it can be written");
    file.to_str().expect("a UTF-8 path").to_owned()
}

fn quarter_car(file: &Path) -> String {
    written(
        file,
        &json!({
            "masses": [{"name": "body", "mass": BODY}, {"name": "wheel", "mass": WHEEL}],
            "supports": ["road"],
            "springs": [{"name": "suspension", "between": ["wheel", "body"], "stiffness": 16000},
                        {"name": "tyre", "between": ["road", "wheel"], "stiffness": TYRE}],
            "dampers": [{"name": "damper", "between": ["wheel", "body"], "damping": 1000}],
            "outputs": [{"name": "comfort", "acceleration": {"body": 1}},
                        {"name": "holding", "force": "tyre"},
                        {"name": "travel", "displacement": {"body": 1, "wheel": -1}}],
            "noise": [{"of": "road", "velocity": DENSITY}]
        }),
    )
}

const VARY: [&str; 4] = [
    "--vary",
    "suspension.stiffness=5e3:5e4",
    "--vary",
    "damper.damping=200:4000",
];

/// Root mean square of acceleration and travel, by the residues of a quarter car's transfer functions.
fn closed(k: f64, c: f64) -> [f64; 2] {
    let (half, both) = (DENSITY / 4.0, BODY + WHEEL);
    let comfort = half * (TYRE * c + both * k * k / c) / (BODY * BODY);
    [comfort.sqrt(), (half * both / c).sqrt()]
}

struct Design {
    parameters: [f64; 2],
    metrics: [f64; 2],
    is_shown: bool,
}

fn front(scene: &str, metrics: [&str; 2], count: &str) -> Vec<Design> {
    let aims = ["--minimise", metrics[0], "--minimise", metrics[1]];
    let more = ["--front", count, "--json"];
    let answer = parsed(&[&["optimise", scene], &VARY[..], &aims, &more].concat());
    let all = answer["front"].as_array().expect("a list").clone();
    let each = all.iter().map(|one| Design {
        parameters: ["suspension.stiffness", "damper.damping"]
            .map(|name| number(&one["parameters"][name])),
        metrics: metrics.map(|name| number(&one["metrics"][name])),
        is_shown: one["local_optimum"] == true,
    });
    each.collect()
}

#[test]
fn comfort_against_travel_is_as_closed_forms_have_it() {
    let folder = fresh("front-closed");
    fs::create_dir_all(&folder).expect("it can be made");
    let scene = quarter_car(&folder.join("car.json"));
    let designs = front(&scene, ["rms comfort", "rms travel"], "5");
    assert_eq!(designs.len(), 5);
    for design in &designs {
        let [k, c] = design.parameters;
        for (found, right) in design.metrics.iter().zip(closed(k, c)) {
            assert!((found / right - 1.0).abs() < 1e-12, "{k} {c}");
        }
    }
    // The softest spring is best for both, but for the last design, whose travel no spring changes.
    for design in &designs[..4] {
        assert!(design.is_shown);
        assert!((design.parameters[0] / 5e3 - 1.0).abs() < 1e-12);
    }
    let best = 5e3 * ((BODY + WHEEL) / TYRE).sqrt();
    assert!((designs[0].parameters[1] / best - 1.0).abs() < 1e-9);
    assert!((designs[4].parameters[1] / 4e3 - 1.0).abs() < 1e-12);
    // Between the ends both are as far above a point of the straight line that joins them.
    let ends = [designs[0].metrics, designs[4].metrics];
    let extent = [ends[1][0] - ends[0][0], ends[0][1] - ends[1][1]];
    for (k, design) in (1..4).zip(&designs[1..4]) {
        let part = f64::from(k) / 4.0;
        let above = (design.metrics[0] - ends[0][0]) / extent[0] - part;
        let other = (design.metrics[1] - ends[1][1]) / extent[1] - (1.0 - part);
        assert!(
            (above - other).abs() < 1e-9 && above < 0.0,
            "{above} {other}"
        );
    }
}

/// Values of the filter's own are in `crates/response/tests/designs.rs`: here the least of them is one of a finer and finer grid.
#[test]
fn comfort_as_people_feel_it_is_least_where_a_grid_has_it() {
    let folder = fresh("front-weighted");
    fs::create_dir_all(&folder).expect("it can be made");
    let scene = quarter_car(&folder.join("car.json"));
    let vary = ["--vary", "damper.damping=200:4000"];
    for metric in ["rms-wk comfort", "rms-wd comfort"] {
        let least = ["optimise", &scene, "--minimise", metric, "--json"];
        let answer = parsed(&[&least[..], &vary].concat());
        let certificate = &answer["certificate"];
        assert_eq!(certificate["local_optimum"], true, "{answer}");
        assert_eq!(certificate["proven"], false, "{answer}");
        let best = number(&answer["parameters"]["damper.damping"]);
        let value = number(&answer["metric"]["value"]);
        let around = format!("damper.damping={}:{}:21", 0.9 * best, 1.1 * best);
        let sweep = [
            "sweep", &scene, "--vary", &around, "--metric", metric, "--json",
        ];
        let values: Vec<f64> = printed(&sweep)
            .lines()
            .map(|line| {
                number(&serde_json::from_str::<Value>(line).expect("JSON")["metrics"][metric])
            })
            .collect();
        assert!(
            (values[10] / value - 1.0).abs() < 1e-12,
            "{metric}: {values:?}"
        );
        assert!(
            values.iter().all(|other| *other >= value * (1.0 - 1e-12)),
            "{metric}: {values:?}"
        );
        assert!(
            values[0] > 1.0005 * value && values[20] > 1.0005 * value,
            "{metric}: {values:?}"
        );
        // No person feels more of it than there is, but for the few percent that both filters add.
        let plain = [
            "sweep",
            &scene,
            "--vary",
            &around,
            "--metric",
            "rms comfort",
            "--json",
        ];
        let plain: Value =
            serde_json::from_str(printed(&plain).lines().next().expect("a line")).expect("JSON");
        assert!(values[0] < 1.06 * number(&plain["metrics"]["rms comfort"]));
    }
    let unknown = [
        "sweep",
        &scene,
        "--vary",
        "damper.damping=1000",
        "--metric",
        "rms-wk comfrot",
    ];
    assert!(refused(&unknown, 2).contains("did you mean \"comfort\"?"));
    let of_a_place = [&unknown[..5], &["rms-wk body"]].concat();
    assert!(refused(&of_a_place, 2).contains("body is in m: name an output"));
}

/// Of one mass, ∫|W|²|s²/(s² + s + 400)|² df from 0.5 to 20 Hz with 30 digits (mpmath's quadrature).
#[test]
fn comfort_on_a_road_within_a_band_is_that_of_quadrature() {
    let folder = fresh("band-weighted");
    fs::create_dir_all(&folder).expect("it can be made");
    let scene = written(
        &folder.join("one.json"),
        &json!({
            "masses": [{"name": "m", "mass": 1}],
            "springs": [{"between": ["ground", "m"], "stiffness": 400}],
            "dampers": [{"between": ["ground", "m"], "damping": 1}],
            "outputs": [{"name": "ride", "acceleration": {"m": 1}}],
            "noise": [{"on": "m", "force": 1, "band": [0.5, 20]}]
        }),
    );
    for (metric, truth) in [
        ("rms-wk ride", 9.187_733_582_418_648),
        ("rms-wd ride", 6.331_264_796_762_155),
    ] {
        for precision in ["double", "certified"] {
            let sweep = [
                "sweep", &scene, "--vary", "m.mass=1", "--metric", metric, "--json",
            ];
            let line = parsed(&[&sweep[..], &["--precision", precision]].concat());
            let found = number(&line["metrics"][metric]);
            assert!((found / truth - 1.0).abs() < 1e-15, "{metric}: {found}");
        }
    }
}

#[test]
fn no_design_of_a_grid_is_better_in_both() {
    let folder = fresh("front-grid");
    fs::create_dir_all(&folder).expect("it can be made");
    let scene = quarter_car(&folder.join("car.json"));
    let metrics = ["rms comfort", "rms holding"];
    let designs = front(&scene, metrics, "4");
    assert_eq!(designs.len(), 4);
    assert!(designs.iter().all(|design| design.is_shown));
    let grid = [
        "--vary",
        "suspension.stiffness=5e3:5e4:16:log",
        "--vary",
        "damper.damping=200:4000:24:log",
    ];
    let aims = ["--metric", metrics[0], "--metric", metrics[1], "--json"];
    let lines = printed(&[&["sweep", &scene], &grid[..], &aims].concat());
    let mut count = 0;
    for line in lines.lines() {
        let one: Value = serde_json::from_str(line).expect("JSON");
        let values = metrics.map(|name| number(&one["metrics"][name]));
        let better =
            |design: &Design| (0..2).all(|k| values[k] < design.metrics[k] * (1.0 - 1e-12));
        assert!(!designs.iter().any(better), "{line}");
        count += 1;
    }
    assert_eq!(count, 16 * 24);
    let out = folder.join("out");
    let out = out.to_str().expect("UTF-8");
    let aims = [
        "--minimise",
        metrics[0],
        "--maximise",
        "damping",
        "--front",
        "2",
    ];
    let text = printed(&[&["optimise", &scene], &VARY[..], &aims, &["--out", out]].concat());
    assert!(text.trim_start().starts_with("rms comfort "), "{text}");
    let table = fs::read_to_string(folder.join("out/front.csv")).expect("a table");
    assert_eq!(table.lines().count(), 3);
    assert!(folder.join("out/front.svg").exists());
    let one = ["--minimise", "damping", "--out", out];
    let error = refused(&[&["optimise", &scene], &VARY[..], &one].concat(), 2);
    assert!(error.contains("--out is for"), "{error}");
}

/// What grows or does not decay has no gain and no root mean square, though doubles do not show on which side of the axis its root is.
#[test]
fn roots_near_the_axis_are_placed_by_proof() {
    let folder = fresh("gain-axis");
    fs::create_dir_all(&folder).expect("it can be made");
    let scene = written(
        &folder.join("pair.json"),
        &json!({
            "masses": [{"name": "a", "mass": 2.396}, {"name": "b", "mass": 1.862}],
            "springs": [
                {"between": ["ground", "a"], "stiffness": 76.084},
                {"between": ["a", "b"], "stiffness": 38.48},
                {"between": ["ground", "b"], "stiffness": 37.74}
            ],
            "dampers": [{"name": "d", "between": ["ground", "a"], "damping": 1}],
            "outputs": [{"name": "ride", "acceleration": {"b": 1}}],
            "noise": [{"on": "b", "force": 1}]
        }),
    );
    for damping in ["-1.3749706298850007e-13", "0"] {
        let vary = format!("d.damping={damping}");
        for metric in ["gain b b", "rms b", "rms-wd ride"] {
            // A note says why there is no value.
            let output = super::eigentone(&[
                "sweep", &scene, "--vary", &vary, "--metric", metric, "--json",
            ]);
            assert!(output.status.success(), "{output:?}");
            let line: Value = serde_json::from_slice(&output.stdout).expect("JSON");
            let found = &line["metrics"][metric];
            assert!(found.is_null(), "{metric} at {damping}: {found}");
        }
    }
}

#[test]
fn gains_between_two_frequencies_are_those_of_one_mass() {
    let folder = fresh("gain-band");
    fs::create_dir_all(&folder).expect("it can be made");
    let (m, c, k) = (2.0, 0.8, 50.0);
    let scene = written(
        &folder.join("one.json"),
        &json!({
            "masses": [{"name": "m", "mass": m}],
            "springs": [{"name": "k", "between": ["ground", "m"], "stiffness": k}],
            "dampers": [{"between": ["ground", "m"], "damping": c}]
        }),
    );
    let gain = |w: f64| 1.0 / ((k - m * w * w).powi(2) + (c * w).powi(2)).sqrt();
    let peak = (k / m - c * c / (2.0 * m * m)).sqrt();
    for precision in ["double", "certified"] {
        for (band, right) in [
            ("1:20", gain(peak)),
            ("0:3", gain(3.0)),
            ("6:1000", gain(6.0)),
            ("1Hz:2Hz", gain(std::f64::consts::TAU)),
        ] {
            let metric = format!("gain m m {band}");
            let more = ["--vary", "k.stiffness=50", "--metric", &metric, "--json"];
            let line = parsed(&[&["sweep", &scene, "--precision", precision], &more[..]].concat());
            let found = number(&line["metrics"][metric.as_str()]);
            assert!(
                (found / right - 1.0).abs() < 1e-12,
                "{band}: {found} {right}"
            );
        }
    }
    let spelt = "write the frequencies of a gain as lo:hi";
    for (wrong, says) in [
        ("gain m m 3", spelt),
        ("gain m m a:b", spelt),
        ("gain m m 3:1", "nothing is between 3 and 1"),
        ("gain m m 1Hz:1Hz", "nothing is between 1Hz and 1Hz"),
    ] {
        let asked = ["--vary", "k.stiffness=50", "--metric", wrong];
        let error = refused(&[&["sweep", &scene], &asked[..]].concat(), 2);
        assert!(error.contains(says), "{error}");
    }
}

/// A mass beside the one that is shaken, and joined to it by nothing: the gain is 0, and no number changes it.
#[test]
fn gains_of_what_is_not_reached_are_0() {
    let folder = fresh("not-reached");
    fs::create_dir_all(&folder).expect("it can be made");
    let beside = |damping: f64| {
        json!({
            "masses": [{"name": "m", "mass": 2}, {"name": "x", "mass": 3}],
            "supports": ["s"],
            "springs": [
                {"name": "k", "between": ["s", "m"], "stiffness": 50},
                {"between": ["ground", "x"], "stiffness": 3}
            ],
            "dampers": [
                {"between": ["s", "m"], "damping": damping},
                {"between": ["ground", "x"], "damping": damping}
            ]
        })
    };
    for damping in [0.0, 0.5] {
        let scene = written(&folder.join("scene.json"), &beside(damping));
        for (metric, precision) in [
            ("gain s x", "double"),
            ("gain s x 1:2", "double"),
            ("gain s x", "certified"),
        ] {
            let asked = ["--metric", metric, "--precision", precision, "--json"];
            let asked = [&["sweep", &scene, "--vary", "k.stiffness=40"], &asked[..]].concat();
            assert_eq!(parsed(&asked)["metrics"][metric], json!(0.0), "{metric}");
        }
        let asked = ["optimise", &scene, "--vary", "k.stiffness=40:60"];
        let asked = [&asked[..], &["--minimise", "gain s x"]].concat();
        let text = printed(&asked);
        assert!(text.contains("what varies may not change it"), "{text}");
        let answer = parsed(&[&asked[..], &["--json"]].concat());
        assert_eq!(answer["metric"]["value"], json!(0.0));
        assert_eq!(answer["certificate"]["constant"], json!(true));
    }
}

/// Without damping a gain is infinite, and nothing settles: each metric says why of itself alone.
#[test]
fn each_metric_without_a_value_says_why() {
    let folder = fresh("each-why");
    fs::create_dir_all(&folder).expect("it can be made");
    let scene = json!({
        "masses": [{"name": "m", "mass": 2}],
        "springs": [{"name": "k", "between": ["ground", "m"], "stiffness": 50}],
        "time": {"end": 1, "step": 0.1},
        "initial": {"m": {"displacement": 1}}
    });
    let scene = written(&folder.join("scene.json"), &scene);
    let refused_for = |metrics: [&str; 2]| {
        let asked = ["optimise", &scene, "--vary", "k.stiffness=40:60"];
        let aims = metrics.map(|metric| ["--minimise", metric]);
        refused(&[&asked[..], &aims.concat()].concat(), 2)
    };
    let error = refused_for(["settling m", "gain m m"]);
    assert!(error.contains("of settling m, it drifts"), "{error}");
    assert!(error.contains("; of gain m m, it is infinite"), "{error}");
    // No double is the pole, and beside it there is a value.
    let error = refused_for(["gain m m", "damping"]);
    assert!(error.contains("of gain m m, it is infinite"), "{error}");
}

/// Of a force on one of two free bodies the stretch between them has the largest gain 1/(m·2ζω·√(ω² − ζ²ω²)).
#[test]
fn rigid_motions_leave_relative_gains() {
    let folder = fresh("free-gain");
    fs::create_dir_all(&folder).expect("it can be made");
    let scene = json!({
        "masses": [{"name": "a", "mass": 1}, {"name": "b", "mass": 2}],
        "springs": [{"between": ["a", "b"], "stiffness": 10}],
        "dampers": [{"name": "c", "between": ["a", "b"], "damping": 0.5}],
        "outputs": [{"name": "s", "displacement": {"a": 1, "b": -1}}]
    });
    let scene = written(&folder.join("scene.json"), &scene);
    let asked = [
        "optimise",
        &scene,
        "--vary",
        "c.damping=0.1:2",
        "--minimise",
    ];
    let answer = parsed(&[&asked[..], &["gain a s", "--json"]].concat());
    let exact = 1.0 / (3.0 * (15.0f64 - 2.25).sqrt());
    let gain = number(&answer["metric"]["value"]);
    assert!((gain - exact).abs() < 1e-12, "{answer}");
    let error = refused(&[&asked[..], &["gain a a"]].concat(), 2);
    assert!(error.contains("it is infinite"), "{error}");
}

/// Where the least damped roots meet, no derivative tells how far a step may go. Two masses of small whole numbers, all alike in
/// every run.
#[test]
fn the_most_damped_design_is_no_worse_than_any_that_was_looked_at() {
    let folder = fresh("most-damped");
    fs::create_dir_all(&folder).expect("it can be made");
    let mut state = 7u64;
    // Knuth's linear congruential generator.
    let mut from = |low: u64, high: u64| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        low + (state >> 33) % (high - low + 1)
    };
    for _ in 0..24 {
        let scene = json!({
            "masses": [{"name": "a", "mass": from(1, 5)}, {"name": "b", "mass": from(1, 5)}],
            "springs": [{"between": ["ground", "a"], "stiffness": from(1, 30)},
                        {"name": "k", "between": ["a", "b"], "stiffness": 1},
                        {"between": ["b", "ground"], "stiffness": from(1, 30)}],
            "dampers": [{"between": ["ground", "a"], "damping": from(0, 4) as f64 / 2.0},
                        {"name": "c", "between": ["a", "b"], "damping": 1}]
        });
        let file = written(&folder.join("two.json"), &scene);
        let (k, c) = (from(10, 30), from(5, 15));
        let limits = [format!("k.stiffness=0.1:{k}"), format!("c.damping=0.1:{c}")];
        let vary = ["--vary", &limits[0], "--vary", &limits[1]];
        let aim = ["--maximise", "damping", "--json"];
        let answer = parsed(&[&["optimise", &file], &vary[..], &aim].concat());
        // But for rounding.
        let best = number(&answer["metric"]["value"]) * (1.0 + 1e-12);
        let others = answer["certificate"]["others"].as_array().expect("a list");
        assert!(
            others.iter().all(|other| number(other) <= best),
            "{scene} {answer}"
        );
        let grid = limits.each_ref().map(|limits| format!("{limits}:16"));
        let grid = ["--vary", &grid[0], "--vary", &grid[1]];
        let aim = ["--metric", "damping", "--json"];
        for line in printed(&[&["sweep", &file], &grid[..], &aim].concat()).lines() {
            let one: Value = serde_json::from_str(line).expect("JSON");
            let value = number(&one["metrics"]["damping"]);
            assert!(value <= best, "{scene} {line} {answer}");
        }
    }
}

/// The one mass that nothing damps has a ratio of 0, of either sign before it is turned.
#[test]
fn no_zero_is_negative() {
    let folder = fresh("no-damping");
    fs::create_dir_all(&folder).expect("it can be made");
    let scene = written(
        &folder.join("two.json"),
        &json!({
            "masses": [{"name": "m", "mass": 1}, {"name": "n", "mass": 1}],
            "springs": [{"between": ["ground", "m"], "stiffness": 1}, {"between": ["ground", "n"], "stiffness": 1}],
            "dampers": [{"name": "c", "between": ["ground", "m"], "damping": 0.1}]
        }),
    );
    let best = [
        "optimise",
        &scene,
        "--vary",
        "c.damping=0:2",
        "--maximise",
        "damping",
    ];
    let all = [
        "sweep",
        &scene,
        "--vary",
        "c.damping=0,1",
        "--metric",
        "damping",
    ];
    for arguments in [best, all] {
        let text = printed(&[&arguments[..], &["--json"]].concat());
        assert!(text.contains(": 0.0}") && !text.contains("-0.0"), "{text}");
    }
}

/// A gain of 1/k is that of the force at rest: the largest wherever enough is damped.
#[test]
fn an_end_of_a_front_is_the_best_of_those_that_are_equal() {
    let folder = fresh("front-flat");
    fs::create_dir_all(&folder).expect("it can be made");
    let scene = written(
        &folder.join("one.json"),
        &json!({
            "masses": [{"name": "m", "mass": 1}],
            "springs": [{"name": "k", "between": ["ground", "m"], "stiffness": 1}],
            "dampers": [{"name": "c", "between": ["ground", "m"], "damping": 1}],
            "noise": [{"on": "m", "force": 1}]
        }),
    );
    let front = |vary: &str, aims: [&str; 2]| {
        let more = ["--vary", vary, "--front", "5", "--json"];
        let aims = ["--minimise", aims[0], "--minimise", aims[1]];
        let answer = parsed(&[&["optimise", &scene], &aims[..], &more].concat());
        answer["front"].as_array().expect("a list").clone()
    };
    let near = |value: &Value, right: f64| (number(value) / right - 1.0).abs() < 1e-9;
    // √(S/4ck) falls on.
    for aims in [["gain m m", "rms m"], ["rms m", "gain m m"]] {
        let [one] = &front("c.damping=0.5:10", aims)[..] else {
            panic!("one design is the best for both");
        };
        assert!(near(&one["metrics"]["gain m m"], 1.0), "{one}");
        assert!(near(&one["metrics"]["rms m"], 0.1 * 2.5f64.sqrt()), "{one}");
    }
    // No mass changes it.
    let [one] = &front("m.mass=0.1:10", ["rms m", "gain m m"])[..] else {
        panic!("one design is the best for both");
    };
    assert!(near(&one["metrics"]["gain m m"], 1.0), "{one}");
    // Up to m = c²/2k a heavier mass has the gain of a light one, and then one that grows with the square of the excess.
    let all = front("m.mass=0.3:10", ["gain m m", "frequency 1"]);
    assert!(near(&all[0]["metrics"]["gain m m"], 1.0), "{all:?}");
    let mass = number(&all[0]["parameters"]["m.mass"]);
    assert!((mass - 0.5).abs() < 1e-5, "{all:?}");
    assert!(near(&all[4]["parameters"]["m.mass"], 10.0), "{all:?}");
}

/// Five storeys, an absorber of 2 % of the building on the roof.
#[test]
fn an_absorber_for_a_building_is_better_than_its_neighbours() {
    let folder = fresh("building");
    fs::create_dir_all(&folder).expect("it can be made");
    let floor = |i: usize| format!("f{i}");
    let below = |i: usize| {
        if i == 1 {
            "base".to_owned()
        } else {
            floor(i - 1)
        }
    };
    let masses = (1..=5).map(|i| json!({"name": floor(i), "mass": 1e5}));
    let springs = (1..=5).map(|i| json!({"between": [below(i), floor(i)], "stiffness": 1e8}));
    let dampers = (1..=5).map(|i| json!({"between": [below(i), floor(i)], "damping": 5e4}));
    let absorber = json!({"name": "a", "mass": 1e4});
    let spring = json!({"name": "absorber", "between": ["f5", "a"], "stiffness": 8e5});
    let damper = json!({"name": "dashpot", "between": ["f5", "a"], "damping": 1e4});
    let scene = written(
        &folder.join("building.json"),
        &json!({
            "supports": ["base"],
            "masses": masses.chain([absorber]).collect::<Vec<_>>(),
            "springs": springs.chain([spring]).collect::<Vec<_>>(),
            "dampers": dampers.chain([damper]).collect::<Vec<_>>()
        }),
    );
    let vary = [
        "--vary",
        "absorber.stiffness=1e5:4e6",
        "--vary",
        "dashpot.damping=1e3:2e5",
    ];
    let aim = ["--minimise", "gain base f5", "--json"];
    let answer = parsed(&[&["optimise", &scene], &vary[..], &aim].concat());
    assert_eq!(answer["certificate"]["local_optimum"], true, "{answer}");
    assert_eq!(answer["certificate"]["proven"], true, "{answer}");
    assert_eq!(
        answer["certificate"]["active"].as_array().map(Vec::len),
        Some(2)
    );
    let best = number(&answer["metric"]["value"]);
    let grid = [
        "--vary",
        "absorber.stiffness=1e5:4e6:24:log",
        "--vary",
        "dashpot.damping=1e3:2e5:24:log",
    ];
    let lines = printed(
        &[
            &["sweep", &scene],
            &grid[..],
            &["--metric", "gain base f5", "--json"],
        ]
        .concat(),
    );
    for line in lines.lines() {
        let one: Value = serde_json::from_str(line).expect("JSON");
        assert!(number(&one["metrics"]["gain base f5"]) >= best, "{line}");
    }
}

#[test]
fn absorbers_are_tuned_as_the_literature_has_it() {
    let folder = fresh("absorber");
    fs::create_dir_all(&folder).expect("it can be made");
    let one = json!({"masses": [{"name": "m", "mass": 1}], "springs": [{"between": ["ground", "m"], "stiffness": 1}]});
    let one = written(&folder.join("one.json"), &one);
    let tuned =
        |scene: &str, more: &[&str]| parsed(&[&["absorber", scene, "--json"], more].concat());
    let answer = tuned(&one, &["--on", "m", "--mass", "0.05"]);
    assert!((number(&answer["mass_ratio"]) / 0.05 - 1.0).abs() < 1e-14);
    let rule = |name: &str| {
        ["frequency_ratio", "damping_ratio"].map(|key| number(&answer["rules"][name][key]))
    };
    // Den Hartog, Mechanical vibrations, section 3.3.
    let [f, zeta] = rule("den-hartog");
    assert!(
        (f - 0.95238).abs() < 5e-6 && (zeta - 0.1336).abs() < 5e-5,
        "{answer}"
    );
    // The rule that is exact is where the optimum is found, and that of noise likewise.
    for (name, noise, aim) in [("h-infinity", false, "gain m m"), ("h2", true, "rms m")] {
        let text = printed(&[
            "absorber",
            &one,
            "--on",
            "m",
            "--mass",
            "0.05",
            "--as-scene",
            name,
        ]);
        let mut scene: Value = serde_json::from_str(&text).expect("JSON");
        if noise {
            scene["noise"] = json!([{"on": "m", "force": 1}]);
        }
        let scene = written(&folder.join("with.json"), &scene);
        let vary = [
            "--vary",
            "absorber-spring.stiffness=0.01:0.1",
            "--vary",
            "absorber-damper.damping=0.001:0.1",
        ];
        let best = parsed(
            &[
                &["optimise", &scene],
                &vary[..],
                &["--minimise", aim, "--json"],
            ]
            .concat(),
        );
        for (key, of) in [
            ("absorber-spring.stiffness", "stiffness"),
            ("absorber-damper.damping", "damping"),
        ] {
            let error = number(&best["parameters"][key]) / number(&answer["rules"][name][of]) - 1.0;
            assert!(error.abs() < 1e-10, "{name} {key}: {error}");
        }
    }
    // The tip of a cantilever moves with a quarter of its mass in every mode: ω = β²√(EI/ρA)/L².
    let mast = json!({"beams": [{"name": "mast", "length": 2, "elements": 20, "flexural_rigidity": 100,
        "mass_per_length": 1.2, "ends": ["clamped", "free"]}], "damping": {"rayleigh": {"mass": 0.02, "stiffness": 1e-5}}});
    let mast = written(&folder.join("mast.json"), &mast);
    let tip = ["--on", "mast.20.w", "--mass", "0.03"];
    for (mode, beta) in [
        ("1", 1.875_104_068_711_961),
        ("2", 4.694_091_132_974_175),
        ("3", 7.854_757_438_237_613),
    ] {
        let answer = tuned(&mast, &[&tip[..], &["--mode", mode]].concat());
        let right = beta * beta * f64::sqrt(100.0 / 1.2) / 4.0;
        assert!(
            (number(&answer["natural_frequency"]) / right - 1.0).abs() < 3e-5,
            "{answer}"
        );
        assert!(
            (number(&answer["modal_mass"]) / 0.6 - 1.0).abs() < 1e-4,
            "{answer}"
        );
    }
    // For its second mode: no other spring or damper by a fifth makes the peaks about it as low.
    let text = printed(
        &[
            &["absorber", &mast],
            &tip[..],
            &["--mode", "2", "--as-scene", "h-infinity"],
        ]
        .concat(),
    );
    let scene: Value = serde_json::from_str(&text).expect("JSON");
    let [spring, damper] = [("springs", "stiffness"), ("dampers", "damping")]
        .map(|(list, key)| number(&scene[list][0][key]));
    let scene = written(&folder.join("mast-with.json"), &scene);
    let metric = "gain mast.20.w mast.20.w 25:90";
    let around = |value: f64| {
        [0.8, 1.0, 1.25]
            .map(|part| format!("{:?}", part * value))
            .join(",")
    };
    let vary = [
        format!("absorber-spring.stiffness={}", around(spring)),
        format!("absorber-damper.damping={}", around(damper)),
    ];
    let arguments = [
        "sweep", &scene, "--vary", &vary[0], "--vary", &vary[1], "--metric", metric, "--json",
    ];
    let gains: Vec<f64> = printed(&arguments)
        .lines()
        .map(|line| number(&serde_json::from_str::<Value>(line).expect("JSON")["metrics"][metric]))
        .collect();
    assert!(gains.iter().all(|gain| *gain >= gains[4]), "{gains:?}");
    // ω² = 3 ± √6 for x_b/x_a = (2 ∓ √6)/2, and a point x_a + c·x_b that hardly moves where c is near 2 + √6.
    let root = 6f64.sqrt();
    for c in [1.0, 4.4, 4.449_5, 4.449_489_75] {
        let two = json!({"masses": [{"name": "a", "mass": 1}, {"name": "b", "mass": 2}],
            "springs": [{"between": ["ground", "a"], "stiffness": 3}, {"between": ["a", "b"], "stiffness": 2}],
            "points": [{"name": "p", "moves": {"a": 1, "b": c}}]});
        let two = written(&folder.join("two.json"), &two);
        let of = ["--on", "p", "--mass", "0.1", "--mode", "2"];
        let moved = (c - 2.0 - root) * (2.0 - root) / 2.0;
        if moved.abs() < 1e-6 {
            let error = refused(&[&["absorber", &two], &of[..]].concat(), 2);
            assert!(error.contains("of its largest motion"), "{error}");
            continue;
        }
        let answer = tuned(&two, &of);
        let wanted = (1.0 + (2.0 - root).powi(2) / 2.0) / (moved * moved);
        let error = (number(&answer["modal_mass"]) - wanted).abs();
        assert!(
            error <= number(&answer["modal_mass_error"]),
            "{c}: {answer} {wanted}"
        );
        assert!(error < 1e-8 * wanted, "{c}: {answer}");
    }
    let error = |more: &[&str]| refused(&[&["absorber", &mast], more].concat(), 2);
    assert!(error(&["--on", "mast.20.x", "--mass", "1"]).contains("did you mean \"mast.20.w\"?"));
    assert!(error(&["--on", "mast.20.w", "--mass", "-1"]).contains("greater than 0"));
    for (mode, right) in [
        ("0", "from 1 to"),
        ("nan", "from 1 to"),
        ("41", "from 1 to 40"),
    ] {
        assert!(error(&["--on", "mast.20.w", "--mass", "1", "--mode", mode]).contains(right));
    }
    for mass in ["1e300", "1e-300"] {
        assert!(error(&["--on", "mast.20.w", "--mass", mass]).contains("nearer to the modal mass"));
    }
    let again = [
        "absorber",
        &scene,
        "--on",
        "mast.20.w",
        "--mass",
        "1",
        "--as-scene",
        "h2",
    ];
    assert!(refused(&again, 2).contains("is there already"));
    let ground = error(&["--on", "ground", "--mass", "1"]);
    assert!(ground.contains("that can move by itself"), "{ground}");
}

/// Three equal masses on one: what swings between the three has one frequency, and two shapes that are a choice. A mass moves with 2/3 of
/// what its own would.
#[test]
fn modes_of_one_frequency_act_together_on_an_absorber() {
    let folder = fresh("absorber-star");
    fs::create_dir_all(&folder).expect("it can be made");
    let masses = ["m1", "m2", "m3", "m4"].map(|name| json!({"name": name, "mass": 1.4}));
    let spring = |ends: [&str; 2]| json!({"between": ends, "stiffness": 1});
    let ends = [["ground", "m1"], ["m1", "m2"], ["m1", "m3"], ["m1", "m4"]];
    let star = json!({"masses": masses, "springs": ends.map(spring)});
    let star = written(&folder.join("star.json"), &star);
    for (on, mode) in ["m2", "m3", "m4"]
        .into_iter()
        .flat_map(|on| [(on, "2"), (on, "3")])
    {
        let asked = ["--on", on, "--mass", "0.1", "--mode", mode, "--json"];
        let answer = parsed(&[&["absorber", &star], &asked[..]].concat());
        let error = (number(&answer["modal_mass"]) - 2.1).abs();
        assert!(
            error <= number(&answer["modal_mass_error"]),
            "{on}: {answer}"
        );
    }
}

/// Where the search ends away from a minimum, what it weighed is not all as large as the largest.
#[test]
fn what_is_smaller_is_not_called_one_of_the_largest() {
    let folder = fresh("not-largest");
    fs::create_dir_all(&folder).expect("it can be made");
    let scene = json!({
        "masses": [{"name": "m", "mass": 1}, {"name": "a", "mass": 0.05}],
        "springs": [{"between": ["ground", "m"], "stiffness": 1}, {"between": ["m", "a"], "stiffness": 0.04}],
        "dampers": [{"name": "d", "between": ["m", "a"], "damping": 0.01}]
    });
    let scene = written(&folder.join("scene.json"), &scene);
    for limits in ["d.damping=0:1e12", "d.damping=0:1", "d.damping=0.001:0.1"] {
        let text = printed(&[
            "optimise",
            &scene,
            "--vary",
            limits,
            "--minimise",
            "gain m m",
        ]);
        let gain = text.lines().find_map(|line| line.strip_prefix("gain m m "));
        let gain = gain.expect("the gain").trim();
        for line in text.lines().filter(|line| line.starts_with("one of")) {
            let start = format!("one of the largest: {gain} ");
            assert!(line.starts_with(&start), "{limits}: {text}");
        }
    }
}
