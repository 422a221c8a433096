//! What the methods damp by themselves, and where they are stable: the facts that their
//! documentation states.

use eigentone_check::{GeneralizedAlpha, HhtAlpha, Integrator, Newmark, RungeKutta4};
use eigentone_modes::{GROUND, System};
use eigentone_response::{Response, ResponseMethod, State};

use super::run;
use crate::scenes;

/// Displacements of free undamped motion from 1 m, one step apart.
fn steps(method: &dyn Integrator, omega: f64, count: u64) -> Vec<f64> {
    let system = scenes::system(1.0, 0.0, omega * omega);
    let response = Response::of(&system).from(State::at_rest().displace("m1", 1.0));
    let problem = response.every(1.0).until(count as f64).problem();
    let answer = run(method, &problem.expect("valid"));
    (0..=count as usize)
        .map(|column| answer.displacement()[(0, column)])
        .collect()
}

/// By ρ∞ in each step where ω h → ∞. The roots coincide there, so that displacements shrink by no
/// less than ρ∞ⁿ and no more than n² ρ∞ⁿ: between steps 200 and 400, by 4^(1/200) ρ∞ at most.
#[test]
fn the_highest_frequencies_shrink_by_the_spectral_radius() {
    let shrinks = |method: &dyn Integrator, radius: f64| {
        let d = steps(method, 1e6, 400);
        let shrunk = (d[400] / d[200]).abs().powf(1.0 / 200.0);
        println!(
            "{}, ρ∞ = {radius}: ρ = {shrunk} at ω h = 1e6",
            method.name()
        );
        assert!((0.999..1.008).contains(&(shrunk / radius)));
    };
    for spectral_radius in [0.25, 0.5, 0.8, 0.95, 1.0] {
        let substeps = 1;
        let method = GeneralizedAlpha {
            substeps,
            spectral_radius,
        };
        shrinks(&method, spectral_radius);
    }
    for radius in [0.5, 0.8, 0.95, 1.0] {
        let method = HhtAlpha::with_spectral_radius(1, radius);
        assert!((method.spectral_radius() - radius).abs() < 1e-15);
        shrinks(&method, radius);
    }
    let all = GeneralizedAlpha {
        substeps: 1,
        spectral_radius: 0.0,
    };
    let d = steps(&all, 1e6, 4);
    assert!(d[4].abs() < 1e-10, "{d:?}");
}

/// Bounded on one side of the limit, growing on the other.
#[test]
fn are_stable_up_to_their_limits() {
    let grows = |method: &dyn Integrator, omega| {
        let largest = steps(method, omega, 500).into_iter();
        largest.fold(0.0, |most: f64, d| most.max(d.abs())) > 1e3
    };
    let limit = |name: &str, method: &dyn Integrator, limit: f64| {
        assert!(!grows(method, 0.998 * limit), "{name}");
        assert!(grows(method, 1.02 * limit), "{name}");
    };
    // |1 + z + z²/2 + z³/6 + z⁴/24| = 1 at z = i 2√2.
    limit("RK4", &RungeKutta4::with_substeps(1), 8f64.sqrt());
    limit("central", &Newmark::central_difference(1), 2.0);
    limit("linear", &Newmark::linear_acceleration(1), 12f64.sqrt());
    for omega in [0.1, 1.0, 10.0, 1e3] {
        assert!(!grows(&Newmark::with_substeps(1), omega));
        assert!(!grows(&HhtAlpha::with_substeps(1), omega));
    }
}

/// How long a period comes out, from the phase after 200 steps of a tenth of a radian or less.
#[test]
fn change_the_period_as_documented() {
    let stretch = |method: &dyn Integrator, omega: f64| {
        // cos ω̃ h from three neighbouring values of a motion that is not damped.
        let d = steps(method, omega, 2);
        let turned = ((d[0] + d[2]) / (2.0 * d[1])).acos();
        (omega / turned - 1.0) / (omega * omega)
    };
    for (method, expected) in [
        (Newmark::with_substeps(1), 1.0 / 12.0),
        (Newmark::linear_acceleration(1), 1.0 / 24.0),
        (Newmark::central_difference(1), -1.0 / 24.0),
    ] {
        let found = stretch(&method, 0.01);
        assert!((found / expected - 1.0).abs() < 1e-3, "{found}, {expected}");
    }
}

/// Average acceleration keeps the energy of an undamped system, whatever the step; here it is 1.5
/// periods of the faster mode. So does generalized-α where ρ∞ = 1, within bounds.
#[test]
fn average_acceleration_keeps_the_energy() {
    let system = System::builder()
        .mass("a", 2.0)
        .mass("b", 0.5)
        .spring(GROUND, "a", 3.0)
        .spring("a", "b", 70.0)
        .build()
        .expect("valid");
    let response = Response::of(&system).from(State::at_rest().displace("a", 1.0).push("b", -3.0));
    let problem = response.every(0.7).until(700.0).problem().expect("valid");
    let (m, k) = (system.mass_matrix(), system.stiffness_matrix());
    let energy = |method: &dyn ResponseMethod| -> Vec<f64> {
        let answer = run(method, &problem);
        let columns = 0..answer.len();
        let energy = columns.map(|column| {
            let (x, v) = (
                answer.displacement().col(column),
                answer.velocity().col(column),
            );
            v.transpose() * &m * v + x.transpose() * &k * x
        });
        energy.collect()
    };
    let kept = energy(&Newmark::with_substeps(1));
    for at in &kept[1..] {
        assert!((at / kept[0] - 1.0).abs() < 1e-11);
    }
    let lost = energy(&HhtAlpha::with_substeps(1));
    assert!(lost[1000] < 0.9 * lost[0]);
}
