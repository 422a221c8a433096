//! Reference tables: modes and motions to 15 significant digits, every one of which is right.
//!
//! The numbers come from the reference in [`check`](crate::check), which encloses each in a proven
//! radius. A number is printed once its enclosure leaves one rounding only; until then the reference
//! is asked for more digits. Whole numbers do all of the work, so that a table is the same to the byte
//! on any machine. A table in which a digit would stay in doubt is refused.
//!
//! [`ModeTable`] and [`ResponseTable`] are tables of a system and of a problem; [`SceneTables`] are the
//! documents that `eigentone tables` writes. All come as Markdown, CSV, JSON and LaTeX.
//!
//! # In the documentation of another crate
//!
//! Write the table into a file of that crate, include the file, and let a test keep it up to date:
//!
//! ```
//! use eigentone::prelude::*;
//! use eigentone::tables::{ModeTable, ResponseTable};
//!
//! /// The pendulum that this crate's integrators are checked with:
//! ///
//! /// | # | motion | multiplicity | Re λ, 1/s | Im λ, rad/s | ω_n, rad/s | f_n, Hz | ω_d, rad/s | ζ | decay rate, 1/s |
//! /// | --: | :-- | --: | --: | --: | --: | --: | --: | --: | --: |
//! /// | 1 | oscillating | 1 | -0.125000000000000 | 1.40867845869808 | 1.41421356237310 | 0.225079079039277 | 1.40867845869808 | 0.0883883476483184 | 0.125000000000000 |
//! // In a crate of its own: #[doc = include_str!("../docs/pendulum.md")]
//! fn pendulum() -> Result<System, Box<dyn std::error::Error>> {
//!     let system = System::builder().mass("bob", 1.0).spring(GROUND, "bob", 2.0);
//!     Ok(system.damper(GROUND, "bob", 0.25).build()?)
//! }
//!
//! // The test, which writes the file anew where it differs.
//! # let file = std::env::temp_dir().join(format!("eigentone-pendulum-{}.md", std::process::id()));
//! let system = pendulum()?;
//! let table = ModeTable::of(&system)?.markdown();
//! if std::fs::read_to_string(&file).ok().as_ref() != Some(&table) {
//!     std::fs::write(&file, &table)?;
//! }
//! # std::fs::remove_file(&file)?;
//! let numbers = "-0.125000000000000 | 1.40867845869808 | 1.41421356237310 | 0.225079079039277 |";
//! assert!(table.contains(numbers));
//!
//! let problem = Response::of(&system)
//!     .from(State::at_rest().displace("bob", 1.0))
//!     .every(0.5)
//!     .until(10.0)
//!     .problem()?
//!     .at(&[0, 10, 20])?;
//! let motion = ResponseTable::of(&problem)?;
//! assert_eq!(motion.rows()[2].displacement[0].to_string(), "0.0398196096837704");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
mod modes;
mod response;
mod scene;
mod settle;
mod sheet;
mod value;

pub use error::TableError;
pub use modes::{ModeRow, ModeTable};
pub use response::{ResponseRow, ResponseTable};
pub use scene::SceneTables;
pub use value::{DIGITS, Value};
