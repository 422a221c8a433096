//! The quadratic problems with real square matrices of the collection NLEVP that have published formulas, against their roots
//! to 60 digits. docs/validation.md lists them.

#[allow(dead_code)]
#[path = "../elements/mesh.rs"]
mod mesh;
mod problems;
#[path = "../elements/truth.rs"]
mod truth;

use std::fmt::Write;
use std::fs;

use eigentone_modes::{Bounds, BuildError, Precision, System};
use mesh::Model;
use problems::*;
use truth::{check, examine};

/// Of up to 30 coordinates.
fn small() -> Vec<Problem> {
    vec![
        acoustic_wave_1d(10),
        acoustic_wave_2d(4),
        bcc_traffic(8),
        bicycle(5.0),
        bilby(0.5),
        closed_loop(1.0),
        damped_beam(6),
        damped_gyro("damped_gyro", 4, 1e-4),
        deformed_consensus(12),
        dirac(6),
        damped_gyro("elastic_deform", 4, 0.0),
        gen_hyper2(8),
        gen_palindromic("gen_tantipal2", 8),
        gen_palindromic("gen_tpal2", 8),
        intersection(),
        metal_strip(),
        mobile_manipulator(),
        power_plant(),
        qep1(),
        qep2(),
        qep3(-1.0 + 2f64.powf(-26.5)),
        relative_pose_6pt(),
        sign(1, 15),
        sign(2, 7),
        sleeper(10),
        spring(10),
        spring_dashpot(4),
        wing(),
        wiresaw("wiresaw1", 10, 0.01, 0.0),
        wiresaw("wiresaw2", 10, 0.01, 0.8),
    ]
}

/// Of more than 64, those with narrow bands, whose determinants are quick.
fn large() -> Vec<Problem> {
    vec![
        acoustic_wave_1d(65),
        acoustic_wave_2d(9),
        bcc_traffic(65),
        damped_beam(40),
        spring(65),
    ]
}

/// Of more than 64, with full matrices: proven, and no more is asked.
fn full() -> Vec<Problem> {
    vec![
        dirac(33),
        gen_hyper2(66),
        gen_palindromic("gen_tantipal2", 66),
        gen_palindromic("gen_tpal2", 66),
        sign(2, 33),
        sleeper(65),
        spring_dashpot(32),
        wiresaw("wiresaw1", 65, 0.9, 0.0),
        wiresaw("wiresaw2", 66, 0.01, 0.8),
    ]
}

const TIGHT: f64 = 2.0 * f64::EPSILON;

#[test]
fn small_problems_are_right() {
    let mut table = "| problem | n | finite roots | infinite ones | largest multiplicity |\n|---|--:|--:|--:|--:|\n".to_owned();
    for Problem { name, model } in small() {
        let modes = examine(name, &model, TIGHT);
        assert!(modes.is_complete(), "{name}");
        let counts: Option<Vec<usize>> = modes.iter().map(|mode| mode.multiplicity()).collect();
        let most = counts.expect(name).into_iter().max().unwrap_or(0);
        let (n, finite, infinite) = (model.order(), modes.eigenvalues().len(), modes.infinite());
        writeln!(table, "| {name} | {n} | {finite} | {infinite} | {most} |").expect("a text");
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/validation.md");
    let page = fs::read_to_string(path).expect("the page is there");
    assert!(
        page.contains(&table),
        "docs/validation.md is to show\n{table}"
    );
}

#[test]
fn large_problems_are_proven() {
    for Problem { name, model } in large() {
        let modes = model.modes(Precision::default());
        assert_eq!(modes.bounds(), Bounds::Proven, "{name}: {}", modes.plan());
        check(name, &model, &modes, TIGHT);
    }
}

#[test]
fn full_matrices_are_proven_too() {
    for Problem { name, model } in full() {
        let modes = model.modes(Precision::default());
        assert_eq!(modes.bounds(), Bounds::Proven, "{name}: {}", modes.plan());
        for root in modes.eigenvalues() {
            assert!(
                root.bound <= Some(TIGHT * root.value.norm()),
                "{name}: {root:?}"
            );
        }
    }
}

/// Nothing but imaginary roots has a gyroscopic system on springs.
#[test]
fn what_only_turns_neither_grows_nor_decays() {
    for n in [10, 66] {
        let modes = wiresaw("wiresaw1", n, 0.5, 0.0)
            .model
            .modes(Precision::default());
        assert!(
            modes
                .eigenvalues()
                .iter()
                .all(|root| root.value.re == 0.0 && root.real_bound == Some(0.0))
        );
    }
}

#[test]
fn a_determinant_that_vanishes_everywhere_is_refused() {
    let Model {
        mass,
        damping,
        stiffness,
    } = qep5().model;
    let refused = System::from_matrices(mass.as_ref(), damping.as_ref(), stiffness.as_ref());
    assert_eq!(refused.err(), Some(BuildError::Singular));
}
