//! Frequency response functions in doubles by a Hessenberg form that all frequencies share.
//!
//! Reflections turn z′ = Az + bf into x′ = Hx + βe₁f, where H has nothing below its first subdiagonal (Laub 1981, *IEEE Trans.
//! Autom. Control* 26). All rows but the first of (s − H)x = βe₁ give x from its last entry upwards, up to a factor, and the
//! first row gives that factor: Hyman's method, which solves equations next to these (Higham 2002, section 14.6.1). It takes
//! O(N²) a frequency, most of it in products of matrices for many frequencies at once.
//!
//! Losses of springs make A complex, A + iA′; then z = z₁ + iz₂ with real equations for both, [z₁′; z₂′] = [A −A′; A′ A][z₁; z₂],
//! in which i is a matrix of its own, beside that of s = iΩ.
//!
//! Errors are estimated: H, β and x are those of an A that differs by some rounding units of its norm, so that x is off by
//! (s − A)⁻¹ times that. How much (s − A)⁻¹ enlarges is what it makes of a vector at random, which excites all modes. How many
//! units there are is measured, by what x leaves of the equations of motion at some of the frequencies.

use std::ops::Range;

use eigentone_modes::{FirstOrder, System, balance};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::hessenberg::{hessenberg_in_place, hessenberg_in_place_scratch};
use faer::linalg::householder::{
    apply_block_householder_sequence_on_the_right_in_place_scratch as apply_scratch,
    apply_block_householder_sequence_on_the_right_in_place_with_conj as apply,
};
use faer::linalg::matmul::matmul;
use faer::{Accum, Conj, Mat, MatMut, MatRef, Par, Spec};
use num_complex::Complex;
use pulp::Arch;

use super::dynamic_stiffness::losses;
use super::modal_functions::{Value, turn};
use super::ports::{Ports, Push, Reading, dense};
use super::random::Random;

/// As many frequencies as one product of matrices takes.
const BATCH: usize = 128;

/// Estimates above this share of the state are none.
const LEAST_DIGITS: f64 = 1e-9;

/// What all inputs share.
pub(super) struct Hessenberg {
    /// A, balanced.
    a: Mat<f64>,
    /// By what the states were divided.
    scale: Vec<f64>,
    first_order: FirstOrder,
    /// M, C and K.
    matrices: [Mat<f64>; 3],
    /// What the losses of springs add to K, times i.
    losses: Option<Mat<f64>>,
    /// The norm of A.
    norm: f64,
    probe: Form,
}

/// One input.
pub(super) struct Column {
    ports: Ports,
    /// By power of s, with real and imaginary parts of the sums of coordinates, one a column.
    forms: Vec<(i32, Form, Mat<f64>)>,
    /// Of each sum of coordinates, the size of its rows.
    lengths: Vec<f64>,
    /// How many units of the norm A is off.
    rounding: f64,
}

/// (s − H)x = βe₁.
struct Form {
    /// H; its states beyond what the input reaches are left out.
    h: Mat<f64>,
    /// β.
    force: f64,
    /// What the coordinates are of x; their imaginary parts follow where there are losses.
    shapes: Mat<f64>,
}

/// Solutions for several frequencies, but for a factor each.
struct Motion {
    /// Frequencies along a column: real parts, then imaginary ones; a column for each state.
    x: Mat<f64>,
    /// What they are to be multiplied by.
    factors: Vec<Complex<f64>>,
    /// The norms of the products.
    sizes: Vec<f64>,
}

impl Hessenberg {
    /// With a loss factor for each spring, or for none; `None` where forces act on what has no state.
    pub(super) fn of(system: &System, loss_factors: &[f64]) -> Option<Hessenberg> {
        let first_order = FirstOrder::of(system).ok()?;
        if first_order.d().is_some() {
            return None;
        }
        let lossy = loss_factors.iter().any(|factor| *factor != 0.0);
        let losses = lossy.then(|| losses(system, loss_factors));
        let balanced = match &losses {
            None => balance(first_order.a()),
            Some(losses) => {
                let (a, n) = (first_order.a(), first_order.states());
                let turned = first_order.b() * losses * first_order.x();
                let mut both = Mat::zeros(2 * n, 2 * n);
                for half in [0, n] {
                    both.submatrix_mut(half, half, n, n).copy_from(a);
                }
                both.submatrix_mut(0, n, n, n).copy_from(&turned);
                both.submatrix_mut(n, 0, n, n).copy_from(-turned);
                balance(both.as_ref())
            }
        };
        let norm = balanced.matrix.norm_l2();
        let states = balanced.scale.len();
        let mut random = Random(1);
        let start: Vec<f64> = (0..states).map(|_| random.signed()).collect();
        let probe = Form::of(
            balanced.matrix.as_ref(),
            &start,
            Mat::zeros(0, states),
            norm,
        );
        norm.is_finite().then(|| Hessenberg {
            a: balanced.matrix,
            scale: balanced.scale,
            first_order,
            matrices: [
                system.mass_matrix(),
                system.damping_matrix(),
                system.stiffness_matrix(),
            ],
            losses,
            norm,
            probe,
        })
    }

    /// For each frequency by how much (s − A)⁻¹ enlarges: measured at every eighth, and where the two beside do not decide.
    pub(super) fn enlargements(&self, frequencies: &[f64]) -> Vec<f64> {
        const STRIDE: usize = 8;
        let all = 0..frequencies.len();
        let mut known = vec![f64::NAN; frequencies.len()];
        self.measure(frequencies, all.clone().step_by(STRIDE), &mut known);
        for index in all.clone().filter(|index| index % STRIDE > 0) {
            let before = index - index % STRIDE;
            let beside = [before, before + STRIDE].into_iter().map(|at| {
                let distance = |other: &f64| (other - frequencies[index]).abs();
                let measured = frequencies.get(at).map(distance).zip(known.get(at));
                measured.map_or(f64::NAN, |(distance, measured)| {
                    self.beside(*measured, distance)
                })
            });
            known[index] = beside.fold(f64::NAN, f64::min);
        }
        let left: Vec<usize> = all.filter(|index| known[*index].is_nan()).collect();
        self.measure(frequencies, left.into_iter(), &mut known);
        known
    }

    fn measure(
        &self,
        frequencies: &[f64],
        at: impl Iterator<Item = usize>,
        enlargements: &mut [f64],
    ) {
        let at: Vec<usize> = at.collect();
        for batch in at.chunks(BATCH) {
            let own: Vec<f64> = batch.iter().map(|index| frequencies[*index]).collect();
            let sizes = self.probe.motion(&own).sizes;
            for (index, size) in batch.iter().zip(sizes) {
                enlargements[*index] = size / self.probe.force.abs();
            }
        }
    }

    /// What an enlargement says at most of a frequency at some distance, NaN where that is nothing: R(s + iδ) is
    /// (1 + iδR(s))⁻¹R(s), and |R| may be √N times as large as what it makes of a vector at random, and three times that
    /// where that vector has little of what is enlarged.
    fn beside(&self, enlargement: f64, distance: f64) -> f64 {
        let change = 3.0 * distance * enlargement * (self.scale.len() as f64).sqrt();
        if change < 0.5 {
            enlargement / (1.0 - change)
        } else {
            f64::NAN
        }
    }

    /// One input.
    pub(super) fn column(
        &self,
        pushes: &[Push],
        readings: &[Reading],
        frequencies: &[f64],
    ) -> Option<Column> {
        let x = self.first_order.x();
        let (n, states) = (x.nrows(), x.ncols());
        let ports = Ports::of(pushes, readings);
        let halves = self.scale.len() / states;
        let mut shapes = Mat::zeros(halves * n, halves * states);
        for half in 0..halves {
            for j in 0..states {
                let scale = self.scale[half * states + j];
                (0..n).for_each(|i| shapes[(half * n + i, half * states + j)] = x[(i, j)] * scale);
            }
        }
        let b = self.first_order.b();
        let mut column = Column {
            lengths: vec![0.0; ports.sums.len()],
            rounding: LEAST_UNITS * f64::EPSILON,
            forms: Vec::new(),
            ports,
        };
        for (power, acts) in &column.ports.acts {
            let force = &dense(n, acts);
            let parts: [fn(&Complex<f64>) -> f64; 2] = [|force| force.re, |force| force.im];
            let rows = parts.into_iter().take(halves).flat_map(|part| {
                (0..states).map(move |i| {
                    let terms = force.iter().enumerate();
                    terms.map(|(j, force)| b[(i, j)] * part(force)).sum::<f64>()
                })
            });
            let start = rows.zip(&self.scale).map(|(row, scale)| row / scale);
            let start: Vec<f64> = start.collect();
            let form = Form::of(self.a.as_ref(), &start, shapes.clone(), self.norm);
            for frequency in samples(frequencies) {
                let measured = self.backward_error(&form, force, frequency)?;
                column.rounding = column.rounding.max(MORE * measured);
            }
            let (real, imaginary) = form.shapes.as_ref().split_at_row(n);
            let mut outputs = column.ports.outputs(real, |factor| factor.re);
            if imaginary.nrows() > 0 {
                let turned = column.ports.outputs(imaginary, |factor| factor.im);
                let both = [
                    outputs - turned,
                    column.ports.outputs(real, |factor| factor.im)
                        + column.ports.outputs(imaginary, |factor| factor.re),
                ];
                let sums = both[0].nrows();
                outputs = Mat::from_fn(2 * sums, both[0].ncols(), |i, j| {
                    both[i / sums][(i % sums, j)]
                });
            }
            let sums = column.lengths.len();
            for (row, length) in column.lengths.iter_mut().enumerate() {
                let own = (row..outputs.nrows()).step_by(sums);
                let size: f64 = own.map(|row| outputs.row(row).norm_l2()).sum();
                *length = size.max(*length);
            }
            let outputs = outputs.transpose().to_owned();
            column.forms.push((*power, form, outputs));
        }
        column.rounding.is_finite().then_some(column)
    }

    /// What a solution leaves of the equations of motion, as a share of the norm of A.
    fn backward_error(&self, form: &Form, force: &[Complex<f64>], frequency: f64) -> Option<f64> {
        let motion = form.motion(&[frequency]);
        let n = force.len();
        let x = &motion.x * form.shapes.transpose();
        let x: Vec<Complex<f64>> = (0..n)
            .map(|i| {
                let parts = (i..x.ncols()).step_by(n);
                let parts = parts.map(|i| Complex::new(x[(0, i)], x[(1, i)]));
                let turns = [Complex::ONE, Complex::I];
                let sum: Complex<f64> = parts.zip(turns).map(|(part, turn)| part * turn).sum();
                sum * motion.factors[0]
            })
            .collect();
        let s = Complex::new(0.0, frequency);
        let mut left = force.to_vec();
        for (j, x) in x.iter().enumerate() {
            for (i, left) in left.iter_mut().enumerate() {
                let [m, c, k] = self.matrices.each_ref().map(|matrix| matrix[(i, j)]);
                let lost = self.losses.as_ref().map_or(0.0, |losses| losses[(i, j)]);
                *left -= (Complex::new(k, lost) + s * c + s * s * m) * x;
            }
        }
        let b = self.first_order.b();
        let parts = (0..b.nrows()).map(|i| {
            let terms = left.iter().enumerate().map(|(j, left)| b[(i, j)] * left);
            (terms.sum::<Complex<f64>>() / self.scale[i]).norm_sqr()
        });
        let share = parts.sum::<f64>().sqrt() / ((self.norm + frequency) * motion.sizes[0]);
        match motion.sizes[0] == 0.0 {
            true => Some(0.0),
            false => share.is_finite().then_some(share),
        }
    }
}

/// A is taken to be off by so many rounding units of its norm at least.
const LEAST_UNITS: f64 = 8.0;

/// And by so many times what is measured.
const MORE: f64 = 4.0;

/// Some of the frequencies.
fn samples(frequencies: &[f64]) -> impl Iterator<Item = f64> + '_ {
    let last = frequencies.len().saturating_sub(1);
    let mut at = vec![0, last / 3, last];
    at.dedup();
    at.into_iter().filter_map(|at| frequencies.get(at).copied())
}

impl Column {
    /// For each frequency in rad/s the values of all outputs; `None` where too few digits are left.
    pub(super) fn values(
        &self,
        of: &Hessenberg,
        frequencies: &[f64],
        enlargements: &[f64],
    ) -> Vec<Option<Vec<Value>>> {
        let batches = frequencies.chunks(BATCH).zip(enlargements.chunks(BATCH));
        let values = batches.flat_map(|(batch, enlargements)| {
            let solved = self.forms.iter().map(|(power, form, outputs)| {
                let motion = form.motion(batch);
                (*power, &motion.x * outputs, motion)
            });
            let solved: Vec<(i32, Mat<f64>, Motion)> = solved.collect();
            let each = batch.iter().zip(enlargements).enumerate();
            let read = each.map(|(at, (&frequency, enlargement))| {
                let off = self.rounding * (of.norm + frequency) * enlargement;
                self.read(&solved, at, frequency, off)
            });
            read.collect::<Vec<_>>()
        });
        values.collect()
    }

    /// At one frequency, where states are off by this share.
    fn read(
        &self,
        solved: &[(i32, Mat<f64>, Motion)],
        at: usize,
        frequency: f64,
        off: f64,
    ) -> Option<Vec<Value>> {
        if off.is_nan() || off > LEAST_DIGITS {
            return None;
        }
        let mut values = vec![(Complex::ZERO, 0.0); self.ports.count];
        let rounding = |count: usize| 4.0 * (count as f64).sqrt() * f64::EPSILON;
        for (power, products, motion) in solved {
            let half = motion.factors.len();
            let off = motion.sizes[at] * (off + rounding(motion.x.ncols()));
            let sums = self.ports.sums.len();
            for (row, (index, order, _)) in self.ports.sums.iter().enumerate() {
                let product = |row| Complex::new(products[(at, row)], products[(half + at, row)]);
                let product = match products.ncols() > sums {
                    true => product(row) + Complex::<f64>::I * product(sums + row),
                    false => product(row),
                };
                let order = order + power;
                let (value, bound) = &mut values[*index];
                *value += product * motion.factors[at] * turn(frequency, order);
                *bound += self.lengths[row] * off * frequency.powi(order);
            }
        }
        for (index, part) in &self.ports.direct {
            let (index, (power, coefficient)) = (*index, part.factor());
            values[index].0 += turn(frequency, power) * coefficient;
            values[index].1 += coefficient.norm() * frequency.powi(power) * rounding(1);
        }
        let mut all = values.iter();
        all.all(|(value, bound)| value.is_finite() && bound.is_finite())
            .then_some(values)
    }
}

impl Form {
    /// Of A and b, with what the coordinates are of z.
    fn of(a: MatRef<'_, f64>, start: &[f64], mut shapes: Mat<f64>, norm: f64) -> Form {
        let n = a.nrows();
        // Reflections of [0 0; b A] keep the first row.
        let mut bordered = Mat::<f64>::zeros(n + 1, n + 1);
        for (i, start) in start.iter().enumerate() {
            bordered[(i + 1, 0)] = *start;
        }
        bordered.submatrix_mut(1, 1, n, n).copy_from(a);
        let width = faer::linalg::qr::no_pivoting::factor::recommended_block_size::<f64>(n, n);
        let mut factors = Mat::<f64>::zeros(width, n);
        let scratch = hessenberg_in_place_scratch::<f64>(n + 1, width, Par::Seq, Spec::default());
        hessenberg_in_place(
            bordered.as_mut(),
            factors.as_mut(),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(scratch)),
            Spec::default(),
        );
        if shapes.nrows() > 0 {
            let scratch = apply_scratch::<f64>(n, width, shapes.nrows());
            apply(
                bordered.submatrix(1, 0, n, n),
                factors.as_ref(),
                Conj::No,
                shapes.as_mut(),
                Par::Seq,
                MemStack::new(&mut MemBuffer::new(scratch)),
            );
        }
        let force = bordered[(1, 0)];
        let h = bordered.submatrix(1, 1, n, n);
        // What is next to nothing beside A cuts off the states beyond.
        let cut = (1..n).find(|k| h[(*k, k - 1)].abs() <= f64::EPSILON * norm);
        let reached = if force == 0.0 { 0 } else { cut.unwrap_or(n) };
        Form {
            h: h.submatrix(0, 0, reached, reached).to_owned(),
            force,
            shapes: shapes.subcols(0, reached).to_owned(),
        }
    }

    fn motion(&self, frequencies: &[f64]) -> Motion {
        /// Rows that are taken together.
        const ROWS: usize = 8;
        let (n, count) = (self.h.nrows(), frequencies.len());
        let mut x = Mat::<f64>::zeros(2 * count, n);
        if n == 0 {
            return Motion {
                x,
                factors: vec![Complex::ZERO; count],
                sizes: vec![0.0; count],
            };
        }
        x.col_as_slice_mut(n - 1)[..count].fill(1.0);
        let mut sums = Mat::<f64>::zeros(2 * count, ROWS);
        let mut end = n;
        while end > 0 {
            let begin = end.saturating_sub(ROWS);
            matmul(
                sums.as_mut().subcols_mut(0, end - begin),
                Accum::Replace,
                x.as_ref().subcols(end, n - end),
                self.h
                    .submatrix(begin, end, end - begin, n - end)
                    .transpose(),
                1.0,
                Par::Seq,
            );
            Arch::new().dispatch(
                #[inline(always)]
                || self.upwards(begin..end, frequencies, &mut sums, &mut x),
            );
            if begin > 0 {
                keep_in_range(x.as_mut().subcols_mut(begin - 1, n - begin + 1), count);
            }
            end = begin;
        }
        let (re, im) = sums.col_as_slice(0).split_at(count);
        let factors = re.iter().zip(im);
        let factors: Vec<Complex<f64>> = factors
            .map(|(re, im)| self.force / Complex::new(*re, *im))
            .collect();
        let mut squares = vec![0.0; count];
        Arch::new().dispatch(
            #[inline(always)]
            || {
                for k in 0..n {
                    let (re, im) = x.col_as_slice(k).split_at(count);
                    for (square, (re, im)) in squares.iter_mut().zip(re.iter().zip(im)) {
                        *square += re * re + im * im;
                    }
                }
            },
        );
        let sizes = squares.iter().zip(&factors);
        let sizes = sizes.map(|(square, factor)| square.sqrt() * factor.norm());
        Motion {
            sizes: sizes.collect(),
            factors,
            x,
        }
    }

    /// Takes some rows from below, with the sums of their entries beyond them.
    #[inline(always)]
    fn upwards(
        &self,
        rows: Range<usize>,
        frequencies: &[f64],
        sums: &mut Mat<f64>,
        x: &mut Mat<f64>,
    ) {
        let count = frequencies.len();
        for k in rows.clone().rev() {
            let own = sums.col_as_slice_mut(k - rows.start);
            for j in k..rows.end {
                let entry = self.h[(k, j)];
                for (own, x) in own.iter_mut().zip(x.col_as_slice(j)) {
                    *own += entry * x;
                }
            }
            // The row of s − H without its first entry.
            let (re, im) = x.col_as_slice(k).split_at(count);
            let (own_re, own_im) = own.split_at_mut(count);
            let own = own_re.iter_mut().zip(own_im).zip(re.iter().zip(im));
            for (((own_re, own_im), (re, im)), frequency) in own.zip(frequencies) {
                *own_re = -frequency * im - *own_re;
                *own_im = frequency * re - *own_im;
            }
            if k > 0 {
                let divisor = self.h[(k, k - 1)].recip();
                let before = x.col_as_slice_mut(k - 1).iter_mut();
                let own = sums.col_as_slice(k - rows.start);
                before.zip(own).for_each(|(x, own)| *x = own * divisor);
            }
        }
    }
}

/// Solutions may be multiplied by what one likes: those that have become large are made small.
fn keep_in_range(mut x: MatMut<'_, f64>, count: usize) {
    const LARGE: f64 = 1e50;
    for f in 0..count {
        let size = x[(f, 0)].abs().max(x[(count + f, 0)].abs());
        if size > LARGE && size.is_finite() {
            let factor = size.recip();
            for j in 0..x.ncols() {
                x[(f, j)] *= factor;
                x[(count + f, j)] *= factor;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_modes::GROUND;

    /// A chain of masses, hardly or strongly damped.
    fn chain(n: usize, damping: f64) -> System {
        let name = |i: usize| match i {
            0 => GROUND.to_owned(),
            i => format!("m{i}"),
        };
        let mut builder = System::builder();
        for i in 1..=n {
            let (before, own) = (name(i - 1), name(i));
            builder = builder
                .mass(&own, 1.0 + i as f64)
                .spring(&before, &own, 100.0)
                .damper(&before, &own, damping);
        }
        builder.build().expect("a chain")
    }

    #[test]
    fn enlargements_beside_the_measured_ones_are_hardly_larger_and_none_smaller() {
        let frequencies: Vec<f64> = (0..400).map(|k| 0.02 * f64::from(k)).collect();
        for (damping, likely) in [(1e-4, 20), (1.0, 60), (30.0, 250)] {
            let form = Hessenberg::of(&chain(12, damping), &[]).expect("a form");
            let mut measured = vec![f64::NAN; frequencies.len()];
            form.measure(&frequencies, 0..frequencies.len(), &mut measured);
            let found = form.enlargements(&frequencies);
            let estimated = found.iter().zip(&measured).filter(|(a, b)| a != b);
            let estimated = estimated.count();
            assert!(estimated >= likely, "{damping}: {estimated}");
            for (found, measured) in found.iter().zip(measured) {
                assert!(
                    (measured..=2.5 * measured).contains(found),
                    "{damping}: {found} {measured}"
                );
            }
        }
    }
}
