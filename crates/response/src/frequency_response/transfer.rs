//! One frequency response function in doubles, and how it changes with the matrices.

use eigentone_modes::{MatrixKind, System};
use num_complex::Complex;

use super::modal_functions::turn;
use super::ports::{Ports, dense};

/// One frequency response function H of a system in doubles: for many designs, of which each is asked for little.
///
/// ```
/// use eigentone_modes::{GROUND, System};
/// use eigentone_response::FrequencyResponse;
///
/// let system = |k: f64| {
///     let builder = System::builder().mass("m", 1.0).spring(GROUND, "m", k);
///     builder.damper(GROUND, "m", 0.5).build()
/// };
/// let (here, there) = (system(4.0)?, system(5.0)?);
/// let transfer = FrequencyResponse::of(&here).from("m").to("m").transfer()?.expect("it is small");
/// let there = FrequencyResponse::of(&there).from("m").to("m").transfer()?.expect("it is small");
/// let adjoint = transfer.adjoint(2.0).expect("no pole");
/// // H = 1/(k − ω² + icω), and dH/dk = −H².
/// let slope = adjoint.along(&there) - adjoint.along(&transfer);
/// assert!((slope + adjoint.value() * adjoint.value()).norm() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Transfer {
    pub(super) n: usize,
    /// K, C and M, row by row.
    matrices: [Vec<f64>; 3],
    /// The same with the sizes of all that they are sums of.
    sizes: [Vec<f64>; 3],
    /// What the losses of springs add to K, times i.
    losses: Option<Vec<f64>>,
    pub(super) acts: Vec<(i32, Vec<Complex<f64>>)>,
    pub(super) reads: Vec<(i32, Reading)>,
    pub(super) direct: Vec<(i32, Complex<f64>)>,
}

/// The coordinates that are read, and their factors.
type Reading = Vec<(usize, Complex<f64>)>;

/// A value H(iΩ) of a [`Transfer`] with the motion x and its adjoint y, Zx = b and Zᵀy = c for H = cᵀZ⁻¹b + d.
#[derive(Clone, Debug)]
pub struct Adjoint {
    frequency: f64,
    value: Complex<f64>,
    x: Vec<Complex<f64>>,
    y: Vec<Complex<f64>>,
}

impl Adjoint {
    /// H.
    pub fn value(&self) -> Complex<f64> {
        self.value
    }

    /// cᵀx + yᵀb − yᵀZx + d with the Z, b, c and d of another design at the same frequency: as x and y are, its derivative by
    /// whatever these depend on is that of H, and it is H itself for the design it was made for.
    pub fn along(&self, other: &Transfer) -> Complex<f64> {
        let (frequency, n) = (self.frequency, other.n);
        let mut sum = other.passed(frequency, 0);
        let (b, c) = (other.force(frequency, 0), other.row(frequency, 0));
        for i in 0..n {
            sum += c[i] * self.x[i] + b[i] * self.y[i];
        }
        sum - other.between(&self.y, &self.x, frequency)
    }
}

impl Transfer {
    pub(super) fn of(system: &System, ports: Ports, losses: Option<faer::Mat<f64>>) -> Transfer {
        let n = system.len();
        let kinds = [MatrixKind::Stiffness, MatrixKind::Damping, MatrixKind::Mass];
        let mut sizes = [(); 3].map(|()| vec![0.0; n * n]);
        let matrices = [0, 1, 2].map(|k| {
            let mut matrix = vec![0.0; n * n];
            for term in system.terms(kinds[k]) {
                matrix[term.row * n + term.column] += term.value;
                sizes[k][term.row * n + term.column] += term.value.abs();
            }
            matrix
        });
        let flat = |matrix: faer::Mat<f64>| (0..n * n).map(|k| matrix[(k / n, k % n)]).collect();
        Transfer {
            n,
            matrices,
            sizes,
            losses: losses.map(flat),
            acts: ports
                .acts
                .into_iter()
                .map(|(power, of)| (power, dense(n, &of)))
                .collect(),
            reads: ports
                .sums
                .into_iter()
                .map(|(_, power, of)| {
                    let factors = of.into_iter().map(|(i, part)| (i, part.factor().1));
                    (power, factors.collect())
                })
                .collect(),
            direct: ports
                .direct
                .into_iter()
                .map(|(_, part)| part.factor())
                .collect(),
        }
    }

    pub(super) fn losses(&self) -> Option<faer::Mat<f64>> {
        let n = self.n;
        let losses = self.losses.as_ref()?;
        Some(faer::Mat::from_fn(n, n, |i, j| losses[i * n + j]))
    }

    /// Z = K + iL + sC + s²M or a derivative of it by s.
    fn stiffness(&self, at: usize, frequency: f64, order: i32) -> Complex<f64> {
        let [k, c, m] = [0, 1, 2].map(|power| self.matrices[power][at]);
        match order {
            0 => {
                let loss = self.losses.as_ref().map_or(0.0, |losses| losses[at]);
                let square = frequency * frequency;
                Complex::new(k - square * m, frequency * c + loss)
            }
            1 => Complex::new(c, 2.0 * frequency * m),
            _ => Complex::new(2.0 * m, 0.0),
        }
    }

    /// b or a derivative of it by s.
    fn force(&self, frequency: f64, order: i32) -> Vec<Complex<f64>> {
        let mut force = vec![Complex::ZERO; self.n];
        for (power, acts) in &self.acts {
            let factor = derived(frequency, *power, order);
            for (sum, act) in force.iter_mut().zip(acts) {
                *sum += factor * act;
            }
        }
        force
    }

    /// c or a derivative of it by s.
    fn row(&self, frequency: f64, order: i32) -> Vec<Complex<f64>> {
        let mut row = vec![Complex::ZERO; self.n];
        for (power, parts) in &self.reads {
            let factor = derived(frequency, *power, order);
            parts.iter().for_each(|(i, by)| row[*i] += factor * by);
        }
        row
    }

    fn passed(&self, frequency: f64, order: i32) -> Complex<f64> {
        let parts = self.direct.iter();
        parts
            .map(|(power, by)| derived(frequency, *power, order) * by)
            .sum()
    }

    /// yᵀZx.
    fn between(&self, y: &[Complex<f64>], x: &[Complex<f64>], frequency: f64) -> Complex<f64> {
        let n = self.n;
        let row = |i: usize| -> Complex<f64> {
            (0..n)
                .map(|j| self.stiffness(i * n + j, frequency, 0) * x[j])
                .sum()
        };
        (0..n).map(|i| y[i] * row(i)).sum()
    }

    fn factor(&self, frequency: f64) -> Option<Factor> {
        let entries = (0..self.n * self.n).map(|at| self.stiffness(at, frequency, 0));
        Factor::of(entries.collect(), self.n)
    }

    /// Its value at a frequency in rad/s; `None` at a pole.
    pub fn value(&self, frequency: f64) -> Option<Complex<f64>> {
        let x = self.factor(frequency)?.solve(self.force(frequency, 0));
        let value = product(&self.row(frequency, 0), &x) + self.passed(frequency, 0);
        value.is_finite().then_some(value)
    }

    /// Its value with what its derivatives take; `None` at a pole.
    pub fn adjoint(&self, frequency: f64) -> Option<Adjoint> {
        let factor = self.factor(frequency)?;
        let x = factor.solve(self.force(frequency, 0));
        let row = self.row(frequency, 0);
        let value = product(&row, &x) + self.passed(frequency, 0);
        let y = factor.solve_transposed(row);
        value.is_finite().then_some(Adjoint {
            frequency,
            value,
            x,
            y,
        })
    }

    /// An estimate of what rounding makes of the value: some units of all terms that it depends on.
    pub(super) fn rounding(&self, adjoint: &Adjoint) -> f64 {
        let (n, frequency) = (self.n, adjoint.frequency);
        let powers = [1.0, frequency, frequency * frequency];
        let mut sum = adjoint.value.norm();
        for i in 0..n {
            for j in 0..n {
                let at = i * n + j;
                let terms = (0..3).map(|k| powers[k] * self.sizes[k][at]);
                let loss = self.losses.as_ref().map_or(0.0, |losses| losses[at].abs());
                let size = terms.sum::<f64>() + loss;
                sum += size * adjoint.y[i].norm() * adjoint.x[j].norm();
            }
        }
        (n as f64 + 8.0) * f64::EPSILON * sum
    }

    /// ln|H| and its first two derivatives by the frequency.
    pub(super) fn steepness(&self, frequency: f64) -> Option<[f64; 3]> {
        let n = self.n;
        let factor = self.factor(frequency)?;
        let x = factor.solve(self.force(frequency, 0));
        let pushed = |x: &[Complex<f64>], order: i32| -> Vec<Complex<f64>> {
            let row = |i: usize| {
                (0..n)
                    .map(|j| self.stiffness(i * n + j, frequency, order) * x[j])
                    .sum::<Complex<f64>>()
            };
            (0..n).map(row).collect()
        };
        let less = |mut force: Vec<Complex<f64>>, by: &[Complex<f64>], times: f64| {
            force.iter_mut().zip(by).for_each(|(f, b)| *f -= b * times);
            force
        };
        let first = less(self.force(frequency, 1), &pushed(&x, 1), 1.0);
        let first = factor.solve(first);
        let second = less(self.force(frequency, 2), &pushed(&x, 2), 1.0);
        let second = factor.solve(less(second, &pushed(&first, 1), 2.0));
        let [row, rows, more] = [0, 1, 2].map(|order| self.row(frequency, order));
        let value = product(&row, &x) + self.passed(frequency, 0);
        let rate = product(&rows, &x) + product(&row, &first) + self.passed(frequency, 1);
        let bend = product(&more, &x)
            + product(&rows, &first) * 2.0
            + product(&row, &second)
            + self.passed(frequency, 2);
        // d/dΩ = i d/ds.
        let (rate, bend) = (Complex::<f64>::I * rate / value, -bend / value);
        let found = [value.norm().ln(), rate.re, (bend - rate * rate).re];
        found.iter().all(|value| value.is_finite()).then_some(found)
    }
}

/// s^power, or a derivative of it by s.
fn derived(frequency: f64, power: i32, order: i32) -> Complex<f64> {
    let factor: i32 = (0..order).map(|k| power - k).product();
    match factor {
        0 => Complex::ZERO,
        factor => turn(frequency, power - order) * f64::from(factor),
    }
}

fn product(a: &[Complex<f64>], b: &[Complex<f64>]) -> Complex<f64> {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// L and U of a small matrix, row by row, with its rows exchanged.
struct Factor {
    n: usize,
    entries: Vec<Complex<f64>>,
    rows: Vec<usize>,
}

impl Factor {
    /// `None` where a pivot is 0.
    fn of(mut entries: Vec<Complex<f64>>, n: usize) -> Option<Factor> {
        let mut rows: Vec<usize> = (0..n).collect();
        for k in 0..n {
            let size = |i: &usize| entries[i * n + k].l1_norm();
            let pivot = (k..n).max_by(|a, b| size(a).total_cmp(&size(b)))?;
            if pivot != k {
                rows.swap(k, pivot);
                (0..n).for_each(|j| entries.swap(k * n + j, pivot * n + j));
            }
            let head = entries[k * n + k];
            if head == Complex::ZERO || !head.is_finite() {
                return None;
            }
            let inverse = head.inv();
            for i in k + 1..n {
                let factor = entries[i * n + k] * inverse;
                entries[i * n + k] = factor;
                if factor != Complex::ZERO {
                    for j in k + 1..n {
                        let above = entries[k * n + j];
                        entries[i * n + j] -= factor * above;
                    }
                }
            }
        }
        Some(Factor { n, entries, rows })
    }

    fn solve(&self, right: Vec<Complex<f64>>) -> Vec<Complex<f64>> {
        let n = self.n;
        let mut x: Vec<Complex<f64>> = self.rows.iter().map(|i| right[*i]).collect();
        for i in 0..n {
            for j in 0..i {
                let known = x[j];
                x[i] -= self.entries[i * n + j] * known;
            }
        }
        for i in (0..n).rev() {
            for j in i + 1..n {
                let known = x[j];
                x[i] -= self.entries[i * n + j] * known;
            }
            x[i] /= self.entries[i * n + i];
        }
        x
    }

    fn solve_transposed(&self, mut right: Vec<Complex<f64>>) -> Vec<Complex<f64>> {
        let n = self.n;
        for i in 0..n {
            right[i] /= self.entries[i * n + i];
            let known = right[i];
            let row = &self.entries[i * n + i + 1..(i + 1) * n];
            for (entry, right) in row.iter().zip(&mut right[i + 1..]) {
                *right -= entry * known;
            }
        }
        for i in (0..n).rev() {
            let known = right[i];
            let row = &self.entries[i * n..i * n + i];
            for (entry, right) in row.iter().zip(&mut right[..i]) {
                *right -= entry * known;
            }
        }
        let mut y = vec![Complex::ZERO; n];
        self.rows
            .iter()
            .zip(right)
            .for_each(|(i, value)| y[*i] = value);
        y
    }
}
