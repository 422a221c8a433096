//! `eigentone scenes [NAME | --schema]`.

use clap::Args;
use eigentone::gallery::{Case, cases, machines};
use eigentone::scene::did_you_mean;

use super::{Failure, print};

/// Lists the scenes of the gallery, whose answers are known to 34 digits, or prints one
#[derive(Debug, Args)]
pub struct Scenes {
    /// The scene to print [default: list all]
    name: Option<String>,
    /// Print the JSON Schema of scenes, by which editors complete and check: save it as scene.schema.json beside yours
    #[arg(long, conflicts_with = "name")]
    schema: bool,
}

const SCHEMA: &str = include_str!("../../../docs/scene.schema.json");

impl Scenes {
    pub fn run(self) -> Result<(), Failure> {
        if self.schema {
            return print(|out| out.write_all(SCHEMA.as_bytes()));
        }
        let all: Vec<&Case> = cases().iter().chain(machines()).collect();
        let Some(name) = self.name else {
            let width = all.iter().map(|case| case.name().len()).max().unwrap_or(0);
            return print(|out| {
                all.iter().try_for_each(|case| {
                    let (name, scene) = (case.name(), case.scene());
                    writeln!(out, "{name:width$}  {}", scene.title().unwrap_or_default())
                })
            });
        };
        match all.iter().find(|case| case.name() == name) {
            Some(case) => print(|out| out.write_all(case.scene_text().as_bytes())),
            None => {
                let known: Vec<&str> = all.iter().map(|case| case.name()).collect();
                let hint = did_you_mean(&name, &known);
                Err(Failure::NoSuchScene { name, hint })
            }
        }
    }
}
