//! Points and supports, beams and rods, damping in proportion and by ratios, kinds of coordinate, and scales far apart.

mod beams;
mod damping;
mod errors;
mod forms;
mod kinds;
mod scales;
