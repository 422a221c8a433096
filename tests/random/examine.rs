//! What must hold of every answer, whatever the scene: finite numbers or an error, honest counts, and bounds that
//! agree with each other.

use eigentone::modes::{Bounds, Eigenvalue, Modes, Precision};
use eigentone::response::{
    ElementForces, Energy, Problem, ResponsePlan, SteadyState, Summary, TimeGrid, Trajectory,
};
use eigentone::scene::Scene;
use eigentone::switching::{Event, EventKind, Period, Switching};

/// The certified tolerance of a second answer, which must agree with the first.
const LOOSE: Precision = Precision::Certified { tolerance: 1e-6 };

/// What is to be proven, which takes longer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Proven {
    Nothing,
    Modes,
    All,
}

/// The answers to one scene.
#[derive(Debug, Default)]
pub struct Answers {
    pub certified: Option<Modes>,
    pub estimated: Option<Modes>,
    pub motion: Option<Trajectory>,
    pub estimated_motion: Option<Trajectory>,
}

/// Solves the scene in doubles; and with proof, twice, as far as `proven` says.
///
/// # Panics
/// Where an answer is not what it says, or two answers contradict each other.
pub fn examined(scene: &Scene, proven: Proven) -> Answers {
    let system = scene.system();
    assert!(!system.structure().to_string().is_empty());
    let modes = |precision: Precision| {
        let modes = system.modes_to(precision).map_err(said).ok()?;
        check_modes(&modes, system.len());
        Some(modes)
    };
    let mut answers = Answers {
        estimated: modes(Precision::Double),
        ..Answers::default()
    };
    if proven != Proven::Nothing {
        answers.certified = modes(Precision::default());
        if let (Some(tight), Some(loose)) = (&answers.certified, modes(LOOSE)) {
            agree(tight, &loose);
        }
    }
    let Some(problem) = scene.problem() else {
        return answers;
    };
    let problem = problem.expect("it was checked when it was read");
    let motion = |precision: Precision| motion(&problem.clone().to(precision));
    answers.estimated_motion = motion(Precision::Double);
    if proven == Proven::All {
        answers.motion = motion(Precision::default());
        if let (Some(tight), Some(loose)) = (&answers.motion, motion(LOOSE)) {
            agree_in_motion(tight, &loose);
        }
    }
    let both = [&answers.motion, &answers.estimated_motion];
    for trajectory in both.into_iter().flatten() {
        let modes = answers.certified.as_ref().or(answers.estimated.as_ref());
        check_along(&problem, trajectory, modes);
    }
    answers
}

/// Solves a scene with switches in doubles, and with proof, twice.
///
/// # Panics
/// As above.
#[allow(dead_code)] // only some of those who share this ask
pub fn examined_with_switches(scene: &Scene) {
    /// Turns of the quickest motion: more only take longer.
    const LONGEST: f64 = 1e3;
    let quickest = scene.system().modes_to(Precision::Double).map(|modes| {
        let sizes = modes.eigenvalues().iter().map(|root| root.value.norm());
        sizes.fold(0.0, f64::max)
    });
    let (Some(end), Ok(quickest)) = (scene.end(), quickest) else {
        return;
    };
    if quickest * end > LONGEST {
        return;
    }
    let problem = scene.problem().expect("it has an end");
    let problem = problem.expect("it was checked when it was read");
    let motion = |precision: Precision| {
        let problem = problem.clone().to(precision);
        let motion = Switching::new(&problem, scene.switches())
            .map_err(said)
            .ok()?;
        let motion = motion.run().map_err(said).ok()?;
        check_motion(motion.trajectory(), "between events");
        let mut before = 0.0;
        for event in motion.events() {
            assert!(event.time >= before && event.time <= end, "{event:?}");
            assert!(event.bound >= 0.0, "{event:?}");
            before = event.time;
        }
        Some(motion)
    };
    let _ = motion(Precision::Double);
    if let (Some(tight), Some(loose)) = (motion(Precision::default()), motion(LOOSE)) {
        agree_in_motion(tight.trajectory(), loose.trajectory());
        // Of bounces that die out without end, more are listed where more digits are asked for.
        let ends = loose
            .events()
            .iter()
            .filter(|event| event.kind == EventKind::Contact);
        let ends: Vec<f64> = ends.map(|event| event.time).collect();
        let dies_out = |event: &Event| {
            let mut left = ends.iter().map(|time| time - event.time);
            left.any(|left| left.abs() <= 1e-5 * end)
        };
        let mut tight = tight.events().iter().filter(|event| !dies_out(event));
        for b in loose.events().iter().filter(|event| !dies_out(event)) {
            let a = tight.next().expect("as many events");
            assert_eq!((a.switch, a.kind), (b.switch, b.kind), "{a:?} {b:?}");
            assert!((a.time - b.time).abs() <= a.bound + b.bound, "{a:?} {b:?}");
        }
        assert_eq!(tight.next(), None);
    }
    if quickest * end > LONGEST / 20.0 {
        return;
    }
    for period in [Period::Free, Period::Cycles(1)] {
        repeats_itself(&problem, scene, period);
    }
}

/// A periodic motion, where one is found, comes back to its start.
fn repeats_itself(problem: &Problem<'_>, scene: &Scene, period: Period) {
    let Ok(switching) = Switching::new(problem, scene.switches()) else {
        return;
    };
    let Ok(cycle) = switching.limit_cycle(period).map_err(said) else {
        return;
    };
    let numbers = cycle.displacement.iter().chain(&cycle.velocity);
    let numbers = numbers.chain(cycle.bound.iter().flatten());
    assert!(
        numbers
            .chain([&cycle.period_bound])
            .all(|number| number.is_finite())
    );
    let system = scene.system();
    let once = TimeGrid::new(cycle.period, cycle.period).and_then(|grid| {
        let loads = problem.loads().to_vec();
        Problem::new(system, &cycle.state(system), loads, grid)
    });
    // Loads on points and motions of supports are not among those.
    let Ok(once) = once else { return };
    if !problem.channels().is_empty() || cycle.multipliers.iter().any(|one| one.norm() > 1e3) {
        return;
    }
    let motion = Switching::new(&once, scene.switches()).and_then(|switching| switching.run());
    let Ok(motion) = motion.map_err(said) else {
        return;
    };
    let ends = [
        (motion.trajectory().displacement(), &cycle.displacement),
        (motion.trajectory().velocity(), &cycle.velocity),
    ];
    for (found, start) in ends {
        let largest = start
            .iter()
            .fold(0.0f64, |largest, value| largest.max(value.abs()));
        for (i, start) in start.iter().enumerate() {
            let off = (found[(i, found.ncols() - 1)] - start).abs();
            assert!(
                off <= 1e-6 * largest,
                "{period:?} {cycle:?}: off by {off:?}"
            );
        }
    }
}

/// An error says something, in one line.
pub fn said<E: std::error::Error>(error: E) {
    let message = error.to_string();
    assert!(
        !message.is_empty() && !message.contains('\n') && !message.contains("NaN"),
        "{message}"
    );
}

fn motion(problem: &Problem<'_>) -> Option<Trajectory> {
    let plan = ResponsePlan::of(problem).map_err(said).ok()?;
    let trajectory = plan.run(problem).map_err(said).ok()?;
    check_motion(&trajectory, &plan.reason);
    Some(trajectory)
}

/// Numbers that are some, with bounds.
fn check_motion(trajectory: &Trajectory, reason: &str) {
    for (part, bounds) in parts(trajectory) {
        assert_eq!(bounds.len(), trajectory.len());
        for (k, bound) in bounds.iter().enumerate() {
            for i in 0..part.nrows() {
                assert!(part[(i, k)].is_finite(), "{reason} at {k}: {part:?}");
            }
            assert!(bound.is_none_or(|bound| bound >= 0.0), "{bound:?}");
            let proven = trajectory.bounds() == Bounds::Proven;
            assert!(!proven || bound.is_some());
        }
    }
}

fn parts(trajectory: &Trajectory) -> [(faer::MatRef<'_, f64>, &[Option<f64>]); 2] {
    [
        (trajectory.displacement(), trajectory.displacement_bound()),
        (trajectory.velocity(), trajectory.velocity_bound()),
    ]
}

fn check_modes(modes: &Modes, n: usize) {
    let roots = modes.eigenvalues();
    assert_eq!(roots.len() + modes.infinite(), 2 * n);
    for root in roots {
        assert!(root.value.re.is_finite() && root.value.im.is_finite());
        for bound in [root.bound, root.real_bound] {
            assert!(bound.is_none_or(|bound| bound >= 0.0), "{root:?}");
            assert!(bound.is_some() || modes.bounds() == Bounds::Estimated);
        }
    }
    let mut counted = 0;
    for mode in modes {
        let root = mode.eigenvalue();
        assert!(roots.contains(&root) && root.value.im >= 0.0, "{mode:?}");
        assert_eq!(mode.shape().len(), n);
        let finite = |x: &num_complex::Complex<f64>| x.re.is_finite() && x.im.is_finite();
        assert!(mode.shape().iter().all(finite), "{mode:?}");
        let one = num_complex::Complex::new(1.0, 0.0);
        assert!(mode.shape().contains(&one), "{mode:?}");
        assert!(mode.natural_frequency().hertz().is_finite());
        assert!(mode.backward_error() >= 0.0, "{mode:?}");
        assert!(mode.damping_ratio().is_none_or(|ratio| ratio.abs() <= 1.0));
        let times = mode.roots();
        counted += if root.value.im == 0.0 {
            times
        } else {
            2 * times
        };
    }
    assert_eq!(counted, roots.len());
}

/// By how far two numbers that were rounded to doubles may lie apart.
fn rounded(size: f64) -> f64 {
    4.0 * f64::EPSILON * size + 4.0 * 5e-324
}

/// Whether both can be right within their bounds, the second ones times `room`.
fn meet(a: &Eigenvalue, b: &Eigenvalue, room: f64) -> bool {
    let (Some(first), Some(second)) = (a.bound, b.bound) else {
        return true;
    };
    let apart = a.value - b.value;
    let size = a.value.re.hypot(a.value.im);
    apart.re.hypot(apart.im) <= first + room * second + rounded(size)
}

/// Whether each root of one list can be given a root of the other, and each another one, such that they meet.
pub fn matched(a: &[Eigenvalue], b: &[Eigenvalue], room: f64) -> bool {
    /// Gives the root `i` a partner, moving others on (Kuhn's algorithm).
    fn place(
        i: usize,
        a: &[Eigenvalue],
        b: &[Eigenvalue],
        room: f64,
        seen: &mut [bool],
        partner: &mut [Option<usize>],
    ) -> bool {
        for j in 0..b.len() {
            if seen[j] || !meet(&a[i], &b[j], room) {
                continue;
            }
            seen[j] = true;
            if partner[j].is_none_or(|other| place(other, a, b, room, seen, partner)) {
                partner[j] = Some(i);
                return true;
            }
        }
        false
    }
    let mut partner = vec![None; b.len()];
    let mut placed = |i| place(i, a, b, room, &mut vec![false; b.len()], &mut partner);
    a.len() == b.len() && (0..a.len()).all(&mut placed)
}

/// Two lists that are both proven must meet.
fn agree(tight: &Modes, loose: &Modes) {
    let proven = |modes: &Modes| modes.bounds() == Bounds::Proven;
    assert_eq!(tight.infinite(), loose.infinite());
    if proven(tight) && proven(loose) {
        let (tight, loose) = (tight.eigenvalues(), loose.eigenvalues());
        assert!(matched(tight, loose, 1.0), "{tight:?}\n{loose:?}");
    }
}

/// Where two motions differ by more than the bounds of both, the second ones times `room`.
pub fn beyond(first: &Trajectory, second: &Trajectory, room: f64) -> Option<String> {
    let both = parts(first).into_iter().zip(parts(second));
    for (kind, ((a, a_bounds), (b, b_bounds))) in ["displacement", "velocity"].iter().zip(both) {
        for k in 0..first.len() {
            let (Some(one), Some(other)) = (a_bounds[k], b_bounds[k]) else {
                continue;
            };
            for i in 0..a.nrows() {
                let apart = (a[(i, k)] - b[(i, k)]).abs();
                let allowed = one + room * other + rounded(a[(i, k)].abs());
                if apart > allowed {
                    return Some(format!(
                        "{kind} {i} at {k}: {:e} ± {one:e} by {}, {:e} ± {other:e} by {}",
                        a[(i, k)],
                        first.method(),
                        b[(i, k)],
                        second.method()
                    ));
                }
            }
        }
    }
    None
}

fn agree_in_motion(tight: &Trajectory, loose: &Trajectory) {
    let proven = |motion: &Trajectory| motion.bounds() == Bounds::Proven;
    if proven(tight) && proven(loose) {
        assert_eq!(beyond(tight, loose, 1.0), None);
    }
}

/// What is derived from a motion does not fail on it.
fn check_along(problem: &Problem<'_>, trajectory: &Trajectory, modes: Option<&Modes>) {
    if let Some(modes) = modes {
        let summary = Summary::of(problem, trajectory, modes);
        assert!(summary.is_some());
    }
    let _ = SteadyState::of(problem).map_err(said);
    let _ = Energy::along(problem, trajectory).map_err(said);
    let _ = ElementForces::along(problem, trajectory).map_err(said);
}
