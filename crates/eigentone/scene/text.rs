//! From a file to text, and from text to the layout of a scene.

use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

use serde_json::error::Category;
use serde_path_to_error::Segment;

use super::error::{MAX_BYTES, SceneError};
use super::layout;
use super::place::{self, Place, Step};
use super::shape::Object;

/// The text of a scene file, if it is a file, not too large, and text: what [`Scene::read`](super::Scene::read) parses.
///
/// # Errors
/// [`SceneError`] naming the file and what is wrong with it.
pub fn read_file(path: &Path) -> Result<String, SceneError> {
    let file = path.to_owned();
    let failed = |source| SceneError::Read {
        file: path.to_owned(),
        source,
    };
    // To open a pipe would wait for its other end.
    let metadata = fs::metadata(path).map_err(failed)?;
    if metadata.is_dir() {
        return Err(SceneError::Directory { file });
    }
    if !metadata.is_file() {
        return Err(SceneError::NotFile { file });
    }
    if metadata.len() > MAX_BYTES {
        return Err(SceneError::TooLarge { file });
    }
    // It may have grown.
    read_text(File::open(path).map_err(failed)?, path)
}

/// The text of a scene that comes from elsewhere, such as standard input, if it is not too large, and text; `file` is
/// named in errors.
///
/// # Errors
/// As [`read_file`].
pub fn read_text(input: impl Read, file: &Path) -> Result<String, SceneError> {
    let file = file.to_owned();
    let mut bytes = Vec::new();
    if let Err(source) = input.take(MAX_BYTES + 1).read_to_end(&mut bytes) {
        return Err(SceneError::Read { file, source });
    }
    if bytes.len() as u64 > MAX_BYTES {
        return Err(SceneError::TooLarge { file });
    }
    String::from_utf8(bytes).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let before = String::from_utf8_lossy(valid);
        let (line, column) = place::line_and_column(&before, before.len());
        SceneError::NotUtf8 {
            at: Place {
                file,
                path: String::new(),
                line,
                column,
            },
        }
    })
}

/// The text of a scene and the name of its file.
pub(super) struct Source<'a> {
    text: &'a str,
    file: &'a Path,
}

impl<'a> Source<'a> {
    /// The text without a byte order mark.
    pub(super) fn new(text: &'a str, file: &'a Path) -> Result<Source<'a>, SceneError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        if text.trim().is_empty() {
            let file = file.to_owned();
            return Err(SceneError::Empty { file });
        }
        Ok(Source { text, file })
    }

    /// A path that is relative to the scene's file.
    pub(super) fn beside(&self, path: &str) -> PathBuf {
        match self.file.parent() {
            Some(directory) => directory.join(path),
            None => PathBuf::from(path),
        }
    }

    /// The scene as it is laid out in JSON, with nothing checked but its form.
    pub(super) fn layout(&self) -> Result<layout::Scene, SceneError> {
        // To know the place of what is wrong takes longer than to read what is right.
        if let Ok(Object(scene)) = serde_json::from_str(self.text) {
            return Ok(scene);
        }
        let mut json = serde_json::Deserializer::from_str(self.text);
        let scene: Object<layout::Scene> = serde_path_to_error::deserialize(&mut json)
            .map_err(|error| self.refusal(steps(error.path()), error.into_inner()))?;
        json.end()
            .map_err(|error| self.refusal(Vec::new(), error))?;
        Ok(scene.0)
    }

    /// The place of the value that the steps lead to.
    pub(super) fn place(&self, steps: Vec<Step>) -> Place {
        self.place_at(&steps, place::offset(self.text, &steps))
    }

    fn place_at(&self, steps: &[Step], offset: usize) -> Place {
        let (line, column) = place::line_and_column(self.text, offset);
        Place {
            file: self.file.to_owned(),
            path: place::written(steps),
            line,
            column,
        }
    }

    /// What a JSON error means for a scene.
    fn refusal(&self, steps: Vec<Step>, source: serde_json::Error) -> SceneError {
        let lines = self
            .text
            .split_inclusive('\n')
            .take(source.line().max(1) - 1);
        let offset = lines.map(str::len).sum::<usize>() + source.column().max(1) - 1;
        let at = self.place_at(&steps, offset);
        if source.classify() == Category::Data {
            return SceneError::Shape { at, source };
        }
        let word = word_around(self.text, offset);
        let magnitude = word.trim_start_matches(['+', '-']);
        match magnitude.parse::<f64>() {
            Ok(value) if !value.is_finite() => SceneError::NotFinite {
                at,
                number: super::words::excerpt(word),
            },
            _ => SceneError::NotJson { at, source },
        }
    }
}

/// The steps of a path, as far as they are known.
fn steps(path: &serde_path_to_error::Path) -> Vec<Step> {
    path.iter()
        .map_while(|segment| match segment {
            Segment::Seq { index } => Some(Step::Index(*index)),
            Segment::Map { key } => Some(Step::Key(key.clone())),
            Segment::Enum { .. } | Segment::Unknown => None,
        })
        .collect()
}

/// The run of letters, digits, signs and points that includes an offset.
fn word_around(text: &str, offset: usize) -> &str {
    let part = |byte: &u8| byte.is_ascii_alphanumeric() || b"+-.".contains(byte);
    let bytes = text.as_bytes();
    let is_between = |at: &usize| text.is_char_boundary(*at);
    // The reader stops at a byte, which may lie within a letter.
    let offset = (0..=offset.min(bytes.len())).rfind(is_between).unwrap_or(0);
    let before = bytes[..offset].iter().rev().take_while(|b| part(b)).count();
    let after = bytes[offset..].iter().take_while(|b| part(b)).count();
    &text[offset - before..offset + after]
}
