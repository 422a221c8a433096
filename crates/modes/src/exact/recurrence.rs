//! The shortest linear recurrence of a sequence modulo a prime.

use super::prime_field::{PrimeField, Residue};

/// The order of the shortest linear recurrence that a sequence obeys (Massey 1969, *IEEE Trans. Inf. Theory* 15). For the
/// sequence uᵀAᵏb no more than the rank of b, Ab, A²b, …: its Hankel matrix, whose rank the order is, is a product with them.
pub(crate) fn order(field: &PrimeField, sequence: &[Residue]) -> usize {
    let one = field.integer(1);
    // Σ c_j s_{k−j} = 0, and the one before the last change of the order, with what it left.
    let (mut now, mut before) = (vec![one], vec![one]);
    let (mut order, mut since, mut scale) = (0, 1, one);
    for k in 0..sequence.len() {
        let terms = now.iter().zip(sequence[..=k].iter().rev());
        let left = terms.fold(Residue::ZERO, |sum, (&c, &s)| {
            field.sum(sum, field.product(c, s))
        });
        if left.is_zero() {
            since += 1;
            continue;
        }
        let factor = field.negative(field.product(left, scale));
        let longer = 2 * order <= k;
        let old = longer.then(|| now.clone());
        now.resize(now.len().max(before.len() + since), Residue::ZERO);
        for (c, &b) in now[since..].iter_mut().zip(&before) {
            *c = field.sum(*c, field.product(factor, b));
        }
        match old {
            Some(old) => {
                order = k + 1 - order;
                (before, since, scale) = (old, 1, field.inverse(left));
            }
            None => since += 1,
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sequences_of_known_order() {
        let field = PrimeField::first();
        let of = |next: &dyn Fn(u64) -> u64| -> usize {
            let sequence: Vec<Residue> = (0..20).map(|k| field.integer(next(k))).collect();
            order(&field, &sequence)
        };
        assert_eq!(of(&|_| 0), 0);
        assert_eq!(of(&|_| 7), 1);
        assert_eq!(of(&|k| 3u64.pow(k as u32)), 1);
        assert_eq!(of(&|k| 3u64.pow(k as u32) + 2u64.pow(k as u32)), 2);
        assert_eq!(of(&|k| k * k), 3);
        assert_eq!(of(&|k| u64::from(k == 4)), 5);
        // Fibonacci's numbers.
        assert_eq!(of(&|k| (0..k).fold((0, 1), |(a, b), _| (b, a + b)).0), 2);
    }
}
