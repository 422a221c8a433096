//! Whether the roots of an answer are together those of the system, as far as their estimates go.
//!
//! For every s that is no root, Σ 1/(s − λ_i) over all finite roots is (d/ds) ln det Q(s) = tr(Q(s)⁻¹Q′(s)) (Jacobi's formula), whatever
//! M, C and K. Seen from an s beyond all roots each counts about 1/s, so that one that is missing, invented or
//! listed twice shows; seen from the size of the smallest, those that are lost beside large ones show. The trace comes from one
//! inverse X of Q(s): with R = I − QX it is tr(XQ′) + tr(X(R + R² + …)Q′), and so off by at most
//!
//! tr(|X||R||Q′|)/(1 − ‖R‖)
//!
//! to first order, with norms of rows and columns in place of sums of sizes (Cauchy's inequality); those of the rows of R come from its
//! products with a few columns of signs, which take the place of one product of matrices. Rounding of sums of n terms is
//! taken for √n roundings of the sum of sizes. Where ‖R‖ is not below ½, that s decides nothing.

use eigentone_digits::{Cholesky, Lu, product};
use faer::{Mat, MatRef};

use crate::modes::Modes;
use crate::system::System;

/// Whether Σ 1/(s − λ) agrees with tr(Q(s)⁻¹Q′(s)) within what the bounds of all roots allow: beside the smallest roots, and with
/// dampers, where solvers may lose a root, beyond all.
pub(super) fn holds(system: &System, modes: &Modes) -> bool {
    let structure = system.structure();
    let sizes = modes.eigenvalues.iter().map(|root| root.value.norm());
    let sizes = sizes.filter(|size| *size > 0.0 && size.is_finite());
    let (least, most) = sizes.fold((f64::INFINITY, 0.0), |(least, most): (f64, f64), size| {
        (least.min(size), most.max(size))
    });
    // Coefficients whose products leave the doubles are not judged.
    const RANGE: std::ops::Range<f64> = 1e-60..1e60;
    if !RANGE.contains(&least) || !RANGE.contains(&most) {
        return true;
    }
    let matrices = [
        system.mass_matrix(),
        system.damping_matrix(),
        system.stiffness_matrix(),
    ];
    let beyond = 2.0 * most.log2().ceil().exp2();
    let beside = least.log2().floor().exp2();
    let far_side = |size: f64| {
        let distance = |s: &f64| {
            let each = modes.eigenvalues.iter();
            each.map(|root| (root.value - s).norm())
                .fold(f64::INFINITY, f64::min)
        };
        if distance(&size) >= distance(&-size) {
            size
        } else {
            -size
        }
    };
    let sizes = [Some(beside), (!structure.is_undamped()).then_some(beyond)];
    let mut sizes = sizes.into_iter().flatten();
    sizes.all(|size| agrees(&matrices, structure.is_symmetric(), modes, far_side(size)))
}

fn agrees(matrices: &[Mat<f64>; 3], symmetric: bool, modes: &Modes, s: f64) -> bool {
    const UNIT: f64 = f64::EPSILON;
    let Some((trace, error)) = trace(matrices, symmetric, s) else {
        return true;
    };
    let (mut sum, mut reach) = (0.0, error);
    for root in &modes.eigenvalues {
        let offset = s - root.value;
        let distance = offset.norm();
        // Conjugates are listed too: imaginary parts cancel.
        sum += offset.re / (distance * distance);
        // A root that is doubtful is of about its size.
        let bound = root.bound.unwrap_or(root.value.norm()) + UNIT * distance;
        let rest = distance - bound;
        if rest <= 0.0 {
            return true;
        }
        reach += bound / (distance * rest) + UNIT * modes.eigenvalues.len() as f64 / distance;
    }
    let apart = (sum - trace).abs();
    apart.is_nan() || apart <= reach
}

/// tr(Q(s)⁻¹Q′(s)) and how far it may be off; `None` where doubles do not decide.
fn trace(matrices: &[Mat<f64>; 3], symmetric: bool, s: f64) -> Option<(f64, f64)> {
    let [m, c, k] = matrices;
    let n = m.nrows();
    let columns = |j: usize| {
        let [m, c, k] = [m, c, k].map(|matrix| matrix.col_as_slice(j));
        m.iter().zip(c).zip(k).map(|((m, c), k)| [*m, *c, *k])
    };
    let size = |[m, c, k]: [f64; 3]| s * s * m.abs() + (s * c).abs() + k.abs();
    // In units in which every coordinate has about the same share, which change no trace.
    let mut most = vec![0.0f64; n];
    for j in 0..n {
        let mut own = most[j];
        for (most, entries) in most.iter_mut().zip(columns(j)) {
            let size = size(entries);
            *most = if size > *most { size } else { *most };
            own = if size > own { size } else { own };
        }
        most[j] = own;
    }
    let unit = |most: &f64| (-0.5 * most.log2()).round().exp2();
    let units: Vec<f64> = most.iter().map(unit).collect();
    let mut q = Mat::<f64>::zeros(n, n);
    // The squares of the norms of the rows of what adds up to them, by size.
    let (mut sizes, mut steepness) = (vec![0.0; n], vec![0.0; n]);
    for j in 0..n {
        let entries = q.col_as_slice_mut(j).iter_mut().zip(columns(j));
        let squares = sizes.iter_mut().zip(&mut steepness).zip(&units);
        for ((q, parts), ((square, steep), unit)) in entries.zip(squares) {
            let unit = unit * units[j];
            let [m, c, k] = parts;
            *q = unit * (s * s * m + s * c + k);
            *square += (unit * size(parts)).powi(2);
            *steep += (unit * (2.0 * (s * m).abs() + c.abs())).powi(2);
        }
    }
    let definite = symmetric.then(|| Cholesky::of(q.as_ref())).flatten();
    let inverse = match definite {
        Some(factor) => factor.inverse(),
        None => Lu::of(q.as_ref()).inverse(),
    };
    let norms = |squares: Vec<f64>| -> Vec<f64> { squares.into_iter().map(f64::sqrt).collect() };
    let (sizes, steepness) = (norms(sizes), norms(steepness));
    // (|A||X|)_ij is at most the norm of a row of A times that of a column of X.
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let norm = |entries: &[f64]| dot(entries, entries).sqrt();
    let columns_of_inverse = (0..n).map(|j| inverse.col_as_slice(j));
    let lengths: Vec<f64> = columns_of_inverse.map(norm).collect();
    let rest = rows_of_rest(q.as_ref(), inverse.as_ref());
    let rounding = 4.0 * f64::EPSILON * (n as f64).sqrt();
    let off = norm(&rest) + rounding * norm(&sizes) * norm(&lengths);
    let steep = dot(&steepness, &lengths);
    let pushed = dot(&lengths, &rest) * norm(&steepness) + rounding * dot(&lengths, &sizes) * steep;
    let error = pushed / (1.0 - off) + rounding * steep;
    // A symmetric inverse by columns, which lie one after the other.
    let inverse = if symmetric {
        inverse.as_ref()
    } else {
        inverse.transpose()
    };
    let own = |j: usize| {
        let slopes = columns(j).zip(&units);
        let slopes = slopes.map(|([m, c, _], unit)| unit * units[j] * (2.0 * s * m + c));
        let pairs = inverse.col(j).iter().zip(slopes);
        pairs.map(|(x, slope)| x * slope).sum::<f64>()
    };
    (off < 0.5 && error.is_finite()).then(|| ((0..n).map(own).sum(), error))
}

/// About the norms of the rows of R = I − QX, from its products with columns of signs: the mean of their squares is the square of
/// the norm.
fn rows_of_rest(q: MatRef<'_, f64>, inverse: MatRef<'_, f64>) -> Vec<f64> {
    const SAMPLES: usize = 8;
    let n = q.nrows();
    let signs = Mat::from_fn(n, SAMPLES, |i, j| {
        let bits = ((SAMPLES * i + j + 1) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        if bits.count_ones().is_multiple_of(2) {
            1.0
        } else {
            -1.0
        }
    });
    let rest = &signs - product(q, product(inverse, signs.as_ref()).as_ref());
    let squares = |i: usize| (0..SAMPLES).map(|j| rest[(i, j)].powi(2)).sum::<f64>();
    (0..n)
        .map(|i| (squares(i) / SAMPLES as f64).sqrt())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modes::{Precision, listed};
    use crate::random::Random;

    /// Full matrices with many sizes of entries, from a fixed sequence.
    fn system(n: usize, damped: bool) -> System {
        let mut random = Random(9);
        let mut definite = |own: f64| {
            let factor = Mat::from_fn(n, n, |_, _| 0.5 * random.signed());
            let mut product = factor.transpose() * &factor;
            (0..n).for_each(|i| product[(i, i)] += own * (1.0 + i as f64));
            product
        };
        let (m, c, k) = (definite(1.0), definite(0.1), definite(20.0));
        let c = if damped { c } else { Mat::zeros(n, n) };
        System::from_matrices(m.as_ref(), c.as_ref(), k.as_ref()).expect("a system")
    }

    #[test]
    fn faults_are_seen() {
        for (n, damped) in [(5, true), (40, true), (70, true), (70, false)] {
            let system = system(n, damped);
            let right = system.modes_to(Precision::Double).expect("modes");
            assert!(holds(&system, &right));
            let changed = |change: &dyn Fn(&mut Modes)| {
                let mut modes = right.clone();
                change(&mut modes);
                modes.eigenvalues = listed(&modes.modes);
                modes
            };
            let last = right.modes.len() - 1;
            for i in [0, last / 2, last] {
                let twice = changed(&|modes| {
                    let from = if i == 0 { 1 } else { i - 1 };
                    modes.modes[i].eigenvalue = modes.modes[from].eigenvalue;
                });
                assert!(
                    !holds(&system, &twice),
                    "{n}: {i} in place of its neighbour"
                );
                let off = changed(&|modes| modes.modes[i].eigenvalue.value *= 1.0 + 1e-6);
                assert!(!holds(&system, &off), "{n}: {i} off by a millionth");
                let missing = changed(&|modes| {
                    modes.modes.remove(i);
                });
                assert!(!holds(&system, &missing), "{n}: {i} missing");
                let doubtful = changed(&|modes| {
                    let root = &mut modes.modes[i].eigenvalue;
                    root.value *= 1.5;
                    (root.bound, root.real_bound) = (None, None);
                });
                assert!(holds(&system, &doubtful), "{n}: nothing is said of {i}");
            }
        }
    }
}
