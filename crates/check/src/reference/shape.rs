//! Mode shapes: the null space of Q(λ) = λ²M + λC + K where it is a line.
//!
//! Every column of the adjugate of Q(λ) lies in that line, and its entries are polynomials in λ with
//! whole coefficients. They are interpolated from exact eliminations, and evaluated in balls at λ.
//! An entry that balls do not distinguish from 0 is compared with the characteristic polynomial p: it is 0
//! exactly where λ is a root of the greatest common divisor of the two.

use eigentone_modes::System;
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Zero};

use super::Reference;
use super::ball::Ball;
use super::characteristic_polynomial::WholePencil;
use super::complex::Complex;
use super::equation::Equation;
use super::error::ReferenceError;
use super::integer_polynomial::{IntegerPolynomial, squarefree};
use super::modes::{ReferenceEigenvalue, ReferenceModes};
use super::rational_matrix::RationalMatrix;

/// Components whose sizes agree to so many powers of two count as equally large.
const TIE: i64 = 100;

/// One component of a shape, relative to its largest.
#[derive(Clone, Debug)]
pub struct ShapeComponent {
    /// Its real part; 0 without a radius where that is proved.
    pub re: Ball,
    /// Its imaginary part; 0 without a radius where that is proved.
    pub im: Ball,
}

/// What is known of the shapes at an eigenvalue.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Shape {
    /// There is one, but for its scale: one component for each coordinate, the largest 1, the first
    /// of those whose sizes agree to 30 digits.
    Determined(Vec<ShapeComponent>),
    /// There are several independent ones, and none stands out.
    Several,
    /// The radius of the eigenvalue leaves open whether there are several.
    Open,
}

impl Reference {
    /// The shape at each of `modes`, the answer for the same system, in their order.
    ///
    /// # Errors
    /// [`ReferenceError::TooMuchWork`].
    pub fn shapes(
        &self,
        system: &System,
        modes: &ReferenceModes,
    ) -> Result<Vec<Shape>, ReferenceError> {
        let n = system.len() as f64;
        // Long numbers: some digits for each row.
        self.afford(2.0 * n.powi(4) * (1.0 + n / 8.0))?;
        let pencil = WholePencil::of(system);
        let finder = Finder {
            characteristic: radical(&pencil.polynomial()),
            real: has_real_shapes(system),
            n: system.len(),
            pencil,
        };
        let mut columns: Vec<Column> = Vec::new();
        let mut shapes = Vec::new();
        for root in modes.eigenvalues() {
            shapes.push(finder.shape(root, &mut columns));
        }
        Ok(shapes)
    }
}

/// A column of the adjugate: for each row, the coefficients of its entry, lowest first.
type Column = Vec<Vec<BigInt>>;

struct Finder {
    pencil: WholePencil,
    /// A polynomial with every eigenvalue as a simple root.
    characteristic: IntegerPolynomial,
    /// Whether every shape that is determined is real.
    real: bool,
    n: usize,
}

impl Finder {
    fn shape(&self, root: &ReferenceEigenvalue, columns: &mut Vec<Column>) -> Shape {
        let lambda = Complex {
            re: root.re.clone(),
            im: root.im.clone(),
        };
        let mut open = false;
        for index in 0..self.n {
            if columns.len() == index {
                columns.push(self.column(index));
            }
            let entries: Vec<Entry> = columns[index]
                .iter()
                .map(|coefficients| self.entry(coefficients, &lambda))
                .collect();
            open |= entries.iter().any(|entry| matches!(entry, Entry::Open(_)));
            if entries.iter().any(|entry| matches!(entry, Entry::Value(_))) {
                return Shape::Determined(self.scaled(entries));
            }
        }
        if open { Shape::Open } else { Shape::Several }
    }

    /// The entries relative to the largest.
    fn scaled(&self, entries: Vec<Entry>) -> Vec<ShapeComponent> {
        let sizes: Vec<Option<Ball>> = entries
            .iter()
            .map(|entry| match entry {
                Entry::Value(value) => Some(value.modulus()),
                _ => None,
            })
            .collect();
        let mut largest: Option<&Ball> = None;
        for size in sizes.iter().flatten() {
            if largest.is_none_or(|before| (size - before).midpoint().is_positive()) {
                largest = Some(size);
            }
        }
        let first = largest.and_then(|largest| {
            let reached = largest.midpoint() - largest.midpoint().scaled(-TIE);
            sizes.iter().position(|size| {
                let size = size.as_ref();
                size.is_some_and(|size| !(&reached - &size.midpoint()).is_positive())
            })
        });
        let unit = first.map(|first| match &entries[first] {
            Entry::Value(value) | Entry::Open(value) => value.clone(),
            Entry::Zero => Complex::real(Ball::zero()),
        });
        let component = |(i, entry): (usize, Entry)| match (entry, &unit) {
            (Entry::Value(_), _) if Some(i) == first => ShapeComponent {
                re: Ball::from(1),
                im: Ball::zero(),
            },
            (Entry::Value(value) | Entry::Open(value), Some(unit)) => {
                let ratio = &value / unit;
                ShapeComponent {
                    re: ratio.re,
                    im: if self.real { Ball::zero() } else { ratio.im },
                }
            }
            _ => ShapeComponent {
                re: Ball::zero(),
                im: Ball::zero(),
            },
        };
        entries.into_iter().enumerate().map(component).collect()
    }

    /// The value of a polynomial at a root of the characteristic one.
    fn entry(&self, coefficients: &[BigInt], lambda: &Complex) -> Entry {
        let value = horner(coefficients, lambda);
        if value.re.is_zero() && value.im.is_zero() {
            return Entry::Zero;
        }
        if !value.contains_zero() {
            return Entry::Value(value);
        }
        if coefficients.iter().all(Zero::is_zero) {
            return Entry::Zero;
        }
        let polynomial = IntegerPolynomial::new(coefficients.to_vec());
        let shared = self.characteristic.common_divisor(&polynomial);
        let others = self.characteristic.divided_by(&shared);
        let others = others.expect("a divisor of it");
        // λ is a root of one of the two.
        match horner(others.coefficients(), lambda).contains_zero() {
            true => Entry::Open(value),
            false => Entry::Zero,
        }
    }

    /// Column `index` of the adjugate, interpolated (Newton's divided differences) from its values at
    /// whole numbers that are no eigenvalues.
    fn column(&self, index: usize) -> Column {
        let needed = 2 * self.n - 1;
        let mut points: Vec<BigInt> = Vec::with_capacity(needed);
        let mut values: Vec<Vec<BigInt>> = vec![Vec::with_capacity(needed); self.n];
        let mut point = BigInt::zero();
        while points.len() < needed {
            if let Some(found) = adjugate_column(self.pencil.at(&point), index) {
                for (list, value) in values.iter_mut().zip(found) {
                    list.push(value);
                }
                points.push(point.clone());
            }
            point += 1;
        }
        let coefficients = values
            .into_iter()
            .map(|values| interpolate(&points, values));
        coefficients.collect()
    }
}

enum Entry {
    Zero,
    Value(Complex),
    /// Not distinguished from 0.
    Open(Complex),
}

fn horner(coefficients: &[BigInt], at: &Complex) -> Complex {
    let zero = Complex::real(Ball::zero());
    coefficients.iter().rev().fold(zero, |value, coefficient| {
        let mut value = &value * at;
        value.re = value.re + Ball::from(coefficient.clone());
        value
    })
}

/// det(A)·A⁻¹e, e a unit vector, by Gauss and Jordan's elimination without fractions (E. H.
/// Bareiss, Math. Comp. 22, 1968); `None` where A is singular.
fn adjugate_column(mut rows: Vec<Vec<BigInt>>, index: usize) -> Option<Vec<BigInt>> {
    for (i, row) in rows.iter_mut().enumerate() {
        row.push(BigInt::from(i == index));
    }
    let n = rows.len();
    let (mut before, mut swapped) = (BigInt::one(), false);
    for k in 0..n {
        let pivot = (k..n).find(|i| !rows[*i][k].is_zero())?;
        swapped ^= pivot != k;
        rows.swap(k, pivot);
        let leading = rows[k].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(i, _)| *i != k) {
            let factor = row[k].clone();
            for (entry, above) in row.iter_mut().zip(&leading) {
                *entry = (&*entry * &leading[k] - &factor * above) / &before;
            }
        }
        before = leading[k].clone();
    }
    // Every diagonal entry has become the determinant, up to the sign of the exchanges.
    let entry = |mut row: Vec<BigInt>| row.pop().map(|x| if swapped { -x } else { x });
    rows.into_iter().map(entry).collect()
}

/// The coefficients, which are whole, of the polynomial with these values at whole numbers: so are its divided differences, as
/// those of each power are sums of products of the points.
fn interpolate(points: &[BigInt], values: Vec<BigInt>) -> Vec<BigInt> {
    let count = points.len();
    let mut differences = values;
    for order in 1..count {
        for k in (order..count).rev() {
            let width = &points[k] - &points[k - order];
            differences[k] = (&differences[k] - &differences[k - 1]) / width;
        }
    }
    let mut coefficients = vec![BigInt::zero(); count];
    for k in (0..count).rev() {
        // p ← p·(x − x_k) + d_k
        for j in (0..count).rev() {
            let below = match j {
                0 => differences[k].clone(),
                _ => coefficients[j - 1].clone(),
            };
            coefficients[j] = below - &coefficients[j] * &points[k];
        }
    }
    coefficients
}

/// The product of the distinct factors.
fn radical(polynomial: &IntegerPolynomial) -> IntegerPolynomial {
    let (zeros, rest) = polynomial.without_zeros();
    let mut coefficients = vec![BigInt::one()];
    for (factor, _) in squarefree(&rest) {
        let mut product = vec![BigInt::zero(); coefficients.len() + factor.degree()];
        for (i, a) in coefficients.iter().enumerate() {
            for (j, b) in factor.coefficients().iter().enumerate() {
                product[i + j] += a * b;
            }
        }
        coefficients = product;
    }
    if zeros > 0 {
        coefficients.insert(0, BigInt::zero());
    }
    IntegerPolynomial::new(coefficients)
}

/// Whether M is diagonal and positive, C and K are symmetric and C M⁻¹ K = K M⁻¹ C: then all three
/// are diagonal in one basis of real shapes.
fn has_real_shapes(system: &System) -> bool {
    let Equation {
        mass,
        damping,
        stiffness,
    } = Equation::of(system);
    let n = system.len();
    let positive = (0..n).all(|i| *mass.at(i, i) > BigRational::zero());
    let diagonal = mass.nonzeros().all(|(i, j, _)| i == j);
    let symmetric = |matrix: &RationalMatrix| *matrix == matrix.transposed();
    if !(positive && diagonal && symmetric(&damping) && symmetric(&stiffness)) {
        return false;
    }
    let scaled = mass.solve(&stiffness).expect("a positive diagonal");
    symmetric(&damping.times(&scaled))
}

#[cfg(test)]
mod tests {
    use eigentone_modes::{GROUND, System};

    use super::*;

    fn shapes(system: &System) -> Vec<Shape> {
        let reference = Reference::with_digits(40);
        let modes = reference.modes(system).expect("it is small");
        reference.shapes(system, &modes).expect("it is small")
    }

    fn chain(stiffness: [f64; 4], damping: [f64; 4]) -> System {
        let nodes = [GROUND, "a", "b", "c", GROUND];
        let mut builder = System::builder()
            .mass("a", 1.0)
            .mass("b", 1.0)
            .mass("c", 1.0);
        for (k, ends) in nodes.windows(2).enumerate() {
            builder = builder.spring(ends[0], ends[1], stiffness[k]);
            if damping[k] != 0.0 {
                builder = builder.damper(ends[0], ends[1], damping[k]);
            }
        }
        builder.build().expect("a system")
    }

    fn text(shape: &Shape) -> Vec<(String, String)> {
        let Shape::Determined(components) = shape else {
            panic!("{shape:?}")
        };
        let digits = |ball: &Ball| ball.decided(20).expect("40 digits are known");
        let parts = components.iter();
        parts.map(|x| (digits(&x.re), digits(&x.im))).collect()
    }

    #[test]
    fn a_uniform_chain_has_sines_for_shapes_and_nodes_at_rest() {
        let half = "7.0710678118654752440e-1".to_owned();
        let one = "1.0000000000000000000e0".to_owned();
        let zero = "0".to_owned();
        for damping in [[0.0; 4], [0.1; 4]] {
            let shapes = shapes(&chain([1.0; 4], damping));
            let expected = [
                [half.clone(), one.clone(), half.clone()],
                [one.clone(), zero.clone(), format!("-{one}")],
                // Of equal sizes the first is 1; here the middle one alone is the largest.
                [format!("-{half}"), one.clone(), format!("-{half}")],
            ];
            for (mode, expected) in expected.iter().enumerate() {
                for conjugate in 0..2 {
                    let found = text(&shapes[2 * mode + conjugate]);
                    for (found, expected) in found.iter().zip(expected) {
                        assert_eq!(found, &(expected.clone(), zero.clone()));
                    }
                }
            }
        }
    }

    #[test]
    fn a_damped_shape_solves_its_equation() {
        let system = chain([1.0, 2.0, 3.0, 4.0], [0.5, 0.0, 0.0, 0.0]);
        let reference = Reference::with_digits(40);
        let modes = reference.modes(&system).expect("it is small");
        let shapes = reference.shapes(&system, &modes).expect("it is small");
        let Equation {
            mass,
            damping,
            stiffness,
        } = Equation::of(&system);
        for (root, shape) in modes.eigenvalues().iter().zip(&shapes) {
            let Shape::Determined(x) = shape else {
                panic!("{shape:?}")
            };
            let lambda = Complex {
                re: root.re.clone(),
                im: root.im.clone(),
            };
            for i in 0..3 {
                let mut sum = Complex::real(Ball::zero());
                for (j, x) in x.iter().enumerate() {
                    let part = |matrix: &RationalMatrix| {
                        Complex::real(Ball::rational(matrix.at(i, j), 256))
                    };
                    let inner = &(&part(&mass) * &lambda) + &part(&damping);
                    let entry = &(&inner * &lambda) + &part(&stiffness);
                    let x = Complex {
                        re: x.re.clone(),
                        im: x.im.clone(),
                    };
                    sum = &sum + &(&entry * &x);
                }
                assert!(sum.contains_zero());
                assert!(sum.re.radius().max(sum.im.radius()) < 1e-30);
            }
        }
    }

    #[test]
    fn a_repeated_root_without_one_shape_has_none_and_a_defective_one_has_one() {
        let twins = System::builder()
            .mass("a", 1.0)
            .mass("b", 1.0)
            .spring(GROUND, "a", 2.0)
            .spring(GROUND, "b", 2.0)
            .build()
            .expect("a system");
        let found = shapes(&twins);
        assert!(found.iter().all(|shape| matches!(shape, Shape::Several)));
        let critical = System::builder()
            .mass("a", 1.0)
            .spring(GROUND, "a", 1.0)
            .damper(GROUND, "a", 2.0)
            .build()
            .expect("a system");
        let found = shapes(&critical);
        assert_eq!(found.len(), 1);
        assert!(matches!(&found[0], Shape::Determined(x) if x.len() == 1));
    }
}
