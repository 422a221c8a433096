//! Motions as text.

use eigentone_modes::Bounds;
use faer::MatRef;
use serde::{Serialize, Serializer};

use super::Trajectory;

/// A list for each coordinate.
struct Rows<'a>(MatRef<'a, f64>);

impl Serialize for Rows<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let rows = self.0.row_iter();
        to.collect_seq(rows.map(|row| row.iter().copied().collect::<Vec<f64>>()))
    }
}

/// The keys of `eigentone response --json`, with a list for each coordinate in order.
/// Nothing reads it back: what is proven rests on the problem.
impl Serialize for Trajectory {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Output<'a> {
            name: &'a str,
            value: &'a [f64],
            bound: &'a [Option<f64>],
        }
        #[derive(Serialize)]
        struct Text<'a> {
            bounds: Bounds,
            method: &'a str,
            step: &'a [u64],
            time: &'a [f64],
            displacement: Rows<'a>,
            velocity: Rows<'a>,
            displacement_bound: &'a [Option<f64>],
            velocity_bound: &'a [Option<f64>],
            #[serde(skip_serializing_if = "Option::is_none")]
            acceleration: Option<Rows<'a>>,
            #[serde(skip_serializing_if = "<[_]>::is_empty")]
            acceleration_bound: &'a [Option<f64>],
            #[serde(skip_serializing_if = "Vec::is_empty")]
            outputs: Vec<Output<'a>>,
        }
        let outputs = self.outputs().enumerate().map(|(i, name)| Output {
            name,
            value: self.output(i),
            bound: self.output_bound(i),
        });
        Text {
            bounds: self.bounds(),
            method: self.method(),
            step: self.steps(),
            time: self.times(),
            displacement: Rows(self.displacement()),
            velocity: Rows(self.velocity()),
            displacement_bound: self.displacement_bound(),
            velocity_bound: self.velocity_bound(),
            acceleration: self.acceleration().map(Rows),
            acceleration_bound: self.acceleration_bound(),
            outputs: outputs.collect(),
        }
        .serialize(to)
    }
}
