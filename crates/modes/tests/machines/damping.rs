//! Rayleigh and modal damping: exact products, couplings to supports, and what is known of such systems.

use eigentone_modes::{
    Beam, BeamEnd, Bounds, BuildError, ElementKind, GROUND, MatrixKind, Mode, Modes, Motion,
    Precision, Rod, RodEnd, SparseModes, System, SystemBuilder,
};

/// Three storeys on a soil; numbers whose products are no doubles.
fn building() -> SystemBuilder {
    System::builder()
        .mass("a", 3.1)
        .mass("b", 2.7)
        .mass("c", 1.9)
        .support("soil")
        .spring("soil", "a", 310.1)
        .spring("a", "b", 270.3)
        .spring("b", "c", 190.7)
}

fn ratios(modes: &Modes) -> Vec<f64> {
    let each = modes
        .iter()
        .map(|mode| mode.damping_ratio().expect("it swings"));
    each.collect()
}

#[test]
fn ratios_of_rayleigh_damping() {
    let (alpha, beta) = (0.3, 0.007);
    let system = building()
        .rayleigh(alpha, beta, Some("soil"))
        .build()
        .expect("a system");
    let structure = system.structure();
    assert!(structure.is_classical() && structure.is_passive());
    let modes = system.modes().expect("modes");
    assert_eq!(modes.bounds(), Bounds::Proven);
    for mode in &modes {
        let omega = mode.natural_frequency().radians_per_second();
        let zeta = 0.5 * (alpha / omega + beta * omega);
        assert!((mode.damping_ratio().expect("it swings") / zeta - 1.0).abs() < 1e-15);
    }
    // What was given is what was given.
    assert!(system.elements(ElementKind::Damper).is_empty());
    assert_eq!(system.elements(ElementKind::Spring).len(), 3);
    assert!(
        system
            .dampers()
            .iter()
            .all(|damper| damper.coefficient > 0.0)
    );
}

/// Rotations without mass relax with −1/β, all others as the undamped modes say, some of them nearly with −1/β.
#[test]
fn rotations_without_mass_relax_with_the_damping_of_stiffness() {
    let (alpha, beta) = (0.1, 1e-4);
    for elements in [10, 40, 100] {
        let beam = || {
            System::builder().beam(Beam {
                name: "b".to_owned(),
                length: 2.0,
                elements,
                flexural_rigidity: 100.0,
                mass_per_length: 1.0,
                ends: [BeamEnd::Clamped, BeamEnd::Pinned],
                lumped: true,
            })
        };
        let undamped = beam().build().expect("a system").modes().expect("modes");
        let mut known = vec![-1.0 / beta; elements];
        let mut pairs = Vec::new();
        for mode in &undamped {
            let omega = mode.natural_frequency().radians_per_second();
            let half = 0.5 * (alpha + beta * omega * omega);
            if half < omega {
                pairs.push([-half, ((omega - half) * (omega + half)).sqrt()]);
            } else {
                let large = half + ((half - omega) * (half + omega)).sqrt();
                known.extend([-large, -omega * omega / large]);
            }
        }
        let system = beam().rayleigh(alpha, beta, None).build();
        let modes = system.expect("a system").modes().expect("modes");
        assert_eq!(
            modes.bounds(),
            Bounds::Proven,
            "{elements}: {}",
            modes.plan()
        );
        let is_common = |mode: &&Mode| mode.multiplicity() == Some(elements);
        assert_eq!(modes.iter().filter(is_common).count(), elements);
        let (mut real, mut oscillating) = (Vec::new(), Vec::new());
        for root in modes.eigenvalues() {
            assert!(
                root.bound.expect("proven") <= 3e-16 * root.value.norm(),
                "{root:?}"
            );
            match root.value.im {
                0.0 => real.push(root.value.re),
                im if im > 0.0 => oscillating.push([root.value.re, im]),
                _ => {}
            }
        }
        known.sort_by(f64::total_cmp);
        real.sort_by(f64::total_cmp);
        oscillating.sort_by(|a, b| a[1].total_cmp(&b[1]));
        pairs.sort_by(|a, b| a[1].total_cmp(&b[1]));
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs();
        assert_eq!([real.len(), oscillating.len()], [known.len(), pairs.len()]);
        assert!(
            real.iter().zip(&known).all(|(a, b)| near(*a, *b)),
            "{elements}"
        );
        let mut each = oscillating.iter().flatten().zip(pairs.iter().flatten());
        assert!(each.all(|(a, b)| near(*a, *b)), "{elements}");
    }
}

fn summed(system: &System, kind: MatrixKind, row: usize) -> f64 {
    let terms = system.coupling(kind).iter();
    terms
        .filter(|term| term.row == row)
        .map(|term| term.value)
        .sum()
}

/// On its soil everything follows alike: −αM·1 − β·K·1 goes to the soil's velocity.
#[test]
fn damping_relative_to_the_soil_follows_it() {
    let relative = building()
        .rayleigh(0.5, 0.25, Some("soil"))
        .build()
        .expect("a system");
    let absolute = building()
        .rayleigh(0.5, 0.25, None)
        .build()
        .expect("a system");
    let damping = MatrixKind::Damping;
    for (i, mass) in [3.1, 2.7, 1.9].into_iter().enumerate() {
        let spring = if i == 0 { -0.25 * 310.1 } else { 0.0 };
        assert_eq!(summed(&relative, damping, i), spring - 0.5 * mass);
        assert_eq!(summed(&absolute, damping, i), spring);
    }
}

/// A carried mass of 8 moves with 0.5x + 0.25s: M = 3, M_s = 1. K = 2 holds x at s, so that r = 1.
#[test]
fn carried_masses_follow_too() {
    let lever = || {
        System::builder()
            .mass("x", 1.0)
            .support("s")
            .support("t")
            .point("p", [("x", 0.5), ("s", 0.25), ("t", 0.125)], 8.0)
            .spring("x", "s", 2.0)
    };
    let of = |system: &System, column: usize| {
        let terms = system.coupling(MatrixKind::Damping).iter();
        let own = terms.filter(|term| term.column == column);
        own.map(|term| term.value).sum::<f64>()
    };
    let relative = lever()
        .rayleigh(0.5, 0.0, Some("s"))
        .build()
        .expect("a system");
    assert_eq!([of(&relative, 0), of(&relative, 1)], [-1.5, 0.25]);
    let absolute = lever().rayleigh(0.5, 0.0, None).build().expect("a system");
    assert_eq!([of(&absolute, 0), of(&absolute, 1)], [0.5, 0.25]);
}

/// Between two supports, x follows the first by k₁/(k₁ + k₂) = 0.1/0.3 of its motion.
#[test]
fn what_follows_in_part() {
    let between = System::builder()
        .mass("x", 3.0)
        .support("s")
        .spring("x", "s", 1.0)
        .spring("x", GROUND, 2.0)
        .rayleigh(1.0, 0.0, Some("s"))
        .build()
        .expect("a system");
    let parts: Vec<f64> = between
        .coupling(MatrixKind::Damping)
        .iter()
        .map(|term| term.value)
        .collect();
    // −3·(1/3), right to 2^-156.
    assert_eq!(parts.iter().sum::<f64>(), -1.0);
    assert!(
        parts.len() <= 4 && parts[1..].iter().all(|part| part.abs() < 1e-46),
        "{parts:?}"
    );
    let floating = building().mass("far", 1.0).rayleigh(1.0, 0.0, Some("soil"));
    let floating = floating.spring("a", GROUND, 1.0).build();
    assert!(
        matches!(floating, Err(BuildError::NotHeld { .. })),
        "{floating:?}"
    );
}

/// Points, beams and given matrices are damped as well.
#[test]
fn everything_is_damped_in_proportion() {
    let plain = || {
        System::builder()
            .mass("x", 0.7)
            .mass("y", 1.3)
            .point("p", [("x", 0.6), ("y", -0.8)], 0.9)
            .spring("p", GROUND, 1e8)
            .spring("y", GROUND, 3.0)
    };
    let system = plain().rayleigh(0.1, 0.2, None).build().expect("a system");
    assert!(system.structure().is_passive() && system.structure().is_classical());
    let matrix = faer::mat![[2.0, -1.0], [-1.0, 2.0]];
    let given = plain().matrix(MatrixKind::Stiffness, matrix.as_ref());
    let given = given.rayleigh(0.1, 0.2, None).build().expect("a system");
    for system in [system, given] {
        assert!(system.structure().is_classical());
        let [m, c, k] = [
            system.mass_matrix(),
            system.damping_matrix(),
            system.stiffness_matrix(),
        ];
        for i in 0..2 {
            for j in 0..2 {
                let expected = 0.1 * m[(i, j)] + 0.2 * k[(i, j)];
                assert!((c[(i, j)] - expected).abs() <= 2e-16 * expected.abs());
            }
        }
    }
}

/// Linear in the number of coordinates: a second for a hundred thousand, not an hour.
#[test]
fn a_long_chain_is_seen_to_be_damped_in_proportion() {
    let n = 100_000;
    let name = |i: usize| {
        if i == 0 {
            GROUND.to_owned()
        } else {
            format!("m{i}")
        }
    };
    let chain = (1..=n).fold(System::builder(), |builder, i| {
        let builder = builder.mass(name(i), 1.0 + 0.1 * (i % 7) as f64);
        builder.spring(name(i - 1), name(i), 100.1 + (i % 11) as f64)
    });
    let start = std::time::Instant::now();
    let system = chain.rayleigh(0.0, 0.003, None).build().expect("a system");
    let built = start.elapsed();
    let modes = SparseModes::lowest(&system, 5).expect("modes");
    println!("{n}: built in {built:?}, modes after {:?}", start.elapsed());
    assert!(system.structure().is_classical());
    assert_eq!(modes.len(), 5);
}

#[test]
fn modal_ratios_are_those_given() {
    for (given, expected) in [
        (vec![0.05], [0.05, 0.05, 0.05]),
        (vec![0.02, 0.3, 0.0], [0.02, 0.3, 0.0]),
        (vec![0.02, 0.05], [0.02, 0.05, 0.05]),
    ] {
        let beside = building()
            .mass("node", 0.0)
            .spring("node", "c", 3.0)
            .spring("node", "a", 1.0);
        for builder in [building(), beside] {
            let system = builder.modal_damping(given.clone(), None).build();
            let modes = system.expect("a system").modes().expect("modes");
            assert_eq!(modes.bounds(), Bounds::Proven, "{}", modes.plan());
            for (found, expected) in ratios(&modes).into_iter().zip(expected) {
                let off = (found - expected).abs();
                assert!(off <= 4.5e-16 * expected, "{found} {expected}");
            }
        }
    }
}

/// The pair of a ratio of 1 is no two modes, with a node without mass or not: what its rounded matrix would separate is not claimed.
#[test]
fn critical_modal_damping_is_left_open() {
    for node in [false, true] {
        let builder = match node {
            true => building().mass("node", 0.0).spring("node", "c", 3.0),
            false => building(),
        };
        let system = builder.modal_damping([1.0], None).build();
        let modes = system.expect("a system").modes().expect("modes");
        let open = modes
            .iter()
            .filter(|mode| mode.motion() == Motion::Doubtful);
        assert_eq!((open.count(), modes.len()), (3, 3), "{}", modes.plan());
    }
}

/// Beside dampers, with a node without mass, and relative to the soil: −C r for C the modal part.
#[test]
fn modal_damping_beside_others() {
    let system = building()
        .mass("node", 0.0)
        .spring("node", "c", 3.0)
        .spring("node", "a", 1.0)
        .damper("a", "b", 0.7)
        .modal_damping([0.1], Some("soil"))
        .build()
        .expect("a system");
    let c = system.damping_matrix();
    assert!((0..4).all(|i| c[(3, i)] == 0.0 && c[(i, 3)] == 0.0));
    let damping = MatrixKind::Damping;
    for i in 0..3 {
        let own: f64 = (0..3).map(|j| c[(i, j)]).sum();
        assert!((summed(&system, damping, i) + own).abs() < 1e-14);
    }
    assert_eq!(system.modes().expect("modes").bounds(), Bounds::Proven);
}

fn free_chain(builder: SystemBuilder, [a, b, c]: [&str; 3]) -> SystemBuilder {
    let builder = builder.mass(a, 3.1).mass(b, 0.7).mass(c, 1.9);
    builder.spring(a, b, 270.3).spring(b, c, 190.7)
}

/// What nothing holds is not damped: chains, two of them beside each other, a bar that heaves and pitches, with a node
/// without mass.
#[test]
fn modal_damping_leaves_rigid_motions_alone() {
    let one = || free_chain(System::builder(), ["a", "b", "c"]);
    let two = free_chain(one(), ["d", "e", "f"]);
    let bar = System::builder()
        .mass("heave", 3.1)
        .mass("pitch", 1.3)
        .mass("rider", 0.9)
        .mass("guest", 0.4)
        .point("front", [("heave", 1.0), ("pitch", 1.25)], 0.0)
        .point("rear", [("heave", 1.0), ("pitch", -0.75)], 0.0)
        .spring("front", "rider", 33.3)
        .spring("rear", "guest", 71.7);
    let node = one()
        .mass("node", 0.0)
        .spring("node", "a", 3.0)
        .spring("node", "c", 5.0);
    for (builder, rigid) in [(one(), 1), (two, 2), (bar, 2), (node, 1)] {
        let system = builder
            .modal_damping([0.05], None)
            .build()
            .expect("a system");
        assert_eq!(system.structure().zero_roots(), Some(2 * rigid));
        let modes = system.modes().expect("modes");
        assert_eq!(modes.bounds(), Bounds::Proven, "{}", modes.plan());
        let (still, moving): (Vec<_>, Vec<_>) = modes
            .iter()
            .partition(|mode| mode.motion() == Motion::Rigid);
        // One entry for all, as none of them has as many shapes as roots.
        assert!(!still.is_empty());
        assert!(
            still
                .iter()
                .all(|mode| mode.multiplicity() == Some(2 * rigid))
        );
        for mode in moving {
            let ratio = mode.damping_ratio().expect("it swings");
            assert!((ratio - 0.05).abs() <= 2e-17, "{ratio}");
        }
    }
}

/// Free beams, whose rotation is no binary fraction: nothing damps what no spring resists, and nothing grows. A dashpot beside takes
/// one root at 0 of one motion.
#[test]
fn free_beams_with_modal_damping() {
    for elements in [1, 2, 5, 12] {
        for length in [0.3, 1.0, 1.4, 1.7] {
            let beam = Beam {
                name: "b".to_owned(),
                length,
                elements,
                flexural_rigidity: 10.0,
                mass_per_length: 2.0,
                ends: [BeamEnd::Free; 2],
                lumped: false,
            };
            let free = System::builder().beam(beam).modal_damping([0.02], None);
            let system = free.clone().build().expect("a system");
            let structure = system.structure();
            assert!(structure.is_passive() && structure.is_classical());
            assert_eq!(structure.zero_roots(), Some(4));
            let modes = system.modes().expect("modes");
            assert_eq!(modes.bounds(), Bounds::Proven);
            let elastic = modes.iter().filter(|mode| mode.motion() != Motion::Rigid);
            let mut count = 0;
            for mode in elastic {
                let ratio = mode.damping_ratio().expect("it swings");
                assert!((ratio - 0.02).abs() <= 1e-17, "{ratio}");
                count += 1;
            }
            assert_eq!(count, 2 * elements);

            let system = free.damper(GROUND, "b.0.w", 0.3).build().expect("a system");
            let structure = system.structure();
            assert!(structure.is_passive() && !structure.is_classical());
            assert_eq!(structure.zero_roots(), Some(3));
            let modes = system.modes().expect("modes");
            let falls = |mode: &eigentone_modes::Mode| mode.eigenvalue().value.re <= 0.0;
            assert!(modes.iter().all(falls), "{modes:?}");
        }
    }
}

/// Ratios of 0, 1, above 1 and below 0 are what they are given as: λ = −ζω ± ω√(ζ² − 1) for the ω of the same system without damping.
#[test]
fn ratios_of_every_kind() {
    let undamped = building()
        .build()
        .expect("a system")
        .modes()
        .expect("modes");
    let frequency = |k: usize| undamped[k].natural_frequency().radians_per_second();
    for ratios in [
        [0.0, 0.05, 0.0],
        [0.05, 0.0, 0.0],
        [0.3, 1.0, 0.0],
        [2.0, 1.5, 3.0],
        [0.1, -0.1, 0.0],
        [1.0, 1.0, 1.0],
    ] {
        let system = building()
            .modal_damping(ratios, None)
            .build()
            .expect("a system");
        let structure = system.structure();
        let are = |kind: fn(f64) -> bool| ratios.iter().filter(|ratio| kind(**ratio)).count();
        assert!(structure.is_classical());
        assert_eq!(structure.is_passive(), are(|ratio| ratio < 0.0) == 0);
        assert_eq!(structure.is_overdamped(), are(|ratio| ratio > 1.0) == 3);
        assert_eq!(structure.undamped_modes(), Some(are(|ratio| ratio == 0.0)));
        assert_eq!(structure.damping_rank(), Some(are(|ratio| ratio != 0.0)));
        let modes = system.modes().expect("modes");
        assert_eq!(modes.bounds(), Bounds::Proven, "{ratios:?}");
        for (k, zeta) in ratios.into_iter().enumerate() {
            let omega = frequency(k);
            let (re, im) = (-zeta * omega, omega * (1.0 - zeta * zeta).max(0.0).sqrt());
            let apart = omega * (zeta * zeta - 1.0).max(0.0).sqrt();
            for re in [re - apart, re + apart] {
                // A root of double multiplicity is where half the digits place it.
                let near = modes.iter().filter(|mode| {
                    let value = mode.eigenvalue().value;
                    (value.re - re).hypot(value.im - im) <= 1e-13 * omega
                });
                assert!(near.count() > 0, "{re} ± {im}i of {ratios:?}: {modes:?}");
            }
        }
        let still = modes
            .iter()
            .filter(|mode| mode.eigenvalue().value.re == 0.0);
        assert_eq!(
            still.count(),
            are(|ratio| ratio == 0.0),
            "{ratios:?}: {modes:?}"
        );
    }
}

/// Rigid motions of levers are no doubles: they are still all the same, whatever the rounding of C.
#[test]
fn levers_with_modal_damping() {
    let levers = || {
        System::builder()
            .mass("a", 7.0)
            .mass("b", 9.0)
            .mass("c", 2.0)
            .point("p", [("a", 3.7), ("b", -7.9)], 0.0)
            .spring(GROUND, "p", 1.0)
    };
    // vᵀM⁻¹v for the lever v.
    let square: f64 = 3.7 * 3.7 / 7.0 + 7.9 * 7.9 / 9.0;
    for ratio in [0.02, 1.0, 1.5] {
        let system = levers()
            .modal_damping([ratio], None)
            .build()
            .expect("a system");
        assert_eq!(system.structure().zero_roots(), Some(4));
        assert!(system.structure().damps_rigid_motions_by_rounding());
        let modes = system.modes().expect("modes");
        assert_eq!(modes.bounds(), Bounds::Proven, "{ratio}");
        let eigenvalues = modes.eigenvalues();
        let zeros = eigenvalues.iter().filter(|root| root.value.norm() == 0.0);
        assert_eq!((zeros.count(), eigenvalues.len()), (4, 6), "{modes:?}");
        let swings = modes.iter().filter(|mode| mode.motion() != Motion::Rigid);
        for mode in swings {
            let [re, im] = [mode.eigenvalue().value.re, mode.eigenvalue().value.im];
            // λ² + 2ζωλ + ω² = 0.
            let left = (re * re - im * im + 2.0 * ratio * square.sqrt() * re + square).abs();
            assert!(left < 1e-12 && re < 0.0, "{ratio}: {re} ± {im}i");
        }
    }
}

/// Lumped beams have rotations without mass.
#[test]
fn lumped_beams_with_modal_damping() {
    let beam = |ends, ratios: &[f64]| {
        let beam = Beam {
            name: "b".to_owned(),
            length: 1.1,
            elements: 5,
            flexural_rigidity: 10.0,
            mass_per_length: 2.0,
            ends,
            lumped: true,
        };
        let damped = System::builder().beam(beam).modal_damping(ratios, None);
        damped.build().expect("a system")
    };
    for (ends, zeros) in [
        ([BeamEnd::Pinned, BeamEnd::Free], 2),
        ([BeamEnd::Free, BeamEnd::Free], 4),
        ([BeamEnd::Clamped, BeamEnd::Free], 0),
    ] {
        for ratios in [&[0.02][..], &[0.3, 0.0]] {
            let system = beam(ends, ratios);
            let structure = system.structure();
            assert_eq!(structure.zero_roots(), Some(zeros));
            assert!(structure.is_passive(), "{structure}");
            let modes = system.modes().expect("modes");
            let eigenvalues = modes.eigenvalues();
            let still = eigenvalues.iter().filter(|root| root.value.norm() == 0.0);
            assert_eq!(still.count(), zeros);
            assert_eq!(Some(eigenvalues.len()), structure.finite_roots());
            // By their order, rigid motions first.
            let ratio = |r: usize| ratios[r.min(ratios.len() - 1)];
            let swings = modes.iter().filter(|mode| mode.motion() != Motion::Rigid);
            for (r, mode) in (zeros / 2..).zip(swings) {
                let found = mode.damping_ratio().expect("it swings");
                assert!((found - ratio(r)).abs() <= 1e-15, "{r}: {found}");
                assert_ne!(mode.motion(), Motion::Growing);
            }
        }
    }
}

#[test]
fn what_is_wrong_is_said() {
    let wrong = |builder: SystemBuilder| builder.build().expect_err("wrong");
    let two = || {
        let names = System::builder().mass("a", 1.0).mass("b", 1.0);
        names.spring(GROUND, "a", 2.0).spring(GROUND, "b", 2.0)
    };
    let equal = wrong(two().modal_damping([0.1, 0.2], None));
    assert!(
        matches!(equal, BuildError::EqualModes { mode: 0, .. }),
        "{equal}"
    );
    assert!(two().modal_damping([0.1], None).build().is_ok());
    let no_modes = |builder: SystemBuilder| {
        let error = wrong(builder);
        assert!(matches!(error, BuildError::NoModes { .. }), "{error}");
    };
    no_modes(two().spring("a", GROUND, -9.0).modal_damping([0.1], None));
    let skew = faer::mat![[0.0, 0.5], [0.0, 0.0]];
    no_modes(
        two()
            .matrix(MatrixKind::Stiffness, skew.as_ref())
            .modal_damping([0.1], None),
    );
    let indefinite = faer::mat![[-2.0, 0.0], [0.0, 0.0]];
    no_modes(
        two()
            .matrix(MatrixKind::Mass, indefinite.as_ref())
            .modal_damping([0.1], None),
    );
    assert_eq!(wrong(two().modal_damping([], None)), BuildError::NoRatios);
    let (count, modes) = (3, 2);
    assert_eq!(
        wrong(two().modal_damping([0.1, 0.2, 0.3], None)),
        BuildError::ManyRatios { count, modes }
    );
    let infinite = wrong(two().rayleigh(f64::INFINITY, 0.0, None));
    assert!(matches!(infinite, BuildError::DampingNotFinite { .. }));
    let far = wrong(two().rayleigh(1e-300, 0.0, None));
    assert_eq!(far, BuildError::DampingRange);
    for builder in [
        two().rayleigh(1.0, 1.0, Some("a")),
        two().modal_damping([0.1], Some("a")),
    ] {
        assert!(matches!(wrong(builder), BuildError::NotASupport { .. }));
    }
}

/// Mass matrices of long beams and rods are no sums of lumped masses, and are proved definite all the same: their damping is
/// known to be Rayleigh's, and none of the lowest modes of a rod to be missing.
#[test]
fn long_beams_and_rods_are_damped_in_proportion() {
    let (alpha, beta) = (0.1, 1e-5);
    let beam = Beam {
        name: "mast".to_owned(),
        length: 2.0,
        elements: 2_100,
        flexural_rigidity: 100.0,
        mass_per_length: 1.2,
        ends: [BeamEnd::Clamped, BeamEnd::Free],
        lumped: false,
    };
    let beam = System::builder().beam(beam).rayleigh(alpha, beta, None);
    let beam = beam.build().expect("a system");
    assert!(beam.is_large() && beam.structure().is_classical());
    let rod = Rod {
        name: "shaft".to_owned(),
        length: 2.0,
        elements: 4_100,
        axial_rigidity: 100.0,
        mass_per_length: 1.2,
        ends: [RodEnd::Fixed, RodEnd::Free],
        lumped: false,
        twists: false,
    };
    let rod = System::builder().rod(rod).rayleigh(alpha, beta, None);
    let rod = rod.build().expect("a system");
    assert!(rod.is_large() && rod.structure().is_classical());
    let found = SparseModes::lowest(&rod, 4).expect("modes");
    let modes = found.modes().expect("damped modes");
    assert!(modes.is_complete());
    for mode in &modes {
        let omega = mode.natural_frequency().radians_per_second();
        let zeta = 0.5 * (alpha / omega + beta * omega);
        assert!((mode.damping_ratio().expect("it swings") / zeta - 1.0).abs() < 1e-9);
    }
}

/// Two of three coordinates are without mass, and one spring holds none of two shapes: λ = 0 twice, and
/// m c₁c₂e²λ² + m k(c₂a² + c₁f²)λ + k c₁c₂f² = 0, the stretches being aw − bu of the spring and ew − u of a damper, f = a − be.
#[test]
fn shapes_without_mass_may_outnumber_masses() {
    let [m, k, c1, c2] = [
        430.193_137_639_703_76,
        7.0,
        3.773_203_346_728_739e-5,
        1_428.344_711_794_708_5,
    ];
    let [a, u] = [3.230_011_646_352_633_4, 3.0 - 1.887_470_197_133_506];
    let builder = System::builder()
        .mass("u", 0.0)
        .mass("w", 0.0)
        .mass("y", m)
        .point("p0", [("u", u)], 0.0)
        .point("p1", [("u", -1.0), ("w", a)], 0.0)
        .spring("p0", "p1", k)
        .damper("w", "p1", c1)
        .damper("u", "y", c2);
    let system = builder.build().expect("a system");
    let (b, e) = (1.0 + u, a - 1.0);
    let f = a - b * e;
    let fast = -k * (c2 * a * a + c1 * f * f) / (c1 * c2 * e * e);
    let slow = k * f * f / (m * e * e) / fast;
    for precision in [Precision::default(), Precision::Double] {
        let modes = system.modes_to(precision).expect("it has modes");
        for wanted in [fast, slow] {
            let off = |mode: &&Mode| (mode.eigenvalue().value - wanted).norm();
            let nearest = modes.iter().min_by(|x, y| off(x).total_cmp(&off(y)));
            let nearest = nearest.expect("modes");
            let rounding = 1e-13 * wanted.abs();
            let bound = nearest.eigenvalue().bound;
            let off = off(&nearest);
            assert!(
                bound.is_none_or(|bound| off <= bound + rounding),
                "{nearest:?} {wanted}"
            );
        }
    }
}

/// One mass, one spring, and three nodes without mass that only dampers tie: K lets three shapes move without any force, more than
/// there are masses. Eliminated by hand, spring and dampers are one damper d = 4/9·c₂c₃/(c₂ + c₃) behind k: λ² + (k/d)λ + k = 0
/// beside the three roots 0.
#[test]
fn shapes_that_no_spring_resists_may_outnumber_masses() {
    let k = 1_025_986_015.619_340_4f64;
    let [c1, c2, c3] = [1.168_560_455_641_301_7e-4, 22_527_114_950.721_508, 1.0f64];
    let builder = System::builder()
        .mass("m0", 0.0)
        .mass("m1", 0.0)
        .mass("m2", 1.0)
        .mass("m3", 0.0)
        .point("p3", [("m3", 0.6)], 0.0)
        .spring("p3", "m2", k)
        .damper("m1", "m2", c1)
        .damper("p3", "m0", c2)
        .damper("m0", "m3", c3);
    let system = builder.build().expect("a system");
    let d = 4.0 / 9.0 * c2 * c3 / (c2 + c3);
    let fast = -0.5 * k / d * (1.0 + (1.0 - 4.0 * d / k * d).sqrt());
    for precision in [Precision::default(), Precision::Double] {
        let modes = system.modes_to(precision).expect("it has modes");
        let mut zeros = 0;
        let mut others = Vec::new();
        for mode in &modes {
            match mode.eigenvalue().value {
                value if value.norm() == 0.0 => zeros += mode.roots(),
                _ => others.push(mode.eigenvalue()),
            }
        }
        others.sort_by(|a, b| a.value.re.total_cmp(&b.value.re));
        assert_eq!((zeros, others.len()), (3, 2), "{:?}", modes.eigenvalues());
        for (found, wanted) in others.into_iter().zip([fast, k / fast]) {
            let off = (found.value - wanted).norm();
            let rounding = 1e-15 * wanted.abs();
            assert!(
                found.bound.is_none_or(|bound| off <= bound + rounding),
                "{found:?} {wanted}"
            );
            let tolerance = 1e-15 * wanted.abs();
            assert!(
                precision == Precision::Double
                    || found.bound.is_some_and(|bound| bound <= tolerance)
            );
        }
    }
}
