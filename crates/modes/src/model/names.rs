//! The names of coordinates, and their places by name.

use std::fmt;
use std::ops::Deref;
use std::sync::{Arc, OnceLock};

/// The names of the coordinates of a system, in order: a slice of them that also finds places. Clones share one list.
#[derive(Clone, Debug)]
pub struct Names(Arc<List>);

#[derive(Debug)]
struct List {
    names: Vec<String>,
    /// Their places sorted by name, when one is first looked for.
    by_name: OnceLock<Vec<u32>>,
}

impl Names {
    /// The place of the coordinate `name`.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        let at = |i: &u32| self[*i as usize].as_str();
        let by_name = self.0.by_name.get_or_init(|| {
            let mut order: Vec<u32> = (0..self.len() as u32).collect();
            order.sort_unstable_by_key(at);
            order
        });
        let place = by_name.binary_search_by(|i| at(i).cmp(name)).ok()?;
        Some(by_name[place] as usize)
    }

    /// The same, where a name that is none is an error.
    ///
    /// # Errors
    /// [`NoCoordinate`], which names those that there are.
    pub fn find(&self, name: &str) -> Result<usize, NoCoordinate> {
        self.index_of(name).ok_or_else(|| NoCoordinate {
            name: name.to_owned(),
            names: self.clone(),
        })
    }
}

impl Deref for Names {
    type Target = [String];

    fn deref(&self) -> &[String] {
        &self.0.names
    }
}

impl From<Vec<String>> for Names {
    fn from(names: Vec<String>) -> Names {
        Names(Arc::new(List {
            names,
            by_name: OnceLock::new(),
        }))
    }
}

/// Without any.
impl Default for Names {
    fn default() -> Names {
        Vec::new().into()
    }
}

impl PartialEq for Names {
    fn eq(&self, other: &Names) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self[..] == other[..]
    }
}

impl Eq for Names {}

/// A name that no coordinate has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoCoordinate {
    /// The name.
    pub name: String,
    names: Names,
}

impl fmt::Display for NoCoordinate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const SHOWN: usize = 12;
        let names = self.names.iter().take(SHOWN);
        let shown: Vec<String> = names.map(|name| format!("{name:?}")).collect();
        write!(f, "there is no coordinate {:?}: there ", self.name)?;
        match self.names.len() {
            0 => write!(f, "are no names"),
            1 => write!(f, "is {}", shown[0]),
            _ => write!(f, "are {}", shown.join(", ")),
        }?;
        match self.names.len().saturating_sub(SHOWN) {
            0 => Ok(()),
            more => write!(f, " and {more} more"),
        }
    }
}

impl std::error::Error for NoCoordinate {}
