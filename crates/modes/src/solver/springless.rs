//! Systems without springs: λ(λM + C)x = 0. Beside n roots at 0 they have those of λM + C, which
//! are −ω² of the undamped system that has each damper for a spring: these are known as well, and
//! for the same reasons, as its frequencies, however far apart the dampers are.

use num_complex::Complex;

use crate::model::{Added, MatrixKind};
use crate::modes::Modes;
use crate::system::System;

use super::mode_solver::{ModeSolver, ModesError, admit};
use super::roots::{Root, collect};
use super::{rigid, spring_factor};

/// The frequencies of the undamped system that has the dampers for springs, by [`SpringFactor`]:
/// for systems of masses and positive dampers alone that have massless nodes.
///
/// [`SpringFactor`]: super::SpringFactor
#[derive(Clone, Copy, Debug)]
pub struct DamperFactor;

impl ModeSolver for DamperFactor {
    fn name(&self) -> &'static str {
        "damper factor"
    }

    fn refuses(&self, system: &System) -> Option<String> {
        let structure = system.structure();
        if !has_no_springs(system) || structure.is_undamped() {
            return Some(
                "it takes systems of masses and dampers alone, without springs".to_owned(),
            );
        }
        if structure.massless().is_empty() {
            return Some("there are no massless nodes".to_owned());
        }
        if system.added(MatrixKind::Damping).is_some() {
            return Some("the system has a damping matrix, not dampers alone".to_owned());
        }
        spring_factor::refuses_springs(&turned(system))
    }

    fn reason(&self) -> &'static str {
        "without springs: relaxation rates are squared frequencies of the dampers taken for springs"
    }

    fn solve(&self, system: &System) -> Result<Modes, ModesError> {
        admit(self, system)?;
        let undamped = turned(system);
        let modes = spring_factor::real_modes(self, &undamped)?;
        let elastic = modes.into_iter().filter(|mode| !mode.rigid);
        let relaxing = elastic.map(|mode| {
            let error = mode.square_error() * mode.square;
            Root {
                error: Some((error, error)),
                ..Root::simple(Complex::from(-mode.square), mode.complex_shape())
            }
        });
        let mut roots: Vec<Root> = relaxing.collect();
        // Nothing resists any displacement.
        let n = system.len();
        let unit = |i: usize| {
            let mut shape = vec![Complex::ZERO; n];
            shape[i] = Complex::ONE;
            shape
        };
        let zeros = system.structure().zero_roots().unwrap_or(n);
        roots.extend(rigid::roots((0..n).map(unit).collect(), zeros));
        Ok(collect(self, system, roots))
    }
}

/// The undamped system with the dampers for springs; `None` where there are springs or no dampers,
/// or M ≻ 0 and the symmetry of C are not proved.
pub(crate) fn with_dampers_for_springs(system: &System) -> Option<System> {
    let structure = system.structure();
    let applies = has_no_springs(system) && !structure.is_undamped() && structure.is_classical();
    applies.then(|| turned(system))
}

fn has_no_springs(system: &System) -> bool {
    let springs = system.springs().iter().map(|spring| spring.coefficient);
    let added = system.added(MatrixKind::Stiffness);
    springs.chain(added.map(|k| k.norm_max())).all(|k| k == 0.0)
}

/// The dampers for springs, and no dampers.
fn turned(system: &System) -> System {
    let added = |kind| system.model().added_whole(kind).clone();
    System::assemble(
        system.names().to_vec(),
        system.masses().to_vec(),
        system.dampers().to_vec(),
        Vec::new(),
        [
            added(MatrixKind::Mass),
            Added::default(),
            added(MatrixKind::Damping),
        ],
    )
}

#[cfg(test)]
mod tests {
    use crate::structure::samples::chain;
    use crate::{Bounds, ClassicalModes, Precision, System};
    use eigentone_digits::sort_by_number;

    /// Five masses of 1 kg in a chain, the first of which a damper of 1e-12 N·s/m ties to the
    /// ground, each next one 1e6 times as strong.
    fn graded() -> System {
        chain(&[1.0; 5], &[], &DAMPERS)
    }

    const DAMPERS: [f64; 5] = [1e-12, 1e-6, 1.0, 1e6, 1e12];

    /// Of C, by FLINT.
    const EIGENVALUES: [f64; 5] = [
        1.999_998_719_999_894_4e-13,
        1.250_000_096_874_551_8e-6,
        1.333_333_490_741_032_3,
        1_500_000.291_667_071_8,
        2_000_000_500_000.375,
    ];

    #[test]
    fn graded_dampers_keep_their_digits_in_doubles() {
        let modes = graded().modes_to(Precision::Double).unwrap();
        assert_eq!(modes.bounds(), Bounds::Estimated);
        let roots = modes.eigenvalues();
        assert_eq!(roots.len(), 10);
        assert!(roots[..5].iter().all(|root| root.value.norm() == 0.0));
        for (root, known) in roots[5..].iter().zip(EIGENVALUES) {
            let error = (root.value + known).norm();
            assert!(error <= 1e-14 * known, "{} {known}", root.value);
            assert!(error <= root.bound.unwrap());
        }
    }

    /// The same chain with each damper made of two of twice its strength, a massless node between.
    #[test]
    fn so_they_do_through_massless_nodes() {
        let masses: Vec<f64> = (0..10).map(|i| f64::from(i % 2)).collect();
        let dampers = DAMPERS.iter().flat_map(|c| [2.0 * c; 2]);
        let system = chain(&masses, &[], &dampers.collect::<Vec<_>>());
        let modes = system.modes_to(Precision::Double).unwrap();
        assert_eq!(modes.infinite(), 5);
        let roots = modes.eigenvalues();
        assert_eq!(roots.len(), 15);
        assert!(roots[..10].iter().all(|root| root.value.norm() == 0.0));
        for (root, known) in roots[10..].iter().zip(EIGENVALUES) {
            let error = (root.value + known).norm();
            assert!(error <= 1e-14 * known, "{} {known}", root.value);
            assert!(error <= root.bound.unwrap());
        }
        for mode in &modes {
            assert!(mode.backward_error() <= 1e-15, "{}", mode.backward_error());
        }
    }

    #[test]
    fn so_do_the_rates_of_its_real_modes() {
        let modes = ClassicalModes::of(&graded()).unwrap().unwrap();
        let rates = modes.rates().iter().map(|rate| rate.map(|x| x.to_f64()));
        let mut rates: Vec<[f64; 2]> = rates.collect();
        sort_by_number(&mut rates, |rate| rate[1]);
        for ([stiffness, damping], known) in rates.into_iter().zip(EIGENVALUES) {
            assert_eq!(stiffness, 0.0);
            let off = (damping - known).abs();
            assert!(off <= 1e-14 * known, "{damping} {known}");
        }
    }
}
