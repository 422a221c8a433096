//! K − Ω²M + iΩC in ball arithmetic, from the elements.

use std::collections::BTreeMap;

use eigentone_digits::{Ball, Real, WideComplex};
use eigentone_modes::{MatrixKind, System};

use super::elimination::{Row, scaled};

/// The doubles whose exact sums are an entry of K, C and M.
type Terms = [Vec<f64>; 3];

/// K − Ω²M + iΩC of the coordinates that chosen ones are joined to, as sums of doubles.
pub(super) struct DynamicStiffness {
    frequency: f64,
    /// The coordinates it is about, rising.
    coordinates: Vec<usize>,
    /// By row and column, both as positions in `coordinates`.
    entries: BTreeMap<(usize, usize), Terms>,
}

impl DynamicStiffness {
    /// Of all coordinates that any of `from` is joined to, be it through others. The rest moves by
    /// itself, which no load on `from` changes.
    pub(super) fn of(system: &System, frequency: f64, from: &[usize]) -> DynamicStiffness {
        let whole = entries(system);
        let mut reached = vec![false; system.len()];
        let mut joined = vec![Vec::new(); system.len()];
        for &(row, column) in whole.keys() {
            joined[row].push(column);
            joined[column].push(row);
        }
        let mut waiting = from.to_vec();
        while let Some(next) = waiting.pop() {
            if !std::mem::replace(&mut reached[next], true) {
                waiting.extend(&joined[next]);
            }
        }
        let coordinates: Vec<usize> = (0..system.len()).filter(|i| reached[*i]).collect();
        let place = |i: usize| coordinates.binary_search(&i).ok();
        let within = whole.into_iter().filter_map(|((row, column), terms)| {
            let place = (place(row)?, place(column)?);
            Some((place, terms))
        });
        DynamicStiffness {
            frequency,
            entries: within.collect(),
            coordinates,
        }
    }

    /// The coordinates that it is about, rising.
    pub(super) fn coordinates(&self) -> &[usize] {
        &self.coordinates
    }

    /// Its rows in the precision of T, and the powers of two by which row and column are divided so
    /// that the largest entry of each is about 1.
    pub(super) fn rows<T: Real>(&self) -> (Vec<Row<T>>, Vec<i64>) {
        let n = self.coordinates.len();
        let factors = self.factors::<T>();
        let sum = |terms: &[f64]| {
            let terms = terms.iter().map(|term| real::<T>(*term));
            terms.fold(Ball::ZERO, |sum, term| sum + term)
        };
        let values = self.entries.iter().map(|(place, terms)| {
            let parts = terms.iter().zip(factors);
            let parts = parts.filter(|(terms, _)| !terms.is_empty());
            let value = parts.fold(Ball::ZERO, |value, (terms, factor)| {
                value + sum(terms) * factor
            });
            (*place, value)
        });
        let values: Vec<((usize, usize), Ball<T>)> = values.collect();
        let mut largest = vec![None; n];
        for ((row, column), value) in &values {
            let size = value.upper();
            if !size.is_zero() && size.is_finite() {
                for at in [*row, *column] {
                    largest[at] = largest[at].max(Some(size.exponent()));
                }
            }
        }
        let exponents: Vec<i64> = largest
            .into_iter()
            .map(|exponent| exponent.unwrap_or(0).div_euclid(2))
            .collect();
        let mut rows = vec![Row::new(); n];
        for ((row, column), value) in values {
            let down = -(exponents[row] + exponents[column]);
            rows[row].push((column, scaled(value, down)));
        }
        (rows, exponents)
    }

    /// k such that the determinant, unless it is 0, is at least 2^k: every entry of a row is a
    /// Gaussian integer times one power of two, so their products are.
    pub(super) fn grain(&self) -> i64 {
        let frequency = if self.frequency == 0.0 {
            0
        } else {
            last_bit(self.frequency)
        };
        let mut rows = vec![None; self.coordinates.len()];
        for ((row, _), terms) in &self.entries {
            for (power, terms) in terms.iter().enumerate() {
                for term in terms {
                    let bit = last_bit(*term) + power as i64 * frequency;
                    rows[*row] = Some(rows[*row].map_or(bit, |least: i64| least.min(bit)));
                }
            }
        }
        rows.into_iter().flatten().sum()
    }

    /// What K, C and M are multiplied by: 1, iΩ and −Ω².
    fn factors<T: Real>(&self) -> [Ball<T>; 3] {
        let frequency = real::<T>(self.frequency);
        let turned = Ball::from(WideComplex {
            re: T::ZERO,
            im: T::from(self.frequency),
        });
        [real(1.0), turned, -(frequency * frequency)]
    }
}

/// The entries of K, C and M that are not always zero, as sums of doubles.
fn entries(system: &System) -> BTreeMap<(usize, usize), Terms> {
    let mut entries: BTreeMap<(usize, usize), Terms> = BTreeMap::new();
    let kinds = [MatrixKind::Stiffness, MatrixKind::Damping, MatrixKind::Mass];
    for (power, kind) in kinds.into_iter().enumerate() {
        for term in system.terms(kind) {
            let entry = entries.entry((term.row, term.column)).or_default();
            entry[power].push(term.value);
        }
    }
    entries
}

/// A double, exactly.
fn real<T: Real>(value: f64) -> Ball<T> {
    Ball::from(WideComplex {
        re: T::from(value),
        im: T::ZERO,
    })
}

/// The largest k for which a nonzero double is a whole multiple of 2^k.
fn last_bit(value: f64) -> i64 {
    const MANTISSA: u64 = (1 << 52) - 1;
    let bits = value.to_bits();
    let (biased, fraction) = ((bits >> 52) as i64 & 0x7ff, bits & MANTISSA);
    match biased {
        0 => i64::from(fraction.trailing_zeros()) - 1074,
        _ => biased - 1075 + i64::from((fraction | (1 << 52)).trailing_zeros()),
    }
}

#[cfg(test)]
mod tests {
    use super::last_bit;

    #[test]
    fn the_last_bit_of_a_double() {
        let cases = [
            (1.0, 0),
            (-6.0, 1),
            (0.75, -2),
            (5e-324, -1074),
            (f64::MIN_POSITIVE, -1022),
            (1e22, 22),
            (f64::MAX, 971),
        ];
        for (value, bit) in cases {
            assert_eq!(last_bit(value), bit, "{value:e}");
        }
    }
}
