//! From names to linear forms: points, supports, and the elements between them.

use std::collections::{HashMap, HashSet};

use super::BuildError;
use super::builder::{GivenPoint, Joint};
use crate::model::{
    Element, ElementKind, Form, GROUND, GivenElement, Machine, MatrixKind, Node, Point, Term,
};

/// Everything an element may end at.
pub(super) struct Places<'a> {
    names: &'a [String],
    index: HashMap<&'a str, usize>,
    points: Vec<Point>,
    supports: Vec<String>,
}

impl<'a> Places<'a> {
    pub(super) fn of(
        names: &'a [String],
        points: Vec<GivenPoint>,
        supports: Vec<String>,
    ) -> Result<Places<'a>, BuildError> {
        let index = names.iter().enumerate().map(|(i, name)| (name.as_str(), i));
        let mut places = Places {
            names,
            index: index.collect(),
            points: Vec::new(),
            supports: Vec::new(),
        };
        let given: HashSet<String> = points.iter().map(|point| point.name.clone()).collect();
        for (index, name) in supports.into_iter().enumerate() {
            places.admit("support", index, &name)?;
            places.supports.push(name);
        }
        for (index, point) in points.into_iter().enumerate() {
            places.admit("point", index, &point.name)?;
            let point = places.point(index, point, &given)?;
            places.points.push(point);
        }
        Ok(places)
    }

    fn admit(&self, what: &'static str, index: usize, name: &str) -> Result<(), BuildError> {
        let taken = name.is_empty() || self.form(name).is_some();
        let name = name.to_owned();
        match taken {
            true => Err(BuildError::PlaceName { what, index, name }),
            false => Ok(()),
        }
    }

    fn point(
        &self,
        index: usize,
        given: GivenPoint,
        points: &HashSet<String>,
    ) -> Result<Point, BuildError> {
        let GivenPoint { name, moves, mass } = given;
        if moves.is_empty() {
            return Err(BuildError::PointStill { point: name });
        }
        if !(0.0..=f64::MAX).contains(&mass) {
            let value = mass;
            return Err(BuildError::InvalidMass { index, name, value });
        }
        let mut form = Form::default();
        for (with, value) in moves {
            if !value.is_finite() {
                return Err(BuildError::PointNotFinite {
                    point: name,
                    name: with,
                    value,
                });
            }
            if points.contains(&with) {
                return Err(BuildError::PointOnPoint {
                    point: name,
                    name: with,
                });
            }
            let moved = self.form(&with).filter(|_| with != GROUND);
            let Some(moved) = moved else {
                return Err(BuildError::PointMoves {
                    point: name,
                    name: with,
                    known: self.known(),
                });
            };
            let times = |(i, _): (usize, f64)| (i, value);
            form.coordinates
                .extend(moved.coordinates.into_iter().map(times));
            form.supports.extend(moved.supports.into_iter().map(times));
        }
        let form = form.minus(&Form::default());
        let mass = mass.abs();
        Ok(Point { name, form, mass })
    }

    fn has(&self, name: &str) -> bool {
        self.node(name).is_some() || self.points.iter().any(|point| point.name == name)
    }

    /// A place that is not a point; a support stands still as the ground does.
    fn node(&self, name: &str) -> Option<Node> {
        let coordinate = self.index.get(name).map(|&i| Node::Coordinate(i));
        let still = || name == GROUND || self.supports.iter().any(|support| support == name);
        coordinate.or_else(|| still().then_some(Node::Ground))
    }

    /// The displacement of a place; the ground has none.
    fn form(&self, name: &str) -> Option<Form> {
        if name == GROUND {
            return Some(Form::default());
        }
        let coordinate = self.index.get(name).map(|&i| Form::coordinate(i));
        let support = || self.supports.iter().position(|support| support == name);
        let point = || self.points.iter().find(|point| point.name == name);
        coordinate
            .or_else(|| support().map(Form::support))
            .or_else(|| point().map(|point| point.form.clone()))
    }

    /// The names there are, the first ones of many.
    fn known(&self) -> String {
        const SHOWN: usize = 12;
        let points = self.points.iter().map(|point| &point.name);
        let all = self.names.iter().chain(points).chain(&self.supports);
        let names: Vec<&str> = all.clone().take(SHOWN).map(String::as_str).collect();
        match all.count() {
            0..=SHOWN => names.join(", "),
            count => format!("{} and {} more", names.join(", "), count - SHOWN),
        }
    }
}

/// What elements and points make of a model.
pub(super) struct Joined {
    /// The elements between coordinates, and from one to what stands still.
    pub(super) springs: Vec<Element>,
    pub(super) dampers: Vec<Element>,
    /// What the other ones, and the masses of points, add to M, C and K.
    pub(super) terms: [Vec<Term>; 3],
    /// Absent where nothing but coordinates was given.
    pub(super) machine: Option<Machine>,
}

/// Finds the ends of all elements.
pub(super) fn join(places: &Places<'_>, elements: Vec<Joint>) -> Result<Joined, BuildError> {
    let mut machine = Machine {
        points: places.points.clone(),
        supports: places.supports.clone(),
        ..Machine::default()
    };
    let named = elements.iter().any(|element| element.name.is_some());
    let is_plain = places.points.is_empty() && places.supports.is_empty() && !named;
    let (mut springs, mut dampers) = (Vec::new(), Vec::new());
    let mut terms: [Vec<Term>; 3] = Default::default();
    let mut names = HashSet::new();
    let mut counts = [0, 0];
    for element in elements {
        let kind = element.kind;
        let count = &mut counts[kind as usize];
        let (index, coefficient) = (*count, element.coefficient);
        *count += 1;
        let [first, second] = &element.ends;
        for name in [first, second] {
            if !places.has(name) {
                return Err(BuildError::UnknownNode {
                    kind,
                    index,
                    name: name.clone(),
                    known: places.known(),
                });
            }
        }
        if first == second {
            let name = first.clone();
            return Err(BuildError::SelfJoined { kind, index, name });
        }
        if !coefficient.is_finite() {
            return Err(BuildError::ElementNotFinite {
                kind,
                index,
                value: coefficient,
            });
        }
        if let Some(name) = element.name.clone()
            && (name.is_empty() || !names.insert(name.clone()))
        {
            return Err(BuildError::ElementName { kind, index, name });
        }
        let (matrix, list, given) = match kind {
            ElementKind::Spring => (MatrixKind::Stiffness, &mut springs, &mut machine.springs),
            ElementKind::Damper => (MatrixKind::Damping, &mut dampers, &mut machine.dampers),
        };
        let ends = [first, second].map(|name| places.node(name));
        if is_plain && let [Some(first), Some(second)] = ends {
            list.push(Element {
                first,
                second,
                coefficient,
            });
            continue;
        }
        let [from, to] = [first, second].map(|name| places.form(name).expect("looked up above"));
        let stretch = to.minus(&from);
        let direct = match ends {
            [Some(Node::Ground), Some(Node::Ground)] => None,
            [Some(first), Some(second)] => Some(Element {
                first,
                second,
                coefficient,
            }),
            _ => stretch.element(coefficient),
        };
        list.extend(direct);
        if direct.is_none() || !stretch.supports.is_empty() {
            let what = || format!("{kind} {index}");
            let [own, coupling] = within_range(&stretch, coefficient, what)?;
            if direct.is_none() {
                terms[matrix as usize].extend(own);
            }
            machine.couplings[matrix as usize].extend(coupling);
        }
        given.push(GivenElement {
            name: element.name,
            stretch,
            coefficient,
        });
    }
    for point in &places.points {
        let what = || format!("the mass of point {:?}", point.name);
        let [own, coupling] = within_range(&point.form, point.mass, what)?;
        terms[MatrixKind::Mass as usize].extend(own);
        machine.couplings[MatrixKind::Mass as usize].extend(coupling);
    }
    Ok(Joined {
        springs,
        dampers,
        terms,
        machine: (!is_plain).then_some(machine),
    })
}

fn within_range(
    form: &Form,
    coefficient: f64,
    what: impl Fn() -> String,
) -> Result<[Vec<Term>; 2], BuildError> {
    let mut terms = form
        .terms(coefficient)
        .ok_or_else(|| BuildError::PointRange { what: what() })?;
    for terms in &mut terms {
        terms.retain(|term| term.value != 0.0);
    }
    Ok(terms)
}
