//! The order in which nodes are eliminated, and the pattern that the factor gets from it.
//!
//! Two orders are tried: the given one, which a chain that is numbered along itself has no fill in,
//! and approximate minimum degree (Amestoy, Davis & Duff 1996, *SIAM J. Matrix Anal. Appl.* 17). The
//! one with less fill is taken, in a postorder of its elimination tree (Liu 1990, *SIAM J. Matrix
//! Anal. Appl.* 11), so that a node stands near those it is eliminated into.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

/// No parent.
const ROOT: u32 = u32::MAX;

/// A symmetric pattern by columns: for each node the others it is joined to.
#[derive(Clone, Debug)]
pub(crate) struct Adjacency {
    pub(crate) starts: Vec<usize>,
    pub(crate) others: Vec<u32>,
}

impl Adjacency {
    pub(crate) fn of(&self, node: usize) -> &[u32] {
        &self.others[self.starts[node]..self.starts[node + 1]]
    }

    pub(crate) fn len(&self) -> usize {
        self.starts.len() - 1
    }
}

/// An order of elimination and the pattern of L below the diagonal, by columns.
#[derive(Clone, Debug)]
pub(crate) struct Ordering {
    /// The node at each place.
    pub(crate) nodes: Vec<u32>,
    /// The place of each node.
    pub(crate) places: Vec<u32>,
    /// Where each column of L starts, and where the last one ends.
    pub(crate) starts: Vec<usize>,
    /// Rows of L, rising in each column.
    pub(crate) rows: Vec<u32>,
}

impl Ordering {
    /// With the less fill of the two orders; `None` where the factor would have more than `most`
    /// entries.
    pub(crate) fn of(graph: &Adjacency, most: usize) -> Option<Ordering> {
        let natural: Vec<u32> = (0..graph.len() as u32).collect();
        let joins = graph.others.len() / 2;
        let mut best = Tree::of(graph, natural, most);
        // No order has less than the joins themselves.
        if best.as_ref().is_none_or(|tree| tree.fill > joins) {
            let by_degree = minimum_degree(graph).and_then(|nodes| {
                let least = best
                    .as_ref()
                    .map_or(most, |tree| tree.fill.saturating_sub(1));
                Tree::of(graph, nodes, least)
            });
            best = by_degree.or(best);
        }
        let nodes = best?.postordered();
        let tree = Tree::of(graph, nodes, most)?;
        Some(tree.pattern(graph))
    }
}

/// Approximate minimum degree; `None` where it overflows.
fn minimum_degree(graph: &Adjacency) -> Option<Vec<u32>> {
    let n = graph.len();
    let rows: Vec<usize> = graph.others.iter().map(|&i| i as usize).collect();
    let pattern = SymbolicSparseColMatRef::new_unsorted_checked(n, n, &graph.starts, None, &rows);
    let scratch = amd::order_maybe_unsorted_scratch::<usize>(n, rows.len());
    let mut memory = MemBuffer::try_new(scratch).ok()?;
    let (mut order, mut inverse) = (vec![0usize; n], vec![0usize; n]);
    let control = amd::Control::default();
    let stack = MemStack::new(&mut memory);
    amd::order_maybe_unsorted(&mut order, &mut inverse, pattern, control, stack).ok()?;
    Some(order.into_iter().map(|i| i as u32).collect())
}

/// An order with its elimination tree.
struct Tree {
    nodes: Vec<u32>,
    places: Vec<u32>,
    /// The place of the parent of each place.
    parents: Vec<u32>,
    /// Entries of each column of L below the diagonal.
    counts: Vec<u32>,
    fill: usize,
}

impl Tree {
    fn of(graph: &Adjacency, nodes: Vec<u32>, most: usize) -> Option<Tree> {
        let n = nodes.len();
        let mut places = vec![0u32; n];
        for (place, &node) in nodes.iter().enumerate() {
            places[node as usize] = place as u32;
        }
        let parents = parents(graph, &nodes, &places);
        let mut tree = Tree {
            nodes,
            places,
            parents,
            counts: vec![0; n],
            fill: 0,
        };
        let mut counts = vec![0u32; n];
        let mut marked = vec![ROOT; n];
        let mut fill = 0;
        for row in 0..n {
            tree.reach(graph, row, &mut marked, |column| {
                counts[column] += 1;
                fill += 1;
            });
            if fill > most {
                return None;
            }
        }
        (tree.counts, tree.fill) = (counts, fill);
        Some(tree)
    }

    /// The columns of L that have an entry in this row.
    fn reach(
        &self,
        graph: &Adjacency,
        row: usize,
        marked: &mut [u32],
        mut visit: impl FnMut(usize),
    ) {
        marked[row] = row as u32;
        for &other in graph.of(self.nodes[row] as usize) {
            let mut column = self.places[other as usize] as usize;
            while column < row && marked[column] != row as u32 {
                marked[column] = row as u32;
                visit(column);
                column = self.parents[column] as usize;
            }
        }
    }

    /// The same tree with every node right after its descendants.
    fn postordered(&self) -> Vec<u32> {
        let n = self.nodes.len();
        // Children of each place, least first.
        let (mut first, mut next) = (vec![ROOT; n], vec![ROOT; n]);
        let mut roots = Vec::new();
        for place in (0..n).rev() {
            match self.parents[place] {
                ROOT => roots.push(place as u32),
                parent => {
                    next[place] = first[parent as usize];
                    first[parent as usize] = place as u32;
                }
            }
        }
        let mut order = Vec::with_capacity(n);
        let mut stack = Vec::new();
        while let Some(root) = roots.pop() {
            stack.push(root);
            while let Some(&place) = stack.last() {
                let child = first[place as usize];
                if child == ROOT {
                    stack.pop();
                    order.push(self.nodes[place as usize]);
                } else {
                    first[place as usize] = next[child as usize];
                    stack.push(child);
                }
            }
        }
        order
    }

    fn pattern(self, graph: &Adjacency) -> Ordering {
        let n = self.nodes.len();
        let mut starts = Vec::with_capacity(n + 1);
        starts.push(0);
        for &count in &self.counts {
            starts.push(starts[starts.len() - 1] + count as usize);
        }
        let mut ends = starts.clone();
        let mut rows = vec![0u32; self.fill];
        let mut marked = vec![ROOT; n];
        for row in 0..n {
            self.reach(graph, row, &mut marked, |column| {
                rows[ends[column]] = row as u32;
                ends[column] += 1;
            });
        }
        Ordering {
            nodes: self.nodes,
            places: self.places,
            starts,
            rows,
        }
    }
}

/// The elimination tree, with compressed paths.
fn parents(graph: &Adjacency, nodes: &[u32], places: &[u32]) -> Vec<u32> {
    let n = nodes.len();
    let (mut parents, mut ancestors) = (vec![ROOT; n], vec![ROOT; n]);
    for (row, &node) in nodes.iter().enumerate() {
        for &other in graph.of(node as usize) {
            let mut column = places[other as usize];
            while column < row as u32 {
                let above = ancestors[column as usize];
                ancestors[column as usize] = row as u32;
                if above == ROOT {
                    parents[column as usize] = row as u32;
                    break;
                }
                column = above;
            }
        }
    }
    parents
}
