//! Forces in springs and dampers along a trajectory as CSV.

use std::io::{self, Write};

use eigentone_modes::{ElementKind, GROUND, GivenElement, System};
use eigentone_response::{ElementForces, Trajectory};
use faer::MatRef;

use super::csv;
use super::unit;

/// Prints element forces.
#[derive(Clone, Copy, Debug)]
pub struct ElementForceReport<'a> {
    forces: &'a ElementForces,
    system: &'a System,
    trajectory: &'a Trajectory,
}

impl<'a> ElementForceReport<'a> {
    /// A report of `forces`, which were computed for `system` along `trajectory`.
    pub fn new(
        forces: &'a ElementForces,
        system: &'a System,
        trajectory: &'a Trajectory,
    ) -> ElementForceReport<'a> {
        ElementForceReport {
            forces,
            system,
            trajectory,
        }
    }

    /// One row for each instant with all digits: step, instant, and the tension in each spring and
    /// damper, in their order, under the names of both ends.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn csv(&self, mut out: impl Write) -> io::Result<()> {
        let system = self.system;
        let header = |kind: ElementKind| {
            let elements = system.elements(kind).into_iter().enumerate();
            elements.map(move |(index, element)| {
                let what = format!("{kind} {}", label(system, index, &element));
                unit::bracketed(&what, unit::force(element.kind))
            })
        };
        let instant = ["step".to_owned(), "time [s]".to_owned()].into_iter();
        let [springs, dampers] = [ElementKind::Spring, ElementKind::Damper].map(header);
        csv::row(&mut out, instant.chain(springs).chain(dampers))?;
        let instants = self.trajectory.steps().iter().zip(self.trajectory.times());
        for (column, (step, time)) in instants.enumerate() {
            let instant = [step.to_string(), csv::number(*time)].into_iter();
            let at = |of: MatRef<'a, f64>| {
                (0..of.nrows()).map(move |row| csv::number(of[(row, column)]))
            };
            let (springs, dampers) = (at(self.forces.springs()), at(self.forces.dampers()));
            csv::row(&mut out, instant.chain(springs).chain(dampers))?;
        }
        Ok(())
    }
}

/// The name of an element, else those of its ends, else its number.
fn label(system: &System, index: usize, element: &GivenElement) -> String {
    let stretch = &element.stretch;
    let places = [
        (&stretch.coordinates, system.names()),
        (&stretch.supports, system.supports()),
    ];
    let ends = places
        .into_iter()
        .flat_map(|(terms, names)| terms.iter().map(|&(i, factor)| (names[i].as_str(), factor)));
    let ends: Vec<(&str, f64)> = ends.collect();
    let at = |side: f64| {
        let mut found = ends.iter().filter(|(_, factor)| *factor == side);
        found.next().map_or(GROUND, |(name, _)| name)
    };
    let plain = ends.len() <= 2 && ends.iter().all(|(_, factor)| factor.abs() == 1.0);
    let distinct = at(-1.0) != at(1.0);
    match &element.name {
        Some(name) => name.clone(),
        None if plain && distinct => format!("{}–{}", at(-1.0), at(1.0)),
        None => index.to_string(),
    }
}
