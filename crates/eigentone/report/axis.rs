//! Axes: from quantities to places on a drawing, with divisions that are easily read.

/// How an axis is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal lengths are equal differences.
    Linear,
    /// Equal lengths are equal ratios; only positive values can be shown.
    Logarithmic,
}

/// An axis: its label, with the unit, is `quantity, unit`.
#[derive(Clone, Debug)]
pub struct Axis {
    /// What is shown.
    pub quantity: String,
    /// Its unit, which a power of ten may precede; empty for a pure number.
    pub unit: String,
    /// How it is divided.
    pub scale: Scale,
}

impl Axis {
    /// An axis with equal divisions.
    pub fn linear(quantity: &str, unit: &str) -> Axis {
        Axis {
            quantity: quantity.to_owned(),
            unit: unit.to_owned(),
            scale: Scale::Linear,
        }
    }

    /// An axis of powers of ten.
    pub fn logarithmic(quantity: &str, unit: &str) -> Axis {
        Axis {
            scale: Scale::Logarithmic,
            ..Axis::linear(quantity, unit)
        }
    }
}

/// The span of a quantity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Range {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Range {
    pub(super) const NONE: Range = Range {
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
    };

    pub(super) fn include(&mut self, value: f64) {
        self.low = self.low.min(value);
        self.high = self.high.max(value);
    }
}

/// A division of an axis.
#[derive(Clone, Debug)]
pub(super) struct Tick {
    pub(super) at: f64,
    pub(super) label: String,
    pub(super) zero: bool,
}

/// From values to places on the drawing.
#[derive(Clone, Debug)]
pub(super) struct Ruler {
    scale: Scale,
    /// Values are divided by ten to this power first.
    pub(super) power: i32,
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) ticks: Vec<Tick>,
    pub(super) label: String,
}

impl Ruler {
    /// A ruler from place `from` to place `to` for the range, widened by `margin` of its width.
    pub(super) fn of(axis: &Axis, range: Range, margin: f64, from: f64, to: f64) -> Ruler {
        let range = if range.low <= range.high {
            range
        } else {
            Range {
                low: 1.0,
                high: 1.0,
            } // nothing to show
        };
        let mut ruler = Ruler {
            scale: axis.scale,
            power: 0,
            low: 0.0,
            high: 1.0,
            from,
            to,
            ticks: Vec::new(),
            label: String::new(),
        };
        match axis.scale {
            Scale::Linear => ruler.divide_evenly(range, margin),
            Scale::Logarithmic => ruler.divide_by_powers(range),
        }
        let unit = match (ruler.power, axis.unit.as_str()) {
            (0, unit) => unit.to_owned(),
            (power, unit) => format!("10{} {unit}", superscript(power)),
        };
        ruler.label = match unit.trim_end() {
            "" => axis.quantity.clone(),
            unit => format!("{}, {unit}", axis.quantity),
        };
        ruler
    }

    fn divide_evenly(&mut self, range: Range, margin: f64) {
        let largest = range.low.abs().max(range.high.abs());
        if largest > 0.0 {
            let leading = (largest.log10() + 1e-9).floor() as i32;
            if !(-2..5).contains(&leading) {
                self.power = leading.div_euclid(3) * 3;
            }
        }
        let (low, high) = (self.reduced(range.low), self.reduced(range.high));
        let width = high - low;
        // Below this the variation is rounding, and the line is a constant.
        let (low, high) = if width > 1e-11 * low.abs().max(high.abs()) {
            (low - margin * width, high + margin * width)
        } else if low == 0.0 && high == 0.0 {
            (-1.0, 1.0)
        } else {
            (low - 0.1 * low.abs(), high + 0.1 * high.abs())
        };
        (self.low, self.high) = (low, high);
        let step = nice_step((high - low) / 7.0);
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
        self.ticks = (first..=last)
            .map(|k| {
                let value = k as f64 * step;
                Tick {
                    at: self.between(value),
                    label: format!("{value:.decimals$}").replace('-', "−"),
                    zero: k == 0,
                }
            })
            .collect();
    }

    fn divide_by_powers(&mut self, range: Range) {
        let (mut low, mut high) = (range.low.log10(), range.high.log10());
        if high - low < 1.0 {
            // At least one whole power on each side, so that two labels show.
            (low, high) = (low.floor(), high.ceil().max(low.floor() + 1.0));
        } else {
            let margin = 0.03 * (high - low);
            (low, high) = (low - margin, high + margin);
        }
        (self.low, self.high) = (low, high);
        let each = ((high - low) / 9.0).ceil().max(1.0) as i32;
        // Where powers are few, their doubles and fivefolds too.
        let factors: &[u32] = if high - low <= 2.1 { &[1, 2, 5] } else { &[1] };
        let powers = (low.floor() as i32)..=(high.floor() as i32);
        let powers = powers.filter(|power| power.rem_euclid(each) == 0);
        let marks = powers.flat_map(|power| factors.iter().map(move |factor| (power, *factor)));
        let place = |(power, factor)| f64::from(power) + f64::from(factor).log10();
        let shown = marks.filter(|mark| (low..=high).contains(&place(*mark)));
        self.ticks = shown
            .map(|(power, factor)| Tick {
                at: self.between(place((power, factor))),
                label: match factor {
                    1 => format!("10{}", superscript(power)),
                    _ => format!("{factor}·10{}", superscript(power)),
                },
                zero: false,
            })
            .collect();
    }

    /// Leaves out ticks until there are no more than so many; the one at zero stays.
    pub(super) fn keep(&mut self, most: usize) {
        let each = self.ticks.len().div_ceil(most.max(1)).max(1);
        let zero = self.ticks.iter().position(|tick| tick.zero).unwrap_or(0);
        let mut index = 0;
        self.ticks.retain(|_| {
            index += 1;
            (index - 1) % each == zero % each
        });
    }

    /// The value in units of the power of ten that the label names.
    fn reduced(&self, value: f64) -> f64 {
        // In two parts, for 10^308 is the last power that a double has.
        let half = self.power / 2;
        value / 10f64.powi(half) / 10f64.powi(self.power - half)
    }

    pub(super) fn place(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => self.between(self.reduced(value)),
            Scale::Logarithmic => self.between(value.log10()),
        }
    }

    fn between(&self, value: f64) -> f64 {
        self.from + (value - self.low) / (self.high - self.low) * (self.to - self.from)
    }
}

/// The least of 1, 2, 5 times a power of ten that is not below `least`.
fn nice_step(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    let mut steps = [1.0, 2.0, 5.0].into_iter().map(|factor| factor * power);
    steps
        .find(|step| *step >= least * (1.0 - 1e-12))
        .unwrap_or(10.0 * power)
}

/// An exponent.
pub(super) fn superscript(power: i32) -> String {
    let digit = |c| match c {
        '-' => '⁻',
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        _ => '⁹',
    };
    power.to_string().chars().map(digit).collect()
}
