//! The system as first-order equations with more digits, each entry with a proven bound.

use eigentone_digits::{BallMatrix, Magnitude, Real};

use crate::exact::matrix::ExactMatrix;
use crate::first_order::{FirstOrderError, Massless};
use crate::model::MatrixKind;
use crate::system::System;

/// z′ = A z + B f(t), x = X z + D f, as in [`FirstOrder`](crate::FirstOrder), but in the arithmetic
/// of T, from the elements themselves, and with a proven bound of every entry.
#[derive(Clone, Debug)]
pub struct EnclosedFirstOrder<T> {
    massive: Vec<usize>,
    a: BallMatrix<T>,
    b: BallMatrix<T>,
    x: BallMatrix<T>,
    d: BallMatrix<T>,
    initial: BallMatrix<T>,
    mass: BallMatrix<T>,
    stiffness: BallMatrix<T>,
}

impl<T: Real> EnclosedFirstOrder<T> {
    /// The first-order form of a system.
    ///
    /// # Errors
    /// Those of [`FirstOrder::of`](crate::FirstOrder::of), also where the digits of T do not show
    /// that a matrix to be divided by is nonsingular.
    pub fn of(system: &System) -> Result<EnclosedFirstOrder<T>, FirstOrderError> {
        let n = system.len();
        let massless = Massless::of_system(system);
        let massive = massless.massive().to_vec();
        let (nf, nw, na) = (massive.len(), massless.relaxing(), massless.following());
        let nr = nf + nw;

        // The congruence P with x = P (x_f, w, a).
        let mut p = BallMatrix::<T>::zeros(n, n);
        let one = |matrix: &mut BallMatrix<T>, i: usize, j: usize| {
            matrix.set(i, j, T::ONE, Magnitude::ZERO);
        };
        for (column, &i) in massive.iter().enumerate() {
            one(&mut p, i, column);
        }
        for (i, column) in massless.change() {
            one(&mut p, i, nf + column);
        }
        let transposed = transpose(&p);
        let transform = |kind| transposed.times(&assembled(system, kind)).times(&p);
        let (m, c, k) = (
            transform(MatrixKind::Mass),
            transform(MatrixKind::Damping),
            transform(MatrixKind::Stiffness),
        );

        // Followers: a = K_aa⁻¹ (f_a − K_ar r).
        let k_aa = k.block(nr, nr, na, na);
        let solved = |right: &BallMatrix<T>| k_aa.solve(right).ok_or(FirstOrderError::Constraint);
        let follow = solved(&k.block(nr, 0, na, nr))?;
        let feed = solved(&transposed.block(nr, 0, na, n))?;
        let k_ra = k.block(0, nr, nr, na);
        let stiffness = minus(&k.block(0, 0, nr, nr), &k_ra.times(&follow));
        let force = minus(&transposed.block(0, 0, nr, n), &k_ra.times(&feed));

        // Rows of the balance of forces over the states (x_f, v, w), without the accelerations.
        let states = 2 * nf + nw;
        let balance = |first: usize, rows: usize| {
            let mut balance = BallMatrix::zeros(rows, states);
            balance.put(0, 0, &stiffness.block(first, 0, rows, nf));
            balance.put(0, nf, &c.block(first, 0, rows, nf));
            balance.put(0, 2 * nf, &stiffness.block(first, nf, rows, nw));
            balance.negated()
        };
        // Relaxing coordinates: w′ = C_ww⁻¹ (f_w − C_wf v − K_wf x − K_ww w).
        let c_ww = c.block(nf, nf, nw, nw);
        let relaxed =
            |right: &BallMatrix<T>| c_ww.solve(right).ok_or(FirstOrderError::SingularDamping);
        let rate = relaxed(&balance(nf, nw))?;
        let rate_force = relaxed(&force.block(nf, 0, nw, n))?;
        let c_fw = c.block(0, nf, nf, nw);
        let momentum = minus(&balance(0, nf), &c_fw.times(&rate));
        let momentum_force = minus(&force.block(0, 0, nf, n), &c_fw.times(&rate_force));

        let mass = m.block(0, 0, nf, nf);
        let divided =
            |right: &BallMatrix<T>| mass.solve(right).ok_or(FirstOrderError::SingularMass);
        let mut a = BallMatrix::zeros(states, states);
        let mut b = BallMatrix::zeros(states, n);
        (0..nf).for_each(|i| one(&mut a, i, nf + i));
        a.put(nf, 0, &divided(&momentum)?);
        b.put(nf, 0, &divided(&momentum_force)?);
        a.put(2 * nf, 0, &rate);
        b.put(2 * nf, 0, &rate_force);

        // Back to the coordinates: x = P (x_f, w, a).
        let mut reduced = BallMatrix::zeros(nr, states);
        (0..nf).for_each(|i| one(&mut reduced, i, i));
        (0..nw).for_each(|i| one(&mut reduced, nf + i, 2 * nf + i));
        let p_a = p.block(0, nr, n, na);
        let x = minus(
            &p.block(0, 0, n, nr).times(&reduced),
            &p_a.times(&follow.times(&reduced)),
        );
        let d = p_a.times(&feed);

        let mut initial = BallMatrix::zeros(states, 2 * n);
        for (row, &i) in massive.iter().enumerate() {
            one(&mut initial, row, i);
            one(&mut initial, nf + row, n + i);
        }
        for (row, i, sign) in massless.state_entries() {
            initial.set(2 * nf + row, i, T::from(sign), Magnitude::ZERO);
        }
        Ok(EnclosedFirstOrder {
            massive,
            a,
            b,
            x,
            d,
            initial,
            mass,
            stiffness,
        })
    }

    /// The number N of states.
    pub fn states(&self) -> usize {
        self.a.rows()
    }

    /// The coordinates that have mass, whose displacements and velocities come first in z.
    pub fn massive(&self) -> &[usize] {
        &self.massive
    }

    /// A (N × N).
    pub fn a(&self) -> &BallMatrix<T> {
        &self.a
    }

    /// B (N × n). It is also the change of z that unit impulses make.
    pub fn b(&self) -> &BallMatrix<T> {
        &self.b
    }

    /// X (n × N).
    pub fn x(&self) -> &BallMatrix<T> {
        &self.x
    }

    /// D (n × n), what forces on undamped massless nodes displace at once; all 0 if there are no
    /// such nodes.
    pub fn d(&self) -> &BallMatrix<T> {
        &self.d
    }

    /// z from the displacements, then the velocities of all coordinates (N × 2n); what massless
    /// nodes cannot be given is passed over.
    pub fn initial(&self) -> &BallMatrix<T> {
        &self.initial
    }

    /// The mass matrix of the coordinates that have mass.
    pub fn mass(&self) -> &BallMatrix<T> {
        &self.mass
    }

    /// The stiffness of the coordinates with mass, then of the relaxing ones, with the followers
    /// eliminated.
    pub fn stiffness(&self) -> &BallMatrix<T> {
        &self.stiffness
    }
}

fn minus<T: Real>(a: &BallMatrix<T>, b: &BallMatrix<T>) -> BallMatrix<T> {
    a.plus(&b.clone().negated())
}

fn transpose<T: Real>(a: &BallMatrix<T>) -> BallMatrix<T> {
    let mut transposed = BallMatrix::zeros(a.columns(), a.rows());
    for i in 0..a.rows() {
        for j in 0..a.columns() {
            transposed.set(j, i, a.middle(i, j), a.radius(i, j));
        }
    }
    transposed
}

/// M, C or K, summed from its terms.
fn assembled<T: Real>(system: &System, kind: MatrixKind) -> BallMatrix<T> {
    let n = system.len();
    let exact = ExactMatrix::of(system.model(), kind);
    let mut matrix = BallMatrix::zeros(n, n);
    for i in 0..n {
        for (j, terms) in exact.row(i) {
            for &term in terms {
                matrix.add(i, j, T::from(term), Magnitude::ZERO);
            }
        }
    }
    matrix
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::first_order::FirstOrder;
    use crate::model::GROUND;
    use eigentone_digits::DoubleDouble;

    /// Mass and massless nodes of every kind: damped, in a floating group, and undamped.
    fn zoo() -> System {
        let node = |builder: crate::SystemBuilder, name: &str| builder.mass(name, 0.0);
        let builder = System::builder().mass("m1", 2.0).mass("m2", 0.5);
        let builder = ["p", "q", "r", "s"].into_iter().fold(builder, node);
        builder
            .spring(GROUND, "m1", 3.0)
            .spring("m1", "p", 5.0)
            .spring("p", "m2", 7.0)
            .damper("m1", "m2", 0.25)
            .damper("q", "m1", 0.5)
            .spring("q", GROUND, 11.0)
            .damper("r", "s", 2.0)
            .spring("r", "m1", 13.0)
            .spring("s", "m2", 17.0)
            .build()
            .expect("it is regular")
    }

    #[test]
    fn agrees_with_the_form_in_doubles() {
        let system = zoo();
        let precise = EnclosedFirstOrder::<DoubleDouble>::of(&system).expect("regular");
        let plain = FirstOrder::of(&system).expect("regular");
        assert_eq!(precise.states(), plain.states());
        let same = |precise: &BallMatrix<DoubleDouble>, plain: faer::MatRef<'_, f64>| {
            for i in 0..plain.nrows() {
                for j in 0..plain.ncols() {
                    let (x, r) = (precise.middle(i, j).to_f64(), precise.radius(i, j).to_f64());
                    assert!(
                        (x - plain[(i, j)]).abs() < 1e-13,
                        "({i}, {j}): {x} {}",
                        plain[(i, j)]
                    );
                    assert!(r < 1e-26, "({i}, {j}): {r}");
                }
            }
        };
        same(precise.a(), plain.a());
        same(precise.b(), plain.b());
        same(precise.x(), plain.x());
        same(precise.d(), plain.d().expect("p follows"));
        let x0: Vec<f64> = (1..=6).map(f64::from).collect();
        let v0: Vec<f64> = (1..=6).map(|i| f64::from(i) * 0.5).collect();
        let z = plain.state(&x0, &v0);
        for (i, z) in z.iter().enumerate() {
            let both = x0.iter().chain(&v0).enumerate();
            let sum: f64 = both
                .map(|(j, value)| precise.initial().middle(i, j).to_f64() * value)
                .sum();
            assert_eq!(sum, *z);
        }
    }
}
