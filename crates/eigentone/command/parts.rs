//! The files of a sweep: a table that grows while it runs, so that what was ended can go on, beside what it is a table of; and
//! the whole from its parts.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead, BufReader, BufWriter, Write};
use std::ops;
use std::path::{Path, PathBuf};

use eigentone::design::{Grid, Range};
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
    grid: Grid,
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
    /// Of this part of a question, which names everything that its answer depends on, and of a grid of designs.
    pub fn new(directory: &Path, question: Value, grid: Grid, table: SweepTable) -> Part {
        Part {
            directory: directory.to_owned(),
            question,
            grid,
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

    /// The designs of the part.
    fn designs(&self, file: &Path) -> Result<ops::Range<u64>, Failure> {
        let [part, parts] = self.part();
        let designs = self.grid.part(part, parts);
        designs.map_err(|error| unfit(file, error.to_string()))
    }

    /// Reads the complete lines of a table, which must be designs of the part in their order.
    fn read(&self, file: &Path, mut each: impl FnMut(SweptDesign)) -> Result<Done, Failure> {
        let ops::Range { mut start, end } = self.designs(file)?;
        let mut reader = BufReader::new(read(file, File::open(file))?);
        let (mut line, mut done) = (Vec::new(), Done::default());
        loop {
            line.clear();
            let length = read(file, reader.read_until(b'\n', &mut line))?;
            if !line.ends_with(b"\n") {
                done.is_whole = start == end;
                return Ok(done);
            }
            if done.has_header() {
                let design = str::from_utf8(&line).ok();
                let design = design.and_then(|line| self.table.read(line));
                let design = design.filter(|design| {
                    let here = (design.index, Some(&design.values));
                    start < end && here == (start, self.grid.design(start).as_ref())
                });
                each(design.ok_or_else(|| {
                    let place = match start < end {
                        true => format!("design {start} of this sweep must be there, and is not"),
                        false => format!("its part of the sweep ends with design {}", end - 1),
                    };
                    let advice = "remove this line and all behind it, and let --resume go on";
                    unfit(file, format!("line {}: {place}: {advice}", done.lines + 1))
                })?);
                start += 1;
            }
            done.lines += 1;
            done.bytes += length as u64;
        }
    }

    /// Begins the table, or, to resume, goes on behind the designs that it has: how many these are. `None` where it is complete.
    pub fn open(&self, scene: &Path, resume: bool) -> Result<Option<(Growing, u64)>, Failure> {
        let growing = self.file(".csv.part");
        let known = self.file(".json");
        let mut done = Done::default();
        if resume && known.exists() {
            same(
                &known,
                &question(&known)?,
                &self.question,
                "take another directory, or leave --resume out",
            )?;
            let whole = self.file(".csv");
            if growing.exists() {
                done = self.read(&growing, drop)?;
            } else if whole.exists() {
                done = self.read(&whole, drop)?;
                if done.is_whole {
                    return Ok(None);
                }
                written(&whole, fs::rename(&whole, &growing))?;
            }
        }
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
            file.set_len(done.bytes)?;
            Ok(file)
        };
        let growing = Growing {
            out: BufWriter::new(written(&growing, open())?),
            file: growing,
            has_header: done.has_header(),
        };
        Ok(Some((growing, done.lines.saturating_sub(1))))
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
        let count = self.grid.count();
        if count > MOST_DRAWN {
            let _ = writeln!(
                io::stderr(),
                "note: {}: {count} designs are too many to draw, of which {MOST_DRAWN} are the most",
                self.directory.display()
            );
            return Ok(());
        }
        let mut designs = Vec::new();
        self.read(&self.file(".csv"), |design| designs.push(design))?;
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

/// What a table has.
#[derive(Default)]
struct Done {
    /// Complete lines, the first of which names the columns.
    lines: u64,
    /// The length of these.
    bytes: u64,
    /// Whether these are all designs of the part.
    is_whole: bool,
}

impl Done {
    fn has_header(&self) -> bool {
        self.lines > 0
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
    for (_, file) in &parts {
        same(
            file,
            &question(file)?,
            &asked,
            "give the parts of one sweep",
        )?;
    }
    let mut part = asked_of(&first, directory, &asked)?;
    /// So many are named.
    const MOST_NAMED: usize = 10;
    let mut missing = Vec::new();
    for i in 1..=count {
        part.question["part"] = json!([i, count]);
        let [file, growing] = [".csv", ".csv.part"].map(|ending| part.file(ending));
        let is_there = file.exists() && parts.iter().any(|([part, _], _)| *part == i);
        if is_there && part.read(&file, drop)?.is_whole {
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
    asked["part"] = json!([1, 1]);
    part.question = asked;
    let mut files = Files::into(directory)?;
    let mut problem = None;
    files.write("sweep.csv", |out| {
        let mut columns = String::new();
        for i in 1..=count {
            let file = directory.join(stem(i, count) + ".csv");
            let mut table = BufReader::new(File::open(&file)?);
            let mut header = String::new();
            table.read_line(&mut header)?;
            if table.fill_buf()?.is_empty() {
                continue; // a part without designs
            }
            if columns.is_empty() {
                out.write_all(header.as_bytes())?;
                columns = header;
            } else if columns != header {
                problem.get_or_insert(unfit(&file, "its columns are not those of the other parts"));
            }
            io::copy(&mut table, out)?;
        }
        Ok(())
    })?;
    if let Some(problem) = problem {
        return Err(problem);
    }
    files.write("sweep.json", |out| writeln!(out, "{:#}", part.question))?;
    files.keep()?;
    part.draw()?;
    Ok(part.grid.count())
}

fn question(file: &Path) -> Result<Value, Failure> {
    let text = read(file, fs::read_to_string(file))?;
    serde_json::from_str(&text).map_err(|error| unfit(file, error.to_string()))
}

/// The part of a sweep that a question is about.
fn asked_of(file: &Path, directory: &Path, question: &Value) -> Result<Part, Failure> {
    let texts = |value: &Value| -> Option<Vec<String>> {
        let texts = value.as_array()?.iter();
        texts.map(|text| Some(text.as_str()?.to_owned())).collect()
    };
    let varied = question["vary"].as_array().and_then(|all| {
        let each = all.iter().map(|one| {
            let range = one[1].as_str()?.parse::<Range>().ok()?;
            Some((one[0].as_str()?.to_owned(), range))
        });
        each.collect::<Option<(Vec<String>, Vec<Range>)>>()
    });
    let asked = varied.zip(texts(&question["metrics"]));
    let asked = asked.and_then(|((parameters, ranges), metrics)| {
        let grid = Grid::new(ranges).ok()?;
        let units = texts(&question["units"]).unwrap_or_default();
        let table = SweepTable {
            parameters,
            metrics,
            units,
        };
        let is_same = question["designs"] == grid.count();
        is_same.then(|| Part::new(directory, question.clone(), grid, table))
    });
    asked.ok_or_else(|| unfit(file, "it does not say what varies, and what is measured"))
}
