//! Systems without springs: λ(λM + C)x = 0. Beside n roots at 0 they have those of λM + C, which
//! are −ω² of the undamped system that has each damper for a spring: these are known as well, and
//! for the same reasons, as its frequencies, however far apart the dampers are.

use crate::element::MatrixKind;
use crate::structure::Structure;
use crate::system::System;

/// The undamped system with the dampers for springs; `None` where there are springs or no dampers,
/// or M ≻ 0 and the symmetry of C are not proved.
pub(crate) fn with_dampers_for_springs(system: &System, structure: &Structure) -> Option<System> {
    let springs = system.springs().iter().map(|spring| spring.coefficient);
    let added = system.added(MatrixKind::Stiffness);
    let no_springs = springs.chain(added.map(|k| k.norm_max())).all(|k| k == 0.0);
    if !no_springs || structure.is_undamped() || !structure.is_classical() {
        return None;
    }
    let added = |kind| system.added(kind).map(|matrix| matrix.to_owned());
    Some(System::assemble(
        system.names().to_vec(),
        system.masses().to_vec(),
        system.dampers().to_vec(),
        Vec::new(),
        [added(MatrixKind::Mass), None, added(MatrixKind::Damping)],
    ))
}

#[cfg(test)]
mod tests {
    use crate::element::GROUND;
    use crate::{Bounds, ClassicalModes, Precision, System};

    /// Five masses of 1 kg in a chain, the first of which a damper of 1e-12 N·s/m ties to the
    /// ground, each next one 1e6 times as strong.
    fn chain() -> System {
        let name = |i: i32| format!("m{i}");
        let masses = (0..5).fold(System::builder(), |b, i| b.mass(name(i), 1.0));
        let dampers = [1e-12, 1e-6, 1.0, 1e6, 1e12].into_iter().zip(0..);
        let joined = dampers.fold(masses, |builder, (c, i)| {
            let from = if i == 0 {
                GROUND.to_owned()
            } else {
                name(i - 1)
            };
            builder.damper(from, name(i), c)
        });
        joined.build().unwrap()
    }

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
        let modes = chain().modes_to(Precision::Double).unwrap();
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

    #[test]
    fn so_do_the_rates_of_its_real_modes() {
        let modes = ClassicalModes::of(&chain()).unwrap().unwrap();
        let rates = modes.rates().iter().map(|rate| rate.map(|x| x.to_f64()));
        let mut rates: Vec<[f64; 2]> = rates.collect();
        rates.sort_by(|a, b| a[1].total_cmp(&b[1]));
        for ([stiffness, damping], known) in rates.into_iter().zip(EIGENVALUES) {
            assert_eq!(stiffness, 0.0);
            assert!(
                (damping - known).abs() <= 1e-14 * known,
                "{damping} {known}"
            );
        }
    }
}
