//! Square matrices of fixed-point numbers with one radius for all entries.

use num_bigint::{BigInt, BigUint};
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Zero};

use super::ball::shift_right;
use super::limbs::{Limbs, dot};
use super::pi_polynomial::PiMatrix;

/// From so many bits on, products by hand take longer than the faster ways of `num-bigint`.
const LONG: u64 = 1024;

/// Each entry is known to lie within `radius` of a whole number, both in units of 2^−`bits`.
#[derive(Clone, Debug)]
pub(super) struct FixedMatrix {
    pub(super) order: usize,
    pub(super) bits: u64,
    /// By rows.
    pub(super) entries: Vec<BigInt>,
    pub(super) radius: BigUint,
}

impl FixedMatrix {
    pub(super) fn identity(order: usize, bits: u64) -> FixedMatrix {
        let mut entries = vec![BigInt::zero(); order * order];
        for i in 0..order {
            entries[i * order + i] = BigInt::one() << bits;
        }
        FixedMatrix {
            order,
            bits,
            entries,
            radius: BigUint::zero(),
        }
    }

    /// `matrix` times `factor`, cut to `bits` bits after the point.
    pub(super) fn cut(matrix: &PiMatrix, factor: &BigRational, bits: u64) -> FixedMatrix {
        let order = matrix.nrows();
        let mut entries = vec![BigInt::zero(); order * order];
        let mut radius = BigUint::one();
        for (i, j, entry) in matrix.nonzeros() {
            let at = &mut entries[i * order + j];
            match entry.rational() {
                Some(entry) => {
                    let numerator = (entry.numer() * factor.numer()) << bits;
                    *at = numerator.div_floor(&(entry.denom() * factor.denom()));
                }
                None => {
                    let entry = (entry * factor).ball(bits + 32);
                    let (midpoint, off) = entry.in_units(-(bits as i64));
                    *at = midpoint;
                    radius = radius.max(off);
                }
            }
        }
        FixedMatrix {
            order,
            bits,
            entries,
            radius,
        }
    }

    fn row(&self, i: usize) -> &[BigInt] {
        &self.entries[i * self.order..(i + 1) * self.order]
    }

    /// The sum of sizes along row `i`.
    pub(super) fn row_sum(&self, i: usize) -> BigUint {
        self.row(i).iter().map(BigInt::magnitude).sum()
    }

    /// The largest sum of sizes along a row.
    pub(super) fn row_norm(&self) -> BigUint {
        let sums = (0..self.order).map(|i| self.row_sum(i));
        sums.max().unwrap_or_default()
    }

    /// Upper bounds of the sizes of all entries, without a radius.
    pub(super) fn sizes(mut self) -> FixedMatrix {
        for entry in &mut self.entries {
            *entry = BigInt::from(entry.magnitude() + &self.radius);
        }
        self.radius = BigUint::zero();
        self
    }

    fn column_norm(&self) -> BigUint {
        let size = |i: usize, j: usize| self.entries[i * self.order + j].magnitude();
        let sum = |j| (0..self.order).map(|i| size(i, j)).sum::<BigUint>();
        (0..self.order).map(sum).max().unwrap_or_default()
    }

    /// The product; errors are bounded by
    /// |(A + δA)(B + δB) − AB| ≤ ‖A‖_∞ max|δB| + max|δA| ‖B‖_1 + n max|δA| max|δB| in each entry.
    pub(super) fn times(&self, other: &FixedMatrix) -> FixedMatrix {
        let n = self.order;
        let mut radius = self.row_norm() * &other.radius + &self.radius * other.column_norm();
        radius += &self.radius * &other.radius * n;
        let sums = match self.bits.max(other.bits) > LONG {
            true => self.long_sums(other),
            false => self.short_sums(other),
        };
        let entries = sums.into_iter().map(|sum| sum >> self.bits).collect();
        FixedMatrix {
            order: n,
            bits: self.bits,
            entries,
            radius: (radius >> self.bits) + 2u8,
        }
    }

    /// The entries of the product before they are cut, for numbers of a few limbs.
    fn short_sums(&self, other: &FixedMatrix) -> Vec<BigInt> {
        let n = self.order;
        let rows = Limbs::of(self.entries.iter());
        let transposed = (0..n * n).map(|index| &other.entries[index % n * n + index / n]);
        let columns = Limbs::of(transposed);
        let mut sums = Vec::with_capacity(n * n);
        for i in 0..n {
            let row = self.row(i);
            let filled: Vec<usize> = (0..n).filter(|k| !row[*k].is_zero()).collect();
            sums.extend((0..n).map(|j| dot((&rows, i * n), (&columns, j * n), &filled)));
        }
        sums
    }

    /// The same for long ones.
    fn long_sums(&self, other: &FixedMatrix) -> Vec<BigInt> {
        let n = self.order;
        let mut sums = vec![BigInt::zero(); n * n];
        for (index, left) in self.entries.iter().enumerate() {
            let sums = &mut sums[index / n * n..][..n];
            for (sum, right) in sums.iter_mut().zip(other.row(index % n)) {
                if !left.is_zero() && !right.is_zero() {
                    *sum += left * right;
                }
            }
        }
        sums
    }

    pub(super) fn plus(mut self, other: &FixedMatrix) -> FixedMatrix {
        for (entry, more) in self.entries.iter_mut().zip(&other.entries) {
            *entry += more;
        }
        self.radius += &other.radius;
        self
    }

    pub(super) fn divided(mut self, divisor: u32) -> FixedMatrix {
        for entry in self.entries.iter_mut().filter(|entry| !entry.is_zero()) {
            *entry /= divisor;
        }
        self.radius = self.radius / divisor + 2u8;
        self
    }

    /// The matrix, unless its radius exceeds 1 and every entry: squares of that would only grow.
    pub(super) fn known(self) -> Option<FixedMatrix> {
        let useful = self.radius < self.row_norm().max(BigUint::one() << self.bits);
        useful.then_some(self)
    }

    /// Upper bounds of |A| v for a vector v of bounds, in units of 2^−`bits`.
    pub(super) fn carry(&self, bounds: &[BigUint]) -> Vec<BigUint> {
        let row = |i| {
            let terms = self.row(i).iter().zip(bounds);
            let sum: BigUint = terms
                .map(|(entry, v)| (entry.magnitude() + &self.radius) * v)
                .sum();
            (sum >> self.bits) + 1u8
        };
        (0..self.order).map(row).collect()
    }

    /// Whether no entry can be distinguished from 0.
    pub(super) fn vanishes(&self) -> bool {
        self.entries
            .iter()
            .all(|entry| *entry.magnitude() <= self.radius)
    }

    /// Adds to the state z, in units of its own, what makes it the image of z; the most by which
    /// one component is off because of this step.
    pub(super) fn advance(&self, state: &mut [BigInt]) -> BigUint {
        let size: BigUint = state.iter().map(BigInt::magnitude).sum();
        let mut lost = &self.radius * size;
        let image = (0..self.order).map(|i| {
            let terms = self.row(i).iter().zip(state.iter());
            let terms = terms.filter(|(entry, value)| !entry.is_zero() && !value.is_zero());
            terms.map(|(entry, value)| entry * value).sum::<BigInt>()
        });
        let image: Vec<BigInt> = image.collect();
        let mut exact = true;
        for (component, product) in state.iter_mut().zip(image) {
            exact &= product
                .trailing_zeros()
                .is_none_or(|zeros| zeros >= self.bits);
            *component = product >> self.bits;
        }
        if !exact {
            lost += BigUint::one() << self.bits;
        }
        shift_right(&BigInt::zero(), &lost, self.bits).1
    }
}
