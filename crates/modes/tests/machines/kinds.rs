//! Displacements in m beside rotations in rad.

use eigentone_modes::{CoordinateKind, GROUND, Participation, ParticipationError, System};

/// Body, pitch and two wheels, springs at the ends of the body.
fn half_car() -> System {
    System::builder()
        .mass("body", 600.0)
        .rotation("pitch", 900.0)
        .mass("front wheel", 40.0)
        .mass("rear wheel", 45.0)
        .point("front", [("body", 1.0), ("pitch", -1.2)], 10.0)
        .point("rear", [("body", 1.0), ("pitch", 1.4)], 0.0)
        .spring("front wheel", "front", 15e3)
        .spring("rear wheel", "rear", 17e3)
        .spring(GROUND, "front wheel", 180e3)
        .spring(GROUND, "rear wheel", 190e3)
        .build()
        .expect("a system")
}

#[test]
fn effective_masses_of_a_half_car_are_those_of_a_direction() {
    let car = half_car();
    assert_eq!(car.kind_of(0), CoordinateKind::Displacement);
    assert_eq!(car.kind_of(1), CoordinateKind::Rotation);
    let parts = Participation::of_parts(&car);
    let [(heave, heaving), (pitch, pitching)] = &parts[..] else {
        panic!("two directions: {parts:?}");
    };
    assert_eq!((&heave[..], &pitch[..]), (&[0, 2, 3][..], &[1][..]));
    let [heaving, pitching] = [heaving, pitching].map(|part| part.as_ref().expect("real modes"));
    // With the mass at the front: 695 kg, and 900 + 10·1.2² kg·m².
    assert_eq!(heaving.total_mass(), 695.0);
    assert!((pitching.total_mass() - 914.4).abs() < 1e-12);
    for part in [heaving, pitching] {
        let sum: f64 = part.effective_masses().iter().sum();
        assert!((sum / part.total_mass() - 1.0).abs() < 1e-14);
        assert_eq!(part.modes().mass().len(), 4);
    }
    assert!(matches!(
        Participation::of(&car),
        Err(ParticipationError::NoCommonDirection)
    ));
}

/// Springs askew show no common direction of x and y; one between them does.
#[test]
fn directions_are_not_guessed() {
    let askew = || {
        System::builder()
            .mass("x", 1.0)
            .mass("y", 1.0)
            .point("p", [("x", 0.8), ("y", 0.6)], 0.0)
            .spring(GROUND, "p", 2.0)
            .spring(GROUND, "x", 1.0)
    };
    let count = |system: &System| Participation::of_parts(system).len();
    assert_eq!(count(&askew().build().expect("a system")), 2);
    let joined = askew().point("q", [("y", 1.0)], 0.0).spring("x", "q", 1.0);
    assert_eq!(count(&joined.build().expect("a system")), 1);
    let geared = System::builder()
        .mass("rack", 1.0)
        .rotation("pinion", 1.0)
        .spring("rack", "pinion", 1.0)
        .spring(GROUND, "rack", 1.0);
    assert_eq!(count(&geared.build().expect("a system")), 2);
}

/// What arms, gears, supports and elements measure follows from what they are joined to, as far as it can be determined.
#[test]
fn kinds_reach_points_supports_and_elements() {
    use CoordinateKind::{Displacement, Rotation};
    let builder = System::builder()
        .mass("load", 3.0)
        .rotation("lever", 0.5)
        .rotation("rotor", 0.25)
        .support("wall")
        .support("motor")
        .support("idle")
        .point("edge", [("load", 1.0), ("lever", -0.5)], 0.0)
        .point("arm", [("lever", 0.25)], 0.0)
        .point("gear", [("lever", 4.0)], 0.0)
        .point("unknown", [("lever", 0.75)], 0.0)
        .point("tooth", [("rotor", 0.125)], 0.0)
        .measuring(Displacement)
        .point("torn", [("rotor", 1.5)], 0.0);
    let joins = [
        (GROUND, "edge", Some(Displacement)),
        ("arm", "load", Some(Displacement)),
        ("gear", "rotor", Some(Rotation)),
        ("unknown", GROUND, None),
        ("tooth", GROUND, Some(Displacement)),
        ("wall", "load", Some(Displacement)),
        ("motor", "rotor", Some(Rotation)),
        ("load", "lever", None),
        ("torn", "load", None),
        ("torn", "lever", None),
    ];
    let join = |builder: eigentone_modes::SystemBuilder, (a, b, _): &(&str, &str, _)| {
        builder.spring(*a, *b, 2.0)
    };
    let system = joins.iter().fold(builder, join).build().expect("a system");
    let places = [
        ("edge", Some(Displacement)),
        ("arm", Some(Displacement)),
        ("gear", Some(Rotation)),
        ("unknown", None),
        ("tooth", Some(Displacement)),
        ("torn", None),
        ("wall", Some(Displacement)),
        ("motor", Some(Rotation)),
        ("idle", Some(Displacement)),
        ("rotor", Some(Rotation)),
        ("nobody", None),
    ];
    for (name, kind) in places {
        assert_eq!(system.kind_at(name), kind, "{name}");
    }
    let elements = system.elements(eigentone_modes::ElementKind::Spring);
    for (element, (a, b, kind)) in elements.iter().zip(joins) {
        assert_eq!(element.kind, kind, "{a}–{b}");
    }
}
