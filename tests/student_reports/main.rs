//! Two student reports, done again: every figure and table of docs/student-reports.md, from exact motions
//! and from ode45's method at its default tolerances.

mod ode45;
#[path = "../page/mod.rs"]
mod page;

use std::fmt::Write;

use eigentone::gallery::cases;
use eigentone::prelude::*;
use eigentone::report::{Axis, Line, Plot};
use eigentone::response::{
    ByCertifiedExponential, CoordinateSummary, Destination, Problem, Summary,
};
use eigentone::scene::Scene;
use faer::MatRef;
use faer::linalg::solvers::DenseSolveCore;

use ode45::{DEFAULT, Solution, Tolerances, solve};

/// A scene's exact motion on a fine grid, and that of ode45 beside the exact one at the same instants.
struct Study {
    scene: Scene,
    end: f64,
    fine: Trajectory,
    integrated: Solution,
    exact: Trajectory,
    summary: Summary,
}

/// Enough for pictures and for errors of 1e-6.
const DIGITS: Precision = Precision::Certified { tolerance: 1e-10 };

fn problem<'a>(scene: &'a Scene) -> Problem<'a> {
    scene
        .problem()
        .expect("it has times")
        .expect("it was checked")
}

fn study(name: &str, step: f64) -> Study {
    let case = cases()
        .iter()
        .find(|case| case.name() == name)
        .expect("a scene of the gallery");
    let scene = case.scene();
    let asked = problem(&scene);
    let (grid, system) = (*asked.grid(), asked.system());
    let end = grid.time(grid.last());

    // The same question on a finer grid.
    let mut finer = Response::of(system).every(step).until(end).to(DIGITS);
    let mut state = State::at_rest();
    for (i, name) in system.names().iter().enumerate() {
        state = state
            .displace(name, asked.initial_displacement()[i])
            .push(name, asked.initial_velocity()[i]);
    }
    for load in asked.loads() {
        finer = finer.load(&system.names()[load.coordinate], load.load.clone());
    }
    let finer = finer.from(state).problem().expect("a problem");
    let fine = ByCertifiedExponential.run(&finer).expect("a motion");
    let modes = system.modes().expect("modes");
    let summary = Summary::of(&finer, &fine, &modes).expect("instants");

    let integrated = integrate(&asked, end, DEFAULT);
    let exact = ByCertifiedExponential
        .at(&finer, &integrated.times)
        .expect("a motion");
    drop((asked, finer));
    Study {
        scene,
        end,
        fine,
        integrated,
        exact,
        summary,
    }
}

/// ode45 on M x″ = f − C x′ − K x, under the constant forces of these scenes.
fn integrate(problem: &Problem<'_>, end: f64, tolerances: Tolerances) -> Solution {
    let system = problem.system();
    let n = system.len();
    let (c, k) = (system.damping_matrix(), system.stiffness_matrix());
    let inverse = system.mass_matrix().partial_piv_lu().inverse();
    let mut force = vec![0.0; n];
    for load in problem.loads() {
        match load.load {
            Load::Step(Step {
                force: value,
                start: 0.0,
            }) => force[load.coordinate] += value,
            _ => panic!("a force from the beginning"),
        }
    }
    let f = |y: &[f64]| -> Vec<f64> {
        let net = |i: usize| {
            let resisting = (0..n).map(|j| k[(i, j)] * y[j] + c[(i, j)] * y[n + j]);
            force[i] - resisting.sum::<f64>()
        };
        let accelerations = (0..n).map(|i| (0..n).map(|j| inverse[(i, j)] * net(j)).sum());
        y[n..].iter().copied().chain(accelerations).collect()
    };
    let start = [problem.initial_displacement(), problem.initial_velocity()].concat();
    solve(f, &start, end, tolerances)
}

impl Study {
    fn names(&self) -> &[String] {
        self.scene.system().names()
    }

    /// ode45's largest error over the coordinates at each of its instants: of displacements or velocities.
    fn errors(&self, velocity: bool) -> Vec<f64> {
        let n = self.names().len();
        let (exact, from) = match velocity {
            false => (self.exact.displacement(), 0),
            true => (self.exact.velocity(), n),
        };
        let off = |(column, state): (usize, &Vec<f64>)| {
            (0..n)
                .map(|i| (state[from + i] - exact[(i, column)]).abs())
                .fold(0.0, f64::max)
        };
        self.integrated.states.iter().enumerate().map(off).collect()
    }

    /// The displacement of largest size that a list of instants shows.
    fn seen(values: impl Iterator<Item = f64>) -> f64 {
        values.fold(
            0.0,
            |most: f64, x| if x.abs() > most.abs() { x } else { most },
        )
    }
}

fn largest(values: MatRef<'_, f64>) -> f64 {
    values.norm_max()
}

/// Two significant digits.
fn short(x: f64) -> String {
    let power = x.abs().log10().floor() as i32;
    match power {
        _ if x == 0.0 => "0".to_owned(),
        -3..2 => format!("{x:.*}", (1 - power) as usize),
        _ => format!("{x:.1e}").replace('-', "−"),
    }
}

/// Five decimals.
fn metres(x: f64) -> String {
    format!("{x:.5}").replace('-', "−")
}

fn percent(x: f64) -> String {
    format!("{}\u{a0}%", short(100.0 * x))
}

fn mode_rows(table: &mut String, label: &str, study: &Study) {
    for (j, mode) in study
        .scene
        .system()
        .modes()
        .expect("modes")
        .iter()
        .enumerate()
    {
        let root = mode.eigenvalue().value;
        let oscillates = root.im != 0.0;
        let _ = writeln!(
            table,
            "| {} | {} | {} | {} | {} | {:.5} | {} |",
            if j == 0 { label } else { "" },
            j + 1,
            if oscillates {
                format!("−{:.6}\u{a0}±\u{a0}{:.6}i", -root.re, root.im)
            } else {
                format!("−{:.6}", -root.re)
            },
            metres(mode.natural_frequency().hertz()),
            mode.damping_ratio()
                .map_or("–".to_owned(), |zeta| format!("{zeta:.5}")),
            mode.time_constant().expect("it decays"),
            mode.motion(),
        );
    }
}

const MODES: &str = "| scene | # | λ, 1/s | f_n, Hz | ζ | time constant, s | motion |\n|---|--:|---|--:|--:|--:|---|\n";

/// Where everything ends up, exactly, and the peak that ode45's points and one sample a second show.
fn summary_rows(table: &mut String, label: &str, study: &Study) {
    let n = study.names().len();
    for (i, coordinate) in study.summary.coordinates().iter().enumerate() {
        let end = metres(end_of(coordinate));
        let settled = match coordinate.destination {
            Destination::Rest {
                settled: Some(time),
                ..
            } => format!("{time:.3}"),
            _ => "–".to_owned(),
        };
        let by_ode45 = Study::seen(study.integrated.states.iter().map(|state| state[i]));
        let every_second = (0..study.fine.len()).filter(|j| study.fine.times()[*j].fract() == 0.0);
        let by_samples = Study::seen(every_second.map(|j| study.fine.displacement()[(i, j)]));
        assert_eq!(study.integrated.states[0].len(), 2 * n);
        let _ = writeln!(
            table,
            "| {} | {} | {end} | {} | {:.3} | {settled} | {} | {} |",
            if i == 0 { label } else { "" },
            study.names()[i],
            metres(coordinate.peak),
            coordinate.peak_time,
            metres(by_ode45),
            metres(by_samples),
        );
    }
}

const SUMMARY: &str = "| scene | mass | ends at, m | peak, m | peak at, s | settled after, s | peak by ode45, m | peak by samples of 1 s, m |\n|---|---|--:|--:|--:|--:|--:|--:|\n";

/// Where a coordinate comes to rest.
fn end_of(coordinate: &CoordinateSummary) -> f64 {
    match coordinate.destination {
        Destination::Rest { displacement, .. } => displacement,
        _ => panic!("it comes to rest"),
    }
}

/// ode45's work and errors. The exact motion is what is left of it in the last quarter, about the end.
fn error_row(table: &mut String, label: &str, study: &Study) {
    let (x, v) = (study.errors(false), study.errors(true));
    let worst = |errors: &[f64]| errors.iter().copied().fold(0.0, f64::max);
    let at = x
        .iter()
        .position(|error| *error == worst(&x))
        .expect("there are errors");
    // What it makes of the end, where all has come to rest.
    let tail = study
        .integrated
        .times
        .iter()
        .zip(&x)
        .filter(|(t, _)| **t > 0.75 * study.end);
    let tail = tail.map(|(_, error)| *error).fold(0.0, f64::max);
    let ends: Vec<f64> = study.summary.coordinates().iter().map(end_of).collect();
    let late = (0..study.exact.len()).filter(|j| study.exact.times()[*j] > 0.75 * study.end);
    let exact = study.exact.displacement();
    let deviation = |j: usize| (0..ends.len()).map(move |i| (i, j));
    let still = late
        .flat_map(deviation)
        .map(|(i, j)| (exact[(i, j)] - ends[i]).abs());
    let still = still.fold(0.0, f64::max);
    let _ = writeln!(
        table,
        "| {label} | {} | {} | {} | {} | {:.1} | {} | {} | {} |",
        study.integrated.steps,
        study.integrated.failed,
        short(worst(&x)),
        percent(worst(&x) / largest(study.exact.displacement())),
        study.exact.times()[at],
        percent(worst(&v) / largest(study.exact.velocity())),
        short(tail),
        short(still),
    );
}

const ERRORS: &str = "| scene | steps | rejected | worst error, m | of the largest displacement | at, s | of the largest velocity | worst error in the last quarter, m | exact motion there, m |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|\n";

/// Displacements or velocities of some studies in one picture.
fn picture(name: &str, title: &str, studies: &[(&str, &Study)], velocity: bool) {
    let mut lines = Vec::new();
    for (suffix, study) in studies {
        let values = if velocity {
            study.fine.velocity()
        } else {
            study.fine.displacement()
        };
        for (i, mass) in study.names().iter().enumerate() {
            let point = move |j: usize| (study.fine.times()[j], values[(i, j)]);
            lines.push(Line::new(
                &format!("{mass}{suffix}"),
                study.fine.len(),
                point,
            ));
        }
    }
    let y = if velocity {
        Axis::linear("velocity", "m/s")
    } else {
        Axis::linear("displacement", "m")
    };
    draw(name, title, y, lines);
}

fn error_picture(name: &str, title: &str, studies: &[(&str, &Study)]) {
    let lines = studies.iter().map(|(label, study)| {
        let errors = study.errors(false);
        // Ends of steps only, and none of the rounding of the first ones.
        let shown = |error: f64| if error > 1e-9 { error } else { f64::NAN };
        let point = move |j: usize| (study.integrated.times[4 * j], shown(errors[4 * j]));
        Line::new(label, study.integrated.steps + 1, point)
    });
    draw(
        name,
        title,
        Axis::logarithmic("error of displacement", "m"),
        lines.collect(),
    );
}

fn draw(name: &str, title: &str, y: Axis, lines: Vec<Line<'_>>) {
    let plot = Plot {
        title: title.to_owned(),
        x: Axis::linear("time", "s"),
        y,
        lines,
        ring: None,
    };
    page::assert_drawn(&format!("student-reports/{name}.svg"), &plot.svg());
}

#[test]
fn two_masses() {
    let [free, forced, modified_free, modified_forced] = [
        "two-mass-free",
        "two-mass-forced",
        "two-mass-modified-free",
        "two-mass-modified-forced",
    ]
    .map(|name| study(name, 0.125));
    let both = |original, modified| [("", original), (", modified", modified)];
    let pair = both(&free, &modified_free);
    picture(
        "two-mass-free-displacement",
        "Two masses, released from 1 m",
        &pair,
        false,
    );
    picture(
        "two-mass-free-velocity",
        "Velocities of two masses, released from 1 m",
        &pair,
        true,
    );
    let pair = both(&forced, &modified_forced);
    picture(
        "two-mass-forced-displacement",
        "Two masses, 1 N on the second",
        &pair,
        false,
    );
    picture(
        "two-mass-forced-velocity",
        "Velocities of two masses, 1 N on the second",
        &pair,
        true,
    );

    let all = [
        ("free", &free),
        ("forced", &forced),
        ("modified, free", &modified_free),
        ("modified, forced", &modified_forced),
    ];
    error_picture(
        "two-mass-errors",
        "What ode45 gets wrong with default tolerances",
        &all,
    );
    let (mut modes, mut summary, mut errors) =
        (MODES.to_owned(), SUMMARY.to_owned(), ERRORS.to_owned());
    mode_rows(&mut modes, "original", &free);
    mode_rows(&mut modes, "modified", &modified_free);
    for (label, study) in all {
        summary_rows(&mut summary, label, study);
        error_row(&mut errors, label, study);
    }
    page::assert_shown("student-reports.md", "two-mass modes", &modes);
    page::assert_shown("student-reports.md", "two-mass motion", &summary);
    page::assert_shown("student-reports.md", "two-mass errors", &errors);
}

#[test]
fn three_masses() {
    let studies: Vec<Study> = (1..=6)
        .map(|i| study(&format!("three-mass-{i}"), 0.25))
        .collect();
    let labels: Vec<String> = (1..=6).map(|i| format!("scenario\u{a0}{i}")).collect();
    let all: Vec<(&str, &Study)> = labels.iter().map(String::as_str).zip(&studies).collect();
    for (i, study) in studies.iter().enumerate() {
        let title = study.scene.title().expect("it has one");
        let (_, title) = title.split_once(", ").expect("the scenario");
        let title = title[..1].to_uppercase() + &title[1..];
        picture(
            &format!("three-mass-{}-displacement", i + 1),
            &title,
            &[("", study)],
            false,
        );
        picture(
            &format!("three-mass-{}-velocity", i + 1),
            &title,
            &[("", study)],
            true,
        );
    }
    error_picture(
        "three-mass-errors",
        "What ode45 gets wrong with default tolerances",
        &all,
    );

    // The third mass of scenario 5, as one sample a second shows it.
    let light = study("three-mass-5", 0.0625);
    let (times, x) = (light.fine.times(), light.fine.displacement());
    let until = times.iter().take_while(|t| **t <= 20.0).count();
    let lines = vec![
        Line::new("m3", until, |j| (times[j], x[(2, j)])),
        Line::new("samples of 1 s", until.div_ceil(16), |j| {
            (times[16 * j], x[(2, 16 * j)])
        })
        .marked(),
    ];
    draw(
        "three-mass-5-sampled",
        "Light masses, one sample a second",
        Axis::linear("displacement", "m"),
        lines,
    );

    let (mut modes, mut summary, mut errors) =
        (MODES.to_owned(), SUMMARY.to_owned(), ERRORS.to_owned());
    for (label, study) in all {
        mode_rows(&mut modes, label, study);
        summary_rows(&mut summary, label, study);
        error_row(&mut errors, label, study);
    }
    page::assert_shown("student-reports.md", "three-mass modes", &modes);
    page::assert_shown("student-reports.md", "three-mass motion", &summary);
    page::assert_shown("student-reports.md", "three-mass errors", &errors);
}
