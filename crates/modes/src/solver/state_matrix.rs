//! General damping: the standard eigenproblem of the balanced state matrix.

use faer::MatRef;
use num_complex::Complex;

use crate::first_order::FirstOrder;
use crate::linear::balance;
use crate::modes::Modes;
use crate::quality::pencil::products;
use crate::system::System;

use super::improvement::refine;
use super::mode_solver::{ModeSolver, ModesError, admit};
use super::rigid;
use super::roots::{Root, collect};
use crate::linear::eigenpairs::{eigenpairs, is_direction};

/// Eigenvalues of the state matrix A of z′ = A z, balanced, by the QR algorithm; each simple one is
/// then improved by the Rayleigh functional of its shapes (Lancaster 1966, §5.5). For every system
/// with a [first-order form](crate::FirstOrder).
#[derive(Clone, Copy, Debug)]
pub struct StateMatrix;

impl ModeSolver for StateMatrix {
    fn name(&self) -> &'static str {
        "state matrix"
    }

    fn refuses(&self, system: &System) -> Option<String> {
        if FirstOrder::is_certain(system) {
            return None;
        }
        FirstOrder::of(system).err().map(|error| error.to_string())
    }

    fn reason(&self) -> &'static str {
        "generally damped: eigenvalues of the 2n states"
    }

    fn solve(&self, system: &System) -> Result<Modes, ModesError> {
        let structure = system.structure();
        admit(self, system)?;
        let mut found = unrefined(system)?;
        let mut roots = Vec::new();
        if let Some(zeros) = structure.zero_roots().filter(|zeros| *zeros > 0) {
            let removed = rigid::removed(&mut found, zeros);
            let mut shapes = rigid::shapes(system);
            if shapes.is_empty() {
                shapes = removed.into_iter().map(|root| root.shape).collect();
                shapes.truncate(1);
            }
            roots.extend(rigid::roots(shapes, zeros));
        }
        roots.extend(refine(system, found));
        Ok(collect(self, system, roots))
    }
}

/// The eigenvalues, conjugates included, as the QR algorithm leaves them.
pub(super) fn unrefined(system: &System) -> Result<Vec<Root>, ModesError> {
    let form = FirstOrder::of(system)?;
    let left = (!system.structure().is_symmetric()).then(|| form.b());
    eigen(&StateMatrix, form.a(), form.x(), &|_, z| z, left)
}

/// The amplitudes of a basis of shapes that belong to a root and the vector z of its state.
pub(crate) type Amplitudes<'a> = dyn Fn(Complex<f64>, Vec<Complex<f64>>) -> Vec<Complex<f64>> + 'a;

/// All eigenvalues of A (N × N), conjugates included, with the shapes that a basis (n × any) has
/// with the amplitudes of each; with B, also the left shapes y = B*w.
pub(crate) fn eigen(
    solver: &dyn ModeSolver,
    a: MatRef<'_, f64>,
    basis: MatRef<'_, f64>,
    amplitudes: &Amplitudes<'_>,
    b: Option<MatRef<'_, f64>>,
) -> Result<Vec<Root>, ModesError> {
    let method = solver.name();
    let symmetric = b.is_none();
    let balanced = balance(a);
    if !balanced.matrix.norm_max().is_finite() {
        return Err(ModesError::OutOfRange { method });
    }
    let found = eigenpairs(&balanced, !symmetric).ok_or(ModesError::NoConvergence { method })?;
    // The states in their own units.
    let unbalanced = |mut vector: Vec<Complex<f64>>, inverse: bool| {
        for (entry, scale) in vector.iter_mut().zip(&balanced.scale) {
            *entry *= if inverse { 1.0 / scale } else { *scale };
        }
        of_size_one(vector)
    };
    let values = found.values;
    let right: Vec<Vec<Complex<f64>>> = values
        .iter()
        .zip(found.right)
        .map(|(value, z)| amplitudes(*value, unbalanced(z, false)))
        .collect();
    let lefts = b.zip(found.left).map(|(b, left)| {
        let left: Vec<Vec<Complex<f64>>> = left.into_iter().map(|w| unbalanced(w, true)).collect();
        let left: Vec<&[Complex<f64>]> = left.iter().map(Vec::as_slice).collect();
        products(b.transpose(), &left)
    });
    assembled(solver, values, right, lefts, basis)
}

/// Roots given by one of each conjugate pair and the amplitudes that a basis of shapes has in it: conjugates included, with
/// their shapes. Left shapes are given as they are.
pub(crate) fn assembled(
    solver: &dyn ModeSolver,
    values: Vec<Complex<f64>>,
    amplitudes: Vec<Vec<Complex<f64>>>,
    lefts: Option<Vec<Vec<Complex<f64>>>>,
    basis: MatRef<'_, f64>,
) -> Result<Vec<Root>, ModesError> {
    let amplitudes: Vec<&[Complex<f64>]> = amplitudes.iter().map(Vec::as_slice).collect();
    let shapes: Vec<Vec<Complex<f64>>> = products(basis, &amplitudes)
        .into_iter()
        .map(of_size_one)
        .collect();
    // Motions at rest need none: their shapes are known.
    let mut moving = values.iter().zip(&shapes);
    if moving.any(|(value, shape)| *value != Complex::ZERO && !is_direction(shape)) {
        let method = solver.name();
        return Err(ModesError::OutOfRange { method });
    }
    let mut roots = Vec::with_capacity(2 * values.len());
    let mut lefts = lefts.map(Vec::into_iter);
    for (value, shape) in values.into_iter().zip(shapes) {
        let root = Root {
            left: lefts.as_mut().and_then(Iterator::next),
            ..Root::simple(value, shape)
        };
        if value.im != 0.0 {
            let conjugate = |v: &[Complex<f64>]| v.iter().map(|z| z.conj()).collect::<Vec<_>>();
            roots.push(Root {
                left: root.left.as_deref().map(conjugate),
                ..Root::simple(value.conj(), conjugate(&root.shape))
            });
        }
        roots.push(root);
    }
    Ok(roots)
}

/// The vector times the power of two that brings its largest entry to about 1: components in units far
/// apart, squared or multiplied, would leave the doubles.
fn of_size_one(mut vector: Vec<Complex<f64>>) -> Vec<Complex<f64>> {
    let sizes = vector.iter().map(Complex::l1_norm);
    let largest = sizes.fold(0.0, f64::max);
    if largest > 0.0 && largest.is_finite() {
        // In two factors, of which neither leaves the doubles.
        let half = (-0.5 * largest.log2()).round().exp2();
        vector
            .iter_mut()
            .for_each(|entry| *entry = *entry * half * half);
    }
    vector
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::samples::chain;

    #[test]
    fn nearly_repeated_roots_keep_their_shapes() {
        // Two ends alike, with modes of their own 60 masses apart: pairs of roots 1e-14 apart.
        let n = 120;
        let masses: Vec<f64> = (0..n).map(|i| 1.0 + 0.25 * (i % 4) as f64).collect();
        let springs: Vec<f64> = (0..=n).map(|i| 1.0 + 0.5 * (i % 3) as f64).collect();
        let dampers: Vec<f64> = (0..=n).map(|i| 0.02 * (1 + i % 5) as f64).collect();
        let system = chain(&masses, &springs, &dampers);
        let modes = StateMatrix.solve(&system).unwrap();
        assert_eq!(modes.eigenvalues().len(), 2 * n);
        for mode in &modes {
            assert!(mode.backward_error() <= 8.0 * f64::EPSILON);
        }
    }
}
