//! Singular mass matrices: the roots of the problem in 1/(λ − s) for a real number s.
//!
//! With λ = s + 1/μ, Q(λ)x = (λ²M + λC + K)x = 0 becomes (μ²Q(s) + μQ′(s) + M)x = 0, with
//! Q′(s) = 2sM + C (Mackey, Mackey, Mehl & Mehrmann 2006, *SIAM J. Matrix Anal. Appl.* 28, on Möbius
//! transformations of matrix polynomials). Where Q(s) is nonsingular, which it is for all but 2n numbers s,
//! this is an ordinary problem, and the infinite roots λ are its roots μ = 0. How many these are,
//! and how many λ are 0, is counted exactly; rounding scatters them, so that the nearest ones
//! are set aside. What rounding does to the others is for the inclusion to mend.

use eigentone_digits::{DoubleDouble, singular_values, sort_by_number};
use faer::Mat;
use num_complex::Complex;

use crate::first_order::{FirstOrder, FirstOrderError, Massless};
use crate::model::MatrixKind;
use crate::modes::Modes;
use crate::quality::rayleigh::Forms;
use crate::system::System;

use super::choice::solvers;
use super::improvement::refine;
use super::mode_solver::{ModeSolver, ModesError};
use super::rigid::null_vectors;
use super::roots::{Root, collect};
use super::{rigid, state_matrix};

/// The state matrix of the problem in 1/(λ − s): for systems whose masses, and dampers and springs on
/// massless nodes, do not determine all accelerations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shifted;

/// Whether they do not. That is proved where all finite roots are counted, and else judged in
/// doubles.
pub(crate) fn is_needed(system: &System) -> bool {
    let singular = system.masses().contains(&0.0) || system.added(MatrixKind::Mass).is_some();
    let structure = system.structure();
    singular
        && match structure.finite_roots() {
            Some(degree) if structure.massless().is_empty() => degree != 2 * system.len(),
            Some(degree) => degree != Massless::of_system(system).degree(),
            None => FirstOrder::of(system).is_err(),
        }
}

impl ModeSolver for Shifted {
    fn name(&self) -> &'static str {
        "shifted state matrix"
    }

    fn refuses(&self, system: &System) -> Option<String> {
        let structure = system.structure();
        let counted = structure.finite_roots().is_some() && structure.zero_roots().is_some();
        (!counted).then(|| "the finite roots were not counted".to_owned())
    }

    fn reason(&self) -> &'static str {
        "the masses do not determine every acceleration: roots of the problem in 1/(λ − s)"
    }

    fn solve(&self, system: &System) -> Result<Modes, ModesError> {
        let structure = system.structure();
        let (Some(finite), Some(zeros)) = (structure.finite_roots(), structure.zero_roots()) else {
            let error = FirstOrder::of(system).err();
            return Err(error.unwrap_or(FirstOrderError::SingularMass).into());
        };
        let (mut found, shift) = if finite > zeros {
            approximate(self, system, finite)?
        } else {
            (Vec::new(), 0.0)
        };
        let mut roots = Vec::new();
        if zeros > 0 {
            let mut at_rest = rigid::shapes(system);
            if at_rest.is_empty() {
                let one = null_vectors(system.stiffness_matrix().as_ref(), 1);
                at_rest = one.ok_or(failed(self))?;
            }
            roots.extend(rigid::roots(at_rest, zeros));
        }
        if finite > zeros {
            nearest_apart(&mut found, zeros);
            for root in &mut found {
                unhide(system, root, shift);
            }
            roots.extend(refine(system, found));
        }
        let mut modes = collect(self, system, roots);
        modes.plan.reason = self.reason().to_owned();
        let refusal = |other: &&dyn ModeSolver| {
            let reason = other.refuses(system);
            Some((other.name(), reason?))
        };
        modes.plan.left_out = solvers().iter().filter_map(refusal).collect();
        Ok(modes)
    }
}

fn failed(solver: &dyn ModeSolver) -> ModesError {
    let method = solver.name();
    ModesError::NoConvergence { method }
}

/// Of a root that the shift hides, which cancels in its value, takes what its shape gives.
fn unhide(system: &System, root: &mut Root, shift: f64) {
    let hidden = 64.0 * f64::EPSILON * shift.abs();
    if root.value.norm() > hidden {
        return;
    }
    let forms = Forms::<DoubleDouble>::of(system, &root.left(), &root.shape);
    let [m, c, k] = [forms.m, forms.c, forms.k].map(|z| Complex::new(z.re.to_f64(), z.im.to_f64()));
    let mut slow = match c.norm_sqr() > 4.0 * (m * k).norm() {
        true => -k / c,
        false => (-k / m).sqrt(),
    };
    if root.value.im == 0.0 {
        slow.im = 0.0;
    }
    if slow.norm() > 0.0 && slow.norm() <= hidden {
        root.value = slow;
    }
}

/// As many roots λ as are finite, conjugates included, and s.
fn approximate(
    solver: &dyn ModeSolver,
    system: &System,
    finite: usize,
) -> Result<(Vec<Root>, f64), ModesError> {
    let matrices = [
        system.mass_matrix(),
        system.damping_matrix(),
        system.stiffness_matrix(),
    ];
    let [m, c, k] = &matrices;
    let shift = best_shift(&matrices).ok_or(failed(solver))?;
    let slope = c + m * faer::Scale(2.0 * shift);
    let inverted = System::assemble(
        system.names().to_vec(),
        vec![0.0; system.len()],
        Vec::new(),
        Vec::new(),
        [Some(at(&matrices, shift)), Some(slope), Some(m.clone())],
    );
    let form = FirstOrder::of(&inverted)?;
    let left = (!system.structure().is_symmetric()).then(|| form.b());
    let mut found = state_matrix::eigen(solver, form.a(), form.x(), &|_, z| z, left)?;
    nearest_apart(&mut found, (2 * system.len()).saturating_sub(finite));
    // What is 0 all the same is farther out than any other.
    let least = found.iter().map(|root| root.value.norm());
    let least = least
        .filter(|size| *size > 0.0)
        .fold(f64::INFINITY, f64::min);
    let typical = if least.is_finite() {
        least
    } else {
        k.norm_l2()
    };
    for root in &mut found {
        let nonzero = root.value != Complex::ZERO;
        let mu = if nonzero {
            root.value
        } else {
            Complex::from(1e-3 * typical)
        };
        root.value = mu.inv() + shift;
    }
    Ok((found, shift))
}

/// Q(s).
fn at([m, c, k]: &[Mat<f64>; 3], s: f64) -> Mat<f64> {
    k + (c + m * faer::Scale(s)) * faer::Scale(s)
}

/// Of some numbers of the size of the roots, that for which Q(s) is farthest from singular; 0 where that
/// does as well, since it leaves the matrices as they are.
fn best_shift(matrices: &[Mat<f64>; 3]) -> Option<f64> {
    const GOOD: f64 = 1e-6;
    let [m, c, k] = matrices.each_ref().map(|matrix| matrix.norm_l2());
    let sizes = [(k / m).sqrt(), k / c, c / m];
    let size = sizes.into_iter().find(|x| x.is_normal()).unwrap_or(1.0);
    let size = size.log2().round().exp2();
    let reciprocal = |s: f64| {
        let values = singular_values(at(matrices, s).as_ref())?;
        let (largest, least) = (*values.first()?, *values.last()?);
        let ratio = least / largest;
        ratio.is_finite().then_some(ratio)
    };
    if reciprocal(0.0).is_some_and(|ratio| ratio > GOOD) {
        return Some(0.0);
    }
    let candidates = [1.0, -1.0, 0.25, -0.25, 4.0, -4.0, 1.5, -1.5].map(|factor| factor * size);
    let rated = candidates.into_iter().chain([0.0]);
    let rated = rated.filter_map(|s| Some((reciprocal(s)?, s)));
    let best = rated.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 > 0.0).then_some(best.1)
}

/// Removes so many of the roots nearest to 0. Of a pair that this parts, the other one becomes real.
fn nearest_apart(found: &mut Vec<Root>, count: usize) {
    sort_by_number(found, |root| root.value.norm());
    let removed = found.drain(..count.min(found.len())).next_back();
    if let (Some(removed), Some(first)) = (removed, found.first())
        && removed.value.im != 0.0
        && removed.value.conj() == first.value
    {
        found[0].value = Complex::from(removed.value.norm());
    }
}

#[cfg(test)]
mod tests {
    use faer::mat;

    use super::*;
    use crate::model::GROUND;
    use crate::modes::Bounds;

    /// The system is proved to have exactly these roots, conjugates included.
    fn assert_proven(system: &System, infinite: usize, expected: &[Complex<f64>]) -> Modes {
        let modes = system.modes().unwrap();
        assert_eq!(modes.bounds(), Bounds::Proven, "{}", modes.plan());
        assert_eq!(modes.infinite(), infinite);
        assert_eq!(modes.eigenvalues().len(), expected.len());
        for value in expected {
            let met = |root: &&crate::Eigenvalue| {
                (root.value - value).norm() <= 4.0 * f64::EPSILON * value.norm()
            };
            let met = modes.eigenvalues().iter().filter(met).count();
            let equal = expected.iter().filter(|other| *other == value).count();
            assert_eq!(met, equal, "{value}: {:?}", modes.eigenvalues());
        }
        modes
    }

    fn real<const N: usize>(values: [f64; N]) -> [Complex<f64>; N] {
        values.map(Complex::from)
    }

    #[test]
    fn a_mass_shared_by_two_coordinates_leaves_three_roots() {
        // (λ² + λ + 3)(λ² + 2λ + 2) − (λ² − 1)² = 3λ³ + 9λ² + 8λ + 5.
        let system = System::from_matrices(
            mat![[1.0, 1.0], [1.0, 1.0]].as_ref(),
            mat![[1.0, 0.0], [0.0, 2.0]].as_ref(),
            mat![[3.0, -1.0], [-1.0, 2.0]].as_ref(),
        )
        .unwrap();
        let modes = system.modes().unwrap();
        assert_eq!(modes.infinite(), 1);
        assert_eq!(modes.eigenvalues().len(), 3);
        assert_eq!(modes.bounds(), Bounds::Proven);
        for root in modes.eigenvalues() {
            let z = root.value;
            let value = ((z * 3.0 + 9.0) * z + 8.0) * z + 5.0;
            assert!(value.norm() <= 20.0 * f64::EPSILON * (z.norm() + 1.0).powi(3));
            assert!(root.bound.is_some_and(|bound| bound <= 1e-15 * z.norm()));
        }
        assert!(modes.iter().all(|mode| mode.backward_error() <= 1e-15));
    }

    #[test]
    fn masses_and_springs_singular_together() {
        // M = vvᵀ, C = I, K = wwᵀ with v = (3, 7) and w = (1, 1):
        // det = λ² + λ(λ²‖v‖² + ‖w‖²) + λ²(‖v‖²‖w‖² − (v·w)²) = λ(58λ² + 17λ + 2).
        let system = System::from_matrices(
            mat![[9.0, 21.0], [21.0, 49.0]].as_ref(),
            mat![[1.0, 0.0], [0.0, 1.0]].as_ref(),
            mat![[1.0, 1.0], [1.0, 1.0]].as_ref(),
        )
        .unwrap();
        // (−17 ± √(289 − 464))/116.
        let (re, im) = (-17.0 / 116.0, 175f64.sqrt() / 116.0);
        let pair = [Complex::new(re, im), Complex::new(re, -im), Complex::ZERO];
        let modes = assert_proven(&system, 1, &pair);
        let rigid = modes
            .iter()
            .find(|mode| mode.eigenvalue().value.norm() == 0.0);
        let shape = rigid.unwrap().shape();
        assert!((shape[0] + shape[1]).norm() <= 4.0 * f64::EPSILON);
    }

    #[test]
    fn rounding_does_not_hide_that_a_mass_matrix_is_singular() {
        // Row 2 is 7/3 of row 1, which doubles do not hold.
        let system = System::from_matrices(
            mat![[9.0, 21.0], [21.0, 49.0]].as_ref(),
            mat![[0.0, 0.0], [0.0, 0.0]].as_ref(),
            mat![[2.0, 0.0], [0.0, 5.0]].as_ref(),
        )
        .unwrap();
        // det = λ²(9·5 + 49·2) + 10.
        let omega = (10f64 / 143.0).sqrt();
        let pair = [Complex::new(0.0, omega), Complex::new(0.0, -omega)];
        assert_proven(&system, 2, &pair);
    }

    #[test]
    fn planted_rational_roots_with_infinite_and_zero_ones() {
        // Q = Lᵀ·diag((λ+1)(λ+2), λ(λ+3), λ+4, 5)·R for unimodular L and R.
        let diagonals = [
            [2.0, 0.0, 4.0, 5.0],
            [3.0, 3.0, 1.0, 0.0],
            [1.0, 1.0, 0.0, 0.0],
        ];
        let left = mat![
            [1.0, 2.0, 0.0, -1.0],
            [0.0, 1.0, 3.0, 1.0],
            [0.0, 0.0, 1.0, 2.0],
            [0.0, 0.0, 0.0, 1.0]
        ];
        let right = mat![
            [1.0, 0.0, 0.0, 0.0],
            [-2.0, 1.0, 0.0, 0.0],
            [1.0, 1.0, 1.0, 0.0],
            [3.0, 0.0, -1.0, 1.0]
        ];
        for right in [right, left.clone()] {
            let [k, c, m] = diagonals.map(|d: [f64; 4]| {
                let middle = Mat::from_fn(4, 4, |i, j| if i == j { d[i] } else { 0.0 });
                left.transpose() * middle * &right
            });
            let system = System::from_matrices(m.as_ref(), c.as_ref(), k.as_ref()).unwrap();
            assert_proven(&system, 3, &real([-1.0, -2.0, 0.0, -3.0, -4.0]));
        }
    }

    #[test]
    fn a_multiple_root_beside_infinite_ones() {
        // Lᵀ·diag((λ+1)², λ+1, 3)·L: −1 three times, with two shapes.
        let left = mat![[1.0, 2.0, 1.0], [0.0, 1.0, -3.0], [0.0, 0.0, 1.0]];
        let of = |d: [f64; 3]| {
            let middle = Mat::from_fn(3, 3, |i, j| if i == j { d[i] } else { 0.0 });
            left.transpose() * middle * &left
        };
        let (k, c, m) = (
            of([1.0, 1.0, 3.0]),
            of([2.0, 1.0, 0.0]),
            of([1.0, 0.0, 0.0]),
        );
        let system = System::from_matrices(m.as_ref(), c.as_ref(), k.as_ref()).unwrap();
        let modes = system.modes().unwrap();
        assert_eq!(modes.bounds(), Bounds::Proven, "{}", modes.plan());
        assert_eq!((modes.infinite(), modes.eigenvalues().len()), (3, 3));
        for root in modes.eigenvalues() {
            let error = (root.value + 1.0).norm();
            assert!(error <= f64::EPSILON && error <= root.bound.unwrap());
        }
        assert_eq!(modes.as_slice()[0].multiplicity(), Some(3));
    }

    #[test]
    fn what_vanishes_for_every_root_is_refused() {
        let m = mat![[1.0, 2.0], [2.0, 4.0]];
        let build = System::from_matrices(m.as_ref(), m.as_ref(), m.as_ref());
        assert!(
            matches!(build, Err(crate::BuildError::Singular)),
            "{build:?}"
        );
    }

    /// Relaxations of 5e-11 and 4e-17 beside a root of 8e6, in a system of which a point alone has a mass matrix without a
    /// vanishing row: beside the shift the slowest cancels.
    #[test]
    fn a_root_that_the_shift_hides_is_found() {
        let near = [("m2", 0.8), ("m0", 0.8), ("m1", -1.5)];
        let system = System::builder()
            .mass("m0", 0.0)
            .mass("m1", 0.0)
            .mass("m2", 100.0)
            .point("p", near, 5.0)
            .point("q", [("m2", 0.8)], 0.0)
            .point("r", [("m2", -0.64)], 0.0)
            .spring("p", "q", 2e7)
            .spring("p", "m2", 1.0)
            .spring("m1", "q", 5e-6)
            .damper("r", "m0", 3e8)
            .damper("m0", "m2", 3e10)
            .damper("m1", "r", 1.0);
        let modes = system.build().unwrap().modes().unwrap();
        assert_eq!(modes.bounds(), Bounds::Proven, "{}", modes.plan());
        let slowest = modes.eigenvalues()[0].value;
        assert!(slowest.re < 0.0 && slowest.norm() < 1e-15, "{slowest}");
    }

    /// Two coordinates that a point of mass 0.1 couples, one spring 16 decades softer than the other: that one holds the
    /// point, and the other stays as long as it was, so that ω² = k/m.
    #[test]
    fn a_spring_that_only_ties_a_massless_node_costs_no_digits() {
        let (soft, stiff) = (2.732404735710926e-7, 3242296028.1271462);
        let system = System::builder()
            .mass("a", 0.0)
            .mass("b", 0.0)
            .point("p", [("a", 0.8), ("b", -1.2)], 0.1)
            .spring("b", "p", soft)
            .spring("p", GROUND, stiff);
        let omega = (stiff / 0.1f64).sqrt();
        let pair = [Complex::new(0.0, omega), Complex::new(0.0, -omega)];
        assert_proven(&system.build().unwrap(), 2, &pair);
    }

    #[test]
    fn no_finite_root_at_all() {
        let system = System::from_matrices(
            mat![[0.0, 1.0], [0.0, 0.0]].as_ref(),
            mat![[0.0, 0.0], [0.0, 0.0]].as_ref(),
            mat![[1.0, 0.0], [0.0, 1.0]].as_ref(),
        )
        .unwrap();
        let modes = system.modes().unwrap();
        assert_eq!((modes.infinite(), modes.eigenvalues().len()), (4, 0));
    }
}
