//! The system and the laws of its loads as one autonomous equation ζ′ = A ζ, of which powers are
//! quadratic forms.

use eigentone_digits::{DoubleDouble, Real};
use eigentone_modes::{FirstOrder, MatrixKind, Node, System, balance};
use faer::MatRef;

use crate::hold::reduced_angle;
use crate::problem::{Instant, Piece, Problem};

use super::gramian::{Square, dot};
use super::state_matrix::{lumped, state_matrix};

/// ζ = (z, then for each loaded coordinate the straight part of its force and the slope of that, then
/// for each frequency the sinusoidal part and the one a quarter period ahead), each in units of a
/// power of two.
pub(super) struct DrivenForm<T> {
    a: Square<T>,
    /// The coordinates that any load but an impulse acts on, rising.
    loaded: Vec<usize>,
    frequencies: Vec<f64>,
    coordinates: usize,
    states: usize,
    /// n × N: x = X z, v = V z, without what the loads add at once.
    x: Vec<T>,
    /// n × the whole state: velocities, with what the loads add.
    v: Vec<T>,
    /// n × n: x += D f; empty where it vanishes.
    feed: Vec<T>,
    /// N × n: what unit impulses add to z.
    b: Vec<T>,
    /// ζ_i counts in units of 2 to this power.
    units: Vec<i64>,
}

impl<T: Real> DrivenForm<T> {
    pub(super) fn of(problem: &Problem<'_>, form: &FirstOrder) -> DrivenForm<T> {
        let (system, timeline) = (problem.system(), problem.timeline());
        let straight = timeline.pieces().iter().flat_map(Piece::straight);
        let mut loaded: Vec<usize> = straight.map(|straight| straight.coordinate).collect();
        let mut frequencies = Vec::new();
        for (coordinate, harmonic) in timeline.harmonics() {
            loaded.push(*coordinate);
            frequencies.push(harmonic.frequency);
        }
        loaded.sort_unstable();
        loaded.dedup();
        frequencies.sort_unstable_by(f64::total_cmp);
        frequencies.dedup();
        let (n, states, r) = (system.len(), form.states(), loaded.len());
        let (own, b) = match lumped(system) {
            Some(masses) => state_matrix(system, masses),
            None => (converted(form.a()), converted(form.b())),
        };
        let x = converted(form.x());
        let feed = form.d().map_or_else(Vec::new, converted);

        let size = states + 2 * r * (1 + frequencies.len());
        let mut a = Square::zeros(size);
        for i in 0..states {
            a.entries[i * size..][..states].copy_from_slice(&own[i * states..][..states]);
        }
        let force_columns: Vec<usize> = (0..=frequencies.len())
            .map(|law| states + 2 * r * law)
            .collect();
        for &column in &force_columns {
            for i in 0..states {
                for (j, coordinate) in loaded.iter().enumerate() {
                    a.entries[i * size + column + j] = b[i * n + coordinate];
                }
            }
        }
        for j in 0..r {
            // The straight part grows by its slope.
            let (force, slope) = (states + j, states + r + j);
            a.entries[force * size + slope] = T::ONE;
            for (law, frequency) in frequencies.iter().enumerate() {
                let sine = force_columns[law + 1] + j;
                a.entries[sine * size + sine + r] = T::from(*frequency);
                a.entries[(sine + r) * size + sine] = T::from(-*frequency);
            }
        }
        // v = X z′ + D f′, where both are rows of A.
        let mut v = vec![T::ZERO; n * size];
        for i in 0..n {
            for (k, factor) in x[i * states..][..states].iter().enumerate() {
                add_row(
                    &mut v[i * size..][..size],
                    *factor,
                    &a.entries[k * size..][..size],
                );
            }
            for (j, coordinate) in loaded.iter().enumerate().filter(|_| !feed.is_empty()) {
                for &column in &force_columns {
                    let rate = &a.entries[(column + j) * size..][..size];
                    add_row(&mut v[i * size..][..size], feed[i * n + coordinate], rate);
                }
            }
        }
        let mut driven = DrivenForm {
            units: vec![0; size],
            a,
            loaded,
            frequencies,
            coordinates: n,
            states,
            x,
            v,
            feed,
            b,
        };
        driven.choose_units(form.a());
        driven
    }

    /// Units in which rows and columns of A are alike in size, and the forces move the states about
    /// as fast as these move each other.
    fn choose_units(&mut self, own: MatRef<'_, f64>) {
        let (size, states) = (self.a.n, self.states);
        let balanced = balance(own);
        for (unit, scale) in self.units.iter_mut().zip(&balanced.scale) {
            *unit = scale.log2() as i64;
        }
        let rate = balanced.matrix.norm_max();
        let rate = if rate > 0.0 {
            rate.log2().ceil() as i64
        } else {
            0
        };
        let r = self.loaded.len();
        for column in states..size {
            let force = states + (column - states) % r;
            let moved = (0..states).map(|i| {
                let entry = self.a.entries[i * size + force].magnitude();
                (!entry.is_zero()).then(|| entry.exponent() - self.units[i])
            });
            self.units[column] = rate - moved.flatten().max().unwrap_or(rate);
        }
        for i in 0..size {
            for j in 0..size {
                let entry = &mut self.a.entries[i * size + j];
                *entry = entry.scale(self.units[j] - self.units[i]);
            }
        }
        for row in self.v.chunks_mut(size.max(1)) {
            for (entry, unit) in row.iter_mut().zip(&self.units) {
                *entry = entry.scale(*unit);
            }
        }
    }

    /// A·h, for steps of h seconds as the unit of time.
    pub(super) fn over(&self, h: DoubleDouble) -> Square<T> {
        let h = T::from(h.high()) + T::from(h.low());
        let mut a = self.a.clone();
        a.entries.iter_mut().for_each(|entry| *entry = *entry * h);
        a
    }

    /// The form of vᵀCv.
    pub(super) fn dissipation(&self, system: &System) -> Square<T> {
        let (n, size) = (system.len(), self.a.n);
        let mut form = Square::zeros(size);
        let rows: Vec<&[T]> = (0..n).map(|i| &self.v[i * size..][..size]).collect();
        for damper in system.dampers() {
            let mut speed = vec![T::ZERO; size];
            if let Node::Coordinate(i) = damper.second {
                add_row(&mut speed, T::ONE, rows[i]);
            }
            if let Node::Coordinate(i) = damper.first {
                add_row(&mut speed, -T::ONE, rows[i]);
            }
            add_product(&mut form, T::from(damper.coefficient), &speed, &speed);
        }
        if let Some(damping) = system.added(MatrixKind::Damping) {
            for i in 0..n {
                for j in 0..n {
                    add_product(&mut form, T::from(damping[(i, j)]), rows[i], rows[j]);
                }
            }
        }
        form
    }

    /// The form of fᵀv.
    pub(super) fn power(&self) -> Square<T> {
        let size = self.a.n;
        let mut form = Square::zeros(size);
        for (j, coordinate) in self.loaded.iter().enumerate() {
            let mut force = vec![T::ZERO; size];
            for law in 0..=self.frequencies.len() {
                let at = self.states + 2 * self.loaded.len() * law + j;
                force[at] = T::ONE.scale(self.units[at]);
            }
            let speed = &self.v[coordinate * size..][..size];
            add_product(&mut form, T::ONE, &force, speed);
        }
        form
    }

    /// ζ for the state z while `piece` lasts.
    pub(super) fn state(
        &self,
        z: &[f64],
        problem: &Problem<'_>,
        now: &Instant,
        piece: &Piece,
    ) -> Vec<T> {
        let mut state: Vec<T> = z.iter().map(|entry| T::from(*entry)).collect();
        state.resize(self.a.n, T::ZERO);
        for (entry, unit) in state.iter_mut().zip(&self.units) {
            *entry = entry.scale(-unit);
        }
        self.load(&mut state, problem, now, piece);
        state
    }

    /// Sets what the loads are at `now`, by the laws of `piece`.
    pub(super) fn load(
        &self,
        state: &mut [T],
        problem: &Problem<'_>,
        now: &Instant,
        piece: &Piece,
    ) {
        let r = self.loaded.len();
        let place = |coordinate: &usize| {
            let place = self.loaded.binary_search(coordinate);
            self.states + place.expect("all loaded coordinates were collected")
        };
        let mut loads = vec![0.0; state.len()];
        let elapsed = (now.time() - piece.start_instant().time()).to_f64();
        for straight in piece.straight() {
            let at = place(&straight.coordinate);
            loads[at] += straight.value + straight.slope * elapsed;
            loads[at + r] += straight.slope;
        }
        for (coordinate, harmonic) in problem.timeline().harmonics() {
            let law = self
                .frequencies
                .iter()
                .position(|known| *known == harmonic.frequency);
            let law = law.expect("all frequencies were collected");
            let at = place(coordinate) + 2 * r * (law + 1);
            let angle = reduced_angle(harmonic.frequency, now.time(), harmonic.phase);
            let (sine, cosine) = angle.sin_cos();
            loads[at] += harmonic.amplitude * sine;
            loads[at + r] += harmonic.amplitude * cosine;
        }
        for at in self.states..state.len() {
            state[at] = T::from(loads[at]).scale(-self.units[at]);
        }
    }

    /// Displacements and velocities of all coordinates.
    pub(super) fn motion(&self, state: &[T]) -> (Vec<f64>, Vec<f64>) {
        let n = self.coordinates;
        let own: Vec<T> = (0..self.states)
            .map(|i| state[i].scale(self.units[i]))
            .collect();
        let forces = self.forces(state);
        let place = |i: usize| {
            let follows = dot(&self.x[i * self.states..][..self.states], &own);
            let fed = self.feed.chunks(n).nth(i);
            fed.map_or(follows, |row| follows + dot(row, &forces))
                .to_f64()
        };
        let speed = |i: usize| self.velocity(state, i).to_f64();
        ((0..n).map(place).collect(), (0..n).map(speed).collect())
    }

    /// The velocity of one coordinate.
    pub(super) fn velocity(&self, state: &[T], coordinate: usize) -> T {
        dot(&self.v[coordinate * self.a.n..][..self.a.n], state)
    }

    /// The force on each coordinate.
    fn forces(&self, state: &[T]) -> Vec<T> {
        let n = self.coordinates;
        let mut forces = vec![T::ZERO; n];
        for (j, coordinate) in self.loaded.iter().enumerate() {
            for law in 0..=self.frequencies.len() {
                let at = self.states + 2 * self.loaded.len() * law + j;
                forces[*coordinate] = forces[*coordinate] + state[at].scale(self.units[at]);
            }
        }
        forces
    }

    /// The work of loads that jump from what they are in `before` to what they are in `after`, at one
    /// instant: what follows the loads at once moves by D Δf, against half of both forces on the way.
    pub(super) fn jump(&self, before: &[T], after: &[T]) -> T {
        let (before, after) = (self.forces(before), self.forces(after));
        let change: Vec<T> = before.iter().zip(&after).map(|(a, b)| *b - *a).collect();
        let mean: Vec<T> = before
            .iter()
            .zip(&after)
            .map(|(a, b)| (*a + *b).scale(-1))
            .collect();
        let moved: Vec<T> = self
            .feed
            .chunks(mean.len())
            .map(|row| dot(row, &change))
            .collect();
        dot(&mean, &moved)
    }

    /// Adds a blow to the state, and gives its work: its momentum times the mean of the velocities
    /// before and after.
    pub(super) fn strike(&self, state: &mut [T], blows: &[(usize, f64)]) -> T {
        let n = self.coordinates;
        let before = state.to_vec();
        for &(coordinate, momentum) in blows {
            let own = state[..self.states].iter_mut().zip(&self.units);
            for (i, (entry, unit)) in own.enumerate() {
                let change = self.b[i * n + coordinate] * T::from(momentum);
                *entry = *entry + change.scale(-unit);
            }
        }
        blows.iter().fold(T::ZERO, |work, &(coordinate, momentum)| {
            let twice = self.velocity(&before, coordinate) + self.velocity(state, coordinate);
            work + T::from(momentum).scale(-1) * twice
        })
    }
}

/// A matrix by rows.
fn converted<T: Real>(matrix: MatRef<'_, f64>) -> Vec<T> {
    let rows = (0..matrix.nrows()).flat_map(|i| (0..matrix.ncols()).map(move |j| (i, j)));
    rows.map(|(i, j)| T::from(matrix[(i, j)])).collect()
}

/// to += factor·row.
fn add_row<T: Real>(to: &mut [T], factor: T, row: &[T]) {
    if factor.is_zero() {
        return;
    }
    for (to, entry) in to.iter_mut().zip(row) {
        *to = *to + factor * *entry;
    }
}

/// form += factor·(a bᵀ + b aᵀ)/2.
fn add_product<T: Real>(form: &mut Square<T>, factor: T, a: &[T], b: &[T]) {
    let half = factor.scale(-1);
    let n = form.n;
    for i in 0..n {
        add_row(&mut form.entries[i * n..][..n], half * a[i], b);
        add_row(&mut form.entries[i * n..][..n], half * b[i], a);
    }
}
