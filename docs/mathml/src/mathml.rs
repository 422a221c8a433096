//! One formula.

use pulldown_latex::config::{DisplayMode, RenderConfig};
use pulldown_latex::{Parser, Storage, push_mathml};

/// A formula within a line. Markdown must not find marks of its own in it.
pub fn inline(latex: &str) -> Result<String, String> {
    let mathml = convert(latex, DisplayMode::Inline)?;
    let mut out = String::with_capacity(mathml.len());
    let mut tag = false;
    for letter in mathml.chars() {
        match letter {
            '<' => tag = true,
            '>' => tag = false,
            _ => {}
        }
        match letter {
            '*' | '_' | '`' | '[' | ']' | '\\' | '~' | '|' | '$' if !tag => {
                out.push_str(&format!("&#{};", letter as u32));
            }
            '\n' => out.push(' '),
            _ => out.push(letter),
        }
    }
    Ok(out)
}

/// A formula by itself, with its number if it has a `\tag`.
pub fn block(latex: &str) -> Result<String, String> {
    let (formula, number) = match latex.split_once("\\tag{") {
        Some((formula, rest)) => {
            let number = rest.split_once('}').ok_or("\\tag without its end")?.0;
            (formula, format!("<span>({number})</span>"))
        }
        None => (latex, String::new()),
    };
    let mathml = convert(formula, DisplayMode::Block)?.replace('\n', " ");
    Ok(format!("<div class=\"equation\">{mathml}{number}</div>\n"))
}

fn convert(latex: &str, display_mode: DisplayMode) -> Result<String, String> {
    let storage = Storage::new();
    let events: Result<Vec<_>, _> = Parser::new(latex, &storage).collect();
    let events = events.map_err(|error| format!("{latex}: {error}"))?;
    let config = RenderConfig {
        display_mode,
        ..RenderConfig::default()
    };
    let mut out = String::new();
    let events = events.into_iter().map(Ok::<_, std::convert::Infallible>);
    push_mathml(&mut out, events, config).map_err(|error| format!("{latex}: {error}"))?;
    Ok(out)
}
