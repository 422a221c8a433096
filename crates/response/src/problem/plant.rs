//! The system with what drives it: z′ = A z + B f with forces and the signals of all channels as inputs.

use eigentone_modes::FirstOrder;
use faer::{Mat, MatRef};

use super::moving::moving;
use super::question::Problem;

/// z′ = A z + B f, x = X z + D f. The states are those of the system, then the integrals of the channels' signals; the
/// inputs are the forces on the n coordinates, then for each channel its signal and the first two derivatives.
pub(crate) struct Plant {
    /// N × N.
    pub(crate) a: Mat<f64>,
    /// N × inputs.
    pub(crate) b: Mat<f64>,
    /// n × N.
    pub(crate) x: Mat<f64>,
    /// n × inputs; `None` where it is 0.
    pub(crate) d: Option<Mat<f64>>,
    /// Displacement of each support: by the states, and by the inputs.
    pub(crate) supports: [Mat<f64>; 2],
    /// How many states are integrals of signals.
    pub(crate) integrals: usize,
    /// By state of the system, whether anything moves it. What would become of the others is left out of A and B: where they
    /// are unstable, it need not be a double.
    pub(crate) moving: Vec<bool>,
}

impl Plant {
    pub(crate) fn of(problem: &Problem<'_>, form: &FirstOrder) -> Plant {
        let (n, own) = (problem.system().len(), form.states());
        let channels = problem.channels();
        let integrals = channels.iter().map(|channel| channel.integrals).sum();
        let (states, inputs) = (own + integrals, n + 3 * channels.len());
        let start = form.state(problem.initial_displacement(), problem.initial_velocity());
        let moving = moving(
            problem,
            start.iter().map(|entry| *entry != 0.0).collect(),
            |i, j| form.b()[(i, j)] != 0.0,
            |i, j| form.a()[(i, j)] != 0.0,
        );
        let mut a = Mat::<f64>::zeros(states, states);
        a.submatrix_mut(0, 0, own, own).copy_from(form.a());
        let mut b = Mat::<f64>::zeros(states, inputs);
        b.submatrix_mut(0, 0, own, n).copy_from(form.b());
        let mut x = Mat::<f64>::zeros(n, states);
        x.submatrix_mut(0, 0, n, own).copy_from(form.x());
        let mut d = form.d().map(|own| {
            let mut d = Mat::<f64>::zeros(n, inputs);
            d.submatrix_mut(0, 0, n, n).copy_from(own);
            d
        });
        let count = problem.system().supports().len();
        let mut supports = [Mat::zeros(count, states), Mat::zeros(count, inputs)];
        let mut state = own;
        for (at, channel) in channels.iter().enumerate() {
            let q = channel.integrals;
            // u⁽ᵏ⁾ is a state for k < q, and a derivative of the signal from there on.
            for (k, direction) in channel.directions.iter().enumerate() {
                let input = n + 3 * at + k.saturating_sub(q);
                let [pushed, moved] = form.driven(direction);
                for (i, push) in pushed.into_iter().enumerate() {
                    match k < q {
                        true => a[(i, state + k)] += push,
                        false => b[(i, input)] += push,
                    }
                }
                let Some(d) = &mut d else { continue };
                for (i, moved) in moved.into_iter().enumerate() {
                    match k < q {
                        true => x[(i, state + k)] += moved,
                        false => d[(i, input)] += moved,
                    }
                }
            }
            for k in 1..q {
                a[(state + k - 1, state + k)] = 1.0;
            }
            if q > 0 {
                b[(state + q - 1, n + 3 * at)] = 1.0;
            }
            if let Some(support) = channel.support {
                match q {
                    0 => supports[1][(support, n + 3 * at)] += 1.0,
                    _ => supports[0][(support, state)] += 1.0,
                }
            }
            state += q;
        }
        for i in (0..own).filter(|i| !moving[*i]) {
            a.row_mut(i).fill(0.0);
            a.col_mut(i).fill(0.0);
            b.row_mut(i).fill(0.0);
        }
        Plant {
            a,
            b,
            x,
            d,
            supports,
            integrals,
            moving,
        }
    }

    /// The same with what is integrated in units, powers of two, in which it does as much to the states as these to each
    /// other: exponentials are accurate in proportion to the largest of it.
    pub(crate) fn evened(mut self) -> Plant {
        let own = self.a.nrows() - self.integrals;
        let size = |column: usize| -> f64 { (0..own).map(|i| self.a[(i, column)].abs()).sum() };
        let rate = (0..own).map(size).fold(0.0, f64::max);
        let units: Vec<f64> = (own..own + self.integrals)
            .map(|state| {
                let exponent = (rate / size(state)).log2().round();
                let fits = exponent.abs() < 500.0;
                f64::exp2(if fits { exponent } else { 0.0 })
            })
            .collect();
        for (state, unit) in (own..).zip(units) {
            for matrix in [&mut self.a, &mut self.x, &mut self.supports[0]] {
                matrix
                    .col_mut(state)
                    .iter_mut()
                    .for_each(|entry| *entry *= unit);
            }
            for matrix in [&mut self.a, &mut self.b] {
                matrix
                    .row_mut(state)
                    .iter_mut()
                    .for_each(|entry| *entry /= unit);
            }
        }
        self
    }

    /// The columns of B for some inputs.
    pub(crate) fn columns(b: MatRef<'_, f64>, inputs: &[usize]) -> Mat<f64> {
        Mat::from_fn(b.nrows(), inputs.len(), |i, j| b[(i, inputs[j])])
    }
}
