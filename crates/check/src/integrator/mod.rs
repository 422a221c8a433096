//! Numerical integrators: methods that are not exact, to be compared with those that are.

mod adaptive;
mod alpha_family;
mod course;
mod dop853;
mod dormand_prince;
mod embedded;
mod equation;
pub(crate) mod fixed_step;
mod generalized_alpha;
mod hht_alpha;
mod implicit_system;
mod interpolation;
mod knob;
mod limit;
mod newmark;
mod number;
mod prediction;
mod radau;
mod runge_kutta;
#[cfg(feature = "stiff")]
mod stiff;
mod work;

use eigentone_response::{Problem, ResponseError, ResponseMethod, Trajectory};

pub(crate) use course::{Stretch, follow};
pub(crate) use equation::{EquationOfMotion, Forces};
pub(crate) use limit::Meter;

pub use dop853::Dop853;
pub use dormand_prince::DormandPrince5;
pub use generalized_alpha::GeneralizedAlpha;
pub use hht_alpha::HhtAlpha;
pub use knob::Knob;
pub use limit::Limit;
pub use newmark::Newmark;
pub use prediction::{Basis, Prediction};
pub use radau::Radau5;
pub use runge_kutta::RungeKutta4;
#[cfg(feature = "stiff")]
pub use stiff::{Bdf, Esdirk34, TrBdf2};
pub use work::Work;

/// A [`ResponseMethod`] that advances in small steps, so that its error depends on a knob and its
/// work can be counted. None of them takes a system with a singular mass matrix. All restart
/// wherever a load changes its law. Outputs and forces in elements are not computed: answers have none.
pub trait Integrator: ResponseMethod {
    /// What its accuracy is set by.
    fn knob(&self) -> Knob;

    /// The motion at the instants asked for, and the work it took.
    ///
    /// # Errors
    /// [`ResponseError::NotApplicable`] where [`refuses`](ResponseMethod::refuses) gives a reason,
    /// [`ResponseError::Stopped`] where the limit is reached first or the steps become too small,
    /// [`ResponseError::Overflow`] and [`ResponseError::TooLarge`].
    fn integrate(
        &self,
        problem: &Problem<'_>,
        limit: Limit,
    ) -> Result<(Trajectory, Work), ResponseError>;

    /// How many steps [`integrate`](Self::integrate) is going to take. Steps of fixed length are
    /// counted without taking any. Where a tolerance sets the length, the first thousand are
    /// tried; if they do not reach the end, a thousand with a looser tolerance, and a thousand with
    /// one that lets them just reach it, and steps that stability does not limit are shortened by
    /// the order of the error. So no more than three thousand steps are taken to find out.
    ///
    /// # Errors
    /// [`ResponseError::NotApplicable`] where [`refuses`](ResponseMethod::refuses) gives a reason,
    /// and what ends a trial early: [`ResponseError::Stopped`] where its steps become too small,
    /// [`ResponseError::Overflow`].
    fn predict(&self, problem: &Problem<'_>) -> Result<Prediction, ResponseError>;
}

/// Says that a method does not apply.
fn refused(method: &'static str) -> impl Fn(String) -> ResponseError {
    move |reason| ResponseError::NotApplicable { method, reason }
}

/// Says that a method gave up.
fn stopped(method: &'static str) -> impl Fn(String) -> ResponseError + Copy {
    move |reason| ResponseError::Stopped { method, reason }
}

/// Makes a scheme of a family (`adaptive` or `fixed_step`) an integrator.
macro_rules! integrator {
    ($method:ty, $family:ident) => {
        impl eigentone_response::ResponseMethod for $method {
            fn name(&self) -> &'static str {
                $family::Scheme::name(self)
            }

            fn refuses(&self, problem: &eigentone_response::Problem<'_>) -> Option<String> {
                $family::equation(self, problem).err()
            }

            fn run(
                &self,
                problem: &eigentone_response::Problem<'_>,
            ) -> Result<eigentone_response::Trajectory, eigentone_response::ResponseError> {
                let limit = crate::integrator::Limit::default();
                Ok($family::integrate(self, problem, limit)?.0)
            }
        }

        impl crate::integrator::Integrator for $method {
            fn knob(&self) -> crate::integrator::Knob {
                $family::knob(self)
            }

            fn integrate(
                &self,
                problem: &eigentone_response::Problem<'_>,
                limit: crate::integrator::Limit,
            ) -> Result<
                (eigentone_response::Trajectory, crate::integrator::Work),
                eigentone_response::ResponseError,
            > {
                $family::integrate(self, problem, limit)
            }

            fn predict(
                &self,
                problem: &eigentone_response::Problem<'_>,
            ) -> Result<crate::integrator::Prediction, eigentone_response::ResponseError> {
                $family::predict(self, problem)
            }
        }
    };
}
use integrator;
