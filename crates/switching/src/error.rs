//! Why there is no motion.

use std::fmt::Display;

use eigentone_response::ResponseError;
use thiserror::Error;

use crate::switch::SwitchFault;

/// Why there is no motion with switches.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SwitchingError {
    /// A switch is wrong by itself.
    #[error("switch {switch}: {fault}")]
    Switch {
        /// Its place among those given.
        switch: usize,
        /// What is wrong.
        fault: SwitchFault,
    },
    /// The motion between events cannot be computed.
    #[error(transparent)]
    Response(#[from] ResponseError),
    /// What happens next is not decided by the numbers given.
    #[error("at t = {time:?} s it cannot be determined what switch {switch} does next: {reason}")]
    Undecided {
        /// In s.
        time: f64,
        /// Its place among those given.
        switch: usize,
        /// Why.
        reason: &'static str,
    },
    /// Rigid stops, or dampers that hold a body still, hold the same motion, so that their forces are not unique.
    #[error(
        "at t = {time:?} s switch {switch} holds what others hold already, so that its force is not determined: leave one of them out"
    )]
    Dependent {
        /// In s.
        time: f64,
        /// Its place among those given.
        switch: usize,
    },
    /// What is between two rigid stops has no room left, and neither gives way.
    #[error(
        "at t = {time:?} s switch {switch} and another rigid stop come together and jam what is between them: let their supports leave it room, or make one of them a stop with a stiffness"
    )]
    Jammed {
        /// In s.
        time: f64,
        /// Its place among those given.
        switch: usize,
    },
    /// Events come ever more quickly.
    #[error(
        "{events} events came before t = {time:?} s, ever closer together, the last of switch {switch}: ask for less time or, where bounces die out slowly, take a smaller restitution"
    )]
    Endless {
        /// How many.
        events: usize,
        /// In s.
        time: f64,
        /// Its place among those given.
        switch: usize,
    },
    /// The motion is too quick beside the time asked for.
    #[error(
        "it would take {} more short steps, as the quickest motion is of {} rad/s: ask for less time or take softer springs",
        shown(*steps, 0),
        shown(*rate, 1)
    )]
    TooLong {
        /// How many.
        steps: f64,
        /// In rad/s.
        rate: f64,
    },
    /// Rates leave the range of doubles.
    #[error(
        "forces beside masses leave the range of doubles: choose other units, or fewer orders of magnitude"
    )]
    OutOfRange,
    /// The digits do not suffice to divide by the masses.
    #[error(
        "no number of digits in reach distinguishes a matrix to be divided by from a singular one"
    )]
    Stuck,
}

impl SwitchingError {
    /// The switch that it is about, by its place among those given.
    pub fn switch(&self) -> Option<usize> {
        match self {
            SwitchingError::Switch { switch, .. }
            | SwitchingError::Undecided { switch, .. }
            | SwitchingError::Dependent { switch, .. }
            | SwitchingError::Jammed { switch, .. }
            | SwitchingError::Endless { switch, .. } => Some(*switch),
            _ => None,
        }
    }

    /// The message with the name of the switch in place of its number; `names` are those of all switches, in order.
    pub fn with_names(&self, names: &[String]) -> String {
        named(self, self.switch(), names)
    }
}

/// A message about "switch 0" with the name of that.
pub(crate) fn named(error: &impl Display, switch: Option<usize>, names: &[String]) -> String {
    let text = error.to_string();
    match switch.and_then(|switch| names.get(switch).map(|name| (switch, name))) {
        Some((switch, name)) => text.replacen(&format!("switch {switch}"), name, 1),
        None => text,
    }
}

fn shown(number: f64, decimals: usize) -> String {
    match number.is_finite() {
        true => format!("about {number:.decimals$e}"),
        false => "over 1e308".to_owned(),
    }
}
