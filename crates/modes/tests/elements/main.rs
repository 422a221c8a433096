//! Matrices of finite elements, as engineers bring them, against their own roots to 60 digits.

mod damped;
mod mesh;
mod truth;
mod undamped;
