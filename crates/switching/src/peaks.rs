//! The highest and lowest values of a motion, between the instants too.

use std::collections::HashMap;
use std::rc::Rc;

use eigentone_digits::Real;
use eigentone_modes::ElementKind;
use eigentone_response::{Discontinuity, Peaks, Reached};

use crate::configuration::Configuration;
use crate::outputs::Value;
use crate::root::bernstein;
use crate::rows::Row;
use crate::series::Series;

/// Values as near as this are not distinguished from each other.
const ALIKE: f64 = 1e-12;

/// The highest and the lowest values of a motion with switches, at any time, and where they jump. Values are estimates good to
/// about 12 digits, times to half of them.
#[derive(Clone, Debug, PartialEq)]
pub struct SwitchedPeaks {
    /// Of displacement, velocity and acceleration.
    coordinates: [Vec<Peaks>; 3],
    outputs: Vec<Peaks>,
    /// Of springs and of dampers.
    elements: [Vec<Peaks>; 2],
    switches: Vec<Peaks>,
}

impl SwitchedPeaks {
    /// Of the displacement of a coordinate, in m.
    ///
    /// # Panics
    /// If there is no such coordinate, as below.
    pub fn displacement(&self, coordinate: usize) -> &Peaks {
        &self.coordinates[0][coordinate]
    }

    /// Of the velocity of a coordinate, in m/s. Of velocities before and after an impact both count.
    pub fn velocity(&self, coordinate: usize) -> &Peaks {
        &self.coordinates[1][coordinate]
    }

    /// Of the acceleration of a coordinate, in m/s², apart from the impulses of impacts.
    pub fn acceleration(&self, coordinate: usize) -> &Peaks {
        &self.coordinates[2][coordinate]
    }

    /// Of a combination that the problem asks for, by its place.
    pub fn output(&self, index: usize) -> &Peaks {
        &self.outputs[index]
    }

    /// Of the force in a spring or damper, in N, by its place in [`System::elements`](eigentone_modes::System::elements); `None`
    /// where forces [were not asked for](eigentone_response::Problem::with_forces).
    pub fn force(&self, kind: ElementKind, index: usize) -> Option<&Peaks> {
        self.elements[usize::from(kind == ElementKind::Damper)].get(index)
    }

    /// Of the force of a switch on b along its stretch, in N: negative where it acts against a positive rate or
    /// stretch. Impulses of impacts have none.
    pub fn switch(&self, switch: usize) -> &Peaks {
        &self.switches[switch]
    }
}

/// The same on the way.
pub(crate) struct Followed<T> {
    values: Vec<Value<T>>,
    /// How many values are displacements and the like, outputs, springs, dampers.
    counts: [usize; 4],
    /// The rows of the values and of the switches' forces, by the address of a configuration, which is kept with them.
    rows: HashMap<usize, Kept<T>>,
    found: Vec<Option<Peaks>>,
    /// At the end of the last step.
    last: Vec<f64>,
}

type Kept<T> = (Rc<Configuration<T>>, Rc<Vec<Row<T>>>);

impl<T: Real> Followed<T> {
    /// Of three values for each of so many coordinates, then of outputs, springs and dampers, and of so many switches.
    pub(crate) fn new(values: Vec<Value<T>>, counts: [usize; 4], switches: usize) -> Followed<T> {
        Followed {
            found: vec![None; values.len() + switches],
            values,
            counts,
            rows: HashMap::new(),
            last: Vec::new(),
        }
    }

    fn rows(&mut self, current: &Rc<Configuration<T>>) -> Rc<Vec<Row<T>>> {
        let address = Rc::as_ptr(current) as usize;
        let values = &self.values;
        let make = || {
            let none = || Row::of(vec![T::ZERO; current.rows.len()], 0.0);
            let own = values.iter().map(|value| value.in_configuration(current));
            let forces = current.forces.iter();
            let forces = forces.map(|force| force.clone().unwrap_or_else(none));
            (current.clone(), Rc::new(own.chain(forces).collect()))
        };
        self.rows.entry(address).or_insert_with(make).1.clone()
    }

    /// Takes what a step from `now` to θ = `end` reaches; `off` is what is not known of a function of the state at its start.
    pub(crate) fn step(
        &mut self,
        current: &Rc<Configuration<T>>,
        series: &Series<T>,
        now: f64,
        end: f64,
        off: &dyn Fn(&Row<T>) -> f64,
    ) {
        let rows = self.rows(current);
        let begins = self.last.is_empty();
        self.last.resize(rows.len(), 0.0);
        let parts = rows.iter().zip(&mut self.found).zip(&mut self.last);
        for ((row, found), last) in parts {
            let (mut coefficients, mut sizes) = series.of_row_rounded(row);
            let mut power = 1.0;
            for (entry, size) in coefficients.iter_mut().zip(&mut sizes) {
                *entry *= power;
                *size *= power;
                power *= end;
            }
            let size: f64 = sizes.iter().sum();
            // What is left of series where a function of them is 0.
            let nothing = 16.0 * f64::EPSILON * sizes[0];
            if coefficients[0].abs() <= nothing {
                coefficients[0] = 0.0;
            }
            let bound = off(row) + f64::EPSILON * 4.0 * size;
            let reached = |value: f64, theta: f64| Reached {
                value,
                time: now + theta * current.step,
                bound: bound + ALIKE * value.abs(),
            };
            let start = coefficients[0];
            let peaks = found.get_or_insert_with(|| Peaks {
                highest: reached(start, 0.0),
                lowest: reached(start, 0.0),
                jumps: Vec::new(),
            });
            if !begins {
                note_jump(peaks, now, [*last, start], nothing + bound);
            }
            let rises: f64 = coefficients[1..].iter().map(|entry| entry.abs()).sum();
            *last = coefficients.iter().sum();
            let (high, low) = (peaks.highest.value, peaks.lowest.value);
            if start + rises <= high && start - rises >= low {
                continue;
            }
            let mut points = bernstein(&coefficients);
            for sign in [1.0, -1.0] {
                let best = if sign > 0.0 {
                    &mut peaks.highest
                } else {
                    &mut peaks.lowest
                };
                let margin = ALIKE * best.value.abs() + nothing;
                let least = sign * best.value + margin;
                if let Some((value, theta)) = highest(&points, least, 0.0, 1.0) {
                    *best = reached(sign * value, theta * end);
                }
                points.iter_mut().for_each(|point| *point = -*point);
            }
        }
    }

    pub(crate) fn total(self) -> Option<SwitchedPeaks> {
        let mut all = self
            .found
            .into_iter()
            .collect::<Option<Vec<Peaks>>>()?
            .into_iter();
        let [motions, outputs, springs, dampers] = self.counts;
        let mut take = |count: usize| all.by_ref().take(count).collect::<Vec<Peaks>>();
        Some(SwitchedPeaks {
            coordinates: [0; 3].map(|_| take(motions / 3)),
            outputs: take(outputs),
            elements: [springs, dampers].map(&mut take),
            switches: take(usize::MAX),
        })
    }
}

fn note_jump(peaks: &mut Peaks, time: f64, values: [f64; 2], nothing: f64) {
    /// So many jumps of one quantity are noted, as without switches.
    const MOST: usize = 1000;
    /// A part of the range that does not show.
    const INVISIBLE: f64 = 1e-9;
    let size = values
        .iter()
        .fold(0.0f64, |size, value| size.max(value.abs()));
    let size = size.max(peaks.highest.value).max(-peaks.lowest.value);
    if (values[1] - values[0]).abs() > INVISIBLE * size + nothing && peaks.jumps.len() < MOST {
        peaks.jumps.push(Discontinuity { time, values });
    }
}

/// The largest value of a polynomial on an interval, above `least`, and where: parts whose coefficients of Bernstein's basis are
/// all smaller are left out.
fn highest(points: &[f64], least: f64, from: f64, to: f64) -> Option<(f64, f64)> {
    let top = points.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if top <= least {
        return None;
    }
    let (first, last) = (points[0], points[points.len() - 1]);
    let mut best = None;
    let mut least = least;
    for (value, theta) in [(first, from), (last, to)] {
        if value > least {
            best = Some((value, theta));
            least = value;
        }
    }
    let close = top - least <= 0.1 * ALIKE * top.abs();
    if close || to - from < 1e-12 {
        return best;
    }
    let middle = 0.5 * (from + to);
    let (left, right) = crate::root::divided(points, 0.5);
    for (part, from, to) in [(left, from, middle), (right, middle, to)] {
        let above = best.map_or(least, |(value, _)| value + 0.1 * ALIKE * value.abs());
        best = highest(&part, above, from, to).or(best);
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_highest_of_two_hills_is_found() {
        // 1 − 16 (θ − 1/4)² (θ − 3/4)² − θ/100
        let coefficients = [1.0 - 0.5625, 6.0 - 0.01, -22.0, 32.0, -16.0];
        let (value, theta) = highest(&bernstein(&coefficients), 0.0, 0.0, 1.0).expect("a hill");
        let at = |theta: f64| {
            coefficients
                .iter()
                .rev()
                .fold(0.0, |sum, entry| sum * theta + entry)
        };
        assert!((at(theta) - value).abs() < 1e-15);
        let samples = (0..=10_000).map(|k| at(f64::from(k) / 1e4));
        assert!(samples.fold(0.0, f64::max) <= value + 1e-12);
        assert!((theta - 0.25).abs() < 0.01, "{theta}");
    }
}
