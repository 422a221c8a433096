//! Roots from shapes: the two-sided Rayleigh functional, summed over the elements in
//! double-double.
//!
//! With m = y*Mx, c = y*Cx, k = y*Kx the root of mλ² + cλ + k near an approximation is stationary
//! in x and y: errors ε of the shapes enter λ as ε² (Lancaster 1966, *Lambda-matrices and
//! vibrating systems*, §5.5). A spring contributes k·(y_a − y_b)*(x_a − x_b), which keeps soft
//! springs beside stiff ones, as the assembled K does not.

use eigentone_digits::{ComplexDoubleDouble, DoubleDouble};
use num_complex::Complex;

use crate::element::{Element, MatrixKind, Node};
use crate::system::System;

/// y*Mx, y*Cx and y*Kx, or for a real shape x = y their real values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Forms {
    pub(crate) m: ComplexDoubleDouble,
    pub(crate) c: ComplexDoubleDouble,
    pub(crate) k: ComplexDoubleDouble,
}

impl Forms {
    /// The three forms of shapes x and y.
    pub(crate) fn of(system: &System, y: &[Complex<f64>], x: &[Complex<f64>]) -> Forms {
        let entry = |v: Complex<f64>| ComplexDoubleDouble::new(v.re, v.im);
        let mut m = ComplexDoubleDouble::ZERO;
        for (i, mass) in system
            .masses()
            .iter()
            .enumerate()
            .filter(|(_, mass)| **mass != 0.0)
        {
            m += entry(y[i].conj()) * entry(x[i]) * *mass;
        }
        let mut forms = Forms {
            m,
            c: element_form(system.dampers(), y, x),
            k: element_form(system.springs(), y, x),
        };
        for (kind, form) in [
            (MatrixKind::Mass, &mut forms.m),
            (MatrixKind::Damping, &mut forms.c),
            (MatrixKind::Stiffness, &mut forms.k),
        ] {
            let Some(matrix) = system.added(kind) else {
                continue;
            };
            for (j, xj) in x.iter().enumerate() {
                let mut column = ComplexDoubleDouble::ZERO;
                for (i, yi) in y.iter().enumerate() {
                    if matrix[(i, j)] != 0.0 {
                        column += entry(yi.conj()) * matrix[(i, j)];
                    }
                }
                *form += column * entry(*xj);
            }
        }
        forms
    }

    /// The root of mλ² + cλ + k to which Newton's method leads from `start`, or `None` where the
    /// root is nearly double.
    pub(crate) fn root(&self, start: Complex<f64>) -> Option<Complex<f64>> {
        let mut lambda = ComplexDoubleDouble::new(start.re, start.im);
        for _ in 0..3 {
            let value = (self.m * lambda + self.c) * lambda + self.k;
            let slope = self.m * lambda * 2.0 + self.c;
            let step = value / slope;
            if !step.norm().is_finite() || step.norm() > 1e-2 * lambda.norm() {
                return None;
            }
            lambda = lambda - step;
        }
        Some(Complex::new(lambda.re.to_f64(), lambda.im.to_f64()))
    }
}

fn element_form(
    elements: &[Element],
    y: &[Complex<f64>],
    x: &[Complex<f64>],
) -> ComplexDoubleDouble {
    let at =
        |shape: &[Complex<f64>], node: Node| node.coordinate().map_or(Complex::ZERO, |i| shape[i]);
    let stretch = |shape: &[Complex<f64>], element: &Element| {
        let (first, second) = (at(shape, element.first), at(shape, element.second));
        ComplexDoubleDouble {
            re: DoubleDouble::new(first.re, -second.re),
            im: DoubleDouble::new(first.im, -second.im),
        }
    };
    let mut sum = ComplexDoubleDouble::ZERO;
    for element in elements {
        let left = stretch(y, element);
        let left = ComplexDoubleDouble {
            re: left.re,
            im: -left.im,
        };
        sum += left * stretch(x, element) * element.coefficient;
    }
    sum
}
