//! Beams and rods by finite elements: convergence to the continuum, and the last digit of the discrete problem.

use std::f64::consts::PI;

use eigentone_modes::{
    Beam, BeamEnd, Bounds, BuildError, CoordinateKind, GROUND, MatrixKind, Modes, Rod, RodEnd,
    System,
};

use BeamEnd::{Clamped, Free, Guided, Pinned};

fn beam(elements: usize, ends: [BeamEnd; 2], lumped: bool) -> Beam {
    Beam {
        name: "mast".to_owned(),
        length: 2.0,
        elements,
        flexural_rigidity: 100.0,
        mass_per_length: 1.2,
        ends,
        lumped,
    }
}

fn rod(elements: usize, ends: [RodEnd; 2], lumped: bool) -> Rod {
    Rod {
        name: "rod".to_owned(),
        length: 0.7,
        elements,
        axial_rigidity: 3.0,
        mass_per_length: 0.1,
        ends,
        lumped,
        twists: false,
    }
}

fn system(elements: usize, ends: [BeamEnd; 2], lumped: bool) -> System {
    let beam = beam(elements, ends, lumped);
    System::builder().beam(beam).build().expect("a system")
}

fn frequencies(modes: &Modes) -> Vec<f64> {
    let each = modes.iter().map(|mode| mode.natural_frequency());
    each.map(|frequency| frequency.radians_per_second())
        .collect()
}

/// Blevins, *Formulas for Natural Frequency and Mode Shape*, table 8-1: β_nL.
#[test]
fn consistent_beams_converge_with_order_four() {
    let cases = [
        (
            [Clamped, Free],
            [
                1.875_104_068_711_96,
                4.694_091_132_974_17,
                7.854_757_438_237_61,
            ],
        ),
        (
            [Clamped, Clamped],
            [
                4.730_040_744_862_7,
                7.853_204_624_095_84,
                10.995_607_838_001_67,
            ],
        ),
        ([Pinned, Pinned], [PI, 2.0 * PI, 3.0 * PI]),
        ([Guided, Pinned], [0.5 * PI, 1.5 * PI, 2.5 * PI]),
    ];
    for (ends, roots) in cases {
        let errors = [12, 24].map(|elements| {
            let found = frequencies(&system(elements, ends, false).modes().expect("modes"));
            let ideal = roots.map(|root| (root / 2.0f64).powi(2) * (100.0f64 / 1.2).sqrt());
            let off = found
                .iter()
                .zip(ideal)
                .map(|(found, ideal)| found / ideal - 1.0);
            off.collect::<Vec<f64>>()
        });
        for (mode, (coarse, fine)) in errors[0].iter().zip(&errors[1]).enumerate() {
            // Elements that are conforming are too stiff; h⁴ but for terms of higher order.
            let order = (coarse / fine).log2();
            assert!(
                *fine > 0.0 && (order - 4.0).abs() < 0.1,
                "{ends:?} {mode}: {order}"
            );
        }
    }
}

/// Of the discrete problem, with the exact h, EI and ρA the doubles given: inverse iteration with 70 digits.
#[test]
fn a_fine_beam_has_the_last_digit_of_its_discrete_roots() {
    let cases = [
        (
            40,
            [Clamped, Clamped],
            [
                51.059_811_620_906_33,
                140.748_462_892_172_1,
                275.924_071_052_174_67,
            ],
        ),
        (
            400,
            [Clamped, Free],
            [
                8.024_170_312_878_175,
                50.286_616_972_017_68,
                140.803_983_637_596_1,
            ],
        ),
    ];
    for (elements, ends, truth) in cases {
        let modes = system(elements, ends, false).modes().expect("modes");
        assert_eq!(modes.bounds(), Bounds::Proven, "{}", modes.plan());
        for (mode, truth) in modes.iter().zip(truth) {
            let root = mode.eigenvalue();
            let off = (root.value.im - truth).abs();
            assert!(
                off <= 4.5e-16 * truth,
                "{elements}: {} {truth}",
                root.value.im
            );
            let bound = root.bound.expect("proven");
            assert!(bound <= 9e-16 * truth, "{elements}: {bound}");
        }
    }
}

#[test]
fn a_free_beam_has_two_rigid_motions_exactly() {
    for (elements, lumped) in [(8, false), (5, false), (7, true)] {
        let system = system(elements, [Free, Free], lumped);
        assert!(system.structure().is_passive());
        assert_eq!(system.structure().zero_roots(), Some(4), "{elements}");
        let modes = system.modes().expect("modes");
        assert_eq!(modes.bounds(), Bounds::Proven);
        let zeros = modes.eigenvalues().iter();
        assert_eq!(zeros.filter(|root| root.value.norm() == 0.0).count(), 4);
    }
}

/// A spring on a sum of displacements that turning does not change, at elements of lengths that are no doubles.
#[test]
fn springs_that_rigid_motions_do_not_stretch_hold_none() {
    for (length, ends, zeros) in [(1.0, [Free, Free], 4), (0.7, [Pinned, Free], 2)] {
        for lumped in [false, true] {
            let beam = Beam {
                length,
                ..beam(3, ends, lumped)
            };
            let near = match ends[0] {
                Free => vec![("mast.0.w", -1.0)],
                _ => Vec::new(),
            };
            let far = [("mast.3.w", 1.0), ("mast.0.r", -length)];
            let system = System::builder()
                .beam(beam)
                .point("off", far.into_iter().chain(near), 0.0)
                .spring(GROUND, "off", 1.0)
                .build()
                .expect("a system");
            assert_eq!(system.structure().zero_roots(), Some(zeros), "{length}");
        }
    }
}

/// Three elements between pins; ρA·h = 0.8 is put on the inner nodes, where rotations follow without mass. With
/// k = 6EI/(5h³): K of the two displacements is k·[[8, −7], [−7, 8]] for EI/h³ in place of k·5/6.
#[test]
fn lumped_beams_leave_rotations_without_mass() {
    let system = system(3, [Pinned, Pinned], true);
    assert_eq!(system.names()[1], "mast.1.w");
    assert_eq!(system.structure().massless().len(), 4);
    assert_eq!(system.kind_of(0), CoordinateKind::Rotation);
    assert_eq!(system.kind_of(1), CoordinateKind::Displacement);
    let modes = system.modes().expect("modes");
    let (h, m) = (2.0f64 / 3.0, 1.2 * 2.0 / 3.0);
    // Of a beam on pins with the loads P, ±P at its thirds: deflection 5PL³/162EI and PL³/486EI.
    let length = 3.0 * h;
    let stiffness = [162.0 / 5.0, 486.0].map(|k| k * 100.0 / length.powi(3));
    for (found, k) in frequencies(&modes).iter().zip(stiffness) {
        assert!(
            (found / (k / m).sqrt() - 1.0).abs() < 1e-14,
            "{found} {}",
            (k / m).sqrt()
        );
    }
}

/// ω² = 6/h²·(1 − cos θ)/(2 + cos θ)·EA/ρA for the consistent mass and 2(1 − cos θ)/h²·EA/ρA for the lumped one, θ the angle of an
/// element along the wave.
#[test]
fn rods_have_their_dispersion_relation() {
    let n = 9;
    for lumped in [false, true] {
        for (ends, first) in [
            ([RodEnd::Fixed, RodEnd::Fixed], 1.0),
            ([RodEnd::Fixed, RodEnd::Free], 0.5),
            ([RodEnd::Free, RodEnd::Free], 0.0),
        ] {
            let system = System::builder()
                .rod(rod(n, ends, lumped))
                .build()
                .expect("a system");
            let modes = system.modes().expect("modes");
            assert_eq!(modes.bounds(), Bounds::Proven);
            for (r, found) in frequencies(&modes).iter().enumerate() {
                let cos = (PI * (first + r as f64) / n as f64).cos();
                let over = if lumped { 3.0 } else { 2.0 + cos };
                let h = 0.7 / n as f64;
                let expected = (6.0 / (h * h) * (1.0 - cos) / over * 30.0).sqrt();
                let off = (found - expected).abs();
                assert!(off <= 1e-13 * expected, "{found} {expected}");
            }
        }
    }
}

#[test]
fn coordinates_stand_after_masses_whatever_the_order_of_calls() {
    let system = System::builder()
        .rod(rod(2, [RodEnd::Fixed, RodEnd::Free], true))
        .beam(beam(1, [Pinned, Guided], false))
        .mass("tip", 1.0)
        .point("middle", [("mast.1.w", 0.5)], 0.25)
        .spring("middle", "tip", 2.0)
        .build()
        .expect("a system");
    assert_eq!(
        system.names(),
        ["tip", "mast.0.r", "mast.1.w", "rod.1", "rod.2"]
    );
    assert!(system.structure().is_passive());
    // A unit rotation of node 0 of one element: 4EI/h and ρAh·4h²/420.
    let [mass, stiffness] = [system.mass_matrix(), system.stiffness_matrix()];
    assert_eq!(stiffness[(1, 1)], 200.0);
    assert!((mass[(1, 1)] - 2.4 * 16.0 / 420.0).abs() < 1e-16);
    assert!((mass[(2, 2)] - 2.4 * 156.0 / 420.0 - 0.0625).abs() < 2e-16);
    assert!((mass[(1, 2)] - 2.4 * 13.0 * 2.0 / 420.0).abs() < 1e-16);
    assert!(system.added(MatrixKind::Damping).is_none());
}

#[test]
fn what_is_wrong_is_said() {
    let wrong = |change: fn(&mut Beam)| {
        let mut beam = beam(4, [Free, Free], false);
        change(&mut beam);
        System::builder()
            .beam(beam)
            .build()
            .expect_err("not a beam")
    };
    for error in [
        wrong(|beam| beam.length = 0.0),
        wrong(|beam| beam.flexural_rigidity = f64::NAN),
        wrong(|beam| beam.mass_per_length = -1.0),
        wrong(|beam| beam.elements = 0),
    ] {
        assert!(matches!(error, BuildError::Continuum { .. }), "{error}");
    }
    let far = wrong(|beam| beam.length = 1e-200);
    assert!(matches!(far, BuildError::ContinuumRange { .. }), "{far}");
    let many = wrong(|beam| beam.elements = usize::MAX);
    assert!(matches!(many, BuildError::TooLarge { .. }), "{many}");
    let fixed = wrong(|beam| {
        beam.elements = 1;
        beam.ends = [Clamped; 2];
    });
    assert_eq!(fixed, BuildError::Empty);
    let twice = System::builder()
        .mass("mast.0.w", 1.0)
        .beam(beam(1, [Free; 2], true));
    assert!(matches!(
        twice.build(),
        Err(BuildError::DuplicateName { .. })
    ));
}
