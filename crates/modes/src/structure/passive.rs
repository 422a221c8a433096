//! No part can feed energy in: M, C and K are positive semidefinite.

use super::coefficients::Coefficients;
use crate::model::MatrixKind;
use crate::model::Model;

/// Why a system is passive: no motion gains energy, Re λ ≤ 0. One that nothing holds may drift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Passive {
    /// Every spring and damper is ≥ 0, and so is every mass.
    Elements,
    /// The same of the sums of parallel ones, some of which are negative.
    Sums,
    /// Matrices were added, or elements act at points, and each sum was proved positive semidefinite.
    Matrices,
}

/// `None` where it is not proved. Of elements alone nothing is proved once one is negative, even
/// where the others outweigh it, unless those parallel to it do.
pub(crate) fn passive(model: &Model, coefficients: &Coefficients) -> Option<Passive> {
    let parts = [
        (MatrixKind::Mass, &coefficients.mass),
        (MatrixKind::Damping, &coefficients.damping),
        (MatrixKind::Stiffness, &coefficients.stiffness),
    ];
    let proved = parts.iter().all(|&(kind, part)| {
        model.is_sum_of_squares(kind)
            || match model.is_of_elements(kind) {
                true => part
                    .network
                    .as_ref()
                    .is_some_and(|network| network.is_non_negative()),
                false => part.semidefinite_rank().is_some(),
            }
    });
    let elements_alone = parts.iter().all(|&(kind, _)| model.is_of_elements(kind));
    let elements = model.springs().iter().chain(model.dampers());
    let mut values = elements.map(|element| element.coefficient);
    proved.then_some(match elements_alone {
        true if values.all(|value| value >= 0.0) => Passive::Elements,
        true => Passive::Sums,
        false => Passive::Matrices,
    })
}
