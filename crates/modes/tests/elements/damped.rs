//! Beams and membranes with Rayleigh damping, dashpots and rotation.

use eigentone_modes::{Bounds, Eigenvalue, Precision};

use crate::mesh::{Ends, Model, beam, chain, frame, lumped_beam, membrane, octagon, plate, truss};
use crate::truth::{check, examine};

fn beams() -> Vec<(String, Model)> {
    let mut models = Vec::new();
    for elements in [17, 40] {
        for ends in [Ends::Free, Ends::Clamped, Ends::Pinned, Ends::Cantilever] {
            let beam = beam(elements, ends);
            let tip = beam.order() - 2;
            let name = |what: &str| format!("{ends:?} {elements} {what}");
            models.push((name("rayleigh"), beam.clone().rayleigh(0.3, 1e-5)));
            models.push((name("stiffness"), beam.clone().rayleigh(0.0, 1e-6)));
            for damping in [0.3, 50.0, 2e4] {
                let damped = beam.clone().damper(tip, damping);
                models.push((name(&format!("tip {damping}")), damped));
            }
        }
    }
    models
}

fn others() -> Vec<(String, Model)> {
    let mut models = vec![(
        "rotating 20".to_owned(),
        beam(20, Ends::Pinned).rotating(7.0),
    )];
    // Rotations without mass follow at once in both planes.
    for ends in [Ends::Clamped, Ends::Cantilever] {
        models.push((
            format!("rotating lumped {ends:?} 20"),
            lumped_beam(20, ends).rotating(7.0),
        ));
    }
    // As many real roots next to −1/β as there are rotations.
    let free = lumped_beam(44, Ends::Free).rayleigh(0.3, 1e-5);
    models.push(("lumped Free 44 rayleigh".to_owned(), free));
    // Free shafts, seen from the axes that turn with them: nothing holds the translations, rotations only what rounding leaves.
    for (elements, speed) in [(16, 7.0), (20, 0.3)] {
        models.push((
            format!("rotating Free {elements}"),
            beam(elements, Ends::Free).rotating(speed),
        ));
        models.push((
            format!("rotating lumped Free {elements}"),
            lumped_beam(elements, Ends::Free).rotating(speed),
        ));
    }
    for (elements, ends, momentum) in [
        (17, Ends::Free, 3e-3),
        (17, Ends::Free, 0.1),
        (20, Ends::Free, 3.0),
        (20, Ends::Pinned, 0.1),
    ] {
        models.push((
            format!("{ends:?} {elements} with discs {momentum}"),
            beam(elements, ends).with_discs(ends, momentum),
        ));
    }
    for elements in [33, 50] {
        let beam = beam(elements, Ends::Free).unsymmetric();
        let tip = beam.order() - 2;
        models.push((
            format!("Free {elements}, K not symmetric"),
            beam.damper(tip, 50.0),
        ));
    }
    // Rigid motions that no vector of doubles is, and others that rounding leaves next to 0.
    for (elements, damping) in [(60, 0.3), (60, 30.0), (60, 2e4)] {
        let beam = beam(elements, Ends::Free);
        let tip = beam.order() - 2;
        models.push((
            format!("Free {elements} tip {damping}"),
            beam.damper(tip, damping),
        ));
    }
    for ends in [Ends::Free, Ends::Cantilever] {
        let beam = lumped_beam(41, ends);
        let tip = beam.order() - 2;
        models.push((
            format!("lumped {ends:?} mass"),
            beam.clone().rayleigh(0.3, 0.0),
        ));
        for damping in [0.3, 2e4] {
            let damped = beam.clone().damper(tip, damping);
            models.push((format!("lumped {ends:?} tip {damping}"), damped));
        }
    }
    // A rotation that rounding leaves next to 0, beside as many real roots about −1/β as there are nodes.
    models.push((
        "lumped Free 42 stiffness".to_owned(),
        lumped_beam(42, Ends::Free).rayleigh(0.0, 1e-6),
    ));
    // Two rigid motions that dashpots alone hold, with roots far below the elastic ones.
    for (force, moment) in [(5.0, 70.0), (50.0, 7.0)] {
        let beam = beam(60, Ends::Free);
        let tip = beam.order() - 2;
        models.push((
            format!("Free 60 tip {force} and slope {moment}"),
            beam.damper(tip, force).damper(1, moment),
        ));
    }
    // One that nothing holds and one that a dashpot alone holds.
    for elements in [32, 64] {
        models.push((
            format!("Free {elements} slope"),
            beam(elements, Ends::Free).damper(1, 70.0),
        ));
    }
    models.push((
        "Free 60 rayleigh".to_owned(),
        beam(60, Ends::Free).rayleigh(0.3, 1e-6),
    ));
    let plate = plate(4, 3);
    let corner = plate.order() - 4;
    models.push(("plate".to_owned(), plate.clone().damper(corner, 1e4)));
    models.push(("plate, slope".to_owned(), plate.damper(corner + 1, 1e4)));
    for held in [false, true] {
        let membrane = membrane(9, 8, held);
        models.push((
            format!("membrane {held}"),
            membrane.damper(3, 2.0).damper(17, 0.7),
        ));
        models.push((format!("truss {held}"), truss(20, held).damper(30, 1e3)));
    }
    models
}

#[test]
fn modes_of_beams_with_all_ends_are_right() {
    for (name, model) in beams() {
        examine(&name, &model, 1e-3);
    }
}

#[test]
fn modes_of_other_damped_meshes_are_right() {
    for (name, model) in others() {
        examine(&name, &model, 1e-3);
    }
}

/// Of its tiny root no digit is known in double-double: it has a bound larger than itself, and all others are proven.
#[test]
fn a_root_that_is_not_distinguished_from_0_leaves_the_others_proven() {
    let chain = chain(70);
    // K annuls the rotation exactly, with a vector of doubles for 44 elements and without for 60, and C but for its rounding.
    let free = [
        beam(44, Ends::Free),
        lumped_beam(44, Ends::Free),
        beam(60, Ends::Free),
    ];
    let free = free.map(|beam| (beam.rayleigh(0.0, 1e-6), 1, 1e6));
    let chains = [(chain.clone(), 2, 1e3), (chain.damper(69, 0.5), 1, 1e3)];
    for (model, count, tight) in chains.into_iter().chain(free) {
        let modes = model.modes(Precision::default());
        assert_eq!(modes.bounds(), Bounds::Proven, "{}", modes.plan().bounds);
        let loose = |root: &&Eigenvalue| root.bound.is_none_or(|b| b > 1e-3 * root.value.norm());
        assert_eq!(modes.eigenvalues().iter().filter(loose).count(), count);
        check("not distinguished from 0", &model, &modes, tight);
    }
}

/// Their rigid motions have roots next to 0 and, with Rayleigh damping, three next to −α: all are known as well as the others.
#[test]
fn free_frames_are_proven_to_nine_digits() {
    let frame = frame(2, 5);
    let at = frame.order() - 3;
    for (name, model) in [
        ("rayleigh", frame.clone().rayleigh(0.3, 1e-5)),
        ("dashpot", frame.clone().damper(at, 70.0)),
        ("K not symmetric", frame.unsymmetric().damper(at, 70.0)),
    ] {
        let modes = model.modes(Precision::default());
        assert_eq!(modes.bounds(), Bounds::Proven, "{}", modes.plan().bounds);
        check(name, &model, &modes, 1e-9);
    }
}

/// Corrections along the motions of a free body, whose columns are nearly parallel, cancel but for what bays that differ little leave
/// apart.
#[test]
fn roots_close_to_each_other_are_separated_beside_those_next_to_0() {
    let truss = truss(60, false);
    let at = truss.order() - 3;
    let truss = truss.damper(at, 70.0);
    let modes = truss.modes(Precision::default());
    assert_eq!(modes.bounds(), Bounds::Proven, "{}", modes.plan().bounds);
    for root in modes.eigenvalues() {
        let bound = root.bound.unwrap_or(f64::INFINITY);
        assert!(bound <= 1e-9 * root.value.norm(), "{root:?}");
    }
    check("truss", &truss, &modes, 1e-9);
}

/// Doubles know neither the roots next to 0 of what nothing holds, nor those of rotations without mass, within 1e-40 of each other. The
/// latter are as FLINT finds them with 1200 digits: all at one distance from a double.
#[test]
fn roots_next_to_0_and_next_to_each_other_are_proven_together() {
    for (beta, near, beyond) in [
        (1e-6, -1e6, -1.016052321644e-11),
        (3e-5, -33333.33333333333, -2.779984355591e-12),
    ] {
        let model = octagon().rayleigh(0.0, beta);
        let modes = model.modes(Precision::default());
        assert_eq!(modes.bounds(), Bounds::Proven, "{}", modes.plan().bounds);
        let fast = modes.eigenvalues().iter();
        let fast: Vec<&Eigenvalue> = fast.filter(|root| root.value.norm() > 0.5 / beta).collect();
        assert_eq!(fast.len(), 8);
        for root in fast {
            let bound = root.bound.unwrap_or(f64::INFINITY);
            let off = (root.value.re - near) - beyond;
            assert!(bound <= 1.2e-16 / beta, "{root:?}");
            assert!(off.abs() <= bound * (1.0 + 1e-6), "{root:?}: {off:e}");
        }
        check("octagon", &model, &modes, 1e-3);
    }
}
