//! What the loads of a problem are at an instant, by coordinate and law.

use eigentone_digits::DoubleDouble;
use faer::{Mat, MatRef};

use super::laws::Laws;
use crate::problem::{Instant, Piece, Problem};

/// What the loads are at the start of an interval: for each law one value for each loaded
/// coordinate, in the order of [`crate::hold::Held::gamma`]; slopes are multiplied by the
/// interval's length.
#[derive(Clone, Debug)]
pub(crate) struct Signals {
    pub(crate) values: Vec<Vec<f64>>,
}

/// The loads of a problem, by loaded coordinate.
#[derive(Clone, Debug)]
pub(crate) struct Inputs {
    /// Indices of the coordinates that any load but an impulse acts on.
    pub(crate) loaded: Vec<usize>,
    pub(crate) laws: Laws,
    /// Position in `loaded`, position in `laws.frequencies`, amplitude, phase.
    harmonics: Vec<(usize, usize, f64, f64)>,
}

impl Inputs {
    pub(crate) fn of(problem: &Problem<'_>) -> Inputs {
        let timeline = problem.timeline();
        let straight = || timeline.pieces().iter().flat_map(Piece::straight);
        let mut loaded: Vec<usize> = straight().map(|straight| straight.coordinate).collect();
        loaded.extend(
            timeline
                .harmonics()
                .iter()
                .map(|(coordinate, _)| *coordinate),
        );
        loaded.sort_unstable();
        loaded.dedup();
        let mut frequencies: Vec<f64> = Vec::new();
        let mut harmonics = Vec::new();
        for (coordinate, harmonic) in timeline.harmonics() {
            let position = loaded.binary_search(coordinate).expect("collected above");
            let known = frequencies
                .iter()
                .position(|known| *known == harmonic.frequency);
            let frequency = known.unwrap_or_else(|| {
                frequencies.push(harmonic.frequency);
                frequencies.len() - 1
            });
            harmonics.push((position, frequency, harmonic.amplitude, harmonic.phase));
        }
        let laws = Laws {
            straight: straight().any(|s| s.value != 0.0 || s.slope != 0.0),
            sloped: straight().any(|s| s.slope != 0.0),
            frequencies,
        };
        Inputs {
            loaded,
            laws,
            harmonics,
        }
    }

    /// The columns of B for the loaded coordinates.
    pub(crate) fn columns(&self, b: MatRef<'_, f64>) -> Mat<f64> {
        Mat::from_fn(b.nrows(), self.loaded.len(), |i, j| b[(i, self.loaded[j])])
    }

    /// The signals at `now`, within `piece`, for an interval of `h` seconds.
    pub(crate) fn signals(&self, now: &Instant, piece: &Piece, h: f64, signals: &mut Signals) {
        for values in &mut signals.values {
            values.fill(0.0);
        }
        let elapsed = (now.time - piece.start.time).to_f64();
        if self.laws.straight {
            for straight in piece.straight() {
                let j = self
                    .loaded
                    .binary_search(&straight.coordinate)
                    .expect("collected in of");
                signals.values[0][j] = straight.value + straight.slope * elapsed;
                if self.laws.sloped {
                    signals.values[1][j] = straight.slope * h;
                }
            }
        }
        let first = usize::from(self.laws.straight) + usize::from(self.laws.sloped);
        for &(j, frequency, amplitude, phase) in &self.harmonics {
            let angle = reduced_angle(self.laws.frequencies[frequency], now.time, phase);
            let (sine, cosine) = angle.sin_cos();
            signals.values[first + 2 * frequency][j] += amplitude * sine;
            signals.values[first + 2 * frequency + 1][j] += amplitude * cosine;
        }
    }

    pub(crate) fn empty_signals(&self) -> Signals {
        Signals {
            values: vec![vec![0.0; self.loaded.len()]; self.laws.blocks()],
        }
    }

    /// f, f′ and f″ on every coordinate at `now`, of those loads that are not `split` off.
    pub(crate) fn forces(
        &self,
        now: &Instant,
        piece: &Piece,
        split: bool,
        forces: &mut [Vec<f64>; 3],
    ) {
        for force in forces.iter_mut() {
            force.fill(0.0);
        }
        let elapsed = (now.time - piece.start.time).to_f64();
        for straight in piece.straight().iter().filter(|_| !split) {
            forces[0][straight.coordinate] += straight.value + straight.slope * elapsed;
            forces[1][straight.coordinate] += straight.slope;
        }
        for &(j, frequency, amplitude, phase) in &self.harmonics {
            let rate = self.laws.frequencies[frequency];
            let (sine, cosine) = reduced_angle(rate, now.time, phase).sin_cos();
            let coordinate = self.loaded[j];
            forces[0][coordinate] += amplitude * sine;
            forces[1][coordinate] += amplitude * rate * cosine;
            forces[2][coordinate] -= amplitude * rate * rate * sine;
        }
    }
}

/// Ωt + φ less whole turns, kept in double-double until the end.
pub(crate) fn reduced_angle(frequency: f64, time: DoubleDouble, phase: f64) -> f64 {
    let angle = time * frequency;
    let turns = (angle.to_f64() / std::f64::consts::TAU).round();
    let rest = angle - DoubleDouble::TAU * turns + phase;
    rest.to_f64()
}
