//! The exact response with proven bounds: the exponential in as many digits as the bounds ask for.

mod drift;
mod energy;
mod exponential;
mod generator;
mod judge;
mod march;
mod normed;

use eigentone_digits::{DoubleDouble, Wide};
use eigentone_modes::Precision;

use crate::method::ResponseMethod;
use crate::problem::{Problem, ResponseError};
use crate::trajectory::Trajectory;
use march::march;

/// z(t + h) = e^{Wh} z(t) for state and loads together, with a proven bound at every instant.
///
/// The state matrix comes from the elements with about 32 digits and a bound of each entry; it is
/// taken to energy coordinates, in which a passive system lengthens no error; the exponential is a
/// Taylor polynomial, squared, with every error counted in the 2-norm; and the errors of the steps
/// are added up with the norms of the powers that carry them on. Where an instant misses the
/// tolerance, all is done again with 77, 154, … digits. Exact at resonance, at critical damping and
/// without supports, for passive and for unstable systems, and for any stiffness.
#[derive(Clone, Copy, Debug)]
pub struct ByCertifiedExponential;

/// The largest number of coordinates for which it is picked.
pub(crate) const LARGEST: usize = 64;

/// One attempt, by the digits it takes.
struct Rung {
    limbs: usize,
    run: Run,
}

type Run = fn(&Problem<'_>, &'static str, f64, bool) -> Result<Option<Trajectory>, ResponseError>;

const LADDER: [Rung; 6] = [
    Rung {
        limbs: 1,
        run: march::<DoubleDouble>,
    },
    Rung {
        limbs: 4,
        run: march::<Wide<4>>,
    },
    Rung {
        limbs: 8,
        run: march::<Wide<8>>,
    },
    Rung {
        limbs: 16,
        run: march::<Wide<16>>,
    },
    Rung {
        limbs: 32,
        run: march::<Wide<32>>,
    },
    Rung {
        limbs: 64,
        run: march::<Wide<64>>,
    },
];

impl ResponseMethod for ByCertifiedExponential {
    fn name(&self) -> &'static str {
        "certified exponential"
    }

    fn refuses(&self, problem: &Problem<'_>) -> Option<String> {
        let form = eigentone_modes::FirstOrder::of(problem.system());
        if let Err(error) = form {
            return Some(error.to_string());
        }
        let work = work(problem, &LADDER[0]);
        (work > MOST_WORK).then(|| {
            format!("it would take {work:.0e} operations with 32 digits, more than {MOST_WORK:.0e}")
        })
    }

    fn run(&self, problem: &Problem<'_>) -> Result<Trajectory, ResponseError> {
        if let Some(reason) = self.refuses(problem) {
            return Err(ResponseError::NotApplicable {
                method: self.name(),
                reason,
            });
        }
        let tolerance = match problem.precision() {
            Precision::Certified { tolerance } => tolerance,
            Precision::Double => f64::EPSILON,
        };
        let affordable = LADDER
            .iter()
            .filter(|rung| work(problem, rung) <= MOST_WORK);
        let last = affordable.clone().count() - 1;
        for (at, rung) in affordable.enumerate() {
            if let Some(trajectory) = (rung.run)(problem, self.name(), tolerance, at == last)? {
                return Ok(trajectory);
            }
        }
        Err(ResponseError::NotApplicable {
            method: self.name(),
            reason: "no number of digits tells the mass matrix from a singular one".to_owned(),
        })
    }
}

/// The most operations, in units of one with 32 digits.
const MOST_WORK: f64 = 4e10;

/// About how many operations a rung takes, in units of one with 32 digits.
fn work(problem: &Problem<'_>, rung: &Rung) -> f64 {
    let states = 2.0 * problem.system().len() as f64 + problem.loads().len() as f64;
    let instants = match problem.instants() {
        Some(instants) => instants.len() as f64,
        None => problem.grid().last() as f64,
    };
    let steps = instants + problem.timeline().pieces().len() as f64;
    let one = if rung.limbs == 1 {
        1.0
    } else {
        4.0 + (rung.limbs * rung.limbs) as f64 / 8.0
    };
    (60.0 * states.powi(3) + 2.0 * steps * states * states) * one
}
