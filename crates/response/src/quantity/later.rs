//! Whether a motion stays within bands for all time after an instant.
//!
//! What may still come is bounded by the amplitudes of the modes, whatever their phases, or of a passive system by its
//! energy: ½dᵀKd + ½vᵀMv of the distance d from rest does not grow, and (aᵀd)² ≤ aᵀK⁻¹a · dᵀKd. Where that is more than a
//! band, the motion is followed until it is less, or until it is seen outside.

use eigentone_digits::Lu;
use eigentone_modes::{Modes, Motion, System};
use faer::{Mat, c64};

use super::extrema::{Band, Watch, last_place};
use super::persistence::{Parts, Sustained, pair, sustained, swing};
use crate::certified::follow::{Digits, Follower, Stretch};
use crate::problem::{MAX_STEPS, Problem, Source, rest};

/// Along so many spans of time, each twice as long as the one before, a motion is followed.
const SPANS: u32 = 10;
/// So many products each span may take, a tenth of a second.
const PRODUCTS: f64 = 5e7;
/// Amplitudes are those of modes only where dividing by what distinguishes shapes costs no more than this.
const CONDITION: f64 = 1e10;

/// Whether what has a band stays within it from the instant `step` of the grid on, where displacements and velocities are
/// `x` and `v` and it is within, under all loads to come; `None` where that is not known, and without a band. Bands are those
/// of [`last_outside`](super::extrema::last_outside), `ranges` those of what is followed.
pub(crate) fn stays(
    mut follower: Follower<'_, '_>,
    modes: &Modes,
    step: u64,
    (mut x, mut v): (Vec<f64>, Vec<f64>),
    (ranges, digits): (&[f64], Digits),
    bands: &[Option<Band>],
) -> Vec<Option<bool>> {
    let problem = follower.problem();
    let effort = (digits, PRODUCTS);
    let n = problem.system().len();
    let mut answers = vec![None; bands.len()];
    let mut open: Vec<(usize, Band)> = bands.iter().enumerate().flat_map(band_of).collect();
    let beside = bands.len().saturating_sub(problem.sources().len());
    let source = |i: usize| match i.checked_sub(beside.max(n)) {
        Some(place) => problem.sources()[place].clone(),
        None => {
            let mut own = Source::default();
            own.terms[0].push((i, [1.0; 2]));
            own
        }
    };
    let of = |stretch: &Stretch<'_>| {
        let state = |of: &dyn Fn(usize) -> f64| (0..n).map(of).collect::<Vec<f64>>();
        let right = stretch.right;
        (state(&|i| right.x(i)), state(&|i| right.v(i)))
    };
    if digits == Digits::Twice && !open.is_empty() {
        // Those given have a bound that is common to all coordinates.
        let ends = &mut |stretch: &mut Stretch<'_>| (x, v) = of(stretch);
        if follower
            .follow(step, ranges.to_vec(), effort, ends)
            .is_none()
        {
            return answers;
        }
    }
    let mut now = step;
    for span in 0..=SPANS {
        let longer = problem.until(now);
        let time = longer.grid().time(now);
        if time >= problem.last_change() {
            let left = Left::of(&longer, modes, time, (&x, &v));
            open.retain(|(i, band)| {
                let stays = left.keeps(&source(*i), band.half_width);
                if stays {
                    answers[*i] = Some(true);
                }
                !stays
            });
        }
        if open.is_empty() || span == SPANS {
            break;
        }
        let from = now;
        now = now.saturating_add((step / 16).max(1) << span);
        if now > MAX_STEPS || !problem.grid().time(now).is_finite() {
            break;
        }
        let longer = problem.until(now);
        let mut watched = vec![None; bands.len()];
        open.iter().for_each(|(i, band)| watched[*i] = Some(*band));
        let mut ended = None;
        let see = |stretch: &Stretch<'_>| {
            open.retain(|(i, band)| {
                let outside = last_place(stretch, *i, band).is_some();
                if outside {
                    answers[*i] = Some(false);
                }
                !outside
            });
            if stretch.length == 0.0 {
                ended = Some(of(stretch));
            }
        };
        let bands = &watched;
        let mut longer_follower = follower.until(&longer);
        let watch = &mut Watch { bands, see };
        let followed = longer_follower.follow(from, ranges.to_vec(), effort, watch);
        follower = longer_follower.until(problem);
        let Some(state) = followed.and(ended) else {
            break;
        };
        (x, v) = state;
    }
    answers
}

fn band_of((i, band): (usize, &Option<Band>)) -> Option<(usize, Band)> {
    Some((i, (*band)?))
}

/// What may still come of a motion under loads that do not change any more.
struct Left {
    /// Rates, and amplitudes of all coordinates with them: of modes, and of sinusoidal loads.
    swings: Option<Vec<(c64, Vec<c64>)>>,
    energy: Option<Energy>,
}

/// The energy of a motion about its rest, where it does not grow.
struct Energy {
    /// The square root of twice that, in √J.
    size: f64,
    damping: Mat<f64>,
    stiffness: Mat<f64>,
    factors_of_mass: Lu<f64>,
    factors_of_stiffness: Lu<f64>,
}

impl Left {
    fn of(problem: &Problem<'_>, modes: &Modes, time: f64, state: (&[f64], &[f64])) -> Left {
        let system = problem.system();
        let loads = sustained(problem, time);
        Left {
            swings: swings(system, modes, state, &loads),
            energy: Energy::of(system, state, &loads),
        }
    }

    /// Whether a sum stays so near its end.
    fn keeps(&self, source: &Source, half_width: f64) -> bool {
        let by_modes = self.swings.as_ref().is_some_and(|swings| {
            let parts = swings.iter().map(|(rate, of)| along(source, *rate, of));
            parts.sum::<f64>() <= half_width
        });
        let by_energy = || {
            let energy = self.energy.as_ref();
            energy.is_some_and(|energy| energy.reach(source) <= half_width)
        };
        by_modes || by_energy()
    }
}

impl Energy {
    /// ½dᵀKd + ½vᵀMv about the rest under constant loads, of a passive system that springs hold.
    fn of(system: &System, (x, v): (&[f64], &[f64]), loads: &Sustained) -> Option<Energy> {
        let structure = system.structure();
        let decays = structure.is_passive() && structure.is_symmetric();
        let is_held = structure.zero_roots() == Some(0);
        let is_constant = loads.harmonics.is_empty() && loads.rate.iter().all(|rate| *rate == 0.0);
        if !(decays && is_held && is_constant) {
            return None;
        }
        let rest = match loads.force.iter().all(|force| *force == 0.0) {
            true => vec![0.0; x.len()],
            false => rest(system, &loads.force)?,
        };
        let distance = Mat::from_fn(x.len(), 1, |i, _| x[i] - rest[i]);
        let velocity = Mat::from_fn(v.len(), 1, |i, _| v[i]);
        let (mass, stiffness) = (system.mass_matrix(), system.stiffness_matrix());
        let twice = form(&stiffness, &distance) + form(&mass, &velocity);
        Some(Energy {
            size: twice.sqrt(),
            damping: system.damping_matrix(),
            factors_of_mass: Lu::of(mass.as_ref()),
            factors_of_stiffness: Lu::of(stiffness.as_ref()),
            stiffness,
        })
    }

    /// How far it can still move a sum of displacements, of velocities and, Ma = −Kd − Cv, of accelerations. Infinite or NaN
    /// where M does not resist.
    fn reach(&self, source: &Source) -> f64 {
        let n = self.stiffness.nrows();
        let [x, v, a] = [0, 1, 2].map(|order| {
            let mut row = Mat::<f64>::zeros(n, 1);
            // Supports are at rest.
            let own = source.terms[order].iter().filter(|(i, _)| *i < n);
            own.for_each(|(i, [a, b])| row[(*i, 0)] += a * b);
            row
        });
        let through = |row: &Mat<f64>, factors: &Lu<f64>| {
            (row.transpose() * factors.solve(row.clone()))[(0, 0)]
                .abs()
                .sqrt()
        };
        let mut reach = 0.0;
        if x.norm_max() > 0.0 {
            reach += through(&x, &self.factors_of_stiffness);
        }
        if v.norm_max() > 0.0 {
            reach += through(&v, &self.factors_of_mass);
        }
        if a.norm_max() > 0.0 {
            let pushed = self.factors_of_mass.solve(a);
            let dragged = &self.damping * &pushed;
            reach += form(&self.stiffness, &pushed).sqrt();
            reach += through(&dragged, &self.factors_of_mass);
        }
        self.size * reach
    }
}

/// The quadratic form of a matrix that is not negative.
fn form(matrix: &Mat<f64>, of: &Mat<f64>) -> f64 {
    (of.transpose() * matrix * of)[(0, 0)].abs()
}

/// |Σ factor·rateᵏ·amplitude|, k the order of the derivative.
fn along(source: &Source, rate: c64, amplitudes: &[c64]) -> f64 {
    let mut sum = c64::new(0.0, 0.0);
    let mut power = c64::new(1.0, 0.0);
    for terms in &source.terms {
        for (i, [a, b]) in terms {
            // Supports are at rest.
            if let Some(amplitude) = amplitudes.get(*i) {
                sum += power * *amplitude * (a * b);
            }
        }
        power *= rate;
    }
    sum.norm()
}

/// The free motion by modes and what sinusoidal loads keep up. Rigid motions are part of where the end is, and what grows is
/// not there where an end is. `None` where modes are not all known, or not as many as roots.
fn swings(
    system: &System,
    modes: &Modes,
    state: (&[f64], &[f64]),
    loads: &Sustained,
) -> Option<Vec<(c64, Vec<c64>)>> {
    let moving = modes.iter().filter(|mode| mode.motion() != Motion::Rigid);
    let moving: Vec<_> = moving.collect();
    let are_known = moving
        .iter()
        .all(|mode| mode.roots() == 1 && mode.motion() != Motion::Doubtful);
    if !are_known {
        return None;
    }
    let n = system.len();
    let mut swings = Vec::new();
    if let Some(parts) = Parts::of(system, &moving, state, loads) {
        let count = moving.len();
        let inverse = Lu::of(parts.gram.as_ref()).solve(Mat::identity(count, count));
        let weight = |k: usize| parts.sizes[k].sqrt();
        let most = (0..count).flat_map(|i| (0..count).map(move |j| (i, j)));
        let mut most = most.map(|(i, j)| inverse[(i, j)].norm() * weight(i) * weight(j));
        if !most.all(|size| size <= CONDITION) {
            return None;
        }
        let amplitudes = inverse * &parts.free;
        for (k, mode) in moving.iter().enumerate() {
            if mode.motion() == Motion::Growing {
                continue;
            }
            let factor = amplitudes[(k, 0)] * pair(parts.roots[k]);
            let of = (0..n).map(|i| parts.right[(i, k)] * factor).collect();
            swings.push((parts.roots[k], of));
        }
    }
    for load in &loads.harmonics {
        let motion = swing(system, load);
        let of = (0..n).map(|i| motion[(i, 0)]).collect();
        swings.push((c64::new(0.0, load.1.frequency), of));
    }
    Some(swings)
}
