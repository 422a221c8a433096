//! One exact interval: the laws of the loads within it, and what they and the state make of each other. It knows
//! `problem`, and exponentials as functions that it is given.

mod exact;
mod laws;
mod signals;

pub(crate) use exact::{Held, accumulate, exact};
pub(crate) use laws::Laws;
pub(crate) use signals::{CANCELS, Inputs};
