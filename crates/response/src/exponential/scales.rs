//! A diagonal similarity of powers of two that leaves no entry larger than it must be.

use faer::MatRef;

/// The binary logarithms y of a diagonal D = 2^y that makes D⁻¹AD small, for the classes of A in the order
/// of their paths.
///
/// Within a class the largest entries of each row and column off the diagonal are made alike (Schneider & Schneider
/// 1991, *Math. Oper. Res.* 16, max-balancing), where that halves the largest entry. A class that
/// others lead to, and that leads to none of them, can be scaled by itself: just so far that no entry on the way to it is
/// larger than those of the classes. So the size of what only ever passes on, as above the diagonal of a triangular matrix,
/// costs neither squarings nor digits.
pub(super) fn scales(a: MatRef<'_, f64>, classes: &[Vec<usize>]) -> Vec<i64> {
    let n = a.nrows();
    let mut exponents = vec![0; n];
    if n == 1 {
        return exponents;
    }
    let mut logs = vec![f64::NEG_INFINITY; n * n];
    for (j, column) in a.col_iter().enumerate() {
        for (i, entry) in column.iter().enumerate().filter(|(_, x)| **x != 0.0) {
            logs[i * n + j] = entry.abs().log2();
        }
    }
    let log = |i: usize, j: usize| logs[i * n + j];
    for class in classes.iter().filter(|class| class.len() > 1) {
        balance(class, &log, &mut exponents);
    }
    // 1 at least: what is below costs nothing; and with steps of t through d classes comes t^d/d!, which is not to
    // fall below what its digits are counted from.
    let inside = classes.iter().map(|class| largest(class, &log, &exponents));
    let steps = (classes.len() as f64 / std::f64::consts::E).log2().max(0.0);
    let top = inside.fold(steps, f64::max);
    let mut earlier: Vec<usize> = Vec::new();
    for class in classes {
        let mut shift = 0;
        for j in class {
            for i in &earlier {
                let room = top - log(*i, *j);
                if room < f64::INFINITY {
                    shift = shift.min(room.floor() as i64 + exponents[*i] - exponents[*j]);
                }
            }
        }
        class.iter().for_each(|j| exponents[*j] += shift);
        earlier.extend(class);
    }
    exponents
}

/// The logarithm of the largest entry within the class.
fn largest(class: &[usize], log: &impl Fn(usize, usize) -> f64, exponents: &[i64]) -> f64 {
    let rows = class.iter().map(|i| row(class, *i, log, exponents));
    let diagonal = class.iter().map(|i| log(*i, *i));
    rows.chain(diagonal).fold(f64::NEG_INFINITY, f64::max)
}

/// The logarithm of the largest entry of the row within the class, off the diagonal.
fn row(class: &[usize], i: usize, log: &impl Fn(usize, usize) -> f64, exponents: &[i64]) -> f64 {
    let others = class.iter().filter(|j| **j != i);
    let entries = others.map(|j| log(i, *j) + (exponents[*j] - exponents[i]) as f64);
    entries.fold(f64::NEG_INFINITY, f64::max)
}

/// Makes rows and columns of a class alike, where that halves its largest entry.
fn balance(class: &[usize], log: &impl Fn(usize, usize) -> f64, exponents: &mut [i64]) {
    const ROUNDS: usize = 100;
    let before = largest(class, log, exponents);
    for _ in 0..ROUNDS {
        let mut settled = true;
        for i in class {
            let from = row(class, *i, log, exponents);
            let others = class.iter().filter(|j| *j != i);
            let entries = others.map(|j| log(*j, *i) + (exponents[*i] - exponents[*j]) as f64);
            let to = entries.fold(f64::NEG_INFINITY, f64::max);
            // Towards 0, so that nothing goes to and fro.
            let shift = (0.5 * (from - to)) as i64;
            if shift != 0 {
                exponents[*i] += shift;
                settled = false;
            }
        }
        if settled {
            break;
        }
    }
    if largest(class, log, exponents) > before - 1.0 {
        class.iter().for_each(|i| exponents[*i] = 0);
    }
}
