//! What is read off a motion: extrema, settling, energies, forces in elements. It knows `problem`, `answer`
//! and `certified`, which follows a motion between its instants.

mod afterwards;
mod element_force;
mod energy;
mod extrema;
mod later;
mod persistence;
mod summary;

pub use element_force::ElementForces;
pub use energy::Energy;
pub use extrema::{Discontinuity, Extrema, Extremum, Fastest, Jump, Peaks, Reached};
pub use summary::{CombinationRest, CoordinateSummary, Destination, Summary};
