//! Frequency responses of machines drawn at random, against the same equations solved in fractions.

use eigentone_modes::{Bounds, GROUND, System};
use eigentone_response::{
    Combination, FrequencyResponse, FrequencyValue, Quantity, StateSpace, Sum,
};
use num_bigint::BigInt;
use num_rational::{BigRational, Ratio};
use num_traits::{One, Signed, ToPrimitive, Zero};
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

/// Whole numbers and what they are to be divided by, of numbers whose denominators are powers of two.
fn whole<'a>(values: impl Iterator<Item = &'a BigRational> + Clone) -> (Vec<BigInt>, BigInt) {
    let denominators = values.clone().map(BigRational::denom);
    let common = denominators.max().cloned().unwrap_or_else(BigInt::one);
    let whole = values.map(|value| value.numer() * (&common / value.denom()));
    (whole.collect(), common)
}

/// Real and imaginary part, of whole numbers.
type Whole = [BigInt; 2];

/// a + factor·b, without a common factor looked for.
fn sum(a: &BigRational, b: &BigRational, factor: &BigRational) -> BigRational {
    let over = b.denom() * factor.denom();
    let numerator = a.numer() * &over + factor.numer() * b.numer() * a.denom();
    Ratio::new_raw(numerator, a.denom() * over)
}

fn whole_product(a: &Whole, b: &Whole) -> Whole {
    [&a[0] * &b[0] - &a[1] * &b[1], &a[0] * &b[1] + &a[1] * &b[0]]
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

/// X with Z X = F for the rows of the coordinates, as whole numbers over a common one; `None` where that is singular. Steps
/// divide by the pivot before, without remainder (Bareiss 1968, *Mathematics of Computation* 22).
fn solve(rows: &[Vec<Exact>]) -> Option<(Vec<Whole>, Whole)> {
    let n = rows.len();
    let mut rows: Vec<Vec<Whole>> = rows
        .iter()
        .map(|row| {
            let (whole, _) = whole(row.iter().flatten());
            let parts = whole.chunks(2);
            parts
                .map(|part| [part[0].clone(), part[1].clone()])
                .collect()
        })
        .collect();
    let is_zero = |entry: &Whole| entry.iter().all(Zero::is_zero);
    let mut before = [BigInt::one(), BigInt::zero()];
    for k in 0..n {
        let pivot = (k..n).find(|i| !is_zero(&rows[*i][k]))?;
        rows.swap(k, pivot);
        let leading = rows[k].clone();
        let conjugate = [before[0].clone(), -&before[1]];
        let square = &before[0] * &before[0] + &before[1] * &before[1];
        for (i, row) in rows.iter_mut().enumerate() {
            if i == k {
                continue;
            }
            let factor = row[k].clone();
            for (entry, above) in row.iter_mut().zip(&leading).skip(k) {
                let [a, b] = [
                    whole_product(&leading[k], entry),
                    whole_product(&factor, above),
                ];
                let difference = [&a[0] - &b[0], &a[1] - &b[1]];
                *entry = whole_product(&difference, &conjugate).map(|part| part / &square);
            }
        }
        before.clone_from(&leading[k]);
    }
    let x = rows.into_iter().map(|mut row| row.swap_remove(n));
    Some((x.collect(), before))
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

/// How many frequencies each machine is asked for.
fn frequencies() -> usize {
    let asked = std::env::var("EIGENTONE_FREQUENCIES").ok();
    asked.map_or(5, |asked| asked.parse().expect("a number of frequencies"))
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
        powers in vec(-3.0..6.0f64, frequencies()),
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
        let natural = natural.filter(|size| (1e-100..1e100).contains(size));
        let natural = natural.take(frequencies() * 3 / 5);
        let mut asked_at: Vec<f64> = natural.map(|size| size * near).collect();
        let others = powers.iter().map(|power| 10f64.powf(*power));
        asked_at.extend(others.take(frequencies() - asked_at.len()));
        let answer = asked.at(&asked_at).expect("in range");
        prop_assert_eq!(answer.bounds(), Bounds::Proven);
        let forms = forms(&drawn);
        for (k, &frequency) in asked_at.iter().enumerate() {
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
            let solved = solve(&rows.collect::<Vec<_>>());
            let one = [BigInt::one(), BigInt::zero()];
            let mut x = vec![[BigInt::zero(), BigInt::zero()]; moving];
            let (values, over) = solved.clone().unwrap_or((Vec::new(), one));
            if is_support {
                x[input].clone_from(&over);
            }
            for (&i, value) in own.iter().zip(&values) {
                x[i].clone_from(value);
            }
            // Over `over`, made real, and without a common factor looked for.
            let conjugate = [over[0].clone(), -&over[1]];
            let square = &over[0] * &over[0] + &over[1] * &over[1];
            let motion = |i: usize, order: usize| -> Exact {
                let (form, common) = whole(forms[i].iter());
                let parts = form.iter().zip(&x);
                let sum = parts.fold([BigInt::zero(), BigInt::zero()], |sum, (a, x)| {
                    [&sum[0] + a * &x[0], &sum[1] + a * &x[1]]
                });
                let start = (whole_product(&sum, &conjugate), common * &square);
                let ([re, im], over) = (0..order).fold(start, |([re, im], over), _| {
                    ([-im * omega.numer(), re * omega.numer()], over * omega.denom())
                });
                [Ratio::new_raw(re, over.clone()), Ratio::new_raw(im, over)]
            };
            let moves: Vec<Exact> = (0..places).map(|i| motion(i, order)).collect();
            let all = [0, 1].into_iter().flat_map(|order| (0..places).map(move |i| (i, order)));
            let sizes = all.map(|(i, order)| size(&motion(i, order)));
            let largest = moves.iter().map(size).chain(sizes).fold(0.0, f64::max);
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
                        [0, 1].map(|part| sum(&a[part], &b[part], &factor))
                    }
                    to => {
                        let i = (0..places).find(|i| name(*i) == to).expect("a place");
                        moves[i].clone()
                    }
                };
                let (value, bound) = value.known().expect("it is regular");
                let bound = bound.expect("it is proven");
                let minus = exact(-1.0);
                let off = [sum(&truth[0], &exact(value.re), &minus), sum(&truth[1], &exact(value.im), &minus)];
                prop_assert!(size(&off) <= bound * (1.0 + 1e-12), "{function:?} {k}: {off:?}");
                let enough = 4.0 * f64::EPSILON / 2.0 * size(&truth);
                let nothing = value.norm() == 0.0 && bound <= 1e-28 * largest;
                prop_assert!(bound <= enough || nothing, "{value:e} ± {bound:e} for {:e}, {} at {frequency:e}", size(&truth), function.to());
            }
        }
    }
}

/// A polynomial with rational coefficients, the constant first.
type Rational = Vec<BigRational>;

fn trimmed(mut p: Rational) -> Rational {
    while p.last().is_some_and(Zero::is_zero) {
        p.pop();
    }
    p
}

fn product(a: &Rational, b: &Rational) -> Rational {
    let mut p = vec![BigRational::zero(); (a.len() + b.len()).saturating_sub(1)];
    for (i, a) in a.iter().enumerate() {
        for (j, b) in b.iter().enumerate() {
            p[i + j] += a * b;
        }
    }
    trimmed(p)
}

fn difference(a: &Rational, b: &Rational) -> Rational {
    let mut p = a.clone();
    p.resize(a.len().max(b.len()), BigRational::zero());
    for (p, b) in p.iter_mut().zip(b) {
        *p -= b;
    }
    trimmed(p)
}

/// Quotient and remainder.
fn divided(a: &Rational, b: &Rational) -> (Rational, Rational) {
    let (mut rest, mut quotient) = (a.clone(), Vec::new());
    let lead = b.last().expect("not 0");
    while rest.len() >= b.len() {
        let factor = rest.last().expect("not 0") / lead;
        let start = rest.len() - b.len();
        for (rest, b) in rest[start..].iter_mut().zip(b) {
            *rest -= &factor * b;
        }
        rest.pop();
        quotient.push(factor);
    }
    quotient.reverse();
    (quotient, trimmed(rest))
}

fn derivative(p: &Rational) -> Rational {
    let terms = p.iter().enumerate().skip(1);
    let whole = |k: usize| BigRational::from(BigInt::from(k));
    trimmed(terms.map(|(k, a)| whole(k) * a).collect())
}

fn common(a: &Rational, b: &Rational) -> Rational {
    let (mut a, mut b) = (a.clone(), b.clone());
    while !b.is_empty() {
        let (_, rest) = divided(&a, &b);
        (a, b) = (b, rest);
    }
    a
}

/// How many different roots are positive (Sturm).
fn positive_roots(p: &Rational) -> usize {
    let first = p.iter().position(|a| !a.is_zero()).unwrap_or(0);
    let p = p[first..].to_vec();
    let mut chain = vec![p.clone(), derivative(&p)];
    while let [.., a, b] = chain.as_slice()
        && !b.is_empty()
    {
        let (_, rest) = divided(a, b);
        chain.push(rest.into_iter().map(|a| -a).collect());
    }
    let changes = |sign: &dyn Fn(&Rational) -> Option<bool>| {
        let signs: Vec<bool> = chain.iter().filter_map(sign).collect();
        signs.windows(2).filter(|pair| pair[0] != pair[1]).count()
    };
    let positive = |a: Option<&BigRational>| a.filter(|a| !a.is_zero()).map(Signed::is_positive);
    let at_zero = changes(&|p| positive(p.first()));
    let at_end = changes(&|p| positive(p.last()));
    at_zero - at_end
}

/// The determinant of a matrix of polynomials in iΩ with real coefficients, by its first row.
fn determinant(rows: &[Vec<Rational>]) -> Rational {
    let Some((first, others)) = rows.split_first() else {
        return vec![BigRational::from(BigInt::from(1))];
    };
    let mut sum = Vec::new();
    for (j, entry) in first
        .iter()
        .enumerate()
        .filter(|(_, entry)| !entry.is_empty())
    {
        let minor: Vec<Vec<Rational>> = others
            .iter()
            .map(|row| [&row[..j], &row[j + 1..]].concat())
            .collect();
        let mut term = product(entry, &determinant(&minor));
        if j % 2 == 0 {
            term.iter_mut().for_each(|a| *a = -&*a);
        }
        sum = difference(&sum, &term);
    }
    sum
}

/// |p(iΩ)|² as a polynomial in Ω².
fn square(p: &Rational) -> Rational {
    let reflected: Rational = p
        .iter()
        .enumerate()
        .map(|(k, a)| if k % 2 == 0 { a.clone() } else { -a })
        .collect();
    let even = product(p, &reflected).into_iter().step_by(2).enumerate();
    trimmed(even.map(|(k, a)| if k % 2 == 0 { a } else { -a }).collect())
}

/// How often |p(iΩ)/q(iΩ)| turns at frequencies above 0.
fn turns(p: &Rational, q: &Rational) -> usize {
    let (p, q) = (square(p), square(q));
    let shared = common(&p, &q);
    let [p, q] = [p, q].map(|square| divided(&square, &shared).0);
    let left = product(&derivative(&p), &q);
    positive_roots(&difference(&left, &product(&p, &derivative(&q))))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_peak_is_missing_where_none_is_said_to_be(
        masses in vec(1u8..9, 1..4),
        springs in vec((0..4usize, 0..4usize, 1u8..100), 1..6),
        dampers in vec((0..4usize, 0..4usize, 1u8..20), 0..3),
        [input, output] in [0..3usize, 0..3usize],
        order in 0..3usize,
        only in proptest::option::of(0..3usize),
    ) {
        let n = masses.len();
        let name = |i: usize| if i >= n { GROUND.to_owned() } else { format!("m{i}") };
        let mut builder = System::builder();
        for (i, mass) in masses.iter().enumerate() {
            builder = builder.mass(name(i), (*mass).into());
        }
        let mut matrix = vec![vec![vec![BigRational::zero(); 3]; n]; n];
        let whole = |value: u8, over: u8| BigRational::new(value.into(), over.into());
        for (i, mass) in masses.iter().enumerate() {
            matrix[i][i][2] += whole(*mass, 1);
        }
        let all = springs.iter().map(|element| (element, 0));
        for (&(a, b, value), power) in all.chain(dampers.iter().map(|element| (element, 1))) {
            let [a, b] = [a, b].map(|end| end.min(n));
            if a == b {
                continue;
            }
            builder = match power {
                0 => builder.spring(name(a), name(b), value.into()),
                _ => builder.damper(name(a), name(b), f64::from(value) / 64.0),
            };
            let value = whole(value, if power == 0 { 1 } else { 64 });
            for (i, j, sign) in [(a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)] {
                if i < n && j < n {
                    matrix[i][j][power] += &value * BigRational::from(BigInt::from(sign));
                }
            }
        }
        let Ok(system) = builder.build() else {
            return Ok(());
        };
        for entry in matrix.iter_mut().flatten() {
            *entry = trimmed(std::mem::take(entry));
        }
        let (input, output) = (input % n, output % n);
        let minor: Vec<Vec<Rational>> = (0..n)
            .filter(|i| *i != input)
            .map(|i| (0..n).filter(|j| *j != output).map(|j| matrix[i][j].clone()).collect())
            .collect();
        let mut power = vec![BigRational::zero(); order];
        power.push(whole(1, 1));
        let truth = turns(&product(&power, &determinant(&minor)), &determinant(&matrix));
        let quantities = [Quantity::Displacement, Quantity::Velocity, Quantity::Acceleration];
        let asked = FrequencyResponse::of(&system).from(name(input)).to(name(output));
        // Even a single frequency shows all of them.
        let modes = system.modes().expect("modes");
        let grid = match only {
            Some(_) => vec![1.0],
            None => eigentone_response::peak_grid(&system, &modes, &[]),
        };
        let found = asked.quantity(quantities[order]).features(&grid).expect("features");
        let found = &found[0];
        if found.is_complete() {
            prop_assert_eq!(found.peaks().len() + found.dips().len(), truth, "{:?}", found);
        }
    }
}

/// The columns of M⁻¹ times a real matrix, in fractions.
fn by_masses(mass: &[Vec<BigRational>], of: &[Vec<BigRational>]) -> Option<Vec<Vec<BigRational>>> {
    let n = mass.len();
    let real = |value: &BigRational| [value.clone(), BigRational::zero()];
    let columns = (0..n).map(|j| {
        let rows = (0..n).map(|i| {
            let row = mass[i].iter().map(real);
            row.chain([real(&of[i][j])]).collect()
        });
        let (column, [over, _]) = solve(&rows.collect::<Vec<_>>())?;
        let column = column.into_iter();
        Some(
            column
                .map(|[re, _]| BigRational::new(re, over.clone()))
                .collect(),
        )
    });
    columns.collect()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// A, B, C and D of machines all of whose coordinates have masses, forces and accelerations.
    #[test]
    fn state_space_forms_are_those_of_fractions(mut drawn in machines()) {
        for mass in drawn.masses.iter_mut().filter(|mass| **mass == 0.0) {
            *mass = 0.3;
        }
        let Some(system) = drawn.system() else {
            return Ok(());
        };
        let n = drawn.masses.len();
        let part = |z: &[Vec<Exact>], k: usize| -> Vec<Vec<BigRational>> {
            let row = |row: &Vec<Exact>| row[..n].iter().map(|entry| entry[k].clone()).collect();
            z[..n].iter().map(row).collect()
        };
        let [still, moving] = [0.0, 1.0].map(|omega| stiffness(&drawn, &[], &exact(omega)));
        let (stiffness, damping, rest) = (part(&still, 0), part(&moving, 1), part(&moving, 0));
        let mass: Vec<Vec<BigRational>> = stiffness
            .iter()
            .zip(rest)
            .map(|(k, z)| k.iter().zip(z).map(|(k, z)| k - z).collect())
            .collect();
        let unit = |i: usize| (0..n).map(|j| exact(if i == j { 1.0 } else { 0.0 })).collect();
        let unit: Vec<Vec<BigRational>> = (0..n).map(unit).collect();
        let truths = [&stiffness, &damping, &unit].map(|of| by_masses(&mass, of));
        let [Some(stiff), Some(damped), Some(light)] = truths else {
            return Ok(());
        };
        let names: Vec<String> = (0..n).map(|i| format!("m{i}")).collect();
        let plant = names.iter().fold(StateSpace::of(&system), |plant, name| {
            plant.force(name).output(name, Quantity::Acceleration)
        });
        let Ok(plant) = plant.build() else {
            return Ok(());
        };
        let place = |i: usize, what: &str| {
            let name = format!("m{i} {what}");
            plant.states().iter().position(|state| *state == name)
        };
        let matrices = plant.matrices();
        let mut compared = 0;
        for i in 0..n {
            let row = place(i, "velocity").expect("it has a mass");
            for j in 0..n {
                let to = ["displacement", "velocity"].map(|what| place(j, what).expect("a state"));
                let entries = [
                    (&matrices.a, row, to[0], -&stiff[j][i]),
                    (&matrices.a, row, to[1], -&damped[j][i]),
                    (&matrices.b, row, j, light[j][i].clone()),
                    (&matrices.c, i, to[0], -&stiff[j][i]),
                    (&matrices.c, i, to[1], -&damped[j][i]),
                    (&matrices.d, i, j, light[j][i].clone()),
                ];
                for (matrix, row, column, truth) in entries {
                    let (value, bound) = (matrix.values[(row, column)], matrix.bound[(row, column)]);
                    let off = (&truth - exact(value)).abs();
                    prop_assert!(off <= exact(bound), "{value:e} ± {bound:e}: {off}");
                    let last = value.abs() * 2f64.powi(-53) * 1.001;
                    prop_assert!(bound <= last.max(1e-26 * matrix.values.norm_max()), "{value:e} ± {bound:e}");
                    compared += 1;
                }
            }
        }
        prop_assert_eq!(compared, 6 * n * n);
    }
}
