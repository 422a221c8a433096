//! Estimated bounds, in doubles, against proven answers.

use eigentone_modes::{Bounds, Eigenvalue, GROUND, LowRank, ModeSolver, Modes, Precision, System};
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
        let modes = LowRank.solve(&system).expect("few are enough");
        let proven = system.modes().expect("modes");
        prop_assert_eq!(proven.bounds(), Bounds::Proven);
        covered(&proven, &modes);
        for mode in &modes {
            prop_assert!(mode.eigenvalue().bound.is_some() || mode.roots() > 1);
            prop_assert!(mode.backward_error() <= 20.0 * U, "{}", mode.backward_error());
        }
    }
}

/// Rings of equal masses, damped alike, that a spring so much softer than their own holds: λ² + cλ + s = 0 for the smallest s of
/// 1/k = −Σ 1/(n (w − s)), w = 4 sin²(πj/n).
#[test]
fn softly_held_rings() {
    const C: f64 = 0.25;
    for n in [3usize, 5, 50, 100] {
        let squares =
            (1..n).map(|j| 4.0 * (std::f64::consts::PI * j as f64 / n as f64).sin().powi(2));
        let compliance: f64 = squares.map(|square| 1.0 / square).sum();
        for k in [1e-8, 1e-12, 1e-16, 1e-20, 1e-24, 1e-28, 1e-60] {
            let name = |i: usize| format!("m{}", i % n);
            let ring = (0..n).fold(System::builder(), |ring, i| ring.mass(name(i), 1.0));
            let ring = (0..n).fold(ring, |ring, i| {
                let ring = ring.spring(name(i), name(i + 1), 1.0);
                ring.damper(GROUND, name(i), C)
            });
            let system = ring.spring(GROUND, "m0", k).build().expect("a system");
            let share = k / n as f64;
            let square = share / (1.0 + share * compliance);
            let truth = -2.0 * square / (C + (C * C - 4.0 * square).sqrt());
            let modes = system.modes_to(Precision::Double).expect("modes");
            let sizes = modes.eigenvalues().iter();
            let slowest = sizes.min_by(|a, b| a.value.norm().total_cmp(&b.value.norm()));
            let slowest = slowest.expect("roots");
            let off = (slowest.value - truth).norm();
            // Of the closed form: w for w − s, and roundings.
            let slack = 1e-14 * truth.abs();
            let bound = slowest.bound.expect("a bound");
            assert!(off <= bound + slack, "{n} {k}: {slowest:?} for {truth}");
            assert!(bound <= 1e-12 * truth.abs(), "{n} {k}: {slowest:?}");
        }
    }
}
