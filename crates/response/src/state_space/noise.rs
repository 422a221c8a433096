//! What white noise adds to the covariance of the state in a step, Q = ∫₀ʰ e^{As} B W Bᵀ e^{Aᵀs} ds, or in all the time.
//!
//! Both are [Gramians](gramian).

use eigentone_digits::{BallMatrix, Magnitude, Real};
use eigentone_modes::{Bounds, Eigenvalue, Precision, System};
use faer::MatRef;

use super::asked::Asked;
use super::bounded::BoundedMatrix;
use super::coordinates::{Coordinates, kept, transposed};
use super::error::StateSpaceError;
use super::ladder::{Found, Question};
use super::realisation::Realisation;
use crate::enclosed::{Normed, gramian};

pub(super) struct Noise<'a> {
    pub(super) asked: &'a Asked<'a>,
    /// In s, or the unit of time with which an integral over all the time begins.
    pub(super) step: f64,
    pub(super) forever: bool,
    pub(super) density: MatRef<'a, f64>,
}

impl Question for Noise<'_> {
    type Answer = BoundedMatrix;

    fn attempt<T: Real>(&self) -> Found<BoundedMatrix> {
        let Some(form) = Realisation::<T>::of(self.asked) else {
            return Ok(None);
        };
        let Some(coordinates) = Coordinates::of(self.asked, &form, self.step) else {
            return Ok(None);
        };
        let kept_up = accumulated(&coordinates, &form, self.density, self.step, self.forever);
        let Some(sum) = kept_up else {
            return Ok(None);
        };
        let n = form.a.rows();
        let states = BallMatrix::identity(n);
        let (exact, rows) = coordinates.covariance(&states, &kept(&sum, 0, n, n), sum.error());
        let exact = upper_half(exact);
        let norm = sum.true_norm();
        BoundedMatrix::of(&exact, "Q", |i, j| rows[i] * rows[j] * norm)
    }
}

/// Refuses a system of which a part is known not to come to rest by itself, and names it.
pub(super) fn comes_to_rest(system: &System) -> Result<(), StateSpaceError> {
    let structure = system.structure();
    let counted = |count: Option<usize>| count.filter(|count| *count > 0);
    let what = if counted(structure.zero_roots()).is_some() {
        let groups = structure.spring_floating().iter().flatten();
        let names: Vec<String> = groups
            .map(|i| format!("{:?}", system.names()[*i]))
            .collect();
        match names.is_empty() {
            true => "a rigid motion".to_owned(),
            false => format!("the rigid motion of {}", names.join(", ")),
        }
    } else {
        // Forces that do no work damp none.
        let undamped = match structure.is_gyroscopic() {
            true => Some(system.len()),
            false => structure.undamped_modes(),
        };
        match counted(undamped) {
            None if structure.is_reversible() && counted(structure.finite_roots()).is_some() => {
                "what has no damping".to_owned()
            }
            None if grows(system) => "a mode that grows".to_owned(),
            None => return Ok(()),
            Some(1) => "an undamped mode".to_owned(),
            Some(count) => format!("each of {count} undamped modes"),
        }
    };
    Err(StateSpaceError::NotStationary { what })
}

/// Whether a mode is proved to grow. Where doubles show that all decay there is nothing to prove.
fn grows(system: &System) -> bool {
    /// Nearer to the axis doubles may not show on which side a root is.
    const NEAR: f64 = 1e-9;
    let is_clear = |root: &Eigenvalue| {
        let left = root.value.re < -NEAR * root.value.norm();
        !root.is_doubtful() && left
    };
    let quick = system.modes_to(Precision::Double);
    if quick.is_ok_and(|modes| modes.eigenvalues().iter().all(is_clear)) {
        return false;
    }
    let proven = system.modes().ok();
    let proven = proven.filter(|modes| modes.bounds() == Bounds::Proven);
    let grows = |root: &Eigenvalue| root.real_bound.is_some_and(|bound| root.value.re > bound);
    proven.is_some_and(|modes| modes.eigenvalues().iter().any(grows))
}

/// The same of an integral over all the time, of which it is the end that digits do not show.
pub(super) fn not_shown(error: StateSpaceError) -> StateSpaceError {
    match error {
        StateSpaceError::Lost => StateSpaceError::NotShownStationary,
        error => error,
    }
}

/// What noise on the inputs adds up to in these coordinates; `None` where the digits of T do not suffice, or where it is to
/// end by itself and does not.
pub(super) fn accumulated<T: Real>(
    coordinates: &Coordinates<T>,
    form: &Realisation<T>,
    density: MatRef<'_, f64>,
    step: f64,
    forever: bool,
) -> Option<Normed<T>> {
    let (n, m) = (form.a.rows(), form.b.columns());
    let mut intensity = BallMatrix::zeros(m, m);
    for i in 0..m {
        for j in 0..m {
            intensity.set(i, j, T::from(density[(i, j)]), Magnitude::ZERO);
        }
    }
    let b = coordinates.entered(&form.b);
    let rate = b.times(&intensity).times(&transposed(&b));
    let rate = Normed::of(&rate, n);
    let w = Normed::of(&coordinates.a, n).with_more_error(coordinates.a_error);
    let first = (T::from(step), Magnitude::ZERO);
    if !forever {
        return gramian(&w, &rate, first, false);
    }
    let sum = gramian(&w, &rate, first, true)?;
    // Of P + Δ the rest W(P + Δ) + (P + Δ)Wᵀ + rate is R, and |Δ| ≤ ‖R‖ ∫e^{Wt}e^{Wᵀt}dt.
    let kept = symmetric(&sum);
    let once = w.times(&kept);
    let rest = once.plus(&once.transposed()).plus(&rate).true_norm();
    let all = gramian(&w, &Normed::identity(n, n), first, true)?;
    let error = rest * all.true_norm();
    Some(match error < sum.error() {
        true => kept.with_more_error(error),
        false => sum,
    })
}

/// What is kept of the upper half, in both.
fn symmetric<T: Real>(matrix: &Normed<T>) -> Normed<T> {
    let n = matrix.len();
    let entry = |at: usize| {
        let (i, j) = (at / n, at % n);
        matrix.row(i.min(j))[i.max(j)]
    };
    Normed::new(n, n, (0..n * n).map(entry).collect(), Magnitude::ZERO)
}

/// The same with both halves alike, as they are in truth.
fn upper_half<T: Real>(mut a: BallMatrix<T>) -> BallMatrix<T> {
    for i in 0..a.rows() {
        for j in 0..i {
            let (middle, radius) = (a.middle(j, i), a.radius(j, i));
            a.set(i, j, middle, radius);
        }
    }
    a
}
