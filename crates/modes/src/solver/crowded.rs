//! Estimates of roots that lie near each other, where a shape and its condition do not tell them apart.
//!
//! A root that Newton's method finds is one, but not which: several approximations may lead to the same root and leave others
//! beside it without any, and the shapes of those that are left are mixtures, which have the condition of none. Discs that are
//! shown to hold as many roots as approximations bound them all, however they move together.

use num_complex::Complex;

use crate::modes::{Mode, Modes, listed, sort};
use crate::system::System;

use super::certified::{InDisc, discs};
use super::mode_solver::ModeSolver;
use super::newton::FEW;
use super::roots::{Root, collect};

/// Gives roots whose estimates touch the bounds of discs; where none are found by some tenths of a second of work, they are
/// doubtful. Estimates of real shapes hold beside others too, and for many coordinates it would take too long.
pub(super) fn enclose(solver: &dyn ModeSolver, system: &System, found: &mut Modes) {
    let structure = system.structure();
    const TOLERANCE: f64 = 1e-9;
    const MOST_WORK: f64 = 2e7;
    let is_moving = |mode: &Mode| mode.eigenvalue.value != Complex::ZERO;
    let is_crowded = |mode: &Mode| {
        is_moving(mode) && (mode.roots > 1 || mode.cluster().is_some_and(|count| count > 1))
    };
    let is_claimed = |mode: &Mode| is_crowded(mode) && !mode.eigenvalue.is_doubtful();
    let has_real_shapes = structure.is_undamped() && structure.is_symmetric();
    if system.len() > FEW
        || has_real_shapes
        || structure.is_classical()
        || !found.modes.iter().any(is_claimed)
    {
        return;
    }
    let all = std::mem::take(&mut found.modes);
    let (mut moving, mut modes): (Vec<Mode>, Vec<Mode>) = all.into_iter().partition(is_moving);
    let open: Vec<bool> = moving.iter().map(is_crowded).collect();
    match apart(system, &moving, open.clone(), [TOLERANCE, MOST_WORK]) {
        Some((better, replaced)) => {
            let mut replaced = replaced.into_iter();
            moving.retain(|_| !replaced.next().unwrap_or(false));
            moving.extend(collect(solver, system, better).modes);
        }
        None => {
            for (mode, _) in moving.iter_mut().zip(open).filter(|(_, open)| *open) {
                (mode.eigenvalue.bound, mode.eigenvalue.real_bound) = (None, None);
            }
        }
    }
    modes.extend(moving);
    sort(&mut modes);
    found.eigenvalues = listed(&modes);
    found.modes = modes;
}

/// What takes the place of the modes that are open, and which it does take the place of; `None` where no discs are found, or they do
/// not hold as many.
fn apart(
    system: &System,
    moving: &[Mode],
    mut open: Vec<bool>,
    [tolerance, most_work]: [f64; 2],
) -> Option<(Vec<Root>, Vec<bool>)> {
    let root = |(mode, open): (&Mode, &bool)| Root {
        left: mode.left_shape.clone(),
        count: mode.roots,
        // The others are known well enough.
        error: Some(match *open {
            true => (
                mode.eigenvalue.bound.unwrap_or(f64::INFINITY),
                f64::INFINITY,
            ),
            false => (0.0, 0.0),
        }),
        ..Root::simple(mode.eigenvalue.value, mode.shape.clone())
    };
    let known: Vec<Root> = moving.iter().zip(&open).map(root).collect();
    let (found, _) = discs(system, &known, tolerance, most_work)?;
    // An approximation may have roots in several discs: all of them take its place.
    let is_open = |open: &[bool], disc: &InDisc| disc.owners.iter().any(|i| open[*i]);
    while let Some(disc) = found
        .iter()
        .find(|disc| is_open(&open, disc) && !disc.owners.iter().all(|i| open[*i]))
    {
        disc.owners.iter().for_each(|i| open[*i] = true);
    }
    let each = found.into_iter().filter(|disc| is_open(&open, disc));
    let better: Vec<Root> = each.flat_map(|disc| disc.roots).collect();
    let count = |value: Complex<f64>, roots: usize| if value.im == 0.0 { roots } else { 2 * roots };
    let replaced = moving.iter().zip(&open).filter(|(_, open)| **open);
    let before: usize = replaced
        .map(|(mode, _)| count(mode.eigenvalue.value, mode.roots))
        .sum();
    let after: usize = better
        .iter()
        .map(|root| count(root.value, root.count))
        .sum();
    (after == before).then_some((better, open))
}
