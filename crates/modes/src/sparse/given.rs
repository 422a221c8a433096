//! Eigenpairs that another program found: which modes they stand for, and how far those may be off.
//!
//! Where the equation has a factor of a size that is allowed, shapes are refined and undamped modes are counted as if
//! they had been found here. Beyond that eigenvalues are Rayleigh quotients in double-double. Of K x = θM x a
//! residual ρ = ‖Kx − θMx‖ in the norm of M⁻¹, with ‖x‖_M = 1, has an eigenvalue within ρ of θ, and within ρ²/γ where
//! no other lies within γ (Parlett 1998, *The Symmetric Eigenvalue Problem*, theorem 11.7.1).

use eigentone_digits::{DoubleDouble, Real};
use num_complex::Complex;

use super::answer::{Answer, Root, keep_nearest};
use super::basis::dot;
use super::coupled;
use super::damped;
use super::eigenpair::Eigenpair;
use super::error::SparseError;
use super::form::Form;
use super::newton;
use super::operator::Rigid;
use super::pencil::Pencil;
use super::refine::{self, Pair};
use super::search::{self, Vector};
use super::setting::{self, Setting};
use super::undamped::{Facts, Undamped};
use crate::model::MatrixKind;
use crate::modes::{Frequency, ModePlan, Modes, Repeats};
use crate::system::System;

/// What eigenpairs of another program are.
#[derive(Clone, Debug)]
pub struct ExaminedPairs {
    /// The modes that they stand for, with residuals, conditions and bounds.
    pub modes: Modes,
    /// How many pairs are no modes: not finite, 0, found twice, or with a residual that leaves no digit.
    pub unfit: usize,
    /// How many undamped modes a count found missing, which were then found here.
    pub missing: usize,
}

/// The modes that approximate eigenpairs of λ²M + λC + K stand for: as many as are wanted, those whose natural frequency
/// |λ| is nearest to `target`. Of undamped systems and of Rayleigh damping only shapes count, and give all roots they
/// belong to; else a pair stands for its conjugate as well.
///
/// Nothing is taken on trust. Each root is a Rayleigh quotient in double-double, its bound an estimate
/// from its residual; give one pair more than is wanted, so that the last one has a neighbour. Where the factor of
/// λ²M + λC + K has at most `entries` entries below its diagonal, shapes are refined to the last digits first, undamped
/// modes are counted, and those found missing are looked for; [`Modes::is_complete`] tells whether none is missing. Without
/// a factor, bounds suppose that no mode is missing between those that are given. Motions that no spring holds are
/// known without being given.
///
/// # Errors
/// [`SparseError::ShapeLength`], [`SparseError::NotSymmetric`], [`SparseError::NoMass`], [`SparseError::MassNotDefinite`],
/// [`SparseError::Target`], [`SparseError::NoneWanted`] and [`SparseError::TooManyParts`].
pub fn examine_pairs(
    system: &System,
    target: Frequency,
    count: usize,
    pairs: Vec<Eigenpair>,
    entries: usize,
) -> Result<ExaminedPairs, SparseError> {
    let target = target.radians_per_second();
    if !(target >= 0.0 && (target * target).is_finite()) {
        return Err(SparseError::Target { target });
    }
    if count == 0 {
        return Err(SparseError::NoneWanted);
    }
    let expected = system.len();
    if let Some(pair) = pairs.iter().find(|pair| pair.shape.len() != expected) {
        let given = pair.shape.len();
        return Err(SparseError::ShapeLength { given, expected });
    }
    let form = |kind| Form::of(system, kind).ok_or(SparseError::NotSymmetric { kind });
    let mass = form(MatrixKind::Mass)?;
    let damping = form(MatrixKind::Damping)?;
    let stiffness = form(MatrixKind::Stiffness)?;
    if mass.is_zero() {
        return Err(SparseError::NoMass);
    }
    let all = pairs.len();
    let sound = |pair: &Eigenpair| {
        let entries = pair.shape.iter();
        let largest = entries.map(|x| x.l1_norm()).fold(0.0, f64::max);
        let whole = pair.shape.iter().all(|x| x.is_finite());
        pair.value.is_finite() && whole && largest > 0.0
    };
    let pairs: Vec<Eigenpair> = pairs.into_iter().filter(sound).collect();
    let broken = all - pairs.len();
    let facts = Facts {
        target,
        count: count.min(expected),
        ..Facts::of(system)
    };
    let given = Given {
        system,
        forms: [&mass, &damping, &stiffness],
        facts,
        entries,
    };
    let examined = match damping.is_zero() || given.facts.proportion.is_some() {
        true => given.uncoupled(pairs)?,
        false => given.coupled(pairs)?,
    };
    let Examined {
        answer,
        unfit,
        missing,
        way,
    } = examined;
    let counted = match answer.complete {
        Ok(()) => "the signs of pivots prove that none between them is missing",
        Err(_) => "that none between them is missing is not proved",
    };
    let plan = ModePlan {
        solver: "pairs of another program",
        reason: way.to_owned(),
        bounds: "estimated from residuals".to_owned(),
        left_out: vec![("other modes", format!("{count} were asked for; {counted}"))],
        incomplete: answer.complete.err(),
    };
    Ok(ExaminedPairs {
        modes: damped::judged(answer.roots, given.forms, &given.facts, plan),
        unfit: broken + unfit,
        missing,
    })
}

struct Given<'a> {
    system: &'a System,
    /// M, C and K.
    forms: [&'a Form; 3],
    facts: Facts,
    entries: usize,
}

struct Examined {
    answer: Answer,
    /// Pairs that were no modes, and modes that were not given.
    unfit: usize,
    missing: usize,
    /// How shapes were improved.
    way: &'static str,
}

const REFINED: &str = "refined with a factor";
const AS_GIVEN: &str = "shapes as they were given";
const NOT_COUNTED: &str = "modes that another program found are not counted";

impl Given<'_> {
    /// Damping that couples no undamped shapes.
    fn uncoupled(&self, pairs: Vec<Eigenpair>) -> Result<Examined, SparseError> {
        /// Residuals that are smaller beside the terms of Kx and θMx are as small as doubles make them, or small enough to be refined.
        const SMALL: f64 = 1e-9;
        const MENDED: f64 = 1e-4;
        /// A larger part leaves no digit.
        const PART: f64 = 0.1;
        let [mass, damping, _] = self.forms;
        let (floating, _) = setting::floating(self.system, mass);
        let rigid = match floating.as_slice() {
            [] => None,
            parts => {
                let count = parts.len();
                Some(Rigid::of(parts, mass).ok_or(SparseError::TooManyParts { count })?)
            }
        };
        let (target, count) = (self.facts.target, self.facts.count);
        let setting = match Setting::of(self.system, target, count, self.entries) {
            Ok(setting) => Some(setting),
            Err(SparseError::TooDense) => None,
            Err(error) => return Err(error),
        };
        let small = if setting.is_some() { MENDED } else { SMALL };
        let (real, mut unfit) = self.real(pairs, rigid.as_ref());
        let (mut ritz, doubles) = self.ritz(real, floating.is_empty(), small);
        unfit += doubles;
        let before = ritz.len();
        ritz.retain(|pair| pair.error.is_some());
        self.keep_apart(&mut ritz);
        unfit += before - ritz.len();
        let refined = setting.and_then(|setting| self.refined(&setting, &ritz).ok());
        let way = if refined.is_some() { REFINED } else { AS_GIVEN };
        let (found, missing) = refined.unwrap_or_else(|| {
            // What is 0 within its bound is a motion that nothing holds.
            let told = |pair: &Pair| {
                let (error, size) = (pair.error.unwrap_or(0.0), pair.square.abs());
                error <= PART * size || error >= size
            };
            let before = ritz.len();
            ritz.retain(told);
            unfit += before - ritz.len();
            let parts = floating.iter().take(count);
            ritz.extend(parts.map(|part| setting::rigid(part, mass)));
            let found = Undamped::nearest(ritz, None, self.facts.clone(), mass.len());
            (found, 0)
        });
        let mut answer = damped::uncoupled(&found, damping).unwrap_or(Answer {
            roots: Vec::new(),
            complete: Ok(()),
        });
        answer.complete = answer.complete.map_err(|_| NOT_COUNTED);
        Ok(Examined {
            answer,
            unfit,
            missing,
            way,
        })
    }

    /// Those that are wanted with all digits, none missing where they can be counted; how many were not given.
    fn refined(&self, setting: &Setting, given: &[Pair]) -> Result<(Undamped, usize), SparseError> {
        /// What is not known so well after refinement was no shape of one mode.
        const PART: f64 = 1e-6;
        let wanted = setting.wanted();
        let sizes = given.iter().map(|pair| pair.square.abs());
        let search = search::begin(&wanted, sizes.fold(0.0, f64::max))?;
        let shift = search.operator.shift;
        let mut vectors: Vec<Vector> = given
            .iter()
            .map(|pair| Vector {
                inverse: 1.0 / (pair.square - shift),
                shape: pair.shape.clone(),
            })
            .collect();
        vectors.sort_by(|a, b| b.inverse.abs().total_cmp(&a.inverse.abs()));
        let mut pairs = refine::refined(&search.operator, vectors, None);
        pairs.retain(|pair| {
            let reach = PART * (pair.square - shift).abs();
            pair.error.is_some_and(|error| error <= reach)
        });
        self.keep_apart(&mut pairs);
        let mut known: Vec<f64> = pairs.iter().map(|pair| pair.square).collect();
        let found = pairs.into_iter().map(|pair| (pair.square, pair.shape));
        let mut answer = search.beside(found.collect())?;
        let all = setting.undamped(self.system, &mut answer);
        let mut missing = 0;
        for square in all.squares.iter().filter(|square| **square != 0.0) {
            let reach = PART * (square - shift).abs();
            match known
                .iter()
                .position(|known| (known - square).abs() <= reach)
            {
                Some(at) => drop(known.swap_remove(at)),
                None => missing += 1,
            }
        }
        Ok((all, missing))
    }

    /// Real shapes of M-norm 1 that span what is given, without rigid motions; and how many pairs have no mass.
    fn real(&self, pairs: Vec<Eigenpair>, rigid: Option<&Rigid>) -> (Vec<Vec<f64>>, usize) {
        /// Less than that of a shape is what rounding has left.
        const REST: f64 = 1e-6;
        /// Parts of a shape that belong to two modes are not as unlike as that.
        const PART: f64 = 1e-3;
        let [mass, ..] = self.forms;
        let mut product = vec![0.0; mass.len()];
        let mut all = Vec::new();
        let mut unfit = 0;
        for pair in pairs {
            let by_size = |a: &&Complex<f64>, b: &&Complex<f64>| a.norm().total_cmp(&b.norm());
            let largest = pair.shape.iter().max_by(by_size).copied();
            let turn = largest.map_or(Complex::ONE, |x| x.conj() / x.norm() / x.norm());
            let part = |of: fn(Complex<f64>) -> f64| -> Vec<f64> {
                pair.shape.iter().map(|x| of(x * turn)).collect()
            };
            let parts = [part(|x| x.re), part(|x| x.im)];
            let norms = parts.each_ref().map(|part| mass.quadratic(part));
            let whole = norms[0] + norms[1];
            if !(whole > 0.0 && whole.is_finite()) {
                unfit += 1;
                continue;
            }
            for (mut shape, norm) in parts.into_iter().zip(norms) {
                if norm <= PART * PART * whole {
                    continue;
                }
                if let Some(rigid) = rigid {
                    mass.apply(&shape, &mut product);
                    rigid.remove(&product, &mut shape);
                }
                let left = mass.quadratic(&shape);
                if left > REST * REST * norm {
                    let length = left.sqrt();
                    shape.iter_mut().for_each(|x| *x /= length);
                    all.push(shape);
                }
            }
        }
        (all, unfit)
    }

    /// Rayleigh quotients with what residuals say of them where those are small, rising in size; and how many shapes there were twice.
    fn ritz(&self, shapes: Vec<Vec<f64>>, held: bool, small: f64) -> (Vec<Pair>, usize) {
        /// Values that near are taken together.
        const NEAR: f64 = 1e-6;
        /// Shapes with less beside the others are one of them.
        const APART: f64 = 1e-3;
        let [mass, _, stiffness] = self.forms;
        let mut rough: Vec<(f64, f64, Vec<f64>)> = shapes
            .into_iter()
            .map(|shape| {
                let square = stiffness.quadratic(&shape);
                let rest = residual(self.forms, &long(&shape), square.into());
                (square, inverse_mass_norm(mass, &rest).unwrap_or(0.0), shape)
            })
            .collect();
        rough.sort_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        let mut groups: Vec<Vec<(f64, f64, Vec<f64>)>> = Vec::new();
        for next in rough {
            let near = |(square, rest, _): &(f64, f64, Vec<f64>)| {
                let reach = NEAR * square.abs().max(next.0.abs());
                (square - next.0).abs() <= reach.max(2.0 * (rest + next.1))
            };
            match groups.last_mut().filter(|group| group.iter().any(near)) {
                Some(group) => group.push(next),
                None => groups.push(vec![next]),
            }
        }
        let mut doubles = 0;
        let mut product = vec![0.0; mass.len()];
        // By groups: values, residuals, shapes.
        let mut found: Vec<Vec<(Pair, f64, f64)>> = Vec::new();
        for group in groups {
            let mut kept: Vec<Vec<f64>> = Vec::new();
            for (_, _, mut shape) in group {
                mass.apply(&shape, &mut product);
                let along = |other: &Vec<f64>| dot(other, &product);
                let alongs: Vec<f64> = kept.iter().map(along).collect();
                for (other, along) in kept.iter().zip(alongs) {
                    let entries = shape.iter_mut().zip(other);
                    entries.for_each(|(x, y)| *x -= along * y);
                }
                let length = mass.quadratic(&shape).max(0.0).sqrt();
                if length > APART {
                    shape.iter_mut().for_each(|x| *x /= length);
                    kept.push(shape);
                } else {
                    doubles += 1;
                }
            }
            let mut vectors: Vec<[Vec<DoubleDouble>; 2]> =
                kept.iter().map(|x| [long(x), Vec::new()]).collect();
            if !refine::ritz(stiffness, mass, &mut vectors) {
                doubles += vectors.len();
                continue;
            }
            found.push(
                vectors
                    .iter()
                    .map(|[x, _]| self.quotient(x, small))
                    .collect(),
            );
        }
        let told = |(pair, ..): &(Pair, f64, f64)| pair.error.is_some();
        let whole = found.iter().flatten().all(told);
        (bounded(found, held, whole), doubles)
    }

    /// Of shapes that are not orthogonal, as those of modes are, keeps that with the least error.
    fn keep_apart(&self, pairs: &mut Vec<Pair>) {
        const ALIKE: f64 = 0.05;
        let [mass, ..] = self.forms;
        let error = |pair: &Pair| pair.error.unwrap_or(f64::INFINITY) / pair.square.abs();
        pairs.sort_by(|a, b| error(a).total_cmp(&error(b)));
        let mut resisted: Vec<Vec<f64>> = Vec::new();
        pairs.retain(|pair| {
            let alike = |other: &Vec<f64>| dot(other, &pair.shape).abs() > ALIKE;
            let apart = !resisted.iter().any(alike);
            if apart {
                let mut product = vec![0.0; mass.len()];
                mass.apply(&pair.shape, &mut product);
                resisted.push(product);
            }
            apart
        });
    }

    /// θ = xᵀKx of a shape of M-norm 1, with ρ, infinite where M says nothing of it, and what rounding adds.
    fn quotient(&self, x: &[DoubleDouble], small: f64) -> (Pair, f64, f64) {
        let [mass, _, stiffness] = self.forms;
        let (energy, of_energy) = stiffness.quadratic_long(x);
        let (norm, of_norm) = mass.quadratic_long(x);
        let square = (energy / norm).to_f64();
        let rounding = of_energy + of_norm * square.abs() + f64::EPSILON * square.abs();
        let rest = residual(self.forms, x, square.into());
        let rest = inverse_mass_norm(mass, &rest).unwrap_or(f64::INFINITY);
        let sizes = stiffness.sizes().into_iter().zip(mass.sizes()).zip(x);
        let terms = sizes.map(|((k, m), x)| (k + square.abs() * m) * x.high() * x.high());
        let told = rest <= 0.1 * square.abs() || rest <= small * terms.sum::<f64>();
        let pair = Pair {
            square,
            shape: x.iter().map(|x| x.to_f64()).collect(),
            error: told.then_some(f64::INFINITY),
        };
        (pair, rest, rounding)
    }

    /// Damping that couples shapes.
    fn coupled(&self, pairs: Vec<Eigenpair>) -> Result<Examined, SparseError> {
        let [mass, damping, stiffness] = self.forms;
        let (target, count) = (self.facts.target, self.facts.count);
        let (floating, _) = setting::floating(self.system, mass);
        let still = floating.iter().map(|part| setting::rigid(part, mass));
        let still = Undamped::nearest(
            still.collect(),
            None,
            Facts {
                target: 0.0,
                ..self.facts.clone()
            },
            mass.len(),
        );
        let zeros = coupled::zeros(&still, damping);
        let (mut groups, mut unfit) = grouped(pairs, self.forms, zeros.roots);
        let apart = |group: &Vec<Eigenpair>| (group[0].value.norm() - target).abs();
        groups.sort_by(|a, b| apart(a).total_cmp(&apart(b)));
        let own = Pencil::within(
            self.entries,
            stiffness.clone(),
            damping.clone(),
            mass.clone(),
        );
        let mut roots: Vec<Root> = zeros.entries();
        for group in groups {
            let measured = newton::measured(self.forms, group);
            let (told, lost): (Vec<_>, Vec<_>) =
                measured.into_iter().partition(|root| root.error.is_some());
            unfit += lost.len();
            let improved = own.as_ref().map(|pencil| {
                let pair = |root: &newton::Root| Eigenpair {
                    value: root.value,
                    shape: root.shape.clone(),
                };
                newton::refined(pencil, told.iter().map(pair).collect())
            });
            // What does not converge keeps what its residual says.
            let best = match improved {
                Some(roots) if roots.iter().all(|root| root.error.is_some()) => roots,
                _ => told,
            };
            for root in coupled::settled(best, self.facts.passive) {
                let error = |root: &Root| root.error.map_or(0.0, |(whole, _)| whole);
                let same =
                    |other: &Root| (other.value - root.value).norm() <= error(other) + error(&root);
                // Of one group they are a cluster; of two, one root that was reached twice.
                let cluster = matches!(root.repeats, Repeats::Cluster(_));
                match cluster || !roots.iter().any(same) {
                    true => roots.push(root),
                    false => unfit += 1,
                }
            }
        }
        keep_nearest(&mut roots, target, count);
        let complete = Err(NOT_COUNTED);
        Ok(Examined {
            answer: Answer { roots, complete },
            unfit,
            missing: 0,
            way: if own.is_some() { REFINED } else { AS_GIVEN },
        })
    }
}

/// Pairs with Im λ ≥ 0, those together that nearly coincide, without those at 0 and without shapes that others of their
/// group have; and how many the latter are.
fn grouped(pairs: Vec<Eigenpair>, forms: [&Form; 3], zeros: usize) -> (Vec<Vec<Eigenpair>>, usize) {
    const SMALL: f64 = 1e-6;
    const APART: f64 = 1e-3;
    let [mass, _, stiffness] = forms;
    let largest = pairs
        .iter()
        .map(|pair| pair.value.norm())
        .fold(0.0, f64::max);
    let weights: Vec<f64> = stiffness
        .diagonal()
        .into_iter()
        .zip(mass.diagonal())
        .map(|(k, m)| k.abs() + largest * largest * m.abs())
        .collect();
    let product = |x: &[Complex<f64>], y: &[Complex<f64>]| -> Complex<f64> {
        let terms = x.iter().zip(y).zip(&weights);
        terms.map(|((x, y), w)| x.conj() * y * *w).sum()
    };
    let mut pairs = pairs;
    for pair in &mut pairs {
        if pair.value.im < 0.0 {
            pair.value = pair.value.conj();
            pair.shape.iter_mut().for_each(|x| *x = x.conj());
        }
    }
    pairs.sort_by(|a, b| a.value.norm().total_cmp(&b.value.norm()));
    let at_zero = |pair: &Eigenpair| pair.value.norm() <= SMALL * largest;
    let first = pairs
        .iter()
        .take(zeros)
        .take_while(|pair| at_zero(pair))
        .count();
    let mut groups: Vec<Vec<Eigenpair>> = Vec::new();
    for pair in pairs.drain(first..) {
        let reach = newton::NEAR * pair.value.norm();
        let near = |other: &Eigenpair| (other.value - pair.value).norm() <= reach;
        let (joined, mut apart): (Vec<_>, Vec<_>) =
            groups.into_iter().partition(|group| group.iter().any(near));
        let mut group: Vec<Eigenpair> = joined.into_iter().flatten().collect();
        group.push(pair);
        apart.push(group);
        groups = apart;
    }
    let mut doubles = 0;
    for group in &mut groups {
        let mut basis: Vec<Vec<Complex<f64>>> = Vec::new();
        group.retain(|pair| {
            let mut rest = pair.shape.clone();
            let whole = product(&rest, &rest).re.sqrt();
            for other in &basis {
                let along = product(other, &rest);
                let entries = rest.iter_mut().zip(other);
                entries.for_each(|(x, y)| *x -= along * y);
            }
            let length = product(&rest, &rest).re.sqrt();
            let apart = length > APART * whole;
            if apart {
                rest.iter_mut().for_each(|x| *x /= length);
                basis.push(rest);
            }
            doubles += usize::from(!apart);
            apart
        });
    }
    (groups, doubles)
}

/// Errors from residuals and the distances between groups: the first has none below it where `held`, the last an
/// unknown one above. Where one is missing, as not all are `whole`, nothing is known of distances.
fn bounded(found: Vec<Vec<(Pair, f64, f64)>>, held: bool, whole: bool) -> Vec<Pair> {
    let values: Vec<Vec<f64>> = found
        .iter()
        .map(|group| group.iter().map(|(pair, ..)| pair.square).collect())
        .collect();
    let mut all = Vec::new();
    let last = found.len().saturating_sub(1);
    for (k, group) in found.into_iter().enumerate() {
        let joint = group.iter().map(|(_, rest, _)| rest * rest).sum::<f64>();
        for (mut pair, _, rounding) in group {
            let others = values.iter().enumerate().filter(|(j, _)| *j != k);
            let apart = others.flat_map(|(_, squares)| squares);
            let apart = apart.map(|square| (square - pair.square).abs());
            // Rigid motions lie at 0.
            let zero = (!held).then_some(pair.square.abs());
            let gap = apart.chain(zero).fold(f64::INFINITY, f64::min) - joint.sqrt();
            let second = match whole && k < last && gap > 0.0 {
                true => joint / gap,
                false => f64::INFINITY,
            };
            let error = joint.sqrt().min(second) + rounding;
            pair.error = pair.error.and(error.is_finite().then_some(error));
            all.push(pair);
        }
    }
    all
}

fn long(x: &[f64]) -> Vec<DoubleDouble> {
    x.iter().map(|&x| x.into()).collect()
}

/// Kx − θMx.
fn residual(
    [mass, _, stiffness]: [&Form; 3],
    x: &[DoubleDouble],
    square: DoubleDouble,
) -> Vec<f64> {
    let mut product = vec![DoubleDouble::ZERO; x.len()];
    mass.accumulate_long(1.0, x, &mut product);
    product.iter_mut().for_each(|p| *p = -(*p * square));
    stiffness.accumulate_long(1.0, x, &mut product);
    product.into_iter().map(DoubleDouble::to_f64).collect()
}

/// √(rᵀM⁻¹r): by conjugate gradients on M scaled to a unit diagonal (Golub & Van Loan 2013, *Matrix Computations*,
/// §11.3), which sum it up from below, with what a few more digits would add. `None` where M is 0 in a row in which r
/// is not, or that does not converge.
fn inverse_mass_norm(mass: &Form, r: &[f64]) -> Option<f64> {
    const STEPS: usize = 500;
    const DIGITS: f64 = 1e-3;
    let diagonal = mass.diagonal();
    let bare = |(m, r): (&f64, &f64)| *m <= 0.0 && *r != 0.0;
    if diagonal.iter().zip(r).any(bare) {
        return None;
    }
    if mass.is_diagonal() {
        let terms = diagonal.iter().zip(r).filter(|(m, _)| **m > 0.0);
        return Some(terms.map(|(m, r)| r * r / m).sum::<f64>().sqrt());
    }
    let scale: Vec<f64> = diagonal
        .iter()
        .map(|m| if *m > 0.0 { m.sqrt().recip() } else { 0.0 })
        .collect();
    let mut rest: Vec<f64> = r.iter().zip(&scale).map(|(r, s)| r * s).collect();
    let mut direction = rest.clone();
    let (mut along, mut product) = (vec![0.0; r.len()], vec![0.0; r.len()]);
    let mut size = dot(&rest, &rest);
    let first = size;
    let mut sum = 0.0;
    for _ in 0..STEPS {
        if size <= DIGITS * DIGITS * first {
            return Some((sum * (1.0 + 4.0 * DIGITS)).sqrt());
        }
        let scaled = direction.iter().zip(&scale).map(|(d, s)| d * s);
        along.iter_mut().zip(scaled).for_each(|(a, d)| *a = d);
        mass.apply(&along, &mut product);
        let energy = dot(&along, &product);
        if energy <= 0.0 || energy.is_nan() {
            return None;
        }
        let step = size / energy;
        sum += step * size;
        for ((rest, product), s) in rest.iter_mut().zip(&product).zip(&scale) {
            *rest -= step * product * s;
        }
        let before = std::mem::replace(&mut size, dot(&rest, &rest));
        let turn = size / before;
        let entries = direction.iter_mut().zip(&rest);
        entries.for_each(|(d, rest)| *d = *rest + turn * *d);
    }
    None
}
