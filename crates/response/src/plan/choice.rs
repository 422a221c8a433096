//! Which method answers a problem, what is left out, and why.

use std::fmt;
use std::ptr;
use std::sync::Arc;

use eigentone_modes::{Precision, System, dense_gigabytes};

use crate::answer::{ResponseMethod, Trajectory};
use crate::certified::ByCertifiedExponential;
use crate::march::{ByExponential, BySuperposition, Exponential, Superposition};
use crate::problem::{Problem, ResponseError};

/// The choice of a response method, as a value that can be printed and run.
#[derive(Clone)]
pub struct ResponsePlan {
    /// The method that runs.
    pub method: &'static dyn ResponseMethod,
    /// Why it is the right one.
    pub reason: String,
    /// What the problem does not need: a name, and the reason it is left out.
    pub left_out: Vec<(&'static str, String)>,
    found: Found,
    /// A clone of the system, which shares what is proved.
    system: System,
}

/// What was found of the system to choose.
#[derive(Clone)]
enum Found {
    Nothing,
    /// The modes by which superposition applies.
    Modes(Superposition),
    /// The form of which the exponential is taken.
    Form(Arc<Exponential>),
}

/// Every exact method, in the order in which the plan prefers them where they apply well: the
/// certified one, then those in doubles.
///
/// ```
/// use eigentone_modes::{GROUND, System};
/// use eigentone_response::{Response, State, methods};
///
/// let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 1.0).build()?;
/// let from = State::at_rest().displace("m", 1.0);
/// let problem = Response::of(&system).from(from).every(0.5).until(10.0).problem()?;
/// for method in methods() {
///     if method.refuses(&problem).is_none() {
///         let end = method.run(&problem)?.displacement()[(0, 20)];
///         assert!((end - 10f64.cos()).abs() < 1e-14, "{}", method.name());
///     }
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn methods() -> &'static [&'static dyn ResponseMethod] {
    &[&ByCertifiedExponential, &BySuperposition, &ByExponential]
}

impl ResponsePlan {
    /// Picks a method for the problem. Where bounds are to be proven, the certified exponential, wherever its work can be
    /// afforded; else superposition where the damping is proved to be classical,
    /// or where the system is so stiff that rounding its state matrix would cost digits; else the
    /// exponential in doubles.
    ///
    /// # Errors
    /// [`ResponseError::NotApplicable`] where no exact method applies, [`ResponseError::Large`] for
    /// a [large](eigentone_modes::System::is_large) system.
    pub fn of(problem: &Problem<'_>) -> Result<ResponsePlan, ResponseError> {
        let coordinates = problem.system().len();
        if problem.system().is_large() {
            return Err(ResponseError::Large {
                coordinates,
                gigabytes: dense_gigabytes(coordinates),
            });
        }
        let system = problem.system().clone();
        let mut left_out = Vec::new();
        if let Precision::Certified { .. } = problem.precision() {
            match ByCertifiedExponential.refuses(problem) {
                None => {
                    let reason = "its bounds would be estimates".to_owned();
                    left_out.push((BySuperposition.name(), reason.clone()));
                    left_out.push((ByExponential.name(), reason));
                    return Ok(ResponsePlan {
                        method: &ByCertifiedExponential,
                        reason: "proven bounds, with as many digits as they take".to_owned(),
                        left_out,
                        found: Found::Nothing,
                        system,
                    });
                }
                Some(reason) => left_out.push((ByCertifiedExponential.name(), reason)),
            }
        }
        let structure = problem.system().structure();
        let classical = structure.is_undamped() || structure.is_classical();
        let form = (!classical).then(|| Exponential::of(problem.system()).ok());
        let form = form.flatten();
        let is_stiff = |form: &Exponential| form.is_stiff(problem.grid());
        let reason = if classical {
            Some("each real mode moves by itself, in O(n) a step")
        } else if form.as_ref().is_some_and(is_stiff) {
            Some("stiff: rounding the state matrix would cost digits, the modes keep them")
        } else {
            None
        };
        match reason.map(|reason| (reason, Superposition::of(problem))) {
            Some((reason, Ok(found))) => {
                left_out.push((ByExponential.name(), "not needed".to_owned()));
                return Ok(ResponsePlan {
                    method: &BySuperposition,
                    reason: reason.to_owned(),
                    left_out,
                    found: Found::Modes(found),
                    system,
                });
            }
            Some((_, Err(refusal))) => {
                left_out.push((BySuperposition.name(), refusal.to_string()));
            }
            None => {
                let reason = "the damping couples the real modes".to_owned();
                left_out.push((BySuperposition.name(), reason));
            }
        }
        let refusal = match form {
            Some(_) => None,
            None => ByExponential.refuses(problem),
        };
        match refusal {
            Some(reason) => Err(ResponseError::NotApplicable {
                method: ByExponential.name(),
                reason,
            }),
            None => {
                let reason = "exact for any damping, one exponential for each length of step";
                Ok(ResponsePlan {
                    method: &ByExponential,
                    reason: reason.to_owned(),
                    left_out,
                    found: form.map_or(Found::Nothing, |form| Found::Form(Arc::new(form))),
                    system,
                })
            }
        }
    }

    /// Answers the problem by the method picked. What the choice found of the modes is used again.
    ///
    /// # Errors
    /// What the method reports.
    pub fn run(&self, problem: &Problem<'_>) -> Result<Trajectory, ResponseError> {
        let is_for = |method| {
            self.method.name() == method
                && ptr::eq(self.system.structure(), problem.system().structure())
        };
        match &self.found {
            Found::Modes(found) if is_for(BySuperposition.name()) => found.run(problem),
            Found::Form(found) if is_for(ByExponential.name()) => found.run(problem),
            _ => self.method.run(problem),
        }
    }
}

impl fmt::Debug for ResponsePlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ResponsePlan")
            .field("method", &self.method.name())
            .field("reason", &self.reason)
            .field("left_out", &self.left_out)
            .finish_non_exhaustive()
    }
}

impl fmt::Display for ResponsePlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "response by {}: {}", self.method.name(), self.reason)?;
        for (name, reason) in &self.left_out {
            write!(f, "\nleft out {name}: {reason}")?;
        }
        Ok(())
    }
}
