//! Columns that are mixed beyond corrections, made eigenvectors within their span.
//!
//! Doubles leave small roots of a system without digits beside large ones: their columns span the right space, but each is a mixture
//! of all. The Rayleigh–Ritz method in that span (Parlett 1998, *The Symmetric Eigenvalue Problem*, §11.3) knows them to
//! the digits that doubles have beside the largest root of the span, or beside the smallest, and again for what is still
//! mixed then.

use eigentone_digits::{ComplexDoubleDouble, DoubleDouble, Lu, definite_eigen, eigen};
use faer::{Mat, c64};

use super::pair::{Column, Origin, Pair, Pairs, Parts, plain};
use super::rows::Rows;

/// Which roots of a span come out with most digits: those of B⁻¹A are the large ones, those of A⁻¹B the small ones.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum End {
    Large,
    Small,
}

impl Pairs<'_> {
    /// Replaces every group of mixed columns that are not separated yet by the eigenvectors of the pencil in its span; whether there
    /// was one.
    pub(super) fn resolve(&mut self, rows: &Rows, separated: &[bool], end: End) -> bool {
        let mut kept = vec![true; self.pairs.len()];
        let mut resolved = Vec::new();
        for group in rows.mixed(false) {
            let is_open =
                |i: &usize| matches!(self.pairs[*i].origin, Origin::Mode(_)) && !separated[*i];
            let movable = group.iter().all(is_open);
            let Some(found) = movable.then(|| self.ritz(rows, &group, end)).flatten() else {
                continue;
            };
            group.iter().for_each(|i| kept[*i] = false);
            resolved.extend(found);
        }
        let any = !resolved.is_empty();
        let mut kept = kept.into_iter();
        self.pairs.retain(|_| kept.next() == Some(true));
        self.pairs.extend(resolved);
        any
    }

    fn ritz(&self, rows: &Rows, group: &[usize], end: End) -> Option<Vec<Pair>> {
        let is_real = |i: &usize| self.pairs[*i].is_real();
        let first = rows.rho[group[0]];
        // Roots close together by themselves are separated about one of them.
        let close = group.iter().all(|i| {
            let alike = is_real(i) == is_real(&group[0]);
            alike && rows.are_near(group[0], *i)
        }) && !rows.meet_conjugates(group);
        let in_plane = close && !is_real(&group[0]);
        let centre = if close {
            first
        } else {
            ComplexDoubleDouble::ZERO
        };
        let own = |pair: usize| Column {
            pair,
            conjugate: false,
        };
        let columns: Vec<Column> = group
            .iter()
            .flat_map(|&pair| {
                let conjugate = Column {
                    pair,
                    conjugate: true,
                };
                let both = !in_plane && !is_real(&pair);
                std::iter::once(own(pair)).chain(both.then_some(conjugate))
            })
            .collect();
        let size = |column: &Column| rows.own_of(*column).norm().sqrt().recip();
        let scales: Vec<f64> = columns.iter().map(size).collect();
        let k = columns.len();
        let entry = |p: usize, q: usize| {
            let (row, other) = (columns[p], columns[q]);
            let at = rows.place(other.pair, row.conjugate != other.conjugate);
            let b = rows.rows[row.pair].b[at];
            let a = rows.rows[row.pair].h[at] + plain(rows.rho[row.pair] - centre) * b;
            let scale = scales[p] * scales[q];
            let turn = |z: c64| if row.conjugate { z.conj() } else { z } * scale;
            (turn(a), turn(b))
        };
        let mut a = Mat::<c64>::from_fn(k, k, |p, q| entry(p, q).0);
        let mut b = Mat::<c64>::from_fn(k, k, |p, q| entry(p, q).1);
        // A column and its conjugate are its real and imaginary parts.
        let (half, turned) = (c64::new(0.5, 0.0), c64::new(0.0, -0.5));
        for p in (1..k).filter(|p| columns[*p].conjugate) {
            for matrix in [&mut a, &mut b] {
                for q in 0..k {
                    let (x, y) = (matrix[(p - 1, q)], matrix[(p, q)]);
                    (matrix[(p - 1, q)], matrix[(p, q)]) = ((x + y) * half, (x - y) * turned);
                }
                for q in 0..k {
                    let (x, y) = (matrix[(q, p - 1)], matrix[(q, p)]);
                    (matrix[(q, p - 1)], matrix[(q, p)]) = ((x + y) * half, (x - y) * turned);
                }
            }
        }
        let inverted = end == End::Small && !close;
        let (matrix, other) = if inverted { (&b, &a) } else { (&a, &b) };
        let all_finite = |matrix: &Mat<c64>| matrix.norm_max().is_finite();
        let on_axis = !in_plane;
        let definite = (on_axis && !self.has_left()).then(|| definite_pairs(matrix, other));
        let general = || {
            let quotient = Lu::of(other.as_ref()).solve(matrix.clone());
            if !all_finite(&quotient) {
                return None;
            }
            match on_axis {
                true => eigen(Mat::from_fn(k, k, |p, q| quotient[(p, q)].re).as_ref()),
                false => eigen(quotient.as_ref()),
            }
        };
        let (values, right): (Vec<c64>, Mat<c64>) = definite.flatten().or_else(general)?;
        let left = self
            .has_left()
            .then(|| Lu::of((&b * &right).as_ref()).inverse());
        if !all_finite(&right) || left.as_ref().is_some_and(|left| !all_finite(left)) {
            return None;
        }
        let combined =
            |coefficient: &dyn Fn(usize) -> c64, side: fn(&Pair) -> &Parts, real: bool| {
                let n = self.system.len();
                let mut parts = Parts {
                    re: vec![DoubleDouble::ZERO; n],
                    im: vec![DoubleDouble::ZERO; if real { 0 } else { n }],
                };
                let mut add = |share: c64, x: &[DoubleDouble]| {
                    for (re, x) in parts.re.iter_mut().zip(x) {
                        *re += *x * share.re;
                    }
                    for (im, x) in parts.im.iter_mut().zip(x) {
                        *im += *x * share.im;
                    }
                };
                for (p, column) in columns.iter().enumerate() {
                    let share = coefficient(p) * scales[p];
                    let own = side(&self.pairs[column.pair]);
                    if column.conjugate {
                        add(share, &own.im);
                    } else {
                        add(share, &own.re);
                        if in_plane {
                            add(share * c64::I, &own.im);
                        }
                    }
                }
                parts
            };
        let mut found = Vec::with_capacity(k);
        for (j, value) in values.into_iter().enumerate() {
            let value = if inverted { value.inv() } else { value };
            let crosses_axis = in_plane && first.im.to_f64() + value.im <= 0.0;
            if !value.is_finite() || crosses_axis {
                return None;
            }
            let real = !in_plane && value.im == 0.0;
            if !in_plane && value.im < 0.0 {
                continue;
            }
            let place = found.len().min(group.len() - 1);
            found.push(Pair {
                value: centre + ComplexDoubleDouble::new(value.re, value.im),
                right: combined(&|p| right[(p, j)], Pair::right, real),
                left: left
                    .as_ref()
                    .map(|left| combined(&|p| left[(j, p)], Pair::left, real)),
                origin: self.pairs[group[place]].origin,
            });
        }
        Some(found)
    }
}

/// Of a symmetric real pencil (A, B) with B definite, whose roots are real however close they lie; `None` where B is not.
fn definite_pairs(a: &Mat<c64>, b: &Mat<c64>) -> Option<(Vec<c64>, Mat<c64>)> {
    let k = b.nrows();
    let sign = if b[(0, 0)].re < 0.0 { -1.0 } else { 1.0 };
    let symmetric = |matrix: &Mat<c64>| {
        let half = 0.5 * sign;
        Mat::from_fn(k, k, |p, q| half * (matrix[(p, q)].re + matrix[(q, p)].re))
    };
    let (a, b) = (symmetric(a), symmetric(b));
    let (values, right) = definite_eigen(&a, &b)?;
    let right = Mat::from_fn(k, k, |p, q| c64::from(right[(p, q)]));
    Some((values.into_iter().map(c64::from).collect(), right))
}
