//! What is not known of a state, with its directions.

use eigentone_digits::sort_by_number;

use crate::rows::{SLACK, length};

/// e = E r + d with |rᵢ| ≤ 1 and |dᵢ| ≤ boxᵢ: a parallelepiped that moves along with the state, so that errors which turn
/// round do not grow (Lohner, in Computational Ordinary Differential Equations, 1992), and a box for what was added since.
#[derive(Clone, Debug)]
pub(crate) struct ErrorSet {
    n: usize,
    /// E, by rows.
    edges: Vec<f64>,
    rest: Vec<f64>,
}

impl ErrorSet {
    pub(crate) fn new(n: usize, ball: f64) -> ErrorSet {
        ErrorSet {
            n,
            edges: vec![0.0; n * n],
            rest: vec![ball; n],
        }
    }

    /// A bound of |eᵢ|.
    fn extent(&self, i: usize) -> f64 {
        let row = &self.edges[i * self.n..(i + 1) * self.n];
        (row.iter().map(|entry| entry.abs()).sum::<f64>() + self.rest[i]) * SLACK
    }

    /// Bounds of all |eᵢ|.
    pub(crate) fn extents(&self) -> Vec<f64> {
        (0..self.n).map(|i| self.extent(i)).collect()
    }

    /// A bound of ‖D e‖, of a diagonal D.
    pub(crate) fn size_in(&self, scales: &[f64]) -> f64 {
        let extents: Vec<f64> = (0..self.n).map(|i| self.extent(i) * scales[i]).collect();
        length(&extents) * SLACK
    }

    /// A bound of |row·e|.
    pub(crate) fn along(&self, row: &[f64]) -> f64 {
        let n = self.n;
        let mut sum: f64 = row.iter().zip(&self.rest).map(|(a, b)| a.abs() * b).sum();
        let mut size = 0.0;
        let mut products = vec![0.0; n];
        for (i, entry) in row.iter().enumerate().filter(|(_, entry)| **entry != 0.0) {
            for (product, edge) in products.iter_mut().zip(&self.edges[i * n..]) {
                *product += entry * edge;
                size += (entry * edge).abs();
            }
        }
        sum += products.iter().map(|product| product.abs()).sum::<f64>();
        (sum + ROUNDING * n as f64 * size) * SLACK
    }

    /// Adds an error of any direction and this length.
    pub(crate) fn add(&mut self, ball: f64) {
        for rest in &mut self.rest {
            *rest = (*rest + ball) * SLACK;
        }
    }

    /// Adds an error of each entry.
    pub(crate) fn add_each(&mut self, errors: &[f64]) {
        for (rest, error) in self.rest.iter_mut().zip(errors) {
            *rest = (*rest + error) * SLACK;
        }
    }

    /// A e + B e, where A is the identity if none is given.
    pub(crate) fn mapped_with(&self, b: &[f64], a: Option<&[f64]>) -> ErrorSet {
        let n = self.n;
        let mut sum = b.to_vec();
        for i in 0..n {
            for j in 0..n {
                sum[i * n + j] += a.map_or(f64::from(u8::from(i == j)), |a| a[i * n + j]);
            }
        }
        let mut mapped = self.clone();
        mapped.map(&sum);
        mapped
    }

    /// e ← A e, of a matrix by rows whose entries are known to some roundings of their own.
    pub(crate) fn map(&mut self, a: &[f64]) {
        let n = self.n;
        let mut edges = vec![0.0; n * n];
        let mut rest = vec![0.0; n];
        for i in 0..n {
            let mut size = 0.0;
            for k in 0..n {
                let factor = a[i * n + k];
                if factor != 0.0 {
                    for j in 0..n {
                        let part = factor * self.edges[k * n + j];
                        edges[i * n + j] += part;
                        size += part.abs();
                    }
                    rest[i] += factor.abs() * self.rest[k];
                }
            }
            rest[i] = (rest[i] + ROUNDING * n as f64 * size) * SLACK;
        }
        (self.edges, self.rest) = (edges, rest);
        let known = |i: usize| self.extent(i) <= UNKNOWN;
        if !(0..n).all(known) {
            (self.edges, self.rest) = (vec![0.0; n * n], vec![UNKNOWN; n]);
        }
        let thick = (0..n).any(|i| self.rest[i] > 1e-6 * (self.extent(i) - self.rest[i]));
        if thick {
            self.fold();
        }
    }

    /// The least box, in directions of its own, around all: the rest becomes part of it.
    fn fold(&mut self) {
        let n = self.n;
        // What is known far better than the rest is in units of its own, so that it stays so; all else in one, in which
        // right angles are kept.
        let extents = self.extents();
        let largest = extents.iter().copied().fold(0.0, f64::max);
        let unit = |extent: &f64| {
            if *extent < largest * 1e-6 {
                *extent
            } else {
                largest
            }
        };
        let units: Vec<f64> = extents.iter().map(unit).collect();
        let scale = |i: usize| if units[i] > 0.0 { units[i] } else { 1.0 };
        let column = |j: usize| {
            (0..n)
                .map(|i| self.edges[i * n + j] / scale(i))
                .collect::<Vec<f64>>()
        };
        let mut columns: Vec<Vec<f64>> = (0..n).map(column).collect();
        sort_by_number(&mut columns, |column| -length(column));
        // Gram–Schmidt twice, by falling length; unit vectors where nothing is left.
        let mut basis: Vec<Vec<f64>> = Vec::with_capacity(n);
        let axes = (0..n).map(|k| {
            (0..n)
                .map(|i| f64::from(u8::from(i == k)))
                .collect::<Vec<f64>>()
        });
        for candidate in columns.iter().cloned().chain(axes) {
            if basis.len() == n {
                break;
            }
            let before = length(&candidate);
            if before == 0.0 {
                continue;
            }
            let mut left: Vec<f64> = candidate.iter().map(|entry| entry / before).collect();
            for _ in 0..2 {
                for direction in &basis {
                    let share: f64 = left.iter().zip(direction).map(|(a, b)| a * b).sum();
                    left.iter_mut()
                        .zip(direction)
                        .for_each(|(a, b)| *a -= share * b);
                }
            }
            let length = length(&left);
            if length > 1e-8 {
                basis.push(left.iter().map(|entry| entry / length).collect());
            }
        }
        let mut edges = vec![0.0; n * n];
        for (j, direction) in basis.iter().enumerate() {
            let of_edges = columns.iter().map(|column| {
                let share: f64 = column.iter().zip(direction).map(|(a, b)| a * b).sum();
                share.abs()
            });
            let of_rest = (0..n).map(|i| direction[i].abs() * self.rest[i] / scale(i));
            let extent = of_edges.sum::<f64>() + of_rest.sum::<f64>() + ROUNDING * (n * n) as f64;
            for i in 0..n {
                edges[i * n + j] = direction[i] * extent * units[i] * SLACK;
            }
        }
        self.edges = edges;
        self.rest = vec![0.0; n];
    }
}

/// Errors of this size say that nothing is known.
pub(crate) const UNKNOWN: f64 = 1e150;

/// More than a few roundings in doubles.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

#[cfg(test)]
mod tests {
    use super::*;

    /// A rotation by 1 rad, a million times: a ball carried by norms alone would be e^{0.3·10⁶} as large.
    #[test]
    fn errors_that_turn_do_not_grow() {
        let (s, c) = 1f64.sin_cos();
        let mut errors = ErrorSet::new(2, 1e-20);
        for _ in 0..1_000_000 {
            errors.map(&[c, s, -s, c]);
        }
        assert!(errors.size_in(&[1.0; 2]) < 1e-18);
    }
}
