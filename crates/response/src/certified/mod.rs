//! The exact response with proven bounds: the exponential in as many digits as the bounds ask for. It knows `exponential`, `problem`,
//! `answer` and `enclosed`.

#[cfg(test)]
mod agreement;
mod attempt;
mod clock;
mod drift;
mod driven;
pub(crate) mod follow;
mod generator;
mod judge;
mod march;
mod products;
pub(crate) mod quadratic;
mod quintic;
mod remainder;
mod stepper;
mod work;

use eigentone_digits::{DoubleDouble, Real, Wide, decimal_digits};
use eigentone_modes::{FirstOrder, Precision};

use crate::answer::{ResponseMethod, Trajectory, Wanted};
use crate::problem::{Problem, ResponseError};
use attempt::Attempt;
pub use driven::{Driven, KnownVector};
use march::March;
use stepper::Stepper;
pub(crate) use work::work;
use work::{MOST_MORE, MOST_WORK};

/// z(t + h) = e^{Wh} z(t) for state and loads together, with a proven bound at every instant.
///
/// The state matrix comes from the elements with about 32 digits and a bound of each entry; it is
/// taken to energy coordinates, in which a passive system lengthens no error; the exponential is a
/// Taylor polynomial, squared, with every error counted in the 2-norm; and the errors of the steps
/// are added up with the norms of the powers that carry them on. Where an instant misses the
/// tolerance, all is done again: with a state matrix from 77 digits, as dividing by ill-conditioned masses costs digits and
/// the exponential costs few, then with 77, 154, … digits throughout. Exact at resonance, at critical damping and
/// without supports, for passive and for unstable systems, and for any stiffness.
#[derive(Clone, Copy, Debug)]
pub struct ByCertifiedExponential;

/// One attempt, by the digits it takes.
struct Rung {
    limbs: usize,
    /// Limbs for the generator alone.
    prepared: usize,
    run: Run,
}

type Run = fn(March<'_, '_>) -> Result<Attempt, ResponseError>;

const LADDER: [Rung; 7] = [
    rung(1, 1, shared::<DoubleDouble>),
    rung(1, 4, shared::<Wide<4>>),
    rung(4, 4, alone::<Wide<4>>),
    rung(8, 8, alone::<Wide<8>>),
    rung(16, 16, alone::<Wide<16>>),
    rung(32, 32, alone::<Wide<32>>),
    rung(64, 64, alone::<Wide<64>>),
];

/// With 32 digits, by a generator computed in the arithmetic of G: both it and the unit step are shared.
fn shared<G: Real>(march: March<'_, '_>) -> Result<Attempt, ResponseError> {
    march.by(Stepper::shared::<G>(march.problem))
}

/// All in the arithmetic of T.
fn alone<T: Real>(march: March<'_, '_>) -> Result<Attempt, ResponseError> {
    march.by(Stepper::<T>::of::<T>(march.problem))
}

const fn rung(limbs: usize, prepared: usize, run: Run) -> Rung {
    Rung {
        limbs,
        prepared,
        run,
    }
}

impl ByCertifiedExponential {
    /// The motion at any times in s, from 0 to the end of the problem's grid, in any order, instead
    /// of the instants of the grid. A time is taken exactly, unless it is the double printed for an
    /// instant of the grid, which it then stands for. The trajectory has no step indices.
    ///
    /// # Errors
    /// [`ResponseError::Time`] for a time that is not finite or not within the grid, and what
    /// [`run`](ResponseMethod::run) reports.
    ///
    /// ```
    /// use eigentone_modes::{GROUND, System};
    /// use eigentone_response::{ByCertifiedExponential, Response, State};
    ///
    /// let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 4.0).build()?;
    /// let from = State::at_rest().displace("m", 1.0);
    /// let problem = Response::of(&system).from(from).every(1.0).until(10.0).problem()?;
    /// let motion = ByCertifiedExponential.at(&problem, &[0.3, 9.87654321])?;
    /// assert!((motion.displacement()[(0, 0)] - 0.6f64.cos()).abs() < 2e-16);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn at(&self, problem: &Problem<'_>, times: &[f64]) -> Result<Trajectory, ResponseError> {
        let end = problem.grid().time(problem.grid().last());
        match times.iter().find(|time| !(0.0..=end).contains(*time)) {
            Some(&time) => Err(ResponseError::Time { time, end }),
            None => self.climb(problem, Wanted::Times(times)),
        }
    }

    /// More and more digits, until they suffice.
    fn climb(
        &self,
        problem: &Problem<'_>,
        wanted: Wanted<'_>,
    ) -> Result<Trajectory, ResponseError> {
        if let Some(reason) = refusal(problem, &wanted) {
            return Err(ResponseError::NotApplicable {
                method: self.name(),
                reason,
            });
        }
        let tolerance = match problem.precision() {
            Precision::Certified { tolerance } => tolerance,
            Precision::Double => f64::EPSILON,
        };
        let run = |rung: &Rung, last| {
            (rung.run)(March {
                problem,
                wanted,
                method: self.name(),
                tolerance,
                last,
            })
        };
        let mut halvings = 0.0;
        let mut missed = None;
        for (at, rung) in LADDER.iter().enumerate() {
            let work = |rung: &Rung| work(problem, &wanted, [rung.limbs, rung.prepared], halvings);
            if at > 0 && work(rung) > MOST_WORK {
                break;
            }
            let next = LADDER.get(at + 1).map(work);
            let last = next.is_none_or(|next| next > MOST_WORK);
            match run(rung, last || rung.limbs > 1 && work(rung) > MOST_MORE)? {
                Attempt::Found(trajectory) => {
                    return Ok(trajectory.proven(decimal_digits(rung.limbs)));
                }
                Attempt::Missed { halvings: known } => {
                    missed = Some(rung);
                    halvings = known;
                }
                Attempt::Stuck => {}
            }
        }
        // As good as can be afforded.
        if let Some(rung) = missed
            && let Attempt::Found(trajectory) = run(rung, true)?
        {
            return Ok(trajectory.proven(decimal_digits(rung.limbs)));
        }
        Err(ResponseError::NotApplicable {
            method: self.name(),
            reason:
                "no number of digits in reach distinguishes a matrix to be divided by from a singular one"
                    .to_owned(),
        })
    }
}

impl ResponseMethod for ByCertifiedExponential {
    fn name(&self) -> &'static str {
        "certified exponential"
    }

    fn refuses(&self, problem: &Problem<'_>) -> Option<String> {
        refusal(problem, &Wanted::by(problem))
    }

    fn run(&self, problem: &Problem<'_>) -> Result<Trajectory, ResponseError> {
        self.climb(problem, Wanted::by(problem))
    }
}

fn refusal(problem: &Problem<'_>, wanted: &Wanted<'_>) -> Option<String> {
    if let Err(error) = FirstOrder::of(problem.system()) {
        return Some(error.to_string());
    }
    let work = work(problem, wanted, [1, 1], 0.0);
    (work > MOST_WORK).then(|| {
        format!("it would take {work:.0e} operations with 32 digits, more than {MOST_WORK:.0e}")
    })
}
