//! M, C and K of a system without any rounding.

use eigentone_modes::{Element, MatrixKind, Node, System};
use num_rational::BigRational;

use super::ball::Ball;
use super::rational_matrix::RationalMatrix;

/// M x″ + C x′ + K x = f with each matrix the exact sum of its elements' doubles.
pub(super) struct Equation {
    pub(super) mass: RationalMatrix,
    pub(super) damping: RationalMatrix,
    pub(super) stiffness: RationalMatrix,
}

impl Equation {
    pub(super) fn of(system: &System) -> Equation {
        let lumped = system.masses().iter().enumerate();
        let masses: Vec<Element> = lumped
            .map(|(i, mass)| Element {
                first: Node::Ground,
                second: Node::Coordinate(i),
                coefficient: *mass,
            })
            .collect();
        Equation {
            mass: assemble(system, &masses, MatrixKind::Mass),
            damping: assemble(system, system.dampers(), MatrixKind::Damping),
            stiffness: assemble(system, system.springs(), MatrixKind::Stiffness),
        }
    }
}

fn assemble(system: &System, elements: &[Element], kind: MatrixKind) -> RationalMatrix {
    let n = system.len();
    let mut matrix = match system.added(kind) {
        Some(added) => RationalMatrix::from_fn(n, n, |i, j| exactly(added[(i, j)])),
        None => RationalMatrix::zeros(n, n),
    };
    for element in elements {
        let coefficient = exactly(element.coefficient);
        for (end, other) in [
            (element.first, element.second),
            (element.second, element.first),
        ] {
            let Some(i) = end.coordinate() else { continue };
            *matrix.at_mut(i, i) += &coefficient;
            if let Some(j) = other.coordinate() {
                *matrix.at_mut(i, j) -= &coefficient;
            }
        }
    }
    matrix
}

/// A double as the rational number that it is.
pub(super) fn exactly(value: f64) -> BigRational {
    BigRational::from_float(value).expect("systems and problems hold finite numbers only")
}

/// log₂|value|, roughly; −∞ for 0.
pub(super) fn log2(value: &BigRational) -> f64 {
    Ball::from(value.numer().clone()).log2() - Ball::from(value.denom().clone()).log2()
}
