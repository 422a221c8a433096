//! Taylor polynomials of e^A − I with few products.
//!
//! Sastre, Ibáñez & Defez 2019, *Boosting the computation of the matrix exponential* (Appl. Math.
//! Comput. 340), evaluate a polynomial whose first 8, 15 or 21 Taylor coefficients are right with 3,
//! 4 or 5 products, where Paterson & Stockmeyer need 4, 6 and 8. The coefficients here solve
//! their equations to 50 digits and are rounded once.

use super::algebra::Algebra;

/// How far the Taylor series is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Degree {
    /// A.
    One,
    /// Up to A²: one product.
    Two,
    /// Up to A⁴: two products.
    Four,
    /// Up to A⁸: three products.
    Eight,
    /// Up to A¹⁵, and a term in A¹⁶ of .55 times its right size: four products.
    Fifteen,
    /// Up to A²¹, and three further terms that are .56, .73 and 1.13 times right: five products.
    TwentyOne,
}

impl Degree {
    /// The largest norm at which the polynomial is the exponential of a matrix that differs from A
    /// by at most 2^-53 ‖A‖ (Al-Mohy & Higham 2009, eq. 3.5, for log(e^-x p(x))).
    pub(super) fn theta(self) -> f64 {
        match self {
            Degree::One => 2.220_446_049_250_313e-16,
            Degree::Two => 2.580_956_802_971_767e-8,
            Degree::Four => 3.397_168_839_976_962e-4,
            Degree::Eight => 0.049_912_288_711_153_23,
            Degree::Fifteen => 0.676_421_749_542_451_4,
            Degree::TwentyOne => 1.682_715_644_786_315_7,
        }
    }

    /// The first coefficient of log(e^-x p(x)), and its power of x.
    pub(super) fn first_error(self) -> (f64, i32) {
        match self {
            Degree::One => (0.5, 2),
            Degree::Two => (1.0 / 6.0, 3),
            Degree::Four => (1.0 / 120.0, 5),
            Degree::Eight => (1.0 / 362_880.0, 9),
            Degree::Fifteen => (2.171_108_634_289_131_5e-14, 16),
            Degree::TwentyOne => (3.886_425_044_072_925_3e-22, 22),
        }
    }
}

const EIGHT: [f64; 6] = [
    4.980_119_205_559_973e-3,
    1.992_047_682_223_989_4e-2,
    7.665_265_321_119_147e-2,
    8.765_009_801_785_553e-1,
    1.225_521_150_112_074_7e-1,
    2.974_307_204_847_627,
];

const FIFTEEN: [f64; 14] = [
    4.018_761_610_201_035_5e-4,
    2.945_531_440_279_683e-3,
    -8.709_066_576_837_676e-3,
    4.017_568_440_673_568e-1,
    3.230_762_888_122_312e-2,
    5.768_988_513_026_145,
    2.338_576_034_271_299e-2,
    2.381_070_373_870_987e-1,
    2.224_209_172_496_373_6,
    -5.792_361_707_073_261,
    -4.130_276_365_929_783e-2,
    10.408_017_352_313_544,
    -63.317_124_558_833_707,
    3.484_665_863_364_574_6e-1,
];

const TWENTY_ONE: [f64; 20] = [
    1.161_658_834_444_880_4e-6,
    4.500_852_739_573_01e-6,
    5.374_708_803_114_820_4e-5,
    2.005_403_977_292_901_5e-3,
    6.974_348_269_544_424e-2,
    9.418_613_214_806_352e-1,
    2.852_960_512_714_315e-3,
    -7.544_837_153_586_671e-3,
    1.829_773_504_500_423_8,
    3.151_382_711_608_315e-2,
    1.392_249_143_769_798e-1,
    -2.269_101_241_269_351e-3,
    -5.394_098_846_866_402e-2,
    3.112_216_227_982_407e-1,
    9.343_851_261_938_047,
    6.865_706_355_662_834e-1,
    3.233_370_163_085_38,
    -5.726_379_787_260_966,
    -1.413_550_099_309_667e-2,
    -1.638_413_114_712_015_6e-1,
];

/// A and those of its powers that have been computed.
pub(super) struct Powers<E> {
    pub(super) a: E,
    pub(super) a2: Option<E>,
    pub(super) a3: Option<E>,
    /// What A is to be multiplied by, a power of two; all three are known, unless it is 1.
    pub(super) factor: f64,
}

/// p(A) − I.
pub(super) fn evaluate<G: Algebra>(
    algebra: &mut G,
    degree: Degree,
    mut powers: Powers<G::Element>,
) -> G::Element {
    if degree == Degree::One {
        return powers.a;
    }
    let a2 = match powers.a2.take() {
        Some(a2) => a2,
        None => algebra.multiply(&powers.a, &powers.a),
    };
    let result = match degree {
        Degree::One | Degree::Two => {
            let [sum] = algebra.combine([&[(1.0, &powers.a), (0.5, &a2)]]);
            sum
        }
        Degree::Four => four(algebra, &powers.a, &a2),
        Degree::Eight => eight(algebra, &powers.a, &a2),
        Degree::Fifteen => fifteen(algebra, &powers.a, &a2),
        Degree::TwentyOne => {
            let a3 = match powers.a3.take() {
                Some(a3) => a3,
                None => algebra.multiply(&a2, &powers.a),
            };
            let result = twenty_one(algebra, powers.factor, [&powers.a, &a2, &a3]);
            algebra.recycle(a3);
            result
        }
    };
    algebra.recycle(a2);
    algebra.recycle(powers.a);
    result
}

fn four<G: Algebra>(algebra: &mut G, a: &G::Element, a2: &G::Element) -> G::Element {
    let [sum, high] =
        algebra.combine([&[(1.0, a), (0.5, a2)], &[(1.0 / 6.0, a), (1.0 / 24.0, a2)]]);
    let sum = algebra.multiply_add(sum, a2, &high);
    algebra.recycle(high);
    sum
}

fn eight<G: Algebra>(algebra: &mut G, a: &G::Element, a2: &G::Element) -> G::Element {
    let [c1, c2, c3, c4, c5, c6] = EIGHT;
    let [inner] = algebra.combine([&[(c1, a2), (c2, a)]]);
    let y0 = algebra.multiply(a2, &inner);
    algebra.recycle(inner);
    let [left, right, sum] = algebra.combine([
        &[(1.0, &y0), (c3, a2), (c4, a)],
        &[(1.0, &y0), (c5, a2)],
        &[(c6, &y0), (0.5, a2), (1.0, a)],
    ]);
    finish(algebra, sum, [left, right, y0])
}

fn fifteen<G: Algebra>(algebra: &mut G, a: &G::Element, a2: &G::Element) -> G::Element {
    let [c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12, c13, c14] = FIFTEEN;
    let [inner] = algebra.combine([&[(c1, a2), (c2, a)]]);
    let y0 = algebra.multiply(a2, &inner);
    algebra.recycle(inner);
    let [left, right, sum] = algebra.combine([
        &[(1.0, &y0), (c3, a2), (c4, a)],
        &[(1.0, &y0), (c5, a2)],
        &[(c6, &y0), (c7, a2)],
    ]);
    let y1 = algebra.multiply_add(sum, &left, &right);
    algebra.recycle(left);
    algebra.recycle(right);
    let [left, right, sum] = algebra.combine([
        &[(1.0, &y1), (c8, a2), (c9, a)],
        &[(1.0, &y1), (c10, &y0), (c11, a)],
        &[(c12, &y1), (c13, &y0), (c14, a2), (1.0, a)],
    ]);
    algebra.recycle(y1);
    finish(algebra, sum, [left, right, y0])
}

/// For f·A, f a factor that coefficients take up, as do those of the one sum that A³ is multiplied by.
fn twenty_one<G: Algebra>(algebra: &mut G, f: f64, [a, a2, a3]: [&G::Element; 3]) -> G::Element {
    let c = TWENTY_ONE;
    let [f1, f2, f3] = [f, f * f, f * f * f];
    let inner = [
        (c[0] * f3 * f3, a3),
        (c[1] * f2 * f3, a2),
        (c[2] * f1 * f3, a),
    ];
    let [inner] = algebra.combine([&inner]);
    let y0 = algebra.multiply(a3, &inner);
    algebra.recycle(inner);
    let [left, right, sum] = algebra.combine([
        &[(1.0, &y0), (c[3] * f3, a3), (c[4] * f2, a2), (c[5] * f1, a)],
        &[(1.0, &y0), (c[6] * f3, a3), (c[7] * f2, a2)],
        &[(c[8], &y0), (c[9] * f3, a3), (c[10] * f2, a2)],
    ]);
    let y1 = algebra.multiply_add(sum, &left, &right);
    algebra.recycle(left);
    algebra.recycle(right);
    let [left, right, sum] = algebra.combine([
        &[
            (1.0, &y1),
            (c[11] * f3, a3),
            (c[12] * f2, a2),
            (c[13] * f1, a),
        ],
        &[(1.0, &y1), (c[14], &y0), (c[15] * f1, a)],
        &[
            (c[16], &y1),
            (c[17], &y0),
            (c[18] * f3, a3),
            (c[19] * f2, a2),
            (f1, a),
        ],
    ]);
    algebra.recycle(y1);
    finish(algebra, sum, [left, right, y0])
}

/// sum + left·right.
fn finish<G: Algebra>(
    algebra: &mut G,
    sum: G::Element,
    [left, right, rest]: [G::Element; 3],
) -> G::Element {
    let sum = algebra.multiply_add(sum, &left, &right);
    for element in [left, right, rest] {
        algebra.recycle(element);
    }
    sum
}

#[cfg(test)]
mod tests {
    use eigentone_digits::{Real, Wide};

    use super::*;

    type Exact = Wide<4>;

    /// Polynomials in one variable, by their coefficients.
    struct Coefficients;

    impl Algebra for Coefficients {
        type Element = Vec<Exact>;

        fn combine<const SUMS: usize>(
            &mut self,
            terms: [&[(f64, &Vec<Exact>)]; SUMS],
        ) -> [Vec<Exact>; SUMS] {
            terms.map(|terms| {
                let length = terms.iter().map(|(_, x)| x.len()).max().unwrap_or(0);
                let mut sum = vec![Exact::ZERO; length];
                for (factor, x) in terms {
                    for (sum, x) in sum.iter_mut().zip(*x) {
                        *sum = *sum + x.mul_f64(*factor);
                    }
                }
                sum
            })
        }

        fn multiply_add(
            &mut self,
            mut sum: Vec<Exact>,
            x: &Vec<Exact>,
            y: &Vec<Exact>,
        ) -> Vec<Exact> {
            sum.resize(sum.len().max(x.len() + y.len() - 1), Exact::ZERO);
            for (i, x) in x.iter().enumerate() {
                for (j, y) in y.iter().enumerate() {
                    sum[i + j] = sum[i + j] + *x * *y;
                }
            }
            sum
        }

        fn multiply(&mut self, x: &Vec<Exact>, y: &Vec<Exact>) -> Vec<Exact> {
            self.multiply_add(Vec::new(), x, y)
        }

        fn recycle(&mut self, _: Vec<Exact>) {}
    }

    const DEGREES: [(Degree, usize); 6] = [
        (Degree::One, 1),
        (Degree::Two, 2),
        (Degree::Four, 4),
        (Degree::Eight, 8),
        (Degree::Fifteen, 15),
        (Degree::TwentyOne, 21),
    ];

    /// The coefficients of p(x) − 1 in 256 bits.
    fn coefficients(degree: Degree) -> Vec<Exact> {
        let powers = Powers {
            a: vec![Exact::ZERO, Exact::ONE],
            a2: None,
            a3: None,
            factor: 1.0,
        };
        evaluate(&mut Coefficients, degree, powers)
    }

    #[test]
    fn coefficients_are_those_of_taylor() {
        for (degree, order) in DEGREES {
            let found = coefficients(degree);
            assert!(found[0].is_zero());
            let mut factorial = Exact::ONE;
            for (k, found) in found.iter().enumerate().take(order + 1).skip(1) {
                factorial = factorial.mul_f64(k as f64);
                let error = (*found * factorial - Exact::ONE).to_f64().abs();
                assert!(error <= 2e-15, "{degree:?}, x^{k}: {error:e}");
            }
        }
    }

    /// log(e^-x p(x)) in 256 bits, with the Taylor coefficients of p made exact.
    fn backward_error(degree: Degree, order: usize) -> Vec<Exact> {
        const TERMS: usize = 48;
        let mut inverse = vec![Exact::ONE];
        for k in 1..TERMS {
            inverse.push(inverse[k - 1] / Exact::from(k as f64));
        }
        let mut p = coefficients(degree);
        p[..=order].copy_from_slice(&inverse[..=order]);
        let mut quotient = vec![Exact::ZERO; TERMS];
        for (k, entry) in quotient.iter_mut().enumerate() {
            for (j, p) in p.iter().enumerate().take(k + 1) {
                let sign = if (k - j) % 2 == 0 { 1.0 } else { -1.0 };
                *entry = *entry + (*p * inverse[k - j]).mul_f64(sign);
            }
        }
        let mut log = vec![Exact::ZERO; TERMS];
        for k in 1..TERMS {
            let mut sum = quotient[k].mul_f64(k as f64);
            for j in 1..k {
                sum = sum - (log[j] * quotient[k - j]).mul_f64(j as f64);
            }
            log[k] = sum / Exact::from(k as f64);
        }
        log
    }

    #[test]
    fn theta_is_where_the_backward_error_reaches_the_rounding_unit() {
        for (degree, order) in DEGREES {
            let log = backward_error(degree, order);
            let error: f64 = (order + 1..log.len())
                .map(|k| log[k].to_f64().abs() * degree.theta().powi(k as i32 - 1))
                .sum();
            let unit = f64::EPSILON / 2.0;
            assert!((error / unit - 1.0).abs() < 1e-6, "{degree:?}: {error:e}");
            let (first, power) = degree.first_error();
            assert_eq!(power as usize, order + 1);
            assert!((log[order + 1].to_f64().abs() / first - 1.0).abs() < 1e-9);
        }
    }
}
