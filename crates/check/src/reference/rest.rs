//! Which coordinates do not move at all: those that the loads and the initial state never reach.
//!
//! With z′ = A z and x = X z, row i of X e^(A t) z is 0 at all times if and only if that row meets
//! A^k z in 0 for every k below the order of A (Cayley and Hamilton). All of these are exact
//! numbers.

use eigentone_response::Problem;
use num_rational::BigRational;
use num_traits::Zero;

use super::Reference;
use super::driven_form::DrivenForm;
use super::error::ReferenceError;
use super::events::grid_time;
use super::pi_polynomial::{PiMatrix, PiPolynomial};

impl Reference {
    /// For each coordinate, at how many of the first instants of the problem's grid its displacement and
    /// its velocity are proved to be 0. A coordinate that no load and no initial state reaches has
    /// them all; one that only later loads reach has those before.
    ///
    /// # Errors
    /// Those of [`response`](Reference::response).
    pub fn at_rest(&self, problem: &Problem<'_>) -> Result<Vec<[u64; 2]>, ReferenceError> {
        let form = DrivenForm::of(problem)?;
        let order = form.motion.nrows();
        let products = order as f64 + form.jumps.len() as f64;
        self.afford(problem.system().len() as f64 * (order as f64).powi(2) * products)?;
        let grid = problem.grid();
        let instants = grid.last() + 1;
        // What moves from 0 on, then what events add, each as columns.
        let mut causes = vec![(BigRational::zero(), form.start_span())];
        for (time, jumps) in &form.jumps {
            let mut column = PiMatrix::zeros(order, 1);
            for (component, jump) in jumps {
                *column.at_mut(*component, 0) += jump.shifted(-form.scale[*component]);
            }
            causes.push((time.clone(), column));
        }
        causes.retain(|(_, cause)| !cause.is_zero());
        let reached = |row: usize| {
            let mut reach = form
                .displacement
                .block(&[row], &(0..order).collect::<Vec<_>>());
            for j in 0..order {
                let entry = reach.at(0, j).shifted(form.scale[j]);
                *reach.at_mut(0, j) = entry;
            }
            // Powers are long numbers: most causes move something by a low one.
            let next = reach.times(&form.motion);
            let mut rows = vec![reach, next];
            let moves = |row: &PiMatrix, cause| !row.times(cause).is_zero();
            let first = causes.iter().find(|(_, cause)| {
                // One more than the order, so that there is a velocity.
                (0..=order).any(|k| {
                    if k == rows.len() {
                        let next = rows[k - 1].times(&form.motion);
                        rows.push(next);
                    }
                    moves(&rows[k], cause)
                })
            });
            // What it makes move at once, and what only later.
            first.map(|(time, cause)| (time, [0, 1].map(|k| moves(&rows[k], cause))))
        };
        let before = |time: &BigRational| {
            let (mut from, mut to) = (0, instants);
            while from < to {
                let middle = u64::midpoint(from, to);
                match grid_time(grid, middle) < *time {
                    true => from = middle + 1,
                    false => to = middle,
                }
            }
            from
        };
        let count = |row: usize| match reached(row) {
            None => [instants; 2],
            Some((time, at_once)) => {
                let from = before(time);
                let meets = from < instants && grid_time(grid, from) == *time;
                at_once.map(|at_once| from + u64::from(meets && !at_once))
            }
        };
        Ok((0..problem.system().len()).map(count).collect())
    }
}

impl DrivenForm {
    /// Columns, scaled as the states are, that span the state at t = 0 whatever the phases are.
    fn start_span(&self) -> PiMatrix {
        let order = self.motion.nrows();
        let phases: Vec<_> = self.phased().collect();
        let mut span = PiMatrix::zeros(order, 1 + phases.len());
        for (i, value) in self.given().iter().enumerate() {
            *span.at_mut(i, 0) = PiPolynomial::from(value.clone()).shifted(-self.scale[i]);
        }
        for (k, column) in phases.into_iter().enumerate() {
            for (state, value) in column {
                *span.at_mut(state, k + 1) += PiPolynomial::from(value).shifted(-self.scale[state]);
            }
        }
        span
    }
}

#[cfg(test)]
mod tests {
    use eigentone_modes::{GROUND, System};
    use eigentone_response::{Harmonic, Response, State, Step};

    use super::*;

    fn chain(middle: f64) -> System {
        let builder = System::builder()
            .mass("a", 1.0)
            .mass("b", middle)
            .mass("c", 1.0);
        let nodes = [GROUND, "a", "b", "c", GROUND];
        let springs = nodes.windows(2).fold(builder, |builder, ends| {
            builder
                .spring(ends[0], ends[1], 0.3)
                .damper(ends[0], ends[1], 0.1)
        });
        springs
            .mass("free", 1.0)
            .spring(GROUND, "free", 1.0)
            .build()
            .expect("a system")
    }

    #[test]
    fn what_mirrored_causes_leave_alone_is_proved_to_rest() {
        let system = chain(5.0);
        let asked = Response::of(&system)
            .from(State::at_rest().displace("a", 0.1).displace("c", -0.1))
            .load(
                "a",
                Harmonic {
                    amplitude: 2.0,
                    frequency: 0.7,
                    phase: 0.3,
                },
            )
            .load(
                "c",
                Harmonic {
                    amplitude: -2.0,
                    frequency: 0.7,
                    phase: 0.3,
                },
            );
        let reference = Reference::default();
        let problem = asked
            .clone()
            .every(0.5)
            .until(50.0)
            .problem()
            .expect("a problem");
        // Two loads of opposite sign are two causes, each of which moves the middle.
        let resting = reference.at_rest(&problem).expect("it is small");
        assert_eq!(resting, [[0, 1], [1, 1], [0, 1], [101, 101]]);
        let asked =
            Response::of(&system).from(State::at_rest().displace("a", 0.1).displace("c", -0.1));
        let asked = asked.load("free", Step::of(1.0).starting_at(10.0));
        let problem = asked.every(0.5).until(50.0).problem().expect("a problem");
        let resting = reference.at_rest(&problem).expect("it is small");
        assert_eq!(resting, [[0, 1], [101, 101], [0, 1], [21, 21]]);
    }
}
