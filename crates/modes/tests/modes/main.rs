//! Modes from outside.
//!
//! - `closed_form`: frequencies and damping that formulas give, in twice a double's digits.
//! - `dense`: full matrices without any pattern, well and ill conditioned.
//! - `planted`: systems built from chosen poles and shapes.
//! - `estimated`: bounds in doubles cover what proven answers show.
//! - `shapes`: shapes that formulas give, with their bounds.
//! - `singular_mass`: infinite roots beyond those of massless nodes, beside roots from FLINT.
//! - `law`: what does not depend on numbers: units, order, conjugates, signs, counts.

mod closed_form;
mod dense;
mod estimated;
mod law;
mod networks;
mod planted;
mod random;
mod root;
mod shapes;
mod singular_mass;
