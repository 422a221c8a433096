//! The names that columns of motions have in every table, and what each of them is.

use eigentone_modes::{ElementKind, System};
use eigentone_response::{Combination, Quantity, Sum};

use super::unit;

/// Each quantity that a table of a system's motion may show, under the header that its column has in CSV: three derivatives
/// of each mass and point, the tension in each spring and damper with a name, and the outputs.
pub fn motion_columns(system: &System, outputs: &[Combination]) -> Vec<(String, Combination)> {
    let mut columns = Vec::new();
    let mut push = |header: &str, of: Sum| {
        let name = header.to_owned();
        let one = Combination { name, of };
        let unit = unit::output(system, &one);
        columns.push((unit::bracketed(header, unit), one));
    };
    let points = system.points().iter().map(|point| &point.name);
    for (what, quantity) in [
        ("displacement", Quantity::Displacement),
        ("velocity", Quantity::Velocity),
        ("acceleration", Quantity::Acceleration),
    ] {
        for name in system.names().iter().chain(points.clone()) {
            let of = Sum::Motions(vec![(quantity, name.clone(), 1.0)]);
            push(&format!("{what} {name}"), of);
        }
    }
    for (what, kind) in [
        ("spring", ElementKind::Spring),
        ("damper", ElementKind::Damper),
    ] {
        for element in system.elements(kind) {
            if let Some(name) = &element.name {
                push(&format!("{what} {name}"), Sum::Pull(name.clone()));
            }
        }
    }
    for output in outputs {
        push(&format!("output {}", output.name), output.of.clone());
    }
    columns
}
