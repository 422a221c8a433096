//! Estimated bounds, in doubles, against proven answers.

use eigentone_modes::{Bounds, Eigenvalue, LowRank, ModeSolver, Modes, Precision};
use proptest::prelude::*;

use crate::networks::{Network, networks, wide};
use crate::root::U;

/// Every root in doubles lies within both bounds of the proven one that is nearest.
fn assert_covered(network: &Network) {
    let system = network.system();
    let (Ok(proven), Ok(modes)) = (system.modes(), system.modes_to(Precision::Double)) else {
        return;
    };
    if proven.bounds() != Bounds::Proven {
        return;
    }
    covered(&proven, &modes);
}

pub(crate) fn covered(proven: &Modes, modes: &Modes) {
    let mut left: Vec<Eigenvalue> = proven.eigenvalues().to_vec();
    assert_eq!(modes.eigenvalues().len(), left.len());
    let mut found = modes.eigenvalues().to_vec();
    // Roots that are known better choose first.
    let relative = |root: &Eigenvalue| root.bound.unwrap_or(f64::INFINITY) / root.value.norm();
    found.sort_by(|a, b| relative(a).total_cmp(&relative(b)));
    for root in found {
        let distance = |other: &Eigenvalue| (other.value - root.value).norm();
        let nearest = (0..left.len())
            .min_by(|&a, &b| distance(&left[a]).total_cmp(&distance(&left[b])))
            .expect("as many are left as there are");
        let truth = left.swap_remove(nearest);
        let (Some(bound), Some(real_bound)) = (root.bound, root.real_bound) else {
            continue;
        };
        let off = truth.value - root.value;
        let slack = truth.bound.expect("proven");
        assert!(off.norm() <= bound + slack, "{truth:?} found as {root:?}");
        let slack = truth.real_bound.expect("proven");
        assert!(
            off.re.abs() <= real_bound + slack,
            "{truth:?} found as {root:?}"
        );
    }
}

fn config() -> ProptestConfig {
    ProptestConfig {
        cases: 200,
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn moderate_networks(network in networks(2.0, 4)) {
        assert_covered(&network);
    }

    #[test]
    fn wide_networks(network in networks(6.0, 4)) {
        assert_covered(&network);
    }

    #[test]
    fn very_wide_networks(network in networks(12.0, 3)) {
        assert_covered(&network);
    }

    #[test]
    fn very_wide_networks_without_dampers(network in networks(15.0, 0)) {
        assert_covered(&network);
    }
}

/// Chains with few dampers, from weak ones to such that they all but lock.
fn chains() -> impl Strategy<Value = Network> {
    (18usize..36).prop_flat_map(|n| {
        let damper = (0..=n, 1..n, wide(3.0));
        let damper = damper.prop_map(move |(a, step, c)| (a, (a + step) % (n + 1), c));
        (
            prop::collection::vec(wide(0.5), n),
            prop::collection::vec(wide(0.5), n + 1),
            prop::collection::vec(damper, 1..4),
        )
            .prop_map(move |(masses, springs, dampers)| {
                let springs = springs.into_iter().enumerate();
                let springs = springs.map(|(i, k)| (i, (i + 1) % (n + 1), k)).collect();
                Network {
                    masses,
                    springs,
                    dampers,
                }
            })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..config() })]

    #[test]
    fn few_dampers(network in chains()) {
        let system = network.system();
        let modes = LowRank.solve(&system, system.structure()).expect("few are enough");
        let proven = system.modes().expect("modes");
        prop_assert_eq!(proven.bounds(), Bounds::Proven);
        covered(&proven, &modes);
        for mode in &modes {
            prop_assert!(mode.eigenvalue().bound.is_some() || mode.roots() > 1);
            prop_assert!(mode.backward_error() <= 20.0 * U, "{}", mode.backward_error());
        }
    }
}
