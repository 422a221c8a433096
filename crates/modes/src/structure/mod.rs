//! What can be proved of a system from its parameters, in exact arithmetic: every double is taken
//! as it is, elements and matrices are summed without rounding, and nothing rests on a tolerance.
//! One proof a file; [`Structure`] collects them.

mod coefficients;
pub(crate) mod determinant;
pub(crate) mod massless;
mod network;
mod passive;
mod polynomial;
#[cfg(test)]
mod samples;
mod support;
mod symmetric;
mod undamped;

use coefficients::Coefficients;
use determinant::Roots;
use massless::Massless;

use crate::element::MatrixKind;
use crate::system::System;

/// What was proved of a system, by [`System::structure`](crate::System::structure). It prints one
/// fact a line. A fact that is not stated was not proved, which need not make it untrue.
#[derive(Clone, Debug, PartialEq)]
pub struct Structure {
    undamped: bool,
    symmetric: bool,
    passive: bool,
    classical: bool,
    roots: Roots,
    massless: Massless,
    spring_floating: Vec<Vec<usize>>,
    floating: Vec<Vec<usize>>,
}

impl Structure {
    pub(crate) fn of(system: &System) -> Structure {
        let coefficients = Coefficients::of(system);
        let kinds = [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness];
        let floating = |parts: &[&coefficients::Coefficient]| {
            let networks: Option<Vec<_>> = parts.iter().map(|part| part.network.as_ref()).collect();
            networks.map_or(Vec::new(), |networks| support::floating(&networks))
        };
        Structure {
            undamped: undamped::is_undamped(&coefficients),
            symmetric: kinds
                .iter()
                .all(|&kind| symmetric::is_symmetric(system, kind)),
            passive: passive::is_passive(&coefficients),
            classical: false,
            roots: Roots::of(&coefficients),
            massless: Massless::of(&coefficients),
            spring_floating: floating(&[&coefficients.stiffness]),
            floating: floating(&[&coefficients.stiffness, &coefficients.damping]),
        }
    }

    /// Whether there is no damping: C = 0 exactly.
    pub fn is_undamped(&self) -> bool {
        self.undamped
    }

    /// Whether M, C and K are symmetric.
    pub fn is_symmetric(&self) -> bool {
        self.symmetric
    }

    /// Whether no part can feed energy in: M, C and K are proved positive semidefinite, so that
    /// Re λ ≤ 0 for every root.
    pub fn is_passive(&self) -> bool {
        self.passive
    }

    /// Whether M is positive definite, C and K are symmetric, and C M⁻¹ K = K M⁻¹ C, all proved.
    /// Then the undamped shapes are those of the damped system too (Caughey & O'Kelly 1965,
    /// *J. Appl. Mech.* 32, theorem 2), and each moves by itself.
    pub fn is_classical(&self) -> bool {
        self.classical
    }

    /// How many roots are exactly 0: two for each rigid-body motion that nothing holds, one for
    /// each that only dampers hold. `None` where it was not proved.
    pub fn zero_roots(&self) -> Option<usize> {
        self.roots.zero
    }

    /// How many of the 2n roots are finite: the degree of det(λ²M + λC + K). `None` where it was
    /// not proved.
    pub fn finite_roots(&self) -> Option<usize> {
        self.roots.finite
    }

    /// The coordinates whose row and column of M are 0, rising.
    pub fn massless(&self) -> &[usize] {
        &self.massless.nodes
    }

    /// The massless coordinates whose row or column of C is not 0, rising. They have a displacement
    /// of their own, but no free velocity.
    pub fn damped_massless(&self) -> &[usize] {
        &self.massless.damped
    }

    /// The parts that no spring ties to the ground: coordinates that K lets move as one, all by the
    /// same displacement, without any force. Empty unless K is symmetric.
    pub fn spring_floating(&self) -> &[Vec<usize>] {
        &self.spring_floating
    }

    /// The parts that neither springs nor dampers tie to the ground, each made up of whole parts of
    /// [`spring_floating`](Structure::spring_floating). Empty unless C and K are symmetric.
    pub fn floating(&self) -> &[Vec<usize>] {
        &self.floating
    }
}
