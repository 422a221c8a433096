//! Parameters from measurements of which they are known.

use eigentone_design::{FitError, fit, fit_with};
use eigentone_modes::{GROUND, Precision, System};

use crate::random::Random;

/// 1/(k − mω² + icω) at each ω, as real and imaginary parts.
fn receptance(p: &[f64], frequencies: &[f64]) -> Vec<f64> {
    let [m, c, k] = [p[0], p[1], p[2]];
    let each = frequencies.iter().flat_map(|w| {
        let (re, im) = (k - m * w * w, c * w);
        let size = re * re + im * im;
        [re / size, -im / size]
    });
    each.collect()
}

#[test]
fn planted_parameters_are_found_to_ten_digits() {
    let truth = [2.0, 0.3, 200.0];
    let frequencies: Vec<f64> = (0..30).map(|k| 6.0 + 0.3 * f64::from(k)).collect();
    let data = receptance(&truth, &frequencies);
    for start in [[2.1, 0.25, 190.0], [2.2, 0.6, 200.0], [1.9, 0.1, 205.0]] {
        let found = fit(&start, false, |p| {
            let model = receptance(p, &frequencies);
            Some(model.iter().zip(&data).map(|(a, b)| a - b).collect())
        });
        let found = found.expect("a fit");
        assert!(
            found.is_settled && found.undetermined.is_empty(),
            "{found:?}"
        );
        for (value, wanted) in found.point.iter().zip(truth) {
            assert!((value / wanted - 1.0).abs() < 1e-11, "{found:?}");
        }
    }
}

/// Springs of a chain from its frequencies and damping ratios.
#[test]
fn a_chain_is_found_from_its_modes() {
    let modes = |p: &[f64]| -> Option<Vec<f64>> {
        let mut builder = System::builder();
        for i in 0..4 {
            builder = builder.mass(format!("m{i}"), 1.0 + 0.5 * f64::from(i));
        }
        let places = [GROUND, "m0", "m1", "m2", "m3"];
        for i in 0..4 {
            builder = builder.spring(places[i], places[i + 1], p[i]);
        }
        let system = builder.damper(GROUND, "m0", p[4]).damper("m2", "m3", 0.4);
        let modes = system.build().ok()?.modes_to(Precision::Double).ok()?;
        let each = modes.iter().flat_map(|mode| {
            let frequency = mode.natural_frequency().radians_per_second();
            [Some(frequency.ln()), mode.damping_ratio()]
        });
        each.collect()
    };
    let truth = [120.0, 80.0, 95.0, 60.0, 0.7];
    let data = modes(&truth).expect("modes");
    let found = fit(&[100.0, 100.0, 80.0, 80.0, 0.5], false, |p| {
        let model = modes(p)?;
        Some(model.iter().zip(&data).map(|(a, b)| a - b).collect())
    });
    let found = found.expect("a fit");
    for (value, wanted) in found.point.iter().zip(truth) {
        assert!((value / wanted - 1.0).abs() < 1e-10, "{found:?}");
    }
}

/// 2000 noisy measurements: the interval has the truth in 95 ± 2 % of them, with the deviation known and not.
#[test]
fn intervals_hold_what_they_say() {
    let truth = [2.0, 0.9, 200.0];
    let frequencies: Vec<f64> = (0..8).map(|k| 8.0 + 0.6 * f64::from(k)).collect();
    let exact = receptance(&truth, &frequencies);
    let deviation = 2e-4;
    for known in [true, false] {
        let mut noise = Random(20_261_123);
        let mut within = [0usize; 3];
        let mut outliers = 0;
        const TIMES: usize = 2000;
        for _ in 0..TIMES {
            let data: Vec<f64> = exact
                .iter()
                .map(|value| value + deviation * noise.normal())
                .collect();
            let found = fit(&[2.2, 0.8, 210.0], known, |p| {
                let model = receptance(p, &frequencies);
                let left = model.iter().zip(&data).map(|(a, b)| a - b);
                Some(
                    left.map(|rest| if known { rest / deviation } else { rest })
                        .collect(),
                )
            });
            let found = found.expect("a fit");
            assert!(found.is_settled);
            outliers += usize::from(found.outlier().is_some());
            for i in 0..3 {
                let reach = found.interval[i].expect("it is determined");
                within[i] += usize::from((found.point[i] - truth[i]).abs() <= reach);
            }
        }
        // One in a thousand, and up to three standard deviations of their number.
        assert!(outliers <= 6, "{known}: {outliers}");
        for count in within {
            let share = count as f64 / TIMES as f64;
            assert!((share - 0.95).abs() <= 0.02, "{known}: {share}");
        }
    }
}

/// One of twenty residuals is far off: with normal errors the largest of twenty stays below 4.06 deviations in 999 of 1000 cases, by
/// erfc(4.06/√2) = 4.9e-5.
#[test]
fn an_outlier_is_named() {
    let known = |off: f64| {
        let found = fit(&[1.0], true, |p| {
            let mut left: Vec<f64> = (0..20)
                .map(|k| p[0] - 1.0 + f64::from(k % 2) - 0.5)
                .collect();
            left[7] = off;
            Some(left)
        });
        found.expect("a fit").outlier()
    };
    assert_eq!(known(4.0), None);
    assert_eq!(known(-4.2), Some((7, 4.2)));
}

/// Frequencies determine only ratios of stiffness and mass.
#[test]
fn what_nothing_determines_is_said() {
    let found = fit(&[3.0, 2.0, 5.0], false, |p| {
        Some(vec![(p[0] / p[1]).sqrt() - 1.0, 0.1, -0.1])
    });
    let found = found.expect("a fit");
    assert_eq!(found.undetermined.len(), 2);
    assert_eq!(found.interval, [None, None, None]);
    let [first, second] = [&found.undetermined[0], &found.undetermined[1]];
    assert_eq!(first, &[0.0, 0.0, 1.0]);
    assert!((found.point[0] / found.point[1] - 1.0).abs() < 1e-12);
    let ratio = second[0] / second[1];
    assert!((ratio - 1.0).abs() < 1e-6 && second[2] == 0.0, "{second:?}");
    assert_eq!(fit(&[], false, |_| None).err(), Some(FitError::Empty));
    let error = fit(&[1.0, 0.0], false, |_| None).err();
    assert_eq!(
        error,
        Some(FitError::Start {
            index: 1,
            value: 0.0
        })
    );
    assert_eq!(fit(&[1.0], false, |_| None).err(), Some(FitError::NoAnswer));
    assert_eq!(
        fit(&[1.0], false, |_| Some(Vec::new())).err(),
        Some(FitError::NoData)
    );
}

/// With derivatives in closed form the same numbers come back, and far fewer models are asked for.
#[test]
fn derivatives_that_are_given_take_the_place_of_differences() {
    let data: Vec<f64> = (0..8).map(|k| 3.0 * (-0.4 * f64::from(k)).exp()).collect();
    let residuals = |p: &[f64]| -> Option<Vec<f64>> {
        let each = data.iter().enumerate();
        Some(
            each.map(|(k, value)| p[0] * (-p[1] * k as f64).exp() - value)
                .collect(),
        )
    };
    let derivatives = |p: &[f64]| -> Option<Vec<Vec<f64>>> {
        let decay = |k: usize| (-p[1] * k as f64).exp();
        let rates = (0..8).map(|k| -p[0] * k as f64 * decay(k));
        Some(vec![(0..8).map(decay).collect(), rates.collect()])
    };
    let start = [2.0, 0.5];
    let given = fit_with(&start, false, residuals, derivatives).unwrap();
    let differences = fit(&start, false, residuals).unwrap();
    for found in [&given, &differences] {
        assert!((found.point[0] - 3.0).abs() < 1e-13 && (found.point[1] - 0.4).abs() < 1e-14);
        assert!(found.is_settled);
    }
    assert!(
        5 * given.evaluations < differences.evaluations,
        "{}",
        given.evaluations
    );
    // What does not fit is passed over.
    let wrong = fit_with(&start, false, residuals, |_| Some(vec![vec![1.0]])).unwrap();
    assert_eq!(wrong.point, differences.point);
}

/// Models end at a border, and the best one of them lies there: it is found, also where it has no derivatives.
#[test]
fn the_best_model_may_lie_at_the_border_of_all_models() {
    // The residuals of 1 alone would take p to −1.
    let found = fit(&[1.0], false, |p| {
        let has_answer = p[0] >= 0.25;
        has_answer.then(|| vec![p[0] + 1.0, 2.0 * (p[0] + 1.0)])
    });
    let found = found.expect("a fit");
    assert!((0.25..0.3).contains(&found.point[0]), "{found:?}");
    assert_eq!(found.residuals[0], found.point[0] + 1.0);
    assert!(found.evaluations > 10);
    // It did not come to rest where no step makes the sum less.
    assert!(!found.is_settled && found.interval == [None], "{found:?}");
    // Below 0.9 there is the first model that is asked for, and none beside it.
    let mut first = None;
    let found = fit(&[1.0], false, |p| {
        let has_answer = p[0] >= 0.9 || *first.get_or_insert(p[0]) == p[0];
        has_answer.then(|| vec![p[0], 2.0 * p[0]])
    });
    let found = found.expect("a fit");
    assert!(found.point[0] < 0.01 && !found.is_settled, "{found:?}");
    assert_eq!(
        (found.residuals[0], &found.interval[..]),
        (found.point[0], &[None][..])
    );
    let start = |start: &[f64]| fit(start, false, |p| Some(p.to_vec())).expect_err("it is refused");
    let named = |error: FitError| matches!(error, FitError::Start { index: 1, .. });
    for wrong in [0.0, f64::NAN, f64::INFINITY] {
        assert!(named(start(&[1.0, wrong])), "{wrong}");
    }
}

/// The second parameter cancels from the last residual, but for rounding.
#[test]
fn what_rounding_leaves_is_no_dependence() {
    let found = fit(&[2.0, 3.0], false, |p| {
        let rest = 0.7 * p[1] + 1e3 - 1e3 - 0.7 * p[1];
        Some(vec![p[0] - 2.5, p[0] - 2.4, rest])
    });
    let found = found.expect("a fit");
    assert_eq!(found.undetermined, [[0.0, 1.0]], "{found:?}");
    assert!(found.interval[0].is_some() && found.interval[1].is_none());
    assert!((found.point[0] - 2.45).abs() < 1e-14 && found.point[1] == 3.0);
}

/// Squares of residuals beyond the doubles.
#[test]
fn residuals_of_any_size_have_a_deviation() {
    let fitted = |unit: f64| {
        let found = fit(&[1.0], false, |p| {
            Some(vec![unit * (p[0] - 2.5), unit * (p[0] - 2.4)])
        });
        found.expect("a fit")
    };
    let (one, large) = (fitted(1.0), fitted(1e300));
    let deviations = (one.deviation.unwrap(), large.deviation.unwrap());
    assert!((deviations.1 / 1e300 / deviations.0 - 1.0).abs() < 1e-12);
    let widths = (one.interval[0].unwrap(), large.interval[0].unwrap());
    assert!((widths.1 / widths.0 - 1.0).abs() < 1e-9, "{widths:?}");
}
