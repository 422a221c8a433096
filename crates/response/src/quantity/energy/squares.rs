//! M, C or K of coordinates and supports together as squares, of which nothing cancels where all move alike.

use std::collections::BTreeMap;

use eigentone_digits::{Magnitude, Real};
use eigentone_modes::{MatrixKind, System};

use crate::certified::quadratic::Squares;
use crate::problem::{Known, sum};

/// Σ aᵢ xᵢ² + Σ bᵢⱼ (xᵢ − xⱼ)² over the coordinates and then the supports, the quadratic form of K, and those of M and C for
/// velocities: of a network of springs and dampers each is one element.
pub(super) fn squares<T: Real>(system: &System, kind: MatrixKind) -> Squares<T> {
    let n = system.len();
    let nothing = (T::ZERO, Magnitude::ZERO);
    let mut rows = vec![nothing; n + system.supports().len()];
    let mut between = BTreeMap::new();
    // Half of an entry and half of the one across the diagonal.
    let mut add = |row: usize, column: usize, half: f64| {
        let half = (T::from(half), Magnitude::ZERO);
        for at in [row, column] {
            rows[at] = sum(rows[at], half);
        }
        if row != column {
            let pair = between.entry((row.min(column), row.max(column)));
            let pair = pair.or_insert(nothing);
            *pair = sum(*pair, (-half.0, half.1));
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
    let single = rows.into_iter().enumerate();
    let single = single.map(|(i, factor)| (factor, i, None));
    let pairs = between.into_iter();
    let pairs = pairs.map(|((i, j), factor)| (factor, i, Some(j)));
    let terms = single.chain(pairs);
    let is_any = |&((value, error), ..): &(Known<T>, _, _)| !value.is_zero() || !error.is_zero();
    Squares {
        order: usize::from(kind != MatrixKind::Stiffness),
        terms: terms.filter(is_any).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_digits::DoubleDouble;
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
        let form = |kind| {
            let terms = squares::<DoubleDouble>(&system, kind).terms;
            let each = terms.into_iter().map(|((factor, _), i, j)| {
                let stretch: f64 = at[i] - j.map_or(0.0, |j| at[j]);
                factor.to_f64() * stretch * stretch
            });
            each.sum::<f64>()
        };
        assert_eq!(form(MatrixKind::Stiffness), 4.0 * 9.0 + 2.0 * 4.0);
        assert_eq!(form(MatrixKind::Mass), 9.0 + 1.0 + 8.0 * 4.0);
        assert_eq!(form(MatrixKind::Damping), 0.5 * 9.0);
    }
}
