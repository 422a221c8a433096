//! What some inputs make of one output, in doubles: z′ = A z + Σ b u, y = c z + Σ Lₖ u⁽ᵏ⁾.
//!
//! Derivatives and integrals of the inputs and of what is read are taken out of the transfer function by
//! s(s − A)⁻¹ = A(s − A)⁻¹ + 1 and s⁻¹(s − A)⁻¹ = A⁻¹(s − A)⁻¹ − A⁻¹s⁻¹.

use eigentone_modes::FirstOrder;
use faer::linalg::solvers::{PartialPivLu, Solve};
use faer::{Mat, MatRef};

/// Powers of s, from the least.
const LEAST: i32 = -2;
const POWERS: usize = 7;

/// Forces on the coordinates, by the power of s that they are multiplied with.
pub(crate) type Acts = Vec<(i32, Vec<f64>)>;

/// Coordinates with factors, by the power of s that they are multiplied with.
pub(crate) type Reads = Vec<(i32, Vec<(usize, f64)>)>;

#[derive(Clone, Debug)]
pub(crate) struct StateForm {
    pub(crate) a: Mat<f64>,
    /// Which states are rates of others.
    pub(crate) rates: Vec<bool>,
    /// b of each input.
    pub(crate) b: Vec<Vec<f64>>,
    pub(crate) c: Vec<f64>,
    /// Lₖ of each input, k = −2 … 4.
    direct: Vec<[f64; POWERS]>,
}

impl StateForm {
    /// `None` where integrals are asked for, and A is singular in doubles.
    pub(crate) fn of(form: &FirstOrder, inputs: &[Acts], reads: &Reads) -> Option<StateForm> {
        let (a, states) = (form.a(), form.states());
        let integrates = inputs.iter().flatten().any(|(power, _)| *power < 0);
        let inverse = integrates.then(|| a.partial_piv_lu());
        let inverse = match inverse {
            Some(inverse) => Some(regular(inverse)?),
            None => None,
        };
        let back = |state: Vec<f64>| -> Vec<f64> {
            let Some(inverse) = &inverse else {
                return state;
            };
            let mut right = Mat::from_fn(states, 1, |i, _| state[i]);
            inverse.solve_in_place(&mut right);
            right.col(0).iter().copied().collect()
        };
        let rows: Vec<(i32, Vec<f64>)> = reads
            .iter()
            .map(|(power, parts)| {
                let entry = |j: usize| parts.iter().map(|(i, by)| by * form.x()[(*i, j)]).sum();
                (*power, (0..states).map(entry).collect())
            })
            .collect();
        let mut c = vec![0.0; states];
        for (power, row) in &rows {
            let last = (0..*power).fold(row.clone(), |row, _| times(a.transpose(), &row));
            c.iter_mut()
                .zip(last)
                .for_each(|(sum, entry)| *sum += entry);
        }
        let (mut b, mut direct) = (Vec::new(), Vec::new());
        for acts in inputs {
            let (mut sum, mut passed) = (vec![0.0; states], [0.0; POWERS]);
            for (turns, force) in acts {
                let start = times(form.b(), force);
                for ((power, row), (_, parts)) in rows.iter().zip(reads) {
                    let total = power + turns;
                    let mut state = start.clone();
                    for i in 0..total {
                        *at(&mut passed, total - 1 - i) += dot(row, &state);
                        state = times(a, &state);
                    }
                    for i in total..0 {
                        state = back(state);
                        *at(&mut passed, i) -= dot(row, &state);
                    }
                    if let Some(d) = form.d() {
                        let moved = times(d, force);
                        let read: f64 = parts.iter().map(|(i, by)| by * moved[*i]).sum();
                        *at(&mut passed, total) += read;
                    }
                }
                let forth = (0..*turns).fold(start, |state, _| times(a, &state));
                let end = (*turns..0).fold(forth, |state, _| back(state));
                sum.iter_mut()
                    .zip(end)
                    .for_each(|(sum, entry)| *sum += entry);
            }
            b.push(sum);
            direct.push(passed);
        }
        let massive = form.massive().len();
        let rates = (0..states).map(|i| (massive..2 * massive).contains(&i));
        let (rates, a) = (rates.collect(), a.to_owned());
        Some(StateForm {
            a,
            rates,
            b,
            c,
            direct,
        })
    }

    /// Lₖ of an input.
    pub(crate) fn direct(&self, input: usize, power: i32) -> f64 {
        self.direct[input][(power - LEAST) as usize]
    }

    /// Adds to it what passes by the states.
    pub(crate) fn pass(&mut self, input: usize, power: i32, value: f64) {
        *at(&mut self.direct[input], power) += value;
    }

    /// Its output through x″ = back·(x, x′) + push·y, as read·(x, x′) + bend·y: two more states, of which the second is a rate.
    pub(crate) fn followed(
        &self,
        back: [f64; 2],
        push: f64,
        read: [f64; 2],
        bend: f64,
    ) -> StateForm {
        let n = self.c.len();
        let mut a = Mat::<f64>::zeros(n + 2, n + 2);
        a.submatrix_mut(0, 0, n, n).copy_from(&self.a);
        a[(n, n + 1)] = 1.0;
        (a[(n + 1, n)], a[(n + 1, n + 1)]) = (back[0], back[1]);
        (0..n).for_each(|j| a[(n + 1, j)] = push * self.c[j]);
        let fed = |(b, direct): (&Vec<f64>, &[f64; POWERS])| {
            let passed = direct[-LEAST as usize];
            [b.as_slice(), &[0.0, push * passed]].concat()
        };
        let kept = |direct: &[f64; POWERS]| direct.map(|passed| bend * passed);
        StateForm {
            a,
            rates: [self.rates.as_slice(), &[false, true]].concat(),
            b: self.b.iter().zip(&self.direct).map(fed).collect(),
            c: self.c.iter().map(|c| bend * c).chain(read).collect(),
            direct: self.direct.iter().map(kept).collect(),
        }
    }

    /// The powers of s, from the least.
    pub(crate) fn powers() -> std::ops::Range<i32> {
        LEAST..LEAST + POWERS as i32
    }
}

/// The factor of a matrix that is regular in doubles.
pub(crate) fn regular(factor: PartialPivLu<f64>) -> Option<PartialPivLu<f64>> {
    let u = factor.U();
    let sound = |i: usize| u[(i, i)] != 0.0 && u[(i, i)].is_finite();
    (0..u.nrows()).all(sound).then_some(factor)
}

fn at(direct: &mut [f64; POWERS], power: i32) -> &mut f64 {
    &mut direct[(power - LEAST) as usize]
}

fn times(matrix: MatRef<'_, f64>, vector: &[f64]) -> Vec<f64> {
    let row = |i: usize| (0..vector.len()).map(|j| matrix[(i, j)] * vector[j]).sum();
    (0..matrix.nrows()).map(row).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
