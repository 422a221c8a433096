//! How long something takes.

use std::hint::black_box;
use std::time::Instant;

use eigentone_digits::sort_by_number;

/// Run times of the same computation, repeated, in s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunTime {
    /// The median.
    pub median: f64,
    /// The lower and the upper quartile.
    pub quartiles: [f64; 2],
    /// The shortest.
    pub min: f64,
    /// The longest.
    pub max: f64,
    /// How many runs were timed.
    pub runs: usize,
}

impl RunTime {
    /// Runs once to warm up, then at least 5 times and for 20 ms, but no longer than 0.2 s. Where
    /// the first run takes that long by itself, it is the one that counts.
    pub(crate) fn of<T, E>(mut run: impl FnMut() -> Result<T, E>) -> Result<(T, RunTime), E> {
        const LEAST: (usize, f64) = (5, 0.02);
        const MOST: f64 = 0.2;
        let mut timed = || {
            let start = Instant::now();
            let result = black_box(run());
            result.map(|result| (result, start.elapsed().as_secs_f64()))
        };
        let (result, first) = timed()?;
        let mut times = Vec::new();
        let mut spent = 0.0;
        if first >= MOST {
            times.push(first);
            spent = first;
        }
        while spent < MOST && (times.len() < LEAST.0 || spent < LEAST.1) {
            let (_, time) = timed()?;
            times.push(time);
            spent += time;
        }
        sort_by_number(&mut times, |time| *time);
        let time = RunTime {
            median: times[times.len() / 2],
            quartiles: [times[times.len() / 4], times[3 * times.len() / 4]],
            min: times[0],
            max: times[times.len() - 1],
            runs: times.len(),
        };
        Ok((result, time))
    }
}
