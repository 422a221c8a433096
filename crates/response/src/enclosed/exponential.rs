//! e^{τW} with more digits and a proven bound: scaling and squaring with a Taylor polynomial
//! (Paterson & Stockmeyer 1973, *SIAM J. Comput.* 2), every error counted in the 2-norm.

use std::sync::LazyLock;

use eigentone_digits::{Magnitude, Real, Wide};
use faer::Mat;

use super::normed::{Normed, growth};

/// e^{τW}, for a `tau` known to a relative `tau_error`. Where entries are of unlike sizes they may have many digits
/// of which the bound, one for the whole matrix, knows nothing.
pub(crate) fn exponential<T: Real>(w: &Normed<T>, tau: T, tau_error: Magnitude) -> Normed<T> {
    until(w, tau, tau_error, |_| false).0
}

/// The same for those who need the bound, which is infinite once nothing is left of it, and how many products it took.
pub(crate) fn counted<T: Real>(w: &Normed<T>, tau: T, tau_error: Magnitude) -> (Normed<T>, u64) {
    until(w, tau, tau_error, is_lost)
}

/// The exponential, given up as soon as a square is `lost`.
fn until<T: Real>(
    w: &Normed<T>,
    tau: T,
    tau_error: Magnitude,
    lost: impl Fn(&Normed<T>) -> bool,
) -> (Normed<T>, u64) {
    let scaled = w.times_scalar(tau, tau_error);
    let size = scaled.true_norm();
    if !size.is_finite() {
        let n = w.len();
        let anything = Normed::identity(n, w.lead()).with_more_error(Magnitude::INFINITY);
        return (anything, 0);
    }
    let plan = Plan::of(size.log2(), T::UNIT_LOG2);
    let mut power = polynomial(&scaled.scaled(-plan.squarings), &plan);
    let mut products = plan.products() as u64;
    for _ in 0..plan.squarings {
        power = power.times(&power);
        products += 1;
        if lost(&power) {
            return (power.with_more_error(Magnitude::INFINITY), products);
        }
    }
    (power, products)
}

/// e^W as a matrix whose sizes have norm ½ to 1 and the exponent of a power of two beside it, so that neither growth nor
/// decay leads out of range; `None` where no digit is left. Below 2^-`least` it may be anything that small.
pub(crate) fn of_any_size<T: Real>(w: &Normed<T>, least: f64) -> Option<(Normed<T>, i64)> {
    /// Logarithms of norms are as near as this to the true ones, by far.
    const SLACK: f64 = 1e-6;
    /// Relative errors double with every square at least: what comes to 1 in so many more is given up.
    const AHEAD: i64 = 50;
    let size = w.true_norm();
    if !size.is_finite() {
        return None;
    }
    let plan = Plan::of(size.log2(), T::UNIT_LOG2);
    let scaled = w.scaled(-plan.squarings);
    let (power, squarings) = if w.error().is_zero() && scaled.error().is_zero() {
        by_powers(&scaled, &plan)
    } else {
        (polynomial(&scaled, &plan), plan.squarings)
    };
    let (mut power, mut exponent) = power.normalised();
    for left in (0..squarings).rev() {
        let (square, more) = power.times(&power).normalised();
        power = square;
        exponent = exponent.saturating_mul(2).saturating_add(more);
        let growth = power.true_norm().log2() + exponent as f64;
        if growth < -SLACK && growth * (left as f64).exp2() < -least {
            return Some((power, i64::MIN));
        }
        let ahead = Magnitude::power_of_two(left.min(AHEAD));
        if power.sizes() <= power.error() * ahead {
            return None;
        }
    }
    Some((power, exponent))
}

/// e^{τW/2^depth} at all depths, from one set of powers: as far down as the step is to be halved before the polynomial each is
/// the square of the next, and below that a polynomial of the same powers.
pub(crate) struct Halves<T> {
    plan: Plan,
    /// Of what is kept of τW/2^squarings.
    powers: Vec<Normed<T>>,
    /// How far off that is.
    error: Magnitude,
}

impl<T: Real> Halves<T> {
    /// For a `tau` known to a relative `tau_error`. `None` where τW is beyond the range of T.
    pub(crate) fn of(w: &Normed<T>, tau: T, tau_error: Magnitude) -> Option<Halves<T>> {
        let scaled = w.times_scalar(tau, tau_error);
        let size = scaled.true_norm();
        if !size.is_finite() {
            return None;
        }
        let plan = Plan::of(size.log2(), T::UNIT_LOG2);
        let x = scaled.scaled(-plan.squarings);
        Some(Halves {
            powers: powers(&x, &plan),
            error: x.error(),
            plan,
        })
    }

    /// The depth at which no squaring is needed.
    pub(crate) fn ground(&self) -> usize {
        self.plan.squarings as usize
    }

    /// e^{τW/2^depth}, for a depth that is no less.
    pub(crate) fn at(&self, depth: usize) -> Normed<T> {
        let down = depth as i64 - self.plan.squarings;
        let error = self.error * Magnitude::power_of_two(-down);
        let x = self.powers[1].scaled(-down).with_more_error(error);
        // The shorter the step, the fewer terms.
        let size = x.true_norm().log2();
        let reaches = |height: &usize| {
            let next = self.plan.width * height + 1;
            next as f64 * size + 1.0 - LOG2_FACTORIALS[next] <= f64::from(T::UNIT_LOG2)
        };
        let plan = Plan {
            height: (1..self.plan.height)
                .find(reaches)
                .unwrap_or(self.plan.height),
            ..self.plan
        };
        of_small_powers(&x, &self.powers, down, &plan)
    }

    /// e^{τW}, its half, …, down to the ground, each the square of the next.
    pub(crate) fn squares(&self) -> Vec<Normed<T>> {
        let mut squares = vec![self.at(self.ground())];
        for last in 0..self.ground() {
            squares.push(squares[last].times(&squares[last]));
        }
        squares.reverse();
        squares
    }

    /// How many products of matrices lead to the whole.
    pub(crate) fn products(&self) -> u64 {
        (self.plan.products() + self.ground()) as u64
    }

    /// τW/2^depth, in doubles.
    pub(crate) fn exponent(&self, depth: usize) -> Mat<f64> {
        let x = &self.powers[1];
        let factor = ((self.plan.squarings - depth as i64) as f64).exp2();
        Mat::from_fn(x.len(), x.len(), |i, j| factor * x.row(i)[j].to_f64())
    }
}

/// How many products of matrices [`of_any_size`] takes at most, for an exponent of norm 2^`size`.
pub(crate) fn products<T: Real>(size: f64) -> f64 {
    let plan = Plan::of(size, T::UNIT_LOG2);
    // Beyond as many squarings as there are digits no digit is left.
    let squarings = plan.squarings.min(i64::from(-T::UNIT_LOG2));
    (plan.products() as i64 + squarings) as f64
}

/// Whether nothing is known of a matrix, nor of any power of it: an error of at least 1 and at least what is
/// kept of the matrix only grows in a square, in proportion too.
fn is_lost<T: Real>(power: &Normed<T>) -> bool {
    Magnitude::from(1.0) <= power.error() && power.sizes() <= power.error()
}

/// How often τW is halved before the polynomial, at most.
pub(crate) fn squarings<T: Real>(w: &Normed<T>, tau: f64) -> f64 {
    (w.true_norm().log2() + tau.log2()).max(0.0)
}

/// How e^X is taken: degree = width·height of the polynomial, and how often X is halved first.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Plan {
    width: usize,
    height: usize,
    squarings: i64,
}

/// The widest polynomial that is thought of, by one.
const WIDTHS: usize = 40;

/// log₂ k! for every degree k that a plan may ask for.
static LOG2_FACTORIALS: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let mut sum = 0.0;
    let next = |k: usize| {
        sum += (k.max(1) as f64).log2();
        sum
    };
    (0..=WIDTHS * WIDTHS).map(next).collect()
});

impl Plan {
    /// The cheapest for ‖X‖ = 2^size and a unit of 2^unit: its truncation stays below the unit.
    fn of(size: f64, unit: i32) -> Plan {
        let shapes = (2..WIDTHS).flat_map(|width| [(width, width), (width, width + 1)]);
        let mut best: Option<Plan> = None;
        for (width, height) in shapes {
            // More products than the best takes with its squarings.
            let work = |plan: &Plan| (plan.products() as i64).saturating_add(plan.squarings);
            if best.is_some_and(|best| work(&best) <= (width + height - 2) as i64) {
                break;
            }
            let degree = width * height;
            let factorial = LOG2_FACTORIALS[degree + 1];
            // x^(degree + 1)/(degree + 1)! ≤ 2^unit, and x ≤ 1.
            let reach = ((f64::from(unit) + factorial) / (degree + 1) as f64).min(0.0);
            let plan = Plan {
                width,
                height,
                squarings: (size - reach).ceil().max(0.0) as i64,
            };
            if best.is_none_or(|best| work(&plan) < work(&best)) {
                best = Some(plan);
            }
        }
        best.expect("there are shapes")
    }

    fn products(&self) -> usize {
        self.width + self.height - 2
    }
}

/// Σ X^k/k! up to the degree, with the error of the polynomial, of its truncation and of X.
fn polynomial<T: Real>(x: &Normed<T>, plan: &Plan) -> Normed<T> {
    of_small_powers(x, &powers(x, plan), 0, plan)
}

/// The same, given the powers of 2^down·X.
fn of_small_powers<T: Real>(
    x: &Normed<T>,
    powers: &[Normed<T>],
    down: i64,
    plan: &Plan,
) -> Normed<T> {
    // x ≤ 1: Σ_{k > degree} x^k/k! ≤ x^{degree+1}/(degree+1)!·2, and e^x ≤ 1 + x + x².
    let size = x.true_norm();
    let mut tail = Magnitude::from(2.0);
    for k in 1..=plan.width * plan.height + 1 {
        tail = tail * size / Magnitude::from(k as f64);
    }
    let slope = Magnitude::from(1.0) + size + size * size;
    of_powers(powers, down, plan).with_more_error(tail + x.error() * slope)
}

/// I, X, …, X^width of what is kept of X.
fn powers<T: Real>(x: &Normed<T>, plan: &Plan) -> Vec<Normed<T>> {
    let (n, lead) = (x.len(), x.lead());
    let kept = Normed::new(n, lead, x.entries().to_vec(), Magnitude::ZERO);
    let mut powers = vec![Normed::identity(n, lead), kept];
    for i in 2..=plan.width {
        let next = powers[i - 1].times(&powers[1]);
        powers.push(next);
    }
    powers
}

/// The polynomial for an X without error of which powers are small though it is not, and how many squarings are left: A
/// is scaled by norms of powers, not by its own (Al-Mohy & Higham 2009, SIAM J. Matrix Anal. 31), as each squaring of a matrix far
/// from normal costs digits.
fn by_powers<T: Real>(x: &Normed<T>, plan: &Plan) -> (Normed<T>, i64) {
    let (width, height) = (plan.width, plan.height);
    let mut powers = powers(x, plan);
    let root = |k: usize| powers[k].true_norm().log2() / k as f64;
    // With w(w − 1) ≤ degree + 1 the largest of two neighbours serves for all later powers.
    let pairs = (1..width).map(|k| root(k).max(root(k + 1)));
    let size = pairs.fold(root(1), f64::min);
    // What fits x fits powers that are as small; of X^width the bound below rests on.
    let spare = (root(1).min(0.0) - size).min(-root(width)).floor();
    let spare = (spare.max(0.0) as i64).min(plan.squarings);
    for (k, power) in powers.iter_mut().enumerate() {
        *power = power.scaled(spare * k as i64);
    }
    // ‖X^{wq + r}‖ ≤ ‖X^w‖^q ‖X^r‖, and ‖X^w‖ ≤ 1: later terms halve at least.
    let last = powers[width].true_norm();
    let mut tail = Magnitude::ZERO;
    let mut factor = Magnitude::from(2.0);
    for k in 1..=height {
        let product = ((k - 1) * width + 1..=k * width).map(|k| Magnitude::from(k as f64));
        factor = product.fold(factor * last, |factor, k| factor / k);
    }
    for (k, power) in powers.iter().enumerate().skip(1) {
        factor = factor / Magnitude::from((width * height + k) as f64);
        tail = tail + power.true_norm() * factor;
    }
    let sum = of_powers(&powers, 0, plan);
    (sum.with_more_error(tail), plan.squarings - spare)
}

/// Σ X^k/k! up to the degree from the first powers of 2^down·X, with the error of the polynomial.
fn of_powers<T: Real>(powers: &[Normed<T>], down: i64, plan: &Plan) -> Normed<T> {
    let (n, lead, width) = (powers[0].len(), powers[0].lead(), plan.width);
    let degree = width * plan.height;
    let mut coefficients = vec![T::ONE];
    for k in 1..=degree {
        let last = coefficients[k - 1];
        coefficients.push(last / T::from(k as f64));
    }
    // Σ c_{first + i} X^i for i below `count`; a coefficient errs by a unit for each quotient.
    let block = |first: usize, count: usize| {
        let mut entries = vec![T::ZERO; n * n];
        let mut error = T::floor() * Magnitude::from((n * n * count) as f64);
        let mut terms = Vec::with_capacity(count);
        for (i, power) in powers.iter().enumerate().take(count) {
            let coefficient = coefficients[first + i].scale(-down * i as i64);
            terms.push((coefficient, power.entries()));
            let rounding = power.sizes() * growth::<T>(first + i + count + 2);
            error = error + coefficient.upper() * (power.error() + rounding);
            error = error + T::floor() * power.sizes();
        }
        T::add_multiples(&mut entries, &terms);
        (entries, error)
    };
    // The highest block takes the last coefficient with it.
    let (entries, error) = block(degree - width, width + 1);
    let mut sum = Normed::new(n, lead, entries, error);
    let widest = powers[width].scaled(-down * width as i64);
    for height in (0..plan.height - 1).rev() {
        let (mut entries, error) = sum.product(&widest);
        let (lower, more) = block(height * width, width);
        let pairs = entries.iter_mut().zip(lower);
        pairs.for_each(|(sum, entry)| *sum = *sum + entry);
        let rounded = Normed::new(n, lead, entries, error + more);
        let rounding = rounded.sizes() * T::unit();
        sum = rounded.with_more_error(rounding);
    }
    sum
}

/// cos φ and sin φ, and a bound of the error of either.
pub(crate) fn cos_sin<T: Real>(phase: f64) -> (T, T, Magnitude) {
    if phase == 0.0 {
        return (T::ONE, T::ZERO, Magnitude::ZERO);
    }
    /// Larger ones would cost more digits than there may be.
    const LARGE: f64 = (1u64 << 20) as f64;
    /// So many limbs hold the largest double and as many digits beyond it as are ever asked for.
    const LIMBS: usize = 32;
    if phase.abs() <= LARGE {
        return rotation(phase);
    }
    let (c, s, error) = rotation::<Wide<LIMBS>>(phase);
    let ((c, of_cosine), (s, of_sine)) = (shortened(c), shortened(s));
    (c, s, error + of_cosine + of_sine)
}

/// The same by an exponential.
fn rotation<T: Real>(phase: f64) -> (T, T, Magnitude) {
    let generator = vec![T::ZERO, T::ONE, -T::ONE, T::ZERO];
    let generator = Normed::new(2, 2, generator, Magnitude::ZERO);
    let turned = exponential(&generator, T::from(phase), Magnitude::ZERO);
    (turned.row(0)[0], turned.row(0)[1], turned.error())
}

/// A number of at most 1 in the digits of T, and how far off it may be.
fn shortened<S: Real, T: Real>(value: S) -> (T, Magnitude) {
    let (mut sum, mut rest) = (T::ZERO, value);
    let doubles = 2 - T::UNIT_LOG2 / 50;
    for _ in 0..doubles {
        let part = rest.to_f64();
        sum = sum + T::from(part);
        rest = rest - S::from(part);
    }
    let rounding = T::unit() * Magnitude::from(2.0 * f64::from(doubles));
    (sum, rest.upper() + rounding + S::unit())
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_digits::{DoubleDouble, Wide};

    /// The exponentials of one matrix in two precisions lie within their two bounds.
    fn agree(n: usize, entries: &[f64], tau: f64) -> (f64, f64) {
        fn of<T: Real>(n: usize, entries: &[f64], tau: f64) -> Normed<T> {
            let entries = entries.iter().map(|x| T::from(*x)).collect();
            let w = Normed::new(n, n, entries, Magnitude::ZERO);
            exponential(&w, T::from(tau), Magnitude::ZERO)
        }
        let fine = of::<Wide<16>>(n, entries, tau);
        let coarse = of::<DoubleDouble>(n, entries, tau);
        let difference = fine
            .entries()
            .iter()
            .zip(coarse.entries())
            .map(|(fine, coarse)| (*fine - Wide::from(*coarse)).to_f64().powi(2))
            .sum::<f64>()
            .sqrt();
        let bound = (fine.error() + coarse.error()).to_f64();
        // The Frobenius norm is at most √n times the 2-norm that is bounded.
        assert!(difference <= bound * (n as f64).sqrt());
        (difference, bound)
    }

    #[test]
    fn bounds_hold_and_are_not_idle() {
        for (n, entries, tau) in [
            (2, vec![0.0, 1.0, -1.0, 0.0], 1e3),
            (2, vec![1.0, 1e2, 0.0, -1.0], 1.0),
            (2, vec![0.0, 1e4, -1e4, -1e4], 0.5),
            (
                3,
                vec![-1.0, 1.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0, -1.0],
                20.0,
            ),
            (1, vec![-700.0], 1.0),
        ] {
            let (_, bound) = agree(n, &entries, tau);
            assert!(bound < 1e-9, "{entries:?}: {bound}");
        }
    }

    #[test]
    fn sines_of_large_phases() {
        // From π to 40 digits: 1e6 = 159154·2π + 5.92562114009136…
        let (c, s, error) = cos_sin::<DoubleDouble>(1e6);
        assert!((c.to_f64() - 0.936_752_127_533_144_8).abs() < 1e-15);
        assert!((s.to_f64() + 0.349_993_502_171_292_95).abs() < 1e-15);
        for (phase, sine) in [
            (1e17, -0.464_530_104_835_372_7),
            (-1e100, 0.380_637_731_005_028_7),
            (1.7e308, -0.595_256_084_863_207_7),
        ] {
            let (c, s, bound) = cos_sin::<DoubleDouble>(phase);
            assert!((s.to_f64() - sine).abs() < 1e-15, "{phase:e}");
            assert!(bound.to_f64() < 1e-28, "{phase:e}: {bound:?}");
            let (longer_c, longer_s, more) = cos_sin::<Wide<8>>(phase);
            assert!(more.to_f64() < 1e-140, "{phase:e}: {more:?}");
            for (short, long) in [(c, longer_c), (s, longer_s)] {
                let off = (long - Wide::from(short)).to_f64().abs();
                assert!(off <= (bound + more).to_f64(), "{phase:e}: {off:e}");
            }
        }
        assert!(error.to_f64() < 1e-22);
        let one = c * c + s * s - DoubleDouble::from(1.0);
        assert!(one.to_f64().abs() < 1e-22);
    }

    /// Four terms of e^x at ½ are off by ½⁵/5! and more.
    #[test]
    fn what_the_series_leaves_out_is_counted() {
        for size in [-0.5f64, 0.5, 1.0] {
            let x = Normed::new(1, 1, vec![DoubleDouble::from(size)], Magnitude::ZERO);
            let plan = Plan {
                width: 2,
                height: 2,
                squarings: 0,
            };
            let sum = polynomial(&x, &plan);
            let off = (sum.entries()[0].to_f64() - size.exp()).abs();
            assert!(off > 2e-4, "the series is longer than planned");
            assert!(
                off <= sum.error().to_f64(),
                "{off:e} {}",
                sum.error().to_f64()
            );
            assert!(sum.error().to_f64() <= 3.0 * off);
            let (sum, left) = by_powers(&x, &plan);
            let off = (sum.entries()[0].to_f64() - size.exp()).abs();
            assert!(off <= sum.error().to_f64() && left == 0, "{off:e}");
            assert!(sum.error().to_f64() <= 5.0 * off);
        }
    }

    /// e^N = I + N for N² = 0, however large N is: each squaring would cost the digits of a square.
    #[test]
    fn small_powers_spare_squarings() {
        let entries = [1.0, -1.0, 1.0, -1.0].map(|x| Wide::<4>::from(1e9 * x));
        let n = Normed::new(2, 2, entries.to_vec(), Magnitude::ZERO);
        let (power, exponent) = of_any_size(&n, f64::INFINITY).expect("digits are left");
        let error = power.error() * Magnitude::power_of_two(exponent);
        assert!(error.to_f64() < 1e-9, "{:e}", error.to_f64());
        let wanted = [1e9 + 1.0, -1e9, 1e9, 1.0 - 1e9];
        for (x, wanted) in power.entries().iter().zip(wanted) {
            assert_eq!(x.scale(exponent).to_f64(), wanted);
        }
    }

    /// Every depth, by squares and by scaled powers, within its bound of the exponential taken by itself.
    #[test]
    fn halves_are_the_exponentials_of_shorter_steps() {
        let entries = [0.3, 1e3, -1.2e3, -40.0].map(DoubleDouble::from);
        let w = Normed::new(2, 2, entries.to_vec(), Magnitude::ZERO);
        let halves = Halves::of(&w, DoubleDouble::from(0.7), Magnitude::ZERO).expect("in range");
        assert!(halves.ground() > 5);
        for depth in halves.ground()..halves.ground() + 9 {
            let found = halves.at(depth);
            let exponent = halves.exponent(depth)[(1, 0)];
            let wanted = -1.2e3 * 0.7 * (-(depth as f64)).exp2();
            assert!((exponent / wanted - 1.0).abs() < 1e-15, "{exponent:e}");
            let step = DoubleDouble::from(0.7).scale(-(depth as i64));
            let known = exponential(&w, step, Magnitude::ZERO);
            for (found, known) in found.entries().iter().zip(known.entries()) {
                assert!((*found - *known).to_f64().abs() < 1e-28);
            }
            assert!(found.error().to_f64() < 1e-27);
        }
    }

    /// e^{x + δ} − e^x is more than δ for x > 0; times that are known to δ leave that open.
    #[test]
    fn errors_of_the_argument_are_counted() {
        let of = |error: f64, tau_error: f64| {
            let w = vec![DoubleDouble::from(0.75)];
            let w = Normed::new(1, 1, w, Magnitude::from(error));
            exponential(&w, DoubleDouble::from(4.0), Magnitude::from(tau_error))
        };
        let (exact, delta) = (3f64.exp(), 1e-9);
        for (power, change) in [(of(delta, 0.0), 4.0 * delta), (of(0.0, delta), 3.0 * delta)] {
            let worst = exact * change.exp_m1();
            let bound = power.error().to_f64();
            assert!(bound >= worst, "{bound:e} {worst:e}");
            assert!(bound <= 10.0 * worst, "{bound:e} {worst:e}");
        }
    }
}
