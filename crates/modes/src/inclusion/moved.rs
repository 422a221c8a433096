//! XᵀAX of columns that have moved little, from that before.
//!
//! With X′ = X + D and G = AX + AD/2, for symmetric A, X′ᵀAX′ = XᵀAX + GᵀD + DᵀG. The first term is known to many digits; the
//! others are as small beside it as D is beside X, and one slice shows what is seen of them; doubles hold enough of AD.

use eigentone_digits::{DoubleDouble, product};
use faer::Mat;

use super::gram::{self, Form, Gram, Kept, LITTLE, UPWARD};
use super::sliced::{self, Rounding};

impl Form<'_> {
    /// X′ᵀAX′ of a symmetric form in so many slices, from that of as many columns X near to X′ where its errors grow little by it,
    /// or anew.
    pub(super) fn gram_near(
        &self,
        before: Option<&Gram>,
        slices: usize,
        columns: &[Vec<DoubleDouble>],
    ) -> Gram {
        let moved = before.and_then(|before| self.moved(before, slices, columns));
        moved.unwrap_or_else(|| self.gram_in(slices, columns))
    }

    fn moved(&self, before: &Gram, slices: usize, columns: &[Vec<DoubleDouble>]) -> Option<Gram> {
        let kept = before.kept.as_ref().filter(|_| before.slices >= slices)?;
        let size = columns.len();
        let pairs = columns.iter().zip(&kept.columns);
        let change = pairs.map(|(x, old)| x.iter().zip(old).map(|(x, old)| *x - *old).collect());
        let change: Vec<Vec<DoubleDouble>> = change.collect();
        let weights = &kept.weights;
        // Σ|d_ri||A_rs||x_sj| is no more than the product of these sizes of d_i and x_j.
        let size_of = |columns: &[Vec<DoubleDouble>]| -> Vec<f64> {
            let each = columns.iter();
            each.map(|x| weights.over_rows(x).sqrt() * UPWARD).collect()
        };
        let (of_change, of_columns) = (size_of(&change), size_of(&kept.columns));
        // A and D round, and sums of n products.
        let pull_unit = (self.n as f64 + 8.0) * 2f64.powi(-53);
        let is_near = |slices: &usize| {
            let slice = sliced::unit(*slices, self.n);
            (0..size).all(|j| {
                let added = of_change[j] * (slice * of_columns[j] + pull_unit * of_change[j]);
                added <= LITTLE * before.error(j, j)
            })
        };
        let slices_of_change = (0..=1).find(is_near)?;
        let rounded = Mat::from_fn(self.n, size, |i, j| change[j][i].to_f64());
        let pull = product(self.matrix?, rounded.as_ref());
        let pulled = |by: f64| -> Vec<Vec<DoubleDouble>> {
            let each = kept.forces.iter().enumerate().map(|(j, forces)| {
                let both = forces.iter().zip(pull.col(j).iter());
                both.map(|(force, pull)| *force + by * pull).collect()
            });
            each.collect()
        };
        let (shares, products) = sliced::products(&pulled(0.5), &change, slices_of_change, false)?;
        let moved = kept.moved.iter().zip(&of_change);
        let moved: Vec<f64> = moved.map(|(before, now)| before + now).collect();
        let felt = kept.of_forces.as_ref().map(|rounding| {
            let felt = change.iter().map(|d| rounding.felt(d) * UPWARD);
            let felt: Vec<f64> = felt.collect();
            (rounding.unit, &rounding.second, felt)
        });
        // Of GᵀD; of D and of AX, beside slices; of AD; and of AX in slices.
        let unit = weights.unit(felt.is_some()) + 2f64.powi(-102);
        let mut bounds = vec![
            (products.unit, &products.first, &products.second),
            (unit, &of_columns, &of_change),
            (pull_unit, &moved, &of_change),
        ];
        bounds.extend(felt.iter().map(|(unit, first, felt)| (*unit, *first, felt)));
        let both_ways = bounds.into_iter();
        let both_ways =
            both_ways.flat_map(|(unit, first, second)| gram::both_ways(unit, first, second));
        let both_ways: Vec<Rounding> = both_ways.collect();
        let mut errors = gram::errors(&both_ways, 0.0, true);
        let mut entries = vec![DoubleDouble::ZERO; size * size];
        for i in 0..size {
            for j in i..size {
                let (at, mirrored) = (i * size + j, j * size + i);
                let terms = [before.entries[at], shares[at], shares[mirrored]];
                let entry = terms[0] + terms[1] + terms[2];
                let size: f64 = terms.iter().map(|term| term.to_f64().abs()).sum();
                let rounded = 2f64.powi(-102) * size;
                let error = (before.errors[at] + errors[at] + rounded) * UPWARD;
                for at in [at, mirrored] {
                    (entries[at], errors[at]) = (entry, error);
                }
            }
        }
        let both = before.sizes.iter().zip(&of_change);
        let sizes = both.map(|(size, change)| size + change).collect();
        before.near(entries, errors, sizes, || {
            Some(Kept {
                columns: columns.to_vec(),
                forces: pulled(1.0),
                of_forces: kept.of_forces.clone(),
                weights: weights.clone(),
                moved,
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inclusion::gram::SLICES;
    use crate::model::MatrixKind;
    use crate::system::System;
    use eigentone_digits::{Real, Wide};

    type Number = Wide<6>;

    const N: usize = 50;

    fn number(x: DoubleDouble) -> Number {
        Number::from(x.high()) + Number::from(x.low())
    }

    /// Numbers in [−½, ½] without a pattern.
    fn entry(seed: usize, i: usize, j: usize) -> f64 {
        let of =
            |i: usize, j: usize| (i * i * 31 + j * 104_729 + i * j * 13 + seed * 7919) % 10_007;
        of(i, j) as f64 / 10_007.0 - 0.5
    }

    #[test]
    fn forms_of_moved_columns_are_within_their_bounds() {
        // Rows in units that differ, as of rotations beside translations.
        let unit = |i: usize| 2f64.powi(10 * (i % 3) as i32);
        let matrix = Mat::from_fn(N, N, |i, j| {
            entry(1, i.max(j), i.min(j)) * unit(i) * unit(j)
        });
        let names = (0..N).fold(System::builder(), |builder, i| {
            builder.mass(format!("q{i}"), 1.0)
        });
        let system = names
            .matrix(MatrixKind::Stiffness, matrix.as_ref())
            .build()
            .unwrap();
        let form = Form::stiffness(&system);
        let columns = |steps: &[f64]| -> Vec<Vec<DoubleDouble>> {
            let x = |i: usize, j: usize| {
                let steps = steps.iter().enumerate();
                let moved = steps.map(|(k, step)| DoubleDouble::from(step * entry(3 + k, i, j)));
                let first = DoubleDouble::new(entry(2, i, j), 1e-18 * entry(9, i, j));
                moved
                    .fold(first, |sum, step| sum + step)
                    .scale(-10 * (i % 3) as i64)
            };
            (0..N).map(|j| (0..N).map(|i| x(i, j)).collect()).collect()
        };
        let is_within = |gram: &Gram, columns: &[Vec<DoubleDouble>]| {
            let force = |j: usize, i: usize| {
                let each = (0..N).map(|k| Number::from(matrix[(i, k)]) * number(columns[j][k]));
                each.fold(Number::from(0.0), |sum, term| sum + term)
            };
            (0..N).step_by(7).all(|j| {
                let forces: Vec<Number> = (0..N).map(|i| force(j, i)).collect();
                (0..N).all(|i| {
                    let each = columns[i].iter().zip(&forces);
                    let true_entry =
                        each.fold(Number::from(0.0), |sum, (x, f)| sum + number(*x) * *f);
                    let off = (true_entry - number(gram.at(i, j))).abs().to_f64();
                    off <= gram.error(i, j)
                })
            })
        };
        let steps = [1e-12, 1e-15, 1e-20];
        let mut gram = form.gram_near(None, SLICES, &columns(&[]));
        assert!(is_within(&gram, &columns(&[])));
        for last in 1..=steps.len() {
            let moved = columns(&steps[..last]);
            gram = form.gram_near(Some(&gram), SLICES, &moved);
            assert!(gram.growth > 1.0, "found anew");
            assert!(is_within(&gram, &moved));
        }
        // So far away anew.
        let far = columns(&[1e-3]);
        gram = form.gram_near(Some(&gram), SLICES, &far);
        assert_eq!(gram.growth, 1.0);
        assert!(is_within(&gram, &far));
    }
}
