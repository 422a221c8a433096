//! The steady state under harmonic loads as a table and as JSON.

use std::f64::consts::TAU;

use eigentone_modes::System;
use eigentone_response::{HarmonicMotion, Quantity, SteadyState};
use serde::ser::{SerializeMap, SerializeSeq};
use serde::{Serialize, Serializer};

use super::number;
use super::table::{Align, Table};
use super::unit;

/// Prints a steady state; as JSON an array of `{"frequency", "amplitude": {NAME: {"re", "im",
/// "bound"}}}`.
#[derive(Clone, Copy, Debug)]
pub(super) struct SteadyStateReport<'a> {
    pub(super) steady_state: &'a SteadyState,
    pub(super) names: &'a [String],
}

impl SteadyStateReport<'_> {
    /// What the table says.
    pub(super) const EXPLAINED: &'static str =
        "Each mass moves as the sum of amplitude·sin(Ωt + phase) once free motion has died out.";

    /// The table and what it says.
    pub(super) fn text(&self, system: &System) -> String {
        format!("{}{}\n", self.table(system).text(), Self::EXPLAINED)
    }

    /// Amplitude and phase of each coordinate at each frequency.
    pub(super) fn table(&self, system: &System) -> Table {
        let motions = || self.steady_state.motions().iter();
        let sizes = motions().flat_map(|motion| motion.displacement().iter().map(|x| x.norm()));
        let phases = motions().flat_map(|motion| {
            let each = motion.displacement().iter();
            each.map(|x| (x.norm() > 0.0).then(|| x.arg().to_degrees()))
        });
        let frequencies = |factor: f64| {
            let all = number::column(motions().map(|motion| Some(motion.frequency() * factor)));
            let rest = self.names.len() - 1;
            let cells = all.into_iter();
            cells.flat_map(move |first| std::iter::once(first).chain(vec![String::new(); rest]))
        };
        let names = motions().flat_map(|_| self.names);
        let bounds = motions().flat_map(|motion| motion.bound());
        let table = Table::default()
            .column("Ω, rad/s", Align::Point, frequencies(1.0))
            .column("f, Hz", Align::Point, frequencies(TAU.recip()))
            .column("mass", Align::Left, names);
        let (table, unit) = unit::column(table, system, Quantity::Displacement, motions().len());
        table
            .column(
                &unit::labelled("amplitude", unit),
                Align::Point,
                number::column(sizes.map(Some)),
            )
            .column("phase, °", Align::Point, number::column(phases))
            .column(
                &unit::labelled("proven within", unit),
                Align::Right,
                bounds.map(|bound| number::bound(*bound)),
            )
    }
}

impl Serialize for SteadyStateReport<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let motions = self.steady_state.motions();
        let mut seq = serializer.serialize_seq(Some(motions.len()))?;
        for motion in motions {
            seq.serialize_element(&MotionJson {
                frequency: motion.frequency(),
                amplitude: ByName(motion, self.names),
            })?;
        }
        seq.end()
    }
}

#[derive(Serialize)]
struct MotionJson<'a> {
    frequency: f64,
    amplitude: ByName<'a>,
}

struct ByName<'a>(&'a HarmonicMotion, &'a [String]);

impl Serialize for ByName<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let ByName(motion, names) = self;
        let mut map = serializer.serialize_map(Some(names.len()))?;
        let amplitudes = motion.displacement().iter().zip(motion.bound());
        for (name, (x, bound)) in names.iter().zip(amplitudes) {
            let (re, im, bound) = (x.re, x.im, *bound);
            map.serialize_entry(name, &Amplitude { re, im, bound })?;
        }
        map.end()
    }
}

#[derive(Serialize)]
struct Amplitude {
    re: f64,
    im: f64,
    bound: f64,
}
