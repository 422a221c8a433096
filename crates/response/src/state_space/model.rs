//! A system as z′ = A z + B u, y = C z + D u.

use eigentone_digits::Real;
use eigentone_modes::{FirstOrder, System};
use faer::MatRef;

use super::asked::{Asked, word};
use super::bounded::BoundedMatrix;
use super::discrete::Discrete;
use super::error::StateSpaceError;
use super::ladder::{Found, Question, climb};
use super::noise::{Noise, comes_to_rest, not_shown};
use super::realisation::Realisation;
use crate::problem::{Combination, Hold, Quantity, Sum};

/// A system as z′ = A z + B u, y = C z + D u, with named states, inputs and outputs.
///
/// States are the displacements of the coordinates that have mass, their velocities, and a displacement for each
/// independent damper between nodes without mass; nodes without mass are eliminated. Inputs are forces on coordinates and points, and motions of supports
/// by any of their derivatives. Where velocity or acceleration is the input, the support's displacement (and velocity) are
/// states too, so that outputs are absolute. Where u is a displacement (or a velocity) and dampers (or masses) at the
/// support pass on its derivatives, what its jumps make of the state at once is taken out of the state, and back in by D: no
/// derivative of an input remains, and jumps are impulses as they are in reality. Such states say so in their names.
///
/// ```
/// use eigentone_modes::{GROUND, System};
/// use eigentone_response::{Hold, Quantity, StateSpace};
///
/// let system = System::builder()
///     .mass("m", 2.0)
///     .spring(GROUND, "m", 8.0)
///     .damper(GROUND, "m", 1.0)
///     .build()?;
/// let plant = StateSpace::of(&system)
///     .force("m")
///     .output("m", Quantity::Displacement)
///     .build()?;
/// assert_eq!(plant.states(), ["m displacement", "m velocity"]);
/// assert_eq!(plant.matrices().a.values[(1, 0)], -4.0);
/// // Under a force that keeps each sample for 1/100 s, exactly:
/// let held = plant.discretise(0.01, Hold::Zero)?;
/// assert!((held.b.values[(1, 0)] - 0.004_987_188).abs() < 1e-9);
/// assert!(held.b.bound[(1, 0)] < 1e-18);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct StateSpace<'a> {
    asked: Asked<'a>,
    states: Vec<String>,
    matrices: StateMatrices,
}

/// A, B, C and D of a continuous or a discrete form.
#[derive(Clone, Debug, PartialEq)]
pub struct StateMatrices {
    /// States × states.
    pub a: BoundedMatrix,
    /// States × inputs.
    pub b: BoundedMatrix,
    /// Outputs × states.
    pub c: BoundedMatrix,
    /// Outputs × inputs.
    pub d: BoundedMatrix,
}

/// Chooses inputs and outputs of a [`StateSpace`]; columns and rows come in the order in which they are named.
#[derive(Clone, Debug)]
#[must_use = "nothing is computed until `build` is called"]
pub struct StateSpaceBuilder<'a> {
    system: &'a System,
    inputs: Vec<(String, Option<Quantity>)>,
    outputs: Vec<Combination>,
}

impl<'a> StateSpaceBuilder<'a> {
    /// A force on a coordinate or point, in N, as an input.
    pub fn force(mut self, name: impl Into<String>) -> StateSpaceBuilder<'a> {
        self.inputs.push((name.into(), None));
        self
    }

    /// The motion of a support, by its displacement, velocity or acceleration, as an input.
    pub fn motion(mut self, name: impl Into<String>, quantity: Quantity) -> StateSpaceBuilder<'a> {
        self.inputs.push((name.into(), Some(quantity)));
        self
    }

    /// A motion of a coordinate, point or support as an output.
    pub fn output(self, name: impl Into<String>, quantity: Quantity) -> StateSpaceBuilder<'a> {
        let name = name.into();
        let called = format!("{name} {}", word(quantity));
        self.sum(called, [(quantity, name, 1.0)])
    }

    /// A combination of motions as an output.
    pub fn combination(mut self, combination: Combination) -> StateSpaceBuilder<'a> {
        self.outputs.push(combination);
        self
    }

    /// A sum of motions as an output: which quantity, of which coordinate, point or support, times what.
    pub fn sum<N: Into<String>>(
        self,
        name: impl Into<String>,
        motions: impl IntoIterator<Item = (Quantity, N, f64)>,
    ) -> StateSpaceBuilder<'a> {
        let motions = motions.into_iter();
        let motions = motions.map(|(quantity, of, factor)| (quantity, of.into(), factor));
        let (name, of) = (name.into(), Sum::Motions(motions.collect()));
        self.combination(Combination { name, of })
    }

    /// The pull of the spring or damper named `element` as an output.
    pub fn pull(
        self,
        name: impl Into<String>,
        element: impl Into<String>,
    ) -> StateSpaceBuilder<'a> {
        let (name, of) = (name.into(), Sum::Pull(element.into()));
        self.combination(Combination { name, of })
    }

    /// A, B, C and D.
    ///
    /// # Errors
    /// [`StateSpaceError`]: names that are not there; an output that follows a derivative of an input, or that the digits
    /// do not show to follow none; a system without first-order form; entries beyond the doubles.
    pub fn build(self) -> Result<StateSpace<'a>, StateSpaceError> {
        let mut asked = Asked::of(self.system);
        for (name, quantity) in &self.inputs {
            match quantity {
                None => asked.force(name)?,
                Some(quantity) => asked.motion(name, *quantity)?,
            }
        }
        for output in self.outputs {
            asked.output(output)?;
        }
        // What has no form at all has none in any digits.
        let states = FirstOrder::of(self.system)?.states() as f64;
        let operations = 8.0 * states.powi(3);
        let (states, matrices) = climb(&Continuous { asked: &asked }, states as usize, operations)?;
        Ok(StateSpace {
            asked,
            states,
            matrices: matrices.into(),
        })
    }
}

impl<'a> StateSpace<'a> {
    /// Starts from a system, without inputs and outputs.
    pub fn of(system: &'a System) -> StateSpaceBuilder<'a> {
        StateSpaceBuilder {
            system,
            inputs: Vec::new(),
            outputs: Vec::new(),
        }
    }

    /// A, B, C and D of z′ = A z + B u, y = C z + D u.
    pub fn matrices(&self) -> &StateMatrices {
        &self.matrices
    }

    /// What the states are.
    pub fn states(&self) -> &[String] {
        &self.states
    }

    /// What the inputs are.
    pub fn inputs(&self) -> &[String] {
        &self.asked.inputs
    }

    /// What the outputs are.
    pub fn outputs(&self) -> &[String] {
        &self.asked.outputs
    }

    /// The exact discrete form ζ(k + 1) = A ζ(k) + B u(k), y(k) = C ζ(k) + D u(k) for inputs that are held between samples
    /// `step` s apart. Under [`Hold::Zero`] ζ is z; under [`Hold::First`], where inputs run straight from sample to
    /// sample, it is z − Γu with Γ = ∫₀ʰ e^{A(h − s)} B s/h ds, so that no later sample is needed, as in SciPy's
    /// `cont2discrete(…, "foh")`. Entries are right to the last digit down to 1e-30 of what the energy allows them to be.
    ///
    /// # Errors
    /// [`StateSpaceError`]: a step that is not positive, entries beyond the doubles, more work than can be afforded.
    pub fn discretise(&self, step: f64, hold: Hold) -> Result<StateMatrices, StateSpaceError> {
        let borders = match hold {
            Hold::Zero => 1,
            Hold::First => 2,
        };
        let operations = self.operations(step, borders * self.asked.inputs.len())?;
        let asked = &self.asked;
        let question = Discrete { asked, step, hold };
        Ok(climb(&question, self.states.len(), operations)?.into())
    }

    /// What white noise on the inputs adds to the covariance of the state within `step` s:
    /// Q = ∫₀ʰ e^{As} B W Bᵀ e^{Aᵀs} ds (states × states), for a `density` W (inputs × inputs) with E[u(t)u(s)ᵀ] = W δ(t − s):
    /// half of the one-sided density per Hz. For λh of any size: nothing in it grows.
    ///
    /// # Errors
    /// [`StateSpaceError`]: a density that is not symmetric, and as for [`discretise`](Self::discretise).
    pub fn process_noise(
        &self,
        step: f64,
        density: MatRef<'_, f64>,
    ) -> Result<BoundedMatrix, StateSpaceError> {
        self.check(density)?;
        let operations = 3.0 * self.operations(step, 0)?;
        let asked = &self.asked;
        let question = Noise {
            asked,
            step,
            forever: false,
            density,
        };
        climb(&question, self.states.len(), operations)
    }

    /// The covariance P of the state (states × states) that white noise on the inputs keeps up in the long run, A P + P Aᵀ + B W Bᵀ = 0,
    /// for a `density` W as in [`process_noise`](Self::process_noise): exact also where damping is next to nothing or frequencies are
    /// many powers of ten apart. The variances of outputs without D are the diagonal of C P Cᵀ.
    ///
    /// ```
    /// use eigentone_modes::{GROUND, System};
    /// use eigentone_response::StateSpace;
    /// use faer::mat;
    ///
    /// let system = System::builder().mass("m", 2.0).spring(GROUND, "m", 8.0).damper(GROUND, "m", 1e-9);
    /// let system = system.build()?;
    /// let plant = StateSpace::of(&system).force("m").build()?;
    /// // W/2ck and W/2cm.
    /// let covariance = plant.stationary_covariance(mat![[1.0]].as_ref())?.values;
    /// assert!((covariance[(0, 0)] * 16e-9 - 1.0).abs() < 4e-16);
    /// assert!((covariance[(1, 1)] * 4e-9 - 1.0).abs() < 4e-16);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`StateSpaceError::NotStationary`] where something does not come to rest by itself: rigid motions, undamped modes, and the
    /// displacement of a support that is an integral of an input; [`StateSpaceError::NotShownStationary`] for what grows. Else as for
    /// [`process_noise`](Self::process_noise).
    pub fn stationary_covariance(
        &self,
        density: MatRef<'_, f64>,
    ) -> Result<BoundedMatrix, StateSpaceError> {
        self.check(density)?;
        let driven = self.asked.channels.iter().zip(&self.asked.inputs);
        let mut integrated = driven.filter(|(channel, _)| channel.integrals > 0);
        if let Some((_, input)) = integrated.next() {
            let what = format!("the support that the {input} moves");
            return Err(StateSpaceError::NotStationary { what });
        }
        comes_to_rest(self.asked.system)?;
        let step = first_step(self.matrices.a.values.as_ref());
        let operations = OF_DOUBLINGS * self.operations(step, 0)?;
        let asked = &self.asked;
        let question = Noise {
            asked,
            step,
            forever: true,
            density,
        };
        climb(&question, self.states.len(), operations).map_err(not_shown)
    }

    /// Refuses a density that is none.
    fn check(&self, density: MatRef<'_, f64>) -> Result<(), StateSpaceError> {
        let inputs = self.asked.inputs.len();
        let (rows, columns) = (density.nrows(), density.ncols());
        let fits = rows == inputs && columns == inputs;
        let right =
            |i: usize, j: usize| density[(i, j)].is_finite() && density[(i, j)] == density[(j, i)];
        if !fits || (0..rows).any(|i| (0..columns).any(|j| !right(i, j))) {
            return Err(StateSpaceError::Density {
                rows,
                columns,
                inputs,
            });
        }
        Ok(())
    }

    /// How many multiplications an exponential takes, with so many more rows.
    fn operations(&self, step: f64, more: usize) -> Result<f64, StateSpaceError> {
        if !(step.is_finite() && step > 0.0) {
            return Err(StateSpaceError::Step { step });
        }
        let squarings = (self.matrices.a.values.norm_max() * step).log2();
        Ok(operations(self.states.len() + more, squarings))
    }
}

/// How many exponentials the doublings of an integral over all the time count for: about as many as there are digits and
/// powers of ten between rates.
pub(super) const OF_DOUBLINGS: f64 = 9.0;

/// How many multiplications an exponential of so many rows and squarings takes.
pub(super) fn operations(size: usize, squarings: f64) -> f64 {
    (size as f64).powi(3) * (30.0 + squarings.max(0.0))
}

/// The time with which an integral over all the time begins.
pub(super) fn first_step(a: MatRef<'_, f64>) -> f64 {
    let size = a.norm_max();
    if size > 0.0 { 1.0 / size } else { 1.0 }
}

/// The continuous form itself.
struct Continuous<'a> {
    asked: &'a Asked<'a>,
}

impl Question for Continuous<'_> {
    type Answer = (Vec<String>, [BoundedMatrix; 4]);

    fn attempt<T: Real>(&self) -> Found<Self::Answer> {
        let Some(form) = Realisation::<T>::of(self.asked) else {
            return Ok(None);
        };
        form.check_proper(self.asked)?;
        let matrices = [
            BoundedMatrix::by_itself(&form.a, "A")?,
            BoundedMatrix::by_itself(&form.b, "B")?,
            BoundedMatrix::by_itself(&form.c, "C")?,
            BoundedMatrix::by_itself(&form.d, "D")?,
        ];
        let [Some(a), Some(b), Some(c), Some(d)] = matrices else {
            return Ok(None);
        };
        let good = a.1 && b.1 && c.1 && d.1;
        Ok(Some(((form.states, [a.0, b.0, c.0, d.0]), good)))
    }
}

impl From<[BoundedMatrix; 4]> for StateMatrices {
    fn from([a, b, c, d]: [BoundedMatrix; 4]) -> StateMatrices {
        StateMatrices { a, b, c, d }
    }
}
