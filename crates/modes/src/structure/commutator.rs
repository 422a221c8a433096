//! Whether C M⁻¹ K − K M⁻¹ C takes some one vector to what doubles distinguish from 0, for a full M.
//!
//! With X near M⁻¹ and E = I − XM, M⁻¹r = (I − E)⁻¹Xr is no larger than ‖|X||r|‖/(1 − ‖E‖) in the maximum norm (Higham 2002,
//! *Accuracy and Stability of Numerical Algorithms*, §13.4): so much is an approximate solution z of Mz = Kq off, whose residual is r.

use eigentone_digits::{Cholesky, product, settle};
use faer::Mat;

use crate::exact::matrix::ExactMatrix;

/// A matrix rounded to doubles, and the sums of the sizes of its terms.
struct Rounded {
    value: Mat<f64>,
    size: Mat<f64>,
}

/// Whether the images of a vector differ. Not decided for an M that is not positive definite in doubles, and where numbers leave their
/// range.
pub(super) fn differs_visibly(m: &ExactMatrix, c: &ExactMatrix, k: &ExactMatrix) -> bool {
    let differ = images_differ(m, c, k);
    settle();
    differ.unwrap_or(false)
}

fn images_differ(m: &ExactMatrix, c: &ExactMatrix, k: &ExactMatrix) -> Option<bool> {
    /// Differences below the start are not decided, for products may underflow. An inverse beyond the end might overflow.
    const RANGE: std::ops::Range<f64> = 1e-100..1e50;
    let n = m.len();
    // Units of the coordinates in which all masses on the diagonal are alike; they change no entry from or to 0.
    let unit = |i: usize| {
        let own: f64 = m.entry(i, i).iter().sum();
        (-0.5 * own.log2()).round().exp2()
    };
    let units: Vec<f64> = (0..n).map(unit).collect();
    let mut most = 0;
    let mut rounded = |matrix: &ExactMatrix| {
        let mut value = Mat::<f64>::zeros(n, n);
        let mut size = Mat::<f64>::zeros(n, n);
        for i in 0..n {
            for (j, terms) in matrix.row(i) {
                most = most.max(terms.len());
                let unit = units[i] * units[j];
                value[(i, j)] = terms.iter().sum::<f64>() * unit;
                size[(i, j)] = terms.iter().map(|term| term.abs()).sum::<f64>() * unit;
            }
        }
        Rounded { value, size }
    };
    let [mass, mut damping, mut stiffness] = [m, c, k].map(&mut rounded);
    for matrix in [&mut damping, &mut stiffness] {
        let scale = (-matrix.size.norm_max().log2()).round().exp2();
        matrix.value *= scale;
        matrix.size *= scale;
    }
    // Sums of n products, of entries that are sums and were scaled.
    let rounding = 4.0 * (n + most + 8) as f64 * f64::EPSILON;
    let inverse = Cholesky::of(mass.value.as_ref())?.inverse();
    let inverse_size = Mat::from_fn(n, n, |i, j| inverse[(i, j)].abs());
    let norm = |vector: &Mat<f64>| vector.norm_max();
    let ones = Mat::<f64>::full(n, 1, 1.0);
    let off = product(inverse.as_ref(), mass.value.as_ref());
    let off = Mat::from_fn(n, n, |i, j| {
        (off[(i, j)] - f64::from(u8::from(i == j))).abs()
    });
    let norm_off = norm(&(off * &ones)) + rounding * norm(&(&inverse_size * (&mass.size * &ones)));
    if !(norm_off < 0.5 && RANGE.contains(&norm(&(&inverse_size * &ones)))) {
        return None;
    }
    // Numbers without a pattern, of one size.
    let entry = |i: usize| {
        let bits = (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let share = (bits >> 11) as f64 / (1u64 << 53) as f64;
        (0.5 + 0.5 * share) * if bits & 1 == 0 { 1.0 } else { -1.0 }
    };
    let vector = Mat::from_fn(n, 1, |i, _| entry(i));
    // M⁻¹Aq, and how far it is off at most.
    let solved = |matrix: &Rounded| {
        let right = &matrix.value * &vector;
        let found = &inverse * &right;
        let found_size = Mat::from_fn(n, 1, |i, _| found[(i, 0)].abs());
        let rest = &right - &mass.value * &found;
        let sizes = &matrix.size * &ones + &mass.size * &found_size;
        let rest = Mat::from_fn(n, 1, |i, _| rest[(i, 0)].abs() + rounding * sizes[(i, 0)]);
        let bound = 2.0 * norm(&(&inverse_size * rest)) / (1.0 - norm_off);
        (found, found_size, bound)
    };
    let [(z, z_size, z_off), (w, w_size, w_off)] = [&stiffness, &damping].map(solved);
    let apart = &damping.value * &z - &stiffness.value * &w;
    let sizes = &damping.size * &z_size + &stiffness.size * &w_size;
    let errors = (&damping.size * &ones) * z_off + (&stiffness.size * &ones) * w_off;
    let differs = |i: usize| {
        let bound = 2.0 * (errors[(i, 0)] + rounding * sizes[(i, 0)]);
        bound.is_finite() && apart[(i, 0)].abs() > bound.max(RANGE.start)
    };
    Some((0..n).any(differs))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::MatrixKind;
    use crate::random::Random;
    use crate::system::System;
    use faer::Mat;

    /// Full matrices, positive definite, from a fixed sequence, in units of the coordinates that lie far apart.
    fn definite(n: usize, seed: u64, far: f64) -> Mat<f64> {
        let mut random = Random(seed);
        let factor = Mat::from_fn(n, n, |_, _| 0.5 * random.signed());
        let square = &factor * factor.transpose();
        let unit = |i: usize| far.powi(i as i32 % 3).log2().round().exp2();
        Mat::from_fn(n, n, |i, j| {
            let (i, j) = (i.max(j), i.min(j));
            let own = if i == j { 1.0 } else { 0.0 };
            unit(i) * (square[(i, j)] + own) * unit(j)
        })
    }

    fn differs(m: &Mat<f64>, c: &Mat<f64>, k: &Mat<f64>) -> bool {
        let system = System::from_matrices(m.as_ref(), c.as_ref(), k.as_ref()).expect("a system");
        let [m, c, k] = [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness]
            .map(|kind| ExactMatrix::of(system.model(), kind));
        differs_visibly(&m, &c, &k)
    }

    #[test]
    fn full_matrices_differ_and_proportional_ones_do_not() {
        for n in [2, 3, 10, 40] {
            for far in [1.0, 1e6] {
                let (m, k) = (definite(n, 1, far), definite(n, 2, far));
                assert!(differs(&m, &definite(n, 3, far), &k), "{n}, {far}");
                // C = αM + βK rounded, and C = K M⁻¹ K rounded: what differs is rounding.
                let rayleigh = Mat::from_fn(n, n, |i, j| 0.3 * m[(i, j)] + 0.007 * k[(i, j)]);
                assert!(!differs(&m, &rayleigh, &k), "{n}, {far}");
                let caughey = &k * Cholesky::of(m.as_ref()).expect("definite").inverse() * &k;
                let caughey = Mat::from_fn(n, n, |i, j| caughey[(i.max(j), i.min(j))]);
                assert!(!differs(&m, &caughey, &k), "{n}, {far}");
                // A difference of a millionth shows.
                let mut off = rayleigh.clone();
                off[(0, 0)] *= 1.0 + 1e-6;
                assert!(differs(&m, &off, &k), "{n}, {far}");
            }
        }
    }
}
