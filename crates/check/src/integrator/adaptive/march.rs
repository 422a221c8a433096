//! The steps of a method through one stretch after the other, as the tolerance lets them be.

use eigentone_response::ResponseError;

use super::super::course::{Recorder, Stretch};
use super::super::limit::Meter;
use super::super::{Limit, Prediction};
use super::outlook::Outlook;
use super::scale::Scale;
use super::{Allowed, Passage};

/// How far a method has come.
pub(super) struct March {
    pub(super) tolerance: f64,
    pub(super) last_step: Option<f64>,
    pub(super) accepted: u64,
    pub(super) rejected: u64,
    pub(super) meter: Meter,
    pub(super) outlook: Outlook,
    scale: Scale,
}

impl March {
    pub(super) fn with(tolerance: f64, longest_step: f64, limit: Limit) -> March {
        March {
            tolerance,
            last_step: None,
            accepted: 0,
            rejected: 0,
            meter: Meter::start(limit),
            outlook: Outlook::with(longest_step),
            scale: Scale::default(),
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
            let (wanted, before) = (passage.wanted(), passage.elapsed());
            let left = length - before;
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
            self.outlook.see(wanted, passage.elapsed() - before);
            if self.meter.is_in_first_half() {
                self.outlook.note();
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
        self.outlook.pass_break();
        for index in stops {
            recorder.record(index, passage.state())?;
        }
        Ok(())
    }

    /// What is foreseen for the whole way, which may not have been gone to its end.
    pub(super) fn foreseen(&self, end: f64) -> Prediction {
        let tried = (self.accepted + self.rejected) as f64;
        let foreseen = self.outlook.foreseen(end);
        Prediction {
            steps: foreseen.steps * tried / (self.accepted as f64).max(1.0),
            ..foreseen
        }
    }
}
