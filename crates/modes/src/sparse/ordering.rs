//! The order in which nodes are eliminated, and the pattern that the factor gets from it.
//!
//! Three orders are tried: the given one, which a chain that is numbered along itself has no fill in;
//! approximate minimum degree (Amestoy, Davis & Duff 1996, *SIAM J. Matrix Anal. Appl.* 17); and, where
//! that leaves as much work as solids do, nested dissection (George 1973, *SIAM J. Numer. Anal.* 10; Pellegrini & Roman 1996,
//! HPCN Europe). The one with the least work is taken, in a postorder of its elimination tree (Liu 1990, *SIAM J. Matrix
//! Anal. Appl.* 11), so that a node stands near those it is eliminated into.

use std::ops::Range;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;
use feral_scotch::{CscPattern, scotch_order};

/// So many multiplications for each node are more than plates take, and dissection makes them fewer.
const SOLID: f64 = 1e5;

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

    /// Whether some node is joined to so many that dissection takes long, and separates nothing.
    fn has_hub(&self) -> bool {
        let most = 16 + 10 * self.len().isqrt();
        self.starts.windows(2).any(|ends| ends[1] - ends[0] > most)
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
    /// The first column of each supernode, and n: columns that follow each other with the same rows, but for those among
    /// them.
    edges: Vec<u32>,
}

impl Ordering {
    /// With the least work; `None` where the factor would have more than `most` entries.
    pub(crate) fn of(graph: &Adjacency, most: usize) -> Option<Ordering> {
        let natural: Vec<u32> = (0..graph.len() as u32).collect();
        let joins = graph.others.len() / 2;
        let mut best = Tree::of(graph, natural, most);
        // No order has less than the joins themselves.
        if best.as_ref().is_none_or(|tree| tree.fill > joins) {
            let least = best.as_ref().map_or(most, |tree| tree.fill);
            let other = minimum_degree(graph).and_then(|nodes| Tree::of(graph, nodes, least));
            best = Tree::less(best, other);
        }
        let work = best.as_ref().map_or(f64::INFINITY, Tree::work);
        if work > SOLID * graph.len() as f64 && !graph.has_hub() {
            let other = nested_dissection(graph).and_then(|nodes| Tree::of(graph, nodes, most));
            best = Tree::less(best, other);
        }
        let nodes = best?.postordered();
        let tree = Tree::of(graph, nodes, most)?;
        Some(tree.pattern(graph))
    }

    /// How many multiplications a factor takes.
    pub(crate) fn work(&self) -> f64 {
        let columns = self.starts.windows(2).map(|ends| ends[1] - ends[0]);
        columns.map(multiplications).sum()
    }

    /// The columns of each supernode, in order.
    pub(crate) fn supernodes(&self) -> impl DoubleEndedIterator<Item = Range<usize>> {
        let edges = self.edges.windows(2);
        edges.map(|edge| edge[0] as usize..edge[1] as usize)
    }

    /// The rows of a supernode below its columns.
    pub(crate) fn below(&self, columns: &Range<usize>) -> &[u32] {
        &self.rows[self.starts[columns.end - 1]..self.starts[columns.end]]
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

/// Nested dissection; `None` where indices of 32 bits do not suffice.
fn nested_dissection(graph: &Adjacency) -> Option<Vec<u32>> {
    let starts: Result<Vec<i32>, _> = graph.starts.iter().map(|&at| at.try_into()).collect();
    let rows: Vec<i32> = graph.others.iter().map(|&i| i as i32).collect();
    let starts = starts.ok()?;
    let pattern = CscPattern::new(graph.len(), &starts, &rows)?;
    let order = scotch_order(&pattern).ok()?;
    Some(order.into_iter().map(|i| i as u32).collect())
}

/// How many a column with so many entries below its diagonal takes.
fn multiplications(entries: usize) -> f64 {
    entries as f64 * (entries as f64 + 1.0) / 2.0
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

    /// How many multiplications a factor takes.
    fn work(&self) -> f64 {
        let columns = self.counts.iter().map(|&entries| entries as usize);
        columns.map(multiplications).sum()
    }

    /// The one with less work, or the first.
    fn less(first: Option<Tree>, second: Option<Tree>) -> Option<Tree> {
        match (first, second) {
            (Some(first), Some(second)) if second.work() < first.work() => Some(second),
            (first, second) => first.or(second),
        }
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
        let is_same = |j: &usize| {
            self.parents[j - 1] == *j as u32 && self.counts[j - 1] == self.counts[*j] + 1
        };
        let edges = (0..n).filter(|j| *j == 0 || !is_same(j)).chain([n]);
        Ordering {
            edges: edges.map(|j| j as u32).collect(),
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The nodes are 0 … n − 1.
    fn graph(n: usize, joins: &[(usize, usize)]) -> Adjacency {
        let mut others = vec![Vec::new(); n];
        for &(i, j) in joins {
            others[i].push(j as u32);
            others[j].push(i as u32);
        }
        let mut starts = vec![0];
        for others in &mut others {
            others.sort_unstable();
            others.dedup();
            starts.push(starts[starts.len() - 1] + others.len());
        }
        Adjacency {
            starts,
            others: others.concat(),
        }
    }

    /// A block of side³ nodes, each joined to its neighbours.
    fn block(side: usize) -> Adjacency {
        let node = |i: usize, j: usize, k: usize| (i * side + j) * side + k;
        let mut joins = Vec::new();
        for i in 0..side {
            for j in 0..side {
                for k in 1..side {
                    joins.push((node(i, j, k - 1), node(i, j, k)));
                    joins.push((node(k - 1, i, j), node(k, i, j)));
                    joins.push((node(i, k - 1, j), node(i, k, j)));
                }
            }
        }
        graph(side * side * side, &joins)
    }

    #[test]
    fn dissection_orders_graphs_of_any_kind() {
        let all = |n: usize| (0..n).flat_map(move |i| (0..i).map(move |j| (i, j)));
        let star: Vec<_> = (1..300).map(|i| (0, i)).collect();
        let ring: Vec<_> = (0..500).map(|i| (i, (i + 1) % 500)).collect();
        let mut random = 1;
        let mut draw = |most: usize| {
            let value = super::super::random::uniform(&mut random).abs();
            ((value * most as f64) as usize).min(most - 1)
        };
        let loose: Vec<_> = (0..600).map(|_| (draw(900), draw(900))).collect();
        let loose: Vec<_> = loose.into_iter().filter(|(i, j)| i != j).collect();
        let graphs = [
            graph(0, &[]),
            graph(1, &[]),
            graph(400, &[]),
            graph(60, &all(60).collect::<Vec<_>>()),
            graph(300, &star),
            graph(500, &ring),
            graph(900, &loose),
            block(9),
        ];
        for graph in &graphs {
            let mut order = nested_dissection(graph).expect("an order");
            order.sort_unstable();
            assert!(order.iter().copied().eq(0..graph.len() as u32));
        }
    }

    #[test]
    fn solids_take_less_work_by_dissection() {
        let solid = block(36);
        let most = usize::MAX;
        let by_degree = minimum_degree(&solid).expect("an order");
        let by_degree = Tree::of(&solid, by_degree, most).expect("a tree").work();
        let chosen = Ordering::of(&solid, most).expect("an order").work();
        assert!(chosen < 0.7 * by_degree, "{chosen:e} for {by_degree:e}");
    }

    #[test]
    fn supernodes_have_the_same_rows() {
        let ordering = Ordering::of(&block(7), usize::MAX).expect("an order");
        let mut next = 0;
        for columns in ordering.supernodes() {
            assert_eq!(columns.start, next);
            next = columns.end;
            let below = ordering.below(&columns);
            for j in columns.clone() {
                let rows = &ordering.rows[ordering.starts[j]..ordering.starts[j + 1]];
                let own = (j + 1..columns.end).map(|row| row as u32);
                assert!(own.chain(below.iter().copied()).eq(rows.iter().copied()));
            }
        }
        assert_eq!(next, 343);
    }
}
