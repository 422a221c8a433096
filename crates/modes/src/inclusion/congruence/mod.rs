//! All frequencies of an undamped system at once, from approximate shapes, in O(n³).
//!
//! For square X the pencils (K, M) and (XᵀKX, XᵀMX) have the same eigenvalues, and good shapes make both
//! forms nearly diagonal. What they leave off the diagonal bounds all frequencies ([`forms`]) and how much the shapes
//! are still mixed ([`mixing`]), once the shapes are refined ([`refine`]).

mod closer;
mod corrected;
mod elastic;
mod enclose;
mod forms;
mod mixing;
mod refine;
mod squares;
#[cfg(test)]
mod tests;

pub(crate) use elastic::certify;
pub(super) use forms::Basis;
pub(super) use refine::Goal;
pub(crate) use squares::refined;
pub(super) use squares::{Precise, Squares, precise, squares};
