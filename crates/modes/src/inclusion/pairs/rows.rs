//! The rows of ZᵀAZ − λZᵀBZ, with bounds of their entries.

use eigentone_digits::{ComplexDoubleDouble, DoubleDouble};
use faer::c64;

use super::pair::{Column, Origin, Pair, Pairs, plain};
use crate::inclusion::gram::{Form, Gram, SLICES, UPWARD};

type Columns = Vec<Vec<DoubleDouble>>;

/// What a few operations on double-doubles err by, of the sizes that they begin with.
const ROUNDING: f64 = 2.5e-29;

/// The rows of the pairs over all columns, divided by b_ii.
pub(super) struct Rows {
    pub(super) columns: Vec<Column>,
    /// λ as it was before.
    pub(super) values: Vec<ComplexDoubleDouble>,
    pub(super) rho: Vec<ComplexDoubleDouble>,
    pub(super) rows: Vec<Row>,
    /// What each pair's column is scaled by.
    pub(super) tau: Vec<f64>,
    /// How much of the motions that drift each shape holds at most, in any component.
    pub(super) drift: Vec<f64>,
    pub(super) origins: Vec<Origin>,
    /// Pairs with real roots whose shapes are nearly the same: the other one of each.
    twin: Vec<Option<usize>>,
    /// Where the column of each pair stands.
    places: Vec<usize>,
    /// Of M, C and K.
    forms: [Gram; 3],
}

pub(super) struct Row {
    /// h_ij b_ii and b_ij.
    pub(super) h: Vec<c64>,
    pub(super) b: Vec<c64>,
    /// Bounds of |h_ij| and |e_ij|, the rounding of all sums included.
    pub(super) reach: Vec<f64>,
    pub(super) mixed: Vec<f64>,
    /// b_ii.
    pub(super) own: c64,
}

impl Pairs<'_> {
    /// From those of shapes nearby where there are any; `None` where a shape has no root or a number leaves its range.
    pub(super) fn rows(&self, before: Option<&Rows>) -> Option<Rows> {
        let (mut columns, places) = self.real_columns(Pair::right);
        let count = columns.len();
        columns.extend(self.drifting.clone());
        let mut left = self.has_left().then(|| self.real_columns(Pair::left).0);
        if let Some(left) = &mut left {
            left.extend(self.drifting.clone());
        }
        let forms = [Form::mass, Form::damping, Form::stiffness].map(|form| form(self.system));
        // yᵀAx for all columns, those on the left being the same where there are no others.
        let gram = |which: usize, left: Option<&Columns>, columns: &Columns| {
            let before = before.map(|before| &before.forms[which]);
            match left {
                None => forms[which].gram_near(before, SLICES, columns),
                Some(left) => forms[which].between(left, columns),
            }
        };
        let mass = gram(0, left.as_ref(), &columns);
        columns.truncate(count);
        if let Some(left) = &mut left {
            left.truncate(count);
        }
        let damping = gram(1, left.as_ref(), &columns);
        let stiffness = gram(2, left.as_ref(), &columns);
        let products = Products {
            pairs: &self.pairs,
            places: &places,
        };
        // What coordinates that follow at once leave of each shape, by the size that K gives it.
        let follow = |columns: &[Vec<DoubleDouble>]| -> Vec<f64> {
            let left = self.inert.left(&forms[2], columns);
            let of = |i: usize| {
                let parts = if self.pairs[i].is_real() { 1 } else { 2 };
                let sum: f64 = left[places[i]..places[i] + parts].iter().sum();
                match self.pairs[i].origin {
                    Origin::Rest => 0.0,
                    _ => sum.sqrt() * UPWARD,
                }
            };
            (0..self.pairs.len()).map(of).collect()
        };
        let follow_right = follow(&columns);
        let follow_left = left.as_deref().map(follow);
        let follow_left = follow_left.as_ref().unwrap_or(&follow_right);
        let drifting = Drifting::of(&self.drifting, &mass, count)?;
        // What is left of the motions that drift, in each shape.
        let losses = |upper: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
            let loss = |i: usize| {
                let parts = if self.pairs[i].is_real() { 1 } else { 2 };
                let left = (0..parts).map(|part| drifting.left_of(places[i] + part, upper));
                left.sum::<f64>() * UPWARD
            };
            (0..self.pairs.len()).map(loss).collect()
        };
        let losses_right = losses(&|column, drift| mass.upper(drift, column));
        let losses_left = losses(&|column, drift| mass.upper(column, drift));
        let drift = losses_left.iter().zip(&losses_right);
        let drift = drift.map(|(left, right)| drifting.largest * left.max(*right) * UPWARD);
        let drift = drift.collect();
        let columns = self.columns();
        let value = |column: Column| {
            let value = self.pairs[column.pair].value;
            if column.conjugate {
                value.conj()
            } else {
                value
            }
        };
        let sizes: Vec<f64> = self.pairs.iter().map(|pair| pair.value.norm()).collect();
        let own = |pair: usize| Column {
            pair,
            conjugate: false,
        };
        let of = |i: usize, other: Column, rho: ComplexDoubleDouble| -> Entry {
            let fixed = [i, other.pair]
                .map(|i| self.pairs[i].origin)
                .contains(&Origin::Rest);
            let (k, k_error) = if fixed {
                (ComplexDoubleDouble::ZERO, 0.0)
            } else {
                products.of(&stiffness, i, other)
            };
            let k_error = k_error + follow_left[i] * follow_right[other.pair];
            let (m, m_error) = products.of(&mass, i, other);
            let (c, c_error) = products.of(&damping, i, other);
            let m_error = m_error + losses_left[i] * losses_right[other.pair];
            let (first, second) = (self.pairs[i].value, value(other));
            let (product, sum) = (first * second, first + second);
            let a = k - product * m;
            let b = -(c + sum * m);
            let (product, sum) = (sizes[i] * sizes[other.pair], sum.norm());
            let [k, m, c] = [k, m, c].map(|z| plain(z).l1_norm());
            let (a_size, b_size) = (k + product * m, c + sum * m);
            let a_error = k_error + product * m_error + ROUNDING * a_size;
            let b_error = c_error + sum * m_error + ROUNDING * b_size;
            let rounding = ROUNDING * (a_size + rho.norm() * b_size);
            Entry {
                a,
                b,
                h: plain(a - rho * b),
                h_error: (a_error + rho.norm() * b_error + rounding) * UPWARD,
                b_error: b_error * UPWARD,
            }
        };
        let mut rho = Vec::with_capacity(self.pairs.len());
        for i in 0..self.pairs.len() {
            let entry = of(i, own(i), ComplexDoubleDouble::ZERO);
            let quotient = if self.pairs[i].value.norm() > 0.0 {
                entry.a / entry.b
            } else {
                ComplexDoubleDouble::ZERO
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
            let of_own = plain(of(i, own(i), ComplexDoubleDouble::ZERO).b);
            let size = of_own.norm() / UPWARD;
            let mut row = Row {
                h: Vec::with_capacity(columns.len()),
                b: Vec::with_capacity(columns.len()),
                reach: Vec::with_capacity(columns.len()),
                mixed: Vec::with_capacity(columns.len()),
                own: of_own,
            };
            for other in &columns {
                let entry = of(i, *other, rho[i]);
                let mixed = if *other == own(i) {
                    0.0
                } else {
                    entry.b.norm()
                };
                row.h.push(entry.h);
                row.b.push(plain(entry.b));
                row.reach.push((entry.h.norm() + entry.h_error) / size);
                row.mixed.push((mixed + entry.b_error) / size);
            }
            row
        };
        let rows: Vec<Row> = (0..self.pairs.len()).map(row).collect();
        let origins: Vec<Origin> = self.pairs.iter().map(|pair| pair.origin).collect();
        let sizes = rho.iter().map(|rho| rho.norm());
        let known = sizes
            .zip(&origins)
            .filter(|(size, origin)| *size > 0.0 && !origin.is_counted());
        let least = known.fold(f64::INFINITY, |least, (size, _)| least.min(size));
        let tau = rho.iter().zip(&rows).map(|(rho, row)| {
            let size = if rho.norm() > 0.0 { rho.norm() } else { least };
            (size * row.own.norm()).sqrt().recip()
        });
        let tau: Vec<f64> = tau.collect();
        let usable = tau.iter().all(|tau| tau.is_normal());
        usable.then_some(Rows {
            columns,
            values: self.pairs.iter().map(|pair| pair.value).collect(),
            rho,
            rows,
            tau,
            drift,
            origins,
            twin: self.twins(&mass, &places),
            places,
            forms: [mass, damping, stiffness],
        })
    }
}

impl Pairs<'_> {
    /// The pairs with real roots whose shapes are nearly the same, two by two.
    fn twins(&self, mass: &Gram, places: &[usize]) -> Vec<Option<usize>> {
        /// Of the square of the cosine between them.
        const ALIKE: f64 = 0.5;
        let mut twin = vec![None; self.pairs.len()];
        let is_single = |i: &usize| self.pairs[*i].is_real() && !self.pairs[*i].is_given();
        let singles: Vec<usize> = (0..self.pairs.len()).filter(is_single).collect();
        let product = |i: usize, j: usize| mass.at(places[i], places[j]).to_f64();
        for (at, &i) in singles.iter().enumerate() {
            let alike = |j: usize| product(i, j).powi(2) / (product(i, i) * product(j, j));
            let open = singles[at + 1..]
                .iter()
                .copied()
                .filter(|j| twin[*j].is_none());
            let best = open.max_by(|a, b| alike(*a).total_cmp(&alike(*b)));
            if let Some(j) = best.filter(|j| twin[i].is_none() && alike(*j) > ALIKE) {
                (twin[i], twin[j]) = (Some(j), Some(i));
            }
        }
        twin
    }
}

/// Exact motions D that nothing holds, behind `first` columns, to take out of all others: x − D(DᵀMD)⁻¹DᵀMx.
struct Drifting {
    /// Lower bounds of √(d_kᵀMd_k).
    norms: Vec<f64>,
    first: usize,
    /// 1/√λ, λ ≤ the least eigenvalue of DᵀMD with its diagonal scaled to 1.
    skew: f64,
    /// The largest component of D(DᵀMD)⁻¹c where D has c left, of size 1 by M.
    largest: f64,
}

impl Drifting {
    fn of(motions: &[Vec<DoubleDouble>], mass: &Gram, first: usize) -> Option<Drifting> {
        let own = |k: usize| {
            let at = first + k;
            (mass.at(at, at).to_f64() - mass.error(at, at)).sqrt() / UPWARD
        };
        let norms: Vec<f64> = (0..motions.len()).map(own).collect();
        let coupled = |k: usize| -> f64 {
            let others = (0..motions.len()).filter(|j| *j != k);
            let share = |j: usize| mass.upper(first + k, first + j) / norms[k] / norms[j];
            others.map(share).sum()
        };
        let least = 1.0 - (0..motions.len()).map(coupled).fold(0.0, f64::max) * UPWARD;
        let size = |motion: &Vec<DoubleDouble>| {
            let sizes = motion.iter().map(|x| x.to_f64().abs());
            sizes.fold(0.0, f64::max)
        };
        let reach = motions.iter().zip(&norms).map(|(d, norm)| size(d) / norm);
        let skew = least.sqrt().recip() * UPWARD;
        (least > 0.25).then_some(Drifting {
            largest: reach.sum::<f64>() * skew * UPWARD,
            norms,
            first,
            skew,
        })
    }

    /// A bound of the size by M of what a column holds of them, given how much M couples it with each.
    fn left_of(&self, column: usize, upper: &dyn Fn(usize, usize) -> f64) -> f64 {
        let each = self.norms.iter().enumerate();
        let share = |(k, norm): (usize, &f64)| upper(column, self.first + k) / norm;
        each.map(share).sum::<f64>() * self.skew * UPWARD
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
    /// y_iᵀAx_j, x_j perhaps conjugated, and a bound of its error.
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
    pub(super) fn rho_of(&self, column: Column) -> ComplexDoubleDouble {
        let rho = self.rho[column.pair];
        if column.conjugate { rho.conj() } else { rho }
    }

    /// Where the column of a pair or its conjugate stands; real ones have no other.
    pub(super) fn place(&self, pair: usize, conjugate: bool) -> usize {
        let own = self.places[pair];
        let next = self.columns.get(own + 1);
        let has_two = next.is_some_and(|next| next.pair == pair);
        own + usize::from(conjugate && has_two)
    }

    /// The column that has nearly the same shape: of the conjugate, or of another real root.
    pub(super) fn twin(&self, at: usize) -> Option<usize> {
        let Column { pair, conjugate } = self.columns[at];
        let other = self.place(pair, !conjugate);
        match self.twin[pair] {
            Some(twin) => Some(self.place(twin, false)),
            None => Some(other).filter(|other| *other != at),
        }
    }

    /// a_jl − ρ b_jl of two columns.
    pub(super) fn shifted(&self, j: usize, l: usize, rho: ComplexDoubleDouble) -> c64 {
        let (row, other) = (self.columns[j], self.columns[l]);
        let place = self.place(other.pair, row.conjugate != other.conjugate);
        let (h, b) = (self.rows[row.pair].h[place], self.rows[row.pair].b[place]);
        let turn = |z: c64| if row.conjugate { z.conj() } else { z };
        turn(h) + plain(self.rho_of(row) - rho) * turn(b)
    }

    pub(super) fn own_of(&self, column: Column) -> c64 {
        let own = self.rows[column.pair].own;
        if column.conjugate { own.conj() } else { own }
    }

    /// h_ii, and the sums of all others and of e over a row.
    pub(super) fn sums(&self, i: usize) -> (f64, f64, f64) {
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

    /// The largest radius, relative to its root; more than 1 where the rows bound none.
    pub(super) fn spread(&self) -> f64 {
        self.reaches().map(|root| root.relative).fold(0.0, f64::max)
    }

    /// The same without real roots that are separated from all others by being so small.
    pub(super) fn spread_of_distinguished(&self) -> f64 {
        const KNOWN: f64 = 1e-3;
        let all: Vec<Reach> = self.reaches().collect();
        let known = all.iter().filter(|root| root.relative <= KNOWN);
        let least = known
            .map(|root| root.size)
            .filter(|size| *size > 0.0)
            .fold(f64::INFINITY, f64::min);
        let is_hidden = |i: usize| {
            let Reach { size, radius, .. } = all[i];
            least.is_finite() && self.is_real(i) && size + radius <= KNOWN * least
        };
        let distinguished = (0..all.len()).filter(|i| !is_hidden(*i));
        distinguished.map(|i| all[i].relative).fold(0.0, f64::max)
    }

    /// Whether the root of a pair is one of those at 0 that are only counted, or counted with them.
    pub(super) fn is_counted(&self, pair: usize) -> bool {
        self.origins[pair].is_counted()
    }

    fn is_real(&self, pair: usize) -> bool {
        self.place(pair, true) == self.place(pair, false)
    }

    /// How far each root is known; of those at 0 or not distinguished from it, nothing is asked.
    fn reaches(&self) -> impl Iterator<Item = Reach> {
        (0..self.rows.len()).map(|i| {
            let (own, others, mixed) = self.sums(i);
            let size = self.rho[i].norm();
            let radius = own + others;
            let hidden = matches!(self.origins[i], Origin::Hidden(_));
            let unbounded = |relative: f64| Reach {
                size,
                radius: f64::INFINITY,
                relative,
            };
            if radius.is_nan() || mixed.is_nan() {
                unbounded(f64::INFINITY)
            } else if mixed > 0.25 {
                unbounded(1.0 + mixed)
            } else if size == 0.0 || self.is_counted(i) || hidden {
                Reach {
                    size: 0.0,
                    radius: 0.0,
                    relative: 0.0,
                }
            } else {
                let relative = radius / size;
                Reach {
                    size,
                    radius,
                    relative,
                }
            }
        })
    }
}

/// The size of a root, the radius of its disc, and what part of the size this is: more than 1 where there is none.
struct Reach {
    size: f64,
    radius: f64,
    relative: f64,
}
