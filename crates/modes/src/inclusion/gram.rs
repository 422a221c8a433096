//! XᵀAX of a symmetric matrix A given by elements, in double-double, with bounds of its errors.

use eigentone_digits::{DoubleDouble, Lanes};
use faer::MatRef;
use pulp::{Arch, Simd, WithSimd};

use crate::element::{Element, MatrixKind, Node};
use crate::system::System;

/// Sums of doubles that are all ≥ 0 are this near their truth for any length in reach.
pub(super) const UPWARD: f64 = 1.0 + 1e-9;

/// A quadratic form Σ_e k_e (x_a − x_b)² + xᵀAx of elements e = (a, b) and a symmetric matrix A.
pub(super) struct Form<'a> {
    n: usize,
    elements: Vec<Element>,
    matrix: Option<MatRef<'a, f64>>,
}

/// XᵀAX for a form and columns X, with how far its entries may be off.
pub(super) struct Gram {
    pub(super) size: usize,
    /// By rows.
    entries: Vec<DoubleDouble>,
    /// Entry (i, j), i ≤ j, is off by at most unit·first_i·second_j + floor.
    first: Vec<f64>,
    second: Vec<f64>,
    unit: f64,
    floor: f64,
}

impl<'a> Form<'a> {
    pub(super) fn stiffness(system: &'a System) -> Form<'a> {
        Form {
            n: system.len(),
            elements: system.springs().to_vec(),
            matrix: system.added(MatrixKind::Stiffness),
        }
    }

    pub(super) fn damping(system: &'a System) -> Form<'a> {
        Form {
            n: system.len(),
            elements: system.dampers().to_vec(),
            matrix: system.added(MatrixKind::Damping),
        }
    }

    /// C + shift·M, as near as doubles come to it.
    pub(super) fn shifted_damping(
        system: &System,
        shift: f64,
        matrix: Option<MatRef<'a, f64>>,
    ) -> Form<'a> {
        let mass = Form::mass(system).elements.into_iter();
        let grounded = mass.map(|element| Element {
            coefficient: shift * element.coefficient,
            ..element
        });
        Form {
            n: system.len(),
            elements: system.dampers().iter().copied().chain(grounded).collect(),
            matrix,
        }
    }

    pub(super) fn mass(system: &'a System) -> Form<'a> {
        let lumped = system.masses().iter().enumerate().map(|(i, mass)| Element {
            first: Node::Coordinate(i),
            second: Node::Ground,
            coefficient: *mass,
        });
        Form {
            n: system.len(),
            elements: lumped.collect(),
            matrix: system.added(MatrixKind::Mass),
        }
    }

    /// Entry (i, j), i ≤ j, is the sum over elements of (k·stretch_i)·stretch_j, so that soft springs
    /// survive beside stiff ones; where elements are many, and for A, the sum over nodes of
    /// force_i·x_j.
    ///
    /// Each entry is a sum of products whose factors err by at most `count` roundings of 2^-102 one upon
    /// the other, and which [`Lanes::products`] sums: it errs by a `unit` of the sum of the absolute products. That
    /// in turn is bounded by the inequality of Cauchy and Schwarz over all pairs it runs over:
    /// Σ|k||s_i||s_j| ≤ √(Σ|k|s_i²)·√(Σ|k|s_j²), and likewise Σ|k||s_i|(|x_aj| + |x_bj|) and
    /// Σ|A_ab||x_ai||x_bj|.
    pub(super) fn gram(&self, columns: &[Vec<DoubleDouble>]) -> Gram {
        let (n, size) = (self.n, columns.len());
        let by_stretch = self.elements.len() <= 4 * n;
        let by_force = self.matrix.is_some() || !by_stretch;
        // Per node, what a unit displacement meets in absolute terms, and how many terms it is.
        let (mut load, mut terms) = (vec![0.0; n], vec![0usize; n]);
        let ends = |element: &Element| [element.first, element.second].map(Node::coordinate);
        if !by_stretch {
            for element in &self.elements {
                for i in ends(element).into_iter().flatten() {
                    load[i] += element.coefficient.abs();
                    terms[i] += 1;
                }
            }
        }
        let mut row_sums = vec![0.0; n];
        // The entries of the matrix that are not 0, by columns.
        let mut entries: Vec<Vec<(usize, f64)>> = Vec::new();
        if let Some(matrix) = self.matrix {
            for j in 0..n {
                let column = matrix.col(j).iter().copied().enumerate();
                let column: Vec<(usize, f64)> = column.filter(|entry| entry.1 != 0.0).collect();
                for (i, entry) in &column {
                    row_sums[*i] += entry.abs();
                    terms[*i] += 1;
                }
                entries.push(column);
            }
        }
        let (mut inner, mut outer) = (Vec::with_capacity(size), Vec::with_capacity(size));
        let (mut first, mut second) = (Vec::with_capacity(size), Vec::with_capacity(size));
        let mut largest = 0.0;
        for x in columns {
            let at = |node: Node| node.coordinate().map_or(DoubleDouble::ZERO, |i| x[i]);
            let stretches: Vec<DoubleDouble> = self
                .elements
                .iter()
                .map(|element| at(element.first) - at(element.second))
                .collect();
            let forces = self.elements.iter().zip(&stretches);
            let mut forces: Vec<DoubleDouble> = forces
                .map(|(e, stretch)| *stretch * e.coefficient)
                .collect();
            let energy = self.elements.iter().zip(&stretches);
            let energy: f64 = energy
                .map(|(e, stretch)| square(e.coefficient, stretch.to_f64()))
                .sum();
            let over = |weights: &[f64]| -> f64 {
                let each = weights.iter().zip(x);
                each.map(|(weight, x)| square(*weight, x.to_f64())).sum()
            };
            let along = over(&row_sums);
            if by_stretch {
                first.push((energy + along).sqrt() * UPWARD);
                second.push((energy + along).sqrt() * UPWARD);
            } else {
                first.push((2.0 * energy + along).sqrt() * UPWARD);
                second.push((over(&load) + along).sqrt() * UPWARD);
            }
            let mut right = if by_stretch { stretches } else { Vec::new() };
            if by_force {
                let mut nodal = vec![DoubleDouble::ZERO; n];
                if !by_stretch {
                    for (element, force) in self.elements.iter().zip(&forces) {
                        let [first, second] = ends(element);
                        if let Some(i) = first {
                            nodal[i] += *force;
                        }
                        if let Some(i) = second {
                            nodal[i] -= *force;
                        }
                    }
                    forces.clear();
                }
                for (x, column) in x.iter().zip(&entries) {
                    for (i, entry) in column {
                        nodal[*i] += *x * *entry;
                    }
                }
                forces.extend(nodal);
                right.extend(x);
            }
            largest = right
                .iter()
                .map(|x| x.to_f64().abs())
                .fold(largest, f64::max);
            inner.push(forces);
            outer.push(right);
        }
        let length = outer.first().map_or(0, Vec::len);
        let entries = Arch::new().dispatch(Products {
            inner: &inner,
            outer: &outer,
        });
        // Both stretches, k·stretch and the sum of forces; then the sum of products.
        let count = 4 + terms.into_iter().max().unwrap_or(0);
        let summed = (length + 4) as f64;
        Gram {
            size,
            entries,
            first,
            second,
            unit: (count + 1) as f64 * 2f64.powi(-102) + summed * summed * 2f64.powi(-106),
            // Products that underflow err by 2^-1060 each, and those of a force are multiplied on.
            floor: 1e-300 * (1.0 + largest),
        }
    }
}

/// All products of one set of columns with another that are the entries of a symmetric matrix, by rows.
struct Products<'a> {
    inner: &'a [Vec<DoubleDouble>],
    outer: &'a [Vec<DoubleDouble>],
}

impl WithSimd for Products<'_> {
    type Output = Vec<DoubleDouble>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<DoubleDouble> {
        // Processors with vectors of doubles fuse multiplications and additions.
        if S::F64_LANES > 1 {
            self.sums::<true>()
        } else {
            self.sums::<false>()
        }
    }
}

impl Products<'_> {
    #[inline(always)]
    fn sums<const FUSED: bool>(self) -> Vec<DoubleDouble> {
        let size = self.outer.len();
        let length = self.outer.first().map_or(0, Vec::len);
        let mut sums = vec![DoubleDouble::ZERO; size * size];
        for (block, columns) in self.outer.chunks(LANES).enumerate() {
            let side_by_side = interleaved(columns, length);
            let j = block * LANES;
            for (i, row) in self.inner.iter().enumerate().take(j + columns.len()) {
                let found = Lanes::products::<FUSED>(row, &side_by_side);
                for (j, sum) in (j..j + columns.len()).zip(found).filter(|(j, _)| i <= *j) {
                    sums[i * size + j] = sum;
                    sums[j * size + i] = sum;
                }
            }
        }
        sums
    }
}

/// So many sums at a time: one alone would wait for each of its own additions to end.
const LANES: usize = 8;

/// Columns side by side, entry by entry; those that are missing are 0.
fn interleaved(columns: &[Vec<DoubleDouble>], length: usize) -> Vec<Lanes<LANES>> {
    let mut rows = vec![Lanes::ZERO; length];
    for (lane, column) in columns.iter().enumerate() {
        for (row, entry) in rows.iter_mut().zip(column) {
            row.set(lane, *entry);
        }
    }
    rows
}

/// k·x², no smaller than the truth by more than `UPWARD` wherever it underflows.
fn square(k: f64, x: f64) -> f64 {
    let root = k.abs().sqrt() * x;
    root * root + f64::MIN_POSITIVE
}

impl Gram {
    pub(super) fn at(&self, i: usize, j: usize) -> DoubleDouble {
        self.entries[i * self.size + j]
    }

    /// A bound of |entry (i, j)|.
    pub(super) fn upper(&self, i: usize, j: usize) -> f64 {
        (self.at(i, j).to_f64().abs() + self.error(i, j)) * UPWARD
    }

    /// How far entry (i, j) may be off.
    pub(super) fn error(&self, i: usize, j: usize) -> f64 {
        let (a, b) = (i.min(j), i.max(j));
        (self.unit * self.first[a] * self.second[b] + self.floor) * UPWARD
    }

    /// A bound of ‖E‖ for this matrix = δ^{1/2}(I + E)δ^{1/2}, δ its computed diagonal; NaN or
    /// infinite where there is none.
    pub(super) fn distance(&self) -> f64 {
        let roots: Vec<f64> = (0..self.size)
            .map(|i| self.at(i, i).to_f64().sqrt())
            .collect();
        let mut largest = 0.0;
        for i in 0..self.size {
            let sum: f64 = (0..self.size)
                .map(|j| {
                    let entry = if i == j {
                        self.error(i, j)
                    } else {
                        self.upper(i, j)
                    };
                    entry / roots[i] / roots[j]
                })
                .sum();
            if !sum.is_finite() {
                return sum;
            }
            largest = sum.max(largest);
        }
        largest * UPWARD
    }
}
