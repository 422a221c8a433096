//! A scene of which numbers vary, and what is reported of each design: for `sweep`, `optimise` and `fit`.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::slice::from_ref;
use std::str::FromStr;

use eigentone::design::{difference, spaced};
use eigentone::modes::{Bounds, Eigenvalue, Mode, Modes, Motion, Precision, Sensitivity};
use eigentone::report::Units;
use eigentone::response::{
    Combination, Extrema, FrequencyValue, LargestGain, MeanSquare, Peak, Problem, Quantity,
    ResponsePlan, StateSpaceError, Sum, Summary, Trajectory, Transfer, Weighting, peak_grid,
};
use eigentone::scene::{Scene, did_you_mean};
use num_complex::Complex;
use serde_json::Value;

use super::frequency::Asked;
use super::frf::asked;
use super::{Failure, source};

/// What is reported of a design.
#[derive(Clone, Debug)]
pub struct Metric {
    pub text: String,
    pub kind: Kind,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    Damping,
    Frequency(usize),
    /// From, to, and between which frequencies, in rad/s.
    Gain(String, String, Option<(f64, f64)>),
    /// Of what, and through which weighting.
    Rms(String, Option<Weighting>),
    Peak(String),
    Settling(String),
}

/// Root mean squares are to be as good as this part of them.
const GOOD: f64 = 1e-11;

/// And gains that have a bound as good as this part of them.
const GOOD_GAIN: f64 = 1e-9;

pub const METRICS: &str = "\"damping\", \"frequency K\", \"gain FROM TO\", \"gain FROM TO lo:hi\", \"rms NAME\", \"rms-wk NAME\", \"rms-wd NAME\", \"peak NAME\" and \"settling NAME\"";

impl Kind {
    /// Whether there are proven values of it: a weighted mean square is an estimate.
    pub fn is_proven(&self) -> bool {
        !matches!(self, Kind::Rms(_, Some(_)))
    }

    /// Its unit, empty where it is not known.
    pub fn unit(&self, scene: &Scene) -> String {
        let units = units(scene);
        match self {
            Kind::Damping => String::new(),
            Kind::Frequency(_) => "rad/s".to_owned(),
            Kind::Gain(from, to, _) => units.response(from, units.place(to)),
            Kind::Rms(name, _) | Kind::Peak(name) => units.place(name).to_owned(),
            Kind::Settling(_) => "s".to_owned(),
        }
    }

    /// When a design has no value of it.
    pub fn is_missing(&self) -> &'static str {
        match self {
            Kind::Damping => "roots are doubtful",
            Kind::Frequency(_) => "there are fewer modes, or this one is doubtful",
            Kind::Gain(..) => "it is infinite or not known, or something grows",
            Kind::Rms(..) => "it is infinite or not known",
            Kind::Peak(_) => "it is not known",
            Kind::Settling(_) => {
                "it drifts, keeps oscillating or grows, or is not shown to stay at rest from the end of `time` on"
            }
        }
    }
}

fn units(scene: &Scene) -> Units<'_> {
    Units {
        system: scene.system(),
        outputs: scene.outputs(),
    }
}

impl FromStr for Metric {
    type Err = String;

    fn from_str(text: &str) -> Result<Metric, String> {
        let text = text.trim();
        let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let rest = rest.trim_start();
        let kind = match (word, rest) {
            ("damping", "") => Kind::Damping,
            ("frequency", k) if !k.is_empty() => match k.parse() {
                Ok(k) if k >= 1 => Kind::Frequency(k),
                _ => return Err("the modes of \"frequency K\" count from 1".to_owned()),
            },
            ("gain", ends) => match ends.split_whitespace().collect::<Vec<&str>>()[..] {
                [] | [_] => return Err(format!("metrics are {METRICS}")),
                [from, to] => Kind::Gain(from.to_owned(), to.to_owned(), None),
                // Names may have spaces: the scene decides which they are.
                _ => Kind::Gain(ends.to_owned(), String::new(), None),
            },
            ("rms", name) if !name.is_empty() => Kind::Rms(name.to_owned(), None),
            ("rms-wk", name) if !name.is_empty() => {
                Kind::Rms(name.to_owned(), Some(Weighting::Vertical))
            }
            ("rms-wd", name) if !name.is_empty() => {
                Kind::Rms(name.to_owned(), Some(Weighting::Horizontal))
            }
            ("peak", name) if !name.is_empty() => Kind::Peak(name.to_owned()),
            ("settling", name) if !name.is_empty() => Kind::Settling(name.to_owned()),
            _ => return Err(format!("metrics are {METRICS}")),
        };
        let text = text.to_owned();
        Ok(Metric { text, kind })
    }
}

impl Metric {
    /// The same for a scene: weightings are of accelerations alone, and the ends of a gain are those that its names leave no choice about.
    pub fn of(self, scene: &Scene) -> Result<Metric, String> {
        if let Kind::Rms(name, Some(_)) = &self.kind {
            let (text, unit) = (&self.text, self.kind.unit(scene));
            if !unit.is_empty() && !unit.ends_with("/s²") {
                return Err(format!(
                    "{text}: this weighting is one of accelerations, and {name} is in {unit}: name an output such as \
                     {{\"name\": \"comfort\", \"acceleration\": {{\"{name}\": 1}}}}"
                ));
            }
        }
        let Kind::Gain(ends, to, None) = &self.kind else {
            return Ok(self);
        };
        if !to.is_empty() {
            return Ok(self);
        }
        let spaces = |text: &str| -> Vec<usize> {
            let all = text.char_indices();
            let all = all.filter(|(_, letter)| letter.is_whitespace());
            all.map(|(at, _)| at).collect()
        };
        let fit = |ends: &str, limits: Option<(f64, f64)>| -> Vec<Kind> {
            let parts = spaces(ends).into_iter().map(|at| ends.split_at(at));
            let parts = parts.map(|(from, to)| (from.trim_end(), to.trim_start()));
            let known = parts.filter(|(from, to)| is_end(scene, from) && is_to(scene, to));
            let gain =
                |(from, to): (&str, &str)| Kind::Gain(from.to_owned(), to.to_owned(), limits);
            known.map(gain).collect()
        };
        let mut all = fit(ends, None);
        if let Some((names, limits)) = ends.rsplit_once(char::is_whitespace) {
            let are_ends = !fit(names.trim_end(), None).is_empty();
            match band(limits) {
                Ok(limits) => all.extend(fit(names.trim_end(), Some(limits))),
                Err(wrong) if are_ends && all.is_empty() => {
                    return Err(format!("{}: {wrong}", self.text));
                }
                Err(_) => {}
            }
        }
        all.dedup();
        match <[Kind; 1]>::try_from(all) {
            Ok([kind]) => Ok(Metric { kind, ..self }),
            Err(all) => {
                let why = match all[..] {
                    [] => "no two names of the scene are in it",
                    _ => "more than two names of the scene are in it",
                };
                let text = &self.text;
                Err(format!(
                    "{text}: {why}: write \"gain FROM TO\" or \"gain FROM TO lo:hi\""
                ))
            }
        }
    }
}

/// Whether a frequency response can start there.
pub fn is_end(scene: &Scene, name: &str) -> bool {
    let system = scene.system();
    system.form(name).is_some() || system.supports().iter().any(|support| support == name)
}

/// Whether one can end there.
pub fn is_to(scene: &Scene, name: &str) -> bool {
    is_end(scene, name) || scene.outputs().iter().any(|output| output.name == name)
}

/// The frequencies between which a gain is sought.
fn band(text: &str) -> Result<(f64, f64), String> {
    const RIGHT: &str =
        "write the frequencies of a gain as lo:hi, in rad/s or with a unit, as 2:30 or 1Hz:5Hz";
    let (low, high) = text.split_once(':').ok_or(RIGHT)?;
    let number = |text: &str| text.parse::<Asked>().map(|at| at.radians_per_second(false));
    match (number(low), number(high)) {
        (Ok(low), Ok(high)) if low < high => Ok((low, high)),
        (Ok(_), Ok(_)) => Err(format!(
            "nothing is between {low} and {high}: give the lower frequency first, and a higher one after it"
        )),
        _ => Err(RIGHT.to_owned()),
    }
}

/// A scene with its varied numbers.
pub struct Varied {
    file: PathBuf,
    precision: Precision,
    value: Value,
    names: Vec<String>,
    /// A JSON Pointer for each name.
    pointers: Vec<String>,
    /// The text of the scene around the varied numbers, and which of them comes next.
    pieces: Vec<(String, Option<usize>)>,
}

impl Varied {
    /// The scene itself, and what is needed to vary these numbers of it.
    pub fn read<'a>(
        file: &Path,
        precision: Precision,
        names: impl Iterator<Item = &'a str>,
    ) -> Result<(Scene, Varied), Failure> {
        let text = source::text(file)?;
        let scene = Scene::parse(&text, file)?;
        let mut varied = Varied {
            file: file.to_owned(),
            precision,
            value: Value::Null,
            names: Vec::new(),
            pointers: Vec::new(),
            pieces: Vec::new(),
        };
        varied.value = serde_json::from_str(text.trim_start_matches('\u{feff}'))
            .map_err(|error| varied.refuse(error.to_string()))?;
        for name in names {
            let pointer = pointer(&varied.value, name).map_err(|why| varied.refuse(why))?;
            if varied.pointers.contains(&pointer) {
                let message = format!("--vary {name}: this number varies already");
                return Err(varied.refuse(message));
            }
            varied.pointers.push(pointer);
            varied.names.push(name.to_owned());
        }
        varied.pieces = pieces(&varied.value, &varied.pointers);
        Ok((scene, varied))
    }

    /// The title of the scene, or the name of its file.
    pub fn title(&self) -> &str {
        let title = self.value["title"].as_str();
        let name = || self.file.file_stem().and_then(OsStr::to_str);
        title.or_else(name).unwrap_or_default()
    }

    /// The scene as it was read.
    pub fn scene(&self) -> &Value {
        &self.value
    }

    /// The units of the varied numbers.
    pub fn units(&self, scene: &Scene) -> impl Iterator<Item = String> {
        self.pointers.iter().map(move |pointer| {
            let parts: Vec<&str> = pointer.split('/').collect();
            let unit = match parts[..] {
                ["", list, index, key] => index
                    .parse()
                    .map_or("", |index| units(scene).number(list, index, key)),
                _ => "",
            };
            unit.to_owned()
        })
    }

    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str)
    }

    pub fn refuse(&self, message: String) -> Failure {
        Failure::Study {
            scene: self.file.clone(),
            message,
        }
    }

    /// The numbers of a design by their names, for messages.
    pub fn named(&self, values: &[f64]) -> String {
        let design = self.names().zip(values);
        let design: Vec<String> = design
            .map(|(name, value)| format!("{name} = {value:?}"))
            .collect();
        design.join(", ")
    }

    /// The numbers of the scene as it was read.
    pub fn start(&self) -> Vec<f64> {
        let all = self
            .pointers
            .iter()
            .map(|pointer| self.value.pointer(pointer));
        let all = all.map(|value| value.and_then(Value::as_f64));
        all.map(|value| value.unwrap_or(f64::NAN)).collect()
    }

    /// What the scene is with these numbers, as it would be written.
    pub fn written(&self, values: &[f64]) -> Value {
        let mut written = self.value.clone();
        for (pointer, value) in self.pointers.iter().zip(values) {
            if let Some(place) = written.pointer_mut(pointer) {
                *place = Value::from(*value);
            }
        }
        written
    }

    /// The same numbers of the same scene, to another precision.
    pub fn to(self, precision: Precision) -> Varied {
        Varied { precision, ..self }
    }

    /// The scene with these numbers, and its modes.
    pub fn solve(&self, values: &[f64]) -> Result<(Scene, Modes), String> {
        let scene = self.scene_of(values)?;
        let modes = scene.system().modes_to(self.precision);
        let modes = modes.map_err(|error| error.to_string())?;
        Ok((scene, modes))
    }

    /// The scene with these numbers.
    pub fn scene_of(&self, values: &[f64]) -> Result<Scene, String> {
        const NUMBER: usize = 25;
        let length = self.pieces.iter().map(|(piece, _)| piece.len() + NUMBER);
        let mut text = String::with_capacity(length.sum());
        for (piece, next) in &self.pieces {
            text.push_str(piece);
            if let Some(next) = next {
                text.push_str(&Value::from(values[*next]).to_string());
            }
        }
        Scene::parse_to(&text, &self.file, self.precision).map_err(|error| {
            let message = error.to_string();
            // Lines and columns are not those of the file.
            let place = format!("{}:", self.file.display());
            let rest = message
                .strip_prefix(&place)
                .and_then(|rest| rest.split_once(": "));
            rest.map_or(message.clone(), |(_, rest)| rest.to_owned())
        })
    }

    /// The derivatives, by each of the numbers, of what `held` measures of scenes beside this one: of the numbers of their equations,
    /// with solutions held. These are most often linear in the numbers of a scene, and smooth for sure, so that differences of
    /// eighth order are exact but for rounding. `None` where a scene beside this one has none.
    pub fn derivatives(
        &self,
        values: &[f64],
        limits: Option<&[(f64, f64)]>,
        held: &dyn Fn(&Scene) -> Option<Vec<f64>>,
    ) -> Option<Vec<Vec<f64>>> {
        const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);
        let derivative = |i: usize| {
            let (low, high) = limits.map_or(FREE, |limits| limits[i]);
            let (below, spacing) = spaced(values[i], [low, high]);
            let mut sum: Option<Vec<f64>> = None;
            let mut first: Option<Vec<f64>> = None;
            for (node, weight) in difference(below).into_iter().enumerate() {
                let mut moved = values.to_vec();
                moved[i] += (node as f64 - below as f64) * spacing;
                let measured = held(&self.scene_of(&moved).ok()?)?;
                let sum = sum.get_or_insert_with(|| vec![0.0; measured.len()]);
                if sum.len() != measured.len() {
                    return None;
                }
                // The weights sum to 0, and beside the first value what does not change leaves exactly nothing.
                let first = first.get_or_insert_with(|| measured.clone());
                let terms = sum.iter_mut().zip(measured.iter().zip(&*first));
                terms.for_each(|(sum, (value, first))| *sum += weight * (value - first) / spacing);
            }
            sum.filter(|sum| sum.iter().all(|slope| slope.is_finite()))
        };
        (0..values.len()).map(derivative).collect()
    }

    /// A metric, or `None` where it is infinite or not known.
    pub fn measure(
        &self,
        kind: &Kind,
        scene: &Scene,
        modes: &Modes,
    ) -> Result<Option<f64>, String> {
        match kind {
            Kind::Damping => {
                if modes.eigenvalues().iter().any(|root| root.is_doubtful()) {
                    return Ok(None);
                }
                Ok(ratios(modes).map(|(_, ratio)| ratio).reduce(f64::min))
            }
            Kind::Frequency(k) => match modes.into_iter().nth(k - 1) {
                Some(mode) if mode.eigenvalue().is_doubtful() => Ok(None),
                Some(mode) => Ok(Some(mode.natural_frequency().radians_per_second())),
                // A pair that meets on the real axis becomes two modes: other designs may have this one.
                None if *k <= modes.eigenvalues().len() => Ok(None),
                None => {
                    let count = modes.into_iter().count();
                    Err(match count {
                        1 => "there is only 1 mode".to_owned(),
                        count => format!("there are only {count} modes"),
                    })
                }
            },
            Kind::Gain(from, to, band) => {
                if grows(modes) {
                    return Ok(None);
                }
                let decays = all_decay(modes);
                // Doubles do not show of a root near the axis on which side it is.
                if self.precision == Precision::Double && !decays {
                    let proven = scene.system().modes().map_err(|error| error.to_string())?;
                    if grows(&proven) {
                        return Ok(None);
                    }
                }
                if self.precision == Precision::Double && decays {
                    let highest = |all: Vec<(f64, f64)>| {
                        let all = all.into_iter();
                        all.max_by(|one, other| one.1.total_cmp(&other.1))
                    };
                    let known = peaks_in_doubles(scene, from, to, *band)?;
                    if let Some((_, gain)) = known.and_then(highest) {
                        return Ok(Some(gain));
                    }
                    let found = peaks_by_values(scene, modes, from, to, *band)?;
                    let last = found.iter().flatten().map(|(at, _)| *at);
                    let last = last.fold(0.0, f64::max);
                    match found.and_then(highest) {
                        // The limit is nowhere a value.
                        Some((at, gain)) if band.is_none() && at == last => return Ok(Some(gain)),
                        Some((at, _)) => {
                            let values = asked(scene, from_ref(from), from_ref(to)).at(&[at]);
                            let values = values.map_err(|error| error.to_string())?;
                            let value = values.functions().first().map(|one| one.values()[0]);
                            let value = value.and_then(FrequencyValue::known);
                            return Ok(value.map(|(value, _)| value.norm()));
                        }
                        None => {}
                    }
                }
                let within = |precision| largest_gain(scene, modes, from, to, *band, precision);
                let good = |(gain, bound): &(f64, f64)| *bound <= GOOD_GAIN * gain;
                let found = match within(self.precision)? {
                    Some(found) if self.precision == Precision::Double && !good(&found) => {
                        within(Precision::default())?
                    }
                    found => found,
                };
                Ok(found.filter(good).map(|(gain, _)| gain))
            }
            Kind::Rms(name, weighting) => {
                if scene.loss_factors().iter().any(|factor| *factor != 0.0) {
                    return Err("a spring with a `loss_factor` has no force in time".to_owned());
                }
                let noise = scene.noise().ok_or("the scene has no `noise`")?;
                if !is_moved(scene, name) {
                    return Err(unknown(scene, name));
                }
                if self.precision == Precision::Double {
                    let square = mean_square(scene, name, *weighting)?;
                    if let Some(square) = square {
                        return Ok(Some(square.value().sqrt()));
                    }
                }
                let solved = match weighting {
                    None => noise.solve(),
                    Some(weighting) => noise.weighted(*weighting),
                };
                let motion = match solved {
                    Ok(motion) => motion,
                    // It is infinite, or not known.
                    Err(
                        StateSpaceError::NotStationary { .. } | StateSpaceError::NotShownStationary,
                    ) => return Ok(None),
                    Err(error) => return Err(error.to_string()),
                };
                let mut all = motion.outputs().iter().chain(motion.displacement());
                let found = all.find(|of| of.name == *name);
                let found = found.and_then(|found| found.rms.finite());
                let good = found.filter(|(value, bound)| *value == 0.0 || bound / value <= GOOD);
                Ok(good.map(|(value, _)| value))
            }
            Kind::Peak(name) => peak(scene, self.precision, name),
            Kind::Settling(name) => settling(scene, modes, name),
        }
    }
}

/// Whether all roots but those at 0 are clearly to the left of the axis: near it, only a proof shows whether a gain is finite.
fn all_decay(modes: &Modes) -> bool {
    let decays = |root: &Eigenvalue| {
        let left = root.value.re < -1e-9 * root.value.norm();
        !root.is_doubtful() && (left || root.value.norm() == 0.0)
    };
    modes.eigenvalues().iter().all(decays)
}

/// The same by a proof where doubles do not show it.
pub fn decays(scene: &Scene, modes: &Modes) -> Result<bool, String> {
    if all_decay(modes) {
        return Ok(true);
    }
    let proven = scene.system().modes().map_err(|error| error.to_string())?;
    let decays = |root: &Eigenvalue| {
        let left = |bound| root.value.re + bound < 0.0;
        root.real_bound.is_some_and(left) || root.value.norm() == 0.0
    };
    Ok(proven.bounds() == Bounds::Proven && proven.eigenvalues().iter().all(decays))
}

/// Whether something grows: there is no steady motion then that a frequency response would describe.
fn grows(modes: &Modes) -> bool {
    modes
        .into_iter()
        .any(|mode| mode.motion() == Motion::Growing)
}

/// Each root but 0 with its damping ratio.
pub fn ratios(modes: &Modes) -> impl Iterator<Item = (f64, f64)> {
    let roots = modes.into_iter().map(|mode| mode.eigenvalue().value);
    let sizes = roots.map(|root| (root, root.norm()));
    let moving = sizes.filter(|(_, size)| *size > 0.0);
    // Of 0 the opposite would be −0.
    moving.map(|(root, size)| (size, 0.0 - root.re / size))
}

/// The largest magnitude at any frequency, or in a band, with a bound of its error; `None` where it is infinite or not known.
fn largest_gain(
    scene: &Scene,
    modes: &Modes,
    from: &String,
    to: &String,
    band: Option<(f64, f64)>,
    precision: Precision,
) -> Result<Option<(f64, f64)>, String> {
    let grid = peak_grid(scene.system(), modes, scene.loss_factors());
    let asked = asked(scene, from_ref(from), from_ref(to)).precision(precision);
    let features = asked.features(&grid).map_err(|error| error.to_string())?;
    let Some(features) = features.first() else {
        return Ok(None);
    };
    let Some((low, high)) = band else {
        return Ok(match features.largest_gain() {
            Some(LargestGain::Unbounded { .. }) | None => None,
            Some(LargestGain::Finite { gain, bound, .. }) => Some((gain, bound)),
        });
    };
    if !features.is_complete() {
        return Ok(None);
    }
    let ends = asked.at(&[low, high]).map_err(|error| error.to_string())?;
    let ends = ends.functions().iter().flat_map(|end| end.values());
    let ends = ends.map(|end| {
        end.known()
            .map(|(value, bound)| (value.norm(), bound.unwrap_or(f64::INFINITY)))
    });
    let within = |peak: &&Peak| (low..=high).contains(&peak.frequency().0);
    let peaks = features.peaks().iter().filter(within).map(Peak::gain);
    let all: Option<Vec<(f64, f64)>> = peaks.chain(ends).collect();
    // What may be larger by its bound than the largest counts with it.
    let larger = |one: (f64, f64), other: (f64, f64)| {
        let (low, high) = if one.0 < other.0 {
            (one, other)
        } else {
            (other, one)
        };
        (high.0, high.1.max(low.0 + low.1 - high.0))
    };
    Ok(all.and_then(|all| all.into_iter().reduce(larger)))
}

/// Frequency in rad/s and magnitude of each peak within a band, or at all frequencies, its ends and the highest frequency looked at
/// included; `None` where one is infinite, or something grows. By values that keep their digits where matrices in doubles do
/// not, most of them all.
pub fn peaks_by_values(
    scene: &Scene,
    modes: &Modes,
    from: &String,
    to: &String,
    band: Option<(f64, f64)>,
) -> Result<Option<Vec<(f64, f64)>>, String> {
    if grows(modes) {
        return Ok(None);
    }
    let roots = modes.eigenvalues().iter().map(|root| root.value);
    let roots: Vec<_> = roots.filter(|root| root.norm() > 0.0).collect();
    let (low, high) = band.unwrap_or((0.0, f64::INFINITY));
    let asked = asked(scene, from_ref(from), from_ref(to)).precision(Precision::Double);
    let peaks = asked.peaks_about(&roots, low, high);
    peaks.map_err(|error| error.to_string())
}

/// The same of matrices in doubles, where these have digits enough.
pub fn peaks_in_doubles(
    scene: &Scene,
    from: &String,
    to: &String,
    band: Option<(f64, f64)>,
) -> Result<Option<Vec<(f64, f64)>>, String> {
    let transfer = transfer(scene, from, to)?;
    let (low, high) = band.unwrap_or((0.0, f64::INFINITY));
    Ok(transfer.and_then(|transfer| transfer.peaks(scene.system(), low, high)))
}

/// One frequency response function in doubles.
pub fn transfer(scene: &Scene, from: &String, to: &String) -> Result<Option<Transfer>, String> {
    let transfer = asked(scene, from_ref(from), from_ref(to)).transfer();
    transfer.map_err(|error| error.to_string())
}

/// The mean square of an output or displacement under the scene's noise in doubles, where they determine it.
pub fn mean_square(
    scene: &Scene,
    name: &str,
    weighting: Option<Weighting>,
) -> Result<Option<MeanSquare>, String> {
    let noise = scene.noise().ok_or("the scene has no `noise`")?;
    let square = noise
        .mean_square(name, weighting)
        .map_err(|error| error.to_string())?;
    Ok(square.filter(|square| square.estimate() <= GOOD * square.value()))
}

/// What a root at λ that changes at a rate makes of |λ| and of −Re λ/|λ|.
pub fn rates(root: Complex<f64>, rate: Complex<f64>) -> [f64; 2] {
    let size = root.norm();
    let turn = (root.re * rate.im - root.im * rate.re) / size;
    [
        (root.conj() * rate).re / size,
        turn / size * (root.im / size),
    ]
}

/// Of modes, how their roots change with the matrices; `None` where one is repeated or not distinguished from others.
pub fn sensitivities<'a, 'm>(
    scene: &'a Scene,
    modes: impl Iterator<Item = &'m Mode>,
) -> Option<Vec<(Complex<f64>, Sensitivity<'a>)>> {
    let each = modes.map(|mode| {
        let sensitivity = Sensitivity::of(scene.system(), mode).ok()?;
        Some((mode.eigenvalue().value, sensitivity))
    });
    each.collect()
}

/// How far the numbers of a problem are from those of another beside it; `None` where loads differ too.
pub fn numbers_beside(here: &Problem<'_>, there: &Problem<'_>) -> Option<Vec<f64>> {
    (there.drives() == here.drives()).then(|| there.numbers_beyond(here))?
}

/// Refuses what has no linear motion in time.
pub fn motion(scene: &Scene) -> Result<Problem<'_>, String> {
    if let Some(first) = scene.switch_places().into_iter().next() {
        return Err(format!(
            "the scene has {first}, and this metric is for linear motions alone"
        ));
    }
    let problem = scene
        .problem()
        .ok_or("the scene has no `time`: add \"time\": {\"end\": …, \"step\": …}")?;
    problem.map_err(|error| error.to_string())
}

/// Whether an output, mass or point has this name.
fn is_moved(scene: &Scene, name: &str) -> bool {
    let points = scene.system().points().iter().map(|point| &point.name);
    let outputs = scene.outputs().iter().map(|output| &output.name);
    let mut known = outputs.chain(scene.system().names()).chain(points);
    known.any(|known| known == name)
}

/// No output, mass or point has this name.
fn unknown(scene: &Scene, name: &str) -> String {
    let outputs = scene.outputs().iter().map(|output| &output.name);
    let points = scene.system().points().iter().map(|point| &point.name);
    let known = outputs.chain(scene.system().names()).chain(points);
    let hint = did_you_mean(name, &known.collect::<Vec<_>>());
    format!("there is no output, mass or point {name:?}: {hint}")
}

/// The linear motion of an output, or of the displacement of a mass or point, as the one combination of its problem, and with it
/// its instants.
fn moving<'a>(
    scene: &'a Scene,
    precision: Precision,
    name: &str,
) -> Result<(Problem<'a>, Trajectory), String> {
    let problem = asked_of(scene, precision, name)?;
    let plan = ResponsePlan::of(&problem).map_err(|error| error.to_string())?;
    let trajectory = plan.run(&problem).map_err(|error| error.to_string())?;
    Ok((problem, trajectory))
}

/// The question that it answers.
fn asked_of<'a>(scene: &'a Scene, precision: Precision, name: &str) -> Result<Problem<'a>, String> {
    let output = scene.outputs().iter().find(|output| output.name == *name);
    let of = match output {
        Some(output) => output.of.clone(),
        None if is_moved(scene, name) => {
            Sum::Motions(vec![(Quantity::Displacement, name.to_owned(), 1.0)])
        }
        None => return Err(unknown(scene, name)),
    };
    let name = name.to_owned();
    let problem = motion(scene)?.to(precision);
    let problem = problem.with_combinations(vec![Combination { name, of }]);
    problem.map_err(|error| error.to_string())
}

impl Varied {
    /// The derivatives of the largest magnitude by the numbers: those of the motion at its instant.
    pub fn slopes_of_peak(
        &self,
        scene: &Scene,
        name: &str,
        values: &[f64],
        limits: &[(f64, f64)],
    ) -> Option<Vec<f64>> {
        let (problem, trajectory) = moving(scene, self.precision, name).ok()?;
        let extrema = Extrema::of(&problem, &trajectory)?;
        let rates = self.derivatives(values, Some(limits), &|other| {
            let there = asked_of(other, self.precision, name).ok()?;
            numbers_beside(&problem, &there)
        })?;
        let each = rates.iter();
        each.map(|rates| extrema.slope_of_largest(&problem, 0, rates))
            .collect()
    }
}

/// The largest magnitude at any time.
fn peak(scene: &Scene, precision: Precision, name: &str) -> Result<Option<f64>, String> {
    let (problem, trajectory) = moving(scene, precision, name)?;
    let extrema = Extrema::of(&problem, &trajectory);
    let peaks = extrema.as_ref().and_then(|extrema| extrema.output(0));
    Ok(peaks.map(|peaks| peaks.largest().value.abs()))
}

/// The last time of all outside 2 % of the largest deviation from where it comes to rest, if that is before the end.
fn settling(scene: &Scene, modes: &Modes, name: &str) -> Result<Option<f64>, String> {
    // Settling between the samples is known where the motion is proven.
    let (problem, trajectory) = moving(scene, Precision::default(), name)?;
    let summary = Summary::of(&problem, &trajectory, modes);
    let rests = summary.and_then(|summary| summary.combinations(&problem, &trajectory, modes));
    let rest = rests.and_then(|mut rests| rests.pop().flatten());
    Ok(rest.and_then(|rest| rest.settled))
}

/// The text of a value around the numbers at these places.
fn pieces(value: &Value, pointers: &[String]) -> Vec<(String, Option<usize>)> {
    let given = value.to_string();
    let mut sign = "vary".to_owned();
    while given.contains(&sign) {
        sign.push('y');
    }
    let mark = |k: usize| format!("{sign}-{k}");
    let mut marked = value.clone();
    for (k, pointer) in pointers.iter().enumerate() {
        if let Some(place) = marked.pointer_mut(pointer) {
            *place = Value::from(mark(k));
        }
    }
    let text = marked.to_string();
    let mut places: Vec<(usize, usize)> = (0..pointers.len())
        .filter_map(|k| Some((text.find(&format!("\"{}\"", mark(k)))?, k)))
        .collect();
    places.sort_unstable();
    let mut pieces = Vec::new();
    let mut from = 0;
    for (at, k) in places {
        pieces.push((text[from..at].to_owned(), Some(k)));
        from = at + mark(k).len() + 2;
    }
    pieces.push((text[from..].to_owned(), None));
    pieces
}

/// A JSON object in the order given.
pub fn object<'a>(entries: impl Iterator<Item = (&'a str, Option<f64>)>) -> String {
    let entries =
        entries.map(|(name, value)| format!("{}: {}", Value::from(name), Value::from(value)));
    format!("{{{}}}", entries.collect::<Vec<_>>().join(", "))
}

/// The place of a number of the scene as a JSON Pointer.
fn pointer(scene: &Value, path: &str) -> Result<String, String> {
    let is_number = |pointer: &str| scene.pointer(pointer).is_some_and(Value::is_number);
    if path.starts_with('/') {
        return match is_number(path) {
            true => Ok(path.to_owned()),
            false => Err(format!("--vary {path}: no number of the scene is there")),
        };
    }
    let (mut known, mut pointers) = (Vec::new(), Vec::new());
    let lists = scene.as_object().into_iter().flatten();
    for (list, items) in lists {
        for (i, item) in items.as_array().into_iter().flatten().enumerate() {
            let Some(name) = item.get("name").and_then(Value::as_str) else {
                continue;
            };
            let numbers = item.as_object().into_iter().flatten();
            for (key, _) in numbers.filter(|(_, value)| value.is_number()) {
                known.push(format!("{name}.{key}"));
                pointers.push(format!("/{list}/{i}/{key}"));
            }
        }
    }
    if let Some(at) = known.iter().position(|name| name == path) {
        return Ok(pointers.swap_remove(at));
    }
    let hint = match known[..] {
        [] => "no element with a number has a name".to_owned(),
        _ => did_you_mean(path, &known),
    };
    Err(format!(
        "--vary {path}: no number of the scene has this name, NAME.key or a JSON Pointer such as /springs/0/stiffness: {hint}"
    ))
}
