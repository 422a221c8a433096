//! Which of its linear laws a switch follows.

/// The law that a switch follows at present. Signs are 1 or −1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Phase {
    /// Friction that holds v = 0.
    Stick,
    /// Friction against a v of this sign.
    Slip(i8),
    /// Friction whose ends others hold, with no force, or with all that it has against this sign.
    Idle(i8),
    /// A stop that is not touched.
    Open,
    /// A stop that pushes back.
    Closed,
    /// A rigid stop that is not pressed.
    Free,
    /// A rigid stop that holds x.
    Contact,
    /// An on-off damper, by the signs of v_b and v; 0 of what stays 0.
    OnOff { body: i8, rate: i8 },
    /// An on-off damper that holds v_b = 0, as neither damping keeps its sign; by the sign of v.
    Hold { rate: i8 },
    /// A clipped damper, by the signs of sky·v_b − low·v, sky·v_b − high·v and v.
    Clipped { low: i8, high: i8, rate: i8 },
}

/// What a damper does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Setting {
    Low,
    High,
    Sky,
    Hold,
}

impl Phase {
    /// What a damper does in this phase; `None` of other elements.
    pub(crate) fn setting(self) -> Option<Setting> {
        match self {
            Phase::OnOff { body, rate } if body * rate > 0 => Some(Setting::High),
            Phase::OnOff { .. } => Some(Setting::Low),
            Phase::Hold { .. } => Some(Setting::Hold),
            Phase::Clipped { low, high, rate } => Some(match (rate * low > 0, rate * high > 0) {
                (false, _) => Setting::Low,
                (true, false) => Setting::Sky,
                (true, true) => Setting::High,
            }),
            _ => None,
        }
    }

    /// Whether it holds a relation of the motion, by whatever force that takes.
    pub(crate) fn holds(self) -> bool {
        matches!(self, Phase::Stick | Phase::Contact | Phase::Hold { .. })
    }
}
