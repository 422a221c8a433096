//! The first root of a polynomial on an interval, none missed.

use eigentone_digits::Real;

/// What is known of the first root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum First {
    /// There is none: the polynomial stays > 0.
    None,
    /// It is the only one between these two, > 0 before and < 0 after.
    Between(f64, f64),
    /// The polynomial comes so close to 0 here that its errors hide whether it crosses.
    Hidden(f64),
}

/// The first root of Σ aₖ θᵏ, times any power of θ, on (0, 1], where the polynomial is known to `margin` everywhere there.
/// By the coefficients of Bernstein's basis, of which the polynomial is a convex combination, and whose changes of sign
/// count its roots from above (Farouki, Computer Aided Geometric Design 29, 2012, sections 3 and 6).
pub(crate) fn first<T: Real>(coefficients: &[T], margin: f64) -> First {
    let sizes = coefficients[1..].iter().map(|entry| entry.to_f64().abs());
    let rest: f64 = sizes.sum();
    // The last terms count as errors.
    let negligible = 0.25 * margin.max(rest * f64::MIN_POSITIVE);
    let (mut count, mut left) = (coefficients.len(), 0.0);
    while count > 2 && left + coefficients[count - 1].to_f64().abs() <= negligible {
        left += coefficients[count - 1].to_f64().abs();
        count -= 1;
    }
    let (coefficients, margin) = (&coefficients[..count], margin + left);
    if coefficients[0].to_f64() > (rest + margin) * (1.0 + 1e-12) {
        return First::None;
    }
    let bernstein = bernstein(coefficients);
    let rounding = 2f64.powi(T::UNIT_LOG2) * 4.0 * (count * count) as f64;
    let margin = margin + rounding * (rest + coefficients[0].to_f64().abs());
    search(&bernstein, margin, 0.0, 1.0)
}

/// The coefficients in Bernstein's basis of Σ aₖ θᵏ on [0, 1]: bᵢ = Σₖ C(i,k)/C(p,k) aₖ, by repeated sums.
pub(crate) fn bernstein<T: Real>(coefficients: &[T]) -> Vec<T> {
    let count = coefficients.len();
    let degree = count - 1;
    let mut bernstein: Vec<T> = coefficients.to_vec();
    for (k, entry) in bernstein.iter_mut().enumerate() {
        // aₖ / C(p,k)
        for i in 0..k {
            *entry = *entry * T::from((i + 1) as f64) / T::from((degree - i) as f64);
        }
    }
    for level in 0..degree {
        for i in (level + 1..count).rev() {
            let before = bernstein[i - 1];
            bernstein[i] = bernstein[i] + before;
        }
    }
    bernstein
}

fn search<T: Real>(bernstein: &[T], margin: f64, from: f64, to: f64) -> First {
    let sign = |entry: &T| {
        let value = entry.to_f64();
        if value > margin {
            1
        } else if value < -margin {
            -1
        } else {
            0
        }
    };
    if bernstein.iter().all(|entry| sign(entry) > 0) {
        return First::None;
    }
    let (first, last) = (sign(&bernstein[0]), sign(&bernstein[bernstein.len() - 1]));
    match first {
        // No part that begins here would show more.
        0 => return First::Hidden(from),
        ..0 => return First::Between(from, from),
        _ => {}
    }
    if last < 0 {
        // One change of sign, whatever the signs of those that are not known.
        let rises = bernstein.iter().skip_while(|entry| sign(entry) > 0);
        let mut later = rises.skip_while(|entry| sign(entry) == 0);
        if later.all(|entry| sign(entry) < 0) && once(bernstein, margin) {
            return First::Between(from, to);
        }
    }
    // Where doubles distinguish no places, or the root is the start itself.
    const NEAREST: f64 = 1e-200;
    if to - from <= 4.0 * f64::EPSILON * to || to < NEAREST {
        return First::Hidden(from);
    }
    // Not where a root lies.
    const CUTS: [f64; 3] = [0.5, 0.4140625, 0.5859375];
    let mut parts = divided(bernstein, CUTS[0]);
    let mut cut = CUTS[0];
    for other in &CUTS[1..] {
        if sign(&parts.1[0]) != 0 {
            break;
        }
        parts = divided(bernstein, *other);
        cut = *other;
    }
    let (left, right) = parts;
    let middle = from + cut * (to - from);
    match search(&left, margin, from, middle) {
        First::None => search(&right, margin, middle, to),
        found => found,
    }
}

/// Whether coefficients that are not known change sign at most once: one of them, or all in a row that falls.
fn once<T: Real>(bernstein: &[T], margin: f64) -> bool {
    let unknown = bernstein
        .iter()
        .filter(|entry| entry.to_f64().abs() <= margin);
    unknown.count() <= 1
}

/// De Casteljau's division.
pub(crate) fn divided<T: Real>(bernstein: &[T], cut: f64) -> (Vec<T>, Vec<T>) {
    let count = bernstein.len();
    let mut row = bernstein.to_vec();
    let mut left = Vec::with_capacity(count);
    let mut right = vec![T::ZERO; count];
    for level in 0..count {
        left.push(row[0]);
        right[count - 1 - level] = row[count - 1 - level];
        for i in 0..count - 1 - level {
            row[i] = match cut == 0.5 {
                true => (row[i] + row[i + 1]).scale(-1),
                false => row[i].mul_f64(1.0 - cut) + row[i + 1].mul_f64(cut),
            };
        }
    }
    (left, right)
}

/// The root between two places, of opposite signs there, to the digits of T: by Newton's method, kept between.
pub(crate) fn refine<T: Real>(coefficients: &[T], from: f64, to: f64) -> T {
    let value = |theta: T| {
        let mut slope = T::ZERO;
        let mut sum = T::ZERO;
        for entry in coefficients.iter().rev() {
            slope = slope * theta + sum;
            sum = sum * theta + *entry;
        }
        (sum, slope)
    };
    let (mut low, mut high) = (T::from(from), T::from(to));
    let mut theta = (low + high).scale(-1);
    let mut last = f64::INFINITY;
    for _ in 0..200 {
        let (here, slope) = value(theta);
        if here.is_zero() {
            return theta;
        }
        match here > T::ZERO {
            true => low = theta,
            false => high = theta,
        }
        let step = here / slope;
        let next = theta - step;
        let size = step.to_f64().abs();
        let inside = next > low && next < high && slope < T::ZERO;
        // Newton's steps end where rounding does not let them shrink.
        let small = size <= 2f64.powi(T::UNIT_LOG2 / 4 * 3);
        let still = size <= 2f64.powi(T::UNIT_LOG2) * 4.0 || size >= last || !inside;
        if small && still {
            return if inside { next } else { theta };
        }
        last = if inside { size } else { f64::INFINITY };
        theta = if inside { next } else { (low + high).scale(-1) };
        if high - low <= T::ONE.scale(i64::from(T::UNIT_LOG2) - 4) {
            return theta;
        }
    }
    theta
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polynomial(roots: &[f64], sign: f64) -> Vec<f64> {
        let mut coefficients = vec![sign];
        for root in roots {
            let mut next = vec![0.0; coefficients.len() + 1];
            for (k, entry) in coefficients.iter().enumerate() {
                next[k + 1] += entry;
                next[k] -= root * entry;
            }
            coefficients = next;
        }
        coefficients
    }

    #[test]
    fn the_first_of_several_roots_is_found() {
        let found = first(&polynomial(&[0.3, 0.31, 0.8], -1.0), 1e-14);
        let First::Between(from, to) = found else {
            panic!("{found:?}");
        };
        assert!(from < 0.3 && to > 0.3 && to < 0.31, "{from} {to}");
        let root = refine(&polynomial(&[0.3, 0.31, 0.8], -1.0), from, to);
        assert!((root - 0.3).abs() < 1e-13, "{root}");
    }

    #[test]
    fn two_roots_close_together_are_not_missed() {
        let found = first(&polynomial(&[0.5, 0.500001], 1.0), 1e-15);
        let First::Between(from, to) = found else {
            panic!("{found:?}");
        };
        assert!(from < 0.5 && to > 0.5 && to < 0.500001);
    }

    #[test]
    fn a_touch_is_said_to_be_hidden() {
        assert!(
            matches!(first(&polynomial(&[0.5, 0.5], 1.0), 1e-15), First::Hidden(at) if (at - 0.5).abs() < 1e-6)
        );
        assert_eq!(first(&polynomial(&[-0.5, 1.5], -1.0), 1e-15), First::None);
    }
}
