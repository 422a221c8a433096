//! X(I + E) of approximate shapes X for a small E, and its forms, from those of X.
//!
//! With Y = X(I + E), S = XᵀAX = D + O and D its diagonal,
//!
//! YᵀAY = S + DE + EᵀD + P + Pᵀ + EᵀOE, P = (O + EᵀD/2)E.
//!
//! What is of the first order in E and O is summed in double-double. P is of the second, where doubles hold enough of it, and
//! EᵀOE of the third: a part of the bounds, as are the errors of S, and what X′, as it is kept, differs from Y.

use eigentone_digits::{DoubleDouble, Real, product, settle};
use faer::{Mat, MatRef};

use super::forms::{Basis, Forms};
use crate::inclusion::gram::{self, Form, Gram, UPWARD};
use crate::inclusion::sliced::{self, Rounding};

/// Half of the distance from 1 to the next double.
const UNIT: f64 = f64::EPSILON / 2.0;

impl Basis<'_> {
    /// X ← X(I + E) with E small, all by all and 0 in the columns of exact shapes, and the forms then: from those before where
    /// their errors grow little by it.
    pub(super) fn corrected(&mut self, forms: &Forms, change: &Mat<f64>) -> Option<Forms> {
        let off = self.correct(change);
        let elastic = self.elastic;
        let of_stiffness = change.as_ref().submatrix(0, 0, elastic, elastic);
        let corrected = |form: &Form<'_>, gram: &Gram, change, columns: &[Vec<DoubleDouble>]| {
            let near = form.corrected(gram, self.slices, change, &off);
            near.unwrap_or_else(|| form.gram_in(self.slices, columns))
        };
        let elastic = &self.columns[..elastic];
        let stiffness = corrected(&self.stiffness, &forms.stiffness, of_stiffness, elastic);
        let mass = corrected(&self.mass, &forms.mass, change.as_ref(), &self.columns);
        self.forms_of(stiffness, mass)
    }

    /// How far each entry of X′ may be from Y, column by column.
    ///
    /// XE = X₁E₁ + X₁E₂ + X₁E₃ + X₂E. As in [`sliced`], X₁ and E₁ are multiples of 2^{-β} of the largest entries of rows of X and of
    /// columns of E, E₂ those of 2^{-2β}, so that no sum of the first two products rounds.
    fn correct(&mut self, change: &Mat<f64>) -> Vec<Vec<f64>> {
        /// Powers of 2 above the largest entries, but for those near underflow.
        fn power(largest: f64) -> f64 {
            const LEAST: f64 = 1e-100;
            1.0.scale(largest.max(LEAST).magnitude().exponent())
        }
        let (n, all, elastic) = (self.columns[0].len(), self.columns.len(), self.elastic);
        let bits = sliced::bits(all);
        // The nearest multiple of 2^{-β} of a power.
        let cut = |x: f64, power: f64| {
            let step = 1.5 * 2f64.powi(52 - bits) * power;
            (x + step) - step
        };
        let mut rows = vec![0.0f64; n];
        for column in &self.columns {
            for (row, x) in rows.iter_mut().zip(column) {
                *row = row.max(x.high().abs());
            }
        }
        rows.iter_mut().for_each(|row| *row = power(*row));
        let change = change.as_ref().subcols(0, elastic);
        let mut slices = [0, 1].map(|_| Mat::<f64>::zeros(all, elastic));
        let mut sums = Vec::with_capacity(elastic);
        for (j, column) in change.col_iter().enumerate() {
            let power = power(column.norm_max());
            for (i, x) in column.iter().enumerate() {
                let first = cut(*x, power);
                slices[0][(i, j)] = first;
                slices[1][(i, j)] = cut(*x - first, power * 2f64.powi(-bits));
            }
            sums.push(column.iter().map(|x| x.abs()).sum::<f64>());
        }
        let third = change - &slices[0] - &slices[1];
        let first = Mat::from_fn(n, all, |i, j| cut(self.columns[j][i].high(), rows[i]));
        let second = Mat::from_fn(n, all, |i, j| {
            let x = self.columns[j][i];
            (x.high() - first[(i, j)]) + x.low()
        });
        let by_first = |change: &Mat<f64>| product(first.as_ref(), change.as_ref());
        let [exact, smaller] = slices.map(|slice| by_first(&slice));
        let rest = smaller + (by_first(&third) + product(second.as_ref(), change));
        settle();
        for (j, column) in self.columns[..elastic].iter_mut().enumerate() {
            let changes = exact.col_as_slice(j).iter().zip(rest.col_as_slice(j));
            for (entry, (exact, rest)) in column.iter_mut().zip(changes) {
                *entry += DoubleDouble::from(*exact) + *rest;
            }
        }
        let alone = (self.inert.count() > 0).then(|| self.columns[..elastic].to_vec());
        self.inert
            .follow(&self.stiffness, &mut self.columns[..elastic]);
        // X₂ is at most 2^{-β-1} of the powers, E₂ 2^{-β} of the largest entry, and E₃ far less: half of this is what their products
        // round, the other what the sum does.
        let unit = 2f64.powi(1 - bits) * UNIT * (all as f64 + 8.0);
        let bound = |j: usize| -> Vec<f64> {
            let each = self.columns[j].iter().zip(&rows).enumerate();
            let one = |(i, (x, row)): (usize, (&DoubleDouble, &f64))| {
                let follows = |alone: &Vec<Vec<DoubleDouble>>| (*x - alone[j][i]).to_f64().abs();
                let followed = alone.as_ref().map_or(0.0, follows);
                2f64.powi(-104) * x.to_f64().abs() + unit * sums[j] * row + followed
            };
            each.map(one).collect()
        };
        (0..elastic).map(bound).collect()
    }
}

impl Form<'_> {
    /// X′ᵀAX′ of a symmetric form, from that of X, where it was found in as many slices and its errors grow little.
    fn corrected(
        &self,
        before: &Gram,
        slices: usize,
        change: MatRef<'_, f64>,
        off: &[Vec<f64>],
    ) -> Option<Gram> {
        if before.slices < slices {
            return None;
        }
        let size = before.size;
        let diagonal: Vec<DoubleDouble> = (0..size).map(|i| before.at(i, i)).collect();
        // The transposes of O, which is symmetric, and of EᵀD/2.
        let rest = Mat::from_fn(size, size, |k, i| match i == k {
            true => 0.0,
            false => before.at(i, k).to_f64(),
        });
        let half = Mat::from_fn(size, size, |k, i| {
            0.5 * change[(k, i)] * diagonal[k].to_f64()
        });
        let second = product((&rest + &half).transpose(), change);
        settle();
        let (bounds, sizes) = self.bounds(before, &rest, &half, change, off);
        let mut errors = gram::errors(&bounds, 0.0, true);
        let mut entries = vec![DoubleDouble::ZERO; size * size];
        let [mirrored_change, mirrored_second] =
            [change, second.as_ref()].map(|matrix| matrix.transpose().to_owned());
        for i in 0..size {
            let (of_row, of_column) = (mirrored_change.col_as_slice(i), change.col(i));
            let seconds = (mirrored_second.col_as_slice(i), second.col_as_slice(i));
            for j in i..size {
                let at = i * size + j;
                let terms = [
                    before.entries[at],
                    diagonal[i] * of_row[j],
                    diagonal[j] * of_column[j],
                    DoubleDouble::from(seconds.0[j]) + seconds.1[j],
                ];
                let entry = terms[0] + terms[1] + terms[2] + terms[3];
                let sum: f64 = terms.iter().map(|term| term.to_f64().abs()).sum();
                let error = (before.errors[at] + errors[at] + 2f64.powi(-101) * sum) * UPWARD;
                for at in [at, j * size + i] {
                    (entries[at], errors[at]) = (entry, error);
                }
            }
        }
        before.near(entries, errors, sizes, || None)
    }

    /// How far X′ᵀAX′ may be off beside the errors of S and what double-doubles round, and the sizes of X′.
    fn bounds(
        &self,
        before: &Gram,
        rest: &Mat<f64>,
        half: &Mat<f64>,
        change: MatRef<'_, f64>,
        off: &[Vec<f64>],
    ) -> (Vec<Rounding>, Vec<f64>) {
        let size = before.size;
        // No |xᵀy| exceeds the largest entry of x times the sum of y.
        let largest = |values: &[f64]| values.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        let sum = |j: usize| change.col(j).iter().map(|x| x.abs()).sum::<f64>() * UPWARD;
        let of_change: Vec<f64> = (0..size).map(sum).collect();
        let rows = before.errors.chunks_exact(size.max(1));
        let of_errors: Vec<f64> = rows.map(largest).collect();
        let of_rest: Vec<f64> = (0..size).map(|i| largest(rest.col_as_slice(i))).collect();
        let third = 0.5 * (largest(&of_errors) + largest(&of_rest));
        let rounded = UNIT * (size as f64 + 8.0);
        // Of the errors of S, of P, and of the third order.
        let coupled = (0..size).map(|i| {
            let factors = of_rest[i] + largest(half.col_as_slice(i));
            of_errors[i] + rounded * factors + third * of_change[i]
        });
        let coupled: Vec<f64> = coupled.collect();
        let loads = self.loads();
        let kept = (0..size).map(|j| {
            let each = off.get(j).map_or([].iter(), |off| off.iter()).zip(&loads);
            let squares: f64 = each.map(|(off, load)| gram::square(*load, *off)).sum();
            squares.sqrt() * UPWARD
        });
        let kept: Vec<f64> = kept.collect();
        let sizes = (0..size).map(|j| {
            let each = before.sizes.iter().zip(change.col(j).iter());
            let added: f64 = each.map(|(size, x)| size * x.abs()).sum();
            (before.sizes[j] + added + kept[j]) * UPWARD
        });
        let sizes: Vec<f64> = sizes.collect();
        let of_forms = gram::both_ways(1.0, &coupled, &of_change);
        let of_columns = gram::both_ways(1.0, &kept, &sizes);
        let bounds = of_forms.into_iter().chain(of_columns).collect();
        (bounds, sizes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inclusion::congruence::squares::basis;
    use crate::model::MatrixKind;
    use crate::modes::Precision;
    use crate::system::System;
    use eigentone_digits::Wide;

    type Number = Wide<6>;

    /// Springs between neighbours, and a full matrix where there are many, which add without rounding; every so many coordinates
    /// have no mass.
    fn system(n: usize, without_mass: usize) -> System {
        let entry = |i: usize, j: usize| {
            let (i, j) = (i.min(j), i.max(j));
            ((i * i * 31 + j * 104_729 + i * j * 13) % 10_007) as f64 / 16_384.0 - 0.25
        };
        let matrix = Mat::from_fn(n, n, |i, j| {
            entry(i, j) + if i == j { n as f64 } else { 0.0 }
        });
        let names: Vec<String> = (0..n).map(|i| format!("q{i}")).collect();
        let mut builder = System::builder();
        for (i, name) in names.iter().enumerate() {
            let mass = match i % without_mass {
                0 => 0.0,
                _ => 1.0 + 0.01 * i as f64,
            };
            builder = builder
                .mass(name, mass)
                .spring("ground", name, 20.0 + i as f64);
            if i > 0 {
                builder = builder.spring(&names[i - 1], name, 1.0 + 0.25 * i as f64);
            }
        }
        if n > 20 {
            builder = builder.matrix(MatrixKind::Stiffness, matrix.as_ref());
        }
        builder.build().unwrap()
    }

    fn is_within(gram: &Gram, matrix: &Mat<f64>, columns: &[Vec<DoubleDouble>]) -> bool {
        let number = |x: DoubleDouble| Number::from(x.high()) + Number::from(x.low());
        let sum = |terms: &mut dyn Iterator<Item = Number>| {
            terms.fold(Number::from(0.0), |sum, term| sum + term)
        };
        let n = matrix.nrows();
        (0..gram.size).step_by(7).all(|j| {
            let force = |i: usize| {
                sum(&mut (0..n).map(|k| Number::from(matrix[(i, k)]) * number(columns[j][k])))
            };
            let forces: Vec<Number> = (0..n).map(force).collect();
            (0..gram.size).all(|i| {
                let each = columns[i].iter().zip(&forces);
                let truth = sum(&mut each.map(|(x, force)| number(*x) * *force));
                let off = (truth - number(gram.at(i, j))).abs().to_f64();
                off <= gram.error(i, j)
            })
        })
    }

    #[test]
    fn forms_of_corrected_shapes_are_within_their_bounds() {
        for (n, without_mass) in [(12, 50), (50, 100), (70, 100), (70, 20)] {
            let system = system(n, without_mass);
            let modes = system.modes_to(Precision::Double).unwrap();
            let shape = |shape: &[num_complex::Complex<f64>]| shape.iter().map(|x| x.re).collect();
            let shapes = modes.as_slice().iter().map(|mode| shape(mode.shape()));
            let mut basis = basis(&system, shapes.collect()).unwrap();
            let forms = basis.forms().unwrap();
            let (next, _) = basis.advanced(&forms).unwrap();
            assert!(next.spread < 1e-6 * forms.spread);
            let elastic = &basis.columns[..basis.elastic];
            assert!(is_within(
                &next.stiffness,
                &system.stiffness_matrix(),
                elastic
            ));
            assert!(is_within(&next.mass, &system.mass_matrix(), &basis.columns));
            let growth = next.stiffness.growth.max(next.mass.growth);
            assert!(growth > 1.0, "{n}, {without_mass}: found anew");
        }
    }
}
