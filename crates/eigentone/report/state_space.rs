//! State-space matrices as tables, JSON and Matrix Market files.

use std::io::{self, Write};

use eigentone_modes::Bounds;
use eigentone_response::{BoundedMatrix, Hold, StateMatrices, StateSpace};
use serde::Serialize;

use super::number;
use super::table::{Align, Table};

/// Prints a state-space form.
#[derive(Clone, Copy, Debug)]
pub struct StateSpaceReport<'a> {
    /// The continuous form, and the names.
    pub plant: &'a StateSpace<'a>,
    /// The discrete form that is printed in its place: step in s, hold, matrices.
    pub held: Option<(f64, Hold, &'a StateMatrices)>,
}

/// As many columns are printed for people.
const COLUMNS: usize = 12;

impl<'a> StateSpaceReport<'a> {
    /// A, B, C and D by their names.
    pub fn matrices(&self) -> [(&'static str, &'a BoundedMatrix); 4] {
        let matrices = match self.held {
            Some((.., held)) => held,
            None => self.plant.matrices(),
        };
        let StateMatrices { a, b, c, d } = matrices;
        [("A", a), ("B", b), ("C", c), ("D", d)]
    }

    /// The form in words, and each matrix under the names of its columns.
    pub fn text(&self) -> String {
        let mut text = match self.held {
            None => "z′ = A z + B u, y = C z + D u\n".to_owned(),
            Some((step, hold, _)) => {
                let course = match hold {
                    Hold::Zero => "inputs that keep each sample",
                    Hold::First => {
                        "inputs that run straight from sample to sample; the state is z less what follows u at once"
                    }
                };
                let step = number::short(step);
                format!(
                    "z(k + 1) = A z(k) + B u(k), y(k) = C z(k) + D u(k), every {step} s, for {course}\n"
                )
            }
        };
        let (states, inputs) = (self.plant.states(), self.plant.inputs());
        let outputs = self.plant.outputs();
        let headers = [states, inputs, states, inputs];
        let sides = [states, states, outputs, outputs];
        let (mut largest, mut others, mut widest) = (0.0f64, 0, 0.0f64);
        for (((name, matrix), header), side) in self.matrices().into_iter().zip(headers).zip(sides)
        {
            let values = &matrix.values;
            text += &format!("\n{name}: {} × {}\n", values.nrows(), values.ncols());
            for (i, j) in (0..values.nrows()).flat_map(|i| (0..values.ncols()).map(move |j| (i, j)))
            {
                let (size, bound) = (values[(i, j)].abs(), matrix.bound[(i, j)]);
                if bound > size * f64::EPSILON {
                    others += 1;
                    widest = widest.max(bound);
                } else if bound > 0.0 {
                    largest = largest.max(bound / size);
                }
            }
            if values.ncols() > COLUMNS {
                text += "too wide for the screen: --json prints it, --out writes it\n";
                continue;
            }
            let mut table = Table::default().column("", Align::Left, side);
            for (j, header) in header.iter().enumerate() {
                let column = (0..values.nrows()).map(|i| number::significant(values[(i, j)]));
                table = table.column(header, Align::Point, column);
            }
            text += &table.text();
        }
        let largest = number::bound(largest);
        text += &format!("\nEvery entry is proven within a relative error of {largest}");
        if others > 0 {
            let entries = number::count(others, "entry that is", "entries that are");
            let widest = number::bound(widest);
            text += &format!(
                ", but for {entries} proven within an absolute error of {widest}; --json has the bounds of all"
            );
        }
        text + ".\n"
    }

    /// One JSON object: the matrices row by row, the names, the bounds of all entries, and step and hold of a discrete form.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn json(&self, mut out: impl Write) -> io::Result<()> {
        let [a, b, c, d] = self.matrices().map(|(_, matrix)| Rows::of(matrix));
        let json = Json {
            bounds: super::worth(Bounds::Proven),
            hold: self.held.map(|(_, hold, _)| match hold {
                Hold::Zero => "zero",
                Hold::First => "first",
            }),
            step: self.held.map(|(step, ..)| step),
            a: a.values,
            b: b.values,
            c: c.values,
            d: d.values,
            states: self.plant.states(),
            inputs: self.plant.inputs(),
            outputs: self.plant.outputs(),
            bound: BoundJson {
                a: a.bound,
                b: b.bound,
                c: c.bound,
                d: d.bound,
            },
        };
        serde_json::to_writer(&mut out, &json)?;
        writeln!(out)
    }

    /// A matrix in Matrix Market format, column by column, with all digits.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn matrix_market(matrix: &BoundedMatrix, mut out: impl Write) -> io::Result<()> {
        let values = &matrix.values;
        writeln!(out, "%%MatrixMarket matrix array real general")?;
        writeln!(out, "{} {}", values.nrows(), values.ncols())?;
        for j in 0..values.ncols() {
            for i in 0..values.nrows() {
                writeln!(out, "{:?}", values[(i, j)])?;
            }
        }
        Ok(())
    }
}

struct Rows {
    values: Vec<Vec<f64>>,
    bound: Vec<Vec<f64>>,
}

impl Rows {
    fn of(matrix: &BoundedMatrix) -> Rows {
        let rows = |of: &faer::Mat<f64>| {
            let row = |i| (0..of.ncols()).map(|j| of[(i, j)]).collect();
            (0..of.nrows()).map(row).collect()
        };
        Rows {
            values: rows(&matrix.values),
            bound: rows(&matrix.bound),
        }
    }
}

#[derive(Serialize)]
struct Json<'a> {
    bounds: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    hold: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    step: Option<f64>,
    #[serde(rename = "A")]
    a: Vec<Vec<f64>>,
    #[serde(rename = "B")]
    b: Vec<Vec<f64>>,
    #[serde(rename = "C")]
    c: Vec<Vec<f64>>,
    #[serde(rename = "D")]
    d: Vec<Vec<f64>>,
    states: &'a [String],
    inputs: &'a [String],
    outputs: &'a [String],
    bound: BoundJson,
}

#[derive(Serialize)]
struct BoundJson {
    #[serde(rename = "A")]
    a: Vec<Vec<f64>>,
    #[serde(rename = "B")]
    b: Vec<Vec<f64>>,
    #[serde(rename = "C")]
    c: Vec<Vec<f64>>,
    #[serde(rename = "D")]
    d: Vec<Vec<f64>>,
}
