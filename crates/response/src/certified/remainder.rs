//! How far a motion may be from the polynomials of degree five through its ends, at most.

use eigentone_digits::product;
use faer::Mat;

use super::products::multiply;
use crate::exponential::Growth;

/// What bounds the sixth derivatives of quantities x = cᵀζ, ζ′ = Wζ, over any stretch: x⁽⁶⁾ = cᵀW³ · W³ζ, and W³ζ goes on as ζ
/// does. In energy coordinates, in which no state of a passive system grows, so much of a fast oscillation counts as it has in the
/// motion and shows in the quantity.
///
/// A polynomial of degree five through value and two derivatives at both ends of a stretch of length h is within h⁶/46080 of a
/// function with a sixth derivative of at most 1, and its slope within √5 h⁵/30000 (Birkhoff & Priver 1967, *Hermite
/// interpolation errors for derivatives*, J. Math. and Phys. 46).
pub(super) struct Remainder {
    /// W³ by rows.
    cube: Vec<f64>,
    /// The 2-norms of cᵀW³ by quantities, for states and for loads.
    norms: Vec<[f64; 2]>,
    states: usize,
    /// How fast states, and how fast loads may grow by themselves.
    growths: [Growth; 2],
    /// What loads of size 1 do to states in a second, at most.
    push: f64,
    /// How far W³ζ may be off by rounding, beside ζ.
    lost: f64,
}

impl Remainder {
    /// Of so many quantities whose second derivatives are these rows times ζ, by rows, for W by rows, of which so many entries are
    /// states.
    pub(super) fn of(count: usize, second: &[f64], w: &[f64], states: usize) -> Remainder {
        let size = w.len().isqrt();
        let w = Mat::from_fn(size, size, |i, j| w[i * size + j]);
        let second = Mat::from_fn(count, size, |i, j| second[i * size + j]);
        // ‖|W|‖₂ is at most √(‖W‖₁‖W‖_∞).
        let sum = |total: f64, entry: &f64| total + entry.abs();
        let columns = w.col_iter().map(|column| column.iter().fold(0.0, sum));
        let rows = w.row_iter().map(|row| row.iter().fold(0.0, sum));
        let norm = (columns.fold(0.0, f64::max) * rows.fold(0.0, f64::max)).sqrt();
        let rounding = 4.0 * size as f64 * f64::EPSILON;
        let third = product(second.as_ref(), w.as_ref());
        let norms = third.row_iter().zip(second.row_iter());
        let norms = norms.map(|(third, second)| {
            let off = rounding * norm * second.norm_l2();
            let (states, loads) = third.transpose().split_at_row(states);
            [states, loads].map(|part| part.norm_l2() + off)
        });
        let cube = product(product(w.as_ref(), w.as_ref()).as_ref(), w.as_ref());
        let (within, push, _, alone) = w.split_at(states, states);
        Remainder {
            cube: (0..size * size)
                .map(|at| cube[(at / size, at % size)])
                .collect(),
            norms: norms.collect(),
            states,
            growths: [within, alone].map(Growth::of),
            push: push.norm_l2(),
            lost: rounding * norm.powi(3),
        }
    }

    /// How large the states, and how large the loads of W³ζ are at most on a stretch of this length that begins with this ζ.
    pub(super) fn sizes(&self, length: f64, zeta: &[f64]) -> [f64; 2] {
        let mut third = vec![0.0; zeta.len()];
        multiply(&self.cube, zeta, &mut third);
        let norm = |part: &[f64]| part.iter().map(|x| x * x).sum::<f64>().sqrt();
        let off = self.lost * norm(zeta);
        let (states, loads) = third.split_at(self.states);
        let [growth, growth_alone] = self.growths.each_ref().map(|growth| growth.until(length));
        let loads = growth_alone * (norm(loads) + off);
        let states = growth * (norm(states) + off + length * self.push * loads);
        [states, loads]
    }

    /// How far each quantity, and how far its slope may be off on a stretch of this length within one of these sizes.
    pub(super) fn along(
        &self,
        length: f64,
        [states, loads]: [f64; 2],
    ) -> impl Fn(usize) -> [f64; 2] {
        /// More than rounding takes from sums of what is not negative.
        const ROUNDING: f64 = 1.0 + 1e-9;
        let share = ROUNDING * length.powi(5);
        move |i| {
            let [of_states, of_loads] = self.norms[i];
            let sixth = of_states * states + of_loads * loads;
            let slope = share * 5f64.sqrt() / 30000.0;
            [share * length / 46080.0 * sixth, slope * sixth]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::certified::quintic::Quintic;

    /// Of x = ½ sin 3t + A sin 2t, which 5A sin 2t pushes, x″ = −9x + 5A sin 2t, from 3x, x′ and the load.
    #[test]
    fn what_a_polynomial_misses_is_bounded_and_not_by_much_more() {
        for amplitude in [0.0, 0.3, 20.0] {
            let push = 5.0 * amplitude;
            let w = [
                [0.0, 3.0, 0.0, 0.0],
                [-3.0, 0.0, push, 0.0],
                [0.0, 0.0, 0.0, 2.0],
                [0.0, 0.0, -2.0, 0.0],
            ];
            let remainder = Remainder::of(1, &[-3.0, 0.0, push, 0.0], w.as_flattened(), 2);
            for (from, length) in [(0.0, 0.6), (0.3, 0.2), (1.1, 0.02)] {
                let knot = |t: f64| {
                    let [own, forced] =
                        [(0.5, 3.0), (amplitude, 2.0)].map(|(size, omega): (f64, f64)| {
                            let (sine, cosine) = (omega * t).sin_cos();
                            [
                                size * sine,
                                size * omega * cosine,
                                -size * omega * omega * sine,
                            ]
                        });
                    [0, 1, 2].map(|order| own[order] + forced[order])
                };
                let polynomial = Quintic::between(knot(from), knot(from + length), length);
                let missed = |k: usize| {
                    let s = f64::from(k as u32) / 64.0;
                    let [x, v, _] = knot(from + s * length);
                    let slope = polynomial.slope().at(s) / length;
                    [(polynomial.at(s) - x).abs(), (slope - v).abs()]
                };
                let most = (0..=64).map(missed).fold([0.0f64; 2], |most, missed| {
                    [0, 1].map(|order| most[order].max(missed[order]))
                });
                let [x, v, _] = knot(from);
                let (sine, cosine) = (2.0 * from).sin_cos();
                let sizes = remainder.sizes(length, &[3.0 * x, v, sine, cosine]);
                let off = remainder.along(length, sizes)(0);
                let rounding = 1e-14 * (1.0 + amplitude) / length;
                for (off, most) in off.into_iter().zip(most) {
                    assert!(most <= off + rounding, "{length}: {most:e} {off:e}");
                    assert!(off <= 40.0 * most + rounding, "{length}: {most:e} {off:e}");
                }
            }
        }
    }
}
