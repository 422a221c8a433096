//! The lower half [K C] of a second-order state matrix, by its entries that are not zero.

use pulp::Simd;

/// An entry: its row, and its value.
type Entry = (usize, f64);

/// K and C side by side, m × m each, column by column with rows ascending.
pub(super) struct LowerHalf {
    m: usize,
    /// Where each of the 2m columns begins, and the end.
    starts: Vec<usize>,
    entries: Vec<Entry>,
}

impl LowerHalf {
    /// From the columns of [−K −C]; `None` where more than `most` entries are not zero.
    pub(super) fn of<'a>(
        m: usize,
        columns: impl Iterator<Item = &'a [f64]>,
        most: usize,
    ) -> Option<LowerHalf> {
        let mut starts = Vec::with_capacity(2 * m + 1);
        let mut entries = Vec::with_capacity(most.min(8 * m));
        for column in columns {
            starts.push(entries.len());
            for (i, entry) in column.iter().enumerate() {
                if *entry != 0.0 {
                    entries.push((i, -entry));
                }
            }
            if entries.len() > most {
                return None;
            }
        }
        starts.push(entries.len());
        Some(LowerHalf { m, starts, entries })
    }

    /// How many entries are not zero.
    pub(super) fn len(&self) -> usize {
        self.entries.len()
    }

    /// Column j of K.
    pub(super) fn k(&self, j: usize) -> &[Entry] {
        &self.entries[self.starts[j]..self.starts[j + 1]]
    }

    /// Column j of C.
    pub(super) fn c(&self, j: usize) -> &[Entry] {
        self.k(self.m + j)
    }

    /// Multiplies column j of K by `k(j)`, and C by `c`.
    pub(super) fn rescale(&mut self, k: impl Fn(usize) -> f64, c: f64) {
        for j in 0..2 * self.m {
            let factor = if j < self.m { k(j) } else { c };
            for (_, entry) in &mut self.entries[self.starts[j]..self.starts[j + 1]] {
                *entry *= factor;
            }
        }
    }

    /// How far an entry is from the diagonal at most.
    pub(super) fn band(&self) -> usize {
        let far = (0..self.m).flat_map(|j| {
            let both = self.k(j).iter().chain(self.c(j));
            both.map(move |(i, _)| i.abs_diff(j))
        });
        far.max().unwrap_or(0)
    }

    /// Whether K and C equal their transposes.
    pub(super) fn is_symmetric(&self) -> bool {
        (0..2 * self.m).all(|column| {
            let (first, j) = (column / self.m * self.m, column % self.m);
            self.k(column).iter().all(|(i, entry)| {
                let mirrored = self.k(first + i);
                let place = mirrored.binary_search_by_key(&j, |(row, _)| *row);
                place.is_ok_and(|place| mirrored[place].1 == *entry)
            })
        })
    }

    /// The largest entry on the diagonal of C, at least 0.
    pub(super) fn largest_damping(&self) -> f64 {
        let diagonal = (0..self.m).flat_map(|j| self.c(j).iter().filter(move |(i, _)| *i == j));
        diagonal.map(|(_, entry)| *entry).fold(0.0, f64::max)
    }

    /// The 1-norm of K.
    pub(super) fn stiffness_norm(&self) -> f64 {
        let sums = (0..self.m).map(|j| self.k(j).iter().map(|(_, entry)| entry.abs()).sum());
        sums.fold(0.0, f64::max)
    }

    /// wᵀ|K| and wᵀ|C|.
    pub(super) fn weighted(&self, w: &[f64]) -> impl Iterator<Item = [f64; 2]> {
        let sum = |entries: &[Entry]| -> f64 { entries.iter().map(|(i, x)| w[*i] * x.abs()).sum() };
        (0..self.m).map(move |j| [sum(self.k(j)), sum(self.c(j))])
    }
}

/// Rows that are handled together.
pub(super) const LANES: usize = 4;

/// Columns of numbers, one after the other, each beginning with its first row and filled up with zeros
/// to whole groups of [`LANES`] rows.
pub(super) struct Panel {
    /// Groups of rows.
    groups: usize,
    entries: Vec<[f64; LANES]>,
}

impl Panel {
    /// m × m zeros.
    pub(super) fn zeros(m: usize) -> Panel {
        let groups = m.div_ceil(LANES);
        Panel {
            groups,
            entries: vec![[0.0; LANES]; groups * m],
        }
    }

    /// The groups of column j in this range.
    #[inline(always)]
    pub(super) fn part(&self, j: usize, groups: std::ops::Range<usize>) -> &[[f64; LANES]] {
        &self.entries[j * self.groups + groups.start..j * self.groups + groups.end]
    }

    /// The same, to change.
    #[inline(always)]
    pub(super) fn part_mut(
        &mut self,
        j: usize,
        groups: std::ops::Range<usize>,
    ) -> &mut [[f64; LANES]] {
        &mut self.entries[j * self.groups + groups.start..j * self.groups + groups.end]
    }

    /// Column j.
    pub(super) fn column(&self, j: usize) -> &[f64] {
        self.part(j, 0..self.groups).as_flattened()
    }

    /// Column j, to change.
    pub(super) fn column_mut(&mut self, j: usize) -> &mut [f64] {
        self.part_mut(j, 0..self.groups).as_flattened_mut()
    }

    /// How many rows there are room for: the distance from one column to the next.
    pub(super) fn stride(&self) -> usize {
        self.groups * LANES
    }

    /// All columns with what fills them up.
    pub(super) fn entries(&self) -> &[f64] {
        self.entries.as_flattened()
    }

    /// All columns with what fills them up, to change.
    pub(super) fn entries_mut(&mut self) -> &mut [f64] {
        self.entries.as_flattened_mut()
    }

    /// The groups that hold the rows of column j within `band` of the diagonal.
    pub(super) fn near(&self, j: usize, band: usize) -> std::ops::Range<usize> {
        let last = (j + band) / LANES;
        j.saturating_sub(band) / LANES..self.groups.min(last + 1)
    }
}

/// Adds factor · Σ entry · column of the panel, within the groups, to `out`.
#[inline(always)]
pub(super) fn accumulate<S: Simd>(
    simd: S,
    out: &mut [[f64; LANES]],
    panel: &Panel,
    groups: std::ops::Range<usize>,
    factor: f64,
    entries: &[Entry],
) {
    let (out, last) = S::as_mut_simd_f64s(out.as_flattened_mut());
    let part = |i: usize| S::as_simd_f64s(panel.part(i, groups.clone()).as_flattened());
    let (threes, rest) = entries.as_chunks::<3>();
    for [(i, a), (j, b), (k, c)] in threes {
        let factors = [factor * a, factor * b, factor * c];
        let [a, b, c] = factors.map(|factor| simd.splat_f64s(factor));
        let [(x, x_last), (y, y_last), (z, z_last)] = [part(*i), part(*j), part(*k)];
        for (out, ((x, y), z)) in out.iter_mut().zip(x.iter().zip(y).zip(z)) {
            let sum = simd.mul_add_e_f64s(a, *x, *out);
            let sum = simd.mul_add_e_f64s(b, *y, sum);
            *out = simd.mul_add_e_f64s(c, *z, sum);
        }
        for (out, ((x, y), z)) in last.iter_mut().zip(x_last.iter().zip(y_last).zip(z_last)) {
            *out += factors[0] * x + factors[1] * y + factors[2] * z;
        }
    }
    for (i, a) in rest {
        let (x, x_last) = part(*i);
        let a = factor * a;
        let factors = simd.splat_f64s(a);
        for (out, x) in out.iter_mut().zip(x) {
            *out = simd.mul_add_e_f64s(factors, *x, *out);
        }
        for (out, x) in last.iter_mut().zip(x_last) {
            *out += a * x;
        }
    }
}
