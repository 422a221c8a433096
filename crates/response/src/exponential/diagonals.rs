//! Matrices with few diagonals.

use faer::MatRef;

/// An m × m matrix by its diagonals that are not zero.
pub(super) struct Diagonals {
    m: usize,
    /// The offset j − i, and the entries by their row i.
    diagonals: Vec<(isize, Vec<f64>)>,
}

impl Diagonals {
    /// `factor` times the matrix, with column j times `columns[j]`; `None` if more than `most`
    /// diagonals are not zero.
    pub(super) fn of(
        a: MatRef<'_, f64>,
        factor: f64,
        columns: &[f64],
        most: usize,
    ) -> Option<Diagonals> {
        let m = a.nrows();
        let mut found: Vec<Option<Vec<f64>>> = vec![None; 2 * m];
        let mut count = 0;
        for (j, column) in a.col_iter().enumerate() {
            for (i, entry) in column
                .iter()
                .enumerate()
                .filter(|(_, entry)| **entry != 0.0)
            {
                let diagonal = found[m + j - i].get_or_insert_with(|| {
                    count += 1;
                    vec![0.0; m]
                });
                if count > most {
                    return None;
                }
                diagonal[i] = entry * factor * columns[j];
            }
        }
        let diagonals = found
            .into_iter()
            .enumerate()
            .filter_map(|(index, diagonal)| {
                diagonal.map(|entries| (index as isize - m as isize, entries))
            });
        Some(Diagonals {
            m,
            diagonals: diagonals.collect(),
        })
    }

    /// How many diagonals lie at most to each side of the main one.
    pub(super) fn band(&self) -> usize {
        let offsets = self
            .diagonals
            .iter()
            .map(|(offset, _)| offset.unsigned_abs());
        offsets.max().unwrap_or(0)
    }

    /// Whether the matrix equals its transpose.
    pub(super) fn is_symmetric(&self) -> bool {
        self.entries().all(|(i, j, entry)| {
            let mirrored = self
                .diagonals
                .iter()
                .find(|(offset, _)| *offset == i as isize - j as isize);
            mirrored.is_some_and(|(_, entries)| entries[j] == entry)
        })
    }

    /// The largest entry of the main diagonal, at least 0.
    pub(super) fn largest_diagonal(&self) -> f64 {
        let main = self.entries().filter(|(i, j, _)| i == j);
        main.map(|(_, _, entry)| entry).fold(0.0, f64::max)
    }

    /// Row, column and value of what is stored.
    fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        self.diagonals.iter().flat_map(move |(offset, entries)| {
            self.rows(*offset)
                .map(move |i| (i, i.wrapping_add_signed(*offset), entries[i]))
        })
    }

    /// The rows that the diagonal of this offset crosses.
    fn rows(&self, offset: isize) -> std::ops::Range<usize> {
        let before = (-offset).max(0) as usize;
        let after = self.m - offset.max(0) as usize;
        before..after
    }

    /// sum += wᵀ|F|.
    pub(super) fn add_sizes(&self, w: &[f64], sum: &mut [f64]) {
        for (i, j, entry) in self.entries() {
            sum[j] += w[i] * entry.abs();
        }
    }

    /// Y += factor·F·X for X and Y with m rows.
    pub(super) fn add_left(&self, factor: f64, x: &[f64], y: &mut [f64]) {
        for (x, y) in x.chunks_exact(self.m).zip(y.chunks_exact_mut(self.m)) {
            for (offset, entries) in &self.diagonals {
                let rows = self.rows(*offset);
                let from = rows.start.wrapping_add_signed(*offset);
                let x = &x[from..from + rows.len()];
                for ((y, x), entry) in y[rows.clone()].iter_mut().zip(x).zip(&entries[rows]) {
                    *y += factor * entry * x;
                }
            }
        }
    }

    /// Y += factor·X·F for square X and Y, where X has no entries more than `band` off its main
    /// diagonal.
    pub(super) fn add_right(&self, factor: f64, x: &[f64], band: usize, y: &mut [f64]) {
        let m = self.m;
        for (i, j, entry) in self.entries() {
            let rows = i.saturating_sub(band)..m.min(i + band + 1);
            let x = &x[i * m + rows.start..i * m + rows.end];
            let y = &mut y[j * m + rows.start..j * m + rows.end];
            let factor = factor * entry;
            for (y, x) in y.iter_mut().zip(x) {
                *y += factor * x;
            }
        }
    }
}
