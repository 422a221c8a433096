//! One oscillator in five guises: the numbers of docs/analogies.md, and that they are the same oscillator.

use std::f64::consts::PI;
use std::fmt::Write;

use eigentone::gallery::machines;
use eigentone::modes::{MatrixKind, Modes};
use eigentone::prelude::*;
use eigentone::response::{Destination, Load, Problem, ResponsePlan, Summary};
use eigentone::scene::Scene;

/// A scene, and the units of its coordinate, inertia, resistance, stiffness and load.
const GUISES: [(&str, [&str; 5]); 5] = [
    ("translation", ["m", "kg", "N·s/m", "N/m", "N"]),
    ("rotation", ["rad", "kg·m²", "N·m·s/rad", "N·m/rad", "N·m"]),
    ("pendulum", ["rad", "kg·m²", "N·m·s/rad", "N·m/rad", "N·m"]),
    ("cantilever", ["m", "kg", "N·s/m", "N/m", "N"]),
    ("circuit", ["C", "H", "Ω", "1/F", "V"]),
];

/// ω_n² = 16 and 2ζω_n = ½.
const NATURAL: f64 = 4.0;
const DECAY: f64 = 0.25;
/// Load over stiffness.
const END: f64 = 0.25;

fn scene(name: &str) -> Scene {
    let name = format!("analogy-{name}");
    let case = machines().iter().find(|case| case.name() == name);
    case.expect("a machine of the gallery").scene()
}

/// Inertia, resistance and stiffness of the first coordinate, which others without mass follow.
fn parts(system: &System) -> [f64; 3] {
    let matrix = |kind| match kind {
        MatrixKind::Mass => system.mass_matrix(),
        MatrixKind::Damping => system.damping_matrix(),
        MatrixKind::Stiffness => system.stiffness_matrix(),
    };
    let kinds = [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness];
    kinds.map(|kind| {
        let matrix = matrix(kind);
        let follows = kind == MatrixKind::Stiffness && system.len() == 2;
        match follows {
            true => matrix[(0, 0)] - matrix[(0, 1)] * matrix[(1, 0)] / matrix[(1, 1)],
            false => matrix[(0, 0)],
        }
    })
}

fn load(problem: &Problem<'_>) -> f64 {
    match problem.drives() {
        [only] => match &only.load {
            Load::Step(step) => step.force,
            other => panic!("{other:?} is no step"),
        },
        several => panic!("{several:?}"),
    }
}

/// Six significant digits, without zeros at the end.
fn short(value: f64) -> String {
    let decimals = (5 - value.abs().log10().floor() as i32).max(0) as usize;
    let text = format!("{value:.decimals$}");
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    text.replace('-', "−")
}

fn close(found: f64, wanted: f64) {
    let error = (found - wanted).abs();
    assert!(error <= 1e-15 * wanted.abs(), "{found} for {wanted}");
}

fn check(modes: &Modes, summary: &Summary) {
    let swing = (NATURAL * NATURAL - DECAY * DECAY).sqrt();
    let root = modes.as_slice()[0].eigenvalue();
    close(root.value.re, -DECAY);
    close(root.value.im, swing);
    let one = &summary.coordinates()[0];
    let beyond = (-DECAY * PI / swing).exp();
    close(one.peak, END * (1.0 + beyond));
    close(one.peak_time, PI / swing);
    match one.destination {
        Destination::Rest {
            displacement,
            overshoot: Some(overshoot),
            ..
        } => {
            close(displacement, END);
            close(overshoot, beyond);
        }
        ref other => panic!("{other:?}"),
    }
}

#[test]
fn five_guises_are_one_oscillator() {
    let mut same = String::from(
        "| scene | coordinate | inertia | resistance | stiffness | load |\n|---|---|--:|--:|--:|--:|\n",
    );
    let mut moves = String::from(
        "| scene | λ, 1/s | ω_n, rad/s | ζ | ends at | peak | peak at, s | overshoot, % | settled after, s |\n|---|---|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for (name, units) in GUISES {
        let scene = scene(name);
        let system = scene.system();
        let problem = scene.problem().expect("it has times").expect(name);
        let modes = system.modes().expect(name);
        let plan = ResponsePlan::of(&problem).expect(name);
        let trajectory = plan.run(&problem).expect(name);
        let summary = Summary::of(&problem, &trajectory, &modes).expect(name);
        check(&modes, &summary);
        let [mass, damping, stiffness] = parts(system);
        let row = [mass, damping, stiffness, load(&problem)];
        let row = row.iter().zip(&units[1..]);
        let row: Vec<String> = row
            .map(|(value, unit)| format!("{} {unit}", short(*value)))
            .collect();
        let _ = writeln!(
            same,
            "| `analogy-{name}` | {}, {} | {} |",
            system.names()[0],
            units[0],
            row.join(" | ")
        );
        let mode = &modes.as_slice()[0];
        let root = mode.eigenvalue().value;
        let one = &summary.coordinates()[0];
        let Destination::Rest {
            displacement,
            overshoot,
            settled,
        } = one.destination
        else {
            panic!("{name} comes to rest");
        };
        let _ = writeln!(
            moves,
            "| `analogy-{name}` | {} ± {}i | {} | {} | {} {unit} | {} {unit} | {} | {} | {} |",
            short(root.re),
            short(root.im),
            short(mode.natural_frequency().radians_per_second()),
            short(mode.damping_ratio().expect("it oscillates")),
            short(displacement),
            short(one.peak),
            short(one.peak_time),
            short(100.0 * overshoot.expect("it goes beyond")),
            short(settled.expect("it settles")),
            unit = units[0],
        );
    }
    crate::page::assert_shown("analogies.md", "values", &same);
    crate::page::assert_shown("analogies.md", "motion", &moves);
}
