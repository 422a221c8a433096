//! Rotors against closed forms, and critical speeds against the eigenproblem that has them for roots.

use eigentone_design::{Branch, Campbell, CampbellError, CriticalSpeed, Whirl};
use eigentone_modes::{GROUND, MatrixKind, System};
use faer::Mat;
use num_complex::Complex;

use crate::random::Random;

/// An overhung disc on a shaft (Stodola): deflections y, z and slopes of both planes, m = I_d = 1 and I_p = 2. Forward, with
/// s = Ω²: (5 − s)(5 + s) = 9, so that Ω = 2 is the only one. Backward: (5 − s)(5 − 3s) = 9, so that 3s² − 20s + 16 = 0.
fn stodola() -> System {
    let mut stiffness = Mat::zeros(4, 4);
    let mut gyroscopic = Mat::zeros(4, 4);
    for plane in 0..2 {
        let (w, r) = (2 * plane, 2 * plane + 1);
        stiffness[(w, w)] = 5.0;
        stiffness[(r, r)] = 5.0;
        stiffness[(w, r)] = 3.0;
        stiffness[(r, w)] = 3.0;
    }
    gyroscopic[(1, 3)] = 2.0;
    gyroscopic[(3, 1)] = -2.0;
    let mass = Mat::identity(4, 4);
    System::from_matrices(mass.as_ref(), gyroscopic.as_ref(), stiffness.as_ref()).expect("a rotor")
}

/// One angle of a disc has 5 times the critical damping, so that its pair parts on the real axis and meets again: with G of rising
/// speed Ω, (λ² + 2)(λ² + 10λ + 2) + Ω²λ² = 0, and every root that oscillates at a speed is one of a branch.
#[test]
fn modes_that_cease_to_oscillate_go_on() {
    let damping = faer::mat![[0.0, 1.0], [-1.0, 10.0]];
    let (mass, stiffness) = (Mat::<f64>::identity(2, 2), 2.0 * Mat::<f64>::identity(2, 2));
    let rotor = System::from_matrices(mass.as_ref(), damping.as_ref(), stiffness.as_ref());
    let rotor = rotor.expect("a rotor");
    for count in [5, 40, 200] {
        let speeds = grid(20.0, count);
        let diagram = Campbell::of(&rotor).over(&speeds).expect("a diagram");
        for (k, speed) in speeds.iter().enumerate() {
            let found: Vec<_> = diagram
                .branches()
                .iter()
                .map(|branch| branch.roots[k])
                .collect();
            let spun = rotor.with_gyroscopic_part(*speed).expect("a rotor");
            let modes = spun.modes().expect("modes");
            let upper = modes.eigenvalues().iter().map(|root| root.value);
            let mut upper: Vec<_> = upper.filter(|root| root.im > 0.0).collect();
            let mut oscillating: Vec<_> = found.into_iter().filter(|root| root.im != 0.0).collect();
            let by_height = |a: &Complex<f64>, b: &Complex<f64>| a.im.total_cmp(&b.im);
            upper.sort_by(by_height);
            oscillating.sort_by(by_height);
            assert_eq!(upper, oscillating, "at {speed} rad/s");
            for root in &upper {
                let square = root * root;
                let left = (square + 2.0) * (square + 10.0 * root + 2.0) + speed * speed * square;
                assert!(
                    left.norm() < 1e-9 * (1.0 + square.norm_sqr()),
                    "{root} at {speed}"
                );
            }
        }
        assert!(
            diagram
                .branches()
                .iter()
                .all(|one| one.roots.iter().all(|root| root.im >= 0.0))
        );
    }
}

fn grid(to: f64, count: usize) -> Vec<f64> {
    (0..=count).map(|k| to * k as f64 / count as f64).collect()
}

/// Within its bound, and a bound of a few last places.
fn is(found: &CriticalSpeed, speed: f64) {
    let off = (found.speed - speed).abs();
    assert!(
        off <= found.bound + f64::EPSILON * speed,
        "{} for {speed}",
        found.speed
    );
    assert!(found.bound <= 8.0 * f64::EPSILON * speed, "{found:?}");
    assert!((found.root.im - found.order * speed).abs() <= 16.0 * f64::EPSILON * speed);
}

#[test]
fn an_overhung_disc_has_the_critical_speeds_of_its_closed_form() {
    let larger = (10.0 + 52.0f64.sqrt()) / 3.0;
    let backward = [(16.0 / 3.0 / larger).sqrt(), larger.sqrt()];
    let rotor = stodola();
    for count in [1, 7, 100] {
        let diagram = Campbell::of(&rotor)
            .over(&grid(10.0, count))
            .expect("a diagram");
        let all = diagram.critical_speeds();
        assert_eq!(all.len(), 3);
        for (found, speed) in all.iter().zip([backward[0], 2.0, backward[1]]) {
            is(found, speed);
        }
        let senses = [Whirl::Backward, Whirl::Forward, Whirl::Backward].map(Some);
        assert!(all.iter().map(|found| found.whirl).eq(senses));
        assert!(diagram.is_complete() && diagram.is_sure());
    }
}

/// (5 − σ²)(5 + 2Ωσ − σ²) = 9 for the signed frequencies σ: forward ones with one sign, backward ones with the other.
#[test]
fn branches_keep_their_whirl_and_obey_the_frequency_equation() {
    let diagram = Campbell::of(&stodola())
        .over(&grid(10.0, 50))
        .expect("a diagram");
    assert_eq!(diagram.branches().len(), 4);
    for Branch { roots, whirl } in diagram.branches() {
        assert_eq!(whirl[0], None, "at rest they are one");
        let sense = whirl[1].expect("a sense");
        assert!(whirl[1..].iter().all(|other| *other == Some(sense)));
        for (root, speed) in roots.iter().zip(diagram.speeds()) {
            let sign = if sense == Whirl::Forward { 1.0 } else { -1.0 };
            let (w, g) = (root.im, 2.0 * speed * sign * root.im);
            let residual = (5.0 - w * w) * (5.0 + g - w * w) - 9.0;
            let size = (5.0 + w * w) * (5.0 + g.abs() + w * w);
            assert!(residual.abs() <= 1e-14 * size, "{residual} at {speed}");
        }
        let frequencies: Vec<f64> = roots.iter().map(|root| root.im).collect();
        assert!(frequencies.windows(2).all(|pair| match sense {
            Whirl::Forward => pair[0] < pair[1],
            Whirl::Backward => pair[0] > pair[1],
        }));
    }
}

/// The speed that the matrix holds at is a unit, and orders divide speeds.
#[test]
fn references_and_orders_scale() {
    let rotor = stodola();
    let found = Campbell::of(&rotor).given_at(3.0).orders([1.0, 2.0, 0.5]);
    let diagram = found.over(&grid(30.0, 13)).expect("a diagram");
    assert!(diagram.is_complete());
    for critical in diagram.critical_speeds() {
        // H = K − n²Ω²M + inΩ²G/3, of which one sense is (5 − n²s)(5 − n²s ± 2ns/3) = 9.
        let (n, s) = (critical.order, critical.speed * critical.speed);
        let sign = if critical.whirl == Some(Whirl::Forward) {
            1.0
        } else {
            -1.0
        };
        let (a, b) = (5.0 - n * n * s, 5.0 - n * n * s + sign * 2.0 * n * s / 3.0);
        assert!((a * b - 9.0).abs() <= 1e-13 * (5.0 + n * n * s) * (5.0 + n * n * s + n * s));
        assert!(
            critical.bound <= 16.0 * f64::EPSILON * critical.speed,
            "{critical:?}"
        );
    }
    let count = |order: f64| {
        diagram
            .critical_speeds()
            .iter()
            .filter(|c| c.order == order)
            .count()
    };
    // A disc with I_p/I_d = 2/3 whirls forward faster than half the speed for ever.
    assert_eq!((count(1.0), count(2.0), count(0.5)), (4, 4, 3));
}

/// K x = s (n²M − inG) x has the squares of critical speeds for roots, each twice in real numbers.
#[test]
fn counts_are_those_of_the_eigenproblem_of_critical_speeds() {
    let mut random = Random(7);
    for n in [2, 3, 4, 5, 3, 4] {
        let mut square = || Mat::from_fn(n, n, |_, _| 2.0 * random.uniform() - 1.0);
        let definite = |a: Mat<f64>| a.transpose() * &a + Mat::<f64>::identity(n, n);
        let symmetric = |a: Mat<f64>| Mat::from_fn(n, n, |i, j| a[(i.max(j), i.min(j))]);
        let (mass, stiffness) = (symmetric(definite(square())), symmetric(definite(square())));
        let a = square();
        let gyroscopic = &a - a.transpose();
        let rotor = System::from_matrices(mass.as_ref(), gyroscopic.as_ref(), stiffness.as_ref());
        let diagram = Campbell::of(&rotor.expect("a rotor")).over(&[0.0, 1.0, 50.0]);
        let diagram = diagram.expect("a diagram");
        assert!(diagram.is_complete());
        let twice = |same: &Mat<f64>, across: &Mat<f64>| {
            Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
                (true, true) => same[(i, j)],
                (true, false) => across[(i, j - n)],
                (false, true) => -across[(i - n, j)],
                (false, false) => same[(i - n, j - n)],
            })
        };
        let none = Mat::zeros(n, n);
        let pencil = System::builder()
            .matrix(MatrixKind::Mass, twice(&mass, &gyroscopic).as_ref())
            .matrix(MatrixKind::Stiffness, twice(&stiffness, &none).as_ref())
            .build()
            .expect("a pencil");
        let modes = pencil.modes().expect("modes");
        let mut expected: Vec<f64> = modes
            .eigenvalues()
            .iter()
            .map(|root| root.value.im)
            .collect();
        expected.retain(|speed| *speed > 1e-9 && *speed < 50.0);
        expected.sort_by(f64::total_cmp);
        let found = diagram.critical_speeds();
        assert_eq!(
            expected.len(),
            2 * found.iter().map(|c| c.count).sum::<usize>()
        );
        for (pair, found) in expected.chunks(2).zip(found) {
            assert!(
                (pair[0] - found.speed).abs() <= 1e-12 * found.speed,
                "{pair:?} {found:?}"
            );
            assert!(found.bound <= 1e-13 * found.speed, "{found:?}");
        }
    }
}

/// Frequencies √(4 − (c/2)²) of two planes at every speed: both meet the order there, and no list is called complete.
#[test]
fn a_damped_shaft_is_critical_at_its_damped_frequency() {
    let mut builder = System::builder();
    for plane in ["y", "z"] {
        builder = builder
            .mass(plane, 1.0)
            .spring(GROUND, plane, 4.0)
            .damper(GROUND, plane, 0.5);
    }
    let rotor = builder.build().expect("a rotor");
    let diagram = Campbell::of(&rotor)
        .over(&grid(5.0, 10))
        .expect("a diagram");
    let [found] = diagram.critical_speeds() else {
        panic!("one critical speed");
    };
    is(found, (4.0f64 - 0.0625).sqrt());
    assert_eq!((found.count, found.whirl), (2, None));
    assert!(!diagram.is_complete());
}

/// A shaft of two Hermite elements in each plane, pinned at both ends, m = EI = h = 1, with a gyroscopic coupling of its
/// middle. Where the middle stays at rest, 4(1 − s) = ±(2 + 3s) for ω² = 420s at every speed: ω² = 120 and 2520.
#[test]
fn modes_with_a_node_at_the_disc_whirl_in_no_sense() {
    let stiffness = [
        [4.0, -6.0, 2.0, 0.0],
        [-6.0, 24.0, 0.0, 6.0],
        [2.0, 0.0, 8.0, 2.0],
        [0.0, 6.0, 2.0, 4.0],
    ];
    let mass = [
        [4.0, 13.0, -3.0, 0.0],
        [13.0, 312.0, 0.0, -13.0],
        [-3.0, 0.0, 8.0, -3.0],
        [0.0, -13.0, -3.0, 4.0],
    ];
    let of_planes = |plane: [[f64; 4]; 4], unit: f64| {
        Mat::from_fn(8, 8, |i, j| match i / 4 == j / 4 {
            true => plane[i % 4][j % 4] / unit,
            false => 0.0,
        })
    };
    let (mass, stiffness) = (of_planes(mass, 420.0), of_planes(stiffness, 1.0));
    let mut gyroscopic = Mat::zeros(8, 8);
    gyroscopic[(1, 5)] = 0.1;
    gyroscopic[(5, 1)] = -0.1;
    let rotor = System::from_matrices(mass.as_ref(), gyroscopic.as_ref(), stiffness.as_ref());
    let rotor = rotor.expect("a rotor");
    let diagram = Campbell::of(&rotor)
        .over(&grid(50.0, 2))
        .expect("a diagram");
    let still = [120.0f64.sqrt(), 2520.0f64.sqrt()];
    let rests = |omega: f64| {
        still
            .iter()
            .any(|still| (omega / still - 1.0).abs() < 1e-12)
    };
    let (mut resting, mut whirling) = (0, 0);
    for Branch { roots, whirl } in diagram.branches() {
        for (root, sense) in roots.iter().zip(whirl).skip(1) {
            assert_eq!(sense.is_none(), rests(root.im), "{root}: {sense:?}");
            *if sense.is_none() {
                &mut resting
            } else {
                &mut whirling
            } += 1;
        }
    }
    assert_eq!([resting, whirling], [8, 8]);
    for critical in diagram.critical_speeds() {
        assert_eq!(critical.whirl.is_none(), rests(critical.speed));
    }
}

/// A node without mass between spring and bearing changes nothing but the stiffness, 1/(1/8 + 1/8); with gyroscopic forces
/// on it roots would come from infinity.
#[test]
fn massless_nodes_are_no_matter_unless_gyroscopic_forces_act_on_them() {
    let builder = |on: [usize; 2]| {
        let mut gyroscopic = Mat::zeros(4, 4);
        gyroscopic[(on[0], on[1])] = 0.5;
        gyroscopic[(on[1], on[0])] = -0.5;
        let mut builder = System::builder();
        for (disc, node) in [("y", "node y"), ("z", "node z")] {
            builder = builder.mass(disc, 1.0).mass(node, 0.0);
            builder = builder.spring(disc, node, 8.0).spring(node, GROUND, 8.0);
        }
        builder.matrix(MatrixKind::Damping, gyroscopic.as_ref())
    };
    let rotor = |on| builder(on).build().expect("a rotor");
    let diagram = |on| Campbell::of(&rotor(on)).over(&grid(5.0, 10));
    let found = diagram([0, 2]).expect("a diagram");
    let [backward, forward] = found.critical_speeds() else {
        panic!("two critical speeds");
    };
    is(backward, (8.0f64 / 3.0).sqrt());
    is(forward, 8.0f64.sqrt());
    // A point with mass joins both discs in M: as without the nodes, whose springs are one of 4 N/m each.
    let joined = |system: &System| {
        let diagram = Campbell::of(system)
            .over(&grid(5.0, 10))
            .expect("a diagram");
        let speeds = diagram.critical_speeds().iter().map(|found| found.speed);
        speeds.collect::<Vec<f64>>()
    };
    let mass = faer::mat![[2.0, 1.0], [1.0, 2.0]];
    let gyroscopic = faer::mat![[0.0, 0.5], [-0.5, 0.0]];
    let stiffness = faer::mat![[4.0, 0.0], [0.0, 4.0]];
    let alone = System::from_matrices(mass.as_ref(), gyroscopic.as_ref(), stiffness.as_ref());
    let found = joined(
        &builder([0, 2])
            .point("p", [("y", 1.0), ("z", 1.0)], 1.0)
            .build()
            .expect("a rotor"),
    );
    let wanted = joined(&alone.expect("a rotor"));
    assert!(found.len() == wanted.len() && !found.is_empty());
    for (found, wanted) in found.iter().zip(&wanted) {
        assert!((found - wanted).abs() < 1e-14 * wanted, "{found} {wanted}");
    }
    assert!(matches!(
        diagram([0, 3]),
        Err(CampbellError::Massless { index: 3 })
    ));
}

#[test]
fn what_makes_no_diagram_is_an_error() {
    let rotor = stodola();
    let error = |speeds: &[f64]| Campbell::of(&rotor).over(speeds).expect_err("no diagram");
    for (count, speeds) in [&[][..], &[1.0]].into_iter().enumerate() {
        assert_eq!(error(speeds), CampbellError::FewSpeeds { count });
    }
    for speeds in [[2.0, 1.0], [1.0, 1.0], [-1.0, 1.0], [0.0, f64::NAN]] {
        assert!(matches!(error(&speeds), CampbellError::Speeds { .. }));
    }
    for wrong in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        let given = Campbell::of(&rotor).given_at(wrong).over(&[0.0, 1.0]);
        assert!(matches!(given, Err(CampbellError::NotPositive { .. })));
        let orders = Campbell::of(&rotor).orders([wrong]).over(&[0.0, 1.0]);
        assert!(matches!(orders, Err(CampbellError::NotPositive { .. })));
    }
    for (given_at, speed) in [(1.0, 1e300), (1.0, 1e-310), (1e-300, 1e300)] {
        let found = Campbell::of(&rotor).given_at(given_at).over(&[0.0, speed]);
        assert_eq!(found.err(), Some(CampbellError::FarSpeed { speed }));
    }
}
