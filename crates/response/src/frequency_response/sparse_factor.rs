//! Values beyond the sizes of dense matrices: one sparse factor for each frequency, with estimated bounds.

use eigentone_digits::ComplexDoubleDouble;
use eigentone_modes::SparseDynamicStiffness;
use num_complex::Complex;

use super::dynamic_stiffness::{Frequency, Part};
use super::enclosure::Value;
use super::modal_functions::turn;
use super::ports::{Push, Reading};

/// By input, the values of all readings at a frequency in rad/s, and estimates of how far they may be off; `None` where there is
/// no factor.
pub(super) fn values(
    stiffness: &SparseDynamicStiffness,
    coordinates: usize,
    columns: &[(&[Push], &[Reading])],
    frequency: f64,
) -> Option<Vec<Vec<Sum>>> {
    let right = columns
        .iter()
        .map(|(pushes, _)| forces(coordinates, pushes, |part| value(&part, frequency)));
    let right: Vec<Vec<Complex<f64>>> = right.collect();
    let solved = stiffness.solve(frequency, &right)?;
    let all = columns.iter().zip(&solved);
    let each = all.map(|((_, readings), (x, errors))| {
        let sums = readings.iter();
        let sums = sums.map(|reading| sum(reading, frequency, x, errors.as_deref()));
        sums.collect()
    });
    Some(each.collect())
}

/// A value, and an estimate of how far it may be off.
pub(super) type Sum = (Complex<f64>, Option<f64>);

/// The value of one reading and its steepness, by estimates; `None` where there is no factor or refinement does not settle.
pub(super) fn look(
    stiffness: &SparseDynamicStiffness,
    coordinates: usize,
    (pushes, reading): (&[Push], &Reading),
    frequency: Frequency,
) -> Option<Value> {
    let (middle, rounded) = (frequency.middle, frequency.middle.to_f64());
    let right = forces(coordinates, pushes, |part| value(&part, rounded));
    let slope = forces(coordinates, pushes, |part| slope(part, rounded));
    let [(x, errors), (rates, off)] = stiffness.solve_with_slope(middle, &right, &slope)?;
    // (a x)′ = a′x + a x′.
    let derivative = Reading {
        of: reading
            .of
            .iter()
            .filter_map(|(k, part)| Some((*k, part.derivative()?)))
            .collect(),
        more: reading
            .more
            .iter()
            .filter_map(|part| part.derivative())
            .collect(),
    };
    let without_more = Reading {
        of: reading.of.clone(),
        more: Vec::new(),
    };
    let (value, bound) = sum(reading, rounded, &x, errors.as_deref());
    let (first, first_off) = sum(&derivative, rounded, &x, errors.as_deref());
    let (second, second_off) = sum(&without_more, rounded, &rates, off.as_deref());
    let (rate, off) = (first + second, first_off? + second_off?);
    let (size, bound) = (value.norm(), bound?);
    let ratio = (rate / value).re;
    let ratio_off = (off + rate.norm() * (bound / size + 4.0 * f64::EPSILON)) / size;
    let bound = bound + rate.norm() * frequency.radius;
    (value.is_finite() && bound.is_finite()).then_some(Value {
        value,
        bound,
        steepness: (ratio.is_finite() && ratio_off.is_finite()).then_some((ratio, ratio_off)),
    })
}

fn forces(
    coordinates: usize,
    pushes: &[Push],
    size: impl Fn(Part) -> Complex<f64>,
) -> Vec<Complex<f64>> {
    let mut right = vec![Complex::ZERO; coordinates];
    for push in pushes {
        right[push.coordinate] += size(push.part);
    }
    right
}

fn value(part: &Part, frequency: f64) -> Complex<f64> {
    let (power, factor) = part.factor();
    turn(frequency, power) * factor
}

fn slope(part: Part, frequency: f64) -> Complex<f64> {
    part.derivative()
        .map_or(Complex::ZERO, |part| value(&part, frequency))
}

fn sum(
    reading: &Reading,
    frequency: f64,
    x: &[ComplexDoubleDouble],
    errors: Option<&[f64]>,
) -> Sum {
    let mut sum = ComplexDoubleDouble::ZERO;
    let (mut off, mut size) = (0.0, 0.0);
    let wide = |value: Complex<f64>| ComplexDoubleDouble::new(value.re, value.im);
    for (coordinate, part) in &reading.of {
        let factor = value(part, frequency);
        sum += wide(factor) * x[*coordinate];
        off += factor.norm() * errors.map_or(0.0, |errors| errors[*coordinate]);
        size += factor.norm() * x[*coordinate].norm();
    }
    for part in &reading.more {
        let more = value(part, frequency);
        sum += wide(more);
        size += more.norm();
    }
    let value = Complex::new(sum.re.to_f64(), sum.im.to_f64());
    let rounding = 2.0 * f64::EPSILON * size;
    (value, errors.map(|_| off + rounding))
}
