//! What is looked for in a system, and what is known of it before.

use std::sync::Arc;

use super::error::SparseError;
use super::form::Form;
use super::inertia::{Inertia, Side};
use super::pencil::Pencil;
use super::refine::{self, Pair};
use super::search::{Answer, Wanted};
use super::undamped::{Facts, Undamped};
use crate::model::MatrixKind;
use crate::system::System;

/// K and M with a pattern of their factor, and what is proved of both.
pub(crate) struct Setting {
    pub(crate) pencil: Arc<Pencil>,
    /// Parts with mass that no spring ties to the ground, and those without.
    floating: Vec<Vec<usize>>,
    idle: Vec<Vec<usize>>,
    has_sound_mass: bool,
    semidefinite: bool,
    target: f64,
    count: usize,
}

impl Setting {
    /// With a factor that takes at most so many multiplications.
    pub(crate) fn of(
        system: &System,
        target: f64,
        count: usize,
        operations: f64,
    ) -> Result<Setting, SparseError> {
        let form = |kind| Form::of(system, kind).ok_or(SparseError::NotSymmetric { kind });
        let mass = form(MatrixKind::Mass)?;
        let stiffness = form(MatrixKind::Stiffness)?;
        let has_sound_mass = check_mass(&mass, operations)?;
        let structure = system.structure();
        let (floating, idle) = floating(system, &mass);
        let semidefinite = stiffness.is_non_negative()
            || (!structure.is_large() && structure.rigid_motions().is_some());
        let none = Form::zero(system.len());
        let pencil =
            Pencil::within(operations, stiffness, none, mass).ok_or(SparseError::TooDense)?;
        // What lies barely below 0 is far from any other target.
        let semidefinite = semidefinite
            || target > 0.0 && {
                let at = -(1e-3 * target) * (1e-3 * target);
                let inertia = Inertia::new(&pencil, &idle);
                inertia.below_either(at, Side::AtMost) == Some(0)
            };
        Ok(Setting {
            pencil: Arc::new(pencil),
            floating,
            idle,
            has_sound_mass,
            semidefinite,
            target,
            count: count.min(system.len()),
        })
    }

    /// What a search is given.
    pub(crate) fn wanted(&self) -> Wanted<'_> {
        Wanted {
            pencil: &self.pencil,
            floating: &self.floating,
            idle: &self.idle,
            semidefinite: self.semidefinite,
            target: self.target,
            count: self.count,
        }
    }

    /// What a search found, with all digits, and the motions that nothing holds.
    pub(crate) fn undamped(&self, system: &System, answer: &mut Answer<'_>) -> Undamped {
        // Pivots count eigenvalues where M ⪰ 0.
        let counted = answer.counted.filter(|_| self.has_sound_mass);
        let (vectors, next) = answer.needed(&self.wanted());
        let mut pairs = refine::refined(&answer.operator, vectors, next);
        let structure = system.structure();
        if counted.is_some() && !structure.is_large() {
            let known = self.floating.len() + self.idle.len();
            let zeros = || Some(structure.rigid_motions_counted()?.saturating_sub(known));
            rest_exactly(&mut pairs, zeros);
        }
        let mass = &self.pencil.mass;
        pairs.extend(
            self.floating
                .iter()
                .take(self.count)
                .map(|part| rigid(part, mass)),
        );
        Undamped::nearest(pairs, counted, self.facts(system), system.len())
    }

    /// What is asked for, and what is proved of the system.
    pub(crate) fn facts(&self, system: &System) -> Facts {
        Facts {
            target: self.target,
            count: self.count,
            has_sound_mass: self.has_sound_mass,
            semidefinite: self.semidefinite,
            idle: self.idle.clone(),
            ..Facts::of(system)
        }
    }
}

/// Parts that no spring ties to the ground: those with mass, and those without.
pub(crate) fn floating(system: &System, mass: &Form) -> (Vec<Vec<usize>>, Vec<Vec<usize>>) {
    let has_mass = |part: &Vec<usize>| part.iter().any(|&i| !is_massless(mass, i));
    let parts = system.structure().spring_floating();
    parts.iter().cloned().partition(has_mass)
}

/// Whether row i of M is 0.
fn is_massless(mass: &Form, i: usize) -> bool {
    mass.is_diagonal() && mass.ground(i) == 0.0
}

/// Whether M is proved to be positive semidefinite, as lumped masses are, by a factor of so many multiplications; an error where
/// it is not so.
fn check_mass(mass: &Form, operations: f64) -> Result<bool, SparseError> {
    if mass.is_zero() {
        return Err(SparseError::NoMass);
    }
    if mass.is_non_negative() {
        return Ok(true);
    }
    let none = Form::zero(mass.len());
    let pencil = Pencil::within(operations, mass.clone(), none.clone(), none);
    let pencil = pencil.ok_or(SparseError::TooDense)?;
    let sizes = mass.sizes();
    let bare = (0..sizes.len()).filter(|&i| sizes[i] == 0.0);
    let bare: Vec<Vec<usize>> = bare.map(|i| vec![i]).collect();
    let inertia = Inertia::new(&pencil, &bare);
    if inertia.below_either(0.0, Side::AtMost) == Some(0) {
        return Ok(true);
    }
    match inertia.below_either(0.0, Side::AtLeast) {
        Some(0) | None => Ok(false),
        Some(_) => Err(SparseError::MassNotDefinite),
    }
}

/// Makes those that are not distinguished from 0 exactly 0 where as many motions are proved to need no force, and none
/// is missing.
fn rest_exactly(pairs: &mut [Pair], zeros: impl FnOnce() -> Option<usize>) {
    let unclear = |pair: &&mut Pair| pair.error.is_none_or(|error| pair.square.abs() <= error);
    let unclear: Vec<&mut Pair> = pairs.iter_mut().filter(unclear).collect();
    if unclear.is_empty() || zeros() != Some(unclear.len()) {
        return;
    }
    for pair in unclear {
        (pair.square, pair.error) = (0.0, Some(0.0));
    }
}

/// A part that moves as a whole.
pub(crate) fn rigid(part: &[usize], mass: &Form) -> Pair {
    let mut shape = vec![0.0; mass.len()];
    part.iter().for_each(|&i| shape[i] = 1.0);
    let norm = mass.quadratic(&shape).sqrt();
    part.iter().for_each(|&i| shape[i] = norm.recip());
    Pair {
        square: 0.0,
        shape,
        error: Some(0.0),
    }
}
