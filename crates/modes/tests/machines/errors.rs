//! What is wrong with points and supports is said.

use eigentone_modes::{BuildError, ElementKind, GROUND, System, SystemBuilder};

fn wrong(builder: SystemBuilder) -> BuildError {
    builder.build().expect_err("not a system")
}

fn body() -> SystemBuilder {
    System::builder()
        .mass("body", 2.0)
        .spring(GROUND, "body", 1.0)
}

#[test]
fn names_are_taken_once() {
    for (what, wrong) in [
        ("point", wrong(body().point("body", [("body", 1.0)], 0.0))),
        ("point", wrong(body().point(GROUND, [("body", 1.0)], 0.0))),
        (
            "point",
            wrong(body().support("p").point("p", [("body", 1.0)], 0.0)),
        ),
        ("support", wrong(body().support(""))),
        ("support", wrong(body().support("body"))),
    ] {
        match wrong {
            BuildError::PlaceName {
                what: named,
                index: 0,
                ..
            } => assert_eq!(what, named),
            other => panic!("{other}"),
        }
    }
    let twice = body()
        .support("road")
        .spring("road", "body", 1.0)
        .named("a");
    let twice = wrong(twice.damper("road", "body", 1.0).named("a"));
    let (kind, index, name) = (ElementKind::Damper, 0, "a".to_owned());
    assert_eq!(twice, BuildError::ElementName { kind, index, name });
}

#[test]
fn points_move_with_masses_and_supports() {
    let point = |moves: &[(&str, f64)], mass| wrong(body().point("p", moves.iter().copied(), mass));
    assert!(matches!(point(&[], 0.0), BuildError::PointStill { .. }));
    assert!(matches!(
        point(&[("q", 1.0)], 0.0),
        BuildError::PointMoves { .. }
    ));
    assert!(matches!(
        point(&[(GROUND, 1.0)], 0.0),
        BuildError::PointMoves { .. }
    ));
    assert!(matches!(
        point(&[("p", 1.0)], 0.0),
        BuildError::PointCircle { .. }
    ));
    let chained = |end: &str| {
        let first = body().point("p", [("q", 1.0)], 0.0);
        wrong(
            first
                .point("q", [("r", 1.0)], 0.0)
                .point("r", [(end, 1.0)], 0.0),
        )
        .to_string()
    };
    assert_eq!(
        chained("p"),
        "points \"p\" and \"q\" move with each other: give the masses and supports that move them"
    );
    assert!(chained("body").contains("which is a point: give what that one moves with"));
    assert!(matches!(
        point(&[("body", f64::NAN)], 0.0),
        BuildError::PointNotFinite { .. }
    ));
    assert!(matches!(
        point(&[("body", 1.0)], -1.0),
        BuildError::InvalidMass { .. }
    ));
    let far = body()
        .point("p", [("body", 1e-200)], 0.0)
        .spring("p", GROUND, 1.0);
    assert!(matches!(wrong(far), BuildError::PointRange { .. }));
}
