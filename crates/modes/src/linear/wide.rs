//! Matrices with so many digits that what they give is right to forty-eight, whatever the condition of doubles allows:
//! linear equations by Gaussian elimination, and all modes of a definite pair by Jacobi's rotations (Golub & Van Loan,
//! *Matrix Computations*, §8.5), of what eigenvectors of doubles, corrected with all digits, leave to them.

use eigentone_digits::{DoubleDouble, Real, Wide, symmetric_eigen};
use faer::Mat;

/// 384 bits.
pub(crate) type Number = Wide<6>;

/// What is smaller than this beside what it came from is rounding, or cannot be distinguished from it: 2^-200 leaves 184 of 384 bits, 2^-80
/// about 20 of a double-double.
fn least<T: Real>(size: T) -> T {
    size.abs().scale(i64::from(T::UNIT_LOG2.max(-222)) + 22)
}

/// A full matrix by rows.
pub(crate) type Rows<T> = Vec<Vec<T>>;

/// X of A X = B, all given by rows, by elimination with row interchanges; `None` where a pivot is lost beside its row.
pub(crate) fn solve<T: Real>(mut a: Rows<T>, mut b: Rows<T>) -> Option<Rows<T>> {
    let n = a.len();
    let sizes: Vec<T> = a.iter().map(|row| largest(row.iter().copied())).collect();
    let mut rows: Vec<usize> = (0..n).collect();
    for k in 0..n {
        // The pivot that is largest beside its row.
        let share = |i: &usize| match sizes[*i].is_zero() {
            true => T::ZERO,
            false => a[*i][k].abs() / sizes[*i],
        };
        let best = (k..n).max_by(|i, j| {
            let (x, y) = (share(&rows[*i]), share(&rows[*j]));
            x.partial_cmp(&y).unwrap_or(std::cmp::Ordering::Equal)
        })?;
        rows.swap(k, best);
        let pivot = rows[k];
        if a[pivot][k].abs() <= least(sizes[pivot]) {
            return None;
        }
        let (row, right) = (a[pivot].clone(), b[pivot].clone());
        for &i in &rows[k + 1..] {
            if a[i][k].is_zero() {
                continue;
            }
            let factor = -(a[i][k] / row[k]);
            T::add_multiple(&mut a[i][k..], factor, &row[k..]);
            T::add_multiple(&mut b[i], factor, &right);
        }
    }
    let mut x: Rows<T> = vec![Vec::new(); n];
    for k in (0..n).rev() {
        let i = rows[k];
        let mut row = b[i].clone();
        let terms: Vec<_> = (k + 1..n).map(|j| (-a[i][j], &x[j][..])).collect();
        T::add_multiples(&mut row, &terms);
        x[k] = row.into_iter().map(|entry| entry / a[i][k]).collect();
    }
    Some(x)
}

/// The modes of K x = ω²M x by rising ω²: ω², and as rows the forces M x for shapes with xᵀMx = 1. `None` where M is not
/// positive definite. What is below [`least`] of the largest ω² is 0.
pub(crate) fn modes<T: Real>(mass: &Rows<T>, stiffness: &Rows<T>) -> Option<(Vec<T>, Rows<T>)> {
    let (mut squares, forces) = pairs(mass, stiffness)?;
    let size = largest(squares.iter().copied());
    let hidden = squares
        .iter_mut()
        .filter(|square| square.abs() <= least(size));
    hidden.for_each(|square| *square = T::ZERO);
    Some((squares, forces))
}

/// The same with every ω² as it is found, however small.
pub(crate) fn pairs<T: Real>(mass: &Rows<T>, stiffness: &Rows<T>) -> Option<(Vec<T>, Rows<T>)> {
    // M = L Lᵀ, and A = L⁻¹ K L⁻ᵀ.
    let factor = cholesky(mass)?;
    let mut half = forward(&factor, stiffness.clone());
    transpose(&mut half);
    let mut a = forward(&factor, half);
    // Columns of L Q, as rows.
    let mut forces = factor;
    transpose(&mut forces);
    approach(&mut a, &mut forces);
    rotate(&mut a, &mut forces);
    let squares = (0..a.len()).map(|i| a[i][i]);
    let mut found: Vec<(T, Vec<T>)> = squares.zip(forces).collect();
    found.sort_by(|a, b| a.0.partial_cmp(&b.0).unwrap_or(std::cmp::Ordering::Equal));
    Some(found.into_iter().unzip())
}

/// Whether a symmetric matrix is positive definite, as far as digits show.
pub(crate) fn is_definite<T: Real>(matrix: &Rows<T>) -> bool {
    cholesky(matrix).is_some()
}

fn largest<T: Real>(values: impl Iterator<Item = T>) -> T {
    values.fold(T::ZERO, |largest, value| {
        if value.abs() > largest {
            value.abs()
        } else {
            largest
        }
    })
}

fn transposed<T: Real>(rows: &Rows<T>) -> Rows<T> {
    let mut rows = rows.clone();
    transpose(&mut rows);
    rows
}

fn transpose<T: Real>(rows: &mut Rows<T>) {
    for i in 0..rows.len() {
        let (above, below) = rows.split_at_mut(i);
        for (j, row) in above.iter_mut().enumerate() {
            std::mem::swap(&mut row[i], &mut below[0][j]);
        }
    }
}

/// L with L Lᵀ the matrix, by rows with zeros above the diagonal.
fn cholesky<T: Real>(matrix: &Rows<T>) -> Option<Rows<T>> {
    let n = matrix.len();
    let mut factor: Rows<T> = vec![vec![T::ZERO; n]; n];
    for i in 0..n {
        for j in 0..=i {
            let mut sum = matrix[i][j];
            for (x, y) in factor[i][..j].iter().zip(&factor[j][..j]) {
                if !x.is_zero() {
                    sum = sum - *x * *y;
                }
            }
            factor[i][j] = match i == j {
                false => sum / factor[j][j],
                true if sum > least(matrix[i][i]) => sum.sqrt(),
                true => return None,
            };
        }
    }
    Some(factor)
}

/// L⁻¹B.
fn forward<T: Real>(factor: &Rows<T>, mut b: Rows<T>) -> Rows<T> {
    for (i, own) in factor.iter().enumerate() {
        let (above, rest) = b.split_at_mut(i);
        let terms = own.iter().zip(above.iter());
        let terms = terms.filter(|(entry, _)| !entry.is_zero());
        let terms: Vec<_> = terms.map(|(entry, row)| (-*entry, &row[..])).collect();
        T::add_multiples(&mut rest[0], &terms);
        let pivot = own[i];
        rest[0].iter_mut().for_each(|entry| *entry = *entry / pivot);
    }
    b
}

/// Makes a symmetric matrix A diagonal but for rounding and for values that hardly differ, as XᵀAX, which leaves few rotations to be
/// done; `others` becomes Xᵀ`others`. X is made of eigenvectors of doubles, each correction of which squares what they are off. Where
/// that does not succeed all stays as it was.
fn approach<T: Real>(a: &mut Rows<T>, others: &mut Rows<T>) {
    /// Fewer rows are as quickly rotated from the start, and double-doubles have no digits to spare for small values.
    const LEAST: usize = 12;
    /// Three corrections are enough where values are apart.
    const MOST: usize = 6;
    let n = a.len();
    if n < LEAST || T::UNIT_LOG2 > -200 {
        return;
    }
    let size = largest(a.iter().flatten().copied());
    if size.is_zero() || !size.is_finite() {
        return;
    }
    let exponent = size.magnitude().exponent();
    let scaled = |entry: T| entry.scale(-exponent);
    let doubles = Mat::from_fn(n, n, |i, j| scaled(a[i][j]).to_f64());
    let Some((_, vectors)) = symmetric_eigen(&doubles) else {
        return;
    };
    let short = |x: T| {
        let [high, low, _] = parts(scaled(x));
        DoubleDouble::new(high, low)
    };
    let of = |row: &Vec<T>| row.iter().map(|x| short(*x)).collect();
    let mut first: Rows<DoubleDouble> = (0..n)
        .map(|j| (0..n).map(|i| vectors[(i, j)].into()).collect())
        .collect();
    corrected(&a.iter().map(of).collect(), &mut first);
    let long = |x: &DoubleDouble| T::from(x.high()) + T::from(x.low());
    let mut x: Rows<T> = first
        .iter()
        .map(|row| row.iter().map(long).collect())
        .collect();
    // The last correction errs by about the square of its size.
    let enough = (f64::from(T::UNIT_LOG2) / 2.0).exp2();
    if !(0..MOST).any(|_| corrected(a, &mut x) <= enough) {
        return;
    }
    let forms = product(&product(&x, a), &transposed(&x));
    let rounding = size.scale(i64::from(T::UNIT_LOG2) + 13);
    for i in 0..n {
        for j in 0..=i {
            let entry = forms[i][j];
            // Rounding errs by units of the largest entry: below that nothing is known.
            let is_known = i == j || entry.abs() > rounding;
            a[i][j] = if is_known { entry } else { T::ZERO };
            a[j][i] = a[i][j];
        }
    }
    *others = product(&x, others);
}

/// X(I + E) for approximate eigenvectors X of a symmetric A, given as rows: orthogonal, and apart where values are, but for the square
/// of what they are off (Ogita & Aishima 2018, *Iterative refinement for symmetric eigenvalue decomposition*, Jpn. J. Ind. Appl. Math.
/// 35); the largest size in E. Where values are as near as what couples them, vectors are made orthogonal alone.
fn corrected<T: Real>(a: &Rows<T>, x: &mut Rows<T>) -> f64 {
    /// How much less than the gap between values what couples them is.
    const APART: i64 = -10;
    let n = x.len();
    let across = transposed(x);
    let forms = product(&product(x, a), &across);
    let mut rest = product(x, &across);
    for (i, row) in rest.iter_mut().enumerate() {
        row.iter_mut().for_each(|entry| *entry = -*entry);
        row[i] = T::ONE + row[i];
    }
    let values: Vec<T> = (0..n)
        .map(|i| forms[i][i] / (T::ONE - rest[i][i]))
        .collect();
    // By rows of Eᵀ.
    let mut change = vec![vec![T::ZERO; n]; n];
    let mut size = 0.0f64;
    for i in 0..n {
        for j in 0..=i {
            let gap = values[j] - values[i];
            let half = rest[i][j].scale(-1);
            let coupled = [j, i].map(|of| forms[i][j] + values[of] * rest[i][j]);
            let are_apart = coupled.iter().all(|x| x.abs() < gap.abs().scale(APART));
            (change[j][i], change[i][j]) = match are_apart {
                true => (coupled[0] / gap, -(coupled[1] / gap)),
                false => (half, half),
            };
            let sizes = [change[j][i], change[i][j]].map(|x| x.abs().to_f64());
            size = size.max(sizes[0]).max(sizes[1]);
        }
    }
    let moved = product(&change, x);
    for (row, moved) in x.iter_mut().zip(moved) {
        for (entry, moved) in row.iter_mut().zip(moved) {
            *entry = *entry + moved;
        }
    }
    size
}

fn product<T: Real>(a: &Rows<T>, b: &Rows<T>) -> Rows<T> {
    let (k, n) = (b.len(), b.first().map_or(0, Vec::len));
    if let Some(product) = T::matrix_product([a.len(), k, n], &a.concat(), &b.concat()) {
        return product.chunks_exact(n).map(<[T]>::to_vec).collect();
    }
    let row = |factors: &Vec<T>| {
        let mut sum = vec![T::ZERO; n];
        let terms = factors
            .iter()
            .zip(b)
            .filter(|(factor, _)| !factor.is_zero());
        let terms: Vec<_> = terms.map(|(factor, row)| (*factor, &row[..])).collect();
        T::add_multiples(&mut sum, &terms);
        sum
    };
    a.iter().map(row).collect()
}

/// Makes a symmetric matrix diagonal by rotations of rows and columns; those of rows are applied to `others` too.
fn rotate<T: Real>(a: &mut Rows<T>, others: &mut Rows<T>) {
    /// Each sweep squares what is left, once it is small.
    const SWEEPS: usize = 40;
    let n = a.len();
    let one = T::ONE;
    for _ in 0..SWEEPS {
        let mut still = true;
        for p in 0..n {
            for q in p + 1..n {
                let off = a[p][q];
                let (first, second) = (a[p][p], a[q][q]);
                let size = largest([first, second].into_iter());
                // 13 bits more than a unit of both are what rounding leaves.
                if off.abs() <= size.scale(i64::from(T::UNIT_LOG2) + 13) {
                    continue;
                }
                still = false;
                let theta = (second - first) / (off + off);
                let size = theta.abs() + (theta * theta + one).sqrt();
                let tangent = match theta < T::ZERO {
                    true => -(one / size),
                    false => one / size,
                };
                let cosine = one / (tangent * tangent + one).sqrt();
                let sine = tangent * cosine;
                turn(a, [p, q], [cosine, sine]);
                turn(others, [p, q], [cosine, sine]);
                for row in a.iter_mut() {
                    let (x, y) = (row[p], row[q]);
                    row[p] = cosine * x - sine * y;
                    row[q] = sine * x + cosine * y;
                }
                (a[p][q], a[q][p]) = (T::ZERO, T::ZERO);
            }
        }
        if still {
            return;
        }
    }
}

fn turn<T: Real>(rows: &mut Rows<T>, [p, q]: [usize; 2], [cosine, sine]: [T; 2]) {
    let (above, below) = rows.split_at_mut(q);
    for (x, y) in above[p].iter_mut().zip(&mut below[0]) {
        (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
    }
}

/// A number as three doubles, the largest first: it is their sum but for 2^-159 of itself.
pub(crate) fn parts<T: Real>(number: T) -> [f64; 3] {
    let mut rest = number;
    [(); 3].map(|()| {
        let part = rest.to_f64();
        rest = rest - T::from(part);
        part
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dot(a: &[Number], b: &[Number]) -> Number {
        let pairs = a.iter().zip(b);
        pairs.fold(Number::ZERO, |sum, (x, y)| sum + *x * *y)
    }

    fn rows<const N: usize>(entries: [[f64; N]; N]) -> Rows<Number> {
        let row = |row: &[f64; N]| row.iter().map(|x| Number::from(*x)).collect();
        entries.iter().map(row).collect()
    }

    /// Equations whose pivots must be sought, and a singular matrix.
    #[test]
    fn equations() {
        let b: Rows<Number> = [1.0, 2.0].map(|x| vec![Number::from(x)]).to_vec();
        let x = solve(rows([[0.0, 3.0], [1.0, 1e-30]]), b.clone()).expect("regular");
        assert_eq!(parts(x[1][0])[..2], [1.0 / 3.0, 1.850_371_707_708_594e-17]);
        assert!(solve(rows([[1.0, 2.0], [2.0, 4.0]]), b).is_none());
    }

    /// Three equal masses between walls: ω² = 2 − √2, 2, 2 + √2, and what a free pair leaves at 0.
    #[test]
    fn modes_of_chains() {
        let unit = rows([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let chain = rows([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]]);
        let (squares, forces) = modes(&unit, &chain).expect("definite");
        let root = Number::from(2.0).sqrt();
        let expected = [-root, Number::from(0.0), root].map(|x| x + Number::from(2.0));
        for (i, (square, expected)) in squares.iter().zip(expected).enumerate() {
            assert!((*square - expected).abs().to_f64() < 1e-100);
            let sum = forces[i]
                .iter()
                .fold(Number::from(0.0), |sum, x| sum + *x * *x);
            assert!((sum - Number::from(1.0)).abs().to_f64() < 1e-100);
        }
        let free = rows([[1.0, -1.0], [-1.0, 1.0]]);
        let (squares, _) = modes(&rows([[3.0, 1.0], [1.0, 2.0]]), &free).expect("definite");
        assert!(squares[0].is_zero() && !squares[1].is_zero());
        assert!(modes(&free, &free).is_none());
    }

    /// A grid of six by six masses, all of whose values but some come twice or more, and the same with springs that make a few of
    /// them differ by 1e-13: all residuals and products of vectors are nothing but rounding.
    #[test]
    fn values_that_coincide_are_taken_apart_too() {
        const SIDE: usize = 6;
        let n = SIDE * SIDE;
        for more in [0.0, 1e-13] {
            let entry = |i: usize, j: usize| match i.abs_diff(j) {
                0 => 4.0,
                1 if i / SIDE == j / SIDE => -1.0,
                SIDE => -1.0,
                _ => 0.0,
            };
            let row = |i: usize| (0..n).map(|j| Number::from(entry(i, j))).collect();
            let mut grid: Rows<Number> = (0..n).map(row).collect();
            grid[7][7] = grid[7][7] + Number::from(more);
            let mut unit: Rows<Number> = vec![vec![Number::ZERO; n]; n];
            (0..n).for_each(|i| unit[i][i] = Number::ONE);
            let (squares, vectors) = modes(&unit, &grid).expect("definite");
            for i in 0..n {
                let pushed: Vec<Number> = grid.iter().map(|row| dot(row, &vectors[i])).collect();
                for (push, x) in pushed.iter().zip(&vectors[i]) {
                    assert!((*push - squares[i] * *x).abs().to_f64() < 1e-105);
                }
                for j in 0..=i {
                    let one = if i == j { Number::ONE } else { Number::ZERO };
                    assert!((dot(&vectors[i], &vectors[j]) - one).abs().to_f64() < 1e-105);
                }
            }
        }
    }
}
