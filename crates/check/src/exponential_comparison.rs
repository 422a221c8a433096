//! Every matrix exponential on the state matrix of the same system: error, run time and products.

use eigentone_modes::{FirstOrder, System, balance};
use eigentone_response::{
    ByCertifiedExponential, Exponential, Pade13, Problem, ResponseError, ResponseMethod,
    SecondOrder, State, Taylor, TimeGrid,
};
use faer::{Mat, MatRef};

use crate::run_time::RunTime;
use crate::work_precision::Progress;

/// Exponentials of e^{Ah}, A being the balanced state matrix of a system and h one step of the grid.
#[derive(Clone, Debug)]
pub struct ExponentialComparison {
    /// The order of A.
    pub order: usize,
    /// h, in s.
    pub step: f64,
    /// The largest column sum of |A|h.
    pub norm: f64,
    /// One row for each method.
    pub rows: Vec<ExponentialRow>,
}

/// One method.
#[derive(Clone, Debug)]
pub struct ExponentialRow {
    /// The method's name.
    pub method: &'static str,
    /// The error in the 1-norm, relative to the norm of the exponential; infinite where the method
    /// refuses.
    pub error: f64,
    /// How long it takes.
    pub time: RunTime,
    /// How many products of matrices of the order of A it takes, squarings included.
    pub products: f64,
}

/// Every method in doubles.
const METHODS: [&dyn Exponential; 3] = [&SecondOrder, &Taylor, &Pade13];

impl ExponentialComparison {
    /// Compares the exponentials over one step of the grid with the motions from unit states that the
    /// certified exponential proves; `progress` is reported before each.
    ///
    /// # Errors
    /// [`ResponseError::NotApplicable`] where the system has no first-order form or is too large for
    /// proofs, and what the certified exponential reports.
    pub fn measure(
        system: &System,
        step: f64,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<ExponentialComparison, ResponseError> {
        let form = FirstOrder::of(system).map_err(|error| ResponseError::NotApplicable {
            method: "exponential",
            reason: error.to_string(),
        })?;
        let n = form.states();
        let balanced = balance(form.a());
        let a = Mat::from_fn(n, n, |i, j| balanced.matrix[(i, j)] * step);
        let columns = Columns::of(system, &form, &balanced.scale, step)?;
        let rows = METHODS.iter().enumerate().map(|(done, method)| {
            progress(Progress {
                done,
                total: METHODS.len(),
                method: method.name(),
                knob: None,
            });
            let nothing = || (Mat::from_fn(n, n, |_, _| f64::NAN), 0.0);
            let run = || {
                let found = method.counted(a.as_ref());
                Ok::<_, ResponseError>(found.unwrap_or_else(|_| nothing()))
            };
            let ((found, products), time) = RunTime::of(run)?;
            Ok(ExponentialRow {
                method: method.name(),
                error: columns.error(found.as_ref()),
                time,
                products,
            })
        });
        Ok(ExponentialComparison {
            order: n,
            step,
            norm: a.col_iter().map(|c| c.norm_l1()).fold(0.0, f64::max),
            rows: rows.collect::<Result<_, ResponseError>>()?,
        })
    }
}

/// Unit states at 0 and what they become, in balanced coordinates.
struct Columns {
    start: Mat<f64>,
    end: Mat<f64>,
}

impl Columns {
    fn of(
        system: &System,
        form: &FirstOrder,
        scale: &[f64],
        step: f64,
    ) -> Result<Columns, ResponseError> {
        let grid = TimeGrid::new(step, step)?;
        let names = system.names();
        let displaced = names
            .iter()
            .map(|name| State::at_rest().displace(name.clone(), 1.0));
        let pushed = form
            .massive()
            .iter()
            .map(|i| State::at_rest().push(names[*i].clone(), 1.0));
        let (mut starts, mut ends) = (Vec::new(), Vec::new());
        for state in displaced.chain(pushed) {
            let problem = Problem::new(system, &state, Vec::new(), grid)?.at(&[1])?;
            let balanced = |x: &[f64], v: &[f64]| -> Vec<f64> {
                let z = form.state(x, v);
                z.iter().zip(scale).map(|(z, d)| z / d).collect()
            };
            let z = balanced(problem.initial_displacement(), problem.initial_velocity());
            let size: f64 = z.iter().map(|entry| entry.abs()).sum();
            if size == 0.0 {
                continue;
            }
            let motion = ByCertifiedExponential.run(&problem)?;
            let of =
                |values: MatRef<'_, f64>| -> Vec<f64> { values.col(0).iter().copied().collect() };
            let end = balanced(&of(motion.displacement()), &of(motion.velocity()));
            let unit = |z: Vec<f64>| -> Vec<f64> { z.iter().map(|entry| entry / size).collect() };
            starts.push(unit(z));
            ends.push(unit(end));
        }
        let matrix =
            |columns: &[Vec<f64>]| Mat::from_fn(form.states(), columns.len(), |i, j| columns[j][i]);
        Ok(Columns {
            start: matrix(&starts),
            end: matrix(&ends),
        })
    }

    fn error(&self, exponential: MatRef<'_, f64>) -> f64 {
        let off = exponential * &self.start - &self.end;
        let norm = |matrix: &Mat<f64>| {
            let sums = matrix.col_iter().map(|column| column.norm_l1());
            sums.fold(
                0.0,
                |top: f64, sum| if sum > top || sum.is_nan() { sum } else { top },
            )
        };
        let error = norm(&off) / norm(&self.end);
        if error.is_nan() { f64::INFINITY } else { error }
    }
}
