//! The elimination of massless nodes, in any arithmetic.

use eigentone_digits::Real;

use super::error::FirstOrderError;
use super::massless::Massless;
use crate::exact::matrix::ExactMatrix;
use crate::linear::plain_matrix::PlainMatrix;
use crate::model::MatrixKind;
use crate::system::System;

/// A matrix that the elimination can work with.
pub(super) trait Dense: Sized {
    fn zeros(rows: usize, columns: usize) -> Self;

    fn size(&self) -> [usize; 2];

    /// Adds a term to an entry.
    fn add(&mut self, i: usize, j: usize, term: f64);

    /// Sets an entry to that of another matrix.
    fn copy(&mut self, to: [usize; 2], from: &Self, at: [usize; 2]);

    fn times(&self, other: &Self) -> Self;

    fn minus(&self, other: &Self) -> Self;

    /// A⁻¹·right for this square matrix A; `None` where the arithmetic does not show that it is nonsingular.
    fn solve(&self, right: &Self) -> Option<Self>;

    /// The block of this size whose first entry is (i, j).
    fn block(&self, i: usize, j: usize, rows: usize, columns: usize) -> Self {
        let mut block = Self::zeros(rows, columns);
        for row in 0..rows {
            for column in 0..columns {
                block.copy([row, column], self, [i + row, j + column]);
            }
        }
        block
    }

    /// Writes a block so that its first entry becomes (i, j).
    fn put(&mut self, i: usize, j: usize, block: &Self) {
        let [rows, columns] = block.size();
        for row in 0..rows {
            for column in 0..columns {
                self.copy([i + row, j + column], block, [row, column]);
            }
        }
    }

    fn transposed(&self) -> Self {
        let [rows, columns] = self.size();
        let mut transposed = Self::zeros(columns, rows);
        for i in 0..rows {
            for j in 0..columns {
                transposed.copy([j, i], self, [i, j]);
            }
        }
        transposed
    }
}

/// z′ = A z + B f, x = X z + D f, as in [`FirstOrder`](super::FirstOrder).
pub(super) struct Eliminated<M> {
    pub(super) a: M,
    pub(super) b: M,
    pub(super) x: M,
    pub(super) d: M,
    /// The mass matrix of the coordinates that have mass.
    pub(super) mass: M,
    /// The stiffness of those, then of the relaxing ones, with the followers eliminated.
    pub(super) stiffness: M,
}

impl<M: Dense> Eliminated<M> {
    pub(super) fn of(system: &System, massless: &Massless) -> Result<Self, FirstOrderError> {
        let n = system.len();
        let massive = massless.massive();
        let (nf, nw, na) = (massive.len(), massless.relaxing(), massless.following());
        let nr = nf + nw;
        let negative = |matrix: &M| {
            let [rows, columns] = matrix.size();
            M::zeros(rows, columns).minus(matrix)
        };

        // The congruence P with x = P (x_f, w, a).
        let mut p = M::zeros(n, n);
        for (column, &i) in massive.iter().enumerate() {
            p.add(i, column, 1.0);
        }
        for (i, column) in massless.change() {
            p.add(i, nf + column, 1.0);
        }
        let transposed = p.transposed();
        let transform = |kind| transposed.times(&assembled::<M>(system, kind)).times(&p);
        let (m, c, k) = (
            transform(MatrixKind::Mass),
            transform(MatrixKind::Damping),
            transform(MatrixKind::Stiffness),
        );

        // Followers: a = K_aa⁻¹ (f_a − K_ar r).
        let k_aa = k.block(nr, nr, na, na);
        let solved = |right: &M| k_aa.solve(right).ok_or(FirstOrderError::Constraint);
        let follow = solved(&k.block(nr, 0, na, nr))?;
        let feed = solved(&transposed.block(nr, 0, na, n))?;
        let k_ra = k.block(0, nr, nr, na);
        let stiffness = k.block(0, 0, nr, nr).minus(&k_ra.times(&follow));
        let force = transposed.block(0, 0, nr, n).minus(&k_ra.times(&feed));

        // Rows of the balance of forces over the states (x_f, v, w), without the accelerations.
        let states = 2 * nf + nw;
        let balance = |first: usize, rows: usize| {
            let mut balance = M::zeros(rows, states);
            balance.put(0, 0, &stiffness.block(first, 0, rows, nf));
            balance.put(0, nf, &c.block(first, 0, rows, nf));
            balance.put(0, 2 * nf, &stiffness.block(first, nf, rows, nw));
            negative(&balance)
        };
        // Relaxing coordinates: w′ = C_ww⁻¹ (f_w − C_wf v − K_wf x − K_ww w).
        let c_ww = c.block(nf, nf, nw, nw);
        let relaxed = |right: &M| c_ww.solve(right).ok_or(FirstOrderError::SingularDamping);
        let rate = relaxed(&balance(nf, nw))?;
        let rate_force = relaxed(&force.block(nf, 0, nw, n))?;
        let c_fw = c.block(0, nf, nf, nw);
        let momentum = balance(0, nf).minus(&c_fw.times(&rate));
        let momentum_force = force.block(0, 0, nf, n).minus(&c_fw.times(&rate_force));

        let mass = m.block(0, 0, nf, nf);
        let divided = |right: &M| mass.solve(right).ok_or(FirstOrderError::SingularMass);
        let mut a = M::zeros(states, states);
        let mut b = M::zeros(states, n);
        (0..nf).for_each(|i| a.add(i, nf + i, 1.0));
        a.put(nf, 0, &divided(&momentum)?);
        b.put(nf, 0, &divided(&momentum_force)?);
        a.put(2 * nf, 0, &rate);
        b.put(2 * nf, 0, &rate_force);

        // Back to the coordinates: x = P (x_f, w, a).
        let mut reduced = M::zeros(nr, states);
        (0..nf).for_each(|i| reduced.add(i, i, 1.0));
        (0..nw).for_each(|i| reduced.add(nf + i, 2 * nf + i, 1.0));
        let p_a = p.block(0, nr, n, na);
        let own = p.block(0, 0, n, nr).times(&reduced);
        let x = own.minus(&p_a.times(&follow.times(&reduced)));
        Ok(Eliminated {
            a,
            b,
            x,
            d: p_a.times(&feed),
            mass,
            stiffness,
        })
    }
}

impl<T: Real> Dense for PlainMatrix<T> {
    fn zeros(rows: usize, columns: usize) -> Self {
        PlainMatrix::zeros(rows, columns)
    }

    fn size(&self) -> [usize; 2] {
        PlainMatrix::size(self)
    }

    fn add(&mut self, i: usize, j: usize, term: f64) {
        self.set(i, j, self.get(i, j) + T::from(term));
    }

    fn copy(&mut self, to: [usize; 2], from: &Self, at: [usize; 2]) {
        self.set(to[0], to[1], from.get(at[0], at[1]));
    }

    fn times(&self, other: &Self) -> Self {
        PlainMatrix::times(self, other)
    }

    fn minus(&self, other: &Self) -> Self {
        let mut difference = PlainMatrix::zeros(self.size()[0], self.size()[1]);
        for i in 0..self.size()[0] {
            for (j, entry) in self.row(i).iter().enumerate() {
                difference.set(i, j, *entry - other.get(i, j));
            }
        }
        difference
    }

    fn solve(&self, right: &Self) -> Option<Self> {
        PlainMatrix::solve(self, right)
    }
}

/// M, C or K, summed from its terms.
fn assembled<M: Dense>(system: &System, kind: MatrixKind) -> M {
    let n = system.len();
    let exact = ExactMatrix::of(system.model(), kind);
    let mut matrix = M::zeros(n, n);
    for i in 0..n {
        for (j, terms) in exact.row(i) {
            terms.iter().for_each(|term| matrix.add(i, j, *term));
        }
    }
    matrix
}
