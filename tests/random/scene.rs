//! Scenes as text: networks of every form, matrices, all kinds of loads, events between the instants.

use super::choices::Choices;
use super::number::Spread;

/// The most coordinates that a scene has.
pub const LARGEST: usize = 8;

/// The text of a scene: valid JSON that keeps to the format. Some have no answer all the same, for instance
/// where nothing holds a massless node.
pub fn text(choices: &mut Choices<'_>) -> String {
    let n = 1 + choices.below(LARGEST);
    let spread = Spread::draw(choices);
    let names: Vec<String> = (1..=n).map(|i| format!("m{i}")).collect();
    let mut members = Vec::new();
    let matrices = choices.once_in(5).then(|| matrices(choices, n, spread));
    let named = matrices.is_none() || choices.once_in(2);
    if named {
        members.push(masses(choices, &names, spread));
    }
    let names = match named {
        true => names,
        false => (1..=n).map(|i| format!("x{i}")).collect(),
    };
    members.extend(matrices);
    let springs = elements(choices, &names, spread, "stiffness");
    members.push(format!("\"springs\": [{springs}]"));
    if !choices.once_in(4) {
        let apart = if choices.once_in(3) {
            Spread::draw(choices)
        } else {
            spread
        };
        let dampers = elements(choices, &names, apart, "damping");
        members.push(format!("\"dampers\": [{dampers}]"));
    }
    let (step, count) = instants(choices);
    members.push(initial(choices, &names, spread));
    let loads: Vec<String> = (0..choices.below(5))
        .map(|_| load(choices, &names, spread, step, count))
        .collect();
    members.push(format!("\"loads\": [{}]", loads.join(", ")));
    if !choices.once_in(8) {
        let end = step * count as f64;
        members.push(format!(
            "\"time\": {{\"end\": {end:?}, \"step\": {step:?}}}"
        ));
    }
    format!("{{{}}}", members.join(",\n"))
}

/// The text of a machine: points on masses and supports, supports that move, damping of the whole, outputs.
#[allow(dead_code)] // only some of those who share this ask
pub fn machine(choices: &mut Choices<'_>) -> String {
    machine_with(choices, |_, _, _| Vec::new())
}

/// The same with switches between its names.
#[allow(dead_code)] // only some of those who share this ask
pub fn switched_machine(choices: &mut Choices<'_>) -> String {
    machine_with(choices, switches)
}

/// More members of a machine, from the names of all that moves and how far its numbers lie apart.
type More = fn(&mut Choices<'_>, &[String], Spread) -> Vec<String>;

fn switches(choices: &mut Choices<'_>, names: &[String], spread: Spread) -> Vec<String> {
    let each = (0..1 + choices.below(4)).map(|_| {
        let places = names.len() + 1;
        let first = choices.below(places);
        let second = (first + 1 + choices.below(places - 1)) % places;
        let name = |place: usize| names.get(place).map_or("ground", String::as_str);
        let between = format!("\"between\": [\"{}\", \"{}\"]", name(first), name(second));
        let (low, high) = (spread.positive(choices), spread.positive(choices));
        let gap = match choices.below(3) {
            0 => 0.0,
            1 => spread.signed(choices),
            _ => spread.positive(choices),
        };
        let (key, rest) = match choices.below(5) {
            0 => ("frictions", format!("\"force\": {low:?}")),
            1 => (
                "frictions",
                format!("\"force\": {low:?}, \"static\": {high:?}"),
            ),
            2 => {
                let damping = if choices.once_in(2) { high } else { 0.0 };
                (
                    "stops",
                    format!("\"gap\": {gap:?}, \"stiffness\": {low:?}, \"damping\": {damping:?}"),
                )
            }
            3 => {
                let restitution = choices.pick(&[0.0, 0.5, 0.8, 1.0]);
                (
                    "impacts",
                    format!("\"gap\": {gap:?}, \"restitution\": {restitution:?}"),
                )
            }
            _ => {
                let law = match choices.once_in(2) {
                    true => "\"law\": \"on-off skyhook\"".to_owned(),
                    false => format!("\"law\": \"clipped skyhook\", \"sky\": {low:?}"),
                };
                let high = low.max(high);
                (
                    "controlled_dampers",
                    format!("{law}, \"low\": {low:?}, \"high\": {high:?}"),
                )
            }
        };
        (key, format!("{{{between}, {rest}}}"))
    });
    let each: Vec<(&str, String)> = each.collect();
    let list = |key: &'static str| {
        let own = each.iter().filter(|(kind, _)| *kind == key);
        let own: Vec<&str> = own.map(|(_, text)| text.as_str()).collect();
        format!("\"{key}\": [{}]", own.join(", "))
    };
    ["frictions", "stops", "impacts", "controlled_dampers"]
        .map(list)
        .to_vec()
}

fn machine_with(choices: &mut Choices<'_>, more: More) -> String {
    let n = 1 + choices.below(LARGEST / 2);
    let spread = Spread::draw(choices);
    let names: Vec<String> = (1..=n).map(|i| format!("m{i}")).collect();
    let supports: Vec<String> = (0..choices.below(3)).map(|i| format!("s{i}")).collect();
    let points: Vec<String> = (0..choices.below(4)).map(|i| format!("p{i}")).collect();
    let quoted = |names: &[String]| {
        let quoted: Vec<String> = names.iter().map(|name| format!("{name:?}")).collect();
        quoted.join(", ")
    };
    let moving = [&names[..], &supports].concat();
    let loaded = [&names[..], &points].concat();
    let all = [&moving[..], &points].concat();
    let mut members = vec![
        masses(choices, &names, spread),
        format!("\"supports\": [{}]", quoted(&supports)),
    ];
    let factor = |choices: &mut Choices<'_>| match choices.below(4) {
        0 => 1.0,
        1 => -1.0,
        2 => 0.1 * choices.below(40) as f64,
        _ => spread.signed(choices),
    };
    let sum = |choices: &mut Choices<'_>, of: &[String]| {
        let first = choices.below(of.len());
        let count = 1 + choices.below(of.len().min(3));
        let terms = (0..count).map(|k| {
            let name = &of[(first + k) % of.len()];
            format!("\"{name}\": {:?}", factor(choices))
        });
        terms.collect::<Vec<_>>().join(", ")
    };
    let made = points.iter().map(|name| {
        let moves = sum(choices, &moving);
        let mass = if choices.once_in(3) {
            spread.positive(choices)
        } else {
            0.0
        };
        format!("{{\"name\": \"{name}\", \"moves\": {{{moves}}}, \"mass\": {mass:?}}}")
    });
    let made: Vec<String> = made.collect();
    members.push(format!("\"points\": [{}]", made.join(", ")));
    for (list, key) in [("springs", "stiffness"), ("dampers", "damping")] {
        let elements = elements(choices, &all, spread, key);
        members.push(format!("\"{list}\": [{elements}]"));
    }
    match choices.below(5) {
        0 => members.push("\"damping\": {\"modal\": [0.02, 0.5]}".to_owned()),
        1 => {
            let (mass, stiffness) = (spread.positive(choices), spread.positive(choices));
            members.push(format!(
                "\"damping\": {{\"rayleigh\": {{\"mass\": {mass:?}, \"stiffness\": {stiffness:?}}}}}"
            ));
        }
        _ => {}
    }
    let (step, count) = instants(choices);
    members.push(initial(choices, &names, spread));
    let loads = (0..choices.below(3)).map(|_| load(choices, &loaded, spread, step, count));
    let loads: Vec<String> = loads.collect();
    members.push(format!("\"loads\": [{}]", loads.join(", ")));
    if !supports.is_empty() {
        let motions = (0..choices.below(4)).map(|_| motion(choices, &supports, spread, step));
        let motions: Vec<String> = motions.collect();
        members.push(format!("\"motions\": [{}]", motions.join(", ")));
    }
    let outputs = (0..choices.below(4)).map(|k| {
        let quantity = choices.pick(&["displacement", "velocity", "acceleration"]);
        format!(
            "{{\"name\": \"o{k}\", \"{quantity}\": {{{}}}}}",
            sum(choices, &all)
        )
    });
    let outputs: Vec<String> = outputs.collect();
    members.extend(more(choices, &all, spread));
    members.push(format!("\"outputs\": [{}]", outputs.join(", ")));
    let end = step * count as f64;
    members.push(format!(
        "\"time\": {{\"end\": {end:?}, \"step\": {step:?}}}"
    ));
    format!("{{{}}}", members.join(",\n"))
}

fn motion(choices: &mut Choices<'_>, supports: &[String], spread: Spread, step: f64) -> String {
    let of = &supports[choices.below(supports.len())];
    let quantity = choices.pick(&["displacement", "velocity", "acceleration"]);
    let size = spread.signed(choices);
    let start = step * 0.5 * choices.below(8) as f64;
    let course = match choices.below(6) {
        0 => format!("\"step\": {{\"height\": {size:?}, \"start\": {start:?}}}"),
        1 => format!("\"ramp\": {{\"rate\": {size:?}, \"start\": {start:?}}}"),
        2 => format!(
            "\"harmonic\": {{\"amplitude\": {size:?}, \"frequency\": {:?}}}",
            1.0 / step
        ),
        3 => {
            let coefficients: Vec<f64> = (0..1 + choices.below(7))
                .map(|_| {
                    if choices.once_in(2) {
                        0.0
                    } else {
                        spread.signed(choices)
                    }
                })
                .collect();
            format!("\"polynomial\": {{\"coefficients\": {coefficients:?}, \"start\": {start:?}}}")
        }
        4 => format!(
            "\"versine\": {{\"height\": {size:?}, \"duration\": {:?}, \"start\": {start:?}}}",
            3.5 * step
        ),
        _ => format!(
            "\"samples\": {{\"step\": {step:?}, \"values\": [0.0, {size:?}, 1.0], \"hold\": \"{}\"}}",
            choices.pick(&["zero", "first"])
        ),
    };
    format!("{{\"of\": \"{of}\", \"{quantity}\": {{{course}}}}}")
}

fn masses(choices: &mut Choices<'_>, names: &[String], spread: Spread) -> String {
    let identical = choices.once_in(4).then(|| spread.positive(choices));
    let masses = names.iter().map(|name| {
        let mass = match choices.once_in(9) {
            true => 0.0,
            false => identical.unwrap_or_else(|| spread.positive(choices)),
        };
        format!("{{\"name\": \"{name}\", \"mass\": {mass:?}}}")
    });
    let masses: Vec<String> = masses.collect();
    format!("\"masses\": [{}]", masses.join(", "))
}

fn matrices(choices: &mut Choices<'_>, n: usize, spread: Spread) -> String {
    let mut members = Vec::new();
    for kind in ["mass", "damping", "stiffness"] {
        if choices.once_in(3) {
            continue;
        }
        let form = choices.below(4);
        let mut rows = vec![vec![0.0; n]; n];
        for (i, j) in (0..n).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            let entry = match (form, i == j) {
                (_, true) => 4.0 * spread.positive(choices).min(1e307),
                (0, _) => 0.0,
                _ => spread.signed(choices),
            };
            rows[j][i] = match form {
                1 | 2 => entry,
                _ => spread.signed(choices),
            };
            rows[i][j] = entry;
        }
        let rows: Vec<String> = rows.iter().map(|row| format!("{row:?}")).collect();
        members.push(format!("\"{kind}\": [{}]", rows.join(", ")));
    }
    format!("\"matrices\": {{{}}}", members.join(", "))
}

/// Springs or dampers: a chain, a star, loose parts, or any pairs.
fn elements(choices: &mut Choices<'_>, names: &[String], spread: Spread, key: &str) -> String {
    let n = names.len();
    let node = |index: usize| match index {
        0 => "ground",
        index => &names[index - 1],
    };
    let pairs: Vec<(usize, usize)> = match choices.below(7) {
        0 => (1..=n).map(|i| (i - 1, i)).collect(),
        1 => (2..=n).map(|i| (i - 1, i)).collect(),
        2 => (1..=n).map(|i| (0, i)).collect(),
        3 => (2..=n).map(|i| (1, i)).collect(),
        4 => (1..=n).filter(|i| i % 3 != 0).map(|i| (i - 1, i)).collect(),
        5 => (0..=n).flat_map(|i| (0..i).map(move |j| (j, i))).collect(),
        _ => (0..choices.below(2 * n + 1))
            .map(|_| (choices.below(n + 1), choices.below(n + 1)))
            .filter(|(a, b)| a != b)
            .collect(),
    };
    let alike = choices.once_in(4).then(|| spread.positive(choices));
    let elements = pairs.into_iter().map(|(a, b)| {
        let value = alike.unwrap_or_else(|| spread.coefficient(choices));
        let (a, b) = (node(a), node(b));
        format!("{{\"between\": [\"{a}\", \"{b}\"], \"{key}\": {value:?}}}")
    });
    elements.collect::<Vec<_>>().join(", ")
}

/// The step and how many.
fn instants(choices: &mut Choices<'_>) -> (f64, usize) {
    let step = match choices.below(8) {
        0 => 1.0,
        1 => 0.1,
        2 => 0.05,
        3 => 1e-3,
        4 => 1e3,
        5 => 10f64.powf(12.0 * choices.fraction() - 6.0),
        6 => 10f64.powf(300.0 * choices.fraction() - 150.0),
        _ => 0.25,
    };
    (step, choices.below(40))
}

fn initial(choices: &mut Choices<'_>, names: &[String], spread: Spread) -> String {
    let values = |choices: &mut Choices<'_>| match choices.below(3) {
        0 => 1.0,
        1 => spread.signed(choices),
        _ => 0.0,
    };
    let mut states = Vec::new();
    for name in names {
        if choices.below(3) > 0 {
            continue;
        }
        let (x, v) = (values(choices), values(choices));
        states.push(format!(
            "\"{name}\": {{\"displacement\": {x:?}, \"velocity\": {v:?}}}"
        ));
    }
    format!("\"initial\": {{{}}}", states.join(", "))
}

fn load(
    choices: &mut Choices<'_>,
    names: &[String],
    spread: Spread,
    step: f64,
    count: usize,
) -> String {
    let on = &names[choices.below(names.len())];
    let size = spread.signed(choices);
    let end = step * count as f64;
    // At an instant, between two, beyond the end, or before the beginning.
    let mut at = match choices.below(6) {
        0 => 0.0,
        1 => step * choices.below(count + 1) as f64,
        2 => end * choices.fraction(),
        3 => end / 3.0,
        4 => 2.0 * end + 1.0,
        _ => -step,
    };
    let law = match choices.below(6) {
        0 => format!("\"step\": {{\"force\": {size:?}, \"start\": {at:?}}}"),
        1 => format!("\"ramp\": {{\"rate\": {size:?}, \"start\": {at:?}}}"),
        2 => {
            at = at.abs();
            format!("\"impulse\": {{\"magnitude\": {size:?}, \"at\": {at:?}}}")
        }
        3 | 4 => {
            let frequency = match choices.below(4) {
                0 => 1.0,
                1 => 0.0,
                2 => spread.positive(choices).sqrt(),
                _ => 1.0 / step,
            };
            let phase = 6.0 * choices.fraction();
            format!(
                "\"harmonic\": {{\"amplitude\": {size:?}, \"frequency\": {frequency:?}, \"phase\": {phase:?}}}"
            )
        }
        _ => {
            let spacing = match choices.below(4) {
                0 => step,
                1 => 3.0 * step,
                2 => step / 4.0,
                _ => 0.7 * step,
            };
            let values: Vec<f64> = (0..1 + choices.below(9))
                .map(|_| spread.signed(choices))
                .collect();
            let hold = choices.pick(&["zero", "first"]);
            format!(
                "\"samples\": {{\"step\": {spacing:?}, \"values\": {values:?}, \"hold\": \"{hold}\"}}"
            )
        }
    };
    format!("{{\"on\": \"{on}\", {law}}}")
}
