//! Roots keep their places, however long the steps are.

use eigentone_design::{Followed, Follower};
use eigentone_modes::{GROUND, Precision, System};
use num_complex::Complex;

use crate::random::Random;

fn solved(system: System) -> Option<Follower> {
    let modes = system.modes_to(Precision::Double).ok()?;
    Follower::at(&system, &modes).ok()
}

/// Two oscillators, the first of stiffness `k`, with a spring between them.
fn two(k: f64, coupling: f64) -> Option<Follower> {
    let builder = System::builder().mass("a", 1.0).mass("b", 1.0);
    let builder = builder.spring(GROUND, "a", k).spring(GROUND, "b", 4.0);
    solved(builder.spring("a", "b", coupling).build().ok()?)
}

/// The roots at the end of a path in equal steps, and whether they are sure.
fn walked(steps: usize, solve: &dyn Fn(f64) -> Option<Follower>) -> (Vec<Complex<f64>>, bool) {
    let mut follower = solve(0.0).expect("a start");
    let mut sure = true;
    for k in 0..steps {
        let at = |t: f64| (k as f64 + t) / steps as f64;
        let followed = follower.advance(|t| solve(at(t))).expect("a design");
        sure &= followed == Followed::Surely;
    }
    (follower.roots().to_vec(), sure)
}

#[test]
fn a_veering_pair_keeps_its_places_at_every_step_size() {
    for steps in [1, 2, 3, 5, 10, 33, 100, 1000] {
        // With a coupling the lower root stays the lower one, without it they cross.
        for (coupling, first, second) in [(1e-6, 2.0, 3.0), (0.0, 3.0, 2.0)] {
            let (roots, sure) = walked(steps, &|t| two(1.0 + 8.0 * t, coupling));
            assert!(sure, "{steps} steps, coupling {coupling}");
            assert!(
                (roots[0].im - first).abs() < 1e-5,
                "{steps} steps, coupling {coupling}: {roots:?}"
            );
            assert!(
                (roots[2].im - second).abs() < 1e-5,
                "{steps} steps, coupling {coupling}: {roots:?}"
            );
        }
    }
}

/// Four oscillators of which the first becomes stiffer and passes the three others, with springs between all, and dampers.
fn four(k: f64, coupling: f64, damping: [f64; 2]) -> Option<Follower> {
    let name = |i: usize| format!("m{i}");
    let mut builder = System::builder();
    for i in 0..4 {
        builder = builder.mass(name(i), 1.0);
    }
    builder = builder.spring(GROUND, "m0", k);
    for i in 1..4 {
        builder = builder.spring(GROUND, name(i), 2.0 + 1.3 * i as f64);
    }
    for i in 0..4 {
        let c = damping[0] + damping[1] * i as f64;
        builder = builder.damper(GROUND, name(i), c);
        for j in 0..i {
            builder = builder.spring(name(j), name(i), coupling);
        }
    }
    solved(builder.build().ok()?)
}

#[test]
fn damped_roots_that_veer_or_cross_keep_their_places_at_every_step_size_both_ways() {
    // A coupling κ makes frequencies veer where it is more than half the difference of the rates of decay, about κ/2ω.
    let cases = [
        (1e-6, [0.0, 0.0], true),
        (1e-6, [1e-7, 0.7e-7], true),
        (1e-6, [1e-3, 0.0], true),
        (1e-9, [1e-3, 0.7e-3], false),
        (1e-3, [0.1, 0.07], false),
        (1e-2, [1e-3, 0.7e-3], true),
    ];
    for (coupling, damping, veers) in cases {
        let (low, high) = (1.0, 12.0);
        let at = |t: f64| four(low + t * (high - low), coupling, damping);
        let ends = [at(0.0), at(1.0)].map(|end| end.expect("a design").roots().to_vec());
        for steps in (1..=24).chain([40, 100, 301]) {
            for (way, solve) in [&at as &dyn Fn(f64) -> Option<Follower>, &|t: f64| {
                at(1.0 - t)
            }]
            .into_iter()
            .enumerate()
            {
                let case = format!("{coupling} {damping:?} {steps} steps, way {way}");
                let (roots, sure) = walked(steps, solve);
                assert!(sure, "{case}");
                // In the order of the start: the same order, or the first one passes the others.
                let mut wanted = ends[1 - way].clone();
                match (veers, way) {
                    (true, _) => {}
                    (false, 0) => wanted.rotate_right(2),
                    (false, _) => wanted.rotate_left(2),
                }
                for (found, right) in roots.iter().zip(&wanted) {
                    assert!((found - right).norm() < 1e-9, "{case}: {roots:?}");
                }
            }
        }
    }
}

#[test]
fn a_pair_that_meets_on_the_real_axis_becomes_two_roots_and_a_pair_again() {
    let damped = |c: f64| {
        let builder = System::builder().mass("a", 1.0).mass("b", 1.0);
        let builder = builder.spring(GROUND, "a", 1.0).spring(GROUND, "b", 900.0);
        solved(builder.damper(GROUND, "a", c).build().ok()?)
    };
    for steps in [1, 3, 7, 50] {
        let (roots, sure) = walked(steps, &|t| damped(1.0 + 1.5 * t));
        assert!(sure, "{steps} steps");
        assert!(
            (roots[0].re + 0.5).abs() < 1e-12 && (roots[1].re + 2.0).abs() < 1e-12,
            "{roots:?}"
        );
        let (roots, sure) = walked(steps, &|t| damped(2.5 - 1.5 * t));
        assert!(sure, "{steps} steps back");
        let pair = [0, 1].map(|k| roots[k]);
        assert!(pair[0].im > 0.0 && pair[0] == pair[1].conj(), "{roots:?}");
    }
}

#[test]
fn random_paths_with_crossings_agree_with_paths_a_hundred_times_finer() {
    let mut random = Random(1);
    let (mut crossings, mut doubtful) = (0, 0);
    for path in 0..1000 {
        let ends: Vec<[f64; 2]> = (0..4)
            .map(|_| [0, 1].map(|_| 0.5 + 4.0 * random.uniform()))
            .collect();
        let coupling = [0.0, 1e-6, 1e-3, 0.1][path % 4];
        let damping = [0.0, 0.02][path / 4 % 2];
        let solve = |t: f64| {
            let name = |i: usize| format!("m{i}");
            let mut builder = System::builder();
            for i in 0..4 {
                builder = builder.mass(name(i), 1.0);
            }
            for (i, [from, to]) in ends.iter().enumerate() {
                let (k, c) = (from + t * (to - from), damping * (i + 1) as f64);
                builder = builder
                    .spring(GROUND, name(i), k)
                    .damper(GROUND, name(i), c);
            }
            for i in 1..4 {
                builder = builder.spring(name(i - 1), name(i), coupling);
            }
            solved(builder.build().ok()?)
        };
        let (coarse, sure) = walked(1, &solve);
        let (fine, sure_too) = walked(100, &solve);
        // Masses that others couple may veer by less than doubles show.
        if !(sure && sure_too) {
            doubtful += 1;
            continue;
        }
        assert_eq!(coarse, fine, "path {path}: {ends:?}");
        let pairs = coarse
            .windows(2)
            .filter(|pair| pair[1].norm() < 0.999 * pair[0].norm());
        crossings += pairs.count();
    }
    assert!(crossings > 300, "{crossings} crossings");
    assert!(doubtful <= 5, "{doubtful} doubtful");
}

/// Two bodies that float freely, four zero roots with two shapes, until a spring holds them together: how they part is the same at
/// every size, so that designs between tell nothing, however close to 0, and few are asked for.
#[test]
fn roots_that_part_the_same_at_every_size_are_not_pursued() {
    let solve = |k: f64| {
        let builder = System::builder().mass("a", 1.0).mass("b", 2.0);
        let builder = builder.mass("c", 1.5).spring("b", "c", 7.0);
        let builder = builder.damper("b", "c", 0.3).spring("a", "b", k);
        solved(builder.build().ok()?)
    };
    let mut follower = solve(0.0).expect("a start");
    let mut asked = 0;
    let followed = follower.advance(|t| {
        asked += 1;
        solve(t)
    });
    assert_eq!(followed, Ok(Followed::Doubtful));
    assert!(asked < 100, "{asked}");
    let mut roots = follower.roots().to_vec();
    roots.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
    // The centre of mass floats on, and a moves against the two others, about.
    assert_eq!(roots[..2], [Complex::ZERO; 2]);
    let about = (1.0f64 / 1.0 + 1.0 / 3.5).sqrt();
    for root in &roots[2..4] {
        assert!((root.im.abs() - about).abs() < 0.1, "{roots:?}");
    }
}
