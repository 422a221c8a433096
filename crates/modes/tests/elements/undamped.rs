//! Beams, membranes and trusses without damping.

use crate::mesh::{Ends, Model, beam, lumped_beam, membrane, truss};
use crate::truth::examine;

fn models() -> Vec<(String, Model)> {
    let mut models = Vec::new();
    for elements in [33, 55] {
        for ends in [Ends::Free, Ends::Clamped, Ends::Pinned, Ends::Cantilever] {
            models.push((format!("{ends:?} {elements}"), beam(elements, ends)));
        }
    }
    models.push(("free 100".to_owned(), beam(100, Ends::Free)));
    for ends in [Ends::Free, Ends::Clamped, Ends::Pinned, Ends::Cantilever] {
        models.push((format!("lumped {ends:?}"), lumped_beam(40, ends)));
    }
    for held in [false, true] {
        models.push((format!("membrane held {held}"), membrane(9, 8, held)));
        models.push((format!("square membrane held {held}"), membrane(9, 9, held)));
        models.push((format!("truss held {held}"), truss(20, held)));
    }
    models
}

/// The tiny roots that rounding leaves of rigid motions are known to fewer digits than the others.
#[test]
fn modes_of_meshes_are_right() {
    for (name, model) in models() {
        let modes = examine(&name, &model, 1e-6);
        let worst = modes
            .eigenvalues()
            .iter()
            .filter(|root| root.value.norm() > 1.0);
        for root in worst {
            let bound = root.bound.unwrap_or(f64::INFINITY);
            assert!(bound <= 2e-16 * root.value.norm(), "{name}: {root:?}");
        }
    }
}
