//! Matrices with a bound of their error in the 2-norm, their exponentials and Gramians, and energy coordinates. It knows no other room.

mod energy;
mod exponential;
mod gramian;
mod normed;
mod row;

pub(crate) use energy::{Energy, frobenius};
pub(crate) use exponential::{
    Halves, cos_sin, counted, exponential, of_any_size, products, squarings,
};
pub(crate) use gramian::gramian;
pub(crate) use normed::{Normed, growth};
pub(crate) use row::add_multiple;
