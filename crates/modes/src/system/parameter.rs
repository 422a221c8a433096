//! The numbers a system is made of, one by one.

use crate::model::{ElementKind, Form, GivenElement, MatrixKind};
use crate::system::System;

/// One number of a system: what derivatives are taken with respect to. Indices count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Parameter {
    /// The lumped mass on this coordinate, in kg.
    Mass(usize),
    /// The mass that moves with this one of [`System::points`], in kg.
    PointMass(usize),
    /// The stiffness of this one of the springs as given, [`System::elements`], in N/m.
    Spring(usize),
    /// The damping of this one of the dampers as given, [`System::elements`], in N·s/m.
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

/// Where a parameter p enters: Q(λ) holds p·λ^power·l rᵀ, with l and r by index and coefficient. An index may come
/// more than once.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub(crate) power: usize,
    pub(crate) left: Vec<(usize, f64)>,
    pub(crate) right: Vec<(usize, f64)>,
}

impl Parameter {
    /// All parameters of a system: each lumped mass (those of 0 too), each mass of a point, each spring, each damper, and
    /// each entry that is not 0 of a matrix that was given.
    pub fn all(system: &System) -> Vec<Parameter> {
        let mut all: Vec<Parameter> = (0..system.len()).map(Parameter::Mass).collect();
        let count = |kind| system.model().element_count(kind);
        all.extend((0..system.points().len()).map(Parameter::PointMass));
        all.extend((0..count(ElementKind::Spring)).map(Parameter::Spring));
        all.extend((0..count(ElementKind::Damper)).map(Parameter::Damper));
        for kind in [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness] {
            let added = system.model().added_whole(kind);
            let Some(matrix) = added.dense().filter(|_| added.is_given) else {
                continue;
            };
            for row in 0..system.len() {
                let filled = (0..system.len()).filter(|column| matrix[(row, *column)] != 0.0);
                all.extend(filled.map(|column| Parameter::Entry { kind, row, column }));
            }
        }
        all
    }

    /// Its value in a system, or `None` if the system has no such parameter. Of an entry it is that of the
    /// [added](System::added) matrix, 0 if there is none.
    pub fn value(self, system: &System) -> Option<f64> {
        let element = |kind, i| Some(system.model().element(kind, i)?.coefficient);
        match self {
            Parameter::Mass(i) => system.masses().get(i).copied(),
            Parameter::PointMass(i) => system.points().get(i).map(|point| point.mass),
            Parameter::Spring(i) => element(ElementKind::Spring, i),
            Parameter::Damper(i) => element(ElementKind::Damper, i),
            Parameter::Entry { kind, row, column } => (row.max(column) < system.len()).then(|| {
                system
                    .added(kind)
                    .map_or(0.0, |matrix| matrix[(row, column)])
            }),
        }
    }

    pub(crate) fn place(self, system: &System) -> Option<Place> {
        let alone = |i: usize| (i < system.len()).then(|| vec![(i, 1.0)]);
        let symmetric = |power: usize, form: Vec<(usize, f64)>| Place {
            power,
            left: form.clone(),
            right: form,
        };
        let stretch = |kind, i| -> Option<Vec<(usize, f64)>> {
            let GivenElement { stretch, .. } = system.model().element(kind, i)?;
            let Form { coordinates, .. } = stretch;
            Some(coordinates)
        };
        match self {
            Parameter::Mass(i) => Some(symmetric(2, alone(i)?)),
            Parameter::PointMass(i) => {
                let form = &system.points().get(i)?.form;
                Some(symmetric(2, form.coordinates.clone()))
            }
            Parameter::Damper(i) => Some(symmetric(1, stretch(ElementKind::Damper, i)?)),
            Parameter::Spring(i) => Some(symmetric(0, stretch(ElementKind::Spring, i)?)),
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
            Parameter::PointMass(i) => write!(f, "mass of point {i}"),
            Parameter::Spring(i) => write!(f, "spring {i}"),
            Parameter::Damper(i) => write!(f, "damper {i}"),
            Parameter::Entry { kind, row, column } => {
                write!(f, "entry ({row}, {column}) of the {kind} matrix")
            }
        }
    }
}
