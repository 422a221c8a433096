//! Root mean squares under white noise against closed forms, and against ∫ |H|² S df with 40 digits (mpmath's quadrature).

use eigentone_modes::{GROUND, MatrixKind, System};
use eigentone_response::{
    Noise, Quantity, RandomVibration, Rms, StateSpaceError, StationaryMotion, Statistics, Weighting,
};

use crate::systems::{between, pull, sum};

use Quantity::{Acceleration, Displacement, Velocity};

fn system(builder: eigentone_modes::SystemBuilder) -> System {
    builder.build().expect("a system")
}

fn one(m: f64, c: f64, k: f64) -> System {
    let one = System::builder().support("base").mass("m", m);
    system(one.spring("base", "m", k).damper("base", "m", c))
}

fn solved(noise: RandomVibration<'_>) -> StationaryMotion {
    noise.solve().expect("a stationary motion")
}

fn of<'m>(all: &'m [Statistics], name: &str) -> &'m Rms {
    let found = all.iter().find(|known| known.name == name);
    &found.expect("it is asked for").rms
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
        let motion = solved(RandomVibration::of(&one).force("m", 3.0).output(relative));
        for (all, name, truth) in [
            (motion.displacement(), "m", (3.0 / (4.0 * c * 8.0)).sqrt()),
            (motion.velocity(), "m", (3.0 / (4.0 * c * 2.0)).sqrt()),
        ] {
            is(of(all, name), truth, 4e-16);
        }
        is_infinite(of(motion.acceleration(), "m"), "m force");
        // Twice a second times 2π, whatever the damping.
        let crossings = motion.displacement()[0].zero_crossings();
        let (value, bound) = crossings.expect("it swings");
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
            RandomVibration::of(&one)
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
        for (all, name, truth) in [
            (motion.outputs(), "x", (3.0 * m * m / (4.0 * c * k)).sqrt()),
            (motion.outputs(), "v", (3.0 * m / (4.0 * c)).sqrt()),
        ] {
            is(of(all, name), truth, 4e-16);
        }
        is_infinite(of(motion.outputs(), "a"), "base acceleration");
    }
}

#[test]
fn two_masses_agree_with_quadrature() {
    let pair = System::builder().mass("a", 2.0).mass("b", 1.0);
    let pair = pair.spring(GROUND, "a", 8.0).damper(GROUND, "a", 0.5);
    let pair = system(pair.spring("a", "b", 3.0).damper("a", "b", 0.25));
    let noise = RandomVibration::of(&pair).force("b", 0.5).force("b", 1.5);
    let motion = solved(noise.output(between("stretch", Displacement, "a", "b")));
    for (all, name, truth) in [
        (motion.displacement(), "a", 0.460_501_540_368_740_9),
        (motion.displacement(), "b", 1.118_552_102_913_712_5),
        (motion.velocity(), "a", 0.666_162_647_038_658_7),
        (motion.velocity(), "b", 1.512_143_509_308_842_3),
        (motion.acceleration(), "a", 1.120_296_158_373_645),
    ] {
        is(of(all, name), truth, 1e-14);
    }
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
        let noise = RandomVibration::of(&car).motion("road", quantity, 1e-3);
        let noise = noise.output(between("travel", Displacement, "wheel", "body"));
        solved(noise.output(pull("tyre")))
    };
    let motion = on(Velocity);
    for (all, name, truth) in [
        (motion.outputs(), "travel", 0.008_385_254_915_624_211),
        (motion.outputs(), "tyre", 403.514_797_746_005_84),
        (motion.acceleration(), "body", 0.894_427_190_999_915_9),
        (motion.acceleration(), "wheel", 11.303_804_669_225_32),
        (motion.velocity(), "body", 0.075_880_251_053_880_94),
    ] {
        is(of(all, name), truth, 1e-14);
    }
    is_infinite(of(motion.displacement(), "body"), "road velocity");
    let motion = on(Acceleration);
    for (all, name, truth) in [
        (motion.outputs(), "travel", 0.001_063_511_983_598_592_3),
        (motion.outputs(), "tyre", 20.673_654_732_533_384),
        (motion.acceleration(), "body", 0.075_880_251_053_880_94),
        (motion.acceleration(), "wheel", 0.169_581_285_818_925_2),
    ] {
        is(of(all, name), truth, 1e-14);
    }
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
    let pushed = solved(RandomVibration::of(&fixed).force("m", 12.0));
    let noise = RandomVibration::of(&shaken).motion("base", Acceleration, 3.0);
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
    let refused = RandomVibration::of(&undamped).force("m", 1.0).solve();
    let what = "an undamped mode".to_owned();
    assert_eq!(refused, Err(StateSpaceError::NotStationary { what }));

    // Gyroscopic forces do no work.
    let whirl = faer::mat![[0.0, 0.5], [-0.5, 0.0]];
    let rotor = System::builder().mass("x", 1.0).mass("y", 1.0);
    let rotor = rotor.spring(GROUND, "x", 4.0).spring(GROUND, "y", 5.0);
    let rotor = system(rotor.matrix(MatrixKind::Damping, whirl.as_ref()));
    let refused = RandomVibration::of(&rotor).force("x", 1.0).solve();
    let what = "each of 2 undamped modes".to_owned();
    assert_eq!(refused, Err(StateSpaceError::NotStationary { what }));

    // Nor do they beside a node without mass, or where they hold up what springs push over.
    let without_damping = || {
        Err(StateSpaceError::NotStationary {
            what: "what has no damping".to_owned(),
        })
    };
    let whirl = faer::mat![[0.0, 5.0, 0.0], [-5.0, 0.0, 0.0], [0.0, 0.0, 0.0]];
    let rotor = System::builder()
        .mass("x", 1.0)
        .mass("y", 1.0)
        .mass("n", 0.0);
    let rotor = rotor.spring("x", "n", 4.0).spring(GROUND, "n", 5.0);
    for stiffness in [3.0, -3.0] {
        let rotor = rotor
            .clone()
            .spring(GROUND, "y", stiffness)
            .spring(GROUND, "x", stiffness);
        let rotor = system(rotor.matrix(MatrixKind::Damping, whirl.as_ref()));
        assert_eq!(
            RandomVibration::of(&rotor).force("x", 1.0).solve(),
            without_damping()
        );
    }

    // What grows at 1e-14 1/s, through a weighting too.
    let slow = one(1.0, -2e-14, 100.0);
    let slow = RandomVibration::of(&slow).force("m", 1.0);
    let what = "a mode that grows".to_owned();
    let grows = || Err(StateSpaceError::NotStationary { what: what.clone() });
    assert_eq!(slow.solve(), grows());
    assert_eq!(slow.weighted(Weighting::Vertical), grows());

    let free = System::builder().mass("a", 1.0).mass("b", 1.0);
    let free = system(free.spring("a", "b", 1.0).damper("a", "b", 1.0));
    let refused = RandomVibration::of(&free).force("a", 1.0).solve();
    let what = "the rigid motion of \"a\", \"b\"".to_owned();
    assert_eq!(refused, Err(StateSpaceError::NotStationary { what }));

    // A damper to the ground holds back what the base carries along.
    let held = System::builder().support("base").mass("m", 1.0);
    let held = system(held.spring("base", "m", 1.0).damper(GROUND, "m", 1.0));
    let motion = solved(RandomVibration::of(&held).motion("base", Velocity, 4.0));
    is_infinite(of(motion.displacement(), "m"), "base velocity");
    is(of(motion.velocity(), "m"), 1.0, 0.0);
    let shaken = RandomVibration::of(&held).motion("base", Displacement, 4.0);
    is(of(solved(shaken).displacement(), "m"), 1.0, 0.0);

    let refused = RandomVibration::of(&held).force("m", -1.0).solve();
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
    let motion = solved(RandomVibration::of(&two).force("a", 4.0));
    is(of(motion.displacement(), "a"), 1.0, 0.0);
    let Rms::Finite { value, bound } = of(motion.displacement(), "b") else {
        panic!("it rests")
    };
    assert!(*value == 0.0 && *bound < 1e-29, "{value} ± {bound}");
}

/// The truths of the tests below are integrals of S|H|² over the band with 40 digits (mpmath's quadrature, split at the poles).
#[test]
fn one_mass_in_a_band_agrees_with_quadrature() {
    // Light, critical and next to no damping; a band that ends near the resonance, and one that leaves it out.
    for (c, band, truths) in [
        (
            0.5,
            [0.25, 0.5],
            [
                0.402_967_390_697_311_6,
                0.816_819_045_686_063_4,
                1.698_594_641_204_992_5,
            ],
        ),
        (
            8.0,
            [0.25, 0.5],
            [
                0.047_730_371_085_323_94,
                0.105_198_692_256_148_2,
                0.250_029_734_227_123_77,
            ],
        ),
        (
            8.0,
            [0.0, 3.0],
            [
                0.108_226_098_241_142_67,
                0.201_468_303_385_431_65,
                1.318_285_996_436_259_6,
            ],
        ),
        (
            1e-9,
            [0.25, 0.5],
            [
                9_682.458_364_198_225,
                19_364.916_728_869_288,
                38_729.833_461_104_87,
            ],
        ),
        (
            1e-9,
            [0.35, 0.5],
            [
                0.159_686_113_996_049_6,
                0.384_796_396_021_680_74,
                0.942_895_355_317_674_5,
            ],
        ),
    ] {
        let one = one(2.0, c, 8.0);
        let motion = solved(RandomVibration::of(&one).force("m", Noise::within(3.0, band)));
        let all = [
            motion.displacement(),
            motion.velocity(),
            motion.acceleration(),
        ];
        for (all, truth) in all.into_iter().zip(truths) {
            is(of(all, "m"), truth, 2e-16);
        }
        // The rate of what is asked for is what is asked for of its rate.
        assert_eq!(motion.displacement()[0].rate, motion.velocity()[0].rms);
        assert_eq!(motion.velocity()[0].rate, motion.acceleration()[0].rms);
    }
}

/// Gyroscopic forces beside stiff dampers make resolvents a thousand times as large as their poles are near.
#[test]
fn a_band_below_stiff_gyroscopic_dampers_agrees_with_quadrature() {
    let damping = faer::mat![[100.0, -101.0], [-99.0, 100.0]];
    let system = system(
        System::builder()
            .mass("a", 1.0)
            .mass("b", 0.01)
            .spring(GROUND, "a", 40.0)
            .spring(GROUND, "b", 1.0)
            .matrix(MatrixKind::Damping, damping.as_ref()),
    );
    let noise = RandomVibration::of(&system).force("b", Noise::within(1.0, [0.0, 0.05]));
    let motion = solved(noise);
    for (name, truth) in [
        ("a", 0.005_379_642_423_294_909),
        ("b", 0.049_185_315_675_224_656),
    ] {
        is(of(motion.displacement(), name), truth, 2e-16);
    }
}

#[test]
fn a_car_on_roads_within_a_band_agrees_with_quadrature() {
    let car = car();
    // Travel, tyre, body and wheel accelerations; displacement and velocity of the body, which wander with the road where
    // the band begins at 0.
    for (quantity, low, truths) in [
        (
            Displacement,
            0.5,
            [
                0.177_114_728_179_325_4,
                25_196.410_102_266_557,
                42.584_233_363_555_96,
                763.375_099_098_481_8,
            ],
        ),
        (
            Velocity,
            0.5,
            [
                0.008_354_433_406_221_815,
                369.017_005_351_135_9,
                0.887_581_393_838_505_9,
                10.103_485_645_265_915,
            ],
        ),
        (
            Acceleration,
            0.5,
            [
                0.000_997_166_560_191_497_8,
                19.499_500_322_847_478,
                0.072_038_644_254_051_97,
                0.166_208_404_838_644_69,
            ],
        ),
        (
            Velocity,
            0.0,
            [
                0.008_383_744_918_265_8,
                369.243_415_724_754_47,
                0.888_739_869_837_770_8,
                10.103_569_457_624_604,
            ],
        ),
        (
            Acceleration,
            0.0,
            [
                0.001_063_511_426_594_492,
                20.658_011_741_739_607,
                0.075_877_549_439_163_4,
                0.167_729_799_361_055_73,
            ],
        ),
    ] {
        let noise =
            RandomVibration::of(&car).motion("road", quantity, Noise::within(1e-3, [low, 20.0]));
        let noise = noise.output(between("travel", Displacement, "wheel", "body"));
        let motion = solved(noise.output(pull("tyre")));
        let [travel, tyre, body, wheel] = truths;
        is(of(motion.outputs(), "travel"), travel, 2e-16);
        is(of(motion.outputs(), "tyre"), tyre, 2e-16);
        is(of(motion.acceleration(), "body"), body, 2e-16);
        is(of(motion.acceleration(), "wheel"), wheel, 2e-16);
        let (displacement, velocity) = match (quantity, low) {
            (Displacement, _) => (0.072_038_644_254_051_97, 0.887_581_393_838_505_9),
            (Velocity, 0.0) | (Acceleration, 0.0) => {
                let by = if quantity == Velocity {
                    "road velocity"
                } else {
                    "road acceleration"
                };
                is_infinite(of(motion.displacement(), "body"), by);
                continue;
            }
            (Velocity, _) => (0.010_735_843_247_873_786, 0.072_038_644_254_051_97),
            (Acceleration, _) => (0.002_007_237_940_990_186, 0.010_735_843_247_873_786),
        };
        is(of(motion.displacement(), "body"), displacement, 2e-16);
        is(of(motion.velocity(), "body"), velocity, 2e-16);
    }
}

/// Bands side by side add up to the band of both, and a wide one comes near to white noise.
#[test]
fn bands_add_up() {
    let car = car();
    let on = |noises: &[Noise]| {
        let start = RandomVibration::of(&car).output(pull("tyre"));
        let all = noises.iter();
        solved(all.fold(start, |all, noise| {
            all.force("body", *noise).force("wheel", *noise)
        }))
    };
    let parts = on(&[
        Noise::within(2.0, [0.0, 1.0]),
        Noise::within(2.0, [1.0, 11.5]),
        Noise::within(2.0, [11.5, 1e3]),
    ]);
    let whole = on(&[Noise::within(2.0, [0.0, 1e3])]);
    let white = on(&[Noise::white(2.0)]);
    let value =
        |motion: &StationaryMotion| of(motion.outputs(), "tyre").finite().expect("finite").0;
    assert!((value(&parts) - value(&whole)).abs() <= 2.3e-16 * value(&whole));
    assert!(value(&whole) < value(&white) && value(&whole) > value(&white) * (1.0 - 1e-4));
}

/// Of the formula of Davenport (1964) for 600 s of a mast at 1 Hz: 3.9 of σ.
#[test]
fn expected_peaks_follow_davenport() {
    let omega = std::f64::consts::TAU;
    let mast = one(1.0, 0.02 * omega, omega * omega);
    let motion = solved(RandomVibration::of(&mast).force("m", 4.0));
    let top = &motion.displacement()[0];
    let (sigma, _) = top.rms.finite().expect("it is held");
    let (peak, bound) = top.expected_peak(600.0).expect("many swings");
    let root = (2.0 * 1200f64.ln()).sqrt();
    let truth = sigma * (root + 0.577_215_664_901_532_9 / root);
    assert!(
        (peak - truth).abs() <= bound && bound < 1e-14 * peak,
        "{peak} {truth} {bound}"
    );
    assert!((peak / sigma - 3.919).abs() < 1e-3, "{}", peak / sigma);
    assert_eq!(top.expected_peak(2.0), None);
    assert_eq!(top.expected_peak(f64::INFINITY), None);
}

/// One decays by 1e26 powers of e while the other decays by one.
#[test]
fn damping_may_differ_by_many_powers_of_ten() {
    let two = System::builder().mass("a", 1.0).mass("b", 1.0);
    let two = two.spring(GROUND, "a", 1.0).damper(GROUND, "a", 1e-26);
    let two = system(two.spring(GROUND, "b", 1e4).damper(GROUND, "b", 200.0));
    let motion = solved(RandomVibration::of(&two).force("a", 4.0).force("b", 4.0));
    is(of(motion.displacement(), "a"), 1e13, 2e-16);
    is(of(motion.displacement(), "b"), (1.0f64 / 2e6).sqrt(), 2e-16);
}

/// Neither share of the support's motion, 3/7, is a double, and both are the same: the spring does not follow. Integrals of S|H|² with
/// 30 digits (mpmath).
#[test]
fn what_cancels_exactly_does_not_wander() {
    let pair = System::builder().support("s").mass("a", 1.0).mass("b", 1.0);
    let pair = pair.spring("s", "a", 3.0).spring(GROUND, "a", 4.0);
    let pair = pair.spring("a", "b", 2.0).named("k");
    let pair = pair.damper("s", "a", 0.1).damper("a", "b", 0.1).named("c");
    let pair = system(pair);
    let noise = |quantity| {
        let noise = RandomVibration::of(&pair).motion("s", quantity, 1e-3);
        noise.output(pull("k")).output(pull("c"))
    };
    let on_road = solved(noise(Velocity));
    is(of(on_road.outputs(), "k"), 0.054_781_356_399_536_88, 1e-15);
    is_infinite(of(on_road.displacement(), "b"), "s velocity");
    let square = noise(Velocity).mean_square("k", None);
    let square = square.unwrap().expect("it is finite");
    assert!((square.value().sqrt() / 0.054_781_356_399_536_88 - 1.0).abs() < 1e-13);

    let shaken = solved(noise(Acceleration));
    is(of(shaken.outputs(), "c"), 0.002_739_067_819_976_844, 1e-15);
    is(of(shaken.outputs(), "k"), 0.041_407_946_708_452_89, 1e-15);
    is_infinite(of(shaken.displacement(), "a"), "s acceleration");
    is_infinite(of(shaken.velocity(), "b"), "s acceleration");
}

/// Integrals of S|WH|² with 30 digits (mpmath's quadrature), W with the frequencies and quality factors of the standard.
#[test]
fn weighted_motions_agree_with_quadrature() {
    let car = System::builder()
        .support("road")
        .mass("body", 290.0)
        .mass("wheel", 59.0);
    let car = car
        .spring("wheel", "body", 16812.0)
        .damper("wheel", "body", 1000.0);
    let car = system(
        car.spring("road", "wheel", 190_000.0)
            .damper("road", "wheel", 20.0),
    );
    let road = |quantity, band| {
        let noise = RandomVibration::of(&car).motion("road", quantity, Noise::within(1e-4, band));
        noise.output(between("relative", Acceleration, "road", "wheel"))
    };
    let force = Noise::within(3.0, [0.1, 200.0]);
    let both = road(Velocity, [0.5, 20.0]).force("body", force);
    let alone = RandomVibration::of(&car).force("body", force);
    let cases = [
        (
            road(Velocity, [0.5, 20.0]),
            "body",
            [0.248_943_786_544_320_9, 0.178_484_467_561_684_9],
        ),
        (
            road(Velocity, [0.0, 20.0]),
            "body",
            [0.248_991_856_979_495_94, 0.178_760_374_132_645_88],
        ),
        (
            road(Velocity, [9.5, 10.0]),
            "wheel",
            [1.225_423_930_902_393, 0.254_947_603_285_759_06],
        ),
        (
            road(Displacement, [1.0, 30.0]),
            "relative",
            [606.611_709_586_616, 100.645_033_872_401_53],
        ),
        (
            road(Acceleration, [0.0, 5.0]),
            "body",
            [0.011_348_108_731_397_3, 0.022_342_494_835_230_096],
        ),
        (
            alone,
            "body",
            [0.028_308_726_640_464_855, 0.015_651_864_564_427_128],
        ),
        (both, "body", [0.250_548_184_713_098_6, f64::NAN]),
    ];
    for (noise, name, truths) in cases {
        let weightings = [Weighting::Vertical, Weighting::Horizontal].into_iter();
        for (weighting, truth) in weightings.zip(truths).filter(|(_, truth)| !truth.is_nan()) {
            let motion = noise.weighted(weighting).expect("a stationary motion");
            let all = motion.outputs().iter().chain(motion.acceleration());
            let all: Vec<Statistics> = all.cloned().collect();
            is(of(&all, name), truth, 1e-15);
        }
    }

    // White noise, of one mass: what doubles have is the proven value, and what wanders is held back.
    let one = one(1.0, 1.0, 400.0);
    let noise = RandomVibration::of(&one).motion("base", Acceleration, 2.0);
    let noise = noise.output(between("ride", Acceleration, "base", "m"));
    let white = RandomVibration::of(&one).motion("base", Velocity, 2.0);
    let white = white.output(sum("ride", &[(Acceleration, "m", 1.0)]));
    for weighting in [Weighting::Vertical, Weighting::Horizontal] {
        assert!(
            noise.weighted(weighting).unwrap().displacement()[0]
                .rms
                .finite()
                .is_some()
        );
        let square = white.mean_square("ride", Some(weighting));
        let square = square.unwrap().expect("doubles determine it");
        let motion = white.weighted(weighting).expect("a stationary motion");
        is(of(motion.outputs(), "ride"), square.value().sqrt(), 1e-12);
    }
}
