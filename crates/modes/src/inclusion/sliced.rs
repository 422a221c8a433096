//! Products of long columns to more digits than doubles have, as a few products of matrices of doubles.
//!
//! Columns whose largest entry is about 1 are cut into slices of β bits, A = A₁ + … + A_p + a_p with the entries of A_s multiples
//! of 2^{-βs}. While 2β + log₂ n ≤ 53 no sum in A_sᵀB_t rounds, in whatever order it is taken. With b_t what t slices leave of B,
//!
//! AᵀB = Σ_{s+t ≤ p+1} A_sᵀB_t + Σ_s A_sᵀb_{p+1−s} + a_pᵀB,
//!
//! where the last two, some 2^{-βp} of the whole, are taken in doubles (Ozaki, Ogita, Oishi & Rump 2012, *Numer. Algorithms* 59).
//! Powers of 2 scale rows against each other first, so that rotations beside translations cost no digits.

use eigentone_digits::{DoubleDouble, Real, settle};
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, Mat, Par};
use pulp::Arch;

type Columns = [Vec<DoubleDouble>];

/// A bound of the errors of all entries (i, j) of a product: unit·first_i·second_j, which are sums in doubles.
#[derive(Clone)]
pub(super) struct Rounding {
    pub(super) unit: f64,
    pub(super) first: Vec<f64>,
    pub(super) second: Vec<f64>,
}

impl Rounding {
    /// What it makes of the rows of a product that a column x multiplies on the left.
    pub(super) fn felt(&self, x: &[DoubleDouble]) -> f64 {
        let rows = self.first.iter().zip(x);
        rows.map(|(size, x)| size * x.to_f64().abs()).sum()
    }
}

/// AᵀB by rows, in p slices; with `is_symmetric` from what is on and above its diagonal. `None` where entries are so
/// large or small that their scales leave the range of doubles.
pub(super) fn products(
    a: &Columns,
    b: &Columns,
    slices: usize,
    is_symmetric: bool,
) -> Option<(Vec<DoubleDouble>, Rounding)> {
    let length = a.first().map_or(0, Vec::len);
    // Compiled for vectors of doubles.
    let (left, right) = Arch::new().dispatch(|| {
        let rows = row_scales(a, b, length)?;
        let left = Side::of(a, &rows, slices, 1)?;
        let inverse = |row: f64| if row == 0.0 { 0.0 } else { 1.0 / row };
        let rows: Vec<f64> = rows.into_iter().map(inverse).collect();
        Some((left, Side::of(b, &rows, slices, slices + 1)?))
    })?;
    let (count, size) = (a.len(), b.len());
    let start = |i: usize| if is_symmetric { i } else { 0 };
    // The rows of AᵀB are the columns of BᵀA.
    let mut part = Mat::<f64>::zeros(size, count);
    let multiply = |a: &Mat<f64>, b: &Mat<f64>, accum: Accum, to: &mut Mat<f64>| {
        let shape = if is_symmetric {
            BlockStructure::TriangularLower
        } else {
            BlockStructure::Rectangular
        };
        let whole = BlockStructure::Rectangular;
        let (b, a) = (b.transpose(), a.as_ref());
        matmul(to.as_mut(), shape, accum, b, whole, a, whole, 1.0, Par::Seq);
    };
    // Highs and lows apart, for vectors of each.
    let [mut high, mut low] = [0, 1].map(|_| vec![0.0; count * size]);
    let mut add = |part: &Mat<f64>| {
        for i in 0..count {
            let row = i * size + start(i)..(i + 1) * size;
            let (high, low) = (&mut high[row.clone()], &mut low[row]);
            let part = &part.col_as_slice(i)[start(i)..];
            Arch::new().dispatch(|| {
                for ((high, low), x) in high.iter_mut().zip(low).zip(part) {
                    let sum = DoubleDouble::new(*high, *low) + DoubleDouble::from(*x);
                    (*high, *low) = (sum.high(), sum.low());
                }
            });
        }
    };
    let behind = (1..=slices).map(|s| (&left.slices[s - 1], &right.tails[slices + 1 - s]));
    for (a, b) in std::iter::once((&left.tails[0], &right.tails[0])).chain(behind) {
        if let (Some(a), Some(b)) = (a, b) {
            multiply(a, b, Accum::Add, &mut part);
        }
    }
    add(&part);
    for s in 1..=slices {
        for t in 1..=slices + 1 - s {
            let (Some(a), Some(b)) = (&left.slices[s - 1], &right.slices[t - 1]) else {
                continue;
            };
            multiply(a, b, Accum::Replace, &mut part);
            add(&part);
        }
    }
    settle();
    let scales = |side: &Side| -> Vec<f64> {
        let each = side.exponents.iter();
        each.map(|power| 1.0.scale(*power)).collect()
    };
    let (of_rows, of_columns) = (scales(&left), scales(&right));
    let mut entries = vec![DoubleDouble::ZERO; count * size];
    for (i, of_row) in of_rows.into_iter().enumerate() {
        for j in start(i)..size {
            let scale = of_row * of_columns[j];
            let entry = DoubleDouble::new(high[i * size + j] * scale, low[i * size + j] * scale);
            entries[i * size + j] = entry;
            if is_symmetric {
                entries[j * size + i] = entry;
            }
        }
    }
    let rounding = Rounding {
        unit: unit(slices, length),
        first: left.sizes,
        second: right.sizes,
    };
    Some((entries, rounding))
}

/// What products of columns of a length err by, relative to their sizes: each of the p + 1 sums in doubles has n terms, whose
/// factors round once each, and they are added; the sums of exact parts round in double-double.
pub(super) fn unit(slices: usize, length: usize) -> f64 {
    let added = slices * (slices + 1) / 2 + 1;
    let sums = (slices + 1) as f64;
    let rounded = 2f64.powi(-53 - slices as i32 * bits(length));
    rounded * sums * (length as f64 + sums + 4.0) + added as f64 * 2f64.powi(-103)
}

/// β for columns of a length.
pub(super) fn bits(length: usize) -> i32 {
    (53 - (usize::BITS - length.leading_zeros()) as i32) / 2
}

/// Whether shapes that belong to such squares of frequencies lose little by [`shorten`].
pub(super) fn are_alike(squares: impl Iterator<Item = f64>) -> bool {
    const MOST: f64 = 1e6;
    let positive = squares.filter(|square| *square > 0.0);
    let (least, most) = positive.fold((f64::INFINITY, 0.0f64), |(least, most), square| {
        (least.min(square), most.max(square))
    });
    most <= MOST * least
}

/// Rounds an approximate column to what two slices hold of it, which saves a third of the products.
pub(super) fn shorten(column: &mut [DoubleDouble]) {
    let Some(power) = exponent(column.iter().map(|x| x.to_f64())) else {
        return;
    };
    let step = 1.5.scale(52 + power - 2 * i64::from(bits(column.len())));
    for x in column {
        *x = DoubleDouble::from((x.high() + step) - step);
    }
}

/// Columns scaled to a largest entry between ½ and 1, in slices.
struct Side {
    /// `None` in place of what is 0, as where they hold all of a double.
    slices: Vec<Option<Mat<f64>>>,
    /// What the first t slices leave, up to all of them.
    tails: Vec<Option<Mat<f64>>>,
    /// 2 to these powers are the scales.
    exponents: Vec<i64>,
    /// The largest of 2^{β(s−1)}‖A_s‖ and 2^{βt}‖a_t‖ in each column, before it was scaled.
    sizes: Vec<f64>,
}

impl Side {
    /// With so many tails, the last ones.
    #[inline(always)]
    fn of(columns: &Columns, rows: &[f64], slices: usize, tails: usize) -> Option<Side> {
        let length = rows.len();
        let bits = bits(length);
        let mut side = Side {
            slices: vec![None; slices],
            tails: vec![None; tails],
            exponents: Vec::with_capacity(columns.len()),
            sizes: Vec::with_capacity(columns.len()),
        };
        let zeros = || Mat::<f64>::zeros(length, columns.len());
        // Highs and lows apart, for vectors of each.
        let [mut high, mut low] = [0, 1].map(|_| vec![0.0; length]);
        for (j, column) in columns.iter().enumerate() {
            let power = exponent(column.iter().zip(rows).map(|(x, row)| x.to_f64() * row))?;
            let factor = 1.0.scale(-power);
            for ((high, low), (x, row)) in
                high.iter_mut().zip(&mut low).zip(column.iter().zip(rows))
            {
                (*high, *low) = (x.high() * row * factor, x.low() * row * factor);
            }
            let mut largest = 0.0f64;
            for t in 0..=slices {
                let unit = 2f64.powi(t as i32 * bits);
                let squares = sum_of_squares(&high);
                // Squares may be 0 of what is not.
                if squares == 0.0 && high.iter().all(|x| *x == 0.0) {
                    break;
                }
                if let Some(at) = (t + tails).checked_sub(slices + 1) {
                    let tail = side.tails[at].get_or_insert_with(zeros);
                    tail.col_as_slice_mut(j).copy_from_slice(&high);
                }
                largest = largest.max(squares.sqrt() * unit);
                if t == slices {
                    break;
                }
                // Added and taken away, it rounds to multiples of 2^{-β(t+1)}.
                let step = 1.5 * 2f64.powi(52 - (t as i32 + 1) * bits);
                let slice = side.slices[t].get_or_insert_with(zeros);
                let slice = slice.col_as_slice_mut(j);
                for (to, (high, low)) in slice.iter_mut().zip(high.iter_mut().zip(&mut low)) {
                    *to = (*high + step) - step;
                    let rest = DoubleDouble::new(*high - *to, *low);
                    (*high, *low) = (rest.high(), rest.low());
                }
                largest = largest.max(sum_of_squares(slice).sqrt() * unit);
            }
            side.exponents.push(power);
            side.sizes.push(largest.scale(power));
        }
        Some(side)
    }
}

/// Powers of 2 that make the rows of A as large as those of B once their columns are scaled; 0 for rows that are 0 in one of
/// them, which add nothing.
#[inline(always)]
fn row_scales(a: &Columns, b: &Columns, length: usize) -> Option<Vec<f64>> {
    let add_nonzero = |mut rows: Vec<bool>, column: &Vec<DoubleDouble>| {
        for (row, x) in rows.iter_mut().zip(column) {
            *row |= x.to_f64() != 0.0;
        }
        rows
    };
    let [in_a, in_b] = [a, b].map(|columns| columns.iter().fold(vec![false; length], add_nonzero));
    let counts: Vec<f64> = in_a
        .into_iter()
        .zip(in_b)
        .map(|(a, b)| if a && b { 1.0 } else { 0.0 })
        .collect();
    let largest = |columns: &Columns| -> Option<Vec<f64>> {
        let mut rows = vec![0.0f64; length];
        for column in columns {
            let sizes = || {
                column
                    .iter()
                    .zip(&counts)
                    .map(|(x, count)| x.to_f64().abs() * count)
            };
            let factor = 1.0.scale(-exponent(sizes())?);
            for (row, size) in rows.iter_mut().zip(sizes()) {
                *row = row.max(size * factor);
            }
        }
        Some(rows)
    };
    let between = |(a, b): (f64, f64)| match a > 0.0 && b > 0.0 {
        true => 1.0.scale(((b / a).log2() / 2.0).trunc() as i64),
        false => 0.0,
    };
    Some(
        largest(a)?
            .into_iter()
            .zip(largest(b)?)
            .map(between)
            .collect(),
    )
}

/// Σx², up to rounding.
#[inline(always)]
fn sum_of_squares(values: &[f64]) -> f64 {
    const LANES: usize = 8;
    let (whole, rest) = values.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for values in whole {
        for (sum, x) in sums.iter_mut().zip(values) {
            *sum += x * x;
        }
    }
    sums.into_iter().chain(rest.iter().map(|x| x * x)).sum()
}

/// k with 2^k above all sizes and 2^(k−1) not, 0 where all are 0; `None` near the ends of the range.
#[inline(always)]
fn exponent(values: impl Iterator<Item = f64>) -> Option<i64> {
    const RANGE: std::ops::Range<i64> = -250..250;
    // In the order of their bits, and what is not finite after all others.
    let bits = values.map(|x| x.abs().to_bits());
    let largest = f64::from_bits(bits.fold(0, u64::max));
    let exponent = largest.magnitude().exponent();
    (largest.is_finite() && RANGE.contains(&exponent)).then_some(exponent)
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_digits::Wide;
    use proptest::prelude::*;

    type Number = Wide<6>;

    const ROUNDED: f64 = 1.0 + 1e-9;

    fn number(x: DoubleDouble) -> Number {
        Number::from(x.high()) + Number::from(x.low())
    }

    /// Columns of numbers in [−1, 1], each times a power of 2 and in rows that differ as much.
    fn columns(
        count: usize,
        length: usize,
        rows: i64,
    ) -> impl Strategy<Value = Vec<Vec<DoubleDouble>>> {
        let entry = (-1.0..1.0f64, -1.0..1.0f64, 0..8u8);
        let column = (prop::collection::vec(entry, length), -60..60i64);
        prop::collection::vec(column, count).prop_map(move |columns| {
            let of = |(entries, scale): (Vec<(f64, f64, u8)>, i64)| {
                let scaled = |(k, (high, low, kind)): (usize, (f64, f64, u8))| {
                    let high = if kind == 0 { 0.0 } else { high };
                    let row = rows * (k as i64 % 5);
                    DoubleDouble::new(high, low * high * 2f64.powi(-54)).scale(scale + row)
                };
                entries.into_iter().enumerate().map(scaled).collect()
            };
            columns.into_iter().map(of).collect()
        })
    }

    #[test]
    fn short_columns_are_what_two_slices_hold() {
        let n = 67;
        let entry = |i: usize| {
            let x = ((i * i * 31 + 7) % 101) as f64 / 101.0 - 0.5;
            DoubleDouble::new(x * 1e-40, x * 1e-60)
        };
        let long: Vec<DoubleDouble> = (0..n).map(entry).collect();
        let mut short = long.clone();
        shorten(&mut short);
        let largest = long
            .iter()
            .fold(0.0f64, |most, x| most.max(x.to_f64().abs()));
        let unit = largest * 2f64.powi(1 - 2 * bits(n));
        let off = |(long, short): (&DoubleDouble, &DoubleDouble)| (*long - *short).to_f64().abs();
        assert!(long.iter().zip(&short).all(|pair| off(pair) <= 0.5 * unit));
        let rows = vec![1.0; n];
        let tails = |column: &[DoubleDouble]| {
            Side::of(&[column.to_vec()], &rows, 2, 1).unwrap().tails[0].is_some()
        };
        assert!(tails(&long) && !tails(&short));
        // What two slices hold entirely takes no more products.
        let whole = products(&[short.clone()], &[short.clone()], 2, true)
            .unwrap()
            .0[0];
        let exact = short.iter().map(|x| number(*x) * number(*x));
        let exact = exact.fold(Number::from(0.0), |sum, term| sum + term);
        assert!((exact - number(whole)).abs().to_f64() <= 1e-31 * whole.to_f64());
        assert!(are_alike([0.0, 1.0, 1e6].into_iter()));
        assert!(!are_alike([1.0, 1.1e6].into_iter()));
    }

    proptest! {
        #[test]
        fn products_are_within_their_bounds(
            a in columns(5, 67, 9),
            b in columns(4, 67, -9),
            slices in 0..=3usize,
        ) {
            let (entries, found) = products(&a, &b, slices, false).expect("products");
            let (own_entries, own) = products(&a, &a, slices, true).expect("products");
            let off = |x: &[DoubleDouble], y: &[DoubleDouble], found: DoubleDouble| {
                let terms = x.iter().zip(y);
                let sum = terms.fold(Number::from(0.0), |sum, (x, y)| sum + number(*x) * number(*y));
                (sum - number(found)).abs().to_f64()
            };
            for (i, x) in a.iter().enumerate() {
                for (j, y) in b.iter().enumerate() {
                    let bound = ROUNDED * found.unit * found.first[i] * found.second[j];
                    prop_assert!(off(x, y, entries[i * 4 + j]) <= bound);
                }
                for (j, y) in a.iter().enumerate() {
                    let (first, second) = (own.first[i.min(j)], own.second[i.max(j)]);
                    let bound = ROUNDED * own.unit * first * second;
                    prop_assert!(off(x, y, own_entries[i * 5 + j]) <= bound);
                }
            }
        }
    }
}
