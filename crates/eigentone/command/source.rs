//! Where the scene comes from: a file, or standard input.

use std::io;
use std::path::{Path, PathBuf};

use clap::builder::{PathBufValueParser, TypedValueParser};
use eigentone::scene::{SceneError, read_text};

/// What messages call standard input. A file of this name is `./<stdin>` on the command line.
const STANDARD_INPUT: &str = "<stdin>";

/// Reads the argument that names a scene: `-` is standard input.
pub fn parser() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().map(|path| match path.as_os_str() == "-" {
        true => PathBuf::from(STANDARD_INPUT),
        false => path,
    })
}

/// What files that belong to the scene are called: by its name, without signs that file systems refuse.
pub fn stem(scene: &Path) -> String {
    let stem = match scene.as_os_str() == STANDARD_INPUT {
        true => STANDARD_INPUT.trim_matches(['<', '>']).into(),
        false => scene
            .file_stem()
            .unwrap_or(scene.as_os_str())
            .to_string_lossy(),
    };
    stem.into_owned()
}

/// The text of the scene; that of standard input can be read once.
pub fn text(scene: &Path) -> Result<String, SceneError> {
    match scene.as_os_str() == STANDARD_INPUT {
        true => read_text(io::stdin().lock(), scene),
        false => eigentone::scene::read_file(scene),
    }
}
