//! What the loads of a problem are at an instant, by coordinate and law.

use eigentone_digits::DoubleDouble;
use faer::{Mat, MatRef};

use super::laws::Laws;
use crate::problem::{Instant, Piece, Plant, Problem, Pulse, reduced_angle};

/// What the loads are at the start of an interval.
#[derive(Clone, Debug)]
pub(crate) struct Signals {
    /// For each law one value for each loaded input, law after law in the order of [`crate::hold::Held::gamma`]; slopes are
    /// multiplied by the interval's length.
    pub(crate) values: Vec<f64>,
    /// For each loaded input, the sum of the sizes of its parts.
    pub(crate) sizes: Vec<f64>,
}

/// Parts of a load cancel where they are larger than their sum by more than this: what the sum does is then no measure of
/// what their rounding does.
pub(crate) const CANCELS: f64 = 4.0;

/// The loads of a problem, by input of its [`Plant`](crate::problem::Plant).
#[derive(Clone, Debug)]
pub(crate) struct Inputs {
    /// Those that any load but an impulse acts on.
    pub(crate) loaded: Vec<usize>,
    pub(crate) laws: Laws,
    waves: Vec<Wave>,
    /// How many coordinates there are.
    coordinates: usize,
    /// By channel: the orders of derivatives of its signal that act.
    orders: Vec<Vec<usize>>,
    pulses: Vec<Pulse>,
}

/// A sinusoid on an input: amplitude·sin(angle + quarters·π/2).
#[derive(Clone, Debug)]
struct Wave {
    input: usize,
    /// Position in `loaded`.
    position: usize,
    /// Position in `laws.frequencies`.
    frequency: usize,
    amplitude: f64,
    quarters: usize,
    angle: Angle,
}

/// Where the angle of a wave comes from.
#[derive(Clone, Copy, Debug)]
enum Angle {
    /// It is frequency·t and this phase.
    Phase(f64),
    /// It is that of a pulse since its start.
    Pulse(usize),
}

impl Inputs {
    pub(crate) fn of(problem: &Problem<'_>) -> Inputs {
        let timeline = problem.timeline();
        let coordinates = problem.system().len();
        let channels = problem.channels().iter();
        let mut inputs = Inputs {
            loaded: Vec::new(),
            laws: Laws::default(),
            waves: Vec::new(),
            coordinates,
            orders: channels.map(|channel| channel.orders().collect()).collect(),
            pulses: timeline.pulses().to_vec(),
        };
        let straight = || timeline.pieces().iter().flat_map(Piece::straight);
        let harmonics = timeline.harmonics().iter().map(|(on, _)| *on);
        let pulses = timeline.pulses().iter().map(|pulse| pulse.coordinate);
        let signals = straight().map(|straight| straight.coordinate);
        let mut acts = vec![false; coordinates + inputs.orders.len()];
        signals
            .chain(harmonics)
            .chain(pulses)
            .for_each(|signal| acts[signal] = true);
        let mut loaded = Vec::new();
        for signal in (0..acts.len()).filter(|signal| acts[*signal]) {
            loaded.extend(inputs.of_signal(signal).map(|(input, _)| input));
        }
        loaded.sort_unstable();
        loaded.dedup();
        inputs.loaded = loaded;
        inputs.laws.straight = straight().any(|s| s.value != 0.0 || s.slope != 0.0);
        inputs.laws.sloped = straight().any(|s| s.slope != 0.0);
        for (on, harmonic) in timeline.harmonics() {
            let angle = Angle::Phase(harmonic.phase);
            inputs.add(*on, harmonic.frequency, harmonic.amplitude, 0, angle);
        }
        for (index, pulse) in timeline.pulses().iter().enumerate() {
            let (rate, angle) = (pulse.rate.to_f64(), Angle::Pulse(index));
            match pulse.sine != 0.0 {
                true => inputs.add(pulse.coordinate, rate, pulse.sine, 0, angle),
                false => inputs.add(pulse.coordinate, rate, pulse.cosine, 1, angle),
            }
        }
        inputs
    }

    /// The inputs that a signal acts on, each with the order of its derivative there.
    fn of_signal(&self, signal: usize) -> impl Iterator<Item = (usize, usize)> + use<> {
        let mut inputs = [None; 3];
        match signal.checked_sub(self.coordinates) {
            None => inputs[0] = Some((signal, 0)),
            Some(channel) => {
                for order in &self.orders[channel] {
                    let input = self.coordinates + 3 * channel + order;
                    inputs[*order] = Some((input, *order));
                }
            }
        }
        inputs.into_iter().flatten()
    }

    fn add(&mut self, signal: usize, rate: f64, amplitude: f64, quarters: usize, angle: Angle) {
        let known = self
            .laws
            .frequencies
            .iter()
            .position(|known| *known == rate);
        let frequency = known.unwrap_or_else(|| {
            self.laws.frequencies.push(rate);
            self.laws.frequencies.len() - 1
        });
        for (input, order) in self.of_signal(signal) {
            let position = self.loaded.binary_search(&input).expect("collected in of");
            self.waves.push(Wave {
                input,
                position,
                frequency,
                amplitude: amplitude * rate.powi(order as i32),
                quarters: quarters + order,
                angle,
            });
        }
    }

    /// What a wave is `later` s after now, which is next to nothing, and a quarter period ahead; nothing of a pulse that
    /// does not last.
    fn at(&self, wave: &Wave, now: &Instant, later: f64, piece: &Piece) -> Option<[f64; 2]> {
        let angle = match wave.angle {
            Angle::Phase(phase) => {
                let frequency = self.laws.frequencies[wave.frequency];
                reduced_angle(frequency, now.time + later, phase)
            }
            Angle::Pulse(index) if piece.pulses().contains(&index) => self.pulses[index].angle(now),
            Angle::Pulse(_) => return None,
        };
        let (sine, cosine) = angle.sin_cos();
        let turned = match wave.quarters % 4 {
            0 => [sine, cosine],
            1 => [cosine, -sine],
            2 => [-sine, -cosine],
            _ => [-cosine, sine],
        };
        Some(turned.map(|part| wave.amplitude * part))
    }

    /// The columns of B for the loaded inputs.
    pub(crate) fn columns(&self, b: MatRef<'_, f64>) -> Mat<f64> {
        Plant::columns(b, &self.loaded)
    }

    /// The largest amplitude of the sinusoids of each frequency, in rad/s, on each input of the plant.
    pub(crate) fn amplitudes(&self) -> impl Iterator<Item = (f64, Vec<f64>)> + '_ {
        let frequencies = self.laws.frequencies.iter().enumerate();
        frequencies.map(|(index, frequency)| {
            let mut sizes = vec![0.0; self.coordinates + 3 * self.orders.len()];
            for wave in self.waves.iter().filter(|wave| wave.frequency == index) {
                sizes[wave.input] += wave.amplitude.abs();
            }
            (*frequency, sizes)
        })
    }

    /// The signals at `now`, within `piece`, for an interval of `h` seconds that is held for as long as its high part:
    /// sinusoids, which may be fast, are those at the start of that, so that they end as they are at its end.
    pub(crate) fn signals(
        &self,
        now: &Instant,
        piece: &Piece,
        h: DoubleDouble,
        signals: &mut Signals,
    ) {
        let (later, h) = (h.low(), h.high());
        signals.values.fill(0.0);
        signals.sizes.fill(0.0);
        let width = self.loaded.len();
        let elapsed = (now.time - piece.start.time).to_f64();
        for straight in piece.straight().iter().filter(|_| self.laws.straight) {
            for (input, order) in self.of_signal(straight.coordinate) {
                let j = self.loaded.binary_search(&input).expect("collected in of");
                match order {
                    0 => {
                        let grown = straight.slope * elapsed;
                        signals.values[j] = straight.value + grown;
                        signals.sizes[j] += straight.value.abs() + grown.abs();
                        if self.laws.sloped {
                            signals.values[width + j] = straight.slope * h;
                        }
                    }
                    1 => {
                        signals.values[j] = straight.slope;
                        signals.sizes[j] += straight.slope.abs();
                    }
                    _ => {}
                }
            }
        }
        let first = usize::from(self.laws.straight) + usize::from(self.laws.sloped);
        for wave in &self.waves {
            if let Some([here, ahead]) = self.at(wave, now, later, piece) {
                let at = (first + 2 * wave.frequency) * width + wave.position;
                signals.values[at] += here;
                signals.values[at + width] += ahead;
                signals.sizes[wave.position] += here.abs();
            }
        }
    }

    pub(crate) fn empty_signals(&self) -> Signals {
        Signals {
            values: vec![0.0; self.loaded.len() * self.laws.blocks()],
            sizes: vec![0.0; self.loaded.len()],
        }
    }

    /// The [values](Signals::values) of one law after the other.
    pub(crate) fn by_law<'a>(&self, values: &'a [f64]) -> std::slice::ChunksExact<'a, f64> {
        values.chunks_exact(self.loaded.len().max(1))
    }

    /// The sizes of the parts of every input, where they cancel; `None` where none do.
    pub(crate) fn cancelled(&self, signals: &Signals) -> Option<Vec<f64>> {
        let straight = usize::from(self.laws.straight);
        let first = straight + usize::from(self.laws.sloped);
        let laws = self.by_law(&signals.values);
        let waves = laws.clone().skip(first).step_by(2);
        let here = || laws.clone().take(straight).chain(waves.clone());
        let sum = |j: usize| here().map(|values| values[j]).sum::<f64>().abs();
        let cancels = |j: &usize| signals.sizes[*j] > CANCELS * sum(*j);
        let mut inputs = (0..self.loaded.len()).filter(cancels).peekable();
        inputs.peek()?;
        let mut sizes = vec![0.0; self.coordinates + 3 * self.orders.len()];
        inputs.for_each(|j| sizes[self.loaded[j]] = signals.sizes[j]);
        Some(sizes)
    }

    /// f, f′ and f″ of every input at `now`, of those loads that are not `split` off, and the sums of the sizes of
    /// their parts.
    pub(crate) fn forces(
        &self,
        now: &Instant,
        piece: &Piece,
        split: bool,
        forces: &mut [Vec<f64>; 3],
        sizes: &mut [Vec<f64>; 3],
    ) {
        for force in forces.iter_mut().chain(sizes.iter_mut()) {
            force.fill(0.0);
        }
        let mut add = |order: usize, input: usize, part: f64| {
            forces[order][input] += part;
            sizes[order][input] += part.abs();
        };
        let elapsed = (now.time - piece.start.time).to_f64();
        for straight in piece.straight().iter().filter(|_| !split) {
            for (input, order) in self.of_signal(straight.coordinate) {
                if order == 0 {
                    add(0, input, straight.value + straight.slope * elapsed);
                }
                if let Some(left) = 1usize.checked_sub(order) {
                    add(left, input, straight.slope);
                }
            }
        }
        for wave in &self.waves {
            let Some([here, ahead]) = self.at(wave, now, 0.0, piece) else {
                continue;
            };
            let rate = self.laws.frequencies[wave.frequency];
            add(0, wave.input, here);
            add(1, wave.input, rate * ahead);
            add(2, wave.input, -rate * rate * here);
        }
    }
}
