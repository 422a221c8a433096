//! The factor F = D_k^{1/2} G M^{-1/2} of a network's springs as a product X D U that keeps the
//! digits of every singular value.
//!
//! Where stiff springs close a cycle, the soft motions of F rest on G·1 = 0 around it, which the
//! rounding of F itself destroys. So the springs of a spanning tree of the greatest stiffness are
//! taken first: every other one stretches by a sum of stretches ±s_t along the tree, and with
//! T = D_t^{1/2} G_t M^{-1/2} for the tree alone
//!
//! F = B T, B = [I; D_c^{1/2} N D_t^{-1/2}], N of entries 0 and ±1, |B_ij| ≤ 1.
//!
//! T is acyclic, so that elimination with complete pivoting finds T = L D U without one subtraction
//! (Demmel et al. 1999, *Lin. Alg. Appl.* 299, §6): the pivot joins two nodes into one, and what is
//! left is a tree again. L, U and X = B L are well conditioned, and their rounding changes each
//! singular value of X D U by a few units (theorem 2.1 there).

use eigentone_digits::sort_by_number;
use faer::Mat;

use crate::model::{Element, Node};

/// W (r × n) with WᵀW = FᵀF, whose rows are far from dependent once scaled to one length
/// (algorithm 3.1 of Demmel et al.). `columns` gives the column of each coordinate, `masses` the
/// mass of each column.
pub(crate) fn factor(springs: &[Element], columns: &[Option<usize>], masses: &[f64]) -> Mat<f64> {
    let network = Network::of(springs, columns, masses.len());
    let Eliminated {
        lower,
        pivots,
        upper,
    } = network.eliminate(masses);
    let rank = pivots.len();
    let mut graded = Mat::zeros(rank + network.others.len(), rank);
    graded.submatrix_mut(0, 0, rank, rank).copy_from(&lower);
    for (row, other) in network.others.iter().enumerate() {
        for (t, share) in network.cycle(other) {
            for j in 0..rank {
                graded[(rank + row, j)] += share * lower[(t, j)];
            }
        }
    }
    for (j, pivot) in pivots.iter().enumerate() {
        for i in 0..graded.nrows() {
            graded[(i, j)] *= pivot;
        }
    }
    let qr = graded.col_piv_qr();
    let (order, _) = qr.P().arrays();
    let sorted = Mat::from_fn(rank, masses.len(), |i, j| upper[(order[i], j)]);
    let triangle = qr.thin_R();
    Mat::from_fn(
        rank,
        rank,
        |i, j| if i <= j { triangle[(i, j)] } else { 0.0 },
    ) * sorted
}

/// A spring between two columns; the last of all nodes is the ground.
#[derive(Clone, Copy, Debug)]
struct Join {
    ends: [usize; 2],
    /// √k.
    root: f64,
}

/// Springs on a spanning forest of the greatest stiffness, and the others.
struct Network {
    tree: Vec<Join>,
    others: Vec<Join>,
    /// For each node the node before it on the way from the root of its tree, and the spring there.
    before: Vec<Option<(usize, usize)>>,
    depth: Vec<usize>,
}

/// T = L D U: L (r × r) by springs and pivots, U (r × n) by pivots and columns.
struct Eliminated {
    lower: Mat<f64>,
    pivots: Vec<f64>,
    upper: Mat<f64>,
}

impl Network {
    fn of(springs: &[Element], columns: &[Option<usize>], count: usize) -> Network {
        let ground = count;
        let node = |end: Node| {
            let column = end.coordinate().and_then(|i| columns[i]);
            column.unwrap_or(ground)
        };
        let mut joins: Vec<Join> = springs
            .iter()
            .map(|spring| Join {
                ends: [node(spring.first), node(spring.second)],
                root: spring.coefficient.sqrt(),
            })
            .filter(|join| join.root > 0.0)
            .collect();
        sort_by_number(&mut joins, |join| -join.root);
        let mut label: Vec<usize> = (0..=count).collect();
        let (mut tree, mut others) = (Vec::new(), Vec::new());
        for join in joins {
            let [from, to] = join.ends.map(|node| label[node]);
            if from == to {
                others.push(join);
            } else {
                let within = label.iter_mut().filter(|label| **label == from);
                within.for_each(|label| *label = to);
                tree.push(join);
            }
        }
        let mut touching = vec![Vec::new(); count + 1];
        for (t, join) in tree.iter().enumerate() {
            let [a, b] = join.ends;
            touching[a].push((b, t));
            touching[b].push((a, t));
        }
        let (mut before, mut depth) = (vec![None; count + 1], vec![usize::MAX; count + 1]);
        for root in (0..=count).rev() {
            if depth[root] != usize::MAX {
                continue;
            }
            depth[root] = 0;
            let mut reached = vec![root];
            while let Some(at) = reached.pop() {
                for &(next, t) in &touching[at] {
                    if depth[next] == usize::MAX {
                        depth[next] = depth[at] + 1;
                        before[next] = Some((at, t));
                        reached.push(next);
                    }
                }
            }
        }
        Network {
            tree,
            others,
            before,
            depth,
        }
    }

    /// The row of B for a spring outside the tree: its entries that are not 0.
    fn cycle(&self, spring: &Join) -> Vec<(usize, f64)> {
        let [mut a, mut b] = spring.ends;
        let mut row = Vec::new();
        let mut climb = |from: &mut usize, sign: f64| {
            if let Some((next, t)) = self.before[*from] {
                let join = &self.tree[t];
                // From its first end towards its second one, a tree spring counts as it is.
                let along = if join.ends[0] == *from { sign } else { -sign };
                row.push((t, along * (spring.root / join.root)));
                *from = next;
            }
        };
        while a != b {
            if self.depth[a] >= self.depth[b] {
                climb(&mut a, 1.0);
            } else {
                climb(&mut b, -1.0);
            }
        }
        row
    }

    fn eliminate(&self, masses: &[f64]) -> Eliminated {
        let ground = masses.len();
        let rank = self.tree.len();
        let mut rows: Vec<Vec<(usize, f64)>> = self
            .tree
            .iter()
            .map(|join| {
                let [a, b] = join.ends;
                let entries = [(a, join.root), (b, -join.root)].into_iter();
                let inside = entries.filter(|(node, _)| *node != ground);
                inside
                    .map(|(node, entry)| (node, entry / masses[node].sqrt()))
                    .collect()
            })
            .collect();
        let mut lower = Mat::zeros(rank, rank);
        let mut upper = Mat::zeros(rank, masses.len());
        let mut pivots = Vec::with_capacity(rank);
        let mut left: Vec<usize> = (0..rank).collect();
        for p in 0..rank {
            let largest = |row: &usize| {
                let sizes = rows[*row].iter().map(|(_, entry)| entry.abs());
                sizes.fold(0.0, f64::max)
            };
            let place = (0..left.len())
                .max_by(|a, b| largest(&left[*a]).total_cmp(&largest(&left[*b])))
                .expect("as many rows are left as pivots");
            let row = left.swap_remove(place);
            let entries = std::mem::take(&mut rows[row]);
            let by_size = |a: &&(usize, f64), b: &&(usize, f64)| a.1.abs().total_cmp(&b.1.abs());
            let Some(&(column, pivot)) = entries.iter().max_by(by_size) else {
                continue;
            };
            let partner = entries.iter().find(|(node, _)| *node != column).copied();
            pivots.push(pivot);
            lower[(row, p)] = 1.0;
            upper[(p, column)] = 1.0;
            if let Some((node, entry)) = partner {
                upper[(p, node)] = entry / pivot;
            }
            for &other in &left {
                let Some(at) = rows[other].iter().position(|(node, _)| *node == column) else {
                    continue;
                };
                let (_, entry) = rows[other].swap_remove(at);
                lower[(other, p)] = entry / pivot;
                if let Some((node, share)) = partner {
                    // A tree has no second spring between the two nodes: nothing is subtracted.
                    rows[other].push((node, -(entry / pivot) * share));
                }
            }
        }
        Eliminated {
            lower,
            pivots,
            upper,
        }
    }
}
