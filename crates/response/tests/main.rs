//! Motions from outside.
//!
//! They are one program, which takes less time to build than one of each file.

mod between;
mod closed_form;
mod decay_to_rest;
mod designs;
#[path = "elements/main.rs"]
mod elements;
mod energy;
#[path = "expm/main.rs"]
mod expm;
mod exponential;
mod frequency_response;
mod history;
mod machines;
mod modal_truncation;
mod random;
#[path = "response_spectrum/main.rs"]
mod response_spectrum;
#[path = "state_space/main.rs"]
mod state_space;
mod steady_state;
mod systems;
