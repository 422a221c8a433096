//! Products of real matrices with complex vectors, with bounds of what both and their rounding are off by.

use eigentone_digits::{Ball, Magnitude, Real, WideComplex};

use super::refinement::{FLOOR, UPWARD};

/// A real matrix whose entries are known within bounds, by columns.
#[derive(Debug)]
pub(super) struct Columns<T> {
    rows: usize,
    /// The most entries in a row.
    terms: usize,
    columns: Vec<Column<T>>,
}

#[derive(Debug)]
enum Column<T> {
    Full {
        entries: Vec<T>,
        /// Of the entries.
        sizes: Vec<f64>,
        /// How far the entries may be off, or nothing where they are exact.
        radii: Vec<f64>,
    },
    /// Row, entry, its size, and how far it may be off.
    Few(Vec<(usize, T, f64, f64)>),
}

impl<T: Real> Columns<T> {
    /// The square matrix of the real parts of these entries: row, column and entry, each place once; the others are 0. What an
    /// entry may be off by counts although it may be imaginary.
    pub(super) fn of(n: usize, entries: impl Iterator<Item = (usize, usize, Ball<T>)>) -> Self {
        /// A column with a larger part of entries is taken as a whole.
        const FEW: usize = 8;
        let mut columns: Vec<Vec<(usize, T, f64, f64)>> = vec![Vec::new(); n];
        let mut terms = vec![0; n];
        for (row, column, entry) in entries.filter(|(.., entry)| !entry.is_zero()) {
            let (middle, radius) = (entry.middle().re, entry.radius());
            let size = middle.to_f64().abs() * UPWARD + FLOOR;
            let off = match radius.is_zero() {
                true => 0.0,
                false => radius.to_f64() * UPWARD + FLOOR,
            };
            columns[column].push((row, middle, size, off));
            terms[row] += 1;
        }
        let column = |few: Vec<(usize, T, f64, f64)>| {
            if few.len() <= n / FEW {
                return Column::Few(few);
            }
            let (mut entries, mut sizes) = (vec![T::ZERO; n], vec![0.0; n]);
            let is_exact = few.iter().all(|(.., off)| *off == 0.0);
            let mut radii = vec![0.0; if is_exact { 0 } else { n }];
            for (row, middle, size, off) in few {
                (entries[row], sizes[row]) = (middle, size);
                if let Some(radius) = radii.get_mut(row) {
                    *radius = off;
                }
            }
            Column::Full {
                entries,
                sizes,
                radii,
            }
        };
        Columns {
            rows: n,
            terms: terms.into_iter().max().unwrap_or(0),
            columns: columns.into_iter().map(column).collect(),
        }
    }

    /// Whether no entry is other than 0.
    pub(super) fn is_zero(&self) -> bool {
        let mut columns = self.columns.iter();
        columns.all(|column| matches!(column, Column::Few(few) if few.is_empty()))
    }

    /// The product with a vector, in O(1) operations for each entry.
    pub(super) fn times(&self, x: &[Ball<T>]) -> Vec<Ball<T>> {
        let n = self.rows;
        // Terms that are 0 are added exactly.
        let rounding = (self.terms + 2) as f64 * T::unit().to_f64();
        let (mut re, mut im) = (vec![T::ZERO; n], vec![T::ZERO; n]);
        let mut errors = vec![n as f64 * FLOOR; n];
        let (mut real, mut imaginary) = (Vec::new(), Vec::new());
        for (column, x) in self.columns.iter().zip(x).filter(|(_, x)| !x.is_zero()) {
            let (middle, radius) = (x.middle(), x.radius());
            let size = middle.norm() * UPWARD + FLOOR;
            let radius = match radius.is_zero() {
                true => 0.0,
                false => radius.to_f64() * UPWARD + FLOOR,
            };
            let (by_size, by_radius) = (rounding * size + radius, size + radius);
            match column {
                Column::Few(few) => {
                    for &(row, entry, size, off) in few {
                        re[row] = re[row] + entry * middle.re;
                        im[row] = im[row] + entry * middle.im;
                        errors[row] += size * by_size + off * by_radius;
                    }
                }
                Column::Full {
                    entries,
                    sizes,
                    radii,
                } => {
                    for (terms, part) in [(&mut real, middle.re), (&mut imaginary, middle.im)] {
                        if !part.is_zero() {
                            terms.push((part, &entries[..]));
                        }
                    }
                    for (error, size) in errors.iter_mut().zip(sizes) {
                        *error += size * by_size;
                    }
                    for (error, off) in errors.iter_mut().zip(radii) {
                        *error += off * by_radius;
                    }
                }
            }
        }
        T::add_multiples(&mut re, &real);
        T::add_multiples(&mut im, &imaginary);
        let middles = re
            .into_iter()
            .zip(im)
            .map(|(re, im)| WideComplex { re, im });
        let all = middles.zip(errors);
        all.map(|(middle, error)| Ball::new(middle, Magnitude::from(error * UPWARD)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use eigentone_digits::{DoubleDouble, Wide};

    use super::super::random::Random;
    use super::*;

    fn ball<T: Real>(re: f64, im: f64, radius: f64) -> Ball<T> {
        Ball::new(WideComplex::new(re, im), radius.into())
    }

    /// Of the middles and of what is within the radii, with columns of all kinds.
    #[test]
    fn products_enclose_those_of_more_digits() {
        let mut numbers = Random(5);
        for n in [1, 7, 20, 41] {
            let mut entries = Vec::new();
            for row in 0..n {
                for column in 0..n {
                    if column % 3 == 0 || row == column {
                        let radius = if column % 2 == 0 { 0.0 } else { 1e-14 };
                        entries.push((row, column, numbers.signed(), radius));
                    }
                }
            }
            let x: Vec<[f64; 3]> = (0..n)
                .map(|i| {
                    let off = if i % 4 == 0 { 1e-13 } else { 0.0 };
                    [numbers.signed(), numbers.signed() * (i % 2) as f64, off]
                })
                .collect();
            let own = entries.iter();
            let own = own.map(|&(i, j, entry, off)| (i, j, ball::<DoubleDouble>(entry, 0.0, off)));
            let matrix = Columns::of(n, own);
            assert!(!matrix.is_zero());
            let vector: Vec<_> = x.iter().map(|[re, im, off]| ball(*re, *im, *off)).collect();
            let product = matrix.times(&vector);
            for side in [-1.0, 0.0, 1.0] {
                let mut truth = vec![Ball::<Wide<8>>::ZERO; n];
                let mut size = vec![0.0; n];
                for &(i, j, entry, off) in &entries {
                    let [re, im, moved] = x[j];
                    let own = ball::<Wide<8>>(entry, 0.0, 0.0) + ball(side * off, 0.0, 0.0);
                    let other = ball::<Wide<8>>(re, im, 0.0) + ball(side * moved, 0.0, 0.0);
                    truth[i] = truth[i] + own * other;
                    size[i] += entry.abs() * moved + off * (re.abs() + im.abs() + moved);
                }
                for ((truth, found), size) in truth.iter().zip(&product).zip(size) {
                    let middle = found.middle();
                    let wide =
                        |part: DoubleDouble| Wide::from(part.high()) + Wide::from(part.low());
                    let middle = WideComplex {
                        re: wide(middle.re),
                        im: wide(middle.im),
                    };
                    let off = (*truth - Ball::from(middle)).upper();
                    assert!(off <= found.radius(), "{n} {side}: {off:?} {found:?}");
                    assert!(found.radius().to_f64() <= 1.5 * size + 1e-28 * n as f64);
                }
            }
        }
        assert!(Columns::<f64>::of(3, std::iter::empty()).is_zero());
    }
}
