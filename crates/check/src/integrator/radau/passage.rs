//! Steps of Radau IIA within one stretch. The equation is linear, so that Newton's iteration ends
//! with its first step; what that is added to is the last step's polynomial continued, which leaves
//! little for it to round.

use faer::c64;

use super::super::adaptive::{Allowed, Passage, Steps};
use super::super::course::Stretch;
use super::Radau;
use super::collocation::Collocation;
use super::tableau::{ALPHA, BETA, C, ERROR, FROM_TRANSFORMED, GAMMA, TO_TRANSFORMED};

/// What a step aims at, of the error allowed, for the length of the next.
const SAFETY: f64 = 0.9;

/// The method at work within one stretch.
pub(super) struct Marching<'s, 'e> {
    radau: &'s mut Radau<'e>,
    stretch: &'s Stretch<'s>,
    steps: Steps,
    elapsed: f64,
    /// What `elapsed` lacks by rounding; over a million equal steps it would add up.
    rest: f64,
    state: Vec<f64>,
    /// The state's derivative there.
    slope: Vec<f64>,
    wanted: f64,
    /// The last step taken: its length and error.
    last: Option<(f64, f64)>,
    polynomial: Option<Collocation>,
    rejected: bool,
}

impl<'s, 'e> Marching<'s, 'e> {
    pub(super) fn begin(
        radau: &'s mut Radau<'e>,
        stretch: &'s Stretch<'s>,
        state: &[f64],
        steps: Steps,
    ) -> Marching<'s, 'e> {
        let mut marching = Marching {
            radau,
            stretch,
            steps,
            elapsed: 0.0,
            rest: 0.0,
            state: state.to_vec(),
            slope: vec![0.0; state.len()],
            // The estimate of the error does not see what a longer step extinguishes.
            wanted: steps.careful.min(steps.longest),
            last: None,
            polynomial: None,
            rejected: false,
        };
        marching.slope = marching.slope_of(0.0, state);
        marching
    }

    fn slope_of(&mut self, elapsed: f64, state: &[f64]) -> Vec<f64> {
        let equation = self.radau.equation;
        self.radau.evaluations += 1;
        let n = equation.len();
        let mut slope = vec![0.0; 2 * n];
        slope[..n].copy_from_slice(&state[n..]);
        equation.acceleration(state, &self.stretch.forces, elapsed, &mut slope[n..]);
        slope
    }

    /// The stages of a step of `h` s, less the state.
    fn stages(&mut self, h: f64) -> [Vec<f64>; 3] {
        let guess = C.map(|c| {
            let mut stage = self.state.clone();
            if let Some(polynomial) = &self.polynomial {
                polynomial.at(self.elapsed + c * h, &mut stage);
            }
            stage
        });
        let slopes = [0, 1, 2].map(|i| self.slope_of(self.elapsed + C[i] * h, &guess[i]));
        let mut z = guess;
        for stage in &mut z {
            for (value, state) in stage.iter_mut().zip(&self.state) {
                *value -= state;
            }
        }
        let transformed = |row: usize, stages: &[Vec<f64>; 3], i: usize| -> f64 {
            (0..3).map(|j| TO_TRANSFORMED[row][j] * stages[j][i]).sum()
        };
        let (gamma, alpha, beta) = (GAMMA / h, ALPHA / h, BETA / h);
        let size = self.state.len();
        let w = |i: usize| [0, 1, 2].map(|row| transformed(row, &z, i));
        let f = |i: usize| [0, 1, 2].map(|row| transformed(row, &slopes, i));
        let mut real: Vec<f64> = (0..size).map(|i| f(i)[0] - gamma * w(i)[0]).collect();
        let complex = (0..size).map(|i| {
            let (w, f) = (w(i), f(i));
            c64::new(
                f[1] - (alpha * w[1] - beta * w[2]),
                f[2] - (beta * w[1] + alpha * w[2]),
            )
        });
        let mut complex: Vec<c64> = complex.collect();
        self.radau.real.apply(&mut real);
        self.radau.complex.apply(&mut complex);
        for (row, stage) in FROM_TRANSFORMED.iter().zip(&mut z) {
            for (i, value) in stage.iter_mut().enumerate() {
                *value += row[0] * real[i] + row[1] * complex[i].re + row[2] * complex[i].im;
            }
        }
        z
    }

    /// The estimate of a step's error, as a multiple of what is allowed.
    fn error(&mut self, h: f64, z: &[Vec<f64>; 3], allowed: Allowed) -> f64 {
        let weigh = |i: usize| (0..3).map(|j| ERROR[j] * z[j][i]).sum::<f64>() / h;
        let stages: Vec<f64> = (0..self.state.len()).map(weigh).collect();
        let mut error = sum(&stages, &self.slope);
        self.radau.real.apply(&mut error);
        let size = relative(&error, allowed);
        // Once more through the resolvent where the error is of fast motions, which it damps.
        if size < 1.0 || (self.last.is_some() && !self.rejected) {
            return size;
        }
        let moved = sum(&self.state, &error);
        let slope = self.slope_of(self.elapsed, &moved);
        error = sum(&stages, &slope);
        self.radau.real.apply(&mut error);
        relative(&error, allowed)
    }

    /// How much longer the next step may be, after one of `h` s and this error.
    fn growth(&self, h: f64, error: f64) -> f64 {
        let plain = SAFETY * error.powf(-0.25);
        // Gustafsson's controller, which sees how the error changes.
        let foreseen = self.last.map_or(f64::INFINITY, |(last_h, last_error)| {
            plain * (h / last_h) * (last_error / error).powf(0.25)
        });
        plain.min(foreseen).clamp(0.2, 8.0)
    }
}

impl Passage for Marching<'_, '_> {
    fn elapsed(&self) -> f64 {
        self.elapsed
    }

    fn state(&self) -> &[f64] {
        &self.state
    }

    fn wanted(&self) -> f64 {
        self.wanted
    }

    fn attempt(&mut self, h: f64, allowed: Allowed) -> Result<bool, String> {
        let h = h.min(self.wanted);
        if self.elapsed + h <= self.elapsed {
            return Err("its step vanishes".to_owned());
        }
        self.radau.real.factorise(h / GAMMA)?;
        self.radau
            .complex
            .factorise(c64::new(h, 0.0) / c64::new(ALPHA, BETA))?;
        let z = self.stages(h);
        let error = self.error(h, &z, allowed);
        if !error.is_finite() {
            return Err("its motion leaves the range of doubles".to_owned());
        }
        // An error of exactly 0 would make the growth infinite.
        let error = error.max(1e-10);
        if error >= 1.0 {
            self.wanted = h * (SAFETY * error.powf(-0.25)).max(0.2);
            self.rejected = true;
            return Ok(false);
        }
        let mut growth = self.growth(h, error);
        if self.rejected {
            growth = growth.min(1.0);
        }
        // A step so little longer is not worth new factorisations.
        if (1.0..1.2).contains(&growth) {
            growth = 1.0;
        }
        self.wanted = (growth * h).min(self.steps.longest);
        self.last = Some((h, error.max(1e-2)));
        self.rejected = false;
        let end = sum(&self.state, &z[2]);
        self.polynomial = Some(Collocation::of(self.elapsed, h, &end, &z));
        let (start, ahead) = (self.elapsed, h + self.rest);
        (self.elapsed, self.rest) = match h == self.steps.whole - start {
            true => (self.steps.whole, 0.0),
            false => (start + ahead, ahead - (start + ahead - start)),
        };
        self.slope = self.slope_of(self.elapsed, &end);
        self.state = end;
        Ok(true)
    }

    fn between(&self, elapsed: f64, state: &mut [f64]) -> Result<(), String> {
        if let Some(polynomial) = &self.polynomial {
            polynomial.at(elapsed, state);
        }
        Ok(())
    }
}

fn sum(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

/// The largest entry of [x; x′], relative to what is allowed; NaN if there is one.
fn relative(error: &[f64], allowed: Allowed) -> f64 {
    let (displacement, velocity) = error.split_at(error.len() / 2);
    let largest = |part: &[f64], allowed: f64| {
        part.iter().fold(0.0, |most: f64, value| {
            let ratio = value.abs() / allowed;
            if ratio <= most || most.is_nan() {
                most
            } else {
                ratio
            }
        })
    };
    let (a, b) = (
        largest(displacement, allowed.displacement),
        largest(velocity, allowed.velocity),
    );
    if a <= b || b.is_nan() { b } else { a }
}
