//! Response spectra by the exact recursion (Nigam & Jennings 1969, *Bull. Seismol. Soc. Am.* 59), with the true extrema
//! between the samples.

use eigentone_digits::{DoubleDouble, Magnitude, Real};
use eigentone_modes::Precision;

use super::base::BaseAcceleration;
use super::error::SpectrumError;
use super::maps::{Maps, Place};
use super::oscillator::{Oscillator, SLACK};
use super::peak::Form;
use super::search::{Largest, Search};
use crate::problem::Hold;

/// The largest value of a motion in size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectralPeak {
    /// The size.
    pub value: f64,
    /// How far it may be off, proven.
    pub bound: f64,
    /// When, in s.
    pub time: f64,
    /// How far from that the motion turns, proven; `None` where it does not turn but has a corner, as some accelerations at
    /// samples, or where digits do not decide.
    pub time_bound: Option<f64>,
}

impl SpectralPeak {
    /// Whether so little is known of it that it says nothing.
    fn is_unknown(&self) -> bool {
        const KNOWN: f64 = 1e-6;
        /// Below, digits are lost at the end of the range of doubles.
        const SMALLEST: f64 = 1e-290;
        self.bound > KNOWN * self.value + SMALLEST
    }
}

/// The largest motions of one-mass systems of one damping ratio on a base that is shaken, from rest on: at any time, between
/// samples and after the end too. All bounds are proven.
///
/// ```
/// use eigentone_modes::Precision;
/// use eigentone_response::{Hold, ResponseSpectrum, Samples};
///
/// let record = Samples { step: 0.01, values: vec![0.0, 1.0, 0.5, -1.0, 0.0], hold: Hold::First };
/// let spectrum = ResponseSpectrum::of(record, 0.05, &[1.0, 10.0], Precision::default())?;
/// let peak = spectrum.displacement()[1];
/// assert!(peak.bound < 1e-15 * peak.value);
/// # Ok::<(), eigentone_response::SpectrumError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseSpectrum {
    frequencies: Vec<f64>,
    ratio: f64,
    displacement: Vec<SpectralPeak>,
    pseudo_velocity: Vec<SpectralPeak>,
    pseudo_acceleration: Vec<SpectralPeak>,
    acceleration: Vec<SpectralPeak>,
}

impl ResponseSpectrum {
    /// At frequencies in Hz. With [`Precision::Certified`] the recursion has 32 digits and the values are right to about
    /// their last one; with [`Precision::Double`] it has those of doubles wherever these leave six, is several times as fast, and the
    /// bounds are wider.
    ///
    /// # Errors
    /// [`SpectrumError`]: an acceleration, frequency or ratio that none can be, or that leads out of range; a motion that
    /// is too fast within an interval to find its largest value to six digits.
    pub fn of(
        base: impl Into<BaseAcceleration>,
        ratio: f64,
        frequencies: &[f64],
        precision: Precision,
    ) -> Result<ResponseSpectrum, SpectrumError> {
        let base = base.into();
        base.check()?;
        if !(ratio.is_finite() && ratio >= 0.0) {
            return Err(SpectrumError::Ratio { ratio });
        }
        let wrong = |frequency: &f64| !(frequency.is_finite() && *frequency > 0.0);
        if let Some(index) = frequencies.iter().position(wrong) {
            let frequency = frequencies[index];
            return Err(SpectrumError::Frequency { index, frequency });
        }
        let mut spectrum = ResponseSpectrum {
            frequencies: frequencies.to_vec(),
            ratio,
            displacement: Vec::with_capacity(frequencies.len()),
            pseudo_velocity: Vec::with_capacity(frequencies.len()),
            pseudo_acceleration: Vec::with_capacity(frequencies.len()),
            acceleration: Vec::with_capacity(frequencies.len()),
        };
        for &frequency in frequencies {
            let oscillator = Oscillator::of(frequency, ratio, &base);
            let oscillator = oscillator.ok_or(SpectrumError::OutOfRange { frequency })?;
            let is_known = |peaks: &[SpectralPeak; 4]| !peaks.iter().any(SpectralPeak::is_unknown);
            let quick = match precision {
                Precision::Double => Shaken::<f64>::by(&oscillator, &base).peaks(),
                Precision::Certified { .. } => None,
            };
            // Where doubles leave nothing that is known, more digits may.
            let peaks = match quick.filter(is_known) {
                None => Shaken::<DoubleDouble>::by(&oscillator, &base).peaks(),
                known => known,
            };
            let peaks = peaks.ok_or(SpectrumError::OutOfRange { frequency })?;
            if !is_known(&peaks) {
                let interval = base.interval();
                return Err(SpectrumError::Undecided {
                    frequency,
                    interval,
                });
            }
            let [displacement, velocity, pseudo, acceleration] = peaks;
            spectrum.displacement.push(displacement);
            spectrum.pseudo_velocity.push(velocity);
            spectrum.pseudo_acceleration.push(pseudo);
            spectrum.acceleration.push(acceleration);
        }
        Ok(spectrum)
    }

    /// The frequencies, in Hz.
    pub fn frequencies(&self) -> &[f64] {
        &self.frequencies
    }

    /// The damping ratio.
    pub fn ratio(&self) -> f64 {
        self.ratio
    }

    /// The largest displacement y relative to the base, in m.
    pub fn displacement(&self) -> &[SpectralPeak] {
        &self.displacement
    }

    /// ω times that, in m/s.
    pub fn pseudo_velocity(&self) -> &[SpectralPeak] {
        &self.pseudo_velocity
    }

    /// ω² times that, in m/s².
    pub fn pseudo_acceleration(&self) -> &[SpectralPeak] {
        &self.pseudo_acceleration
    }

    /// The largest absolute acceleration, 2ζωy′ + ω²y, in m/s².
    pub fn acceleration(&self) -> &[SpectralPeak] {
        &self.acceleration
    }
}

/// A system that is shaken, at one frequency.
struct Shaken<'a, T> {
    oscillator: &'a Oscillator,
    base: &'a BaseAcceleration,
    maps: Maps<T>,
    /// Without the base.
    free: Maps<T>,
    forms: [Form<T>; 2],
    /// Intervals in which a form may be largest: by the number of the interval.
    candidates: [Vec<Candidate<T>>; 2],
    /// The largest |p|, |v| and base acceleration times interval at the samples.
    most: [f64; 3],
}

struct Candidate<T> {
    upper: f64,
    index: usize,
    from: [T; 2],
}

/// So many candidates are kept before those that have been outdone are dropped.
const KEPT: usize = 4096;

impl<'a, T: Real> Shaken<'a, T> {
    fn by(oscillator: &'a Oscillator, base: &'a BaseAcceleration) -> Shaken<'a, T> {
        Shaken {
            oscillator,
            base,
            maps: Maps::driven(oscillator),
            free: Maps::free(oscillator),
            forms: [Form::of(0.0), Form::of(2.0 * oscillator.ratio)],
            candidates: [Vec::new(), Vec::new()],
            most: [0.0; 3],
        }
    }

    /// Relative displacement, pseudo-velocity, pseudo-acceleration, absolute acceleration.
    fn peaks(mut self) -> Option<[SpectralPeak; 4]> {
        let (unit, start) = (self.base.interval(), self.base.start());
        let end = self.follow();
        // With more digits than a double has, to less than its last one.
        let digits = if T::UNIT_LOG2 > -60 { -50 } else { -57 };
        let candidates = std::mem::take(&mut self.candidates);
        let mut found = Vec::new();
        for (form, candidates) in self.forms.into_iter().zip(candidates) {
            let maps = [&mut self.maps, &mut self.free];
            let mut search = Search::new(self.oscillator, maps, form, start, unit);
            for candidate in candidates {
                let from = (candidate.from, law(self.base, candidate.index));
                let interval = start + candidate.index as f64 * unit;
                search.add(interval, 0.0, 0, from);
            }
            let ended = start + self.base.intervals() as f64 * unit;
            swing(self.oscillator, &mut search, form, ended, end);
            found.push(search.run(digits));
        }
        let [p, v, a] = self.most;
        // Every step from sample to sample, and every halving of an interval, errs by as much; values are read twice.
        let size = (p.hypot(v) + 4.0 * a) * (1.0 + SLACK);
        let steps = self.oscillator.gathered(self.base.intervals() as f64) + 200.0;
        let floor = T::floor().to_f64() * 1e3;
        let single = self.maps.error().max(self.free.error());
        let error = 4.0 * steps * (single * size + floor) * (1.0 + SLACK);
        let (rate, relative) = self.oscillator.rate;
        let peak_of = |largest: &Largest<T>, form: &Form<T>, power: i32| {
            let error = error * form.norm();
            let time_bound = largest.time_bound(error);
            SpectralPeak {
                time_bound,
                ..scaled(largest, error.into(), rate, relative, power)
            }
        };
        let [y, a] = &found[..] else {
            return None;
        };
        let peaks = [
            peak_of(y, &self.forms[0], -1),
            peak_of(y, &self.forms[0], 0),
            peak_of(y, &self.forms[0], 1),
            peak_of(a, &self.forms[1], 1),
        ];
        let whole = |peak: &SpectralPeak| {
            peak.value.is_finite() && peak.bound.is_finite() && peak.time.is_finite()
        };
        peaks.iter().all(whole).then_some(peaks)
    }

    /// From sample to sample, collecting candidates; the state at the end.
    fn follow(&mut self) -> [T; 2] {
        let rest = [T::ZERO; 2];
        let BaseAcceleration::Record(record) = self.base else {
            let law = law::<T>(self.base, 0);
            let [a, b, c] = law.map(T::to_f64);
            self.most[2] = c.abs() + (a - c).hypot(b);
            for candidates in &mut self.candidates {
                candidates.push(Candidate {
                    upper: f64::INFINITY,
                    index: 0,
                    from: rest,
                });
            }
            let end = self.maps.at(0).apply(&(rest, law)).0;
            self.most[0] = end[0].to_f64().abs() + self.most[2];
            self.most[1] = end[1].to_f64().abs() + self.most[2];
            return end;
        };
        let map = self.maps.at(0).clone();
        let unit = T::from(record.step);
        // Of the samples at both ends of an interval.
        let [p_row, v_row] = [map.rows[0], map.rows[1]];
        let ends = |row: &[T; 5]| match record.hold {
            Hold::Zero => [row[2] * unit, T::ZERO],
            Hold::First => [(row[2] - row[3]) * unit, row[3] * unit],
        };
        let (p_ends, v_ends) = (ends(&p_row), ends(&v_row));
        let straight = record.hold == Hold::First;
        let quick = self.forms.map(|form| Quick::of(&form, self.oscillator));
        let values = &record.values;
        let mut best = [0.0f64; 2];
        let [mut p, mut v] = rest;
        let [mut p_rough, mut v_rough] = [0.0f64; 2];
        for index in 0..self.base.intervals() {
            let from = values[index];
            let (mut p_next, mut v_next) = (
                p_row[0] * p + p_row[1] * v + p_ends[0].mul_f64(from),
                v_row[0] * p + v_row[1] * v + v_ends[0].mul_f64(from),
            );
            let mut pushed = from.abs();
            if straight {
                let to = values[index + 1];
                p_next = p_next + p_ends[1].mul_f64(to);
                v_next = v_next + v_ends[1].mul_f64(to);
                pushed = pushed.max(to.abs());
            }
            let (p_to, v_to) = (p_next.to_f64(), v_next.to_f64());
            pushed *= record.step;
            let size = p_rough.abs() + v_rough.abs() + pushed;
            for (which, quick) in quick.iter().enumerate() {
                let form = &self.forms[which];
                let first = form.rough(p_rough, v_rough).abs();
                let last = form.rough(p_to, v_to).abs();
                if best[which] < last {
                    best[which] = last;
                }
                let upper = first.max(last) + quick.of_size * size + quick.of_push * pushed;
                // What is not a number is looked at too.
                if upper < best[which] {
                    continue;
                }
                let place = ([p, v], law(self.base, index));
                let to = ([p_next, v_next], end_of(&place.1));
                let upper = form.bound(self.oscillator, 1.0, &place, &to).to_f64();
                if upper * (1.0 + SLACK) < best[which] {
                    continue;
                }
                let candidates = &mut self.candidates[which];
                candidates.push(Candidate {
                    upper: upper * (1.0 + SLACK),
                    index,
                    from: [p, v],
                });
                if candidates.len() >= KEPT && candidates.len().is_power_of_two() {
                    candidates.retain(|candidate| candidate.upper >= best[which]);
                }
            }
            self.most[0] = self.most[0].max(p_to.abs());
            self.most[1] = self.most[1].max(v_to.abs());
            self.most[2] = self.most[2].max(pushed);
            (p, v, p_rough, v_rough) = (p_next, v_next, p_to, v_to);
        }
        for (candidates, best) in self.candidates.iter_mut().zip(best) {
            candidates.retain(|candidate| candidate.upper >= best);
        }
        [p, v]
    }
}

/// |g(t)| ≤ max(|g₀|, |g₁|) + max|g″|/8 within an interval.
struct Quick {
    of_size: f64,
    of_push: f64,
}

impl Quick {
    fn of<T: Real>(form: &Form<T>, oscillator: &Oscillator) -> Quick {
        let eighth = form.norm() / 8.0 * (1.0 + SLACK);
        Quick {
            // The roundings of the forms as well.
            of_size: eighth * oscillator.norm * oscillator.norm + form.norm() * SLACK,
            of_push: eighth * (oscillator.norm + 2.0),
        }
    }
}

/// The law of the base in an interval: in units of it.
fn law<T: Real>(base: &BaseAcceleration, index: usize) -> [T; 3] {
    let unit = T::from(base.interval());
    let BaseAcceleration::Record(record) = base else {
        return base.pulse().map(|part| T::from(part) * unit);
    };
    let from = T::from(record.values[index]);
    let rise = match record.hold {
        Hold::Zero => T::ZERO,
        Hold::First => T::from(record.values[index + 1]) - from,
    };
    [from * unit, rise * unit, T::ZERO]
}

/// A straight law at the end of its interval.
fn end_of<T: Real>(law: &[T; 3]) -> [T; 3] {
    [law[0] + law[1], law[1], law[2]]
}

/// Adds the free motion after the end, until its first extremum or until it cannot come to more: later ones are smaller.
fn swing<T: Real>(
    oscillator: &Oscillator,
    search: &mut Search<'_, T>,
    form: Form<T>,
    ended: f64,
    end: [T; 2],
) {
    let mut place: Place<T> = (end, [T::ZERO; 3]);
    let turning = (1.0 - oscillator.ratio.powi(2)).max(0.0).sqrt() * oscillator.w;
    let (mut offset, mut level) = (0.0, 0);
    loop {
        let [p, v] = place.0.map(T::to_f64);
        let most = form.norm() * p.hypot(v) * (1.0 + SLACK);
        let outdone = offset > 0.0 && most <= search.best().to_f64() * (1.0 - SLACK);
        if most == 0.0 || !most.is_finite() || outdone || turning * offset > 3.15 {
            return;
        }
        place = search.add(ended, offset, level, place);
        offset += (-level as f64).exp2();
        level -= 1;
    }
}

/// ω^power times the largest value, which may be off by `error`.
fn scaled<T: Real>(
    largest: &Largest<T>,
    error: Magnitude,
    rate: DoubleDouble,
    relative: Magnitude,
    power: i32,
) -> SpectralPeak {
    let wide = |x: T| {
        let high = x.to_f64();
        DoubleDouble::from(high) + DoubleDouble::from((x - T::from(high)).to_f64())
    };
    let (lower, upper) = (wide(largest.lower), wide(largest.upper));
    let middle = (lower + upper).mul_f64(0.5);
    let half = (upper - lower).upper() * Magnitude::from(0.5);
    let unit = DoubleDouble::unit() * Magnitude::from(4.0);
    let off = half + error + middle.upper() * unit;
    let (exact, off) = match power {
        -1 => (
            middle / rate,
            off * Magnitude::from(1.0 + SLACK) / rate.magnitude(),
        ),
        0 => (middle, off),
        _ => (middle * rate, off * rate.upper()),
    };
    let off = off + exact.upper() * (relative + unit) + DoubleDouble::floor();
    let value = exact.to_f64();
    let bound = off + (exact - DoubleDouble::from(value)).upper();
    SpectralPeak {
        value,
        bound: bound.to_f64(),
        time: largest.time,
        time_bound: None,
    }
}
