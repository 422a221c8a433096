//! From event to event.

use std::collections::HashMap;
use std::rc::Rc;

use eigentone_digits::{DoubleDouble, Real, sort_by_number};
use eigentone_modes::{ElementKind, Form};
use eigentone_response::{Driven, Instant, Problem, ResponseError, Trajectory};

use crate::change::{Change, product};
use crate::configuration::{Configuration, Place, Unfit, exponential, length_of};
use crate::error::SwitchingError;
use crate::error_set::ErrorSet;
use crate::event::Event;
use crate::losses::{Losses, Taken};
use crate::outputs::{Moment, Outputs, SwitchForce, combinations};
use crate::peaks::{Followed, SwitchedPeaks};
use crate::phase::Phase;
use crate::root::{First, first, refine};
use crate::rows::{Row, SLACK, dot, length, unit, upper};
use crate::series::{BEYOND, Series};
use crate::switch::{DamperLaw, Switch, SwitchFault};

/// What is asked.
#[derive(Clone, Debug)]
pub(crate) struct Question<'a, 'b> {
    pub(crate) problem: &'a Problem<'b>,
    pub(crate) switches: Vec<Switch>,
    /// Of each switch, its stretch and the displacement of b.
    pub(crate) forms: Vec<[Form; 2]>,
    /// Whether losses are asked for.
    pub(crate) with_losses: bool,
    /// Whether peaks are.
    pub(crate) with_peaks: bool,
}

/// What came of an attempt with some digits.
pub(crate) struct Found {
    pub(crate) trajectory: Trajectory,
    pub(crate) events: Vec<Event>,
    pub(crate) losses: Option<Losses>,
    pub(crate) peaks: Option<SwitchedPeaks>,
    pub(crate) forces: Vec<SwitchForce>,
    /// Whether every instant is as good as asked for.
    pub(crate) good: bool,
}

/// Why a march ended early.
pub(crate) enum Halt {
    /// More digits may decide.
    Undecided(SwitchingError),
    Failed(SwitchingError),
}

impl Halt {
    pub(crate) fn is_undecided(&self) -> bool {
        matches!(self, Halt::Undecided(_))
    }
}

impl From<Halt> for SwitchingError {
    fn from(halt: Halt) -> SwitchingError {
        match halt {
            Halt::Undecided(error) | Halt::Failed(error) => error,
        }
    }
}

impl From<ResponseError> for Halt {
    fn from(error: ResponseError) -> Halt {
        Halt::Failed(error.into())
    }
}

/// A state on its way through events.
pub(crate) struct March<'a, 'b, T> {
    pub(crate) question: &'a Question<'a, 'b>,
    pub(crate) driven: Driven<'a, 'b, T>,
    /// W without switches, with the constant.
    pub(crate) w: Vec<T>,
    w_error: f64,
    /// The last entry of ζ, which stands for 1.
    pub(crate) constant: T,
    /// The longest step, in s, and the largest norm that W times a step may have.
    limits: [f64; 2],
    pub(crate) places: Vec<Place<T>>,
    pub(crate) phases: Vec<Phase>,
    known: HashMap<Vec<Phase>, Result<Rc<Configuration<T>>, Unfit>>,
    pub(crate) current: Rc<Configuration<T>>,
    /// Of each guard, how many derivatives are 0 at the start of the step; none of those of `usize::MAX` leaves 0.
    pub(crate) orders: Vec<usize>,
    pub(crate) zeta: Vec<T>,
    /// ζ before anything jumped at the last instant at which something did.
    pub(crate) earlier: Vec<T>,
    pub(crate) errors: ErrorSet,
    pub(crate) now: T,
    pub(crate) doubt: Doubt,
    /// Relative.
    tolerance: f64,
    /// Whether the motion has begun.
    pub(crate) started: bool,
    /// Whether velocities jumped at this instant.
    pub(crate) jumped: bool,
    /// Of each switch, whether it has just bounced.
    pub(crate) bounced: Vec<bool>,
    /// Of each switch, the largest speed at an impact.
    pub(crate) largest: Vec<f64>,
    /// Of each switch, when it bounced last, three times at most.
    pub(crate) turns: Vec<Vec<T>>,
    /// Whether digits ended bounces, and not their speeds.
    pub(crate) is_cut: bool,
    /// When the loads change next, or are no longer followed.
    pub(crate) change: Option<T>,
    /// Until when, in s, bounces go on that are left out, what they may do to ζ, and of which switch they are.
    pub(crate) hidden: (T, f64, usize),
    /// Of each switch, how many seconds later its contact begins, and how well that is known.
    pub(crate) delays: Vec<Option<(f64, f64)>>,
    /// What settling has added to the errors at this instant.
    pub(crate) added: Vec<f64>,
    /// How many steps in a row ended before what could not be decided.
    approach: usize,
    /// How many steps in a row passed what could not be decided.
    passes: i32,
    /// How many multiplications are left, and how many a step takes, about.
    budget: f64,
    cost: f64,
    pub(crate) events: Vec<Event>,
    /// Where losses are asked for.
    pub(crate) taken: Option<Taken<T>>,
    /// Where peaks are.
    followed: Option<Followed<T>>,
    /// Where asked for, how ζ follows ζ at the start, by rows: the product of all steps and jumps, with what the time of an
    /// event does (Aizerman and Gantmakher, Q. J. Mech. Appl. Math. 11, 1958).
    pub(crate) tangent: Option<Vec<f64>>,
}

/// Records the instants of a step from one time up to another, but for that one.
type Recorder<'r, 'a, 'b, T> = dyn FnMut(&March<'a, 'b, T>, &Series<T>, T, T) + 'r;

/// What is done where errors hide what happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Doubt {
    /// It is not decided.
    Refused,
    /// What is 0 as far as half of the digits show is a coincidence; nothing else is decided.
    Coincidence,
    /// The numbers decide, as if they were right but for their rounding.
    Ignored,
}

/// A root of a guard within a step.
struct Root<T> {
    guard: usize,
    theta: T,
    /// How far it may be off.
    bound: f64,
    /// The same, with what is not known of the state at the start where that is left aside.
    known: f64,
}

/// A place within a step where a guard comes too near to 0 to decide whether it ends.
#[derive(Clone, Copy)]
struct Hidden {
    place: f64,
    guard: usize,
}

/// The motion with T's digits, by a system computed with those of G.
pub(crate) fn march<T: Real, G: Real>(
    question: &Question<'_, '_>,
    tolerance: f64,
    doubt: Doubt,
) -> Result<Found, Halt> {
    let problem = question.problem;
    let mut forms: Vec<_> = question.forms.iter().flatten().cloned().collect();
    let parts = combinations(problem, &mut forms);
    let (dampers, first) = match question.with_losses {
        true => (problem.system().elements(ElementKind::Damper), forms.len()),
        false => (Vec::new(), 0),
    };
    forms.extend(dampers.iter().map(|damper| damper.stretch.clone()));
    let Some(driven) = Driven::<T>::of::<G>(problem, &forms)? else {
        return Err(Halt::Undecided(SwitchingError::Stuck));
    };
    let outputs = Outputs::of(problem, &driven, &parts, question.switches.len(), tolerance);
    let followed = question.with_peaks.then(|| {
        let system = problem.system();
        let [springs, dampers] =
            [ElementKind::Spring, ElementKind::Damper].map(|kind| match problem.wants_forces() {
                true => system.elements(kind).len(),
                false => 0,
            });
        let counts = [
            3 * system.len(),
            problem.combinations().len(),
            springs,
            dampers,
        ];
        Followed::new(outputs.values(), counts, question.switches.len())
    });
    let taken = question.with_losses.then(|| {
        let each = dampers.iter().zip(first..).map(|(damper, form)| {
            let rows = driven.form(form);
            let rows = rows.map(|row| Row::with_constant(row, T::ZERO));
            (T::from(damper.coefficient), rows)
        });
        Taken::new(each.collect(), question.switches.len())
    });
    let mut march = March::new(question, driven, doubt, tolerance)?;
    (march.taken, march.followed) = (taken, followed);
    march.run(outputs)
}

impl<'a, 'b, T: Real> March<'a, 'b, T> {
    /// The motion's own start, by a system computed with the digits of G, with no form in view but those of the switches.
    pub(crate) fn of<G: Real>(
        question: &'a Question<'a, 'b>,
        doubt: Doubt,
        tolerance: f64,
    ) -> Result<March<'a, 'b, T>, Halt> {
        let forms: Vec<_> = question.forms.iter().flatten().cloned().collect();
        let Some(driven) = Driven::<T>::of::<G>(question.problem, &forms)? else {
            return Err(Halt::Undecided(SwitchingError::Stuck));
        };
        March::new(question, driven, doubt, tolerance)
    }

    /// Leaves but a part of the multiplications that a motion may take.
    pub(crate) fn spare(&mut self, part: f64) {
        self.budget *= part;
    }

    /// Displacements and then velocities of all coordinates, as functions of ζ.
    pub(crate) fn motion(&self) -> Vec<Row<T>> {
        let count = self.question.problem.system().len();
        let [x, v]: [Vec<_>; 2] = [0, 1].map(|kind| {
            let each = (0..count).map(|i| {
                let [x, v] = self.driven.coordinate(i);
                Row::with_constant(if kind == 0 { x } else { v }, T::ZERO)
            });
            each.collect()
        });
        x.into_iter().chain(v).collect()
    }

    /// Starts from other displacements and then velocities, known to these bounds, with the tangent; and what a unit of each
    /// adds to ζ.
    pub(crate) fn place(&mut self, motion: &[T], off: &[f64]) -> Vec<Vec<f64>> {
        let n = self.zeta.len();
        let start = |motion: &[T]| {
            let mut zeta = self.driven.start_from(motion);
            zeta.push(self.constant);
            zeta
        };
        let rest = start(&vec![T::ZERO; motion.len()]);
        let enter = (0..motion.len()).map(|j| {
            let mut unit = vec![T::ZERO; motion.len()];
            unit[j] = T::ONE;
            let each = start(&unit);
            let each = each.iter().zip(&rest).map(|(a, b)| (*a - *b).to_f64());
            each.collect()
        });
        let enter: Vec<Vec<f64>> = enter.collect();
        self.zeta = start(motion);
        let mut errors = vec![0.0; n];
        for (column, off) in enter.iter().zip(off) {
            let each = errors.iter_mut().zip(column);
            each.for_each(|(error, entry)| *error += entry.abs() * off);
        }
        self.errors.add_each(&errors);
        let identity = |at: usize| f64::from(u8::from(at / n == at % n));
        self.tangent = Some((0..n * n).map(identity).collect());
        enter
    }

    fn new(
        question: &'a Question<'a, 'b>,
        driven: Driven<'a, 'b, T>,
        doubt: Doubt,
        tolerance: f64,
    ) -> Result<March<'a, 'b, T>, Halt> {
        let n = driven.len();
        let grid = question.problem.grid();
        let end = grid.time(grid.last());
        let longest = if end > 0.0 { end } else { 1.0 };
        // Long steps are quick, and lose digits.
        let digits_to_spare = tolerance.is_infinite() || T::UNIT_LOG2 < DoubleDouble::UNIT_LOG2;
        let reach = if digits_to_spare { 8.0 } else { 2.0 };
        let pushes: Vec<(Vec<T>, f64)> = question
            .forms
            .iter()
            .map(|[stretch, _]| {
                let (mut push, error) = driven.push(stretch);
                push.push(T::ZERO);
                (push, upper(error))
            })
            .collect();
        // The constant is about as long as what its forces do to the state.
        let strengths = question
            .switches
            .iter()
            .zip(&pushes)
            .map(|(switch, (push, _))| {
                let force = match switch {
                    Switch::Friction(friction) => friction.static_force,
                    Switch::Stop(stop) => stop.stiffness * stop.gap.abs(),
                    Switch::Impact(_) | Switch::ControlledDamper(_) => 0.0,
                };
                force * length_of(push) * longest
            });
        let strength = strengths.fold(0.0f64, f64::max);
        let power = if strength > 0.0 {
            strength.log2().floor() as i64
        } else {
            0
        };
        let constant = T::ONE.scale(power.clamp(-300, 300));
        let mut places = Vec::with_capacity(question.switches.len());
        for (index, (switch, (push, push_error))) in
            question.switches.iter().zip(pushes).enumerate()
        {
            let row = |known| Row::with_constant(known, T::ZERO);
            let [stretch, rate] = driven.form(2 * index).map(row);
            let [_, body] = driven.form(2 * index + 1).map(row);
            let reply = dot(&rate.entries, &push).to_f64();
            let moved = dot(&stretch.entries, &push).to_f64().abs();
            // A support moves with no force, however far.
            let felt = rate.rounded.iter().zip(&push);
            let felt = felt.filter(|(_, push)| !push.is_zero());
            let felt: Vec<f64> = felt.map(|(entry, _)| *entry).collect();
            let certain = length(&felt) * length_of(&push);
            if driven.gives_way(&question.forms[index][0])
                || reply <= 1e-12 * certain
                || moved > 1e-12 * certain * longest
            {
                let [first, second] = switch.between().clone();
                let fault = SwitchFault::Massless { first, second };
                return Err(Halt::Failed(SwitchingError::Switch {
                    switch: index,
                    fault,
                }));
            }
            places.push(Place {
                switch: switch.clone(),
                stretch,
                rate,
                body,
                push,
                push_error,
            });
        }
        let (given, w_error) = driven.matrix();
        let mut w = vec![T::ZERO; (n + 1) * (n + 1)];
        for i in 0..n {
            w[i * (n + 1)..i * (n + 1) + n].copy_from_slice(&given[i * n..(i + 1) * n]);
        }
        let (mut zeta, error) = driven.start();
        zeta.push(constant);
        let phases: Vec<Phase> = places
            .iter()
            .map(|place| match &place.switch {
                Switch::Friction(_) => Phase::Slip(1),
                Switch::Stop(_) => Phase::Open,
                Switch::Impact(_) => Phase::Free,
                Switch::ControlledDamper(damper) => match damper.law {
                    DamperLaw::OnOffSkyhook => Phase::OnOff { body: 1, rate: 1 },
                    DamperLaw::ClippedSkyhook { .. } => Phase::Clipped {
                        low: -1,
                        high: -1,
                        rate: 1,
                    },
                },
            })
            .collect();
        let count = places.len();
        let w_error = upper(w_error);
        let limits = [longest, reach];
        let current = Configuration::of(&w, w_error, &places, &phases, constant, limits);
        let current = current.map_err(|unfit| match unfit {
            Unfit::Dependent => Halt::Undecided(SwitchingError::Stuck),
            Unfit::OutOfRange => Halt::Failed(SwitchingError::OutOfRange),
        })?;
        Ok(March {
            question,
            driven,
            w,
            w_error,
            constant,
            limits,
            places,
            phases,
            known: HashMap::new(),
            current: Rc::new(current),
            orders: Vec::new(),
            errors: ErrorSet::new(n + 1, upper(error)),
            earlier: zeta.clone(),
            zeta,
            now: T::ZERO,
            doubt,
            tolerance,
            started: false,
            jumped: true,
            bounced: vec![false; count],
            largest: vec![0.0; count],
            turns: vec![Vec::new(); count],
            is_cut: false,
            change: None,
            hidden: (T::ZERO, 0.0, 0),
            delays: vec![None; count],
            added: vec![0.0; n + 1],
            approach: 0,
            passes: 0,
            budget: BUDGET,
            cost: cost::<T>(n + 1),
            events: Vec::new(),
            taken: None,
            followed: None,
            tangent: None,
        })
    }

    /// The system of some phases.
    pub(crate) fn configuration(&mut self, phases: &[Phase]) -> Result<Rc<Configuration<T>>, Halt> {
        let (w, w_error, places) = (&self.w, self.w_error, &self.places);
        let (constant, limits) = (self.constant, self.limits);
        let make = || Configuration::of(w, w_error, places, phases, constant, limits).map(Rc::new);
        let known = self.known.entry(phases.to_vec()).or_insert_with(make);
        let switch = phases.iter().rposition(|phase| phase.holds()).unwrap_or(0);
        let time = self.now.to_f64();
        known.clone().map_err(|unfit| {
            Halt::Failed(match unfit {
                Unfit::Dependent => SwitchingError::Dependent { time, switch },
                Unfit::OutOfRange => SwitchingError::OutOfRange,
            })
        })
    }

    /// Whether a value beside numbers of a size is a coincidence: as far as half of the digits show it is 0.
    pub(crate) fn is_tiny(&self, value: f64, size: f64) -> bool {
        value.abs() <= 2f64.powi(T::UNIT_LOG2 / 2) * size
    }

    pub(crate) fn undecided(&self, switch: usize) -> Halt {
        Halt::Undecided(SwitchingError::Undecided {
            time: self.now.to_f64(),
            switch,
            reason: "it lies on a limit as far as all digits show",
        })
    }

    pub(crate) fn beyond_gap(&self, switch: usize) -> Halt {
        let Switch::Impact(impact) = &self.places[switch].switch else {
            return self.undecided(switch);
        };
        let stretch = self.places[switch].stretch.at(&self.zeta).to_f64();
        let fault = SwitchFault::BeyondGap {
            time: self.now.to_f64(),
            stretch,
            gap: impact.gap,
        };
        Halt::Failed(SwitchingError::Switch { switch, fault })
    }

    /// What is not known of a function of the state, but for rounding of its own.
    pub(crate) fn vague(&self, row: &Row<T>) -> f64 {
        self.errors.along(&row.rounded)
    }

    /// What is not known of the state, in the scales of a configuration.
    pub(crate) fn vague_in(&self, configuration: &Configuration<T>) -> f64 {
        self.errors.size_in(&configuration.scales)
    }

    /// The length of ζ.
    pub(crate) fn size(&self) -> f64 {
        length_of(&self.zeta)
    }

    /// Goes through all pieces up to a time, which is known to a bound; into those that begin there where it is the end of all.
    pub(crate) fn go(
        &mut self,
        (end, blur): (T, f64),
        of_all: bool,
        record: &mut Recorder<'_, 'a, 'b, T>,
    ) -> Result<(), Halt> {
        let problem = self.question.problem;
        let pieces = problem.timeline().pieces();
        let origin = Instant::on_grid(problem.grid(), 0);
        for piece in 0..pieces.len() {
            let own = self.driven.len();
            let mut before = self.zeta.clone();
            if piece == 0 {
                // Supports start from 0, whatever moves them.
                before[self.driven.states()..own].fill(T::ZERO);
            }
            let added = upper(self.driven.begin(piece, &mut self.zeta[..own]));
            self.errors.add(added);
            self.jumped = true;
            let next = pieces.get(piece + 1);
            let next = next.map(|next| self.driven.seconds(&origin, &next.start_instant()));
            let next = next.filter(|(start, _)| *start < end);
            let (until, uncertain) =
                next.map_or((end, blur), |(start, uncertain)| (start, upper(uncertain)));
            self.change = (next.is_some() || !of_all).then_some(until);
            self.pass_on(&before, added)?;
            let change = self.settle(&[], before)?;
            if let Some(map) = &change.map {
                self.turn(map);
            }
            self.note(change, 0.0);
            self.started = true;
            while self.now < until {
                self.step(until, uncertain, record)?;
            }
            if until == end && !of_all {
                break;
            }
        }
        Ok(())
    }

    /// Multiplies the tangent, where there is one.
    pub(crate) fn turn(&mut self, map: &[f64]) {
        if let Some(tangent) = &mut self.tangent {
            *tangent = product(self.zeta.len(), map, tangent);
        }
    }

    fn run(mut self, mut outputs: Outputs<T>) -> Result<Found, Halt> {
        let problem = self.question.problem;
        let grid = problem.grid();
        let origin = Instant::on_grid(grid, 0);
        // The indices asked for, by time.
        let asked: Vec<u64> = match problem.instants() {
            Some(instants) => instants.to_vec(),
            None => (0..=grid.last()).collect(),
        };
        let mut ascending = asked.clone();
        ascending.sort_unstable();
        ascending.dedup();
        let mut samples = ascending
            .iter()
            .map(|index| Instant::on_grid(grid, *index))
            .peekable();
        let last = Instant::on_grid(grid, grid.last());
        let (until, uncertain) = self.driven.seconds(&origin, &last);
        let mut record = |march: &March<'_, 'b, T>, series: &Series<T>, from: T, to: T| {
            while let Some(instant) = samples.peek() {
                let (time, off) = march.driven.seconds(&origin, instant);
                if time >= to {
                    break;
                }
                let theta = (time - from) / T::from(march.current.step);
                let theta = if theta < T::ZERO { T::ZERO } else { theta };
                march.record(&mut outputs, series, theta, upper(off));
                samples.next();
            }
        };
        self.go((until, upper(uncertain)), true, &mut record)?;
        // The end itself, after all that happens there.
        if samples.peek().is_some() {
            let series = Series::of(&self.current, &self.zeta);
            self.record(&mut outputs, &series, T::ZERO, 0.0);
        }
        // And what is reached there.
        let series = Series::of(&self.current, &self.zeta);
        self.follow(&series, 0.0);
        let picked: Vec<usize> = asked
            .iter()
            .map(|index| ascending.binary_search(index).expect("it is one of them"))
            .collect();
        sort_by_number(&mut self.events, |event| event.time);
        // Early events are measured beside a part of the whole time.
        const PART: f64 = 1e-6;
        let end = grid.time(grid.last());
        let tolerance = self.tolerance + f64::EPSILON / 2.0;
        let good = |event: &Event| event.bound <= tolerance * event.time.max(PART * end);
        let is_whole = !self.is_cut || self.tolerance.is_infinite();
        let good = is_whole && outputs.is_good() && self.events.iter().all(good);
        let (trajectory, forces) = outputs.trajectory(problem, asked, &picked);
        Ok(Found {
            good,
            trajectory,
            forces,
            losses: self.taken.as_ref().map(Taken::total),
            peaks: self.followed.and_then(Followed::total),
            events: self.events,
        })
    }

    fn record(&self, outputs: &mut Outputs<T>, series: &Series<T>, theta: T, off: f64) {
        let zeta = series.at(theta);
        let step = self.current.step;
        let rate = match outputs.need_rate() {
            true => {
                let rate = self.current.apply(&zeta);
                rate.into_iter()
                    .map(|entry| entry / T::from(step))
                    .collect()
            }
            false => Vec::new(),
        };
        let n = zeta.len();
        let mut errors = self.errors.clone();
        if theta > T::ZERO {
            errors.map(&exponential(n, &self.current.rounded, theta.to_f64()));
        }
        let speed = self.current.reach / step * series.size;
        let time_error = off + unit::<T>() * 4.0 * self.now.to_f64().abs();
        errors.add_each(&series.error_at(theta.to_f64()));
        let late = moved(&self.current, &zeta);
        errors.add_each(
            &late
                .iter()
                .map(|entry| entry.abs() / step * time_error)
                .collect::<Vec<f64>>(),
        );
        if self.now + theta.mul_f64(step) <= self.hidden.0 {
            errors.add(self.hidden.1);
        }
        let extents = errors.extents();
        let own = self.current.error / step * series.size + unit::<T>() * (n + 3) as f64 * speed;
        let moved_errors = self.current.sized(&extents).into_iter();
        outputs.record(&Moment {
            zeta: &zeta,
            rate: &rate,
            along: &|row| errors.along(row),
            rate_errors: moved_errors
                .map(|error| (error / step + own) * SLACK)
                .collect(),
            rate_size: speed,
            size: series.size,
            forces: &self.current.forces,
        });
    }

    /// Takes the peaks of a step to θ = `end`.
    fn follow(&mut self, series: &Series<T>, end: f64) {
        if let Some(mut followed) = self.followed.take() {
            let (current, now) = (self.current.clone(), self.now.to_f64());
            let off = |row: &Row<T>| self.vague(row) + row.own_error(series.size);
            followed.step(&current, series, now, end, &off);
            self.followed = Some(followed);
        }
    }

    /// One step, to its end, the end of the piece, or an event.
    fn step(
        &mut self,
        until: T,
        uncertain: f64,
        record: &mut Recorder<'_, 'a, 'b, T>,
    ) -> Result<(), Halt> {
        let current = self.current.clone();
        let step = T::from(current.step);
        let series = Series::of(&current, &self.zeta);
        let rest = (until - self.now) / step;
        let reach = if rest > T::ONE { T::ONE } else { rest };
        let (end, roots) = self.look(&series, reach)?;
        let from = self.now;
        let at_end = end == rest;
        let to = if at_end { until } else { from + end * step };
        let bound = roots.iter().map(|root| root.bound).fold(0.0, f64::max) * current.step;
        record(self, &series, from, to - T::from(bound));
        if let Some(taken) = &mut self.taken {
            taken.step(&current, &self.places, &series, end);
        }
        self.follow(&series, end.to_f64());
        // The state there.
        self.zeta = series.at(end);
        let n = self.zeta.len();
        match end == T::ONE {
            true => {
                self.errors.map(&current.power);
                self.turn(&current.power);
            }
            false => {
                let power = exponential(n, &current.rounded, end.to_f64());
                self.errors.map(&power);
                self.turn(&power);
            }
        }
        let clock = unit::<T>() * 4.0 * (to.to_f64().abs() + current.step)
            + if at_end { uncertain } else { 0.0 };
        self.errors.add_each(&series.error_at(end.to_f64()));
        let moved = moved(&current, &self.zeta);
        let late: Vec<f64> = moved
            .iter()
            .map(|entry| entry.abs() / current.step * clock)
            .collect();
        self.errors.add_each(&late);
        self.now = to;
        self.orders
            .iter_mut()
            .filter(|order| **order != usize::MAX)
            .for_each(|order| *order = 0);
        self.jumped = false;
        if !roots.is_empty() {
            let known = roots.iter().map(|root| root.known).fold(0.0, f64::max) * current.step;
            self.happen(&current, &roots, known)?;
        }
        self.check_length(until)
    }

    /// How far the step goes, and the guards that end there. Where one comes too near to 0 to decide, the step ends just before
    /// that, or is made shorter; what all digits cannot decide is passed.
    fn look(&mut self, series: &Series<T>, reach: T) -> Result<(T, Vec<Root<T>>), Halt> {
        const SHORTEST: usize = 40;
        /// The part of the way to such a place that an approach leaves.
        const LEFT: f64 = 1.0 / 1_048_576.0;
        let most = usize::try_from(-T::UNIT_LOG2 / 20).expect("a count");
        let mut part = reach;
        for shorter in 0.. {
            let (roots, hidden) = self.roots(series, part)?;
            let Some(hidden) = hidden else {
                let Some(first) = roots.first() else {
                    match part == reach {
                        true => (self.approach, self.passes) = (0, 0),
                        false => self.approach += 1,
                    }
                    return Ok((part, Vec::new()));
                };
                self.approach = 0;
                let end = if first.theta > reach {
                    reach
                } else {
                    first.theta
                };
                return Ok((end, roots));
            };
            let place = hidden.place;
            if place > part.to_f64() / 64.0 && self.approach < most {
                self.approach += 1;
                return Ok((T::from(place * (1.0 - LEFT)), Vec::new()));
            }
            let factor = (16.0 * place / part.to_f64()).clamp(1.0 / 4096.0, 0.5);
            let next = part.mul_f64(factor);
            let is_last = shorter == SHORTEST;
            // Many steps this short would come no nearer to a touch.
            let passes = (is_last || self.is_tiny(next.to_f64(), reach.to_f64()))
                && self.doubt != Doubt::Refused
                && self.is_touch(series, &hidden);
            if is_last && !passes {
                return Err(self.undecided(self.current.guards[hidden.guard].switch));
            }
            if passes {
                let far = 2f64.powi((self.passes - 40).min(-6));
                self.passes += 1;
                let past = T::from(place + far);
                return Ok((if past < reach { past } else { reach }, Vec::new()));
            }
            part = next;
        }
        unreachable!("it is passed at last")
    }

    /// Whether a guard just touches 0 there.
    fn is_touch(&self, series: &Series<T>, hidden: &Hidden) -> bool {
        let row = &self.current.guards[hidden.guard].row;
        let value = row.at(&series.at(T::from(hidden.place))).to_f64();
        self.is_tiny(value, row.norm * series.size)
    }

    /// Where guards end within the step, all that may be the first; or what comes too near to 0 to decide before that.
    fn roots(&self, series: &Series<T>, reach: T) -> Result<(Vec<Root<T>>, Option<Hidden>), Halt> {
        let mut found: Vec<Root<T>> = Vec::new();
        let mut hidden: Option<Hidden> = None;
        let off = self.vague_in(&self.current);
        let far = reach.mul_f64(BEYOND);
        let short = far.to_f64();
        for (at, guard) in self.current.guards.iter().enumerate() {
            let order = self.orders.get(at).copied().unwrap_or(0);
            if order == usize::MAX {
                continue;
            }
            let (coefficients, sizes) = series.of_row_rounded(&guard.row);
            if coefficients.len() <= order {
                continue;
            }
            // A little beyond the reach, in units of that.
            let scaled = |values: &[f64]| {
                let mut power = 1.0;
                let scaled = values[order..].iter().map(|value| {
                    let own = value * power;
                    power *= short;
                    own
                });
                scaled.collect::<Vec<f64>>()
            };
            let margin = |off: f64, first: f64| {
                let mut errors = series.coefficient_errors(&self.current, &guard.row, off, &sizes);
                errors[0] += first;
                scaled(&errors).iter().sum::<f64>()
            };
            let known = margin(off, self.vague(&guard.row));
            let margin = match self.doubt {
                Doubt::Ignored => margin(0.0, 0.0),
                _ => known,
            };
            let width = (guard.row.entries.len() + 4) as f64;
            let rounding: f64 = scaled(&sizes).iter().sum::<f64>() * f64::EPSILON * width;
            let exact = || {
                let mut power = T::ONE;
                let all = series.of_row(&guard.row);
                let scaled = all[order..].iter().map(|value| {
                    let own = *value * power;
                    power = power * far;
                    own
                });
                scaled.collect::<Vec<T>>()
            };
            let mut answer = first(&scaled(&coefficients), margin + rounding);
            if let First::Hidden(_) = answer {
                answer = first(&exact(), margin);
            }
            match answer {
                First::None => {}
                First::Between(from, to) => {
                    let exact = exact();
                    let theta = refine(&exact, from, to);
                    let slope = self.slope(&exact, theta.to_f64());
                    let bound = |margin: f64| {
                        let bound = match slope < 0.0 {
                            true => 1.5 * margin / -slope,
                            false => 1.0,
                        };
                        (bound + unit::<T>() * 8.0) * short
                    };
                    let (bound, known) = (bound(margin), bound(known));
                    let theta = theta * far;
                    if (theta - reach).to_f64() > bound {
                        continue;
                    }
                    found.push(Root {
                        guard: at,
                        theta,
                        bound,
                        known,
                    });
                }
                First::Hidden(place) if place * BEYOND > 1.0 => {}
                First::Hidden(place) => {
                    let place = place * short;
                    if hidden.as_ref().is_none_or(|known| place < known.place) {
                        hidden = Some(Hidden { place, guard: at });
                    }
                }
            }
        }
        let Some(earliest) = found
            .iter()
            .map(|root| root.theta)
            .reduce(|a, b| if a < b { a } else { b })
        else {
            return Ok((found, hidden));
        };
        let bound = found
            .iter()
            .filter(|root| root.theta == earliest)
            .map(|root| root.bound)
            .fold(0.0, f64::max);
        found.retain(|root| (root.theta - earliest).to_f64() <= root.bound + bound);
        found.sort_by(|a, b| a.theta.partial_cmp(&b.theta).expect("numbers"));
        if let Some(hidden) = &hidden
            && hidden.place < earliest.to_f64() + bound
        {
            return Ok((Vec::new(), Some(*hidden)));
        }
        let switches = found
            .iter()
            .map(|root| self.current.guards[root.guard].switch);
        if switches.clone().min() != switches.max() && self.doubt == Doubt::Refused {
            return Err(self.undecided(self.current.guards[found[0].guard].switch));
        }
        Ok((found, None))
    }

    /// The slope of a polynomial.
    fn slope(&self, coefficients: &[T], theta: f64) -> f64 {
        let (mut sum, mut slope) = (0.0, 0.0);
        for entry in coefficients.iter().rev() {
            slope = slope * theta + sum;
            sum = sum * theta + entry.to_f64();
        }
        slope
    }

    /// What happens where guards end.
    fn happen(
        &mut self,
        old: &Rc<Configuration<T>>,
        roots: &[Root<T>],
        bound: f64,
    ) -> Result<(), Halt> {
        let n = self.zeta.len();
        let before = old.apply(&self.zeta);
        let guard = &old.guards[roots[0].guard].row;
        // How the time of the event follows the error of the state, in steps.
        let fall = guard.at(&before).to_f64();
        let residual = guard.at(&self.zeta).to_f64().abs() + 2.0 * guard.own_error(self.size());
        let mut due: Vec<usize> = roots
            .iter()
            .map(|root| old.guards[root.guard].switch)
            .collect();
        due.dedup();
        if self.interrupts(&due) {
            return Err(self.interrupted(due[0]));
        }
        let errors = self.errors.clone();
        let time_bound = bound;
        let change = self.settle(&due, self.zeta.clone())?;
        let new = self.current.clone();
        // W′ζ after, in the old step's unit, less what becomes of Wζ.
        let ratio = old.step / new.step;
        let after = new.apply(&self.zeta);
        let before: Vec<f64> = before.iter().map(|entry| entry.to_f64()).collect();
        let carried = match &change.map {
            None => before.clone(),
            Some(map) => (0..n)
                .map(|i| (0..n).map(|j| map[i * n + j] * before[j]).sum())
                .collect(),
        };
        let jump: Vec<f64> = carried
            .iter()
            .zip(&after)
            .map(|(a, b)| a - b.to_f64() * ratio)
            .collect();
        let leap = length(&jump);
        let beside = length(&before);
        if fall >= 0.0 && leap > 1e-14 * beside {
            return Err(self.undecided(due[0]));
        }
        if fall < 0.0 && !self.is_tiny(leap, beside) {
            // e ← e − jump·(guard·e₀)/fall, with e₀ the error before.
            let mut shift = vec![0.0; n * n];
            for i in 0..n {
                for j in 0..n {
                    shift[i * n + j] = -jump[i] * guard.rounded[j] / fall;
                }
            }
            let added = errors.mapped_with(&shift, change.map.as_deref());
            let identity = |at: usize| f64::from(u8::from(at / n == at % n));
            let map = shift
                .iter()
                .enumerate()
                .map(|(at, shift)| shift + change.map.as_ref().map_or(identity(at), |map| map[at]));
            self.turn(&map.collect::<Vec<f64>>());
            let late = residual / -fall;
            let rest: Vec<f64> = jump.iter().map(|entry| entry.abs() * late).collect();
            self.errors = added;
            let grown = change.map.as_deref().map_or(1.0, length);
            self.errors.add_each(
                &self
                    .added
                    .iter()
                    .map(|added| added * grown)
                    .collect::<Vec<f64>>(),
            );
            self.errors.add_each(&rest);
            let shifted = errors.along(&guard.rounded) / -fall + late;
            // Beyond the first order: what either system does in the time that the event is off.
            let sizes: Vec<f64> = self.zeta.iter().map(|entry| entry.to_f64().abs()).collect();
            let by_old = old.strays(&sizes, &errors, shifted);
            let by_new = new.strays(&sizes, &self.errors, shifted * ratio);
            let mapped = |i: usize| match &change.map {
                None => by_old[i],
                Some(map) => (0..n).map(|j| map[i * n + j].abs() * by_old[j]).sum(),
            };
            let rest: Vec<f64> = (0..n).map(|i| mapped(i) + by_new[i]).collect();
            self.errors.add_each(&rest);
        } else {
            self.errors.add(leap * bound / old.step);
            if let Some(map) = &change.map {
                self.turn(map);
            }
        }
        self.note(change, time_bound);
        Ok(())
    }

    /// Keeps what happened.
    fn note(&mut self, change: Change, bound: f64) {
        let now = self.now;
        let time = now.to_f64();
        let rounding = (now - T::from(time)).to_f64().abs() + unit::<T>() * 4.0 * time.abs();
        for (switch, kind, delay, off) in change.happened {
            let late = (now + T::from(delay)).to_f64();
            let more = if delay > 0.0 {
                late.abs() * f64::EPSILON
            } else {
                rounding
            };
            // While bounces go on that are left out, nothing else is known better than to their time.
            let among = if delay > 0.0 {
                0.0
            } else {
                (self.hidden.0 - now).to_f64().max(0.0)
            };
            self.events.push(Event {
                time: late,
                bound: (bound + more + off + among) * SLACK,
                switch,
                kind,
            });
        }
    }

    /// Ends what would take too long.
    fn check_length(&mut self, until: T) -> Result<(), Halt> {
        self.budget -= self.cost;
        const MOST_EVENTS: usize = 5_000_000;
        const MOST_STEPS: f64 = 3e7;
        const WINDOW: usize = 500_000;
        let steps = (until - self.now).to_f64() / self.current.step;
        if steps > MOST_STEPS || self.budget < 0.0 {
            let rate = self.current.reach / self.current.step;
            return Err(Halt::Failed(SwitchingError::TooLong { steps, rate }));
        }
        let count = self.events.len();
        let crowded = count > WINDOW && {
            let since = self.events[count - WINDOW].time;
            self.now.to_f64() - since < 1e-9 * self.limits[0]
        };
        match self.events.last() {
            Some(last) if crowded || count > MOST_EVENTS => {
                Err(Halt::Failed(SwitchingError::Endless {
                    events: count,
                    time: self.now.to_f64(),
                    switch: last.switch,
                }))
            }
            _ => Ok(()),
        }
    }
}

/// As many multiplications of 32 digits as take a minute or two, about.
const BUDGET: f64 = 2e10;

/// How many of those a step of n entries takes, about.
fn cost<T: Real>(n: usize) -> f64 {
    const TERMS: f64 = 32.0;
    let weight = f64::from(T::UNIT_LOG2) / f64::from(DoubleDouble::UNIT_LOG2);
    TERMS * (n * n) as f64 * weight * weight
}

/// Wζ·h, about.
fn moved<T: Real>(configuration: &Configuration<T>, zeta: &[T]) -> Vec<f64> {
    let n = zeta.len();
    let zeta: Vec<f64> = zeta.iter().map(|entry| entry.to_f64()).collect();
    let row = |i: usize| configuration.rounded[i * n..(i + 1) * n].iter().zip(&zeta);
    (0..n).map(|i| row(i).map(|(a, b)| a * b).sum()).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use eigentone_digits::Wide;
    use eigentone_modes::{GROUND, System};
    use eigentone_response::{Harmonic, Quantity, Ramp, Response, State, Step};

    use super::*;
    use crate::event::EventKind;
    use crate::switch::{ControlledDamper, Friction, Stop};
    use crate::switching::Switching;

    /// Units of mass, time and length.
    type Units = [f64; 3];

    /// What came of a motion, in units of its own.
    #[derive(Debug)]
    struct Passed {
        events: Vec<(usize, EventKind, f64)>,
        steps: f64,
        /// Displacements and then velocities.
        end: Vec<f64>,
    }

    fn passed(ask: Response<'_>, switches: Vec<Switch>, units: Units) -> Passed {
        passed_with::<DoubleDouble>(ask, switches, units, Doubt::Refused)
    }

    fn passed_with<T: Real>(
        ask: Response<'_>,
        switches: Vec<Switch>,
        [_, s, m]: Units,
        doubt: Doubt,
    ) -> Passed {
        let problem = ask.problem().expect("a problem");
        let switching = Switching::new(&problem, switches).expect("switches");
        let question = switching.question();
        let march = March::<T>::of::<Wide<4>>(question, doubt, 1e-15);
        let mut march = march.unwrap_or_else(|halt| panic!("{}", SwitchingError::from(halt)));
        let end = problem.grid().time(problem.grid().last());
        let gone = march.go((T::from(end), 0.0), true, &mut |_, _, _, _| {});
        gone.unwrap_or_else(|halt| panic!("{}", SwitchingError::from(halt)));
        let motion = march.motion();
        let units = |i: usize| if 2 * i < motion.len() { m } else { m / s };
        let at = |(i, row): (usize, &Row<_>)| row.at(&march.zeta).to_f64() / units(i);
        let events = march.events.iter();
        Passed {
            end: motion.iter().enumerate().map(at).collect(),
            events: events
                .map(|event| (event.switch, event.kind, event.time / s))
                .collect(),
            steps: (BUDGET - march.budget) / march.cost,
        }
    }

    fn between(a: &str, b: &str) -> [String; 2] {
        [a.into(), b.into()]
    }

    /// Half swings of π s, each of which loses 2·0.02 m of 0.25 m.
    fn friction([kg, s, m]: Units) -> Passed {
        let [force, stiffness] = [kg * m / (s * s), kg / (s * s)];
        let system = System::builder().mass("m", kg);
        let system = system.spring(GROUND, "m", stiffness).build();
        let system = system.expect("a system");
        let from = State::at_rest().displace("m", 0.25 * m);
        let ask = Response::of(&system).from(from);
        let friction = Switch::Friction(Friction {
            between: between(GROUND, "m"),
            force: 0.02 * force,
            static_force: 0.02 * force,
        });
        passed(
            ask.every(0.5 * s).until(32.0 * s),
            vec![friction],
            [kg, s, m],
        )
    }

    /// Half swings of π s on one side of 0, and of π/2 s in the stop on the other.
    fn stop([kg, s, m]: Units) -> Passed {
        let stiffness = kg / (s * s);
        let system = System::builder().mass("m", kg);
        let system = system.spring(GROUND, "m", stiffness).build();
        let system = system.expect("a system");
        let from = State::at_rest().displace("m", -0.25 * m);
        let ask = Response::of(&system).from(from);
        let stop = Switch::Stop(Stop {
            between: between(GROUND, "m"),
            gap: 0.0,
            stiffness: 3.0 * stiffness,
            damping: 0.0,
        });
        passed(ask.every(0.5 * s).until(32.0 * s), vec![stop], [kg, s, m])
    }

    /// A ramp and a harmonic load beside an on-off damper.
    fn loaded([kg, s, m]: Units) -> Passed {
        let force = kg * m / (s * s);
        let system = System::builder().mass("a", 0.9 * kg).mass("b", 0.4 * kg);
        let system = system.spring(GROUND, "a", 12.0 * kg / (s * s));
        let system = system.spring("a", "b", 90.0 * kg / (s * s)).build();
        let system = system.expect("a system");
        let from = State::at_rest()
            .displace("a", -0.2 * m)
            .push("a", -0.3 * m / s);
        let ask = Response::of(&system).from(from);
        let ask = ask.load("b", Harmonic::of(16.0 * force, 5.5 / s).with_phase(2.5));
        let ask = ask.load("b", Ramp::of(-2.7 * force / s));
        let damper = Switch::ControlledDamper(ControlledDamper {
            between: between("a", "b"),
            low: 0.11 * kg / s,
            high: 10.0 * kg / s,
            law: DamperLaw::OnOffSkyhook,
        });
        passed(ask.every(0.1 * s).until(2.4 * s), vec![damper], [kg, s, m])
    }

    /// A mass on a belt slips at 0.3 m and 2 m/s, and then swings about there with a speed that is that of the belt once a
    /// turn.
    #[test]
    fn touches_of_a_limit_take_few_steps() {
        let system = System::builder().mass("m", 1.0).support("belt");
        let system = system.spring(GROUND, "m", 30.0).build();
        let system = system.expect("a system");
        let ask = Response::of(&system).from(State::at_rest().push("m", 2.0));
        let ask = ask.motion("belt", Quantity::Velocity, Step::of(2.0));
        let friction = Switch::Friction(Friction {
            between: between("m", "belt"),
            force: 9.0,
            static_force: 9.0,
        });
        let ask = ask.every(0.5).until(10.0);
        let found = passed_with::<Wide<4>>(ask, vec![friction], [1.0; 3], Doubt::Coincidence);
        assert!(found.events.len() == 1 && found.events[0].1 == EventKind::Slip);
        let (w, t) = (30f64.sqrt(), found.events[0].2);
        let [x, v] = [
            0.3 + 2.0 / w * (w * (10.0 - t)).sin(),
            2.0 * (w * (10.0 - t)).cos(),
        ];
        let off = [t - 0.15, found.end[0] - x, found.end[1] - v];
        assert!(off.iter().all(|off| off.abs() < 1e-13), "{found:?}");
        assert!(found.steps < 200.0, "{found:?}");
    }

    #[test]
    fn a_motion_takes_as_many_steps_in_any_units() {
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-13 * (1.0 + b.abs());
        for scene in [friction, stop, loaded] {
            let plain = scene([1.0; 3]);
            assert!(plain.events.len() > 3 && plain.steps < 200.0, "{plain:?}");
            for (unit, power) in (0..9).map(|k| (k / 3, 30 * (k % 3) - 30)) {
                let mut units = [1.0; 3];
                units[unit as usize] = 2f64.powi(power);
                let other = scene(units);
                let mut events = plain.events.iter().zip(&other.events);
                let alike = plain.events.len() == other.events.len()
                    && events.all(|(a, b)| (a.0, a.1) == (b.0, b.1) && close(a.2, b.2));
                let ends = plain.end.iter().zip(&other.end).all(|(a, b)| close(*a, *b));
                let steps = (plain.steps - other.steps).abs() <= 0.25 * plain.steps;
                assert!(alike && ends && steps, "{unit} {power} {plain:?} {other:?}");
            }
        }
        // Each half swing of π s loses 2·0.02 m: the sixth ends within 0.02 m of 0.
        let rest = friction([1.0; 3]);
        let (_, kind, time) = rest.events[rest.events.len() - 1];
        assert!(kind == EventKind::Stick && close(time, 6.0 * PI) && close(rest.end[0], 0.01));
    }
}
