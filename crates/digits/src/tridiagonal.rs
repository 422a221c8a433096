//! Eigenvalues and eigenvectors of symmetric tridiagonal matrices by divide and conquer: J. J. M. Cuppen, *A divide and conquer
//! method for the symmetric tridiagonal eigenproblem*, Numer. Math. 36 (1981), with the vectors of M. Gu and S. C. Eisenstat,
//! *A divide-and-conquer algorithm for the symmetric tridiagonal eigenproblem*, SIAM J. Matrix Anal. Appl. 16 (1995), which
//! are orthogonal however close the eigenvalues are.
//!
//! T is two smaller such matrices and ρ v vᵀ, ‖v‖ = 1. In the eigenvectors of both this is D + ρ z zᵀ, whose eigenvalues are the
//! roots of 1/ρ + Σ zᵢ²/(dᵢ − λ), and whose vectors have the entries zᵢ/(dᵢ − λ). Products of matrices take 4/3 n³ operations
//! at most, and fewer the more entries of z are nothing beside the rounding of T.

use std::array::from_fn;

use faer::diag::Diag;
use faer::dyn_stack::MemStack;
use faer::linalg::evd::{self, ComputeEigenvectors};
use faer::linalg::matmul::matmul;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, Col, ColRef, Mat, MatMut, Par};
use pulp::{Arch, Simd, WithSimd};

use crate::symmetric_eigen::implicit_steps;
use crate::{settle, sort_by_number, workspace};

/// Up to so many rows implicit QR steps take as long.
pub(crate) const LEAF: usize = 32;

/// All eigenvalues, rising, with their vectors, column by column, of the matrix with this diagonal and these entries below it;
/// up to `leaf` rows, at least one, are left to implicit QR steps. `None` where an entry is not finite or these do not converge.
pub(crate) fn eigen(diagonal: &[f64], below: &[f64], leaf: usize) -> Option<(Vec<f64>, Mat<f64>)> {
    let n = diagonal.len();
    if n == 0 {
        return Some((Vec::new(), Mat::zeros(0, 0)));
    }
    let (unit, [mut values, below]) = scaled([diagonal, below])?;
    let mut vectors = Mat::<f64>::zeros(n, n);
    divide(
        &mut values,
        &below,
        vectors.as_mut(),
        &mut Room::of(n, leaf),
    )?;
    let mut order: Vec<usize> = (0..n).collect();
    sort_by_number(&mut order, |j| values[*j]);
    let mut sorted = Mat::zeros(n, n);
    for (at, j) in order.iter().enumerate() {
        sorted.col_mut(at).copy_from(vectors.col(*j));
    }
    Some((order.iter().map(|j| values[*j] * unit).collect(), sorted))
}

/// The eigenvalues alone, rising, by implicit QR steps; `None` as for [`eigen`].
pub(crate) fn eigenvalues(diagonal: &[f64], below: &[f64]) -> Option<Vec<f64>> {
    let (unit, [mut values, below]) = scaled([diagonal, below])?;
    if values.len() > 1 {
        by_qr_steps(&mut values, &below, None)?;
    }
    values.iter_mut().for_each(|value| *value *= unit);
    values.sort_unstable_by(f64::total_cmp);
    Some(values)
}

/// All entries in a unit in which squares stay within the range of doubles; `None` where one is not finite.
fn scaled(parts: [&[f64]; 2]) -> Option<(f64, [Vec<f64>; 2])> {
    let entries = || parts.into_iter().flatten();
    if entries().any(|entry| !entry.is_finite()) {
        return None;
    }
    let unit = match entries().fold(0.0, |most: f64, entry| most.max(entry.abs())) {
        0.0 => 1.0,
        largest => largest.log2().floor().exp2(),
    };
    let scaled = parts.map(|part| part.iter().map(|entry| entry / unit).collect());
    Some((unit, scaled))
}

/// What all levels compute in.
struct Room {
    /// The upper and the lower rows of the vectors that take part.
    halves: [Mat<f64>; 2],
    /// The vectors of D + ρ z zᵀ.
    amplitudes: Mat<f64>,
    leaf: usize,
}

impl Room {
    fn of(n: usize, leaf: usize) -> Room {
        let columns = if n > leaf { n } else { 0 };
        // Whole registers: see `even`.
        let half = || Mat::zeros(n.div_ceil(2).next_multiple_of(8), columns);
        Room {
            halves: [half(), half()],
            amplitudes: Mat::zeros(columns, columns),
            leaf,
        }
    }
}

/// Puts the eigenvalues, in any order, in the place of the diagonal, and their vectors where all is 0.
fn divide(
    diagonal: &mut [f64],
    below: &[f64],
    mut vectors: MatMut<'_, f64>,
    room: &mut Room,
) -> Option<()> {
    let n = diagonal.len();
    if n <= room.leaf {
        return by_qr_steps(diagonal, below, Some(vectors));
    }
    let half = n / 2;
    let joint = below[half - 1];
    diagonal[half - 1] -= joint.abs();
    diagonal[half] -= joint.abs();
    let (upper, lower) = diagonal.split_at_mut(half);
    let (corner, _, _, rest) = vectors.rb_mut().split_at_mut(half, half);
    divide(upper, &below[..half - 1], corner, room)?;
    divide(lower, &below[half..], rest, room)?;
    conquer(diagonal, joint, vectors, room);
    Some(())
}

/// The same by implicit QR steps (Golub & Van Loan, *Matrix Computations*, §8.3), with vectors or without.
fn by_qr_steps(
    diagonal: &mut [f64],
    below: &[f64],
    vectors: Option<MatMut<'_, f64>>,
) -> Option<()> {
    let n = diagonal.len();
    let mut offset = Diag::<f64>::zeros(n);
    below.iter().enumerate().for_each(|(i, x)| offset[i] = *x);
    let mut values = Diag::<f64>::zeros(n);
    let params = implicit_steps();
    // That of a whole matrix is larger than that of this part of it.
    let yes = ComputeEigenvectors::Yes;
    let scratch = evd::self_adjoint_evd_scratch::<f64>(n, yes, Par::Seq, params);
    evd::tridiagonal_self_adjoint_evd(
        ColRef::from_slice(diagonal).as_diagonal(),
        offset.as_ref(),
        values.as_mut(),
        vectors,
        Par::Seq,
        MemStack::new(&mut workspace(scratch)),
        params,
    )
    .ok()?;
    settle();
    diagonal.copy_from_slice(values.column_vector().try_as_col_major()?.as_slice());
    Some(())
}

/// Which rows of a column may differ from 0.
#[derive(Clone, Copy, PartialEq)]
enum Rows {
    Upper,
    All,
    Lower,
}

/// Makes the eigenvalues and vectors of both halves those of the whole.
fn conquer(values: &mut [f64], joint: f64, mut vectors: MatMut<'_, f64>, room: &mut Room) {
    let n = values.len();
    let half = n / 2;
    // v is 1/√2 in the last place of the upper half, and ±1/√2 in the first of the lower one.
    let rho = 2.0 * joint.abs();
    let share = 0.5f64.sqrt();
    let mut z: Vec<f64> = (0..half).map(|j| share * vectors[(half - 1, j)]).collect();
    z.extend((half..n).map(|j| share.copysign(joint) * vectors[(half, j)]));
    let mut rows = vec![Rows::Upper; half];
    rows.resize(n, Rows::Lower);
    let (kept, done) = deflate(values, &mut z, rho, &mut rows, vectors.rb_mut());
    if kept.is_empty() {
        return;
    }
    let count = kept.len();
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|k| rows[kept[*k]] as u8);
    let of = |wanted: Rows| kept.iter().filter(|j| rows[**j] == wanted).count();
    let (lower, upper) = (of(Rows::Upper), count - of(Rows::Lower));
    let pick = |from: &[f64]| -> Vec<f64> { kept.iter().map(|j| from[*j]).collect() };
    let roots = Secular {
        d: pick(values),
        squares: pick(&z).iter().map(|z| z * z).collect(),
        rho,
    }
    .solve(&pick(&z), &order, &mut room.amplitudes);
    let before = vectors.rb();
    let copied = |j: &usize| (values[*j], before.col(*j).to_owned());
    let finished: Vec<(f64, Col<f64>)> = done.iter().map(copied).collect();
    // Rows, and the places of the amplitudes that they are multiplied with.
    let parts = [(0..half, 0..upper), (half..n, lower..count)];
    for (kept_rows, (rows, places)) in room.halves.iter_mut().zip(&parts) {
        for (to, k) in order[places.clone()].iter().enumerate() {
            let from = before.col(kept[*k]).subrows(rows.start, rows.len());
            kept_rows
                .col_mut(to)
                .subrows_mut(0, rows.len())
                .copy_from(from);
        }
    }
    for (kept_rows, (rows, places)) in room.halves.iter().zip(parts) {
        let amplitudes = room
            .amplitudes
            .submatrix(places.start, 0, places.len(), count);
        matmul(
            vectors
                .rb_mut()
                .submatrix_mut(rows.start, 0, rows.len(), count),
            Accum::Replace,
            kept_rows.submatrix(0, 0, rows.len(), places.len()),
            amplitudes,
            1.0,
            Par::Seq,
        );
    }
    settle();
    values[..count].copy_from_slice(&roots);
    for (at, (value, column)) in (count..).zip(finished) {
        values[at] = value;
        vectors.rb_mut().col_mut(at).copy_from(&column);
    }
}

/// The columns that take part, by rising d, and those that are eigenvectors already: where zᵢ is nothing beside the rounding of the
/// matrix, or a rotation of two columns whose dᵢ nearly agree makes it so (Gu & Eisenstat, §3).
fn deflate(
    d: &mut [f64],
    z: &mut [f64],
    rho: f64,
    rows: &mut [Rows],
    mut vectors: MatMut<'_, f64>,
) -> (Vec<usize>, Vec<usize>) {
    let n = d.len();
    let most = |x: &[f64]| x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let tolerance = 4.0 * f64::EPSILON * most(d).max(rho * most(z));
    let mut order: Vec<usize> = (0..n).collect();
    sort_by_number(&mut order, |j| d[*j]);
    let (mut kept, mut done) = (Vec::with_capacity(n), Vec::new());
    let mut last: Option<usize> = None;
    for at in order {
        if rho * z[at].abs() <= tolerance {
            done.push(at);
            continue;
        }
        if let Some(before) = last {
            let length = z[at].hypot(z[before]);
            let (c, s) = (z[at] / length, z[before] / length);
            let (low, high) = (d[before], d[at]);
            if (high - low) * (c * s).abs() <= tolerance {
                (z[before], z[at]) = (0.0, length);
                for i in 0..n {
                    let (x, y) = (vectors[(i, before)], vectors[(i, at)]);
                    vectors[(i, before)] = c * x - s * y;
                    vectors[(i, at)] = s * x + c * y;
                }
                if rows[at] != rows[before] {
                    rows[at] = Rows::All;
                }
                d[before] = low * c * c + high * s * s;
                d[at] = low * s * s + high * c * c;
                done.push(before);
            } else {
                kept.push(before);
            }
        }
        last = Some(at);
    }
    kept.extend(last);
    (kept, done)
}

/// D + ρ z zᵀ with rising d that differ, and the squares of z.
struct Secular {
    d: Vec<f64>,
    squares: Vec<f64>,
    rho: f64,
}

/// What is to be solved, in code for the registers that the processor has.
struct Solve<'a> {
    secular: &'a Secular,
    z: &'a [f64],
    order: &'a [usize],
    vectors: &'a mut Mat<f64>,
}

impl WithSimd for Solve<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<f64> {
        self.secular.solve_with(self.z, self.order, self.vectors)
    }
}

impl Secular {
    /// Its eigenvalues, and its vectors, column by column, with their entries in the given order.
    fn solve(&self, z: &[f64], order: &[usize], vectors: &mut Mat<f64>) -> Vec<f64> {
        Arch::new().dispatch(Solve {
            secular: self,
            z,
            order,
            vectors,
        })
    }

    #[inline(always)]
    fn solve_with(&self, z: &[f64], order: &[usize], vectors: &mut Mat<f64>) -> Vec<f64> {
        let d = &self.d;
        let count = d.len();
        let mut distances = vec![0.0; count];
        let mut roots = Vec::with_capacity(count);
        // The squares of which the roots that were found are the exact ones: the product of dᵢ − λⱼ by that of dᵢ − dⱼ, j ≠ i.
        let mut exact = vec![1.0; count];
        for j in 0..count {
            let (origin, offset) = self.root(j, &mut distances);
            roots.push(d[origin] + offset);
            let column = &mut vectors.col_as_slice_mut(j)[..count];
            for (entry, distance) in column.iter_mut().zip(&distances) {
                *entry = distance - offset;
            }
            exact[j] *= column[j];
            for others in [0..j, j + 1..count] {
                let each = exact[others.clone()]
                    .iter_mut()
                    .zip(&column[others.clone()]);
                for ((square, entry), d_i) in each.zip(&d[others]) {
                    *square *= entry / (d_i - d[j]);
                }
            }
        }
        for (square, z) in exact.iter_mut().zip(z) {
            *square = square.abs().sqrt().copysign(*z);
        }
        for j in 0..count {
            let column = &mut vectors.col_as_slice_mut(j)[..count];
            for ((entry, z), apart) in distances.iter_mut().zip(&exact).zip(&*column) {
                *entry = z / apart;
            }
            let length = distances.iter().map(|x| x * x).sum::<f64>().sqrt();
            for (entry, from) in column.iter_mut().zip(order) {
                *entry = distances[*from] / length;
            }
        }
        roots
    }

    /// The j-th eigenvalue: the place of the nearest d and the distance from that to nearly all digits, and those of all d. By
    /// the interpolation of R.-C. Li, *Solving secular equations stably and efficiently* (LAPACK Working Note 89, 1993), between brackets.
    #[inline(always)]
    fn root(&self, j: usize, distances: &mut [f64]) -> (usize, f64) {
        const MOST: usize = 100;
        let (d, squares) = (&self.d, &self.squares);
        let count = d.len();
        if count == 1 {
            distances[0] = 0.0;
            return (0, self.rho * squares[0]);
        }
        // The last root lies behind all poles.
        let is_last = j + 1 == count;
        let split = if is_last { j } else { j + 1 };
        let (left, right) = (split - 1, split);
        let gap = match is_last {
            true => self.rho * squares.iter().sum::<f64>(),
            false => d[j + 1] - d[j],
        };
        let measure = |distances: &mut [f64], origin: usize| {
            for (distance, d_i) in distances.iter_mut().zip(d) {
                *distance = d_i - d[origin];
            }
        };
        measure(distances, j);
        let (value, ..) = self.value(distances, split, 0.5 * gap);
        let from_left = is_last || value >= 0.0;
        let origin = if from_left { j } else { j + 1 };
        if !from_left {
            measure(distances, origin);
        }
        let (mut low, mut high) = match (is_last, from_left) {
            (true, _) if value < 0.0 => (0.5 * gap, gap),
            (_, true) => (0.0, 0.5 * gap),
            (_, false) => (-0.5 * gap, 0.0),
        };
        // With what all other poles add as it is in the middle.
        let (near, far) = (squares[left], squares[right]);
        let rest = value + (near - far) / (0.5 * gap);
        let mut mu = match (is_last, from_left) {
            (true, _) => 0.5 * (low + high),
            (_, true) => quadratic(rest, rest * gap + near + far, near * gap, true),
            (_, false) => quadratic(rest, -rest * gap + near + far, -far * gap, true),
        };
        if !(low < mu && mu < high) {
            mu = 0.5 * (low + high);
        }
        for _ in 0..MOST {
            let (value, slopes, size) = self.value(distances, split, mu);
            if value.abs() <= 2.0 * f64::EPSILON * size {
                break;
            }
            match value < 0.0 {
                true => low = mu,
                false => high = mu,
            }
            let slope = slopes[0] + slopes[1];
            let (near, far) = (distances[left] - mu, distances[right] - mu);
            // The nearer pole keeps its weight, and the other one takes what that leaves of the slope.
            let rest = match (is_last, from_left) {
                (true, _) => (value - near * slopes[0] - far * slopes[1]).abs(),
                (_, true) => value - far * slope - (near - far) * squares[left] / (near * near),
                (_, false) => value - near * slope - (far - near) * squares[right] / (far * far),
            };
            let a = (near + far) * value - near * far * slope;
            let mut step = quadratic(rest, a, near * far * value, !is_last);
            if step.is_nan() || step * value >= 0.0 {
                step = -value / slope;
            }
            let mut next = mu + step;
            if !(low < next && next < high) {
                next = 0.5 * (low + high);
            }
            if (next - mu).abs() <= 0.25 * f64::EPSILON * mu.abs() {
                break;
            }
            mu = next;
        }
        (origin, mu)
    }

    /// 1/ρ + Σ zᵢ²/(δᵢ − μ), its derivatives by the poles up to the split and from it, and the sum of the sizes of its parts.
    #[inline(always)]
    fn value(&self, distances: &[f64], split: usize, mu: f64) -> (f64, [f64; 2], f64) {
        let (near, far) = self.squares.split_at(split);
        let (left, right) = distances.split_at(split);
        let [before, steep] = sums(near, left, mu);
        let [beyond, steeper] = sums(far, right, mu);
        let constant = 1.0 / self.rho;
        let size = constant + before.abs() + beyond.abs();
        (constant + before + beyond, [steep, steeper], size)
    }
}

/// Σ zᵢ²/(δᵢ − μ) and Σ zᵢ²/(δᵢ − μ)².
#[inline(always)]
fn sums(squares: &[f64], distances: &[f64], mu: f64) -> [f64; 2] {
    const LANES: usize = 8;
    let (mut values, mut slopes) = ([0.0; LANES], [0.0; LANES]);
    let (z, d) = (squares.chunks_exact(LANES), distances.chunks_exact(LANES));
    for (i, (z, d)) in z.remainder().iter().zip(d.remainder()).enumerate() {
        let inverse = 1.0 / (d - mu);
        values[i] = z * inverse;
        slopes[i] = values[i] * inverse;
    }
    for (z, d) in z.zip(d) {
        let inverse: [f64; LANES] = from_fn(|i| 1.0 / (d[i] - mu));
        let terms: [f64; LANES] = from_fn(|i| z[i] * inverse[i]);
        values = from_fn(|i| values[i] + terms[i]);
        slopes = from_fn(|i| slopes[i] + terms[i] * inverse[i]);
    }
    [values, slopes].map(|lanes| lanes.iter().sum())
}

/// One of both x with c x² − a x + b = 0, without cancellation: that which is finite for c = 0, or the other.
#[inline(always)]
fn quadratic(c: f64, a: f64, b: f64, is_finite: bool) -> f64 {
    let root = (a * a - 4.0 * b * c).abs().sqrt();
    match (is_finite, a > 0.0) {
        (true, true) => 2.0 * b / (a + root),
        (true, false) => (a - root) / (2.0 * c),
        (false, true) => (a + root) / (2.0 * c),
        (false, false) => 2.0 * b / (a - root),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Entries = (Vec<f64>, Vec<f64>);

    /// Matrices of n rows that make and spare work in each way, with a factor for all entries.
    fn matrices(n: usize) -> Vec<(&'static str, f64, Entries)> {
        let number =
            |i: usize, k: usize| ((i * i * 31 + i * 7919 + k * 271) % 1009) as f64 / 1009.0;
        let of = |diagonal: &dyn Fn(usize) -> f64, below: &dyn Fn(usize) -> f64| -> Entries {
            let below = (1..n).map(|i| below(i - 1));
            ((0..n).map(diagonal).collect(), below.collect())
        };
        let mut all = vec![
            (
                "numbers without a pattern",
                of(&|i| number(i, 0) - 0.5, &|i| number(i, 1) - 0.5),
            ),
            ("equal entries", of(&|_| 2.0, &|_| -1.0)),
            (
                "pairs that nearly coincide",
                of(&|i| (i % 21).abs_diff(10) as f64, &|i| {
                    if i % 21 == 20 { 1e-10 } else { 1.0 }
                }),
            ),
            (
                "falling sizes",
                of(&|i| 0.8f64.powi(i as i32), &|i| 0.5 * 0.8f64.powi(i as i32)),
            ),
            (
                "rising sizes",
                of(&|i| 0.8f64.powi((n - i) as i32), &|i| {
                    0.5 * 0.8f64.powi((n - i) as i32)
                }),
            ),
            (
                "nearly the identity",
                of(&|_| 1.0, &|i| 1e-9 * number(i, 2)),
            ),
            ("the identity", of(&|_| 1.0, &|_| 0.0)),
            ("nothing", of(&|_| 0.0, &|_| 0.0)),
            (
                "parts",
                of(&|i| (i % 7) as f64, &|i| {
                    if i % 5 == 4 { 0.0 } else { 1e-3 }
                }),
            ),
            (
                "any sizes",
                of(&|i| (40.0 * number(i, 3) - 20.0).exp2(), &|i| {
                    (40.0 * number(i, 4) - 30.0).exp2()
                }),
            ),
        ];
        all.push((
            "no diagonal",
            of(&|_| 0.0, &|i| if i % 21 == 20 { 1e-8 } else { 1.0 }),
        ));
        let sized = |(name, entries): (_, Entries)| {
            [1.0, 1e-290, 1e290].map(|factor| (name, factor, entries.clone()))
        };
        all.into_iter().flat_map(sized).collect()
    }

    /// T·V − V·Λ and VᵀV − I on both sides of one and of two divisions, in units of rounding.
    #[test]
    fn residuals_are_roundings() {
        for n in [1, 2, 3, LEAF, LEAF + 1, 2 * LEAF, 2 * LEAF + 1, 150, 257] {
            for (name, factor, (diagonal, below)) in matrices(n) {
                let times =
                    |entries: &[f64]| -> Vec<f64> { entries.iter().map(|x| factor * x).collect() };
                let (values, vectors) =
                    eigen(&times(&diagonal), &times(&below), LEAF).expect("it converges");
                assert!(values.is_sorted());
                let t = Mat::from_fn(n, n, |i, j| match i.abs_diff(j) {
                    0 => diagonal[i],
                    1 => below[i.min(j)],
                    _ => 0.0,
                });
                let scaled = Mat::from_fn(n, n, |i, j| vectors[(i, j)] * (values[j] / factor));
                let off = (&t * &vectors - scaled).norm_max();
                let apart =
                    (vectors.transpose() * &vectors - Mat::<f64>::identity(n, n)).norm_max();
                let unit = 40.0 * f64::EPSILON;
                assert!(
                    off <= unit * t.norm_max(),
                    "{name}, {n} rows, {factor:e}: {off:e}"
                );
                assert!(apart <= unit, "{name}, {n} rows, {factor:e}: {apart:e}");
            }
        }
    }

    /// 2 − 2 cos(kπ/(n + 1)).
    #[test]
    fn eigenvalues_of_a_chain_are_known() {
        for n in [1, LEAF, LEAF + 1, 100, 333] {
            let (values, _) = eigen(&vec![2.0; n], &vec![-1.0; n - 1], LEAF).expect("it converges");
            for (k, value) in values.iter().enumerate() {
                let half = (k + 1) as f64 * std::f64::consts::FRAC_PI_2 / (n + 1) as f64;
                let expected = 4.0 * half.sin().powi(2);
                assert!((value - expected).abs() <= 20.0 * f64::EPSILON, "{n}, {k}");
            }
        }
    }

    #[test]
    fn of_nothing_there_is_nothing() {
        let (values, vectors) = eigen(&[], &[], LEAF).expect("it is there");
        assert_eq!((values.len(), vectors.ncols()), (0, 0));
    }

    #[test]
    fn what_is_not_finite_is_refused() {
        for entry in [f64::NAN, f64::INFINITY] {
            assert!(eigen(&[1.0, entry], &[1.0], LEAF).is_none());
            assert!(eigen(&[1.0, 1.0], &[entry], LEAF).is_none());
        }
    }
}
