//! What some inputs make of one output: z′ = A z + Σ b u, y = c z + Σ Lₖ u⁽ᵏ⁾.
//!
//! Derivatives and integrals of the inputs and of what is read are taken out of the transfer function by
//! s(s − A)⁻¹ = A(s − A)⁻¹ + 1 and s⁻¹(s − A)⁻¹ = A⁻¹(s − A)⁻¹ − A⁻¹s⁻¹.

use eigentone_digits::{BallMatrix, Lu, Real};
use eigentone_modes::{EnclosedFirstOrder, FirstOrder};
use faer::{Mat, MatRef};

/// Powers of s, from the least.
const LEAST: i32 = -2;
const POWERS: usize = 7;

/// Forces on the coordinates, by the power of s that they are multiplied with.
pub(crate) type Acts = Vec<(i32, Vec<f64>)>;

/// Coordinates with factors, by the power of s that they are multiplied with.
pub(crate) type Reads = Vec<(i32, Vec<(usize, f64)>)>;

/// z′ = A z + B f, x = X z + D f, as in [`FirstOrder`].
pub(crate) struct Equations<T> {
    a: Mat<T>,
    b: Mat<T>,
    x: Mat<T>,
    d: Option<Mat<T>>,
    massive: usize,
}

impl Equations<f64> {
    pub(crate) fn of(form: &FirstOrder) -> Equations<f64> {
        Equations {
            a: form.a().to_owned(),
            b: form.b().to_owned(),
            x: form.x().to_owned(),
            d: form.d().map(|d| d.to_owned()),
            massive: form.massive().len(),
        }
    }
}

impl<T: Real> Equations<T> {
    /// From all digits of the elements.
    pub(crate) fn precise(form: &EnclosedFirstOrder<T>) -> Equations<T> {
        let middles =
            |of: &BallMatrix<T>| Mat::from_fn(of.rows(), of.columns(), |i, j| of.middle(i, j));
        Equations {
            a: middles(form.a()),
            b: middles(form.b()),
            x: middles(form.x()),
            d: Some(middles(form.d())),
            massive: form.massive().len(),
        }
    }
}

#[derive(Clone, Debug)]
pub(crate) struct StateForm<T> {
    pub(crate) a: Mat<T>,
    /// Which states are rates of others.
    pub(crate) rates: Vec<bool>,
    /// b of each input.
    pub(crate) b: Vec<Vec<T>>,
    pub(crate) c: Vec<T>,
    /// Lₖ of each input, k = −2 … 4.
    direct: Vec<[T; POWERS]>,
}

impl<T: Real> StateForm<T> {
    /// `None` where integrals are asked for, and A is singular in doubles.
    pub(crate) fn of(form: Equations<T>, inputs: &[Acts], reads: &Reads) -> Option<StateForm<T>> {
        /// Each brings as many digits as doubles have beyond those that A costs.
        const REFINEMENTS: usize = 6;
        let (a, states) = (form.a.as_ref(), form.a.nrows());
        let integrates = inputs.iter().flatten().any(|(power, _)| *power < 0);
        let rounded = || Mat::from_fn(states, states, |i, j| a[(i, j)].to_f64());
        let inverse = match integrates {
            true => Some(Lu::regular(rounded().as_ref())?),
            false => None,
        };
        let solves = match T::UNIT_LOG2 < f64::UNIT_LOG2 {
            true => REFINEMENTS,
            false => 1,
        };
        let back = |state: Vec<T>| -> Vec<T> {
            let Some(inverse) = &inverse else {
                return state;
            };
            let (mut left, mut solved) = (state.clone(), vec![T::ZERO; states]);
            for _ in 0..solves {
                let mut right = Mat::from_fn(states, 1, |i, _| left[i].to_f64());
                inverse.solve_in_place(right.as_mut());
                for (i, sum) in solved.iter_mut().enumerate() {
                    *sum = *sum + T::from(right[(i, 0)]);
                }
                let used = times(a, &solved);
                let rest = state.iter().zip(used).map(|(state, used)| *state - used);
                left = rest.collect();
            }
            solved
        };
        let rows: Vec<(i32, Vec<T>)> = reads
            .iter()
            .map(|(power, parts)| {
                let entry = |j: usize| {
                    let terms = parts.iter().map(|(i, by)| form.x[(*i, j)].mul_f64(*by));
                    sum(terms)
                };
                (*power, (0..states).map(entry).collect())
            })
            .collect();
        let mut c = vec![T::ZERO; states];
        for (power, row) in &rows {
            let last = (0..*power).fold(row.clone(), |row, _| times(a.transpose(), &row));
            add(&mut c, &last);
        }
        let (mut b, mut direct) = (Vec::new(), Vec::new());
        for acts in inputs {
            let (mut total, mut passed) = (vec![T::ZERO; states], [T::ZERO; POWERS]);
            for (turns, force) in acts {
                let force: Vec<T> = force.iter().map(|force| T::from(*force)).collect();
                let start = times(form.b.as_ref(), &force);
                for ((power, row), (_, parts)) in rows.iter().zip(reads) {
                    let order = power + turns;
                    let mut state = start.clone();
                    for i in 0..order {
                        pass(&mut passed, order - 1 - i, dot(row, &state));
                        state = times(a, &state);
                    }
                    for i in order..0 {
                        state = back(state);
                        pass(&mut passed, i, -dot(row, &state));
                    }
                    if let Some(d) = &form.d {
                        let moved = times(d.as_ref(), &force);
                        let read = sum(parts.iter().map(|(i, by)| moved[*i].mul_f64(*by)));
                        pass(&mut passed, order, read);
                    }
                }
                let forth = (0..*turns).fold(start, |state, _| times(a, &state));
                let end = (*turns..0).fold(forth, |state, _| back(state));
                add(&mut total, &end);
            }
            b.push(total);
            direct.push(passed);
        }
        let massive = form.massive;
        let rates = (0..states).map(|i| (massive..2 * massive).contains(&i));
        Some(StateForm {
            rates: rates.collect(),
            a: form.a,
            b,
            c,
            direct,
        })
    }

    /// Lₖ of an input.
    pub(crate) fn direct(&self, input: usize, power: i32) -> T {
        self.direct[input][(power - LEAST) as usize]
    }

    /// Adds to it what passes by the states.
    pub(crate) fn pass(&mut self, input: usize, power: i32, value: f64) {
        pass(&mut self.direct[input], power, T::from(value));
    }

    /// Its output through x″ = back·(x, x′) + push·y, as read·(x, x′) + bend·y: two more states, of which the second is a rate.
    pub(crate) fn followed(
        &self,
        back: [f64; 2],
        push: f64,
        read: [f64; 2],
        bend: f64,
    ) -> StateForm<T> {
        let n = self.c.len();
        let a = Mat::from_fn(n + 2, n + 2, |i, j| match (i, j) {
            _ if i < n && j < n => self.a[(i, j)],
            _ if i == n && j == n + 1 => T::ONE,
            _ if i == n + 1 && j < n => self.c[j].mul_f64(push),
            _ if i == n + 1 => T::from(back[j - n]),
            _ => T::ZERO,
        });
        let fed = |(b, direct): (&Vec<T>, &[T; POWERS])| {
            let passed = direct[-LEAST as usize];
            [b.as_slice(), &[T::ZERO, passed.mul_f64(push)]].concat()
        };
        let kept = |direct: &[T; POWERS]| direct.map(|passed| passed.mul_f64(bend));
        let own = self.c.iter().map(|c| c.mul_f64(bend));
        StateForm {
            a,
            rates: [self.rates.as_slice(), &[false, true]].concat(),
            b: self.b.iter().zip(&self.direct).map(fed).collect(),
            c: own.chain(read.map(T::from)).collect(),
            direct: self.direct.iter().map(kept).collect(),
        }
    }
}

/// The powers of s, from the least.
pub(crate) fn powers() -> std::ops::Range<i32> {
    LEAST..LEAST + POWERS as i32
}

fn pass<T: Real>(direct: &mut [T; POWERS], power: i32, value: T) {
    let sum = &mut direct[(power - LEAST) as usize];
    *sum = *sum + value;
}

fn sum<T: Real>(terms: impl Iterator<Item = T>) -> T {
    terms.fold(T::ZERO, |sum, term| sum + term)
}

fn add<T: Real>(sums: &mut [T], terms: &[T]) {
    T::add_multiple(sums, T::ONE, terms);
}

fn times<T: Real>(matrix: MatRef<'_, T>, vector: &[T]) -> Vec<T> {
    let row = |i: usize| sum((0..vector.len()).map(|j| matrix[(i, j)] * vector[j]));
    (0..matrix.nrows()).map(row).collect()
}

fn dot<T: Real>(a: &[T], b: &[T]) -> T {
    sum(a.iter().zip(b).map(|(a, b)| *a * *b))
}
