//! What is checked of the checks:
//!
//! - `one_mass`: the closed form against 34-digit truths, published numbers and textbook formulas;
//! - `integrators`: their order, their tolerance, the laws they keep and what they foretell;
//! - `comparisons`: the measure of error, and what a comparison does with methods that fail.

mod comparisons;
mod integrators;
mod one_mass;
mod scenes;
