//! The reference tables: every printed digit against answers that other programs gave, and the files in
//! `docs/tables` against what the command writes.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use eigentone::gallery::{cases, machines};
use eigentone::modes::{CoordinateKind, GROUND, System};
use eigentone::response::{Response, State, Step};
use eigentone::tables::{DIGITS, ModeTable, ResponseTable, TableError, Value};
use serde_json::Value as Json;
use serde_json::value::RawValue;

/// Sign, digits without zeros at either end, and the power of ten of the first.
#[derive(Debug, PartialEq, Eq)]
struct Decimal {
    negative: bool,
    digits: String,
    exponent: i64,
}

impl Decimal {
    fn read(text: &str) -> Decimal {
        let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
        let exponent: i64 = exponent.parse().expect("a whole exponent");
        let (negative, mantissa) = match mantissa.strip_prefix('-') {
            Some(rest) => (true, rest),
            None => (false, mantissa),
        };
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let all = format!("{whole}{fraction}");
        assert!(all.bytes().all(|c| c.is_ascii_digit()), "{text}");
        let zeros = all.bytes().take_while(|c| *c == b'0').count();
        let digits = all[zeros..].trim_end_matches('0').to_owned();
        let exponent = exponent + whole.len() as i64 - 1 - zeros as i64;
        Decimal {
            negative: negative && !digits.is_empty(),
            exponent: if digits.is_empty() { 0 } else { exponent },
            digits,
        }
    }

    /// Rounded to nearest by hand; the digits must leave no doubt.
    fn rounded(self) -> Decimal {
        let Some((kept, rest)) = self.digits.split_at_checked(DIGITS) else {
            return self;
        };
        let doubt =
            |tail: &str| tail.len() > 12 && tail[..12].bytes().all(|c| c == tail.as_bytes()[0]);
        assert!(rest != "5" && !(rest.starts_with('5') && doubt(&format!("{}0", &rest[1..]))));
        let mut number: u64 = kept.parse().expect("fifteen digits");
        if rest.as_bytes().first().is_some_and(|digit| *digit >= b'5') {
            number += 1;
        }
        let text = number.to_string();
        Decimal {
            exponent: self.exponent + (text.len() - DIGITS) as i64,
            digits: text.trim_end_matches('0').to_owned(),
            ..self
        }
    }
}

/// Holds what is printed against a longer number.
#[track_caller]
fn check(printed: &str, truth: &str, what: &str) {
    let significant = printed.split('e').next().unwrap_or(printed);
    let digits = significant.trim_start_matches(['-', '0', '.']);
    let count = digits.bytes().filter(u8::is_ascii_digit).count();
    assert!(
        count == DIGITS || printed == "0" || printed == "1",
        "{what}: {printed} has {count} digits"
    );
    let rounded = Decimal::read(truth).rounded();
    assert_eq!(
        Decimal::read(printed),
        rounded,
        "{what}: {printed} is not {truth}"
    );
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A table of `docs/tables/NAME.json`, its numbers as they are printed.
fn rows(name: &str, table: &str) -> Vec<BTreeMap<String, String>> {
    let file = root().join(format!("docs/tables/{name}.json"));
    let text = fs::read_to_string(file).expect("it is there");
    let all: BTreeMap<String, Box<RawValue>> = serde_json::from_str(&text).expect("JSON");
    let rows: Option<Vec<BTreeMap<String, Box<RawValue>>>> =
        serde_json::from_str(all[table].get()).expect("rows");
    let plain = |value: Box<RawValue>| value.get().trim_matches('"').to_owned();
    let row = |row: BTreeMap<String, Box<RawValue>>| {
        row.into_iter()
            .map(|(key, value)| (key, plain(value)))
            .collect()
    };
    rows.into_iter().flatten().map(row).collect()
}

#[test]
fn every_digit_of_every_motion_is_that_of_the_34_digit_answers() {
    let mut checked = 0;
    for case in cases() {
        let truth = case.truth();
        let printed = rows(case.name(), "response");
        assert_eq!(
            printed.len(),
            truth.response.len() * truth.coordinates.len()
        );
        let mut printed = printed.iter();
        for sample in &truth.response {
            for (i, coordinate) in truth.coordinates.iter().enumerate() {
                let row = printed.next().expect("counted");
                let what = format!("{} {coordinate} at {}", case.name(), sample.step);
                assert_eq!(row["step"], sample.step.to_string());
                assert_eq!(&row["coordinate"], coordinate);
                check(&row["displacement"], sample.displacement[i].as_str(), &what);
                check(&row["velocity"], sample.velocity[i].as_str(), &what);
                checked += 2;
            }
        }
    }
    assert!(checked > 400, "{checked}");
}

/// Points, supports, beams, and pulses, whose rates are multiples of π.
#[test]
fn every_digit_of_the_motion_of_machines_is_right() {
    for case in machines() {
        let (name, scene, truth) = (case.name(), case.scene(), case.truth());
        let steps: Vec<u64> = truth.response.iter().map(|sample| sample.step).collect();
        let problem = scene.problem().expect("it has times").expect(name);
        let problem = problem.at(&steps).expect(name);
        let table = ResponseTable::of(&problem).unwrap_or_else(|error| panic!("{name}: {error}"));
        for (row, sample) in table.rows().iter().zip(&truth.response) {
            let found = row.displacement.iter().chain(&row.velocity);
            let known = sample.displacement.iter().chain(&sample.velocity);
            for (k, (found, known)) in found.zip(known).enumerate() {
                let what = format!("{name}, number {k} of step {}", sample.step);
                check(&found.to_string(), known.as_str(), &what);
            }
        }
        let kinds: BTreeSet<_> = (0..scene.system().len())
            .map(|i| scene.system().kind_of(i) == CoordinateKind::Rotation)
            .collect();
        let units = match (kinds.contains(&false), kinds.contains(&true)) {
            (true, false) => "step,time [s],coordinate,displacement [m],velocity [m/s]",
            (false, _) => "step,time [s],coordinate,displacement [rad],velocity [rad/s]",
            _ => "step,time [s],coordinate,unit,displacement,velocity",
        };
        assert_eq!(table.csv().lines().next(), Some(units), "{name}");
    }
}

#[test]
fn every_eigenvalue_has_the_digits_of_the_34_digit_answers() {
    for case in cases() {
        let truth = case.truth().eigenvalues;
        let mut left: Vec<_> = truth
            .iter()
            .filter(|root| root.im.to_f64() >= 0.0)
            .collect();
        for row in rows(case.name(), "modes") {
            let number = |key: &str| row[key].parse::<f64>().expect("a number");
            let (re, im) = (number("re"), number("im"));
            let same = |root: &&eigentone::gallery::TrueEigenvalue| {
                root.re.minus(re).hypot(root.im.minus(im)) <= 1e-13 * re.hypot(im)
            };
            let count = left.iter().filter(|root| same(root)).count();
            let real = if im == 0.0 { 1 } else { count };
            assert_eq!(
                row["multiplicity"].parse(),
                Ok(count),
                "{} {row:?}",
                case.name()
            );
            assert!(count >= 1 && real >= 1);
            let root = left.iter().find(|root| same(root)).expect("counted");
            check(&row["re"], root.re.as_str(), case.name());
            check(&row["im"], root.im.as_str(), case.name());
            left.retain(|root| !same(root));
        }
        assert!(
            left.is_empty(),
            "{}: {} are missing",
            case.name(),
            left.len()
        );
    }
}

#[test]
fn every_digit_that_follows_from_eigenvalues_and_shapes_is_right() {
    let text = fs::read_to_string(root().join("tests/tables/modes.json")).expect("it is there");
    let truth: BTreeMap<String, Vec<Json>> = serde_json::from_str(&text).expect("JSON");
    assert_eq!(truth.len(), cases().len());
    for case in cases() {
        let name = case.name();
        let (modes, shapes) = (rows(name, "modes"), rows(name, "shapes"));
        assert_eq!(modes.len(), truth[name].len(), "{name}");
        let mut shapes = shapes.iter();
        for (k, (mode, truth)) in modes.iter().zip(&truth[name]).enumerate() {
            let what = format!("{name}, mode {}", k + 1);
            for (key, known) in [
                ("re", "re"),
                ("im", "im"),
                ("natural_frequency", "natural_frequency"),
                ("hertz", "hertz"),
                ("damped_frequency", "im"),
                ("damping_ratio", "damping_ratio"),
            ] {
                match &truth[known] {
                    Json::Null => assert_eq!(mode[key], "null", "{what}: {key}"),
                    known => check(&mode[key], known.as_str().expect("digits"), &what),
                }
            }
            let re = truth["re"].as_str().expect("digits");
            let rate = match re.strip_prefix('-') {
                Some(rate) => rate.to_owned(),
                None => format!("-{re}"),
            };
            check(&mode["decay_rate"], &rate, &what);
            for component in truth["shape"].as_array().into_iter().flatten() {
                let row = shapes.next().expect("as many components");
                assert_eq!(row["mode"], (k + 1).to_string());
                check(&row["re"], component[0].as_str().expect("digits"), &what);
                check(&row["im"], component[1].as_str().expect("digits"), &what);
            }
        }
        assert!(shapes.next().is_none(), "{name}");
    }
}

/// Names and contents of all files in a directory.
fn files(directory: &Path) -> BTreeMap<String, String> {
    let entries = fs::read_dir(directory).expect("a directory");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let name = |path: &PathBuf| {
        path.file_name()
            .expect("a name")
            .to_string_lossy()
            .into_owned()
    };
    paths
        .map(|path| (name(&path), fs::read_to_string(&path).expect("text")))
        .collect()
}

fn fresh(name: &str) -> PathBuf {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    if directory.is_dir() {
        fs::remove_dir_all(&directory).expect("it can be removed");
    } else if directory.exists() {
        fs::remove_file(&directory).expect("it can be removed");
    }
    directory
}

fn eigentone(arguments: &[&str], out: &Path) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_eigentone"))
        .current_dir(root())
        .arg("tables")
        .args(arguments)
        .arg("--out")
        .arg(out)
        .output()
        .expect("the binary runs")
}

#[test]
fn docs_tables_are_what_the_command_writes() {
    let directory = fresh("tables");
    let output = eigentone(&[], &directory);
    assert!(output.status.success() && output.stdout.is_empty() && output.stderr.is_empty());
    let (written, committed) = (files(&directory), files(&root().join("docs/tables")));
    let names = |files: &BTreeMap<String, String>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&written), names(&committed));
    for (name, text) in &written {
        assert!(
            committed[name] == *text,
            "docs/tables/{name}: run `eigentone tables --out docs/tables`"
        );
    }
}

#[test]
fn all_forms_of_a_table_have_the_same_digits() {
    let tables = files(&root().join("docs/tables"));
    for case in cases() {
        let name = case.name();
        let [markdown, latex] = ["md", "tex"].map(|ending| &tables[&format!("{name}.{ending}")]);
        for table in ["modes", "shapes", "response"] {
            let csv = tables.get(&format!("{name}-{table}.csv"));
            for row in rows(name, table) {
                for (key, value) in row {
                    if key == "coordinate" || value == "null" {
                        continue;
                    }
                    assert!(
                        markdown.contains(&format!("| {value} |")),
                        "{name}: {key} {value}"
                    );
                    assert!(latex.contains(value.split('e').next().expect("a part")));
                    let csv = csv.expect("it is there");
                    let cell = |c: &str| csv.contains(&format!("{c}{value},"));
                    let last = csv.contains(&format!(",{value}\r\n"));
                    assert!(cell(",") || cell("\n") || last, "{name}: {key} {value}");
                }
            }
        }
    }
}

#[test]
fn a_scene_of_ones_own_has_tables_at_the_instants_asked_for() {
    let directory = fresh("tables-own");
    let scene = "tests/gallery/scenes/two-mass-free.json";
    let output = eigentone(&[scene, "--steps", "1000,1"], &directory);
    assert!(output.status.success());
    let written = files(&directory);
    assert_eq!(written.len(), 6);
    let motion: Vec<&str> = written["two-mass-free-response.csv"].lines().collect();
    assert!(motion[1].starts_with("1000,50,m1,") && motion[3].starts_with("1,0.05,m1,"));

    let output = eigentone(&[scene, "--steps", "1001"], &fresh("tables-beyond"));
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("1001 is beyond the last one, 1000"));
    // Nothing is written beside what cannot be written.
    let file = fresh("tables-file");
    fs::write(&file, "in the way").expect("it can be written");
    let output = eigentone(&[scene], &file);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert_eq!(error.lines().count(), 1);
}

fn chain(stiffness: f64) -> System {
    let nodes = [GROUND, "a", "b", "c", GROUND];
    let builder = System::builder()
        .mass("a", 1.0)
        .mass("b", 1.0)
        .mass("c", 1.0);
    let builder = nodes.windows(2).fold(builder, |builder, ends| {
        let builder = builder.spring(ends[0], ends[1], stiffness);
        builder.damper(ends[0], ends[1], 0.1)
    });
    builder.build().expect("a system")
}

#[test]
fn what_is_exactly_zero_is_printed_as_zero() {
    let system = chain(1.0);
    let modes = ModeTable::of(&system).expect("a table");
    let shape = modes.rows()[1].shape.as_ref().expect("one shape");
    assert!(shape[1].0.is_zero() && shape.iter().all(|(_, im)| im.is_zero()));
    let problem = Response::of(&system)
        .from(State::at_rest().displace("a", 1.0).displace("c", -1.0))
        .load("b", Step::of(1.0).starting_at(5.0))
        .every(1.0)
        .until(10.0)
        .problem()
        .expect("a problem");
    let table = ResponseTable::of(&problem).expect("a table");
    let middle: Vec<String> = table
        .rows()
        .iter()
        .map(|row| row.displacement[1].to_string())
        .collect();
    assert!(middle[..6].iter().all(|text| text == "0"), "{middle:?}");
    assert!(
        middle[6..].iter().all(|text| text.len() >= 15),
        "{middle:?}"
    );
    assert!(
        !table
            .rows()
            .iter()
            .any(|row| row.velocity.iter().any(Value::is_open))
    );
}

#[test]
fn a_zero_that_is_not_proved_is_given_by_a_bound() {
    // A free mass passes through 0 at 2 s: 1 − t/2.
    let system = System::builder()
        .mass("m", 1.0)
        .mass("n", 1.0)
        .spring(GROUND, "n", 1.0);
    let system = system.build().expect("a system");
    let problem = Response::of(&system)
        .from(
            State::at_rest()
                .displace("m", 1.0)
                .push("m", -0.5)
                .displace("n", 1.0),
        )
        .every(1.0)
        .until(4.0)
        .problem()
        .expect("a problem");
    let table = ResponseTable::of(&problem).expect("a table");
    let [row, other] = [2, 3].map(|k| &table.rows()[k].displacement[0]);
    assert!(row.is_zero() || row.is_open(), "{row}");
    assert_eq!(row.to_f64(), 0.0);
    assert_eq!(other.to_string(), "-0.500000000000000");
}

#[test]
fn a_number_at_a_rounding_boundary_is_exact_or_refused() {
    // √k = 1 + 2^-26 + 2^-53 + …: k = (1 + 2^-26)² exactly gives ω_n = 1 + 2^-26.
    let root = 1.0 + f64::EPSILON * 67_108_864.0;
    let one = |stiffness: f64| {
        let system = System::builder()
            .mass("m", 1.0)
            .spring(GROUND, "m", stiffness);
        ModeTable::of(&system.build().expect("a system"))
    };
    assert!(root * root > 1.0);
    let table = one(root * root).expect("it is decided");
    assert_eq!(
        table.rows()[0].natural_frequency.to_string(),
        "1.00000001490116"
    );
    // 2^-22 has sixteen digits, the last of which is a 5: an exact tie goes away from 0.
    let tie = 2f64.powi(-44);
    match one(tie) {
        Ok(table) => {
            let printed = table.rows()[0].natural_frequency.to_string();
            assert_eq!(printed, "2.38418579101563e-7");
        }
        Err(error) => assert!(matches!(error, TableError::Undecided { .. }), "{error}"),
    }
}
