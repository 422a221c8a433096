//! The response by some of the modes alone, with the others following the loads without inertia.
//!
//! x(t) = Φ q(t) + R f(t): the amplitudes q of the shapes Φ that are kept move exactly, by any of the exact
//! methods on the reduced equation; the residual flexibility R = K⁻¹ − ΦΩ⁻²Φᵀ adds what the loads move
//! statically besides (mode acceleration; Cornwell, Craig & Johnson 1983, *Earthquake Eng. Struct. Dyn.*
//! 11; MacNeal 1971, *Comput. Struct.* 1).
//!
//! What is left out is bounded where the system is passive and its damping couples no shapes. For a mode that
//! is not kept, with |b| its share of a load g(t), Duhamel's integral by parts gives
//! q − b g/ω² = −(b/ω²)∫ h dg with |h| ≤ 1 and |h′| ≤ ω, so that in the norms of K and M the
//! rest of x and v is at most TV(g)·√(bᵀRb), and a rest of the initial state keeps at most its energy. A
//! coordinate moves by √R_ii at most for xᵀKx = 1. What ω² of the modes that are kept may be off is counted, and so is
//! what their shapes may be: Φq leaves Σ (Kφ − ω²Mφ) q of the equation, and shapes that are not quite orthogonal take of a load
//! g other than its parts. Such forces act on the whole system, whose √(2E) grows by their size in the norm of M⁻¹ at most, and
//! which is moved by √(K⁻¹)_ii for xᵀKx = 1.

use eigentone_digits::DoubleDouble;
use eigentone_modes::{MatrixKind, SparseModes, System};
use faer::Mat;

use super::choice::ResponsePlan;
use crate::answer::{BUDGET, Trajectory};
use crate::problem::{AppliedLoad, Instant, Load, Polynomial, Problem, ResponseError, State};

/// The response of large systems by so many modes of the smallest frequencies. Its
/// [bounds](Trajectory::displacement_bound) are estimates of what the other modes add, where they can be
/// given; velocities have no static correction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModalTruncation {
    /// How many modes are kept; all where there are not so many.
    pub modes: usize,
}

impl ModalTruncation {
    /// The motion at the instants asked for.
    ///
    /// # Errors
    /// [`ResponseError::Sparse`] where the modes cannot be computed, [`ResponseError::NotApplicable`] where
    /// more is asked for than displacements and velocities, a load acts at a point or is a polynomial, a support moves or no
    /// residual flexibility exists, and what the reduced equation reports.
    pub fn run(&self, problem: &Problem<'_>) -> Result<Trajectory, ResponseError> {
        if problem.wants_acceleration() || !problem.sources().is_empty() {
            let kept = "it gives displacements and velocities alone: leave accelerations, outputs and forces out, or superpose all modes";
            return Err(refusal(kept.to_owned()));
        }
        if !problem.channels().is_empty() {
            let reason =
                "loads at points, polynomials and motions of supports have no static correction";
            return Err(refusal(reason.to_owned()));
        }
        admit(problem)?;
        let modes = SparseModes::lowest(problem.system(), self.modes)?;
        let reduced = modes.reduced()?;
        let kept = Kept::of(problem, &modes)?;
        let mut small = Problem::new(&reduced, &kept.state, kept.loads(problem), *problem.grid())?
            .to(problem.precision());
        if let Some(instants) = problem.instants() {
            small = small.at(instants)?;
        }
        let motion = ResponsePlan::of(&small)?.run(&small)?;
        let shapes = modes.shapes();
        let mut displacement = shapes * motion.displacement();
        let velocity = shapes * motion.velocity();
        let rest = Rest::of(problem, &modes, &kept, &reduced)?;
        let mut largest = Amplitudes::new(modes.len());
        let (mut x_bounds, mut v_bounds) = (Vec::new(), Vec::new());
        for (column, &step) in motion.steps().iter().enumerate() {
            let instant = Instant::on_grid(problem.grid(), step);
            rest.follow(problem, &instant, &mut displacement, column);
            largest.meet(&modes, &motion, column);
            let [x, v] = rest.bounds(problem, &instant, &largest);
            let (x_drift, v_drift) = drift(&modes, &motion, column).unzip();
            let sum = |rest: Option<f64>, own: Option<f64>, drift: Option<f64>| {
                Some(rest? + (own? + drift?) * kept.largest)
            };
            x_bounds.push(sum(x, motion.displacement_bound()[column], x_drift));
            v_bounds.push(sum(v, motion.velocity_bound()[column], v_drift));
        }
        let (steps, times) = (motion.steps().to_vec(), motion.times().to_vec());
        Ok(Trajectory::new(NAME, steps, times, displacement, velocity)
            .with_names(problem.system().coordinate_names())
            .with_bounds(x_bounds, v_bounds)
            .after(motion.operations()))
    }
}

/// How far the amplitude of a mode and its rate are off by then because ω² is: by Duhamel's integral δω²·q acts as a
/// force, whose answer grows to δω²·|q|·t/ω at most. `None` where ω² is not known.
fn drift(modes: &SparseModes, motion: &Trajectory, column: usize) -> Option<(f64, f64)> {
    let t = motion.times()[column].abs();
    let (mut largest, mut fastest): (f64, f64) = (0.0, 0.0);
    let all = modes.squares().iter().zip(modes.square_bounds());
    for (k, (square, error)) in all.enumerate() {
        let error = (*error)?;
        let rate = square.abs().sqrt();
        let [q, v] = [motion.displacement(), motion.velocity()].map(|part| part[(k, column)]);
        // How long a force of then has acted with the same sign.
        let lasting = if rate * t > 1.0 { 1.0 / rate } else { t };
        let drift = error * q.hypot(v * lasting) * t * lasting;
        largest = largest.max(drift);
        fastest = fastest.max(drift * rate.max(1.0 / lasting.max(f64::MIN_POSITIVE)));
    }
    Some((largest, fastest)).filter(|(x, v)| x.is_finite() && v.is_finite())
}

/// The largest amplitudes of the modes until now, and of their rates.
struct Amplitudes {
    displacement: Vec<f64>,
    velocity: Vec<f64>,
}

impl Amplitudes {
    fn new(count: usize) -> Amplitudes {
        Amplitudes {
            displacement: vec![0.0; count],
            velocity: vec![0.0; count],
        }
    }

    fn meet(&mut self, modes: &SparseModes, motion: &Trajectory, column: usize) {
        let [q, rate] = [motion.displacement(), motion.velocity()];
        for (k, square) in modes.squares().iter().enumerate() {
            let (q, rate, omega) = (q[(k, column)], rate[(k, column)], square.abs().sqrt());
            // Between the instants it swings as far as its energy lets it.
            let swing = if omega > 0.0 { rate / omega } else { 0.0 };
            self.displacement[k] = self.displacement[k].max(q.hypot(swing));
            self.velocity[k] = self.velocity[k].max(rate.hypot(q * omega));
        }
    }
}

const NAME: &str = "modal truncation";

fn refusal(reason: String) -> ResponseError {
    ResponseError::NotApplicable {
        method: NAME,
        reason,
    }
}

/// Refuses answers that would take too much memory.
fn admit(problem: &Problem<'_>) -> Result<(), ResponseError> {
    let coordinates = problem.system().len();
    let instants = match problem.instants() {
        Some(instants) => instants.len() as u64,
        None => problem.grid().last() + 1,
    };
    let bytes = instants as f64 * coordinates as f64 * 16.0;
    if bytes <= BUDGET {
        return Ok(());
    }
    let (gigabytes, limit) = (bytes / 1e9, BUDGET / 1e9);
    Err(ResponseError::TooLarge {
        instants,
        coordinates,
        gigabytes,
        limit,
    })
}

/// What is kept of the initial state and the loads.
struct Kept {
    state: State,
    /// The rest of the initial displacements and velocities.
    rest: [Vec<f64>; 2],
    /// By mode, the shape at each load's coordinate.
    shares: Vec<Vec<f64>>,
    /// By how much an error of all amplitudes can move a coordinate.
    largest: f64,
}

impl Kept {
    fn of(problem: &Problem<'_>, modes: &SparseModes) -> Result<Kept, ResponseError> {
        let shapes = modes.shapes();
        let initial = [problem.initial_displacement(), problem.initial_velocity()];
        let mut amplitudes = [vec![0.0; modes.len()], vec![0.0; modes.len()]];
        let mut rest = initial.map(<[f64]>::to_vec);
        // Shapes that are not quite orthogonal leave something of them, which is taken out once more.
        for _ in 0..2 {
            for ((initial, amplitudes), rest) in initial.iter().zip(&mut amplitudes).zip(&mut rest)
            {
                let resisted = modes.mass_times(rest);
                for (k, amplitude) in amplitudes.iter_mut().enumerate() {
                    let terms = shapes.col(k).iter().zip(&resisted);
                    *amplitude += terms.map(|(x, y)| x * y).sum::<f64>();
                }
                for (i, rest) in rest.iter_mut().enumerate() {
                    let terms = amplitudes.iter().enumerate();
                    let terms = terms.map(|(k, q)| DoubleDouble::product(shapes[(i, k)], *q));
                    let start = DoubleDouble::from(initial[i]);
                    *rest = terms.fold(start, |sum, term| sum - term).to_f64();
                }
            }
        }
        let mut state = State::at_rest();
        let mut shares = Vec::new();
        let mut reach = vec![0.0; shapes.nrows()];
        let [displaced, pushed] = &amplitudes;
        for (k, (&x, &v)) in displaced.iter().zip(pushed).enumerate() {
            let shape = shapes.col(k);
            let name = format!("x{}", k + 1);
            state = state.displace(&name, x).push(&name, v);
            let loads = problem.loads().iter();
            shares.push(loads.map(|load| shape[load.coordinate]).collect());
            let pairs = reach.iter_mut().zip(shape.iter());
            pairs.for_each(|(reach, x)| *reach += x.abs());
        }
        Ok(Kept {
            state,
            rest,
            shares,
            largest: reach.into_iter().fold(0.0, f64::max),
        })
    }

    /// Each load on each mode.
    fn loads(&self, problem: &Problem<'_>) -> Vec<AppliedLoad> {
        let on = |(coordinate, shares): (usize, &Vec<f64>)| {
            let pairs = problem.loads().iter().zip(shares);
            let loads = pairs.filter(|(_, share)| **share != 0.0);
            let loads = loads.map(|(applied, share)| AppliedLoad {
                coordinate,
                load: scaled(&applied.load, *share),
            });
            loads.collect::<Vec<_>>()
        };
        self.shares.iter().enumerate().flat_map(on).collect()
    }
}

/// A load times a number.
fn scaled(load: &Load, factor: f64) -> Load {
    let mut load = load.clone();
    match &mut load {
        Load::Step(step) => step.force *= factor,
        Load::Ramp(ramp) => ramp.rate *= factor,
        Load::Impulse(impulse) => impulse.magnitude *= factor,
        Load::Harmonic(harmonic) => harmonic.amplitude *= factor,
        Load::Samples(samples) => samples.values.iter_mut().for_each(|value| *value *= factor),
        Load::HalfSine(pulse) => pulse.force *= factor,
        Load::Versine(pulse) => pulse.force *= factor,
        Load::Polynomial(Polynomial { coefficients, .. }) => {
            coefficients.iter_mut().for_each(|value| *value *= factor);
        }
    }
    load
}

/// What the modes that are not kept do.
struct Rest {
    /// Coordinates with loads, each once, and R e_c of each.
    loaded: Vec<(usize, Vec<f64>)>,
    limits: Option<Limits>,
}

/// What bounds them.
struct Limits {
    /// √(twice the energy) of the rest of the initial state.
    initial: f64,
    /// The largest √R_ii, and √((M⁻¹ − ΦΦᵀ)_ii).
    reach: [f64; 2],
    /// By coordinate.
    inertia: Vec<f64>,
    shapes: Shapes,
}

/// What errors of the shapes that are kept make.
struct Shapes {
    /// √(twice the energy) of what shapes that are not orthogonal leave of the initial state along themselves.
    initial: f64,
    /// The largest √(K⁻¹)_ii, and √(M⁻¹)_ii.
    reach: [f64; 2],
    /// By mode, Kφ − ω²Mφ and Cφ − 2ζωMφ in the norm of M⁻¹.
    residuals: Vec<[f64; 2]>,
    /// ΦᵀMΦ − 1 in the Frobenius norm.
    overlap: f64,
    /// By mode, the largest entry.
    largest: Vec<f64>,
    /// By loaded coordinate, the norm of its row of Φ, and the largest entry of what Φ Ω⁻² Φᵀ has in its column.
    loaded: Vec<[f64; 2]>,
}

impl Rest {
    fn of(
        problem: &Problem<'_>,
        modes: &SparseModes,
        kept: &Kept,
        reduced: &System,
    ) -> Result<Rest, ResponseError> {
        let system = problem.system();
        let mut coordinates: Vec<usize> = problem.loads().iter().map(|on| on.coordinate).collect();
        coordinates.sort_unstable();
        coordinates.dedup();
        let mut loaded = Vec::new();
        for coordinate in coordinates {
            let mut force = vec![0.0; system.len()];
            force[coordinate] = 1.0;
            let moved = modes.residual_flexibility(&force).ok_or_else(|| {
                refusal("K is too near to singular for a static correction".to_owned())
            })?;
            loaded.push((coordinate, moved));
        }
        let coordinates: Vec<usize> = loaded.iter().map(|(coordinate, _)| *coordinate).collect();
        Ok(Rest {
            loaded,
            limits: Limits::of(problem, modes, kept, (reduced, &coordinates)),
        })
    }

    /// Adds R f at an instant.
    fn follow(
        &self,
        problem: &Problem<'_>,
        instant: &Instant,
        displacement: &mut Mat<f64>,
        column: usize,
    ) {
        let pieces = problem.timeline().pieces();
        let begun = pieces.partition_point(|piece| piece.start_instant().order(instant).is_le());
        let mut force = vec![0.0; displacement.nrows()];
        let t = instant.time().to_f64();
        let piece = begun.saturating_sub(1);
        let timeline = problem.timeline();
        timeline.signals(piece, t, |on, [value, ..]| force[on] += value);
        for (coordinate, moved) in &self.loaded {
            let force = force[*coordinate];
            let pairs = displacement.col_mut(column).iter_mut().zip(moved);
            pairs.for_each(|(x, moved)| *x += force * moved);
        }
    }

    /// Of displacements and velocities up to an instant.
    fn bounds(
        &self,
        problem: &Problem<'_>,
        until: &Instant,
        amplitudes: &Amplitudes,
    ) -> [Option<f64>; 2] {
        /// Roundings of a product and of the sums beside it.
        const ROUNDINGS: f64 = 8.0 * f64::EPSILON;
        let Some(limits) = &self.limits else {
            return [None; 2];
        };
        let (shapes, t) = (&limits.shapes, until.time().to_f64());
        let mut size = limits.initial;
        let mut stray = shapes.initial;
        let rounded = |amplitudes: &[f64]| {
            let terms = amplitudes.iter().zip(&shapes.largest);
            let terms: f64 = terms.map(|(q, x)| q * x).sum();
            (ROUNDINGS + amplitudes.len() as f64 * f64::EPSILON) * terms
        };
        let mut rounding = [&amplitudes.displacement, &amplitudes.velocity].map(|q| rounded(q));
        for (k, [elastic, damped]) in shapes.residuals.iter().enumerate() {
            let force = elastic * amplitudes.displacement[k] + damped * amplitudes.velocity[k];
            stray += force * t;
        }
        for ((coordinate, moved), [share, cancels]) in self.loaded.iter().zip(&shapes.loaded) {
            let variation = variation(problem, *coordinate, until);
            size += variation * moved[*coordinate].max(0.0).sqrt();
            stray += shapes.overlap * share * variation * t;
            let moved = moved
                .iter()
                .fold(*cancels, |top, moved| top.max(moved.abs()));
            rounding[0] += ROUNDINGS * variation * moved;
        }
        let pieces = problem.timeline().pieces().iter();
        for piece in pieces.take_while(|piece| piece.start_instant().order(until).is_le()) {
            for &(coordinate, momentum) in piece.impulses() {
                size += momentum.abs() * limits.inertia[coordinate].sqrt();
                let at = self.loaded.iter().position(|(on, _)| *on == coordinate);
                let share = at.map_or(0.0, |at| shapes.loaded[at][0]);
                stray += shapes.overlap * share * momentum.abs();
            }
        }
        [0, 1].map(|kind| {
            let [rest, whole] = [limits.reach[kind], shapes.reach[kind]];
            Some(rest * size + whole * stray + rounding[kind])
        })
    }
}

/// How much the force on a coordinate rises and falls from 0 until an instant, its onset included.
fn variation(problem: &Problem<'_>, coordinate: usize, until: &Instant) -> f64 {
    let end = until.time().to_f64();
    let timeline = problem.timeline();
    let (mut total, mut before) = (0.0, 0.0);
    let pieces = timeline.pieces();
    for (k, piece) in pieces.iter().enumerate() {
        if piece.start_instant().order(until).is_gt() {
            break;
        }
        let straight = piece
            .straight()
            .iter()
            .find(|part| part.coordinate == coordinate);
        let (value, slope) = straight.map_or((0.0, 0.0), |part| (part.value, part.slope));
        let next = pieces.get(k + 1).map_or(end, |next| next.start().min(end));
        let change = slope * (next - piece.start()).max(0.0);
        total += f64::abs(value - before) + change.abs();
        before = value + change;
    }
    for (at, harmonic) in timeline.harmonics() {
        if *at == coordinate {
            // Two amplitudes for each half turn begun, and the onset.
            let half_turns = (harmonic.frequency * end).abs() / std::f64::consts::PI + 1.0;
            total += harmonic.amplitude.abs() * (2.0 * half_turns + 1.0);
        }
    }
    for pulse in timeline
        .pulses()
        .iter()
        .filter(|pulse| pulse.coordinate == coordinate)
    {
        // A cosine sets in at once, turns three times and ends at once.
        total += 2.0 * pulse.sine.abs() + 6.0 * pulse.cosine.abs();
    }
    total
}

impl Limits {
    /// `None` where the system feeds energy in, damping couples shapes, something floats or has no mass of
    /// its own.
    fn of(
        problem: &Problem<'_>,
        modes: &SparseModes,
        kept: &Kept,
        (reduced, loaded): (&System, &[usize]),
    ) -> Option<Limits> {
        let system = problem.system();
        let structure = system.structure();
        let uncoupled = structure.is_undamped() || structure.is_classical();
        let lumped = system.masses().iter().all(|mass| *mass > 0.0)
            && system.added(MatrixKind::Mass).is_none()
            && system.added_sparse(MatrixKind::Mass).is_none();
        if !(structure.is_passive() && uncoupled && lumped) {
            return None;
        }
        let flexibility = modes.residual_flexibility_diagonal()?;
        let mut inertia: Vec<f64> = system.masses().iter().map(|mass| mass.recip()).collect();
        for k in 0..modes.len() {
            let pairs = inertia.iter_mut().zip(modes.shapes().col(k).iter());
            pairs.for_each(|(rest, x)| *rest -= x * x);
        }
        inertia.iter_mut().for_each(|rest| *rest = rest.max(0.0));
        let largest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max).sqrt();
        let [x, v] = &kept.rest;
        let moving: f64 = v.iter().zip(system.masses()).map(|(v, m)| m * v * v).sum();
        Some(Limits {
            initial: (modes.twice_potential_energy(x) + moving).sqrt(),
            reach: [largest(&flexibility), largest(&inertia)],
            inertia,
            shapes: Shapes::of(system, modes, kept, (reduced, loaded), &flexibility)?,
        })
    }
}

impl Shapes {
    /// Where masses are lumped, and `flexibility` is the diagonal of R.
    fn of(
        system: &System,
        modes: &SparseModes,
        kept: &Kept,
        (reduced, loaded): (&System, &[usize]),
        flexibility: &[f64],
    ) -> Option<Shapes> {
        let (shapes, masses, n) = (modes.shapes(), system.masses(), system.len());
        let norm = |rest: &[f64]| {
            let terms = rest
                .iter()
                .zip(masses)
                .map(|(rest, mass)| rest * rest / mass);
            terms.sum::<f64>().sqrt()
        };
        let damping = reduced.damping_matrix();
        let residuals = (0..modes.len()).map(|k| {
            let damped = modes.damping_residual(k, damping[(k, k)])?;
            Some([norm(&modes.residual(k)), norm(&damped)])
        });
        let weighted = Mat::from_fn(n, modes.len(), |i, k| masses[i] * shapes[(i, k)]);
        let overlap =
            shapes.transpose() * &weighted - Mat::<f64>::identity(modes.len(), modes.len());
        let rounding = 8.0 * f64::EPSILON;
        // What is left of the initial state along each mode, and the rounding of that.
        let mut initial = 0.0;
        for (order, rest) in kept.rest.iter().enumerate() {
            for (k, square) in modes.squares().iter().enumerate() {
                let terms = rest.iter().zip(weighted.col(k).iter());
                let terms = terms.map(|(rest, x)| rest * x);
                let (sum, size) = terms.fold((0.0, 0.0), |(sum, size), term: f64| {
                    (sum + term, size + term.abs())
                });
                let rate = if order == 0 { square.abs().sqrt() } else { 1.0 };
                initial += rate * (f64::abs(sum) + rounding * size);
            }
        }
        let squares = |i: usize| {
            let terms = modes.squares().iter().enumerate();
            terms.map(move |(k, square)| shapes[(i, k)].powi(2) / square)
        };
        let flexible = (0..n).map(|i| flexibility[i] + squares(i).sum::<f64>());
        let inertia = masses.iter().map(|mass| mass.recip());
        let loaded = loaded.iter().map(|&coordinate| {
            let share = shapes.row(coordinate).norm_l2();
            let flexible = |i: usize| {
                let terms = modes.squares().iter().enumerate();
                let terms = terms
                    .map(|(k, square)| (shapes[(i, k)] * shapes[(coordinate, k)] / square).abs());
                terms.sum::<f64>()
            };
            [share, (0..n).map(flexible).fold(0.0, f64::max)]
        });
        Some(Shapes {
            initial,
            reach: [
                flexible.fold(0.0, f64::max).sqrt(),
                inertia.fold(0.0, f64::max).sqrt(),
            ],
            residuals: residuals.collect::<Option<_>>()?,
            overlap: overlap.norm_l2() + rounding,
            largest: (0..modes.len()).map(|k| shapes.col(k).norm_max()).collect(),
            loaded: loaded.collect(),
        })
    }
}
