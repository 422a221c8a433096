//! Where the energy of a motion goes.

use eigentone_digits::Real;

use crate::configuration::{Configuration, Place};
use crate::rows::Row;
use crate::series::Series;

/// The energy that dampers and switches have taken up to the end of a motion, in J; infinite of what damps a stretch that jumps.
#[derive(Clone, Debug, PartialEq)]
pub struct Losses {
    /// In each damper of the system, as [`elements`](eigentone_modes::System::elements) lists them.
    pub dampers: Vec<f64>,
    /// In each switch: by friction, by impacts, and by what a damper or a stop takes, with what the
    /// spring of a stop holds at the end more than at the start.
    pub switches: Vec<f64>,
}

/// The same on the way.
pub(crate) struct Taken<T> {
    /// Coefficient, stretch and rate of each damper.
    dampers: Vec<(T, [Row<T>; 2])>,
    by_dampers: Vec<T>,
    by_switches: Vec<T>,
    /// Sums of the sizes of what each switch took and gave back.
    passed: Vec<f64>,
    /// Which of the dampers and of the switches have taken energy without limit.
    without_limit: [Vec<bool>; 2],
    /// 1/k.
    inverses: Vec<T>,
}

impl<T: Real> Taken<T> {
    pub(crate) fn new(dampers: Vec<(T, [Row<T>; 2])>, switches: usize) -> Taken<T> {
        Taken {
            without_limit: [vec![false; dampers.len()], vec![false; switches]],
            by_dampers: vec![T::ZERO; dampers.len()],
            dampers,
            by_switches: vec![T::ZERO; switches],
            passed: vec![0.0; switches],
            inverses: Vec::new(),
        }
    }

    /// Adds what a step takes up to θ = end.
    pub(crate) fn step(
        &mut self,
        current: &Configuration<T>,
        places: &[Place<T>],
        series: &Series<T>,
        end: T,
    ) {
        let seconds = T::from(current.step);
        for ((coefficient, [_, rate]), sum) in self.dampers.iter().zip(&mut self.by_dampers) {
            let rate = powers(series, rate, end);
            *sum = *sum + *coefficient * seconds * integral(&mut self.inverses, &rate, &rate, end);
        }
        let switches = places.iter().zip(&current.forces);
        for (switch, (place, force)) in switches.enumerate() {
            if let Some(force) = force {
                let rate = powers(series, &place.rate, end);
                let force = powers(series, force, end);
                let brought = seconds * integral(&mut self.inverses, &force, &rate, end);
                self.impact(switch, -brought);
            }
        }
    }

    /// Adds what a switch takes, at an impact or over a time.
    pub(crate) fn impact(&mut self, switch: usize, energy: T) {
        self.passed[switch] += energy.to_f64().abs();
        self.by_switches[switch] = self.by_switches[switch] + energy;
    }

    /// A switch damps a stretch that jumps.
    pub(crate) fn without_limit(&mut self, switch: usize) {
        self.without_limit[1][switch] = true;
    }

    /// The dampers damp stretches of which these jump.
    pub(crate) fn jump(&mut self, jumps: impl Fn(&Row<T>) -> bool) {
        let dampers = self.dampers.iter().zip(&mut self.without_limit[0]);
        for ((coefficient, [stretch, _]), without_limit) in dampers {
            *without_limit |= !coefficient.is_zero() && jumps(stretch);
        }
    }

    pub(crate) fn total(&self) -> Losses {
        /// What is less than this part of what passed is rounding.
        const HIDDEN: f64 = 1e-20;
        let taken = self.by_switches.iter().zip(&self.passed);
        let taken = taken.map(
            |(energy, passed)| match energy.to_f64().abs() <= HIDDEN * passed {
                true => T::ZERO,
                false => *energy,
            },
        );
        let taken: Vec<T> = taken.collect();
        let rounded = |all: &[T], without_limit: &[bool]| {
            let each = all.iter().zip(without_limit);
            each.map(|(energy, without_limit)| match without_limit {
                true => f64::INFINITY,
                false => energy.to_f64(),
            })
            .collect()
        };
        Losses {
            dampers: rounded(&self.by_dampers, &self.without_limit[0]),
            switches: rounded(&taken, &self.without_limit[1]),
        }
    }
}

/// The terms of a function of ζ at θ = end.
fn powers<T: Real>(series: &Series<T>, row: &Row<T>, end: T) -> Vec<T> {
    let mut power = T::ONE;
    let mut terms = series.of_row(row);
    for term in &mut terms {
        *term = *term * power;
        power = power * end;
    }
    while terms.last().is_some_and(|term| term.is_zero()) {
        terms.pop();
    }
    terms
}

/// ∫₀ᵉⁿᵈ ab dθ.
fn integral<T: Real>(inverses: &mut Vec<T>, a: &[T], b: &[T], end: T) -> T {
    for k in inverses.len()..a.len() + b.len() {
        inverses.push(T::ONE / T::from((k + 1) as f64));
    }
    let mut sum = T::ZERO;
    for (i, a) in a.iter().enumerate() {
        let own = b.iter().zip(&inverses[i..]);
        let own = own.fold(T::ZERO, |sum, (b, inverse)| sum + *b * *inverse);
        sum = sum + *a * own;
    }
    sum * end
}
