//! What elements at points add to the matrices, without rounding.

use eigentone_modes::{ElementKind, GROUND, MatrixKind, Parameter, Sensitivity, System};

/// Springs of 1e8 and 1 on points at right angles: the soft one keeps its last digit. λ² = −k(0.8² + 0.6²), with
/// 0.8 and 0.6 the doubles next to them.
#[test]
fn a_soft_spring_beside_a_stiff_one_keeps_its_digits() {
    let system = System::builder()
        .mass("x", 1.0)
        .mass("y", 1.0)
        .point("along", [("x", 0.8), ("y", 0.6)], 0.0)
        .point("across", [("x", -0.6), ("y", 0.8)], 0.0)
        .spring(GROUND, "along", 1e8)
        .spring(GROUND, "across", 1.0)
        .build()
        .expect("a system");
    let modes = system.modes().expect("modes");
    let found: Vec<f64> = modes
        .eigenvalues()
        .iter()
        .map(|root| root.value.im.abs())
        .collect();
    // √(0.8² + 0.6²) is 1 but for 2e-17 of rounding.
    for (found, wanted) in found.iter().zip([1.0, 1.0, 1e4, 1e4]) {
        assert!((found - wanted).abs() <= 4.5e-16 * wanted, "{found}");
    }
}

/// What is rigid stays at rest, exactly: points that move alike are joined by a spring that nothing stretches.
#[test]
fn forms_that_cancel_are_nothing() {
    let system = System::builder()
        .mass("a", 1.0)
        .point("p", [("a", 0.1)], 0.0)
        .point("q", [("a", 0.1)], 3.0)
        .spring("p", "q", 5.0)
        .build()
        .expect("a system");
    assert_eq!(system.terms(MatrixKind::Stiffness).count(), 0);
    assert_eq!(system.structure().zero_roots(), Some(2));
}

/// Points that stand for a coordinate make the elements that it would make, and supports are the ground in modes.
#[test]
fn plain_points_and_supports_leave_plain_elements() {
    let system = System::builder()
        .mass("body", 290.0)
        .mass("wheel", 59.0)
        .point("axle", [("wheel", 1.0)], 0.0)
        .support("road")
        .spring("axle", "body", 16812.0)
        .named("suspension")
        .spring("road", "axle", 190_000.0)
        .named("tyre")
        .damper("road", "wheel", 10.0)
        .build()
        .expect("a system");
    assert!(system.added(MatrixKind::Stiffness).is_none());
    assert_eq!(system.springs().len(), 2);
    assert_eq!(system.supports(), ["road"]);
    let tyre = system.element_of("tyre").expect("named");
    assert_eq!(tyre, (ElementKind::Spring, 1));
    let stretch = &system.elements(ElementKind::Spring)[1].stretch;
    assert_eq!(
        (&stretch.coordinates[..], &stretch.supports[..]),
        (&[(1, 1.0)][..], &[(0, -1.0)][..])
    );
    let coupling = system.coupling(MatrixKind::Stiffness);
    assert_eq!(
        (coupling[0].row, coupling[0].column, coupling[0].value),
        (1, 0, -190_000.0)
    );
    assert_eq!(system.coupling(MatrixKind::Damping)[0].value, -10.0);
    assert!(system.coupling(MatrixKind::Mass).is_empty());
}

/// A mass on a lever between a coordinate and a support: M = m a², M_s = m a b.
#[test]
fn carried_masses_couple_to_supports() {
    let system = System::builder()
        .mass("x", 1.0)
        .support("s")
        .point("p", [("x", 0.5), ("s", 0.25)], 8.0)
        .spring("x", GROUND, 1.0)
        .build()
        .expect("a system");
    assert_eq!(system.mass_matrix()[(0, 0)], 3.0);
    let coupling = system.coupling(MatrixKind::Mass);
    assert_eq!(coupling.iter().map(|term| term.value).sum::<f64>(), 1.0);
}

/// Two levers, of which one is softer by a part that the double of its matrix does not show: their roots differ, and none
/// is taken for double.
#[test]
fn parts_that_differ_below_a_double_are_distinguished() {
    let lever = |builder: eigentone_modes::SystemBuilder, name: &str, soft: f64| {
        let (point, next) = (format!("{name} point"), format!("{name} next"));
        builder
            .mass(name, 1.0)
            .mass(&next, 1.0)
            .point(&point, [(name, 1.0), (&next, -0.5)], 0.0)
            .spring(GROUND, &point, 1e18)
            .spring(GROUND, &point, soft)
            .spring(GROUND, name, 1.0)
    };
    let both = |soft| {
        let system = lever(lever(System::builder(), "a", 0.0), "b", soft);
        system.build().expect("a system").modes().expect("modes")
    };
    let same = both(0.0);
    assert_eq!(same.as_slice()[0].multiplicity(), Some(2));
    for mode in both(1.0).iter() {
        assert_ne!(mode.multiplicity(), Some(2));
    }
}

/// Forms with positive coefficients are squares, however many there are.
#[test]
fn large_machines_of_levers_are_passive() {
    let n = 4100;
    let name = |i: usize| format!("m{i}");
    let levers = (0..n).fold(System::builder(), |builder, i| builder.mass(name(i), 1.0));
    let levers = (1..n).fold(levers, |builder, i| {
        let point = format!("p{i}");
        let moves = [(name(i - 1), 0.3), (name(i), -1.1)];
        builder
            .point(&point, moves, 0.1)
            .spring(&point, GROUND, 2.0)
            .damper(&point, GROUND, 0.1)
    });
    assert!(
        levers
            .clone()
            .build()
            .expect("a system")
            .structure()
            .is_passive()
    );
    let pushed = levers
        .spring("p1", GROUND, -1e-9)
        .build()
        .expect("a system");
    assert!(!pushed.structure().is_passive());
}

/// ∂ω/∂k = (aᵀx)²/2ω and ∂ω/∂m = −ω(aᵀx)²/2 for shapes of modal mass 1, of elements at points by name.
#[test]
fn sensitivities_at_points() {
    let build = |k: f64, m: f64| {
        System::builder()
            .mass("x", 2.0)
            .mass("y", 1.0)
            .point("p", [("x", 0.6), ("y", -0.3)], m)
            .spring(GROUND, "x", 3.0)
            .spring("p", "y", k)
            .named("link")
            .spring(GROUND, "y", 1.0)
            .build()
            .expect("a system")
    };
    let system = build(5.0, 0.5);
    let Some((ElementKind::Spring, link)) = system.element_of("link") else {
        panic!("there is a link");
    };
    let modes = system.modes().expect("modes");
    let frequency = |k: f64, m: f64, mode: usize| {
        let modes = build(k, m).modes().expect("modes");
        modes.as_slice()[mode]
            .natural_frequency()
            .radians_per_second()
    };
    let step = 1e-4;
    for (i, mode) in modes.iter().enumerate() {
        let sensitivity = Sensitivity::of(&system, mode).expect("a simple root");
        let to = |parameter| {
            let derivative = sensitivity.to(parameter).expect("there is one");
            derivative.natural_frequency().expect("it swings")
        };
        let by_k = (frequency(5.0 + step, 0.5, i) - frequency(5.0 - step, 0.5, i)) / (2.0 * step);
        let by_m = (frequency(5.0, 0.5 + step, i) - frequency(5.0, 0.5 - step, i)) / (2.0 * step);
        assert!((to(Parameter::Spring(link)) - by_k).abs() < 1e-8);
        assert!((to(Parameter::PointMass(0)) - by_m).abs() < 1e-8);
    }
    let all = Parameter::all(&system);
    assert_eq!(all.len(), 2 + 1 + 3);
    assert_eq!(Parameter::Spring(link).value(&system), Some(5.0));
}
