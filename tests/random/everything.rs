//! All that the commands print of one scene: numbers, or an error that says why there are none.

use std::time::{Duration, Instant};

use eigentone::check::{
    Dop853, Effort, ExponentialComparison, Integrator, ModeComparison, Newmark, WorkPrecision,
};
use eigentone::modes::{Bounds, Participation};
use eigentone::report::{
    Analysis, Answer, CheckReport, DemandReport, EnergyReport, ModeReport, Page, ResponseReport,
};
use eigentone::response::{
    ByCertifiedExponential, Destination, Energy, ResponsePlan, SteadyState, Summary, methods,
};
use eigentone::scene::Scene;
use eigentone::tables::SceneTables;

use super::examine::said;

/// How long all commands together may take for a scene of a few coordinates and instants, most of it measuring
/// how long methods take.
const LONGEST: Duration = Duration::from_secs(60);

/// Where nothing is known there is a word or a dash, and no number that is none.
fn clean(text: &str) {
    for line in text.lines() {
        let mut words = line.split(|c: char| !c.is_alphanumeric());
        let wrong = words.find(|word| ["NaN", "nan", "inf", "Infinity"].contains(word));
        assert_eq!(wrong, None, "{line}");
    }
}

fn written(write: impl FnOnce(&mut Vec<u8>) -> std::io::Result<()>) -> String {
    let mut out = Vec::new();
    write(&mut out).expect("a vector takes it");
    let text = String::from_utf8(out).expect("UTF-8");
    clean(&text);
    text
}

fn json(write: impl FnOnce(&mut Vec<u8>) -> std::io::Result<()>) {
    let text = written(write);
    let parsed: Result<serde_json::Value, _> = serde_json::from_str(&text);
    // 15 digits of the largest double are more than it is.
    let error = parsed.err().map(|error| error.to_string());
    let is_beyond = |error: &String| error.starts_with("number out of range");
    assert!(error.as_ref().is_none_or(is_beyond), "{error:?}: {text}");
}

/// `analyze`, `modes`, `response`, `check` and `tables`.
///
/// # Panics
/// Where one of them does, prints a number that is none, or takes too long.
pub fn every_command(scene: &Scene) {
    let start = Instant::now();
    analyzed(scene);
    checked(scene);
    tabled(scene);
    assert!(start.elapsed() < LONGEST, "{:?}", start.elapsed());
}

/// The same without reference tables: those of machines may take the minutes that the reference is allowed.
///
/// # Panics
/// As above.
pub fn every_quick_command(scene: &Scene) {
    let start = Instant::now();
    analyzed(scene);
    checked(scene);
    assert!(start.elapsed() < LONGEST, "{:?}", start.elapsed());
}

fn tabled(scene: &Scene) {
    /// Some seconds: more are refused.
    const MULTIPLICATIONS: f64 = 1e7;
    match SceneTables::within(MULTIPLICATIONS, "a scene", scene, None) {
        Ok(tables) => {
            for text in [tables.markdown(), tables.latex(), tables.shapes_csv()] {
                clean(&text);
            }
            json(|out| {
                out.extend(tables.json().bytes());
                Ok(())
            });
        }
        Err(error) => said(error),
    }
}

fn analyzed(scene: &Scene) {
    let system = scene.system();
    let Ok(modes) = system.modes().map_err(said) else {
        return;
    };
    let problem = scene.problem().map(|problem| {
        let problem = problem.expect("checked");
        problem.with_acceleration().with_forces()
    });
    let solved = problem.as_ref().and_then(|problem| {
        let plan = ResponsePlan::of(problem).map_err(said).ok()?;
        let trajectory = plan.run(problem).map_err(said).ok()?;
        let summary = Summary::of(problem, &trajectory, &modes).expect("an instant");
        Some((plan, trajectory, summary, SteadyState::of(problem)))
    });
    let participation = Participation::of_parts(system);
    let analysis = Analysis {
        participation: &participation,
        title: "a scene",
        system,
        structure: system.structure(),
        modes: &modes,
        response: solved.as_ref().zip(problem.as_ref()).map(
            |((plan, trajectory, summary, steady_state), problem)| Answer {
                problem,
                plan,
                trajectory,
                summary,
                steady_state,
            },
        ),
        switched: None,
    };
    clean(&analysis.text());
    let report = ModeReport::new(&modes, system.names());
    clean(&report.markdown());
    json(|out| report.json(out));
    written(|out| report.csv(out));
    let energy = problem
        .as_ref()
        .zip(solved.as_ref())
        .and_then(|(problem, solved)| Energy::along(problem, &solved.1).map_err(said).ok());
    if let Some((problem, (_, trajectory, ..))) = problem.as_ref().zip(solved.as_ref()) {
        let report = ResponseReport::new(trajectory, system.names()).with_units(problem);
        json(|out| report.json(out));
        written(|out| report.text(out));
        written(|out| report.csv(out));
        let extrema = solved.as_ref().and_then(|solved| solved.2.extrema());
        let report = DemandReport::new(problem, trajectory, extrema);
        written(|out| report.accelerations(out));
        written(|out| report.forces(out));
        written(|out| report.peaks(out));
        if let Some(energy) = &energy {
            written(|out| EnergyReport::new(energy, trajectory).csv(out));
        }
    }
    let page = Page {
        analysis: &analysis,
        frequency: None,
        energy: energy.as_ref(),
    };
    // Its script has words of its own.
    let html = page.html();
    let (drawn, _) = html.split_once("<script>").expect("a script");
    clean(drawn);
}

fn checked(scene: &Scene) {
    let Ok(modes) = ModeComparison::measure(scene.system(), &mut |_| {}).map_err(said) else {
        return;
    };
    let problem = scene.problem().map(|problem| problem.expect("checked"));
    let step = problem.as_ref().map(|problem| problem.grid().step());
    let exponentials = step.and_then(|step| {
        let compared = ExponentialComparison::measure(scene.system(), step, &mut |_| {});
        compared.map_err(said).ok()
    });
    let integrators: [Box<dyn Integrator>; 2] = [
        Box::new(Dop853::with_tolerance(1e-6)),
        Box::new(Newmark::with_substeps(2)),
    ];
    let effort = Effort {
        instants: 50,
        run: Duration::from_millis(100),
        total: Duration::from_millis(300),
    };
    let response = problem.map(|problem| {
        let compared =
            WorkPrecision::measure(&problem, methods(), &integrators, effort, &mut |_| {});
        if let Err(error) = &compared {
            said(error);
        }
        compared
    });
    let report = CheckReport {
        title: "a scene",
        modes: &modes,
        exponentials: exponentials.as_ref(),
        response: response.as_ref().map(Result::as_ref),
    };
    clean(&report.text());
    clean(&report.markdown());
    json(|out| report.json(out));
    if let Some(plot) = report.plot() {
        clean(&plot.svg());
    }
}

/// Peaks are as large as any displacement and what has settled stays so, as the motion at events, just before them and
/// at other times shows.
pub fn peaks_and_settling_hold(scene: &Scene) {
    let problem = scene.problem().expect("it has instants").expect("checked");
    let plan = ResponsePlan::of(&problem).expect("a plan");
    let trajectory = plan.run(&problem).expect("a motion");
    assert_eq!(trajectory.bounds(), Bounds::Proven);
    let modes = scene.system().modes().expect("modes");
    let summary = Summary::of(&problem, &trajectory, &modes).expect("an instant");
    assert!(summary.is_between());
    let end = problem.grid().time(problem.grid().last());
    let starts = problem
        .timeline()
        .pieces()
        .iter()
        .map(|piece| piece.start());
    let mut times: Vec<f64> = starts.flat_map(|at| [at, at * (1.0 - 1e-9)]).collect();
    times.extend((0..=40).map(|k| end * f64::from(k) / 40.0));
    let motion = ByCertifiedExponential
        .at(&problem, &times)
        .expect("a motion");
    let largest = motion.displacement().norm_max();
    for (i, course) in summary.coordinates().iter().enumerate() {
        let peak = course.peak.abs();
        for (k, time) in times.iter().enumerate() {
            let (x, v) = (motion.displacement()[(i, k)], motion.velocity()[(i, k)]);
            let rounding = 1e-10 * largest;
            assert!(x.abs() <= peak + rounding, "{i} at {time}: {x} {course:?}");
            assert!(v.abs() <= course.fastest.abs() * (1.0 + 1e-10) + rounding);
            let Destination::Rest {
                displacement,
                settled,
                ..
            } = course.destination
            else {
                continue;
            };
            let band = 0.02 * (peak + displacement.abs()) * (1.0 + 1e-6) + rounding;
            let settled = settled.unwrap_or(f64::INFINITY);
            assert!(
                *time <= settled * (1.0 + 1e-6) || (x - displacement).abs() <= band,
                "{i} at {time}: {x} {course:?}"
            );
        }
    }
}
