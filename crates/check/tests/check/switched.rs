//! Motions with switches on supports that move, drawn at random: the exact ones against integrators that locate events.

use eigentone_check::{EventDriven, Limit, OneStep, TrajectoryError};
use eigentone_modes::{GROUND, System};
use eigentone_response::{Harmonic, Quantity, Ramp, Response, State};
use eigentone_switching::{
    ControlledDamper, DamperLaw, EventKind, Friction, Impact, Stop, Switch, Switching,
    SwitchingError,
};
use proptest::collection::vec;
use proptest::prelude::*;

/// A chain of masses between the ground and a support, with the places of switches.
#[derive(Clone, Debug)]
struct Drawn {
    masses: Vec<f64>,
    springs: Vec<f64>,
    dampers: Vec<f64>,
    start: Vec<(f64, f64)>,
    /// Amplitude and frequency of the support, and the speed at which it goes on.
    shake: (f64, f64, f64),
    switches: Vec<(u8, usize, usize, [f64; 3])>,
}

fn drawn() -> impl Strategy<Value = Drawn> {
    (1usize..5).prop_flat_map(|n| {
        let numbers = [0.1..3.0f64, 1.0..1.6f64, 0.02..0.3f64];
        let switch = (0u8..6, 0..n + 2, 0..n + 2, numbers);
        (
            vec(0.2..3.0f64, n),
            vec(20.0..300.0f64, n + 1),
            vec(0.0..1.0f64, n + 1),
            vec((-0.015..0.015f64, -1.0..1.0f64), n),
            (0.0..0.02f64, 1.0..20.0f64, -0.3..0.3f64),
            vec(switch, 1..4),
        )
            .prop_map(|(masses, springs, dampers, start, shake, switches)| Drawn {
                masses,
                springs,
                dampers,
                start,
                shake,
                switches,
            })
    })
}

impl Drawn {
    fn name(&self, place: usize) -> String {
        match place {
            0 => GROUND.to_owned(),
            place if place > self.masses.len() => "support".to_owned(),
            place => format!("m{place}"),
        }
    }

    fn system(&self) -> System {
        let mut builder = System::builder().support("support");
        for (i, mass) in self.masses.iter().enumerate() {
            builder = builder.mass(self.name(i + 1), *mass);
        }
        for (i, (spring, damper)) in self.springs.iter().zip(&self.dampers).enumerate() {
            let [a, b] = [i, i + 1].map(|place| self.name(place));
            builder = builder.spring(&a, &b, *spring).damper(a, b, *damper);
        }
        builder.build().expect("a chain")
    }

    /// None between the ground and the support, and one controlled damper at most: what several share out at v_b = 0 is not
    /// unique.
    fn switches(&self) -> Vec<Switch> {
        let last = self.masses.len() + 1;
        let mut controlled = 0;
        let all = self
            .switches
            .iter()
            .filter_map(|&(kind, a, b, [force, ratio, gap])| {
                if a == b || a + b == last && a * b == 0 {
                    return None;
                }
                let between = [a, b].map(|place| self.name(place));
                Some(match kind {
                    0 | 1 => Switch::Friction(Friction {
                        between,
                        force,
                        static_force: force,
                    }),
                    2 => Switch::Stop(Stop {
                        between,
                        gap,
                        stiffness: 2e3 * ratio,
                        damping: force,
                    }),
                    3 => Switch::Impact(Impact {
                        between,
                        gap,
                        restitution: 3.0 * gap,
                    }),
                    _ => {
                        controlled += 1;
                        if controlled > 1 {
                            return None;
                        }
                        let law = match kind {
                            4 => DamperLaw::OnOffSkyhook,
                            _ => DamperLaw::ClippedSkyhook { sky: 3.0 * force },
                        };
                        Switch::ControlledDamper(ControlledDamper {
                            between,
                            low: force,
                            high: 4.0 * force,
                            law,
                        })
                    }
                })
            });
        all.collect()
    }
}

fn examine(drawn: &Drawn) -> Result<(), TestCaseError> {
    let system = drawn.system();
    let mut state = State::at_rest();
    for (i, (x, v)) in drawn.start.iter().enumerate() {
        state = state
            .displace(drawn.name(i + 1), *x)
            .push(drawn.name(i + 1), *v);
    }
    let (amplitude, frequency, speed) = drawn.shake;
    let problem = Response::of(&system)
        .from(state)
        .motion(
            "support",
            Quantity::Displacement,
            Harmonic::of(amplitude, frequency),
        )
        .motion("support", Quantity::Displacement, Ramp::of(speed))
        .every(0.0625)
        .until(1.0)
        .problem()
        .expect("a problem");
    let switches = drawn.switches();
    let exact = Switching::new(&problem, switches.clone()).and_then(|switching| switching.run());
    let exact = match exact {
        Ok(exact) => exact,
        Err(SwitchingError::Dependent { .. } | SwitchingError::Switch { .. }) => return Ok(()),
        Err(SwitchingError::Undecided { reason, .. }) if reason.contains("die out") => {
            return Ok(());
        }
        // A mass that is squeezed between a wall and a support has no way out.
        Err(SwitchingError::Endless { .. })
            if switches
                .iter()
                .filter(|one| matches!(one, Switch::Impact(_)))
                .count()
                > 1 =>
        {
            return Ok(());
        }
        Err(error) => return Err(TestCaseError::fail(error.to_string())),
    };
    // Bounces that die out are cut short by the integrators, each in its own way.
    let bounces = exact
        .events()
        .iter()
        .filter(|event| event.kind == EventKind::Impact);
    if bounces.count() > 20 {
        return Ok(());
    }
    // What comes and goes within a step they miss.
    let shortest = 2.0 * 0.0625 / 128.0;
    let hurries = |switch: usize| {
        let own = exact.events().iter().filter(|event| event.switch == switch);
        let times: Vec<f64> = own.map(|event| event.time).collect();
        times.windows(2).any(|pair| pair[1] - pair[0] < shortest)
    };
    if (0..switches.len()).any(hurries) {
        return Ok(());
    }
    let integrated = |substeps: u32| {
        let method = EventDriven {
            method: OneStep::Dop853,
            substeps,
        };
        method.integrate(&problem, &switches, Limit::default())
    };
    let (Ok(coarse), Ok(fine)) = (integrated(64), integrated(128)) else {
        return Ok(());
    };
    let apart = TrajectoryError::between(&coarse.trajectory, &fine.trajectory).worst();
    if apart > 1e-7 {
        return Ok(());
    }
    let off = TrajectoryError::between(&fine.trajectory, exact.trajectory()).worst();
    prop_assert!(
        off < 1e-6 + 100.0 * apart,
        "{off:e}, two integrations {apart:e}\n{:?}\n{:?}",
        exact.events(),
        fine.events
    );
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, max_shrink_iters: 8, ..ProptestConfig::default() })]

    #[test]
    fn motions_with_switches_are_those_of_integrators(drawn in drawn()) {
        examine(&drawn)?;
    }
}
