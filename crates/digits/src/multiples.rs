//! Multiples of rows of double-doubles added to a row, in the processor's vector registers where it has them.

use pulp::{Arch, Simd, WithSimd};

use crate::DoubleDouble;
use crate::double_double::two_sum;

/// [`Real::add_multiples`](crate::Real::add_multiples). Up to 8 terms at a time are summed as in
/// [`Lanes::products`](crate::Lanes::products), and these sums in double-double: m terms err by (m + 4)²/16 units of
/// 2^-102, at most m + 1 for m in 1, 2, 4 and 8, and each sum after the first by one more.
pub(crate) fn add_multiples(sum: &mut [DoubleDouble], terms: &[Term<'_>]) {
    Arch::new().dispatch(AddMultiples { sum, terms });
}

/// A factor and what it multiplies.
type Term<'a> = (DoubleDouble, &'a [DoubleDouble]);

struct AddMultiples<'a> {
    sum: &'a mut [DoubleDouble],
    terms: &'a [Term<'a>],
}

impl WithSimd for AddMultiples<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let AddMultiples { sum, terms } = self;
        // Processors with vectors of doubles fuse multiplications and additions.
        if S::F64_LANES > 1 {
            let rest = add::<8>(sum, terms);
            let rest = add::<4>(sum, rest);
            let rest = add::<2>(sum, rest);
            add::<1>(sum, rest);
            return;
        }
        for (factor, entries) in terms {
            for (sum, entry) in sum.iter_mut().zip(*entries) {
                *sum += *factor * *entry;
            }
        }
    }
}

/// Adds M terms at a time; those that are left.
#[inline(always)]
fn add<'a, const M: usize>(sum: &mut [DoubleDouble], terms: &'a [Term<'a>]) -> &'a [Term<'a>] {
    let (chunks, rest) = terms.as_chunks::<M>();
    for terms in chunks {
        let entries = terms.map(|(_, entries)| &entries[..sum.len()]);
        for (i, sum) in sum.iter_mut().enumerate() {
            let (mut high, mut low) = product(terms[0].0, entries[0][i]);
            for k in 1..M {
                let (next, small) = product(terms[k].0, entries[k][i]);
                let (total, rounding) = two_sum(high, next);
                (high, low) = (total, low + (rounding + small));
            }
            *sum += DoubleDouble::new(high, low);
        }
    }
    rest
}

/// The product of the high parts, and all that is small beside it.
#[inline(always)]
fn product(a: DoubleDouble, b: DoubleDouble) -> (f64, f64) {
    let product = a.high() * b.high();
    let error = a.high().mul_add(b.high(), -product);
    (product, error + (a.high() * b.low() + a.low() * b.high()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Real;
    use crate::rational::{Exact, integer};
    use num_bigint::BigInt;
    use num_rational::BigRational;
    use num_traits::Signed;
    use proptest::prelude::*;

    fn number() -> impl Strategy<Value = DoubleDouble> {
        (-1.0..1.0, -1.0..1.0, -300..300).prop_map(|(high, low, exponent): (f64, f64, i32)| {
            let scale = 2f64.powi(exponent);
            DoubleDouble::new(high * scale, low * scale * 2f64.powi(-54))
        })
    }

    proptest! {
        /// Whatever the number of entries leaves beside whole registers.
        #[test]
        fn vectors_and_operators_agree_to_the_last_bit(
            rows in prop::collection::vec((number(), number()), 0..21),
            factor in number(),
        ) {
            let (mut sum, entries): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
            let known: Vec<DoubleDouble> =
                sum.iter().zip(&entries).map(|(sum, entry)| *sum + factor * *entry).collect();
            DoubleDouble::add_multiple(&mut sum, factor, &entries);
            prop_assert_eq!(sum, known);
        }

        /// In one call or two, and where terms cancel.
        #[test]
        fn sums_are_within_their_bound(
            terms in prop::collection::vec((number(), prop::collection::vec(number(), 5)), 1..21),
            first in 0..20usize,
            cancels in any::<bool>(),
        ) {
            let mut terms = terms;
            if cancels && terms.len() > 1 {
                let (factor, entries) = terms[0].clone();
                *terms.last_mut().expect("a term") = (-factor, entries);
            }
            let given: Vec<Term<'_>> =
                terms.iter().map(|(factor, entries)| (*factor, &entries[..])).collect();
            let (one, other) = given.split_at(first.min(given.len()));
            let mut sums = vec![DoubleDouble::ZERO; 5];
            add_multiples(&mut sums, one);
            add_multiples(&mut sums, other);
            let units = BigRational::from(BigInt::from(terms.len() + 2));
            let unit = integer(1.into(), DoubleDouble::UNIT_LOG2.into());
            for (i, sum) in sums.iter().enumerate() {
                let exact = terms.iter().map(|(factor, entries)| factor.exact() * entries[i].exact());
                let size: BigRational = exact.clone().map(|term| term.abs()).sum();
                let off = (sum.exact() - exact.sum::<BigRational>()).abs();
                prop_assert!(off <= &units * &unit * size);
            }
        }
    }

    /// Where splitting overflows, the result is the same, finite or not.
    #[test]
    fn the_ends_of_the_range_agree() {
        for (factor, entry) in [
            (2f64.powi(1000), 3.0),
            (1e300, 1e8),
            (1e300, 1e9),
            (f64::INFINITY, 1.0),
        ] {
            let (factor, entry) = (DoubleDouble::from(factor), DoubleDouble::from(entry));
            let known = DoubleDouble::from(0.1) + factor * entry;
            let is_finite = known.high().is_finite() && known.low().is_finite();
            let entries = [entry; 5];
            for terms in [1, 2, 9] {
                let mut sum = [DoubleDouble::from(0.1); 5];
                let mut all = vec![(DoubleDouble::ZERO, &[DoubleDouble::ONE; 5][..]); terms];
                all[terms / 2] = (factor, &entries[..]);
                add_multiples(&mut sum, &all);
                for sum in sum {
                    assert_eq!(sum.high().is_finite() && sum.low().is_finite(), is_finite);
                    assert!(!is_finite || sum == known);
                }
            }
        }
    }
}
