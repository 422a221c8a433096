//! Frequency responses of machines drawn at random, against the same equations solved in fractions.

use eigentone_modes::Bounds;
use eigentone_response::{Combination, FrequencyResponse, FrequencyValue, Quantity, Sum};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};
use proptest::collection::vec;
use proptest::prelude::*;

use super::machines::{Drawn, machines};

/// Real and imaginary part.
type Exact = [BigRational; 2];

fn exact(value: f64) -> BigRational {
    BigRational::from_float(value).expect("it is finite")
}

fn zero() -> Exact {
    [BigRational::zero(), BigRational::zero()]
}

fn times(a: &Exact, b: &Exact) -> Exact {
    [&a[0] * &b[0] - &a[1] * &b[1], &a[0] * &b[1] + &a[1] * &b[0]]
}

fn over(a: &Exact, b: &Exact) -> Exact {
    let size = &b[0] * &b[0] + &b[1] * &b[1];
    let [re, im] = times(a, &[b[0].clone(), -b[1].clone()]);
    [re / &size, im / size]
}

/// The displacements of all places by coordinates and supports; the last is the ground.
fn forms(drawn: &Drawn) -> Vec<Vec<BigRational>> {
    let moving = drawn.masses.len() + drawn.supports;
    let unit = |i: usize| {
        let entry = |j: usize| if i == j { 1.0 } else { 0.0 };
        (0..moving).map(|j| exact(entry(j))).collect::<Vec<_>>()
    };
    let mut forms: Vec<Vec<BigRational>> = (0..moving).map(unit).collect();
    for (moves, _) in &drawn.points {
        let mut form = vec![BigRational::zero(); moving];
        for (i, factor) in moves {
            form[i % moving] += exact(*factor);
        }
        forms.push(form);
    }
    forms.push(vec![BigRational::zero(); moving]);
    forms
}

/// The dynamic stiffness over coordinates and supports.
fn stiffness(drawn: &Drawn, losses: &[f64], omega: &BigRational) -> Vec<Vec<Exact>> {
    let forms = forms(drawn);
    let moving = drawn.masses.len() + drawn.supports;
    let mut z = vec![vec![zero(); moving]; moving];
    let mut add = |form: &[BigRational], value: &Exact| {
        for i in 0..moving {
            for j in 0..moving {
                let product = &form[i] * &form[j];
                z[i][j][0] += &product * &value[0];
                z[i][j][1] += &product * &value[1];
            }
        }
    };
    let inertia = |mass: f64| [-(exact(mass) * omega * omega), BigRational::zero()];
    for (i, mass) in drawn.masses.iter().enumerate() {
        add(&forms[i], &inertia(*mass));
    }
    for (k, (_, mass)) in drawn.points.iter().enumerate() {
        add(&forms[moving + k], &inertia(*mass));
    }
    let mut springs = 0;
    for (is_spring, a, b, coefficient) in &drawn.elements {
        let [a, b] = [a, b].map(|i| i % forms.len());
        if a == b {
            continue;
        }
        let form: Vec<BigRational> = (0..moving).map(|i| &forms[b][i] - &forms[a][i]).collect();
        let coefficient = exact(*coefficient);
        let value = match is_spring {
            true => {
                let loss = losses.get(springs).copied().unwrap_or(0.0);
                springs += 1;
                [coefficient.clone(), coefficient * exact(loss)]
            }
            false => [BigRational::zero(), coefficient * omega],
        };
        add(&form, &value);
    }
    z
}

/// X with Z X = F for the rows of the coordinates; `None` where that is singular.
fn solve(mut rows: Vec<Vec<Exact>>, n: usize) -> Option<Vec<Exact>> {
    for k in 0..n {
        let is_zero = |entry: &Exact| entry[0].is_zero() && entry[1].is_zero();
        let pivot = (k..n).find(|i| !is_zero(&rows[*i][k]))?;
        rows.swap(k, pivot);
        let leading = rows[k].clone();
        for (i, row) in rows.iter_mut().enumerate() {
            if i == k || is_zero(&row[k]) {
                continue;
            }
            let factor = over(&row[k], &leading[k]);
            for (entry, above) in row.iter_mut().zip(&leading).skip(k) {
                let [re, im] = times(&factor, above);
                entry[0] -= re;
                entry[1] -= im;
            }
        }
    }
    Some((0..n).map(|i| over(&rows[i][n], &rows[i][i])).collect())
}

/// (iΩ)^order.
fn power(omega: &BigRational, order: usize) -> Exact {
    let unit = [BigRational::zero(), omega.clone()];
    let one = [BigRational::from(BigInt::from(1)), BigRational::zero()];
    (0..order).fold(one, |product, _| times(&product, &unit))
}

/// A size, rounded upwards.
fn size(value: &Exact) -> f64 {
    let parts = value
        .each_ref()
        .map(|part| part.to_f64().expect("it is in range").abs());
    parts[0].hypot(parts[1])
}

/// The coordinates that those of the form are joined to.
fn joined(z: &[Vec<Exact>], n: usize, from: &[BigRational], right: &[Exact]) -> Vec<bool> {
    let mut joined: Vec<bool> = (0..n)
        .map(|i| !from[i].is_zero() || !right[i][0].is_zero() || !right[i][1].is_zero())
        .collect();
    for _ in 0..n {
        for i in 0..n {
            for j in 0..n {
                if joined[j] && (!z[i][j][0].is_zero() || !z[i][j][1].is_zero()) {
                    joined[i] = true;
                }
            }
        }
    }
    joined
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        cases: ProptestConfig::default().cases / 8,
        ..ProptestConfig::default()
    })]

    #[test]
    fn frequency_responses_are_those_of_fractions(
        drawn in machines(),
        losses in prop_oneof![Just(Vec::new()), vec(prop_oneof![Just(0.0), 0.001..0.5f64], 16)],
        input in 0..16usize,
        order in 0..3usize,
        near in prop_oneof![Just(1.0), Just(1.0 + 1e-13), 0.5..2.0f64],
        powers in vec(-3.0..6.0f64, 2),
    ) {
        let Some(system) = drawn.system() else {
            return Ok(());
        };
        let (n, moving) = (drawn.masses.len(), drawn.masses.len() + drawn.supports);
        let places = moving + drawn.points.len();
        let name = |i: usize| match i {
            i if i < n => format!("m{i}"),
            i if i < moving => format!("s{}", i - n),
            i => format!("p{}", i - moving),
        };
        let springs = system.elements(eigentone_modes::ElementKind::Spring).len();
        let losses: Vec<f64> = losses.into_iter().take(springs).collect();
        let losses = if losses.len() < springs { Vec::new() } else { losses };
        let input = input % places;
        let quantities = [Quantity::Displacement, Quantity::Velocity, Quantity::Acceleration];
        let mut asked = FrequencyResponse::of(&system)
            .from(name(input))
            .quantity(quantities[order])
            .loss_factors(losses.clone())
            .output(Combination {
                name: "sum".to_owned(),
                of: Sum::Motions(vec![
                    (Quantity::Displacement, name(0), 1.0),
                    (Quantity::Velocity, name(places - 1), -0.1),
                ]),
            });
        for i in 0..places {
            asked = asked.to(name(i));
        }
        // Beside a natural frequency, and anywhere.
        let modes = system.modes_to(eigentone_modes::Precision::Double);
        let natural = modes.iter().flat_map(|modes| modes.iter());
        let natural = natural.map(|mode| mode.eigenvalue().value.norm());
        let natural = natural.filter(|size| (1e-100..1e100).contains(size)).take(3);
        let mut frequencies: Vec<f64> = natural.map(|size| size * near).collect();
        frequencies.extend(powers.iter().map(|power| 10f64.powf(*power)));
        let answer = asked.at(&frequencies).expect("in range");
        prop_assert_eq!(answer.bounds(), Bounds::Proven);
        let forms = forms(&drawn);
        for (k, &frequency) in frequencies.iter().enumerate() {
            let omega = exact(frequency);
            let z = stiffness(&drawn, &losses, &omega);
            let is_support = (n..moving).contains(&input);
            let right: Vec<Exact> = (0..n)
                .map(|i| match is_support {
                    true => z[i][input].each_ref().map(|part| -part),
                    false => [forms[input][i].clone(), BigRational::zero()],
                })
                .collect();
            let none = vec![BigRational::zero(); moving];
            let reached = joined(&z, n, &none, &right);
            let own: Vec<usize> = (0..n).filter(|i| reached[*i]).collect();
            let rows = own.iter().map(|&i| {
                let left = own.iter().map(|&j| z[i][j].clone());
                left.chain([right[i].clone()]).collect()
            });
            let solved = solve(rows.collect(), own.len());
            let mut x = vec![zero(); moving];
            if is_support {
                x[input][0] = exact(1.0);
            }
            for (&i, value) in own.iter().zip(solved.iter().flatten()) {
                x[i].clone_from(value);
            }
            let motion = |i: usize, order: usize| {
                let parts = forms[i].iter().zip(&x);
                let sum = parts.fold(zero(), |sum, (a, x)| {
                    [&sum[0] + a * &x[0], &sum[1] + a * &x[1]]
                });
                times(&sum, &power(&omega, order))
            };
            for function in answer.functions() {
                let value = function.values()[k];
                if solved.is_none() {
                    prop_assert_eq!(value, FrequencyValue::Pole);
                    continue;
                }
                let truth = match function.to() {
                    "sum" => {
                        let [a, b] = [motion(0, 0), motion(places - 1, 1)];
                        let factor = exact(-0.1);
                        [&a[0] + &factor * &b[0], &a[1] + &factor * &b[1]]
                    }
                    to => {
                        let i = (0..places).find(|i| name(*i) == to).expect("a place");
                        motion(i, order)
                    }
                };
                let (value, bound) = value.known().expect("it is regular");
                let bound = bound.expect("it is proven");
                let off = [&truth[0] - exact(value.re), &truth[1] - exact(value.im)];
                let off = [off[0].abs(), off[1].abs()];
                prop_assert!(size(&off) <= bound * (1.0 + 1e-12), "{function:?} {k}: {off:?}");
                let largest = (0..places).map(|i| size(&motion(i, order))).fold(0.0, f64::max);
                let enough = 4.0 * f64::EPSILON / 2.0 * size(&truth);
                prop_assert!(bound <= enough || bound <= 1e-28 * largest.max(size(&x[0])), "{bound:e} for {truth:?}");
            }
        }
    }
}
