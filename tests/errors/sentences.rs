//! Every sentence of answers, pages and help, for eyes: `docs/sentences.md` lists each once, with `#` for numbers.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use eigentone::gallery::{Case, cases, machines, switches};
use rayon::prelude::*;

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
const ASKED_OF_ONE: [(&str, &[&str]); 10] = [
    ("three-mass-1", &["analyze", "--precision", "double"]),
    (
        "quarter-car-bump",
        &["check", "--methods", "certified exponential,exponential"],
    ),
    (
        "two-mass-forced",
        &["sweep", "--vary", "/springs/0/stiffness=1:3:3"],
    ),
    (
        "two-mass-forced",
        &[
            "optimise",
            "--vary",
            "/dampers/1/damping=0.5:4",
            "--minimise",
            "gain m2 m2",
        ],
    ),
    (
        "two-mass-forced",
        &["fit", "--vary", "/springs/0/stiffness", "--to", MEASURED],
    ),
    ("two-mass-forced", &["campbell", "--speeds", "0:2:3"]),
    ("one-mass-resonance", &["cycle", "--cycles", "1"]),
    ("belt-stick-slip", &["cycle"]),
    ("two-mass-forced", &["modes", "--lowest", "1"]),
    ("quarter-car-kerb", &["frf", "--at", "1,2"]),
];

/// Stands for a table of measurements.
const MEASURED: &str = "FILE";
/// Scenes whose pages have between them all that pages have.
const PAGES: [(&str, &str); 3] = [
    (".", "three-mass-5"),
    ("machines", "half-car"),
    ("switches", "belt-stick-slip"),
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

/// What is printed of a command, or of all of them.
fn help(command: Option<&str>) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_eigentone"))
        .args(command)
        .arg("-h")
        .output()
        .expect("the binary runs");
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// What a page says, markup and script apart, and what its script says.
fn page_of(folder: &Path, name: &str) -> Vec<String> {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sentences");
    let done = Command::new(env!("CARGO_BIN_EXE_eigentone"))
        .current_dir(folder)
        .args(["analyze", &format!("{name}.json"), "--out"])
        .arg(&out)
        .output()
        .expect("the binary runs");
    assert!(done.status.success());
    let html = fs::read_to_string(out.join("report.html")).expect("it was written");
    let (html, rest) = html.split_once("<script>").expect("a script");
    let (script, _) = rest.split_once("</script>").expect("its end");
    let body = html.split("</style>").nth(1).expect("a style");
    let texts = body
        .split('<')
        .filter_map(|part| Some(part.split_once('>')?.1));
    let labels = script.split('"').skip(1).step_by(2);
    let all = texts.chain(labels.filter(|text| text.starts_with(char::is_uppercase)));
    let plain = all.map(|text| {
        text.replace("&lt;", "<")
            .replace("&gt;", ">")
            .replace("&amp;", "&")
    });
    plain
        .map(|text| text.split_whitespace().collect::<Vec<_>>().join(" "))
        .collect()
}

#[test]
fn every_sentence_is_listed() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gallery");
    let measured = Path::new(env!("CARGO_TARGET_TMPDIR")).join("measured.csv");
    fs::write(&measured, "natural_frequency [rad/s]\n0.5\n1.5\n").expect("it can be written");
    let measured = measured.to_str().expect("a UTF-8 path");
    let mut found: Vec<(String, Vec<String>)> = Vec::new();
    // Each under the first heading that has it.
    let mut listed = BTreeSet::new();
    let mut add = |heading: &str, said: String| {
        if !listed.insert(said.clone()) {
            return;
        }
        match found.iter_mut().find(|(known, _)| known == heading) {
            Some((_, all)) => all.push(said),
            None => found.push((heading.to_owned(), vec![said])),
        }
    };
    let mut runs = Vec::new();
    for (folder, all) in [
        (".", cases()),
        ("machines", machines()),
        ("switches", switches()),
    ] {
        for case in all.iter().filter(|case| case.name() != LONG) {
            let own = ASKED_OF_ONE.iter().filter(|(name, _)| *name == case.name());
            for asked in ASKED.into_iter().chain(own.map(|(_, asked)| *asked)) {
                runs.push((folder, case, asked));
            }
        }
    }
    let answer = |&(folder, case, asked): &(&str, &Case, &[&str])| {
        let output = Command::new(env!("CARGO_BIN_EXE_eigentone"))
            .current_dir(root.join(folder).join("scenes"))
            .args([asked[0], &format!("{}.json", case.name())])
            .args(asked[1..].iter().map(|word| match *word {
                MEASURED => measured,
                word => word,
            }))
            .output()
            .expect("the binary runs");
        [output.stdout, output.stderr].concat()
    };
    let answers: Vec<Vec<u8>> = runs.par_iter().map(answer).collect();
    for ((_, case, asked), said) in runs.iter().zip(answers) {
        let title = case.scene().title().and_then(sentence);
        let said = String::from_utf8_lossy(&said).replace(measured, MEASURED);
        for line in said.lines() {
            if let Some(said) = sentence(line).filter(|said| Some(said) != title.as_ref()) {
                add(
                    asked[0],
                    said.replace(&format!("{}.json", case.name()), "SCENE"),
                );
            }
        }
    }
    for (folder, name) in PAGES {
        for said in page_of(&root.join(folder).join("scenes"), name) {
            // Not what belongs to one scene.
            let is_common = |said: &String| said.split(' ').count() > 4 && !said.contains("λ = ");
            if let Some(said) = sentence(&said).filter(is_common) {
                add("report.html", said);
            }
        }
    }
    let front = help(None);
    let commands = front
        .lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1);
    let commands = commands.map_while(|line| line.split_whitespace().next());
    for command in std::iter::once(None).chain(commands.map(Some)) {
        for line in help(command).lines() {
            // What an option is called stands before a gap.
            let said = line.trim().rsplit("  ").next().unwrap_or_default();
            if let Some(said) = sentence(said.trim()) {
                add("--help", said);
            }
        }
    }
    let mut text = String::new();
    for (heading, sentences) in found {
        let _ = writeln!(text, "### {heading}\n\n```text");
        for sentence in sentences {
            let _ = writeln!(text, "{sentence}");
        }
        text.push_str("```\n\n");
    }
    page::assert_shown("sentences.md", "sentences", text.trim_end());
}
