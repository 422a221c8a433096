//! Beams in bending and rods along their length, by finite elements (Petyt 2010, *Introduction to Finite Element
//! Vibration Analysis*, chapters 3.3 and 3.5).
//!
//! The bending energy of an element of length h between nodes 1 and 2 is the sum of two squares,
//! EI/h·(r₂ − r₁)² and 12EI/h³·(w₂ − w₁ − h(r₁ + r₂)/2)², and its kinetic energy, by the Legendre polynomials along it,
//! that of four: rigid motions stretch nothing, exactly, and no energy is negative. The forms that are squared are exact, as they are taken
//! N times for N elements of length h = L/N; their coefficients are kept as three doubles, within 2^-156 of themselves, and all products
//! without rounding.

use eigentone_digits::Real;

use super::BuildError;
use crate::linear::wide::Number;
use crate::model::{
    CoordinateKind, Element, Form, Held, MAX_COORDINATES, Node, Square, Term, gathered,
};

/// A straight uniform Euler–Bernoulli beam of equal elements. Node i has the displacement `NAME.i.w` across the beam
/// in m and the rotation `NAME.i.r` = dw/dx in rad, i from 0; those that an end fixes are no coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Beam {
    /// What the names of its coordinates begin with.
    pub name: String,
    /// In m.
    pub length: f64,
    /// How many elements; it has one node more.
    pub elements: usize,
    /// EI in N·m².
    pub flexural_rigidity: f64,
    /// ρA in kg/m.
    pub mass_per_length: f64,
    /// How the first and the last node are held.
    pub ends: [BeamEnd; 2],
    /// Whether each element puts half of its mass on the displacement of either node, and no inertia on rotations, which
    /// then follow without mass. Otherwise the mass is consistent: that of the cubic shapes of the elements.
    pub lumped: bool,
}

/// How an end of a [`Beam`] is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BeamEnd {
    /// w = 0 and r = 0.
    Clamped,
    /// w = 0.
    Pinned,
    /// r = 0.
    Guided,
    /// Not at all.
    Free,
}

/// A straight uniform rod of equal elements that moves along its length; shafts in torsion and taut strings are rods by
/// analogy. Node i has the displacement `NAME.i`, i from 0; those that an end fixes are no coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Rod {
    /// What the names of its coordinates begin with.
    pub name: String,
    /// In m.
    pub length: f64,
    /// How many elements; it has one node more.
    pub elements: usize,
    /// EA in N.
    pub axial_rigidity: f64,
    /// ρA in kg/m.
    pub mass_per_length: f64,
    /// How the first and the last node are held.
    pub ends: [RodEnd; 2],
    /// Whether each element puts half of its mass on either node. Otherwise the mass is consistent: that of the linear
    /// shapes of the elements.
    pub lumped: bool,
    /// Whether it is a shaft in torsion: its coordinates are rotations in rad, its rigidity is GJ in N·m², and its mass
    /// per length an inertia per length in kg·m.
    pub twists: bool,
}

/// How an end of a [`Rod`] is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RodEnd {
    /// It does not move.
    Fixed,
    /// Not at all.
    Free,
}

/// The coordinates of beams and rods, in their order, and what they add to M and K.
#[derive(Default)]
pub(super) struct Continua {
    pub(super) names: Vec<String>,
    pub(super) masses: Vec<f64>,
    pub(super) is_rotation: Vec<bool>,
    pub(super) springs: Vec<Element>,
    pub(super) mass: Sum,
    pub(super) stiffness: Sum,
    pub(super) held: Held,
}

/// What a node's displacement or rotation is.
#[derive(Clone, Copy)]
enum Place {
    Coordinate(usize),
    /// One that is 0, by its index among these.
    Held(usize),
}

impl Place {
    fn coordinate(self) -> Option<usize> {
        match self {
            Place::Coordinate(at) => Some(at),
            Place::Held(_) => None,
        }
    }
}

/// A sum of squares and its terms.
#[derive(Default)]
pub(super) struct Sum {
    pub(super) squares: Vec<Square>,
    pub(super) terms: Vec<Term>,
}

impl Continua {
    /// `before` is how many coordinates there are besides.
    pub(super) fn of(beams: &[Beam], rods: &[Rod], before: usize) -> Result<Continua, BuildError> {
        let mut all = Continua::default();
        for beam in beams {
            let numbers = [beam.length, beam.flexural_rigidity, beam.mass_per_length];
            check(&beam.name, numbers, beam.elements, before + all.names.len())?;
            all.beam(beam, before)?;
        }
        for rod in rods {
            let numbers = [rod.length, rod.axial_rigidity, rod.mass_per_length];
            check(&rod.name, numbers, rod.elements, before + all.names.len())?;
            all.rod(rod, before)?;
        }
        Ok(all)
    }

    /// A coordinate, unless it is held.
    fn place(&mut self, moves: bool, before: usize, name: String, is_rotation: bool) -> Place {
        if !moves {
            self.held.kinds.push(match is_rotation {
                true => CoordinateKind::Rotation,
                false => CoordinateKind::Displacement,
            });
            return Place::Held(self.held.kinds.len() - 1);
        }
        self.names.push(name);
        self.masses.push(0.0);
        self.is_rotation.push(is_rotation);
        Place::Coordinate(before + self.names.len() - 1)
    }

    fn beam(&mut self, beam: &Beam, before: usize) -> Result<(), BuildError> {
        let last = beam.elements;
        let mut nodes = Vec::with_capacity(last + 1);
        for i in 0..=last {
            let end = match i {
                0 => beam.ends[0],
                _ if i == last => beam.ends[1],
                _ => BeamEnd::Free,
            };
            let name = &beam.name;
            let w = !matches!(end, BeamEnd::Clamped | BeamEnd::Pinned);
            let w = self.place(w, before, format!("{name}.{i}.w"), false);
            let r = !matches!(end, BeamEnd::Clamped | BeamEnd::Guided);
            let r = self.place(r, before, format!("{name}.{i}.r"), true);
            nodes.push([w, r]);
        }
        let range = || BuildError::ContinuumRange {
            name: beam.name.clone(),
        };
        let h = Number::from(beam.length) / number(beam.elements as f64);
        let rigidity = Number::from(beam.flexural_rigidity);
        // Forms are taken as many times as there are elements: the length of one, and so a rigid motion, may be no double.
        let count = beam.elements as f64;
        let square = number(count) * number(count);
        let form = |plain: &[(usize, f64)], times_h: &[(usize, f64)]| -> Vec<(usize, f64)> {
            let plain = plain.iter().map(|&(i, a)| (i, count * a));
            let times_h = times_h.iter().map(|&(i, b)| (i, beam.length * b));
            plain.chain(times_h).collect()
        };
        // w₁, r₁, w₂ and r₂ are 0 to 3.
        let bending = [
            (rigidity / h, vec![(1, -1.0), (3, 1.0)]),
            (
                number(12.0) * rigidity / (h * h * h * square),
                form(&[(0, -1.0), (2, 1.0)], &[(1, -0.5), (3, -0.5)]),
            ),
        ];
        let bending = Part::of(&bending).ok_or_else(range)?;
        let mass = Number::from(beam.mass_per_length) * h;
        let consistent = || {
            let forms = [
                (144.0, form(&[(0, 6.0), (2, 6.0)], &[(1, 1.0), (3, -1.0)])),
                (
                    1200.0,
                    form(&[(0, -12.0), (2, 12.0)], &[(1, -1.0), (3, -1.0)]),
                ),
                (720.0, form(&[], &[(1, -1.0), (3, 1.0)])),
                (2800.0, form(&[(0, 2.0), (2, -2.0)], &[(1, 1.0), (3, 1.0)])),
            ];
            Part::of(&forms.map(|(over, form)| (mass / (number(over) * square), form)))
        };
        let consistent = match beam.lumped {
            true => None,
            false => Some(consistent().ok_or_else(range)?),
        };
        for pair in nodes.windows(2) {
            let place = [pair[0][0], pair[0][1], pair[1][0], pair[1][1]];
            self.stiffness.add(&bending, &place);
            if let Some(consistent) = &consistent {
                self.mass.add(consistent, &place);
                hold(&mut self.held, consistent, &place);
            }
        }
        if beam.lumped {
            let across: Vec<Place> = nodes.iter().map(|node| node[0]).collect();
            self.lump(mass, &across, before).ok_or_else(range)?;
        }
        Ok(())
    }

    fn rod(&mut self, rod: &Rod, before: usize) -> Result<(), BuildError> {
        let last = rod.elements;
        let nodes: Vec<Place> = (0..=last)
            .map(|i| {
                let end = match i {
                    0 => rod.ends[0],
                    _ if i == last => rod.ends[1],
                    _ => RodEnd::Free,
                };
                let free = end == RodEnd::Free;
                self.place(free, before, format!("{}.{i}", rod.name), rod.twists)
            })
            .collect();
        let range = || BuildError::ContinuumRange {
            name: rod.name.clone(),
        };
        let h = Number::from(rod.length) / number(rod.elements as f64);
        let stiffness = positive_parts(Number::from(rod.axial_rigidity) / h).ok_or_else(range)?;
        let node = |place: Place| place.coordinate().map_or(Node::Ground, Node::Coordinate);
        for pair in nodes.windows(2) {
            let [first, second] = [node(pair[0]), node(pair[1])];
            self.springs
                .extend(stiffness.iter().map(|&coefficient| Element {
                    first,
                    second,
                    coefficient,
                }));
        }
        let mass = Number::from(rod.mass_per_length) * h;
        if rod.lumped {
            return self.lump(mass, &nodes, before).ok_or_else(range);
        }
        let forms = [
            (4.0, vec![(0, 1.0), (1, 1.0)]),
            (12.0, vec![(0, -1.0), (1, 1.0)]),
        ];
        let consistent = forms.map(|(over, form)| (mass / number(over), form));
        let consistent = Part::of(&consistent).ok_or_else(range)?;
        for pair in nodes.windows(2) {
            self.mass.add(&consistent, pair);
            hold(&mut self.held, &consistent, pair);
        }
        Ok(())
    }

    /// Half the mass of an element on each of its nodes: on the lumped masses where it is a double.
    fn lump(&mut self, mass: Number, nodes: &[Place], before: usize) -> Option<()> {
        let last = nodes.len() - 1;
        for (i, node) in nodes.iter().enumerate() {
            let Some(at) = node.coordinate() else {
                continue;
            };
            let own = if i == 0 || i == last {
                mass.scale(-1)
            } else {
                mass
            };
            let parts = positive_parts(own)?;
            if let [own] = parts.as_slice() {
                self.masses[at - before] = *own;
                continue;
            }
            for value in parts {
                let (row, column) = (at, at);
                self.mass.terms.push(Term { row, column, value });
                self.mass.squares.push(Square {
                    coefficient: value,
                    form: vec![(at, 1.0)],
                });
            }
        }
        Some(())
    }
}

fn check(
    name: &str,
    [length, rigidity, mass]: [f64; 3],
    elements: usize,
    before: usize,
) -> Result<(), BuildError> {
    let wrong = |what, value| {
        Err(BuildError::Continuum {
            name: name.to_owned(),
            what,
            value,
        })
    };
    let positive = f64::MIN_POSITIVE..=f64::MAX;
    if !positive.contains(&length) {
        return wrong("length", length);
    }
    if !positive.contains(&rigidity) {
        return wrong("rigidity", rigidity);
    }
    if !(0.0..=f64::MAX).contains(&mass) {
        return wrong("mass per length", mass);
    }
    if elements == 0 {
        return wrong("number of elements", 0.0);
    }
    match elements.saturating_mul(2).saturating_add(before) {
        count if count > MAX_COORDINATES => Err(BuildError::TooLarge { count }),
        _ => Ok(()),
    }
}

fn number(value: f64) -> Number {
    Number::from(value)
}

/// A number ≥ 0 as up to three doubles > 0, within 2^-156 of itself; `None` out of the range of doubles.
fn positive_parts(value: Number) -> Option<Vec<f64>> {
    if value.is_zero() {
        return Some(Vec::new());
    }
    let mut rest = value;
    let mut parts = Vec::new();
    for _ in 0..3 {
        let mut part = rest.to_f64();
        if Number::from(part) > rest {
            part = part.next_down();
        }
        if part == 0.0 {
            break;
        }
        rest = rest - Number::from(part);
        parts.push(part);
    }
    let is_finite = parts.iter().all(|part| part.is_finite());
    (is_finite && !parts.is_empty()).then_some(parts)
}

/// What an element's mass has at places that are held.
fn hold(held: &mut Held, Part(part): &Part, places: &[Place]) {
    for term in &part.terms {
        let value = term.value;
        match (places[term.row], places[term.column]) {
            (Place::Coordinate(row), Place::Held(column)) => {
                held.coupling.push(Term { row, column, value });
            }
            (Place::Held(row), Place::Held(column)) => {
                held.between.push(Term { row, column, value });
            }
            _ => {}
        }
    }
}

/// One element: its squares and terms in its own few coordinates.
struct Part(Sum);

impl Part {
    fn of(squares: &[(Number, Vec<(usize, f64)>)]) -> Option<Part> {
        let mut sum = Sum::default();
        for (coefficient, form) in squares {
            for coefficient in positive_parts(*coefficient)? {
                let form = Form {
                    coordinates: form.clone(),
                    supports: Vec::new(),
                };
                let [own, ..] = form.terms(coefficient)?;
                sum.terms.extend(own);
                sum.squares.push(Square {
                    coefficient,
                    form: form.coordinates,
                });
            }
        }
        sum.terms = gathered(sum.terms);
        Some(Part(sum))
    }
}

impl Sum {
    /// An element at its places, but for what is held.
    fn add(&mut self, Part(part): &Part, places: &[Place]) {
        let at = |i: usize| places[i].coordinate();
        for term in &part.terms {
            if let (Some(row), Some(column)) = (at(term.row), at(term.column)) {
                let value = term.value;
                self.terms.push(Term { row, column, value });
            }
        }
        for Square { coefficient, form } in &part.squares {
            let form = form.iter();
            let form: Vec<_> = form
                .filter_map(|&(i, times)| Some((at(i)?, times)))
                .collect();
            if !form.is_empty() {
                let coefficient = *coefficient;
                self.squares.push(Square { coefficient, form });
            }
        }
    }
}
