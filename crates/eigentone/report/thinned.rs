//! Fewer points that look the same.

use std::collections::HashSet;

/// Points in drawing coordinates, at most four in each column of one unit's width.
pub(super) struct Thinned<I: Iterator<Item = (f64, f64)>> {
    points: std::iter::Peekable<I>,
    ready: std::vec::IntoIter<(f64, f64)>,
}

impl<I: Iterator<Item = (f64, f64)>> Thinned<I> {
    pub(super) fn of(points: I) -> Thinned<I> {
        Thinned {
            points: points.peekable(),
            ready: Vec::new().into_iter(),
        }
    }
}

impl<I: Iterator<Item = (f64, f64)>> Iterator for Thinned<I> {
    type Item = (f64, f64);

    fn next(&mut self) -> Option<(f64, f64)> {
        if let Some(point) = self.ready.next() {
            return Some(point);
        }
        let first = self.points.next()?;
        let column = first.0.floor();
        // By index in the column, so that the order in time is kept.
        let (mut low, mut high, mut last) = ((0, first), (0, first), (0, first));
        while let Some(point) = self.points.next_if(|point| point.0.floor() == column) {
            last = (last.0 + 1, point);
            if point.1 < low.1.1 {
                low = last;
            }
            if point.1 > high.1.1 {
                high = last;
            }
        }
        let mut kept = vec![(0, first), low, high, last];
        kept.sort_by_key(|(index, _)| *index);
        kept.dedup_by_key(|(index, _)| *index);
        let kept: Vec<(f64, f64)> = kept.into_iter().map(|(_, point)| point).collect();
        self.ready = kept.into_iter();
        self.ready.next()
    }
}

/// Dots in drawing coordinates, one at most in each square of one unit's width.
pub(super) fn apart(dots: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut taken = HashSet::new();
    let is_first = |(x, y): &(f64, f64)| taken.insert((x.floor() as i64, y.floor() as i64));
    dots.filter(is_first).collect()
}
