//! Modal masses, dampings and stiffnesses of real shapes, summed over the elements.
//!
//! A spring contributes k·(x_a − x_b)², which keeps soft springs beside stiff ones, as the assembled
//! K does not; the quotient k/m is stationary in x, so that it errs by the square of what the shape
//! does (Rayleigh).

use eigentone_digits::{DoubleDouble, Lanes, Real};
use faer::MatRef;

use crate::element::{Element, MatrixKind, Node};
use crate::system::System;

/// xᵀMx, xᵀCx and xᵀKx of a real shape x.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RealForms {
    pub(crate) m: DoubleDouble,
    pub(crate) c: DoubleDouble,
    pub(crate) k: DoubleDouble,
}

/// Shapes that are taken at a time.
const LANES: usize = 8;

impl RealForms {
    /// Those of one shape.
    pub(crate) fn one(system: &System, x: &[f64]) -> RealForms {
        let at = |node: Node| DoubleDouble::from(node.coordinate().map_or(0.0, |i| x[i]));
        let elements = |elements: &[Element]| {
            elements.iter().fold(DoubleDouble::ZERO, |sum, element| {
                let stretch = at(element.first) - at(element.second);
                sum + (stretch * stretch).mul_f64(element.coefficient)
            })
        };
        let masses = system.masses().iter().zip(x);
        let mut forms = RealForms {
            m: masses.fold(DoubleDouble::ZERO, |sum, (mass, x)| {
                sum + DoubleDouble::product(*x, *x).mul_f64(*mass)
            }),
            c: elements(system.dampers()),
            k: elements(system.springs()),
        };
        forms.add_matrices(system, x);
        forms
    }

    /// Those of many shapes, together.
    pub(crate) fn of(system: &System, shapes: &[&[f64]]) -> Vec<RealForms> {
        let n = system.len();
        let mut columns = vec![[0.0; LANES]; n];
        let mut all = Vec::with_capacity(shapes.len());
        for block in shapes.chunks(LANES) {
            for (lane, x) in block.iter().enumerate() {
                for (column, x) in columns.iter_mut().zip(*x) {
                    column[lane] = *x;
                }
            }
            let [m, c, k] = sums(system, &columns);
            all.extend(block.iter().enumerate().map(|(lane, x)| {
                let mut forms = RealForms {
                    m: m.get(lane),
                    c: c.get(lane),
                    k: k.get(lane),
                };
                let parts = [forms.m, forms.c, forms.k];
                if parts.iter().all(|part| part.to_f64().is_finite()) {
                    forms.add_matrices(system, x);
                    forms
                } else {
                    RealForms::one(system, x)
                }
            }));
        }
        all
    }

    fn add_matrices(&mut self, system: &System, x: &[f64]) {
        for (kind, form) in [
            (MatrixKind::Mass, &mut self.m),
            (MatrixKind::Damping, &mut self.c),
            (MatrixKind::Stiffness, &mut self.k),
        ] {
            if let Some(matrix) = system.added(kind) {
                *form = *form + quadratic_form(matrix, x);
            }
        }
    }

    /// k/m in doubles.
    pub(crate) fn quotient(&self) -> f64 {
        (self.k / self.m).to_f64()
    }
}

/// The elements' shares of the three forms.
fn sums(system: &System, columns: &[[f64; LANES]]) -> [Lanes<LANES>; 3] {
    const GROUND: [f64; LANES] = [0.0; LANES];
    let at = |node: Node| node.coordinate().map_or(&GROUND, |i| &columns[i]);
    let elements = |elements: &[Element]| {
        let mut sum = Lanes::ZERO;
        for element in elements {
            sum.add_square(element.coefficient, at(element.first), at(element.second));
        }
        sum
    };
    let mut mass = Lanes::ZERO;
    for (factor, column) in system.masses().iter().zip(columns) {
        mass.add_square(*factor, column, &GROUND);
    }
    [
        mass,
        elements(system.dampers()),
        elements(system.springs()),
    ]
}

/// xᵀAx.
fn quadratic_form(matrix: MatRef<'_, f64>, x: &[f64]) -> DoubleDouble {
    let mut form = DoubleDouble::ZERO;
    for (j, xj) in x.iter().enumerate() {
        let mut column = DoubleDouble::ZERO;
        for (entry, xi) in matrix.col(j).iter().zip(x) {
            if *entry != 0.0 {
                column = column + DoubleDouble::product(*entry, *xi);
            }
        }
        form = form + column.mul_f64(*xj);
    }
    form
}
