//! Motions of finite-element matrices of more than 64 coordinates, against 600-digit exponentials of the matrices as given.

use eigentone_modes::{Bounds, MatrixKind, Precision, System};
use eigentone_response::{Response, State, Trajectory};
use faer::Mat;

/// So many elements of a beam.
const ELEMENTS: usize = 33;
/// The length of each, in m.
const LENGTH: f64 = 0.0625;
/// Bending stiffness in N m², mass in kg/m, and the dashpot at the tip in N s/m.
const BENDING: f64 = 1500.0;
const MASS: f64 = 3.1;
const DASHPOT: f64 = 3.0;
/// In s.
const STEP: f64 = 0.0078125;
const LAST: u64 = 64;

/// An Euler–Bernoulli beam with consistent mass, clamped at its first end or free.
fn beam(is_clamped: bool) -> System {
    let h = LENGTH;
    let a = BENDING / (h * h * h);
    let k = [
        [a * 12.0, a * 6.0 * h, -a * 12.0, a * 6.0 * h],
        [a * 6.0 * h, a * 4.0 * h * h, -a * 6.0 * h, a * 2.0 * h * h],
        [-a * 12.0, -a * 6.0 * h, a * 12.0, -a * 6.0 * h],
        [a * 6.0 * h, a * 2.0 * h * h, -a * 6.0 * h, a * 4.0 * h * h],
    ];
    let u = MASS * h / 420.0;
    let m = [
        [u * 156.0, u * 22.0 * h, u * 54.0, -u * 13.0 * h],
        [
            u * 22.0 * h,
            u * 4.0 * h * h,
            u * 13.0 * h,
            -u * 3.0 * h * h,
        ],
        [u * 54.0, u * 13.0 * h, u * 156.0, -u * 22.0 * h],
        [
            -u * 13.0 * h,
            -u * 3.0 * h * h,
            -u * 22.0 * h,
            u * 4.0 * h * h,
        ],
    ];
    let n = 2 * (ELEMENTS + 1);
    let assembled = |element: &[[f64; 4]; 4]| {
        let mut sum = Mat::<f64>::zeros(n, n);
        for first in (0..n - 2).step_by(2) {
            for (i, row) in element.iter().enumerate() {
                for (j, entry) in row.iter().enumerate() {
                    sum[(first + i, first + j)] += entry;
                }
            }
        }
        sum
    };
    let mut damping = Mat::<f64>::zeros(n, n);
    damping[(n - 2, n - 2)] = DASHPOT;
    let held = if is_clamped { 2 } else { 0 };
    let mut builder = System::builder();
    for i in held..n {
        builder = builder.mass(format!("x{i}"), 0.0);
    }
    for (kind, matrix) in [
        (MatrixKind::Mass, assembled(&m)),
        (MatrixKind::Damping, damping),
        (MatrixKind::Stiffness, assembled(&k)),
    ] {
        builder = builder.matrix(kind, matrix.submatrix(held, held, n - held, n - held));
    }
    builder.build().expect("a beam")
}

/// Its motion after the deflection of the tip got a velocity of 1 m/s.
fn motion(system: &System, precision: Precision) -> Trajectory {
    let tip = &system.names()[system.len() - 2];
    Response::of(system)
        .from(State::at_rest().push(tip, 1.0))
        .every(STEP)
        .until(STEP * LAST as f64)
        .to(precision)
        .run()
        .expect("a motion")
}

/// Displacements and then velocities of some steps.
fn truth(text: &str) -> Vec<(usize, Vec<f64>)> {
    let numbers = |line: &str| {
        let mut words = line.split_whitespace();
        let step = words.next().expect("a step").parse().expect("a number");
        let values = words.map(|word| word.parse().expect("a number"));
        (step, values.collect())
    };
    text.lines().map(numbers).collect()
}

const BEAMS: [(bool, &str); 2] = [
    (true, include_str!("clamped.txt")),
    (false, include_str!("free.txt")),
];

/// The largest error and bound of displacements and of velocities at a step, over the largest of them.
fn errors(motion: &Trajectory, step: usize, values: &[f64]) -> [(f64, Option<f64>); 2] {
    let n = motion.displacement().nrows();
    [
        (
            motion.displacement(),
            motion.displacement_bound(),
            &values[..n],
        ),
        (motion.velocity(), motion.velocity_bound(), &values[n..]),
    ]
    .map(|(found, bounds, known)| {
        let largest = known.iter().fold(0.0f64, |a, b| a.max(b.abs()));
        let off = (0..n).map(|i| {
            // The truth is rounded to a double too.
            (found[(i, step)] - known[i]).abs() - known[i].abs() * f64::EPSILON / 2.0
        });
        (
            off.fold(0.0, f64::max) / largest,
            bounds[step].map(|bound| bound / largest),
        )
    })
}

#[test]
fn motions_of_beams_are_proven() {
    for (is_clamped, text) in BEAMS {
        let system = beam(is_clamped);
        let motion = motion(&system, Precision::default());
        assert_eq!(motion.bounds(), Bounds::Proven);
        for (step, values) in truth(text) {
            for (error, bound) in errors(&motion, step, &values) {
                let bound = bound.expect("a proven bound");
                assert!(error <= bound, "{error:e} > {bound:e}");
                assert!(bound < 1e-13, "{bound:e}");
            }
        }
    }
}

#[test]
fn motions_of_beams_in_doubles_are_right_or_doubtful() {
    for (is_clamped, text) in BEAMS {
        let system = beam(is_clamped);
        let motion = motion(&system, Precision::Double);
        for (step, values) in truth(text) {
            for (error, bound) in errors(&motion, step, &values) {
                assert!(
                    bound.is_none_or(|bound| error <= bound),
                    "{error:e} > {bound:?}"
                );
                assert!(bound.is_some() || motion.is_doubtful(step));
            }
        }
        // Nothing holds the free one.
        assert_eq!(motion.doubtful() == 0, is_clamped);
    }
}
