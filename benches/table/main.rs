//! Turns what `cargo bench` left behind into a table that can be pasted: dated, with the name of the
//! machine, one row for each question and one column for each method, run times as medians with the
//! median deviation from them.
//!
//! ```sh
//! cargo bench
//! cargo run --release --example bench-table > results.md
//! ```

mod date;
mod machine;

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde_json::Value;

/// Medians and deviations in ns, by group, question and method.
type Results = BTreeMap<String, BTreeMap<String, BTreeMap<String, [f64; 2]>>>;

fn main() -> ExitCode {
    let directory = std::env::args_os().nth(1);
    let directory = directory.map_or_else(|| PathBuf::from("target/criterion"), PathBuf::from);
    let mut results = Results::new();
    if let Err(error) = collect(&directory, &mut results) {
        eprintln!(
            "error: {}: {error}; run `cargo bench` first",
            directory.display()
        );
        return ExitCode::from(2);
    }
    if results.is_empty() {
        eprintln!(
            "error: {}: no results; run `cargo bench` first",
            directory.display()
        );
        return ExitCode::from(2);
    }
    print!("{}", markdown(&results));
    ExitCode::SUCCESS
}

/// Every directory with the newest results of one benchmark.
fn collect(directory: &Path, results: &mut Results) -> Result<(), Box<dyn Error>> {
    let newest = directory.join("new");
    if newest.join("benchmark.json").is_file() {
        let read = |name: &str| -> Result<Value, Box<dyn Error>> {
            Ok(serde_json::from_slice(&fs::read(newest.join(name))?)?)
        };
        let (about, estimates) = (read("benchmark.json")?, read("estimates.json")?);
        let text = |key: &str| about[key].as_str().unwrap_or_default().to_owned();
        let number = |key: &str| {
            estimates[key]["point_estimate"]
                .as_f64()
                .unwrap_or(f64::NAN)
        };
        let group = results.entry(text("group_id")).or_default();
        let question = group.entry(text("value_str")).or_default();
        let times = [number("median"), number("median_abs_dev")];
        question.insert(text("function_id"), times);
        return Ok(());
    }
    for entry in fs::read_dir(directory)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, results)?;
        }
    }
    Ok(())
}

fn markdown(results: &Results) -> String {
    let mut out = format!("Measured on {}, on {}.\n", date::today(), machine::name());
    for (group, questions) in results {
        let mut methods: Vec<&str> = Vec::new();
        for method in questions.values().flat_map(BTreeMap::keys) {
            if !methods.contains(&method.as_str()) {
                methods.push(method);
            }
        }
        let row = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        out += &format!("\n### {group}\n\n");
        let header = methods.iter().map(|method| (*method).to_owned());
        out += &row([String::new()].into_iter().chain(header).collect());
        let rule = methods.iter().map(|_| "--:".to_owned());
        out += &row(["--".to_owned()].into_iter().chain(rule).collect());
        let mut sorted: Vec<&String> = questions.keys().collect();
        sorted.sort_by(|a, b| by_number(a, b));
        for question in sorted {
            let times = &questions[question];
            let cells = methods.iter().map(|method| match times.get(*method) {
                Some(time) => cell(*time),
                None => String::new(),
            });
            out += &row([question.clone()].into_iter().chain(cells).collect());
        }
    }
    out
}

/// Names in their order, but by the number at their end where they are alike before it.
fn by_number(a: &str, b: &str) -> std::cmp::Ordering {
    let split = |name: &str| {
        let stem = name
            .trim_end_matches(|c: char| c.is_ascii_digit())
            .to_owned();
        let number = name[stem.len()..].parse::<u64>().ok();
        (stem, number)
    };
    split(a).cmp(&split(b))
}

/// A time in ns with the unit that suits it, and the deviation in percent.
fn cell([median, deviation]: [f64; 2]) -> String {
    let units = [(1e9, "s"), (1e6, "ms"), (1e3, "µs"), (1.0, "ns")];
    let unit = units.iter().find(|(size, _)| median >= *size);
    let (size, unit) = unit.unwrap_or(&units[3]);
    let value = median / size;
    let decimals = if value < 10.0 {
        2
    } else if value < 100.0 {
        1
    } else {
        0
    };
    let spread = 100.0 * deviation / median;
    format!("{value:.decimals$} {unit} ± {spread:.0} %")
}
