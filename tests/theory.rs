//! Evaluates every numbered formula of docs/theory.md, (1) to (38), on systems small enough to see
//! through, against the answers of the library. `tests/docs.rs` checks that none is left out.

mod page;
#[path = "theory/published.rs"]
mod published;

use std::f64::consts::PI;

use eigentone::modes::{
    ClassicalModes, Element, FirstOrder, MatrixKind, Node, Parameter, Sensitivity, SensitivityError,
};
use eigentone::prelude::*;
use eigentone::response::{SteadyState, expm, receptance};
use faer::linalg::solvers::{DenseSolveCore, Solve};
use faer::{Mat, mat};
use num_complex::Complex;

type C64 = Complex<f64>;

const I: C64 = Complex::new(0.0, 1.0);

/// Three masses between walls, with damping that is not classical.
fn three() -> System {
    System::builder()
        .mass("m1", 6.0)
        .mass("m2", 9.0)
        .mass("m3", 5.0)
        .spring(GROUND, "m1", 6.0)
        .spring("m1", "m2", 7.0)
        .spring("m2", "m3", 4.0)
        .spring("m3", GROUND, 1.0)
        .damper(GROUND, "m1", 1.0)
        .damper("m1", "m2", 0.2)
        .damper("m3", GROUND, 2.0)
        .build()
        .expect("a system")
}

/// Two masses with C = αM + βK.
fn rayleigh(alpha: f64, beta: f64) -> System {
    let system = System::builder()
        .mass("m1", 2.0)
        .mass("m2", 1.0)
        .spring(GROUND, "m1", 3.0)
        .spring("m1", "m2", 4.0);
    system
        .damper(GROUND, "m1", 3.0 * beta)
        .damper(GROUND, "m1", 2.0 * alpha)
        .damper(GROUND, "m2", alpha)
        .damper("m1", "m2", 4.0 * beta)
        .build()
        .expect("a system")
}

fn oscillator(m: f64, c: f64, k: f64) -> System {
    System::builder()
        .mass("m", m)
        .spring(GROUND, "m", k)
        .damper(GROUND, "m", c)
        .build()
        .expect("a system")
}

fn assert_near(found: f64, expected: f64, relative: f64) {
    let off = (found - expected).abs();
    assert!(off <= relative * expected.abs(), "{found} for {expected}");
}

fn times(matrix: &Mat<f64>, x: &[C64]) -> Vec<C64> {
    let row = |i| (0..matrix.ncols()).map(|j| x[j] * matrix[(i, j)]).sum();
    (0..matrix.nrows()).map(row).collect()
}

/// y* x.
fn dot(y: &[C64], x: &[C64]) -> C64 {
    y.iter().zip(x).map(|(y, x)| y.conj() * x).sum()
}

fn norm(x: &[C64]) -> f64 {
    dot(x, x).re.sqrt()
}

/// M, C and K.
fn matrices(system: &System) -> [Mat<f64>; 3] {
    [
        system.mass_matrix(),
        system.damping_matrix(),
        system.stiffness_matrix(),
    ]
}

/// Q(λ)x.
fn q_times(system: &System, lambda: C64, x: &[C64]) -> Vec<C64> {
    let [m, c, k] = matrices(system).map(|matrix| times(&matrix, x));
    (0..x.len())
        .map(|i| lambda * lambda * m[i] + lambda * c[i] + k[i])
        .collect()
}

fn q(system: &System, z: C64) -> Mat<C64> {
    let [m, c, k] = matrices(system);
    Mat::from_fn(system.len(), system.len(), |i, j| {
        z * z * m[(i, j)] + z * c[(i, j)] + k[(i, j)]
    })
}

/// The block matrix [blocks].
fn blocks(rows: &[&[&Mat<f64>]]) -> Mat<f64> {
    let height: usize = rows.iter().map(|row| row[0].nrows()).sum();
    let width: usize = rows[0].iter().map(|block| block.ncols()).sum();
    let mut whole = Mat::zeros(height, width);
    let mut top = 0;
    for row in rows {
        let mut left = 0;
        for block in *row {
            for j in 0..block.ncols() {
                for i in 0..block.nrows() {
                    whole[(top + i, left + j)] = block[(i, j)];
                }
            }
            left += block.ncols();
        }
        top += row[0].nrows();
    }
    whole
}

fn zeros(rows: usize, columns: usize) -> Mat<f64> {
    Mat::zeros(rows, columns)
}

fn identity(n: usize) -> Mat<f64> {
    Mat::identity(n, n)
}

/// A and B of (8), from M, C and K.
fn state_matrix(system: &System) -> (Mat<f64>, Mat<f64>) {
    let [m, c, k] = matrices(system);
    let n = system.len();
    let inverse = m.partial_piv_lu().inverse();
    let a = blocks(&[
        &[&zeros(n, n), &identity(n)],
        &[&-(&inverse * k), &-(&inverse * c)],
    ]);
    (a, blocks(&[&[&zeros(n, n)], &[&inverse]]))
}

fn scaled(matrix: &Mat<f64>, factor: f64) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        factor * matrix[(i, j)]
    })
}

fn assert_close(found: &Mat<f64>, expected: &Mat<f64>, absolute: f64) {
    assert_eq!(found.shape(), expected.shape());
    assert!(
        (found - expected).norm_max() <= absolute,
        "{found:?} for {expected:?}"
    );
}

/// Displacements, then velocities, at the last instant.
fn final_state(trajectory: &Trajectory) -> Mat<f64> {
    let (x, v) = (trajectory.displacement(), trajectory.velocity());
    let (n, last) = (x.nrows(), x.ncols() - 1);
    Mat::from_fn(2 * n, 1, |i, _| {
        if i < n {
            x[(i, last)]
        } else {
            v[(i - n, last)]
        }
    })
}

const H: f64 = 0.75;

/// The three masses, moving.
fn start() -> (State, Mat<f64>) {
    let state = State::at_rest()
        .displace("m1", 1.0)
        .displace("m2", -0.5)
        .push("m3", 2.0);
    (state, mat![[1.0], [-0.5], [0.0], [0.0], [0.0], [2.0]])
}

#[test]
fn the_equation_of_motion() {
    // (1): the accelerations of the answer balance the forces.
    let system = three();
    let asked = Response::of(&system)
        .from(start().0)
        .load("m2", Step::of(3.0));
    let answer = asked
        .every(H)
        .until(4.0 * H)
        .with_acceleration()
        .run()
        .expect("a motion");
    let [m, c, k] = matrices(&system);
    let acceleration = answer.acceleration().expect("they were asked for");
    let sum = m * acceleration + c * answer.velocity() + k * answer.displacement();
    let force = Mat::from_fn(3, answer.len(), |i, _| if i == 1 { 3.0 } else { 0.0 });
    assert_close(&sum, &force, 1e-13);

    // (2)
    let outer = |elements: &[Element]| {
        let mut sum = zeros(3, 3);
        for element in elements {
            let [a, b] = [element.first, element.second].map(Node::coordinate);
            let mut g = [0.0; 3];
            a.into_iter().for_each(|a| g[a] += 1.0);
            b.into_iter().for_each(|b| g[b] -= 1.0);
            sum += Mat::from_fn(3, 3, |i, j| element.coefficient * g[i] * g[j]);
        }
        sum
    };
    assert_eq!(outer(system.springs()), system.stiffness_matrix());
    assert_eq!(outer(system.dampers()), system.damping_matrix());
    let masses = Mat::from_fn(3, 3, |i, j| if i == j { system.masses()[i] } else { 0.0 });
    assert_eq!(masses, system.mass_matrix());
}

#[test]
fn the_quadratic_eigenproblem() {
    let system = three();
    let modes = system.modes().expect("modes");
    assert_eq!(modes.eigenvalues().len(), 6);
    for mode in &modes {
        let lambda = mode.eigenvalue().value;
        // (3), (4)
        assert!(norm(&q_times(&system, lambda, mode.shape())) < 1e-13);
        assert!(q(&system, lambda).determinant().norm() < 1e-11);
        // (5)
        assert_near(
            mode.natural_frequency().radians_per_second(),
            lambda.norm(),
            1e-15,
        );
        assert_eq!(
            mode.damped_frequency().radians_per_second(),
            lambda.im.abs()
        );
        let zeta = mode.damping_ratio().expect("it oscillates");
        assert_near(zeta, -lambda.re / lambda.norm(), 1e-15);
        assert_near(
            mode.time_constant().expect("it decays"),
            -1.0 / lambda.re,
            1e-15,
        );
    }
}

#[test]
fn one_mass() {
    // (6)
    let (m, k) = (0.5, 32.0);
    let omega = f64::sqrt(k / m);
    for zeta in [0.125, 1.0, 2.0, 1e8] {
        let system = oscillator(m, 2.0 * zeta * f64::sqrt(k * m), k);
        let modes = system.modes().expect("modes");
        let root = (C64::from(zeta * zeta) - 1.0).sqrt() * omega;
        let fast = -zeta * omega - root;
        let slow = (k / m) / fast;
        for eigenvalue in modes.eigenvalues() {
            let off = (eigenvalue.value - fast)
                .norm()
                .min((eigenvalue.value - slow).norm());
            assert!(off <= 1e-15 * eigenvalue.value.norm());
        }
        assert_eq!(
            modes.iter().any(|mode| mode.is_defective() == Some(true)),
            zeta == 1.0
        );
    }
}

#[test]
fn roots_at_zero_and_at_infinity() {
    // (7): nothing holds the pair, and the damper does not either: 1 + 1. On the ground by a damper: 1 + 0.
    let pair = || {
        System::builder()
            .mass("a", 1.0)
            .mass("b", 2.0)
            .spring("a", "b", 3.0)
    };
    for (builder, zeros) in [
        (pair().damper("a", "b", 1.0), 2),
        (pair().damper(GROUND, "a", 1.0), 1),
    ] {
        let system = builder.build().expect("a system");
        assert_eq!(system.structure().zero_roots(), Some(zeros));
        let modes = system.modes().expect("modes");
        let found = modes
            .eigenvalues()
            .iter()
            .filter(|root| root.value == C64::ZERO);
        assert_eq!(found.count(), zeros);
    }
    // A massless node: two roots less, or one with a damper.
    let node = || {
        System::builder()
            .mass("a", 1.0)
            .mass("b", 0.0)
            .spring("a", "b", 3.0)
    };
    for (builder, infinite) in [
        (node().spring(GROUND, "b", 1.0), 2),
        (node().damper(GROUND, "b", 1.0), 1),
    ] {
        let modes = builder.build().expect("a system").modes().expect("modes");
        assert_eq!(
            (modes.infinite(), modes.eigenvalues().len()),
            (infinite, 4 - infinite)
        );
    }
}

#[test]
fn the_state_matrix() {
    // (8)
    let system = three();
    let (a, b) = state_matrix(&system);
    let form = FirstOrder::of(&system).expect("M is regular");
    assert_close(&form.a().to_owned(), &a, 1e-15);
    assert_close(&form.b().to_owned(), &b, 1e-15);
    // (9)
    for mode in &system.modes().expect("modes") {
        let lambda = mode.eigenvalue().value;
        let both: Vec<C64> = mode
            .shape()
            .iter()
            .copied()
            .chain(mode.shape().iter().map(|x| lambda * x))
            .collect();
        let off: Vec<C64> = times(&a, &both)
            .iter()
            .zip(&both)
            .map(|(ax, x)| ax - lambda * x)
            .collect();
        assert!(norm(&off) < 1e-14);
    }
}

#[test]
fn normal_modes() {
    // (10), (11) and (16), with C = αM + βK.
    let (alpha, beta) = (0.125, 0.0625);
    let system = rayleigh(alpha, beta);
    let modal = ClassicalModes::of(&system)
        .expect("modes")
        .expect("C is classical");
    let shapes = modal.shapes();
    let [m, c, k] = matrices(&system);
    for (matrix, diagonal) in [
        (&m, modal.mass()),
        (&c, modal.damping()),
        (&k, modal.stiffness()),
    ] {
        let product = shapes.transpose() * matrix * shapes;
        let expected = Mat::from_fn(2, 2, |i, j| if i == j { diagonal[i] } else { 0.0 });
        assert_close(&product, &expected, 1e-14);
    }
    let modes = system.modes().expect("modes");
    for (j, mode) in modes.iter().enumerate() {
        let omega = f64::sqrt(modal.stiffness()[j] / modal.mass()[j]);
        assert_near(mode.natural_frequency().radians_per_second(), omega, 1e-14);
        let zeta = mode.damping_ratio().expect("it oscillates");
        assert_near(
            zeta,
            modal.damping()[j] / (2.0 * omega * modal.mass()[j]),
            1e-14,
        );
        assert_near(zeta, alpha / (2.0 * omega) + beta * omega / 2.0, 1e-14);
    }
    // (15)
    let inverse = m.partial_piv_lu().inverse();
    assert_close(&(&c * &inverse * &k), &(&k * &inverse * &c), 1e-14);
    assert!(system.structure().is_classical() && !three().structure().is_classical());
}

#[test]
fn almost_classical() {
    // The example at (16).
    let e = 2f64.powi(-50);
    let system = System::from_matrices(
        identity(2).as_ref(),
        mat![[0.1, 0.0], [0.0, 0.2]].as_ref(),
        mat![[1.0 + e, -e], [-e, 1.0 + e]].as_ref(),
    );
    let modes = system.expect("a system").modes().expect("modes");
    let mut rates: Vec<f64> = modes.iter().map(|mode| mode.decay_rate()).collect();
    rates.sort_by(f64::total_cmp);
    assert_near(rates[0], 0.05, 1e-12);
    assert_near(rates[1], 0.10, 1e-12);
}

#[test]
fn a_chain_between_walls() {
    // (12)
    let (n, m, k) = (7, 0.5, 40.0);
    let name = |i: usize| {
        if i == 0 || i > n {
            GROUND.to_owned()
        } else {
            format!("m{i}")
        }
    };
    let masses = (1..=n).fold(System::builder(), |builder, i| builder.mass(name(i), m));
    let chain = (0..=n).fold(masses, |builder, i| builder.spring(name(i), name(i + 1), k));
    let modes = chain.build().expect("a system").modes().expect("modes");
    for (j, mode) in (1..).zip(&modes) {
        let angle = f64::from(j) * PI / (2.0 * (n as f64 + 1.0));
        let omega = 2.0 * f64::sqrt(k / m) * angle.sin();
        assert_near(mode.natural_frequency().radians_per_second(), omega, 4e-16);
    }
}

#[test]
fn frequencies_from_the_springs() {
    let (masses, springs) = ([2.0f64, 1.0, 3.0], [1.0f64, 1e20, 5.0]);
    let system = System::builder()
        .mass("a", masses[0])
        .mass("b", masses[1])
        .mass("c", masses[2])
        .spring(GROUND, "a", springs[0])
        .spring("a", "b", springs[1])
        .spring("b", "c", springs[2])
        .build()
        .expect("a system");
    // (13): D^(1/2) G M^(-1/2); FᵀF is K between M^(-1/2), where K can be determined at all.
    let g = mat![[1.0, 0.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, -1.0]];
    let f = Mat::from_fn(3, 3, |s, i| {
        springs[s].sqrt() * g[(s, i)] / masses[i].sqrt()
    });
    let product = f.transpose() * &f;
    let k = system.stiffness_matrix();
    for j in 0..3 {
        for i in 0..3 {
            let expected = k[(i, j)] / (masses[i] * masses[j]).sqrt();
            assert!((product[(i, j)] - expected).abs() <= 1e-15 * expected.abs());
        }
    }
    // Their product is det F, although K has lost the 1: its rows of the stiff spring are ± the same.
    assert_eq!(k[(0, 0)], -k[(0, 1)]);
    let modes = system.modes().expect("modes");
    let found: f64 = modes
        .iter()
        .map(|mode| mode.natural_frequency().radians_per_second())
        .product();
    let determinant = (springs.iter().product::<f64>() / masses.iter().product::<f64>()).sqrt();
    assert_near(found, determinant, 1e-15);
    // (14)
    for mode in &modes {
        let omega = mode.natural_frequency().radians_per_second();
        let sensitivity = Sensitivity::of(&system, mode).expect("it is simple");
        let relative = |parameter: Parameter, value: f64| {
            let slope = sensitivity
                .to(parameter)
                .expect("it is there")
                .natural_frequency();
            slope.expect("it oscillates") * value / omega
        };
        let by_springs: Vec<f64> = (0..3)
            .map(|s| relative(Parameter::Spring(s), springs[s]))
            .collect();
        let by_masses: Vec<f64> = (0..3)
            .map(|i| relative(Parameter::Mass(i), masses[i]))
            .collect();
        assert!(by_springs.iter().all(|part| *part >= 0.0));
        assert_near(by_springs.iter().sum(), 0.5, 1e-14);
        assert_near(by_masses.iter().sum(), -0.5, 1e-14);
    }
}

#[test]
fn passive_systems() {
    // (17)
    let system = three();
    let [m, c, k] = matrices(&system);
    for mode in &system.modes().expect("modes") {
        let x = mode.shape();
        let form = |matrix: &Mat<f64>| dot(x, &times(matrix, x)).re;
        let lambda = mode.eigenvalue().value;
        assert_near(lambda.re, -form(&c) / (2.0 * form(&m)), 1e-14);
        assert_near(lambda.norm_sqr(), form(&k) / form(&m), 1e-14);
    }
}

#[test]
fn sensitivities_and_quality() {
    let system = three();
    let [m, c, k] = matrices(&system);
    for mode in &system.modes().expect("modes") {
        let lambda = mode.eigenvalue().value;
        let (x, y) = (mode.shape(), mode.left_shape().expect("it is simple"));
        let mx: Vec<C64> = times(&m, x)
            .iter()
            .zip(times(&c, x))
            .map(|(m, c)| 2.0 * lambda * m + c)
            .collect();
        let slope = dot(y, &mx);
        // (18), for the spring between m1 and m2, the damper at m3 and the mass m2.
        let sensitivity = Sensitivity::of(&system, mode).expect("it is simple");
        let found = |parameter| Ok::<_, SensitivityError>(sensitivity.to(parameter)?.eigenvalue());
        let stretch = (y[0] - y[1]).conj() * (x[0] - x[1]);
        for (parameter, numerator) in [
            (Parameter::Spring(1), stretch),
            (Parameter::Damper(2), lambda * y[2].conj() * x[2]),
            (Parameter::Mass(1), lambda * lambda * y[1].conj() * x[1]),
        ] {
            let (found, expected) = (found(parameter).expect("it is there"), -numerator / slope);
            assert!((found - expected).norm() < 1e-13 * expected.norm());
        }
        // (19), with the norms of Frobenius.
        let [nm, nc, nk] = [&m, &c, &k].map(|matrix| matrix.norm_l2());
        let alpha = lambda.norm_sqr() * nm + lambda.norm() * nc + nk;
        assert!(mode.backward_error() <= 1e-15);
        let eta = norm(&q_times(&system, lambda, x)) / (alpha * norm(x));
        assert!(eta <= 1e-15);
        let kappa = alpha * norm(x) * norm(y) / (lambda.norm() * slope.norm());
        assert_near(mode.condition().expect("it is simple"), kappa, 1e-12);
    }
}

#[test]
fn holds() {
    let system = three();
    let (a, b) = state_matrix(&system);
    let (state, z) = start();
    let column = Mat::from_fn(6, 1, |i, _| b[(i, 1)]);
    let phi = expm(scaled(&a, H).as_ref()).expect("it is finite");
    let run = |load: Load| {
        let asked = Response::of(&system).from(state.clone()).load("m2", load);
        final_state(&asked.every(H).until(H).run().expect("a motion"))
    };
    // (20): free motion, and the integral by the rule of Simpson in a thousand parts.
    let free = Response::of(&system)
        .from(state.clone())
        .every(H)
        .until(H)
        .run();
    assert_close(&final_state(&free.expect("a motion")), &(&phi * &z), 1e-14);
    let parts = 1000;
    let part = expm(scaled(&a, H / f64::from(parts)).as_ref()).expect("it is finite");
    let (mut integral, mut carried) = (zeros(6, 1), column.clone());
    for index in 0..=parts {
        // The load's age is h − s where e^(As) has come to.
        let force = (0.5 * (H - H * f64::from(index) / f64::from(parts))).sin();
        let weight = if index == 0 || index == parts {
            1.0
        } else if index % 2 == 1 {
            4.0
        } else {
            2.0
        };
        integral += scaled(&carried, weight * force * H / (3.0 * f64::from(parts)));
        carried = &part * &carried;
    }
    assert_close(
        &run(Harmonic::of(1.0, 0.5).into()),
        &(&phi * &z + integral),
        1e-13,
    );
    // (21)
    let p = 3.0;
    let bordered = blocks(&[
        &[&scaled(&a, H), &scaled(&column, H)],
        &[&zeros(1, 6), &zeros(1, 1)],
    ]);
    let held = expm(bordered.as_ref()).expect("it is finite");
    let block = |column: usize| Mat::from_fn(6, 1, |i, _| held[(i, column)]);
    assert_close(
        &run(Step::of(p).into()),
        &(&phi * &z + scaled(&block(6), p)),
        1e-14,
    );
    // (22)
    let slope = -0.5;
    let bordered = blocks(&[
        &[&scaled(&a, H), &scaled(&column, H), &zeros(6, 1)],
        &[&zeros(1, 6), &zeros(1, 1), &identity(1)],
        &[&zeros(1, 6), &zeros(1, 1), &zeros(1, 1)],
    ]);
    let held = expm(bordered.as_ref()).expect("it is finite");
    let block = |column: usize| Mat::from_fn(6, 1, |i, _| held[(i, column)]);
    let expected = &phi * &z + scaled(&block(6), p) + scaled(&block(7), slope * H);
    let samples = Samples {
        step: H,
        values: vec![p, p + slope * H],
        hold: Hold::First,
    };
    assert_close(&run(samples.into()), &expected, 1e-14);
    // (23)
    let after = &z + scaled(&column, 7.0);
    assert_close(&run(Impulse::of(7.0).into()), &(&phi * &after), 1e-13);
    // (24)
    let (frequency, phase) = (2.5, 0.75);
    let rotation = mat![[0.0, frequency], [-frequency, 0.0]];
    let load = blocks(&[&[&scaled(&column, p), &zeros(6, 1)]]);
    let whole = blocks(&[&[&a, &load], &[&zeros(2, 6), &rotation]]);
    let begun = blocks(&[&[&z], &[&mat![[f64::sin(phase)], [f64::cos(phase)]]]]);
    let moved = expm(scaled(&whole, H).as_ref()).expect("it is finite") * begun;
    let expected = Mat::from_fn(6, 1, |i, _| moved[(i, 0)]);
    assert_close(
        &run(Harmonic::of(p, frequency).with_phase(phase).into()),
        &expected,
        1e-13,
    );
}

#[test]
fn resonance() {
    // (25)
    let (m, k, force) = (0.5, 8.0, 3.0);
    let omega = f64::sqrt(k / m);
    let system = oscillator(m, 0.0, k);
    let load = Harmonic::of(force, omega).with_phase(PI / 2.0);
    let answer = Response::of(&system)
        .load("m", load)
        .every(0.5)
        .until(20.0)
        .run()
        .expect("a motion");
    for (column, t) in answer.times().iter().enumerate() {
        let expected = force / (2.0 * m * omega) * t * (omega * t).sin();
        assert!((answer.displacement()[(0, column)] - expected).abs() < 1e-13);
    }
}

#[test]
fn the_exponential() {
    // (26)
    let x = scaled(&state_matrix(&three()).0, 2.0);
    let exact = expm(x.as_ref()).expect("it is finite");
    let mut squared = expm(scaled(&x, 0.125).as_ref()).expect("it is finite");
    for _ in 0..3 {
        squared = &squared * &squared;
    }
    assert_close(&squared, &exact, 1e-13);
    let size = x.norm_l2();
    let (mut sum, mut term, mut last) = (identity(6), identity(6), 1.0);
    for m in 1..30 {
        term = scaled(&(&term * &x), 1.0 / f64::from(m));
        sum += &term;
        last *= size / f64::from(m);
        let next = last * size / f64::from(m + 1);
        if size < f64::from(m + 2) {
            let bound = next / (1.0 - size / f64::from(m + 2));
            assert!((&sum - &exact).norm_l2() <= bound + 1e-13);
        }
    }
}

#[test]
fn superposition() {
    let (q0, v0) = (1.5, -2.0);
    let run = |zeta: f64| {
        let system = oscillator(1.0, 2.0 * zeta * 3.0, 9.0);
        let from = State::at_rest().displace("m", q0).push("m", v0);
        Response::of(&system)
            .from(from)
            .every(0.25)
            .until(5.0)
            .run()
            .expect("a motion")
    };
    // (27), (28)
    let (omega, zeta) = (3.0f64, 0.25f64);
    let damped = omega * (1.0 - zeta * zeta).sqrt();
    let (below, at) = (run(zeta), run(1.0));
    for (column, t) in below.times().iter().enumerate() {
        let oscillating = (-zeta * omega * t).exp()
            * (q0 * (damped * t).cos() + (v0 + zeta * omega * q0) / damped * (damped * t).sin());
        assert!((below.displacement()[(0, column)] - oscillating).abs() < 1e-15);
        let critical = (q0 + (v0 + omega * q0) * t) * (-omega * t).exp();
        assert!((at.displacement()[(0, column)] - critical).abs() < 1e-15);
    }
    // (29): the left eigenvectors of A for y are (λ̄My + Cᵀy; My).
    let system = three();
    let [m, c, _] = matrices(&system);
    let (state, z) = start();
    let z: Vec<C64> = (0..6).map(|i| C64::from(z[(i, 0)])).collect();
    let mut sum = [C64::ZERO; 6];
    for mode in &system.modes().expect("modes") {
        let lambda = mode.eigenvalue().value;
        let (x, y) = (mode.shape(), mode.left_shape().expect("it is simple"));
        let v: Vec<C64> = x
            .iter()
            .copied()
            .chain(x.iter().map(|x| lambda * x))
            .collect();
        let my = times(&m, y);
        let cy = times(&c, y);
        let upper = my.iter().zip(&cy).map(|(m, c)| lambda.conj() * m + c);
        let w: Vec<C64> = upper.chain(my.iter().copied()).collect();
        let part = dot(&w, &z) / dot(&w, &v) * (lambda * H).exp();
        // The conjugate root adds the conjugate.
        sum.iter_mut()
            .zip(&v)
            .for_each(|(sum, v)| *sum += 2.0 * (part * v).re);
    }
    let answer = Response::of(&system)
        .from(state)
        .every(H)
        .until(H)
        .run()
        .expect("a motion");
    let found = final_state(&answer);
    for i in 0..6 {
        assert!((sum[i].re - found[(i, 0)]).abs() < 1e-14);
    }
}

#[test]
fn discs() {
    // (30), (31), about approximations that are off by 1e-6.
    let system = three();
    let modes = system.modes().expect("modes");
    let roots: Vec<C64> = modes.eigenvalues().iter().map(|root| root.value).collect();
    let near: Vec<C64> = roots
        .iter()
        .zip(1..)
        .map(|(z, i)| z + 1e-6 * (I * f64::from(i)).exp())
        .collect();
    let mass = system.mass_matrix().determinant();
    for (i, z) in near.iter().enumerate() {
        let others = near.iter().enumerate().filter(|(j, _)| *j != i);
        let product: C64 = others.map(|(_, other)| z - other).product();
        let correction = q(&system, *z).determinant() / (mass * product);
        let radius = 6.0 * correction.norm();
        assert!((roots[i] - z).norm() <= radius && radius < 1e-5);
        // With the correction taken, what is left is of second order.
        assert!((roots[i] - (z - correction)).norm() < 1e-10);
    }
}

#[test]
fn frequencies_from_a_congruence() {
    // (32), for shapes that are off by 1e-4.
    let damped = three();
    let [m, _, k] = matrices(&damped);
    let system = System::builder()
        .matrix(MatrixKind::Mass, m.as_ref())
        .matrix(MatrixKind::Stiffness, k.as_ref());
    let system = system.build().expect("a system");
    let modes = system.modes().expect("modes");
    let x = Mat::from_fn(3, 3, |i, j| {
        modes.as_slice()[j].shape()[i].re + 1e-4 * ((1 + i + 3 * j) as f64).sin()
    });
    let (g, s) = (x.transpose() * &m * &x, x.transpose() * &k * &x);
    let off = |matrix: &Mat<f64>| {
        let scaled = Mat::from_fn(3, 3, |i, j| {
            if i == j {
                0.0
            } else {
                matrix[(i, j)] / (matrix[(i, i)] * matrix[(j, j)]).sqrt()
            }
        });
        scaled.norm_l2()
    };
    let (eg, es) = (off(&g), off(&s));
    assert!(eg > 1e-6 && eg < 1e-2 && es > 1e-6 && es < 1e-2);
    for (j, mode) in modes.iter().enumerate() {
        let square = mode.natural_frequency().radians_per_second().powi(2);
        let d = s[(j, j)] / g[(j, j)];
        assert!(d * (1.0 - es) / (1.0 + eg) <= square && square <= d * (1.0 + es) / (1.0 - eg));
    }
}

#[test]
fn energy() {
    let system = three();
    let [m, c, k] = matrices(&system);
    let (state, z) = start();
    // (33): what is gone after a short time is what the damper took and the load brought.
    let force = mat![[0.0], [3.0], [0.0]];
    let h = 1e-5;
    let asked = Response::of(&system)
        .from(state)
        .load("m2", Step::of(3.0))
        .every(h)
        .until(2.0 * h);
    let answer = asked.run().expect("a motion");
    let energy = |column: usize| {
        let x = answer.displacement().subcols(column, 1).to_owned();
        let v = answer.velocity().subcols(column, 1).to_owned();
        0.5 * (v.transpose() * &m * &v)[(0, 0)] + 0.5 * (x.transpose() * &k * &x)[(0, 0)]
    };
    let v = answer.velocity().subcols(1, 1).to_owned();
    let power = (force.transpose() * &v)[(0, 0)] - (v.transpose() * &c * &v)[(0, 0)];
    assert_near((energy(2) - energy(0)) / (2.0 * h), power, 1e-8);
    // (34)
    let l = k.llt(faer::Side::Lower).expect("it is held").L().to_owned();
    let root = Mat::from_fn(3, 3, |i, j| m[(i, j)].sqrt());
    let r = blocks(&[
        &[&l.transpose().to_owned(), &zeros(3, 3)],
        &[&zeros(3, 3), &root],
    ]);
    let length = (&r * &z).squared_norm_l2();
    assert_near(length, 2.0 * energy(0), 1e-14);
    let phi = expm(scaled(&state_matrix(&system).0, H).as_ref()).expect("it is finite");
    let carried = &r * &phi * r.partial_piv_lu().inverse();
    let contraction = carried.singular_values().expect("they converge")[0];
    assert!(contraction <= 1.0 + 1e-14);
    // (35): errors of δ in each of a hundred steps.
    let delta = 1e-3;
    let mut error = zeros(6, 1);
    for step in 0..100 {
        let rounding = Mat::from_fn(6, 1, |i, _| ((6 * step + i) as f64).sin());
        error = &carried * error + scaled(&rounding, delta / rounding.norm_l2());
        assert!(error.norm_l2() <= delta * f64::from(step as u32 + 1));
    }
    // In the coordinates of (8) the same step lengthens some error.
    assert!(phi.singular_values().expect("they converge")[0] > 1.05);
}

#[test]
fn steady_state() {
    // (36)
    let system = three();
    let [m, c, k] = matrices(&system);
    let (amplitude, frequency, phase) = (2.0, 1.25, 0.5);
    let load = Harmonic::of(amplitude, frequency).with_phase(phase);
    let asked = Response::of(&system)
        .load("m1", load)
        .every(1.0)
        .until(400.0);
    let problem = asked.clone().problem().expect("a problem");
    let steady = SteadyState::of(&problem).expect("it is damped");
    let x = steady.motions()[0].displacement();
    let matrix = Mat::from_fn(3, 3, |i, j| {
        C64::new(
            k[(i, j)] - frequency * frequency * m[(i, j)],
            frequency * c[(i, j)],
        )
    });
    let force = Mat::from_fn(3, 1, |i, _| {
        if i == 0 {
            C64::from_polar(amplitude, phase)
        } else {
            C64::ZERO
        }
    });
    let solved = matrix.partial_piv_lu().solve(&force);
    let answer = asked.run().expect("a motion");
    let (last, t) = (answer.len() - 1, 400.0);
    for i in 0..3 {
        assert!((x[i] - solved[(i, 0)]).norm() < 1e-14);
        let expected = x[i].norm() * (frequency * t + x[i].arg()).sin();
        assert!((answer.displacement()[(i, last)] - expected).abs() < 1e-12);
    }
    // (37)
    let (m, c, k) = (0.5, 6.0, 200.0);
    let one = oscillator(m, c, k);
    let found = receptance(&one, "m", 15.0)
        .expect("it is damped")
        .displacement()[0]
        .norm();
    let expected = 1.0 / f64::hypot(k - m * 15.0 * 15.0, c * 15.0);
    assert_near(found, expected, 1e-15);
    // (38)
    let system = rayleigh(0.125, 0.0625);
    let modal = ClassicalModes::of(&system)
        .expect("modes")
        .expect("C is classical");
    let column = receptance(&system, "m1", frequency).expect("it is damped");
    for (a, found) in column.displacement().iter().enumerate() {
        let part = |j: usize| {
            let (mass, shapes) = (modal.mass()[j], modal.shapes());
            let omega = (modal.stiffness()[j] / mass).sqrt();
            let zeta = modal.damping()[j] / (2.0 * omega * mass);
            let denominator =
                omega * omega - frequency * frequency + 2.0 * I * zeta * omega * frequency;
            shapes[(a, j)] * shapes[(0, j)] / (mass * denominator)
        };
        let expected = part(0) + part(1);
        assert!((found - expected).norm() < 1e-14 * expected.norm());
    }
}
