//! Discs as doubles with bounds.

use eigentone_digits::DoubleDouble;
use num_complex::Complex;

use super::discs::Disc;
use super::pair::{Pair, Pairs, Parts, plain};
use crate::inclusion::bounded_shape::Shape;
use crate::inclusion::gram::UPWARD;
use crate::inclusion::shape::Shapes;
use crate::structure::Structure;

/// One root with Im ≥ 0, or several that are not separated.
#[derive(Clone, Debug)]
pub(crate) struct Paired {
    /// The modes that it comes from.
    pub(crate) members: Vec<usize>,
    pub(crate) value: Complex<f64>,
    pub(crate) bound: f64,
    pub(crate) real_bound: f64,
    /// x at a single root.
    pub(crate) shape: Option<Shape>,
    /// y there, where that does not follow from x by symmetry.
    pub(crate) left: Option<Shape>,
}

impl Pairs<'_> {
    /// The discs as doubles with bounds.
    pub(super) fn found(
        &self,
        structure: &Structure,
        discs: Vec<(Disc, Option<Shapes>)>,
    ) -> Option<Vec<Paired>> {
        let undamped = self.are_undamped(structure, discs.iter().map(|(disc, _)| disc));
        let mut found = Vec::new();
        for (disc, shapes) in discs {
            let real = self.pairs[disc.members[0]].is_real();
            if disc
                .members
                .iter()
                .any(|i| self.pairs[*i].is_real() != real)
            {
                return None;
            }
            let members: Option<Vec<usize>> =
                disc.members.iter().map(|i| self.pairs[*i].mode()).collect();
            let middle = disc.centres[disc.centres.len() / 2];
            let mut value = plain(middle);
            let on_axis = !real && disc.is_on_axis();
            if on_axis {
                value.re = 0.0;
            }
            if structure.is_passive() && value.re > 0.0 {
                return None;
            }
            let (mut bound, mut real_bound) = (0f64, 0f64);
            for (centre, radius) in disc.centres.iter().zip(&disc.radii) {
                let re = (centre.re - DoubleDouble::from(value.re)).to_f64().abs();
                let im = (centre.im - DoubleDouble::from(value.im)).to_f64().abs();
                bound = bound.max((re.hypot(im) + radius) * UPWARD);
                real_bound = real_bound.max((re + radius) * UPWARD);
            }
            if on_axis && (undamped || structure.is_gyroscopic()) {
                real_bound = 0.0;
            }
            let (shape, left) = match disc.members.as_slice() {
                [alone] => self.shapes(&self.pairs[*alone], shapes),
                _ => (None, None),
            };
            found.push(Paired {
                members: members?,
                value,
                bound: bound.max(f64::from_bits(1)),
                real_bound: if real_bound > 0.0 {
                    real_bound.max(f64::from_bits(1))
                } else {
                    0.0
                },
                shape,
                left,
            });
        }
        Some(found)
    }

    /// x and y as they are proved, or else as they are.
    fn shapes(&self, pair: &Pair, proven: Option<Shapes>) -> (Option<Shape>, Option<Shape>) {
        if let Some(Shapes { right, left }) = proven {
            return (Some(right.into()), left.map(Shape::from));
        }
        let entries = |parts: &Parts| (0..self.system.len()).map(|row| parts.at(row)).collect();
        let plain = |components: Vec<Complex<f64>>| Shape {
            components,
            bounds: None,
        };
        let conjugate = |z: Vec<Complex<f64>>| z.iter().map(Complex::conj).collect();
        let left = pair.left.as_ref();
        let left = left.map(|left| plain(conjugate(entries(left))));
        (Some(plain(entries(&pair.right))), left)
    }
}
