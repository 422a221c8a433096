//! Every message that a user or a caller can meet, read once by eye: `docs/errors.md` lists each with what gives it.
//! `EIGENTONE_WRITE_DOCS=1 cargo test --release --test errors` writes the page anew.

// What the system says of files is worded elsewhere in other ways.
#![cfg(target_os = "linux")]

#[path = "errors/command.rs"]
mod command;
#[path = "errors/library.rs"]
mod library;
#[path = "errors/listing.rs"]
mod listing;
mod page;
#[path = "errors/sentences.rs"]
mod sentences;

use std::fs;
use std::path::{Path, PathBuf};

use eigentone::scene::{Scene, SceneError};

use listing::{Listing, kind};

/// What would take an input that no test should make, with the reason.
const NOT_SHOWN: &[(&str, &str)] = &[
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
    (
        "BuildError::PointNotFinite",
        "a scene has finite numbers only",
    ),
    (
        "BuildError::DampingNotFinite",
        "a scene has finite numbers only",
    ),
    (
        "BuildError::PointMoves",
        "SceneError::UnknownName says it with the nearest name",
    ),
    (
        "BuildError::NotASupport",
        "SceneError::UnknownName says it with the nearest name",
    ),
    ("BuildError::FollowSize", "takes thousands of masses"),
    ("BuildError::ModalSize", "takes thousands of masses"),
    (
        "LoadError::ImpulseOfMotion",
        "\"impulse\" is no kind of a motion in a scene",
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
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"points\": [{\"name\": \"a\", \"moves\": {\"road\": 1}}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"points\": [{\"name\": \"p\", \"moves\": {\"b\": 1}}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"points\": [{\"name\": \"p\", \"moves\": {\"p\": 1}}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"points\": [{\"name\": \"p\", \"moves\": {\"q\": 1}}, {\"name\": \"q\", \"moves\": {\"a\": 1}}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"points\": [{\"name\": \"p\", \"moves\": {}}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"points\": [{\"name\": \"p\", \"moves\": {\"a\": 1}}], \"initial\": {\"p\": {\"displacement\": 1}}}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"points\": [{\"name\": \"p\", \"moves\": {\"a\": 1e300}, \"mass\": 1}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"loads\": [{\"on\": \"road\", \"step\": {\"force\": 1}}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"loads\": [{\"on\": \"a\", \"half_sine\": {\"force\": 1, \"duration\": 0}}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"loads\": [{\"on\": \"a\", \"versine\": {\"force\": 1, \"duration\": 1, \"start\": -1}}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"loads\": [{\"on\": \"a\", \"polynomial\": {\"coefficients\": []}}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"loads\": [{\"on\": \"a\", \"polynomial\": {\"coefficients\": [0, 1e306]}}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"motions\": [{\"of\": \"a\", \"displacement\": {\"step\": {\"height\": 1}}}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"motions\": [{\"of\": \"road\"}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"motions\": [{\"of\": \"road\", \"displacement\": {}}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"points\": [{\"name\": \"p\", \"moves\": {\"a\": 1, \"road\": 1}, \"mass\": 1}], \"motions\": [{\"of\": \"road\", \"displacement\": {\"step\": {\"height\": 1}}}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"outputs\": [{\"name\": \"o\"}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"outputs\": [{\"name\": \"o\", \"displacement\": {}}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"outputs\": [{\"name\": \"o\", \"force\": \"tire\"}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"outputs\": [{\"name\": \"\", \"force\": \"tyre\"}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"dampers\": [{\"between\": [\"road\", \"a\"], \"damping\": 1, \"name\": \"tyre\"}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"damping\": {\"rayleigh\": {\"mass\": 1, \"relative_to\": \"soil\"}}}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"springs\": [{\"between\": [\"road\", \"a\"], \"stiffness\": 9, \"name\": \"tyre\"}], \"damping\": {\"modal\": []}}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"noise\": [{\"of\": \"road\"}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"noise\": [{\"of\": \"road\", \"force\": 1}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"noise\": [{\"on\": \"a\", \"velocity\": 1}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"noise\": [{\"of\": \"road\", \"velocity\": -1}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"supports\": [\"road\"], \"noise\": [{\"on\": \"a\", \"force\": 1, \"band\": [10, 1]}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"frictions\": [{\"between\": [\"ground\", \"a\"], \"force\": -1}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"controlled_dampers\": [{\"between\": [\"ground\", \"a\"], \"law\": \"clipped skyhook\", \"low\": 0, \"high\": 1}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"controlled_dampers\": [{\"between\": [\"ground\", \"a\"], \"law\": \"on-off skyhook\", \"low\": 0, \"high\": 1, \"sky\": 1}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"frequencies\": {\"from\": 0, \"to\": 10, \"count\": 5}}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"frequencies\": {\"from\": 3, \"to\": 1, \"count\": 5}}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"springs\": [{\"between\": [\"ground\", \"a\"], \"stiffness\": 1, \"loss_factor\": -1}]}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"springs\": [{\"between\": [\"ground\", \"a\"], \"stiffness\": 1, \"loss_factor\": 0.1}], \"time\": {\"end\": 1, \"step\": 0.1}}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"springs\": [{\"between\": [\"ground\", \"a\"], \"stiffness\": 1}], \"damping\": {\"modal\": [0.02, 0.03]}}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}], \"springs\": [{\"between\": [\"ground\", \"a\"], \"stiffness\": -1}], \"damping\": {\"modal\": 0.02}}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}, {\"name\": \"b\", \"mass\": 1}], \"springs\": [{\"between\": [\"ground\", \"a\"], \"stiffness\": 1}, {\"between\": [\"ground\", \"b\"], \"stiffness\": 1}], \"damping\": {\"modal\": [0.02, 0.03]}}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1}, {\"name\": \"b\", \"mass\": 1}], \"supports\": [\"soil\"], \"springs\": [{\"between\": [\"soil\", \"a\"], \"stiffness\": 1}, {\"between\": [\"ground\", \"a\"], \"stiffness\": 1}], \"damping\": {\"rayleigh\": {\"mass\": 1, \"relative_to\": \"soil\"}}}",
    "{\"masses\": [{\"name\": \"a\", \"mass\": 1e300}], \"springs\": [{\"between\": [\"ground\", \"a\"], \"stiffness\": 1}], \"damping\": {\"rayleigh\": {\"mass\": 1e300}}}",
    "{\"beams\": [{\"name\": \"mast\", \"length\": 0, \"elements\": 2, \"flexural_rigidity\": 1, \"mass_per_length\": 1, \"ends\": [\"clamped\", \"free\"]}]}",
    "{\"beams\": [{\"name\": \"mast\", \"length\": 1e-200, \"elements\": 2, \"flexural_rigidity\": 1, \"mass_per_length\": 1, \"ends\": [\"clamped\", \"free\"]}]}",
    "{\"rods\": [{\"name\": \"rod\", \"length\": 1, \"elements\": 0, \"axial_rigidity\": 1, \"mass_per_length\": 1, \"ends\": [\"fixed\", \"free\"]}]}",
];

/// Matrix files of one fault each, beside the scene, as a stiffness matrix.
const MATRICES: &[&str] = &[
    "",
    "%%MatrixMarket matrix coordinate real",
    "%%MatrixMarket vector coordinate real general",
    "%%MatrixMarket matrix dense real general",
    "%%MatrixMarket matrix coordinate complex general",
    "%%MatrixMarket matrix coordinate pattern general",
    "%%MatrixMarket matrix coordinate real hermitian",
    "%%MatrixMarket matrix coordinate real general",
    "%%MatrixMarket matrix coordinate real general\n2 2",
    "%%MatrixMarket matrix coordinate real general\n2 3 1",
    "%%MatrixMarket matrix coordinate real general\n0 0 0",
    "%%MatrixMarket matrix coordinate real general\n99999999 99999999 1",
    "%%MatrixMarket matrix coordinate real general\n2 2 5",
    "%%MatrixMarket matrix coordinate real general\n1000 1000 900000",
    "%%MatrixMarket matrix coordinate real general\n2 2 2\n1 1 1",
    "%%MatrixMarket matrix coordinate real general\n2 2 1\n1 1 1\n2 2 1",
    "%%MatrixMarket matrix coordinate real general\n2 2 1\n1 3 1",
    "%%MatrixMarket matrix coordinate real general\n2 2 1\n1 1",
    "%%MatrixMarket matrix coordinate real general\n2 2 2\n1 1 1\n1 1 2",
    "%%MatrixMarket matrix coordinate real general\n2 2 1\n1 1 1d5",
    "%%MatrixMarket matrix coordinate real general\n2 2 1\n1 1 1e999",
    "%%MatrixMarket matrix coordinate integer general\n2 2 1\n1 1 0.5",
    "%%MatrixMarket matrix coordinate real symmetric\n2 2 1\n1 2 1",
    "%%MatrixMarket matrix coordinate real skew-symmetric\n2 2 1\n1 1 1",
    "%%MatrixMarket matrix array real general\n2 2 4",
    "%%MatrixMarket matrix array real general\n2 2\n1 2\n3 4",
];

/// Files of samples of one fault each, beside the scene, of which the column ax is wanted.
const RECORDS: &[&str] = &[
    "",
    "0.1\n0.2",
    "t,ay\n0,0.1",
    "ax,ax\n0,0.1",
    "t,ax\n0,0.1\n0.02,\n",
    "t,ax\n0,0.1\n0.02\n",
    "t,ax\n0,0.1\n\n0.04,0.2",
    "t;ax\n0;0,1",
    "t ax\n0 nan",
];

const ENUMS: [(&str, &str); 5] = [
    ("crates/eigentone/scene/error.rs", "SceneError"),
    ("crates/eigentone/scene/record.rs", "RecordError"),
    ("crates/eigentone/scene/matrix_error.rs", "MatrixFileError"),
    ("crates/modes/src/system/builder.rs", "BuildError"),
    ("crates/response/src/problem/load.rs", "LoadError"),
];

/// An error and those inside of it.
fn kinds(error: &SceneError) -> Vec<String> {
    let mut all = vec![kind(error)];
    match error {
        SceneError::Matrix { source, .. } => all.push(kind(&**source)),
        SceneError::Record { source, .. } => all.push(kind(&**source)),
        SceneError::System { source, .. } => all.push(kind(&**source)),
        SceneError::Response { source, .. } => {
            all.push(kind(&**source));
            use eigentone::response::ResponseError::{Load, Motion};
            if let Load { error, .. } | Motion { error, .. } = &**source {
                all.push(kind(error));
            }
        }
        _ => {}
    }
    all
}

fn folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("errors");
    fs::create_dir_all(&folder).expect("it can be made");
    folder
}

/// A file of so many bytes that takes no room: nothing but its beginning was written.
fn vast(file: &Path, beginning: &str, bytes: u64) {
    fs::write(file, beginning).expect("it can be written");
    let file = fs::File::options().write(true).open(file);
    file.and_then(|file| file.set_len(bytes))
        .expect("it can be enlarged");
}

#[test]
fn every_error_of_a_scene_is_listed() {
    let folder = folder();
    let mut listing = Listing::headed(["scene", "message"]);
    let mut list = |input: &str, error: SceneError| {
        let message = error.to_string();
        let message = message.replace(&format!("{}/", folder.display()), "");
        let message = message.replace(&folder.display().to_string(), "scenes");
        listing.row(input, &message);
        kinds(&error)
            .into_iter()
            .for_each(|kind| listing.show(kind));
    };
    for text in SCENES {
        let error = Scene::parse(text, &folder.join("scene.json")).expect_err(text);
        list(if text.is_empty() { " " } else { text }, error);
    }
    let file = folder.join("lost.json");
    list("(no such file)", Scene::read(&file).expect_err("lost"));
    list(
        "(a directory)",
        Scene::read(&folder).expect_err("a directory"),
    );
    let null = Scene::read(Path::new("/dev/null"));
    list("(a device)", null.expect_err("no regular file"));
    let file = folder.join("latin.json");
    fs::write(&file, b"{\"title\": \"\xe4\"}").expect("it can be written");
    list("(not in UTF-8)", Scene::read(&file).expect_err("not UTF-8"));
    let file = folder.join("vast.json");
    vast(&file, "{", (64 << 20) + 1);
    list(
        "(more than 64 MiB)",
        Scene::read(&file).expect_err("too large"),
    );
    let matrix = folder.join("k.mtx");
    let scene = "{\"matrices\": {\"mass\": [[1, 0], [0, 1]], \"stiffness\": \"k.mtx\"}}";
    let read = || Scene::parse(scene, &folder.join("scene.json"));
    for text in MATRICES {
        fs::write(&matrix, text).expect("it can be written");
        let lines = if text.is_empty() { " " } else { text }.replace('\n', " ⏎ ");
        list(&format!("k.mtx: {lines}"), read().expect_err(text));
    }
    let head = "%%MatrixMarket matrix coordinate real general\n9999999 9999999 99999999\n";
    vast(&matrix, head, 1 << 30);
    let lines = head.trim_end().replace('\n', " ⏎ ");
    let error = read().expect_err("it is vast");
    list(&format!("k.mtx: {lines} ⏎ …"), error);
    vast(&matrix, head, (4 << 30) + 1);
    let error = read().expect_err("it is vast");
    list("k.mtx: (more than 4 GiB)", error);
    let record = folder.join("ax.csv");
    let scene = "{\"masses\": [{\"name\": \"m\", \"mass\": 1}], \"loads\": [{\"on\": \"m\", \"samples\": \
                 {\"step\": 1, \"values\": {\"file\": \"ax.csv\", \"column\": \"ax\"}, \"hold\": \"first\"}}]}";
    let read = || Scene::parse(scene, &folder.join("scene.json"));
    list("ax.csv: (no such file)", read().expect_err("lost"));
    for text in RECORDS {
        fs::write(&record, text).expect("it can be written");
        let lines = if text.is_empty() { " " } else { text }.replace('\n', " ⏎ ");
        list(&format!("ax.csv: {lines}"), read().expect_err(text));
    }
    vast(&record, "ax\n1\n", (256 << 20) + 1);
    let error = read().expect_err("it is vast");
    list("ax.csv: (more than 256 MiB)", error);
    let folder_for_file = scene.replace("ax.csv", ".");
    let error = Scene::parse(&folder_for_file, &folder.join("scene.json"));
    list("ax.csv: (a directory)", error.expect_err("no file"));
    fs::remove_dir_all(&folder).expect("it can be removed");
    let table = listing.finish(&ENUMS, NOT_SHOWN);
    page::assert_shown("errors.md", "scene", &table);
}

/// Every type of error has its place in one of the lists.
#[test]
fn no_type_of_error_is_forgotten() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut folders = vec![root.join("crates")];
    let mut found = 0;
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("it can be listed") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            if path.extension().is_none_or(|ending| ending != "rs") {
                continue;
            }
            let text = fs::read_to_string(&path).expect("it can be read");
            let errors = text.split("#[derive(").skip(1);
            let errors = errors.filter(|rest| {
                let derived = rest.split(')').next().unwrap_or_default();
                derived.split(", ").any(|name| name == "Error")
            });
            for rest in errors {
                let Some((_, name)) = rest.split_once("pub enum ") else {
                    continue;
                };
                // What is not public reaches nobody by itself.
                if rest.find("pub(crate) enum ").is_some_and(|at| at < 200) {
                    continue;
                }
                found += 1;
                let name = listing::variant(name);
                let lists = ENUMS.iter().chain(&library::ENUMS).chain(&command::ENUMS);
                let mut known = lists.map(|(file, error)| (root.join(file), *error));
                assert!(
                    known.any(|(file, error)| file == path && error == name),
                    "{name} in {}",
                    path.display()
                );
            }
        }
    }
    assert_eq!(
        found,
        ENUMS.len() + library::ENUMS.len() + command::ENUMS.len() - 2
    );
}
