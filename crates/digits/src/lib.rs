//! Arithmetic with more digits than a double has, and with proven error bounds.
//!
//! | type | what it is |
//! |---|---|
//! | [`DoubleDouble`] | an unevaluated sum of two doubles, about 32 digits |
//! | [`Wide`] | a binary float of a fixed number of limbs of 64 bits |
//! | [`WideComplex`], [`ComplexDoubleDouble`] | pairs of them |
//! | [`Magnitude`] | a size or an error, always rounded up |
//! | [`Ball`], [`BallMatrix`] | a complex number, and a real matrix, with a proven bound of the error |
//! | [`Lanes`] | several double-doubles that are summed together |
//!
//! [`Real`] is what doubles and both kinds of longer numbers have in common, so that kernels are written
//! once for all. Of full matrices of doubles there are the [`product`], factors ([`Lu`], [`Cholesky`]), eigenvalues ([`eigen`],
//! [`symmetric_eigen`]) and singular values ([`svd`]). There is no mechanics here, and nothing that prints or reads files.
//!
//! ```
//! use eigentone_digits::DoubleDouble;
//!
//! // A third of 1, three times, is 1 to 32 digits.
//! let third = DoubleDouble::from(1.0) / DoubleDouble::from(3.0);
//! let rest = third + third + third - DoubleDouble::from(1.0);
//! assert!(rest.to_f64().abs() < 1e-31);
//! // A double alone is off by more than that.
//! assert!((third - DoubleDouble::from(1.0 / 3.0)).to_f64().abs() > 1e-17);
//! ```

mod ball;
mod ball_matrix;
mod complex;
mod dense;
mod double_double;
mod lanes;
mod magnitude;
mod multiples;
mod products;
mod radii;
#[cfg(test)]
mod rational;
mod real;
mod reflections;
mod slices;
mod sorting;
mod symmetric_eigen;
mod tridiagonal;
mod wide;

pub use ball::Ball;
pub use ball_matrix::BallMatrix;
pub use complex::{ComplexDoubleDouble, WideComplex, modulus};
pub use dense::{
    Cholesky, Entry, Lu, RealEigen, eigen, eigenvalues, real_eigen, singular_values, svd, thin_svd,
};
pub use double_double::{DoubleDouble, parts};
pub use lanes::Lanes;
pub use magnitude::Magnitude;
pub use products::{even, product, settle, workspace};
pub use real::{Real, decimal_digits};
pub use sorting::sort_by_number;
pub use symmetric_eigen::{
    definite_eigen, quick_definite_eigen, quick_symmetric_eigen, symmetric_eigen,
    symmetric_eigenvalues,
};
pub use wide::Wide;
