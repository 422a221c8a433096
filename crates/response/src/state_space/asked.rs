//! What a state-space form is asked for: inputs and outputs of a system, by names.

use eigentone_modes::System;

use super::error::StateSpaceError;
use crate::problem::{Channel, Combination, Quantity, Source};

/// A checked question.
#[derive(Clone, Debug)]
pub(super) struct Asked<'a> {
    pub(super) system: &'a System,
    pub(super) channels: Vec<Channel>,
    pub(super) inputs: Vec<String>,
    pub(super) sources: Vec<Source>,
    pub(super) outputs: Vec<String>,
}

/// What a quantity is called.
pub(super) fn word(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Displacement => "displacement",
        Quantity::Velocity => "velocity",
        Quantity::Acceleration => "acceleration",
    }
}

fn listed<'n>(names: impl Iterator<Item = &'n String>) -> String {
    let names: Vec<&str> = names.map(String::as_str).collect();
    match names.is_empty() {
        true => "none".to_owned(),
        false => names.join(", "),
    }
}

impl<'a> Asked<'a> {
    pub(super) fn of(system: &'a System) -> Asked<'a> {
        Asked {
            system,
            channels: Vec::new(),
            inputs: Vec::new(),
            sources: Vec::new(),
            outputs: Vec::new(),
        }
    }

    pub(super) fn force(&mut self, name: &str) -> Result<(), StateSpaceError> {
        let system = self.system;
        let points = || system.points().iter();
        let known = system.index_of(name).is_some() || points().any(|point| point.name == name);
        let Some(form) = system.form(name).filter(|_| known) else {
            let known = listed(
                system
                    .names()
                    .iter()
                    .chain(points().map(|point| &point.name)),
            );
            let name = name.to_owned();
            return Err(StateSpaceError::UnknownPlace { name, known });
        };
        self.channels.push(Channel::of_point(&form));
        self.inputs.push(format!("{name} force"));
        Ok(())
    }

    pub(super) fn motion(&mut self, name: &str, quantity: Quantity) -> Result<(), StateSpaceError> {
        let supports = self.system.supports();
        let Some(support) = supports.iter().position(|known| known == name) else {
            let (name, known) = (name.to_owned(), listed(supports.iter()));
            return Err(StateSpaceError::UnknownSupport { name, known });
        };
        let channel = Channel::of_support(self.system, support, quantity);
        self.channels.push(channel);
        self.inputs.push(format!("{name} {}", word(quantity)));
        Ok(())
    }

    pub(super) fn output(&mut self, combination: Combination) -> Result<(), StateSpaceError> {
        let source = Source::of(&combination, self.system);
        let name = combination.name;
        let source = match source {
            Ok(source) => source,
            Err(reason) => return Err(StateSpaceError::Output { name, reason }),
        };
        self.sources.push(source);
        self.outputs.push(name);
        Ok(())
    }
}
