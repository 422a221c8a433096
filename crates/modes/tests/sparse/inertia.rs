//! Eigenvalues counted in 384 bits: the truth about matrices of doubles, in another way than the code.

use eigentone_digits::{DoubleDouble, Real, Wide, WideComplex};
use eigentone_modes::SparseModes;

use crate::elements::{Assembly, Model};

pub type Long = Wide<6>;

/// A band of rows from their first entry on.
fn rows(model: &Model) -> Vec<usize> {
    let mut first: Vec<usize> = (0..model.n).collect();
    for part in [&model.stiffness, &model.mass, &model.damping] {
        for &(i, j) in part.entries.keys() {
            first[i] = first[i].min(j);
        }
    }
    first
}

/// K − τM by rows of its lower triangle, factorised in place; the number of its negative pivots.
pub fn below(model: &Model, at: Long) -> usize {
    let first = rows(model);
    let mut lower: Vec<Vec<Long>> = (0..model.n)
        .map(|i| vec![Long::ZERO; i + 1 - first[i]])
        .collect();
    let mut add = |part: &Assembly, factor: Long| {
        for (&(i, j), &value) in &part.entries {
            if j <= i {
                let entry = &mut lower[i][j - first[i]];
                *entry = *entry + Long::from(value) * factor;
            }
        }
    };
    add(&model.stiffness, Long::ONE);
    add(&model.mass, -at);
    let mut pivots = vec![Long::ZERO; model.n];
    let mut negative = 0;
    for i in 0..model.n {
        let (above, rest) = lower.split_at_mut(i);
        let row = &mut rest[0];
        let mut pivot = row[i - first[i]];
        // Entries are kept as l·d.
        for j in first[i]..i {
            let mut sum = row[j - first[i]];
            for k in first[i].max(first[j])..j {
                sum = sum - row[k - first[i]] * (above[j][k - first[j]] / pivots[k]);
            }
            row[j - first[i]] = sum;
            pivot = pivot - sum * (sum / pivots[j]);
        }
        assert!(!pivot.is_zero(), "a pivot of 384 bits is 0");
        negative += usize::from(pivot < Long::ZERO);
        pivots[i] = pivot;
    }
    negative
}

/// Asserts that these are the lowest eigenvalues, each within its bound, and that bounds say something: not more
/// than `within` of the eigenvalue, where it is not exactly 0.
pub fn assert_lowest(model: &Model, modes: &SparseModes, within: f64, what: &str) {
    assert!(modes.is_counted(), "{what}: not counted");
    let found = modes.squares().iter().zip(modes.square_bounds());
    for (k, (&square, bound)) in found.enumerate() {
        let bound = bound.unwrap_or_else(|| panic!("{what}: mode {k} has no bound"));
        assert!(
            bound <= within * square.abs(),
            "{what}: mode {k}: {square:e} is known to {bound:e} only"
        );
        let room = if square == 0.0 {
            Long::from(1e-60)
        } else {
            Long::from(bound)
        };
        let [low, high] = [Long::from(square) - room, Long::from(square) + room];
        let (low, high) = (below(model, low), below(model, high));
        assert!(
            low <= k && k < high,
            "{what}: mode {k} of {square:e} ± {bound:e}: {low} lie below, {high} up to there"
        );
    }
}

type Complex = WideComplex<Long>;

/// det Q(z)/|det Q(z)| by bands with partial pivoting, up to a positive factor.
fn direction(model: &Model, z: Complex) -> num_complex::Complex<f64> {
    let first = rows(model);
    let width = (0..model.n).map(|i| i - first[i]).max().unwrap_or(0);
    let n = model.n;
    // Row i from column i − width to i + 2 width.
    let mut band = vec![vec![Complex::ZERO; 3 * width + 1]; n];
    for (part, factor) in [
        (&model.mass, z * z),
        (&model.damping, z),
        (&model.stiffness, Complex::new(Long::ONE, Long::ZERO)),
    ] {
        for (&(i, j), &value) in &part.entries {
            let entry = &mut band[i][j + width - i];
            *entry += factor * Complex::new(Long::from(value), Long::ZERO);
        }
    }
    let mut turned = num_complex::Complex::<f64>::ONE;
    for k in 0..n {
        let last = (k + width).min(n - 1);
        let size = |i: usize| band[i][k + width - i].norm();
        let best = (k..=last).fold(k, |best, i| if size(i) > size(best) { i } else { best });
        if best != k {
            turned = -turned;
            for j in k..=(k + 2 * width).min(n - 1) {
                let held = band[k][j + width - k];
                band[k][j + width - k] = band[best][j + width - best];
                band[best][j + width - best] = held;
            }
        }
        let pivot = band[k][width];
        let size = pivot.norm();
        turned *= num_complex::Complex::new(pivot.re.to_f64() / size, pivot.im.to_f64() / size);
        for i in k + 1..=last {
            let factor = band[i][k + width - i] / pivot;
            for j in k..=(k + 2 * width).min(n - 1) {
                let taken = factor * band[k][j + width - k];
                let entry = &mut band[i][j + width - i];
                *entry = *entry - taken;
            }
        }
    }
    turned / turned.norm()
}

/// How many roots of det Q lie in a disc: the winding number of det Q along its rim, by 32 points, which is enough
/// for a few roots that do not lie near the rim.
pub fn inside(model: &Model, centre: num_complex::Complex<f64>, radius: f64) -> i64 {
    const POINTS: usize = 32;
    let at = |k: usize| {
        let angle = (k as f64 + 0.37) / POINTS as f64 * std::f64::consts::TAU;
        let re = DoubleDouble::new(centre.re, radius * angle.cos());
        let im = DoubleDouble::new(centre.im, radius * angle.sin());
        direction(model, Complex::new(Long::from(re), Long::from(im)))
    };
    let directions: Vec<_> = (0..POINTS).map(at).collect();
    let turns: f64 = (0..POINTS)
        .map(|k| (directions[(k + 1) % POINTS] / directions[k]).arg())
        .sum();
    (turns / std::f64::consts::TAU).round() as i64
}

/// How many roots of det Q have |λ| < radius: the winding number along the circle, followed over its upper half with
/// arcs that are halved until both halves turn by little.
pub fn below_radius(model: &Model, radius: f64) -> i64 {
    const ARCS: usize = 48;
    let at = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let z = Complex::new(Long::from(radius * cos), Long::from(radius * sin));
        direction(model, z)
    };
    fn turn(
        at: &dyn Fn(f64) -> num_complex::Complex<f64>,
        ends: [(f64, num_complex::Complex<f64>); 2],
        depth: usize,
    ) -> f64 {
        let [(a, first), (b, last)] = ends;
        let angle = 0.5 * (a + b);
        let middle = at(angle);
        let (one, two) = ((middle / first).arg(), (last / middle).arg());
        if depth > 40 || one.abs().max(two.abs()) < 0.7 && (one - two).abs() < 0.2 {
            return one + two;
        }
        turn(at, [(a, first), (angle, middle)], depth + 1)
            + turn(at, [(angle, middle), (b, last)], depth + 1)
    }
    let angle = |k: usize| k as f64 / ARCS as f64 * std::f64::consts::PI;
    let points: Vec<_> = (0..=ARCS).map(|k| (angle(k), at(angle(k)))).collect();
    let turns = points
        .windows(2)
        .map(|pair| turn(&at, [pair[0], pair[1]], 0));
    (turns.sum::<f64>() / std::f64::consts::PI).round() as i64
}
