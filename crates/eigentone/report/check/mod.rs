//! Every method against a reference: errors and run times as tables, as JSON and as a
//! work-precision diagram.

mod diagram;
mod json;
mod tables;

use std::io;

use eigentone_check::{
    ExponentialComparison, Measurement, ModeComparison, Outcome, WorkPrecision, WorkPrecisionRow,
};

use eigentone_response::ResponseError;

use super::plot::Plot;
use super::table::{Table, markdown_text, visible};

/// How every solver and method did on one scene.
pub struct CheckReport<'a> {
    /// What the scene is called.
    pub title: &'a str,
    /// The mode solvers.
    pub modes: &'a ModeComparison,
    /// The matrix exponentials, if the scene asks for a response and is not too large for proofs.
    pub exponentials: Option<&'a ExponentialComparison>,
    /// The response methods, if the scene asks for a response, or why there is none to compare.
    pub response: Option<Result<&'a WorkPrecision, &'a ResponseError>>,
}

const NO_RESPONSE: &str = "Response: left out, the scene has no `time`";

/// A heading, its table, and what is to be said below it.
struct Section {
    heading: String,
    table: Table,
    remarks: Vec<String>,
}

impl CheckReport<'_> {
    /// Tables in aligned columns: the mode solvers, the matrix exponentials, and the response methods
    /// with their settings; below each, what the plan picks and whether anything beats it.
    pub fn text(&self) -> String {
        let mut text = format!("{}\n", visible(self.title));
        for section in self.sections() {
            text += &format!("\n{}\n", section.heading);
            for line in section.table.text().lines().chain(lines(&section.remarks)) {
                text += &format!("  {line}\n");
            }
        }
        if let Some(reason) = self.without_response() {
            text += &format!("\n{reason}\n");
        }
        text
    }

    /// The same in Markdown.
    pub fn markdown(&self) -> String {
        let mut text = format!("# {}\n", markdown_text(self.title));
        for section in self.sections() {
            text += &format!("\n## {}\n\n", markdown_text(&section.heading));
            text += &section.table.markdown();
            for remark in lines(&section.remarks) {
                text += &format!("\n{}\n", markdown_text(remark));
            }
        }
        if let Some(reason) = self.without_response() {
            text += &format!("\n{}\n", markdown_text(&reason));
        }
        text
    }

    /// One JSON object with all digits: run times in s; errors are relative, and null for the
    /// reference and where they are infinite. Where the response fails, `response` is null and `response_error`
    /// says why.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn json(&self, out: impl io::Write) -> io::Result<()> {
        json::write(self, out)
    }

    /// Run time against the error of the displacements, both on logarithmic axes: a line for each
    /// method, a point for each setting, and a ring about what the plan picks. `None` without a response.
    /// The reference, and what agrees with it in every digit, has no place on such an axis.
    pub fn plot(&self) -> Option<Plot<'_>> {
        Some(diagram::of(self.title, self.response?.ok()?))
    }

    /// Why nothing is said of a response.
    fn without_response(&self) -> Option<String> {
        match self.response {
            None => Some(NO_RESPONSE.to_owned()),
            Some(Err(error)) => Some(format!("Response: none, {error}")),
            Some(Ok(_)) => None,
        }
    }

    fn sections(&self) -> Vec<Section> {
        let mut sections = vec![tables::modes(self.modes)];
        sections.extend(self.exponentials.map(tables::exponentials));
        sections.extend(self.response.and_then(Result::ok).map(tables::response));
        sections
    }
}

fn lines(remarks: &[String]) -> impl Iterator<Item = &str> {
    remarks.iter().map(String::as_str)
}

fn measured(row: &WorkPrecisionRow) -> Option<&Measurement> {
    match &row.outcome {
        Outcome::Measured(measurement) => Some(measurement),
        _ => None,
    }
}

/// Why a method has no answer: what an integrator makes of a motion may grow where the motion does not.
fn failure(row: &WorkPrecisionRow, error: &ResponseError) -> String {
    match error {
        ResponseError::Overflow { .. } if row.knob.is_some() => {
            "its values exceed the largest double: unless those of the motion do so too, it is unstable with steps as long as these".to_owned()
        }
        error => error.to_string(),
    }
}

fn setting(row: &WorkPrecisionRow) -> String {
    row.knob.map(|knob| knob.to_string()).unwrap_or_default()
}

/// A method with its setting.
fn named(row: &WorkPrecisionRow) -> String {
    match row.knob {
        Some(knob) => format!("{} at {knob}", row.method),
        None => row.method.to_owned(),
    }
}
