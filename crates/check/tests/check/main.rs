//! What is checked of the checks:
//!
//! - `coincidence`: roots that coincide or nearly do, by the modes, against the reference;
//! - `machines`: points, supports and nodes without mass at random, against the reference;
//! - `one_mass`: the closed form against 34-digit truths, published numbers and textbook formulas;
//! - `closed_forms`: one mass, uniform chains and undamped pairs in more digits against exponentials;
//! - `integrators`: their order, their tolerance, the laws they keep and what they foretell;
//! - `reference`: the reference in more digits against closed forms, its laws, and what it refuses;
//! - `motions`: supports that move, by the exact methods and by an integrator;
//! - `switched`: motions with switches at random, by integrators that locate events;
//! - `comparisons`: the measure of error, and what a comparison does with methods that fail.

#[path = "../../../../tests/page/mod.rs"]
mod page;
#[path = "../../../../tests/row/mod.rs"]
mod row;

mod closed_forms;
mod coincidence;
mod comparisons;
mod frequency;
mod integrators;
mod machines;
mod motions;
mod one_mass;
mod reference;
mod scenes;
mod stability;
mod switched;
