//! The steady state under harmonic loads as a table and as JSON.

use std::f64::consts::TAU;

use eigentone_modes::{Mode, Modes, Motion, System};
use eigentone_response::{Destination, HarmonicMotion, Quantity, SteadyState, Summary};
use serde::ser::{SerializeMap, SerializeSeq};
use serde::{Serialize, Serializer};

use super::number;
use super::table::{Align, Table};
use super::unit;

/// Prints a steady state.
#[derive(Clone, Copy, Debug)]
pub(super) struct SteadyStateReport<'a> {
    pub(super) steady_state: &'a SteadyState,
    pub(super) names: &'a [String],
    pub(super) summary: &'a Summary,
    pub(super) modes: &'a Modes,
}

/// As JSON an array of `{"frequency", "amplitude": {NAME: {"re", "im", "bound"}}}`.
#[derive(Clone, Copy, Debug)]
pub(super) struct SteadyStateJson<'a> {
    pub(super) steady_state: &'a SteadyState,
    pub(super) names: &'a [String],
}

impl SteadyStateReport<'_> {
    /// The table and what it says.
    pub(super) fn text(&self, system: &System) -> String {
        format!("{}{}\n", self.table(system).text(), self.explained())
    }

    /// What the table says.
    pub(super) fn explained(&self) -> String {
        let mut text = match self.is_about_0() {
            true => "Each mass moves as the sum of amplitude·sin(Ωt + phase) once free motion has died out.",
            false => {
                "About the displacement given each mass moves as the sum of amplitude·sin(Ωt + phase) once free motion has died\n\
                 out."
            }
        }
        .to_owned();
        let goes_away =
            |destination| matches!(destination, Destination::Drift | Destination::Growth);
        let mut coordinates = self.summary.coordinates().iter();
        if coordinates.any(|one| goes_away(one.destination)) {
            text += " That a mass drifts or grows is no part of that sum.";
        }
        let lasts = |mode: &Mode| mode.motion() != Motion::Rigid && mode.time_constant().is_none();
        if self.modes.iter().any(lasts) {
            text += "\nFree motion that is not damped does not die out: where there is any, it goes on beside that sum.";
        }
        text
    }

    /// About what a mass moves, without what loads of frequency 0 have in the sum already.
    fn about(&self, i: usize) -> Option<f64> {
        let mean = self.summary.mean(i)?;
        let still = self.steady_state.motions().iter();
        let still = still.filter(|motion| motion.frequency() == 0.0);
        let rest = mean - still.map(|motion| motion.displacement()[i].im).sum::<f64>();
        Some(if rest.abs() <= 1e-12 * mean.abs() {
            0.0
        } else {
            rest
        })
    }

    /// Whether every mass moves about 0.
    fn is_about_0(&self) -> bool {
        (0..self.names.len()).all(|i| self.about(i) == Some(0.0))
    }

    /// Amplitude and phase of each coordinate at each frequency, and about what it moves where that is not 0 for all.
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
        let table = match self.is_about_0() {
            true => table,
            false => {
                let coordinates = self.summary.coordinates().iter();
                let means = number::column((0..self.names.len()).map(|i| self.about(i)));
                let about = coordinates.zip(means);
                let about = about.map(|(one, mean)| match one.destination {
                    Destination::Drift => "drifts".to_owned(),
                    Destination::Growth => "grows".to_owned(),
                    Destination::Unknown => "not known".to_owned(),
                    _ => mean,
                });
                // Once, and not with each frequency.
                let blank = motions().skip(1).flat_map(|_| self.names);
                let about = about.chain(blank.map(|_| String::new()));
                table.column(&unit::labelled("about", unit), Align::Point, about)
            }
        };
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

impl Serialize for SteadyStateJson<'_> {
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
