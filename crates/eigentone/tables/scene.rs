//! All tables of one scene, as documents.

use super::DIGITS;
use super::error::TableError;
use super::modes::ModeTable;
use super::response::ResponseTable;
use super::settle::MOST_WORK;
use super::sheet::{json_text, latex_text};
use crate::report::table::markdown_text;
use crate::scene::Scene;

/// What a document says of its numbers.
const ABOUT: &str = "Every number is rounded once, to nearest, to 15 significant digits; all of them are right. \
A 0 without digits is exact.";
const SHAPES: &str =
    "The largest component of a shape is 1, the first one where sizes agree to 30 digits.";
const TIMES: &str = "t is the step's index k times the time step, exactly.";
const OPEN: &str = "A number with < before it cannot be distinguished from 0, and is no larger.";

/// The tables of a scene: modes, shapes, and the motion if it asks for one and it can be computed.
#[derive(Clone, Debug)]
pub struct SceneTables {
    title: String,
    modes: ModeTable,
    response: Option<Result<ResponseTable, TableError>>,
}

/// How many parts the time of a scene is divided into where nobody says which instants are wanted.
const PARTS: u128 = 10;

impl SceneTables {
    /// The tables of `scene`, called `title`, its motion at these step indices; `None` takes eleven
    /// evenly spread ones.
    ///
    /// # Errors
    /// [`TableError`] where the reference refuses, or a digit stays open, among the modes, or where there is no such step.
    /// Where only the motion cannot be computed, [`without_response`](Self::without_response) says why.
    pub fn of(
        title: &str,
        scene: &Scene,
        steps: Option<&[u64]>,
    ) -> Result<SceneTables, TableError> {
        SceneTables::within(MOST_WORK, title, scene, steps)
    }

    /// The same, where no step of the reference takes more than so many multiplications of whole numbers, of which a core does
    /// some ten million in a second: 1e9 for [`of`](Self::of).
    ///
    /// # Errors
    /// As there.
    pub fn within(
        multiplications: f64,
        title: &str,
        scene: &Scene,
        steps: Option<&[u64]>,
    ) -> Result<SceneTables, TableError> {
        let response = match scene.problem().transpose()? {
            None => None,
            Some(problem) => {
                let last = u128::from(problem.grid().last());
                let part = |k| (last * k / PARTS) as u64; // not above the last
                let mut spread: Vec<u64> = (0..=PARTS).map(part).collect();
                spread.dedup();
                let problem = problem.at(steps.unwrap_or(&spread))?;
                Some(ResponseTable::within(multiplications, &problem))
            }
        };
        Ok(SceneTables {
            title: title.to_owned(),
            modes: ModeTable::within(multiplications, scene.system())?,
            response,
        })
    }

    /// What the scene is called.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// Its modes.
    pub fn modes(&self) -> &ModeTable {
        &self.modes
    }

    /// Its motion, if it asks for one and it can be computed.
    pub fn response(&self) -> Option<&ResponseTable> {
        self.response.as_ref()?.as_ref().ok()
    }

    /// Why there is no motion, if it asks for one.
    pub fn without_response(&self) -> Option<&TableError> {
        self.response.as_ref()?.as_ref().err()
    }

    /// The shapes as CSV: a row for each component of each mode that has one shape.
    pub fn shapes_csv(&self) -> String {
        self.modes.shapes().csv()
    }

    /// One Markdown document.
    pub fn markdown(&self) -> String {
        let mut out = format!("# {}\n\n{ABOUT}\n", markdown_text(&self.title));
        if self.is_open() {
            out += &format!("{}\n", OPEN.replace('<', "&lt;"));
        }
        out += &format!("\n## Modes\n\n{}", self.modes.markdown());
        if let Some(infinite) = self.infinite() {
            out += &format!("\n{infinite}\n");
        }
        let shapes = self.modes.shapes();
        out += "\n## Shapes\n\n";
        if !shapes.rows.is_empty() {
            out += &format!("{SHAPES}\n\n{}", shapes.markdown());
        }
        if let Some(several) = self.several() {
            let gap = if shapes.rows.is_empty() { "" } else { "\n" };
            out += &format!("{gap}{several}\n");
        }
        if let Some(response) = self.response() {
            out += &format!("\n## Response\n\n{TIMES}\n\n{}", response.markdown());
        }
        if let Some(error) = self.without_response() {
            let reason = markdown_text(&error.to_string());
            out += &format!("\n## Response\n\nNone: {reason}.\n");
        }
        out
    }

    /// One LaTeX fragment with a `tabular` for each table; it needs no package.
    pub fn latex(&self) -> String {
        let mut out = format!("% {ABOUT}\n\\paragraph{{{}}}\n\n", latex_text(&self.title));
        if self.is_open() {
            out += &format!("{}\n\n", latex_text(OPEN));
        }
        out += &format!("\\noindent Modes\\par\n{}", self.modes.latex());
        if let Some(infinite) = self.infinite() {
            out += &format!("\n{infinite}\n");
        }
        let shapes = self.modes.shapes();
        if !shapes.rows.is_empty() {
            out += &format!("\n\\noindent Shapes\\par\n{}", shapes.latex());
        }
        if let Some(several) = self.several() {
            out += &format!("\n{several}\n");
        }
        if let Some(response) = self.response() {
            out += &format!("\n\\noindent Response\\par\n{}", response.latex());
        }
        if let Some(error) = self.without_response() {
            let reason = latex_text(&error.to_string());
            out += &format!("\n\\noindent Response\\par\nNone: {reason}.\n");
        }
        out
    }

    /// One JSON object: `title`, `digits`, `modes`, `infinite`, `shapes` and `response`, which is null
    /// where the scene asks for none, or where `response_error` says why there is none. Numbers are in units of m, s and rad, in rows that have a `unit` in that one; their digits are those
    /// of the other forms.
    pub fn json(&self) -> String {
        let response = self.response();
        let error = self.without_response().map_or(String::new(), |error| {
            let reason = json_text(&error.to_string());
            format!(",\n  \"response_error\":{reason}")
        });
        format!(
            "{{\n  \"title\":{},\n  \"digits\":{DIGITS},\n  \"modes\":{},\n  \"infinite\":{},\n  \"shapes\":{},\n  \"response\":{}{error}\n}}\n",
            json_text(&self.title),
            self.modes.sheet().json("  "),
            self.modes.infinite(),
            self.modes.shapes().json("  "),
            response.map_or("null".to_owned(), |response| response.sheet().json("  ")),
        )
    }

    fn infinite(&self) -> Option<String> {
        match self.modes.infinite() {
            0 => None,
            1 => Some("One further root is infinite.".to_owned()),
            count => Some(format!("{count} further roots are infinite.")),
        }
    }

    /// Which modes have no shape of their own.
    fn several(&self) -> Option<String> {
        let rows = self.modes.rows().iter().enumerate();
        let without = rows.filter(|(_, row)| row.shape.is_none());
        let numbers: Vec<String> = without.map(|(k, _)| (k + 1).to_string()).collect();
        match numbers.as_slice() {
            [] => None,
            [one] => Some(format!(
                "Several shapes belong to mode {one}, and none stands out."
            )),
            all => Some(format!(
                "Several shapes belong to each of the modes {}, and none stands out.",
                all.join(", ")
            )),
        }
    }

    /// Whether a number is given by a bound only.
    fn is_open(&self) -> bool {
        let shapes = self
            .modes
            .rows()
            .iter()
            .flat_map(|row| row.shape.iter().flatten());
        let shapes = shapes.flat_map(|(re, im)| [re, im]);
        let rows = self.response().into_iter();
        let rows = rows.flat_map(|response| response.rows());
        let motion = rows.flat_map(|row| row.displacement.iter().chain(&row.velocity));
        shapes.chain(motion).any(super::Value::is_open)
    }
}
