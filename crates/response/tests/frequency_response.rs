//! Frequency response functions against closed forms, and their peaks and half-power bands.

use eigentone_modes::{BeamEnd, Bounds, ElementKind, GROUND, Precision, System, SystemBuilder};
use eigentone_response::{
    Features, FrequencyResponse, FrequencyValue, LargestGain, Quantity, peak_grid,
};
use faer::Mat;
use num_complex::Complex;

use crate::random::Random;
use crate::systems::{CANTILEVER, beam, between, car, chain, chain_of, in_a_row, pull, sum};

fn features(system: &System, from: &str, to: &str) -> Features {
    let modes = system.modes().expect("modes");
    let grid = peak_grid(system, &modes, &[]);
    let asked = FrequencyResponse::of(system).from(from).to(to);
    let mut features = asked.features(&grid).expect("features");
    assert_eq!(features.len(), 1);
    assert!(features[0].is_complete(), "{features:?}");
    features.remove(0)
}

fn assert_near(value: f64, truth: f64, relative: f64) {
    let off = (value - truth).abs();
    assert!(
        off <= relative * truth.abs(),
        "{value:e} is not {truth:e}: {off:e}"
    );
}

/// Two masses that a strong damper joins: with s = Ω², |H|² = (1 + c²s)/((1 − 3s + s²)² + c²s(1 − 2s)²), which peaks at
/// s = ½ but for 1/c². So narrow a peak keeps its digits, or nine of them.
#[test]
fn the_narrowest_peaks_keep_their_digits() {
    for (c, most) in [(1e7, 1e-14), (1e8, 1e-14), (1e10, 1e-8)] {
        let system = in_a_row(&[("a", 1.0), ("b", 1.0)], &[1.0, 1.0], &[0.0, c]);
        let features = features(&system, "a", "b");
        assert!(features.is_complete());
        let [peak] = features.peaks() else {
            panic!("{:?}", features.peaks())
        };
        let (gain, bound) = peak.gain().expect("damped");
        assert_near(gain, 4.0 * f64::sqrt(1.0 + 0.5 * c * c), 1e-13);
        assert!(bound <= most * gain, "{c}: {gain} {bound}");
    }
}

#[test]
fn one_mass_peaks_as_its_closed_form() {
    for (stiffness, zeta) in [(4.0, 0.5), (9e4, 0.01), (1.0, 1e-7), (2.0, 0.3)] {
        let omega = f64::sqrt(stiffness);
        let damping = 2.0 * zeta * omega;
        let system = in_a_row(&[("m", 1.0)], &[stiffness], &[damping]);
        let features = features(&system, "m", "m");
        let [peak] = features.peaks() else {
            panic!("{:?}", features.peaks())
        };
        let (frequency, bound) = peak.frequency();
        assert_near(frequency, omega * f64::sqrt(1.0 - 2.0 * zeta * zeta), 1e-15);
        assert!(bound <= f64::EPSILON * frequency);
        let (gain, bound) = peak.gain().expect("damped");
        let truth = 1.0 / (damping * omega * f64::sqrt(1.0 - zeta * zeta));
        assert_near(gain, truth, 1e-15);
        assert!(bound <= 3.0 * f64::EPSILON * gain);
        // (1 − r²)² + (2ζr)² = 2·4ζ²(1 − ζ²).
        let root = 2.0 * zeta * f64::sqrt(1.0 - zeta * zeta);
        let at = |side: f64| omega * f64::sqrt(1.0 - 2.0 * zeta * zeta + side * root);
        if zeta < 0.38 {
            let [low, high] = peak.half_power().expect("it falls so far on both sides");
            // The width of a narrow peak has the digits that are left of its frequencies.
            assert_near(low, at(-1.0), 1e-15);
            assert_near(high, at(1.0), 1e-15);
        } else {
            assert_eq!(peak.half_power(), None);
        }
        let low = features.low().expect("held");
        assert_eq!(low.power, 0);
        assert_near(low.coefficient, 1.0 / stiffness, 1e-15);
        let high = features.high().expect("it has a mass");
        assert_eq!(high.power, -2);
        assert_near(high.coefficient, 1.0, 1e-15);
    }
}

/// A machine of 1 kg and 1 N/m with an absorber of mass ratio μ at Den Hartog's tuning and c = 2ζ m ω.
fn absorber(mu: f64, zeta_squared: f64) -> System {
    tuned(mu, 1.0 / (1.0 + mu), 2.0 * mu * f64::sqrt(zeta_squared))
}

/// The same at any tuning, with a damper in N·s/m.
fn tuned(mu: f64, tuning: f64, damping: f64) -> System {
    System::builder()
        .mass("machine", 1.0)
        .mass("absorber", mu)
        .spring(GROUND, "machine", 1.0)
        .spring("machine", "absorber", mu * tuning * tuning)
        .damper("machine", "absorber", damping)
        .build()
        .expect("a system")
}

/// Where the higher peak is as low as it can be both are equal, and known in closed form (Nishihara & Asami 2002, *Journal of
/// Vibration and Acoustics* 124).
#[test]
fn both_peaks_are_equal_at_the_exact_optimum() {
    for mu in [0.01f64, 0.05, 0.2, 1.0] {
        let root = f64::sqrt(4.0 + 3.0 * mu);
        let many = 16.0 + 23.0 * mu + 9.0 * mu * mu + 2.0 * (2.0 + mu) * root;
        let few = 3.0 * (64.0 + 80.0 * mu + 27.0 * mu * mu);
        let tuning = 2.0 / (1.0 + mu) * f64::sqrt(2.0 * many / few);
        let zeta = f64::sqrt((8.0 + 9.0 * mu - 4.0 * root) / (1.0 + mu)) / 4.0;
        let square = (8.0 + 9.0 * mu).powi(2) * (16.0 + 9.0 * mu) - 128.0 * root.powi(3);
        let gain = f64::sqrt(square / (3.0 * (32.0 + 27.0 * mu))) / (3.0 * mu);
        let system = tuned(mu, tuning, 2.0 * mu * zeta * tuning);
        let found = features(&system, "machine", "machine");
        let gains = found
            .peaks()
            .iter()
            .map(|peak| peak.gain().expect("damped"));
        let [(low, low_off), (high, high_off)] = gains.collect::<Vec<_>>()[..] else {
            panic!("two peaks: {found:?}")
        };
        assert!(low_off.max(high_off) <= 4.0 * f64::EPSILON * gain);
        assert_near(low, high, 1e-12);
        // What is subtracted cancels for light absorbers.
        assert_near(low, gain, 1e-12);
        assert_near(high, gain, 1e-12);
    }
}

/// Den Hartog (1956), *Mechanical Vibrations*, section 3.3: at the tuning 1/(1 + μ) all curves pass through two points of
/// height √(1 + 2/μ), and a damping for each of the two makes it a peak.
#[test]
fn an_absorber_peaks_at_its_fixed_points() {
    for mu in [0.05, 0.2, 1.0] {
        let height = f64::sqrt(1.0 + 2.0 / mu);
        for side in [-1.0, 1.0] {
            let cube = (1.0 + mu) * (1.0 + mu) * (1.0 + mu);
            let zeta_squared = mu * (3.0 + side * f64::sqrt(mu / (mu + 2.0))) / (8.0 * cube);
            let features = features(&absorber(mu, zeta_squared), "machine", "machine");
            let gains: Vec<f64> = features
                .peaks()
                .iter()
                .filter_map(|peak| Some(peak.gain()?.0))
                .collect();
            assert_eq!(gains.len(), 2);
            let nearest = gains.iter().map(|gain| (gain / height - 1.0).abs());
            let nearest = nearest.fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-14, "{mu} {side}: {gains:?} {height}");
            // The other peak stands beside its fixed point, and is higher.
            assert!(features.largest().expect("damped").gain().expect("known").0 >= height);
        }
        // The mean of the two leaves both peaks a little above the fixed points.
        let cube = (1.0 + mu) * (1.0 + mu) * (1.0 + mu);
        let features = features(&absorber(mu, 3.0 * mu / (8.0 * cube)), "machine", "machine");
        let gains = features
            .peaks()
            .iter()
            .map(|peak| peak.gain().expect("damped").0);
        for gain in gains {
            assert!(gain > height && gain < 1.06 * height, "{gain} {height}");
        }
    }
}

#[test]
fn undamped_peaks_are_poles_and_dips_are_zeros() {
    let system = in_a_row(&[("a", 1.0), ("b", 1.0)], &[4.0, 3.0, 4.0], &[]);
    let found = features(&system, "a", "a");
    let peaks: Vec<_> = found
        .peaks()
        .iter()
        .map(|peak| (peak.frequency().0, peak.gain()))
        .collect();
    assert_eq!(peaks.len(), 2);
    assert_near(peaks[0].0, 2.0, 1e-15);
    assert_near(peaks[1].0, f64::sqrt(10.0), 1e-15);
    assert!(peaks.iter().all(|(_, gain)| gain.is_none()) && found.largest().is_none());
    let [dip] = found.dips() else {
        panic!("{:?}", found.dips())
    };
    assert_near(dip.frequency().0, f64::sqrt(7.0), 1e-15);
    let (gain, bound) = dip.gain().expect("a zero");
    assert!(gain <= bound && bound < 1e-20);
    let answer = FrequencyResponse::of(&system)
        .from("a")
        .to("b")
        .at(&[0.0, 2.0, 3.0]);
    let answer = answer.expect("a response");
    let values = answer.functions()[0].values();
    assert_eq!(values[1], FrequencyValue::Pole);
    // 3/((7 − 9)² − 9).
    assert_eq!(
        values[2].known().expect("regular").0,
        Complex::new(-0.6, 0.0)
    );
}

/// Where no spring reaches the ground, the equations are singular at 0, and yet what does not run away has a value there.
#[test]
fn functions_that_are_finite_at_0_have_values_there() {
    let at_0 = |asked: FrequencyResponse<'_>| -> Vec<FrequencyValue> {
        let found = asked.at(&[0.0]).expect("in range");
        assert_eq!(found.bounds(), Bounds::Proven);
        let values = found.functions().iter();
        values.map(|function| function.values()[0]).collect()
    };
    let is = |value: FrequencyValue, truth: Complex<f64>| {
        let (value, bound) = value.known().expect("it is finite");
        let bound = bound.expect("it is proven");
        let off = (value - truth).norm();
        assert!(
            off <= 2.0 * f64::EPSILON * truth.norm() && bound <= f64::EPSILON * truth.norm(),
            "{value} ± {bound:e} is not {truth}"
        );
    };
    let real = |re: f64| Complex::new(re, 0.0);
    let joined = |builder: SystemBuilder| {
        let builder = builder.mass("a", 0.3).mass("b", 0.7);
        builder.spring("a", "b", 2.1).damper("a", "b", 0.9)
    };
    // A steady force drags both at F/c, without a force between them.
    let dragged = joined(System::builder())
        .damper(GROUND, "a", 1.7)
        .named("drag");
    let dragged = dragged.build().expect("a system");
    let asked = |quantity: Quantity| {
        let asked = FrequencyResponse::of(&dragged).from("a").quantity(quantity);
        asked
            .to("a")
            .to("b")
            .output(between("relative", Quantity::Displacement, "b", "a"))
            .output(pull("drag"))
    };
    let velocities = at_0(asked(Quantity::Velocity));
    is(velocities[0], real(1.0 / 1.7));
    is(velocities[1], real(1.0 / 1.7));
    is(velocities[2], real(0.0));
    is(velocities[3], real(1.0));
    let displacements = at_0(asked(Quantity::Displacement));
    assert_eq!(displacements[..2], [FrequencyValue::Pole; 2]);
    at_0(asked(Quantity::Acceleration))[..2]
        .iter()
        .for_each(|value| is(*value, real(0.0)));
    // In free flight both accelerate by F/(m_a + m_b), and b takes its share of the force through the spring.
    let free = joined(System::builder()).build().expect("a system");
    for loss in [0.0, 0.25] {
        let asked = |quantity: Quantity| {
            let asked = FrequencyResponse::of(&free).from("a").quantity(quantity);
            asked
                .to("a")
                .to("b")
                .output(between("relative", Quantity::Displacement, "b", "a"))
                .loss_factors([loss])
        };
        let accelerations = at_0(asked(Quantity::Acceleration));
        is(accelerations[0], real(1.0));
        is(accelerations[1], real(1.0));
        is(
            accelerations[2],
            real(0.7) / (Complex::new(1.0, loss) * 2.1),
        );
        let velocities = at_0(asked(Quantity::Velocity));
        assert_eq!(velocities[..2], [FrequencyValue::Pole; 2]);
    }
    // What a damper alone joins to a support goes with it.
    let carried = joined(System::builder().support("road")).damper("road", "b", 0.1);
    let carried = carried.build().expect("a system");
    let followed = at_0(FrequencyResponse::of(&carried).from("road"));
    followed.iter().for_each(|value| is(*value, real(1.0)));
}

/// A full system: every coordinate is joined to every other.
fn full(n: usize, damped: bool) -> System {
    let mut builder = System::builder();
    let mut numbers = Random(1);
    let mut random = || 0.5 * (numbers.signed() + 1.0);
    for i in 0..n {
        builder = builder.mass(format!("m{i}"), 0.5 + random());
    }
    for i in 0..n {
        builder = builder.spring(GROUND, format!("m{i}"), 10.0 + random());
        for j in 0..i {
            let (a, b) = (format!("m{i}"), format!("m{j}"));
            builder = builder.spring(&a, &b, random());
            if damped && (i + j) % 5 == 0 {
                builder = builder.damper(&a, &b, 0.05 * random());
            }
        }
    }
    builder.build().expect("a system")
}

#[test]
fn doubles_lie_within_their_bounds_of_the_certified() {
    for (n, damped) in [(12, true), (60, true), (60, false)] {
        let system = full(n, damped);
        let frequencies: Vec<f64> = (0..40).map(|k| 0.37 * f64::from(k)).collect();
        let of_velocity = (Quantity::Velocity, "m1", 1.0);
        let difference = [of_velocity, (Quantity::Displacement, "m2", -0.5)];
        let asked = FrequencyResponse::of(&system)
            .from("m0")
            .from("m3")
            .to("m0")
            .to("m5")
            .output(sum("difference", &difference))
            .quantity(Quantity::Acceleration);
        let certified = asked.at(&frequencies).expect("a response");
        let doubles = asked
            .precision(Precision::Double)
            .at(&frequencies)
            .expect("a response");
        let pairs = certified.functions().iter().zip(doubles.functions());
        for (certified, doubles) in pairs {
            for (k, (a, b)) in certified.values().iter().zip(doubles.values()).enumerate() {
                let (a, a_off) = a.known().expect("no pole");
                let (b, b_off) = b.known().expect("no pole");
                let (a_off, b_off) = (a_off.expect("proven"), b_off.expect("proven"));
                assert!(
                    (a - b).norm() <= a_off + b_off,
                    "{k}: {a} ± {a_off:e}, {b} ± {b_off:e}"
                );
                assert!(a_off <= 4.5e-16 * a.norm(), "{k}: {a} ± {a_off:e}");
                let size = b.norm().max(frequencies[k] * frequencies[k] * 1e-4);
                assert!(b_off <= 1e-7 * size, "{k}: {b} ± {b_off:e}");
            }
        }
    }
}

/// Two chains from the ground to a common tip, beside which all modes in which they move against each other keep it at rest.
fn twins() -> SystemBuilder {
    (0..40).fold(System::builder(), |builder, i| {
        let (branch, k) = (i / 20, i % 20);
        let name = |k: i32| match k {
            20 => "tip".to_owned(),
            k => format!("b{branch}.{k}"),
        };
        let builder = match i {
            0 => builder.mass("tip", 1.0),
            _ => builder,
        };
        let builder = builder.mass(name(k), 1.0);
        let (first, second) = match k {
            0 => (GROUND.to_owned(), name(0)),
            k => (name(k - 1), name(k)),
        };
        let builder = builder
            .spring(&first, &second, 100.0)
            .damper(&first, &second, 1e-6);
        match k {
            19 => builder.spring(name(19), "tip", 50.0),
            _ => builder,
        }
    })
}

/// A tower on a soil that moves, with a floor without mass.
fn tower() -> SystemBuilder {
    (0..35).fold(System::builder().support("soil"), |builder, i| {
        let below = match i {
            0 => "soil".to_owned(),
            i => format!("f{}", i - 1),
        };
        let (floor, k) = (format!("f{i}"), 1e6 * f64::from(1 + i % 3));
        let mass = if i == 17 { 0.0 } else { 1e3 };
        builder
            .mass(&floor, mass)
            .spring(&below, &floor, k)
            .named(format!("k{i}"))
            .damper(&below, &floor, 1e-3 * k)
    })
}

#[test]
fn estimates_of_a_hessenberg_form_hold() {
    let mast = beam("mast", 20, [2.0, 1500.0, 3.1], CANTILEVER);
    let mast = System::builder()
        .beam(mast)
        .damper(GROUND, "mast.20.w", 0.3);
    let cases = [
        (twins(), "tip", "b0.7", 0.0),
        (mast, "mast.20.w", "mast.11.r", 0.0),
        (tower(), "soil", "f30", 0.0),
        (tower(), "soil", "f30", 0.02),
        (tower(), "f8", "f30", 0.3),
        (twins(), "tip", "b0.7", 1e-6),
    ];
    for (builder, from, to, loss) in cases {
        let system = builder.build().expect("a system");
        let modes = system.modes().expect("modes");
        let natural = modes.iter().map(|mode| mode.eigenvalue().value.norm());
        let natural: Vec<f64> = natural.filter(|size| *size > 0.0).collect();
        let mut frequencies = vec![0.0, 1e-3, 3.3, 1e5];
        for size in natural.iter().take(45) {
            frequencies.extend([*size, size * (1.0 + 1e-4), size * 1.01]);
        }
        let springs = system.elements(ElementKind::Spring).len();
        let losses = match loss > 0.0 {
            true => (0..springs).map(|k| loss * (1 + k % 2) as f64).collect(),
            false => Vec::new(),
        };
        let asked = FrequencyResponse::of(&system).from(from).to(from).to(to);
        let mut asked = asked.quantity(Quantity::Velocity).loss_factors(losses);
        for name in ["k0", "k20"] {
            if system.element_of(name).is_some() {
                asked = asked.output(pull(name));
            }
        }
        let certified = asked.at(&frequencies).expect("a response");
        let doubles = asked
            .precision(Precision::Double)
            .at(&frequencies)
            .expect("a response");
        assert_eq!(doubles.bounds(), Bounds::Estimated);
        let mut estimates = 0;
        let pairs = certified.functions().iter().zip(doubles.functions());
        for (certified, doubles) in pairs {
            let values = certified.values().iter().zip(doubles.values());
            for ((a, b), frequency) in values.zip(&frequencies) {
                let (Some((a, a_off)), Some((b, b_off))) = (a.known(), b.known()) else {
                    assert_eq!(a, b);
                    continue;
                };
                let (a_off, b_off) = (a_off.expect("proven"), b_off.expect("estimated"));
                assert!(
                    (a - b).norm() <= a_off + b_off,
                    "{from}, {frequency}: {a} ± {a_off:e}, {b} ± {b_off:e}"
                );
                estimates += usize::from(b_off > 3.0 * a_off && b_off <= 1e-7 * b.norm());
            }
        }
        assert!(estimates > frequencies.len() / 2, "{from}: {estimates}");
    }
}

/// Of a chain from the ground, each mass joined to the one before.
fn damped_chain(n: usize) -> System {
    chain_of(n, |i| {
        let before = (i - 1) as f64;
        [1.0 + 0.1 * before, 10.0 + before, 0.1 + 0.01 * before]
    })
}

/// How often a function turns from rising to falling, and the other way, between frequencies close to each other.
fn turns_on_a_grid(low: f64, high: f64, count: usize, size: impl Fn(f64) -> f64) -> [usize; 2] {
    let ratio = (high / low).powf(1.0 / count as f64);
    let sizes: Vec<f64> = (0..=count)
        .map(|k| size(low * ratio.powi(k as i32)))
        .collect();
    let turns =
        |is_turn: fn(&[f64]) -> bool| sizes.windows(3).filter(|three| is_turn(three)).count();
    [
        turns(|three| three[0] < three[1] && three[1] >= three[2]),
        turns(|three| three[0] > three[1] && three[1] <= three[2]),
    ]
}

/// What a force on one end of a chain does to the other falls with twice as high a power of the frequency as there are masses, far below
/// all that modes in doubles can tell from 0: it is the product of what joins them over the determinant, a recursion of three terms.
#[test]
fn peaks_are_complete_where_functions_fall_steeply() {
    let system = damped_chain(8);
    let asked = FrequencyResponse::of(&system).from("m1");
    let all = asked.features(&[1e-3, 1e3]).expect("features");
    for (i, found) in all.iter().enumerate() {
        assert!(found.is_complete(), "{i}");
        assert!(found.peaks().len() > found.dips().len(), "{i}: {found:?}");
    }
    let n = 40;
    let system = damped_chain(n);
    let link = |i: usize, s: Complex<f64>| 10.0 + i as f64 + s * (0.1 + 0.01 * i as f64);
    let size = |frequency: f64| {
        let s = Complex::new(0.0, frequency);
        let (mut before, mut own, mut sum) = (Complex::ZERO, Complex::ONE, 0.0);
        for i in 0..n {
            let above = if i + 1 < n {
                link(i + 1, s)
            } else {
                Complex::ZERO
            };
            let diagonal = (1.0 + 0.1 * i as f64) * s * s + link(i, s) + above;
            let joined = if i > 0 { link(i, s) } else { Complex::ONE };
            let next = diagonal * own - joined * joined * before;
            let length = next.norm();
            (before, own) = (own / length, next / length);
            sum += joined.norm().ln() - length.ln();
        }
        sum
    };
    let asked = FrequencyResponse::of(&system).from("m1").to("m40");
    let found = &asked.features(&[1e-3, 1e3]).expect("features")[0];
    assert!(found.is_complete());
    let counted = [found.peaks().len(), found.dips().len()];
    assert_eq!(turns_on_a_grid(1e-3, 1e3, 100_000, size), counted);
    for peak in found.peaks() {
        let (gain, bound) = peak.gain().expect("damped");
        assert_near(size(peak.frequency().0).exp(), gain, 1e-9);
        assert!(bound <= 1e-15 * gain, "{peak:?}");
    }
}

/// Where doubles do not tell on which side of a turn a function rises, digits that do place it.
#[test]
fn turns_that_doubles_cannot_place_are_listed() {
    let n = 16;
    for seed in 1..=12 {
        let mut numbers = Random(seed);
        let mut decades = || 10f64.powf(2.0 * numbers.signed());
        let both: Vec<[f64; 2]> = (0..n).map(|_| [100.0 * decades(), decades()]).collect();
        let system = chain_of(n, |i| {
            let [stiffness, mass] = both[i - 1];
            [mass, stiffness, 1e-3 * stiffness]
        });
        let asked = FrequencyResponse::of(&system).from("m1").to("m16");
        let found = &asked.features(&[]).expect("features")[0];
        assert!(found.is_complete(), "{seed}");
        assert_eq!(found.peaks().len(), found.dips().len() + 1, "{seed}");
    }
}

/// Rayleigh damping of finite elements makes modes from lightly to overdamped ones, the fastest many times as fast as without damping;
/// and the errors of the recursion about 0 and ∞ grow by ten orders from one coefficient to the next.
/// Of matrices of a free beam, with the two rigid motions that rounding of the stiffness moves.
#[test]
fn elastic_modes_of_a_free_beam_are_its_peaks() {
    let free = System::builder().beam(beam("rod", 16, [2.0, 100.0, 1.2], [BeamEnd::Free; 2]));
    let free = free.build().expect("a system");
    let none = Mat::<f64>::zeros(free.len(), free.len());
    let [mass, stiffness] = [free.mass_matrix(), free.stiffness_matrix()];
    let system = System::from_matrices(mass.as_ref(), none.as_ref(), stiffness.as_ref());
    let system = system.expect("a system");
    let modes = system.modes().expect("modes");
    let grid = peak_grid(&system, &modes, &[]);
    let names = system.names();
    let asked = FrequencyResponse::of(&system)
        .from(&names[0])
        .to(&names[system.len() - 2]);
    let found = &asked.features(&grid).expect("features")[0];
    let elastic = modes
        .eigenvalues()
        .iter()
        .filter(|root| root.value.im > 1.0);
    let mut count = 0;
    for root in elastic {
        let (place, bound) = (root.value.im, root.bound.expect("proven"));
        let near = |peak: &&eigentone_response::Peak| {
            let (at, off) = peak.frequency();
            (at - place).abs() <= off + bound
        };
        let own: Vec<_> = found.peaks().iter().filter(near).collect();
        assert_eq!(own.len(), 1, "{place}");
        let (at, off) = own[0].frequency();
        assert!(off <= f64::EPSILON * at, "{at} {off}");
        assert_eq!(own[0].gain(), None, "{place}");
        count += 1;
    }
    assert_eq!(count, 32);
}

#[test]
fn peaks_of_finite_elements_are_complete() {
    for elements in [10, 20, 40] {
        let system = System::builder()
            .beam(beam("mast", elements, [2.0, 100.0, 1.2], CANTILEVER))
            .rayleigh(0.1, 1e-4, None)
            .build()
            .expect("a system");
        let tip = format!("mast.{elements}.w");
        let asked = FrequencyResponse::of(&system).from(&tip).to(&tip);
        let found = &asked.features(&[1.0, 1e4]).expect("features")[0];
        assert!(found.is_complete(), "{elements}");
        // By factors of the dynamic stiffness in doubles.
        let [mass, damping, stiffness] = [
            system.mass_matrix(),
            system.damping_matrix(),
            system.stiffness_matrix(),
        ];
        let n = system.len();
        let size = |frequency: f64| {
            let mut rows = Mat::from_fn(n, n, |i, j| {
                let real = stiffness[(i, j)] - frequency * frequency * mass[(i, j)];
                Complex::new(real, frequency * damping[(i, j)])
            });
            // From the clamped end, without exchanges of rows: three others are joined to each.
            for k in 0..n - 2 {
                for i in k + 1..n.min(k + 4) {
                    let factor = rows[(i, k)] / rows[(k, k)];
                    for j in k..n.min(k + 4) {
                        let change = factor * rows[(k, j)];
                        rows[(i, j)] -= change;
                    }
                }
            }
            // Deflection and rotation of the tip are left.
            let at = |i: usize, j: usize| rows[(n - 2 + i, n - 2 + j)];
            (at(1, 1) / (at(0, 0) * at(1, 1) - at(0, 1) * at(1, 0))).norm()
        };
        let counted = [found.peaks().len(), found.dips().len()];
        assert_eq!(turns_on_a_grid(1.0, 1e5, 4000, size), counted, "{elements}");
    }
}

/// What moves apart in a free chain, from one end to the stretch of a spring, is complete: peaks and the dip by mpmath with 40 digits,
/// and m_b + m_c over all masses and k at rest.
#[test]
fn relative_motions_of_free_bodies_are_complete() {
    const PEAKS: [[f64; 2]; 2] = [
        [8.893436050372758, 0.06469006466870983],
        [14.903127161713508, 0.014136461268557902],
    ];
    let chain = System::builder()
        .mass("a", 2.0)
        .mass("b", 1.0)
        .mass("c", 0.5);
    let chain = chain.spring("a", "b", 100.0).spring("b", "c", 50.0);
    let chain = chain.damper("a", "b", 0.5).damper("b", "c", 0.3);
    let chain = chain.build().expect("a system");
    let asked = FrequencyResponse::of(&chain).from("a");
    let asked = asked.output(between("relative", Quantity::Displacement, "b", "a"));
    let found = asked.features(&[1.0, 100.0]).expect("features");
    let found = &found[0];
    assert!(found.is_complete());
    assert_eq!((found.peaks().len(), found.dips().len()), (2, 1));
    for (peak, [at, gain]) in found.peaks().iter().zip(PEAKS) {
        assert!((peak.frequency().0 - at).abs() < 4e-15 * at);
        let (value, bound) = peak.gain().expect("known");
        assert!((value - gain).abs() <= bound + 2e-16 * gain && bound < 1e-15 * gain);
    }
    let Some(LargestGain::Finite { gain, .. }) = found.largest_gain() else {
        panic!("{found:?}");
    };
    assert!((gain - PEAKS[0][1]).abs() < 1e-16);
    // Of many masses, where the magnitude falls from its limit at rest, m_0 over all masses and k, which is not decided by digits there.
    let long = (0..9).fold(System::builder(), |builder, i| {
        builder.mass(format!("m{i}"), 1.1 + 0.1 * f64::from(i))
    });
    let long = (1..9).fold(long, |builder, i| {
        let [a, b] = [i - 1, i].map(|i| format!("m{i}"));
        builder.spring(&a, &b, 33.2).damper(&a, &b, 0.7)
    });
    let long = long.build().expect("a system");
    let asked = FrequencyResponse::of(&long).from("m1").output(between(
        "relative",
        Quantity::Displacement,
        "m1",
        "m0",
    ));
    let found = &asked.features(&[1.0, 100.0]).expect("features")[0];
    assert!(
        found.is_complete() && found.largest_gain().is_some(),
        "{found:?}"
    );
    // A lever that rides on two masses bends nothing at rest either, and what is dragged has one power of Ω in common, not two.
    let ridden = System::builder()
        .mass("a", 2.0)
        .mass("b", 1.0)
        .mass("c", 0.5);
    let ridden = ridden.point("p", [("a", 0.75), ("b", 0.25)], 0.25);
    let ridden = ridden
        .spring("p", "c", 8.0)
        .damper("p", "c", 4.0)
        .spring("a", "b", 64.0);
    for drag in [0.0, 0.5] {
        let ridden = ridden
            .clone()
            .damper("a", "b", 1.0)
            .damper(GROUND, "b", drag);
        let ridden = ridden.build().expect("a system");
        let asked = FrequencyResponse::of(&ridden).from("a");
        let found = asked
            .output(between("relative", Quantity::Displacement, "c", "p"))
            .features(&[1.0, 100.0]);
        let found = &found.expect("features")[0];
        assert!(found.is_complete(), "{drag}");
        assert!(matches!(
            found.largest_gain(),
            Some(LargestGain::Finite { .. })
        ));
    }
}

/// Of two equal bodies on a third neither moves before the other: a function that is 0 as its parts cancel, beside nodes without
/// mass too.
#[test]
fn what_cancels_everywhere_is_0() {
    let pair = System::builder()
        .mass("a", 0.1)
        .mass("b", 0.1)
        .mass("c", 2.0)
        .mass("n", 0.0);
    let pair = pair
        .spring("c", "a", 50.0)
        .spring("c", "b", 50.0)
        .spring("c", "n", 50.0);
    let pair = pair.damper("c", "a", 0.2).damper("c", "b", 0.2);
    let pair = pair
        .spring(GROUND, "n", 50.0)
        .spring(GROUND, "c", 100.0)
        .build();
    let pair = pair.expect("a system");
    let nearly = [("c", 1.0), ("n", -1.0)];
    let half = nearly.map(|(name, factor)| (Quantity::Velocity, name, factor));
    let asked = FrequencyResponse::of(&pair).from("c");
    let asked = asked
        .output(between("relative", Quantity::Displacement, "b", "a"))
        .output(sum("half", &half));
    let found = asked.features(&[1.0, 100.0]).expect("features");
    let is_nothing = |found: &Features| {
        let gain = found.largest_gain();
        matches!(
            gain,
            Some(LargestGain::Finite {
                gain: 0.0,
                bound: 0.0,
                ..
            })
        )
    };
    assert_eq!([0, 1].map(|at| is_nothing(&found[at])), [true, false]);
    assert!(found[0].is_complete() && found[0].peaks().is_empty());
}

/// At low frequencies a mass hangs on another without any force: |H| falls as Ω³, by terms that cancel exactly, also where parallel
/// springs have a sum that is no double. Peaks by mpmath with 40 digits, zeros of d|H|/dΩ of the exact doubles.
#[test]
fn relative_motions_are_complete_whatever_springs_add_up_to() {
    let system = System::builder()
        .mass("a", 8.0)
        .mass("b", 4.0)
        .spring(GROUND, "a", 8.0)
        .spring("a", "b", 0.1)
        .spring("a", "b", 0.2)
        .damper("a", "b", 0.05)
        .build()
        .expect("a system");
    let apart = between("apart", Quantity::Velocity, "b", "a");
    let asked = FrequencyResponse::of(&system).from("a").output(apart);
    let found = &asked.features(&[0.1, 3.0]).expect("features")[0];
    assert!(found.is_complete(), "{found:?}");
    let truth = [
        (0.268_767_284_500_098_1, 0.809_201_091_881_559_3),
        (1.019_960_709_042_062_4, 18.559_751_499_347_474),
    ];
    assert_eq!(found.peaks().len(), truth.len());
    for (peak, (frequency, gain)) in found.peaks().iter().zip(truth) {
        assert_near(peak.frequency().0, frequency, 1e-15);
        assert_near(peak.gain().expect("damped").0, gain, 1e-15);
    }
}

/// With losses terms cancel at 0 and at ∞ as without: in what a mass that hangs on another moves beside it, in accelerations, in the
/// stretch of a free spring, in what a support carries along by springs and dampers, and of what is 0 everywhere. Peaks by mpmath with 50 digits, zeros of d|H|/dΩ of the exact doubles; of
/// the free spring in closed form, Ω² = k/m_a + k/m_b and 1/(m_a Ω² η).
#[test]
fn functions_with_losses_are_complete() {
    let hung = System::builder()
        .mass("a", 8.0)
        .mass("b", 4.0)
        .spring(GROUND, "a", 8.0)
        .spring("a", "b", 0.1)
        .spring("a", "b", 0.2);
    let one = System::builder()
        .mass("b", 2.0)
        .spring(GROUND, "b", 0.1)
        .spring(GROUND, "b", 0.2)
        .damper(GROUND, "b", 0.25);
    let free = System::builder()
        .mass("a", 1.0)
        .mass("b", 2.0)
        .spring("a", "b", 6.0);
    let riding = System::builder()
        .mass("a", 1.0)
        .mass("b", 0.0)
        .spring(GROUND, "a", 1.5)
        .spring("a", "b", 0.3);
    let carried = System::builder()
        .mass("a", 1.9)
        .mass("b", 3.52)
        .support("soil")
        .spring("soil", "a", 56.3)
        .spring("a", "b", 32.4)
        .damper("soil", "b", 0.0982);
    let two = System::builder()
        .mass("a", 1.0)
        .mass("b", 2.0)
        .mass("c", 2.0)
        .spring("a", "b", 6.0)
        .damper("a", "b", 0.5)
        .spring(GROUND, "c", 1.0);
    let apart = |quantity| between("apart", quantity, "b", "a");
    let moved = || sum("moved", &[(Quantity::Acceleration, "b", 1.0)]);
    let displaced = Quantity::Displacement;
    let cases = [
        (
            hung,
            vec![0.0, 0.25, 0.25],
            "a",
            apart(Quantity::Velocity),
            &[
                (0.281_417_545_489_947_2, 0.155_810_819_707_244),
                (1.019_935_212_892_388_4, 12.620_833_168_055_978),
            ][..],
        ),
        (
            one,
            vec![0.5, 0.25],
            "b",
            moved(),
            &[(0.453_574_927_670_431_6, 0.854_540_640_018_357_3)],
        ),
        (
            free,
            vec![0.125],
            "a",
            apart(displaced),
            &[(3.0, 8.0 / 9.0)],
        ),
        (riding, vec![0.1, 6.15], "a", apart(displaced), &[]),
        // The last peak is 1.2e-4 above the limit for Ω → ∞.
        (
            carried.clone(),
            vec![0.0415, 0.0605],
            "soil",
            sum("moved", &[(Quantity::Velocity, "b", 1.0)]),
            &[
                (2.326_868_685_919_645_5, 41.608_497_771_257_29),
                (7.099_576_119_830_777, 16.840_925_374_822_27),
                (159.159_304_333_715_54, 0.027_901_034_639_764_294),
            ],
        ),
        (
            carried,
            vec![0.0415, 0.0605],
            "soil",
            sum("moved", &[(Quantity::Displacement, "b", 1.0)]),
            &[
                (2.324_586_389_457_389, 17.890_529_688_991_93),
                (7.094_968_771_047_071, 2.372_871_634_952_83),
            ],
        ),
        (
            two,
            vec![0.125, 0.0],
            "a",
            sum("moved", &[(displaced, "c", 1.0)]),
            &[],
        ),
    ];
    for (builder, losses, from, output, truth) in cases {
        let system = builder.build().expect("a system");
        let asked = FrequencyResponse::of(&system).from(from).output(output);
        let found = asked.loss_factors(losses).features(&[0.1, 3.0]);
        let found = &found.expect("features")[0];
        assert!(found.is_complete(), "{found:?}");
        assert_eq!(found.peaks().len(), truth.len());
        for (peak, (frequency, gain)) in found.peaks().iter().zip(truth) {
            assert_near(peak.frequency().0, *frequency, 1e-15);
            assert_near(peak.gain().expect("damped").0, *gain, 1e-15);
        }
        let Some(LargestGain::Finite { gain, .. }) = found.largest_gain() else {
            panic!("{found:?}")
        };
        let largest = truth.iter().map(|(_, gain)| *gain).fold(0.0, f64::max);
        assert_near(gain, largest, 1e-15);
    }
}

/// Of the velocity of one mass it is 1/√2 of the peak where |k − mΩ²| = cΩ, wherever the grid ends.
#[test]
fn half_power_is_found_beyond_the_grid() {
    let damping = 3.0;
    let system = in_a_row(&[("m", 1.0)], &[1.0], &[damping]);
    let asked = FrequencyResponse::of(&system).from("m").to("m");
    let asked = asked.quantity(Quantity::Velocity);
    let found = &asked.features(&[0.5, 2.0]).expect("features")[0];
    let [low, high] = found.peaks()[0].half_power().expect("it falls to 0");
    let root = f64::sqrt(damping * damping + 4.0);
    assert_near(high, 0.5 * (root + damping), 1e-15);
    assert_near(low, 2.0 / (root + damping), 1e-15);
}

/// Parts that nothing joins do not move each other, and no rounding makes them.
#[test]
fn what_is_not_reached_is_exactly_0() {
    let system = System::builder()
        .mass("a", 1.0)
        .mass("b", 1.0)
        .mass("c", 2.0)
        .spring(GROUND, "a", 1.0)
        .spring(GROUND, "b", 4.0)
        .spring("b", "c", 0.3)
        .build()
        .expect("a system");
    let modes = system.modes().expect("modes");
    let grid = peak_grid(&system, &modes, &[]);
    for precision in [Precision::Double, Precision::default()] {
        let asked = FrequencyResponse::of(&system).from("c").to("a");
        let asked = asked.precision(precision);
        let found = &asked.features(&grid).expect("features")[0];
        let Some(LargestGain::Finite { gain, bound, .. }) = found.largest_gain() else {
            panic!("{precision:?}: {found:?}")
        };
        assert_eq!((gain, bound), (0.0, 0.0));
        let values = asked.at(&[0.7, 2.0]).expect("values");
        for value in values.functions()[0].values() {
            assert_eq!(value.known(), Some((Complex::ZERO, Some(0.0))));
        }
    }
}

/// Between two frequencies that lie below and above all of them.
#[test]
fn peaks_need_no_grid() {
    let system = absorber(0.05, 0.01);
    let asked = FrequencyResponse::of(&system).from("machine").to("machine");
    let found = &asked.features(&[1e-3, 10.0]).expect("features")[0];
    assert!(found.is_complete());
    assert_eq!((found.peaks().len(), found.dips().len()), (2, 1));
    let known = features(&system, "machine", "machine");
    assert_eq!(found.largest_gain(), known.largest_gain());
    let largest = known.largest().expect("damped");
    let LargestGain::Finite {
        frequency, gain, ..
    } = known.largest_gain().expect("proven")
    else {
        panic!("{known:?}")
    };
    assert_eq!(frequency, largest.frequency().0);
    assert_eq!(gain, largest.gain().expect("damped").0);
    // Without a frequency too.
    let found = &asked.features(&[]).expect("features")[0];
    assert_eq!((found.peaks().len(), found.dips().len()), (2, 1));
}

#[test]
fn the_largest_gain_may_be_at_an_end() {
    let gain = |damping: f64, quantity: Quantity| {
        let system = System::builder()
            .mass("m", 2.0)
            .support("road")
            .spring("road", "m", 8.0)
            .damper(GROUND, "m", damping)
            .build()
            .expect("a system");
        let asked = FrequencyResponse::of(&system).from("m").to("m");
        let found = asked.quantity(quantity).features(&[1.0]).expect("features");
        assert!(found[0].is_complete());
        found[0].largest_gain().expect("proven")
    };
    let finite = |found| match found {
        LargestGain::Finite {
            frequency,
            gain,
            bound,
        } => (frequency, gain, bound),
        LargestGain::Unbounded { frequency } => panic!("{frequency}"),
    };
    // Overdamped: the static value, and the inverse of the mass.
    let (frequency, value, bound) = finite(gain(40.0, Quantity::Displacement));
    assert!(frequency == 0.0 && (value - 0.125).abs() <= bound && bound < 1e-16);
    let (frequency, value, bound) = finite(gain(40.0, Quantity::Acceleration));
    assert!(frequency == f64::INFINITY && (value - 0.5).abs() <= bound && bound < 1e-15);
    // |iΩ/(8 − 2Ω² + icΩ)| is largest at Ω = 2, and 1/c there.
    let (frequency, value, bound) = finite(gain(40.0, Quantity::Velocity));
    assert!((frequency - 2.0).abs() < 1e-15 && (value - 0.025).abs() <= bound);
    // |1/(2iΩ + c)| of a mass that no spring holds.
    let system = in_a_row(&[("m", 2.0)], &[], &[40.0]);
    let asked = FrequencyResponse::of(&system).from("m").to("m");
    let found = asked
        .quantity(Quantity::Velocity)
        .features(&[1.0])
        .expect("features");
    let (frequency, value, bound) = finite(found[0].largest_gain().expect("proven"));
    assert!(frequency == 0.0 && (value - 0.025).abs() <= bound && bound < 1e-17);
    let unbounded = gain(0.0, Quantity::Displacement);
    let LargestGain::Unbounded { frequency } = unbounded else {
        panic!("{unbounded:?}")
    };
    assert_near(frequency, 2.0, 1e-15);
}

/// A suspension's travel is 0 on a road at rest, as springs and dampers follow it: no rounding hides that.
#[test]
fn what_vanishes_at_rest_hides_no_peak() {
    let car = car().build().expect("a system");
    let travel = between("travel", Quantity::Displacement, "wheel", "body");
    let asked = FrequencyResponse::of(&car).from("road").output(travel);
    let found = &asked.features(&[1.0]).expect("features")[0];
    assert!(found.is_complete());
    assert_eq!((found.peaks().len(), found.dips().len()), (2, 1));
}

/// Where nothing has a state, as massless nodes on springs, all follows at once, by modes as by elimination.
#[test]
fn massless_nodes_on_springs_follow_at_once() {
    let system = in_a_row(&[("n", 0.0), ("e", 0.0)], &[4.0, 4.0], &[]);
    for precision in [Precision::Double, Precision::default()] {
        let asked = FrequencyResponse::of(&system).from("n").to("n").to("e");
        let asked = asked.precision(precision);
        let found = asked.at(&[0.0, 3.0]).expect("an answer");
        for value in found.functions().iter().flat_map(|f| f.values()) {
            let (value, _) = value.known().expect("no pole");
            assert!((value - 0.25).norm() <= 1e-15, "{value}");
        }
        for features in asked.features(&[1.0, 2.0]).expect("features") {
            let Some(LargestGain::Finite { gain, .. }) = features.largest_gain() else {
                panic!("{features:?}")
            };
            assert_near(gain, 0.25, 1e-15);
        }
    }
}

/// What a force does to masses that it reaches does not depend on those that it does not reach, which come first here.
#[test]
fn outputs_out_of_reach_change_no_others() {
    let system = System::builder()
        .mass("a", 1.0)
        .mass("b", 1.0)
        .spring(GROUND, "a", 1.0)
        .spring(GROUND, "b", 4.0)
        .damper(GROUND, "b", 0.1)
        .build()
        .expect("a system");
    let modes = system.modes().expect("modes");
    let grid = peak_grid(&system, &modes, &[]);
    let asked = FrequencyResponse::of(&system).from("b").to("a").to("b");
    let both = asked.features(&grid).expect("features");
    let alone = features(&system, "b", "b");
    assert!(both[0].peaks().is_empty() && both[0].is_complete());
    assert_eq!(format!("{:?}", both[1]), format!("{alone:?}"));
}

#[test]
fn peaks_of_many_masses_are_proven_too() {
    let system = full(45, true);
    let found = features(&system, "m0", "m7");
    assert!(found.peaks().len() > 3, "{}", found.peaks().len());
    for peak in found.peaks() {
        let (frequency, bound) = peak.frequency();
        assert!(bound <= 4.0 * f64::EPSILON * frequency);
        let (gain, bound) = peak.gain().expect("damped");
        assert!(bound <= 4.0 * f64::EPSILON * gain);
        let beside = [1.0 - 1e-5, 1.0 + 1e-5].map(|factor| factor * frequency);
        let beside = FrequencyResponse::of(&system)
            .from("m0")
            .to("m7")
            .at(&beside);
        let beside = beside.expect("a response");
        for value in beside.functions()[0].values() {
            assert!(value.known().expect("no pole").0.norm() < gain);
        }
    }
}

/// K and C with the shapes of one reflection, and a damper that joins all modes, or none: |H|² in closed form, of which every
/// turn is found on a fine grid, and every pole.
#[test]
fn full_matrices_have_all_their_peaks() {
    let asked = [
        (24, &[0, 5, 23][..], true),
        (48, &[7], true),
        (7, &[0, 3], false),
        (24, &[0, 5], false),
        (48, &[7], false),
    ];
    for (n, outputs, is_damped) in asked {
        let omega = |k: usize| 1.0 + 0.31 * k as f64 + 0.1 * (k as f64 * 1.7).sin();
        let zeta = |k: usize| match is_damped {
            true => 0.004 + 0.006 * (k % 5) as f64,
            false => 0.0,
        };
        let v: Vec<f64> = (0..n).map(|i| 1.0 + (0.9 * i as f64).sin()).collect();
        let square: f64 = v.iter().map(|v| v * v).sum();
        let q = |i: usize, k: usize| f64::from(i == k) - 2.0 * v[i] * v[k] / square;
        let modal = |value: &dyn Fn(usize) -> f64| {
            Mat::from_fn(n, n, |i, j| {
                let (i, j) = (i.min(j), i.max(j));
                (0..n).map(|k| q(i, k) * value(k) * q(j, k)).sum()
            })
        };
        let dashpot = if is_damped { 0.7 } else { 0.0 };
        let mut damping = modal(&|k| 2.0 * zeta(k) * omega(k));
        damping[(2, 2)] += dashpot;
        let stiffness = modal(&|k| omega(k) * omega(k));
        let mass = Mat::<f64>::identity(n, n);
        let system = System::from_matrices(mass.as_ref(), damping.as_ref(), stiffness.as_ref());
        let system = system.expect("a system");
        let inverses = |w: f64| -> Vec<Complex<f64>> {
            let one = |k| Complex::new(omega(k).powi(2) - w * w, 2.0 * zeta(k) * omega(k) * w);
            (0..n).map(|k| one(k).inv()).collect()
        };
        let h = |to: usize, w: f64| {
            let inverses = inverses(w);
            let free = |a: usize, b: usize| -> Complex<f64> {
                let each = inverses.iter().enumerate();
                each.map(|(k, inverse)| inverse * q(a, k) * q(b, k)).sum()
            };
            let pull = Complex::new(0.0, w * dashpot);
            free(0, to) - pull * free(0, 2) * free(2, to) / (1.0 + pull * free(2, 2))
        };
        for &to in outputs {
            let found = features(&system, "x1", &format!("x{}", to + 1));
            let poles = found.peaks().iter().filter(|peak| peak.gain().is_none());
            let poles: Vec<(f64, f64)> = poles.map(|peak| peak.frequency()).collect();
            assert_eq!(poles.len(), if is_damped { 0 } else { n });
            for (k, (pole, off)) in poles.into_iter().enumerate() {
                assert!(
                    (pole - omega(k)).abs() < 1e-13 * pole,
                    "{pole} {}",
                    omega(k)
                );
                assert!(off <= f64::EPSILON * pole, "{off:e}");
            }
            let mut turns: Vec<(f64, bool)> = Vec::new();
            let peaks = found.peaks().iter().map(|peak| (peak.frequency().0, true));
            turns.extend(peaks);
            turns.extend(found.dips().iter().map(|dip| (dip.frequency().0, false)));
            turns.sort_by(|a, b| a.0.total_cmp(&b.0));
            let count = 30_000;
            let (low, high) = (0.02f64, 20.0 * omega(n - 1));
            let even = |k: usize| low * (high / low).powf(k as f64 / count as f64);
            let mut grid: Vec<f64> = (0..=count).map(even).collect();
            if !is_damped {
                // A zero may be close to a pole.
                let near = (0..n).flat_map(|k| {
                    let offsets = (0..80).map(move |j| 0.01 * 0.75f64.powi(j));
                    offsets.flat_map(move |off| [1.0 - off, 1.0 + off].map(|part| part * omega(k)))
                });
                grid.extend(near);
                grid.sort_by(f64::total_cmp);
            }
            let at = |k: usize| grid[k];
            let sizes: Vec<f64> = grid.iter().map(|w| h(to, *w).norm()).collect();
            let mut seen = turns.iter();
            for k in 1..grid.len() - 1 {
                let [before, own, after] = [k - 1, k, k + 1].map(|k| sizes[k]);
                if (own - before) * (own - after) > 0.0 {
                    let &(frequency, is_peak) = seen.next().expect("none is missing");
                    assert_eq!(is_peak, own > before);
                    assert!(
                        at(k - 1) < frequency && frequency < at(k + 1),
                        "{frequency}"
                    );
                }
            }
            assert_eq!(seen.next(), None, "{turns:?}");
            assert!(turns.len() > n / 2, "{}", turns.len());
        }
    }
}

#[test]
fn long_chains_are_solved_by_a_sparse_factor() {
    for (damping, loss) in [(0.02, 0.0), (0.02, 0.01), (0.0, 0.1)] {
        a_long_chain_is_solved(damping, loss);
    }
}

/// Masses of 1 kg between springs of 4 N/m with a loss factor and dampers in N·s/m, with both ends at the ground: the inverse of
/// a tridiagonal matrix in closed form (Hu & O'Connell 1996, *J. Phys. A* 29).
fn a_long_chain_is_solved(damping: f64, loss: f64) {
    let n = 1000;
    let system = chain(&vec![1.0; n], &vec![4.0; n + 1], &vec![damping; n + 1]);
    let frequencies = [0.0, 1e-3, 0.1, 1.0, 3.9];
    let asked = FrequencyResponse::of(&system).from("m3").to("m3").to("m40");
    let answer = asked
        .quantity(Quantity::Velocity)
        .loss_factors(vec![loss; n + 1])
        .at(&frequencies)
        .expect("a response");
    assert_eq!(answer.bounds(), Bounds::Estimated);
    for (k, frequency) in frequencies.into_iter().enumerate() {
        let stiffness = Complex::new(4.0, 4.0 * loss + damping * frequency);
        let cosh = 1.0 - 0.5 * frequency * frequency / stiffness;
        let theta = cosh.acosh();
        for (function, to) in answer.functions().iter().zip([3.0, 40.0]) {
            let (value, bound) = function.values()[k].known().expect("regular");
            let bound = bound.expect("it settles");
            if frequency == 0.0 {
                assert_eq!(value, Complex::ZERO);
                continue;
            }
            let far = n as f64 + 1.0;
            // sinh((far − to)θ)/sinh(far θ), which may not overflow.
            let ratio = ((-theta * to).exp() - (-theta * (2.0 * far - to)).exp())
                / (1.0 - (-theta * 2.0 * far).exp());
            let truth = ratio * (theta * 3.0).sinh() / (theta.sinh() * stiffness);
            let truth = truth * Complex::new(0.0, frequency);
            let off = (value - truth).norm();
            assert!(
                off <= 1e-11 * truth.norm() + bound,
                "{frequency}: {value} {truth}"
            );
            assert!(
                bound <= 1e-14 * value.norm(),
                "{frequency}: {value} ± {bound:e}"
            );
        }
    }
}

/// A mass on a spring and a damper at the near end of a long chain that hardly moves: the peak of one mass in closed form,
/// Ω² = ω²(1 − 2ζ²) and 1/(2kζ√(1 − ζ²)); with a loss factor in place of the damper Ω = ω and 1/(kη).
#[test]
fn peaks_of_large_systems_are_found_by_a_sparse_factor() {
    let n = 1000;
    let name = |i: usize| format!("m{i}");
    for (damping, loss) in [(0.08, 0.0), (0.0, 0.02)] {
        let mut builder = System::builder();
        for i in 0..n {
            builder = builder.mass(name(i), 1.0);
        }
        // The others are held, and joined to each other, but not to the first.
        builder = builder.spring(GROUND, name(0), 4.0);
        builder = builder.damper(GROUND, name(0), damping);
        for i in 1..n {
            builder = builder.spring(GROUND, name(i), 1e4);
            if i > 1 {
                builder = builder.spring(name(i - 1), name(i), 4.0);
            }
        }
        let system = builder.build().expect("a system");
        let springs = system.springs().len();
        let asked = FrequencyResponse::of(&system).from("m0").to("m0");
        let features = asked
            .loss_factors(vec![loss; springs])
            .features(&[0.1, 1.0, 2.5, 20.0])
            .expect("features");
        let [features] = features.as_slice() else {
            panic!("one function")
        };
        assert!(!features.is_complete());
        let [peak] = features.peaks() else {
            panic!("one peak: {features:?}")
        };
        let zeta = damping / 4.0;
        let frequency = 2.0 * (1.0f64 - 2.0 * zeta * zeta).sqrt();
        let gain = match damping > 0.0 {
            true => 1.0 / (8.0 * zeta * (1.0f64 - zeta * zeta).sqrt()),
            false => 1.0 / (4.0 * loss),
        };
        let (found, off) = peak.frequency();
        assert!(
            (found - frequency).abs() <= off + 1e-15,
            "{found} ± {off:e}"
        );
        assert!(off < 1e-11, "{off:e}");
        let (found, off) = peak.gain().expect("it settles");
        assert!(
            (found - gain).abs() <= off + 1e-15 * gain,
            "{found} ± {off:e}"
        );
        assert!(off < 1e-13 * gain, "{off:e}");
        let width = peak.relative_width().expect("it falls");
        let expected = if damping > 0.0 { 2.0 * zeta } else { loss };
        assert!((width / expected - 1.0).abs() < 0.01, "{width}");
        assert_eq!(features.low().expect("a limit").power, 0);
        assert_eq!(features.high().expect("a limit").power, -2);
    }
}

/// One mass, whose peak is narrower than the doubles beside it are apart, down to 1e-25 of its frequency.
#[test]
fn narrow_peaks_have_gains_and_widths() {
    for damping in [1e-14, 3e-16, 1e-18, 1e-19, 1e-20, 1e-22, 1e-24] {
        let system = System::builder().mass("a", 1.0).spring(GROUND, "a", 3.0);
        let system = system.damper(GROUND, "a", damping).build();
        let found = features(&system.expect("a system"), "a", "a");
        let peak = found.peaks()[0];
        let root = 3f64.sqrt();
        let (gain, bound) = peak.gain().expect("it is finite");
        let truth = 1.0 / (damping * root);
        assert!((gain - truth).abs() <= bound + 4e-16 * truth, "{damping}");
        assert!(bound <= 1e-7 * gain, "{damping}: {bound:e}");
        let width = peak.relative_width().expect("it falls");
        assert_near(width, damping / root, 1e-6);
        let [low, high] = peak.half_power().expect("it falls");
        let place = peak.frequency().0;
        assert!(low <= place && place <= high);
        assert_near(high - low, damping, f64::EPSILON * 4.0 / damping);
    }
}

/// Peaks among others, high and low ones: at both frequencies the magnitude is 1/√2 of that of the peak, one below and one above it.
#[test]
fn half_power_is_on_both_sides_of_each_peak() {
    let mut numbers = Random(11);
    let mut between = |low: f64, high: f64| low + 0.5 * (high - low) * (numbers.signed() + 1.0);
    let mut seen = 0;
    for n in [4, 8, 14] {
        let masses: Vec<(String, f64)> = (0..n)
            .map(|i| (format!("m{i}"), between(0.3, 3.0)))
            .collect();
        let masses: Vec<(&str, f64)> = masses.iter().map(|(name, m)| (&name[..], *m)).collect();
        let stiffness: Vec<f64> = (0..n).map(|_| between(10.0, 900.0)).collect();
        let damping: Vec<f64> = (0..n).map(|_| between(0.0, 0.05)).collect();
        let system = in_a_row(&masses, &stiffness, &damping);
        for to in ["m0", "m1", "m3"] {
            let found = features(&system, "m2", to);
            for peak in found.peaks() {
                let Some(ends) = peak.half_power() else {
                    continue;
                };
                let (place, gain) = (peak.frequency().0, peak.gain().expect("it is damped").0);
                assert!(ends[0] < place && place < ends[1], "{ends:?} {place}");
                let width = (ends[1] - ends[0]) / place;
                assert_near(
                    peak.relative_width().expect("it has one"),
                    width,
                    1e-15 / width,
                );
                let asked = FrequencyResponse::of(&system).from("m2").to(to);
                let values = asked.at(&ends).expect("values");
                for value in values.functions()[0].values() {
                    let (value, _) = value.known().expect("no pole");
                    let half = gain * std::f64::consts::FRAC_1_SQRT_2;
                    assert_near(value.norm(), half, 1e-14 / width);
                }
                seen += 1;
            }
        }
    }
    assert!(seen > 40, "{seen}");
}

/// Of an acceleration that grows with the frequency: bands whose one end is higher than the point of the grid beside it, and lower
/// than the peak between both.
#[test]
fn a_peak_beside_the_end_of_a_band_is_found() {
    let (stiffness, damping) = (100.0, 6.0);
    let system = System::builder()
        .mass("a", 1.0)
        .support("g")
        .spring("g", "a", stiffness)
        .damper("g", "a", damping)
        .build()
        .expect("a system");
    let asked = FrequencyResponse::of(&system).from("g").to("a");
    let asked = asked.quantity(Quantity::Acceleration);
    let gain = |omega: f64| {
        let pull = Complex::new(stiffness, omega * damping);
        (omega * omega * pull / (pull - omega * omega)).norm()
    };
    let mut place = 11.0;
    while gain(place + 1e-6) > gain(place) {
        place += 1e-6;
    }
    let modes = system.modes().expect("modes");
    let roots: Vec<Complex<f64>> = modes.eigenvalues().iter().map(|root| root.value).collect();
    for apart in [1e-4, 1e-3, 1e-2, 0.1] {
        for [low, high] in [
            [place * (1.0 - apart), 1.1 * place],
            [0.5 * place, place * (1.0 + apart)],
        ] {
            let peaks = asked.peaks_about(&roots, low, high).expect("values");
            let peaks = peaks.expect("they are known").into_iter();
            let highest = peaks.map(|(_, gain)| gain).fold(0.0, f64::max);
            assert_near(highest, gain(place), 1e-10);
        }
    }
}

/// A wheel follows a road nearly rigidly: its peak rises above 1 by 1e-4 only, within a wide bracket.
#[test]
fn flat_turns_are_as_sharp_as_others() {
    let car = System::builder()
        .mass("body", 290.0)
        .mass("wheel", 5.0)
        .support("road")
        .spring("wheel", "body", 100.0)
        .damper("wheel", "body", 20.0)
        .spring("road", "wheel", 400_000.0)
        .build()
        .expect("a system");
    let asked = FrequencyResponse::of(&car).from("road").to("wheel");
    let found = &asked.features(&[1.0]).expect("features")[0];
    assert!(found.is_complete());
    let flat = &found.peaks()[0];
    let (gain, bound) = flat.gain().expect("damped");
    assert!((1.0..1.01).contains(&gain), "{flat:?}");
    assert!(bound <= 4.0 * f64::EPSILON, "{flat:?}");
    let (frequency, bound) = flat.frequency();
    assert!(bound <= f64::EPSILON * frequency, "{flat:?}");
}

/// −Ω²/(2 − Ω²) of a mass of 1 kg on 2 N/m is less than any double at 1e-200 rad/s, but not 0.
#[test]
fn bounds_count_what_is_smaller_than_doubles() {
    let system = in_a_row(&[("m", 1.0)], &[2.0], &[]);
    for precision in [Precision::Double, Precision::default()] {
        let asked = FrequencyResponse::of(&system).from("m").to("m");
        let asked = asked.quantity(Quantity::Acceleration).precision(precision);
        for (frequency, exact) in [(1e-200, 0.0), (1e-154, -5e-309), (1e-100, -5e-201)] {
            let found = asked.at(&[frequency]).expect("well posed");
            let FrequencyValue::Known { value, bound } = found.functions()[0].values()[0] else {
                panic!("{frequency:e} is no pole");
            };
            let bound = bound.expect("proven");
            assert!(bound > 0.0, "{frequency:e}");
            let off = (value.re - exact).abs();
            assert!(off <= bound, "{frequency:e}: {value} ± {bound:e}");
        }
    }
}

/// Far above all modes what these make of a distant coordinate cancels, and their sum says nothing.
#[test]
fn bounds_far_above_all_modes_say_something() {
    let system = in_a_row(&[("a", 1.0), ("b", 2.0)], &[1.0, 1.0, 1.0], &[1.0]);
    let asked = FrequencyResponse::of(&system).from("a").to("b");
    let asked = asked.quantity(Quantity::Acceleration);
    let asked = asked.precision(Precision::Double);
    let found = asked.at(&[1e3, 1e6, 1e12]).expect("well posed");
    for (value, frequency) in found.functions()[0].values().iter().zip([1e3, 1e6, 1e12]) {
        let &FrequencyValue::Known { value, bound } = value else {
            panic!("{frequency:e} is no pole");
        };
        // −Ω² times the entry of (K + iΩC − Ω²M)⁻¹, which is 1/determinant.
        let square = frequency * frequency;
        let first = Complex::new(2.0 - square, frequency);
        let exact = Complex::<f64>::from(-square) / (first * (2.0 - 2.0 * square) - 1.0);
        let bound = bound.expect("proven");
        assert!(bound <= 1e-3 * exact.norm(), "{frequency:e}: {bound:e}");
        let off = (value - exact).norm();
        assert!(
            off <= bound + 1e-15 * exact.norm(),
            "{frequency:e}: {off:e}"
        );
    }
}

/// Behind a chain with a node without mass, where a force falls to a part in 1e35 before the node's damper holds it, and in front
/// of one where doubles leave no digit of the slope.
#[test]
fn turns_behind_a_node_without_mass_are_all_found() {
    all_turns_are_found(
        ["m1", "m7"],
        [1.14, 1.4, 2.23, 2.6, 0.0, 2.13, 1.83],
        [3319.3, 14.3, 4030.3, 56.0, 35.2, 147.3, 714.1],
        [0.056, 0.13, 0.02, 0.168, 0.0, 0.016, 0.025],
    );
    all_turns_are_found(
        ["m7", "m1"],
        [1.26, 0.0, 2.3, 1.7, 0.73, 0.55, 1.87],
        [73.8, 15.0, 2183.9, 61.0, 11.9, 65.3, 3999.1],
        [0.0, 0.12, 0.0, 0.0, 0.06, 0.074, 0.0],
    );
}

/// All turns between the ends of a chain are those of the continuants of its matrix on a fine grid.
fn all_turns_are_found(
    [from, to]: [&str; 2],
    masses: [f64; 7],
    springs: [f64; 7],
    dampers: [f64; 7],
) {
    let n = masses.len();
    let system = chain(&masses, &springs, &dampers);
    let found = features(&system, from, to);
    let size = |frequency: f64| {
        let link = |i: usize| match i < n {
            true => Complex::new(springs[i], frequency * dampers[i]),
            false => Complex::ZERO,
        };
        let (mut before, mut now) = (Complex::ZERO, Complex::ONE);
        for (i, mass) in masses.iter().enumerate() {
            let own = link(i) + link(i + 1) - frequency * frequency * mass;
            let next = own * now - link(i) * link(i) * before;
            (before, now) = (now, next);
        }
        let links = (1..n).map(|i| link(i).norm().ln()).sum::<f64>();
        links - now.norm().ln()
    };
    let mut turns = [Vec::new(), Vec::new()];
    let at = |k: i32| 0.1 * (f64::from(k) * 4e-5).exp();
    let sizes: Vec<f64> = (0..400_000).map(|k| size(at(k))).collect();
    for k in 1..399_999usize {
        let [before, own, after] = [sizes[k - 1], sizes[k], sizes[k + 1]];
        if (own > before) != (after > own) {
            turns[usize::from(own < after)].push(at(k as i32));
        }
    }
    for (found, truth) in [found.peaks(), found.dips()].into_iter().zip(&turns) {
        assert_eq!(found.len(), truth.len(), "{found:?} {truth:?}");
        for (found, truth) in found.iter().zip(truth) {
            assert_near(found.frequency().0, *truth, 1e-4);
        }
    }
}
