//! How far an integrator may go.

use std::time::{Duration, Instant};

/// How far an integrator may go before it stops with
/// [`ResponseError::Stopped`](eigentone_response::ResponseError::Stopped).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limit {
    /// The most steps it may try.
    pub steps: u64,
    /// The longest time it may run, if there is one.
    pub time: Option<Duration>,
}

impl Default for Limit {
    /// A million steps, however long they take.
    fn default() -> Limit {
        Limit {
            steps: 1_000_000,
            time: None,
        }
    }
}

/// Counts steps against a limit.
pub(crate) struct Meter {
    limit: Limit,
    started: Instant,
    steps: u64,
}

impl Meter {
    pub(crate) fn start(limit: Limit) -> Meter {
        Meter {
            limit,
            started: Instant::now(),
            steps: 0,
        }
    }

    /// The steps counted.
    pub(crate) fn steps(&self) -> u64 {
        self.steps
    }

    /// Whether it allows at least as many more.
    pub(super) fn is_in_first_half(&self) -> bool {
        self.steps <= self.limit.steps / 2
    }

    /// Counts one more step, or says that it is one too many.
    pub(crate) fn step(&mut self) -> Result<(), String> {
        /// Reading the clock costs as much as a small step.
        const STEPS_BETWEEN_READINGS: u64 = 64;
        if self.steps == self.limit.steps {
            return Err(format!(
                "it reached its limit of steps, {}",
                self.limit.steps
            ));
        }
        self.steps += 1;
        match self.limit.time {
            Some(time)
                if self.steps.is_multiple_of(STEPS_BETWEEN_READINGS)
                    && self.started.elapsed() > time =>
            {
                Err(format!("{:.1} s did not suffice", time.as_secs_f64()))
            }
            _ => Ok(()),
        }
    }
}
