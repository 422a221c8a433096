//! Points and supports, beams and rods, damping in proportion and by ratios, and kinds of coordinate.

mod beams;
mod damping;
mod errors;
mod forms;
mod kinds;
