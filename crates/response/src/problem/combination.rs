//! Sums of motions that are asked for beside those of the coordinates.

use eigentone_digits::{DoubleDouble, parts};
use eigentone_modes::{ElementKind, Form, System};

use super::channel::Quantity;

/// A sum of displacements, velocities and accelerations of coordinates, points and supports, or the pull of a spring or
/// damper; each with a bound of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Combination {
    /// What it is called.
    pub name: String,
    /// What it is.
    pub of: Sum,
}

/// What a [`Combination`] adds up.
#[derive(Clone, Debug, PartialEq)]
pub enum Sum {
    /// Motions: which derivative, of which coordinate, point or support, times what.
    Motions(Vec<(Quantity, String, f64)>),
    /// The pull in N of the spring or damper of this name: its coefficient times the stretch, or the rate of it.
    Pull(String),
}

/// A combination in terms of coordinates and supports.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Source {
    /// By order of the derivative: index of the coordinate, or beyond them of the support, and two factors; their products
    /// add up.
    pub(crate) terms: [Vec<(usize, [f64; 2])>; 3],
}

impl Source {
    pub(crate) fn of(combination: &Combination, system: &System) -> Result<Source, String> {
        let mut source = Source::default();
        let mut add = |order, form: &_, factor| source.add(system, order, form, factor);
        match &combination.of {
            Sum::Motions(motions) => {
                if motions.is_empty() {
                    return Err("it adds up nothing: give at least one motion".to_owned());
                }
                for (quantity, name, factor) in motions {
                    if !factor.is_finite() {
                        let text = format!("its factor of {name:?} is {factor:?}");
                        return Err(text + ": it must be a finite number");
                    }
                    let form = system.form(name).ok_or_else(|| {
                        format!("{name:?} is neither a coordinate nor a point nor a support")
                    })?;
                    add(*quantity as usize, &form, *factor);
                }
            }
            Sum::Pull(name) => {
                let (kind, index) = system
                    .element_of(name)
                    .ok_or_else(|| format!("no spring or damper is named {name:?}"))?;
                let element = &system.elements(kind)[index];
                add(Source::order(kind), &element.stretch, element.coefficient);
            }
        }
        source.cancel();
        Ok(source)
    }

    /// The pulls of all springs, then of all dampers.
    pub(super) fn of_elements(system: &System) -> impl Iterator<Item = Source> {
        let kinds = [ElementKind::Spring, ElementKind::Damper].into_iter();
        kinds.flat_map(move |kind| {
            system.elements(kind).into_iter().map(move |element| {
                let mut source = Source::default();
                source.add(
                    system,
                    Source::order(kind),
                    &element.stretch,
                    element.coefficient,
                );
                source
            })
        })
    }

    /// Which derivative of its stretch an element answers.
    fn order(kind: ElementKind) -> usize {
        usize::from(kind == ElementKind::Damper)
    }

    pub(crate) fn add(&mut self, system: &System, order: usize, form: &Form, factor: f64) {
        let supports = form.supports.iter().map(|&(s, b)| (system.len() + s, b));
        let places = form.coordinates.iter().copied().chain(supports);
        self.terms[order].extend(places.map(|(i, a)| (i, [a, factor])));
    }

    /// Leaves out what adds up to exactly 0, which no digits would show.
    fn cancel(&mut self) {
        for terms in &mut self.terms {
            let mut places: Vec<usize> = terms.iter().map(|(i, _)| *i).collect();
            places.sort_unstable();
            for own in places.chunk_by(|a, b| a == b).filter(|own| own.len() > 1) {
                let all = terms.iter().filter(|(i, _)| *i == own[0]);
                let products = all.map(|(_, [a, b])| DoubleDouble::product(*a, *b));
                let products: Vec<DoubleDouble> = products.collect();
                let is_exact =
                    |product: &DoubleDouble| (1e-200..1e200).contains(&product.high().abs());
                let sum = products
                    .iter()
                    .flat_map(|product| [product.high(), product.low()]);
                if products.iter().all(is_exact) && parts(&sum.collect::<Vec<f64>>()).is_empty() {
                    terms.retain(|(i, _)| *i != own[0]);
                }
            }
        }
    }

    /// Whether any acceleration is part of it.
    pub(crate) fn accelerates(&self) -> bool {
        !self.terms[2].is_empty()
    }
}
