//! How many steps an integration takes, predicted from longer steps, or from steps that did not reach its end.

use super::super::{Basis, Prediction};

/// Predicts from the steps taken so far those that a stricter tolerance would take.
pub(super) struct Outlook {
    /// What accuracy would shorten the steps by.
    pub(super) factor: f64,
    longest_step: f64,
    /// Foreseen for the stretches passed, and for the one under way.
    passed: f64,
    here: f64,
    /// How far the steps have come, in s.
    reached: f64,
    /// How far they had come at the middle of a trial, in s, and what was foreseen for that.
    halfway: (f64, f64),
}

impl Outlook {
    pub(super) fn with(longest_step: f64) -> Outlook {
        Outlook {
            factor: 1.0,
            longest_step,
            passed: 0.0,
            here: 0.0,
            reached: 0.0,
            halfway: (0.0, 0.0),
        }
    }

    /// Takes in a step, which wanted to be so long and was, up to a break.
    pub(super) fn see(&mut self, wanted: f64, taken: f64) {
        // What is as long as stability allows may remain so, or be shortened all the same.
        let length = match wanted < 0.99 * self.longest_step {
            true => wanted * self.factor,
            false => self.longest_step * self.factor.sqrt(),
        };
        self.here += taken / length;
        self.reached += taken;
    }

    /// Notes the middle of a trial.
    pub(super) fn note(&mut self) {
        self.halfway = (self.reached, self.passed + self.here);
    }

    /// Every stretch takes whole steps.
    pub(super) fn pass_break(&mut self) {
        self.passed += self.here.ceil();
        self.here = 0.0;
    }

    /// The mean length of what is foreseen since the middle of the trial, in s.
    fn length(&self) -> f64 {
        let steps = self.passed + self.here - self.halfway.1;
        (self.reached - self.halfway.0) / steps
    }

    /// How many times longer steps may become until stability limits them.
    pub(super) fn freedom(&self) -> f64 {
        self.longest_step / self.length()
    }

    /// What is foreseen up to `end` s: from where the steps have come to, as since the middle of the
    /// trial.
    pub(super) fn foreseen(&self, end: f64) -> Prediction {
        let so_far = self.passed + self.here;
        let left = (end - self.reached).max(0.0);
        let rest = if left > 1e-9 * end {
            left / self.length()
        } else {
            0.0
        };
        let steps = so_far + rest;
        // Rejected steps, and those cut short at a break, make it a little more than stable.
        let basis = match 0.9 * steps <= end / self.longest_step {
            true => Basis::Stability,
            false => Basis::Accuracy,
        };
        Prediction { steps, basis }
    }
}
