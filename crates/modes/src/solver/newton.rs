//! Roots that doubles leave in doubt, by Newton's method in double-double.

use eigentone_digits::ComplexDoubleDouble;
use num_complex::Complex;

use crate::quality::bordered::Resolved;
use crate::system::System;

use super::roots::{Root, normalised};

/// Up to so many coordinates, Newton's method in double-double is quick beside the eigenproblem.
pub(crate) const FEW: usize = 16;

/// The simple root within `reach` that Newton's method leads to, with its shapes, from the elements;
/// `None` where it does not converge or B there is singular to 27 digits. Its last step left errors
/// below 1e-12 squared, times the condition of B, which is below 1e27: more than a double holds,
/// but for real parts that are all but nothing.
pub(crate) fn resolved(system: &System, root: &Root, reach: f64) -> Option<Root> {
    const BEYOND: f64 = 1e-22;
    let shape = normalised(&root.shape);
    let resolved = Resolved::of(system, root.value, &shape)?;
    let plain = |z: &ComplexDoubleDouble| Complex::new(z.re.to_f64(), z.im.to_f64());
    let value = plain(&resolved.lambda);
    if (value - root.value).norm() > reach {
        return None;
    }
    let left = || resolved.left().iter().map(plain).collect();
    let part = |part: f64| f64::EPSILON * part.abs() + BEYOND * value.norm();
    Some(Root {
        value,
        left: root.left.is_some().then(left),
        shape: resolved.x.iter().map(plain).collect(),
        error: Some((part(value.re).hypot(part(value.im)), part(value.re))),
        ..root.clone()
    })
}
