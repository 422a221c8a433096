//! Response spectra against 25-digit truths (truth.py; the closed form of half-sine shocks, shock.py), laws, and closed forms.

use eigentone_modes::Precision;
use eigentone_response::{
    BaseAcceleration, Baseline, HalfSine, Hold, LoadError, ResponseSpectrum, Samples, SpectralPeak,
    SpectrumError, Versine,
};

const RECORD: [f64; 16] = [
    0.0, 0.5, -1.25, 2.0, 0.75, -3.0, 1.5, 0.25, -0.5, 2.5, -1.0, 0.125, 0.0, -0.75, 0.5, 0.0,
];
const STEP: f64 = 0.02;
const CERTIFIED: Precision = Precision::Certified {
    tolerance: f64::EPSILON,
};

fn record(hold: Hold) -> Samples {
    let values = RECORD.to_vec();
    let step = STEP;
    Samples { step, values, hold }
}

fn base(name: &str) -> BaseAcceleration {
    match name {
        "record-zero" => record(Hold::Zero).into(),
        "record-first" => record(Hold::First).into(),
        _ => HalfSine::of(9.0, 0.011).into(),
    }
}

/// Frequency, ratio, displacement and absolute acceleration: the nearest doubles, within 1.2e-16.
fn truth() -> impl Iterator<Item = (&'static str, [f64; 4])> {
    let lines = include_str!("truth.txt").lines();
    lines.chain(include_str!("shock.txt").lines()).map(|line| {
        let (name, numbers) = line.split_once(' ').expect("a name");
        let mut numbers = numbers
            .split(' ')
            .map(|text| text.parse().expect("a number"));
        (name, [0; 4].map(|_| numbers.next().expect("four of them")))
    })
}

fn holds(what: &str, peak: SpectralPeak, truth: f64, idle: f64) {
    let off = (peak.value - truth).abs();
    let rounding = 1.2e-16 * truth;
    assert!(off <= peak.bound + rounding, "{what}: {peak:?} {truth:e}");
    assert!(peak.bound <= idle * truth, "{what}: {peak:?} is idle");
}

#[test]
fn spectra_are_right_to_their_last_digits() {
    let mut count = 0;
    for (name, [frequency, ratio, displacement, acceleration]) in truth() {
        for (precision, idle) in [(CERTIFIED, 1.2e-16), (Precision::Double, 1e-8)] {
            let spectrum = ResponseSpectrum::of(base(name), ratio, &[frequency], precision);
            let spectrum = spectrum.expect("a spectrum");
            let what = format!("{name} {frequency} Hz ζ = {ratio} {precision:?}");
            holds(&what, spectrum.displacement()[0], displacement, idle);
            holds(&what, spectrum.acceleration()[0], acceleration, idle);
            let rate = 2.0 * std::f64::consts::PI * frequency;
            let velocity = spectrum.pseudo_velocity()[0];
            let off = (velocity.value / (rate * displacement) - 1.0).abs();
            assert!(
                off <= idle + 1e-15 && velocity.bound <= idle * velocity.value,
                "{what}"
            );
            let off = velocity.value * rate - spectrum.pseudo_acceleration()[0].value;
            assert!(off.abs() <= 1e-9 * velocity.value * rate, "{what}");
        }
        count += 1;
    }
    assert!(count >= 470, "{count}");
}

/// The times are those of the peaks: half-sine shocks of undamped systems have them in closed form.
#[test]
fn peaks_come_when_they_are_said_to() {
    let duration = 0.011;
    for product in [0.9, 1.3, 2.2, 5.1] {
        let frequency = product / duration;
        let base = HalfSine::of(9.0, duration).starting_at(0.25);
        let spectrum = ResponseSpectrum::of(base, 0.0, &[frequency], CERTIFIED);
        let peak = spectrum.expect("a spectrum").displacement()[0];
        // y′ vanishes where cos ω_p t = cos ωt: at 2πn/(ω + ω_p).
        let turns = (peak.time - 0.25) * (frequency + 0.5 / duration);
        assert!((turns - turns.round()).abs() < 1e-12, "{product}: {turns}");
        let bound = peak.time_bound.expect("it turns there");
        let truth = 0.25 + turns.round() / (frequency + 0.5 / duration);
        // The formula in doubles is off by itself.
        let off = (peak.time - truth).abs();
        assert!(off <= bound + 1e-16, "{peak:?} {truth}");
        assert!(bound < 1e-14, "{bound:e}");
    }
}

/// Of damped systems most peaks have times, doubles ones that lie within their bounds of the others.
#[test]
fn times_of_both_precisions_agree() {
    let (mut known, mut all) = (0, 0);
    // Without damping the same value may come again.
    for (name, [frequency, ratio, ..]) in truth().filter(|(_, row)| row[1] > 0.0) {
        let [certified, doubles] = [CERTIFIED, Precision::Double].map(|precision| {
            let spectrum = ResponseSpectrum::of(base(name), ratio, &[frequency], precision);
            spectrum.expect("a spectrum").displacement()[0]
        });
        all += 1;
        if let (Some(a), Some(b)) = (certified.time_bound, doubles.time_bound) {
            let off = (certified.time - doubles.time).abs();
            assert!(
                off <= a + b,
                "{name} {frequency} {ratio}: {certified:?} {doubles:?}"
            );
            assert!(a <= 1e-10, "{certified:?}");
            known += 1;
        }
    }
    assert!(known > all / 2, "{known} of {all}");
}

/// Versines, and the same by many straight lines: nearer as the lines grow shorter.
#[test]
fn pulses_are_what_their_samples_come_to() {
    let exact = ResponseSpectrum::of(Versine::of(2.0, 0.5), 0.1, &[0.7, 3.0, 9.0], CERTIFIED);
    let exact = exact.expect("a spectrum");
    let error = |count: usize| {
        let turn = |k: usize| 2.0 * std::f64::consts::PI * k as f64 / count as f64;
        let values = (0..=count).map(|k| 1.0 - turn(k).cos()).collect();
        let step = 0.5 / count as f64;
        let hold = Hold::First;
        let samples = Samples { step, values, hold };
        let near = ResponseSpectrum::of(samples, 0.1, &[0.7, 3.0, 9.0], CERTIFIED);
        let near = near.expect("a spectrum");
        let pairs = near.displacement().iter().zip(exact.displacement());
        pairs
            .map(|(a, b)| (a.value / b.value - 1.0).abs())
            .fold(0.0, f64::max)
    };
    let (coarse, fine) = (error(100), error(200));
    assert!((3.9..4.1).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
}

/// Linear in the base, and in its time.
#[test]
fn units_do_not_matter() {
    let of = |factor: f64, stretch: f64| {
        let mut samples = record(Hold::First);
        samples.values.iter_mut().for_each(|value| *value *= factor);
        samples.step *= stretch;
        let frequencies = [0.5 / stretch, 8.0 / stretch];
        ResponseSpectrum::of(samples, 0.05, &frequencies, CERTIFIED).expect("a spectrum")
    };
    let (one, other) = (of(1.0, 1.0), of(-1024.0, 0.25));
    for (a, b) in one.displacement().iter().zip(other.displacement()) {
        assert_eq!(a.value * 64.0, b.value);
        assert!((a.time * 0.25 - b.time).abs() < 1e-9);
    }
}

/// Nor do units near the ends of the range of doubles.
#[test]
fn units_at_the_ends_of_doubles_do_not_matter() {
    let of = |values: &[f64], factor: f64, ratio: f64| {
        let values = values.iter().map(|value| value * factor).collect();
        let (step, hold) = (5.0, Hold::Zero);
        let samples = Samples { step, values, hold };
        let frequencies = [0.02, 0.3];
        ResponseSpectrum::of(samples, ratio, &frequencies, CERTIFIED).expect("a spectrum")
    };
    for values in [&RECORD[..], &[1.0, -1.0, -1.0]] {
        for ratio in [0.0, 0.05] {
            let one = of(values, 1.0, ratio);
            for power in [-800, -660, -500, 500, 660, 800] {
                let factor = f64::powi(2.0, power);
                let other = of(values, factor, ratio);
                for (a, b) in one.displacement().iter().zip(other.displacement()) {
                    let off = (b.value - a.value * factor).abs();
                    assert!(off <= a.bound * factor + b.bound, "2^{power}: {a:?} {b:?}");
                }
            }
        }
    }
}

/// What is very stiff follows the base; what is very soft stays where it is.
#[test]
fn the_ends_of_the_spectrum() {
    let spectrum = |hold, frequency| {
        let spectrum = ResponseSpectrum::of(record(hold), 0.05, &[frequency], CERTIFIED);
        spectrum.expect("a spectrum")
    };
    let stiff = spectrum(Hold::First, 1e6);
    assert!((stiff.acceleration()[0].value - 3.0).abs() < 1e-4);
    assert!((stiff.acceleration()[0].time - 5.0 * STEP).abs() < 1e-6);
    let soft = spectrum(Hold::First, 1e-7).displacement()[0];
    let baseline = Baseline::of(&record(Hold::First)).expect("a record");
    // It swings about what the base runs away with, v/ω e^(−ζ arccos ζ/√(1 − ζ²)).
    let reach = baseline.velocity.abs() / (2e-7 * std::f64::consts::PI);
    let off = (soft.value / reach - 0.926_69).abs();
    assert!(off < 1e-5, "{soft:?} {reach}");
}

#[test]
fn a_base_at_rest_moves_nothing() {
    for values in [vec![0.0; 5], vec![1.0]] {
        let (step, hold) = (0.1, Hold::First);
        let spectrum = Samples { step, values, hold };
        let spectrum = ResponseSpectrum::of(spectrum, 0.05, &[1.0], CERTIFIED);
        let peak = spectrum.expect("a spectrum").displacement()[0];
        assert_eq!((peak.value, peak.time), (0.0, 0.0));
        assert!(peak.bound < 1e-28);
    }
}

#[test]
fn a_baseline_beyond_the_doubles_is_refused() {
    let of = |size: f64| {
        let (step, values, hold) = (STEP, vec![size, size, size], Hold::First);
        Baseline::of(&Samples { step, values, hold })
    };
    let large = of(1e300).expect("a baseline");
    assert!((large.velocity / (2e300 * STEP) - 1.0).abs() < 1e-15);
    assert_eq!(of(1.5e308), Err(SpectrumError::BaseRange));
}

#[test]
fn a_baseline_is_summed() {
    let baseline = Baseline::of(&record(Hold::Zero)).expect("a record");
    let sum: f64 = RECORD.iter().sum();
    assert_eq!((baseline.peak, baseline.peak_time), (3.0, 0.1));
    assert!((baseline.velocity - sum * STEP).abs() < 1e-16);
    assert!((baseline.mean - sum / 16.0).abs() < 1e-16);
    assert_eq!(baseline.duration, 16.0 * STEP);
    let of_step = |k: usize| STEP * STEP * (15.5 - k as f64) * RECORD[k];
    let displacement: f64 = (0..16).map(of_step).sum();
    assert!((baseline.displacement - displacement).abs() < 1e-16);
}

#[test]
fn what_cannot_be_is_refused() {
    let of = |base: BaseAcceleration, ratio, frequency| {
        ResponseSpectrum::of(base, ratio, &[1.0, frequency], CERTIFIED).map(drop)
    };
    let good = || BaseAcceleration::from(record(Hold::First));
    for frequency in [0.0, -1.0, f64::INFINITY] {
        let index = 1;
        let refusal = Err(SpectrumError::Frequency { index, frequency });
        assert_eq!(of(good(), 0.05, frequency), refusal);
    }
    let ratio = -0.1;
    assert_eq!(of(good(), ratio, 1.0), Err(SpectrumError::Ratio { ratio }));
    let mut empty = record(Hold::Zero);
    empty.values.clear();
    let refusal = Err(SpectrumError::Base(LoadError::NoSamples));
    assert_eq!(of(empty.into(), 0.05, 1.0), refusal);
    let mut still = record(Hold::Zero);
    still.step = 0.0;
    let refusal = Err(SpectrumError::Base(LoadError::SampleStep { step: 0.0 }));
    assert_eq!(of(still.into(), 0.05, 1.0), refusal);
    let frequency = 1e-200;
    let refusal = Err(SpectrumError::OutOfRange { frequency });
    assert_eq!(of(good(), 0.05, frequency), refusal);
    let mut large = record(Hold::Zero);
    large.values[3] = 1e308;
    assert!(matches!(
        of(large.into(), 0.05, 1e-3),
        Err(SpectrumError::OutOfRange { .. })
    ));
}

/// Of a damping ratio of 1e5 doubles leave no six digits, and more are taken. The truth by mpmath with 60 digits, straight piece by straight
/// piece from the roots of λ² + 2ζωλ + ω² = 0, ω = 2π, to where y′ = 0, 5e-7 s after the third sample.
#[test]
fn where_doubles_leave_nothing_more_digits_are_taken() {
    const TRUTH: f64 = 7.957_722_154_626_83e-8;
    let record = Samples {
        step: 0.1,
        values: vec![0.0, 1.0, 0.0, -1.0, 0.0],
        hold: Hold::First,
    };
    let found = ResponseSpectrum::of(record, 1e5, &[1.0], Precision::Double).expect("known");
    let peak = found.displacement()[0];
    let off = (peak.value - TRUTH).abs();
    assert!(off <= peak.bound + 1e-15 * TRUTH, "{peak:?}");
    assert!(peak.bound <= 1e-9 * TRUTH, "{peak:?}");
}

/// A slow pulse that lasts ten million periods: where the largest motion is not found there is no value.
#[test]
fn values_of_which_nothing_is_known_are_not_given() {
    for precision in [Precision::Double, CERTIFIED] {
        let slow = HalfSine::of(1.0, 1e7);
        let found = ResponseSpectrum::of(slow, 0.0, &[1.0], precision);
        let (frequency, interval) = (1.0, 1e7);
        let refusal = SpectrumError::Undecided {
            frequency,
            interval,
        };
        assert_eq!(found, Err(refusal));
        // A base that rests is known.
        let still = HalfSine::of(0.0, 1e3);
        let found = ResponseSpectrum::of(still, 0.0, &[1.0], precision).expect("it rests");
        assert_eq!(found.displacement()[0].value, 0.0);
    }
}

/// Steady accelerations with samples 1 s apart, of a damping ratio of 1e4 and less: the largest displacement comes at the end of each,
/// the largest acceleration within a thousandth of a second of its beginning. The truth by mpmath with 50 digits, from the roots of
/// λ² + 2ζωλ + ω² = 0.
#[test]
fn steady_accelerations_of_overdamped_systems_are_known() {
    const TRUTH: [(f64, f64, f64, f64); 5] = [
        (
            0.1,
            1e4,
            0.000_318_289_880_670_026_3,
            1.000_000_002_499_999_8,
        ),
        (
            2.0,
            1e4,
            1.589_551_085_558_396_2e-5,
            1.000_000_002_499_999_8,
        ),
        (50.0, 1e4, 6.170_321_506_546_961e-7, 1.000_000_002_499_999_8),
        (1.0, 30.0, 0.008667794232946029, 1.000_276_669_724_209),
        (1.0, 2.0, 0.025_297_838_874_021_88, 1.047_768_732_505_620_2),
    ];
    let record = Samples {
        step: 1.0,
        values: vec![1.0; 5],
        hold: Hold::First,
    };
    for (frequency, ratio, displacement, acceleration) in TRUTH {
        for precision in [Precision::Double, CERTIFIED] {
            let found = ResponseSpectrum::of(record.clone(), ratio, &[frequency], precision);
            let found = found.expect("known");
            let peaks = [found.displacement()[0], found.acceleration()[0]];
            for (peak, truth) in peaks.into_iter().zip([displacement, acceleration]) {
                let off = (peak.value - truth).abs();
                assert!(off <= peak.bound + 2e-16 * truth, "{peak:?} {truth}");
                assert!(peak.bound <= 1e-6 * truth, "{peak:?}");
            }
        }
    }
}
