//! Response spectra: the largest motions of one-mass systems on a base that is shaken. It knows `problem` and `enclosed`.

mod base;
mod baseline;
mod error;
mod maps;
mod oscillator;
mod peak;
mod search;
mod spectrum;

pub use base::BaseAcceleration;
pub use baseline::Baseline;
pub use error::SpectrumError;
pub use spectrum::{ResponseSpectrum, SpectralPeak};
