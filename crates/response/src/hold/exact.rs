//! Exact holds: how state and load at the start of an interval give the state at its end.

use eigentone_digits::Lu;
use eigentone_modes::balance;
use faer::{Mat, MatRef, Scale};

use super::laws::Laws;
use crate::problem::reduced_angle;

/// z(h) = Φ z(0) + Γ₀ p + Γ₁ q·h + Σ (Γ_s s + Γ_c c) for z′ = A z + U u(t), where the input u is
/// p + q·t plus, for each frequency, the r values of a sine that stands at s and whose quarter
/// period ahead stands at c.
#[derive(Clone, Debug)]
pub(crate) struct Held {
    /// How many products of matrices it took.
    pub(crate) products: f64,
    pub(crate) phi: Mat<f64>,
    /// One N × r block for each of: constant, slope times h, then sine and cosine by frequency;
    /// what the laws leave out is missing.
    pub(crate) gamma: Vec<Mat<f64>>,
}

/// The exact hold over `h` seconds for z′ = A z + U u(t): one exponential of A bordered by the
/// generators of the input (Van Loan 1978, *IEEE Trans. Autom. Control* 23), exact also at
/// resonance, at critical damping and for singular A.
///
/// A is balanced first, time is counted in units of h, and every input column is scaled by a power
/// of two to norm ≤ 1, so that large inputs cost no squarings. Sinusoids much faster than A have a closed form.
pub(crate) fn exact(
    method: fn(MatRef<'_, f64>) -> (Mat<f64>, f64),
    a: MatRef<'_, f64>,
    u: MatRef<'_, f64>,
    h: f64,
    laws: &Laws,
) -> Held {
    let (n, r) = (a.nrows(), u.ncols());
    let balanced = balance(a);
    let rate = (0..n).map(|j| balanced.matrix.col(j).norm_l1());
    let rate = rate.fold(0.0, f64::max);
    let is_fast = |frequency: &f64| frequency.abs() > (2.0 * rate).max(h.recip());
    let (fast, slow): (Vec<f64>, Vec<f64>) = laws.frequencies.iter().partition(|f| is_fast(f));
    let blocks = laws.blocks() - 2 * fast.len();
    let size = n + r * blocks;
    let mut bordered = Mat::<f64>::zeros(size, size);
    for j in 0..n {
        for i in 0..n {
            bordered[(i, j)] = balanced.matrix[(i, j)] * h;
        }
    }
    let scales: Vec<f64> = (0..r)
        .map(|j| {
            let size = (0..n)
                .map(|i| (u[(i, j)] / balanced.scale[i] * h).abs())
                .fold(0.0, f64::max);
            let exponent = size.log2().ceil();
            if exponent.is_finite() {
                exponent.clamp(-1000.0, 1000.0).exp2()
            } else {
                1.0
            }
        })
        .collect();
    let mut enter = |block: usize| {
        for j in 0..r {
            for i in 0..n {
                bordered[(i, n + block * r + j)] = u[(i, j)] / balanced.scale[i] * h / scales[j];
            }
        }
    };
    let mut block = 0;
    if laws.straight {
        enter(0);
        block = 1;
    }
    let harmonic = block + usize::from(laws.sloped);
    for index in 0..slow.len() {
        enter(harmonic + 2 * index);
    }
    if laws.sloped {
        for j in 0..r {
            bordered[(n + j, n + r + j)] = 1.0;
        }
    }
    for (index, frequency) in slow.iter().enumerate() {
        let sine = n + (harmonic + 2 * index) * r;
        for j in 0..r {
            bordered[(sine + j, sine + r + j)] = frequency * h;
            bordered[(sine + r + j, sine + j)] = -frequency * h;
        }
    }
    let (result, products) = method(bordered.as_ref());
    let d = &balanced.scale;
    let held = |block: usize| {
        Mat::from_fn(n, r, |i, j| {
            d[i] * result[(i, n + block * r + j)] * scales[j]
        })
    };
    let mut gamma: Vec<Mat<f64>> = (0..harmonic).map(held).collect();
    let mut bordered = (harmonic..blocks).map(held);
    for frequency in &laws.frequencies {
        if is_fast(frequency) {
            let u = Mat::from_fn(n, r, |i, j| u[(i, j)] / d[i]);
            let power = result.submatrix(0, 0, n, n);
            let pair = fast_wave(balanced.matrix.as_ref(), power, u, h, *frequency);
            gamma.extend(pair.map(|part| Mat::from_fn(n, r, |i, j| d[i] * part[(i, j)])));
        } else {
            gamma.extend(bordered.by_ref().take(2));
        }
    }
    Held {
        products,
        phi: Mat::from_fn(n, n, |i, j| d[i] * result[(i, j)] / d[j]),
        gamma,
    }
}

/// What a sine and a cosine of a frequency Ω > 2‖A‖ add, given e^{Ah}. In an exponential they would cost as many digits as Ωh has;
/// but P sin + Q cos with Q = −Ω(A² + Ω²)⁻¹U and P = AQ/Ω solves the equation too, and z less it moves freely.
fn fast_wave(
    a: MatRef<'_, f64>,
    power: MatRef<'_, f64>,
    u: Mat<f64>,
    h: f64,
    frequency: f64,
) -> [Mat<f64>; 2] {
    let a = a * Scale(frequency.recip());
    let matrix = Mat::<f64>::identity(a.nrows(), a.ncols()) + &a * &a;
    let q = Lu::of(matrix.as_ref()).solve(u * Scale(-frequency.recip()));
    let p = &a * &q;
    let (s, c) = reduced_angle(frequency, h.into(), 0.0).sin_cos();
    [
        &p * Scale(c) - &q * Scale(s) - power * &p,
        &p * Scale(s) + &q * Scale(c) - power * &q,
    ]
}

/// sum += matrix · vector.
pub(crate) fn accumulate(matrix: &Mat<f64>, vector: &[f64], sum: &mut [f64]) {
    for (j, factor) in vector.iter().enumerate() {
        if *factor != 0.0 {
            for (entry, column) in sum.iter_mut().zip(matrix.col(j).iter()) {
                *entry += column * factor;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exponential::by_taylor;

    fn one_mass(a: [[f64; 2]; 2], h: f64, laws: &Laws) -> Held {
        let a = Mat::from_fn(2, 2, |i, j| a[i][j]);
        let u = Mat::from_fn(2, 1, |i, _| i as f64);
        exact(by_taylor, a.as_ref(), u.as_ref(), h, laws)
    }

    #[test]
    fn a_free_mass_falls_by_half_h_squared() {
        let laws = Laws {
            straight: true,
            sloped: true,
            frequencies: vec![],
        };
        let held = one_mass([[0.0, 1.0], [0.0, 0.0]], 0.3, &laws);
        assert!((held.gamma[0][(0, 0)] - 0.045).abs() < 1e-17);
        assert!((held.gamma[0][(1, 0)] - 0.3).abs() < 1e-16);
        assert!((held.gamma[1][(0, 0)] - 0.3 * 0.3 / 6.0).abs() < 1e-17);
    }

    #[test]
    fn resonance_grows_in_proportion_to_time() {
        // x″ + 4x = sin 2t from rest: x = (sin 2t − 2t cos 2t)/8.
        let laws = Laws {
            frequencies: vec![2.0],
            ..Laws::default()
        };
        let t = 3.0f64;
        let held = one_mass([[0.0, 1.0], [-4.0, 0.0]], t, &laws);
        let exact = ((2.0 * t).sin() - 2.0 * t * (2.0 * t).cos()) / 8.0;
        assert!((held.gamma[1][(0, 0)] - exact).abs() < 1e-15);
    }

    /// x″ + x = sin Ωt from rest: x = (sin Ωt − Ω sin t)/(1 − Ω²), and the same for cos Ωt: (cos t − cos Ωt)/(Ω² − 1).
    #[test]
    fn fast_sinusoids_lose_no_digits() {
        let h = 0.1f64;
        for frequency in [3.0, 30.0, 1e3, 1e6, 1e9] {
            let laws = Laws {
                frequencies: vec![0.5, frequency],
                ..Laws::default()
            };
            let held = one_mass([[0.0, 1.0], [-1.0, 0.0]], h, &laws);
            let (sine, cosine) = reduced_angle(frequency, h.into(), 0.0).sin_cos();
            let less = (1.0 - frequency) * (1.0 + frequency);
            let exact = [
                [
                    (sine - frequency * h.sin()) / less,
                    (cosine - h.cos()) / less,
                ],
                [
                    frequency * (cosine - h.cos()) / less,
                    (h.sin() - frequency * sine) / less,
                ],
            ];
            let unit = 8.0 * f64::EPSILON / frequency;
            for (row, exact) in exact.iter().enumerate() {
                for (column, exact) in exact.iter().enumerate() {
                    let off = (held.gamma[3 - column][(row, 0)] - exact).abs();
                    assert!(off <= unit, "{frequency:e}: {row} {column} {off:e}");
                }
            }
            assert!((held.phi[(0, 1)] - h.sin()).abs() < 2.0 * f64::EPSILON * h);
            // The slow one is where it was.
            let slow = (h.cos() - (0.5 * h).cos()) / -0.75;
            assert!((held.gamma[0][(0, 0)] - slow).abs() < 1e-16);
        }
    }

    #[test]
    fn a_step_on_a_frozen_dashpot_does_not_cancel() {
        // x″ + c x′ = 1: x = (ch − 1 + e^(−ch))/c².
        let laws = Laws {
            straight: true,
            ..Laws::default()
        };
        let (c, h) = (1e-3f64, 1e-2f64);
        let held = one_mass([[0.0, 1.0], [0.0, -c]], h, &laws);
        let y = c * h;
        let exact = h * h * (0.5 - y / 6.0 + y * y / 24.0 - y * y * y / 120.0);
        assert!((held.gamma[0][(0, 0)] / exact - 1.0).abs() < 1e-15);
    }
}
