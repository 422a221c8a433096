//! Vectors of a Hessenberg matrix by inverse iteration (Wilkinson 1965, *The Algebraic Eigenvalue Problem*, ch. 9,
//! §§53–55).

use num_complex::Complex;

/// Residuals that no further step makes smaller, and the most that the eigenvalues' own errors explain for each row.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
const MOST: f64 = 64.0 * f64::EPSILON;

/// H − λI and its triangular factors, row by row, real parts apart from imaginary ones.
pub(super) struct Shifted {
    n: usize,
    /// H row by row.
    rows: Vec<f64>,
    /// U, of which each row is used from its diagonal on.
    re: Vec<f64>,
    im: Vec<f64>,
    inverses: Vec<Complex<f64>>,
    /// What of each row, after an interchange where there is one, is taken off the next.
    steps: Vec<(Complex<f64>, bool)>,
    size: f64,
}

impl Shifted {
    /// Of an upper Hessenberg matrix, column by column.
    pub(super) fn of(h: &[f64], n: usize) -> Shifted {
        let rows: Vec<f64> = (0..n * n).map(|at| h[at / n + n * (at % n)]).collect();
        Shifted {
            n,
            size: rows
                .iter()
                .fold(0.0, |top: f64, entry| top.max(entry.abs())),
            re: vec![0.0; n * n],
            im: vec![0.0; n * n],
            inverses: vec![Complex::ZERO; n],
            steps: vec![(Complex::ZERO, false); n.saturating_sub(1)],
            rows,
        }
    }

    /// LU with interchanges of neighbouring rows; pivots that vanish are made small.
    pub(super) fn factor(&mut self, lambda: Complex<f64>) {
        let n = self.n;
        self.re.copy_from_slice(&self.rows);
        self.im.fill(0.0);
        for i in 0..n {
            self.re[i + n * i] -= lambda.re;
            self.im[i + n * i] = -lambda.im;
        }
        let tiny = f64::EPSILON * self.size.max(f64::MIN_POSITIVE);
        for k in 0..n {
            let mut pivot = Complex::new(self.re[k + n * k], self.im[k + n * k]);
            if k + 1 < n {
                let split = n * (k + 1);
                let (upper, lower) = self.re.split_at_mut(split);
                let (re, re_next) = (&mut upper[n * k + k..], &mut lower[k..n]);
                let (upper, lower) = self.im.split_at_mut(split);
                let (im, im_next) = (&mut upper[n * k + k..], &mut lower[k..n]);
                let below = Complex::new(re_next[0], im_next[0]);
                let swapped = below.norm_sqr() > pivot.norm_sqr();
                if swapped {
                    re.swap_with_slice(re_next);
                    im.swap_with_slice(im_next);
                }
                let (top, bottom) = if swapped {
                    (below, pivot)
                } else {
                    (pivot, below)
                };
                pivot = top;
                let factor = if top == Complex::ZERO {
                    top
                } else {
                    bottom / top
                };
                let entries = re.iter().zip(im).zip(re_next.iter_mut().zip(im_next));
                for ((re, im), (re_next, im_next)) in entries.skip(1) {
                    *re_next -= factor.re * *re - factor.im * *im;
                    *im_next -= factor.re * *im + factor.im * *re;
                }
                self.steps[k] = (factor, swapped);
            }
            if pivot.l1_norm() < tiny {
                pivot = Complex::from(tiny);
            }
            self.inverses[k] = pivot.inv();
        }
    }

    /// x with (H − λI)x ≈ 0; `None` where two steps leave a residual.
    pub(super) fn right(&self) -> Option<Vec<Complex<f64>>> {
        let mut x = vec![Complex::ONE; self.n];
        self.solve_upper(&mut x);
        if self.residual(unit(&mut x)?) <= ROUNDING {
            return Some(x);
        }
        for (k, (factor, swapped)) in self.steps.iter().enumerate() {
            if *swapped {
                x.swap(k, k + 1);
            }
            let head = x[k];
            x[k + 1] -= factor * head;
        }
        self.solve_upper(&mut x);
        let residual = self.residual(unit(&mut x)?);
        (residual <= MOST * self.n as f64).then_some(x)
    }

    /// w with w*(H − λI) ≈ 0; `None` where two steps leave a residual.
    pub(super) fn left(&self) -> Option<Vec<Complex<f64>>> {
        let mut w = vec![Complex::ONE; self.n];
        let mut residual = f64::INFINITY;
        for _ in 0..2 {
            self.solve_upper_adjoint(&mut w);
            for (k, (factor, swapped)) in self.steps.iter().enumerate().rev() {
                let tail = w[k + 1];
                w[k] -= factor.conj() * tail;
                if *swapped {
                    w.swap(k, k + 1);
                }
            }
            residual = self.residual(unit(&mut w)?);
            if residual <= ROUNDING {
                break;
            }
        }
        (residual <= MOST * self.n as f64).then_some(w)
    }

    /// The residual that a solution leaves whose largest component was so large, against the size of H.
    fn residual(&self, growth: f64) -> f64 {
        1.0 / (growth * self.size)
    }

    /// x ← U⁻¹x.
    fn solve_upper(&self, x: &mut [Complex<f64>]) {
        let n = self.n;
        for k in (0..n).rev() {
            let (head, rest) = x[k..].split_at_mut(1);
            let row = n * k + k + 1..n * (k + 1);
            head[0] = (head[0] - row_product(&self.re[row.clone()], &self.im[row], rest))
                * self.inverses[k];
        }
    }

    /// x ← U⁻*x.
    fn solve_upper_adjoint(&self, x: &mut [Complex<f64>]) {
        let n = self.n;
        for k in 0..n {
            let (head, rest) = x[k..].split_at_mut(1);
            let solved = head[0] * self.inverses[k].conj();
            head[0] = solved;
            let row = n * k + k + 1..n * (k + 1);
            for ((u, v), x) in self.re[row.clone()].iter().zip(&self.im[row]).zip(rest) {
                x.re -= u * solved.re + v * solved.im;
                x.im -= u * solved.im - v * solved.re;
            }
        }
    }
}

/// Σ (u + iv)·x, in sums that need not wait for each other.
fn row_product(u: &[f64], v: &[f64], x: &[Complex<f64>]) -> Complex<f64> {
    const LANES: usize = 2;
    let mut sums = [[0.0; LANES]; 4];
    let add = |sums: &mut [[f64; LANES]; 4], lane: usize, u: f64, v: f64, x: Complex<f64>| {
        sums[0][lane] += u * x.re;
        sums[1][lane] += v * x.im;
        sums[2][lane] += u * x.im;
        sums[3][lane] += v * x.re;
    };
    let chunks = u.chunks_exact(LANES).zip(v.chunks_exact(LANES));
    for ((u, v), x) in chunks.zip(x.chunks_exact(LANES)) {
        for lane in 0..LANES {
            add(&mut sums, lane, u[lane], v[lane], x[lane]);
        }
    }
    let whole = u.len() - u.len() % LANES;
    for at in whole..u.len() {
        add(&mut sums, 0, u[at], v[at], x[at]);
    }
    let [ux, vy, uy, vx] = sums.map(|sum| sum[0] + sum[1]);
    Complex::new(ux - vy, uy + vx)
}

/// Makes the largest component 1 and gives how large it was; `None` where a component is no number or all are 0.
fn unit(x: &mut [Complex<f64>]) -> Option<f64> {
    let largest = x.iter().map(Complex::norm_sqr).fold(0.0, f64::max).sqrt();
    // What is not a number, which no maximum shows, shows in a sum.
    let sum: f64 = x.iter().map(Complex::l1_norm).sum();
    if !(largest > 0.0 && largest.is_finite() && sum.is_finite()) {
        return None;
    }
    let inverse = 1.0 / largest;
    x.iter_mut().for_each(|entry| *entry *= inverse);
    Some(largest)
}
