//! K − σM assembled in an order of elimination, ready to be factorised at any shift σ.

use eigentone_digits::DoubleDouble;

use super::form::Form;
use super::ordering::{Adjacency, Ordering};

/// The most entries that a factor may have below its diagonal: 12 bytes each.
pub(crate) const MOST_ENTRIES: usize = 500_000_000;

/// Symmetric K, C and M with the pattern of their common factor.
#[derive(Clone, Debug)]
pub(crate) struct Pencil {
    pub(crate) stiffness: Form,
    /// 0 where there are no dampers, or they do not matter.
    pub(crate) damping: Form,
    pub(crate) mass: Form,
    pub(crate) ordering: Ordering,
    /// Where each column's joins to later places start, and where the last one's end.
    pub(crate) starts: Vec<usize>,
    pub(crate) rows: Vec<u32>,
    /// Of each join, parallel ones added up.
    pub(crate) stiffnesses: Vec<DoubleDouble>,
    /// The same of C; empty where C is diagonal.
    pub(crate) dampings: Vec<DoubleDouble>,
    /// The same of M; empty where M is diagonal.
    pub(crate) masses: Vec<DoubleDouble>,
    /// The most terms that an entry of the factor is the sum of.
    pub(crate) terms: usize,
}

impl Pencil {
    /// `None` where the factor would be larger than [`MOST_ENTRIES`].
    pub(crate) fn of(stiffness: Form, damping: Form, mass: Form) -> Option<Pencil> {
        Pencil::within(f64::INFINITY, stiffness, damping, mass)
    }

    /// The same where the factor takes at most so many multiplications.
    pub(crate) fn within(
        operations: f64,
        stiffness: Form,
        damping: Form,
        mass: Form,
    ) -> Option<Pencil> {
        let graph = adjacency(&[&stiffness, &damping, &mass]);
        // Each entry takes one at least.
        let most = MOST_ENTRIES.min(operations as usize);
        let ordering = Ordering::of(&graph, most)?;
        if ordering.work() > operations {
            return None;
        }
        let n = graph.len();
        let mut starts = Vec::with_capacity(n + 1);
        starts.push(0);
        let mut rows: Vec<u32> = Vec::with_capacity(graph.others.len() / 2);
        for (place, &node) in ordering.nodes.iter().enumerate() {
            let later = graph.of(node as usize).iter();
            let later = later.map(|&other| ordering.places[other as usize]);
            rows.extend(later.filter(|&other| other as usize > place));
            rows[starts[place]..].sort_unstable();
            starts.push(rows.len());
        }
        let terms = terms(&ordering);
        let mut pencil = Pencil {
            stiffness,
            damping,
            mass,
            ordering,
            starts,
            rows,
            stiffnesses: Vec::new(),
            dampings: Vec::new(),
            terms,
            masses: Vec::new(),
        };
        pencil.stiffnesses = pencil.weights(&pencil.stiffness);
        if !pencil.damping.is_diagonal() {
            pencil.dampings = pencil.weights(&pencil.damping);
        }
        if !pencil.mass.is_diagonal() {
            pencil.masses = pencil.weights(&pencil.mass);
        }
        Some(pencil)
    }

    /// The same with another C that joins no other nodes.
    pub(crate) fn with_damping(&self, damping: Form) -> Pencil {
        let mut pencil = self.clone();
        pencil.dampings = match damping.is_diagonal() {
            true => Vec::new(),
            false => pencil.weights(&damping),
        };
        pencil.damping = damping;
        pencil
    }

    /// M, C and K.
    pub(crate) fn forms(&self) -> [&Form; 3] {
        [&self.mass, &self.damping, &self.stiffness]
    }

    /// The order n.
    pub(crate) fn len(&self) -> usize {
        self.stiffness.len()
    }

    fn weights(&self, form: &Form) -> Vec<DoubleDouble> {
        let mut weights = vec![DoubleDouble::ZERO; self.rows.len()];
        for join in form.joins() {
            let [a, b] = join.ends.map(|node| self.ordering.places[node as usize]);
            let column = a.min(b) as usize;
            let range = self.starts[column]..self.starts[column + 1];
            if let Ok(at) = self.rows[range.clone()].binary_search(&a.max(b)) {
                weights[range.start + at] += DoubleDouble::from(join.weight);
            }
        }
        weights
    }
}

/// The most entries that a row and its column of L have together.
fn terms(ordering: &Ordering) -> usize {
    let mut counts: Vec<usize> = ordering.starts.windows(2).map(|w| w[1] - w[0]).collect();
    for &row in &ordering.rows {
        counts[row as usize] += 1;
    }
    counts.into_iter().max().unwrap_or(0)
}

/// Which nodes are joined in any of the forms.
fn adjacency(forms: &[&Form]) -> Adjacency {
    let n = forms[0].len();
    let joins = || forms.iter().flat_map(|form| form.joins());
    let mut starts = vec![0usize; n + 1];
    for join in joins() {
        let (i, j) = join.ends();
        starts[i + 1] += 1;
        starts[j + 1] += 1;
    }
    for i in 0..n {
        starts[i + 1] += starts[i];
    }
    let mut ends = starts.clone();
    let mut others = vec![0u32; starts[n]];
    for join in joins() {
        let (i, j) = join.ends();
        (others[ends[i]], others[ends[j]]) = (join.ends[1], join.ends[0]);
        ends[i] += 1;
        ends[j] += 1;
    }
    // Each once.
    let (mut kept, mut start) = (0, 0);
    for i in 0..n {
        let end = starts[i + 1];
        others[start..end].sort_unstable();
        let first = kept;
        for at in start..end {
            if kept == first || others[kept - 1] != others[at] {
                others[kept] = others[at];
                kept += 1;
            }
        }
        start = end;
        starts[i + 1] = kept;
    }
    others.truncate(kept);
    Adjacency { starts, others }
}
