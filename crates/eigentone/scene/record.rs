//! Columns of numbers in a text file: the values of samples that were measured.
//!
//! Read strictly: a field that is missing, empty or no finite number is an error that names line and column. Nothing is
//! filled in; of a whole table an empty field says that nothing was measured.

use std::borrow::Cow;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::shape::Column;
use super::words::{did_you_mean, excerpt};

/// The largest file of samples that is read, in bytes.
pub const MAX_RECORD_BYTES: u64 = 256 << 20;

/// What is wrong with a file of samples: the file, the line and column in it, what is wrong and what would be right.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RecordError {
    /// It cannot be read.
    #[error("{}: cannot be read: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// It is a directory, a pipe or a device.
    #[error("{}: is not a file: name a text file with columns of numbers", file.display())]
    NotFile {
        /// What was named.
        file: PathBuf,
    },
    /// It has more than [`MAX_RECORD_BYTES`].
    #[error("{}: is larger than {} MiB, the most a file of samples may have", file.display(), MAX_RECORD_BYTES >> 20)]
    TooLarge {
        /// The file.
        file: PathBuf,
    },
    /// A place in it is wrong.
    #[error("{}:{line}:{column}: {problem}", file.display())]
    Text {
        /// The file.
        file: PathBuf,
        /// Its line, from 1.
        line: usize,
        /// The column in that line, from 1, in characters.
        column: usize,
        /// What is wrong, and what would be right.
        problem: String,
    },
}

/// The numbers of one column of a text file, as samples of a scene have them: the column of this name in the first line, or
/// of this number, from 1 on; or the only one.
///
/// # Errors
/// [`RecordError`] naming the file, the line and the column.
pub fn read_record(path: &Path, column: Option<&str>) -> Result<Vec<f64>, RecordError> {
    let column = match column.map(|text| (text, text.parse::<usize>())) {
        None => Column::Only,
        Some((_, Ok(number))) if number > 0 => Column::Number(number),
        Some((name, _)) => Column::Name(name.to_owned()),
    };
    read(path, &column)
}

/// The numbers of one column.
pub(super) fn read(path: &Path, column: &Column) -> Result<Vec<f64>, RecordError> {
    let bytes = bytes(path)?;
    let values = values(&String::from_utf8_lossy(&bytes), column);
    values.map_err(|refusal| refusal.of(path))
}

/// A text file with named columns, of which some have numbers.
#[derive(Clone, Debug)]
pub struct Table {
    file: PathBuf,
    text: String,
    names: Vec<String>,
}

impl Table {
    /// Reads the file: its first line has the names.
    ///
    /// # Errors
    /// [`RecordError`] where it cannot be read, has no names, two columns of one name, or lines of different lengths.
    pub fn read(path: &Path) -> Result<Table, RecordError> {
        let text = String::from_utf8_lossy(&bytes(path)?).into_owned();
        Table::of(path, text)
    }

    fn of(path: &Path, text: String) -> Result<Table, RecordError> {
        let mut names: Vec<String> = Vec::new();
        let found = rows(&text, Separator::of_names, |line, fields| {
            if !names.is_empty() {
                return Ok(());
            }
            names = fields.iter().map(|field| field.name().into()).collect();
            let is_new = |(i, name): (usize, &String)| !names[..i].contains(name);
            let again = names.iter().enumerate().position(|one| !is_new(one));
            let problem = match again {
                Some(i) => format!("two columns are named {:?}", excerpt(&names[i])),
                None if names.iter().all(|name| name.parse::<f64>().is_err()) => return Ok(()),
                None => "the first line needs the name of each column".to_owned(),
            };
            let column = fields[again.unwrap_or(0)].column;
            Err(Refusal {
                line,
                column,
                problem,
            })
        });
        found.map_err(|refusal| refusal.of(path))?;
        let file = path.to_owned();
        Ok(Table { file, text, names })
    }

    /// The names of the columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The numbers of a column with their lines in the file, from 1 on; `None` where the field is empty.
    ///
    /// # Errors
    /// [`RecordError`] naming the field that is no finite number.
    pub fn column(&self, index: usize) -> Result<Vec<(usize, Option<f64>)>, RecordError> {
        let mut values = Vec::new();
        let mut is_first = true;
        let found = rows(&self.text, Separator::of_names, |line, fields| {
            if !std::mem::take(&mut is_first)
                && let Some(field) = fields.get(index)
            {
                let value = match field.text {
                    "" => None,
                    _ => Some(field.number(line)?),
                };
                values.push((line, value));
            }
            Ok(())
        });
        found.map_err(|refusal| refusal.of(&self.file))?;
        Ok(values)
    }

    /// Says that a line is wrong.
    pub fn refuse(&self, line: usize, problem: String) -> RecordError {
        let refusal = Refusal {
            line,
            column: 1,
            problem,
        };
        refusal.of(&self.file)
    }
}

fn bytes(path: &Path) -> Result<Vec<u8>, RecordError> {
    let failed = |source| RecordError::Read {
        file: path.to_owned(),
        source,
    };
    // To open a pipe would wait for its other end.
    let metadata = std::fs::metadata(path).map_err(failed)?;
    let file = path.to_owned();
    if !metadata.is_file() {
        return Err(RecordError::NotFile { file });
    }
    let mut bytes = Vec::new();
    if metadata.len() <= MAX_RECORD_BYTES {
        // It may have grown.
        let open = File::open(path).map_err(failed)?.take(MAX_RECORD_BYTES + 1);
        { open }.read_to_end(&mut bytes).map_err(failed)?;
    }
    match metadata.len().max(bytes.len() as u64) > MAX_RECORD_BYTES {
        true => Err(RecordError::TooLarge { file }),
        false => Ok(bytes),
    }
}

#[derive(Debug)]
struct Refusal {
    line: usize,
    column: usize,
    problem: String,
}

impl Refusal {
    fn of(self, file: &Path) -> RecordError {
        RecordError::Text {
            file: file.to_owned(),
            line: self.line,
            column: self.column,
            problem: self.problem,
        }
    }
}

/// What stands between the fields of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Separator {
    Character(char),
    Blanks,
}

impl Separator {
    fn of(line: &str) -> Separator {
        // Decimal commas are no numbers here, but a semicolon beside them is what separates.
        let found = [';', ','].into_iter().find(|&mark| {
            let mut quoted = false;
            line.chars().any(|c| {
                quoted ^= c == '"';
                c == mark && !quoted
            })
        });
        found.map_or(Separator::Blanks, Separator::Character)
    }

    /// The same of names in which blanks are.
    fn of_names(line: &str) -> Separator {
        match Separator::of(line) {
            Separator::Blanks => Separator::Character('\t'),
            found => found,
        }
    }

    fn is(self, c: char) -> bool {
        match self {
            Separator::Character(mark) => c == mark,
            Separator::Blanks => c.is_whitespace(),
        }
    }
}

/// A part of a line and the column in which it begins, from 1.
struct Field<'a> {
    text: &'a str,
    column: usize,
}

impl<'a> Field<'a> {
    /// The text without the quotes around it, in which two quotes mean one.
    fn name(&self) -> Cow<'a, str> {
        let quoted = self.text.strip_prefix('"');
        match quoted.and_then(|text| text.strip_suffix('"')) {
            Some(text) => text.replace("\"\"", "\"").into(),
            None => self.text.into(),
        }
    }

    fn number(&self, line: usize) -> Result<f64, Refusal> {
        let value = self.text.parse().ok();
        value
            .filter(|value: &f64| value.is_finite())
            .ok_or_else(|| {
                let problem = match self.text {
                    "" => "the field is empty: a sample is missing, and none is made up for it"
                        .to_owned(),
                    text => format!(
                        "{:?} is not a finite number: write one with a point, as 0.25 or 2.5e-1",
                        excerpt(text)
                    ),
                };
                Refusal {
                    line,
                    column: self.column,
                    problem,
                }
            })
    }

    /// What no number begins with.
    fn is_name(&self) -> bool {
        let first = self.text.chars().next();
        let of_number = |c: char| c.is_ascii_digit() || "+-.".contains(c);
        first.is_some_and(|c| !of_number(c)) && self.text.parse::<f64>().is_err()
    }
}

/// The fields of a line without its comment; none of a line with nothing else in it.
fn fields(line: &str, separator: Separator) -> Vec<Field<'_>> {
    let (mut ends, mut end, mut quoted) = (Vec::new(), line.len(), false);
    for (at, c) in line.char_indices() {
        quoted ^= c == '"';
        if !quoted && c == '#' {
            end = at;
            break;
        }
        if !quoted && separator.is(c) {
            ends.push((at, at + c.len_utf8()));
        }
    }
    if line[..end].trim().is_empty() {
        return Vec::new();
    }
    ends.push((end, end));
    let mut start = 0;
    let mut fields = Vec::new();
    for (end, next) in ends {
        let text = line[start..end].trim();
        let blank = line[start..end].len() - line[start..end].trim_start().len();
        let column = line[..start + blank].chars().count() + 1;
        if separator != Separator::Blanks || !text.is_empty() {
            fields.push(Field { text, column });
        }
        start = next;
    }
    fields
}

/// The fields of each line that has any, with its number from 1 on: always as many, and no empty line between them.
fn rows(
    text: &str,
    separator: impl Fn(&str) -> Separator,
    mut each: impl FnMut(usize, &[Field<'_>]) -> Result<(), Refusal>,
) -> Result<(), Refusal> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut layout: Option<(Separator, usize)> = None;
    let mut has_numbers = false;
    let mut empty = None;
    for (index, line) in text.lines().enumerate() {
        let number = index + 1;
        if line.trim().is_empty() {
            empty = empty.or(Some(number).filter(|_| has_numbers));
            continue;
        }
        let separator = layout.map_or_else(|| separator(line), |(separator, _)| separator);
        let fields = fields(line, separator);
        if fields.is_empty() {
            continue;
        }
        let refusal = |line, problem| Refusal {
            line,
            column: 1,
            problem,
        };
        if let Some(line) = empty {
            let problem =
                "the line is empty: each line from the first to the last sample needs a number"
                    .to_owned();
            return Err(refusal(line, problem));
        }
        let found = fields.len();
        match layout {
            None => {
                has_numbers = !fields.iter().all(Field::is_name);
                layout = Some((separator, found));
            }
            Some((_, count)) if found != count => {
                let problem = format!(
                    "fields in this line: {found}, in the first one: {count}; give a number in each column"
                );
                return Err(refusal(number, problem));
            }
            Some(_) => has_numbers = true,
        }
        each(number, &fields)?;
    }
    Ok(())
}

fn values(text: &str, wanted: &Column) -> Result<Vec<f64>, Refusal> {
    let mut found: Option<usize> = None;
    let mut values = Vec::new();
    rows(text, Separator::of, |line, fields| {
        let at = match found {
            Some(at) => at,
            None => {
                let names = fields.iter().all(Field::is_name);
                let at = place(fields, names, wanted).map_err(|problem| Refusal {
                    line,
                    column: 1,
                    problem,
                })?;
                found = Some(at);
                if names {
                    return Ok(());
                }
                at
            }
        };
        values.push(fields[at].number(line)?);
        Ok(())
    })?;
    match values.is_empty() {
        true => Err(Refusal {
            line: text.lines().count().max(1),
            column: 1,
            problem: "the file ends without a number: give at least one sample".to_owned(),
        }),
        false => Ok(values),
    }
}

/// Which field of the first line is wanted.
fn place(fields: &[Field<'_>], names: bool, wanted: &Column) -> Result<usize, String> {
    let count = fields.len();
    let columns = if count == 1 {
        "1 column"
    } else {
        &format!("{count} columns")
    };
    match wanted {
        Column::Only if count == 1 => Ok(0),
        Column::Only => Err(format!(
            "the file has {columns}: say which by \"column\", its name or its number from 1 on"
        )),
        Column::Number(number) if *number <= count => Ok(number - 1),
        Column::Number(number) => Err(format!(
            "there is no column {number}: the file has {columns}"
        )),
        Column::Name(name) if !names => Err(format!(
            "there is no column named {:?}: the first line has numbers, so give the column's number, from 1 on",
            excerpt(name)
        )),
        Column::Name(name) => {
            let known: Vec<Cow<'_, str>> = fields.iter().map(Field::name).collect();
            let mut found = known
                .iter()
                .enumerate()
                .filter(|(_, known)| **known == name.as_str());
            match (found.next(), found.next()) {
                (Some((place, _)), None) => Ok(place),
                (Some((first, _)), Some((second, _))) => Err(format!(
                    "columns {} and {} are both named {:?}: give the number of one",
                    first + 1,
                    second + 1,
                    excerpt(name)
                )),
                _ => Err(format!(
                    "there is no column named {:?}: {}",
                    excerpt(name),
                    did_you_mean(name, &known)
                )),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(name: &str) -> Column {
        Column::Name(name.to_owned())
    }

    #[test]
    fn columns_are_found_by_name_and_number_under_every_separator() {
        for text in [
            "t,ax,ay\n0,1.5,2\n0.1,-2e1,3\n",
            "# a record\n\n t ; \"ax\"; ay \n0; 1.5;2\n# between\n0.1;-2e1;3\r\n\n",
            "\u{feff}t ax\tay\n 0   1.5 2\n0.1\t-2e1 3 # the last",
        ] {
            for column in [named("ax"), Column::Number(2)] {
                assert_eq!(values(text, &column).expect(text), [1.5, -20.0], "{text}");
            }
        }
        assert_eq!(
            values("1\n2\n", &Column::Only).expect("one column"),
            [1.0, 2.0]
        );
        assert_eq!(
            values("\"a, b\",\"c\"\"d\"\n1,2", &named("c\"d")).expect("quotes"),
            [2.0]
        );
    }

    #[test]
    fn tables_have_names_and_may_have_holes() {
        let read = |text: &str| Table::of(Path::new("table.csv"), text.to_owned());
        let table = read("# modes\nf [Hz],\"a, b\",what\n1.5,,x\n,2,y\n").expect("a table");
        assert_eq!(table.names(), ["f [Hz]", "a, b", "what"]);
        let columns = [0, 1].map(|k| table.column(k).expect("numbers"));
        assert_eq!(columns[0], [(3, Some(1.5)), (4, None)]);
        assert_eq!(columns[1], [(3, None), (4, Some(2.0))]);
        let error = table.column(2).expect_err("text").to_string();
        assert!(error.contains("table.csv:3:6: \"x\" is not"), "{error}");
        for (text, says) in [
            ("a,a\n1,2\n", ":1:3: two columns are named \"a\""),
            ("1,2\n3,4\n", ":1:1: the first line needs the name"),
            ("a,b\n1\n", ":2:1: fields in this line: 1"),
        ] {
            let error = read(text).expect_err(text).to_string();
            assert!(error.contains(says), "{error}");
        }
    }

    #[test]
    fn what_is_missing_or_no_number_is_refused_with_its_place() {
        let cases: [(&str, Column, usize, usize, &str); 14] = [
            ("t,a\n0,1\n0.1,\n", named("a"), 3, 5, "the field is empty"),
            (
                "t,a\n0,1\n,2\n0.1, ,3",
                named("a"),
                4,
                1,
                "line: 3, in the first one: 2",
            ),
            ("1\n\n2\n", Column::Only, 2, 1, "the line is empty"),
            (
                "t a\n0 1\n0.1\n",
                named("a"),
                3,
                1,
                "line: 1, in the first one: 2",
            ),
            ("t;a\n0;1,5\n", named("a"), 2, 3, "with a point"),
            (
                "t,a\n0,nan\n",
                named("a"),
                2,
                3,
                "\"nan\" is not a finite number",
            ),
            (
                "t,a\n0,1e999\n",
                named("a"),
                2,
                3,
                "\"1e999\" is not a finite number",
            ),
            ("0.1x\n2\n", Column::Only, 1, 1, "\"0.1x\" is not"),
            (
                "t,ax\n0,1\n",
                named("ay"),
                1,
                1,
                "known are \"t\" and \"ax\"",
            ),
            ("0,1\n", named("ay"), 1, 1, "give the column's number"),
            ("a,a\n0,1\n", named("a"), 1, 1, "both named \"a\""),
            ("0,1\n", Column::Number(3), 1, 1, "the file has 2 columns"),
            ("0,1\n", Column::Only, 1, 1, "say which by \"column\""),
            ("# nothing\n", Column::Only, 1, 1, "at least one sample"),
        ];
        for (text, column, line, place, says) in cases {
            let refusal = values(text, &column).expect_err(text);
            assert_eq!((refusal.line, refusal.column), (line, place), "{text}");
            assert!(
                refusal.problem.contains(says),
                "{text}: {}",
                refusal.problem
            );
        }
    }
}
