//! The modes as a table, as JSON, as CSV and as Markdown.

use std::f64::consts::TAU;
use std::io::{self, Write};

use eigentone_modes::{Bounds, Eigenvalue, Mode, Modes, Motion};
use num_complex::Complex;
use serde::Serialize;

use super::csv;
use super::number;
use super::table::{Align, Table};

/// Prints the modes of a system.
///
/// ```
/// use eigentone::prelude::*;
/// use eigentone::report::ModeReport;
///
/// let system = System::builder().mass("m", 1.0).spring(GROUND, "m", 4.0).build()?;
/// let modes = system.modes()?;
/// let report = ModeReport::new(&modes, system.names());
/// assert!(report.markdown().starts_with("| # | λ, 1/s"));
/// let mut json = Vec::new();
/// report.json(&mut json)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ModeReport<'a> {
    modes: &'a Modes,
    names: &'a [String],
    /// Whether these are some of the modes, and their count agrees.
    selected: Option<bool>,
}

impl<'a> ModeReport<'a> {
    /// A report of `modes`, with the coordinates' names in order.
    pub fn new(modes: &'a Modes, names: &'a [String]) -> ModeReport<'a> {
        ModeReport {
            modes,
            names,
            selected: None,
        }
    }

    /// The same, saying that these are some of the modes and whether a count confirms that none between
    /// them is missing.
    pub fn selected(self, counted: bool) -> ModeReport<'a> {
        ModeReport {
            selected: Some(counted),
            ..self
        }
    }

    /// The mode table in aligned columns, six significant digits, units in the header: one row for
    /// each conjugate pair or real root.
    pub fn text(&self) -> String {
        self.table().text() + &self.remarks()
    }

    /// The shapes in numbers, a column for each mode: real ones with their signs, others by size and phase. `None` where there are
    /// too many to look at.
    pub(super) fn shapes(&self) -> Option<String> {
        const MOST_MODES: usize = 8;
        const MOST_COORDINATES: usize = 24;
        let (modes, names) = (self.modes.as_slice(), self.names);
        if modes.is_empty() || modes.len() > MOST_MODES || names.len() > MOST_COORDINATES {
            return None;
        }
        let mut table = Table::default().column("mass", Align::Left, names);
        for (place, mode) in (1..).zip(modes) {
            let bounds = mode.shape_bound();
            let real = mode.shape().iter().all(|entry| entry.im == 0.0);
            let cells = mode.shape().iter().enumerate();
            let cells =
                cells.map(|(i, entry)| component(*entry, bounds.map(|bounds| bounds[i]), real));
            table = table.column(&place.to_string(), Align::Right, cells);
        }
        let text = table.text();
        let mut remark = "The largest entry of each is 1.".to_owned();
        if text.contains('∠') {
            remark += " Size ∠ phase where the masses do not pass through 0 together.";
        }
        if text.contains('?') {
            remark += " ?: not known to six digits.";
        }
        Some(text + &remark + "\n")
    }

    /// The same as a Markdown table.
    pub fn markdown(&self) -> String {
        let remarks = self.remarks().replace('\n', "\n\n");
        let gap = if remarks.is_empty() { "" } else { "\n" };
        self.table().markdown() + gap + remarks.trim_end_matches("\n\n") + gap
    }

    /// One JSON object with every finite root and every mode. Frequencies are in rad/s, time
    /// constants in s, roots and their bounds in 1/s; numbers are in the shortest form that reads
    /// back to the same double, and what there is no number for is null.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn json(&self, mut out: impl Write) -> io::Result<()> {
        serde_json::to_writer(&mut out, &Json::of(self))?;
        out.write_all(b"\n")
    }

    /// One row for each mode, its shape in two columns for each coordinate; all digits.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn csv(&self, mut out: impl Write) -> io::Result<()> {
        let mut header: Vec<String> = [
            "re [1/s]",
            "im [1/s]",
            "bound [1/s]",
            "real_bound [1/s]",
            "natural_frequency [rad/s]",
            "natural_frequency [Hz]",
            "damped_frequency [rad/s]",
            "damped_frequency [Hz]",
            "damping_ratio",
            "time_constant [s]",
            "motion",
            "multiplicity",
            "defective",
            "backward_error",
            "condition",
            "cluster",
            "doubtful",
        ]
        .map(str::to_owned)
        .to_vec();
        for name in self.names {
            header.extend([format!("shape re {name}"), format!("shape im {name}")]);
        }
        csv::row(&mut out, header)?;
        for mode in self.modes {
            let root = mode.eigenvalue();
            let mut row = vec![
                csv::number(root.value.re),
                csv::number(root.value.im),
                csv::optional(root.bound),
                csv::optional(root.real_bound),
                csv::number(mode.natural_frequency().radians_per_second()),
                csv::number(mode.natural_frequency().hertz()),
                csv::number(mode.damped_frequency().radians_per_second()),
                csv::number(mode.damped_frequency().hertz()),
                csv::optional(mode.damping_ratio()),
                csv::optional(mode.time_constant()),
                mode.motion().to_string(),
                whole(mode.multiplicity()),
                mode.is_defective()
                    .map_or_else(String::new, |defective| defective.to_string()),
                csv::number(mode.backward_error()),
                csv::optional(mode.condition()),
                whole(mode.cluster()),
                root.is_doubtful().to_string(),
            ];
            for component in mode.shape() {
                row.extend([csv::number(component.re), csv::number(component.im)]);
            }
            csv::row(&mut out, row)?;
        }
        Ok(())
    }

    pub(super) fn table(&self) -> Table {
        let of = |value: fn(&Mode) -> Option<(f64, f64)>| {
            number::known_column(self.modes.iter().map(value))
        };
        let numbers = (1..=self.modes.as_slice().len()).map(|k| k.to_string());
        Table::default()
            .column("#", Align::Right, numbers)
            .column("λ, 1/s", Align::Left, self.roots())
            .column(
                "ω_n, rad/s",
                Align::Point,
                of(|mode| within(mode, mode.natural_frequency().radians_per_second(), 1.0)),
            )
            .column(
                "f_n, Hz",
                Align::Point,
                of(|mode| within(mode, mode.natural_frequency().hertz(), 1.0 / TAU)),
            )
            .column(
                "f_d, Hz",
                Align::Point,
                of(|mode| {
                    let turns = mode.eigenvalue().value.im != 0.0;
                    within(mode, mode.damped_frequency().hertz(), 1.0 / TAU).filter(|_| turns)
                }),
            )
            .column("ζ", Align::Point, of(damping_ratio))
            .column("time constant, s", Align::Point, of(time_constant))
            .column("motion", Align::Left, self.modes.iter().map(motion))
    }

    /// λ of each mode, lined up by its real part.
    fn roots(&self) -> Vec<String> {
        let roots = || self.modes.iter().map(|mode| mode.eigenvalue());
        let real =
            number::known_column(roots().map(|root| Some((root.value.re, root.real_bound?))));
        let imaginary = number::known_column(
            roots().map(|root| Some((root.value.im, root.bound?)).filter(|(im, _)| *im != 0.0)),
        );
        let widths = real.iter().map(|cell| cell.chars().count());
        let wide = widths.max().unwrap_or(0);
        let cells = real.iter().zip(&imaginary).zip(roots());
        cells
            .map(|((re, im), root)| {
                let Complex { re: x, im: y } = root.value;
                match (root.is_doubtful(), y == 0.0) {
                    (false, true) => format!("{re:>wide$}"),
                    (false, false) => format!("{re:>wide$} ± {im}i"),
                    (true, true) => format!("{:>wide$}", number::doubtful(x)),
                    (true, false) => {
                        format!("{:>wide$} ± {}i", number::doubtful(x), number::doubtful(y))
                    }
                }
            })
            .collect()
    }

    /// What stands below the table, a line each.
    pub(super) fn remarks(&self) -> String {
        let doubtful = self.doubtful().map_or_else(String::new, |text| text + "\n");
        doubtful + &self.infinite()
    }

    /// How many roots are doubtful, if any are.
    fn doubtful(&self) -> Option<String> {
        let all = self.modes.eigenvalues();
        let count = all.iter().filter(|root| root.is_doubtful()).count();
        let (are, of) = (if count == 1 { "is" } else { "are" }, all.len());
        (count > 0).then(|| {
            format!(
                "?: {count} of {of} roots {are} doubtful: no bound is known for them, and what is printed may be far from any root"
            )
        })
    }

    /// Where roots at either end of those shown have others at the same place that are not shown.
    fn cut_off(&self) -> String {
        let modes = self.modes.iter();
        let ends = [("first", modes.clone().next()), ("last", modes.last())];
        let ends = ends.map(|(end, mode)| (end, mode.map_or((0, ""), |mode| self.more_at(mode))));
        let same_root = |mode: Option<&Mode>| mode.map(|mode| mode.eigenvalue().value);
        let one = same_root(self.modes.iter().next()) == same_root(self.modes.iter().last());
        let ends = ends.into_iter().skip(usize::from(one));
        let cut = ends.filter(|(_, (more, _))| *more > 0);
        let cut: Vec<String> = cut
            .map(|(end, (more, what))| match what {
                "" if more == 1 => format!("1 more equals the {end}"),
                "" => format!("{more} more equal the {end}"),
                _ if more == 1 => format!("1 more is {what} from the {end}"),
                _ => format!("{more} more are {what} from the {end}"),
            })
            .collect();
        match cut.is_empty() {
            true => String::new(),
            false => format!(", but {}", cut.join(" and ")),
        }
    }

    /// How many more roots there are at the place of a mode, conjugates left out, and what is said of them unless they are equal.
    fn more_at(&self, mode: &Mode) -> (usize, &'static str) {
        let own = mode.eigenvalue();
        let reach = |root: &Eigenvalue| root.bound.unwrap_or(0.0);
        let all = self.modes.eigenvalues().iter();
        let here = all.filter(|root| (root.value - own.value).norm() <= reach(root) + reach(&own));
        let (known, what) = match (mode.multiplicity(), mode.cluster()) {
            (Some(count), _) => (count, ""),
            (None, Some(count)) => (count, "not separated"),
            (None, None) => (0, ""),
        };
        (known.saturating_sub(here.count()), what)
    }

    fn infinite(&self) -> String {
        if let Some(counted) = self.selected {
            let shown = self.modes.eigenvalues().len();
            let of = 2 * self.names.len() - self.modes.infinite();
            return match counted {
                true => {
                    let more = self.cut_off();
                    format!("{shown} of {of} roots; none between them is missing{more}\n")
                }
                false => {
                    let reason = self.modes.plan().incomplete.map(|why| format!(": {why}"));
                    let reason = reason.unwrap_or_default();
                    format!(
                        "{shown} of {of} roots; whether some between them are missing is not known{reason}\n"
                    )
                }
            };
        }
        match self.modes.infinite() {
            0 => String::new(),
            1 => {
                "1 further root is infinite: a massless node has no motion of its own\n".to_owned()
            }
            k => format!(
                "{k} further roots are infinite: massless nodes have no motion of their own\n"
            ),
        }
    }
}

/// A quantity that the root's bound, times `scale`, bounds.
fn within(mode: &Mode, value: f64, scale: f64) -> Option<(f64, f64)> {
    let bound = mode.eigenvalue().bound?;
    Some((value, bound * scale))
}

/// ζ, and how far off it may be; of one whose sign is not known that it is nearly 0.
fn damping_ratio(mode: &Mode) -> Option<(f64, f64)> {
    let root = mode.eigenvalue();
    let (bound, real_bound) = (root.bound?, root.real_bound?);
    let size = root.value.norm();
    match mode.damping_ratio() {
        Some(ratio) => Some((ratio, (real_bound + ratio.abs() * bound) / size)),
        None if mode.motion() == Motion::Oscillating => Some((0.0, real_bound / size)),
        None => None,
    }
}

/// An entry of a shape, as far as six digits of it are known.
fn component(entry: Complex<f64>, bound: Option<f64>, real: bool) -> String {
    const SIX_DIGITS: f64 = 5e-7;
    let size = entry.norm();
    match bound {
        Some(bound) if bound <= SIX_DIGITS * size || size + bound == 0.0 => match real {
            true => number::significant(entry.re),
            false if size == 0.0 => "0".to_owned(),
            false => {
                // Above −180° and up to 180° as it is printed too, and 0 without a sign.
                let phase = match (entry.arg().to_degrees() * 1e3).round() / 1e3 {
                    -180.0 => 180.0,
                    phase => phase + 0.0,
                };
                format!(
                    "{} ∠{}°",
                    number::significant(size),
                    format!("{phase:.3}").replace('-', "−")
                )
            }
        },
        Some(bound) if size + bound < SIX_DIGITS => "< 5e−7".to_owned(),
        _ => "?".to_owned(),
    }
}

fn time_constant(mode: &Mode) -> Option<(f64, f64)> {
    let constant = mode.time_constant()?;
    let bound = mode.eigenvalue().real_bound?;
    let known = Some((constant, bound * constant * constant));
    known.filter(|(constant, bound)| bound < constant)
}

/// The motion, and how many roots coincide.
fn motion(mode: &Mode) -> String {
    let at_least = if mode.cluster().is_none() {
        "at least "
    } else {
        ""
    };
    let coincide = match (mode.multiplicity(), mode.cluster_found()) {
        (Some(k), _) if k > 1 => format!(", {k}-fold"),
        (None, Some(k)) if k > 1 => format!(", one of {at_least}{k} not separated"),
        _ => String::new(),
    };
    let defective = if mode.is_defective() == Some(true) {
        ", defective"
    } else {
        ""
    };
    format!("{}{coincide}{defective}", mode.motion())
}

fn whole(count: Option<usize>) -> String {
    count.map_or_else(String::new, |count| count.to_string())
}

/// The contract between this program and what reads its JSON: names and order stay.
#[derive(Serialize)]
struct Json<'a> {
    bounds: Bounds,
    eigenvalues: &'a [Eigenvalue],
    infinite: usize,
    /// Whether it is proved that no root that was asked for is missing.
    complete: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    selected: Option<SelectedJson>,
    modes: &'a [Mode],
}

/// There only where some of the modes were asked for.
#[derive(Serialize)]
struct SelectedJson {
    /// How many finite roots there are in all.
    of: usize,
    /// Whether a count confirms that none between those listed is missing.
    counted: bool,
}

impl<'a> Json<'a> {
    fn of(report: &ModeReport<'a>) -> Json<'a> {
        let ModeReport {
            modes,
            names,
            selected,
        } = *report;
        Json {
            bounds: modes.bounds(),
            eigenvalues: modes.eigenvalues(),
            infinite: modes.infinite(),
            complete: selected.unwrap_or(modes.is_complete()),
            selected: selected.map(|counted| SelectedJson {
                of: 2 * names.len() - modes.infinite(),
                counted,
            }),
            modes: modes.as_slice(),
        }
    }
}

#[cfg(test)]
mod tests {
    use eigentone_modes::{GROUND, System};

    use super::*;

    #[test]
    fn no_mode_is_some_of_none() {
        let massless = System::builder()
            .mass("m", 0.0)
            .spring(GROUND, "m", 1.0)
            .build();
        let massless = massless.unwrap();
        let modes = massless.modes().unwrap();
        let mut json = Vec::new();
        let report = ModeReport::new(&modes, massless.names()).selected(true);
        report.json(&mut json).unwrap();
        let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
        assert_eq!(json["modes"], serde_json::json!([]));
        assert_eq!(json["selected"]["of"], 0);
    }

    #[test]
    fn entries_show_the_digits_that_are_known() {
        let shown = |re, im, bound, real| component(Complex::new(re, im), bound, real);
        assert_eq!(shown(-0.5, 0.0, Some(1e-17), true), "−0.500000");
        assert_eq!(shown(0.0, -0.5, Some(1e-17), false), "0.500000 ∠−90.000°");
        assert_eq!(shown(0.5, -1e-9, Some(1e-17), false), "0.500000 ∠0.000°");
        assert_eq!(shown(-0.5, -1e-9, Some(1e-17), false), "0.500000 ∠180.000°");
        assert_eq!(shown(0.0, 0.0, Some(0.0), true), "0");
        assert_eq!(shown(0.5, 0.0, Some(1e-6), true), "?");
        assert_eq!(shown(0.5, 0.0, None, true), "?");
        assert_eq!(shown(1e-12, 0.0, Some(1e-12), true), "< 5e−7");
        assert_eq!(shown(0.5, 0.0, Some(f64::NAN), true), "?");
    }
}
