//! What is read off the state at the instants asked for.

use eigentone_digits::Real;
use eigentone_modes::{ElementKind, Form};
use eigentone_response::{Driven, Problem, Quantity, Sum, Trajectory};
use faer::Mat;

use crate::configuration::Configuration;
use crate::error_set::UNKNOWN;
use crate::rows::{Row, SLACK};

/// A combination of motions by forms: which derivative, which form, and what it is multiplied by.
pub(crate) type Parts = Vec<(Quantity, usize, f64)>;

/// The combinations that a problem asks for, of forms that are added to `forms`.
pub(crate) fn combinations(problem: &Problem<'_>, forms: &mut Vec<Form>) -> Vec<Parts> {
    let system = problem.system();
    let mut place = |form: Form| {
        forms.push(form);
        forms.len() - 1
    };
    let parts = |combination: &eigentone_response::Combination| match &combination.of {
        Sum::Motions(motions) => {
            let each = motions.iter().map(|(quantity, name, factor)| {
                let form = system.form(name).expect("checked with the problem");
                (*quantity, place(form), *factor)
            });
            each.collect()
        }
        Sum::Pull(name) => {
            let (kind, index) = system.element_of(name).expect("checked with the problem");
            let element = &system.elements(kind)[index];
            let form = place(element.stretch.clone());
            vec![(answered(kind), form, element.coefficient)]
        }
    };
    let mut parts: Vec<Parts> = problem.combinations().iter().map(parts).collect();
    if problem.wants_forces() {
        for kind in [ElementKind::Spring, ElementKind::Damper] {
            for element in system.elements(kind) {
                let form = place(element.stretch.clone());
                parts.push(vec![(answered(kind), form, element.coefficient)]);
            }
        }
    }
    parts
}

/// What an element of a kind answers to.
fn answered(kind: ElementKind) -> Quantity {
    match kind {
        ElementKind::Damper => Quantity::Velocity,
        _ => Quantity::Displacement,
    }
}

/// A value of the motion: a function of ζ, and one of ζ′ beside it.
#[derive(Clone)]
pub(crate) struct Value<T> {
    of_state: Option<Row<T>>,
    of_rate: Option<Row<T>>,
}

impl<T: Real> Value<T> {
    /// The function of ζ that it is while a configuration lasts.
    pub(crate) fn in_configuration(&self, configuration: &Configuration<T>) -> Row<T> {
        let of_rate = self.of_rate.as_ref().map(|row| configuration.of_rate(row));
        match (&self.of_state, of_rate) {
            (Some(row), None) => row.clone(),
            (None, Some(row)) => row,
            (Some(one), Some(other)) => Row::sum(&[(1.0, one), (1.0, &other)]),
            (None, None) => Row::of(vec![T::ZERO; configuration.rows.len()], 0.0),
        }
    }
}

/// All that is recorded, and what has been.
pub(crate) struct Outputs<T> {
    coordinates: Vec<[Row<T>; 2]>,
    combined: Vec<Value<T>>,
    /// Displacement, velocity, acceleration: by instant and coordinate.
    values: [Vec<Vec<f64>>; 3],
    bounds: [Vec<f64>; 3],
    combinations: Vec<(Vec<f64>, Vec<f64>)>,
    /// Of each switch, where forces are asked for.
    forces: Vec<(Vec<f64>, Vec<f64>)>,
    accelerates: bool,
    /// Of displacements and of velocities.
    largest: [f64; 2],
    /// The largest error of any that misses the tolerance.
    missed: [f64; 2],
    tolerance: f64,
    /// In s.
    end: f64,
}

/// The state at an instant, and what is not known of it.
pub(crate) struct Moment<'m, T> {
    pub(crate) zeta: &'m [T],
    /// ζ′.
    pub(crate) rate: &'m [T],
    /// A bound of |row·e|.
    pub(crate) along: &'m dyn Fn(&[f64]) -> f64,
    /// Bounds of the errors of the entries of ζ′, and of its length.
    pub(crate) rate_errors: Vec<f64>,
    pub(crate) rate_size: f64,
    pub(crate) size: f64,
    /// The forces of the switches.
    pub(crate) forces: &'m [Option<Row<T>>],
}

impl<T: Real> Outputs<T> {
    pub(crate) fn of(
        problem: &Problem<'_>,
        driven: &Driven<'_, '_, T>,
        parts: &[Parts],
        switches: usize,
        tolerance: f64,
    ) -> Outputs<T> {
        let row = |known| Row::with_constant(known, T::ZERO);
        let combined = parts.iter().map(|parts| {
            let rows: Vec<(Quantity, f64, Row<T>)> = parts
                .iter()
                .map(|(quantity, form, factor)| {
                    let [stretch, rate] = driven.form(*form);
                    let own = match quantity {
                        Quantity::Displacement => row(stretch),
                        _ => row(rate),
                    };
                    (*quantity, *factor, own)
                })
                .collect();
            let sum = |accelerates: bool| {
                let own = rows
                    .iter()
                    .filter(|(quantity, ..)| (*quantity == Quantity::Acceleration) == accelerates);
                let own: Vec<(f64, &Row<T>)> = own.map(|(_, factor, row)| (*factor, row)).collect();
                (!own.is_empty()).then(|| Row::sum(&own))
            };
            Value {
                of_state: sum(false),
                of_rate: sum(true),
            }
        });
        Outputs {
            coordinates: (0..problem.system().len())
                .map(|index| driven.coordinate(index).map(row))
                .collect(),
            combined: combined.collect(),
            values: [Vec::new(), Vec::new(), Vec::new()],
            bounds: [Vec::new(), Vec::new(), Vec::new()],
            combinations: vec![(Vec::new(), Vec::new()); parts.len()],
            forces: match problem.wants_forces() {
                true => vec![(Vec::new(), Vec::new()); switches],
                false => Vec::new(),
            },
            accelerates: problem.wants_acceleration(),
            largest: [0.0; 2],
            missed: [0.0; 2],
            tolerance,
            end: problem.grid().time(problem.grid().last()),
        }
    }

    /// Whether ζ′ is needed.
    pub(crate) fn need_rate(&self) -> bool {
        self.accelerates || self.combined.iter().any(|value| value.of_rate.is_some())
    }

    /// Displacements, velocities and accelerations of all coordinates, then what is combined of them.
    pub(crate) fn values(&self) -> Vec<Value<T>> {
        let motions = (0..3).flat_map(|kind| {
            self.coordinates.iter().map(move |rows| match kind {
                2 => Value {
                    of_state: None,
                    of_rate: Some(rows[1].clone()),
                },
                kind => Value {
                    of_state: Some(rows[kind].clone()),
                    of_rate: None,
                },
            })
        });
        motions.chain(self.combined.iter().cloned()).collect()
    }

    pub(crate) fn record(&mut self, moment: &Moment<'_, T>) {
        for kind in 0..3 {
            if kind == 2 && !self.accelerates {
                continue;
            }
            let mut column = Vec::with_capacity(self.coordinates.len());
            let (mut top, mut worst, mut bound) = (0.0f64, 0.0f64, 0.0f64);
            for rows in &self.coordinates {
                let (exact, error) = match kind {
                    2 => of_rate(&rows[1], moment),
                    _ => of_state(&rows[kind], moment),
                };
                let (value, off) = rounded(exact, error, self.tolerance.is_finite());
                top = top.max(value.abs());
                worst = worst.max(error);
                bound = bound.max(off);
                column.push(value);
            }
            self.values[kind].push(column);
            self.bounds[kind].push(bound);
            if kind < 2 {
                self.largest[kind] = self.largest[kind].max(top);
                if worst > self.tolerance * top {
                    self.missed[kind] = self.missed[kind].max(worst);
                }
            }
        }
        for (value, (values, bounds)) in self.combined.iter().zip(&mut self.combinations) {
            let (mut sum, mut error) = (T::ZERO, 0.0);
            for (row, of) in [
                (
                    &value.of_state,
                    of_state as fn(&Row<T>, &Moment<'_, T>) -> (T, f64),
                ),
                (&value.of_rate, of_rate),
            ] {
                if let Some(row) = row {
                    let (part, off) = of(row, moment);
                    sum = sum + part;
                    error += off;
                }
            }
            let (value, off) = rounded(sum, error * SLACK, self.tolerance.is_finite());
            values.push(value);
            bounds.push(off);
        }
        for (force, (values, bounds)) in moment.forces.iter().zip(&mut self.forces) {
            let known = force.as_ref().map(|row| of_state(row, moment));
            let (exact, error) = known.unwrap_or((T::ZERO, 0.0));
            let (value, off) = rounded(exact, error, self.tolerance.is_finite());
            values.push(value);
            bounds.push(off);
        }
    }

    /// Whether every instant is as good as asked for, or lost only beside the largest motion of all.
    pub(crate) fn is_good(&self) -> bool {
        const HIDDEN: f64 = 1e-18;
        let [x, v] = self.largest;
        let hidden = [x, v.max(x / self.end)].map(|largest| HIDDEN * largest);
        (0..2).all(|kind| self.missed[kind] <= hidden[kind])
    }

    /// The trajectory of what was recorded, for instants of these indices; `picked` says which record each of them is.
    pub(crate) fn trajectory(
        self,
        problem: &Problem<'_>,
        steps: Vec<u64>,
        picked: &[usize],
    ) -> (Trajectory, Vec<SwitchForce>) {
        let grid = problem.grid();
        let times = steps.iter().map(|step| grid.time(*step)).collect();
        let n = problem.system().len();
        let matrix =
            |values: &Vec<Vec<f64>>| Mat::from_fn(n, picked.len(), |i, k| values[picked[k]][i]);
        let bounds =
            |bounds: &Vec<f64>| picked.iter().map(|k| known(bounds[*k])).collect::<Vec<_>>();
        let trajectory = Trajectory::new(
            "exact between events",
            steps,
            times,
            matrix(&self.values[0]),
            matrix(&self.values[1]),
        )
        .with_names(problem.system().coordinate_names())
        .with_bounds(bounds(&self.bounds[0]), bounds(&self.bounds[1]));
        let trajectory = match self.accelerates {
            true => trajectory
                .with_acceleration(matrix(&self.values[2]))
                .with_acceleration_bound(bounds(&self.bounds[2])),
            false => trajectory,
        };
        let taken = |(values, all): (Vec<f64>, Vec<f64>)| {
            let values: Vec<f64> = picked.iter().map(|k| values[*k]).collect();
            (values, bounds(&all))
        };
        let mut outputs: Vec<_> = self.combinations.into_iter().map(taken).collect();
        let forces = outputs.split_off(problem.combinations().len());
        let names = problem.combinations().iter();
        let outputs = names.zip(outputs);
        let outputs = outputs.map(|(one, (values, bounds))| (one.name.clone(), values, bounds));
        let trajectory = trajectory.with_outputs(outputs);
        let trajectory = match problem.wants_forces() {
            true => {
                let springs = problem.system().elements(ElementKind::Spring).len();
                trajectory.with_forces(springs, forces)
            }
            false => trajectory,
        };
        (trajectory, self.forces.into_iter().map(taken).collect())
    }
}

/// The values of a force at the instants, and their bounds.
pub(crate) type SwitchForce = (Vec<f64>, Vec<Option<f64>>);

fn of_state<T: Real>(row: &Row<T>, moment: &Moment<'_, T>) -> (T, f64) {
    let error = (moment.along)(&row.rounded) + row.own_error(moment.size);
    (row.at(moment.zeta), error * SLACK)
}

fn of_rate<T: Real>(row: &Row<T>, moment: &Moment<'_, T>) -> (T, f64) {
    let errors = row.rounded.iter().zip(&moment.rate_errors);
    let along: f64 = errors.map(|(entry, error)| entry.abs() * error).sum();
    let error = along + row.own_error(moment.rate_size);
    (row.at(moment.rate), error * SLACK)
}

/// A bound, unless it says that nothing is known.
fn known(bound: f64) -> Option<f64> {
    (bound < 1e-10 * UNKNOWN).then_some(bound)
}

/// The nearest double, or 0 where the error hides it, and how far it may be off.
fn rounded<T: Real>(exact: T, error: f64, proven: bool) -> (f64, f64) {
    let value = exact.to_f64();
    if proven && value.abs() <= error {
        return (0.0, (error + value.abs()) * SLACK);
    }
    (
        value,
        (error + (exact - T::from(value)).to_f64().abs()) * SLACK,
    )
}
