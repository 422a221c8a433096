//! The state at all instants asked for, from event to event.

use std::collections::{BTreeMap, BTreeSet};

use num_bigint::{BigInt, BigUint};
use num_rational::BigRational;
use num_traits::Zero;

use super::ball::Ball;
use super::driven_form::DrivenForm;
use super::error::ReferenceError;
use super::exponential::{exponential, growth, halvings};
use super::fixed_matrix::FixedMatrix;
use super::pi_polynomial::PiMatrix;

/// All coordinates at one instant.
#[derive(Clone, Debug)]
pub(super) struct Moment {
    pub(super) displacement: Vec<Ball>,
    pub(super) velocity: Vec<Ball>,
    /// log₂ of the largest displacement and velocity that could come from states as large as
    /// any until then: it distinguishes an exact 0 from a motion.
    pub(super) reach: [f64; 2],
}

/// What of a motion is wanted.
pub(super) struct March {
    form: DrivenForm,
    /// The instants asked for, ascending.
    times: Vec<BigRational>,
    /// They and those of events, ascending, with the seconds since the one before.
    stops: Vec<(BigRational, BigRational)>,
    gaps: BTreeSet<BigRational>,
}

/// Numbers of so many bits cost little more than their allocation.
const FEW_WORDS: f64 = 768.0;

impl March {
    pub(super) fn new(form: DrivenForm, times: Vec<BigRational>) -> March {
        let mut stops: BTreeSet<&BigRational> = times.iter().collect();
        let last = times.last();
        stops.extend(form.jumps.keys().filter(|time| Some(*time) <= last));
        let mut before = BigRational::zero();
        let stops: Vec<(BigRational, BigRational)> = stops
            .into_iter()
            .map(|time| {
                let gap = time - std::mem::replace(&mut before, time.clone());
                (time.clone(), gap)
            })
            .collect();
        let gaps = stops
            .iter()
            .map(|(_, gap)| gap)
            .filter(|gap| !gap.is_zero());
        let gaps = gaps.cloned().collect();
        March {
            form,
            times,
            stops,
            gaps,
        }
    }

    /// log₂ of the longest stretch in units of the fastest motion.
    pub(super) fn doublings(&self) -> u64 {
        let last = self.times.last().filter(|time| !time.is_zero());
        last.map_or(0, |last| halvings(&self.form.motion, last))
    }

    /// About how many multiplications of a few words one attempt with numbers of `bits` bits takes. Long ones cost as much as
    /// many of those (Karatsuba and Ofman 1962).
    pub(super) fn work(&self, bits: u64) -> f64 {
        let order = self.form.motion.nrows() as f64;
        let terms = bits as f64 / 5.0;
        let nonzeros = self.form.motion.nonzeros().count() as f64;
        let exponential = |doublings: f64| doublings * order.powi(3) + terms * nonzeros * order;
        let growth = 2.0 * exponential(self.doublings() as f64);
        let gaps = self
            .gaps
            .iter()
            .map(|gap| exponential(halvings(&self.form.motion, gap) as f64));
        let count = growth + gaps.sum::<f64>() + self.stops.len() as f64 * order * order;
        count * (bits as f64 / FEW_WORDS).powf(1.585).max(1.0)
    }

    /// The motion at the instants asked for, computed with `bits` bits; `None` if they are too few.
    ///
    /// # Errors
    /// [`ReferenceError::TooFast`].
    ///
    /// With ẑ the computed state, e its error and E = e^(A t) for one gap, known as Ê, each step
    /// adds (E − Ê) ẑ and a rounding to E e. All that is added at some time is carried to any later
    /// one by e^(A τ), of which [`growth`] bounds all entries: it suffices to add up what is added.
    pub(super) fn run(&self, bits: u64) -> Result<Option<Vec<Moment>>, ReferenceError> {
        let form = &self.form;
        let start = form.start(bits + 64);
        let unit = self.unit(&start) - bits as i64;
        let horizon = self.times.last().cloned().unwrap_or_default();
        let Some(carried) = growth(&form.motion, &horizon, bits)? else {
            return Ok(None);
        };
        let mut powers: BTreeMap<&BigRational, FixedMatrix> = BTreeMap::new();
        for gap in &self.gaps {
            let Some(power) = exponential(&form.motion, gap, bits)? else {
                return Ok(None);
            };
            powers.insert(gap, power);
        }
        let outputs = [&form.displacement, &form.velocity]
            .map(|matrix| Output::of(matrix, &form.scale, bits));

        // Errors added before the last step, in any component, and those since, in each.
        let mut added = BigUint::zero();
        let component =
            |(component, scale): (&Ball, &i64)| component.clone().scaled(-scale).in_units(unit);
        let (mut state, mut fresh): (Vec<BigInt>, Vec<BigUint>) =
            start.iter().zip(&form.scale).map(component).unzip();
        let mut moments = Vec::with_capacity(self.times.len());
        let mut largest = 0;
        for (time, gap) in &self.stops {
            if let Some(power) = powers.get(gap) {
                added += fresh.iter().max().cloned().unwrap_or_default();
                added += power.advance(&mut state);
                fresh.fill(BigUint::zero());
            }
            for (component, jump) in form.jumps.get(time).into_iter().flatten() {
                let jump = jump.shifted(-form.scale[*component] - unit);
                let (jump, off) = match jump.rational() {
                    Some(jump) => (
                        jump.floor().to_integer(),
                        u8::from(!jump.is_integer()).into(),
                    ),
                    None => jump.ball(bits + 64).in_units(0),
                };
                state[*component] += jump;
                fresh[*component] += off;
            }
            let longest = state.iter().map(BigInt::bits).max().unwrap_or(0);
            largest = longest.max(largest);
            if self.times.get(moments.len()) == Some(time) {
                let component = |i: usize| {
                    let radius =
                        ((&carried[i] * &added) >> bits) + u8::from(!added.is_zero()) + &fresh[i];
                    Ball::new(state[i].clone(), radius, unit + form.scale[i], bits + 64)
                };
                let state: Vec<Ball> = (0..state.len()).map(component).collect();
                let [displacement, velocity] = [0, 1].map(|which| outputs[which].apply(&state));
                moments.push(Moment {
                    displacement,
                    velocity,
                    reach: [0, 1]
                        .map(|which| outputs[which].reach + (largest as i64 + unit) as f64),
                });
            }
        }
        Ok(Some(moments))
    }

    /// The power of two above the largest component that the state starts or jumps with.
    fn unit(&self, start: &[Ball]) -> i64 {
        let scale = &self.form.scale;
        let started = start.iter().map(Ball::log2).zip(scale);
        let jumps = self.form.jumps.values().flatten();
        let jumped = jumps.map(|(component, jump)| (jump.log2(), &scale[*component]));
        let sizes = started
            .chain(jumped)
            .map(|(log, scale)| log - *scale as f64);
        let most = sizes.fold(f64::NEG_INFINITY, f64::max);
        if most.is_finite() {
            most.ceil() as i64
        } else {
            0
        }
    }
}

/// A matrix of balls by its rows, without its zeros.
struct Output {
    rows: Vec<Vec<(usize, Ball)>>,
    /// log₂ of its largest entry, in the scaled states.
    reach: f64,
}

impl Output {
    fn of(matrix: &PiMatrix, scale: &[i64], bits: u64) -> Output {
        let mut rows = vec![Vec::new(); matrix.nrows()];
        let mut reach = f64::NEG_INFINITY;
        for (i, j, entry) in matrix.nonzeros() {
            reach = reach.max(entry.log2() + scale[j] as f64);
            rows[i].push((j, entry.ball(bits + 64)));
        }
        Output { rows, reach }
    }

    fn apply(&self, state: &[Ball]) -> Vec<Ball> {
        let row = |row: &Vec<(usize, Ball)>| {
            let terms = row.iter().map(|(j, entry)| entry * &state[*j]);
            terms.fold(Ball::zero(), |sum, term| sum + term)
        };
        self.rows.iter().map(row).collect()
    }
}
