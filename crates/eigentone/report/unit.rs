//! Units of all that is printed: what a place measures decides those of its motion, mass, springs, dampers and loads.
//! What is not known has none.

use eigentone_modes::{CoordinateKind, ElementKind, System};
use eigentone_response::{Combination, Quantity, Sum};

use super::table::{Align, Table};

/// What a place, an element or a sum measures, if it is known.
pub(crate) type Kind = Option<CoordinateKind>;

/// Both kinds of coordinate.
pub(crate) const KINDS: [CoordinateKind; 2] =
    [CoordinateKind::Displacement, CoordinateKind::Rotation];

fn choose(kind: Kind, displacement: &'static str, rotation: &'static str) -> &'static str {
    match kind {
        Some(CoordinateKind::Displacement) => displacement,
        Some(CoordinateKind::Rotation) => rotation,
        None => "",
    }
}

/// Of a motion or one of its derivatives.
pub(crate) fn motion(kind: Kind, quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Displacement => choose(kind, "m", "rad"),
        Quantity::Velocity => choose(kind, "m/s", "rad/s"),
        Quantity::Acceleration => choose(kind, "m/s²", "rad/s²"),
    }
}

/// Of a mass.
pub(crate) fn inertia(kind: Kind) -> &'static str {
    choose(kind, "kg", "kg·m²")
}

/// Of a force.
pub(crate) fn force(kind: Kind) -> &'static str {
    choose(kind, "N", "N·m")
}

/// Of an impulse by a force of this unit.
pub(crate) fn momentum(force: &str) -> String {
    match force {
        "" => String::new(),
        force => format!("{force}·s"),
    }
}

/// Of the rate at which something of this unit changes.
pub(crate) fn rate(unit: &str) -> String {
    let powers = [("/s²", "/s³"), ("/s", "/s²"), ("", "/s")];
    let found = powers.into_iter().find_map(|(power, next)| {
        let base = unit.strip_suffix(power)?;
        (!base.is_empty()).then(|| format!("{base}{next}"))
    });
    found.unwrap_or_default()
}

/// Of a stiffness or a damping.
pub(crate) fn coefficient(kind: Kind, of: ElementKind) -> &'static str {
    match of {
        ElementKind::Spring => choose(kind, "N/m", "N·m/rad"),
        ElementKind::Damper => choose(kind, "N·s/m", "N·m·s/rad"),
    }
}

/// Of an output: a sum has a unit where all of its parts have the same.
pub(crate) fn output(system: &System, combination: &Combination) -> &'static str {
    match &combination.of {
        Sum::Motions(motions) => {
            let mut units = motions
                .iter()
                .map(|(quantity, name, _)| motion(system.kind_at(name), *quantity));
            let first = units.next().unwrap_or_default();
            if units.all(|unit| unit == first) {
                first
            } else {
                ""
            }
        }
        Sum::Pull(name) => {
            let found = system.element_of(name);
            force(found.and_then(|(kind, index)| system.elements(kind)[index].kind))
        }
    }
}

/// Units of what designs of a system vary and measure; empty where one is not known.
#[derive(Clone, Copy, Debug)]
pub struct Units<'a> {
    /// The system.
    pub system: &'a System,
    /// What is asked for beside the motions of its coordinates.
    pub outputs: &'a [Combination],
}

impl Units<'_> {
    /// Of a number of a scene, by its list, its place there and its key.
    pub fn number(&self, list: &str, index: usize, key: &str) -> &'static str {
        let element = |of| {
            let elements = self.system.elements(of);
            elements
                .get(index)
                .map_or("", |element| coefficient(element.kind, of))
        };
        match (list, key) {
            ("masses", "mass") if index < self.system.len() => {
                inertia(Some(self.system.kind_of(index)))
            }
            ("springs", "stiffness") => element(ElementKind::Spring),
            ("dampers", "damping") => element(ElementKind::Damper),
            ("beams" | "rods", "length") => "m",
            ("beams", "flexural_rigidity") => "N·m²",
            _ => "",
        }
    }

    /// Of an output, or of the displacement of a coordinate, point or support.
    pub fn place(&self, name: &str) -> &'static str {
        match self.outputs.iter().find(|output| output.name == name) {
            Some(asked) => output(self.system, asked),
            None => motion(self.system.kind_at(name), Quantity::Displacement),
        }
    }

    /// Of a frequency response from a place to something of this unit.
    pub fn response(&self, from: &str, output: &str) -> String {
        let kind = self.system.kind_at(from);
        let input = match self.system.supports().iter().any(|own| own == from) {
            true => motion(kind, Quantity::Displacement),
            false => force(kind),
        };
        match (output, input) {
            ("", _) | (_, "") => String::new(),
            (output, "N·m") => format!("{output}/(N·m)"),
            (output, input) => format!("{output}/{input}"),
        }
    }
}

/// Which kinds of coordinate a system has.
pub(crate) fn kinds(system: &System) -> impl Iterator<Item = CoordinateKind> {
    let has = |kind| (0..system.len()).any(|i| system.kind_of(i) == kind);
    KINDS.into_iter().filter(move |kind| has(*kind))
}

/// Of a quantity of all coordinates: `m`, `rad`, or both.
pub(crate) fn of_all(system: &System, quantity: Quantity) -> String {
    let units = kinds(system).map(|kind| motion(Some(kind), quantity));
    units.collect::<Vec<&str>>().join(" or ")
}

/// The table, which has a row for each coordinate, so many times over, and the unit of its headers. Where
/// coordinates have different units, these stand in a column instead.
pub(super) fn column(
    table: Table,
    system: &System,
    quantity: Quantity,
    times: usize,
) -> (Table, &'static str) {
    let each = || (0..system.len()).map(|i| motion(Some(system.kind_of(i)), quantity));
    match kinds(system).count() {
        1 => (table, each().next().unwrap_or_default()),
        _ => (
            table.column("unit", Align::Left, (0..times).flat_map(|_| each())),
            "",
        ),
    }
}

/// `what, unit`, or what by itself.
pub(crate) fn labelled(what: &str, unit: &str) -> String {
    match unit {
        "" => what.to_owned(),
        unit => format!("{what}, {unit}"),
    }
}

/// `what [unit]`, or what by itself.
pub(crate) fn bracketed(what: &str, unit: &str) -> String {
    match unit {
        "" => what.to_owned(),
        unit => format!("{what} [{unit}]"),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::Scene;

    #[test]
    fn outputs_have_a_unit_where_all_parts_have_the_same() {
        let text = r#"{
            "masses": [{"name": "x", "mass": 1}, {"name": "y", "mass": 1}, {"name": "a", "mass": 1, "unit": "rad"}],
            "springs": [{"between": ["x", "y"], "stiffness": 1, "name": "k"}, {"between": ["ground", "a"], "stiffness": 1, "name": "t"},
                {"between": ["x", "a"], "stiffness": 1, "name": "?"}],
            "dampers": [{"between": ["ground", "a"], "damping": 1, "name": "d"}],
            "outputs": [
                {"name": "travel", "displacement": {"x": 1, "y": -1}},
                {"name": "speed", "velocity": {"a": 2}},
                {"name": "sum", "displacement": {"x": 1, "a": 0.5}},
                {"name": "both", "displacement": {"x": 1}, "velocity": {"x": 1}},
                {"name": "shock", "acceleration": {"a": 1}},
                {"name": "pull", "force": "k"}, {"name": "torque", "force": "t"},
                {"name": "drag", "force": "d"}, {"name": "odd", "force": "?"}
            ],
            "time": {"end": 1, "step": 1}
        }"#;
        let scene = Scene::parse(text, Path::new("scene.json")).expect("a scene");
        let problem = scene.problem().expect("it has times").expect("a problem");
        let units = problem.combinations().iter();
        let units: Vec<&str> = units.map(|one| output(scene.system(), one)).collect();
        let wanted = ["m", "rad/s", "", "", "rad/s²", "N", "N·m", "N·m", ""];
        assert_eq!(units, wanted);
        assert_eq!(of_all(scene.system(), Quantity::Velocity), "m/s or rad/s");
        let elements = scene.system().elements(ElementKind::Damper);
        assert_eq!(
            coefficient(elements[0].kind, ElementKind::Damper),
            "N·m·s/rad"
        );
    }

    #[test]
    fn rates_and_momenta_follow_from_units() {
        let rates = ["N", "N·m", "m", "rad/s", "m/s²", ""].map(rate);
        assert_eq!(rates, ["N/s", "N·m/s", "m/s", "rad/s²", "m/s³", ""]);
        assert_eq!(["N", "N·m", ""].map(momentum), ["N·s", "N·m·s", ""]);
    }
}
