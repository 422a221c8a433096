//! Residuals and conditions of roots in the whole equation.

use num_complex::Complex;

use super::answer::{Parts, Root};
use super::basis::dot;
use super::form::Form;
use crate::model::Names;
use crate::modes::{Eigenvalue, Mode};
use crate::solver::normalised;

/// Measures residuals in the whole equation.
pub(crate) struct Judge<'a> {
    /// M, C and K.
    forms: [&'a Form; 3],
    /// Their Frobenius norms.
    norms: [f64; 3],
}

impl<'a> Judge<'a> {
    pub(crate) fn of(forms: [&'a Form; 3]) -> Judge<'a> {
        Judge {
            forms,
            norms: forms.map(Form::norm),
        }
    }

    /// Q(λ)x.
    fn residual(&self, value: Complex<f64>, shape: &Parts) -> Parts {
        let n = shape[0].len();
        let mut rest = [vec![0.0; n], vec![0.0; n]];
        let mut product = vec![0.0; n];
        let one = Complex::ONE;
        for (form, factor) in self.forms.into_iter().zip([value * value, value, one]) {
            for (part, unit) in shape.iter().zip([one, Complex::I]) {
                form.apply(part, &mut product);
                let factor = factor * unit;
                for (rest, factor) in rest.iter_mut().zip([factor.re, factor.im]) {
                    let pairs = rest.iter_mut().zip(&product);
                    pairs.for_each(|(rest, value)| *rest += factor * value);
                }
            }
        }
        rest
    }

    pub(crate) fn mode(&self, root: Root, names: &Names) -> Mode {
        let Root {
            value,
            error,
            shape,
            repeats,
            roots,
        } = root;
        let rest = self.residual(value, &shape);
        let squared = |x: &Parts| dot(&x[0], &x[0]) + dot(&x[1], &x[1]);
        let [mass, damping, stiffness] = self.norms;
        let size = value.norm();
        let scale = (size * mass + damping) * size + stiffness;
        let condition = (roots == 1 && size != 0.0)
            .then(|| scale * squared(&shape) / (size * self.slope(value, &shape)));
        let backward_error = (squared(&rest) / squared(&shape)).sqrt() / scale;
        let pairs = shape[0].iter().zip(&shape[1]);
        let shape: Vec<Complex<f64>> = pairs.map(|(re, im)| Complex::new(*re, *im)).collect();
        let shape = normalised(&shape);
        Mode {
            eigenvalue: Eigenvalue {
                value,
                bound: error.map(|(whole, _)| whole),
                real_bound: error.map(|(_, real)| real),
            },
            repeats,
            roots,
            names: names.clone(),
            left_shape: Some(shape.iter().map(|entry| entry.conj()).collect()),
            left_shape_bound: None,
            shape,
            shape_bound: None,
            backward_error,
            condition: condition.filter(|condition| condition.is_finite()),
        }
    }

    /// |xᵀ(2λM + C)x|.
    fn slope(&self, value: Complex<f64>, [re, im]: &Parts) -> f64 {
        let form = |form: &Form| {
            let real = form.bilinear(re, re) - form.bilinear(im, im);
            Complex::new(real, 2.0 * form.bilinear(re, im))
        };
        (form(self.forms[0]) * value * 2.0 + form(self.forms[1])).norm()
    }
}
