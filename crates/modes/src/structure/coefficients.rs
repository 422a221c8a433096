//! M, C and K in exact arithmetic, with their networks where they are symmetric.

use std::cell::OnceCell;

use super::network::Network;
use super::semidefinite;
use super::support::floating;
use super::symmetric::is_symmetric;
use crate::element::MatrixKind;
use crate::exact::matrix::ExactMatrix;
use crate::system::System;

/// One of the three matrices.
pub(crate) struct Coefficient {
    pub(crate) matrix: ExactMatrix,
    /// There exactly when the matrix is symmetric.
    pub(crate) network: Option<Network>,
    semidefinite: OnceCell<Option<usize>>,
}

impl Coefficient {
    fn new(matrix: ExactMatrix, symmetric: bool) -> Coefficient {
        Coefficient {
            network: symmetric.then(|| Network::of(&matrix)),
            matrix,
            semidefinite: OnceCell::new(),
        }
    }

    /// The sum of two of them.
    pub(crate) fn plus(&self, other: &Coefficient) -> Coefficient {
        let symmetric = self.network.is_some() && other.network.is_some();
        Coefficient::new(self.matrix.plus(&other.matrix), symmetric)
    }

    /// The rank, if the matrix is proved symmetric and positive semidefinite. Computed once.
    pub(crate) fn semidefinite_rank(&self) -> Option<usize> {
        let network = self.network.as_ref()?;
        *self.semidefinite.get_or_init(|| {
            if network.is_non_negative() {
                Some(network.len() - floating(&[network]).len())
            } else {
                semidefinite::rank(&self.matrix)
            }
        })
    }
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
            let symmetric = is_symmetric(system, kind);
            Coefficient::new(matrix, symmetric)
        };
        Coefficients {
            mass: of(MatrixKind::Mass),
            damping: of(MatrixKind::Damping),
            stiffness: of(MatrixKind::Stiffness),
        }
    }
}
