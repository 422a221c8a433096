//! Power series of functions about points of the axis, from modes in O(n) for each coefficient, with proven bounds.
//!
//! With s = i(x + ρt) and G = (ix − Λ)⁻¹, the modes y = (s − Λ)⁻¹f under f(t) = Σ fₖtᵏ follow from
//! yₖ = G(fₖ − iρyₖ₋₁). Where the spectral radius of ρ|G| is less than 1, s − Λ is regular for all complex |t| ≤ 1, and there
//! |y| ≤ (I − ρ|G|)⁻¹|G| Σ|fₖ|, in each block of Λ by itself; what rounding leaves of the recursion is a force too, with
//! the same bound. So are the matrices of I − SZ = F (see `modal_sum`), and the function is that of the modes but for
//! F(I − F)⁻¹S f, which is analytic and small in the unit disc: a bound of it there bounds each of its coefficients (Cauchy).
//!
//! Around a pole without damping the same bounds hold on a circle, on which |H − H̃| ≤ E for the function H̃ of the modes. As
//! det(I − F) winds around 0 as often as 1 does, s → Z has no more roots within than the modes, one. With the residue r̃ of H̃, the
//! residue r of H is within ρE of it, and not 0 where that is less; the pole then is within (17/16)ρ²E/|r| of that of the modes,
//! by the first moments of H and H̃ on the circle.

use eigentone_digits::{Ball, DoubleDouble, Real, WideComplex};
use num_complex::Complex;

use super::modal_functions::{Input, ModalFunctions, narrowed, turn};
use super::power_series::PowerSeries;
use super::refinement::UPWARD;

/// What the modes may leave of 1.
const LARGEST: f64 = 0.25;

/// (I − ρ|G|)⁻¹|G| of a block.
struct Reach {
    width: usize,
    size: [f64; 4],
    solved: [f64; 4],
}

impl Reach {
    /// `None` where the spectral radius is not shown to be less than 1.
    fn of(width: usize, sizes: [f64; 4], radius: f64) -> Option<Reach> {
        let size = sizes.map(|size| size * UPWARD);
        let [a, b, c, d] = size.map(|entry| radius * entry * UPWARD);
        let (left, right) = (1.0 - a, 1.0 - d);
        if width == 1 {
            let solved = [left.recip() * UPWARD, 0.0, 0.0, 0.0];
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

    /// The same of a block with an imaginary pole, where that is at least so far, and its conjugate too.
    fn around([a, b, c, d]: [f64; 4], top: f64, far: [f64; 2]) -> Reach {
        let divisor = far[0] * far[1] / (1.0 + 1e-3);
        Reach {
            width: 2,
            size: [top + d.abs(), b.abs(), c.abs(), top + a.abs()].map(|entry| entry / divisor),
            solved: [1.0, 0.0, 0.0, 1.0],
        }
    }

    fn bound(&self, force: [f64; 2]) -> [f64; 2] {
        let times = |matrix: &[f64; 4], v: [f64; 2]| match self.width {
            1 => [matrix[0] * v[0], 0.0],
            _ => [
                matrix[0] * v[0] + matrix[1] * v[1],
                matrix[2] * v[0] + matrix[3] * v[1],
            ],
        };
        times(&self.solved, times(&self.size, force)).map(|bound| bound * UPWARD)
    }
}

/// Bounds in lengths of the coordinates, of all blocks: of what moves, of what is lost in doubles, of what the residual of the modes
/// makes; and of each row of the outputs.
struct Bounds {
    moved: f64,
    lost: f64,
    left: f64,
    rows: Vec<f64>,
}

impl Bounds {
    fn of(form: &ModalFunctions<'_>) -> Bounds {
        Bounds {
            moved: 0.0,
            lost: 0.0,
            left: 0.0,
            rows: vec![0.0; form.rows.len()],
        }
    }

    /// A block under such forces and errors.
    fn add(
        &mut self,
        form: &ModalFunctions<'_>,
        start: usize,
        reach: &Reach,
        forces: [f64; 2],
        errors: [f64; 2],
    ) {
        let residual = [0, 1].map(|b| {
            if b < reach.width {
                form.residual[start + b]
            } else {
                0.0
            }
        });
        let [y, off, rest] = [forces, errors, residual].map(|force| reach.bound(force));
        for a in 0..reach.width {
            let column = form.columns[start + a];
            self.moved += column * y[a];
            self.lost += column * off[a];
            self.left += column * rest[a];
            for (row, size) in self.rows.iter_mut().enumerate() {
                *size += form.rounded[(row, start + a)].abs() * y[a];
            }
        }
    }

    /// Bounds of an output and of its error, with so much of what moves for rounding; `None` where I − F may be singular.
    fn ends(
        &self,
        form: &ModalFunctions<'_>,
        output: usize,
        far: f64,
        rounding: f64,
    ) -> Option<[f64; 2]> {
        let passed = form.passed.iter();
        let moved = passed.fold(self.moved, |sum, (power, size)| {
            sum + size * far.powi(*power)
        });
        let [zeroth, first, second] = form.defects;
        let norm = (zeroth + first * far + second * far * far + self.left) * UPWARD;
        if norm.is_nan() || norm > LARGEST {
            return None;
        }
        let off = (moved * (norm / (1.0 - norm) + rounding) + self.lost) * UPWARD;
        let rows = form.rows.iter().zip(&self.rows);
        let rows = rows.filter(|((index, _), _)| *index == output);
        let modal: f64 = rows.map(|(&(_, power), size)| size * far.powi(power)).sum();
        let lengths = form.lengths.iter().filter(|(index, ..)| *index == output);
        let error: f64 = lengths
            .map(|&(_, power, length)| length * off * far.powi(power))
            .sum();
        let direct = form.direct.iter().filter(|(index, ..)| *index == output);
        let direct: f64 = direct
            .map(|&(_, power, part)| part.high().abs() * far.powi(power))
            .sum();
        let error = (error + direct * rounding) * UPWARD;
        let largest = (modal + direct + error) * UPWARD;
        largest.is_finite().then_some([largest, error])
    }
}

/// (i(x + ρt))^power by powers of t.
fn turned<T: Real>(x: DoubleDouble, radius: f64, power: i32) -> Vec<WideComplex<T>> {
    let mut parts = vec![WideComplex::new(1.0, 0.0)];
    for _ in 0..power {
        let mut next = vec![WideComplex::ZERO; parts.len() + 1];
        for (k, part) in parts.iter().enumerate() {
            next[k] += *part * WideComplex::new(0.0, narrowed::<T>(x));
            next[k + 1] += *part * WideComplex::new(0.0, radius);
        }
        parts = next;
    }
    parts
}

fn scaled<T: Real>(value: WideComplex<T>, factor: T) -> WideComplex<T> {
    WideComplex {
        re: value.re * factor,
        im: value.im * factor,
    }
}

/// A double, or a double-double.
fn widened<T: Real>(value: T) -> DoubleDouble {
    let high = value.to_f64();
    DoubleDouble::from(high) + (value - T::from(high)).to_f64()
}

impl ModalFunctions<'_> {
    /// How fast the slowest mode that is no rigid motion is, and the fastest, in 1/s; `None` without any.
    pub(super) fn rates(&self) -> Option<[f64; 2]> {
        /// Slower ones, in parts of the fastest, are rigid but for rounding.
        const RIGID: f64 = 1e-7;
        let rates = self.sum.rates();
        let most = rates.iter().fold(0.0, |most, rate| rate[1].max(most));
        let moving = rates.iter().map(|rate| rate[0]);
        let moving = moving.filter(|rate| *rate > RIGID * most);
        let least = moving.fold(f64::INFINITY, f64::min);
        (most > 0.0 && least.is_finite()).then_some([least, most])
    }

    /// Whether what the modes leave is small enough for series up to this frequency.
    pub(super) fn serve_up_to(&self, frequency: f64) -> bool {
        let [zeroth, first, second] = self.defects;
        zeroth + first * frequency + second * frequency * frequency < LARGEST
    }

    /// How many coefficients of modes so many of the function take.
    pub(super) fn products(&self, count: usize) -> u64 {
        (self.columns.len() * (count + 1) * (self.rows.len() + 1)) as u64
    }

    /// All outputs about x, with a radius ρ of `least` or more, in the precision of T; `None` where the modes do not prove
    /// that they are analytic there.
    pub(super) fn series<T: Real>(
        &self,
        x: DoubleDouble,
        least: f64,
        count: usize,
    ) -> Option<Vec<PowerSeries>> {
        /// Beyond it nothing is gained.
        const MOST: f64 = 0.5;
        let mut steepest = 0.0f64;
        self.sum.each_block(x, |_, _, inverse, _| {
            let [a, b, c, d] = inverse.map(|entry| entry.norm());
            let apart = (a - d).hypot(2.0 * (b * c).sqrt());
            steepest = steepest.max(f64::midpoint(a + d, apart));
        })?;
        let mut radius = f64::exp2(least.log2().ceil());
        if !radius.is_normal() || radius * steepest > 0.9 {
            return None;
        }
        let place = x.to_f64();
        while 2.0 * radius * steepest < MOST && radius < place {
            radius *= 2.0;
        }
        let far = (place + radius) * UPWARD;
        let (rounding, lost) = (self.rounding::<T>(), self.lost());
        let inputs: Vec<(Vec<WideComplex<T>>, &Input)> = self
            .inputs
            .iter()
            .map(|input| (turned(x, radius, input.power), input))
            .collect();
        let turn = WideComplex::<T>::new(0.0, radius);
        let mut sums = vec![vec![WideComplex::<T>::ZERO; count]; self.rows.len()];
        let mut bounds = Bounds::of(self);
        let mut regular = true;
        self.sum
            .each_inverse::<T>(x, |start, width, inverse, off| {
                let Some(reach) = Reach::of(width, inverse.map(WideComplex::norm), radius) else {
                    regular = false;
                    return;
                };
                let rounding = rounding + off;
                let mut before = [WideComplex::<T>::ZERO; 2];
                let (mut forces, mut errors) = ([0.0; 2], [0.0; 2]);
                for k in 0..count {
                    let mut right = before.map(|before| -(turn * before));
                    for b in 0..width {
                        errors[b] += rounding * radius * before[b].norm();
                        for (turned, input) in &inputs {
                            if let Some(power) = turned.get(k) {
                                let modal = input.modal[start + b];
                                right[b] += scaled(*power, narrowed(modal));
                                let size = power.norm();
                                let own = size * modal.high().abs();
                                forces[b] += own;
                                errors[b] += rounding * own + lost * size * input.sizes[start + b];
                            }
                        }
                    }
                    for a in 0..width {
                        before[a] = inverse[a * width] * right[0];
                        if width == 2 {
                            before[a] += inverse[a * width + 1] * right[1];
                        }
                    }
                    for (row, sum) in sums.iter_mut().enumerate() {
                        for (a, state) in before.iter().enumerate().take(width) {
                            sum[k] += scaled(*state, narrowed(self.outputs[row][start + a]));
                        }
                    }
                }
                bounds.add(self, start, &reach, forces, errors);
            })?;
        if !regular {
            return None;
        }
        let output = |output: usize| {
            let [largest, error] = bounds.ends(self, output, far, rounding)?;
            let mut coefficients = vec![WideComplex::<T>::ZERO; count];
            let rows = sums.iter().zip(&self.rows);
            for (sum, &(_, power)) in rows.filter(|(_, (index, _))| *index == output) {
                for (j, part) in turned::<T>(x, radius, power)
                    .into_iter()
                    .enumerate()
                    .take(count)
                {
                    for (to, from) in coefficients[j..].iter_mut().zip(sum) {
                        *to += part * *from;
                    }
                }
            }
            let direct = self.direct.iter().filter(|(index, ..)| *index == output);
            for &(_, power, coefficient) in direct {
                for (to, part) in coefficients.iter_mut().zip(turned(x, radius, power)) {
                    *to += scaled(part, narrowed(coefficient));
                }
            }
            let known = coefficients.iter().all(|value| value.is_finite());
            let number = |value: WideComplex<T>| {
                Ball::new(
                    WideComplex {
                        re: widened(value.re),
                        im: widened(value.im),
                    },
                    error.into(),
                )
            };
            known.then(|| PowerSeries {
                coefficients: coefficients.into_iter().map(number).collect(),
                largest: largest.into(),
                radius,
            })
        };
        (0..self.count).map(output).collect()
    }

    /// A pole of the only output, which is real, between these frequencies or beside them, where the function turns nowhere else between
    /// them: Ω, and a bound of its error, which does not reach the ends. `None` where that is not proved.
    pub(super) fn pole(&self, low: f64, high: f64) -> Option<(f64, f64)> {
        /// How far a pole beyond the ends may be, in parts of their distance.
        const NEAR: f64 = 0.5;
        /// The interval, in parts of ρ.
        const PART: f64 = 0.125;
        let near = NEAR * (high - low);
        let candidates = self.sum.blocks.iter().filter_map(|block| {
            let [a, b, c, d] = *block.generator.as_slice() else {
                return None;
            };
            let place = (a * d - b * c).to_f64().sqrt();
            let fits = a + d == DoubleDouble::ZERO && place > low - near && place < high + near;
            fits.then(|| (block.start, place, [a, b, c, d].map(DoubleDouble::to_f64)))
        });
        let mut candidates = candidates.fuse();
        let (Some((own, place, generator)), None) = (candidates.next(), candidates.next()) else {
            return None;
        };
        let distance = (high - place).max(place - low);
        let radius = distance / PART;
        // No centre is at the pole, where no block has an inverse.
        let x = place + radius / 16.0;
        let far = (x + radius) * UPWARD;
        // Roundings of place and centre are a share of 1e-4 of it.
        if radius < 65_536.0 * f64::EPSILON * place || radius > 0.25 * place {
            return None;
        }
        let size = |power: i32| far.powi(power);
        let force = |k: usize| -> f64 {
            let parts = self.inputs.iter();
            parts
                .map(|input| input.modal[k].high().abs() * size(input.power))
                .sum()
        };
        let (mut bounds, mut regular) = (Bounds::of(self), true);
        self.sum.each_block(x.into(), |start, width, inverse, _| {
            let reach = match start == own {
                true => Some(Reach::around(
                    generator,
                    far,
                    [radius * (15.0 / 16.0), x + place - radius],
                )),
                false => Reach::of(width, inverse.map(|entry| entry.norm()), radius),
            };
            let forces = [0, 1].map(|b| if b < width { force(start + b) } else { 0.0 });
            match reach {
                Some(reach) => bounds.add(self, start, &reach, forces, [0.0; 2]),
                None => regular = false,
            }
        })?;
        let [largest, error] = bounds
            .ends(self, 0, far, self.rounding::<f64>())
            .filter(|_| regular)?;
        let (residue, rounding) = self.residue(own, place, generator);
        let residue = residue - rounding;
        let least = residue - radius * error;
        if least.is_nan() || least < 0.875 * residue {
            return None;
        }
        let off = 1.25 * radius * radius * error / residue + 8.0 * f64::EPSILON * place;
        // Of what is left of the function without its pole.
        let rest = largest + error + 1.5 * (residue + 2.0 * rounding) / radius;
        let distance = distance + off;
        let edge = radius * (15.0 / 16.0) - distance;
        let alone =
            distance * rest * UPWARD < least && distance * distance * rest * UPWARD < least * edge;
        let apart = (place - low).abs() > off && (place - high).abs() > off;
        (alone && apart).then_some((place, off))
    }

    /// The size of the residue at the pole of a block, and a bound of its error.
    fn residue(&self, start: usize, place: f64, [a, b, c, d]: [f64; 4]) -> (f64, f64) {
        let s = Complex::new(0.0, place);
        let adjugate = [s - d, b.into(), c.into(), s - a];
        let (mut sum, mut size) = (Complex::<f64>::ZERO, 0.0);
        for (row, &(_, outer)) in self.rows.iter().enumerate() {
            for input in &self.inputs {
                for (at, entry) in adjugate.iter().enumerate() {
                    let modal = input.modal[start + at % 2].high();
                    let factor = self.rounded[(row, start + at / 2)] * modal;
                    let power = turn(place, outer + input.power);
                    sum += entry * power * factor;
                    size += entry.norm() * (factor * power.norm()).abs();
                }
            }
        }
        let scale = 0.5 / place;
        (sum.norm() * scale, size * scale * 64.0 * f64::EPSILON)
    }
}
