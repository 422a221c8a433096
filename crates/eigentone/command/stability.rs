//! `eigentone stability [--out DIR]`.

use std::path::{Path, PathBuf};

use clap::Args;
use eigentone::check::{Family, StabilityStudy, StudyProgress};
use eigentone::report::StabilityReport;

use super::files::Files;
use super::progress::Progress;
use super::{Failure, print};

/// Tries every method at extremes of stiffness, damping, mass, step, time and size
#[derive(Debug, Args)]
pub struct Stability {
    /// Study only these families: stiffness, damping, mass, step, horizon, size
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = family)]
    only: Vec<String>,
    /// Write the tables, the data and the heat maps into this directory, replacing files of the same names
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Stability {
    pub fn run(self) -> Result<(), Failure> {
        let mut families = Family::all();
        if !self.only.is_empty() {
            families.retain(|family| self.only.iter().any(|name| name == family.name));
        }
        let progress = Progress::of("stability study");
        let study = StabilityStudy::run(&families, &mut |row| progress.say(&message(&row)));
        let report = StabilityReport { study: &study };
        if let Some(directory) = &self.out {
            write(&report, directory)?;
        }
        drop(progress);
        print(|out| out.write_all(report.text().as_bytes()))
    }
}

fn family(name: &str) -> Result<String, String> {
    let families = Family::all();
    if families.iter().any(|family| family.name == name) {
        return Ok(name.to_owned());
    }
    let known: Vec<&str> = families.iter().map(|family| family.name).collect();
    Err(format!("the families are {}", known.join(", ")))
}

fn message(row: &StudyProgress<'_>) -> String {
    format!(
        "{} of {}: {} {:e} by {}",
        row.done + 1,
        row.total,
        row.family,
        row.value,
        row.method
    )
}

fn write(report: &StabilityReport<'_>, directory: &Path) -> Result<(), Failure> {
    let mut files = Files::into(directory)?;
    files.write("stability.json", |out| report.json(out))?;
    files.write("stability.md", |out| {
        out.write_all(report.markdown(true).as_bytes())
    })?;
    for (name, svg) in report.heat_maps() {
        files.write(&name, |out| out.write_all(svg.as_bytes()))?;
    }
    files.keep()
}
