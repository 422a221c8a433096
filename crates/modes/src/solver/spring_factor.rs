//! Undamped modes from the springs themselves: one-sided Jacobi on the spring factor.
//!
//! With K = GᵀD_kG (G the incidence matrix of the springs, D_k their stiffnesses) and M diagonal,
//! the natural frequencies are the singular values of F = D_k^{1/2} G M^{-1/2}. One-sided Jacobi
//! (Hestenes 1958; accuracy: Demmel & Veselić 1992, *SIAM J. Matrix Anal.* 13; for networks Demmel
//! et al. 1999, *Lin. Alg. Appl.* 299) computes each of them to a few units of rounding however
//! stiff the system, since each spring alone changes ω by at most half its own relative change.

use eigentone_digits::{quick_symmetric_eigen, sort_by_number};
use faer::Mat;
use num_complex::Complex;

use crate::model::Node;
use crate::quality::real_forms::{Entries, RealForms};
use crate::system::System;

use super::mode_solver::{ModeSolver, ModesError, admit};
use super::real_mode::{RealMode, unit_shapes};
use super::roots::{Root, collect};
use super::star_mesh::Condensed;
use super::{rigid, tree_factor};
use crate::linear::jacobi::jacobi;
use crate::modes::Modes;

/// Singular values of D_k^{1/2} G M^{-1/2}: for undamped systems of positive springs and lumped
/// masses. Its frequencies are exact to a few units in the last place, whatever the spread of
/// springs and masses.
#[derive(Clone, Copy, Debug)]
pub struct SpringFactor;

/// Above this many coordinates the O(sweeps·n³) of the Jacobi method is too expensive.
const LARGEST: usize = 400;

/// How far singular values of n columns by Jacobi's method may be off, relative: their errors are
/// seen to grow with √n, to 46 units of rounding at n = 200.
pub(crate) fn jacobi_error(n: usize) -> f64 {
    8.0 * f64::EPSILON * (n as f64).sqrt()
}

impl ModeSolver for SpringFactor {
    fn name(&self) -> &'static str {
        "spring factor"
    }

    fn refuses(&self, system: &System) -> Option<String> {
        if !system.structure().is_undamped() {
            return Some("there is damping".to_owned());
        }
        refuses_springs(system)
    }

    fn reason(&self) -> &'static str {
        "undamped, built of positive springs and lumped masses: singular values of the springs' own factor, to the last digits however stiff"
    }

    fn solve(&self, system: &System) -> Result<Modes, ModesError> {
        admit(self, system)?;
        let modes = real_modes(self, system)?;
        Ok(collect(self, system, undamped_roots(modes)))
    }
}

/// Why the springs and masses do not fit the spring factor, damping apart.
pub(crate) fn refuses_springs(system: &System) -> Option<String> {
    use crate::model::MatrixKind::{Mass, Stiffness};
    if system.added(Mass).is_some() || system.added(Stiffness).is_some() {
        return Some("the system has matrices, not springs and masses alone".to_owned());
    }
    if system
        .springs()
        .iter()
        .any(|spring| spring.coefficient < 0.0)
    {
        return Some("a spring is negative".to_owned());
    }
    let n = system.len();
    (n > LARGEST).then(|| format!("{n} coordinates are more than the {LARGEST} it is meant for"))
}

/// λ = ±iω, with Re λ = 0 exactly, and two roots at 0 for each rigid-body mode.
pub(crate) fn undamped_roots(modes: Vec<RealMode>) -> Vec<Root> {
    let (rigid, elastic): (Vec<RealMode>, Vec<RealMode>) =
        modes.into_iter().partition(|mode| mode.rigid);
    let count = 2 * rigid.len();
    let mut roots = rigid::roots(rigid.iter().map(RealMode::complex_shape).collect(), count);
    for mode in elastic {
        let shape = mode.complex_shape();
        let omega = mode.square.abs().sqrt();
        let error = (4.0 * f64::EPSILON + mode.doubt) * omega;
        let root = |value, real_error, shape| Root {
            error: Some((error, real_error)),
            quality: mode.quality,
            ..Root::simple(value, shape)
        };
        if mode.square >= 0.0 {
            roots.push(root(Complex::new(0.0, omega), 0.0, shape));
        } else {
            roots.push(root(Complex::from(omega), error, shape.clone()));
            roots.push(root(Complex::from(-omega), error, shape));
        }
    }
    roots
}

/// The undamped modes of M and K, from the springs.
pub(crate) fn real_modes(
    solver: &dyn ModeSolver,
    system: &System,
) -> Result<Vec<RealMode>, ModesError> {
    let structure = system.structure();
    let n = system.len();
    let network = Condensed::of(system);
    let massive = &network.massive;
    let floating = structure.spring_floating().iter();
    let rank = massive.len() - floating.filter(|part| has_mass(system, part)).count();
    let singular = match even(&network, system, rank) {
        Some(singular) => singular,
        None => singular_values(solver, &network, system)?,
    };
    let mut order: Vec<usize> = (0..singular.values.len()).collect();
    sort_by_number(&mut order, |i| -singular.values[*i]);

    let shape = |&j: &usize| {
        let mut shape = vec![0.0; n];
        for (row, &i) in massive.iter().enumerate() {
            shape[i] = singular.vectors[(row, j)] / system.masses()[i].sqrt();
        }
        network.extend(&mut shape);
        shape
    };
    let shapes: Vec<Vec<f64>> = order.iter().take(rank).map(shape).collect();
    let mut modes: Vec<RealMode> = Vec::with_capacity(massive.len());
    for ((shape, forms), &j) in unit_shapes(system, shapes, Entries::Exact).zip(&order) {
        let (square, doubt) = refined(&forms, singular.values[j], singular.error);
        modes.push(RealMode {
            square,
            shape,
            forms,
            rigid: false,
            // Values that are less good than the quotients do not put these in doubt.
            doubt: if singular.rough { 0.0 } else { doubt },
            quality: None,
            is_exact: false,
        });
    }
    let floating = structure.spring_floating().iter();
    let rigid = floating.filter(|part| has_mass(system, part)).map(|part| {
        let mut shape = vec![0.0; n];
        for &i in part {
            shape[i] = 1.0;
        }
        shape
    });
    modes.extend(
        unit_shapes(system, rigid.collect(), Entries::Exact).map(|(shape, forms)| RealMode {
            square: 0.0,
            shape,
            forms,
            rigid: true,
            doubt: 0.0,
            quality: None,
            is_exact: false,
        }),
    );
    Ok(modes)
}

/// Singular values and vectors of F in double precision throughout: from FᵀF, where its nonzero
/// eigenvalues lie close enough together that each keeps its digits. With κ for the largest over the
/// smallest, a Rayleigh quotient then errs by about n(κu)². `None` elsewhere, and where Jacobi's
/// method is as quick.
fn even(network: &Condensed, system: &System, rank: usize) -> Option<Singular> {
    const FEW: usize = 12;
    const SPREAD: f64 = 1e6;
    let count = network.massive.len();
    if count <= FEW || rank == 0 {
        return None;
    }
    let column = network.columns(system.len());
    let mut square = Mat::<f64>::zeros(count, count);
    for spring in &network.springs {
        let end = |node: Node| {
            let i = node.coordinate()?;
            Some((column[i]?, system.masses()[i].sqrt()))
        };
        let ends = [end(spring.first), end(spring.second)];
        for (i, mass) in ends.into_iter().flatten() {
            square[(i, i)] += spring.coefficient / mass / mass;
        }
        if let [Some((i, one)), Some((j, other))] = ends {
            square[(i, j)] -= spring.coefficient / one / other;
            square[(j, i)] = square[(i, j)];
        }
    }
    let (squares, vectors) = quick_symmetric_eigen(&square)?;
    let largest = squares[count - 1];
    let smallest = squares[count - rank];
    if !largest.is_finite() || smallest <= largest / SPREAD {
        return None;
    }
    Some(Singular {
        values: squares
            .iter()
            .map(|square| square.max(0.0).sqrt())
            .collect(),
        vectors,
        error: 1e-8,
        rough: true,
    })
}

/// Singular values and vectors of F by Jacobi's method.
fn singular_values(
    solver: &dyn ModeSolver,
    network: &Condensed,
    system: &System,
) -> Result<Singular, ModesError> {
    let method = solver.name();
    let columns = network.columns(system.len());
    let masses: Vec<f64> = network
        .massive
        .iter()
        .map(|i| system.masses()[*i])
        .collect();
    let factor = tree_factor::factor(&network.springs, &columns, &masses);
    if !factor.norm_max().is_finite() {
        return Err(ModesError::OutOfRange { method });
    }
    let (values, vectors) =
        jacobi(factor.transpose().to_owned()).ok_or(ModesError::NoConvergence { method })?;
    Ok(Singular {
        values,
        vectors,
        error: jacobi_error(masses.len()),
        rough: false,
    })
}

fn has_mass(system: &System, part: &[usize]) -> bool {
    part.iter().any(|i| system.masses()[*i] > 0.0)
}

/// ω² as the Rayleigh quotient of a shape. On very stiff systems the
/// rounding of the shape itself spoils the quotient: unless it confirms σ to its relative error, σ²
/// stays. Also how far ω may be off, relative to σ: σ's error, or where the quotient is taken twice
/// what the two differ by, since either may be the worse, and no less than its rounding.
pub(crate) fn refined(forms: &RealForms, sigma: f64, error: f64) -> (f64, f64) {
    let square = forms.quotient();
    let apart = (square.sqrt() - sigma).abs();
    if square.is_finite() && apart <= error * sigma {
        // Both may be off by the same, and ω is by half of what its square is.
        (
            square,
            (2.0 * apart / sigma).max(0.5 * forms.quotient_error()),
        )
    } else {
        (sigma * sigma, error)
    }
}

/// Singular values and right singular vectors of F: one row for each coordinate with mass.
struct Singular {
    values: Vec<f64>,
    vectors: Mat<f64>,
    /// Of the values, relative, with a margin.
    error: f64,
    /// Whether Rayleigh quotients of the vectors are better than the values.
    rough: bool,
}
