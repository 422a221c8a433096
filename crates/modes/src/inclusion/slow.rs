//! Shapes that K does not resist, or no more than the rounding of its entries makes it, to double-double.
//!
//! In doubles the roots that belong to them are hardly known: they lie as far below the largest as their squares do below
//! what doubles resolve. The undamped shapes are refined first ([`congruence`](super::congruence)); what M, C and K are
//! in their span is a small system with nearly the same small roots. How many shapes have K x = 0, and of these C x = 0, is
//! counted exactly; no vector of doubles need be one of them.

use eigentone_digits::{DoubleDouble, sort_by_number};
use faer::Mat;
use num_complex::Complex;

use super::congruence::{Precise, precise};
use super::gram::Form;
use crate::system::System;

/// Columns in double-double.
type Columns = Vec<Vec<DoubleDouble>>;

pub(crate) struct Slow {
    /// K x = 0. C couples none with another, M none with those that drift.
    pub(super) relaxing: Columns,
    /// K x = C x = 0. M couples none with another.
    pub(super) drifting: Columns,
    /// Of an unsymmetric C, y for each of both: C and M couple it as they do its x.
    pub(super) left: Option<[Columns; 2]>,
    /// Those with small squares.
    resisted: Columns,
    /// The least frequency of all others.
    pub(crate) elastic: f64,
    /// The largest frequency that double-doubles do not distinguish from 0.
    pub(crate) hidden: f64,
    /// Where C holds no relaxing shape so much that its root is distinguished from 0, a size that is larger than these roots.
    pub(super) hardly_held: Option<f64>,
}

impl Slow {
    /// Given the elastic shapes approximately; `None` where there are no such shapes, or they are not distinguished from others, and
    /// where C is not symmetric and K holds one so little that its roots are not distinguished from 0.
    pub(crate) fn of(system: &System, shapes: Vec<Vec<f64>>) -> Option<Slow> {
        let structure = system.structure();
        /// Squares that are so small beside the largest, with a gap as wide as this above them, if they are few.
        const SMALL: f64 = 1e-11;
        const GAP: f64 = 1e3;
        const MOST: usize = 24;
        let rigid = structure.rigid_motions_counted()?;
        let drifts = structure.zero_roots()?.checked_sub(rigid)?;
        let relaxed = rigid.checked_sub(drifts)?;
        let is_symmetric = structure.is_symmetric();
        // Coordinates without mass that dampers hold back follow at once where there are none.
        let undamped = (!is_symmetric || !structure.damped_massless().is_empty())
            .then(|| System::from(system.model().without_dampers()));
        let mut resisted = match &undamped {
            Some(undamped) => precise(undamped, shapes)?,
            None => precise(system, shapes)?,
        };
        let mut free: Columns = Vec::new();
        while let Some(last) = resisted.pop_if(|last| last.square == 0.0) {
            free.push(last.shape);
        }
        let size = |of: &Precise| of.square.abs();
        sort_by_number(&mut resisted, size);
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
        if !is_symmetric {
            let mut left = free.clone();
            uncouple_sides(&damping, &mut left, &mut free, relaxed)?;
            let [mut left_drifting, mut drifting] =
                [&mut left, &mut free].map(|columns| columns.split_off(relaxed));
            uncouple_sides(&mass, &mut left_drifting, &mut drifting, drifts)?;
            for (y, x) in left_drifting.iter().zip(&drifting) {
                take_out_sides(&mass, y, x, &mut left, &mut free);
            }
            return (hidden == 0.0).then(|| Slow {
                relaxing: free,
                drifting,
                left: Some([left, left_drifting]),
                resisted: resisted.collect(),
                elastic: elastic.sqrt(),
                hidden,
                hardly_held: None,
            });
        }
        uncouple(&damping, &mut free, relaxed);
        let mut drifting = free.split_off(relaxed);
        uncouple(&mass, &mut drifting, drifts);
        for drift in &drifting {
            take_out(&mass, drift, &mut free);
        }
        let hardly_held = hardly_held(system, &free);
        if hardly_held.is_some() {
            uncouple(&mass, &mut free, relaxed);
        }
        Some(Slow {
            hardly_held,
            relaxing: free,
            left: None,
            drifting,
            resisted: resisted.collect(),
            elastic: elastic.sqrt(),
            hidden: hidden.sqrt(),
        })
    }

    /// Whether a real root stands for one that is not distinguished from 0.
    pub(super) fn hides(&self, value: f64) -> bool {
        value.abs() == self.stand_in()
    }

    /// The size of two real roots ±ε that stand for two that are not distinguished from 0: large enough that rounding does not hide
    /// what they leave off the diagonal.
    pub(crate) fn stand_in(&self) -> f64 {
        const TIMES: f64 = 4.0;
        TIMES * self.hidden
    }

    /// The relaxing shapes that C hardly holds, each with the size of what stands for its root.
    pub(super) fn stand_ins(&self) -> impl Iterator<Item = (f64, &[DoubleDouble])> {
        let each = self.relaxing.iter();
        each.filter_map(|shape| Some((self.hardly_held?, shape.as_slice())))
    }

    /// Whether a root is one of theirs.
    pub(super) fn is_beside_zero(&self, value: Complex<f64>) -> bool {
        value.im == 0.0 && self.hardly_held.is_some_and(|size| value.re.abs() <= size)
    }

    fn columns(&self) -> Columns {
        let each = [&self.relaxing, &self.drifting, &self.resisted];
        each.into_iter().flatten().cloned().collect()
    }

    /// M, C and K for motions in their span.
    pub(crate) fn reduced(&self, system: &System) -> Option<System> {
        let columns = self.columns();
        let part = |form: Form<'_>, is_zero: &dyn Fn(usize) -> bool| {
            let gram = form.between(&columns, &columns);
            Mat::from_fn(columns.len(), columns.len(), |i, j| {
                let zero = is_zero(i) || is_zero(j);
                if zero { 0.0 } else { gram.at(i, j).to_f64() }
            })
        };
        let relaxed = self.relaxing.len();
        let rigid = relaxed + self.drifting.len();
        let mass = part(Form::mass(system), &|_| false);
        let damping = part(Form::damping(system), &|i| (relaxed..rigid).contains(&i));
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

/// Makes a form couple each of the first `count` columns on one side with one on the other alone, and those with none of
/// the others; `None` where it is singular on them.
fn uncouple_sides(
    form: &Form<'_>,
    left: &mut Columns,
    right: &mut Columns,
    count: usize,
) -> Option<()> {
    /// Of the largest entry.
    const SINGULAR: f64 = 1e-8;
    let mut least = 0.0;
    for step in 0..count {
        let gram = form.between(left, right);
        let size = |at: &(usize, usize)| gram.at(at.0, at.1).to_f64().abs();
        let rest = (step..left.len()).flat_map(|i| (step..right.len()).map(move |j| (i, j)));
        let largest = rest.max_by(|a, b| size(a).total_cmp(&size(b)))?;
        if step == 0 {
            least = SINGULAR * size(&largest);
        }
        if size(&largest).is_nan() || size(&largest) <= least {
            return None;
        }
        left.swap(step, largest.0);
        right.swap(step, largest.1);
        let (y, left) = left[step..].split_first_mut()?;
        let (x, right) = right[step..].split_first_mut()?;
        take_out_sides(form, y, x, left, right);
    }
    Some(())
}

/// Makes a form couple y and x with none of the other columns.
fn take_out_sides(
    form: &Form<'_>,
    y: &[DoubleDouble],
    x: &[DoubleDouble],
    left: &mut [Vec<DoubleDouble>],
    right: &mut [Vec<DoubleDouble>],
) {
    let [y, x] = [y, x].map(|column| [column.to_vec()]);
    let own = form.between(&y, &x).at(0, 0);
    let coupling = form.between(left, &x);
    subtract(&y[0], left, |i| coupling.at(i, 0) / own);
    let coupling = form.between(&y, right);
    subtract(&x[0], right, |j| coupling.at(0, j) / own);
}

/// Less a share of d in each column.
fn subtract(
    d: &[DoubleDouble],
    columns: &mut [Vec<DoubleDouble>],
    share: impl Fn(usize) -> DoubleDouble,
) {
    for (j, column) in columns.iter_mut().enumerate() {
        let share = share(j);
        for (entry, x) in column.iter_mut().zip(d) {
            *entry -= share * *x;
        }
    }
}

/// x − d (dᵀAx)/(dᵀAd) for each x.
fn take_out(form: &Form<'_>, d: &[DoubleDouble], columns: &mut [Vec<DoubleDouble>]) {
    let d = [d.to_vec()];
    let own = form.gram(&d).at(0, 0);
    let coupling = form.between(&d, columns);
    subtract(&d[0], columns, |j| coupling.at(0, j) / own);
}
