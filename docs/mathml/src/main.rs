//! An mdBook preprocessor: LaTeX formulas become MathML, and links out of the book plain text.
//!
//! The same Markdown is read on GitHub, which renders `$…$` and ```` ```math ```` blocks by itself. A block
//! that ends in `\tag{N}` is equation (N). A formula that cannot be turned into MathML stops the build.

mod markdown;
mod mathml;

use std::error::Error;
use std::io;
use std::process::ExitCode;

use serde_json::Value;

fn main() -> ExitCode {
    // mdBook first asks which renderers are served.
    let mut arguments = std::env::args().skip(1);
    if arguments.next().as_deref() == Some("supports") {
        return match arguments.next().as_deref() {
            Some("html") => ExitCode::SUCCESS,
            _ => ExitCode::FAILURE,
        };
    }
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("book-mathml: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let input: Value = serde_json::from_reader(io::stdin())?;
    let Value::Array(parts) = input else {
        return Err("expected [context, book]".into());
    };
    let mut book = parts.into_iter().nth(1).ok_or("expected [context, book]")?;
    convert_chapters(&mut book)?;
    serde_json::to_writer(io::stdout(), &book)?;
    Ok(())
}

/// Chapters are nested objects whose text is their `content`.
fn convert_chapters(value: &mut Value) -> Result<(), String> {
    match value {
        Value::Array(items) => items.iter_mut().try_for_each(convert_chapters),
        Value::Object(fields) => {
            let path = fields.get("path").and_then(Value::as_str);
            let place = path.unwrap_or("a page").to_owned();
            let depth = place.matches('/').count();
            for (key, field) in fields.iter_mut() {
                match field {
                    Value::String(text) if key == "content" => {
                        *text = markdown::convert(text, depth)
                            .map_err(|why| format!("{place}: {why}"))?;
                    }
                    other => convert_chapters(other)?,
                }
            }
            Ok(())
        }
        _ => Ok(()),
    }
}
