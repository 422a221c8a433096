//! Few dampers: the undamped modes, and a determinant of the order of C's rank.

use faer::Mat;
use num_complex::Complex;

use crate::model::{MatrixKind, Node};
use crate::modes::Modes;
use crate::quality::pencil::products;
use crate::quality::real_forms::Entries;
use crate::system::System;

use super::classical;
use super::improvement::refine_simple;
use super::modal_matrix::ModalMatrix;
use super::modal_matrix::set_apart;
use super::mode_solver::{ModeSolver, ModesError, admit};
use super::real_mode::RealMode;
use super::roots::{Root, collect};
use super::secular::Secular;
use super::spring_factor::undamped_roots;

/// Roots of det(I + λUᵀ(λ² + Ω²)⁻¹U), with the undamped frequencies Ω and C = UUᵀ of low rank in
/// the coordinates of their shapes, by simultaneous iteration: O(n²r²) for all 2n, beside the O(n³)
/// of the undamped modes (Taslaman 2014, *Algorithms and theory for polynomial eigenproblems*).
/// Where that iteration does not show all roots apart, as at critical damping, it gives way to
/// [`ModalMatrix`].
#[derive(Clone, Copy, Debug)]
pub struct LowRank;

/// Below this many coordinates the modal matrix is as quick.
const SMALLEST: usize = 16;

impl ModeSolver for LowRank {
    fn name(&self) -> &'static str {
        "low-rank damping"
    }

    fn refuses(&self, system: &System) -> Option<String> {
        let structure = system.structure();
        if let Some(reason) = ModalMatrix.refuses(system) {
            return Some(reason);
        }
        if !structure.is_passive() {
            return Some("the system is not proved passive".to_owned());
        }
        let n = system.len();
        let rank = system.dampers().len() + damped_by_matrix(system).len();
        if n < SMALLEST || 2 * rank * rank > n {
            return Some(format!(
                "it is quicker only with far fewer dampers than coordinates, where each row of a damping matrix counts as one: dampers {rank}, coordinates {n}"
            ));
        }
        if added_columns(system).is_none() {
            return Some("its damping matrix is not seen to be semidefinite".to_owned());
        }
        let rigid = structure.rigid_motions() != Some(0);
        rigid.then(|| "springs do not hold every motion".to_owned())
    }

    fn reason(&self) -> &'static str {
        "passive, with few dampers: a determinant of their number over the undamped modes"
    }

    fn solve(&self, system: &System) -> Result<Modes, ModesError> {
        admit(self, system)?;
        let undamped = system.structure().undamped_modes().unwrap_or(0);
        let modes = classical::real_modes(self, system, Entries::Plain)?;
        let modes = modes.into_iter().map(RealMode::mass_normalised).collect();
        let (apart, modes) = set_apart(modes, undamped);
        let positive = modes.iter().all(|mode| mode.square > 0.0 && !mode.rigid);
        let found = positive
            .then(|| {
                let omega = modes.iter().map(|mode| mode.square.sqrt()).collect();
                Secular::new(omega, factor(system, &modes)).roots()
            })
            .flatten();
        let Some(found) = found else {
            return ModalMatrix.solve(system);
        };
        let basis = Mat::from_fn(system.len(), modes.len(), |i, j| modes[j].shape[i]);
        let amplitudes: Vec<&[Complex<f64>]> = found
            .iter()
            .map(|root| root.amplitudes.as_slice())
            .collect();
        let shapes = products(basis.as_ref(), &amplitudes);
        let simple = found.iter().zip(shapes);
        let simple = simple.map(|(root, shape)| Root::simple(root.value, shape));
        let radii: Vec<f64> = found.iter().map(|root| root.radius).collect();
        let mut roots = refine_simple(system, simple.collect(), &radii);
        roots.extend(undamped_roots(apart));
        Ok(collect(self, system, roots))
    }
}

/// The coordinates that the added damping matrix acts on.
fn damped_by_matrix(system: &System) -> Vec<usize> {
    let Some(added) = system.added(MatrixKind::Damping) else {
        return Vec::new();
    };
    let is_damped = |i: &usize| (0..added.ncols()).any(|j| added[(*i, j)] != 0.0);
    (0..added.nrows()).filter(is_damped).collect()
}

/// Columns whose products with their transposes add up to the added damping matrix, each by coordinates: its Cholesky factor with
/// pivots, ended where no more is left than rounding of unit diagonals (Higham 2002, section 10.3). `None` where pivots
/// are negative.
fn added_columns(system: &System) -> Option<Vec<Vec<(usize, f64)>>> {
    let damped = damped_by_matrix(system);
    let Some(added) = system
        .added(MatrixKind::Damping)
        .filter(|_| !damped.is_empty())
    else {
        return Some(Vec::new());
    };
    let r = damped.len();
    let scale: Vec<f64> = damped.iter().map(|i| added[(*i, *i)].sqrt()).collect();
    if !scale.iter().all(|scale| *scale > 0.0) {
        return None;
    }
    let mut rest = Mat::from_fn(r, r, |i, j| {
        added[(damped[i], damped[j])] / scale[i] / scale[j]
    });
    let least = 4.0 * r as f64 * f64::EPSILON;
    let mut columns = Vec::new();
    for _ in 0..r {
        let pivot = (0..r).max_by(|i, j| rest[(*i, *i)].total_cmp(&rest[(*j, *j)]))?;
        let size = rest[(pivot, pivot)];
        if size <= least {
            break;
        }
        let column: Vec<f64> = (0..r).map(|i| rest[(i, pivot)] / size.sqrt()).collect();
        for i in 0..r {
            for j in 0..r {
                rest[(i, j)] -= column[i] * column[j];
            }
        }
        let own = column.iter().zip(&scale).zip(&damped);
        columns.push(own.map(|((x, scale), i)| (*i, x * scale)).collect());
    }
    (rest.norm_max() <= least).then_some(columns)
}

/// The rows of U: √c times the stretch of each damper in each shape, and what the shape is along the added matrix's columns.
fn factor(system: &System, modes: &[RealMode]) -> Vec<Vec<f64>> {
    let added = added_columns(system).unwrap_or_default();
    let row = |mode: &RealMode| {
        let at = |node: Node| node.coordinate().map_or(0.0, |i| mode.shape[i]);
        let dampers = system.dampers().iter();
        let stretch = dampers
            .map(|damper| damper.coefficient.sqrt() * (at(damper.first) - at(damper.second)));
        let along = added.iter().map(|column| {
            let terms = column.iter().map(|(i, factor)| factor * mode.shape[*i]);
            terms.sum::<f64>()
        });
        stretch.chain(along).collect()
    };
    modes.iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modes::Precision;
    use crate::structure::samples::{Join, network, with_matrices};

    /// A chain of 40 masses with dampers of very different size, as elements or as a matrix.
    fn chain(as_matrix: bool, dampers: &[Join]) -> System {
        const N: usize = 40;
        let masses: Vec<f64> = (0..N).map(|i| 1.0 + (i % 3) as f64).collect();
        let spring = |i: usize| (i + 1, (i + 2) % (N + 1), 50.0 + i as f64);
        let springs: Vec<Join> = (0..N).map(spring).collect();
        let mut matrix = Mat::<f64>::zeros(N, N);
        for &(a, b, damping) in dampers {
            for (i, j, sign) in [(a, a, 1.0), (a, b, -1.0), (b, a, -1.0), (b, b, 1.0)] {
                if i < N && j < N {
                    matrix[(i, j)] += sign * damping;
                }
            }
        }
        if as_matrix {
            return with_matrices(&masses, &springs, &[], [None, Some(matrix), None]);
        }
        let damper = |&(a, b, damping): &Join| (a + 1, (b + 1) % (N + 1), damping);
        let dampers: Vec<Join> = dampers.iter().map(damper).collect();
        network(&masses, &springs, &dampers)
    }

    #[test]
    fn a_damping_matrix_of_low_rank_is_as_good_as_its_dampers() {
        let ways: [&[Join]; 3] = [
            &[(7, 40, 3.0)],
            &[(7, 9, 3.0)],
            &[(3, 5, 2.0), (5, 8, 1e-9), (30, 40, 1e3)],
        ];
        for dampers in ways {
            let [elements, matrix] = [false, true].map(|as_matrix| {
                let system = chain(as_matrix, dampers);
                assert_eq!(LowRank.refuses(&system), None);
                let modes = system.modes_to(Precision::Double).expect("modes");
                assert_eq!(modes.plan().solver, LowRank.name());
                modes
            });
            let proven = chain(true, dampers).modes().expect("modes");
            assert_eq!(matrix.eigenvalues().len(), 80);
            for other in [&elements, &proven] {
                for (a, b) in matrix.eigenvalues().iter().zip(other.eigenvalues()) {
                    let off = (a.value - b.value).norm();
                    let most = a.bound.expect("known") + b.bound.expect("known");
                    assert!(off <= most && most < 1e-10 * a.value.norm(), "{a:?} {b:?}");
                }
            }
        }
    }

    #[test]
    fn a_damping_matrix_that_is_not_semidefinite_is_refused() {
        let system = chain(true, &[(7, 40, 3.0), (9, 12, -1e-3)]);
        assert!(added_columns(&system).is_none());
        assert!(LowRank.refuses(&system).is_some());
    }
}
