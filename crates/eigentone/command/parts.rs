//! The files of a sweep: a table that grows while it runs, so that what was ended can go on, beside what it is a table of; and
//! the whole from its parts.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

use eigentone::design::part_of;
use eigentone::report::{SweepReport, SweepTable, SweptDesign};
use serde_json::{Value, json};

use super::Failure;
use super::files::Files;

/// More designs than this are not drawn.
const MOST_DRAWN: u64 = 100_000;

/// A table in a directory, and the question that it answers.
pub struct Part {
    directory: PathBuf,
    question: Value,
    table: SweepTable,
}

/// What goes wrong with the files of a sweep.
fn unfit(file: &Path, message: impl Into<String>) -> Failure {
    Failure::Parts {
        file: file.to_owned(),
        message: message.into(),
    }
}

fn written<T>(file: &Path, result: io::Result<T>) -> Result<T, Failure> {
    result.map_err(|error| Failure::Write {
        file: file.to_owned(),
        error,
    })
}

fn read<T>(file: &Path, result: io::Result<T>) -> Result<T, Failure> {
    result.map_err(|error| unfit(file, format!("cannot be read: {error}")))
}

/// `sweep`, or `sweep.2-of-8`.
fn stem(part: u64, parts: u64) -> String {
    match parts {
        1 => "sweep".to_owned(),
        _ => format!("sweep.{part}-of-{parts}"),
    }
}

impl Part {
    /// Of this part of a question, which names everything that its answer depends on.
    pub fn new(directory: &Path, question: Value, table: SweepTable) -> Part {
        Part {
            directory: directory.to_owned(),
            question,
            table,
        }
    }

    fn part(&self) -> [u64; 2] {
        [0, 1].map(|k| self.question["part"][k].as_u64().unwrap_or(1))
    }

    fn file(&self, ending: &str) -> PathBuf {
        let [part, parts] = self.part();
        self.directory.join(stem(part, parts) + ending)
    }

    /// Begins the table, or, to resume, goes on behind the designs that it has: how many these are. `None` where it is complete.
    pub fn open(&self, scene: &Path, resume: bool) -> Result<Option<(Growing, u64)>, Failure> {
        let growing = self.file(".csv.part");
        let known = self.file(".json");
        if resume && known.exists() {
            let text = read(&known, fs::read_to_string(&known))?;
            let answered: Value = serde_json::from_str(&text).unwrap_or_default();
            same(
                &known,
                &answered,
                &self.question,
                "take another directory, or leave --resume out",
            )?;
            let whole = self.file(".csv");
            if !growing.exists() && whole.exists() {
                let designs = self.question["designs"].as_u64().unwrap_or(0);
                if is_whole(&whole, designs, self.part())? {
                    return Ok(None);
                }
                written(&whole, fs::rename(&whole, &growing))?;
            }
        }
        let done = match resume && known.exists() && growing.exists() {
            true => complete_lines(&growing)?,
            false => [0, 0],
        };
        let mut files = Files::into(&self.directory)?.beside(scene);
        let [part, parts] = self.part();
        files.write(&(stem(part, parts) + ".json"), |out| {
            writeln!(out, "{:#}", self.question)
        })?;
        files.keep()?;
        let open = || {
            let file = OpenOptions::new()
                .create(true)
                .append(true)
                .open(&growing)?;
            file.set_len(done[1])?;
            Ok(file)
        };
        let growing = Growing {
            out: BufWriter::new(written(&growing, open())?),
            file: growing,
            has_header: done[0] > 0,
        };
        Ok(Some((growing, done[0].saturating_sub(1))))
    }

    /// Gives the complete table its name; that of a whole sweep is drawn.
    pub fn close(&self, mut growing: Growing) -> Result<(), Failure> {
        growing.flush()?;
        let file = self.file(".csv");
        written(&file, fs::rename(&growing.file, &file))?;
        match self.part()[1] {
            1 => self.draw(),
            _ => Ok(()),
        }
    }

    /// Removes the table of a sweep that has no answer.
    pub fn remove(&self, growing: Growing) {
        drop(growing);
        for ending in [".csv.part", ".json"] {
            let _ = fs::remove_file(self.file(ending)); // it may be gone
        }
        let _ = fs::remove_dir(&self.directory); // it may hold more
    }

    /// Plots of the table, and a page.
    fn draw(&self) -> Result<(), Failure> {
        let count = self.question["designs"].as_u64().unwrap_or(0);
        if count > MOST_DRAWN {
            let _ = writeln!(
                io::stderr(),
                "note: {}: {count} designs are too many to draw, of which {MOST_DRAWN} are the most",
                self.directory.display()
            );
            return Ok(());
        }
        let file = self.file(".csv");
        let text = read(&file, fs::read_to_string(&file))?;
        let designs: Option<Vec<SweptDesign>> = text
            .lines()
            .skip(1)
            .map(|line| self.table.read(line))
            .collect();
        let designs = designs.ok_or_else(|| unfit(&file, "it is no table of this sweep"))?;
        let report = SweepReport {
            title: self.question["title"].as_str().unwrap_or_default(),
            table: &self.table,
            designs: &designs,
        };
        let mut files = Files::into(&self.directory)?;
        for (name, svg) in report.drawings() {
            files.write(&name, |out| out.write_all(svg.as_bytes()))?;
        }
        files.write("sweep.html", |out| out.write_all(report.html().as_bytes()))?;
        files.keep()
    }
}

/// Refuses a table that answers another question, and says what to do.
fn same(file: &Path, written: &Value, asked: &Value, advice: &str) -> Result<(), Failure> {
    let keys = [
        "eigentone",
        "scene",
        "vary",
        "metrics",
        "precision",
        "tolerance",
        "designs",
    ];
    match keys.iter().find(|key| written[**key] != asked[**key]) {
        None => Ok(()),
        Some(key) => Err(unfit(
            file,
            format!("it is of a sweep with another {key:?}: {advice}"),
        )),
    }
}

/// How many lines of a file are complete, and how many bytes these have.
fn complete_lines(file: &Path) -> Result<[u64; 2], Failure> {
    let mut reader = BufReader::new(read(file, File::open(file))?);
    let (mut line, mut found) = (Vec::new(), [0, 0]);
    loop {
        line.clear();
        let length = read(file, reader.read_until(b'\n', &mut line))?;
        if !line.ends_with(b"\n") {
            return Ok(found);
        }
        found = [found[0] + 1, found[1] + length as u64];
    }
}

/// Whether a table has as many designs as a part of so many in all.
fn is_whole(file: &Path, designs: u64, [part, parts]: [u64; 2]) -> Result<bool, Failure> {
    let own = part_of(designs, part, parts).map_err(|error| unfit(file, error.to_string()))?;
    // The first line names the columns.
    let found = complete_lines(file)?[0].saturating_sub(1);
    match found <= own.end - own.start {
        true => Ok(found == own.end - own.start),
        false => Err(unfit(
            file,
            format!(
                "it has {found} designs, and its part of the sweep {}",
                own.end - own.start
            ),
        )),
    }
}

/// A table that is not complete.
pub struct Growing {
    file: PathBuf,
    out: BufWriter<File>,
    has_header: bool,
}

impl Growing {
    /// Adds a design.
    pub fn add(&mut self, table: &SweepTable, design: &SweptDesign) -> Result<(), Failure> {
        let add = |out: &mut BufWriter<File>| -> io::Result<()> {
            if !self.has_header {
                table.header(design.roots.len(), out)?;
            }
            table.row(design, out)
        };
        written(&self.file, add(&mut self.out))?;
        self.has_header = true;
        Ok(())
    }

    /// Writes what was added.
    pub fn flush(&mut self) -> Result<(), Failure> {
        written(&self.file, self.out.flush())
    }
}

/// Makes `sweep.csv` of the parts in a directory, each of which must be there once and be complete, and draws it: how many
/// designs it has.
pub fn merge(directory: &Path) -> Result<u64, Failure> {
    let mut parts: Vec<([u64; 2], PathBuf)> = Vec::new();
    let entries = read(directory, fs::read_dir(directory))?;
    for entry in entries {
        let path = read(directory, entry)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let numbers = name
            .strip_prefix("sweep.")
            .and_then(|rest| rest.strip_suffix(".json"));
        let numbers = numbers.and_then(|numbers| numbers.split_once("-of-"));
        let numbers = numbers.and_then(|(i, n)| Some([i.parse().ok()?, n.parse().ok()?]));
        parts.extend(numbers.map(|numbers| (numbers, path.clone())));
    }
    parts.sort_unstable();
    let Some(([_, count], first)) = parts.first().cloned() else {
        return Err(unfit(
            directory,
            "no part of a sweep is there: name the directory that `sweep --shard i/N --out` wrote into",
        ));
    };
    if let Some(([_, other], file)) = parts.iter().find(|([_, n], _)| *n != count) {
        return Err(unfit(
            file,
            format!("there are parts of {count} and of {other}: keep those of one division"),
        ));
    }
    let mut asked = question(&first)?;
    let table = table_of(&first, &asked)?;
    let designs = asked["designs"].as_u64().unwrap_or(0);
    /// So many are named.
    const MOST_NAMED: usize = 10;
    let mut missing = Vec::new();
    for i in 1..=count {
        let [file, growing] =
            [".csv", ".csv.part"].map(|ending| directory.join(stem(i, count) + ending));
        let is_there = file.exists() && parts.iter().any(|([part, _], _)| *part == i);
        if is_there && is_whole(&file, designs, [i, count])? {
            continue;
        }
        if missing.len() == MOST_NAMED {
            missing.push("…".to_owned());
            break;
        }
        missing.push(match is_there || growing.exists() {
            true => format!("{i} (not complete: --resume goes on)"),
            false => i.to_string(),
        });
    }
    if !missing.is_empty() {
        return Err(unfit(
            directory,
            format!("of {count} parts these are missing: {}", missing.join(", ")),
        ));
    }
    for (_, file) in &parts {
        same(
            file,
            &question(file)?,
            &asked,
            "give the parts of one sweep",
        )?;
    }
    asked["part"] = json!([1, 1]);
    let mut files = Files::into(directory)?;
    let mut problem = None;
    files.write("sweep.csv", |out| {
        let (mut next, mut header) = (0, Vec::new());
        for i in 1..=count {
            let file = directory.join(stem(i, count) + ".csv");
            let mut lines = BufReader::new(File::open(&file)?).split(b'\n');
            let head = lines.next().transpose()?.unwrap_or_default();
            if head.is_empty() {
                continue; // a part without designs
            }
            if header.is_empty() {
                out.write_all(&head)?;
                out.write_all(b"\n")?;
                header = head;
            } else if head != header {
                problem.get_or_insert(unfit(&file, "its columns are not those of the other parts"));
            }
            for line in lines {
                let line = line?;
                let index = line.split(|byte| *byte == b',').next();
                if index != Some(next.to_string().as_bytes()) {
                    problem.get_or_insert(unfit(
                        &file,
                        format!("design {next} is not where it should be"),
                    ));
                    break;
                }
                out.write_all(&line)?;
                out.write_all(b"\n")?;
                next += 1;
            }
        }
        if next != designs {
            problem.get_or_insert(unfit(
                directory,
                format!("the parts have {next} of {designs} designs"),
            ));
        }
        Ok(())
    })?;
    if let Some(problem) = problem {
        return Err(problem);
    }
    files.write("sweep.json", |out| writeln!(out, "{asked:#}"))?;
    files.keep()?;
    Part::new(directory, asked, table).draw()?;
    Ok(designs)
}

fn question(file: &Path) -> Result<Value, Failure> {
    let text = read(file, fs::read_to_string(file))?;
    serde_json::from_str(&text).map_err(|error| unfit(file, error.to_string()))
}

/// The columns of a table.
fn table_of(file: &Path, question: &Value) -> Result<SweepTable, Failure> {
    let texts = |value: &Value| -> Option<Vec<String>> {
        let texts = value.as_array()?.iter();
        texts.map(|text| Some(text.as_str()?.to_owned())).collect()
    };
    let names = question["vary"]
        .as_array()
        .map(|all| all.iter().map(|one| one[0].clone()).collect());
    let names = names.and_then(|names: Vec<Value>| texts(&Value::from(names)));
    let metrics = texts(&question["metrics"]);
    let units = texts(&question["units"]).unwrap_or_default();
    let table = names.zip(metrics).map(|(parameters, metrics)| SweepTable {
        parameters,
        metrics,
        units,
    });
    table.ok_or_else(|| unfit(file, "it does not say what varies, and what is measured"))
}
