//! All finite eigenvalues, each with a bound of its error.

use std::cmp::Ordering;

use eigentone_modes::{Eigenvalue, Modes, System};

use super::Reference;
use super::ball::Ball;
use super::characteristic_polynomial::WholePencil;
use super::complex::Complex;
use super::error::ReferenceError;
use super::integer_polynomial::{IntegerPolynomial, squarefree};
use super::isolation::{is_known, roots};
use crate::trajectory_error::greater;

/// A root λ of det(λ²M + λC + K).
#[derive(Clone, Debug)]
pub struct ReferenceEigenvalue {
    /// Its real part, in 1/s; 0 without a radius where it is 0.
    pub re: Ball,
    /// Its imaginary part, in rad/s; 0 without a radius where it is 0.
    pub im: Ball,
    /// How often it is a root.
    pub multiplicity: usize,
}

/// All finite roots of det(λ²M + λC + K), each within a radius that is proven.
#[derive(Clone, Debug)]
pub struct ReferenceModes {
    eigenvalues: Vec<ReferenceEigenvalue>,
    infinite: usize,
}

/// How far eigenvalues are off. Roots are paired, the largest first, with the nearest that is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EigenvalueError {
    /// The largest |λ̂ − λ|/|λ|; infinite where a zero root is not exactly 0.
    pub modulus: f64,
    /// The largest |Re λ̂ − Re λ|/|Re λ|, in units of |λ| where Re λ = 0.
    pub real_part: f64,
}

impl Reference {
    /// The finite eigenvalues of `system`.
    ///
    /// det(λ²M + λC + K) is expanded exactly: its whole coefficients are put together from
    /// determinants modulo primes. Multiplicities are read from its squarefree factors, and what has
    /// −λ for a root with λ is solved for λ², so that imaginary roots are exactly imaginary. The roots
    /// of each factor come from the iteration of Ehrlich and Aberth, in disjoint discs, with more bits
    /// until each part of a root is known to 10^−digits of itself or 10^−(2·digits) of |λ|.
    ///
    /// # Errors
    /// [`ReferenceError`] where the work is too much or so many digits cannot be reached.
    pub fn modes(&self, system: &System) -> Result<ReferenceModes, ReferenceError> {
        let n = system.len() as f64;
        self.afford(n.powi(3))?;
        let pencil = WholePencil::of(system);
        // A sweep costs some twenty products for each pair of roots, and there are about forty;
        // ten multiplications modulo a prime take the time of one of long numbers.
        self.afford(pencil.work() / 10.0 + 800.0 * (2.0 * n).powi(2))?;
        let polynomial = pencil.polynomial();
        let infinite = 2 * system.len() - polynomial.degree();
        let (zeros, polynomial) = polynomial.without_zeros();
        let mut eigenvalues = Vec::new();
        if zeros > 0 {
            eigenvalues.push(ReferenceEigenvalue {
                re: Ball::zero(),
                im: Ball::zero(),
                multiplicity: zeros,
            });
        }
        for (factor, multiplicity) in squarefree(&polynomial) {
            let found = self.roots(&factor)?;
            eigenvalues.extend(found.into_iter().map(|root| ReferenceEigenvalue {
                re: root.re,
                im: root.im,
                multiplicity,
            }));
        }
        eigenvalues.sort_by(order);
        Ok(ReferenceModes {
            eigenvalues,
            infinite,
        })
    }

    /// The roots of a squarefree polynomial with p(0) ≠ 0.
    fn roots(&self, polynomial: &IntegerPolynomial) -> Result<Vec<Complex>, ReferenceError> {
        let even = polynomial.common_divisor(&polynomial.mirrored());
        let rest = polynomial.divided_by(&even).expect("a divisor");
        let mut found = match rest.degree() {
            0 => Vec::new(),
            _ => roots(&rest, self.digits)?,
        };
        let squares = even
            .halved()
            .expect("it is its own mirror image, and 0 is no root");
        if squares.degree() == 0 {
            return Ok(found);
        }
        // The root of a square that is nearly real or nearly imaginary has a small part.
        let mut digits = self.digits + 1;
        loop {
            // A square that was met exactly may have too few bits for its root.
            let bits = (2.0 * f64::from(digits) * std::f64::consts::LOG2_10) as u64 + 64;
            let squares = roots(&squares, digits)?.into_iter();
            let pairs: Vec<Complex> = squares.map(|z| z.with_at_least(bits).sqrt()).collect();
            if pairs.iter().all(|root| is_known(root, self.digits)) {
                found.extend(pairs.into_iter().flat_map(|root| [root.clone(), -root]));
                return Ok(found);
            }
            digits *= 2;
        }
    }
}

impl ReferenceModes {
    /// The distinct finite eigenvalues, sorted by |λ|, then Re λ, then + before − Im λ.
    pub fn eigenvalues(&self) -> &[ReferenceEigenvalue] {
        &self.eigenvalues
    }

    /// How many of the 2n roots are infinite.
    pub fn infinite(&self) -> usize {
        self.infinite
    }

    /// How far the eigenvalues of `modes` are off, measured far below the last place of a double.
    ///
    /// # Errors
    /// [`ReferenceError::OtherProblem`] where their number is another.
    pub fn error_of(&self, modes: &Modes) -> Result<EigenvalueError, ReferenceError> {
        let mut left = modes.eigenvalues().to_vec();
        let all = self.eigenvalues.iter().rev();
        let all = all.flat_map(|root| std::iter::repeat_n(root, root.multiplicity));
        let mut worst = EigenvalueError {
            modulus: 0.0,
            real_part: 0.0,
        };
        for root in all {
            let distance = |found: &Eigenvalue| {
                root.re
                    .minus(found.value.re)
                    .hypot(root.im.minus(found.value.im))
            };
            let distances = left.iter().map(distance).enumerate();
            let nearest = distances.min_by(|a, b| a.1.total_cmp(&b.1));
            let (position, off) = nearest.ok_or(ReferenceError::OtherProblem)?;
            let found = left.swap_remove(position);
            let size = root.size();
            let real = root.re.nearest().abs();
            let real = if real == 0.0 { size } else { real };
            worst.modulus = greater(worst.modulus, ratio(off, size));
            let real_off = root.re.minus(found.value.re).abs();
            worst.real_part = greater(worst.real_part, ratio(real_off, real));
        }
        match left.is_empty() {
            true => Ok(worst),
            false => Err(ReferenceError::OtherProblem),
        }
    }
}

impl ReferenceEigenvalue {
    fn size(&self) -> f64 {
        self.re.nearest().hypot(self.im.nearest())
    }
}

fn order(a: &ReferenceEigenvalue, b: &ReferenceEigenvalue) -> Ordering {
    let parts = |root: &ReferenceEigenvalue| (root.re.nearest(), root.im.nearest());
    let ((a_re, a_im), (b_re, b_im)) = (parts(a), parts(b));
    a.size()
        .total_cmp(&b.size())
        .then(a_re.total_cmp(&b_re))
        .then(b_im.total_cmp(&a_im))
}

/// error/unit, where no error needs no unit.
fn ratio(error: f64, unit: f64) -> f64 {
    if error == 0.0 { 0.0 } else { error / unit }
}
