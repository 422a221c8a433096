//! `eigentone tables [SCENE] --out DIR`.

use std::path::{Path, PathBuf};

use clap::Args;
use eigentone::gallery::{Case, cases};
use eigentone::scene::Scene;
use eigentone::tables::SceneTables;

use super::files::Files;
use super::progress::Progress;
use super::{Failure, index, memory, read, refuse_switches, source};

/// Writes reference tables: modes and motion to 15 digits, all of them correct
#[derive(Debug, Args)]
pub struct Tables {
    /// The scene file; - is standard input; without one, every scene of the gallery
    #[arg(value_parser = source::parser())]
    scene: Option<PathBuf>,
    /// Write the tables into this directory, replacing files of the same names
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Show the motion at these sample indices, in this order [default: eleven evenly spread ones]
    #[arg(
        long,
        value_name = "INDICES",
        value_delimiter = ',',
        value_parser = index,
        requires = "scene"
    )]
    steps: Option<Vec<u64>>,
    #[command(flatten)]
    memory: memory::Limit,
}

/// How many instants are shown where none are asked for.
const SPREAD: u64 = 11;

impl Tables {
    pub fn run(self) -> Result<(), Failure> {
        match &self.scene {
            Some(file) => {
                let scene = read(file)?;
                refuse_switches(file, &scene, "tables")?;
                let name = source::stem(file);
                let instants = match &self.steps {
                    Some(steps) => steps.len() as u64,
                    None => memory::instants(&scene).min(SPREAD),
                };
                let needed = memory::of_tables(&scene, instants);
                self.memory.admit(file, needed, Some("instants"))?;
                let _progress = Progress::of("tables");
                let tables = tables_of(file, &name, &scene, self.steps.as_deref())?;
                let mut files = Files::into(&self.out)?.beside(file);
                write(&mut files, &name, &tables)?;
                files.keep()?;
                complete(file, &tables)
            }
            None => gallery(&self.out, self.memory),
        }
    }
}

fn gallery(directory: &Path, limit: memory::Limit) -> Result<(), Failure> {
    let mut files = Files::into(directory)?;
    let progress = Progress::of("tables");
    let mut index = String::from(INDEX);
    for (k, case) in cases().iter().enumerate() {
        let name = case.name();
        progress.say(&format!("{} of {}: {name}", k + 1, cases().len()));
        let steps: Vec<u64> = instants(case);
        let (file, scene) = (Path::new(name), case.scene());
        let needed = memory::of_tables(&scene, steps.len() as u64);
        limit.admit(file, needed, None)?;
        let tables = tables_of(file, name, &scene, Some(&steps))?;
        write(&mut files, name, &tables)?;
        complete(file, &tables)?;
        let motion = match tables.response() {
            Some(_) => format!("[csv]({name}-response.csv)"),
            None => "–".to_owned(),
        };
        index += &format!(
            "| [{name}]({name}.md) | {} | [csv]({name}-modes.csv) | [csv]({name}-shapes.csv) | {motion} | [json]({name}.json) | [tex]({name}.tex) |\n",
            tables.title()
        );
    }
    files.write("README.md", |out| out.write_all(index.as_bytes()))?;
    files.keep()
}

/// The instants at which the gallery knows the motion.
fn instants(case: &Case) -> Vec<u64> {
    let samples = case.truth().response;
    samples.iter().map(|sample| sample.step).collect()
}

const INDEX: &str = "\
# Reference tables

Natural frequencies, damping ratios, shapes and motions of the scenes in [tests/gallery](../../tests/gallery),
to 15 significant digits. Each number is rounded once, to nearest, from an enclosure that leaves no other
rounding; a test holds every digit against answers of 34 digits that another program gave.

`eigentone tables --out DIR` makes these files, and `eigentone tables SCENE --out DIR` those of a scene of
your own. `eigentone::tables` gives the same to a program, for instance to the documentation of another crate.

| scene | what it is | modes | shapes | motion | all | all |
| :-- | :-- | :-- | :-- | :-- | :-- | :-- |
";

fn tables_of(
    file: &Path,
    name: &str,
    scene: &Scene,
    steps: Option<&[u64]>,
) -> Result<SceneTables, Failure> {
    let title = scene.title().unwrap_or(name);
    SceneTables::of(title, scene, steps).map_err(Failure::table(file))
}

/// Fails where the motion did: what is said of the modes holds all the same.
fn complete(file: &Path, tables: &SceneTables) -> Result<(), Failure> {
    let error = tables.without_response().cloned();
    error.map_or(Ok(()), |error| Err(Failure::table(file)(error)))
}

fn write(files: &mut Files, name: &str, tables: &SceneTables) -> Result<(), Failure> {
    let mut one = |ending: &str, text: String| {
        files.write(&format!("{name}{ending}"), |out| {
            out.write_all(text.as_bytes())
        })
    };
    one(".md", tables.markdown())?;
    one(".json", tables.json())?;
    one(".tex", tables.latex())?;
    one("-modes.csv", tables.modes().csv())?;
    one("-shapes.csv", tables.shapes_csv())?;
    match tables.response() {
        Some(response) => one("-response.csv", response.csv()),
        None => Ok(()),
    }
}
