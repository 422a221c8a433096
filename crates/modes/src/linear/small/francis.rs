//! The QR algorithm with Francis's implicit double shift (Golub & Van Loan, *Matrix Computations*, §7.5), on rows
//! and columns of the active block alone.

use num_complex::Complex;

/// Steps for one eigenvalue after which the iteration is given up.
const PATIENCE: usize = 60;

/// All eigenvalues of `a` (n × n, column by column, upper Hessenberg), which is overwritten; `None` where
/// the iteration does not converge.
#[inline(always)]
pub(crate) fn francis(a: &mut [f64], n: usize, roots: &mut [Complex<f64>]) -> Option<()> {
    let at = |i: usize, j: usize| i + n * j;
    let norm = a.iter().fold(0.0, |top: f64, x| top.max(x.abs()));
    if !a.iter().all(|x| x.is_finite()) {
        return None;
    }
    // The active block ends before `end`.
    let mut end = n;
    let mut patience = 0;
    while end > 0 {
        let last = end - 1;
        let mut start = last;
        while start > 0 {
            let sum = a[at(start - 1, start - 1)].abs() + a[at(start, start)].abs();
            let size = if sum == 0.0 { norm } else { sum };
            if a[at(start, start - 1)].abs() <= f64::EPSILON * size {
                a[at(start, start - 1)] = 0.0;
                break;
            }
            start -= 1;
        }
        if start == last {
            roots[last] = Complex::from(a[at(last, last)]);
            (end, patience) = (last, 0);
            continue;
        }
        if start + 1 == last {
            let block = [
                a[at(start, start)],
                a[at(start, last)],
                a[at(last, start)],
                a[at(last, last)],
            ];
            [roots[start], roots[last]] = pair(block);
            (end, patience) = (start, 0);
            continue;
        }
        patience += 1;
        if patience > PATIENCE {
            return None;
        }
        // Trace and determinant of the shifts: of the last two rows, or once in a while others.
        let (trace, determinant) = if patience % 10 == 0 {
            let size = a[at(last, last - 1)].abs() + a[at(last - 1, last - 2)].abs();
            let shift = a[at(last, last)];
            (
                1.5 * size + 2.0 * shift,
                size * size + shift * (1.5 * size + shift),
            )
        } else {
            let (x, y) = (a[at(last, last)], a[at(last - 1, last - 1)]);
            let product = a[at(last, last - 1)] * a[at(last - 1, last)];
            (x + y, x * y - product)
        };
        sweep(a, n, start, last, trace, determinant);
    }
    Some(())
}

/// One implicit double step on rows and columns start … last.
#[inline(always)]
fn sweep(a: &mut [f64], n: usize, start: usize, last: usize, trace: f64, determinant: f64) {
    let at = |i: usize, j: usize| i + n * j;
    let s = start;
    let (h00, h10) = (a[at(s, s)], a[at(s + 1, s)]);
    let mut x = h00 * (h00 - trace) + determinant + a[at(s, s + 1)] * h10;
    let mut y = h10 * (h00 + a[at(s + 1, s + 1)] - trace);
    let mut z = h10 * a[at(s + 2, s + 1)];
    for k in start..last {
        let three = k + 2 <= last;
        if !three {
            z = 0.0;
        }
        let size = x.abs() + y.abs() + z.abs();
        if size > 0.0 {
            (x, y, z) = (x / size, y / size, z / size);
            let length = (x * x + y * y + z * z).sqrt().copysign(x);
            let (v0, v1, v2) = (x + length, y, z);
            let scale = 1.0 / (length * v0);
            let first = k.saturating_sub(1).max(start);
            let columns = a[n * first..n * (last + 1)].chunks_exact_mut(n);
            if three {
                for column in columns {
                    let column = &mut column[k..k + 3];
                    let sum = scale * (v0 * column[0] + v1 * column[1] + v2 * column[2]);
                    column[0] -= sum * v0;
                    column[1] -= sum * v1;
                    column[2] -= sum * v2;
                }
            } else {
                for column in columns {
                    let column = &mut column[k..k + 2];
                    let sum = scale * (v0 * column[0] + v1 * column[1]);
                    column[0] -= sum * v0;
                    column[1] -= sum * v1;
                }
            }
            let rows = start..(last.min(k + 3) + 1);
            let (one, rest) = a[n * k..].split_at_mut(n);
            let (two, rest) = rest.split_at_mut(n);
            let (one, two) = (&mut one[rows.clone()], &mut two[rows.clone()]);
            if three {
                for ((x, y), z) in one.iter_mut().zip(two).zip(&mut rest[rows]) {
                    let sum = scale * (v0 * *x + v1 * *y + v2 * *z);
                    *x -= sum * v0;
                    *y -= sum * v1;
                    *z -= sum * v2;
                }
            } else {
                for (x, y) in one.iter_mut().zip(two) {
                    let sum = scale * (v0 * *x + v1 * *y);
                    *x -= sum * v0;
                    *y -= sum * v1;
                }
            }
            if k > start {
                a[at(k + 1, k - 1)] = 0.0;
                if three {
                    a[at(k + 2, k - 1)] = 0.0;
                }
            }
        }
        x = a[at(k + 1, k)];
        y = if three { a[at(k + 2, k)] } else { 0.0 };
        z = if k + 3 <= last { a[at(k + 3, k)] } else { 0.0 };
    }
}

/// The eigenvalues of [a b; c d], without cancellation.
fn pair([a, b, c, d]: [f64; 4]) -> [Complex<f64>; 2] {
    let half = 0.5 * (a - d);
    let product = b * c;
    let discriminant = half * half + product;
    if discriminant < 0.0 {
        let root = Complex::new(0.5 * (a + d), (-discriminant).sqrt());
        return [root, root.conj()];
    }
    let far = half + discriminant.sqrt().copysign(half);
    let near = if far == 0.0 { 0.0 } else { product / far };
    [Complex::from(d + far), Complex::from(d - near)]
}

#[cfg(test)]
mod tests {
    use super::super::eigenvalues;
    use num_complex::Complex;
    use proptest::prelude::*;

    proptest! {
        /// Blocks [re im; −im re], mixed by an orthogonal similarity: a normal matrix, whose eigenvalues
        /// move no farther than its rounding.
        #[test]
        fn planted_roots_are_found(
            pairs in prop::collection::vec((-3.0..1.0f64, 0.1..5.0f64), 1..4),
            real in prop::collection::vec(-4.0..4.0f64, 0..3),
            turns in prop::collection::vec(0.0..6.0f64, 40),
        ) {
            let n = 2 * pairs.len() + real.len();
            let mut a = vec![0.0; n * n];
            let mut planted: Vec<Complex<f64>> = Vec::new();
            for (re, im) in pairs {
                let j = planted.len();
                (a[j + n * j], a[j + 1 + n * (j + 1)]) = (re, re);
                (a[j + 1 + n * j], a[j + n * (j + 1)]) = (-im, im);
                planted.extend([Complex::new(re, im), Complex::new(re, -im)]);
            }
            for re in real {
                let j = planted.len();
                a[j + n * j] = re;
                planted.push(Complex::from(re));
            }
            let mut turns = turns.into_iter();
            for p in 0..n {
                for q in p + 1..n {
                    let (sine, cosine): (f64, f64) = turns.next().unwrap_or(1.0f64).sin_cos();
                    for j in 0..n {
                        let (x, y) = (a[p + n * j], a[q + n * j]);
                        (a[p + n * j], a[q + n * j]) = (cosine * x - sine * y, sine * x + cosine * y);
                    }
                    for i in 0..n {
                        let (x, y) = (a[i + n * p], a[i + n * q]);
                        (a[i + n * p], a[i + n * q]) = (cosine * x - sine * y, sine * x + cosine * y);
                    }
                }
            }
            let mut found = vec![Complex::ZERO; n];
            prop_assert!(eigenvalues(&mut a, n, &mut found).is_some());
            for root in &planted {
                let off = found.iter().map(|other| (other - root).norm()).fold(f64::MAX, f64::min);
                prop_assert!(off < 1e-13, "{root} by {off:e}");
            }
        }
    }

    #[test]
    fn a_jordan_block_and_a_rotation_end() {
        let mut block = vec![2.0, 0.0, 0.0, 1.0, 2.0, 0.0, 0.0, 1.0, 2.0];
        let mut roots = [Complex::ZERO; 3];
        eigenvalues(&mut block, 3, &mut roots).unwrap();
        assert!(roots.iter().all(|root| *root == Complex::from(2.0)));
        // A cycle, which the ordinary shifts leave as it is.
        let mut cycle = vec![0.0; 16];
        for j in 0..4 {
            cycle[(j + 1) % 4 + 4 * j] = 1.0;
        }
        let mut roots = [Complex::ZERO; 4];
        eigenvalues(&mut cycle, 4, &mut roots).unwrap();
        for root in roots {
            assert!((root.powi(4) - 1.0).norm() < 1e-14);
        }
    }
}
