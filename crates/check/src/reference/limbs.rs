//! Sums of products of whole numbers without an allocation for each: what most of the time of a
//! matrix product would go to.

use num_bigint::{BigInt, BigUint, Sign};

/// Whole numbers as rows of 64-bit limbs, lowest first.
pub(super) struct Limbs {
    limbs: Vec<u64>,
    width: usize,
    /// For each number, how many limbs it needs, and whether it is negative.
    sizes: Vec<(usize, bool)>,
}

impl Limbs {
    pub(super) fn of<'a>(numbers: impl Iterator<Item = &'a BigInt> + Clone) -> Limbs {
        let width = numbers.clone().map(|number| number.bits().div_ceil(64));
        let width = width.max().unwrap_or(0) as usize;
        let mut limbs = Vec::new();
        let mut sizes = Vec::new();
        for number in numbers {
            let start = limbs.len();
            limbs.extend(number.iter_u64_digits());
            sizes.push((limbs.len() - start, number.sign() == Sign::Minus));
            limbs.resize(start + width, 0);
        }
        Limbs {
            limbs,
            width,
            sizes,
        }
    }

    fn get(&self, index: usize) -> (&[u64], bool) {
        let (size, negative) = self.sizes[index];
        let start = index * self.width;
        (&self.limbs[start..start + size], negative)
    }
}

/// Σ a_k b_k over the places given of two stretches of the lists, which start at the given positions.
pub(super) fn dot(a: (&Limbs, usize), b: (&Limbs, usize), places: &[usize]) -> BigInt {
    // Room for the sum of 2^64 products.
    let width = a.0.width + b.0.width + 1;
    let mut sums = [Vec::new(), Vec::new()];
    for k in places {
        let ((x, x_negative), (y, y_negative)) = (a.0.get(a.1 + k), b.0.get(b.1 + k));
        if !x.is_empty() && !y.is_empty() {
            let sum = &mut sums[usize::from(x_negative != y_negative)];
            sum.resize(width, 0);
            add_product(sum, x, y);
        }
    }
    let [plus, minus] = sums.map(|sum| {
        let halves = sum
            .iter()
            .flat_map(|limb| [*limb as u32, (*limb >> 32) as u32]);
        BigInt::from(BigUint::new(halves.collect()))
    });
    plus - minus
}

/// Adds a·b to a sum that is wide enough, as one does by hand.
fn add_product(sum: &mut [u64], a: &[u64], b: &[u64]) {
    for (shift, x) in a.iter().enumerate() {
        let mut carry = 0;
        let (low, high) = sum[shift..].split_at_mut(b.len());
        for (limb, y) in low.iter_mut().zip(b) {
            let total = u128::from(*x) * u128::from(*y) + u128::from(*limb) + u128::from(carry);
            (*limb, carry) = (total as u64, (total >> 64) as u64);
        }
        for limb in high {
            if carry == 0 {
                break;
            }
            let (total, overflow) = limb.overflowing_add(carry);
            (*limb, carry) = (total, u64::from(overflow));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_traits::{One, Zero};

    #[test]
    fn carries_run_through() {
        let most: BigInt = (BigInt::one() << 256) - 1;
        let numbers = [
            most.clone(),
            -&most,
            most.clone(),
            BigInt::zero(),
            most.clone(),
        ];
        let limbs = Limbs::of(numbers.iter());
        let expected: BigInt = numbers.iter().map(|number| number * number).sum();
        assert_eq!(dot((&limbs, 0), (&limbs, 0), &[0, 1, 2, 3, 4]), expected);
        assert_eq!(dot((&limbs, 0), (&limbs, 1), &[0]), -(&most * &most));
        assert_eq!(dot((&limbs, 3), (&limbs, 3), &[0]), BigInt::zero());
    }
}
