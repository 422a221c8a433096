//! Numbers printed in verification manuals and papers, beside the exact ones. docs/validation.md shows
//! every row; it is compared with what is computed here.
//!
//! VM is the ANSYS Mechanical APDL Verification Manual, SDLD the guide of VPCS and Code_Aster; units are
//! coherent. What they print is rounded, or was computed numerically: each row states how far the exact
//! value lies from it, relative to the printed number. That distance is known to one digit, and half of
//! that digit is allowed for.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;

use eigentone::prelude::*;
use eigentone::response::receptance;
use faer::{Mat, MatRef, mat};

/// One printed number, or the parts of a complex one.
struct Row {
    source: &'static str,
    case: String,
    printed: Vec<&'static str>,
    found: Vec<f64>,
    /// Of each part, absolute: proven.
    bound: f64,
    /// Relative to the printed number.
    allowed: f64,
}

impl Row {
    /// How far the exact value is from the printed one, relative to it.
    fn off(&self) -> f64 {
        let printed: Vec<f64> = self
            .printed
            .iter()
            .map(|text| text.parse().expect("a number"))
            .collect();
        let off = self
            .found
            .iter()
            .zip(&printed)
            .map(|(found, printed)| (found - printed).powi(2));
        let size = printed.iter().map(|printed| printed * printed);
        (off.sum::<f64>() / size.sum::<f64>()).sqrt()
    }

    /// The same in units of the last printed digit, for the worst part.
    fn units(&self) -> f64 {
        let each = self.printed.iter().zip(&self.found).map(|(text, found)| {
            let (digits, power) = text.split_once('e').unwrap_or((text, "0"));
            let decimals = digits
                .split_once('.')
                .map_or(0, |(_, decimals)| decimals.len());
            let unit = 10f64.powi(power.parse::<i32>().expect("a power") - decimals as i32);
            (found - text.parse::<f64>().expect("a number")).abs() / unit
        });
        each.fold(0.0, f64::max)
    }

    fn check(&self) {
        let off = self.off();
        assert!(
            off <= self.allowed,
            "{} {}: {:?} for {:?}: {off:.1e}",
            self.source,
            self.case,
            self.found,
            self.printed
        );
        assert!(
            self.bound
                <= 1e-14
                    * self
                        .found
                        .iter()
                        .fold(0.0, |most: f64, x| most.max(x.abs()))
        );
    }

    fn line(&self) -> String {
        let digits = |(x, printed): (&f64, &&str)| {
            let mantissa = printed.split('e').next().unwrap_or("");
            let printed = mantissa.chars().filter(char::is_ascii_digit).count();
            significant(*x, (printed + 2).clamp(10, 17))
        };
        let exact: Vec<String> = self.found.iter().zip(&self.printed).map(digits).collect();
        let size = self
            .found
            .iter()
            .fold(0.0, |most: f64, x| most.max(x.abs()));
        let (off, units) = (self.off(), self.units());
        let less = |(x, printed): (&f64, &&str)| {
            let printed: f64 = printed.parse().expect("a number");
            x.abs() > printed.abs()
        };
        let verdict = match units {
            u if u <= 0.5 => "rounded".to_owned(),
            u if u < 1.0 && self.found.iter().zip(&self.printed).all(less) => "cut off".to_owned(),
            u if u < 9.95 => format!("off by {u:.1} units"),
            u => format!("off by {u:.0} units"),
        };
        let off = if off < 1e-15 {
            "0".to_owned()
        } else {
            power(off)
        };
        let proven = if self.bound == 0.0 {
            "exact".to_owned()
        } else {
            power(self.bound / size)
        };
        format!(
            "| {} | {} | {} | {proven} | {off} | {verdict} |",
            self.case
                .rsplit_once(": ")
                .map_or(&*self.case, |(_, quantity)| quantity),
            complex(&self.printed),
            complex(&exact)
        )
    }
}

/// A number with so many significant digits.
fn significant(x: f64, digits: usize) -> String {
    let power = x.abs().log10().floor() as i32;
    if (-3..6).contains(&power) {
        format!("{x:.*}", (digits as i32 - 1 - power) as usize)
    } else {
        format!("{x:.*e}", digits - 1)
    }
}

/// One significant digit, rounded up.
fn power(x: f64) -> String {
    let exponent = x.log10().floor() as i32;
    match (x / 10f64.powi(exponent)).ceil() {
        10.0 => format!("1e{}", exponent + 1),
        digit => format!("{digit}e{exponent}"),
    }
}

fn complex(parts: &[impl AsRef<str>]) -> String {
    match parts {
        [re, im] => {
            let (re, im) = (re.as_ref(), im.as_ref());
            let (sign, size) = im.strip_prefix('-').map_or(("+", im), |size| ("−", size));
            format!("{} {sign} {size}i", re.replace('-', "−"))
                .replace("e−", "e-")
                .replace("e-", "e−")
        }
        _ => parts[0].as_ref().replace('-', "−"),
    }
}

/// Checks the rows and shows them on the page, those of one system in one table.
fn hold(name: &str, rows: &[Row]) {
    const HEADER: &str = "| quantity | published | exact | proven within, relative | difference, relative | published value is |\n\
         |---|--:|--:|--:|--:|---|\n";
    let mut tables = String::new();
    let mut last = None;
    for row in rows {
        row.check();
        let (system, _) = row.case.rsplit_once(": ").expect("system: quantity");
        if last != Some((row.source, system)) {
            let gap = if last.is_some() { "\n" } else { "" };
            let _ = writeln!(
                tables,
                "{gap}**{}**: {system}\n\n{}",
                row.source,
                HEADER.trim_end()
            );
            last = Some((row.source, system));
        }
        let _ = writeln!(tables, "{}", row.line());
    }
    crate::page::assert_shown("validation.md", name, &tables);
}

/// Masses m1, m2, …; joins between them, 0 being the ground.
fn network(
    masses: &[f64],
    springs: &[(usize, usize, f64)],
    dampers: &[(usize, usize, f64)],
) -> System {
    let name = |i: usize| match i {
        0 => GROUND.to_owned(),
        i => format!("m{i}"),
    };
    let mut builder = System::builder();
    for (i, mass) in masses.iter().enumerate() {
        builder = builder.mass(name(i + 1), *mass);
    }
    for &(i, j, stiffness) in springs {
        builder = builder.spring(name(i), name(j), stiffness);
    }
    for &(i, j, damping) in dampers {
        builder = builder.damper(name(i), name(j), damping);
    }
    builder.build().expect("a system")
}

/// One mass on the ground.
fn oscillator(mass: f64, damping: f64, stiffness: f64) -> System {
    network(&[mass], &[(0, 1, stiffness)], &[(0, 1, damping)])
}

/// Eight masses of 10 kg between nine springs of 1e5 N/m.
fn chain_of_eight(dampers: &[f64; 9]) -> System {
    let joins = |values: &[f64; 9]| -> Vec<(usize, usize, f64)> {
        values
            .iter()
            .enumerate()
            .map(|(i, value)| (i, (i + 1) % 9, *value))
            .collect()
    };
    network(&[10.0; 8], &joins(&[1e5; 9]), &joins(dampers))
}

/// A unit of rounding, relative.
const U: f64 = f64::EPSILON / 2.0;

/// A natural frequency in Hz.
fn hertz(
    source: &'static str,
    case: &str,
    mode: &Mode,
    printed: &'static str,
    allowed: f64,
) -> Row {
    let root = mode.eigenvalue();
    let found = mode.natural_frequency().hertz();
    Row {
        source,
        case: case.to_owned(),
        printed: vec![printed],
        found: vec![found],
        bound: root.bound.expect("proven") / TAU + 3.0 * U * found,
        allowed,
    }
}

#[test]
fn modes() {
    let mut rows = Vec::new();
    let mut of = |source, case: &str, system: &System, printed: &[&'static str], allowed| {
        let modes = system.modes().expect("modes");
        assert_eq!(
            (modes.bounds(), modes.as_slice().len()),
            (Bounds::Proven, printed.len())
        );
        for (j, (mode, printed)) in modes.iter().zip(printed).enumerate() {
            let case = if modes.as_slice().len() > 1 {
                format!("{case}: f{}, Hz", j + 1)
            } else {
                format!("{case}: f, Hz")
            };
            rows.push(hertz(source, &case, mode, printed, allowed));
        }
    };
    of(
        "VM45",
        "m 0.006477, k 48",
        &oscillator(0.006477, 0.0, 48.0),
        &["13.701"],
        1e-5,
    );
    of(
        "VM47",
        "inertia 0.30312, torsional k 4.8",
        &oscillator(0.30312, 0.0, 4.8),
        &["0.63333"],
        1e-5,
    );
    // Bounce and pitch about the centre of mass, springs 4.5 ahead and 5.5 behind.
    let coupling = 2600.0 * 5.5 - 2400.0 * 4.5;
    let pitch = 2400.0 * 4.5 * 4.5 + 2600.0 * 5.5 * 5.5;
    let half_car = System::from_matrices(
        mat![[100.0, 0.0], [0.0, 1600.0]].as_ref(),
        Mat::zeros(2, 2).as_ref(),
        mat![[2400.0 + 2600.0, coupling], [coupling, pitch]].as_ref(),
    );
    let case = "half-car: m 100, I 1600; k 2400 at 4.5 and 2600 at 5.5 from the centre";
    of(
        "VM52",
        case,
        &half_car.expect("a system"),
        &["1.0981", "1.4406"],
        3e-5,
    );

    // The closed form, printed as such.
    let modes = chain_of_eight(&[0.0; 9]).modes().expect("modes");
    for (j, mode) in (1..).zip(&modes) {
        let exact = 100.0 / PI * (f64::from(j) * PI / 18.0).sin();
        let found = mode.natural_frequency().hertz();
        assert!((found - exact).abs() <= 1e-15 * exact);
    }

    let system = chain_of_eight(&[250.0, 50.0, 50.0, 50.0, 50.0, 50.0, 50.0, 50.0, 25.0]);
    assert!(!system.structure().is_classical());
    let modes = system.modes().expect("modes");
    // Printed are damped frequencies, and −Re λ/Im λ in place of the damping ratio.
    let frequencies = [
        "5.53", "10.90", "15.93", "20.45", "24.34", "27.49", "29.84", "31.29",
    ];
    let ratios = [
        "0.01521", "0.02877", "0.03960", "0.04709", "0.05098", "0.05183", "0.05115", "0.05036",
    ];
    let row = |case: String, printed, found: f64, bound, allowed| Row {
        source: "SDLD27",
        case,
        printed: vec![printed],
        found: vec![found],
        bound,
        allowed,
    };
    for (j, (mode, printed)) in modes.iter().zip(frequencies).enumerate() {
        let found = mode.damped_frequency().hertz();
        let bound = mode.eigenvalue().bound.expect("proven") / TAU + 3.0 * U * found;
        let case = format!("chain of 8, c 250, 50 ×7, 25: f_d of mode {}, Hz", j + 1);
        rows.push(row(case, printed, found, bound, 5e-4));
    }
    for (j, (mode, printed)) in modes.iter().zip(ratios).enumerate() {
        let root = mode.eigenvalue();
        let found = -root.value.re / root.value.im;
        let relative = root.real_bound.expect("proven") / -root.value.re
            + root.bound.expect("proven") / root.value.im;
        let case = format!("chain of 8, c 250, 50 ×7, 25: −Re λ/Im λ of mode {}", j + 1);
        rows.push(row(
            case,
            printed,
            found,
            (relative + 2.0 * U) * found,
            1.4e-3,
        ));
    }

    let printed: [(f64, &[&[&'static str]]); 2] = [
        (
            0.0,
            &[
                &["-3.13164324790656"],
                &["3.13164324790656"],
                &["-5.53094371765393"],
                &["5.53094371765393"],
            ],
        ),
        (
            5.0,
            &[
                &["-0.32286642900409"],
                &["-0.77534188219585", "4.46486771378823"],
                &["-0.77534188219585", "-4.46486771378823"],
                &["-14.07838969279822"],
            ],
        ),
    ];
    for (v, printed) in printed {
        let modes = bicycle(v).modes().expect("modes");
        assert_eq!(modes.eigenvalues().len(), printed.len());
        for (root, printed) in modes.eigenvalues().iter().zip(printed) {
            assert_eq!(root.value.im != 0.0, printed.len() == 2);
            let found = [root.value.re, root.value.im];
            rows.push(Row {
                source: "bicycle",
                case: format!("v {v} m/s: λ, 1/s"),
                printed: printed.to_vec(),
                found: found[..printed.len()].to_vec(),
                bound: root.bound.expect("proven"),
                allowed: 2e-11,
            });
        }
    }
    hold("modes", &rows);
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

/// Displacements printed at these step indices of the grid.
fn motion(
    rows: &mut Vec<Row>,
    (source, case): (&'static str, &str),
    asked: Response<'_>,
    coordinate: usize,
    printed: &[(usize, &'static str)],
    allowed: f64,
) {
    let trajectory = asked.run().expect("a response");
    assert_eq!(trajectory.bounds(), Bounds::Proven);
    let names = ["x", "x1", "x2", "x3"];
    let several = trajectory.displacement().nrows() > 1;
    let name = names[if several { coordinate + 1 } else { 0 }];
    for &(step, printed) in printed {
        let time = (trajectory.times()[step] * 1e6).round() / 1e6;
        rows.push(Row {
            source,
            case: format!("{case}: {name}({time})"),
            printed: vec![printed],
            found: vec![trajectory.displacement()[(coordinate, step)]],
            bound: trajectory.displacement_bound()[step].expect("proven"),
            allowed,
        });
    }
}

#[test]
fn motions() {
    let mut rows = Vec::new();
    for (damping, printed) in [
        (3.52636, "0.4742"),
        (1.76318, "0.18998"),
        (0.352636, "-0.52108"),
        (0.0, "-0.99688"),
    ] {
        let system = oscillator(0.02590673, damping, 30.0);
        let asked = Response::of(&system).from(State::at_rest().displace("m1", 1.0));
        let case = format!("m 0.02590673, k 30, c {damping}, released from 1");
        motion(
            &mut rows,
            ("VM71", &case),
            asked.every(0.09).until(0.09),
            0,
            &[(1, printed)],
            2.5e-5,
        );
    }
    for (damping, printed) in [
        (0.0, &[(8, "0.99957"), (10, "0.90930")][..]),
        (14.0, &[(10, "0.34180")]),
    ] {
        let system = oscillator(0.5, damping, 200.0);
        let asked = Response::of(&system).load("m1", Impulse::of(10.0));
        let case = format!("m 0.5, k 200, c {damping}, impulse 10");
        motion(
            &mut rows,
            ("VM74", &case),
            asked.every(0.01).until(0.1),
            0,
            printed,
            1.5e-5,
        );
    }
    for (damping, printed) in [(0.0, "1.6536"), (10.0, "1.1531")] {
        let system = oscillator(0.5, damping, 200.0);
        let asked = || Response::of(&system).load("m1", Step::of(200.0));
        let case = format!("m 0.5, k 200, c {damping}, step 200");
        motion(
            &mut rows,
            ("VM75", &case),
            asked().every(0.1).until(0.2),
            0,
            &[(2, printed)],
            3.5e-5,
        );
        if damping == 0.0 {
            // Half a period: π/20 s.
            let peak = asked().every(TAU / 40.0).until(TAU / 40.0);
            motion(
                &mut rows,
                ("VM75", "m 0.5, k 200, c 0, step 200"),
                peak,
                0,
                &[(1, "2")],
                1e-15,
            );
        }
    }

    let system = network(
        &[1e6, 12e6, 12e6],
        &[(1, 2, 4e9), (2, 3, 5.33e8)],
        &[(1, 2, 1.2566e6), (2, 3, 9.0478e6)],
    );
    let asked = || {
        let asked = Response::of(&system).load("m3", Harmonic::of(5e4, 59.69026));
        asked.every(0.01).until(5.0)
    };
    let case = "unsupported: m 1e6, 12e6, 12e6; k 4e9, 5.33e8; c 1.2566e6, 9.0478e6; 5e4 sin(59.69026t) on m3";
    let printed = [
        (9, "6.7395e-6"),
        (32, "1.1019e-5"),
        (118, "3.6683e-5"),
        (492, "1.6615e-4"),
    ];
    motion(&mut rows, ("SDLD320", case), asked(), 2, &printed, 3.5e-5);
    let trajectory = asked().run().expect("a response");
    rows.push(Row {
        source: "SDLD320",
        case: format!("{case}: v3(0.05)"),
        printed: vec!["1.3425e-4"],
        found: vec![trajectory.velocity()[(2, 5)]],
        bound: trajectory.velocity_bound()[5].expect("proven"),
        allowed: 3.5e-5,
    });

    let system = oscillator(10.0, 1000.0, 25000.0);
    let modes = system.modes().expect("modes");
    assert!(modes.iter().all(|mode| mode.is_defective() == Some(true)));
    let printed = [
        (6, "1.18914e-4"),
        (12, "-0.942819e-4"),
        (19, "0.997958e-4"),
        (25, "-0.997748e-4"),
        (31, "0.978457e-4"),
        (38, "-0.988705e-4"),
        (44, "0.999961e-4"),
    ];
    let asked = Response::of(&system).load("m1", Harmonic::of(5.0, 50.0));
    let case = "critical: m 10, k 25000, c 1000, 5 sin 50t";
    motion(
        &mut rows,
        ("SDLD321", case),
        asked.every(0.01).until(0.44),
        0,
        &printed,
        7.5e-7,
    );

    let system = network(
        &[10.0, 10.0],
        &[(0, 1, 2800.0), (1, 2, 28e4)],
        &[(0, 1, 50.0), (1, 2, 50.0)],
    );
    let printed = [
        (27, "3.0927e-3"),
        (53, "8.7953e-4"),
        (80, "2.4669e-3"),
        (125, "-1.098e-3"),
        (151, "7.8754e-4"),
    ];
    let asked = Response::of(&system)
        .load("m2", Step::of(5.0))
        .load("m2", Step::of(-5.0).starting_at(1.0));
    let case = "2 × 10 on k 2800, 28e4, c 50 each; 5 N on m2 for 1 s";
    motion(
        &mut rows,
        ("SDLD325", case),
        asked.every(0.01).until(1.6),
        1,
        &printed,
        2.5e-4,
    );
    hold("motions", &rows);
}

#[test]
fn harmonic() {
    let mut rows = Vec::new();
    let system = oscillator(0.5, 6.0, 200.0);
    let column = receptance(&system, "m1", TAU * 3.1831).expect("it is damped");
    rows.push(Row {
        source: "VM86",
        case: "m 0.5, k 200, c 6, F 10 at 3.1831 Hz: amplitude".to_owned(),
        printed: vec!["0.0833"],
        found: vec![10.0 * column.displacement()[0].norm()],
        bound: 10.0 * (column.bound()[0] + 2.0 * U * column.displacement()[0].norm()),
        allowed: 4.5e-4,
    });

    let springs = [(0, 1, 200.0), (1, 2, 200.0), (0, 2, 200.0)];
    let system = network(&[0.5, 0.5], &springs, &[]);
    for (frequency, printed) in [
        (1.5, ["0.82272", "0.46274"]),
        (4.0, ["-0.51145", "-1.2153"]),
        (6.5, ["-0.58513", "0.26966"]),
    ] {
        let column = receptance(&system, "m1", TAU * frequency).expect("no resonance");
        for (i, printed) in printed.into_iter().enumerate() {
            let x = column.displacement()[i];
            assert_eq!(x.im, 0.0);
            rows.push(Row {
                source: "VM90",
                case: format!(
                    "2 × 0.5, 3 × 200, F 200 on m1 at {frequency} Hz: x{}",
                    i + 1
                ),
                printed: vec![printed],
                found: vec![200.0 * x.re],
                bound: 200.0 * (column.bound()[i] + U * x.re.abs()),
                allowed: 4.5e-5,
            });
        }
    }

    let system = chain_of_eight(&[50.0; 9]);
    for (frequency, printed) in [
        (5.0, ["1.0237e-4", "-8.5187e-6"]),
        (5.5, ["4.5066e-4", "-7.7914e-4"]),
        (10.0, ["8.4143e-7", "-1.0335e-6"]),
        (40.0, ["-2.5696e-6", "-2.7554e-7"]),
    ] {
        let column = receptance(&system, "m4", TAU * frequency).expect("it is damped");
        let x = column.displacement()[3];
        rows.push(Row {
            source: "SDLD21",
            case: format!("chain of 8, every c 50: receptance of m4 at {frequency} Hz"),
            printed: printed.to_vec(),
            found: vec![x.re, x.im],
            bound: column.bound()[3],
            allowed: 2.5e-5,
        });
    }
    hold("harmonic", &rows);
}
