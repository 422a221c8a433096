//! A reference in more digits that shares no code with what it checks.
//!
//! It takes a system's elements and a problem's loads as they are given, every double exact, and
//! goes another way than the solvers and methods that it is compared with, in an arithmetic of its
//! own: balls on whole numbers of any length. Every value comes with a radius that is proven.
//!
//! | | elsewhere | here |
//! |---|---|---|
//! | eigenvalues | determinants in balls at approximate roots, Weierstrass's corrections | the exact characteristic polynomial, its squarefree factors, discs of Laguerre |
//! | response | energy coordinates, a Taylor polynomial in blocks, bounds of norms | exact fractions to first order with the loads as states, scaling and squaring, bounds of entries |

mod aberth;
mod ball;
mod characteristic_polynomial;
mod complex;
mod derived;
mod driven_form;
mod elementary;
mod equation;
mod error;
mod events;
mod exponential;
mod first_order_form;
mod fixed_matrix;
mod integer_polynomial;
mod isolation;
mod limbs;
mod march;
mod modes;
mod pi_polynomial;
mod prime_field;
mod rational_matrix;
mod remainders;
mod response;
mod rest;
mod shape;

pub use ball::Ball;
pub(crate) use elementary::pi;
pub use error::ReferenceError;
pub use modes::{EigenvalueError, ReferenceEigenvalue, ReferenceModes};
pub use response::ReferenceResponse;
pub use shape::{Shape, ShapeComponent};

/// How many digits are wanted, and how much they may cost.
///
/// ```
/// use eigentone_check::Reference;
/// use eigentone_modes::{GROUND, System};
/// use eigentone_response::{Response, Step};
///
/// let system = System::builder()
///     .mass("m", 1.0)
///     .spring(GROUND, "m", 2.0)
///     .build()?;
/// let reference = Reference::with_digits(34);
///
/// let modes = reference.modes(&system)?;
/// let frequency = &modes.eigenvalues()[0].im;
/// assert_eq!(frequency.to_decimal(34), "1.414213562373095048801688724209698e0");
/// assert!(modes.error_of(&system.modes()?)?.modulus < 1.2e-16);
///
/// let problem = Response::of(&system)
///     .load("m", Step::of(1.0))
///     .every(0.5)
///     .until(10.0)
///     .problem()?;
/// let response = reference.response(&problem)?;
/// let swing = (1.0 - (10.0 * 2f64.sqrt()).cos()) / 2.0;
/// assert!(response.displacement(20)[0].minus(swing).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference {
    digits: u32,
    work: f64,
}

impl Default for Reference {
    /// 34 digits.
    fn default() -> Reference {
        Reference::with_digits(34)
    }
}

impl Reference {
    /// A reference with so many correct decimal digits, at the cost of at most 1e9 multiplications
    /// (a minute or two).
    pub fn with_digits(digits: u32) -> Reference {
        Reference { digits, work: 1e9 }
    }

    /// The same with another limit on the multiplications of whole numbers, of which a core does
    /// some ten million in a second.
    pub fn within(self, multiplications: f64) -> Reference {
        Reference {
            work: multiplications,
            ..self
        }
    }

    fn afford(&self, work: f64) -> Result<(), ReferenceError> {
        let limit = self.work;
        match work <= limit {
            true => Ok(()),
            false => Err(ReferenceError::TooMuchWork { work, limit }),
        }
    }
}
