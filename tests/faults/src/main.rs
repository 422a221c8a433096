//! `fault-switches ROOT FAULTS LEFT-OUT`
//!
//! Rewrites the sources under ROOT in place. FAULTS is what `cargo mutants --list --json` printed for
//! them, or a list of faults by hand; fault i of it, counted from 1, is made by the built program if
//! the environment variable `FAULT` is i. LEFT-OUT names faults, one number a line, that do not compile.
//!
//! Prints a line `arm FILE LINE FAULT` for each line of the new sources that stands for one fault,
//! `site FILE FIRST LAST FAULT…` for the lines of each rewritten expression, and `unplaced FAULT` for what
//! could not be placed.

mod by_hand;
mod site;
mod text;

use std::collections::{BTreeMap, HashSet};
use std::error::Error;
use std::fs;
use std::path::Path;

use by_hand::ByHand;
use site::Fault;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [root, faults, left_out] = arguments.as_slice() else {
        return Err("usage: fault-switches ROOT FAULTS LEFT-OUT".into());
    };
    let left_out: HashSet<usize> = fs::read_to_string(left_out)?
        .lines()
        .map(str::parse)
        .collect::<Result<_, _>>()?;
    let list: serde_json::Value = serde_json::from_str(&fs::read_to_string(faults)?)?;
    let mut by_file: BTreeMap<String, (Vec<Fault>, Vec<ByHand>)> = BTreeMap::new();
    for (index, entry) in list.as_array().ok_or("not a list")?.iter().enumerate() {
        let id = index + 1;
        if !left_out.contains(&id) {
            let file = entry["file"].as_str().ok_or("no file")?;
            let (made, by_hand) = by_file.entry(file.to_owned()).or_default();
            match ByHand::read(id, entry) {
                Some(fault) => by_hand.push(fault),
                None => made.push(Fault::read(id, entry).ok_or("not a fault")?),
            }
        }
    }
    for (file, (made, by_hand)) in by_file {
        let path = Path::new(root).join(&file);
        let source = fs::read_to_string(&path)?;
        // Where both replace the same stretch, what is by hand goes around.
        let (mut sites, not_found) = by_hand::find(&source, &by_hand);
        let (made, unplaced) = site::find(&source, made)?;
        sites.extend(made);
        for id in unplaced.into_iter().chain(not_found) {
            println!("unplaced {id}");
        }
        let rewritten = text::rewrite(&source, sites);
        for (line, id) in rewritten.arms {
            println!("arm {file} {line} {id}");
        }
        for (first, last, ids) in rewritten.sites {
            let ids: Vec<String> = ids.iter().map(usize::to_string).collect();
            println!("site {file} {first} {last} {}", ids.join(" "));
        }
        fs::write(&path, rewritten.text)?;
    }
    Ok(())
}
