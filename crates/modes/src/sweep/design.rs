//! Masses, springs and dampers of one layout, with values that change.

use thiserror::Error;

use crate::model::{Element, ElementKind, Form, MatrixKind, Node};
use crate::system::Parameter;
use crate::system::System;

/// The elements of a [`System`], with values that can be set again and again. What joins what stays.
///
/// Masses are positive, springs and dampers ≥ 0, and springs hold every coordinate: then every root
/// λ is finite and none is 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    masses: Vec<f64>,
    springs: Vec<Element>,
    dampers: Vec<Element>,
}

impl Design {
    /// The elements of a system.
    ///
    /// # Errors
    /// [`DesignError`] for a system with whole matrices, Rayleigh damping, elements that no coordinate moves, a mass that is not
    /// positive, or a spring or damper below 0.
    pub fn of(system: &System) -> Result<Design, DesignError> {
        let kinds = [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness];
        if let Some(kind) = kinds.into_iter().find(|kind| system.added(*kind).is_some()) {
            return Err(DesignError::Matrix { kind });
        }
        let elements = [
            (ElementKind::Spring, system.springs()),
            (ElementKind::Damper, system.dampers()),
        ];
        for (kind, between) in elements {
            let given = system.elements(kind).into_iter().map(|given| {
                let direct = given.stretch.element(given.coefficient);
                direct.ok_or(match given.stretch.coordinates.as_slice() {
                    [] => DesignError::AtRest { kind },
                    _ => DesignError::Matrix {
                        kind: match kind {
                            ElementKind::Spring => MatrixKind::Stiffness,
                            ElementKind::Damper => MatrixKind::Damping,
                        },
                    },
                })
            });
            let given: Vec<Element> = given.collect::<Result<_, _>>()?;
            // Written alike: an element may have been given from either end.
            let own = between.iter().map(|element| {
                let [first, second] = [element.first, element.second].map(Form::of_node);
                second.minus(&first).element(element.coefficient)
            });
            // What was not given follows from masses and springs, and would have to change with them.
            if !own.eq(given.into_iter().map(Some)) {
                return Err(DesignError::Rayleigh);
            }
        }
        let mut design = Design {
            masses: system.masses().to_vec(),
            springs: system.springs().to_vec(),
            dampers: system.dampers().to_vec(),
        };
        let settable = |parameter: &Parameter| !matches!(parameter, Parameter::PointMass(_));
        for parameter in Parameter::all(system).into_iter().filter(settable) {
            if let Some(value) = parameter.value(system) {
                design.set(parameter, value)?;
            }
        }
        Ok(design)
    }

    /// Sets one value.
    ///
    /// # Errors
    /// [`DesignError::Unknown`] for a parameter that the system does not have, and
    /// [`DesignError::Value`] for a mass that is not positive, a spring or damper below 0, and what is
    /// not finite. The design then stays as it was.
    pub fn set(&mut self, parameter: Parameter, value: f64) -> Result<(), DesignError> {
        let (place, least) = match parameter {
            Parameter::Mass(i) => (self.masses.get_mut(i), f64::MIN_POSITIVE),
            Parameter::Spring(i) => (coefficient(&mut self.springs, i), 0.0),
            Parameter::Damper(i) => (coefficient(&mut self.dampers, i), 0.0),
            Parameter::PointMass(_) | Parameter::Entry { .. } => (None, 0.0),
        };
        let place = place.ok_or(DesignError::Unknown { parameter })?;
        if !value.is_finite() || value < least {
            return Err(DesignError::Value { parameter, value });
        }
        *place = value;
        Ok(())
    }

    /// The number n of coordinates.
    #[allow(clippy::len_without_is_empty)] // a system is never empty
    pub fn len(&self) -> usize {
        self.masses.len()
    }

    /// The masses in kg, one for each coordinate.
    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// The springs, in the order of the system.
    pub fn springs(&self) -> &[Element] {
        &self.springs
    }

    /// The dampers, in the order of the system.
    pub fn dampers(&self) -> &[Element] {
        &self.dampers
    }

    /// Writes K in N/m (n × n, column by column), summed in doubles.
    ///
    /// # Panics
    /// If there is not room for n² entries.
    pub fn stiffness_matrix(&self, entries: &mut [f64]) {
        assemble(&self.springs, self.len(), entries);
    }

    /// Writes C in N·s/m (n × n, column by column), summed in doubles.
    ///
    /// # Panics
    /// If there is not room for n² entries.
    pub fn damping_matrix(&self, entries: &mut [f64]) {
        assemble(&self.dampers, self.len(), entries);
    }

    /// Whether a path of springs leads from every coordinate to the ground. `reached` has one entry
    /// for each coordinate.
    pub(crate) fn is_held(&self, reached: &mut [bool]) -> bool {
        reached.fill(false);
        let mut last = usize::MAX;
        loop {
            for spring in self
                .springs
                .iter()
                .filter(|spring| spring.coefficient > 0.0)
            {
                let ends = [spring.first, spring.second].map(Node::coordinate);
                let held = |end: Option<usize>| end.is_none_or(|i| reached[i]);
                if ends.into_iter().any(held) {
                    ends.into_iter().flatten().for_each(|i| reached[i] = true);
                }
            }
            let left = reached.iter().filter(|reached| !**reached).count();
            if left == 0 || left == last {
                return left == 0;
            }
            last = left;
        }
    }
}

/// Σ c(e_a − e_b)(e_a − e_b)ᵀ.
fn assemble(elements: &[Element], n: usize, matrix: &mut [f64]) {
    matrix.fill(0.0);
    for element in elements {
        let ends = [element.first, element.second].map(Node::coordinate);
        for i in ends.into_iter().flatten() {
            matrix[i + n * i] += element.coefficient;
        }
        if let [Some(i), Some(j)] = ends {
            matrix[i + n * j] -= element.coefficient;
            matrix[j + n * i] -= element.coefficient;
        }
    }
}

fn coefficient(elements: &mut [Element], index: usize) -> Option<&mut f64> {
    Some(&mut elements.get_mut(index)?.coefficient)
}

/// Why a design cannot be answered.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum DesignError {
    /// The system was given a whole matrix, or elements or masses at points or damping ratios make one.
    #[error(
        "the system has a {kind} matrix, given or made at points or by damping ratios: a sweep takes masses, springs and dampers \
         between coordinates alone"
    )]
    Matrix {
        /// Which matrix.
        kind: MatrixKind,
    },
    /// A spring or damper joins only what stands still.
    #[error(
        "a {kind} moves with no coordinate: a sweep takes springs and dampers between coordinates, or from one to what stands still"
    )]
    AtRest {
        /// Spring or damper.
        kind: ElementKind,
    },
    /// Dampers follow from masses and springs.
    #[error(
        "the system has Rayleigh damping, which changes with its masses and springs: a sweep takes dampers that are given one by one"
    )]
    Rayleigh,
    /// The system has no such parameter, or it is the entry of a matrix.
    #[error("{parameter:?} is not a mass, spring or damper of the system")]
    Unknown {
        /// The parameter.
        parameter: Parameter,
    },
    /// A value is out of range.
    #[error(
        "{parameter:?} is {value:?}: masses must be > 0, springs and dampers ≥ 0, and all finite"
    )]
    Value {
        /// The parameter.
        parameter: Parameter,
        /// The value given.
        value: f64,
    },
    /// A coordinate has no path of springs to the ground.
    #[error(
        "springs do not hold every coordinate: give each a path of positive springs to the ground"
    )]
    NotHeld,
    /// The design has more coordinates or elements than the workspace was made for.
    #[error("the design has another layout than the one that the workspace was made for")]
    Layout,
    /// The QR iteration did not converge, or numbers left the range of doubles.
    #[error(
        "the values lie too far apart for doubles: choose other units, or fewer orders of magnitude"
    )]
    OutOfRange,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GROUND, SystemBuilder};

    /// Rayleigh damping makes a damper of the spring, and the one beside the mass none: as many as were given, but others.
    #[test]
    fn dampers_are_those_that_were_given() {
        let held = || {
            let builder = System::builder().mass("m", 1.0).support("s");
            builder.spring(GROUND, "m", 4.0)
        };
        let refused = |builder: SystemBuilder| {
            let system = builder.build().expect("a system");
            Design::of(&system).expect_err("it is refused")
        };
        let rest = DesignError::AtRest {
            kind: ElementKind::Damper,
        };
        let beside = || held().damper(GROUND, "s", 7.0);
        assert_eq!(refused(beside()), rest);
        assert_eq!(refused(beside().rayleigh(0.0, 0.1, None)), rest);
        assert_eq!(
            refused(held().rayleigh(0.0, 0.1, None)),
            DesignError::Rayleigh
        );
        let plain = System::builder()
            .mass("m", 1.0)
            .spring(GROUND, "m", 4.0)
            .rayleigh(0.5, 0.0, None);
        assert_eq!(refused(plain), DesignError::Rayleigh);
        // From either end, and at a support.
        let ends = held().damper("m", "s", 2.0).damper(GROUND, "m", 3.0);
        let design = Design::of(&ends.build().expect("a system")).expect("a design");
        let mut damping = [0.0];
        design.damping_matrix(&mut damping);
        assert_eq!(damping, [5.0]);
    }
}
