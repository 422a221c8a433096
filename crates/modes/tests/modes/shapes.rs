//! Shapes that formulas give, and what is said of them where they are not determined.

use eigentone_digits::DoubleDouble;
use eigentone_modes::{Bounds, GROUND, Mode, Precision, System, SystemBuilder};
use faer::{Mat, mat};

use crate::root::{Join, U, network};

/// sin(pπ/q), with p brought to 0 ≤ 2p ≤ q.
#[derive(Clone, Copy)]
struct Sine {
    negative: bool,
    p: u64,
    q: u64,
}

impl Sine {
    fn of(p: usize, q: usize) -> Sine {
        let (p, q) = (p as u64 % (2 * q as u64), q as u64);
        let (negative, p) = (p > q, p % q);
        Sine {
            negative,
            p: p.min(q - p),
            q,
        }
    }

    fn value(self) -> DoubleDouble {
        let x = DoubleDouble::TAU * (self.p as f64) / (2.0 * self.q as f64).into();
        let (mut term, mut sum) = (x, x);
        for k in 1..20 {
            term = -(term * x * x / f64::from(2 * k * (2 * k + 1)).into());
            sum += term;
        }
        if self.negative { -sum } else { sum }
    }
}

/// A chain of n masses between two walls, and its shapes sin(ijπ/(n + 1)).
fn between_walls(n: usize) -> (Vec<Join>, Vec<Vec<Sine>>) {
    let joins = (0..=n).map(|i| (i, (i + 1) % (n + 1), 3.0));
    let shape = |j: usize| (1..=n).map(|i| Sine::of(i * j, n + 1)).collect();
    (joins.collect(), (1..=n).map(shape).collect())
}

/// One that hangs from a wall: sin(i(2j − 1)π/(2n + 1)).
fn hanging(n: usize) -> (Vec<Join>, Vec<Vec<Sine>>) {
    let joins = (0..n).map(|i| (i, i + 1, 3.0));
    let shape = |j: usize| {
        (1..=n)
            .map(|i| Sine::of(i * (2 * j - 1), 2 * n + 1))
            .collect()
    };
    (joins.collect(), (1..=n).map(shape).collect())
}

/// One that nothing holds: cos((2i − 1)(j − 1)π/2n).
fn free(n: usize) -> (Vec<Join>, Vec<Vec<Sine>>) {
    let joins = (1..n).map(|i| (i, i + 1, 3.0));
    let shape = |j: usize| {
        (1..=n)
            .map(|i| Sine::of(n + (2 * i - 1) * (j - 1), 2 * n))
            .collect()
    };
    (joins.collect(), (1..=n).map(shape).collect())
}

fn assert_shape(mode: &Mode, truth: &[Sine], what: &str) {
    let bounds = mode.shape_bound().expect(what);
    let largest = truth.iter().map(|sine| sine.p).max().expect("not empty");
    let pivot = truth.iter().position(|sine| sine.p == largest);
    let pivot = pivot.expect("it is one of them");
    let scale = truth[pivot].value();
    for (i, sine) in truth.iter().enumerate() {
        let (found, bound) = (mode.shape()[i], bounds[i]);
        let what = format!("{what}, component {i}: {found} ± {bound:e}");
        assert_eq!(found.im, 0.0, "{what}");
        if sine.p == 0 {
            assert!(found.re.abs() <= bound && bound <= 1e-20, "{what}");
            continue;
        }
        let truth = sine.value() / scale;
        let error = (truth - found.re.into()).to_f64().abs();
        let size = truth.to_f64().abs();
        assert!(error <= bound + 1e-29 * size, "{what}: {error:e}");
        assert!(bound <= 4.0 * U * size, "{what}");
        assert!(error <= 1.01 * U * size, "{what}: {error:e}");
    }
    assert_eq!(
        (mode.shape()[pivot].re, bounds[pivot]),
        (1.0, 0.0),
        "{what}"
    );
}

#[test]
fn uniform_chains() {
    for n in [2, 3, 6, 12, 17, 30, 64, 100] {
        for (kind, (joins, truth)) in [between_walls(n), hanging(n), free(n)].iter().enumerate() {
            let system = network(&vec![0.75; n], joins, &[]);
            let modes = system.modes().expect("modes");
            assert_eq!(modes.bounds(), Bounds::Proven);
            for (j, (mode, truth)) in modes.iter().zip(truth).enumerate() {
                assert_shape(mode, truth, &format!("{kind}, {n} masses, mode {j}"));
            }
        }
    }
}

#[test]
fn uniform_chains_with_dampers_beside_the_springs() {
    // ζ = βω/2 with ω ≤ 4: light, and light enough for one pair of roots to each shape.
    for n in [3, 12, 40, 90] {
        for (joins, truth) in [between_walls(n), hanging(n)] {
            let dampers: Vec<Join> = joins.iter().map(|&(i, j, k)| (i, j, k / 64.0)).collect();
            let modes = network(&vec![0.75; n], &joins, &dampers)
                .modes()
                .expect("modes");
            for (j, (mode, truth)) in modes.iter().zip(&truth).enumerate() {
                assert!(mode.damped_frequency().radians_per_second() > 0.0);
                assert_shape(mode, truth, &format!("{n} masses, mode {j}"));
            }
        }
    }
}

#[test]
fn a_classical_system_has_real_shapes() {
    // Caughey damping that is not Rayleigh's: M = I, C = K².
    let k = mat![[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]];
    let c = (&k * &k) * faer::Scale(1.0 / 64.0);
    let m = Mat::<f64>::identity(3, 3);
    let system = System::from_matrices(m.as_ref(), c.as_ref(), k.as_ref()).expect("a system");
    let modes = system.modes().expect("modes");
    for (mode, truth) in modes.iter().zip(between_walls(3).1) {
        assert_shape(mode, &truth, "C = K²/64");
    }
}

#[test]
fn an_undamped_mode_of_a_damped_system_is_real() {
    let name = |i: usize| format!("m{i}");
    let masses = (1..4).fold(System::builder(), |b, i| b.mass(name(i), 1.0));
    let system = masses
        .spring(GROUND, "m1", 1.0)
        .spring("m1", "m2", 1.0)
        .spring("m2", "m3", 1.0)
        .spring("m3", GROUND, 1.0)
        .damper(GROUND, "m2", 0.3)
        .build()
        .expect("a chain is a system");
    let modes = system.modes().expect("modes");
    let still = modes.iter().find(|mode| mode.damping_ratio() == Some(0.0));
    assert_shape(still.expect("one"), &between_walls(3).1[1], "undamped");
}

#[test]
fn left_shapes_have_bounds_of_their_own() {
    // K − 7 annuls (1, 2) from the right and (2, 1) from the left, K − 3 the same with one sign changed.
    let k = mat![[5.0, 1.0], [4.0, 5.0]];
    let (m, c) = (Mat::<f64>::identity(2, 2), Mat::<f64>::zeros(2, 2));
    let system = System::from_matrices(m.as_ref(), c.as_ref(), k.as_ref()).expect("a system");
    let modes = system.modes().expect("modes");
    for (mode, sign) in modes.iter().zip([-1.0, 1.0]) {
        let real = |shape: &[num_complex::Complex<f64>]| -> Vec<f64> {
            shape.iter().map(|x| x.re).collect()
        };
        assert_eq!(real(mode.shape()), [0.5 * sign, 1.0]);
        assert_eq!(
            real(mode.left_shape().expect("a left shape")),
            [1.0, 0.5 * sign]
        );
        let small = |bounds: Option<&[f64]>| bounds.is_some_and(|b| b.iter().all(|b| *b <= 1e-28));
        assert!(small(mode.shape_bound()) && small(mode.left_shape_bound()));
    }
}

#[test]
fn what_floats_moves_as_a_whole() {
    let system = network(&[1.0, 3e9], &[(1, 2, 0.1)], &[]);
    let modes = system.modes().expect("modes");
    assert_eq!(
        modes.as_slice()[0].shape_bound(),
        Some([0.0, 0.0].as_slice())
    );
}

#[test]
fn no_bounds_where_shapes_are_not_determined() {
    let alike = |coupling: f64| {
        let held = [(0, 1, 2.0), (0, 2, 2.0), (0, 3, 2.0)];
        let joined = [(1, 2, coupling), (2, 3, coupling), (1, 3, coupling)];
        let system = network(&[1.0; 3], &[held, joined].concat(), &[]);
        system.modes().expect("modes")
    };
    let known = |modes: &eigentone_modes::Modes| -> Vec<bool> {
        modes
            .iter()
            .map(|mode| mode.shape_bound().is_some())
            .collect()
    };
    // (1, 1, 1) stands out; the others span a plane.
    assert_eq!(known(&alike(1.0)), [true, false, false]);
    // Three parts that nothing joins, with one frequency.
    assert_eq!(known(&alike(0.0)), [false; 3]);
    let doubles = between_walls(3).0;
    let system = network(&[1.0; 3], &doubles, &[]);
    let estimated = system.modes_to(Precision::Double).expect("modes");
    assert_eq!(known(&estimated), [false; 3]);
}

#[test]
fn parts_that_nothing_joins_keep_their_shapes_apart() {
    let system = network(&[1.0; 2], &[(0, 1, 2.0), (0, 2, 3.0)], &[]);
    let modes = system.modes().expect("modes");
    for (mode, place) in modes.iter().zip(0..) {
        assert_eq!(mode.shape()[place].re, 1.0);
        assert_eq!(mode.shape_bound(), Some([0.0, 0.0].as_slice()));
    }
}

/// The plan tells of the part that takes most, wherever it is listed.
#[test]
fn the_plan_of_parts_is_that_of_the_largest() {
    let alone = |builder: SystemBuilder| builder.mass("x", 1.0).spring(GROUND, "x", 2.0);
    let chain = |builder: SystemBuilder| {
        (0..20).fold(builder, |builder, i| {
            let name = format!("m{i}");
            let from = match i {
                0 => GROUND.to_owned(),
                i => format!("m{}", i - 1),
            };
            let builder = builder.mass(&name, 1.0 + 0.1 * (i % 3) as f64);
            let builder = builder.spring(&from, &name, 3.0 + (i % 4) as f64);
            builder.damper(from, name, 0.01 * (1.0 + (i % 5) as f64))
        })
    };
    let plan = |builder: SystemBuilder| {
        let system = builder.build().expect("a system");
        let modes = system.modes_to(Precision::Double).expect("modes");
        (modes.plan().solver, modes.plan().reason.clone())
    };
    let (largest, _) = plan(chain(System::builder()));
    assert_ne!(largest, plan(alone(System::builder())).0);
    for both in [
        alone(chain(System::builder())),
        chain(alone(System::builder())),
    ] {
        let (solver, reason) = plan(both);
        assert_eq!(solver, largest);
        assert!(
            reason.ends_with("2 parts that nothing joins are solved apart: this is the largest")
        );
    }
}

#[test]
fn critically_damped_shapes_are_determined_all_the_same() {
    // (λ² + 2λ + 1) twice over, joined so that each double root has one shape: (1, 1) and (1, −1).
    let k = mat![[5.0, -4.0], [-4.0, 5.0]];
    let c = mat![[4.0, -2.0], [-2.0, 4.0]];
    let m = Mat::<f64>::identity(2, 2);
    let system = System::from_matrices(m.as_ref(), c.as_ref(), k.as_ref()).expect("a system");
    let modes = system.modes().expect("modes");
    assert_eq!(modes.as_slice().len(), 2);
    for (mode, sign) in modes.iter().zip([1.0, -1.0]) {
        assert_eq!(mode.is_defective(), Some(true));
        assert_eq!(mode.shape()[1].re, sign);
        assert!(
            mode.shape_bound()
                .is_some_and(|b| b.iter().all(|b| *b <= 1e-20))
        );
    }
}
