//! Matrices as files in the Matrix Market exchange format (Boisvert, Pozo & Remington 1996, NISTIR 5935).
//!
//! Read strictly: what the format does not allow is an error that names the line. Nothing is set aside for
//! entries that the file cannot hold.

use std::io::BufRead;

use faer::sparse::{SparseColMat, Triplet};

use super::matrix_error::{Announced, Refusal, Spot};
use super::words::excerpt;

/// A file line by line.
struct Lines<R> {
    text: R,
    line: Vec<u8>,
    /// Of the line, from 1.
    number: usize,
}

impl<R: BufRead> Lines<R> {
    /// Longer lines have no place in the format.
    const LONGEST: u64 = 4096;

    /// Goes to the next line; `false` after the last one.
    fn advance(&mut self) -> Result<bool, Refusal> {
        self.line.clear();
        self.number += 1;
        let mut part = std::io::Read::take(&mut self.text, Self::LONGEST);
        let read = part
            .read_until(b'\n', &mut self.line)
            .map_err(Refusal::Read)?;
        if self.line.last() != Some(&b'\n') && read as u64 == Self::LONGEST {
            let longest = Self::LONGEST;
            return self.refuse(format!("the line is longer than {longest} bytes: break it"));
        }
        Ok(read > 0)
    }

    /// Goes to the next line with something in it, over comments if these may stand here.
    fn advance_to_content(&mut self, comments: bool) -> Result<bool, Refusal> {
        while self.advance()? {
            let text = self.line.trim_ascii();
            let comment = comments && text.first() == Some(&b'%');
            if !text.is_empty() && !comment {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The words of the line.
    fn words(&self) -> Vec<&str> {
        let text = std::str::from_utf8(&self.line).unwrap_or("?");
        text.split_ascii_whitespace().collect()
    }

    fn refuse<T>(&self, problem: String) -> Result<T, Refusal> {
        Err(Refusal::Wrong(Spot::Line(self.number), problem))
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Layout {
    Coordinate,
    Array,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Field {
    Real,
    Integer,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Symmetry {
    General,
    Symmetric,
    Skew,
}

fn header<R: BufRead>(lines: &mut Lines<R>) -> Result<(Layout, Field, Symmetry), Refusal> {
    const RIGHT: &str = "%%MatrixMarket matrix coordinate real symmetric";
    lines.advance()?;
    let line = lines
        .line
        .strip_prefix(b"\xef\xbb\xbf")
        .unwrap_or(&lines.line);
    let line = String::from_utf8_lossy(line).to_ascii_lowercase();
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    if words.first() != Some(&"%%matrixmarket") {
        return lines.refuse(format!(
            "is not the head of a Matrix Market file, such as {RIGHT:?}"
        ));
    }
    let [_, object, layout, field, symmetry] = words[..] else {
        let count = words.len();
        return lines.refuse(format!(
            "the head has {count} words instead of 5, such as {RIGHT:?}"
        ));
    };
    let unknown = |word: &str, known: &str| {
        let word = excerpt(word);
        lines.refuse(format!("{word:?} is not read here: expected {known}"))
    };
    if object != "matrix" {
        return unknown(object, "\"matrix\"");
    }
    let layout = match layout {
        "coordinate" => Layout::Coordinate,
        "array" => Layout::Array,
        other => return unknown(other, "\"coordinate\" or \"array\""),
    };
    let field = match field {
        "real" | "double" => Field::Real,
        "integer" => Field::Integer,
        "pattern" => {
            return lines.refuse(
                "a pattern has no values: give a \"real\" or \"integer\" matrix".to_owned(),
            );
        }
        other => return unknown(other, "\"real\" or \"integer\""),
    };
    let symmetry = match symmetry {
        "general" => Symmetry::General,
        "symmetric" => Symmetry::Symmetric,
        "skew-symmetric" => Symmetry::Skew,
        other => return unknown(other, "\"general\", \"symmetric\" or \"skew-symmetric\""),
    };
    Ok((layout, field, symmetry))
}

/// How many entries of an array are given.
fn given(n: usize, symmetry: Symmetry) -> usize {
    match symmetry {
        Symmetry::General => n * n,
        Symmetry::Symmetric => n * (n + 1) / 2,
        Symmetry::Skew => n * (n - 1) / 2,
    }
}

/// The order of the matrix and how many entries follow.
fn size<R: BufRead>(
    lines: &mut Lines<R>,
    layout: Layout,
    symmetry: Symmetry,
    bytes: u64,
) -> Result<(usize, usize), Refusal> {
    let right = match layout {
        Layout::Coordinate => "rows, columns and entries",
        Layout::Array => "rows and columns",
    };
    if !lines.advance_to_content(true)? {
        return lines.refuse(format!("the file ends before its size: expected {right}"));
    }
    let words = lines.words();
    let wanted = if layout == Layout::Coordinate { 3 } else { 2 };
    let numbers: Vec<usize> = words.iter().map_while(|word| whole(word)).collect();
    if words.len() != wanted || numbers.len() != wanted {
        return lines.refuse(format!(
            "is not the size: expected {right}, {wanted} whole numbers"
        ));
    }
    let (rows, columns) = (numbers[0], numbers[1]);
    let spot = Spot::Line(lines.number);
    Announced::order(rows, columns, spot)?;
    let most = given(rows, symmetry);
    let entries = match layout {
        Layout::Coordinate => numbers[2],
        Layout::Array => most,
    };
    if entries > most {
        return lines.refuse(format!(
            "{entries} entries are more than the {most} that such a matrix of {rows} rows has"
        ));
    }
    // An entry takes a digit and the end of its line, or three numbers of a digit each.
    let least = if layout == Layout::Coordinate { 6 } else { 2 };
    if entries as u64 > bytes / least + 1 {
        return lines.refuse(format!(
            "{entries} entries do not fit into a file of {bytes} bytes: is it cut off?"
        ));
    }
    Announced::entries(entries, spot)?;
    Ok((rows, entries))
}

/// The matrix in a text of so many bytes, with what symmetry leaves out filled in.
pub(super) fn matrix(text: impl BufRead, bytes: u64) -> Result<SparseColMat<usize, f64>, Refusal> {
    let lines = &mut Lines {
        text,
        line: Vec::new(),
        number: 0,
    };
    let (layout, field, symmetry) = header(lines)?;
    let (n, count) = size(lines, layout, symmetry, bytes)?;
    let mut entries: Vec<(usize, usize, f64)> = Vec::with_capacity(count);
    let mut numbers: Vec<usize> = Vec::new();
    // The next place of an array, column by column.
    let first_row = |column: usize| match symmetry {
        Symmetry::General => 0,
        Symmetry::Symmetric => column,
        Symmetry::Skew => column + 1,
    };
    let (mut row, mut column) = (first_row(0), 0);
    for index in 0..count {
        if !lines.advance_to_content(false)? {
            return lines.refuse(format!("the file ends after {index} of {count} entries"));
        }
        let words = lines.words();
        let (i, j, text) = match (layout, &words[..]) {
            (Layout::Array, [text]) => {
                while row == n {
                    column += 1;
                    row = first_row(column);
                }
                row += 1;
                (row - 1, column, *text)
            }
            (Layout::Array, _) => {
                let given = words.len();
                return lines.refuse(format!("{given} words: an array has one number on a line"));
            }
            (Layout::Coordinate, [i, j, text]) => {
                let place = |word: &str| whole(word).filter(|at| (1..=n).contains(at));
                let (Some(i), Some(j)) = (place(i), place(j)) else {
                    let (i, j) = (excerpt(i), excerpt(j));
                    return lines.refuse(format!(
                        "row {i} and column {j}: both must be whole numbers from 1 to {n}"
                    ));
                };
                (i - 1, j - 1, *text)
            }
            (Layout::Coordinate, _) => {
                let given = words.len();
                return lines.refuse(format!(
                    "{given} words: an entry is its row, its column and its value"
                ));
            }
        };
        let value = match number(text, field) {
            Ok(value) => value,
            Err(problem) => return lines.refuse(problem),
        };
        if symmetry != Symmetry::General && i < j {
            return lines.refuse(format!(
                "entry ({}, {}) lies above the diagonal: of such a matrix only those below are given",
                i + 1,
                j + 1
            ));
        }
        if symmetry == Symmetry::Skew && i == j {
            return lines.refuse(format!(
                "entry ({0}, {0}) lies on the diagonal, which is 0 where a matrix is skew-symmetric",
                i + 1
            ));
        }
        entries.push((i, j, value));
        if layout == Layout::Coordinate {
            numbers.push(lines.number);
        }
    }
    if lines.advance_to_content(false)? {
        return lines.refuse(format!(
            "there is more after the last of the entries announced, {count}"
        ));
    }
    if layout == Layout::Coordinate {
        check_once(&entries, &numbers)?;
    }
    let triplets = entries.into_iter().filter(|entry| entry.2 != 0.0);
    let triplets: Vec<Triplet<usize, usize, f64>> = triplets
        .flat_map(|(i, j, value)| {
            let mirrored = match symmetry {
                Symmetry::General => None,
                _ if i == j => None,
                Symmetry::Symmetric => Some(Triplet::new(j, i, value)),
                Symmetry::Skew => Some(Triplet::new(j, i, -value)),
            };
            std::iter::once(Triplet::new(i, j, value)).chain(mirrored)
        })
        .collect();
    SparseColMat::try_new_from_triplets(n, n, &triplets).map_err(|_| {
        let problem = "the matrix is too large for the memory there is".to_owned();
        Refusal::Wrong(Spot::Line(lines.number), problem)
    })
}

/// That no entry is given twice.
fn check_once(entries: &[(usize, usize, f64)], lines: &[usize]) -> Result<(), Refusal> {
    let mut order: Vec<usize> = (0..entries.len()).collect();
    order.sort_by_key(|&at| (entries[at].0, entries[at].1, at));
    for pair in order.windows(2) {
        let (first, second) = (pair[0], pair[1]);
        let (i, j, _) = entries[first];
        if (i, j) == (entries[second].0, entries[second].1) {
            let problem = format!(
                "entry ({}, {}) is given before, in line {}: give it once",
                i + 1,
                j + 1,
                lines[first]
            );
            return Err(Refusal::Wrong(Spot::Line(lines[second]), problem));
        }
    }
    Ok(())
}

/// A whole number of digits alone.
fn whole(word: &str) -> Option<usize> {
    let digits = word.bytes().all(|byte| byte.is_ascii_digit());
    digits.then(|| word.parse().ok()).flatten()
}

/// The double nearest to a text.
fn number(word: &str, field: Field) -> Result<f64, String> {
    let digits = |byte: u8| byte.is_ascii_digit() || b"+-".contains(&byte);
    let part = |byte: u8| digits(byte) || b".eE".contains(&byte);
    let (fits, right) = match field {
        Field::Real => (word.bytes().all(part), "a number such as -1.5e3"),
        Field::Integer => (
            word.bytes().all(digits),
            "a whole number, or the head must say \"real\"",
        ),
    };
    match word.parse::<f64>() {
        Ok(value) if fits && value.is_finite() => Ok(value),
        Ok(_) if fits => Err(format!(
            "{} is too large: up to ±1.79e308 are numbers",
            excerpt(word)
        )),
        _ => Err(format!("{:?} is not {right}", excerpt(word))),
    }
}
