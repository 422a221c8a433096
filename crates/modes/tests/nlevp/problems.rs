//! Quadratic problems λ²M + λC + K with real square matrices of the collection NLEVP (Betcke, Higham, Mehrmann, Schröder &
//! Tisseur 2013, *ACM Trans. Math. Softw.* 39), from the formulas and numbers printed there and in the papers it names.
//!
//! Problems with imaginary coefficients are taken in s = 2πiλ (acoustic waves) or s = iλ (sign operators), where they are real; the power
//! plant without hysteresis. What the collection draws at random is a fixed choice here.

use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, mat};

use std::f64::consts::PI;

use crate::mesh::Model;

pub struct Problem {
    pub name: &'static str,
    pub model: Model,
}

fn problem(name: &'static str, mass: Mat<f64>, damping: Mat<f64>, stiffness: Mat<f64>) -> Problem {
    let model = Model {
        mass,
        damping,
        stiffness,
    };
    Problem { name, model }
}

fn unit(n: usize) -> Mat<f64> {
    Mat::identity(n, n)
}

fn diagonal(entries: &[f64]) -> Mat<f64> {
    let n = entries.len();
    Mat::from_fn(n, n, |i, j| if i == j { entries[i] } else { 0.0 })
}

/// Constant on and beside the diagonal.
fn tridiagonal(n: usize, [below, on, above]: [f64; 3]) -> Mat<f64> {
    Mat::from_fn(n, n, |i, j| match (i + 1).checked_sub(j) {
        Some(0) => above,
        Some(1) => on,
        Some(2) => below,
        _ => 0.0,
    })
}

fn with(mut matrix: Mat<f64>, entries: &[(usize, usize, f64)]) -> Mat<f64> {
    for (i, j, value) in entries {
        matrix[(*i, *j)] = *value;
    }
    matrix
}

fn kron(a: &Mat<f64>, b: &Mat<f64>) -> Mat<f64> {
    let m = b.nrows();
    let n = a.nrows() * m;
    Mat::from_fn(n, n, |i, j| a[(i / m, j / m)] * b[(i % m, j % m)])
}

fn times(factor: f64, matrix: &Mat<f64>) -> Mat<f64> {
    matrix * faer::Scale(factor)
}

fn symmetric(matrix: Mat<f64>) -> Mat<f64> {
    times(0.5, &(&matrix + matrix.transpose()))
}

fn skew(matrix: Mat<f64>) -> Mat<f64> {
    times(0.5, &(&matrix - matrix.transpose()))
}

fn inverse(matrix: &Mat<f64>) -> Mat<f64> {
    matrix.partial_piv_lu().inverse()
}

/// Numbers in 0 … 1 that repeat after a long time.
fn number(seed: usize) -> f64 {
    (0.137 + 0.618_033_988_749_894_9 * seed as f64).fract()
}

/// Reflections in two planes, one after the other.
fn orthogonal(n: usize, seed: usize) -> Mat<f64> {
    let plane = |seed: usize| {
        let v: Vec<f64> = (0..n).map(|i| number(seed + 7 * i) - 0.45).collect();
        let square: f64 = v.iter().map(|x| x * x).sum();
        Mat::from_fn(n, n, |i, j| {
            f64::from(u8::from(i == j)) - 2.0 * v[i] * v[j] / square
        })
    };
    plane(seed) * plane(seed + 101)
}

pub fn acoustic_wave_1d(n: usize) -> Problem {
    let h = 1.0 / n as f64;
    let last = |value| with(unit(n), &[(n - 1, n - 1, value)]);
    let stiffness = with(tridiagonal(n, [-1.0, 2.0, -1.0]), &[(n - 1, n - 1, 1.0)]);
    let damping = with(Mat::zeros(n, n), &[(n - 1, n - 1, 1.0)]);
    problem(
        "acoustic_wave_1d",
        times(h, &last(0.5)),
        damping,
        times(n as f64, &stiffness),
    )
}

/// On q × (q − 1) points.
pub fn acoustic_wave_2d(q: usize) -> Problem {
    let h = 1.0 / q as f64;
    let end = (q - 1, q - 1);
    let across = unit(q - 1);
    let half = with(unit(q), &[(end.0, end.1, 0.5)]);
    let along = with(tridiagonal(q, [-1.0, 4.0, -1.0]), &[(end.0, end.1, 2.0)]);
    let beside = tridiagonal(q - 1, [1.0, 0.0, 1.0]);
    let wall = with(Mat::zeros(q, q), &[(end.0, end.1, h)]);
    problem(
        "acoustic_wave_2d",
        times(h * h, &kron(&across, &half)),
        kron(&across, &wall),
        kron(&across, &along) - kron(&beside, &half),
    )
}

pub fn bcc_traffic(n: usize) -> Problem {
    let chain = with(tridiagonal(n, [-1.0, 2.0, -1.0]), &[(n - 1, n - 1, 1.0)]);
    let gains = |seed: usize| -> Vec<f64> {
        let weak = |i: usize| (i + seed).is_multiple_of(2);
        let gain = |i: usize| {
            if weak(i) {
                0.05 + 0.1 * number(i + 31 * seed)
            } else {
                0.3 + 0.2 * number(i + 31 * seed)
            }
        };
        (0..n).map(gain).collect()
    };
    let scaled = |seed| diagonal(&gains(seed)) * &chain;
    problem("bcc_traffic", unit(n), scaled(0), scaled(1))
}

pub fn bicycle(speed: f64) -> Problem {
    let still = mat![
        [-80.95, -2.59951685249872],
        [-2.59951685249872, -0.80329488458618]
    ];
    let moving = mat![[0.0, 76.59734589573222], [0.0, 2.65431523794604]];
    problem(
        "bicycle",
        mat![
            [80.81722, 2.31941332208709],
            [2.31941332208709, 0.29784188199686]
        ],
        times(
            speed,
            &mat![
                [0.0, 33.86641391492494],
                [-0.85035641456978, 1.68540397397560]
            ],
        ),
        times(9.81, &still) + times(speed * speed, &moving),
    )
}

pub fn bilby(beta: f64) -> Problem {
    let birth = [1.0, 0.4, 0.25, 0.1, 0.0];
    let death = [0.0, 0.5, 0.55, 0.8, 1.0];
    let stay: Vec<f64> = birth.iter().zip(&death).map(|(b, d)| 1.0 - b - d).collect();
    let part = |x: &[f64]| {
        Mat::from_fn(5, 5, |j, i| match (i, j) {
            (_, 0) => 0.2 * x[i],
            (4, 4) => 0.8 * x[4],
            _ if j == i + 1 => 0.8 * x[i],
            _ => 0.0,
        })
    };
    let of = |x: &[f64]| times(beta, &part(x));
    problem("bilby", of(&death), of(&stay) - unit(5), of(&birth))
}

pub fn closed_loop(alpha: f64) -> Problem {
    problem(
        "closed_loop",
        unit(2),
        mat![[0.0, 1.0 + alpha], [1.0, 0.0]],
        diagonal(&[0.5, 0.25]),
    )
}

/// Pinned at both ends, with a dashpot in the middle; `elements` is even.
pub fn damped_beam(elements: usize) -> Problem {
    let h = 1.0 / elements as f64;
    let (width, height) = (0.05, 0.005);
    let rigidity = 7e10 * width * height * height * height / 12.0;
    let (k, m) = (rigidity / (h * h * h), 0.674 * h / 420.0);
    let stiff = [
        [12.0, 6.0 * h, -12.0, 6.0 * h],
        [6.0 * h, 4.0 * h * h, -6.0 * h, 2.0 * h * h],
        [-12.0, -6.0 * h, 12.0, -6.0 * h],
        [6.0 * h, 2.0 * h * h, -6.0 * h, 4.0 * h * h],
    ];
    let heavy = [
        [156.0, 22.0 * h, 54.0, -13.0 * h],
        [22.0 * h, 4.0 * h * h, 13.0 * h, -3.0 * h * h],
        [54.0, 13.0 * h, 156.0, -22.0 * h],
        [-13.0 * h, -3.0 * h * h, -22.0 * h, 4.0 * h * h],
    ];
    let all = 2 * elements + 2;
    let free: Vec<usize> = (1..all - 2).chain([all - 1]).collect();
    let held = |of: &[[f64; 4]; 4], factor: f64| {
        let mut whole = Mat::<f64>::zeros(all, all);
        for (e, i, j) in (0..elements).flat_map(|e| (0..16).map(move |at| (e, at / 4, at % 4))) {
            whole[(2 * e + i, 2 * e + j)] += of[i][j];
        }
        let n = free.len();
        Mat::from_fn(n, n, |i, j| factor * whole[(free[i], free[j])])
    };
    let n = 2 * elements;
    let damping = with(Mat::zeros(n, n), &[(elements - 1, elements - 1, 5.0)]);
    problem("damped_beam", held(&heavy, m), damping, held(&stiff, k))
}

/// On q × q points; `drag` 0 is the elastic deformation of the same paper.
pub fn damped_gyro(name: &'static str, q: usize, drag: f64) -> Problem {
    let sum = |[x, y]: [f64; 2], part: &Mat<f64>| {
        kron(&times(x, &unit(q)), part) + kron(&times(y, part), &unit(q))
    };
    let mass = times(1.0 / 6.0, &tridiagonal(q, [1.0, 4.0, 1.0]));
    let turn = sum([0.1, 1.2], &tridiagonal(q, [1.0, 0.0, -1.0]));
    let drags = sum([1.05, 0.9], &tridiagonal(q, [1.0, 2.0, 1.0]));
    problem(
        name,
        sum([1.0, 1.3], &mass),
        turn + times(drag, &drags),
        sum([1.0, 1.2], &tridiagonal(q, [1.0, -2.0, 1.0])),
    )
}

/// The deformed Laplacian of a ring of n nodes with chords to every third.
pub fn deformed_consensus(n: usize) -> Problem {
    let joined = |i: usize, j: usize| {
        let gap = i.abs_diff(j).min(n - i.abs_diff(j));
        gap == 1 || gap == 3 && i.min(j).is_multiple_of(3)
    };
    let joins = Mat::from_fn(n, n, |i, j| f64::from(u8::from(joined(i, j))));
    let less = |i: usize| joins.row(i).iter().sum::<f64>() - 1.0;
    let degrees: Vec<f64> = (0..n).map(less).collect();
    problem(
        "deformed_consensus",
        diagonal(&degrees),
        times(-1.0, &joins),
        unit(n),
    )
}

/// 2q functions.
pub fn dirac(q: usize) -> Problem {
    const ALPHA: f64 = -0.5;
    const KAPPA: f64 = -1.0;
    let p: Vec<f64> = (0..q)
        .scan(1.0, |p, i| {
            let now = *p;
            *p *= 1.0 + 0.5 / (i + 1) as f64;
            Some(now)
        })
        .collect();
    let sign = |i: usize, j: usize| if (i + j).is_multiple_of(2) { 1.0 } else { -1.0 };
    let root = |i: usize| p[i].sqrt();
    let gap = |i: usize, j: usize| 2.0 * (i as f64 - j as f64);
    let square = |of: &dyn Fn(usize, usize) -> f64| Mat::from_fn(q, q, of);
    let r2 = square(&|i, j| {
        let gap = gap(i, j);
        -2.0 / PI.sqrt() * sign(i, j) * gap / (gap - 1.0) / (gap + 1.0) * root(i) * root(j)
    });
    let r3 = square(&|i, j| {
        let part = |k: usize| p[k] / (2 * k + 1) as f64 / (gap(k, j) - 1.0);
        -2.0 / PI.sqrt() * sign(i, j) * (0..=i).map(part).sum::<f64>() * root(j) / root(i)
    });
    let r4 = square(&|i, j| match i.abs_diff(j) {
        0 => (4 * i + 3) as f64 / 2.0,
        1 => -((2 * i.max(j) + 1) as f64 * (2 * i.max(j)) as f64).sqrt() / 2.0,
        _ => 0.0,
    });
    let quotient = |i: usize, j: usize| 2.0 * sign(i, j) * root(i) / root(j);
    let r5 = square(&|i, j| match i.cmp(&j) {
        std::cmp::Ordering::Less => quotient(i, j),
        std::cmp::Ordering::Equal => 1.0,
        std::cmp::Ordering::Greater => 0.0,
    });
    let r6 = square(&|i, j| {
        if i == j {
            2.0
        } else {
            quotient(i.min(j), i.max(j))
        }
    });
    let one = unit(q);
    let both = times(1.0, &(&r5 + r5.transpose()));
    let (cross, twice) = (
        times(ALPHA, &(&r5 - r5.transpose())),
        times(2.0 * ALPHA * KAPPA, &r6),
    );
    let squares = times(ALPHA * ALPHA + KAPPA * KAPPA, &r6) + &r4 + &one;
    let turned = times(-1.0, &(&r2 + r2.transpose()));
    let first = [
        [&one + times(ALPHA, &r3), &r2 + times(KAPPA, &r3)],
        [times(KAPPA, &r3) - &r2, times(ALPHA, &r3) - &one],
    ];
    let second = [
        [
            &squares + times(2.0 * ALPHA, &r3) + times(KAPPA, &both),
            &turned + &cross + &twice,
        ],
        [
            &turned - &cross + &twice,
            &squares - times(2.0 * ALPHA, &r3) - times(KAPPA, &both),
        ],
    ];
    let joined = |parts: &[[Mat<f64>; 2]; 2]| {
        let whole = Mat::from_fn(2 * q, 2 * q, |i, j| parts[i / q][j / q][(i % q, j % q)]);
        symmetric(whole)
    };
    problem(
        "dirac",
        unit(2 * q),
        times(-2.0, &joined(&first)),
        joined(&second),
    )
}

/// Hyperbolic, with roots ±(j + a fraction).
pub fn gen_hyper2(n: usize) -> Problem {
    let first = orthogonal(n, 3);
    let second = &first * orthogonal(n, 17);
    let roots = |sign: f64| -> Vec<f64> {
        (0..n)
            .map(|j| sign * (j as f64 + 0.2 + 0.7 * number(j)))
            .collect()
    };
    let (above, below) = (roots(1.0), roots(-1.0));
    let moment = |power: i32| {
        let part = |v: &Mat<f64>, roots: &[f64]| {
            let powers: Vec<f64> = roots.iter().map(|x| x.powi(power)).collect();
            v * diagonal(&powers) * v.transpose()
        };
        part(&first, &above) - part(&second, &below)
    };
    let one = symmetric(moment(1));
    let mass = inverse(&one);
    let damping = symmetric(times(-1.0, &(&mass * moment(2) * &mass)));
    let stiffness = &damping * &one * &damping - &mass * moment(3) * &mass;
    problem("gen_hyper2", mass, damping, symmetric(stiffness))
}

/// λ²A + λB ± Aᵀ with roots on the unit circle, from a real Jordan triple on the imaginary axis by Cayley's transform.
pub fn gen_palindromic(name: &'static str, n: usize) -> Problem {
    let is_anti = name == "gen_tantipal2";
    let sign = if is_anti { -1.0 } else { 1.0 };
    let jordan = |rate: &dyn Fn(usize) -> f64| {
        Mat::from_fn(2 * n, 2 * n, |i, j| match (i % 2 == 0, i.abs_diff(j)) {
            (true, 1) if j > i => rate(i / 2),
            (false, 1) if i > j => -rate(j / 2),
            _ => 0.0,
        })
    };
    let angle = |i: usize| 1e-4 + (PI - 2e-4) * number(3 * i + 1);
    let rates = jordan(&|i| (0.5 * angle(i)).tan());
    let first = orthogonal(n, 5);
    let (x, s) = if is_anti {
        let second = &first * orthogonal(n, 29);
        let halves: Vec<f64> = (0..2 * n).map(|i| if i < n { 1.0 } else { -1.0 }).collect();
        (
            Mat::from_fn(n, 2 * n, |i, j| {
                if j < n {
                    first[(i, j)]
                } else {
                    second[(i, j - n)]
                }
            }),
            diagonal(&halves),
        )
    } else {
        (
            Mat::from_fn(n, 2 * n, |i, j| first[(i, j / 2)]),
            jordan(&|_| 1.0),
        )
    };
    let even = |m: Mat<f64>| if is_anti { skew(m) } else { symmetric(m) };
    let odd = |m: Mat<f64>| if is_anti { symmetric(m) } else { skew(m) };
    let moment = |power: &Mat<f64>| &x * power * x.transpose();
    let once = &rates * &s;
    let twice = &rates * &once;
    let two = even(inverse(&moment(&once)));
    let one = odd(times(-1.0, &(&two * moment(&twice) * &two)));
    let third = moment(&(&rates * &twice));
    let zero = even(times(
        -1.0,
        &(&two * (moment(&twice) * &one + third * &two)),
    ));
    let mass = &two + &one + &zero;
    let stiffness = times(sign, &mass.transpose().to_owned());
    problem(name, mass, times(2.0, &(zero - two)), stiffness)
}

pub fn intersection() -> Problem {
    let (r, s) = (1.6e-3, 5.3e-4);
    let stiffness = with(
        Mat::zeros(10, 10),
        &[
            (0, 0, r),
            (3, 0, s),
            (1, 1, r),
            (4, 1, s),
            (6, 1, 1e-4),
            (2, 2, r),
            (5, 2, s),
            (7, 2, 1e-4),
            (3, 3, s),
            (6, 3, 1.0),
            (4, 4, s),
            (5, 5, s),
            (8, 5, 1.0),
            (6, 6, -3.4e-3),
            (7, 6, 1.0),
            (8, 6, 1e-4),
            (0, 7, -1.0),
            (3, 7, -1.0),
            (7, 7, -3.4e-3),
            (9, 7, 1e-4),
            (1, 8, -1.0),
            (4, 8, -1.0),
            (8, 8, -3.4e-3),
            (9, 8, 1.0),
            (2, 9, -1.0),
            (5, 9, -1.0),
            (9, 9, -3.4e-3),
        ],
    );
    let (tilt, shift) = (-1.4e-4, 0.027);
    let damping = with(
        Mat::zeros(10, 10),
        &[
            (6, 6, tilt),
            (3, 7, shift),
            (7, 7, tilt),
            (4, 8, shift),
            (8, 8, tilt),
            (5, 9, shift),
            (9, 9, tilt),
        ],
    );
    let mass = with(
        Mat::zeros(10, 10),
        &[
            (0, 7, r),
            (3, 7, s),
            (1, 8, r),
            (4, 8, s),
            (2, 9, r),
            (5, 9, s),
        ],
    );
    problem("intersection", mass, damping, stiffness)
}

pub fn metal_strip() -> Problem {
    let now = times(
        100.0,
        &mat![[-7.0, 1.0, 2.0], [3.0, -9.0, 0.0], [1.0, 2.0, -6.0]],
    );
    let before = times(
        100.0,
        &mat![[1.0, 0.0, -3.0], [-0.5, -0.5, -1.0], [-0.5, -1.5, 0.0]],
    );
    let delayed = times(
        -1.0 / 72.0,
        &mat![[-1.0, 5.0, 2.0], [4.0, 0.0, 3.0], [-2.0, 4.0, 1.0]],
    );
    let one = unit(3);
    let mass = kron(&one, &before) + kron(&now, &delayed);
    let damping =
        kron(&one, &now) + kron(&now, &one) + kron(&delayed, &before) + kron(&before, &delayed);
    let turned = |i: usize| 3 * (i % 3) + i / 3;
    let stiffness = Mat::from_fn(9, 9, |i, j| mass[(turned(i), turned(j))]);
    problem("metal_strip", mass, damping, stiffness)
}

pub fn mobile_manipulator() -> Problem {
    let rows = |rows: [[f64; 3]; 3]| {
        Mat::from_fn(5, 5, |i, j| if i < 3 && j < 3 { rows[i][j] } else { 0.0 })
    };
    let mass = [
        [18.7532, -7.94493, 7.94494],
        [-7.94493, 31.8182, -26.8182],
        [7.94494, -26.8182, 26.8182],
    ];
    let damping = [
        [-1.52143, -1.55168, 1.55168],
        [3.22064, 3.28467, -3.28467],
        [-3.22064, -3.28467, 3.28467],
    ];
    let stiffness = [
        [67.4894, 69.2393, -69.2393],
        [69.8124, 1.68624, -1.68617],
        [-69.8123, -1.68617, -68.2707],
    ];
    let held = [(0, 3, -1.0), (2, 4, -1.0), (3, 0, 1.0), (4, 2, 1.0)];
    problem(
        "mobile_manipulator",
        rows(mass),
        rows(damping),
        with(rows(stiffness), &held),
    )
}

pub fn power_plant() -> Problem {
    let both = |own: [f64; 8], beside: &[(usize, usize, f64)]| {
        let upper = with(Mat::zeros(8, 8), beside);
        &upper + upper.transpose() + diagonal(&own)
    };
    let mass = diagonal(&[5.4, 0.168e7, 55.2, 0.8711e8, 57.8, 0.235e9, 16.0, 0.214e8]);
    let damping = both(
        [
            9.99, 0.1045e8, 548.0, 0.4329e10, 6178.0, 0.4343e11, 30.0, 0.3473e9,
        ],
        &[
            (0, 1, -7492.0),
            (0, 2, -9.99),
            (0, 3, 9790.0),
            (1, 2, 7492.0),
            (1, 3, -0.1221e8),
            (2, 3, -0.9674e6),
            (2, 4, -538.0),
            (2, 5, -0.538e6),
            (3, 4, 0.9576e6),
            (3, 5, -0.1652e10),
            (4, 5, -0.5042e7),
            (4, 6, -30.0),
            (4, 7, 57000.0),
            (5, 6, -30000.0),
            (5, 7, -0.182e9),
            (6, 7, -57000.0),
        ],
    );
    let stiffness = both(
        [
            11600.0, 0.1522e11, 0.5296e6, 0.9461e13, 0.6862e6, 0.9953e13, 6170.0, 0.2893e12,
        ],
        &[
            (0, 1, -0.87e7),
            (0, 2, -11600.0),
            (0, 3, 0.1137e8),
            (1, 2, 0.87e7),
            (1, 3, -0.1723e11),
            (2, 3, -0.9334e9),
            (2, 4, -0.518e6),
            (2, 5, -0.518e9),
            (3, 4, 0.922e9),
            (3, 5, -0.6878e13),
            (4, 5, 0.3633e9),
            (4, 6, -6170.0),
            (4, 7, 0.1172e8),
            (5, 6, -0.617e7),
            (5, 7, -0.2553e12),
            (6, 7, -0.1172e8),
        ],
    );
    problem("power_plant", mass, damping, stiffness)
}

/// The roots 1/3, 1/2, 1, ±i and one at infinity.
pub fn qep1() -> Problem {
    problem(
        "qep1",
        mat![[0.0, 6.0, 0.0], [0.0, 6.0, 0.0], [0.0, 0.0, 1.0]],
        mat![[1.0, -6.0, 0.0], [2.0, -7.0, 0.0], [0.0, 0.0, 0.0]],
        unit(3),
    )
}

/// The roots −1, 1 three times, and two at infinity.
pub fn qep2() -> Problem {
    problem(
        "qep2",
        diagonal(&[1.0, 1.0, 0.0]),
        mat![[-2.0, 0.0, 1.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]],
        diagonal(&[1.0, -1.0, 1.0]),
    )
}

/// The roots 0, 1, 1 + e, 2, 3 and one at infinity.
pub fn qep3(e: f64) -> Problem {
    problem(
        "qep3",
        mat![[1.0, -1.0, -1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]],
        mat![[-3.0, 1.0, 0.0], [0.0, -1.0 - e, 0.0], [0.0, 0.0, 1.0]],
        mat![[2.0, 0.0, 9.0], [0.0, 0.0, 0.0], [0.0, 0.0, -3.0]],
    )
}

/// det(λ²M + λC + K) = 0 for every λ.
pub fn qep5() -> Problem {
    problem(
        "qep5",
        mat![[1.0, 4.0, 2.0], [0.0, 0.0, 0.0], [1.0, 4.0, 2.0]],
        mat![[1.0, 3.0, 0.0], [1.0, 4.0, 2.0], [0.0, -1.0, -2.0]],
        mat![[1.0, 2.0, -2.0], [0.0, -1.0, -2.0], [0.0, 0.0, 0.0]],
    )
}

/// Multiplication by sign(x) + …, `which` 1 or 2, in 2m + 1 exponentials.
pub fn sign(which: usize, m: usize) -> Problem {
    let n = 2 * m + 1;
    let is_odd = |k: usize| k % 2 == 1 && k < 2 * m;
    // The symbol and its square.
    let first = |k: usize| match (which, k) {
        (1, k) if is_odd(k) => 2.0 / (PI * k as f64),
        (2, 2) => -0.5,
        (2, k) if is_odd(k) => 4.0 / (PI * k as f64),
        _ => 0.0,
    };
    let second = |k: usize| match (which, k) {
        (1, 0) => 1.0,
        (2, 0) => 4.5,
        (2, 4) => -0.25,
        (2, k) if is_odd(k) => -16.0 / (PI * (4.0 - (k * k) as f64)),
        _ => 0.0,
    };
    let turn = Mat::from_fn(n, n, |i, j| {
        if i >= j {
            2.0 * first(i - j)
        } else {
            -2.0 * first(j - i)
        }
    });
    let name = if which == 1 { "sign1" } else { "sign2" };
    problem(
        name,
        unit(n),
        turn,
        Mat::from_fn(n, n, |i, j| -second(i.abs_diff(j))),
    )
}

pub fn sleeper(n: usize) -> Problem {
    let ring = with(
        tridiagonal(n, [1.0, -2.0, 1.0]),
        &[(0, n - 1, 1.0), (n - 1, 0, 1.0)],
    );
    let square = &ring * &ring;
    let damping = &square + unit(n);
    problem("sleeper", unit(n), damping.clone(), damping + ring)
}

pub fn spring(n: usize) -> Problem {
    let chain = |k: f64| {
        let ends = [(0, 0, 3.0 * k), (n - 1, n - 1, 3.0 * k)];
        with(tridiagonal(n, [-k, 3.0 * k, -k]), &ends)
    };
    problem("spring", unit(n), chain(10.0), chain(5.0))
}

/// A spring beside q Maxwell elements, two coordinates each.
pub fn spring_dashpot(q: usize) -> Problem {
    let block = |seed: usize| {
        let root = Mat::from_fn(2, 2, |i, j| 0.2 + 0.8 * number(seed + 2 * i + j));
        &root * root.transpose()
    };
    let (stiff, heavy) = (block(1), block(11));
    let elastic: Vec<f64> = (0..q).map(|i| 0.1 + 0.9 * number(2 * i + 5)).collect();
    let viscous: Vec<f64> = (0..q).map(|i| 0.1 + 0.9 * number(3 * i + 8)).collect();
    let whole: f64 = elastic.iter().sum();
    let first = with(Mat::zeros(q + 1, q + 1), &[(0, 0, 7850.0)]);
    let dashpots: Vec<f64> = [0.0].iter().chain(&viscous).copied().collect();
    let arrow = Mat::from_fn(q + 1, q + 1, |i, j| match (i, j) {
        (0, 0) => whole,
        (0, j) => viscous[j - 1],
        (i, 0) => viscous[i - 1],
        (i, j) if i == j => elastic[i - 1],
        _ => 0.0,
    });
    problem(
        "spring_dashpot",
        kron(&first, &heavy),
        kron(&diagonal(&dashpots), &stiff),
        kron(&arrow, &stiff),
    )
}

pub fn wing() -> Problem {
    problem(
        "wing",
        mat![
            [17.6, 1.28, 2.89],
            [1.28, 0.824, 0.413],
            [2.89, 0.413, 0.725]
        ],
        mat![[7.66, 2.45, 2.1], [0.23, 1.04, 0.223], [0.6, 0.756, 0.658]],
        mat![[121.0, 18.9, 15.9], [0.0, 2.7, 0.145], [11.9, 3.64, 15.5]],
    )
}

/// `drag` 0 is the first of two.
pub fn wiresaw(name: &'static str, n: usize, speed: f64, drag: f64) -> Problem {
    let turn = Mat::from_fn(n, n, |i, j| {
        let (j, k) = ((i + 1) as f64, (j + 1) as f64);
        if (j + k) % 2.0 == 1.0 {
            4.0 * j * k * speed / (j * j - k * k)
        } else {
            0.0
        }
    });
    let own: Vec<f64> = (1..=n)
        .map(|j| 0.5 * (j * j) as f64 * PI * PI * (1.0 - speed * speed))
        .collect();
    let stiffness = diagonal(&own) + times(drag, &turn);
    problem(
        name,
        times(0.5, &unit(n)),
        turn + times(drag, &unit(n)),
        stiffness,
    )
}

/// Coefficients over 1, x, y, x², xy, y², x³, x²y, xy², y³, each a polynomial in w of degree 2.
#[derive(Clone, Copy)]
struct Cubic([[f64; 3]; 10]);

impl Cubic {
    const POWERS: [(usize, usize); 10] = [
        (0, 0),
        (1, 0),
        (0, 1),
        (2, 0),
        (1, 1),
        (0, 2),
        (3, 0),
        (2, 1),
        (1, 2),
        (0, 3),
    ];

    const ZERO: Cubic = Cubic([[0.0; 3]; 10]);

    fn plus(self, other: Cubic, factor: f64) -> Cubic {
        let part = |i: usize, k: usize| self.0[i][k] + factor * other.0[i][k];
        Cubic(std::array::from_fn(|i| std::array::from_fn(|k| part(i, k))))
    }

    fn times(self, other: Cubic) -> Cubic {
        let mut product = Cubic::ZERO;
        for (i, j) in (0..100).map(|at| (at / 10, at % 10)) {
            let ((a, b), (c, d)) = (Cubic::POWERS[i], Cubic::POWERS[j]);
            let Some(at) = Cubic::POWERS
                .iter()
                .position(|power| *power == (a + c, b + d))
            else {
                continue;
            };
            for (k, l) in (0..9).map(|at| (at / 3, at % 3)).filter(|(k, l)| k + l < 3) {
                product.0[at][k + l] += self.0[i][k] * other.0[j][l];
            }
        }
        product
    }

    /// Times w.
    fn raised(self) -> Cubic {
        Cubic(self.0.map(|[a, b, _]| [0.0, a, b]))
    }
}

/// Two views of six points by one camera of unknown focal length f: F = xF₁ + yF₂ + F₃ with det F = 0 and
/// 2 FQFᵀQF = tr(FQFᵀQ)F, Q = diag(1, 1, w), w = f⁻² (Kukelova, Bujnak & Pajdla 2008, BMVC). Three roots are infinite but for rounding.
pub fn relative_pose_6pt() -> Problem {
    let first = [
        [0.98546290800037, 0.68369049573664],
        [-1.97451815082977, -8.06356113591952],
        [-4.74852466853571, -1.67723551191802],
        [-0.08015690576328, -0.81102548799456],
        [-2.60498296435867, -4.12124589320883],
        [1.82921772080851, -3.16952237236666],
    ];
    let second = [
        [2.70596068011403, 4.18287782226932],
        [-0.10212743701718, -3.54681903112052],
        [-2.39185334180910, 0.76294387477984],
        [1.42400401680915, 2.08968858056361],
        [-0.62500033043145, -0.81578650651845],
        [3.05926578381682, 0.21660652322887],
    ];
    let ray = |[x, y]: [f64; 2]| [x, y, 1.0];
    let rows = Mat::from_fn(6, 9, |i, j| ray(second[i])[j / 3] * ray(first[i])[j % 3]);
    let svd = rows.svd().expect("it converges");
    let entry = |at: usize| {
        let of = |k: usize| svd.V()[(at, k)];
        let mut entry = Cubic::ZERO;
        (entry.0[1][0], entry.0[2][0], entry.0[0][0]) = (of(6), of(7), of(8));
        entry
    };
    let f: [[Cubic; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| entry(3 * i + j)));
    let weighed = |entry: Cubic, k: usize| if k == 2 { entry.raised() } else { entry };
    let sum = |of: &dyn Fn(usize) -> Cubic| (0..3).fold(Cubic::ZERO, |sum, k| sum.plus(of(k), 1.0));
    let gram = |i: usize, j: usize| sum(&|k| weighed(f[i][k].times(f[j][k]), k));
    let trace = sum(&|k| weighed(gram(k, k), k));
    let mut equations = vec![sum(&|k| {
        let (p, q) = ((k + 1) % 3, (k + 2) % 3);
        let minor = f[1][p].times(f[2][q]).plus(f[1][q].times(f[2][p]), -1.0);
        f[0][k].times(minor)
    })];
    for (i, j) in (0..9).map(|at| (at / 3, at % 3)) {
        let whole = sum(&|k| weighed(gram(i, k).times(f[k][j]), k));
        equations.push(whole.plus(whole, 1.0).plus(trace.times(f[i][j]), -1.0));
    }
    let part = |power: usize| Mat::from_fn(10, 10, |i, j| equations[i].0[j][power]);
    problem("relative_pose_6pt", part(2), part(1), part(0))
}
