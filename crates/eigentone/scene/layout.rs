//! The layout of a scene file: the keys of each object, and what belongs under them.

use serde::Deserialize;

use super::shape::{ByName, Hold, List, Matrix, Number, Object, Text, Two, given};

#[derive(Debug, Deserialize)]
pub(super) struct Scene {
    #[serde(default, deserialize_with = "given")]
    pub(super) title: Option<Text>,
    #[serde(default, deserialize_with = "given")]
    pub(super) masses: Option<List<Object<Mass>>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) matrices: Option<Object<Matrices>>,
    #[serde(default)]
    pub(super) springs: List<Object<Spring>>,
    #[serde(default)]
    pub(super) dampers: List<Object<Damper>>,
    #[serde(default)]
    pub(super) initial: ByName<Object<Motion>>,
    #[serde(default)]
    pub(super) loads: List<Object<Load>>,
    #[serde(default, deserialize_with = "given")]
    pub(super) time: Option<Object<Time>>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Mass {
    pub(super) name: Text,
    pub(super) mass: Number,
}

#[derive(Debug, Deserialize)]
pub(super) struct Spring {
    pub(super) between: Two,
    pub(super) stiffness: Number,
}

#[derive(Debug, Deserialize)]
pub(super) struct Damper {
    pub(super) between: Two,
    pub(super) damping: Number,
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

#[derive(Debug, Deserialize)]
pub(super) struct Motion {
    #[serde(default)]
    pub(super) displacement: Number,
    #[serde(default)]
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
    pub(super) samples: Option<Object<Samples>>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Step {
    pub(super) force: Number,
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
    pub(super) values: List<Number>,
    pub(super) hold: Hold,
}

#[derive(Debug, Deserialize)]
pub(super) struct Time {
    pub(super) end: Number,
    pub(super) step: Number,
}
