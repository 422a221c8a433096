//! Overdamped systems: (xᵀCx)² > 4 (xᵀMx)(xᵀKx) for every x ≠ 0, so that nothing oscillates. With
//! M ≻ 0 and K ⪰ 0 this holds exactly if Q(−s) = s²M − sC + K is negative definite for some s > 0
//! (Guo, Higham & Tisseur 2009, "Detecting and solving hyperbolic quadratic eigenvalue problems",
//! *SIAM J. Matrix Anal. Appl.* 30). Then all 2n roots are
//! real, semisimple and not positive, n of them below −s and n above.
//!
//! For each x, s lies between the two roots of the scalar quadratic of xᵀMx, xᵀCx and xᵀKx. The
//! coordinates give the first such interval. A Cholesky factorisation of −Q(−s) that does not end
//! gives another x, and s itself is outside its interval, so that each trial halves what is left, as
//! it does for definite pairs (Crawford & Moon 1983, "Finding a positive definite linear combination
//! of two Hermitian matrices", *Lin. Alg. Appl.* 51).
//! The trials are made in doubles; the s that they find is a double, and −Q(−s) ≻ 0 is proved.

use super::coefficients::{Coefficient, Coefficients};
use super::semidefinite::is_definite;
use crate::exact::matrix::ExactMatrix;
use crate::exact::prime_field::MOST_WORK;
use crate::exact::sum::ExactSum;

/// More halvings than the exponents and the digits of doubles allow for.
const MOST_TRIALS: u64 = 100;

/// Whether M ≻ 0, K ⪰ 0 and Q(−s) ≺ 0 for some s > 0 are proved. C ≻ 0 follows.
pub(crate) fn is_overdamped(coefficients: &Coefficients) -> bool {
    let [mass, damping, stiffness] = coefficients.parts();
    let n = mass.matrix.len();
    let definite = |part: &Coefficient| part.semidefinite_rank() == Some(n);
    if !definite(mass) || !definite(damping) || stiffness.semidefinite_rank().is_none() {
        return false;
    }
    let parts = coefficients.parts().map(|part| &part.matrix);
    separating(parts)
        .is_some_and(|s| negated(parts, s).is_some_and(|negated| is_definite(&negated)))
}

/// −Q(−s) = sC − s²M − K.
fn negated([m, c, k]: [&ExactMatrix; 3], s: f64) -> Option<ExactMatrix> {
    let forces = c.times(s)?.plus(&m.times(s)?.times(-s)?);
    Some(forces.plus(&k.times(-1.0)?))
}

/// An s > 0 for which Q(−s) is negative definite as far as doubles show, or so nearly that they do
/// not. `None` if there is no such s as far as they show.
fn separating(parts: [&ExactMatrix; 3]) -> Option<f64> {
    let n = parts[0].len();
    let scale: Vec<i64> = (0..n)
        .map(|i| -ExactSum::of(parts[0].entry(i, i)).exponent().div_euclid(2))
        .collect();
    let entry = |part: &ExactMatrix, i: usize, j: usize| {
        ExactSum::of(part.entry(i, j))
            .round(scale[i] + scale[j])
            .high()
    };
    let mut interval = Interval {
        low: 0.0,
        high: f64::INFINITY,
    };
    for i in 0..n {
        interval = interval.cut(parts.map(|part| entry(part, i, i)))?;
    }
    const NARROW: f64 = 1e-12;
    let trials = (6 * MOST_WORK / (n as u64).pow(3)).min(MOST_TRIALS);
    if trials == 0 {
        return None;
    }
    let [m, c, k] = parts.map(|part| {
        (0..n)
            .map(|i| (0..=i).map(|j| entry(part, i, j)).collect())
            .collect::<Vec<Vec<f64>>>()
    });
    for _ in 0..trials {
        let s = interval.middle();
        let trial = (0..n).map(|i| {
            (0..=i)
                .map(|j| s * (c[i][j] - s * m[i][j]) - k[i][j])
                .collect()
        });
        let Some(x) = not_definite(trial.collect()) else {
            return Some(s);
        };
        interval = interval.cut([&m, &c, &k].map(|part| form(part, &x)))?;
        // x says that s does not separate, so s lies within rounding of an end.
        if interval.low < s && s < interval.high {
            if interval.high - interval.low <= NARROW * s {
                return Some(s);
            }
            if s - interval.low < interval.high - s {
                interval.low = s;
            } else {
                interval.high = s;
            }
        }
    }
    None
}

/// Where s must lie.
#[derive(Clone, Copy)]
struct Interval {
    low: f64,
    high: f64,
}

impl Interval {
    /// What is left between the roots of ms² − cs + k.
    fn cut(self, [m, c, k]: [f64; 3]) -> Option<Interval> {
        let root = (c * c - 4.0 * m * k).sqrt();
        let cut = Interval {
            low: self.low.max(2.0 * k / (c + root)),
            high: self.high.min((c + root) / (2.0 * m)),
        };
        (root > 0.0 && cut.low < cut.high).then_some(cut)
    }

    /// Near the middle, but not there: between round numbers that is often a root itself, where doubles do not decide.
    fn middle(self) -> f64 {
        const SHARE: f64 = 0.55;
        if self.low > 0.0 {
            self.low.powf(SHARE) * self.high.powf(1.0 - SHARE)
        } else {
            self.high * SHARE
        }
    }
}

/// An x with xᵀAx ≤ 0, from the pivot that ends the Cholesky factorisation of A, given by its lower
/// triangle; `None` if it does not end before its time.
fn not_definite(mut a: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    for i in 0..a.len() {
        let (above, rest) = a.split_at_mut(i);
        let row = &mut rest[0];
        for (j, other) in above.iter().enumerate() {
            row[j] = (row[j] - dot(&row[..j], other)) / other[j];
        }
        let pivot = row[i] - dot(&row[..i], &row[..i]);
        // A pivot that rounding alone may have made positive counts as none.
        if pivot > 4.0 * (i + 1) as f64 * f64::EPSILON * row[i].abs() {
            row[i] = pivot.sqrt();
            continue;
        }
        let mut x: Vec<f64> = row[..i].iter().map(|entry| -entry).collect();
        for j in (0..i).rev() {
            x[j] /= above[j][j];
            let (head, tail) = x.split_at_mut(j);
            for (value, factor) in head.iter_mut().zip(&above[j]) {
                *value -= factor * tail[0];
            }
        }
        x.push(1.0);
        return Some(x);
    }
    None
}

/// xᵀAx for a symmetric A given by its lower triangle; x may end early.
fn form(a: &[Vec<f64>], x: &[f64]) -> f64 {
    let row = |i: usize| -> f64 {
        let off: f64 = (0..i).map(|j| a[i][j] * x[j]).sum();
        x[i] * (2.0 * off + a[i][i] * x[i])
    };
    (0..x.len()).map(row).sum()
}

#[cfg(test)]
mod tests {
    use super::super::samples::{chain, matrices, network, triple_defect};
    use super::*;
    use crate::system::System;
    use faer::Mat;
    use proptest::prelude::*;

    fn overdamped(system: &System) -> bool {
        is_overdamped(&Coefficients::of(system.model()))
    }

    #[test]
    fn one_mass_about_critical_damping() {
        let one = |c: f64| overdamped(&chain(&[1.0], &[1.0], &[c]));
        assert!(!one(0.1) && !one(2.0_f64.next_down()) && !one(2.0));
        assert!(one(2.0_f64.next_up()) && one(2.5) && one(1e8) && one(1e150));
        assert!(overdamped(&chain(&[1e-200], &[1e-180], &[2.1e-190])));
        assert!(!overdamped(&chain(&[1e-200], &[1e-180], &[1.9e-190])));
    }

    #[test]
    fn each_mode_may_be_overdamped_while_the_system_is_not() {
        // Roots −1, −2 and −3, −4: no s lies between the pairs.
        let apart = network(
            &[1.0, 1.0],
            &[(0, 1, 2.0), (0, 2, 12.0)],
            &[(0, 1, 3.0), (0, 2, 7.0)],
        );
        assert!(!overdamped(&apart));
        let together = network(
            &[1.0, 1.0],
            &[(0, 1, 4.0), (0, 2, 6.0)],
            &[(0, 1, 5.0), (0, 2, 5.0)],
        );
        assert!(overdamped(&together));
    }

    #[test]
    fn chains_by_their_closed_form() {
        // ω² up to 4k/m; with c on every mass the mode at ω is overdamped if c > 2mω, and −c/2m
        // lies between every pair.
        for n in [2, 9, 60] {
            let top = 2.0 * (n as f64 * std::f64::consts::FRAC_PI_2 / (n + 1) as f64).sin();
            let chain = |c: f64| {
                let springs: Vec<_> = (0..=n).map(|i| (i, (i + 1) % (n + 1), 1.0)).collect();
                let dampers: Vec<_> = (1..=n).map(|i| (0, i, c)).collect();
                overdamped(&network(&vec![1.0; n], &springs, &dampers))
            };
            assert!(chain(2.0 * top * (1.0 + 1e-12)) && !chain(2.0 * top * (1.0 - 1e-12)));
        }
    }

    #[test]
    fn floating_on_dampers_that_hold_it() {
        let system = |c: f64| network(&[1.0, 1.0], &[(1, 2, 1.0)], &[(0, 1, c), (0, 2, c)]);
        assert!(overdamped(&system(3.0)) && !overdamped(&system(2.8)));
        let free = network(&[1.0, 1.0], &[(1, 2, 1.0)], &[(1, 2, 100.0)]);
        assert!(!overdamped(&free));
    }

    #[test]
    fn massless_nodes_are_not_answered() {
        assert!(!overdamped(&triple_defect()));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(500))]

        /// Planted: M = SᵀS, C = SᵀDS, K = SᵀES with the scalar roots −near and −far of each pair. An s
        /// that separates all of them is there if every near one is nearer than every far one.
        #[test]
        fn overdamped_exactly_if_one_s_separates_all_pairs(
            roots in prop::collection::vec((0i32..9, 1i32..9), 1..5),
            shapes in prop::collection::vec(-2i32..3, 16),
        ) {
            let n = roots.len();
            // Lower triangular with ones on its diagonal: never singular.
            let s = Mat::from_fn(n, n, |i, j| match i.cmp(&j) {
                std::cmp::Ordering::Greater => f64::from(shapes[4 * i + j]),
                std::cmp::Ordering::Equal => 1.0,
                std::cmp::Ordering::Less => 0.0,
            });
            let of = |value: &dyn Fn(f64, f64) -> f64| {
                let diagonal = Mat::from_fn(n, n, |i, j| {
                    let (near, step) = (f64::from(roots[i].0), f64::from(roots[i].1));
                    if i == j { value(near, near + step) } else { 0.0 }
                });
                s.transpose() * diagonal * &s
            };
            let system = matrices(of(&|_, _| 1.0), of(&|a, b| a + b), of(&|a, b| a * b));
            let nearest = roots.iter().map(|pair| pair.0).max();
            let farthest = roots.iter().map(|pair| pair.0 + pair.1).min();
            prop_assert_eq!(overdamped(&system), nearest < farthest);
        }
    }
}
