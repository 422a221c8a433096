//! Modes as text: names and order are what `eigentone modes --json` prints, and stay.

use num_complex::Complex;
use serde::{Serialize, Serializer};

use super::{Bounds, Eigenvalue, Mode, Modes, Motion};

impl Serialize for Bounds {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(match self {
            Bounds::Proven => "proven",
            Bounds::Estimated => "estimated",
        })
    }
}

impl Serialize for Motion {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

#[derive(Serialize)]
struct ComplexText {
    re: f64,
    im: f64,
}

impl From<&Complex<f64>> for ComplexText {
    fn from(value: &Complex<f64>) -> ComplexText {
        ComplexText {
            re: value.re,
            im: value.im,
        }
    }
}

/// `re`, `im`, `bound` and `real_bound`, and `doubtful` where no meaningful bound is known.
impl Serialize for Eigenvalue {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Text {
            re: f64,
            im: f64,
            bound: Option<f64>,
            real_bound: Option<f64>,
            #[serde(skip_serializing_if = "Option::is_none")]
            doubtful: Option<bool>,
        }
        Text {
            re: self.value.re,
            im: self.value.im,
            bound: self.bound,
            real_bound: self.real_bound,
            doubtful: self.is_doubtful().then_some(true),
        }
        .serialize(to)
    }
}

/// What `eigentone modes --json` prints of a mode.
impl Serialize for Mode {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Text<'a> {
            motion: Motion,
            natural_frequency: f64,
            damped_frequency: f64,
            damping_ratio: Option<f64>,
            time_constant: Option<f64>,
            eigenvalue: ComplexText,
            multiplicity: Option<usize>,
            /// There where the multiplicity is not.
            #[serde(skip_serializing_if = "Option::is_none")]
            cluster: Option<usize>,
            defective: Option<bool>,
            shape: Vec<ComplexText>,
            shape_bound: Option<&'a [f64]>,
            backward_error: f64,
            condition: Option<f64>,
        }
        Text {
            motion: self.motion(),
            natural_frequency: self.natural_frequency().radians_per_second(),
            damped_frequency: self.damped_frequency().radians_per_second(),
            damping_ratio: self.damping_ratio(),
            time_constant: self.time_constant(),
            eigenvalue: (&self.eigenvalue.value).into(),
            multiplicity: self.multiplicity(),
            cluster: self.cluster(),
            defective: self.is_defective(),
            shape: self.shape().iter().map(ComplexText::from).collect(),
            shape_bound: self.shape_bound(),
            backward_error: self.backward_error(),
            condition: self.condition(),
        }
        .serialize(to)
    }
}

/// What `eigentone modes --json` prints of all modes. Nothing reads it back: what is proven rests on the system.
impl Serialize for Modes {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Text<'a> {
            bounds: Bounds,
            eigenvalues: &'a [Eigenvalue],
            infinite: usize,
            complete: bool,
            modes: &'a [Mode],
        }
        Text {
            bounds: self.bounds(),
            eigenvalues: self.eigenvalues(),
            infinite: self.infinite(),
            complete: self.is_complete(),
            modes: self.as_slice(),
        }
        .serialize(to)
    }
}
