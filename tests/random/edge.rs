//! Scenes at the edges of motion: nothing holds them, nothing has mass, nothing pulls, something grows without
//! end; and scenes whose displacements jump at any instant.

use super::choices::Choices;
use super::number::Spread;

/// The most steps of the grid.
const STEPS: usize = 6;

fn list(key: &str, entries: &[String]) -> String {
    format!("\"{key}\": [{}]", entries.join(", "))
}

fn element(a: &str, b: &str, key: &str, value: f64) -> String {
    format!("{{\"between\": [\"{a}\", \"{b}\"], \"{key}\": {value:?}}}")
}

/// At the start, at an instant, between two, at the end, or after it.
fn instant(choices: &mut Choices<'_>, step: f64, count: usize) -> f64 {
    let end = step * count as f64;
    match choices.below(6) {
        0 => 0.0,
        1 => end,
        2 | 3 => end * choices.fraction(),
        4 => step * choices.below(count + 1) as f64,
        _ => end + step,
    }
}

/// Free, massless, unstable or at rest.
pub fn still(choices: &mut Choices<'_>) -> String {
    let kind = choices.below(6);
    let n = 1 + choices.below(3);
    let spread = Spread::draw(choices);
    let names: Vec<String> = (1..=n).map(|i| format!("m{i}")).collect();
    let masses = names.iter().map(|name| {
        let mass = match kind {
            1 => 0.0,
            2 if choices.once_in(2) => 0.0,
            _ => spread.positive(choices),
        };
        format!("{{\"name\": \"{name}\", \"mass\": {mass:?}}}")
    });
    let mut members = vec![list("masses", &masses.collect::<Vec<_>>())];
    let (mut springs, mut dampers) = (Vec::new(), Vec::new());
    for (i, name) in names.iter().enumerate() {
        let before = if i == 0 { "ground" } else { &names[i - 1] };
        match kind {
            // Nothing at all.
            0 => {}
            // Massless: springs or dampers to the ground.
            1 | 2 => {
                springs.push(element(before, name, "stiffness", spread.positive(choices)));
                if choices.once_in(2) {
                    dampers.push(element("ground", name, "damping", spread.positive(choices)));
                }
            }
            // Masses that only each other hold.
            3 if i > 0 => {
                springs.push(element(
                    before,
                    name,
                    "stiffness",
                    spread.coefficient(choices),
                ));
                dampers.push(element(
                    before,
                    name,
                    "damping",
                    spread.coefficient(choices),
                ));
            }
            // What grows, up to e^(1e10) in a second.
            4 => {
                let rate = 10f64.powf(20.0 * choices.fraction());
                springs.push(element("ground", name, "stiffness", -rate));
            }
            // Elements of nothing.
            5 => {
                springs.push(element(before, name, "stiffness", 0.0));
                dampers.push(element(before, name, "damping", 0.0));
            }
            _ => {}
        }
    }
    members.push(list("springs", &springs));
    members.push(list("dampers", &dampers));
    let (step, count) = (0.5, choices.below(STEPS));
    let mut initial = Vec::new();
    for name in &names {
        if choices.once_in(2) && kind != 1 && kind != 2 {
            let (x, v) = (spread.signed(choices), spread.signed(choices));
            initial.push(format!(
                "\"{name}\": {{\"displacement\": {x:?}, \"velocity\": {v:?}}}"
            ));
        }
    }
    members.push(format!("\"initial\": {{{}}}", initial.join(", ")));
    let mut loads = Vec::new();
    for name in &names {
        let (size, at) = (spread.signed(choices), instant(choices, step, count));
        match choices.below(4) {
            0 => loads.push(format!(
                "{{\"on\": \"{name}\", \"step\": {{\"force\": {size:?}, \"start\": {at:?}}}}}"
            )),
            1 if kind != 1 && kind != 2 => loads.push(format!(
                "{{\"on\": \"{name}\", \"impulse\": {{\"magnitude\": {size:?}, \"at\": {at:?}}}}}"
            )),
            _ => {}
        }
    }
    members.push(list("loads", &loads));
    if !choices.once_in(3) {
        let end = step * count as f64;
        members.push(format!(
            "\"time\": {{\"end\": {end:?}, \"step\": {step:?}}}"
        ));
    }
    format!("{{{}}}", members.join(",\n"))
}

/// A damped mass between two nodes without mass, p damped and q not, under loads that make these jump.
pub fn jumping(choices: &mut Choices<'_>) -> String {
    let (step, count) = (0.5, 1 + choices.below(STEPS));
    let mut number = || 1.0 + choices.below(9) as f64;
    let springs = [
        element("ground", "p", "stiffness", number()),
        element("p", "m", "stiffness", number()),
        element("m", "q", "stiffness", number()),
        element("q", "ground", "stiffness", number()),
    ];
    let dampers = [
        element("ground", "p", "damping", 0.1 * number()),
        element("ground", "m", "damping", number()),
    ];
    let mut loads = Vec::new();
    for _ in 0..1 + choices.below(4) {
        let at = instant(choices, step, count);
        let size = f64::from(choices.byte()) - 128.0;
        loads.push(match choices.below(5) {
            0 | 1 => format!(
                "{{\"on\": \"p\", \"impulse\": {{\"magnitude\": {size:?}, \"at\": {at:?}}}}}"
            ),
            2 => format!("{{\"on\": \"q\", \"step\": {{\"force\": {size:?}, \"start\": {at:?}}}}}"),
            3 => format!(
                "{{\"on\": \"m\", \"impulse\": {{\"magnitude\": {size:?}, \"at\": {at:?}}}}}"
            ),
            _ => {
                let spacing = step / [1.0, 2.0, 4.0][choices.below(3)];
                let values: Vec<f64> = (0..1 + choices.below(9))
                    .map(|_| f64::from(choices.byte()) - 128.0)
                    .collect();
                format!(
                    "{{\"on\": \"q\", \"samples\": {{\"step\": {spacing:?}, \"values\": {values:?}, \"hold\": \"zero\"}}}}"
                )
            }
        });
    }
    let masses = [("p", 0.0), ("m", 1.0), ("q", 0.0)]
        .map(|(name, mass)| format!("{{\"name\": \"{name}\", \"mass\": {mass:?}}}"));
    let end = step * count as f64;
    format!(
        "{{{},\n{},\n{},\n{},\n\"time\": {{\"end\": {end:?}, \"step\": {step:?}}}}}",
        list("masses", &masses),
        list("springs", &springs),
        list("dampers", &dampers),
        list("loads", &loads)
    )
}
