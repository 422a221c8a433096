//! Motions of supports, of every kind and quantity, through every element that may join one: the exact methods against an
//! integrator.

use eigentone_check::{Dop853, Reference};
use eigentone_modes::{Bounds, GROUND, Precision, System};
use eigentone_response::{
    ByCertifiedExponential, HalfSine, Harmonic, Hold, Load, Polynomial, Quantity, Ramp, Response,
    ResponseError, ResponseMethod, Samples, State, Step, Trajectory, Versine, methods,
};

const QUANTITIES: [Quantity; 3] = [
    Quantity::Displacement,
    Quantity::Velocity,
    Quantity::Acceleration,
];

fn kinds() -> Vec<(&'static str, Load)> {
    let values = vec![0.0, 0.3, -0.2, 0.5, 0.5, 0.1];
    let samples = |hold| Samples {
        step: 0.25,
        values: values.clone(),
        hold,
    };
    vec![
        ("step", Step::of(0.7).starting_at(0.3).into()),
        ("ramp", Ramp::of(0.4).starting_at(0.55).into()),
        ("harmonic", Harmonic::of(0.6, 2.5).into()),
        (
            "harmonic with phase",
            Harmonic::of(0.6, 2.5).with_phase(0.8).into(),
        ),
        ("samples held", samples(Hold::Zero).into()),
        ("samples joined", samples(Hold::First).into()),
        ("half sine", HalfSine::of(0.9, 0.7).starting_at(0.2).into()),
        ("versine", Versine::of(0.9, 0.7).starting_at(0.25).into()),
        (
            "polynomial",
            Polynomial::of([0.0, 0.3, -0.7, 0.0, 0.2, 0.1, -0.05]).into(),
        ),
        (
            "polynomial that jumps",
            Polynomial::of([0.2, 0.0, 0.4]).starting_at(0.35).into(),
        ),
    ]
}

/// Two masses, of which the second is joined to a support by one element.
fn system(element: &str) -> System {
    let both = System::builder()
        .mass("a", 2.0)
        .mass("b", 1.0)
        .support("s")
        .spring(GROUND, "a", 30.0)
        .damper(GROUND, "a", 0.4)
        .spring("a", "b", 20.0)
        .damper("a", "b", 0.1);
    let joined = match element {
        "spring" => both.spring("s", "b", 12.0),
        "damper" => both.damper("s", "b", 0.8),
        _ => both.point("p", [("b", 0.5), ("s", 0.75)], 1.5),
    };
    joined.build().expect("a system")
}

fn asked<'a>(system: &'a System, quantity: Quantity, load: &Load) -> Response<'a> {
    Response::of(system)
        .from(State::at_rest().displace("a", 0.1))
        .motion("s", quantity, load.clone())
        .every(0.05)
        .until(2.0)
}

/// The largest difference of displacements and velocities, relative to the largest of each.
fn apart(one: &Trajectory, other: &Trajectory) -> f64 {
    let relative =
        |a: faer::MatRef<'_, f64>, b: faer::MatRef<'_, f64>| (a - b).norm_max() / a.norm_max();
    let x = relative(one.displacement(), other.displacement());
    x.max(relative(one.velocity(), other.velocity()))
}

/// The largest bound of displacements and velocities, relative to the largest of each.
fn widest(motion: &Trajectory) -> f64 {
    let relative = |bounds: &[Option<f64>], values: faer::MatRef<'_, f64>| {
        let bounds = bounds.iter().map(|bound| bound.expect("proven"));
        bounds.fold(0.0, f64::max) / values.norm_max()
    };
    let x = relative(motion.displacement_bound(), motion.displacement());
    x.max(relative(motion.velocity_bound(), motion.velocity()))
}

const ELEMENTS: [&str; 3] = ["spring", "damper", "carried mass"];

/// The power of ten that a number stays below.
fn decade(value: f64) -> String {
    match value {
        0.0 => "0".to_owned(),
        value => format!("1e−{}", -(value.log10().ceil() as i32)),
    }
}

/// All exact methods beside an integrator; docs/validation.md shows the proven one.
#[test]
fn exact_methods_agree_with_an_integrator() {
    let mut compared = 0;
    let mut table = String::from(
        "| motion | quantity | spring | damper | carried mass |\n|---|---|--:|--:|--:|\n",
    );
    let systems = ELEMENTS.map(system);
    for (kind, load) in kinds() {
        for quantity in QUANTITIES {
            let word = format!("{quantity:?}").to_lowercase();
            table += &format!("| {kind} | {word} |");
            for (element, system) in ELEMENTS.into_iter().zip(&systems) {
                let what = format!("{kind} as {quantity:?} through a {element}");
                let problem = match asked(system, quantity, &load).problem() {
                    Ok(problem) => problem,
                    Err(ResponseError::Motion { index: 0, error }) => {
                        assert!(
                            error.to_string().contains("carries mass"),
                            "{what}: {error}"
                        );
                        assert_eq!(element, "carried mass", "{what}");
                        assert_eq!(quantity, Quantity::Displacement, "{what}");
                        table += " refused |";
                        continue;
                    }
                    Err(error) => panic!("{what}: {error}"),
                };
                let integrated = Dop853::with_tolerance(1e-13).run(&problem);
                let integrated = integrated.expect("an integration");
                for method in methods() {
                    assert_eq!(method.refuses(&problem), None, "{what}");
                    let exact = method.run(&problem).expect("a motion");
                    let off = apart(&exact, &integrated);
                    assert!(off < 1e-11, "{what} by {}: {off:e}", method.name());
                    compared += 1;
                    let proven = method.name() == "certified exponential";
                    assert_eq!(exact.bounds() == Bounds::Proven, proven, "{what}");
                    if proven {
                        table += &format!(" {}, {} |", decade(off), decade(widest(&exact)));
                    }
                }
            }
            table += "\n";
        }
    }
    // A displacement that jumps is no motion of a carried mass.
    assert_eq!(compared, 3 * (10 * 9 - 4));
    super::page::assert_shown("validation.md", "motions of supports", &table);
}

/// Proven motions against the reference in more digits, within their bounds, and these within the tolerance asked for; and what motions that are the same in
/// different words are.
#[test]
fn proven_motions_are_within_their_bounds() {
    const TOLERANCE: f64 = 3e-16;
    let asked_for = Precision::Certified {
        tolerance: TOLERANCE,
    };
    let reference = Reference::with_digits(30);
    let mut compared = 0;
    for element in ELEMENTS {
        let system = system(element);
        for quantity in QUANTITIES {
            for (kind, load) in kinds() {
                let what = format!("{kind} as {quantity:?} through a {element}");
                let Ok(problem) = asked(&system, quantity, &load).problem() else {
                    continue;
                };
                let problem = problem.to(asked_for);
                let truth = reference.response(&problem).expect("it is small");
                let proven = ByCertifiedExponential.run(&problem).expect("a motion");
                for k in 0..proven.len() {
                    let columns = [
                        (
                            truth.displacement(k),
                            proven.displacement(),
                            proven.displacement_bound(),
                        ),
                        (
                            truth.velocity(k),
                            proven.velocity(),
                            proven.velocity_bound(),
                        ),
                    ];
                    for (truth, values, bounds) in columns {
                        let bound = bounds[k].expect("proven");
                        let largest = values.col(k).norm_max();
                        assert!(bound <= TOLERANCE * largest, "{what} at {k}: {bound:e}");
                        for (i, truth) in truth.iter().enumerate() {
                            let off = truth.minus(values[(i, k)]).abs();
                            assert!(off <= bound, "{what} at {k}: {off:e} for {bound:e}");
                        }
                    }
                }
                compared += 1;
            }
        }
    }
    assert!(compared > 60, "{compared}");
}
