//! A table of messages, and which kinds of error it has shown.

use std::collections::BTreeSet;
use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// What is listed so far.
#[derive(Debug)]
pub struct Listing {
    rows: String,
    shown: BTreeSet<String>,
    /// What should have been refused.
    answered: Vec<String>,
}

impl Listing {
    /// A table with these headings.
    pub fn headed(headings: [&str; 2]) -> Listing {
        let [left, right] = headings;
        Listing {
            rows: format!("| {left} | {right} |\n| :-- | :-- |\n"),
            shown: BTreeSet::new(),
            answered: Vec::new(),
        }
    }

    /// A row: what was given, and the message that it gave, which is to be one line.
    pub fn row(&mut self, given: &str, message: &str) {
        assert!(message.len() > 20 && !message.contains('\n'), "{message}");
        let message = message.replace('|', "\\|").replace('<', "&lt;");
        let given = given.replace('|', "\\|");
        writeln!(self.rows, "| `{given}` | {message} |").expect("strings take text");
    }

    /// Remembers a kind of error, for instance `ModesError::Refused`.
    pub fn show(&mut self, kind: String) {
        self.shown.insert(kind);
    }

    /// Something was answered that is to be refused.
    pub fn answered(&mut self, given: &str) {
        self.answered.push(given.to_owned());
    }

    /// The row of an error in the library.
    pub fn call<T, E: Error>(&mut self, call: &str, result: Result<T, E>) {
        // As the compiler prints it, but on one line.
        let call = call.split_whitespace().collect::<Vec<_>>().join(" ");
        let call = call.replace(" .", ".");
        match result {
            Ok(_) => self.answered(&call),
            Err(error) => {
                self.row(&call, &error.to_string());
                self.show(kind(&error));
            }
        }
    }

    /// The table, and what is not in it, which must be all that the enums declare besides.
    pub fn finish(self, enums: &[(&str, &str)], left_out: &[(&str, &str)]) -> String {
        let is_left_out = |kind: &String| left_out.iter().any(|(known, _)| known == kind);
        let missing: Vec<String> = enums
            .iter()
            .flat_map(|(file, error)| declared(file, error))
            .filter(|kind| self.shown.contains(kind) == is_left_out(kind))
            .collect();
        assert!(
            missing.is_empty() && self.answered.is_empty(),
            "to be shown, or left out: {missing:#?}\nanswered: {:#?}\n{}",
            self.answered,
            self.rows
        );
        let mut text = self.rows;
        if !left_out.is_empty() {
            text += "\nNot shown, for want of a small example:\n\n";
        }
        for (kind, reason) in left_out {
            writeln!(text, "- `{kind}`: {reason}").expect("strings take text");
        }
        text
    }
}

/// The name of an error's type and variant.
pub fn kind<E: Error>(error: &E) -> String {
    let path = std::any::type_name::<E>();
    let name = path.rsplit("::").next().unwrap_or(path);
    format!("{name}::{}", variant(&format!("{error:?}")))
}

/// The name that a `Debug` text begins with.
pub fn variant(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric());
    &text[..end.unwrap_or(text.len())]
}

/// The variants of an error in its source file.
fn declared(file: &str, error: &str) -> Vec<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{file}: {error}"));
    let (_, rest) = text
        .split_once(&format!("pub enum {error} {{"))
        .unwrap_or_else(|| panic!("{file}: no {error}"));
    let body = rest.split("\n}").next().expect("it ends");
    let name = |line: &str| {
        let name = line.strip_prefix("    ")?;
        let is_name = name.starts_with(|c: char| c.is_ascii_uppercase());
        is_name.then(|| format!("{error}::{}", variant(name)))
    };
    body.lines().filter_map(name).collect()
}
