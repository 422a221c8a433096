//! Linear functions of the state, with bounds of their errors.

use eigentone_digits::{Magnitude, Real};
use eigentone_response::KnownVector;

/// More than the rounding of any bound in doubles: bounds are multiplied by it.
pub(crate) const SLACK: f64 = 1.0 + 1e-9;

/// A linear function of ζ.
#[derive(Clone, Debug)]
pub(crate) struct Row<T> {
    pub(crate) entries: Vec<T>,
    /// The same, rounded.
    pub(crate) rounded: Vec<f64>,
    /// A bound of its 2-norm.
    pub(crate) norm: f64,
    /// A bound of its error in the 2-norm.
    pub(crate) error: f64,
}

impl<T: Real> Row<T> {
    pub(crate) fn of(entries: Vec<T>, error: f64) -> Row<T> {
        let rounded: Vec<f64> = entries.iter().map(|entry| entry.to_f64()).collect();
        Row {
            norm: length(&rounded) * SLACK + error,
            entries,
            rounded,
            error,
        }
    }

    /// One that is known, with the constant added to the state.
    pub(crate) fn with_constant((mut entries, error): KnownVector<T>, constant: T) -> Row<T> {
        entries.push(constant);
        Row::of(entries, upper(error))
    }

    /// A sum of multiples, by exact factors.
    pub(crate) fn sum(parts: &[(f64, &Row<T>)]) -> Row<T> {
        let length = parts[0].1.entries.len();
        let mut entries = vec![T::ZERO; length];
        let mut size = 0.0;
        let mut error = 0.0;
        for &(factor, row) in parts.iter().filter(|(factor, _)| *factor != 0.0) {
            T::add_multiple(&mut entries, T::from(factor), &row.entries);
            size += factor.abs() * row.norm;
            error += factor.abs() * row.error;
        }
        let rounding = unit::<T>() * (parts.len() + 1) as f64 * size;
        Row::of(entries, (error + rounding) * SLACK)
    }

    /// The same with a constant added.
    pub(crate) fn plus_constant(&self, constant: T) -> Row<T> {
        let mut entries = self.entries.clone();
        let last = entries.last_mut().expect("the constant");
        *last = *last + constant;
        let rounding = unit::<T>() * last.to_f64().abs();
        Row::of(entries, (self.error + rounding) * SLACK)
    }

    /// Whether it is 0 in every state.
    pub(crate) fn is_nothing(&self) -> bool {
        self.error == 0.0 && self.entries.iter().all(|entry| entry.is_zero())
    }

    /// Its value, without a bound.
    pub(crate) fn at(&self, zeta: &[T]) -> T {
        dot(&self.entries, zeta)
    }

    /// What is not known of its value at a state of this length, apart from the error of the state.
    pub(crate) fn own_error(&self, size: f64) -> f64 {
        let rounding = unit::<T>() * (self.entries.len() + 2) as f64 * self.norm;
        (self.error + rounding) * size * SLACK
    }
}

/// Σ aᵢ bᵢ.
pub(crate) fn dot<T: Real>(a: &[T], b: &[T]) -> T {
    let products = a
        .iter()
        .zip(b)
        .filter(|(a, b)| !a.is_zero() && !b.is_zero());
    products.fold(T::ZERO, |sum, (a, b)| sum + *a * *b)
}

/// The 2-norm, rounded.
pub(crate) fn length(vector: &[f64]) -> f64 {
    let largest = vector
        .iter()
        .fold(0.0f64, |largest, entry| largest.max(entry.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return largest;
    }
    let squares = vector
        .iter()
        .map(|entry| (entry / largest) * (entry / largest));
    largest * squares.sum::<f64>().sqrt()
}

/// The relative error of one operation.
pub(crate) fn unit<T: Real>() -> f64 {
    2f64.powi(T::UNIT_LOG2)
}

/// As a double, not below it.
pub(crate) fn upper(size: Magnitude) -> f64 {
    size.to_f64() * SLACK
}
