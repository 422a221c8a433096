//! The pages in docs/ and every other Markdown file: links and pictures are there, formulas are numbered
//! and tested, examples print what is shown.

#[path = "docs/guarantees.rs"]
mod guarantees;
#[path = "docs/readme.rs"]
mod readme;

mod page;

use std::collections::{BTreeSet, HashMap};
use std::fs;
use std::path::{Component, Path, PathBuf};
use std::process::Command;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// All files below a folder whose names end like this, without those that are built.
fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("it can be listed") {
            let path = entry.expect("it can be listed").path();
            let name = path
                .file_name()
                .and_then(|name| name.to_str())
                .unwrap_or("");
            if path.is_dir() {
                if name != "target" && !name.starts_with('.') {
                    folders.push(path);
                }
            } else if name.ends_with(ending) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// A fenced block, and the line before it.
struct Block {
    before: String,
    language: String,
    text: String,
}

/// A page's blocks, and its lines outside of them.
fn parts(page: &str) -> (Vec<Block>, Vec<String>) {
    let (mut blocks, mut prose) = (Vec::new(), Vec::<String>::new());
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        let Some(language) = line.strip_prefix("```") else {
            prose.push(line.to_owned());
            continue;
        };
        let inside = lines.by_ref().take_while(|line| !line.starts_with("```"));
        blocks.push(Block {
            before: prose.last().cloned().unwrap_or_default(),
            language: language.to_owned(),
            text: inside.map(|line| format!("{line}\n")).collect(),
        });
    }
    (blocks, prose)
}

/// The line without its code spans and formulas.
fn without_code(line: &str) -> String {
    let pieces = line.split('`').step_by(2);
    pieces.collect::<Vec<_>>().join("")
}

/// The targets of links and pictures; those of pictures are marked.
fn links(prose: &[String]) -> Vec<(String, bool)> {
    let text = prose
        .iter()
        .map(|line| without_code(line))
        .collect::<Vec<_>>()
        .join("\n");
    let mut found = Vec::new();
    for (at, _) in text.match_indices("](") {
        let target = text[at + 2..].split(')').next().unwrap_or("");
        // A picture may stand inside a link, so its own bracket has to be found.
        let mut depth = 0;
        let open = text[..at].char_indices().rev().find(|(_, letter)| {
            match letter {
                ']' => depth += 1,
                '[' if depth > 0 => depth -= 1,
                '[' => return true,
                _ => {}
            }
            false
        });
        let picture = open.is_some_and(|(open, _)| text[..open].ends_with('!'));
        found.push((target.to_owned(), picture));
    }
    for (at, mark) in text.match_indices("<img src=\"") {
        let target = text[at + mark.len()..].split('"').next().unwrap_or("");
        found.push((target.to_owned(), true));
    }
    found
}

/// The anchors of a page: those of its headings, as GitHub and mdBook make them, and those written out.
fn anchors(page: &str) -> BTreeSet<String> {
    let (_, prose) = parts(page);
    let mut seen = HashMap::<String, usize>::new();
    let mut found = BTreeSet::new();
    for line in &prose {
        if let Some((mark, heading)) = line.split_once(' ')
            && !mark.is_empty()
            && mark.chars().all(|letter| letter == '#')
        {
            let letters = heading.trim().to_lowercase();
            let kept = letters
                .chars()
                .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
            let slug: String = kept.map(|c| if c == ' ' { '-' } else { c }).collect();
            let count = seen.entry(slug.clone()).or_default();
            found.insert(if *count == 0 {
                slug
            } else {
                format!("{slug}-{count}")
            });
            *count += 1;
        }
        for (_, rest) in line
            .match_indices("<a id=\"")
            .map(|(at, mark)| line.split_at(at + mark.len()))
        {
            found.extend(rest.split('"').next().map(str::to_owned));
        }
    }
    found
}

/// The path without its `..`.
fn plain(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(out.pop()),
            Component::CurDir => {}
            other => out.push(other),
        }
    }
    out
}

#[test]
fn links_lead_somewhere() {
    let mut wrong = Vec::new();
    let mut count = 0;
    for path in files(root(), ".md") {
        let page = read(&path);
        let place = path
            .strip_prefix(root())
            .expect("it is below")
            .display()
            .to_string();
        for (target, picture) in links(&parts(&page).1) {
            if target.starts_with("http://") || target.starts_with("https://") {
                continue;
            }
            count += 1;
            let (file, anchor) = target.split_once('#').unwrap_or((&target, ""));
            let to = if file.is_empty() {
                path.clone()
            } else {
                plain(&path.parent().expect("a file").join(file))
            };
            if !to.exists() {
                wrong.push(format!("{place}: {target} is not there"));
            } else if !anchor.is_empty() && !anchors(&read(&to)).contains(anchor) {
                wrong.push(format!("{place}: {target} names no heading"));
            } else if picture && !file.ends_with(".svg") {
                wrong.push(format!("{place}: {target} is no SVG"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(count > 30, "only {count} links found");
}

#[test]
fn pictures_say_what_they_show() {
    let pictures = files(&root().join("docs"), ".svg");
    assert!(pictures.len() > 5);
    for path in pictures {
        let (svg, place) = (read(&path), path.display());
        let (_, rest) = svg
            .split_once("<title")
            .unwrap_or_else(|| panic!("{place}: no title"));
        let title = rest
            .split_once('>')
            .and_then(|(_, rest)| rest.split_once("</title>"));
        assert!(
            title.is_some_and(|(title, _)| !title.trim().is_empty()),
            "{place}: no title"
        );
        assert!(
            svg.contains("role=\"img\""),
            "{place}: not marked as a picture"
        );
        // Numbers on both axes, and what they are.
        assert!(svg.matches("<text").count() >= 6, "{place}: no labels");
    }
}

#[test]
fn the_book_lists_every_page() {
    let docs = root().join("docs");
    let summary = read(&docs.join("SUMMARY.md"));
    let mut listed: Vec<String> = links(&parts(&summary).1)
        .into_iter()
        .map(|(to, _)| to)
        .collect();
    listed.sort();
    let pages = files(&docs, ".md").into_iter();
    let pages: Vec<String> = pages
        .map(|path| {
            path.strip_prefix(&docs)
                .expect("it is below")
                .display()
                .to_string()
        })
        .filter(|name| name != "SUMMARY.md")
        .collect();
    assert_eq!(listed, pages);
}

/// The numbers in round brackets in a text.
fn numbers_in_brackets(text: &str) -> BTreeSet<usize> {
    let opened = text.split('(').skip(1);
    opened
        .filter_map(|rest| rest.split_once(')')?.0.parse().ok())
        .collect()
}

#[test]
fn formulas_are_numbered_and_tested() {
    let page = read(&root().join("docs/theory.md"));
    let anchors = anchors(&page);
    let mut last = 0;
    for block in parts(&page)
        .0
        .iter()
        .filter(|block| block.language == "math")
    {
        let tag = block
            .text
            .split_once("\\tag{")
            .and_then(|(_, rest)| rest.split_once('}'));
        let (number, _) = tag.unwrap_or_else(|| panic!("no number: {}", block.text));
        assert_eq!(number, (last + 1).to_string());
        last += 1;
        assert!(
            anchors.contains(&format!("eq-{last}")),
            "no anchor eq-{last}"
        );
    }
    let tests = read(&root().join("tests/theory.rs"));
    let comments = tests
        .lines()
        .filter(|line| line.trim_start().starts_with("// "));
    let tested = comments.flat_map(numbers_in_brackets).collect();
    let all: BTreeSet<usize> = (1..=last).collect();
    assert_eq!(all, tested, "each has its comment in tests/theory.rs");
    // What the page and the code refer to is there.
    let mut texts = vec![parts(&page).1.join("\n")];
    {
        for path in files(&root().join("crates"), ".rs") {
            let code = read(&path)
                .replace("\n    ///", "")
                .replace("\n///", "")
                .replace("\n//!", "");
            let references = code.split("docs/theory.md, ").skip(1);
            texts.extend(references.map(|rest| rest.lines().next().unwrap_or("").to_owned()));
        }
    }
    assert!(texts.len() > 1, "the code refers to formulas");
    for text in texts {
        let named: BTreeSet<usize> = numbers_in_brackets(&text)
            .into_iter()
            .filter(|n| *n < 1000)
            .collect();
        assert!(named.is_subset(&all), "{text}");
    }
}

/// What a command line prints, run in this folder.
fn printed_by(command: &str, folder: &Path) -> String {
    // What stands between quotes is one word.
    let parts = command.split('"').enumerate();
    let words: Vec<&str> = parts
        .flat_map(|(k, part)| match k % 2 {
            0 => part.split_whitespace().collect(),
            _ => vec![part],
        })
        .collect();
    let (first, words) = words.split_first().expect("a command");
    assert_eq!(*first, "eigentone", "{command}");
    let output = Command::new(env!("CARGO_BIN_EXE_eigentone"))
        .current_dir(folder)
        .args(words)
        .output()
        .expect("the binary runs");
    [output.stdout, output.stderr]
        .map(|text| String::from_utf8(text).expect("UTF-8"))
        .concat()
}

/// Every block of `console` shows a session: lines after `$ eigentone` are what it prints. Blocks after a comment
/// `<!-- file: NAME -->` are files of the page's own, and its commands run beside them.
#[test]
fn examples_print_what_is_shown() {
    let mut sessions = 0;
    for path in files(&root().join("docs"), ".md") {
        let (blocks, _) = parts(&read(&path));
        let stem = path
            .file_stem()
            .and_then(|stem| stem.to_str())
            .expect("a name");
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
            .join("docs")
            .join(stem);
        let mut at = root();
        for block in &blocks {
            let name = block
                .before
                .strip_prefix("<!-- file: ")
                .and_then(|rest| rest.strip_suffix(" -->"));
            if let Some(name) = name {
                fs::create_dir_all(&folder).expect("it can be made");
                fs::write(folder.join(name), &block.text).expect("it can be written");
                at = &folder;
            }
        }
        let whole = read(&path);
        let mut renewed = whole.clone();
        for block in blocks.iter().filter(|block| block.language == "console") {
            let commands = block
                .text
                .lines()
                .filter_map(|line| line.strip_prefix("$ "));
            let sessions_of =
                commands.map(|command| format!("$ {command}\n{}", printed_by(command, at)));
            let text: Vec<String> = sessions_of.collect();
            sessions += text.len();
            renewed = renewed.replace(&block.text, &text.join("\n"));
        }
        page::assert_whole(&path, &whole, &renewed);
    }
    assert!(sessions > 3, "only {sessions} found");
}

/// Wherever a page names a test, `FILE.rs::FUNCTION`, it is there.
#[test]
fn tests_that_pages_name_exist() {
    let mut count = 0;
    for path in files(&root().join("docs"), ".md") {
        for line in parts(&read(&path)).1 {
            for code in line.split('`').skip(1).step_by(2) {
                let (file, function) = match code.split_once("::") {
                    Some((file, function)) if file.ends_with(".rs") => (file, Some(function)),
                    None if code.ends_with(".rs") && code.contains("tests/") => (code, None),
                    _ => continue,
                };
                let place = path.display();
                assert!(root().join(file).exists(), "{place}: {file}");
                if let Some(function) = function {
                    let text = read(&root().join(file));
                    assert!(text.contains(&format!("fn {function}(")), "{place}: {code}");
                    count += 1;
                }
            }
        }
    }
    assert!(count > 20, "only {count} found");
}
