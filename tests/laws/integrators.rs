//! DOP853 and the exact response agree on the gallery. They share nothing but the equation of
//! motion.
//!
//! `cargo test --release --test laws integrators -- --nocapture` prints how far apart they are.

use eigentone::check::{Dop853, Integrator, Limit};
use eigentone::gallery::cases;
use eigentone::response::ResponsePlan;
use faer::MatRef;

/// Four scenes are too stiff or too long for an explicit method.
const STEPS: f64 = 1e5;

/// The largest difference, relative to the peak.
fn distance(values: MatRef<'_, f64>, exact: MatRef<'_, f64>) -> f64 {
    (values - exact).norm_max() / exact.norm_max()
}

#[test]
fn dop853_and_the_exact_response_agree() {
    let dop853 = Dop853::with_tolerance(1e-13);
    let (mut compared, mut left_out) = (0, Vec::new());
    for case in cases() {
        let scene = case.scene();
        let Some(problem) = scene.problem() else {
            continue;
        };
        let problem = problem.expect("valid");
        let prediction = dop853.predict(&problem).expect("has mass everywhere");
        if prediction.steps > STEPS {
            left_out.push(case.name());
            continue;
        }
        let exact = ResponsePlan::of(&problem).and_then(|plan| plan.run(&problem));
        let exact = exact.expect("every scene of the gallery has its response");
        let (answer, work) = dop853
            .integrate(&problem, Limit::default())
            .expect("so few steps suffice");
        let displacement = distance(answer.displacement(), exact.displacement());
        let velocity = distance(answer.velocity(), exact.velocity());
        println!(
            "{:<26} {displacement:.1e} of the displacement, {velocity:.1e} of the velocity, \
             {} steps, {} predicted",
            case.name(),
            work.accepted + work.rejected,
            prediction.steps.round()
        );
        assert!(displacement < 5e-12 && velocity < 5e-12);
        compared += 1;
    }
    println!("left out: {left_out:?}");
    assert_eq!((compared, left_out.len()), (20, 4));
}
