//! What is notable in a frequency response function: where its magnitude is largest or least, how wide its peaks are, and
//! what becomes of it at low and high frequencies.

use eigentone_digits::DoubleDouble;

use super::dynamic_stiffness::Frequency;
use super::enclosure::Value;

/// A frequency at which a magnitude is largest, or least, among those around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    frequency: (f64, f64),
    gain: Option<(f64, f64)>,
    half_power: Option<[f64; 2]>,
}

impl Peak {
    /// Ω in rad/s: the double nearest to the true place, and a proven bound of how far it is from there.
    pub fn frequency(&self) -> (f64, f64) {
        self.frequency
    }

    /// The magnitude there, and a proven bound of its error; `None` where it is infinite, or a peak is narrower than 1e-25
    /// of its frequency.
    pub fn gain(&self) -> Option<(f64, f64)> {
        self.gain
    }

    /// The frequencies below and above a peak at which the magnitude is 1/√2 of it, in rad/s, to the last digits; `None`
    /// for a dip, and where the magnitude does not fall so far before it rises again.
    pub fn half_power(&self) -> Option<[f64; 2]> {
        self.half_power
    }

    /// The difference of the half-power frequencies over the frequency of the peak: the loss factor, and nearly 2ζ of a
    /// mode that stands by itself (Ewins 2000, *Modal Testing*, section 4.3.2).
    pub fn relative_width(&self) -> Option<f64> {
        self.half_power
            .map(|[low, high]| (high - low) / self.frequency.0)
    }
}

/// What a magnitude tends to: coefficient·Ω^power.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asymptote {
    /// In the unit of the function, and that of Ω.
    pub coefficient: f64,
    /// A whole number.
    pub power: i32,
}

/// What is notable in a frequency response function.
///
/// Peaks and dips are zeros of d|H|²/dΩ, each enclosed by proven signs on both sides. They are sought between frequencies
/// given: two that lie between the same neighbours are not seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Features {
    peaks: Vec<Peak>,
    dips: Vec<Peak>,
    low: Option<Asymptote>,
    high: Option<Asymptote>,
}

impl Features {
    /// Where the magnitude is largest among those around it: resonances, by rising frequency.
    pub fn peaks(&self) -> &[Peak] {
        &self.peaks
    }

    /// Where it is least: antiresonances, and what lies between two peaks, by rising frequency.
    pub fn dips(&self) -> &[Peak] {
        &self.dips
    }

    /// The largest magnitude of all peaks; `None` where there are none, or one is infinite.
    pub fn largest(&self) -> Option<&Peak> {
        let gain = |peak: &Peak| peak.gain.map_or(f64::INFINITY, |(gain, _)| gain);
        let largest = self.peaks.iter().max_by(|a, b| gain(a).total_cmp(&gain(b)));
        largest.filter(|peak| peak.gain.is_some())
    }

    /// What the magnitude tends to at low frequencies: power 0 is a static value. `None` for a function that is 0.
    pub fn low(&self) -> Option<Asymptote> {
        self.low
    }

    /// What it tends to at high frequencies: a receptance falls with Ω⁻² at the driven mass, and faster elsewhere.
    pub fn high(&self) -> Option<Asymptote> {
        self.high
    }

    /// By looks at single frequencies and their neighbourhood, between those of the grid, which rises.
    pub(super) fn of(look: &Look<'_>, grid: &[f64]) -> Features {
        let mut features = Features {
            peaks: Vec::new(),
            dips: Vec::new(),
            low: None,
            high: None,
        };
        let steep = |frequency: f64| look(frequency.into()).and_then(|value| rise(&value));
        let known = grid.iter().filter(|frequency| **frequency > 0.0);
        let known: Vec<(f64, f64)> = known
            .filter_map(|&frequency| Some((frequency, steep(frequency)?)))
            .collect();
        for pair in known.windows(2) {
            let [(low, before), (high, after)] = [pair[0], pair[1]];
            if before > 0.0 && after < 0.0 {
                features
                    .peaks
                    .extend(turn(look, [low, high], [before, after]));
            } else if before < 0.0 && after > 0.0 {
                features
                    .dips
                    .extend(turn(look, [low, high], [before, after]));
            }
        }
        let (Some(first), Some(last)) = (known.first(), known.last()) else {
            return features;
        };
        for peak in &mut features.peaks {
            let ends = [first.0, last.0];
            peak.half_power = peak.gain.and_then(|(gain, _)| {
                half_power(look, peak.frequency.0, gain, &features.dips, ends)
            });
        }
        features.low = asymptote(look, first.0 * FAR.recip());
        features.high = asymptote(look, last.0 * FAR);
        features
    }
}

/// The value at a frequency; `None` at a pole.
pub(super) type Look<'a> = dyn Fn(Frequency) -> Option<Value> + 'a;

/// 2^40: corrections of asymptotes are of its square.
const FAR: f64 = 1_099_511_627_776.0;

/// How steeply the logarithm of the magnitude rises, if its sign is sure.
fn rise(value: &Value) -> Option<f64> {
    let (rise, off) = value.steepness?;
    (rise.abs() > off).then_some(rise)
}

/// The zero of the steepness between two frequencies at which its signs differ.
fn turn(look: &Look<'_>, [low, high]: [f64; 2], [before, after]: [f64; 2]) -> Option<Peak> {
    const MOST: usize = 160;
    /// Within it the steepness is a straight line, to its square.
    const STRAIGHT: f64 = 1e-5;
    let (mut low, mut high) = (DoubleDouble::from(low), DoubleDouble::from(high));
    let (mut before, mut after) = (before, after);
    let at = |middle: DoubleDouble| {
        look(Frequency {
            middle,
            radius: 0.0,
        })
    };
    for k in 0..MOST {
        let width = (high - low).to_f64();
        let steep = before.abs().max(after.abs()) * width;
        if steep < STRAIGHT || width <= high.to_f64() * 1e-27 {
            break;
        }
        // Far from a narrow peak its steepness is as 1/x, and on it as −x.
        let share = match steep > 1.0 {
            true => after / (after - before),
            false => before / (before - after),
        };
        // One step in three halves, so that none is lost.
        let share = if k % 3 == 2 {
            0.5
        } else {
            share.clamp(1e-3, 0.999)
        };
        let middle = low + DoubleDouble::from(width * share);
        match at(middle).as_ref().and_then(rise) {
            Some(rise) if rise.is_sign_positive() == before.is_sign_positive() => {
                (low, before) = (middle, rise);
            }
            Some(rise) => (high, after) = (middle, rise),
            // A pole, or a point where the digits end.
            None => break,
        }
    }
    let width = (high - low).to_f64();
    let share = before / (before - after);
    let middle = low + DoubleDouble::from(width * share);
    let mut radius = width;
    for narrow in [1e-6, 1e-4, 1e-2] {
        let near = DoubleDouble::from(width * narrow);
        let sides = [middle - near, middle + near].map(|side| at(side).as_ref().and_then(rise));
        if let [Some(left), Some(right)] = sides
            && left.is_sign_positive() == before.is_sign_positive()
            && right.is_sign_positive() == after.is_sign_positive()
        {
            radius = width * narrow;
            break;
        }
    }
    let radius = radius * (1.0 + f64::EPSILON);
    let frequency = middle.to_f64();
    let off = (middle - DoubleDouble::from(frequency)).to_f64().abs() + radius;
    let value = look(Frequency { middle, radius });
    let gain = value.map(|value| {
        (
            value.value.norm(),
            value.bound + value.value.norm() * f64::EPSILON,
        )
    });
    let gain = gain.filter(|(gain, bound)| gain.is_finite() && bound.is_finite());
    Some(Peak {
        frequency: (frequency, off * (1.0 + f64::EPSILON)),
        gain,
        half_power: None,
    })
}

/// Where the magnitude is 1/√2 of a peak's, below and above.
fn half_power(
    look: &Look<'_>,
    peak: f64,
    gain: f64,
    dips: &[Peak],
    ends: [f64; 2],
) -> Option<[f64; 2]> {
    let dips = || dips.iter().map(|dip| dip.frequency.0);
    let low = dips().filter(|dip| *dip < peak).fold(ends[0], f64::max);
    let high = dips().filter(|dip| *dip > peak).fold(ends[1], f64::min);
    let level = gain * std::f64::consts::FRAC_1_SQRT_2;
    let size = |frequency: f64| look(frequency.into()).map(|value| value.value.norm());
    let search = |mut outer: f64| {
        if size(outer)? > level {
            return None;
        }
        let mut inner = peak;
        // Steps away from the peak double, so that narrow peaks take few.
        let mut step = (outer - peak).signum() * peak * f64::EPSILON;
        loop {
            let next = peak + step;
            if (next - peak).abs() >= (outer - peak).abs() {
                break;
            }
            if size(next)? < level {
                outer = next;
                break;
            }
            inner = next;
            step *= 2.0;
        }
        loop {
            let middle = f64::midpoint(inner, outer);
            if middle == inner || middle == outer {
                return Some(outer);
            }
            match size(middle)? < level {
                true => outer = middle,
                false => inner = middle,
            }
        }
    };
    Some([search(low)?, search(high)?])
}

/// What a magnitude tends to beyond a frequency.
fn asymptote(look: &Look<'_>, frequency: f64) -> Option<Asymptote> {
    let value = look(frequency.into())?;
    let (rise, _) = value.steepness?;
    let power = (rise * frequency).round() as i32;
    let coefficient = value.value.norm() / frequency.powi(power);
    let known = coefficient.is_finite() && coefficient > 0.0;
    known.then_some(Asymptote { coefficient, power })
}
