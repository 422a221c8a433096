//! Indices that are joined with each other, directly or through others.

/// Gives all that have the label of either the lesser of both.
pub(crate) fn join(label: &mut [usize], i: usize, j: usize) {
    let (from, to) = (label[i].max(label[j]), label[i].min(label[j]));
    let moved = label.iter_mut().filter(|label| **label == from);
    moved.for_each(|label| *label = to);
}

/// The indices below n in groups of those that are joined.
pub(super) fn groups(n: usize, joined: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
    let mut label: Vec<usize> = (0..n).collect();
    for i in 0..n {
        for j in 0..i {
            if label[i] != label[j] && joined(i, j) {
                join(&mut label, i, j);
            }
        }
    }
    let mut groups = vec![Vec::new(); n];
    for (i, label) in label.into_iter().enumerate() {
        groups[label].push(i);
    }
    groups.retain(|group: &Vec<usize>| !group.is_empty());
    groups
}
