//! State-space forms, held exactly, and their process noise, against exponentials with 120 digits (truth.py), and against
//! motions.

mod random;

use eigentone_digits::{Real, Wide};
use eigentone_modes::{GROUND, System};
use eigentone_response::{
    BoundedMatrix, Hold, Quantity, Response, Samples, StateSpace, StateSpaceError,
};
use faer::{Mat, mat};

use crate::systems::{in_a_row, quarter_car};

use Quantity::{Acceleration, Displacement, Velocity};

type Exact = Wide<8>;

/// A decimal number to more digits than a double has.
fn exact(text: &str) -> Exact {
    let (mantissa, power) = text.split_once('e').unwrap_or((text, "0"));
    let mut power: i64 = power.parse().expect("a power of ten");
    let (negative, digits) = match mantissa.strip_prefix('-') {
        Some(digits) => (true, digits),
        None => (false, mantissa),
    };
    let mut value = Exact::ZERO;
    let mut behind = false;
    for c in digits.chars() {
        match c.to_digit(10) {
            Some(digit) => {
                value = value * Exact::from(10.0) + Exact::from(f64::from(digit));
                power -= i64::from(behind);
            }
            None => behind = true,
        }
    }
    for _ in 0..power.abs() {
        value = match power < 0 {
            true => value / Exact::from(10.0),
            false => value * Exact::from(10.0),
        };
    }
    if negative { -value } else { value }
}

fn truth(case: &str, matrix: &str) -> Vec<(usize, usize, Exact)> {
    let lines = include_str!("truth.txt").lines();
    let entries = lines.filter_map(|line| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let entry = |at: usize| words[at].parse().expect("an index");
        let wanted = words[0] == case && words[1] == matrix;
        wanted.then(|| (entry(2), entry(3), exact(words[4])))
    });
    let entries: Vec<_> = entries.collect();
    assert!(!entries.is_empty(), "{case} {matrix}");
    entries
}

/// Entries lie within their bounds, which are those of rounding but for what is 1e-29 of the largest entry.
fn holds(case: &str, name: &str, matrix: &BoundedMatrix) {
    let entries = truth(case, name);
    assert_eq!(entries.len(), matrix.values.nrows() * matrix.values.ncols());
    for (i, j, truth) in entries {
        let (value, bound) = (matrix.values[(i, j)], matrix.bound[(i, j)]);
        // The truth has 40 digits.
        let off = (truth - Exact::from(value)).abs() - truth.abs() * Exact::from(1e-39);
        let what = format!("{case} {name}({i}, {j}) = {value:e} ± {bound:e}");
        assert!(
            off <= Exact::from(bound),
            "{what}: off by {:e}",
            off.to_f64()
        );
        let last = value.abs() * 2f64.powi(-53) * 1.001;
        let nothing = matrix.values.norm_max() * 1e-29;
        assert!(bound <= last.max(nothing), "{what} is idle");
    }
}

fn oscillator() -> System {
    in_a_row(&[("m", 2.0)], &[8.0], &[1.0])
}

fn driven_car(car: &System) -> StateSpace<'_> {
    let travel = [(Displacement, "body", 1.0), (Displacement, "wheel", -1.0)];
    StateSpace::of(car)
        .motion("road", Displacement)
        .force("body")
        .output("body", Acceleration)
        .sum("travel", travel)
        .pull("tyre force", "tyre")
        .build()
        .expect("a plant")
}

fn maxwell() -> System {
    let system = System::builder().mass("m", 1.0).mass("p", 0.0);
    let system = system.damper("m", "p", 0.5).spring(GROUND, "p", 3.0);
    system.build().expect("a system")
}

fn storeys() -> System {
    System::builder()
        .mass("1", 2.0)
        .mass("2", 1.0)
        .support("soil")
        .spring("soil", "1", 300.0)
        .spring("1", "2", 200.0)
        .damper("soil", "1", 2.0)
        .damper("1", "2", 1.0)
        .build()
        .expect("a system")
}

fn stiff() -> System {
    in_a_row(&[("1", 1.0), ("2", 1.0)], &[1.0, 1e12], &[])
}

fn check(case: &str, plant: &StateSpace<'_>, step: f64, density: Mat<f64>) {
    let zero = plant.discretise(step, Hold::Zero).expect("a form");
    let first = plant.discretise(step, Hold::First).expect("a form");
    holds(case, "A", &zero.a);
    holds(case, "A", &first.a);
    holds(case, "B", &zero.b);
    holds(case, "BF", &first.b);
    holds(case, "DF", &first.d);
    assert_eq!(zero.d, plant.matrices().d);
    let noise = plant.process_noise(step, density.as_ref()).expect("noise");
    holds(case, "Q", &noise);
}

#[test]
fn discrete_forms_are_right_to_the_last_digits() {
    let system = oscillator();
    let plant = StateSpace::of(&system).force("m").output("m", Displacement);
    check(
        "oscillator",
        &plant.build().expect("a plant"),
        0.01,
        mat![[3.0]],
    );

    let system = quarter_car();
    check(
        "car",
        &driven_car(&system),
        0.05,
        mat![[0.5, 0.25], [0.25, 2.0]],
    );

    let system = in_a_row(&[("m", 1.0)], &[1.0], &[1e6]);
    let plant = StateSpace::of(&system).force("m").output("m", Displacement);
    check("slow", &plant.build().expect("a plant"), 1.0, mat![[1.0]]);

    let system = maxwell();
    let plant = StateSpace::of(&system).force("m").force("p");
    let plant = plant.output("p", Displacement).build().expect("a plant");
    check("maxwell", &plant, 0.25, Mat::identity(2, 2));

    let system = storeys();
    let drift = [(Displacement, "1", 1.0), (Displacement, "soil", -1.0)];
    let plant = StateSpace::of(&system).motion("soil", Acceleration);
    let plant = plant.output("2", Acceleration).sum("drift", drift);
    check("quake", &plant.build().expect("a plant"), 0.02, mat![[1.0]]);

    let system = stiff();
    let plant = StateSpace::of(&system).force("2").output("1", Displacement);
    check("stiff", &plant.build().expect("a plant"), 7.0, mat![[1.0]]);
}

#[test]
fn stationary_covariances_are_right_to_the_last_digits() {
    let system = quarter_car();
    let plant = StateSpace::of(&system).force("body").build();
    let plant = plant.expect("a plant");
    let covariance = plant.stationary_covariance(mat![[2.0]].as_ref());
    holds("pushed", "P", &covariance.expect("it comes to rest"));

    let system = in_a_row(&[("1", 1.0), ("2", 1.0)], &[1.0, 1e12], &[1e-9]);
    let plant = StateSpace::of(&system).force("2").build();
    let plant = plant.expect("a plant");
    let covariance = plant.stationary_covariance(mat![[1.0]].as_ref());
    holds("faint", "P", &covariance.expect("it comes to rest"));

    let free = stiff();
    let plant = StateSpace::of(&free).force("2").build().expect("a plant");
    let endless = plant.stationary_covariance(mat![[1.0]].as_ref());
    let refused = matches!(&endless, Err(StateSpaceError::NotStationary { what }) if what == "each of 2 undamped modes");
    assert!(refused, "{endless:?}");
}

/// Frequencies of 1e100 within a step of a second: all of it has died out, far below what any number holds.
#[test]
fn what_decays_beyond_all_range_is_nothing() {
    let system = in_a_row(&[("m", 1e-100)], &[1e100], &[0.1]);
    let plant = StateSpace::of(&system).force("m").output("m", Displacement);
    let plant = plant.build().expect("a plant");
    let held = plant.discretise(1.0, Hold::Zero).expect("a form");
    assert_eq!(held.a.values.norm_max(), 0.0);
    assert_eq!(
        (held.b.values[(0, 0)], held.b.values[(1, 0)]),
        (1e-100, 0.0)
    );
    let noise = plant
        .process_noise(1.0, mat![[1.0]].as_ref())
        .expect("noise");
    // 1/2ck and 1/2cm.
    assert!((noise.values[(0, 0)] / 5e-100 - 1.0).abs() < 4e-16);
    assert!((noise.values[(1, 1)] / 5e100 - 1.0).abs() < 4e-16);
}

/// A jump of the road is an impulse through the tyre's damper: taken out of the state, and back in where it shows.
#[test]
fn states_and_matrices_are_named_and_placed() {
    let system = quarter_car();
    let plant = driven_car(&system);
    let jumps = "wheel velocity without the jumps by road displacement";
    let states = [
        "body displacement",
        "wheel displacement",
        "body velocity",
        jumps,
    ];
    assert_eq!(plant.states(), states);
    assert_eq!(plant.inputs(), ["road displacement", "body force"]);
    assert_eq!(
        plant.outputs(),
        ["body acceleration", "travel", "tyre force"]
    );
    let matrices = plant.matrices();
    let (b, c, d) = (&matrices.b.values, &matrices.c.values, &matrices.d.values);
    assert_eq!(b[(1, 0)], 50.0 / 59.0);
    assert_eq!((b[(2, 1)], b[(3, 1)]), (1.0 / 290.0, 0.0));
    assert_eq!((c[(1, 0)], c[(1, 1)]), (1.0, -1.0));
    assert_eq!((d[(2, 0)], c[(2, 1)]), (-190_000.0, 190_000.0));

    let system = maxwell();
    let plant = StateSpace::of(&system).force("p").build().expect("a plant");
    assert_eq!(
        plant.states(),
        ["m displacement", "m velocity", "p displacement"]
    );
    assert_eq!(
        (
            plant.matrices().c.values.nrows(),
            plant.matrices().d.values.ncols()
        ),
        (0, 1)
    );

    let system = storeys();
    let plant = StateSpace::of(&system).motion("soil", Velocity).build();
    let plant = plant.expect("a plant");
    assert_eq!(plant.states()[4], "soil displacement");
    assert_eq!(plant.states().len(), 5);
}

/// A pair without mass that floats on its damper relaxes in its difference.
#[test]
fn differences_are_named_as_such() {
    let system = System::builder()
        .mass("m", 3.0)
        .mass("a", 0.0)
        .mass("b", 0.0)
        .spring(GROUND, "m", 1.0)
        .spring("m", "a", 1.0)
        .spring("a", "b", 1.0)
        .damper("a", "b", 1.0)
        .build()
        .expect("a system");
    let plant = StateSpace::of(&system).output("b", Displacement);
    let plant = plant.build().expect("a plant");
    let states = [
        "m displacement",
        "m velocity",
        "b displacement − a displacement",
    ];
    assert_eq!(plant.states(), states);
    let c = &plant.matrices().c.values;
    assert_eq!((c[(0, 0)], c[(0, 2)]), (1.0, 1.0));
}

/// A node without mass that a spring k and a damper c join to one support is moved by nothing but the jump of that support
/// which is taken out of its state: a + (c/k)a′ = r + (c/k)r′. Its column of B is 0 by cancellation alone, of which neither A nor
/// what pushes the mass beside it may lose a digit.
#[test]
fn columns_that_cancel_leave_the_others_alone() {
    let nothing = 1e-60;
    let is = |what: &str, matrix: &BoundedMatrix, i: usize, j: usize, wanted: f64| {
        let (value, bound) = (matrix.values[(i, j)], matrix.bound[(i, j)]);
        let what = format!("{what}({i}, {j}) = {value:e} ± {bound:e}, not {wanted:e}");
        assert!((value - wanted).abs() <= 1e-15 * wanted.abs(), "{what}");
        assert!(bound <= wanted.abs() * 1.2e-16 + nothing, "{what}");
    };
    for (mass, stiffness, k, c) in [
        (1.0, 4.0, 2.0, 3.0),
        (1.0, 1.0, 1.0, 2.0),
        (1e-6, 4e-6, 0.7e6, 0.3e6),
        (1e6, 1e6, 0.3e-6, 1e-6),
        (3.0, 7.0, 1e9, 1e2),
    ] {
        let node = System::builder()
            .mass("a", 0.0)
            .support("r")
            .spring("r", "a", k)
            .damper("r", "a", c);
        let both = node.clone().mass("m", mass).spring(GROUND, "m", stiffness);
        let (node, both) = (
            node.build().expect("a system"),
            both.build().expect("a system"),
        );
        let step = 0.1f64;
        let (omega, decay) = ((stiffness / mass).sqrt(), (-k / c * step).exp());
        let (sin, cos) = (omega * step).sin_cos();
        for hold in [Hold::Zero, Hold::First] {
            let plant = StateSpace::of(&node).motion("r", Displacement);
            let plant = plant.output("a", Displacement).build().expect("a plant");
            let held = plant.discretise(step, hold).expect("a form");
            is("A", &held.a, 0, 0, decay);
            is("B", &held.b, 0, 0, 0.0);
            is("C", &held.c, 0, 0, 1.0);
            is("D", &held.d, 0, 0, 1.0);

            let plant = StateSpace::of(&both).motion("r", Displacement).force("m");
            let plant = plant.build().expect("a plant");
            let held = plant.discretise(step, hold).expect("a form");
            let a = [
                [cos, sin / omega, 0.0],
                [-omega * sin, cos, 0.0],
                [0.0, 0.0, decay],
            ];
            for (i, row) in a.iter().enumerate() {
                for (j, wanted) in row.iter().enumerate() {
                    is("A", &held.a, i, j, *wanted);
                }
                is("B", &held.b, i, 0, 0.0);
            }
            if hold == Hold::Zero {
                let half = (omega * step / 2.0).sin();
                is("B", &held.b, 0, 1, 2.0 * half * half / stiffness);
                is("B", &held.b, 1, 1, sin / omega / mass);
                is("B", &held.b, 2, 1, 0.0);
            }
        }
    }
}

/// The discrete form steps where the motion goes, under sampled forces and roads, jumps included.
#[test]
fn the_discrete_form_steps_where_the_motion_goes() {
    let system = quarter_car();
    let plant = driven_car(&system);
    let step = 0.05;
    let road = [0.0, 0.1, -0.05, 0.2, 0.2, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0];
    let push = [1e3, 0.0, -2e3, 0.0, 5e2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    for hold in [Hold::Zero, Hold::First] {
        let sampled = |values: &[f64]| Samples {
            step,
            values: values.to_vec(),
            hold,
        };
        let motion = Response::of(&system)
            .motion("road", Displacement, sampled(&road))
            .load("body", sampled(&push))
            .sum(
                "travel",
                [(Displacement, "body", 1.0), (Displacement, "wheel", -1.0)],
            )
            .every(step)
            .until(0.5);
        let motion = motion.run().expect("a motion");
        let held = plant.discretise(step, hold).expect("a form");
        let mut state = Mat::<f64>::zeros(4, 1);
        if hold == Hold::First {
            // z − Γu at first, of a state at rest under u₀.
            state = -(&held.a.values * &Mat::<f64>::zeros(4, 1));
            let growing = growth(&plant, step);
            state -= growing * mat![[road[0]], [push[0]]];
        }
        for k in 0..road.len() {
            let input = mat![[road[k]], [push[k]]];
            let output = &held.c.values * &state + &held.d.values * &input;
            let wanted = motion.output(0)[k];
            assert!(
                (output[(1, 0)] - wanted).abs() < 1e-15,
                "{hold:?} {k}: {} {wanted}",
                output[(1, 0)]
            );
            state = &held.a.values * &state + &held.b.values * &input;
        }
    }
}

/// Γ₂ of the first-order hold, from outputs that are the states.
fn growth(plant: &StateSpace<'_>, step: f64) -> Mat<f64> {
    let zero = plant.discretise(step, Hold::Zero).expect("a form");
    let first = plant.discretise(step, Hold::First).expect("a form");
    // B_first = Γ₁ + (A − I)Γ₂.
    let difference = &first.b.values - &zero.b.values;
    let a = &zero.a.values - Mat::<f64>::identity(4, 4);
    use faer::linalg::solvers::Solve;
    a.full_piv_lu().solve(difference)
}

#[test]
fn what_cannot_be_is_refused() {
    let system = quarter_car();
    let ask = || StateSpace::of(&system);
    let of = |builder: eigentone_response::StateSpaceBuilder<'_>| builder.build().map(drop);
    let known = "body, wheel".to_owned();
    let name = "road".to_owned();
    assert_eq!(
        of(ask().force("road")),
        Err(StateSpaceError::UnknownPlace { name, known })
    );
    let (name, known) = ("body".to_owned(), "road".to_owned());
    let wrong = Err(StateSpaceError::UnknownSupport { name, known });
    assert_eq!(of(ask().motion("body", Displacement)), wrong);
    // The tyre's damper makes a jump of the road an impulse: the wheel's acceleration is no number then.
    let wheel = ask().output("wheel", Acceleration);
    let (output, input) = (
        "wheel acceleration".to_owned(),
        "road displacement".to_owned(),
    );
    let improper = Err(StateSpaceError::Improper { output, input });
    assert_eq!(of(wheel.clone().motion("road", Displacement)), improper);
    assert_eq!(of(wheel.motion("road", Velocity)), Ok(()));
    let plant = driven_car(&system);
    for step in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = plant.discretise(step, Hold::Zero);
        assert!(
            matches!(refused, Err(StateSpaceError::Step { .. })),
            "{step}"
        );
    }
    for density in [mat![[1.0]], mat![[1.0, 2.0], [3.0, 1.0]]] {
        let refused = plant.process_noise(0.1, density.as_ref());
        assert!(matches!(
            refused,
            Err(StateSpaceError::Density { inputs: 2, .. })
        ));
    }
    let growing = in_a_row(&[("m", 1.0)], &[-1.0], &[]);
    let plant = StateSpace::of(&growing)
        .force("m")
        .build()
        .expect("a plant");
    let beyond = plant.discretise(800.0, Hold::Zero);
    let (matrix, row, column) = ("A", 0, 0);
    assert_eq!(
        beyond,
        Err(StateSpaceError::Overflow {
            matrix,
            row,
            column
        })
    );
}
