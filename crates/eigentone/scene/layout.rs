//! The layout of a scene file: the keys of each object, and what belongs under them.

use serde::Deserialize;

use super::shape::{
    BeamEnd, ByName, Column, Count, DamperLaw, Hold, List, MassKind, Matrix, Number, Object,
    OneOrMore, Ratios, RodEnd, Spacing, Text, Two, Unit, Values, given,
};

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Scene {
    /// For editors.
    #[serde(rename = "$schema", deserialize_with = "given")]
    pub(super) _schema: Option<Text>,
    #[serde(deserialize_with = "given")]
    pub(super) title: Option<Text>,
    #[serde(deserialize_with = "given")]
    pub(super) masses: Option<List<Object<Mass>>>,
    #[serde(deserialize_with = "given")]
    pub(super) matrices: Option<Object<Matrices>>,
    pub(super) springs: List<Object<Spring>>,
    pub(super) dampers: List<Object<Damper>>,
    pub(super) points: List<Object<Point>>,
    pub(super) supports: List<Text>,
    pub(super) beams: List<Object<Beam>>,
    pub(super) rods: List<Object<Rod>>,
    #[serde(deserialize_with = "given")]
    pub(super) damping: Option<Object<Damping>>,
    pub(super) initial: ByName<Object<State>>,
    pub(super) loads: List<Object<Load>>,
    pub(super) motions: List<Object<Motion>>,
    pub(super) outputs: List<Object<Output>>,
    #[serde(deserialize_with = "given")]
    pub(super) time: Option<Object<Time>>,
    #[serde(deserialize_with = "given")]
    pub(super) frequencies: Option<Object<Frequencies>>,
    pub(super) noise: List<Object<Noise>>,
    pub(super) frictions: List<Object<Friction>>,
    pub(super) stops: List<Object<Stop>>,
    pub(super) impacts: List<Object<Impact>>,
    pub(super) controlled_dampers: List<Object<ControlledDamper>>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Friction {
    pub(super) between: Two<Text>,
    pub(super) force: Number,
    #[serde(rename = "static", default, deserialize_with = "given")]
    pub(super) static_force: Option<Number>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Stop {
    pub(super) between: Two<Text>,
    pub(super) gap: Number,
    pub(super) stiffness: Number,
    #[serde(default)]
    pub(super) damping: Number,
}

#[derive(Debug, Deserialize)]
pub(super) struct Impact {
    pub(super) between: Two<Text>,
    pub(super) gap: Number,
    pub(super) restitution: Number,
}

#[derive(Debug, Deserialize)]
pub(super) struct ControlledDamper {
    pub(super) between: Two<Text>,
    pub(super) law: DamperLaw,
    pub(super) low: Number,
    pub(super) high: Number,
    #[serde(default, deserialize_with = "given")]
    pub(super) sky: Option<Number>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Mass {
    pub(super) name: Text,
    pub(super) mass: Number,
    #[serde(default)]
    pub(super) unit: Unit,
}

#[derive(Debug, Deserialize)]
pub(super) struct Point {
    pub(super) name: Text,
    pub(super) moves: ByName<Number>,
    #[serde(default)]
    pub(super) mass: Number,
    #[serde(default, deserialize_with = "given")]
    pub(super) unit: Option<Unit>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Spring {
    pub(super) between: Two<Text>,
    pub(super) stiffness: Number,
    #[serde(default, deserialize_with = "given")]
    pub(super) name: Option<Text>,
    #[serde(default)]
    pub(super) loss_factor: Number,
}

#[derive(Debug, Deserialize)]
pub(super) struct Damper {
    pub(super) between: Two<Text>,
    pub(super) damping: Number,
    #[serde(default, deserialize_with = "given")]
    pub(super) name: Option<Text>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Beam {
    pub(super) name: Text,
    pub(super) length: Number,
    pub(super) elements: Count,
    pub(super) flexural_rigidity: Number,
    pub(super) mass_per_length: Number,
    pub(super) ends: Two<BeamEnd>,
    #[serde(default)]
    pub(super) mass: MassKind,
}

#[derive(Debug, Deserialize)]
pub(super) struct Rod {
    pub(super) name: Text,
    pub(super) length: Number,
    pub(super) elements: Count,
    pub(super) axial_rigidity: Number,
    pub(super) mass_per_length: Number,
    pub(super) ends: Two<RodEnd>,
    #[serde(default)]
    pub(super) mass: MassKind,
    #[serde(default)]
    pub(super) unit: Unit,
}

#[derive(Debug, Deserialize)]
pub(super) struct Damping {
    #[serde(default, deserialize_with = "given")]
    pub(super) rayleigh: Option<Object<Rayleigh>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) modal: Option<Ratios<Modal>>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Rayleigh {
    pub(super) mass: Number,
    pub(super) stiffness: Number,
    #[serde(deserialize_with = "given")]
    pub(super) relative_to: Option<Text>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Matrices {
    #[serde(default, deserialize_with = "given")]
    pub(super) mass: Option<Matrix>,
    #[serde(default, deserialize_with = "given")]
    pub(super) damping: Option<Matrix>,
    #[serde(default, deserialize_with = "given")]
    pub(super) stiffness: Option<Matrix>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct State {
    pub(super) displacement: Number,
    pub(super) velocity: Number,
}

#[derive(Debug, Deserialize)]
pub(super) struct Load {
    pub(super) on: Text,
    #[serde(default, deserialize_with = "given")]
    pub(super) step: Option<Object<Step>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) ramp: Option<Object<Ramp>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) impulse: Option<Object<Impulse>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) harmonic: Option<Object<Harmonic>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) half_sine: Option<Object<Push>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) versine: Option<Object<Push>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) polynomial: Option<Object<Polynomial>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) samples: Option<Object<Samples>>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Motion {
    pub(super) of: Text,
    #[serde(default, deserialize_with = "given")]
    pub(super) displacement: Option<Object<Course>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) velocity: Option<Object<Course>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) acceleration: Option<Object<Course>>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Noise {
    #[serde(default, deserialize_with = "given")]
    pub(super) on: Option<Text>,
    #[serde(default, deserialize_with = "given")]
    pub(super) of: Option<Text>,
    #[serde(default, deserialize_with = "given")]
    pub(super) force: Option<Number>,
    #[serde(default, deserialize_with = "given")]
    pub(super) displacement: Option<Number>,
    #[serde(default, deserialize_with = "given")]
    pub(super) velocity: Option<Number>,
    #[serde(default, deserialize_with = "given")]
    pub(super) acceleration: Option<Number>,
    #[serde(default, deserialize_with = "given")]
    pub(super) band: Option<List<Number>>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Course {
    #[serde(default, deserialize_with = "given")]
    pub(super) step: Option<Object<Rise>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) ramp: Option<Object<Ramp>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) harmonic: Option<Object<Harmonic>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) half_sine: Option<Object<Bump>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) versine: Option<Object<Bump>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) polynomial: Option<Object<Polynomial>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) samples: Option<Object<Samples>>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Output {
    pub(super) name: Text,
    #[serde(default, deserialize_with = "given")]
    pub(super) displacement: Option<ByName<Number>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) velocity: Option<ByName<Number>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) acceleration: Option<ByName<Number>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) force: Option<Text>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Step {
    pub(super) force: Number,
    #[serde(default)]
    pub(super) start: Number,
}

#[derive(Debug, Deserialize)]
pub(super) struct Rise {
    pub(super) height: Number,
    #[serde(default)]
    pub(super) start: Number,
}

#[derive(Debug, Deserialize)]
pub(super) struct Push {
    pub(super) force: Number,
    pub(super) duration: Number,
    #[serde(default)]
    pub(super) start: Number,
}

#[derive(Debug, Deserialize)]
pub(super) struct Bump {
    pub(super) height: Number,
    pub(super) duration: Number,
    #[serde(default)]
    pub(super) start: Number,
}

#[derive(Debug, Deserialize)]
pub(super) struct Ramp {
    pub(super) rate: Number,
    #[serde(default)]
    pub(super) start: Number,
}

#[derive(Debug, Deserialize)]
pub(super) struct Polynomial {
    pub(super) coefficients: List<Number>,
    #[serde(default)]
    pub(super) start: Number,
}

#[derive(Debug, Deserialize)]
pub(super) struct Impulse {
    pub(super) magnitude: Number,
    #[serde(default)]
    pub(super) at: Number,
}

#[derive(Debug, Deserialize)]
pub(super) struct Harmonic {
    pub(super) amplitude: Number,
    pub(super) frequency: Number,
    #[serde(default)]
    pub(super) phase: Number,
}

#[derive(Debug, Deserialize)]
pub(super) struct Samples {
    pub(super) step: Number,
    pub(super) values: Values<Record>,
    pub(super) hold: Hold,
}

#[derive(Debug, Deserialize)]
pub(super) struct Record {
    pub(super) file: Text,
    #[serde(default)]
    pub(super) column: Column,
}

#[derive(Debug, Deserialize)]
pub(super) struct Modal {
    pub(super) ratios: OneOrMore,
    #[serde(default, deserialize_with = "given")]
    pub(super) relative_to: Option<Text>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Time {
    pub(super) end: Number,
    pub(super) step: Number,
}

#[derive(Debug, Deserialize)]
pub(super) struct Frequencies {
    pub(super) from: Number,
    pub(super) to: Number,
    pub(super) count: Number,
    #[serde(default)]
    pub(super) spacing: Spacing,
}
