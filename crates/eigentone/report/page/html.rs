//! The frame of the page, and what text needs to stand in it.

use std::fmt::Write;

use crate::report::plot::escape;
use crate::report::table::{Align, Table};

/// A section with a heading to which the list at the top leads.
pub(super) struct Section {
    pub(super) id: &'static str,
    pub(super) heading: String,
    pub(super) body: String,
}

/// The one script that may run, and its SHA-256, by which the page allows it and no other.
const SCRIPT: &str = include_str!("script.js");
const SCRIPT_HASH: &str = "6JSvLDXazd1CNHRDHoOwI8MG/0DCO2X3TsiR9iMfk3M=";

/// A document that loads nothing.
pub(super) fn document(title: &str, lead: &str, sections: &[Section]) -> String {
    let title = escape(title);
    let mut out = format!(
        r##"<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; script-src 'sha256-{SCRIPT_HASH}'">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta name="generator" content="eigentone">
<title>{title}</title>
<style>
{}</style>
</head>
<body>
<header>
<h1>{title}</h1>
{lead}<nav aria-label="Sections">
"##,
        include_str!("style.css")
    );
    for section in sections {
        let _ = writeln!(
            out,
            r##"<a href="#{}">{}</a>"##,
            section.id,
            escape(&section.heading)
        );
    }
    out.push_str("</nav>\n</header>\n<main>\n");
    for Section { id, heading, body } in sections {
        let _ = write!(
            out,
            "<section id=\"{id}\">\n<h2>{}</h2>\n{body}</section>\n",
            escape(heading)
        );
    }
    let _ = write!(
        out,
        "</main>\n<script>{SCRIPT}</script>\n</body>\n</html>\n"
    );
    out
}

/// A paragraph of plain text.
pub(super) fn paragraph(text: &str) -> String {
    format!("<p>{}</p>\n", escape(text))
}

/// A remark in a paragraph of its own.
pub(super) fn remark(text: &str) -> String {
    format!("<p class=\"soft\">{}</p>\n", escape(text))
}

/// Lines of the form `term: explanation`; those without a term stand by themselves.
pub(super) fn definitions(lines: &str) -> String {
    let mut out = String::from("<dl>\n");
    for line in lines.lines() {
        let (term, text) = line.split_once(": ").unwrap_or((line, ""));
        let _ = writeln!(out, "<dt>{}</dt><dd>{}</dd>", escape(term), escape(text));
    }
    out + "</dl>\n"
}

/// A table that scrolls by itself where it is wider than the page.
pub(super) fn table(table: &Table) -> String {
    let mut out = String::from("<div class=\"scroll\" tabindex=\"0\"><table>\n<thead><tr>");
    let class = |align: Align| match align {
        Align::Left => " class=\"left\"",
        Align::Right | Align::Point => "",
    };
    for (header, align, _) in table.columns() {
        let _ = write!(
            out,
            "<th{} scope=\"col\">{}</th>",
            class(*align),
            escape(header)
        );
    }
    out.push_str("</tr></thead>\n<tbody>\n");
    for row in 0..table.rows() {
        out.push_str("<tr>");
        for (_, align, cells) in table.columns() {
            let cell = cells.get(row).map_or("", String::as_str);
            // Spaces that line up decimal points are as wide as digits.
            let digits = cell.trim_end_matches(' ');
            let pad = "\u{2007}".repeat(cell.len() - digits.len());
            let _ = write!(out, "<td{}>{}{pad}</td>", class(*align), escape(digits));
        }
        out.push_str("</tr>\n");
    }
    out + "</tbody>\n</table></div>\n"
}
