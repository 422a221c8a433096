//! Energies against closed forms, and their balance where there are none.

use eigentone_modes::{GROUND, MatrixKind, System};
use eigentone_response::{
    Energy, Harmonic, Hold, Impulse, Load, Ramp, Response, Samples, State, SteadyState, Step,
};
use faer::mat;

fn energy(asked: Response<'_>) -> Energy {
    let trajectory = asked.clone().run().expect("a response");
    let problem = asked.problem().expect("well posed");
    Energy::along(&problem, &trajectory).expect("energies")
}

/// The largest energy met.
fn most(energy: &Energy) -> f64 {
    let all = [
        energy.kinetic(),
        energy.potential(),
        energy.dissipated(),
        energy.work(),
    ];
    let all = all.into_iter().flatten();
    all.fold(energy.initial(), |most, one| most.max(one.abs()))
}

fn assert_balance(energy: &Energy, tolerance: f64) {
    let most = most(energy);
    assert!(most > 0.0 && most.is_finite(), "nothing happens");
    let imbalance = energy.imbalance();
    assert_eq!(imbalance.len(), energy.work().len());
    for (k, off) in imbalance.into_iter().enumerate() {
        let stored = energy.kinetic()[k] + energy.potential()[k] - energy.initial();
        let missing = stored + energy.dissipated()[k] - energy.work()[k];
        assert!(missing.abs() <= tolerance * most, "{k}: {missing:e}");
        assert!(
            (off - missing).abs() <= 4.0 * f64::EPSILON * most,
            "{k}: {off:e} {missing:e}"
        );
    }
}

fn assert_near(found: f64, wanted: f64, relative: f64) {
    let off = (found - wanted).abs();
    assert!(off <= relative * wanted.abs(), "{found} for {wanted}");
}

/// v = v₀e^{−ct/m}, also for a dashpot that stops the mass at once.
#[test]
fn a_dashpot_takes_the_kinetic_energy() {
    for damping in [0.3, 40.0, 1e6, 1e12] {
        let system = System::builder()
            .mass("m", 2.0)
            .damper(GROUND, "m", damping);
        let system = system.build().expect("a system");
        let asked = Response::of(&system).from(State::at_rest().push("m", 3.0));
        let energy = energy(asked.every(0.125).until(2.0));
        assert_eq!((energy.initial(), energy.dissipated()[0]), (9.0, 0.0));
        for (k, taken) in energy.dissipated().iter().enumerate() {
            let t = 0.125 * k as f64;
            assert_near(*taken, -9.0 * (-damping * t).exp_m1(), 1e-15);
        }
    }
}

/// A constant force does F·Δx, whatever the motion.
#[test]
fn a_constant_force_does_force_times_way() {
    let system = System::builder()
        .mass("a", 1.0)
        .mass("b", 2.0)
        .spring(GROUND, "a", 3.0)
        .spring("a", "b", 1e8)
        .damper(GROUND, "a", 0.1)
        .build()
        .expect("a system");
    let asked = Response::of(&system).load("b", Step::of(5.0).starting_at(0.33));
    let asked = asked.every(0.1).until(20.0);
    let trajectory = asked.clone().run().expect("a response");
    let energy = energy(asked);
    for k in 0..trajectory.len() {
        let wanted = 5.0 * trajectory.displacement()[(1, k)];
        assert!((energy.work()[k] - wanted).abs() <= 1e-12 * most(&energy));
    }
    assert!(energy.work()[3] == 0.0 && energy.work()[4] > 0.0);
}

/// A blow J on a mass at rest brings J²/2m, one on a moving mass Jv more.
#[test]
fn a_blow_brings_kinetic_energy() {
    let system = System::builder().mass("m", 0.5).build().expect("a system");
    let asked = Response::of(&system).load("m", Impulse::of(3.0));
    let asked = asked
        .load("m", Impulse::of(-1.0).at(0.3))
        .every(0.25)
        .until(1.0);
    let energy = energy(asked);
    assert_eq!(energy.initial(), 0.0);
    assert_eq!(energy.work(), [9.0, 9.0, 4.0, 4.0, 4.0]);
    assert_eq!(energy.kinetic(), [9.0, 9.0, 4.0, 4.0, 4.0]);
}

/// In the steady state the damper takes πcΩ|X|² in a period, and the load brings it.
#[test]
fn the_steady_state_takes_what_the_load_brings() {
    let system = System::builder()
        .mass("m", 1.0)
        .spring(GROUND, "m", 4.0)
        .damper(GROUND, "m", 0.8)
        .build()
        .expect("a system");
    // 32 samples make a period.
    let frequency = std::f64::consts::TAU / 4.0;
    let asked = Response::of(&system).load("m", Harmonic::of(2.0, frequency).with_phase(0.5));
    let asked = asked.every(0.125).until(400.0);
    let problem = asked.clone().problem().expect("well posed");
    let steady = SteadyState::of(&problem).expect("it is damped");
    let amplitude = steady.motions()[0].displacement()[0].norm();
    let period = std::f64::consts::PI * 0.8 * frequency * amplitude * amplitude;
    let energy = energy(asked);
    for parts in [energy.dissipated(), energy.work()] {
        assert_near(parts[3200] - parts[3200 - 32], period, 1e-12);
    }
}

/// On a spring alone a step of F does ½F·F/k at once, and a dashpot beside it takes the other half.
#[test]
fn what_has_no_mass_moves_at_once() {
    let spring = System::builder().mass("m", 0.0).spring(GROUND, "m", 4.0);
    let asked = |system| Response::of(system).load("m", Step::of(6.0).starting_at(0.5));
    let alone = spring.clone().build().expect("a system");
    let stiff = energy(asked(&alone).every(0.25).until(20.0));
    assert_eq!(stiff.potential()[1..4], [0.0, 4.5, 4.5]);
    assert_eq!(stiff.work()[1..4], [0.0, 4.5, 4.5]);
    let damped = spring.damper(GROUND, "m", 2.0).build().expect("a system");
    let damped = energy(asked(&damped).every(0.25).until(20.0));
    assert_near(damped.work()[80], 9.0, 1e-15);
    assert_near(damped.dissipated()[80], 4.5, 1e-15);
}

#[test]
fn what_has_no_energy_is_refused() {
    let stiffness = mat![[2.0, -1.0], [0.0, 3.0]];
    let mass = mat![[1.0, 0.0], [0.0, 1.0]];
    let follower = System::builder()
        .matrix(MatrixKind::Mass, mass.as_ref())
        .matrix(MatrixKind::Stiffness, stiffness.as_ref());
    let dashpot = System::builder().mass("x1", 0.0).damper(GROUND, "x1", 1.0);
    for (builder, why) in [(follower, "not symmetric"), (dashpot, "infinite work")] {
        let system = builder.build().expect("a system");
        let asked = Response::of(&system).load("x1", Impulse::of(1.0));
        let asked = asked.every(0.5).until(1.0);
        let trajectory = asked.clone().run().expect("a response");
        let problem = asked.problem().expect("well posed");
        let error = Energy::along(&problem, &trajectory).expect_err(why);
        assert!(error.to_string().contains(why), "{error}");
    }
}

/// Full matrices with gyroscopic forces, massless nodes with and without dampers, and every kind of
/// load, on and off the grid.
#[test]
fn the_balance_holds_for_all_loads() {
    let mass = mat![[0.5, 0.1, 0.0], [0.1, 0.0, 0.0], [0.0, 0.0, 0.0]];
    let damping = mat![[0.1, 0.4, 0.0], [-0.4, 0.2, 0.0], [0.0, 0.0, 0.0]];
    let full = System::builder()
        .mass("a", 1.0)
        .mass("b", 2.0)
        .mass("c", 0.7)
        .spring(GROUND, "a", 3.0)
        .spring("a", "b", 10.0)
        .spring("b", "c", 1.0)
        .damper("b", "c", 0.3)
        .matrix(MatrixKind::Mass, mass.as_ref())
        .matrix(MatrixKind::Damping, damping.as_ref());
    let massless = System::builder()
        .mass("a", 1.0)
        .mass("b", 0.0)
        .mass("c", 0.0)
        .spring(GROUND, "a", 3.0)
        .spring("a", "b", 2.0)
        .spring("b", "c", 5.0)
        .spring(GROUND, "c", 1.0)
        .damper("a", "b", 0.5);
    let free = System::builder()
        .mass("a", 1.0)
        .mass("b", 2.0)
        .mass("c", 0.7)
        .spring("a", "b", 1e6)
        .damper("b", "c", 1e-3);
    for builder in [full, massless, free] {
        let system = builder.build().expect("a system");
        let samples = |hold| Samples {
            step: 0.25,
            values: vec![1.0, -2.0, 0.5, 3.0, 0.0],
            hold,
        };
        let loads: [(&str, Load); 8] = [
            ("a", Step::of(2.0).starting_at(0.3).into()),
            ("c", Step::of(-1.0).starting_at(1.5).into()),
            ("b", Ramp::of(0.25).starting_at(-3.0).into()),
            ("c", Ramp::of(-0.5).starting_at(1.1).into()),
            ("a", Impulse::of(-3.0).at(1.3).into()),
            ("c", Harmonic::of(1.5, 0.7).with_phase(0.3).into()),
            ("b", samples(Hold::Zero).into()),
            ("c", samples(Hold::First).into()),
        ];
        let asked = Response::of(&system).from(State::at_rest().displace("a", 0.5).push("a", -1.0));
        let asked = loads
            .into_iter()
            .fold(asked, |asked, (on, load)| asked.load(on, load));
        assert_balance(&energy(asked.every(0.5).until(10.0)), 1e-12);
    }
}

/// ½xᵀKx of K = [2 −1; −1 2] and x = (1, 0) is 1, and ½vᵀMv of M = [2 1; 1 3] and v = (1, −1) is 1.5: what
/// is stored in matrices counts as what elements store, and nothing takes it.
#[test]
fn matrices_store_energy() {
    let mass = mat![[2.0, 1.0], [1.0, 3.0]];
    let stiffness = mat![[2.0, -1.0], [-1.0, 2.0]];
    let system = System::builder()
        .mass("a", 0.0)
        .mass("b", 0.0)
        .matrix(MatrixKind::Mass, mass.as_ref())
        .matrix(MatrixKind::Stiffness, stiffness.as_ref())
        .build()
        .expect("a system");
    let start = State::at_rest().displace("a", 1.0);
    let start = start.push("a", 1.0).push("b", -1.0);
    let energy = energy(Response::of(&system).from(start).every(0.25).until(10.0));
    assert_eq!(energy.initial(), 2.5);
    assert_eq!((energy.kinetic()[0], energy.potential()[0]), (1.5, 1.0));
    for (kinetic, potential) in energy.kinetic().iter().zip(energy.potential()) {
        assert_near(kinetic + potential, 2.5, 1e-13);
    }
}

/// Only some instants, in any order: the same energies.
#[test]
fn instants_in_any_order() {
    let system = System::builder()
        .mass("m", 1.0)
        .spring(GROUND, "m", 40.0)
        .damper(GROUND, "m", 0.3)
        .build()
        .expect("a system");
    let asked = Response::of(&system)
        .from(State::at_rest().displace("m", 1.0))
        .load("m", Harmonic::of(2.0, 5.0))
        .load("m", Step::of(1.0).starting_at(3.21));
    let asked = asked.every(0.1).until(10.0);
    let all = energy(asked.clone());
    let picked = [77, 3, 77, 100, 0, 31];
    let problem = asked.problem().and_then(|problem| problem.at(&picked));
    let problem = problem.expect("well posed");
    let plan = eigentone_response::ResponsePlan::of(&problem).expect("a plan");
    let trajectory = plan.run(&problem).expect("a response");
    let some = Energy::along(&problem, &trajectory).expect("energies");
    for (k, step) in picked.into_iter().enumerate() {
        let step = step as usize;
        assert!((some.dissipated()[k] - all.dissipated()[step]).abs() <= 1e-12 * most(&all));
        assert!((some.work()[k] - all.work()[step]).abs() <= 1e-12 * most(&all));
    }
}
