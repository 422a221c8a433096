//! Everything about one scene on one page of text, and its plots.

use std::fmt::Write;

use eigentone_modes::{
    Bounds, CoordinateKind, Modes, Participation, ParticipationError, Structure, System,
};
use eigentone_response::{
    Destination, Problem, Quantity, Reached, ResponsePlan, SteadyState, SteadyStateError, Summary,
    Trajectory,
};

use super::axis::Axis;
use super::demands::DemandReport;
use super::modes::ModeReport;
use super::number;
use super::outline::{self, Outline};
use super::participation;
use super::plot::{Line, Plot};
use super::response::doubts;
use super::steady_state::SteadyStateReport;
use super::switched::SwitchedReport;
use super::table::{Align, Table, visible};
use super::unit;

/// What was found out about a scene.
pub struct Analysis<'a> {
    /// What it is called.
    pub title: &'a str,
    /// Its system.
    pub system: &'a System,
    /// What was proved of the system.
    pub structure: &'a Structure,
    /// Its modes.
    pub modes: &'a Modes,
    /// Effective modal masses of the parts that springs and dampers join: [`Participation::of_parts`].
    pub participation: &'a [(Vec<usize>, Result<Participation, ParticipationError>)],
    /// Its response, if one was asked for.
    pub response: Option<Answer<'a>>,
    /// Its motion, if it has switches.
    pub switched: Option<SwitchedReport<'a>>,
}

/// The text has participation of parts of so many modes at most; [`Page`](super::Page) has all that there are.
pub const MOST_PARTICIPATING: usize = 24;

/// A response, how it was computed, and what becomes of each coordinate.
pub struct Answer<'a> {
    /// What was asked.
    pub problem: &'a Problem<'a>,
    /// The method and why.
    pub plan: &'a ResponsePlan,
    /// The motion.
    pub trajectory: &'a Trajectory,
    /// The motion in a few numbers.
    pub summary: &'a Summary,
    /// What remains under the harmonic loads; without any it is empty.
    pub steady_state: &'a Result<SteadyState, SteadyStateError>,
}

/// Why there is no motion.
const NO_TIME: &str = "the scene has no `time`";

impl Analysis<'_> {
    /// Title, what was proved, what ran, the mode table with shapes, the response in a few numbers for each mass, peaks of
    /// accelerations and forces where the trajectory has them, and how far the numbers can be off.
    pub fn text(&self) -> String {
        let mut plan = format!("modes by {}", self.modes.plan().solver);
        let _ = match (&self.response, &self.switched) {
            (Some(answer), _) => write!(plan, "; response by {}", answer.plan.method.name()),
            (None, Some(report)) => {
                write!(plan, "; response {}", report.motion.trajectory().method())
            }
            (None, None) => write!(plan, "; no response: {NO_TIME}"),
        };
        plan.push_str(" (--explain says why)");
        self.with_plan(&plan)
    }

    /// The same with the whole plan: why these methods ran and what was left out.
    pub fn explained(&self) -> String {
        self.with_plan(&self.plan())
    }

    /// Why these methods ran and what was left out, in lines.
    pub(super) fn plan(&self) -> String {
        let mut plan = self.modes.plan().to_string();
        let _ = match (&self.response, &self.switched) {
            (Some(answer), _) => write!(plan, "\n{}", answer.plan),
            (None, Some(report)) => write!(
                plan,
                "\nresponse {}: the scene has switches, and is linear between their events",
                report.motion.trajectory().method()
            ),
            (None, None) => write!(plan, "\nleft out the response: {NO_TIME}"),
        };
        plan
    }

    fn with_plan(&self, plan: &str) -> String {
        let mut text = format!("{}\n", visible(self.title));
        section(&mut text, "Structure", &self.structure.to_string());
        section(&mut text, "Plan", plan);
        let modes = ModeReport::new(self.modes, self.system.names());
        section(&mut text, "Modes", &modes.text());
        if let Some(shapes) = modes.shapes() {
            section(&mut text, "Shapes", &shapes);
        }
        let parts = participation::parts(self).into_iter();
        let parts = parts.filter_map(|(heading, part)| Some((heading, part.ok()?)));
        let mut parts = parts
            .filter(|(_, table)| table.rows() <= MOST_PARTICIPATING)
            .peekable();
        while let Some((heading, table)) = parts.next() {
            let explained = match parts.peek() {
                Some(_) => "",
                None => participation::EXPLAINED,
            };
            section(&mut text, &heading, &(table.text() + explained));
        }
        if let Some(answer) = &self.response {
            let table = answer.table(self.system).text() + &answer.explained();
            section(&mut text, &answer.heading(), &table);
            if let Some(outputs) = answer.outputs() {
                section(&mut text, "Outputs", &outputs.text());
            }
            let extrema = answer.summary.extrema();
            let demands = DemandReport::new(answer.problem, answer.trajectory, extrema);
            if let Some(demands) = demands.text() {
                section(&mut text, "Accelerations and forces", &demands);
            }
            if let Some(steady) = answer.steady(self.system, self.modes) {
                section(&mut text, "Steady state under the harmonic loads", &steady);
            }
        }
        if let Some(report) = &self.switched {
            for (heading, body) in report.sections() {
                section(&mut text, &heading, &body);
            }
        }
        section(&mut text, "Bounds", &self.bounds());
        text
    }

    /// Displacements and velocities against time, if there is a response, of rotations apart from the others: lines
    /// through the samples, the jumps and the extrema. Before each stands what it shows, such as `angular velocity`.
    pub fn motion_plots(&self) -> Vec<(&'static str, Plot<'_>)> {
        let Some(answer) = &self.response else {
            return Vec::new();
        };
        let both = unit::kinds(self.system).flat_map(|kind| {
            [outline::Quantity::Displacement, outline::Quantity::Velocity]
                .map(|quantity| (quantity.name(kind), self.plot(kind, quantity, answer)))
        });
        both.collect()
    }

    /// Each output against time, in their order: lines through the samples, the jumps and the extrema.
    pub fn output_plots(&self) -> Vec<Plot<'_>> {
        let Some(answer) = &self.response else {
            return Vec::new();
        };
        let (trajectory, extrema) = (answer.trajectory, answer.summary.extrema());
        let plot = |(index, name)| {
            let values = trajectory.output(index);
            let peaks = extrema.and_then(|extrema| extrema.output(index));
            let outline = Outline::of_peaks(trajectory.times(), move |k| values[k], peaks);
            let combination = answer.problem.combinations().get(index);
            let unit = combination.map(|sum| unit::output(self.system, sum));
            Plot {
                title: self.title.to_owned(),
                x: Axis::linear("time", "s"),
                y: Axis::linear(name, unit.unwrap_or_default()),
                lines: vec![Line::new(name, outline.len(), move |k| outline.point(k))],
                ring: None,
            }
        };
        trajectory.outputs().enumerate().map(plot).collect()
    }

    fn plot<'b>(
        &'b self,
        kind: CoordinateKind,
        quantity: outline::Quantity,
        answer: &'b Answer<'_>,
    ) -> Plot<'b> {
        let names = self.system.names().iter().enumerate();
        let names = names.filter(|(row, _)| self.system.kind_of(*row) == kind);
        let lines = names.map(|(row, name)| {
            let outline = Outline::of(quantity, answer.trajectory, answer.summary, row);
            Line::new(name, outline.len(), move |k| outline.point(k))
        });
        Plot {
            title: match doubts(answer.trajectory) {
                Some(doubts) => format!("{} ({doubts})", self.title),
                None => self.title.to_owned(),
            },
            x: Axis::linear("time", "s"),
            y: quantity.axis(kind),
            lines: lines.collect(),
            ring: None,
        }
    }

    /// The motion, with switches or without.
    pub(super) fn trajectory(&self) -> Option<&Trajectory> {
        let linear = self.response.as_ref().map(|answer| answer.trajectory);
        linear.or_else(|| Some(self.switched.as_ref()?.motion.trajectory()))
    }

    /// What kind of bounds these are, and the largest.
    pub(super) fn bounds(&self) -> String {
        let roots = self.modes.eigenvalues();
        let relative = roots.iter().filter_map(|root| {
            let size = root.value.norm();
            root.bound.filter(|_| size > 0.0).map(|bound| bound / size)
        });
        let mut text = match self.modes.bounds() {
            Bounds::Proven => "modes proven",
            Bounds::Estimated => "modes estimated to first order",
        }
        .to_owned();
        if let Some(worst) = relative.reduce(f64::max) {
            let _ = write!(text, ": λ within {} of |λ|", number::bound(worst));
        }
        let without = roots.iter().filter(|root| root.bound.is_none()).count();
        if without > 0 {
            let _ = write!(text, "; {without} of {} roots are doubtful", roots.len());
        }
        if let Some(trajectory) = self.trajectory() {
            let _ = match trajectory.bounds() {
                Bounds::Proven => write!(
                    text,
                    "\nresponse proven, computed with {} digits",
                    trajectory.digits()
                ),
                Bounds::Estimated => write!(text, "\nresponse estimated to first order"),
            };
            let mut separator = ": ";
            let all = |quantity| unit::of_all(self.system, quantity);
            for (quantity, unit, bounds) in [
                (
                    "displacements",
                    all(Quantity::Displacement),
                    trajectory.displacement_bound(),
                ),
                (
                    "velocities",
                    all(Quantity::Velocity),
                    trajectory.velocity_bound(),
                ),
            ] {
                let largest = bounds.iter().flatten().copied().reduce(f64::max);
                let _ = match largest.map(number::bound) {
                    Some(worst) => write!(text, "{separator}{quantity} within {worst} {unit}"),
                    None => write!(text, "{separator}none can be given for {quantity}"),
                };
                separator = "; ";
                let without = bounds.iter().filter(|bound| bound.is_none()).count();
                if (1..bounds.len()).contains(&without) {
                    let without = number::count(without, "sample", "samples");
                    let _ = write!(text, " where there is one, at all but {without}");
                }
            }
            if let Some(doubts) = doubts(trajectory) {
                let _ = write!(text, "; {doubts}");
            }
        }
        let kinds = [
            Some(self.modes.bounds()),
            self.trajectory().map(Trajectory::bounds),
        ];
        if kinds.contains(&Some(Bounds::Proven)) {
            text += "\nProven: no value is farther from the exact one, rounding included.";
        }
        if kinds.contains(&Some(Bounds::Estimated)) {
            text += "\nEstimated to first order: the error is hardly ever larger, but that is not proven.";
        }
        text
    }
}

impl Answer<'_> {
    pub(super) fn heading(&self) -> String {
        heading(self.trajectory)
    }

    /// The steady state or why there is none; `None` without harmonic loads.
    fn steady(&self, system: &System, modes: &Modes) -> Option<String> {
        match self.steady_state {
            Ok(steady_state) => (!steady_state.motions().is_empty()).then(|| {
                let report = SteadyStateReport {
                    steady_state,
                    names: system.names(),
                    summary: self.summary,
                    modes,
                };
                report.text(system)
            }),
            Err(error) => Some(format!("none: {error}")),
        }
    }

    /// The largest value of each output, at any time where that is known, and how far it may be off; `None` without any.
    pub(super) fn outputs(&self) -> Option<Table> {
        let trajectory = self.trajectory;
        let names: Vec<&str> = trajectory.outputs().collect();
        let extrema = self.summary.extrema();
        let between = |index: usize| Some(extrema?.output(index)?.largest());
        let between: Option<Vec<Reached>> = (0..names.len()).map(between).collect();
        let is_between = between.is_some();
        let at_a_sample = |index: usize| {
            let values = trajectory.output(index).iter().copied().enumerate();
            let (k, value) = values.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
            let bounds = trajectory.output_bound(index).iter().copied();
            let bound = bounds.reduce(|a, b| Some(a?.max(b?)))?;
            Some((value, trajectory.times()[k], bound))
        };
        let known = |peak: Reached| Some((peak.value, peak.time, Some(peak.bound)));
        let peaks: Vec<Option<(f64, f64, Option<f64>)>> = match between {
            Some(peaks) => peaks.into_iter().map(known).collect(),
            None => (0..names.len()).map(at_a_sample).collect(),
        };
        let values = peaks.iter().map(|peak| peak.map(|(value, ..)| value));
        let times = peaks.iter().map(|peak| peak.map(|(_, time, _)| time));
        let bounds = peaks.iter().map(|peak| peak.and_then(|(.., bound)| bound));
        (!names.is_empty()).then(|| {
            let combinations = self.problem.combinations().iter();
            let unit = |combination| unit::output(self.problem.system(), combination);
            let units: Vec<&str> = combinations.map(unit).collect();
            let table = Table::default().column(
                "output",
                Align::Left,
                names.iter().map(|name| visible(name)),
            );
            let table = match units.iter().any(|unit| !unit.is_empty()) {
                true => table.column("unit", Align::Left, units),
                false => table,
            };
            let (largest, bound) = match is_between {
                true => ("largest, between samples too", "its error, estimated"),
                false => ("largest at a sample", "bound of its error"),
            };
            table
                .column(largest, Align::Point, number::column(values))
                .column("at, s", Align::Point, number::column(times))
                .column(
                    bound,
                    Align::Right,
                    bounds.map(|bound| bound.map_or(number::NONE.to_owned(), number::bound)),
                )
        })
    }

    /// What becomes of each coordinate.
    pub(super) fn table(&self, system: &System) -> Table {
        let all = self.summary.coordinates();
        let rest = |destination| match destination {
            Destination::Rest { displacement, .. } => Some(displacement),
            _ => None,
        };
        let ends = number::column(all.iter().map(|one| rest(one.destination)));
        let ends = all
            .iter()
            .zip(ends)
            .map(|(one, number)| match one.destination {
                Destination::Oscillation => "keeps oscillating".to_owned(),
                Destination::Drift => "drifts".to_owned(),
                Destination::Growth => "grows".to_owned(),
                Destination::Unknown => "not known".to_owned(),
                _ => number,
            });
        let settled = |destination| match destination {
            Destination::Rest { settled, .. } => settled,
            _ => None,
        };
        let overshoot = |destination| match destination {
            Destination::Rest { overshoot, .. } => overshoot.map(|beyond| 100.0 * beyond),
            _ => None,
        };
        let times = number::column(all.iter().map(|one| settled(one.destination)));
        let times = all.iter().zip(times).enumerate();
        let times = times.map(|(i, (one, time))| match one.destination {
            Destination::Rest { settled: None, .. } if self.summary.is_open(i) => {
                "not known".to_owned()
            }
            Destination::Rest { settled: None, .. } => "not yet".to_owned(),
            _ => time,
        });
        let table = Table::default().column("mass", Align::Left, system.names());
        let (table, unit) = unit::column(table, system, Quantity::Displacement, 1);
        table
            .column(&unit::labelled("ends at", unit), Align::Point, ends)
            .column(
                &unit::labelled("peak", unit),
                Align::Point,
                number::column(all.iter().map(|one| Some(one.peak))),
            )
            .column(
                "peak at, s",
                Align::Point,
                number::column(all.iter().map(|one| Some(one.peak_time))),
            )
            .column(
                "overshoot, %",
                Align::Point,
                number::column(all.iter().map(|one| overshoot(one.destination))),
            )
            .column("settled after, s", Align::Point, times)
    }

    /// What the columns mean.
    pub(super) fn explained(&self) -> String {
        let explained = if self.summary.is_between() {
            "Ends at: the equilibrium under the loads that last, the final value of samples among them. Peak: the\n\
             largest displacement, between samples too. Overshoot: how far the motion goes beyond that end, in % of the way\n\
             from its start to that end; given where this way is at least a tenth of the largest distance from that end.\n\
             Settled after: the last time farther from that end than 2 % of the largest distance; it is shown to stay nearer for\n\
             all time after, also beyond the last sample.\n"
        } else {
            "Ends at: the equilibrium under the loads that last, the final value of samples among them. Peak: the\n\
             largest displacement at a sample. Overshoot: how far the motion goes beyond that end, in % of the way\n\
             from its start to that end; given where this way is at least a tenth of the largest distance from that end.\n\
             Settled after: the last sample farther from that end than 2 % of the largest distance; it is shown to stay nearer\n\
             after the last sample of all.\n"
        };
        let mut explained = explained.to_owned();
        let all = self.summary.coordinates();
        if all
            .iter()
            .any(|one| one.destination == Destination::Unknown)
        {
            explained += UNKNOWN;
        }
        if (0..all.len()).any(|i| self.summary.is_open(i)) {
            explained += OPEN;
        }
        explained
    }
}

/// What an end that is *not known* means.
const UNKNOWN: &str = "Not known: a load changes so late that following the motion until then takes too long; end later than that.\n\
    Or a damper is so small beside others that rounding decides where what it slows comes to rest.\n";

/// What a time that is *not known* means.
const OPEN: &str = "Not known: it is not shown to come that near and stay so.\n";

/// How many samples there are, until when.
pub(super) fn heading(trajectory: &Trajectory) -> String {
    let times = trajectory.times();
    let end = times.last().map_or(0.0, |end| *end);
    let samples = number::count(times.len(), "sample", "samples");
    match times.len() {
        1 => format!("Response, {samples} at {} s", number::short(end)),
        _ => format!("Response, {samples} from 0 to {} s", number::short(end)),
    }
}

/// A heading, and its lines indented.
fn section(text: &mut String, heading: &str, body: &str) {
    let _ = writeln!(text, "\n{heading}");
    for line in body.lines() {
        let _ = writeln!(text, "  {line}");
    }
}

#[cfg(test)]
mod tests {
    use eigentone_modes::GROUND;
    use eigentone_response::{Response, State, Step};

    use super::*;

    /// v = −3 sin t, and under a force from 0.1 s on a jump of the acceleration: lines have what samples 2 s apart miss, and the
    /// table has the largest value.
    #[test]
    fn outputs_show_what_lies_between_the_samples() {
        let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 1.0);
        let system = system.build().expect("a system");
        let ask = |response: Response<'_>| {
            let problem = response
                .sum("speed", [(Quantity::Velocity, "m", 1.0)])
                .sum("comfort", [(Quantity::Acceleration, "m", 1.0)])
                .every(2.0)
                .until(6.0)
                .problem()
                .expect("a problem");
            let plan = ResponsePlan::of(&problem).expect("a plan");
            let trajectory = plan.run(&problem).expect("a motion");
            let modes = system.modes().expect("modes");
            let summary = Summary::of(&problem, &trajectory, &modes).expect("an instant");
            let analysis = Analysis {
                title: "one mass",
                system: &system,
                structure: system.structure(),
                modes: &modes,
                participation: &[],
                switched: None,
                response: Some(Answer {
                    problem: &problem,
                    plan: &plan,
                    trajectory: &trajectory,
                    summary: &summary,
                    steady_state: &SteadyState::of(&problem),
                }),
            };
            let extrema = summary.extrema().expect("it is easily followed");
            let points = |i| {
                let peaks = extrema.output(i);
                Outline::of_peaks(trajectory.times(), |_| 0.0, peaks).len()
            };
            assert_eq!(analysis.output_plots().len(), 2);
            (analysis.text(), points(0), points(1))
        };
        let from = State::at_rest().displace("m", 3.0);
        let (text, speed, _) = ask(Response::of(&system).from(from));
        assert!(text.contains("largest, between samples too"), "{text}");
        assert!(text.contains("−3.00000  1.57080"), "{text}");
        // Four samples, the highest and the lowest.
        assert_eq!(speed, 6);
        let step = Step::of(1.0).starting_at(0.1);
        let (_, _, comfort) = ask(Response::of(&system).load("m", step));
        // Four samples, both sides of the jump, of which one is the highest, and the lowest.
        assert_eq!(comfort, 7);
    }
}
