//! The exact motion of vibrating systems that are linear between events: Coulomb friction, stops, impacts and switched dampers.
//!
//! Between two events the motion is that of a linear system and known exactly. An event is a root of a linear function of the
//! state, isolated on the exact motion, so that none is missed, and known to all digits. Bounds are carried through events.
//!
//! ```
//! use eigentone_modes::{GROUND, System};
//! use eigentone_response::{Response, State};
//! use eigentone_switching::{EventKind, Friction, Switch, Switching};
//!
//! // A mass on a spring and a rough table: each half swing loses 2 F/k.
//! let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 4.0).build()?;
//! let from = State::at_rest().displace("m", 1.0);
//! let problem = Response::of(&system).from(from).every(0.01).until(7.0).problem()?;
//! let friction = Friction {
//!     between: [GROUND.to_owned(), "m".to_owned()],
//!     force: 0.5,
//!     static_force: 0.5,
//! };
//! let motion = Switching::new(&problem, vec![Switch::Friction(friction)])?.run()?;
//! let last = motion.events().last().expect("it comes to rest");
//! assert_eq!(last.kind, EventKind::Stick);
//! // After 4 half swings of π/2 s each.
//! assert!((last.time - 2.0 * std::f64::consts::PI).abs() < 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod change;
mod collapse;
mod configuration;
mod cycle;
mod cycle_error;
mod error;
mod error_set;
mod event;
mod losses;
mod march;
mod outputs;
mod passage;
mod peaks;
mod phase;
mod root;
mod rows;
mod series;
mod settle;
mod switch;
mod switching;
mod together;

pub use cycle::{LimitCycle, Period};
pub use cycle_error::CycleError;
pub use error::SwitchingError;
pub use event::{Event, EventKind};
pub use losses::Losses;
pub use peaks::SwitchedPeaks;
pub use switch::{ControlledDamper, DamperLaw, Friction, Impact, Stop, Switch, SwitchFault};
pub use switching::{SwitchedMotion, Switching};
