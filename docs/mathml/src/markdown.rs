//! Finds the formulas of a page, and the links that lead out of the book.

use crate::mathml::{block, inline};

/// The page with every formula as MathML, and without links to files that are not in the book, which is
/// `depth` folders above the page. Other code, blocks and spans alike, stays as it is.
pub fn convert(page: &str, depth: usize) -> Result<String, String> {
    let mut out = String::with_capacity(2 * page.len());
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        let mark = line.trim_start();
        let Some(fence) = ["```", "~~~"].into_iter().find(|f| mark.starts_with(f)) else {
            spans(&without_ways_out(line, depth), &mut out)?;
            out.push('\n');
            continue;
        };
        let inside = lines.by_ref().take_while(|line| line.trim() != fence);
        if mark == "```math" {
            let formula: Vec<&str> = inside.collect();
            out.push_str(&block(&formula.join("\n"))?);
            out.push('\n');
        } else {
            out.push_str(line);
            out.push('\n');
            inside.for_each(|line| {
                out.push_str(line);
                out.push('\n');
            });
            out.push_str(fence);
            out.push('\n');
        }
    }
    Ok(out)
}

/// The line with the text of each link in place of the link, if that leads too far up.
fn without_ways_out(line: &str, depth: usize) -> String {
    let way_out = format!("]({}", "../".repeat(depth + 1));
    let mut out = line.to_owned();
    while let Some(middle) = out.find(&way_out) {
        let (Some(open), Some(close)) = (out[..middle].rfind('['), out[middle..].find(')')) else {
            break;
        };
        out.replace_range(middle..=middle + close, "");
        out.replace_range(open..=open, "");
    }
    out
}

/// One line outside of blocks.
fn spans(line: &str, out: &mut String) -> Result<(), String> {
    let mut rest = line;
    while let Some(at) = rest.find(['`', '$', '\\']) {
        out.push_str(&rest[..at]);
        rest = &rest[at..];
        let end = match rest.as_bytes()[0] {
            b'`' => {
                let ticks = rest.len() - rest.trim_start_matches('`').len();
                let (mark, inside) = rest.split_at(ticks);
                inside.find(mark).map(|end| end + 2 * ticks)
            }
            b'$' => {
                // $`…`$ is for formulas with stars, which Markdown might take for its own.
                let (open, close) = match rest.starts_with("$`") {
                    true => ("$`", "`$"),
                    false => ("$", "$"),
                };
                let Some((formula, after)) = rest[open.len()..].split_once(close) else {
                    return Err(format!("a $ without its end in \"{line}\""));
                };
                out.push_str(&inline(formula)?);
                rest = after;
                continue;
            }
            _ => rest.chars().nth(1).map(|next| 1 + next.len_utf8()),
        };
        let (code, after) = rest.split_at(end.unwrap_or(rest.len()));
        out.push_str(code);
        rest = after;
    }
    out.push_str(rest);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn code_stays() {
        let page = "a `$x$` b\n\n```sh\necho $HOME $PATH\n```\n\\$5\n";
        assert_eq!(convert(page, 0).as_deref(), Ok(page));
    }

    #[test]
    fn formulas_change() {
        let page =
            convert("so $x^2$ is\n\n```math\nx = 1 \\tag{3}\n```\n", 0).expect("it is LaTeX");
        assert!(page.starts_with("so <math"));
        assert!(page.contains("</math> is\n"));
        assert!(page.contains("<div class=\"equation\"><math display=\"block\""));
        assert!(page.trim_end().ends_with("<span>(3)</span></div>"));
    }

    #[test]
    fn stars_are_no_emphasis() {
        let page = convert("$`A^*`$ and $`B^*`$", 0).expect("it is LaTeX");
        assert_eq!(page.matches("<math").count(), 2);
        assert!(!page.contains('*') && !page.contains('`'));
    }

    #[test]
    fn links_stay_in_the_book() {
        let page = "[a](../a.md), [b](../../tests/b) and [c](c.md)";
        let inside = "[a](../a.md), b and [c](c.md)\n";
        assert_eq!(convert(page, 1).as_deref(), Ok(inside));
        assert_eq!(convert(page, 0).as_deref(), Ok("a, b and [c](c.md)\n"));
    }

    #[test]
    fn what_is_wrong_is_said() {
        assert!(convert("cost $5", 0).is_err());
        assert!(convert("$\\nosuchcommand$", 0).is_err());
    }
}
