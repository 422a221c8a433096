//! The equation of motion solved for the acceleration, and the forces that act in one piece.

use eigentone_digits::Lu;
use eigentone_modes::System;
use eigentone_response::Problem;
use faer::Mat;

use super::number::Number;

/// x″ = M⁻¹(f − C x′ − K x), with the zeros of M⁻¹K, M⁻¹C and M⁻¹ left out.
pub(crate) struct EquationOfMotion {
    coupling: Vec<Vec<Coupling>>,
    /// Column j of M⁻¹: what a unit force on coordinate j accelerates.
    mobility: Vec<Vec<(usize, f64)>>,
}

/// How far one coordinate pulls another.
struct Coupling {
    coordinate: usize,
    stiffness: f64,
    damping: f64,
}

impl EquationOfMotion {
    /// Solves the equation, or says why it cannot be solved for the acceleration.
    pub(crate) fn of(system: &System) -> Result<EquationOfMotion, String> {
        let n = system.len();
        let mass = system.mass_matrix();
        let (stiffness, damping) = (system.stiffness_matrix(), system.damping_matrix());
        let empty = |i: usize| (0..n).all(|j| mass[(i, j)] == 0.0);
        if let Some(i) = (0..n).find(|i| empty(*i)) {
            return Err(format!("{:?} has no mass", system.names()[i]));
        }
        let diagonal = (0..n).all(|i| (0..n).all(|j| i == j || mass[(i, j)] == 0.0));
        let (inverse, stiffness, damping) = if diagonal {
            let divide =
                |matrix: Mat<f64>| Mat::from_fn(n, n, |i, j| matrix[(i, j)] / mass[(i, i)]);
            let inverse = divide(Mat::identity(n, n));
            (inverse, divide(stiffness), divide(damping))
        } else {
            let inverse = Lu::of(mass.as_ref()).inverse();
            // The condition of Bauer & Skeel, which does not see how the rows are scaled.
            let condition = largest_row_sum(&(absolute(&inverse) * absolute(&mass)));
            // NaN, from a zero pivot, is singular too.
            let regular = condition < 1.0 / f64::EPSILON;
            if !regular {
                return Err("its mass matrix is singular to working precision".to_owned());
            }
            let (stiffness, damping) = (&inverse * stiffness, &inverse * damping);
            (inverse, stiffness, damping)
        };
        let coupling = |i: usize| {
            let all = (0..n).map(|j| Coupling {
                coordinate: j,
                stiffness: stiffness[(i, j)],
                damping: damping[(i, j)],
            });
            all.filter(|one| one.stiffness != 0.0 || one.damping != 0.0)
                .collect()
        };
        let mobility = |j: usize| {
            let all = (0..n).map(|i| (i, inverse[(i, j)]));
            all.filter(|(_, value)| *value != 0.0).collect()
        };
        Ok(EquationOfMotion {
            coupling: (0..n).map(coupling).collect(),
            mobility: (0..n).map(mobility).collect(),
        })
    }

    /// The number n of coordinates.
    pub(crate) fn len(&self) -> usize {
        self.coupling.len()
    }

    /// x″ for the state [x; x′] (2n) under forces `elapsed` s after their piece began.
    pub(crate) fn acceleration(
        &self,
        state: &[f64],
        forces: &Forces<'_>,
        elapsed: f64,
        acceleration: &mut [f64],
    ) {
        self.derivative(0, state, forces, elapsed, acceleration);
    }

    /// The `order`-th time derivative of x″, from that of the state [x; x′].
    pub(crate) fn derivative(
        &self,
        order: u8,
        state: &[f64],
        forces: &Forces<'_>,
        elapsed: f64,
        acceleration: &mut [f64],
    ) {
        self.pull(state, acceleration);
        let push = |coordinate: usize, force: f64| self.push(coordinate, force, acceleration);
        let time = forces.start() + elapsed;
        forces.problem.forces(forces.piece, time, order, push);
    }

    /// Adds what a force on a coordinate accelerates.
    pub(crate) fn push(&self, coordinate: usize, force: f64, acceleration: &mut [f64]) {
        for (i, mobility) in &self.mobility[coordinate] {
            acceleration[*i] += mobility * force;
        }
    }

    /// −M⁻¹(C x′ + K x) for the state [x; x′].
    pub(crate) fn pull(&self, state: &[f64], acceleration: &mut [f64]) {
        let (displacement, velocity) = state.split_at(self.len());
        for (sum, coupling) in acceleration.iter_mut().zip(&self.coupling) {
            *sum = -coupling.iter().fold(0.0, |pull, one| {
                pull + one.stiffness * displacement[one.coordinate]
                    + one.damping * velocity[one.coordinate]
            });
        }
    }

    /// Adds the velocities that the impulses at the start of a piece give to [x; x′].
    pub(crate) fn apply_impulses(&self, state: &mut [f64], forces: &Forces<'_>) {
        let velocity = &mut state[self.len()..];
        for (coordinate, momentum) in forces.problem.momenta(forces.piece) {
            for (i, mobility) in &self.mobility[coordinate] {
                velocity[*i] += mobility * momentum;
            }
        }
    }

    /// A bound of all |λ| in rad/s: |λ| ≤ ‖M⁻¹C‖ + √‖M⁻¹K‖, in the largest row sum.
    pub(crate) fn fastest(&self) -> f64 {
        let norm = |entry: fn(&Coupling) -> f64| {
            let sums = self.coupling.iter();
            sums.map(|row| row.iter().map(|one| entry(one).abs()).sum())
                .fold(0.0, f64::max)
        };
        norm(|one| one.damping) + norm(|one| one.stiffness).sqrt()
    }

    /// A bound of the acceleration in m/s² that the forces of a piece give by themselves to any
    /// coordinate at `elapsed` s.
    pub(crate) fn largest_push(&self, forces: &Forces<'_>, elapsed: f64) -> f64 {
        let mut total = vec![0.0; self.len()];
        let mut add = |coordinate: usize, force: f64| {
            for (i, mobility) in &self.mobility[coordinate] {
                total[*i] += (mobility * force).abs();
            }
        };
        let timeline = forces.problem.timeline();
        for straight in timeline.pieces()[forces.piece].straight() {
            if straight.coordinate < self.len() {
                let grown = straight.slope.abs() * elapsed;
                add(straight.coordinate, straight.value.abs() + grown);
            }
        }
        for (coordinate, harmonic) in timeline.harmonics() {
            if *coordinate < self.len() {
                add(*coordinate, harmonic.amplitude);
            }
        }
        // What moves supports has no bound of its own: three moments stand for all.
        for part in [0.0, 0.5, 1.0] {
            let time = forces.start() + part * elapsed;
            forces.problem.motion_forces(forces.piece, time, &mut add);
        }
        total.into_iter().fold(0.0, f64::max)
    }

    /// M⁻¹K x for displacements x.
    pub(super) fn stiffness_times<T: Number>(&self, x: &[T], product: &mut [T]) {
        for (sum, coupling) in product.iter_mut().zip(&self.coupling) {
            let pulls = coupling.iter().map(|one| x[one.coordinate] * one.stiffness);
            *sum = pulls.fold(T::zero_impl(), |sum, pull| sum + pull);
        }
    }

    /// I + α M⁻¹C + β M⁻¹K, inverted (n × n).
    pub(super) fn implicit_inverse<T: Number>(&self, alpha: T, beta: T) -> Mat<T> {
        let n = self.len();
        let mut matrix = Mat::<T>::identity(n, n);
        for (i, coupling) in self.coupling.iter().enumerate() {
            for one in coupling {
                let entry = &mut matrix[(i, one.coordinate)];
                *entry += alpha * one.damping + beta * one.stiffness;
            }
        }
        Lu::of(matrix.as_ref()).inverse()
    }
}

fn absolute(matrix: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)].abs())
}

/// The largest sum of a row of entries ≥ 0; NaN if there is one.
fn largest_row_sum(matrix: &Mat<f64>) -> f64 {
    let sums = (0..matrix.nrows()).map(|i| matrix.row(i).iter().sum::<f64>());
    sums.fold(
        0.0,
        |largest: f64, sum| {
            if sum <= largest { largest } else { sum }
        },
    )
}

/// The forces within one piece of a timeline.
pub(crate) struct Forces<'a> {
    pub(crate) problem: &'a Problem<'a>,
    pub(crate) piece: usize,
}

impl Forces<'_> {
    /// When the piece begins, in s.
    pub(crate) fn start(&self) -> f64 {
        self.problem.timeline().pieces()[self.piece].start()
    }
}
