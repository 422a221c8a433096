//! Every way in which a scene can be wrong, read once by eye: `docs/errors.md` lists each message with an input that
//! gives it. `EIGENTONE_WRITE_DOCS=1 cargo test --release --test errors` writes the page anew.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use eigentone::scene::{Scene, SceneError};

/// What would take an input that no test should make, with the reason.
const NOT_SHOWN: [(&str, &str); 9] = [
    ("SceneError::TooLarge", "takes a scene of more than 64 MiB"),
    (
        "MatrixMarketError::TooLarge",
        "takes a matrix of more than 4 GiB",
    ),
    (
        "MatrixMarketError::Memory",
        "takes a matrix of 54 million entries",
    ),
    ("BuildError::TooLarge", "takes more than ten million masses"),
    (
        "BuildError::ElementNotFinite",
        "a scene has finite numbers only",
    ),
    (
        "BuildError::MatrixNotFinite",
        "a scene has finite numbers only",
    ),
    (
        "BuildError::UnknownNode",
        "SceneError::UnknownName says it with the nearest name",
    ),
    ("LoadError::NotFinite", "a scene has finite numbers only"),
    (
        "LoadError::SampleNotFinite",
        "a scene has finite numbers only",
    ),
];

/// Scenes of one fault each.
const SCENES: &[&str] = &[
    "",
    "{\"masses\": [",
    "{\"masses\": [{\"name\": \"m\", \"mass\": 1e999}]}",
    "{\"masses\": [{\"name\": \"m\", \"mass\": 1,5}]}",
    "{\"masses\": [{\"name\": \"m\", \"mass\": 1},]}",
    "{\"masses\": [{\"name\": \"m\", \"mass\": \"1\"}]}",
    "{\"masses\": [{\"name\": \"m\"}]}",
    "{\"masses\": [{\"name\": \"m\", \"mas\": 1}]}",
    "{\"masses\": [{\"name\": \"m\", \"mass\": 1, \"mass\": 1}]}",
    "{\"masses\": []}",
    "{\"masses\": [{\"name\": \"\", \"mass\": 1}]}",
    "{\"masses\": [{\"name\": \"ground\", \"mass\": 1}]}",
    "{\"masses\": [{\"name\": \"m\", \"mass\": 1}, {\"name\": \"m\", \"mass\": 1}]}",
    "{\"masses\": [{\"name\": \"m\", \"mass\": -1}]}",
    "{\"masses\": [{\"name\": \"m\", \"mass\": 0}]}",
    "{\"masses\": [{\"name\": \"m\", \"mass\": 1}], \"springs\": [{\"between\": [\"m\", \"m\"], \"stiffness\": 1}]}",
    "{\"masses\": [{\"name\": \"m\", \"mass\": 1}], \"springs\": [{\"between\": [\"m\", \"grund\"], \"stiffness\": 1}]}",
    "{\"masses\": [{\"name\": \"m\", \"mass\": 1}], \"springs\": [{\"between\": [\"m\", \"ground\"], \"stiffness\": 1.7e308}, {\"between\": [\"m\", \"ground\"], \"stiffness\": 1.7e308}]}",
    "{\"matrices\": {\"mass\": [[1, 0]]}}",
    "{\"matrices\": {\"mass\": [[1, 0], [0]]}}",
    "{\"matrices\": {\"mass\": \"mass.mtx\"}}",
    "{\"matrices\": {\"mass\": \".\"}}",
    "{\"matrices\": {\"mass\": \"upper.mtx\"}}",
    "{\"masses\": [{\"name\": \"m\", \"mass\": 1}], \"initial\": {\"ground\": {\"velocity\": 1}}}",
    "{\"masses\": [{\"name\": \"m\", \"mass\": 1}], \"loads\": [{\"on\": \"m\"}]}",
    "{\"masses\": [{\"name\": \"m\", \"mass\": 1}], \"loads\": [{\"on\": \"m\", \"step\": {\"force\": 1}, \"ramp\": {\"rate\": 1}}]}",
    "{\"masses\": [{\"name\": \"m\", \"mass\": 1}], \"loads\": [{\"on\": \"m\", \"impulse\": {\"magnitude\": 1, \"at\": -1}}]}",
    "{\"masses\": [{\"name\": \"m\", \"mass\": 1}], \"loads\": [{\"on\": \"m\", \"samples\": {\"step\": 1, \"values\": [], \"hold\": \"zero\"}}]}",
    "{\"masses\": [{\"name\": \"m\", \"mass\": 1}], \"loads\": [{\"on\": \"m\", \"samples\": {\"step\": 0, \"values\": [1], \"hold\": \"zero\"}}]}",
    "{\"masses\": [{\"name\": \"m\", \"mass\": 1}], \"loads\": [{\"on\": \"m\", \"samples\": {\"step\": 0.15, \"values\": [1], \"hold\": \"zero\"}}], \"time\": {\"end\": 1, \"step\": 0.1}}",
    "{\"masses\": [{\"name\": \"m\", \"mass\": 1}], \"time\": {\"end\": 1, \"step\": 0}}",
    "{\"masses\": [{\"name\": \"m\", \"mass\": 1}], \"time\": {\"end\": -1, \"step\": 1}}",
    "{\"masses\": [{\"name\": \"m\", \"mass\": 1}], \"time\": {\"end\": 1e300, \"step\": 1}}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}, {\"name\": \"p\", \"mass\": 0}], \"springs\": [{\"between\": [\"p\", \"a\"], \"stiffness\": 1}], \"initial\": {\"p\": {\"displacement\": 1}}}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}, {\"name\": \"p\", \"mass\": 0}], \"dampers\": [{\"between\": [\"p\", \"a\"], \"damping\": 1}], \"initial\": {\"p\": {\"velocity\": 1}}}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}, {\"name\": \"p\", \"mass\": 0}], \"springs\": [{\"between\": [\"p\", \"a\"], \"stiffness\": 1}], \"loads\": [{\"on\": \"p\", \"impulse\": {\"magnitude\": 1}}]}",
];

const UPPER: &str = "%%MatrixMarket matrix coordinate real symmetric\n2 2 1\n1 2 1\n";

/// The names of an error and of those inside of it, as their `Debug` texts begin.
fn variants(error: &SceneError) -> Vec<String> {
    let name = |text: String| {
        let end = text.find(|c: char| !c.is_alphanumeric());
        text[..end.unwrap_or(text.len())].to_owned()
    };
    let mut all = vec![format!("SceneError::{}", name(format!("{error:?}")))];
    match error {
        SceneError::Matrix { source, .. } => {
            all.push(format!(
                "MatrixMarketError::{}",
                name(format!("{source:?}"))
            ));
        }
        SceneError::System { source, .. } => {
            all.push(format!("BuildError::{}", name(format!("{source:?}"))));
        }
        SceneError::Response { source, .. } => {
            all.push(format!("ResponseError::{}", name(format!("{source:?}"))));
            if let eigentone::response::ResponseError::Load { error, .. } = &**source {
                all.push(format!("LoadError::{}", name(format!("{error:?}"))));
            }
        }
        _ => {}
    }
    all
}

/// The variants of an error in its source file.
fn declared(file: &str, error: &str) -> Vec<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{file}: {error}"));
    let (_, rest) = text
        .split_once(&format!("pub enum {error} {{"))
        .expect("it is declared there");
    let body = rest.split("\n}").next().expect("it ends");
    let variant = |line: &str| {
        let name = line.strip_prefix("    ")?;
        let end = name.find(|c: char| !c.is_alphanumeric())?;
        let is_name = name.starts_with(|c: char| c.is_ascii_uppercase());
        is_name.then(|| format!("{error}::{}", &name[..end]))
    };
    body.lines().filter_map(variant).collect()
}

fn folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("errors");
    fs::create_dir_all(&folder).expect("it can be made");
    fs::write(folder.join("upper.mtx"), UPPER).expect("it can be written");
    folder
}

#[test]
fn every_error_of_a_scene_is_listed() {
    let folder = folder();
    let mut shown = BTreeSet::new();
    let mut page = String::from(
        "# What can be wrong with a scene\n\nEach message with a scene that gives it. All end with status 2, and nothing is written. \
         A test writes this page and fails where a kind of error is missing.\n\n| scene | message |\n| :-- | :-- |\n",
    );
    let mut list = |input: &str, error: SceneError| {
        shown.extend(variants(&error));
        let message = error.to_string();
        let message = message.replace(&format!("{}/", folder.display()), "");
        let message = message.replace(&folder.display().to_string(), "scenes");
        assert!(message.len() > 30 && !message.contains('\n'), "{message}");
        let cell = |text: &str| text.replace('|', "\\|");
        writeln!(
            page,
            "| `{}` | {} |",
            cell(input),
            cell(&message).replace('<', "&lt;")
        )
        .expect("strings take text");
    };
    for text in SCENES {
        let error = Scene::parse(text, &folder.join("scene.json")).expect_err(text);
        list(if text.is_empty() { " " } else { text }, error);
    }
    list(
        "(no such file)",
        Scene::read(&folder.join("lost.json")).expect_err("lost"),
    );
    list(
        "(a directory)",
        Scene::read(&folder).expect_err("a directory"),
    );
    let latin = folder.join("latin.json");
    fs::write(&latin, b"{\"title\": \"\xe4\"}").expect("it can be written");
    list(
        "(not in UTF-8)",
        Scene::read(&latin).expect_err("not UTF-8"),
    );

    let own = [
        ("crates/eigentone/scene/error.rs", "SceneError"),
        (
            "crates/eigentone/scene/matrix_market.rs",
            "MatrixMarketError",
        ),
        ("crates/modes/src/builder.rs", "BuildError"),
        ("crates/response/src/load.rs", "LoadError"),
    ];
    let not_shown = |name: &String| NOT_SHOWN.iter().any(|(known, _)| known == name);
    for (file, error) in own {
        for name in declared(file, error) {
            assert!(shown.contains(&name) != not_shown(&name), "{name}");
        }
    }
    page += "\nNot shown, for want of a small example:\n\n";
    for (name, reason) in NOT_SHOWN {
        writeln!(page, "- `{name}`: {reason}").expect("strings take text");
    }
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/errors.md");
    if std::env::var_os("EIGENTONE_WRITE_DOCS").is_some() {
        fs::write(&file, &page).expect("it can be written");
    }
    let written = fs::read_to_string(&file).unwrap_or_default();
    assert!(
        written == page,
        "docs/errors.md is out of date: EIGENTONE_WRITE_DOCS=1 writes it anew"
    );
}
