//! A, B, C and D, each entry enclosed.
//!
//! The motions u of supports act by −(K_s u + C_s u′ + M_s u″), so that z′ = A z + B₀u + B₁u′ + B₂u″ at first. With
//! ζ = z − P₁u − P₂u′, P₂ = B₂ and P₁ = B₁ + A B₂, it is ζ′ = A ζ + (B₀ + A P₁) u: what jumps of u make of the state at once
//! is taken out of it, and no derivative is left.

use eigentone_digits::{BallMatrix, Magnitude, Real};
use eigentone_modes::EnclosedFirstOrder;

use super::asked::Asked;
use super::error::StateSpaceError;
use crate::enclosed::add_multiple;

#[derive(Clone)]
pub(super) struct Realisation<T> {
    pub(super) a: BallMatrix<T>,
    pub(super) b: BallMatrix<T>,
    pub(super) c: BallMatrix<T>,
    pub(super) d: BallMatrix<T>,
    /// What outputs follow of the first derivative of the inputs, and of higher ones.
    pub(super) of_derivatives: Vec<BallMatrix<T>>,
    /// The first states are those of the system itself, in its own form.
    pub(super) form: EnclosedFirstOrder<T>,
    pub(super) states: Vec<String>,
}

/// y = L ζ + Σ Gₖ u⁽ᵏ⁾.
struct Reading<T> {
    of_states: BallMatrix<T>,
    of_inputs: Vec<BallMatrix<T>>,
}

impl<T: Real> Reading<T> {
    fn derivative(&self, a: &BallMatrix<T>, b: &BallMatrix<T>) -> Reading<T> {
        let mut of_inputs = vec![self.of_states.times(b)];
        of_inputs.extend(self.of_inputs.iter().cloned());
        Reading {
            of_states: self.of_states.times(a),
            of_inputs,
        }
    }
}

impl<T: Real> Realisation<T> {
    /// `None` where the digits of T do not suffice to divide by masses, dampers or springs.
    pub(super) fn of(asked: &Asked<'_>) -> Option<Realisation<T>> {
        let system = asked.system;
        let form = EnclosedFirstOrder::<T>::of(system).ok()?;
        let (own, n, inputs) = (form.states(), system.len(), asked.channels.len());
        let integrals: usize = asked.channels.iter().map(|channel| channel.integrals).sum();
        let size = own + integrals;
        let supports = system.supports();

        let zeros = |columns| BallMatrix::<T>::zeros(n, columns);
        let mut by_states = zeros(integrals);
        let mut by_inputs = [zeros(inputs), zeros(inputs), zeros(inputs)];
        let mut a = BallMatrix::zeros(size, size);
        let mut fed = BallMatrix::zeros(size, inputs);
        let mut places = BallMatrix::zeros(n + supports.len(), size);
        let mut led = BallMatrix::zeros(n + supports.len(), inputs);
        let mut states = own_states(&form, system.names());
        let mut first = 0;
        for (input, channel) in asked.channels.iter().enumerate() {
            let q = channel.integrals;
            for (k, direction) in channel.directions.iter().enumerate() {
                for &(row, factor) in direction {
                    let factor = T::from(factor);
                    match k < q {
                        true => by_states.add(row, first + k, factor, Magnitude::ZERO),
                        false => by_inputs[k - q].add(row, input, factor, Magnitude::ZERO),
                    }
                }
            }
            for k in 1..q {
                a.set(
                    own + first + k - 1,
                    own + first + k,
                    T::ONE,
                    Magnitude::ZERO,
                );
            }
            if q > 0 {
                fed.set(own + first + q - 1, input, T::ONE, Magnitude::ZERO);
            }
            if let Some(support) = channel.support {
                match q {
                    0 => led.set(n + support, input, T::ONE, Magnitude::ZERO),
                    _ => places.set(n + support, own + first, T::ONE, Magnitude::ZERO),
                }
                let words = ["displacement", "velocity"].into_iter().take(q);
                states.extend(words.map(|word| format!("{} {word}", supports[support])));
            }
            first += q;
        }

        a.put(0, 0, form.a());
        a.put(0, own, &form.b().times(&by_states));
        let pushes = by_inputs.each_ref().map(|force| form.b().times(force));
        let mut b = fed;
        b.put(0, 0, &pushes[0]);
        let whole = |part: &BallMatrix<T>| {
            let mut whole = BallMatrix::zeros(size, inputs);
            whole.put(0, 0, part);
            whole
        };
        let second = whole(&pushes[2]);
        let first = whole(&pushes[1]).plus(&a.times(&second));
        let b = b.plus(&a.times(&first));
        for (i, name) in states.iter_mut().enumerate() {
            let jumps = |j: &usize| !first.is_zero(i, *j) || !second.is_zero(i, *j);
            let of: Vec<&str> = (0..inputs)
                .filter(jumps)
                .map(|j| asked.inputs[j].as_str())
                .collect();
            if !of.is_empty() {
                *name += &format!(" without the jumps by {}", of.join(" and "));
            }
        }

        places.put(0, 0, form.x());
        places.put(0, own, &form.d().times(&by_states));
        let moved = by_inputs.map(|force| {
            let mut moved = BallMatrix::zeros(n + supports.len(), inputs);
            moved.put(0, 0, &form.d().times(&force));
            moved
        });
        let [at_once, later, last] = moved;
        let position = Reading {
            of_inputs: vec![
                at_once.plus(&led).plus(&places.times(&first)),
                later.plus(&places.times(&second)),
                last,
            ],
            of_states: places,
        };
        let velocity = position.derivative(&a, &b);
        let acceleration = velocity.derivative(&a, &b);
        let readings = [position, velocity, acceleration];
        let count = asked.sources.len();
        let mut c = BallMatrix::zeros(count, size);
        let mut of_inputs = vec![BallMatrix::zeros(count, inputs); 5];
        for (row, source) in asked.sources.iter().enumerate() {
            for (terms, reading) in source.terms.iter().zip(&readings) {
                for &(i, factors) in terms {
                    add_product(&mut c, row, factors, i, &reading.of_states);
                    for (sum, part) in of_inputs.iter_mut().zip(&reading.of_inputs) {
                        add_product(sum, row, factors, i, part);
                    }
                }
            }
        }
        let d = of_inputs.remove(0);
        Some(Realisation {
            a,
            b,
            c,
            d,
            of_derivatives: of_inputs,
            form,
            states,
        })
    }

    /// Refuses an output that follows a derivative of an input, or is not shown to follow none.
    pub(super) fn check_proper(&self, asked: &Asked<'_>) -> Result<(), StateSpaceError> {
        for (row, output) in asked.outputs.iter().enumerate() {
            let follows = |input: &usize| {
                let parts = &mut self.of_derivatives.iter();
                parts.any(|part| !part.is_zero(row, *input))
            };
            if let Some(input) = (0..asked.inputs.len()).find(follows) {
                return Err(StateSpaceError::Improper {
                    output: output.clone(),
                    input: asked.inputs[input].clone(),
                });
            }
        }
        Ok(())
    }

    /// With the rates of change of all outputs after them.
    pub(super) fn with_rates(mut self) -> Realisation<T> {
        let (count, inputs) = (self.c.rows(), self.b.columns());
        let stacked = |above: &BallMatrix<T>, below: &BallMatrix<T>| {
            let mut both = BallMatrix::zeros(2 * count, above.columns());
            both.put(0, 0, above);
            both.put(count, 0, below);
            both
        };
        let mut of_inputs = vec![self.d];
        of_inputs.append(&mut self.of_derivatives);
        of_inputs.push(BallMatrix::zeros(count, inputs));
        let mut of_rates = self.c.times(&self.b);
        for part in &mut of_inputs {
            let both = stacked(part, &of_rates);
            of_rates = std::mem::replace(part, both);
        }
        self.d = of_inputs.remove(0);
        self.of_derivatives = of_inputs;
        self.c = stacked(&self.c, &self.c.times(&self.a));
        self
    }

    /// The states of the system itself beside the integrals u/s and u/s² of the inputs, from
    /// (s − A)⁻¹s⁻¹ = A⁻¹((s − A)⁻¹ − s⁻¹): the form without them, and what outputs follow of u/s² and of u/s. `None` where the
    /// digits do not distinguish A from a singular matrix.
    pub(super) fn beside_integrals(
        mut self,
        asked: &Asked<'_>,
    ) -> Option<(Realisation<T>, [BallMatrix<T>; 2])> {
        let (own, rows, inputs) = (self.form.states(), self.c.rows(), self.b.columns());
        let a = self.a.block(0, 0, own, own);
        let c = self.c.block(0, 0, rows, own);
        let mut b = self.b.block(0, 0, own, inputs);
        let mut follows = [(); 2].map(|()| BallMatrix::zeros(rows, inputs));
        let mut first = own;
        for (input, channel) in asked.channels.iter().enumerate() {
            let count = channel.integrals;
            // The states u/s², u/s, or the latter alone.
            let mut steady = BallMatrix::zeros(own, 1);
            for at in 0..count {
                let pushed = self.a.block(0, first + at, own, 1).plus(&steady);
                steady = a.solve(&pushed)?;
                let direct = self.c.block(0, first + at, rows, 1);
                let follows = &mut follows[2 - count + at];
                follows.put(0, input, &direct.plus(&c.times(&steady).negated()));
            }
            b.put(0, input, &b.block(0, input, own, 1).plus(&steady));
            first += count;
        }
        (self.a, self.b, self.c) = (a, b, c);
        self.states.truncate(own);
        Some((self, follows))
    }
}

/// Adds a row times both factors to a row of the sum.
fn add_product<T: Real>(
    sum: &mut BallMatrix<T>,
    row: usize,
    [a, b]: [f64; 2],
    of: usize,
    matrix: &BallMatrix<T>,
) {
    let mut part = BallMatrix::zeros(1, matrix.columns());
    add_multiple(&mut part, 0, a, &matrix.block(of, 0, 1, matrix.columns()));
    add_multiple(sum, row, b, &part);
}

/// What the states of the system itself are, read from what makes them of displacements and velocities.
fn own_states<T: Real>(form: &EnclosedFirstOrder<T>, names: &[String]) -> Vec<String> {
    let initial = form.initial();
    let n = names.len();
    let state = |row: usize| {
        let taken = |column: &usize| initial.middle(row, *column) < T::ZERO;
        let mut columns: Vec<usize> = (0..2 * n)
            .filter(|column| !initial.is_zero(row, *column))
            .collect();
        columns.sort_by_key(taken);
        let mut text = String::new();
        for column in columns {
            let word = if column < n {
                "displacement"
            } else {
                "velocity"
            };
            text += match taken(&column) {
                true => " − ",
                false if text.is_empty() => "",
                false => " + ",
            };
            text += &format!("{} {word}", names[column % n]);
        }
        text
    };
    (0..form.states()).map(state).collect()
}
