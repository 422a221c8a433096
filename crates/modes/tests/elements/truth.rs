//! All roots of det(λ²M + λC + K) with proven radii, from the matrices alone: Weierstrass' iteration on banded determinants
//! in 320 bits (Smith 1970, *J. ACM* 17).

use std::ops::Range;

use eigentone_digits::{Real, Wide, WideComplex};
use eigentone_modes::{Bounds, Modes, Precision};
use num_complex::Complex;

use crate::mesh::Model;

type Number = WideComplex<Wide<5>>;

/// Roots, each in the disc of its radius.
struct Roots {
    centres: Vec<Number>,
    radii: Vec<f64>,
}

/// From approximations of all of them, in the same order, and how far these may be off. Those given as 0 stay near it.
fn roots(model: &Model, approximations: &[Complex<f64>], reach: &[f64]) -> Roots {
    const STEPS: usize = 40;
    const ENOUGH: f64 = 1e-20;
    let sizes = approximations.iter().map(|z| z.norm());
    let largest = sizes.fold(0.0, f64::max);
    let may_be_real =
        |i: usize| approximations[i].im != 0.0 && reach[i] >= approximations[i].norm();
    let half_way = Complex::from_polar(1.0, std::f64::consts::FRAC_PI_4);
    // Approximations with one value start on a circle wider than these are uncertain, so that the first steps stay near.
    let mut points: Vec<Number> = approximations
        .iter()
        .enumerate()
        .map(|(i, z)| {
            let alike = |range: Range<usize>| range.filter(|j| approximations[*j] == *z).count();
            let (rank, count) = (alike(0..i), alike(0..approximations.len()));
            let reach = if z.norm() == 0.0 {
                1e-25 * largest
            } else {
                let times = if count > 1 { 8.0 } else { 0.5 };
                (times * reach[i]).clamp(1e-22 * z.norm(), 1e-3 * z.norm())
            };
            let angle = 0.4 + std::f64::consts::TAU * rank as f64 / count as f64;
            let turn = Complex::from_polar(reach, angle);
            // A pair that may be two real roots is as near to these.
            let z = if may_be_real(i) { z * half_way } else { *z };
            Number::new(z.re, z.im) + Number::new(turn.re, turn.im)
        })
        .collect();
    // Conjugates are computed once.
    let conjugate = |i: usize| {
        let before = approximations[..i].iter();
        let rank = before.filter(|z| **z == approximations[i]).count();
        let mut each =
            (0..approximations.len()).filter(|j| approximations[*j] == approximations[i].conj());
        each.nth(rank)
            .filter(|_| approximations[i].im < 0.0 && !may_be_real(i))
    };
    let conjugate: Vec<Option<usize>> = (0..points.len()).map(conjugate).collect();
    let mirror = |points: &mut [Number]| {
        for (i, other) in conjugate.iter().enumerate() {
            if let Some(other) = other {
                points[i] = points[*other].conj();
            }
        }
    };
    mirror(&mut points);
    // det M, or where roots are infinite what the determinant is so far out that all others count for nothing.
    let leading = if points.len() == 2 * model.order() {
        model.determinant(Number::ZERO, true)
    } else {
        const FAR: f64 = 1e60;
        let far = Number::new(FAR * largest, 0.0);
        let inverse = Number::new(1.0, 0.0) / far;
        points
            .iter()
            .fold(model.determinant(far, false), |product, _| {
                product * inverse
            })
    };
    let correction = |points: &[Number], i: usize| {
        let others = points.iter().enumerate().filter(|(j, _)| *j != i);
        let product = others.fold(leading, |product, (_, other)| {
            product * (points[i] - *other)
        });
        model.determinant(points[i], false) / product
    };
    let mut open: Vec<usize> = (0..points.len())
        .filter(|i| approximations[*i].norm() > 0.0 && conjugate[*i].is_none())
        .collect();
    for _ in 0..STEPS {
        let moves: Vec<Number> = open.iter().map(|i| correction(&points, *i)).collect();
        for (i, w) in open.iter().zip(&moves) {
            points[*i] = points[*i] - *w;
        }
        mirror(&mut points);
        let sizes = open.iter().zip(&moves);
        open = sizes
            .filter(|(i, w)| w.norm() > ENOUGH * approximations[**i].norm())
            .map(|(i, _)| *i)
            .collect();
    }
    let count = points.len() as f64;
    let radius = |i: usize| match conjugate[i] {
        Some(_) => 0.0,
        None => count * correction(&points, i).norm() * 1.001,
    };
    let known: Vec<f64> = (0..points.len()).map(radius).collect();
    let own: Vec<f64> = (0..points.len())
        .map(|i| known[conjugate[i].unwrap_or(i)])
        .collect();
    let distance = |i: usize, j: usize| (points[i] - points[j]).norm();
    // Discs that touch hold their roots together.
    let mut label: Vec<usize> = (0..points.len()).collect();
    for (i, j) in (0..points.len()).flat_map(|i| (0..i).map(move |j| (i, j))) {
        if label[i] != label[j] && distance(i, j) <= own[i] + own[j] {
            let (from, to) = (label[i], label[j]);
            let moved = label.iter_mut().filter(|label| **label == from);
            moved.for_each(|label| *label = to);
        }
    }
    let radius = |i: usize| {
        let together = (0..points.len()).filter(|j| label[*j] == label[i]);
        let reach = together.map(|j| distance(i, j) + own[j]);
        reach.fold(0.0, f64::max)
    };
    Roots {
        radii: (0..points.len()).map(radius).collect(),
        centres: points,
    }
}

/// The modes of a model, proven: right, and in doubles right or without a bound.
pub fn examine(name: &str, model: &Model, tight: f64) -> Modes {
    let modes = model.modes(Precision::default());
    assert_eq!(modes.bounds(), Bounds::Proven, "{name}: {}", modes.plan());
    // What is doubtful in doubles need not be near any root.
    let truth = Truth::of(model, &modes);
    truth.check(name, &modes, tight);
    truth.check(name, &model.modes(Precision::Double), 1.0);
    modes
}

/// Holds modes against the roots of their model.
pub fn check(name: &str, model: &Model, modes: &Modes, tight: f64) {
    Truth::of(model, modes).check(name, modes, tight);
}

/// The roots of a model, and the modes that they were found from.
struct Truth<'a> {
    order: usize,
    near: &'a Modes,
    roots: Roots,
}

impl Truth<'_> {
    fn of<'a>(model: &Model, near: &'a Modes) -> Truth<'a> {
        let starts = near.eigenvalues().iter();
        let (starts, reach): (Vec<_>, Vec<f64>) = starts
            .map(|root| (root.value, root.bound.unwrap_or(0.0)))
            .unzip();
        Truth {
            order: model.order(),
            near,
            roots: roots(model, &starts, &reach),
        }
    }

    /// All roots are there, each within its bound. What is proven is so to `tight` of its size, but for those below 1e-18
    /// of the largest root; what is not is right to 1e-9, within its estimate, or has no bound.
    fn check(&self, name: &str, modes: &Modes, tight: f64) {
        let found = modes.eigenvalues();
        assert_eq!(found.len(), self.near.eigenvalues().len(), "{name}");
        assert_eq!(found.len() + modes.infinite(), 2 * self.order, "{name}");
        let values: Vec<_> = found.iter().map(|root| root.value).collect();
        // Those of one size may stand in another order.
        let mut open: Vec<usize> = (0..found.len()).collect();
        let nearest = |value: &Complex<f64>| {
            let distance = |i: &usize| (self.near.eigenvalues()[open[*i]].value - value).norm();
            let first = (0..open.len()).min_by(|i, j| distance(i).total_cmp(&distance(j)));
            open.remove(first.expect("a root for each"))
        };
        let order: Vec<usize> = values.iter().map(nearest).collect();
        let mut truth = Roots {
            centres: order.iter().map(|i| self.roots.centres[*i]).collect(),
            radii: order.iter().map(|i| self.roots.radii[*i]).collect(),
        };
        // Of roots with one value the nearest is that of the smallest bound.
        for (i, j) in (0..values.len()).flat_map(|i| (0..i).map(move |j| (i, j))) {
            let off = |i: usize| {
                let value = Number::new(values[i].re, values[i].im);
                (value - truth.centres[i]).norm()
            };
            let bound = |i: usize| found[i].bound.unwrap_or(f64::INFINITY);
            if values[i] == values[j] && (bound(i) < bound(j)) != (off(i) < off(j)) {
                truth.centres.swap(i, j);
                truth.radii.swap(i, j);
            }
        }
        for i in 0..found.len() {
            let (value, radius) = (values[i], truth.radii[i]);
            let difference = Number::new(value.re, value.im) - truth.centres[i];
            let (off, off_real) = (difference.norm(), difference.re.to_f64().abs());
            let size = value.norm();
            let smallest = 1e-18 * values.iter().map(|z| z.norm()).fold(0.0, f64::max);
            match (modes.bounds(), found[i].bound, found[i].real_bound) {
                (Bounds::Proven, Some(bound), Some(real_bound)) => {
                    assert!(
                        off <= bound * (1.0 + 1e-9) + radius
                            && off_real <= real_bound * (1.0 + 1e-9) + radius,
                        "{name}: {value} is {off:e} off, real part {off_real:e}; bounds {bound:e} {real_bound:e}, known to {radius:e}"
                    );
                    let is_tight = |bound: f64| bound <= tight * size.max(smallest);
                    assert!(
                        is_tight(bound) && (size == 0.0 || is_tight(radius)),
                        "{name}: {value} has a bound of {bound:e}, known to {radius:e}"
                    );
                }
                (Bounds::Estimated, Some(bound), _) => assert!(
                    off <= bound.max(1e-9 * size) + radius,
                    "{name}: {value} is {off:e} off, estimated {bound:e}, known to {radius:e}"
                ),
                (Bounds::Estimated, None, _) => {}
                other => panic!("{name}: {value} has {other:?}"),
            }
        }
    }
}

impl Model {
    /// det(λ²M + λC + K), or det M, by elimination within the band.
    fn determinant(&self, lambda: Number, of_mass: bool) -> Number {
        let (n, band) = (self.order(), self.band());
        let square = lambda * lambda;
        let width = 2 * band + 1;
        let mut rows = vec![Number::ZERO; n * width];
        for i in 0..n {
            for j in i.saturating_sub(band)..(i + band + 1).min(n) {
                let number = |x: f64| Number::new(x, 0.0);
                let mass = number(self.mass[(i, j)]);
                rows[i * width + j + band - i] = if of_mass {
                    mass
                } else {
                    square * mass
                        + lambda * number(self.damping[(i, j)])
                        + number(self.stiffness[(i, j)])
                };
            }
        }
        let mut product = Number::new(1.0, 0.0);
        for i in 0..n {
            let pivot = rows[i * width + band];
            product = product * pivot;
            for below in i + 1..(i + band + 1).min(n) {
                let at = below * width + i + band - below;
                let factor = rows[at] / pivot;
                if factor == Number::ZERO {
                    continue;
                }
                for j in i + 1..(i + band + 1).min(n) {
                    let taken = factor * rows[i * width + j + band - i];
                    let entry = &mut rows[below * width + j + band - below];
                    *entry = *entry - taken;
                }
            }
        }
        product
    }
}
