//! Every method against a reference: errors and run times as tables, as JSON and as a
//! work-precision diagram.

use std::io;

use eigentone_check::{
    Measurement, ModeComparison, ModeComparisonRow, ModeOutcome, Outcome, RunTime, WorkPrecision,
    WorkPrecisionRow,
};
use serde::Serialize;

use super::number::{NONE, scientific};
use super::plot::{Axis, Line, Plot};
use super::table::{Align, Table, visible};

/// How every solver and method did on one scene.
pub struct CheckReport<'a> {
    /// What the scene is called.
    pub title: &'a str,
    /// The mode solvers.
    pub modes: &'a ModeComparison,
    /// The response methods, if the scene asks for a response.
    pub response: Option<&'a WorkPrecision>,
}

impl CheckReport<'_> {
    /// Two tables in aligned columns: the mode solvers, and the response methods with their
    /// settings.
    pub fn text(&self) -> String {
        let indent = |table: Table| -> String {
            let text = table.text();
            text.lines().map(|line| format!("  {line}\n")).collect()
        };
        let mut text = format!("{}\n", visible(self.title));
        text += &format!("\n{}\n", self.modes_heading());
        text += &indent(modes_table(self.modes));
        match self.response {
            Some(response) => {
                text += &format!("\n{}\n", response_heading(response));
                text += &indent(response_table(response));
            }
            None => text += &format!("\n{NO_RESPONSE}\n"),
        }
        text
    }

    /// The same in Markdown.
    pub fn markdown(&self) -> String {
        let mut text = format!("# {}\n", visible(self.title));
        text += &format!("\n{}\n\n", self.modes_heading());
        text += &modes_table(self.modes).markdown();
        match self.response {
            Some(response) => {
                text += &format!("\n{}\n\n", response_heading(response));
                text += &response_table(response).markdown();
            }
            None => text += &format!("\n{NO_RESPONSE}\n"),
        }
        text
    }

    /// One JSON object with all digits: run times in s; errors are relative, and null for the
    /// reference and where they are infinite.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn json(&self, mut out: impl io::Write) -> io::Result<()> {
        let json = Json {
            title: self.title,
            modes: ModesJson {
                reference: self.modes.reference,
                solvers: self.modes.rows.iter().map(SolverJson::of).collect(),
            },
            response: self.response.map(|response| ResponseJson {
                reference: response.reference,
                instants: response.instants,
                methods: response.rows.iter().map(MethodJson::of).collect(),
            }),
        };
        serde_json::to_writer_pretty(&mut out, &json)?;
        out.write_all(b"\n")
    }

    /// Run time against the error of the displacements, both on logarithmic axes: a line for each
    /// method, a point for each setting. `None` without a response. The reference, and what agrees
    /// with it in every digit, has no place on such an axis.
    pub fn plot(&self) -> Option<Plot<'_>> {
        let rows = &self.response?.rows;
        let mut names: Vec<&str> = Vec::new();
        for row in rows {
            if measured(row).is_some() && !names.contains(&row.method) {
                names.push(row.method);
            }
        }
        let lines = names.into_iter().filter_map(|name| {
            let of_method = rows.iter().filter(|row| row.method == name);
            let points = of_method.filter_map(|row| {
                let measurement = measured(row)?;
                let error = measurement.error?.displacement;
                (error > 0.0 && error.is_finite()).then_some((error, measurement.time.median))
            });
            let points: Vec<(f64, f64)> = points.collect();
            let line = Line::new(name, points.len(), {
                let points = points.clone();
                move |k| points[k]
            });
            (!points.is_empty()).then(|| line.marked())
        });
        Some(Plot {
            title: self.title.to_owned(),
            x: Axis::logarithmic("largest relative error of a displacement", ""),
            y: Axis::logarithmic("run time", "s"),
            lines: lines.collect(),
        })
    }

    fn modes_heading(&self) -> String {
        format!("Modes, compared with {}", self.modes.reference)
    }
}

const NO_RESPONSE: &str = "Response: left out, the scene has no `time`";

fn response_heading(response: &WorkPrecision) -> String {
    format!(
        "Response at {} instants, compared with {}",
        response.instants, response.reference
    )
}

fn measured(row: &WorkPrecisionRow) -> Option<&Measurement> {
    match &row.outcome {
        Outcome::Measured(measurement) => Some(measurement),
        _ => None,
    }
}

fn or_none(value: Option<f64>) -> String {
    value.map_or_else(|| NONE.to_owned(), scientific)
}

fn modes_table(modes: &ModeComparison) -> Table {
    let rows = || modes.rows.iter();
    let taken = |row: &ModeComparisonRow| match &row.outcome {
        ModeOutcome::Measured { distance, time } => Some((*distance, time.median)),
        _ => None,
    };
    let notes = rows().map(|row| match &row.outcome {
        ModeOutcome::Measured { distance: None, .. } => "the reference".to_owned(),
        ModeOutcome::Measured { .. } => String::new(),
        ModeOutcome::Refused { reason } => format!("does not apply: {reason}"),
        ModeOutcome::Failed(error) => format!("failed: {error}"),
    });
    Table::default()
        .column("solver", Align::Left, rows().map(|row| row.solver))
        .column(
            "|λ − λ_ref| / |λ_ref|",
            Align::Right,
            rows().map(|row| or_none(taken(row).and_then(|(distance, _)| distance))),
        )
        .column(
            "run time, s",
            Align::Right,
            rows().map(|row| or_none(taken(row).map(|(_, time)| time))),
        )
        .column("", Align::Left, notes)
}

fn response_table(response: &WorkPrecision) -> Table {
    let rows = || response.rows.iter();
    let error = |row| measured(row).and_then(|measurement| measurement.error);
    let count = |row, of: fn(&eigentone_check::Work) -> u64| {
        let work = measured(row).and_then(|measurement| measurement.work);
        work.map_or_else(|| NONE.to_owned(), |work| of(&work).to_string())
    };
    let notes = rows().map(|row| match &row.outcome {
        Outcome::Measured(Measurement { error: None, .. }) => "the reference".to_owned(),
        Outcome::Measured(_) => String::new(),
        Outcome::Refused { reason } => format!("does not apply: {reason}"),
        Outcome::Failed(error) => format!("failed: {error}"),
        Outcome::LeftOut { reason } => format!("left out: {reason}"),
    });
    Table::default()
        .column("method", Align::Left, rows().map(|row| row.method))
        .column("setting", Align::Left, rows().map(setting))
        .column(
            "error of x",
            Align::Right,
            rows().map(|row| or_none(error(row).map(|error| error.displacement))),
        )
        .column(
            "error of v",
            Align::Right,
            rows().map(|row| or_none(error(row).map(|error| error.velocity))),
        )
        .column(
            "run time, s",
            Align::Right,
            rows().map(|row| or_none(measured(row).map(|one| one.time.median))),
        )
        .column(
            "steps",
            Align::Right,
            rows().map(|row| count(row, |work| work.accepted + work.rejected)),
        )
        .column(
            "evaluations",
            Align::Right,
            rows().map(|row| count(row, |work| work.evaluations)),
        )
        .column("", Align::Left, notes)
}

fn setting(row: &WorkPrecisionRow) -> String {
    row.knob.map(|knob| knob.to_string()).unwrap_or_default()
}

#[derive(Serialize)]
struct Json<'a> {
    title: &'a str,
    modes: ModesJson<'a>,
    response: Option<ResponseJson<'a>>,
}

#[derive(Serialize)]
struct ModesJson<'a> {
    reference: &'a str,
    solvers: Vec<SolverJson<'a>>,
}

#[derive(Serialize)]
struct SolverJson<'a> {
    solver: &'a str,
    outcome: &'a str,
    reason: Option<String>,
    error: Option<f64>,
    time: Option<TimeJson>,
}

#[derive(Serialize)]
struct ResponseJson<'a> {
    reference: &'a str,
    instants: usize,
    methods: Vec<MethodJson<'a>>,
}

#[derive(Serialize)]
struct MethodJson<'a> {
    method: &'a str,
    setting: String,
    outcome: &'a str,
    reason: Option<String>,
    displacement_error: Option<f64>,
    velocity_error: Option<f64>,
    time: Option<TimeJson>,
    work: Option<WorkJson>,
}

#[derive(Serialize)]
struct TimeJson {
    median: f64,
    min: f64,
    max: f64,
    runs: usize,
}

#[derive(Serialize)]
struct WorkJson {
    evaluations: u64,
    accepted: u64,
    rejected: u64,
}

impl TimeJson {
    fn of(time: &RunTime) -> TimeJson {
        TimeJson {
            median: time.median,
            min: time.min,
            max: time.max,
            runs: time.runs,
        }
    }
}

impl<'a> SolverJson<'a> {
    fn of(row: &'a ModeComparisonRow) -> SolverJson<'a> {
        let (outcome, reason) = match &row.outcome {
            ModeOutcome::Measured { .. } => ("measured", None),
            ModeOutcome::Refused { reason } => ("refused", Some(reason.clone())),
            ModeOutcome::Failed(error) => ("failed", Some(error.to_string())),
        };
        let (error, time) = match &row.outcome {
            ModeOutcome::Measured { distance, time } => (*distance, Some(TimeJson::of(time))),
            _ => (None, None),
        };
        SolverJson {
            solver: row.solver,
            outcome,
            reason,
            error,
            time,
        }
    }
}

impl<'a> MethodJson<'a> {
    fn of(row: &'a WorkPrecisionRow) -> MethodJson<'a> {
        let (outcome, reason) = match &row.outcome {
            Outcome::Measured(_) => ("measured", None),
            Outcome::Refused { reason } => ("refused", Some(reason.clone())),
            Outcome::Failed(error) => ("failed", Some(error.to_string())),
            Outcome::LeftOut { reason } => ("left out", Some(reason.clone())),
        };
        let measurement = measured(row);
        let error = measurement.and_then(|measurement| measurement.error);
        let work = measurement.and_then(|measurement| measurement.work);
        MethodJson {
            method: row.method,
            setting: setting(row),
            outcome,
            reason,
            displacement_error: error.map(|error| error.displacement),
            velocity_error: error.map(|error| error.velocity),
            time: measurement.map(|measurement| TimeJson::of(&measurement.time)),
            work: work.map(|work| WorkJson {
                evaluations: work.evaluations,
                accepted: work.accepted,
                rejected: work.rejected,
            }),
        }
    }
}
