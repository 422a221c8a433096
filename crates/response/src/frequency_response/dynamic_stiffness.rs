//! K − Ω²M + iΩC in ball arithmetic, from the elements, and what forces and motions of supports put beside it.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use eigentone_digits::{Ball, DoubleDouble, Magnitude, Real, WideComplex};
use eigentone_modes::{ElementKind, MatrixKind, System, null_vectors};
use faer::Mat;
use num_complex::Complex;

use super::elimination::{Row, scaled};

/// A frequency Ω ≥ 0 in rad/s, or all that are close to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frequency {
    pub(super) middle: DoubleDouble,
    pub(super) radius: f64,
    /// The power of two that both are multiplied by.
    pub(super) scale: i64,
}

impl From<f64> for Frequency {
    fn from(frequency: f64) -> Frequency {
        Frequency {
            middle: frequency.into(),
            radius: 0.0,
            scale: 0,
        }
    }
}

impl Frequency {
    /// 2^−k, which may be less than any double.
    pub(super) fn small(k: i64) -> Frequency {
        Frequency {
            scale: -k,
            ..1.0.into()
        }
    }

    pub(super) fn is_zero(self) -> bool {
        self.middle == DoubleDouble::ZERO && self.radius == 0.0
    }

    fn ball<T: Real>(self) -> Ball<T> {
        let (high, low) = (self.middle.high(), self.middle.low());
        let middle = T::from(high) + T::from(low);
        let error = T::unit() * middle.upper();
        Ball::new(
            WideComplex {
                re: middle,
                im: T::ZERO,
            },
            Magnitude::from(self.radius) + error,
        )
    }

    /// (iΩ)^power.
    pub(super) fn power<T: Real>(self, power: i32) -> Ball<T> {
        let unit = match self.middle.low() == 0.0 && self.radius == 0.0 {
            true => real(self.middle.high()),
            false => self.ball(),
        };
        let unit = match self.scale {
            0 => turned(unit, 1),
            scale => scaled(turned(unit, 1), scale),
        };
        let product = (0..power.unsigned_abs()).fold(real(1.0), |product, _| product * unit);
        match power {
            0.. => product,
            _ => real::<T>(1.0)
                .checked_div(product)
                .unwrap_or(Ball::new(WideComplex::ZERO, Magnitude::INFINITY)),
        }
    }

    /// The largest k for which it is a whole multiple of 2^k; `None` where it is not one frequency.
    fn last_bit(self) -> Option<i64> {
        let parts = [self.middle.high(), self.middle.low()];
        let parts = parts.into_iter().filter(|part| *part != 0.0);
        (self.radius == 0.0).then(|| parts.map(last_bit).min().unwrap_or(0) + self.scale)
    }
}

/// i^turns (iΩ)^power times a product of doubles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Part {
    turns: u8,
    power: i32,
    factors: [f64; 4],
}

impl Part {
    /// A product of two doubles times (iΩ)^power.
    pub(super) fn of(power: i32, factors: [f64; 2]) -> Part {
        Part {
            turns: 0,
            power,
            factors: [factors[0], factors[1], 1.0, 1.0],
        }
    }

    /// i times the product, at every frequency.
    pub(super) fn loss(factors: [f64; 4]) -> Part {
        Part {
            turns: 1,
            power: 0,
            factors,
        }
    }

    /// The derivative with respect to Ω, of what is no loss.
    pub(super) fn derivative(self) -> Option<Part> {
        let [a, b, ..] = self.factors;
        let power = self.power;
        (power != 0).then(|| Part {
            turns: self.turns + 1,
            power: power - 1,
            factors: [a, b, power.into(), 1.0],
        })
    }

    /// The power of Ω, and what it is multiplied by.
    pub(super) fn coefficient<T: Real>(&self) -> (i32, Ball<T>) {
        let factors = self.factors.iter().filter(|factor| **factor != 1.0);
        let product = factors.fold(real::<T>(1.0), |product, factor| product * *factor);
        let turns = (i32::from(self.turns) + self.power).rem_euclid(4);
        (self.power, turned(product, turns as u8))
    }

    /// Power, quarter turns, and doubles whose sum is the product, where these are exact.
    pub(super) fn exact(&self) -> Option<(i32, u8, Vec<f64>)> {
        let [first, others @ ..] = self.factors;
        let product = others
            .iter()
            .try_fold(vec![first], |product, factor| products(&product, *factor))?;
        Some((self.power, self.turns % 4, product))
    }

    /// Power, and what (iΩ)^power is multiplied by.
    pub(super) fn factor(&self) -> (i32, Complex<f64>) {
        let product = self.factors.iter().product::<f64>();
        let turned = Complex::<f64>::I.powu(self.turns.into()) * product;
        (self.power, turned)
    }

    /// The power of iΩ.
    pub(super) fn power(&self) -> i32 {
        self.power
    }

    /// Whether there is no loss.
    pub(super) fn is_real(&self) -> bool {
        self.turns == 0
    }

    /// The product in double-double, which a power of iΩ is multiplied by where there is no loss.
    pub(super) fn product(&self) -> DoubleDouble {
        let factors = self.factors.iter();
        factors.fold(DoubleDouble::from(1.0), |product, factor| product * *factor)
    }

    pub(super) fn value<T: Real>(&self, frequency: Frequency) -> Ball<T> {
        let factors = self.factors.iter().filter(|factor| **factor != 1.0);
        let product = factors.fold(real::<T>(1.0), |product, factor| product * *factor);
        turned(product, self.turns) * frequency.power(self.power)
    }
}

/// How large the entries of a row are, as polynomials in Ω.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowSize {
    /// The sum of the sizes of all coefficients, or more.
    pub(super) size: Magnitude,
    /// k such that each coefficient is a Gaussian integer times 2^k; `None` for an empty row.
    pub(super) last_bit: Option<i64>,
}

impl Default for RowSize {
    fn default() -> RowSize {
        RowSize {
            size: Magnitude::ZERO,
            last_bit: None,
        }
    }
}

impl RowSize {
    /// Another entry, or another term of one.
    pub(super) fn add(&mut self, part: &Part) {
        self.add_product(&part.factors);
    }

    fn add_product(&mut self, factors: &[f64]) {
        let sizes = factors.iter().map(|factor| Magnitude::from(*factor));
        self.size = self.size + sizes.fold(Magnitude::from(1.0), |product, size| product * size);
        let bit = factors.iter().map(|factor| last_bit(*factor)).sum();
        self.last_bit = Some(self.last_bit.map_or(bit, |least| least.min(bit)));
    }
}

/// i^turns times a ball.
fn turned<T: Real>(ball: Ball<T>, turns: u8) -> Ball<T> {
    let turn = |middle: WideComplex<T>, _| WideComplex {
        re: -middle.im,
        im: middle.re,
    };
    Ball::new((0..turns).fold(ball.middle(), turn), ball.radius())
}

/// An entry as a sum.
#[derive(Clone, Debug, Default)]
struct Terms {
    /// The doubles whose exact sums are its parts of K, C and M.
    sums: [Vec<f64>; 3],
    /// The products of doubles whose sum times i is the loss of springs.
    losses: Vec<[f64; 4]>,
}

/// The dynamic stiffness K − Ω²M + iΩC of a system, springs with loss factors η being k(1 + iη), at any Ω.
#[derive(Debug)]
pub(super) struct DynamicStiffness {
    entries: BTreeMap<(usize, usize), Terms>,
    /// By coordinate, the part of the system that it belongs to: others are joined to none of it.
    part: Vec<usize>,
}

impl DynamicStiffness {
    /// With a loss factor for each of the springs as they were given, or for none.
    pub(super) fn of(system: &System, loss_factors: &[f64]) -> DynamicStiffness {
        let mut entries: BTreeMap<(usize, usize), Terms> = BTreeMap::new();
        let kinds = [MatrixKind::Stiffness, MatrixKind::Damping, MatrixKind::Mass];
        for (power, kind) in kinds.into_iter().enumerate() {
            for term in system.terms(kind) {
                let entry = entries.entry((term.row, term.column)).or_default();
                entry.sums[power].push(term.value);
            }
        }
        for (spring, &loss) in losing(system, loss_factors) {
            for &(row, a) in &spring.stretch.coordinates {
                for &(column, b) in &spring.stretch.coordinates {
                    let entry = entries.entry((row, column)).or_default();
                    entry.losses.push([loss, spring.coefficient, a, b]);
                }
            }
        }
        let part = parts(system.len(), entries.keys().copied());
        DynamicStiffness { entries, part }
    }

    /// Its entries as enclosures of their parts of K, C and M: row, column, parts.
    pub(super) fn balls<T: Real>(&self) -> Vec<(usize, usize, [Ball<T>; 3])> {
        let entries = self.entries.iter();
        let entries = entries.map(|(&(row, column), terms)| {
            let sums = [0, 1, 2].map(|power| sum(&terms.sums[power]));
            (row, column, sums)
        });
        entries.collect()
    }

    /// The parts of the system that some of the coordinates belong to.
    pub(super) fn reached(&self, coordinates: impl Iterator<Item = usize>) -> Vec<usize> {
        let mut reached: Vec<usize> = coordinates.map(|i| self.part[i]).collect();
        reached.sort_unstable();
        reached.dedup();
        reached
    }

    /// Whether a coordinate belongs to one of these parts.
    pub(super) fn is_within(&self, parts: &[usize], coordinate: usize) -> bool {
        parts.binary_search(&self.part[coordinate]).is_ok()
    }

    /// The rows and columns of these parts. The rest moves by itself, which nothing that acts on them changes.
    pub(super) fn block(&self, parts: &[usize]) -> Block {
        let within = |i: usize| self.is_within(parts, i);
        let coordinates: Vec<usize> = (0..self.part.len()).filter(|i| within(*i)).collect();
        let place = |i: usize| coordinates.binary_search(&i).expect("it is within");
        let entries = self.entries.iter().filter(|((row, _), _)| within(*row));
        let entries =
            entries.map(|((row, column), terms)| ((place(*row), place(*column)), terms.clone()));
        Block {
            entries: entries.collect(),
            coordinates,
            free: OnceLock::new(),
        }
    }
}

/// The springs that have a loss factor, with it.
fn losing<'a>(
    system: &System,
    loss_factors: &'a [f64],
) -> impl Iterator<Item = (eigentone_modes::GivenElement, &'a f64)> {
    let springs = match loss_factors.is_empty() {
        true => Vec::new(),
        false => system.elements(ElementKind::Spring),
    };
    let all = springs.into_iter().zip(loss_factors);
    all.filter(|(_, loss)| **loss != 0.0)
}

/// The matrix that stands for the losses of springs: i times it is added to K.
pub(super) fn losses(system: &System, loss_factors: &[f64]) -> Mat<f64> {
    let mut losses = Mat::zeros(system.len(), system.len());
    for (spring, loss) in losing(system, loss_factors) {
        for &(row, a) in &spring.stretch.coordinates {
            for &(column, b) in &spring.stretch.coordinates {
                losses[(row, column)] += loss * spring.coefficient * a * b;
            }
        }
    }
    losses
}

/// What a unit motion of a support puts on the right-hand side: coordinate and −(K_s + iΩC_s − Ω²M_s).
pub(super) fn carried(system: &System, support: usize, loss_factors: &[f64]) -> Vec<(usize, Part)> {
    let kinds = [MatrixKind::Stiffness, MatrixKind::Damping, MatrixKind::Mass];
    let mut carried = Vec::new();
    for (power, kind) in kinds.into_iter().enumerate() {
        let terms = system.coupling(kind).iter();
        let own = terms.filter(|term| term.column == support);
        carried.extend(own.map(|term| (term.row, Part::of(power as i32, [-term.value, 1.0]))));
    }
    for (spring, &loss) in losing(system, loss_factors) {
        let own = spring.stretch.supports.iter();
        for &(_, b) in own.filter(|(s, _)| *s == support) {
            for &(row, a) in &spring.stretch.coordinates {
                carried.push((row, Part::loss([-loss, spring.coefficient, a, b])));
            }
        }
    }
    carried
}

/// For each coordinate the least index of those that it is joined to, be it through others.
pub(super) fn parts(n: usize, joints: impl Iterator<Item = (usize, usize)>) -> Vec<usize> {
    fn root(part: &mut [usize], mut i: usize) -> usize {
        while part[i] != i {
            part[i] = part[part[i]];
            i = part[i];
        }
        i
    }
    let mut part: Vec<usize> = (0..n).collect();
    for (i, j) in joints {
        let (i, j) = (root(&mut part, i), root(&mut part, j));
        part[i.max(j)] = i.min(j);
    }
    (0..n).map(|i| root(&mut part, i)).collect()
}

/// The dynamic stiffness of parts of a system.
#[derive(Debug)]
pub(super) struct Block {
    /// The coordinates it is about, rising.
    coordinates: Vec<usize>,
    /// By row and column, both as positions in `coordinates`; by rising row, then column.
    entries: Vec<((usize, usize), Terms)>,
    /// What K maps to 0, once it was asked for.
    free: OnceLock<Vec<Vec<(usize, f64)>>>,
}

impl Block {
    /// Independent motions that K leaves free, all of them or none: see [`null_vectors`].
    pub(super) fn free(&self) -> &[Vec<(usize, f64)>] {
        self.free.get_or_init(|| {
            let entries = self.entries.iter();
            let parts = entries.flat_map(|((row, column), terms)| {
                let own = terms.sums[0].iter();
                own.map(|part| (*row, *column, *part))
            });
            null_vectors(self.coordinates.len(), parts.collect())
        })
    }

    /// The coordinates that it is about, rising.
    pub(super) fn coordinates(&self) -> &[usize] {
        &self.coordinates
    }

    /// Whether elimination takes longer than an inverse in doubles: rows have entries far from the diagonal, and fill up.
    pub(super) fn fills_up(&self) -> bool {
        /// Fewer coordinates are eliminated as quickly.
        const FEW: usize = 16;
        /// How far from the diagonal rows reach on average.
        const FAR: usize = 6;
        let n = self.coordinates.len();
        let mut reach = vec![0; n];
        for ((row, column), _) in &self.entries {
            reach[*row] = reach[*row].max(row.abs_diff(*column));
        }
        n > FEW && reach.into_iter().sum::<usize>() > FAR * n
    }

    /// Whether it has three entries in a row or fewer, as a chain.
    pub(super) fn is_thin(&self) -> bool {
        self.entries.len() <= 3 * self.coordinates.len()
    }

    /// Whether springs in it have loss factors.
    pub(super) fn has_losses(&self) -> bool {
        self.entries
            .iter()
            .any(|(_, terms)| !terms.losses.is_empty())
    }

    /// Its entries as sums of doubles by powers of iΩ, without losses.
    pub(super) fn terms(&self) -> impl Iterator<Item = (usize, usize, [Vec<f64>; 3])> {
        let entries = self.entries.iter();
        entries.map(|((row, column), terms)| (*row, *column, terms.sums.clone()))
    }

    /// The losses of springs, by row and column.
    pub(super) fn losses(&self) -> impl Iterator<Item = ((usize, usize), Part)> {
        let entries = self.entries.iter();
        entries.flat_map(|(place, terms)| {
            let losses = terms.losses.iter();
            losses.map(|factors| (*place, Part::loss(*factors)))
        })
    }

    /// Its entries as polynomials in Ω: row, column, coefficients.
    pub(super) fn polynomials<T: Real>(&self) -> Vec<(usize, usize, [Ball<T>; 3])> {
        let entries = self.entries.iter().map(|((row, column), terms)| {
            let mut parts = polynomial(&terms.sums);
            for factors in &terms.losses {
                parts[0] = parts[0] + Part::loss(*factors).coefficient().1;
            }
            (*row, *column, parts)
        });
        entries.collect()
    }

    /// Its rows in the precision of T, and the powers of two by which row and column are divided so
    /// that the largest entry of each is about 1.
    pub(super) fn rows<T: Real>(&self, frequency: Frequency) -> (Vec<Row<T>>, Vec<i64>) {
        let n = self.coordinates.len();
        let factors: [Ball<T>; 3] = [0, 1, 2].map(|order| frequency.power(order));
        let values = self.entries.iter().map(|(place, terms)| {
            let parts = terms.sums.iter().zip(factors);
            let parts = parts.filter(|(terms, _)| !terms.is_empty());
            let value = parts.fold(Ball::ZERO, |value, (terms, factor)| {
                value + sum(terms) * factor
            });
            let losses = terms.losses.iter();
            let value = losses.fold(value, |value, factors| {
                value + Part::loss(*factors).value(frequency)
            });
            (*place, value)
        });
        let values: Vec<((usize, usize), Ball<T>)> = values.collect();
        let mut largest = vec![None; n];
        for ((row, column), value) in &values {
            let size = value.upper();
            if !size.is_zero() && size.is_finite() {
                for at in [*row, *column] {
                    largest[at] = largest[at].max(Some(size.exponent()));
                }
            }
        }
        let exponents: Vec<i64> = largest
            .into_iter()
            .map(|exponent| exponent.unwrap_or(0).div_euclid(2))
            .collect();
        let mut rows = vec![Row::new(); n];
        for ((row, column), value) in values {
            let down = -(exponents[row] + exponents[column]);
            rows[row].push((column, scaled(value, down)));
        }
        (rows, exponents)
    }

    /// Z′x for the derivative Z′ = iC − 2ΩM of its rows with respect to Ω.
    pub(super) fn slope<T: Real>(&self, frequency: Frequency, x: &[Ball<T>]) -> Vec<Ball<T>> {
        let factors = slopes::<T>(frequency);
        let mut product = vec![Ball::ZERO; x.len()];
        for ((row, column), terms) in &self.entries {
            for (terms, factor) in terms.sums[1..].iter().zip(factors) {
                product[*row] = product[*row] + sum(terms) * factor * x[*column];
            }
        }
        product
    }

    /// Of each row.
    pub(super) fn row_sizes(&self) -> Vec<RowSize> {
        let mut rows = vec![RowSize::default(); self.coordinates.len()];
        for ((row, _), terms) in &self.entries {
            let sums = terms.sums.iter().flatten();
            sums.for_each(|term| rows[*row].add_product(&[*term]));
            let losses = terms.losses.iter();
            losses.for_each(|factors| rows[*row].add_product(factors));
        }
        rows
    }

    /// k such that the determinant, unless it is 0, is at least 2^k: every entry of a row is a
    /// Gaussian integer times one power of two, so their products are. `None` where Ω is not one frequency.
    pub(super) fn grain(&self, frequency: Frequency) -> Option<i64> {
        let frequency = frequency.last_bit()?;
        let mut rows = vec![None; self.coordinates.len()];
        for ((row, _), terms) in &self.entries {
            let sums = terms.sums.iter().enumerate().flat_map(|(power, terms)| {
                let shift = power as i64 * frequency;
                terms.iter().map(move |term| last_bit(*term) + shift)
            });
            let losses = terms.losses.iter();
            let losses = losses.map(|factors| factors.iter().map(|factor| last_bit(*factor)).sum());
            for bit in sums.chain(losses) {
                rows[*row] = Some(rows[*row].map_or(bit, |least: i64| least.min(bit)));
            }
        }
        Some(rows.into_iter().flatten().sum())
    }
}

/// The derivatives of iΩ and (iΩ)² with respect to Ω: what C and M are multiplied by in Z′.
pub(super) fn slopes<T: Real>(frequency: Frequency) -> [Ball<T>; 2] {
    [1, 2].map(|order| {
        let derivative = Part::of(order, [1.0; 2]).derivative();
        derivative.expect("Ω has a power").value(frequency)
    })
}

/// Doubles whose sum is that of some others times a factor; `None` where these are not exact.
pub(super) fn products(terms: &[f64], factor: f64) -> Option<Vec<f64>> {
    if factor == 1.0 {
        return Some(terms.to_vec());
    }
    let terms = terms.iter().filter(|term| **term != 0.0 && factor != 0.0);
    let products = terms.map(|term| {
        let product = DoubleDouble::product(*term, factor);
        let is_exact = (1e-200..f64::INFINITY).contains(&product.high().abs());
        is_exact.then_some([product.high(), product.low()])
    });
    let products: Option<Vec<[f64; 2]>> = products.collect();
    Some(products?.concat())
}

/// A polynomial in Ω by the doubles whose sums multiply powers of iΩ.
pub(super) fn polynomial<T: Real>(sums: &[Vec<f64>; 3]) -> [Ball<T>; 3] {
    [0, 1, 2].map(|power| turned(sum::<T>(&sums[usize::from(power)]), power))
}

/// The same where others multiply i times these powers.
pub(super) fn complex_polynomial<T: Real>(
    real: &[Vec<f64>; 3],
    imaginary: &[Vec<f64>; 3],
) -> [Ball<T>; 3] {
    let mut parts = polynomial(real);
    let own = polynomial::<T>(imaginary).into_iter().zip(imaginary);
    for (part, (more, _)) in parts
        .iter_mut()
        .zip(own)
        .filter(|(_, (_, doubles))| !doubles.is_empty())
    {
        *part = *part + turned(more, 1);
    }
    parts
}

/// The exact sum of doubles.
fn sum<T: Real>(terms: &[f64]) -> Ball<T> {
    let terms = terms.iter().map(|term| real::<T>(*term));
    terms.fold(Ball::ZERO, |sum, term| sum + term)
}

/// A double, exactly.
fn real<T: Real>(value: f64) -> Ball<T> {
    Ball::from(WideComplex {
        re: T::from(value),
        im: T::ZERO,
    })
}

/// The largest k for which a nonzero double is a whole multiple of 2^k; 0 for 0.
fn last_bit(value: f64) -> i64 {
    if value == 0.0 {
        return 0;
    }
    const MANTISSA: u64 = (1 << 52) - 1;
    let bits = value.to_bits();
    let (biased, fraction) = ((bits >> 52) as i64 & 0x7ff, bits & MANTISSA);
    match biased {
        0 => i64::from(fraction.trailing_zeros()) - 1074,
        _ => biased - 1075 + i64::from((fraction | (1 << 52)).trailing_zeros()),
    }
}

#[cfg(test)]
mod tests {
    use super::last_bit;

    #[test]
    fn the_last_bit_of_a_double() {
        let cases = [
            (1.0, 0),
            (-6.0, 1),
            (0.75, -2),
            (5e-324, -1074),
            (f64::MIN_POSITIVE, -1022),
            (1e22, 22),
            (f64::MAX, 971),
        ];
        for (value, bit) in cases {
            assert_eq!(last_bit(value), bit, "{value:e}");
        }
    }
}
