//! Words of the user within a message, and what they may have meant.

/// A text cut to a length that fits a message.
pub(super) fn excerpt(text: &str) -> String {
    const LONGEST: usize = 60;
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

/// What may have been meant by an unknown word: the known one nearest to it if one is near, or all
/// of them.
///
/// ```
/// use eigentone::scene::did_you_mean;
///
/// assert_eq!(did_you_mean("boddy", &["body", "wheel"]), "did you mean \"body\"?");
/// assert_eq!(did_you_mean("x", &["body", "wheel"]), "known are \"body\" and \"wheel\"");
/// assert_eq!(did_you_mean("soil", &[] as &[&str]), "there is none");
/// ```
#[must_use]
pub fn did_you_mean(word: &str, known: &[impl AsRef<str>]) -> String {
    const SHOWN: usize = 12;
    if known.is_empty() {
        return "there is none".to_owned();
    }
    if let Some(near) = nearest(word, known) {
        return format!("did you mean {:?}?", excerpt(near));
    }
    let shown = if known.len() > SHOWN + 1 {
        SHOWN
    } else {
        known.len()
    };
    let mut words: Vec<String> = known[..shown]
        .iter()
        .map(|word| format!("{:?}", excerpt(word.as_ref())))
        .collect();
    if known.len() > shown {
        words.push(format!("{} more", known.len() - shown));
    }
    let verb = if known.len() == 1 { "is" } else { "are" };
    format!("known {verb} {}", listed(words.into_iter(), "and"))
}

/// Words in a row, the last one behind `last`.
pub(super) fn listed(words: impl Iterator<Item = String>, last: &str) -> String {
    let mut words: Vec<String> = words.collect();
    match words.pop() {
        Some(word) if words.is_empty() => word,
        Some(word) => format!("{} {last} {word}", words.join(", ")),
        None => String::new(),
    }
}

/// The known word at the smallest edit distance, if at most one letter in three is wrong.
fn nearest<'a>(word: &str, known: &'a [impl AsRef<str>]) -> Option<&'a str> {
    const LONGEST: usize = 64;
    let length = word.chars().count();
    if length > LONGEST {
        return None;
    }
    let lower = word.to_lowercase();
    known
        .iter()
        .map(AsRef::as_ref)
        .filter(|candidate| candidate.len() <= 4 * LONGEST)
        .map(|candidate| {
            (
                strsim::osa_distance(&lower, &candidate.to_lowercase()),
                candidate,
            )
        })
        .filter(|(distance, _)| 3 * distance <= length)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}
