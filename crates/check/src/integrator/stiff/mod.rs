//! Methods for stiff systems by the crate `diffsol`: backward differences and diagonally implicit
//! Runge–Kutta methods.

mod bdf;
mod diffsol;
mod esdirk34;
mod marching;
mod tr_bdf2;

pub use bdf::Bdf;
pub use esdirk34::Esdirk34;
pub use tr_bdf2::TrBdf2;
