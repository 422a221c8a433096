//! Networks by node numbers, 0 for the ground.

use eigentone_modes::{GROUND, SparseModes, System};

pub fn name(node: usize) -> String {
    match node {
        0 => GROUND.to_owned(),
        i => format!("m{i}"),
    }
}

pub fn network(
    masses: impl IntoIterator<Item = f64>,
    springs: impl IntoIterator<Item = (usize, usize, f64)>,
) -> System {
    let mut builder = System::builder();
    for (i, mass) in masses.into_iter().enumerate() {
        builder = builder.mass(name(i + 1), mass);
    }
    for (a, b, stiffness) in springs {
        builder = builder.spring(name(a), name(b), stiffness);
    }
    builder.build().expect("the network is a system")
}

/// Asserts that these eigenvalues were found, within 1e-13 and their bounds, and that the count agrees.
pub fn assert_squares(modes: &SparseModes, expected: &[f64], what: &str) {
    assert!(modes.is_counted(), "{what}: not counted");
    assert_eq!(modes.len(), expected.len(), "{what}: number of modes");
    let found = modes.squares().iter().zip(modes.square_bounds());
    for (k, ((square, bound), exact)) in found.zip(expected).enumerate() {
        let error = (square - exact).abs();
        let rounding = 4.0 * f64::EPSILON * exact.abs();
        assert!(
            error <= 1e-13 * exact.abs(),
            "{what}: mode {k}: {square:e} is not {exact:e}"
        );
        let bound = bound.unwrap_or_else(|| panic!("{what}: mode {k} has no bound"));
        assert!(
            error <= bound + rounding,
            "{what}: mode {k}: off by {error:e}, bound {bound:e}"
        );
    }
}

/// Asserts K x = λ M x for a system of masses and springs, and xᵀMx = 1.
pub fn assert_shapes(system: &System, modes: &SparseModes, within: f64, what: &str) {
    let at =
        |shape: &[f64], node: eigentone_modes::Node| node.coordinate().map_or(0.0, |i| shape[i]);
    for (k, square) in modes.squares().iter().enumerate() {
        let shape: Vec<f64> = modes.shapes().col(k).iter().copied().collect();
        let mut forces = vec![0.0; shape.len()];
        let mut scale: f64 = 0.0;
        for spring in system.springs() {
            let (a, b) = (spring.first, spring.second);
            let force = spring.coefficient * (at(&shape, a) - at(&shape, b));
            scale = scale.max(spring.coefficient);
            if let Some(i) = a.coordinate() {
                forces[i] += force;
            }
            if let Some(i) = b.coordinate() {
                forces[i] -= force;
            }
        }
        let norm: f64 = shape
            .iter()
            .zip(system.masses())
            .map(|(x, m)| m * x * x)
            .sum();
        let off = (norm - 1.0).abs();
        assert!(off < 1e-12, "{what}: norm of mode {k}: {norm}");
        let largest = shape.iter().fold(0.0, |top: f64, x| top.max(x.abs()));
        for (i, force) in forces.iter().enumerate() {
            let rest = force - square * system.masses()[i] * shape[i];
            assert!(
                rest.abs() <= within * scale * largest,
                "{what}: mode {k} leaves {rest:e} at node {i}"
            );
        }
    }
}
