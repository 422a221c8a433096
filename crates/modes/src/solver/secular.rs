//! The roots of a system with few dampers, all at once, without a matrix of 2n states.
//!
//! In the coordinates of the undamped modes, (λ²I + Ω² + λUUᵀ)q = 0 with U (n × r), its roots are
//! those of det(I + λUᵀ(λ² + Ω²)⁻¹U)·det(λ² + Ω²) (Taslaman 2014, *Algorithms and theory for
//! polynomial eigenproblems*, on low-rank damping), a determinant of order r for O(nr²). They are
//! found together by the iteration of Ehrlich and Aberth (Bini & Noferini 2013, *Lin. Alg. Appl.*
//! 439, for matrix polynomials), each as the distance δ from one of the poles iω_k, so that light
//! damping keeps its digits. With that pole's share taken out of the matrix, B + a·uuᵀ/δ,
//!
//! det(I + …)(λ − iω_k) = det B·g, g = δ + a·uᵀB⁻¹u, a = λ/(λ + iω_k),
//!
//! which has no pole there. That none is missing is seen by the discs of Smith 1970 (*J. ACM* 17)
//! about the points found: if no two touch, each holds one root.

use num_complex::Complex;

use super::cluster::within;

/// A root λ = i·base + δ; its conjugate is understood unless it is `single`.
#[derive(Clone, Copy, Debug)]
struct Point {
    base: f64,
    delta: Complex<f64>,
    /// k.
    pole: usize,
    single: bool,
    settled: bool,
}

/// One root with Im λ ≥ 0, and the amplitudes of the undamped modes in its shape.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    pub(crate) value: Complex<f64>,
    pub(crate) amplitudes: Vec<Complex<f64>>,
}

/// ω_j > 0, and the rows of U with the products of their entries.
pub(crate) struct Secular {
    omega: Vec<f64>,
    rows: Vec<Vec<f64>>,
    /// u_a·u_b for a ≥ b, row after row.
    products: Vec<f64>,
    /// ‖u‖² of each row.
    weights: Vec<f64>,
    rank: usize,
}

/// What is known of the determinant at a point.
struct Value {
    /// The derivative of the logarithm of the determinant.
    slope: Complex<f64>,
    /// det B·g.
    determinant: Complex<f64>,
    /// The pole whose mode may have the largest amplitude there.
    pole: usize,
    /// w, which the matrix nearly annuls at a root.
    direction: Vec<Complex<f64>>,
    /// Whether that is B⁻¹u, since g is what vanishes, or B is singular by itself.
    closed: bool,
}

impl Point {
    fn value(&self) -> Complex<f64> {
        Complex::new(self.delta.re, self.base + self.delta.im)
    }

    /// λ − iω.
    fn above(&self, omega: f64) -> Complex<f64> {
        Complex::new(self.delta.re, (self.base - omega) + self.delta.im)
    }

    /// λ + iω.
    fn below(&self, omega: f64) -> Complex<f64> {
        Complex::new(self.delta.re, (self.base + omega) + self.delta.im)
    }

    /// λ − μ.
    fn minus(&self, other: &Point) -> Complex<f64> {
        let im = (self.base - other.base) + (self.delta.im - other.delta.im);
        Complex::new(self.delta.re - other.delta.re, im)
    }

    /// λ − μ̄.
    fn minus_conjugate(&self, other: &Point) -> Complex<f64> {
        let im = (self.base + other.base) + (self.delta.im + other.delta.im);
        Complex::new(self.delta.re - other.delta.re, im)
    }

    /// Ready to move again, and off the real axis, where a pair could not form.
    fn unsettle(&mut self) {
        self.settled = self.delta == Complex::ZERO;
        if self.single && self.base == 0.0 {
            self.delta *= Complex::cis(1e-3);
        }
    }

    /// The same λ by its distance from the pole if that is near, else from 0.
    fn seen_from(&mut self, pole: usize, omega: f64) {
        let value = self.value();
        let delta = self.above(omega);
        self.pole = pole;
        if delta.norm() < 0.5 * value.norm() {
            (self.base, self.delta) = (omega, delta);
        } else {
            (self.base, self.delta) = (0.0, value);
        }
    }
}

impl Secular {
    /// From the frequencies, all positive, and a row of U for each.
    pub(crate) fn new(omega: Vec<f64>, rows: Vec<Vec<f64>>) -> Secular {
        let rank = rows.first().map_or(0, Vec::len);
        let products = rows
            .iter()
            .flat_map(|u| (0..rank).flat_map(move |a| (0..=a).map(move |b| u[a] * u[b])));
        Secular {
            products: products.collect(),
            weights: rows.iter().map(|u| u.iter().map(|u| u * u).sum()).collect(),
            omega,
            rows,
            rank,
        }
    }

    /// All roots; `None` where the iteration does not show them apart from each other.
    ///
    /// Strong dampers are reached through weaker ones, from where each undamped mode hardly feels the
    /// others: their roots are far from what it has by itself.
    pub(crate) fn roots(&self) -> Option<Vec<Found>> {
        const LIGHT: f64 = 0.5;
        const STAGE: f64 = 8.0;
        const ROUGH: f64 = 1e-3;
        const FINE: f64 = 1e-7;
        let ratios = self.omega.iter().zip(&self.weights);
        let heaviest = ratios
            .map(|(omega, weight)| weight / omega)
            .fold(0.0, f64::max);
        let mut share = 1.0;
        while share * heaviest > LIGHT {
            share /= STAGE;
        }
        let mut points = self.scaled(share).start();
        while share < 1.0 {
            self.scaled(share).settle(&mut points, ROUGH)?;
            share *= STAGE;
            points.iter_mut().for_each(Point::unsettle);
        }
        self.settle(&mut points, FINE)?;
        self.collect(&points)
    }

    /// The same with all dampers weaker.
    fn scaled(&self, share: f64) -> Secular {
        let times = |x: &f64| share * x;
        let root = share.sqrt();
        let row = |row: &Vec<f64>| row.iter().map(|u| root * u).collect();
        Secular {
            omega: self.omega.clone(),
            rows: self.rows.iter().map(row).collect(),
            products: self.products.iter().map(times).collect(),
            weights: self.weights.iter().map(times).collect(),
            rank: self.rank,
        }
    }

    /// Moves all points until their steps are `near` 0, relative to their distance from the pole.
    fn settle(&self, points: &mut Vec<Point>, near: f64) -> Option<()> {
        const SWEEPS: usize = 40;
        /// Sweeps after which a pair may part.
        const PATIENCE: usize = 6;
        for sweep in 1..=SWEEPS {
            let mut moved = false;
            for i in 0..points.len() {
                if !points[i].settled {
                    self.step(points, i, near)?;
                    moved = true;
                }
            }
            if !moved {
                return Some(());
            }
            if sweep % PATIENCE == 0 {
                part(points);
            }
        }
        None
    }

    /// The roots that each undamped mode has by itself, to first order in the damping.
    fn start(&self) -> Vec<Point> {
        let modes = self.omega.iter().zip(&self.weights).enumerate();
        let points = modes.map(|(j, (omega, weight))| Point {
            base: *omega,
            delta: Complex::from(-0.5 * weight),
            pole: j,
            single: false,
            settled: *weight == 0.0,
        });
        points.collect()
    }

    /// Moves point i by the step of Ehrlich and Aberth.
    fn step(&self, points: &mut [Point], i: usize, near: f64) -> Option<()> {
        let point = points[i];
        let value = self.at(&point)?;
        let mut others = Complex::ZERO;
        for (j, other) in points.iter().enumerate() {
            if j != i {
                others += point.minus(other).inv();
            }
            if !other.single {
                others += point.minus_conjugate(other).inv();
            }
        }
        let step = (value.slope - others).inv();
        if value.determinant == Complex::ZERO {
            points[i].settled = true;
            return Some(());
        }
        if !step.is_finite() {
            return None;
        }
        let point = &mut points[i];
        // No farther than to the size of the point itself: the start is of the right one.
        let size = point.value().norm();
        let step = step * (size / step.norm()).min(1.0);
        point.settled = step.norm() <= near * point.delta.norm();
        point.delta -= step;
        point.seen_from(value.pole, self.omega[value.pole]);
        Some(())
    }

    fn at(&self, point: &Point) -> Option<Value> {
        const CLOSED: f64 = 1e-6;
        let (k, count) = (point.pole, self.rank * (self.rank + 1) / 2);
        let lambda = point.value();
        let mut matrix = vec![Complex::ZERO; count];
        let mut derivative = vec![Complex::ZERO; count];
        let mut sum = Complex::ZERO;
        let (mut pole, mut most) = (k, 0.0);
        for (j, omega) in self.omega.iter().enumerate() {
            let products = &self.products[j * count..][..count];
            let denominator = point.above(*omega) * point.below(*omega);
            if j == k {
                continue;
            }
            let share = self.weights[j] / denominator.norm_sqr();
            if share > most {
                (pole, most) = (j, share);
            }
            let inverse = denominator.inv();
            sum += inverse;
            let weight = lambda * inverse;
            let change = inverse - weight * weight * 2.0;
            for ((entry, derived), product) in matrix.iter_mut().zip(&mut derivative).zip(products)
            {
                *entry += weight * *product;
                *derived += change * *product;
            }
        }
        let (u, omega) = (&self.rows[k], self.omega[k]);
        let below = point.below(omega);
        let a = lambda / below;
        let slope_of_a = Complex::new(0.0, omega) / (below * below);
        let reduced = Reduced::of(&matrix, &derivative, u)?;
        let g = point.above(omega) + a * reduced.form;
        // The other mode that may have the largest amplitude, where w gives this one 1/λ.
        let size: f64 = reduced.direction.iter().map(|w| w.norm_sqr()).sum();
        if most * size * lambda.norm_sqr() <= 1.0 {
            pole = k;
        }
        let slope_of_g = slope_of_a * reduced.form - a * reduced.derived_form + 1.0;
        let closed = g.norm() <= CLOSED * point.above(omega).norm();
        Some(Value {
            closed,
            slope: slope_of_g / g + reduced.trace + below.inv() + lambda * sum * 2.0,
            determinant: reduced.determinant * g,
            pole,
            direction: if closed {
                reduced.direction
            } else {
                reduced.any
            },
        })
    }

    /// W = P(z_i)/Π(z_i − z_j), which bounds the disc about z_i.
    fn correction(&self, points: &[Point], i: usize, value: &Value) -> f64 {
        let point = &points[i];
        let mut above = Scaled::one();
        above.times(value.determinant);
        for (j, omega) in self.omega.iter().enumerate() {
            above.times(point.below(*omega));
            if j != point.pole {
                above.times(point.above(*omega));
            }
        }
        for (j, other) in points.iter().enumerate() {
            if j != i {
                above.over(point.minus(other));
            }
            if !other.single {
                above.over(point.minus_conjugate(other));
            }
        }
        above.size()
    }

    /// The roots with their amplitudes, if the discs lie apart.
    fn collect(&self, points: &[Point]) -> Option<Vec<Found>> {
        let count = points
            .iter()
            .map(|point| if point.single { 1.0 } else { 2.0 });
        let count: f64 = count.sum();
        let mut points = points.to_vec();
        let values = points.iter_mut().map(|point| self.at_its_own(point));
        let values: Vec<Value> = values.collect::<Option<_>>()?;
        let points = points.as_slice();
        let radius = |i: usize| {
            // Rounding of the determinant moves a root as far as that of g does.
            count * self.correction(points, i, &values[i])
        };
        let radii: Vec<f64> = (0..points.len()).map(radius).collect();
        let mut found = Vec::with_capacity(points.len());
        for (i, point) in points.iter().enumerate() {
            let apart = points.iter().enumerate().all(|(j, other)| {
                let reach = radii[i] + radii[j];
                let touches = |z: Complex<f64>| within(z, reach);
                (j == i || !touches(point.minus(other)))
                    && (other.single || !touches(point.minus_conjugate(other)))
            });
            if !apart || !radii[i].is_finite() {
                return None;
            }
            let mut value = point.value();
            let rounding = 16.0 * f64::EPSILON * value.norm();
            if point.single && value.im.abs() <= radii[i] + rounding {
                value.im = 0.0;
            } else if point.single {
                let partner = points.iter().enumerate().any(|(j, other)| {
                    let reach = radii[i] + radii[j] + rounding;
                    other.single && point.minus_conjugate(other).norm() <= reach
                });
                if !partner {
                    return None;
                }
                if value.im < 0.0 {
                    continue;
                }
            }
            found.push(Found {
                value,
                amplitudes: self.amplitudes(point, &values[i]),
            });
        }
        Some(found)
    }

    /// The determinant, seen from the pole whose mode has the largest amplitude.
    fn at_its_own(&self, point: &mut Point) -> Option<Value> {
        const TRIALS: usize = 4;
        let mut value = self.at(point)?;
        for _ in 0..TRIALS {
            let amplitudes = self.amplitudes(point, &value);
            let size = |j: &usize| amplitudes[*j].norm_sqr();
            let own = (0..amplitudes.len()).max_by(|a, b| size(a).total_cmp(&size(b)))?;
            if own == point.pole {
                break;
            }
            point.seen_from(own, self.omega[own]);
            value = self.at(point)?;
        }
        Some(value)
    }

    /// q = (λ² + Ω²)⁻¹Uw, where for w = B⁻¹u g = 0 makes q_k = −1/λ.
    fn amplitudes(&self, point: &Point, value: &Value) -> Vec<Complex<f64>> {
        let each = self.omega.iter().zip(&self.rows).enumerate();
        each.map(|(j, (omega, u))| {
            if j == point.pole && value.closed {
                return -point.value().inv();
            }
            let drive: Complex<f64> = value.direction.iter().zip(u).map(|(w, u)| w * u).sum();
            drive / (point.above(*omega) * point.below(*omega))
        })
        .collect()
    }
}

/// Pairs that have not settled become single points, which may meet the real axis.
fn part(points: &mut Vec<Point>) {
    let mut partners = Vec::new();
    for point in points.iter_mut().filter(|p| !p.settled && !p.single) {
        let value = point.value();
        point.single = true;
        (point.base, point.delta) = (0.0, value);
        partners.push(Point {
            delta: value.conj() * Complex::cis(1e-3) * 1.01,
            ..*point
        });
    }
    points.extend(partners);
}

/// B = I + matrix, and what its inverse makes of u and of its derivative.
struct Reduced {
    determinant: Complex<f64>,
    /// B⁻¹u.
    direction: Vec<Complex<f64>>,
    /// What B⁻¹ makes of a vector without pattern.
    any: Vec<Complex<f64>>,
    /// uᵀB⁻¹u.
    form: Complex<f64>,
    /// uᵀB⁻¹B′B⁻¹u.
    derived_form: Complex<f64>,
    /// tr B⁻¹B′.
    trace: Complex<f64>,
}

impl Reduced {
    /// By elimination with row interchanges; `None` where B is singular or not finite.
    fn of(matrix: &[Complex<f64>], derivative: &[Complex<f64>], u: &[f64]) -> Option<Reduced> {
        let r = u.len();
        let at = |a: usize, b: usize| {
            if a >= b {
                a * (a + 1) / 2 + b
            } else {
                b * (b + 1) / 2 + a
            }
        };
        // [B | u | a vector without pattern | B′], row by row.
        const GOLDEN_ANGLE: f64 = 2.399963229728653;
        let width = 2 * r + 2;
        let mut rows = vec![Complex::ZERO; r * width];
        for a in 0..r {
            for b in 0..r {
                rows[a * width + b] = matrix[at(a, b)];
                rows[a * width + r + 2 + b] = derivative[at(a, b)];
            }
            rows[a * width + a] += 1.0;
            rows[a * width + r] = Complex::from(u[a]);
            rows[a * width + r + 1] = Complex::cis(GOLDEN_ANGLE * a as f64);
        }
        let mut determinant = Complex::ONE;
        for p in 0..r {
            let size = |row: usize| rows[row * width + p].norm_sqr();
            let pivot = (p..r).max_by(|a, b| size(*a).total_cmp(&size(*b)))?;
            if pivot != p {
                for column in 0..width {
                    rows.swap(p * width + column, pivot * width + column);
                }
                determinant = -determinant;
            }
            let head = rows[p * width + p];
            determinant *= head;
            let inverse = head.inv();
            if !inverse.is_finite() || head == Complex::ZERO {
                return None;
            }
            for column in p..width {
                rows[p * width + column] *= inverse;
            }
            for row in (0..r).filter(|row| *row != p) {
                let factor = rows[row * width + p];
                for column in p..width {
                    let product = factor * rows[p * width + column];
                    rows[row * width + column] -= product;
                }
            }
        }
        let column = |at: usize| (0..r).map(move |a| a * width + at);
        let direction: Vec<Complex<f64>> = column(r).map(|at| rows[at]).collect();
        let form = direction.iter().zip(u).map(|(w, u)| w * u).sum();
        // B is symmetric: uᵀB⁻¹ is the direction too.
        let mut derived_form = Complex::ZERO;
        for a in 0..r {
            for b in 0..r {
                derived_form += direction[a] * derivative[at(a, b)] * direction[b];
            }
        }
        Some(Reduced {
            determinant,
            form,
            derived_form,
            trace: (0..r).map(|a| rows[a * width + r + 2 + a]).sum(),
            direction,
            any: column(r + 1).map(|at| rows[at]).collect(),
        })
    }
}

/// The size of a product that may leave the range of doubles on its way.
struct Scaled {
    square: f64,
    exponent: i64,
}

impl Scaled {
    fn one() -> Scaled {
        Scaled {
            square: 1.0,
            exponent: 0,
        }
    }

    fn times(&mut self, factor: Complex<f64>) {
        self.square *= factor.norm_sqr();
        self.tidy();
    }

    fn over(&mut self, divisor: Complex<f64>) {
        self.square /= divisor.norm_sqr();
        self.tidy();
    }

    fn tidy(&mut self) {
        if !(1e-100..1e100).contains(&self.square) && self.square > 0.0 && self.square.is_finite() {
            let exponent = self.square.log2().round();
            self.square *= (-exponent).exp2();
            self.exponent += exponent as i64;
        }
    }

    fn size(&self) -> f64 {
        self.square.sqrt() * (0.5 * self.exponent as f64).exp2()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All roots, conjugates included.
    fn all(found: &[Found]) -> Vec<Complex<f64>> {
        let both = found
            .iter()
            .flat_map(|root| [root.value, root.value.conj()]);
        let mut roots: Vec<Complex<f64>> = Vec::new();
        for root in both {
            if root.im != 0.0 || roots.last() != Some(&root) {
                roots.push(root);
            }
        }
        roots
    }

    #[test]
    fn modes_that_nothing_couples_keep_their_quadratics() {
        let omega = vec![1.0, 2.0, 3.0, 4.0];
        let damping: [f64; 4] = [1e-40, 0.5, 7.0, 1e4];
        let row = |i: usize| {
            let entry = |j: usize| if i == j { damping[i].sqrt() } else { 0.0 };
            (0..4).map(entry).collect()
        };
        let found = Secular::new(omega.clone(), (0..4).map(row).collect()).roots();
        let found = all(&found.expect("they lie apart"));
        assert_eq!(found.len(), 8);
        for (omega, c) in omega.into_iter().zip(damping) {
            let sum = Complex::from(c * c - 4.0 * omega * omega).sqrt() + c;
            let large = -sum / 2.0;
            for root in [large, large.inv() * omega * omega] {
                let met = |other: &&Complex<f64>| {
                    let tight = (*other - root).norm() <= 1e-13 * root.norm();
                    tight && (other.re - root.re).abs() <= 1e-13 * root.re.abs()
                };
                let count = found.iter().filter(met).count();
                assert_eq!(count, 1, "{root}");
            }
        }
    }

    /// Two dampers that couple twenty modes: −Σλ = tr UUᵀ and Πλ = det Ω², whatever their strength.
    #[test]
    fn all_roots_are_found_by_their_sum_and_product() {
        const N: usize = 20;
        let omega: Vec<f64> = (0..N).map(|j| 1.0 + 0.37 * j as f64).collect();
        for strength in [1e-6, 1e-2, 1.0, 1e2, 1e6] {
            let entry = |j: usize, a: usize| ((1 + a) as f64 * (0.3 + j as f64)).sin();
            let row = |j| vec![strength * entry(j, 0), strength * entry(j, 1)];
            let rows: Vec<Vec<f64>> = (0..N).map(row).collect();
            let trace: f64 = rows.iter().flatten().map(|u| u * u).sum();
            let found = Secular::new(omega.clone(), rows).roots();
            let found = all(&found.expect("they lie apart"));
            assert_eq!(found.len(), 2 * N);
            let sum: f64 = found.iter().map(|root| root.re).sum();
            assert!(
                (sum + trace).abs() <= 1e-12 * trace,
                "{strength}: {sum} {trace}"
            );
            let product: f64 = found.iter().map(|root| root.norm().ln()).sum();
            let known: f64 = omega.iter().map(|omega| 2.0 * omega.ln()).sum();
            assert!(
                (product - known).abs() <= 1e-8,
                "{strength}: {product} {known}"
            );
        }
    }
}
