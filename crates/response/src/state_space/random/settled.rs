//! Which outputs do not follow a support that wanders, decided exactly.
//!
//! A support whose velocity or acceleration has power down to frequency 0 wanders without end. At low frequencies the system
//! follows its displacement u with x = r u + r₁u′ + …, where K r + K_s = 0 and K r₁ + C r + C_s = 0, whatever the masses. For a regular K
//! an output c x + d u follows nothing of u where [K K_s; c d] is singular, for its determinant is |K|(d + c r). So is what a velocity
//! adds to it that of K, C and K once more.

use eigentone_modes::{MatrixKind, is_singular};

use crate::problem::Source;
use crate::state_space::asked::Asked;

/// Entries of a matrix, each a sum without rounding.
type Parts = Vec<(usize, usize, f64)>;

/// By output, then by input: whether it follows nothing of [u/s², u/s]; `None` where that is not decided.
pub(super) fn settled(asked: &Asked<'_>) -> Vec<Vec<[Option<bool>; 2]>> {
    let n = asked.system.len();
    let integrates = asked.channels.iter().any(|channel| channel.integrals > 0);
    let regular = integrates && is_singular(n, stiffness(asked, 0, 0)) == Some(false);
    let of = |source: &Source, order: usize| {
        // What is read of x and of x′.
        let terms = |k: usize| k.checked_sub(order).map_or(&[][..], |k| &source.terms[k]);
        let read = [terms(0), terms(1)];
        let with = |input: usize| match asked.channels[input].integrals {
            0 => [Some(true); 2],
            1 => [
                Some(true),
                follows_nothing(asked, regular, input, &read[..1]),
            ],
            _ => [1, 2].map(|count| follows_nothing(asked, regular, input, &read[..count])),
        };
        (0..asked.channels.len()).map(with).collect()
    };
    let motions = asked.sources.iter().map(|source| of(source, 0));
    let rates = asked.sources.iter().map(|source| of(source, 1));
    motions.chain(rates).collect()
}

/// K with its first entry there.
fn stiffness(asked: &Asked<'_>, row: usize, column: usize) -> Parts {
    let terms = asked.system.terms(MatrixKind::Stiffness);
    terms
        .map(|term| (row + term.row, column + term.column, term.value))
        .collect()
}

/// Of what is read of x, and of x′ beside it, the last that the support's displacement makes: d + c r, or d + c r₁ + c′r.
fn follows_nothing(
    asked: &Asked<'_>,
    regular: bool,
    input: usize,
    read: &[&[(usize, [f64; 2])]],
) -> Option<bool> {
    if read.iter().all(|terms| terms.is_empty()) {
        return Some(true);
    }
    if !regular {
        return None;
    }
    let (n, channel) = (asked.system.len(), &asked.channels[input]);
    let last = read.len() * n;
    let mut parts = Parts::new();
    for (at, directions) in channel.directions[..read.len()].iter().enumerate() {
        parts.extend(stiffness(asked, at * n, at * n));
        parts.extend(
            directions
                .iter()
                .map(|(row, force)| (at * n + row, last, -force)),
        );
    }
    if read.len() > 1 {
        let terms = asked.system.terms(MatrixKind::Damping);
        parts.extend(terms.map(|term| (n + term.row, term.column, term.value)));
    }
    // What is read of the k-th derivative meets r in the first columns, r₁ in the next.
    for (order, terms) in read.iter().rev().enumerate() {
        for &(i, [a, b]) in *terms {
            let column = match i.checked_sub(n) {
                None => order * n + i,
                // Of the support itself the last derivative alone.
                Some(support) if Some(support) == channel.support && order == 0 => last,
                Some(_) => continue,
            };
            parts.extend(two_product(a, b)?.map(|factor| (last, column, factor)));
        }
    }
    is_singular(last + 1, parts)
}

/// a·b as its rounded value and the rest.
fn two_product(a: f64, b: f64) -> Option<[f64; 2]> {
    let product = a * b;
    let inside = (1e-290..1e300).contains(&product.abs()) || a == 0.0 || b == 0.0 || b == 1.0;
    inside.then_some([product, a.mul_add(b, -product)])
}
