//! The numbers a system is made of, one by one.

use crate::model::{Element, MatrixKind, Node};
use crate::system::System;

/// One number of a system: what derivatives are taken with respect to. Indices count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Parameter {
    /// The lumped mass on this coordinate, in kg.
    Mass(usize),
    /// The stiffness of this one of [`System::springs`], in N/m.
    Spring(usize),
    /// The damping of this one of [`System::dampers`], in N·s/m.
    Damper(usize),
    /// One entry of M, C or K by itself. A symmetric change off the diagonal is the sum of two.
    Entry {
        /// Which matrix.
        kind: MatrixKind,
        /// The entry's row.
        row: usize,
        /// The entry's column.
        column: usize,
    },
}

/// Where a parameter p enters: Q(λ) holds p·λ^power·(e_l1 − e_l2)(e_r1 − e_r2)ᵀ, with e of the
/// ground = 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) power: usize,
    pub(crate) left: [Node; 2],
    pub(crate) right: [Node; 2],
}

impl Parameter {
    /// All parameters of a system: each lumped mass (those of 0 too), each spring, each damper, and
    /// each entry of the added matrices that is not 0.
    pub fn all(system: &System) -> Vec<Parameter> {
        let mut all: Vec<Parameter> = (0..system.len()).map(Parameter::Mass).collect();
        all.extend((0..system.springs().len()).map(Parameter::Spring));
        all.extend((0..system.dampers().len()).map(Parameter::Damper));
        for kind in [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness] {
            let Some(matrix) = system.added(kind) else {
                continue;
            };
            for row in 0..system.len() {
                let filled = (0..system.len()).filter(|column| matrix[(row, *column)] != 0.0);
                all.extend(filled.map(|column| Parameter::Entry { kind, row, column }));
            }
        }
        all
    }

    /// Its value in a system, or `None` if the system has no such parameter. Of an entry it is the
    /// part that was [added](System::added) as a matrix, 0 if none was.
    pub fn value(self, system: &System) -> Option<f64> {
        match self {
            Parameter::Mass(i) => system.masses().get(i).copied(),
            Parameter::Spring(i) => system.springs().get(i).map(|spring| spring.coefficient),
            Parameter::Damper(i) => system.dampers().get(i).map(|damper| damper.coefficient),
            Parameter::Entry { kind, row, column } => (row.max(column) < system.len()).then(|| {
                system
                    .added(kind)
                    .map_or(0.0, |matrix| matrix[(row, column)])
            }),
        }
    }

    pub(crate) fn place(self, system: &System) -> Option<Place> {
        let alone = |i: usize| (i < system.len()).then_some([Node::Coordinate(i), Node::Ground]);
        let symmetric = |power: usize, ends: [Node; 2]| Place {
            power,
            left: ends,
            right: ends,
        };
        let ends = |element: &Element| [element.first, element.second];
        match self {
            Parameter::Mass(i) => Some(symmetric(2, alone(i)?)),
            Parameter::Damper(i) => Some(symmetric(1, ends(system.dampers().get(i)?))),
            Parameter::Spring(i) => Some(symmetric(0, ends(system.springs().get(i)?))),
            Parameter::Entry { kind, row, column } => Some(Place {
                power: match kind {
                    MatrixKind::Mass => 2,
                    MatrixKind::Damping => 1,
                    MatrixKind::Stiffness => 0,
                },
                left: alone(row)?,
                right: alone(column)?,
            }),
        }
    }
}

impl std::fmt::Display for Parameter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Parameter::Mass(i) => write!(f, "mass {i}"),
            Parameter::Spring(i) => write!(f, "spring {i}"),
            Parameter::Damper(i) => write!(f, "damper {i}"),
            Parameter::Entry { kind, row, column } => {
                write!(f, "entry ({row}, {column}) of the {kind} matrix")
            }
        }
    }
}
