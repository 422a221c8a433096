//! Which states something moves: the others stay exactly 0, however they would go on by themselves.

use super::question::Problem;

/// By state, whether it may ever differ from 0: it does at first, or a force that acts reaches it, or another such state,
/// as far as entries of z′ = A z + B f are not exactly 0.
///
/// `starts` says it of the start, `pushed` whether a force on a coordinate reaches a state, `led` whether a state (first)
/// reacts to another.
pub(crate) fn moving(
    problem: &Problem<'_>,
    mut starts: Vec<bool>,
    pushed: impl Fn(usize, usize) -> bool,
    led: impl Fn(usize, usize) -> bool,
) -> Vec<bool> {
    let n = problem.system().len();
    let on = problem.drives().iter().map(|drive| drive.coordinate);
    let directions = problem
        .channels()
        .iter()
        .flat_map(|channel| &channel.directions);
    let rows = directions.flatten().map(|(row, _)| *row);
    let mut is_loaded = vec![false; n];
    for coordinate in on.filter(|on| *on < n).chain(rows) {
        is_loaded[coordinate] = true;
    }
    for (i, starts) in starts.iter_mut().enumerate() {
        *starts |= (0..n).any(|j| is_loaded[j] && pushed(i, j));
    }
    let mut moving = starts;
    let mut next: Vec<usize> = (0..moving.len()).filter(|i| moving[*i]).collect();
    while let Some(from) = next.pop() {
        for (to, moves) in moving.iter_mut().enumerate() {
            if !*moves && led(to, from) {
                *moves = true;
                next.push(to);
            }
        }
    }
    moving
}
