//! Sums of doubles that are kept without rounding, in few doubles (Shewchuk 1997, *Discrete Comput. Geom.* 18, sections
//! 2.4 and 2.7).

use eigentone_digits::DoubleDouble;

/// a·b as two doubles; `None` where the product, or what rounding leaves of it, may leave the range of doubles.
pub(crate) fn product(a: f64, b: f64) -> Option<[f64; 2]> {
    /// 2^-967: what rounding leaves of larger products is a double.
    const LEAST: f64 = 8.1e-292;
    if a == 0.0 || b == 0.0 {
        return Some([0.0; 2]);
    }
    let size = (a * b).abs();
    (LEAST..=f64::MAX).contains(&size).then(|| {
        let product = DoubleDouble::product(a, b);
        [product.high(), product.low()]
    })
}

/// A sum as doubles that do not overlap, the largest first: it is the sum but for less than a unit of its last place.
/// Empty where the sum is 0.
pub(super) fn sum(terms: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let two_sum = |a: f64, b: f64| {
        let sum = DoubleDouble::from(a) + DoubleDouble::from(b);
        (sum.high(), sum.low())
    };
    // The smallest first.
    let mut parts: Vec<f64> = Vec::new();
    for mut term in terms {
        let mut kept = 0;
        for i in 0..parts.len() {
            let (high, low) = two_sum(term, parts[i]);
            term = high;
            if low != 0.0 {
                parts[kept] = low;
                kept += 1;
            }
        }
        parts.truncate(kept);
        parts.push(term);
    }
    let mut rest: Vec<f64> = Vec::new();
    let Some(mut top) = parts.pop() else {
        return rest;
    };
    for part in parts.into_iter().rev() {
        let (high, low) = two_sum(top, part);
        match low {
            0.0 => top = high,
            _ => {
                rest.push(high);
                top = low;
            }
        }
    }
    rest.push(top);
    let mut compressed: Vec<f64> = Vec::new();
    let mut top = rest.pop().expect("pushed above");
    for part in rest.into_iter().rev() {
        let (high, low) = two_sum(part, top);
        if low != 0.0 {
            compressed.push(low);
        }
        top = high;
    }
    compressed.push(top);
    compressed.reverse();
    compressed.retain(|part| *part != 0.0);
    compressed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_lost() {
        let parts = [1e16, 1.0, 1e-20, -1e16, 3e-40, 0.1, -0.1];
        assert_eq!(sum(parts), vec![1.0, 1e-20, 3e-40]);
        assert_eq!(sum([0.5, -0.5, 0.0]), Vec::<f64>::new());
        assert_eq!(sum([]), Vec::<f64>::new());
        // 0.1² is not a double; what is left is a part of its own.
        let [high, low] = product(0.1, 0.1).expect("within the range");
        assert_eq!(high, 0.1 * 0.1);
        assert!(low != 0.0 && low.abs() < 1e-18);
        assert_eq!(sum([low, high]), vec![high, low]);
    }

    #[test]
    fn products_out_of_range_are_none() {
        assert_eq!(product(1e-200, 1e-200), None);
        assert_eq!(product(1e200, 1e200), None);
        assert_eq!(product(0.0, 1e200), Some([0.0; 2]));
    }
}
