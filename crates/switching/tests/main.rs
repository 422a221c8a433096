//! Motions with switches from outside.
//!
//! They are one program, which takes less time to build than one of each file.

mod closed_forms;
mod cycles;
mod passages;
mod random;
mod skyhook;
