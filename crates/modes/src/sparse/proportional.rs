//! Rayleigh damping couples no shapes: λ² + (α + βω²)λ + ω² = 0 for each.

use eigentone_digits::DoubleDouble;
use num_complex::Complex;

use super::answer::{Answer, NOT_COUNTED, Parts, Root, keep_nearest};
use super::undamped::Undamped;
use crate::modes::Repeats;
use crate::structure::rayleigh::Proportion;

/// Those of Rayleigh damping: γ = α + βω² for each mode by itself.
pub(crate) fn proportional(found: &Undamped, proportion: Proportion) -> Answer {
    let Proportion {
        of_mass: alpha,
        of_stiffness: beta,
    } = proportion;
    let here = found.squares.iter().filter(|s| **s == 0.0).count();
    let rigid = found.facts.rigid.unwrap_or(here);
    let mut roots = Vec::new();
    let mut listed = false;
    for (k, (&square, error)) in found.squares.iter().zip(&found.errors).enumerate() {
        let zeros = vec![0.0; found.shapes.nrows()];
        let shape: Parts = [found.shapes.col(k).iter().copied().collect(), zeros];
        let root = |value: Complex<f64>, error, repeats, roots| Root {
            value,
            error,
            shape: shape.clone(),
            repeats,
            roots,
        };
        let exactly = |count, defective| Repeats::Exactly {
            count,
            defective: Some(defective),
        };
        let alpha_rounded = alpha.to_f64();
        if square == 0.0 && *error == Some(0.0) {
            if alpha_rounded != 0.0 {
                let own = f64::EPSILON * alpha_rounded.abs();
                let own = Some((own, own));
                roots.push(root(
                    Complex::ZERO,
                    Some((0.0, 0.0)),
                    exactly(rigid, false),
                    1,
                ));
                roots.push(root(
                    Complex::from(-alpha_rounded),
                    own,
                    exactly(rigid, false),
                    1,
                ));
            } else if !std::mem::replace(&mut listed, true) {
                let exactly = exactly(2 * rigid, true);
                roots.push(root(Complex::ZERO, Some((0.0, 0.0)), exactly, 2 * here));
            }
            continue;
        }
        for (value, error) in quadratic(alpha, beta, square, *error) {
            roots.push(root(value, error, found.repeats(k), 1));
        }
    }
    let facts = &found.facts;
    let apart = keep_nearest(&mut roots, facts.target, facts.count);
    let beyond =
        |apart| others_lie_beyond(found, [alpha.to_f64(), beta.to_f64()], apart).then_some(());
    let complete = match found.counted {
        None => Err(NOT_COUNTED),
        Some(_) => apart
            .and_then(beyond)
            .ok_or("other modes may have real roots that lie as near"),
    };
    Answer { roots, complete }
}

/// A root, and how far it and its real part may be off.
type Scalar = (Complex<f64>, Option<(f64, f64)>);

/// The roots of λ² + (α + βω²)λ + ω² = 0 with Im λ ≥ 0, given ω² and its error.
fn quadratic(
    alpha: DoubleDouble,
    beta: DoubleDouble,
    square: f64,
    error: Option<f64>,
) -> Vec<Scalar> {
    let half = (alpha + beta * square) * 0.5;
    let rest = half * half - DoubleDouble::from(square);
    let size = rest.abs().to_f64();
    let root = rest.abs().sqrt();
    let (half_rounded, beta) = (half.to_f64().abs(), beta.to_f64().abs());
    let unit = f64::EPSILON;
    // By how much γ/2 and the square of the root below it may be off.
    let of_half = |error: f64| beta / 2.0 * error;
    let of_root = |error: f64| {
        let of_rest = (half_rounded * beta + 1.0) * error + 2.0 * of_half(error) * of_half(error);
        (of_rest <= 0.25 * size).then(|| of_rest / root.to_f64())
    };
    if rest.to_f64() < 0.0 {
        let value = Complex::new(-half.to_f64(), root.to_f64());
        let error = error.and_then(|error| {
            let (real, other) = (of_half(error), of_root(error)?);
            let real = real + unit * half_rounded;
            Some((real + other + unit * value.norm(), real))
        });
        return vec![(value, error)];
    }
    let large = match half.to_f64() < 0.0 {
        true => root - half,
        false => -(half + root),
    };
    let small = DoubleDouble::from(square) / large;
    let both = [small.to_f64(), large.to_f64()];
    both.into_iter()
        .enumerate()
        .map(|(k, value)| {
            let error = error.and_then(|error| {
                let of_large = of_half(error) + of_root(error)?;
                let part = of_large / both[1].abs();
                let own = match k {
                    0 => value.abs() * (2.0 * part + error / square.abs()),
                    _ => of_large,
                };
                let own = own + unit * value.abs();
                (part <= 0.1).then_some((own, own))
            });
            (Complex::from(value), error)
        })
        .collect()
}

/// Whether no root of a mode that was not found has a natural frequency so near to the target.
fn others_lie_beyond(found: &Undamped, [alpha, beta]: [f64; 2], apart: f64) -> bool {
    const ROOM: f64 = 1e-9;
    let Some([low, high]) = found.counted else {
        return false;
    };
    if alpha < 0.0 || beta < 0.0 || !found.facts.semidefinite {
        return false;
    }
    let target = found.facts.target;
    let (low, high) = (low.max(0.0).sqrt(), high.max(0.0).sqrt());
    let [nearest, farthest] = [target - apart, (target + apart) * (1.0 + ROOM)];
    // Complex roots have |λ| = ω; real ones are there where α + βω² ≥ 2ω, and the smaller of two is at least
    // ω²/(α + βω²), which rises with ω.
    let least = |omega: f64| omega * omega / (alpha + beta * omega * omega);
    let slow = alpha / (1.0 + (1.0 - alpha * beta).max(0.0).sqrt());
    let fast = match beta > 0.0 {
        true if alpha * beta < 1.0 => (1.0 + (1.0 - alpha * beta).sqrt()) / beta,
        true => 0.0,
        false => f64::INFINITY,
    };
    let beyond = match fast.is_finite() || high <= slow {
        true if high <= slow => high.min(least(high)),
        true => high.min(least(high.max(fast))),
        false => high,
    };
    // Below, the larger of two real roots is no more than α + βω² where there are some.
    let slower = match fast < low {
        true => low,
        false => low.min(slow),
    };
    let larger = match slower > 0.0 {
        true => alpha + beta * slower * slower,
        false => 0.0,
    };
    farthest <= beyond && (low == 0.0 || larger < nearest * (1.0 - ROOM))
}
