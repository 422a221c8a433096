//! Root mean squares of the stationary motion under white noise: the covariance of the state, read where the outputs are.
//!
//! A support whose velocity or acceleration is white noise wanders without end. Where springs and dampers let the whole
//! system ride along with it unstretched, x = r u, what is beside that motion is stationary, and so are outputs that are the
//! same wherever the support is; both are told exactly.

use eigentone_digits::{BallMatrix, Magnitude, Real, Wide};
use eigentone_modes::{FirstOrder, MatrixKind, System};
use faer::Mat;

use super::asked::{Asked, word};
use super::coordinates::{Coordinates, kept};
use super::error::StateSpaceError;
use super::ladder::{Found, Question, affordable, climb};
use super::model::{OF_DOUBLINGS, first_step, operations};
use super::noise::{accumulated, comes_to_rest};
use super::realisation::Realisation;
use crate::problem::{Combination, Quantity, Source, Sum};

const QUANTITIES: [Quantity; 3] = [
    Quantity::Displacement,
    Quantity::Velocity,
    Quantity::Acceleration,
];

/// Digits of a variance that are to be right, and how small it may be beside what bounds it before they do not count.
const RIGHT: i64 = -60;
const NOTHING: i64 = -200;

/// White noise that drives a system, each source independent of the others, and what is asked of the motion that it keeps up
/// in the long run.
///
/// Densities S are one-sided, in the square of the unit per Hz: the mean square of what lies between f and f + df is S df,
/// f > 0. Over frequencies of both signs it is S/2 per Hz, and the noise w has E[w(t)w(s)] = (S/2) δ(t − s).
///
/// ```
/// use eigentone_modes::{GROUND, System};
/// use eigentone_response::{Rms, WhiteNoise};
///
/// let system = System::builder().mass("m", 2.0).spring(GROUND, "m", 8.0).damper(GROUND, "m", 0.5);
/// let system = system.build()?;
/// let motion = WhiteNoise::of(&system).force("m", 4.0).solve()?;
/// // √(S/4ck) and √(S/4cm).
/// let Rms::Finite { value, bound } = &motion.displacement()[0].1 else { panic!() };
/// assert_eq!(*value, 0.5);
/// assert!(*bound < 1e-16);
/// let Rms::Finite { value, .. } = &motion.velocity()[0].1 else { panic!() };
/// assert_eq!(*value, 1.0);
/// // The force is white, and so is the acceleration of what it acts on.
/// assert!(matches!(motion.acceleration()[0].1, Rms::Infinite { .. }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "nothing is computed until `solve` is called"]
pub struct WhiteNoise<'a> {
    system: &'a System,
    sources: Vec<(String, Option<Quantity>, f64)>,
    outputs: Vec<Combination>,
}

/// The root of the mean square of a stationary motion.
#[derive(Clone, Debug, PartialEq)]
pub enum Rms {
    /// It is within `bound` of `value`.
    Finite {
        /// The nearest double.
        value: f64,
        /// How far it may be off, its rounding included.
        bound: f64,
    },
    /// It is infinite: white noise passes on at once, or what it moves wanders without end.
    Infinite {
        /// The noise that makes it so.
        by: String,
    },
    /// No digits in reach tell whether it is finite.
    Undecided {
        /// The noise of which they do not tell whether it passes on at once.
        by: String,
    },
}

/// Root mean squares of the stationary motion under [`WhiteNoise`].
#[derive(Clone, Debug, PartialEq)]
pub struct StationaryMotion {
    motions: [Vec<(String, Rms)>; 3],
    outputs: Vec<(String, Rms)>,
}

impl<'a> WhiteNoise<'a> {
    /// Starts from a system, without noise.
    pub fn of(system: &'a System) -> WhiteNoise<'a> {
        WhiteNoise {
            system,
            sources: Vec::new(),
            outputs: Vec::new(),
        }
    }

    /// A force on a coordinate or point that is white noise of this one-sided density, in N²/Hz.
    pub fn force(mut self, name: impl Into<String>, density: f64) -> WhiteNoise<'a> {
        self.sources.push((name.into(), None, density));
        self
    }

    /// The motion of a support, white noise in its displacement, velocity or acceleration.
    pub fn motion(
        mut self,
        name: impl Into<String>,
        quantity: Quantity,
        density: f64,
    ) -> WhiteNoise<'a> {
        self.sources.push((name.into(), Some(quantity), density));
        self
    }

    /// A combination of motions that is asked for beside those of all coordinates and points.
    pub fn output(mut self, combination: Combination) -> WhiteNoise<'a> {
        self.outputs.push(combination);
        self
    }

    /// The root mean squares of all coordinates, points and outputs.
    ///
    /// # Errors
    /// [`StateSpaceError`]: names that are not there, densities below 0; [`StateSpaceError::NotStationary`] for rigid motions and
    /// undamped modes, [`StateSpaceError::Wanders`] for a support that wanders and does not carry the whole system, and
    /// [`StateSpaceError::Lost`] for what grows.
    pub fn solve(self) -> Result<StationaryMotion, StateSpaceError> {
        let system = self.system;
        let mut asked = Asked::of(system);
        let inputs = self.sources.len();
        let mut density = Mat::<f64>::zeros(inputs, inputs);
        for (i, (name, quantity, given)) in self.sources.into_iter().enumerate() {
            if !(given.is_finite() && given >= 0.0) {
                let density = given;
                return Err(StateSpaceError::NoiseDensity { name, density });
            }
            match quantity {
                None => asked.force(&name)?,
                Some(quantity) => asked.motion(&name, quantity)?,
            }
            density[(i, i)] = given / 2.0;
        }
        let points = system.points().iter().map(|point| &point.name);
        let places: Vec<&String> = system.names().iter().chain(points).collect();
        for quantity in QUANTITIES {
            for name in &places {
                asked.output(Combination {
                    name: (*name).clone(),
                    of: Sum::Motions(vec![(quantity, (*name).clone(), 1.0)]),
                })?;
            }
        }
        for output in self.outputs {
            asked.output(output)?;
        }
        let form = FirstOrder::of(system)?;
        let operations = OF_DOUBLINGS * operations(form.states(), 0.0);
        affordable(form.states(), operations)?;
        comes_to_rest(system)?;
        let rides = rides(&asked)?;
        let question = Stationary {
            asked: &asked,
            step: first_step(form.a()),
            wanders: wanderers(&asked, &rides, &density),
            density,
            rides,
        };
        let all = climb(&question, form.states(), operations)?;
        let mut all = asked.outputs.into_iter().zip(all);
        let motions = [(); 3].map(|()| all.by_ref().take(places.len()).collect());
        let outputs = all.collect();
        Ok(StationaryMotion { motions, outputs })
    }
}

impl StationaryMotion {
    /// Displacements of all coordinates and points, by their names, in m or rad.
    pub fn displacement(&self) -> &[(String, Rms)] {
        &self.motions[0]
    }

    /// Their velocities.
    pub fn velocity(&self) -> &[(String, Rms)] {
        &self.motions[1]
    }

    /// Their accelerations.
    pub fn acceleration(&self) -> &[(String, Rms)] {
        &self.motions[2]
    }

    /// How often a second displacements pass through 0 upwards on average, σ_v/2πσ_x, in Hz, as far as both are finite and not
    /// 0: Rice's formula (1944, *Bell Syst. Tech. J.* 23), for noise that is Gaussian.
    pub fn zero_crossings(&self) -> Vec<(&str, Option<Rms>)> {
        let both = self.displacement().iter().zip(self.velocity());
        let rate = |displacement: &Rms, velocity: &Rms| {
            let (&Rms::Finite { value: x, bound: a }, &Rms::Finite { value: v, bound: b }) =
                (displacement, velocity)
            else {
                return None;
            };
            // (1 + ε)/(1 − δ) is within 2(ε + δ) of 1, and there are four roundings.
            let value = v / x / std::f64::consts::TAU;
            let off = 2.0 * (a / x + b / v) + 4.0 * f64::EPSILON;
            let bound = (value * off).next_up();
            let told = off <= 0.5 && value >= f64::MIN_POSITIVE / f64::EPSILON && bound.is_finite();
            told.then_some(Rms::Finite { value, bound })
        };
        both.map(|((name, x), (_, v))| (name.as_str(), rate(x, v)))
            .collect()
    }

    /// The outputs asked for, by their names.
    pub fn outputs(&self) -> &[(String, Rms)] {
        &self.outputs
    }
}

struct Stationary<'a> {
    asked: &'a Asked<'a>,
    density: Mat<f64>,
    step: f64,
    /// How far coordinates ride along, for each input; empty where none has to.
    rides: Vec<Vec<f64>>,
    /// For each output the input with whose support it wanders off.
    wanders: Vec<Option<usize>>,
}

impl Question for Stationary<'_> {
    type Answer = Vec<Rms>;

    fn attempt<T: Real>(&self) -> Found<Vec<Rms>> {
        let Some(form) = Realisation::<T>::of(self.asked) else {
            return Ok(None);
        };
        let form = form.beside_rides(self.asked, &self.rides);
        let Some(coordinates) = Coordinates::of(self.asked, &form, self.step) else {
            return Ok(None);
        };
        let density = self.density.as_ref();
        let Some(sum) = accumulated(&coordinates, &form, density, self.step, true) else {
            return Ok(None);
        };
        let n = form.a.rows();
        let (exact, rows) = coordinates.covariance(&form.c, &kept(&sum, 0, n, n), sum.error());
        let norm = sum.true_norm();
        let mut good = true;
        let mut all = Vec::new();
        for (row, size) in rows.into_iter().enumerate() {
            let name = |input: usize| self.asked.inputs[input].clone();
            if let Some(input) = self.wanders[row] {
                all.push(Rms::Infinite { by: name(input) });
                continue;
            }
            match self.at_once(&form, row) {
                None => {}
                Some((input, true)) => {
                    all.push(Rms::Infinite { by: name(input) });
                    continue;
                }
                Some((input, false)) => {
                    good = false;
                    all.push(Rms::Undecided { by: name(input) });
                    continue;
                }
            }
            let (variance, radius) = (exact.middle(row, row), exact.radius(row, row));
            let nothing = size * size * norm * Magnitude::power_of_two(NOTHING);
            let counts = match variance.upper() < nothing {
                true => nothing,
                false => variance.upper(),
            };
            good &= radius <= counts * Magnitude::power_of_two(RIGHT);
            match root(variance, radius) {
                Some(rms) => all.push(rms),
                None => return Ok(None),
            }
        }
        Ok(Some((all, good)))
    }
}

impl Stationary<'_> {
    /// The noise that an output follows at once, by itself or by its derivatives, and whether that is certain.
    fn at_once<T: Real>(&self, form: &Realisation<T>, row: usize) -> Option<(usize, bool)> {
        let loud = |input: &usize| self.density[(*input, *input)] != 0.0;
        let inputs = || (0..self.asked.inputs.len()).filter(loud);
        let parts = || [&form.d].into_iter().chain(&form.of_derivatives);
        let certain = |part: &BallMatrix<T>, input: usize| {
            let (middle, radius) = (part.middle(row, input), part.radius(row, input));
            radius < (middle.abs() * T::from(0.5)).upper() && !middle.is_zero()
        };
        let passed = inputs().find(|input| parts().any(|part| certain(part, *input)));
        let possible = || inputs().find(|input| parts().any(|part| !part.is_zero(row, *input)));
        match passed {
            Some(input) => Some((input, true)),
            None => possible().map(|input| (input, false)),
        }
    }
}

/// √variance; `None` where nothing is known of it, or where it is beyond the doubles.
fn root<T: Real>(variance: T, radius: Magnitude) -> Option<Rms> {
    let size = variance.upper();
    let rms = if variance <= T::ZERO || size <= radius {
        Rms::Finite {
            value: 0.0,
            bound: (size + radius).sqrt().to_f64(),
        }
    } else {
        let root = variance.sqrt();
        let value = root.to_f64();
        // |√t − √v| ≤ |t − v|/√v, and √v is at least half of what is computed for it.
        let least = (root * T::from(0.5)).upper();
        let rounding = root.upper() * T::unit() * Magnitude::from(4.0) + T::floor();
        let off = radius / least + rounding + (root - T::from(value)).upper();
        Rms::Finite {
            value,
            bound: off.to_f64(),
        }
    };
    match rms {
        Rms::Finite { value, bound } if !(value.is_finite() && bound.is_finite()) => None,
        rms => Some(rms),
    }
}

/// How far each coordinate rides along with the support of each input that is integrated: K r + K_s = 0 and C r + C_s = 0.
fn rides(asked: &Asked<'_>) -> Result<Vec<Vec<f64>>, StateSpaceError> {
    let (system, n) = (asked.system, asked.system.len());
    let mut rides = Vec::new();
    for channel in &asked.channels {
        let (Some(support), 1..) = (channel.support, channel.integrals) else {
            rides.push(Vec::new());
            continue;
        };
        let mut stiffness = BallMatrix::<Wide<4>>::zeros(n, n);
        for term in system.terms(MatrixKind::Stiffness) {
            stiffness.add(term.row, term.column, term.value.into(), Magnitude::ZERO);
        }
        let mut pull = BallMatrix::zeros(n, 1);
        for (row, force) in &channel.directions[0] {
            pull.add(*row, 0, (*force).into(), Magnitude::ZERO);
        }
        let solved = stiffness.solve(&pull);
        let shares =
            |ride: BallMatrix<Wide<4>>| (0..n).map(|i| ride.middle(i, 0).to_f64()).collect();
        let ride: Vec<f64> = solved.map(shares).unwrap_or_default();
        let kinds = [MatrixKind::Stiffness, MatrixKind::Damping];
        let mut both = kinds.iter().zip(&channel.directions);
        let unstretched = |(kind, forces): (&MatrixKind, &Vec<(usize, f64)>)| {
            let mut sums = vec![Vec::new(); n];
            for term in system.terms(*kind) {
                sums[term.row].push([term.value, ride[term.column], 1.0]);
            }
            for (row, force) in forces {
                sums[*row].push([-force, 1.0, 1.0]);
            }
            sums.into_iter().all(|sum| vanishes(sum) == Some(true))
        };
        if ride.len() != n || !both.all(unstretched) {
            return Err(StateSpaceError::Wanders {
                support: system.supports()[support].clone(),
                quantity: word(QUANTITIES[channel.integrals.min(2)]),
            });
        }
        rides.push(ride);
    }
    Ok(rides)
}

/// For each output the input with whose support it wanders off.
fn wanderers(asked: &Asked<'_>, rides: &[Vec<f64>], density: &Mat<f64>) -> Vec<Option<usize>> {
    let n = asked.system.len();
    let wanders = |source: &Source, input: usize| {
        let channel = &asked.channels[input];
        let share = |i: usize| match i.checked_sub(n) {
            None => rides[input][i],
            Some(support) => f64::from(u8::from(channel.support == Some(support))),
        };
        // u wanders, and u′ where it is an integral too.
        let sums = source.terms.iter().take(channel.integrals);
        let mut sums = sums.map(|terms| terms.iter().map(|&(i, [a, b])| [a, b, share(i)]));
        sums.any(|sum| vanishes(sum) != Some(true))
    };
    let loud = |input: &usize| density[(*input, *input)] != 0.0;
    let of = |source| {
        (0..rides.len())
            .filter(loud)
            .find(|input| wanders(source, *input))
    };
    asked.sources.iter().map(of).collect()
}

/// Whether a sum of products is 0, told exactly: it is an expansion of doubles that do not overlap (Shewchuk 1997, *Discrete
/// Comput. Geom.* 18), of which none is left. `None` where products leave the range in which their errors are doubles.
fn vanishes(products: impl IntoIterator<Item = [f64; 3]>) -> Option<bool> {
    let mut parts: Vec<f64> = Vec::new();
    for [a, b, c] in products {
        for factor in two_product(a, b)? {
            for mut term in two_product(factor, c)? {
                let mut kept = Vec::new();
                for part in parts {
                    let sum = term + part;
                    let back = sum - term;
                    let error = (term - (sum - back)) + (part - back);
                    kept.extend((error != 0.0).then_some(error));
                    term = sum;
                }
                kept.extend((term != 0.0).then_some(term));
                parts = kept;
            }
        }
    }
    parts
        .iter()
        .all(|part| part.is_finite())
        .then_some(parts.is_empty())
}

/// a·b as its rounded value and the rest.
fn two_product(a: f64, b: f64) -> Option<[f64; 2]> {
    let product = a * b;
    let inside = (1e-290..1e300).contains(&product.abs()) || a == 0.0 || b == 0.0 || b == 1.0;
    inside.then_some([product, a.mul_add(b, -product)])
}
