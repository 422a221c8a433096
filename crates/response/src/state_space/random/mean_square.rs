//! Mean squares of stationary motions, by noise of one band after the other.
//!
//! The response to an input is G(s) = C(s − A)⁻¹B + Σ Lₖsᵏ, and its mean square S/2π·∫|G(iω)|²dω over the band, for a density
//! of S per Hz. As BSBᵀ/2 = (iω − A)P + P(−iω − Aᵀ) for the covariance P under white noise, the first part is
//! (C Φ P Cᵀ + C P Φᵀ Cᵀ)/π with Φ = Re ∫(iω − A)⁻¹dω (Gawronski & Juang 1990, *Int. J. Syst. Sci.* 21): P itself for all
//! frequencies, where Φ = π/2. The others follow from sᵏ(s − A)⁻¹ = Aᵏ(s − A)⁻¹ + sᵏ⁻¹ + A sᵏ⁻² + … + Aᵏ⁻¹.

use eigentone_digits::{Ball, BallMatrix, Magnitude, Real, WideComplex};
use faer::Mat;

use super::Noise;
use super::band::of_band;
use super::statistics::Rms;
use super::weighting::Weighting;
use crate::enclosed::Normed;
use crate::problem::{Known, Rate};
use crate::state_space::asked::Asked;
use crate::state_space::coordinates::{Coordinates, kept};
use crate::state_space::ladder::{Found, Question};
use crate::state_space::noise::accumulated;
use crate::state_space::realisation::Realisation;

/// Digits of a variance that are to be right, and how small it may be beside what bounds it before they do not count.
const RIGHT: i64 = -54;
const NOTHING: i64 = -200;

pub(super) struct MeanSquares<'a> {
    pub(super) asked: &'a Asked<'a>,
    /// By input.
    pub(super) noises: Vec<Noise>,
    /// The time with which the integral over all the time begins.
    pub(super) step: f64,
    /// By output and input, whether it follows nothing of [u/s², u/s], where that is decided exactly.
    pub(super) settled: Vec<Vec<[Option<bool>; 2]>>,
    /// What all is read through.
    pub(super) weighting: Option<Weighting>,
}

/// The least power of s in Σ Lₖsᵏ.
const LEAST: i32 = -2;

/// Lₖ from u/s² on.
type Direct<T> = Vec<BallMatrix<T>>;

impl Question for MeanSquares<'_> {
    /// Of all outputs, then of their rates.
    type Answer = Vec<Rms>;

    fn attempt<T: Real>(&self) -> Found<Vec<Rms>> {
        Ok(self.of_digits::<T>())
    }
}

/// The mean square of an output: its value, how far it may be off, and what is nothing beside it.
#[derive(Clone, Copy)]
struct Sum<T> {
    value: Ball<T>,
    nothing: Magnitude,
}

impl MeanSquares<'_> {
    fn of_digits<T: Real>(&self) -> Option<(Vec<Rms>, bool)> {
        let form = Realisation::<T>::of(self.asked)?.with_rates();
        let (mut form, [twice, once]) = form.beside_integrals(self.asked)?;
        let mut direct = vec![twice, once];
        for (output, settled) in self.settled.iter().enumerate() {
            for (input, settled) in settled.iter().enumerate() {
                for (part, _) in direct
                    .iter_mut()
                    .zip(settled)
                    .filter(|(_, settled)| **settled == Some(true))
                {
                    part.set(output, input, T::ZERO, Magnitude::ZERO);
                }
            }
        }
        direct.push(form.d.clone());
        direct.append(&mut form.of_derivatives);
        let rows = form.c.rows();
        let nothing = Sum {
            value: Ball::ZERO,
            nothing: Magnitude::ZERO,
        };
        let mut sums = vec![nothing; rows];
        let noises = 0..self.noises.len();
        let inputs: Vec<usize> = noises
            .filter(|at| self.noises[*at].density != 0.0)
            .collect();
        let direct = match self.weighting {
            None => {
                self.add_all(&mut sums, &inputs, &form, &direct)?;
                direct
            }
            // What is read through it is what inputs make that come through it.
            Some(weighting) => {
                let mut passed = vec![BallMatrix::zeros(rows, self.noises.len()); direct.len()];
                for input in inputs {
                    let (form, direct) = weighting.before(&form, &direct, input);
                    self.add_all(&mut sums, &[input], &form, &direct)?;
                    for (sum, part) in passed.iter_mut().zip(&direct) {
                        *sum = sum.plus(part);
                    }
                }
                passed
            }
        };

        let (mut all, mut good) = (Vec::new(), true);
        for (row, sum) in sums.into_iter().enumerate() {
            if let Some((input, certain)) = self.unbounded(&direct, row) {
                let by = self.asked.inputs[input].clone();
                good &= certain;
                all.push(match certain {
                    true => Rms::Infinite { by },
                    false => Rms::Undecided { by },
                });
                continue;
            }
            let (variance, radius) = (sum.value.middle().re, sum.value.radius());
            let nothing = sum.nothing * Magnitude::power_of_two(NOTHING);
            let counts = match variance.upper() < nothing {
                true => nothing,
                false => variance.upper(),
            };
            good &= radius <= counts * Magnitude::power_of_two(RIGHT);
            all.push(Rms::of_variance(variance, radius)?);
        }
        Some((all, good))
    }

    /// Adds what the noises on these inputs make of each output, of a form whose other inputs have none.
    fn add_all<T: Real>(
        &self,
        sums: &mut [Sum<T>],
        inputs: &[usize],
        form: &Realisation<T>,
        direct: &Direct<T>,
    ) -> Option<()> {
        let coordinates = Coordinates::of(self.asked, form, self.step)?;
        let mut bands: Vec<Option<[f64; 2]>> = Vec::new();
        for input in inputs {
            let band = self.noises[*input].band;
            if !bands.contains(&band) {
                bands.push(band);
            }
        }
        let mut each = bands.into_iter();
        each.try_for_each(|band| self.add(sums, band, &coordinates, form, direct))
    }

    /// The noise that makes an output infinite, and whether that is certain: what is white without end passes on by any power
    /// of s from 0 on, what begins at frequency 0 by those below.
    fn unbounded<T: Real>(&self, direct: &Direct<T>, row: usize) -> Option<(usize, bool)> {
        let parts = |input: usize| {
            let noise = &self.noises[input];
            let range = match noise.band {
                _ if noise.density == 0.0 => 0..0,
                None => 0..direct.len(),
                Some([0.0, _]) => 0..-LEAST as usize,
                Some(_) => 0..0,
            };
            range.filter(move |at| !direct[*at].is_zero(row, input))
        };
        let inputs = || 0..self.noises.len();
        let certain = |at: usize, input: usize| {
            let decided = self.settled[row][input].get(at);
            decided == Some(&Some(false)) || !entry(&direct[at], row, input).contains_zero()
        };
        let passed = |input: &usize| parts(*input).any(|at| certain(at, *input));
        if let Some(input) = inputs().find(passed) {
            return Some((input, true));
        }
        let possible = |input: &usize| parts(*input).next().is_some();
        inputs().find(possible).map(|input| (input, false))
    }

    /// Adds what the noises of one band make of each output.
    fn add<T: Real>(
        &self,
        sums: &mut [Sum<T>],
        band: Option<[f64; 2]>,
        coordinates: &Coordinates<T>,
        form: &Realisation<T>,
        direct: &Direct<T>,
    ) -> Option<()> {
        let (n, inputs) = (form.a.rows(), self.noises.len());
        let mut density = Mat::<f64>::zeros(inputs, inputs);
        let here = |input: &usize| {
            let noise = &self.noises[*input];
            noise.band == band && noise.density != 0.0
        };
        for input in (0..inputs).filter(here) {
            density[(input, input)] = self.noises[input].density / 2.0;
        }
        let white = accumulated(coordinates, form, density.as_ref(), self.step, true)?;
        let block = |matrix: &Normed<T>| kept(matrix, 0, n, n);
        let Some(band) = band else {
            let (exact, sizes) = coordinates.covariance(&form.c, &block(&white), white.error());
            let norm = white.true_norm();
            for (row, (sum, size)) in sums.iter_mut().zip(sizes).enumerate() {
                sum.value = sum.value + entry(&exact, row, row);
                sum.nothing = sum.nothing + size * size * norm;
            }
            return Some(());
        };

        let turn = Rate::HalfTurns(2, 1.0).value::<T>();
        let limits = band.map(|hertz| known(turn) * exactly(hertz));
        let resolvent = Normed::of(&coordinates.a, n).with_more_error(coordinates.a_error);
        let within = limits.map(|limit| (limit.middle().re, limit.radius()));
        let phi = of_band(&resolvent, within)?;
        let product = phi.times(&white);
        let (exact, sizes) = coordinates.covariance(&form.c, &block(&product), product.error());
        let norm = product.true_norm();
        let per_hertz = exactly(1.0).checked_div(known(turn))?;
        for (row, (sum, size)) in sums.iter_mut().zip(sizes).enumerate() {
            // 2/π = 4/2π.
            sum.value = sum.value + entry(&exact, row, row) * per_hertz * exactly(4.0);
            sum.nothing = sum.nothing + size * size * norm;
        }
        let follows =
            |row: usize, input: usize| direct.iter().any(|part| !part.is_zero(row, input));
        if (0..sums.len()).all(|row| (0..inputs).filter(here).all(|input| !follows(row, input))) {
            return Some(());
        }
        let phi = coordinates.map(&block(&phi), phi.error());
        let moments = Moments::of(form, &phi, direct)?;
        for (row, sum) in sums.iter_mut().enumerate() {
            for input in (0..inputs)
                .filter(here)
                .filter(|input| follows(row, *input))
            {
                if self.unbounded(direct, row).is_some() {
                    continue;
                }
                let square = moments.beside(direct, [row, input], limits)?;
                let density = exactly(self.noises[input].density);
                sum.value = sum.value + square * density * per_hertz;
            }
        }
        Some(())
    }
}

/// C AᵏB and C AᵏΦB from the least power on.
struct Moments<T> {
    plain: Vec<BallMatrix<T>>,
    of_band: Vec<BallMatrix<T>>,
}

impl<T: Real> Moments<T> {
    fn of(form: &Realisation<T>, phi: &BallMatrix<T>, direct: &Direct<T>) -> Option<Moments<T>> {
        let behind = |part: &BallMatrix<T>| {
            let entries = |i| (0..part.columns()).map(move |j| (i, j));
            (0..part.rows())
                .flat_map(entries)
                .any(|(i, j)| !part.is_zero(i, j))
        };
        let falling = direct[..-LEAST as usize].iter().any(behind);
        let all = |start: BallMatrix<T>| {
            let mut states = Vec::new();
            let mut last = start.clone();
            for _ in LEAST..0 {
                last = match falling {
                    true => form.a.solve(&last)?,
                    false => BallMatrix::zeros(start.rows(), start.columns()),
                };
                states.insert(0, last.clone());
            }
            let mut last = start;
            while states.len() < direct.len() {
                let next = form.a.times(&last);
                states.push(std::mem::replace(&mut last, next));
            }
            Some(states.iter().map(|states| form.c.times(states)).collect())
        };
        Some(Moments {
            plain: all(form.b.clone())?,
            of_band: all(phi.times(&form.b))?,
        })
    }

    /// ∫(|G|² − |C(s − A)⁻¹B|²)dω between the limits.
    fn beside(
        &self,
        direct: &Direct<T>,
        [row, input]: [usize; 2],
        [low, high]: [Ball<T>; 2],
    ) -> Option<Ball<T>> {
        let powers = LEAST..LEAST + direct.len() as i32;
        let at = |all: &[BallMatrix<T>], k: i32| entry(&all[(k - LEAST) as usize], row, input);
        // Of s²ᵏ, from the least: |Σ Lₖsᵏ|² = Σ LₖLₗ(−1)ˡsᵏ⁺ˡ.
        let mut coefficients = vec![Ball::ZERO; 2 * direct.len()];
        let mut add = |k: i32, value: Ball<T>| {
            if k % 2 == 0 {
                let sum = &mut coefficients[((k - 2 * LEAST) / 2) as usize];
                *sum = *sum + value;
            }
        };
        let mut square = Ball::ZERO;
        for k in powers.clone() {
            let factor = at(direct, k);
            if direct[(k - LEAST) as usize].is_zero(row, input) {
                continue;
            }
            for l in powers.clone() {
                add(k + l, factor * at(direct, l) * exactly(sign(l)));
            }
            let twice = factor * exactly(2.0 * sign(k));
            square = square + twice * at(&self.of_band, k);
            for m in k.min(0)..k.max(0) {
                let term = twice * at(&self.plain, m) * exactly(if k < 0 { -1.0 } else { 1.0 });
                add(k - 1 - m, term);
            }
        }
        for (at, coefficient) in coefficients.into_iter().enumerate() {
            let k = 2 * (at as i32 + LEAST);
            if coefficient.is_zero() {
                continue;
            }
            let term = power(high, k + 1)? + -power(low, k + 1)?;
            let factor = exactly(sign(k / 2)).checked_div(exactly(f64::from(k + 1)))?;
            square = square + coefficient * factor * term;
        }
        Some(square)
    }
}

/// (−1)ᵏ.
fn sign(k: i32) -> f64 {
    if k % 2 == 0 { 1.0 } else { -1.0 }
}

/// xᵏ; `None` for a power below 0 of what may be 0.
fn power<T: Real>(x: Ball<T>, k: i32) -> Option<Ball<T>> {
    let all = (0..k.abs()).fold(exactly(1.0), |all, _| all * x);
    if k < 0 {
        exactly(1.0).checked_div(all)
    } else {
        Some(all)
    }
}

fn exactly<T: Real>(x: f64) -> Ball<T> {
    Ball::from(WideComplex::new(x, 0.0))
}

fn known<T: Real>((value, error): Known<T>) -> Ball<T> {
    Ball::new(WideComplex::new(value, T::ZERO), error)
}

fn entry<T: Real>(matrix: &BallMatrix<T>, i: usize, j: usize) -> Ball<T> {
    known((matrix.middle(i, j), matrix.radius(i, j)))
}
