//! Laws that hold whatever the numbers are.

use eigentone_modes::{Bounds, Eigenvalue, GROUND, Modes, Motion, SparseModes, System};
use proptest::prelude::*;

use crate::networks::{Network, networks};
use crate::root::Join;

impl Network {
    fn modes(&self) -> Modes {
        let modes = self.system().modes().expect("modes");
        assert_eq!(modes.bounds(), Bounds::Proven, "{}", modes.plan());
        modes
    }

    fn scaled(&self, mass: f64, damping: f64, stiffness: f64) -> Network {
        let times = |joins: &[Join], factor: f64| {
            joins
                .iter()
                .map(|&(a, b, value)| (a, b, value * factor))
                .collect()
        };
        Network {
            masses: self.masses.iter().map(|value| value * mass).collect(),
            springs: times(&self.springs, stiffness),
            dampers: times(&self.dampers, damping),
        }
    }

    /// The last mass first, and elements the other way round.
    fn reversed(&self) -> Network {
        let n = self.masses.len();
        let end = |i: usize| if i == 0 { 0 } else { n + 1 - i };
        let turned = |joins: &[Join]| {
            joins
                .iter()
                .rev()
                .map(|&(a, b, value)| (end(b), end(a), value))
                .collect()
        };
        Network {
            masses: self.masses.iter().rev().copied().collect(),
            springs: turned(&self.springs),
            dampers: turned(&self.dampers),
        }
    }
}

/// Whether two lists of roots, one scaled by `factor`, agree within the bounds of both.
fn assert_same(first: &Modes, factor: f64, second: &Modes) {
    let mut left: Vec<Eigenvalue> = second.eigenvalues().to_vec();
    assert_eq!(first.eigenvalues().len(), left.len());
    assert_eq!(first.infinite(), second.infinite());
    assert_eq!(first.as_slice().len(), second.as_slice().len());
    for root in first.eigenvalues() {
        let expected = root.value * factor;
        let index = (0..left.len())
            .min_by(|&a, &b| {
                let distance = |root: &Eigenvalue| (root.value - expected).norm();
                distance(&left[a]).total_cmp(&distance(&left[b]))
            })
            .expect("as many are left");
        let found = left.swap_remove(index);
        let (bound, real_bound) = (
            factor * root.bound.expect("proven") + found.bound.expect("proven"),
            factor * root.real_bound.expect("proven") + found.real_bound.expect("proven"),
        );
        let off = found.value - expected;
        assert!(
            off.norm() <= bound,
            "{expected} and {}: {:e} > {bound:e}",
            found.value,
            off.norm()
        );
        assert!(
            off.re.abs() <= real_bound,
            "{expected} and {}: {:e}",
            found.value,
            off.re
        );
    }
}

fn config() -> ProptestConfig {
    ProptestConfig {
        cases: 100,
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

/// Of parts whose coordinates alternate, which are solved apart, and of sparse modes.
#[test]
fn components_are_found_by_name() {
    let system = System::builder()
        .mass("a", 1.0)
        .mass("c", 3.0)
        .mass("b", 2.0)
        .spring(GROUND, "a", 5.0)
        .spring("a", "b", 4.0)
        .spring(GROUND, "c", 7.0)
        .build()
        .expect("a system");
    let lowest = SparseModes::lowest(&system, 3).expect("sparse modes");
    for modes in [
        system.modes().expect("modes"),
        lowest.modes().expect("modes"),
    ] {
        assert_eq!(modes.len(), 3);
        for mode in &modes {
            for (name, entry) in ["a", "c", "b"].iter().zip(mode.shape()) {
                assert_eq!(mode.component(name).as_ref(), Ok(entry));
            }
            let error = mode.component("d").expect_err("no such name").to_string();
            let right = r#"there is no coordinate "d": there are "a", "c", "b""#;
            assert_eq!(error, right);
        }
    }
}

proptest! {
    #![proptest_config(config())]

    /// Other units of mass.
    #[test]
    fn scaling_all_parts_changes_nothing(network in networks(4.0, 3), power in -40i32..41) {
        let factor = 2f64.powi(power);
        assert_same(&network.modes(), 1.0, &network.scaled(factor, factor, factor).modes());
    }

    /// Other units of time.
    #[test]
    fn scaling_time_scales_every_root(network in networks(4.0, 3), power in -40i32..41) {
        let factor = 2f64.powi(power);
        let faster = network.scaled(1.0, factor, factor * factor);
        assert_same(&network.modes(), factor, &faster.modes());
    }

    #[test]
    fn the_order_of_nodes_and_elements_does_not_matter(network in networks(4.0, 3)) {
        assert_same(&network.modes(), 1.0, &network.reversed().modes());
    }

    #[test]
    fn runs_repeat(network in networks(4.0, 3)) {
        let system = network.system();
        prop_assert_eq!(system.modes(), system.modes());
    }

    #[test]
    fn roots_come_in_conjugate_pairs_and_do_not_grow(network in networks(4.0, 4)) {
        let modes = network.modes();
        let roots = modes.eigenvalues();
        for (i, root) in roots.iter().enumerate() {
            prop_assert!(root.value.re <= 0.0, "{root:?}");
            prop_assert_ne!(root.motion(), Motion::Growing);
            if root.value.im > 0.0 {
                let partners = roots.iter().filter(|other| **other == root.conjugate()).count();
                let equals = roots.iter().filter(|other| *other == root).count();
                prop_assert_eq!(partners, equals, "{:?}", roots[i]);
            }
        }
        let sizes: Vec<f64> = roots.iter().map(|root| root.value.norm()).collect();
        prop_assert!(sizes.is_sorted());
        let above = roots.iter().filter(|root| root.value.im > 0.0).count();
        let below = roots.iter().filter(|root| root.value.im < 0.0).count();
        prop_assert_eq!(above, below);
    }

    /// The largest component is 1 + 0i; within 1e-12 of it counts as a tie.
    #[test]
    fn shapes_have_one_scale(network in networks(4.0, 3)) {
        for mode in &network.modes() {
            let shape = mode.shape();
            prop_assert!(shape.iter().any(|x| x.re == 1.0 && x.im == 0.0), "{shape:?}");
            prop_assert!(shape.iter().all(|x| x.norm() <= 1.0 + 2e-12), "{shape:?}");
        }
    }

    #[test]
    fn nothing_damps_without_dampers(network in networks(8.0, 0)) {
        for mode in &network.modes() {
            prop_assert_eq!(mode.damping_ratio(), Some(0.0));
            prop_assert_eq!(mode.eigenvalue().value.re, 0.0);
            prop_assert_eq!(mode.eigenvalue().real_bound, Some(0.0));
        }
    }

    /// Without the ground there is one rigid motion: two zeros, and one where a damper holds it.
    #[test]
    fn rigid_motions_are_exactly_at_rest(network in networks(4.0, 3), held in any::<bool>()) {
        let mut free = network;
        free.springs.retain(|(a, b, _)| *a != 0 && *b != 0);
        free.dampers.retain(|(a, b, _)| *a != 0 && *b != 0);
        if held {
            free.dampers.push((0, 1, 0.25));
        }
        let modes = free.modes();
        let zeros = modes.eigenvalues().iter().filter(|root| root.value.norm() == 0.0);
        prop_assert_eq!(zeros.clone().count(), if held { 1 } else { 2 });
        for zero in zeros {
            prop_assert_eq!((zero.bound, zero.real_bound), (Some(0.0), Some(0.0)));
            prop_assert_eq!(zero.motion(), Motion::Rigid);
        }
        prop_assert_eq!(modes.eigenvalues().len(), 2 * free.masses.len());
    }

    /// det(λ²M + λC + K) of n coordinates has 2n roots, those at infinity included.
    #[test]
    fn finite_and_infinite_roots_make_2n(network in networks(3.0, 4), without in 0usize..64) {
        let mut network = network;
        for (i, mass) in network.masses.iter_mut().enumerate() {
            if without >> i & 1 == 1 {
                *mass = 0.0;
            }
        }
        let system = network.system();
        let modes = network.modes();
        prop_assert_eq!(modes.eigenvalues().len() + modes.infinite(), 2 * system.len());
        let structure = system.structure();
        prop_assert_eq!(structure.finite_roots(), Some(modes.eigenvalues().len()));
        prop_assert_eq!(structure.zero_roots(), Some(0));
        prop_assert!(modes.eigenvalues().iter().all(|root| root.value.norm() > 0.0));
    }
}
