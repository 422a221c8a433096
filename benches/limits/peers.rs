//! Times of SciPy, measured by `benches/peers.py` in the same run.

use std::collections::HashMap;
use std::path::Path;
use std::process::Command;

/// Times in µs by name; empty unless `PEERS_PYTHON` names a Python with NumPy and SciPy.
pub struct Peers {
    times: HashMap<String, f64>,
}

impl Peers {
    /// Of these sections of the script.
    pub fn measure(once: bool, sections: &[&str]) -> Peers {
        let times = match std::env::var_os("PEERS_PYTHON") {
            Some(python) if !once && !sections.is_empty() => {
                let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/peers.py");
                let output = Command::new(python)
                    .arg(script)
                    .args(sections)
                    .env("OPENBLAS_NUM_THREADS", "1")
                    .output()
                    .expect("PEERS_PYTHON runs");
                let text = String::from_utf8_lossy(&output.stdout).into_owned();
                text.lines()
                    .filter_map(|line| {
                        let (name, time) = line.rsplit_once(' ')?;
                        Some((name.trim().to_owned(), time.parse().ok()?))
                    })
                    .collect()
            }
            _ => HashMap::new(),
        };
        Peers { times }
    }

    /// The time by this name, and how many times `ours` fits into it, as text.
    pub fn beside(&self, name: &str, ours: f64) -> String {
        match self.times.get(name) {
            Some(time) => format!("{time:>10.2} {:>6.1}×", time / ours),
            None => format!("{:>10} {:>7}", "–", "–"),
        }
    }
}
