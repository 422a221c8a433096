//! What switches do to the equation of motion in each of their phases, in doubles.

use eigentone_modes::{Form, System};
use eigentone_response::Problem;
use eigentone_switching::{DamperLaw, EventKind, Switch};

use crate::integrator::{EquationOfMotion, Forces};

/// The law that a switch follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    /// A friction that holds.
    Stick,
    /// One that pulls with all that it has against this sign where others hold its ends.
    Full(i8),
    /// A friction against a rate of this sign.
    Slip(i8),
    /// A stop or a rigid stop that is not pressed.
    Open,
    /// One that is.
    Closed,
    /// A damper with its low and its high damping, by the law of the sky, and one that holds v_b = 0.
    Low,
    High,
    Sky,
    Hold,
}

impl Phase {
    /// What a change to another phase is called.
    pub(super) fn becomes(self, next: Phase) -> Option<EventKind> {
        match (self, next) {
            _ if self == next => None,
            (Phase::Stick | Phase::Full(_), Phase::Stick | Phase::Full(_)) => None,
            (_, Phase::Slip(_)) => Some(EventKind::Slip),
            (_, Phase::Stick | Phase::Full(_)) => Some(EventKind::Stick),
            (_, Phase::Closed) => Some(EventKind::Contact),
            (_, Phase::Open) => Some(EventKind::Release),
            _ => Some(EventKind::Switch),
        }
    }
}

/// A form of coordinates and supports, and what a unit force along it accelerates.
struct Direction {
    form: Form,
    mobility: Vec<f64>,
    /// What it accelerates along itself.
    reply: f64,
}

impl Direction {
    fn of(equation: &EquationOfMotion, form: Form) -> Direction {
        let mut mobility = vec![0.0; equation.len()];
        for (coordinate, factor) in &form.coordinates {
            equation.push(*coordinate, *factor, &mut mobility);
        }
        let along = form.coordinates.iter();
        let reply = along.map(|(i, factor)| factor * mobility[*i]).sum();
        Direction {
            form,
            mobility,
            reply,
        }
    }

    /// The derivative of an order, from that of the coordinates.
    fn value(&self, coordinates: &[f64], supports: &[[f64; 3]], order: usize) -> f64 {
        let own = self.form.coordinates.iter();
        let own: f64 = own.map(|(i, factor)| factor * coordinates[*i]).sum();
        let others = self.form.supports.iter();
        own + others
            .map(|(i, factor)| factor * supports[*i][order])
            .sum::<f64>()
    }
}

pub(super) struct Placed<'a> {
    pub(super) switch: &'a Switch,
    stretch: Direction,
    body: Direction,
}

/// The system with its switches.
pub(super) struct Law<'a> {
    pub(super) equation: &'a EquationOfMotion,
    problem: &'a Problem<'a>,
    pub(super) placed: Vec<Placed<'a>>,
    /// Of displacements and of velocities: what is far smaller counts as 0.
    pub(super) sizes: [f64; 2],
}

/// A state and what acts there.
pub(super) struct Moment {
    pub(super) accelerations: Vec<f64>,
    /// Of each switch on b along its stretch.
    pub(super) forces: Vec<f64>,
    /// The largest acceleration if nothing held.
    size: f64,
}

impl Moment {
    /// Whether all moves in the same way, but for rounding.
    pub(super) fn is_like(&self, other: &Moment) -> bool {
        let mut pairs = self.accelerations.iter().zip(&other.accelerations);
        let size = self.size.max(other.size);
        pairs.all(|(a, b)| (a - b).abs() <= ROUNDING * size)
    }
}

/// Where a motion is.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) piece: usize,
    /// Seconds since the piece began.
    pub(super) elapsed: f64,
    pub(super) state: &'a [f64],
}

/// Accelerations that cancel to this part of their terms are rounding.
const CANCELS: f64 = 256.0 * f64::EPSILON;

/// What counts as 0 beside the largest so far.
pub(super) const NOTHING: f64 = 1e-11;

/// What may be at a limit is as near to it.
const NEAR: f64 = 10.0 * NOTHING;

/// How far accelerations that are equal may differ beside the largest.
const ROUNDING: f64 = 1e-9;

impl<'a> Law<'a> {
    pub(super) fn of(
        equation: &'a EquationOfMotion,
        problem: &'a Problem<'a>,
        switches: &'a [Switch],
    ) -> Result<Law<'a>, String> {
        let system = problem.system();
        let placed = switches.iter().map(|switch| {
            let [a, b] = switch.between();
            let [a, b] = [known(system, a)?, known(system, b)?];
            let less = |(i, factor): &(usize, f64)| (*i, -factor);
            let stretch = Form {
                coordinates: b
                    .coordinates
                    .iter()
                    .copied()
                    .chain(a.coordinates.iter().map(less))
                    .collect(),
                supports: b
                    .supports
                    .iter()
                    .copied()
                    .chain(a.supports.iter().map(less))
                    .collect(),
            };
            let stretch = Direction::of(equation, stretch);
            let body = Direction::of(equation, b);
            Ok(Placed {
                switch,
                stretch,
                body,
            })
        });
        Ok(Law {
            equation,
            problem,
            placed: placed.collect::<Result<_, String>>()?,
            sizes: [f64::MIN_POSITIVE; 2],
        })
    }

    pub(super) fn len(&self) -> usize {
        self.placed.len()
    }

    /// Why the motion is not followed: where a support jumps at what damps and switches, the rates are infinite.
    pub(super) fn refuses(&self) -> Option<String> {
        let pieces = self.problem.timeline().pieces();
        let mut before = vec![[0.0; 3]; self.problem.system().supports().len()];
        for (piece, begun) in pieces.iter().enumerate() {
            if piece > 0 {
                before = self.problem.supports(piece - 1, begun.start());
            }
            let after = self.problem.supports(piece, begun.start());
            for (k, placed) in self.placed.iter().enumerate() {
                let damps = match placed.switch {
                    Switch::Stop(stop) => stop.damping != 0.0,
                    Switch::ControlledDamper(damper) => damper.high != 0.0,
                    Switch::Friction(_) | Switch::Impact(_) => false,
                };
                let none = vec![0.0; self.equation.len()];
                let [from, to] = [&before, &after].map(|all| placed.stretch.value(&none, all, 0));
                if damps && (to - from).abs() > NOTHING * from.abs().max(to.abs()) {
                    return Some(format!(
                        "at t = {:?} s a support jumps at the damping of switch {k}, which it does not follow",
                        begun.start()
                    ));
                }
            }
        }
        None
    }

    fn supports(&self, place: Place<'_>) -> Vec<[f64; 3]> {
        let forces = Forces {
            problem: self.problem,
            piece: place.piece,
        };
        self.problem
            .supports(place.piece, forces.start() + place.elapsed)
    }

    /// The force of a switch where its phase gives it.
    fn force(&self, k: usize, phase: Phase, rate: f64, stretch: f64, body: f64) -> f64 {
        match (self.placed[k].switch, phase) {
            (Switch::Friction(friction), Phase::Slip(sign)) => -f64::from(sign) * friction.force,
            (Switch::Friction(friction), Phase::Full(sign)) => {
                -f64::from(sign) * friction.static_force
            }
            (Switch::Stop(stop), Phase::Closed) => {
                -stop.stiffness * (stretch - stop.gap) - stop.damping * rate
            }
            (Switch::ControlledDamper(damper), Phase::Low) => -damper.low * rate,
            (Switch::ControlledDamper(damper), Phase::High) => -damper.high * rate,
            (Switch::ControlledDamper(damper), Phase::Sky) => match damper.law {
                DamperLaw::ClippedSkyhook { sky } => -sky * body,
                DamperLaw::OnOffSkyhook => 0.0,
            },
            _ => 0.0,
        }
    }

    fn holds(&self, k: usize, phase: Phase) -> Option<&Direction> {
        let placed = &self.placed[k];
        match (placed.switch, phase) {
            (_, Phase::Stick) | (Switch::Impact(_), Phase::Closed) => Some(&placed.stretch),
            (_, Phase::Hold) => Some(&placed.body),
            _ => None,
        }
    }

    /// Takes the sizes of a state, and those of what is at rest by what accelerates it.
    pub(super) fn see(&mut self, place: Place<'_>) {
        const PART: f64 = 1e4;
        let n = self.equation.len();
        let mut accelerations = vec![0.0; n];
        let forces = Forces {
            problem: self.problem,
            piece: place.piece,
        };
        self.equation.acceleration(
            place.state,
            &forces,
            place.elapsed + self.soon(),
            &mut accelerations,
        );
        let largest = |values: &[f64]| {
            values
                .iter()
                .fold(0.0f64, |size, value| size.max(value.abs()))
        };
        let (x, v) = place.state.split_at(n);
        let gained = largest(&accelerations) * self.soon() * PART;
        let sizes = [largest(x), largest(v).max(gained)];
        for (known, size) in self.sizes.iter_mut().zip(sizes) {
            *known = known.max(size);
        }
    }

    /// What acts in these phases; `None` where what is held depends on each other.
    pub(super) fn moment(&self, phases: &[Phase], place: Place<'_>) -> Option<Moment> {
        let n = self.equation.len();
        let (x, v) = place.state.split_at(n);
        let mut accelerations = vec![0.0; n];
        let forces = Forces {
            problem: self.problem,
            piece: place.piece,
        };
        self.equation
            .acceleration(place.state, &forces, place.elapsed, &mut accelerations);
        let supports = self.supports(place);
        let mut acting = vec![0.0; self.len()];
        let mut held = Vec::new();
        for (k, phase) in phases.iter().enumerate() {
            let placed = &self.placed[k];
            if let Some(relation) = self.holds(k, *phase) {
                held.push((k, relation));
                continue;
            }
            let stretch = placed.stretch.value(x, &supports, 0);
            let rate = placed.stretch.value(v, &supports, 1);
            let body = placed.body.value(v, &supports, 1);
            acting[k] = self.force(k, *phase, rate, stretch, body);
            add(&mut accelerations, acting[k], &placed.stretch.mobility);
        }
        let sizes = accelerations.iter().map(|value| value.abs());
        let size = sizes.fold(0.0, f64::max);
        // Σⱼ (rₖ·bⱼ) λⱼ = −rₖ·x″.
        let count = held.len();
        let mut rows: Vec<Vec<f64>> = Vec::with_capacity(count);
        for (_, relation) in &held {
            let none = vec![[0.0; 3]; supports.len()];
            let each = held
                .iter()
                .map(|(j, _)| relation.value(&self.placed[*j].stretch.mobility, &none, 0));
            let mut row: Vec<f64> = each.collect();
            row.push(-relation.value(&accelerations, &supports, 2));
            rows.push(row);
        }
        let answer = solved(rows)?;
        // Each force is known to a part of the largest one.
        let largest = answer
            .iter()
            .fold(0.0f64, |size, force| size.max(force.abs()));
        let mut terms: Vec<f64> = accelerations.iter().map(|value| value.abs()).collect();
        for ((k, _), force) in held.iter().zip(answer) {
            let mobility = &self.placed[*k].stretch.mobility;
            acting[*k] = force;
            add(&mut accelerations, force, mobility);
            let each = terms.iter_mut().zip(mobility);
            each.for_each(|(size, gain)| *size += (largest * gain).abs());
        }
        // What is held is not moved by rounding.
        for (value, size) in accelerations.iter_mut().zip(terms) {
            if value.abs() <= CANCELS * size {
                *value = 0.0;
            }
        }
        Some(Moment {
            accelerations,
            forces: acting,
            size,
        })
    }

    /// A number that is negative once a phase does not last any longer.
    pub(super) fn guard(&self, k: usize, phase: Phase, place: Place<'_>, moment: &Moment) -> f64 {
        let placed = &self.placed[k];
        let (x, v) = place.state.split_at(self.equation.len());
        let supports = self.supports(place);
        let rate = placed.stretch.value(v, &supports, 1);
        let body = placed.body.value(v, &supports, 1);
        let [x_size, v_size] = self.sizes;
        let v_size = v_size.max(rate.abs()).max(body.abs());
        match (placed.switch, phase) {
            (Switch::Friction(friction), Phase::Stick) => {
                let most = friction.static_force;
                (most - moment.forces[k].abs()) / most.max(f64::MIN_POSITIVE) + NOTHING
            }
            (_, Phase::Slip(sign)) => f64::from(sign) * rate / v_size + NOTHING,
            (_, Phase::Full(_)) => {
                let apart = placed.stretch.value(&moment.accelerations, &supports, 2);
                ROUNDING - apart.abs() / moment.size.max(f64::MIN_POSITIVE)
            }
            (Switch::Impact(_), Phase::Closed) => -moment.forces[k] + NOTHING * v_size,
            (Switch::Stop(_) | Switch::Impact(_), _) => {
                let beyond = placed.stretch.value(x, &supports, 0) - gap(placed.switch);
                let sign = if phase == Phase::Closed { 1.0 } else { -1.0 };
                sign * beyond / x_size + NOTHING
            }
            (Switch::ControlledDamper(damper), phase) => {
                let product = |sky: f64, c: f64| (sky * body - c * rate) / v_size * (rate / v_size);
                let nothing = NOTHING * NOTHING;
                match (damper.law, phase) {
                    (_, Phase::Hold) => {
                        let needed = -moment.forces[k] / rate;
                        (needed - damper.low).min(damper.high - needed) + NOTHING * damper.high
                    }
                    (DamperLaw::OnOffSkyhook, Phase::High) => product(1.0, 0.0) + nothing,
                    (DamperLaw::OnOffSkyhook, _) => -product(1.0, 0.0) + nothing,
                    (DamperLaw::ClippedSkyhook { sky }, phase) => {
                        let (low, high) = (product(sky, damper.low), product(sky, damper.high));
                        let (low, high) = (low / damper.high, high / damper.high);
                        match phase {
                            Phase::Low => -low + nothing,
                            Phase::High => high + nothing,
                            _ => low.min(-high) + nothing,
                        }
                    }
                }
            }
            _ => 1.0,
        }
    }

    /// Whether a rigid stop that is not pressed comes no nearer, where it touches.
    pub(super) fn stays_open(&self, k: usize, phase: Phase, place: Place<'_>) -> bool {
        let placed = &self.placed[k];
        let (x, v) = place.state.split_at(self.equation.len());
        let supports = self.supports(place);
        let is_open = matches!((placed.switch, phase), (Switch::Impact(_), Phase::Open));
        let beyond = placed.stretch.value(x, &supports, 0) - gap(placed.switch);
        let rate = placed.stretch.value(v, &supports, 1);
        !(is_open && beyond >= -NEAR * self.sizes[0] && rate > NOTHING * self.sizes[1])
    }

    /// The phases that a switch may have, those that hold first.
    pub(super) fn candidates(&self, k: usize, place: Place<'_>) -> Vec<Phase> {
        let placed = &self.placed[k];
        let (x, v) = place.state.split_at(self.equation.len());
        let supports = self.supports(place);
        let [x_size, v_size] = self.sizes;
        let sign = |value: f64, size: f64| match value {
            value if value > NEAR * size => 1,
            value if value < -NEAR * size => -1,
            _ => 0,
        };
        let rate = sign(placed.stretch.value(v, &supports, 1), v_size);
        let beyond = || placed.stretch.value(x, &supports, 0) - gap(placed.switch);
        match placed.switch {
            Switch::Friction(_) => match rate {
                0 => vec![Phase::Stick, Phase::Slip(1), Phase::Slip(-1)],
                sign => vec![Phase::Slip(sign)],
            },
            Switch::Stop(_) => match (sign(beyond(), x_size), rate) {
                (1, _) | (0, 1) => vec![Phase::Closed],
                (0, 0) => vec![Phase::Closed, Phase::Open],
                _ => vec![Phase::Open],
            },
            Switch::Impact(_) => match (sign(beyond(), x_size), rate) {
                (0 | 1, 0) => vec![Phase::Closed, Phase::Open],
                _ => vec![Phase::Open],
            },
            Switch::ControlledDamper(damper) => match damper.law {
                DamperLaw::OnOffSkyhook => {
                    let body = placed.body.value(v, &supports, 1);
                    let mut all = vec![Phase::Low, Phase::High];
                    if sign(body, v_size) == 0 {
                        all.push(Phase::Hold);
                    }
                    all
                }
                // Between two limits of 0 there is no force.
                DamperLaw::ClippedSkyhook { .. }
                    if rate == 0 && sign(placed.body.value(v, &supports, 1), v_size) != 0 =>
                {
                    vec![Phase::Low, Phase::High]
                }
                DamperLaw::ClippedSkyhook { .. } => vec![Phase::Low, Phase::Sky, Phase::High],
            },
        }
    }

    /// Seconds in which nothing moves far.
    pub(super) fn soon(&self) -> f64 {
        let grid = self.problem.grid();
        let loads = self.problem.timeline().fastest();
        let end = grid.time(grid.last()).max(f64::MIN_POSITIVE);
        1e-6 / self.equation.fastest().max(loads).max(1.0 / end)
    }

    /// Reverses what hits rigid stops, and gives the stops that were hit.
    pub(super) fn apply_impacts(
        &self,
        phases: &[Phase],
        piece: usize,
        elapsed: f64,
        state: &mut [f64],
    ) -> Result<Vec<usize>, String> {
        /// Beside the largest velocity so slow that nothing bounces any longer.
        const SLOW: f64 = 1e-7;
        let n = self.equation.len();
        let mut hit = Vec::new();
        for _ in 0..1000 {
            let supports = self.supports(Place {
                piece,
                elapsed,
                state,
            });
            let impact = self.placed.iter().enumerate().find_map(|(k, placed)| {
                let Switch::Impact(impact) = placed.switch else {
                    return None;
                };
                let beyond = placed.stretch.value(&state[..n], &supports, 0) - impact.gap;
                let rate = placed.stretch.value(&state[n..], &supports, 1);
                let hits = beyond >= -NEAR * self.sizes[0] && rate > NOTHING * self.sizes[1];
                hits.then_some((k, impact.restitution, rate))
            });
            let Some((k, restitution, rate)) = impact else {
                return Ok(hit);
            };
            let direction = &self.placed[k].stretch;
            // A bounce is over in a moment that is brought back in it.
            let mut free = phases.to_vec();
            if let Some(phase) = free.get_mut(k) {
                *phase = Phase::Open;
            }
            let place = Place {
                piece,
                elapsed,
                state,
            };
            let moment = self.moment(&free, place);
            let back = moment.map_or(0.0, |moment| {
                direction.value(&moment.accelerations, &supports, 2)
            });
            let bounces = rate > SLOW * self.sizes[1]
                && (restitution == 0.0 || restitution * rate > back * self.soon());
            let factor = if bounces { 1.0 + restitution } else { 1.0 };
            add(
                &mut state[n..],
                -factor * rate / direction.reply,
                &direction.mobility,
            );
            if bounces {
                hit.push(k);
            }
        }
        Err("rigid stops hit each other without end".to_owned())
    }

    /// Takes away what rounding left of the rates that are held, and brings what is pressed to its stop.
    pub(super) fn project(&self, phases: &[Phase], piece: usize, elapsed: f64, state: &mut [f64]) {
        let n = self.equation.len();
        let supports = self.supports(Place {
            piece,
            elapsed,
            state,
        });
        for _ in 0..8 {
            for (k, phase) in phases.iter().enumerate() {
                if let Some(relation) = self.holds(k, *phase) {
                    let left = relation.value(&state[n..], &supports, 1);
                    add(&mut state[n..], -left / relation.reply, &relation.mobility);
                    if let Switch::Impact(impact) = self.placed[k].switch {
                        let beyond = relation.value(&state[..n], &supports, 0) - impact.gap;
                        add(
                            &mut state[..n],
                            -beyond / relation.reply,
                            &relation.mobility,
                        );
                    }
                }
            }
        }
        // Squares of what is left would be lost.
        let least = f64::EPSILON * f64::EPSILON * self.sizes[1];
        let left = state[n..].iter_mut().filter(|value| value.abs() < least);
        left.for_each(|value| *value = 0.0);
    }
}

fn known(system: &System, name: &str) -> Result<Form, String> {
    system
        .form(name)
        .ok_or_else(|| format!("{name:?} is no known name"))
}

fn gap(switch: &Switch) -> f64 {
    match switch {
        Switch::Stop(stop) => stop.gap,
        Switch::Impact(impact) => impact.gap,
        _ => 0.0,
    }
}

fn add(sum: &mut [f64], factor: f64, vector: &[f64]) {
    for (sum, entry) in sum.iter_mut().zip(vector) {
        *sum += factor * entry;
    }
}

/// Gauss's elimination with the largest pivots of rows that carry their right-hand sides; `None` if singular.
fn solved(mut rows: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let n = rows.len();
    let size = rows
        .iter()
        .flat_map(|row| &row[..n])
        .fold(0.0f64, |size, entry| size.max(entry.abs()));
    for k in 0..n {
        let pivot = (k..n).max_by(|a, b| rows[*a][k].abs().total_cmp(&rows[*b][k].abs()))?;
        rows.swap(k, pivot);
        if rows[k][k].abs() <= 1e-12 * size {
            return None;
        }
        let (above, below) = rows.split_at_mut(k + 1);
        for row in below {
            let factor = row[k] / above[k][k];
            for (entry, top) in row.iter_mut().zip(&above[k]) {
                *entry -= factor * top;
            }
        }
    }
    let mut answer = vec![0.0; n];
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| rows[k][j] * answer[j]).sum();
        answer[k] = (rows[k][n] - known) / rows[k][k];
    }
    Some(answer)
}
