//! Columns of a cluster of real roots that nearly depend on each other, given anew.

use eigentone_digits::{DoubleDouble, sort_by_number, symmetric_eigen};
use faer::Mat;

use super::pair::{Pairs, Parts, plain};
use super::rows::Rows;

impl Pairs<'_> {
    /// Replaces the shapes of k real roots that doubles do not distinguish by the k vectors that Q(ρ) of a symmetric system
    /// nearly annuls: a solver in doubles finds any vectors of their space, which may be nearly dependent. `None`, with all
    /// as before, where Q(ρ) does not have just so many.
    pub(super) fn span(&mut self, rows: &Rows, group: &[usize]) -> Option<()> {
        /// Roots that differ by more have shapes of their own.
        const ALIKE: f64 = 1e-10;
        /// Of the sizes of what Q(ρ) annuls and of what it does not.
        const GAP: f64 = 1e-3;
        let (n, k) = (self.system.len(), group.len());
        let rho = plain(rows.rho[group[0]]).re;
        let is_one_of_them = |i: &usize| {
            let near = (plain(rows.rho[*i]) - rho).norm() <= ALIKE * rho.abs();
            near && self.pairs[*i].is_real() && self.pairs[*i].mode().is_some()
        };
        if self.has_left() || k >= n || !group.iter().all(is_one_of_them) {
            return None;
        }
        let [m, c, stiffness] = [
            self.system.mass_matrix(),
            self.system.damping_matrix(),
            self.system.stiffness_matrix(),
        ];
        let terms =
            |i: usize, j: usize| [rho * rho * m[(i, j)], rho * c[(i, j)], stiffness[(i, j)]];
        let size = |i: usize| terms(i, i).iter().map(|term| term.abs()).sum::<f64>();
        let scale: Vec<f64> = (0..n).map(|i| size(i).sqrt().recip()).collect();
        let entry = |i: usize, j: usize| terms(i, j).iter().sum::<f64>() * scale[i] * scale[j];
        let scaled = Mat::from_fn(n, n, entry);
        let (values, vectors) = symmetric_eigen(&scaled)?;
        let mut order: Vec<usize> = (0..n).collect();
        sort_by_number(&mut order, |i| values[*i].abs());
        let [last, next] = [order[k - 1], order[k]].map(|at| values[at].abs());
        if last.is_nan() || last > GAP * next {
            return None;
        }
        for (i, at) in group.iter().zip(order) {
            let shape = vectors.col(at).iter().zip(&scale);
            self.pairs[*i].right = Parts {
                re: shape
                    .map(|(x, scale)| DoubleDouble::from(x * scale))
                    .collect(),
                im: Vec::new(),
            };
        }
        Some(())
    }
}
