//! `eigentone export SCENE [--from NAME]… [--to NAME]… [--hold zero|first --step h] [--json] [--out DIR]`, and
//! `eigentone export SCENE --matrices market|petsc --out DIR`.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use eigentone::modes::MatrixKind;
use eigentone::report::{SparseMatrixReport, StateSpaceReport};
use eigentone::response::StateMatrices;
use eigentone::scene::Scene;

use super::files::Files;
use super::progress::Progress;
use super::{Failure, Hold, known_ends, memory, positive, print, read, report_switches, source};

/// Prints the state-space matrices A, B, C and D, continuous or held, or writes M, C and K for other programs
#[derive(Debug, Args)]
pub struct Export {
    // All entries are rounded once: there is no precision to ask for.
    /// The scene file; - is standard input
    #[arg(value_parser = source::parser())]
    scene: PathBuf,
    #[command(flatten)]
    memory: memory::Limit,
    /// An input: the force on this mass or point, or the motion of this support; may be repeated [default: what the scene
    /// drives, else its supports, else each mass]
    #[arg(long, value_name = "NAME")]
    from: Vec<String>,
    /// An output: the displacement of this mass, point or support, or an output of the scene; may be repeated
    /// [default: all masses, points and outputs]
    #[arg(long, value_name = "NAME")]
    to: Vec<String>,
    /// The exact discrete form: inputs are held between samples (zero), or are straight lines between them (first)
    #[arg(long, value_enum)]
    hold: Option<Hold>,
    /// Time between the samples, in s
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    step: Option<f64>,
    /// Print one JSON object with every digit
    #[arg(long)]
    json: bool,
    /// Write the matrices into this directory, as JSON and in Matrix Market format
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write sparse M, C and K into --out in this format instead, of systems of any size, with a scene that reads them back
    #[arg(long, value_enum, value_name = "FORMAT", requires = "out",
        conflicts_with_all = ["from", "to", "hold", "step", "json"])]
    matrices: Option<Format>,
}

/// A format of sparse matrices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Matrix Market, as text
    Market,
    /// PETSc's binary format
    Petsc,
}

impl Format {
    fn extension(self) -> &'static str {
        match self {
            Format::Market => "mtx",
            Format::Petsc => "petsc",
        }
    }
}

impl Export {
    pub fn run(self) -> Result<(), Failure> {
        if self.hold.is_some() != self.step.is_some() {
            return Err(Failure::HoldWithoutStep);
        }
        let scene = read(&self.scene)?;
        let file = &self.scene;
        known_ends(file, &scene, &self.from, &self.to)?;
        report_switches(file, &scene);
        if let (Some(format), Some(directory)) = (self.matrices, &self.out) {
            return self.sparse(&scene, format, directory);
        }
        if scene.loss_factors().iter().any(|factor| *factor != 0.0) {
            let scene = file.clone();
            return Err(Failure::LossFactor { scene });
        }
        self.memory.admit_modes(file, &scene)?;
        let progress = Progress::of("state space");
        let failure = |error| Failure::StateSpace {
            scene: file.clone(),
            error,
        };
        let from = match self.from.is_empty() {
            true => scene.inputs(),
            false => self.from,
        };
        let to = (!self.to.is_empty()).then_some(self.to.as_slice());
        let (plant, said) = scene.state_space(&from, to).map_err(failure)?;
        for note in said {
            // If standard error is closed, nobody can be informed.
            let _ = writeln!(io::stderr(), "note: {}: {note}", file.display());
        }
        let held: Option<(f64, Hold, StateMatrices)> = match (self.step, self.hold) {
            (Some(step), Some(hold)) => {
                let held = plant.discretise(step, hold.into()).map_err(failure)?;
                Some((step, hold, held))
            }
            _ => None,
        };
        drop(progress);
        let report = StateSpaceReport {
            plant: &plant,
            held: held
                .as_ref()
                .map(|(step, hold, matrices)| (*step, (*hold).into(), matrices)),
        };
        if let Some(directory) = &self.out {
            let mut files = Files::into(directory)?.beside(file);
            files.write("export.json", |out| report.json(out))?;
            for (name, matrix) in report.matrices() {
                files.write(&format!("{name}.mtx"), |out| {
                    StateSpaceReport::matrix_market(matrix, out)
                })?;
            }
            files.keep()?;
        }
        print(|out| match self.json {
            true => report.json(out),
            false => out.write_all(report.text().as_bytes()),
        })
    }

    /// M, C and K as files, C only where it is not 0, and a scene that names them.
    fn sparse(&self, scene: &Scene, format: Format, directory: &Path) -> Result<(), Failure> {
        let system = scene.system();
        let mut files = Files::into(directory)?.beside(&self.scene);
        let progress = Progress::of("matrices");
        let (mut named, mut lines) = (Vec::new(), String::new());
        for kind in [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness] {
            let matrix = SparseMatrixReport::of(system, kind);
            let entries = matrix.entries();
            if kind == MatrixKind::Damping && entries == 0 {
                continue;
            }
            let name = format!("{kind}.{}", format.extension());
            files.write(&name, |out| match format {
                Format::Market => matrix.matrix_market(out),
                Format::Petsc => matrix.petsc(false, out),
            })?;
            named.push(format!("\"{kind}\": \"{name}\""));
            let symmetry = match matrix.is_symmetric() {
                true => "symmetric",
                false => "not symmetric",
            };
            let n = system.len();
            lines += &format!("{name}: {n} × {n}, {entries} entries, {symmetry}\n");
        }
        files.write("matrices.json", |out| {
            writeln!(out, "{{\"matrices\": {{{}}}}}", named.join(", "))
        })?;
        drop(progress);
        files.keep()?;
        print(|out| out.write_all(lines.as_bytes()))
    }
}
