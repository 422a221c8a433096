//! Laws that the answers keep, whatever the system: none of these tests knows how they are computed.

#[path = "laws/analogies.rs"]
mod analogies;
#[path = "laws/integrators.rs"]
mod integrators;
mod page;
#[path = "laws/response.rs"]
mod response;

use eigentone::gallery::cases;
use eigentone::modes::{Node, solvers};
use eigentone::prelude::*;
use eigentone::response::{Problem, methods};
use faer::{Mat, mat};
use num_complex::Complex;

/// What rounding may add up to in motions of some thousand steps, of the largest motion.
const MOTION: f64 = 1e-12;

/// The plainest systems of the gallery: one proved undamped, one classically damped, one neither.
fn systems() -> Vec<(&'static str, System)> {
    let plain = ["undamped-long", "micro-units", "three-mass-3"];
    let cases = cases().iter().filter(|case| plain.contains(&case.name()));
    let systems: Vec<_> = cases
        .map(|case| (case.name(), case.scene().system().clone()))
        .collect();
    assert_eq!(systems.len(), plain.len());
    systems
}

/// The system with its coordinates in another order and all parameters scaled.
fn rebuilt(system: &System, order: &[usize], mass: f64, damping: f64, stiffness: f64) -> System {
    let name = |node: Node| match node {
        Node::Ground => GROUND.to_owned(),
        Node::Coordinate(i) => system.names()[i].clone(),
    };
    let mut builder = System::builder();
    for &i in order {
        builder = builder.mass(&system.names()[i], mass * system.masses()[i]);
    }
    for spring in system.springs() {
        let coefficient = stiffness * spring.coefficient;
        builder = builder.spring(name(spring.first), name(spring.second), coefficient);
    }
    for damper in system.dampers() {
        let coefficient = damping * damper.coefficient;
        builder = builder.damper(name(damper.first), name(damper.second), coefficient);
    }
    builder.build().expect("it was a system before")
}

/// The eigenvalues of both agree within their bounds, the second ones divided by `factor`.
fn assert_same_roots(name: &str, one: &[Eigenvalue], other: &[Eigenvalue], factor: f64) {
    assert_eq!(one.len(), other.len(), "{name}");
    for (a, b) in one.iter().zip(other) {
        let distance = (a.value - b.value / factor).norm();
        let bound = a.bound.expect("all are simple") + b.bound.expect("all are simple") / factor;
        assert!(distance <= bound, "{name}: {} {}", a.value, b.value);
        assert!(bound <= 1e-12 * a.value.norm(), "{name}: an empty bound");
    }
}

/// |a − b| over all coordinates and instants is within `tolerance` of the largest |a|, where column
/// j of `a` belongs to column `stride`·j of `b`.
fn assert_same_motion(name: &str, a: &Trajectory, b: &Trajectory, stride: usize, tolerance: f64) {
    for (a, b) in [
        (a.displacement(), b.displacement()),
        (a.velocity(), b.velocity()),
    ] {
        let unit = a.norm_max();
        assert!(unit > 0.0, "{name}: nothing moves");
        for j in 0..a.ncols() {
            for i in 0..a.nrows() {
                let off = (a[(i, j)] - b[(i, stride * j)]).abs();
                assert!(
                    off <= tolerance * unit,
                    "{name}: {off:e} of {unit:e} at {j}"
                );
            }
        }
    }
}

/// Runs `check` with every method that takes the problem.
fn by_every_method(problem: &Problem<'_>, check: impl Fn(&dyn ResponseMethod, Trajectory)) {
    let mut answered = 0;
    for method in methods() {
        if method.refuses(problem).is_none() {
            check(*method, method.run(problem).expect("it does not refuse"));
            answered += 1;
        }
    }
    assert!(answered > 0);
}

/// One load of each kind, on the grid of step `h`.
fn loads(h: f64) -> [Load; 6] {
    let samples = |hold| Samples {
        step: 4.0 * h,
        values: vec![1.0, -2.0, 0.5, 3.0, 0.0],
        hold,
    };
    [
        Step::of(2.0).starting_at(6.0 * h).into(),
        Ramp::of(0.25).starting_at(3.0 * h).into(),
        Impulse::of(-3.0).at(10.0 * h).into(),
        Harmonic::of(1.5, 0.7).with_phase(0.3).into(),
        samples(Hold::Zero).into(),
        samples(Hold::First).into(),
    ]
}

fn three_masses() -> System {
    let case = cases().iter().find(|case| case.name() == "three-mass-1");
    case.expect("it is in the gallery").scene().system().clone()
}

#[test]
fn roots_do_not_depend_on_the_order_of_coordinates() {
    for (name, system) in systems() {
        let order: Vec<usize> = (0..system.len()).rev().collect();
        let other = rebuilt(&system, &order, 1.0, 1.0, 1.0);
        for solver in solvers() {
            let refuses = solver.refuses(&system).is_some();
            assert_eq!(refuses, solver.refuses(&other).is_some());
            if !refuses {
                let one = solver.solve(&system).expect(name);
                let other = solver.solve(&other).expect(name);
                assert_same_roots(name, one.eigenvalues(), other.eigenvalues(), 1.0);
            }
        }
    }
}

/// Powers of two scale without rounding, so that both systems are the same to the last bit.
#[test]
fn roots_do_not_depend_on_the_unit_of_mass() {
    const UNIT: f64 = 1.0 / 1024.0;
    for (name, system) in systems() {
        let order: Vec<usize> = (0..system.len()).collect();
        let other = rebuilt(&system, &order, UNIT, UNIT, UNIT);
        let modes = (system.modes().expect(name), other.modes().expect(name));
        assert_same_roots(name, modes.0.eigenvalues(), modes.1.eigenvalues(), 1.0);
    }
}

#[test]
fn roots_are_counted_in_the_unit_of_time() {
    const UNIT: f64 = 4096.0;
    for (name, system) in systems() {
        let order: Vec<usize> = (0..system.len()).collect();
        let other = rebuilt(&system, &order, 1.0, UNIT, UNIT * UNIT);
        let modes = (system.modes().expect(name), other.modes().expect(name));
        assert_same_roots(name, modes.0.eigenvalues(), modes.1.eigenvalues(), UNIT);
    }
}

/// Q(λ)x = 0, but for the backward error that the mode states; in systems of ordinary numbers that is
/// some units of rounding.
#[test]
fn every_shape_solves_its_equation() {
    const ROUNDING: f64 = 8.0 * f64::EPSILON;
    for case in cases() {
        let (name, scene) = (case.name(), case.scene());
        let system = scene.system();
        let n = system.len();
        let matrices = [
            system.mass_matrix(),
            system.damping_matrix(),
            system.stiffness_matrix(),
        ];
        for mode in &system.modes().expect(name) {
            let lambda = mode.eigenvalue().value;
            let powers = [lambda * lambda, lambda, Complex::ONE];
            let shape = mode.shape();
            let largest = shape.iter().map(|x| x.norm()).fold(0.0, f64::max);
            // Components within 1e-12 of each other tie, and the first of them is made 1.
            assert!(shape.contains(&Complex::ONE) && largest <= 1.0 + 2e-12);
            let parts = || matrices.iter().zip(powers);
            let size: f64 = parts()
                .map(|(matrix, power)| power.norm() * matrix.norm_l2())
                .sum();
            let residual = (0..n).map(|i| {
                let row = parts().flat_map(|(matrix, power)| {
                    (0..n).map(move |j| power * matrix[(i, j)] * shape[j])
                });
                row.sum::<Complex<f64>>().norm_sqr()
            });
            let length: f64 = shape.iter().map(|x| x.norm_sqr()).sum();
            let error = (residual.sum::<f64>() / length).sqrt() / size;
            let stated = mode.backward_error();
            assert!(
                error <= stated + ROUNDING,
                "{name}: {error:e}, not {stated:e}"
            );
            if ["one-", "two-", "three-"]
                .iter()
                .any(|plain| name.starts_with(plain))
            {
                assert!(stated <= ROUNDING, "{name}: {stated:e}");
            }
        }
    }
}

#[test]
fn loads_superpose() {
    let system = three_masses();
    let h = 0.125;
    let ask = |pick: &dyn Fn(usize) -> bool| {
        let start = Response::of(&system).every(h).until(50.0);
        let all = loads(h).into_iter().enumerate();
        let picked = all.filter(|(index, _)| pick(*index));
        let names = system.names();
        let asked = picked.fold(start, |asked, (index, load)| {
            asked.load(&names[index % names.len()], load)
        });
        asked.problem().expect("it is well posed")
    };
    by_every_method(&ask(&|_| true), |method, together| {
        let name = method.name();
        let mut sums = (Mat::zeros(3, together.len()), Mat::zeros(3, together.len()));
        for index in 0..loads(h).len() {
            let alone = method.run(&ask(&|other| other == index)).expect(name);
            assert!(alone.displacement().norm_max() > 0.0);
            sums.0 += alone.displacement();
            sums.1 += alone.velocity();
        }
        let (steps, times) = (together.steps().to_vec(), together.times().to_vec());
        let sum = Trajectory::new("sum", steps, times, sums.0, sums.1);
        assert_same_motion(name, &together, &sum, 1, MOTION);
    });
}

/// Two steps of h are one step of 2h, also where loads change between coarse instants.
#[test]
fn motion_does_not_depend_on_the_grid() {
    let system = three_masses();
    let h = 0.125;
    let ask = |step: f64| {
        let start = State::at_rest().displace("m1", 1.0).push("m3", -2.0);
        let asked = Response::of(&system).from(start).every(step).until(50.0);
        let names = system.names();
        let each = loads(h).into_iter().enumerate();
        let asked = each.fold(asked, |asked, (index, load)| {
            asked.load(&names[index % names.len()], load)
        });
        asked.problem().expect("it is well posed")
    };
    for stride in [2, 4, 8] {
        let fine = ask(h);
        let coarse = ask(h * stride as f64);
        for method in methods() {
            assert!(method.refuses(&fine).is_none());
            let name = method.name();
            let (fine, coarse) = (method.run(&fine), method.run(&coarse));
            let (fine, coarse) = (fine.expect(name), coarse.expect(name));
            assert_same_motion(name, &coarse, &fine, stride, MOTION);
        }
    }
}

/// What starts from where it was goes on as it would have.
#[test]
fn motion_can_be_taken_up_again() {
    let system = three_masses();
    let whole = Response::of(&system).from(State::at_rest().displace("m2", 1.0));
    let whole = whole.every(0.25).until(50.0).problem().expect("well posed");
    by_every_method(&whole, |method, whole| {
        let name = method.name();
        let middle = 80;
        let mut state = State::at_rest();
        for (i, coordinate) in system.names().iter().enumerate() {
            state = state
                .displace(coordinate, whole.displacement()[(i, middle)])
                .push(coordinate, whole.velocity()[(i, middle)]);
        }
        let rest = Response::of(&system).from(state).every(0.25).until(30.0);
        let rest = rest.run_by(method).expect(name);
        let columns = |m: faer::MatRef<'_, f64>| m.subcols(middle, rest.len()).to_owned();
        let (steps, times) = (rest.steps().to_vec(), rest.times().to_vec());
        let moved = (columns(whole.displacement()), columns(whole.velocity()));
        let moved = Trajectory::new("rest", steps, times, moved.0, moved.1);
        assert_same_motion(name, &moved, &rest, 1, MOTION);
    });
}

/// ½ vᵀMv + ½ xᵀKx at each instant, from masses and springs.
fn energy(system: &System, motion: &Trajectory) -> Vec<f64> {
    let at = |j: usize| {
        let (x, v) = (motion.displacement(), motion.velocity());
        let place = |node: Node| node.coordinate().map_or(0.0, |i| x[(i, j)]);
        let moving = system.masses().iter().enumerate();
        let kinetic: f64 = moving.map(|(i, mass)| mass * v[(i, j)].powi(2)).sum();
        let stretched = system.springs().iter().map(|spring| {
            let stretch = place(spring.first) - place(spring.second);
            spring.coefficient * stretch.powi(2)
        });
        (kinetic + stretched.sum::<f64>()) / 2.0
    };
    (0..motion.len()).map(at).collect()
}

fn chain(masses: usize, damping: f64) -> System {
    let mut builder = System::builder();
    for i in 0..masses {
        builder = builder.mass(format!("m{i}"), 1.0 + (i % 3) as f64);
    }
    let name = |i: usize| match i {
        0 => GROUND.to_owned(),
        i => format!("m{}", i - 1),
    };
    for i in 0..masses {
        builder = builder.spring(name(i), name(i + 1), 100.0 / (1.0 + (i % 4) as f64));
    }
    if damping > 0.0 {
        builder = builder.damper(name(1), name(masses), damping);
    }
    builder.build().expect("a chain is a system")
}

#[test]
fn undamped_motion_keeps_its_energy() {
    let system = chain(20, 0.0);
    let start = State::at_rest().displace("m19", 0.1).push("m0", 2.0);
    let asked = Response::of(&system).from(start).every(0.05).until(500.0);
    by_every_method(&asked.problem().expect("well posed"), |method, motion| {
        let name = method.name();
        let energy = energy(&system, &motion);
        for now in &energy {
            assert!((now / energy[0] - 1.0).abs() <= 1e-11, "{name}: {now}");
        }
    });
}

#[test]
fn dampers_only_take_energy() {
    let system = chain(20, 1.0);
    let start = State::at_rest().displace("m19", 0.1).push("m0", 2.0);
    let asked = Response::of(&system).from(start).every(0.05).until(500.0);
    by_every_method(&asked.problem().expect("well posed"), |method, motion| {
        let name = method.name();
        let energy = energy(&system, &motion);
        for pair in energy.windows(2) {
            let rounding = 1e-13 * energy[0];
            assert!(pair[1] <= pair[0] + rounding, "{name}: {pair:?}");
        }
        let last = energy.last().expect("there are instants");
        assert!(*last < 0.9 * energy[0], "{name}: nothing was taken");
    });
}

/// Integers with inverse integers, so that what is planted by them is planted exactly.
fn unimodular() -> (Mat<f64>, Mat<f64>) {
    let p = mat![
        [1.0, 2.0, 0.0, -1.0],
        [0.0, 1.0, 3.0, 1.0],
        [1.0, 2.0, 1.0, 0.0],
        [0.0, -1.0, -3.0, 0.0],
    ];
    let inverse = mat![
        [-5.0, -5.0, 6.0, -3.0],
        [3.0, 3.0, -3.0, 2.0],
        [-1.0, -1.0, 1.0, -1.0],
        [0.0, 1.0, 0.0, 1.0],
    ];
    assert_eq!(&p * &inverse, Mat::<f64>::identity(4, 4));
    (p, inverse)
}

/// Every planted root is found, each once, within its bound, and the bound says something.
fn assert_found(modes: &Modes, planted: &[Complex<f64>]) {
    let mut left = modes.eigenvalues().to_vec();
    assert_eq!(left.len(), planted.len());
    for root in planted {
        let off = |found: &Eigenvalue| (found.value - root).norm();
        let nearest = (0..left.len()).min_by(|&a, &b| off(&left[a]).total_cmp(&off(&left[b])));
        let found = left.swap_remove(nearest.expect("as many are left as are planted"));
        let bound = found.bound.expect("a bound");
        assert!(off(&found) <= bound, "{root}: {} ± {bound:e}", found.value);
        assert!(
            off(&found) <= 1e-12 * root.norm(),
            "{root}: {}",
            found.value
        );
        assert!(bound <= 1e-9 * root.norm(), "{root}: ± {bound:e}");
    }
}

fn diagonal(values: [f64; 4]) -> Mat<f64> {
    Mat::from_fn(4, 4, |i, j| if i == j { values[i] } else { 0.0 })
}

/// M = PᵀP, C = Pᵀ diag(c) P, K = Pᵀ diag(k) P with λ² + cλ + k = 0: the columns of P⁻¹ are the
/// shapes.
#[test]
fn planted_classical_modes_are_found() {
    let (p, inverse) = unimodular();
    let matrix = |values| p.transpose() * diagonal(values) * &p;
    // −1 ± 2i, −3 ± 4i, −1 and −7, ±10i.
    let (c, k) = ([2.0, 6.0, 8.0, 0.0], [5.0, 25.0, 7.0, 100.0]);
    let (m, c, k) = (matrix([1.0; 4]), matrix(c), matrix(k));
    let system = System::from_matrices(m.as_ref(), c.as_ref(), k.as_ref()).expect("regular");
    assert!(system.structure().is_classical());
    let columns = [
        (Complex::new(-1.0, 2.0), 0),
        (Complex::new(-3.0, 4.0), 1),
        (Complex::new(-1.0, 0.0), 2),
        (Complex::new(-7.0, 0.0), 2),
        (Complex::new(0.0, 10.0), 3),
    ];
    let conjugates = columns.iter().map(|(root, _)| root.conj());
    let mut planted: Vec<_> = columns.iter().map(|(root, _)| *root).collect();
    planted.extend(conjugates.filter(|root| root.im != 0.0));
    for solver in solvers() {
        if solver.refuses(&system).is_some() {
            continue;
        }
        let modes = solver.solve(&system).expect("it takes it");
        assert_found(&modes, &planted);
        for (root, column) in columns {
            let mode = modes
                .iter()
                .find(|mode| (mode.eigenvalue().value - root).norm() < 1e-9)
                .expect("a mode for each pair or real root");
            let largest = (0..4).map(|i| inverse[(i, column)]);
            let largest = largest.fold(0.0f64, |a, b| if b.abs() > a.abs() { b } else { a });
            for (i, x) in mode.shape().iter().enumerate() {
                let off = (x - inverse[(i, column)] / largest).norm();
                assert!(off <= 1e-12, "{}, {root}: {off:e}", solver.name());
            }
        }
    }
}

/// (λ − S)(λ − T) = λ² − (S + T)λ + ST, for integer S and T with chosen roots.
fn factored(s: &Mat<f64>, t: &Mat<f64>) -> System {
    let damping = -(s + t);
    let stiffness = s * t;
    let mass = Mat::<f64>::identity(4, 4);
    System::from_matrices(mass.as_ref(), damping.as_ref(), stiffness.as_ref()).expect("regular")
}

#[test]
fn planted_roots_without_any_symmetry_are_found() {
    let (p, inverse) = unimodular();
    // −1 ± 5i and −2 ± i; −3, −4, 2 and 6 ± 0i are real: two of them grow.
    let pairs = mat![
        [-1.0, 5.0, 0.0, 0.0],
        [-5.0, -1.0, 0.0, 0.0],
        [0.0, 0.0, -2.0, 1.0],
        [0.0, 0.0, -1.0, -2.0],
    ];
    let s = &p * pairs * &inverse;
    let t = diagonal([-3.0, -4.0, 2.0, 6.0]);
    let system = factored(&s, &t);
    let structure = system.structure();
    assert!(!structure.is_symmetric() && !structure.is_passive());
    let modes = system.modes().expect("it has a state matrix");
    let planted = [
        (-1.0, 5.0),
        (-1.0, -5.0),
        (-2.0, 1.0),
        (-2.0, -1.0),
        (-3.0, 0.0),
        (-4.0, 0.0),
        (2.0, 0.0),
        (6.0, 0.0),
    ];
    assert_found(&modes, &planted.map(|(re, im)| Complex::new(re, im)));
    let growing = modes.iter().filter(|mode| mode.motion() == Motion::Growing);
    assert_eq!(growing.count(), 2);
}

/// −2 with one shape for two roots, and −5 with two shapes for two.
#[test]
fn planted_repeats_are_separated() {
    let jordan = mat![
        [-2.0, 1.0, 0.0, 0.0],
        [0.0, -2.0, 0.0, 0.0],
        [0.0, 0.0, -5.0, 0.0],
        [0.0, 0.0, 0.0, -5.0],
    ];
    let system = factored(&diagonal([-11.0, -13.0, -17.0, -19.0]), &jordan);
    let modes = system.modes().expect("it has a state matrix");
    let at = |root: f64| {
        let near = modes.iter().filter(move |mode| {
            let value = mode.eigenvalue().value;
            (value - root).norm() < 1e-5 * root.abs()
        });
        near.collect::<Vec<_>>()
    };
    let [critical] = at(-2.0)[..] else {
        panic!("one mode at −2, not {:?}", at(-2.0));
    };
    assert!(critical.is_defective() == Some(true) && critical.multiplicity() == Some(2));
    let off = critical.eigenvalue().value + 2.0;
    assert!(off.norm() <= 1e-13, "{off}");
    let [one, other] = at(-5.0)[..] else {
        panic!("two modes at −5, not {:?}", at(-5.0));
    };
    for mode in [one, other] {
        assert!(mode.is_defective() == Some(false) && mode.multiplicity() == Some(2));
        let off = mode.eigenvalue().value + 5.0;
        assert!(off.norm() <= 1e-13, "{off}");
    }
    let shapes = (one.shape(), other.shape());
    let product: Complex<f64> = shapes
        .0
        .iter()
        .zip(shapes.1)
        .map(|(a, b)| a.conj() * b)
        .sum();
    let norm = |shape: &[Complex<f64>]| shape.iter().map(|x| x.norm_sqr()).sum::<f64>().sqrt();
    let parallel = product.norm() / (norm(shapes.0) * norm(shapes.1));
    assert!(parallel < 0.999, "the same shape twice");
    assert_eq!(modes.eigenvalues().len(), 8);
}
