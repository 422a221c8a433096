//! What is asked: a system, its state at t = 0, its loads, and the instants wanted.

use std::f64::consts::FRAC_PI_2;
use std::sync::{Arc, OnceLock};

use eigentone_digits::{Magnitude, Real};
use eigentone_modes::{Form, Precision, System};

use super::angle::reduced_angle;
use super::applied_load::AppliedLoad;
use super::channel::{Channel, Quantity};
use super::combination::{Combination, Source};
use super::course::{Courses, ORDERS};
use super::error::ResponseError;
use super::grid::TimeGrid;
use super::instant::{Instant, SampleGrid};
use super::kept::Kept;
use super::load::{Harmonic, Load, LoadError};
use super::massless;
use super::momenta::momenta;
use super::state::State;
use super::straight_load::Known;
use super::timeline::Timeline;

/// A checked question: the motion of `system` from `initial` under `loads` at chosen instants of a
/// grid. Every [`ResponseMethod`](crate::ResponseMethod) answers it.
#[derive(Clone, Debug)]
pub struct Problem<'a> {
    system: &'a System,
    initial_displacement: Vec<f64>,
    initial_velocity: Vec<f64>,
    /// What acts on coordinates by itself, then what acts on channels.
    drives: Vec<AppliedLoad>,
    /// Of each, which load or motion it was given as.
    given: Vec<usize>,
    /// How many act on coordinates.
    loads: usize,
    channels: Vec<Channel>,
    combinations: Vec<Combination>,
    /// Of the combinations, then, where they are asked for, of the elements.
    sources: Vec<Source>,
    forces: bool,
    grid: TimeGrid,
    /// Made when it is first asked for: long samples have as many pieces.
    timeline: OnceLock<Timeline>,
    courses: OnceLock<Courses>,
    kept: Kept,
    instants: Option<Vec<u64>>,
    acceleration: bool,
    precision: Precision,
}

/// What moves a system beside forces on single coordinates.
#[derive(Clone, Debug, PartialEq)]
pub enum Drive {
    /// A force on a point.
    Force {
        /// The load's number as it was given, for messages.
        index: usize,
        /// The point's displacement.
        on: Form,
        /// The force.
        load: Load,
    },
    /// The motion of a support, which is at rest at 0 before t = 0. What is given of it, in m, m/s or m/s² in place of N,
    /// follows the course of a load, but for an impulse; a velocity or acceleration is integrated from t = 0 on.
    Motion {
        /// The motion's number as it was given, for messages.
        index: usize,
        /// Index of the support.
        support: usize,
        /// What is given of it.
        quantity: Quantity,
        /// Its course.
        course: Load,
    },
}

impl<'a> Problem<'a> {
    /// Checks the parts against each other.
    ///
    /// # Errors
    /// [`ResponseError`] naming the first thing that is wrong: a load, the coordinate it acts on, its fit to the grid, a
    /// load or initial value that a massless node cannot take, an instant beyond the grid.
    pub fn new(
        system: &'a System,
        initial: &State,
        loads: Vec<AppliedLoad>,
        grid: TimeGrid,
    ) -> Result<Problem<'a>, ResponseError> {
        for (index, applied) in loads.iter().enumerate() {
            let (coordinate, coordinates) = (applied.coordinate, system.len());
            if coordinate >= coordinates {
                return Err(ResponseError::NoCoordinate {
                    index: coordinate,
                    coordinates,
                });
            }
            let wrong = |error| ResponseError::Load { index, error };
            fits(&applied.load, &grid).map_err(wrong)?;
        }
        massless::check(system, initial, &loads)?;
        let loads = loads.into_iter().enumerate();
        let loads = loads.filter(|(_, applied)| !applied.load.is_zero());
        let is_plain =
            |(_, applied): &(_, AppliedLoad)| !matches!(applied.load, Load::Polynomial(_));
        let (plain, polynomials): (Vec<_>, Vec<_>) = loads.partition(is_plain);
        let (given, loads): (Vec<_>, Vec<_>) = plain.into_iter().unzip();
        // They are steps that are integrated, as the motions of supports are.
        let polynomials = polynomials
            .into_iter()
            .map(|(index, applied)| Drive::Force {
                index,
                on: Form {
                    coordinates: vec![(applied.coordinate, 1.0)],
                    ..Form::default()
                },
                load: applied.load,
            });
        let problem = Problem {
            initial_displacement: resolve(system, &initial.displacements)?,
            initial_velocity: resolve(system, &initial.velocities)?,
            timeline: OnceLock::new(),
            courses: OnceLock::new(),
            kept: Kept::default(),
            system,
            given,
            loads: loads.len(),
            drives: loads,
            channels: Vec::new(),
            combinations: Vec::new(),
            sources: Vec::new(),
            forces: false,
            grid,
            instants: None,
            acceleration: false,
            precision: Precision::default(),
        };
        problem.driven(polynomials.collect())
    }

    /// The same problem where the loads on coordinates had these numbers when they were given.
    pub(crate) fn numbered(mut self, numbers: &[usize]) -> Problem<'a> {
        self.given
            .iter_mut()
            .for_each(|given| *given = numbers[*given]);
        self
    }

    /// The same problem with forces on points and motions of supports.
    ///
    /// # Errors
    /// [`ResponseError::Load`] and [`ResponseError::Motion`] for a course that is wrong by itself or does not fit the grid,
    /// for an impulse as a motion, and for a displacement that jumps where the support carries mass.
    ///
    /// # Panics
    /// If the system has no support or coordinate of an index given.
    pub fn driven(mut self, drives: Vec<Drive>) -> Result<Problem<'a>, ResponseError> {
        for drive in drives {
            let (index, channel, load) = match drive {
                Drive::Force { index, on, load } => {
                    let wrong = |error| ResponseError::Load { index, error };
                    fits(&load, &self.grid).map_err(wrong)?;
                    (index, Channel::of_point(&on), load)
                }
                Drive::Motion {
                    index,
                    support,
                    quantity,
                    course,
                } => {
                    let name = &self.system.supports()[support];
                    let channel = Channel::of_support(self.system, support, quantity);
                    let carries = !channel.directions[2].is_empty();
                    let jumps = quantity == Quantity::Displacement && course.jumps();
                    let checked = match &course {
                        Load::Impulse(_) => Err(LoadError::ImpulseOfMotion),
                        _ if carries && jumps => Err(LoadError::JumpOfMass {
                            support: name.clone(),
                        }),
                        course => fits(course, &self.grid),
                    };
                    let wrong = |error| ResponseError::Motion { index, error };
                    checked.map_err(wrong)?;
                    (index, channel, course)
                }
            };
            match &load {
                zero if zero.is_zero() => {}
                Load::Polynomial(polynomial) => {
                    for (order, step) in polynomial.steps() {
                        self.drive(index, channel.integrated(order), step.into());
                    }
                }
                _ => self.drive(index, channel, load),
            }
        }
        self.timeline = OnceLock::new();
        self.courses = OnceLock::new();
        self.kept = Kept::default();
        Ok(self)
    }

    fn drive(&mut self, given: usize, channel: Channel, load: Load) {
        let known = self.channels.iter().position(|known| *known == channel);
        let at = known.unwrap_or_else(|| {
            self.channels.push(channel);
            self.channels.len() - 1
        });
        let coordinate = self.system.len() + at;
        self.drives.push(AppliedLoad { coordinate, load });
        self.given.push(given);
    }

    /// The same problem with these combinations of motions in the answer.
    ///
    /// # Errors
    /// [`ResponseError::Combination`] naming the first thing that is wrong.
    pub fn with_combinations(
        mut self,
        combinations: Vec<Combination>,
    ) -> Result<Problem<'a>, ResponseError> {
        let sources = combinations.iter().enumerate();
        let sources = sources.map(|(index, combination)| {
            let wrong = |reason| ResponseError::Combination { index, reason };
            Source::of(combination, self.system).map_err(wrong)
        });
        let mut sources = sources.collect::<Result<Vec<_>, _>>()?;
        if self.forces {
            sources.extend(Source::of_elements(self.system));
        }
        self.sources = sources;
        self.combinations = combinations;
        self.kept = Kept::default();
        Ok(self)
    }

    /// The same problem with what every spring and every damper carries in the answer.
    pub fn with_forces(mut self) -> Problem<'a> {
        if !self.forces {
            self.forces = true;
            self.sources.extend(Source::of_elements(self.system));
            self.kept = Kept::default();
        }
        self
    }

    /// The same problem, answered only at these indices of the grid, in this order.
    ///
    /// # Errors
    /// [`ResponseError::InstantBeyondEnd`].
    pub fn at(mut self, instants: &[u64]) -> Result<Problem<'a>, ResponseError> {
        let last = self.grid.last();
        if let Some(&index) = instants.iter().find(|index| **index > last) {
            return Err(ResponseError::InstantBeyondEnd { index, last });
        }
        self.instants = Some(instants.to_vec());
        Ok(self)
    }

    /// The same problem until another instant of its grid, which goes on as far as that takes.
    pub(crate) fn until(&self, last: u64) -> Problem<'a> {
        let grid = self.grid.until(last);
        let ends = [&self.grid, &grid].map(|grid| grid.time(grid.last()));
        // What is kept knows of no end, but of all changes of loads before it.
        let kept = match ends.iter().all(|end| self.last_change() < *end) {
            true => self.kept.shared(),
            false => Kept::default(),
        };
        Problem {
            grid,
            timeline: OnceLock::new(),
            courses: OnceLock::new(),
            instants: None,
            kept,
            ..self.clone()
        }
    }

    /// The last time in s at which a load changes its law, also beyond the end of the grid.
    pub(crate) fn last_change(&self) -> f64 {
        let changes = self.drives.iter().map(|applied| applied.load.last_change());
        changes.fold(0.0, f64::max)
    }

    /// The same problem, answered to this precision. The tolerance of a certified answer is relative
    /// to the largest coordinate of each instant, for displacements and for velocities.
    pub fn to(self, precision: Precision) -> Problem<'a> {
        Problem { precision, ..self }
    }

    /// The same problem with accelerations in the answer.
    pub fn with_acceleration(self) -> Problem<'a> {
        Problem {
            acceleration: true,
            ..self
        }
    }

    /// The same signals and instants, where they drive twice as many coordinates of another system: these come first, and what is
    /// a channel is another.
    pub(super) fn doubled<'b>(
        &self,
        system: &'b System,
        [initial_displacement, initial_velocity]: [Vec<f64>; 2],
        channels: Vec<Channel>,
        sources: Vec<Source>,
    ) -> Problem<'b> {
        let n = self.system.len();
        let drives = self.drives.iter().map(|applied| AppliedLoad {
            coordinate: match applied.coordinate < n {
                true => applied.coordinate,
                false => applied.coordinate + system.len() - n,
            },
            load: applied.load.clone(),
        });
        Problem {
            system,
            initial_displacement,
            initial_velocity,
            drives: drives.collect(),
            given: self.given.clone(),
            loads: self.loads,
            channels,
            combinations: self.combinations.clone(),
            sources,
            forces: false,
            grid: self.grid,
            timeline: OnceLock::new(),
            courses: OnceLock::new(),
            kept: Kept::default(),
            instants: self.instants.clone(),
            acceleration: false,
            precision: self.precision,
        }
    }

    /// What has been computed of this problem, made when it is first asked for: one value of each type.
    pub(crate) fn kept<V: Send + Sync + 'static>(&self, make: impl FnOnce() -> V) -> Arc<V> {
        self.kept.get(make)
    }

    /// The same, if it has been made.
    pub(crate) fn found<V: Send + Sync + 'static>(&self) -> Option<Arc<V>> {
        self.kept.found()
    }

    /// The system that moves.
    pub fn system(&self) -> &'a System {
        self.system
    }

    /// Displacements at t = 0 in m, one for each coordinate.
    pub fn initial_displacement(&self) -> &[f64] {
        &self.initial_displacement
    }

    /// Velocities at t = 0 in m/s, one for each coordinate.
    pub fn initial_velocity(&self) -> &[f64] {
        &self.initial_velocity
    }

    /// The loads as pieces between the instants at which they change.
    pub fn timeline(&self) -> &Timeline {
        self.timeline
            .get_or_init(|| Timeline::of(&self.drives, &self.grid))
    }

    /// The forces on single coordinates, in the order given; polynomials are [channels](Self::channels), and what is 0 at all
    /// times is left out.
    pub fn loads(&self) -> &[AppliedLoad] {
        &self.drives[..self.loads]
    }

    /// All that moves the system: the forces on single coordinates, then the signals of [channels](Self::channels), whose
    /// index is the number of coordinates more than their place there.
    pub fn drives(&self) -> &[AppliedLoad] {
        &self.drives
    }

    /// Where signals act that are no force on a single coordinate.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// The combinations of motions that are asked for.
    pub fn combinations(&self) -> &[Combination] {
        &self.combinations
    }

    pub(crate) fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// Calls `push` with every part of the `order`-th time derivative, up to the second, of the forces on the coordinates at
    /// `t` s, by the laws of the given piece of the timeline and without impulses: index of the coordinate and force in N,
    /// of all loads and motions, in doubles.
    ///
    /// # Panics
    /// If there is no such piece, or for a higher order.
    pub fn forces(&self, piece: usize, t: f64, order: u8, mut push: impl FnMut(usize, f64)) {
        assert!(order <= 2, "only two derivatives are kept");
        let (n, timeline) = (self.system.len(), self.timeline());
        timeline.signals(piece, t, |on, derivatives| {
            if on < n {
                push(on, derivatives[usize::from(order)]);
            }
        });
        self.channel_forces(piece, t, order, &mut push);
    }

    /// The same of forces on points and motions of supports alone, without derivatives.
    ///
    /// # Panics
    /// If there is no such piece.
    pub fn motion_forces(&self, piece: usize, t: f64, push: &mut dyn FnMut(usize, f64)) {
        self.channel_forces(piece, t, 0, push);
    }

    fn channel_forces(&self, piece: usize, t: f64, order: u8, push: &mut dyn FnMut(usize, f64)) {
        self.each_channel(piece, t, |channel, derivatives| {
            let later = &derivatives[order.into()..];
            for (direction, value) in channel.directions.iter().zip(later) {
                for &(row, factor) in direction {
                    push(row, factor * value);
                }
            }
        });
    }

    /// The sinusoids that run all the time, as forces on coordinates in doubles: those of channels are spread.
    pub(crate) fn sinusoids(&self) -> Vec<(usize, Harmonic)> {
        let n = self.system.len();
        let mut spread = Vec::new();
        for &(on, harmonic) in self.timeline().harmonics() {
            let Some(channel) = on.checked_sub(n) else {
                spread.push((on, harmonic));
                continue;
            };
            let channel = &self.channels[channel];
            for (k, direction) in channel.directions.iter().enumerate() {
                let turns = k as i32 - channel.integrals as i32;
                let amplitude = harmonic.amplitude * harmonic.frequency.powi(turns);
                let phase = harmonic.phase + f64::from(turns) * FRAC_PI_2;
                spread.extend(direction.iter().map(|&(row, factor)| {
                    let amplitude = amplitude * factor;
                    (
                        row,
                        Harmonic {
                            amplitude,
                            phase,
                            ..harmonic
                        },
                    )
                }));
            }
        }
        spread.retain(|(_, harmonic)| harmonic.amplitude.is_finite());
        spread
    }

    /// The forces on the coordinates at `t` s and all their derivatives, of motions and powers of time, apart from what swings: by the
    /// laws of the given piece, of those that are integrated, or of all.
    pub(crate) fn steady(&self, piece: usize, t: f64, integrated: bool) -> [Vec<f64>; ORDERS] {
        /// How many derivatives of what swings are known.
        const SWINGING: usize = 5;
        /// What is left of what was taken out is rounding below this part of it.
        const ROUNDING: f64 = 1e-12;
        let n = self.system.len();
        let mut steady = [(); ORDERS].map(|()| vec![0.0; n]);
        let harmonics = self.timeline().harmonics();
        self.each_channel(piece, t, |channel, mut derivatives| {
            if integrated && channel.integrals == 0 {
                return;
            }
            let own = self.channels.iter().position(|one| one == channel);
            let own = own.map_or(usize::MAX, |at| n + at);
            let known = channel.integrals + SWINGING;
            let mut swings = [0.0; ORDERS];
            for (_, harmonic) in harmonics.iter().filter(|(on, _)| *on == own) {
                for (k, derivative) in derivatives.iter_mut().enumerate().take(known) {
                    let turns = k as i32 - channel.integrals as i32;
                    let angle = reduced_angle(harmonic.frequency, t.into(), harmonic.phase);
                    let swing = harmonic.amplitude * harmonic.frequency.powi(turns);
                    let part = swing * (angle + f64::from(turns) * FRAC_PI_2).sin();
                    if harmonic.frequency != 0.0 && part.is_finite() {
                        *derivative -= part;
                        swings[k] += part.abs();
                    }
                }
            }
            let given = derivatives.iter_mut().zip(swings).skip(channel.integrals);
            let hidden = given.filter(|(rest, swung)| rest.abs() <= ROUNDING * swung);
            hidden.for_each(|(rest, _)| *rest = 0.0);
            for (order, sums) in steady.iter_mut().enumerate() {
                for (direction, value) in channel.directions.iter().zip(&derivatives[order..]) {
                    direction
                        .iter()
                        .for_each(|&(row, factor)| sums[row] += factor * value);
                }
            }
        });
        steady
    }

    /// Displacement, velocity and acceleration of each support at `t` s, by the laws of the given piece of the timeline.
    ///
    /// # Panics
    /// If there is no such piece.
    pub fn supports(&self, piece: usize, t: f64) -> Vec<[f64; 3]> {
        let mut motion = vec![[0.0; 3]; self.system.supports().len()];
        self.each_channel(piece, t, |channel, derivatives| {
            if let Some(support) = channel.support {
                let parts = motion[support].iter_mut().zip(derivatives);
                parts.for_each(|(sum, part)| *sum += part);
            }
        });
        motion
    }

    fn each_channel(&self, piece: usize, t: f64, mut visit: impl FnMut(&Channel, [f64; ORDERS])) {
        if self.channels.is_empty() {
            return;
        }
        let (timeline, channels) = (self.timeline(), &self.channels);
        let n = self.system.len();
        let courses = || Courses::of(timeline, channels, n, &self.grid);
        let courses = self.courses.get_or_init(courses);
        courses.each(timeline, channels, piece, t, |channel, derivatives| {
            visit(&channels[channel], derivatives);
        });
    }

    /// The momenta that coordinates take at the start of a piece of the timeline, by impulses and by jumps of supports:
    /// index of the coordinate and momentum in N·s, which add up.
    ///
    /// # Panics
    /// If there is no such piece.
    pub fn momenta(&self, piece: usize) -> Vec<(usize, f64)> {
        let pieces = self.timeline().pieces();
        let at = |piece: &super::timeline::Piece, time: f64, channel: usize| {
            let own = piece
                .straight()
                .iter()
                .find(|one| one.coordinate == channel);
            own.map_or([0.0; 2], |one| [one.value + one.slope * time, one.slope])
        };
        let jump = |channel: usize| {
            let now = at(&pieces[piece], 0.0, channel);
            let before = match piece {
                0 => [0.0; 2],
                _ => {
                    let time = pieces[piece]
                        .start
                        .since(&pieces[piece - 1].start, &self.grid);
                    at(&pieces[piece - 1], time, channel)
                }
            };
            [0, 1].map(|order| (now[order] - before[order], Magnitude::ZERO))
        };
        let wave = |angle: f64| (angle.cos(), angle.sin(), Magnitude::ZERO);
        let momenta = self.momenta_known::<f64>(piece, jump, wave).into_iter();
        momenta
            .map(|(row, (momentum, _))| (row, momentum))
            .collect()
    }

    /// The same with what is known of them, by [`momenta`].
    pub(crate) fn momenta_known<T: Real>(
        &self,
        piece: usize,
        jump: impl Fn(usize) -> [Known<T>; 2],
        wave: impl Fn(f64) -> (T, T, Magnitude),
    ) -> Vec<(usize, Known<T>)> {
        let n = self.system.len();
        momenta(self.timeline(), &self.channels, n, piece, jump, wave)
    }

    /// The grid of instants.
    pub fn grid(&self) -> &TimeGrid {
        &self.grid
    }

    /// The indices asked for, or `None` for all of the grid.
    pub fn instants(&self) -> Option<&[u64]> {
        self.instants.as_deref()
    }

    /// The precision asked for.
    pub fn precision(&self) -> Precision {
        self.precision
    }

    /// Why what changes this coordinate's velocity at once, at the start of a piece, is refused where neither mass nor
    /// damper resists it.
    pub(crate) fn unresisted(&self, coordinate: usize, piece: usize) -> ResponseError {
        let name = self.system.names()[coordinate].clone();
        let n = self.system.len();
        let reaches = |on: usize| match on.checked_sub(n) {
            None => on == coordinate,
            Some(channel) => {
                let mut direction = self.channels[channel].directions[0].iter();
                direction.any(|(row, _)| *row == coordinate)
            }
        };
        let start = self.timeline().pieces()[piece].start;
        let acts_at_start = |applied: &AppliedLoad| match &applied.load {
            Load::Impulse(impulse) => Instant::event(&self.grid, impulse.at).order(&start).is_eq(),
            _ => false,
        };
        let mut drives = self.drives.iter().zip(&self.given);
        let index =
            drives.find(|(applied, _)| acts_at_start(applied) && reaches(applied.coordinate));
        match index {
            Some((_, &index)) => ResponseError::ImpulseOnMassless { index, name },
            None => {
                let jumps = self.channels.iter().filter(|channel| {
                    let mut rows = channel.directions[1..].iter().flatten();
                    rows.any(|(row, _)| *row == coordinate)
                });
                let support = jumps.filter_map(|channel| channel.support).next();
                let support = support.map(|support| self.system.supports()[support].clone());
                ResponseError::JumpOnMassless {
                    support: support.unwrap_or_default(),
                    name,
                }
            }
        }
    }

    /// Whether the forces in springs and dampers are asked for.
    pub fn wants_forces(&self) -> bool {
        self.forces
    }

    /// Whether accelerations are asked for.
    pub fn wants_acceleration(&self) -> bool {
        self.acceleration
    }
}

/// Checks a load by itself and against the grid.
fn fits(load: &Load, grid: &TimeGrid) -> Result<(), LoadError> {
    load.check()?;
    match load {
        Load::Samples(samples) => SampleGrid::of(samples.step, grid.step()).map(|_| ()),
        _ => Ok(()),
    }
}

/// Values by index, from values by name.
fn resolve(system: &System, named: &[(String, f64)]) -> Result<Vec<f64>, ResponseError> {
    let mut values = vec![0.0; system.len()];
    for (name, value) in named {
        let index = system
            .index_of(name)
            .ok_or_else(|| ResponseError::UnknownCoordinate {
                name: name.clone(),
                known: system.names().join(", "),
            })?;
        if !value.is_finite() {
            return Err(ResponseError::InitialNotFinite {
                name: name.clone(),
                value: *value,
            });
        }
        values[index] = *value;
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use eigentone_modes::GROUND;

    use super::*;
    use crate::problem::{Impulse, Polynomial, Step};

    /// A support that swings pulls through a spring: apart from what swings nothing is left, whatever piece of time an instant
    /// is in.
    #[test]
    fn what_swings_is_taken_out_after_very_many_turns() {
        let builder = System::builder().mass("m", 1.0).support("s");
        let system = builder.spring("s", "m", 1.0).build().expect("a system");
        let response = crate::Response::of(&system)
            .motion("s", Quantity::Displacement, Harmonic::of(1.0, 1e16 / 3.0))
            .load("m", Impulse::of(1.0).at(1.3));
        let problem = response.every(0.5).until(10.0).problem();
        let problem = problem.expect("a problem");
        for piece in [0, 1] {
            let [force, ..] = problem.steady(piece, 3.3, false);
            assert!(force[0].abs() < 1e-14, "{piece}: {force:?}");
        }
    }

    #[test]
    fn loads_act_on_coordinates_that_there_are() {
        let builder = System::builder().mass("m", 1.0);
        let system = builder.spring(GROUND, "m", 1.0).build().expect("a system");
        let grid = TimeGrid::new(0.1, 1.0).expect("a grid");
        let loads: [Load; 2] = [Step::of(1.0).into(), Polynomial::of([1.0, 2.0]).into()];
        for load in loads {
            let beyond = vec![AppliedLoad {
                coordinate: 1,
                load,
            }];
            let found = Problem::new(&system, &State::at_rest(), beyond, grid);
            let (index, coordinates) = (1, 1);
            let expected = ResponseError::NoCoordinate { index, coordinates };
            assert_eq!(found.expect_err("there is one"), expected);
        }
    }
}
