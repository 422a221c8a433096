//! What floats: the parts of a network that no join ties to the ground, by union and find.
//!
//! A floating part can be moved as a whole without any force, whatever the signs of its joins. With
//! C and K positive semidefinite, λ = 0 is a root dim N(K) + dim(N(K) ∩ N(C)) times: once for each
//! part that floats on its springs, and once more for each that floats on springs and dampers.

use super::network::Network;

/// The floating parts of networks laid over each other: their nodes, rising.
pub(crate) fn floating(networks: &[&Network]) -> Vec<Vec<usize>> {
    let n = networks.first().map_or(0, |network| network.len());
    if (0..n).all(|i| networks.iter().any(|network| network.is_grounded(i))) {
        return Vec::new();
    }
    let mut parts = Parts::new(n + 1);
    for network in networks {
        network.joins().iter().for_each(|&(i, j)| parts.unite(i, j));
        (0..n)
            .filter(|&i| network.is_grounded(i))
            .for_each(|i| parts.unite(i, n));
    }
    let ground = parts.root(n);
    if (0..n).all(|i| parts.root(i) == ground) {
        return Vec::new();
    }
    let mut place = vec![usize::MAX; n];
    let mut list: Vec<Vec<usize>> = Vec::new();
    for i in 0..n {
        let root = parts.root(i);
        if root == ground {
            continue;
        }
        if place[root] == usize::MAX {
            place[root] = list.len();
            list.push(Vec::new());
        }
        list[place[root]].push(i);
    }
    list
}

/// Nodes united into parts: a forest in which every node points towards its part's least node.
pub(crate) struct Parts(Vec<usize>);

impl Parts {
    /// Each node on its own.
    pub(crate) fn new(count: usize) -> Parts {
        Parts((0..count).collect())
    }

    /// The least node of the part that `node` is in.
    pub(crate) fn root(&mut self, mut node: usize) -> usize {
        while self.0[node] != node {
            self.0[node] = self.0[self.0[node]];
            node = self.0[node];
        }
        node
    }

    /// Makes one part of two.
    pub(crate) fn unite(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
    }
}
