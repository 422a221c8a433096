//! A system and its loads as one autonomous system z′ = A z: what supports have moved, straight forces and their slopes, and
//! the two components of each harmonic force and pulse, are states beside those of the system.

use std::collections::BTreeMap;

use eigentone_response::Problem;
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Zero};

use super::ball::Ball;
use super::equation::exactly;
use super::error::ReferenceError;
use super::events::{Change, Events, Pulse};
use super::first_order_form::FirstOrderForm;
use super::pi_polynomial::{PiMatrix, PiPolynomial};

/// z′ = A z between events, in coordinates z_i 2^−`scale`_i in which no entry of A is much larger
/// than it need be; x = X z, v = X A z.
pub(super) struct DrivenForm {
    /// A, scaled.
    pub(super) motion: PiMatrix,
    /// X and X A, of the unscaled state.
    pub(super) displacement: PiMatrix,
    pub(super) velocity: PiMatrix,
    pub(super) scale: Vec<i64>,
    start: Vec<BigRational>,
    /// The harmonic forces.
    phases: Vec<Phase>,
    /// By instant: the components of the unscaled state that jump, and by how much.
    pub(super) jumps: BTreeMap<BigRational, Vec<(usize, PiPolynomial)>>,
}

/// A harmonic force.
pub(super) struct Phase {
    /// The first of its two states.
    sine: usize,
    /// In rad.
    phase: f64,
    /// What its setting in adds to the states of the system: factors of its sine and of its cosine.
    changes: Vec<(usize, [BigRational; 2])>,
}

impl DrivenForm {
    pub(super) fn of(problem: &Problem<'_>) -> Result<DrivenForm, ReferenceError> {
        let form = FirstOrderForm::of(problem.system())?;
        let events = Events::of(problem)?;
        let r = form.states();
        let n = problem.system().len();

        // Where each signal and its slope are among the states, and what of it is integrated.
        let channels = problem.channels();
        let mut order = r;
        let integrals: Vec<usize> = channels
            .iter()
            .map(|channel| {
                order += channel.integrals;
                order - channel.integrals
            })
            .collect();
        let mut forces = BTreeMap::new();
        let straight = events.changes.iter();
        let straight = straight.filter(|event| !matches!(event.change, Change::Impulse(_)));
        let shifted = events.pulses.iter().filter(|pulse| pulse.half_turns == 2);
        let shifted = shifted.map(|pulse| pulse.coordinate);
        for signal in straight.map(|event| event.coordinate).chain(shifted) {
            forces.entry(signal).or_insert_with(|| {
                order += 2;
                order - 2
            });
        }
        let harmonics = order;
        order += 2 * events.harmonics.len();
        let pulses = order;
        order += 2 * events.pulses.len();

        // The signals, and how all but the states of the system go on.
        let mut signals = PiMatrix::zeros(n + channels.len(), order);
        let mut motion = PiMatrix::zeros(order, order);
        for (&signal, &force) in &forces {
            *signals.at_mut(signal, force) = PiPolynomial::one();
            *motion.at_mut(force, force + 1) = PiPolynomial::one();
        }
        for (k, (on, harmonic)) in events.harmonics.iter().enumerate() {
            let (sine, cosine) = (harmonics + 2 * k, harmonics + 2 * k + 1);
            *signals.at_mut(*on, sine) += exactly(harmonic.amplitude).into();
            *motion.at_mut(sine, cosine) = exactly(harmonic.frequency).into();
            *motion.at_mut(cosine, sine) = exactly(-harmonic.frequency).into();
        }
        let rate = |pulse: &Pulse| {
            BigRational::from_integer(pulse.half_turns.into()) / (&pulse.end - &pulse.start)
        };
        for (k, pulse) in events.pulses.iter().enumerate() {
            let (sine, cosine) = (pulses + 2 * k, pulses + 2 * k + 1);
            match pulse.half_turns {
                1 => *signals.at_mut(pulse.coordinate, sine) += pulse.height.clone().into(),
                _ => *signals.at_mut(pulse.coordinate, cosine) += (-&pulse.height / two()).into(),
            }
            *motion.at_mut(sine, cosine) = PiPolynomial::times_pi(rate(pulse));
            *motion.at_mut(cosine, sine) = PiPolynomial::times_pi(-rate(pulse));
        }
        for (at, channel) in channels.iter().enumerate() {
            for k in 1..=channel.integrals {
                let row = integrals[at] + k - 1;
                match k == channel.integrals {
                    true => (0..order).for_each(|j| {
                        let entry = signals.at(n + at, j).clone();
                        *motion.at_mut(row, j) = entry;
                    }),
                    false => *motion.at_mut(row, row + 1) = PiPolynomial::one(),
                }
            }
        }
        // The forces on coordinates: f = Σ directions[k]·u⁽ᵏ⁾.
        let coordinates: Vec<usize> = (0..n).collect();
        let columns: Vec<usize> = (0..order).collect();
        let mut pushed = signals.block(&coordinates, &columns);
        for (at, channel) in channels.iter().enumerate() {
            let mut course = match channel.integrals {
                0 => signals.block(&[n + at], &columns),
                _ => PiMatrix::selection(&[integrals[at]], order),
            };
            for direction in &channel.directions {
                for &(row, factor) in direction {
                    for (_, j, entry) in course.nonzeros() {
                        *pushed.at_mut(row, j) += entry * &exactly(factor);
                    }
                }
                course = course.times(&motion);
            }
        }
        let mut output = PiMatrix::zeros(n, order);
        for (from, to) in [(&form.motion, &mut motion), (&form.output, &mut output)] {
            for (i, j, entry) in from.nonzeros() {
                match j.checked_sub(r) {
                    None => *to.at_mut(i, j) += entry.clone().into(),
                    Some(coordinate) => {
                        for column in r..order {
                            let push = pushed.at(coordinate, column);
                            if !push.is_zero() {
                                *to.at_mut(i, column) += push * entry;
                            }
                        }
                    }
                }
            }
        }

        // What momenta on coordinates add to the states.
        let changed_by = |direction: &[(usize, f64)], load: usize| {
            let mut changes = vec![BigRational::zero(); r];
            if form.gives_way(direction) {
                return Err(ReferenceError::ImpulseGivesWay { load });
            }
            for &(row, factor) in direction {
                for (i, change) in changes.iter_mut().enumerate() {
                    *change += form.motion.at(i, r + row) * exactly(factor);
                }
            }
            Ok(changes)
        };
        // Those that a jump of a signal (0) or of its slope (1) makes.
        let passed_on = |signal: usize, order: usize, load: usize| {
            let direction = signal.checked_sub(n).and_then(|at| {
                let place = channels[at].integrals + order + 1;
                channels[at].directions.get(place)
            });
            changed_by(direction.map_or(&[][..], Vec::as_slice), load)
        };
        let mut phases = Vec::new();
        for (k, (on, harmonic)) in events.harmonics.iter().enumerate() {
            let amplitude = exactly(harmonic.amplitude);
            let growth = &amplitude * exactly(harmonic.frequency);
            let jumps = passed_on(*on, 0, k)?.into_iter().zip(passed_on(*on, 1, k)?);
            let changes = jumps.map(|(value, slope)| [value * &amplitude, slope * &growth]);
            phases.push(Phase {
                sine: harmonics + 2 * k,
                phase: harmonic.phase,
                changes: changes.enumerate().collect(),
            });
        }
        let mut jumps: BTreeMap<BigRational, Vec<(usize, PiPolynomial)>> = BTreeMap::new();
        for (k, pulse) in events.pulses.iter().enumerate() {
            // The slope jumps by as much at both ends of a half sine, and by nothing at those of a versine.
            let turn = PiPolynomial::times_pi(&pulse.height * rate(pulse));
            let changes = match pulse.half_turns {
                1 => passed_on(pulse.coordinate, 1, pulse.load)?,
                _ => Vec::new(),
            };
            for (time, cosine, half) in [
                (&pulse.start, 1, &pulse.height / two()),
                (
                    &pulse.end,
                    2 * i64::from(pulse.half_turns % 2) - 1,
                    -&pulse.height / two(),
                ),
            ] {
                let here = jumps.entry(time.clone()).or_default();
                let cosine = BigRational::from_integer(cosine.into());
                here.push((pulses + 2 * k + 1, cosine.into()));
                if pulse.half_turns == 2 {
                    here.push((forces[&pulse.coordinate], half.into()));
                }
                let entries = changes.iter().enumerate();
                let entries = entries.filter(|(_, change)| !change.is_zero());
                here.extend(entries.map(|(i, change)| (i, &turn * change)));
            }
        }
        for event in events.changes {
            let here = jumps.entry(event.time).or_default();
            let (changes, size) = match event.change {
                Change::Force(force) => {
                    here.push((forces[&event.coordinate], force.clone().into()));
                    (passed_on(event.coordinate, 0, event.load)?, force)
                }
                Change::Slope(slope) => {
                    here.push((forces[&event.coordinate] + 1, slope.clone().into()));
                    (passed_on(event.coordinate, 1, event.load)?, slope)
                }
                Change::Impulse(impulse) => {
                    let alone = [(event.coordinate, 1.0)];
                    let direction = match event.coordinate.checked_sub(n) {
                        None => &alone[..],
                        Some(at) => &channels[at].directions[0],
                    };
                    (changed_by(direction, event.load)?, impulse)
                }
            };
            let entries = changes.into_iter().enumerate();
            let entries = entries.filter(|(_, change)| !change.is_zero());
            here.extend(entries.map(|(i, change)| (i, (change * &size).into())));
        }
        let mut start = form.start(problem.initial_displacement(), problem.initial_velocity());
        start.resize(order, BigRational::zero());
        let scale = scale(&motion, r, forces.values().copied(), harmonics);
        let velocity = output.times(&motion);
        Ok(DrivenForm {
            motion: PiMatrix::from_fn(order, order, |i, j| {
                motion.at(i, j).shifted(scale[j] - scale[i])
            }),
            displacement: output,
            velocity,
            scale,
            start,
            phases,
            jumps,
        })
    }

    /// The unscaled state at t = 0 apart from the harmonic forces.
    pub(super) fn given(&self) -> &[BigRational] {
        &self.start
    }

    /// Unscaled columns of which the state at t = 0 has the sine and the cosine of each phase: the two states of each
    /// harmonic force, with what its setting in adds to others.
    pub(super) fn phased(&self) -> impl Iterator<Item = Vec<(usize, BigRational)>> {
        self.phases.iter().flat_map(|phase| {
            [0, 1].map(|part| {
                let changes = phase.changes.iter();
                let mut column: Vec<_> = changes
                    .map(|(state, factors)| (*state, factors[part].clone()))
                    .collect();
                column.push((phase.sine + part, BigRational::one()));
                column
            })
        })
    }

    /// The unscaled state at t = 0, before what happens then.
    pub(super) fn start(&self, bits: u64) -> Vec<Ball> {
        let mut start: Vec<Ball> = self
            .start
            .iter()
            .map(|value| Ball::rational(value, bits))
            .collect();
        for phase in &self.phases {
            let angle = Ball::rational(&exactly(phase.phase), bits);
            let (sine, cosine) = angle.sin_cos();
            for (state, factors) in &phase.changes {
                for (factor, part) in factors.iter().zip([&sine, &cosine]) {
                    let change = &Ball::rational(factor, bits) * part;
                    start[*state] = &start[*state] + &change;
                }
            }
            (start[phase.sine], start[phase.sine + 1]) = (sine, cosine);
        }
        start
    }
}

fn two() -> BigRational {
    BigRational::from_integer(2.into())
}

/// `value`·2^`power`.
pub(super) fn shifted(value: &BigRational, power: i64) -> BigRational {
    let factor = BigRational::from(BigInt::one() << power.unsigned_abs());
    match power < 0 {
        true => value / factor,
        false => value * factor,
    }
}

/// Powers of two for the states: those of the system balance its rows against its columns
/// (B. Parlett and C. Reinsch, *Balancing a matrix*, Numer. Math. 13, 1969), those of the loads make
/// what they do no larger than the rest.
fn scale(
    motion: &PiMatrix,
    states: usize,
    forces: impl Iterator<Item = usize>,
    harmonics: usize,
) -> Vec<i64> {
    let mut scale = vec![0i64; motion.nrows()];
    let entries: Vec<(usize, usize, f64)> = motion
        .nonzeros()
        .map(|(i, j, entry)| (i, j, entry.log2()))
        .collect();
    let largest = |scale: &[i64], chosen: &dyn Fn(usize, usize) -> bool| {
        let chosen = entries.iter().filter(|(i, j, _)| chosen(*i, *j));
        let sizes = chosen.map(|(i, j, log)| log + (scale[*j] - scale[*i]) as f64);
        sizes.fold(f64::NEG_INFINITY, f64::max)
    };
    for _ in 0..20 {
        let mut settled = true;
        for k in 0..states {
            let row = largest(&scale, &|i, j| i == k && j != k && j < states);
            let column = largest(&scale, &|i, j| j == k && i != k && i < states);
            let shift = ((row - column) / 2.0).round();
            if shift.is_finite() && shift != 0.0 {
                scale[k] += shift as i64;
                settled = false;
            }
        }
        if settled {
            break;
        }
    }
    let most = largest(&scale, &|i, j| i < states && j < states);
    let most = if most.is_finite() { most } else { 0.0 };
    let fit = |scale: &[i64], state: usize| {
        let column = largest(scale, &|i, j| j == state && i < states);
        if column.is_finite() {
            (most - column).round() as i64
        } else {
            0
        }
    };
    for force in forces {
        scale[force] = fit(&scale, force);
        scale[force + 1] = scale[force] + most.round() as i64;
    }
    for sin in (harmonics..motion.nrows()).step_by(2) {
        scale[sin] = fit(&scale, sin);
        scale[sin + 1] = scale[sin];
    }
    scale
}
