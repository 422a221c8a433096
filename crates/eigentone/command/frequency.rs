//! Frequencies as people write them: 88, 88rad/s or 14Hz.

use std::f64::consts::TAU;
use std::str::FromStr;

/// A frequency of 0 or more, and the unit if one is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    value: f64,
    hertz: Option<bool>,
}

impl Asked {
    /// In rad/s; what has no unit is in Hz if so said.
    pub fn radians_per_second(self, plain_is_hertz: bool) -> f64 {
        match self.hertz.unwrap_or(plain_is_hertz) {
            true => self.value * TAU,
            false => self.value,
        }
    }
}

impl FromStr for Asked {
    type Err = String;

    fn from_str(text: &str) -> Result<Asked, String> {
        let text = text.trim();
        let (number, hertz) = match (text.strip_suffix("Hz"), text.strip_suffix("rad/s")) {
            (Some(number), _) => (number, Some(true)),
            (_, Some(number)) => (number, Some(false)),
            _ => (text, None),
        };
        match number.trim_end().parse::<f64>() {
            Ok(value) if (value * TAU).is_finite() && value >= 0.0 => Ok(Asked { value, hertz }),
            _ => Err(
                "write a finite number of rad/s, 0 or more, or one with its unit, as 88, 88rad/s or 14Hz"
                    .to_owned(),
            ),
        }
    }
}
