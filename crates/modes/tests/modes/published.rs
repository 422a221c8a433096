//! Numbers printed in verification manuals and papers. VM is the ANSYS Mechanical APDL Verification
//! Manual, SDLD the guide of VPCS and Code_Aster.

use std::f64::consts::PI;

use eigentone_modes::{Modes, System};
use faer::{Mat, MatRef, mat};

use crate::root::{Join, network};

fn hertz(modes: &Modes) -> Vec<f64> {
    let hertz = |mode: &eigentone_modes::Mode| mode.natural_frequency().hertz();
    modes.iter().map(hertz).collect()
}

fn assert_close(found: &[f64], printed: &[f64], relative: f64) {
    assert_eq!(found.len(), printed.len());
    for (found, printed) in found.iter().zip(printed) {
        let off = (found - printed).abs() / printed.abs();
        assert!(off <= relative, "{found} for {printed}: {off:e}");
    }
}

#[test]
fn vm45_spring_and_mass() {
    let system = network(&[0.006477], &[(0, 1, 48.0)], &[]);
    assert_close(&hertz(&system.modes().expect("modes")), &[13.701], 1e-5);
}

#[test]
fn vm47_torsional_pendulum() {
    let system = network(&[0.30312], &[(0, 1, 4.8)], &[]);
    assert_close(&hertz(&system.modes().expect("modes")), &[0.63333], 1e-5);
}

#[test]
fn vm52_half_car() {
    // Bounce and pitch about the centre of mass, springs 4.5 ahead and 5.5 behind.
    let coupling = 2600.0 * 5.5 - 2400.0 * 4.5;
    let pitch = 2400.0 * 4.5 * 4.5 + 2600.0 * 5.5 * 5.5;
    let system = System::from_matrices(
        mat![[100.0, 0.0], [0.0, 1600.0]].as_ref(),
        Mat::zeros(2, 2).as_ref(),
        mat![[2400.0 + 2600.0, coupling], [coupling, pitch]].as_ref(),
    );
    let modes = system.expect("a regular system").modes().expect("modes");
    assert_close(&hertz(&modes), &[1.0981, 1.4406], 3e-5);
}

/// Eight masses of 10 kg between nine springs of 1e5 N/m.
fn chain_of_eight(dampers: &[f64]) -> System {
    let joins = |values: &[f64]| -> Vec<Join> {
        let join = |(i, value): (usize, &f64)| (i, (i + 1) % 9, *value);
        values.iter().enumerate().map(join).collect()
    };
    network(&[10.0; 8], &joins(&[1e5; 9]), &joins(dampers))
}

#[test]
fn sdld02_fixed_chain() {
    let exact: Vec<f64> = (1..=8)
        .map(|j| 100.0 / PI * (f64::from(j) * PI / 18.0).sin())
        .collect();
    let modes = chain_of_eight(&[]).modes().expect("modes");
    assert_close(&hertz(&modes), &exact, 1e-15);
}

#[test]
fn sdld27_chain_without_modal_damping() {
    let dampers = [250.0, 50.0, 50.0, 50.0, 50.0, 50.0, 50.0, 50.0, 25.0];
    let system = chain_of_eight(&dampers);
    assert!(!system.structure().is_classical());
    let modes = system.modes().expect("modes");
    // Printed are damped frequencies, and −Re λ/Im λ in place of the damping ratio.
    let damped: Vec<f64> = modes
        .iter()
        .map(|mode| mode.damped_frequency().hertz())
        .collect();
    let printed = [5.53, 10.90, 15.93, 20.45, 24.34, 27.49, 29.84, 31.29];
    assert_close(&damped, &printed, 5e-4);
    let ratio = |mode: &eigentone_modes::Mode| {
        mode.decay_rate() / mode.damped_frequency().radians_per_second()
    };
    let ratios: Vec<f64> = modes.iter().map(ratio).collect();
    let printed = [
        0.01521, 0.02877, 0.03960, 0.04709, 0.05098, 0.05183, 0.05115, 0.05036,
    ];
    assert_close(&ratios, &printed, 1.4e-3);
}

/// Meijaard, Papadopoulos, Ruina & Schwab 2007, *Proc. R. Soc. A* 463, the benchmark bicycle at
/// speed v in m/s.
fn bicycle(v: f64) -> System {
    let mass = mat![
        [80.81722, 2.31941332208709],
        [2.31941332208709, 0.29784188199686]
    ];
    let damping = mat![
        [0.0, 33.86641391492494],
        [-0.85035641456978, 1.68540397397560]
    ];
    let gravity = mat![
        [-80.95, -2.59951685249872],
        [-2.59951685249872, -0.80329488458618]
    ];
    let speed = mat![[0.0, 76.59734589573222], [0.0, 2.65431523794604]];
    let scaled =
        |matrix: MatRef<'_, f64>, factor: f64| Mat::from_fn(2, 2, |i, j| factor * matrix[(i, j)]);
    let stiffness = scaled(gravity.as_ref(), 9.81) + scaled(speed.as_ref(), v * v);
    let damping = scaled(damping.as_ref(), v);
    System::from_matrices(mass.as_ref(), damping.as_ref(), stiffness.as_ref())
        .expect("a regular system")
}

fn assert_eigenvalues(v: f64, printed: &[(f64, f64)]) {
    let modes = bicycle(v).modes().expect("modes");
    let found: Vec<(f64, f64)> = modes
        .eigenvalues()
        .iter()
        .map(|root| (root.value.re, root.value.im))
        .collect();
    assert_eq!(found.len(), printed.len());
    for ((re, im), (printed_re, printed_im)) in found.iter().zip(printed) {
        let off = (re - printed_re).hypot(im - printed_im) / printed_re.hypot(*printed_im);
        assert!(off <= 2e-11, "{re} {im} at v = {v}: {off:e}");
    }
}

#[test]
fn a_bicycle_at_rest_falls_over() {
    let printed = [
        (-3.13164324790656, 0.0),
        (3.13164324790656, 0.0),
        (-5.53094371765393, 0.0),
        (5.53094371765393, 0.0),
    ];
    assert_eigenvalues(0.0, &printed);
}

#[test]
fn a_bicycle_at_five_metres_a_second_stays_up() {
    let printed = [
        (-0.32286642900409, 0.0),
        (-0.77534188219585, 4.46486771378823),
        (-0.77534188219585, -4.46486771378823),
        (-14.07838969279822, 0.0),
    ];
    assert_eigenvalues(5.0, &printed);
}
