//! `eigentone absorber SCENE --on NAME --mass M [--mode K] [--as-scene RULE] [--json]`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use eigentone::modes::{ClassicalModes, CoordinateKind, Participation, Precision};
use eigentone::report::significant;
use eigentone::scene::{Scene, did_you_mean};
use eigentone_digits::sort_by_number;
use serde_json::{Value, json};

use super::study::Varied;
use super::{Failure, positive, print, source};

/// Tunes an absorber for one mode of the scene, by the closed forms for one mass under a force
#[derive(Debug, Args)]
pub struct Absorber {
    /// The scene file; - is standard input
    #[arg(value_parser = source::parser())]
    scene: PathBuf,
    /// What it is attached to: a mass, a coordinate or a point
    #[arg(long, value_name = "NAME")]
    on: String,
    /// Its mass, in kg; on a rotation its moment of inertia
    #[arg(long, value_name = "M", value_parser = positive)]
    mass: f64,
    /// For which mode without damping, the lowest first
    #[arg(long, value_name = "K", value_parser = super::count, default_value_t = 1)]
    mode: u32,
    /// Print the scene with the absorber that this rule makes, as `absorber` with `absorber-spring` and `absorber-damper`
    #[arg(long, value_name = "RULE", value_enum, conflicts_with = "json")]
    as_scene: Option<Rule>,
    /// Print one JSON object with every digit
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Rule {
    /// Equal fixed points of the frequency response, and the mean of the damping that makes either a peak (Den Hartog 1956)
    DenHartog,
    /// The least peak of the frequency response, exactly (Nishihara and Asami 2002)
    HInfinity,
    /// The least root mean square under white noise (Crandall and Mark 1963, Warburton 1982)
    H2,
}

impl Rule {
    fn name(self) -> &'static str {
        match self {
            Rule::DenHartog => "den-hartog",
            Rule::HInfinity => "h-infinity",
            Rule::H2 => "h2",
        }
    }

    /// Frequency in parts of the mode's and damping ratio of an absorber by itself, for so many parts of the modal mass.
    fn tuning(self, mu: f64) -> [f64; 2] {
        match self {
            Rule::DenHartog => [1.0 / (1.0 + mu), (3.0 * mu / (8.0 * (1.0 + mu))).sqrt()],
            Rule::HInfinity => {
                let r = (4.0 + 3.0 * mu).sqrt();
                let many = 16.0 + 23.0 * mu + 9.0 * mu * mu + 2.0 * (2.0 + mu) * r;
                let few = 3.0 * (64.0 + 80.0 * mu + 27.0 * mu * mu);
                // 8 + 9μ − 4r without cancellation.
                let left = mu * (96.0 + 81.0 * mu) / (8.0 + 9.0 * mu + 4.0 * r);
                [
                    2.0 / (1.0 + mu) * (2.0 * many / few).sqrt(),
                    (left / (1.0 + mu)).sqrt() / 4.0,
                ]
            }
            Rule::H2 => [
                (1.0 + mu / 2.0).sqrt() / (1.0 + mu),
                (mu * (4.0 + 3.0 * mu) / (8.0 * (1.0 + mu) * (2.0 + mu))).sqrt(),
            ],
        }
    }
}

/// What of a scene its undamped modes depend on.
fn undamped(scene: &Value) -> Value {
    const MODEL: [&str; 7] = [
        "masses", "springs", "points", "supports", "beams", "rods", "matrices",
    ];
    let mut bare = scene.clone();
    if let Some(keys) = bare.as_object_mut() {
        keys.retain(|key, _| MODEL.contains(&key.as_str()));
    }
    if let Some(matrices) = bare.get_mut("matrices").and_then(Value::as_object_mut) {
        matrices.remove("damping");
    }
    bare
}

impl Absorber {
    pub fn run(self) -> Result<(), Failure> {
        let none = std::iter::empty();
        let (scene, varied) = Varied::read(&self.scene, Precision::Double, none)?;
        let refuse = |why: String| varied.refuse(why);
        let system = scene.system();
        let form = system.form(&self.on).ok_or_else(|| {
            let points = system.points().iter().map(|point| &point.name);
            let known: Vec<&String> = system.names().iter().chain(points).collect();
            let hint = did_you_mean(&self.on, &known);
            refuse(format!("--on {}: {hint}", self.on))
        })?;
        if form.coordinates.is_empty() {
            let on = &self.on;
            return Err(refuse(format!(
                "--on {on}: it is the ground or a support, or moves with these alone, and no absorber changes that: take a mass or a point that can move by itself"
            )));
        }
        let undamped = Scene::parse(&undamped(varied.scene()).to_string(), &self.scene)?;
        let system = undamped.system();
        let all = Participation::along(system, &vec![1.0; system.len()]);
        let all = all.map_err(|error| refuse(error.to_string()))?;
        let [omega, modal, off] = self.modal(all.modes(), &form.coordinates).map_err(refuse)?;
        let mu = self.mass / modal;
        let rules = Rule::value_variants().iter().map(|rule| {
            let [f, zeta] = rule.tuning(mu);
            let own = f * omega;
            let stiffness = self.mass * own * own;
            (*rule, f, zeta, stiffness, 2.0 * zeta * self.mass * own)
        });
        if !rules.clone().all(|(_, f, zeta, stiffness, damping)| {
            [f, zeta, stiffness, damping]
                .iter()
                .all(|number| number.is_normal())
        }) {
            let (mass, on) = (self.mass, &self.on);
            return Err(refuse(format!(
                "--mass {mass:?}: the tuning leaves the range of doubles: take a mass nearer to the modal mass at {on}, {modal:.1e}"
            )));
        }
        if let Some(wanted) = self.as_scene {
            let chosen = rules.clone().find(|(rule, ..)| *rule == wanted);
            let Some((.., stiffness, damping)) = chosen else {
                return Ok(());
            };
            let turns = scene.system().kind_at(&self.on) == Some(CoordinateKind::Rotation);
            let text = self.with_absorber(varied.scene().clone(), turns, [stiffness, damping]);
            let text = text.map_err(refuse)?;
            return print(|out| writeln!(out, "{text:#}"));
        }
        if self.json {
            let rules = rules.map(|(rule, f, zeta, stiffness, damping)| {
                let numbers = json!({
                    "frequency_ratio": f, "damping_ratio": zeta,
                    "stiffness": stiffness, "damping": damping,
                });
                (rule.name().to_owned(), numbers)
            });
            let answer = json!({
                "mode": self.mode, "natural_frequency": omega, "modal_mass": modal,
                "modal_mass_error": off * modal, "mass_ratio": mu,
                "rules": rules.collect::<serde_json::Map<String, Value>>(),
            });
            return print(|out| writeln!(out, "{answer}"));
        }
        print(|out| {
            writeln!(
                out,
                "mode {} without damping: {} rad/s, with a modal mass of {} at {}; the absorber has {} of it",
                self.mode,
                significant(omega),
                significant(modal),
                self.on,
                significant(mu)
            )?;
            writeln!(
                out,
                "rule        frequency ratio  damping ratio     stiffness       damping"
            )?;
            for (rule, f, zeta, stiffness, damping) in rules {
                let rule = rule.name();
                let [f, zeta, stiffness, damping] = [f, zeta, stiffness, damping].map(significant);
                writeln!(
                    out,
                    "{rule:<10}  {f:>15}  {zeta:>13}  {stiffness:>12}  {damping:>12}"
                )?;
            }
            Ok(())
        })
    }

    /// Frequency of the mode, its mass where it moves the place by 1, together with others of the same frequency, and by how much of
    /// itself this may be off: entries of shapes are rounded before they cancel.
    fn modal(&self, modes: &ClassicalModes, place: &[(usize, f64)]) -> Result<[f64; 3], String> {
        /// In parts of the largest entry of the shape.
        const STILL: f64 = 1e-6;
        /// Squares of frequencies that differ by less, in parts of them, are equal but for rounding.
        const EQUAL: f64 = 4.0 * f64::EPSILON;
        let (k, m) = (modes.stiffness(), modes.mass());
        let mut order: Vec<usize> = (0..m.len()).collect();
        sort_by_number(&mut order, |at| k[*at] / m[*at]);
        let mode = self.mode;
        let Some(&at) = order.get(mode as usize - 1) else {
            let count = order.len();
            return Err(format!("--mode {mode}: give a number from 1 to {count}"));
        };
        let square = k[at] / m[at];
        if square <= 0.0 {
            return Err(format!(
                "--mode {mode}: no spring holds it, so that nothing is to be tuned: take a higher one"
            ));
        }
        // Shapes of one frequency are a choice, but for what they do together.
        let equal = order.iter().copied().filter(|other| {
            let own = k[*other] / m[*other];
            (own - square).abs() <= EQUAL * square
        });
        let (mut share, mut flexibility, mut parts) = (0.0f64, 0.0, 0.0);
        for at in equal {
            let shape = modes.shapes().col(at);
            let each = place.iter().map(|(i, factor)| factor * shape[*i]);
            let moved: f64 = each.clone().sum();
            share = share.max(moved.abs() / shape.norm_max());
            flexibility += moved * moved / m[at];
            parts += moved.abs() * each.map(f64::abs).sum::<f64>() / m[at];
        }
        if share <= STILL {
            let on = &self.on;
            let moves = match share {
                0.0 => format!("it leaves {on} at rest"),
                _ => format!("it moves {on} by {share:.1e} of its largest motion"),
            };
            return Err(format!("--mode {mode}: {moves}: take another place"));
        }
        let off = 4.0 * f64::EPSILON * (1.0 + parts / flexibility);
        Ok([square.sqrt(), flexibility.recip(), off])
    }

    /// The scene with it, on a rotation or not.
    fn with_absorber(
        &self,
        mut scene: Value,
        turns: bool,
        [stiffness, damping]: [f64; 2],
    ) -> Result<Value, String> {
        if scene.get("matrices").is_some() {
            return Err("it has `matrices`, which leave no coordinate to an absorber: add a row and a column to them".to_owned());
        }
        let between = [self.on.as_str(), "absorber"];
        let mut mass = json!({"name": "absorber", "mass": self.mass});
        if turns {
            mass["unit"] = json!("rad");
        }
        let parts = [
            ("masses", mass),
            (
                "springs",
                json!({"name": "absorber-spring", "between": between, "stiffness": stiffness}),
            ),
            (
                "dampers",
                json!({"name": "absorber-damper", "between": between, "damping": damping}),
            ),
        ];
        for (list, part) in parts {
            let name = &part["name"];
            let lists = scene.as_object().into_iter().flatten();
            let mut items = lists.flat_map(|(_, items)| items.as_array().into_iter().flatten());
            if items.any(|item| item["name"] == *name || item == name) {
                return Err(format!("{name} is there already: rename it"));
            }
            let lists = scene.as_object_mut();
            let items = lists.map(|lists| lists.entry(list).or_insert_with(|| json!([])));
            if let Some(items) = items.and_then(Value::as_array_mut) {
                items.push(part);
            }
        }
        Ok(scene)
    }
}
