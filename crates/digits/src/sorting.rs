//! Sorting by a number of each.

/// Sorts by a number of each, smallest first, as [`f64::total_cmp`] orders them. Those whose numbers are equal keep their
/// order. A number is asked for once.
///
/// Lists are sorted by one function of their numbers: `slice::sort_by` is built anew for each place that calls it, which was a
/// twentieth of all machine code.
///
/// ```
/// let mut words = ["three", "a", "to"];
/// eigentone_digits::sort_by_number(&mut words, |word| word.len() as f64);
/// assert_eq!(words, ["a", "to", "three"]);
/// ```
pub fn sort_by_number<T>(items: &mut [T], number: impl FnMut(&T) -> f64) {
    let numbers: Vec<f64> = items.iter().map(number).collect();
    for (i, other) in exchanges(&numbers).into_iter().enumerate() {
        items.swap(i, other);
    }
}

/// With which place, at it or after it, each place is to be exchanged, in their order.
fn exchanges(numbers: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..numbers.len()).collect();
    order.sort_by(|a, b| numbers[*a].total_cmp(&numbers[*b]));
    for i in 0..order.len() {
        // What stood there before has been exchanged since.
        while order[i] < i {
            order[i] = order[order[i]];
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_numbers_keep_their_order() {
        let mut items: Vec<(f64, usize)> = (0..50)
            .map(|k| (f64::from(k % 4) - 1.5, k as usize))
            .collect();
        sort_by_number(&mut items, |item| -item.0);
        let wanted = (0..4)
            .rev()
            .flat_map(|part| (0..50).filter(move |k| k % 4 == part));
        assert!(items.iter().map(|item| item.1).eq(wanted));
    }
}
