//! Approximate roots with their shapes.

use eigentone_digits::{ComplexDoubleDouble, DoubleDouble, modulus};
use faer::c64;
use num_complex::Complex;

use crate::inclusion::gram::{Form, Gram};
use crate::inclusion::inert::Inert;
use crate::inclusion::sliced;
use crate::inclusion::slow::{self, Slow};
use crate::modes::Mode;
use crate::system::System;

/// A complex vector.
#[derive(Clone)]
pub(super) struct Parts {
    pub(super) re: Vec<DoubleDouble>,
    /// Nothing for real roots.
    pub(super) im: Vec<DoubleDouble>,
}

impl Parts {
    fn real(re: Vec<DoubleDouble>) -> Parts {
        Parts { re, im: Vec::new() }
    }

    /// A component in doubles.
    pub(super) fn at(&self, row: usize) -> Complex<f64> {
        let im = self.im.get(row).map_or(0.0, |im| im.to_f64());
        Complex::new(self.re[row].to_f64(), im)
    }
}

/// An approximate root with Im ≥ 0, and its shapes.
#[derive(Clone)]
pub(super) struct Pair {
    pub(super) value: ComplexDoubleDouble,
    pub(super) right: Parts,
    /// y with yᵀQ = 0, where that is not x by symmetry.
    pub(super) left: Option<Parts>,
    pub(super) origin: Origin,
}

/// Where a pair comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Origin {
    /// One of the given modes.
    Mode(usize),
    /// The same of a root that double-doubles do not distinguish from 0; its value stays as it is given.
    Hidden(usize),
    /// λ = 0 exactly, with an exact shape.
    Rest,
    /// λ = 0, which is counted exactly, with a shape that is not exact.
    Null,
    /// The same of a motion that nothing holds: one of two columns (x, ±εx), which are so near to (x, 0) and (0, x).
    Drift,
    /// (x, −εx) beside such an (x, εx) for λ = 0 where C hardly holds the motion x: it stands for the mode's root, which is
    /// not distinguished from 0 and has this value without it.
    Beside(usize, f64),
}

impl Origin {
    /// Whether it stands for a root at 0, or one that is counted with those.
    pub(super) fn is_counted(self) -> bool {
        matches!(self, Origin::Null | Origin::Drift | Origin::Beside(..))
    }
}

impl Pair {
    pub(super) fn mode(&self) -> Option<usize> {
        match self.origin {
            Origin::Mode(mode) | Origin::Hidden(mode) | Origin::Beside(mode, _) => Some(mode),
            Origin::Rest | Origin::Null | Origin::Drift => None,
        }
    }

    fn real(value: f64, shape: Vec<DoubleDouble>, origin: Origin) -> Pair {
        Pair {
            value: ComplexDoubleDouble::new(value, 0.0),
            right: Parts::real(shape),
            left: None,
            origin,
        }
    }

    /// Whether root and shape stay as they are given.
    pub(super) fn is_given(&self) -> bool {
        self.origin.is_counted() || self.origin == Origin::Rest
    }

    pub(super) fn is_real(&self) -> bool {
        self.right.im.is_empty()
    }

    /// How many real columns its shape is.
    pub(super) fn parts(&self) -> usize {
        if self.is_real() { 1 } else { 2 }
    }

    pub(super) fn right(&self) -> &Parts {
        &self.right
    }

    pub(super) fn left(&self) -> &Parts {
        self.left.as_ref().unwrap_or(&self.right)
    }
}

/// The roots and shapes, with the forms that they are to diagonalise.
pub(super) struct Pairs<'a> {
    pub(super) system: &'a System,
    pub(super) pairs: Vec<Pair>,
    /// The motions that nothing holds, exactly.
    pub(super) drifting: Vec<Vec<DoubleDouble>>,
    /// The coordinates that follow at once.
    pub(super) inert: Inert,
}

/// Which column: that of a pair, or its conjugate.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Column {
    pub(super) pair: usize,
    pub(super) conjugate: bool,
}

pub(super) fn plain(z: ComplexDoubleDouble) -> c64 {
    c64::new(z.re.to_f64(), z.im.to_f64())
}

/// |z|, quicker than by `hypot`.
pub(super) fn norm(z: c64) -> f64 {
    modulus(z.re, z.im)
}

impl<'a> Pairs<'a> {
    pub(super) fn of(system: &'a System, modes: &[Mode], slow: Option<&Slow>) -> Option<Pairs<'a>> {
        let structure = system.structure();
        let n = system.len();
        let is_symmetric = structure.is_symmetric();
        let inert = Inert::of(system)?;
        let states = n - inert.count() + massive(system);
        let applies = structure.finite_roots() == Some(states)
            && (is_symmetric || structure.zero_roots() == Some(0) || slow.is_some());
        if !applies {
            return None;
        }
        let precise = |vector: Vec<f64>| vector.into_iter().map(DoubleDouble::from).collect();
        let loose = structure.null_vectors();
        let free = structure.undamped_among(&loose);
        let held = loose.iter().filter(|vector| !free.contains(vector));
        let at_rest = free.iter().chain(held).map(|vector| vector.dense(n));
        let mut drifting = nearly_orthogonal(&Form::mass(system), at_rest.collect());
        let relaxing = drifting.split_off(free.len());
        let mut pairs = match slow {
            Some(slow) => {
                if slow.drifting.len() != drifting.len() {
                    drifting.clear();
                }
                counted(system, slow, drifting.is_empty())
            }
            None => {
                if structure.zero_roots() != Some(loose.len() + free.len()) {
                    return None;
                }
                let relaxing = nearly_orthogonal(&Form::damping(system), relaxing);
                let rest = |shape| Pair::real(0.0, precise(shape), Origin::Rest);
                relaxing.into_iter().map(rest).collect()
            }
        };
        let drifting: Vec<Vec<DoubleDouble>> = drifting.into_iter().map(precise).collect();
        let drifts = 2 * drifting.len();
        let mut stand_ins = slow.into_iter().flat_map(Slow::stand_ins);
        for (index, mode) in modes.iter().enumerate() {
            let value = mode.eigenvalue().value;
            if value.norm() == 0.0 {
                continue;
            }
            if slow.is_some_and(|slow| slow.is_beside_zero(value)) {
                let (stand_in, shape) = stand_ins.next()?;
                let origin = Origin::Beside(index, value.re);
                pairs.push(Pair::real(-stand_in, shape.to_vec(), origin));
                continue;
            }
            if mode.roots() > 1 {
                return None;
            }
            let parts = |shape: &[Complex<f64>], sign: f64| {
                let re = shape.iter().map(|z| DoubleDouble::from(z.re));
                let im = shape.iter().map(|z| DoubleDouble::from(sign * z.im));
                let is_real = value.im == 0.0;
                Parts {
                    re: re.collect(),
                    im: im.filter(|_| !is_real).collect(),
                }
            };
            let left = if is_symmetric {
                None
            } else {
                // y*Q = 0 there.
                Some(parts(mode.left_shape()?, -1.0))
            };
            pairs.push(Pair {
                value: ComplexDoubleDouble::new(value.re, value.im),
                right: parts(mode.shape(), 1.0),
                left,
                origin: if value.im == 0.0 && slow.is_some_and(|slow| slow.hides(value.re)) {
                    Origin::Hidden(index)
                } else {
                    Origin::Mode(index)
                },
            });
        }
        let count: usize = pairs.iter().map(Pair::parts).sum();
        shorten(system, &mut pairs);
        let all = stand_ins.next().is_none() && count + drifts == states;
        all.then_some(Pairs {
            system,
            pairs,
            drifting,
            inert,
        })
    }

    /// The real columns of all shapes on one side, and where each pair has its own.
    pub(super) fn real_columns(
        &self,
        side: fn(&Pair) -> &Parts,
    ) -> (Vec<Vec<DoubleDouble>>, Vec<usize>) {
        let mut columns = Vec::new();
        let mut places = Vec::with_capacity(self.pairs.len());
        for pair in &self.pairs {
            places.push(columns.len());
            columns.push(side(pair).re.clone());
            if !pair.is_real() {
                columns.push(side(pair).im.clone());
            }
        }
        (columns, places)
    }

    /// Takes what drifts out of all other shapes, as far as rounding goes.
    pub(super) fn project(&mut self) -> Option<()> {
        let nearly = self.pairs.iter();
        let nearly = nearly.filter(|pair| pair.origin == Origin::Drift);
        let nearly = nearly.step_by(2).map(|pair| [pair.right(), pair.left()]);
        let nearly = nearly.map(|sides| sides.map(|parts| parts.re.clone()));
        let exactly = self.drifting.iter().map(|x| [x.clone(), x.clone()]);
        let drifting: Vec<[Vec<DoubleDouble>; 2]> = exactly.chain(nearly).collect();
        for [x, y] in &drifting {
            self.take_out(Pair::right, |pair| Some(&mut pair.right), x, y)?;
            if self.has_left() {
                self.take_out(Pair::left, |pair| pair.left.as_mut(), y, x)?;
            }
        }
        self.uncouple_from_rest();
        self.follow_at_once();
        Some(())
    }

    /// Takes a motion that drifts out of the shapes on its side, which M couples no more with that on the other.
    fn take_out(
        &mut self,
        side: fn(&Pair) -> &Parts,
        parts: fn(&mut Pair) -> Option<&mut Parts>,
        own: &[DoubleDouble],
        other: &[DoubleDouble],
    ) -> Option<()> {
        let (mut columns, places) = self.real_columns(side);
        let last = columns.len();
        columns.push(own.to_vec());
        let mass = Form::mass(self.system).between(&columns, &[other.to_vec()]);
        let whole = mass.at(last, 0);
        let moving = self.pairs.iter_mut().zip(places);
        for (pair, place) in moving.filter(|(pair, _)| !pair.is_given()) {
            let Parts { re, im } = parts(pair)?;
            for (offset, column) in [re, im].into_iter().enumerate() {
                if column.is_empty() {
                    continue;
                }
                let share = mass.at(place + offset, 0) / whole;
                if !share.to_f64().is_finite() {
                    return None;
                }
                for (entry, rigid) in column.iter_mut().zip(own) {
                    *entry -= share * *rigid;
                }
            }
        }
        Some(())
    }

    /// Lets the coordinates that neither masses nor dampers move follow in all shapes but exact ones.
    fn follow_at_once(&mut self) {
        if self.inert.count() == 0 {
            return;
        }
        let stiffness = Form::stiffness(self.system);
        let (mut columns, places) = self.real_columns(Pair::right);
        self.inert.follow(&stiffness, &mut columns);
        let mut left = self.has_left().then(|| self.real_columns(Pair::left).0);
        if let Some(columns) = &mut left {
            self.inert.follow(&stiffness, columns);
        }
        for (pair, place) in self.pairs.iter_mut().zip(places) {
            if pair.origin == Origin::Rest {
                continue;
            }
            let left = pair.left.as_mut().zip(left.as_mut());
            for (parts, columns) in [(&mut pair.right, &mut columns)].into_iter().chain(left) {
                parts.re = std::mem::take(&mut columns[place]);
                if !parts.im.is_empty() {
                    parts.im = std::mem::take(&mut columns[place + 1]);
                }
            }
        }
    }

    /// Takes the shapes of roots at 0 out of all others, which B makes orthogonal: xᵀ(C + λM)x_i = 0. Roots near 0 would
    /// keep what they hold of them. Corrections of unsymmetric systems do so.
    fn uncouple_from_rest(&mut self) {
        /// Of xᵀ(C + λM)x where it vanishes, as at another root of nearly the same shape: errors of λ count by its inverse.
        const VANISHING: f64 = 3e-2;
        if self.has_left() {
            return;
        }
        for rest in 0..self.pairs.len() {
            if !matches!(self.pairs[rest].origin, Origin::Null | Origin::Rest) {
                continue;
            }
            let shape = self.pairs[rest].right.re.clone();
            let (columns, places) = self.real_columns(Pair::right);
            let [mass, damping] = [Form::mass(self.system), Form::damping(self.system)]
                .map(|form| form.between(&columns, std::slice::from_ref(&shape)));
            let at = |gram: &Gram, pair: &Pair, place: usize| ComplexDoubleDouble {
                re: gram.at(place, 0),
                im: if pair.is_real() {
                    DoubleDouble::ZERO
                } else {
                    gram.at(place + 1, 0)
                },
            };
            let own = [&mass, &damping].map(|gram| gram.at(places[rest], 0));
            for (pair, place) in self.pairs.iter_mut().zip(places) {
                if pair.is_given() {
                    continue;
                }
                let real = |re| ComplexDoubleDouble {
                    re,
                    im: DoubleDouble::ZERO,
                };
                let whole = pair.value * real(own[0]) + real(own[1]);
                let size = pair.value.norm() * own[0].to_f64().abs() + own[1].to_f64().abs();
                let coupling = at(&damping, pair, place) + pair.value * at(&mass, pair, place);
                let share = coupling / whole;
                if whole.norm() <= VANISHING * size || !share.is_finite() {
                    continue;
                }
                for (part, share) in [
                    (&mut pair.right.re, share.re),
                    (&mut pair.right.im, share.im),
                ] {
                    for (entry, x) in part.iter_mut().zip(&shape) {
                        *entry -= share * *x;
                    }
                }
            }
        }
    }

    pub(super) fn has_left(&self) -> bool {
        self.pairs.iter().any(|pair| pair.left.is_some())
    }

    /// The columns of all states, less those that drift.
    pub(super) fn columns(&self) -> Vec<Column> {
        let both = |(pair, found): (usize, &Pair)| {
            let column = |conjugate| Column { pair, conjugate };
            if found.is_real() {
                vec![column(false)]
            } else {
                vec![column(false), column(true)]
            }
        };
        self.pairs.iter().enumerate().flat_map(both).collect()
    }
}

/// Shortens shapes whose forms are taken in slices, where roots are of nearly the same size.
fn shorten(system: &System, pairs: &mut [Pair]) {
    let forms = [Form::mass, Form::damping, Form::stiffness].map(|form| form(system));
    let count = pairs.iter().map(Pair::parts).sum();
    let squares = pairs.iter().map(|pair| pair.value.norm().powi(2));
    if !forms.iter().any(|form| form.is_sliced(count)) || !sliced::are_alike(squares) {
        return;
    }
    for pair in pairs.iter_mut().filter(|pair| !pair.is_given()) {
        for Parts { re, im } in std::iter::once(&mut pair.right).chain(&mut pair.left) {
            sliced::shorten(re);
            sliced::shorten(im);
        }
    }
}

/// Columns for the shapes of roots at 0 that are counted, those that drift only if they are not known exactly.
fn counted(system: &System, slow: &Slow, with_drifting: bool) -> Vec<Pair> {
    let value = slow.hardly_held.unwrap_or(0.0);
    let [left_relaxing, left_drifting] = match &slow.left {
        Some([relaxing, drifting]) => [Some(relaxing), Some(drifting)],
        None => [None, None],
    };
    let pair = |value, i: usize, right: &[DoubleDouble], left: Option<&Vec<Vec<_>>>, origin| Pair {
        left: left.map(|left| Parts::real(left[i].clone())),
        ..Pair::real(value, right.to_vec(), origin)
    };
    let relaxing = slow.relaxing.iter().enumerate();
    let relaxing = relaxing.map(|(i, x)| pair(value, i, x, left_relaxing, Origin::Null));
    let unseen = slow::unseen(system, &slow.drifting).into_iter();
    let drifting = slow.drifting.iter().zip(unseen).enumerate();
    let drifting = drifting.flat_map(|(i, (x, size))| {
        [size, -size].map(|value| pair(value, i, x, left_drifting, Origin::Drift))
    });
    let drifting = drifting.filter(|_| with_drifting);
    relaxing.chain(drifting).collect()
}

/// How many coordinates have a row or column of M that is not 0.
fn massive(system: &System) -> usize {
    let mass = system.mass_matrix();
    let moves = |i: &usize| (0..mass.nrows()).any(|j| mass[(*i, j)] != 0.0 || mass[(j, *i)] != 0.0);
    (0..mass.nrows()).filter(moves).count()
}

/// Vectors made orthogonal by a form to a few digits, as far as doubles hold the combinations exactly.
fn nearly_orthogonal(form: &Form<'_>, mut vectors: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    /// Where so many float they are parts of a network, which share no coordinate.
    const MOST: usize = 6;
    const BITS: f64 = 18.0;
    if vectors.len() > MOST {
        return vectors;
    }
    for last in 1..vectors.len() {
        for other in 0..last {
            let pair = [other, last].map(|i| vectors[i].iter().map(|x| DoubleDouble::from(*x)));
            let gram = form.gram(&pair.map(Iterator::collect));
            let share = (gram.at(0, 1) / gram.at(0, 0)).to_f64();
            let unit = (share.abs().log2().floor() - BITS).exp2();
            let share = (share / unit).round() * unit;
            let less = |(x, y): (&f64, &f64)| {
                let product = share * y;
                let difference = x - product;
                let is_exact = share.mul_add(*y, -product) == 0.0
                    && difference + product == *x
                    && x - difference == product;
                is_exact.then_some(difference)
            };
            let each = vectors[last].iter().zip(&vectors[other]);
            if let Some(combined) = each.map(less).collect() {
                vectors[last] = combined;
            }
        }
    }
    vectors
}
