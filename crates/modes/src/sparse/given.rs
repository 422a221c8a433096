//! Eigenpairs that another program found: which modes they stand for, and how far those may be off.
//!
//! Where the equation has a factor of a size that is allowed, shapes are refined, and modes are counted, as if they had been
//! found here. Beyond that they stay as they are, and eigenvalues are their Rayleigh quotients in double-double.

use eigentone_digits::sort_by_number;
use num_complex::Complex;

use super::answer::{Answer, Root, keep_nearest};
use super::coupled;
use super::damped;
use super::eigenpair::Eigenpair;
use super::error::SparseError;
use super::form::Form;
use super::newton;
use super::operator::Rigid;
use super::pencil::Pencil;
use super::quotients::Shapes;
use super::refine::{self, Pair};
use super::search::{self, Vector};
use super::setting::{self, Setting};
use super::undamped::{Facts, Undamped};
use crate::model::MatrixKind;
use crate::modes::{Frequency, ModePlan, Modes};
use crate::system::System;

/// What eigenpairs of another program are.
#[derive(Clone, Debug)]
pub struct ExaminedPairs {
    /// The modes that they stand for, with residuals, conditions and bounds.
    pub modes: Modes,
    /// How many pairs are no modes: not finite, 0, with a λ² beyond doubles, or with a residual that leaves no digit. A mode that is
    /// given twice is one.
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
/// λ²M + λC + K takes at most `operations` multiplications, shapes are refined to the last digits first, undamped
/// modes are counted, and those found missing are looked for; [`Modes::is_complete`] says whether none is missing. Without
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
    operations: f64,
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
    let sound = pairs.into_iter().filter_map(|pair| {
        let is_finite = pair.value.norm_sqr().is_finite();
        let shape = near_one(pair.shape).filter(|_| is_finite)?;
        Some(Eigenpair { shape, ..pair })
    });
    let pairs: Vec<Eigenpair> = sound.collect();
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
        operations,
    };
    let couples = !damping.is_zero() && given.facts.proportion.is_none();
    let examined = match couples {
        false => given.uncoupled(pairs)?,
        true => given.coupled(pairs)?,
    };
    let Examined {
        answer,
        unfit,
        missing,
        way,
    } = examined;
    let counted = damped::how_counted(&answer.complete, couples);
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

/// A shape in a unit, a power of two, that makes its largest entry about 1, so that squares are doubles; `None` where it is 0 or not
/// finite.
fn near_one(mut shape: Vec<Complex<f64>>) -> Option<Vec<Complex<f64>>> {
    let parts = || shape.iter().flat_map(|entry| [entry.re, entry.im]);
    let largest = parts().map(f64::abs).fold(0.0, f64::max);
    if !(parts().all(f64::is_finite) && largest > 0.0) {
        return None;
    }
    // In two steps: the inverse of the least doubles is none.
    let half = (-0.5 * largest.log2()).round().exp2();
    shape
        .iter_mut()
        .for_each(|entry| *entry = *entry * half * half);
    Some(shape)
}

struct Given<'a> {
    system: &'a System,
    /// M, C and K.
    forms: [&'a Form; 3],
    facts: Facts,
    operations: f64,
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
        let setting = match Setting::of(self.system, target, count, self.operations) {
            Ok(setting) => Some(setting),
            Err(SparseError::TooDense) => None,
            Err(error) => return Err(error),
        };
        let small = if setting.is_some() { MENDED } else { SMALL };
        let (real, massless) = self.shapes().real(pairs, rigid.as_ref());
        let (mut ritz, unlike) = self.shapes().pairs(real, floating.is_empty(), small);
        let mut unfit = massless + unlike;
        let refined = setting.and_then(|setting| self.refined(&setting, &ritz).ok());
        let way = if refined.is_some() { REFINED } else { AS_GIVEN };
        let (found, missing) = refined.unwrap_or_else(|| {
            // What is 0 within its bound is a motion that nothing holds.
            let is_resolved = |pair: &Pair| {
                let (error, size) = (pair.error.unwrap_or(0.0), pair.square.abs());
                error <= PART * size || error >= size
            };
            let before = ritz.len();
            ritz.retain(is_resolved);
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

    fn shapes(&self) -> Shapes<'_> {
        let [mass, _, stiffness] = self.forms;
        Shapes { mass, stiffness }
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
        sort_by_number(&mut vectors, |vector| -vector.inverse.abs());
        let mut pairs = refine::refined(&search.operator, vectors, None);
        pairs.retain(|pair| {
            let reach = PART * (pair.square - shift).abs();
            pair.error.is_some_and(|error| error <= reach)
        });
        self.shapes().keep_apart(&mut pairs);
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
        let mut groups = grouped(pairs, self.forms, zeros.roots);
        // What no weight measures.
        let before = groups.len();
        groups.retain(|group| !group.is_empty());
        let weightless = before - groups.len();
        let apart = |group: &Vec<Eigenpair>| (group[0].value.norm() - target).abs();
        sort_by_number(&mut groups, apart);
        let counting = match Setting::of(self.system, target, count, self.operations) {
            Ok(setting) => Some(setting),
            Err(SparseError::TooDense) => None,
            Err(error) => return Err(error),
        };
        let counted = match &counting {
            Some(setting) => coupled::count(
                &groups,
                &zeros,
                &setting.facts(self.system),
                &setting.pencil,
                damping,
            ),
            None => Err(NOT_COUNTED),
        };
        let own = Pencil::within(
            self.operations,
            stiffness.clone(),
            damping.clone(),
            mass.clone(),
        );
        let mut unfit = weightless;
        let mut roots: Vec<(usize, Root)> =
            zeros.entries().into_iter().map(|root| (0, root)).collect();
        for (at, group) in (1..).zip(groups) {
            let measured = newton::measured(self.forms, group);
            let (bounded, lost): (Vec<_>, Vec<_>) =
                measured.into_iter().partition(|root| root.error.is_some());
            unfit += lost.len();
            let improved = own.as_ref().map(|pencil| {
                let pair = |root: &newton::Root| Eigenpair {
                    value: root.value,
                    shape: root.shape.clone(),
                };
                newton::refined(pencil, bounded.iter().map(pair).collect())
            });
            // What does not converge keeps what its residual says.
            let best = match improved {
                Some(roots) if roots.iter().all(|root| root.error.is_some()) => roots,
                _ => bounded,
            };
            for root in coupled::settled(best, self.facts.passive) {
                let error = |root: &Root| root.error.map_or(0.0, |(whole, _)| whole);
                // Two groups may lead to one root.
                let same = |(other_at, other): &(usize, Root)| {
                    *other_at != at
                        && (other.value - root.value).norm() <= error(other) + error(&root)
                };
                if !roots.iter().any(same) {
                    roots.push((at, root));
                }
            }
        }
        let complete = counted.and_then(|count| coupled::confirmed(&roots, &count));
        let mut roots: Vec<Root> = roots.into_iter().map(|(_, root)| root).collect();
        if complete.is_err() {
            roots.iter_mut().for_each(Root::may_have_more_beside);
        }
        keep_nearest(&mut roots, target, count);
        Ok(Examined {
            answer: Answer { roots, complete },
            unfit,
            missing: 0,
            way: if own.is_some() { REFINED } else { AS_GIVEN },
        })
    }
}

/// Pairs with Im λ ≥ 0, those together that nearly coincide, without those at 0 and without shapes that others of their
/// group have.
fn grouped(pairs: Vec<Eigenpair>, forms: [&Form; 3], zeros: usize) -> Vec<Vec<Eigenpair>> {
    const SMALL: f64 = 1e-6;
    const APART: f64 = 1e-3;
    let [mass, _, stiffness] = forms;
    let largest = pairs
        .iter()
        .map(|pair| pair.value.norm())
        .fold(0.0, f64::max);
    // K + |λ|²M, in a unit that keeps all of it in the range of doubles.
    let unit = largest.max(1.0);
    let part = largest / unit;
    let weights = stiffness.diagonal().into_iter().zip(mass.diagonal());
    let weights: Vec<f64> = weights
        .map(|(k, m)| k.abs() / unit / unit + part * part * m.abs())
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
    sort_by_number(&mut pairs, |pair| pair.value.norm());
    let at_zero = |pair: &Eigenpair| pair.value.norm() <= SMALL * largest;
    let first = pairs
        .iter()
        .take(zeros)
        .take_while(|pair| at_zero(pair))
        .count();
    let mut groups = coupled::joined(pairs.drain(first..), newton::NEAR, |pair| pair.value);
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
            apart
        });
    }
    groups
}
