//! Proven responses of generated systems: with 32 and with 154 digits they agree within their bounds,
//! and the methods in doubles come close where nothing is stiff.

use eigentone_digits::{DoubleDouble, Real, Wide};
use eigentone_modes::System;
use proptest::prelude::*;

use super::attempt::Attempt;
use super::march::March;
use super::stepper::Stepper;
use crate::answer::{Trajectory, Wanted};
use crate::plan::{Response, methods};
use crate::problem::{
    HalfSine, Harmonic, Hold, Impulse, Load, Polynomial, Problem, Quantity, Ramp, Samples, State,
    Step, Versine,
};

/// A link of two nodes, of which 0 is the ground, and its coefficient.
type Link = (usize, usize, f64);

#[derive(Clone, Debug)]
struct Asked {
    masses: Vec<f64>,
    springs: Vec<Link>,
    dampers: Vec<Link>,
    /// By coordinate, from 0.
    initial: Vec<(f64, f64)>,
    loads: Vec<(usize, Load)>,
    /// How what node 0 stands for moves, where it is no ground but a support.
    motions: Vec<(Quantity, Load)>,
    /// A point that moves with a node and the support by these factors, with a mass and a load.
    point: Option<(usize, [f64; 2], f64, Load)>,
}

const STEP: f64 = 0.1;
const END: f64 = 3.0;

impl Asked {
    fn name(&self, node: usize) -> String {
        match node {
            0 if self.motions.is_empty() => eigentone_modes::GROUND.to_owned(),
            0 => "s".to_owned(),
            i => format!("m{i}"),
        }
    }
}

fn sized(decades: f64) -> impl Strategy<Value = f64> + Clone {
    let size = (-decades..=decades).prop_map(|exponent| 10f64.powf(exponent));
    (size, any::<bool>()).prop_map(|(size, negative)| if negative { -size } else { size })
}

/// On the grid, off it, or before 0.
fn moment() -> impl Strategy<Value = f64> {
    prop_oneof![
        (0..=30u32).prop_map(|k| f64::from(k) * STEP),
        0.0..END,
        -10.0..0.0,
    ]
}

fn load() -> impl Strategy<Value = Load> {
    let size = || sized(3.0);
    let samples = |(step, values, first)| Samples {
        step,
        values,
        hold: if first { Hold::First } else { Hold::Zero },
    };
    let spacing = prop::sample::select(vec![STEP, 3.0 * STEP, STEP / 2.0, STEP / 3.0]);
    let values = prop::collection::vec(-1.0..1.0, 1..12);
    prop_oneof![
        (size(), moment()).prop_map(|(force, start)| Step { force, start }.into()),
        (size(), moment()).prop_map(|(rate, start)| Ramp { rate, start }.into()),
        (size(), moment()).prop_map(|(magnitude, at)| {
            let at = at.max(0.0);
            Impulse { magnitude, at }.into()
        }),
        (size(), sized(2.0), -10.0..10.0).prop_map(|(amplitude, frequency, phase)| {
            Harmonic {
                amplitude,
                frequency,
                phase,
            }
            .into()
        }),
        (spacing, values, any::<bool>()).prop_map(move |given| samples(given).into()),
        (size(), 0.01..2.0, moment()).prop_map(|(force, duration, start)| {
            HalfSine::of(force, duration)
                .starting_at(f64::max(start, 0.0))
                .into()
        }),
        (prop::collection::vec(-1.0..1.0, 1..8), moment()).prop_map(|(coefficients, start)| {
            Polynomial::of(coefficients)
                .starting_at(f64::max(start, 0.0))
                .into()
        }),
        (size(), 0.01..2.0, moment()).prop_map(|(force, duration, start)| {
            Versine::of(force, duration)
                .starting_at(f64::max(start, 0.0))
                .into()
        }),
    ]
}

fn motion() -> impl Strategy<Value = (Quantity, Load)> {
    let quantities = [
        Quantity::Displacement,
        Quantity::Velocity,
        Quantity::Acceleration,
    ];
    let course = load().prop_filter("a force", |load| !matches!(load, Load::Impulse(_)));
    (prop::sample::select(quantities.to_vec()), course)
}

/// 2 to 6 masses in a chain with springs across, where coefficients spread over so many decades to
/// either side of 1.
fn asked(decades: f64) -> impl Strategy<Value = Asked> {
    (2..=6usize).prop_flat_map(move |n| {
        let positive = || sized(decades).prop_map(f64::abs);
        let across = (0..=n, 0..=n, positive());
        let masses = prop::collection::vec(sized(decades / 4.0).prop_map(f64::abs), n);
        let along = prop::collection::vec(positive(), n);
        let springs = prop::collection::vec(across.clone(), 0..3);
        let dampers = prop::collection::vec(across, 0..4);
        let initial = prop::collection::vec((-1.0..1.0, -1.0..1.0), n);
        let loads = prop::collection::vec((1..=n, load()), 0..4);
        let motions = prop::collection::vec(motion(), 0..3);
        let point = prop::option::of((1..=n, [-2.0..2.0, -2.0..2.0], 0.0..2.0, load()));
        (
            masses,
            along,
            springs,
            dampers,
            initial,
            loads,
            (motions, point),
        )
            .prop_map(
                |(masses, along, springs, dampers, initial, loads, (motions, point))| {
                    let along = along.into_iter().enumerate().map(|(i, k)| (i, i + 1, k));
                    let joins = |link: &Link| link.0 != link.1;
                    Asked {
                        masses,
                        springs: along.chain(springs).filter(joins).collect(),
                        dampers: dampers.into_iter().filter(joins).collect(),
                        initial,
                        loads,
                        motions,
                        point,
                    }
                },
            )
    })
}

impl Asked {
    fn system(&self) -> System {
        let mut builder = System::builder();
        for (i, mass) in self.masses.iter().enumerate() {
            builder = builder.mass(self.name(i + 1), *mass);
        }
        if !self.motions.is_empty() {
            builder = builder.support("s");
        }
        if let Some((node, [a, b], mass, _)) = &self.point {
            // A mass on a support that jumps is refused.
            let jumps = |(quantity, _): &(Quantity, Load)| *quantity == Quantity::Displacement;
            let mass = if self.motions.iter().any(jumps) {
                0.0
            } else {
                *mass
            };
            let mut moves = vec![(self.name(*node), *a)];
            moves.extend((!self.motions.is_empty()).then(|| (self.name(0), *b)));
            builder = builder.point("p", moves, mass);
            builder = builder
                .spring("p", self.name(1), 1.0)
                .damper("p", self.name(1), 0.1);
        }
        for &(i, j, stiffness) in &self.springs {
            builder = builder.spring(self.name(i), self.name(j), stiffness);
        }
        for &(i, j, damping) in &self.dampers {
            builder = builder.damper(self.name(i), self.name(j), damping);
        }
        builder.build().expect("every mass is positive")
    }

    fn problem<'a>(&self, system: &'a System) -> Problem<'a> {
        let mut state = State::at_rest();
        for (i, &(x, v)) in self.initial.iter().enumerate() {
            state = state
                .displace(self.name(i + 1), x)
                .push(self.name(i + 1), v);
        }
        let mut response = Response::of(system).from(state).every(STEP).until(END);
        for (i, load) in &self.loads {
            response = response.load(self.name(*i), load.clone());
        }
        for (quantity, course) in &self.motions {
            response = response.motion("s", *quantity, course.clone());
        }
        if let Some((_, _, _, load)) = &self.point {
            response = response.load("p", load.clone());
        }
        let place = |node| {
            (
                Quantity::Displacement,
                self.name(node),
                if node == 0 { -1.0 } else { 1.0 },
            )
        };
        response = response.sum("relative", [place(1), place(0)]);
        let rates = [
            (Quantity::Velocity, self.name(2), 2.0),
            (Quantity::Acceleration, self.name(1), -0.3),
        ];
        response = response.sum("mixed", rates);
        response.problem().expect("all names are known")
    }
}

/// The answer in the arithmetic of T, by a generator in that of G, however good.
fn certified<T: Real, G: Real>(problem: &Problem<'_>) -> Trajectory {
    let march = March {
        problem,
        wanted: Wanted::Grid,
        method: "test",
        tolerance: f64::EPSILON,
        last: true,
    };
    match march
        .by(Stepper::<T>::of::<G>(problem))
        .expect("nothing grows")
    {
        Attempt::Found(trajectory) => *trajectory,
        _ => panic!("no mass is 0"),
    }
}

/// The largest difference of each instant, of displacements and of velocities.
fn differences(a: &Trajectory, b: &Trajectory) -> Vec<[f64; 2]> {
    let off = |a: faer::MatRef<'_, f64>, b: faer::MatRef<'_, f64>, at: usize| {
        let each = (0..a.nrows()).map(|i| (a[(i, at)] - b[(i, at)]).abs());
        each.fold(0.0, f64::max)
    };
    let instant = |at| {
        [
            off(a.displacement(), b.displacement(), at),
            off(a.velocity(), b.velocity(), at),
        ]
    };
    (0..a.len()).map(instant).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn digits_agree_within_their_bounds(asked in asked(8.0)) {
        let system = asked.system();
        let problem = asked.problem(&system);
        let few = certified::<DoubleDouble, DoubleDouble>(&problem);
        let prepared = certified::<DoubleDouble, Wide<4>>(&problem);
        let many = certified::<Wide<8>, Wide<8>>(&problem);
        let bounds = |one: &Trajectory, at: usize| {
            [one.displacement_bound()[at], one.velocity_bound()[at]].map(|bound| bound.expect("proven"))
        };
        for few in [few, prepared] {
            for output in 0..2 {
                for at in 0..few.len() {
                    let off = (few.output(output)[at] - many.output(output)[at]).abs();
                    let [a, b] = [&few, &many].map(|one| one.output_bound(output)[at].expect("proven"));
                    prop_assert!(off <= (a + b) * (1.0 + f64::EPSILON), "{output}: {off:e} {a:e} {b:e} at {at}");
                }
            }
            for (at, off) in differences(&few, &many).into_iter().enumerate() {
                for (off, (a, b)) in off.into_iter().zip(bounds(&few, at).into_iter().zip(bounds(&many, at))) {
                    prop_assert!(off <= (a + b) * (1.0 + f64::EPSILON), "{:e} > {:e} + {:e} at {}", off, a, b, at);
                }
            }
        }
    }

    /// Doubles lose few digits of the largest motion.
    #[test]
    fn doubles_come_close_where_nothing_is_stiff(asked in asked(1.0)) {
        let system = asked.system();
        let problem = asked.problem(&system);
        let proven = certified::<DoubleDouble, DoubleDouble>(&problem);
        let most = [proven.displacement().norm_max(), proven.velocity().norm_max()];
        for method in methods().iter().filter(|method| method.refuses(&problem).is_none()) {
            let found = method.run(&problem).expect("it does not refuse");
            for output in 0..2 {
                for at in 0..found.len() {
                    let off = (found.output(output)[at] - proven.output(output)[at]).abs();
                    let known = proven.output_bound(output)[at].expect("proven");
                    if let Some(bound) = found.output_bound(output)[at] {
                        prop_assert!(off <= bound + known, "{} {output}: {off:e} > {bound:e} at {at}", method.name());
                    }
                }
            }
            for at in 0..found.len() {
                let bounds = [found.displacement_bound()[at], found.velocity_bound()[at]];
                let off = differences(&proven, &found)[at];
                for (off, bound) in off.into_iter().zip(bounds) {
                    prop_assert!(bound.is_none_or(|bound| off <= bound * 1.0001), "{}: {off:e} > {bound:?} at {at}", method.name());
                }
            }
            for (at, off) in differences(&proven, &found).into_iter().enumerate() {
                for (off, most) in off.into_iter().zip(most) {
                    prop_assert!(off <= 1e-12 * most, "{}: {:e} of {:e} at {}", method.name(), off, most, at);
                }
            }
        }
    }
}
