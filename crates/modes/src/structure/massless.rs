//! Coordinates without mass, decided on the exact entries and never by a norm: a mass of 1e-300
//! beside one of 1e300 is a mass.

use super::coefficients::Coefficients;
use super::network::Network;
use super::support::Parts;
use crate::exact::matrix::ExactMatrix;

/// The coordinates whose row and column of M are 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Massless {
    /// All of them, rising.
    pub(crate) nodes: Vec<usize>,
    /// Those whose row or column of C is not 0, rising.
    pub(crate) damped: Vec<usize>,
    /// Their groups joined by dampers, where C is symmetric.
    pub(crate) groups: Vec<DamperGroup>,
}

/// Damped massless nodes that dampers join to each other.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DamperGroup {
    /// The nodes, rising.
    pub(crate) nodes: Vec<usize>,
    /// Whether no damper leads from them to a mass or to the ground. With C ⪰ 0 such a group has
    /// one relaxation root less than nodes, any other as many as nodes.
    pub(crate) floating: bool,
}

impl Massless {
    pub(crate) fn of(coefficients: &Coefficients) -> Massless {
        let massive = touched(&coefficients.mass.matrix);
        let damped = touched(&coefficients.damping.matrix);
        let nodes: Vec<usize> = (0..massive.len()).filter(|&i| !massive[i]).collect();
        let damped: Vec<usize> = nodes.iter().copied().filter(|&i| damped[i]).collect();
        let groups = match &coefficients.damping.network {
            Some(network) if !damped.is_empty() => groups(network, &massive, &damped),
            _ => Vec::new(),
        };
        Massless {
            nodes,
            damped,
            groups,
        }
    }
}

fn groups(network: &Network, massive: &[bool], damped: &[usize]) -> Vec<DamperGroup> {
    let n = massive.len();
    let mut parts = Parts::new(n);
    let mut tied: Vec<bool> = (0..n).map(|i| network.is_grounded(i)).collect();
    for &(i, j) in network.joins() {
        match (massive[i], massive[j]) {
            (false, false) => parts.unite(i, j),
            (false, true) => tied[i] = true,
            (true, false) => tied[j] = true,
            (true, true) => {}
        }
    }
    let mut groups: Vec<DamperGroup> = Vec::new();
    let mut place = vec![None; n];
    for &node in damped {
        let at = *place[parts.root(node)].get_or_insert(groups.len());
        if at == groups.len() {
            groups.push(DamperGroup {
                nodes: Vec::new(),
                floating: true,
            });
        }
        groups[at].nodes.push(node);
        groups[at].floating &= !tied[node];
    }
    groups
}

/// Which coordinates have an entry in their row or column.
fn touched(matrix: &ExactMatrix) -> Vec<bool> {
    let mut touched = vec![false; matrix.len()];
    for i in 0..matrix.len() {
        for (j, _) in matrix.row(i) {
            touched[i] = true;
            touched[j] = true;
        }
    }
    touched
}
