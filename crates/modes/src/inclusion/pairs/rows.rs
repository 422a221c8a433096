//! The rows of ZᵀAZ − λZᵀBZ, with bounds of their entries.

use eigentone_digits::{ComplexDoubleDouble, DoubleDouble, Real};
use faer::c64;

use super::pair::{Column, Origin, Pair, Pairs, norm, plain};
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
    /// Whether rows are columns.
    pub(super) is_symmetric: bool,
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
        // What coordinates that follow at once leave of each shape, by the size that K gives it.
        let follow = |columns: &[Vec<DoubleDouble>]| -> Vec<f64> {
            let left = self.inert.left(&forms[2], columns);
            let of = |i: usize| {
                let parts = self.pairs[i].parts();
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
                let parts = self.pairs[i].parts();
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
        let products = Products {
            pairs: &self.pairs,
            places: &places,
            forms: [&mass, &damping, &stiffness],
            count,
            zeros: vec![DoubleDouble::ZERO; count],
        };
        let added = Added {
            follow: [follow_left, &follow_right],
            losses: [&losses_left, &losses_right],
        };
        let found: Option<Vec<_>> = (0..self.pairs.len())
            .map(|i| products.row(i, &added))
            .collect();
        let (rho, rows): (Vec<ComplexDoubleDouble>, Vec<Row>) = found?.into_iter().unzip();
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
            columns: self.columns(),
            values: self.pairs.iter().map(|pair| pair.value).collect(),
            rho,
            rows,
            tau,
            drift,
            origins,
            twin: self.twins(&mass, &places),
            places,
            is_symmetric: left.is_none(),
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

/// What is added to the errors of entries (i, j): the products of numbers of i on the left and of j on the right.
struct Added<'a> {
    /// To those of yᵀKx.
    follow: [&'a [f64]; 2],
    /// To those of yᵀMx.
    losses: [&'a [f64]; 2],
}

/// Rows of complex columns from products of real ones.
struct Products<'a> {
    pairs: &'a [Pair],
    places: &'a [usize],
    /// Of M, C and K.
    forms: [&'a Gram; 3],
    /// How many real columns there are.
    count: usize,
    /// What real shapes have in place of an imaginary part.
    zeros: Vec<DoubleDouble>,
}

/// Complex numbers for all real columns, real parts before imaginary ones.
type Complex = [Vec<DoubleDouble>; 2];

impl<'a> Products<'a> {
    /// ρ_i and row i: with u_ij = y_iᵀ(C + λ_iM)x_j, b_ij = −(u_ij + λ_j y_iᵀMx_j) and
    ///
    /// a_ij − ρ_ib_ij = y_iᵀKx_j + ρ_iu_ij + (ρ_i − λ_i)λ_j y_iᵀMx_j,
    ///
    /// the last term of which is as small as the correction of λ_i, so that doubles hold enough of it. All but that is found
    /// for real columns first. `None` where a shape has no root.
    fn row(&self, i: usize, added: &Added<'_>) -> Option<(ComplexDoubleDouble, Row)> {
        let pair = &self.pairs[i];
        let [mass, damping, stiffness] = self.forms.map(|gram| self.of_left(gram, i));
        let mut u = damping.map(<[_]>::to_vec);
        add_multiple(&mut u, pair.value, mass);
        let mut b = u.clone();
        self.add_by_column(&mut b, mass);
        let mut rest = stiffness.map(<[_]>::to_vec);
        self.clear_at_rest(&mut rest, i);
        let own = Column {
            pair: i,
            conjugate: false,
        };
        let of_own = -self.at(b.each_ref().map(|part| &part[..]), own);
        if of_own.norm() == 0.0 {
            return None;
        }
        let mut rho = ComplexDoubleDouble::ZERO;
        if pair.value.norm() > 0.0 {
            let square = pair.value * pair.value;
            let of_stiffness = self.at(rest.each_ref().map(|part| &part[..]), own);
            rho = (of_stiffness - square * self.at(mass, own)) / of_own;
        }
        if pair.is_real() {
            rho.im = DoubleDouble::ZERO;
        }
        if !rho.is_finite() {
            return None;
        }
        add_multiple(&mut rest, rho, u.each_ref().map(|part| &part[..]));
        let step = plain(rho - pair.value);
        let (fast, known, moved) = (pair.value.norm(), rho.norm(), norm(step));
        let size = of_own.norm() / UPWARD;
        let mut row = Row {
            h: Vec::with_capacity(self.count),
            b: Vec::with_capacity(self.count),
            reach: Vec::with_capacity(self.count),
            mixed: Vec::with_capacity(self.count),
            own: plain(of_own),
        };
        for (j, other) in self.pairs.iter().enumerate() {
            let [(m, m_error), (c, c_error), (k, k_error)] =
                self.forms.map(|gram| self.sizes(gram, i, j));
            let (k, k_error) = match self.is_at_rest(i) || self.is_at_rest(j) {
                true => (0.0, 0.0),
                false => (k, k_error),
            };
            let m_error = m_error + added.losses[0][i] * added.losses[1][j];
            let k_error = k_error + added.follow[0][i] * added.follow[1][j];
            let speed = other.value.norm();
            let (sum, by_step) = (fast + speed, moved * speed);
            let b_size = c + sum * m;
            let b_error = (c_error + sum * m_error + ROUNDING * b_size) * UPWARD;
            let in_doubles = 2f64.powi(-49) * by_step * m;
            let by_mass = (known * fast + by_step) * m_error;
            let h_error = k_error + known * c_error + by_mass + in_doubles;
            let h_error = (h_error + ROUNDING * (k + known * b_size)) * UPWARD;
            for conjugate in [false, true].into_iter().take(other.parts()) {
                let column = Column { pair: j, conjugate };
                let at = |row: [&[DoubleDouble]; 2]| plain(self.at(row, column));
                let value = plain(other.value);
                let value = if conjugate { value.conj() } else { value };
                let h = at([&rest[0], &rest[1]]) + step * value * at(mass);
                let b = -at([&b[0], &b[1]]);
                let mixed = if column == own { 0.0 } else { norm(b) };
                row.reach.push((norm(h) + h_error) / size);
                row.mixed.push((mixed + b_error) / size);
                row.h.push(h);
                row.b.push(b);
            }
        }
        Some((rho, row))
    }

    /// y_iᵀA for all real columns, real parts before imaginary ones.
    fn of_left(&self, gram: &'a Gram, i: usize) -> [&[DoubleDouble]; 2] {
        let row = |at: usize| &gram.row(self.places[i] + at)[..self.count];
        let is_real = self.pairs[i].is_real();
        [row(0), if is_real { &self.zeros } else { row(1) }]
    }

    /// The entry of a complex column.
    #[inline]
    fn at(&self, [re, im]: [&[DoubleDouble]; 2], column: Column) -> ComplexDoubleDouble {
        let place = self.places[column.pair];
        let (mut re_part, mut im_part) = (re[place], im[place]);
        if !self.pairs[column.pair].is_real() {
            let (re, im) = (re[place + 1], im[place + 1]);
            if column.conjugate {
                (re_part, im_part) = (re_part + im, im_part - re);
            } else {
                (re_part, im_part) = (re_part - im, im_part + re);
            }
        }
        ComplexDoubleDouble {
            re: re_part,
            im: im_part,
        }
    }

    /// Adds λ_j times the entries of column j, for all of them.
    fn add_by_column(&self, to: &mut Complex, of: [&[DoubleDouble]; 2]) {
        for (to, of) in to.iter_mut().zip(of) {
            for (pair, &at) in self.pairs.iter().zip(self.places) {
                let ComplexDoubleDouble { re, im } = pair.value;
                to[at] += re * of[at];
                if !pair.is_real() {
                    to[at] -= im * of[at + 1];
                    to[at + 1] += re * of[at + 1] + im * of[at];
                }
            }
        }
    }

    /// Motions at rest strain no spring.
    fn clear_at_rest(&self, of_stiffness: &mut Complex, i: usize) {
        for part in of_stiffness {
            for (pair, &place) in self.places.iter().enumerate() {
                if self.is_at_rest(i) || self.is_at_rest(pair) {
                    part[place..place + self.pairs[pair].parts()].fill(DoubleDouble::ZERO);
                }
            }
        }
    }

    fn is_at_rest(&self, pair: usize) -> bool {
        self.pairs[pair].origin == Origin::Rest
    }

    /// The sums of the sizes and of the errors of all real products that y_iᵀAx_j consists of.
    fn sizes(&self, gram: &Gram, i: usize, j: usize) -> (f64, f64) {
        let (mut size, mut error) = (0.0, 0.0);
        for p in (self.places[i]..).take(self.pairs[i].parts()) {
            for q in (self.places[j]..).take(self.pairs[j].parts()) {
                size += gram.at(p, q).to_f64().abs();
                error += gram.error(p, q);
            }
        }
        (size, error)
    }
}

/// Adds factor times the entries.
fn add_multiple(to: &mut Complex, factor: ComplexDoubleDouble, [re, im]: [&[DoubleDouble]; 2]) {
    let [to_re, to_im] = to;
    DoubleDouble::add_multiples(to_re, &[(factor.re, re), (-factor.im, im)]);
    DoubleDouble::add_multiples(to_im, &[(factor.re, im), (factor.im, re)]);
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
