//! Proven discs against answers known to 34 digits.
//!
//! `cargo test --release --test certified -- --nocapture` prints what each one reaches.

#[path = "certified/estimated.rs"]
mod estimated;

mod known;

use std::fmt::Write as _;
use std::sync::LazyLock;

use eigentone::modes::{Bounds, Modes, Precision, System};
use eigentone_digits::ComplexDoubleDouble;
use faer::{Mat, c64};

use known::{KNOWN, Known, Pair, U, none_wrong, pairs, size};

/// What cannot be distinguished from 0, in units of |λ|.
const HIDDEN: f64 = 1e-30;

/// The answers; what has none fails a test of its own.
static FOUND: LazyLock<Vec<(&Known, Modes)>> = LazyLock::new(|| {
    let solved = |known: &'static Known| Some((known, known.scene.system().modes().ok()?));
    KNOWN.iter().filter_map(solved).collect()
});

#[test]
fn every_system_has_modes() {
    let unsolved = KNOWN.iter().filter_map(|known| {
        let error = known.scene.system().modes().err()?;
        Some(format!("{}: {error}", known.name))
    });
    none_wrong(&unsolved.collect::<Vec<String>>());
}

fn each_pair(mut check: impl FnMut(&Pair) -> Result<(), String>) {
    let mut wrong = Vec::new();
    for (known, modes) in FOUND.iter() {
        // Where counts differ another test fails.
        for pair in pairs(&known.truth, modes).into_iter().flatten() {
            if let Err(what) = check(&pair) {
                let (truth, found) = (&pair.truth, pair.found.value);
                wrong.push(format!(
                    "{}: {} {}i found as {found:e}: {what}",
                    known.name, truth.re, truth.im
                ));
            }
        }
    }
    none_wrong(&wrong);
}

fn ensure(holds: bool, what: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(what()) }
}

#[test]
fn every_system_up_to_64_coordinates_is_proven() {
    let unproven = FOUND
        .iter()
        .filter(|(_, modes)| modes.bounds() != Bounds::Proven);
    let wrong: Vec<String> = unproven
        .map(|(known, modes)| format!("{}: {}", known.name, modes.plan()))
        .collect();
    none_wrong(&wrong);
}

#[test]
fn no_eigenvalue_is_missing_and_none_is_invented() {
    let mut wrong = Vec::new();
    for (known, modes) in FOUND.iter() {
        let (all, finite) = (
            2 * known.scene.system().len(),
            known.truth.eigenvalues.len(),
        );
        let found = (modes.eigenvalues().len(), modes.infinite());
        if found != (finite, all - finite) {
            wrong.push(format!(
                "{}: {found:?} of {finite} + {}",
                known.name,
                all - finite
            ));
        }
        let zeros = |count: usize, of: &str, zeros: usize| {
            (count != zeros).then(|| format!("{}: {zeros} zeros {of}, not {count}", known.name))
        };
        let true_zeros = known
            .truth
            .eigenvalues
            .iter()
            .filter(|z| size(z) == 0.0)
            .count();
        let found = modes.eigenvalues().iter();
        let found = found.filter(|z| z.value.norm() == 0.0).count();
        wrong.extend(zeros(true_zeros, "found", found));
    }
    none_wrong(&wrong);
}

#[test]
fn sizes_are_right_to_the_last_digits() {
    each_pair(|pair| {
        ensure(pair.error <= 4.0 * U * pair.size, || {
            format!("{:.1} u", pair.error / pair.size / U)
        })
    });
}

#[test]
fn real_parts_are_right_to_the_last_digits() {
    each_pair(|pair| {
        let found = pair.found.value.re;
        if pair.re == 0.0 {
            ensure(found == 0.0, || "Re λ = 0".to_owned())
        } else if pair.re.abs() <= HIDDEN * pair.size {
            ensure(pair.real_error <= HIDDEN * pair.size, || {
                "Re λ ≈ 0".to_owned()
            })
        } else {
            ensure(pair.real_error <= 8.0 * U * pair.re.abs(), || {
                format!("{:.1} u in Re λ", pair.real_error / pair.re.abs() / U)
            })
        }
    });
}

#[test]
fn bounds_hold() {
    each_pair(|pair| {
        let bound = pair.found.bound.ok_or("no bound")?;
        let real_bound = pair.found.real_bound.ok_or("no bound of Re λ")?;
        ensure(pair.error <= bound, || {
            format!("{:e} > {bound:e}", pair.error)
        })?;
        ensure(pair.real_error <= real_bound, || {
            format!("{:e} > {real_bound:e} in Re λ", pair.real_error)
        })
    });
}

#[test]
fn bounds_say_something() {
    each_pair(|pair| {
        let bound = pair.found.bound.ok_or("no bound")?;
        let real_bound = pair.found.real_bound.ok_or("no bound of Re λ")?;
        ensure(bound <= 1e-13 * pair.size, || {
            format!("bound {:e} of |λ|", bound / pair.size)
        })?;
        let real_size = if pair.re.abs() <= HIDDEN * pair.size {
            HIDDEN * pair.size
        } else {
            1e-13 * pair.re.abs()
        };
        ensure(real_bound <= real_size, || {
            format!("bound {:e} of |Re λ|", real_bound / pair.re.abs())
        })
    });
}

/// ‖Q(λ)x‖ / ((|λ|²‖M‖ + |λ|‖C‖ + ‖K‖)‖x‖) with Frobenius norms, from double-doubles.
fn backward_error(matrices: &[Mat<f64>; 3], value: c64, shape: &[c64]) -> f64 {
    let exact = |z: c64| ComplexDoubleDouble::new(z.re, z.im);
    let lambda = exact(value);
    let powers = [lambda * lambda, lambda, exact(1.0.into())];
    let mut residual = 0.0_f64;
    for i in 0..shape.len() {
        let mut sum = exact(0.0.into());
        for (matrix, power) in matrices.iter().zip(powers) {
            for (j, x) in shape.iter().enumerate() {
                if matrix[(i, j)] != 0.0 {
                    sum += power * exact(*x) * exact(matrix[(i, j)].into());
                }
            }
        }
        residual = residual.hypot(sum.re.to_f64()).hypot(sum.im.to_f64());
    }
    let norm = shape.iter().fold(0.0_f64, |sum, x| sum.hypot(x.norm()));
    let at = value.norm();
    let [m, c, k] = matrices.each_ref().map(|matrix| matrix.norm_l2());
    // Where K = 0, λ = 0 meets its equation exactly.
    if residual == 0.0 {
        return 0.0;
    }
    residual / ((at * at * m + at * c + k) * norm)
}

fn matrices(system: &System) -> [Mat<f64>; 3] {
    [
        system.mass_matrix(),
        system.damping_matrix(),
        system.stiffness_matrix(),
    ]
}

/// Everything wrong with the shapes of one answer; defective roots have one each.
fn wrong_shapes(name: &str, system: &System, modes: &Modes) -> Vec<String> {
    let matrices = matrices(system);
    let symmetric = system.structure().is_symmetric();
    let adjoint = matrices
        .each_ref()
        .map(|matrix| matrix.transpose().to_owned());
    let mut wrong = Vec::new();
    let mut check = |what: &str, error: f64| {
        if error.is_nan() || error > 20.0 * U {
            wrong.push(format!("{name}: {what}: {:.1} u", error / U));
        }
    };
    for mode in modes {
        let value = mode.eigenvalue().value;
        check(
            &format!("shape at {value:e}"),
            backward_error(&matrices, value, mode.shape()),
        );
        check(
            &format!("its own figure at {value:e}"),
            mode.backward_error(),
        );
        // Those of symmetric systems are the conjugates of the shapes.
        if let (false, Some(left)) = (symmetric, mode.left_shape()) {
            // y*Q(λ) = 0 is Q(λ̄)ᵀ y = 0.
            assert_eq!(left.len(), system.len(), "{name}: left shape at {value:e}");
            let error = backward_error(&adjoint, value.conj(), left);
            check(&format!("left shape at {value:e}"), error);
        }
    }
    wrong
}

#[test]
fn shapes_solve_a_system_close_by() {
    let wrong: Vec<String> = FOUND
        .iter()
        .flat_map(|(known, modes)| wrong_shapes(&known.name, known.scene.system(), modes))
        .collect();
    none_wrong(&wrong);
}

#[test]
fn doubles_solve_a_system_close_by() {
    let mut wrong = Vec::new();
    for known in KNOWN.iter().filter(|known| known.in_gallery) {
        let system = known.scene.system();
        let modes = system.modes_to(Precision::Double).expect(&known.name);
        assert_eq!(modes.bounds(), Bounds::Estimated);
        wrong.extend(wrong_shapes(&known.name, system, &modes));
    }
    none_wrong(&wrong);
}

#[test]
fn listing() {
    let mut text = String::from(
        "\nscene                     proven    |λ|/u   Re λ/u  of bound  bound/|λ|  bound/|Re λ|\n",
    );
    for (known, modes) in FOUND.iter() {
        let mut most = [0.0_f64; 5];
        for pair in pairs(&known.truth, modes).into_iter().flatten() {
            let of = |part: f64, whole: f64| if part == 0.0 { 0.0 } else { part / whole };
            let bound = pair.found.bound.unwrap_or(f64::NAN);
            let real_bound = pair.found.real_bound.unwrap_or(f64::NAN);
            let each = [
                of(pair.error, pair.size) / U,
                of(pair.real_error, pair.re.abs()) / U,
                of(pair.error, bound).max(of(pair.real_error, real_bound)),
                of(bound, pair.size),
                of(real_bound, pair.re.abs()),
            ];
            for (most, each) in most.iter_mut().zip(each) {
                *most = most.max(each);
            }
        }
        let [error, real, of_bound, bound, real_bound] = most;
        let proven = modes.bounds() == Bounds::Proven;
        let name = &known.name;
        writeln!(
            text,
            "{name:25} {proven:6} {error:>8.2} {real:>8.2} {of_bound:>9.2} {bound:>10.1e} {real_bound:>13.1e}"
        )
        .expect("strings take text");
    }
    println!("{text}");
}
