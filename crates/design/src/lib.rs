//! Design studies of linear vibrating systems: which designs a study looks at, and which root of one design is which of the
//! next.
//!
//! A [`Grid`] numbers the designs of one or several [`Range`]s, and its parts. A [`Follower`] keeps every root at one place
//! along a path of designs: through crossings, through veerings, and where a pair meets on the real axis. [`Campbell`] follows the modes of a
//! rotor along its speed, and encloses its critical speeds.
//! [`minimise`] finds where the largest of several functions is least, and shows that it is.
//! [`front`] finds designs between the best of two aims.
//! [`fit`] finds parameters from measurements, and how well these determine them.
//! Nothing here prints or reads files.

mod campbell;
mod difference;
mod fit;
mod follower;
mod front;
mod grid;
mod minimax;
mod programme;
mod range;

pub use campbell::{Branch, Campbell, CampbellDiagram, CampbellError, CriticalSpeed, Whirl};
pub use difference::{difference, spaced};
pub use fit::{Fit, FitError, fit, fit_with};
pub use follower::{FollowError, Followed, Follower};
pub use front::{FrontPoint, front, front_with};
pub use grid::{Grid, GridError};
pub use minimax::{Optimum, OptimumError, Piece, minimise, minimise_with};
pub use range::{Range, RangeError};
