//! The table of modes and that of their shapes.

use std::cmp::Ordering;

use eigentone_check::{Ball, ReferenceEigenvalue, ReferenceError, Shape, ShapeComponent};
use eigentone_modes::{Motion, System};

use super::error::TableError;
use super::settle::{Attempt, MOST_WORK, settled};
use super::sheet::{Cell, Column, Sheet};
use super::value::Value;

/// Every distinct mode of a system to [`DIGITS`](super::DIGITS) digits that are all right.
#[derive(Clone, Debug)]
pub struct ModeTable {
    names: Vec<String>,
    rows: Vec<ModeRow>,
    infinite: usize,
}

/// A conjugate pair of eigenvalues or a real one.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ModeRow {
    /// How it moves.
    pub motion: Motion,
    /// How often λ is a root.
    pub multiplicity: usize,
    /// Re λ in 1/s.
    pub real_part: Value,
    /// Im λ ≥ 0 in rad/s.
    pub imaginary_part: Value,
    /// ω_n = |λ| in rad/s.
    pub natural_frequency: Value,
    /// ω_n/2π in Hz.
    pub hertz: Value,
    /// ω_d = Im λ in rad/s.
    pub damped_frequency: Value,
    /// ζ = −Re λ/|λ|; `None` for a real root.
    pub damping_ratio: Option<Value>,
    /// −Re λ in 1/s.
    pub decay_rate: Value,
    /// Real and imaginary part of each component, relative to the largest, the first of those whose sizes
    /// agree to 30 digits; `None` where several shapes belong to λ.
    pub shape: Option<Vec<(Value, Value)>>,
}

impl ModeTable {
    /// The modes of `system`, from the reference with as many digits as decide each rounding.
    ///
    /// # Errors
    /// [`TableError`] where the reference refuses, or a digit stays open.
    pub fn of(system: &System) -> Result<ModeTable, TableError> {
        ModeTable::within(MOST_WORK, system)
    }

    /// The same, where no step of the reference takes more than so many multiplications of whole numbers, of which a core does
    /// some ten million in a second: 1e9 for [`of`](Self::of).
    ///
    /// # Errors
    /// As there.
    pub fn within(multiplications: f64, system: &System) -> Result<ModeTable, TableError> {
        settled(multiplications, |attempt| {
            let modes = attempt.reference.modes(system)?;
            let shapes = attempt.reference.shapes(system, &modes)?;
            let mut found: Vec<(&ReferenceEigenvalue, Shape)> =
                modes.eigenvalues().iter().zip(shapes).collect();
            found.retain(|(root, _)| root.im.is_exactly_zero() || root.im.nearest() > 0.0);
            found.sort_by(|(a, _), (b, _)| order(a, b));
            let rows = found.into_iter().enumerate();
            let rows = rows.map(|(k, (root, shape))| row(attempt, k + 1, root, shape));
            Ok::<_, ReferenceError>(ModeTable {
                names: system.names().to_vec(),
                rows: rows.collect(),
                infinite: modes.infinite(),
            })
        })
    }

    /// One entry for each distinct conjugate pair or real root, by rising |λ|, then Re λ.
    pub fn rows(&self) -> &[ModeRow] {
        &self.rows
    }

    /// How many of the 2n roots are infinite.
    pub fn infinite(&self) -> usize {
        self.infinite
    }

    /// The modes as a Markdown table.
    pub fn markdown(&self) -> String {
        self.sheet().markdown()
    }

    /// The modes as CSV, units in the header.
    pub fn csv(&self) -> String {
        self.sheet().csv()
    }

    /// The modes as a JSON array of objects.
    pub fn json(&self) -> String {
        self.sheet().json("")
    }

    /// The modes as a LaTeX `tabular`.
    pub fn latex(&self) -> String {
        self.sheet().latex()
    }

    pub(super) fn sheet(&self) -> Sheet {
        let columns = vec![
            Column::of("mode", "#", "\\#", ""),
            Column::of("motion", "motion", "motion", ""),
            Column::of("multiplicity", "multiplicity", "multiplicity", ""),
            Column::of("re", "Re λ", "$\\mathrm{Re}\\,\\lambda$", "1/s"),
            Column::of("im", "Im λ", "$\\mathrm{Im}\\,\\lambda$", "rad/s"),
            Column::of("natural_frequency", "ω_n", "$\\omega_n$", "rad/s"),
            Column::of("hertz", "f_n", "$f_n$", "Hz"),
            Column::of("damped_frequency", "ω_d", "$\\omega_d$", "rad/s"),
            Column::of("damping_ratio", "ζ", "$\\zeta$", ""),
            Column::of("decay_rate", "decay rate", "decay rate", "1/s"),
        ];
        let row = |(k, row): (usize, &ModeRow)| {
            vec![
                Cell::Whole(k as u64 + 1),
                Cell::Text(row.motion.to_string()),
                Cell::Whole(row.multiplicity as u64),
                Cell::Value(row.real_part.clone()),
                Cell::Value(row.imaginary_part.clone()),
                Cell::Value(row.natural_frequency.clone()),
                Cell::Value(row.hertz.clone()),
                Cell::Value(row.damped_frequency.clone()),
                row.damping_ratio.clone().map_or(Cell::None, Cell::Value),
                Cell::Value(row.decay_rate.clone()),
            ]
        };
        Sheet {
            columns,
            rows: self.rows.iter().enumerate().map(row).collect(),
        }
    }

    /// The shapes that are determined: a row for each component.
    pub(super) fn shapes(&self) -> Sheet {
        let columns = vec![
            Column::of("mode", "mode", "mode", ""),
            Column::of("coordinate", "coordinate", "coordinate", ""),
            Column::of("re", "Re x", "$\\mathrm{Re}\\,x$", ""),
            Column::of("im", "Im x", "$\\mathrm{Im}\\,x$", ""),
        ];
        let mut rows = Vec::new();
        for (k, row) in self.rows.iter().enumerate() {
            let components = row.shape.iter().flatten();
            for (name, (re, im)) in self.names.iter().zip(components) {
                rows.push(vec![
                    Cell::Whole(k as u64 + 1),
                    Cell::Text(name.clone()),
                    Cell::Value(re.clone()),
                    Cell::Value(im.clone()),
                ]);
            }
        }
        Sheet { columns, rows }
    }
}

fn row(attempt: &mut Attempt, number: usize, root: &ReferenceEigenvalue, shape: Shape) -> ModeRow {
    let mut settle = |ball: &Ball, quantity: &str| {
        attempt.settle(ball, || format!("{quantity} of mode {number}"))
    };
    let real_part = settle(&root.re, "Re λ");
    let imaginary_part = settle(&root.im, "Im λ");
    let natural_frequency = settle(&root.natural_frequency(), "ω_n");
    let hertz = settle(&root.hertz(), "f_n");
    let damped_frequency = settle(&root.damped_frequency(), "ω_d");
    let ratio = root.damping_ratio();
    let damping_ratio = ratio.map(|ratio| settle(&ratio, "ζ"));
    let decay_rate = settle(&root.decay_rate(), "the decay rate");
    let shape = match shape {
        Shape::Determined(components) => {
            let component = |(i, x): (usize, &ShapeComponent)| {
                if x.im.is_exactly_zero() && x.re.minus(1.0) == 0.0 && x.re.radius() == 0.0 {
                    return (Value::ONE, settle(&x.im, ""));
                }
                let mut part =
                    |ball: &Ball| settle(ball, &format!("component {} of the shape", i + 1));
                (part(&x.re), part(&x.im))
            };
            Some(components.iter().enumerate().map(component).collect())
        }
        Shape::Several => None,
        _ => {
            attempt.leave_open();
            None
        }
    };
    ModeRow {
        motion: motion(&real_part, &imaginary_part),
        multiplicity: root.multiplicity,
        real_part,
        imaginary_part,
        natural_frequency,
        hertz,
        damped_frequency,
        damping_ratio,
        decay_rate,
        shape,
    }
}

fn motion(re: &Value, im: &Value) -> Motion {
    match (re.is_zero(), im.is_zero()) {
        (true, true) => Motion::Rigid,
        (true, false) => Motion::Oscillating,
        _ if !re.is_negative() => Motion::Growing,
        (false, true) => Motion::Decaying,
        (false, false) => Motion::Oscillating,
    }
}

/// By |λ|, then Re λ, in doubles that whole numbers alone have made.
fn order(a: &ReferenceEigenvalue, b: &ReferenceEigenvalue) -> Ordering {
    let size = |root: &ReferenceEigenvalue| root.natural_frequency().nearest();
    size(a)
        .total_cmp(&size(b))
        .then(a.re.nearest().total_cmp(&b.re.nearest()))
        .then(b.im.nearest().total_cmp(&a.im.nearest()))
}
