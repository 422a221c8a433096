//! What the methods damp by themselves, and where they are stable: the facts that their
//! documentation states.

use eigentone_check::{
    DormandPrince5, GeneralizedAlpha, HhtAlpha, Integrator, Knob, Limit, Newmark, Radau5,
    RungeKutta4,
};
use eigentone_response::{Hold, Response, ResponseMethod, Samples, State};

use super::run;
use crate::row::in_a_row;
use crate::scenes;

/// Displacements of free undamped motion from 1 m, one step apart. A load that moves nothing by as much as rounding does, sampled
/// at every instant, makes methods of adaptive step end one there.
fn steps(method: &dyn Integrator, omega: f64, count: u64) -> Vec<f64> {
    let system = scenes::system(1.0, 0.0, omega * omega);
    let nothing = Samples {
        step: 1.0,
        values: vec![1e-290; count as usize],
        hold: Hold::Zero,
    };
    let mut response = Response::of(&system).from(State::at_rest().displace("m1", 1.0));
    if let Knob::Tolerance(_) = method.knob() {
        response = response.load("m1", nothing);
    }
    let problem = response.every(1.0).until(count as f64).problem();
    let answer = method.integrate(&problem.expect("valid"), Limit::default());
    let (answer, work) = answer.expect("applies");
    assert_eq!(work.accepted + work.rejected, count);
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

/// The damping ratio that a method gives to undamped motion of ω h, and how much longer its periods
/// come out: from d(n+1) = 2 r cos θ d(n) − r² d(n−1), which displacements follow once what a method
/// has besides the two roots r e^(±iθ) has died down.
fn damping_and_stretch(method: &dyn Integrator, omega: f64) -> (f64, f64) {
    let steps = steps(method, omega, 60);
    let d: [f64; 4] = steps[56..60].try_into().expect("four");
    let determinant = d[0] * d[2] - d[1] * d[1];
    let twice = (d[0] * d[3] - d[1] * d[2]) / determinant;
    let square = (d[1] * d[3] - d[2] * d[2]) / determinant;
    let decay = -0.5 * square.ln();
    let angle = (0.5 * twice / square.sqrt()).acos();
    (decay / decay.hypot(angle), omega / angle - 1.0)
}

/// In proportion to powers of ω h, with the factors that the documentation states.
#[test]
fn damp_and_stretch_as_documented() {
    let factors = |method: &dyn Integrator, omega: f64, of_damping: i32, of_stretch: i32| {
        let (damping, stretch) = damping_and_stretch(method, omega);
        [
            damping / omega.powi(of_damping),
            stretch / omega.powi(of_stretch),
        ]
    };
    let near = |found: f64, documented: f64| (found / documented - 1.0).abs() < 0.02;
    for (method, stretch) in [
        (Newmark::with_substeps(1), 1.0 / 12.0),
        (Newmark::linear_acceleration(1), 1.0 / 24.0),
        (Newmark::central_difference(1), -1.0 / 24.0),
    ] {
        let found = factors(&method, 0.05, 3, 2);
        assert!(
            found[0].abs() < 1e-8 && near(found[1], stretch),
            "{found:?}"
        );
    }
    for radius in [0.5, 0.6, 0.8, 0.9] {
        let alpha: f64 = (1.0 - radius) / (1.0 + radius);
        let found = factors(&HhtAlpha::with_spectral_radius(1, radius), 0.05, 3, 2);
        assert!(near(found[0], alpha * (1.0 - alpha).powi(2) / 8.0));
        let stretch = 1.0 / 12.0 + alpha * (2.0 - 3.0 * alpha) / 8.0;
        assert!(near(found[1], stretch), "{found:?}");
    }
    for spectral_radius in [0.0, 0.5, 0.8] {
        let substeps = 1;
        let method = GeneralizedAlpha {
            substeps,
            spectral_radius,
        };
        let s: f64 = (1.0 - spectral_radius) / (1.0 + spectral_radius);
        let found = factors(&method, 0.05, 3, 2);
        assert!(near(found[0], s.powi(3) / 2.0), "{found:?}");
        assert!(near(found[1], 1.0 / 12.0 + 3.0 * s * s / 8.0), "{found:?}");
    }
    let found = factors(&RungeKutta4::with_substeps(1), 0.1, 5, 4);
    assert!(near(found[0], 1.0 / 144.0) && near(found[1], 1.0 / 120.0));
    let found = factors(&DormandPrince5::with_tolerance(1.0), 0.1, 5, 4);
    assert!(near(found[0], 1.0 / 3600.0), "{found:?}");
    let found = factors(&Radau5::with_tolerance(1.0), 0.1, 5, 4);
    assert!(near(found[0], 1.0 / 7200.0), "{found:?}");
}

/// Average acceleration keeps the energy of an undamped system, whatever the step; here it is 1.5
/// periods of the faster mode. HHT-α loses some.
#[test]
fn average_acceleration_keeps_the_energy() {
    let system = in_a_row(&[("a", 2.0), ("b", 0.5)], &[3.0, 70.0], &[]);
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
