//! Events of a motion with switches.

use std::fmt::Write as _;
use std::io;

use eigentone_switching::Event;
use serde::Serialize;

use super::csv;
use super::number;
use super::table::visible;

/// An event in JSON: names and order stay.
#[derive(Serialize)]
pub(super) struct Listed<'a> {
    time: f64,
    bound: f64,
    element: &'a str,
    what: String,
}

/// The events with the names of their switches.
pub(super) fn listed<'a>(events: &[Event], switches: &'a [String]) -> Vec<Listed<'a>> {
    let listed = events.iter().map(|event| Listed {
        time: event.time,
        bound: event.bound,
        element: &switches[event.switch],
        what: event.kind.to_string(),
    });
    listed.collect()
}

/// A line for each event.
pub(super) fn text(events: &[Event], switches: &[String]) -> String {
    if events.is_empty() {
        return "no event\n".to_owned();
    }
    let mut text = format!("\n{:>13}  {:<8} of\n", "t, s", "event");
    for event in events {
        let (time, what) = (number::significant(event.time), event.kind.to_string());
        let switch = visible(&switches[event.switch]);
        let _ = writeln!(text, "{time:>13}  {what:<8} {switch}");
    }
    text
}

/// A table of events with all digits: instant, its bound, what happens, and to which switch.
///
/// # Errors
/// Those of `out`.
pub fn events_csv(
    events: &[Event],
    switches: &[String],
    mut out: impl io::Write,
) -> io::Result<()> {
    let header = ["time [s]", "time_bound [s]", "event", "element"];
    csv::row(&mut out, header.map(str::to_owned))?;
    for event in events {
        let numbers = [event.time, event.bound].map(csv::number);
        let words = [event.kind.to_string(), switches[event.switch].clone()];
        csv::row(&mut out, numbers.into_iter().chain(words))?;
    }
    Ok(())
}
