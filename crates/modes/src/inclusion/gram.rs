//! XᵀAX and YᵀAX of a matrix A given by elements, in double-double, with bounds of their errors.

use std::collections::BTreeMap;
use std::rc::Rc;

use eigentone_digits::{DoubleDouble, Lanes};
use faer::MatRef;

use super::sliced::{self, Rounding};
use super::summed::{self, Rows};
use crate::model::{Element, MatrixKind, Node, Term};
use crate::system::System;

/// Sums of doubles that are all ≥ 0 are this near their truth for any length in reach.
pub(super) const UPWARD: f64 = 1.0 + 1e-9;

/// From so many columns on products of matrices of doubles are quicker than double-doubles.
const LARGE: usize = 48;

/// The same for products with a full matrix.
const FULL: usize = 64;

/// As many as leave no more than what double-doubles round.
pub(super) const SLICES: usize = 3;

/// How many times as large errors of forms that are found from others may become.
pub(super) const LITTLE: f64 = 1.25;

/// A form Σ_e k_e (y_a − y_b)(x_a − x_b) + yᵀAx of elements e = (a, b) and a matrix A.
pub(super) struct Form<'a> {
    pub(super) n: usize,
    elements: Vec<Element>,
    pub(super) matrix: Option<MatRef<'a, f64>>,
    /// What is left of the entries of the matrix.
    tails: &'a [Term],
}

/// XᵀAX or YᵀAX for a form and columns X and Y, with how far its entries may be off.
pub(super) struct Gram {
    /// How many columns X has.
    pub(super) size: usize,
    /// By rows.
    pub(super) entries: Vec<DoubleDouble>,
    /// How far each may be off.
    pub(super) errors: Vec<f64>,
    /// Of XᵀAX: Σ|A_rs||x_ri||x_sj|, over elements and matrix, is no more than the product of these sizes of x_i and x_j.
    pub(super) sizes: Vec<f64>,
    /// In so many slices it was found, where it was.
    pub(super) slices: usize,
    /// How many times as large errors have become since it was found anew.
    pub(super) growth: f64,
    /// Where XᵀAX of columns nearby is found from this.
    pub(super) kept: Option<Kept>,
}

/// What the form of columns nearby is found from.
pub(super) struct Kept {
    /// X, and AX with how far it may be off beside rounding, node by column.
    pub(super) columns: Vec<Vec<DoubleDouble>>,
    pub(super) forces: Vec<Vec<DoubleDouble>>,
    pub(super) of_forces: Option<Rounding>,
    pub(super) weights: Rc<Weights>,
    /// How far the columns have moved, as |A| counts it, since AX was found.
    pub(super) moved: Vec<f64>,
}

impl<'a> Form<'a> {
    pub(super) fn stiffness(system: &'a System) -> Form<'a> {
        Form {
            n: system.len(),
            elements: system.springs().to_vec(),
            matrix: system.added(MatrixKind::Stiffness),
            tails: system.model().tails(MatrixKind::Stiffness),
        }
    }

    pub(super) fn damping(system: &'a System) -> Form<'a> {
        Form {
            n: system.len(),
            elements: system.dampers().to_vec(),
            matrix: system.added(MatrixKind::Damping),
            tails: system.model().tails(MatrixKind::Damping),
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
            tails: &[],
        }
    }

    pub(super) fn mass(system: &'a System) -> Form<'a> {
        let masses = system.masses().iter().enumerate();
        let lumped = masses.filter(|(_, mass)| **mass != 0.0);
        let lumped = lumped.map(|(i, mass)| Element {
            first: Node::Coordinate(i),
            second: Node::Ground,
            coefficient: *mass,
        });
        Form {
            n: system.len(),
            elements: lumped.collect(),
            matrix: system.added(MatrixKind::Mass),
            tails: system.model().tails(MatrixKind::Mass),
        }
    }

    /// XᵀAX of a symmetric form.
    pub(super) fn gram(&self, columns: &[Vec<DoubleDouble>]) -> Gram {
        self.gram_in(SLICES, columns)
    }

    /// The same, in so many slices where [`is_sliced`](Self::is_sliced).
    pub(super) fn gram_in(&self, slices: usize, columns: &[Vec<DoubleDouble>]) -> Gram {
        self.products(columns, None, slices)
    }

    /// Whether products of so many columns with as many others are taken in slices.
    pub(super) fn is_sliced(&self, columns: usize) -> bool {
        self.matrix.is_some() && columns >= LARGE
    }

    /// YᵀAX.
    pub(super) fn between(&self, left: &[Vec<DoubleDouble>], right: &[Vec<DoubleDouble>]) -> Gram {
        self.products(left, Some(right), SLICES)
    }

    /// Entry (i, j) is the sum over elements of (k·stretch_i)·stretch_j, so that soft springs
    /// survive beside stiff ones; where elements are many, and for A, the sum over nodes of
    /// force_i·x_j. Without columns of their own on the right, the entries are those for i ≤ j.
    ///
    /// Each entry is a sum of products whose factors err by at most a number of roundings of 2^-102 one upon
    /// the other, and which [`Lanes::products`] sums: it errs by a `unit` of the sum of the absolute products. That
    /// in turn is bounded by the inequality of Cauchy and Schwarz over all pairs it runs over:
    /// Σ|k||s_i||s_j| ≤ √(Σ|k|s_i²)·√(Σ|k|s_j²), and likewise Σ|k||s_i|(|x_aj| + |x_bj|) and
    /// Σ|A_ab||x_ai||x_bj|.
    fn products(
        &self,
        left: &[Vec<DoubleDouble>],
        right: Option<&[Vec<DoubleDouble>]>,
        slices: usize,
    ) -> Gram {
        let weights = Weights::of(self);
        let (mut nodal, of_forces) = self.nodal_forces(&weights, left, slices);
        let left = left.iter().zip(&mut nodal);
        let mut left: Vec<Side> = left
            .map(|(x, nodal)| self.side(&weights, x, Some(std::mem::take(nodal))))
            .collect();
        let right = right.map(|right| -> Vec<Side> {
            let each = right.iter();
            each.map(|x| self.side(&weights, x, None)).collect()
        });
        let is_symmetric = right.is_none();
        let inner: Vec<Vec<DoubleDouble>> = left
            .iter_mut()
            .map(|side| std::mem::take(&mut side.forces))
            .collect();
        let first: Vec<f64> = left.iter().map(|side| side.first).collect();
        let right = right.unwrap_or(left);
        let second: Vec<f64> = right.iter().map(|side| side.second).collect();
        let both = first.iter().zip(&second);
        let sizes = both.map(|(first, second)| first.max(*second)).collect();
        let outer: Vec<Vec<DoubleDouble>> = right.into_iter().map(|side| side.stretches).collect();
        let each = outer.iter().flatten().map(|x| x.to_f64().abs());
        let largest = each.fold(0.0, f64::max);
        let size = outer.len();
        let length = outer.first().map_or(0, Vec::len);
        let factors = Rounding {
            unit: weights.unit(of_forces.is_some()),
            first,
            second,
        };
        let on_columns = of_forces.as_ref().map(|rounding| {
            let felt = |x: &Vec<DoubleDouble>| rounding.felt(&x[length - self.n..]);
            Rounding {
                unit: rounding.unit,
                first: rounding.second.clone(),
                second: outer.iter().map(felt).collect(),
            }
        });
        let is_sliced = self.is_sliced(inner.len().min(size));
        let sliced = is_sliced.then(|| sliced::products(&inner, &outer, slices, is_symmetric));
        let (entries, mut roundings) = match sliced.flatten() {
            Some((entries, products)) => (entries, vec![factors, products]),
            None => {
                let entries = summed::products(Rows::Full(&inner), &outer, is_symmetric);
                let summed = (length + 4) as f64;
                let both = Rounding {
                    unit: factors.unit + summed * summed * 2f64.powi(-106),
                    ..factors
                };
                (entries, vec![both])
            }
        };
        roundings.extend(on_columns);
        // Of others AX costs less than what finds the form of columns nearby.
        let keeps = is_sliced && is_symmetric && self.elements.is_empty() && weights.is_full();
        // Products that underflow err by 2^-1060 each, and those of a force are multiplied on.
        let floor = 1e-300 * (1.0 + largest);
        Gram {
            size,
            sizes,
            slices,
            growth: 1.0,
            entries,
            errors: errors(&roundings, floor, is_symmetric),
            kept: keeps.then(|| Kept {
                columns: outer,
                forces: inner,
                of_forces,
                weights: weights.into(),
                moved: vec![0.0; size],
            }),
        }
    }
}

/// A bound of the errors of XᵀY + YᵀX, given that of XᵀY.
pub(super) fn both_ways(unit: f64, first: &[f64], second: &[f64]) -> [Rounding; 2] {
    [(first, second), (second, first)].map(|(first, second)| Rounding {
        unit,
        first: first.to_vec(),
        second: second.to_vec(),
    })
}

/// Bounds of the errors of all entries by rows, the sums of `floor` and all roundings; where symmetric those of entry (j, i) are
/// those of (i, j), i ≤ j.
pub(super) fn errors(roundings: &[Rounding], floor: f64, is_symmetric: bool) -> Vec<f64> {
    let Some(Rounding { first, second, .. }) = roundings.first() else {
        return Vec::new();
    };
    let (count, size) = (first.len(), second.len());
    let mut errors = vec![floor; count * size];
    for (i, row) in errors.chunks_exact_mut(size.max(1)).enumerate() {
        for rounding in roundings {
            let factor = rounding.unit * rounding.first[i];
            for (error, second) in row.iter_mut().zip(&rounding.second) {
                *error += factor * second;
            }
        }
        row.iter_mut().for_each(|error| *error *= UPWARD);
    }
    if is_symmetric {
        for i in 0..size {
            for j in 0..i {
                errors[i * size + j] = errors[j * size + i];
            }
        }
    }
    errors
}

impl Form<'_> {
    /// √Σ(load·x)² is a size of x as a [`Gram`] has them, for symmetric A.
    pub(super) fn loads(&self) -> Vec<f64> {
        let mut loads = vec![0.0; self.n];
        for element in &self.elements {
            for i in ends(element).into_iter().flatten() {
                loads[i] += 2.0 * element.coefficient.abs();
            }
        }
        if let Some(matrix) = self.matrix {
            for (load, column) in loads.iter_mut().zip(matrix.col_iter()) {
                *load += column.iter().map(|entry| entry.abs()).sum::<f64>() * UPWARD;
            }
        }
        loads.iter_mut().for_each(|load| *load = load.sqrt());
        loads
    }

    /// Aᵀx for each of the columns x, and where A is taken in slices how far they may be off, node by column.
    fn nodal_forces(
        &self,
        weights: &Weights,
        columns: &[Vec<DoubleDouble>],
        slices: usize,
    ) -> (Vec<Vec<DoubleDouble>>, Option<Rounding>) {
        if weights.entries.is_empty() {
            return (vec![vec![DoubleDouble::ZERO; self.n]; columns.len()], None);
        }
        let is_full = columns.len() >= FULL && weights.is_full();
        let whole = |entries: &Vec<(usize, f64)>| {
            let mut column = vec![DoubleDouble::ZERO; self.n];
            for (i, entry) in entries {
                column[*i] += DoubleDouble::from(*entry);
            }
            column
        };
        let in_slices = || {
            let matrix: Vec<Vec<DoubleDouble>> = weights.entries.iter().map(whole).collect();
            sliced::products(columns, &matrix, slices, false)
        };
        if let Some((entries, rounding)) = is_full.then(in_slices).flatten() {
            let forces = entries.chunks_exact(self.n).map(<[_]>::to_vec).collect();
            let rounding = Rounding {
                unit: rounding.unit,
                first: rounding.second,
                second: rounding.first,
            };
            return (forces, Some(rounding));
        }
        let entries = summed::products(Rows::Sparse(&weights.entries), columns, false);
        let of = |i: usize| entries.iter().skip(i).step_by(columns.len());
        let forces = (0..columns.len()).map(|i| of(i).copied().collect());
        (forces.collect(), None)
    }
}

/// What a form has for each node.
pub(super) struct Weights {
    /// Whether entries are summed over elements, and whether over nodes.
    by_stretch: bool,
    by_force: bool,
    /// Roots of the sizes of elements, and of what a unit displacement meets in absolute terms in elements, rows and columns; in
    /// how many elements it does.
    elements: Vec<f64>,
    load: Vec<f64>,
    rows: Vec<f64>,
    columns: Vec<f64>,
    terms: Vec<usize>,
    /// The entries of the matrix that are not 0, by columns.
    entries: Vec<Vec<(usize, f64)>>,
}

impl Weights {
    fn of(form: &Form<'_>) -> Weights {
        let n = form.n;
        let by_stretch = form.elements.len() <= 4 * n;
        let mut weights = Weights {
            by_stretch,
            by_force: form.matrix.is_some() || !by_stretch,
            elements: form.elements.iter().map(|e| e.coefficient.abs()).collect(),
            load: vec![0.0; n],
            rows: vec![0.0; n],
            columns: vec![0.0; n],
            terms: vec![0; n],
            entries: Vec::new(),
        };
        if !by_stretch {
            for element in &form.elements {
                for i in ends(element).into_iter().flatten() {
                    weights.load[i] += element.coefficient.abs();
                    weights.terms[i] += 1;
                }
            }
        }
        if let Some(matrix) = form.matrix {
            let column = |j: usize| matrix.col(j).iter().copied().enumerate();
            let filled = |j| column(j).filter(|entry| entry.1 != 0.0).collect();
            weights.entries = (0..n).map(filled).collect();
            // What the next double leaves of an entry is below 2^-105 of it.
            let mut rests: BTreeMap<(usize, usize), DoubleDouble> = BTreeMap::new();
            for tail in form.tails {
                *rests.entry((tail.row, tail.column)).or_default() +=
                    DoubleDouble::from(tail.value);
            }
            for ((i, j), rest) in rests {
                weights.entries[j].push((i, rest.to_f64()));
            }
        }
        for (j, column) in weights.entries.iter().enumerate() {
            for (i, entry) in column {
                weights.rows[*i] += entry.abs();
                weights.columns[j] += entry.abs();
            }
        }
        let all = [
            &mut weights.elements,
            &mut weights.load,
            &mut weights.rows,
            &mut weights.columns,
        ];
        for size in all.into_iter().flatten() {
            *size = size.sqrt();
        }
        weights
    }
}

impl Weights {
    /// What each product errs by, relative: both stretches, k·stretch, the rest of an entry and the sum of forces, unless those of
    /// the matrix are taken in slices.
    pub(super) fn unit(&self, is_sliced: bool) -> f64 {
        (6.0 + self.roundings(is_sliced)) * 2f64.powi(-102)
    }

    /// Whether half of the entries of the matrix and more are not 0.
    fn is_full(&self) -> bool {
        let filled: usize = self.entries.iter().map(Vec::len).sum();
        2 * filled >= self.rows.len() * self.rows.len()
    }

    /// Σ|A_rs|x_r² over all entries, no smaller than the truth by more than `UPWARD`.
    pub(super) fn over_rows(&self, x: &[DoubleDouble]) -> f64 {
        let each = self.rows.iter().zip(x);
        each.map(|(root, x)| square(*root, x.to_f64())).sum()
    }

    /// How many roundings the sum of the forces on a node is.
    fn roundings(&self, is_sliced: bool) -> f64 {
        let elements = self.terms.iter().max().map_or(0, |most| *most) as f64;
        if is_sliced {
            return elements + 1.0;
        }
        let most = self.entries.iter().map(Vec::len).max().unwrap_or(0);
        // Of the terms that are summed at once, and of their sums.
        let (at_once, sums) = (most.min(Lanes::<1>::AT_ONCE), most / Lanes::<1>::AT_ONCE);
        let at_once = if most == 0 {
            0.0
        } else {
            (at_once as f64 + 4.0).powi(2) / 16.0
        };
        elements + 1.0 + at_once + sums as f64
    }
}

fn ends(element: &Element) -> [Option<usize>; 2] {
    [element.first, element.second].map(Node::coordinate)
}

/// What a column brings to its products.
struct Side {
    /// On the left.
    forces: Vec<DoubleDouble>,
    /// On the right.
    stretches: Vec<DoubleDouble>,
    /// Bounds of its part in the sums of absolute products, on the left and on the right.
    first: f64,
    second: f64,
}

impl Form<'_> {
    /// On the left with the forces of the matrix.
    fn side(
        &self,
        weights: &Weights,
        x: &[DoubleDouble],
        nodal: Option<Vec<DoubleDouble>>,
    ) -> Side {
        let at = |node: Node| node.coordinate().map_or(DoubleDouble::ZERO, |i| x[i]);
        let elements = self.elements.iter();
        let stretches: Vec<DoubleDouble> = elements
            .map(|element| at(element.first) - at(element.second))
            .collect();
        let over = |roots: &[f64], values: &[DoubleDouble]| -> f64 {
            let each = roots.iter().zip(values);
            each.map(|(root, x)| square(*root, x.to_f64())).sum()
        };
        let energy = over(&weights.elements, &stretches);
        let (first, second) = if weights.by_stretch {
            (energy, energy)
        } else {
            (2.0 * energy, over(&weights.load, x))
        };
        let forces = nodal.map_or(Vec::new(), |nodal| self.forces(weights, &stretches, nodal));
        let mut right = if weights.by_stretch {
            stretches
        } else {
            Vec::new()
        };
        if weights.by_force {
            right.extend(x);
        }
        Side {
            forces,
            stretches: right,
            first: (first + weights.over_rows(x)).sqrt() * UPWARD,
            second: (second + over(&weights.columns, x)).sqrt() * UPWARD,
        }
    }

    /// Of the elements, on the nodes, or both, given those of Aᵀ on the nodes.
    fn forces(
        &self,
        weights: &Weights,
        stretches: &[DoubleDouble],
        mut nodal: Vec<DoubleDouble>,
    ) -> Vec<DoubleDouble> {
        let each = self.elements.iter().zip(stretches);
        let mut forces: Vec<DoubleDouble> =
            each.map(|(e, stretch)| *stretch * e.coefficient).collect();
        if !weights.by_force {
            return forces;
        }
        if !weights.by_stretch {
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
        forces.extend(nodal);
        forces
    }
}

/// k·x² given √k, no smaller than the truth by more than `UPWARD` wherever it underflows.
pub(super) fn square(root: f64, x: f64) -> f64 {
    let root = root * x;
    root * root + f64::MIN_POSITIVE
}

impl Gram {
    /// That of columns nearby, which was found from this; `None` where errors have become larger than [`LITTLE`] allows.
    pub(super) fn near(
        &self,
        entries: Vec<DoubleDouble>,
        errors: Vec<f64>,
        sizes: Vec<f64>,
        kept: impl FnOnce() -> Option<Kept>,
    ) -> Option<Gram> {
        let ratios = errors.iter().zip(&self.errors);
        let ratios = ratios.map(|(error, before)| error / before);
        let growth = self.growth * ratios.fold(1.0, f64::max);
        let is_known = growth <= LITTLE && errors.iter().all(|error| error.is_finite());
        is_known.then(|| Gram {
            size: self.size,
            entries,
            errors,
            sizes,
            slices: self.slices,
            growth,
            kept: kept(),
        })
    }

    pub(super) fn at(&self, i: usize, j: usize) -> DoubleDouble {
        self.entries[i * self.size + j]
    }

    pub(super) fn row(&self, i: usize) -> &[DoubleDouble] {
        &self.entries[i * self.size..][..self.size]
    }

    /// A bound of |entry (i, j)|.
    pub(super) fn upper(&self, i: usize, j: usize) -> f64 {
        (self.at(i, j).to_f64().abs() + self.error(i, j)) * UPWARD
    }

    /// How far entry (i, j) may be off.
    pub(super) fn error(&self, i: usize, j: usize) -> f64 {
        self.errors[i * self.size + j]
    }

    /// A bound of ‖E‖ for this matrix = δ^{1/2}(D + E)δ^{1/2}, D its computed diagonal over δ but 0 from `zeros` on; the
    /// `sizes` are √δ. NaN or infinite where there is none.
    pub(super) fn distance(&self, sizes: &[f64], zeros: usize) -> f64 {
        let mut largest = 0.0;
        for i in 0..self.size {
            let sum: f64 = (0..self.size)
                .map(|j| {
                    let entry = if i == j && i < zeros {
                        self.error(i, j)
                    } else {
                        self.upper(i, j)
                    };
                    entry / sizes[i] / sizes[j]
                })
                .sum();
            if !sum.is_finite() {
                return sum;
            }
            largest = sum.max(largest);
        }
        largest * UPWARD
    }

    /// The same with δ the computed diagonal, D = I.
    pub(super) fn distance_from_diagonal(&self) -> f64 {
        let size = |i: usize| self.at(i, i).to_f64().sqrt();
        let sizes: Vec<f64> = (0..self.size).map(size).collect();
        self.distance(&sizes, self.size)
    }
}
