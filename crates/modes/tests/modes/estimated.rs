//! Estimated bounds, in doubles, against proven answers.

use eigentone_modes::{Bounds, Eigenvalue, Modes, Precision};
use proptest::prelude::*;

use crate::networks::{Network, networks};

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

fn covered(proven: &Modes, modes: &Modes) {
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
