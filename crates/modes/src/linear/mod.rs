//! Eigenproblems of plain matrices of doubles, and what they need. It knows no mechanics and no other file of the crate.

mod balance;
pub(crate) mod eigenpairs;
pub(crate) mod jacobi;
pub(crate) mod plain_matrix;
pub(crate) mod small;
pub(crate) mod wide;

pub use balance::{Balanced, balance};
pub use eigenpairs::eigenvalues;
