//! `expm` at the ends of size, range and normality.

use std::cmp::Ordering;

use eigentone_digits::{Real, Wide};
use eigentone_modes::Bounds;
use eigentone_response::{
    BoundedExponential, ExpmError, Exponential, Pade13, SecondOrder, Taylor, expm, expm_bounded,
    expm_condition,
};
use faer::{Mat, MatRef, mat};

use crate::random::Random;

type Exact = Wide<8>;

/// Entries row by row.
type Square = Vec<Exact>;

/// 146 matrices of the test suites of SciPy, Julia, ExponentialUtilities.jl and of the literature, and their
/// exponentials to 25 digits, computed in ball arithmetic from the doubles (FLINT's `arb_mat_exp`): name, order, entries row
/// by row, exponential.
const MATRICES: &str = include_str!("matrices.tsv");

/// Ends of the range of doubles, found by hand and at random, from the same source; 1e400 and 1e-400 stand for all beyond.
const ENDS: &str = include_str!("ends.tsv");

const UNIT: f64 = f64::EPSILON / 2.0;

/// The number that the digits say.
fn decimal(text: &str) -> Exact {
    let (digits, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let (negative, digits) = match digits.strip_prefix('-') {
        Some(digits) => (true, digits),
        None => (false, digits),
    };
    let (whole, part) = digits.split_once('.').unwrap_or((digits, ""));
    let ten = Exact::from(10.0);
    let number = whole
        .chars()
        .chain(part.chars())
        .fold(Exact::ZERO, |sum, digit| {
            sum * ten + Exact::from(f64::from(digit.to_digit(10).expect("a digit")))
        });
    // Far beyond the doubles, one is as good as the other.
    let exponent: f64 = exponent.parse().expect("an exponent");
    let exponent = exponent.clamp(-2000.0, 2000.0) as i64 - part.len() as i64;
    let (mut power, mut base, mut left) = (Exact::ONE, ten, exponent.unsigned_abs());
    while left > 0 {
        if left & 1 == 1 {
            power = power * base;
        }
        base = base * base;
        left >>= 1;
    }
    let number = if exponent < 0 {
        number / power
    } else {
        number * power
    };
    if negative { -number } else { number }
}

/// The largest column sum.
fn norm(n: usize, x: &[Exact]) -> Exact {
    let sum = |j: usize| (0..n).fold(Exact::ZERO, |sum, i| sum + x[i * n + j].abs());
    (0..n)
        .map(sum)
        .fold(Exact::ZERO, |a, b| if b > a { b } else { a })
}

/// What a matrix is off, with the norm of the exact one; entries beyond the doubles must be infinite, and are
/// left out.
fn off(name: &str, found: &Mat<f64>, exact: &[Exact]) -> (Exact, Exact) {
    let n = found.nrows();
    let mut rest = vec![Exact::ZERO; n * n];
    for i in 0..n {
        for j in 0..n {
            let (x, truth) = (found[(i, j)], exact[i * n + j]);
            if x.is_infinite() || truth.to_f64().is_infinite() {
                assert_eq!(x, truth.to_f64(), "{name} ({i}, {j})");
            } else {
                rest[i * n + j] = Exact::from(x) - truth;
            }
        }
    }
    (norm(n, &rest), norm(n, exact))
}

/// That an exponential is within its bound, and within what is promised; with the relative error and what the
/// condition allows.
fn judge(name: &str, a: MatRef<'_, f64>, exact: &[Exact]) -> BoundedExponential {
    let found = expm_bounded(a).unwrap_or_else(|error| panic!("{name}: {error}"));
    let (error, size) = off(name, &found.matrix, exact);
    let bound = Exact::from(found.bound);
    assert!(
        error <= bound,
        "{name}: {:e} {:e}",
        error.to_f64(),
        found.bound
    );
    let end = Exact::ONE.scale(1024);
    let size = if size > end { end } else { size };
    // At least ‖A‖.
    let least = || a.col_iter().map(|c| c.norm_l1()).fold(0.0, f64::max);
    let condition = expm_condition(a).unwrap_or_else(|_| least());
    let relative = (error / size).to_f64();
    // The last digit of subnormal numbers is more.
    let last = (Exact::from(a.nrows() as f64 * f64::from_bits(1)) / size).to_f64();
    let allowed = 1e-15 * (1.0 + condition) + last;
    assert!(relative <= allowed, "{name}: {relative:e} {allowed:e}");
    // Idle bounds would be worth nothing.
    let idle = (bound / size).to_f64();
    assert!(idle <= 4.0 * allowed, "{name}: {idle:e} {allowed:e}");
    assert_eq!(expm(a).as_ref(), Ok(&found.matrix), "{name}");
    found
}

/// Name, matrix and exponential of a line.
fn read(line: &str) -> (&str, Mat<f64>, Vec<Exact>) {
    let fields: Vec<&str> = line.split('\t').collect();
    let [name, n, entries, exact] = fields[..] else {
        panic!("{line}");
    };
    let n: usize = n.parse().expect("an order");
    let entries = entries.split(' ').map(|x| x.parse().expect("a double"));
    let entries: Vec<f64> = entries.collect();
    let a = Mat::from_fn(n, n, |i, j| entries[i * n + j]);
    (name, a, exact.split(' ').map(decimal).collect())
}

/// The entries that are off by more than half a unit of their last place, by a hair.
fn missed(found: &Mat<f64>, exact: &[Exact]) -> usize {
    let n = found.nrows();
    let is_off = |at: usize| {
        let (x, truth) = (found[(at / n, at % n)], exact[at]);
        let half = truth.abs().to_f64() * f64::EPSILON * 0.501 + f64::from_bits(1);
        x != truth.to_f64() && (Exact::from(x) - truth).abs().to_f64() > half
    };
    (0..n * n).filter(|at| is_off(*at)).count()
}

#[test]
fn matrices_of_other_suites() {
    let (mut worst, mut estimated) = ((0.0, ""), 0);
    for line in MATRICES.lines() {
        let (name, a, exact) = read(line);
        let found = judge(name, a.as_ref(), &exact);
        let (error, size) = off(name, &found.matrix, &exact);
        let relative = (error / size).to_f64();
        if relative > worst.0 {
            worst = (relative, name);
        }
        estimated += usize::from(found.bounds == Bounds::Estimated);
        if found.bounds == Bounds::Proven {
            assert!(relative < 2.0 * UNIT, "{name}: {relative:e}");
        }
    }
    assert_eq!(MATRICES.lines().count(), 146);
    println!(
        "worst relative error: {:e}, {}; {estimated} estimated",
        worst.0, worst.1
    );
}

/// The first lines are right in every entry, whatever its size beside the others; of random ones a few may be refused.
#[test]
fn ends_of_the_range() {
    const RANDOM: &str = "random";
    let (mut refused, mut loose) = (Vec::new(), 0);
    for line in ENDS.lines() {
        let (name, a, exact) = read(line);
        let random = name.starts_with(RANDOM);
        match expm(a.as_ref()) {
            Err(ExpmError::TooManyDigits { order }) if random && order <= a.nrows() => {
                refused.push(name);
                continue;
            }
            Err(error) => panic!("{name}: {error}"),
            Ok(found) => {
                let missed = missed(&found, &exact);
                assert!(random || missed == 0, "{name}: {found:?}");
                loose += usize::from(missed > 0);
            }
        }
        let found = judge(name, a.as_ref(), &exact);
        assert_eq!(found.bounds, Bounds::Proven, "{name}");
    }
    println!("refused: {refused:?}; not right in every entry: {loose}");
    let random = ENDS.lines().filter(|line| line.starts_with(RANDOM)).count();
    assert!(random == 120 && refused.len() * 10 <= random, "{refused:?}");
}

impl Random {
    /// From −size to size.
    fn whole(&mut self, size: i32) -> f64 {
        (self.signed() * (f64::from(size) + 0.5)).round()
    }
}

fn product<T: Real>(n: usize, x: &[T], y: &[T]) -> Vec<T> {
    let mut sum = vec![T::ZERO; n * n];
    for i in 0..n {
        for k in (0..n).filter(|k| !x[i * n + k].is_zero()) {
            for j in (0..n).filter(|j| !y[k * n + j].is_zero()) {
                sum[i * n + j] = sum[i * n + j] + x[i * n + k] * y[k * n + j];
            }
        }
    }
    sum
}

/// e^A by the plain Taylor series of 2^-s A, whose terms shrink by 2^32 at least, and s squarings.
fn reference<T: Real>(n: usize, a: &[f64]) -> Vec<T> {
    let norm: f64 = a
        .chunks(n)
        .map(|row| row.iter().map(|x| x.abs()).sum())
        .fold(0.0, f64::max);
    let squarings = (norm * 32f64.exp2()).log2().ceil().max(0.0) as i64;
    let scaled: Vec<T> = a.iter().map(|x| T::from(*x).scale(-squarings)).collect();
    let (mut terms, mut left) = (0, -f64::from(T::UNIT_LOG2));
    while left > 0.0 {
        terms += 1;
        left -= 32.0 + f64::from(terms).log2();
    }
    let mut sum = vec![T::ZERO; n * n];
    for k in (0..=terms).rev() {
        sum = product(n, &scaled, &sum);
        let divisor = T::from(f64::from(k + 1));
        sum.iter_mut().for_each(|x| *x = *x / divisor);
        (0..n).for_each(|i| sum[i * n + i] = sum[i * n + i] + T::ONE);
    }
    for _ in 0..squarings {
        sum = product(n, &sum, &sum);
    }
    sum
}

fn entries(n: usize, entry: impl FnMut((usize, usize)) -> f64) -> Vec<f64> {
    (0..n * n).map(|at| (at / n, at % n)).map(entry).collect()
}

fn matrix(n: usize, entries: &[f64]) -> Mat<f64> {
    Mat::from_fn(n, n, |i, j| entries[i * n + j])
}

fn exactly(entries: &[f64]) -> Square {
    entries.iter().map(|x| Exact::from(*x)).collect()
}

/// P and P⁻¹ of whole numbers: products of shears.
fn unimodular(n: usize, shears: usize, from: &mut Random) -> [Vec<f64>; 2] {
    let mut forth = entries(n, |(i, j)| f64::from(u8::from(i == j)));
    let mut back = forth.clone();
    for _ in 0..shears {
        let pick = |x: f64| ((x + 1.0) * 0.5 * n as f64) as usize;
        let (i, j) = (pick(from.signed()), pick(from.signed()));
        if i == j {
            continue;
        }
        let factor = if from.signed() < 0.0 { -1.0 } else { 1.0 };
        // Row j is added to row i, and column i is taken from column j.
        for k in 0..n {
            forth[i * n + k] += factor * forth[j * n + k];
            back[k * n + j] -= factor * back[k * n + i];
        }
    }
    [forth, back]
}

/// PBP⁻¹ for a block B whose exponential is known: A is without rounding, and so is its exponential but for 500 bits.
fn planted(n: usize, shears: usize, b: &[f64], power: &[Exact], seed: u64) -> (Mat<f64>, Square) {
    let [forth, back] = unimodular(n, shears, &mut Random(seed));
    let a = product(n, &product(n, &forth, b), &back);
    let exactly_a = product(
        n,
        &product(n, &exactly(&forth), &exactly(b)),
        &exactly(&back),
    );
    assert_eq!(exactly(&a), exactly_a, "the entries are to be doubles");
    let power = product(n, &product(n, &exactly(&forth), power), &exactly(&back));
    (matrix(n, &a), power)
}

/// Jordan blocks of four, of rates from −3 to 1 in eighths.
fn jordan(n: usize) -> (Vec<f64>, Square) {
    let rate = |i: usize| ((i / 4 * 7) % 33) as f64 / 8.0 - 3.0;
    let b = entries(n, |(i, j)| match (i == j, j == i + 1 && i / 4 == j / 4) {
        (true, _) => rate(i),
        (_, true) => 1.0,
        _ => 0.0,
    });
    let mut power = vec![Exact::ZERO; n * n];
    for i in 0..n {
        let mut term = reference::<Exact>(1, &[rate(i)])[0];
        for j in (i..n).take_while(|j| j / 4 == i / 4) {
            power[i * n + j] = term;
            term = term / Exact::from((j - i + 1) as f64);
        }
    }
    (b, power)
}

/// Orders 10 to 200, nearer to and farther from normal.
#[test]
fn planted_jordan_blocks() {
    for (n, shears) in [
        (10, 10),
        (10, 60),
        (24, 40),
        (40, 60),
        (40, 300),
        (65, 80),
        (100, 100),
        (200, 150),
    ] {
        let (b, power) = jordan(n);
        let (a, power) = planted(n, shears, &b, &power, n as u64);
        let name = format!("Jordan blocks of order {n}, {shears} shears");
        let found = judge(&name, a.as_ref(), &power);
        let (error, size) = off(&name, &found.matrix, &power);
        println!("{name}: {:e} {:?}", (error / size).to_f64(), found.bounds);
    }
}

/// N⁶ = 0, of entries up to the hundred thousands: the exponential is a polynomial of degree 5.
#[test]
fn planted_nilpotent_matrices() {
    for (n, shears, size) in [
        (12, 30, 9),
        (36, 60, 1000),
        (66, 80, 1000),
        (102, 80, 100_000),
    ] {
        let mut from = Random(size as u64);
        let b = entries(n, |(i, j)| match j % 6 > i % 6 && (i + j) % 3 == 0 {
            true => from.whole(size),
            false => 0.0,
        });
        let [one, zero] = [Exact::ONE, Exact::ZERO];
        let mut term: Square = (0..n * n)
            .map(|at| if at / n == at % n { one } else { zero })
            .collect();
        let mut power = term.clone();
        for k in 1..6 {
            term = product(n, &term, &exactly(&b));
            let divisor = Exact::from(f64::from(k));
            term.iter_mut().for_each(|x| *x = *x / divisor);
            power
                .iter_mut()
                .zip(&term)
                .for_each(|(sum, x)| *sum = *sum + *x);
        }
        let (a, power) = planted(n, shears, &b, &power, 3);
        judge(&format!("nilpotent of order {n}"), a.as_ref(), &power);
    }
}

/// A = 2^-s U Vᵀ of whole numbers, of which VᵀU = B is small though U and V are not: e^A = I + U φ(B) Vᵀ.
fn low_rank(n: usize, size: i32, shift: i32) -> (Mat<f64>, Square) {
    let scale = 2f64.powi(-shift);
    let mut from = Random(n as u64);
    let [mut u, mut v] = [(); 2].map(|()| {
        (0..n)
            .map(|_| [(); 2].map(|()| from.whole(size)))
            .collect::<Vec<_>>()
    });
    (v[n - 2], v[n - 1]) = ([1.0, 0.0], [0.0, 1.0]);
    let b = [[-1.5, 0.75], [-0.25, 0.5]].map(|row| row.map(|x| x / scale));
    for (k, b) in b.iter().enumerate() {
        let sum = |l: usize| (0..n - 2).map(|i| v[i][k] * u[i][l]).sum::<f64>();
        u[n - 2 + k] = [b[0] - sum(0), b[1] - sum(1)];
    }
    let a = Mat::from_fn(n, n, |i, j| scale * (u[i][0] * v[j][0] + u[i][1] * v[j][1]));
    // Σ B^k/(k + 1)!
    let b = exactly(&b.concat().iter().map(|x| x * scale).collect::<Vec<_>>());
    let [one, zero] = [Exact::ONE, Exact::ZERO];
    let mut term = vec![one, zero, zero, one];
    let mut phi = term.clone();
    for k in 2..100 {
        let divisor = Exact::from(f64::from(k));
        term = product(2, &term, &b)
            .into_iter()
            .map(|x| x / divisor)
            .collect();
        phi.iter_mut()
            .zip(&term)
            .for_each(|(sum, x)| *sum = *sum + *x);
    }
    let exact = |at: usize| {
        let (u, v) = (u[at / n].map(Exact::from), v[at % n].map(Exact::from));
        let left = [0, 1].map(|l| u[0] * phi[l] + u[1] * phi[2 + l]);
        let sum = (left[0] * v[0] + left[1] * v[1]).scale(-i64::from(shift));
        if at / n == at % n { sum + one } else { sum }
    };
    (a, (0..n * n).map(exact).collect())
}

/// Beyond what can be afforded with more digits the bound says how many are left, and `expm` refuses where they are too
/// few.
#[test]
fn low_ranks_that_cancel() {
    let mut kinds = Vec::new();
    for (n, size, shift) in [
        (9, 1000, 8),
        (30, 2000, 20),
        (64, 3000, 16),
        (120, 3000, 20),
        (320, 40, 4),
        (320, 4000, 20),
    ] {
        let (a, exact) = low_rank(n, size, shift);
        let name = format!("rank 2 of order {n}, {size}, 2^-{shift}");
        let found = expm_bounded(a.as_ref()).unwrap_or_else(|error| panic!("{name}: {error}"));
        let (error, whole) = off(&name, &found.matrix, &exact);
        assert!(
            error <= Exact::from(found.bound),
            "{name}: {:e} {:e}",
            error.to_f64(),
            found.bound
        );
        println!(
            "{name}: {:e}, bound {:e}, {:?}",
            (error / whole).to_f64(),
            found.bound / whole.to_f64(),
            found.bounds
        );
        match expm(a.as_ref()) {
            Ok(matrix) => {
                judge(&name, a.as_ref(), &exact);
                assert_eq!(matrix, found.matrix);
            }
            Err(error) => assert_eq!(error, ExpmError::Uncertain { error: found.bound }, "{name}"),
        }
        kinds.push((n, found.bounds));
    }
    println!("{kinds:?}");
}

/// Triangular ones up to order 200: on the diagonal stands the exponential of a number, from 1e−300 to 1e300.
#[test]
fn triangular_matrices() {
    for (n, size, top) in [
        (9, 700.0, 1.0),
        (30, 3.0, 1e8),
        (65, 300.0, 10.0),
        (100, 2.0, 1e3),
        (200, 600.0, 0.1),
    ] {
        let mut from = Random(n as u64);
        let a = entries(n, |(i, j)| match j.cmp(&i) {
            Ordering::Less => 0.0,
            Ordering::Equal => size * from.signed(),
            Ordering::Greater if j - i > 40 => 0.0,
            Ordering::Greater => top * from.signed(),
        });
        let exact = reference::<Exact>(n, &a);
        let name = format!("triangular of order {n}");
        let found = judge(&name, matrix(n, &a).as_ref(), &exact);
        for i in 0..n {
            let (x, truth) = (found.matrix[(i, i)], exact[i * n + i]);
            let off = (Exact::from(x) / truth - Exact::ONE).abs().to_f64();
            assert!(off <= 1.001 * UNIT, "{name}: {i}: {off:e}");
        }
    }
}

/// What decays is right beside what grows, though it is e^-800 of it.
#[test]
fn blocks_keep_their_digits() {
    let n = 40;
    let mut from = Random(8);
    let a = entries(n, |(i, j)| match (i / 10).cmp(&(j / 10)) {
        Ordering::Greater => 0.0,
        Ordering::Equal => {
            from.signed()
                + if i == j {
                    [400.0, -400.0, 0.0, -30.0][i / 10]
                } else {
                    0.0
                }
        }
        Ordering::Less => from.signed(),
    });
    // Rows and columns in another order, so that the blocks are to be found.
    let place = |i: usize| (i * 7) % n;
    let mut mixed = vec![0.0; n * n];
    for at in 0..n * n {
        mixed[place(at / n) * n + place(at % n)] = a[at];
    }
    let exact = reference::<Wide<24>>(n, &mixed);
    let exact: Square = exact.into_iter().map(Wide::resize).collect();
    let found = judge("blocks", matrix(n, &mixed).as_ref(), &exact);
    for block in 0..4 {
        let indices: Vec<usize> = (block * 10..block * 10 + 10).map(place).collect();
        let (mut error, mut size) = (Exact::ZERO, Exact::ZERO);
        for i in &indices {
            for j in &indices {
                let truth = exact[i * n + j];
                error = error + (Exact::from(found.matrix[(*i, *j)]) - truth).abs();
                size = size + truth.abs();
            }
        }
        let relative = (error / size).to_f64();
        assert!(relative < 1e-14, "block {block}: {relative:e}");
    }
    for i in 0..n {
        for j in 0..n {
            if exact[i * n + j].is_zero() {
                assert_eq!(found.matrix[(i, j)], 0.0);
            }
        }
    }
}

/// D⁻¹AD with scales of up to 2^±`spread`.
#[test]
fn badly_scaled_matrices() {
    for (n, spread) in [(6, 500), (20, 100), (20, 400), (65, 100), (65, 300)] {
        let mut from = Random(n as u64);
        let a = entries(n, |_| from.signed() * 2.0 / (n as f64).sqrt());
        let exponents: Vec<i64> = (0..n).map(|_| from.whole(spread) as i64).collect();
        let shift = |at: usize| exponents[at % n] - exponents[at / n];
        let scaled: Vec<f64> = (0..n * n).map(|at| a[at].scale(shift(at))).collect();
        let exact = reference::<Exact>(n, &a);
        let exact: Square = (0..n * n).map(|at| exact[at].scale(shift(at))).collect();
        judge(
            &format!("scales of 2^{spread}, order {n}"),
            matrix(n, &scaled).as_ref(),
            &exact,
        );
    }
}

/// Chebyshev's differentiation matrix at the points but one (`gallery('chebspec', n)`): nilpotent but for rounding, and
/// its exponential extrapolates polynomials of degree n − 1 to twice their interval.
fn chebspec(n: usize) -> Vec<f64> {
    let point = |k: usize| (std::f64::consts::PI * k as f64 / n as f64).cos();
    let weight = |k: usize| if k == 0 || k == n { 2.0 } else { 1.0 };
    entries(n, |(i, j)| {
        let (i, j) = (i + 1, j + 1);
        let (x, y) = (point(i), point(j));
        let sign = if (i + j) % 2 == 0 { 1.0 } else { -1.0 };
        match i == j {
            true if i == n => -(2.0 * (n * n) as f64 + 1.0) / 6.0,
            true => -0.5 * x / (1.0 - x * x),
            false => weight(i) / weight(j) * sign / (x - y),
        }
    })
}

#[test]
fn chebyshev_differentiation() {
    for (n, sign) in [(16, 1.0), (65, 1.0), (16, -1.0), (40, -1.0), (65, -1.0)] {
        let a: Vec<f64> = chebspec(n).iter().map(|x| sign * x).collect();
        // The same as with twice the digits, to 1e-124 of each entry.
        let exact = reference::<Exact>(n, &a);
        let found = judge(&format!("chebspec {n}"), matrix(n, &a).as_ref(), &exact);
        println!("chebspec {n}: {:e} {:?}", found.bound, found.bounds);
    }
}

/// Where too many digits are wanted the answer is no, or comes from what is certain of it, and soon.
#[test]
fn what_takes_too_long_is_refused() {
    let n = 64;
    let wild = Mat::from_fn(n, n, |i, j| 1e20 * ((1 + n * i + j) as f64).sin());
    match expm(wild.as_ref()) {
        Ok(found) => assert!(found.col_iter().all(|c| c.iter().all(|x| x.is_infinite()))),
        Err(error) => assert_eq!(error, ExpmError::TooManyDigits { order: n }),
    }
    let turn = Mat::from_fn(n, n, |i, j| 1e300 * (i as f64 - j as f64));
    assert_eq!(
        expm(turn.as_ref()),
        Err(ExpmError::TooManyDigits { order: n })
    );
    // Decay alone is certain with few digits.
    let decay = Mat::from_fn(n, n, |i, j| {
        if i == j {
            -1e300
        } else {
            1e297 * (i as f64 - j as f64).cos()
        }
    });
    assert_eq!(expm(decay.as_ref()), Ok(Mat::zeros(n, n)));
    let far: Vec<f64> = chebspec(150).iter().map(|x| -x).collect();
    assert!(expm(matrix(150, &far).as_ref()).is_err());
}

#[test]
fn every_method_takes_square_and_finite_matrices_only() {
    let methods: [&dyn Exponential; 3] = [&Pade13, &Taylor, &SecondOrder];
    let not_finite = |row, column| Some(ExpmError::NotFinite { row, column });
    for method in methods {
        for (rows, columns) in [(2, 3), (3, 2), (0, 1), (4, 2), (1, 0)] {
            let found = method.exponential(Mat::zeros(rows, columns).as_ref());
            assert_eq!(found, Err(ExpmError::NotSquare { rows, columns }));
        }
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let a = mat![[0.0, 1.0], [bad, 0.0]];
            assert_eq!(method.exponential(a.as_ref()).err(), not_finite(1, 0));
            assert_eq!(method.counted(a.as_ref()).err(), not_finite(1, 0));
        }
        // No digit is left, or an entry is too large; what there is else would be taken for an answer.
        for a in [
            mat![[0.0, 1e20], [-1e20, 0.0]],
            mat![[1e308, 1e308], [1e308, 1e308]],
            mat![[1e10, 0.0], [0.0, 0.0]],
            mat![[0.0, 1.0], [-1e300, 0.0]],
            mat![[f64::MAX, -f64::MAX], [f64::MAX, -f64::MAX]],
        ] {
            let found = method.exponential(a.as_ref());
            assert_eq!(
                found,
                Err(ExpmError::BeyondDoubles),
                "{} {a:?}",
                method.name()
            );
        }
        let none = method.exponential(Mat::zeros(0, 0).as_ref());
        assert_eq!(none, Ok(Mat::zeros(0, 0)));
    }
}

/// At least ‖A‖, and not more than a few times that for matrices that turn.
#[test]
fn conditions_at_the_ends_of_the_range() {
    for number in [-1e200, 3e-300, f64::MAX] {
        assert_eq!(expm_condition(mat![[number]].as_ref()), Ok(number.abs()));
    }
    for angle in [1e8, 1e20, 1e46, 1e150, 1e300] {
        let a = mat![[0.0, angle], [-angle, 0.0]];
        let condition = expm_condition(a.as_ref()).expect("it is small");
        assert!(
            (1.0 - 1e-12..=2.0).contains(&(condition / angle)),
            "{angle:e}: {condition:e}"
        );
    }
    // A change of the zero counts with the square of the entry above it.
    let condition = |above: f64| expm_condition(mat![[1.0, above], [0.0, -1.0]].as_ref());
    let part = condition(1e86).expect("it is small") / 1e172;
    assert!((0.01..1.0).contains(&part), "{part}");
    assert_eq!(condition(1e200), Ok(f64::INFINITY));
    let mut from = Random(1);
    for (n, sizes) in [
        (3, [1e-150, 1e17, 1e150, 1e300]),
        (6, [1e-150, 1e17, 1e30, 1e60]),
    ] {
        for size in sizes {
            let skew = Mat::from_fn(n, n, |_, _| from.signed());
            let skew = (&skew - skew.transpose()) * faer::Scale(size);
            let norm = skew.col_iter().map(|c| c.norm_l1()).fold(0.0, f64::max);
            let condition = expm_condition(skew.as_ref()).expect("few digits");
            let part = condition / norm;
            assert!(
                (1.0 - 1e-5..2.0 * n as f64).contains(&part),
                "{size:e}: {part}"
            );
        }
    }
}
