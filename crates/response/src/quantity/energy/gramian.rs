//! e^A and ∫₀¹ e^{Aᵀt} Q e^{At} dt by Taylor's series over a short time and doubling.
//!
//! With E(t) = e^{At} and P(t) = ∫₀ᵗ e^{Aᵀs} Q e^{As} ds, E(2t) = E(t)² and
//! P(2t) = P(t) + E(t)ᵀ P(t) E(t) (the doubling of Smith 1968, *SIAM J. Appl. Math.* 16). The block
//! exponential of [−Aᵀ Q; 0 A] (Van Loan 1978, *IEEE Trans. Autom. Control* 23) has e^{−Aᵀt} in it
//! and overflows where a fast motion decays; doubling does not, and for Q ⪰ 0 it only adds terms
//! that are ⪰ 0.

use eigentone_digits::Real;

/// A square matrix, by rows.
#[derive(Clone, Debug)]
pub(super) struct Square<T> {
    pub(super) n: usize,
    pub(super) entries: Vec<T>,
}

impl<T: Real> Square<T> {
    pub(super) fn zeros(n: usize) -> Square<T> {
        Square {
            n,
            entries: vec![T::ZERO; n * n],
        }
    }

    fn identity(n: usize) -> Square<T> {
        let mut identity = Square::zeros(n);
        for i in 0..n {
            identity.entries[i * n + i] = T::ONE;
        }
        identity
    }

    fn times(&self, other: &Square<T>) -> Square<T> {
        let mut product = Square::zeros(self.n);
        for (row, into) in self.rows().zip(product.entries.chunks_mut(self.n.max(1))) {
            for (factor, with) in row.iter().zip(other.rows()) {
                if !factor.is_zero() {
                    for (sum, entry) in into.iter_mut().zip(with) {
                        *sum = *sum + *factor * *entry;
                    }
                }
            }
        }
        product
    }

    fn transposed(&self) -> Square<T> {
        let n = self.n;
        let entries = (0..n * n).map(|at| self.entries[at % n * n + at / n]);
        Square {
            n,
            entries: entries.collect(),
        }
    }

    /// Adds factor·other.
    fn add(&mut self, factor: T, other: &Square<T>) {
        for (sum, entry) in self.entries.iter_mut().zip(&other.entries) {
            *sum = *sum + factor * *entry;
        }
    }

    fn rows(&self) -> impl Iterator<Item = &[T]> {
        self.entries.chunks(self.n.max(1))
    }

    /// self·v.
    pub(super) fn apply(&self, vector: &[T]) -> Vec<T> {
        self.rows().map(|row| dot(row, vector)).collect()
    }

    /// row·self.
    pub(super) fn before(&self, row: &[T]) -> Vec<T> {
        let mut product = vec![T::ZERO; self.n];
        for (factor, with) in row.iter().zip(self.rows()) {
            if !factor.is_zero() {
                for (sum, entry) in product.iter_mut().zip(with) {
                    *sum = *sum + *factor * *entry;
                }
            }
        }
        product
    }

    /// vᵀ·self·v.
    pub(super) fn form(&self, vector: &[T]) -> T {
        dot(vector, &self.apply(vector))
    }

    /// The largest sum of absolute values in a row or a column, in double.
    fn norm(&self) -> f64 {
        let sum = |entries: &mut dyn Iterator<Item = &T>| -> f64 {
            entries.map(|entry| entry.to_f64().abs()).sum()
        };
        let n = self.n;
        let rows = self.rows().map(|row| sum(&mut row.iter()));
        let columns = (0..n).map(|j| sum(&mut self.entries.iter().skip(j).step_by(n)));
        rows.chain(columns).fold(0.0, f64::max)
    }
}

/// Σ a_i b_i.
pub(super) fn dot<T: Real>(a: &[T], b: &[T]) -> T {
    let products = a
        .iter()
        .zip(b)
        .filter(|(a, b)| !a.is_zero() && !b.is_zero());
    products.fold(T::ZERO, |sum, (a, b)| sum + *a * *b)
}

/// e^A, and ∫₀¹ e^{Aᵀt} Q e^{At} dt for each Q, a symmetric matrix.
pub(super) fn gramians<T: Real, const COUNT: usize>(
    a: &Square<T>,
    q: [Square<T>; COUNT],
) -> (Square<T>, [Square<T>; COUNT]) {
    // Over so short a time that ‖A‖t ≤ ¼, terms fall by half and more.
    let norm = a.norm();
    let halvings = if norm > 0.25 && norm.is_finite() {
        norm.log2().ceil() as i64 + 2
    } else {
        0
    };
    let scaled = |matrix: &Square<T>| Square {
        n: matrix.n,
        entries: matrix.entries.iter().map(|x| x.scale(-halvings)).collect(),
    };
    let a = scaled(a);
    let down = a.transposed();
    let terms = (1 - i64::from(T::UNIT_LOG2)) as usize;
    let mut exponential = Square::identity(a.n);
    let mut power = Square::identity(a.n);
    let mut factor = 1.0;
    for index in 1..terms {
        power = power.times(&a);
        factor *= index as f64;
        let last = power.norm() / factor;
        exponential.add(T::ONE / factorial(index), &power);
        if last < T::unit().to_f64() {
            break;
        }
    }
    let mut integrals = q.map(|q| integral(scaled(&q), &a, &down));
    for _ in 0..halvings {
        let back = exponential.transposed();
        for integral in &mut integrals {
            let moved = back.times(integral).times(&exponential);
            integral.add(T::ONE, &moved);
        }
        exponential = exponential.times(&exponential);
    }
    (exponential, integrals)
}

/// Σ L_k/(k+1)! with L₀ = Q and L_k = Aᵀ L_{k−1} + L_{k−1} A, for ‖A‖ ≤ ¼.
fn integral<T: Real>(q: Square<T>, a: &Square<T>, down: &Square<T>) -> Square<T> {
    let enough = q.norm() * T::unit().to_f64();
    let mut term = q.clone();
    let mut sum = q;
    let mut index = 1;
    let mut size = 1.0;
    while term.norm() > enough * size {
        let mut next = down.times(&term);
        next.add(T::ONE, &term.times(a));
        term = next;
        index += 1;
        size *= index as f64;
        sum.add(T::ONE / factorial(index), &term);
    }
    sum
}

/// k! in the precision of T.
fn factorial<T: Real>(k: usize) -> T {
    (2..=k).fold(T::ONE, |product, i| product * T::from(i as f64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_digits::DoubleDouble;

    fn square<T: Real>(rows: [[f64; 2]; 2]) -> Square<T> {
        Square {
            n: 2,
            entries: rows.concat().into_iter().map(T::from).collect(),
        }
    }

    /// ∫₀¹ of a decaying exponential, squared: (1 − e^{−2λ})/2λ, for slow and fast decay, with the
    /// block exponential far beyond overflow.
    #[test]
    fn decay_of_any_rate() {
        let a = square::<DoubleDouble>([[-1e-3, 0.0], [0.0, -1e6]]);
        let q = square([[1.0, 0.0], [0.0, 1.0]]);
        let (exponential, [p]) = gramians(&a, [q]);
        let slow = -(-2e-3f64).exp_m1() / 2e-3;
        assert!((p.entries[0].to_f64() / slow - 1.0).abs() < 4.0 * f64::EPSILON);
        assert!((p.entries[3].to_f64() / 5e-7 - 1.0).abs() < 4.0 * f64::EPSILON);
        assert!((exponential.entries[0].to_f64() - (-1e-3f64).exp()).abs() < f64::EPSILON);
        assert_eq!(exponential.entries[3].to_f64(), 0.0);
    }

    /// x″ + ω²x = 0 from x = 1: ∫ v² = ω²/2 − ω sin(2ω)/4, ∫ xv = (cos²ω − 1)/2.
    #[test]
    fn a_vibration_of_many_turns() {
        let omega = 1000.0f64;
        let a = square::<DoubleDouble>([[0.0, 1.0], [-omega * omega, 0.0]]);
        let velocity = square([[0.0, 0.0], [0.0, 1.0]]);
        let product = square([[0.0, 0.5], [0.5, 0.0]]);
        let (_, [vv, xv]) = gramians(&a, [velocity, product]);
        let exact = omega * omega / 2.0 - omega * (2.0 * omega).sin() / 4.0;
        assert!((vv.entries[0].to_f64() / exact - 1.0).abs() < 4.0 * f64::EPSILON);
        let exact = (omega.cos().powi(2) - 1.0) / 2.0;
        assert!((xv.entries[0].to_f64() - exact).abs() < 4.0 * f64::EPSILON);
    }

    #[test]
    fn doubles_and_more_digits_agree() {
        let rows = [[0.5, 2.0], [-3.0, -0.25]];
        let q = [[1.0, 0.5], [0.5, 2.0]];
        let (e, [p]) = gramians(&square::<f64>(rows), [square(q)]);
        let (exact, [integral]) = gramians(&square::<DoubleDouble>(rows), [square(q)]);
        for at in 0..4 {
            assert!((e.entries[at] - exact.entries[at].to_f64()).abs() < 1e-14);
            assert!((p.entries[at] - integral.entries[at].to_f64()).abs() < 1e-14);
        }
    }
}
