//! A comparison with all digits, for programs.

use std::io;

use eigentone_check::{
    ExponentialComparison, ExponentialRow, ModeComparison, ModeComparisonRow, ModeOutcome, Outcome,
    RunTime, WorkPrecision, WorkPrecisionRow,
};
use eigentone_response::ResponseError;
use serde::Serialize;

use super::{CheckReport, failure, measured, setting};
use crate::report::worth;

pub(super) fn write(report: &CheckReport<'_>, mut out: impl io::Write) -> io::Result<()> {
    let json = Json {
        title: report.title,
        modes: ModesJson::of(report.modes),
        exponentials: report.exponentials.map(ExponentialsJson::of),
        response: report.response.and_then(Result::ok).map(ResponseJson::of),
        response_error: report
            .response
            .and_then(Result::err)
            .map(ToString::to_string),
    };
    serde_json::to_writer_pretty(&mut out, &json)?;
    out.write_all(b"\n")
}

#[derive(Serialize)]
struct Json<'a> {
    title: &'a str,
    modes: ModesJson<'a>,
    exponentials: Option<ExponentialsJson>,
    response: Option<ResponseJson<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    response_error: Option<String>,
}

#[derive(Serialize)]
struct ModesJson<'a> {
    reference: &'a str,
    pick: &'a str,
    reason: &'a str,
    solvers: Vec<SolverJson<'a>>,
}

#[derive(Serialize)]
struct SolverJson<'a> {
    solver: &'a str,
    outcome: &'a str,
    reason: Option<String>,
    error: Option<f64>,
    real_part_error: Option<f64>,
    bounds: Option<&'a str>,
    time: Option<TimeJson>,
}

#[derive(Serialize)]
struct ExponentialsJson {
    order: usize,
    step: f64,
    norm: f64,
    methods: Vec<ExponentialJson>,
}

#[derive(Serialize)]
struct ExponentialJson {
    method: &'static str,
    error: f64,
    products: f64,
    time: TimeJson,
}

#[derive(Serialize)]
struct ResponseJson<'a> {
    reference: &'a str,
    instants: usize,
    pick: Option<PickJson<'a>>,
    methods: Vec<MethodJson<'a>>,
}

#[derive(Serialize)]
struct PickJson<'a> {
    method: &'a str,
    reason: &'a str,
    /// Indices of the methods as accurate and faster.
    beaten_by: Vec<usize>,
}

#[derive(Serialize)]
struct MethodJson<'a> {
    method: &'a str,
    setting: String,
    outcome: &'a str,
    reason: Option<String>,
    displacement_error: Option<f64>,
    velocity_error: Option<f64>,
    stable: Option<bool>,
    bounds: Option<&'a str>,
    digits: Option<usize>,
    front: bool,
    time: Option<TimeJson>,
    operations: Option<OperationsJson>,
    work: Option<WorkJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    events: Option<EventsJson>,
}

#[derive(Serialize)]
struct TimeJson {
    median: f64,
    quartiles: [f64; 2],
    min: f64,
    max: f64,
    runs: usize,
}

#[derive(Serialize)]
struct OperationsJson {
    exponentials: u64,
    products: f64,
    steps: u64,
}

#[derive(Serialize)]
struct EventsJson {
    expected: usize,
    found: usize,
    in_order: usize,
    time_error: Option<f64>,
}

#[derive(Serialize)]
struct WorkJson {
    evaluations: u64,
    accepted: u64,
    rejected: u64,
    factorisations: u64,
    solves: u64,
}

impl TimeJson {
    fn of(time: &RunTime) -> TimeJson {
        TimeJson {
            median: time.median,
            quartiles: time.quartiles,
            min: time.min,
            max: time.max,
            runs: time.runs,
        }
    }
}

impl<'a> ModesJson<'a> {
    fn of(modes: &'a ModeComparison) -> ModesJson<'a> {
        ModesJson {
            reference: modes.reference,
            pick: modes.pick,
            reason: &modes.reason,
            solvers: modes.rows.iter().map(SolverJson::of).collect(),
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
        let (error, bounds, time) = match &row.outcome {
            ModeOutcome::Measured {
                error,
                bounds,
                time,
            } => (*error, Some(worth(*bounds)), Some(TimeJson::of(time))),
            _ => (None, None, None),
        };
        SolverJson {
            solver: row.solver,
            outcome,
            reason,
            error: error.map(|error| error.modulus),
            real_part_error: error.map(|error| error.real_part),
            bounds,
            time,
        }
    }
}

impl ExponentialsJson {
    fn of(comparison: &ExponentialComparison) -> ExponentialsJson {
        let method = |row: &ExponentialRow| ExponentialJson {
            method: row.method,
            error: row.error,
            products: row.products,
            time: TimeJson::of(&row.time),
        };
        ExponentialsJson {
            order: comparison.order,
            step: comparison.step,
            norm: comparison.norm,
            methods: comparison.rows.iter().map(method).collect(),
        }
    }
}

impl<'a> ResponseJson<'a> {
    fn of(response: &'a WorkPrecision) -> ResponseJson<'a> {
        let front = response.front();
        let exceeds = response.exceeds_doubles();
        let rows = response.rows.iter().enumerate();
        ResponseJson {
            reference: response.reference,
            instants: response.instants,
            pick: response.pick.as_ref().map(|pick| PickJson {
                method: response.rows[pick.row].method,
                reason: &pick.reason,
                beaten_by: response.beating(pick.row),
            }),
            methods: rows
                .map(|(at, row)| MethodJson::of(row, front.contains(&at), exceeds))
                .collect(),
        }
    }
}

impl<'a> MethodJson<'a> {
    fn of(row: &'a WorkPrecisionRow, front: bool, exceeds: bool) -> MethodJson<'a> {
        let (outcome, reason) = match &row.outcome {
            Outcome::Measured(_) => ("measured", None),
            Outcome::Refused { reason } => ("refused", Some(reason.clone())),
            Outcome::Failed(error) => ("failed", Some(failure(row, error))),
            Outcome::LeftOut { reason } => ("left out", Some(reason.clone())),
        };
        let measurement = measured(row);
        let error = measurement.and_then(|measurement| measurement.error);
        let work = measurement.and_then(|measurement| measurement.work);
        let operations = measurement.and_then(|measurement| measurement.operations);
        MethodJson {
            method: row.method,
            setting: setting(row),
            outcome,
            reason,
            displacement_error: error.map(|error| error.displacement),
            velocity_error: error.map(|error| error.velocity),
            stable: match &row.outcome {
                Outcome::Failed(ResponseError::Overflow { .. }) if !exceeds => Some(false),
                _ => measurement.and_then(|measurement| measurement.stable),
            },
            bounds: measurement.map(|measurement| worth(measurement.bounds)),
            digits: measurement.map(|measurement| measurement.digits),
            front,
            time: measurement.map(|measurement| TimeJson::of(&measurement.time)),
            operations: operations.map(|operations| OperationsJson {
                exponentials: operations.exponentials,
                products: operations.products,
                steps: operations.steps,
            }),
            work: work.map(|work| WorkJson {
                evaluations: work.evaluations,
                accepted: work.accepted,
                rejected: work.rejected,
                factorisations: work.factorisations,
                solves: work.solves,
            }),
            events: measurement
                .and_then(|measurement| measurement.events)
                .map(|events| EventsJson {
                    expected: events.expected,
                    found: events.found,
                    in_order: events.in_order,
                    time_error: events.time,
                }),
        }
    }
}
