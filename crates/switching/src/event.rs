//! What happens between linear motions.

use std::fmt;

/// A change of a switch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// In s.
    pub time: f64,
    /// How far the time may be off, in s: proven or estimated, as the motion's bounds are.
    pub bound: f64,
    /// The switch, by its place among those given.
    pub switch: usize,
    /// What happens.
    pub kind: EventKind,
}

/// What happens to a switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// A friction comes to hold.
    Stick,
    /// A friction begins to slide, or slides the other way.
    Slip,
    /// A stop is touched, or an impact's bounces have died out.
    Contact,
    /// A stop or a contact is left.
    Release,
    /// A rigid stop is hit.
    Impact,
    /// A controlled damper takes another law.
    Switch,
}

impl fmt::Display for EventKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            EventKind::Stick => "stick",
            EventKind::Slip => "slip",
            EventKind::Contact => "contact",
            EventKind::Release => "release",
            EventKind::Impact => "impact",
            EventKind::Switch => "switch",
        })
    }
}
