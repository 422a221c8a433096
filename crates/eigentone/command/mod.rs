//! The command line: what can be asked for, and how each command answers.

mod absorber;
mod analyze;
mod asymmetry;
mod campbell;
mod check;
mod cycle;
mod designs;
mod export;
mod failure;
mod files;
mod fit;
mod form;
mod frequency;
mod frf;
mod interrupt;
mod measured;
mod memory;
mod merge;
mod modes;
mod new;
mod optimise;
mod parts;
mod progress;
mod random;
mod response;
mod scenes;
mod selection;
mod shell;
mod slepc;
mod source;
mod spectrum;
mod stability;
mod study;
mod sweep;
mod tables;

use std::ffi::OsString;
use std::io::{self, BufWriter, Write};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};
use eigentone::modes::{Bounds, Modes, System};
use eigentone::response::Trajectory;
use eigentone::scene::{Scene, did_you_mean};

pub use failure::Failure;

/// Modes and exact time response of linear vibrating systems.
#[derive(Debug, Parser)]
#[command(name = "eigentone", version, about)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Analyze(analyze::Analyze),
    Modes(modes::Modes),
    Response(response::Response),
    Frf(frf::Frf),
    Random(random::Random),
    Spectrum(spectrum::Spectrum),
    Campbell(campbell::Campbell),
    Sweep(sweep::Sweep),
    Merge(merge::Merge),
    Optimise(optimise::Optimise),
    Fit(fit::Fit),
    Absorber(absorber::Absorber),
    Cycle(cycle::Cycle),
    Export(export::Export),
    Check(check::Check),
    Stability(stability::Stability),
    Tables(tables::Tables),
    New(new::New),
    Scenes(scenes::Scenes),
    Completions(shell::Completions),
    #[command(name = "man")]
    Manual(shell::Manual),
}

impl Cli {
    /// Reads what was typed; what is wrong with it, and help, ends the program.
    pub fn read() -> Cli {
        // A number below 0 is a value that its option refuses in its own words, and no unknown option.
        let command = Cli::command().mut_subcommands(|command| {
            command.mut_args(|arg| match arg.get_action().takes_values() {
                true if !arg.is_positional() => arg.allow_negative_numbers(true),
                _ => arg,
            })
        });
        let typed = joined(std::env::args_os());
        let read = command.try_get_matches_from(&typed);
        let read = read.and_then(|found| Cli::from_arg_matches(&found));
        read.unwrap_or_else(|mut error| {
            let first = typed.get(1).map(Path::new);
            if let (ErrorKind::InvalidSubcommand, Some(file)) = (error.kind(), first)
                && (file.exists() || file.extension().is_some_and(|end| end == "json"))
            {
                let tip = format!(
                    "a command comes before the scene, as in 'eigentone analyze {}'",
                    file.display()
                );
                let tip = ContextValue::StyledStrs(vec![tip.into()]);
                error.insert(ContextKind::Suggested, tip);
            }
            error.exit()
        })
    }

    /// Runs the command and prints its result on standard output, or nothing if it fails.
    pub fn run(self) -> Result<(), Failure> {
        interrupt::watch(self.command.quicker());
        match self.command {
            Command::Analyze(command) => command.run(),
            Command::Modes(command) => command.run(),
            Command::Response(command) => command.run(),
            Command::Frf(command) => command.run(),
            Command::Random(command) => command.run(),
            Command::Spectrum(command) => command.run(),
            Command::Campbell(command) => command.run(),
            Command::Sweep(command) => command.run(),
            Command::Merge(command) => command.run(),
            Command::Optimise(command) => command.run(),
            Command::Fit(command) => command.run(),
            Command::Absorber(command) => command.run(),
            Command::Cycle(command) => command.run(),
            Command::Export(command) => command.run(),
            Command::Check(command) => command.run(),
            Command::Stability(command) => command.run(),
            Command::Tables(command) => command.run(),
            Command::New(command) => command.run(),
            Command::Scenes(command) => command.run(),
            Command::Completions(command) => command.run(),
            Command::Manual(command) => command.run(),
        }
    }
}

impl Command {
    /// What to ask for in place of an answer that takes too long.
    fn quicker(&self) -> Option<&'static str> {
        match self {
            Command::Analyze(_) | Command::Response(_) => Some(
                "--precision double, with estimated bounds; fewer instants, by a larger time.step or `response --steps 0,100`",
            ),
            Command::Modes(_) => Some(
                "--precision double, with estimated bounds; some modes alone, by --lowest or --near",
            ),
            Command::Frf(_) => Some(
                "fewer functions, by --from and --to; --at for single frequencies; --precision double, with estimated bounds",
            ),
            Command::Check(_) => Some("fewer methods, by --methods; a smaller time.end"),
            Command::Cycle(_) => {
                Some("a start nearer to the periodic motion, and a smaller time.end")
            }
            Command::Sweep(_) => Some(
                "fewer designs, or a part of them by --shard 1/4; what --out has already, --resume goes on with",
            ),
            Command::Random(_) | Command::Spectrum(_) | Command::Campbell(_) => {
                Some("--precision double, with estimated bounds")
            }
            _ => None,
        }
    }
}

/// What every command is given: the scene, and how far its answer may be off.
#[derive(Debug, Args)]
struct Question {
    /// The scene file; - is standard input
    #[arg(value_parser = source::parser())]
    scene: PathBuf,
    #[command(flatten)]
    accuracy: Accuracy,
    #[command(flatten)]
    memory: memory::Limit,
}

/// How far an answer may be off.
#[derive(Clone, Copy, Debug, Args)]
struct Accuracy {
    /// Proven bounds, computed with more digits where they need them, or double precision alone
    #[arg(long, value_enum, default_value_t = Precision::Certified)]
    precision: Precision,
    /// Largest relative error wanted, at least 2^-53 [default: the last digits]
    #[arg(long, value_name = "REL", value_parser = tolerance)]
    tolerance: Option<f64>,
}

impl Accuracy {
    /// As the library puts it, once the options make sense together.
    fn precision(&self) -> Result<eigentone::modes::Precision, Failure> {
        use eigentone::modes::Precision as Asked;
        match (self.precision, self.tolerance) {
            (Precision::Double, Some(_)) => Err(Failure::ToleranceInDoubles),
            (Precision::Double, None) => Ok(Asked::Double),
            (Precision::Certified, Some(tolerance)) => Ok(Asked::Certified { tolerance }),
            (Precision::Certified, None) => Ok(Asked::default()),
        }
    }
}

/// What an input does between its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Hold {
    Zero,
    First,
}

impl From<Hold> for eigentone::response::Hold {
    fn from(hold: Hold) -> eigentone::response::Hold {
        match hold {
            Hold::Zero => eigentone::response::Hold::Zero,
            Hold::First => eigentone::response::Hold::First,
        }
    }
}

/// What helps where proofs leave roots without bounds.
const UNPROVEN: &str = "solve parts of the system, at best of up to 64 coordinates, or give it in units that bring its numbers closer together";

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Precision {
    Certified,
    Double,
}

impl Question {
    /// Reads the scene once the options make sense together.
    fn scene(&self) -> Result<Scene, Failure> {
        self.accuracy.precision()?;
        let scene = read(&self.scene)?;
        asymmetry::report(&self.scene, scene.system());
        Ok(scene)
    }

    /// The precision asked for, as the library puts it.
    fn precision(&self) -> eigentone::modes::Precision {
        // `scene` has refused what makes no sense.
        self.accuracy.precision().unwrap_or_default()
    }

    /// Refuses what would take more memory than is allowed, before any is taken, and says of what there may be fewer.
    fn admit(&self, bytes: f64, fewer: &'static str) -> Result<(), Failure> {
        self.memory.admit(&self.scene, bytes, Some(fewer))
    }

    /// The same for all modes.
    fn admit_modes(&self, scene: &Scene) -> Result<(), Failure> {
        self.memory.admit_modes(&self.scene, scene)
    }

    /// Says on standard error that modes know of no loss factors.
    fn report_loss_factors(&self, scene: &Scene) {
        if scene.loss_factors().iter().any(|factor| *factor != 0.0) {
            let _ = writeln!(
                io::stderr(),
                "note: {}: loss factors are for frequency response: modes leave them out",
                self.scene.display()
            );
        }
    }

    /// Says on standard error which roots are doubtful, and what would help.
    fn report_doubts(&self, modes: &Modes) {
        let all = modes.eigenvalues();
        let count = all.iter().filter(|root| root.is_doubtful()).count();
        if count == 0 {
            return;
        }
        let scene = self.scene.display();
        let help = match self.accuracy.precision {
            Precision::Double => "leave out --precision double",
            Precision::Certified => UNPROVEN,
        };
        let of = all.len();
        // If standard error is closed, nobody can be informed.
        let _ = writeln!(
            io::stderr(),
            "note: {scene}: {count} of {of} roots are doubtful: doubles give no bound for them; {help}"
        );
    }

    /// Says on standard error how much of a motion is doubtful, and what would help.
    fn report_doubts_of_motion(&self, motion: &Trajectory) {
        let (count, all) = (motion.doubtful(), motion.len());
        if count == 0 {
            return;
        }
        let help = match self.accuracy.precision {
            Precision::Double => "leave out --precision double",
            Precision::Certified => "ask for fewer samples, or for parts of the system",
        };
        let scene = self.scene.display();
        let _ = writeln!(
            io::stderr(),
            "note: {scene}: {count} of {all} samples are doubtful: doubles give no bound for a motion that may grow, \
             that nothing holds, or that is too stiff for them; {help}"
        );
    }

    /// Says on standard error why bounds that were to be proven are not.
    fn report_estimates(&self, modes: &Modes) {
        if self.accuracy.precision == Precision::Certified && modes.bounds() == Bounds::Estimated {
            let (scene, bounds) = (self.scene.display(), &modes.plan().bounds);
            let _ = writeln!(io::stderr(), "note: {scene}: bounds are {bounds}");
        }
    }

    /// Says on standard error which roots near 0 rounding of the given stiffness matrix may have moved there.
    fn report_rounding(&self, system: &System, modes: &Modes) {
        let places = system.rigid_but_for_rounding(modes);
        if places.is_empty() {
            return;
        }
        let number = |place: &usize| {
            let rate = modes[*place].eigenvalue().value.norm();
            format!("{} ({rate:.1e} rad/s)", place + 1)
        };
        let numbers: Vec<String> = places.iter().map(number).collect();
        let (mode, are) = match numbers.len() {
            1 => ("mode", "a rigid motion"),
            _ => ("modes", "rigid motions"),
        };
        let (scene, numbers) = (self.scene.display(), numbers.join(", "));
        let _ = writeln!(
            io::stderr(),
            "note: {scene}: {mode} {numbers} may be {are}: rounding of the entries of the stiffness matrix moves roots so far from 0"
        );
    }

    /// What a scene without a title is called.
    fn name(&self) -> String {
        let name = self.scene.file_stem().unwrap_or(self.scene.as_os_str());
        name.to_string_lossy().into_owned()
    }
}

/// Reads and checks a scene.
fn read(scene: &Path) -> Result<Scene, Failure> {
    Ok(Scene::parse(&source::text(scene)?, scene)?)
}

/// Refuses a scene with switches.
fn refuse_switches(file: &Path, scene: &Scene, what: &'static str) -> Result<(), Failure> {
    match scene.switch_places().into_iter().next() {
        None => Ok(()),
        Some(first) => Err(Failure::Switches {
            scene: file.to_owned(),
            first,
            what,
        }),
    }
}

/// Says on standard error that an answer leaves switches out.
fn report_switches(file: &Path, scene: &Scene) {
    if !scene.switches().is_empty() {
        let _ = writeln!(
            io::stderr(),
            "note: {}: modes, frequencies and noise are of the scene without its frictions, stops, impacts and controlled dampers",
            file.display()
        );
    }
}

/// A number greater than 0.
fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("it must be a finite number greater than 0".to_owned()),
    }
}

fn tolerance(text: &str) -> Result<f64, String> {
    const LEAST: f64 = f64::EPSILON / 2.0;
    match text.parse::<f64>() {
        Ok(value) if (LEAST..1.0).contains(&value) => Ok(value),
        _ => Err("it must be a number of at least 2^-53 = 1.11e-16 and below 1".to_owned()),
    }
}

/// Refuses a name that none of those known is.
fn known<'a>(
    scene: &Path,
    option: &'static str,
    names: &[String],
    all: impl Iterator<Item = &'a String>,
) -> Result<(), Failure> {
    let all: Vec<&String> = all.collect();
    match names.iter().find(|name| !all.contains(name)) {
        None => Ok(()),
        Some(name) => Err(Failure::UnknownName {
            scene: scene.to_owned(),
            option,
            name: name.clone(),
            hint: did_you_mean(name, &all),
        }),
    }
}

/// Refuses names of inputs and outputs that the scene does not have.
fn known_ends(file: &Path, scene: &Scene, from: &[String], to: &[String]) -> Result<(), Failure> {
    let system = scene.system();
    let points = system.points().iter().map(|point| &point.name);
    let places = system.names().iter().chain(points).chain(system.supports());
    known(file, "--from", from, places.clone())?;
    let outputs = scene.outputs().iter().map(|output| &output.name);
    known(file, "--to", to, places.chain(outputs))
}

/// What was typed, with lists and units in one word: `--steps 0 1 2` is `--steps 0,1,2`, and `--near 14 Hz` is `--near 14Hz`.
fn joined(typed: impl Iterator<Item = OsString>) -> Vec<OsString> {
    const LISTS: [&str; 3] = ["--steps", "--at", "--near"];
    let mut words: Vec<OsString> = Vec::new();
    // How many words ago a list began.
    let mut list = None;
    for word in typed {
        let text = word.to_str().unwrap_or_default();
        let joint = match (list, text) {
            (Some(1..), "Hz" | "rad/s") => Some(""),
            (Some(1..), _) if text.parse::<f64>().is_ok() => Some(","),
            _ => None,
        };
        list = match list {
            _ if LISTS.contains(&text) => Some(0),
            Some(0) => Some(1),
            Some(_) if joint.is_some() => list,
            _ => None,
        };
        match (joint, words.last_mut()) {
            (Some(joint), Some(last)) => last.push(format!("{joint}{text}")),
            _ => words.push(word),
        }
    }
    words
}

/// How many are wanted.
fn count(text: &str) -> Result<u32, String> {
    whole(1..=u32::MAX)(text)
}

/// A whole number within limits.
fn whole(limits: RangeInclusive<u32>) -> impl Fn(&str) -> Result<u32, String> + Clone {
    move |text| match text.parse() {
        Ok(number) if limits.contains(&number) => Ok(number),
        _ => {
            let (least, most) = limits.clone().into_inner();
            Err(format!("it must be a whole number from {least} to {most}"))
        }
    }
}

/// The index of a sample.
fn index(text: &str) -> Result<u64, String> {
    let right = "it must be whole numbers from 0 on, as 0,10,400";
    text.parse().map_err(|_| right.to_owned())
}

/// Writes to standard output. Who stops reading early has seen enough.
fn print(write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Failure> {
    let mut out = BufWriter::with_capacity(1 << 16, io::stdout().lock());
    match write(&mut out).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::Output(error)),
        _ => Ok(()),
    }
}
