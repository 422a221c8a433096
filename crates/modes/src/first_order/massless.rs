//! Which massless nodes relax, and which follow at once.

use faer::{Mat, MatRef};

use crate::model::{Element, MatrixKind};
use crate::system::System;

/// The coordinates with mass, and the massless ones: new coordinates (w, a) with x_p = T (w, a), where w relaxes through
/// dampers and a follows at once.
pub(crate) struct Massless {
    massive: Vec<usize>,
    nodes: Vec<usize>,
    /// T, of entries 0 and 1.
    change: Mat<f64>,
    /// w = S x_p, of entries 0, 1 and −1.
    states: Mat<f64>,
    relaxing: usize,
}

impl Massless {
    /// Groups massless nodes that only dampers among themselves hold: such a group relaxes in its
    /// differences and follows at once as a whole.
    pub(crate) fn of_system(system: &System) -> Massless {
        Massless::of(
            system,
            system.mass_matrix().as_ref(),
            system.damping_matrix().as_ref(),
        )
    }

    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The coordinates with mass.
    pub(crate) fn massive(&self) -> &[usize] {
        &self.massive
    }

    /// The degree of det(λ²M + λC + K) if the masses of coordinates that have any, the dampers on those
    /// that relax, and the springs on those that follow are nonsingular blocks; less if not.
    pub(crate) fn degree(&self) -> usize {
        2 * self.massive.len() + self.relaxing
    }

    /// How many coordinates relax.
    pub(crate) fn relaxing(&self) -> usize {
        self.relaxing
    }

    /// How many coordinates follow at once.
    pub(crate) fn following(&self) -> usize {
        self.nodes.len() - self.relaxing
    }

    /// Where T is 1: the node, and the column.
    pub(crate) fn change(&self) -> impl Iterator<Item = (usize, usize)> {
        let entries = (0..self.nodes.len())
            .flat_map(|row| (0..self.nodes.len()).map(move |column| (row, column)));
        entries
            .filter(|at| self.change[*at] != 0.0)
            .map(|(row, column)| (self.nodes[row], column))
    }

    /// Where S is not 0: the row, the node, and the entry.
    pub(crate) fn state_entries(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        let entries = (0..self.relaxing)
            .flat_map(|row| (0..self.nodes.len()).map(move |column| (row, column)));
        entries
            .map(|(row, column)| (row, self.nodes[column], self.states[(row, column)]))
            .filter(|(.., entry)| *entry != 0.0)
    }

    /// The nodes whose displacements, less that of the group they float with, relax.
    pub(crate) fn relaxing_nodes(&self) -> Vec<usize> {
        let row =
            |state: usize| (0..self.nodes.len()).find(|row| self.states[(state, *row)] == 1.0);
        (0..self.relaxing)
            .filter_map(|state| row(state).map(|row| self.nodes[row]))
            .collect()
    }

    /// The groups of nodes that follow at once as wholes.
    pub(crate) fn following_groups(&self) -> Vec<Vec<usize>> {
        let member = |row: &usize, column: usize| self.change[(*row, column)] == 1.0;
        (self.relaxing..self.nodes.len())
            .map(|column| {
                let rows = (0..self.nodes.len()).filter(|row| member(row, column));
                rows.map(|row| self.nodes[row]).collect()
            })
            .collect()
    }

    /// Groups massless nodes, given M and C.
    fn of(system: &System, m: MatRef<'_, f64>, c: MatRef<'_, f64>) -> Massless {
        let n = c.nrows();
        let has_mass = |i: &usize| (0..n).any(|j| m[(*i, j)] != 0.0 || m[(j, *i)] != 0.0);
        let (massive, nodes): (Vec<usize>, Vec<usize>) = (0..n).partition(has_mass);
        let p = nodes.len();
        let mut group: Vec<usize> = (0..p).collect();
        for (row, &i) in nodes.iter().enumerate() {
            for (column, &j) in nodes.iter().enumerate().take(row) {
                if c[(i, j)] != 0.0 || c[(j, i)] != 0.0 {
                    let (from, to) = (group[row], group[column]);
                    for member in group.iter_mut().filter(|member| **member == from) {
                        *member = to;
                    }
                }
            }
        }
        // A group floats if no damper leaves it. Where a damping matrix was added, only nodes that
        // it does not touch count as floating.
        let inside = |label: usize, i: usize| {
            nodes
                .iter()
                .position(|node| *node == i)
                .is_some_and(|at| group[at] == label)
        };
        let floats = |label: usize| {
            let members = nodes.iter().zip(&group).filter(|(_, g)| **g == label);
            let untouched = members
                .clone()
                .all(|(&i, _)| (0..n).all(|j| c[(i, j)] == 0.0 && c[(j, i)] == 0.0));
            let leaves = |element: &Element| {
                let ends = [element.first, element.second]
                    .map(|end| end.coordinate().is_some_and(|i| inside(label, i)));
                element.coefficient != 0.0 && ends[0] != ends[1]
            };
            let closed =
                system.added(MatrixKind::Damping).is_none() && !system.dampers().iter().any(leaves);
            untouched || closed
        };
        let mut roots = Vec::new();
        let mut relaxing = Vec::new();
        for row in 0..p {
            let label = group[row];
            let first = group
                .iter()
                .position(|g| *g == label)
                .expect("row is in its own group");
            if first == row && floats(label) {
                roots.push(row);
            } else {
                relaxing.push((row, roots.contains(&first).then_some(first)));
            }
        }
        let mut change = Mat::<f64>::zeros(p, p);
        let mut states = Mat::<f64>::zeros(relaxing.len(), p);
        for (column, (row, root)) in relaxing.iter().enumerate() {
            change[(*row, column)] = 1.0;
            states[(column, *row)] = 1.0;
            if let Some(root) = root {
                states[(column, *root)] = -1.0;
            }
        }
        for (column, root) in roots.iter().enumerate() {
            for row in (0..p).filter(|row| group[*row] == group[*root]) {
                change[(row, relaxing.len() + column)] = 1.0;
            }
        }
        Massless {
            massive,
            nodes,
            change,
            states,
            relaxing: relaxing.len(),
        }
    }
}
