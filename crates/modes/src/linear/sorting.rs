//! Sorting by a number of each.

/// Sorts by a number of each, smallest first. Those whose numbers are equal keep their order. A number is asked for once.
///
/// Lists are sorted by one function of their numbers: `slice::sort_by` is built anew for each place that calls it, which was an
/// eighth of this crate's machine code.
pub(crate) fn sort_by_number<T>(items: &mut [T], number: impl FnMut(&T) -> f64) {
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
