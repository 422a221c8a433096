//! Families of systems, each with one parameter that is taken from harmless to extreme.

use eigentone_modes::{BuildError, GROUND, System};
use eigentone_response::{Problem, ResponseError, State, TimeGrid, Trajectory};
use faer::Mat;
use num_complex::Complex;

use crate::closed_form::{ChainEnds, ExactMotion, UniformChain};
use crate::truth::{ModesTruth, MotionTruth};

/// What makes the far end of a family hard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Difficulty {
    /// One spring is far stiffer than the others.
    Stiffness,
    /// A damper is far weaker or far stronger than what would be critical.
    Damping,
    /// One mass is far lighter than the others.
    Mass,
    /// One step is far longer or far shorter than the fastest motion takes.
    Step,
    /// The end is many periods away.
    Horizon,
    /// There are many coordinates.
    Size,
}

/// Systems and questions that differ in one parameter.
#[derive(Clone, Debug)]
pub struct Family {
    /// What it is called.
    pub name: &'static str,
    /// The parameter, as the label of an axis.
    pub parameter: &'static str,
    /// The system in one sentence.
    pub about: &'static str,
    /// What makes its far end hard.
    pub difficulty: Difficulty,
    /// The parameter's values, ascending.
    pub values: Vec<f64>,
    /// The period, in s, of the motion that steps are to resolve.
    pub(super) period: f64,
    /// Whether the modes change with the parameter.
    pub(super) modes: bool,
    build: fn(f64) -> Result<Case, BuildError>,
}

/// One member of a family: a system let go, and the instants at which it is looked at.
pub(super) struct Case {
    pub(super) system: System,
    start: State,
    step: f64,
    instants: Vec<u64>,
    /// For systems that are too large for the reference.
    closed_form: ClosedForm,
}

type ClosedForm = fn(&System, &Problem<'_>) -> Option<(MotionTruth, ModesTruth)>;

/// No closed form: the reference serves.
fn none(_: &System, _: &Problem<'_>) -> Option<(MotionTruth, ModesTruth)> {
    None
}

impl Case {
    /// The true motion, and the true modes if they are `wanted`.
    pub(super) fn truth(&self, wanted: bool) -> Result<(MotionTruth, Option<ModesTruth>), String> {
        let message = |error: ResponseError| error.to_string();
        let problem = self.problem().map_err(message)?;
        if let Some((motion, modes)) = (self.closed_form)(&self.system, &problem) {
            return Ok((motion, wanted.then_some(modes)));
        }
        let motion = MotionTruth::of(&problem).map_err(message)?;
        let modes = wanted.then(|| ModesTruth::of(&self.system)).transpose();
        Ok((motion, modes.map_err(|error| error.to_string())?))
    }

    pub(super) fn problem(&self) -> Result<Problem<'_>, ResponseError> {
        let last = self.instants.last().copied().unwrap_or(0);
        let grid = TimeGrid::new(self.step, self.step * last as f64)?;
        Problem::new(&self.system, &self.start, Vec::new(), grid)?.at(&self.instants)
    }
}

/// How many instants are looked at.
const INSTANTS: u64 = 100;

impl Family {
    pub(super) fn case(&self, value: f64) -> Result<Case, BuildError> {
        (self.build)(value)
    }

    /// The six families of the study: stiffness ratio 1 … 1e20, damping ratio 1e-16 … 1e8, mass ratio
    /// 1 … 1e20, ‖A‖h from 1e-8 to 1e12, 1 … 1e8 periods, and 1 … 500 coordinates.
    pub fn all() -> Vec<Family> {
        let powers = |range: std::ops::RangeInclusive<i32>, by: usize| -> Vec<f64> {
            range
                .step_by(by)
                .map(|k| format!("1e{k}").parse().expect("a number"))
                .collect()
        };
        const TURN: f64 = std::f64::consts::TAU;
        vec![
            Family {
                name: "stiffness",
                parameter: "stiffness ratio",
                about: "Three masses between walls; the spring between the first two is stiffer than the others by the ratio.",
                difficulty: Difficulty::Stiffness,
                values: powers(0..=20, 2),
                period: TURN / 0.6,
                modes: true,
                build: stiffness,
            },
            Family {
                name: "damping",
                parameter: "damping ratio",
                about: "Two masses on two springs; a damper holds the lower one, critical by itself at a ratio of 1.",
                difficulty: Difficulty::Damping,
                values: powers(-16..=8, 2),
                period: TURN / 1.6,
                modes: true,
                build: damping,
            },
            Family {
                name: "mass",
                parameter: "mass ratio",
                about: "Three masses between walls, with equal springs; the middle one is lighter than the others by the ratio.",
                difficulty: Difficulty::Mass,
                values: powers(0..=20, 2),
                period: TURN / 1.2,
                modes: true,
                build: mass,
            },
            Family {
                name: "step",
                parameter: "‖A‖h",
                about: "Two masses, one of them on a damper that is 100 times critical; 100 steps of the grid, each h long.",
                difficulty: Difficulty::Step,
                values: powers(-8..=12, 2),
                period: TURN,
                modes: false,
                build: step,
            },
            Family {
                name: "horizon",
                parameter: "periods",
                about: "Two masses without dampers, looked at 100 times until so many periods have passed.",
                difficulty: Difficulty::Horizon,
                values: powers(0..=8, 1),
                period: TURN / 1.6,
                modes: false,
                build: horizon,
            },
            Family {
                name: "size",
                parameter: "coordinates",
                about: "A chain of equal masses and springs between walls; the first mass is let go.",
                difficulty: Difficulty::Size,
                values: vec![1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0],
                period: TURN / 2.0,
                modes: true,
                build: size,
            },
        ]
    }
}

/// A row of masses m1, m2, …, each on a spring to the one before it, the first to the ground, and perhaps the last too; with
/// dampers between masses by their numbers, 0 for the ground.
fn row(
    masses: &[f64],
    springs: &[f64],
    dampers: &[(usize, usize, f64)],
) -> Result<System, BuildError> {
    let name = |i: usize| match i {
        0 => GROUND.to_owned(),
        i if i > masses.len() => GROUND.to_owned(),
        i => format!("m{i}"),
    };
    let mut builder = System::builder();
    for (i, mass) in (1..).zip(masses) {
        builder = builder.mass(name(i), *mass);
    }
    for (i, stiffness) in springs.iter().enumerate() {
        builder = builder.spring(name(i), name(i + 1), *stiffness);
    }
    for (i, j, damping) in dampers {
        builder = builder.damper(name(*i), name(*j), *damping);
    }
    builder.build()
}

/// A system let go, looked at [`INSTANTS`] times, each `stride` steps after the last.
fn let_go(system: System, start: State, step: f64, stride: u64) -> Case {
    Case {
        system,
        start,
        step,
        instants: (1..=INSTANTS).map(|k| k * stride).collect(),
        closed_form: none,
    }
}

fn stiffness(ratio: f64) -> Result<Case, BuildError> {
    let dampers = [(0, 1, 0.02), (2, 3, 0.02)];
    let system = row(&[1.0; 3], &[1.0, ratio, 1.0, 1.0], &dampers)?;
    let start = State::at_rest().displace("m1", 1.0).displace("m2", 1.0);
    Ok(let_go(system, start, 1.0, 1))
}

fn damping(ratio: f64) -> Result<Case, BuildError> {
    let system = row(&[1.0; 2], &[1.0; 2], &[(0, 1, 2.0 * ratio)])?;
    let start = State::at_rest().displace("m1", 1.0);
    Ok(let_go(system, start, 0.5, 1))
}

fn mass(ratio: f64) -> Result<Case, BuildError> {
    let dampers = [(0, 1, 0.02), (2, 3, 0.02)];
    let system = row(&[1.0, 1.0 / ratio, 1.0], &[1.0; 4], &dampers)?;
    let start = State::at_rest().displace("m1", 1.0).displace("m2", 0.5);
    Ok(let_go(system, start, 1.0, 1))
}

fn step(length: f64) -> Result<Case, BuildError> {
    // ‖A‖ of the state matrix is 201 by column sums and 203 by row sums.
    const NORM: f64 = 202.0;
    let system = row(&[1.0; 2], &[1.0; 2], &[(0, 1, 200.0)])?;
    let start = State::at_rest().displace("m1", 1.0).displace("m2", 0.5);
    Ok(let_go(system, start, length / NORM, 1))
}

fn horizon(periods: f64) -> Result<Case, BuildError> {
    let system = row(&[1.0; 2], &[1.0; 2], &[])?;
    let start = State::at_rest().displace("m1", 1.0);
    // The slow mode turns at 0.618 rad/s: one period is about 10.17 s, or 100 steps.
    Ok(let_go(system, start, 0.1017, periods as u64))
}

fn size(coordinates: f64) -> Result<Case, BuildError> {
    let n = coordinates as usize;
    Ok(Case {
        system: row(&vec![1.0; n], &vec![1.0; n + 1], &[])?,
        start: State::at_rest().displace("m1", 1.0),
        // Times that are doubles, which the closed form takes.
        step: 0.25,
        instants: (1..=10).map(|k| 8 * k).collect(),
        closed_form: of_chain,
    })
}

/// The chain's motion and eigenvalues by their closed forms, rounded to doubles.
fn of_chain(system: &System, problem: &Problem<'_>) -> Option<(MotionTruth, ModesTruth)> {
    /// Enough to round to the nearest double, or next to it.
    const DIGITS: u32 = 18;
    let n = system.len();
    let chain = UniformChain::new(ChainEnds::BothGrounded, n, 1.0, 1.0).ok()?;
    let chain = chain.with_digits(DIGITS);
    let steps = problem.instants()?.to_vec();
    let times: Vec<f64> = steps.iter().map(|k| problem.grid().time(*k)).collect();
    let (x0, v0) = (problem.initial_displacement(), problem.initial_velocity());
    let motions = chain.free_at(x0, v0, &times).ok()?;
    let matrix =
        |value: fn(&ExactMotion) -> f64| Mat::from_fn(n, times.len(), |i, k| value(&motions[k][i]));
    let displacement = matrix(|motion| motion.displacement.nearest());
    let velocity = matrix(|motion| motion.velocity.nearest());
    let motion = Trajectory::new("closed form", steps, times.clone(), displacement, velocity);
    let frequencies = chain.natural_frequencies();
    let roots = frequencies.iter().flat_map(|omega| {
        let root = Complex::new(0.0, omega.nearest());
        [root, root.conj()]
    });
    Some((
        MotionTruth::Doubles(Box::new(motion)),
        ModesTruth::Doubles(roots.collect()),
    ))
}
