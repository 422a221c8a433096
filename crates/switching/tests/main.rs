//! Motions with switches from outside.
//!
//! They are one program, which takes less time to build than one of each file.

#[path = "../../../tests/row/mod.rs"]
mod row;

mod closed_forms;
mod cycles;
mod passages;
mod random;
mod skyhook;
