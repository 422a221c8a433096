//! Gaussian elimination of sparse rows in ball arithmetic, with complete pivoting: what comes out
//! encloses the exact solution. With partial pivoting the balls would grow much faster.

use eigentone_digits::{Ball, Magnitude, Real};

/// The entries of a row that are not always zero, by rising column.
pub(super) type Row<T> = Vec<(usize, Ball<T>)>;

/// What elimination shows of A x = b.
pub(super) enum Outcome<T> {
    /// Enclosures of x.
    Solved(Vec<Ball<T>>),
    /// Nothing but balls around 0 was left; |det A| is at most this.
    Singular(Magnitude),
}

/// An equation that gives one unknown from those eliminated later.
struct Equation<T> {
    unknown: usize,
    pivot: Ball<T>,
    others: Row<T>,
    right: Ball<T>,
}

/// An enclosure of A⁻¹b for n rows of A, and how many products it took.
pub(super) fn solve<T: Real>(rows: Vec<Row<T>>, right: Vec<Ball<T>>) -> (Outcome<T>, u64) {
    let n = rows.len();
    let mut active: Vec<(Row<T>, Ball<T>)> = rows.into_iter().zip(right).collect();
    let mut done: Vec<Equation<T>> = Vec::with_capacity(n);
    let mut work = 0;
    let mut determinant = Magnitude::from(1.0);
    while let Some((at, column)) = largest(&active) {
        let (mut row, right) = active.swap_remove(at);
        let place = row
            .binary_search_by_key(&column, |entry| entry.0)
            .expect("the pivot is in its row");
        let (_, pivot) = row.remove(place);
        determinant = determinant * pivot.upper();
        for (other, other_right) in &mut active {
            let Ok(place) = other.binary_search_by_key(&column, |entry| entry.0) else {
                continue;
            };
            let (_, below) = other.remove(place);
            let factor = below
                .checked_div(pivot)
                .expect("the pivot's ball excludes zero");
            *other = less(other, &row, factor);
            if !is_zero(right) {
                *other_right = *other_right - factor * right;
            }
            work += row.len() as u64 + 2;
        }
        done.push(Equation {
            unknown: column,
            pivot,
            others: row,
            right,
        });
    }
    if !active.is_empty() {
        // Hadamard: a determinant is at most the product of its rows' lengths.
        for (row, _) in &active {
            let length = row.iter().map(|(_, entry)| entry.upper());
            determinant = determinant * length.fold(Magnitude::ZERO, |sum, size| sum + size);
        }
        return (Outcome::Singular(determinant), work);
    }
    let mut x = vec![Ball::ZERO; n];
    for equation in done.into_iter().rev() {
        let known = equation.others.iter().filter(|(j, _)| !is_zero(x[*j]));
        let rest = known.fold(equation.right, |rest, (j, entry)| rest - *entry * x[*j]);
        x[equation.unknown] = rest
            .checked_div(equation.pivot)
            .expect("the pivot's ball excludes zero");
    }
    (Outcome::Solved(x), work)
}

/// Row and column of the entry that is surely the largest; `None` where all may be 0.
fn largest<T: Real>(active: &[(Row<T>, Ball<T>)]) -> Option<(usize, usize)> {
    let mut best = (Magnitude::ZERO, None);
    for (at, (row, _)) in active.iter().enumerate() {
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
    if is_zero(ball) {
        return ball;
    }
    let radius = ball.radius() * Magnitude::power_of_two(power) + T::floor() * Magnitude::from(2.0);
    Ball::new(ball.middle().scale(power), radius)
}

/// Whether it is exactly 0.
fn is_zero<T: Real>(ball: Ball<T>) -> bool {
    ball.upper().is_zero()
}
