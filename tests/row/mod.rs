//! Masses in a row, which tests of several packages build.

use eigentone_modes::{GROUND, System};

/// Masses in a row with springs and dampers: the first of each between the ground and the first mass, the next between
/// that and the second, and one beyond the last mass between it and the ground.
pub(crate) fn in_a_row(masses: &[(&str, f64)], springs: &[f64], dampers: &[f64]) -> System {
    let name = |i: usize| masses.get(i).map_or(GROUND, |(name, _)| name);
    let before = |i: usize| i.checked_sub(1).map_or(GROUND, name);
    let mut row = System::builder();
    for (name, mass) in masses {
        row = row.mass(*name, *mass);
    }
    for (i, stiffness) in springs.iter().enumerate() {
        row = row.spring(before(i), name(i), *stiffness);
    }
    for (i, damping) in dampers.iter().enumerate() {
        row = row.damper(before(i), name(i), *damping);
    }
    row.build().expect("a system")
}
