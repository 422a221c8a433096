//! Which instants a problem asks for.

use eigentone_response::{Problem, ResponseError};

/// The memory that one trajectory may take, in GB.
const LIMIT: f64 = 2.0;

/// The indices asked for, in the order given.
pub(crate) fn wanted(problem: &Problem<'_>) -> Result<Vec<u64>, ResponseError> {
    let count = match problem.instants() {
        Some(indices) => indices.len() as u64,
        None => problem.grid().last() + 1,
    };
    let coordinates = problem.system().len();
    let gigabytes = count as f64 * coordinates as f64 * 24e-9;
    if gigabytes > LIMIT {
        return Err(ResponseError::TooLarge {
            instants: count,
            coordinates,
            gigabytes,
            limit: LIMIT,
        });
    }
    Ok(match problem.instants() {
        Some(indices) => indices.to_vec(),
        None => (0..count).collect(),
    })
}
