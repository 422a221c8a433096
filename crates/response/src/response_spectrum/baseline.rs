//! What a record of accelerations leaves of the base itself.

use eigentone_digits::DoubleDouble;

use super::base::BaseAcceleration;
use super::error::SpectrumError;
use crate::problem::{Hold, Samples};

/// The motion of the base itself, from rest, at the end of a record: what a good baseline correction leaves near 0.
/// Summed in double-double and rounded once.
///
/// ```
/// use eigentone_response::{Baseline, Hold, Samples};
///
/// let record = Samples { step: 0.5, values: vec![0.0, 2.0, -1.0, 0.0], hold: Hold::First };
/// let baseline = Baseline::of(&record)?;
/// assert_eq!((baseline.peak, baseline.peak_time), (2.0, 0.5));
/// assert_eq!((baseline.velocity, baseline.duration), (0.5, 1.5));
/// # Ok::<(), eigentone_response::SpectrumError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Baseline {
    /// How long the record is, in s.
    pub duration: f64,
    /// The largest acceleration in size (PGA), in m/s².
    pub peak: f64,
    /// When, in s.
    pub peak_time: f64,
    /// The mean acceleration, in m/s².
    pub mean: f64,
    /// The velocity at the end, in m/s.
    pub velocity: f64,
    /// The displacement at the end, in m.
    pub displacement: f64,
}

impl Baseline {
    /// Of a record.
    ///
    /// # Errors
    /// [`SpectrumError::Base`] for a record without samples, with one that is not finite, or without a step, and
    /// [`SpectrumError::BaseRange`] where a sum of samples leaves the range of doubles.
    pub fn of(record: &Samples) -> Result<Baseline, SpectrumError> {
        BaseAcceleration::Record(record.clone()).check()?;
        let values = &record.values;
        let step = DoubleDouble::from(record.step);
        let (mut velocity, mut displacement) = (DoubleDouble::ZERO, DoubleDouble::ZERO);
        let (two, three, six) = (2.0, 3.0, 6.0);
        let [two, three, six] = [two, three, six].map(DoubleDouble::from);
        let mut advance = |from: f64, to: f64| {
            let (from, to) = (DoubleDouble::from(from), DoubleDouble::from(to));
            let rest = from / three + to / six;
            displacement = displacement + velocity + rest;
            velocity += (from + to) / two;
        };
        let intervals = match record.hold {
            Hold::Zero => {
                values.iter().for_each(|value| advance(*value, *value));
                values.len()
            }
            Hold::First => {
                values.windows(2).for_each(|pair| advance(pair[0], pair[1]));
                values.len() - 1
            }
        };
        let largest =
            (0..values.len()).fold(0, |best, at| match values[at].abs() > values[best].abs() {
                true => at,
                false => best,
            });
        let count = DoubleDouble::from(intervals as f64);
        let mean = match intervals {
            0 => DoubleDouble::from(values[0]),
            _ => velocity / count,
        };
        let found = Baseline {
            duration: (step * count).to_f64(),
            peak: values[largest].abs(),
            peak_time: largest as f64 * record.step,
            mean: mean.to_f64(),
            velocity: (velocity * step).to_f64(),
            displacement: (displacement * step * step).to_f64(),
        };
        let motion = [
            found.duration,
            found.mean,
            found.velocity,
            found.displacement,
        ];
        match motion.iter().all(|value| value.is_finite()) {
            true => Ok(found),
            false => Err(SpectrumError::BaseRange),
        }
    }
}
