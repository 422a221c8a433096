//! Answers as text tables, JSON, CSV, Markdown and plots.
//!
//! Nothing here computes: a report borrows an answer and writes it down. Tables are for people,
//! with six significant digits and units in their headers; JSON and CSV have all digits.

mod analysis;
mod axis;
mod campbell;
#[cfg(feature = "check")]
mod check;
mod columns;
pub(crate) mod csv;
mod cycle;
mod demands;
mod energy;
mod events;
mod frequency;
mod front;
#[cfg(feature = "check")]
mod heat_map;
mod map;
mod modes;
mod number;
mod outline;
mod page;
mod participation;
mod plot;
mod random;
mod response;
mod sparse_matrix;
mod spectrum;
#[cfg(feature = "check")]
mod stability;
mod state_space;
mod steady_state;
mod sweep;
mod switched;
pub(crate) mod table;
mod thinned;
pub(crate) mod unit;

use eigentone_modes::Bounds;

pub use analysis::{Analysis, Answer, MOST_PARTICIPATING};
pub use axis::{Axis, Scale};
pub use campbell::CampbellReport;
#[cfg(feature = "check")]
pub use check::CheckReport;
pub use columns::motion_columns;
pub use cycle::CycleReport;
pub use demands::{DemandReport, MOST_DEMANDS};
pub use energy::EnergyReport;
pub use events::events_csv;
pub use frequency::FrequencyReport;
pub use front::{FrontDesign, FrontReport};
pub use modes::ModeReport;
pub use number::significant;
pub use page::Page;
pub use plot::{Line, Plot, Ring};
pub use random::RandomReport;
pub use response::ResponseReport;
pub use sparse_matrix::SparseMatrixReport;
pub use spectrum::SpectrumReport;
#[cfg(feature = "check")]
pub use stability::StabilityReport;
pub use state_space::StateSpaceReport;
pub use sweep::{SweepReport, SweepTable, SweptDesign};
pub use switched::SwitchedReport;
pub use unit::Units;

/// What bounds are worth, as JSON says it.
fn worth(bounds: Bounds) -> &'static str {
    match bounds {
        Bounds::Proven => "proven",
        Bounds::Estimated => "estimated",
    }
}
