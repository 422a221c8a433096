//! Frequency response functions as sums over modes, with what bounds all that the modes leave of I − SZ (see `modal_sum`). Here they are
//! evaluated in plain doubles: many frequencies by one product of matrices, and single values in O(n) each.

use std::ops::RangeInclusive;

use eigentone_digits::{DoubleDouble, Real, WideComplex};
use faer::Mat;
use num_complex::Complex;

use super::dynamic_stiffness::Frequency;
use super::modal_sum::ModalSum;
use super::ports::{Ports, Push, Reading};
use super::refinement::UPWARD;

/// What is read of what one input does.
pub(super) struct ModalFunctions<'a> {
    pub(super) sum: &'a ModalSum,
    /// A row for each output and each power of s in it.
    pub(super) outputs: Vec<Vec<DoubleDouble>>,
    /// The same in doubles.
    pub(super) rounded: Mat<f64>,
    /// Which output, and which power.
    pub(super) rows: Vec<(usize, i32)>,
    pub(super) inputs: Vec<Input>,
    /// What passes by the modes: which output, which power, and the coefficient.
    pub(super) direct: Vec<(usize, i32, DoubleDouble)>,
    /// Lengths of the outputs: factors times the lengths of the coordinates.
    pub(super) lengths: Vec<(usize, i32, f64)>,
    /// By power, a bound of |D||f| in the lengths of the coordinates.
    pub(super) passed: Vec<(i32, f64)>,
    /// How many outputs there are.
    pub(super) count: usize,
    /// In lengths of the coordinates: bounds of the parts of F that grow with powers of s.
    pub(super) defects: [f64; 3],
    /// Likewise of the columns of U.
    pub(super) columns: Vec<f64>,
    /// |R| times the lengths.
    pub(super) residual: Vec<f64>,
    /// The largest rate of a mode, in 1/s.
    fastest: f64,
}

/// What acts on the modes by one power of s.
pub(super) struct Input {
    pub(super) power: i32,
    pub(super) modal: Vec<DoubleDouble>,
    /// Sums of the sizes of what it is the sum of.
    pub(super) sizes: Vec<f64>,
}

/// A value and how far it may be off.
pub(super) type Value = (Complex<f64>, f64);

/// As many frequencies as one product of matrices takes.
const BATCH: usize = 128;

impl<'a> ModalFunctions<'a> {
    /// Frequencies whose powers, and what is smaller still, stay within the range of doubles.
    pub(super) const RANGE: RangeInclusive<f64> = 1e-70..=1e70;

    /// Bounds that are smaller do not count products below the range of doubles.
    pub(super) const SMALLEST: f64 = 1e-290;

    /// Of what loses nothing in springs; `None` where a length is no number.
    pub(super) fn of(
        sum: &'a ModalSum,
        pushes: &[Push],
        readings: &[Reading],
    ) -> Option<ModalFunctions<'a>> {
        let (n, states) = (sum.coordinates(), sum.shapes.len());
        let Ports {
            acts,
            sums,
            direct,
            count,
        } = Ports::of(pushes, readings);
        let lengths = sum.common_lengths()?;
        let added = direct.iter();
        let added = added.map(|(index, part)| (*index, part.factor().0, part.product()));
        let mut direct: Vec<(usize, i32, DoubleDouble)> = added.collect();
        let mut passed = Vec::new();
        if let (Some(matrix), Some(size)) = (&sum.direct, &sum.sizes.2) {
            for (power, acts) in &acts {
                let mut largest = 0.0f64;
                for j in 0..n {
                    let terms = acts.iter();
                    let terms = terms.map(|(i, part)| size[(j, *i)] * part.factor().1.norm());
                    largest = largest.max(terms.sum::<f64>() / lengths[j]);
                }
                passed.push((*power, largest));
                for (index, order, parts) in &sums {
                    let pairs = parts.iter().flat_map(|(to, read)| {
                        acts.iter().map(move |(i, act)| (*to, read, *i, act))
                    });
                    let terms = pairs
                        .map(|(to, read, i, act)| read.product() * act.product() * matrix[(to, i)]);
                    let total = terms.fold(DoubleDouble::ZERO, |sum, term| sum + term);
                    direct.push((*index, order + power, total));
                }
            }
        }
        let inputs = acts.iter().map(|(power, acts)| {
            // What forces on several coordinates cancel of each other loses no digit of a double.
            let modal = (0..states).map(|k| {
                let terms = acts
                    .iter()
                    .map(|(j, part)| sum.weights[k][*j] * part.product());
                let total = terms.fold(DoubleDouble::ZERO, |sum, term| sum + term);
                let sizes = acts
                    .iter()
                    .map(|(j, part)| sum.sizes.1[(*j, k)] * part.factor().1.norm());
                (total, sizes.sum::<f64>())
            });
            let (modal, sizes) = modal.unzip();
            Input {
                power: *power,
                modal,
                sizes,
            }
        });
        let inputs: Vec<Input> = inputs.collect();
        let outputs = sums.iter().map(|(.., parts)| {
            let of = |shape: &Vec<DoubleDouble>| {
                let terms = parts.iter().map(|(i, part)| shape[*i] * part.product());
                terms.fold(DoubleDouble::ZERO, |sum, term| sum + term)
            };
            sum.shapes.iter().map(of).collect()
        });
        let outputs: Vec<Vec<DoubleDouble>> = outputs.collect();
        let each = sums.iter().map(|(index, power, parts)| {
            let terms = parts
                .iter()
                .map(|(i, part)| part.factor().1.norm() * lengths[*i]);
            (*index, *power, terms.sum())
        });
        let largest = |matrix: &Mat<f64>, weigh: &dyn Fn(usize) -> f64, j: usize| {
            let column = (0..n).map(|i| matrix[(i, j)] * weigh(j) / lengths[i]);
            column.fold(0.0, f64::max)
        };
        let defects = sum.defects.each_ref().map(|defect| {
            let rows = (0..n).map(|i| {
                let terms = (0..n).map(|j| defect[(i, j)] * lengths[j]);
                terms.sum::<f64>() / lengths[i]
            });
            rows.fold(0.0, f64::max)
        });
        let columns = (0..states).map(|k| largest(&sum.sizes.0, &|_| 1.0, k));
        let residual = (0..states).map(|k| {
            let terms = (0..n).map(|j| sum.residual[(k, j)] * lengths[j]);
            terms.sum()
        });
        Some(ModalFunctions {
            fastest: sum.rates().iter().fold(0.0, |most, rate| rate[1].max(most)),
            count,
            inputs,
            lengths: each.collect(),
            columns: columns.collect(),
            residual: residual.collect(),
            rows: sums
                .iter()
                .map(|(index, power, _)| (*index, *power))
                .collect(),
            sum,
            rounded: Mat::from_fn(outputs.len(), states, |row, k| outputs[row][k].high()),
            outputs,
            direct,
            passed,
            defects,
        })
    }

    /// For each frequency in rad/s the values of all outputs; `None` where the modes prove nothing.
    pub(super) fn values(&self, frequencies: &[f64]) -> Vec<Option<Vec<Value>>> {
        let batches = frequencies.chunks(BATCH);
        batches.flat_map(|batch| self.batch(batch)).collect()
    }

    fn batch(&self, frequencies: &[f64]) -> Vec<Option<Vec<Value>>> {
        let states = self.columns.len();
        let (mut re, mut im) = (
            Mat::<f64>::zeros(states, frequencies.len()),
            Mat::<f64>::zeros(states, frequencies.len()),
        );
        let mut sizes = Vec::with_capacity(frequencies.len());
        for (column, &frequency) in frequencies.iter().enumerate() {
            let mut sizes_of = Sizes::default();
            let force = self.force(frequency);
            let known = self
                .sum
                .each_block(frequency.into(), |start, width, inverse, off| {
                    for a in 0..width {
                        let (mut y, mut rest, mut size) = (Complex::ZERO, 0.0, 0.0);
                        for b in 0..width {
                            let (force, terms) = force(start + b);
                            let entry = inverse[a * width + b];
                            y += entry * force;
                            rest += entry.norm() * self.residual[start + b];
                            size += entry.norm() * (off * force.norm() + terms);
                        }
                        (re[(start + a, column)], im[(start + a, column)]) = (y.re, y.im);
                        sizes_of.moved += self.columns[start + a] * y.norm();
                        sizes_of.left += self.columns[start + a] * rest;
                        sizes_of.lost += self.columns[start + a] * size;
                    }
                });
            sizes.push(known.map(|()| sizes_of));
        }
        let re = &self.rounded * re;
        let im = &self.rounded * im;
        let columns = frequencies.iter().zip(sizes).enumerate();
        columns
            .map(|(column, (&frequency, sizes))| {
                let read = |row: usize| Complex::new(re[(row, column)], im[(row, column)]);
                self.read(frequency, sizes?, read)
            })
            .collect()
    }

    /// What acts on each mode, and a bound of what sums in double-double lose of it.
    fn force(&self, frequency: f64) -> impl Fn(usize) -> (Complex<f64>, f64) + '_ {
        let powers: Vec<Complex<f64>> = self
            .inputs
            .iter()
            .map(|input| turn(frequency, input.power))
            .collect();
        let lost = self.lost();
        move |k| {
            let mut force = (Complex::ZERO, 0.0);
            for (input, power) in self.inputs.iter().zip(&powers) {
                force.0 += power * input.modal[k].high();
                force.1 += power.norm() * input.sizes[k] * lost;
            }
            force
        }
    }

    /// The relative error of sums in double-double over all coordinates.
    pub(super) fn lost(&self) -> f64 {
        (self.sum.coordinates() as f64 + 16.0) * DoubleDouble::unit().to_f64()
    }

    /// Values with bounds, from the products of the rows with what moves.
    fn read(
        &self,
        frequency: f64,
        Sizes { moved, left, lost }: Sizes,
        product: impl Fn(usize) -> Complex<f64>,
    ) -> Option<Vec<Value>> {
        let passed = self.passed.iter();
        let moved = passed.fold(moved, |sum, (power, size)| {
            sum + size * frequency.powi(*power)
        });
        if frequency != 0.0 && !Self::RANGE.contains(&frequency) {
            return None;
        }
        let [zeroth, first, second] = self.defects;
        let norm = zeroth + first * frequency + second * frequency * frequency + left;
        if norm.is_nan() || norm > 0.25 {
            return None;
        }
        /// Values with a larger relative bound are left to elimination, where more is known of them.
        const LARGEST: f64 = 1e-3;
        /// What the modes leave is of the size of rounding.
        const NEARLY_NOTHING: f64 = 1e-6;
        let rounding = self.rounding::<f64>();
        let off = (moved * (norm / (1.0 - norm) + rounding) + lost) * UPWARD;
        let mut values = vec![(Complex::ZERO, 0.0); self.count];
        for (row, &(index, power)) in self.rows.iter().enumerate() {
            values[index].0 += product(row) * turn(frequency, power);
        }
        for &(index, power, length) in &self.lengths {
            values[index].1 += length * off * frequency.powi(power);
        }
        for &(index, power, coefficient) in &self.direct {
            let coefficient = coefficient.high();
            values[index].0 += turn(frequency, power) * coefficient;
            values[index].1 += coefficient.abs() * frequency.powi(power) * rounding;
        }
        // Beyond all modes their sums cancel, each the more the less the whole moves.
        let cancels = frequency > self.fastest || norm > NEARLY_NOTHING;
        let good = values.iter().all(|(value, bound)| {
            let is_normal = frequency == 0.0 || *bound >= Self::SMALLEST;
            let is_known = *bound <= LARGEST * value.norm() || !cancels;
            value.is_finite() && bound.is_finite() && is_normal && is_known
        });
        good.then_some(values)
    }

    /// The relative error of sums over all modes in the precision of T.
    pub(super) fn rounding<T: Real>(&self) -> f64 {
        (self.columns.len() as f64 + 80.0) * 2.0 * T::unit().to_f64()
    }

    /// |H| and the derivative of its logarithm with respect to Ω, of the only output, without bounds.
    pub(super) fn glance(&self, frequency: f64) -> Option<(f64, f64)> {
        let powers = || {
            let inputs = self.inputs.iter();
            inputs.map(|input| (input.power, &input.modal))
        };
        let (mut value, mut change) = (Complex::<f64>::ZERO, Complex::<f64>::ZERO);
        let unit = Complex::<f64>::I;
        let sums: Vec<(Complex<f64>, Complex<f64>)> = self
            .rows
            .iter()
            .enumerate()
            .map(|(row, _)| {
                let (mut y, mut rate) = (Complex::<f64>::ZERO, Complex::<f64>::ZERO);
                let known = self
                    .sum
                    .each_block(frequency.into(), |start, width, inverse, _| {
                        let mut state = [Complex::<f64>::ZERO; 2];
                        let mut speed = [Complex::<f64>::ZERO; 2];
                        for b in 0..width {
                            let force: Complex<f64> = powers()
                                .map(|(power, modal)| {
                                    turn(frequency, power) * modal[start + b].high()
                                })
                                .sum();
                            let slope: Complex<f64> = powers()
                                .map(|(power, modal)| {
                                    turn(frequency, power - 1)
                                        * unit
                                        * f64::from(power)
                                        * modal[start + b].high()
                                })
                                .sum();
                            for a in 0..width {
                                state[a] += inverse[a * width + b] * force;
                                speed[a] += inverse[a * width + b] * slope;
                            }
                        }
                        for a in 0..width {
                            // The derivative of (s − Λ)⁻¹ is minus its square.
                            let back: Complex<f64> =
                                (0..width).map(|b| inverse[a * width + b] * state[b]).sum();
                            y += state[a] * self.rounded[(row, start + a)];
                            rate += (speed[a] - unit * back) * self.rounded[(row, start + a)];
                        }
                    });
                known.map(|()| (y, rate))
            })
            .collect::<Option<_>>()?;
        for (&(_, power), (y, rate)) in self.rows.iter().zip(sums) {
            value += turn(frequency, power) * y;
            change += turn(frequency, power) * rate
                + turn(frequency, power - 1) * unit * f64::from(power) * y;
        }
        for &(_, power, coefficient) in &self.direct {
            let coefficient = coefficient.high();
            value += turn(frequency, power) * coefficient;
            change += turn(frequency, power - 1) * unit * f64::from(power) * coefficient;
        }
        let ratio = (change / value).re;
        ratio.is_finite().then(|| (value.norm(), ratio))
    }
}

/// What is known of sizes at one frequency, in lengths of the coordinates: of what moves, of what the residual of the modes makes of
/// it, and of what is lost in blocks that are near to a root.
#[derive(Clone, Copy, Default)]
struct Sizes {
    moved: f64,
    left: f64,
    lost: f64,
}

/// In the precision of T, double-double at most.
pub(super) fn narrowed<T: Real>(value: DoubleDouble) -> T {
    T::from(value.high()) + T::from(value.low())
}

/// (iΩ)^power.
pub(super) fn turn(frequency: f64, power: i32) -> Complex<f64> {
    if power < 0 {
        return Complex::ZERO; // only ever times 0
    }
    Complex::new(0.0, frequency).powi(power)
}

impl ModalSum {
    /// Calls `visit` with start, width, and the inverse of each block of s − Λ by rows, and a bound of the relative error of
    /// that beside rounding; `None` where one is nearly singular.
    pub(super) fn each_block(
        &self,
        frequency: DoubleDouble,
        mut visit: impl FnMut(usize, usize, &[Complex<f64>; 4], f64),
    ) -> Option<()> {
        self.each_inverse::<f64>(frequency, |start, width, inverse, off| {
            let inverse = inverse
                .each_ref()
                .map(|entry| Complex::new(entry.re, entry.im));
            visit(start, width, &inverse, off);
        })
    }

    /// The same in the precision of T, double-double at most.
    pub(super) fn each_inverse<T: Real>(
        &self,
        frequency: DoubleDouble,
        mut visit: impl FnMut(usize, usize, &[WideComplex<T>; 4], f64),
    ) -> Option<()> {
        /// Nearer to a root there are no digits.
        const NEAREST: f64 = 1e-20;
        let square = frequency * frequency;
        let zero = WideComplex::<T>::ZERO;
        let inverted = |re: T, im: T| {
            let size = re * re + im * im;
            WideComplex {
                re: re / size,
                im: -im / size,
            }
        };
        for block in &self.blocks {
            match *block.generator.as_slice() {
                [a] => {
                    let (re, im) = (narrowed::<T>(-a), narrowed::<T>(frequency));
                    if re.to_f64().hypot(im.to_f64()) < f64::MIN_POSITIVE {
                        return None;
                    }
                    visit(block.start, 1, &[inverted(re, im), zero, zero, zero], 0.0);
                }
                [a, b, c, d] => {
                    let product = a * d - b * c;
                    let re = product - square;
                    let im = -((a + d) * frequency);
                    let size = (a * d).abs().to_f64() + (b * c).abs().to_f64() + square.to_f64();
                    let distance = re.to_f64().hypot(im.to_f64());
                    if distance <= size * NEAREST {
                        return None;
                    }
                    let inverse = inverted(narrowed(re), narrowed(im));
                    let minus = |entry: DoubleDouble| WideComplex {
                        re: narrowed::<T>(-entry),
                        im: narrowed::<T>(frequency),
                    };
                    let real = |entry: DoubleDouble| WideComplex {
                        re: narrowed::<T>(entry),
                        im: T::ZERO,
                    };
                    let entries = [minus(d), real(b), real(c), minus(a)];
                    let entries = entries.map(|entry| entry * inverse);
                    let off = 8.0 * DoubleDouble::unit().to_f64() * size / distance;
                    visit(block.start, 2, &entries, off);
                }
                _ => return None,
            }
        }
        Some(())
    }

    /// How slow and how fast the modes of each block are, in 1/s.
    pub(super) fn rates(&self) -> Vec<[f64; 2]> {
        let blocks = self.blocks.iter();
        let rates = blocks.map(|block| match *block.generator.as_slice() {
            [a] => [a.to_f64().abs(); 2],
            [a, b, c, d] => {
                let square = (a * d - b * c).to_f64().abs();
                let half = 0.5 * (a + d).to_f64().abs();
                match half * half > square {
                    true => {
                        let fast = half + (half * half - square).sqrt();
                        [square / fast, fast]
                    }
                    false => [square.sqrt(); 2],
                }
            }
            _ => [0.0; 2],
        });
        rates.collect()
    }

    /// Lengths for all frequencies: they have the units of the coordinates.
    fn common_lengths(&self) -> Option<Vec<f64>> {
        let n = self.coordinates();
        let largest = self
            .rates()
            .iter()
            .fold(0.0, |most, rate| rate[1].max(most));
        let rate = if largest > 0.0 { largest } else { 1.0 };
        // Above all of them no block is near to its resonance.
        let at = self.at_lengths(Frequency::from(rate * 1.618))?;
        let known = at.iter().all(|length| *length > 0.0 && length.is_finite());
        (known && at.len() == n).then_some(at)
    }
}
