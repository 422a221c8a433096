//! Shapes, with bounds where they are proved.

use eigentone_digits::DoubleDouble;
use num_complex::Complex;

use super::shape::Enclosed;

/// A shape.
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
