//! Faults that are written down as text: an expression or a statement, and what replaces it.

use crate::text::{Piece, Site};

/// The switch: the number of the fault that is made.
pub const ACTIVE: &str = "eigentone_digits::active_fault()";

/// `old` is a stretch of the source that occurs once; where only a part of it is replaced, that part stands in «».
pub struct ByHand {
    id: usize,
    old: String,
    new: String,
}

impl ByHand {
    pub fn read(id: usize, entry: &serde_json::Value) -> Option<ByHand> {
        Some(ByHand {
            id,
            old: entry["old"].as_str()?.to_owned(),
            new: entry["new"].as_str()?.to_owned(),
        })
    }
}

/// The sites of `faults` in `source`, and the faults that found none, or more than one.
pub fn find(source: &str, faults: &[ByHand]) -> (Vec<Site>, Vec<usize>) {
    let (mut sites, mut unplaced) = (Vec::new(), Vec::new());
    for fault in faults {
        match site(source, fault) {
            Some(site) => sites.push(site),
            None => unplaced.push(fault.id),
        }
    }
    (sites, unplaced)
}

fn site(source: &str, fault: &ByHand) -> Option<Site> {
    let (before, rest) = fault.old.split_once('«').unwrap_or(("", &fault.old));
    let (middle, after) = rest.split_once('»').unwrap_or((rest, ""));
    let whole = format!("{before}{middle}{after}");
    let mut places = source.match_indices(&whole);
    let (Some((at, _)), None) = (places.next(), places.next()) else {
        return None;
    };
    let start = at + before.len();
    let old = start..start + middle.len();
    // A statement keeps its semicolon inside; an expression stays one.
    let (open, close) = if middle.ends_with(';') {
        ("", "")
    } else {
        ("(", ")")
    };
    let (id, new) = (fault.id, &fault.new);
    let arm = vec![
        Piece::New(format!("{open}if {ACTIVE} == {id} {{ {new} }} else {{ ")),
        Piece::Old(old.clone()),
        Piece::New(format!(" }}{close}")),
    ];
    Some(Site {
        old,
        pieces: vec![Piece::Arm(id, arm)],
        faults: vec![id],
    })
}
