//! det(λ²M + λC + K) modulo a prime: its value at a point, and its coefficients from enough of
//! them by Newton's interpolation.

use super::coefficients::Coefficients;
use crate::exact::elimination::{Echelon, Row, eliminate};
use crate::exact::matrix::Image;
use crate::exact::prime_field::{PrimeField, Residue};

/// M, C and K modulo a prime.
pub(crate) struct Reduced<'a> {
    field: &'a PrimeField,
    n: usize,
    /// K, C, M, by rising powers of λ.
    images: [Image<'a>; 3],
}

impl<'a> Reduced<'a> {
    pub(crate) fn new(coefficients: &'a Coefficients, field: &'a PrimeField) -> Reduced<'a> {
        let by_power = [
            &coefficients.stiffness,
            &coefficients.damping,
            &coefficients.mass,
        ];
        Reduced {
            field,
            n: coefficients.mass.matrix.len(),
            images: by_power.map(|coefficient| coefficient.matrix.image(field)),
        }
    }

    /// λ²M + λC + K, eliminated.
    pub(crate) fn at(&self, point: u64) -> Echelon {
        let point = self.field.integer(point);
        let powers = [
            self.field.integer(1),
            point,
            self.field.product(point, point),
        ];
        let mut parts = Vec::new();
        let rows = (0..self.n).map(|i| {
            parts.clear();
            for (image, &power) in self.images.iter().zip(&powers) {
                parts.extend(
                    image
                        .row(i)
                        .map(|(j, value)| (j, self.field.product(power, value))),
                );
            }
            Row::new(self.field, &parts)
        });
        eliminate(self.field, rows.collect())
    }

    /// The coefficients of the determinant by rising powers, given a bound on its degree.
    pub(crate) fn coefficients(&self, degree: usize) -> Vec<Residue> {
        let f = self.field;
        let points = 1..=degree as u64 + 1;
        let mut differences: Vec<Residue> =
            points.map(|point| self.at(point).determinant).collect();
        for order in 1..differences.len() {
            let inverse = f.inverse(f.integer(order as u64));
            for at in (order..differences.len()).rev() {
                let difference = f.difference(differences[at], differences[at - 1]);
                differences[at] = f.product(difference, inverse);
            }
        }
        let mut result = vec![Residue::ZERO; differences.len()];
        for at in (0..differences.len()).rev() {
            let point = f.integer(at as u64 + 1);
            for power in (0..result.len()).rev() {
                let below = if power == 0 {
                    differences[at]
                } else {
                    result[power - 1]
                };
                result[power] = f.difference(below, f.product(point, result[power]));
            }
        }
        result
    }
}
