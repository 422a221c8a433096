//! What is notable in a frequency response function: where its magnitude is largest or least, how wide its peaks are, and
//! what becomes of it at low and high frequencies.

use eigentone_digits::DoubleDouble;

use super::dynamic_stiffness::Frequency;
use super::enclosure::{Asked, Value};
use super::turns::Turns;

/// A frequency at which a magnitude is largest, or least, among those around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    frequency: (f64, f64),
    gain: Option<(f64, f64)>,
    /// The place, in more digits.
    middle: DoubleDouble,
    /// How far from there the frequencies of half power are.
    half_power: Option<[f64; 2]>,
}

impl Peak {
    fn pole(frequency: (f64, f64)) -> Peak {
        Peak {
            frequency,
            gain: None,
            middle: frequency.0.into(),
            half_power: None,
        }
    }

    /// Ω in rad/s: the double nearest to the true place, and a bound of how far it is from there, which is proven as those
    /// of the function's values are: beyond 400 coordinates it is an estimate.
    pub fn frequency(&self) -> (f64, f64) {
        self.frequency
    }

    /// The magnitude there, and a bound of its error, proven likewise; `None` where it is infinite, or a peak is narrower than 1e-25
    /// of its frequency.
    pub fn gain(&self) -> Option<(f64, f64)> {
        self.gain
    }

    /// The frequencies below and above a peak at which the magnitude is 1/√2 of it, in rad/s, to the last digits; `None`
    /// for a dip, where the magnitude does not fall so far before it rises again, and for a peak narrower than 1e-25 of its frequency.
    pub fn half_power(&self) -> Option<[f64; 2]> {
        let offsets = self.half_power?;
        Some(offsets.map(|offset| (self.middle + DoubleDouble::from(offset)).to_f64()))
    }

    /// The difference of the half-power frequencies over the frequency of the peak: the loss factor, and nearly 2ζ of a
    /// mode that stands by itself (Ewins 2000, *Modal Testing*, section 4.3.2). It has digits where no double is between the
    /// frequencies too.
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

/// The largest magnitude at all frequencies: the norm of a function in H∞.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LargestGain {
    /// It is reached, or approached as Ω → ∞.
    Finite {
        /// Ω in rad/s: 0, that of a peak, or ∞.
        frequency: f64,
        /// The magnitude.
        gain: f64,
        /// A proven bound of its error.
        bound: f64,
    },
    /// There is none: the magnitude grows beyond all bounds, at a pole without damping or as Ω → ∞.
    Unbounded {
        /// Ω in rad/s: that of the pole, or ∞.
        frequency: f64,
    },
}

/// What is notable in a frequency response function.
///
/// Peaks and dips are zeros of d|H|²/dΩ, each enclosed by proven signs on both sides, or beyond 400 coordinates by signs that
/// estimates of errors leave no doubt of. Where it is
/// [`complete`](Self::is_complete), there are no others at any frequency. Elsewhere they are sought between frequencies
/// given: two that lie between the same neighbours are not seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Features {
    peaks: Vec<Peak>,
    dips: Vec<Peak>,
    complete: bool,
    largest_gain: Option<LargestGain>,
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

    /// Whether it is proved that there is no other peak or dip at any frequency between 0 and ∞.
    ///
    /// It is not where poles on the axis coincide, or are not seen by the function, where two rigid motions or more are
    /// free and the function follows some of them, or the mass matrix stays singular without its empty rows and columns, and where the proof takes too long, as it
    /// may from about a hundred coordinates on.
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// The largest magnitude at all frequencies from 0 to ∞; `None` where it is not proved.
    pub fn largest_gain(&self) -> Option<LargestGain> {
        self.largest_gain
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

    /// By looks at single frequencies and their neighbourhood, between those of the grid, which rises, or in brackets with one
    /// turn each where all are known; the steepness at a glance, without a bound, saves looks where there is one.
    pub(super) fn of(
        look: &Look<'_>,
        glance: Option<&Glance<'_>>,
        grid: &[f64],
        turns: Option<&Turns>,
    ) -> Features {
        let sure = |frequency: f64| look(frequency.into(), Asked::Sign).as_ref().and_then(rise);
        let steep = |frequency: f64| {
            let known = glance.and_then(|glance| glance(frequency));
            known.map(|(_, rise)| rise).or_else(|| sure(frequency))
        };
        let known = grid.iter().filter(|frequency| **frequency > 0.0);
        let complete = turns.and_then(|turns| {
            let found = turns.each.iter().map(|turn| {
                if let Some(frequency) = turn.pole {
                    return Some((true, Peak::pole(frequency)));
                }
                let [low, high] = turn.ends;
                let real = turns.is_real;
                let quick = || found(look, glance, turn.ends, [steep(low)?, steep(high)?], real);
                // Doubles may not tell the signs where a function has fallen far.
                quick().or_else(|| found(look, None, turn.ends, [sure(low)?, sure(high)?], real))
            });
            let found = found.collect::<Option<Vec<(bool, Peak)>>>()?;
            // As many as there are, if no two are the same.
            let apart = found.windows(2).all(|pair| {
                let [(low, below), (high, above)] = [0, 1].map(|k| pair[k].1.frequency);
                low + below < high - above
            });
            apart.then_some(found)
        });
        let mut features = Features {
            peaks: Vec::new(),
            dips: Vec::new(),
            complete: complete.is_some(),
            largest_gain: None,
            low: None,
            high: None,
        };
        let found = complete.unwrap_or_else(|| {
            let known = known.clone();
            let known: Vec<(f64, f64)> = known
                .filter_map(|&frequency| Some((frequency, steep(frequency)?)))
                .collect();
            let pairs = known.windows(2);
            let found = pairs.filter_map(|pair| {
                let [ends, rises] = [[pair[0].0, pair[1].0], [pair[0].1, pair[1].1]];
                found(look, glance, ends, rises, false)
            });
            found.collect()
        });
        for (is_peak, turn) in found {
            match is_peak {
                true => features.peaks.push(turn),
                false => features.dips.push(turn),
            }
        }
        features.largest_gain = turns.and_then(|turns| features.largest_of_all(look, turns));
        let (Some(&first), Some(&last)) = (known.clone().next(), known.clone().next_back()) else {
            return features;
        };
        // Where all turns are known, the magnitude falls on beyond the grid.
        let beyond = if features.complete { FAR } else { 1.0 };
        for peak in &mut features.peaks {
            peak.half_power = peak.gain.and_then(|(gain, _)| {
                let place = peak.frequency.0;
                let ends = [first.min(place) / beyond, last.max(place) * beyond];
                let dips = || features.dips.iter().map(|dip| dip.frequency.0);
                let low = dips().filter(|dip| *dip < place).fold(ends[0], f64::max);
                let high = dips().filter(|dip| *dip > place).fold(ends[1], f64::min);
                half_power(look, glance, peak.middle, gain, [low, high])
            });
        }
        features.low = asymptote(look, first * FAR.recip());
        features.high = asymptote(look, last * FAR);
        features
    }

    /// The largest of all peaks and of the limits at 0 and ∞.
    fn largest_of_all(&self, look: &Look<'_>, turns: &Turns) -> Option<LargestGain> {
        if !self.complete {
            return None;
        }
        let mut largest = None;
        let mut add = |frequency: f64, (gain, bound): (f64, f64)| {
            let known = match largest {
                Some(LargestGain::Finite { gain, .. }) => gain,
                Some(LargestGain::Unbounded { .. }) => return,
                None => f64::NEG_INFINITY,
            };
            if gain == f64::INFINITY {
                largest = Some(LargestGain::Unbounded { frequency });
            } else if gain > known {
                largest = Some(LargestGain::Finite {
                    frequency,
                    gain,
                    bound,
                });
            }
        };
        for peak in &self.peaks {
            let frequency = peak.frequency.0;
            let pole = || is_pole(look, turns, frequency).then_some((f64::INFINITY, 0.0));
            add(frequency, peak.gain.or_else(pole)?);
        }
        if turns.rises_at_last {
            add(f64::INFINITY, turns.limit?);
        }
        if turns.falls_at_first {
            let known = look(0.0.into(), Asked::Value).map(|value| {
                let size = value.value.norm();
                (size, value.bound + size * f64::EPSILON)
            });
            add(0.0, known.or(turns.start)?);
        }
        largest
    }
}

/// Whether a peak is a pole: H, which is real, changes its sign in a bracket without a dip.
fn is_pole(look: &Look<'_>, turns: &Turns, peak: f64) -> bool {
    let mut each = turns.each.iter();
    let own = each.find(|turn| (turn.ends[0]..=turn.ends[1]).contains(&peak));
    if own.is_some_and(|turn| turn.pole.is_some()) {
        return true;
    }
    let value = |frequency: f64| look(frequency.into(), Asked::Value).map(|value| value.value);
    let signs = own.and_then(|turn| Some((value(turn.ends[0])?, value(turn.ends[1])?)));
    turns.is_real && signs.is_some_and(|(before, after)| (before * after.conj()).re < 0.0)
}

/// What is between two frequencies where the steepness has these signs: whether it is a peak, and where. The function may be known to
/// be real at all frequencies, or imaginary.
fn found(
    look: &Look<'_>,
    glance: Option<&Glance<'_>>,
    ends: [f64; 2],
    rises: [f64; 2],
    real: bool,
) -> Option<(bool, Peak)> {
    let is_peak = match rises {
        [before, after] if before > 0.0 && after < 0.0 => true,
        [before, after] if before < 0.0 && after > 0.0 => false,
        _ => return None,
    };
    let near = glance.and_then(|glance| near(look, glance, ends, rises));
    let bracket = near.or_else(|| certain(look, ends, rises[0]))?;
    Some((is_peak, turn(look, bracket, real)))
}

/// The value at a frequency; `None` at a pole.
pub(super) type Look<'a> = dyn Fn(Frequency, Asked) -> Option<Value> + 'a;

/// The magnitude and its steepness in doubles.
pub(super) type Glance<'a> = dyn Fn(f64) -> Option<(f64, f64)> + 'a;

/// Two frequencies between which the steepness changes its sign, and the steepness there, by proof.
type Bracket = ([DoubleDouble; 2], [f64; 2]);

/// 2^40: corrections of asymptotes are of its square.
const FAR: f64 = 1_099_511_627_776.0;

/// How steeply the logarithm of the magnitude rises, if its sign is sure.
fn rise(value: &Value) -> Option<f64> {
    let (rise, off) = value.steepness?;
    (rise.abs() > off).then_some(rise)
}

/// The bracket between two frequencies, if looks say the same as glances.
fn certain(look: &Look<'_>, ends: [f64; 2], before: f64) -> Option<Bracket> {
    let [low, high] = ends.map(|end| look(end.into(), Asked::Sign).as_ref().and_then(rise));
    let (low, high) = (low?, high?);
    let fits = low * before > 0.0 && high * before < 0.0;
    fits.then(|| (ends.map(DoubleDouble::from), [low, high]))
}

/// A narrow bracket within a wide one, found by glances.
fn near(
    look: &Look<'_>,
    glance: &Glance<'_>,
    [mut low, mut high]: [f64; 2],
    [mut before, mut after]: [f64; 2],
) -> Option<Bracket> {
    const MOST: usize = 100;
    for k in 0..MOST {
        let share = share(before, after, high - low, k);
        let middle = low + share * (high - low);
        if middle <= low || middle >= high || high - low < 1e-13 * high {
            break;
        }
        let (_, rise) = glance(middle)?;
        match rise * before > 0.0 {
            true => (low, before) = (middle, rise),
            false => (high, after) = (middle, rise),
        }
    }
    let middle = f64::midpoint(low, high);
    let widths = [1e-14, 1e-12, 1e-9, 1e-6].map(|width| width * middle + (high - low));
    let mut brackets = widths
        .into_iter()
        .map(|width| certain(look, [middle - width, middle + width], before));
    brackets.find_map(|bracket| bracket)
}

/// Where the zero is to be sought in a bracket, as a share of it.
fn share(before: f64, after: f64, width: f64, step: usize) -> f64 {
    let steep = before.abs().max(after.abs()) * width;
    // Far from a narrow peak its steepness is as 1/x, and on it as −x.
    let share = match steep > 1.0 {
        true => after / (after - before),
        false => before / (before - after),
    };
    // One step in three halves, so that none is lost.
    if step % 3 == 2 {
        0.5
    } else {
        share.clamp(1e-3, 0.999)
    }
}

/// The place of a pole in a bracket in which the magnitude rises and falls: values beside it are real, but for rounding, and change
/// their sign.
fn pole(
    look: &Look<'_>,
    [low, high]: [DoubleDouble; 2],
    [before, after]: [f64; 2],
) -> Option<(f64, f64)> {
    /// How near to it signs are looked at, in parts of its frequency.
    const NEAR: [f64; 3] = [1e-18, 1e-17, 1e-16];
    let at = |middle: DoubleDouble, asked: Asked| {
        let frequency = Frequency {
            middle,
            radius: 0.0,
            scale: 0,
        };
        look(frequency, asked)
    };
    let changes_sign = |ends: [DoubleDouble; 2]| {
        let value = |middle: DoubleDouble| {
            let value = at(middle, Asked::Value)?.value;
            (value.im == 0.0).then_some(value.re)
        };
        Some(value(ends[0])? * value(ends[1])? < 0.0)
    };
    if !changes_sign([low, high])? {
        return None;
    }
    let width = (high - low).to_f64();
    let middle = low + DoubleDouble::from(width * share(before, after, width, 0));
    let frequency = middle.to_f64();
    NEAR.into_iter().find_map(|near| {
        let near = DoubleDouble::from(near * frequency);
        let sides = [middle - near, middle + near];
        let [left, right] = sides.map(|side| at(side, Asked::Sign).as_ref().and_then(rise));
        let fits = left? > 0.0 && right? < 0.0 && changes_sign(sides)?;
        let off = (middle - DoubleDouble::from(frequency)).abs() + near;
        fits.then_some((frequency, off.to_f64() * (1.0 + 4.0 * f64::EPSILON)))
    })
}

/// A gain with such a bound, in parts of it, is as good as a double.
const GOOD: f64 = 1e-15;

/// The zero of the steepness within a bracket.
fn turn(look: &Look<'_>, (ends, rises): Bracket, real: bool) -> Peak {
    const MOST: usize = 160;
    /// Within it the steepness is a straight line, to its square.
    const STRAIGHT: f64 = 1e-5;
    /// How narrow the bracket is to become, in parts of the frequency; and where the gain needs it, at most.
    const NARROW: f64 = 1e-22;
    const NARROWEST: f64 = 1e-28;
    /// A magnitude with fewer digits is none: there may be a pole.
    const KNOWN: f64 = 1e-6;
    let ([mut low, mut high], [mut before, mut after]) = (ends, rises);
    let at = |middle: DoubleDouble| {
        let frequency = Frequency {
            scale: 0,
            middle,
            radius: 0.0,
        };
        look(frequency, Asked::Sign)
    };
    let pole = || pole(look, [low, high], [before, after]);
    if let Some(pole) = (before > 0.0).then(pole).flatten() {
        return Peak::pole(pole);
    }
    for k in 0..MOST {
        let width = (high - low).to_f64();
        let steep = before.abs().max(after.abs()) * width;
        // Beside a zero of the function, or a pole, its inverse is the distance from there.
        let distance = (after.recip() - before.recip()) / width;
        let is_straight = steep < STRAIGHT || (distance.abs() - 1.0).abs() < STRAIGHT;
        if is_straight || width <= high.to_f64() * 1e-27 {
            break;
        }
        let share = share(before, after, width, k);
        // An elimination may meet a pivot of 0 where there is no pole.
        let near = [share, 0.9 * share + 0.05, 0.5]
            .into_iter()
            .find_map(|share| {
                let middle = low + DoubleDouble::from(width * share);
                Some((middle, at(middle).as_ref().and_then(rise)?))
            });
        match near {
            Some((middle, rise)) if rise * before > 0.0 => (low, before) = (middle, rise),
            Some((middle, rise)) => (high, after) = (middle, rise),
            // A pole, or a point where the digits end.
            None => break,
        }
    }
    // Now the zero of a straight line is close, or a pole: signs beside it narrow the bracket a thousandfold and more at once.
    let zero = |low: DoubleDouble, high: DoubleDouble, before: f64, after: f64| {
        let width = (high - low).to_f64();
        low + DoubleDouble::from(width * share(before, after, width, 0))
    };
    let mut gain: Option<(f64, f64)> = None;
    for k in 0..MOST {
        let width = (high - low).to_f64();
        let goal = high.to_f64() * NARROW;
        let middle = zero(low, high, before, after);
        if width <= goal {
            let found = gain_within(look, middle, width, real);
            let closer = found.filter(|found| gain.is_none_or(|known| found.1 < known.1));
            let done = match closer {
                Some((size, bound)) => bound <= GOOD * size || real && bound >= size,
                None => gain.is_some(),
            };
            gain = closer.or(gain);
            if done || width <= high.to_f64() * NARROWEST {
                break;
            }
        }
        // No narrower at once than is asked for: that takes more digits.
        let least = match width <= goal {
            true => 1e-2,
            false => (0.4 * goal / width).max(1e-6),
        };
        let wider = [1e-4, 1e-2, 0.1, 0.25].into_iter();
        let narrower = std::iter::once(least)
            .chain(wider.filter(|narrow| *narrow > least))
            .find_map(|narrow| {
                let near = DoubleDouble::from(width * narrow);
                let sides = [middle - near, middle + near];
                let [left, right] = sides.map(|side| at(side).as_ref().and_then(rise));
                let fits = left? * before > 0.0 && right? * after > 0.0;
                fits.then_some((sides, [left?, right?]))
            });
        if let Some((ends, rises)) = narrower {
            ([low, high], [before, after]) = (ends, rises);
            continue;
        }
        // A flat turn is not straight, however little the magnitude changes.
        let middle = low + DoubleDouble::from(width * share(before, after, width, k));
        match at(middle).as_ref().and_then(rise) {
            Some(rise) if rise * before > 0.0 => (low, before) = (middle, rise),
            Some(rise) => (high, after) = (middle, rise),
            None => break,
        }
    }
    let middle = zero(low, high, before, after);
    let radius = (high - low).to_f64();
    let gain = gain.or_else(|| gain_within(look, middle, radius, real));
    let radius = radius * (1.0 + f64::EPSILON);
    let frequency = middle.to_f64();
    let off = (middle - DoubleDouble::from(frequency)).to_f64().abs() + radius;
    Peak {
        frequency: (frequency, off * (1.0 + f64::EPSILON)),
        gain: gain.filter(|(gain, bound)| {
            let is_dip = before < 0.0;
            gain.is_finite() && bound.is_finite() && (is_dip || *bound <= KNOWN * gain)
        }),
        middle,
        half_power: None,
    }
}

/// The magnitude of a turn within a radius of a frequency: as known for the whole range, or at its middle, from where a narrow peak
/// hardly rises within it, however fast the phase turns.
fn gain_within(
    look: &Look<'_>,
    middle: DoubleDouble,
    radius: f64,
    real: bool,
) -> Option<(f64, f64)> {
    let at = |radius: f64, asked: Asked| {
        let frequency = Frequency {
            middle,
            radius,
            scale: 0,
        };
        look(frequency, asked)
    };
    let known = |value: Value| {
        let size = value.value.norm();
        (size, value.bound + size * f64::EPSILON)
    };
    let whole = known(at(radius, Asked::Value)?);
    // Where a real function may be 0, it changes its sign, and its magnitude has no steepness.
    if whole.1 <= GOOD * whole.0 || real && whole.1 >= whole.0 {
        return Some(whole);
    }
    let by_middle = || {
        let (rise, off) = at(radius, Asked::Steepness)?.steepness?;
        let (size, bound) = known(at(0.0, Asked::Value)?);
        // e^x − 1 ≤ 2x up to 1.
        let change = 2.0 * (rise.abs() + off) * radius;
        (change <= 1.0).then_some((size, bound + change * (size + bound)))
    };
    let closer = by_middle().filter(|(_, bound)| *bound < whole.1);
    Some(closer.unwrap_or(whole))
}

/// How far below and above a peak, before these ends, the magnitude is 1/√2 of what it is there: sought by glances, if there are any,
/// and found by looks.
fn half_power(
    look: &Look<'_>,
    glance: Option<&Glance<'_>>,
    peak: DoubleDouble,
    gain: f64,
    ends: [f64; 2],
) -> Option<[f64; 2]> {
    /// Narrower peaks, in parts of their frequency, have too few doubles for glances.
    const WIDE: f64 = 1e-9;
    let level = gain * std::f64::consts::FRAC_1_SQRT_2;
    let place = peak.to_f64();
    let ends = ends.map(|end| (DoubleDouble::from(end) - peak).to_f64());
    let above = |offset: f64| {
        let frequency = Frequency {
            middle: peak + DoubleDouble::from(offset),
            radius: 0.0,
            scale: 0,
        };
        let value = look(frequency, Asked::Steepness)?;
        let (rise, _) = value.steepness?;
        Some(((value.value.norm() / level).ln(), rise))
    };
    let nearly = glance.and_then(|glance| {
        let above = |offset: f64| {
            let (size, rise) = glance((peak + DoubleDouble::from(offset)).to_f64())?;
            Some(((size / level).ln(), rise))
        };
        let found = crossings(&above, place, ends)?;
        let is_known = |offset: &f64| offset.abs() > WIDE * place;
        found.iter().all(is_known).then_some(found)
    });
    let closer = |from: f64| {
        /// Steps of Newton's method from what doubles say.
        const STEPS: usize = 5;
        /// Farther from there it may be another crossing.
        const NEAR: f64 = 1e-4;
        let mut at = from;
        for _ in 0..STEPS {
            let (height, rise) = above(at)?;
            let next = at - height / rise;
            if (next - at).abs() <= next.abs() * ROUNDING {
                return Some(next);
            }
            at = Some(next).filter(|next| (next - from).abs() <= NEAR * from.abs())?;
        }
        None
    };
    let near = nearly.and_then(|[low, high]| Some([closer(low)?, closer(high)?]));
    near.or_else(|| crossings(&above, place, ends))
}

/// What rounding leaves open of offsets, in parts of them.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// How far below and above a peak the magnitude crosses a level, given how far above the level it is on a logarithmic scale and
/// how steep that is, so far from the peak.
fn crossings(
    above: &dyn Fn(f64) -> Option<(f64, f64)>,
    peak: f64,
    [low, high]: [f64; 2],
) -> Option<[f64; 2]> {
    /// Narrower peaks, in parts of their frequency, have too few digits.
    const NARROWEST: f64 = 1e-25;
    // A peak by itself is 1/(1 + (x/σ)²), of which the steepness is −x/(x² + σ²).
    let mut x = peak * 1e-4;
    let mut width = 0.0;
    while width <= 0.0 && x > peak * NARROWEST {
        let (_, rise) = above(x)?;
        let square = -x / rise - x * x;
        width = if square > 0.01 * x * x {
            square.sqrt()
        } else {
            0.0
        };
        x /= 100.0;
    }
    let width = width.max(peak * NARROWEST);
    let search = |end: f64| {
        let side = end.signum();
        let (mut inner, mut reach) = (0.0, width);
        let mut outer = loop {
            let next = side * reach;
            if (end - next) * side <= 0.0 {
                break (above(end)?.0 <= 0.0).then_some(end)?;
            }
            if above(next)?.0 <= 0.0 {
                break next;
            }
            (inner, reach) = (next, 2.0 * reach);
        };
        let mut next = f64::midpoint(inner, outer);
        loop {
            if (next - inner) * side <= 0.0 || (outer - next) * side <= 0.0 {
                next = f64::midpoint(inner, outer);
            }
            if next.abs() < peak * NARROWEST {
                return None;
            }
            if next == inner || next == outer {
                return Some(outer);
            }
            let (height, rise) = above(next)?;
            match height > 0.0 {
                true => inner = next,
                false => outer = next,
            }
            let newton = next - height / rise;
            if (newton - next).abs() <= next.abs() * ROUNDING {
                return Some(newton);
            }
            next = newton;
        }
    };
    Some([search(low)?, search(high)?])
}

/// What a magnitude tends to beyond a frequency.
fn asymptote(look: &Look<'_>, frequency: f64) -> Option<Asymptote> {
    let value = look(frequency.into(), Asked::Steepness)?;
    let (rise, _) = value.steepness?;
    let power = (rise * frequency).round() as i32;
    let coefficient = value.value.norm() / frequency.powi(power);
    let known = coefficient.is_finite() && coefficient > 0.0;
    known.then_some(Asymptote { coefficient, power })
}
