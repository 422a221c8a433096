//! Closed forms in more digits against exponentials computed with 400 digits, in every regime and
//! where formulas cancel.

use std::str::FromStr;
use std::sync::LazyLock;

use approx::assert_relative_eq;
use eigentone_check::{
    Ball, ChainEnds, Damping, ExactMass, ExactMotion, MassSpringDamper, UndampedPair, UniformChain,
};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::ToPrimitive;
use serde_json::Value;

/// What they are right to, in parts of each value; the truths have 40 digits.
const ERROR: f64 = 1e-31;

static TRUTH: LazyLock<Value> =
    LazyLock::new(|| serde_json::from_str(include_str!("closed_forms.json")).expect("valid"));

fn rows(key: &str) -> &'static [Value] {
    TRUTH[key].as_array().expect("a list")
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    let list: Vec<f64> = list(value);
    list.try_into().expect("so many")
}

fn list(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .expect("a list")
        .iter()
        .map(number)
        .collect()
}

/// The value of a decimal number less a double.
fn minus(decimal: &str, value: f64) -> f64 {
    let (mantissa, exponent) = decimal.split_once('e').unwrap_or((decimal, "0"));
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits = BigInt::from_str(&format!("{whole}{fraction}")).expect("digits");
    let exponent = i32::from_str(exponent).expect("whole") - fraction.len() as i32;
    let power = BigRational::from(BigInt::from(10)).pow(exponent);
    let difference = power * digits - BigRational::from_float(value).expect("finite");
    difference.to_f64().expect("finite")
}

#[track_caller]
fn assert_right(found: &Ball, truth: &Value, case: &Value) {
    let truth = truth.as_str().expect("a decimal number");
    let near = found.nearest();
    let off = (found.minus(near) - minus(truth, near)).abs();
    assert!(
        off <= ERROR * near.abs(),
        "{found} is {off:e} off {truth} in {case}"
    );
    assert!(found.radius() <= 1e-33 * near.abs(), "{found} in {case}");
}

#[track_caller]
fn assert_moves(found: &[ExactMotion], truth: &Value, case: &Value) {
    let truth = truth.as_array().expect("a list");
    assert_eq!(found.len(), truth.len());
    for (found, truth) in found.iter().zip(truth) {
        assert_right(&found.displacement, &truth[0], case);
        assert_right(&found.velocity, &truth[1], case);
    }
}

fn exact_mass(row: &Value) -> ExactMass {
    let [m, c, k] = numbers(&row["system"]);
    ExactMass::new(m, c, k).expect("valid")
}

#[test]
fn one_mass_moves_as_its_exponential() {
    for row in rows("masses") {
        let mass = exact_mass(row);
        let t = number(&row["time"]);
        let arguments = list(&row["arguments"]);
        let found = match (row["kind"].as_str().expect("text"), &arguments[..]) {
            ("free", [x0, v0]) => mass.free(*x0, *v0, t),
            ("step", [force]) => mass.step(*force, t),
            ("ramp", [rate]) => mass.ramp(*rate, t),
            ("impulse", [momentum]) => mass.impulse(*momentum, t),
            ("harmonic", [amplitude, omega, phase]) => mass.harmonic(*amplitude, *omega, *phase, t),
            other => panic!("{other:?}"),
        };
        assert_moves(&[found], &row["motion"], row);
    }
}

#[test]
fn every_regime_and_load_is_among_the_truths() {
    let kinds = ["free", "step", "ramp", "impulse", "harmonic"];
    for damping in [
        Damping::Undamped,
        Damping::Underdamped,
        Damping::Critical,
        Damping::Overdamped,
        Damping::Unsupported,
    ] {
        for kind in kinds {
            let has = |row: &Value| row["kind"] == kind && exact_mass(row).damping() == damping;
            assert!(rows("masses").iter().any(has), "{damping:?}, {kind}");
        }
    }
}

#[test]
fn uniform_chains_move_as_their_exponential() {
    for row in rows("chains") {
        let ends = match row["ends"].as_str().expect("text") {
            "both" => ChainEnds::BothGrounded,
            "first" => ChainEnds::FirstGrounded,
            _ => ChainEnds::Free,
        };
        let [m, k] = numbers(&row["system"]);
        let count = row["count"].as_u64().expect("whole") as usize;
        let chain = UniformChain::new(ends, count, m, k).expect("valid");
        let frequencies = row["frequencies"].as_array().expect("a list");
        for (found, truth) in chain.natural_frequencies().iter().zip(frequencies) {
            assert_right(found, truth, row);
        }
        let (x0, v0) = (list(&row["displacements"]), list(&row["velocities"]));
        let found = chain
            .free(&x0, &v0, number(&row["time"]))
            .expect("one entry a mass");
        assert_moves(&found, &row["motion"], row);
        assert!(chain.free(&x0[1..], &v0, 0.0).is_err());
    }
}

#[test]
fn pairs_move_as_their_exponential() {
    for row in rows("pairs") {
        let masses = numbers(&row["masses"]);
        let pair = UndampedPair::new(masses, numbers(&row["springs"])).expect("valid");
        let t = number(&row["time"]);
        for (k, found) in pair.natural_frequencies().iter().enumerate() {
            assert_right(found, &row["frequencies"][k], row);
        }
        assert_moves(&pair.free([1.0, -0.3], [0.0, 0.5], t), &row["free"], row);
        assert_moves(&pair.step([1.0, -2.0], t), &row["step"], row);
    }
}

/// The form in doubles is the nearest double to a few units in the last place of the amplitude.
#[test]
fn doubles_follow_the_form_in_more_digits() {
    for row in rows("masses") {
        let [m, c, k] = numbers(&row["system"]);
        let Ok(doubles) = MassSpringDamper::new(m, c, k) else {
            continue;
        };
        let (exact, t) = (exact_mass(row), number(&row["time"]));
        let pairs = [
            (doubles.free(1.0, 0.0, t), exact.free(1.0, 0.0, t)),
            (doubles.step(1.0, t), exact.step(1.0, t)),
            (doubles.impulse(1.0, t), exact.impulse(1.0, t)),
        ];
        for (found, truth) in pairs {
            let (x, v) = (truth.displacement.nearest(), truth.velocity.nearest());
            let rate = (k / m).sqrt().max(c / m);
            let amplitude = if rate > 0.0 {
                x.abs().max(v.abs() / rate)
            } else {
                x.abs()
            };
            let epsilon = 4.0 * f64::EPSILON * amplitude;
            assert_relative_eq!(
                found.displacement,
                x,
                epsilon = epsilon,
                max_relative = 1e-15
            );
            let epsilon = 4.0 * f64::EPSILON * amplitude * rate;
            assert_relative_eq!(found.velocity, v, epsilon = epsilon, max_relative = 1e-15);
        }
    }
}

#[test]
fn what_is_no_mass_or_spring_is_refused() {
    for (m, c, k) in [
        (0.0, 1.0, 1.0),
        (-1.0, 1.0, 1.0),
        (f64::NAN, 1.0, 1.0),
        (1.0, -1.0, 1.0),
    ] {
        assert!(ExactMass::new(m, c, k).is_err(), "{m}, {c}, {k}");
    }
    assert!(ExactMass::new(1.0, 1.0, f64::INFINITY).is_err());
    let unknown = ExactMass::new(1.0, 1.0, 1.0)
        .expect("valid")
        .step(1.0, f64::NAN);
    assert!(unknown.displacement.nearest().is_nan());
}
