//! The answer to a unit harmonic force.

use eigentone_modes::System;

use super::dynamic_stiffness::Part;
use super::harmonic_motion::{HarmonicMotion, SteadyStateError, motion};
use super::phasor::Phase;
use super::ports::Push;

/// The receptances of a system at `frequency` rad/s: the amplitudes of all coordinates, in m for
/// each N, under the force e^{iΩt} on the coordinate `on`. That is one column of
/// (K − Ω²M + iΩC)⁻¹; [`velocity`](HarmonicMotion::velocity) is that of the mobility and
/// [`acceleration`](HarmonicMotion::acceleration) that of the accelerance.
///
/// # Errors
/// [`SteadyStateError`] for a name that is no coordinate, a frequency that is not finite, and where
/// there is no steady motion or more than one.
pub fn receptance(
    system: &System,
    on: &str,
    frequency: f64,
) -> Result<HarmonicMotion, SteadyStateError> {
    if !frequency.is_finite() {
        return Err(SteadyStateError::FrequencyNotFinite { frequency });
    }
    let coordinate = system
        .index_of(on)
        .ok_or_else(|| SteadyStateError::UnknownCoordinate {
            name: on.to_owned(),
            known: system.names().join(", "),
        })?;
    let force = Push {
        coordinate,
        part: Part::of(0, [1.0; 2]),
        phase: Phase::Zero,
    };
    motion(system, frequency, &[force])
}
