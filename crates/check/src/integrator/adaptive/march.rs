//! The steps of a method through one stretch after the other, as the tolerance lets them be.

use eigentone_response::ResponseError;

use super::super::course::{Recorder, Stretch};
use super::super::limit::Meter;
use super::super::{Basis, Limit, Prediction};
use super::scale::Scale;
use super::{Allowed, Passage};

/// How far a method has come.
pub(super) struct March {
    pub(super) tolerance: f64,
    pub(super) last_step: Option<f64>,
    pub(super) accepted: u64,
    pub(super) rejected: u64,
    pub(super) meter: Meter,
    scale: Scale,
    /// The time in s that the steps have come to, and had come to with half of those allowed.
    reached: f64,
    halfway: f64,
}

impl March {
    pub(super) fn with(tolerance: f64, limit: Limit) -> March {
        March {
            tolerance,
            last_step: None,
            accepted: 0,
            rejected: 0,
            meter: Meter::start(limit),
            scale: Scale::default(),
            reached: 0.0,
            halfway: 0.0,
        }
    }

    /// What is allowed at the start of a stretch, where this acceleration in m/s² acts for at least
    /// so many s.
    pub(super) fn begin(&mut self, state: &[f64], acceleration: f64, time: f64) -> Allowed {
        self.scale.include(state);
        self.scale.include_acceleration(acceleration, time);
        self.scale.allowed(self.tolerance)
    }

    /// Leads a method through a stretch, past the stops after its start.
    pub(super) fn lead(
        &mut self,
        passage: &mut dyn Passage,
        stretch: &Stretch<'_>,
        stops: &[u64],
        recorder: &mut Recorder,
        stopped: impl Fn(String) -> ResponseError + Copy,
    ) -> Result<(), ResponseError> {
        let (start, length) = (stretch.start(), stretch.length());
        let after = |index: &u64| stretch.elapsed(&stretch.stop(*index));
        let mut stops = stops.iter().copied().peekable();
        let mut between = passage.state().to_vec();
        loop {
            let wanted = passage.wanted();
            let left = length - passage.elapsed();
            // So short a rest changes nothing, and the solver takes it for a breakdown.
            if left <= 1e-13 * wanted {
                break;
            }
            self.meter.step().map_err(stopped)?;
            let allowed = self.scale.allowed(self.tolerance);
            let taken = passage.attempt(left, allowed).map_err(|reason| {
                let at = start + passage.elapsed();
                stopped(format!("{reason} at {at} s"))
            })?;
            if !taken {
                self.rejected += 1;
                continue;
            }
            self.accepted += 1;
            self.last_step = Some(match wanted >= left {
                true => wanted.max(passage.wanted()),
                false => passage.wanted(),
            });
            self.reached = start + passage.elapsed();
            if self.meter.is_in_first_half() {
                self.halfway = self.reached;
            }
            self.scale.include(passage.state());
            let within = |index: &u64| after(index) < passage.elapsed();
            if !stops.peek().is_some_and(within) {
                continue;
            }
            passage.look_back();
            while let Some(index) = stops.next_if(|index| after(index) < passage.elapsed()) {
                passage
                    .between(after(&index), &mut between)
                    .map_err(stopped)?;
                recorder.record(index, &between)?;
            }
        }
        for index in stops {
            recorder.record(index, passage.state())?;
        }
        Ok(())
    }

    /// What is foreseen, where the steps allowed did not reach the end.
    pub(super) fn extended(&self, end: f64, longest_step: f64) -> Prediction {
        let steps = self.meter.steps();
        let left = end - self.reached;
        let pace = (self.reached - self.halfway) / (steps / 2) as f64;
        let as_before = left / pace.max(f64::MIN_POSITIVE);
        let stable = left / longest_step;
        // Rejected steps, and those cut short at a break, make it a little more than stable.
        let (more, basis) = match stable >= 0.9 * as_before {
            true => (stable.max(as_before), Basis::Stability),
            false => (as_before, Basis::Accuracy),
        };
        Prediction {
            steps: steps as f64 + more,
            basis,
        }
    }
}
