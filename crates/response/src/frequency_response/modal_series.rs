//! Power series of one function about points of the axis, from modes in O(n) for each coefficient, with proven bounds.
//!
//! With s = i(x + ρt) and G = (ix − Λ)⁻¹, the modes y = (s − Λ)⁻¹f under f(t) = Σ fₖtᵏ follow from
//! yₖ = G(fₖ − iρyₖ₋₁). Where the spectral radius of ρ|G| is less than 1, s − Λ is regular for all complex |t| ≤ 1, and there
//! |y| ≤ (I − ρ|G|)⁻¹|G| Σ|fₖ|, in each block of Λ by itself; what rounding leaves of the recursion is a force too, with
//! the same bound. So are the matrices of I − SZ = F (see `modal_sum`), and the function is that of the modes but for
//! F(I − F)⁻¹S f, which is analytic and small in the unit disc: a bound of it there bounds each of its coefficients (Cauchy).

use eigentone_digits::{Ball, WideComplex};
use num_complex::Complex;

use super::in_doubles::{BLOCK, InDoubles};
use super::power_series::PowerSeries;

/// (I − ρ|G|)⁻¹|G| of a block.
struct Reach {
    width: usize,
    size: [f64; 4],
    solved: [f64; 4],
}

/// Bounds are sums of doubles, of a few thousand terms at most.
const ABOVE: f64 = 1.0 + 1e-9;

impl Reach {
    /// `None` where the spectral radius is not shown to be less than 1.
    fn of(width: usize, inverse: &[Complex<f64>; 4], radius: f64) -> Option<Reach> {
        let size = inverse.map(|entry| entry.norm() * (1.0 + 2.0 * BLOCK));
        let [a, b, c, d] = size.map(|entry| radius * entry * ABOVE);
        let (left, right) = (1.0 - a, 1.0 - d);
        if width == 1 {
            let solved = [left.recip() * ABOVE, 0.0, 0.0, 0.0];
            return (left > 1e-3).then_some(Reach {
                width,
                size,
                solved,
            });
        }
        let determinant = left * right - b * c;
        let solved = [right, b, c, left].map(|entry| entry / determinant * (1.0 + 1e-6));
        let known = left > 0.0 && right > 0.0 && determinant > 1e-6;
        known.then_some(Reach {
            width,
            size,
            solved,
        })
    }

    fn bound(&self, force: [f64; 2]) -> [f64; 2] {
        let times = |matrix: &[f64; 4], v: [f64; 2]| match self.width {
            1 => [matrix[0] * v[0], 0.0],
            _ => [
                matrix[0] * v[0] + matrix[1] * v[1],
                matrix[2] * v[0] + matrix[3] * v[1],
            ],
        };
        times(&self.solved, times(&self.size, force)).map(|bound| bound * ABOVE)
    }
}

/// (i(x + ρt))^power by powers of t.
fn turned(x: f64, radius: f64, power: i32) -> Vec<Complex<f64>> {
    let mut parts = vec![Complex::ONE];
    for _ in 0..power {
        let mut next = vec![Complex::ZERO; parts.len() + 1];
        for (k, part) in parts.iter().enumerate() {
            next[k] += part * Complex::new(0.0, x);
            next[k + 1] += part * Complex::new(0.0, radius);
        }
        parts = next;
    }
    parts
}

impl InDoubles<'_> {
    /// How fast the slowest mode that is no rigid motion is, and the fastest, in 1/s; `None` without any.
    pub(super) fn rates(&self) -> Option<[f64; 2]> {
        /// Slower ones, in parts of the fastest, are rigid but for rounding.
        const RIGID: f64 = 1e-7;
        let rates = self.sum.rates();
        let most = rates.iter().copied().fold(0.0, f64::max);
        let moving = rates.into_iter().filter(|rate| *rate > RIGID * most);
        let least = moving.fold(f64::INFINITY, f64::min);
        (most > 0.0 && least.is_finite()).then_some([least, most])
    }

    /// How many coefficients of modes so many of the function take.
    pub(super) fn products(&self, count: usize) -> u64 {
        (self.columns.len() * (count + 1) * (self.rows.len() + 1)) as u64
    }

    /// The only output about x, with a radius ρ of `least` or more, which is returned too; `None` where the modes do not prove
    /// that it is analytic there.
    pub(super) fn series(&self, x: f64, least: f64, count: usize) -> Option<(PowerSeries, f64)> {
        /// Beyond it nothing is gained.
        const MOST: f64 = 0.5;
        let mut steepest = 0.0f64;
        self.sum.each_block(x, |_, _, inverse| {
            let [a, b, c, d] = inverse.map(|entry| entry.norm());
            let apart = (a - d).hypot(2.0 * (b * c).sqrt());
            steepest = steepest.max(f64::midpoint(a + d, apart));
        })?;
        let mut radius = f64::exp2(least.log2().ceil());
        if !radius.is_normal() || radius * steepest > 0.9 {
            return None;
        }
        while 2.0 * radius * steepest < MOST && radius < x {
            radius *= 2.0;
        }
        let far = (x + radius) * ABOVE;
        let rounding = (self.columns.len() as f64 + 64.0) * f64::EPSILON + BLOCK;
        let inputs: Vec<(Vec<Complex<f64>>, &[f64])> = self
            .inputs
            .iter()
            .map(|(power, modal)| (turned(x, radius, *power), &modal[..]))
            .collect();
        let turn = Complex::new(0.0, radius);
        let mut sums = vec![vec![Complex::<f64>::ZERO; count]; self.rows.len()];
        let mut sizes = vec![0.0; self.rows.len()];
        let (mut moved, mut left, mut lost) = (0.0, 0.0, 0.0);
        let mut regular = true;
        self.sum.each_block(x, |start, width, inverse| {
            let Some(reach) = Reach::of(width, inverse, radius) else {
                regular = false;
                return;
            };
            let at = |b: usize| (b < width).then_some(start + b);
            let force = |k: usize, b: usize| -> Complex<f64> {
                let parts = inputs
                    .iter()
                    .filter_map(|(turned, modal)| Some(turned.get(k)? * modal[at(b)?]));
                parts.sum()
            };
            let mut before = [Complex::<f64>::ZERO; 2];
            let (mut forces, mut errors) = ([0.0; 2], [0.0; 2]);
            for k in 0..count {
                let own = [force(k, 0), force(k, 1)];
                let right = [0, 1].map(|b| own[b] - turn * before[b]);
                for b in 0..width {
                    let parts = inputs.iter().filter_map(|(turned, modal)| {
                        Some((turned.get(k)? * modal[at(b)?]).norm())
                    });
                    let size: f64 = parts.sum();
                    forces[b] += size;
                    errors[b] += rounding * (size + radius * before[b].norm());
                }
                before = [0, 1].map(|a| match a < width {
                    true => (0..width).map(|b| inverse[a * width + b] * right[b]).sum(),
                    false => Complex::ZERO,
                });
                for (row, sum) in sums.iter_mut().enumerate() {
                    for (a, state) in before.iter().enumerate().take(width) {
                        sum[k] += state * self.outputs[(row, start + a)];
                    }
                }
            }
            let residual = [0, 1].map(|b| at(b).map_or(0.0, |at| self.residual[at]));
            let [y, off, rest] = [forces, errors, residual].map(|force| reach.bound(force));
            for a in 0..width {
                let column = self.columns[start + a];
                moved += column * y[a];
                lost += column * off[a];
                left += column * rest[a];
                for (row, size) in sizes.iter_mut().enumerate() {
                    *size += self.outputs[(row, start + a)].abs() * y[a];
                }
            }
        })?;
        let moved = self
            .passed
            .iter()
            .fold(moved, |sum, (power, size)| sum + size * far.powi(*power));
        let [zeroth, first, second] = self.defects;
        let norm = (zeroth + first * far + second * far * far + left) * ABOVE;
        if !regular || norm.is_nan() || norm > 0.25 {
            return None;
        }
        let off = (moved * (norm / (1.0 - norm) + rounding) + lost) * ABOVE;
        let mut coefficients = vec![Complex::<f64>::ZERO; count];
        let (mut largest, mut error) = (0.0, 0.0);
        for ((sum, size), &(_, power)) in sums.iter().zip(sizes).zip(&self.rows) {
            for (j, part) in turned(x, radius, power).into_iter().enumerate().take(count) {
                for (to, from) in coefficients[j..].iter_mut().zip(sum) {
                    *to += part * from;
                }
            }
            largest += size * far.powi(power);
        }
        for &(_, power, length) in &self.lengths {
            error += length * off * far.powi(power);
        }
        for &(_, power, coefficient) in &self.direct {
            for (to, part) in coefficients.iter_mut().zip(turned(x, radius, power)) {
                *to += part * coefficient;
            }
            let size = coefficient.abs() * far.powi(power);
            largest += size;
            error += size * rounding;
        }
        let error = error * ABOVE;
        let largest = (largest + error) * ABOVE;
        let known = largest.is_finite() && coefficients.iter().all(|value| value.is_finite());
        let number = |value: Complex<f64>| {
            let middle = WideComplex {
                re: value.re.into(),
                im: value.im.into(),
            };
            Ball::new(middle, error.into())
        };
        known.then(|| {
            let series = PowerSeries {
                coefficients: coefficients.into_iter().map(number).collect(),
                largest: largest.into(),
            };
            (series, radius)
        })
    }
}
