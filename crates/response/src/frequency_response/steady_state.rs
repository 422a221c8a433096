//! What remains of a damped motion under harmonic loads once the transient has died out.

use super::dynamic_stiffness::Part;
use super::harmonic_motion::{HarmonicMotion, SteadyStateError, motion};
use super::phasor::Phase;
use super::ports::Push;
use crate::problem::{Load, Problem};

/// The steady state under a problem's harmonic loads: for each of their frequencies Ω the complex
/// amplitudes X, in m, with (K − Ω²M + iΩC) X = F. Loads of other kinds and of amplitude 0 add nothing to it.
///
/// The loads of one frequency sum to F = Σ amplitude·e^{i·phase}, so that the motion is
///
/// x(t) = Σ Im(X e^{iΩt}) = Σ |X| sin(Ωt + arg X),
///
/// with one term for each frequency, just as a load is amplitude·sin(Ωt + phase). It is a motion that these loads allow from
/// −∞ on; others under them approach it where every free motion decays. Where there are roots at 0, a constant distance or a
/// steady course may remain between them, and other loads that last move all by what they do by themselves: about what each
/// coordinate moves says [`Summary::mean`](crate::Summary::mean). A load of frequency 0 is the constant
/// force amplitude·sin(phase): then X is i times the static displacement; where no springs hold what it acts on, it adds
/// nothing beside loads of other frequencies, as any load that lasts. A negative frequency
/// counts as the positive one with the phase that makes it the same force.
///
/// Supports that move by a sinusoid count as loads do. What is given as a velocity or an acceleration swings about a
/// place, or along a straight course, that follows from rest at t = 0: it is no part of the steady state either. With a
/// frequency of 0 it takes the support ever further, and with it what springs join to it: then there is no steady state.
///
/// The equations are solved in ball arithmetic, from the elements, with as many digits as it takes:
/// every amplitude comes with a proven bound.
///
/// ```
/// use eigentone_modes::{GROUND, System};
/// use eigentone_response::{Harmonic, Response, SteadyState};
///
/// // ANSYS verification manual, VM86.
/// let system = System::builder()
///     .mass("m", 0.5)
///     .spring(GROUND, "m", 200.0)
///     .damper(GROUND, "m", 6.0)
///     .build()?;
/// let problem = Response::of(&system)
///     .load("m", Harmonic::of(10.0, 20.0))
///     .every(1.0)
///     .until(1.0)
///     .problem()?;
/// let steady = SteadyState::of(&problem)?;
/// let amplitude = steady.motions()[0].displacement()[0];
/// // At resonance of the undamped system only the damper resists: |X| = F / (Ω c).
/// assert_eq!(amplitude.norm(), 10.0 / (20.0 * 6.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SteadyState {
    motions: Vec<HarmonicMotion>,
}

impl SteadyState {
    /// Solves for the amplitudes under the harmonic loads of `problem`.
    ///
    /// # Errors
    /// [`SteadyStateError`] at a frequency where no steady motion exists or where it is not the
    /// only one, and for a [large](eigentone_modes::System::is_large) system.
    pub fn of(problem: &Problem<'_>) -> Result<SteadyState, SteadyStateError> {
        let n = problem.system().len();
        let mut frequencies: Vec<(f64, Vec<Push>)> = Vec::new();
        let mut travels = false;
        for applied in problem.drives() {
            let Load::Harmonic(load) = &applied.load else {
                continue;
            };
            let frequency = load.frequency.abs();
            let known = frequencies
                .iter()
                .position(|(known, _)| *known == frequency);
            let at = known.unwrap_or_else(|| {
                frequencies.push((frequency, Vec::new()));
                frequencies.len() - 1
            });
            let phase = match load.frequency {
                0.0 => Phase::Still(load.phase),
                negative if negative < 0.0 => Phase::Backward(load.phase),
                _ => Phase::Forward(load.phase),
            };
            let Some(channel) = applied.coordinate.checked_sub(n) else {
                frequencies[at].1.push(Push {
                    coordinate: applied.coordinate,
                    part: Part::of(0, [load.amplitude, 1.0]),
                    phase,
                });
                continue;
            };
            let channel = &problem.channels()[channel];
            if frequency == 0.0 {
                if load.phase == 0.0 {
                    continue;
                }
                // Springs follow its place; dampers, or mass, may meet no more than what is constant.
                let mut growing = channel.directions.iter().take(channel.integrals);
                if growing.any(|direction| !direction.is_empty()) {
                    return Err(SteadyStateError::Drift);
                }
                travels |= channel.integrals > 0;
            }
            for (order, direction) in channel.directions.iter().enumerate() {
                let power = order as i32 - channel.integrals as i32;
                frequencies[at]
                    .1
                    .extend(direction.iter().map(|&(coordinate, factor)| Push {
                        coordinate,
                        part: Part::of(power, [load.amplitude, factor]),
                        phase,
                    }));
            }
        }
        let several = frequencies.len() > 1;
        let mut motions = Vec::with_capacity(frequencies.len());
        for (frequency, pushes) in frequencies {
            match motion(problem.system(), frequency, &pushes) {
                Err(SteadyStateError::Unsupported) if travels => {
                    return Err(SteadyStateError::Drift);
                }
                Err(SteadyStateError::Unsupported) if several => {}
                motion => motions.push(motion?),
            }
        }
        Ok(SteadyState { motions })
    }

    /// One motion for each frequency of loads that are not 0, in the order in which the loads name them.
    pub fn motions(&self) -> &[HarmonicMotion] {
        &self.motions
    }
}
