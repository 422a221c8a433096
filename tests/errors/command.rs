//! Everything that the command says when it has no result, with the arguments that make it say so.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};

use super::listing::Listing;

pub const ENUMS: [(&str, &str); 2] = [
    ("crates/eigentone/command/failure.rs", "Failure"),
    ("crates/eigentone/command/slepc.rs", "SlepcError"),
];

const LEFT_OUT: [(&str, &str); 1] = [(
    "SlepcError::Scratch",
    "names a directory that no two runs share, which cannot be made or is full, and says to name another by --scratch",
)];

/// What stands in for Python and MPI where SLEPc is asked for.
const PROGRAMS: [(&str, &str); 7] = [
    ("python", "echo eigentone f"),
    (
        "as-root",
        "echo mpirun has detected an attempt to run as root. >&2; exit 1",
    ),
    ("few-slots", "echo There are not enough slots >&2; exit 1"),
    (
        "failing",
        "echo 'eigentone: failed: out of memory' >&2; exit 1",
    ),
    ("hanging", "exec sleep 60"),
    ("cut-off", ": > $5/answer.bin"),
    (
        "empty",
        "printf 'EIGENT\\001\\n\\001\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0' > $5/answer.bin",
    ),
];

/// What goes wrong, and the arguments; S stands for a scene.
const CASES: [(&str, &str); 55] = [
    ("Scene", "modes lost.json"),
    ("NoTime", "response still.json"),
    (
        "ToleranceInDoubles",
        "modes S --precision double --tolerance 1e-9",
    ),
    ("Large", "modes large.json"),
    ("Memory", "response S --memory-limit 1e-6"),
    ("Sparse", "modes dashpot.json --lowest 1"),
    ("Modes", "modes far-apart.json"),
    ("EngineForAll", "modes S --engine slepc"),
    (
        "SlepcError::Missing",
        "modes S --engine slepc --lowest 1 --python ./lost",
    ),
    (
        "SlepcError::Launcher",
        "modes S --engine slepc --lowest 1 --python ./python --launcher ./lost",
    ),
    (
        "SlepcError::Root",
        "modes S --engine slepc --lowest 1 --python ./python --launcher ./as-root",
    ),
    (
        "SlepcError::Slots",
        "modes S --engine slepc --lowest 1 --python ./python --launcher ./few-slots --ranks 9",
    ),
    (
        "SlepcError::Ended",
        "modes S --engine slepc --lowest 1 --python ./python --launcher ./failing",
    ),
    (
        "SlepcError::TimeLimit",
        "modes S --engine slepc --lowest 1 --python ./python --launcher ./hanging --time-limit 0.1",
    ),
    (
        "SlepcError::Answer",
        "modes S --engine slepc --lowest 1 --python ./python --launcher ./cut-off",
    ),
    (
        "SlepcError::Nothing",
        "modes S --engine slepc --lowest 1 --python ./python --launcher ./empty",
    ),
    ("Response", "response growing.json"),
    ("Response", "response S --steps 0,99"),
    ("Switching", "response beyond.json"),
    ("Switches", "tables beyond.json --out tables"),
    ("Cycle", "cycle growing.json --cycles 1"),
    ("Frequency", "frf dashpot.json --from m0"),
    ("UnknownName", "frf S --to wall"),
    ("", "frf S --at 1,x"),
    ("StateSpace", "export far-apart.json"),
    ("NoSuchScene", "scenes three-mas"),
    ("NoSuchMethod", "check S --methods newmork"),
    ("LossFactor", "export rubber.json"),
    ("NoNoise", "random S"),
    ("HoldWithoutStep", "export S --step 0.1"),
    ("Record", "spectrum record.csv --step 0.01 --column ay"),
    (
        "Spectrum",
        "spectrum record.csv --step 0.01 --from 1e-200 --column ax",
    ),
    (
        "Frequencies",
        "spectrum record.csv --step 0.01 --from 5 --to 1",
    ),
    ("", "spectrum record.csv --step 0"),
    ("", "campbell rotor.json --speeds 0:1e300:3"),
    ("Campbell", "campbell S --speeds 2,1"),
    ("", "campbell S --speeds 1"),
    ("", "campbell S --speeds 1:2"),
    ("Study", "sweep S --vary m.mas=1:2:3"),
    ("Parts", "merge ."),
    ("Study", "optimise S --vary m.mass=-2:-1 --minimise damping"),
    ("", "optimise S --vary m.mass=2:1 --minimise damping"),
    ("Record", "fit S --vary m.mass --to record.csv"),
    ("Study", "fit S --vary m.mas --to record.csv"),
    ("Table", "tables late.json --out tables --steps 1,9999"),
    ("Table", "tables S --out tables --steps 99"),
    ("OverScene", "analyze results/modes.json --out results"),
    ("Write", "analyze S --out a-file"),
    ("Write", "analyze S --out /dev/null/results"),
    ("Output", "modes S > /dev/full"),
    ("", "modes S --tolerance 1e-17"),
    ("", "modes S --near x"),
    ("", "response S --steps 1.5"),
    ("", "modes S --memory-limit 0"),
    ("", "stability --only friction"),
];

fn files(folder: &Path) {
    let write = |name: &str, text: &str| {
        fs::write(folder.join(name), text).expect("it can be written");
    };
    let one = |mass: &str, more: &str| {
        format!("{{\"masses\": [{{\"name\": \"m\", \"mass\": {mass}}}], {more}}}")
    };
    let spring = |stiffness: &str| {
        format!("\"springs\": [{{\"between\": [\"ground\", \"m\"], \"stiffness\": {stiffness}}}]")
    };
    let damper = |damping: &str| {
        format!("\"dampers\": [{{\"between\": [\"ground\", \"m\"], \"damping\": {damping}}}]")
    };
    let moving = "\"initial\": {\"m\": {\"displacement\": 1}}";
    let time = |end: &str, step: &str| format!("\"time\": {{\"end\": {end}, \"step\": {step}}}");
    let scene = one("1", &format!("{}, {}", spring("4"), time("1", "0.1")));
    write("scene.json", &scene);
    write("still.json", &one("1", &spring("4")));
    write("far-apart.json", &one("5e-324", &spring("1e308")));
    let rubber = spring("4").replace("4}", "4, \"loss_factor\": 0.1}");
    write("rubber.json", &one("1", &rubber));
    let wall =
        "\"impacts\": [{\"between\": [\"ground\", \"m\"], \"gap\": 0.5, \"restitution\": 1}]";
    let beyond = format!("{}, {moving}, {wall}, {}", spring("4"), time("1", "0.1"));
    write("beyond.json", &one("1", &beyond));
    let rotor = "{\"masses\": [{\"name\": \"x\", \"mass\": 1}, {\"name\": \"y\", \"mass\": 1}], \"matrices\": {\"damping\": [[0, 1], [-1, 0]], \"stiffness\": [[4, 0], [0, 5]]}}";
    write("rotor.json", rotor);
    write("record.csv", "t,ax\n0,0\n0.01,1\n");
    let growing = format!("{}, {moving}, {}", spring("-400"), time("100", "1"));
    write("growing.json", &one("1", &growing));
    let held = format!("{}, {}", spring("2.6"), damper("2.4"));
    let late = format!("{held}, {moving}, {}", time("1000", "0.1"));
    write("late.json", &one("0.5", &late));
    // Beyond 400 coordinates some modes are found without the others.
    let names: Vec<String> = (0..401).map(|i| format!("m{i}")).collect();
    let network = |names: &[String], mass: &str| {
        let list = |each: &dyn Fn(&String) -> String| {
            names.iter().map(each).collect::<Vec<_>>().join(", ")
        };
        let masses = list(&|name| format!("{{\"name\": \"{name}\", \"mass\": {mass}}}"));
        let of = |key: &str| {
            list(&|name| format!("{{\"between\": [\"ground\", \"{name}\"], \"{key}\": 1}}"))
        };
        let (springs, dampers) = (of("stiffness"), of("damping"));
        format!("{{\"masses\": [{masses}], \"springs\": [{springs}], \"dampers\": [{dampers}]}}")
    };
    write("dashpot.json", &network(&names, "0"));
    let names: Vec<String> = (0..5000).map(|i| format!("m{i}")).collect();
    write("large.json", &network(&names, "1"));
    fs::create_dir_all(folder.join("results")).expect("it can be made");
    fs::write(folder.join("results/modes.json"), &scene).expect("it can be written");
    write("a-file", "mine");
    for (name, lines) in PROGRAMS {
        use std::os::unix::fs::PermissionsExt;
        write(name, &format!("#!/bin/sh\n{lines}\n"));
        let program = fs::Permissions::from_mode(0o755);
        fs::set_permissions(folder.join(name), program).expect("it can be made a program");
    }
}

/// The first line of what it says, and its exit status; `None` where it answers.
fn run(folder: &Path, arguments: &str) -> Option<(String, i32)> {
    let (arguments, full) = match arguments.split_once(" > ") {
        Some((arguments, file)) => (arguments, Some(file)),
        None => (arguments, None),
    };
    let arguments = arguments.split(' ').map(|word| match word {
        "S" => "scene.json",
        word => word,
    });
    let out = match full {
        Some(file) => Stdio::from(File::options().write(true).open(file).expect("it is there")),
        None => Stdio::null(),
    };
    let output = Command::new(env!("CARGO_BIN_EXE_eigentone"))
        .args(arguments)
        .current_dir(folder)
        .stdout(out)
        .output()
        .expect("the binary runs");
    let said = String::from_utf8(output.stderr).expect("UTF-8");
    let line = said.lines().next().unwrap_or_default();
    let line = line.strip_prefix("error: ")?.to_owned();
    Some((line, output.status.code()?))
}

#[test]
fn every_failure_of_a_command_is_listed() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("failures");
    fs::create_dir_all(&folder).expect("it can be made");
    files(&folder);
    let mut listing = Listing::headed(["arguments", "status, message"]);
    for (kind, arguments) in CASES {
        let asked = arguments.replace(" S", " scene.json");
        let Some((line, status)) = run(&folder, arguments) else {
            listing.answered(&asked);
            continue;
        };
        listing.row(&asked, &format!("{status}: {line}"));
        // Whose errors are passed on shows both.
        match kind.split_once("Error::") {
            Some((passed_on, _)) => {
                listing.show(kind.to_owned());
                listing.show(format!("Failure::{passed_on}"));
            }
            None => listing.show(format!("Failure::{kind}")),
        }
    }
    let table = listing.finish(&ENUMS, &LEFT_OUT);
    super::page::assert_shown("errors.md", "command", &table);
}
