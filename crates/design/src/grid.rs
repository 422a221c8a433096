//! All designs of several ranges, in one order, and its parts.

use std::ops;

use thiserror::Error;

use crate::range::Range;

/// The product of ranges: designs by an index, of which the last range varies first.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    ranges: Vec<Range>,
    count: u64,
}

/// What is wrong with a grid.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum GridError {
    /// There are no ranges.
    #[error("nothing varies: give at least one range")]
    Empty,
    /// It has more designs than can be numbered exactly.
    #[error("there are more than 2^53 designs: give fewer values, or fewer ranges")]
    TooMany,
    /// There is no such part.
    #[error("there is no part {part} of {parts}: parts are 1 to {parts}")]
    NoSuchPart {
        /// The part asked for.
        part: u64,
        /// How many there are.
        parts: u64,
    },
}

impl Grid {
    /// The product of these ranges.
    ///
    /// # Errors
    /// [`GridError::Empty`], [`GridError::TooMany`].
    pub fn new(ranges: Vec<Range>) -> Result<Grid, GridError> {
        const MOST: u64 = 1 << 53;
        if ranges.is_empty() {
            return Err(GridError::Empty);
        }
        let lengths = ranges.iter().map(|range| range.values().len() as u64);
        let product = lengths.into_iter().try_fold(1, u64::checked_mul);
        let product = product.filter(|count| *count <= MOST);
        let count = product.ok_or(GridError::TooMany)?;
        Ok(Grid { ranges, count })
    }

    /// How many designs there are.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The values of a design, one of each range; `None` beyond the last.
    pub fn design(&self, index: u64) -> Option<Vec<f64>> {
        if index >= self.count {
            return None;
        }
        let mut left = index;
        let mut values: Vec<f64> = Vec::with_capacity(self.ranges.len());
        for range in self.ranges.iter().rev() {
            let length = range.values().len() as u64;
            values.push(range.values()[(left % length) as usize]);
            left /= length;
        }
        values.reverse();
        Some(values)
    }

    /// The design that one is followed from: the one before it in the last range of which it has not the first value, or, for
    /// every 4096th value of that range, the 4096th before it. So its roots are found at the same places whichever part it is
    /// in, and no part has to begin far before its first design. `None` for the first, and beyond the last.
    pub fn before(&self, index: u64) -> Option<u64> {
        if index == 0 || index >= self.count {
            return None;
        }
        const STRIDE: u64 = 4096;
        let mut step = 1;
        for range in self.ranges.iter().rev() {
            let length = range.values().len() as u64;
            let place = (index / step) % length;
            if place > 0 {
                let is_stride = place.is_multiple_of(STRIDE);
                step *= if is_stride { STRIDE } else { 1 };
                break;
            }
            step *= length;
        }
        Some(index - step)
    }

    /// The designs about this one that follow each other in one piece: at most 32 that differ in the last range, and of which only
    /// the first may be followed from one that is not its neighbour. Empty beyond the last.
    pub fn run(&self, index: u64) -> ops::Range<u64> {
        const LONGEST: u64 = 32;
        if index >= self.count {
            return index..index;
        }
        let length = self
            .ranges
            .last()
            .map_or(1, |range| range.values().len() as u64);
        let (row, place) = (index - index % length, index % length);
        let start = place - place % LONGEST;
        row + start..row + (start + LONGEST).min(length)
    }

    /// The indices of one of so many parts, from 1, that follow each other and differ by one design at most.
    ///
    /// # Errors
    /// [`GridError::NoSuchPart`].
    pub fn part(&self, part: u64, parts: u64) -> Result<ops::Range<u64>, GridError> {
        if part == 0 || part > parts {
            return Err(GridError::NoSuchPart { part, parts });
        }
        let end = |part: u64| {
            let share = u128::from(self.count) * u128::from(part) / u128::from(parts);
            share as u64 // it is `count` at most
        };
        Ok(end(part - 1)..end(part))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(texts: &[&str]) -> Grid {
        let ranges = texts.iter().map(|text| text.parse().unwrap());
        Grid::new(ranges.collect()).unwrap()
    }

    #[test]
    fn parts_are_a_partition() {
        let grid = grid(&["1:2:7", "1,2,3", "0,1"]);
        assert_eq!(grid.count(), 42);
        for parts in [1, 2, 5, 41, 42, 43, u64::MAX] {
            let all = (1..=parts.min(50)).map(|part| grid.part(part, parts).unwrap());
            let mut next = 0;
            for part in all {
                assert_eq!(part.start, next);
                next = part.end;
            }
            assert!(parts > 50 || next == 42);
        }
        assert!(grid.part(0, 2).is_err() && grid.part(3, 2).is_err());
        assert_eq!(
            grid.part(1, 0).unwrap_err(),
            GridError::NoSuchPart { part: 1, parts: 0 }
        );
    }

    #[test]
    fn each_design_follows_one_that_differs_in_one_value() {
        let grid = grid(&["1:2:7", "1,2,3", "0,1"]);
        assert_eq!(grid.design(0).unwrap(), [1.0, 1.0, 0.0]);
        assert_eq!(grid.design(41).unwrap(), [2.0, 3.0, 1.0]);
        assert_eq!(grid.design(42), None);
        assert_eq!(grid.before(0), None);
        for index in 1..42 {
            let before = grid.before(index).unwrap();
            let (own, other) = (grid.design(index).unwrap(), grid.design(before).unwrap());
            let differing = own.iter().zip(&other).filter(|(a, b)| a != b);
            assert!(before < index && differing.count() == 1);
        }
    }

    #[test]
    fn long_ranges_are_followed_in_strides() {
        let grid = grid(&["1:2:3", "1:2:10000"]);
        assert_eq!(grid.before(10_001), Some(10_000));
        assert_eq!(grid.before(10_000), Some(0));
        assert_eq!(grid.before(18_192), Some(14_096));
        assert_eq!(grid.before(14_096), Some(10_000));
        // However far it is, a design is reached by few.
        let path = std::iter::successors(Some(29_999), |index| grid.before(*index));
        assert!(path.count() < 2 * 4096 + 4);
    }

    #[test]
    fn runs_are_a_partition() {
        let grid = grid(&["1,2,3", "1:2:5000"]);
        let mut next = 0;
        while next < grid.count() {
            let run = grid.run(next);
            assert!(run.start == next && run.end > next && run.end - next <= 32);
            assert!(run.clone().all(|index| grid.run(index) == run));
            assert!(
                run.clone()
                    .skip(1)
                    .all(|index| grid.before(index) == Some(index - 1))
            );
            next = run.end;
        }
        assert_eq!(next, grid.count());
        assert!(grid.run(next).is_empty());
    }

    #[test]
    fn too_many_designs_are_refused() {
        let ranges = vec!["1:2:10000000".parse::<Range>().unwrap(); 3];
        assert_eq!(Grid::new(ranges), Err(GridError::TooMany));
        assert_eq!(Grid::new(Vec::new()), Err(GridError::Empty));
    }
}
