//! A periodic motion, as tables, JSON and CSV.

use std::collections::BTreeMap;
use std::io;

use eigentone_modes::System;
use eigentone_response::Quantity;
use eigentone_switching::LimitCycle;
use serde::Serialize;

use super::table::{Align, Table};
use super::{csv, events, number, unit};

/// Prints a limit cycle: its period, what becomes of disturbances, its start and its events.
#[derive(Clone, Copy, Debug)]
pub struct CycleReport<'a> {
    /// What moves.
    pub system: &'a System,
    /// The motion.
    pub cycle: &'a LimitCycle,
    /// What each switch is called.
    pub switches: &'a [String],
}

/// In JSON: names and order stay.
#[derive(Serialize)]
struct Described<'a> {
    bounds: &'static str,
    period: f64,
    period_bound: f64,
    stable: Option<bool>,
    reached: bool,
    multipliers: Vec<[f64; 2]>,
    start: BTreeMap<&'a str, Start>,
    events: Vec<events::Listed<'a>>,
}

#[derive(Serialize)]
struct Start {
    displacement: f64,
    displacement_bound: f64,
    velocity: f64,
    velocity_bound: f64,
}

impl CycleReport<'_> {
    /// For people.
    pub fn text(&self) -> String {
        let cycle = self.cycle;
        let [period, hertz] = [cycle.period, 1.0 / cycle.period].map(number::significant);
        let bound = number::bound(cycle.period_bound);
        let factor = cycle.multipliers.first().map_or(0.0, |first| first.norm());
        let factor = number::significant(factor);
        let fate = match cycle.stable {
            Some(true) => {
                format!("stable: each period multiplies a small disturbance by {factor}")
            }
            Some(false) => {
                format!("unstable: each period multiplies a small disturbance by {factor}")
            }
            None => format!(
                "doubles do not show whether it is stable: each period multiplies a small disturbance by {factor}"
            ),
        };
        let mut text = format!(
            "period {period} s ({hertz} Hz), estimated to be within {bound} s of the exact one\n{fate}\n"
        );
        if !cycle.is_reached {
            text.push_str("the scene's own motion does not end near this one: it may need more time, or tend to another, such as one of twice the period\n");
        }
        text.push('\n');
        let of = |part: fn(&faer::c64) -> f64| {
            cycle
                .multipliers
                .iter()
                .map(move |one| number::significant(part(one)))
        };
        let table = Table::default()
            .column("multiplier, re", Align::Right, of(|one| one.re))
            .column("im", Align::Right, of(|one| one.im))
            .column("modulus", Align::Right, of(|one| one.norm()));
        text.push_str(&table.text());
        text.push_str("Multipliers (Floquet): the eigenvalues of the matrix by which one period multiplies a small disturbance.\n");
        text.push_str("\nstate at the start of a period\n");
        let names = self.system.names();
        let units = |quantity| {
            (0..names.len()).map(move |i| unit::motion(Some(self.system.kind_of(i)), quantity))
        };
        let values = |values: &[f64]| {
            values
                .iter()
                .map(|value| number::significant(*value))
                .collect::<Vec<_>>()
        };
        let table = Table::default()
            .column("of", Align::Left, names)
            .column("displacement", Align::Right, values(&cycle.displacement))
            .column("", Align::Left, units(Quantity::Displacement))
            .column("velocity", Align::Right, values(&cycle.velocity))
            .column("", Align::Left, units(Quantity::Velocity));
        text.push_str(&table.text());
        text.push_str(&events::text(&cycle.events, self.switches));
        text
    }

    /// One object, with every digit.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn json(&self, mut out: impl io::Write) -> io::Result<()> {
        let cycle = self.cycle;
        let start = self.system.names().iter().enumerate().map(|(i, name)| {
            let start = Start {
                displacement: cycle.displacement[i],
                displacement_bound: cycle.bound[0][i],
                velocity: cycle.velocity[i],
                velocity_bound: cycle.bound[1][i],
            };
            (name.as_str(), start)
        });
        let described = Described {
            bounds: "estimated",
            period: cycle.period,
            period_bound: cycle.period_bound,
            stable: cycle.stable,
            reached: cycle.is_reached,
            multipliers: cycle
                .multipliers
                .iter()
                .map(|one| [one.re, one.im])
                .collect(),
            start: start.collect(),
            events: events::listed(&cycle.events, self.switches),
        };
        serde_json::to_writer(&mut out, &described)?;
        writeln!(out)
    }

    /// The start, with every digit.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn csv(&self, mut out: impl io::Write) -> io::Result<()> {
        let header = [
            "name",
            "displacement",
            "displacement_bound",
            "velocity",
            "velocity_bound",
            "unit",
        ];
        csv::row(&mut out, header.map(str::to_owned))?;
        for (i, name) in self.system.names().iter().enumerate() {
            let [x, v] = &self.cycle.bound;
            let numbers = [
                self.cycle.displacement[i],
                x[i],
                self.cycle.velocity[i],
                v[i],
            ];
            let unit = unit::motion(Some(self.system.kind_of(i)), Quantity::Displacement);
            let row = [name.clone()].into_iter().chain(numbers.map(csv::number));
            csv::row(&mut out, row.chain([unit.to_owned()]))?;
        }
        Ok(())
    }
}
