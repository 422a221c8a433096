//! M, C and K of a system without any rounding.

use eigentone_modes::{MatrixKind, System};
use num_rational::BigRational;

use super::ball::Ball;
use super::rational_matrix::RationalMatrix;

/// M x″ + C x′ + K x = f with each matrix the exact sum of its terms' doubles.
pub(super) struct Equation {
    pub(super) mass: RationalMatrix,
    pub(super) damping: RationalMatrix,
    pub(super) stiffness: RationalMatrix,
}

impl Equation {
    pub(super) fn of(system: &System) -> Equation {
        let [mass, damping, stiffness] =
            [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness].map(|kind| {
                let mut matrix = RationalMatrix::zeros(system.len(), system.len());
                for term in system.terms(kind) {
                    *matrix.at_mut(term.row, term.column) += exactly(term.value);
                }
                matrix
            });
        Equation {
            mass,
            damping,
            stiffness,
        }
    }
}

/// A double as the rational number that it is.
pub(super) fn exactly(value: f64) -> BigRational {
    BigRational::from_float(value).expect("systems and problems hold finite numbers only")
}

/// log₂|value|, roughly; −∞ for 0.
pub(super) fn log2(value: &BigRational) -> f64 {
    Ball::from(value.numer().clone()).log2() - Ball::from(value.denom().clone()).log2()
}
