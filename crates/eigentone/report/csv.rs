//! Comma-separated values as RFC 4180 has them, with all digits of every number.

use std::borrow::Cow;
use std::io::{self, Write};

/// One row; a cell that needs quotes gets them, and one that is no number stays [`text`].
pub(crate) fn row(
    out: &mut impl Write,
    cells: impl IntoIterator<Item = impl AsRef<str>>,
) -> io::Result<()> {
    for (index, cell) in cells.into_iter().enumerate() {
        if index > 0 {
            out.write_all(b",")?;
        }
        let cell = text(cell.as_ref());
        if cell.contains(['"', ',', '\n', '\r']) {
            write!(out, "\"{}\"", cell.replace('"', "\"\""))?;
        } else {
            out.write_all(cell.as_bytes())?;
        }
    }
    out.write_all(b"\r\n")
}

/// What begins a formula in some spreadsheet.
const FORMULA: [char; 8] = ['=', '+', '-', '@', '＝', '＋', '－', '＠'];

/// What a cell holds: an apostrophe before what a spreadsheet would take for a formula says that it is none.
pub(crate) fn text(cell: &str) -> Cow<'_, str> {
    if !cell.trim_start().starts_with(FORMULA) || is_negative_number(cell) {
        return cell.into();
    }
    format!("'{cell}").into()
}

/// Whether it is one as [`number`] writes them.
fn is_negative_number(cell: &str) -> bool {
    let digits = cell.strip_prefix('-');
    digits.is_some_and(|digits| {
        digits.starts_with(|c: char| c.is_ascii_digit()) && cell.parse::<f64>().is_ok()
    })
}

/// The shortest form that reads back to the same double; an empty cell for what is no number.
pub(crate) fn number(value: f64) -> String {
    if value.is_finite() {
        format!("{value:?}")
    } else {
        String::new()
    }
}

/// A number, or an empty cell.
pub(crate) fn optional(value: Option<f64>) -> String {
    value.map(number).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_that_would_break_a_row_are_quoted() {
        let mut out = Vec::new();
        row(&mut out, ["m1", "a,b", "say \"x\"", "two\nlines"]).expect("a vector takes it");
        assert_eq!(
            String::from_utf8_lossy(&out),
            "m1,\"a,b\",\"say \"\"x\"\"\",\"two\nlines\"\r\n"
        );
    }

    #[test]
    fn names_are_no_formulas() {
        for name in [
            "=1+1", "+a", "+1", "-a", "-1+a", "-inf", "@a", "\t=1", " =1", " -1", "＝1",
        ] {
            assert_eq!(text(name), format!("'{name}"));
        }
        for name in ["m1", "a=b", "'=1", "", "-1.5", "-1e-300", "-0.0"] {
            assert_eq!(text(name), name);
        }
        let mut out = Vec::new();
        row(&mut out, ["=a", "-b,", "-2.5"]).expect("a vector takes it");
        assert_eq!(String::from_utf8_lossy(&out), "'=a,\"'-b,\",-2.5\r\n");
    }

    #[test]
    fn numbers_read_back_to_the_same_double() {
        for value in [0.1, -1e-300, 5e-324, 1e22, f64::MAX, 123_456.789] {
            assert_eq!(number(value).parse(), Ok(value));
        }
        assert!(number(1e-300).len() < 10);
        assert_eq!([number(f64::NAN), number(f64::INFINITY)], ["", ""]);
    }
}
