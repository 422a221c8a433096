//! Matrices that carry their derivative in one direction along.

use super::algebra::{Algebra, Explicit};
use super::aligned::Aligned;
use super::dense::Dense;

/// X + εX′ with ε² = 0, so that (X + εX′)(Y + εY′) = XY + ε(X′Y + XY′).
pub(super) struct Dual {
    dense: Dense,
}

/// A matrix and its derivative.
pub(super) struct Pair {
    pub(super) value: Aligned,
    pub(super) derivative: Aligned,
}

impl Dual {
    pub(super) fn new(n: usize) -> Dual {
        Dual {
            dense: Dense::new(n),
        }
    }
}

impl Algebra for Dual {
    type Element = Pair;

    fn combine<const SUMS: usize>(&mut self, terms: [&[(f64, &Pair)]; SUMS]) -> [Pair; SUMS] {
        terms.map(|terms| {
            let mut part = |part: fn(&Pair) -> &Aligned| {
                let terms: Vec<_> = terms.iter().map(|(factor, x)| (*factor, part(x))).collect();
                let [sum] = self.dense.combine([&terms]);
                sum
            };
            Pair {
                value: part(|pair| &pair.value),
                derivative: part(|pair| &pair.derivative),
            }
        })
    }

    fn multiply_add(&mut self, sum: Pair, x: &Pair, y: &Pair) -> Pair {
        let derivative = self
            .dense
            .multiply_add(sum.derivative, &x.derivative, &y.value);
        Pair {
            value: self.dense.multiply_add(sum.value, &x.value, &y.value),
            derivative: self.dense.multiply_add(derivative, &x.value, &y.derivative),
        }
    }

    fn multiply(&mut self, x: &Pair, y: &Pair) -> Pair {
        let derivative = self.dense.multiply(&x.derivative, &y.value);
        Pair {
            value: self.dense.multiply(&x.value, &y.value),
            derivative: self.dense.multiply_add(derivative, &x.value, &y.derivative),
        }
    }

    fn recycle(&mut self, element: Pair) {
        self.dense.recycle(element.value);
        self.dense.recycle(element.derivative);
    }
}

impl Explicit for Dual {
    fn order(&self) -> usize {
        self.dense.order()
    }

    fn value(element: &Pair) -> &[f64] {
        &element.value
    }

    fn rescale(element: &mut Pair, factor: f64) {
        Dense::rescale(&mut element.value, factor);
        Dense::rescale(&mut element.derivative, factor);
    }

    fn value_mut(element: &mut Pair) -> &mut [f64] {
        &mut element.value
    }

    fn twice(&mut self, x: &Pair, s: &[f64]) -> Pair {
        Pair {
            value: self.dense.twice(&x.value, s),
            derivative: self.dense.twice(&x.derivative, s),
        }
    }
}
