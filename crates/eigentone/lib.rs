//! Exact analysis of linear vibrating systems.

#[cfg(feature = "gallery")]
pub mod gallery;
pub mod report;
pub mod scene;

pub use eigentone_check as check;
pub use eigentone_modes as modes;
pub use eigentone_response as response;
