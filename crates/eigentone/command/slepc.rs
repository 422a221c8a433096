//! Eigenpairs by SLEPc, on as many ranks as there are: matrices and a driver go into a directory, a launcher starts the
//! driver on every rank, and the pairs it leaves are read back. What they are worth is not decided here.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{ChildStderr, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::time::{Duration, Instant};

use clap::Args;
use eigentone::modes::{Eigenpair, Frequency, MatrixKind, System};
use eigentone::report::SparseMatrixReport;
use num_complex::Complex;
use thiserror::Error;

use super::interrupt;
use super::progress::Progress;

const DRIVER: &str = include_str!("slepc.py");

/// What the answer begins with.
const MAGIC: &[u8; 8] = b"EIGENT\x01\n";

/// How SLEPc is started.
#[derive(Clone, Debug, Args)]
pub struct Slepc {
    /// Number of processes, with --engine slepc
    #[arg(long, value_name = "COUNT", default_value_t = 1, value_parser = super::count)]
    ranks: u32,
    /// Time limit of SLEPc, in s
    #[arg(long, value_name = "SECONDS", default_value_t = 3600.0, value_parser = super::positive)]
    time_limit: f64,
    /// The program that starts the processes, called with -n COUNT: mpirun, or srun within a job of Slurm
    #[arg(long, value_name = "COMMAND", default_value = "mpirun")]
    launcher: String,
    /// The Python that has slepc4py [default: python3, then /usr/bin/python3]
    #[arg(long, value_name = "FILE")]
    python: Option<PathBuf>,
    /// The directory in which matrices and shapes are exchanged; every process must see it [default: the system's temporary directory]
    #[arg(long, value_name = "DIR")]
    scratch: Option<PathBuf>,
}

/// Why SLEPc gave no eigenpairs.
#[derive(Debug, Error)]
pub enum SlepcError {
    /// No Python has it.
    #[error(
        "SLEPc is not there: {found}; install it, as by `apt install python3-slepc4py{}`, name its Python by --python, and where it is not in the usual place set PETSC_DIR and SLEPC_DIR",
        if *complex { "-complex" } else { "" }
    )]
    Missing { found: String, complex: bool },
    #[error(
        "`{launcher}` cannot be started: {error}; install MPI, as by `apt install openmpi-bin`, or name what starts processes by --launcher"
    )]
    Launcher { launcher: String, error: io::Error },
    #[error(
        "MPI refuses to run as root: run as another user, or set OMPI_ALLOW_RUN_AS_ROOT=1 and OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1"
    )]
    Root,
    #[error(
        "MPI has no room for {ranks} ranks: ask for fewer by --ranks, or allow more than there are cores, as by --launcher \"mpirun --oversubscribe\""
    )]
    Slots { ranks: u32 },
    #[error(
        "SLEPc took longer than the {limit} s allowed, and was ended: allow more by --time-limit, ask for fewer modes, or take more --ranks"
    )]
    TimeLimit { limit: f64 },
    #[error("SLEPc ended without an answer ({status}): {said}")]
    Ended { status: String, said: String },
    #[error("{}: cannot be written: {error}; name a directory with more room by --scratch", file.display())]
    Scratch { file: PathBuf, error: io::Error },
    #[error("the answer of SLEPc cannot be read: {problem}")]
    Answer { problem: String },
    #[error("SLEPc found no eigenpair: ask for others, or near another frequency")]
    Nothing,
}

/// A Python with slepc4py, and what it takes to find it.
struct Python {
    program: PathBuf,
    variables: Vec<(&'static str, OsString)>,
    complex: bool,
}

impl Slepc {
    /// Approximate eigenpairs of a system, some more than `count` nearest to a frequency, so that the last ones have
    /// neighbours.
    pub fn pairs(
        &self,
        system: &System,
        target: Frequency,
        count: usize,
    ) -> Result<Vec<Eigenpair>, SlepcError> {
        let target = target.radians_per_second();
        let structure = system.structure();
        let couples = !(structure.is_undamped() || structure.is_rayleigh());
        let progress = Progress::of("SLEPc");
        let python = self.find(couples && target > 0.0)?;
        let scratch = Scratch::within(self.scratch.as_deref())?;
        progress.say("SLEPc: writing the matrices");
        let mut named = Vec::new();
        for kind in [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness] {
            if kind == MatrixKind::Damping && !couples {
                continue;
            }
            let name = format!("{kind}.petsc");
            let matrix = SparseMatrixReport::of(system, kind);
            scratch.write(&name, |out| matrix.petsc(python.complex, out))?;
            named.push(format!("\"{kind}\": \"{name}\""));
        }
        let n = system.len();
        let request = format!(
            "{{\"matrices\": {{{}}}, \"target\": {target:?}, \"count\": {}, \"roots\": {}, \"tolerance\": 1e-12}}\n",
            named.join(", "),
            (count + 2).min(n),
            if target > 0.0 {
                count + 4
            } else {
                2 * count + 6
            }
            .min(2 * n),
        );
        scratch.write("request.json", |out| out.write_all(request.as_bytes()))?;
        scratch.write("slepc.py", |out| out.write_all(DRIVER.as_bytes()))?;
        progress.say(&format!("SLEPc on {} ranks", self.ranks));
        self.run(&python, &scratch)?;
        progress.say("SLEPc: reading the shapes");
        let pairs = answer(&scratch.directory.join("answer.bin"), n)?;
        match pairs.is_empty() {
            true => Err(SlepcError::Nothing),
            false => Ok(pairs),
        }
    }

    /// The first Python that has slepc4py, of complex numbers if it must.
    fn find(&self, complex: bool) -> Result<Python, SlepcError> {
        const SAY: &str = "import petsc4py; petsc4py.init(); from petsc4py import PETSc; import slepc4py; \
                           slepc4py.init(); from slepc4py import SLEPc; print('eigentone', PETSc.ScalarType(0).dtype.kind)";
        let programs = match &self.python {
            Some(named) => vec![named.clone()],
            None => vec![PathBuf::from("python3"), PathBuf::from("/usr/bin/python3")],
        };
        let mut said = Vec::new();
        for program in &programs {
            for variables in places(complex) {
                let mut probe = Command::new(program);
                probe.args(["-c", SAY]).envs(variables.iter().cloned());
                let output = match probe.stdin(Stdio::null()).output() {
                    Ok(output) => output,
                    Err(error) => {
                        said.push(format!("{}: {error}", program.display()));
                        break;
                    }
                };
                let kind = String::from_utf8_lossy(&output.stdout);
                let is_complex = kind.contains("eigentone c");
                let is_there = output.status.success() && kind.contains("eigentone ");
                if is_there && (is_complex || !complex) {
                    return Ok(Python {
                        program: program.clone(),
                        variables,
                        complex: is_complex,
                    });
                }
                let problem = match is_there {
                    true => {
                        "it has real numbers, and damped modes near a frequency take complex ones"
                            .to_owned()
                    }
                    false => last_line(&String::from_utf8_lossy(&output.stderr)),
                };
                said.push(format!("{}: {problem}", program.display()));
            }
        }
        said.dedup();
        let found = said.join("; ");
        Err(SlepcError::Missing { found, complex })
    }

    /// Starts the driver on every rank, and waits for it.
    fn run(&self, python: &Python, scratch: &Scratch) -> Result<(), SlepcError> {
        const LOOK: Duration = Duration::from_millis(20);
        let file = |name: &str| scratch.directory.join(name);
        let mut words = self.launcher.split_whitespace();
        let launcher = words.next().unwrap_or("mpirun").to_owned();
        let mut command = Command::new(&launcher);
        command
            .args(words)
            .args(["-n", &self.ranks.to_string()])
            .arg(&python.program)
            .arg(file("slepc.py"))
            .arg(&scratch.directory)
            .envs(python.variables.iter().cloned())
            // One thread for each rank, unless set otherwise.
            .env(
                "OMP_NUM_THREADS",
                std::env::var_os("OMP_NUM_THREADS").unwrap_or("1".into()),
            )
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let start = Instant::now();
        let started = interrupt::spawn(&mut command);
        let (child, said) = started.map_err(|error| SlepcError::Launcher { launcher, error })?;
        let said = heard(said);
        let status = loop {
            if let Some(status) = child.status() {
                break status;
            }
            if start.elapsed().as_secs_f64() > self.time_limit {
                child.end();
                let limit = self.time_limit;
                return Err(SlepcError::TimeLimit { limit });
            }
            std::thread::sleep(LOOK);
        };
        let answered = file("answer.bin").is_file();
        match status {
            Ok(status) if status.success() && answered => Ok(()),
            status => {
                // Who still says something after that does not matter.
                const PATIENCE: Duration = Duration::from_secs(2);
                let text = said.recv_timeout(PATIENCE).unwrap_or_default();
                Err(self.failure(&status, &text))
            }
        }
    }

    /// What went wrong, by what was said on standard error.
    fn failure(&self, status: &io::Result<ExitStatus>, text: &str) -> SlepcError {
        if text.contains("attempt to run as root") {
            return SlepcError::Root;
        }
        if text.contains("not enough slots") {
            return SlepcError::Slots { ranks: self.ranks };
        }
        let killed = text.contains("signal 9") || text.contains("Killed");
        let why = match killed {
            true => {
                "; where memory runs out ranks are killed: ask for fewer modes, or take more machines"
            }
            false => "",
        };
        let own = |line: &&str| line.starts_with("eigentone: ");
        let said = match text.lines().find(own) {
            Some(line) => line.trim_start_matches("eigentone: ").to_owned(),
            None => last_line(text),
        };
        SlepcError::Ended {
            status: match status {
                Ok(status) => status.to_string(),
                Err(error) => error.to_string(),
            },
            said: said + why,
        }
    }
}

/// What a process says, once it has ended; the beginning of much.
fn heard(said: Option<ChildStderr>) -> Receiver<String> {
    const MOST: u64 = 1 << 20;
    let (sender, receiver) = mpsc::channel();
    std::thread::spawn(move || {
        let mut text = Vec::new();
        if let Some(mut said) = said {
            let read = said.by_ref().take(MOST).read_to_end(&mut text);
            let _ = read.and_then(|_| io::copy(&mut said, &mut io::sink())); // what cannot be read says nothing
        }
        let _ = sender.send(String::from_utf8_lossy(&text).into_owned()); // nobody may wait for it
    });
    receiver
}

/// Where slepc4py may be: as it stands, or in one of Debian's directories.
fn places(complex: bool) -> Vec<Vec<(&'static str, OsString)>> {
    let mut all = vec![Vec::new()];
    let set = |name: &str| std::env::var_os(name).is_some();
    if set("PETSC_DIR") || set("SLEPC_DIR") {
        return all;
    }
    let ending = if complex { "-complex" } else { "-real" };
    let found = |root: &str| -> Vec<PathBuf> {
        let inner = |path: &Path| -> Vec<PathBuf> {
            let entries = fs::read_dir(path).into_iter().flatten().flatten();
            let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
            paths.sort();
            paths
        };
        let builds = inner(Path::new(root))
            .into_iter()
            .flat_map(|version| inner(&version));
        builds
            .filter(|path| path.to_string_lossy().ends_with(ending))
            .collect()
    };
    let (petsc, slepc) = (found("/usr/lib/petscdir"), found("/usr/lib/slepcdir"));
    for (petsc, slepc) in petsc.into_iter().zip(slepc).rev() {
        all.push(vec![
            ("PETSC_DIR", petsc.into_os_string()),
            ("SLEPC_DIR", slepc.into_os_string()),
        ]);
    }
    all
}

/// The last line with something in it, of ordinary length.
fn last_line(text: &str) -> String {
    const LONGEST: usize = 300;
    let lines = text.lines().map(str::trim);
    let mut lines = lines.filter(|line| line.chars().any(char::is_alphanumeric));
    let last = lines.next_back().unwrap_or("nothing was said");
    last.chars().take(LONGEST).collect()
}

/// A directory that is gone when it is dropped, or the program is interrupted.
struct Scratch {
    directory: PathBuf,
}

impl Scratch {
    fn within(parent: Option<&Path>) -> Result<Scratch, SlepcError> {
        let parent = parent.map_or_else(std::env::temp_dir, Path::to_owned);
        let since = std::time::UNIX_EPOCH.elapsed().unwrap_or_default();
        let name = format!("eigentone-{}-{}", std::process::id(), since.as_nanos());
        let directory = parent.join(name);
        match interrupt::create_directory(&directory) {
            Ok(()) => Ok(Scratch { directory }),
            Err(error) => Err(SlepcError::Scratch {
                file: directory,
                error,
            }),
        }
    }

    fn write(
        &self,
        name: &str,
        content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), SlepcError> {
        let file = self.directory.join(name);
        let write = || {
            let mut out = io::BufWriter::with_capacity(1 << 16, File::create(&file)?);
            content(&mut out)?;
            out.flush()
        };
        write().map_err(|error| SlepcError::Scratch { file, error })
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        interrupt::remove(&self.directory);
    }
}

/// The pairs in a file of the driver.
fn answer(file: &Path, n: usize) -> Result<Vec<Eigenpair>, SlepcError> {
    let wrong = |problem: String| SlepcError::Answer { problem };
    let failed = |error: io::Error| match error.kind() {
        io::ErrorKind::UnexpectedEof => wrong("it is cut off".to_owned()),
        _ => wrong(error.to_string()),
    };
    let mut bytes = BufReader::with_capacity(1 << 16, File::open(file).map_err(failed)?);
    let mut word = [0; 8];
    let mut next = move || bytes.read_exact(&mut word).map(|()| word);
    if &next().map_err(failed)? != MAGIC {
        return Err(wrong("it does not begin as one does".to_owned()));
    }
    let order = u64::from_le_bytes(next().map_err(failed)?);
    if order != n as u64 {
        return Err(wrong(format!(
            "its shapes have {order} entries instead of {n}"
        )));
    }
    let count = u64::from_le_bytes(next().map_err(failed)?);
    let mut pairs = Vec::new();
    for _ in 0..count {
        let parts = u64::from_le_bytes(next().map_err(failed)?);
        let mut number = || next().map(f64::from_le_bytes).map_err(failed);
        let value = Complex::new(number()?, number()?);
        let mut shape = vec![Complex::ZERO; n];
        for entry in &mut shape {
            entry.re = number()?;
        }
        if parts == 2 {
            for entry in &mut shape {
                entry.im = number()?;
            }
        }
        pairs.push(Eigenpair { value, shape });
    }
    Ok(pairs)
}
