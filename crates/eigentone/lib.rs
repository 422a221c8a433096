//! Exact analysis of linear vibrating systems.

pub mod scene;

pub use eigentone_check as check;
pub use eigentone_modes as modes;
pub use eigentone_response as response;
