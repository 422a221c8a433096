//! What is proved of a system, as text.

use serde::{Serialize, Serializer};

use super::Structure;

/// One key for each method: true where it is proved, null for a number that is not.
impl Serialize for Structure {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Text<'a> {
            symmetric: bool,
            passive: bool,
            undamped: bool,
            classical: bool,
            gyroscopic: bool,
            overdamped: bool,
            finite_roots: Option<usize>,
            zero_roots: Option<usize>,
            undamped_modes: Option<usize>,
            damping_rank: Option<usize>,
            massless: &'a [usize],
            damped_massless: &'a [usize],
            spring_floating: &'a [Vec<usize>],
            floating: &'a [Vec<usize>],
        }
        Text {
            symmetric: self.is_symmetric(),
            passive: self.is_passive(),
            undamped: self.is_undamped(),
            classical: self.is_classical(),
            gyroscopic: self.is_gyroscopic(),
            overdamped: self.is_overdamped(),
            finite_roots: self.finite_roots(),
            zero_roots: self.zero_roots(),
            undamped_modes: self.undamped_modes(),
            damping_rank: self.damping_rank(),
            massless: self.massless(),
            damped_massless: self.damped_massless(),
            spring_floating: self.spring_floating(),
            floating: self.floating(),
        }
        .serialize(to)
    }
}
