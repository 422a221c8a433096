//! What the machine is called.

use std::fs;
use std::thread;

/// Processor, cores that may be used, and operating system, as far as they can be determined.
pub fn name() -> String {
    let cores = thread::available_parallelism().map_or(1, |count| count.get());
    let system = std::env::consts::OS;
    let architecture = std::env::consts::ARCH;
    let processor = processor().unwrap_or_else(|| "a processor of unknown name".to_owned());
    format!("{processor}, {cores} cores, {architecture} {system}")
}

/// The model, where the system lists it in a file.
fn processor() -> Option<String> {
    let list = fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = list.lines().find(|line| line.starts_with("model name"))?;
    let (_, model) = line.split_once(':')?;
    Some(model.trim().to_owned())
}
