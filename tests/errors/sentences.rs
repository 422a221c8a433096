//! Every sentence that commands print of the gallery, for eyes: `docs/sentences.md` lists each once, with `#` for numbers.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use eigentone::gallery::{Case, cases, machines, switches};

use crate::page;

/// A motion of a million seconds says nothing that others do not.
const LONG: &str = "undamped-long";
/// What is asked of each scene.
const ASKED: [&[&str]; 6] = [
    &["analyze", "--explain"],
    &["modes"],
    &["response", "--steps", "0,1,2"],
    &["frf"],
    &["random"],
    &["export"],
];
/// What is asked of one scene.
const ASKED_OF_ONE: [(&str, &[&str]); 3] = [
    ("three-mass-1", &["analyze", "--precision", "double"]),
    (
        "quarter-car-bump",
        &["check", "--methods", "certified exponential,exponential"],
    ),
    (
        "two-mass-forced",
        &["sweep", "--vary", "/springs/0/stiffness=1:3:3"],
    ),
];

/// The line without numbers, if it is a sentence: rows of tables have gaps.
fn sentence(line: &str) -> Option<String> {
    let line = line.trim();
    if line.contains("  ") || line.split(' ').count() < 3 || line.starts_with("error: ") {
        return None;
    }
    let words = line.split(' ').map(|word| {
        let bare = word
            .trim_end_matches([',', ';', '.', ':', ')'])
            .trim_start_matches('(');
        let digits = bare.replace('−', "-");
        match digits.parse::<f64>() {
            Ok(_) => word.replace(bare, "#"),
            Err(_) => word.to_owned(),
        }
    });
    Some(words.collect::<Vec<_>>().join(" "))
}

#[test]
fn every_sentence_is_listed() {
    let mut found: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let mut ask = |folder: &str, case: &Case, asked: &[&str]| {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gallery");
        let output = Command::new(env!("CARGO_BIN_EXE_eigentone"))
            .current_dir(root.join(folder).join("scenes"))
            .arg(asked[0])
            .arg(format!("{}.json", case.name()))
            .args(&asked[1..])
            .output()
            .expect("the binary runs");
        let title = case.scene().title().map(str::to_owned);
        let all = [output.stdout, output.stderr].concat();
        for line in String::from_utf8_lossy(&all).lines() {
            let Some(sentence) = sentence(line).filter(|line| Some(line) != title.as_ref()) else {
                continue;
            };
            // Under the first command that says it.
            let sentence = sentence.replace(&format!("{}.json", case.name()), "SCENE");
            if found.values().flatten().all(|known| *known != sentence) {
                found.entry(asked[0].to_owned()).or_default().push(sentence);
            }
        }
    };
    for (folder, all) in [
        (".", cases()),
        ("machines", machines()),
        ("switches", switches()),
    ] {
        for case in all.iter().filter(|case| case.name() != LONG) {
            for asked in ASKED {
                ask(folder, case, asked);
            }
            for (_, asked) in ASKED_OF_ONE.iter().filter(|(name, _)| *name == case.name()) {
                ask(folder, case, asked);
            }
        }
    }
    let mut text = String::new();
    for (command, sentences) in found {
        let _ = writeln!(text, "### {command}\n\n```text");
        for sentence in sentences {
            let _ = writeln!(text, "{sentence}");
        }
        text.push_str("```\n\n");
    }
    page::assert_shown("sentences.md", "sentences", text.trim_end());
}
