//! Stationary motion under noise that is white, or is within a band.

mod band;
mod density;
mod estimated;
mod mean_square;
mod settled;
mod statistics;
mod weighting;

use eigentone_modes::{FirstOrder, System};

pub use self::density::SpectralDensity;
pub use self::estimated::MeanSquare;
use self::mean_square::MeanSquares;
use self::settled::settled;
pub use self::statistics::{Rms, Statistics};
pub use self::weighting::Weighting;
use super::asked::Asked;
use super::error::StateSpaceError;
use super::ladder::{affordable, climb};
use super::model::{OF_DOUBLINGS, first_step, operations};
use super::noise::{comes_to_rest, not_shown};
use crate::problem::{Combination, Quantity, Sum};

const QUANTITIES: [Quantity; 3] = [
    Quantity::Displacement,
    Quantity::Velocity,
    Quantity::Acceleration,
];

/// How many exponentials the resolvent over a band counts for: products for each of the pieces of its way, of matrices with
/// four times as many entries.
const OF_BAND: f64 = 80.0;

/// A stationary noise of zero mean and constant density.
///
/// Densities S are one-sided, in the square of the unit per Hz: the mean square of what lies between f and f + df is S df,
/// f > 0. Over frequencies of both signs it is S/2 per Hz, and white noise w has E[w(t)w(s)] = (S/2) δ(t − s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// The density between the ends of the band, 0 or more.
    pub density: f64,
    /// The ends of the band in Hz, 0 ≤ f₁ < f₂; `None` for white noise, which has power at all frequencies.
    pub band: Option<[f64; 2]>,
}

impl Noise {
    /// White noise of this density.
    pub fn white(density: f64) -> Noise {
        Noise {
            density,
            band: None,
        }
    }

    /// Noise of this density between two frequencies in Hz, and nothing outside.
    pub fn within(density: f64, band: [f64; 2]) -> Noise {
        Noise {
            density,
            band: Some(band),
        }
    }
}

/// White noise of this density.
impl From<f64> for Noise {
    fn from(density: f64) -> Noise {
        Noise::white(density)
    }
}

/// Noise that drives a system, each source independent of the others, and what is asked of the motion that it keeps up in the
/// long run.
///
/// ```
/// use eigentone_modes::{GROUND, System};
/// use eigentone_response::{Noise, RandomVibration, Rms};
///
/// let system = System::builder().mass("m", 2.0).spring(GROUND, "m", 8.0).damper(GROUND, "m", 0.5);
/// let system = system.build()?;
/// let motion = RandomVibration::of(&system).force("m", 4.0).solve()?;
/// // √(S/4ck) and √(S/4cm).
/// let (value, bound) = motion.displacement()[0].rms.finite().expect("it is held");
/// assert!(value == 0.5 && bound < 1e-16);
/// assert_eq!(motion.velocity()[0].rms.finite().map(|(value, _)| value), Some(1.0));
/// // The force is white, and so is the acceleration of what it acts on: it has no mean square.
/// assert!(matches!(motion.acceleration()[0].rms, Rms::Infinite { .. }));
/// // Below 1 kHz it has one.
/// let noise = Noise::within(4.0, [0.0, 1e3]);
/// let motion = RandomVibration::of(&system).force("m", noise).solve()?;
/// let (value, _) = motion.acceleration()[0].rms.finite().expect("within a band");
/// assert!((value - 1000f64.sqrt()).abs() < 0.1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "nothing is computed until `solve` is called"]
pub struct RandomVibration<'a> {
    system: &'a System,
    sources: Vec<(String, Option<Quantity>, Noise)>,
    outputs: Vec<Combination>,
}

/// Root mean squares of the stationary motion of a [`RandomVibration`].
#[derive(Clone, Debug, PartialEq)]
pub struct StationaryMotion {
    motions: [Vec<Statistics>; 3],
    outputs: Vec<Statistics>,
}

impl<'a> RandomVibration<'a> {
    /// Starts from a system, without noise.
    pub fn of(system: &'a System) -> RandomVibration<'a> {
        RandomVibration {
            system,
            sources: Vec::new(),
            outputs: Vec::new(),
        }
    }

    /// A force on a coordinate or point, of a density in N²/Hz.
    pub fn force(
        mut self,
        name: impl Into<String>,
        noise: impl Into<Noise>,
    ) -> RandomVibration<'a> {
        self.sources.push((name.into(), None, noise.into()));
        self
    }

    /// The displacement, velocity or acceleration of a support.
    pub fn motion(
        mut self,
        name: impl Into<String>,
        quantity: Quantity,
        noise: impl Into<Noise>,
    ) -> RandomVibration<'a> {
        let source = (name.into(), Some(quantity), noise.into());
        self.sources.push(source);
        self
    }

    /// A combination of motions that is asked for beside those of all coordinates and points.
    pub fn output(mut self, combination: Combination) -> RandomVibration<'a> {
        self.outputs.push(combination);
        self
    }

    /// The root mean squares of all coordinates, points and outputs, and of their rates of change.
    ///
    /// Every value is proven: mean squares under white noise by doubling the time over which they add up, those of a band by
    /// the logarithm of A at its ends, without quadrature, with as many digits as that takes.
    ///
    /// # Errors
    /// [`StateSpaceError`]: names that are not there, densities and bands that are none; [`StateSpaceError::NotStationary`] for
    /// rigid motions and undamped modes, and [`StateSpaceError::NotShownStationary`] for what grows.
    pub fn solve(&self) -> Result<StationaryMotion, StateSpaceError> {
        self.read_through(None)
    }

    /// What [`solve`](Self::solve) finds, read through a weighting. Its high pass keeps away what wanders.
    ///
    /// ```
    /// use eigentone_modes::{GROUND, System};
    /// use eigentone_response::{Noise, RandomVibration, Weighting};
    ///
    /// let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 400.0).damper(GROUND, "m", 1.0);
    /// let system = system.build()?;
    /// let noise = RandomVibration::of(&system).force("m", Noise::within(1.0, [0.5, 20.0]));
    /// let felt = noise.weighted(Weighting::Vertical)?;
    /// let (value, bound) = felt.acceleration()[0].rms.finite().expect("within a band");
    /// assert!((value - 9.18773).abs() < 1e-5 && bound < 2e-16 * value);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn weighted(&self, weighting: Weighting) -> Result<StationaryMotion, StateSpaceError> {
        self.read_through(Some(weighting))
    }

    fn read_through(
        &self,
        weighting: Option<Weighting>,
    ) -> Result<StationaryMotion, StateSpaceError> {
        let system = self.system;
        let mut asked = Asked::of(system);
        let mut noises = Vec::new();
        for (name, quantity, noise) in self.sources.iter().cloned() {
            let density = noise.density;
            if !(density.is_finite() && density >= 0.0) {
                return Err(StateSpaceError::NoiseDensity { name, density });
            }
            if let Some([low, high]) = noise.band
                && !(low >= 0.0 && low < high && high.is_finite())
            {
                return Err(StateSpaceError::NoiseBand { name, low, high });
            }
            match quantity {
                None => asked.force(&name)?,
                Some(quantity) => asked.motion(&name, quantity)?,
            }
            noises.push(noise);
        }
        let points = system.points().iter().map(|point| &point.name);
        let places: Vec<&String> = system.names().iter().chain(points).collect();
        for quantity in QUANTITIES {
            for name in &places {
                asked.output(Combination {
                    name: (*name).clone(),
                    of: Sum::Motions(vec![(quantity, (*name).clone(), 1.0)]),
                })?;
            }
        }
        for output in &self.outputs {
            asked.output(output.clone())?;
        }
        let form = FirstOrder::of(system)?;
        let banded = noises.iter().any(|noise| noise.band.is_some());
        let exponentials = OF_DOUBLINGS + if banded { OF_BAND } else { 0.0 };
        let (states, times) = match weighting {
            None => (form.states(), 1),
            Some(weighting) => (form.states() + weighting.order(), noises.len()),
        };
        let operations = times as f64 * exponentials * operations(states, 0.0);
        affordable(states, operations)?;
        comes_to_rest(system)?;
        let question = MeanSquares {
            asked: &asked,
            step: first_step(form.a()),
            settled: settled(&asked),
            noises,
            weighting,
        };
        let all = climb(&question, states, operations).map_err(not_shown)?;
        let (values, rates) = all.split_at(asked.outputs.len());
        let both = values.iter().zip(rates);
        let mut all = asked
            .outputs
            .iter()
            .zip(both)
            .map(|(name, (rms, rate))| Statistics {
                name: name.clone(),
                rms: rms.clone(),
                rate: rate.clone(),
            });
        let motions = [(); 3].map(|()| all.by_ref().take(places.len()).collect());
        let outputs = all.collect();
        Ok(StationaryMotion { motions, outputs })
    }
}

impl StationaryMotion {
    /// Displacements of all coordinates and points, in m or rad.
    pub fn displacement(&self) -> &[Statistics] {
        &self.motions[0]
    }

    /// Their velocities.
    pub fn velocity(&self) -> &[Statistics] {
        &self.motions[1]
    }

    /// Their accelerations.
    pub fn acceleration(&self) -> &[Statistics] {
        &self.motions[2]
    }

    /// The outputs asked for.
    pub fn outputs(&self) -> &[Statistics] {
        &self.outputs
    }
}
