//! Places in a scene file: the path to a value, and its line and column.

use std::collections::HashMap;
use std::fmt;
use std::path::PathBuf;

use serde_json::value::RawValue;

/// A place in a scene file. It prints as `FILE:LINE:COLUMN: PATH`, such as
/// `scene.json:12:34: springs[2].between[1]`.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Place {
    /// The file.
    pub file: PathBuf,
    /// The path to the value inside the scene; empty for the scene as a whole.
    pub path: String,
    /// The line, from 1.
    pub line: usize,
    /// The column, from 1, in characters.
    pub column: usize,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.file.display(), self.line, self.column)?;
        if self.path.is_empty() {
            return Ok(());
        }
        write!(f, ": {}", self.path)
    }
}

/// One step from a value into a part of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Step {
    Key(String),
    Index(usize),
}

impl From<&str> for Step {
    fn from(key: &str) -> Step {
        Step::Key(key.to_owned())
    }
}

impl From<usize> for Step {
    fn from(index: usize) -> Step {
        Step::Index(index)
    }
}

/// Steps from keys and indices, in order.
macro_rules! steps {
    ($($step:expr),*) => { vec![$($crate::scene::place::Step::from($step)),*] };
}
pub(super) use steps;

/// The steps as text: `springs[2].between[1]`, with keys in brackets where a dot would not do.
pub(super) fn written(steps: &[Step]) -> String {
    let mut text = String::new();
    for step in steps {
        match step {
            Step::Index(index) => text += &format!("[{index}]"),
            Step::Key(key) => {
                let plain = |c: char| c.is_alphanumeric() || "_-".contains(c);
                if key.is_empty() || !key.chars().all(plain) {
                    text += &format!("[{:?}]", super::words::excerpt(key));
                } else {
                    text += if text.is_empty() { "" } else { "." };
                    text += &super::words::excerpt(key);
                }
            }
        }
    }
    text
}

/// The offset in bytes at which the value begins that the steps lead to. Where they lead nowhere,
/// the last value on the way counts.
pub(super) fn offset(text: &str, steps: &[Step]) -> usize {
    let start = |value: &RawValue| value.get().as_ptr() as usize - text.as_ptr() as usize;
    let Ok(mut here) = serde_json::from_str::<&RawValue>(text) else {
        return 0;
    };
    for step in steps {
        let next = match step {
            Step::Key(key) => serde_json::from_str::<HashMap<String, &RawValue>>(here.get())
                .ok()
                .and_then(|mut members| members.remove(key)),
            Step::Index(index) => serde_json::from_str::<Vec<&RawValue>>(here.get())
                .ok()
                .and_then(|values| values.get(*index).copied()),
        };
        match next {
            Some(value) => here = value,
            None => break,
        }
    }
    start(here)
}

/// Line and column, from 1 and in characters, of an offset in bytes.
pub(super) fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let before = &text.as_bytes()[..offset.min(text.len())];
    let start = before
        .iter()
        .rposition(|byte| *byte == b'\n')
        .map_or(0, |i| i + 1);
    let line = before.iter().filter(|byte| **byte == b'\n').count() + 1;
    let is_first_of_character = |byte: &&u8| **byte & 0xC0 != 0x80;
    let column = before[start..].iter().filter(is_first_of_character).count() + 1;
    (line, column)
}
