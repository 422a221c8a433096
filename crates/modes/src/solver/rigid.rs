//! The roots λ = 0 of systems that nothing holds in place.

use num_complex::Complex;

use crate::structure::Structure;
use crate::system::System;

use super::roots::Root;

/// `count` roots at 0 with the given shapes, of which every one is a motion that no spring
/// resists. If there are more roots than shapes, the root is defective: some shape keeps the
/// velocity that it is given, since no damper holds it either.
pub(crate) fn roots(shapes: Vec<Vec<Complex<f64>>>, count: usize) -> Vec<Root> {
    let defective = count > shapes.len();
    let root = |shape, count| Root {
        count,
        defective,
        error: Some((0.0, 0.0)),
        ..Root::simple(Complex::ZERO, shape)
    };
    let listed = if defective { 1 } else { count };
    let each = if defective { count } else { 1 };
    shapes
        .into_iter()
        .take(listed)
        .map(|shape| root(shape, each))
        .collect()
}

/// The shapes of the parts that no spring ties to the ground: each moves as a whole.
pub(crate) fn shapes(system: &System, structure: &Structure) -> Vec<Vec<Complex<f64>>> {
    let indicator = |part: &Vec<usize>| {
        let mut shape = vec![Complex::ZERO; system.len()];
        for &i in part {
            shape[i] = Complex::ONE;
        }
        shape
    };
    structure.spring_floating().iter().map(indicator).collect()
}
