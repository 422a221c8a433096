//! Energies against closed forms, and their balance where there are none.

use eigentone_modes::{BeamEnd, GROUND, MatrixKind, System};
use eigentone_response::{
    ByCertifiedExponential, Energy, HalfSine, Harmonic, Hold, Impulse, Load, Polynomial, Quantity,
    Ramp, Response, ResponseMethod, Samples, State, SteadyState, Step, Versine,
};
use faer::mat;

use crate::systems::{beam, in_a_row};

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

/// All is known, and adds up.
fn assert_balance(energy: &Energy) {
    let most = most(energy);
    assert!(most > 0.0 && most.is_finite(), "nothing happens");
    assert_eq!(energy.bound().len(), energy.work().len());
    for (k, bound) in energy.bound().iter().enumerate() {
        let stored = energy.kinetic()[k] + energy.potential()[k] - energy.initial();
        let missing = stored + energy.dissipated()[k] - energy.work()[k];
        assert!(
            missing.abs() <= 4.0 * f64::EPSILON * most,
            "{k}: {missing:e}"
        );
        assert!(*bound <= f64::EPSILON * most, "{k}: {bound:e} {most:e}");
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
        let system = in_a_row(&[("m", 2.0)], &[], &[damping]);
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
    let system = in_a_row(&[("a", 1.0), ("b", 2.0)], &[3.0, 1e8], &[0.1]);
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

/// An impulse J on a mass at rest brings J²/2m, one on a moving mass Jv more.
#[test]
fn an_impulse_brings_kinetic_energy() {
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
    let system = in_a_row(&[("m", 1.0)], &[4.0], &[0.8]);
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

/// A road that jumps by h under a spring stores ½kh² in it at once, which goes to and fro from then on; a mass that a
/// support carries takes ½mv² to be brought to v.
#[test]
fn a_road_that_jumps_brings_what_its_spring_stores() {
    let system = System::builder()
        .mass("m", 2.0)
        .support("road")
        .spring("road", "m", 8.0);
    let system = system.build().expect("a system");
    let jump = Step::of(0.5).starting_at(0.33);
    let asked = Response::of(&system).motion("road", Quantity::Displacement, jump);
    let found = energy(asked.every(0.25).until(5.0));
    assert_eq!((found.initial(), found.work()[1]), (0.0, 0.0));
    for k in 2..=20 {
        assert_near(found.work()[k], 1.0, 1e-15);
        assert_near(found.kinetic()[k] + found.potential()[k], 1.0, 1e-14);
    }
    let carried = System::builder()
        .mass("m", 2.0)
        .support("s")
        .point("p", [("s", 1.0)], 3.0);
    let carried = carried.spring(GROUND, "m", 8.0).build().expect("a system");
    let pushed = Response::of(&carried).motion("s", Quantity::Velocity, Step::of(2.0));
    let pushed = energy(pushed.every(0.25).until(1.0));
    assert_eq!((pushed.initial(), pushed.work()), (0.0, &[6.0; 5][..]));
    assert_eq!(pushed.kinetic(), [6.0; 5]);
}

/// What begins with a harmonic that is not 0 at once begins with a jump, as a step of that height does.
#[test]
fn a_harmonic_that_begins_with_a_jump_brings_what_a_step_does() {
    let harmonic = Harmonic::of(3.0, 1.0).with_phase(0.5);
    let height = 3.0 * 0.5f64.sin();
    let road = System::builder()
        .mass("m", 1.0)
        .support("road")
        .spring("road", "m", 2.0);
    let road = road.build().expect("a system");
    let asked = Response::of(&road).motion("road", Quantity::Displacement, harmonic);
    let moved = energy(asked.every(0.25).until(2.0));
    assert_eq!((moved.initial(), moved.kinetic()[0]), (0.0, 0.0));
    assert_near(moved.work()[0], height * height, 1e-15);
    assert_balance(&moved);
    let node = System::builder()
        .mass("m", 1.0)
        .mass("node", 0.0)
        .spring("m", "node", 2.0)
        .spring("node", GROUND, 2.0);
    let node = node.build().expect("a system");
    let at = State::at_rest().displace("m", 1.0);
    let asked = Response::of(&node).load("node", harmonic).from(at);
    let pushed = energy(asked.every(0.25).until(2.0));
    // The node moves from 1/2 by F/4, under a force that rises with its way from none to F.
    assert_near(pushed.initial(), 0.5, 1e-15);
    assert_near(pushed.work()[0], height * height / 8.0, 1e-15);
    assert_balance(&pushed);
}

/// Springs and dampers do not see from which frame they are looked at: on a soil that ends metres away a building stores and
/// loses what one on a fixed soil does under −m u″, also where its damping is given by modes or by masses.
#[test]
fn what_is_stored_does_not_depend_on_the_frame() {
    let floors = |soil: &'static str| {
        System::builder()
            .mass("floor", 3.0)
            .mass("roof", 2.0)
            .support("soil")
            .spring(soil, "floor", 700.0)
            .damper(soil, "floor", 5.0)
            .spring("floor", "roof", 500.0)
            .rayleigh(0.1, 0.001, (soil == "soil").then_some("soil"))
            .modal_damping([0.02], (soil == "soil").then_some("soil"))
            .build()
            .expect("a system")
    };
    let record = |factor: f64| Samples {
        step: 0.02,
        values: (0..400)
            .map(|j| factor * f64::from(j * 37 % 101) / 64.0)
            .collect(),
        hold: Hold::First,
    };
    let (tower, fixed) = (floors("soil"), floors(GROUND));
    let shaken = Response::of(&tower).motion("soil", Quantity::Acceleration, record(1.0));
    let shaken = energy(shaken.every(0.02).until(8.0));
    let pushed = Response::of(&fixed)
        .load("floor", record(-3.0))
        .load("roof", record(-2.0));
    let pushed = energy(pushed.every(0.02).until(8.0));
    assert_balance(&shaken);
    let stored = pushed.potential().iter().fold(0.0, |a: f64, b| a.max(*b));
    for k in 0..=400 {
        let off = shaken.potential()[k] - pushed.potential()[k];
        assert!(off.abs() <= 1e-12 * stored, "{k}: {off:e} {stored:e}");
        let off = shaken.dissipated()[k] - pushed.dissipated()[k];
        assert!(off.abs() <= 1e-12 * pushed.dissipated()[k], "{k}: {off:e}");
    }
    assert!(shaken.work()[400] > 1e3 * stored);
}

/// In the steady state on a shaken road the damper takes πcΩ|x − u|² in a period, and the road brings it.
#[test]
fn a_shaken_road_brings_what_the_damper_takes() {
    let system = System::builder()
        .mass("m", 1.0)
        .support("road")
        .spring("road", "m", 4.0)
        .damper("road", "m", 0.8)
        .build()
        .expect("a system");
    let frequency = std::f64::consts::TAU / 4.0;
    for (quantity, size) in [
        (Quantity::Displacement, 0.5),
        (Quantity::Velocity, 0.5 * frequency),
        (Quantity::Acceleration, 0.5 * frequency * frequency),
    ] {
        let asked = Response::of(&system).motion("road", quantity, Harmonic::of(size, frequency));
        let energy = energy(asked.every(0.125).until(400.0));
        // |x − u| = Ω²|u|/|4 − Ω² + 0.8iΩ|.
        let square = frequency * frequency;
        let stretch = square * 0.5 / (4.0 - square).hypot(0.8 * frequency);
        let period = std::f64::consts::PI * 0.8 * frequency * stretch * stretch;
        for parts in [energy.dissipated(), energy.work()] {
            assert_near(parts[3200] - parts[3200 - 32], period, 1e-11);
        }
    }
}

/// Every kind of motion and pulse, by every quantity, on points that carry mass too: what moves, what takes and what brings
/// add up.
#[test]
fn the_balance_holds_where_supports_move() {
    let samples = |hold| Samples {
        step: 0.25,
        values: vec![0.0, -2.0, 0.5, 3.0, 0.0],
        hold,
    };
    let kinds: [Load; 8] = [
        Step::of(0.7).starting_at(0.3).into(),
        Ramp::of(0.25).starting_at(0.4).into(),
        Harmonic::of(1.5, 0.7).into(),
        HalfSine::of(0.8, 0.6).starting_at(0.2).into(),
        Versine::of(0.8, 0.6).starting_at(0.9).into(),
        Polynomial::of([0.0, 0.3, -0.2]).starting_at(0.1).into(),
        samples(Hold::First).into(),
        samples(Hold::Zero).into(),
    ];
    let quantities = [
        Quantity::Displacement,
        Quantity::Velocity,
        Quantity::Acceleration,
    ];
    let springs = || {
        System::builder()
            .mass("heave", 4.0)
            .mass("pitch", 1.5)
            .mass("light", 0.0)
            .support("s")
            .support("t")
            .point("front", [("heave", 1.0), ("pitch", -1.1)], 0.0)
            .point("rear", [("heave", 1.0), ("pitch", 1.4)], 0.5)
            .spring("s", "front", 300.0)
            .spring("t", "rear", 200.0)
            .spring("light", "rear", 30.0)
            .spring("t", "light", 20.0)
            .spring("s", "t", 7.0)
            .damper("front", "rear", 3.0)
    };
    let damped = || springs().damper("s", "front", 2.0).damper("s", "t", 0.4);
    let heavy = || damped().point("carried", [("heave", 0.5), ("s", 0.25)], 2.0);
    let mut answered = 0;
    for builder in [springs(), damped(), heavy()] {
        let system = builder.build().expect("a system");
        for kind in &kinds {
            for quantity in quantities {
                let asked = Response::of(&system)
                    .from(State::at_rest().displace("pitch", 0.1).push("heave", -1.0))
                    .motion("s", quantity, kind.clone())
                    .motion("t", Quantity::Displacement, Versine::of(0.3, 1.5))
                    .load("rear", HalfSine::of(40.0, 0.5).starting_at(0.7))
                    .load("rear", Impulse::of(0.8).at(0.65))
                    .load("heave", Step::of(5.0).starting_at(0.11));
                let asked = asked.every(0.5).until(6.0);
                let Ok(problem) = asked.clone().problem() else {
                    continue;
                };
                let trajectory = asked.run().expect("a motion");
                match Energy::along(&problem, &trajectory) {
                    Ok(energy) => assert_balance(&energy),
                    Err(error) => {
                        let jumps = matches!(kind, Load::Step(_))
                            || matches!(kind, Load::Samples(samples) if samples.hold == Hold::Zero);
                        assert!(jumps && quantity == Quantity::Displacement, "{error}");
                        continue;
                    }
                }
                answered += 1;
            }
        }
    }
    // Jumps through a damper take infinite work, those of what carries mass are no motions.
    assert_eq!(answered, 3 * 24 - 2 - 2);
}

#[test]
fn what_has_no_energy_is_refused() {
    let stiffness = mat![[2.0, -1.0], [0.0, 3.0]];
    let mass = mat![[1.0, 0.0], [0.0, 1.0]];
    let follower = System::builder()
        .matrix(MatrixKind::Mass, mass.as_ref())
        .matrix(MatrixKind::Stiffness, stiffness.as_ref());
    let dashpot = System::builder().mass("x1", 0.0).damper(GROUND, "x1", 1.0);
    let road = System::builder().mass("x1", 1.0).support("road");
    let road = road.damper("road", "x1", 1.0);
    for (builder, why) in [
        (follower, "not symmetric"),
        (dashpot, "infinite work"),
        (road, "through a damper"),
    ] {
        let system = builder.build().expect("a system");
        let mut asked = Response::of(&system).load("x1", Impulse::of(1.0));
        for support in system.supports() {
            asked = asked.motion(support, Quantity::Displacement, Step::of(1.0));
        }
        let asked = asked.every(0.5).until(1.0);
        let trajectory = asked.clone().run().expect("a response");
        let problem = asked.problem().expect("well posed");
        let error = Energy::along(&problem, &trajectory).expect_err(why);
        assert!(error.to_string().contains(why), "{error}");
    }
}

/// Loads and motions that are 0 at all times are left out: the motion is that of the state at t = 0 alone, known with 32 digits, and
/// where that is at rest every energy is 0.
#[test]
fn loads_that_are_zero_take_nothing() {
    let builder = System::builder().mass("m", 1.0).support("s");
    let builder = builder.spring("s", "m", 1.0).damper("s", "m", 0.1);
    let system = builder.build().expect("a system");
    let zeros: [Load; 8] = [
        Step::of(0.0).into(),
        Ramp::of(0.0).into(),
        Impulse::of(0.0).at(0.7).into(),
        Harmonic::of(0.0, 2.0).into(),
        Samples {
            step: 0.5,
            values: vec![0.0, -0.0],
            hold: Hold::First,
        }
        .into(),
        HalfSine::of(0.0, 0.3).into(),
        Versine::of(0.0, 0.3).into(),
        Polynomial::of([0.0, 0.0]).into(),
    ];
    for zero in zeros {
        let mut asked = Response::of(&system).load("m", zero.clone());
        if !matches!(zero, Load::Impulse(_)) {
            asked = asked.motion("s", Quantity::Displacement, zero.clone());
        }
        let asked = asked.every(0.5).until(2.0);
        let problem = asked.clone().problem().expect("well posed");
        assert!(problem.drives().is_empty(), "{zero:?}");
        let still = ByCertifiedExponential.run(&problem).expect("a motion");
        assert_eq!(still.digits(), 32, "{zero:?}");
        let energy = Energy::along(&problem, &still).expect("energies");
        assert!(energy.work().iter().all(|work| *work == 0.0), "{zero:?}");
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
        assert_balance(&energy(asked.every(0.5).until(10.0)));
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

/// Loads bring ∫fᵀv and dampers take ∫vᵀCv, by Simpson's rule over the proven motion.
#[test]
fn what_is_brought_and_taken_is_the_integral_of_a_power() {
    let mass = mat![[0.5, 0.1, 0.0], [0.1, 0.0, 0.0], [0.0, 0.0, 0.0]];
    let damping = mat![[0.1, 0.4, 0.0], [-0.4, 0.2, 0.0], [0.0, 0.0, 0.0]];
    let chain = |c: f64| {
        let masses = System::builder().mass("a", 1.0).mass("b", 2.0).mass("c", c);
        masses.spring("a", "b", 10.0).spring("b", "c", 1.0)
    };
    let full = chain(0.7)
        .matrix(MatrixKind::Mass, mass.as_ref())
        .matrix(MatrixKind::Damping, damping.as_ref());
    // What a node without mass and damper moves at once, under half of the force on average, against springs of 1 and 2 N/m.
    let at_once = (1.5 * 0.3f64.sin()).powi(2) / (2.0 * 3.0);
    for (builder, at_once) in [
        (full.spring(GROUND, "a", 3.0).damper("b", "c", 0.3), 0.0),
        (chain(0.0).damper(GROUND, "c", 0.5), 0.0),
        (
            chain(0.0).spring(GROUND, "c", 2.0).damper("a", "b", 0.4),
            at_once,
        ),
        (chain(3.0).damper("a", "c", 1e-3), 0.0),
    ] {
        let system = builder.build().expect("a system");
        let asked = Response::of(&system)
            .from(State::at_rest().displace("a", 0.5).push("a", -1.0))
            .load("a", Ramp::of(0.25).starting_at(-3.0))
            .load("b", HalfSine::of(4.0, 1.5))
            .load(
                "b",
                Samples {
                    step: 0.25,
                    values: vec![1.0, -2.0, 0.5, 3.0],
                    hold: Hold::First,
                },
            )
            .load("c", Harmonic::of(1.5, 0.7).with_phase(0.3));
        let problem = asked.clone().every(1.0 / 256.0).until(3.0);
        let problem = problem.problem().expect("a problem");
        let motion = asked.every(1.0 / 256.0).until(3.0).run().expect("a motion");
        let energy = Energy::along(&problem, &motion).expect("energies");
        let c = system.damping_matrix();
        let powers = |k: usize| {
            let v = motion.velocity().col(k);
            let mut brought = 0.0;
            let t = motion.times()[k];
            let pieces = problem.timeline().pieces();
            let piece = pieces.iter().rposition(|piece| piece.start() <= t);
            problem.forces(piece.expect("from 0 on"), t, 0, |on, force| {
                brought += force * v[on]
            });
            [brought, (v.transpose() * &c * v)]
        };
        let mut sums = [at_once, 0.0];
        for k in (2..motion.len()).step_by(2) {
            let three = [k - 2, k - 1, k].map(powers);
            for (kind, sum) in sums.iter_mut().enumerate() {
                let [first, middle, last] = three.map(|powers| powers[kind]);
                *sum += (first + 4.0 * middle + last) / (3.0 * 256.0);
            }
            for (found, wanted) in [energy.work()[k], energy.dissipated()[k]].iter().zip(sums) {
                assert!((found - wanted).abs() < 1e-8, "{k}: {found} {wanted}");
            }
        }
        assert!(sums.iter().all(|sum| sum.abs() > 1e-3), "{sums:?}");
    }
}

/// A free beam moves far beside what it bends: its stiffness times the way would hide all energies in doubles.
#[test]
fn a_free_beam_keeps_what_is_brought() {
    for elements in [4, 20] {
        let beam = beam("b", elements, [2.0, 2e6, 1.0], [BeamEnd::Free; 2]);
        let system = System::builder().beam(beam).build().expect("a beam");
        let pushed = Response::of(&system).load("b.1.w", Step::of(3.0));
        let pushed = pushed.every(5.0).until(50.0);
        let found = energy(pushed.clone());
        let far = pushed.run().expect("a motion");
        let x = far.displacement_of("b.1.w").expect("a coordinate");
        for k in 1..=10 {
            assert_near(found.work()[k], 3.0 * x[k], 1e-15);
            assert!(
                found.bound()[k] <= f64::EPSILON * found.work()[k],
                "{:e} {:e}",
                found.bound()[k],
                found.work()[k]
            );
        }
    }
}

/// Against exponentials of 900 bits, of matrices that were assembled in fractions by another program.
#[test]
fn energies_of_beams_are_those_of_exact_fractions() {
    let free = |elements, sizes: [f64; 3]| beam("b", elements, sizes, [BeamEnd::Free; 2]);
    let tube = System::builder().beam(free(20, [2.0, 2e4, 1.0])).build();
    let tube = tube.expect("a beam");
    let asked = Response::of(&tube).load("b.1.w", Harmonic::of(3.0, 2.0));
    let found = energy(asked.every(5.0).until(50.0));
    assert_near(found.potential()[2], 7.770_493e-6, 1e-6);
    assert_near(found.potential()[10], 2.364_961_6e-6, 1e-7);
    assert_near(found.work()[10], 0.036_575_78, 1e-6);
    let carried = System::builder().beam(free(3, [1.31, 507.0, 0.623]));
    let carried = carried.support("s").spring("s", "b.1.w", 2.94);
    let carried = carried.build().expect("a beam");
    let asked = Response::of(&carried).motion("s", Quantity::Acceleration, Step::of(3.76));
    let found = energy(asked.every(700.0).until(7000.0));
    assert_near(found.work()[10], 212_031_127.39, 1e-10);
}

/// A free body that was moved as a whole has no energy, to the digits in which its springs cancel.
#[test]
fn a_body_that_was_moved_as_a_whole_is_at_rest() {
    let system = System::builder().mass("a", 914.5).mass("b", 1.2);
    let system = system.spring("a", "b", 17.6).damper("a", GROUND, 0.3);
    let system = system.build().expect("a system");
    let moved = State::at_rest().displace("a", 1.0).displace("b", 1.0);
    let found = energy(Response::of(&system).from(moved).every(0.01).until(0.1));
    assert_eq!(most(&found), 0.0);
    assert!(found.bound().iter().all(|bound| *bound < 1e-24));
}

/// Times that are asked for alone are no instants of the grid.
#[test]
fn other_times_are_refused() {
    let system = in_a_row(&[("m", 1.0)], &[40.0], &[]);
    let asked = Response::of(&system).from(State::at_rest().displace("m", 1.0));
    let problem = asked.every(0.1).until(10.0).problem().expect("a problem");
    let motion = ByCertifiedExponential.at(&problem, &[0.3, 0.77]);
    let error = Energy::along(&problem, &motion.expect("a motion")).expect_err("no grid");
    assert!(error.to_string().contains("grid"), "{error}");
}

/// Only some instants, in any order: the same energies.
#[test]
fn instants_in_any_order() {
    let system = in_a_row(&[("m", 1.0)], &[40.0], &[0.3]);
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

/// A node without mass goes with a support that moves: no energy, though the spring between them is of 3 N/m.
#[test]
fn what_only_follows_has_none() {
    let system = System::builder().mass("a", 0.0).support("s");
    let system = system.spring("s", "a", 3.0).build().expect("a system");
    let ask = Response::of(&system).motion("s", Quantity::Velocity, Step::of(0.1));
    let energy = energy(ask.every(1.0).until(2.0));
    assert!(most(&energy) <= 1e-25);
    assert!(energy.bound().iter().all(|bound| *bound <= 1e-25));
}
