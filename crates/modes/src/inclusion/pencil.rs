//! det(λ²M + λC + K) in ball arithmetic, from the elements.

use crate::model::MatrixKind;
use crate::system::System;

use eigentone_digits::{Ball, Magnitude, Real, WideComplex};

use num_complex::Complex;

use super::exactly::{lower, middle, real, scaled, upper};

/// A number with a power of two apart, so that long products stay within range.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scaled<T> {
    pub(crate) ball: Ball<T>,
    pub(crate) exponent: i64,
}

impl<T: Real> Scaled<T> {
    pub(crate) fn one() -> Self {
        Scaled {
            ball: real(1.0),
            exponent: 0,
        }
    }

    pub(crate) fn times(self, factor: Ball<T>) -> Self {
        Scaled {
            ball: self.ball * factor,
            exponent: self.exponent,
        }
        .normalised()
    }

    pub(crate) fn divided_by(self, divisor: Self) -> Option<Self> {
        let ball = self.ball.checked_div(divisor.ball)?;
        Some(
            Scaled {
                ball,
                exponent: self.exponent - divisor.exponent,
            }
            .normalised(),
        )
    }

    pub(crate) fn conj(self) -> Self {
        let ball = Ball::new(self.ball.middle().conj(), self.ball.radius());
        Scaled { ball, ..self }
    }

    fn normalised(self) -> Self {
        let size = self.ball.upper();
        if size.is_zero() || !size.is_finite() {
            return self;
        }
        let shift = size.exponent();
        Scaled {
            ball: scaled(self.ball, -shift),
            exponent: self.exponent + shift,
        }
    }

    /// The ball itself, or `None` out of range or where nothing is known of it.
    pub(crate) fn value(self) -> Option<Ball<T>> {
        if self.ball.is_zero() {
            return Some(self.ball);
        }
        // However small its power of two, it may be anything.
        if !self.ball.upper().is_finite() {
            return None;
        }
        const LARGEST: i64 = 900;
        let this = self.normalised();
        if this.exponent < -LARGEST {
            let reach = Magnitude::power_of_two(1 - LARGEST);
            return Some(Ball::new(WideComplex::ZERO, reach));
        }
        (this.exponent < LARGEST).then(|| scaled(this.ball, this.exponent))
    }
}

/// One of the doubles whose exact sums are the entries of K, C and M.
#[derive(Clone, Copy, Debug)]
struct Term {
    /// Of [`Pencil::entries`].
    entry: usize,
    power: usize,
    value: f64,
}

/// Operations of a product with so many limbs.
pub(crate) fn product(limbs: usize) -> f64 {
    (limbs * limbs + 20) as f64
}

/// The matrix polynomial of a system, as sums of doubles: in λ, or without C in σ = λ² as σM + K.
#[derive(Clone, Debug)]
pub(crate) struct Pencil {
    n: usize,
    /// Row and column of every entry of λ²M + λC + K that is not always zero.
    entries: Vec<[usize; 2]>,
    terms: Vec<Term>,
    pub(crate) in_square: bool,
}

/// [`Pencil`] in the precision of T, with rows, columns and λ in units of powers of two.
#[derive(Clone, Debug)]
pub(crate) struct PencilIn<T> {
    n: usize,
    /// Row, column, and the coefficients of 1, μ and μ².
    entries: Vec<(usize, usize, [Ball<T>; 3])>,
    /// Row and column i are divided by 2 to this power.
    exponents: Vec<i32>,
}

impl Pencil {
    pub(crate) fn of(system: &System, in_square: bool) -> Pencil {
        let n = system.len();
        let mut entries: Vec<[usize; 2]> = Vec::with_capacity(3 * n);
        let mut terms: Vec<Term> = Vec::with_capacity(8 * n);
        let mut index = vec![usize::MAX; n * n];
        for (kind, power) in [
            (MatrixKind::Stiffness, 0),
            (MatrixKind::Damping, 1),
            (MatrixKind::Mass, if in_square { 1 } else { 2 }),
        ] {
            if in_square && kind == MatrixKind::Damping {
                continue;
            }
            for term in system.terms(kind) {
                let entry = &mut index[term.row * n + term.column];
                if *entry == usize::MAX {
                    *entry = entries.len();
                    entries.push([term.row, term.column]);
                }
                terms.push(Term {
                    entry: *entry,
                    power,
                    value: term.value,
                });
            }
        }
        Pencil {
            n,
            entries,
            terms,
            in_square,
        }
    }

    /// n.
    pub(crate) fn len(&self) -> usize {
        self.n
    }

    /// Whether so many eliminations with so many limbs stay within a stated count of operations.
    pub(crate) fn affords(&self, limbs: usize, times: usize) -> bool {
        const LARGEST: f64 = 1e9;
        let n = self.n as f64;
        let filled = self.entries.len() as f64 / n;
        let elimination = (n * n * n / 3.0).min(4.0 * n * filled * filled);
        elimination * times as f64 * product(limbs) <= LARGEST
    }

    /// The coefficient of one power, with rows and columns added up over the given parts; by rows.
    pub(crate) fn block<T: Real>(&self, power: usize, parts: &[Vec<usize>]) -> Vec<Ball<T>> {
        let part = |i: usize| parts.iter().position(|part| part.contains(&i));
        let mut block = vec![Ball::ZERO; parts.len() * parts.len()];
        for term in self.terms.iter().filter(|term| term.power == power) {
            if let [Some(row), Some(column)] = self.entries[term.entry].map(part) {
                let at = &mut block[row * parts.len() + column];
                *at = *at + real(term.value);
            }
        }
        block
    }

    /// In the precision of T, with λ = 2^unit·μ (or σ = 4^unit·μ), and each row and column scaled
    /// so that its largest entry for |μ| = 1 is about 1.
    pub(crate) fn precise<T: Real>(&self, unit: i32) -> (PencilIn<T>, i64) {
        let step = if self.in_square { 2 * unit } else { unit };
        let new = |[row, column]: &[usize; 2]| (*row, *column, [Ball::ZERO; 3]);
        let mut entries: Vec<(usize, usize, [Ball<T>; 3])> = self.entries.iter().map(new).collect();
        for term in &self.terms {
            let sum = &mut entries[term.entry].2[term.power];
            *sum = *sum + real(term.value);
        }
        for (_, _, coefficients) in &mut entries {
            for (power, sum) in (0..).zip(coefficients) {
                *sum = scaled(*sum, i64::from(step * power));
            }
        }
        let mut scale = vec![Magnitude::ZERO; self.n];
        let larger = |a: Magnitude, b: Magnitude| if b > a { b } else { a };
        for (row, column, coefficients) in &entries {
            let sizes = coefficients.iter().map(|ball| ball.upper());
            let size = sizes.fold(Magnitude::ZERO, larger);
            scale[*row] = larger(scale[*row], size);
            scale[*column] = larger(scale[*column], size);
        }
        // Beyond the range of doubles too, which that of T may exceed.
        let exponents: Vec<i32> = scale
            .iter()
            .map(|size| {
                if !size.is_zero() && size.is_finite() {
                    (size.log2() / 2.0).round() as i32
                } else {
                    0
                }
            })
            .collect();
        for (row, column, coefficients) in &mut entries {
            let down = -i64::from(exponents[*row] + exponents[*column]);
            *coefficients = coefficients.map(|ball| scaled(ball, down));
        }
        let total = exponents
            .iter()
            .map(|exponent| 2 * i64::from(*exponent))
            .sum();
        (
            PencilIn {
                n: self.n,
                entries,
                exponents,
            },
            total,
        )
    }
}

impl<T: Real> PencilIn<T> {
    /// n.
    pub(crate) fn size(&self) -> usize {
        self.n
    }

    /// Row, column, and the coefficients of 1, μ and μ², which are real.
    pub(crate) fn entries(&self) -> &[(usize, usize, [Ball<T>; 3])] {
        &self.entries
    }

    /// The units of a vector's entries: powers of two by which its columns were divided.
    pub(crate) fn exponents(&self) -> &[i32] {
        &self.exponents
    }

    /// The matrix at μ, by rows.
    fn at(&self, mu: Ball<T>) -> Vec<Ball<T>> {
        let n = self.n;
        let mut matrix = vec![Ball::ZERO; n * n];
        for (row, column, [zero, one, two]) in &self.entries {
            let value = if two.is_zero() {
                *zero + *one * mu
            } else {
                *zero + (*one + *two * mu) * mu
            };
            matrix[row * n + column] = value;
        }
        matrix
    }

    /// The determinant at μ, and how many products it took.
    pub(crate) fn determinant(&self, mu: Ball<T>) -> (Scaled<T>, u64) {
        let eliminated = Eliminated::of(self.at(mu), self.n);
        (eliminated.determinant, eliminated.products)
    }

    /// Balls about the vector x that Q(μ) annuls at every root μ in the disc, up to a factor and with x_i in
    /// units of the scaled columns; with `transposed`, about that of Q(μ)ᵀ. `None` where the rank of Q(μ) is not
    /// proved to be n − 1 there.
    pub(crate) fn null_vector(&self, disc: Ball<T>, transposed: bool) -> Option<Vec<Ball<T>>> {
        let n = self.n;
        let mut matrix = self.at(disc);
        if transposed {
            matrix = (0..n * n).map(|at| matrix[at % n * n + at / n]).collect();
        }
        let factors = Eliminated::of(matrix, n);
        if factors.pivots + 1 != n {
            return None;
        }
        let at = |i: usize, j: usize| factors.matrix[factors.rows[i] * n + factors.columns[j]];
        // By pivots, then by columns.
        let mut ordered = vec![Ball::<T>::ZERO; n];
        ordered[n - 1] = real(1.0);
        for i in (0..n - 1).rev() {
            let mut sum = Ball::ZERO;
            for (j, entry) in ordered.iter().enumerate().skip(i + 1) {
                let factor = at(i, j);
                if !factor.is_zero() {
                    sum = sum + factor * *entry;
                }
            }
            ordered[i] = (-sum).checked_div(at(i, i))?;
        }
        let mut x = vec![Ball::ZERO; n];
        for (entry, column) in ordered.into_iter().zip(&factors.columns) {
            x[*column] = entry;
        }
        Some(x)
    }

    /// A [null vector](Self::null_vector) in the coordinates of the system, up to a factor.
    pub(crate) fn in_coordinates(&self, x: &[Ball<T>]) -> Vec<Ball<T>> {
        let power = |(x, exponent): (&Ball<T>, &i32)| x.upper().exponent() - i64::from(*exponent);
        let sized = x.iter().zip(&self.exponents);
        let sized = sized.filter(|(x, _)| !x.is_zero());
        let largest = sized.map(power).max().unwrap_or(0);
        let each = x.iter().zip(&self.exponents);
        each.map(|(x, exponent)| scaled(*x, -largest - i64::from(*exponent)))
            .collect()
    }

    /// Components of a vector of the system in units of the scaled columns, up to a factor; `None` where they are not as many.
    pub(crate) fn in_units(&self, x: &[Complex<f64>]) -> Option<Vec<Complex<f64>>> {
        let largest = *self.exponents.iter().max()?;
        let unit = |exponent: &i32| 2f64.powi((exponent - largest).max(-1000));
        let each = x.iter().zip(&self.exponents);
        (x.len() == self.n).then(|| each.map(|(x, exponent)| x * unit(exponent)).collect())
    }

    /// A disc that holds every root that `disc` holds, given its shapes as [`null_vector`](Self::null_vector)
    /// gives them and vectors near the left ones; `None` where nothing follows.
    pub(crate) fn narrowed(
        &self,
        disc: Ball<T>,
        x: &[Ball<T>],
        left: &[Ball<T>],
    ) -> Option<Ball<T>> {
        let z = middle(disc);
        let sum = z + disc;
        let (mut rest, mut slope) = (vec![Ball::ZERO; self.n], Ball::ZERO);
        for (row, column, [zero, one, two]) in &self.entries {
            let w = middle(left[*row]);
            let (value, steep) = if two.is_zero() {
                (*zero + *one * z, *one)
            } else {
                (*zero + (*one + *two * z) * z, *one + *two * sum)
            };
            rest[*column] = rest[*column] + w * value;
            slope = slope + steep * (w * x[*column]);
        }
        let products = rest.iter().zip(x).map(|(rest, x)| *rest * *x);
        let value = products.fold(Ball::ZERO, |sum, product| sum + product);
        Some(z - value.checked_div(slope)?)
    }
}

/// An n × n matrix after elimination with complete pivoting.
pub(crate) struct Eliminated<T> {
    pub(crate) determinant: Scaled<T>,
    /// By rows of the original numbering; what belongs to the upper triangle is in place.
    matrix: Vec<Ball<T>>,
    rows: Vec<usize>,
    columns: Vec<usize>,
    /// How many pivots are certainly not zero.
    pivots: usize,
    /// How many products were formed.
    products: u64,
}

impl<T: Real> Eliminated<T> {
    /// Eliminates a matrix given by rows. Where nothing but balls around zero is left, Hadamard's
    /// inequality bounds the rest of the determinant.
    pub(crate) fn of(mut matrix: Vec<Ball<T>>, n: usize) -> Eliminated<T> {
        let mut determinant = Scaled::one();
        let mut rows: Vec<usize> = (0..n).collect();
        let mut columns: Vec<usize> = (0..n).collect();
        let mut odd = false;
        let mut products = 0;
        for step in 0..n {
            let mut best = (0.0, step, step);
            for i in step..n {
                for j in step..n {
                    let size = lower(matrix[rows[i] * n + columns[j]]);
                    if size > best.0 {
                        best = (size, i, j);
                    }
                }
            }
            let (size, i, j) = best;
            if size == 0.0 {
                for i in step..n {
                    let norm = (step..n)
                        .map(|j| upper(matrix[rows[i] * n + columns[j]]))
                        .fold(0.0, f64::hypot);
                    let bound = Magnitude::from(norm * (1.0 + 1e-10));
                    determinant = determinant.times(Ball::new(WideComplex::ZERO, bound));
                }
                return Eliminated {
                    determinant,
                    matrix,
                    rows,
                    columns,
                    pivots: step,
                    products,
                };
            }
            odd ^= (i != step) ^ (j != step);
            rows.swap(step, i);
            columns.swap(step, j);
            let pivot = matrix[rows[step] * n + columns[step]];
            determinant = determinant.times(pivot);
            let tail: Vec<usize> = columns[step + 1..]
                .iter()
                .copied()
                .filter(|column| !matrix[rows[step] * n + column].is_zero())
                .collect();
            for row in rows[step + 1..].iter().copied() {
                let below = matrix[row * n + columns[step]];
                if below.is_zero() {
                    continue;
                }
                let factor = below
                    .checked_div(pivot)
                    .expect("the pivot's ball excludes zero");
                products += tail.len() as u64;
                for &column in &tail {
                    let product = factor * matrix[rows[step] * n + column];
                    matrix[row * n + column] = matrix[row * n + column] - product;
                }
            }
        }
        if odd {
            determinant.ball = -determinant.ball;
        }
        Eliminated {
            determinant,
            matrix,
            rows,
            columns,
            pivots: n,
            products,
        }
    }
}

#[cfg(test)]
mod tests {
    use eigentone_digits::Wide;

    use super::*;

    /// What is unknown is not small because it is written with a small power of two.
    #[test]
    fn what_is_unknown_has_no_value() {
        let ball = |radius: Magnitude| Ball::<Wide<4>>::new(WideComplex::ZERO, radius);
        for exponent in [-5000, -901, 0, 901] {
            let unknown = Scaled {
                ball: ball(Magnitude::INFINITY),
                exponent,
            };
            assert!(unknown.value().is_none());
        }
        let small = Scaled {
            ball: ball(Magnitude::from(1.0)),
            exponent: -5000,
        };
        assert!(
            small
                .value()
                .is_some_and(|value| value.radius() > Magnitude::ZERO)
        );
    }

    /// λ²M reaches 1e373, for which no double stands. The roots are from 200 digits.
    #[test]
    fn terms_beyond_the_doubles_are_scaled() {
        let matrix = |m: [[f64; 2]; 2]| faer::Mat::from_fn(2, 2, |i, j| m[i][j]);
        let mass = 1.6298896544521524e211;
        let m = matrix([
            [4e-300, -3.7983683188454224e133],
            [-3.7983683188454224e133, 8.900295434028806e-308],
        ]);
        let c = matrix([
            [4e160, 4.356725084943691e292],
            [4.356725084943691e292, 9.089748238990291e-64],
        ]);
        let k = matrix([
            [4e-300, -9.511467065569227e292],
            [1.0316539430681957e234, 2.9122672152026616e122],
        ]);
        let system = System::builder()
            .mass("a", mass)
            .mass("b", mass)
            .spring("a", "b", 7.031466280492861e-117)
            .damper("ground", "a", 4.0)
            .damper("a", "b", 4.0)
            .matrix(MatrixKind::Mass, m.as_ref())
            .matrix(MatrixKind::Damping, c.as_ref())
            .matrix(MatrixKind::Stiffness, k.as_ref())
            .build()
            .expect("a system");
        assert_eq!(system.structure().finite_roots(), Some(4));
        let modes = system.modes().expect("they are found");
        let known = [
            -2.3679574059732746e-59,
            2.183168981315735,
            -2.673018429832354e81,
            2.673018429832354e81,
        ];
        assert_eq!(modes.bounds(), crate::Bounds::Proven, "{}", modes.plan());
        for (root, known) in modes.eigenvalues().iter().zip(known) {
            let bound = root.bound.expect("it is proven");
            assert_eq!(root.value.im, 0.0);
            assert!((root.value.re - known).abs() <= bound.max(f64::EPSILON * known.abs()));
            assert!(bound <= f64::EPSILON * known.abs());
        }
    }
}
