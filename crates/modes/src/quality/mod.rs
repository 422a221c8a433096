//! How far a root and its shape may be off. It knows `model`, `modes` and `system`.

pub(crate) mod bordered;
pub(crate) mod pencil;
pub(crate) mod rayleigh;
pub(crate) mod real_forms;
mod rounded;
