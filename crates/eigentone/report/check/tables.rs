//! What people read of a comparison.

use eigentone_check::{
    EventsFound, ExponentialComparison, Measurement, ModeComparison, ModeComparisonRow,
    ModeOutcome, Outcome, RunTime, WorkPrecision, WorkPrecisionRow,
};

use eigentone_response::ResponseError;

use super::{Section, failure, measured, named, setting};
use crate::report::number::{NONE, count, scientific, short};
use crate::report::table::{Align, Table};
use crate::report::worth;

/// What the errors of a response mean.
const ERROR: &str = "Error of x: the largest difference of a displacement at any of these instants, relative to the peak, the \
     largest displacement of any coordinate at any of them. Error of v: the same of velocities.";

/// What is said of a motion that grows out of the range of doubles.
const EXCEEDS: &str = "The motion itself exceeds the largest double at some of these instants: no error is a number there, and which method is \
     stable is not known.";

/// What the columns of a comparison of modes mean.
const MODES: &str = "Error of λ: the largest difference of an eigenvalue, relative to its modulus; of Re λ: the same of its real part, \
     relative to the modulus too. Run time: the median of several runs. Spread: between the quartiles of these runs, in % of the median.";

/// What marks a method on the front.
const FRONT: &str = "Front: • where no other method is both as accurate and faster.";

/// What is said of events.
const EVENTS: &str = "Events: how many from the first on are those of the exact motion, in its order and to within a step, and the largest error of their times. \
     Steps are halved until two answers in a row agree to 1e-10.";

/// More rows that beat the pick are only counted.
const MOST_NAMED: usize = 3;

pub(super) fn modes(modes: &ModeComparison) -> Section {
    let rows = || modes.rows.iter();
    let taken = |row: &ModeComparisonRow| match &row.outcome {
        ModeOutcome::Measured { error, time, .. } => Some((*error, *time)),
        _ => None,
    };
    let error = |row| taken(row).and_then(|(error, _)| error);
    let worth = |row: &ModeComparisonRow| match &row.outcome {
        ModeOutcome::Measured { bounds, .. } => worth(*bounds),
        _ => NONE,
    };
    let notes = rows().map(|row| match &row.outcome {
        ModeOutcome::Measured { error: None, .. } => "the reference".to_owned(),
        ModeOutcome::Measured { .. } if row.solver == modes.pick => "picked".to_owned(),
        ModeOutcome::Measured { .. } => String::new(),
        ModeOutcome::Refused { reason } => format!("does not apply: {reason}"),
        ModeOutcome::Failed(error) => format!("failed: {error}"),
    });
    let table = Table::default()
        .column("solver", Align::Left, rows().map(|row| row.solver))
        .column(
            "error of λ",
            Align::Right,
            rows().map(|row| or_none(error(row).map(|error| error.modulus))),
        )
        .column(
            "of Re λ",
            Align::Right,
            rows().map(|row| or_none(error(row).map(|error| error.real_part))),
        )
        .column("bounds", Align::Left, rows().map(worth));
    Section {
        heading: format!("Modes, compared with {}", modes.reference),
        table: timed(table, rows().map(|row| taken(row).map(|(_, time)| time))).column(
            "",
            Align::Left,
            notes,
        ),
        remarks: vec![
            MODES.to_owned(),
            format!("The plan picks {}: {}.", modes.pick, modes.reason),
        ],
    }
}

pub(super) fn exponentials(comparison: &ExponentialComparison) -> Section {
    let rows = || comparison.rows.iter();
    let table = Table::default()
        .column("method", Align::Left, rows().map(|row| row.method))
        .column(
            "error",
            Align::Right,
            rows().map(|row| scientific(row.error)),
        )
        .column(
            "products",
            Align::Right,
            rows().map(|row| short(row.products)),
        );
    Section {
        heading: format!(
            "Exponential of the state matrix over {} s: order {}, norm {}",
            short(comparison.step),
            comparison.order,
            scientific(comparison.norm)
        ),
        table: timed(table, rows().map(|row| Some(row.time))),
        remarks: Vec::new(),
    }
}

pub(super) fn response(response: &WorkPrecision) -> Section {
    let rows = || response.rows.iter();
    let error = |row| measured(row).and_then(|measurement| measurement.error);
    let front = response.front();
    let pick = response.pick.as_ref().map(|pick| pick.row);
    let notes = rows().enumerate().map(|(at, row)| match &row.outcome {
        Outcome::Measured(Measurement { error: None, .. }) => "the reference".to_owned(),
        Outcome::Measured(_) if Some(at) == pick => "picked".to_owned(),
        Outcome::Measured(_) => String::new(),
        Outcome::Refused { reason } => format!("does not apply: {reason}"),
        Outcome::Failed(error) => format!("failed: {}", failure(row, error)),
        Outcome::LeftOut { reason } => format!("left out: {reason}"),
    });
    let stable = |row: &WorkPrecisionRow| match &row.outcome {
        Outcome::Measured(Measurement {
            stable: Some(true), ..
        }) => "yes",
        Outcome::Measured(Measurement { stable: None, .. }) => NONE,
        Outcome::Failed(ResponseError::Overflow { .. }) if response.exceeds_doubles() => NONE,
        Outcome::Measured(_) | Outcome::Failed(ResponseError::Overflow { .. }) => "no",
        _ => NONE,
    };
    let on_front = (0..response.rows.len()).map(|at| if front.contains(&at) { "•" } else { "" });
    let table = Table::default()
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
        .column("stable", Align::Left, rows().map(stable));
    let events = |row| measured(row).and_then(|one| one.events);
    let table = match rows().any(|row| events(row).is_some()) {
        true => table
            .column(
                "events",
                Align::Left,
                rows().map(|row| events(row).map_or(NONE.to_owned(), agreement)),
            )
            .column(
                "their times, s",
                Align::Right,
                rows().map(|row| or_none(events(row).and_then(|events| events.time))),
            ),
        false => table,
    };
    let times = rows().map(|row| measured(row).map(|one| one.time));
    Section {
        heading: format!(
            "Response at {}, compared with {}",
            count(response.instants, "instant", "instants"),
            response.reference
        ),
        table: timed(table, times)
            .column("work", Align::Left, rows().map(work))
            .column("front", Align::Left, on_front)
            .column("", Align::Left, notes),
        remarks: [ERROR.to_owned()]
            .into_iter()
            .chain(response.exceeds_doubles().then(|| EXCEEDS.to_owned()))
            .chain(response.is_still().then(|| {
                let [_, v] = response.peaks;
                format!(
                    "Velocities at these instants are {} at most, which over the whole time would not change the largest displacement in its \
                     last digit: errors of v are parts of what is as good as 0.",
                    scientific(v)
                )
            }))
            .chain([FRONT.to_owned()])
            .chain(
                rows()
                    .any(|row| events(row).is_some())
                    .then(|| EVENTS.to_owned()),
            )
            .chain(remarks(response))
            .collect(),
    }
}

/// How many events agree.
fn agreement(events: EventsFound) -> String {
    let EventsFound {
        expected,
        found,
        in_order,
        ..
    } = events;
    match found == expected && in_order == expected {
        true => format!("all {expected}"),
        false => format!("{in_order} of {expected}, {found} found"),
    }
}

/// Two columns: the median, and the quartiles' distance relative to it.
fn timed(table: Table, times: impl Iterator<Item = Option<RunTime>>) -> Table {
    let times: Vec<Option<RunTime>> = times.collect();
    let of = |pick: fn(&RunTime) -> String| {
        let cell = move |time: &Option<RunTime>| time.as_ref().map_or(NONE.to_owned(), pick);
        times.iter().map(cell).collect::<Vec<String>>()
    };
    let spread = |time: &RunTime| match time.runs {
        1 => "one run".to_owned(),
        _ => {
            let [low, high] = time.quartiles;
            format!("{:.0} %", 100.0 * (high - low) / time.median)
        }
    };
    let (medians, spreads) = (of(|time| scientific(time.median)), of(spread));
    table
        .column("run time, s", Align::Right, medians)
        .column("spread", Align::Right, spreads)
}

fn or_none(value: Option<f64>) -> String {
    value.map_or_else(|| NONE.to_owned(), scientific)
}

/// What a method counted.
fn work(row: &WorkPrecisionRow) -> String {
    let Some(measurement) = measured(row) else {
        return NONE.to_owned();
    };
    let mut parts: Vec<String> = Vec::new();
    let mut add = |count: f64, one: &str, many: &str| {
        if count > 0.0 {
            let name = if count == 1.0 { one } else { many };
            parts.push(format!("{} {name}", short(count)));
        }
    };
    if let Some(work) = measurement.work {
        add(work.accepted as f64, "step", "steps");
        add(work.rejected as f64, "rejected", "rejected");
        add(work.evaluations as f64, "evaluation", "evaluations");
        add(
            work.factorisations as f64,
            "factorisation",
            "factorisations",
        );
        add(work.solves as f64, "solve", "solves");
    }
    if let Some(operations) = measurement.operations {
        add(
            operations.exponentials as f64,
            "exponential",
            "exponentials",
        );
        add(operations.products, "product", "products");
        add(operations.steps as f64, "step", "steps");
    }
    if measurement.digits > 16 {
        parts.push(format!("{} digits", measurement.digits));
    }
    if parts.is_empty() {
        NONE.to_owned()
    } else {
        parts.join(", ")
    }
}

/// What the plan picks and why, and what beats it and why that is not taken.
fn remarks(response: &WorkPrecision) -> Vec<String> {
    let Some(pick) = &response.pick else {
        return Vec::new();
    };
    let picked = &response.rows[pick.row];
    let mut remarks = vec![format!(
        "The plan picks {}: {}.",
        picked.method, pick.reason
    )];
    let Some(own) = measured(picked) else {
        return remarks;
    };
    if own.error.is_none() {
        return remarks;
    }
    let beating = response.beating(pick.row);
    if beating.is_empty() {
        remarks.push("It is on the front.".to_owned());
        return remarks;
    }
    for row in beating
        .iter()
        .take(MOST_NAMED)
        .map(|at| &response.rows[*at])
    {
        let Some(one) = measured(row) else {
            continue;
        };
        let factor = own.time.median / one.time.median;
        let left_out = pick.left_out.iter().find(|(name, _)| *name == row.method);
        let reason = match left_out {
            Some((_, reason)) => reason.as_str(),
            None if row.knob.is_some() => {
                "an integrator has no bound: how far it is off is known beside the exact answer only"
            }
            None => "it is for one mass alone",
        };
        remarks.push(format!(
            "{} is as accurate and {factor:.1} times faster; not taken: {reason}.",
            named(row)
        ));
    }
    if let more @ 1.. = beating.len().saturating_sub(MOST_NAMED) {
        remarks.push(format!("So are {more} more."));
    }
    remarks
}
