//! Laws of motion that every response keeps, on generated systems: what is compared never comes from
//! the same run, and what may differ follows from the bounds that the runs state.

use eigentone::modes::{Element, Node};
use eigentone::prelude::*;
use eigentone::response::{
    ByCertifiedExponential, BySuperposition, Energy, Problem, ResponseMethod, methods,
};
use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;
use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;

/// A supported chain of masses with springs across and some dampers.
#[derive(Clone, Debug)]
struct Chain {
    masses: Vec<f64>,
    springs: Vec<(usize, usize, f64)>,
    dampers: Vec<(usize, usize, f64)>,
}

fn power(range: std::ops::Range<f64>) -> impl Strategy<Value = f64> + Clone {
    range.prop_map(|exponent| 10f64.powf(exponent))
}

fn chain(damped: bool) -> impl Strategy<Value = Chain> {
    (1..5usize).prop_flat_map(move |n| {
        let masses = prop::collection::vec(power(-1.0..1.0), n);
        let springs = prop::collection::vec(power(0.0..4.0), n);
        let join = (0..=n, 0..=n, power(-2.0..2.0));
        let across = prop::collection::vec(join.clone(), 0..3);
        let dampers = prop::collection::vec(join, if damped { 1..5 } else { 0..1 });
        (masses, springs, across, dampers).prop_map(|(masses, springs, across, dampers)| {
            let springs = springs.into_iter().enumerate();
            let along = springs.map(|(i, stiffness)| (i, i + 1, stiffness));
            Chain {
                masses,
                springs: along.chain(across).filter(|(i, j, _)| i != j).collect(),
                dampers: dampers.into_iter().filter(|(i, j, _)| i != j).collect(),
            }
        })
    })
}

impl Chain {
    fn system(&self) -> System {
        let mut builder = System::builder();
        for (i, mass) in self.masses.iter().enumerate() {
            builder = builder.mass(name(i + 1), *mass);
        }
        for &(i, j, stiffness) in &self.springs {
            builder = builder.spring(name(i), name(j), stiffness);
        }
        for &(i, j, damping) in &self.dampers {
            builder = builder.damper(name(i), name(j), damping);
        }
        builder.build().expect("a supported chain")
    }
}

/// 0 is the ground.
fn name(i: usize) -> String {
    match i {
        0 => GROUND.to_owned(),
        i => format!("m{i}"),
    }
}

/// Displacements and velocities.
type Motion = (Vec<f64>, Vec<f64>);

/// Numbers for as many masses as a chain can have.
fn motion() -> impl Strategy<Value = Motion> {
    let numbers = || prop::collection::vec(-1.0..1.0f64, 4);
    (numbers(), numbers())
}

fn start(system: &System, (x, v): &Motion) -> State {
    let coordinates = system.names().iter().zip(x.iter().zip(v));
    coordinates.fold(State::at_rest(), |state, (name, (x, v))| {
        state.displace(name, *x).push(name, *v)
    })
}

fn at(trajectory: &Trajectory, k: usize) -> Motion {
    let column = |m: faer::MatRef<'_, f64>| m.col(k).iter().copied().collect();
    (
        column(trajectory.displacement()),
        column(trajectory.velocity()),
    )
}

/// How far displacements and velocities of an instant may be off: as stated, but never so far that
/// a law says nothing.
fn bounds(trajectory: &Trajectory, k: usize) -> (f64, f64) {
    const SENSELESS: f64 = 1e-9;
    let least = |bound: Option<f64>, of: faer::MatRef<'_, f64>| {
        bound
            .unwrap_or(f64::INFINITY)
            .min(SENSELESS * of.norm_max())
    };
    (
        least(
            trajectory.displacement_bound()[k],
            trajectory.displacement(),
        ),
        least(trajectory.velocity_bound()[k], trajectory.velocity()),
    )
}

/// The square root of the energy of a motion. In a passive system the difference of two motions
/// under the same loads is a free motion, so that this cannot grow with time.
fn energy_norm(system: &System, (x, v): &Motion) -> f64 {
    let place = |node: Node| node.coordinate().map_or(0.0, |i| x[i]);
    let stretch = |spring: &Element| place(spring.second) - place(spring.first);
    let masses = system.masses().iter().zip(v);
    let kinetic: f64 = masses.map(|(mass, v)| mass * v * v).sum();
    let springs = system.springs().iter();
    let potential: f64 = springs
        .map(|spring| spring.coefficient * stretch(spring).powi(2))
        .sum();
    ((kinetic + potential) / 2.0).sqrt()
}

/// The largest energy norm of a motion within these bounds.
fn energy_bound(system: &System, (x, v): (f64, f64)) -> f64 {
    let kinetic: f64 = system.masses().iter().map(|mass| mass * v * v).sum();
    let springs = system.springs().iter();
    let potential: f64 = springs
        .map(|spring| spring.coefficient * (2.0 * x).powi(2))
        .sum();
    ((kinetic + potential) / 2.0).sqrt()
}

fn less((x, v): &Motion, (y, w): &Motion) -> Motion {
    let differences = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
    (differences(x, y), differences(v, w))
}

/// Every method that takes the problem answers it.
fn by_every_method(
    problem: &Problem<'_>,
    mut check: impl FnMut(&dyn ResponseMethod, Trajectory) -> TestCaseResult,
) -> TestCaseResult {
    let mut answered = 0;
    for method in methods() {
        if method.refuses(problem).is_none() {
            check(*method, method.run(problem).expect("it does not refuse"))?;
            answered += 1;
        }
    }
    prop_assert!(answered > 0);
    Ok(())
}

/// Loads of every kind, on and off a grid of step h.
fn loads(h: f64) -> [Load; 7] {
    let samples = |hold| Samples {
        step: 2.0 * h,
        values: vec![1.0, -2.0, 0.5, 3.0, 0.0],
        hold,
    };
    [
        Step::of(2.0).starting_at(3.3 * h).into(),
        Ramp::of(0.25).starting_at(-1.0).into(),
        Impulse::of(-3.0).at(10.0 * h).into(),
        Impulse::of(1.0).at(0.7 * h).into(),
        Harmonic::of(1.5, 0.7).with_phase(0.3).into(),
        samples(Hold::Zero).into(),
        samples(Hold::First).into(),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// From 0 to t₁ and from there on for t₂ is from 0 to t₁ + t₂.
    #[test]
    fn motion_taken_up_again_goes_on(
        chain in chain(true), initial in motion(), h in 0.01..2.0f64, first in 1..20u64, second in 1..20u64,
    ) {
        let system = chain.system();
        let ask = |state, count: u64| {
            let asked = Response::of(&system).from(state).every(h).until(count as f64 * h);
            asked.problem().expect("well posed")
        };
        let whole = ask(start(&system, &initial), first + second);
        by_every_method(&whole, |method, whole| {
            let (middle, last) = (first as usize, (first + second) as usize);
            let rest = ask(start(&system, &at(&whole, middle)), second);
            let rest = method.run(&rest).expect("it does not refuse");
            let off = less(&at(&whole, last), &at(&rest, second as usize));
            let off = energy_norm(&system, &off);
            let allowed: f64 = [(&whole, middle), (&whole, last), (&rest, second as usize)]
                .map(|(trajectory, k)| energy_bound(&system, bounds(trajectory, k)))
                .iter()
                .sum();
            prop_assert!(off <= allowed, "{}: {:e} > {:e}", method.name(), off, allowed);
            Ok(())
        })?;
    }

    /// Undamped, what moves back with the opposite velocity returns to where it was.
    #[test]
    fn undamped_motion_runs_backwards(
        chain in chain(false), initial in motion(), h in 0.01..2.0f64, count in 1..30u64,
    ) {
        let system = chain.system();
        prop_assert!(system.structure().is_undamped());
        let ask = |state| {
            let asked = Response::of(&system).from(state).every(h).until(count as f64 * h);
            asked.problem().expect("well posed")
        };
        by_every_method(&ask(start(&system, &initial)), |method, forth| {
            let last = count as usize;
            let (x, v) = at(&forth, last);
            let turned = (x, v.into_iter().map(|v| -v).collect());
            let back = method.run(&ask(start(&system, &turned))).expect("it does not refuse");
            let (x, v) = at(&back, last);
            let returned = (x, v.into_iter().map(|v| -v).collect());
            let off = energy_norm(&system, &less(&at(&forth, 0), &returned));
            let allowed: f64 = [(&forth, last), (&back, last)]
                .map(|(trajectory, k)| energy_bound(&system, bounds(trajectory, k)))
                .iter()
                .sum();
            prop_assert!(off <= allowed, "{}: {:e} > {:e}", method.name(), off, allowed);
            Ok(())
        })?;
    }

    /// The motion under all loads is the sum of the motions under each.
    #[test]
    fn loads_and_initial_states_superpose(
        chain in chain(true), initial in motion(), h in 0.05..1.0f64, picks in prop::collection::vec(1..5usize, 7),
    ) {
        let system = chain.system();
        let n = system.len();
        let ask = |of: &dyn Fn(usize) -> bool| {
            let mut asked = Response::of(&system).every(h).until(15.0 * h);
            if of(7) {
                asked = asked.from(start(&system, &initial));
            }
            for (index, load) in loads(h).into_iter().enumerate() {
                if of(index) {
                    asked = asked.load(name(1 + (picks[index] - 1) % n), load);
                }
            }
            asked.problem().expect("well posed")
        };
        by_every_method(&ask(&|_| true), |method, together| {
            let each: Vec<Trajectory> = (0..8)
                .map(|index| method.run(&ask(&|other| other == index)).expect("as together"))
                .collect();
            for k in 0..together.len() {
                let (mut x, mut v) = at(&together, k);
                let (mut x_bound, mut v_bound) = bounds(&together, k);
                let (mut x_size, mut v_size) = (0.0, 0.0);
                for one in &each {
                    (x, v) = less(&(x, v), &at(one, k));
                    let (x_more, v_more) = bounds(one, k);
                    (x_bound, v_bound) = (x_bound + x_more, v_bound + v_more);
                    x_size += one.displacement().norm_max();
                    v_size += one.velocity().norm_max();
                }
                // Eight roundings in the sum here.
                x_bound += 8.0 * f64::EPSILON * x_size;
                v_bound += 8.0 * f64::EPSILON * v_size;
                for (x, v) in x.iter().zip(&v) {
                    prop_assert!(x.abs() <= x_bound, "{}: {:e} > {:e}", method.name(), x, x_bound);
                    prop_assert!(v.abs() <= v_bound, "{}: {:e} > {:e}", method.name(), v, v_bound);
                }
            }
            Ok(())
        })?;
    }

    /// Energies are those of what every method finds, and dampers only take.
    #[test]
    fn energies_are_those_of_the_motion(
        chain in chain(true), initial in motion(), h in 0.05..1.0f64, picks in prop::collection::vec(1..5usize, 7),
    ) {
        let system = chain.system();
        let n = system.len();
        let mut asked = Response::of(&system).from(start(&system, &initial));
        for (index, load) in loads(h).into_iter().enumerate() {
            asked = asked.load(name(1 + (picks[index] - 1) % n), load);
        }
        let problem = asked.every(h).until(25.0 * h).problem().expect("well posed");
        by_every_method(&problem, |method, trajectory| {
            let energy = Energy::along(&problem, &trajectory).expect("masses and springs");
            let parts = [energy.kinetic(), energy.potential(), energy.dissipated(), energy.work()];
            let most = parts.into_iter().flatten().fold(energy.initial(), |a, b| a.max(b.abs()));
            for (k, bound) in energy.bound().iter().enumerate() {
                let now = energy.kinetic()[k] + energy.potential()[k];
                let masses = system.masses().iter().enumerate();
                let moving = masses.map(|(i, mass)| mass * trajectory.velocity()[(i, k)].powi(2));
                let place = |node: Node| match node {
                    Node::Ground => 0.0,
                    Node::Coordinate(i) => trajectory.displacement()[(i, k)],
                };
                let bent = system.springs().iter().map(|spring| {
                    let stretch = place(spring.first) - place(spring.second);
                    spring.coefficient * stretch * stretch
                });
                let found = moving.chain(bent).sum::<f64>() / 2.0;
                let moved = energy_bound(&system, bounds(&trajectory, k));
                let allowed = moved * (2.0 * now.sqrt() + moved) + 16.0 * f64::EPSILON * now + 2.0 * bound;
                let off = (found - now).abs();
                prop_assert!(off <= allowed, "{}: {:e} > {:e}", method.name(), off, allowed);
                prop_assert!(*bound <= f64::EPSILON * most, "{}: {:e}", method.name(), bound);
            }
            prop_assert!(energy.dissipated().is_sorted());
            Ok(())
        })?;
    }

    /// Volumes in state space shrink by e^{−h·tr(M⁻¹C)} (Liouville).
    #[test]
    fn state_space_shrinks_by_the_damping(chain in chain(true), turn in 0.05..3.0f64) {
        let system = chain.system();
        let n = system.len();
        let (mass, damping) = (system.mass_matrix(), system.damping_matrix());
        let trace: f64 = (0..n).map(|i| damping[(i, i)] / mass[(i, i)]).sum();
        let stiffest = chain.springs.iter().map(|spring| spring.2).fold(0.0, f64::max);
        let lightest = chain.masses.iter().copied().fold(f64::INFINITY, f64::min);
        // Velocities in units of a high frequency, a step of a part of its turn or decay.
        let rate = (stiffest / lightest).sqrt();
        let h = turn / rate.max(trace);
        let ask = |column: usize| {
            let mut unit = (vec![0.0; n], vec![0.0; n]);
            if column < n {
                unit.0[column] = 1.0;
            } else {
                unit.1[column - n] = rate;
            }
            let asked = Response::of(&system).from(start(&system, &unit)).every(h).until(h);
            asked.problem().expect("well posed")
        };
        by_every_method(&ask(0), |method, _| {
            let mut transition = Mat::zeros(2 * n, 2 * n);
            let mut error = 0.0f64;
            for column in 0..2 * n {
                let moved = method.run(&ask(column)).expect("as the first");
                let (x, v) = at(&moved, 1);
                for i in 0..n {
                    transition[(i, column)] = x[i];
                    transition[(n + i, column)] = v[i] / rate;
                }
                let (x, v) = bounds(&moved, 1);
                // The units of velocity are rounded, too.
                error = error.max(x.max(v / rate) + 2.0 * f64::EPSILON);
            }
            let expected = (-h * trace).exp();
            let factors = transition.partial_piv_lu();
            let inverse = factors.inverse();
            // d det = det·tr(Φ⁻¹ dΦ), and some roundings of the elimination.
            let sum: f64 = (0..4 * n * n).map(|at| inverse[(at % (2 * n), at / (2 * n))].abs()).sum();
            let allowed = expected * sum * (error + 16.0 * n as f64 * f64::EPSILON);
            let off = (transition.determinant() - expected).abs();
            prop_assert!(off <= allowed, "{}: {:e} > {:e}", method.name(), off, allowed);
            prop_assert!(allowed <= 1e-6 * expected, "nothing is shown");
            Ok(())
        })?;
    }
}

/// In doubles, too, the recurrences of superposition do not drift: after a million steps taken one by
/// one, and after a hundred million taken at once, the motion is right to its last digits.
#[test]
fn superposition_does_not_drift_over_very_many_steps() {
    let system = System::builder()
        .mass("m", 1.0)
        .spring(GROUND, "m", 1.0)
        .build()
        .expect("a system");
    // In strides, step by step for accelerations, and at once.
    for (steps, all, accelerates) in [
        (1_000_000u64, true, false),
        (1_000_000, true, true),
        (100_000_000, false, false),
    ] {
        let asked = Response::of(&system)
            .from(State::at_rest().displace("m", 1.0))
            .every(0.7)
            .until(0.7 * steps as f64);
        let asked = match accelerates {
            true => asked.with_acceleration(),
            false => asked,
        };
        let whole = asked.problem().expect("a problem");
        let last = whole.clone().at(&[steps]).expect("the last instant");
        let certified = ByCertifiedExponential.run(&last).expect("certified");
        let plain = BySuperposition.run(if all { &whole } else { &last });
        let plain = plain.expect("superposition");
        let end = plain.len() - 1;
        let difference = certified.displacement()[(0, 0)] - plain.displacement()[(0, end)];
        assert!(difference.abs() <= 1e-15, "{difference:e}");
    }
}
