//! Numbers of every size that a double has.

use super::choices::Choices;

/// How far the numbers of one scene lie apart.
#[derive(Clone, Copy, Debug)]
pub enum Spread {
    /// All of them are the same.
    None,
    /// Small whole numbers.
    Whole,
    /// From 10^-k to 10^k.
    Decades(u8),
    /// Any finite double, those below 2.2e-308 included.
    Any,
}

impl Spread {
    pub fn draw(choices: &mut Choices<'_>) -> Spread {
        match choices.below(8) {
            0 | 1 => Spread::Whole,
            2 => Spread::None,
            3 => Spread::Decades(1),
            4 => Spread::Decades(6),
            5 => Spread::Decades(20),
            6 => Spread::Decades(150),
            _ => Spread::Any,
        }
    }

    /// A number that is greater than 0.
    pub fn positive(self, choices: &mut Choices<'_>) -> f64 {
        const EDGES: [f64; 8] = [
            5e-324,
            2.2250738585072014e-308,
            1e-300,
            1e-160,
            1.0,
            1e160,
            1e300,
            f64::MAX,
        ];
        match self {
            Spread::None => 2.0,
            Spread::Whole => 1.0 + choices.below(9) as f64,
            Spread::Decades(decades) => {
                let exponent = (2.0 * choices.fraction() - 1.0) * f64::from(decades);
                10f64.powf(exponent)
            }
            Spread::Any => match choices.below(3) {
                0 => choices.pick(&EDGES),
                1 => 10f64.powf(600.0 * choices.fraction() - 300.0),
                _ => {
                    let value = f64::from_bits(choices.bits()).abs();
                    let usable = value.is_finite() && value > 0.0;
                    if usable { value } else { 1.0 }
                }
            },
        }
    }

    /// Mostly positive, now and then 0 or negative.
    pub fn coefficient(self, choices: &mut Choices<'_>) -> f64 {
        match choices.below(24) {
            22 => 0.0,
            23 => -self.positive(choices),
            _ => self.positive(choices),
        }
    }

    /// Of either sign, or 0.
    pub fn signed(self, choices: &mut Choices<'_>) -> f64 {
        match choices.below(5) {
            0 | 1 => self.positive(choices),
            2 | 3 => -self.positive(choices),
            _ => 0.0,
        }
    }
}
