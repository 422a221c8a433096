//! The eigenvalues μ of A = (K − σM)⁻¹M that are largest in size, by Lanczos' method in the inner
//! product of M, with full reorthogonalisation and thick restarts (Wu & Simon 2000, *SIAM J. Matrix
//! Anal. Appl.* 22).
//!
//! Known eigenvectors are locked: what is found is orthogonal to them. Of a multiple eigenvalue one
//! run can in exact arithmetic find one vector; the others are found by runs that have it locked.

use eigentone_digits::{sort_by_number, symmetric_eigen};
use faer::Mat;

use super::basis::{combine, dot, products, subtract};
use super::operator::ShiftInvert;
use super::random::uniform;

/// What a run found.
#[derive(Debug)]
pub(crate) struct Found {
    /// μ of each vector, largest first in size.
    pub(crate) values: Vec<f64>,
    /// Ritz vectors of M-norm 1.
    pub(crate) vectors: Vec<Vec<f64>>,
    /// The next Ritz value, near an eigenvalue not yet found.
    pub(crate) next: Option<f64>,
    /// How often A was applied.
    pub(crate) applied: usize,
    /// Whether there is nothing else: A has no further eigenvalue other than 0.
    pub(crate) exhausted: bool,
}

/// What a run is asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// How many eigenvalues.
    pub(crate) wanted: usize,
    /// At which residual, relative to μ, a vector counts as found.
    pub(crate) tolerance: f64,
    /// Of the start vector.
    pub(crate) seed: u64,
}

/// Restarts without an answer before a run is given up.
const RESTARTS: usize = 200;

/// Finds eigenvectors orthogonal to `locked`; `None` where it does not converge or leaves the range of
/// doubles.
pub(crate) fn lanczos(
    operator: &ShiftInvert<'_>,
    locked: &[Vec<f64>],
    goal: Goal,
) -> Option<Found> {
    let n = operator.pencil.len();
    let most = (2 * goal.wanted).max(goal.wanted + 24).min(n);
    let mut krylov = Krylov::new(operator, locked, goal.seed, most);
    let mut restarts = 0;
    let mut check = goal.wanted + 4;
    if !krylov.start() {
        return Some(krylov.found(&Ritz::none(), 0, true));
    }
    loop {
        krylov.step()?;
        let size = krylov.size;
        let exhausted = krylov.coupling == 0.0 && (size == n || !krylov.start());
        if !exhausted && size < most && size < check {
            continue;
        }
        let ritz = Ritz::of(&krylov)?;
        let converged = ritz.converged(krylov.coupling, goal.tolerance);
        let clear = ritz.clear();
        if exhausted || converged >= goal.wanted.min(clear) {
            let count = if exhausted {
                clear
            } else {
                converged.min(clear)
            };
            return Some(krylov.found(&ritz, count, exhausted && clear == size));
        }
        check = size + 4.max(size / 8);
        if size == most {
            restarts += 1;
            if restarts > RESTARTS {
                return None;
            }
            let kept = goal.wanted.max(converged) + (most - goal.wanted.max(converged)) / 2;
            krylov.restart(&ritz, kept.min(most - 2));
            check = krylov.size + 4;
        }
    }
}

/// A basis of a Krylov space, and A projected on it.
struct Krylov<'a, 'b> {
    operator: &'a ShiftInvert<'b>,
    locked: &'a [Vec<f64>],
    /// Orthonormal in the inner product of M; one more than `size`, but at the end.
    basis: Vec<Vec<f64>>,
    /// The order of `projected` that is known.
    size: usize,
    projected: Mat<f64>,
    /// The M-norm of what the last product left beyond the basis.
    coupling: f64,
    /// The largest entry seen.
    scale: f64,
    applied: usize,
    random: u64,
    product: Vec<f64>,
    work: Vec<f64>,
}

impl<'a, 'b> Krylov<'a, 'b> {
    fn new(
        operator: &'a ShiftInvert<'b>,
        locked: &'a [Vec<f64>],
        seed: u64,
        most: usize,
    ) -> Krylov<'a, 'b> {
        let n = operator.pencil.len();
        Krylov {
            operator,
            locked,
            basis: Vec::with_capacity(most + 1),
            size: 0,
            projected: Mat::zeros(most, most),
            coupling: 0.0,
            scale: 0.0,
            applied: 0,
            random: seed,
            product: vec![0.0; n],
            work: vec![0.0; n],
        }
    }

    /// Adds a random vector, orthogonal to all; `false` where there is no direction left.
    fn start(&mut self) -> bool {
        const LEAST: f64 = 1e-8;
        let mut x: Vec<f64> = self.work.iter().map(|_| 0.0).collect();
        for value in &mut x {
            *value = uniform(&mut self.random);
        }
        self.operator.project(&mut x, &mut self.work);
        let before = self.norm(&x);
        for _ in 0..3 {
            self.orthogonalise(&mut x);
        }
        let after = self.norm(&x);
        if !(after > LEAST * before && after.is_finite()) {
            return false;
        }
        x.iter_mut().for_each(|value| *value /= after);
        self.basis.push(x);
        true
    }

    /// Applies A to the last vector, and adds what is new of the product as the next.
    fn step(&mut self) -> Option<()> {
        let j = self.size;
        let mut x = vec![0.0; self.work.len()];
        self.operator.pencil.mass.apply(&self.basis[j], &mut x);
        self.operator.solve(&mut x, &mut self.work);
        self.applied += 1;
        // What is known of the product, then what rounding has left, as often as there is some.
        self.operator.pencil.mass.apply(&x, &mut self.product);
        let along = dot(&self.basis[j], &self.product);
        self.projected[(j, j)] = along;
        let known: Vec<f64> = (0..=j).map(|i| self.projected[(i, j)]).collect();
        let first = known.iter().position(|known| *known != 0.0).unwrap_or(j);
        subtract(&self.basis[first..=j], &known[first..], &mut x);
        let mut before = self.norm(&x);
        for _ in 0..4 {
            self.projected[(j, j)] += self.orthogonalise(&mut x);
            let after = self.norm(&x);
            self.coupling = after;
            if after > 0.7 * before {
                break;
            }
            before = after;
        }
        if !self.coupling.is_finite() {
            return None;
        }
        self.size += 1;
        self.scale = self.scale.max(along.abs());
        let noise = 16.0 * f64::EPSILON * self.scale;
        if self.coupling <= noise || self.size == self.work.len() {
            self.coupling = 0.0;
            return Some(());
        }
        let coupling = self.coupling;
        x.iter_mut().for_each(|value| *value /= coupling);
        if self.size < self.projected.nrows() {
            self.projected[(j, j + 1)] = coupling;
            self.projected[(j + 1, j)] = coupling;
        }
        self.basis.push(x);
        Some(())
    }

    /// Makes x orthogonal to what is locked and to the basis. Returns its part along the last vector.
    fn orthogonalise(&mut self, x: &mut [f64]) -> f64 {
        self.operator.project(x, &mut self.work);
        self.operator.pencil.mass.apply(x, &mut self.product);
        let among_locked = products(self.locked, &self.product);
        let along = products(&self.basis, &self.product);
        subtract(self.locked, &among_locked, x);
        subtract(&self.basis, &along, x);
        along.last().copied().unwrap_or(0.0)
    }

    fn norm(&mut self, x: &[f64]) -> f64 {
        self.operator.pencil.mass.apply(x, &mut self.product);
        dot(x, &self.product).max(0.0).sqrt()
    }

    /// Goes on with the leading Ritz vectors alone, and the vector that comes next.
    fn restart(&mut self, ritz: &Ritz, kept: usize) {
        let next = self.basis.pop().expect("a restart has a next vector");
        combine(&mut self.basis, ritz.vectors.subcols(0, kept));
        self.basis.truncate(kept);
        self.basis.push(next);
        self.projected.fill(0.0);
        for i in 0..kept {
            let coupling = self.coupling * ritz.vectors[(self.size - 1, i)];
            self.projected[(i, i)] = ritz.values[i];
            self.projected[(i, kept)] = coupling;
            self.projected[(kept, i)] = coupling;
        }
        self.size = kept;
    }

    fn found(mut self, ritz: &Ritz, count: usize, exhausted: bool) -> Found {
        combine(&mut self.basis, ritz.vectors.subcols(0, count));
        self.basis.truncate(count);
        Found {
            values: ritz.values[..count].to_vec(),
            vectors: self.basis,
            next: ritz.values.get(count).copied(),
            applied: self.applied,
            exhausted,
        }
    }
}

/// The eigenvalues of A as the basis sees them, largest first in size, with their vectors in the
/// basis.
struct Ritz {
    values: Vec<f64>,
    vectors: Mat<f64>,
}

impl Ritz {
    fn none() -> Ritz {
        Ritz {
            values: Vec::new(),
            vectors: Mat::zeros(0, 0),
        }
    }

    fn of(krylov: &Krylov<'_, '_>) -> Option<Ritz> {
        let size = krylov.size;
        let projected = krylov.projected.submatrix(0, 0, size, size).to_owned();
        let (values, vectors) = symmetric_eigen(&projected)?;
        let value = |k: &usize| values[*k];
        let mut order: Vec<usize> = (0..size).collect();
        sort_by_number(&mut order, |k| -value(k).abs());
        Some(Ritz {
            values: order.iter().map(value).collect(),
            vectors: Mat::from_fn(size, size, |i, j| vectors[(i, order[j])]),
        })
    }

    /// How many of the leading ones stand clear of the rounding that the largest brings along; the
    /// others are left to runs that have these locked.
    fn clear(&self) -> usize {
        const CLEAR: f64 = 1e-9;
        let largest = self.values.first().map_or(0.0, |value| value.abs());
        self.values
            .partition_point(|value| value.abs() >= CLEAR * largest)
    }

    /// How many of the leading ones have residuals within the tolerance.
    fn converged(&self, coupling: f64, tolerance: f64) -> usize {
        let last = self.values.len() - 1;
        let within = |(k, value): &(usize, &f64)| {
            (coupling * self.vectors[(last, *k)]).abs() <= tolerance * value.abs()
        };
        self.values.iter().enumerate().take_while(within).count()
    }
}
