//! The part of a motion that never dies out: modes with Re λ ≥ 0, and what sustained loads keep up.
//!
//! The left and right shapes y, x of the roots are biorthogonal in the pencil's linear form,
//! y_iᵀ((λ_i + λ_j)M + C)x_j = 0 for λ_i ≠ λ_j (Tisseur & Meerbergen 2001, *SIAM Rev.* 43, section
//! 3). So c = yᵀ((λM + C)x + Mv) obeys c′ = λc + yᵀf by itself, whatever else moves.

use eigentone_digits::{DoubleDouble, Lu, svd};
use eigentone_modes::{Mode, Modes, Motion, System};
use faer::{Mat, MatRef, c64};

use crate::problem::{Harmonic, Instant, Problem, reduced_angle};

/// Loads as they go on from an instant, in N, N/s and as sinusoids.
#[derive(Clone, Debug)]
pub(crate) struct Sustained {
    /// In s, as it is before it is rounded to a double.
    pub(crate) time: DoubleDouble,
    pub(crate) force: Vec<f64>,
    pub(crate) rate: Vec<f64>,
    pub(crate) harmonics: Vec<(usize, Harmonic)>,
}

/// The loads as they are at time `t` and go on.
pub(super) fn sustained(problem: &Problem<'_>, t: f64) -> Sustained {
    let n = problem.system().len();
    let pieces = problem.timeline().pieces();
    let latest = pieces.iter().rposition(|piece| piece.start() <= t);
    let latest = latest.unwrap_or(0);
    let [mut force, mut rate, ..] = problem.steady(latest, t, false);
    let straight = pieces[latest].straight().iter();
    for straight in straight.filter(|straight| straight.coordinate < n) {
        let elapsed = t - pieces[latest].start();
        force[straight.coordinate] += straight.value + straight.slope * elapsed;
        rate[straight.coordinate] += straight.slope;
    }
    let turning = |load: &Harmonic| load.frequency != 0.0;
    let sinusoids = problem.sinusoids().into_iter();
    let (harmonics, still): (Vec<_>, Vec<_>) = sinusoids.partition(|(_, load)| turning(load));
    for (coordinate, load) in still {
        force[coordinate] += load.amplitude * load.phase.sin();
    }
    Sustained {
        time: Instant::event(problem.grid(), t).time,
        force,
        rate,
        harmonics,
    }
}

/// For each coordinate, the amplitude in m of what goes on for ever.
#[derive(Clone, Debug)]
pub(crate) struct Persistence {
    /// By undamped modes and by sinusoidal loads.
    pub(crate) oscillation: Vec<f64>,
    /// By growing modes, and by what sinusoidal loads in resonance with undamped ones have built up
    /// so far.
    pub(crate) growth: Vec<f64>,
}

impl Persistence {
    /// For the motion that passes through the displacements `x` and velocities `v` while `loads`
    /// act.
    pub(crate) fn of(
        system: &System,
        modes: &Modes,
        (x, v): (&[f64], &[f64]),
        loads: &Sustained,
    ) -> Persistence {
        let n = system.len();
        let mut persistence = Persistence {
            oscillation: vec![0.0; n],
            growth: vec![0.0; n],
        };
        let lasting: Vec<&Mode> = modes
            .iter()
            .filter(|mode| is_steady(mode) || mode.motion() == Motion::Growing)
            .collect();
        persistence.add_modes(system, &lasting, (x, v), loads);
        persistence.add_sinusoids(system, loads);
        persistence
    }

    fn add_modes(
        &mut self,
        system: &System,
        lasting: &[&Mode],
        (x, v): (&[f64], &[f64]),
        loads: &Sustained,
    ) {
        let Some(parts) = Parts::of(system, lasting, (x, v), loads) else {
            return;
        };
        let amplitudes = Lu::of(parts.gram.as_ref()).solve(parts.free);
        for (k, mode) in lasting.iter().enumerate() {
            let grows = !is_steady(mode) || mode.roots() > 1;
            for i in 0..system.len() {
                // A pair moves with both of its roots.
                let pair = pair(parts.roots[k]);
                let amplitude = pair * (parts.right[(i, k)] * amplitudes[(k, 0)]).norm();
                let into = if grows {
                    &mut self.growth
                } else {
                    &mut self.oscillation
                };
                into[i] += amplitude;
                self.growth[i] += pair * (parts.right[(i, k)] * amplitudes[(k, 1)]).norm();
            }
        }
    }

    fn add_sinusoids(&mut self, system: &System, loads: &Sustained) {
        for load in &loads.harmonics {
            let motion = swing(system, load);
            for i in 0..system.len() {
                self.oscillation[i] += motion[(i, 0)].norm();
            }
        }
    }
}

/// What single modes have of a motion.
pub(super) struct Parts {
    pub(super) roots: Vec<c64>,
    /// Their shapes, as columns.
    pub(super) right: Mat<c64>,
    /// The linear form of left and right shapes.
    pub(super) gram: Mat<c64>,
    /// Of each diagonal entry, the sizes of what it is the sum of.
    pub(super) sizes: Vec<f64>,
    /// What moves freely, and what a resonance has built up: `gram` times the amplitudes.
    pub(super) free: Mat<c64>,
}

impl Parts {
    /// Those that modes other than rigid ones have in the motion through `x` and `v` while `loads` act. `None` without modes.
    pub(super) fn of(
        system: &System,
        modes: &[&Mode],
        (x, v): (&[f64], &[f64]),
        loads: &Sustained,
    ) -> Option<Parts> {
        let (n, count) = (system.len(), modes.len());
        if count == 0 {
            return None;
        }
        let (mass, damping) = (system.mass_matrix(), system.damping_matrix());
        let roots: Vec<c64> = modes.iter().map(|mode| mode.eigenvalue().value).collect();
        let right = Mat::from_fn(n, count, |i, k| modes[k].shape()[i]);
        let left = if system.structure().is_symmetric() {
            right.clone()
        } else {
            let left: Vec<Vec<c64>> = modes.iter().map(|mode| left_shape(system, mode)).collect();
            Mat::from_fn(n, count, |i, k| left[k][i])
        };
        let (mass_x, damping_x) = (
            apply(&mass, right.as_ref()),
            apply(&damping, right.as_ref()),
        );
        let size = |k: usize, images: &Mat<c64>| -> f64 {
            let parts = (0..n).map(|i| left[(i, k)].norm() * images[(i, k)].norm());
            parts.sum()
        };
        let size = |k: usize| 2.0 * roots[k].norm() * size(k, &mass_x) + size(k, &damping_x);
        let sizes = (0..count).map(size).collect();
        let products = (left.transpose() * mass_x, left.transpose() * damping_x);
        let mut gram = Mat::from_fn(count, count, |i, j| {
            (roots[i] + roots[j]) * products.0[(i, j)] + products.1[(i, j)]
        });
        let state = |i: usize| (c64::from(x[i]), c64::from(v[i]));
        let column = Mat::from_fn(n, 2, |i, j| if j == 0 { state(i).0 } else { state(i).1 });
        let (mass_state, damping_state) = (
            apply(&mass, column.as_ref()),
            apply(&damping, column.as_ref()),
        );
        let mut free = Mat::<c64>::zeros(count, 2);
        for k in 0..count {
            let root = roots[k];
            let along =
                |f: &dyn Fn(usize) -> c64| -> c64 { (0..n).map(|i| left[(i, k)] * f(i)).sum() };
            let total =
                along(&|i| root * mass_state[(i, 0)] + damping_state[(i, 0)] + mass_state[(i, 1)]);
            let mut forced =
                -along(&|i| c64::from(loads.force[i]) / root + loads.rate[i] / (root * root));
            for (coordinate, load) in &loads.harmonics {
                let omega = c64::new(0.0, load.frequency);
                let angle = reduced_angle(load.frequency, loads.time, load.phase);
                let phase = c64::new(0.0, angle);
                let force = left[(*coordinate, k)] * load.amplitude / c64::new(0.0, 2.0);
                for (omega, phase, sign) in [(omega, phase, 1.0), (-omega, -phase, -1.0)] {
                    if (omega - root).norm() <= RESONANCE * root.norm() {
                        free[(k, 1)] += force.norm() * loads.time.to_f64();
                    } else {
                        forced += sign * force * phase.exp() / (omega - root);
                    }
                }
            }
            free[(k, 0)] = total - forced;
            if modes[k].roots() > 1 {
                // It has no amplitude of its own: where it is stirred at all, it grows.
                gram[(k, k)] = c64::from(1.0);
                (0..count).filter(|&j| j != k).for_each(|j| {
                    gram[(k, j)] = c64::from(0.0);
                    gram[(j, k)] = c64::from(0.0);
                });
            }
        }
        Some(Parts {
            roots,
            right,
            gram,
            sizes,
            free,
        })
    }
}

/// A pair moves with both of its roots.
pub(super) fn pair(root: c64) -> f64 {
    if root.im == 0.0 { 1.0 } else { 2.0 }
}

/// The steady motion under a sinusoidal load: (K − Ω²M + iΩC) X = F.
pub(super) fn swing(system: &System, (coordinate, load): &(usize, Harmonic)) -> Mat<c64> {
    let n = system.len();
    let (mass, damping) = (system.mass_matrix(), system.damping_matrix());
    let stiffness = system.stiffness_matrix();
    // Beside a resonance, where the answer has the same zeros.
    let omega = load.frequency * (1.0 + RESONANCE);
    let dynamic = Mat::from_fn(n, n, |i, j| {
        let real = stiffness[(i, j)] - omega * omega * mass[(i, j)];
        c64::new(real, omega * damping[(i, j)])
    });
    let mut amplitude = Mat::<c64>::zeros(n, 1);
    amplitude[(*coordinate, 0)] = c64::from(load.amplitude);
    Lu::of(dynamic.as_ref()).solve(amplitude)
}

/// How close, relatively, a load's frequency must be to an undamped mode's to be its own: beyond
/// this, beats of finite amplitude are distinguished from growth in doubles.
const RESONANCE: f64 = 1e-12;

/// Whether a mode neither decays nor grows, as far as can be determined: its real part is within its
/// bound, and so small that 10^12 radians would pass before it showed. Rigid ones are not meant.
fn is_steady(mode: &Mode) -> bool {
    let root = mode.eigenvalue();
    let bound = root.real_bound.unwrap_or(f64::INFINITY);
    root.value.im != 0.0 && root.value.re.abs() <= bound.min(1e-12 * root.value.norm())
}

/// y with yᵀQ(λ) = 0.
fn left_shape(system: &System, mode: &Mode) -> Vec<c64> {
    if let Some(shape) = mode.left_shape() {
        return shape.iter().map(|entry| entry.conj()).collect();
    }
    // At a defective root: the direction that Q(λ) reaches least.
    let root = mode.eigenvalue().value;
    let (mass, damping) = (system.mass_matrix(), system.damping_matrix());
    let stiffness = system.stiffness_matrix();
    let n = system.len();
    let q = Mat::from_fn(n, n, |i, j| {
        root * root * mass[(i, j)] + root * damping[(i, j)] + stiffness[(i, j)]
    });
    let Some(svd) = svd(q.as_ref()) else {
        return mode.shape().to_vec();
    };
    let least: Vec<c64> = (0..n).map(|i| svd.U()[(i, n - 1)].conj()).collect();
    let size = least
        .iter()
        .fold(0.0f64, |top, entry| top.max(entry.norm()));
    least.iter().map(|entry| entry / size).collect()
}

/// A real matrix times complex columns.
fn apply(matrix: &Mat<f64>, columns: MatRef<'_, c64>) -> Mat<c64> {
    let part = |take: fn(&c64) -> f64| {
        matrix
            * Mat::from_fn(columns.nrows(), columns.ncols(), |i, j| {
                take(&columns[(i, j)])
            })
    };
    let (re, im) = (part(|z| z.re), part(|z| z.im));
    Mat::from_fn(columns.nrows(), columns.ncols(), |i, j| {
        c64::new(re[(i, j)], im[(i, j)])
    })
}
