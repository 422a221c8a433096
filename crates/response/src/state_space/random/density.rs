//! Spectral densities of the stationary motion, Σ S|H|² over the sources.

use std::f64::consts::TAU;

use super::{Noise, QUANTITIES, RandomVibration};
use crate::frequency_response::{FrequencyError, FrequencyResponse};
use crate::problem::{Combination, Quantity};

/// The one-sided spectral density of one motion.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectralDensity {
    /// Of which coordinate, point or output.
    pub name: String,
    /// Which derivative of its displacement; `None` for an output.
    pub quantity: Option<Quantity>,
    /// For each frequency the density in the square of its unit per Hz, and a proven bound of the error; `None` where it is
    /// infinite or not known.
    pub values: Vec<Option<(f64, f64)>>,
}

/// What drives one coordinate, point or support.
struct Source<'n> {
    name: &'n str,
    all: Vec<(Option<Quantity>, Noise)>,
}

impl Source<'_> {
    /// The density of the force, or of the displacement of the support, in its square per Hz, within 8 units; infinite for a
    /// displacement that wanders.
    fn density(&self, frequency: f64) -> f64 {
        let within = |noise: &Noise| match noise.band {
            None => true,
            Some([low, high]) => (TAU * low..=TAU * high).contains(&frequency),
        };
        let all = self.all.iter().filter(|(_, noise)| within(noise));
        let of = |(quantity, noise): &(Option<Quantity>, Noise)| {
            let integrals = quantity.map_or(0, |quantity| quantity as i32);
            match noise.density == 0.0 {
                true => 0.0,
                false => noise.density / frequency.powi(2 * integrals),
            }
        };
        all.map(of).sum()
    }
}

impl RandomVibration<'_> {
    /// The ends of all bands as Ω in rad/s, where densities jump, each with its neighbours; those at 0 are left out.
    pub fn ends(&self) -> Vec<f64> {
        let bands = self.sources.iter().filter_map(|(.., noise)| noise.band);
        let ends = bands.flatten().map(|end| TAU * end);
        let ends = ends.filter(|end| *end > 0.0 && *end < f64::MAX);
        ends.flat_map(|end| [end.next_down(), end, end.next_up()])
            .collect()
    }

    /// The spectral densities at these frequencies Ω in rad/s, per Hz: displacements, velocities and accelerations of all
    /// coordinates and points, then the outputs. What lies at the end of a band counts as within it.
    ///
    /// # Errors
    /// [`FrequencyError`], as for [`FrequencyResponse::at`].
    pub fn densities(&self, frequencies: &[f64]) -> Result<Vec<SpectralDensity>, FrequencyError> {
        let mut sources: Vec<Source<'_>> = Vec::new();
        for (name, quantity, noise) in &self.sources {
            let one = (*quantity, *noise);
            match sources.iter_mut().find(|source| source.name == name) {
                Some(source) => source.all.push(one),
                None => sources.push(Source {
                    name,
                    all: vec![one],
                }),
            }
        }
        let start = FrequencyResponse::of(self.system);
        let asked = sources
            .iter()
            .fold(start, |asked, source| asked.from(source.name));
        let points = self.system.points().iter().map(|point| &point.name);
        let places: Vec<&String> = self.system.names().iter().chain(points).collect();
        let mut all = Vec::new();
        for quantity in QUANTITIES {
            let asked = asked.clone().quantity(quantity);
            let asked = places.iter().fold(asked, |asked, name| asked.to(*name));
            let names = places.iter().map(|name| (name.as_str(), Some(quantity)));
            all.extend(read(&sources, &asked, names, frequencies)?);
        }
        if !self.outputs.is_empty() {
            let outputs = self.outputs.iter().cloned();
            let asked = outputs.fold(asked, FrequencyResponse::output);
            let name = |output: &Combination| output.name.clone();
            let names: Vec<String> = self.outputs.iter().map(name).collect();
            let names = names.iter().map(|name| (name.as_str(), None));
            all.extend(read(&sources, &asked, names, frequencies)?);
        }
        Ok(all)
    }
}

fn read<'n>(
    sources: &[Source<'_>],
    asked: &FrequencyResponse<'_>,
    names: impl Iterator<Item = (&'n str, Option<Quantity>)>,
    frequencies: &[f64],
) -> Result<Vec<SpectralDensity>, FrequencyError> {
    let functions = asked.at(frequencies)?;
    let mut all: Vec<SpectralDensity> = names
        .map(|(name, quantity)| SpectralDensity {
            name: name.to_owned(),
            quantity,
            values: vec![Some((0.0, 0.0)); frequencies.len()],
        })
        .collect();
    let by_source = functions.functions().chunks(all.len());
    for (source, functions) in sources.iter().zip(by_source) {
        for (density, function) in all.iter_mut().zip(functions) {
            let values = density.values.iter_mut().zip(function.values());
            for ((sum, value), &frequency) in values.zip(frequencies) {
                let given = source.density(frequency);
                if given == 0.0 {
                    continue;
                }
                let known = value
                    .known()
                    .and_then(|(value, bound)| Some((value, bound?)));
                *sum = sum.zip(known).and_then(|((sum, off), (value, bound))| {
                    let size = value.norm();
                    let (square, spread) = (size * size, (2.0 * size + bound) * bound);
                    let next = sum + given * square;
                    // 8 units of the density, 4 of the square, one for each sum, and the products of this very bound.
                    let off = off + given * (spread + 16.0 * f64::EPSILON * (square + spread));
                    let off = (off + next * f64::EPSILON).next_up();
                    (next.is_finite() && off.is_finite()).then_some((next, off))
                });
            }
        }
    }
    Ok(all)
}
