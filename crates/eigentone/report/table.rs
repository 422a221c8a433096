//! A table of text cells, for the terminal and for Markdown.

use std::fmt::Write;

/// How a column lines up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Align {
    /// At its left edge.
    Left,
    /// At its right edge.
    Right,
    /// Numbers at their decimal point, anything else at the right edge.
    Point,
}

/// Columns of equal length, each under its header.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    columns: Vec<(String, Align, Vec<String>)>,
}

impl Table {
    /// Adds a column; control characters in its cells are made visible.
    pub(crate) fn column<T: AsRef<str>>(
        mut self,
        header: &str,
        align: Align,
        cells: impl IntoIterator<Item = T>,
    ) -> Table {
        let cells = cells.into_iter().map(|cell| visible(cell.as_ref()));
        let mut cells: Vec<String> = cells.collect();
        if align == Align::Point {
            let longest = cells.iter().filter_map(|cell| behind_point(cell)).max();
            for cell in &mut cells {
                if let (Some(longest), Some(behind)) = (longest, behind_point(cell)) {
                    cell.extend(std::iter::repeat_n(' ', longest - behind));
                }
            }
        }
        self.columns.push((visible(header), align, cells));
        self
    }

    /// Header, alignment and cells of each.
    pub(super) fn columns(&self) -> &[(String, Align, Vec<String>)] {
        &self.columns
    }

    pub(super) fn rows(&self) -> usize {
        let lengths = self.columns.iter().map(|(_, _, cells)| cells.len());
        lengths.max().unwrap_or(0)
    }

    /// Aligned columns two spaces apart, one line a row, the header first.
    pub(crate) fn text(&self) -> String {
        let widths: Vec<usize> = self
            .columns
            .iter()
            .map(|(header, _, cells)| {
                let all = std::iter::once(header).chain(cells);
                all.map(|cell| cell.chars().count()).max().unwrap_or(0)
            })
            .collect();
        let mut out = String::new();
        for row in 0..=self.rows() {
            let mut line = String::new();
            for ((header, align, cells), &width) in self.columns.iter().zip(&widths) {
                let cell = match row {
                    0 => header.as_str(),
                    _ => cells.get(row - 1).map_or("", String::as_str),
                };
                let _ = match align {
                    Align::Left => write!(line, "{cell:<width$}  "),
                    Align::Right | Align::Point => write!(line, "{cell:>width$}  "),
                };
            }
            out.push_str(line.trim_end());
            out.push('\n');
        }
        out
    }

    /// The same as a Markdown table.
    pub(crate) fn markdown(&self) -> String {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        // Behind a bar no line begins, and no heading.
        let escape = |cell: &str| markdown_text(cell.trim()).replace("\\#", "#");
        let headers = self.columns.iter().map(|(header, ..)| escape(header));
        let rules = self.columns.iter().map(|(_, align, _)| match align {
            Align::Left => ":--".to_owned(),
            Align::Right | Align::Point => "--:".to_owned(),
        });
        let mut out = line(headers.collect()) + &line(rules.collect());
        for row in 0..self.rows() {
            let cells = self.columns.iter();
            let cells =
                cells.map(|(_, _, cells)| cells.get(row).map_or_else(String::new, |c| escape(c)));
            out.push_str(&line(cells.collect()));
        }
        out
    }
}

/// Text in which nothing is taken for Markdown or HTML.
pub(crate) fn markdown_text(text: &str) -> String {
    let mut out = String::new();
    for c in visible(text).chars() {
        match c {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '\\' | '|' | '`' | '*' | '_' | '[' | ']' | '#' | '~' | '$' | '!' => {
                out.push('\\');
                out.push(c);
            }
            c => out.push(c),
        }
    }
    out
}

/// How many letters a number has from its decimal point on; `None` if it is no number.
fn behind_point(cell: &str) -> Option<usize> {
    let number = cell
        .trim_start_matches('−')
        .starts_with(|c: char| c.is_ascii_digit());
    let point = cell.find('.').unwrap_or(cell.len());
    number.then(|| cell[point..].chars().count())
}

/// Text in which nothing can break a line or command a terminal.
pub(crate) fn visible(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() {
            out.extend(c.escape_debug());
        } else {
            out.push(c);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        Table::default()
            .column("mass", Align::Left, ["m1", "a|b", "<b>evil\n\u{1b}[2J"])
            .column("x, m", Align::Right, ["1.5", "−20.25", "–"])
    }

    #[test]
    fn columns_line_up_whatever_the_cells() {
        let text = table().text();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 4);
        let ends: Vec<usize> = lines.iter().map(|line| line.chars().count()).collect();
        assert!(ends.iter().all(|end| *end == ends[0]), "{text}");
        assert!(!text.contains('\u{1b}'));
    }

    #[test]
    fn points_stand_under_each_other() {
        let cells = ["1.5", "−20.25", "0", "–", "not yet", "3.00000e−9"];
        let text = Table::default().column("x", Align::Point, cells).text();
        let at = |line: &str| line.chars().position(|c| c == '.');
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(at(lines[1]), at(lines[2]));
        assert_eq!(at(lines[1]), at(lines[6]));
        // A whole number ends where the others have their point.
        assert_eq!(Some(lines[3].chars().count()), at(lines[1]));
    }

    #[test]
    fn markdown_has_as_many_bars_in_every_line() {
        let text = table().markdown();
        for line in text.lines() {
            assert_eq!(line.replace("\\|", "").matches('|').count(), 3, "{line}");
        }
        assert_eq!(text.lines().count(), 5);
        assert!(text.contains("&lt;b&gt;evil"), "{text}");
    }
}
