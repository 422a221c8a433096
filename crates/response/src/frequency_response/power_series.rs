//! Solutions of A(x) y = b(x), for polynomials A and b in x, as power series about a point, with proven bounds: as many
//! coefficients as are asked for, and one bound for all that follow.
//!
//! With x = x₀ + ρt and A = A₀ + tA₁ + t²A₂, the coefficients follow from A₀yₖ = bₖ − A₁yₖ₋₁ − A₂yₖ₋₂. Where
//! G = |A₀⁻¹A₁| + |A₀⁻¹A₂| has q = ‖G‖ < 1 in the largest ratio to some lengths, A is regular for all complex |t| ≤ 1, and |y| there at
//! most (1 − G)⁻¹v with v = |A₀⁻¹b₀| + |A₀⁻¹b₁| + |A₀⁻¹b₂|, so at most z wherever v + Gz ≤ z, entry by entry: behind many masses y is
//! smaller than before them by as many powers as its bound then is, and ‖v‖/(1 − q) is not. A bound of an analytic function on the
//! unit disc bounds all of its coefficients (Cauchy): those that follow, and those that errors of the recursion, which grow from step to
//! step, leave less known. A smaller ρ makes the bound smaller, of functions that fall steeply by much more than their last terms grow.

use eigentone_digits::{Ball, DoubleDouble, Magnitude, WideComplex};
use num_complex::Complex;

use super::elimination::{Factor, Outcome, Row, scaled};
use super::refinement::{UPWARD, largest};

/// A number with bounds.
pub(super) type Number = Ball<DoubleDouble>;

/// The farthest that is looked at about a point, in ρ.
pub(super) const REACH: f64 = 0.4;

/// By powers of x, or of t.
pub(super) type Polynomial = [Number; 3];

/// Row, column and what stands there.
pub(super) type Entry = (usize, usize, Polynomial);

/// The equations about a point.
pub(super) struct Center {
    x: f64,
    /// ρ, a power of two.
    radius: f64,
    factor: Factor<DoubleDouble>,
    /// Powers of two by which rows and columns are divided.
    scales: (Vec<i64>, Vec<i64>),
    /// A₁ and A₂, of scaled rows and columns.
    changes: Vec<(usize, usize, [Number; 2])>,
    lengths: Vec<f64>,
    contraction: f64,
    /// |A₀⁻¹A₁| and |A₀⁻¹A₂|, by rows.
    growth: [Vec<f64>; 2],
}

/// Why there is no centre.
#[derive(Clone, Copy)]
pub(super) enum NoCenter {
    /// The matrix may be singular at the point.
    Singular,
    /// It may be within the radius, and is not within this one.
    TooWide(f64),
}

/// The coefficients of an analytic function of t, and a bound of its size where |t| ≤ 1.
pub(super) struct PowerSeries {
    pub(super) coefficients: Vec<Number>,
    pub(super) largest: Magnitude,
    /// ρ.
    pub(super) radius: f64,
}

impl Center {
    /// About x, with a radius of `least` or more. The second is how many products it took.
    pub(super) fn of(
        n: usize,
        entries: &[Entry],
        x: f64,
        least: f64,
    ) -> (Result<Center, NoCenter>, u64) {
        let local: Vec<Entry> = entries
            .iter()
            .map(|(row, column, polynomial)| (*row, *column, about(polynomial, x)))
            .collect();
        let scales = scales(n, &local);
        let down = |row: usize, column: usize| -(scales.0[row] + scales.1[column]);
        let mut rows = vec![Row::new(); n];
        let mut changes = Vec::new();
        for (row, column, [value, first, second]) in &local {
            let power = down(*row, *column);
            if !value.is_zero() {
                rows[*row].push((*column, scaled(*value, power)));
            }
            if !first.is_zero() || !second.is_zero() {
                let changed = [*first, *second].map(|change| scaled(change, power));
                changes.push((*row, *column, changed));
            }
        }
        for row in &mut rows {
            row.sort_by_key(|entry| entry.0);
        }
        let (outcome, work) = Factor::of(rows);
        let Outcome::Regular(factor) = outcome else {
            return (Err(NoCenter::Singular), work);
        };
        let work = work + (n * (4 * n + changes.len())) as u64;
        let mut center = Center {
            x,
            radius: 1.0,
            factor,
            scales,
            changes,
            lengths: Vec::new(),
            contraction: 0.0,
            growth: [Vec::new(), Vec::new()],
        };
        let known = center.contract(n, least);
        (known.map(|()| center).map_err(NoCenter::TooWide), work)
    }

    /// Finds lengths and a radius of contraction, or the largest there is below `least`, 0 where there is none.
    fn contract(&mut self, n: usize, least: f64) -> Result<(), f64> {
        /// Steps towards the vector of Perron, whose lengths make the norm least.
        const STEPS: usize = 12;
        /// Beyond it nothing is gained.
        const MOST: f64 = 0.5;
        let [first, second] = self.moved(n);
        let row = |matrix: &[f64], v: &[f64], i: usize| -> f64 {
            let own = &matrix[i * n..(i + 1) * n];
            own.iter().zip(v).map(|(a, v)| a * v).sum()
        };
        let sum = |v: &[f64], radius: f64, i: usize| {
            radius * (row(&first, v, i) + radius * row(&second, v, i))
        };
        let mut lengths = vec![1.0; n];
        for _ in 0..STEPS {
            let next: Vec<f64> = (0..n).map(|i| sum(&lengths, least, i)).collect();
            let top = next.iter().copied().fold(0.0, f64::max);
            if !(top > 0.0 && top.is_finite()) {
                break;
            }
            lengths = next.iter().map(|next| next / top + 1e-6).collect();
        }
        let norm = |radius: f64| {
            let ratios = (0..n).map(|i| sum(&lengths, radius, i) / lengths[i]);
            largest(ratios) * UPWARD
        };
        let mut radius = f64::exp2(least.log2().ceil());
        let mut contraction = norm(radius);
        if contraction.is_nan() || contraction > 0.9 || !radius.is_normal() {
            let mut narrower = std::iter::successors(Some(radius), |radius| Some(0.5 * radius));
            let known = narrower.find(|radius| norm(*radius) <= 0.9 || !radius.is_normal());
            return Err(known.filter(|radius| radius.is_normal()).unwrap_or(0.0));
        }
        for _ in 0..16 {
            let wider = norm(2.0 * radius);
            if wider > MOST || wider.is_nan() {
                break;
            }
            (radius, contraction) = (2.0 * radius, wider);
        }
        for (_, _, [first, second]) in &mut self.changes {
            *first = times(*first, radius);
            *second = times(*second, radius * radius);
        }
        (self.radius, self.contraction, self.lengths) = (radius, contraction, lengths);
        self.growth = [first, second];
        Ok(())
    }

    /// Bounds of |A₀⁻¹A₁| and |A₀⁻¹A₂| for ρ = 1, by rows.
    fn moved(&self, n: usize) -> [Vec<f64>; 2] {
        let mut inverse = vec![(Complex::<f64>::ZERO, 0.0); n * n];
        for column in 0..n {
            let mut unit = vec![Number::ZERO; n];
            unit[column] = real(1.0);
            for (row, value) in self.factor.solve(unit).into_iter().enumerate() {
                inverse[row * n + column] = double(value);
            }
        }
        let lost = (4 * n + 64) as f64 * f64::EPSILON;
        [0, 1].map(|order| {
            let mut product = vec![(Complex::<f64>::ZERO, 0.0); n * n];
            for (row, column, changes) in &self.changes {
                let (change, off) = double(changes[order]);
                let size = change.norm() + off;
                if size == 0.0 {
                    continue;
                }
                for i in 0..n {
                    let (value, error) = inverse[i * n + row];
                    let (sum, total) = &mut product[i * n + column];
                    *sum += value * change;
                    *total += value.norm() * (off + lost * size) + error * size;
                }
            }
            let bound = |(value, off): (Complex<f64>, f64)| (value.norm() + off) * UPWARD;
            product.into_iter().map(bound).collect()
        })
    }

    /// Bounds of the entries of y on the unit disc for this radius, ρ or less, from those of v.
    fn within(&self, radius: f64, least: &[Magnitude]) -> Vec<Magnitude> {
        /// How far above what is needed, so that a last sweep finds enough everywhere.
        const SPARE: f64 = 1.0 + 1.0 / 16.0;
        let n = least.len();
        // On the way through many masses each of them may take a sweep.
        let sweeps = 24 + n;
        // What is below the doubles is not 0.
        let grown = |(a, b): (&f64, &f64)| (radius * (a + radius * b)) * UPWARD + f64::MIN_POSITIVE;
        let grown = self.growth[0].iter().zip(&self.growth[1]).map(grown);
        let growth: Vec<Magnitude> = grown.map(Magnitude::from).collect();
        let mut z = least.to_vec();
        for _ in 0..sweeps {
            let mut is_enough = true;
            for i in 0..n {
                let row = growth[i * n..(i + 1) * n].iter().zip(&z);
                let needed = row.fold(least[i], |sum, (factor, z)| sum + *factor * *z);
                if needed > z[i] {
                    (z[i], is_enough) = (needed * Magnitude::from(SPARE), false);
                }
            }
            if is_enough {
                return z;
            }
        }
        let ratios = least.iter().zip(&self.lengths);
        let ratios = ratios.map(|(size, length)| *size / Magnitude::from(*length));
        let largest = ratios.fold(Magnitude::ZERO, |a, b| if a < b { b } else { a });
        let largest = largest / Magnitude::from(1.0 - self.contraction * UPWARD);
        let bound = |length: &f64| largest * Magnitude::from(*length);
        self.lengths.iter().map(bound).collect()
    }

    /// The centre.
    pub(super) fn place(&self) -> f64 {
        self.x
    }

    /// Σ cⱼyⱼ + d for a right-hand side b, with polynomials in x, and with the radius of which the rest is least within `half` of the
    /// centre: a function that falls steeply is much larger on wide discs.
    pub(super) fn series(
        &self,
        right: &[(usize, Polynomial)],
        output: &[(usize, Polynomial)],
        direct: &Polynomial,
        count: usize,
        half: f64,
    ) -> PowerSeries {
        let n = self.lengths.len();
        let stretched = |polynomial: &Polynomial| {
            let [value, first, second] = about(polynomial, self.x);
            let square = self.radius * self.radius;
            [value, times(first, self.radius), times(second, square)]
        };
        let mut forces = [(); 3].map(|()| vec![Number::ZERO; n]);
        for (row, polynomial) in right {
            for (force, part) in forces.iter_mut().zip(stretched(polynomial)) {
                force[*row] = plus(force[*row], scaled(part, -self.scales.0[*row]));
            }
        }
        let output: Vec<(usize, Polynomial)> = output
            .iter()
            .map(|(column, polynomial)| {
                let down = |part| scaled(part, -self.scales.1[*column]);
                (*column, stretched(polynomial).map(down))
            })
            .collect();
        let direct = stretched(direct);
        let mut solutions: Vec<Vec<Number>> = Vec::with_capacity(count);
        for k in 0..count {
            let mut right = match forces.get(k) {
                Some(force) => force.clone(),
                None => vec![Number::ZERO; n],
            };
            for (row, column, changes) in &self.changes {
                let changes = changes.iter().enumerate();
                for (order, change) in changes.filter(|(_, change)| !change.is_zero()) {
                    let before = k.checked_sub(order + 1).map(|k| solutions[k][*column]);
                    if let Some(before) = before.filter(|before| !before.is_zero()) {
                        right[*row] = right[*row] - *change * before;
                    }
                }
            }
            solutions.push(self.factor.solve(right));
        }
        let coefficients = (0..count).map(|k| {
            let mut sum = direct.get(k).copied().unwrap_or(Number::ZERO);
            for (column, parts) in &output {
                for (order, part) in parts.iter().enumerate().take(k + 1) {
                    let y = solutions[k - order][*column];
                    if !part.is_zero() && !y.is_zero() {
                        sum = plus(sum, *part * y);
                    }
                }
            }
            sum
        });
        let coefficients: Vec<Number> = coefficients.collect();
        let solved = forces.map(|force| match force.iter().any(|part| !part.is_zero()) {
            true => self
                .factor
                .solve(force)
                .into_iter()
                .map(Ball::upper)
                .collect(),
            false => vec![Magnitude::ZERO; n],
        });
        // A polynomial's parts, with ρ over 2^shift.
        let narrowed = |parts: [Magnitude; 3], shift: i64| {
            let mut power = 0;
            parts.into_iter().fold(Magnitude::ZERO, |sum, part| {
                power += shift;
                sum + part * Magnitude::power_of_two(shift - power)
            })
        };
        let bound = |shift: i64| {
            let sizes: Vec<Magnitude> = (0..n)
                .map(|i| narrowed([0, 1, 2].map(|order| solved[order][i]), shift))
                .collect();
            let sizes = self.within(self.radius * f64::exp2(-shift as f64), &sizes);
            let size = |parts: &Polynomial| narrowed(parts.map(Ball::upper), shift);
            output.iter().fold(size(&direct), |total, (column, parts)| {
                total + size(parts) * sizes[*column]
            })
        };
        let (mut shift, mut largest) = (0, bound(0));
        let most = (REACH * self.radius / half).log2().min(60.0) as i64;
        for next in 1..=most {
            let narrower = bound(next);
            // The rest grows with the square of the bound, and with 1/ρ to the power of its order.
            let gain = 2.0 * (largest.log2() - narrower.log2());
            if gain.is_nan() || gain <= count as f64 {
                break;
            }
            (shift, largest) = (next, narrower);
        }
        let each = coefficients.into_iter().enumerate();
        PowerSeries {
            coefficients: each
                .map(|(k, coefficient)| at_most(scaled(coefficient, -shift * k as i64), largest))
                .collect(),
            largest,
            radius: self.radius * f64::exp2(-shift as f64),
        }
    }
}

/// What is known of a number of this size or less: errors of recursions grow from step to step, and may be larger.
pub(super) fn at_most(value: Number, size: Magnitude) -> Number {
    match size < value.radius() {
        true => Ball::new(WideComplex::ZERO, size),
        false => value,
    }
}

/// A double, exactly.
pub(super) fn real(value: f64) -> Number {
    Ball::from(WideComplex {
        re: value.into(),
        im: DoubleDouble::ZERO,
    })
}

/// The product with a double, 0 where one of the two is.
pub(super) fn times(value: Number, factor: f64) -> Number {
    match factor == 0.0 || value.is_zero() {
        true => Number::ZERO,
        false => value * factor,
    }
}

/// The sum, without a rounding where one of the two is 0.
fn plus(a: Number, b: Number) -> Number {
    match (a.is_zero(), b.is_zero()) {
        (true, _) => b,
        (_, true) => a,
        _ => a + b,
    }
}

/// The same polynomial by powers of x − x₀.
fn about([zeroth, first, second]: &Polynomial, x: f64) -> Polynomial {
    let slope = plus(*first, times(*second, x));
    [
        plus(*zeroth, times(slope, x)),
        plus(slope, times(*second, x)),
        *second,
    ]
}

/// In doubles, and how far it may be off.
fn double(value: Number) -> (Complex<f64>, f64) {
    let WideComplex { re, im } = value.middle();
    let middle = Complex::new(re.to_f64(), im.to_f64());
    let rounding = middle.norm() * f64::EPSILON;
    (middle, value.radius().to_f64() + rounding)
}

/// Powers of two for rows and columns, so that the largest entry of each is about 1.
fn scales(n: usize, entries: &[Entry]) -> (Vec<i64>, Vec<i64>) {
    let sizes: Vec<(usize, usize, i64)> = entries
        .iter()
        .map(|(row, column, value)| (*row, *column, value[0].upper()))
        .filter(|(.., size)| !size.is_zero() && size.is_finite())
        .map(|(row, column, size)| (row, column, size.exponent()))
        .collect();
    let largest = |each: &mut dyn Iterator<Item = (usize, i64)>| -> Vec<i64> {
        let mut largest = vec![None; n];
        for (at, exponent) in each {
            largest[at] = largest[at].max(Some(exponent));
        }
        largest.into_iter().map(Option::unwrap_or_default).collect()
    };
    let columns: Vec<i64> = largest(&mut sizes.iter().map(|entry| (entry.1, entry.2)))
        .into_iter()
        .map(|exponent| exponent.div_euclid(2))
        .collect();
    let down = |entry: &(usize, usize, i64)| (entry.0, entry.2 - columns[entry.1]);
    let rows = largest(&mut sizes.iter().map(down));
    let down = |entry: &(usize, usize, i64)| (entry.1, entry.2 - rows[entry.0]);
    let columns = largest(&mut sizes.iter().map(down));
    (rows, columns)
}
