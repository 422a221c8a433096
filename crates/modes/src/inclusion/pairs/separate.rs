//! Columns that corrections do not separate, made eigenvectors within their span.

use eigentone_digits::{ComplexDoubleDouble, DoubleDouble};
use faer::{Mat, c64};

use super::pair::{Pair, Pairs, plain};
use super::rows::Rows;

impl Pairs<'_> {
    /// Replaces columns that are mixed with each other by the eigenvectors of the pencil in their
    /// span: made orthogonal by B, then turned by complex rotations (Jacobi's) until A couples none.
    /// `None` where that fails, as at defective roots, and where left shapes are not those on the right.
    pub(super) fn separate(&mut self, rows: &Rows, group: &[usize]) -> Option<()> {
        const SWEEPS: usize = 40;
        let k = group.len();
        let centre = rows.rho[group[0]];
        let real = self.pairs[group[0]].is_real();
        let alike = |i: &usize| self.pairs[*i].is_real() == real && self.pairs[*i].mode().is_some();
        if self.has_left() || !group.iter().all(alike) {
            return None;
        }
        let entries = |part: &dyn Fn(usize, usize) -> c64| {
            Mat::<c64>::from_fn(k, k, |p, q| part(group[p.min(q)], group[p.max(q)]))
        };
        // So that real columns stay real.
        let sign = if real && rows.b(group[0], group[0]).re < 0.0 {
            -1.0
        } else {
            1.0
        };
        let b = entries(&|i, j| rows.b(i, j) * sign);
        // A less a multiple of B, which leaves what separates the roots.
        let coupling = |i, j| rows.h(i, j) + plain(rows.rho[i] - centre) * rows.b(i, j);
        let mut a = entries(&|i, j| coupling(i, j) * sign);
        let mut turned = Mat::<c64>::zeros(k, k);
        let form = |x: &[c64], y: &[c64]| {
            let row = |p: usize| (0..k).map(|q| b[(p, q)] * y[q]).sum::<c64>() * x[p];
            (0..k).map(row).sum::<c64>()
        };
        let mut basis: Vec<Vec<c64>> = Vec::with_capacity(k);
        for p in 0..k {
            let mut vector: Vec<c64> = (0..k).map(|q| c64::from(f64::from(p == q))).collect();
            for _ in 0..2 {
                for other in &basis {
                    let share = form(other, &vector);
                    vector
                        .iter_mut()
                        .zip(other)
                        .for_each(|(x, y)| *x -= share * y);
                }
            }
            let size = form(&vector, &vector).sqrt();
            if size.norm() <= 1e-6 * b[(p, p)].norm().sqrt() || !size.is_finite() {
                return None;
            }
            vector.iter_mut().for_each(|x| *x /= size);
            basis.push(vector);
        }
        for (q, vector) in basis.iter().enumerate() {
            (0..k).for_each(|p| turned[(p, q)] = vector[p]);
        }
        a = turned.transpose() * a * &turned;
        for _ in 0..SWEEPS {
            let mut again = false;
            for (p, q) in (1..k).flat_map(|q| (0..q).map(move |p| (p, q))) {
                let off = a[(p, q)];
                let gap = a[(q, q)] - a[(p, p)];
                if off.norm() <= 1e-17 * (gap.norm() + off.norm()) {
                    continue;
                }
                again = true;
                let zeta = gap / (off * 2.0);
                let root = (zeta * zeta + 1.0).sqrt();
                let (plus, minus) = (zeta + root, zeta - root);
                let larger = if plus.norm_sqr() > minus.norm_sqr() {
                    plus
                } else {
                    minus
                };
                let t = larger.inv();
                let cosine = (t * t + 1.0).sqrt().inv();
                let sine = cosine * t;
                if !sine.is_finite() || sine.norm() > 1e3 {
                    return None;
                }
                let turn = |x: c64, y: c64| (cosine * x - sine * y, sine * x + cosine * y);
                for i in 0..k {
                    (a[(i, p)], a[(i, q)]) = turn(a[(i, p)], a[(i, q)]);
                    (turned[(i, p)], turned[(i, q)]) = turn(turned[(i, p)], turned[(i, q)]);
                }
                for i in 0..k {
                    (a[(p, i)], a[(q, i)]) = turn(a[(p, i)], a[(q, i)]);
                }
            }
            if !again {
                break;
            }
        }
        let largest = turned.norm_max();
        let real_shares = (0..k).all(|q| (0..k).all(|p| turned[(p, q)].im == 0.0));
        if !largest.is_finite() || real && !real_shares {
            return None;
        }
        let before: Vec<Pair> = group.iter().map(|i| self.pairs[*i].clone()).collect();
        for (q, i) in group.iter().enumerate() {
            let pair = &mut self.pairs[*i];
            let shift = a[(q, q)];
            pair.value = centre + ComplexDoubleDouble::new(shift.re, shift.im);
            let share = |p: usize| turned[(p, q)];
            for (row, entry) in pair.right.re.iter_mut().enumerate() {
                *entry = DoubleDouble::ZERO;
                for (p, other) in before.iter().enumerate() {
                    *entry += other.right.re[row] * share(p).re;
                    if !real {
                        *entry -= other.right.im[row] * share(p).im;
                    }
                }
            }
            for (row, entry) in pair.right.im.iter_mut().enumerate() {
                *entry = DoubleDouble::ZERO;
                for (p, other) in before.iter().enumerate() {
                    *entry += other.right.re[row] * share(p).im + other.right.im[row] * share(p).re;
                }
            }
        }
        Some(())
    }
}

impl Rows {
    /// h_ij b_ii.
    fn h(&self, i: usize, j: usize) -> c64 {
        self.rows[i].h[self.place(j, false)]
    }

    /// b_ij.
    fn b(&self, i: usize, j: usize) -> c64 {
        self.rows[i].b[self.place(j, false)]
    }
}
