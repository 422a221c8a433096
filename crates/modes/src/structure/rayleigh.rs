//! Rayleigh damping: C = αM + βK for two numbers α and β (Lord Rayleigh 1877, *The Theory of
//! Sound*). Each undamped shape then keeps its frequency's own damping, γ = α + βω².

use std::cmp::Ordering;

use eigentone_digits::DoubleDouble;

use super::classical::is_rayleigh;
use crate::exact::matrix::ExactMatrix;
use crate::exact::sum::ExactSum;

/// α and β, each within 2^-98 of itself; 0 exactly where it is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Proportion {
    pub(crate) of_mass: DoubleDouble,
    pub(crate) of_stiffness: DoubleDouble,
}

impl Proportion {
    /// Of no damping.
    pub(crate) const NONE: Proportion = Proportion {
        of_mass: DoubleDouble::ZERO,
        of_stiffness: DoubleDouble::ZERO,
    };
}

/// The proportion of M, C and K, where C is one and M and K are not multiples of each other; `None` as well
/// where a product of entries leaves the doubles.
pub(crate) fn proportion(matrices: [&ExactMatrix; 3]) -> Option<Proportion> {
    if !is_rayleigh(matrices) {
        return None;
    }
    // All entries, as vectors (m, c, k), lie in one plane. Two that differ in direction span it.
    let mut first: Option<[&[f64]; 3]> = None;
    for i in 0..matrices[0].len() {
        for matrix in matrices {
            for (j, _) in matrix.row(i) {
                let entry = matrices.map(|matrix| matrix.entry(i, j));
                let Some(first) = first else {
                    let vanishes = entry
                        .iter()
                        .all(|terms| ExactSum::of(terms).sign() == Ordering::Equal);
                    first = (!vanishes).then_some(entry);
                    continue;
                };
                let cross = [(1, 2), (2, 0), (0, 1)]
                    .map(|(a, b)| difference([first[a], entry[b]], [first[b], entry[a]]));
                let [Some(m), Some(c), Some(k)] = cross else {
                    return None;
                };
                let vanishes = |sum: &ExactSum| sum.sign() == Ordering::Equal;
                if [&m, &c, &k].into_iter().all(vanishes) {
                    continue;
                }
                // m·M + c·C + k·K = 0.
                if vanishes(&c) {
                    return None;
                }
                let power = -c.exponent();
                let share = |sum: &ExactSum| {
                    let ratio = -(sum.round(power) / c.round(power));
                    let size = ratio.to_f64().abs();
                    (vanishes(sum) || (1e-250..1e250).contains(&size)).then_some(ratio)
                };
                return Some(Proportion {
                    of_mass: share(&m)?,
                    of_stiffness: share(&k)?,
                });
            }
        }
    }
    None
}

/// a·b − c·d of exact sums; `None` where a product is not exact in two doubles.
fn difference([a, b]: [&[f64]; 2], [c, d]: [&[f64]; 2]) -> Option<ExactSum> {
    let mut sum = ExactSum::new();
    for (left, right, sign) in [(a, b, 1.0), (c, d, -1.0)] {
        for x in left {
            for y in right {
                let product = DoubleDouble::product(*x, *y);
                let size = product.high().abs();
                if *x != 0.0 && *y != 0.0 && !(1e-280..1e280).contains(&size) {
                    return None;
                }
                sum.add(sign * product.high());
                sum.add(sign * product.low());
            }
        }
    }
    Some(sum)
}

#[cfg(test)]
mod tests {
    use super::super::samples::{almost_classical, chain};
    use super::*;
    use crate::structure::coefficients::Coefficients;
    use crate::system::System;

    fn found(system: &System) -> Option<(f64, f64)> {
        let coefficients = Coefficients::of(system.model());
        let found = proportion(coefficients.parts().map(|part| &part.matrix))?;
        Some((found.of_mass.to_f64(), found.of_stiffness.to_f64()))
    }

    #[test]
    fn dampers_in_proportion_to_springs() {
        let system = chain(
            &[10.0, 20.0, 30.0],
            &[1e5, 2e5, 3e5, 4e5],
            &[50.0, 100.0, 150.0, 200.0],
        );
        assert_eq!(found(&system), Some((0.0, 5e-4)));
    }

    #[test]
    fn both_at_once() {
        // C = 3M + K/8 for a mass matrix and springs that share no pattern.
        let n = 4;
        let system = (0..n).fold(System::builder(), |builder, i| {
            builder.mass(format!("m{i}"), f64::from(i + 1))
        });
        let system = (0..n).fold(system, |builder, i| {
            let (from, to) = (crate::GROUND, format!("m{i}"));
            builder.damper(from, to, 3.0 * f64::from(i + 1))
        });
        let system = (1..n).fold(system, |builder, i| {
            let (from, to) = (format!("m{}", i - 1), format!("m{i}"));
            builder
                .spring(from.clone(), to.clone(), 0.1 * f64::from(i))
                .damper(from, to, 0.1 * f64::from(i) / 8.0)
        });
        assert_eq!(found(&system.build().unwrap()), Some((3.0, 0.125)));
    }

    #[test]
    fn where_there_is_none() {
        assert_eq!(found(&almost_classical()), None);
        // M and K are multiples of each other: any C is classical, none distinguishes α from β.
        assert_eq!(found(&chain(&[1.0], &[1.0], &[3.0])), None);
        assert_eq!(
            found(&chain(&[1e-200; 2], &[1e-200; 3], &[1e-200; 3])),
            None
        );
    }
}
