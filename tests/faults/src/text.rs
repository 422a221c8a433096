//! New text from old text and the sites in it.

use std::ops::Range;

/// A part of what replaces a site.
pub enum Piece {
    /// New text.
    New(String),
    /// A stretch of the old text, with the sites in it replaced.
    Old(Range<usize>),
    /// A line of its own that makes one fault.
    Arm(usize, Vec<Piece>),
}

/// A stretch of the old text and what replaces it.
pub struct Site {
    pub old: Range<usize>,
    pub pieces: Vec<Piece>,
    pub faults: Vec<usize>,
}

#[derive(Default)]
pub struct Rewritten {
    pub text: String,
    /// Line and fault.
    pub arms: Vec<(usize, usize)>,
    /// First line, last line, faults.
    pub sites: Vec<(usize, usize, Vec<usize>)>,
}

pub fn rewrite(source: &str, mut sites: Vec<Site>) -> Rewritten {
    // What is only put in stands before what it is put in front of.
    sites.sort_by_key(|site| {
        (
            site.old.start,
            !site.old.is_empty(),
            usize::MAX - site.old.end,
        )
    });
    let mut writer = Writer {
        source,
        sites: &sites,
        line: 1,
        done: Rewritten::default(),
    };
    writer.old(0..source.len(), 0);
    writer.done
}

struct Writer<'a> {
    source: &'a str,
    sites: &'a [Site],
    line: usize,
    done: Rewritten,
}

impl Writer<'_> {
    fn new(&mut self, text: &str) {
        self.line += text.matches('\n').count();
        self.done.text.push_str(text);
    }

    /// The old text in `range`, with the outermost sites in it replaced, counted from `from` on.
    fn old(&mut self, range: Range<usize>, from: usize) {
        let (sites, source) = (self.sites, self.source);
        let mut at = range.start;
        for (index, site) in sites.iter().enumerate().skip(from) {
            if site.old.start >= at && site.old.end <= range.end {
                self.new(&source[at..site.old.start]);
                let first = self.line;
                self.pieces(&site.pieces, index + 1);
                self.done
                    .sites
                    .push((first, self.line, site.faults.clone()));
                at = site.old.end;
            }
            if site.old.start > range.end {
                break;
            }
        }
        self.new(&source[at..range.end]);
    }

    fn pieces(&mut self, pieces: &[Piece], from: usize) {
        for piece in pieces {
            match piece {
                Piece::New(text) => self.new(text),
                Piece::Old(range) => self.old(range.clone(), from),
                Piece::Arm(id, pieces) => {
                    self.new("\n");
                    self.done.arms.push((self.line, *id));
                    self.pieces(pieces, from);
                    self.new("\n");
                }
            }
        }
    }
}
