//! Solutions of the dynamic equations by modes, proved by what the modes leave of them.
//!
//! Let columns of U and rows of W be shapes in double-double (see `modal_refinement`), with blocks Λ on the diagonal, so that
//! S(s) = U (s − Λ)⁻¹ W + D is nearly the inverse of Z(s) = K + sC + s²M. With the residual R = WK + ΛWC + Λ²WM of
//! the shapes, which is small, exactly
//!
//! I − S Z = [I − U(WC + ΛWM) − DK] − s [UWM + DC] − s² DM − U (s − Λ)⁻¹ R.
//!
//! The matrices in it are bounded once, by products in double-double. At each frequency they bound I − SZ in O(n²).

use std::sync::OnceLock;

use eigentone_digits::{Ball, ComplexDoubleDouble, DoubleDouble, Real, Wide, WideComplex};
use eigentone_modes::{MatrixKind, Precision, System};
use faer::Mat;
use num_complex::Complex;

use super::columns::Columns;
use super::dynamic_stiffness::{DynamicStiffness, Frequency};
use super::modal_refinement::{Block, Rows, corrected_shapes, corrected_weights};
use super::refinement::{ApproximateInverse, FLOOR, UPWARD, largest};
use crate::march::Basis;

/// (s − Λ)⁻¹ of a block by rows, and bounds of the sizes of its entries.
type Inverse = ([Complex<f64>; 4], [f64; 4]);

/// Modes as an approximate inverse at every frequency.
#[derive(Debug)]
pub(super) struct ModalSum {
    /// U, by columns.
    pub(super) shapes: Rows,
    /// W, by rows.
    pub(super) weights: Rows,
    /// D.
    pub(super) direct: Option<Mat<f64>>,
    pub(super) blocks: Vec<Block>,
    /// Bounds of the three matrices of I − SZ, by powers of s.
    pub(super) defects: [Mat<f64>; 3],
    /// A bound of |R|.
    pub(super) residual: Mat<f64>,
    /// |U|, |Wᵀ|, |D|.
    pub(super) sizes: (Mat<f64>, Mat<f64>, Option<Mat<f64>>),
    stiffness: DynamicStiffness,
    matrices: Matrices<DoubleDouble>,
    wide_matrices: OnceLock<Matrices<Wide<4>>>,
}

/// K, C and M.
pub(super) type Matrices<T> = [Columns<T>; 3];

/// Row, column, and the parts of K, C and M.
type Entry<T> = (usize, usize, [Ball<T>; 3]);

/// What the sum is at one frequency, and the equations there in the precision of T.
pub(super) struct At<'a, T> {
    sum: &'a ModalSum,
    /// By block.
    inverses: Vec<Inverse>,
    matrices: &'a Matrices<T>,
    /// s and its square.
    powers: [Ball<T>; 2],
    /// Their derivatives with respect to Ω.
    rates: [Ball<T>; 2],
    /// Lengths in which F is small, one for each coordinate.
    lengths: Vec<f64>,
    /// The norm of F in them.
    norm: f64,
}

impl ModalSum {
    /// `None` where modes do not span the motion, or too badly.
    pub(super) fn of(system: &System, stiffness: DynamicStiffness) -> Option<ModalSum> {
        let basis = Basis::of(system, Precision::Double).ok()?;
        let n = system.len();
        let shapes = eigentone_digits::product(basis.form.x(), basis.t.as_ref());
        let weights = eigentone_digits::product(basis.inverse.as_ref(), basis.form.b());
        let direct = basis.form.d().map(|direct| direct.to_owned());
        let mut blocks = Vec::new();
        let mut start = 0;
        for block in &basis.blocks {
            blocks.push(Block {
                start,
                generator: block.generator().to_vec(),
            });
            start += block.width;
        }
        let states = start;
        let entries = stiffness.balls();
        let turned = entries
            .iter()
            .map(|&(row, column, parts)| (column, row, parts));
        let transposed = matrices(n, &turned.collect::<Vec<_>>());
        let times = |left: &Rows, order: usize| from_left(left, &transposed[order]);
        let d = direct.as_ref().map(rows);
        let with = |product: Rows, order: usize| match &d {
            Some(direct) => plus(product, &times(direct, order)),
            None => product,
        };
        // W, ΛW and Λ²W times K, C and M.
        let left = |w: &Rows, blocks: &[Block]| {
            let once = by_blocks(blocks, w);
            let twice = by_blocks(blocks, &once);
            let sum = plus(times(w, 0), &times(&once, 1));
            (plus(sum, &times(&twice, 2)), once)
        };
        let (mut u, mut w) = (rows(&shapes), rows(&weights));
        let (residual, _) = left(&w, &blocks);
        corrected_weights(&mut w, &mut blocks, &shapes, direct.as_ref(), &residual);
        let (residual, once) = left(&w, &blocks);
        let inner = [plus(times(&w, 1), &times(&once, 2)), times(&w, 2)];
        // What is left of 1 and 0 (see above), by powers of s.
        let defects = |u: &Rows| {
            let mut zeroth = with(product(u, &inner[0], n), 0);
            for (i, row) in zeroth.iter_mut().enumerate() {
                row[i] -= DoubleDouble::from(1.0);
            }
            let none = vec![vec![DoubleDouble::ZERO; n]; n];
            [zeroth, with(product(u, &inner[1], n), 1), with(none, 2)]
        };
        let [zeroth, first, _] = defects(&u);
        corrected_shapes(&mut u, &blocks, [&zeroth, &first]);
        let defects = defects(&u);
        let (u_size, w_size) = (size(&u, states), size(&w, n));
        let d_size = direct.as_ref().map(abs);
        let kinds = [MatrixKind::Stiffness, MatrixKind::Damping, MatrixKind::Mass];
        let [k_size, c_size, m_size] = kinds.map(|kind| {
            let mut size = Mat::<f64>::zeros(n, n);
            for term in system.terms(kind) {
                size[(term.row, term.column)] += term.value.abs();
            }
            size
        });
        let turned = |of: &Mat<f64>| {
            let mut product = Mat::<f64>::zeros(states, n);
            for Block { start, generator } in &blocks {
                let width = generator.len().isqrt();
                for j in 0..n {
                    for i in 0..width {
                        let terms = (0..width)
                            .map(|l| generator[i * width + l].to_f64().abs() * of[(start + l, j)]);
                        product[(start + i, j)] = terms.sum();
                    }
                }
            }
            product
        };
        let once_size = turned(&w_size);
        let twice_size = turned(&once_size);
        let size_with = |product: Mat<f64>, size: &Mat<f64>| match &d_size {
            Some(direct) => product + direct * size,
            None => product,
        };
        // Sums of products of up to four factors (Higham 2002, section 3.5).
        let unit = DoubleDouble::unit().to_f64();
        let lost = (states as f64 + 2.0 * n as f64 + 64.0) * unit * 4.0;
        let bound = |value: &Rows, size: Mat<f64>| {
            Mat::from_fn(value.len(), n, |i, j| {
                (value[i][j].to_f64().abs() + lost * size[(i, j)]) * UPWARD + FLOOR
            })
        };
        let inner = &w_size * &c_size + &once_size * &m_size;
        let zeroth_size = size_with(&u_size * inner, &k_size) + Mat::<f64>::identity(n, n);
        let first_size = size_with(&u_size * (&w_size * &m_size), &c_size);
        let second_size = size_with(Mat::zeros(n, n), &m_size);
        let [zeroth, first, second] = &defects;
        let defects = [
            bound(zeroth, zeroth_size),
            bound(first, first_size),
            bound(second, second_size),
        ];
        let residual = bound(
            &residual,
            &w_size * &k_size + &once_size * &c_size + &twice_size * &m_size,
        );
        let is_finite = |matrix: &Mat<f64>| {
            (0..matrix.ncols()).all(|j| (0..matrix.nrows()).all(|i| matrix[(i, j)].is_finite()))
        };
        let finite = defects.iter().all(is_finite) && is_finite(&residual);
        let column = |k: usize| u.iter().map(|row| row[k]).collect();
        finite.then(|| ModalSum {
            matrices: matrices(n, &entries),
            wide_matrices: OnceLock::new(),
            stiffness,
            shapes: (0..states).map(column).collect(),
            weights: w,
            direct,
            blocks,
            defects,
            residual,
            sizes: (u_size, w_size.transpose().to_owned(), d_size),
        })
    }

    /// How many coordinates there are.
    pub(super) fn coordinates(&self) -> usize {
        self.defects[0].nrows()
    }

    /// K, C and M in double-double.
    pub(super) fn matrices(&self) -> &Matrices<DoubleDouble> {
        &self.matrices
    }

    /// The same in more digits.
    pub(super) fn wide_matrices(&self) -> &Matrices<Wide<4>> {
        let wide = || matrices(self.coordinates(), &self.stiffness.balls());
        self.wide_matrices.get_or_init(wide)
    }

    /// At a frequency, with K, C and M; `None` where the modes do not prove that Z is regular.
    pub(super) fn at<'a, T: Real>(
        &'a self,
        frequency: Frequency,
        matrices: &'a Matrices<T>,
    ) -> Option<At<'a, T>> {
        let n = self.coordinates();
        let s = frequency.power::<DoubleDouble>(1);
        let inverses = self.inverses(s)?;
        let lengths = self.lengths(&inverses);
        let top = s.upper().to_f64() * UPWARD;
        let mut moved = vec![0.0; n];
        for (order, defect) in self.defects.iter().enumerate() {
            let factor = top.powi(order as i32) * UPWARD;
            let lengths = lengths.iter().map(|length| length * factor);
            add_product(&mut moved, defect, lengths);
        }
        let mut left = vec![0.0; self.residual.nrows()];
        add_product(&mut left, &self.residual, lengths.iter().copied());
        self.spread(&inverses, &left, &mut moved);
        let ratios = moved
            .iter()
            .zip(&lengths)
            .map(|(moved, length)| moved / length);
        let norm = largest(ratios) * UPWARD;
        if norm.is_nan() || norm >= 0.5 {
            return None;
        }
        Some(At {
            sum: self,
            inverses,
            matrices,
            powers: [1, 2].map(|order| frequency.power(order)),
            rates: super::dynamic_stiffness::slopes(frequency),
            lengths,
            norm,
        })
    }

    fn inverses(&self, s: Ball<DoubleDouble>) -> Option<Vec<Inverse>> {
        self.blocks.iter().map(|block| block.inverse(s)).collect()
    }

    /// Lengths that fit one frequency.
    pub(super) fn at_lengths(&self, frequency: Frequency) -> Option<Vec<f64>> {
        Some(self.lengths(&self.inverses(frequency.power(1))?))
    }

    /// The square roots of what the diagonal of S is at most: they have the units of the coordinates.
    fn lengths(&self, inverses: &[Inverse]) -> Vec<f64> {
        let n = self.coordinates();
        let (shapes, weights, direct) = &self.sizes;
        let mut squares: Vec<f64> = (0..n)
            .map(|i| direct.as_ref().map_or(0.0, |direct| direct[(i, i)]))
            .collect();
        for (block, (_, size)) in self.blocks.iter().zip(inverses) {
            let width = block.width();
            for (at, size) in size.iter().enumerate().take(width * width) {
                let left = shapes.col_as_slice(block.start + at / width);
                let right = weights.col_as_slice(block.start + at % width);
                for ((square, left), right) in squares.iter_mut().zip(left).zip(right) {
                    *square += left * size * right;
                }
            }
        }
        squares.into_iter().map(f64::sqrt).collect()
    }

    /// sum += |U||(s − Λ)⁻¹| left.
    fn spread(&self, inverses: &[Inverse], left: &[f64], sum: &mut [f64]) {
        for (block, (_, size)) in self.blocks.iter().zip(inverses) {
            let width = block.width();
            for a in 0..width {
                let terms = (0..width).map(|b| size[a * width + b] * left[block.start + b]);
                let total: f64 = terms.sum();
                let column = self.sizes.0.col_as_slice(block.start + a);
                for (sum, size) in sum.iter_mut().zip(column) {
                    *sum += size * total;
                }
            }
        }
    }
}

impl Block {
    fn inverse(&self, s: Ball<DoubleDouble>) -> Option<Inverse> {
        let real = |value: DoubleDouble| {
            Ball::from(WideComplex {
                re: value,
                im: DoubleDouble::ZERO,
            })
        };
        let one = real(DoubleDouble::from(1.0));
        let entries = match *self.generator.as_slice() {
            [a] => vec![one.checked_div(s - real(a))?],
            [a, b, c, d] => {
                let [a, b, c, d] = [a, b, c, d].map(real);
                let determinant = (s - a) * (s - d) - b * c;
                let entries = [s - d, b, c, s - a].map(|entry| entry.checked_div(determinant));
                entries.into_iter().collect::<Option<_>>()?
            }
            _ => return None,
        };
        let mut inverse = ([Complex::ZERO; 4], [0.0; 4]);
        for (at, entry) in entries.into_iter().enumerate() {
            let WideComplex { re, im } = entry.middle();
            inverse.0[at] = Complex::new(re.to_f64(), im.to_f64());
            inverse.1[at] = entry.upper().to_f64() * UPWARD;
            if !inverse.1[at].is_finite() {
                return None;
            }
        }
        Some(inverse)
    }
}

impl<T: Real> At<'_, T> {
    /// Z′x.
    pub(super) fn slope(&self, x: &[Ball<T>]) -> Vec<Ball<T>> {
        let mut sum = vec![Ball::ZERO; x.len()];
        self.add(&mut sum, x, self.rates);
        sum
    }

    /// Adds C x and M x times these factors.
    fn add(&self, sum: &mut [Ball<T>], x: &[Ball<T>], factors: [Ball<T>; 2]) {
        let rates = self.matrices[1..].iter().zip(factors);
        for (matrix, factor) in rates.filter(|(matrix, _)| !matrix.is_zero()) {
            for (sum, part) in sum.iter_mut().zip(matrix.times(x)) {
                *sum = *sum + part * factor;
            }
        }
    }
}

impl<T: Real> ApproximateInverse<T> for At<'_, T> {
    fn apply(&self, right: &[Complex<f64>]) -> Vec<ComplexDoubleDouble> {
        let sum = self.sum;
        let acting: Vec<(usize, Complex<f64>)> = right.iter().copied().enumerate().collect();
        let acting = acting.iter().filter(|(_, value)| *value != Complex::ZERO);
        let modal = sum.weights.iter().map(|weights| {
            let terms = acting.clone().map(|&(j, value)| value * weights[j].high());
            terms.sum::<Complex<f64>>()
        });
        let modal: Vec<Complex<f64>> = modal.collect();
        let mut terms: [Vec<(DoubleDouble, &[DoubleDouble])>; 2] = Default::default();
        for (block, (inverse, _)) in sum.blocks.iter().zip(&self.inverses) {
            let width = block.width();
            for a in 0..width {
                let parts = (0..width).map(|b| inverse[a * width + b] * modal[block.start + b]);
                let Complex { re, im } = parts.sum::<Complex<f64>>();
                for (terms, part) in terms.iter_mut().zip([re, im]) {
                    terms.push((part.into(), &sum.shapes[block.start + a][..]));
                }
            }
        }
        let [re, im] = terms.map(|terms| {
            let mut part = vec![DoubleDouble::ZERO; right.len()];
            let moving = terms.into_iter().filter(|(factor, _)| !factor.is_zero());
            DoubleDouble::add_multiples(&mut part, &moving.collect::<Vec<_>>());
            part
        });
        let parts = re.into_iter().zip(im);
        let mut x: Vec<ComplexDoubleDouble> =
            parts.map(|(re, im)| WideComplex { re, im }).collect();
        if let Some(direct) = &sum.direct {
            for &(j, value) in acting {
                for (i, x) in x.iter_mut().enumerate() {
                    x.re += DoubleDouble::product(value.re, direct[(i, j)]);
                    x.im += DoubleDouble::product(value.im, direct[(i, j)]);
                }
            }
        }
        x
    }

    fn sizes(&self, right: &[f64]) -> Vec<f64> {
        let (_, weights, direct) = &self.sum.sizes;
        let modal = (0..weights.ncols()).map(|k| {
            let terms = weights.col_as_slice(k).iter().zip(right);
            terms.map(|(weight, value)| weight * value).sum()
        });
        let modal: Vec<f64> = modal.collect();
        let mut x = vec![0.0; right.len()];
        if let Some(direct) = direct {
            add_product(&mut x, direct, right.iter().copied());
        }
        self.sum.spread(&self.inverses, &modal, &mut x);
        x.iter().map(|size| size * UPWARD).collect()
    }

    fn times(&self, x: &[Ball<T>]) -> Vec<Ball<T>> {
        let mut sum = self.matrices[0].times(x);
        self.add(&mut sum, x, self.powers);
        sum
    }

    fn defect(&self) -> (&[f64], f64) {
        (&self.lengths, self.norm)
    }
}

/// sum += matrix · x.
fn add_product(sum: &mut [f64], matrix: &Mat<f64>, x: impl Iterator<Item = f64>) {
    for (j, x) in x.enumerate() {
        let column = matrix.col_as_slice(j).iter();
        sum.iter_mut()
            .zip(column)
            .for_each(|(sum, entry)| *sum += entry * x);
    }
}

fn matrices<T: Real>(n: usize, entries: &[Entry<T>]) -> Matrices<T> {
    [0, 1, 2].map(|kind| {
        let own = entries.iter();
        Columns::of(
            n,
            own.map(|(row, column, parts)| (*row, *column, parts[kind])),
        )
    })
}

fn rows(matrix: &Mat<f64>) -> Rows {
    let row = |i: usize| (0..matrix.ncols()).map(move |j| matrix[(i, j)].into());
    (0..matrix.nrows()).map(|i| row(i).collect()).collect()
}

fn plus(mut sum: Rows, other: &Rows) -> Rows {
    for (sum, other) in sum.iter_mut().flatten().zip(other.iter().flatten()) {
        *sum += *other;
    }
    sum
}

/// Left times right, of which rows have this width: without states it has no row, and the product is 0.
fn product(left: &Rows, right: &Rows, width: usize) -> Rows {
    let row = |left: &Vec<DoubleDouble>| {
        let mut row = vec![DoubleDouble::ZERO; width];
        let terms = left.iter().zip(right);
        let terms = terms.filter(|(factor, _)| !factor.is_zero());
        let terms: Vec<_> = terms.map(|(factor, right)| (*factor, &right[..])).collect();
        DoubleDouble::add_multiples(&mut row, &terms);
        row
    };
    left.iter().map(row).collect()
}

/// Λ times a matrix.
fn by_blocks(blocks: &[Block], of: &Rows) -> Rows {
    let mut product = of.clone();
    for block in blocks {
        let width = block.width();
        for i in 0..width {
            let mut row = vec![DoubleDouble::ZERO; of[block.start].len()];
            for l in 0..width {
                let factor = block.generator[i * width + l];
                DoubleDouble::add_multiple(&mut row, factor, &of[block.start + l]);
            }
            product[block.start + i] = row;
        }
    }
    product
}

/// `left` times a matrix, of which this is the transpose.
fn from_left(left: &Rows, transposed: &Columns<DoubleDouble>) -> Rows {
    let ball = |re: &DoubleDouble| {
        Ball::from(WideComplex {
            re: *re,
            im: DoubleDouble::ZERO,
        })
    };
    let row = |left: &Vec<DoubleDouble>| {
        let product = transposed.times(&left.iter().map(ball).collect::<Vec<_>>());
        product.into_iter().map(|entry| entry.middle().re).collect()
    };
    left.iter().map(row).collect()
}

fn size(rows: &Rows, width: usize) -> Mat<f64> {
    Mat::from_fn(rows.len(), width, |i, j| rows[i][j].to_f64().abs() * UPWARD)
}

fn abs(matrix: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)].abs())
}

#[cfg(test)]
mod tests {
    use super::super::dynamic_stiffness::Part;
    use super::super::enclosure::{Asked, Enclosed, Question, Value, enclose};
    use super::super::modal_functions::ModalFunctions;
    use super::super::phasor::Phase;
    use super::super::ports::{Push, Reading};
    use super::*;
    use eigentone_modes::{Beam, BeamEnd, GROUND};

    /// All ways enclose the same numbers, and modes answer all of the frequencies given. How many their series answer to the last
    /// digit.
    fn assert_agreement(system: &System, frequencies: &[f64]) -> usize {
        let stiffness = DynamicStiffness::of(system, &[]);
        let parts: Vec<usize> = stiffness.reached(0..system.len());
        let block = stiffness.block(&parts);
        let sum = ModalSum::of(system, stiffness).expect("modes");
        let push = [Push {
            coordinate: 1,
            part: Part::of(0, [1.0; 2]),
            phase: Phase::Zero,
        }];
        let readings: Vec<Reading> = (0..system.len())
            .map(|i| Reading {
                of: vec![(i, Part::of(1, [1.0; 2]))],
                more: Vec::new(),
            })
            .collect();
        let series = ModalFunctions::of(&sum, &push, &readings).expect("lengths");
        let mut answered = 0;
        for &frequency in frequencies {
            let at = sum.at(frequency.into(), sum.matrices());
            assert!(at.is_some(), "{frequency}");
            let [by_modes, by_elimination] = [Some(&sum), None].map(|modes| {
                let found = enclose(&Question {
                    block: &block,
                    modes,
                    modal: &[],
                    frequency: frequency.into(),
                    columns: &[(&push, &readings)],
                    asked: Asked::Steepness,
                });
                match found {
                    Enclosed::Values(values, _) => values,
                    other => panic!("{other:?}"),
                }
            });
            for (a, b) in by_modes[0].iter().zip(&by_elimination[0]) {
                let off = (a.value - b.value).norm();
                assert!(off <= a.bound + b.bound, "{frequency}: {a:?} {b:?}");
                let size = a.value.norm();
                assert!(a.bound <= 2.0 * f64::EPSILON * size, "{frequency}: {a:?}");
                let [(a, a_off), (b, b_off)] = [a, b].map(|value| value.steepness.expect("known"));
                assert!((a - b).abs() <= a_off + b_off, "{frequency}: {a} {b}");
                assert!(a_off <= 1e-9 * a.abs(), "{frequency}: {a} ± {a_off:e}");
            }
            // At the frequency, and throughout a range with it.
            let range = Frequency {
                middle: (frequency * (1.0 + 0.7e-9)).into(),
                radius: 1e-9 * frequency,
                scale: 0,
            };
            for asked in [frequency.into(), range] {
                let values = series.enclosed(asked);
                answered += usize::from(values.is_some());
                let all = values.into_iter().flatten().zip(&by_elimination[0]);
                for ([sum, change], truth) in all {
                    let known = Value::of(sum, Some(change));
                    let off = (known.value - truth.value).norm();
                    let most = known.bound + truth.bound;
                    assert!(off <= most, "{asked:?}: {known:?} {truth:?}");
                    if let (Some((a, a_off)), Some((b, b_off))) = (known.steepness, truth.steepness)
                    {
                        assert!((a - b).abs() <= a_off + b_off, "{asked:?}: {a} {b}");
                    }
                }
            }
        }
        answered
    }

    /// At the doubles nearest to the roots of given matrices; those of a free beam have two rigid motions that rounding moves.
    #[test]
    fn modes_of_finite_elements_have_digits_beside_poles() {
        for (end, damping) in [(BeamEnd::Free, 0.0), (BeamEnd::Clamped, 1e-9)] {
            let beam = System::builder().beam(Beam {
                name: "rod".to_owned(),
                length: 2.0,
                elements: 12,
                flexural_rigidity: 1500.0,
                mass_per_length: 3.1,
                ends: [end, BeamEnd::Free],
                lumped: false,
            });
            let beam = beam.build().expect("a beam");
            let n = beam.len();
            let [m, k] = [beam.mass_matrix(), beam.stiffness_matrix()];
            let mut c = Mat::<f64>::zeros(n, n);
            c[(n - 1, n - 1)] = damping;
            let beam = System::from_matrices(m.as_ref(), c.as_ref(), k.as_ref());
            let beam = beam.expect("a system");
            let modes = beam.modes().expect("modes");
            let roots = modes.eigenvalues().iter();
            let poles = roots.map(|root| root.value.im).filter(|im| *im > 1.0);
            let poles: Vec<f64> = poles.collect();
            assert_eq!(poles.len(), 24);
            assert_eq!(assert_agreement(&beam, &poles), 24);
        }
    }

    #[test]
    fn modes_and_elimination_enclose_the_same() {
        let mut builder = System::builder();
        for i in 0..12 {
            builder = builder.mass(format!("m{i}"), 1.0 + 0.3 * f64::from(i));
        }
        builder = builder.mass("node", 0.0);
        for i in 0..11 {
            builder = builder.spring(format!("m{i}"), format!("m{}", i + 1), 100.0 + f64::from(i));
            builder = builder.damper(format!("m{i}"), format!("m{}", (i + 5) % 12), 0.1);
        }
        let system = builder
            .spring(GROUND, "m0", 7.0)
            .spring("m3", "node", 5.0)
            .spring("node", "m5", 9.0)
            .build()
            .expect("a system");
        assert_eq!(
            assert_agreement(&system, &[1e-3, 0.4, 1.0, 7.3, 20.0, 1e3]),
            12
        );
        let beam = System::builder()
            .beam(Beam {
                name: "mast".to_owned(),
                length: 2.0,
                elements: 20,
                flexural_rigidity: 1500.0,
                mass_per_length: 3.1,
                ends: [BeamEnd::Clamped, BeamEnd::Free],
                lumped: false,
            })
            .damper(GROUND, "mast.20.w", 3.0)
            .build()
            .expect("a beam");
        assert_eq!(
            assert_agreement(&beam, &[0.5, 19.0, 19.3, 120.0, 5000.0]),
            10
        );
    }
}
