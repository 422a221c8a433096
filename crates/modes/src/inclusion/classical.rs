//! All roots of a classically damped system, from proven squares of its undamped frequencies.
//!
//! Where C M⁻¹ K = K M⁻¹ C, proved exactly, there are shapes x*_k with x*ᵀMx* = I, x*ᵀKx* = diag σ
//! and x*ᵀCx* = diag γ, and the roots are those of λ² + γ_kλ + σ_k. The σ are known
//! ([`squares`]); which γ go with those of a group I that stands apart from all others is seen from
//! approximate shapes X_I. Let x_j = Σ_k a_kj x*_k have modal mass 1, and d_j = x_jᵀKx_j. As
//! x*_kᵀ(K − d_jM)x_j = (σ_k − d_j) a_kj,
//!
//! Σ_k (σ_k − d_j)² a_kj² = ‖(K − d_jM)x_j‖² in the norm of M⁻¹ ≤ Σ_i h_ij² / (1 − ‖E_G‖),
//!
//! h_ij = x_iᵀ(K − d_jM)x_j, over all shapes X with XᵀMX = I + E_G. So B, the part of X_I that
//! lies outside the group's own shapes, has ‖B‖² ≤ Σ_j Σ_i h_ij² / ((1 − ‖E_G‖) gap_j²): the square
//! of what shapes err. With A the part inside, X_IᵀCX_I − BᵀΓB = AᵀΓ_I A and
//! X_IᵀMX_I − BᵀB = AᵀA: the γ of the group are the eigenvalues of a pencil that is known but for
//! ‖B‖²‖Γ‖ and ‖B‖², and nearly diagonal once X_I are the shapes in which C does not couple the
//! group. Weyl's and Ostrowski's theorems (Horn & Johnson, *Matrix Analysis*, 4.3.1 and 4.5.9) then
//! bound them all, in order.
//!
//! For the rigid-body motions, which are exact, B = 0.

use std::cmp::Ordering;
use std::ops::Range;

use eigentone_digits::{Ball, DoubleDouble};
use faer::Mat;

use super::bounded_shape::Shape;
use super::congruence::{Basis, Goal, Squares, squares};
use super::gram::{Form, Gram, SLICES, UPWARD};
use super::inert::Inert;
use super::quadratic::{Damped, Modal, around, roots};
use crate::model::MatrixKind;
use crate::system::System;

/// Squares nearer to each other than this, relatively, leave too little of a shape's own digits to
/// show what is whose: their γ are bounded together.
const NEAR: f64 = 1e-18;

/// Proves a bound for every nonzero root of a classically damped system, given its elastic shapes
/// approximately. `None` where no proof was reached.
pub(crate) fn certify(
    system: &System,
    shapes: Vec<Vec<f64>>,
    tolerance: f64,
) -> Option<Vec<Damped>> {
    let structure = system.structure();
    // What massless nodes leave of K is not counted here.
    let applies = structure.is_classical() && structure.massless().is_empty();
    if !applies || structure.is_undamped() {
        return None;
    }
    let squares = squares(system, shapes, Goal::always(1e-27), tolerance)?;
    if squares.null > 0 {
        return None;
    }
    let groups = groups(&squares);
    let rigid = squares.values.len()..squares.columns.len();
    let mut columns = squares.columns.clone();
    for group in groups
        .iter()
        .chain([&rigid])
        .filter(|group| group.len() > 1)
    {
        uncouple(system, &mut columns[group.clone()])?;
    }
    for part in structure.spring_floating() {
        // Rounding must not stretch what moves as a whole.
        for column in &mut columns[rigid.clone()] {
            let whole = column[part[0]];
            part.iter().for_each(|i| column[*i] = whole);
        }
    }
    let grams = Grams {
        mass: Form::mass(system).gram(&columns),
        damping: Form::damping(system).gram(&columns),
        stiffness: Form::stiffness(system).gram(&columns[..rigid.start]),
        squares: &squares,
    };
    let distance = grams.mass.distance_from_diagonal();
    if distance.is_nan() || distance > 1e-3 {
        return None;
    }
    let largest = grams.largest() / (1.0 - distance) * UPWARD;
    let mut modes = Vec::with_capacity(columns.len());
    for group in groups {
        let sigma = squares.around(&group);
        let gammas = grams.gammas(&group, grams.outside(&group, distance)?, largest)?;
        modes.extend(gammas.into_iter().map(|(i, gamma)| Modal {
            gamma,
            sigma: Some(sigma),
            shape: if group.len() == 1 {
                squares.shape(i)
            } else {
                Shape::plain(&columns[i])
            },
            is_common: false,
        }));
    }
    // What moves no damper is counted exactly.
    let hidden = |mode: &Modal| mode.gamma.contains_zero();
    let count = modes.iter().filter(|mode| hidden(mode)).count();
    if count > 0 && structure.undamped_modes() == Some(count) {
        modes
            .iter_mut()
            .filter(|mode| hidden(mode))
            .for_each(|mode| mode.gamma = Ball::ZERO);
    }
    let drifting = structure.zero_roots()?.checked_sub(rigid.len())?;
    let mut relaxing = grams.gammas(&rigid, 0.0, largest)?;
    relaxing.retain(|(_, gamma)| !gamma.contains_zero());
    if relaxing.len() + drifting != rigid.len() {
        return None;
    }
    modes.extend(relaxing.into_iter().map(|(i, gamma)| Modal {
        gamma,
        sigma: None,
        shape: match structure.spring_floating() {
            [part] => Shape::whole(system.len(), part, true),
            _ => Shape::plain(&columns[i]),
        },
        is_common: false,
    }));
    roots(&modes)
}

/// Rising squares that stand apart from all others.
fn groups(squares: &Squares) -> Vec<Range<usize>> {
    let (values, reach) = (&squares.values, &squares.reach);
    squares.apart_where(|i| {
        let size = values[i].to_f64().abs().max(values[i - 1].to_f64().abs());
        let gap = (values[i] - values[i - 1]).to_f64();
        gap > NEAR * size && gap > 4.0 * reach[i].max(reach[i - 1])
    })
}

/// Mixes shapes among each other so that C couples none of them.
fn uncouple(system: &System, columns: &mut [Vec<DoubleDouble>]) -> Option<()> {
    let mass = Form::mass(system).gram(columns);
    let damping = Form::damping(system).gram(columns);
    let rate = |i: usize| (damping.at(i, i) / mass.at(i, i)).to_f64().abs();
    let largest = (0..columns.len()).map(rate).fold(0.0, f64::max);
    if largest == 0.0 || !largest.is_finite() {
        return Some(());
    }
    // In C + shift·M every rate is about as large as any.
    let shift = (4.0 * columns.len() as f64 * largest).log2().ceil().exp2();
    let added = |kind| system.added(kind);
    let n = system.len();
    let matrix = match (added(MatrixKind::Damping), added(MatrixKind::Mass)) {
        (None, None) => None,
        (damping, mass) => Some(Mat::from_fn(n, n, |i, j| {
            let entry = |matrix: Option<faer::MatRef<'_, f64>>| matrix.map_or(0.0, |m| m[(i, j)]);
            entry(damping) + shift * entry(mass)
        })),
    };
    let mut basis = Basis {
        stiffness: Form::shifted_damping(system, shift, matrix.as_ref().map(Mat::as_ref)),
        mass: Form::mass(system),
        elastic: columns.len(),
        null: 0,
        inert: Inert::none(),
        slices: SLICES,
        columns: columns.to_vec(),
    };
    basis.refine(Goal::always(1e-27))?;
    columns.clone_from_slice(&basis.columns);
    Some(())
}

/// XᵀMX, XᵀCX and, for the elastic shapes, XᵀKX.
struct Grams<'a> {
    mass: Gram,
    damping: Gram,
    stiffness: Gram,
    squares: &'a Squares,
}

impl Grams<'_> {
    /// √(x_iᵀMx_i).
    fn norm(&self, i: usize) -> f64 {
        self.mass.at(i, i).to_f64().sqrt()
    }

    /// A bound of ‖B‖² for a group of elastic shapes; `None` where another frequency is too near.
    fn outside(&self, group: &Range<usize>, distance: f64) -> Option<f64> {
        let (values, reach) = (&self.squares.values, &self.squares.reach);
        let all = self.mass.size;
        let mut sum = 0.0;
        for j in group.clone() {
            let quotient = self.stiffness.at(j, j) / self.mass.at(j, j);
            let mut residual = 0.0;
            for i in 0..all {
                let g = self.mass.at(i, j);
                let (s, error) = if i < self.stiffness.size {
                    (self.stiffness.at(i, j), self.stiffness.error(i, j))
                } else {
                    (DoubleDouble::ZERO, 0.0)
                };
                let product = quotient * g;
                let rounding = 2f64.powi(-98) * (product.to_f64().abs() + s.to_f64().abs());
                let error = error + quotient.to_f64().abs() * self.mass.error(i, j) + rounding;
                let entry = (s - product).to_f64().abs() + error;
                residual += (entry / self.norm(i)).powi(2);
            }
            let next = [group.start.checked_sub(1), Some(group.end)];
            let next = next.into_iter().flatten().filter(|i| *i < values.len());
            let others = next.map(|i| (values[i], reach[i]));
            let at_rest = (all > values.len()).then_some((DoubleDouble::ZERO, 0.0));
            let gap = |(other, reach): (DoubleDouble, f64)| {
                (quotient - other).to_f64().abs() * (1.0 - 1e-9) - reach * UPWARD
            };
            let gap = others.chain(at_rest).map(gap).fold(f64::INFINITY, f64::min);
            if gap.is_nan() || gap <= 0.0 {
                return None;
            }
            sum += residual / (1.0 - distance) / (gap * gap) / self.norm(j).powi(2);
        }
        (sum * UPWARD <= 1e-3).then_some(sum * UPWARD)
    }

    /// A bound of |x_iᵀAx_j| for shapes of modal mass 1.
    fn share(&self, gram: &Gram, i: usize, j: usize) -> f64 {
        gram.upper(i, j) / self.norm(i) / self.norm(j)
    }

    /// (1 − ‖E_G‖)‖Γ‖, of all shapes, or more.
    fn largest(&self) -> f64 {
        let all = 0..self.mass.size;
        let row = |i: usize| -> f64 { all.clone().map(|j| self.share(&self.damping, i, j)).sum() };
        all.clone().map(row).fold(0.0, f64::max) * UPWARD
    }

    /// Enclosures of the γ of a group with the given bounds of ‖B‖² and ‖Γ‖, each with a shape of it.
    fn gammas(
        &self,
        group: &Range<usize>,
        outside: f64,
        largest: f64,
    ) -> Option<Vec<(usize, Ball<DoubleDouble>)>> {
        // What is left of both forms beside their diagonals, over the group.
        let beside = |gram: &Gram, i: usize| {
            let entry = |j: usize| {
                if i == j {
                    gram.error(i, i) / self.norm(i).powi(2)
                } else {
                    self.share(gram, i, j)
                }
            };
            group.clone().map(entry).sum::<f64>()
        };
        let rest = |gram: &Gram| {
            let sums = group.clone().map(|i| beside(gram, i));
            sums.fold(0.0, f64::max) * UPWARD
        };
        let damping = rest(&self.damping) + largest * outside;
        let mass = rest(&self.mass) + outside;
        if !(damping.is_finite() && mass <= 1e-2) {
            return None;
        }
        let mut found: Vec<(usize, DoubleDouble)> = group
            .clone()
            .map(|i| (i, self.damping.at(i, i) / self.mass.at(i, i)))
            .collect();
        found.sort_by(|a, b| a.1.partial_cmp(&b.1).unwrap_or(Ordering::Equal));
        let ball = |(i, value): (usize, DoubleDouble)| {
            // The quotient itself rounds.
            let size = value.to_f64().abs();
            let reach = (damping + mass * size) / (1.0 - mass) + 2f64.powi(-98) * size;
            (i, around(value, reach * UPWARD))
        };
        Some(found.into_iter().map(ball).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::samples::{Join, network};
    use crate::{Bounds, Modes};

    /// 2 sin(πp/q), by its series.
    fn chord(p: usize, q: usize) -> DoubleDouble {
        let x =
            DoubleDouble::TAU * DoubleDouble::from(p as f64) / DoubleDouble::from(2.0 * q as f64);
        let (mut term, mut sum) = (x, x);
        for k in 1..30 {
            term = -(term * x * x) / DoubleDouble::from(f64::from(2 * k * (2 * k + 1)));
            sum += term;
        }
        sum * 2.0
    }

    /// The joins i – i + 1 of a chain or, with `closed`, of a ring, one for the ground at each end
    /// that is held.
    fn tridiagonal(n: usize, diagonal: f64, beside: f64, closed: bool) -> Mat<f64> {
        Mat::from_fn(n, n, |i, j| match i.abs_diff(j) {
            0 => diagonal,
            1 => beside,
            apart if closed && apart == n - 1 => beside,
            _ => 0.0,
        })
    }

    fn identity(n: usize, value: f64) -> Mat<f64> {
        Mat::from_fn(n, n, |i, j| if i == j { value } else { 0.0 })
    }

    /// λ = −γ/2 ± √(γ²/4 − σ), with Im ≥ 0; of σ = 0 the nonzero one.
    fn pair(gamma: DoubleDouble, sigma: DoubleDouble) -> Vec<[DoubleDouble; 2]> {
        let zero = DoubleDouble::ZERO;
        let half = gamma * 0.5;
        let rest = half * half - sigma;
        if rest < zero {
            return vec![[-half, (-rest).sqrt()]];
        }
        let large = -half - rest.sqrt();
        let both = [[large, zero], [sigma / large, zero]];
        both.into_iter().filter(|root| root[0] != zero).collect()
    }

    /// Every root is found once, within its bound, to the last digits.
    fn assert_roots(modes: &Modes, mut truth: Vec<[DoubleDouble; 2]>) {
        const U: f64 = f64::EPSILON / 2.0;
        assert_eq!(modes.bounds(), Bounds::Proven, "{}", modes.plan());
        let nonzero = modes.eigenvalues().iter();
        let found = nonzero.filter(|root| root.value.im >= 0.0 && root.value.norm() > 0.0);
        let mut found: Vec<_> = found.collect();
        assert_eq!(found.len(), truth.len());
        let order = |a: (f64, f64), b: (f64, f64)| {
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * (a.abs() + b.abs());
            if near(a.0.hypot(a.1), b.0.hypot(b.1)) {
                a.0.total_cmp(&b.0)
            } else {
                a.0.hypot(a.1).total_cmp(&b.0.hypot(b.1))
            }
        };
        let plain = |z: &[DoubleDouble; 2]| (z[0].to_f64(), z[1].to_f64());
        truth.sort_by(|a, b| order(plain(a), plain(b)));
        found.sort_by(|a, b| order((a.value.re, a.value.im), (b.value.re, b.value.im)));
        for (root, [re, im]) in found.iter().zip(truth) {
            let off = |part: DoubleDouble, double: f64| {
                (part - DoubleDouble::from(double)).to_f64().abs()
            };
            let (re_error, im_error) = (off(re, root.value.re), off(im, root.value.im));
            let (re, size) = (re.to_f64().abs(), re.to_f64().hypot(im.to_f64()));
            let error = re_error.hypot(im_error);
            let (bound, real_bound) = (root.bound.unwrap(), root.real_bound.unwrap());
            assert!(
                error <= bound && re_error <= real_bound,
                "{root:?} {re_error:e} {error:e}"
            );
            assert!(bound <= 4.0 * U * size, "{root:?}");
            assert!(real_bound <= 8.0 * U * re, "{root:?}");
        }
    }

    #[test]
    fn chains_with_damping_of_higher_order() {
        // T = tridiag(−1, 2, −1), M = m, K = kT, C = aI + bT².
        for n in [65, 200] {
            let (m, k, a, b) = (0.5, 3.0, 0.0625, 0.375);
            let chain = tridiagonal(n, 2.0, -1.0, false);
            let damping = &chain * &chain * faer::Scale(b) + identity(n, a);
            let stiffness = &chain * faer::Scale(k);
            let system = System::from_matrices(
                identity(n, m).as_ref(),
                damping.as_ref(),
                stiffness.as_ref(),
            );
            let mut truth = Vec::new();
            for j in 1..=n {
                let t = chord(j, 2 * (n + 1));
                let t = t * t;
                let gamma = (t * t * b + DoubleDouble::from(a)) / DoubleDouble::from(m);
                truth.extend(pair(gamma, t * k / DoubleDouble::from(m)));
            }
            assert_roots(&system.unwrap().modes().unwrap(), truth);
        }
    }

    #[test]
    fn weak_damping_keeps_its_digits() {
        let n = 70;
        let chain = tridiagonal(n, 2.0, -1.0, false);
        let damping = &chain * &chain * faer::Scale(2f64.powi(-60));
        let system =
            System::from_matrices(identity(n, 1.0).as_ref(), damping.as_ref(), chain.as_ref());
        let root = |j| {
            let t = chord(j, 2 * (n + 1));
            pair(t * t * t * t * 2f64.powi(-60), t * t)
        };
        let truth = (1..=n).flat_map(root).collect();
        assert_roots(&system.unwrap().modes().unwrap(), truth);
    }

    #[test]
    fn dampers_across_the_middle_spare_every_other_mode() {
        // Masses i and n − 1 − i of a uniform chain, joined by c: C = c(I − J).
        let n = 100;
        let c = 0.25;
        let springs: Vec<Join> = (0..=n).map(|i| (i, (i + 1) % (n + 1), 1.0)).collect();
        let dampers: Vec<Join> = (1..=n / 2).map(|i| (i, n + 1 - i, c)).collect();
        let modes = network(&vec![1.0; n], &springs, &dampers).modes().unwrap();
        let mut truth = Vec::new();
        for j in 1..=n {
            let t = chord(j, 2 * (n + 1));
            // The first, third … are symmetric.
            let gamma = if j % 2 == 1 { 0.0 } else { 2.0 * c };
            truth.extend(pair(DoubleDouble::from(gamma), t * t));
        }
        assert_roots(&modes, truth);
        let undamped = modes
            .iter()
            .filter(|mode| mode.eigenvalue().value.re == 0.0);
        assert_eq!(undamped.count(), n / 2);
    }

    #[test]
    fn rings_have_every_frequency_twice() {
        // Springs to the next mass of a ring, and to the ground if there are any; dampers to the
        // next but one.
        for (n, ground) in [(66, 0.5), (67, 0.0)] {
            let springs = tridiagonal(n, 2.0 + ground, -1.0, true);
            let dampers = Mat::from_fn(n, n, |i, j| match i.abs_diff(j) {
                0 => 0.25,
                2 => -0.125,
                apart if apart == n - 2 => -0.125,
                _ => 0.0,
            });
            let system = System::from_matrices(
                identity(n, 1.0).as_ref(),
                dampers.as_ref(),
                springs.as_ref(),
            );
            let mut truth = Vec::new();
            for j in 0..n {
                let (once, twice) = (chord(j, n), chord(2 * j % n, n));
                let gamma = twice * twice * 0.125;
                if j == 0 && ground == 0.0 {
                    continue;
                }
                truth.extend(pair(gamma, once * once + DoubleDouble::from(ground)));
            }
            let modes = system.unwrap().modes().unwrap();
            assert_roots(&modes, truth);
            let zeros = modes
                .eigenvalues()
                .iter()
                .filter(|root| root.value.norm() == 0.0);
            assert_eq!(zeros.count(), if ground == 0.0 { 2 } else { 0 });
        }
    }

    #[test]
    fn one_frequency_and_many_dampings() {
        // K = 3M; C = tridiag(−1, 2, −1) in proportion to M = 4I.
        let n = 80;
        let chain = tridiagonal(n, 2.0, -1.0, false);
        let system = System::from_matrices(
            identity(n, 4.0).as_ref(),
            chain.as_ref(),
            identity(n, 12.0).as_ref(),
        );
        let root = |j| {
            let t = chord(j, 2 * (n + 1));
            pair(t * t / DoubleDouble::from(4.0), DoubleDouble::from(3.0))
        };
        let truth = (1..=n).flat_map(root).collect();
        assert_roots(&system.unwrap().modes().unwrap(), truth);
    }

    #[test]
    fn what_only_dampers_hold_relaxes() {
        // Two free chains side by side, each mass tied to its twin by a damper.
        let n = 40;
        let c = 0.75;
        let springs = [0, n].map(|side| (1..n).map(move |i| (side + i, side + i + 1, 1.5)));
        let springs: Vec<Join> = springs.into_iter().flatten().collect();
        let dampers: Vec<Join> = (1..=n).map(|i| (i, n + i, c)).collect();
        let modes = network(&vec![2.0; 2 * n], &springs, &dampers)
            .modes()
            .unwrap();
        let mut truth = Vec::new();
        for j in 0..n {
            let t = chord(j, 2 * n);
            let sigma = t * t * 0.75;
            // Together, and against each other.
            truth.extend(pair(DoubleDouble::from(c), sigma));
            if j > 0 {
                truth.extend(pair(DoubleDouble::ZERO, sigma));
            }
        }
        assert_roots(&modes, truth);
        let zeros = modes
            .eigenvalues()
            .iter()
            .filter(|root| root.value.norm() == 0.0);
        assert_eq!(zeros.count(), 3);
    }

    #[test]
    fn no_proof_of_what_is_not_classical() {
        let chain = tridiagonal(6, 2.0, -1.0, false);
        let damping = Mat::from_fn(6, 6, |i, j| if (i, j) == (0, 0) { 0.5 } else { 0.0 });
        let system =
            System::from_matrices(identity(6, 1.0).as_ref(), damping.as_ref(), chain.as_ref());
        let system = system.unwrap();
        let shapes = (0..6).map(|i| (0..6).map(|j| f64::from(u8::from(i == j))).collect());
        assert!(certify(&system, shapes.collect(), 1e-15).is_none());
    }
}
