//! Sweeps against the certified answers to the same designs.

use eigentone_modes::{DesignError, GROUND, Parameter, System};
use eigentone_response::{
    AppliedLoad, ByCertifiedExponential, Harmonic, Hold, Impulse, Load, Problem, Ramp,
    ResponseMethod, Samples, State, Step, Sweep, SweepError, TimeGrid,
};
use proptest::prelude::*;

const MASSES: [f64; 3] = [6.0, 9.0, 5.0];
const SPRINGS: [f64; 4] = [6.0, 7.0, 4.0, 1.0];
const DAMPERS: [f64; 4] = [1.0, 0.2, 0.1, 2.0];

fn chain(masses: &[f64], springs: &[f64], dampers: &[f64]) -> System {
    let n = masses.len();
    let name = |i: usize| match i {
        i if i == 0 || i == n + 1 => GROUND.to_owned(),
        i => format!("m{i}"),
    };
    let mut builder = System::builder();
    for (i, mass) in masses.iter().enumerate() {
        builder = builder.mass(name(i + 1), *mass);
    }
    for i in 0..=n {
        builder = builder.spring(name(i), name(i + 1), springs[i]).damper(
            name(i),
            name(i + 1),
            dampers[i],
        );
    }
    builder.build().expect("a chain is a system")
}

fn start() -> State {
    State::at_rest()
        .displace("m1", 6.0)
        .displace("m2", 7.0)
        .push("m3", -2.0)
}

/// One load of each kind, some off the grid.
fn loads() -> Vec<AppliedLoad> {
    let on = |coordinate, load| AppliedLoad { coordinate, load };
    vec![
        on(0, Load::Step(Step::of(3.0))),
        on(
            1,
            Load::Ramp(Ramp {
                rate: 0.25,
                start: 1.13,
            }),
        ),
        on(
            2,
            Load::Impulse(Impulse {
                magnitude: 2.0,
                at: 2.0,
            }),
        ),
        on(
            2,
            Load::Harmonic(Harmonic {
                amplitude: 1.5,
                frequency: 0.7,
                phase: 0.3,
            }),
        ),
        on(
            0,
            Load::Samples(Samples {
                step: 0.4,
                values: vec![0.0, 1.0, -1.0, 0.5],
                hold: Hold::First,
            }),
        ),
    ]
}

/// How far a sweep may be off, relative to the largest motion.
const NEAR: f64 = 2e-13;

fn agree(system: &System, loads: Vec<AppliedLoad>, sweep: &mut Sweep) {
    let grid = TimeGrid::new(0.1, 20.0).unwrap();
    let problem = Problem::new(system, &start(), loads, grid).unwrap();
    let known = ByCertifiedExponential.run(&problem).unwrap();
    let answer = sweep.solve().unwrap();
    for (found, known) in [
        (answer.displacement(), known.displacement()),
        (answer.velocity(), known.velocity()),
    ] {
        let off = (found - known).norm_max();
        assert!(off <= NEAR * known.norm_max(), "{off:e}");
    }
    let modes = system.modes().unwrap();
    assert_eq!(answer.eigenvalues().len(), modes.as_slice().len());
    for (j, mode) in modes.iter().enumerate() {
        let known = mode.eigenvalue().value;
        let condition = mode.condition().unwrap_or(f64::INFINITY);
        let allowed = 64.0 * f64::EPSILON * condition;
        if allowed > 1e-8 || allowed.is_nan() {
            continue;
        }
        let met =
            |found: &num_complex::Complex<f64>| (found - known).norm() <= allowed * known.norm();
        assert!(
            answer.eigenvalues().iter().any(met),
            "{known} among {:?}",
            answer.eigenvalues()
        );
        if (answer.eigenvalues()[j] - known).norm() > 1e-9 * known.norm() {
            continue;
        }
        // Both shapes are 1 somewhere, perhaps not at the same place.
        let (x, y) = (answer.shape(j), mode.shape());
        let pivot = (0..x.len())
            .find(|i| x[*i].re == 1.0 && x[*i].im == 0.0)
            .unwrap();
        for (x, y) in x.iter().zip(y) {
            let off = (x - y / mode.shape()[pivot]).norm();
            assert!(off <= 1e-6, "{off:e}");
        }
    }
}

#[test]
fn every_kind_of_load_is_answered() {
    let system = chain(&MASSES, &SPRINGS, &DAMPERS);
    let grid = TimeGrid::new(0.1, 20.0).unwrap();
    for loads in [vec![], loads()[..1].to_vec(), loads()] {
        let problem = Problem::new(&system, &start(), loads.clone(), grid).unwrap();
        agree(&system, loads, &mut Sweep::of(&problem).unwrap());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn designs_are_answered_as_systems_of_their_own(
        masses in prop::array::uniform3(-1.0..1.0),
        springs in prop::array::uniform4(-1.0..1.5),
        dampers in prop::array::uniform4(-3.0..1.0),
    ) {
        let ten = |x: f64| 10f64.powf(x);
        let (masses, springs, dampers) = (masses.map(ten), springs.map(ten), dampers.map(ten));
        let base = chain(&MASSES, &SPRINGS, &DAMPERS);
        let grid = TimeGrid::new(0.1, 20.0).unwrap();
        let problem = Problem::new(&base, &start(), loads(), grid).unwrap();
        let mut sweep = Sweep::of(&problem).unwrap();
        for (i, mass) in masses.iter().enumerate() {
            sweep.set(Parameter::Mass(i), *mass).unwrap();
        }
        for i in 0..4 {
            sweep.set(Parameter::Spring(i), springs[i]).unwrap();
            sweep.set(Parameter::Damper(i), dampers[i]).unwrap();
        }
        agree(&chain(&masses, &springs, &dampers), loads(), &mut sweep);
    }
}

#[test]
fn undamped_designs_do_not_decay() {
    let system = chain(&MASSES, &SPRINGS, &[0.0; 4]);
    let grid = TimeGrid::new(0.1, 20.0).unwrap();
    let problem = Problem::new(&system, &start(), vec![], grid).unwrap();
    let mut sweep = Sweep::of(&problem).unwrap();
    let answer = sweep.solve().unwrap();
    assert_eq!(answer.eigenvalues().len(), 3);
    assert!(
        answer
            .eigenvalues()
            .iter()
            .all(|root| root.re == 0.0 && root.im > 0.0)
    );
    agree(&system, vec![], &mut sweep);
}

#[test]
fn what_cannot_be_swept_is_refused() {
    let system = chain(&MASSES, &SPRINGS, &DAMPERS);
    let grid = TimeGrid::new(0.1, 20.0).unwrap();
    let problem = Problem::new(&system, &start(), vec![], grid).unwrap();
    let chosen = problem.clone().at(&[3]).unwrap();
    assert_eq!(Sweep::of(&chosen).err(), Some(SweepError::Wanted));
    let mut sweep = Sweep::of(&problem).unwrap();
    for (parameter, value) in [
        (Parameter::Mass(0), 0.0),
        (Parameter::Mass(0), f64::NAN),
        (Parameter::Spring(0), -1.0),
        (Parameter::Damper(3), f64::INFINITY),
    ] {
        let refused = sweep.set(parameter, value).unwrap_err();
        assert!(matches!(refused, DesignError::Value { .. }), "{refused}");
    }
    let unknown = sweep.set(Parameter::Spring(4), 1.0).unwrap_err();
    assert!(matches!(unknown, DesignError::Unknown { .. }), "{unknown}");
    sweep.set(Parameter::Spring(0), 0.0).unwrap();
    sweep.solve().unwrap();
    sweep.set(Parameter::Spring(3), 0.0).unwrap();
    assert_eq!(
        sweep.solve().err(),
        Some(SweepError::Design(DesignError::NotHeld))
    );
    sweep.set(Parameter::Spring(3), 1e308).unwrap();
    sweep.set(Parameter::Mass(2), 1e-300).unwrap();
    assert!(sweep.solve().is_err());
    let long = Problem::new(&system, &start(), vec![], TimeGrid::new(1e-9, 1.0).unwrap()).unwrap();
    assert!(matches!(Sweep::of(&long), Err(SweepError::TooLarge { .. })));
}

/// The same bits by one thread and by several, and one design after another.
#[cfg(feature = "rayon")]
#[test]
fn threads_change_no_bit() {
    let system = chain(&MASSES, &SPRINGS, &DAMPERS);
    let grid = TimeGrid::new(0.4, 10.0).expect("a grid");
    let problem = Problem::new(&system, &start(), loads(), grid).expect("a problem");
    let mut sweep = Sweep::of(&problem).expect("it can be swept");
    let designs: Vec<f64> = (1..=40).map(|k| 0.3 * f64::from(k)).collect();
    let set = |sweep: &mut Sweep, value: f64| sweep.set(Parameter::Spring(0), value);
    let bits = |answer: eigentone_response::Answer<'_>| {
        let motion = answer.displacement();
        let columns = (0..motion.ncols()).flat_map(|j| (0..motion.nrows()).map(move |i| (i, j)));
        let motion = columns.map(|at| motion[at].to_bits());
        let roots = answer.eigenvalues().iter();
        let roots = roots.flat_map(|root| [root.re.to_bits(), root.im.to_bits()]);
        motion.chain(roots).collect::<Vec<u64>>()
    };
    let one_by_one: Vec<_> = sweep.each(designs.clone(), set, bits).collect();
    assert!(one_by_one.iter().all(Result::is_ok));
    for threads in [1, 2, 3, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.expect("threads can be started");
        let together = pool.install(|| sweep.each_in_parallel(designs.clone(), set, bits));
        assert_eq!(together, one_by_one, "{threads} threads");
    }
}
