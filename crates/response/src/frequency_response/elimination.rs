//! Gaussian elimination of sparse rows in ball arithmetic, with complete pivoting: what comes out
//! encloses the exact solution. With partial pivoting the balls would grow much faster.

use eigentone_digits::{Ball, Magnitude, Real};

/// The entries of a row that are not always zero, by rising column.
pub(super) type Row<T> = Vec<(usize, Ball<T>)>;

/// What elimination shows of a matrix.
pub(super) enum Outcome<T> {
    /// It is regular, and eliminated.
    Regular(Factor<T>),
    /// Nothing but balls around 0 was left; |det A| is at most this.
    Singular(Magnitude),
}

/// A matrix after elimination.
pub(super) struct Factor<T> {
    /// In the order of elimination.
    equations: Vec<Equation<T>>,
}

/// One row at the time when it was the pivot's.
struct Equation<T> {
    /// Its index in the matrix.
    row: usize,
    /// The unknown that it gives from those eliminated later.
    unknown: usize,
    pivot: Ball<T>,
    others: Row<T>,
    /// The rows from which it was subtracted, and how often.
    below: Vec<(usize, Ball<T>)>,
}

impl<T: Real> Factor<T> {
    /// Eliminates n rows; the second is how many products it took.
    pub(super) fn of(rows: Vec<Row<T>>) -> (Outcome<T>, u64) {
        let n = rows.len();
        let mut active: Vec<(usize, Row<T>)> = rows.into_iter().enumerate().collect();
        let mut equations: Vec<Equation<T>> = Vec::with_capacity(n);
        let mut work = 0;
        let mut determinant = Magnitude::from(1.0);
        while let Some((at, column)) = largest(&active) {
            let (index, mut row) = active.swap_remove(at);
            let place = row
                .binary_search_by_key(&column, |entry| entry.0)
                .expect("the pivot is in its row");
            let (_, pivot) = row.remove(place);
            determinant = determinant * pivot.upper();
            let mut below = Vec::new();
            for (other_index, other) in &mut active {
                let Ok(place) = other.binary_search_by_key(&column, |entry| entry.0) else {
                    continue;
                };
                let (_, entry) = other.remove(place);
                let factor = entry
                    .checked_div(pivot)
                    .expect("the pivot's ball excludes zero");
                *other = less(other, &row, factor);
                below.push((*other_index, factor));
                work += row.len() as u64 + 2;
            }
            equations.push(Equation {
                row: index,
                unknown: column,
                pivot,
                others: row,
                below,
            });
        }
        if active.is_empty() {
            return (Outcome::Regular(Factor { equations }), work);
        }
        // Hadamard: a determinant is at most the product of its rows' lengths.
        for (_, row) in &active {
            let length = row.iter().map(|(_, entry)| entry.upper());
            determinant = determinant * length.fold(Magnitude::ZERO, |sum, size| sum + size);
        }
        (Outcome::Singular(determinant), work)
    }

    /// An enclosure of A⁻¹b.
    pub(super) fn solve(&self, mut right: Vec<Ball<T>>) -> Vec<Ball<T>> {
        for equation in &self.equations {
            let own = right[equation.row];
            if !own.is_zero() {
                for &(row, factor) in &equation.below {
                    right[row] = right[row] - factor * own;
                }
            }
        }
        let mut x = vec![Ball::ZERO; right.len()];
        for equation in self.equations.iter().rev() {
            let known = equation.others.iter().filter(|(j, _)| !x[*j].is_zero());
            let rest = known.fold(right[equation.row], |rest, (j, entry)| {
                rest - *entry * x[*j]
            });
            x[equation.unknown] = rest
                .checked_div(equation.pivot)
                .expect("the pivot's ball excludes zero");
        }
        x
    }
}

/// Row and column of the entry that is surely the largest; `None` where all may be 0.
fn largest<T: Real>(active: &[(usize, Row<T>)]) -> Option<(usize, usize)> {
    let mut best = (Magnitude::ZERO, None);
    for (at, (_, row)) in active.iter().enumerate() {
        for (column, entry) in row {
            let size = entry.lower();
            if size > best.0 {
                best = (size, Some((at, *column)));
            }
        }
    }
    best.1
}

/// row − factor·pivot.
fn less<T: Real>(row: &Row<T>, pivot: &Row<T>, factor: Ball<T>) -> Row<T> {
    let mut result = Vec::with_capacity(row.len() + pivot.len());
    let (mut kept, mut taken) = (row.iter().peekable(), pivot.iter().peekable());
    loop {
        match (kept.peek(), taken.peek()) {
            (Some((i, entry)), Some((j, other))) if i == j => {
                result.push((*i, *entry - factor * *other));
                kept.next();
                taken.next();
            }
            (Some((i, entry)), other) if other.is_none_or(|(j, _)| i < j) => {
                result.push((*i, *entry));
                kept.next();
            }
            (_, Some((j, other))) => {
                result.push((*j, -(factor * *other)));
                taken.next();
            }
            (_, None) => return result,
        }
    }
}

/// 2^power times the ball.
pub(super) fn scaled<T: Real>(ball: Ball<T>, power: i64) -> Ball<T> {
    if ball.is_zero() {
        return ball;
    }
    let radius = ball.radius() * Magnitude::power_of_two(power) + T::floor() * Magnitude::from(2.0);
    Ball::new(ball.middle().scale(power), radius)
}
