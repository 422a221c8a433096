//! M, C or K row by row, without a dense matrix, as a Matrix Market file or one of PETSc's.

use std::io::{self, Write};

use eigentone_digits::DoubleDouble;
use eigentone_modes::{MatrixKind, System};

/// The number that a matrix of PETSc begins with.
const CLASS: i32 = 1_211_216;

/// Prints one matrix of a system, each entry the double nearest to the sum of its terms in double-double, those that
/// are 0 left out. It takes memory for the entries alone.
#[derive(Clone, Debug)]
pub struct SparseMatrixReport {
    /// Where each row starts, and where the last one ends.
    starts: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
    is_symmetric: bool,
}

impl SparseMatrixReport {
    /// M (kg), C (N·s/m) or K (N/m) of a system.
    pub fn of(system: &System, kind: MatrixKind) -> SparseMatrixReport {
        let n = system.len();
        let mut ends = vec![0usize; n];
        for term in system.terms(kind) {
            ends[term.row] += 1;
        }
        let mut end = 0;
        for place in &mut ends {
            end += std::mem::replace(place, end);
        }
        let mut terms = vec![(0u32, 0.0); end];
        for term in system.terms(kind) {
            // What fits into a system fits into 32 bits.
            terms[ends[term.row]] = (term.column as u32, term.value);
            ends[term.row] += 1;
        }
        let mut report = SparseMatrixReport {
            starts: vec![0],
            columns: Vec::new(),
            values: Vec::new(),
            is_symmetric: true,
        };
        let mut start = 0;
        for end in ends {
            let row = &mut terms[start..end];
            row.sort_by_key(|(column, _)| *column);
            for same in row.chunk_by(|a, b| a.0 == b.0) {
                let sum = same
                    .iter()
                    .fold(DoubleDouble::ZERO, |sum, term| sum + term.1);
                if sum.to_f64() != 0.0 {
                    report.columns.push(same[0].0);
                    report.values.push(sum.to_f64());
                }
            }
            report.starts.push(report.columns.len());
            start = end;
        }
        let all = (0..n).flat_map(|row| report.row(row).map(move |entry| (row, entry)));
        let mirrored = |(row, (column, value)): (usize, (u32, f64))| {
            report.entry(column as usize, row as u32) == value
        };
        let is_symmetric = { all }.all(mirrored);
        SparseMatrixReport {
            is_symmetric,
            ..report
        }
    }

    fn row(&self, row: usize) -> impl Iterator<Item = (u32, f64)> + '_ {
        let range = self.starts[row]..self.starts[row + 1];
        let columns = self.columns[range.clone()].iter().copied();
        columns.zip(self.values[range].iter().copied())
    }

    fn entry(&self, row: usize, column: u32) -> f64 {
        let start = self.starts[row];
        let columns = &self.columns[start..self.starts[row + 1]];
        match columns.binary_search(&column) {
            Ok(at) => self.values[start + at],
            Err(_) => 0.0,
        }
    }

    fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// How many entries are not 0.
    pub fn entries(&self) -> usize {
        self.values.len()
    }

    /// Whether it is its own transpose.
    pub fn is_symmetric(&self) -> bool {
        self.is_symmetric
    }

    /// In Matrix Market format, with all digits; of a symmetric matrix the lower half.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn matrix_market(&self, out: &mut dyn Write) -> io::Result<()> {
        let n = self.len();
        let given = |row: usize, column: u32| !self.is_symmetric || column as usize <= row;
        let symmetry = match self.is_symmetric {
            true => "symmetric",
            false => "general",
        };
        let counts = (0..n).map(|row| self.row(row).filter(|entry| given(row, entry.0)).count());
        writeln!(out, "%%MatrixMarket matrix coordinate real {symmetry}")?;
        writeln!(out, "{n} {n} {}", counts.sum::<usize>())?;
        for row in 0..n {
            for (column, value) in self.row(row).filter(|entry| given(row, entry.0)) {
                writeln!(out, "{} {} {value:?}", row + 1, column + 1)?;
            }
        }
        Ok(())
    }

    /// In the binary format of PETSc, as `MatView` writes a sparse matrix with 32-bit indices, with values that are real, or
    /// complex as a PETSc of complex scalars reads them.
    ///
    /// # Errors
    /// Those of `out`, and more than 2³¹ − 1 entries, which the format has no number for.
    pub fn petsc(&self, complex: bool, out: &mut dyn Write) -> io::Result<()> {
        let whole = |count: usize| {
            let many = |_| {
                io::Error::other(format!(
                    "{count} entries are more than 32-bit indices count"
                ))
            };
            i32::try_from(count).map_err(many)
        };
        let (order, entries) = (whole(self.len())?, whole(self.entries())?);
        for number in [CLASS, order, order, entries] {
            out.write_all(&number.to_be_bytes())?;
        }
        for row in self.starts.windows(2) {
            out.write_all(&whole(row[1] - row[0])?.to_be_bytes())?;
        }
        for column in &self.columns {
            out.write_all(&column.to_be_bytes())?;
        }
        for value in &self.values {
            out.write_all(&value.to_be_bytes())?;
            if complex {
                out.write_all(&0f64.to_be_bytes())?;
            }
        }
        Ok(())
    }
}
