//! From the layout of a scene to its system, initial state, loads and instants.

use std::collections::HashSet;

use eigentone_modes::{
    Beam, BuildError, CoordinateKind, ElementKind, GROUND, GivenElement, MatrixKind, Precision,
    Rod, System, SystemBuilder,
};
use eigentone_response::{
    Combination, HalfSine, Harmonic, Impulse, Load, LoadError, Noise, Polynomial, Quantity, Ramp,
    ResponseError, Samples, State, Step, Sum, Versine,
};
use eigentone_switching::{
    ControlledDamper, DamperLaw, Friction, Impact, Stop, Switch, SwitchFault,
};
use faer::Mat;

use super::Scene;
use super::error::{Choice, SceneError};
use super::layout;
use super::matrix_file;
use super::place::{self, steps};
use super::record;
use super::shape::{ByName, List, Matrix, Number, Object, Ratios, Text, Two, Values};
use super::text::Source;
use super::words::{did_you_mean, excerpt};

/// Checks all there is to check.
pub(super) fn scene(
    layout: layout::Scene,
    source: &Source<'_>,
    precision: Precision,
) -> Result<Scene, SceneError> {
    let system = system(&layout, source, precision)?;
    let names = Names {
        system: &system,
        source,
    };
    let mut initial = State::at_rest();
    for (name, Object(state)) in &layout.initial.0 {
        names.of_state(name, steps!["initial", name.as_str()])?;
        initial = initial
            .displace(name, state.displacement.0)
            .push(name, state.velocity.0);
    }
    let mut kinds = Kinds::default();
    let mut loads = Vec::new();
    for (i, Object(given)) in layout.loads.0.into_iter().enumerate() {
        let on = given.on.0.clone();
        names.of_load(&on, steps!["loads", i, "on"])?;
        let (kind, load) = load(given, i, source)?;
        kinds.loads.push(kind);
        loads.push((on, load));
    }
    let mut motions = Vec::new();
    for (i, Object(given)) in layout.motions.0.into_iter().enumerate() {
        let of = given.of.0.clone();
        names.of_motion(&of, steps!["motions", i, "of"])?;
        let (path, quantity, course) = motion(given, i, source)?;
        kinds.motions.push(path);
        motions.push((of, quantity, course));
    }
    let outputs = outputs(layout.outputs.0, &names)?;
    let mut noises = Vec::new();
    for (i, Object(given)) in layout.noise.0.into_iter().enumerate() {
        noises.push(noise(given, i, &names)?);
    }
    let frictions = layout.frictions.0.into_iter();
    let frictions = frictions.map(|Object(given)| friction(given)).enumerate();
    let stops = layout.stops.0.into_iter();
    let stops = stops.map(|Object(given)| stop(given)).enumerate();
    let impacts = layout.impacts.0.into_iter();
    let impacts = impacts.map(|Object(given)| impact(given)).enumerate();
    let mut switches: Vec<(&'static str, usize, Switch)> = Vec::new();
    switches.extend(frictions.map(|(i, switch)| ("frictions", i, switch)));
    switches.extend(stops.map(|(i, switch)| ("stops", i, switch)));
    switches.extend(impacts.map(|(i, switch)| ("impacts", i, switch)));
    for (i, Object(given)) in layout.controlled_dampers.0.into_iter().enumerate() {
        let switch = controlled_damper(given, i, source)?;
        switches.push(("controlled_dampers", i, switch));
    }
    for (key, i, switch) in &switches {
        for (end, name) in switch.between().iter().enumerate() {
            names.of_output(name, steps![*key, *i, "between", end])?;
        }
        switch.check(&system).map_err(|fault| SceneError::Switch {
            at: source.place(switch_path(key, *i, &fault)),
            source: Box::new(fault),
        })?;
    }
    let elastic = |spring: &Object<layout::Spring>| spring.0.loss_factor.0;
    let loss_factors: Vec<f64> = layout.springs.0.iter().map(elastic).collect();
    let lossy = loss_factors.iter().position(|factor| *factor != 0.0);
    if let (Some(i), true) = (lossy, layout.time.is_some()) {
        let at = source.place(steps!["springs", i, "loss_factor"]);
        return Err(SceneError::LossFactorInTime { at });
    }
    let time = layout.time.map(|Object(time)| (time.step.0, time.end.0));
    let frequencies = layout
        .frequencies
        .map(|Object(given)| frequencies(&given, source));
    let scene = Scene {
        title: layout.title.map(|title| title.0),
        system,
        initial,
        loads,
        motions,
        outputs,
        loss_factors,
        time,
        frequencies: frequencies.transpose()?,
        noises,
        switches,
    };
    let problem = match scene.problem() {
        Some(problem) => problem.map(drop),
        None => check_without_time(&scene),
    };
    problem.map_err(|error| SceneError::Response {
        at: source.place(response_path(&error, &kinds, &scene.motions)),
        source: Box::new(error),
    })?;
    Ok(scene)
}

/// Evenly spread frequencies, the first and the last being those given.
fn frequencies(given: &layout::Frequencies, source: &Source<'_>) -> Result<Vec<f64>, SceneError> {
    /// As many as a table can show.
    const MOST: f64 = 1e6;
    let (from, to, count) = (given.from.0, given.to.0, given.count.0);
    let wrong = |key: &'static str, problem: &'static str| {
        let at = source.place(steps!["frequencies", key]);
        Err(SceneError::Frequencies { at, problem })
    };
    if count.fract() != 0.0 || !(1.0..=MOST).contains(&count) {
        return wrong("count", "expected a whole number from 1 to 1000000");
    }
    let count = count as usize;
    if from < 0.0 {
        return wrong("from", "a frequency must be 0 or more");
    }
    if from == 0.0 && !given.spacing.0 {
        return wrong(
            "from",
            "a logarithmic scale has no 0: begin above it, or take \"spacing\": \"linear\"",
        );
    }
    if to < from || to == from && count > 1 {
        return wrong("to", "the last frequency must be above the first");
    }
    let at = |k: usize| {
        let share = k as f64 / (count.max(2) - 1) as f64;
        match (k, given.spacing.0) {
            (0, _) => from,
            (k, _) if k == count - 1 => to,
            (_, true) => from + share * (to - from),
            (_, false) => from * (share * (to / from).ln()).exp(),
        }
    };
    Ok((0..count).map(at).collect())
}

/// The kind of each load, and where the course of each motion stands.
#[derive(Default)]
struct Kinds {
    loads: Vec<&'static str>,
    motions: Vec<[&'static str; 2]>,
}

/// What names stand for, once there is a system.
struct Names<'a> {
    system: &'a System,
    source: &'a Source<'a>,
}

impl Names<'_> {
    /// What the name stands for.
    fn kind(&self, name: &str) -> Option<Named> {
        let coordinate = || self.system.index_of(name).map(|_| Named::Coordinate);
        let supports = self.system.supports();
        let support = || {
            supports
                .iter()
                .any(|support| support == name)
                .then_some(Named::Support)
        };
        let points = self.system.points();
        let point = || {
            points
                .iter()
                .any(|point| point.name == name)
                .then_some(Named::Point)
        };
        let ground = (name == GROUND).then_some(Named::Ground);
        ground.or_else(coordinate).or_else(support).or_else(point)
    }

    /// The names of what is of one of these kinds.
    fn all(&self, kinds: &[Named]) -> Vec<&str> {
        let coordinates = self.system.names().iter().map(String::as_str);
        let points = self.system.points().iter().map(|point| point.name.as_str());
        let supports = self.system.supports().iter().map(String::as_str);
        let all = coordinates.chain(points).chain(supports);
        all.filter(|name| self.kind(name).is_some_and(|kind| kinds.contains(&kind)))
            .collect()
    }

    /// Refuses a name of none of these kinds.
    fn admit(
        &self,
        name: &str,
        kinds: &[Named],
        what: &'static str,
        path: Vec<place::Step>,
    ) -> Result<(), SceneError> {
        let at = || self.source.place(path.clone());
        match self.kind(name) {
            Some(kind) if kinds.contains(&kind) => Ok(()),
            Some(Named::Ground) => Err(SceneError::OnGround { at: at() }),
            Some(kind) => Err(SceneError::WrongKind {
                at: at(),
                name: excerpt(name).into(),
                is: kind.word(),
                what,
            }),
            None => Err(unknown_name(
                name,
                what,
                &self.all(kinds),
                self.source,
                path,
            )),
        }
    }

    fn of_state(&self, name: &str, path: Vec<place::Step>) -> Result<(), SceneError> {
        self.admit(name, &[Named::Coordinate], "a coordinate", path)
    }

    fn of_load(&self, name: &str, path: Vec<place::Step>) -> Result<(), SceneError> {
        let kinds = [Named::Coordinate, Named::Point];
        self.admit(name, &kinds, "a coordinate or point", path)
    }

    fn of_motion(&self, name: &str, path: Vec<place::Step>) -> Result<(), SceneError> {
        self.admit(name, &[Named::Support], "a support", path)
    }

    fn of_output(&self, name: &str, path: Vec<place::Step>) -> Result<(), SceneError> {
        let kinds = [
            Named::Coordinate,
            Named::Point,
            Named::Support,
            Named::Ground,
        ];
        self.admit(name, &kinds, "a coordinate, point or support", path)
    }

    fn of_force(&self, name: &str, path: Vec<place::Step>) -> Result<(), SceneError> {
        if self.system.element_of(name).is_some() {
            return Ok(());
        }
        let kinds = [ElementKind::Spring, ElementKind::Damper];
        let elements: Vec<GivenElement> = kinds
            .into_iter()
            .flat_map(|kind| self.system.elements(kind))
            .collect();
        let known: Vec<&String> = elements
            .iter()
            .filter_map(|element| element.name.as_ref())
            .collect();
        Err(unknown_name(
            name,
            "a spring or damper",
            &known,
            self.source,
            path,
        ))
    }
}

/// What a name may stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Named {
    Ground,
    Coordinate,
    Point,
    Support,
}

impl Named {
    fn word(self) -> &'static str {
        match self {
            Named::Ground => "the ground",
            Named::Coordinate => "a coordinate",
            Named::Point => "a point",
            Named::Support => "a support",
        }
    }
}

fn system(
    layout: &layout::Scene,
    source: &Source<'_>,
    precision: Precision,
) -> Result<System, SceneError> {
    let mut builder = System::builder();
    if let Some(masses) = &layout.masses {
        if masses.0.is_empty() {
            return Err(SceneError::System {
                at: source.place(steps!["masses"]),
                source: Box::new(BuildError::Empty),
            });
        }
        for Object(mass) in &masses.0 {
            let (name, inertia) = (&mass.name.0, mass.mass.0);
            builder = match mass.unit.0 {
                true => builder.rotation(name, inertia),
                false => builder.mass(name, inertia),
            };
        }
    }
    for Object(point) in &layout.points.0 {
        let moves = point
            .moves
            .0
            .iter()
            .map(|(name, times)| (name.as_str(), times.0));
        builder = builder.point(&point.name.0, moves, point.mass.0);
        if let Some(unit) = &point.unit {
            builder = builder.measuring(match unit.0 {
                true => CoordinateKind::Rotation,
                false => CoordinateKind::Displacement,
            });
        }
    }
    for support in &layout.supports.0 {
        builder = builder.support(&support.0);
    }
    for (i, Object(spring)) in layout.springs.0.iter().enumerate() {
        if spring.loss_factor.0 < 0.0 {
            return Err(SceneError::LossFactor {
                at: source.place(steps!["springs", i, "loss_factor"]),
                value: spring.loss_factor.0,
            });
        }
        let [first, second] = &spring.between.0;
        builder = builder.spring(&first.0, &second.0, spring.stiffness.0);
        if let Some(name) = &spring.name {
            builder = builder.named(&name.0);
        }
    }
    for Object(damper) in &layout.dampers.0 {
        let [first, second] = &damper.between.0;
        builder = builder.damper(&first.0, &second.0, damper.damping.0);
        if let Some(name) = &damper.name {
            builder = builder.named(&name.0);
        }
    }
    for Object(beam) in &layout.beams.0 {
        builder = builder.beam(Beam {
            name: beam.name.0.clone(),
            length: beam.length.0,
            elements: beam.elements.0,
            flexural_rigidity: beam.flexural_rigidity.0,
            mass_per_length: beam.mass_per_length.0,
            ends: beam.ends.0.each_ref().map(|end| end.0),
            lumped: beam.mass.0,
        });
    }
    for Object(rod) in &layout.rods.0 {
        builder = builder.rod(Rod {
            name: rod.name.0.clone(),
            length: rod.length.0,
            elements: rod.elements.0,
            axial_rigidity: rod.axial_rigidity.0,
            mass_per_length: rod.mass_per_length.0,
            ends: rod.ends.0.each_ref().map(|end| end.0),
            lumped: rod.mass.0,
            twists: rod.unit.0,
        });
    }
    if let Some(Object(damping)) = &layout.damping {
        builder = damped(builder, damping);
        if precision == Precision::Double {
            builder = builder.quick_modal_damping();
        }
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
                    let matrix = matrix_file::read(&source.beside(path)).map_err(|error| {
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
        let mut names: Vec<String> = match &layout.masses {
            Some(masses) => masses.0.iter().map(|mass| mass.0.name.0.clone()).collect(),
            None => (1..=order).map(|i| format!("x{i}")).collect(),
        };
        let supports = layout.supports.0.iter().map(|support| support.0.clone());
        let points = layout.points.0.iter().map(|point| point.0.name.0.clone());
        match error {
            BuildError::UnknownNode { name, .. } => {
                let coordinates = names.len();
                names.extend(points.chain(supports));
                let what = match names.len() > coordinates {
                    true => "a coordinate, point or support",
                    false => "a coordinate",
                };
                names.push(GROUND.to_owned());
                unknown_name(&name, what, &names, source, path)
            }
            BuildError::PointMoves { name, .. } => {
                names.extend(supports);
                unknown_name(&name, "a coordinate or support", &names, source, path)
            }
            BuildError::NotASupport { name, .. } => {
                let supports: Vec<String> = supports.collect();
                unknown_name(&name, "a support", &supports, source, path)
            }
            error => SceneError::System {
                at: source.place(path),
                source: Box::new(error),
            },
        }
    })
}

fn damped(mut builder: SystemBuilder, damping: &layout::Damping) -> SystemBuilder {
    let name = |text: &Option<Text>| text.as_ref().map(|text| text.0.clone());
    if let Some(Object(rayleigh)) = &damping.rayleigh {
        let relative_to = name(&rayleigh.relative_to);
        let (mass, stiffness) = (rayleigh.mass.0, rayleigh.stiffness.0);
        builder = builder.rayleigh(mass, stiffness, relative_to.as_deref());
    }
    match &damping.modal {
        Some(Ratios::Plain(ratios)) => builder.modal_damping(ratios.0.clone(), None),
        Some(Ratios::More(modal)) => {
            let relative_to = name(&modal.relative_to);
            builder.modal_damping(modal.ratios.0.clone(), relative_to.as_deref())
        }
        None => builder,
    }
}

fn unknown_name(
    name: &str,
    what: &'static str,
    known: &[impl AsRef<str>],
    source: &Source<'_>,
    path: Vec<place::Step>,
) -> SceneError {
    SceneError::UnknownName {
        at: source.place(path),
        name: excerpt(name).into(),
        what,
        hint: did_you_mean(name, known).into(),
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

/// The only one of these that is given, with its key; or else all the keys that are.
fn only<T, const N: usize>(
    all: [(&'static str, Option<T>); N],
) -> Result<(&'static str, T), Vec<&'static str>> {
    let mut present = all
        .into_iter()
        .filter_map(|(key, value)| Some((key, value?)));
    match (present.next(), present.next()) {
        (Some(only), None) => Ok(only),
        (first, second) => {
            let present = first.into_iter().chain(second).chain(present);
            Err(present.map(|(key, _)| key).collect())
        }
    }
}

/// The load and its kind.
fn load(
    given: layout::Load,
    index: usize,
    source: &Source<'_>,
) -> Result<(&'static str, Load), SceneError> {
    let place = || steps!["loads", index];
    let step =
        |Object(step): Object<layout::Step>| Step::of(step.force.0).starting_at(step.start.0);
    let impulse = |Object(impulse): Object<layout::Impulse>| {
        Impulse::of(impulse.magnitude.0).at(impulse.at.0)
    };
    let half_sine = |Object(push): Object<layout::Push>| {
        HalfSine::of(push.force.0, push.duration.0).starting_at(push.start.0)
    };
    let versine = |Object(push): Object<layout::Push>| {
        Versine::of(push.force.0, push.duration.0).starting_at(push.start.0)
    };
    let all = [
        ("step", given.step.map(step).map(Load::from)),
        ("ramp", given.ramp.map(ramp)),
        ("impulse", given.impulse.map(impulse).map(Load::from)),
        ("harmonic", given.harmonic.map(harmonic)),
        ("half_sine", given.half_sine.map(half_sine).map(Load::from)),
        ("versine", given.versine.map(versine).map(Load::from)),
        ("polynomial", given.polynomial.map(polynomial)),
        ("samples", samples(given.samples, place, source)?),
    ];
    only(all).map_err(|given| SceneError::Choice {
        at: source.place(place()),
        choice: Choice::Load,
        given,
    })
}

/// The motion of a support, and where its course stands.
fn motion(
    given: layout::Motion,
    index: usize,
    source: &Source<'_>,
) -> Result<([&'static str; 2], Quantity, Load), SceneError> {
    let all = [
        (
            "displacement",
            given
                .displacement
                .map(|course| (Quantity::Displacement, course)),
        ),
        (
            "velocity",
            given.velocity.map(|course| (Quantity::Velocity, course)),
        ),
        (
            "acceleration",
            given
                .acceleration
                .map(|course| (Quantity::Acceleration, course)),
        ),
    ];
    let (key, (quantity, Object(given))) = only(all).map_err(|given| SceneError::Choice {
        at: source.place(steps!["motions", index]),
        choice: Choice::Motion,
        given,
    })?;
    let place = || steps!["motions", index, key];
    let step =
        |Object(rise): Object<layout::Rise>| Step::of(rise.height.0).starting_at(rise.start.0);
    let half_sine = |Object(bump): Object<layout::Bump>| {
        HalfSine::of(bump.height.0, bump.duration.0).starting_at(bump.start.0)
    };
    let versine = |Object(bump): Object<layout::Bump>| {
        Versine::of(bump.height.0, bump.duration.0).starting_at(bump.start.0)
    };
    let all = [
        ("step", given.step.map(step).map(Load::from)),
        ("ramp", given.ramp.map(ramp)),
        ("harmonic", given.harmonic.map(harmonic)),
        ("half_sine", given.half_sine.map(half_sine).map(Load::from)),
        ("versine", given.versine.map(versine).map(Load::from)),
        ("polynomial", given.polynomial.map(polynomial)),
        ("samples", samples(given.samples, place, source)?),
    ];
    let (kind, course) = only(all).map_err(|given| SceneError::Choice {
        at: source.place(place()),
        choice: Choice::Course,
        given,
    })?;
    Ok(([key, kind], quantity, course))
}

fn ramp(Object(ramp): Object<layout::Ramp>) -> Load {
    Ramp::of(ramp.rate.0).starting_at(ramp.start.0).into()
}

fn polynomial(Object(polynomial): Object<layout::Polynomial>) -> Load {
    let coefficients = polynomial.coefficients.0.iter().map(|number| number.0);
    Polynomial::of(coefficients.collect::<Vec<f64>>())
        .starting_at(polynomial.start.0)
        .into()
}

/// What noise acts on, and which motion it is if it is no force.
fn noise(
    given: layout::Noise,
    index: usize,
    names: &Names<'_>,
) -> Result<(String, Option<Quantity>, Noise), SceneError> {
    let at = |path| names.source.place(path);
    let place = || at(steps!["noise", index]);
    let all = [
        ("force", given.force.map(|density| (None, density))),
        (
            "displacement",
            given
                .displacement
                .map(|density| (Some(Quantity::Displacement), density)),
        ),
        (
            "velocity",
            given
                .velocity
                .map(|density| (Some(Quantity::Velocity), density)),
        ),
        (
            "acceleration",
            given
                .acceleration
                .map(|density| (Some(Quantity::Acceleration), density)),
        ),
    ];
    let (key, (quantity, density)) = only(all).map_err(|given| SceneError::Choice {
        at: place(),
        choice: Choice::Noise,
        given,
    })?;
    let name = match (quantity, given.on, given.of) {
        (None, Some(on), None) => {
            names.of_load(&on.0, steps!["noise", index, "on"])?;
            on.0
        }
        (Some(_), None, Some(of)) => {
            names.of_motion(&of.0, steps!["noise", index, "of"])?;
            of.0
        }
        _ => {
            let (at, force) = (place(), quantity.is_none());
            return Err(SceneError::NoisePlace { at, force });
        }
    };
    if density.0 < 0.0 {
        let at = at(steps!["noise", index, key]);
        return Err(SceneError::NoiseDensity { at });
    }
    let band = match given.band.as_ref().map(|band| band.0.as_slice()) {
        None => None,
        Some([low, high]) if low.0 >= 0.0 && low.0 < high.0 => Some([low.0, high.0]),
        Some(_) => {
            let at = at(steps!["noise", index, "band"]);
            return Err(SceneError::NoiseBand { at });
        }
    };
    let density = density.0;
    Ok((name, quantity, Noise { density, band }))
}

fn ends(Two([first, second]): Two<Text>) -> [String; 2] {
    [first.0, second.0]
}

fn friction(given: layout::Friction) -> Switch {
    Switch::Friction(Friction {
        between: ends(given.between),
        force: given.force.0,
        static_force: given.static_force.unwrap_or(given.force).0,
    })
}

fn stop(given: layout::Stop) -> Switch {
    Switch::Stop(Stop {
        between: ends(given.between),
        gap: given.gap.0,
        stiffness: given.stiffness.0,
        damping: given.damping.0,
    })
}

fn impact(given: layout::Impact) -> Switch {
    Switch::Impact(Impact {
        between: ends(given.between),
        gap: given.gap.0,
        restitution: given.restitution.0,
    })
}

fn controlled_damper(
    given: layout::ControlledDamper,
    index: usize,
    source: &Source<'_>,
) -> Result<Switch, SceneError> {
    let law = match (given.law.0, given.sky) {
        (true, Some(sky)) => DamperLaw::ClippedSkyhook { sky: sky.0 },
        (false, None) => DamperLaw::OnOffSkyhook,
        (clipped, _) => {
            let at = source.place(steps!["controlled_dampers", index]);
            return Err(SceneError::Sky { at, clipped });
        }
    };
    Ok(Switch::ControlledDamper(ControlledDamper {
        between: ends(given.between),
        low: given.low.0,
        high: given.high.0,
        law,
    }))
}

/// Where what is wrong with a switch stands.
fn switch_path(key: &'static str, index: usize, fault: &SwitchFault) -> Vec<place::Step> {
    match fault {
        SwitchFault::Number { what, .. } => {
            let what = what.split(' ').next().unwrap_or(what);
            steps![key, index, what]
        }
        _ => steps![key, index],
    }
}

fn harmonic(Object(harmonic): Object<layout::Harmonic>) -> Load {
    Harmonic::of(harmonic.amplitude.0, harmonic.frequency.0)
        .with_phase(harmonic.phase.0)
        .into()
}

/// Samples that stand in the scene or in a file beside it.
fn samples(
    given: Option<Object<layout::Samples>>,
    place: impl Fn() -> Vec<place::Step>,
    source: &Source<'_>,
) -> Result<Option<Load>, SceneError> {
    let Some(Object(samples)) = given else {
        return Ok(None);
    };
    let values = match samples.values {
        Values::Here(values) => values.into_iter().map(|value| value.0).collect(),
        Values::There(of) => {
            record::read(&source.beside(&of.file.0), &of.column).map_err(|error| {
                let path = place().into_iter().chain(steps!["samples", "values"]);
                SceneError::Record {
                    at: source.place(path.collect()),
                    source: Box::new(error),
                }
            })?
        }
    };
    Ok(Some(Load::from(Samples {
        step: samples.step.0,
        values,
        hold: samples.hold.0,
    })))
}

/// What is asked for beside the motion of the coordinates.
fn outputs(
    given: Vec<Object<layout::Output>>,
    names: &Names<'_>,
) -> Result<Vec<Combination>, SceneError> {
    let mut seen = HashSet::new();
    let mut outputs = Vec::new();
    for (i, Object(output)) in given.into_iter().enumerate() {
        let name = output.name.0;
        let at = |path| names.source.place(path);
        if name.is_empty() || !seen.insert(name.clone()) {
            return Err(SceneError::OutputName {
                at: at(steps!["outputs", i, "name"]),
                name: excerpt(&name),
            });
        }
        let sums = [
            ("displacement", Quantity::Displacement, output.displacement),
            ("velocity", Quantity::Velocity, output.velocity),
            ("acceleration", Quantity::Acceleration, output.acceleration),
        ];
        let mut terms = Vec::new();
        let mut keys = Vec::new();
        for (key, quantity, sum) in sums {
            let Some(ByName(sum)) = sum else { continue };
            keys.push(key);
            if sum.is_empty() {
                let at = at(steps!["outputs", i, key]);
                return Err(SceneError::EmptyOutput { at });
            }
            for (of, times) in sum {
                names.of_output(&of, steps!["outputs", i, key, of.as_str()])?;
                terms.push((quantity, of, times.0));
            }
        }
        let of = match output.force {
            Some(element) if keys.is_empty() => {
                names.of_force(&element.0, steps!["outputs", i, "force"])?;
                Sum::Pull(element.0)
            }
            None if !keys.is_empty() => Sum::Motions(terms),
            force => {
                keys.extend(force.map(|_| "force"));
                return Err(SceneError::Choice {
                    at: at(steps!["outputs", i]),
                    choice: Choice::Output,
                    given: keys,
                });
            }
        };
        outputs.push(Combination { name, of });
    }
    Ok(outputs)
}

/// What can be checked of the initial state and the loads while no instants are asked for: all but
/// the fit of sample steps to a grid.
fn check_without_time(scene: &Scene) -> Result<(), ResponseError> {
    let mut scene = scene.clone();
    let loads = scene.loads.iter_mut().map(|(_, load)| load);
    let courses = scene.motions.iter_mut().map(|(_, _, course)| course);
    for load in loads.chain(courses) {
        if let Load::Samples(samples) = load
            && samples.step > 0.0
        {
            samples.step = 1.0;
        }
    }
    scene.asked(1.0, 0.0).problem().map(drop)
}

/// Where in the scene a system is wrong.
fn build_path(error: &BuildError, layout: &layout::Scene) -> Vec<place::Step> {
    let element = |kind: &ElementKind| match kind {
        ElementKind::Spring => ("springs", "stiffness"),
        ElementKind::Damper => ("dampers", "damping"),
    };
    let index_of_point = |name: &String| {
        let points = layout.points.0.iter();
        let found = points
            .map(|point| &point.0.name.0)
            .position(|point| point == name);
        found.unwrap_or(0)
    };
    let continuum = |name: &String| {
        let beam = layout
            .beams
            .0
            .iter()
            .position(|beam| beam.0.name.0 == *name);
        let rod = layout.rods.0.iter().position(|rod| rod.0.name.0 == *name);
        match (beam, rod) {
            (Some(beam), _) => steps!["beams", beam],
            (None, rod) => steps!["rods", rod.unwrap_or(0)],
        }
    };
    let relative_to = |name: &String| {
        let damping = layout.damping.as_ref().map(|damping| &damping.0);
        let rayleigh = damping.and_then(|damping| damping.rayleigh.as_ref());
        let to_it = rayleigh.and_then(|rayleigh| rayleigh.0.relative_to.as_ref());
        let of = if to_it.is_some_and(|to| to.0 == *name) {
            "rayleigh"
        } else {
            "modal"
        };
        steps!["damping", of, "relative_to"]
    };
    match error {
        BuildError::TooLarge { .. } | BuildError::Empty => match &layout.masses {
            Some(_) => steps!["masses"],
            None if layout.matrices.is_some() => steps!["matrices"],
            None => steps![],
        },
        BuildError::EmptyName { index }
        | BuildError::ReservedName { index }
        | BuildError::DuplicateName { second: index, .. } => match &layout.masses {
            Some(masses) if *index < masses.0.len() => steps!["masses", *index, "name"],
            _ if layout.beams.0.is_empty() => steps!["rods"],
            _ => steps!["beams"],
        },
        BuildError::Continuum { name, what, .. } => {
            let mut path = continuum(name);
            let is_beam = path.first() == Some(&place::Step::from("beams"));
            path.push(place::Step::from(match (*what, is_beam) {
                ("rigidity", true) => "flexural_rigidity",
                ("rigidity", false) => "axial_rigidity",
                ("mass per length", _) => "mass_per_length",
                ("number of elements", _) => "elements",
                (what, _) => what,
            }));
            path
        }
        BuildError::ContinuumRange { name } => continuum(name),
        BuildError::DampingNotFinite { .. } | BuildError::DampingRange => steps!["damping"],
        BuildError::NotASupport { name, .. } | BuildError::NotHeld { name } => relative_to(name),
        BuildError::NoRatios | BuildError::ManyRatios { .. } => match &layout.damping {
            Some(Object(layout::Damping {
                modal: Some(Ratios::More(_)),
                ..
            })) => {
                steps!["damping", "modal", "ratios"]
            }
            _ => steps!["damping", "modal"],
        },
        BuildError::ModalSize { .. }
        | BuildError::NoModes { .. }
        | BuildError::EqualModes { .. } => steps!["damping", "modal"],
        BuildError::FollowSize { .. } => steps!["damping"],
        BuildError::InvalidMass { index, name, .. } => {
            let masses = layout.masses.iter().flat_map(|masses| &masses.0);
            let is_mass = masses.take(index + 1).any(|mass| mass.0.name.0 == *name);
            steps![if is_mass { "masses" } else { "points" }, *index, "mass"]
        }
        BuildError::PlaceName {
            what: "support",
            index,
            ..
        } => steps!["supports", *index],
        BuildError::PlaceName { index, .. } => steps!["points", *index, "name"],
        BuildError::PointMoves { point, name, .. }
        | BuildError::PointOnPoint { point, name }
        | BuildError::PointCircle { point, name }
        | BuildError::PointNotFinite { point, name, .. } => {
            steps!["points", index_of_point(point), "moves", name.as_str()]
        }
        BuildError::PointStill { point } => steps!["points", index_of_point(point), "moves"],
        BuildError::ElementName { kind, index, .. } => steps![element(kind).0, *index, "name"],
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
            let end = usize::from(between.0[0].0 != *name);
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
fn response_path(
    error: &ResponseError,
    kinds: &Kinds,
    motions: &[(String, Quantity, Load)],
) -> Vec<place::Step> {
    match error {
        ResponseError::Step { .. } => steps!["time", "step"],
        ResponseError::End { .. } => steps!["time", "end"],
        ResponseError::TooManySteps { .. } | ResponseError::LastInstant { .. } => steps!["time"],
        ResponseError::InitialOnMassless { name }
        | ResponseError::InitialNotFinite { name, .. } => steps!["initial", name.as_str()],
        ResponseError::VelocityOnMassless { name } => {
            steps!["initial", name.as_str(), "velocity"]
        }
        ResponseError::ImpulseOnMassless { index, .. } => steps!["loads", *index, "impulse"],
        ResponseError::Load { index, error } => {
            let kind = kinds.loads[*index];
            let mut path = steps!["loads", *index, kind];
            path.extend(parameter(error));
            path
        }
        ResponseError::Motion { index, error } => {
            let [quantity, kind] = kinds.motions[*index];
            let mut path = steps!["motions", *index, quantity, kind];
            path.extend(parameter(error));
            path
        }
        ResponseError::JumpOnMassless { support, .. } => {
            let moved = motions.iter().position(|(of, ..)| of == support);
            steps!["motions", moved.unwrap_or(0)]
        }
        ResponseError::Combination { index, .. } => steps!["outputs", *index],
        _ => steps![],
    }
}

/// Where in a load or a motion it is wrong.
fn parameter(error: &LoadError) -> Vec<place::Step> {
    match error {
        LoadError::NotFinite { parameter, .. } => steps![*parameter],
        LoadError::ImpulseBeforeStart { .. } => steps!["at"],
        LoadError::Coefficients { .. } => steps!["coefficients"],
        LoadError::CoefficientNotFinite { index, .. } => steps!["coefficients", *index],
        LoadError::NoSamples => steps!["values"],
        LoadError::SampleNotFinite { index, .. } => steps!["values", *index],
        LoadError::SampleStep { .. } | LoadError::SampleGrid { .. } => steps!["step"],
        LoadError::Duration { .. } => steps!["duration"],
        LoadError::PulseBeforeStart { .. } => steps!["start"],
        _ => Vec::new(),
    }
}
