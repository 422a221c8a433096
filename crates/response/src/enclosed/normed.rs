//! Square matrices with a bound of their error in the 2-norm.

use std::ops::Range;

use eigentone_digits::{BallMatrix, Cholesky, Magnitude, Real, settle};
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

/// A true matrix within `error` of the matrix kept, in the 2-norm, and of the same shape: block
/// upper triangular, with a first block of `lead` rows.
#[derive(Clone, Debug)]
pub(crate) struct Normed<T> {
    n: usize,
    lead: usize,
    /// Row by row.
    entries: Vec<T>,
    error: Magnitude,
    /// Upper bounds of the 2-norms of what is kept, and of the matrix of the sizes of its entries.
    norm: Magnitude,
    sizes: Magnitude,
}

impl<T: Real> Normed<T> {
    /// From entries row by row and the error they have already.
    pub(crate) fn new(n: usize, lead: usize, entries: Vec<T>, error: Magnitude) -> Normed<T> {
        let (sizes, norm) = norms(n, &entries);
        // Entries that left the range of T say nothing, though their bounds may be finite.
        let error = if sizes.is_finite() {
            error
        } else {
            Magnitude::INFINITY
        };
        Normed {
            n,
            lead,
            entries,
            error,
            norm,
            sizes,
        }
    }

    /// From a matrix known entry by entry.
    pub(crate) fn of(matrix: &BallMatrix<T>, lead: usize) -> Normed<T> {
        let n = matrix.rows();
        let entries = (0..n * n).map(|at| matrix.middle(at / n, at % n));
        Normed::new(n, lead, entries.collect(), matrix.spread())
    }

    pub(crate) fn identity(n: usize, lead: usize) -> Normed<T> {
        let entry = |at: usize| if at / n == at % n { T::ONE } else { T::ZERO };
        let entries = (0..n * n).map(entry).collect();
        Normed::new(n, lead, entries, Magnitude::ZERO)
    }

    pub(crate) fn len(&self) -> usize {
        self.n
    }

    pub(crate) fn lead(&self) -> usize {
        self.lead
    }

    pub(crate) fn entries(&self) -> &[T] {
        &self.entries
    }

    pub(crate) fn row(&self, i: usize) -> &[T] {
        &self.entries[i * self.n..(i + 1) * self.n]
    }

    /// How far the true matrix may be, in the 2-norm.
    pub(crate) fn error(&self) -> Magnitude {
        self.error
    }

    /// An upper bound of the 2-norm of the true matrix.
    pub(crate) fn true_norm(&self) -> Magnitude {
        self.norm + self.error
    }

    /// An upper bound of the 2-norm of the matrix of the sizes |aᵢⱼ| of what is kept: rounding errs by units of it.
    pub(crate) fn sizes(&self) -> Magnitude {
        self.sizes
    }

    /// The same matrix, farther from the true one.
    pub(crate) fn with_more_error(mut self, more: Magnitude) -> Normed<T> {
        self.error = self.error + more;
        self
    }

    /// The block of these rows and the same columns.
    pub(crate) fn part(&self, places: Range<usize>) -> Normed<T> {
        if places.len() == self.n {
            return self.clone();
        }
        let rows = places.clone().flat_map(|i| &self.row(i)[places.clone()]);
        let lead = self.lead.clamp(places.start, places.end) - places.start;
        Normed::new(places.len(), lead, rows.copied().collect(), self.error)
    }

    /// An upper bound of the 2-norm of a block of the true matrix.
    pub(crate) fn between(&self, rows: Range<usize>, columns: Range<usize>) -> Magnitude {
        let entries = rows.flat_map(|i| &self.row(i)[columns.clone()]);
        let squares = entries.map(|entry| entry.upper() * entry.upper());
        let sum = squares.fold(Magnitude::ZERO, |sum, square| sum + square);
        sum.sqrt() + self.error
    }

    pub(crate) fn transposed(&self) -> Normed<T> {
        let n = self.n;
        let entries = (0..n * n).map(|at| self.entries[at % n * n + at / n]);
        Normed::new(n, n, entries.collect(), self.error)
    }

    pub(crate) fn plus(&self, other: &Normed<T>) -> Normed<T> {
        let pairs = self.entries.iter().zip(&other.entries);
        let entries = pairs.map(|(a, b)| *a + *b).collect();
        let lead = self.lead.min(other.lead);
        let sum = Normed::new(self.n, lead, entries, self.error + other.error);
        let rounding = sum.sizes * T::unit();
        sum.with_more_error(rounding)
    }

    /// 2^power times the matrix.
    pub(crate) fn scaled(&self, power: i64) -> Normed<T> {
        let factor = Magnitude::power_of_two(power);
        let lost = T::floor() * Magnitude::from(self.n as f64);
        Normed {
            entries: self.entries.iter().map(|x| x.scale(power)).collect(),
            error: self.error * factor + lost,
            norm: self.norm * factor + lost,
            sizes: self.sizes * factor + lost,
            ..*self
        }
    }

    /// The matrix over a power of two that is near the norm of its sizes, and the exponent of that. Entries so small beside
    /// the others that their squares could leave the range of T become 0, within the error.
    pub(crate) fn normalised(&self) -> (Normed<T>, i64) {
        const END: i64 = -1 << 50;
        let exponent = self.sizes.exponent();
        let mut scaled = self.scaled(-exponent);
        let end = Magnitude::power_of_two(END);
        for entry in &mut scaled.entries {
            if !entry.is_zero() && entry.magnitude() < end {
                *entry = T::ZERO;
                scaled.error = scaled.error + end;
            }
        }
        (scaled, exponent)
    }

    /// `factor` times the matrix, for a factor known to a relative `error`.
    pub(crate) fn times_scalar(&self, factor: T, error: Magnitude) -> Normed<T> {
        let size = factor.upper();
        let rounding =
            size * self.sizes * (T::unit() + error) + T::floor() * Magnitude::from(self.n as f64);
        let error = size * self.error * (Magnitude::from(1.0) + error) + rounding;
        let entries = self.entries.iter().map(|x| *x * factor).collect();
        Normed::new(self.n, self.lead, entries, error)
    }

    /// The product. With k = n terms in each sum, its rounding is at most (k + 2)U in parts of the
    /// product of sizes |A||B| (Higham 2002, §3.5).
    pub(crate) fn times(&self, other: &Normed<T>) -> Normed<T> {
        let (entries, error) = self.product(other);
        Normed::new(self.n, self.lead, entries, error)
    }

    /// Entries and error of the same.
    pub(super) fn product(&self, other: &Normed<T>) -> (Vec<T>, Magnitude) {
        let n = self.n;
        let entries = T::matrix_product([n; 3], &self.entries, &other.entries);
        let entries = entries.unwrap_or_else(|| self.term_by_term(other));
        let rounding = self.sizes * other.sizes * growth::<T>(n)
            + T::floor() * Magnitude::from((n * n) as f64 * 2.0);
        let error = self.norm * other.error + self.error * other.true_norm() + rounding;
        (entries, error)
    }

    fn term_by_term(&self, other: &Normed<T>) -> Vec<T> {
        let (n, lead) = (self.n, self.lead);
        let mut entries = vec![T::ZERO; n * n];
        let mut terms = Vec::with_capacity(n);
        let mut add = |sum: &mut [T], i: usize, inner: Range<usize>, start: usize| {
            let factors = inner.map(|k| (k, self.entries[i * n + k]));
            let factors = factors.filter(|(_, factor)| !factor.is_zero());
            terms.clear();
            terms.extend(factors.map(|(k, factor)| (factor, &other.row(k)[start..])));
            T::add_multiples(sum, &terms);
        };
        for (i, row) in entries.chunks_exact_mut(n.max(1)).enumerate() {
            if i < lead {
                add(row, i, 0..lead, 0);
            }
            add(&mut row[lead..], i, lead..n, lead);
        }
        entries
    }
}

/// (k + 2)U, above kU/(1 − kU).
pub(crate) fn growth<T: Real>(k: usize) -> Magnitude {
    T::unit() * Magnitude::from(k as f64 + 2.0)
}

/// Upper bounds of the 2-norms of the sizes, and of the matrix itself, computed in doubles with their rounding added. Of the
/// sizes: ‖A‖_F, or ‖|A|‖² ≤ ‖A‖₁‖A‖_∞ where that is less, as it is near I. Of the matrix: ‖A‖² = ‖G‖ for G = AᵀA, and
/// ‖G‖⁴ = ‖G⁴‖ ≤ ‖G⁴‖_∞, which exceeds the norm by at most the eighth root of n.
fn norms<T: Real>(n: usize, entries: &[T]) -> (Magnitude, Magnitude) {
    const UNIT: f64 = f64::EPSILON / 2.0;
    let largest = |largest: Magnitude, entry: &T| {
        let size = entry.magnitude();
        if largest < size { size } else { largest }
    };
    let largest = entries.iter().fold(Magnitude::ZERO, largest);
    if largest.is_zero() || !largest.is_finite() {
        return (largest, largest);
    }
    // Entries of size at most 2, each within a unit of itself or 2^-1074.
    let exponent = largest.exponent();
    let mut a: Vec<f64> = entries
        .iter()
        .map(|x| x.scale(-exponent).to_f64())
        .collect();
    let count = entries.len() as f64;
    let squares: f64 = a.iter().map(|x| x * x).sum();
    let frobenius = (squares * (1.0 + (count + 8.0) * 2.0 * UNIT)).sqrt() * (1.0 + 4.0 * UNIT);
    let (mut longest, mut columns) = (0.0f64, vec![0.0; n]);
    for row in a.chunks_exact(n) {
        longest = longest.max(row.iter().map(|x| x.abs()).sum());
        let pairs = columns.iter_mut().zip(row);
        pairs.for_each(|(sum, x)| *sum += x.abs());
    }
    let tallest = columns.into_iter().fold(0.0, f64::max);
    let sizes = (longest * tallest).sqrt() * (1.0 + (n as f64 + 8.0) * 4.0 * UNIT);
    let sizes = sizes.min(frobenius);
    // Over a power of two that leaves at most 1 of it.
    let excess = frobenius.log2().ceil() as i32 + 1;
    let factor = 2f64.powi(-excess);
    a.iter_mut().for_each(|x| *x *= factor);
    let unit = Magnitude::power_of_two(exponent);
    let sizes = Magnitude::from(sizes) * unit;

    let mut first = gram(n, &a);
    let second = gram(n, &first);
    let fourth = gram(n, &second);
    // The Frobenius norms of the rounding errors; squares of sizes up to 1 + n·units.
    let lost = |matrix: &[f64]| {
        let sum: f64 = matrix.iter().map(|x| x * x).sum();
        (n as f64 + 4.0) * 2.0 * UNIT * sum + f64::MIN_POSITIVE * (n * n) as f64
    };
    let row_sum = |i: usize| {
        let row = fourth[i * n..(i + 1) * n].iter();
        row.map(|x| x.abs()).sum::<f64>()
    };
    let largest = (0..n).map(row_sum).fold(0.0, f64::max) * (1.0 + 2.0 * n as f64 * UNIT);
    let of_second = (largest + lost(&second)).sqrt();
    let mut of_gram = (of_second * (1.0 + 8.0 * UNIT) + lost(&first)).sqrt();
    // Of a matrix that lengthens nothing the powers above are not near enough to 1 for many steps.
    let one = (-2.0 * (exponent + i64::from(excess)) as f64).exp2();
    if (one..2.0 * one).contains(&of_gram) {
        let (terms, filled) = (n as f64 * (n as f64 + 5.0), n as f64 + 8.0);
        let slack = (terms * one + filled) * 2.0 * UNIT;
        if slack < of_gram - one && is_at_most(n, &mut first, one + slack) {
            of_gram = of_gram.min(one + 3.0 * slack);
        }
    }
    // ‖A‖_F ≤ 1 after the scaling; the conversions add 4 units to what the sums lose.
    let of_square = of_gram * (1.0 + 8.0 * UNIT) + (n as f64 + 8.0) * 2.0 * UNIT;
    let norm = Magnitude::from(of_square * (1.0 + 8.0 * UNIT)).sqrt();
    let norm = norm * Magnitude::power_of_two(excess.into()) * unit;
    (sizes, if norm < sizes { norm } else { sizes })
}

/// Whether s·I − G, for a symmetric G by columns that is overwritten, has a Cholesky factor: G is then at most s(1 + n(n + 5)2u)·I,
/// as the factor is exact for a matrix off by at most (n + 2)2u√(aᵢᵢaⱼⱼ) in entry (i, j), aᵢᵢ ≤ s, with one rounding more for
/// reciprocals of pivots (Rump 2006, *Verification of positive definiteness*, BIT 46).
fn is_at_most(n: usize, g: &mut [f64], s: f64) -> bool {
    g.iter_mut().for_each(|entry| *entry = -*entry);
    (0..n).for_each(|i| g[i * n + i] += s);
    Cholesky::of(MatRef::from_column_major_slice(g, n, n)).is_some()
}

/// AᵀA for a matrix A by rows, given as B = Aᵀ by columns: BBᵀ.
fn gram(n: usize, b: &[f64]) -> Vec<f64> {
    /// Below this many rows plain loops are quicker than a blocked product.
    const BLOCKS: usize = 16;
    let mut product = vec![0.0; n * n];
    if n >= BLOCKS {
        let b = MatRef::from_column_major_slice(b, n, n);
        let to = MatMut::from_column_major_slice_mut(&mut product, n, n);
        matmul(to, Accum::Replace, b, b.transpose(), 1.0, Par::Seq);
        settle();
        return product;
    }
    for column in b.chunks_exact(n) {
        for (sums, factor) in product.chunks_exact_mut(n).zip(column) {
            let pairs = sums.iter_mut().zip(column);
            pairs.for_each(|(sum, entry)| *sum += factor * entry);
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_digits::{DoubleDouble, Wide};

    fn normed<T: Real>(n: usize, entries: &[f64]) -> Normed<T> {
        let entries = entries.iter().map(|x| T::from(*x)).collect();
        Normed::new(n, n, entries, Magnitude::ZERO)
    }

    #[test]
    fn the_two_norm_is_bounded_closely() {
        // A rotation, a nilpotent matrix, and a singular one: norms 1, 1e9 and 2·√5.
        let (c, s) = (0.6, 0.8);
        for (entries, norm) in [
            ([c, s, -s, c], 1.0),
            ([0.0, 1e9, 0.0, 0.0], 1e9),
            ([2.0, 2.0, 4.0, 4.0], 40f64.sqrt()),
            ([1e-300, 0.0, 0.0, 1e-310], 1e-300),
        ] {
            let bound = normed::<DoubleDouble>(2, &entries).true_norm().to_f64();
            assert!(bound >= norm * (1.0 - 1e-15), "{bound} {norm}");
            assert!(bound <= norm * 1.1, "{bound} {norm}");
        }
    }

    #[test]
    fn products_respect_the_blocks() {
        let entries = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 0.0, 0.0, 7.0];
        let whole = normed::<Wide<4>>(3, &entries);
        let blocked = Normed::new(3, 2, whole.entries.clone(), Magnitude::ZERO);
        assert_eq!(whole.times(&whole).entries, blocked.times(&blocked).entries);
        assert_eq!(
            blocked.times(&blocked).row(0)[2].to_f64(),
            3.0 + 12.0 + 21.0
        );
    }

    /// 3 ± 1e-10 times 5 ± 1e-11: the worst of the products is what the bound must reach, in every one
    /// of its terms.
    #[test]
    fn errors_of_both_factors_and_of_both_together_count() {
        let one = |value: f64, error: f64| {
            Normed::new(
                1,
                1,
                vec![DoubleDouble::from(value)],
                Magnitude::from(error),
            )
        };
        let product = one(3.0, 1e-10).times(&one(5.0, 1e-11));
        let worst = 3.0 * 1e-11 + 1e-10 * 5.0 + 1e-10 * 1e-11;
        let bound = product.error().to_f64();
        assert!(bound >= worst * (1.0 - 1e-15), "{bound:e} {worst:e}");
        assert!(bound <= worst * (1.0 + 1e-9), "{bound:e} {worst:e}");
        // A factor of 7 ± 1e-12, relative to it.
        let scaled = one(3.0, 1e-10).times_scalar(DoubleDouble::from(7.0), Magnitude::from(1e-12));
        let worst = 7.0 * 1e-10 * (1.0 + 1e-12) + 7.0 * 1e-12 * 3.0;
        let bound = scaled.error().to_f64();
        assert!(bound >= worst * (1.0 - 1e-15), "{bound:e} {worst:e}");
        assert!(bound <= worst * (1.0 + 1e-9), "{bound:e} {worst:e}");
        // What a matrix may be is as large as it is and its error.
        assert!(one(3.0, 1e-10).true_norm().to_f64() >= 3.0 + 1e-10);
    }

    /// Products of 106 bits against products of 1024, whose entries have no pattern.
    #[test]
    fn rounding_of_products_is_counted() {
        let n = 7;
        let third = DoubleDouble::from(1.0) / DoubleDouble::from(3.0);
        let entry = |at: usize| {
            let turned = third * DoubleDouble::from((at * at % 41) as f64 - 20.0);
            turned + DoubleDouble::from(1.0 / (at as f64 + 0.3))
        };
        let entries: Vec<DoubleDouble> = (0..n * n).map(entry).collect();
        let exact = entries.iter().map(|x| Wide::<16>::from(*x)).collect();
        let exact = Normed::new(n, n, exact, Magnitude::ZERO);
        let coarse = Normed::new(n, n, entries, Magnitude::ZERO);
        let factor = third + DoubleDouble::from(1.0);
        let products = [
            (exact.times(&exact), coarse.times(&coarse)),
            (
                exact.times_scalar(Wide::from(factor), Magnitude::ZERO),
                coarse.times_scalar(factor, Magnitude::ZERO),
            ),
        ];
        for (exact, coarse) in products {
            let pairs = exact.entries().iter().zip(coarse.entries());
            let off = pairs.map(|(exact, coarse)| (*exact - Wide::from(*coarse)).to_f64().abs());
            let off = off.fold(0.0, f64::max);
            let bound = coarse.error().to_f64();
            assert!(off > 0.0, "nothing was rounded");
            // No entry of a matrix exceeds its 2-norm.
            assert!(off <= bound, "{off:e} {bound:e}");
            assert!(bound <= 1e-29 * exact.true_norm().to_f64());
        }
    }

    /// Of n ones in a row the norm is √n, of n × n ones n: more than any one entry.
    #[test]
    fn the_two_norm_is_that_of_all_entries() {
        for n in [2usize, 5, 12] {
            let ones = normed::<DoubleDouble>(n, &vec![1.0; n * n])
                .true_norm()
                .to_f64();
            assert!(ones >= n as f64 && ones <= 1.01 * n as f64, "{ones}");
            let row: Vec<f64> = (0..n * n).map(|at| f64::from(at < n)).collect();
            let row = normed::<DoubleDouble>(n, &row).true_norm().to_f64();
            let exact = (n as f64).sqrt();
            assert!(row >= exact * (1.0 - 1e-15) && row <= 1.01 * exact, "{row}");
        }
    }

    /// Rotations of pairs by many angles, some of them shortened, in other orthogonal coordinates: their powers lengthen nothing, and
    /// that is known far more closely than ‖G⁴‖_∞ shows.
    #[test]
    fn what_lengthens_nothing_is_known_to() {
        for n in [4usize, 40] {
            let mut entries = vec![0.0; n * n];
            for pair in 0..n / 2 {
                let (sine, cosine) = (0.3 + pair as f64).sin_cos();
                let size = 1.0 - 0.2 * (pair % 3) as f64;
                let at = 2 * pair;
                entries[at * n + at] = size * cosine;
                entries[at * n + at + 1] = size * sine;
                entries[(at + 1) * n + at] = -size * sine;
                entries[(at + 1) * n + at + 1] = size * cosine;
            }
            // Reflections I − 2vvᵀ/vᵀv from both sides, which change lengths by rounding alone.
            let v: Vec<f64> = (0..n).map(|i| 1.0 + (i % 5) as f64).collect();
            let square: f64 = v.iter().map(|x| x * x).sum();
            for _ in 0..2 {
                for row in entries.chunks_exact_mut(n) {
                    let product: f64 = row.iter().zip(&v).map(|(x, y)| x * y).sum();
                    let pairs = row.iter_mut().zip(&v);
                    pairs.for_each(|(x, y)| *x -= 2.0 * product / square * y);
                }
                entries = (0..n * n).map(|at| entries[at % n * n + at / n]).collect();
            }
            for scale in [1.0, 1.0 + 1e-9, 1.0 - 1e-9, 1.1] {
                let scaled: Vec<f64> = entries.iter().map(|x| x * scale).collect();
                let bound = normed::<DoubleDouble>(n, &scaled).true_norm().to_f64();
                assert!(bound >= scale - 1e-14, "{n}: {bound}");
                if scale <= 1.0 {
                    assert!(bound <= 1.0 + 1e-11, "{n}: {:e}", bound - 1.0);
                }
            }
        }
    }

    /// I and a ring of entries ±ε beside it: |A| has the norm 1 + 2ε, where ‖A‖_F is √n and more. Of ones in the first
    /// row and the last column sums of rows and columns are n, and ‖A‖_F = √(2n − 1) is nearer.
    #[test]
    fn the_norm_of_the_sizes_is_bounded_both_ways() {
        let (n, small) = (100, 1.0 / 1024.0);
        let mut ring = vec![0.0; n * n];
        for i in 0..n {
            ring[i * n + i] = 1.0;
            ring[i * n + (i + 1) % n] = small;
            ring[(i + 1) % n * n + i] = -small;
        }
        let found = normed::<DoubleDouble>(n, &ring).sizes().to_f64();
        let exact = 1.0 + 2.0 * small;
        assert!(found >= exact && found <= exact * (1.0 + 1e-12), "{found}");
        let cross: Vec<f64> = (0..n * n)
            .map(|at| f64::from(at < n || at % n == n - 1))
            .collect();
        // |A|ᵀ|A| = J + (n − 1)eeᵀ for J of ones, on the span of the ones and e.
        let (a, b) = (n as f64, n as f64 - 1.0);
        let exact = ((a + b + ((a + b).powi(2) - 4.0 * b * b).sqrt()) / 2.0).sqrt();
        let found = normed::<DoubleDouble>(n, &cross).sizes().to_f64();
        assert!(found >= exact && found <= 1.5 * exact, "{found} {exact}");
    }
}
