//! Shapes that K does not resist, or no more than the rounding of its entries makes it, to double-double.
//!
//! In doubles the roots that belong to them are hardly known: they lie as far below the largest as their squares do below
//! what doubles resolve. The undamped shapes are refined first ([`congruence`](super::congruence)); what M, C and K are
//! in their span is a small system with nearly the same small roots. How many shapes have K x = 0, and of these C x = 0, is
//! counted exactly; no vector of doubles need be one of them.

use eigentone_digits::DoubleDouble;
use faer::Mat;
use num_complex::Complex;

use super::congruence::{Precise, precise};
use super::gram::Form;
use crate::structure::Structure;
use crate::system::System;

/// Columns in double-double.
type Columns = Vec<Vec<DoubleDouble>>;

pub(crate) struct Slow {
    /// K x = 0. C couples none with another, M none with those that drift.
    pub(super) creeping: Columns,
    /// K x = C x = 0. M couples none with another.
    pub(super) drifting: Columns,
    /// Those with small squares.
    resisted: Columns,
    /// The least frequency of all others.
    pub(crate) elastic: f64,
    /// The largest frequency that double-doubles do not tell from 0.
    pub(crate) hidden: f64,
    /// Where C holds no creeping shape so much that its root is told from 0, a size that is larger than these roots.
    pub(super) hardly_held: Option<f64>,
}

impl Slow {
    /// Given the elastic shapes approximately; `None` where there are no such shapes, or they are not told from others.
    pub(crate) fn of(
        system: &System,
        structure: &Structure,
        shapes: Vec<Vec<f64>>,
    ) -> Option<Slow> {
        /// Squares that are so small beside the largest, with a gap as wide as this above them, if they are few.
        const SMALL: f64 = 1e-11;
        const GAP: f64 = 1e3;
        const MOST: usize = 24;
        let rigid = structure.rigid_motions_counted()?;
        let drifts = structure.zero_roots()?.checked_sub(rigid)?;
        let creeps = rigid.checked_sub(drifts)?;
        // Coordinates without mass that dampers hold back follow at once where there are none.
        let undamped = (!structure.damped_massless().is_empty())
            .then(|| System::from(system.model().without_dampers()));
        let mut resisted = match &undamped {
            Some(undamped) => precise(undamped, undamped.structure(), shapes)?,
            None => precise(system, structure, shapes)?,
        };
        let mut free: Columns = Vec::new();
        while let Some(last) = resisted.pop_if(|last| last.square == 0.0) {
            free.push(last.shape);
        }
        let size = |of: &Precise| of.square.abs();
        resisted.sort_by(|a, b| size(a).total_cmp(&size(b)));
        let gaps = resisted.windows(2).take(MOST).enumerate();
        let most = SMALL * resisted.last().map_or(0.0, size);
        let is_gap = |pair: &[Precise]| {
            let [below, above] = [&pair[0], &pair[1]].map(size);
            below <= most && above > GAP * below
        };
        let last = gaps.rev().find(|(_, pair)| is_gap(pair));
        let small = last.map_or(0, |(below, _)| below + 1);
        if free.len() != rigid || small + rigid == 0 {
            return None;
        }
        let elastic = resisted.get(small).map_or(f64::INFINITY, size);
        resisted.truncate(small);
        let is_hidden = |of: &&Precise| size(of) <= of.reach;
        let hidden = resisted.iter().filter(is_hidden);
        let hidden = hidden.map(|of| size(of) + of.reach).fold(0.0, f64::max);
        let resisted = resisted.into_iter().map(|of| of.shape);
        let (mass, damping) = (Form::mass(system), Form::damping(system));
        uncouple(&damping, &mut free, creeps);
        let mut drifting = free.split_off(creeps);
        uncouple(&mass, &mut drifting, drifts);
        for drift in &drifting {
            take_out(&mass, drift, &mut free);
        }
        let hardly_held = hardly_held(system, &free);
        if hardly_held.is_some() {
            uncouple(&mass, &mut free, creeps);
        }
        Some(Slow {
            hardly_held,
            creeping: free,
            drifting,
            resisted: resisted.collect(),
            elastic: elastic.sqrt(),
            hidden: hidden.sqrt(),
        })
    }

    /// Whether a real root stands for one that is not told from 0.
    pub(super) fn hides(&self, value: f64) -> bool {
        value.abs() == self.stand_in()
    }

    /// The size of two real roots ±ε that stand for two that are not told from 0: large enough that rounding does not hide
    /// what they leave off the diagonal.
    pub(crate) fn stand_in(&self) -> f64 {
        const TIMES: f64 = 4.0;
        TIMES * self.hidden
    }

    /// The creeping shapes that C hardly holds, each with the size of what stands for its root.
    pub(super) fn stand_ins(&self) -> impl Iterator<Item = (f64, &[DoubleDouble])> {
        let each = self.creeping.iter();
        each.filter_map(|shape| Some((self.hardly_held?, shape.as_slice())))
    }

    /// Whether a root is one of theirs.
    pub(super) fn is_beside_zero(&self, value: Complex<f64>) -> bool {
        value.im == 0.0 && self.hardly_held.is_some_and(|size| value.re.abs() <= size)
    }

    fn columns(&self) -> Columns {
        let each = [&self.creeping, &self.drifting, &self.resisted];
        each.into_iter().flatten().cloned().collect()
    }

    /// M, C and K for motions in their span.
    pub(crate) fn reduced(&self, system: &System) -> Option<System> {
        let columns = self.columns();
        let part = |form: Form<'_>, is_zero: &dyn Fn(usize) -> bool| {
            let gram = form.gram(&columns);
            Mat::from_fn(columns.len(), columns.len(), |i, j| {
                let zero = is_zero(i) || is_zero(j);
                if zero { 0.0 } else { gram.at(i, j).to_f64() }
            })
        };
        let creeps = self.creeping.len();
        let rigid = creeps + self.drifting.len();
        let mass = part(Form::mass(system), &|_| false);
        let damping = part(Form::damping(system), &|i| (creeps..rigid).contains(&i));
        let stiffness = part(Form::stiffness(system), &|i| i < rigid);
        System::from_matrices(mass.as_ref(), damping.as_ref(), stiffness.as_ref()).ok()
    }

    /// The shape of the whole system that belongs to one of the reduced system.
    pub(crate) fn shape(&self, shares: &[Complex<f64>]) -> Vec<Complex<f64>> {
        let columns = self.columns();
        let part = |row: usize, share: fn(&Complex<f64>) -> f64| {
            let each = columns.iter().zip(shares);
            let each = each.map(|(column, y)| column[row] * share(y));
            each.fold(DoubleDouble::ZERO, |sum, x| sum + x).to_f64()
        };
        let entry = |row| Complex::new(part(row, |y| y.re), part(row, |y| y.im));
        (0..columns[0].len()).map(entry).collect()
    }
}

/// For each shape a frequency below which rounding hides what K makes of it.
pub(super) fn unseen(system: &System, shapes: &Columns) -> Vec<f64> {
    const TIMES: f64 = 4.0;
    let stiffness = Form::stiffness(system).gram(shapes);
    let mass = Form::mass(system).gram(shapes);
    let size = |i: usize| TIMES * (stiffness.upper(i, i) / mass.at(i, i).to_f64()).sqrt();
    (0..shapes.len()).map(size).collect()
}

/// A size that stands out from what C makes of shapes with K x = 0, where that is less than rounding of K hides.
fn hardly_held(system: &System, shapes: &Columns) -> Option<f64> {
    /// Of what rounding hides: the columns (x, ±εx) then couple each other by less than an eighth of themselves.
    const TIMES: f64 = 16.0;
    let unseen = unseen(system, shapes);
    let largest = unseen.iter().copied().fold(0.0, f64::max);
    let mass = Form::mass(system).gram(shapes);
    let damping = Form::damping(system).gram(shapes);
    let is_hidden = |i: usize| {
        let held: f64 = (0..shapes.len()).map(|j| damping.upper(i, j)).sum();
        held / mass.at(i, i).to_f64() <= unseen[i]
    };
    let all = !shapes.is_empty() && (0..shapes.len()).all(is_hidden);
    all.then_some(TIMES * largest)
}

/// Makes the first `count` orthogonal to each other and all others by a form, those first that it makes largest.
fn uncouple(form: &Form<'_>, columns: &mut Columns, count: usize) {
    for step in 0..count {
        let gram = form.gram(columns);
        let size = |i: &usize| gram.at(*i, *i).to_f64().abs();
        let largest = (step..columns.len()).max_by(|a, b| size(a).total_cmp(&size(b)));
        columns.swap(step, largest.unwrap_or(step));
        let (done, rest) = columns.split_at_mut(step + 1);
        take_out(form, &done[step], rest);
    }
}

/// x − d (dᵀAx)/(dᵀAd) for each x.
fn take_out(form: &Form<'_>, d: &[DoubleDouble], columns: &mut [Vec<DoubleDouble>]) {
    let d = [d.to_vec()];
    let own = form.gram(&d).at(0, 0);
    let coupling = form.between(&d, columns);
    for (j, column) in columns.iter_mut().enumerate() {
        let share = coupling.at(0, j) / own;
        for (entry, x) in column.iter_mut().zip(&d[0]) {
            *entry -= share * *x;
        }
    }
}
