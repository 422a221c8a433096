//! The linear system that a combination of phases makes.

use eigentone_digits::{BallMatrix, Magnitude, Real};

use crate::error_set::ErrorSet;
use crate::phase::{Phase, Setting};
use crate::rows::{Row, SLACK, length, unit};
use crate::switch::{ControlledDamper, DamperLaw, Stop, Switch};

/// A switch in terms of ζ.
pub(crate) struct Place<T> {
    pub(crate) switch: Switch,
    /// x = x_b − x_a.
    pub(crate) stretch: Row<T>,
    /// v.
    pub(crate) rate: Row<T>,
    /// v_b.
    pub(crate) body: Row<T>,
    /// What a unit force along the stretch adds to ζ′.
    pub(crate) push: Vec<T>,
    /// The error of that, in the 2-norm.
    pub(crate) push_error: f64,
}

impl<T: Real> Place<T> {
    /// What a damper does in a phase; `None` of other elements. Beside what stands still v is v_b, so that its law is that of one damping.
    pub(crate) fn setting(&self, phase: Phase) -> Option<Setting> {
        let own = phase.setting()?;
        match &self.switch {
            Switch::ControlledDamper(damper) if self.is_grounded() => Some(match damper.law {
                _ if own == Setting::Hold => own,
                DamperLaw::OnOffSkyhook => Setting::High,
                DamperLaw::ClippedSkyhook { sky } if sky <= damper.low => Setting::Low,
                DamperLaw::ClippedSkyhook { sky } if sky >= damper.high => Setting::High,
                DamperLaw::ClippedSkyhook { .. } => Setting::Sky,
            }),
            _ => Some(own),
        }
    }

    /// The larger size of v_b and v of a damper whose law at rest is not that of one damping: of those beside what stands still it is.
    pub(crate) fn speed(&self, zeta: &[T]) -> Option<f64> {
        let is_damper = matches!(self.switch, Switch::ControlledDamper(_));
        let speeds = [&self.body, &self.rate].map(|row| row.at(zeta).to_f64().abs());
        (is_damper && !self.is_grounded()).then(|| speeds[0].max(speeds[1]))
    }

    fn is_grounded(&self) -> bool {
        self.body.entries == self.rate.entries
    }
}

/// A function of ζ that stays ≥ 0 while a phase lasts.
pub(crate) struct Guard<T> {
    /// Index of the switch.
    pub(crate) switch: usize,
    pub(crate) row: Row<T>,
}

/// ζ′ = W ζ in a combination of phases.
pub(crate) struct Configuration<T> {
    /// W·h, by rows, without zeros.
    pub(crate) rows: Vec<Vec<(usize, T)>>,
    /// The sizes of its entries, rounded up.
    pub(crate) sizes: Vec<Vec<(usize, f64)>>,
    /// The same in doubles, dense.
    pub(crate) rounded: Vec<f64>,
    /// The step h in s: the series of one step converges quickly.
    pub(crate) step: f64,
    /// A bound of ‖ D|W|D⁻¹·h ‖.
    pub(crate) reach: f64,
    /// The diagonal of D.
    pub(crate) scales: Vec<f64>,
    /// A bound of the error of W·h in the 2-norm.
    pub(crate) error: f64,
    pub(crate) guards: Vec<Guard<T>>,
    /// Of each switch, the force along its stretch, where there is one.
    pub(crate) forces: Vec<Option<Row<T>>>,
    /// For each switch that holds a relation: its index, the relation, and the force of unit rate of it.
    pub(crate) held: Vec<(usize, Vec<T>, Vec<T>)>,
    /// e^{Wh}, about.
    pub(crate) power: Vec<f64>,
}

/// Why phases make no system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unfit {
    /// What is held depends on each other, so that the forces are not unique.
    Dependent,
    /// Rates leave the range of doubles.
    OutOfRange,
}

impl<T: Real> Configuration<T> {
    /// From the system without switches, the dense `w` with its error. `constant` is the entry of ζ that stays, which stands
    /// for 1; a step is not longer than `longest`, nor ‖Wh‖ larger than `reach`.
    pub(crate) fn of(
        w: &[T],
        w_error: f64,
        places: &[Place<T>],
        phases: &[Phase],
        constant: T,
        [longest, reach]: [f64; 2],
    ) -> Result<Configuration<T>, Unfit> {
        let n = w.len().isqrt();
        let one = T::ONE / constant;
        let mut whole = BallMatrix::<T>::zeros(n, n);
        for i in 0..n {
            for j in 0..n {
                let entry = w[i * n + j];
                if !entry.is_zero() {
                    whole.set(i, j, entry, Magnitude::ZERO);
                }
            }
        }
        let mut error = w_error;
        // Forces along the stretches as functions of ζ.
        let mut forces: Vec<Option<Row<T>>> = places
            .iter()
            .zip(phases)
            .map(|(place, phase)| law(place, *phase, one))
            .collect();
        for (place, force) in places.iter().zip(&forces) {
            if let Some(force) = force {
                let (column, row) = (column(&place.push), self::row(&force.entries));
                whole = whole.plus(&column.times(&row));
                let norm = length_of(&place.push);
                error += norm * force.error + place.push_error * force.norm;
            }
        }
        // What holds: R W ζ + R B λ = 0.
        let held: Vec<usize> = (0..places.len()).filter(|k| phases[*k].holds()).collect();
        let mut gains = Vec::new();
        if !held.is_empty() {
            let relation = |k: usize| match phases[k] {
                Phase::Hold { .. } => &places[k].body,
                _ => &places[k].rate,
            };
            let count = held.len();
            let (mut relations, mut pushes) = (
                BallMatrix::<T>::zeros(count, n),
                BallMatrix::<T>::zeros(n, count),
            );
            for (at, k) in held.iter().enumerate() {
                for i in 0..n {
                    relations.set(at, i, relation(*k).entries[i], Magnitude::ZERO);
                    pushes.set(i, at, places[*k].push[i], Magnitude::ZERO);
                }
            }
            let answers = relations.times(&pushes);
            let gain = answers.solve(&relations).ok_or(Unfit::Dependent)?;
            let force = gain.times(&whole).negated();
            // The errors of the relations and pushes, to first order and half as much again.
            let size = |matrix: &BallMatrix<T>| {
                let entries = (0..matrix.rows() * matrix.columns()).map(|at| {
                    let (i, j) = (at / matrix.columns(), at % matrix.columns());
                    (matrix.middle(i, j).upper() + matrix.radius(i, j)).to_f64()
                });
                length(&entries.collect::<Vec<f64>>()) * SLACK
            };
            let off: f64 = held
                .iter()
                .map(|k| {
                    relation(*k).error / relation(*k).norm
                        + places[*k].push_error / length_of(&places[*k].push)
                })
                .sum();
            let blame = size(&gain) * size(&pushes);
            let inside = whole_size(&whole);
            error = (error * (1.0 + blame) + 1.5 * off * blame * (1.0 + blame) * inside) * SLACK;
            whole = whole.plus(&pushes.times(&force));
            for (at, k) in held.iter().enumerate() {
                let entries: Vec<T> = (0..n).map(|j| force.middle(at, j)).collect();
                let radii: Vec<f64> = (0..n).map(|j| force.radius(at, j).to_f64()).collect();
                let norm = length(
                    &(0..n)
                        .map(|j| gain.middle(at, j).to_f64())
                        .collect::<Vec<_>>(),
                );
                let own = length(&radii) + norm * error + 1.5 * off * norm * inside;
                forces[*k] = Some(Row::of(entries, own * SLACK));
                let gain = (0..n).map(|j| gain.middle(at, j)).collect();
                gains.push((*k, gain, places[*k].push.clone()));
            }
        }
        let radii = (0..n * n).map(|at| whole.radius(at / n, at % n).to_f64());
        error = (error + length(&radii.collect::<Vec<f64>>())) * SLACK;
        let sizes: Vec<f64> = (0..n * n)
            .map(|at| whole.middle(at / n, at % n).to_f64().abs())
            .collect();
        let scales = balance(n, &sizes, longest);
        let entry = |i: usize, j: usize| sizes[i * n + j] * scales[i] / scales[j];
        let sums = (0..n).map(|i| {
            let across: f64 = (0..n).map(|j| entry(i, j)).sum();
            let down: f64 = (0..n).map(|j| entry(j, i)).sum();
            [across, down]
        });
        let [across, down] = sums.fold([0.0f64; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
        let norm = across.sqrt() * down.sqrt() * SLACK;
        if !norm.is_finite() {
            return Err(Unfit::OutOfRange);
        }
        // A power of two, so that W·h is not rounded.
        let step = match norm > 0.0 {
            true => 2f64.powi((reach / norm).log2().floor() as i32).min(longest),
            false => longest,
        };
        let power_of_two = step.log2().floor() as i64;
        let step = 2f64.powi(power_of_two as i32);
        let rows = (0..n).map(|i| {
            let entries = (0..n).filter(|j| !whole.middle(i, *j).is_zero());
            entries
                .map(|j| (j, whole.middle(i, j).scale(power_of_two)))
                .collect()
        });
        let rows: Vec<Vec<(usize, T)>> = rows.collect();
        let mut rounded = vec![0.0; n * n];
        for (i, row) in rows.iter().enumerate() {
            for (j, entry) in row {
                rounded[i * n + j] = entry.to_f64();
            }
        }
        let size = |(j, entry): &(usize, T)| (*j, entry.to_f64().abs() * SLACK);
        let sizes = rows
            .iter()
            .map(|row| row.iter().map(size).collect())
            .collect();
        let guards = places
            .iter()
            .zip(phases)
            .enumerate()
            .flat_map(|(switch, (place, phase))| {
                let rows = guards(place, *phase, forces[switch].as_ref(), one);
                rows.into_iter().map(move |row| Guard { switch, row })
            });
        let guards = guards.collect();
        Ok(Configuration {
            power: exponential(n, &rounded, 1.0),
            rows,
            sizes,
            rounded,
            step,
            reach: norm * step,
            scales,
            error: error * step * SLACK,
            guards,
            forces,
            held: gains,
        })
    }

    /// A bound of the 2-norm of a row times D⁻¹.
    pub(crate) fn norm_of(&self, row: &Row<T>) -> f64 {
        let scaled = row.rounded.iter().zip(&self.scales);
        let scaled: Vec<f64> = scaled.map(|(entry, scale)| entry / scale).collect();
        length(&scaled) * SLACK + row.error
    }

    /// How far each entry of a state of these sizes, known to `errors`, may stray in `time` steps from what it is to first
    /// order.
    pub(crate) fn strays(&self, sizes: &[f64], errors: &ErrorSet, time: f64) -> Vec<f64> {
        let length = |sizes: &[f64]| {
            let scaled = sizes.iter().zip(&self.scales).map(|(a, b)| a * b);
            length(&scaled.collect::<Vec<f64>>())
        };
        let extents = errors.extents();
        let (first, twice) = (self.sized(&extents), self.sized(&self.sized(sizes)));
        let short = time * self.reach;
        let beyond = short * short * (short * length(sizes) + length(&extents));
        let each = first.iter().zip(&twice).zip(&self.scales);
        each.map(|((error, curve), scale)| {
            2.0 * (time * error + time * time * curve + beyond / scale)
        })
        .collect()
    }

    /// |W| h times sizes of the entries of ζ.
    pub(crate) fn sized(&self, sizes: &[f64]) -> Vec<f64> {
        let row = |row: &Vec<(usize, f64)>| row.iter().map(|(j, entry)| entry * sizes[*j]).sum();
        self.sizes.iter().map(row).collect()
    }

    /// The function of ζ that a function of ζ′ is.
    pub(crate) fn of_rate(&self, row: &Row<T>) -> Row<T> {
        let n = self.rows.len();
        let mut entries = vec![T::ZERO; n];
        let mut sizes = vec![0.0; n];
        for ((factor, row), own) in row.entries.iter().zip(&self.rows).zip(&self.sizes) {
            if factor.is_zero() {
                continue;
            }
            for ((j, entry), (_, size)) in row.iter().zip(own) {
                entries[*j] = entries[*j] + *factor * *entry;
                sizes[*j] += factor.to_f64().abs() * size;
            }
        }
        // The step is a power of two.
        let seconds = T::ONE / T::from(self.step);
        entries
            .iter_mut()
            .for_each(|entry| *entry = *entry * seconds);
        let all = self.sizes.iter().flatten().map(|(_, size)| *size);
        let norm = length(&all.collect::<Vec<f64>>());
        let rounding = unit::<T>() * (n + 2) as f64 * length(&sizes);
        let error = rounding + row.norm * self.error + row.error * norm;
        Row::of(entries, error / self.step * SLACK)
    }

    /// Adds W ζ h to a list of states, ζ being the last.
    pub(crate) fn apply_to(&self, states: &mut Vec<T>) {
        let start = states.len() - self.rows.len();
        for row in &self.rows {
            let mut sum = T::ZERO;
            for (j, entry) in row {
                let state = states[start + j];
                if !state.is_zero() {
                    sum = sum + *entry * state;
                }
            }
            states.push(sum);
        }
    }

    /// W ζ h.
    pub(crate) fn apply(&self, zeta: &[T]) -> Vec<T> {
        let entries = self.rows.iter().map(|row| {
            let parts = row.iter().filter(|(j, _)| !zeta[*j].is_zero());
            parts.fold(T::ZERO, |sum, (j, entry)| sum + *entry * zeta[*j])
        });
        entries.collect()
    }
}

/// Powers of two by which rows and columns of a matrix come to about the same size (Osborne, J. ACM 7, 1960).
fn balance(n: usize, sizes: &[f64], longest: f64) -> Vec<f64> {
    /// What is smaller beside the largest is rounding.
    const ROUNDING: f64 = 1e-15;
    /// No scale is larger, nor smaller than its inverse: what is left out of series is bounded in these scales.
    const MOST: f64 = 1_048_576.0;
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    let size = |at: usize| {
        if sizes[at] > ROUNDING * largest {
            sizes[at]
        } else {
            0.0
        }
    };
    /// Beside what goes to and fro, what only follows it is smaller than this part, so that steps are not shorter for it.
    const PART: f64 = 1.0 / 64.0;
    // What goes to and fro between two entries, which no scales change.
    let mutual = (0..n * n).map(|at| (size(at) * size(at % n * n + at / n)).sqrt());
    let follows = (PART * mutual.fold(0.0, f64::max)).max(1.0 / longest);
    let mut scales = vec![1.0f64; n];
    for _ in 0..20 {
        let mut done = true;
        for i in 0..n {
            let others = (0..n).filter(|j| *j != i);
            let across: f64 = others
                .clone()
                .map(|j| size(i * n + j) * scales[i] / scales[j])
                .sum();
            let down: f64 = others
                .map(|j| size(j * n + i) * scales[j] / scales[i])
                .sum();
            if across > 0.0 && down > 0.0 {
                let factor = 2f64.powi((down / across).log2().div_euclid(2.0) as i32);
                if factor != 1.0 {
                    scales[i] *= factor;
                    done = false;
                }
            } else if across > 0.0 {
                // Nothing depends on it: it is made small beside what it depends on.
                scales[i] *= 2f64.powi((follows / across).log2().floor() as i32);
            }
        }
        if done {
            break;
        }
    }
    for scale in &mut scales {
        *scale = scale.clamp(1.0 / MOST, MOST);
    }
    scales
}

fn whole_size<T: Real>(whole: &BallMatrix<T>) -> f64 {
    let n = whole.rows();
    let entries = (0..n * n).map(|at| whole.middle(at / n, at % n).to_f64());
    length(&entries.collect::<Vec<f64>>()) * SLACK
}

fn column<T: Real>(entries: &[T]) -> BallMatrix<T> {
    let mut column = BallMatrix::zeros(entries.len(), 1);
    for (i, entry) in entries.iter().enumerate() {
        column.set(i, 0, *entry, Magnitude::ZERO);
    }
    column
}

fn row<T: Real>(entries: &[T]) -> BallMatrix<T> {
    let mut row = BallMatrix::zeros(1, entries.len());
    for (j, entry) in entries.iter().enumerate() {
        row.set(0, j, *entry, Magnitude::ZERO);
    }
    row
}

pub(crate) fn length_of<T: Real>(entries: &[T]) -> f64 {
    let rounded: Vec<f64> = entries.iter().map(|entry| entry.to_f64()).collect();
    length(&rounded) * SLACK
}

/// The force along the stretch, where the phase gives it; `one` times the constant entry is 1.
fn law<T: Real>(place: &Place<T>, phase: Phase, one: T) -> Option<Row<T>> {
    let nothing = || Row::sum(&[(0.0, &place.rate)]);
    match (&place.switch, phase) {
        (Switch::Friction(friction), Phase::Slip(sign) | Phase::Idle(sign)) => {
            let size = match phase {
                Phase::Slip(_) => friction.force,
                _ => friction.static_force,
            };
            Some(nothing().plus_constant(T::from(-f64::from(sign) * size) * one))
        }
        (Switch::Stop(stop), Phase::Closed) => {
            let own = [
                (-stop.stiffness, &place.stretch),
                (-stop.damping, &place.rate),
            ];
            let gap = T::from(stop.stiffness) * T::from(stop.gap) * one;
            Some(Row::sum(&own).plus_constant(gap))
        }
        (Switch::ControlledDamper(damper), phase) => match place.setting(phase)? {
            Setting::Low => Some(Row::sum(&[(-damper.low, &place.rate)])),
            Setting::High => Some(Row::sum(&[(-damper.high, &place.rate)])),
            Setting::Sky => match damper.law {
                DamperLaw::ClippedSkyhook { sky } => Some(Row::sum(&[(-sky, &place.body)])),
                DamperLaw::OnOffSkyhook => None,
            },
            Setting::Hold => None,
        },
        _ => None,
    }
}

/// What stays ≥ 0 while a phase lasts.
fn guards<T: Real>(place: &Place<T>, phase: Phase, force: Option<&Row<T>>, one: T) -> Vec<Row<T>> {
    let signed = |sign: i8, row: &Row<T>| Row::sum(&[(f64::from(sign), row)]);
    match (&place.switch, phase) {
        (Switch::Friction(friction), Phase::Stick) => {
            let force = force.expect("what holds has a force");
            let most = T::from(friction.static_force) * one;
            vec![
                signed(-1, force).plus_constant(most),
                signed(1, force).plus_constant(most),
            ]
        }
        (Switch::Friction(_), Phase::Slip(sign)) => vec![signed(sign, &place.rate)],
        // What holds its ends may not hold what its ends are to each other: supports move.
        (Switch::Friction(_), Phase::Idle(_)) => {
            vec![signed(1, &place.rate), signed(-1, &place.rate)]
        }
        (Switch::Stop(Stop { gap, .. }), phase) => {
            let beyond = place.stretch.plus_constant(-(T::from(*gap) * one));
            let sign = if phase == Phase::Closed { 1 } else { -1 };
            vec![signed(sign, &beyond)]
        }
        (Switch::Impact(impact), Phase::Free) => {
            let beyond = place.stretch.plus_constant(-(T::from(impact.gap) * one));
            vec![signed(-1, &beyond)]
        }
        (Switch::Impact(_), Phase::Contact) => {
            vec![signed(-1, force.expect("what holds has a force"))]
        }
        (Switch::ControlledDamper(_), Phase::OnOff { body, rate }) => {
            vec![signed(body, &place.body), signed(rate, &place.rate)]
        }
        (Switch::ControlledDamper(damper), Phase::Hold { rate }) => {
            let force = force.expect("what holds has a force");
            let sign = f64::from(rate);
            vec![
                Row::sum(&[(-sign, force), (-sign * damper.low, &place.rate)]),
                Row::sum(&[(sign, force), (sign * damper.high, &place.rate)]),
                signed(rate, &place.rate),
            ]
        }
        (Switch::ControlledDamper(damper), Phase::Clipped { low, high, rate }) => {
            let [to_low, to_high] = clipped(place, damper);
            vec![
                signed(low, &to_low),
                signed(high, &to_high),
                signed(rate, &place.rate),
            ]
        }
        _ => Vec::new(),
    }
}

/// sky·v_b − low·v and sky·v_b − high·v.
pub(crate) fn clipped<T: Real>(place: &Place<T>, damper: &ControlledDamper) -> [Row<T>; 2] {
    let sky = match damper.law {
        DamperLaw::ClippedSkyhook { sky } => sky,
        DamperLaw::OnOffSkyhook => 0.0,
    };
    [damper.low, damper.high]
        .map(|damping| Row::sum(&[(sky, &place.body), (-damping, &place.rate)]))
}

/// e^{Aθ} in doubles, for an A whose norm is about 1.
pub(crate) fn exponential(n: usize, a: &[f64], theta: f64) -> Vec<f64> {
    let mut sum = vec![0.0; n * n];
    let mut term = vec![0.0; n * n];
    for i in 0..n {
        sum[i * n + i] = 1.0;
        term[i * n + i] = 1.0;
    }
    for k in 1..40 {
        let mut next = vec![0.0; n * n];
        let mut size = 0.0f64;
        for i in 0..n {
            for l in 0..n {
                let factor = a[i * n + l] * theta / f64::from(k);
                if factor != 0.0 {
                    for j in 0..n {
                        next[i * n + j] += factor * term[l * n + j];
                    }
                }
            }
        }
        for (sum, next) in sum.iter_mut().zip(&next) {
            *sum += next;
            size = size.max(next.abs());
        }
        term = next;
        if size < 1e-18 {
            break;
        }
    }
    sum
}
