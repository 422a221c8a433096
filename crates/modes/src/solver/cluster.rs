//! Groups of computed roots that doubles cannot separate.

use num_complex::Complex;

/// The first of all indices below n that each is joined with, directly or through others.
pub(crate) fn labels(n: usize, joined: impl Fn(usize, usize) -> bool) -> Vec<usize> {
    let mut label: Vec<usize> = (0..n).collect();
    for i in 0..n {
        for j in 0..i {
            if label[i] != label[j] && joined(i, j) {
                let (from, to) = (label[i].max(label[j]), label[i].min(label[j]));
                label
                    .iter_mut()
                    .filter(|l| **l == from)
                    .for_each(|l| *l = to);
            }
        }
    }
    label
}

/// Indices of roots whose estimated error discs touch, in groups; every root is in one.
pub(crate) fn groups(values: &[Complex<f64>], radii: &[f64]) -> Vec<Vec<usize>> {
    let n = values.len();
    let label = labels(n, |i, j| within(values[i] - values[j], radii[i] + radii[j]));
    let mut groups: Vec<Vec<usize>> = vec![Vec::new(); n];
    for (i, label) in label.into_iter().enumerate() {
        groups[label].push(i);
    }
    groups.retain(|group| !group.is_empty());
    groups
}

/// Whether no two of the discs touch.
pub(crate) fn are_apart(values: &[Complex<f64>], radii: &[f64]) -> bool {
    let touch = |i: usize| (0..i).any(|j| within(values[i] - values[j], radii[i] + radii[j]));
    !(0..values.len()).any(touch)
}

/// Whether |z| ≤ reach, mostly without a root.
pub(crate) fn within(z: Complex<f64>, reach: f64) -> bool {
    z.re.abs() <= reach && z.im.abs() <= reach && z.norm() <= reach
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn touching_discs_chain_together() {
        let values = [0.0, 1.0, 5.0, 2.0].map(Complex::from);
        let groups = groups(&values, &[0.6, 0.6, 0.1, 0.6]);
        assert_eq!(groups, vec![vec![0, 1, 3], vec![2]]);
    }
}
