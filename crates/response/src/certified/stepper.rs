//! What the march from instant to instant and those who follow the motion between them have in common: the system with 32
//! digits, and its unit step with all its halves.

use std::marker::PhantomData;
use std::sync::{Arc, OnceLock};

use eigentone_digits::{DoubleDouble, Magnitude, Real, Wide};

use super::generator::Generator;
use crate::enclosed::{Halves, Normed};
use crate::problem::Problem;

/// The system of a problem, and its unit step where that takes no longer than a moment.
#[derive(Clone)]
pub(super) struct Stepper<T> {
    pub(super) generator: Arc<Generator<T>>,
    pub(super) unit: Option<Arc<Unit<T>>>,
}

/// A system computed in the arithmetic of G: `None` where the digits do not suffice to divide by the masses.
struct Shared<G>(Option<Stepper<DoubleDouble>>, PhantomData<fn() -> G>);

impl<T: Real> Stepper<T> {
    /// That of a problem, computed in the arithmetic of G, for one use. `None` where the digits do not suffice to divide by the
    /// masses.
    pub(super) fn of<G: Real>(problem: &Problem<'_>) -> Option<Stepper<T>> {
        let generator = Arc::new(Generator::of_moving::<G>(problem)?);
        let unit = None;
        Some(Stepper { generator, unit })
    }
}

impl Stepper<DoubleDouble> {
    /// The same, kept for all who ask for it.
    pub(super) fn shared<G: Real>(problem: &Problem<'_>) -> Option<Stepper<DoubleDouble>> {
        let make = || {
            let unit = is_quick(problem).then(Arc::default);
            Some(Stepper {
                unit,
                ..Stepper::of::<G>(problem)?
            })
        };
        let shared = problem.kept(|| Shared::<G>(make(), PhantomData));
        shared.0.clone()
    }

    /// The same, computed with more digits where what is not known of it would come to more than `lost` in all the time, or where
    /// the march has made its step with them.
    pub(super) fn precise(problem: &Problem<'_>, lost: f64) -> Option<Stepper<DoubleDouble>> {
        let wide = problem.found::<Shared<Wide<4>>>();
        let with_step =
            |stepper: &&Stepper<_>| stepper.unit.as_ref().is_some_and(|unit| unit.is_made());
        if let Some(stepper) = wide
            .as_ref()
            .and_then(|wide| wide.0.as_ref())
            .filter(with_step)
        {
            return Some(stepper.clone());
        }
        let stepper = Stepper::shared::<DoubleDouble>(problem)?;
        let end = Magnitude::from(problem.grid().time(problem.grid().last()));
        match (stepper.generator.w.error() * end).to_f64() > lost {
            true => Stepper::shared::<Wide<4>>(problem),
            false => Some(stepper),
        }
    }
}

/// Whether the exponential of a step takes no longer than a moment with 32 digits.
pub(super) fn is_quick(problem: &Problem<'_>) -> bool {
    /// In products.
    const MOST_AT_ONCE: f64 = 2e9;
    let states = 2.0 * problem.system().len() as f64;
    64.0 * states.powi(3) <= MOST_AT_ONCE
}

/// The step from which the march makes all others.
pub(super) struct Unit<T>(OnceLock<Option<Chain<T>>>);

impl<T> Default for Unit<T> {
    fn default() -> Unit<T> {
        Unit(OnceLock::new())
    }
}

/// A step, and the halves that its exponential is made of.
pub(super) struct Chain<T> {
    length: T,
    pub(super) halves: Arc<Halves<T>>,
    /// [`Halves::squares`].
    pub(super) squares: Vec<Normed<T>>,
}

impl<T: Real> Unit<T> {
    /// That of τ, which is known to a relative error, made when it is first asked for. `None` where there is too much of it to
    /// be kept, and of any other time than the first.
    pub(super) fn chain(&self, w: &Normed<T>, tau: T, error: Magnitude) -> Option<&Chain<T>> {
        /// Beyond so many squares most of 32 digits are lost.
        const MOST_SQUARES: usize = 32;
        let make = || {
            let halves = Halves::of(w, tau, error)?;
            (halves.ground() <= MOST_SQUARES).then(|| Chain {
                length: tau,
                squares: halves.squares(),
                halves: Arc::new(halves),
            })
        };
        let chain = self.0.get_or_init(make).as_ref()?;
        (chain.length == tau).then_some(chain)
    }

    fn is_made(&self) -> bool {
        self.0.get().is_some()
    }

    /// What has been made, if it is of this length.
    pub(super) fn known(&self, length: T) -> Option<&Chain<T>> {
        let chain = self.0.get()?.as_ref()?;
        (chain.length == length).then_some(chain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::Drive;
    use crate::{ByCertifiedExponential, Load, Response, ResponseMethod, State, Summary};
    use eigentone_modes::{ElementKind, Form, GROUND, System};

    /// A problem that becomes another after it was answered is answered as that other.
    #[test]
    fn nothing_is_kept_of_another_problem() {
        let system = System::builder().mass("m", 1.0);
        let system = system.spring(GROUND, "m", 4.0).named("s");
        let system = system.build().expect("a system");
        let problem = |drives: Vec<Drive>| {
            let from = State::at_rest().displace("m", 1.0);
            let ask = Response::of(&system).from(from).every(0.5).until(4.0);
            ask.problem()
                .and_then(|problem| problem.driven(drives))
                .expect("a problem")
        };
        let run = |problem: &Problem<'_>| ByCertifiedExponential.run(problem).expect("a motion");
        let force = || Drive::Force {
            index: 0,
            on: Form {
                coordinates: vec![(0, 1.0)],
                ..Form::default()
            },
            load: Load::from(crate::Step::of(4.0)),
        };
        let free = problem(Vec::new());
        let alone = run(&free);
        let forced = run(&free.driven(vec![force()]).expect("a problem"));
        assert_eq!(
            forced.displacement(),
            run(&problem(vec![force()])).displacement()
        );
        assert!(forced.displacement() != alone.displacement());
        let asked = problem(Vec::new());
        run(&asked);
        let pulled = run(&asked.with_forces());
        let pull = pulled.force(ElementKind::Spring, 0).expect("a spring")[1];
        assert!((pull.abs() - 4.0 * 1f64.cos()).abs() < 1e-15, "{pull}");
    }

    /// What follows the motion takes over the steps of the march: it finds what it finds by itself.
    #[test]
    fn steps_that_are_shared_show_the_same_peaks() {
        let system = System::builder().mass("a", 1.0).mass("b", 2.0);
        let system = system.spring(GROUND, "a", 30.0).spring("a", "b", 20.0);
        let system = system.damper("a", "b", 0.3).build().expect("a system");
        let problem = || {
            let ask = Response::of(&system).from(State::at_rest().displace("a", 1.0));
            ask.every(0.1).until(4.0).problem().expect("a problem")
        };
        let (answered, new) = (problem(), problem());
        let motion = ByCertifiedExponential.run(&answered).expect("a motion");
        let modes = system.modes().expect("modes");
        let peaks = |problem: &Problem<'_>| {
            let summary = Summary::of(problem, &motion, &modes).expect("instants");
            format!("{:?}", summary.extrema())
        };
        assert_eq!(peaks(&answered), peaks(&new));
    }
}
