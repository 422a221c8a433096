//! Which outputs do not follow a support that wanders, decided exactly.
//!
//! A support whose velocity or acceleration has power down to frequency 0 wanders without end. At low frequencies the system
//! follows its displacement u with x = r u + r₁u′ + …, where K r + K_s = 0 and K r₁ + C r + C_s = 0, whatever the masses.

use eigentone_digits::{BallMatrix, Magnitude, Real, Wide};
use eigentone_modes::MatrixKind;

use crate::problem::Source;
use crate::state_space::asked::Asked;

/// Of one input: what follows the displacement of its support at low frequencies.
struct Static {
    /// r, of coordinates and supports; empty where it is not known exactly.
    shares: Vec<f64>,
    /// Whether r₁ = 0.
    undamped: bool,
}

/// By output, then by input: whether it is proven to follow nothing of [u/s², u/s].
pub(super) fn settled(asked: &Asked<'_>) -> Vec<Vec<[bool; 2]>> {
    let all: Vec<Static> = (0..asked.channels.len())
        .map(|input| Static::of(asked, input))
        .collect();
    let none = Vec::new();
    let of = |source: &Source, order: usize| {
        let terms = |k: usize| k.checked_sub(order).map_or(&none, |k| &source.terms[k]);
        let with = |(input, at): (usize, &Static)| match asked.channels[input].integrals {
            0 => [true, true],
            1 => [true, at.follows_nothing(terms(0))],
            _ => {
                let rates = at.undamped || terms(0).is_empty();
                let once = rates && at.follows_nothing(terms(1));
                [at.follows_nothing(terms(0)), once]
            }
        };
        all.iter().enumerate().map(with).collect()
    };
    let motions = asked.sources.iter().map(|source| of(source, 0));
    let rates = asked.sources.iter().map(|source| of(source, 1));
    motions.chain(rates).collect()
}

impl Static {
    fn of(asked: &Asked<'_>, input: usize) -> Static {
        let (system, channel) = (asked.system, &asked.channels[input]);
        let n = system.len();
        let unknown = Static {
            shares: Vec::new(),
            undamped: false,
        };
        let (Some(support), 1..) = (channel.support, channel.integrals) else {
            return unknown;
        };
        let mut stiffness = BallMatrix::<Wide<4>>::zeros(n, n);
        for term in system.terms(MatrixKind::Stiffness) {
            stiffness.add(term.row, term.column, term.value.into(), Magnitude::ZERO);
        }
        let mut pull = BallMatrix::zeros(n, 1);
        for (row, force) in &channel.directions[0] {
            pull.add(*row, 0, (*force).into(), Magnitude::ZERO);
        }
        let Some(solved) = stiffness.solve(&pull) else {
            return unknown;
        };
        let mut shares: Vec<f64> = (0..n).map(|i| solved.middle(i, 0).to_f64()).collect();
        let kinds = [MatrixKind::Stiffness, MatrixKind::Damping];
        let mut both = kinds.iter().zip(&channel.directions);
        let mut unstretched = || {
            let (kind, forces) = both.next()?;
            let mut sums = vec![Vec::new(); n];
            for term in system.terms(*kind) {
                sums[term.row].push([term.value, shares[term.column], 1.0]);
            }
            for (row, force) in forces {
                sums[*row].push([-force, 1.0, 1.0]);
            }
            sums.into_iter()
                .all(|sum| vanishes(sum) == Some(true))
                .then_some(())
        };
        if unstretched().is_none() {
            return unknown;
        }
        let undamped = unstretched().is_some();
        let own = |s: usize| f64::from(u8::from(s == support));
        shares.extend((0..system.supports().len()).map(own));
        Static { shares, undamped }
    }

    fn follows_nothing(&self, terms: &[(usize, [f64; 2])]) -> bool {
        let products = terms
            .iter()
            .map(|&(i, [a, b])| Some([a, b, *self.shares.get(i)?]));
        let products: Option<Vec<[f64; 3]>> = products.collect();
        products.and_then(vanishes) == Some(true)
    }
}

/// Whether a sum of products is 0, decided exactly: it is an expansion of doubles that do not overlap (Shewchuk 1997, *Discrete
/// Comput. Geom.* 18), of which none is left. `None` where products leave the range in which their errors are doubles.
fn vanishes(products: impl IntoIterator<Item = [f64; 3]>) -> Option<bool> {
    let mut parts: Vec<f64> = Vec::new();
    for [a, b, c] in products {
        for factor in two_product(a, b)? {
            for mut term in two_product(factor, c)? {
                let mut kept = Vec::new();
                for part in parts {
                    let sum = term + part;
                    let back = sum - term;
                    let error = (term - (sum - back)) + (part - back);
                    kept.extend((error != 0.0).then_some(error));
                    term = sum;
                }
                kept.extend((term != 0.0).then_some(term));
                parts = kept;
            }
        }
    }
    parts
        .iter()
        .all(|part| part.is_finite())
        .then_some(parts.is_empty())
}

/// a·b as its rounded value and the rest.
fn two_product(a: f64, b: f64) -> Option<[f64; 2]> {
    let product = a * b;
    let inside = (1e-290..1e300).contains(&product.abs()) || a == 0.0 || b == 0.0 || b == 1.0;
    inside.then_some([product, a.mul_add(b, -product)])
}
