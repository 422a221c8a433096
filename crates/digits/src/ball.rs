//! Midpoint-radius arithmetic (Rump 1999, "Fast and parallel interval arithmetic", *BIT* 39;
//! van der Hoeven 2010, *Ball arithmetic*), with every rounding error of the midpoint in the radius.

use std::ops::{Add, Mul, Neg, Sub};

use crate::{Magnitude, Real, WideComplex};

/// The disc |z − middle| ≤ radius. For every z in a and w in b, z∘w lies in a∘b.
///
/// With U = `T::unit()`, F = `T::floor()`, radii r, s and midpoints a, b, the radii are
///
/// - a ± b: r + s + U·(|re c| + |im c|), where c is the computed midpoint: each part of it errs by
///   at most U times itself;
/// - a·b: |a|·(s + 3U|b|) + r·(|b| + s) + 3F. The four products and two sums of the midpoint make an
///   error of at most (2U + U²)(|ac| + |bd|) + 2F(1 + U) in one part and the same with
///   |ad| + |bc| in the other, for a + ib and c + id; each sum is at most |a + ib||c + id|, and
///   √2·(2 + U) < 3;
/// - a/b: the largest |z − q·w| over the smallest |w|, for the computed midpoint q, as
///   z/w − q = (z − q·w)/w; the numerator is bounded by this very arithmetic, so that nothing need
///   be known of how q was computed.
///
/// All sizes are rounded to the safe side. A ball whose midpoint leaves the range of `T` has an
/// infinite radius, and so has what is computed from it.
#[derive(Clone, Copy, Debug)]
pub struct Ball<T> {
    middle: WideComplex<T>,
    radius: Magnitude,
}

impl<T: Real> Ball<T> {
    /// 0, exactly.
    pub const ZERO: Ball<T> = Ball {
        middle: WideComplex::ZERO,
        radius: Magnitude::ZERO,
    };

    /// 1, exactly.
    pub const ONE: Ball<T> = Ball {
        middle: WideComplex {
            re: T::ONE,
            im: T::ZERO,
        },
        radius: Magnitude::ZERO,
    };

    /// The disc of that midpoint and radius.
    #[inline]
    pub fn new(middle: WideComplex<T>, radius: Magnitude) -> Ball<T> {
        let radius = if middle.is_finite() {
            radius
        } else {
            Magnitude::INFINITY
        };
        Ball { middle, radius }
    }

    /// The midpoint.
    pub fn middle(self) -> WideComplex<T> {
        self.middle
    }

    /// The radius.
    pub fn radius(self) -> Magnitude {
        self.radius
    }

    /// An upper bound of |z| for all z in the ball.
    pub fn upper(self) -> Magnitude {
        self.middle.upper() + self.radius
    }

    /// A lower bound of |z| for all z in the ball; 0 where nothing is known.
    pub fn lower(self) -> Magnitude {
        self.middle.lower().minus(self.radius)
    }

    /// Whether it is 0, exactly.
    #[inline]
    pub fn is_zero(self) -> bool {
        self.radius.is_zero() && self.middle.re.is_zero() && self.middle.im.is_zero()
    }

    /// Whether 0 may lie in the ball: `false` is a proof that it does not.
    pub fn contains_zero(self) -> bool {
        self.lower().is_zero()
    }

    /// z/w for all z in this and w in the other ball; `None` where the other may contain 0.
    pub fn checked_div(self, other: Ball<T>) -> Option<Ball<T>> {
        let least = other.lower();
        if least.is_zero() {
            return None;
        }
        let quotient = Ball::from(self.middle / other.middle);
        let rest = self - quotient * other;
        Some(Ball::new(quotient.middle, rest.upper() / least))
    }

    /// The ball about a midpoint whose parts are rounded once, of numbers off by at most r + s.
    #[inline]
    fn rounded(middle: WideComplex<T>, r: Magnitude, s: Magnitude) -> Ball<T> {
        let (re, im) = (middle.re.magnitude(), middle.im.magnitude());
        // The same in plain doubles, where `above` makes up for all roundings.
        let radius = match Magnitude::plain([r, s, re, im, T::unit()]) {
            Some([r, s, re, im, unit]) => Magnitude::new(r + s + (re + im) * unit, 0).above(),
            None => r + s + (re.above() + im.above()) * T::unit(),
        };
        Ball::new(middle, radius)
    }
}

/// The point, exactly.
impl<T: Real> From<WideComplex<T>> for Ball<T> {
    fn from(middle: WideComplex<T>) -> Ball<T> {
        Ball::new(middle, Magnitude::ZERO)
    }
}

impl<T: Real> Neg for Ball<T> {
    type Output = Ball<T>;

    fn neg(self) -> Ball<T> {
        Ball {
            middle: -self.middle,
            radius: self.radius,
        }
    }
}

impl<T: Real> Add for Ball<T> {
    type Output = Ball<T>;

    #[inline]
    fn add(self, other: Ball<T>) -> Ball<T> {
        Ball::rounded(self.middle + other.middle, self.radius, other.radius)
    }
}

impl<T: Real> Sub for Ball<T> {
    type Output = Ball<T>;

    #[inline]
    fn sub(self, other: Ball<T>) -> Ball<T> {
        Ball::rounded(self.middle - other.middle, self.radius, other.radius)
    }
}

impl<T: Real> Mul for Ball<T> {
    type Output = Ball<T>;

    #[inline]
    fn mul(self, other: Ball<T>) -> Ball<T> {
        let (r, s) = (self.radius, other.radius);
        let (a, b) = (self.middle.magnitude(), other.middle.magnitude());
        let radius = match Magnitude::plain([a, b, r, s, T::unit()]) {
            // Above 2^-770 unless a or b is 0, and then nothing is rounded: F does not count.
            Some([a, b, r, s, unit]) => Magnitude::new(a * (s + 3.0 * unit * b) + r * (b + s), 0)
                .above()
                .above(),
            None => {
                let (a, b, three) = (a.above(), b.above(), Magnitude::from(3.0));
                a * (s + b * (T::unit() * three)) + r * (b + s) + T::floor() * three
            }
        };
        Ball::new(self.middle * other.middle, radius)
    }
}

/// The product with a double, exactly known: with radius r·|f| + U·(|re c| + |im c|) + 2F.
impl<T: Real> Mul<f64> for Ball<T> {
    type Output = Ball<T>;

    fn mul(self, factor: f64) -> Ball<T> {
        let radius = self.radius * Magnitude::from(factor);
        let floor = T::floor() * Magnitude::from(2.0);
        Ball::rounded(self.middle * factor, radius, floor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rational::Exact;
    use crate::{DoubleDouble, Wide};
    use num_rational::BigRational;
    use num_traits::Signed;
    use proptest::prelude::*;

    /// A complex number, exactly.
    #[derive(Clone, Debug)]
    struct Point {
        re: BigRational,
        im: BigRational,
    }

    impl Point {
        fn of<T: Real + Exact>(z: WideComplex<T>) -> Point {
            Point {
                re: z.re.exact(),
                im: z.im.exact(),
            }
        }

        fn plus(&self, other: &Point) -> Point {
            Point {
                re: &self.re + &other.re,
                im: &self.im + &other.im,
            }
        }

        fn times(&self, other: &Point) -> Point {
            Point {
                re: &self.re * &other.re - &self.im * &other.im,
                im: &self.re * &other.im + &self.im * &other.re,
            }
        }

        fn stretched(&self, factor: &BigRational) -> Point {
            Point {
                re: &self.re * factor,
                im: &self.im * factor,
            }
        }

        fn inverse(&self) -> Point {
            let square = self.square();
            Point {
                re: &self.re / &square,
                im: -&self.im / &square,
            }
        }

        fn square(&self) -> BigRational {
            &self.re * &self.re + &self.im * &self.im
        }
    }

    fn whole(value: i64) -> BigRational {
        BigRational::from_integer(value.into())
    }

    /// A ball and a number of which it is known that it lies in the ball.
    type Pair<T> = (Ball<T>, Point);

    fn assert_holds<T: Real + Exact>((ball, point): &Pair<T>) -> Result<(), TestCaseError> {
        if !ball.radius().is_finite() {
            return Ok(());
        }
        let radius = ball.radius().exact();
        let off = point.plus(&Point::of(-ball.middle()));
        prop_assert!(off.square() <= &radius * &radius);
        let (upper, lower, square) = (ball.upper().exact(), ball.lower().exact(), point.square());
        prop_assert!(square <= &upper * &upper && square >= &lower * &lower);
        prop_assert!(ball.contains_zero() || square.is_positive());
        prop_assert_eq!(ball.is_zero(), ball.upper().is_zero());
        Ok(())
    }

    #[derive(Clone, Copy, Debug)]
    enum Step {
        Add,
        Sub,
        Mul,
        Div,
        Stretch(f64),
        /// Less itself in another order of operations, where everything cancels.
        Cancel,
    }

    fn step<T: Real + Exact>(step: Step, a: &Pair<T>, b: &Pair<T>) -> Option<Pair<T>> {
        let minus = |p: &Point| p.stretched(&whole(-1));
        Some(match step {
            Step::Add => (a.0 + b.0, a.1.plus(&b.1)),
            Step::Sub => (a.0 - b.0, a.1.plus(&minus(&b.1))),
            Step::Mul => (a.0 * b.0, a.1.times(&b.1)),
            Step::Div => (a.0.checked_div(b.0)?, a.1.times(&b.1.inverse())),
            Step::Stretch(factor) => (a.0 * factor, a.1.stretched(&factor.exact())),
            Step::Cancel => {
                let square = a.0 * a.0 - b.0 * b.0;
                let sum = a.1.plus(&b.1).times(&a.1.plus(&minus(&b.1)));
                let other = (a.0 + b.0) * (a.0 - b.0);
                (square - other, sum.plus(&minus(&sum)))
            }
        })
    }

    fn any_step() -> impl Strategy<Value = Step> {
        prop_oneof![
            Just(Step::Add),
            Just(Step::Sub),
            Just(Step::Mul),
            Just(Step::Div),
            any_part(300).prop_map(Step::Stretch),
            Just(Step::Cancel),
        ]
    }

    fn any_part(reach: i64) -> impl Strategy<Value = f64> {
        let power = prop_oneof![Just(0), -3..=3i64, -reach..=reach];
        prop_oneof![
            1 => Just(0.0),
            9 => (-2.0..2.0f64, power).prop_map(|(fraction, power)| fraction.scale(power)),
        ]
    }

    /// A ball of any relative radius, and a number at its border, in it or at its midpoint.
    fn any_pair<T: Real + Exact>(reach: i64) -> impl Strategy<Value = Pair<T>> {
        let parts = prop::array::uniform4(any_part(reach));
        let size = prop_oneof![
            Just(None),
            (1..150i64).prop_map(Some),
            (900..1000i64).prop_map(Some)
        ];
        (parts, size, 0..6usize).prop_map(|(parts, size, place)| {
            let wide = |high: f64, low: f64| T::from(high) + T::from(high.scale(-60) * (low % 1.0));
            let parts = [wide(parts[0], parts[2]), wide(parts[1], parts[3])];
            let middle = WideComplex::<T>::new(parts[0], parts[1]);
            let radius = size.map_or(Magnitude::ZERO, |size| {
                middle.upper() * Magnitude::power_of_two(-size)
            });
            let (re, im) = [(5, 0), (0, 5), (-3, 4), (3, -4), (1, 2), (0, 0)][place];
            let off = Point {
                re: whole(re),
                im: whole(im),
            };
            let off = off.stretched(&(radius.exact() / whole(5)));
            (Ball::new(middle, radius), Point::of(middle).plus(&off))
        })
    }

    fn any_plan() -> impl Strategy<Value = Vec<(Step, usize, usize)>> {
        prop::collection::vec((any_step(), any::<usize>(), any::<usize>()), 1..7)
    }

    fn follow<T: Real + Exact>(
        mut pairs: Vec<Pair<T>>,
        plan: &[(Step, usize, usize)],
    ) -> Result<(), TestCaseError> {
        for (operation, i, j) in plan {
            let (a, b) = (&pairs[i % pairs.len()], &pairs[j % pairs.len()]);
            let small = |p: &Point| p.re.numer().bits().max(p.im.denom().bits()) < 40_000;
            if let Some(next) = step(*operation, a, b)
                && small(&next.1)
            {
                assert_holds(&next)?;
                pairs.push(next);
            }
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn double_double_balls_hold_the_truth(
            near in prop::collection::vec(any_pair::<DoubleDouble>(60), 2),
            far in prop::collection::vec(any_pair::<DoubleDouble>(1000), 1),
            plan in any_plan(),
        ) {
            follow([near, far].concat(), &plan)?;
        }

        #[test]
        fn wide_balls_hold_the_truth(
            near in prop::collection::vec(any_pair::<Wide<4>>(60), 2),
            far in prop::collection::vec(any_pair::<Wide<4>>(1000), 1),
            plan in any_plan(),
        ) {
            follow([near, far].concat(), &plan)?;
        }

        #[test]
        fn plain_balls_hold_the_truth(
            near in prop::collection::vec(any_pair::<f64>(60), 2),
            far in prop::collection::vec(any_pair::<f64>(1000), 1),
            plan in any_plan(),
        ) {
            follow([near, far].concat(), &plan)?;
        }

        #[test]
        fn underflow_is_in_the_radius(parts in prop::array::uniform4(-2.0..2.0f64), low in -1.0..1.0f64, power in 460..545i64, twist in -40..40i64) {
            let [a, b, c, d] = parts.map(|x| x.scale(-power));
            underflow::<DoubleDouble>(a, b, c.scale(twist), d, low)?;
            underflow::<f64>(a, b, c.scale(twist), d, low)?;
        }

        #[test]
        fn radii_of_exact_points_are_a_few_units(a in any_part(100), b in any_part(100), c in any_part(100), d in any_part(100)) {
            few_units::<DoubleDouble>(a, b, c, d)?;
            few_units::<Wide<4>>(a.scale(9), b, c, d)?;
        }
    }

    fn underflow<T: Real + Exact>(
        a: f64,
        b: f64,
        c: f64,
        d: f64,
        low: f64,
    ) -> Result<(), TestCaseError> {
        let long = |x: f64| T::from(x) + T::from(x.scale(-54) * low);
        let pair = |re: f64, im: f64| {
            let z = WideComplex::<T>::new(long(re), long(im));
            (Ball::from(z), Point::of(z))
        };
        let (z, w) = (pair(a, b), pair(c, d));
        for operation in [Step::Mul, Step::Stretch(c)] {
            let product = step(operation, &z, &w);
            prop_assert!(
                product.is_some_and(|p| p.0.radius().is_finite() && assert_holds(&p).is_ok())
            );
        }
        Ok(())
    }

    fn few_units<T: Real>(a: f64, b: f64, c: f64, d: f64) -> Result<(), TestCaseError> {
        prop_assume!((a != 0.0 || b != 0.0) && (c != 0.0 || d != 0.0));
        let point = |re: f64, im: f64| Ball::from(WideComplex::<T>::new(re, im));
        let (z, w) = (point(a, b), point(c, d));
        let quotient = z.checked_div(w);
        prop_assert!(quotient.is_some());
        for (ball, units) in [(z + w, 1.5), (z - w, 1.5), (z * w, 3.1)]
            .into_iter()
            .chain(quotient.map(|q| (q, 15.0)))
        {
            let bound = ball.upper() * T::unit() * Magnitude::from(units);
            prop_assert!(ball.radius() <= bound);
        }
        Ok(())
    }

    #[test]
    fn out_of_range_is_no_knowledge() {
        let large = Ball::from(WideComplex::<DoubleDouble>::new(1e200, 0.0));
        let one = Ball::from(WideComplex::<DoubleDouble>::new(1.0, 0.0));
        let unknown = large * large;
        for ball in [
            unknown,
            unknown * Ball::ZERO,
            unknown - unknown,
            one * unknown,
            one * f64::NAN,
            one + Ball::new(WideComplex::ZERO, Magnitude::INFINITY),
        ] {
            assert_eq!(ball.radius(), Magnitude::INFINITY);
            assert!(ball.contains_zero());
            assert!(one.checked_div(ball).is_none());
        }
        assert!(one.checked_div(Ball::ZERO).is_none());
    }
}
