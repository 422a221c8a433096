//! Undamped finite elements against counts in 384 bits.

use eigentone_modes::{Frequency, SparseModes};

use crate::elements::{Ends, Model, beam, frame, membrane, rod, truss};
use crate::inertia::assert_lowest;

fn check(what: &str, model: &Model, count: usize, within: f64) -> SparseModes {
    let modes = SparseModes::lowest(&model.system(), count).expect("modes");
    assert_lowest(model, &modes, within, what);
    modes
}

#[test]
fn beams_of_any_ends() {
    for elements in [33, 150, 300] {
        for ends in [Ends::Clamped, Ends::Pinned, Ends::Cantilever] {
            let model = beam(ends, elements, 2.0, 1500.0, 3.1);
            let what = format!("{ends:?} beam of {elements} elements");
            check(&what, &model, 8, 1e-15);
        }
    }
}

#[test]
fn beams_near_targets_below_all_of_their_frequencies() {
    for elements in [300, 1000] {
        for ends in [Ends::Clamped, Ends::Cantilever] {
            let model = beam(ends, elements, 2.0, 1500.0, 3.1);
            let system = model.system();
            let lowest = SparseModes::lowest(&system, 1).expect("the lowest mode");
            let lowest = lowest.frequencies()[0].radians_per_second();
            for factor in [0.5, 1e-4] {
                let target = Frequency::from_radians_per_second(factor * lowest);
                let modes = SparseModes::nearest(&system, target, 6).expect("modes");
                let what = format!("{ends:?} beam of {elements} elements, {factor}");
                assert_lowest(&model, &modes, 1e-14, &what);
            }
        }
    }
}

#[test]
fn free_beams_as_their_matrices_have_them() {
    for elements in [40, 55, 120, 190, 300, 600] {
        let model = beam(Ends::Free, elements, 2.0, 1500.0, 3.1);
        let what = format!("free beam of {elements} elements");
        check(&what, &model, 8, 1e-9);
    }
}

#[test]
fn membranes_of_double_eigenvalues() {
    for side in [8, 13] {
        let model = membrane(side);
        for count in [2, 5, 12] {
            check(
                &format!("membrane of {side}, {count}"),
                &model,
                count,
                1e-14,
            );
        }
    }
}

#[test]
fn rods_of_graded_stiffness() {
    for (elements, factor) in [(100, 1.2), (80, 0.7), (120, 1.35)] {
        for held in [true, false] {
            let model = rod(elements, 1.0, factor, held);
            check(&format!("rod, {factor}, {held}"), &model, 6, 1e-10);
        }
    }
}

#[test]
fn free_frames() {
    let nodes: Vec<[f64; 2]> = (0..40)
        .map(|i| [0.3 * f64::from(i), 0.7 * f64::from(i % 2)])
        .collect();
    let bars: Vec<[usize; 2]> = (1usize..40)
        .flat_map(|i| [[i - 1, i], [i.saturating_sub(2), i]])
        .filter(|[a, b]| a != b)
        .collect();
    let model = frame(&nodes, &bars, [2e7, 300.0, 1.7]);
    check("free frame", &model, 9, 1e-7);
}

#[test]
fn mechanisms() {
    // Squares without diagonals lean over.
    let nodes: Vec<[f64; 2]> = (0..40)
        .map(|i| [f64::from(i / 2), f64::from(i % 2)])
        .collect();
    let rungs = (0..20).map(|i| [2 * i, 2 * i + 1]);
    let rails = (0..38).map(|i| [i, i + 2]);
    let bars: Vec<[usize; 2]> = rungs.chain(rails).collect();
    let model = truss(&nodes, &bars, 1e6, 0.5);
    let modes = check("ladder", &model, 30, 1e-13);
    // 80 coordinates, 58 bars.
    assert_eq!(
        modes
            .squares()
            .iter()
            .filter(|square| **square == 0.0)
            .count(),
        22
    );
}

#[test]
fn free_beams_as_far_as_their_ideal_is_kept() {
    let modes = SparseModes::lowest(&beam(Ends::Free, 300, 2.0, 1500.0, 3.1).system(), 4).unwrap();
    // Elastic roots of the matrices differ from those of the beam by their own rounding, u‖K‖ in ω².
    for (found, exact) in modes.frequencies()[2..].iter().zip([123.036_67, 339.155]) {
        let found = found.radians_per_second();
        assert!((found / exact - 1.0).abs() < 1e-4, "{found} {exact}");
    }
}
