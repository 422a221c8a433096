//! Few dampers: the undamped modes, and a determinant of the order of C's rank.

use faer::Mat;
use num_complex::Complex;

use crate::model::{MatrixKind, Node};
use crate::modes::Modes;
use crate::quality::pencil::products;
use crate::quality::real_forms::Entries;
use crate::structure::Structure;
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

    fn refuses(&self, system: &System, structure: &Structure) -> Option<String> {
        if let Some(reason) = ModalMatrix.refuses(system, structure) {
            return Some(reason);
        }
        if !structure.is_passive() {
            return Some("the system is not proved passive".to_owned());
        }
        let n = system.len();
        let dampers = system.dampers().len();
        if system.added(MatrixKind::Damping).is_some() {
            return Some("the system has a damping matrix, not dampers alone".to_owned());
        }
        if n < SMALLEST || 2 * dampers * dampers > n {
            return Some(format!(
                "it is quicker only with far fewer dampers than coordinates: dampers {dampers}, coordinates {n}"
            ));
        }
        let rigid = structure.rigid_motions() != Some(0);
        rigid.then(|| "springs do not hold every motion".to_owned())
    }

    fn reason(&self) -> &'static str {
        "passive, with few dampers: a determinant of their number over the undamped modes"
    }

    fn solve(&self, system: &System, structure: &Structure) -> Result<Modes, ModesError> {
        admit(self, system, structure)?;
        let undamped = structure.undamped_modes().unwrap_or(0);
        let modes = classical::real_modes(self, system, structure, Entries::Plain)?;
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
            return ModalMatrix.solve(system, structure);
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
        let mut roots = refine_simple(system, structure, simple.collect(), &radii);
        roots.extend(undamped_roots(apart));
        Ok(collect(self, system, roots))
    }
}

/// The rows of U: √c times the stretch of each damper in each shape.
fn factor(system: &System, modes: &[RealMode]) -> Vec<Vec<f64>> {
    let row = |mode: &RealMode| {
        let at = |node: Node| node.coordinate().map_or(0.0, |i| mode.shape[i]);
        let dampers = system.dampers().iter();
        let stretch = dampers
            .map(|damper| damper.coefficient.sqrt() * (at(damper.first) - at(damper.second)));
        stretch.collect()
    };
    modes.iter().map(row).collect()
}
