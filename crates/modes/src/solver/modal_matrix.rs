//! General damping in the coordinates of the undamped modes.

use eigentone_digits::{Lu, sort_by_number};
use faer::{Mat, MatRef};
use num_complex::Complex;

use crate::model::{Element, MatrixKind};
use crate::modes::Modes;
use crate::quality::real_forms::Entries;
use crate::system::System;

use super::improvement::refine;
use super::modal_damping::modal_damping;
use super::mode_solver::{ModeSolver, ModesError, admit};
use super::real_mode::RealMode;
use super::roots::{Root, collect};
use super::spring_factor::{self, undamped_roots};
use super::weak_coupling::weakly_coupled;
use super::{classical, rigid, state_matrix, symmetric};

/// Up to so many coordinates an even system is solved without its undamped modes.
const FEW: usize = 12;

/// Eigenvalues of [0 Ω; −JΩ −Γ], with the undamped frequencies Ω, J = I but for −1 where K makes a square negative, and the
/// modal damping matrix Γ = ΦᵀCΦ: for symmetric systems without massless nodes.
///
/// Where damping couples the modes weakly their roots are refined all at once, else they are those of the QR algorithm. The
/// states are scaled by their energy, so that stiff springs do not swamp soft ones, and the
/// frequencies come from the springs themselves where the system is built of them. Modes that C
/// provably leaves undamped ([`Structure::undamped_modes`](crate::Structure::undamped_modes)) are set apart and keep Re λ = 0.
#[derive(Clone, Copy, Debug)]
pub struct ModalMatrix;

impl ModeSolver for ModalMatrix {
    fn name(&self) -> &'static str {
        "modal matrix"
    }

    fn refuses(&self, system: &System) -> Option<String> {
        let structure = system.structure();
        if structure.is_undamped() {
            return Some("there is no damping".to_owned());
        }
        if !structure.is_symmetric() {
            return Some("a matrix is not symmetric".to_owned());
        }
        if !structure.massless().is_empty() {
            return Some("there are massless nodes".to_owned());
        }
        spring_factor::refuses_springs(system).and_then(|_| symmetric::refuses_matrices(system))
    }

    fn needless(&self, system: &System) -> Option<String> {
        let structure = system.structure();
        let is_plain = system.len() <= FEW
            && is_even(system)
            && structure.zero_roots() == Some(0)
            && structure.undamped_modes() == Some(0);
        is_plain.then(|| "not needed: nothing is stiff".to_owned())
    }

    fn reason(&self) -> &'static str {
        "damping couples the undamped modes: roots in modal coordinates"
    }

    fn solve(&self, system: &System) -> Result<Modes, ModesError> {
        let structure = system.structure();
        admit(self, system)?;
        let undamped = structure.undamped_modes().unwrap_or(0);
        // Mixing shapes of nearly one frequency would neglect what K couples them by.
        let shapes = match undamped {
            0 => classical::undamped_modes,
            _ => classical::real_modes,
        };
        let modes = shapes(self, system, Entries::Plain)?;
        let modes = modes.into_iter().map(RealMode::mass_normalised).collect();
        let (apart, mut modes) = set_apart(modes, undamped);
        let mut roots = undamped_roots(apart);

        // Rigid-body modes have no elastic energy, and so no state for it.
        modes.sort_by_key(|mode| mode.rigid);
        let r = modes.len();
        let elastic = modes.iter().filter(|mode| !mode.rigid).count();
        let gamma = modal_damping(system, modes.iter().map(|mode| mode.shape.as_slice()));
        let shapes = Mat::from_fn(system.len(), r, |i, j| modes[j].shape[i]);
        let basis = shapes.as_ref();
        let is_held = modes.iter().all(|mode| !mode.rigid && mode.square > 0.0);
        let weakly = || {
            let frequencies: Vec<f64> = modes.iter().map(|mode| mode.square.sqrt()).collect();
            weakly_coupled(&frequencies, gamma.as_ref())
        };
        let mut found = match is_held.then(weakly).flatten() {
            Some((values, amplitudes)) => {
                state_matrix::assembled(self, values, amplitudes, None, basis)?
            }
            None => by_states(self, &modes[..], elastic, gamma.as_ref(), basis)?,
        };
        let rigid_count = r - elastic;
        if rigid_count > 0 {
            let zeros = structure.zero_roots().unwrap_or(rigid_count);
            rigid::removed(&mut found, zeros.saturating_sub(rigid_count));
            let shapes = modes[elastic..].iter().map(RealMode::complex_shape);
            roots.extend(rigid::roots(shapes.collect(), zeros));
        }
        roots.extend(refine(system, found));
        Ok(collect(self, system, roots))
    }
}

/// The roots of the state matrix, conjugates included.
fn by_states(
    solver: &dyn ModeSolver,
    modes: &[RealMode],
    elastic: usize,
    gamma: MatRef<'_, f64>,
    basis: MatRef<'_, f64>,
) -> Result<Vec<Root>, ModesError> {
    let r = modes.len();
    let mut a = Mat::<f64>::zeros(elastic + r, elastic + r);
    for (j, mode) in modes.iter().take(elastic).enumerate() {
        let frequency = mode.square.abs().sqrt();
        a[(j, elastic + j)] = frequency;
        a[(elastic + j, j)] = -frequency.copysign(mode.square);
    }
    for j in 0..r {
        for i in 0..r {
            a[(elastic + i, elastic + j)] = -gamma[(i, j)];
        }
    }
    // z holds ωq and q′ = λq of each mode: q comes from the larger.
    let amplitudes = |lambda: Complex<f64>, z: Vec<Complex<f64>>| {
        let amplitude = |j: usize| {
            let velocity = z[elastic + j];
            if j < elastic && z[j].norm_sqr() > velocity.norm_sqr() {
                z[j] / modes[j].square.abs().sqrt()
            } else {
                velocity / lambda
            }
        };
        (0..r).map(amplitude).collect()
    };
    state_matrix::eigen(solver, a.as_ref(), basis, &amplitudes, None)
}

/// Whether masses and springs lie within three orders of magnitude each, and no damper is far stronger than either: then
/// the state matrix loses no more in doubles than its eigenvalues' vectors make good. Where matrices are given, the pivots of
/// M and K stand for masses and springs, and the entries of C for dampers.
fn is_even(system: &System) -> bool {
    const RANGE: f64 = 1e3;
    let span = |values: &mut dyn Iterator<Item = f64>| {
        let set = values.filter(|value| *value != 0.0).map(f64::abs);
        set.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), value| {
            (low.min(value), high.max(value))
        })
    };
    let elements =
        |elements: &[Element]| span(&mut elements.iter().map(|element| element.coefficient));
    let pivots = |matrix: Mat<f64>| Some(span(&mut Lu::regular(matrix.as_ref())?.pivots()));
    let masses = match system.added(MatrixKind::Mass) {
        None => Some(span(&mut system.masses().iter().copied())),
        Some(_) => pivots(system.mass_matrix()),
    };
    let springs = match system.added(MatrixKind::Stiffness) {
        None => Some(elements(system.springs())),
        Some(_) => pivots(system.stiffness_matrix()),
    };
    let (_, damper) = match system.added(MatrixKind::Damping) {
        None => elements(system.dampers()),
        Some(_) => (0.0, system.damping_matrix().norm_max()),
    };
    let is_narrow = |(low, high): (f64, f64)| high <= RANGE * low;
    masses.zip(springs).is_some_and(|(masses, springs)| {
        is_narrow(masses) && is_narrow(springs) && damper / masses.1 <= RANGE * (springs.1 / damper)
    })
}

/// The given number of elastic modes that C resists least, relative to their frequency, and the
/// rest.
pub(crate) fn set_apart(modes: Vec<RealMode>, count: usize) -> (Vec<RealMode>, Vec<RealMode>) {
    let resistance = |mode: &RealMode| {
        if mode.rigid {
            return f64::INFINITY;
        }
        let damping = (mode.forms.c / mode.forms.m).to_f64();
        damping.abs() / mode.square.sqrt()
    };
    if count == 0 {
        return (Vec::new(), modes);
    }
    let mut rated: Vec<(f64, RealMode)> = modes
        .into_iter()
        .map(|mode| (resistance(&mode), mode))
        .collect();
    sort_by_number(&mut rated, |mode| mode.0);
    let rest = rated.split_off(count.min(rated.len()));
    let bare = |rated: Vec<(f64, RealMode)>| rated.into_iter().map(|(_, mode)| mode).collect();
    (bare(rated), bare(rest))
}

#[cfg(test)]
mod tests {
    use faer::mat;

    use super::*;
    use crate::modes::Precision;
    use crate::structure::samples::{matrices, network};

    /// Two oscillators that a soft spring couples more than their damping separates them: (Δω)² = κ² + (δ + iσ)²/4, about.
    #[test]
    fn damping_does_not_hide_what_a_soft_spring_couples() {
        let (k, coupling, c) = (5.9, 1e-6, [1e-7, 3.1e-7]);
        for shift in [-1e-6, -1e-7, 0.0, 1e-8, 1e-6] {
            let springs = [(0, 1, k + shift), (0, 2, k), (1, 2, coupling)];
            let system = network(&[1.0; 2], &springs, &[(0, 1, c[0]), (0, 2, c[1])]);
            let modes = ModalMatrix.solve(&system).unwrap();
            let found: Vec<Complex<f64>> =
                modes.iter().map(|mode| mode.eigenvalue().value).collect();
            // (λ² + c₁λ + k₁)(λ² + c₂λ + k₂) = κ² has the roots nearest to these.
            let own = |i: usize, root: Complex<f64>| {
                let stiffness = k + coupling + if i == 0 { k + shift - k } else { 0.0 };
                root * root + c[i] * root + stiffness
            };
            for root in &found {
                let left = own(0, *root) * own(1, *root) - coupling * coupling;
                let slope = (own(0, *root) + own(1, *root)) * 2.0 * root;
                assert!((left / slope).norm() < 1e-13, "{shift}: {root}");
            }
            let gap = found[0] - found[1];
            let wanted = Complex::new(shift, (c[1] - c[0]) * k.sqrt());
            let wanted = (wanted * wanted + 4.0 * coupling * coupling).sqrt() / (2.0 * k.sqrt());
            let off = (gap.im.abs() / wanted.re - 1.0).abs();
            assert!(off < 1e-4, "{shift}: {gap}");
        }
    }

    #[test]
    fn a_mode_with_its_damper_in_a_node_stays_undamped() {
        let springs = [(0, 1, 3.0), (1, 2, 3.0), (2, 3, 3.0), (3, 0, 3.0)];
        let system = network(&[1.0; 3], &springs, &[(0, 2, 0.5)]);
        let modes = ModalMatrix.solve(&system).unwrap();
        let undamped: Vec<Complex<f64>> = modes
            .iter()
            .map(|mode| mode.eigenvalue().value)
            .filter(|value| value.re == 0.0)
            .collect();
        assert_eq!(undamped.len(), 1);
        assert!((undamped[0].im - 6f64.sqrt()).abs() < 1e-15);
    }

    /// Given matrices are judged by what elimination leaves of them, not by the sizes of their entries: the second K has the
    /// pivots 1e3 and 0.1.
    #[test]
    fn the_state_matrix_solves_matrices_that_are_even() {
        let damping = mat![[0.3, -0.2], [-0.2, 0.5]];
        let stiff = mat![[1e3, -1e3], [-1e3, 1e3 + 0.1]];
        let heavy = mat![[1e4, 0.0], [0.0, 1.0]];
        let even = mat![[3.0, -1.0], [-1.0, 2.0]];
        let identity = || Mat::<f64>::identity(2, 2);
        for (mass, damping, stiffness, solver) in [
            (identity(), damping.clone(), even.clone(), "state matrix"),
            (identity(), damping.clone(), stiff, "modal matrix"),
            (heavy, damping.clone(), even.clone(), "modal matrix"),
            (identity(), damping * 1e4, even, "modal matrix"),
        ] {
            let system = matrices(mass, damping, stiffness);
            for precision in [Precision::default(), Precision::Double] {
                let modes = system.modes_to(precision).expect("they are definite");
                assert_eq!(modes.plan().solver, solver);
            }
        }
    }
}
