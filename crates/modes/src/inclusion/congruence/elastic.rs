//! The roots of an undamped system, from the squares of its frequencies.

use eigentone_digits::DoubleDouble;
use num_complex::Complex;

use super::refine::Goal;
use super::squares::{Squares, squares};
use crate::inclusion::gram::UPWARD;
use crate::inclusion::quadratic::Damped;
use crate::modes::Mode;
use crate::system::System;

/// Proves a bound for every nonzero root of an undamped system with M and K symmetric, given all its modes
/// approximately: iω, or both of ±√−ω² where K makes the square negative. `None` where no proof was reached.
pub(crate) fn certify(system: &System, modes: &[Mode], tolerance: f64) -> Option<Vec<Damped>> {
    let structure = system.structure();
    // Of the two real roots of a negative square one.
    let elastic = || {
        let one = |mode: &&Mode| {
            let value = mode.eigenvalue().value;
            value.im != 0.0 || value.re > 0.0
        };
        modes.iter().filter(one)
    };
    if !structure.is_undamped() || elastic().any(|mode| mode.roots() > 1) {
        return None;
    }
    let shapes = elastic().map(|mode| mode.shape().iter().map(|x| x.re).collect());
    let goal = Goal {
        spread: 1e-24,
        where_apart: 1e-20,
    };
    let found = squares(system, shapes.collect(), goal, tolerance)?;
    Some(elastic_modes(&found, structure.is_passive()))
}

/// λ = ±√−σ with bounds; those that are not separated get one value.
fn elastic_modes(squares: &Squares, are_positive: bool) -> Vec<Damped> {
    let mut found = Vec::with_capacity(squares.values.len());
    for group in squares.groups() {
        let middle = squares.values[(group.start + group.end) / 2];
        let size = middle.abs().sqrt().to_f64();
        let bound = group.clone().map(|i| {
            let root = squares.values[i].abs().sqrt();
            let rounding = (root - DoubleDouble::from(size)).to_f64().abs();
            let spread = squares.reach[i] / squares.values[i].to_f64().abs();
            // √(1 + t) is within this of 1 for |t| ≤ spread. More is added for the root.
            let relative = spread / (1.0 + (1.0 - spread.min(1.0)).sqrt()) + 2f64.powi(-100);
            (rounding + relative * root.to_f64()) * UPWARD
        });
        let bound = bound.fold(f64::from_bits(1), f64::max);
        // Of a square that is not distinguished from 0 the roots may be imaginary or real, and no larger than this.
        let largest = group
            .clone()
            .map(|i| squares.values[i].to_f64().abs() + squares.reach[i]);
        let largest = largest.fold(0.0, f64::max).sqrt() * UPWARD;
        let is_open = group
            .clone()
            .any(|i| squares.values[i].to_f64().abs() <= squares.reach[i] * UPWARD);
        let roots = if is_open {
            let real_bound = if are_positive { 0.0 } else { largest };
            vec![(
                Complex::new(0.0, size),
                (size + largest) * UPWARD,
                real_bound,
            )]
        } else if middle > DoubleDouble::ZERO {
            vec![(Complex::new(0.0, size), bound, 0.0)]
        } else {
            let real = |value: f64| (Complex::from(value), bound, bound);
            vec![real(-size), real(size)]
        };
        for (value, bound, real_bound) in roots {
            found.extend(group.clone().map(|i| Damped {
                value,
                bound,
                real_bound,
                multiplicity: group.len(),
                coincide: false,
                roots: 1,
                shape: squares.shape(i),
            }));
        }
    }
    found
}
