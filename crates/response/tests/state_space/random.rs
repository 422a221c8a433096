//! Root mean squares under white noise against closed forms, and against ∫ |H|² S df with 40 digits (mpmath's quadrature).

use eigentone_modes::{GROUND, System};
use eigentone_response::{
    Combination, Quantity, Rms, StateSpaceError, StationaryMotion, Sum, WhiteNoise,
};

use Quantity::{Acceleration, Displacement, Velocity};

fn system(builder: eigentone_modes::SystemBuilder) -> System {
    builder.build().expect("a system")
}

fn one(m: f64, c: f64, k: f64) -> System {
    let one = System::builder().support("base").mass("m", m);
    system(one.spring("base", "m", k).damper("base", "m", c))
}

fn between(name: &str, quantity: Quantity, first: &str, second: &str) -> Combination {
    let motions = vec![
        (quantity, second.into(), 1.0),
        (quantity, first.into(), -1.0),
    ];
    Combination {
        name: name.into(),
        of: Sum::Motions(motions),
    }
}

fn pull(name: &str) -> Combination {
    Combination {
        name: name.into(),
        of: Sum::Pull(name.into()),
    }
}

fn solved(noise: WhiteNoise<'_>) -> StationaryMotion {
    noise.solve().expect("a stationary motion")
}

fn of<'m>(all: &'m [(String, Rms)], name: &str) -> &'m Rms {
    let found = all.iter().find(|(known, _)| known == name);
    &found.expect("it is asked for").1
}

/// Within the bound, which is that of rounding, and what is known of the truth.
#[track_caller]
fn is(rms: &Rms, truth: f64, known: f64) {
    let Rms::Finite { value, bound } = rms else {
        panic!("{rms:?} is not {truth:e}");
    };
    assert!(
        (value - truth).abs() <= bound + known * truth,
        "{value:e} ± {bound:e}, not {truth:e}"
    );
    assert!(
        *bound <= value * 2f64.powi(-53) * 1.001,
        "{value:e} ± {bound:e}"
    );
}

#[track_caller]
fn is_infinite(rms: &Rms, noise: &str) {
    assert_eq!(
        *rms,
        Rms::Infinite {
            by: noise.to_owned()
        }
    );
}

/// σ² = S/4ck and S/4cm, down to next to no damping.
#[test]
fn one_mass_under_a_white_force() {
    for c in [1e3, 0.5, 1e-9, 1e-14] {
        let one = one(2.0, c, 8.0);
        let relative = between("relative", Displacement, "base", "m");
        let motion = solved(WhiteNoise::of(&one).force("m", 3.0).output(relative));
        is(
            of(motion.displacement(), "m"),
            (3.0 / (4.0 * c * 8.0)).sqrt(),
            4e-16,
        );
        is(
            of(motion.velocity(), "m"),
            (3.0 / (4.0 * c * 2.0)).sqrt(),
            4e-16,
        );
        is_infinite(of(motion.acceleration(), "m"), "m force");
        // Twice a second times 2π, whatever the damping.
        let crossings = motion.zero_crossings();
        let Some(Rms::Finite { value, bound }) = crossings[0].1 else {
            panic!("it swings")
        };
        let truth = std::f64::consts::FRAC_1_PI;
        assert!(
            (value - truth).abs() <= bound && bound < 2e-15,
            "{value} ± {bound}"
        );
        is(
            of(motion.outputs(), "relative"),
            (3.0 / (4.0 * c * 8.0)).sqrt(),
            4e-16,
        );
    }
}

/// Relative to the base, S m/4ck·m; the absolute acceleration, S ω₀(1 + 4ζ²)/8ζ; all else wanders with the base.
#[test]
fn one_mass_on_a_base_of_white_acceleration() {
    for c in [0.5, 1e-9] {
        let (m, k) = (2.0, 8.0);
        let one = one(m, c, k);
        let motion = solved(
            WhiteNoise::of(&one)
                .motion("base", Acceleration, 3.0)
                .output(between("x", Displacement, "base", "m"))
                .output(between("v", Velocity, "base", "m"))
                .output(between("a", Acceleration, "base", "m")),
        );
        is_infinite(of(motion.displacement(), "m"), "base acceleration");
        is_infinite(of(motion.velocity(), "m"), "base acceleration");
        let (omega, zeta) = ((k / m).sqrt(), c / (2.0 * (k * m).sqrt()));
        let acceleration = 3.0 * omega * (1.0 + 4.0 * zeta * zeta) / (8.0 * zeta);
        is(of(motion.acceleration(), "m"), acceleration.sqrt(), 1e-15);
        is(
            of(motion.outputs(), "x"),
            (3.0 * m * m / (4.0 * c * k)).sqrt(),
            4e-16,
        );
        is(
            of(motion.outputs(), "v"),
            (3.0 * m / (4.0 * c)).sqrt(),
            4e-16,
        );
        is_infinite(of(motion.outputs(), "a"), "base acceleration");
    }
}

#[test]
fn two_masses_agree_with_quadrature() {
    let pair = System::builder().mass("a", 2.0).mass("b", 1.0);
    let pair = pair.spring(GROUND, "a", 8.0).damper(GROUND, "a", 0.5);
    let pair = system(pair.spring("a", "b", 3.0).damper("a", "b", 0.25));
    let noise = WhiteNoise::of(&pair).force("b", 0.5).force("b", 1.5);
    let motion = solved(noise.output(between("stretch", Displacement, "a", "b")));
    is(
        of(motion.displacement(), "a"),
        0.460_501_540_368_740_9,
        1e-14,
    );
    is(
        of(motion.displacement(), "b"),
        1.118_552_102_913_712_5,
        1e-14,
    );
    is(of(motion.velocity(), "a"), 0.666_162_647_038_658_7, 1e-14);
    is(of(motion.velocity(), "b"), 1.512_143_509_308_842_3, 1e-14);
    is(of(motion.acceleration(), "a"), 1.120_296_158_373_645, 1e-14);
    is_infinite(of(motion.acceleration(), "b"), "b force");
    is(
        of(motion.outputs(), "stretch"),
        0.701_814_312_551_903_2,
        1e-14,
    );
}

fn car() -> System {
    let car = System::builder()
        .support("road")
        .mass("body", 256.0)
        .mass("wheel", 32.0);
    let car = car
        .spring("wheel", "body", 16384.0)
        .damper("wheel", "body", 1024.0);
    system(car.spring("road", "wheel", 131_072.0).named("tyre"))
}

#[test]
fn a_car_on_white_roads_agrees_with_quadrature() {
    let car = car();
    let on = |quantity| {
        let noise = WhiteNoise::of(&car).motion("road", quantity, 1e-3);
        let noise = noise.output(between("travel", Displacement, "wheel", "body"));
        solved(noise.output(pull("tyre")))
    };
    let motion = on(Velocity);
    is(
        of(motion.outputs(), "travel"),
        0.008_385_254_915_624_211,
        1e-14,
    );
    is(of(motion.outputs(), "tyre"), 403.514_797_746_005_84, 1e-14);
    is(
        of(motion.acceleration(), "body"),
        0.894_427_190_999_915_9,
        1e-14,
    );
    is(
        of(motion.acceleration(), "wheel"),
        11.303_804_669_225_32,
        1e-14,
    );
    is(
        of(motion.velocity(), "body"),
        0.075_880_251_053_880_94,
        1e-14,
    );
    is_infinite(of(motion.displacement(), "body"), "road velocity");
    let motion = on(Acceleration);
    is(
        of(motion.outputs(), "travel"),
        0.001_063_511_983_598_592_3,
        1e-14,
    );
    is(of(motion.outputs(), "tyre"), 20.673_654_732_533_384, 1e-14);
    is(
        of(motion.acceleration(), "body"),
        0.075_880_251_053_880_94,
        1e-14,
    );
    is(
        of(motion.acceleration(), "wheel"),
        0.169_581_285_818_925_2,
        1e-14,
    );
    is_infinite(of(motion.velocity(), "body"), "road acceleration");
}

/// A massless node between spring and damper, on the moving base: its motion beside the ride is that of a mass held by both
/// in a row, whatever its displacement in the form.
#[test]
fn nodes_without_mass_ride_along() {
    let build = |first: &str| {
        let row = System::builder()
            .support("base")
            .mass("m", 2.0)
            .mass("node", 0.0);
        let row = row.spring(first, "m", 8.0).spring(first, "node", 4.0);
        system(row.damper("node", "m", 0.5))
    };
    let (fixed, shaken) = (build(GROUND), build("base"));
    let pushed = solved(WhiteNoise::of(&fixed).force("m", 12.0));
    let noise = WhiteNoise::of(&shaken).motion("base", Acceleration, 3.0);
    let noise = noise.output(between("m", Displacement, "base", "m"));
    let ridden = solved(noise.output(between("node", Displacement, "base", "node")));
    for name in ["m", "node"] {
        let Rms::Finite { value, .. } = of(pushed.displacement(), name) else {
            panic!("it is held")
        };
        is(of(ridden.outputs(), name), *value, 3e-16);
    }
}

#[test]
fn what_does_not_come_to_rest_is_refused_by_name() {
    let undamped = one(1.0, 0.0, 1.0);
    let refused = WhiteNoise::of(&undamped).force("m", 1.0).solve();
    let what = "an undamped mode".to_owned();
    assert_eq!(refused, Err(StateSpaceError::NotStationary { what }));

    let free = System::builder().mass("a", 1.0).mass("b", 1.0);
    let free = system(free.spring("a", "b", 1.0).damper("a", "b", 1.0));
    let refused = WhiteNoise::of(&free).force("a", 1.0).solve();
    let what = "the rigid motion of \"a\", \"b\"".to_owned();
    assert_eq!(refused, Err(StateSpaceError::NotStationary { what }));

    // A damper to the ground holds back what the base carries along.
    let held = System::builder().support("base").mass("m", 1.0);
    let held = system(held.spring("base", "m", 1.0).damper(GROUND, "m", 1.0));
    let refused = WhiteNoise::of(&held).motion("base", Velocity, 1.0).solve();
    let (support, quantity) = ("base".to_owned(), "velocity");
    assert_eq!(refused, Err(StateSpaceError::Wanders { support, quantity }));
    let shaken = WhiteNoise::of(&held).motion("base", Displacement, 4.0);
    is(of(solved(shaken).displacement(), "m"), 1.0, 0.0);

    let refused = WhiteNoise::of(&held).force("m", -1.0).solve();
    let (name, density) = ("m".to_owned(), -1.0);
    assert_eq!(
        refused,
        Err(StateSpaceError::NoiseDensity { name, density })
    );
}

/// What the noise does not reach does not move.
#[test]
fn rest_stays_rest() {
    let two = System::builder().mass("a", 1.0).mass("b", 1.0);
    let two = two.spring(GROUND, "a", 1.0).damper(GROUND, "a", 1.0);
    let two = system(two.spring(GROUND, "b", 1.0).damper(GROUND, "b", 1.0));
    let motion = solved(WhiteNoise::of(&two).force("a", 4.0));
    is(of(motion.displacement(), "a"), 1.0, 0.0);
    let Rms::Finite { value, bound } = of(motion.displacement(), "b") else {
        panic!("it rests")
    };
    assert!(*value == 0.0 && *bound < 1e-29, "{value} ± {bound}");
}
