//! Several double-double sums at a time.

use crate::DoubleDouble;
use crate::double_double::{split, two_sum};

/// L numbers side by side, highs apart from lows, so that one instruction serves several of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lanes<const L: usize> {
    high: [f64; L],
    low: [f64; L],
}

impl<const L: usize> Lanes<L> {
    /// All 0.
    pub const ZERO: Lanes<L> = Lanes {
        high: [0.0; L],
        low: [0.0; L],
    };

    /// Sets one of the numbers.
    ///
    /// # Panics
    /// If `lane` is not below L.
    pub fn set(&mut self, lane: usize, value: DoubleDouble) {
        (self.high[lane], self.low[lane]) = (value.high(), value.low());
    }

    /// Σ_k row_k · columns_k in every lane. As long as nothing overflows, each is off by at most
    /// (n + 4)²·2^-106 Σ|row_k||columns_k|, n being the number of terms, up to 2^20, and by 2^-1060 for each
    /// term where error terms underflow.
    ///
    /// The high parts are summed with their exact errors, and all that is small is summed in doubles (Ogita, Rump
    /// & Oishi 2005, *Accurate sum and dot product*, SIAM J. Sci. Comput. 26, algorithm 5.3, with the
    /// low parts of the factors added). With u = 2^-53 and S the sum of absolute products, the small
    /// terms are at most u(S + 4|p_k|) each, so that their sum rounds by no more than (n²/2 + 5n + 12) u²S.
    ///
    /// `FUSED` says how the error of a product is found: by a multiplication and an addition that are rounded once,
    /// which is quick only in code that is compiled for processors with such an instruction, or by splitting the
    /// factors. Both are exact, and as long as nothing under- or overflows the sums agree to the last bit.
    #[inline(always)]
    pub fn products<const FUSED: bool>(
        row: &[DoubleDouble],
        columns: &[Lanes<L>],
    ) -> [DoubleDouble; L] {
        let mut sum = Lanes::<L>::ZERO;
        for (factor, entries) in row.iter().zip(columns) {
            sum.add_product::<FUSED>(*factor, entries);
        }
        if sum.high.iter().chain(&sum.low).all(|part| part.is_finite()) {
            return std::array::from_fn(|lane| DoubleDouble::new(sum.high[lane], sum.low[lane]));
        }
        // The splitting overflows above 2^996, where the operators go another way.
        std::array::from_fn(|lane| {
            let terms = row.iter().zip(columns);
            terms.fold(DoubleDouble::ZERO, |sum, (factor, entries)| {
                sum + *factor * DoubleDouble::new(entries.high[lane], entries.low[lane])
            })
        })
    }

    /// So many terms [`sparse_products`](Self::sparse_products) sums at once.
    pub const AT_ONCE: usize = 16;

    /// Σ factor · columns_k over terms (k, factor) in every lane. As long as nothing overflows, each is off by at most
    /// ((m + 4)²/16 + ⌊n/m⌋)·2^-102 Σ|factor||columns_k| for n terms, m = [`AT_ONCE`](Self::AT_ONCE) or n if that is
    /// less, and by 2^-1060 for each term where error terms underflow.
    ///
    /// m at a time are summed as in [`products`](Self::products), and these sums in double-double.
    ///
    /// # Panics
    /// If there is no column k.
    #[inline(always)]
    pub fn sparse_products<const FUSED: bool>(
        terms: &[(usize, f64)],
        columns: &[Lanes<L>],
    ) -> [DoubleDouble; L] {
        let mut sums = [DoubleDouble::ZERO; L];
        for terms in terms.chunks(Self::AT_ONCE) {
            let mut part = Lanes::<L>::ZERO;
            for (k, factor) in terms {
                part.add_product::<FUSED>(DoubleDouble::from(*factor), &columns[*k]);
            }
            for (lane, sum) in sums.iter_mut().enumerate() {
                *sum += match part.high[lane].is_finite() && part.low[lane].is_finite() {
                    true => DoubleDouble::new(part.high[lane], part.low[lane]),
                    // The splitting overflows above 2^996, where the operators go another way.
                    false => terms.iter().fold(DoubleDouble::ZERO, |sum, (k, factor)| {
                        let entries = &columns[*k];
                        sum + DoubleDouble::new(entries.high[lane], entries.low[lane]) * *factor
                    }),
                };
            }
        }
        sums
    }

    /// Adds factor·(first − second)² in every lane. A sum of n such terms is off by at most
    /// (n + 8)²·2^-106 of that of their sizes, n up to 2^20, and by 2^-1060 for each term where error terms
    /// underflow, as long as nothing comes near the ends of the range: above 2^450 the splitting of doubles
    /// can overflow, which leaves what is not finite.
    ///
    /// The difference is s + e exactly, its square s² + 2se but for e², below 2^-106 of it. What is small
    /// is summed in doubles, as in [`products`](Self::products).
    #[inline(always)]
    pub fn add_square(&mut self, factor: f64, first: &[f64; L], second: &[f64; L]) {
        let (f1, f2) = split(factor);
        for lane in 0..L {
            let (s, e) = two_sum(first[lane], -second[lane]);
            let (s1, s2) = split(s);
            let square = s * s;
            let rest = ((s1 * s1 - square) + 2.0 * s1 * s2) + s2 * s2 + 2.0 * s * e;
            self.add_part(lane, (factor, f1, f2), square, rest);
        }
    }

    /// Adds factor·z² in every lane of the real parts and `imaginary`, z being the complex difference first − second,
    /// with real parts before imaginary ones. What holds of [`add_square`](Self::add_square) holds of both parts, off by
    /// no more than the same share of the sum of |factor||z|².
    ///
    /// With z = (s + e) + i(t + d) exactly, Re z² = s² − t² + 2(se − td) and Im z² = 2(st + sd + te) but for
    /// products of e and d.
    #[inline(always)]
    pub fn add_complex_square(
        &mut self,
        imaginary: &mut Lanes<L>,
        factor: f64,
        first: &[[f64; L]; 2],
        second: &[[f64; L]; 2],
    ) {
        let (f1, f2) = split(factor);
        for lane in 0..L {
            let (s, e) = two_sum(first[0][lane], -second[0][lane]);
            let (t, d) = two_sum(first[1][lane], -second[1][lane]);
            let (s1, s2) = split(s);
            let (t1, t2) = split(t);
            let (ss, tt, st) = (s * s, t * t, s * t);
            let ss_error = ((s1 * s1 - ss) + 2.0 * s1 * s2) + s2 * s2;
            let tt_error = ((t1 * t1 - tt) + 2.0 * t1 * t2) + t2 * t2;
            let st_error = ((s1 * t1 - st) + s1 * t2 + s2 * t1) + s2 * t2;
            let (real, real_error) = two_sum(ss, -tt);
            let real_rest = real_error + (ss_error - tt_error) + 2.0 * (s * e - t * d);
            let twice = 2.0 * st;
            let twice_rest = 2.0 * (st_error + s * d + t * e);
            self.add_part(lane, (factor, f1, f2), real, real_rest);
            imaginary.add_part(lane, (factor, f1, f2), twice, twice_rest);
        }
    }

    /// Adds factor·(number + rest) in a lane, given the halves of the factor.
    #[inline(always)]
    fn add_part(&mut self, lane: usize, (factor, f1, f2): (f64, f64, f64), number: f64, rest: f64) {
        let product = factor * number;
        let (q1, q2) = split(number);
        let error = ((f1 * q1 - product) + f1 * q2 + f2 * q1) + f2 * q2;
        let (sum, rounding) = two_sum(self.high[lane], product);
        self.high[lane] = sum;
        self.low[lane] += rounding + (error + factor * rest);
    }

    /// The number in a lane, or what is not finite where it has left the range of doubles on the way.
    ///
    /// # Panics
    /// If `lane` is not below L.
    pub fn get(&self, lane: usize) -> DoubleDouble {
        DoubleDouble::new(self.high[lane], self.low[lane])
    }

    #[inline(always)]
    fn add_product<const FUSED: bool>(&mut self, factor: DoubleDouble, entries: &Lanes<L>) {
        let (y, y_low) = (factor.high(), factor.low());
        let (y1, y2) = split(y);
        for lane in 0..L {
            let (x, x_low) = (entries.high[lane], entries.low[lane]);
            let product = y * x;
            let error = if FUSED {
                y.mul_add(x, -product)
            } else {
                let (x1, x2) = split(x);
                ((y1 * x1 - product) + y1 * x2 + y2 * x1) + y2 * x2
            };
            let small = error + (y * x_low + y_low * x);
            let (sum, rounding) = two_sum(self.high[lane], product);
            self.high[lane] = sum;
            self.low[lane] += rounding + small;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_bigint::BigInt;
    use num_rational::BigRational;
    use num_traits::Signed;
    use proptest::prelude::*;

    fn numbers(exponents: std::ops::Range<i32>) -> impl Strategy<Value = DoubleDouble> {
        (-1.0..1.0, -1.0..1.0, exponents).prop_map(|(high, low, exponent): (f64, f64, i32)| {
            let scale = 2f64.powi(exponent);
            DoubleDouble::new(high * scale, low * scale * 2f64.powi(-60))
        })
    }

    /// Both ways to the errors of products lead to sums within their bound; returns these.
    fn agree(row: &[DoubleDouble], columns: &[Vec<DoubleDouble>; 3]) -> [[DoubleDouble; 3]; 2] {
        let mut lanes = vec![Lanes::<3>::ZERO; row.len()];
        for (k, lanes) in lanes.iter_mut().enumerate() {
            for (lane, column) in columns.iter().enumerate() {
                lanes.set(lane, column[k]);
            }
        }
        let found = [
            Lanes::products::<false>(row, &lanes),
            Lanes::products::<true>(row, &lanes),
        ];
        let n = row.len() as i64;
        let each = found.iter().flat_map(|sums| sums.iter().zip(columns));
        for (found, column) in each {
            let terms = || {
                row.iter()
                    .zip(column)
                    .map(|(a, b)| rational(*a) * rational(*b))
            };
            let zero = || BigRational::from_integer(0.into());
            let off = terms()
                .fold(-rational(*found), |sum, term| sum + term)
                .abs();
            let size = terms().fold(zero(), |sum, term| sum + term.abs());
            let share = BigRational::new(((n + 4) * (n + 4)).into(), BigInt::from(1) << 106);
            assert!(off <= size * share);
        }
        found
    }

    fn rational(value: DoubleDouble) -> BigRational {
        let part = |part: f64| BigRational::from_float(part).expect("finite");
        part(value.high()) + part(value.low())
    }

    proptest! {
        #[test]
        fn sums_are_within_their_bound(
            row in prop::collection::vec(numbers(-200..200), 7),
            a in prop::collection::vec(numbers(-200..200), 7),
            b in prop::collection::vec(numbers(-200..200), 7),
            c in prop::collection::vec(numbers(-200..200), 7),
        ) {
            let [split, fused] = agree(&row, &[a, b, c]);
            prop_assert_eq!(split, fused);
        }

        #[test]
        fn sums_of_squares_are_within_their_bound(
            terms in prop::collection::vec((-1.0..1.0, -1.0..1.0, -1.0..1.0, -30..30), 1..20),
        ) {
            let mut lanes = Lanes::<3>::ZERO;
            let exact = |value: f64| BigRational::from_float(value).expect("finite");
            let mut known = vec![BigRational::from_float(0.0).expect("finite"); 3];
            let mut size = known.clone();
            for (factor, a, b, exponent) in &terms {
                let (factor, a): (f64, f64) = (*factor, a * 2f64.powi(*exponent));
                // Far from each other, near to each other, and the same.
                let (first, second) = ([a, 1.0, a], [*b, 1.0 + b * f64::EPSILON, a]);
                lanes.add_square(factor, &first, &second);
                for lane in 0..3 {
                    let difference = exact(first[lane]) - exact(second[lane]);
                    let term = exact(factor) * &difference * &difference;
                    size[lane] += term.abs();
                    known[lane] += term;
                }
            }
            let n = terms.len() as i64;
            let share = BigRational::new(((n + 8) * (n + 8)).into(), BigInt::from(1) << 106);
            for lane in 0..3 {
                let off = (rational(lanes.get(lane)) - &known[lane]).abs();
                prop_assert!(off <= &size[lane] * &share);
            }
        }

        #[test]
        fn sums_of_complex_squares_are_within_their_bound(
            terms in prop::collection::vec((-1.0..1.0, -1.0..1.0, -1.0..1.0, -30..30, -30..30), 1..20),
        ) {
            let [mut re, mut im] = [Lanes::<3>::ZERO; 2];
            let exact = |value: f64| BigRational::from_float(value).expect("finite");
            let zero = || vec![exact(0.0); 3];
            let (mut known, mut size) = ([zero(), zero()], zero());
            for (factor, a, b, p, q) in &terms {
                let (factor, a): (f64, f64) = (*factor, a * 2f64.powi(*p));
                let b: f64 = b * 2f64.powi(*q);
                // Nearly real or nearly imaginary, nearly as much of both, and nearly nothing.
                let first = [[a, 1.0, 1.0 + b * f64::EPSILON], [b, 1.0 + a * f64::EPSILON, a]];
                let second = [[factor, 0.0, 1.0], [0.0, 0.0, a * 3.0]];
                re.add_complex_square(&mut im, factor, &first, &second);
                for lane in 0..3 {
                    let [x, y] = [0, 1].map(|part| exact(first[part][lane]) - exact(second[part][lane]));
                    size[lane] += exact(factor.abs()) * (&x * &x + &y * &y);
                    known[0][lane] += exact(factor) * (&x * &x - &y * &y);
                    known[1][lane] += exact(2.0 * factor) * &x * &y;
                }
            }
            let n = terms.len() as i64;
            let share = BigRational::new(((n + 8) * (n + 8)).into(), BigInt::from(1) << 106);
            for (part, known) in [re, im].iter().zip(&known) {
                for lane in 0..3 {
                    let off = (rational(part.get(lane)) - &known[lane]).abs();
                    prop_assert!(off <= &size[lane] * &share);
                }
            }
        }

        #[test]
        fn large_numbers_are_split_elsewhere(
            row in prop::collection::vec(numbers(995..1010), 4),
            a in prop::collection::vec(numbers(-60..-20), 4),
            b in prop::collection::vec(numbers(-60..-20), 4),
            c in prop::collection::vec(numbers(-60..-20), 4),
        ) {
            agree(&row, &[a, b, c]);
        }
    }
}
