//! All frequencies of an undamped system at once, from approximate shapes, in O(n³).
//!
//! For square X the pencils (K, M) and (S, G) = (XᵀKX, XᵀMX) have the same eigenvalues, and good
//! shapes make S and G nearly diagonal. With g = diag G, s = diag S and d_k = s_k/g_k write
//!
//! G = g^{1/2}(I + E_G)g^{1/2}, S = g^{1/2}D^{1/2}(I + E_S)D^{1/2}g^{1/2}, D = diag d ≥ 0.
//!
//! If ‖E_G‖ < 1 and ‖E_S‖ < 1, the k-th eigenvalues σ_k of (K, M) and d_k of D, both in rising
//! order, satisfy
//!
//! d_k (1 − ‖E_S‖)/(1 + ‖E_G‖) ≤ σ_k ≤ d_k (1 + ‖E_S‖)/(1 − ‖E_G‖).
//!
//! Proof. I + E_G is positive definite, so X and M are nonsingular and M is positive definite. By
//! Ostrowski's theorem (Horn & Johnson, *Matrix Analysis*, theorem 4.5.9) λ_k(TATᵀ) = θ_k λ_k(A)
//! with λ_min(TTᵀ) ≤ θ_k ≤ λ_max(TTᵀ) for symmetric A and nonsingular T. D^{1/2}(I + E_S)D^{1/2}
//! has the eigenvalues of TDTᵀ with T = (I + E_S)^{1/2}, which are θ_k d_k with
//! |θ_k − 1| ≤ ‖E_S‖; taking the pencil with I + E_G is one more congruence, by (I + E_G)^{-1/2}. ∎
//!
//! (This is theorem 2.3 of Demmel & Veselić 1992, *SIAM J. Matrix Anal.* 13, for both matrices.)
//! Scaled by D^{1/2}, the error is small against each frequency and not only the largest, and
//! roots that coincide cost nothing. The shapes of rigid-body motions are exact: their rows of S
//! vanish, and d = 0.
//!
//! ‖E‖ is bounded by the largest sum of |E_ij| over a row. It is of the first order in the errors of
//! X, so X is first refined to double-double by the iteration of Ogita & Aishima 2018, *Jpn. J. Ind.
//! Appl. Math.* 35, for a pencil: X ← X(I + Ẽ) with ẽ_ij = (s_ij − d_j g_ij)/((d_j − d_i) g_i).
//! Shapes too close for that are first replaced by the Ritz vectors of their span.
//!
//! What S and G leave off the diagonal also bounds how much the shapes are still mixed (`mixing`).

mod mixing;

use std::cmp::Ordering;
use std::ops::Range;

use eigentone_digits::{Ball, DoubleDouble, Magnitude, Real};
use faer::{Mat, Side};
use num_complex::Complex;

use super::gram::{Form, Gram, UPWARD};
use super::quadratic::around;
use crate::modes::Mode;
use crate::structure::Structure;
use crate::system::System;

use super::exactly::exact;
use super::pencil::Pencil;
use super::shape::{self, Disc, Enclosed, Kind, Shaper};

/// One elastic mode: ω with a proven bound, and its shape.
#[derive(Clone, Debug)]
pub(crate) struct Elastic {
    pub(crate) frequency: f64,
    /// Of |ω̂ − ω|.
    pub(crate) bound: f64,
    /// How many frequencies the bounds do not tell apart.
    pub(crate) multiplicity: usize,
    pub(crate) shape: Shape,
}

/// A real shape.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    pub(crate) components: Vec<Complex<f64>>,
    /// How far each may be off where the largest is 1; `None` where that is not proved.
    pub(crate) bounds: Option<Vec<f64>>,
}

impl Shape {
    /// An approximate one.
    pub(crate) fn plain(column: &[DoubleDouble]) -> Shape {
        Shape {
            components: column.iter().map(|x| Complex::from(x.to_f64())).collect(),
            bounds: None,
        }
    }

    /// Some of n coordinates move as a whole, and nothing else; bounded where that is the only such motion.
    pub(crate) fn whole(n: usize, part: &[usize], is_alone: bool) -> Shape {
        let moves = |i: usize| Complex::from(f64::from(part.contains(&i)));
        let shape = Shape::from(Enclosed::exactly((0..n).map(moves).collect()));
        if is_alone {
            shape
        } else {
            shape.without_bounds()
        }
    }

    /// The same where another root is at the same place.
    pub(crate) fn without_bounds(self) -> Shape {
        Shape {
            bounds: None,
            ..self
        }
    }
}

impl From<Enclosed> for Shape {
    fn from(enclosed: Enclosed) -> Shape {
        Shape {
            components: enclosed.shape,
            bounds: Some(enclosed.bounds),
        }
    }
}

/// Proves a bound for every nonzero frequency of an undamped system with M and K symmetric and no
/// massless nodes, given all its modes approximately. `None` where no proof was reached, as for
/// K ⋡ 0.
pub(crate) fn certify(
    system: &System,
    structure: &Structure,
    modes: &[Mode],
    tolerance: f64,
) -> Option<Vec<Elastic>> {
    let elastic = || {
        modes
            .iter()
            .filter(|mode| mode.eigenvalue().value.norm() != 0.0)
    };
    if !structure.is_undamped() || elastic().any(|mode| mode.is_defective()) {
        return None;
    }
    let shapes = elastic().map(|mode| mode.shape().iter().map(|x| x.re).collect());
    let goal = Goal {
        spread: 1e-24,
        where_apart: 1e-20,
    };
    let found = squares(system, structure, shapes.collect(), goal, tolerance)?;
    Some(elastic_modes(&found))
}

/// How small the bound of relative errors is to become.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// In any case, if double-double reaches it.
    pub(crate) spread: f64,
    /// Where all values and shapes are told apart by it.
    pub(crate) where_apart: f64,
}

impl Goal {
    /// The same whether values are apart or not.
    pub(crate) fn always(spread: f64) -> Goal {
        Goal {
            spread,
            where_apart: spread,
        }
    }
}

/// The nonzero eigenvalues σ = ω² of (K, M), rising, with their shapes.
pub(crate) struct Squares {
    pub(crate) values: Vec<DoubleDouble>,
    pub(crate) shapes: Vec<Shape>,
    /// In the same order; after them the rigid-body motions, which are exact.
    pub(crate) columns: Vec<Vec<DoubleDouble>>,
    /// A bound of the relative error of every value.
    pub(crate) spread: f64,
}

impl Squares {
    /// The shape of one of them.
    pub(crate) fn shape(&self, i: usize) -> Shape {
        self.shapes[i].clone()
    }

    /// A ball that holds all true values of a group.
    pub(super) fn around(&self, group: &Range<usize>) -> Ball<DoubleDouble> {
        let centre = self.values[(group.start + group.end) / 2];
        let reach = group.clone().map(|i| {
            let value = self.values[i];
            (value - centre).to_f64().abs() + self.spread * value.to_f64()
        });
        around(centre, reach.fold(0.0, f64::max) * UPWARD)
    }

    /// Those that their bounds do not tell apart.
    pub(crate) fn groups(&self) -> Vec<Range<usize>> {
        let touch = |a: &DoubleDouble, b: &DoubleDouble| {
            (*b - *a).to_f64() <= self.spread * UPWARD * (*a + *b).to_f64()
        };
        let mut start = 0;
        let ranges = self.values.chunk_by(touch).map(|group| {
            let range = start..start + group.len();
            start = range.end;
            range
        });
        ranges.collect()
    }
}

/// The same for (K, M) of any system with M and K symmetric and no massless nodes, and its shapes with
/// components within a relative tolerance where digits allow, given its elastic shapes approximately: as many as there are coordinates, less the parts that no spring
/// ties to the ground.
pub(crate) fn squares(
    system: &System,
    structure: &Structure,
    shapes: Vec<Vec<f64>>,
    goal: Goal,
    tolerance: f64,
) -> Option<Squares> {
    let rigid = structure.spring_floating();
    let n = system.len();
    let applies = structure.is_symmetric() && structure.massless().is_empty();
    let elastic = shapes.len();
    if !applies || elastic + rigid.len() != n {
        return None;
    }
    let mass = system.mass_matrix();
    let scaled = |shape: Vec<f64>| {
        let column = Mat::from_fn(n, 1, |i, _| shape[i]);
        let norm = (column.transpose() * &mass * &column)[(0, 0)].sqrt();
        let entries = shape.iter().map(|x| DoubleDouble::from(x / norm));
        entries.collect::<Vec<DoubleDouble>>()
    };
    let mut columns: Vec<Vec<DoubleDouble>> = shapes.into_iter().map(scaled).collect();
    columns.extend(rigid.iter().map(|part| {
        let within = |i| if part.contains(&i) { 1.0 } else { 0.0 };
        scaled((0..n).map(within).collect())
    }));
    let mut basis = Basis {
        stiffness: Form::stiffness(system),
        mass: Form::mass(system),
        columns,
        elastic,
    };
    let forms = basis.refine(goal)?;
    let (forms, mut enclosed) = basis.enclosed(forms, tolerance);
    let mut order: Vec<usize> = (0..elastic).collect();
    let value = |i: usize| forms.squares[i];
    order.sort_by(|a, b| {
        let order = value(*a).partial_cmp(&value(*b));
        order.unwrap_or(Ordering::Equal)
    });
    let rest: Vec<usize> = (elastic..n).collect();
    let mut found = Squares {
        values: order.iter().map(|i| value(*i)).collect(),
        shapes: Vec::with_capacity(elastic),
        columns: order
            .iter()
            .chain(&rest)
            .map(|i| basis.columns[*i].clone())
            .collect(),
        spread: forms.full_spread(),
    };
    let mut alone = vec![false; elastic];
    for group in found.groups().into_iter().filter(|group| group.len() == 1) {
        alone[group.start] = true;
    }
    let closer = Closer::of(system, &found, tolerance);
    for (at, i) in order.into_iter().enumerate() {
        let proven = alone[at].then(|| closer.shape(found.values[at], enclosed[i].take()));
        let shape = proven.flatten().map(Shape::from);
        let shape = shape.unwrap_or_else(|| Shape::plain(&basis.columns[i]));
        found.shapes.push(shape);
    }
    Some(found)
}

/// Finds single shapes with more digits where those of all at once do not do.
struct Closer {
    unit: i32,
    spread: f64,
    goal: shape::Goal,
    /// Few enough coordinates for an elimination at every root.
    pencil: Option<Pencil>,
}

impl Closer {
    fn of(system: &System, squares: &Squares, tolerance: f64) -> Closer {
        const LARGEST: usize = 64;
        let largest = squares.values.last().map_or(1.0, |top| top.to_f64());
        Closer {
            unit: (largest.log2() / 2.0).round() as i32,
            spread: squares.spread,
            goal: shape::Goal {
                tolerance,
                symmetric: true,
                roots: squares.values.len(),
            },
            pencil: (system.len() <= LARGEST).then(|| Pencil::of(system, true)),
        }
    }

    /// The shape of the only root at σ, as found already or better.
    fn shape(&self, sigma: DoubleDouble, found: Option<Enclosed>) -> Option<Enclosed> {
        let good = |shape: &Enclosed| shape.meets(self.goal.tolerance);
        let enough = found.as_ref().is_some_and(good);
        let Some(pencil) = self.pencil.as_ref().filter(|_| !enough) else {
            return found;
        };
        let kind = Kind {
            is_simple: true,
            is_real: true,
        };
        // λ² = −σ = 4^unit·μ.
        let scale = -2 * i64::from(self.unit);
        let centre = exact(-sigma.scale(scale), DoubleDouble::ZERO).middle();
        let reach = (self.spread * UPWARD * sigma.scale(scale).to_f64()).max(f64::MIN_POSITIVE);
        let disc = Disc::of(Ball::new(centre, Magnitude::from(reach)));
        let closer = Shaper::of(pencil, self.unit, self.goal).shapes(disc, kind);
        let closer = closer.map(|shapes| shapes.right);
        match (found, closer) {
            (Some(found), Some(closer))
                if !good(&closer) && found.looseness() < closer.looseness() =>
            {
                Some(found)
            }
            (found, closer) => closer.or(found),
        }
    }
}

/// Approximate shapes, the elastic ones first, with the forms that they are to diagonalise.
pub(super) struct Basis<'a> {
    pub(super) stiffness: Form<'a>,
    pub(super) mass: Form<'a>,
    pub(super) columns: Vec<Vec<DoubleDouble>>,
    pub(super) elastic: usize,
}

/// S, G and d in a basis.
pub(super) struct Forms {
    stiffness: Gram,
    mass: Gram,
    squares: Vec<DoubleDouble>,
    /// A bound of |σ_k/d_k − 1| for all k, where it is below ½.
    spread: f64,
}

impl Forms {
    /// With the rounding of the quotients s/g.
    fn full_spread(&self) -> f64 {
        self.spread + 2f64.powi(-100)
    }

    fn meet(&self, goal: Goal) -> bool {
        self.spread <= goal.spread || (self.spread <= goal.where_apart && self.are_apart())
    }

    /// Whether squares are so far apart that neither their bounds nor the mixing of shapes, which is about
    /// the bound divided by the gap, shows in doubles.
    fn are_apart(&self) -> bool {
        const HIDDEN: f64 = 1e-17;
        let mut rising: Vec<DoubleDouble> = self.squares.clone();
        rising.sort_by(|a, b| a.partial_cmp(b).unwrap_or(Ordering::Equal));
        rising.windows(2).all(|pair| {
            let gap = (pair[1] - pair[0]).to_f64();
            HIDDEN * gap > self.spread * pair[1].to_f64()
        })
    }
}

/// What is to be done to a basis.
enum Step {
    /// X ← X(I + Ẽ).
    Correct(Mat<f64>),
    /// Ritz vectors in place of each of these sets of columns.
    Rotate(Vec<Vec<usize>>),
}

impl Basis<'_> {
    /// Refines the basis to the goal, or as far as double-double reaches, and returns its forms.
    pub(super) fn refine(&mut self, goal: Goal) -> Option<Forms> {
        const STEPS: usize = 12;
        let mut forms = self.forms()?;
        for _ in 0..STEPS {
            if forms.meet(goal) {
                break;
            }
            let Some((next, slow)) = self.advanced(&forms) else {
                break;
            };
            forms = next;
            if slow {
                break;
            }
        }
        // Spreads beyond this tell nothing.
        (forms.spread <= 1e-6).then_some(forms)
    }

    /// The forms after a step, and whether another would gain little; `None`, with the basis as before, where the
    /// step gained nothing.
    fn advanced(&mut self, forms: &Forms) -> Option<(Forms, bool)> {
        let before = self.columns.clone();
        let step = self.step(forms);
        let done = match &step {
            Step::Correct(change) => {
                self.correct(change);
                Some(())
            }
            Step::Rotate(groups) => groups
                .iter()
                .try_for_each(|group| self.rotate(forms, group)),
        };
        let corrected = matches!(step, Step::Correct(_));
        let next = done.and_then(|()| self.forms());
        let better = next.filter(|next| !corrected || next.spread < forms.spread);
        if better.is_none() {
            self.columns = before;
        }
        better.map(|next| {
            let slow = corrected && next.spread > 0.5 * forms.spread;
            (next, slow)
        })
    }

    /// The elastic shapes with bounds, where these are proved, after as many more steps as help, and the forms
    /// then.
    fn enclosed(&mut self, mut forms: Forms, tolerance: f64) -> (Forms, Vec<Option<Enclosed>>) {
        const STEPS: usize = 1;
        /// Little is gained below.
        const LEAST: f64 = 1e-25;
        let good = |shape: &Option<Enclosed>| {
            let shape = shape.as_ref();
            shape.is_none_or(|shape| shape.meets(tolerance))
        };
        let mut shapes = self.shapes(&forms);
        for _ in 0..STEPS {
            if forms.spread <= LEAST || shapes.iter().all(good) {
                break;
            }
            let Some((next, slow)) = self.advanced(&forms) else {
                break;
            };
            forms = next;
            shapes = self.shapes(&forms);
            if slow {
                break;
            }
        }
        (forms, shapes)
    }

    fn shapes(&self, forms: &Forms) -> Vec<Option<Enclosed>> {
        let errors = mixing::errors(forms, &self.columns, forms.full_spread());
        let shape = |(column, errors): (&Vec<DoubleDouble>, Option<Vec<f64>>)| {
            let errors = errors?;
            let each = column.iter().zip(&errors);
            let ball = |(x, error): (&DoubleDouble, &f64)| {
                let middle = exact(*x, DoubleDouble::ZERO).middle();
                Ball::new(middle, Magnitude::from(*error))
            };
            let balls: Vec<Ball<DoubleDouble>> = each.map(ball).collect();
            Enclosed::of(&balls, true)
        };
        self.columns.iter().zip(errors).map(shape).collect()
    }

    /// `None` where a shape has no frequency or a number leaves its range.
    fn forms(&self) -> Option<Forms> {
        let stiffness = self.stiffness.gram(&self.columns[..self.elastic]);
        let mass = self.mass.gram(&self.columns);
        let in_range = |value: DoubleDouble| value.to_f64() > 1e-280 && value.to_f64() < 1e280;
        let diagonals = |gram: &Gram| (0..gram.size).all(|i| in_range(gram.at(i, i)));
        if !diagonals(&stiffness) || !diagonals(&mass) {
            return None;
        }
        let squares: Vec<DoubleDouble> = (0..self.elastic)
            .map(|i| stiffness.at(i, i) / mass.at(i, i))
            .collect();
        if !squares.iter().copied().all(in_range) {
            return None;
        }
        let (e_s, e_g) = (stiffness.distance(), mass.distance());
        // From both sides |σ/d − 1| ≤ (e_S + e_G)/(1 − e_G). Without the theorem's conditions this
        // is ½ or more, and no proof.
        let spread = (e_s + e_g) / (1.0 - e_g.min(0.5)) * UPWARD;
        Some(Forms {
            stiffness,
            mass,
            squares,
            spread,
        })
    }

    fn step(&self, forms: &Forms) -> Step {
        /// Gaps that may hide shapes which are still mixed.
        const NEAR: f64 = 0.1;
        /// Of a gap; beyond it one correction does not do.
        const SMALL: f64 = 1e-2;
        /// Coupling and gap of shapes of which any mixture will do: it only has to be orthogonal.
        const NOTHING: f64 = 1e-27;
        const EQUAL: f64 = 1e-14;
        let Forms {
            stiffness,
            mass,
            squares,
            ..
        } = forms;
        let (all, elastic) = (self.columns.len(), self.elastic);
        let mut change = Mat::<f64>::zeros(all, elastic);
        let mut group: Vec<usize> = (0..elastic).collect();
        let own = |i: usize| mass.at(i, i).to_f64();
        for j in 0..elastic {
            for i in elastic..all {
                change[(i, j)] = -mass.at(i, j).to_f64() / own(i);
            }
            for i in 0..j {
                let (s, g) = (stiffness.at(i, j), mass.at(i, j));
                let gap = (squares[j] - squares[i]).to_f64();
                let size = squares[i].to_f64().max(squares[j].to_f64());
                let mean = (squares[i] + squares[j]) * 0.5;
                let coupling = (s - mean * g).to_f64().abs() / (size * (own(i) * own(j)).sqrt());
                if coupling <= NOTHING && gap.abs() <= EQUAL * size {
                    change[(i, j)] = -0.5 * g.to_f64() / own(i);
                    change[(j, i)] = -0.5 * g.to_f64() / own(j);
                } else if gap.abs() <= NEAR * size && coupling * size > SMALL * gap.abs() {
                    let (from, to) = (group[i].max(group[j]), group[i].min(group[j]));
                    group
                        .iter_mut()
                        .filter(|label| **label == from)
                        .for_each(|label| *label = to);
                } else {
                    change[(i, j)] = (s - squares[j] * g).to_f64() / (gap * own(i));
                    change[(j, i)] = -(s - squares[i] * g).to_f64() / (gap * own(j));
                }
            }
        }
        let mut groups = vec![Vec::new(); elastic];
        for (i, label) in group.into_iter().enumerate() {
            groups[label].push(i);
        }
        groups.retain(|group| group.len() > 1);
        if groups.is_empty() {
            Step::Correct(change)
        } else {
            Step::Rotate(groups)
        }
    }

    /// The product is small against X, and rounds in the same proportion.
    fn correct(&mut self, change: &Mat<f64>) {
        let n = self.columns[0].len();
        let shapes = Mat::from_fn(n, self.columns.len(), |i, j| self.columns[j][i].to_f64());
        let product = shapes * change;
        for (j, column) in self.columns[..self.elastic].iter_mut().enumerate() {
            for (i, entry) in column.iter_mut().enumerate() {
                *entry = *entry + product[(i, j)];
            }
        }
    }

    /// The Ritz vectors of a set of columns, by the part of S that differs from a multiple of G.
    fn rotate(&mut self, forms: &Forms, group: &[usize]) -> Option<()> {
        let Forms {
            stiffness,
            mass,
            squares,
            ..
        } = forms;
        let centre = squares[group[group.len() / 2]];
        let norms: Vec<f64> = group
            .iter()
            .map(|i| mass.at(*i, *i).to_f64().sqrt())
            .collect();
        let rest = Mat::from_fn(group.len(), group.len(), |a, b| {
            let (i, j) = (group[a], group[b]);
            (stiffness.at(i, j) - centre * mass.at(i, j)).to_f64() / norms[a] / norms[b]
        });
        let eigen = rest.self_adjoint_eigen(Side::Lower).ok()?;
        let rotated = (0..group.len()).map(|b| {
            let mut column = vec![DoubleDouble::ZERO; self.columns[0].len()];
            for (a, i) in group.iter().enumerate() {
                let share = eigen.U()[(a, b)] / norms[a];
                for (entry, x) in column.iter_mut().zip(&self.columns[*i]) {
                    *entry += *x * share;
                }
            }
            column
        });
        let rotated: Vec<Vec<DoubleDouble>> = rotated.collect();
        for (i, column) in group.iter().zip(rotated) {
            self.columns[*i] = column;
        }
        Some(())
    }
}

/// ω = √σ with bounds; frequencies that are not told apart get one value.
fn elastic_modes(squares: &Squares) -> Vec<Elastic> {
    // √(1 + t) is within this of 1 for |t| ≤ spread. More is added for the root.
    let relative = squares.spread / (1.0 + (1.0 - squares.spread).sqrt()) + 2f64.powi(-100);
    let mut found = Vec::with_capacity(squares.values.len());
    for group in squares.groups() {
        let middle = squares.values[(group.start + group.end) / 2];
        let frequency = middle.sqrt().to_f64();
        let bound = group.clone().map(|i| {
            let root = squares.values[i].sqrt();
            let rounding = (root - DoubleDouble::from(frequency)).to_f64().abs();
            (rounding + relative * root.to_f64()) * UPWARD
        });
        let bound = bound.fold(f64::from_bits(1), f64::max);
        found.extend(group.clone().map(|i| Elastic {
            frequency,
            bound,
            multiplicity: group.len(),
            shape: squares.shape(i),
        }));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inclusion;
    use crate::modes::{Bounds, Modes, Precision};
    use crate::solver::solvers;
    use crate::{GROUND, SystemBuilder};
    use num_complex::Complex;
    use proptest::prelude::*;

    const UNIT: f64 = f64::EPSILON / 2.0;

    fn names(n: usize) -> Vec<String> {
        (0..n).map(|i| format!("m{i}")).collect()
    }

    /// Masses in a row; of n + 1 springs the first and the last lead to the ground, if not 0.
    fn chain(masses: &[f64], springs: &[f64]) -> System {
        let n = masses.len();
        let names = names(n);
        let end = |i: usize| {
            if i == 0 || i > n {
                GROUND
            } else {
                &names[i - 1]
            }
        };
        let masses = names.iter().zip(masses);
        let system = masses.fold(System::builder(), |b, (name, mass)| b.mass(name, *mass));
        let springs = springs.iter().enumerate().filter(|(_, k)| **k != 0.0);
        springs
            .fold(system, |b, (i, k)| b.spring(end(i), end(i + 1), *k))
            .build()
            .unwrap()
    }

    /// Every mass joined to every other one.
    fn complete(n: usize, mass: f64, spring: f64, ground: f64) -> System {
        let names = names(n);
        let mut builder = SystemBuilder::default();
        for (i, name) in names.iter().enumerate() {
            builder = builder.mass(name, mass);
            if ground != 0.0 {
                builder = builder.spring(GROUND, name, ground);
            }
            for other in &names[..i] {
                builder = builder.spring(other, name, spring);
            }
        }
        builder.build().unwrap()
    }

    fn approximate(system: &System) -> Modes {
        system.modes_to(Precision::Double).unwrap()
    }

    fn certified(system: &System) -> Option<Vec<Elastic>> {
        certify(
            system,
            system.structure(),
            approximate(system).as_slice(),
            4.0 * UNIT,
        )
    }

    /// sin x by its series.
    fn sine(x: DoubleDouble) -> DoubleDouble {
        let (mut term, mut sum) = (x, x);
        for k in 1..30 {
            term = -(term * x * x) / DoubleDouble::from(f64::from(2 * k * (2 * k + 1)));
            sum += term;
        }
        sum
    }

    /// Each frequency is its truth within the bound, and the bound within `tolerance`.
    fn assert_true(found: &[Elastic], truth: &[DoubleDouble], tolerance: f64) {
        assert_eq!(found.len(), truth.len());
        for (mode, truth) in found.iter().zip(truth) {
            let error = (*truth - DoubleDouble::from(mode.frequency)).to_f64().abs();
            assert!(
                error <= mode.bound + 1e-30 * mode.frequency,
                "{error:e} {mode:?}"
            );
            assert!(mode.bound <= tolerance * mode.frequency, "{mode:?}");
        }
    }

    #[test]
    fn uniform_chains_of_200() {
        let n = 200;
        let (m, k) = (0.5, 3.0);
        let whole = vec![k; n + 1];
        let (mut hanging, mut free) = (whole.clone(), whole.clone());
        hanging[n] = 0.0;
        (free[0], free[n]) = (0.0, 0.0);
        let quarter = DoubleDouble::TAU * 0.25;
        // The argument of the sine is (j·p + q)/r quarter turns.
        for (springs, first, p, q, r) in [
            (whole, 1, 1.0, 0.0, n + 1),
            (hanging, 1, 2.0, -1.0, 2 * n + 1),
            (free, 1, 1.0, 0.0, n),
        ] {
            let count = n - usize::from(springs[0] == 0.0);
            let truth: Vec<DoubleDouble> = (first..first + count)
                .map(|j| {
                    let turns = DoubleDouble::from(j as f64 * p + q) / DoubleDouble::from(r as f64);
                    let root = DoubleDouble::from(4.0 * k / m).sqrt();
                    root * sine(quarter * turns)
                })
                .collect();
            let system = chain(&vec![m; n], &springs);
            assert_true(&certified(&system).unwrap(), &truth, 1.01 * UNIT);
        }
    }

    #[test]
    fn one_root_of_99() {
        for ground in [0.0, 0.25] {
            let system = complete(100, 2.0, 0.125, ground);
            let found = certified(&system).unwrap();
            let root = |square: f64| DoubleDouble::from(square).sqrt();
            let mut truth = vec![root((12.5 + ground) / 2.0); 99];
            if ground != 0.0 {
                truth.insert(0, root(ground / 2.0));
            }
            assert_true(&found, &truth, 1.01 * UNIT);
            assert_eq!(found.last().unwrap().multiplicity, 99);
            let modes = system.modes().unwrap();
            assert_eq!(modes.bounds(), Bounds::Proven);
            assert_eq!(modes.eigenvalues().len(), 200);
        }
    }

    #[test]
    fn a_bar_of_finite_elements() {
        // K = tridiag(−1, 2, −1) and M = tridiag(1, 4, 1): σ = (2 − 2 cos θ)/(4 + 2 cos θ).
        let n = 99;
        let band = |a: f64, b: f64| {
            Mat::from_fn(n, n, |i, j| match i.abs_diff(j) {
                0 => a,
                1 => b,
                _ => 0.0,
            })
        };
        let (mass, stiffness) = (band(4.0, 1.0), band(2.0, -1.0));
        let none = Mat::<f64>::zeros(n, n);
        let system =
            System::from_matrices(mass.as_ref(), none.as_ref(), stiffness.as_ref()).unwrap();
        let truth: Vec<DoubleDouble> = (1..=n)
            .map(|j| {
                let share = DoubleDouble::from(j as f64) / DoubleDouble::from(400.0);
                let s = sine(DoubleDouble::TAU * share);
                let below = DoubleDouble::from(6.0) - s * s * 4.0;
                (s * s * 4.0 / below).sqrt()
            })
            .collect();
        assert_true(&certified(&system).unwrap(), &truth, 1.01 * UNIT);
    }

    #[test]
    fn soft_beside_stiff() {
        // σ² − (k₁ + 2k₂)σ + k₁k₂ = 0.
        for stiff in [1e8, 1e16, 1e24] {
            let found = certified(&chain(&[1.0, 1.0], &[1.0, stiff, 0.0])).unwrap();
            let (one, k) = (DoubleDouble::from(1.0), DoubleDouble::from(stiff));
            let high = (one + k * 2.0 + (one + k * k * 4.0).sqrt()) * 0.5;
            assert_true(&found, &[(k / high).sqrt(), high.sqrt()], 1.01 * UNIT);
        }
        let n = 100;
        let springs: Vec<f64> = (0..=n)
            .map(|i| if i % 2 == 0 { 1.0 } else { 1e12 })
            .collect();
        let found = certified(&chain(&vec![1.0; n], &springs)).unwrap();
        assert!(
            found
                .iter()
                .all(|mode| mode.bound <= 4.0 * UNIT * mode.frequency)
        );
    }

    #[test]
    fn nearly_equal_is_not_equal() {
        for coupling in [1e-9, 1e-13, 1e-16] {
            let found = certified(&chain(&[1.0, 1.0], &[1.0, coupling, 1.0])).unwrap();
            let apart = DoubleDouble::from(1.0) + DoubleDouble::from(2.0 * coupling);
            let truth = [DoubleDouble::from(1.0), apart.sqrt()];
            assert_true(&found, &truth, 1.01 * UNIT);
            assert!(found.iter().all(|mode| mode.multiplicity == 1));
        }
    }

    #[test]
    fn no_proof_without_its_conditions() {
        let negative = chain(&[1.0, 1.0], &[1.0, 1.0, -3.0]);
        assert!(certified(&negative).is_none());
        assert!(certified(&chain(&[1.0, 0.0, 1.0], &[1.0; 4])).is_none());
        let damped = System::builder().mass("a", 1.0).spring(GROUND, "a", 1.0);
        assert!(certified(&damped.damper(GROUND, "a", 0.1).build().unwrap()).is_none());
        // A mode is missing, and one is given twice.
        let system = chain(&[1.0, 2.0], &[1.0, 2.0, 3.0]);
        let modes = approximate(&system).as_slice().to_vec();
        let structure = system.structure();
        assert!(certify(&system, structure, &modes[..1], 4.0 * UNIT).is_none());
        let twice = [modes[0].clone(), modes[0].clone()];
        assert!(certify(&system, structure, &twice, 4.0 * UNIT).is_none());
    }

    /// What Weierstrass corrections prove of the same frequencies.
    fn by_discs(system: &System) -> Option<Vec<(f64, f64)>> {
        let structure = system.structure();
        let roots: Vec<Complex<f64>> = approximate(system)
            .eigenvalues()
            .iter()
            .map(|root| root.value)
            .filter(|value| value.norm() > 0.0)
            .collect();
        let (found, _) = inclusion::certify(system, structure, &roots, 4.0 * UNIT)?;
        let mut found: Vec<(f64, f64)> = found
            .iter()
            .flat_map(|root| root.members.iter().map(|_| (root.value.im, root.bound)))
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        Some(found)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        #[test]
        fn agrees_with_the_determinant(
            masses in prop::collection::vec(-3.0..3.0f64, 2..7),
            springs in prop::collection::vec(-6.0..6.0f64, 7),
            cross in prop::collection::vec(-6.0..6.0f64, 3),
            free in any::<bool>(),
        ) {
            let n = masses.len();
            let power = |x: &f64| 10f64.powf(*x);
            let masses: Vec<f64> = masses.iter().map(power).collect();
            let mut springs: Vec<f64> = springs[..=n].iter().map(power).collect();
            springs[n] = 0.0;
            if free {
                springs[0] = 0.0;
            }
            let mut builder = SystemBuilder::default();
            let names = names(n);
            for (name, mass) in names.iter().zip(&masses) {
                builder = builder.mass(name, *mass);
            }
            for (i, k) in springs.iter().enumerate().filter(|(_, k)| **k != 0.0) {
                let from = if i == 0 { GROUND } else { &names[i - 1] };
                builder = builder.spring(from, &names[i], *k);
            }
            for (i, k) in cross.iter().enumerate().filter(|(i, _)| i + 2 < n) {
                builder = builder.spring(&names[i], &names[i + 2], power(k));
            }
            let system = builder.build().unwrap();
            let found = certified(&system).expect("it is far from the end of the digits");
            let discs = by_discs(&system).expect("so few roots have discs");
            prop_assert_eq!(found.len(), discs.len());
            for (mode, (frequency, bound)) in found.iter().zip(discs) {
                prop_assert!(mode.bound <= 1.01 * UNIT * mode.frequency);
                prop_assert!((mode.frequency - frequency).abs() <= (mode.bound + bound) * 1.0001);
            }
        }
    }

    #[test]
    fn every_undamped_solver_leads_to_the_same_doubles() {
        let springs: Vec<f64> = (0..31).map(|i| 1.0 + f64::from(i % 7)).collect();
        let system = chain(&[1.5; 30], &springs);
        let structure = system.structure();
        let undamped = solvers()
            .iter()
            .filter(|solver| solver.refuses(&system, structure).is_none());
        let found: Vec<Vec<f64>> = undamped
            .map(|solver| {
                let modes = solver.solve(&system, structure).unwrap();
                let found = certify(&system, structure, modes.as_slice(), 4.0 * UNIT).unwrap();
                found.iter().map(|mode| mode.frequency).collect()
            })
            .collect();
        assert!(found.len() > 1);
        assert!(found.iter().all(|list| *list == found[0]));
    }

    /// 2 and 2.5, each to an eighth, lie between 1.75 and 2.8125.
    #[test]
    fn a_ball_about_several_squares_holds_what_is_open_of_each() {
        let squares = Squares {
            values: vec![DoubleDouble::from(2.0), DoubleDouble::from(2.5)],
            shapes: Vec::new(),
            columns: Vec::new(),
            spread: 0.125,
        };
        let ball = squares.around(&(0..2));
        let (centre, reach) = (ball.middle().re.to_f64(), ball.radius().to_f64());
        assert!(
            centre - reach <= 1.75 && centre + reach >= 2.8125,
            "{centre} {reach}"
        );
        assert!(reach < 1.0);
    }
}
