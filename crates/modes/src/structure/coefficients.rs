//! M, C and K in exact arithmetic, with their networks where they are symmetric.

use super::network::Network;
use crate::element::MatrixKind;
use crate::exact::matrix::ExactMatrix;
use crate::system::System;

/// One of the three matrices.
pub(crate) struct Coefficient {
    pub(crate) matrix: ExactMatrix,
    /// There exactly when the matrix is symmetric.
    pub(crate) network: Option<Network>,
}

/// All three.
pub(crate) struct Coefficients {
    pub(crate) mass: Coefficient,
    pub(crate) damping: Coefficient,
    pub(crate) stiffness: Coefficient,
}

impl Coefficients {
    pub(crate) fn of(system: &System) -> Coefficients {
        let of = |kind| {
            let matrix = ExactMatrix::of(system, kind);
            let symmetric = super::symmetric::is_symmetric(system, kind);
            let network = symmetric.then(|| Network::of(&matrix));
            Coefficient { matrix, network }
        };
        Coefficients {
            mass: of(MatrixKind::Mass),
            damping: of(MatrixKind::Damping),
            stiffness: of(MatrixKind::Stiffness),
        }
    }
}
