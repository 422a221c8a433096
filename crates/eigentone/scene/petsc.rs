//! Matrices in the binary format of PETSc (Balay et al., *PETSc/TAO Users Manual*, `MatLoad`): big-endian; the number
//! 1211216, rows, columns and entries, then how many entries each row has, their columns from 0, and their values.
//!
//! Read strictly: the size of the file must be the one that its head announces. Values are doubles, or complex ones
//! without imaginary parts.

use std::io::Read;

use faer::sparse::{SparseColMat, Triplet};

use super::matrix_error::{Announced, Refusal, Spot};

/// What every matrix begins with.
const CLASS: [u8; 4] = 1_211_216i32.to_be_bytes();

/// The same where PETSc was built with whole numbers of 64 bits.
const WIDE_CLASS: [u8; 8] = 1_211_216i64.to_be_bytes();

/// Whether a file that begins like this is one of PETSc's.
pub(super) fn is_start(bytes: &[u8]) -> bool {
    bytes.starts_with(&CLASS) || bytes.starts_with(&WIDE_CLASS)
}

/// Bytes with the place of the next one.
struct Bytes<R> {
    bytes: R,
    at: u64,
}

impl<R: Read> Bytes<R> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Refusal> {
        let mut word = [0; N];
        self.bytes.read_exact(&mut word).map_err(Refusal::Read)?;
        self.at += N as u64;
        Ok(word)
    }

    /// A whole number, and where it stands.
    fn whole(&mut self) -> Result<(i32, Spot), Refusal> {
        let spot = Spot::Byte(self.at);
        Ok((i32::from_be_bytes(self.take()?), spot))
    }

    /// A number that is not negative.
    fn count(&mut self, what: &str) -> Result<(usize, Spot), Refusal> {
        let (number, spot) = self.whole()?;
        match usize::try_from(number) {
            Ok(count) => Ok((count, spot)),
            Err(_) => wrong(spot, format!("{number} {what}: it must be 0 or more")),
        }
    }
}

fn wrong<T>(spot: Spot, problem: String) -> Result<T, Refusal> {
    Err(Refusal::Wrong(spot, problem))
}

/// The matrix in so many bytes.
pub(super) fn matrix(content: impl Read, bytes: u64) -> Result<SparseColMat<usize, f64>, Refusal> {
    const HEAD: u64 = 16;
    let mut content = Bytes {
        bytes: content,
        at: 0,
    };
    if bytes < HEAD {
        let problem =
            format!("the file ends after {bytes} bytes of a head of {HEAD}: is it cut off?");
        return wrong(Spot::Byte(bytes), problem);
    }
    let class: [u8; 4] = content.take()?;
    if class != CLASS {
        let problem = "whole numbers have 64 bits: write the matrix with a PETSc of 32-bit indices";
        return wrong(Spot::Byte(0), problem.to_owned());
    }
    let (rows, order) = content.count("rows")?;
    let (columns, _) = content.count("columns")?;
    Announced::order(rows, columns, order)?;
    let (entries, spot) = content.whole()?;
    let Ok(entries) = usize::try_from(entries) else {
        let problem = match entries {
            -1 => "the matrix is dense: write it as a sparse one (MATAIJ)".to_owned(),
            _ => format!("{entries} entries: it must be 0 or more"),
        };
        return wrong(spot, problem);
    };
    let places = HEAD + 4 * (rows as u64 + entries as u64);
    let [plain, complex] = [8, 16].map(|size| places + size * entries as u64);
    if bytes != plain && bytes != complex {
        return wrong(
            spot,
            format!(
                "{entries} entries in {rows} rows take {plain} bytes, or {complex} with complex values, and the file \
                 has {bytes}: is it cut off, or has it more than one matrix?"
            ),
        );
    }
    Announced::entries(entries, spot)?;
    let has_imaginary = bytes == complex && bytes != plain;
    let mut ends = Vec::with_capacity(rows);
    let mut end = 0;
    for row in 0..rows {
        let (count, spot) = content.count("entries in a row")?;
        end += count;
        if end > entries {
            let problem =
                format!("up to row {row} there are more entries than announced, {entries}");
            return wrong(spot, problem);
        }
        ends.push(end);
    }
    if end != entries {
        let problem = format!("the rows have {end} entries together, and {entries} are announced");
        return wrong(spot, problem);
    }
    let mut places: Vec<(u32, u32)> = Vec::with_capacity(entries);
    // The row that a column was last seen in, from 1.
    let mut seen = vec![0u32; columns];
    for (row, end) in (0..).zip(ends) {
        while places.len() < end {
            let (column, spot) = content.count("as a column")?;
            match seen.get_mut(column) {
                None => {
                    let problem = format!(
                        "column {column} in row {row}: there are {columns}, counted from 0"
                    );
                    return wrong(spot, problem);
                }
                Some(last) if *last == row + 1 => {
                    let problem = format!("entry ({row}, {column}) is given before: give it once");
                    return wrong(spot, problem);
                }
                Some(last) => *last = row + 1,
            }
            places.push((row, column as u32));
        }
    }
    let mut triplets: Vec<Triplet<usize, usize, f64>> = Vec::with_capacity(entries);
    let first = Spot::Byte(content.at);
    let mut has_odd = entries < 2;
    for (at, (row, column)) in places.into_iter().enumerate() {
        let spot = Spot::Byte(content.at);
        let value = f64::from_be_bytes(content.take()?);
        let imaginary = match has_imaginary {
            true => f64::from_be_bytes(content.take()?),
            false => 0.0,
        };
        if !value.is_finite() {
            let problem = format!("entry ({row}, {column}) is {value}: it must be a finite number");
            return wrong(spot, problem);
        }
        if imaginary != 0.0 {
            let problem = format!(
                "entry ({row}, {column}) has the imaginary part {imaginary:?}: M, C and K are real"
            );
            return wrong(spot, problem);
        }
        has_odd |= at % 2 == 1 && value != 0.0;
        if value != 0.0 {
            triplets.push(Triplet::new(row as usize, column as usize, value));
        }
    }
    if !has_odd && !has_imaginary && !triplets.is_empty() {
        let problem = "every second value is 0: are they complex ones, and the file is cut off?";
        return wrong(first, problem.to_owned());
    }
    SparseColMat::try_new_from_triplets(rows, columns, &triplets).map_err(|_| {
        let problem = "the matrix is too large for the memory there is".to_owned();
        Refusal::Wrong(spot, problem)
    })
}
