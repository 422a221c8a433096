//! Parts of pages that are computed: a page holds them between `<!-- NAME: begin -->` and
//! `<!-- NAME: end -->`.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// With this variable set, pages and pictures are written instead of compared.
const WRITE: &str = "EIGENTONE_WRITE_DOCS";

fn docs(name: &str) -> PathBuf {
    // Of the root, from whichever package.
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = own.ancestors().find(|above| above.join("docs").is_dir());
    root.unwrap_or(own).join("docs").join(name)
}

/// A page is as it would be written anew.
#[allow(dead_code)]
pub fn assert_whole(path: &Path, shown: &str, renewed: &str) {
    if shown == renewed {
        return;
    }
    let place = path.display();
    let mut pairs = shown.lines().zip(renewed.lines());
    let first = pairs.find(|(shown, renewed)| shown != renewed);
    assert!(
        std::env::var_os(WRITE).is_some(),
        "{place} is out of date, first at {first:?}; {WRITE}=1 writes it"
    );
    fs::write(path, renewed).expect("it can be written");
}

/// The page shows this text between its marks.
#[allow(dead_code)]
pub fn assert_shown(page: &str, name: &str, text: &str) {
    // Parts of one page are written one after the other.
    static PAGES: Mutex<()> = Mutex::new(());
    let _one = PAGES.lock();
    let path = docs(page);
    let whole = fs::read_to_string(&path).expect("the page is there");
    let (begin, end) = (
        format!("<!-- {name}: begin -->\n"),
        format!("<!-- {name}: end -->"),
    );
    let (before, rest) = whole.split_once(&begin).expect("the part begins");
    let (shown, after) = rest.split_once(&end).expect("the part ends");
    let text = format!("\n{text}\n");
    if shown == text {
        return;
    }
    assert!(
        std::env::var_os(WRITE).is_some(),
        "{page}: {name} is out of date; it is\n{text}\n{WRITE}=1 writes it"
    );
    fs::write(&path, format!("{before}{begin}{text}{end}{after}")).expect("it can be written");
}

/// The picture in docs/ is this one.
#[allow(dead_code)]
pub fn assert_drawn(picture: &str, svg: &str) {
    let path = docs(picture);
    if fs::read_to_string(&path).is_ok_and(|drawn| drawn == svg) {
        return;
    }
    assert!(
        std::env::var_os(WRITE).is_some(),
        "docs/{picture} is out of date; {WRITE}=1 draws it"
    );
    fs::create_dir_all(path.parent().expect("a file")).expect("it can be made");
    fs::write(&path, svg).expect("it can be written");
}
