//! The peaks of a frequency response function in doubles, and where it is above a level.
//!
//! Peaks are sought between and beside the poles, on H as a sum over them, and made as good as doubles are by Newton's method on
//! the derivative of ln|H|. That none is higher is shown by the level set just above the highest: |H| has that value where the
//! Hamiltonian matrix of the level has imaginary eigenvalues (Boyd & Balakrishnan 1990, *Systems & Control Letters* 15;
//! Bruinsma & Steinbuch 1990, *ibid.* 14).

use eigentone_digits::{Lu, eigen, sort_by_number};
use eigentone_modes::{Balanced, FirstOrder, System, balance, eigenvalues};
use faer::Mat;
use num_complex::Complex;

use super::brackets::{brackets, end, far, grid, narrow};
use super::modal_functions::turn;
use super::state_form::{Acts, Equations, StateForm, powers};
use super::transfer::Transfer;

/// Levels are above the highest peak by this part of it.
const MARGIN: f64 = 1e-9;

/// Values are to be as good as this part of them.
const GOOD: f64 = 1e-10;

/// Where peaks are sought.
struct Search<'a> {
    transfer: &'a Transfer,
    poles: Vec<Complex<f64>>,
    /// H as a sum over poles, but where springs have losses.
    sum: Option<PoleSum>,
}

/// H as a sum over poles, and what passes by the states.
struct PoleSum {
    /// A, balanced, and b and c in the same units and of one size.
    a: Mat<f64>,
    b: Vec<f64>,
    c: Vec<f64>,
    /// Of each power of s, from the least.
    direct: Vec<f64>,
    residues: Vec<Complex<f64>>,
}

impl Transfer {
    /// Frequency in rad/s and magnitude of each peak between two frequencies, the higher of which may be infinite, with both ends,
    /// of which one that is infinite is a frequency with the value of the limit; `None` where doubles do not determine them: where
    /// something does not decay, the gain grows without end, or too few digits are left. That no peak is higher than all of these is
    /// shown by a level set, but for springs with losses and systems of more than 100 coordinates.
    pub fn peaks(&self, system: &System, low: f64, high: f64) -> Option<Vec<(f64, f64)>> {
        const MOST: usize = 100;
        let search = Search::of(self, system)?;
        let grid = grid(&search.poles, low, high);
        let mut peaks = match &search.sum {
            Some(_) => search.peaks_on(&grid)?,
            None => search.turns_on(&grid)?,
        };
        let last = *grid.last()?;
        for at in [grid[0], last] {
            if peaks.iter().all(|(known, _)| *known != at) {
                peaks.push((at, self.value(at)?.norm()));
            }
        }
        let mut beyond = 0.0;
        if high == f64::INFINITY {
            beyond = search.sum.as_ref().map_or(Some(0.0), PoleSum::beyond)?;
            let far = far(&search.poles);
            let [value, at_twice] = [far, 2.0 * far].map(|at| Some(self.value(at)?.norm()));
            end(&mut peaks, far, [value?, at_twice?])?;
        }
        let Some(sum) = search.sum.as_ref().filter(|_| self.n <= MOST) else {
            return search.judged(peaks);
        };
        // Whatever is above all of them is another peak.
        for _ in 0..20 {
            let highest = peaks.iter().map(|(_, value)| *value).fold(beyond, f64::max);
            let level = highest * (1.0 + MARGIN);
            let within = |at: &f64| low < *at && *at < high;
            let mut points: Vec<f64> = sum.crossings(level)?.into_iter().filter(within).collect();
            points.push(low);
            points.push(high.min(2.0 * points.iter().fold(last, |a, b| a.max(*b))));
            sort_by_number(&mut points, |point| *point);
            let middles: Vec<f64> = points
                .windows(2)
                .map(|pair| 0.5 * (pair[0] + pair[1]))
                .collect();
            points.extend(middles);
            sort_by_number(&mut points, |point| *point);
            points.dedup();
            if !points.iter().any(|at| search.size(*at) > level) {
                return search.judged(peaks);
            }
            let more = search.peaks_on(&points)?;
            if !more.iter().any(|(_, value)| *value > level) {
                return None;
            }
            peaks.extend(more);
        }
        None
    }
}

impl<'a> Search<'a> {
    fn of(transfer: &'a Transfer, system: &System) -> Option<Search<'a>> {
        let first_order = FirstOrder::of(system).ok()?;
        if let Some(losses) = transfer.losses() {
            let lost = first_order.b() * losses * first_order.x();
            let a = first_order.a();
            let states = a.nrows();
            let turned = |i: usize, j: usize| Complex::new(a[(i, j)], -lost[(i, j)]);
            let sizes = Mat::from_fn(states, states, |i, j| turned(i, j).norm());
            let Balanced { matrix, scale } = balance(sizes.as_ref());
            let unit = unit(&matrix);
            let even = |i: usize, j: usize| turned(i, j) * (scale[j] / scale[i] / unit);
            let mut poles =
                eigentone_digits::eigenvalues(Mat::from_fn(states, states, even).as_ref())?;
            poles.iter_mut().for_each(|pole| *pole *= unit);
            // At frequencies below 0 losses would feed, so that what is there may grow.
            let above = poles.iter().copied().filter(|pole| pole.im >= 0.0);
            return decays(&above.collect::<Vec<_>>()).then_some(Search {
                transfer,
                poles,
                sum: None,
            });
        }
        let acts: Acts = transfer
            .acts
            .iter()
            .map(|(power, force)| (*power, force.iter().map(|force| force.re).collect()))
            .collect();
        let real = |(i, by): &(usize, Complex<f64>)| (*i, by.re);
        let reads = transfer.reads.iter();
        let reads = reads.map(|(power, parts)| (*power, parts.iter().map(real).collect()));
        let equations = Equations::of(&first_order);
        let mut form = StateForm::of(equations, &[acts], &reads.collect())?;
        for (power, by) in &transfer.direct {
            form.pass(0, *power, by.re);
        }
        let (sum, poles) = PoleSum::of(&form)?;
        decays(&poles).then_some(Search {
            transfer,
            poles,
            sum: Some(sum),
        })
    }

    /// |H|.
    fn size(&self, frequency: f64) -> f64 {
        let s = Complex::new(0.0, frequency);
        let Some(PoleSum {
            direct, residues, ..
        }) = &self.sum
        else {
            let value = self.transfer.value(frequency);
            return value.map_or(f64::INFINITY, |value| value.norm());
        };
        let poles = self.poles.iter().zip(residues);
        let mut sum: Complex<f64> = poles.map(|(pole, residue)| residue / (s - pole)).sum();
        for (power, passed) in powers().zip(direct) {
            sum += turn(frequency, power) * passed;
        }
        sum.norm()
    }

    /// The peaks between the points of a grid.
    fn peaks_on(&self, grid: &[f64]) -> Option<Vec<(f64, f64)>> {
        /// Values beside a peak that are as near to it are near enough for Newton's method.
        const FLAT: f64 = 1e-6;
        let sizes = |at: &[f64]| at.iter().map(|at| self.size(*at)).collect::<Vec<f64>>();
        let mut found = brackets(grid, &sizes(grid));
        narrow(&mut found, FLAT, |at| Ok::<_, ()>(sizes(at))).ok()?;
        found
            .into_iter()
            .map(|bracket| self.peak_in(bracket.map(|(at, _)| at)))
            .collect()
    }

    /// The peaks between points of a grid of which |H| rises at one and falls at the next: fewer are missed so than by values alone.
    fn turns_on(&self, grid: &[f64]) -> Option<Vec<(f64, f64)>> {
        /// Halvings of what is between two points.
        const STEPS: usize = 40;
        /// Smaller changes of ln|H| are rounding.
        const FLAT: f64 = 1e-12;
        // From 0 it rises.
        let slope = |at: &f64| {
            self.transfer
                .steepness(*at)
                .map_or(f64::MAX, |[_, slope, _]| slope)
        };
        let slopes: Vec<f64> = grid.iter().map(slope).collect();
        let pairs = grid.windows(2).zip(slopes.windows(2));
        let turns = pairs.filter(|(ends, slopes)| {
            let change = FLAT / (ends[1] - ends[0]);
            slopes[0] > change && slopes[1] < -change
        });
        let peak = |(ends, _): (&[f64], &[f64])| {
            let (mut low, mut high) = (ends[0], ends[1]);
            for _ in 0..STEPS {
                let middle = f64::midpoint(low, high);
                match slope(&middle) > 0.0 {
                    true => low = middle,
                    false => high = middle,
                }
            }
            self.peak_in([low, f64::midpoint(low, high), high])
        };
        turns.map(peak).collect()
    }

    fn peak_in(&self, [low, mut at, high]: [f64; 3]) -> Option<(f64, f64)> {
        let width = high - low;
        for _ in 0..8 {
            let [_, slope, bend] = self.transfer.steepness(at)?;
            let step = -slope / bend;
            if bend >= 0.0 || !(low - width..=high + width).contains(&(at + step)) {
                break;
            }
            at += step;
            if step.abs() <= 1e-15 * at {
                break;
            }
        }
        Some((at, self.transfer.value(at)?.norm()))
    }

    /// The peaks where all digits that matter are there.
    fn judged(&self, peaks: Vec<(f64, f64)>) -> Option<Vec<(f64, f64)>> {
        let highest = peaks.iter().map(|(_, value)| *value).fold(0.0, f64::max);
        let sound = peaks.iter().all(|&(at, value)| {
            let off = self
                .transfer
                .adjoint(at)
                .map(|adjoint| self.transfer.rounding(&adjoint));
            // What was sought is what there is.
            let alike = (self.size(at) - value).abs() <= 1e-6 * highest;
            alike && off.is_some_and(|off| off <= GOOD * highest)
        });
        sound.then_some(peaks)
    }
}

impl PoleSum {
    /// With the poles; `None` where the iteration does not converge, or poles coincide.
    fn of(form: &StateForm<f64>) -> Option<(PoleSum, Vec<Complex<f64>>)> {
        let n = form.c.len();
        let Balanced { matrix: a, scale } = balance(form.a.as_ref());
        let b: Vec<f64> = (0..n).map(|i| form.b[0][i] / scale[i]).collect();
        let c: Vec<f64> = (0..n).map(|j| form.c[j] * scale[j]).collect();
        let [into, out] =
            [&b, &c].map(|all| all.iter().fold(0.0, |sum: f64, entry| sum.hypot(*entry)));
        // Both of one size.
        let even = match (out / into).sqrt() {
            even if even > 0.0 && even.is_finite() => even,
            _ => 1.0,
        };
        let b: Vec<f64> = b.iter().map(|entry| entry * even).collect();
        let c: Vec<f64> = c.iter().map(|entry| entry / even).collect();
        let unit = unit(&a);
        let (poles, u) = eigen(Mat::from_fn(n, n, |i, j| a[(i, j)] / unit).as_ref())?;
        let poles: Vec<Complex<f64>> = poles.into_iter().map(|pole| pole * unit).collect();
        let mut share = Mat::from_fn(n, 1, |i, _| Complex::from(b[i]));
        Lu::of(u.as_ref()).solve_in_place(share.as_mut());
        let residue = |k: usize| {
            let row: Complex<f64> = (0..n).map(|i| u[(i, k)] * c[i]).sum();
            row * share[(k, 0)]
        };
        let residues: Vec<Complex<f64>> = (0..n).map(residue).collect();
        let known = residues.iter().all(|residue| residue.is_finite());
        let sum = PoleSum {
            a,
            b,
            c,
            direct: powers().map(|power| form.direct(0, power)).collect(),
            residues,
        };
        known.then_some((sum, poles))
    }

    /// What it comes to as frequencies grow; `None` where it grows without end.
    fn beyond(&self) -> Option<f64> {
        let mut passed = powers().zip(&self.direct);
        let ends = !passed.any(|(power, by)| power > 0 && *by != 0.0);
        ends.then(|| self.at_infinity().abs())
    }

    /// What passes by the states as it is.
    fn at_infinity(&self) -> f64 {
        self.direct[-powers().start as usize]
    }

    /// Where |H| may cross a level, which is above what it is at infinity: among the imaginary parts of the eigenvalues of
    /// [A + bRdc, bRbᵀ; −cᵀRc, −(A + bRdc)ᵀ], R = 1/(1 − d²), for H over the level. Which of them are on the axis, rounding
    /// does not leave certain.
    fn crossings(&self, level: f64) -> Option<Vec<f64>> {
        let n = self.c.len();
        let d = self.at_infinity() / level;
        let r = 1.0 / (1.0 - d * d);
        if !(r.is_finite() && r > 0.0) {
            return None;
        }
        let root = level.sqrt();
        let b: Vec<f64> = self.b.iter().map(|entry| entry / root).collect();
        let c: Vec<f64> = self.c.iter().map(|entry| entry / root).collect();
        let a = |i: usize, j: usize| self.a[(i, j)] + b[i] * r * d * c[j];
        let matrix = Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
            (true, true) => a(i, j),
            (true, false) => b[i] * r * b[j - n],
            (false, true) => -c[i - n] * r * c[j],
            (false, false) => -a(j - n, i - n),
        });
        let roots = eigenvalues(matrix.as_ref())?;
        let upper = roots.iter().filter(|root| root.im > 0.0);
        Some(upper.map(|root| root.im).collect())
    }
}

/// The largest entry, in which the iteration for eigenvalues is to find the others.
fn unit(matrix: &Mat<f64>) -> f64 {
    let unit = matrix.norm_max();
    if unit > 0.0 { unit } else { 1.0 }
}

/// Whether all of it is clearly to the left of the axis: near it, only a proof shows whether a gain is finite.
fn decays(poles: &[Complex<f64>]) -> bool {
    poles.iter().all(|pole| pole.re <= -1e-9 * pole.norm())
}
