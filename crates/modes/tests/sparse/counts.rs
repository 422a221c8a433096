//! Where none is said to be missing, as many roots are listed as the determinant has, by its winding number in 384 bits;
//! elsewhere the plan says what the proof lacks.

use eigentone_modes::{Frequency, Mode, Modes, SparseModes};

use crate::elements::{Ends, Model, beam, membrane, rod};
use crate::inertia::below_radius;

/// How many roots a mode stands for.
fn roots(mode: &Mode) -> i64 {
    match mode.eigenvalue().value.im == 0.0 {
        true => mode.roots() as i64,
        false => 2 * mode.roots() as i64,
    }
}

/// Asserts that modes near a target are complete, and that their number is that of the roots between them.
fn assert_complete(model: &Model, modes: &Modes, target: f64, what: &str) {
    assert_eq!(modes.plan().incomplete, None, "{what}");
    assert!(modes.is_complete(), "{what}");
    let size = |mode: &Mode| mode.eigenvalue().value.norm();
    // A rim in the widest gap between the farther ones.
    let mut apart: Vec<f64> = modes
        .iter()
        .map(|mode| (size(mode) - target).abs())
        .collect();
    apart.sort_by(f64::total_cmp);
    let farther = apart[apart.len() / 2..].windows(2);
    let widest = farther.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
    let reach = widest.map_or(0.5 * apart[0], |gap| 0.5 * (gap[0] + gap[1]));
    let [low, high] = [(target - reach).max(0.0), target + reach];
    let inside = |mode: &&Mode| size(mode) < high && (low == 0.0 || size(mode) > low);
    let listed: i64 = modes.iter().filter(inside).map(roots).sum();
    let below = |radius: f64| match radius > 0.0 {
        true => below_radius(model, radius),
        false => 0,
    };
    assert_eq!(listed, below(high) - below(low), "{what}");
}

fn lowest(model: &Model, count: usize) -> Modes {
    let found = SparseModes::lowest(&model.system(), count).unwrap();
    found.modes().unwrap()
}

fn nearest(model: &Model, target: f64, count: usize) -> Modes {
    let target = Frequency::from_radians_per_second(target);
    let found = SparseModes::nearest(&model.system(), target, count).unwrap();
    found.modes().unwrap()
}

#[test]
fn dashpots_on_beams() {
    for ends in [Ends::Cantilever, Ends::Pinned] {
        for damping in [0.3, 40.0, 2e4, 1e8] {
            let mut model = beam(ends, 60, 2.0, 1500.0, 3.1);
            model.damping.add(model.n - 4, model.n - 4, damping);
            model.damping.add(41, 41, 0.01 * damping);
            let what = format!("{ends:?} {damping}");
            assert_complete(&model, &lowest(&model, 12), 0.0, &what);
            assert_complete(&model, &nearest(&model, 2000.0, 5), 2000.0, &what);
        }
    }
}

#[test]
fn free_beams_whose_stiffness_is_rounded() {
    // K is not positive semidefinite: rounding gives rigid motions ω² of either sign.
    for damping in [0.3, 1e4] {
        let mut model = beam(Ends::Free, 100, 2.0, 1500.0, 3.1);
        model.damping.add(0, 0, damping);
        let modes = nearest(&model, 3000.0, 5);
        assert_complete(&model, &modes, 3000.0, &format!("{damping}"));
    }
}

#[test]
fn many_strong_dashpots_are_counted_or_not_claimed() {
    let mut model = beam(Ends::Pinned, 70, 2.0, 1500.0, 3.1);
    for k in 0..20 {
        let node = 6 * k + 4;
        model.damping.add(node, node, 300.0 + node as f64);
    }
    let modes = lowest(&model, 8);
    match modes.plan().incomplete {
        None => assert_complete(&model, &modes, 0.0, "strong"),
        Some(_) => assert!(!modes.is_complete()),
    }
}

#[test]
fn roots_that_damping_parts_a_little() {
    // Of double frequencies one root moves by 1e-4 to 2e-4 of its size.
    for side in [9, 15] {
        let mut model = membrane(side);
        for (node, damping) in [(3 * side + 5, 0.3), (7 * side + 4, 0.15)] {
            model.damping.add(node, node, damping);
        }
        assert_complete(&model, &lowest(&model, 9), 0.0, &format!("{side}"));
    }
}

#[test]
fn nearly_critical_dashpots() {
    // A pair of real roots, or of complex ones, that nearly meet.
    let rest = |damping: f64| {
        let mut model = rod(40, 1.0, 1.0, true);
        model.damping.add(39, 39, damping);
        model
    };
    let reals = |damping: f64| {
        let modes = lowest(&rest(damping), 6);
        let real = |mode: &&Mode| mode.eigenvalue().value.im == 0.0;
        modes.iter().filter(real).count()
    };
    let (mut low, mut high) = (0.01, 10.0);
    assert!(reals(low) == 0 && reals(high) > 0);
    for _ in 0..40 {
        let middle: f64 = f64::sqrt(low * high);
        *(if reals(middle) == 0 {
            &mut low
        } else {
            &mut high
        }) = middle;
    }
    for damping in [low, high] {
        let model = rest(damping);
        let modes = lowest(&model, 6);
        if modes.is_complete() {
            assert_complete(&model, &modes, 0.0, &format!("{damping}"));
        }
    }
}

#[test]
fn what_a_proof_lacks_is_said() {
    let mut model = rod(120, 1.0, 1.0, true);
    for node in 0..60 {
        model.damping.add(node, node, 0.01);
    }
    let modes = lowest(&model, 4);
    assert!(!modes.is_complete());
    let reason = modes.plan().incomplete.unwrap();
    assert!(reason.contains("48"), "{reason}");
    let mut model = rod(120, 1.0, 1.0, true);
    model.damping.add(7, 7, -0.01);
    let modes = lowest(&model, 4);
    assert!(!modes.is_complete());
    let reason = modes.plan().incomplete.unwrap();
    assert!(reason.contains("damping matrix"), "{reason}");
}
