//! Peaks between and beside poles: points about each pole, brackets about what is largest, and parabolas that narrow them.

use eigentone_digits::sort_by_number;
use num_complex::Complex;

use super::function::FrequencyFunctions;
use super::question::{FrequencyError, FrequencyResponse};

/// So far beyond all poles a function is its limit but for the reciprocal, or its square, and estimates of errors that grow with the
/// frequency leave it digits enough.
const FAR: f64 = 67_108_864.0;

/// Three points of which the middle one is the largest.
pub(super) type Bracket = [(f64, f64); 3];

/// Frequencies between which no peak hides but by chance: evenly spread ones, some about each pole, a few far beyond them, both
/// ends, and some beside these.
pub(super) fn grid(poles: &[Complex<f64>], low: f64, high: f64) -> Vec<f64> {
    const EVEN: usize = 60;
    /// Farther from all poles, in powers of ten, magnitudes differ from their limits by less than 1e-12.
    const BEYOND: i32 = 6;
    const OFFSETS: [f64; 7] = [-3.0, -1.0, -0.4, 0.0, 0.4, 1.0, 3.0];
    /// So many points come nearer to each end, each ten times: a peak that is still nearer is as high as the end but for 1e-9.
    const CLOSER: i32 = 5;
    /// Between points that are nearer to each other nothing but rounding differs.
    const NEAR: f64 = 1e-12;
    let sizes = || {
        let sizes = poles.iter().map(|pole| pole.norm());
        sizes.filter(|size| *size > 0.0)
    };
    let first = sizes().fold(f64::INFINITY, f64::min) / 10.0;
    let last = sizes().fold(0.0, f64::max) * 10.0;
    let span = (last / first).ln();
    let even = (0..EVEN).map(|k| first * (span * k as f64 / (EVEN - 1) as f64).exp());
    let beyond = (1..=BEYOND).map(|k| last * 10f64.powi(k));
    let mut grid: Vec<f64> = even.chain(beyond).collect();
    for pole in poles {
        grid.extend(OFFSETS.map(|offset| pole.im.abs() + offset * pole.re.abs()));
    }
    grid.extend([low, high]);
    grid.retain(|at| at.is_finite() && (low..=high).contains(at));
    sort_by_number(&mut grid, |omega| *omega);
    // A peak beside an end is between points that are lower.
    let ends = [
        (low, grid.iter().find(|at| **at > low)),
        (high, grid.iter().rfind(|at| **at < high)),
    ];
    let beside = ends.into_iter().flat_map(|(end, next)| {
        let gap = next.filter(|_| end.is_finite()).map(|next| next - end);
        let gap = gap.into_iter();
        gap.flat_map(move |gap| (1..=CLOSER).map(move |k| end + gap * 10f64.powi(-k)))
    });
    let beside: Vec<f64> = beside.collect();
    grid.extend(beside);
    sort_by_number(&mut grid, |omega| *omega);
    grid.dedup_by(|at, before| {
        let near = *at - *before <= NEAR * *at;
        near && (*at != high || at == before)
    });
    grid
}

/// A frequency so high that a function of these poles is its limit there, if it does not grow.
pub(super) fn far(poles: &[Complex<f64>]) -> f64 {
    let largest = poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
    FAR * if largest > 0.0 { largest } else { 1.0 }
}

/// Adds the limit of a magnitude, in place of what differs from it by rounding alone, by its values at a frequency that is [`far`] and
/// at twice that; `None` where it grows.
pub(super) fn end(
    peaks: &mut Vec<(f64, f64)>,
    far: f64,
    [value, at_twice]: [f64; 2],
) -> Option<()> {
    const ALIKE: f64 = 1e-12;
    /// Parts of the highest peak that may be rounding.
    const SMALL: f64 = 1e-6;
    let highest = peaks.iter().map(|(_, value)| *value).fold(0.0, f64::max);
    // By a whole power, where it does.
    if at_twice > 1.5 * value && at_twice > SMALL * highest {
        return None;
    }
    // With losses of springs it differs from the limit by the reciprocal of the frequency itself.
    let limit = 2.0 * at_twice - value;
    let limit = limit.clamp(0.5 * value, 1.5 * value);
    // From about ten times the fastest pole on.
    let beyond = far / FAR * 11.0;
    peaks.retain(|(at, value)| *at < beyond || *value > limit * (1.0 + ALIKE));
    peaks.push((far, limit));
    Some(())
}

/// Brackets about the points of a grid that are larger than those beside them.
pub(super) fn brackets(grid: &[f64], values: &[f64]) -> Vec<Bracket> {
    let is_peak = |k: &usize| values[*k] > values[k - 1] && values[*k] >= values[k + 1];
    let inner = (1..grid.len().saturating_sub(1)).filter(is_peak);
    inner
        .map(|k| [k - 1, k, k + 1].map(|k| (grid[k], values[k])))
        .collect()
}

/// Narrows each bracket until its ends are as large as its middle but for a part of it, or as far as rounding lets it.
pub(super) fn narrow<E>(
    brackets: &mut [Bracket],
    part: f64,
    mut look: impl FnMut(&[f64]) -> Result<Vec<f64>, E>,
) -> Result<(), E> {
    /// Each narrows a bracket about ten times near a peak, and until then it comes nearer.
    const ROUNDS: usize = 20;
    let is_open = |[a, b, c]: &Bracket| a.1.min(c.1) < b.1 * (1.0 - part);
    for _ in 0..ROUNDS {
        let open = || brackets.iter().filter(|bracket| is_open(bracket));
        let tried: Vec<f64> = open().flat_map(vertex).collect();
        if tried.is_empty() {
            break;
        }
        let values = look(&tried)?;
        let mut tried = tried.into_iter().zip(values);
        for bracket in brackets.iter_mut().filter(|bracket| is_open(bracket)) {
            let mut all = bracket.to_vec();
            all.extend(tried.by_ref().take(3));
            sort_by_number(&mut all, |one| one.0);
            let best = (1..all.len() - 1).max_by(|a, b| all[*a].1.total_cmp(&all[*b].1));
            if let Some(best) = best {
                *bracket = [all[best - 1], all[best], all[best + 1]];
            }
        }
    }
    Ok(())
}

/// Where the parabola through 1/|H|², which is nearly one about a resonance, is least, and points beside it.
fn vertex(bracket: &Bracket) -> [f64; 3] {
    let [a, b, c] = bracket.map(|(at, value)| (at, (bracket[1].1 / value).powi(2)));
    let (left, right) = (b.0 - a.0, c.0 - b.0);
    let (down, up) = ((b.1 - a.1) / left, (c.1 - b.1) / right);
    let bend = (up - down) / (left + right);
    // Slope at b, and how far from there to the vertex.
    let slope = (down * right + up * left) / (left + right);
    let vertex = b.0 - slope / (2.0 * bend);
    let near = 0.05 * left.min(right).max((left + right) / 20.0);
    let vertex = match a.0 < vertex && vertex < c.0 {
        true => vertex,
        false => b.0,
    };
    [vertex - near, vertex, vertex + near].map(|at| at.clamp(a.0, c.0))
}

/// Whether the first value has more digits than its bound takes, as sums do that cancel to what is not 0 by rounding alone.
fn is_known(functions: &FrequencyFunctions) -> bool {
    /// Bounds by modes are wide: most values are much better.
    const KNOWN: f64 = 1e-2;
    let mut values = functions.functions().iter().flat_map(|f| f.values());
    let first = values.next().and_then(|value| value.known());
    first.is_some_and(|(value, bound)| bound.is_none_or(|bound| bound <= KNOWN * value.norm()))
}

impl FrequencyResponse<'_> {
    /// Frequency in rad/s and magnitude of each peak of the first function between two frequencies, the higher of which may be
    /// infinite, with both ends, of which one that is infinite is a frequency with the value of the limit, by its
    /// [values](Self::at) about the roots given, those of the system; `None` where a value is not known, the highest not to two digits,
    /// or the magnitude grows without end. Where two peaks are close, one may be missed:
    /// [`Transfer::peaks`](super::Transfer::peaks) shows that none is higher, [`features`](Self::features) prove all.
    ///
    /// # Errors
    /// As [`at`](Self::at).
    pub fn peaks_about(
        &self,
        roots: &[Complex<f64>],
        low: f64,
        high: f64,
    ) -> Result<Option<Vec<(f64, f64)>>, FrequencyError> {
        /// Values beside a peak that are as near to it give it to all digits but those of their rounding.
        const FLAT: f64 = 1e-13;
        let look = |frequencies: &[f64]| -> Result<Vec<f64>, Option<FrequencyError>> {
            let functions = self.at(frequencies).map_err(Some)?;
            let values = functions.functions().first().map(|f| f.values());
            let values = values.unwrap_or_default().iter();
            let sizes = values.map(|value| value.known().map(|(value, _)| value.norm()));
            sizes.collect::<Option<_>>().ok_or(None)
        };
        let sought = || {
            let grid = grid(roots, low, high);
            let values = look(&grid)?;
            let mut found = brackets(&grid, &values);
            narrow(&mut found, FLAT, look)?;
            let points = || grid.iter().copied().zip(values.iter().copied());
            let ends = points().next().into_iter().chain(points().next_back());
            let peaks = found.iter().map(|bracket| bracket[1]).chain(ends);
            let mut peaks: Vec<(f64, f64)> = peaks.filter(|(_, value)| value.is_finite()).collect();
            if high == f64::INFINITY {
                let far = far(roots);
                let ends = look(&[far, 2.0 * far]).map_err(|_| None)?;
                let ends = ends.try_into().map_err(|_| None)?;
                end(&mut peaks, far, ends).ok_or(None)?;
            }
            let highest = peaks.iter().max_by(|a, b| a.1.total_cmp(&b.1));
            match highest
                .map(|peak| self.at(&[peak.0]))
                .transpose()
                .map_err(Some)?
            {
                Some(functions) if !is_known(&functions) => Err(None),
                _ => Ok(peaks),
            }
        };
        match sought() {
            Ok(peaks) => Ok(Some(peaks)),
            Err(None) => Ok(None),
            Err(Some(error)) => Err(error),
        }
    }
}
