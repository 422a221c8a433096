//! Some modes of large systems.
//!
//! - `chains`: closed forms of chains of any length, held, free, massless in between, with a
//!   consistent mass matrix.
//! - `counts`: completeness of damped modes against winding numbers in 384 bits.
//! - `damped`: damped modes against the dense solvers, and against counts in small discs in 384 bits.
//! - `given`: eigenpairs from elsewhere, spoilt, against closed forms and proven roots.
//! - `grids`: closed forms of grids and rings, whose eigenvalues are multiple: none may be lost.
//! - `small`: every mode of small random systems against the proven ones of the dense solvers.
//! - `undamped`: finite elements against counts of their eigenvalues in 384 bits.
//! - `refusals`: what cannot be answered says why.

mod chains;
mod counts;
mod damped;
mod elements;
mod given;
mod grids;
mod inertia;
mod networks;
#[path = "../modes/random.rs"]
mod random;
mod refusals;
mod small;
mod undamped;
