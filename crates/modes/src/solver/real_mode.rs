//! Undamped modes: a square of a frequency and a real shape each.

use eigentone_digits::DoubleDouble;
use num_complex::Complex;

use crate::quality::pencil::Quality;
use crate::quality::real_forms::{Entries, RealForms};
use crate::system::System;

/// An undamped mode.
#[derive(Clone, Debug)]
pub(crate) struct RealMode {
    /// ω², negative where the motion diverges.
    pub(crate) square: f64,
    /// Its largest entry is exactly 1, which keeps the forms of a single mass exact.
    pub(crate) shape: Vec<f64>,
    pub(crate) forms: RealForms,
    pub(crate) rigid: bool,
    /// How far ω may be off beyond its own rounding, relative.
    pub(crate) doubt: f64,
    /// Where products of whole matrices gave it.
    pub(crate) quality: Option<Quality>,
    /// Whether its forms are those of the shape before it was rounded.
    pub(crate) is_exact: bool,
}

impl RealMode {
    /// How far ω² may be off, relative: twice as far as ω, and by the rounding of a sum in doubles.
    pub(crate) fn square_error(&self) -> f64 {
        2.0 * self.doubt + 16.0 * f64::EPSILON
    }

    /// Whether a quotient of the shape's forms agrees with ω².
    pub(crate) fn is_confirmed_by(&self, quotient: DoubleDouble) -> bool {
        (quotient.to_f64() - self.square).abs() <= self.square_error() * self.square.abs()
    }

    pub(crate) fn complex_shape(&self) -> Vec<Complex<f64>> {
        self.shape.iter().map(|x| Complex::from(*x)).collect()
    }

    /// The shape of modal mass 1.
    pub(crate) fn mass_normalised(mut self) -> RealMode {
        let size = self.forms.m.to_f64().sqrt();
        self.shape.iter_mut().for_each(|x| *x /= size);
        self
    }
}

/// Shapes scaled so that their largest entries are exactly 1, with their forms.
pub(crate) fn unit_shapes(
    system: &System,
    mut shapes: Vec<Vec<f64>>,
    entries: Entries,
) -> impl Iterator<Item = (Vec<f64>, RealForms)> {
    scale_to_one(&mut shapes);
    let columns: Vec<&[f64]> = shapes.iter().map(Vec::as_slice).collect();
    let forms = RealForms::of(system, &columns, entries);
    shapes.into_iter().zip(forms)
}

/// Makes the largest entry of each shape exactly 1.
pub(super) fn scale_to_one(shapes: &mut [Vec<f64>]) {
    for shape in shapes {
        let larger = |a: f64, b: &f64| if b.abs() > a.abs() { *b } else { a };
        let pivot = shape.iter().fold(0.0, larger);
        shape.iter_mut().for_each(|x| *x /= pivot);
    }
}
