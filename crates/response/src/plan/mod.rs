//! Which method answers, and the short way to ask. It knows `problem`, `answer`, `march` and `certified`.

mod choice;
mod follow;
mod modal_truncation;
mod response;

pub use choice::{ResponsePlan, methods};
pub use modal_truncation::ModalTruncation;
pub use response::Response;
