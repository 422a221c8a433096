//! State and loads of a problem as one linear system, piece by piece.

use std::sync::Arc;

use eigentone_digits::{BallMatrix, Magnitude, Real};
use eigentone_modes::Form;

use super::clock::{Clock, Moment};
use super::generator::{Generator, Output};
use super::stepper::{Stepper, Unit};
use crate::enclosed::cos_sin;
use crate::problem::{
    Instant, Known, Piece, Problem, ResponseError, Source, StraightLoad, StraightLoads, sum,
};

/// The motion of a problem as ζ′ = W ζ without input: ζ holds the state in energy coordinates and what drives it, each load in
/// a unit of its own. Between two pieces of the [timeline](Problem::timeline) W stays as it is; at the start of a piece ζ
/// jumps. For programs that add feedback of their own, such as switches: each form that they name is a linear function of ζ,
/// and a force along it changes ζ′ by a column.
///
/// Everything comes with a bound of its error in the 2-norm.
pub struct Driven<'a, 'b, T> {
    pub(super) problem: &'a Problem<'b>,
    pub(super) generator: Arc<Generator<T>>,
    /// Where it is shared.
    pub(super) unit: Option<Arc<Unit<T>>>,
    pub(super) clock: Clock,
    pub(super) straight: StraightLoads<T>,
    forms: usize,
}

/// A row or a column, and a bound of its error in the 2-norm.
pub type KnownVector<T> = (Vec<T>, Magnitude);

/// What changed at the start of a piece.
pub(super) struct Begun<T> {
    /// By coordinate.
    pub(super) momenta: Vec<(usize, Known<T>)>,
    /// What the momenta add to the error of ζ.
    pub(super) error: Magnitude,
    /// The error of the straight loads, where they were set anew.
    pub(super) straight: Option<Magnitude>,
}

impl<'a, 'b, T: Real> Driven<'a, 'b, T> {
    /// The system of a problem, computed in the arithmetic of G and rounded to that of T, with these forms in view. `None`
    /// where the digits do not suffice to divide by the masses.
    ///
    /// # Errors
    /// [`ResponseError::ImpulseOnMassless`] for an impulse that displaces without limit.
    pub fn of<G: Real>(
        problem: &'a Problem<'b>,
        forms: &[Form],
    ) -> Result<Option<Driven<'a, 'b, T>>, ResponseError> {
        let sources = forms.iter().flat_map(|form| {
            [0, 1].map(|order| {
                let mut source = Source::default();
                source.add(problem.system(), order, form, 1.0);
                source
            })
        });
        let sources: Vec<Source> = sources.collect();
        let Some(generator) = Generator::of::<G>(problem, &sources) else {
            return Ok(None);
        };
        let stepper = Stepper {
            generator: Arc::new(generator),
            unit: None,
        };
        let driven = Driven::new(problem, stepper, forms.len());
        driven.check_momenta()?;
        Ok(Some(driven))
    }

    pub(super) fn new(
        problem: &'a Problem<'b>,
        Stepper { generator, unit }: Stepper<T>,
        forms: usize,
    ) -> Driven<'a, 'b, T> {
        Driven {
            problem,
            clock: Clock::of(problem),
            straight: StraightLoads::of(problem.drives()),
            generator,
            unit,
            forms,
        }
    }

    /// # Errors
    /// [`ResponseError::ImpulseOnMassless`].
    pub(super) fn check_momenta(&self) -> Result<(), ResponseError> {
        for piece in 0..self.problem.timeline().pieces().len() {
            let momenta = self.problem.momenta(piece);
            if momenta.is_empty() {
                continue;
            }
            if let Some(on) = self.generator.gives_way(&momenta) {
                return Err(self.problem.unresisted(on, piece));
            }
        }
        Ok(())
    }

    /// How many entries ζ has.
    pub fn len(&self) -> usize {
        self.generator.w.len()
    }

    /// How many of its first entries are the state; what drives it follows.
    pub fn states(&self) -> usize {
        self.generator.states
    }

    /// Whether ζ has no entry.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// W, row by row.
    pub fn matrix(&self) -> KnownVector<T> {
        let w = &self.generator.w;
        (w.entries().to_vec(), w.error())
    }

    /// Displacement and velocity of a coordinate as functions of ζ.
    pub fn coordinate(&self, index: usize) -> [KnownVector<T>; 2] {
        [0, 1].map(|kind| row(&self.generator.outputs[kind], index))
    }

    /// Displacement and velocity of one of the forms, by its place among those given.
    pub fn form(&self, place: usize) -> [KnownVector<T>; 2] {
        let first = self.generator.combinations.len() - 2 * self.forms + 2 * place;
        [0, 1].map(|order| row(&self.generator.combinations[first + order], 0))
    }

    /// What a unit force along a form adds to ζ′, and a unit impulse to ζ: nothing by its supports.
    pub fn push(&self, form: &Form) -> KnownVector<T> {
        let mut column = vec![T::ZERO; self.len()];
        let mut error = Magnitude::ZERO;
        for &(coordinate, share) in &form.coordinates {
            let share = (T::from(share), Magnitude::ZERO);
            let added = self.generator.add_momentum(&mut column, coordinate, share);
            error = error + added;
        }
        (column, error)
    }

    /// Whether a force along a form displaces something at once.
    pub fn gives_way(&self, form: &Form) -> bool {
        self.generator.gives_way(&form.coordinates).is_some()
    }

    /// ζ at t = 0, before the first piece begins.
    pub fn start(&self) -> KnownVector<T> {
        self.generator.start(self.problem)
    }

    /// The same from other displacements and then velocities of all coordinates, without bounds.
    ///
    /// # Panics
    /// If there are not two for each coordinate.
    pub fn start_from(&self, motion: &[T]) -> Vec<T> {
        assert_eq!(motion.len(), 2 * self.problem.system().len(), "two each");
        let mut given = BallMatrix::zeros(motion.len(), 1);
        for (i, value) in motion.iter().enumerate() {
            given.set(i, 0, *value, Magnitude::ZERO);
        }
        self.generator.start_from(&given).0
    }

    /// The seconds from one instant to another.
    pub fn seconds(&self, from: &Instant, to: &Instant) -> (T, Magnitude) {
        self.clock
            .seconds(self.clock.moment(from), self.clock.moment(to))
    }

    /// ζ at the start of a piece of the timeline, from what it is just before: impulses act, loads change; and what that
    /// adds to the error of ζ. To be asked of one piece after the other.
    ///
    /// # Panics
    /// If there is no such piece.
    pub fn begin(&mut self, piece: usize, zeta: &mut [T]) -> Magnitude {
        let begun = self.set(piece, zeta);
        begun.error + begun.straight.unwrap_or(Magnitude::ZERO)
    }

    pub(super) fn set(&mut self, index: usize, zeta: &mut [T]) -> Begun<T> {
        let problem = self.problem;
        let piece = &problem.timeline().pieces()[index];
        let before = self.signals(piece);
        for law in piece.changes() {
            let clock = &self.clock;
            self.straight.set(law, |from, to| {
                clock.seconds(clock.moment(from), clock.moment(to))
            });
        }
        let after = self.signals(piece);
        let first = problem.system().len();
        let jump = |channel: usize| {
            let [before, after] = [&before, &after].map(|all| all[channel - first]);
            let known = |(value, error): Known<T>| (-value, error);
            let value = sum(after.value, known(before.value));
            [value, sum(after.slope, known(before.slope))]
        };
        let momenta = problem.momenta_known(index, jump, cos_sin::<T>);
        let mut error = Magnitude::ZERO;
        for &(coordinate, momentum) in &momenta {
            error = error + self.generator.add_momentum(zeta, coordinate, momentum);
        }
        let pulses = problem.timeline().pulses();
        self.generator.set_pulses(zeta, pulses, piece);
        let changes = !piece.changes().is_empty();
        Begun {
            momenta,
            error,
            straight: changes.then(|| self.set_straight_at(self.clock.moment(&piece.start), zeta)),
        }
    }

    /// The straight part of each channel's signal at the start of a piece.
    fn signals(&self, piece: &Piece) -> Vec<StraightLoad<T>> {
        let (clock, now) = (&self.clock, self.clock.moment(&piece.start));
        let elapsed = |since: &Instant| clock.seconds(clock.moment(since), now);
        let first = self.problem.system().len();
        let channels = (first..).zip(self.problem.channels());
        let signals = channels.map(|(channel, _)| self.straight.of_one(channel, elapsed));
        signals.map(Option::unwrap_or_default).collect()
    }

    /// Sets the straight loads to their values at `now`; their error.
    pub(super) fn set_straight_at(&mut self, now: Moment, zeta: &mut [T]) -> Magnitude {
        let clock = &self.clock;
        let loads = self
            .straight
            .now(|since| clock.seconds(clock.moment(since), now));
        self.generator.set_straight(zeta, loads)
    }
}

/// A row of an output, of which the states and the loads are known apart.
fn row<T: Real>(output: &Output<T>, index: usize) -> KnownVector<T> {
    let error = output.parts[0].error + output.parts[1].error;
    (output.rows[index].clone(), error)
}
