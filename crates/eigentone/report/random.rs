//! Root mean squares of stationary motions, and how often they pass through 0, as a table, JSON and CSV.

use std::io::{self, Write};

use eigentone_modes::{Bounds, System};
use eigentone_response::{Combination, Quantity, Rms, StationaryMotion};
use serde::{Serialize, Serializer};

use super::table::{Align, Table};
use super::{csv, number, unit};

/// Prints root mean squares.
#[derive(Clone, Copy, Debug)]
pub struct RandomReport<'a> {
    /// What moves.
    pub system: &'a System,
    /// What was asked for beside the motions of coordinates and points, in the order of the answers.
    pub outputs: &'a [Combination],
    /// The answers.
    pub motion: &'a StationaryMotion,
}

/// A root mean square, or how often displacements pass through 0: of what, which quantity of it, its unit.
type Row<'a> = (&'a str, &'static str, &'static str, Rms);

impl<'a> RandomReport<'a> {
    fn rows(&self) -> Vec<Row<'a>> {
        let mut rows: Vec<Row<'a>> = Vec::new();
        let motion = self.motion;
        let motions = [
            (
                "displacement",
                Quantity::Displacement,
                motion.displacement(),
            ),
            ("velocity", Quantity::Velocity, motion.velocity()),
            (
                "acceleration",
                Quantity::Acceleration,
                motion.acceleration(),
            ),
        ];
        for (word, quantity, all) in motions {
            let unit = |name: &str| unit::motion(self.system.kind_at(name), quantity);
            let row =
                |(name, rms): &'a (String, Rms)| (name.as_str(), word, unit(name), rms.clone());
            rows.extend(all.iter().map(row));
        }
        let outputs = self.outputs.iter().zip(motion.outputs());
        rows.extend(outputs.map(|(output, (name, rms))| {
            let unit = unit::output(self.system, output);
            (name.as_str(), "output", unit, rms.clone())
        }));
        let crossings = motion.zero_crossings().into_iter();
        rows.extend(
            crossings.filter_map(|(name, rate)| Some((name, "zero crossings", "Hz", rate?))),
        );
        rows
    }

    /// A table, and how much of it is proven.
    pub fn text(&self) -> String {
        let rows = self.rows();
        let known = rows.iter().map(|(.., rms)| match rms {
            Rms::Finite { value, bound } => Some((*value, *bound)),
            Rms::Infinite { .. } | Rms::Undecided { .. } => None,
        });
        let bounds = rows.iter().map(|(.., rms)| match rms {
            Rms::Finite { bound, .. } => number::bound(*bound),
            Rms::Infinite { .. } | Rms::Undecided { .. } => number::NONE.to_owned(),
        });
        let mut table = Table::default()
            .column("of", Align::Left, rows.iter().map(|row| row.0))
            .column("what", Align::Left, rows.iter().map(|row| row.1))
            .column("r.m.s.", Align::Point, number::told_column(known))
            .column("unit", Align::Left, rows.iter().map(|row| row.2))
            .column("proven within", Align::Right, bounds);
        let reasons: Vec<String> = rows.iter().map(|row| reason(&row.3)).collect();
        if reasons.iter().any(|reason| !reason.is_empty()) {
            table = table.column("why", Align::Left, &reasons);
        }
        table.text()
    }

    /// One JSON object; what is not finite is null, with a `reason`.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn json(&self, mut out: impl Write) -> io::Result<()> {
        let motion = self.motion;
        let json = Json {
            bounds: super::worth(Bounds::Proven),
            rms: Quantities {
                displacement: Map(motion.displacement()),
                velocity: Map(motion.velocity()),
                acceleration: Map(motion.acceleration()),
                outputs: Map(motion.outputs()),
            },
            zero_crossings: Crossings(motion.zero_crossings()),
        };
        serde_json::to_writer(&mut out, &json)?;
        writeln!(out)
    }

    /// A row for each root mean square, with all digits; empty cells where it is not finite.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn csv(&self, mut out: impl Write) -> io::Result<()> {
        csv::row(&mut out, ["of", "what", "unit", "rms", "bound", "reason"])?;
        for (of, what, unit, rms) in self.rows() {
            let [value, bound] = match &rms {
                Rms::Finite { value, bound } => [csv::number(*value), csv::number(*bound)],
                Rms::Infinite { .. } | Rms::Undecided { .. } => [String::new(), String::new()],
            };
            let (of, reason) = (csv::text(of), reason(&rms));
            csv::row(&mut out, [&of, what, unit, &value, &bound, &reason])?;
        }
        Ok(())
    }
}

/// Why there is no number; nothing where there is one.
fn reason(rms: &Rms) -> String {
    match rms {
        Rms::Finite { .. } => String::new(),
        Rms::Infinite { by } => format!("infinite under white noise: {by}"),
        Rms::Undecided { by } => format!("not told from infinite under white noise: {by}"),
    }
}

#[derive(Serialize)]
struct Json<'a> {
    bounds: &'static str,
    rms: Quantities<'a>,
    zero_crossings: Crossings<'a>,
}

#[derive(Serialize)]
struct Quantities<'a> {
    displacement: Map<'a>,
    velocity: Map<'a>,
    acceleration: Map<'a>,
    outputs: Map<'a>,
}

struct Map<'a>(&'a [(String, Rms)]);

#[derive(Serialize)]
struct Value {
    value: Option<f64>,
    bound: Option<f64>,
    #[serde(skip_serializing_if = "String::is_empty")]
    reason: String,
}

impl Value {
    fn of(rms: &Rms) -> Value {
        let (value, bound) = match rms {
            Rms::Finite { value, bound } => (Some(*value), Some(*bound)),
            Rms::Infinite { .. } | Rms::Undecided { .. } => (None, None),
        };
        let reason = reason(rms);
        Value {
            value,
            bound,
            reason,
        }
    }
}

impl Serialize for Map<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, rms)| (name, Value::of(rms))))
    }
}

struct Crossings<'a>(Vec<(&'a str, Option<Rms>)>);

impl Serialize for Crossings<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let all = self.0.iter();
        serializer.collect_map(all.map(|(name, rate)| (name, rate.as_ref().map(Value::of))))
    }
}
