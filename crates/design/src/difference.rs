//! Differences of eighth order.

/// How many of nine values, evenly spaced, lie below a number, and how far apart they are: in parts of the number, and of its range
/// where it is 0. Limits may be infinite, and as many values as they allow lie between them.
pub fn spaced(number: f64, [low, high]: [f64; 2]) -> (usize, f64) {
    const PART: f64 = 1.0 / 128.0;
    let range = high - low;
    let size = match number.abs() {
        0.0 if range.is_finite() => PART * range,
        0.0 => PART,
        size => size,
    };
    let spacing = (PART * size).min(range / 8.0);
    let least = ((number + 8.0 * spacing - high) / spacing).ceil().max(0.0);
    let most = ((number - low) / spacing).floor().min(8.0);
    let below = 4.0f64.max(least).min(most.max(0.0));
    (below.min(8.0) as usize, spacing)
}

/// Weights of nine values 1 apart for the first derivative at the one in place `at`, from 0: exact for polynomials of degree eight.
///
/// # Panics
/// If `at` is beyond 8.
pub fn difference(at: usize) -> [f64; 9] {
    assert!(at <= 8, "there are nine values");
    let product = |k: usize, without: usize, from: usize| -> f64 {
        let others = (0..9usize).filter(|m| *m != k && *m != without);
        others.map(|m| from as f64 - m as f64).product()
    };
    std::array::from_fn(|k| match k == at {
        true => {
            let others = (0..9usize).filter(|m| *m != at);
            others.map(|m| 1.0 / (at as f64 - m as f64)).sum()
        }
        false => product(k, at, at) / product(k, k, k),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No absolute size decides: nine values around a number stay apart in doubles, however large it is.
    #[test]
    fn values_are_spaced_in_parts_of_the_number() {
        let free = [f64::NEG_INFINITY, f64::INFINITY];
        for number in [1e-200, 0.3, 100.0, 9.5e19, -1e100] {
            let (below, spacing) = spaced(number, free);
            assert_eq!((below, spacing), (4, number.abs() / 128.0));
            let at = |k: f64| number + k * spacing;
            let sum: f64 = difference(below)
                .iter()
                .zip([-4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0])
                .map(|(weight, k)| weight * (at(k) / number).sqrt())
                .sum();
            let slope = sum / spacing * number;
            assert!((slope - 0.5).abs() < 1e-12, "{number:?}: {slope:?}");
        }
        assert_eq!(spaced(0.0, free).0, 4);
        assert_eq!(spaced(1.0, [1.0, 9.0]), (0, 1.0 / 128.0));
        assert_eq!(spaced(9.0, [1.0, 9.0]), (8, 9.0 / 128.0));
        assert_eq!(spaced(8.0, [8.0, 8.125]), (0, 0.125 / 8.0));
    }
}
