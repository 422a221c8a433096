//! A system and its loads as one autonomous system z′ = A z: straight forces and their slopes, and
//! the two components of each harmonic force, are states beside those of the system.

use std::collections::BTreeMap;

use eigentone_response::Problem;
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Zero};

use super::ball::Ball;
use super::equation::{exactly, log2};
use super::error::ReferenceError;
use super::events::{Change, Events};
use super::first_order_form::FirstOrderForm;
use super::rational_matrix::RationalMatrix;

/// z′ = A z between events, in coordinates z_i 2^−`scale`_i in which no entry of A is much larger
/// than it need be; x = X z, v = X A z.
pub(super) struct DrivenForm {
    /// A, scaled.
    pub(super) motion: RationalMatrix,
    /// X and X A, of the unscaled state.
    pub(super) displacement: RationalMatrix,
    pub(super) velocity: RationalMatrix,
    pub(super) scale: Vec<i64>,
    start: Vec<BigRational>,
    /// The states of each harmonic force and its phase.
    phases: Vec<(usize, f64)>,
    /// By instant: the components of the unscaled state that jump, and by how much.
    pub(super) jumps: BTreeMap<BigRational, Vec<(usize, BigRational)>>,
}

impl DrivenForm {
    pub(super) fn of(problem: &Problem<'_>) -> Result<DrivenForm, ReferenceError> {
        let form = FirstOrderForm::of(problem.system())?;
        let events = Events::of(problem)?;
        let r = form.states();
        let n = problem.system().len();

        // Where each force and its slope are among the states.
        let mut forces = BTreeMap::new();
        let mut order = r;
        for event in &events.changes {
            if !matches!(event.change, Change::Impulse(_)) {
                forces.entry(event.coordinate).or_insert_with(|| {
                    order += 2;
                    order - 2
                });
            }
        }
        let harmonics = order;
        order += 2 * events.harmonics.len();

        let mut motion = RationalMatrix::zeros(order, order);
        let mut output = RationalMatrix::zeros(n, order);
        for (from, to) in [(&form.motion, &mut motion), (&form.output, &mut output)] {
            for (i, j, entry) in from.nonzeros() {
                let Some(coordinate) = j.checked_sub(r) else {
                    *to.at_mut(i, j) = entry.clone();
                    continue;
                };
                if let Some(&force) = forces.get(&coordinate) {
                    *to.at_mut(i, force) = entry.clone();
                }
                for (k, (on, harmonic)) in events.harmonics.iter().enumerate() {
                    if *on == coordinate {
                        *to.at_mut(i, harmonics + 2 * k) = entry * exactly(harmonic.amplitude);
                    }
                }
            }
        }
        for &force in forces.values() {
            *motion.at_mut(force, force + 1) = BigRational::one();
        }
        let mut phases = Vec::new();
        for (k, (_, harmonic)) in events.harmonics.iter().enumerate() {
            let (sin, cos) = (harmonics + 2 * k, harmonics + 2 * k + 1);
            *motion.at_mut(sin, cos) = exactly(harmonic.frequency);
            *motion.at_mut(cos, sin) = -exactly(harmonic.frequency);
            phases.push((sin, harmonic.phase));
        }

        let mut jumps: BTreeMap<BigRational, Vec<(usize, BigRational)>> = BTreeMap::new();
        for event in events.changes {
            let here = jumps.entry(event.time).or_default();
            match event.change {
                Change::Force(force) => here.push((forces[&event.coordinate], force)),
                Change::Slope(slope) => here.push((forces[&event.coordinate] + 1, slope)),
                Change::Impulse(_) if form.gives_way[event.coordinate] => {
                    return Err(ReferenceError::ImpulseGivesWay { load: event.load });
                }
                Change::Impulse(impulse) => {
                    let column = r + event.coordinate;
                    let entries = (0..r).map(|i| (i, form.motion.at(i, column) * &impulse));
                    here.extend(entries.filter(|(_, jump)| !jump.is_zero()));
                }
            }
        }
        let mut start = form.start(problem.initial_displacement(), problem.initial_velocity());
        start.resize(order, BigRational::zero());
        let scale = scale(&motion, r, forces.values().copied(), harmonics);
        let velocity = output.times(&motion);
        Ok(DrivenForm {
            motion: RationalMatrix::from_fn(order, order, |i, j| {
                let entry = motion.at(i, j);
                match entry.is_zero() {
                    true => BigRational::zero(),
                    false => shifted(entry, scale[j] - scale[i]),
                }
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

    /// The first of the two states of each harmonic force.
    pub(super) fn phased(&self) -> impl Iterator<Item = usize> {
        self.phases.iter().map(|(sin, _)| *sin)
    }

    /// The unscaled state at t = 0, before what happens then.
    pub(super) fn start(&self, bits: u64) -> Vec<Ball> {
        let mut start: Vec<Ball> = self
            .start
            .iter()
            .map(|value| Ball::rational(value, bits))
            .collect();
        for &(sin, phase) in &self.phases {
            let phase = Ball::rational(&exactly(phase), bits);
            (start[sin], start[sin + 1]) = phase.sin_cos();
        }
        start
    }
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
    motion: &RationalMatrix,
    states: usize,
    forces: impl Iterator<Item = usize>,
    harmonics: usize,
) -> Vec<i64> {
    let mut scale = vec![0i64; motion.nrows()];
    let entries: Vec<(usize, usize, f64)> = motion
        .nonzeros()
        .map(|(i, j, entry)| (i, j, log2(entry)))
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
