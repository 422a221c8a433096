//! The instants t_k = k·step at which a response is asked for.

use super::error::ResponseError;

/// The largest number of steps a grid may have: beyond it k is no longer exact in a double.
pub const MAX_STEPS: u64 = 1 << 53;

/// Instants t_k = k·`step`, k = 0 … `last`; the product is exact and never accumulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeGrid {
    step: f64,
    last: u64,
}

impl TimeGrid {
    /// The grid from 0 to `end` s with spacing `step` s: `last` is the exact quotient end/step,
    /// rounded to nearest, halves up.
    ///
    /// # Errors
    /// [`ResponseError::Step`] unless step is finite and > 0, [`ResponseError::End`] unless end is
    /// finite and ≥ 0, [`ResponseError::TooManySteps`] above [`MAX_STEPS`], [`ResponseError::LastInstant`] where
    /// rounding up goes beyond the doubles.
    ///
    /// ```
    /// use eigentone_response::TimeGrid;
    /// let grid = TimeGrid::new(0.05, 50.0)?;
    /// assert_eq!(grid.last(), 1000);
    /// assert_eq!(grid.time(3), 3.0 * 0.05);
    /// # Ok::<(), eigentone_response::ResponseError>(())
    /// ```
    pub fn new(step: f64, end: f64) -> Result<TimeGrid, ResponseError> {
        if !step.is_finite() || step <= 0.0 {
            return Err(ResponseError::Step { step });
        }
        if !end.is_finite() || end < 0.0 {
            return Err(ResponseError::End { end });
        }
        if end / step > MAX_STEPS as f64 {
            return Err(ResponseError::TooManySteps { step, end });
        }
        // The remainder of two doubles is exact, so the halfway case is decided exactly.
        let remainder = end % step;
        let whole = ((end - remainder) / step).round() as u64;
        let last = if remainder >= step - remainder {
            whole + 1
        } else {
            whole
        };
        if last > MAX_STEPS {
            return Err(ResponseError::TooManySteps { step, end });
        }
        if !(last as f64 * step).is_finite() {
            let steps = last;
            return Err(ResponseError::LastInstant { step, steps });
        }
        Ok(TimeGrid { step, last })
    }

    /// The same instants until another index, up to [`MAX_STEPS`].
    pub(super) fn until(self, last: u64) -> TimeGrid {
        TimeGrid { last, ..self }
    }

    /// The spacing in s.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// The index N of the last instant.
    pub fn last(&self) -> u64 {
        self.last
    }

    /// The double nearest to t_k = k·step.
    pub fn time(&self, index: u64) -> f64 {
        index as f64 * self.step
    }
}
