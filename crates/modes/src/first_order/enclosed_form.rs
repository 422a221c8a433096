//! The system as first-order equations with more digits, each entry with a proven bound.

use eigentone_digits::{BallMatrix, Magnitude, Real};

use super::elimination::{Dense, Eliminated};
use super::error::FirstOrderError;
use super::massless::Massless;
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
        let massless = Massless::of_system(system);
        let Eliminated {
            a,
            b,
            x,
            d,
            mass,
            stiffness,
        } = Eliminated::<BallMatrix<T>>::of(system, &massless)?;
        let (n, nf) = (system.len(), massless.massive().len());
        let mut initial = BallMatrix::zeros(a.rows(), 2 * n);
        for (row, &i) in massless.massive().iter().enumerate() {
            initial.set(row, i, T::ONE, Magnitude::ZERO);
            initial.set(nf + row, n + i, T::ONE, Magnitude::ZERO);
        }
        for (row, i, sign) in massless.state_entries() {
            initial.set(2 * nf + row, i, T::from(sign), Magnitude::ZERO);
        }
        Ok(EnclosedFirstOrder {
            massive: massless.massive().to_vec(),
            a,
            b,
            x,
            d,
            initial,
            mass,
            stiffness,
        })
    }

    /// The same where the states that are not `kept` are 0 all the time, and left out: a coordinate with mass stays as a
    /// whole where its displacement or its velocity is kept. There is no proof here that they are 0.
    ///
    /// # Panics
    /// If `kept` does not say it of each state.
    #[must_use]
    pub fn within(&self, kept: &[bool]) -> EnclosedFirstOrder<T> {
        assert_eq!(kept.len(), self.states(), "one for each state");
        let nf = self.massive.len();
        let massive = (0..nf).filter(|i| kept[*i] || kept[nf + i]);
        let massive: Vec<usize> = massive.collect();
        let relaxing = || (2 * nf..kept.len()).filter(|i| kept[*i]);
        let velocities = massive.iter().map(|i| nf + i);
        let states: Vec<usize> = massive
            .iter()
            .copied()
            .chain(velocities)
            .chain(relaxing())
            .collect();
        // The stiffness has no rows for velocities.
        let held: Vec<usize> = massive
            .iter()
            .copied()
            .chain(relaxing().map(|i| i - nf))
            .collect();
        let all: Vec<usize> = (0..self.initial.columns()).collect();
        let coordinates = &all[..self.x.rows()];
        EnclosedFirstOrder {
            a: self.a.part(&states, &states),
            b: self.b.part(&states, coordinates),
            x: self.x.part(coordinates, &states),
            d: self.d.clone(),
            initial: self.initial.part(&states, &all),
            mass: self.mass.part(&massive, &massive),
            stiffness: self.stiffness.part(&held, &held),
            massive: massive.iter().map(|i| self.massive[*i]).collect(),
        }
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

impl<T: Real> Dense for BallMatrix<T> {
    fn zeros(rows: usize, columns: usize) -> Self {
        BallMatrix::zeros(rows, columns)
    }

    fn size(&self) -> [usize; 2] {
        [self.rows(), self.columns()]
    }

    fn add(&mut self, i: usize, j: usize, term: f64) {
        BallMatrix::add(self, i, j, T::from(term), Magnitude::ZERO);
    }

    fn copy(&mut self, to: [usize; 2], from: &Self, at: [usize; 2]) {
        self.set(
            to[0],
            to[1],
            from.middle(at[0], at[1]),
            from.radius(at[0], at[1]),
        );
    }

    fn times(&self, other: &Self) -> Self {
        BallMatrix::times(self, other)
    }

    fn minus(&self, other: &Self) -> Self {
        self.plus(&other.clone().negated())
    }

    fn solve(&self, right: &Self) -> Option<Self> {
        BallMatrix::solve(self, right)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::first_order::FirstOrder;
    use crate::model::{GROUND, MatrixKind};
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

    /// Gyroscopic and circulatory terms, each from its own formula: A = −M⁻¹(K, C), where no coordinate is without mass.
    #[test]
    fn matrices_without_symmetry_stand_as_they_are() {
        let (damping, stiffness) = ([[1.0, 3.0], [-5.0, 2.0]], [[7.0, -1.0], [2.0, 9.0]]);
        let mass = [2.0, 4.0];
        let matrix = |rows: [[f64; 2]; 2]| faer::Mat::from_fn(2, 2, |i, j| rows[i][j]);
        let system = System::builder()
            .mass("a", mass[0])
            .mass("b", mass[1])
            .matrix(MatrixKind::Damping, matrix(damping).as_ref())
            .matrix(MatrixKind::Stiffness, matrix(stiffness).as_ref())
            .build()
            .expect("it is regular");
        let precise = EnclosedFirstOrder::<DoubleDouble>::of(&system).expect("regular");
        let plain = FirstOrder::of(&system).expect("regular");
        for i in 0..2 {
            for j in 0..2 {
                for (column, entry) in [(j, stiffness[i][j]), (2 + j, damping[i][j])] {
                    let expected = -entry / mass[i];
                    assert_eq!(plain.a()[(2 + i, column)], expected);
                    assert_eq!(precise.a().middle(2 + i, column).to_f64(), expected);
                }
            }
        }
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
