//! The peaks of a frequency response function in doubles, and where it is above a level.
//!
//! Peaks are sought between and beside the poles, on H as a sum over them, and made as good as doubles are by Newton's method on
//! the derivative of ln|H|. That none is higher is shown by the level set just above the highest: |H| has that value where the
//! Hamiltonian matrix of the level has imaginary eigenvalues (Boyd & Balakrishnan 1990, *Systems & Control Letters* 15;
//! Bruinsma & Steinbuch 1990, *ibid.* 14).

use eigentone_modes::{FirstOrder, System, eigenvalues};
use faer::Mat;
use faer::linalg::solvers::Solve;
use num_complex::Complex;

use super::brackets::{Bracket, brackets, end, far, grid, narrow};
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
    form: StateForm<f64>,
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
        let mut peaks = search.peaks_on(&grid)?;
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
            let mut ends: Vec<f64> = sum.crossings(level)?.into_iter().filter(within).collect();
            ends.push(low);
            ends.push(high.min(2.0 * ends.iter().fold(last, |a, b| a.max(*b))));
            ends.sort_by(f64::total_cmp);
            let middles = ends
                .windows(2)
                .map(|pair| (pair, 0.5 * (pair[0] + pair[1])));
            let mut above = middles.filter(|(_, middle)| search.size(*middle) > level);
            let Some((pair, _)) = above.next() else {
                return search.judged(peaks);
            };
            let parts = [0.0, 0.25, 0.5, 0.75, 1.0];
            let more = search.peaks_on(&parts.map(|part| pair[0] + part * (pair[1] - pair[0])))?;
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
            let turned = Mat::from_fn(states, states, |i, j| {
                Complex::new(a[(i, j)], -lost[(i, j)])
            });
            let mut poles = turned.eigenvalues().ok()?;
            poles.retain(|pole| pole.im >= 0.0);
            return decays(&poles).then_some(Search {
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
        let eigen = form.a.eigen().ok()?;
        let states = form.c.len();
        let poles: Vec<Complex<f64>> = eigen.S().column_vector().iter().copied().collect();
        if !decays(&poles) {
            return None;
        }
        let u = eigen.U();
        let mut share = Mat::from_fn(states, 1, |i, _| Complex::from(form.b[0][i]));
        u.partial_piv_lu().solve_in_place(&mut share);
        let residue = |k: usize| {
            let row: Complex<f64> = (0..states).map(|i| u[(i, k)] * form.c[i]).sum();
            row * share[(k, 0)]
        };
        let residues: Vec<Complex<f64>> = (0..states).map(residue).collect();
        let known = residues.iter().all(|residue| residue.is_finite());
        let sum = Some(PoleSum { form, residues });
        known.then_some(Search {
            transfer,
            poles,
            sum,
        })
    }

    /// |H|.
    fn size(&self, frequency: f64) -> f64 {
        let s = Complex::new(0.0, frequency);
        let Some(PoleSum { form, residues }) = &self.sum else {
            let value = self.transfer.value(frequency);
            return value.map_or(f64::INFINITY, |value| value.norm());
        };
        let poles = self.poles.iter().zip(residues);
        let mut sum: Complex<f64> = poles.map(|(pole, residue)| residue / (s - pole)).sum();
        let mut power = Complex::ONE;
        for k in 0..powers().end {
            sum += power * form.direct(0, k);
            power *= s;
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
            .map(|bracket| self.peak_in(bracket))
            .collect()
    }

    fn peak_in(&self, bracket: Bracket) -> Option<(f64, f64)> {
        let [low, mut at, high] = bracket.map(|(at, _)| at);
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
    /// What it comes to as frequencies grow; `None` where it grows without end.
    fn beyond(&self) -> Option<f64> {
        let grows = |power: i32| power > 0 && self.form.direct(0, power) != 0.0;
        let ends = !powers().any(grows);
        ends.then(|| self.form.direct(0, 0).abs())
    }

    /// Where |H| may cross a level, which is above what it is at infinity: imaginary parts of the eigenvalues near the axis of
    /// [A + bRdc, bRbᵀ; −cᵀRc, −(A + bRdc)ᵀ], R = 1/(1 − d²), for H over the level.
    fn crossings(&self, level: f64) -> Option<Vec<f64>> {
        /// So near in parts of their size.
        const NEAR: f64 = 1e-4;
        let n = self.form.c.len();
        let d = self.form.direct(0, 0) / level;
        let r = 1.0 / (1.0 - d * d);
        if !(r.is_finite() && r > 0.0) {
            return None;
        }
        let root = level.sqrt();
        let b: Vec<f64> = self.form.b[0].iter().map(|entry| entry / root).collect();
        let c: Vec<f64> = self.form.c.iter().map(|entry| entry / root).collect();
        let a = |i: usize, j: usize| self.form.a[(i, j)] + b[i] * r * d * c[j];
        let matrix = Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
            (true, true) => a(i, j),
            (true, false) => b[i] * r * b[j - n],
            (false, true) => -c[i - n] * r * c[j],
            (false, false) => -a(j - n, i - n),
        });
        let roots = eigenvalues(matrix.as_ref())?;
        let near = roots
            .iter()
            .filter(|root| root.im > 0.0 && root.re.abs() <= NEAR * root.im);
        Some(near.map(|root| root.im).collect())
    }
}

/// Whether all of it is clearly to the left of the axis: near it, only a proof shows whether a gain is finite.
fn decays(poles: &[Complex<f64>]) -> bool {
    poles.iter().all(|pole| pole.re <= -1e-9 * pole.norm())
}
