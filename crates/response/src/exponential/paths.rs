//! Which entries of e^A can differ from 0: those between which nonzero entries of A make a path.

use faer::MatRef;

/// From which row a path of nonzero entries leads to which column (Warshall 1962, *J. ACM* 9), 64 columns at a time.
pub(super) struct Paths {
    n: usize,
    words: usize,
    bits: Vec<u64>,
}

impl Paths {
    pub(super) fn of(a: MatRef<'_, f64>) -> Paths {
        const WIDTH: usize = 64;
        let n = a.nrows();
        let words = n.div_ceil(WIDTH);
        let mut bits = vec![0u64; n * words];
        for j in 0..n {
            for i in (0..n).filter(|i| *i == j || a[(*i, j)] != 0.0) {
                bits[i * words + j / WIDTH] |= 1 << (j % WIDTH);
            }
        }
        let mut paths = Paths { n, words, bits };
        // Where all are joined there is nothing to add.
        let rounds = if paths.count() == n * n { 0 } else { n };
        for k in 0..rounds {
            let through = paths.row(k).to_vec();
            for i in 0..n {
                if i != k && paths.lead(i, k) {
                    let row = &mut paths.bits[i * words..(i + 1) * words];
                    row.iter_mut().zip(&through).for_each(|(to, by)| *to |= by);
                }
            }
        }
        paths
    }

    fn row(&self, i: usize) -> &[u64] {
        &self.bits[i * self.words..(i + 1) * self.words]
    }

    /// Whether there is one from i to j, or i = j.
    pub(super) fn lead(&self, i: usize, j: usize) -> bool {
        self.row(i)[j / 64] >> (j % 64) & 1 == 1
    }

    /// How many pairs of indices they join, each index with itself counted in.
    pub(super) fn count(&self) -> usize {
        self.bits
            .iter()
            .map(|word| word.count_ones() as usize)
            .sum()
    }

    /// The indices that paths join, in either direction and by way of others.
    pub(super) fn parts(&self) -> Vec<Vec<usize>> {
        self.grouped(|i, j| self.lead(i, j) || self.lead(j, i))
    }

    /// The indices between which paths lead there and back, so ordered that none leads to an earlier class.
    pub(super) fn classes(&self) -> Vec<Vec<usize>> {
        let mut classes = self.grouped(|i, j| self.lead(i, j) && self.lead(j, i));
        // From an earlier class more can be reached.
        let reached = |i: usize| {
            self.row(i)
                .iter()
                .map(|word| word.count_ones())
                .sum::<u32>()
        };
        classes.sort_by_cached_key(|class| std::cmp::Reverse(reached(class[0])));
        classes
    }

    /// The indices that a relation joins, directly or by way of others.
    fn grouped(&self, joined: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
        let mut left: Vec<usize> = (0..self.n).collect();
        let mut groups = Vec::new();
        while let Some(first) = left.first().copied() {
            let mut group = vec![first];
            left.remove(0);
            let mut next = 0;
            while let Some(i) = group.get(next).copied() {
                let (more, rest) = left.iter().partition(|j| joined(i, **j));
                left = rest;
                group.extend::<Vec<usize>>(more);
                next += 1;
            }
            group.sort_unstable();
            groups.push(group);
        }
        groups
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    #[test]
    fn classes_come_in_the_order_of_their_paths() {
        // 3 → 1 ⇄ 4 → 0, and 2 by itself.
        let edges = [(3, 1), (1, 4), (4, 1), (4, 0)];
        let a = Mat::from_fn(5, 5, |i, j| f64::from(u8::from(edges.contains(&(i, j)))));
        let paths = Paths::of(a.as_ref());
        assert!(paths.lead(3, 0) && !paths.lead(0, 3) && paths.lead(2, 2));
        assert_eq!(paths.parts(), [vec![0, 1, 3, 4], vec![2]]);
        let classes = paths.classes();
        let place = |i: usize| classes.iter().position(|class| class.contains(&i));
        assert!(place(3) < place(1) && place(1) == place(4) && place(4) < place(0));
        assert_eq!(classes.len(), 4);
    }
}
