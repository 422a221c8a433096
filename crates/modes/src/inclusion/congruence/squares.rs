//! The squares of all undamped frequencies, in order, with their shapes.

use std::cmp::Ordering;
use std::ops::Range;

use eigentone_digits::{Ball, DoubleDouble};
use faer::Mat;

use super::closer::Closer;
use super::forms::Basis;
use super::refine::Goal;
use crate::inclusion::bounded_shape::Shape;
use crate::inclusion::gram::{Form, UPWARD};
use crate::inclusion::quadratic::around;
use crate::structure::Structure;
use crate::system::System;

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
    pub(in crate::inclusion) fn around(&self, group: &Range<usize>) -> Ball<DoubleDouble> {
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
