//! All roots of a symmetric system at once, from approximate roots and shapes, in O(n³).
//!
//! The pencil A − λB with A = diag(K, −M) and B = −[C M; M 0] has the roots of
//! Q(λ) = λ²M + λC + K, with vectors z = (x, λx) (Tisseur & Meerbergen 2001, *SIAM Review* 43, §3.4).
//! For 2n columns Z = [X; XΛ] it has those of ZᵀAZ − λZᵀBZ as well, of entries
//!
//! a_ij = x_iᵀKx_j − λ_iλ_j x_iᵀMx_j and b_ij = −(x_iᵀCx_j + (λ_i + λ_j) x_iᵀMx_j),
//!
//! which good roots and shapes make nearly diagonal: M, C and K are needed in three products only.
//! With ρ_i any numbers near a_ii/b_ii and scales τ, Gershgorin's theorem for row i divided by b_ii
//! says that a root λ has, for some i,
//!
//! |λ − ρ_i| ≤ Σ_j (|h_ij| + |λ − ρ_i||e_ij|) τ_j/τ_i, h_ij = (a_ij − ρ_ib_ij)/b_ii, e_ij = b_ij/b_ii − δ_ij,
//!
//! so that it lies in the disc about ρ_i of radius H_i/(1 − E_i), H and E being those sums. The sums
//! only shrink as all that is off the diagonal is let go to 0; so as long as E_i < 1, k discs that
//! touch no others hold k roots: all are accounted for. With τ_i made t times larger the disc of row i is
//! nearly t times smaller, while no other grows by more than t·h_ji does; the largest t for which
//! they stay apart makes the radius one of the second order in what is off the diagonal. What
//! remains is the rounding of the row's own two sums.
//!
//! X and Λ are first refined to double-double as in [`congruence`](super::congruence), by
//! x_i ← x_i + Σ_j x_j h_ij b_ii/(b_jj(ρ_i − ρ_j)), λ_i ← ρ_i (Ogita & Aishima 2018, *Jpn. J. Ind.
//! Appl. Math.* 35). Motions that nothing holds, K x = C x = 0, are taken out exactly: the rest moves in
//! the complement xᵀMy = 0. Those that only dampers hold are columns of their own with λ = 0, where
//! h vanishes.

use eigentone_digits::{ComplexDoubleDouble, DoubleDouble};
use faer::{Mat, c64};
use num_complex::Complex;

use super::gram::{Form, Gram, UPWARD};
use crate::modes::Mode;
use crate::structure::Structure;
use crate::system::System;

/// What a few operations on double-doubles err by, of the sizes that they begin with.
const ROUNDING: f64 = 2.5e-29;

/// One root with Im ≥ 0, or several that are not told apart.
#[derive(Clone, Debug)]
pub(crate) struct Paired {
    /// The modes that it comes from.
    pub(crate) members: Vec<usize>,
    pub(crate) value: Complex<f64>,
    pub(crate) bound: f64,
    pub(crate) real_bound: f64,
    /// x at a single root.
    pub(crate) shape: Option<Vec<Complex<f64>>>,
}

/// Proves a disc for every nonzero root of a symmetric system without massless nodes, given all
/// its modes approximately. `None` where no proof was reached, as for defective roots.
pub(crate) fn certify(
    system: &System,
    structure: &Structure,
    modes: &[Mode],
) -> Option<Vec<Paired>> {
    let mut pairs = Pairs::of(system, structure, modes)?;
    let rows = pairs.refine()?;
    let discs = rows.discs()?;
    pairs.found(structure, discs)
}

/// An approximate root with Im ≥ 0, and its shape.
#[derive(Clone)]
struct Pair {
    value: ComplexDoubleDouble,
    re: Vec<DoubleDouble>,
    /// Nothing for real roots.
    im: Vec<DoubleDouble>,
    /// Of which of the given modes; `None` for λ = 0 exactly, with an exact shape.
    mode: Option<usize>,
}

impl Pair {
    fn is_real(&self) -> bool {
        self.im.is_empty()
    }
}

/// The roots and shapes, with the forms that they are to diagonalise.
struct Pairs<'a> {
    system: &'a System,
    pairs: Vec<Pair>,
    /// The motion that nothing holds.
    drifting: Option<Vec<DoubleDouble>>,
}

/// Which of the 2n columns: that of a pair, or its conjugate.
#[derive(Clone, Copy, PartialEq)]
struct Column {
    pair: usize,
    conjugate: bool,
}

/// The rows of the pairs over all columns, divided by b_ii.
struct Rows {
    columns: Vec<Column>,
    rho: Vec<ComplexDoubleDouble>,
    rows: Vec<Row>,
    /// What each pair's column is scaled by.
    tau: Vec<f64>,
}

struct Row {
    /// h_ij b_ii and b_ij.
    h: Vec<c64>,
    b: Vec<c64>,
    /// Bounds of |h_ij| and |e_ij|, the rounding of all sums included.
    reach: Vec<f64>,
    mixed: Vec<f64>,
    /// b_ii.
    own: c64,
}

/// Some pairs whose discs touch each other, with the radius of each.
struct Disc {
    members: Vec<usize>,
    centres: Vec<ComplexDoubleDouble>,
    radii: Vec<f64>,
}

fn plain(z: ComplexDoubleDouble) -> c64 {
    c64::new(z.re.to_f64(), z.im.to_f64())
}

impl<'a> Pairs<'a> {
    fn of(system: &'a System, structure: &Structure, modes: &[Mode]) -> Option<Pairs<'a>> {
        let n = system.len();
        let applies = structure.is_symmetric()
            && structure.massless().is_empty()
            && structure.finite_roots() == Some(2 * n);
        if !applies {
            return None;
        }
        let indicator = |part: &Vec<usize>| -> Vec<DoubleDouble> {
            let within = |i| f64::from(u8::from(part.contains(&i)));
            (0..n).map(|i| DoubleDouble::from(within(i))).collect()
        };
        let (loose, free) = (structure.spring_floating(), structure.floating());
        let (drifting, creeping) = match (loose, free) {
            (creeping, []) => (None, creeping),
            ([_], [drifting]) => (Some(indicator(drifting)), &[][..]),
            _ => return None,
        };
        let drifts = if drifting.is_some() { 2 } else { 0 };
        if structure.zero_roots() != Some(creeping.len() + drifts) {
            return None;
        }
        let mut pairs: Vec<Pair> = creeping
            .iter()
            .map(|part| Pair {
                value: ComplexDoubleDouble::ZERO,
                re: indicator(part),
                im: Vec::new(),
                mode: None,
            })
            .collect();
        for (index, mode) in modes.iter().enumerate() {
            let value = mode.eigenvalue().value;
            if value.norm() == 0.0 {
                continue;
            }
            if mode.is_defective() {
                return None;
            }
            let part = |part: fn(&Complex<f64>) -> f64| {
                let entries = mode.shape().iter().map(part);
                entries.map(DoubleDouble::from).collect::<Vec<_>>()
            };
            pairs.push(Pair {
                value: ComplexDoubleDouble::new(value.re, value.im),
                re: part(|z| z.re),
                im: if value.im == 0.0 {
                    Vec::new()
                } else {
                    part(|z| z.im)
                },
                mode: Some(index),
            });
        }
        let count: usize = pairs
            .iter()
            .map(|pair| if pair.is_real() { 1 } else { 2 })
            .sum();
        (count + drifts == 2 * n).then_some(Pairs {
            system,
            pairs,
            drifting,
        })
    }

    /// Refines roots and shapes until their discs are small, or as far as double-double reaches.
    fn refine(&mut self) -> Option<Rows> {
        const STEPS: usize = 12;
        const GOAL: f64 = 1e-20;
        const LARGEST: f64 = 1e-3;
        self.project()?;
        let mut rows = self.rows()?;
        let mut spread = rows.spread();
        for _ in 0..STEPS {
            if spread <= GOAL {
                break;
            }
            let before = self.pairs.clone();
            let groups = rows.mixed();
            let mut separated = false;
            for group in &groups {
                separated |= self.separate(&rows, group).is_some();
            }
            if !separated {
                self.correct(&rows);
            }
            self.project()?;
            let next = self.rows();
            let reached = next.as_ref().map_or(f64::INFINITY, Rows::spread);
            match next {
                Some(next) if separated || reached < spread => rows = next,
                _ => {
                    self.pairs = before;
                    break;
                }
            }
            let stuck = !separated && reached > 0.5 * spread;
            spread = reached;
            if stuck {
                break;
            }
        }
        (spread <= LARGEST).then_some(rows)
    }

    /// Replaces columns that are mixed with each other by the eigenvectors of the pencil in their
    /// span: made orthogonal by B, then turned by complex rotations (Jacobi's) until A couples none.
    /// `None` where that fails, as at defective roots.
    fn separate(&mut self, rows: &Rows, group: &[usize]) -> Option<()> {
        const SWEEPS: usize = 40;
        let k = group.len();
        let centre = rows.rho[group[0]];
        let real = self.pairs[group[0]].is_real();
        let alike = |i: &usize| self.pairs[*i].is_real() == real && self.pairs[*i].mode.is_some();
        if !group.iter().all(alike) {
            return None;
        }
        let entries = |part: &dyn Fn(usize, usize) -> c64| {
            Mat::<c64>::from_fn(k, k, |p, q| part(group[p.min(q)], group[p.max(q)]))
        };
        let b = entries(&|i, j| rows.b(i, j));
        // A less a multiple of B, which leaves what tells the roots apart.
        let mut a = entries(&|i, j| rows.h(i, j) + plain(rows.rho[i] - centre) * rows.b(i, j));
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
            for (row, entry) in pair.re.iter_mut().enumerate() {
                *entry = DoubleDouble::ZERO;
                for (p, other) in before.iter().enumerate() {
                    *entry += other.re[row] * share(p).re;
                    if !real {
                        *entry -= other.im[row] * share(p).im;
                    }
                }
            }
            for (row, entry) in pair.im.iter_mut().enumerate() {
                *entry = DoubleDouble::ZERO;
                for (p, other) in before.iter().enumerate() {
                    *entry += other.re[row] * share(p).im + other.im[row] * share(p).re;
                }
            }
        }
        Some(())
    }

    /// The real columns of all shapes, and where each pair has its own.
    fn real_columns(&self) -> (Vec<Vec<DoubleDouble>>, Vec<usize>) {
        let mut columns = Vec::new();
        let mut places = Vec::with_capacity(self.pairs.len());
        for pair in &self.pairs {
            places.push(columns.len());
            columns.push(pair.re.clone());
            if !pair.is_real() {
                columns.push(pair.im.clone());
            }
        }
        (columns, places)
    }

    /// Takes what drifts out of all other shapes, as far as rounding goes.
    fn project(&mut self) -> Option<()> {
        let Some(drifting) = &self.drifting else {
            return Some(());
        };
        let (mut columns, places) = self.real_columns();
        let last = columns.len();
        columns.push(drifting.clone());
        let mass = Form::mass(self.system).gram(&columns);
        let own = mass.at(last, last);
        for (pair, place) in self.pairs.iter_mut().zip(places) {
            for (offset, column) in [&mut pair.re, &mut pair.im].into_iter().enumerate() {
                if column.is_empty() {
                    continue;
                }
                let share = mass.at(place + offset, last) / own;
                if !share.to_f64().is_finite() {
                    return None;
                }
                for (entry, rigid) in column.iter_mut().zip(drifting) {
                    *entry -= share * *rigid;
                }
            }
        }
        Some(())
    }

    /// All 2n columns, less those that drift.
    fn columns(&self) -> Vec<Column> {
        let both = |(pair, found): (usize, &Pair)| {
            let column = |conjugate| Column { pair, conjugate };
            if found.is_real() {
                vec![column(false)]
            } else {
                vec![column(false), column(true)]
            }
        };
        self.pairs.iter().enumerate().flat_map(both).collect()
    }

    /// `None` where a shape has no root or a number leaves its range.
    fn rows(&self) -> Option<Rows> {
        let (mut columns, places) = self.real_columns();
        let count = columns.len();
        columns.extend(self.drifting.clone());
        let mass = Form::mass(self.system).gram(&columns);
        columns.truncate(count);
        let damping = Form::damping(self.system).gram(&columns);
        let stiffness = Form::stiffness(self.system).gram(&columns);
        let forms = Products {
            pairs: &self.pairs,
            places: &places,
        };
        let loss = |i: usize| {
            if self.drifting.is_none() {
                return 0.0;
            }
            let least = (mass.at(count, count).to_f64() - mass.error(count, count)).sqrt();
            let parts = if self.pairs[i].is_real() { 1 } else { 2 };
            let sum: f64 = (0..parts)
                .map(|part| mass.upper(places[i] + part, count))
                .sum();
            sum / least * UPWARD
        };
        // What is left of the motion that drifts, in each shape.
        let losses: Vec<f64> = (0..self.pairs.len()).map(loss).collect();
        let columns = self.columns();
        let value = |column: Column| {
            let value = self.pairs[column.pair].value;
            if column.conjugate {
                value.conj()
            } else {
                value
            }
        };
        let of = |i: usize, other: Column, rho: ComplexDoubleDouble| -> Entry {
            let fixed = self.pairs[i].mode.is_none() || self.pairs[other.pair].mode.is_none();
            let (k, k_error) = if fixed {
                (ComplexDoubleDouble::ZERO, 0.0)
            } else {
                forms.of(&stiffness, i, other)
            };
            let (m, m_error) = forms.of(&mass, i, other);
            let (c, c_error) = forms.of(&damping, i, other);
            let m_error = m_error + losses[i] * losses[other.pair];
            let (first, second) = (self.pairs[i].value, value(other));
            let (product, sum) = (first * second, first + second);
            let a = k - product * m;
            let b = -(c + sum * m);
            let a_size = k.norm() + product.norm() * m.norm();
            let b_size = c.norm() + sum.norm() * m.norm();
            let a_error = k_error + product.norm() * m_error + ROUNDING * a_size;
            let b_error = c_error + sum.norm() * m_error + ROUNDING * b_size;
            Entry {
                a,
                b,
                h: plain(a - rho * b),
                h_error: (a_error + rho.norm() * (b_error + ROUNDING * b_size) + ROUNDING * a_size)
                    * UPWARD,
                b_error: b_error * UPWARD,
            }
        };
        let own = |pair: usize| Column {
            pair,
            conjugate: false,
        };
        let mut rho = Vec::with_capacity(self.pairs.len());
        for i in 0..self.pairs.len() {
            let entry = of(i, own(i), ComplexDoubleDouble::ZERO);
            let quotient = match self.pairs[i].mode {
                Some(_) => entry.a / entry.b,
                None => ComplexDoubleDouble::ZERO,
            };
            if !quotient.is_finite() || entry.b.norm() == 0.0 {
                return None;
            }
            rho.push(if self.pairs[i].is_real() {
                ComplexDoubleDouble {
                    im: DoubleDouble::ZERO,
                    ..quotient
                }
            } else {
                quotient
            });
        }
        let row = |i: usize| {
            let own = plain(of(i, own(i), ComplexDoubleDouble::ZERO).b);
            let size = own.norm() / UPWARD;
            let mut row = Row {
                h: Vec::with_capacity(columns.len()),
                b: Vec::with_capacity(columns.len()),
                reach: Vec::with_capacity(columns.len()),
                mixed: Vec::with_capacity(columns.len()),
                own,
            };
            for other in &columns {
                let entry = of(i, *other, rho[i]);
                let is_own = *other
                    == Column {
                        pair: i,
                        conjugate: false,
                    };
                let mixed = if is_own { 0.0 } else { entry.b.norm() };
                row.h.push(entry.h);
                row.b.push(plain(entry.b));
                row.reach.push((entry.h.norm() + entry.h_error) / size);
                row.mixed.push((mixed + entry.b_error) / size);
            }
            row
        };
        let rows: Vec<Row> = (0..self.pairs.len()).map(row).collect();
        let sizes = rho.iter().map(|rho| rho.norm()).filter(|size| *size > 0.0);
        let least = sizes.fold(f64::INFINITY, f64::min);
        let tau = rho
            .iter()
            .zip(&rows)
            .map(|(rho, row)| (rho.norm().max(least) * row.own.norm()).sqrt().recip());
        let tau: Vec<f64> = tau.collect();
        let usable = tau.iter().all(|tau| tau.is_normal());
        usable.then_some(Rows {
            columns,
            rho,
            rows,
            tau,
        })
    }

    /// A step towards the roots and shapes, of the first order in what is off the diagonal; columns
    /// too close for that keep what mixes them.
    fn correct(&mut self, rows: &Rows) {
        let n = self.system.len();
        let (all, count) = (rows.columns.len(), self.pairs.len());
        let mut change = Mat::<c64>::zeros(all, count);
        for i in (0..count).filter(|i| self.pairs[*i].mode.is_some()) {
            let row = &rows.rows[i];
            for (at, other) in rows.columns.iter().enumerate() {
                if other.pair == i && !other.conjugate {
                    continue;
                }
                let gap = plain(rows.rho[i] - rows.rho_of(*other));
                let share = row.h[at] / (rows.own_of(*other) * gap);
                if !rows.mixes(i, *other, share) {
                    change[(at, i)] = share;
                }
            }
        }
        let shapes = Mat::<c64>::from_fn(n, all, |row, at| {
            let Column { pair, conjugate } = rows.columns[at];
            let pair = &self.pairs[pair];
            let im = pair.im.get(row).map_or(0.0, |im| im.to_f64());
            c64::new(pair.re[row].to_f64(), if conjugate { -im } else { im })
        });
        let product = shapes * change;
        for (i, pair) in self.pairs.iter_mut().enumerate() {
            if pair.mode.is_none() {
                continue;
            }
            pair.value = rows.rho[i];
            if pair.is_real() {
                pair.value.im = DoubleDouble::ZERO;
            }
            for (row, entry) in pair.re.iter_mut().enumerate() {
                *entry = *entry + product[(row, i)].re;
            }
            for (row, entry) in pair.im.iter_mut().enumerate() {
                *entry = *entry + product[(row, i)].im;
            }
        }
    }

    /// The discs as doubles with bounds.
    fn found(&self, structure: &Structure, discs: Vec<Disc>) -> Option<Vec<Paired>> {
        let off_axis = |disc: &Disc| {
            let each = disc.centres.iter().zip(&disc.radii);
            each.map(|(centre, radius)| centre.re.to_f64().abs() - radius)
                .fold(f64::INFINITY, f64::min)
        };
        let is_real = |disc: &Disc| self.pairs[disc.members[0]].is_real();
        // Modes that move no damper are counted exactly.
        let hidden = discs
            .iter()
            .filter(|disc| !is_real(disc) && off_axis(disc) <= 0.0);
        let hidden: usize = hidden.map(|disc| disc.members.len()).sum();
        let undamped = hidden > 0 && structure.undamped_modes() == Some(hidden);
        let mut found = Vec::new();
        for disc in &discs {
            let real = is_real(disc);
            if disc
                .members
                .iter()
                .any(|i| self.pairs[*i].is_real() != real)
            {
                return None;
            }
            let members: Option<Vec<usize>> =
                disc.members.iter().map(|i| self.pairs[*i].mode).collect();
            let middle = disc.centres[disc.centres.len() / 2];
            let mut value = plain(middle);
            let on_axis = !real && off_axis(disc) <= 0.0;
            if on_axis {
                value.re = 0.0;
            }
            if structure.is_passive() && value.re > 0.0 {
                return None;
            }
            let (mut bound, mut real_bound) = (0f64, 0f64);
            for (centre, radius) in disc.centres.iter().zip(&disc.radii) {
                let re = (centre.re - DoubleDouble::from(value.re)).to_f64().abs();
                let im = (centre.im - DoubleDouble::from(value.im)).to_f64().abs();
                bound = bound.max((re.hypot(im) + radius) * UPWARD);
                real_bound = real_bound.max((re + radius) * UPWARD);
            }
            if on_axis && undamped {
                real_bound = 0.0;
            }
            let shape = |i: usize| {
                let pair = &self.pairs[i];
                let entry = |row: usize| {
                    let im = pair.im.get(row).map_or(0.0, |im| im.to_f64());
                    Complex::new(pair.re[row].to_f64(), im)
                };
                (0..self.system.len()).map(entry).collect()
            };
            found.push(Paired {
                members: members?,
                value,
                bound: bound.max(f64::from_bits(1)),
                real_bound: if real_bound > 0.0 {
                    real_bound.max(f64::from_bits(1))
                } else {
                    0.0
                },
                shape: (disc.members.len() == 1).then(|| shape(disc.members[0])),
            });
        }
        Some(found)
    }
}

/// a_ij and b_ij, and h_ij b_ii, with how far each may be off.
struct Entry {
    a: ComplexDoubleDouble,
    b: ComplexDoubleDouble,
    h: c64,
    h_error: f64,
    b_error: f64,
}

/// Complex products from those of real columns.
struct Products<'a> {
    pairs: &'a [Pair],
    places: &'a [usize],
}

impl Products<'_> {
    /// x_iᵀAx_j, x_j perhaps conjugated, and a bound of its error.
    fn of(&self, gram: &Gram, i: usize, other: Column) -> (ComplexDoubleDouble, f64) {
        let j = other.pair;
        let (p, q) = (self.places[i], self.places[j]);
        let (first, second) = (!self.pairs[i].is_real(), !self.pairs[j].is_real());
        let sign = if other.conjugate { -1.0 } else { 1.0 };
        let (mut re, mut im) = (gram.at(p, q), DoubleDouble::ZERO);
        let mut error = gram.error(p, q);
        if second {
            im += gram.at(p, q + 1) * sign;
            error += gram.error(p, q + 1);
        }
        if first {
            im += gram.at(p + 1, q);
            error += gram.error(p + 1, q);
        }
        if first && second {
            let part = gram.at(p + 1, q + 1);
            re -= part * sign;
            error += gram.error(p + 1, q + 1);
            // The sums round as well.
            let size = gram.at(p, q).to_f64().abs() + part.to_f64().abs();
            error += ROUNDING * (size + gram.at(p, q + 1).to_f64().abs());
            error += ROUNDING * gram.at(p + 1, q).to_f64().abs();
        }
        (ComplexDoubleDouble { re, im }, error * UPWARD)
    }
}

impl Rows {
    fn rho_of(&self, column: Column) -> ComplexDoubleDouble {
        let rho = self.rho[column.pair];
        if column.conjugate { rho.conj() } else { rho }
    }

    fn own_of(&self, column: Column) -> c64 {
        let own = self.rows[column.pair].own;
        if column.conjugate { own.conj() } else { own }
    }

    /// Where the column of a pair stands.
    fn place(&self, pair: usize) -> usize {
        let own = Column {
            pair,
            conjugate: false,
        };
        self.columns
            .iter()
            .position(|column| *column == own)
            .unwrap_or(0)
    }

    /// h_ij b_ii.
    fn h(&self, i: usize, j: usize) -> c64 {
        self.rows[i].h[self.place(j)]
    }

    /// b_ij.
    fn b(&self, i: usize, j: usize) -> c64 {
        self.rows[i].b[self.place(j)]
    }

    /// Whether so large a share of another column is more than a correction.
    fn mixes(&self, i: usize, other: Column, share: c64) -> bool {
        const SMALL: f64 = 1e-2;
        let ratio = self.tau[i] / self.tau[other.pair];
        !share.is_finite() || share.norm() * ratio > SMALL
    }

    /// Groups of pairs with roots so near, and columns so far from what they should be, that
    /// corrections do not tell them apart.
    fn mixed(&self) -> Vec<Vec<usize>> {
        /// Gaps that may hide it.
        const NEAR: f64 = 0.1;
        let count = self.rows.len();
        let mut label: Vec<usize> = (0..count).collect();
        for (i, row) in self.rows.iter().enumerate() {
            for (at, other) in self.columns.iter().enumerate() {
                let j = other.pair;
                let gap = plain(self.rho[i] - self.rho_of(*other));
                if j == i || other.conjugate || gap.norm() > NEAR * self.rho[i].norm() {
                    continue;
                }
                let share = row.h[at] / (self.own_of(*other) * gap);
                if self.mixes(i, *other, share) {
                    let (from, to) = (label[i].max(label[j]), label[i].min(label[j]));
                    let moved = label.iter_mut().filter(|label| **label == from);
                    moved.for_each(|label| *label = to);
                }
            }
        }
        let members = |first: usize| (0..count).filter(|i| label[*i] == first).collect();
        let groups = (0..count).map(members);
        groups
            .filter(|group: &Vec<usize>| group.len() > 1)
            .collect()
    }

    /// h_ii, and the sums of all others and of e over a row.
    fn sums(&self, i: usize) -> (f64, f64, f64) {
        let (mut own, mut others, mut mixed) = (0.0, 0.0, 0.0);
        let row = &self.rows[i];
        for (at, other) in self.columns.iter().enumerate() {
            let ratio = self.tau[other.pair] / self.tau[i];
            if other.pair == i && !other.conjugate {
                own = row.reach[at];
            } else {
                others += row.reach[at] * ratio;
            }
            mixed += row.mixed[at] * ratio;
        }
        (own * UPWARD, others * UPWARD, mixed * UPWARD)
    }

    /// The largest radius, relative to its root.
    fn spread(&self) -> f64 {
        let relative = |i: usize| {
            let (own, others, mixed) = self.sums(i);
            let size = self.rho[i].norm();
            let reach = own + others;
            if mixed > 0.25 || reach.is_nan() || mixed.is_nan() {
                1.0
            } else if size == 0.0 {
                0.0
            } else {
                reach / size
            }
        };
        (0..self.rows.len()).map(relative).fold(0.0, f64::max)
    }

    /// Discs that hold as many roots as they have members, none of which touches another or its
    /// conjugate; `None` where that is not so.
    fn discs(&self) -> Option<Vec<Disc>> {
        let count = self.rows.len();
        let sums: Vec<(f64, f64, f64)> = (0..count).map(|i| self.sums(i)).collect();
        if !sums
            .iter()
            .all(|(own, others, mixed)| *mixed <= 0.25 && (own + others).is_finite())
        {
            return None;
        }
        let reach = |i: usize| sums[i].0 + sums[i].1;
        let mut label: Vec<usize> = (0..count).collect();
        // How many times larger each column can be made.
        let mut times = vec![1e15f64; count];
        for (i, row) in self.rows.iter().enumerate() {
            for (at, other) in self.columns.iter().enumerate() {
                let j = other.pair;
                if j == i && !other.conjugate {
                    continue;
                }
                let gap = (self.rho[i] - self.rho_of(*other)).norm() / UPWARD;
                // With E ≤ ½ each radius is at most twice its sum.
                let rest = gap - 2.0 * (reach(i) + reach(j)) * UPWARD;
                if rest.is_nan() || rest <= 0.0 {
                    if other.conjugate {
                        return None;
                    }
                    let (from, to) = (label[i].max(label[j]), label[i].min(label[j]));
                    let moved = label.iter_mut().filter(|label| **label == from);
                    moved.for_each(|label| *label = to);
                    continue;
                }
                let ratio = self.tau[j] / self.tau[i] * UPWARD;
                let most =
                    (rest / (2.0 * row.reach[at] * ratio)).min(0.25 / (row.mixed[at] * ratio));
                if !most.is_nan() {
                    times[j] = times[j].min(most / UPWARD);
                }
            }
        }
        let mut discs = Vec::new();
        for first in 0..count {
            let members: Vec<usize> = (0..count).filter(|i| label[*i] == first).collect();
            if members.is_empty() || self.rho[first].norm() == 0.0 && members.len() == 1 {
                continue;
            }
            let alone = members.len() == 1;
            let radius = |i: &usize| {
                let (own, others, mixed) = sums[*i];
                let times = if alone { times[*i].max(1.0) } else { 1.0 };
                (own + others / times) / (1.0 - mixed) * UPWARD
            };
            discs.push(Disc {
                centres: members.iter().map(|i| self.rho[*i]).collect(),
                radii: members.iter().map(radius).collect(),
                members,
            });
        }
        Some(discs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inclusion;
    use crate::{Bounds, GROUND, MatrixKind, Modes, Precision, SystemBuilder};
    use eigentone_digits::{Real, Wide, WideComplex};
    use proptest::prelude::*;

    const UNIT: f64 = f64::EPSILON / 2.0;

    fn approximate(system: &System) -> Modes {
        system.modes_to(Precision::Double).unwrap()
    }

    fn proven(system: &System) -> Option<Vec<Paired>> {
        certify(system, system.structure(), approximate(system).as_slice())
    }

    /// Masses in a row, with a spring before each and one behind the last; dampers to the ground.
    fn chain(masses: &[f64], springs: &[f64], dashpots: &[(usize, f64)]) -> System {
        let name = |i: usize| format!("m{i}");
        let n = masses.len();
        let each = masses.iter().enumerate();
        let mut builder = each.fold(SystemBuilder::default(), |b, (i, m)| b.mass(name(i), *m));
        for (i, k) in springs.iter().enumerate().filter(|(_, k)| **k != 0.0) {
            let from = if i == 0 {
                GROUND.to_owned()
            } else {
                name(i - 1)
            };
            let to = if i == n { GROUND.to_owned() } else { name(i) };
            builder = builder.spring(from, to, *k);
        }
        let dashpots = dashpots.iter();
        let damped = dashpots.fold(builder, |b, (i, c)| b.damper(GROUND, name(*i), *c));
        damped.build().unwrap()
    }

    type Precise = WideComplex<Wide<4>>;

    /// How far λ and its real part are from a root of the chain, by Newton's method on its determinant:
    /// the recurrence of a tridiagonal matrix in 77 digits, with its derivative.
    fn errors(
        masses: &[f64],
        springs: &[f64],
        dashpots: &[(usize, f64)],
        found: Complex<f64>,
    ) -> (f64, f64) {
        const STEPS: usize = 5;
        let start = Precise::new(found.re, found.im);
        let mut lambda = start;
        for _ in 0..STEPS {
            let [mut last, mut now] = [[Precise::ZERO; 2], [Precise::new(1.0, 0.0), Precise::ZERO]];
            for i in 0..masses.len() {
                let c: f64 = dashpots.iter().filter(|d| d.0 == i).map(|d| d.1).sum();
                let stiffness = Precise::new(springs[i] + springs[i + 1], 0.0);
                let entry = lambda * lambda * masses[i] + lambda * c + stiffness;
                let slope = lambda * (2.0 * masses[i]) + Precise::new(c, 0.0);
                let beside = springs[i] * springs[i];
                let value = entry * now[0] - last[0] * beside;
                let derivative = slope * now[0] + entry * now[1] - last[1] * beside;
                (last, now) = (now, [value, derivative]);
            }
            lambda = lambda - now[0] / now[1];
        }
        let apart = lambda - start;
        (apart.norm(), apart.re.to_f64().abs())
    }

    #[test]
    fn long_chains_with_a_few_dashpots() {
        for (n, dashpots) in [
            (80, vec![(79, 0.75)]),
            (200, vec![(3, 0.5), (99, 2.0), (150, 1e-6)]),
            // Pairs of roots 1e-9 apart, which doubles mix.
            (200, vec![(3, 0.5), (100, 2.0)]),
        ] {
            let masses: Vec<f64> = (0..n).map(|i| 1.0 + 0.25 * (i % 4) as f64).collect();
            let mut springs: Vec<f64> = (0..=n).map(|i| 1.0 + (i % 3) as f64).collect();
            springs[n] = 0.0;
            let system = chain(&masses, &springs, &dashpots);
            let modes = system.modes().unwrap();
            assert_eq!(modes.bounds(), Bounds::Proven, "{}", modes.plan());
            assert_eq!(modes.eigenvalues().len(), 2 * n);
            for root in modes.eigenvalues() {
                let size = root.value.norm();
                let (bound, real_bound) = (root.bound.unwrap(), root.real_bound.unwrap());
                assert!(bound <= 4.0 * UNIT * size, "{root:?}");
                // Some modes keep away from all dashpots.
                let least = 1e-10 * UNIT * size;
                assert!(
                    real_bound <= (8.0 * UNIT * root.value.re.abs()).max(least),
                    "{root:?}"
                );
                let (error, real_error) = errors(&masses, &springs, &dashpots, root.value);
                assert!(
                    error <= bound && real_error <= real_bound,
                    "{error:e} {root:?}"
                );
            }
            for mode in &modes {
                assert!(mode.backward_error() <= 20.0 * UNIT);
            }
        }
    }

    /// A beam of Hermite elements, EI = 1 and each 1 long, 420 kg/m, clamped at both ends.
    fn clamped_beam(elements: usize) -> [Mat<f64>; 2] {
        let mass = [
            [156.0, 22.0, 54.0, -13.0],
            [22.0, 4.0, 13.0, -3.0],
            [54.0, 13.0, 156.0, -22.0],
            [-13.0, -3.0, -22.0, 4.0],
        ];
        let stiffness = [
            [12.0, 6.0, -12.0, 6.0],
            [6.0, 4.0, -6.0, 2.0],
            [-12.0, -6.0, 12.0, -6.0],
            [6.0, 2.0, -6.0, 4.0],
        ];
        let n = 2 * elements - 2;
        [mass, stiffness].map(|element| {
            let mut whole = Mat::zeros(n, n);
            for at in 0..elements {
                for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
                    let place = |k: usize| (2 * at + k).checked_sub(2).filter(|place| *place < n);
                    if let (Some(a), Some(b)) = (place(i), place(j)) {
                        whole[(a, b)] += element[i][j];
                    }
                }
            }
            whole
        })
    }

    #[test]
    fn a_clamped_beam_with_a_dashpot_at_its_middle() {
        let elements = 60;
        let [mass, stiffness] = clamped_beam(elements);
        let n = mass.nrows();
        let names = (0..n).fold(System::builder(), |b, i| b.mass(format!("q{i}"), 0.0));
        let system = names
            .matrix(MatrixKind::Mass, mass.as_ref())
            .matrix(MatrixKind::Stiffness, stiffness.as_ref())
            .damper(GROUND, format!("q{}", elements - 2), 8.0)
            .build()
            .unwrap();
        let modes = system.modes().unwrap();
        assert_eq!(modes.bounds(), Bounds::Proven, "{}", modes.plan());
        let undamped = modes
            .iter()
            .filter(|mode| mode.eigenvalue().value.re == 0.0);
        assert_eq!(undamped.count(), n / 2);
        for root in modes.eigenvalues() {
            assert!(root.value.re <= 0.0);
            assert!(
                root.bound.unwrap() <= 4.0 * UNIT * root.value.norm(),
                "{root:?}"
            );
            assert!(
                root.real_bound.unwrap() <= 8.0 * UNIT * root.value.re.abs(),
                "{root:?}"
            );
        }
    }

    #[test]
    fn no_proof_of_what_it_is_not_meant_for() {
        // Critical damping, and a force that follows.
        let critical = chain(&[1.0], &[1.0, 0.0], &[(0, 2.0)]);
        assert!(proven(&critical).is_none());
        let names = System::builder().mass("a", 1.0).mass("b", 2.0);
        let follower = faer::mat![[2.0, -1.0], [0.0, 3.0]];
        let follower = names.matrix(MatrixKind::Stiffness, follower.as_ref());
        assert!(proven(&follower.build().unwrap()).is_none());
        // A root is missing, and one is given twice.
        let system = chain(&[1.0, 2.0], &[1.0, 2.0, 3.0], &[(0, 0.5)]);
        let modes = approximate(&system);
        let structure = system.structure();
        assert!(certify(&system, structure, modes.as_slice()).is_some());
        assert!(certify(&system, structure, &modes.as_slice()[..1]).is_none());
        let twice = [modes.as_slice()[0].clone(), modes.as_slice()[0].clone()];
        assert!(certify(&system, structure, &twice).is_none());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        #[test]
        fn agrees_with_the_determinant(
            masses in prop::collection::vec(0.5..3.0f64, 2..7),
            springs in prop::collection::vec(-2.0..2.0f64, 7),
            dashpots in prop::collection::vec((0usize..7, -3.0..1.0f64), 0..4),
            cross in prop::collection::vec((0usize..7, 0usize..7, -3.0..1.0f64), 0..3),
            ends in 0..3,
        ) {
            let n = masses.len();
            let mut springs: Vec<f64> = springs[..=n].iter().map(|x| 10f64.powf(*x)).collect();
            springs[n] = 0.0;
            if ends == 0 {
                springs[0] = 0.0;
            }
            let name = |i: usize| format!("m{}", i % n);
            let each = masses.iter().enumerate();
            let mut builder = each.fold(SystemBuilder::default(), |b, (i, m)| b.mass(name(i), *m));
            for (i, k) in springs.iter().enumerate().filter(|(_, k)| **k != 0.0) {
                let from = if i == 0 { GROUND.to_owned() } else { name(i - 1) };
                builder = builder.spring(from, name(i), *k);
            }
            for (i, c) in &dashpots {
                builder = builder.damper(GROUND, name(*i), 10f64.powf(*c));
            }
            for (i, j, c) in cross.iter().filter(|(i, j, _)| i % n != j % n) {
                builder = builder.damper(name(*i), name(*j), 10f64.powf(*c));
            }
            let system = builder.build().unwrap();
            let modes = approximate(&system);
            let Some(found) = proven(&system) else {
                // Only where roots lie close to each other.
                let roots = modes.eigenvalues();
                let near = |i: usize| (0..i).any(|j| {
                    let gap = (roots[i].value - roots[j].value).norm();
                    gap <= 1e-2 * roots[i].value.norm()
                });
                prop_assert!((0..roots.len()).any(near), "{:?}", roots);
                return Ok(());
            };
            let nonzero = modes.eigenvalues().iter().map(|root| root.value);
            let start: Vec<Complex<f64>> = nonzero.filter(|z| z.norm() > 0.0).collect();
            let structure = system.structure();
            let (discs, _) = inclusion::certify(&system, structure, &start, 4.0 * UNIT).unwrap();
            let count: usize = discs.iter().map(|disc| disc.members.len()).sum();
            let ours: usize = found.iter().map(|disc| disc.members.len()).sum();
            prop_assert!(ours <= count);
            for disc in &found {
                let met = discs.iter().filter(|other| {
                    let reach = (disc.bound + other.bound) * (1.0 + 1e-9);
                    let real = (disc.real_bound + other.real_bound) * (1.0 + 1e-9);
                    let apart = disc.value - other.value;
                    apart.norm() <= reach && apart.re.abs() <= real
                });
                prop_assert_eq!(met.count(), 1, "{:?}", disc);
            }
        }
    }
}
