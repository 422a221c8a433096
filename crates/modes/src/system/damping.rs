//! Damping as engineers state it: in proportion to masses and springs, or by ratios of the undamped modes.

use std::cmp::Ordering;

use eigentone_digits::{DoubleDouble, Real};

use super::BuildError;
use super::condensed::{Condensed, dense};
use crate::exact::matrix::ExactMatrix;
use crate::exact::null_space::{NullVector, null_space};
use crate::exact::sum::ExactSum;
use crate::linear::wide::{Number, Rows, modes, parts, solve};
use crate::model::{
    Element, Form, GROUND, MatrixKind, Model, MoreDamping, Node, Square, Term, gathered, product,
};
use crate::structure::symmetric::is_symmetric;

/// More coordinates than this take minutes with so many digits.
const MOST: usize = 200;

/// αM + βK as it was given.
#[derive(Clone, Debug)]
pub(super) struct Rayleigh {
    pub(super) of_mass: f64,
    pub(super) of_stiffness: f64,
    pub(super) relative_to: Option<String>,
}

/// Ratios of the undamped modes as they were given.
#[derive(Clone, Debug)]
pub(super) struct ModalRatios {
    pub(super) ratios: Vec<f64>,
    pub(super) relative_to: Option<String>,
    /// Whether some thirty digits are enough.
    pub(super) in_double_double: bool,
}

/// What moves when a support does.
struct Follow {
    support: usize,
    /// Row and part of how far it follows.
    motion: Vec<(usize, f64)>,
}

impl Rayleigh {
    /// What it adds to a model. Products are kept in two doubles each; those of one spring or mass have its sign, so that
    /// what is known of springs that push is known of their dampers.
    pub(super) fn of(&self, model: &Model) -> Result<MoreDamping, BuildError> {
        for value in [self.of_mass, self.of_stiffness] {
            check(value)?;
        }
        let mut more = MoreDamping::default();
        let elements = |factor: f64, element: Element| -> Result<_, BuildError> {
            let parts = parallel(factor, element.coefficient)?.into_iter();
            Ok(parts.map(move |coefficient| Element {
                coefficient,
                ..element
            }))
        };
        for spring in model.springs() {
            more.dampers.extend(elements(self.of_stiffness, *spring)?);
        }
        for (i, &coefficient) in model.masses().iter().enumerate() {
            let (first, second) = (Node::Ground, Node::Coordinate(i));
            let mass = Element {
                first,
                second,
                coefficient,
            };
            more.dampers.extend(elements(self.of_mass, mass)?);
        }
        let follow = Follow::of(model, self.relative_to.as_deref())?;
        for (factor, kind) in [
            (self.of_mass, MatrixKind::Mass),
            (self.of_stiffness, MatrixKind::Stiffness),
        ] {
            // A mass that a support carries does not move relative to the motion that follows it.
            let carried = |support: usize| {
                let followed = follow.as_ref().map(|follow| follow.support);
                kind == MatrixKind::Mass && followed == Some(support)
            };
            let coupling = model.coupling(kind).iter().copied();
            let coupling = times(factor, coupling.filter(|term| !carried(term.column)))?;
            let between = model.between_supports(kind).iter().copied();
            let between = between.filter(|term| !carried(term.row) && !carried(term.column));
            more.between_supports.extend(times(factor, between)?);
            if let Some(follow) = &follow
                && kind == MatrixKind::Mass
            {
                more.between_supports.extend(follow.against(&coupling)?);
            }
            more.coupling.extend(coupling);
            let Some(squares) = model.added_whole(kind).squares() else {
                more.is_given |= factor != 0.0;
                more.terms.extend(times(factor, model.added_terms(kind))?);
                continue;
            };
            for square in squares {
                for coefficient in parallel(factor, square.coefficient)? {
                    let form = Form {
                        coordinates: square.form.clone(),
                        supports: Vec::new(),
                    };
                    let [own, ..] = form.terms(coefficient).ok_or(BuildError::DampingRange)?;
                    more.terms.extend(own);
                    more.squares.push(Square {
                        coefficient,
                        form: form.coordinates,
                    });
                }
            }
        }
        if let Some(follow) = follow {
            let against = times(-self.of_mass, model.terms(MatrixKind::Mass))?;
            let coupling = follow.force(&against)?;
            more.between_supports.extend(follow.against(&coupling)?);
            more.coupling.extend(coupling);
        }
        Ok(more)
    }
}

impl ModalRatios {
    /// What it adds to a model: MΦ diag(2ζω) ΦᵀM, each entry as three doubles, or as two where double-doubles do.
    pub(super) fn of(&self, model: &Model) -> Result<MoreDamping, BuildError> {
        match self.in_double_double {
            true => self.with_digits::<DoubleDouble>(model),
            false => self.with_digits::<Number>(model),
        }
    }

    fn with_digits<T: Real>(&self, model: &Model) -> Result<MoreDamping, BuildError> {
        let Some(&last) = self.ratios.last() else {
            return Err(BuildError::NoRatios);
        };
        for &ratio in &self.ratios {
            check(ratio)?;
        }
        let n = model.len();
        if n > MOST {
            return Err(BuildError::ModalSize {
                count: n,
                most: MOST,
            });
        }
        let no_modes = |reason| BuildError::NoModes { reason };
        let kinds = [MatrixKind::Mass, MatrixKind::Stiffness];
        if !kinds.into_iter().all(|kind| is_symmetric(model, kind)) {
            return Err(no_modes("M or K is not symmetric"));
        }
        let zero = T::ZERO;
        let Condensed {
            massless,
            massive,
            mass,
            stiffness,
            ..
        } = Condensed::<T>::of(model)
            .ok_or(no_modes("springs do not hold the coordinates without mass"))?;
        let found = modes(&mass, &stiffness);
        let (squares, forces) = found.ok_or(no_modes("M is not positive definite"))?;
        let (count, modes) = (self.ratios.len(), squares.len());
        if count > modes.max(1) {
            return Err(BuildError::ManyRatios { count, modes });
        }
        let rigid = rigid_motions(model, &massless, &massive);
        let zeta = |r: usize| self.ratios.get(r).copied().unwrap_or(last);
        let mut matrix: Rows<T> = vec![vec![zero; massive.len()]; massive.len()];
        for (r, (&square, force)) in squares.iter().zip(&forces).enumerate() {
            if square < zero {
                return Err(no_modes("K is not positive semidefinite"));
            }
            if r < rigid.len() {
                continue;
            }
            if let (Some(&next), Some(&largest)) = (squares.get(r + 1), squares.last())
                && next - square <= largest.scale(i64::from(T::UNIT_LOG2.max(-222)) + 22)
                && zeta(r) != zeta(r + 1)
                && next != zero
            {
                let frequency = square.sqrt().to_f64();
                return Err(BuildError::EqualModes {
                    mode: r,
                    frequency,
                    ratios: [zeta(r), zeta(r + 1)],
                });
            }
            let rate = T::from(2.0 * zeta(r)) * square.sqrt();
            for (i, x) in force.iter().enumerate() {
                let factor = rate * *x;
                for (entry, y) in matrix[i][..=i].iter_mut().zip(force) {
                    *entry = *entry + factor * *y;
                }
            }
        }
        // What only rounding keeps from 0 is 0: parts that move by themselves stay apart.
        let sizes: Vec<T> = (0..massive.len())
            .map(|i| matrix[i][i].abs().sqrt())
            .collect();
        let rounding = i64::from(T::UNIT_LOG2) + 24;
        let mut terms: Vec<Term> = Vec::new();
        for (i, row) in matrix.iter().enumerate() {
            for (j, entry) in row[..=i].iter().enumerate() {
                if i != j && entry.abs() <= (sizes[i] * sizes[j]).scale(rounding) {
                    continue;
                }
                let (row, column) = (massive[i], massive[j]);
                for value in parts(*entry) {
                    terms.push(Term { row, column, value });
                    if i != j {
                        let (row, column) = (column, row);
                        terms.push(Term { row, column, value });
                    }
                }
            }
        }
        let terms = without(terms, &rigid, n).ok_or(BuildError::DampingRange)?;
        if terms.iter().any(|term| !term.value.is_finite()) {
            return Err(BuildError::DampingRange);
        }
        let mut more = MoreDamping {
            ratios: (!terms.is_empty()).then(|| self.ratios.clone()),
            is_given: true,
            ..MoreDamping::default()
        };
        if let Some(follow) = Follow::of(model, self.relative_to.as_deref())? {
            let against: Vec<Term> = terms
                .iter()
                .map(|term| Term {
                    value: -term.value,
                    ..*term
                })
                .collect();
            more.coupling = follow.force(&against)?;
            more.between_supports = follow.against(&more.coupling)?;
        }
        more.terms = terms;
        Ok(more)
    }
}

/// A basis of the motions that need no force, of the coordinates with mass; none where they are not all exact, or a basis of
/// them needs coordinates without mass.
fn rigid_motions(model: &Model, massless: &[usize], massive: &[usize]) -> Vec<NullVector> {
    let order: Vec<usize> = massless.iter().chain(massive).copied().collect();
    let mut places = vec![0; order.len()];
    order
        .iter()
        .enumerate()
        .for_each(|(place, i)| places[*i] = place);
    // Columns that come late are the ones that are left free.
    let terms = model.terms(MatrixKind::Stiffness);
    let moved = terms.map(|term| (places[term.row], places[term.column], term.value));
    let matrix = ExactMatrix::from_parts(order.len(), moved.collect());
    let mut found = null_space(&matrix).unwrap_or_default();
    if found.iter().any(|vector| vector.place < massless.len()) {
        return Vec::new();
    }
    for vector in &mut found {
        vector.place = order[vector.place];
        vector.entries.retain(|(place, _)| *place >= massless.len());
        vector
            .entries
            .iter_mut()
            .for_each(|(place, _)| *place = order[*place]);
    }
    found
}

/// PᵀCP, which P = 1 − R Eᵀ makes annul the rigid motions R exactly, E being 1 at their places; but for rounding it is C.
/// The rest of C stays, and what stands in rows and columns of those places follows from it.
fn without(terms: Vec<Term>, rigid: &[NullVector], n: usize) -> Option<Vec<Term>> {
    let mut moves: Vec<Vec<(usize, f64)>> = vec![Vec::new(); n];
    for vector in rigid {
        for &(i, part) in vector.entries.iter().filter(|(i, _)| *i != vector.place) {
            moves[i].push((vector.place, part));
        }
    }
    let is_place = |i: usize| rigid.iter().any(|vector| vector.place == i);
    let stays = |term: &Term| term.value != 0.0 && !is_place(term.row) && !is_place(term.column);
    let mut all: Vec<Term> = terms.into_iter().filter(stays).collect();
    let times = |terms: &[Term], turned: bool| {
        let mut found = Vec::new();
        for term in terms {
            let Term { row, column, .. } = *term;
            for &(place, part) in &moves[if turned { row } else { column }] {
                let (row, column) = match turned {
                    true => (place, column),
                    false => (row, place),
                };
                let parts = product(-term.value, part)?;
                found.extend(parts.map(|value| Term { row, column, value }));
            }
        }
        Some(gathered(found))
    };
    let beside = times(&all, false)?;
    let within = times(&beside, true)?;
    let across = beside.iter().map(|term| Term {
        row: term.column,
        column: term.row,
        ..*term
    });
    all.extend(across.collect::<Vec<_>>());
    all.extend(beside);
    all.extend(within);
    Some(all)
}

impl Follow {
    /// `None` for the ground.
    fn of(model: &Model, support: Option<&str>) -> Result<Option<Follow>, BuildError> {
        let Some(name) = support.filter(|name| *name != GROUND) else {
            return Ok(None);
        };
        let supports = model.supports();
        let Some(support) = supports.iter().position(|support| support == name) else {
            return Err(BuildError::NotASupport {
                name: name.to_owned(),
                known: supports.join(", "),
            });
        };
        // K·1 + K_s.
        let n = model.len();
        let mut sums: Vec<Vec<f64>> = vec![Vec::new(); n];
        for term in model.terms(MatrixKind::Stiffness) {
            sums[term.row].push(term.value);
        }
        let coupling = model.coupling(MatrixKind::Stiffness);
        let own = || coupling.iter().filter(|term| term.column == support);
        for term in own() {
            sums[term.row].push(term.value);
        }
        let is_zero = |terms: &Vec<f64>| ExactSum::sign_of(terms) == Ordering::Equal;
        if sums.iter().all(is_zero) {
            let motion = (0..n).map(|i| (i, 1.0)).collect();
            return Ok(Some(Follow { support, motion }));
        }
        if n > MOST {
            return Err(BuildError::FollowSize {
                count: n,
                most: MOST,
            });
        }
        let mut right: Rows<Number> = vec![vec![Number::ZERO]; n];
        for term in own() {
            right[term.row][0] = right[term.row][0] - Number::from(term.value);
        }
        let solved = solve(dense(model, MatrixKind::Stiffness), right);
        let solved = solved.ok_or_else(|| BuildError::NotHeld {
            name: name.to_owned(),
        })?;
        let each = solved.into_iter().enumerate();
        let motion = each.flat_map(|(i, row)| parts(row[0]).map(|part| (i, part)));
        let motion: Vec<(usize, f64)> = motion.filter(|(_, part)| *part != 0.0).collect();
        match motion.iter().all(|(_, part)| part.is_finite()) {
            true => Ok(Some(Follow { support, motion })),
            false => Err(BuildError::DampingRange),
        }
    }

    /// What couples the coordinates to supports, as the support that is followed takes it up: both ways, but for what couples
    /// them to itself.
    fn against(&self, coupling: &[Term]) -> Result<Vec<Term>, BuildError> {
        let mut taken = Vec::new();
        let sizes = coupling.iter().map(|term| term.value.abs());
        let least = self.least(sizes.fold(0.0, f64::max));
        for &Term { row, column, value } in coupling {
            let first = self.motion.partition_point(|(i, _)| *i < row);
            let parts = self.motion[first..].iter().take_while(|(i, _)| *i == row);
            for &(_, part) in parts {
                for value in kept(-value, part, least)? {
                    let (row, column) = (self.support, column);
                    taken.push(Term { row, column, value });
                    if row != column {
                        let (row, column) = (column, row);
                        taken.push(Term { row, column, value });
                    }
                }
            }
        }
        Ok(gathered(taken))
    }

    /// Up to where products of the motion with terms up to a size are far below the digits that are kept.
    fn least(&self, size: f64) -> f64 {
        let parts = self.motion.iter().map(|(_, part)| part.abs());
        size * parts.fold(0.0, f64::max) * f64::powi(2.0, -200)
    }

    /// A matrix given by its terms, times this motion.
    fn force(&self, matrix: &[Term]) -> Result<Vec<Term>, BuildError> {
        let mut by_row: Vec<(usize, f64)> = Vec::new();
        let mut starts: Vec<usize> = Vec::new();
        for &(i, part) in &self.motion {
            starts.resize(i + 1, by_row.len());
            by_row.push((i, part));
        }
        let at = |i: usize| {
            let start = starts.get(i).copied().unwrap_or(by_row.len());
            by_row[start..].iter().take_while(move |each| each.0 == i)
        };
        let mut force = Vec::new();
        let sizes = matrix.iter().map(|term| term.value.abs());
        let least = self.least(sizes.fold(0.0, f64::max));
        for term in matrix {
            for &(_, part) in at(term.column) {
                let parts = kept(term.value, part, least)?;
                force.extend(parts.map(|value| Term {
                    row: term.row,
                    column: self.support,
                    value,
                }));
            }
        }
        Ok(gathered(force))
    }
}

/// a·b as two doubles; 0 where it leaves their range and is no larger than what counts.
fn kept(a: f64, b: f64, least: f64) -> Result<[f64; 2], BuildError> {
    match product(a, b) {
        None if a.abs() * b.abs() <= least => Ok([0.0; 2]),
        found => found.ok_or(BuildError::DampingRange),
    }
}

fn check(value: f64) -> Result<(), BuildError> {
    match value.is_finite() {
        true => Ok(()),
        false => Err(BuildError::DampingNotFinite { value }),
    }
}

/// a·b as two doubles of its sign, the first rounded towards 0; as one or none where that is all.
fn parallel(a: f64, b: f64) -> Result<Vec<f64>, BuildError> {
    let [mut high, mut low] = product(a, b).ok_or(BuildError::DampingRange)?;
    if high * low < 0.0 {
        let near = match high > 0.0 {
            true => high.next_down(),
            false => high.next_up(),
        };
        // Both differences are exact: the second has no more bits than a product has in its lower half.
        low += high - near;
        high = near;
    }
    Ok([high, low]
        .into_iter()
        .filter(|part| *part != 0.0)
        .collect())
}

fn times(factor: f64, terms: impl Iterator<Item = Term>) -> Result<Vec<Term>, BuildError> {
    let mut all = Vec::new();
    for term in terms {
        let parts = product(factor, term.value).ok_or(BuildError::DampingRange)?;
        all.extend(parts.map(|value| Term { value, ..term }));
    }
    all.retain(|term| term.value != 0.0);
    Ok(all)
}
