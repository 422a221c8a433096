//! What a scene answers from its inputs to its outputs: frequency responses and state-space forms, by names.

use eigentone_response::{Combination, FrequencyResponse, Quantity, StateSpace, StateSpaceError};

use super::Scene;

/// An output by its name.
enum To<'a> {
    Place(&'a str),
    Output(&'a Combination),
}

impl Scene {
    /// What drives it, else its supports, else its coordinates: the inputs where none is named.
    pub fn inputs(&self) -> Vec<String> {
        let (driven, supports) = (self.driven(), self.system.supports());
        match driven.is_empty() {
            false => driven.into_iter().map(str::to_owned).collect(),
            true if !supports.is_empty() => supports.to_vec(),
            true => self.system.names().to_vec(),
        }
    }

    /// Frequency responses from these coordinates, points and supports, to these and its outputs: without names to all
    /// coordinates, points and outputs. A name that a place and an output share stands for both.
    pub fn frequency_response(
        &self,
        from: &[String],
        to: Option<&[String]>,
    ) -> FrequencyResponse<'_> {
        let asked = FrequencyResponse::of(&self.system).loss_factors(self.loss_factors());
        let asked = from.iter().fold(asked, FrequencyResponse::from);
        let to = self.to(to).into_iter();
        to.fold(asked, |asked, to| match to {
            To::Place(name) => asked.to(name),
            To::Output(output) => asked.output(output.clone()),
        })
    }

    /// The state-space form between the same, its inputs forces, and motions of supports by those of their derivatives that
    /// the scene gives; by a higher one where an output follows a derivative of that, which the sentences beside it say. Loss
    /// factors have none.
    ///
    /// # Errors
    /// [`StateSpaceError`]
    pub fn state_space(
        &self,
        from: &[String],
        to: Option<&[String]>,
    ) -> Result<(StateSpace<'_>, Vec<String>), StateSpaceError> {
        let (mut raised, mut said): (Vec<(String, Quantity)>, _) = (Vec::new(), Vec::new());
        loop {
            let mut plant = StateSpace::of(&self.system);
            let inputs = self.channels(from, &raised);
            for (name, quantity) in &inputs {
                plant = match quantity {
                    None => plant.force(name),
                    Some(quantity) => plant.motion(name, *quantity),
                };
            }
            for to in self.to(to) {
                plant = match to {
                    To::Place(name) => plant.output(name, Quantity::Displacement),
                    To::Output(output) => plant.combination(output.clone()),
                };
            }
            let (output, input) = match plant.build() {
                Err(StateSpaceError::Improper { output, input }) => (output, input),
                answer => return Ok((answer?, said)),
            };
            let higher = inputs.iter().find_map(|(name, quantity)| match quantity {
                Some(Quantity::Displacement) if input == format!("{name} displacement") => {
                    Some((name, Quantity::Velocity, "velocity"))
                }
                Some(Quantity::Velocity) if input == format!("{name} velocity") => {
                    Some((name, Quantity::Acceleration, "acceleration"))
                }
                _ => None,
            });
            let Some((support, quantity, word)) = higher else {
                return Err(StateSpaceError::Improper { output, input });
            };
            said.push(format!(
                "output {output:?} depends on a derivative of the {input}: the input is the {word} of {support} instead"
            ));
            raised.retain(|(known, _)| known != support);
            raised.push((support.clone(), quantity));
        }
    }

    /// Forces, and motions by at least the derivatives that `raised` says.
    fn channels(
        &self,
        from: &[String],
        raised: &[(String, Quantity)],
    ) -> Vec<(String, Option<Quantity>)> {
        let mut all = Vec::new();
        for name in from {
            if !self.system.supports().contains(name) {
                all.push((name.clone(), None));
                continue;
            }
            let least = raised.iter().find(|(support, _)| support == name);
            let least = least.map_or(Quantity::Displacement, |(_, quantity)| *quantity);
            let moved = self.motions().filter(|(of, _)| of == name);
            let mut moved: Vec<Quantity> = moved.map(|(_, quantity)| quantity).collect();
            if moved.is_empty() {
                moved.push(Quantity::Displacement);
            }
            for quantity in moved {
                let higher = match (quantity as u8) < least as u8 {
                    true => least,
                    false => quantity,
                };
                let input = (name.clone(), Some(higher));
                if !all.contains(&input) {
                    all.push(input);
                }
            }
        }
        all
    }

    /// The outputs of these names in their order, a place before an output of the same name.
    fn to<'a>(&'a self, names: Option<&'a [String]>) -> Vec<To<'a>> {
        let system = &self.system;
        let points = system.points().iter().map(|point| &point.name);
        let places = system.names().iter().chain(points);
        let Some(names) = names else {
            let places = places.map(|name| To::Place(name));
            return places.chain(self.outputs.iter().map(To::Output)).collect();
        };
        let mut all = Vec::new();
        for name in names {
            let output = self.outputs.iter().find(|output| output.name == *name);
            if system.form(name).is_some() || output.is_none() {
                all.push(To::Place(name));
            }
            all.extend(output.map(To::Output));
        }
        all
    }
}
