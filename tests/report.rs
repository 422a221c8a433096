//! `report.html`: what is in it, that nothing can break out of it, and how it looks in a browser.

#[path = "report/sha256.rs"]
mod sha256;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use eigentone::gallery::{Case, cases, machines, switches};
use serde_json::{Value, json};

/// What a browser may be called. Without any the test of looks is skipped.
const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

fn fresh(name: &str) -> PathBuf {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    if directory.exists() {
        fs::remove_dir_all(&directory).expect("it can be removed");
    }
    fs::create_dir_all(&directory).expect("it can be made");
    directory
}

/// The report of a scene, written into a directory of its own.
fn report(directory: &Path, name: &str, scene: &str) -> PathBuf {
    let file = directory.join(format!("{name}.json"));
    fs::write(&file, scene).expect("it can be written");
    let out = directory.join(name);
    let output = Command::new(env!("CARGO_BIN_EXE_eigentone"))
        .arg("analyze")
        .arg(&file)
        .arg("--out")
        .arg(&out)
        .output()
        .expect("the binary runs");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{name}: {error}");
    out.join("report.html")
}

/// A motion of a million seconds, followed peak by peak, whose page has nothing that others lack.
const LONG: &str = "undamped-long";

fn short_cases() -> impl Iterator<Item = &'static Case> {
    let all = cases().iter().chain(machines()).chain(switches());
    all.filter(|case| case.name() != LONG)
}

/// The report of every other scene of the gallery, below one directory.
static GALLERY: LazyLock<(PathBuf, Vec<PathBuf>)> = LazyLock::new(|| {
    let directory = fresh("report");
    let reports = short_cases().map(|case| report(&directory, case.name(), case.scene_text()));
    let reports = reports.collect();
    (directory, reports)
});

fn html(directory: &Path, name: &str, scene: &str) -> String {
    fs::read_to_string(report(directory, name, scene)).expect("it was written")
}

/// The names of all tags in order, each checked against what is open.
fn tags(html: &str) -> Vec<String> {
    let (mut found, mut open) = (Vec::new(), Vec::new());
    let body = html.strip_prefix("<!DOCTYPE html>").expect("a document");
    let (head, rest) = body.split_once("<style>").expect("a style");
    let (_, rest) = rest.split_once("</style>").expect("its end");
    let (rest, end) = rest.split_once("<script>").expect("a script");
    let (_, end) = end.split_once("</script>").expect("its end");
    for part in format!("{head}{rest}{end}").split('<').skip(1) {
        let (tag, text) = part.split_once('>').expect("every tag ends");
        assert!(!text.contains('>'), "{part}");
        let name = tag
            .split_whitespace()
            .next()
            .expect("a name")
            .trim_end_matches('/');
        assert!(tag.matches('"').count().is_multiple_of(2), "{tag}");
        match name.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop().as_deref(), Some(name), "{tag}"),
            None if tag.ends_with('/') || name == "meta" => {}
            None => open.push(name.to_owned()),
        }
        found.push(name.to_owned());
    }
    assert!(open.is_empty(), "{open:?}");
    found
}

fn sections(html: &str) -> Vec<&str> {
    let parts = html.split("<section id=\"").skip(1);
    parts.filter_map(|part| part.split('"').next()).collect()
}

/// Two masses between walls with every kind of load, called by the names given.
fn pair(title: &str, names: [&str; 2]) -> String {
    json!({
        "title": title,
        "masses": [{"name": names[0], "mass": 1.0}, {"name": names[1], "mass": 2.0}],
        "springs": [
            {"between": ["ground", names[0]], "stiffness": 3.0},
            {"between": [names[0], names[1]], "stiffness": 2.0},
        ],
        "dampers": [{"between": ["ground", names[1]], "damping": 0.2}],
        "initial": {names[0]: {"displacement": 1.0, "velocity": -0.25}},
        "loads": [
            {"on": names[0], "step": {"force": -2.0, "start": 1.0}},
            {"on": names[0], "ramp": {"rate": 0.1}},
            {"on": names[1], "impulse": {"magnitude": 1.0, "at": 3.0}},
            {"on": names[1], "harmonic": {"amplitude": 0.5, "frequency": 2.0, "phase": 0.3}},
            {"on": names[1], "samples": {"step": 0.5, "values": [0.0, 1.0, -1.0], "hold": "first"}},
        ],
        "time": {"end": 20.0, "step": 0.05},
    })
    .to_string()
}

/// Masses that are joined in many ways, and loaded.
fn network() -> String {
    let names: Vec<String> = (1..=6).map(|i| format!("m{i}")).collect();
    let masses = names.iter().map(|name| json!({"name": name, "mass": 1.5}));
    let ring =
        (0..6).map(|i| json!({"between": [names[i], names[(i + 1) % 6]], "stiffness": 100.0}));
    let other = [
        ("m1", "m4", 50.0),
        ("ground", "m3", 2e7),
        ("ground", "m3", 12_345.678),
        ("m2", "m5", 0.1),
        ("m3", "m5", 7.0),
        ("ground", "m1", 1e3),
        ("ground", "m6", -1.5),
    ];
    let other = other
        .iter()
        .map(|(a, b, k)| json!({"between": [a, b], "stiffness": k}));
    let dampers = [("m1", "m2"), ("ground", "m4"), ("m2", "m6"), ("m1", "m2")];
    let dampers = dampers
        .iter()
        .map(|ends| json!({"between": [ends.0, ends.1], "damping": 0.3}));
    json!({
        "title": "A ring with cross links",
        "masses": masses.collect::<Vec<Value>>(),
        "springs": ring.chain(other).collect::<Vec<Value>>(),
        "dampers": dampers.collect::<Vec<Value>>(),
        "loads": [
            {"on": "m3", "harmonic": {"amplitude": 5.0, "frequency": 12.0}},
            {"on": "m5", "impulse": {"magnitude": -2.0, "at": 1.0}},
        ],
        "time": {"end": 4.0, "step": 0.01},
    })
    .to_string()
}

/// A damped row of `n` masses, followed for `samples` steps.
fn row(n: usize, samples: u32) -> String {
    let name = |i: usize| {
        if i == 0 {
            "ground".to_owned()
        } else {
            format!("storey {i}")
        }
    };
    let masses = (1..=n).map(|i| json!({"name": name(i), "mass": 1.0}));
    let spring = |i| json!({"between": [name(i - 1), name(i)], "stiffness": 100.0});
    let damper = |i| json!({"between": [name(i - 1), name(i)], "damping": 0.2});
    json!({
        "masses": masses.collect::<Vec<Value>>(),
        "springs": (1..=n).map(spring).collect::<Vec<Value>>(),
        "dampers": (1..=n).map(damper).collect::<Vec<Value>>(),
        "initial": {name(n): {"velocity": 1.0}},
        "time": {"end": 0.01 * f64::from(samples), "step": 0.01},
    })
    .to_string()
}

const FLUTTER: &str = r#"{"title": "Flutter",
    "matrices": {"mass": [[1, 0], [0, 1]], "damping": [[0.01, 0], [0, 0.01]], "stiffness": [[2, 1], [-1, 2]]},
    "initial": {"x1": {"displacement": 0.001}}, "time": {"end": 20, "step": 0.05}}"#;

#[test]
fn it_loads_nothing_and_runs_its_own_script_alone_and_is_well_formed() {
    for (case, report) in short_cases().zip(&GALLERY.1) {
        let html = fs::read_to_string(report).expect("it was written");
        tags(&html);
        for foreign in [
            "http:",
            "https:",
            "<script ",
            "<link",
            "src=",
            "url(",
            "@import",
            "javascript:",
        ] {
            assert!(!html.contains(foreign), "{}: {foreign}", case.name());
        }
        assert!(html.contains("prefers-color-scheme"));
        let parts = html.split("<script>").collect::<Vec<_>>();
        assert_eq!(parts.len(), 2, "{}", case.name());
        let (script, _) = parts[1].split_once("</script>").expect("its end");
        let policy = "default-src 'none'; style-src 'unsafe-inline'; script-src";
        let hash = sha256::base64(&sha256::digest(script.as_bytes()));
        let allowed = format!("Content-Security-Policy\" content=\"{policy} 'sha256-{hash}'\"");
        assert!(html.contains(&allowed), "{hash} is the script's");
        let drawn = html.replace(script, "");
        assert!(
            !drawn.contains("NaN") && !drawn.contains("inf "),
            "{}",
            case.name()
        );
        assert!(
            html.len() < 500_000,
            "{}: {} bytes",
            case.name(),
            html.len()
        );
        let title = case.scene().title().expect("a title").to_owned();
        assert!(html.contains(&format!("<h1>{title}</h1>")), "{title}");
    }
}

#[test]
fn it_has_what_the_scene_needs_and_no_more() {
    let directory = fresh("report-parts");
    let still = ["scene", "plan", "modes", "shapes", "frequency", "bounds"];
    let text = |name: &str| {
        let case = cases()
            .iter()
            .find(|case| case.name() == name)
            .expect("a case");
        html(&directory, name, case.scene_text())
    };
    assert_eq!(sections(&text("triple-defect")), still);
    let moving = [
        "scene",
        "plan",
        "modes",
        "shapes",
        "frequency",
        "response",
        "bounds",
    ];
    let html = text("three-mass-1");
    assert_eq!(sections(&html), moving);
    assert!(html.contains("<h3>Energy</h3>") && !html.contains("<h3>Participation</h3>"));
    // The peaks are those of the motion, not of its samples: README.md has them from elsewhere.
    assert!(html.contains("m2</span>: 7.16802 m at 1.06064 s"));
    let driven = self::html(&directory, "pair", &pair("Two masses", ["a", "b"]));
    assert!(sections(&driven).contains(&"steady-state"));
    // Undamped: effective masses that add up to the whole.
    let html = text("one-mass-undamped");
    assert!(html.contains("<h3>Participation</h3>"));
    let html = self::html(&directory, "flutter", FLUTTER);
    assert!(html.contains("no parts to draw") && !html.contains("<h3>Energy</h3>"));
    assert!(html.contains("<span>growing</span>"));
    let belt = switches()
        .iter()
        .find(|case| case.name() == "belt-stick-slip");
    let belt = belt.expect("a case");
    let html = self::html(&directory, belt.name(), belt.scene_text());
    // The belt reaches the masses through friction alone: there is no frequency response.
    assert_eq!(
        sections(&html),
        ["scene", "plan", "modes", "shapes", "response", "bounds"]
    );
    for part in ["Events", "Energy taken", "Accelerations and forces"] {
        assert!(html.contains(&format!("<h3>{part}</h3>")), "{part}");
    }
    let bands = html.split("data-m=\"2\"").nth(1).expect("when it sticks");
    let bands = bands.split("/>").next().expect("a path");
    let truth = belt.truth();
    let stuck = truth.events.iter().filter(|event| event.what == "stick");
    assert_eq!(bands.matches('z').count(), stuck.count());
}

#[test]
fn names_change_nothing_but_text() {
    let directory = fresh("report-names");
    let plain = html(&directory, "plain", &pair("A title", ["one name", "other"]));
    let hostile = pair(
        "</title><script>alert(1)</script>\" onload=\"alert(2) <!-- ]]> & \u{202e}",
        [
            "<img src=x onerror=alert(1)>",
            "\"'</text></svg><b>&amp;\u{1b}\n",
        ],
    );
    let hostile = html(&directory, "hostile", &hostile);
    assert_eq!(tags(&plain), tags(&hostile));
    assert!(!hostile.contains("<img") && !hostile.contains("\" onload"));
    assert!(!hostile.contains('\u{1b}'));
}

#[test]
fn long_motions_of_many_masses_stay_below_a_megabyte() {
    let directory = fresh("report-size");
    for (masses, samples) in [(12, 2_000), (60, 4_000)] {
        let html = html(&directory, "row", &row(masses, samples));
        assert!(html.len() < 1_000_000, "{} bytes", html.len());
        tags(&html);
        // Each curve in a panel of its own.
        let panels = html.matches("aria-label=\"Displacement: ").count();
        assert_eq!(panels, masses.min(50));
        assert_eq!(
            html.contains("Drawn are the 50 of 60 that go farthest."),
            masses == 60
        );
        assert_eq!(
            html.contains("too many for a readable drawing"),
            masses == 60
        );
    }
}

/// Every colour against what is behind it, in both schemes, by the contrast of WCAG 2.1: text 4.5, drawings 3.
#[test]
fn colours_have_the_contrast_of_wcag_aa() {
    let style = include_str!("../crates/eigentone/report/page/style.css");
    let schemes: Vec<&str> = style.split(":root {").skip(1).take(2).collect();
    for (scheme, block) in ["light", "dark"].iter().zip(schemes) {
        let luminance = |name: &str| -> f64 {
            let (_, value) = block.split_once(&format!("--{name}: #")).expect(name);
            let channel = |k: usize| {
                let byte = u8::from_str_radix(&value[2 * k..2 * k + 2], 16).expect("two digits");
                let c = f64::from(byte) / 255.0;
                if c <= 0.04045 {
                    c / 12.92
                } else {
                    ((c + 0.055) / 1.055).powf(2.4)
                }
            };
            0.2126 * channel(0) + 0.7152 * channel(1) + 0.0722 * channel(2)
        };
        let contrast = |a: &str, b: &str| {
            let (a, b) = (luminance(a), luminance(b));
            (a.max(b) + 0.05) / (a.min(b) + 0.05)
        };
        let text = [
            ("ink", "page"),
            ("ink", "card"),
            ("ink", "box"),
            ("soft", "page"),
            ("soft", "card"),
            ("c0", "page"),
            ("c1", "card"),
        ];
        let lines = (0..7).map(|k| format!("c{k}"));
        let drawn: Vec<(String, &str)> = lines.map(|colour| (colour, "card")).collect();
        let text = text.map(|(a, b)| (a.to_owned(), b, 4.5));
        let drawn = drawn.into_iter().map(|(a, b)| (a, b, 3.0));
        for (a, b, least) in text.into_iter().chain(drawn) {
            let found = contrast(&a, b);
            assert!(found >= least, "{scheme}: {a} on {b} has {found:.2}");
        }
    }
}

/// A machine of displacements and rotations names the units of both, and draws them apart.
#[test]
fn displacements_and_rotations_stand_apart() {
    let (directory, _) = &*GALLERY;
    let html = fs::read_to_string(directory.join("half-car/report.html")).expect("it was written");
    for wanted in [
        "1310 kg·m²",
        "half sine 0.05 m from",
        "bounce − 1.15·pitch",
        "Springs in N/m, dampers in N·s/m,",
        "<h3>Rotation</h3>",
        "<h3>Angular velocity</h3>",
        "displacement, m or rad",
        "; displacements reach 1.00000, rotations 0.419386",
    ] {
        assert!(html.contains(wanted), "{wanted}");
    }
    assert_eq!(html.matches("aria-label=\"Rotation\"").count(), 1);
    // Three points, each of which bounces and pitches; what the roads bring is counted.
    assert_eq!(html.matches("times as far</title>").count(), 6);
    assert!(html.contains("dashed lines lead there") && html.contains("<h3>Energy</h3>"));
    let html =
        fs::read_to_string(directory.join("drive-train/report.html")).expect("it was written");
    for wanted in [
        "Springs in N·m/rad, dampers in N·m·s/rad,",
        "0.6 kg·m², 0.25·pinion",
        "40 N·m",
    ] {
        assert!(html.contains(wanted), "{wanted}");
    }
    assert!(!html.contains("displacement, m"));
    let header = |name: &str, file: &str| {
        let text = fs::read_to_string(directory.join(name).join(file)).expect("it was written");
        text.lines().next().expect("a header").to_owned()
    };
    let response = header("half-car", "response.csv");
    for wanted in [
        "displacement pitch [rad]",
        "velocity pitch [rad/s]",
        "displacement_bound [m or rad]",
        "output seat [m/s²]",
        "output_bound front travel [m]",
        "output rear tyre [N]",
    ] {
        assert!(response.contains(wanted), "{wanted} in {response}");
    }
    let forces = header("drive-train", "forces.csv");
    assert!(forces.contains("spring clutch [N·m]"), "{forces}");
    for (name, rotates) in [
        ("half-car", true),
        ("drive-train", true),
        ("quarter-car-bump", false),
    ] {
        let plot = |file: &str| directory.join(name).join(file).exists();
        assert_eq!(
            plot("rotation.svg") && plot("angular-velocity.svg"),
            rotates,
            "{name}"
        );
        assert_eq!(plot("displacement.svg"), name != "drive-train", "{name}");
    }
}

/// The first browser there is.
fn browser() -> Option<&'static str> {
    let runs = |name: &&&str| {
        let output = Command::new(name).arg("--version").output();
        output.is_ok_and(|output| output.status.success())
    };
    BROWSERS.iter().find(runs).copied()
}

#[test]
fn nothing_overlaps_or_overflows_in_a_browser() {
    let Some(browser) = browser() else {
        eprintln!("skipped: none of {} is installed", BROWSERS.join(", "));
        return;
    };
    let (directory, reports) = &*GALLERY;
    let wide = ["WWWWWWWWWWWWWWWWWWWW", "MMMMMMMMMMMMMMMMMMMMMM"];
    let others = [
        ("pair", pair("Two masses", ["a", "b"])),
        ("network", network()),
        ("row", row(30, 500)),
        ("flutter", FLUTTER.to_owned()),
        ("wide", pair("Wide", wide)),
    ];
    let others = others.map(|(name, scene)| report(directory, name, &scene));
    let reports = reports.iter().chain(&others).map(|file| {
        let file = file.strip_prefix(directory).expect("it is inside");
        file.to_string_lossy().into_owned()
    });
    let reports: Vec<String> = reports.collect();
    let template = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/report/wrapper.html");
    let template = fs::read_to_string(template).expect("it is there");
    let page = template.replace("REPORTS;", &format!("{};", json!(reports)));
    let file = directory.join("wrapper.html");
    fs::write(&file, page).expect("it can be written");
    let output = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-quic",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
            "--allow-file-access-from-files",
            "--enable-logging=stderr",
            "--virtual-time-budget=60000",
            "--dump-dom",
        ])
        .arg(format!(
            "--user-data-dir={}",
            directory.join("profile").display()
        ))
        .arg(format!("file://{}", file.display()))
        .output()
        .expect("it runs");
    let dom = String::from_utf8_lossy(&output.stdout);
    let said = String::from_utf8_lossy(&output.stderr);
    let complaints: Vec<&str> = said
        .lines()
        .filter(|line| line.contains("CONSOLE"))
        .collect();
    assert!(complaints.is_empty(), "{complaints:#?}");
    let (_, found) = dom
        .split_once("<pre id=\"found\">")
        .expect("the wrapper ran");
    let (found, _) = found.split_once("</pre>").expect("its end");
    assert_eq!(found, format!("looked at {}\n\nend", reports.len()));
}
