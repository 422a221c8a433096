//! Systems as text, with the keys of a scene: what the builder was given, so that a system read back is the same one, to the
//! last digit.

use std::collections::HashSet;

use faer::Mat;
use serde::de::{Error as _, MapAccess, SeqAccess, Visitor};
use serde::ser::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::System;
use super::beams::{Beam, BeamEnd, Rod, RodEnd};
use super::builder::{Entries, SystemBuilder};
use crate::model::{CoordinateKind, ElementKind, MAX_DENSE_COORDINATES, MatrixKind};

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Description {
    #[serde(skip_serializing_if = "Vec::is_empty")]
    masses: Vec<Mass>,
    #[serde(skip_serializing_if = "Matrices::is_empty")]
    matrices: Matrices,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    supports: Vec<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    points: Vec<Point>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    springs: Vec<Spring>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    dampers: Vec<Damper>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    beams: Vec<BeamText>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    rods: Vec<RodText>,
    #[serde(skip_serializing_if = "Damping::is_empty")]
    damping: Damping,
}

#[derive(Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
enum Unit {
    #[default]
    #[serde(rename = "m")]
    Metre,
    #[serde(rename = "rad")]
    Radian,
}

impl Unit {
    fn is_metre(&self) -> bool {
        *self == Unit::Metre
    }

    fn of(is_rotation: bool) -> Unit {
        if is_rotation {
            Unit::Radian
        } else {
            Unit::Metre
        }
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Mass {
    name: String,
    mass: f64,
    #[serde(default, skip_serializing_if = "Unit::is_metre")]
    unit: Unit,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Matrices {
    #[serde(skip_serializing_if = "Option::is_none")]
    mass: Option<Vec<Vec<f64>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    damping: Option<Vec<Vec<f64>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    stiffness: Option<Vec<Vec<f64>>>,
}

impl Matrices {
    fn is_empty(&self) -> bool {
        self.mass.is_none() && self.damping.is_none() && self.stiffness.is_none()
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Point {
    name: String,
    moves: Moves,
    #[serde(default)]
    mass: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    unit: Option<Unit>,
}

/// A map in the order in which it was given. Where a name comes more than once, which maps cannot hold and whose sum need not be a
/// double, a list of pairs.
struct Moves(Vec<(String, f64)>);

impl Serialize for Moves {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut names = HashSet::new();
        match self.0.iter().all(|(name, _)| names.insert(name)) {
            true => to.collect_map(self.0.iter().map(|(name, times)| (name, times))),
            false => to.collect_seq(&self.0),
        }
    }
}

impl<'de> Deserialize<'de> for Moves {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Moves, D::Error> {
        struct Pairs;
        impl<'de> Visitor<'de> for Pairs {
            type Value = Moves;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("names with numbers, or pairs of both")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Moves, A::Error> {
                let mut pairs = Vec::new();
                while let Some(pair) = list.next_element()? {
                    pairs.push(pair);
                }
                Ok(Moves(pairs))
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Moves, A::Error> {
                let mut pairs = Vec::new();
                while let Some(pair) = map.next_entry()? {
                    pairs.push(pair);
                }
                Ok(Moves(pairs))
            }
        }
        from.deserialize_any(Pairs)
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Spring {
    between: [String; 2],
    stiffness: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    name: Option<String>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Damper {
    between: [String; 2],
    damping: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    name: Option<String>,
}

#[derive(Clone, Copy, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum MassKind {
    #[default]
    Consistent,
    Lumped,
}

impl MassKind {
    fn of(lumped: bool) -> MassKind {
        if lumped {
            MassKind::Lumped
        } else {
            MassKind::Consistent
        }
    }
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "BeamEnd", rename_all = "lowercase")]
enum BeamEndText {
    Clamped,
    Pinned,
    Guided,
    Free,
}

#[derive(Serialize, Deserialize)]
struct HeldBeam(#[serde(with = "BeamEndText")] BeamEnd);

#[derive(Serialize, Deserialize)]
#[serde(remote = "RodEnd", rename_all = "lowercase")]
enum RodEndText {
    Fixed,
    Free,
}

#[derive(Serialize, Deserialize)]
struct HeldRod(#[serde(with = "RodEndText")] RodEnd);

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BeamText {
    name: String,
    length: f64,
    elements: usize,
    flexural_rigidity: f64,
    mass_per_length: f64,
    ends: [HeldBeam; 2],
    #[serde(default)]
    mass: MassKind,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RodText {
    name: String,
    length: f64,
    elements: usize,
    axial_rigidity: f64,
    mass_per_length: f64,
    ends: [HeldRod; 2],
    #[serde(default)]
    mass: MassKind,
    #[serde(default, skip_serializing_if = "Unit::is_metre")]
    unit: Unit,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Damping {
    #[serde(skip_serializing_if = "Option::is_none")]
    rayleigh: Option<RayleighText>,
    #[serde(skip_serializing_if = "Option::is_none")]
    modal: Option<ModalText>,
}

impl Damping {
    fn is_empty(&self) -> bool {
        self.rayleigh.is_none() && self.modal.is_none()
    }
}

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RayleighText {
    mass: f64,
    stiffness: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    relative_to: Option<String>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ModalText {
    ratios: Vec<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    relative_to: Option<String>,
    /// Whether [`SystemBuilder::quick_modal_damping`] was asked for.
    #[serde(default, skip_serializing_if = "is_false")]
    quick: bool,
}

fn is_false(value: &bool) -> bool {
    !value
}

impl Description {
    /// `None` for matrices that are too large to be written out.
    fn of(given: &SystemBuilder) -> Option<Description> {
        let mut out = Description {
            supports: given.supports.clone(),
            ..Description::default()
        };
        let masses = given.masses.iter().enumerate();
        out.masses.extend(masses.map(|(i, (name, mass))| Mass {
            name: name.clone(),
            mass: *mass,
            unit: Unit::of(given.rotations.contains(&i)),
        }));
        for (kind, entries) in &given.matrices {
            let matrix = match entries {
                Entries::Dense(matrix) => matrix.clone(),
                Entries::Sparse(matrix) if matrix.nrows() <= MAX_DENSE_COORDINATES => {
                    matrix.to_dense()
                }
                Entries::Sparse(_) => return None,
            };
            let rows =
                (0..matrix.nrows()).map(|i| (0..matrix.ncols()).map(|j| matrix[(i, j)]).collect());
            *out.matrices.slot(*kind) = Some(rows.collect());
        }
        out.points.extend(given.points.iter().map(|point| {
            Point {
                name: point.name.clone(),
                moves: Moves(point.moves.clone()),
                mass: point.mass,
                unit: point
                    .kind
                    .map(|kind| Unit::of(kind == CoordinateKind::Rotation)),
            }
        }));
        for joint in &given.elements {
            let (between, name) = (joint.ends.clone(), joint.name.clone());
            match joint.kind {
                ElementKind::Spring => out.springs.push(Spring {
                    between,
                    stiffness: joint.coefficient,
                    name,
                }),
                ElementKind::Damper => out.dampers.push(Damper {
                    between,
                    damping: joint.coefficient,
                    name,
                }),
            }
        }
        out.beams.extend(given.beams.iter().map(|beam| BeamText {
            name: beam.name.clone(),
            length: beam.length,
            elements: beam.elements,
            flexural_rigidity: beam.flexural_rigidity,
            mass_per_length: beam.mass_per_length,
            ends: beam.ends.map(HeldBeam),
            mass: MassKind::of(beam.lumped),
        }));
        out.rods.extend(given.rods.iter().map(|rod| RodText {
            name: rod.name.clone(),
            length: rod.length,
            elements: rod.elements,
            axial_rigidity: rod.axial_rigidity,
            mass_per_length: rod.mass_per_length,
            ends: rod.ends.map(HeldRod),
            mass: MassKind::of(rod.lumped),
            unit: Unit::of(rod.twists),
        }));
        out.damping.rayleigh = given.rayleigh.as_ref().map(|rayleigh| RayleighText {
            mass: rayleigh.of_mass,
            stiffness: rayleigh.of_stiffness,
            relative_to: rayleigh.relative_to.clone(),
        });
        out.damping.modal = given.modal.as_ref().map(|modal| ModalText {
            ratios: modal.ratios.clone(),
            relative_to: modal.relative_to.clone(),
            quick: modal.in_double_double,
        });
        Some(out)
    }

    /// What is wrong, if a matrix is not rectangular.
    fn builder(mut self) -> Result<SystemBuilder, &'static str> {
        let mut builder = System::builder();
        for Mass { name, mass, unit } in self.masses {
            builder = match unit {
                Unit::Metre => builder.mass(name, mass),
                Unit::Radian => builder.rotation(name, mass),
            };
        }
        for kind in [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness] {
            let Some(rows) = self.matrices.slot(kind).take() else {
                continue;
            };
            let columns = rows.first().map_or(0, Vec::len);
            if rows.iter().any(|row| row.len() != columns) {
                return Err("the rows of a matrix have different lengths");
            }
            let matrix = Mat::from_fn(rows.len(), columns, |i, j| rows[i][j]);
            builder = builder.matrix(kind, matrix.as_ref());
        }
        for support in self.supports {
            builder = builder.support(support);
        }
        for point in self.points {
            builder = builder.point(point.name, point.moves.0, point.mass);
            builder = match point.unit {
                None => builder,
                Some(Unit::Metre) => builder.measuring(CoordinateKind::Displacement),
                Some(Unit::Radian) => builder.measuring(CoordinateKind::Rotation),
            };
        }
        let named = |builder: SystemBuilder, name: Option<String>| match name {
            Some(name) => builder.named(name),
            None => builder,
        };
        for spring in self.springs {
            let [first, second] = spring.between;
            builder = named(builder.spring(first, second, spring.stiffness), spring.name);
        }
        for damper in self.dampers {
            let [first, second] = damper.between;
            builder = named(builder.damper(first, second, damper.damping), damper.name);
        }
        for beam in self.beams {
            builder = builder.beam(Beam {
                name: beam.name,
                length: beam.length,
                elements: beam.elements,
                flexural_rigidity: beam.flexural_rigidity,
                mass_per_length: beam.mass_per_length,
                ends: beam.ends.map(|end| end.0),
                lumped: matches!(beam.mass, MassKind::Lumped),
            });
        }
        for rod in self.rods {
            builder = builder.rod(Rod {
                name: rod.name,
                length: rod.length,
                elements: rod.elements,
                axial_rigidity: rod.axial_rigidity,
                mass_per_length: rod.mass_per_length,
                ends: rod.ends.map(|end| end.0),
                lumped: matches!(rod.mass, MassKind::Lumped),
                twists: rod.unit == Unit::Radian,
            });
        }
        if let Some(rayleigh) = self.damping.rayleigh {
            let relative_to = rayleigh.relative_to.as_deref();
            builder = builder.rayleigh(rayleigh.mass, rayleigh.stiffness, relative_to);
        }
        if let Some(modal) = self.damping.modal {
            builder = builder.modal_damping(modal.ratios, modal.relative_to.as_deref());
            if modal.quick {
                builder = builder.quick_modal_damping();
            }
        }
        Ok(builder)
    }
}

impl Matrices {
    fn slot(&mut self, kind: MatrixKind) -> &mut Option<Vec<Vec<f64>>> {
        match kind {
            MatrixKind::Mass => &mut self.mass,
            MatrixKind::Damping => &mut self.damping,
            MatrixKind::Stiffness => &mut self.stiffness,
        }
    }
}

/// What the builder was given, under the keys of a scene file: `masses`, `matrices`, `supports`, `points`, `springs`, `dampers`,
/// `beams`, `rods` and `damping`; what scenes do not have is `quick` in `modal`, and `moves` as a list of pairs where a point names a
/// coordinate twice. An error for sparse matrices of more than [`MAX_DENSE_COORDINATES`] coordinates, and for
/// systems that were made from others.
impl Serialize for System {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let given = self.given.as_ref().ok_or_else(|| {
            S::Error::custom("the system was made from another, not by a builder")
        })?;
        let description = Description::of(given)
            .ok_or_else(|| S::Error::custom("the matrices are too large to be written out"))?;
        description.serialize(to)
    }
}

/// Checked as [`SystemBuilder::build`] does. Beyond the keys above nothing is allowed.
impl<'de> Deserialize<'de> for System {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<System, D::Error> {
        let description = Description::deserialize(from)?;
        let builder = description.builder().map_err(D::Error::custom)?;
        builder.build().map_err(D::Error::custom)
    }
}
