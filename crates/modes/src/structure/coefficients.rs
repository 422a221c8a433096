//! M, C and K in exact arithmetic, with their networks where they are symmetric.

use super::later::Later;
use super::mirror::Mirror;
use super::network::Network;
use super::semidefinite;
use super::support::floating;
use super::symmetric::is_symmetric;
use crate::exact::matrix::ExactMatrix;
use crate::exact::null_space::{NullVector, null_space};
use crate::model::MAX_DENSE_COORDINATES;
use crate::model::MatrixKind;
use crate::model::Model;

/// One of the three matrices.
#[derive(Debug, PartialEq)]
pub(crate) struct Coefficient {
    pub(crate) matrix: ExactMatrix,
    /// There exactly when the matrix is symmetric.
    pub(crate) network: Option<Network>,
    semidefinite: Later<Option<usize>>,
    null_space: Later<Option<Vec<NullVector>>>,
}

impl Coefficient {
    fn new(matrix: ExactMatrix, symmetric: bool) -> Coefficient {
        Coefficient {
            network: symmetric.then(|| Network::of(&matrix)),
            matrix,
            semidefinite: Later::new(),
            null_space: Later::new(),
        }
    }

    /// The sum of two of them.
    pub(crate) fn plus(&self, other: &Coefficient) -> Coefficient {
        let symmetric = self.network.is_some() && other.network.is_some();
        Coefficient::new(self.matrix.plus(&other.matrix), symmetric)
    }

    /// A basis of all x with A x = 0, where it was found. Computed once.
    pub(crate) fn null_space(&self) -> Option<&[NullVector]> {
        let found = self.null_space.get(|| {
            let is_small = self.matrix.len() <= MAX_DENSE_COORDINATES;
            is_small.then(|| null_space(&self.matrix)).flatten()
        });
        found.as_deref()
    }

    /// The rank, if the matrix is proved symmetric and positive semidefinite. Computed once.
    pub(crate) fn semidefinite_rank(&self) -> Option<usize> {
        let network = self.network.as_ref()?;
        *self.semidefinite.get(|| {
            if network.is_non_negative() {
                Some(network.len() - floating(&[network]).len())
            } else if self.matrix.len() > MAX_DENSE_COORDINATES {
                semidefinite::is_narrow_definite(&self.matrix).then_some(self.matrix.len())
            } else {
                semidefinite::rank(&self.matrix)
            }
        })
    }
}

/// All three.
#[derive(Debug, PartialEq)]
pub(crate) struct Coefficients {
    pub(crate) mass: Coefficient,
    pub(crate) damping: Coefficient,
    pub(crate) stiffness: Coefficient,
    mirror: Later<Option<Mirror>>,
}

impl From<[Coefficient; 3]> for Coefficients {
    fn from([mass, damping, stiffness]: [Coefficient; 3]) -> Coefficients {
        Coefficients {
            mass,
            damping,
            stiffness,
            mirror: Later::new(),
        }
    }
}

impl Coefficients {
    pub(crate) fn of(model: &Model) -> Coefficients {
        let of = |kind| {
            let matrix = ExactMatrix::of(model, kind);
            let symmetric = is_symmetric(model, kind);
            Coefficient::new(matrix, symmetric)
        };
        Coefficients::from([MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness].map(of))
    }

    /// M, C and K.
    pub(crate) fn parts(&self) -> [&Coefficient; 3] {
        [&self.mass, &self.damping, &self.stiffness]
    }

    /// A mirror symmetry, if one was found. Looked for once.
    pub(crate) fn mirror(&self) -> Option<&Mirror> {
        let of = || Mirror::of(self.parts().map(|part| &part.matrix));
        let mirror = self.mirror.get(of);
        mirror.as_ref()
    }
}
