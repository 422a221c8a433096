//! Systems that several tests build, and what they ask of them.

#[path = "../../../tests/row/mod.rs"]
mod row;

use eigentone_modes::{Beam, BeamEnd, System, SystemBuilder};
use eigentone_response::{
    Combination, Problem, Quantity, ResponseMethod, Sum, Trajectory, methods,
};

pub(crate) use row::in_a_row;

/// The same with masses that are called m1, m2, …
pub(crate) fn chain(masses: &[f64], springs: &[f64], dampers: &[f64]) -> System {
    let names: Vec<String> = (1..=masses.len()).map(|i| format!("m{i}")).collect();
    let names = names.iter().map(String::as_str);
    let masses: Vec<(&str, f64)> = names.zip(masses.iter().copied()).collect();
    in_a_row(&masses, springs, dampers)
}

/// Such a row of so many masses, where the numbers of each follow from its place, from 1 on: its mass, and the stiffness and
/// damping between it and the one before.
pub(crate) fn chain_of(count: usize, numbers: impl Fn(usize) -> [f64; 3]) -> System {
    let of = |kind: usize| -> Vec<f64> { (1..=count).map(|i| numbers(i)[kind]).collect() };
    chain(&of(0), &of(1), &of(2))
}

/// A quarter of a car on its wheel, on a road that moves.
pub(crate) fn quarter_car() -> System {
    let car = car().damper("road", "wheel", 50.0);
    car.build().expect("a system")
}

/// The same with a tyre that is a spring alone.
pub(crate) fn car() -> SystemBuilder {
    System::builder()
        .mass("body", 290.0)
        .mass("wheel", 59.0)
        .support("road")
        .spring("wheel", "body", 16812.0)
        .named("suspension")
        .damper("wheel", "body", 1000.0)
        .named("shock absorber")
        .spring("road", "wheel", 190_000.0)
        .named("tyre")
}

/// A sum of motions that is asked for.
pub(crate) fn sum(name: &str, motions: &[(Quantity, &str, f64)]) -> Combination {
    let motions = motions.iter();
    let motions = motions.map(|(quantity, of, factor)| (*quantity, (*of).to_owned(), *factor));
    Combination {
        name: name.to_owned(),
        of: Sum::Motions(motions.collect()),
    }
}

/// The motion of one place beside that of another.
pub(crate) fn between(name: &str, quantity: Quantity, first: &str, second: &str) -> Combination {
    sum(name, &[(quantity, second, 1.0), (quantity, first, -1.0)])
}

/// The force in an element, called as that is.
pub(crate) fn pull(element: &str) -> Combination {
    Combination {
        name: element.to_owned(),
        of: Sum::Pull(element.to_owned()),
    }
}

/// The answers of all methods that take a problem, by their names.
pub(crate) fn answers(problem: &Problem<'_>) -> Vec<(&'static str, Trajectory)> {
    let takes = methods()
        .iter()
        .filter(|method| method.refuses(problem).is_none());
    let run = |method: &&dyn ResponseMethod| {
        let found = method.run(problem);
        (
            method.name(),
            found.unwrap_or_else(|error| panic!("{}: {error}", method.name())),
        )
    };
    takes.map(run).collect()
}

/// The ends of a cantilever.
pub(crate) const CANTILEVER: [BeamEnd; 2] = [BeamEnd::Clamped, BeamEnd::Free];

/// A beam of so many elements with consistent mass: of a length, a flexural rigidity and a mass per length.
pub(crate) fn beam(
    name: &str,
    elements: usize,
    [length, flexural_rigidity, mass_per_length]: [f64; 3],
    ends: [BeamEnd; 2],
) -> Beam {
    Beam {
        name: name.to_owned(),
        length,
        elements,
        flexural_rigidity,
        mass_per_length,
        ends,
        lumped: false,
    }
}
