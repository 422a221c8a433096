//! What is computed in doubles for many designs, and its derivatives, against proven answers and differences of them.

use eigentone_modes::{GROUND, Precision, System, SystemBuilder};
use eigentone_response::{
    ByCertifiedExponential, Extrema, FrequencyResponse, HalfSine, Harmonic, Hold, LargestGain,
    Peak, Quantity, RandomVibration, Response, ResponsePlan, Samples, State, Step, Trajectory,
    Weighting, peak_grid,
};
use faer::Mat;
use faer::linalg::solvers::Solve;
use num_complex::Complex;

use crate::systems::{CANTILEVER, beam, between, in_a_row, sum};

/// Numbers in (0, 1) that repeat (Park & Miller 1988).
struct Dice(u64);

impl Dice {
    fn throw(&mut self) -> f64 {
        self.0 = self.0 * 16807 % 2_147_483_647;
        self.0 as f64 / 2_147_483_647.0
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.throw())
    }
}

/// A chain of masses that are all damped, with a point and a support.
fn chain(numbers: &[f64]) -> SystemBuilder {
    let n = numbers.len() / 3;
    let mut builder = System::builder().support("road");
    for i in 0..n {
        builder = builder.mass(format!("m{i}"), numbers[3 * i]);
    }
    for i in 0..n {
        let before = if i == 0 {
            "road".to_owned()
        } else {
            format!("m{}", i - 1)
        };
        builder = builder
            .spring(&before, format!("m{i}"), numbers[3 * i + 1])
            .damper(&before, format!("m{i}"), numbers[3 * i + 2]);
    }
    let last = format!("m{}", n - 1);
    let ends = if n == 1 {
        vec![("m0".to_owned(), 0.7)]
    } else {
        vec![("m0".to_owned(), 0.5), (last, 0.5)]
    };
    builder.point("middle", ends, 0.0)
}

fn random(dice: &mut Dice, n: usize, damping: f64) -> Vec<f64> {
    (0..n)
        .flat_map(|_| {
            let [m, k] = [dice.between(0.3, 3.0), dice.between(50.0, 5000.0)];
            [m, k, dice.between(0.5, 2.0) * damping * (m * k).sqrt()]
        })
        .collect()
}

fn built(numbers: &[f64]) -> System {
    chain(numbers).build().expect("a system")
}

/// f′ by a difference of eighth order.
fn slope(numbers: &[f64], at: usize, f: impl Fn(&[f64]) -> f64) -> f64 {
    slope_by(5e-4, numbers, at, f)
}

/// The same with a spacing, in parts of the number.
fn slope_by(spacing: f64, numbers: &[f64], at: usize, f: impl Fn(&[f64]) -> f64) -> f64 {
    const WEIGHTS: [f64; 4] = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
    let spacing = spacing * numbers[at];
    let each = (1..).zip(WEIGHTS).map(|(k, weight)| {
        let moved = |sign: f64| {
            let mut moved = numbers.to_vec();
            moved[at] += sign * f64::from(k) * spacing;
            f(&moved)
        };
        weight * (moved(1.0) - moved(-1.0)) / spacing
    });
    each.sum()
}

/// A derivative of what is linear in a number.
fn linear(numbers: &[f64], at: usize, f: impl Fn(&[f64]) -> f64) -> f64 {
    let moved = |by: f64| {
        let mut moved = numbers.to_vec();
        moved[at] *= 1.0 + by;
        f(&moved)
    };
    (moved(0.5) - moved(-0.5)) / numbers[at]
}

fn road(system: &System) -> FrequencyResponse<'_> {
    FrequencyResponse::of(system)
        .from("road")
        .quantity(Quantity::Acceleration)
        .to("middle")
}

#[test]
fn derivatives_of_frequency_responses_are_those_of_proven_values() {
    let mut dice = Dice(5);
    for n in [1, 3, 5] {
        let numbers = random(&mut dice, n, 0.05);
        let system = built(&numbers);
        let transfer = road(&system).transfer().unwrap().expect("it is small");
        for frequency in [7.0, 20.0, 61.0] {
            let adjoint = transfer.adjoint(frequency).expect("no pole");
            let proven = |numbers: &[f64]| {
                let system = built(numbers);
                let found = road(&system).at(&[frequency]).unwrap();
                let (value, _) = found.functions()[0].values()[0].known().expect("no pole");
                value
            };
            let value = proven(&numbers);
            assert!((adjoint.value() - value).norm() < 1e-13 * value.norm());
            for at in 0..numbers.len() {
                let along = |numbers: &[f64]| {
                    let system = built(numbers);
                    adjoint.along(&road(&system).transfer().unwrap().expect("it is small"))
                };
                let found = Complex::new(
                    linear(&numbers, at, |numbers| along(numbers).re),
                    linear(&numbers, at, |numbers| along(numbers).im),
                );
                let right = Complex::new(
                    slope(&numbers, at, |numbers| proven(numbers).re),
                    slope(&numbers, at, |numbers| proven(numbers).im),
                );
                let size = value.norm() / numbers[at] + right.norm();
                let off = (found - right).norm();
                assert!(off < 1e-11 * size, "{n} {at}: {found} {right}");
            }
        }
    }
}

#[test]
fn losses_of_springs_are_in_derivatives_too() {
    let asked = |k: f64| {
        let system = in_a_row(&[("m", 2.0)], &[k], &[]);
        let asked = FrequencyResponse::of(&system)
            .from("m")
            .to("m")
            .loss_factors([0.1]);
        asked.transfer().unwrap().expect("it is small")
    };
    let adjoint = asked(50.0).adjoint(5.0).expect("no pole");
    // H = 1/(k(1 + iη) − ω²m), dH/dk = −(1 + iη)H².
    let value = Complex::new(0.0, 5.0).inv();
    assert!((adjoint.value() - value).norm() < 1e-15);
    let found = (adjoint.along(&asked(60.0)) - adjoint.along(&asked(40.0))) / 20.0;
    let right = -Complex::new(1.0, 0.1) * value * value;
    assert!((found - right).norm() < 1e-15, "{found} {right}");
}

#[test]
fn the_highest_peak_is_the_proven_one() {
    let mut dice = Dice(11);
    for case in 0..24 {
        let n = 1 + case % 6;
        let damping = [0.3, 0.02, 1e-4][case % 3];
        let system = built(&random(&mut dice, n, damping));
        let modes = system.modes().unwrap();
        let roots: Vec<_> = modes.eigenvalues().iter().map(|root| root.value).collect();
        let force = FrequencyResponse::of(&system).from("m0").to("middle");
        for asked in [force, FrequencyResponse::of(&system).from("road").to("m0")] {
            let features = asked.features(&peak_grid(&system, &modes, &[])).unwrap();
            let Some(LargestGain::Finite { gain, .. }) = features[0].largest_gain() else {
                panic!("{case}: it is damped");
            };
            let is_found = |peaks: &[(f64, f64)]| {
                let found = peaks.iter().map(|(_, value)| *value).fold(0.0, f64::max);
                assert!((found / gain - 1.0).abs() < 1e-11, "{case}: {found} {gain}");
            };
            // By matrices in doubles, but where resonances may leave them too few digits, and by values that keep theirs.
            let transfer = asked.transfer().unwrap().expect("it is small");
            let peaks = transfer.peaks(&system, 0.0, f64::INFINITY);
            assert!(peaks.is_some() || damping < 0.1, "{case}");
            if let Some(peaks) = peaks {
                is_found(&peaks);
            }
            let asked = asked.precision(Precision::Double);
            let peaks = asked.peaks_about(&roots, 0.0, f64::INFINITY).unwrap();
            is_found(&peaks.expect("all values are known"));
        }
    }
}

#[test]
fn gains_that_doubles_do_not_decide_are_left_to_proofs() {
    let undamped = in_a_row(&[("m", 1.0)], &[4.0], &[]);
    let stiff = System::builder()
        .mass("m", 1.0)
        .mass("n", 1.0)
        .spring(GROUND, "m", 4.0)
        .damper(GROUND, "m", 0.1)
        .spring("m", "n", 1e20)
        .damper("m", "n", 1.0);
    for system in [undamped, stiff.build().unwrap()] {
        let transfer = FrequencyResponse::of(&system)
            .from("m")
            .to("m")
            .transfer()
            .unwrap();
        let peaks = transfer
            .expect("it is small")
            .peaks(&system, 0.0, f64::INFINITY);
        assert_eq!(peaks, None);
    }
}

/// The largest gain in doubles, as matrices and as values determine it, and the proven one; infinite where none is proved.
fn largest(
    asked: &FrequencyResponse<'_>,
    system: &System,
    factors: &[f64],
) -> ([Option<f64>; 2], f64) {
    let modes = system.modes().unwrap();
    let roots: Vec<_> = modes.eigenvalues().iter().map(|root| root.value).collect();
    let features = asked.features(&peak_grid(system, &modes, factors)).unwrap();
    let proven = match features[0].largest_gain() {
        Some(LargestGain::Finite { gain, .. }) => gain,
        _ => f64::INFINITY,
    };
    let highest =
        |peaks: Vec<(f64, f64)>| peaks.into_iter().map(|(_, value)| value).reduce(f64::max);
    let transfer = asked.transfer().unwrap().expect("it is small");
    let by_matrices = transfer.peaks(system, 0.0, f64::INFINITY).and_then(highest);
    let asked = asked.clone().precision(Precision::Double);
    let by_values = asked.peaks_about(&roots, 0.0, f64::INFINITY).unwrap();
    ([by_matrices, by_values.and_then(highest)], proven)
}

/// An accelerance tends to 1/m, and the motion of a massless node against a damper may grow without end.
#[test]
fn gains_are_those_of_infinite_frequencies_too() {
    let held = |mass: f64| {
        let builder = System::builder().support("s").mass("m", mass);
        let builder = builder.spring("s", "m", 8.0).damper(GROUND, "m", 7.0);
        builder.build().unwrap()
    };
    let (heavy, massless) = (held(2.0), held(0.0));
    let cases = [
        (&heavy, "m", "m", Quantity::Acceleration, 0.5),
        (&heavy, "m", "m", Quantity::Velocity, 1.0 / 7.0),
        (&heavy, "s", "m", Quantity::Acceleration, 4.0),
        (&heavy, "s", "s", Quantity::Acceleration, f64::INFINITY),
        (&heavy, "s", "s", Quantity::Velocity, f64::INFINITY),
        (&massless, "m", "m", Quantity::Displacement, 0.125),
        (&massless, "m", "m", Quantity::Velocity, 1.0 / 7.0),
        (&massless, "s", "m", Quantity::Velocity, 8.0 / 7.0),
        (&massless, "m", "m", Quantity::Acceleration, f64::INFINITY),
    ];
    for (system, from, to, quantity, truth) in cases {
        let asked = FrequencyResponse::of(system).from(from).to(to);
        let (found, proven) = largest(&asked.quantity(quantity), system, &[]);
        for found in found.map(|found| found.unwrap_or(f64::INFINITY)) {
            let alike = found == truth || (found / truth - 1.0).abs() < 1e-12;
            assert!(alike, "{from} {to} {quantity:?}: {found}");
        }
        assert!(proven == truth || (proven / truth - 1.0).abs() < 1e-12);
    }
    // With losses.
    let asked = FrequencyResponse::of(&heavy)
        .from("m")
        .to("m")
        .loss_factors([0.1]);
    let transfer = asked.quantity(Quantity::Acceleration).transfer().unwrap();
    let peaks = transfer.unwrap().peaks(&heavy, 0.0, f64::INFINITY).unwrap();
    let found = peaks.iter().map(|(_, value)| *value).fold(0.0, f64::max);
    assert!((found / 0.5 - 1.0).abs() < 1e-12, "{found}");
    let asked = FrequencyResponse::of(&massless)
        .from("m")
        .to("m")
        .loss_factors([0.1]);
    let highest = |quantity: Quantity| {
        let transfer = asked.clone().quantity(quantity).transfer().unwrap();
        let peaks = transfer.unwrap().peaks(&massless, 0.0, f64::INFINITY)?;
        peaks.into_iter().map(|(_, value)| value).reduce(f64::max)
    };
    assert_eq!(highest(Quantity::Acceleration), None);
    // It comes near 1/c as 1/Ω.
    let found = highest(Quantity::Velocity).unwrap();
    assert!((found * 7.0 - 1.0).abs() < 1e-12, "{found}");
}

/// The accelerance at the end of a beam tends to a limit too, in values where matrices in doubles have too few digits.
#[test]
fn gains_of_finite_elements_are_those_of_infinite_frequencies_too() {
    let mast = System::builder()
        .beam(beam("mast", 16, [10.0, 1e6, 10.0], CANTILEVER))
        .rayleigh(0.1, 1e-4, None)
        .damper(GROUND, "mast.16.w", 30.0)
        .build()
        .unwrap();
    let asked = FrequencyResponse::of(&mast)
        .from("mast.16.w")
        .to("mast.16.w");
    let asked = asked
        .quantity(Quantity::Acceleration)
        .precision(Precision::Double);
    let modes = mast.modes().unwrap();
    let roots: Vec<_> = modes.eigenvalues().iter().map(|root| root.value).collect();
    let peaks = asked
        .peaks_about(&roots, 0.0, f64::INFINITY)
        .unwrap()
        .expect("it is known");
    let found = peaks.iter().map(|(_, value)| *value).fold(0.0, f64::max);
    // What the inverse of the mass matrix has there.
    let mut unit = Mat::<f64>::zeros(mast.len(), 1);
    let end = mast
        .names()
        .iter()
        .position(|name| name == "mast.16.w")
        .unwrap();
    unit[(end, 0)] = 1.0;
    let limit = mast.mass_matrix().partial_piv_lu().solve(&unit)[(end, 0)];
    assert!((found / limit - 1.0).abs() < 1e-12, "{found} {limit}");
}

/// The highest peak between two frequencies in doubles, and the proven one.
fn highest_between(
    asked: &FrequencyResponse<'_>,
    system: &System,
    factors: &[f64],
    low: f64,
    high: f64,
) -> (f64, f64) {
    let modes = system.modes().unwrap();
    let features = asked.features(&peak_grid(system, &modes, factors)).unwrap();
    assert!(features[0].is_complete());
    let within = |peak: &&Peak| (low..=high).contains(&peak.frequency().0);
    let proven = features[0]
        .peaks()
        .iter()
        .filter(within)
        .filter_map(|peak| peak.gain());
    let transfer = asked.transfer().unwrap().expect("it is small");
    let found = transfer
        .peaks(system, low, high)
        .expect("doubles determine it");
    let found = found.iter().map(|(_, value)| *value);
    (
        found.fold(0.0, f64::max),
        proven.map(|(gain, _)| gain).fold(0.0, f64::max),
    )
}

/// A micromechanical system of 1e-13 kg: beside the end of the band the level set alone shows its peak.
#[test]
fn a_peak_near_the_end_of_a_band_is_found_in_small_units() {
    let system = System::builder()
        .mass("a", 1.26e-13)
        .mass("b", 4.08e-13)
        .mass("c", 1.46e-13)
        .spring(GROUND, "a", 2.6e6)
        .spring(GROUND, "b", 62_900.0)
        .spring(GROUND, "c", 1.48e6)
        .spring("b", "c", 157_000.0)
        .damper(GROUND, "a", 1.48e-4)
        .damper(GROUND, "b", 2.38e-5)
        .damper(GROUND, "c", 3.66e-5)
        .damper("a", "b", 1.44e-4)
        .damper("a", "c", 1.88e-4)
        .damper("b", "c", 1.05e-4)
        .build()
        .unwrap();
    let asked = FrequencyResponse::of(&system).from("a").to("a");
    let (found, proven) = highest_between(&asked, &system, &[], 5e7, 3_795_246_651.297_837);
    assert!((found / proven - 1.0).abs() < 1e-12, "{found} {proven}");
}

/// The same system in units of time and mass that are powers of two has the same gains, to the last digits.
#[test]
fn units_change_no_gain() {
    let built = |mass: f64, time: f64| {
        let (k, c) = (mass / time.powi(2), mass / time);
        let mut builder = System::builder();
        for (name, part) in [("a", 2.49), ("b", 0.24), ("c", 0.0)] {
            builder = builder.mass(name, part * mass);
        }
        builder = builder
            .spring("a", "b", 6.5 * k)
            .spring(GROUND, "a", 36.0 * k)
            .spring(GROUND, "b", 1.2 * k)
            .spring(GROUND, "c", 0.4 * k)
            .spring("c", "b", 0.1 * k)
            .damper(GROUND, "c", 30.0 * c)
            .damper("a", "b", 0.02 * c)
            .damper(GROUND, "a", 0.04 * c);
        builder.build().unwrap()
    };
    for losses in [[0.0; 5], [0.02, 0.1, 0.0, 0.2, 0.0]] {
        let mut known: Option<[f64; 2]> = None;
        for [mass, time] in [
            [0, 0],
            [-20, -10],
            [30, 30],
            [0, 30],
            [-30, -33],
            [5, 60],
            [0, -60],
        ] {
            let [mass, time] = [mass, time].map(f64::from).map(f64::exp2);
            let system = built(mass, time);
            let asked = FrequencyResponse::of(&system)
                .from("a")
                .to("c")
                .loss_factors(losses);
            let transfer = asked.transfer().unwrap().expect("it is small");
            // Past the last peak that is in the band, and everywhere.
            let bands = [(0.5 / time, 3.9 / time), (0.0, f64::INFINITY)];
            let found = bands.map(|(low, high)| {
                let peaks = transfer.peaks(&system, low, high);
                let peaks = peaks.unwrap_or_else(|| panic!("{mass:e} {time:e} {losses:?} {high}"));
                let highest = peaks.iter().map(|(_, value)| *value).fold(0.0, f64::max);
                highest * mass / time.powi(2)
            });
            let known = *known.get_or_insert(found);
            for (found, known) in found.iter().zip(known) {
                let off = (found / known - 1.0).abs();
                assert!(off < 1e-12, "{mass:e} {time:e}: {found} {known}");
            }
        }
    }
}

/// A peak near the end of a band, and one a thousand times as fast as the fastest root, 3e-7 higher than the limit.
#[test]
fn peaks_between_losses_are_the_proven_ones() {
    let two = System::builder()
        .mass("a", 3.0131)
        .mass("b", 1.0)
        .spring(GROUND, "a", 1.7308)
        .spring(GROUND, "b", 1.0222)
        .spring(GROUND, "a", 10.128)
        .damper(GROUND, "a", 0.0406)
        .damper(GROUND, "b", 1.5453)
        .damper("a", "b", 0.18345);
    let two = (two.build().unwrap(), "b", "a", Quantity::Acceleration);
    let massless = System::builder()
        .mass("a", 0.0)
        .mass("b", 0.0)
        .mass("c", 1.0)
        .mass("d", 0.0)
        .spring(GROUND, "a", 0.2477)
        .spring("a", "b", 1.7016)
        .spring(GROUND, "c", 3.4225)
        .spring("b", "d", 2.805)
        .spring("b", "a", 0.09757)
        .damper("a", "b", 0.31126)
        .damper(GROUND, "c", 0.07032)
        .damper(GROUND, "d", 0.12162)
        .damper("c", "b", 0.0871)
        .damper(GROUND, "a", 0.02754);
    let massless = (massless.build().unwrap(), "b", "a", Quantity::Velocity);
    let cases = [
        (two, vec![0.0, 0.0, 0.1], (1.9847, 180.8)),
        (
            massless,
            vec![0.0, 0.1, 0.0, 0.0, 0.0],
            (0.0, f64::INFINITY),
        ),
    ];
    for ((system, from, to, quantity), factors, (low, high)) in cases {
        let asked = FrequencyResponse::of(&system)
            .from(from)
            .to(to)
            .quantity(quantity);
        let asked = asked.loss_factors(factors.clone());
        let (found, proven) = highest_between(&asked, &system, &factors, low, high);
        assert!((found / proven - 1.0).abs() < 1e-12, "{found} {proven}");
    }
}

/// The force in a spring beside a damper, on a node without mass that moves with the road, is 0 but for rounding.
#[test]
fn what_rounding_leaves_is_no_gain() {
    let system = System::builder()
        .support("road")
        .mass("n", 0.0)
        .spring("road", "n", 39.3)
        .damper("road", "n", 3.7)
        .build()
        .unwrap();
    let ends = [("n", 39.3), ("road", -39.3)];
    let pull = sum(
        "pull",
        &ends.map(|(of, by)| (Quantity::Displacement, of, by)),
    );
    let asked = FrequencyResponse::of(&system).from("road").output(pull);
    assert_eq!(largest(&asked, &system, &[]).0, [None, None]);
}

fn noise(system: &System) -> RandomVibration<'_> {
    let last = format!("m{}", system.len() - 1);
    RandomVibration::of(system)
        .motion("road", Quantity::Velocity, 1e-3)
        .output(sum("ride", &[(Quantity::Acceleration, &last, 1.0)]))
        .output(between("travel", Quantity::Displacement, "road", &last))
}

/// The estimate of a mean square in parts of it, that is within it of the proven one.
fn estimate(noise: &RandomVibration<'_>, name: &str, case: usize) -> f64 {
    let found = noise.mean_square(name, None).unwrap();
    let found = found.unwrap_or_else(|| panic!("{case} {name}: doubles determine it"));
    let proven = noise.solve().unwrap();
    let mut all = proven.outputs().iter().chain(proven.displacement());
    let rms = &all.find(|one| one.name == name).expect("it is asked").rms;
    let (value, _) = rms.finite().expect("it is held");
    let off = (found.value() - value * value).abs();
    assert!(
        off <= found.estimate() + 1e-15 * found.value(),
        "{case} {name}: {off:e}"
    );
    found.estimate() / found.value()
}

#[test]
fn mean_squares_are_the_proven_ones_within_their_estimates() {
    let mut dice = Dice(17);
    for case in 0..30 {
        let n = 2 + case % 5;
        let damping = [0.3, 0.02, 1e-3][case % 3];
        let system = built(&random(&mut dice, n, damping));
        let white = RandomVibration::of(&system).force("m1", 2.0);
        for (noise, name) in [(white, "m0"), (noise(&system), "travel")] {
            assert!(estimate(&noise, name, case) < 1e-11, "{case} {name}");
        }
    }
    // The displacement of a mass wanders with the road.
    let system = built(&random(&mut dice, 2, 0.1));
    assert!(noise(&system).mean_square("m0", None).unwrap().is_none());
}

/// Two equal masses on one that a damper holds, and chains without dampers: what swings between the masses does not decay, though rounding may make it.
#[test]
fn what_does_not_decay_has_no_mean_square() {
    let mut dice = Dice(71);
    for case in 0..40 {
        let [mass, other, spring] = std::array::from_fn(|_| dice.between(1.0, 5.0).round());
        let mut builder = System::builder()
            .mass("m0", mass)
            .mass("m1", other)
            .mass("m2", other)
            .spring(GROUND, "m0", dice.between(1.0, 5.0).round())
            .spring("m0", "m1", spring)
            .spring("m0", "m2", spring);
        if case % 2 == 0 {
            builder = builder.damper(GROUND, "m0", 1.0);
        }
        let system = builder.build().unwrap();
        let noise = RandomVibration::of(&system)
            .force("m2", 1.0)
            .output(sum("ride", &[(Quantity::Acceleration, "m2", 1.0)]));
        for (name, weighting) in [
            ("m1", None),
            ("m2", None),
            ("ride", Some(Weighting::Vertical)),
            ("ride", Some(Weighting::Horizontal)),
        ] {
            let found = noise.mean_square(name, weighting).unwrap();
            let found = found.map(|found| [found.value(), found.estimate()]);
            assert!(found.is_none(), "{case} {name} {weighting:?}: {found:?}");
        }
    }
}

#[test]
fn so_are_those_of_stiff_systems() {
    let mut dice = Dice(29);
    for case in 0..30 {
        let n = 2 + case % 5;
        let mut numbers = random(&mut dice, n, 0.05);
        let times = [1e3, 1e6, 1e9][case % 3];
        numbers[3 * (n - 1) + 1] *= times;
        let system = built(&numbers);
        let white = RandomVibration::of(&system).force("m0", 2.0);
        for (noise, name) in [(white, "middle"), (noise(&system), "ride")] {
            let estimate = estimate(&noise, name, case);
            assert!(
                estimate < 1e-11 || times > 1e6,
                "{case} {name}: {estimate:e}"
            );
        }
    }
}

/// Two masses that nothing holds, with dampers in proportion to them: how fast they part is white noise through μ(r″ + cr′) + kr. And
/// a mass behind one that a damper joins to a road of white displacement, whose mean square is Sc/4m. Where they are as a whole is
/// a root at 0, which rounding makes one that decays.
#[test]
fn mean_squares_of_what_floats_are_those_of_the_closed_form() {
    let mut dice = Dice(1478);
    for case in 0..300 {
        let [m, other] = std::array::from_fn(|_| dice.between(1.0, 64.0).round() / 16.0);
        let [k, inner] = [dice.between(0.1, 10.0), dice.between(0.01, 1.0)];
        let rate = 1.0 / 16.0;
        let masses = || System::builder().mass("a", m).mass("b", other);
        let system = masses().spring("a", "b", k).damper("a", "b", inner);
        let system = system.damper(GROUND, "a", rate * m);
        let system = system.damper(GROUND, "b", rate * other).build().unwrap();
        let driven = RandomVibration::of(&system).force("a", 2.0);
        let driven = driven.output(between("parting", Quantity::Velocity, "b", "a"));
        let carried = masses().support("road").spring("a", "b", k);
        let carried = carried.damper("road", "b", 1e-3 * inner).build().unwrap();
        let carried = RandomVibration::of(&carried).motion("road", Quantity::Displacement, 2.0);
        let parts = 2.0 * m * m * (rate + inner * (1.0 / m + 1.0 / other));
        let rights = [1.0 / parts, 1e-3 * inner / (2.0 * m)];
        for ((noise, name), right) in [(driven, "parting"), (carried, "a")].iter().zip(rights) {
            let Some(found) = noise.mean_square(name, None).unwrap() else {
                continue;
            };
            let off = (found.value() - right).abs();
            let most = found.estimate() + 8.0 * f64::EPSILON * right;
            assert!(off <= most, "{case} {name}: {off:e} of {right:e}, {most:e}");
        }
    }
}

/// S/4ck of a mass that creeps back on a soft spring: its two rates are up to 2·10⁻²² times as large as each other.
#[test]
fn mean_squares_of_what_creeps_are_those_of_the_closed_form() {
    for (power, c) in (0..30).flat_map(|power| [0.01, 0.1, 1.0, 2.0].map(|c| (power, c))) {
        let k = 0.1f64.powi(power);
        let system = in_a_row(&[("m", 1.0)], &[k], &[c]);
        let noise = RandomVibration::of(&system).force("m", 1.0);
        let Some(square) = noise.mean_square("m", None).unwrap() else {
            assert!(power > 20, "{k} {c}");
            continue;
        };
        let error = (square.value() - 0.25 / (c * k)).abs();
        let rounding = 2.0 * f64::EPSILON * square.value();
        assert!(error <= square.estimate() + rounding, "{k} {c}: {square:?}");
    }
}

#[test]
fn derivatives_of_mean_squares_are_those_of_proven_values() {
    let numbers = random(&mut Dice(23), 3, 0.05);
    let system = built(&numbers);
    let found = noise(&system)
        .mean_square("travel", None)
        .unwrap()
        .expect("doubles determine it");
    for at in 0..numbers.len() {
        let along = |numbers: &[f64]| {
            let system = built(numbers);
            found.along(&noise(&system)).unwrap().expect("alike")
        };
        let proven = |numbers: &[f64]| {
            let system = built(numbers);
            let motion = noise(&system).solve().unwrap();
            let (value, _) = motion.outputs()[1].rms.finite().expect("it is held");
            value * value
        };
        let (found, right) = (
            slope_by(1.0 / 128.0, &numbers, at, along),
            slope(&numbers, at, proven),
        );
        let size = found.abs() + right.abs() + proven(&numbers) / numbers[at];
        let off = (found - right).abs();
        assert!(off < 1e-11 * size, "{at}: {found:e} {right:e}");
    }
}

/// A cantilever of so many elements and this rigidity with a mass and a dashpot at its tip, and an absorber of this stiffness there.
fn mast(elements: usize, rigidity: f64, absorber: f64) -> System {
    let beam = beam("mast", elements, [2.0, rigidity, 1.2], CANTILEVER);
    let builder = System::builder().mass("absorber", 0.1).beam(beam);
    let builder = builder.point("tip", [(format!("mast.{elements}.w"), 1.0)], 0.5);
    let builder = builder
        .spring("tip", "absorber", absorber)
        .damper("tip", "absorber", 0.3)
        .damper(GROUND, "tip", 0.5);
    builder.build().expect("a mast")
}

/// Against partial fractions with 40 digits of the roots of the same finite elements.
#[test]
fn mean_squares_of_finite_elements_are_those_of_40_digits() {
    let system = mast(20, 100.0, 10.0);
    fn noise(system: &System) -> RandomVibration<'_> {
        RandomVibration::of(system).force("tip", 1.0)
    }
    let found = noise(&system)
        .mean_square("tip", None)
        .unwrap()
        .expect("it is held");
    let off = (found.value().sqrt() / 0.107_137_440_391_158_97 - 1.0).abs();
    assert!(
        off < 1e-15 && found.estimate() < 1e-14 * found.value(),
        "{off:e}"
    );
    let along = |by: [f64; 2]| {
        found
            .along(&noise(&mast(20, by[0], by[1])))
            .unwrap()
            .expect("alike")
    };
    for (at, right) in [-1.522_584_550_067_093_7e-4, 3.611_977_353_696_341e-4]
        .into_iter()
        .enumerate()
    {
        let slope = slope_by(1.0 / 128.0, &[100.0, 10.0], at, |by| along([by[0], by[1]]));
        assert!((slope / right - 1.0).abs() < 1e-13, "{at}: {slope:e}");
    }
}

/// A force at the tip reaches the absorber through its spring and damper alone, so that its acceleration is finite.
#[test]
fn what_no_inertia_couples_has_a_finite_acceleration() {
    let system = mast(3, 100.0, 10.0);
    let output = sum("ride", &[(Quantity::Acceleration, "absorber", 1.0)]);
    let noise = RandomVibration::of(&system)
        .force("tip", 1.0)
        .output(output);
    assert!(estimate(&noise, "ride", 0) < 1e-11);
    let proven = noise.solve().unwrap();
    let accelerations = proven.acceleration().iter();
    for of in accelerations.filter(|of| of.name != "absorber") {
        assert!(of.rms.finite().is_none(), "{}", of.name);
    }
}

/// W_k and W_d × 1000 at the nominal third octaves from 1 to 80 Hz, as ISO 2631-1:1997 prints them in its table 3. At 10 Hz the filter of W_d
/// gives 202 for the 212 that is printed.
const PRINTED: [[f64; 2]; 20] = [
    [482.0, 1011.0],
    [484.0, 1008.0],
    [494.0, 968.0],
    [531.0, 890.0],
    [631.0, 776.0],
    [804.0, 642.0],
    [967.0, 512.0],
    [1039.0, 409.0],
    [1054.0, 323.0],
    [1036.0, 253.0],
    [988.0, 212.0],
    [902.0, 161.0],
    [768.0, 125.0],
    [636.0, 100.0],
    [513.0, 80.0],
    [405.0, 63.2],
    [314.0, 49.4],
    [246.0, 38.8],
    [186.0, 29.5],
    [132.0, 21.1],
];

/// The nominal third octaves.
const HERTZ: [f64; 20] = [
    1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0, 10.0, 12.5, 16.0, 20.0, 25.0, 31.5, 40.0,
    50.0, 63.0, 80.0,
];

#[test]
fn weightings_are_as_printed() {
    for (n, printed) in PRINTED.iter().enumerate() {
        let hertz = HERTZ[n];
        for (weighting, printed) in [Weighting::Vertical, Weighting::Horizontal]
            .iter()
            .zip(printed)
        {
            let found = 1000.0 * weighting.at(hertz * std::f64::consts::TAU).norm();
            let printed = if *printed == 212.0 { 202.0 } else { *printed };
            let last = if printed < 100.0 { 0.1 } else { 1.0 };
            let off = (found - printed).abs();
            assert!(off < last, "{weighting:?} {hertz}: {found} {printed}");
        }
    }
}

#[test]
fn weighted_mean_squares_agree_with_quadrature() {
    let system = built(&[40.0, 160_000.0, 10.0, 300.0, 16_000.0, 1000.0]);
    let noise = noise(&system);
    for weighting in [Weighting::Vertical, Weighting::Horizontal] {
        let found = noise
            .mean_square("ride", Some(weighting))
            .unwrap()
            .expect("doubles determine it");
        assert!(found.estimate() < 1e-11 * found.value());
        // ∫|W|²|H|²S/ω² dω/2π over ln ω, of a smooth function that vanishes at both ends.
        let (from, to, count) = (1e-5f64.ln(), 1e7f64.ln(), 40_000);
        let asked = FrequencyResponse::of(&system)
            .from("road")
            .quantity(Quantity::Acceleration);
        let transfer = asked.to("m1").transfer().unwrap().expect("it is small");
        let step = (to - from) / f64::from(count);
        let sum: f64 = (0..=count)
            .map(|k| {
                let omega = (from + step * f64::from(k)).exp();
                let value = transfer.value(omega).expect("no pole") * weighting.at(omega);
                value.norm_sqr() / omega * 1e-3
            })
            .sum();
        let right = sum * step / std::f64::consts::TAU;
        assert!(
            (found.value() / right - 1.0).abs() < 1e-9,
            "{} {right}",
            found.value()
        );
    }
}

fn moved(system: &System) -> Response<'_> {
    let last = format!("m{}", system.len() - 1);
    let samples = Samples {
        step: 0.1,
        values: vec![1.0, -2.0, 0.5, 3.0],
        hold: Hold::Zero,
    };
    Response::of(system)
        .from(State::at_rest().displace("m0", 0.1).push(&last, -0.3))
        .load("middle", Step::of(3.0))
        .load(
            "m0",
            Harmonic {
                amplitude: 2.0,
                frequency: 11.0,
                phase: 0.4,
            },
        )
        .load(&last, samples)
        .motion("road", Quantity::Velocity, HalfSine::of(0.2, 0.3))
        .sum("ride", [(Quantity::Acceleration, last.as_str(), 1.0)])
        .every(0.1)
        .until(2.0)
}

fn run(system: &System) -> Trajectory {
    let problem = moved(system).problem().unwrap();
    ResponsePlan::of(&problem).unwrap().run(&problem).unwrap()
}

/// How fast the numbers of a problem change with one of the system.
fn rates(numbers: &[f64], at: usize, asked: fn(&System) -> Response<'_>) -> Vec<f64> {
    let there = |by: f64| {
        let mut numbers = numbers.to_vec();
        numbers[at] *= 1.0 + by;
        asked(&built(&numbers)).problem().unwrap().numbers()
    };
    let both = there(0.5).into_iter().zip(there(-0.5));
    both.map(|(up, down)| (up - down) / numbers[at]).collect()
}

/// A spring is added to another on the diagonal, and alone beside it: both change by the same double, to the last bit.
#[test]
fn numbers_differ_by_what_springs_differ_by() {
    let (here, there) = (0.77, 0.77 * (1.0 + 1.0 / 128.0));
    let system = |between: f64| {
        let builder = System::builder().mass("a", 1.3).mass("b", 1.3);
        let builder = builder.spring(GROUND, "a", 4.1).spring(GROUND, "b", 4.1);
        builder.spring("a", "b", between).build().unwrap()
    };
    let [first, second] = [here, there].map(system);
    let problem = |system| {
        Response::of(system)
            .every(0.5)
            .until(1.0)
            .problem()
            .unwrap()
    };
    let by = problem(&second).numbers_beyond(&problem(&first)).unwrap();
    // M, C and K, each by rows, and nothing in the initial state.
    let step: f64 = there - here;
    assert_eq!(by[8..12], [step, -step, -step, step]);
    assert!(by[..8].iter().chain(&by[12..]).all(|by| *by == 0.0));
    let sums = [here, there].map(|between| 4.1 + between);
    assert_ne!(sums[1] - sums[0], step);
    let one = System::builder().mass("a", 1.0).build().unwrap();
    assert_eq!(problem(&one).numbers_beyond(&problem(&first)), None);
}

#[test]
fn derivatives_of_motions_are_those_of_proven_motions() {
    let numbers = random(&mut Dice(31), 3, 0.03);
    let system = built(&numbers);
    let here = moved(&system).problem().unwrap().to(Precision::Double);
    for at in 0..numbers.len() {
        let rates = rates(&numbers, at, moved);
        let tangent = here.tangent_system(&rates).unwrap();
        let problem = here.tangent(&tangent, &rates);
        let found = ResponsePlan::of(&problem).unwrap().run(&problem).unwrap();
        for k in [1usize, 7, 20] {
            let right = slope(&numbers, at, |numbers| {
                run(&built(numbers)).displacement()[(2, k)]
            });
            let off = found.displacement()[(5, k)] - right;
            assert!(
                off.abs() < 1e-11 * (right.abs() + 0.1 / numbers[at]),
                "{at} {k}: {off:e}"
            );
            let right = slope(&numbers, at, |numbers| run(&built(numbers)).output(0)[k]);
            let off = found.output(0)[k] - right;
            let size = right.abs() + run(&system).output(0)[k].abs() / numbers[at];
            assert!(off.abs() < 1e-10 * size, "{at} {k}: {off:e} {right:e}");
        }
    }
}

/// Pushed, and with a force that goes on.
fn pushed(system: &System) -> Response<'_> {
    let last = format!("m{}", system.len() - 1);
    Response::of(system)
        .from(State::at_rest().push("m0", 1.0))
        .load("middle", Step::of(3.0))
        .motion("road", Quantity::Velocity, HalfSine::of(0.2, 0.3))
        .sum("travel", [(Quantity::Displacement, "m0", 1.0)])
        .sum("ride", [(Quantity::Acceleration, last.as_str(), 1.0)])
        .every(0.1)
        .until(2.0)
}

#[test]
fn derivatives_of_peaks_are_those_of_proven_peaks() {
    for (seed, n) in [(37, 1), (41, 3), (43, 4)] {
        let numbers = random(&mut Dice(seed), n, 0.03);
        let system = built(&numbers);
        let here = pushed(&system).problem().unwrap().to(Precision::Double);
        let motion = ResponsePlan::of(&here).unwrap().run(&here).unwrap();
        let extrema = Extrema::of(&here, &motion).expect("it is followed");
        for output in 0..2 {
            // The proven value at the instant of the peak, which at any other near it is the same.
            let proven = |numbers: &[f64]| {
                let system = built(numbers);
                let problem = pushed(&system).problem().unwrap();
                let motion = ResponsePlan::of(&problem).unwrap().run(&problem).unwrap();
                let extrema = Extrema::of(&problem, &motion).expect("it is followed");
                let time = extrema
                    .output(output)
                    .expect("it is asked for")
                    .largest()
                    .time;
                let motion = ByCertifiedExponential.at(&problem, &[time]).unwrap();
                motion.output(output)[0].abs()
            };
            for at in 0..numbers.len() {
                let found = extrema.slope_of_largest(&here, output, &rates(&numbers, at, pushed));
                let found = found.expect("it is no event");
                let right = slope(&numbers, at, proven);
                let size = right.abs() + proven(&numbers) / numbers[at];
                let off = (found - right).abs();
                assert!(off < 1e-11 * size, "{n} {output} {at}: {found:e} {right:e}");
            }
        }
    }
}

#[test]
fn a_peak_at_an_event_has_no_derivative() {
    let numbers = [2.0, 50.0, 30.0];
    let system = built(&numbers);
    fn jumping(system: &System) -> Response<'_> {
        Response::of(system)
            .load("m0", Step::of(3.0).starting_at(1.0))
            .sum("ride", [(Quantity::Acceleration, "m0", 1.0)])
            .every(0.1)
            .until(2.0)
    }
    let problem = jumping(&system).problem().unwrap();
    let motion = ResponsePlan::of(&problem).unwrap().run(&problem).unwrap();
    let extrema = Extrema::of(&problem, &motion).expect("it is followed");
    let largest = extrema.output(0).expect("it is asked for").largest();
    assert_eq!((largest.time, largest.value), (1.0, 1.5));
    for at in 0..3 {
        let rates = rates(&numbers, at, jumping);
        assert_eq!(extrema.slope_of_largest(&problem, 0, &rates), None);
    }
}
