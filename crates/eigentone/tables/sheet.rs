//! One table in four forms: Markdown, CSV, JSON and LaTeX.

use std::fmt::Write;

use super::value::Value;
use crate::report::csv;
use crate::report::table::{markdown_text, visible};

/// A column: what it is called in programs, and what people read above it.
pub(super) struct Column {
    /// Its key in JSON.
    pub(super) key: &'static str,
    /// Its symbol or word in Markdown.
    pub(super) head: &'static str,
    /// The same in LaTeX.
    pub(super) latex: &'static str,
    /// Its unit; empty for a pure number and for words.
    pub(super) unit: &'static str,
}

impl Column {
    pub(super) fn of(
        key: &'static str,
        head: &'static str,
        latex: &'static str,
        unit: &'static str,
    ) -> Column {
        Column {
            key,
            head,
            latex,
            unit,
        }
    }
}

/// What stands in one place.
#[derive(Clone, Debug)]
pub(super) enum Cell {
    Value(Value),
    /// A number that a person chose, without zeros at its end.
    Chosen(Value),
    Whole(u64),
    Text(String),
    None,
}

pub(super) struct Sheet {
    pub(super) columns: Vec<Column>,
    pub(super) rows: Vec<Vec<Cell>>,
}

impl Sheet {
    /// A Markdown table.
    pub(super) fn markdown(&self) -> String {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let heads = self.columns.iter().map(|column| match column.unit {
            "" => column.head.to_owned(),
            unit => format!("{}, {unit}", column.head),
        });
        let rules = self.columns.iter().enumerate().map(|(i, _)| {
            let words = |row: &Vec<Cell>| matches!(row.get(i), Some(Cell::Text(_)));
            if self.rows.iter().any(words) {
                ":--"
            } else {
                "--:"
            }
            .to_owned()
        });
        let mut out = line(heads.collect()) + &line(rules.collect());
        for row in &self.rows {
            let cells = row.iter().map(|cell| match cell {
                Cell::Value(value) if value.is_open() => value.to_string().replace('<', "&lt;"),
                Cell::Value(value) => value.to_string(),
                Cell::Chosen(value) => value.trimmed(),
                Cell::Whole(number) => number.to_string(),
                Cell::Text(text) => markdown_text(text),
                Cell::None => "–".to_owned(),
            });
            out.push_str(&line(cells.collect()));
        }
        out
    }

    /// Comma-separated values as RFC 4180 has them, with units in the header.
    pub(super) fn csv(&self) -> String {
        let mut out = Vec::new();
        let heads = self.columns.iter().map(|column| match column.unit {
            "" => column.key.to_owned(),
            unit => format!("{} [{unit}]", column.key),
        });
        let rows = self.rows.iter().map(|row| {
            let cells = row.iter().map(|cell| match cell {
                Cell::Value(value) => value.to_string(),
                Cell::Chosen(value) => value.trimmed(),
                Cell::Whole(number) => number.to_string(),
                Cell::Text(text) => text.clone(),
                Cell::None => String::new(),
            });
            cells.collect::<Vec<String>>()
        });
        for row in std::iter::once(heads.collect()).chain(rows) {
            csv::row(&mut out, row).expect("a vector takes it");
        }
        String::from_utf8(out).expect("it was made of text")
    }

    /// An array of objects, one for each row; what there is no number for is null.
    pub(super) fn json(&self, indent: &str) -> String {
        let rows = self.rows.iter().map(|row| {
            let entries = self.columns.iter().zip(row).map(|(column, cell)| {
                let cell = match cell {
                    Cell::Value(value) => value.json(),
                    Cell::Chosen(value) => value.trimmed(),
                    Cell::Whole(number) => number.to_string(),
                    Cell::Text(text) => json_text(text),
                    Cell::None => "null".to_owned(),
                };
                format!("\"{}\":{cell}", column.key)
            });
            format!(
                "{indent}  {{{}}}",
                entries.collect::<Vec<String>>().join(",")
            )
        });
        let rows: Vec<String> = rows.collect();
        match rows.is_empty() {
            true => "[]".to_owned(),
            false => format!("[\n{}\n{indent}]", rows.join(",\n")),
        }
    }

    /// A `tabular` that needs no package.
    pub(super) fn latex(&self) -> String {
        let mut out = String::from("\\begin{tabular}{");
        for (i, _) in self.columns.iter().enumerate() {
            let words = |row: &Vec<Cell>| matches!(row.get(i), Some(Cell::Text(_)));
            out.push(if self.rows.iter().any(words) {
                'l'
            } else {
                'r'
            });
        }
        out.push_str("}\n\\hline\n");
        let heads = self.columns.iter().map(|column| match column.unit {
            "" => column.latex.to_owned(),
            unit => format!("{}, {unit}", column.latex),
        });
        let _ = writeln!(
            out,
            "{} \\\\\n\\hline",
            heads.collect::<Vec<String>>().join(" & ")
        );
        for row in &self.rows {
            let cells = row.iter().map(|cell| match cell {
                Cell::Value(value) => value.latex(),
                Cell::Chosen(value) => format!("${}$", value.trimmed()),
                Cell::Whole(number) => number.to_string(),
                Cell::Text(text) => latex_text(text),
                Cell::None => "--".to_owned(),
            });
            let _ = writeln!(out, "{} \\\\", cells.collect::<Vec<String>>().join(" & "));
        }
        out + "\\hline\n\\end{tabular}\n"
    }
}

/// Text in which nothing is taken for a command.
pub(super) fn latex_text(text: &str) -> String {
    let mut out = String::new();
    for c in visible(text).chars() {
        match c {
            '\\' => out.push_str("\\textbackslash{}"),
            '~' => out.push_str("\\textasciitilde{}"),
            '^' => out.push_str("\\textasciicircum{}"),
            '<' => out.push_str("\\textless{}"),
            '>' => out.push_str("\\textgreater{}"),
            '{' | '}' | '$' | '&' | '#' | '_' | '%' => {
                out.push('\\');
                out.push(c);
            }
            c => out.push(c),
        }
    }
    out
}

/// A JSON string.
pub(super) fn json_text(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(name: &str) -> Sheet {
        Sheet {
            columns: vec![
                Column::of("coordinate", "coordinate", "coordinate", ""),
                Column::of("x", "x", "$x$", "m"),
            ],
            rows: vec![vec![Cell::Text(name.to_owned()), Cell::None]],
        }
    }

    #[test]
    fn a_hostile_name_stays_a_name_in_every_form() {
        let sheet = sheet("<script>|\\input{x}%\n\"*_`,[a](b)");
        let markdown = sheet.markdown();
        assert!(!markdown.contains('<') && markdown.lines().count() == 3);
        let cells = markdown.lines().last().expect("a row").replace("\\|", "");
        assert_eq!(cells.matches('|').count(), 3, "{cells}");
        let latex = sheet.latex();
        assert!(!latex.contains("\\input") && latex.contains("\\textbackslash{}input\\{x\\}\\%"));
        let json: serde_json::Value = serde_json::from_str(&sheet.json("")).expect("JSON");
        assert_eq!(json[0]["coordinate"], "<script>|\\input{x}%\n\"*_`,[a](b)");
        assert!(json[0]["x"].is_null());
        assert!(
            sheet
                .csv()
                .ends_with("\"<script>|\\input{x}%\n\"\"*_`,[a](b)\",\r\n")
        );
        assert!(sheet.csv().starts_with("coordinate,x [m]\r\n"));
        let formula = self::sheet("=cmd|'/C calc'!A1").csv();
        assert!(formula.contains("\r\n'=cmd|"), "{formula}");
    }
}
