//! The scene file: one vibrating system, its initial state, its loads and its instants, as JSON.
//!
//! `docs/scene.md` describes the format and `docs/scene.schema.json` is its JSON Schema. Reading is
//! strict: what is not part of the format, and what is said twice, is an error, and every error
//! names the file, the place in it, what is wrong and what would be right.

mod asked;
mod assemble;
mod error;
mod layout;
mod matrix_error;
mod matrix_file;
mod matrix_market;
mod petsc;
mod place;
mod record;
mod shape;
mod text;
mod words;

use std::path::Path;

use eigentone_modes::{Precision, System};
use eigentone_response::{
    Combination, Load, Noise, Problem, Quantity, RandomVibration, Response, ResponseError, State,
    Sum,
};

use eigentone_switching::Switch;

pub use error::{MAX_BYTES, SceneError};
pub use matrix_error::{MAX_MATRIX_BYTES, MAX_MATRIX_MEMORY, MatrixFileError, Spot};
pub use place::Place;
pub use record::{MAX_RECORD_BYTES, RecordError, Table, read_record};
pub use text::{read_file, read_text};
pub use words::did_you_mean;

/// A scene that has been read and checked.
#[derive(Clone, Debug)]
pub struct Scene {
    title: Option<String>,
    system: System,
    initial: State,
    loads: Vec<(String, Load)>,
    motions: Vec<(String, Quantity, Load)>,
    outputs: Vec<Combination>,
    /// One for each spring.
    loss_factors: Vec<f64>,
    /// Step and end.
    time: Option<(f64, f64)>,
    frequencies: Option<Vec<f64>>,
    /// What is noise: a force on what, or which motion of which support.
    noises: Vec<(String, Option<Quantity>, Noise)>,
    /// Each with the key of its list, and its place there.
    switches: Vec<(&'static str, usize, Switch)>,
}

impl Scene {
    /// Reads and checks a scene file.
    ///
    /// # Errors
    /// [`SceneError`] naming the file, the place in it, what is wrong and what would be right.
    pub fn read(path: &Path) -> Result<Scene, SceneError> {
        Scene::parse(&read_file(path)?, path)
    }

    /// Checks the text of a scene; `file` is named in errors, and beside it are the Matrix Market files
    /// that the scene names.
    ///
    /// # Errors
    /// As [`read`](Scene::read), without those of reading the scene itself.
    ///
    /// ```
    /// use eigentone::scene::Scene;
    ///
    /// let text = r#"{ "masses": [{"name": "m", "mass": 2}],
    ///                 "springs": [{"between": ["ground", "m"], "stiffness": 8}] }"#;
    /// let scene = Scene::parse(text, "example.json".as_ref())?;
    /// assert_eq!(scene.system().names(), ["m"]);
    /// assert!(scene.problem().is_none());
    ///
    /// let error = Scene::parse(&text.replace("8", "null"), "example.json".as_ref()).unwrap_err();
    /// let message = "example.json:2:74: springs[0].stiffness: expected a number, found null";
    /// assert_eq!(error.to_string(), message);
    /// # Ok::<(), eigentone::scene::SceneError>(())
    /// ```
    pub fn parse(text: &str, file: &Path) -> Result<Scene, SceneError> {
        Scene::parse_to(text, file, Precision::default())
    }

    /// The same for answers of this precision: what is only wanted in doubles need not have modal damping with fifty digits.
    ///
    /// # Errors
    /// As [`parse`](Scene::parse).
    pub fn parse_to(text: &str, file: &Path, precision: Precision) -> Result<Scene, SceneError> {
        let source = text::Source::new(text, file)?;
        assemble::scene(source.layout()?, &source, precision)
    }

    /// The title, if it has one.
    pub fn title(&self) -> Option<&str> {
        self.title.as_deref()
    }

    /// The system it describes.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// What it asks for beside the motion of the coordinates.
    pub fn outputs(&self) -> &[Combination] {
        &self.outputs
    }

    /// The loss factors of the springs, in their order; 0 where none is given. They are for frequency response: neither
    /// modes nor motions have them.
    pub fn loss_factors(&self) -> &[f64] {
        &self.loss_factors
    }

    /// The frequencies in rad/s that it asks for in frequency responses, rising; `None` if it names none.
    pub fn frequencies(&self) -> Option<&[f64]> {
        self.frequencies.as_deref()
    }

    /// The end of its time in s; `None` if it has none.
    pub fn end(&self) -> Option<f64> {
        self.time.map(|(_, end)| end)
    }

    /// Its frictions, stops, impacts and controlled dampers, in this order: neither its [`system`](Self::system) nor its
    /// [`problem`](Self::problem) has them.
    pub fn switches(&self) -> Vec<Switch> {
        let switches = self.switches.iter();
        switches.map(|(.., switch)| switch.clone()).collect()
    }

    /// What each switch is in the file, as `frictions[0]`.
    pub fn switch_places(&self) -> Vec<String> {
        let switches = self.switches.iter();
        let places = switches.map(|(key, index, _)| format!("{key}[{index}]"));
        places.collect()
    }

    /// The noise that drives it, asked for all its outputs; `None` if it has none.
    pub fn noise(&self) -> Option<RandomVibration<'_>> {
        if self.noises.is_empty() {
            return None;
        }
        let all = RandomVibration::of(&self.system);
        let all = self
            .noises
            .iter()
            .fold(all, |all, (name, quantity, noise)| match quantity {
                None => all.force(name, *noise),
                Some(quantity) => all.motion(name, *quantity, *noise),
            });
        let outputs = self.outputs.iter().cloned();
        Some(outputs.fold(all, RandomVibration::output))
    }

    /// The names of what loads act on, then of the supports that motions move, each once.
    pub fn driven(&self) -> Vec<&str> {
        let loads = self.loads.iter().map(|(on, _)| on);
        let all = loads.chain(self.motions.iter().map(|(of, ..)| of));
        let mut names: Vec<&str> = Vec::new();
        for name in all {
            if !names.contains(&name.as_str()) {
                names.push(name);
            }
        }
        names
    }

    /// The supports that are moved, and by which of their derivatives, in the order given.
    pub fn motions(&self) -> impl Iterator<Item = (&str, Quantity)> {
        let motions = self.motions.iter();
        motions.map(|(of, quantity, _)| (of.as_str(), *quantity))
    }

    /// The response it asks for, of its system without switches; `None` if it has no `time`.
    ///
    /// # Errors
    /// None after [`read`](Scene::read), which checks the same; the type is the library's.
    pub fn problem(&self) -> Option<Result<Problem<'_>, ResponseError>> {
        let (step, end) = self.time?;
        Some(self.asked(step, end).problem())
    }

    /// The response at these instants.
    fn asked(&self, step: f64, end: f64) -> Response<'_> {
        let mut response = Response::of(&self.system)
            .from(self.initial.clone())
            .every(step)
            .until(end);
        for (on, load) in &self.loads {
            response = response.load(on, load.clone());
        }
        for (of, quantity, course) in &self.motions {
            response = response.motion(of, *quantity, course.clone());
        }
        for output in &self.outputs {
            response = match &output.of {
                Sum::Motions(motions) => response.sum(&output.name, motions.iter().cloned()),
                Sum::Pull(element) => response.pull(&output.name, element),
            };
        }
        response
    }
}
