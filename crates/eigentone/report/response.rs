//! The trajectory as a table, as JSON and as CSV; all of them written row by row, for it may be
//! large.

use std::io::{self, Write};

use eigentone_response::{Problem, Quantity, SteadyState, Trajectory};
use eigentone_switching::Event;
use faer::MatRef;
use serde::ser::{SerializeMap, SerializeSeq};
use serde::{Serialize, Serializer};

use super::csv;
use super::number;
use super::steady_state::SteadyStateJson;
use super::table::visible;
use super::unit;

/// Prints a trajectory.
#[derive(Clone, Copy, Debug)]
pub struct ResponseReport<'a> {
    trajectory: &'a Trajectory,
    names: &'a [String],
    steady_state: Option<&'a SteadyState>,
    /// What says which coordinates are rotations, and what outputs are.
    problem: Option<&'a Problem<'a>>,
    /// With the places of the switches.
    events: Option<(&'a [Event], &'a [String])>,
}

impl<'a> ResponseReport<'a> {
    /// A report of `trajectory`, with the coordinates' names in order.
    pub fn new(trajectory: &'a Trajectory, names: &'a [String]) -> ResponseReport<'a> {
        ResponseReport {
            trajectory,
            names,
            steady_state: None,
            problem: None,
            events: None,
        }
    }

    /// The same with the units of what `problem` asks for, where all coordinates are said to be in m and outputs have no
    /// unit otherwise.
    pub fn with_units(self, problem: &'a Problem<'a>) -> ResponseReport<'a> {
        ResponseReport {
            problem: Some(problem),
            ..self
        }
    }

    fn unit(&self, coordinate: usize, quantity: Quantity) -> &'static str {
        let system = self.problem.map(Problem::system);
        let kind = system.map_or(unit::KINDS[0], |system| system.kind_of(coordinate));
        unit::motion(Some(kind), quantity)
    }

    /// The outputs' names, each with its unit.
    fn outputs(&self) -> impl Iterator<Item = (&'a str, &'static str)> {
        let problem = self.problem;
        self.trajectory.outputs().enumerate().map(move |(i, name)| {
            let unit = problem.and_then(|problem| {
                let combination = problem.combinations().get(i)?;
                Some(unit::output(problem.system(), combination))
            });
            (name, unit.unwrap_or_default())
        })
    }

    /// The same with events, and what each switch is called: a list in JSON, lines under the table.
    pub fn with_events(self, events: &'a [Event], switches: &'a [String]) -> ResponseReport<'a> {
        ResponseReport {
            events: Some((events, switches)),
            ..self
        }
    }

    /// The same with the steady state under the harmonic loads, which JSON carries unless there are
    /// no such loads.
    pub fn with_steady_state(self, steady_state: Option<&'a SteadyState>) -> ResponseReport<'a> {
        ResponseReport {
            steady_state: steady_state.filter(|steady| !steady.motions().is_empty()),
            ..self
        }
    }

    /// A table of step index, instant, displacements and outputs, six significant digits, one line for each
    /// instant. What has no bound is marked as doubtful.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn text(&self, mut out: impl Write) -> io::Result<()> {
        let steps = self.trajectory.steps();
        let last = steps.iter().max().map_or(0, |step| step.to_string().len());
        let step_width = last.max("step".len());
        let headers = self.names.iter().enumerate().map(|(i, name)| {
            let unit = self.unit(i, Quantity::Displacement);
            unit::labelled(&visible(name), unit)
        });
        let outputs = self.outputs();
        let outputs = outputs.map(|(name, unit)| unit::labelled(&visible(name), unit));
        let headers: Vec<String> = headers.chain(outputs).collect();
        // No number is wider than this: a sign, six digits, the point and a three-digit power.
        let width = |header: &String| header.chars().count().max("−1.23456e−300".chars().count());
        write!(out, "{:>step_width$}  {:>13}", "step", "t, s")?;
        for header in &headers {
            write!(out, "  {header:>0$}", width(header))?;
        }
        writeln!(out)?;
        let displacement = self.trajectory.displacement();
        for (column, (step, time)) in steps.iter().zip(self.trajectory.times()).enumerate() {
            write!(
                out,
                "{step:>step_width$}  {:>13}",
                number::significant(*time)
            )?;
            for (row, header) in headers.iter().enumerate() {
                let value = match row.checked_sub(self.names.len()) {
                    None => displacement[(row, column)],
                    Some(output) => self.trajectory.output(output)[column],
                };
                let value = number::significant(value);
                write!(out, "  {value:>0$}", width(header))?;
            }
            let mark = if self.trajectory.is_doubtful(column) {
                "  ?"
            } else {
                ""
            };
            writeln!(out, "{mark}")?;
        }
        if let Some(doubts) = doubts(self.trajectory) {
            writeln!(
                out,
                "?: {doubts}: no bound is known for them, and what is printed may be far from the motion"
            )?;
        }
        match self.events {
            Some((events, switches)) => {
                out.write_all(super::events::text(events, switches).as_bytes())
            }
            None => Ok(()),
        }
    }

    /// One JSON object: step indices, instants in s, displacements in m and velocities in m/s by
    /// name, and absolute bounds over all coordinates for each instant. Numbers are in the
    /// shortest form that reads back to the same double; a bound that cannot be given is null.
    /// Where outputs were asked for, the keys `outputs` and `output_bound` list their values and absolute bounds by name.
    /// Where events were given, the key `events` lists their instants in s, bounds of these, switches, and what happens.
    /// Where a steady state was given, the key `steady_state` lists the real and imaginary part of
    /// the amplitude of each coordinate in m, with its proven bound, for each frequency in rad/s.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn json(&self, mut out: impl Write) -> io::Result<()> {
        let trajectory = self.trajectory;
        let outputs = trajectory.outputs().next().is_some();
        let json = Json {
            bounds: super::worth(trajectory.bounds()),
            step: trajectory.steps(),
            time: trajectory.times(),
            displacement: Rows(self.names, trajectory.displacement()),
            velocity: Rows(self.names, trajectory.velocity()),
            displacement_bound: trajectory.displacement_bound(),
            velocity_bound: trajectory.velocity_bound(),
            outputs: outputs.then_some(Outputs(trajectory, Trajectory::output)),
            output_bound: outputs.then_some(Outputs(trajectory, Trajectory::output_bound)),
            events: self
                .events
                .map(|(events, switches)| super::events::listed(events, switches)),
            steady_state: self.steady_state.map(|steady_state| SteadyStateJson {
                steady_state,
                names: self.names,
            }),
        };
        serde_json::to_writer(&mut out, &json)?;
        out.write_all(b"\n")
    }

    /// One row for each instant with all digits: step, instant, displacements, velocities, bounds, outputs and
    /// their bounds.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn csv(&self, mut out: impl Write) -> io::Result<()> {
        let trajectory = self.trajectory;
        let mut header = vec!["step".to_owned(), "time [s]".to_owned()];
        let kinds = [
            ("displacement", Quantity::Displacement),
            ("velocity", Quantity::Velocity),
        ];
        for (what, quantity) in kinds {
            let names = self.names.iter().enumerate();
            let cell =
                |(i, name)| unit::bracketed(&format!("{what} {name}"), self.unit(i, quantity));
            header.extend(names.map(cell));
        }
        for (what, quantity) in kinds {
            let unit = match self.problem {
                Some(problem) => unit::of_all(problem.system(), quantity),
                None => self.unit(0, quantity).to_owned(),
            };
            header.push(unit::bracketed(&format!("{what}_bound"), &unit));
        }
        let outputs: Vec<(&str, &str)> = self.outputs().collect();
        for kind in ["output", "output_bound"] {
            let cell =
                |(name, unit): &(&str, &str)| unit::bracketed(&format!("{kind} {name}"), unit);
            header.extend(outputs.iter().map(cell));
        }
        csv::row(&mut out, header)?;
        let (displacement, velocity) = (trajectory.displacement(), trajectory.velocity());
        for (column, step) in trajectory.steps().iter().enumerate() {
            let cells = [step.to_string(), csv::number(trajectory.times()[column])].into_iter();
            let at = |matrix: MatRef<'a, f64>| {
                (0..matrix.nrows()).map(move |row| csv::number(matrix[(row, column)]))
            };
            let bounds = [
                csv::optional(trajectory.displacement_bound()[column]),
                csv::optional(trajectory.velocity_bound()[column]),
            ];
            let cells = cells.chain(at(displacement)).chain(at(velocity));
            let all = 0..outputs.len();
            let values = all
                .clone()
                .map(|i| csv::number(trajectory.output(i)[column]));
            let of_outputs = all.map(|i| csv::optional(trajectory.output_bound(i)[column]));
            csv::row(
                &mut out,
                cells.chain(bounds).chain(values).chain(of_outputs),
            )?;
        }
        Ok(())
    }
}

/// How many samples are doubtful, if any are.
pub(super) fn doubts(trajectory: &Trajectory) -> Option<String> {
    let (count, all) = (trajectory.doubtful(), trajectory.len());
    (count > 0).then(|| match all {
        1 => "the sample is doubtful".to_owned(),
        _ => format!("{count} of {all} samples are doubtful"),
    })
}

/// The contract between this program and what reads its JSON: names and order stay.
#[derive(Serialize)]
struct Json<'a> {
    bounds: &'static str,
    step: &'a [u64],
    time: &'a [f64],
    displacement: Rows<'a>,
    velocity: Rows<'a>,
    displacement_bound: &'a [Option<f64>],
    velocity_bound: &'a [Option<f64>],
    #[serde(skip_serializing_if = "Option::is_none")]
    outputs: Option<Outputs<'a, f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    output_bound: Option<Outputs<'a, Option<f64>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    events: Option<Vec<super::events::Listed<'a>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    steady_state: Option<SteadyStateJson<'a>>,
}

/// Something of each output at the instants, by its name.
struct Outputs<'a, T>(&'a Trajectory, fn(&Trajectory, usize) -> &[T]);

impl<T: Serialize> Serialize for Outputs<'_, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let names = self.0.outputs().enumerate();
        serializer.collect_map(names.map(|(index, name)| (name, self.1(self.0, index))))
    }
}

/// The rows of a matrix as arrays, by name.
struct Rows<'a>(&'a [String], MatRef<'a, f64>);

impl Serialize for Rows<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (row, name) in self.0.iter().enumerate() {
            map.serialize_entry(name, &Row(self.1, row))?;
        }
        map.end()
    }
}

struct Row<'a>(MatRef<'a, f64>, usize);

impl Serialize for Row<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let columns = self.0.ncols();
        let mut seq = serializer.serialize_seq(Some(columns))?;
        for column in 0..columns {
            seq.serialize_element(&self.0[(self.1, column)])?;
        }
        seq.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    #[test]
    fn json_has_the_keys_in_order_and_shortest_numbers() {
        let displacement = Mat::from_fn(2, 3, |i, j| (1 + i) as f64 / 10.0 + j as f64);
        let velocity = Mat::from_fn(2, 3, |_, j| -1e-300 * j as f64);
        let steps = vec![4, 0, 4];
        let times = vec![0.2, 0.0, 0.2];
        let trajectory = Trajectory::new("by hand", steps, times, displacement, velocity)
            .with_bounds(vec![Some(1e-17), None, Some(0.0)], vec![None; 3]);
        let names = ["m\"1".to_owned(), "m2".to_owned()];
        let mut out = Vec::new();
        ResponseReport::new(&trajectory, &names)
            .json(&mut out)
            .expect("a vector takes it");
        let text = String::from_utf8(out).expect("JSON is UTF-8");
        let wanted = concat!(
            r#"{"bounds":"estimated","step":[4,0,4],"time":[0.2,0.0,0.2],"#,
            r#""displacement":{"m\"1":[0.1,1.1,2.1],"m2":[0.2,1.2,2.2]},"#,
            r#""velocity":{"m\"1":[-0.0,-1e-300,-2e-300],"m2":[-0.0,-1e-300,-2e-300]},"#,
            r#""displacement_bound":[1e-17,null,0.0],"velocity_bound":[null,null,null]}"#,
            "\n"
        );
        assert_eq!(text, wanted);
    }

    #[test]
    fn csv_has_every_number_of_the_trajectory() {
        let displacement = Mat::from_fn(1, 2, |_, j| j as f64 / 3.0);
        let velocity = Mat::from_fn(1, 2, |_, j| j as f64 / 7.0);
        let trajectory = Trajectory::new(
            "by hand",
            vec![0, 1],
            vec![0.0, 0.5],
            displacement,
            velocity,
        );
        let mut out = Vec::new();
        ResponseReport::new(&trajectory, &["a,b".to_owned()])
            .csv(&mut out)
            .expect("a vector takes it");
        let text = String::from_utf8(out).expect("CSV is UTF-8");
        let rows: Vec<&str> = text.lines().collect();
        assert_eq!(rows.len(), 3);
        assert!(rows[0].contains("\"displacement a,b [m]\""));
        assert_eq!(rows[2], format!("1,0.5,{:?},{:?},,", 1.0 / 3.0, 1.0 / 7.0));
    }
}
