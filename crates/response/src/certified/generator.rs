//! State and loads together as one system ζ′ = W ζ without input, in energy coordinates.

use std::ops::Range;

use eigentone_digits::{BallMatrix, Magnitude, Real};
use eigentone_modes::EnclosedFirstOrder;

use crate::enclosed::{Energy, Normed, add_multiple, cos_sin, frobenius};
use crate::problem::{Known, Piece, Problem, Pulse, Rate, Source, StraightLoad, moving};

/// ζ holds, in this order: the state in energy coordinates; the integrals of the channels' signals; sine and cosine of each
/// frequency, and of each pulse; the force on each coordinate, or the signal of each channel, with a straight load; its
/// slope where it has one. Loads are in units of powers of two in which what they do in some span of time is about 1.
pub(crate) struct Generator<T> {
    /// W: block upper triangular, the states first.
    pub(crate) w: Normed<T>,
    /// How many entries of ζ are states, with the integrals of signals.
    pub(crate) states: usize,
    /// Where the sines of the pulses begin.
    pulses: usize,
    /// The first entry of the straight loads, beyond the sines and cosines.
    pub(crate) straight: usize,
    /// The entries before those by levels, each moved by itself and by later ones alone: the state of the system, integrals
    /// of signals, those of the highest order first, sines and cosines.
    pub(crate) levels: Vec<Range<usize>>,
    /// What forces displace at once, by coordinates: impulses would without limit.
    yields: BallMatrix<T>,
    channels: Vec<Channel>,
    /// Each entry of ζ beyond the states is 2 to this power times the load; 0 for the states.
    units: Vec<i64>,
    /// ζ from the state: R, in whole.
    enter: BallMatrix<T>,
    /// R B: the change of the states by unit impulses, by coordinate.
    impulse: BallMatrix<T>,
    initial: BallMatrix<T>,
    /// Displacement, velocity and acceleration from ζ.
    pub(crate) outputs: [Output<T>; 3],
    /// Each combination from ζ.
    pub(crate) combinations: Vec<Output<T>>,
    /// Displacement, velocity and acceleration from the state in its own coordinates and the loads in theirs; then
    /// all combinations.
    maps: [BallMatrix<T>; 4],
    /// B.
    push: BallMatrix<T>,
}

/// A coordinate with a straight load, and where its slope stands in ζ.
#[derive(Clone, Copy, Debug)]
struct Channel {
    coordinate: usize,
    slope: Option<usize>,
}

/// A linear map from ζ to the coordinates.
pub(crate) struct Output<T> {
    /// Row by row, one row for each coordinate.
    pub(crate) rows: Vec<Vec<T>>,
    /// What the states, and what the loads do to it.
    pub(crate) parts: [Part; 2],
    /// How far the two parts of each row may be off, in the 2-norm.
    pub(crate) off: Vec<[Magnitude; 2]>,
}

/// A part of all rows of an output.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    /// The largest 2-norm of a row.
    pub(crate) norm: Magnitude,
    /// The largest error of a row, in the 2-norm.
    pub(crate) error: Magnitude,
}

impl<T: Real> Generator<T> {
    /// `None` where the digits do not suffice to divide by the masses, or to change coordinates: those of G, in which W
    /// is computed before it is rounded to T. Where matrices are ill-conditioned, dividing by the masses and changing
    /// coordinates costs digits, and the exponential costs none.
    /// Sources in `more` are combinations beside those of the problem. Loads are in units of what they do in all the time.
    pub(crate) fn of<G: Real>(problem: &Problem<'_>, more: &[Source]) -> Option<Generator<T>> {
        let form = EnclosedFirstOrder::<G>::of(problem.system()).ok()?;
        Generator::of_form(problem, &form, more, f64::INFINITY)
    }

    /// The same for a march by steps of the grid, with loads in units of what they do in a step, so that a step does not lengthen
    /// errors, and those of loads weigh little. It is without the states that nothing moves, where no force acts but those of
    /// the problem: what is at rest may be unstable, and errors would grow in it.
    pub(crate) fn of_moving<G: Real>(problem: &Problem<'_>) -> Option<Generator<T>> {
        let form = EnclosedFirstOrder::<G>::of(problem.system()).ok()?;
        let start = form.initial().times(&motion(problem));
        let starts = (0..form.states()).map(|i| !start.is_zero(i, 0)).collect();
        let moving = moving(
            problem,
            starts,
            |i, j| !form.b().is_zero(i, j),
            |i, j| !form.a().is_zero(i, j),
        );
        let step = problem.grid().step();
        match moving.contains(&false) {
            true => Generator::of_form(problem, &form.within(&moving), &[], step),
            false => Generator::of_form(problem, &form, &[], step),
        }
    }

    fn of_form<G: Real>(
        problem: &Problem<'_>,
        form: &EnclosedFirstOrder<G>,
        more: &[Source],
        span: f64,
    ) -> Option<Generator<T>> {
        let system = problem.system();
        let end = problem.grid().time(problem.grid().last());
        let horizon = if end > 0.0 { end } else { 1.0 };
        let structure = system.structure();
        let supported = structure.is_passive() && structure.zero_roots() == Some(0);
        let energy = Energy::of(form, supported, 1.0 / horizon)?;

        let timeline = problem.timeline();
        let (own, n) = (form.states(), system.len());
        let integrals: usize = problem.channels().iter().map(|one| one.integrals).sum();
        let states = own + integrals;
        let mut frequencies: Vec<f64> = Vec::new();
        for (_, harmonic) in timeline.harmonics() {
            if !frequencies.contains(&harmonic.frequency) {
                frequencies.push(harmonic.frequency);
            }
        }
        let pulses = states + 2 * frequencies.len();
        let straight = pulses + 2 * timeline.pulses().len();
        let mut channels: Vec<Channel> = Vec::new();
        for law in timeline.pieces().iter().flat_map(|piece| piece.changes()) {
            let at = match channels
                .iter()
                .position(|channel| channel.coordinate == law.coordinate)
            {
                Some(at) => at,
                None => {
                    channels.push(Channel {
                        coordinate: law.coordinate,
                        slope: None,
                    });
                    channels.len() - 1
                }
            };
            if law.is_sloped() {
                channels[at].slope = Some(0);
            }
        }
        let mut size = straight + channels.len();
        for channel in channels
            .iter_mut()
            .filter(|channel| channel.slope.is_some())
        {
            channel.slope = Some(size);
            size += 1;
        }

        // What is known of the signals: of coordinates, then of channels.
        let count = problem.channels().len();
        let mut signals = BallMatrix::<G>::zeros(n + count, size);
        for (signal, harmonic) in timeline.harmonics() {
            let place = frequencies.iter().position(|f| *f == harmonic.frequency);
            let column = states + 2 * place.expect("collected above");
            let (c, s, error) = cos_sin::<G>(harmonic.phase);
            let amplitude = G::from(harmonic.amplitude);
            for (column, part) in [(column, c), (column + 1, s)] {
                let value = amplitude * part;
                let error = amplitude.upper() * error + value.upper() * G::unit() + G::floor();
                let error = if part.is_zero() && error.is_zero() {
                    Magnitude::ZERO
                } else {
                    error
                };
                signals.add(*signal, column, value, error);
            }
        }
        for (column, pulse) in (pulses..).step_by(2).zip(timeline.pulses()) {
            let parts = [(column, pulse.sine), (column + 1, pulse.cosine)];
            for (column, value) in parts.into_iter().filter(|(_, value)| *value != 0.0) {
                signals.add(pulse.coordinate, column, G::from(value), Magnitude::ZERO);
            }
        }
        for (at, channel) in channels.iter().enumerate() {
            signals.set(channel.coordinate, straight + at, G::ONE, Magnitude::ZERO);
        }
        // How the loads go on by themselves.
        let mut motion = BallMatrix::<G>::zeros(size, size);
        let rates = frequencies.iter().map(|frequency| Rate::Given(*frequency));
        let rates = rates.chain(timeline.pulses().iter().map(|pulse| pulse.rate));
        for (column, rate) in (states..).step_by(2).zip(rates) {
            let (rate, error) = rate.value::<G>();
            motion.set(column, column + 1, rate, error);
            motion.set(column + 1, column, -rate, error);
        }
        for (at, channel) in channels.iter().enumerate() {
            if let Some(slope) = channel.slope {
                motion.set(straight + at, slope, G::ONE, Magnitude::ZERO);
            }
        }
        // The first that a channel takes in, then those that these are integrals of.
        let mut levels: Vec<Range<usize>> = std::iter::once(0..own).collect();
        let mut chains = vec![Vec::new(); count];
        for order in 0.. {
            let start = levels.last().map_or(own, |level| level.end);
            let mut place = start;
            for (chain, channel) in chains.iter_mut().zip(problem.channels()) {
                if order < channel.integrals {
                    chain.push(place);
                    place += 1;
                }
            }
            if place == start {
                break;
            }
            levels.push(start..place);
        }
        levels.push(states..straight);
        levels.retain(|level| !level.is_empty());
        for (at, chain) in chains.iter().enumerate() {
            for pair in chain.windows(2) {
                motion.set(pair[0], pair[1], G::ONE, Magnitude::ZERO);
            }
            if let Some(last) = chain.last() {
                motion.put(*last, 0, &signals.block(n + at, 0, 1, size));
            }
        }
        // The system in its own coordinates: z′ = A z + B f, x = X z + D f, f = F (loads).
        let mut forces = BallMatrix::<G>::zeros(n, size);
        forces.put(0, 0, &signals.block(0, 0, n, size));
        let mut supports = BallMatrix::<G>::zeros(system.supports().len(), size);
        for ((at, channel), chain) in problem.channels().iter().enumerate().zip(chains) {
            let mut course = signals.block(n + at, 0, 1, size);
            if let Some(first) = chain.first() {
                course = BallMatrix::zeros(1, size);
                course.set(0, *first, G::ONE, Magnitude::ZERO);
            }
            if let Some(support) = channel.support {
                add_multiple(&mut supports, support, 1.0, &course);
            }
            for direction in &channel.directions {
                for &(row, factor) in direction {
                    add_multiple(&mut forces, row, factor, &course);
                }
                course = course.times(&motion);
            }
        }
        let mut whole = form.b().times(&forces);
        whole.put(0, 0, form.a());
        let mut moved = form.d().times(&forces);
        moved.put(0, 0, form.x());
        let mut position = BallMatrix::zeros(n + supports.rows(), size);
        position.put(0, 0, &moved);
        position.put(n, 0, &supports);
        motion.put(0, 0, &whole);
        let own_motion = motion;

        // W but for the units of the loads.
        let turned = energy.r.times(&whole);
        let states_alone = turned.block(0, 0, own, own).times(&energy.y);
        let mut w = own_motion.clone();
        w.put(0, 0, &turned);
        w.put(0, 0, &states_alone);
        // R⁻¹ = Y (RY)⁻¹ and ‖(RY)⁻¹ − I‖ ≤ δ/(1 − δ) ≤ 2δ.
        let inexact = energy.defect + energy.defect;
        let inside = inexact * frobenius(&states_alone);

        // Units of the loads.
        let span = Magnitude::from(span.min(horizon));
        /// Far below all units.
        const NOTHING: i64 = i64::MIN / 2;
        // By what is known not to be rounding of 0.
        let known = |matrix: &BallMatrix<G>, i: usize, j: usize| {
            let size = matrix.middle(i, j).upper();
            match matrix.radius(i, j) < size {
                true => size,
                false => Magnitude::ZERO,
            }
        };
        let strength = |column: usize| {
            let squares = (0..own).map(|i| {
                let size = known(&w, i, column);
                size * size
            });
            let norm = squares.fold(Magnitude::ZERO, |a, b| a + b).sqrt();
            match norm.is_zero() {
                true => NOTHING,
                false => (norm * span).exponent(),
            }
        };
        let epoch = span.exponent();
        let mut units = vec![0i64; size];
        // What a unit of a load adds to the integrals of its own channel.
        let feeds = |units: &[i64], column: usize| {
            let rows = (own..states).filter(|row| !own_motion.is_zero(*row, column));
            let fed = rows.map(|row| {
                let factor = known(&own_motion, row, column);
                units[row] + (factor * span).exponent()
            });
            fed.max().unwrap_or(NOTHING)
        };
        for column in own..states {
            units[column] = strength(column).max(feeds(&units, column));
        }
        for sine in (states..straight).step_by(2) {
            let unit = [sine, sine + 1].map(|part| strength(part).max(feeds(&units, part)));
            units[sine..sine + 2].fill(unit[0].max(unit[1]));
        }
        for (at, channel) in (straight..).zip(&channels) {
            units[at] = strength(at).max(feeds(&units, at));
            if let Some(slope) = channel.slope {
                units[slope] = strength(slope)
                    .max(feeds(&units, slope))
                    .max(units[at] + epoch);
            }
        }
        // What moves nothing has any.
        let idle = units.iter_mut().filter(|unit| **unit < NOTHING / 2);
        idle.for_each(|unit| *unit = 0);
        let velocity = position.times(&own_motion);
        let acceleration = velocity.times(&own_motion);
        let sources = || problem.sources().iter().chain(more);
        let mut combined = BallMatrix::<G>::zeros(sources().count(), size);
        for (row, source) in sources().enumerate() {
            for (terms, map) in source
                .terms
                .iter()
                .zip([&position, &velocity, &acceleration])
            {
                for (i, [a, b]) in terms {
                    let mut part = BallMatrix::zeros(1, size);
                    add_multiple(&mut part, 0, *a, &map.block(*i, 0, 1, size));
                    add_multiple(&mut combined, row, *b, &part);
                }
            }
        }

        let mut leave = BallMatrix::zeros(size, size);
        leave.put(0, 0, &energy.y);
        for (i, unit) in units.iter().enumerate().skip(own) {
            leave.set(i, i, G::ONE.scale(-*unit), Magnitude::ZERO);
        }
        for i in 0..size {
            for j in own..size {
                let power = units[i] - units[j];
                let radius = w.radius(i, j) * Magnitude::power_of_two(power);
                w.set(i, j, w.middle(i, j).scale(power), radius);
            }
        }
        let w = Normed::of(&w.rounded(), states).with_more_error(inside);
        let output =
            |map: &BallMatrix<G>| Output::of(&map.times(&leave).rounded(), states, inexact);
        let of_coordinates = |map: &BallMatrix<G>| map.block(0, 0, n, size);
        let motions = [position, velocity, acceleration].map(|map| of_coordinates(&map));
        Some(Generator {
            w,
            states,
            pulses,
            straight,
            levels,
            yields: form.d().rounded(),
            channels,
            units,
            impulse: energy.r.times(form.b()).rounded(),
            enter: energy.r.rounded(),
            initial: form.initial().rounded(),
            outputs: [0, 1, 2].map(|kind| output(&motions[kind])),
            combinations: (0..combined.rows())
                .map(|row| output(&combined.block(row, 0, 1, size)))
                .collect(),
            maps: {
                let [x, v, a] = motions;
                [x, v, a, combined].map(|map| map.rounded())
            },
            push: form.b().rounded(),
        })
    }

    /// ζ at t = 0 without straight loads, and its error.
    pub(crate) fn start(&self, problem: &Problem<'_>) -> (Vec<T>, Magnitude) {
        self.start_from(&motion(problem))
    }

    /// The same from other displacements and then velocities.
    pub(crate) fn start_from(&self, motion: &BallMatrix<T>) -> (Vec<T>, Magnitude) {
        let state = self.enter.times(&self.initial.times(motion));
        let mut zeta: Vec<T> = (0..state.rows()).map(|i| state.middle(i, 0)).collect();
        zeta.resize(self.w.len(), T::ZERO);
        for cosine in (self.states + 1..self.pulses).step_by(2) {
            zeta[cosine] = T::ONE.scale(self.units[cosine]);
        }
        (zeta, state.spread())
    }

    /// No free motion is faster, in 1/s; about.
    pub(crate) fn fastest(&self) -> Magnitude {
        let rows = (0..self.states).flat_map(|i| &self.w.row(i)[..self.states]);
        let squares = rows.map(|entry| entry.upper() * entry.upper());
        squares
            .fold(Magnitude::ZERO, |sum, square| sum + square)
            .sqrt()
    }

    /// The state at t = 0 in its own coordinates, before any impulse.
    pub(crate) fn given(&self, problem: &Problem<'_>) -> BallMatrix<T> {
        self.initial.times(&motion(problem))
    }

    /// The state of rest in its own coordinates.
    pub(crate) fn rest(&self) -> BallMatrix<T> {
        BallMatrix::zeros(self.initial.rows(), 1)
    }

    /// A state in its own coordinates, after momenta.
    pub(crate) fn after_momenta(
        &self,
        state: &BallMatrix<T>,
        momenta: &[(usize, Known<T>)],
    ) -> BallMatrix<T> {
        let mut sum = BallMatrix::zeros(self.push.columns(), 1);
        for &(coordinate, (momentum, error)) in momenta {
            sum.add(coordinate, 0, momentum, error);
        }
        state.plus(&self.push.times(&sum))
    }

    /// Sets what pulses begin and end with a piece.
    pub(crate) fn set_pulses(&self, zeta: &mut [T], pulses: &[Pulse], piece: &Piece) {
        for (sine, pulse) in (self.pulses..).step_by(2).zip(pulses) {
            let [begins, ends] = pulse.bounds(piece);
            if begins || ends {
                zeta[sine] = T::ZERO;
                zeta[sine + 1] = match begins {
                    true => T::ONE.scale(self.units[sine]),
                    false => T::ZERO,
                };
            }
        }
    }

    /// Displacements, velocities, accelerations and combinations of a state in its own coordinates under the loads
    /// in ζ, each with its error: without any change of coordinates, so that what is given comes out
    /// as it is.
    pub(crate) fn outset(
        &self,
        state: &BallMatrix<T>,
        zeta: &[T],
        straight_error: Magnitude,
    ) -> [BallMatrix<T>; 4] {
        let mut whole = BallMatrix::zeros(zeta.len(), 1);
        whole.put(0, 0, state);
        for (i, unit) in self.units.iter().enumerate().skip(self.states) {
            // Sines and cosines are 0 and 1: only at the start, as with them nothing is at rest later.
            let error = if i < self.straight {
                Magnitude::ZERO
            } else {
                straight_error * Magnitude::power_of_two(-*unit)
            };
            whole.set(i, 0, zeta[i].scale(-*unit), error);
        }
        [0, 1, 2, 3].map(|kind| self.maps[kind].times(&whole))
    }

    /// Adds a momentum to ζ; its error.
    pub(crate) fn add_momentum(
        &self,
        zeta: &mut [T],
        coordinate: usize,
        (momentum, off): Known<T>,
    ) -> Magnitude {
        let mut error = Magnitude::ZERO;
        for (i, entry) in zeta.iter_mut().enumerate().take(self.impulse.rows()) {
            if self.impulse.is_zero(i, coordinate) {
                continue;
            }
            let factor = self.impulse.middle(i, coordinate);
            let change = factor * momentum;
            *entry = *entry + change;
            let rounding = (change.upper() + entry.upper()) * T::unit() + T::floor();
            let radius = self.impulse.radius(i, coordinate);
            error = error + rounding + (momentum.upper() + off) * radius + factor.upper() * off;
        }
        error
    }

    /// The first of these coordinates by whose momenta, in N·s, something would be displaced without limit: those together that no
    /// damper resists.
    pub(crate) fn gives_way(&self, momenta: &[(usize, f64)]) -> Option<usize> {
        let mut column = BallMatrix::zeros(self.yields.columns(), 1);
        for &(coordinate, momentum) in momenta {
            // Each is a rounded product.
            let rounding = Magnitude::from(momentum) * Magnitude::from(f64::EPSILON);
            column.add(coordinate, 0, T::from(momentum), rounding);
        }
        let moved = self.yields.times(&column);
        let moves = |i: &usize| moved.radius(*i, 0) < moved.middle(*i, 0).upper();
        let row = (0..moved.rows()).find(moves)?;
        let mut coordinates = momenta.iter().map(|(coordinate, _)| *coordinate);
        coordinates.find(|coordinate| !self.yields.is_zero(row, *coordinate))
    }

    /// Sets the straight loads in ζ, each with its coordinate; the error that they have there.
    pub(crate) fn set_straight(
        &self,
        zeta: &mut [T],
        loads: impl Iterator<Item = (usize, StraightLoad<T>)>,
    ) -> Magnitude {
        for entry in &mut zeta[self.straight..] {
            *entry = T::ZERO;
        }
        let mut total = Magnitude::ZERO;
        for (coordinate, straight) in loads {
            let at = self
                .channels
                .iter()
                .position(|channel| channel.coordinate == coordinate)
                .expect("collected from the same pieces");
            let mut set = |place: usize, (value, error): Known<T>| {
                let unit = self.units[place];
                total = total + error * Magnitude::power_of_two(unit);
                if !value.is_zero() {
                    total = total + T::floor();
                }
                zeta[place] = value.scale(unit);
            };
            set(self.straight + at, straight.value);
            if let Some(slope) = self.channels[at].slope {
                set(slope, straight.slope);
            }
        }
        total
    }
}

/// Displacements and then velocities at t = 0.
fn motion<T: Real>(problem: &Problem<'_>) -> BallMatrix<T> {
    let given = problem.initial_displacement().iter();
    let given = given.chain(problem.initial_velocity());
    let mut motion = BallMatrix::zeros(2 * problem.system().len(), 1);
    for (i, value) in given.enumerate() {
        motion.set(i, 0, T::from(*value), Magnitude::ZERO);
    }
    motion
}

impl<T: Real> Output<T> {
    fn of(map: &BallMatrix<T>, states: usize, inexact: Magnitude) -> Output<T> {
        let columns = map.columns();
        let largest = |a: Magnitude, b: Magnitude| if a < b { b } else { a };
        let kinds = [(0..states, inexact), (states..columns, Magnitude::ZERO)];
        // Norm and error of each part of a row.
        let sizes = |i: usize| {
            kinds.clone().map(|(range, inexact)| {
                let length = |entry: &dyn Fn(usize) -> Magnitude| {
                    let filled = range.clone().filter(|j| !map.is_zero(i, *j));
                    let squares = filled.map(|j| entry(j) * entry(j));
                    squares.fold(Magnitude::ZERO, |a, b| a + b).sqrt()
                };
                let norm = length(&|j| map.middle(i, j).upper() + map.radius(i, j));
                [norm, length(&|j| map.radius(i, j)) + inexact * norm]
            })
        };
        let sizes: Vec<[[Magnitude; 2]; 2]> = (0..map.rows()).map(sizes).collect();
        let part = |kind: usize| {
            let top = |of: usize| {
                let all = sizes.iter().map(|row| row[kind][of]);
                all.fold(Magnitude::ZERO, largest)
            };
            Part {
                norm: top(0),
                error: top(1),
            }
        };
        Output {
            rows: (0..map.rows())
                .map(|i| (0..columns).map(|j| map.middle(i, j)).collect())
                .collect(),
            parts: [part(0), part(1)],
            off: sizes.iter().map(|row| row.map(|[_, off]| off)).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Impulse, Response, State};
    use eigentone_digits::{DoubleDouble, Wide};
    use eigentone_modes::{GROUND, System};

    type Exact = Wide<16>;

    fn length(off: impl Iterator<Item = Exact>) -> f64 {
        let squares = off.map(|off| off.to_f64() * off.to_f64());
        squares.sum::<f64>().sqrt()
    }

    /// R z₀, and what an impulse adds to it, of 106 bits against 1024: rounded, and within the error stated.
    #[test]
    fn rounding_of_the_start_and_of_impulses_is_counted() {
        let system = System::builder()
            .mass("a", 0.3)
            .mass("b", 0.7)
            .spring(GROUND, "a", 1.1)
            .spring("a", "b", 1.3)
            .damper("a", "b", 0.1)
            .build()
            .expect("a system");
        let start = State::at_rest().displace("a", 0.1).displace("b", 0.7);
        let start = start.push("a", 0.3).push("b", -0.9);
        let asked = Response::of(&system)
            .from(start)
            .load("b", Impulse::of(0.3));
        let problem = asked.every(0.1).until(1.0).problem().expect("well posed");
        let generator =
            Generator::<DoubleDouble>::of::<DoubleDouble>(&problem, &[]).expect("a generator");
        let given = [0.1, 0.7, 0.3, -0.9].map(Exact::from);
        let n = generator.states;

        let (mut zeta, error) = generator.start(&problem);
        let exact = |i: usize| {
            let entries = (0..n).map(|j| Exact::from(generator.enter.middle(i, j)) * given[j]);
            entries.fold(Exact::from(0.0), |sum, entry| sum + entry)
        };
        let off = length((0..n).map(|i| exact(i) - Exact::from(zeta[i])));
        assert!(off > 0.0, "nothing was rounded");
        assert!(off <= error.to_f64(), "{off:e} {:e}", error.to_f64());

        let before = zeta.clone();
        let error =
            generator.add_momentum(&mut zeta, 1, (DoubleDouble::from(0.3), Magnitude::ZERO));
        let change = |i: usize| Exact::from(generator.impulse.middle(i, 1)) * Exact::from(0.3);
        let exact = |i: usize| Exact::from(before[i]) + change(i);
        let off = length((0..n).map(|i| exact(i) - Exact::from(zeta[i])));
        let radii =
            length((0..n).map(|i| Exact::from(0.3 * generator.impulse.radius(i, 1).to_f64())));
        assert!(off > 0.0, "nothing was rounded");
        // Beside what is not known of the impulse.
        assert!(
            off + radii <= error.to_f64(),
            "{off:e} {radii:e} {:e}",
            error.to_f64()
        );
    }
}
