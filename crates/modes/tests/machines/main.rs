//! Points and supports: linear forms in place of coordinates at the ends of elements.

mod errors;
mod forms;
