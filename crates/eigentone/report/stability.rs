//! The stability study as tables, as JSON and as heat maps.

use std::io;

use eigentone_check::{Cell, FamilyStudy, StabilityRow, StabilityStudy, Verdict};
use serde::Serialize;

use super::axis::superscript;
use super::heat_map::{HeatMap, Row, Tile};
use super::table::{Align, Table};

/// Where every method is accurate, where it loses digits and where it breaks.
pub struct StabilityReport<'a> {
    /// What was found.
    pub study: &'a StabilityStudy,
}

impl StabilityReport<'_> {
    /// A table for each family in aligned columns, and below it why methods fail.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for study in &self.study.families {
            text += &format!("{}\n  {}\n", heading(study), study.family.about);
            for line in table(study).text().lines() {
                text += &format!("  {line}\n");
            }
            for (method, why) in explanations(study) {
                text += &format!("  {method}: {why}\n");
            }
            text.push('\n');
        }
        text + READING + "\n"
    }

    /// The same in Markdown; with `plots`, each family shows its heat map from
    /// [`heat_maps`](Self::heat_maps), by its file name.
    pub fn markdown(&self, plots: bool) -> String {
        let mut text = String::new();
        for study in &self.study.families {
            text += &format!("## {}\n\n{}\n\n", heading(study), study.family.about);
            if plots {
                text += &format!("![{}]({})\n\n", heading(study), file(study));
            }
            text += &table(study).markdown();
            text.push('\n');
            for (method, why) in explanations(study) {
                text += &format!("- **{method}**: {why}\n");
            }
            text.push('\n');
        }
        text + READING + "\n"
    }

    /// One JSON object with every cell: errors are relative, times in s.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn json(&self, mut out: impl io::Write) -> io::Result<()> {
        let families = self.study.families.iter().map(FamilyJson::of).collect();
        serde_json::to_writer_pretty(&mut out, &Json { families })?;
        out.write_all(b"\n")
    }

    /// A heat map for each family: the name of its file, and the SVG.
    pub fn heat_maps(&self) -> Vec<(String, String)> {
        let studies = self.study.families.iter();
        studies
            .map(|study| (file(study), heat_map(study).svg()))
            .collect()
    }
}

const READING: &str = "Accurate: at least four digits. Degraded: one to four. Broken: no digit is right, the motion \
     grows without bound, or there is no answer. Not run: it would take more than 2 s. \
     T/500: 500 steps in a period of the motion that one looks at. 1e-9: the tolerance of each step.";

fn heading(study: &FamilyStudy) -> String {
    let values = &study.family.values;
    let (first, last) = (values.first(), values.last());
    let (Some(first), Some(last)) = (first, last) else {
        return study.family.parameter.to_owned();
    };
    let [first, last] = [first, last].map(|value| label(*value));
    let mut letters = study.family.parameter.chars();
    let initial = letters.next().map(|c| c.to_uppercase().to_string());
    let parameter = initial.unwrap_or_default() + letters.as_str();
    format!("{parameter} {first} to {last}")
}

fn file(study: &FamilyStudy) -> String {
    format!("stability-{}.svg", study.family.name)
}

fn explanations(study: &FamilyStudy) -> Vec<(String, &str)> {
    let rows = study.rows.iter();
    rows.filter_map(|row| Some((name(row), row.explanation.as_deref()?)))
        .collect()
}

fn name(row: &StabilityRow) -> String {
    match row.modes {
        true => format!("modes by {}", row.method),
        false => row.method.clone(),
    }
}

fn table(study: &FamilyStudy) -> Table {
    let rows = || study.rows.iter();
    let column = |verdict: Verdict| rows().map(move |row| ranges(study, row, verdict));
    let worst = rows().map(|row| {
        let errors = row.cells.iter().filter_map(|cell| match cell {
            Cell::Answered { error, .. } => Some(*error),
            _ => None,
        });
        errors.fold(0.0, f64::max)
    });
    let slowest = rows().map(|row| {
        let times = row.cells.iter().filter_map(|cell| match cell {
            Cell::Answered { time, .. } => Some(*time),
            _ => None,
        });
        times.fold(0.0, f64::max)
    });
    use super::number::scientific;
    Table::default()
        .column("method", Align::Left, rows().map(name))
        .column("accurate", Align::Left, column(Verdict::Accurate))
        .column("degraded", Align::Left, column(Verdict::Degraded))
        .column("broken", Align::Left, column(Verdict::Broken))
        .column("not run", Align::Left, column(Verdict::NotRun))
        .column("worst error", Align::Right, worst.map(scientific))
        .column("slowest, s", Align::Right, slowest.map(scientific))
}

/// The values at which a method has this verdict, neighbours joined.
fn ranges(study: &FamilyStudy, row: &StabilityRow, verdict: Verdict) -> String {
    let values = &study.family.values;
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for at in (0..row.cells.len()).filter(|at| row.cells[*at].verdict() == verdict) {
        match runs.last_mut() {
            Some((_, end)) if *end + 1 == at => *end = at,
            _ => runs.push((at, at)),
        }
    }
    let all = values.len();
    let text = |(from, to): (usize, usize)| match (from, to) {
        (0, to) if to + 1 == all => "all".to_owned(),
        (0, to) if to > 0 => format!("to {}", label(values[to])),
        (from, to) if to + 1 == all && from < to => format!("from {}", label(values[from])),
        (from, to) if from == to => label(values[from]),
        (from, to) => format!("{} to {}", label(values[from]), label(values[to])),
    };
    runs.into_iter().map(text).collect::<Vec<_>>().join(", ")
}

/// A value as a power of ten, or as it is.
fn label(value: f64) -> String {
    let power = value.log10().round() as i32;
    match (-1..3).contains(&power) {
        true => format!("{value}"),
        false if format!("{value:e}") == format!("1e{power}") => format!("1e{power}"),
        false => format!("{value}"),
    }
}

fn heat_map(study: &FamilyStudy) -> HeatMap {
    let row = |row: &StabilityRow| Row {
        name: row.method.clone(),
        strong: row.planned,
        tiles: row.cells.iter().map(tile).collect(),
    };
    let group = |modes: bool| -> Vec<Row> {
        let rows = study.rows.iter().filter(|row| row.modes == modes);
        rows.map(row).collect()
    };
    let groups = [("Motion", group(false)), ("Modes", group(true))];
    HeatMap {
        title: heading(study),
        about: study.family.about.to_owned(),
        parameter: study.family.parameter.to_owned(),
        columns: study
            .family
            .values
            .iter()
            .map(|value| pretty(*value))
            .collect(),
        groups: groups
            .into_iter()
            .filter(|(_, rows)| !rows.is_empty())
            .map(|(word, rows)| (word.to_owned(), rows))
            .collect(),
    }
}

/// A power of ten as it is printed in books.
fn pretty(value: f64) -> String {
    match label(value).split_once('e') {
        Some((_, power)) => format!("10{}", superscript(power.parse().unwrap_or(0))),
        None => label(value),
    }
}

fn tile(cell: &Cell) -> Tile {
    match cell {
        Cell::Answered { .. } if cell.verdict() == Verdict::Broken => Tile::Broken,
        Cell::Answered { error, .. } => {
            let digits = -error.max(f64::MIN_POSITIVE).log10();
            Tile::Digits((digits + 0.1).floor().clamp(0.0, 16.0) as u32)
        }
        Cell::Unstable | Cell::Failed { .. } => Tile::Broken,
        Cell::Refused { .. } => Tile::Absent,
        Cell::NotRun { steps, .. } => {
            Tile::Left(format!("10{}", superscript(steps.log10().round() as i32)))
        }
    }
}

#[derive(Serialize)]
struct Json<'a> {
    families: Vec<FamilyJson<'a>>,
}

#[derive(Serialize)]
struct FamilyJson<'a> {
    name: &'a str,
    parameter: &'a str,
    about: &'a str,
    values: &'a [f64],
    methods: Vec<RowJson<'a>>,
}

#[derive(Serialize)]
struct RowJson<'a> {
    method: &'a str,
    answers: &'a str,
    planned: bool,
    explanation: Option<&'a str>,
    cells: Vec<CellJson<'a>>,
}

#[derive(Serialize)]
struct CellJson<'a> {
    outcome: &'a str,
    verdict: &'a str,
    error: Option<f64>,
    time: Option<f64>,
    predicted_steps: Option<f64>,
    predicted_time: Option<f64>,
    reason: Option<&'a str>,
}

impl<'a> FamilyJson<'a> {
    fn of(study: &'a FamilyStudy) -> FamilyJson<'a> {
        FamilyJson {
            name: study.family.name,
            parameter: study.family.parameter,
            about: study.family.about,
            values: &study.family.values,
            methods: study.rows.iter().map(RowJson::of).collect(),
        }
    }
}

impl<'a> RowJson<'a> {
    fn of(row: &'a StabilityRow) -> RowJson<'a> {
        RowJson {
            method: &row.method,
            answers: if row.modes { "modes" } else { "motion" },
            planned: row.planned,
            explanation: row.explanation.as_deref(),
            cells: row.cells.iter().map(CellJson::of).collect(),
        }
    }
}

impl<'a> CellJson<'a> {
    fn of(cell: &'a Cell) -> CellJson<'a> {
        let nothing = CellJson {
            outcome: "",
            verdict: match cell.verdict() {
                Verdict::Accurate => "accurate",
                Verdict::Degraded => "degraded",
                Verdict::Broken => "broken",
                Verdict::Refused => "refused",
                Verdict::NotRun => "not run",
            },
            error: None,
            time: None,
            predicted_steps: None,
            predicted_time: None,
            reason: None,
        };
        match cell {
            Cell::Answered { error, time } => CellJson {
                outcome: "answered",
                error: Some(*error),
                time: Some(*time),
                ..nothing
            },
            Cell::Unstable => CellJson {
                outcome: "unstable",
                ..nothing
            },
            Cell::Failed { reason } => CellJson {
                outcome: "failed",
                reason: Some(reason),
                ..nothing
            },
            Cell::Refused { reason } => CellJson {
                outcome: "refused",
                reason: Some(reason),
                ..nothing
            },
            Cell::NotRun { steps, time } => CellJson {
                outcome: "not run",
                predicted_steps: Some(*steps),
                predicted_time: Some(*time),
                ..nothing
            },
        }
    }
}
