//! The exponential of any real matrix.

use eigentone_digits::{Magnitude, Real};
use eigentone_modes::Bounds;
use faer::{Mat, MatRef};

use super::error::{ExpmError, check};
use super::norm::norm;
use super::paths::Paths;
use super::precise::{Judge, LIMIT, precisely};
use super::scales::scales;
use super::squaring::MEANINGFUL;
use super::taylor::{otherwise, taylor};
use crate::enclosed::Normed;

/// An exponential, and how far it may be off.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundedExponential {
    /// e^A. An entry is infinite where it is beyond the largest double, with that sign.
    pub matrix: Mat<f64>,
    /// A bound of the error in the 1-norm, infinite entries left out: the largest sum of a column of the sizes
    /// of what entries are off, the rounding to doubles included.
    pub bound: f64,
    /// Whether the bound is proven.
    pub bounds: Bounds,
}

/// e^A for a real square matrix A, in doubles.
///
/// The error in the 1-norm is at most 2^-50·(1 + κ) of the norm of e^A, where κ is the condition [`expm_condition`](super::expm_condition); nearly always
/// it is that of rounding the result. Entries beyond the largest double are infinite, those below the smallest are 0, none is
/// NaN. [`expm_bounded`] says how, and gives the bound.
///
/// ```
/// use eigentone_response::expm;
/// use faer::mat;
///
/// let quarter_turn = std::f64::consts::FRAC_PI_2;
/// let rotation = expm(mat![[0.0, quarter_turn], [-quarter_turn, 0.0]].as_ref())?;
/// assert!((rotation[(0, 1)] - 1.0).abs() < 1e-15);
/// # Ok::<(), eigentone_response::ExpmError>(())
/// ```
///
/// # Errors
/// [`ExpmError`] for a matrix that is not square or has an entry that is not finite, and where the exponential has
/// fewer digits than promised, or needs more digits than can be afforded.
pub fn expm(a: MatRef<'_, f64>) -> Result<Mat<f64>, ExpmError> {
    /// By so much blocks that were put in their place may change the norm that an estimate started from.
    const SLACK: f64 = 1.0 + 1e-6;
    let found = expm_bounded(a)?;
    // A proven one is right to the last digit that doubles have.
    let promised = SLACK * ALLOWED * (1.0 + norm(a)) * norm(found.matrix.as_ref());
    if found.bounds == Bounds::Proven || found.bound <= promised {
        Ok(found.matrix)
    } else {
        Err(ExpmError::Uncertain { error: found.bound })
    }
}

/// e^A for a real square matrix A, with a bound of its error.
///
/// What no path of nonzero entries joins is taken by itself, and so is each class of indices between which paths lead
/// there and back, as each diagonal entry of a triangular matrix is: so decay keeps its digits beside growth, and entries
/// that are 0 in every power of A are 0. The classes are scaled and balanced by powers of two first (`scales`),
/// and the range of doubles counts only in the end.
///
/// Beyond 8 rows, what [`Taylor`](super::Taylor) computes in doubles is taken where the same by the square of e^{A/2} is within
/// 2^-51·(1 + ‖A‖) of the norm, which the condition explains, as it is at least ‖A‖. The bound
/// is an estimate then, twice that. Else, and for fewer rows, the exponential comes from 32 digits or more: so many that the
/// error is proven to be below the rounding of the result, in the 1-norm, and for most entries by themselves. Where
/// that cannot be afforded, which takes hundreds of rows or a matrix very far from normal of more than about
/// eighty, the result in doubles is given with an estimate from the difference of the two, if that leaves three
/// digits.
///
/// # Errors
/// [`ExpmError`] for a matrix that is not square or has an entry that is not finite, and where an exponential of three
/// digits would take more time than about five seconds.
pub fn expm_bounded(a: MatRef<'_, f64>) -> Result<BoundedExponential, ExpmError> {
    check(a)?;
    let n = a.nrows();
    let paths = Paths::of(a);
    let parts = paths.parts();
    if let [_] = parts[..] {
        return connected(a, &paths, LIMIT);
    }
    let mut whole = BoundedExponential {
        matrix: Mat::zeros(n, n),
        bound: 0.0,
        bounds: Bounds::Proven,
    };
    for part in &parts {
        let part_of_a = within(a, part);
        let limit = LIMIT * part.len() as f64 / n as f64;
        let found = connected(part_of_a.as_ref(), &Paths::of(part_of_a.as_ref()), limit)?;
        whole.bound = whole.bound.max(found.bound);
        whole.place(part, found);
    }
    Ok(whole)
}

impl BoundedExponential {
    /// Puts a block in its place.
    fn place(&mut self, rows: &[usize], block: BoundedExponential) {
        for (column, j) in block.matrix.col_iter().zip(rows) {
            for (entry, i) in column.iter().zip(rows) {
                self.matrix[(*i, *j)] = *entry;
            }
        }
        if block.bounds == Bounds::Estimated {
            self.bounds = Bounds::Estimated;
        }
    }
}

/// The rows and columns of these indices.
fn within(a: MatRef<'_, f64>, indices: &[usize]) -> Mat<f64> {
    Mat::from_fn(indices.len(), indices.len(), |i, j| {
        a[(indices[i], indices[j])]
    })
}

/// The exponential of a matrix whose indices are joined by paths; diagonal blocks have one of their own.
fn connected(
    a: MatRef<'_, f64>,
    paths: &Paths,
    limit: f64,
) -> Result<BoundedExponential, ExpmError> {
    let classes = paths.classes();
    let mut whole = jointly(a, paths, &classes, limit)?;
    if classes.len() > 1 {
        let (proven, mut more) = (whole.bounds == Bounds::Proven, 0f64);
        for class in &classes {
            let block = within(a, class);
            let all = [(0..class.len()).collect()];
            let limit = limit * class.len() as f64 / a.nrows() as f64;
            let block = jointly(block.as_ref(), &Paths::of(block.as_ref()), &all, limit)?;
            more = more.max(block.bound);
            whole.place(class, block);
        }
        // An estimate of the whole counts its blocks in.
        whole.bound = match proven {
            true => (whole.bound + more).next_up(),
            false => whole.bound.max(more),
        };
    }
    Ok(whole)
}

/// 2^-50: four units of rounding for what the condition makes of them, twice.
const ALLOWED: f64 = 4.0 * f64::EPSILON;

/// All entries at once, more digits for no more than `limit`.
fn jointly(
    a: MatRef<'_, f64>,
    paths: &Paths,
    classes: &[Vec<usize>],
    limit: f64,
) -> Result<BoundedExponential, ExpmError> {
    /// Up to so many rows 32 digits take no longer than it takes to decide whether doubles suffice.
    const SMALL: usize = 8;
    /// Above this part of the norm no error is taken without having tried more digits.
    const INVISIBLE: f64 = 1e-12;
    /// Estimates above this part of the norm say too little.
    const USEFUL: f64 = 1e-3;
    let n = a.nrows();
    let exponents = scales(a, classes);
    let rough = if n > SMALL {
        in_doubles(a, &exponents)
    } else {
        None
    };
    let estimated = |matrix: Mat<f64>, bound: f64| BoundedExponential {
        matrix,
        bound,
        bounds: Bounds::Estimated,
    };
    if let Some(Rough { matrix, size, off }) = &rough {
        let allowed = (ALLOWED * (1.0 + size.min(norm(a)))).min(INVISIBLE);
        let allowed = allowed * norm(matrix.as_ref());
        if *off <= 0.5 * allowed {
            return Ok(estimated(matrix.clone(), allowed));
        }
    }
    let mut entries = Vec::with_capacity(n * n);
    for i in 0..n {
        entries.extend((0..n).map(|j| (a[(i, j)], exponents[j] - exponents[i])));
    }
    let rounding = Rounding {
        paths,
        exponents,
        between: classes.len() > 1,
    };
    let mut left = limit;
    if let Some((matrix, bound)) = precisely(n, paths.count(), &entries, &rounding, &mut left) {
        return Ok(BoundedExponential {
            matrix,
            bound,
            bounds: Bounds::Proven,
        });
    }
    match rough {
        Some(Rough { matrix, off, .. }) if off <= USEFUL * norm(matrix.as_ref()) => {
            Ok(estimated(matrix, 4.0 * off))
        }
        _ => Err(ExpmError::TooManyDigits { order: n }),
    }
}

/// What doubles make of e^A.
struct Rough {
    matrix: Mat<f64>,
    /// The norm of the scaled matrix.
    size: f64,
    /// How far two ways to it differ.
    off: f64,
}

/// In two ways; `None` where both may have lost the same.
fn in_doubles(a: MatRef<'_, f64>, exponents: &[i64]) -> Option<Rough> {
    /// Scales further apart may lead out of the range of doubles and back.
    const SPREAD: i64 = 256;
    let (least, most) = (exponents.iter().min()?, exponents.iter().max()?);
    if most - least > SPREAD {
        return None;
    }
    let back = |x: &Mat<f64>| {
        Mat::from_fn(x.nrows(), x.ncols(), |i, j| {
            x[(i, j)].scale(exponents[i] - exponents[j])
        })
    };
    let n = a.nrows();
    let scaled = Mat::from_fn(n, n, |i, j| a[(i, j)].scale(exponents[j] - exponents[i]));
    if back(&scaled) != a {
        return None;
    }
    let (found, _, squarings) = taylor(scaled.as_ref());
    if squarings > MEANINGFUL {
        return None;
    }
    let range = 2f64.powi(-(SPREAD as i32))..2f64.powi(2 * SPREAD as i32);
    let (matrix, other) = (back(&found), back(&otherwise(scaled.as_ref())));
    let off = norm((&matrix - &other).as_ref());
    (range.contains(&norm(matrix.as_ref())) && off.is_finite()).then(|| Rough {
        matrix,
        size: norm(scaled.as_ref()),
        off,
    })
}

/// Rounds e^A to doubles, where W = 2^-y A 2^y.
struct Rounding<'a> {
    paths: &'a Paths,
    /// y.
    exponents: Vec<i64>,
    /// Only the entries between classes count; the others come from elsewhere.
    between: bool,
}

impl Judge for Rounding<'_> {
    type Verdict = (Mat<f64>, f64);

    fn least(&self) -> f64 {
        let (most, least) = (self.exponents.iter().max(), self.exponents.iter().min());
        let spread = most.zip(least).map_or(0, |(most, least)| most - least);
        2200.0 + spread as f64
    }

    fn judge<T: Real>(&self, power: &Normed<T>, exponent: i64) -> Option<(Self::Verdict, bool)> {
        /// Entries are at most so many powers of two apart, see [`Normed::normalised`].
        const FAR: i64 = 1 << 52;
        let n = power.len();
        let two = Magnitude::power_of_two;
        let (end, tiny) = (two(1024), two(-1075));
        let mut matrix = Mat::zeros(n, n);
        let mut settled = true;
        // Columns with the largest entries, unsettled errors, and errors with those of the last rounding.
        let (mut norm, mut open, mut bound) = (Magnitude::ZERO, Magnitude::ZERO, Magnitude::ZERO);
        for j in 0..n {
            let [mut size, mut unsettled, mut error] = [Magnitude::ZERO; 3];
            for i in (0..n).filter(|i| self.paths.lead(*i, j)) {
                let shift = exponent
                    .saturating_add(self.exponents[i] - self.exponents[j])
                    .clamp(-FAR, FAR);
                let x = power.row(i)[j];
                let off = power.error() * two(shift) + T::floor();
                let above = x.upper() * two(shift) + off;
                // Sizes are known to 2^-49.
                let below = above.minus(off + off + above * two(-47));
                size = size + below;
                let value = if below >= end {
                    f64::INFINITY.copysign(sign(x))
                } else if above < tiny {
                    0.0
                } else {
                    x.scale(shift).to_f64()
                };
                if value.is_nan() {
                    return None;
                }
                matrix[(i, j)] = value;
                if below >= end || self.between && self.paths.lead(j, i) {
                    continue;
                }
                if above < tiny {
                    error = error + above;
                    continue;
                }
                if value.is_finite() {
                    let rounding = Magnitude::from(value) * two(-53) + tiny;
                    error = error + rounding + off;
                }
                if off > two(-1076) && off > below * two(-54) {
                    settled = false;
                    unsettled = unsettled + off;
                }
            }
            let larger = |a, b| if a > b { a } else { b };
            (norm, open) = (larger(norm, size), larger(open, unsettled));
            bound = larger(bound, error);
        }
        let norm = if norm > end { end } else { norm };
        (open <= norm * two(-55)).then(|| ((matrix, bound.to_f64()), settled))
    }
}

fn sign<T: Real>(x: T) -> f64 {
    if x < T::ZERO { -1.0 } else { 1.0 }
}
