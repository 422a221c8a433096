//! The system and what drives it as one autonomous equation ζ′ = A ζ, of which powers are quadratic forms.

use eigentone_digits::{DoubleDouble, Real};
use eigentone_modes::{FirstOrder, MatrixKind, balance};
use faer::MatRef;

use crate::hold::reduced_angle;
use crate::problem::{Instant, Piece, Problem, Rate};

use super::gramian::{Square, dot};
use super::squares::Squares;
use super::state_matrix::{lumped, state_matrix};

/// Where things stand in ζ = (z, then the integrals of signals, then of each signal its straight part and the slope of that,
/// then of each sinusoid itself and what it is a quarter period ahead).
pub(super) struct Layout {
    /// The coordinates, and beyond them the channels, that more than impulses act on; rising.
    signals: Vec<usize>,
    /// Sinusoids: place of the signal, and rate.
    waves: Vec<(usize, Rate)>,
    /// How many entries are the system's own.
    own: usize,
    /// How many are those and the integrals.
    states: usize,
}

impl Layout {
    pub(super) fn of(problem: &Problem<'_>, form: &FirstOrder) -> Layout {
        let timeline = problem.timeline();
        let straight = timeline.pieces().iter().flat_map(Piece::straight);
        let mut signals: Vec<usize> = straight.map(|straight| straight.coordinate).collect();
        let harmonics = timeline.harmonics().iter();
        let harmonics = harmonics.map(|(on, one)| (*on, Rate::Given(one.frequency)));
        let pulses = timeline.pulses().iter();
        let pulses = pulses.map(|pulse| (pulse.coordinate, pulse.rate));
        let all: Vec<(usize, Rate)> = harmonics.chain(pulses).collect();
        signals.extend(all.iter().map(|(on, _)| *on));
        signals.sort_unstable();
        signals.dedup();
        let mut layout = Layout {
            waves: Vec::new(),
            own: form.states(),
            states: form.states(),
            signals,
        };
        for (on, rate) in all {
            let wave = (layout.signal(on).expect("collected above"), rate);
            if !layout.waves.contains(&wave) {
                layout.waves.push(wave);
            }
        }
        let integrals = problem.channels().iter().map(|channel| channel.integrals);
        layout.states += integrals.sum::<usize>();
        layout
    }

    /// How many entries ζ has.
    pub(super) fn len(&self) -> usize {
        self.wave(self.waves.len())
    }

    fn signal(&self, on: usize) -> Option<usize> {
        self.signals.binary_search(&on).ok()
    }

    /// The entry of the straight part; its slope comes next.
    fn straight(&self, signal: usize) -> usize {
        self.states + 2 * signal
    }

    /// The entry of a sinusoid; what it is a quarter period ahead comes next.
    fn wave(&self, wave: usize) -> usize {
        self.straight(self.signals.len()) + 2 * wave
    }

    /// The entry of the sinusoid of a signal at a rate.
    fn wave_of(&self, on: usize, rate: Rate) -> usize {
        let signal = self.signal(on).expect("all signals were collected");
        let known = self.waves.iter().position(|wave| *wave == (signal, rate));
        self.wave(known.expect("all sinusoids were collected"))
    }

    /// The row that makes a signal of ζ.
    fn course<T: Real>(&self, on: usize) -> Vec<T> {
        let mut row = vec![T::ZERO; self.len()];
        if let Some(signal) = self.signal(on) {
            row[self.straight(signal)] = T::ONE;
            let waves = self.waves.iter().enumerate();
            for (wave, _) in waves.filter(|(_, (of, _))| *of == signal) {
                row[self.wave(wave)] = T::ONE;
            }
        }
        row
    }
}

/// ζ with each entry in units of a power of two, and what is a linear function of it.
pub(super) struct DrivenForm<T> {
    layout: Layout,
    a: Square<T>,
    coordinates: usize,
    /// Rows of the displacements of coordinates and then supports, and of their velocities.
    displacements: Vec<Vec<T>>,
    velocities: Vec<Vec<T>>,
    /// Rows of the loads on the coordinates, those on points included.
    loads: Vec<Vec<T>>,
    /// Rows of the forces that the supports take, and of what springs make of them.
    pulls: Vec<Vec<T>>,
    tensions: Vec<Vec<T>>,
    /// Whether forces displace coordinates at once, and whether supports carry mass.
    gives_way: bool,
    carries: bool,
    mass: Squares<T>,
    damping: Squares<T>,
    stiffness: Squares<T>,
    /// N × n: what unit impulses add to z.
    b: Vec<T>,
    /// ζ_i counts in units of 2 to this power.
    units: Vec<i64>,
}

impl<T: Real> DrivenForm<T> {
    /// `None` where the rates of the states leave the range of doubles.
    pub(super) fn of(problem: &Problem<'_>, form: &FirstOrder, layout: Layout) -> Option<Self> {
        let system = problem.system();
        let (n, size, own) = (system.len(), layout.len(), layout.own);
        let (own_motion, b) = match lumped(system) {
            Some(masses) => state_matrix(system, masses),
            None => (converted(form.a()), converted(form.b())),
        };
        let mut a = Square::zeros(size);
        for signal in 0..layout.signals.len() {
            let at = layout.straight(signal);
            a.entries[at * size + at + 1] = T::ONE;
        }
        for (wave, (_, rate)) in layout.waves.iter().enumerate() {
            let (at, rate) = (layout.wave(wave), rate.value::<T>().0);
            a.entries[at * size + at + 1] = rate;
            a.entries[(at + 1) * size + at] = -rate;
        }
        let row = || vec![T::ZERO; size];
        let mut loads = vec![row(); n];
        for &on in layout.signals.iter().filter(|on| **on < n) {
            add_row(&mut loads[on], T::ONE, &layout.course(on));
        }
        let mut forces = vec![row(); n];
        let mut supports = vec![row(); system.supports().len()];
        let mut first = own;
        for (on, channel) in (n..).zip(problem.channels()) {
            let mut course = layout.course(on);
            let next = first + channel.integrals;
            for at in first..next {
                match at + 1 < next {
                    true => a.entries[at * size + at + 1] = T::ONE,
                    false => add_row(&mut a.entries[at * size..][..size], T::ONE, &course),
                }
            }
            if first < next {
                course = row();
                course[first] = T::ONE;
            }
            first = next;
            if let Some(support) = channel.support {
                add_row(&mut supports[support], T::ONE, &course);
            }
            let pushed = match channel.support {
                Some(_) => &mut forces,
                None => &mut loads,
            };
            for direction in &channel.directions {
                for &(on, factor) in direction {
                    add_row(&mut pushed[on], T::from(factor), &course);
                }
                course = a.before(&course);
            }
        }
        for (force, load) in forces.iter_mut().zip(&loads) {
            add_row(force, T::ONE, load);
        }
        for i in 0..own {
            let entries = &mut a.entries[i * size..][..size];
            entries[..own].copy_from_slice(&own_motion[i * own..][..own]);
            for (factor, force) in b[i * n..][..n].iter().zip(&forces) {
                add_row(entries, *factor, force);
            }
        }
        let mut displacements = vec![row(); n];
        let x = form.x();
        for (i, place) in displacements.iter_mut().enumerate() {
            for (k, entry) in place[..own].iter_mut().enumerate() {
                *entry = T::from(x[(i, k)]);
            }
            for (j, force) in forces.iter().enumerate() {
                let fed = form.d().map_or(0.0, |d| d[(i, j)]);
                add_row(place, T::from(fed), force);
            }
        }
        displacements.extend(supports);
        let driven = |rows: &[Vec<T>]| -> Vec<Vec<T>> {
            let rows = rows.iter();
            rows.map(|row| a.before(row)).collect()
        };
        let velocities = driven(&displacements);
        let kinds = [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness];
        let [mass, damping, stiffness] = kinds.map(|kind| Squares::of(system, kind));
        let places = n..displacements.len();
        let mut tensions = vec![row(); places.len()];
        let mut pulls = tensions.clone();
        if !places.is_empty() {
            let accelerations = driven(&velocities);
            for (support, place) in places.enumerate() {
                let pull = |to: &mut Vec<T>, squares: &Squares<T>, rows: &[Vec<T>]| {
                    squares.on(place, |value, other| {
                        add_row(to, value, &rows[place]);
                        if let Some(other) = other {
                            add_row(to, -value, &rows[other]);
                        }
                    });
                };
                pull(&mut tensions[support], &stiffness, &displacements);
                let whole = &mut pulls[support];
                add_row(whole, T::ONE, &tensions[support]);
                pull(whole, &damping, &velocities);
                pull(whole, &mass, &accelerations);
            }
        }
        let mut driven = DrivenForm {
            units: vec![0; size],
            layout,
            a,
            coordinates: n,
            displacements,
            velocities,
            loads,
            pulls,
            tensions,
            gives_way: form.d().is_some(),
            carries: !system.between_supports(MatrixKind::Mass).is_empty(),
            mass,
            damping,
            stiffness,
            b,
        };
        driven.choose_units(form.a())?;
        Some(driven)
    }

    /// Units in which rows and columns of A are alike in size, and what drives the states moves them about as fast as
    /// these move each other. `None` where such rates leave the range of doubles.
    fn choose_units(&mut self, own: MatRef<'_, f64>) -> Option<()> {
        let (size, layout) = (self.a.n, &self.layout);
        let balanced = balance(own);
        for (unit, scale) in self.units.iter_mut().zip(&balanced.scale) {
            *unit = scale.log2() as i64;
        }
        let rate = balanced.matrix.norm_max();
        let rate = match rate {
            0.0 => 0,
            rate => rate.is_finite().then(|| rate.log2().ceil() as i64)?,
        };
        // Each entry of ζ drives those before it alone; a sinusoid and what is ahead of it have one unit.
        let mut column = layout.own;
        while column < size {
            let pair = column >= layout.wave(0);
            let columns = column..column + if pair { 2 } else { 1 };
            let moved = columns
                .clone()
                .flat_map(|j| (0..column).map(move |i| (i, j)));
            let moved = moved.filter_map(|(i, j)| {
                let entry = self.a.entries[i * size + j].magnitude();
                (!entry.is_zero()).then(|| entry.exponent() - self.units[i])
            });
            let unit = rate - moved.max().unwrap_or(rate);
            self.units[columns.clone()].fill(unit);
            column = columns.end;
        }
        for i in 0..size {
            for j in 0..size {
                let entry = &mut self.a.entries[i * size + j];
                *entry = entry.scale(self.units[j] - self.units[i]);
            }
        }
        let rows = [
            &mut self.displacements,
            &mut self.velocities,
            &mut self.loads,
            &mut self.pulls,
            &mut self.tensions,
        ];
        for row in rows.into_iter().flatten() {
            for (entry, unit) in row.iter_mut().zip(&self.units) {
                *entry = entry.scale(*unit);
            }
        }
        Some(())
    }

    /// A·h, for steps of h seconds as the unit of time.
    pub(super) fn over(&self, h: DoubleDouble) -> Square<T> {
        let h = T::from(h.high()) + T::from(h.low());
        let mut a = self.a.clone();
        a.entries.iter_mut().for_each(|entry| *entry = *entry * h);
        a
    }

    /// The form of what dampers take.
    pub(super) fn dissipation(&self) -> Square<T> {
        let mut form = Square::zeros(self.a.n);
        self.damping.each(|value, i, j| {
            let mut rate = self.velocities[i].clone();
            if let Some(j) = j {
                add_row(&mut rate, -T::ONE, &self.velocities[j]);
            }
            add_product(&mut form, value, &rate, &rate);
        });
        form
    }

    /// The form of what loads and the motions of supports bring.
    pub(super) fn power(&self) -> Square<T> {
        let mut form = Square::zeros(self.a.n);
        let forces = self.loads.iter().chain(&self.pulls);
        for (force, speed) in forces.zip(&self.velocities) {
            if force.iter().any(|entry| !entry.is_zero()) {
                add_product(&mut form, T::ONE, force, speed);
            }
        }
        form
    }

    /// ζ where nothing moves.
    pub(super) fn at_rest(&self) -> Vec<T> {
        vec![T::ZERO; self.a.n]
    }

    /// Sets the system's own state.
    pub(super) fn set(&self, state: &mut [T], z: &[f64]) {
        let own = state.iter_mut().zip(&self.units);
        for ((entry, unit), value) in own.zip(z) {
            *entry = T::from(*value).scale(-unit);
        }
    }

    /// Sets what the signals are at `now`, by the laws of `piece`.
    pub(super) fn load(
        &self,
        state: &mut [T],
        problem: &Problem<'_>,
        now: &Instant,
        piece: &Piece,
    ) {
        let layout = &self.layout;
        let mut values = vec![0.0; state.len()];
        let elapsed = (now.time() - piece.start_instant().time()).to_f64();
        for straight in piece.straight() {
            let signal = layout.signal(straight.coordinate);
            let at = layout.straight(signal.expect("all signals were collected"));
            values[at] += straight.value + straight.slope * elapsed;
            values[at + 1] += straight.slope;
        }
        let mut add = |on: usize, rate: Rate, [sine, cosine]: [f64; 2], angle: f64| {
            let at = layout.wave_of(on, rate);
            let (s, c) = angle.sin_cos();
            values[at] += sine * s + cosine * c;
            values[at + 1] += sine * c - cosine * s;
        };
        let timeline = problem.timeline();
        for (on, harmonic) in timeline.harmonics() {
            let angle = reduced_angle(harmonic.frequency, now.time(), harmonic.phase);
            let rate = Rate::Given(harmonic.frequency);
            add(*on, rate, [harmonic.amplitude, 0.0], angle);
        }
        for pulse in piece
            .pulses()
            .iter()
            .map(|index| &timeline.pulses()[*index])
        {
            let parts = [pulse.sine, pulse.cosine];
            add(pulse.coordinate, pulse.rate, parts, pulse.angle(now));
        }
        for at in layout.states..state.len() {
            state[at] = T::from(values[at]).scale(-self.units[at]);
        }
    }

    /// Displacements and velocities of coordinates and then supports; those of coordinates as they were found, if they were.
    pub(super) fn motion(&self, state: &[T], found: Option<[&[f64]; 2]>) -> [Vec<T>; 2] {
        let rows = [&self.displacements, &self.velocities];
        let Some(found) = found else {
            return rows.map(|rows| values(rows, state));
        };
        [0, 1].map(|order| {
            let known = found[order].iter().map(|value| T::from(*value));
            known
                .chain(values(&rows[order][self.coordinates..], state))
                .collect()
        })
    }

    fn velocities(&self, state: &[T]) -> Vec<T> {
        values(&self.velocities, state)
    }

    /// Of such displacements and velocities, ½vᵀMv and ½xᵀKx, moving supports included.
    pub(super) fn stored(&self, [x, v]: [Vec<T>; 2]) -> [f64; 2] {
        [self.mass.form(&v), self.stiffness.form(&x)].map(|form| form.scale(-1).to_f64())
    }

    /// The work of what jumps from what it is in `before` to what it is in `after`, at one instant: half of the forces at
    /// both ends times the way that goes at once.
    pub(super) fn jump(&self, before: &[T], after: &[T]) -> T {
        let n = self.coordinates;
        let first = if self.gives_way { 0 } else { n };
        let forces = self.loads.iter().chain(&self.tensions);
        let forces = forces.zip(&self.displacements).skip(first);
        forces.fold(T::ZERO, |sum, (force, place)| {
            let mean = (dot(force, before) + dot(force, after)).scale(-1);
            sum + mean * (dot(place, after) - dot(place, before))
        })
    }

    /// Adds the momenta at the start of a piece to the state, and gives their work: each times the mean of the velocities
    /// before and after. `before` is the state before the signals of the piece set in.
    pub(super) fn apply_impulses(
        &self,
        problem: &Problem<'_>,
        piece: usize,
        before: &[T],
        state: &mut [T],
    ) -> T {
        let n = self.coordinates;
        let impulses = problem.timeline().pieces()[piece].impulses();
        let momenta = problem.momenta(piece);
        if momenta.is_empty() && impulses.is_empty() && !self.carries {
            return T::ZERO;
        }
        let loaded = self.velocities(state);
        for (coordinate, momentum) in momenta {
            let own = state[..self.layout.own].iter_mut().zip(&self.units);
            for (i, (entry, unit)) in own.enumerate() {
                let change = self.b[i * n + coordinate] * T::from(momentum);
                *entry = *entry + change.scale(-unit);
            }
        }
        let [before, after] = [before, &*state].map(|state| self.velocities(state));
        let mut sum = T::ZERO;
        let mut apply = |on: usize, momentum: f64| {
            let mean = (loaded[on] + after[on]).scale(-1);
            sum = sum + T::from(momentum) * mean;
        };
        for &(on, momentum) in impulses {
            match on.checked_sub(n) {
                None => apply(on, momentum),
                Some(channel) => {
                    let shares = problem.channels()[channel].directions[0].iter();
                    shares.for_each(|(row, share)| apply(*row, momentum * share));
                }
            }
        }
        let change = |place: usize| after[place] - before[place];
        for place in n..before.len() {
            let mut momentum = T::ZERO;
            self.mass.on(place, |value, other| {
                let other = other.map_or(T::ZERO, change);
                momentum = momentum + value * (change(place) - other);
            });
            sum = sum + momentum * (before[place] + after[place]).scale(-1);
        }
        sum
    }
}

fn values<T: Real>(rows: &[Vec<T>], state: &[T]) -> Vec<T> {
    rows.iter().map(|row| dot(row, state)).collect()
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
