//! e^(Ah) and what constant, growing and harmonic loads add, in the same memory again and again.

use pulp::Arch;

use crate::hold::Laws;

/// Rows are padded to a multiple of this, so that loops over them have no remainders.
const LANES: usize = 4;

/// z(h) = Φ z(0) + Γ s for z′ = A z + B f: one exponential of A bordered by the generators of the
/// loads (Van Loan 1978, *IEEE Trans. Autom. Control* 23), by scaling and squaring of a Taylor
/// polynomial.
#[derive(Clone, Debug)]
pub(super) struct Propagator {
    states: usize,
    inputs: usize,
    rows: usize,
    /// Buffers of `rows` × (states + inputs), column by column: A and its powers, then what the
    /// polynomial needs.
    generator: Vec<f64>,
    square: Vec<f64>,
    cube: Vec<f64>,
    fourth: Vec<f64>,
    sum: Vec<f64>,
    spare: Vec<f64>,
    scale: Vec<f64>,
}

/// 1/k! for k = 0 … 16.
const fn inverse_factorials() -> [f64; 17] {
    let mut all = [1.0; 17];
    let mut factorial = 1.0;
    let mut k = 1;
    while k < 17 {
        factorial *= k as f64;
        all[k] = 1.0 / factorial;
        k += 1;
    }
    all
}

/// Up to this norm the Taylor polynomial of degree 16 has a backward error below 2^-53 (Higham
/// 2008, *Functions of Matrices*, table 10.1 for Taylor polynomials: 0.78).
const REACH: f64 = 0.78;

impl Propagator {
    pub(super) fn new(states: usize, loaded: usize, laws: &Laws) -> Propagator {
        let blocks =
            usize::from(laws.straight) + usize::from(laws.sloped) + 2 * laws.frequencies.len();
        let inputs = blocks * loaded;
        let size = states + inputs;
        let rows = size.next_multiple_of(LANES);
        let buffer = || vec![0.0; rows * size];
        Propagator {
            states,
            inputs,
            rows,
            generator: buffer(),
            square: buffer(),
            cube: buffer(),
            fourth: buffer(),
            sum: buffer(),
            spare: buffer(),
            scale: vec![1.0; size],
        }
    }

    /// Computes Φ and Γ over `h` seconds; `a` gives the entries of A, `force` those that a unit
    /// force on the j-th loaded coordinate makes of z′. False where numbers leave the range of doubles.
    pub(super) fn prepare(
        &mut self,
        h: f64,
        laws: &Laws,
        a: impl Fn(usize, usize) -> f64,
        force: impl Fn(usize, usize) -> f64,
    ) -> bool {
        let (n, rows, size) = (self.states, self.rows, self.states + self.inputs);
        let blocks =
            usize::from(laws.straight) + usize::from(laws.sloped) + 2 * laws.frequencies.len();
        let loaded = self.inputs.checked_div(blocks).unwrap_or(0);
        let g = &mut self.generator;
        g.fill(0.0);
        for j in 0..n {
            for i in 0..n {
                g[i + rows * j] = h * a(i, j);
            }
        }
        let harmonic = usize::from(laws.straight) + usize::from(laws.sloped);
        let straight = laws.straight.then_some(0);
        let sines = (0..laws.frequencies.len()).map(|index| harmonic + 2 * index);
        for block in straight.into_iter().chain(sines) {
            for j in 0..loaded {
                for i in 0..n {
                    g[i + rows * (n + block * loaded + j)] = h * force(i, j);
                }
            }
        }
        for j in 0..loaded {
            if laws.sloped {
                g[n + j + rows * (n + loaded + j)] = 1.0;
            }
            for (index, frequency) in laws.frequencies.iter().enumerate() {
                let sine = n + (harmonic + 2 * index) * loaded + j;
                g[sine + rows * (sine + loaded)] = frequency * h;
                g[sine + loaded + rows * sine] = -frequency * h;
            }
        }
        let Some(squarings) = self.balance(size) else {
            return false;
        };
        Arch::new().dispatch(|| self.polynomial(size, squarings));
        for j in 0..size {
            for i in 0..n {
                self.sum[i + rows * j] *= self.scale[i] / self.scale[j];
            }
        }
        for j in 0..n {
            self.sum[j + rows * j] += 1.0;
        }
        self.sum.iter().all(|entry| entry.is_finite())
    }

    /// Scales the generator to D⁻¹GD, D of powers of two, with nearly equal norms of rows and columns
    /// (Parlett & Reinsch 1969, *Numer. Math.* 13), then to a norm within reach of the polynomial; returns how
    /// often it was halved. Columns of the inputs are scaled down freely: they cost no squarings.
    fn balance(&mut self, size: usize) -> Option<i32> {
        const ROUNDS: usize = 20;
        let (rows, g, scale) = (self.rows, &mut self.generator, &mut self.scale);
        scale.fill(1.0);
        for _ in 0..ROUNDS {
            let mut settled = true;
            for i in 0..size {
                let (mut column, mut row) = (0.0, 0.0);
                for j in (0..size).filter(|j| *j != i) {
                    column += g[j + rows * i].abs();
                    row += g[i + rows * j].abs();
                }
                // An input that nothing feeds: its column to norm 1.
                let ratio: f64 = if row == 0.0 {
                    column.powi(-2)
                } else {
                    row / column
                };
                if !(ratio > 0.0 && ratio.is_finite()) {
                    continue;
                }
                let exponent = (0.5 * ratio.log2()).round();
                let factor = exponent.exp2();
                let gains = if row == 0.0 {
                    column > 1.0
                } else {
                    column * factor + row / factor < 0.95 * (column + row)
                };
                if exponent != 0.0 && gains {
                    settled = false;
                    scale[i] *= factor;
                    for j in 0..size {
                        g[j + rows * i] *= factor;
                        g[i + rows * j] /= factor;
                    }
                }
            }
            if settled {
                break;
            }
        }
        let sums = g
            .chunks_exact(rows)
            .map(|column| column.iter().map(|x| x.abs()).sum());
        let norm = sums.fold(
            0.0,
            |top: f64, sum: f64| if sum > top || sum.is_nan() { sum } else { top },
        );
        if !norm.is_finite() {
            return None;
        }
        let squarings = (norm / REACH).log2().ceil().max(0.0) as i32;
        // Two factors: one alone may be out of range.
        let half = squarings / 2;
        let factors = [0.5f64.powi(half), 0.5f64.powi(squarings - half)];
        g.iter_mut()
            .for_each(|entry| *entry = *entry * factors[0] * factors[1]);
        Some(squarings)
    }

    /// e^G − I into `sum`. The identity is left out to the end: what moves slowly beside something
    /// fast keeps its digits.
    #[inline(always)]
    fn polynomial(&mut self, size: usize, squarings: i32) {
        const C: [f64; 17] = inverse_factorials();
        let rows = self.rows;
        multiply(
            &mut self.square,
            &self.generator,
            &self.generator,
            rows,
            size,
        );
        multiply(&mut self.cube, &self.square, &self.generator, rows, size);
        multiply(&mut self.fourth, &self.square, &self.square, rows, size);
        // Degree 16 by four products of G⁴ (Paterson & Stockmeyer 1973).
        let powers = [&self.generator[..], &self.square, &self.cube, &self.fourth];
        combine(&mut self.sum, powers, [C[13], C[14], C[15], C[16]]);
        for part in [8, 4, 0] {
            for j in 0..size {
                self.sum[j + rows * j] += C[part + 4];
            }
            multiply(&mut self.spare, &self.sum, &self.fourth, rows, size);
            let powers = [&self.generator[..], &self.square, &self.cube, &self.spare];
            combine(
                &mut self.sum,
                powers,
                [C[part + 1], C[part + 2], C[part + 3], 1.0],
            );
        }
        for _ in 0..squarings {
            // (I + D)² = I + 2D + D².
            multiply(&mut self.spare, &self.sum, &self.sum, rows, size);
            for (sum, square) in self.sum.iter_mut().zip(&self.spare) {
                *sum = 2.0 * *sum + square;
            }
        }
    }

    /// Γ s.
    pub(super) fn drive(&self, signal: &[f64], drive: &mut [f64]) {
        drive.fill(0.0);
        for (j, value) in signal
            .iter()
            .enumerate()
            .filter(|(_, value)| **value != 0.0)
        {
            let column = &self.sum[self.rows * (self.states + j)..];
            for (entry, factor) in drive.iter_mut().zip(column).take(self.states) {
                *entry += factor * value;
            }
        }
    }

    /// z ← Φ z + drive; `next` is written over. All have room for padded rows.
    #[inline(always)]
    pub(super) fn advance(&self, z: &mut [f64], drive: &[f64], next: &mut [f64]) {
        let padded = self.states.next_multiple_of(LANES);
        let next = &mut next[..padded];
        next.copy_from_slice(&drive[..padded]);
        for (column, value) in self.sum.chunks_exact(self.rows).zip(&z[..self.states]) {
            for (entry, factor) in next.iter_mut().zip(&column[..padded]) {
                *entry += factor * value;
            }
        }
        z[..self.states].copy_from_slice(&next[..self.states]);
    }
}

/// out = x·y.
#[inline(always)]
fn multiply(out: &mut [f64], x: &[f64], y: &[f64], rows: usize, size: usize) {
    let columns = out.chunks_exact_mut(rows).zip(y.chunks_exact(rows));
    for (out, y) in columns {
        out.fill(0.0);
        for (x, factor) in x.chunks_exact(rows).zip(&y[..size]) {
            for (out, x) in out
                .as_chunks_mut::<LANES>()
                .0
                .iter_mut()
                .zip(x.as_chunks::<LANES>().0)
            {
                for lane in 0..LANES {
                    out[lane] += x[lane] * factor;
                }
            }
        }
    }
}

/// out = Σ factor · x.
#[inline(always)]
fn combine(out: &mut [f64], [a, b, c, d]: [&[f64]; 4], [fa, fb, fc, fd]: [f64; 4]) {
    let terms = a.iter().zip(b).zip(c).zip(d);
    for (out, (((a, b), c), d)) in out.iter_mut().zip(terms) {
        *out = (fa * a + fb * b) + (fc * c + fd * d);
    }
}
