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

use std::ops::Range;

use num_complex::Complex;
use pulp::Arch;

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
    /// How far off it may be, as an estimate.
    pub(crate) radius: f64,
}

/// ω_j > 0, and the rows of U with the products of their entries.
pub(crate) struct Secular {
    omega: Vec<f64>,
    rows: Vec<Vec<f64>>,
    /// u_a·u_b of all rows, for each a ≥ b.
    products: Vec<Vec<f64>>,
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
        let pairs = (0..rank).flat_map(|a| (0..=a).map(move |b| (a, b)));
        let products = pairs.map(|(a, b)| rows.iter().map(|u| u[a] * u[b]).collect());
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
            products: self
                .products
                .iter()
                .map(|each| each.iter().map(times).collect())
                .collect(),
            weights: self.weights.iter().map(times).collect(),
            rank: self.rank,
        }
    }

    /// Moves all points until their steps are `near` 0, relative to their distance from the pole.
    fn settle(&self, points: &mut Vec<Point>, near: f64) -> Option<()> {
        const SWEEPS: usize = 40;
        /// Sweeps after which a pair may part.
        const PATIENCE: usize = 6;
        let mut shares = Shares::new(self.omega.len());
        for sweep in 1..=SWEEPS {
            let mut moved = false;
            let mut repulsion = Repulsion::of(points);
            for (i, point) in points.iter_mut().enumerate() {
                if !point.settled {
                    let others = repulsion.on(i, point);
                    self.step(point, others, near, &mut shares)?;
                    repulsion.moved(i, point);
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

    /// Moves a point by the step of Ehrlich and Aberth, the others repelling it.
    fn step(
        &self,
        point: &mut Point,
        others: Complex<f64>,
        near: f64,
        shares: &mut Shares,
    ) -> Option<()> {
        let value = self.at(point, shares)?;
        let step = (value.slope - others).inv();
        if value.determinant == Complex::ZERO {
            point.settled = true;
            return Some(());
        }
        if !step.is_finite() {
            return None;
        }
        // No farther than to the size of the point itself: the start is of the right one.
        let size = point.value().norm();
        let step = step * (size / step.norm()).min(1.0);
        point.settled = step.norm() <= near * point.delta.norm();
        point.delta -= step;
        point.seen_from(value.pole, self.omega[value.pole]);
        Some(())
    }

    fn at(&self, point: &Point, shares: &mut Shares) -> Option<Value> {
        const CLOSED: f64 = 1e-6;
        let k = point.pole;
        let lambda = point.value();
        let arch = Arch::new();
        let sum = arch.dispatch(|| shares.fill(point, &self.omega, &self.weights));
        shares.matrix.clear();
        shares.derivative.clear();
        for products in &self.products {
            let [entry, derived] = arch.dispatch(|| shares.dot(products));
            shares.matrix.push(entry);
            shares.derivative.push(derived);
        }
        let most = shares.largest.iter().copied().fold(0.0, f64::max);
        let at = shares.largest.iter().position(|share| *share == most);
        let mut pole = at.filter(|_| most > 0.0).unwrap_or(k);
        let (u, omega) = (&self.rows[k], self.omega[k]);
        let below = point.below(omega);
        let a = lambda / below;
        let slope_of_a = Complex::new(0.0, omega) / (below * below);
        let reduced = Reduced::of(&shares.matrix, &shares.derivative, u)?;
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
        let own = |j: usize| j == point.pole;
        let mut quotient = Scaled::one();
        quotient.times(value.determinant.norm_sqr());
        for j in 0..self.omega.len().max(points.len()) {
            // Both are near 1 in most cases: few products leave the range of doubles.
            let mut factor = self.omega.get(j).map_or(1.0, |omega| {
                let above = point.above(*omega).norm_sqr();
                point.below(*omega).norm_sqr() * if own(j) { 1.0 } else { above }
            });
            if let Some(other) = points.get(j) {
                if j != i {
                    factor /= point.minus(other).norm_sqr();
                }
                if !other.single {
                    factor /= point.minus_conjugate(other).norm_sqr();
                }
            }
            quotient.times(factor);
        }
        quotient.size()
    }

    /// The roots with their amplitudes, if the discs lie apart.
    fn collect(&self, points: &[Point]) -> Option<Vec<Found>> {
        let count = points
            .iter()
            .map(|point| if point.single { 1.0 } else { 2.0 });
        let count: f64 = count.sum();
        let mut points = points.to_vec();
        let mut shares = Shares::new(self.omega.len());
        let values = points
            .iter_mut()
            .map(|point| self.at_its_own(point, &mut shares));
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
                radius: radii[i] + rounding,
            });
        }
        Some(found)
    }

    /// The determinant, seen from the pole whose mode has the largest amplitude.
    fn at_its_own(&self, point: &mut Point, shares: &mut Shares) -> Option<Value> {
        const TRIALS: usize = 4;
        let mut value = self.at(point, shares)?;
        for _ in 0..TRIALS {
            let amplitudes = self.amplitudes(point, &value);
            let size = |j: &usize| amplitudes[*j].norm_sqr();
            let own = (0..amplitudes.len()).max_by(|a, b| size(a).total_cmp(&size(b)))?;
            if own == point.pole {
                break;
            }
            point.seen_from(own, self.omega[own]);
            value = self.at(point, shares)?;
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

/// What each undamped mode adds to the determinant at a point, apart from that of the point's pole.
struct Shares {
    /// λ/(λ² + ω²).
    weight: [Vec<f64>; 2],
    /// Its derivative.
    change: [Vec<f64>; 2],
    /// ‖u‖²/|λ² + ω²|².
    largest: Vec<f64>,
    matrix: Vec<Complex<f64>>,
    derivative: Vec<Complex<f64>>,
}

/// Sums that are added up side by side.
const LANES: usize = 8;

impl Shares {
    fn new(n: usize) -> Shares {
        let zeros = || [vec![0.0; n], vec![0.0; n]];
        Shares {
            weight: zeros(),
            change: zeros(),
            largest: vec![0.0; n],
            matrix: Vec::new(),
            derivative: Vec::new(),
        }
    }

    /// Takes the point, and returns Σ1/(λ² + ω²).
    #[inline(always)]
    fn fill(&mut self, point: &Point, omega: &[f64], weights: &[f64]) -> Complex<f64> {
        let n = omega.len();
        let lambda = point.value();
        let [wr, wi] = &mut self.weight;
        let [cr, ci] = &mut self.change;
        let (wr, wi, cr, ci) = (&mut wr[..n], &mut wi[..n], &mut cr[..n], &mut ci[..n]);
        let (largest, weights) = (&mut self.largest[..n], &weights[..n]);
        // λ² + ω² = (λ − iω)(λ + iω), each without cancellation.
        let (re, base, im) = (point.delta.re, point.base, point.delta.im);
        for j in 0..n {
            let (above, below) = ((base - omega[j]) + im, (base + omega[j]) + im);
            let (dr, di) = (re * re - above * below, re * (above + below));
            let square = dr * dr + di * di;
            let (ir, ii) = (dr / square, -di / square);
            // The derivatives hold the inverses for now.
            (cr[j], ci[j]) = (ir, ii);
            wr[j] = lambda.re * ir - lambda.im * ii;
            wi[j] = lambda.re * ii + lambda.im * ir;
            largest[j] = weights[j] / square;
        }
        for list in [&mut *wr, &mut *wi, &mut *cr, &mut *ci, &mut *largest] {
            list[point.pole] = 0.0;
        }
        let sum = Complex::new(total(cr), total(ci));
        for j in 0..n {
            cr[j] -= 2.0 * (wr[j] * wr[j] - wi[j] * wi[j]);
            ci[j] -= 4.0 * wr[j] * wi[j];
        }
        sum
    }

    /// The sums of weights and changes, each times its factor.
    #[inline(always)]
    fn dot(&self, factors: &[f64]) -> [Complex<f64>; 2] {
        let n = factors.len();
        let lists = [
            &self.weight[0],
            &self.weight[1],
            &self.change[0],
            &self.change[1],
        ];
        let mut sums = [[0.0; LANES]; 4];
        let whole = n - n % LANES;
        for start in (0..whole).step_by(LANES) {
            let factors: &[f64; LANES] = factors[start..start + LANES]
                .try_into()
                .expect("as many as lanes");
            for (sum, list) in sums.iter_mut().zip(lists) {
                let list = &list[start..start + LANES];
                for lane in 0..LANES {
                    sum[lane] += list[lane] * factors[lane];
                }
            }
        }
        for j in whole..n {
            for (sum, list) in sums.iter_mut().zip(lists) {
                sum[j - whole] += list[j] * factors[j];
            }
        }
        let [wr, wi, cr, ci] = sums.map(|sum| sum.iter().sum::<f64>());
        [Complex::new(wr, wi), Complex::new(cr, ci)]
    }
}

#[inline(always)]
fn total(list: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let (whole, rest) = list.as_chunks::<LANES>();
    for chunk in whole {
        for lane in 0..LANES {
            sums[lane] += chunk[lane];
        }
    }
    for (sum, entry) in sums.iter_mut().zip(rest) {
        *sum += entry;
    }
    sums.iter().sum()
}

/// The points side by side, for the sums of 1/(z_i − z_j).
struct Repulsion {
    base: Vec<f64>,
    re: Vec<f64>,
    im: Vec<f64>,
    /// 1 where the conjugate is understood, else 0.
    paired: Vec<f64>,
}

impl Repulsion {
    fn of(points: &[Point]) -> Repulsion {
        let list = |part: fn(&Point) -> f64| points.iter().map(part).collect();
        Repulsion {
            base: list(|point| point.base),
            re: list(|point| point.delta.re),
            im: list(|point| point.delta.im),
            paired: list(|point| if point.single { 0.0 } else { 1.0 }),
        }
    }

    fn moved(&mut self, i: usize, point: &Point) {
        (self.base[i], self.re[i], self.im[i]) = (point.base, point.delta.re, point.delta.im);
    }

    /// Σ1/(z_i − z_j) over all other points and all conjugates.
    fn on(&self, i: usize, point: &Point) -> Complex<f64> {
        let own = if point.single {
            Complex::ZERO
        } else {
            point.minus_conjugate(point).inv()
        };
        let last = self.base.len();
        let arch = Arch::new();
        let part = |range: Range<usize>| arch.dispatch(|| self.sum(range, point));
        own + part(0..i) + part(i + 1..last)
    }

    #[inline(always)]
    fn sum(&self, range: Range<usize>, point: &Point) -> Complex<f64> {
        let (base, re, im) = (
            &self.base[range.clone()],
            &self.re[range.clone()],
            &self.im[range.clone()],
        );
        let paired = &self.paired[range];
        let mut sums = [[0.0; LANES]; 2];
        let mut add = |lane: usize, j: usize| {
            let x = point.delta.re - re[j];
            let y = (point.base - base[j]) + (point.delta.im - im[j]);
            let below = (point.base + base[j]) + (point.delta.im + im[j]);
            let inverse = 1.0 / (x * x + y * y);
            let conjugate = paired[j] / (x * x + below * below);
            sums[0][lane] += x * inverse + x * conjugate;
            sums[1][lane] -= y * inverse + below * conjugate;
        };
        let n = base.len();
        let whole = n - n % LANES;
        for start in (0..whole).step_by(LANES) {
            for lane in 0..LANES {
                add(lane, start + lane);
            }
        }
        for j in whole..n {
            add(j - whole, j);
        }
        let [re, im] = sums.map(|sum| sum.iter().sum::<f64>());
        Complex::new(re, im)
    }
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

    /// By a size, squared.
    fn times(&mut self, factor: f64) {
        self.square *= factor;
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
            let off = (sum + trace).abs();
            assert!(off <= 1e-12 * trace, "{strength}: {sum} {trace}");
            let product: f64 = found.iter().map(|root| root.norm().ln()).sum();
            let known: f64 = omega.iter().map(|omega| 2.0 * omega.ln()).sum();
            let off = (product - known).abs();
            assert!(off <= 1e-8, "{strength}: {product} {known}");
        }
    }
}
