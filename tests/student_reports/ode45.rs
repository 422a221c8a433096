//! The explicit pair of order 5(4) of Dormand & Prince (1980, *J. Comput. Appl. Math.* 6) with the step
//! control, the first step and the dense output that ode45 of the MATLAB ODE suite documents (Shampine &
//! Reichelt 1997, *SIAM J. Sci. Comput.* 18): every component of the local error within
//! max(RelTol·|y|, AbsTol), and three interpolated points in each step (`Refine` = 4).

/// Its tolerances; those of [`DEFAULT`] unless set otherwise.
#[derive(Clone, Copy, Debug)]
pub struct Tolerances {
    pub relative: f64,
    pub absolute: f64,
}

pub const DEFAULT: Tolerances = Tolerances {
    relative: 1e-3,
    absolute: 1e-6,
};

/// What it returns: instants and states, four for each step after the first.
#[derive(Clone, Debug, Default)]
pub struct Solution {
    pub times: Vec<f64>,
    pub states: Vec<Vec<f64>>,
    pub steps: usize,
    pub failed: usize,
}

const STAGES: usize = 7;

const A: [[f64; 6]; STAGES] = [
    [0.0; 6],
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
        0.0,
        0.0,
    ],
    [
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
        0.0,
    ],
    // The weights of order 5: the last stage is the first of the next step.
    [
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];

/// Weights of order 4.
const B4: [f64; STAGES] = [
    5179.0 / 57600.0,
    0.0,
    7571.0 / 16695.0,
    393.0 / 640.0,
    -92097.0 / 339200.0,
    187.0 / 2100.0,
    1.0 / 40.0,
];

/// Weights of the fourth-order interpolant, by rising powers of the fraction of the step from 1 on.
const DENSE: [[f64; 4]; STAGES] = [
    [1.0, -183.0 / 64.0, 37.0 / 12.0, -145.0 / 128.0],
    [0.0; 4],
    [0.0, 1500.0 / 371.0, -1000.0 / 159.0, 1000.0 / 371.0],
    [0.0, -125.0 / 32.0, 125.0 / 12.0, -375.0 / 64.0],
    [0.0, 9477.0 / 3392.0, -729.0 / 106.0, 25515.0 / 6784.0],
    [0.0, -11.0 / 7.0, 11.0 / 3.0, -55.0 / 28.0],
    [0.0, 3.0 / 2.0, -4.0, 5.0 / 2.0],
];

/// Integrates y′ = f(y) from 0 to `end`.
pub fn solve(
    f: impl Fn(&[f64]) -> Vec<f64>,
    start: &[f64],
    end: f64,
    tolerances: Tolerances,
) -> Solution {
    let Tolerances { relative, absolute } = tolerances;
    let threshold = absolute / relative;
    let longest = 0.1 * end;
    let (mut t, mut y) = (0.0, start.to_vec());
    let mut slope = f(&y);
    let rates = slope
        .iter()
        .zip(&y)
        .map(|(f, y)| f.abs() / y.abs().max(threshold));
    let rate = rates.fold(0.0, f64::max) / (0.8 * relative.powf(0.2));
    let mut step = if longest * rate > 1.0 {
        1.0 / rate
    } else {
        longest
    };
    let mut solution = Solution::default();
    solution.times.push(t);
    solution.states.push(y.clone());
    while t < end {
        step = step.min(longest);
        let mut failed = false;
        let (stages, next, error) = loop {
            if 1.1 * step >= end - t {
                step = end - t;
            }
            let (stages, next, error) = attempt(&f, &y, &slope, step, threshold);
            if error <= relative {
                break (stages, next, error);
            }
            solution.failed += 1;
            step *= match failed {
                false => (0.8 * (relative / error).powf(0.2)).max(0.1),
                true => 0.5,
            };
            failed = true;
        };
        let arrived = if step == end - t { end } else { t + step };
        for quarter in 1..4 {
            let s = f64::from(quarter) / 4.0;
            solution.times.push(t + s * step);
            solution.states.push(between(&y, &stages, step, s));
        }
        solution.times.push(arrived);
        solution.states.push(next.clone());
        solution.steps += 1;
        (t, y) = (arrived, next);
        slope = stages[STAGES - 1].clone();
        if !failed {
            step /= (1.25 * (error / relative).powf(0.2)).max(0.2);
        }
    }
    solution
}

/// The stages of a step, the state after it, and its largest error in units of each component.
fn attempt(
    f: &impl Fn(&[f64]) -> Vec<f64>,
    y: &[f64],
    slope: &[f64],
    step: f64,
    threshold: f64,
) -> (Vec<Vec<f64>>, Vec<f64>, f64) {
    let mut stages = vec![slope.to_vec()];
    let mut next = y.to_vec();
    for weights in &A[1..] {
        next = y.to_vec();
        for (stage, weight) in stages.iter().zip(weights) {
            next.iter_mut()
                .zip(stage)
                .for_each(|(next, k)| *next += step * weight * k);
        }
        stages.push(f(&next));
    }
    let error = (0..y.len()).map(|i| {
        let fifth = |stage: usize| if stage < 6 { A[6][stage] } else { 0.0 };
        let parts = stages
            .iter()
            .enumerate()
            .map(|(j, k)| (fifth(j) - B4[j]) * k[i]);
        step * parts.sum::<f64>().abs() / y[i].abs().max(next[i].abs()).max(threshold)
    });
    let error = error.fold(0.0, f64::max);
    (stages, next, error)
}

/// The state at a fraction of the step.
fn between(y: &[f64], stages: &[Vec<f64>], step: f64, s: f64) -> Vec<f64> {
    let weight = |weights: &[f64; 4]| weights.iter().rev().fold(0.0, |sum, w| (sum + w) * s);
    let mut state = y.to_vec();
    for (stage, weights) in stages.iter().zip(&DENSE) {
        let weight = step * weight(weights);
        state
            .iter_mut()
            .zip(stage)
            .for_each(|(state, k)| *state += weight * k);
    }
    state
}

#[test]
fn it_is_of_order_five_between_too() {
    // y″ = −y from 1: cos t.
    let f = |y: &[f64]| vec![y[1], -y[0]];
    let worst = |relative: f64| {
        let tolerances = Tolerances {
            relative,
            absolute: 1e-3 * relative,
        };
        let solution = solve(f, &[1.0, 0.0], 10.0, tolerances);
        let off = solution
            .times
            .iter()
            .zip(&solution.states)
            .map(|(t, y)| (y[0] - t.cos()).abs());
        (off.fold(0.0, f64::max), solution.steps as f64)
    };
    let ((coarse, few), (fine, many)) = (worst(1e-6), worst(1e-9));
    let order = (coarse / fine).ln() / (many / few).ln();
    assert!((4.0..6.0).contains(&order), "{order}");
    assert!(fine < 1e-7);
}
