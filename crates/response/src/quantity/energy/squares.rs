//! M, C or K of coordinates and supports together as squares, of which nothing cancels where all move alike.

use std::collections::BTreeMap;

use eigentone_digits::{DoubleDouble, Real};
use eigentone_modes::{MatrixKind, System};

/// Σ aᵢ xᵢ² + Σ bᵢⱼ (xᵢ − xⱼ)² over the coordinates and then the supports, the quadratic form of a matrix: of a network of
/// springs and dampers each is one element.
pub(super) struct Squares<T> {
    single: Vec<(usize, T)>,
    between: Vec<(usize, usize, T)>,
}

impl<T: Real> Squares<T> {
    pub(super) fn of(system: &System, kind: MatrixKind) -> Squares<T> {
        let n = system.len();
        let mut rows = vec![DoubleDouble::ZERO; n + system.supports().len()];
        let mut between = BTreeMap::new();
        // Half of an entry and half of the one across the diagonal.
        let mut add = |row: usize, column: usize, half: f64| {
            let half = DoubleDouble::from(half);
            rows[row] += half;
            rows[column] += half;
            if row != column {
                let pair = (row.min(column), row.max(column));
                *between.entry(pair).or_insert(DoubleDouble::ZERO) += -half;
            }
        };
        for term in system.terms(kind) {
            add(term.row, term.column, term.value / 2.0);
        }
        for term in system.coupling(kind) {
            add(term.row, n + term.column, term.value);
        }
        for term in system.between_supports(kind) {
            add(n + term.row, n + term.column, term.value / 2.0);
        }
        let known = |value: DoubleDouble| T::from(value.high()) + T::from(value.low());
        let single = rows.into_iter().enumerate();
        let single = single.filter(|(_, value)| !value.is_zero());
        let pairs = between.into_iter().filter(|(_, value)| !value.is_zero());
        Squares {
            single: single.map(|(i, value)| (i, known(value))).collect(),
            between: pairs.map(|((i, j), value)| (i, j, known(value))).collect(),
        }
    }

    /// Calls `visit` with each coefficient, and the places between which it acts; the second is absent for the ground.
    pub(super) fn each(&self, mut visit: impl FnMut(T, usize, Option<usize>)) {
        for &(i, value) in &self.single {
            visit(value, i, None);
        }
        for &(i, j, value) in &self.between {
            visit(value, i, Some(j));
        }
    }

    /// The form of a motion.
    pub(super) fn form(&self, x: &[T]) -> T {
        let mut sum = T::ZERO;
        self.each(|value, i, j| {
            let stretch = j.map_or(x[i], |j| x[i] - x[j]);
            sum = sum + value * stretch * stretch;
        });
        sum
    }

    /// Calls `visit` with all that acts on one place: each coefficient, and the other place.
    pub(super) fn on(&self, place: usize, mut visit: impl FnMut(T, Option<usize>)) {
        self.each(|value, i, j| match j {
            _ if i == place => visit(value, j),
            Some(j) if j == place => visit(value, Some(i)),
            _ => {}
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_modes::GROUND;

    /// A lever to a support and a damping matrix with a skew part: the squares are those that elements make, and what
    /// turns takes nothing.
    #[test]
    fn squares_are_those_of_the_elements() {
        let skew = faer::mat![[0.5, 3.0], [-3.0, 0.0]];
        let system = System::builder()
            .mass("x", 1.0)
            .mass("y", 1.0)
            .support("s")
            .point("p", [("x", 0.5), ("s", 0.25)], 8.0)
            .spring("y", "p", 4.0)
            .spring("s", GROUND, 2.0)
            .matrix(MatrixKind::Damping, skew.as_ref())
            .build()
            .expect("a system");
        let at = [3.0, -1.0, 2.0];
        let form = |kind| Squares::<f64>::of(&system, kind).form(&at);
        assert_eq!(form(MatrixKind::Stiffness), 4.0 * 9.0 + 2.0 * 4.0);
        assert_eq!(form(MatrixKind::Mass), 9.0 + 1.0 + 8.0 * 4.0);
        assert_eq!(form(MatrixKind::Damping), 0.5 * 9.0);
        // What pulls at the support is half of the slope.
        let squares = Squares::<f64>::of(&system, MatrixKind::Stiffness);
        let mut pull = 0.0;
        squares.on(2, |value, j| {
            pull += value * (at[2] - j.map_or(0.0, |j| at[j]))
        });
        assert_eq!(pull, 4.0 * 3.0 * 0.25 + 2.0 * 2.0);
    }
}
