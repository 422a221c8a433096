//! The mean square of one output under white noise in doubles, for many designs, and how it changes with the matrices.
//!
//! A P + P Aᵀ + Q = 0 and Aᵀ X + X A + cᵀc = 0 are solved together: with F = (A − q)⁻¹(A + q) they are P = FPFᵀ + 2q(A − q)⁻¹Q(A − q)⁻ᵀ
//! and its transpose, sums that double their length at each step (Smith 1968, *SIAM J. Appl. Math.* 16). What P leaves of its
//! equation, weighed by X, is how far cPcᵀ is off: it is added, and what rounding makes of it is the estimate.

use eigentone_modes::FirstOrder;
use faer::Mat;
use faer::linalg::solvers::Solve;

use super::RandomVibration;
use super::settled::settled;
use super::weighting::Weighting;
use crate::frequency_response::{Acts, Reads, StateForm, regular};
use crate::problem::{Combination, Quantity, Source, Sum};
use crate::state_space::asked::Asked;
use crate::state_space::error::StateSpaceError;

/// The mean square of an output in doubles, of a [`RandomVibration`].
#[derive(Clone, Debug)]
pub struct MeanSquare {
    output: String,
    weighting: Option<Weighting>,
    value: f64,
    estimate: f64,
    p: Mat<f64>,
    x: Mat<f64>,
    /// By what the states are divided.
    units: Vec<f64>,
}

impl MeanSquare {
    /// In the square of the unit of the output.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// How far it may be off, as an estimate.
    pub fn estimate(&self) -> f64 {
        self.estimate
    }

    /// cPcᵀ + tr X(AP + PAᵀ + Q) with the A, Q and c of another design: as P and X are, its derivative by whatever these depend on
    /// is that of the mean square, and it is the mean square itself for the design it was made for. `None` where the other has none.
    ///
    /// # Errors
    /// As [`RandomVibration::mean_square`].
    pub fn along(&self, other: &RandomVibration<'_>) -> Result<Option<f64>, StateSpaceError> {
        let Some(form) = other.form(&self.output, self.weighting)? else {
            return Ok(None);
        };
        let fits = form.c.len() == self.units.len();
        Ok(fits.then(|| {
            let scaled = Scaled::of(&form, &self.units);
            let left = scaled.left(&self.p);
            scaled.read(&self.p) + between(&self.x, &left)
        }))
    }
}

/// What noise of one unit, by its strength, makes of one output.
struct Weighed {
    form: StateForm,
    /// Half of the density of each input.
    strengths: Vec<f64>,
}

impl std::ops::Deref for Weighed {
    type Target = StateForm;

    fn deref(&self) -> &StateForm {
        &self.form
    }
}

/// A, Q and c with other units of the states.
struct Scaled {
    a: Mat<f64>,
    q: Mat<f64>,
    c: Vec<f64>,
}

impl Scaled {
    fn of(form: &Weighed, units: &[f64]) -> Scaled {
        let n = units.len();
        let a = Mat::from_fn(n, n, |i, j| form.a[(i, j)] * (units[j] / units[i]));
        let mut q = Mat::<f64>::zeros(n, n);
        for (b, strength) in form.b.iter().zip(&form.strengths) {
            for i in 0..n {
                for j in 0..n {
                    q[(i, j)] += strength * (b[i] / units[i]) * (b[j] / units[j]);
                }
            }
        }
        let c = form.c.iter().zip(units).map(|(c, unit)| c * unit).collect();
        Scaled { a, q, c }
    }

    /// AP + PAᵀ + Q.
    fn left(&self, p: &Mat<f64>) -> Mat<f64> {
        let moved = &self.a * p;
        &moved + moved.transpose() + &self.q
    }

    fn read(&self, p: &Mat<f64>) -> f64 {
        let n = self.c.len();
        let row = |i: usize| (0..n).map(|j| p[(i, j)] * self.c[j]).sum::<f64>();
        (0..n).map(|i| self.c[i] * row(i)).sum()
    }

    /// P and X; `None` where something does not decay, as far as doubles tell.
    fn solve(&self, q: f64) -> Option<[Mat<f64>; 2]> {
        const DOUBLINGS: usize = 60;
        const ENOUGH: f64 = 1e-18;
        let n = self.c.len();
        let unit = Mat::<f64>::identity(n, n);
        let shifted = regular((&self.a - faer::Scale(q) * &unit).partial_piv_lu())?;
        let mut f = shifted.solve(&self.a + faer::Scale(q) * &unit);
        let once = shifted.solve(&self.q);
        let mut p = faer::Scale(2.0 * q) * shifted.solve(once.transpose());
        let row = Mat::from_fn(n, 1, |i, _| self.c[i]);
        let mut back = row;
        shifted.solve_transpose_in_place(&mut back);
        let mut x = faer::Scale(2.0 * q) * (&back * back.transpose());
        for _ in 0..DOUBLINGS {
            let more = &f * &p * f.transpose();
            let more_x = f.transpose() * &x * &f;
            let (size, size_x) = (more.norm_max(), more_x.norm_max());
            p += &more;
            x += &more_x;
            if !(size.is_finite() && size_x.is_finite()) {
                return None;
            }
            if size <= ENOUGH * p.norm_max() && size_x <= ENOUGH * x.norm_max() {
                // What rounding makes unsymmetric would count as a residual that X does not weigh rightly.
                return Some([p, x].map(|sum| faer::Scale(0.5) * (&sum + sum.transpose())));
            }
            f = &f * &f;
        }
        None
    }
}

/// tr XR.
fn between(x: &Mat<f64>, r: &Mat<f64>) -> f64 {
    let n = x.nrows();
    let column = |j: usize| (0..n).map(|i| x[(i, j)] * r[(i, j)]).sum::<f64>();
    (0..n).map(column).sum()
}

impl RandomVibration<'_> {
    /// The mean square of one output, or of the displacement of a coordinate or point, or of what a weighting makes of it, in doubles
    /// with an estimate of its error: many times quicker than [`solve`](Self::solve), which proves all of them. `None` where doubles do not tell it: under noise
    /// of a band, where the mean square is not shown to be finite, and where something does not decay.
    ///
    /// ```
    /// use eigentone_modes::{GROUND, System};
    /// use eigentone_response::RandomVibration;
    ///
    /// let system = System::builder().mass("m", 2.0).spring(GROUND, "m", 8.0).damper(GROUND, "m", 0.5);
    /// let system = system.build()?;
    /// let noise = RandomVibration::of(&system).force("m", 4.0);
    /// // S/4ck.
    /// let square = noise.mean_square("m", None)?.expect("it is held");
    /// assert!((square.value() - 0.25).abs() <= square.estimate() && square.estimate() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`StateSpaceError`]: names that are not there, and systems without first-order form.
    pub fn mean_square(
        &self,
        output: &str,
        weighting: Option<Weighting>,
    ) -> Result<Option<MeanSquare>, StateSpaceError> {
        Ok(self.form(output, weighting)?.and_then(|form| {
            let n = form.c.len();
            // The geometric mean of the rates.
            let factor = regular(form.a.partial_piv_lu())?;
            let logarithm = |i: usize| factor.U()[(i, i)].abs().ln();
            let q = ((0..n).map(logarithm).sum::<f64>() / n as f64).exp();
            let speed = f64::exp2(q.log2().round());
            let unit = |is_rate: &bool| if *is_rate { speed } else { 1.0 };
            let units: Vec<f64> = form.rates.iter().map(unit).collect();
            let scaled = Scaled::of(&form, &units);
            let [p, x] = scaled.solve(q)?;
            let value = scaled.read(&p) + between(&x, &scaled.left(&p));
            let size = |matrix: &Mat<f64>| Mat::from_fn(n, n, |i, j| matrix[(i, j)].abs());
            let sizes = Scaled {
                a: size(&scaled.a),
                q: size(&scaled.q),
                c: scaled.c.iter().map(|entry| entry.abs()).collect(),
            };
            let terms = between(&size(&x), &sizes.left(&size(&p))) + sizes.read(&size(&p));
            let estimate = (n as f64 + 8.0) * f64::EPSILON * terms;
            let sound = value > 0.0 && estimate.is_finite();
            sound.then(|| MeanSquare {
                output: output.to_owned(),
                weighting,
                value,
                estimate,
                p,
                x,
                units,
            })
        }))
    }

    /// What the noise makes of one output; `None` where it passes by the states, or may.
    fn form(
        &self,
        output: &str,
        weighting: Option<Weighting>,
    ) -> Result<Option<Weighed>, StateSpaceError> {
        let system = self.system;
        let mut asked = Asked::of(system);
        for (name, quantity, noise) in &self.sources {
            if noise.band.is_some() || !(noise.density.is_finite() && noise.density >= 0.0) {
                return Ok(None);
            }
            match quantity {
                None => asked.force(name)?,
                Some(quantity) => asked.motion(name, *quantity)?,
            }
        }
        let own = self.outputs.iter().find(|of| of.name == output);
        asked.output(own.cloned().unwrap_or_else(|| Combination {
            name: output.to_owned(),
            of: Sum::Motions(vec![(Quantity::Displacement, output.to_owned(), 1.0)]),
        }))?;
        let first_order = FirstOrder::of(system)?;
        let n = system.len();
        let inputs: Vec<Acts> = asked
            .channels
            .iter()
            .map(|channel| {
                let orders = channel.directions.iter().enumerate();
                let acting = orders.filter(|(_, direction)| !direction.is_empty());
                let act = |(order, direction): (usize, &Vec<(usize, f64)>)| {
                    let mut force = vec![0.0; n];
                    direction.iter().for_each(|(row, by)| force[*row] += by);
                    (order as i32 - channel.integrals as i32, force)
                };
                acting.map(act).collect()
            })
            .collect();
        let source: &Source = &asked.sources[0];
        let orders = source.terms.iter().enumerate();
        let reads: Reads = orders
            .map(|(order, terms)| {
                let own = terms.iter().filter(|(i, _)| *i < n);
                (order as i32, own.map(|&(i, [a, b])| (i, a * b)).collect())
            })
            .filter(|(_, parts): &(i32, Vec<_>)| !parts.is_empty())
            .collect();
        let Some(mut form) = StateForm::of(&first_order, &inputs, &reads) else {
            return Ok(None);
        };
        for (input, channel) in asked.channels.iter().enumerate() {
            for (order, terms) in source.terms.iter().enumerate() {
                let support = channel.support.map(|support| n + support);
                let own = terms.iter().filter(|(i, _)| Some(*i) == support);
                for &(_, [a, b]) in own {
                    form.pass(input, order as i32 - channel.integrals as i32, a * b);
                }
            }
        }
        // Integrals of white noise wander, unless they are proven to cancel.
        let settled = settled(&asked);
        for (input, (_, _, noise)) in self.sources.iter().enumerate() {
            let wanders = |power: i32| {
                let order = (power + 2) as usize;
                !settled[0][input][order] && form.direct(input, power) != 0.0
            };
            if noise.density != 0.0 && (-2..0).any(wanders) {
                return Ok(None);
            }
        }
        if let Some(weighting) = weighting {
            let Some(after) = weighting.after(form) else {
                return Ok(None);
            };
            form = after;
        }
        // White noise passes by the states with infinite power.
        for (input, (_, _, noise)) in self.sources.iter().enumerate() {
            let passes = |power: i32| power >= 0 && form.direct(input, power) != 0.0;
            if noise.density != 0.0 && StateForm::powers().any(passes) {
                return Ok(None);
            }
        }
        let strengths = self.sources.iter().map(|(_, _, noise)| noise.density / 2.0);
        let strengths = strengths.collect();
        Ok(Some(Weighed { form, strengths }))
    }
}
