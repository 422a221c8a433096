//! The table of a motion.

use std::cell::LazyCell;

use eigentone_check::Ball;
use eigentone_modes::CoordinateKind;
use eigentone_response::{Problem, Quantity};

use super::error::TableError;
use super::settle::{MOST_WORK, settled};
use super::sheet::{Cell, Column, Sheet};
use super::value::Value;
use crate::report::unit;

/// A motion at the instants of a problem to [`DIGITS`](super::DIGITS) digits that are all right.
#[derive(Clone, Debug)]
pub struct ResponseTable {
    names: Vec<String>,
    kinds: Vec<CoordinateKind>,
    rows: Vec<ResponseRow>,
}

/// All coordinates at one instant.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ResponseRow {
    /// The index k of the instant.
    pub step: u64,
    /// t_k = k·step, in s.
    pub time: Value,
    /// The displacement of each coordinate, in m or rad.
    pub displacement: Vec<Value>,
    /// The velocity of each coordinate, in m/s or rad/s.
    pub velocity: Vec<Value>,
}

impl ResponseTable {
    /// The motion at the instants that `problem` asks for ([`Problem::at`] chooses them), from the
    /// reference with as many digits as decide each rounding.
    ///
    /// # Errors
    /// [`TableError`] where the reference refuses, or a digit stays open.
    pub fn of(problem: &Problem<'_>) -> Result<ResponseTable, TableError> {
        ResponseTable::within(MOST_WORK, problem)
    }

    /// The same, where no step of the reference takes more than so many multiplications of whole numbers, of which a core does
    /// some ten million in a second: 1e9 for [`of`](Self::of).
    ///
    /// # Errors
    /// As there.
    pub fn within(
        multiplications: f64,
        problem: &Problem<'_>,
    ) -> Result<ResponseTable, TableError> {
        let system = problem.system();
        let names = system.names();
        settled(multiplications, |attempt| {
            let response = attempt.reference.response(problem)?;
            let reference = attempt.reference;
            let resting = LazyCell::new(|| reference.at_rest(problem).unwrap_or_default());
            let rests = |kind: usize, coordinate: usize, step: u64| {
                let until = resting.get(coordinate).map(|kinds| kinds[kind]);
                until.is_some_and(|until| step < until)
            };
            let rows = response.steps().iter().enumerate();
            let rows = rows.map(|(position, &step)| {
                let mut settle = |values: &[Ball], kind: usize| {
                    let quantity = ["displacement", "velocity"][kind];
                    let each = values.iter().zip(names).enumerate();
                    let each = each.map(|(i, (value, name))| {
                        if value.may_be_zero() && rests(kind, i, step) {
                            return Value::ZERO;
                        }
                        let what = || format!("the {quantity} of {name:?} at step {step}");
                        attempt.settle(value, what)
                    });
                    each.collect::<Vec<Value>>()
                };
                let displacement = settle(response.displacement(position), 0);
                let velocity = settle(response.velocity(position), 1);
                let time = response.time(position);
                ResponseRow {
                    step,
                    time: attempt.settle(&time, || format!("the time of step {step}")),
                    displacement,
                    velocity,
                }
            });
            Ok(ResponseTable {
                names: names.to_vec(),
                kinds: (0..names.len()).map(|i| system.kind_of(i)).collect(),
                rows: rows.collect(),
            })
        })
    }

    /// One entry for each instant, in the order asked for.
    pub fn rows(&self) -> &[ResponseRow] {
        &self.rows
    }

    /// The motion as a Markdown table: a row for each instant and coordinate.
    pub fn markdown(&self) -> String {
        self.sheet().markdown()
    }

    /// The same as CSV, units in the header.
    pub fn csv(&self) -> String {
        self.sheet().csv()
    }

    /// The same as a JSON array of objects.
    pub fn json(&self) -> String {
        self.sheet().json("")
    }

    /// The same as a LaTeX `tabular`.
    pub fn latex(&self) -> String {
        self.sheet().latex()
    }

    pub(super) fn sheet(&self) -> Sheet {
        // Where units differ, each row has its own.
        let mixed = self.kinds.iter().any(|kind| *kind != self.kinds[0]);
        let common = self.kinds.first().copied().filter(|_| !mixed);
        let of = |quantity| unit::motion(common, quantity);
        let (displacement, velocity) = (of(Quantity::Displacement), of(Quantity::Velocity));
        let mut columns = vec![
            Column::of("step", "k", "$k$", ""),
            Column::of("time", "t", "$t$", "s"),
            Column::of("coordinate", "coordinate", "coordinate", ""),
            Column::of("displacement", "displacement", "displacement", displacement),
            Column::of("velocity", "velocity", "velocity", velocity),
        ];
        if mixed {
            columns.insert(3, Column::of("unit", "unit", "unit", ""));
        }
        let mut rows = Vec::new();
        for row in &self.rows {
            let motion = row.displacement.iter().zip(&row.velocity);
            for (i, (displacement, velocity)) in motion.enumerate() {
                let mut cells = vec![
                    Cell::Whole(row.step),
                    Cell::Chosen(row.time.clone()),
                    Cell::Text(self.names[i].clone()),
                    Cell::Value(displacement.clone()),
                    Cell::Value(velocity.clone()),
                ];
                if mixed {
                    let unit = unit::motion(Some(self.kinds[i]), Quantity::Displacement);
                    cells.insert(3, Cell::Text(unit.to_owned()));
                }
                rows.push(cells);
            }
        }
        Sheet { columns, rows }
    }
}
