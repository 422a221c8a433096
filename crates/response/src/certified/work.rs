//! What an attempt at a proven answer costs.

use crate::answer::Wanted;
use crate::problem::{Hold, Load, Problem};

/// The most operations, in units of one with 32 digits.
pub(super) const MOST_WORK: f64 = 3e10;

/// What the generator takes, in cubes of the number of states.
const GENERATOR: f64 = 8.0;

/// Where an attempt with more digits takes more than this, none with still more comes after it.
pub(super) const MOST_MORE: f64 = 2e9;

/// About how many operations it takes with so many limbs, and so many for the generator, in units of one with 32 digits. The
/// exponential of a step that is not very stiff takes some 60 products, `squarings` included; stiffer ones more.
pub(crate) fn work(
    problem: &Problem<'_>,
    wanted: &Wanted<'_>,
    [limbs, prepared]: [usize; 2],
    squarings: f64,
) -> f64 {
    let states = (2 * problem.system().len() + load_states(problem)) as f64;
    let instants = wanted.count(problem.grid()) as f64;
    let pieces = problem.timeline().pieces();
    let off_grid = pieces
        .iter()
        .filter(|piece| piece.start_instant().fraction().is_none());
    // An instant off the grid takes an exponential of its own, and one back to the grid.
    let exponentials = 1.0
        + 2.0 * off_grid.count() as f64
        + match wanted {
            Wanted::Times(_) => instants,
            _ => 0.0,
        };
    let steps = instants + pieces.len() as f64;
    let one = |limbs: usize| match limbs {
        1 => 1.0,
        _ => 4.0 + (limbs * limbs) as f64 / 8.0,
    };
    let products = 60.0 + (squarings - 20.0).max(0.0);
    let asked = problem.sources().len()
        + match problem.wants_acceleration() {
            true => problem.system().len(),
            false => 0,
        };
    let march = products * exponentials * states.powi(3)
        + 2.0 * steps * states * states
        + instants * asked as f64 * states;
    march * one(limbs) + GENERATOR * states.powi(3) * one(prepared)
}

/// How many states the loads make: sine and cosine of each frequency, force and slope on each coordinate or channel, and
/// the integrals of channels.
fn load_states(problem: &Problem<'_>) -> usize {
    let mut laws: Vec<(u8, u64)> = Vec::new();
    for (number, applied) in (0..).zip(problem.drives()) {
        let on = applied.coordinate as u64;
        match &applied.load {
            Load::Impulse(_) | Load::Polynomial(_) => {}
            Load::Harmonic(load) => {
                let frequency = load.frequency.to_bits();
                laws.extend([(0, frequency), (1, frequency)]);
            }
            Load::Samples(samples) if samples.hold == Hold::First => {
                laws.extend([(2, on), (3, on)]);
            }
            Load::Ramp(_) => laws.extend([(2, on), (3, on)]),
            Load::HalfSine(_) => laws.extend([(4, number), (5, number)]),
            Load::Versine(_) => laws.extend([(2, on), (4, number), (5, number)]),
            Load::Step(_) | Load::Samples(_) => laws.push((2, on)),
        }
    }
    laws.sort_unstable();
    laws.dedup();
    let channels = problem.channels().iter();
    laws.len() + channels.map(|channel| channel.integrals).sum::<usize>()
}
