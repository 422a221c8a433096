//! No part can feed energy in: M, C and K are positive semidefinite.

use super::coefficients::Coefficients;

/// Whether that is proved. Then no motion grows: Re λ ≤ 0.
pub(crate) fn is_passive(coefficients: &Coefficients) -> bool {
    [
        &coefficients.mass,
        &coefficients.damping,
        &coefficients.stiffness,
    ]
    .iter()
    .all(|part| {
        part.network
            .as_ref()
            .is_some_and(|network| network.is_non_negative())
    })
}
