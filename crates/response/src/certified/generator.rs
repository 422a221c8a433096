//! State and loads together as one system ζ′ = W ζ without input, in energy coordinates.

use eigentone_digits::{BallMatrix, Magnitude, Real};
use eigentone_modes::EnclosedFirstOrder;

use crate::enclosed::{Energy, Normed, cos_sin, frobenius};
use crate::problem::{Known, Problem, StraightLoad};

/// ζ holds, in this order: the state in energy coordinates; sine and cosine of each frequency; the
/// force on each coordinate with a straight load; its slope where it has one. Loads are in units of
/// powers of two in which their work over the whole time is about that of 1.
pub(crate) struct Generator<T> {
    /// W: block upper triangular, the states first.
    pub(crate) w: Normed<T>,
    /// How many entries of ζ are states.
    pub(crate) states: usize,
    /// The first entry of the straight loads, beyond the sines and cosines.
    pub(crate) straight: usize,
    /// By coordinate: whether a force on it displaces something at once, so that a blow would without limit.
    pub(crate) gives_way: Vec<bool>,
    channels: Vec<Channel>,
    /// Each entry of ζ beyond the states is 2 to this power times the load; 0 for the states.
    units: Vec<i64>,
    /// ζ from the state: R, in whole.
    enter: BallMatrix<T>,
    /// R B: the change of the states by unit impulses, by coordinate.
    blow: BallMatrix<T>,
    initial: BallMatrix<T>,
    /// Displacement, velocity and acceleration from ζ.
    pub(crate) outputs: [Output<T>; 3],
    /// The same from the state in its own coordinates and the loads in theirs.
    maps: [BallMatrix<T>; 3],
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
    pub(crate) fn of<G: Real>(problem: &Problem<'_>) -> Option<Generator<T>> {
        let system = problem.system();
        let form = EnclosedFirstOrder::<G>::of(system).ok()?;
        let end = problem.grid().time(problem.grid().last());
        let horizon = if end > 0.0 { end } else { 1.0 };
        let structure = system.structure();
        let supported = structure.is_passive() && structure.zero_roots() == Some(0);
        let energy = Energy::of(&form, supported, 1.0 / horizon)?;

        let timeline = problem.timeline();
        let n = form.states();
        let mut frequencies: Vec<f64> = Vec::new();
        for (_, harmonic) in timeline.harmonics() {
            if !frequencies.contains(&harmonic.frequency) {
                frequencies.push(harmonic.frequency);
            }
        }
        let straight = n + 2 * frequencies.len();
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

        // The system in its own coordinates: z′ = A z + B f, x = X z + D f, f = F (loads).
        let mut forces = BallMatrix::<G>::zeros(system.len(), size);
        for (coordinate, harmonic) in timeline.harmonics() {
            let place = frequencies.iter().position(|f| *f == harmonic.frequency);
            let column = n + 2 * place.expect("collected above");
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
                forces.add(*coordinate, column, value, error);
            }
        }
        for (at, channel) in channels.iter().enumerate() {
            forces.set(channel.coordinate, straight + at, G::ONE, Magnitude::ZERO);
        }
        let displaces = |j: usize| {
            let d = form.d();
            (0..system.len()).any(|i| d.radius(i, j) < d.middle(i, j).upper())
        };
        let gives_way = (0..system.len()).map(displaces).collect();
        let mut whole = form.b().times(&forces);
        whole.put(0, 0, form.a());
        let mut position = form.d().times(&forces);
        position.put(0, 0, form.x());

        // Units of the loads.
        let pushed = energy.r.times(&whole.block(0, n, n, size - n));
        let strength = |column: usize| {
            let squares = (0..n).map(|i| {
                let size = pushed.middle(i, column - n).upper();
                size * size
            });
            let norm = squares.fold(Magnitude::ZERO, |a, b| a + b).sqrt();
            (norm * Magnitude::from(horizon)).exponent()
        };
        let epoch = Magnitude::from(horizon).exponent();
        let mut units = vec![0i64; size];
        for sine in (n..straight).step_by(2) {
            let unit = strength(sine).max(strength(sine + 1));
            units[sine..sine + 2].fill(unit);
        }
        for (at, channel) in (straight..).zip(&channels) {
            units[at] = strength(at);
            if let Some(slope) = channel.slope {
                units[slope] = units[at] + epoch;
            }
        }

        // How the loads themselves go on.
        let mut own = BallMatrix::<G>::zeros(size, size);
        own.put(0, 0, &whole);
        for (at, frequency) in frequencies.iter().enumerate() {
            let column = n + 2 * at;
            own.set(column, column + 1, G::from(*frequency), Magnitude::ZERO);
            own.set(column + 1, column, G::from(-*frequency), Magnitude::ZERO);
        }
        for (at, channel) in channels.iter().enumerate() {
            if let Some(slope) = channel.slope {
                own.set(straight + at, slope, G::ONE, Magnitude::ZERO);
            }
        }
        let velocity = position.times(&own);
        let acceleration = velocity.times(&own);

        let (mut enter, mut leave) = (BallMatrix::zeros(size, size), BallMatrix::zeros(size, size));
        enter.put(0, 0, &energy.r);
        leave.put(0, 0, &energy.y);
        for (i, unit) in units.iter().enumerate().skip(n) {
            enter.set(i, i, G::ONE.scale(*unit), Magnitude::ZERO);
            leave.set(i, i, G::ONE.scale(-*unit), Magnitude::ZERO);
        }
        // R⁻¹ = Y (RY)⁻¹ and ‖(RY)⁻¹ − I‖ ≤ δ/(1 − δ) ≤ 2δ.
        let inexact = energy.defect + energy.defect;
        let w = enter.times(&own).times(&leave);
        let inside = inexact * frobenius(&w.block(0, 0, n, n));
        let w = Normed::of(&w.rounded(), n).with_more_error(inside);
        let output = |map: &BallMatrix<G>| Output::of(&map.times(&leave).rounded(), n, inexact);
        Some(Generator {
            w,
            states: n,
            straight,
            gives_way,
            channels,
            units,
            blow: energy.r.times(form.b()).rounded(),
            enter: energy.r.rounded(),
            initial: form.initial().rounded(),
            outputs: [output(&position), output(&velocity), output(&acceleration)],
            maps: [position, velocity, acceleration].map(|map| map.rounded()),
            push: form.b().rounded(),
        })
    }

    /// ζ at t = 0 without straight loads, and its error.
    pub(crate) fn start(&self, problem: &Problem<'_>) -> (Vec<T>, Magnitude) {
        let state = self.enter.times(&self.given(problem));
        let mut zeta: Vec<T> = (0..self.states).map(|i| state.middle(i, 0)).collect();
        zeta.resize(self.w.len(), T::ZERO);
        for cosine in (self.states + 1..self.straight).step_by(2) {
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

    /// The state at t = 0 in its own coordinates, before any blow.
    pub(crate) fn given(&self, problem: &Problem<'_>) -> BallMatrix<T> {
        let given = problem.initial_displacement().iter();
        let given = given.chain(problem.initial_velocity());
        let mut motion = BallMatrix::zeros(2 * problem.system().len(), 1);
        for (i, value) in given.enumerate() {
            motion.set(i, 0, T::from(*value), Magnitude::ZERO);
        }
        self.initial.times(&motion)
    }

    /// A state in its own coordinates, after blows.
    pub(crate) fn struck(&self, state: &BallMatrix<T>, blows: &[(usize, f64)]) -> BallMatrix<T> {
        let mut sum = BallMatrix::zeros(self.push.columns(), 1);
        for &(coordinate, magnitude) in blows {
            sum.add(coordinate, 0, T::from(magnitude), Magnitude::ZERO);
        }
        state.plus(&self.push.times(&sum))
    }

    /// Displacements, velocities and accelerations of a state in its own coordinates under the loads
    /// in ζ, each with its error: without any change of coordinates, so that what is given comes out
    /// as it is.
    pub(crate) fn outset(
        &self,
        state: &BallMatrix<T>,
        zeta: &[T],
        straight_error: Magnitude,
    ) -> [BallMatrix<T>; 3] {
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
        [0, 1, 2].map(|kind| self.maps[kind].times(&whole))
    }

    /// Adds a blow to ζ; its error.
    pub(crate) fn strike(&self, zeta: &mut [T], coordinate: usize, magnitude: f64) -> Magnitude {
        let factor = T::from(magnitude);
        let mut error = Magnitude::ZERO;
        for (i, entry) in zeta.iter_mut().enumerate().take(self.states) {
            if self.blow.is_zero(i, coordinate) {
                continue;
            }
            let change = self.blow.middle(i, coordinate) * factor;
            *entry = *entry + change;
            let rounding = (change.upper() + entry.upper()) * T::unit() + T::floor();
            error = error + rounding + factor.upper() * self.blow.radius(i, coordinate);
        }
        error
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

impl<T: Real> Output<T> {
    fn of(map: &BallMatrix<T>, states: usize, inexact: Magnitude) -> Output<T> {
        let columns = map.columns();
        let largest = |a: Magnitude, b: Magnitude| if a < b { b } else { a };
        let part = |from: usize, to: usize, inexact: Magnitude| {
            let row = |i: usize, entry: &dyn Fn(usize, usize) -> Magnitude| {
                let squares = (from..to).map(|j| entry(i, j) * entry(i, j));
                squares.fold(Magnitude::ZERO, |a, b| a + b).sqrt()
            };
            let rows = |norm: &dyn Fn(usize) -> Magnitude| {
                (0..map.rows()).map(norm).fold(Magnitude::ZERO, largest)
            };
            let norm = |i| row(i, &|i, j| map.middle(i, j).upper() + map.radius(i, j));
            Part {
                norm: rows(&norm),
                error: rows(&|i| row(i, &|i, j| map.radius(i, j)) + inexact * norm(i)),
            }
        };
        Output {
            rows: (0..map.rows())
                .map(|i| (0..columns).map(|j| map.middle(i, j)).collect())
                .collect(),
            parts: [
                part(0, states, inexact),
                part(states, columns, Magnitude::ZERO),
            ],
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

    /// R z₀, and what a blow adds to it, of 106 bits against 1024: rounded, and within the error stated.
    #[test]
    fn rounding_of_the_start_and_of_blows_is_counted() {
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
            Generator::<DoubleDouble>::of::<DoubleDouble>(&problem).expect("a generator");
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
        let error = generator.strike(&mut zeta, 1, 0.3);
        let change = |i: usize| Exact::from(generator.blow.middle(i, 1)) * Exact::from(0.3);
        let exact = |i: usize| Exact::from(before[i]) + change(i);
        let off = length((0..n).map(|i| exact(i) - Exact::from(zeta[i])));
        let radii = length((0..n).map(|i| Exact::from(0.3 * generator.blow.radius(i, 1).to_f64())));
        assert!(off > 0.0, "nothing was rounded");
        // Beside what is not known of the blow.
        assert!(
            off + radii <= error.to_f64(),
            "{off:e} {radii:e} {:e}",
            error.to_f64()
        );
    }
}
