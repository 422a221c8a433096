//! The gallery: scenes with answers known to 34 digits, shared by tests, benches, checks and docs.
//!
//! The answers were computed in rigorous ball arithmetic from the exact values of each scene's
//! doubles; those of scenes with switches by a simulation with 60 digits that finds events by
//! bisection. A case is a pair of files in `tests/gallery`: `scenes/NAME.json` and
//! `truth/NAME.json`, of [machines] in `tests/gallery/machines`, and of [switches] in
//! `tests/gallery/switches`.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use eigentone_digits::{Real, Wide};
use serde::Deserialize;

use crate::scene::Scene;

/// A scene and its answers.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    name: &'static str,
    scene: &'static str,
    truth: &'static str,
}

impl Case {
    /// The case's name: that of its files, without their extension.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// The scene file's text.
    pub fn scene_text(&self) -> &'static str {
        self.scene
    }

    /// The text of the file of answers.
    pub fn truth_text(&self) -> &'static str {
        self.truth
    }

    /// The scene.
    pub fn scene(&self) -> Scene {
        Scene::parse(self.scene, Path::new(self.name)).expect("tests/gallery.rs reads every scene")
    }

    /// The answers.
    pub fn truth(&self) -> Truth {
        serde_json::from_str(self.truth).expect("tests/gallery.rs reads all answers")
    }
}

/// What is known of a scene.
#[derive(Clone, Debug, Deserialize)]
#[non_exhaustive]
pub struct Truth {
    /// The names of the coordinates, in order.
    pub coordinates: Vec<String>,
    /// Every finite eigenvalue λ in 1/s, conjugates and repeats included; none where the scene has switches.
    #[serde(default)]
    pub eigenvalues: Vec<TrueEigenvalue>,
    /// The motion at some instants; empty where the scene asks for none.
    #[serde(default)]
    pub response: Vec<TrueSample>,
    /// The events, by time, where the scene has switches.
    #[serde(default)]
    pub events: Vec<TrueEvent>,
}

/// A finite eigenvalue. One of multiplicity m is listed m times.
#[derive(Clone, Debug, Deserialize)]
#[serde(from = "(Decimal, Decimal, usize)")]
#[non_exhaustive]
pub struct TrueEigenvalue {
    /// Its real part, in 1/s.
    pub re: Decimal,
    /// Its imaginary part, in rad/s.
    pub im: Decimal,
    /// Its algebraic multiplicity.
    pub multiplicity: usize,
}

impl From<(Decimal, Decimal, usize)> for TrueEigenvalue {
    fn from((re, im, multiplicity): (Decimal, Decimal, usize)) -> TrueEigenvalue {
        TrueEigenvalue {
            re,
            im,
            multiplicity,
        }
    }
}

/// An event of a motion with switches.
#[derive(Clone, Debug, Deserialize)]
#[non_exhaustive]
pub struct TrueEvent {
    /// In s.
    pub time: Decimal,
    /// The place of the switch in the scene.
    pub element: String,
    /// What happens.
    pub what: String,
}

/// The motion at the instant `step` times the scene's `time.step`.
#[derive(Clone, Debug, Deserialize)]
#[non_exhaustive]
pub struct TrueSample {
    /// The index of the instant.
    pub step: u64,
    /// Displacements in m, one for each coordinate.
    pub displacement: Vec<Decimal>,
    /// Velocities in m/s, one for each coordinate.
    pub velocity: Vec<Decimal>,
    /// The outputs of the scene, by name.
    #[serde(default)]
    pub outputs: BTreeMap<String, Decimal>,
}

/// A decimal number with more digits than a double has.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub struct Decimal(String);

impl Decimal {
    /// Its digits.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The double nearest to it.
    pub fn to_f64(&self) -> f64 {
        self.0.parse().expect("checked when it was read")
    }

    /// How much it is more than `value`, to within 1e-70 of itself and a unit of rounding of the difference: what an error in a
    /// double is measured with.
    pub fn minus(&self, value: f64) -> f64 {
        (self.to_wide() - Wide::from(value)).to_f64()
    }

    fn to_wide(&self) -> Wide<4> {
        const DIGITS_AT_ONCE: usize = 15; // exact in a double
        if self.to_f64() == 0.0 {
            return Wide::ZERO;
        }
        let (mantissa, exponent) = self.0.split_once(['e', 'E']).unwrap_or((&self.0, "0"));
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let exponent: i32 = exponent.parse().expect("a number's exponent is whole");
        let digits: Vec<u8> = whole.bytes().chain(fraction.bytes()).collect();
        let digits: Vec<u8> = digits.into_iter().filter(u8::is_ascii_digit).collect();
        let mut value = Wide::ZERO;
        for chunk in digits.chunks(DIGITS_AT_ONCE) {
            let number = chunk
                .iter()
                .fold(0.0, |sum, digit| 10.0 * sum + f64::from(digit - b'0'));
            value = value * power_of_ten(chunk.len() as u32) + Wide::from(number);
        }
        // In two steps, so that no power on the way leaves the range of doubles.
        let shift = exponent - fraction.len() as i32;
        for part in [shift / 2, shift - shift / 2] {
            let power = power_of_ten(part.unsigned_abs());
            value = if part < 0 {
                value / power
            } else {
                value * power
            };
        }
        if mantissa.starts_with('-') {
            -value
        } else {
            value
        }
    }
}

fn power_of_ten(exponent: u32) -> Wide<4> {
    let mut power = Wide::from(1.0);
    let mut square = Wide::from(10.0);
    let mut rest = exponent;
    while rest > 0 {
        if rest % 2 == 1 {
            power = power * square;
        }
        square = square * square;
        rest /= 2;
    }
    power
}

impl TryFrom<String> for Decimal {
    type Error = std::num::ParseFloatError;

    fn try_from(text: String) -> Result<Decimal, Self::Error> {
        text.parse::<f64>()?;
        Ok(Decimal(text))
    }
}

impl fmt::Display for Decimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

macro_rules! cases {
    ($folder:literal: $($name:literal),* $(,)?) => {
        &[$(Case {
            name: $name,
            scene: include_str!(concat!("../../tests/", $folder, "/scenes/", $name, ".json")),
            truth: include_str!(concat!("../../tests/", $folder, "/truth/", $name, ".json")),
        }),*]
    };
}

/// Scenes of machines, in the order of their names: points that move with several coordinates, supports that move, damping
/// of the whole, and outputs.
pub fn machines() -> &'static [Case] {
    cases!["gallery/machines":
        "analogy-cantilever",
        "analogy-circuit",
        "analogy-pendulum",
        "analogy-rotation",
        "analogy-translation",
        "cantilever",
        "carried-mass",
        "double-pendulum",
        "drive-train",
        "half-car",
        "inclined-springs",
        "lever",
        "quarter-car-bump",
        "quarter-car-kerb",
        "shaft",
        "shaken-building",
    ]
}

/// Scenes with switches, in the order of their names: their truths have motions and events, and no roots.
pub fn switches() -> &'static [Case] {
    cases!["gallery/switches":
        "belt-stick-slip",
        "friction-two-mass",
        "hardening-stops",
        "impact-two-mass",
        "quarter-car-clipped",
    ]
}

/// Every case but the [machines] and [switches], in the order of their names.
///
/// ```
/// use eigentone::gallery::cases;
///
/// for case in cases() {
///     let (scene, truth) = (case.scene(), case.truth());
///     let modes = scene.system().modes()?;
///     assert_eq!(modes.eigenvalues().len(), truth.eigenvalues.len());
///     println!("{}: {} roots", case.name(), truth.eigenvalues.len());
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn cases() -> &'static [Case] {
    cases!["gallery":
        "alternating-1e12",
        "free-free",
        "mass-ratio",
        "micro-units",
        "one-mass-critical",
        "one-mass-overdamped",
        "one-mass-resonance",
        "one-mass-undamped",
        "one-mass-underdamped",
        "sampled-first",
        "sampled-zero",
        "stiff-contact",
        "stiff-overdamped",
        "three-mass-1",
        "three-mass-2",
        "three-mass-3",
        "three-mass-4",
        "three-mass-5",
        "three-mass-6",
        "triple-defect",
        "two-mass-forced",
        "two-mass-free",
        "two-mass-modified-forced",
        "two-mass-modified-free",
        "undamped-long",
    ]
}

#[cfg(test)]
mod tests {
    use super::Decimal;

    fn decimal(text: &str) -> Decimal {
        Decimal::try_from(text.to_owned()).expect("a number")
    }

    #[test]
    fn difference_from_a_double_keeps_its_digits() {
        // The double nearest to 0.1 is 0.1000000000000000055511151231257827021181583404541015625.
        let tenth = 5.551_115_123_125_783e-18;
        assert_eq!(decimal("0.1").minus(0.1), -tenth);
        assert_eq!(decimal("-0.1").minus(-0.1), tenth);
        assert_eq!(decimal("1.00e-1").minus(0.1), -tenth);
        let nearest = "0.1000000000000000055511151231257827021181583404541015625";
        assert!(decimal(nearest).minus(0.1).abs() <= 1e-30);
        // 1e23 is no double; the nearest one is 8388608 less.
        assert_eq!(decimal("1e23").minus(1e23), 8_388_608.0);
        assert_eq!(
            decimal("-2.000000000000000000000000000000000").minus(-2.0),
            0.0
        );
        assert_eq!(decimal("0").minus(0.0), 0.0);
    }

    #[test]
    fn the_smallest_numbers_stay_in_range() {
        let tiny = decimal("1.234567890123456789012345678901234e-310");
        assert!(tiny.minus(tiny.to_f64()).abs() <= 1e-320);
        assert_eq!(decimal("-1.5e-2000").minus(0.0), 0.0);
        let huge = decimal("1.234567890123456789012345678901234e+307");
        assert!(huge.minus(huge.to_f64()).abs() <= 1.2e-16 * 1.3e307);
    }
}
