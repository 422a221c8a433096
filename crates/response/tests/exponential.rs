//! Matrix exponentials against the same in 320 bits.

use std::cmp::Ordering;
use std::fmt::Write;

use eigentone_digits::{Real, Wide};
use eigentone_response::{
    ExpmError, Exponential, Pade13, SecondOrder, Taylor, expm, expm_condition,
};
use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, MatRef};

use crate::random::Random;

type Exact = Wide<5>;
type Square = Vec<Vec<Exact>>;

const UNIT: f64 = f64::EPSILON / 2.0;

/// A matrix, and the family that it stands for.
struct Case {
    family: &'static str,
    matrix: Mat<f64>,
}

fn case<const N: usize>(family: &'static str, rows: [[f64; N]; N]) -> Case {
    Case {
        family,
        matrix: Mat::from_fn(N, N, |i, j| rows[i][j]),
    }
}

fn exactly(a: MatRef<'_, f64>) -> Square {
    let row = |i: usize| a.row(i).iter().map(|entry| Exact::from(*entry)).collect();
    (0..a.nrows()).map(row).collect()
}

/// e^A by the plain Taylor series of 2^-s A and s squarings, in 320 bits: s so large that terms
/// shrink by 2^8 at least, and 26 of them.
fn reference(a: &Square) -> Square {
    let n = a.len();
    let norm = norm(a).to_f64();
    let squarings = (norm * 256.0).log2().ceil().max(0.0) as i64;
    let build = |entry: &dyn Fn(usize, usize) -> Exact| -> Square {
        let row = |i: usize| (0..n).map(|j| entry(i, j)).collect();
        (0..n).map(row).collect()
    };
    let scaled = build(&|i, j| a[i][j].scale(-squarings));
    let identity = build(&|i, j| if i == j { Exact::ONE } else { Exact::ZERO });
    // Horner: I + A (I + A/2 (I + A/3 (…))).
    let mut sum = identity.clone();
    for k in (1..=26).rev() {
        let next = product(&scaled, &sum);
        sum = build(&|i, j| next[i][j] / Exact::from(f64::from(k)) + identity[i][j]);
    }
    for _ in 0..squarings {
        sum = product(&sum, &sum);
    }
    sum
}

fn product(x: &Square, y: &Square) -> Square {
    let row = |x: &Vec<Exact>| {
        let mut sum = vec![Exact::ZERO; x.len()];
        for (factor, y) in x.iter().zip(y).filter(|(factor, _)| !factor.is_zero()) {
            for (sum, y) in sum.iter_mut().zip(y).filter(|(_, y)| !y.is_zero()) {
                *sum = *sum + *factor * *y;
            }
        }
        sum
    };
    x.iter().map(row).collect()
}

/// The largest column sum.
fn norm(x: &Square) -> Exact {
    let sum = |j: usize| x.iter().fold(Exact::ZERO, |sum, row| sum + row[j].abs());
    let larger = |a, b| if b > a { b } else { a };
    (0..x.len()).map(sum).fold(Exact::ZERO, larger)
}

fn difference(x: &Square, y: &Square) -> Square {
    let row = |(x, y): (&Vec<Exact>, &Vec<Exact>)| x.iter().zip(y).map(|(x, y)| *x - *y).collect();
    x.iter().zip(y).map(row).collect()
}

fn is_finite(x: &Mat<f64>) -> bool {
    x.col_iter()
        .all(|column| column.iter().all(|x| x.is_finite()))
}

/// ‖X − E‖₁ / ‖E‖₁, ∞ where X is not finite.
fn error(x: &Mat<f64>, exact: &Square) -> f64 {
    if !is_finite(x) {
        return f64::INFINITY;
    }
    let off = norm(&difference(&exactly(x.as_ref()), exact));
    (off / norm(exact)).to_f64()
}

/// Cases from the literature and from textbooks.
fn known() -> Vec<Case> {
    let (a, b, c, d, e) = (2e10, 4e8 / 6.0, 200.0 / 3.0, 3.0, 1e-8);
    let mut cases = vec![
        // Moler's blog, "A balancing act for the matrix exponential", 2012.
        case("Moler", [[0.0, e, 0.0], [-(a + b), -d, a], [c, 0.0, -c]]),
        // Moler & Van Loan 2003, section 3.
        case("Moler & Van Loan", [[-49.0, 24.0], [-64.0, 31.0]]),
        // Al-Mohy & Higham 2009, section 1.
        case("overscaling", [[1.0, 1e6], [0.0, -1.0]]),
        case("overscaling", [[1.0, 1e12], [0.0, -1.0]]),
        case("overscaling", [[1e6, -1e6], [1e6, -1e6]]),
        case(
            "overscaling",
            [[0.0, 1e9, 1e3], [0.0, 0.0, 1e9], [0.0, 0.0, 0.0]],
        ),
        case(
            "overscaling",
            [[1.0, 1e5, 1e10], [0.0, -1.0, 1e5], [0.0, 0.0, 0.5]],
        ),
        case("fast and slow", [[-1e12, 0.0], [0.0, -1.0]]),
        case("fast and slow", [[-1e9, 1e9], [1.0, -1.0]]),
        case("decay", [[-700.0, 1.0], [0.0, -690.0]]),
        case("growth", [[300.0, 1.0], [-1.0, 290.0]]),
    ];
    for exponent in 3..=12 {
        for a in [0.0, -1.0, -100.0, 5.0] {
            let delta = 10f64.powi(-exponent);
            cases.push(case("divided difference", [[a, 1.0], [0.0, a + delta]]));
        }
    }
    for (g, k) in [
        (1.0, 1.0),
        (100.0, 1.0),
        (1.0, 1e6),
        (1e3, -1.0),
        (3.0, 1e-4),
    ] {
        let rows = [
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [-k, 0.0, 0.0, -g],
            [0.0, -k, g, 0.0],
        ];
        cases.push(case("gyroscopic", rows));
    }
    for (n, lambda) in [(2, -2.0), (5, -1.0), (10, 0.0), (12, -30.0), (20, 0.5)] {
        let entry = |i: usize, j: usize| match j.wrapping_sub(i) {
            0 => lambda,
            1 => 1.0,
            _ => 0.0,
        };
        cases.push(Case {
            family: "Jordan",
            matrix: Mat::from_fn(n, n, entry),
        });
    }
    cases
}

impl Random {
    /// From 10^`low` to 10^`high`, evenly on a logarithmic scale.
    fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        10f64.powf(low + (high - low) * 0.5 * (self.signed() + 1.0))
    }

    fn size(&mut self, low: usize, high: usize) -> usize {
        low + ((high - low + 1) as f64 * 0.5 * (self.signed() + 1.0)) as usize
    }

    /// n × n, from the indices and a number in [−1, 1).
    fn matrix(&mut self, n: usize, entry: impl Fn(usize, usize, f64) -> f64) -> Mat<f64> {
        Mat::from_fn(n, n, |i, j| entry(i, j, self.signed()))
    }

    /// A chain between two walls, with masses from 1 to 10 and springs from 1 to 10^`stiffest`.
    fn chain(&mut self, stiffest: f64, damped: bool) -> Mat<f64> {
        let n = self.size(1, 10);
        let mut a = Mat::<f64>::zeros(2 * n, 2 * n);
        let m: Vec<f64> = (0..n).map(|_| self.magnitude(0.0, 1.0)).collect();
        for i in 0..n {
            a[(i, n + i)] = 1.0;
        }
        for spring in 0..=n {
            let k = self.magnitude(0.0, stiffest);
            let c = if damped { 0.05 * k.sqrt() } else { 0.0 };
            let ends = [spring.checked_sub(1), (spring < n).then_some(spring)];
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                if let (Some(row), Some(column)) = (ends[i], ends[j]) {
                    let sign = if i == j { -1.0 } else { 1.0 };
                    a[(n + row, column)] += sign * k / m[row];
                    a[(n + row, n + column)] += sign * c / m[row];
                }
            }
        }
        a
    }
}

/// Stiff and nonnormal matrices of order 2 to 20.
fn generated() -> Vec<Case> {
    let mut from = Random(7);
    let mut cases = Vec::new();
    for _ in 0..25 {
        let mut add = |family, matrix| cases.push(Case { family, matrix });
        add("stiff chain", from.chain(12.0, true));
        add("undamped chain", from.chain(6.0, false));

        let (n, top) = (from.size(2, 20), from.magnitude(-1.0, 1.5));
        add("full", from.matrix(n, |_, _, x| top * x));

        let (n, top) = (from.size(2, 20), from.magnitude(0.0, 8.0));
        let triangular = from.matrix(n, |i, j, x| match j.cmp(&i) {
            Ordering::Less => 0.0,
            Ordering::Equal => 3.0 * x,
            Ordering::Greater => top * x,
        });
        add("triangular", triangular);

        let (n, ratio) = (from.size(2, 20), from.magnitude(-1.5, 0.0));
        let graded = from.matrix(n, |i, j, x| 4.0 * ratio.powi((i + j) as i32) * x);
        add("graded", graded);

        let (n, ratio) = (from.size(2, 14), from.magnitude(0.0, 1.0));
        let skewed = from.matrix(n, |i, j, x| 2.0 * ratio.powi(i as i32 - j as i32) * x);
        add("badly scaled", skewed);

        let (n, top) = (from.size(2, 16), from.magnitude(0.0, 3.0));
        let bidiagonal = from.matrix(n, |i, j, x| match j.wrapping_sub(i) {
            0 => -top * x.abs(),
            1 => top * x,
            _ => 0.0,
        });
        add("bidiagonal decay", bidiagonal);

        let (n, top) = (from.size(3, 12), from.magnitude(0.0, 5.0));
        let strict = from.matrix(n, |i, j, x| if j > i { top * x } else { 0.0 });
        let mix = from.matrix(n, |i, j, x| if i == j { 2.0 + x } else { x });
        let inverse = mix.partial_piv_lu().inverse();
        add("nearly nilpotent", &mix * strict * inverse);
    }
    cases
}

/// Worst ratios of a family.
struct Worst {
    family: &'static str,
    cases: usize,
    /// Error of [`expm`], of [`Taylor`] and of [`Pade13`] in units of κ·2^-53.
    units: [f64; 3],
    /// Error of [`expm`] and of [`Taylor`] over what is asked of them.
    of_allowed: [f64; 2],
}

/// In doubles; NaN where the method says that it cannot.
fn plain(method: &dyn Exponential, a: MatRef<'_, f64>) -> Mat<f64> {
    let nothing = || Mat::from_fn(a.nrows(), a.ncols(), |_, _| f64::NAN);
    method.exponential(a).unwrap_or_else(|_| nothing())
}

/// The error must stay below ten units of what the condition makes of rounding, or below twice that of
/// Al-Mohy & Higham's method.
#[test]
fn errors_are_those_that_the_condition_explains() {
    let (known, generated) = (known(), generated());
    assert_eq!(generated.len(), 200);
    let mut table: Vec<Worst> = Vec::new();
    for Case { family, matrix } in known.iter().chain(&generated) {
        let exact = reference(&exactly(matrix.as_ref()));
        if !norm(&exact).to_f64().is_finite() {
            // Beyond the range of doubles: said to be so.
            let found = expm(matrix.as_ref()).expect("square and finite");
            assert!(!is_finite(&found), "{family}");
            assert!(found.col_iter().all(|c| c.iter().all(|x| !x.is_nan())));
            continue;
        }
        let condition = expm_condition(matrix.as_ref()).expect("square and finite");
        let found = [
            expm(matrix.as_ref()).expect("square and finite"),
            plain(&Taylor, matrix.as_ref()),
            plain(&Pade13, matrix.as_ref()),
        ];
        let errors = found.each_ref().map(|found| error(found, &exact));
        let rounding = UNIT * condition.max(1.0);
        let units = errors.map(|error| error / rounding);
        let allowed = (10.0 * rounding).max(2.0 * errors[2]);
        let of_allowed = [errors[0] / allowed, errors[1] / allowed];
        match table.iter_mut().find(|worst| worst.family == *family) {
            Some(worst) => {
                worst.cases += 1;
                worst.units = std::array::from_fn(|i| worst.units[i].max(units[i]));
                worst.of_allowed = std::array::from_fn(|i| worst.of_allowed[i].max(of_allowed[i]));
            }
            None => table.push(Worst {
                family,
                cases: 1,
                units,
                of_allowed,
            }),
        }
    }
    let mut text = String::from(
        "\nWorst errors, in units of κ·2^-53, and over the allowed max(10 units, 2 × Padé 13)\n\n\
         family               cases      expm    Taylor   Padé 13   expm/allowed   Taylor/allowed\n",
    );
    for worst in &table {
        let ([a, b, c], [d, e]) = (worst.units, worst.of_allowed);
        let (family, cases) = (worst.family, worst.cases);
        writeln!(
            text,
            "{family:20} {cases:>5} {a:>9.2e} {b:>9.2e} {c:>9.2e} {d:>14.2} {e:>16.2}"
        )
        .expect("strings take text");
    }
    println!("{text}");
    for worst in &table {
        assert!(worst.units[0].is_finite(), "expm, {}", worst.family);
        assert!(worst.of_allowed[0] <= 1.0, "expm, {}", worst.family);
        // In doubles alone the powers of nearly nilpotent matrices cancel, by any method.
        let doubles_suffice = worst.family != "nearly nilpotent";
        let taylor = worst.of_allowed[1];
        assert!(
            taylor <= 1.0 || !doubles_suffice,
            "Taylor, {}",
            worst.family
        );
    }
}

#[test]
fn only_square_and_finite_matrices_are_taken() {
    let tall = Mat::<f64>::zeros(3, 2);
    let error = ExpmError::NotSquare {
        rows: 3,
        columns: 2,
    };
    assert_eq!(expm(tall.as_ref()).err(), Some(error));
    assert_eq!(expm_condition(tall.as_ref()).err(), Some(error));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut a = Mat::<f64>::zeros(3, 3);
        a[(2, 1)] = bad;
        let error = ExpmError::NotFinite { row: 2, column: 1 };
        assert_eq!(expm(a.as_ref()).err(), Some(error));
        assert_eq!(expm_condition(a.as_ref()).err(), Some(error));
    }
}

#[test]
fn trivial_matrices_are_exact() {
    let none = expm(Mat::<f64>::zeros(0, 0).as_ref()).expect("square");
    assert_eq!(none.shape(), (0, 0));
    for n in 1..=6 {
        let one = expm(Mat::<f64>::zeros(n, n).as_ref()).expect("square");
        assert_eq!(one, Mat::<f64>::identity(n, n));
    }
    let tiny = Mat::from_fn(3, 3, |i, j| 1e-300 * (1 + i + 3 * j) as f64);
    let result = expm(tiny.as_ref()).expect("square");
    assert_eq!(result[(0, 1)], tiny[(0, 1)]);
    assert_eq!(result[(1, 1)], 1.0);
}

/// Every norm that a double can hold: decay ends at 0, growth at ∞, a turn keeps its size.
#[test]
fn nothing_is_ever_nan() {
    for exponent in [1, 3, 10, 16, 20, 100, 150, 200, 300, 307] {
        let size = 10f64.powi(exponent);
        for n in [1, 2, 3, 5, 7] {
            let decay = Mat::from_fn(n, n, |i, j| match (i == j, i + 1 == j) {
                (true, _) => -size * (1.0 + i as f64 / 8.0),
                (_, true) => size / 8.0,
                _ => 0.0,
            });
            let result = expm(decay.as_ref()).expect("finite");
            assert!(is_finite(&result), "decay {size:e}");
            assert!(size < 1e3 || result.norm_max() == 0.0);

            let turn = Mat::from_fn(n, n, |i, j| size * (j as f64 - i as f64) / n as f64);
            let result = expm(turn.as_ref()).expect("finite");
            assert!(is_finite(&result), "turn {size:e}, order {n}");
            assert!(result.norm_max() < 2.0, "turn {size:e}, order {n}");

            let growth = Mat::from_fn(n, n, |i, j| if i == j { size } else { -size / 9.0 });
            for a in [
                &growth,
                &(&growth - 2.0 * &turn),
                &((&turn * faer::Scale(1.0 / size)) * &decay),
            ] {
                let result = expm(a.as_ref()).expect("finite");
                let nan = result.col_iter().any(|c| c.iter().any(|x| x.is_nan()));
                assert!(!nan, "growth {size:e}, order {n}");
            }
        }
        // A power of four is balanced to a turn, which keeps its size.
        let stiffness = 4f64.powi((size.log2() / 2.0) as i32);
        let oscillator = Mat::from_fn(2, 2, |i, j| [[0.0, 1.0], [-stiffness, 0.0]][i][j]);
        let result = expm(oscillator.as_ref()).expect("finite");
        assert!(result[(0, 0)].abs() < 1.5 && result[(0, 1)].abs() < 1.5 / stiffness.sqrt());
    }
}

/// What decays at once leaves the digits of what moves slowly.
#[test]
fn slow_motion_beside_fast_decay_keeps_its_digits() {
    for fast in [1e3, 1e12, 1e100, 1e300] {
        let a = Mat::from_fn(
            3,
            3,
            |i, j| if i == j { [-fast, -1.0, 0.25][i] } else { 0.0 },
        );
        let result = expm(a.as_ref()).expect("finite");
        assert_eq!(result[(0, 0)], 0.0);
        for (i, rate) in [(1, -1.0f64), (2, 0.25)] {
            let error = (result[(i, i)] / rate.exp() - 1.0).abs();
            assert!(error < 8.0 * f64::EPSILON, "{fast:e}: {error:e}");
        }
    }
}

/// By up to 1e25 rad, of which doubles keep no digit in 50 or 80 squarings; cosine and sine from elsewhere, to 20 digits.
#[test]
fn very_many_turns_keep_their_digits() {
    for (angle, cosine, sine) in [
        (1e8, -0.363_385_089_355_690_5, 0.931_639_027_109_726),
        (1e16, -0.626_168_198_133_086_2, 0.779_688_006_606_978_8),
        (1e25, 0.952_269_749_313_008_9, -0.305_257_800_135_130_3),
    ] {
        let a = faer::mat![[0.0, angle], [-angle, 0.0]];
        let result = expm(a.as_ref()).expect("finite");
        let wanted = [[cosine, sine], [-sine, cosine]];
        for (i, row) in wanted.iter().enumerate() {
            for (j, wanted) in row.iter().enumerate() {
                let off = (result[(i, j)] - wanted).abs();
                assert!(off <= 2.0 * UNIT, "{angle:e}: {off:e}");
            }
        }
    }
}

/// ‖A‖‖L(A, E)‖ / (‖E‖‖e^A‖), from a difference of two exponentials in 320 bits.
fn condition_along(a: &Mat<f64>, e: &Mat<f64>) -> f64 {
    const STEP: i64 = -120;
    let (a, e) = (exactly(a.as_ref()), exactly(e.as_ref()));
    let n = a.len();
    let moved = |i: usize, j: usize| a[i][j] + e[i][j].scale(STEP);
    let moved: Square = (0..n)
        .map(|i| (0..n).map(|j| moved(i, j)).collect())
        .collect();
    let at = reference(&a);
    let change = norm(&difference(&reference(&moved), &at)).scale(-STEP);
    (norm(&a) * change / (norm(&e) * norm(&at))).to_f64()
}

#[test]
fn the_condition_of_small_matrices_is_exact() {
    for rows in [
        [[0.0, 1.0], [-4.0, -0.1]],
        [[1.0, 1e3], [0.0, -1.0]],
        [[-30.0, 1.0], [0.5, -2.0]],
        [[700.0, 1.0], [1.0, 705.0]],
        [[-800.0, 1.0], [1.0, -805.0]],
    ] {
        let a = Mat::from_fn(2, 2, |i, j| rows[i][j]);
        // One signed unit vector in each column; a common sign makes no difference.
        let mut largest = 0f64;
        for choice in 0..8 {
            let (first, second) = (choice & 1, choice >> 1 & 1);
            let sign = if choice >> 2 == 1 { -1.0 } else { 1.0 };
            let mut e = Mat::<f64>::zeros(2, 2);
            e[(first, 0)] = 1.0;
            e[(second, 1)] = sign;
            largest = largest.max(condition_along(&a, &e));
        }
        let found = expm_condition(a.as_ref()).expect("finite");
        let off = (found / largest - 1.0).abs();
        assert!(off < 1e-9, "{rows:?}: {found} {largest}");
    }
    let number = Mat::from_fn(1, 1, |_, _| -3.5);
    assert_eq!(expm_condition(number.as_ref()), Ok(3.5));
}

/// For larger ones it is a lower bound that no direction tried exceeds by much.
#[test]
fn the_condition_of_larger_matrices_is_nearly_reached() {
    let mut from = Random(11);
    for (n, ratio) in [(5, 1.0), (6, 3.0), (8, 0.5)] {
        let a = from.matrix(n, |i, j, x| 2.0 * f64::powi(ratio, i as i32 - j as i32) * x);
        let found = expm_condition(a.as_ref()).expect("finite");
        let mut largest = condition_along(&a, &Mat::identity(n, n));
        for row in 0..n {
            for column in 0..n {
                let unit = |i, j| f64::from(u8::from((i, j) == (row, column)));
                largest = largest.max(condition_along(&a, &Mat::from_fn(n, n, unit)));
            }
        }
        assert!(found >= 0.5 * largest, "order {n}: {found} {largest}");
        assert!(found <= n as f64 * largest, "order {n}: {found} {largest}");
    }
}

/// Chains of few masses and of so many that sparsity is used, of equal and of unequal masses, over short
/// and long times.
#[test]
fn second_order_errors_are_those_that_the_condition_explains() {
    let mut from = Random(5);
    let mut worst = [0f64; 2];
    for case in 0..60 {
        let damping = [0.0, 1e-3, 0.1, 3.0][case % 4];
        let time = [0.01, 0.05, 0.2, 0.5, 40.0][case / 4 % 5];
        let n = match case / 20 {
            0 => 10,
            1 => 1 + case % 9,
            _ => 11 + case % 7,
        };
        let unequal = case >= 20 && case % 3 > 0;
        let mass: Vec<f64> = (0..n)
            .map(|_| {
                if unequal {
                    from.magnitude(0.0, 2.0)
                } else {
                    1.0
                }
            })
            .collect();
        let spring: Vec<f64> = (0..=n).map(|_| from.magnitude(0.0, 1.5)).collect();
        let mut a = Mat::<f64>::zeros(2 * n, 2 * n);
        for i in 0..n {
            a[(i, n + i)] = 4.0 * time;
            for (factor, first) in [(0.25 * time, 0), (damping * time, n)] {
                let factor = factor / mass[i];
                a[(n + i, first + i)] = -factor * (spring[i] + spring[i + 1]);
                if i > 0 {
                    a[(n + i, first + i - 1)] = factor * spring[i];
                }
                if i + 1 < n {
                    a[(n + i, first + i + 1)] = factor * spring[i + 1];
                }
            }
        }
        let exact = reference(&exactly(a.as_ref()));
        let condition = expm_condition(a.as_ref()).expect("finite");
        // The result is rounded too.
        let rounding = UNIT * condition.max(1.0);
        for (worst, method) in worst
            .iter_mut()
            .zip([&SecondOrder as &dyn Exponential, &Taylor])
        {
            let error = error(&plain(method, a.as_ref()), &exact) / rounding;
            assert!(error < 10.0, "{} on chain {case}: {error}", method.name());
            *worst = worst.max(error);
        }
        // The same matrix, stored by rows.
        let back = Mat::from_fn(2 * n, 2 * n, |i, j| a[(j, i)]);
        assert_eq!(
            SecondOrder.exponential(back.transpose()),
            SecondOrder.exponential(a.as_ref())
        );
    }
    println!(
        "second order {:.2}, Taylor {:.2} units of κ·2^-53",
        worst[0], worst[1]
    );
}

/// Found by fuzzing: the bound of its growth is below every power of two that is counted.
#[test]
fn what_vanishes_at_the_end_of_the_doubles_is_0() {
    for entry in [-1.5174619174283343e308, -f64::MAX] {
        let power = expm(faer::mat![[entry]].as_ref()).expect("it is square and finite");
        assert_eq!(power[(0, 0)], 0.0);
        // Beside it no digits are promised, but numbers.
        let both = faer::mat![[entry, 0.0], [0.0, 1.0]];
        let power = expm(both.as_ref()).expect("it is square and finite");
        assert!(power[(0, 0)] == 0.0 && !power[(1, 1)].is_nan());
    }
}

/// e^A is 10^137 in one entry and 10^-189 in another, further apart than doubles with one power of two for all of them:
/// what is lost so is refused, and neither 0 nor half of it.
#[test]
fn what_growth_leaves_no_room_for_is_refused() {
    use eigentone_modes::{GROUND, System};
    use eigentone_response::{ByExponential, Response, ResponseError, State};

    let mut builder = System::builder().mass("m1", 1.0).spring(GROUND, "m1", -1e5);
    for i in 2..=6 {
        let (before, name) = (format!("m{}", i - 1), format!("m{i}"));
        builder = builder.mass(&name, 1.0).spring(GROUND, &name, 1.0);
        builder = builder.spring(before, name, 1e-60);
    }
    let system = builder.damper(GROUND, "m3", 0.5).build().expect("a system");
    let from = |name: &str| {
        let response = Response::of(&system).from(State::at_rest().displace(name, 1.0));
        response.every(1.0).until(2.0).run_by(&ByExponential)
    };
    let lost = from("m1");
    assert!(
        matches!(lost, Err(ResponseError::Overflow { .. })),
        "{lost:?}"
    );
    for method in [&Taylor as &dyn Exponential, &SecondOrder, &Pade13] {
        let beside = faer::mat![[400.0, 0.0], [1e-300, -400.0]];
        if let Ok(found) = method.exponential(beside.as_ref()) {
            // e^-400, and 1e-300 sinh(400)/400.
            let wanted = [1.915_169_596_714_005_6e-174, 6.526_837_112_205_18e-130];
            for (found, wanted) in [found[(1, 1)], found[(1, 0)]].into_iter().zip(wanted) {
                assert!(
                    (found / wanted - 1.0).abs() < 1e-10,
                    "{}: {found:e}",
                    method.name()
                );
            }
        }
    }
}

/// Of a turn of 1e12 radians doubles keep four digits; with more, the condition is had beyond 64 rows too.
#[test]
fn conditions_of_many_rows_may_take_more_digits() {
    let n = 66;
    let turn = Mat::from_fn(n, n, |i, j| match i as isize - j as isize {
        1 => 1e12,
        -1 => -1e12,
        _ => 0.0,
    });
    let found = expm_condition(turn.as_ref()).expect("it can be afforded");
    // It has six digits.
    assert!(
        (1.999_998e12..2e12 * n as f64).contains(&found),
        "{found:e}"
    );
}
