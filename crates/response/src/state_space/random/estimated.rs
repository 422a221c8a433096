//! The mean square of one output under white noise in doubles, for many designs, and how it changes with the matrices.
//!
//! A P + P Aᵀ + Q = 0 and Aᵀ X + X A + cᵀc = 0 are solved together: with F = (A − q)⁻¹(A + q) they are P = FPFᵀ + 2q(A − q)⁻¹Q(A − q)⁻ᵀ
//! and its transpose, sums that double their length at each step (Smith 1968, *SIAM J. Appl. Math.* 16). What P leaves of its
//! equation, R = AP + PAᵀ + Q, weighed by X, is how far cPcᵀ is off: it is added, and the estimate is as much, beside what rounding makes
//! of it.
//!
//! Stiff systems, as finite elements are, leave doubles few digits of A itself. There R, and what X leaves of its equation, S, come from
//! an A of twice the digits. With E that P lacks, AE + EAᵀ = −R, the mean square is cPcᵀ + tr XR + tr SE but for what E lacks itself.

use std::slice::from_ref;

use eigentone_digits::{DoubleDouble, Lu, Real, product};
use eigentone_modes::{EnclosedFirstOrder, FirstOrder};
use faer::Mat;

use super::RandomVibration;
use super::settled::settled;
use super::weighting::Weighting;
use crate::frequency_response::{Acts, Equations, Reads, StateForm, powers};
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
    p: Parts,
    x: Parts,
    /// Whether doubles alone leave too few digits.
    is_stiff: bool,
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
        let (output, weighting) = (&self.output, self.weighting);
        Ok(match self.is_stiff {
            true => self.held(other.precise(output, weighting)?),
            false => self.held(other.in_doubles(output, weighting)?),
        })
    }

    fn held<T: Real>(&self, form: Option<Weighed<T>>) -> Option<f64> {
        let form = form.filter(|form| form.c.len() == self.units.len())?;
        let scaled = Scaled::of(&form, &self.units);
        Some(scaled.read(&self.p).to_f64() + between(&self.x, &scaled.left(&self.p)))
    }
}

impl MeanSquare {
    /// As computed in doubles; `None` where something does not decay.
    fn of(
        form: &Weighed<f64>,
        output: &str,
        weighting: Option<Weighting>,
    ) -> Option<(MeanSquare, Smith)> {
        let n = form.c.len();
        // The geometric mean of the rates.
        let factor = Lu::regular(form.a.as_ref())?;
        let q = (factor.pivots().map(f64::ln).sum::<f64>() / n as f64).exp();
        let speed = f64::exp2(q.log2().round());
        let unit = |is_rate: &bool| if *is_rate { speed } else { 1.0 };
        let units: Vec<f64> = form.rates.iter().map(unit).collect();
        let scaled = Scaled::of(form, &units);
        let whole = |of: &[Vec<f64>]| Mat::from_fn(n, n, |i, j| of[j][i]);
        let smith = Smith::of(&whole(&scaled.a), q)?;
        let solved = smith.solve(&whole(&scaled.q), &whole(&scaled.transposed().q))?;
        let [p, x] = solved.map(|part| vec![part]);
        let correction = between(&x, &scaled.left(&p));
        let found = MeanSquare {
            output: output.to_owned(),
            weighting,
            value: scaled.read(&p) + correction,
            // Where rates are far apart, P and X err by so much of their small entries that what they leave of both equations
            // is as much as it corrects.
            estimate: rounding(&scaled, &p, &x) + correction.abs(),
            p,
            x,
            is_stiff: false,
            units,
        };
        Some((found, smith))
    }

    /// The same with a form of more digits.
    fn corrected<T: Real>(mut self, form: &Weighed<T>, smith: &Smith) -> Option<MeanSquare> {
        const ROUNDS: usize = 4;
        /// A correction that differs from what it corrects by less, in parts of it, corrects nothing.
        const ALIKE: f64 = 0.1;
        if form.c.len() != self.units.len() {
            return None;
        }
        let scaled = Scaled::of(form, &self.units);
        let transposed = scaled.transposed();
        self.is_stiff = true;
        for _ in 0..ROUNDS {
            let left = scaled.left(&self.p);
            let back = [transposed.left(&self.x)];
            let [lacks, lacks_x] = smith.solve(&left, &back[0])?;
            // A root at 0 that doubles take for one that decays leaves as much in either equation again, however often.
            let again = |lacks: &Mat<f64>, parts: &Parts| {
                let last = parts.last()?;
                Some((lacks - last).norm_max() < ALIKE * last.norm_max())
            };
            if again(&lacks, &self.p)? || again(&lacks_x, &self.x)? {
                return None;
            }
            let first = scaled.read(&self.p) + T::from(between(&self.x, &left));
            self.value = (first + T::from(between(&back, &lacks))).to_f64();
            // The last correction bounds what is left of it, as E is small beside P.
            self.estimate = between(&sizes(&back), &sizes(from_ref(&lacks))[0])
                + rounding(&scaled, &self.p, &self.x)
                + 2.0 * f64::EPSILON * self.value.abs();
            self.p.push(lacks);
            self.x.push(lacks_x);
            if self.is_good() {
                break;
            }
        }
        Some(self)
    }

    /// Whether it needs no more digits.
    fn is_good(&self) -> bool {
        const GOOD: f64 = 1e-12;
        self.estimate <= GOOD * self.value
    }
}

/// An estimate of what rounding makes of cPcᵀ + tr X(AP + PAᵀ + Q): some units of all terms.
fn rounding<T: Real>(scaled: &Scaled<T>, p: &[Mat<f64>], x: &[Mat<f64>]) -> f64 {
    let of_terms = scaled.map(|entry| entry.to_f64().abs());
    let (p, x) = (sizes(p), sizes(x));
    let terms = between(&x, &of_terms.left(&p)) + of_terms.read(&p);
    let unit = f64::exp2(f64::from(T::UNIT_LOG2 + 1));
    (scaled.c.len() as f64 + 8.0) * unit * terms
}

/// A symmetric matrix as a sum of others, each much smaller than those before it.
type Parts = Vec<Mat<f64>>;

fn entry<T: Real>(parts: &[Mat<f64>], i: usize, j: usize) -> T {
    let parts = parts.iter().map(|part| T::from(part[(i, j)]));
    parts.fold(T::ZERO, |sum, part| sum + part)
}

/// What noise of one unit, by its strength, makes of one output.
struct Weighed<T> {
    form: StateForm<T>,
    /// Half of the density of each input.
    strengths: Vec<f64>,
}

impl<T> std::ops::Deref for Weighed<T> {
    type Target = StateForm<T>;

    fn deref(&self) -> &StateForm<T> {
        &self.form
    }
}

/// A, Q and c with other units of the states, powers of two; matrices by their columns.
struct Scaled<T> {
    a: Vec<Vec<T>>,
    q: Vec<Vec<T>>,
    c: Vec<T>,
}

impl<T: Real> Scaled<T> {
    fn of(form: &Weighed<T>, units: &[f64]) -> Scaled<T> {
        let n = units.len();
        let c = form.c.iter().zip(units).map(|(c, unit)| c.mul_f64(*unit));
        let a = |i: usize, j: usize| form.a[(i, j)].mul_f64(units[j] / units[i]);
        let q = |i: usize, j: usize| {
            let inputs = form.b.iter().zip(&form.strengths);
            inputs.fold(T::ZERO, |sum, (b, strength)| {
                let [one, other] = [i, j].map(|k| b[k].mul_f64(1.0 / units[k]));
                sum + one * other.mul_f64(*strength)
            })
        };
        Scaled {
            a: columns(n, a),
            q: columns(n, q),
            c: c.collect(),
        }
    }

    /// With Aᵀ for A, and cᵀc for Q.
    fn transposed(&self) -> Scaled<T> {
        let n = self.c.len();
        Scaled {
            a: columns(n, |i, j| self.a[i][j]),
            q: columns(n, |i, j| self.c[i] * self.c[j]),
            c: Vec::new(),
        }
    }

    fn map<U>(&self, by: impl Fn(&T) -> U) -> Scaled<U> {
        let vector = |of: &Vec<T>| of.iter().map(&by).collect();
        Scaled {
            a: self.a.iter().map(vector).collect(),
            q: self.q.iter().map(vector).collect(),
            c: vector(&self.c),
        }
    }

    /// AP + PAᵀ + Q.
    fn left(&self, p: &[Mat<f64>]) -> Mat<f64> {
        let n = self.a.len();
        let moved: Vec<Vec<T>> = (0..n)
            .map(|j| {
                let mut column = vec![T::ZERO; n];
                let terms = self.a.iter().enumerate();
                let terms: Vec<_> = terms.map(|(k, of)| (entry(p, k, j), &of[..])).collect();
                T::add_multiples(&mut column, &terms);
                column
            })
            .collect();
        Mat::from_fn(n, n, |i, j| {
            (moved[j][i] + moved[i][j] + self.q[j][i]).to_f64()
        })
    }

    /// cPcᵀ.
    fn read(&self, p: &[Mat<f64>]) -> T {
        let n = self.c.len();
        let terms = (0..n * n).map(|k| (k / n, k % n));
        terms.fold(T::ZERO, |sum, (i, j)| {
            sum + self.c[i] * self.c[j] * entry(p, i, j)
        })
    }
}

fn columns<T>(n: usize, entry: impl Fn(usize, usize) -> T) -> Vec<Vec<T>> {
    (0..n)
        .map(|j| (0..n).map(|i| entry(i, j)).collect())
        .collect()
}

/// A of doubles, ready to solve AP + PAᵀ + Q = 0.
struct Smith {
    shifted: Lu<f64>,
    /// F.
    f: Mat<f64>,
    q: f64,
}

impl Smith {
    fn of(a: &Mat<f64>, q: f64) -> Option<Smith> {
        let shift = faer::Scale(q) * Mat::<f64>::identity(a.nrows(), a.nrows());
        let shifted = Lu::regular((a - &shift).as_ref())?;
        let f = shifted.solve(a + &shift);
        Some(Smith { shifted, f, q })
    }

    /// P for one Q, and with Aᵀ for A what solves that for another; `None` where something does not decay, as far as doubles show.
    fn solve(&self, right: &Mat<f64>, back: &Mat<f64>) -> Option<[Mat<f64>; 2]> {
        /// What F errs by doubles with each: with more of them the sums would be of rounding.
        const DOUBLINGS: usize = 44;
        const NOTHING: f64 = 1e-16;
        let mut once = right.to_owned();
        self.shifted.solve_in_place(once.as_mut());
        let mut p = once.transpose().to_owned();
        self.shifted.solve_in_place(p.as_mut());
        let mut once = back.to_owned();
        self.shifted.solve_transpose_in_place(once.as_mut());
        let mut x = once.transpose().to_owned();
        self.shifted.solve_transpose_in_place(x.as_mut());
        let mut f = self.f.clone();
        for _ in 0..DOUBLINGS {
            p += product(product(f.as_ref(), p.as_ref()).as_ref(), f.transpose());
            x += product(f.transpose(), product(x.as_ref(), f.as_ref()).as_ref());
            let size = f.norm_max();
            if !size.is_finite() {
                return None;
            }
            // What comes after is as small as its square.
            if size <= NOTHING {
                // What rounding makes unsymmetric would count as a residual that X does not weigh rightly.
                return Some([p, x].map(|sum| faer::Scale(self.q) * (&sum + sum.transpose())));
            }
            f = product(f.as_ref(), f.as_ref());
        }
        None
    }
}

/// tr XR.
fn between(x: &[Mat<f64>], r: &Mat<f64>) -> f64 {
    let n = r.nrows();
    let column = |j: usize| {
        (0..n)
            .map(|i| entry::<f64>(x, i, j) * r[(i, j)])
            .sum::<f64>()
    };
    (0..n).map(column).sum()
}

fn sizes(parts: &[Mat<f64>]) -> Parts {
    let size = |of: &Mat<f64>| Mat::from_fn(of.nrows(), of.ncols(), |i, j| of[(i, j)].abs());
    parts.iter().map(size).collect()
}

impl RandomVibration<'_> {
    /// The mean square of one output, or of the displacement of a coordinate or point, or of what a weighting makes of it, in doubles
    /// with an estimate of its error: many times quicker than [`solve`](Self::solve), which proves all of them. `None` where doubles do not determine it: under noise
    /// of a band, where the mean square is not shown to be finite, and where something does not decay as far as they show.
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
        let Some(form) = self.in_doubles(output, weighting)? else {
            return Ok(None);
        };
        let Some((found, smith)) = MeanSquare::of(&form, output, weighting) else {
            return Ok(None);
        };
        let found = match found.is_good() {
            true => Some(found),
            false => {
                let form = self.precise(output, weighting)?;
                form.and_then(|form| found.corrected(&form, &smith))
            }
        };
        // Of what does not decay each round would add as much again.
        const DETERMINED: f64 = 1e-3;
        let is_known =
            |found: &MeanSquare| found.value > 0.0 && found.estimate <= DETERMINED * found.value;
        Ok(found.filter(is_known))
    }

    fn in_doubles(
        &self,
        output: &str,
        weighting: Option<Weighting>,
    ) -> Result<Option<Weighed<f64>>, StateSpaceError> {
        let equations = Equations::of(&FirstOrder::of(self.system)?);
        self.form(equations, output, weighting)
    }

    fn precise(
        &self,
        output: &str,
        weighting: Option<Weighting>,
    ) -> Result<Option<Weighed<DoubleDouble>>, StateSpaceError> {
        let equations = Equations::precise(&EnclosedFirstOrder::of(self.system)?);
        self.form(equations, output, weighting)
    }

    /// What the noise makes of one output; `None` where it passes by the states, or may.
    fn form<T: Real>(
        &self,
        equations: Equations<T>,
        output: &str,
        weighting: Option<Weighting>,
    ) -> Result<Option<Weighed<T>>, StateSpaceError> {
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
        let Some(mut form) = StateForm::of(equations, &inputs, &reads) else {
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
                settled[0][input][order] != Some(true) && !form.direct(input, power).is_zero()
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
            let passes = |power: i32| power >= 0 && !form.direct(input, power).is_zero();
            if noise.density != 0.0 && powers().any(passes) {
                return Ok(None);
            }
        }
        let strengths = self.sources.iter().map(|(_, _, noise)| noise.density / 2.0);
        let strengths = strengths.collect();
        Ok(Some(Weighed { form, strengths }))
    }
}
