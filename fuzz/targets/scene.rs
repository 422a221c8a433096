//! Any bytes as a scene file: read, solved in doubles, and its motion at a few instants.

#![no_main]

use std::path::Path;

use eigentone::modes::Precision;
use eigentone::response::ResponsePlan;
use eigentone::scene::Scene;
use libfuzzer_sys::fuzz_target;

/// Larger systems only take longer.
const LARGEST: usize = 12;

fuzz_target!(|bytes: &[u8]| {
    let text = String::from_utf8_lossy(bytes);
    let scene = match Scene::parse(&text, Path::new("scene.json")) {
        Ok(scene) => scene,
        Err(error) => {
            let message = error.to_string();
            assert!(message.starts_with("scene.json:") && message.len() < 1000);
            assert!(!message.contains('\n'));
            return;
        }
    };
    if scene.system().len() > LARGEST {
        return;
    }
    let _ = scene.system().modes_to(Precision::Double);
    let Some(problem) = scene.problem() else {
        return;
    };
    let problem = problem.expect("it was checked when it was read");
    let last = problem.grid().last();
    let instants = [0, last.min(1), last.min(7), last / 2, last];
    let problem = problem.at(&instants).expect("all lie on the grid");
    let problem = problem.to(Precision::Double);
    let _ = ResponsePlan::of(&problem).and_then(|plan| plan.run(&problem));
});
