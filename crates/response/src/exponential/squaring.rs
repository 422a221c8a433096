//! Squarings that keep small motions and never leave the range of doubles.

use super::algebra::Explicit;
use super::growth::Growth;
use super::norm::{column_sums, largest};

/// x·2^exponent.
pub(super) struct Extended<E> {
    pub(super) element: E,
    pub(super) exponent: i64,
}

/// A column of E of less than this norm is kept whole, since E − I would cancel there.
const SMALL: f64 = 0.7;

/// Norms between the inverse of this and this can be squared twice.
pub(super) const LARGE: f64 = 1e70;

/// So many squarings still leave digits: 2^-53 · 2^45 is small.
pub(super) const MEANINGFUL: u32 = 45;

/// e^{2^s A} from E − I for E = e^A, by s squarings; `growth` bounds e^{2^s A t}.
///
/// What is carried is D = E − S, where S is diagonal with entries 0 and 1, doubled as SD + DS + D².
/// At first S = I: what moves slowly beside something fast then keeps its digits, and squarings that
/// were not needed do no harm. Where a column of E becomes small, the 1 would cancel and is given up:
/// what decays then keeps its digits too. Once S = 0, a power of two is kept apart, so that
/// nothing overflows or underflows before the end.
pub(super) fn square<G: Explicit>(
    algebra: &mut G,
    mut element: G::Element,
    squarings: u32,
    growth: impl FnOnce() -> Growth,
) -> Extended<G::Element> {
    let n = algebra.order();
    let growth = (squarings > MEANINGFUL).then(growth);
    let mut ones = vec![1.0; n];
    let mut exponent = 0i64;
    for done in 1..=squarings {
        let sums = column_sums(n, G::value(&element));
        give_up::<G>(&mut element, &mut ones, |j, entry| {
            sums[j] - entry.abs() + (entry + 1.0).abs() < SMALL
        });
        let norm = largest(&sums);
        if norm > LARGE || (norm < 1.0 / LARGE && !ones.contains(&1.0)) {
            give_up::<G>(&mut element, &mut ones, |_, _| true);
            exponent = exponent.saturating_add(normalise::<G>(&mut element, norm));
        }
        let next = if ones.contains(&1.0) {
            let sum = algebra.twice(&element, &ones);
            algebra.multiply_add(sum, &element, &element)
        } else {
            algebra.multiply(&element, &element)
        };
        algebra.recycle(std::mem::replace(&mut element, next));
        exponent = exponent.saturating_mul(2);
        if let Some(growth) = growth {
            let time = 0.5f64.powi((squarings - done) as i32);
            // It may be infinite, where the exponential is 0 beyond any doubt.
            let excess = growth.excess(G::value(&element), &ones, exponent, time);
            let excess = excess.min(1e18);
            if excess > 0.0 {
                give_up::<G>(&mut element, &mut ones, |_, _| true);
                G::rescale(&mut element, (-excess.fract()).exp2());
                exponent = exponent.saturating_sub(excess as i64);
            }
        }
    }
    give_up::<G>(&mut element, &mut ones, |_, _| true);
    Extended { element, exponent }
}

/// Moves those ones of S into D whose entry of D is chosen.
fn give_up<G: Explicit>(
    element: &mut G::Element,
    ones: &mut [f64],
    choose: impl Fn(usize, f64) -> bool,
) {
    let n = ones.len();
    let diagonal = G::value_mut(element).iter_mut().step_by(n + 1);
    for (j, (entry, one)) in diagonal.zip(ones).enumerate() {
        if *one == 1.0 && choose(j, *entry) {
            *entry += 1.0;
            *one = 0.0;
        }
    }
}

/// Scales an element of this norm by a power of two to a norm of about 1; returns the exponent that
/// was taken out.
fn normalise<G: Explicit>(element: &mut G::Element, norm: f64) -> i64 {
    if norm == 0.0 || !norm.is_finite() {
        return 0;
    }
    let exponent = norm.log2().floor();
    // Two factors: one alone may be out of range.
    let half = (exponent / 2.0).floor();
    G::rescale(element, (-half).exp2());
    G::rescale(element, (half - exponent).exp2());
    exponent as i64
}
