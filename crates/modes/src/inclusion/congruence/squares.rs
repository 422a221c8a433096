//! The squares of all undamped frequencies, in order, with their shapes.

use std::cmp::Ordering;
use std::ops::Range;

use eigentone_digits::{Ball, DoubleDouble, product};
use faer::Mat;

use super::closer::Closer;
use super::forms::Basis;
use super::refine::Goal;
use crate::inclusion::bounded_shape::Shape;
use crate::inclusion::gram::{Form, SLICES, UPWARD};
use crate::inclusion::inert::Inert;
use crate::inclusion::quadratic::around;
use crate::inclusion::sliced;
use crate::system::System;

/// The nonzero eigenvalues σ = ω² of (K, M), rising, with their shapes.
pub(crate) struct Squares {
    pub(crate) values: Vec<DoubleDouble>,
    pub(crate) shapes: Vec<Shape>,
    /// In the same order; after them the shapes with ω = 0, of which those of whole parts are exact.
    pub(crate) columns: Vec<Vec<DoubleDouble>>,
    /// Bounds of the errors of the values.
    pub(crate) reach: Vec<f64>,
    /// How many shapes with ω = 0 are not exact.
    pub(crate) null: usize,
}

impl Squares {
    /// The shape of one of them.
    pub(crate) fn shape(&self, i: usize) -> Shape {
        self.shapes[i].clone()
    }

    /// A ball that holds all true values of a group.
    pub(in crate::inclusion) fn around(&self, group: &Range<usize>) -> Ball<DoubleDouble> {
        let centre = self.values[(group.start + group.end) / 2];
        let reach = group.clone().map(|i| {
            let value = self.values[i];
            (value - centre).to_f64().abs() + self.reach[i]
        });
        around(centre, reach.fold(0.0, f64::max) * UPWARD)
    }

    /// The values in groups, each of which begins at 0 or where `begins` is true.
    pub(in crate::inclusion) fn apart_where(
        &self,
        begins: impl Fn(usize) -> bool,
    ) -> Vec<Range<usize>> {
        let mut groups: Vec<Range<usize>> = Vec::new();
        for i in 0..self.values.len() {
            match groups.last_mut() {
                Some(group) if !begins(i) => group.end = i + 1,
                _ => groups.push(i..i + 1),
            }
        }
        groups
    }

    /// Those that their bounds do not separate.
    pub(crate) fn groups(&self) -> Vec<Range<usize>> {
        let touch = |i: usize| {
            let gap = (self.values[i] - self.values[i - 1]).to_f64();
            gap <= (self.reach[i] + self.reach[i - 1]) * UPWARD
        };
        self.apart_where(|i| !touch(i))
    }
}

/// The same for (K, M) of any system with M and K symmetric and no dampers on massless nodes, and its shapes with
/// components within a relative tolerance where digits allow, given its elastic shapes approximately: as many as K has
/// nonzero eigenvalues.
pub(crate) fn squares(
    system: &System,
    shapes: Vec<Vec<f64>>,
    goal: Goal,
    tolerance: f64,
) -> Option<Squares> {
    let mut basis = basis(system, shapes)?.shortened(system);
    let (elastic, null) = (basis.elastic - basis.null, basis.null);
    let forms = basis.refine(goal)?;
    let (forms, mut enclosed) = basis.enclosed(forms, tolerance);
    let mut order: Vec<usize> = (0..elastic).collect();
    let value = |i: usize| forms.squares[i];
    order.sort_by(|a, b| {
        let order = value(*a).partial_cmp(&value(*b));
        order.unwrap_or(Ordering::Equal)
    });
    let rest: Vec<usize> = (elastic..basis.columns.len()).collect();
    let mut found = Squares {
        null,
        values: order.iter().map(|i| value(*i)).collect(),
        shapes: Vec::with_capacity(elastic),
        columns: order
            .iter()
            .chain(&rest)
            .map(|i| basis.columns[*i].clone())
            .collect(),
        reach: order.iter().map(|i| forms.reach[*i]).collect(),
    };
    let mut alone = vec![false; elastic];
    for group in found.groups().into_iter().filter(|group| group.len() == 1) {
        alone[group.start] = true;
    }
    let closer = Closer::of(system, &found.values, tolerance);
    for (at, i) in order.into_iter().enumerate() {
        let proven =
            alone[at].then(|| closer.shape(found.values[at], found.reach[at], enclosed[i].take()));
        let shape = proven.flatten().map(Shape::from);
        let shape = shape.unwrap_or_else(|| Shape::plain(&basis.columns[i]));
        found.shapes.push(shape);
    }
    Some(found)
}

/// All σ = ω² of (K, M), how far each may be off, relative, and their shapes, given the elastic ones approximately, refined
/// until the forms of all are as near to diagonal as the goal, or as 32 digits come. `None` where these are too far from the true
/// ones.
pub(crate) fn refined(
    system: &System,
    shapes: Vec<Vec<f64>>,
    goal: f64,
) -> Option<Vec<(f64, f64, Vec<f64>)>> {
    const KNOWN: f64 = 1e-3;
    let mut basis = basis(system, shapes)?;
    let forms = basis.refine(Goal::always(goal))?;
    if forms.spread > KNOWN {
        return None;
    }
    let square = |i: usize| forms.squares.get(i).map_or(0.0, |square| square.to_f64());
    let rounded = basis.columns.iter().enumerate().map(|(i, column)| {
        let shape = column.iter().map(|x| x.to_f64()).collect();
        let reach = forms
            .reach
            .get(i)
            .map_or(0.0, |reach| reach / square(i).abs());
        (square(i), reach, shape)
    });
    Some(rounded.collect())
}

/// A shape in double-double with its σ and a bound of its error.
pub(in crate::inclusion) struct Precise {
    pub(in crate::inclusion) square: f64,
    pub(in crate::inclusion) reach: f64,
    pub(in crate::inclusion) shape: Vec<DoubleDouble>,
}

/// All shapes as near as double-doubles come, those with σ = 0, which are counted, last.
pub(in crate::inclusion) fn precise(
    system: &System,
    shapes: Vec<Vec<f64>>,
) -> Option<Vec<Precise>> {
    const GOAL: f64 = 1e-27;
    let mut basis = basis(system, shapes)?.shortened(system);
    let forms = basis.refine(Goal::always(GOAL))?;
    let each = basis.columns.into_iter().enumerate();
    let each = each.map(|(i, shape)| Precise {
        square: forms.squares.get(i).map_or(0.0, |square| square.to_f64()),
        reach: forms.reach.get(i).copied().unwrap_or(0.0),
        shape,
    });
    Some(each.collect())
}

impl Basis<'_> {
    /// With shapes rounded to what two slices hold, where they are to be refined far beyond that, and little is lost by it.
    fn shortened(mut self, system: &System) -> Self {
        let elastic = &mut self.columns[..self.elastic];
        if !self.stiffness.is_sliced(elastic.len()) {
            return self;
        }
        let shapes = Mat::from_fn(system.len(), elastic.len(), |i, j| elastic[j][i].to_f64());
        let squares = quadratic(&system.stiffness_matrix(), &shapes);
        if sliced::are_alike(squares.into_iter().map(f64::abs)) {
            elastic.iter_mut().for_each(|x| sliced::shorten(x));
            self.inert.follow(&self.stiffness, elastic);
        }
        self
    }
}

/// xᵀAx of each shape x, in doubles.
fn quadratic(matrix: &Mat<f64>, shapes: &Mat<f64>) -> Vec<f64> {
    let forces = product(matrix.as_ref(), shapes.as_ref());
    let each = shapes.col_iter().zip(forces.col_iter());
    each.map(|(x, force)| x.transpose() * force).collect()
}

/// The elastic shapes, those with ω = 0 that are not exact, and those that are.
pub(super) fn basis<'a>(system: &'a System, shapes: Vec<Vec<f64>>) -> Option<Basis<'a>> {
    let structure = system.structure();
    let rigid = structure.spring_floating();
    let n = system.len();
    if !structure.is_symmetric() || !structure.damped_massless().is_empty() {
        return None;
    }
    let inert = Inert::of(system)?;
    let null = n.checked_sub(inert.count() + shapes.len() + rigid.len())?;
    if null > 0 && structure.rigid_motions_counted() != Some(null + rigid.len()) {
        return None;
    }
    let mass = system.mass_matrix();
    let normed = |shapes: Vec<Vec<f64>>| -> Vec<Vec<f64>> {
        let squares = quadratic(&mass, &Mat::from_fn(n, shapes.len(), |i, j| shapes[j][i]));
        let each = shapes.into_iter().zip(squares);
        let one = |(shape, square): (Vec<f64>, f64)| {
            shape.into_iter().map(|x| x / square.sqrt()).collect()
        };
        each.map(one).collect()
    };
    let mut columns = normed(shapes);
    let elastic = columns.len() + null;
    let whole = rigid.iter().map(|part| {
        let within = |i| if part.contains(&i) { 1.0 } else { 0.0 };
        (0..n).map(within).collect()
    });
    let whole = normed(whole.collect());
    if null > 0 {
        columns.extend(complement(&mass, columns.iter().chain(&whole), null)?);
    }
    columns.extend(whole);
    let precise = |column: Vec<f64>| column.into_iter().map(DoubleDouble::from).collect();
    let mut columns: Vec<Vec<DoubleDouble>> = columns.into_iter().map(precise).collect();
    let stiffness = Form::stiffness(system);
    for _ in 0..2 {
        inert.follow(&stiffness, &mut columns[..elastic]);
    }
    Some(Basis {
        stiffness,
        mass: Form::mass(system),
        columns,
        elastic,
        null,
        inert,
        slices: SLICES,
    })
}

/// So many shapes that M makes orthogonal to all others and to each other, approximately.
fn complement<'a>(
    mass: &Mat<f64>,
    others: impl Iterator<Item = &'a Vec<f64>>,
    count: usize,
) -> Option<Vec<Vec<f64>>> {
    let n = mass.nrows();
    let others: Vec<&Vec<f64>> = others.collect();
    let known = Mat::from_fn(n, others.len(), |i, j| others[j][i]);
    // X Xᵀ M projects on the shapes X; what it leaves of unit vectors lies in the complement.
    let mut rest = Mat::<f64>::identity(n, n);
    for _ in 0..2 {
        let share = known.transpose() * (mass * &rest);
        rest -= &known * share;
    }
    let mut found: Vec<Vec<f64>> = Vec::with_capacity(count);
    for _ in 0..count {
        let lengths = mass * &rest;
        let length = |j: usize| -> f64 { (0..n).map(|i| rest[(i, j)] * lengths[(i, j)]).sum() };
        // Against the length that the unit vector had.
        let left = |j: usize| length(j) / mass[(j, j)];
        let massive = (0..n).filter(|j| mass[(*j, *j)] > 0.0);
        let best = massive.max_by(|a, b| left(*a).total_cmp(&left(*b)))?;
        let norm = length(best).sqrt();
        let column = Mat::from_fn(n, 1, |i, _| rest[(i, best)] / norm);
        let share = column.transpose() * &lengths;
        rest -= &column * share;
        found.push(column.col(0).iter().copied().collect());
    }
    let finite = found.iter().flatten().all(|x| x.is_finite());
    finite.then_some(found)
}
