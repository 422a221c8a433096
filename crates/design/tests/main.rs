//! Studies of designs from outside.
//!
//! They are one program, which takes less time to build than one of each file.

mod campbell;
mod fit;
mod follower;
mod random;
