//! Elements that are linear between events.

use eigentone_modes::{Form, GROUND, System};
use thiserror::Error;

/// An element between two names a and b (coordinates, points, supports or the ground) that is linear between events. Its
/// stretch is x = x_b − x_a, its rate v = v_b − v_a.
#[derive(Clone, Debug, PartialEq)]
pub enum Switch {
    /// See [`Friction`].
    Friction(Friction),
    /// See [`Stop`].
    Stop(Stop),
    /// See [`Impact`].
    Impact(Impact),
    /// See [`ControlledDamper`].
    ControlledDamper(ControlledDamper),
}

/// Coulomb friction: while a and b slide it acts against v with a constant force; while they stick it holds v = 0 with
/// whatever force that takes, up to the static one.
#[derive(Clone, Debug, PartialEq)]
pub struct Friction {
    /// a and b.
    pub between: [String; 2],
    /// The force while sliding, in N; ≥ 0.
    pub force: f64,
    /// The largest force while sticking, in N; at least `force`.
    pub static_force: f64,
}

/// A stop: pushes back with stiffness·(x − gap) + damping·v while x > gap.
#[derive(Clone, Debug, PartialEq)]
pub struct Stop {
    /// a and b.
    pub between: [String; 2],
    /// The stretch from which on it acts, in m; negative where it is pressed at x = 0.
    pub gap: f64,
    /// In N/m; ≥ 0.
    pub stiffness: f64,
    /// In N·s/m; ≥ 0.
    pub damping: f64,
}

/// A rigid stop at x = gap: when x reaches it with v > 0, an impulse between a and b turns v round, times the restitution.
/// What no longer bounces stays in contact while it is pressed.
#[derive(Clone, Debug, PartialEq)]
pub struct Impact {
    /// a and b.
    pub between: [String; 2],
    /// The largest stretch, in m.
    pub gap: f64,
    /// From 0 to 1.
    pub restitution: f64,
}

/// A damper that is switched by the motion.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlledDamper {
    /// a, and b, the body that is to be kept calm.
    pub between: [String; 2],
    /// The least damping, in N·s/m; ≥ 0.
    pub low: f64,
    /// The largest damping, in N·s/m; at least `low`.
    pub high: f64,
    /// When it takes which (Karnopp, Crosby & Harwood, J. Eng. Ind. 96, 1974).
    pub law: DamperLaw,
}

/// How a [`ControlledDamper`] is switched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DamperLaw {
    /// `high` while v_b·v > 0, else `low`.
    OnOffSkyhook,
    /// The force sky·v_b of a damper between b and the sky, kept between `low`·v and `high`·v.
    ClippedSkyhook {
        /// In N·s/m; ≥ 0.
        sky: f64,
    },
}

/// What is wrong with a [`Switch`].
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SwitchFault {
    /// An end is no known name.
    #[error("{name:?} is neither a coordinate nor a point nor a support nor the ground")]
    UnknownName {
        /// The name given.
        name: String,
    },
    /// Both ends move alike, so that nothing is between them.
    #[error("{first:?} and {second:?} move as one: an element between them does nothing")]
    NoStretch {
        /// a.
        first: String,
        /// b.
        second: String,
    },
    /// A number is out of its range.
    #[error("{what} is {value:?}: it must be {range}")]
    Number {
        /// Which number.
        what: &'static str,
        /// The number given.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// A force on it displaces something at once.
    #[error(
        "a force between {first:?} and {second:?} moves something that has no mass: give every coordinate at its ends a mass"
    )]
    Massless {
        /// a.
        first: String,
        /// b.
        second: String,
    },
    /// It is beyond its gap at the start, or after a support has jumped.
    #[error(
        "at t = {time:?} s the stretch is {stretch:?} m, beyond the gap of {gap:?} m: start at the gap or before it, and let no support jump beyond it"
    )]
    BeyondGap {
        /// In s.
        time: f64,
        /// In m.
        stretch: f64,
        /// In m.
        gap: f64,
    },
}

impl Switch {
    /// a and b.
    pub fn between(&self) -> &[String; 2] {
        match self {
            Switch::Friction(friction) => &friction.between,
            Switch::Stop(stop) => &stop.between,
            Switch::Impact(impact) => &impact.between,
            Switch::ControlledDamper(damper) => &damper.between,
        }
    }

    /// Whether it makes sense in a system.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn check(&self, system: &System) -> Result<(), SwitchFault> {
        self.forms(system).map(drop)
    }

    /// The stretch x_b − x_a and the displacement of b.
    pub(crate) fn forms(&self, system: &System) -> Result<[Form; 2], SwitchFault> {
        self.check_numbers()?;
        let [first, second] = self.between();
        let form = |name: &String| {
            let known = if name == GROUND {
                Some(Form::default())
            } else {
                system.form(name)
            };
            known.ok_or_else(|| SwitchFault::UnknownName { name: name.clone() })
        };
        let (a, b) = (form(first)?, form(second)?);
        let difference = |b: &[(usize, f64)], a: &[(usize, f64)]| {
            let mut sum: Vec<(usize, f64)> = b.to_vec();
            for &(index, factor) in a {
                match sum
                    .iter()
                    .position(|(known, other)| *known == index && *other == factor)
                {
                    Some(at) => drop(sum.swap_remove(at)),
                    None => sum.push((index, -factor)),
                }
            }
            sum
        };
        let stretch = Form {
            coordinates: difference(&b.coordinates, &a.coordinates),
            supports: difference(&b.supports, &a.supports),
        };
        if stretch.coordinates.is_empty() {
            let [first, second] = self.between().clone();
            return Err(SwitchFault::NoStretch { first, second });
        }
        Ok([stretch, b])
    }

    fn check_numbers(&self) -> Result<(), SwitchFault> {
        let at_least =
            |what, value: f64, least: f64, range| match value.is_finite() && value >= least {
                true => Ok(()),
                false => Err(SwitchFault::Number { what, value, range }),
            };
        const POSITIVE: &str = "a finite number, 0 or more";
        match self {
            Switch::Friction(Friction {
                force,
                static_force,
                ..
            }) => {
                at_least("force", *force, 0.0, POSITIVE)?;
                at_least(
                    "static force",
                    *static_force,
                    *force,
                    "a finite number, not below the force while sliding",
                )
            }
            Switch::Stop(Stop {
                gap,
                stiffness,
                damping,
                ..
            }) => {
                at_least("gap", *gap, f64::MIN, "a finite number")?;
                at_least("stiffness", *stiffness, 0.0, POSITIVE)?;
                at_least("damping", *damping, 0.0, POSITIVE)
            }
            Switch::Impact(Impact {
                gap, restitution, ..
            }) => {
                at_least("gap", *gap, f64::MIN, "a finite number")?;
                const RANGE: &str = "a number from 0 to 1";
                at_least("restitution", *restitution, 0.0, RANGE)?;
                at_least("restitution", -*restitution, -1.0, RANGE).map_err(|_| {
                    SwitchFault::Number {
                        what: "restitution",
                        value: *restitution,
                        range: RANGE,
                    }
                })
            }
            Switch::ControlledDamper(ControlledDamper { low, high, law, .. }) => {
                at_least("low", *low, 0.0, POSITIVE)?;
                at_least(
                    "high",
                    *high,
                    *low,
                    "a finite number, not below the low one",
                )?;
                match law {
                    DamperLaw::OnOffSkyhook => Ok(()),
                    DamperLaw::ClippedSkyhook { sky } => at_least("sky", *sky, 0.0, POSITIVE),
                }
            }
        }
    }
}
