//! From names to linear forms: points, supports, and the elements between them.

use std::collections::{HashMap, HashSet};

use super::BuildError;
use super::given::{GivenPoint, Joint};
use super::kinds::Kinds;
use crate::model::{
    CoordinateKind, Element, ElementKind, Form, GROUND, GivenElement, Machine, MatrixKind, Node,
    Point, Square, Term,
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
        let given = points.iter().map(|point| {
            let moves = point.moves.iter().map(|(with, _)| with.clone());
            (point.name.clone(), moves.collect())
        });
        let given: HashMap<String, Vec<String>> = given.collect();
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
        points: &HashMap<String, Vec<String>>,
    ) -> Result<Point, BuildError> {
        let GivenPoint {
            name,
            moves,
            mass,
            kind,
        } = given;
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
            if points.contains_key(&with) {
                let (point, name) = (name, with);
                return Err(match leads(points, &name, &point) {
                    true => BuildError::PointCircle { point, name },
                    false => BuildError::PointOnPoint { point, name },
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
        Ok(Point {
            name,
            form,
            mass,
            kind,
        })
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
    pub(super) squares: [Vec<Square>; 3],
    /// Absent where nothing but coordinates was given.
    pub(super) machine: Option<Machine>,
}

/// Finds the ends of all elements. What is not `is_plain` has more than coordinates and elements between them.
pub(super) fn join(
    places: &Places<'_>,
    elements: Vec<Joint>,
    is_plain: bool,
    is_rotation: &[bool],
) -> Result<Joined, BuildError> {
    let named = elements.iter().any(|element| element.name.is_some());
    let is_plain = is_plain && places.points.is_empty() && places.supports.is_empty() && !named;
    let kinds = (!is_plain).then(|| {
        let (points, supports) = (&places.points, &places.supports);
        Kinds::of(places.names, is_rotation, points, supports, &elements)
    });
    let machine = kinds.as_ref().map(|kinds| {
        let points = places.points.iter().zip(&kinds.points);
        let kind = |(point, kind): (&Point, &Option<CoordinateKind>)| Point {
            kind: *kind,
            ..point.clone()
        };
        Machine {
            points: points.map(kind).collect(),
            supports: places.supports.clone(),
            support_kinds: kinds.supports.clone(),
            ..Machine::default()
        }
    });
    let mut joined = Joined {
        springs: Vec::new(),
        dampers: Vec::new(),
        terms: Default::default(),
        squares: Default::default(),
        machine,
    };
    let mut names = HashSet::new();
    let mut counts = [0, 0];
    let measured = kinds.map_or(Vec::new(), |kinds| kinds.elements);
    let measured = measured.into_iter().chain(std::iter::repeat(None));
    for (element, measured) in elements.into_iter().zip(measured) {
        let kind = element.kind;
        let index = counts[kind as usize];
        counts[kind as usize] += 1;
        let ends = element.ends.each_ref().map(|name| places.node(name));
        let is_point = |name: &String| places.points.iter().any(|point| point.name == *name);
        for (name, node) in element.ends.iter().zip(ends) {
            if node.is_none() && !is_point(name) {
                return Err(BuildError::UnknownNode {
                    kind,
                    index,
                    name: name.clone(),
                    known: places.known(),
                });
            }
        }
        if element.ends[0] == element.ends[1] {
            let [name, _] = element.ends;
            return Err(BuildError::SelfJoined { kind, index, name });
        }
        if !element.coefficient.is_finite() {
            return Err(BuildError::ElementNotFinite {
                kind,
                index,
                value: element.coefficient,
            });
        }
        if let Some(name) = element.name.clone()
            && (name.is_empty() || !names.insert(name.clone()))
        {
            return Err(BuildError::ElementName { kind, index, name });
        }
        joined.take(places, element, ends, measured, index)?;
    }
    for point in &places.points {
        let what = || format!("the mass of point {:?}", point.name);
        joined.add(MatrixKind::Mass, &point.form, point.mass, what)?;
    }
    Ok(joined)
}

impl Joined {
    /// An element whose ends are known; those that are points have no node.
    fn take(
        &mut self,
        places: &Places<'_>,
        element: Joint,
        ends: [Option<Node>; 2],
        measured: Option<CoordinateKind>,
        index: usize,
    ) -> Result<(), BuildError> {
        let (kind, coefficient) = (element.kind, element.coefficient);
        let (matrix, list) = match kind {
            ElementKind::Spring => (MatrixKind::Stiffness, &mut self.springs),
            ElementKind::Damper => (MatrixKind::Damping, &mut self.dampers),
        };
        let between = match ends {
            [Some(first), Some(second)] if first != second => Some(Element {
                first,
                second,
                coefficient,
            }),
            _ => None,
        };
        let Some(machine) = &mut self.machine else {
            list.extend(between);
            return Ok(());
        };
        let [from, to] = element
            .ends
            .each_ref()
            .map(|name| places.form(name).expect("looked up before"));
        let stretch = to.minus(&from);
        let direct = between.or_else(|| stretch.element(coefficient));
        list.extend(direct);
        let given = match kind {
            ElementKind::Spring => &mut machine.springs,
            ElementKind::Damper => &mut machine.dampers,
        };
        given.push(GivenElement {
            name: element.name,
            ends: element.ends,
            stretch: stretch.clone(),
            coefficient,
            kind: measured,
        });
        if direct.is_some() && stretch.supports.is_empty() {
            return Ok(());
        }
        let before = self.terms[matrix as usize].len();
        self.add(matrix, &stretch, coefficient, || format!("{kind} {index}"))?;
        if direct.is_some() {
            self.terms[matrix as usize].truncate(before);
            self.squares[matrix as usize].pop();
        }
        Ok(())
    }

    /// coefficient·a aᵀ of a form, and what couples it to supports.
    fn add(
        &mut self,
        matrix: MatrixKind,
        form: &Form,
        coefficient: f64,
        what: impl Fn() -> String,
    ) -> Result<(), BuildError> {
        let terms = form.terms(coefficient);
        let [own, coupling, between] =
            terms.ok_or_else(|| BuildError::PointRange { what: what() })?;
        self.terms[matrix as usize].extend(own);
        self.squares[matrix as usize].push(Square {
            coefficient,
            form: form.coordinates.clone(),
        });
        if let Some(machine) = &mut self.machine {
            machine.couplings[matrix as usize].extend(coupling);
            machine.between_supports[matrix as usize].extend(between);
        }
        Ok(())
    }
}

/// Whether one point moves with another, by way of any number of points.
fn leads(points: &HashMap<String, Vec<String>>, from: &str, to: &str) -> bool {
    let (mut seen, mut open) = (HashSet::new(), vec![from]);
    while let Some(name) = open.pop() {
        if name == to {
            return true;
        }
        if let Some(moves) = points.get(name).filter(|_| seen.insert(name)) {
            open.extend(moves.iter().map(String::as_str));
        }
    }
    false
}
