//! From modes in doubles to modes with proven bounds.

use num_complex::Complex;

use crate::inclusion::certify;
use crate::modes::{Bounds, Mode, Modes};
use crate::structure::Structure;
use crate::system::System;

use super::ModeSolver;
use super::roots::{Root, collect};

/// Above this many coordinates the O(n⁴) of a determinant at every root is too dear.
const LARGEST: usize = 64;

/// The same modes with eigenvalues that carry proven bounds, or the modes as they are, with the
/// reason in their plan.
pub(crate) fn certified(
    solver: &dyn ModeSolver,
    system: &System,
    structure: &Structure,
    modes: Modes,
    tolerance: f64,
) -> Modes {
    let n = system.len();
    if n > LARGEST {
        let reason = format!("{n} coordinates are more than the {LARGEST} it is meant for");
        return without_proof(modes, reason);
    }
    // Approximations of all nonzero roots, and the mode that each belongs to.
    let mut approximations: Vec<Complex<f64>> = Vec::new();
    let mut owner = Vec::new();
    for (index, mode) in modes.iter().enumerate() {
        let value = mode.eigenvalue().value;
        if value.norm() == 0.0 {
            continue;
        }
        let count = if mode.is_defective() {
            mode.multiplicity()
        } else {
            1
        };
        for _ in 0..count {
            approximations.push(value);
            owner.push(index);
            if value.im != 0.0 {
                approximations.push(value.conj());
                owner.push(index);
            }
        }
    }
    let Some(found) = certify(system, structure, &approximations, tolerance) else {
        let reason = "no separate discs were reached with the digits at hand".to_owned();
        return without_proof(modes, reason);
    };
    let mut roots: Vec<Root> = modes
        .iter()
        .filter(|mode| mode.eigenvalue().value.norm() == 0.0)
        .map(|mode| {
            root(
                mode,
                mode.eigenvalue().value,
                mode.multiplicity,
                mode.defective,
            )
        })
        .map(|zero| Root {
            error: Some((0.0, 0.0)),
            ..zero
        })
        .collect();
    for certificate in found {
        let mut owners: Vec<usize> = certificate
            .members
            .iter()
            .map(|member| owner[*member])
            .collect();
        owners.sort_unstable();
        owners.dedup();
        let count = certificate.members.len();
        // As many shapes as roots: they coincide, but nothing is missing.
        let complete = owners.len() == count;
        let entries = if complete { count } else { 1 };
        for owner in owners.into_iter().take(entries) {
            let each = if complete { 1 } else { count };
            let found = root(&modes.as_slice()[owner], certificate.value, each, !complete);
            roots.push(Root {
                error: Some((certificate.bound, certificate.real_bound)),
                ..found
            });
        }
    }
    Modes {
        bounds: Bounds::Proven,
        plan: modes.plan,
        ..collect(solver, system, roots)
    }
}

fn root(mode: &Mode, value: Complex<f64>, count: usize, defective: bool) -> Root {
    Root {
        count,
        defective,
        ..Root::simple(value, mode.shape().to_vec())
    }
}

fn without_proof(mut modes: Modes, reason: String) -> Modes {
    modes.plan.left_out.push(("proven bounds", reason));
    modes
}
