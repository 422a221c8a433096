//! Machines: points, supports that move, damping of the whole, outputs and switches, against answers to 34 digits.
//!
//! `cargo test --release --test machines -- --nocapture` prints all errors.

use std::collections::BTreeSet;
use std::path::Path;
use std::time::Duration;

use eigentone::check::{Effort, OneStep, Outcome, WorkPrecision};
use eigentone::gallery::{Case, Decimal, TrueSample, cases, machines, switches};
use eigentone::modes::{Bounds, GROUND, MatrixKind, Precision, System};
use eigentone::report::ModeReport;
use eigentone::response::{ResponsePlan, Trajectory, methods};
use eigentone::scene::Scene;
use eigentone::switching::{SwitchedMotion, Switching};

/// What a bound may be exceeded by, for its error is measured in double-doubles.
const MEASURED: f64 = 1.0 + 1e-12;

fn largest<'a>(values: impl IntoIterator<Item = &'a Decimal>) -> f64 {
    let sizes = values.into_iter().map(|value| value.to_f64().abs());
    sizes.fold(0.0, f64::max)
}

#[test]
fn every_file_is_in_the_list() {
    for (room, cases) in [("machines", machines()), ("switches", switches())] {
        let names: Vec<&str> = cases.iter().map(Case::name).collect();
        assert!(names.is_sorted());
        for folder in ["scenes", "truth"] {
            let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gallery");
            let files = std::fs::read_dir(root.join(room).join(folder)).expect("it is there");
            let files: BTreeSet<String> = files
                .map(|file| file.expect("it can be listed").path())
                .map(|file| file.file_stem().expect("a name").display().to_string())
                .collect();
            assert_eq!(files, names.iter().map(|name| (*name).to_owned()).collect());
        }
    }
}

/// What a system was built from is written under the keys of a scene: read back by the library, or as a scene, it is the
/// same system.
#[test]
fn systems_are_read_back_to_the_last_digit() {
    let entries = |system: &System| {
        let kinds = [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness];
        let terms = kinds.map(|kind| {
            let terms = system
                .terms(kind)
                .chain(system.coupling(kind).iter().copied());
            terms
                .map(|term| format!("{term:?}"))
                .collect::<Vec<String>>()
        });
        format!("{terms:?} {:?} {:?}", system.points(), system.names())
    };
    for case in cases().iter().chain(machines()).chain(switches()) {
        let (name, scene) = (case.name(), case.scene());
        let system = scene.system();
        let text = serde_json::to_string(system).expect(name);
        let back: System = serde_json::from_str(&text).expect(name);
        assert_eq!(entries(&back), entries(system), "{name}");
        assert_eq!(serde_json::to_string(&back).expect(name), text);
        let again = Scene::parse(&text, Path::new("again.json")).expect(name);
        assert_eq!(entries(again.system()), entries(system), "{name}");
    }
    // What scenes do not have: a place that is named twice, and damping ratios with fewer digits.
    let two = || {
        let builder = System::builder().mass("a", 1.0).mass("b", 2.0);
        let builder = builder.spring(GROUND, "a", 3.0).spring("a", "b", 0.7);
        builder.point("p", [("a", 1.0), ("b", 1.0), ("a", 1e-20)], 0.5)
    };
    let damped = |quick: bool| {
        let builder = two().modal_damping(vec![0.1, 0.3], None);
        match quick {
            true => builder.quick_modal_damping(),
            false => builder,
        }
    };
    let all = [two(), damped(false), damped(true)].map(|all| all.build().expect("a system"));
    for system in &all {
        let text = serde_json::to_string(system).expect("text");
        let back: System = serde_json::from_str(&text).expect("a system");
        assert_eq!(entries(&back), entries(system), "{text}");
        assert!(!text.contains(r#""a":1.0,"b":1.0,"a":1e-20"#), "{text}");
    }
    let [_, slow, quick] = &all;
    assert_ne!(entries(slow), entries(quick));
    let wrong = r#"{"masses": [{"name": "m", "mass": 1.0, "colour": "red"}]}"#;
    let error = serde_json::from_str::<System>(wrong).expect_err("an unknown key");
    assert!(
        error.to_string().contains("unknown field `colour`"),
        "{error}"
    );
    let wrong = r#"{"masses": [{"name": "m", "mass": -1.0}]}"#;
    let error = serde_json::from_str::<System>(wrong).expect_err("a negative mass");
    assert!(error.to_string().contains("-1"), "{error}");
}

/// As JSON the library's answers have the keys of the command line.
#[test]
fn answers_are_written_with_the_keys_of_the_command_line() {
    let case = machines().iter().find(|case| case.name() == "half-car");
    let scene = case.expect("a case").scene();
    let modes = scene.system().modes().expect("modes");
    let mut printed = Vec::new();
    let report = ModeReport::new(&modes, scene.system().names());
    report.json(&mut printed).expect("a vector takes it");
    let printed = String::from_utf8(printed).expect("UTF-8");
    assert_eq!(
        serde_json::to_string(&modes).expect("text"),
        printed.trim_end()
    );
    let problem = scene.problem().expect("a time").expect("a problem");
    let motion = ResponsePlan::of(&problem).and_then(|plan| plan.run(&problem));
    let motion = motion.expect("a motion");
    let written = serde_json::to_value(&motion).expect("a value");
    assert_eq!(written["bounds"], "proven");
    assert_eq!(written["displacement"][1][7], motion.displacement()[(1, 7)]);
    assert_eq!(written["outputs"][0]["value"][7], motion.output(0)[7]);
    let proved = serde_json::to_value(scene.system().structure()).expect("a value");
    assert_eq!(
        (&proved["passive"], &proved["finite_roots"]),
        (&true.into(), &8.into())
    );
}

#[test]
fn modes_are_right_to_the_last_digits() {
    for case in machines() {
        let (name, scene, truth) = (case.name(), case.scene(), case.truth());
        assert_eq!(truth.coordinates, scene.system().names(), "{name}");
        let modes = scene.system().modes().expect(name);
        assert_eq!(modes.bounds(), Bounds::Proven, "{name}");
        let mut left = modes.eigenvalues().to_vec();
        assert_eq!(left.len(), truth.eigenvalues.len(), "{name}");
        for root in &truth.eigenvalues {
            let off = |k: usize| {
                let found = left[k].value;
                root.re.minus(found.re).hypot(root.im.minus(found.im))
            };
            let nearest = (0..left.len()).min_by(|a, b| off(*a).total_cmp(&off(*b)));
            let nearest = nearest.expect("as many as there are");
            let error = off(nearest);
            let found = left.swap_remove(nearest);
            let size = root.re.to_f64().hypot(root.im.to_f64());
            println!("{name}: {:.1e} of {size:.3e}", error);
            assert!(
                error <= 4.0 * f64::EPSILON / 2.0 * size,
                "{name}: {error:e} of {size:e}"
            );
            let bound = found.bound.expect("proven");
            assert!(
                error <= bound * MEASURED,
                "{name}: {error:e} beyond {bound:e}"
            );
            assert!(bound <= 1e-15 * size, "{name}: {bound:e} says nothing");
        }
    }
}

/// Checks all that one method says of one machine; the errors of displacements, velocities and outputs in parts of the
/// largest of their kind.
fn errors(name: &str, samples: &[TrueSample], found: &Trajectory, idle: f64) -> [f64; 3] {
    let mut worst = [0.0; 3];
    let mut note = |kind: usize, error: f64, size: f64, bound: Option<f64>| {
        let what = ["displacement", "velocity", "output"][kind];
        if let Some(bound) = bound {
            assert!(
                error <= bound * MEASURED,
                "{name}: {what} {error:e} beyond {bound:e}"
            );
            assert!(
                bound <= idle * size,
                "{name}: {what} of {size:e} has {bound:e}"
            );
        }
        if size > 0.0 {
            worst[kind] = f64::max(worst[kind], error / size);
        }
    };
    let moved = largest(samples.iter().flat_map(|sample| &sample.displacement));
    let fastest = largest(samples.iter().flat_map(|sample| &sample.velocity));
    for (k, sample) in samples.iter().enumerate() {
        assert_eq!(found.steps()[k], sample.step);
        let kinds = [
            (
                &sample.displacement,
                found.displacement(),
                found.displacement_bound()[k],
                moved,
            ),
            (
                &sample.velocity,
                found.velocity(),
                found.velocity_bound()[k],
                fastest,
            ),
        ];
        for (kind, (truth, found, bound, size)) in kinds.into_iter().enumerate() {
            for (i, truth) in truth.iter().enumerate() {
                note(kind, truth.minus(found[(i, k)]).abs(), size, bound);
            }
        }
        assert_eq!(found.outputs().count(), sample.outputs.len());
        for (i, output) in found.outputs().enumerate() {
            let size = largest(samples.iter().map(|sample| &sample.outputs[output]));
            let error = sample.outputs[output].minus(found.output(i)[k]).abs();
            note(2, error, size, found.output_bound(i)[k]);
        }
    }
    worst
}

#[test]
fn motions_and_outputs_are_right_to_the_last_digits() {
    for case in machines() {
        let (name, scene, truth) = (case.name(), case.scene(), case.truth());
        let steps: Vec<u64> = truth.response.iter().map(|sample| sample.step).collect();
        let problem = scene.problem().expect(name);
        let problem = problem.and_then(|problem| problem.at(&steps)).expect(name);
        let plan = ResponsePlan::of(&problem).expect(name);
        let certified = plan.run(&problem).expect(name);
        assert_eq!(certified.bounds(), Bounds::Proven, "{name}");
        let off = errors(name, &truth.response, &certified, 1e-14);
        println!("{name}: certified {off:?}");
        assert!(
            off[0] <= 2e-15 && off[1] <= 2e-15 && off[2] <= 1e-14,
            "{name}: {off:?}"
        );
        let problem = problem.to(Precision::Double);
        for method in methods() {
            if method.refuses(&problem).is_some() {
                continue;
            }
            let found = method.run(&problem).expect(name);
            let off = errors(name, &truth.response, &found, f64::INFINITY);
            println!("{name}: {} {off:?}", method.name());
            assert!(off.iter().all(|off| *off <= 1e-11), "{name}: {off:?}");
        }
    }
}

fn switched(name: &str, scene: &Scene, precision: Precision) -> SwitchedMotion {
    let problem = scene.problem().expect(name).expect(name).to(precision);
    let switching = Switching::new(&problem, scene.switches()).expect(name);
    switching
        .run()
        .unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// All events in their order, at their times, and the motion between, within bounds that say something.
#[test]
fn motions_with_switches_are_those_of_60_digits() {
    for case in switches() {
        let (name, scene, truth) = (case.name(), case.scene(), case.truth());
        assert_eq!(truth.coordinates, scene.system().names(), "{name}");
        let places = scene.switch_places();
        for (precision, idle) in [(Precision::default(), 1.0), (Precision::Double, 1e3)] {
            let motion = switched(name, &scene, precision);
            let found = motion.events().iter();
            let found: Vec<_> = found
                .map(|event| (places[event.switch].as_str(), event.kind.to_string()))
                .collect();
            let wanted = truth.events.iter();
            let wanted: Vec<_> = wanted
                .map(|event| (event.element.as_str(), event.what.clone()))
                .collect();
            assert_eq!(found, wanted, "{name}");
            for (event, wanted) in motion.events().iter().zip(&truth.events) {
                let error = wanted.time.minus(event.time).abs();
                assert!(
                    error <= event.bound * MEASURED,
                    "{name}: {event:?} {error:e}"
                );
                assert!(
                    event.bound <= idle * 4.5e-16 * event.time,
                    "{name}: {event:?}"
                );
            }
            let trajectory = motion.trajectory();
            type Values = fn(&TrueSample) -> &Vec<Decimal>;
            let kinds: [(Values, _, _); 2] = [
                (
                    |sample| &sample.displacement,
                    trajectory.displacement(),
                    trajectory.displacement_bound(),
                ),
                (
                    |sample| &sample.velocity,
                    trajectory.velocity(),
                    trajectory.velocity_bound(),
                ),
            ];
            for (of, values, bounds) in kinds {
                let size = largest(truth.response.iter().flat_map(of));
                for sample in &truth.response {
                    let k = sample.step as usize;
                    let bound = bounds[k].expect("as events are few");
                    assert!(
                        bound <= idle * 5e-16 * size,
                        "{name} {k}: {bound:e} of {size:e}"
                    );
                    for (i, wanted) in of(sample).iter().enumerate() {
                        let error = wanted.minus(values[(i, k)]).abs();
                        assert!(error <= bound * MEASURED, "{name} {k} {i}: {error:e}");
                    }
                }
            }
        }
    }
}

#[test]
fn output_steps_change_neither_events_nor_motions() {
    for case in switches() {
        let name = case.name();
        let own = case.scene_text();
        let at = own.find("\"step\": 0.0").expect("a step") + 8;
        let end = at + own[at..].find(' ').expect("an end");
        let motions = ["0.0009765625", "0.03125", "0.25", "1.0"].map(|step| {
            let text = format!("{}{step}{}", &own[..at], &own[end..]);
            let scene = Scene::parse(&text, Path::new(name)).expect(name);
            switched(name, &scene, Precision::default())
        });
        let [finest, others @ ..] = &motions;
        for motion in others {
            let kinds = |motion: &SwitchedMotion| {
                let events = motion.events().iter();
                events
                    .map(|event| (event.switch, event.kind))
                    .collect::<Vec<_>>()
            };
            assert_eq!(kinds(finest), kinds(motion), "{name}");
            for (a, b) in finest.events().iter().zip(motion.events()) {
                assert!(
                    (a.time - b.time).abs() <= 1e-14 * a.time,
                    "{name}: {a:?} {b:?}"
                );
            }
            let ratio = (finest.trajectory().len() - 1) / (motion.trajectory().len() - 1);
            let [fine, coarse] = [finest, motion].map(|motion| motion.trajectory().displacement());
            for k in 0..coarse.ncols() {
                for i in 0..coarse.nrows() {
                    let off = (fine[(i, k * ratio)] - coarse[(i, k)]).abs();
                    assert!(off <= 1e-14 * coarse[(i, k)].abs().max(1e-3), "{name} {k}");
                }
            }
        }
    }
}

/// With steps that are short enough, methods that locate events find all of them, near the times that are claimed to be exact.
#[test]
fn integrators_find_the_same_events() {
    for case in switches() {
        let (name, scene) = (case.name(), case.scene());
        let problem = scene.problem().expect("instants").expect(name);
        let effort = Effort {
            instants: 50,
            run: Duration::from_secs(10),
            total: Duration::from_secs(20),
        };
        let methods = [OneStep::RungeKutta4, OneStep::Radau5];
        let compared = WorkPrecision::measure_switched(
            &problem,
            &scene.switches(),
            &methods,
            effort,
            &mut |_| {},
        );
        let rows = compared.expect(name).rows;
        for method in methods {
            let finest = rows.iter().rfind(|row| row.method == method.name());
            let finest = finest.expect("a row");
            let Outcome::Measured(one) = &finest.outcome else {
                panic!("{name}: {finest:?}");
            };
            let events = one.events.expect("it has switches");
            println!("{name}, {}: {:?} {events:?}", finest.method, one.error);
            assert_eq!(
                (events.found, events.in_order),
                (events.expected, events.expected),
                "{name}"
            );
            let time = events.time.unwrap_or(0.0);
            assert!(time < 1e-8, "{name}: {events:?}");
            assert!(
                one.error.is_some_and(|error| error.worst() < 1e-8),
                "{name}: {one:?}"
            );
        }
    }
}
