//! From the layout of a scene to its system, initial state, loads and instants.

use eigentone_modes::{BuildError, ElementKind, GROUND, MatrixKind, System};
use eigentone_response::{
    AppliedLoad, Harmonic, Impulse, Load, LoadError, Problem, Ramp, ResponseError, Samples, State,
    Step, TimeGrid,
};
use faer::Mat;

use super::Scene;
use super::error::SceneError;
use super::layout;
use super::matrix_market;
use super::place::{self, steps};

use super::shape::{List, Matrix, Number, Object};
use super::text::Source;
use super::words::{excerpt, hint};

/// Checks all there is to check.
pub(super) fn scene(layout: layout::Scene, source: &Source<'_>) -> Result<Scene, SceneError> {
    let system = system(&layout, source)?;
    let known = |name: &str, path: Vec<place::Step>| {
        if name == GROUND {
            let at = source.place(path);
            return Err(SceneError::OnGround { at });
        }
        system
            .index_of(name)
            .ok_or_else(|| unknown_name(name, system.names(), source, path))
    };

    let mut initial = State::at_rest();
    for (name, Object(motion)) in &layout.initial.0 {
        known(name, steps!["initial", name.as_str()])?;
        initial = initial
            .displace(name, motion.displacement.0)
            .push(name, motion.velocity.0);
    }
    let mut loads = Vec::new();
    let mut kinds = Vec::new();
    for (i, Object(given)) in layout.loads.0.into_iter().enumerate() {
        let coordinate = known(&given.on.0, steps!["loads", i, "on"])?;
        let (kind, load) = load(given).map_err(|given| SceneError::LoadKind {
            at: source.place(steps!["loads", i]),
            given,
        })?;
        loads.push(AppliedLoad { coordinate, load });
        kinds.push(kind);
    }

    let refusal = |error: ResponseError| {
        let at = source.place(response_path(&error, &kinds));
        let source = Box::new(error);
        SceneError::Response { at, source }
    };
    let grid = match layout.time {
        Some(Object(time)) => Some(TimeGrid::new(time.step.0, time.end.0).map_err(refusal)?),
        None => None,
    };
    match grid {
        Some(grid) => Problem::new(&system, &initial, loads.clone(), grid).map(drop),
        None => check_without_time(&system, &initial, &loads),
    }
    .map_err(refusal)?;
    Ok(Scene {
        title: layout.title.map(|title| title.0),
        system,
        initial,
        loads,
        grid,
    })
}

fn system(layout: &layout::Scene, source: &Source<'_>) -> Result<System, SceneError> {
    let mut builder = System::builder();
    if let Some(masses) = &layout.masses {
        if masses.0.is_empty() {
            return Err(SceneError::System {
                at: source.place(steps!["masses"]),
                source: Box::new(BuildError::Empty),
            });
        }
        for Object(mass) in &masses.0 {
            builder = builder.mass(&mass.name.0, mass.mass.0);
        }
    }
    for Object(spring) in &layout.springs.0 {
        let [first, second] = &spring.between.0;
        builder = builder.spring(first, second, spring.stiffness.0);
    }
    for Object(damper) in &layout.dampers.0 {
        let [first, second] = &damper.between.0;
        builder = builder.damper(first, second, damper.damping.0);
    }
    let mut order = 0;
    if let Some(Object(matrices)) = &layout.matrices {
        for (kind, matrix) in [
            (MatrixKind::Mass, &matrices.mass),
            (MatrixKind::Damping, &matrices.damping),
            (MatrixKind::Stiffness, &matrices.stiffness),
        ] {
            let Some(matrix) = matrix else { continue };
            match matrix {
                Matrix::Rows(rows) => {
                    let matrix = entries(kind, rows, source)?;
                    order = matrix.nrows();
                    builder = builder.matrix(kind, matrix.as_ref());
                }
                Matrix::File(path) => {
                    let matrix = matrix_market::read(&source.beside(path)).map_err(|error| {
                        let at = source.place(steps!["matrices", kind.to_string().as_str()]);
                        SceneError::Matrix {
                            at,
                            source: Box::new(error),
                        }
                    })?;
                    order = matrix.nrows();
                    builder = builder.sparse_matrix(kind, matrix);
                }
            }
        }
    }
    builder.build().map_err(|error| {
        let path = build_path(&error, layout);
        match error {
            BuildError::UnknownNode { name, .. } => {
                let mut names: Vec<String> = match &layout.masses {
                    Some(masses) => masses.0.iter().map(|mass| mass.0.name.0.clone()).collect(),
                    None => (1..=order).map(|i| format!("x{i}")).collect(),
                };
                names.push(GROUND.to_owned());
                unknown_name(&name, &names, source, path)
            }
            error => SceneError::System {
                at: source.place(path),
                source: Box::new(error),
            },
        }
    })
}

fn unknown_name(
    name: &str,
    known: &[impl AsRef<str>],
    source: &Source<'_>,
    path: Vec<place::Step>,
) -> SceneError {
    SceneError::UnknownName {
        at: source.place(path),
        name: excerpt(name),
        hint: hint(name, known),
    }
}

/// The rows as a matrix.
fn entries(
    kind: MatrixKind,
    rows: &[List<Number>],
    source: &Source<'_>,
) -> Result<Mat<f64>, SceneError> {
    let expected = rows.first().map_or(0, |row| row.0.len());
    let ragged = |row: &List<Number>| row.0.len() != expected;
    if let Some(i) = rows.iter().position(ragged) {
        return Err(SceneError::RaggedRow {
            at: source.place(steps!["matrices", kind.to_string().as_str(), i]),
            kind,
            length: rows[i].0.len(),
            expected,
        });
    }
    Ok(Mat::from_fn(rows.len(), expected, |i, j| rows[i].0[j].0))
}

/// The load and its kind, if it has one; or else the kinds it has.
fn load(given: layout::Load) -> Result<(&'static str, Load), Vec<&'static str>> {
    let step = given
        .step
        .map(|Object(step)| Step::of(step.force.0).starting_at(step.start.0));
    let ramp = given
        .ramp
        .map(|Object(ramp)| Ramp::of(ramp.rate.0).starting_at(ramp.start.0));
    let impulse = given
        .impulse
        .map(|Object(impulse)| Impulse::of(impulse.magnitude.0).at(impulse.at.0));
    let harmonic = given.harmonic.map(|Object(harmonic)| {
        Harmonic::of(harmonic.amplitude.0, harmonic.frequency.0).with_phase(harmonic.phase.0)
    });
    let samples = given.samples.map(|Object(samples)| Samples {
        step: samples.step.0,
        values: samples.values.0.into_iter().map(|value| value.0).collect(),
        hold: samples.hold.0,
    });
    let all = [
        ("step", step.map(Load::from)),
        ("ramp", ramp.map(Load::from)),
        ("impulse", impulse.map(Load::from)),
        ("harmonic", harmonic.map(Load::from)),
        ("samples", samples.map(Load::from)),
    ];
    let mut present = all
        .into_iter()
        .filter_map(|(kind, load)| Some((kind, load?)));
    match (present.next(), present.next()) {
        (Some(only), None) => Ok(only),
        (first, second) => {
            let present = first.into_iter().chain(second).chain(present);
            Err(present.map(|(kind, _)| kind).collect())
        }
    }
}

/// What can be checked of the initial state and the loads while no instants are asked for: all but
/// the fit of sample steps to a grid.
fn check_without_time(
    system: &System,
    initial: &State,
    loads: &[AppliedLoad],
) -> Result<(), ResponseError> {
    let loads = loads.iter().cloned().map(|mut applied| {
        if let Load::Samples(samples) = &mut applied.load
            && samples.step > 0.0
        {
            samples.step = 1.0;
        }
        applied
    });
    Problem::new(system, initial, loads.collect(), TimeGrid::new(1.0, 0.0)?).map(drop)
}

/// Where in the scene a system is wrong.
fn build_path(error: &BuildError, layout: &layout::Scene) -> Vec<place::Step> {
    let element = |kind: &ElementKind| match kind {
        ElementKind::Spring => ("springs", "stiffness"),
        ElementKind::Damper => ("dampers", "damping"),
    };
    match error {
        BuildError::TooLarge { .. } | BuildError::Empty => match &layout.masses {
            Some(_) => steps!["masses"],
            None if layout.matrices.is_some() => steps!["matrices"],
            None => steps![],
        },
        BuildError::EmptyName { index }
        | BuildError::ReservedName { index }
        | BuildError::DuplicateName { second: index, .. } => steps!["masses", *index, "name"],
        BuildError::InvalidMass { index, .. } => steps!["masses", *index, "mass"],
        BuildError::ElementNotFinite { kind, index, .. } => {
            let (list, coefficient) = element(kind);
            steps![list, *index, coefficient]
        }
        BuildError::UnknownNode {
            kind, index, name, ..
        } => {
            let between = match kind {
                ElementKind::Spring => &layout.springs.0[*index].0.between,
                ElementKind::Damper => &layout.dampers.0[*index].0.between,
            };
            let end = usize::from(between.0[0] != *name);
            steps![element(kind).0, *index, "between", end]
        }
        BuildError::SelfJoined { kind, index, .. } => steps![element(kind).0, *index, "between"],
        BuildError::MatrixShape { kind, .. } => steps!["matrices", kind.to_string().as_str()],
        BuildError::MatrixNotFinite {
            kind, row, column, ..
        } => {
            steps!["matrices", kind.to_string().as_str(), *row, *column]
        }
        BuildError::Overflow { kind, .. } => match kind {
            MatrixKind::Mass => steps!["masses"],
            MatrixKind::Damping => steps!["dampers"],
            MatrixKind::Stiffness => steps!["springs"],
        },
        _ => steps![],
    }
}

/// Where in the scene a response is wrong.
fn response_path(error: &ResponseError, kinds: &[&str]) -> Vec<place::Step> {
    match error {
        ResponseError::Step { .. } => steps!["time", "step"],
        ResponseError::End { .. } => steps!["time", "end"],
        ResponseError::TooManySteps { .. } => steps!["time"],
        ResponseError::InitialOnMassless { name }
        | ResponseError::InitialNotFinite { name, .. } => steps!["initial", name.as_str()],
        ResponseError::VelocityOnMassless { name } => {
            steps!["initial", name.as_str(), "velocity"]
        }
        ResponseError::ImpulseOnMassless { index, .. } => steps!["loads", *index, "impulse"],
        ResponseError::Load { index, error } => {
            let kind = kinds[*index];
            match error {
                LoadError::NotFinite { parameter, .. } => steps!["loads", *index, kind, *parameter],
                LoadError::ImpulseBeforeStart { .. } => steps!["loads", *index, kind, "at"],
                LoadError::NoSamples => steps!["loads", *index, kind, "values"],
                LoadError::SampleNotFinite { index: sample, .. } => {
                    steps!["loads", *index, kind, "values", *sample]
                }
                LoadError::SampleStep { .. } | LoadError::SampleGrid { .. } => {
                    steps!["loads", *index, kind, "step"]
                }
                _ => steps!["loads", *index, kind],
            }
        }
        _ => steps![],
    }
}
