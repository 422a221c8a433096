//! All frequencies between 0 and ∞ at which a magnitude turns, each in an interval of its own.
//!
//! |H|² is covered by power series about points of the axis: of H, or of 1/H beside poles that are nearly on the axis, in Ω
//! and, beyond all poles, in 1/Ω. Those of H come from modes (`modal_series`), which know poles without damping too, and from a
//! factor at the point where modes in doubles have too few digits. With a(t) = |h|² of a series h, its slope has the sign of a
//! polynomial g(t) with bounds for the coefficients and for the rest. An interval is decided where g has one sign, or where g′ has one and g is known at both
//! ends; others are divided. Where one stays undecided, or the work is not worth it, nothing is said.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use eigentone_digits::{Ball, DoubleDouble, Magnitude, Real};

use super::dynamic_stiffness::{Block, Part};
use super::modal_functions::ModalFunctions;
use super::odd_powers::{Place, first_odd};
use super::orders::{Equations, Orders};
use super::ports::{Push, Reading};
use super::power_series::{
    Center, Entry, NoCenter, Number, Polynomial, PowerSeries, REACH, at_most, real, times,
};
use super::refinement::UPWARD;
use super::rigid::Split;

/// What is known of a magnitude at all frequencies.
pub(super) struct Turns {
    /// By rising frequency, and none elsewhere.
    pub(super) each: Vec<Turn>,
    /// Whether it falls before the first of them.
    pub(super) falls_at_first: bool,
    /// Whether it rises after the last of them, or is the same everywhere.
    pub(super) rises_at_last: bool,
    /// Whether H is real at all frequencies, or imaginary.
    pub(super) is_real: bool,
    /// The limit of |H| for Ω → 0 with its bound, where the equations of motion are regular there.
    pub(super) start: Option<(f64, f64)>,
    /// The limit for Ω → ∞ with its bound; infinite where that is proved, `None` where it is unknown.
    pub(super) limit: Option<(f64, f64)>,
}

/// The only turn in an interval.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    pub(super) ends: [f64; 2],
    /// Where it is known to be a pole on the axis: Ω, and a bound of how far it is from there.
    pub(super) pole: Option<(f64, f64)>,
}

impl Turn {
    /// Takes the place of a pole from proven frequencies of modes with their bounds, where one of them alone can be meant.
    pub(super) fn narrow<'a>(&mut self, proven: impl FnOnce() -> &'a Vec<(f64, f64)>) {
        let Some((place, off)) = self.pole else {
            return;
        };
        let near = proven().iter();
        let mut near = near.filter(|(at, bound)| (at - place).abs() <= off + bound);
        if let (Some(&(at, bound)), None) = (near.next(), near.next()) {
            self.pole = Some((at, bound)).filter(|_| bound < off).or(self.pole);
        }
    }
}

type Known = Result<Rc<Center>, NoCenter>;

/// By the number of equations, which outputs out of reach have none of, the direction, both ends, and the columns that were divided.
type Which = (usize, bool, u64, u64, Vec<(usize, usize)>);

/// Series about the points of one input's axes.
#[derive(Default)]
pub(super) struct Centers {
    known: HashMap<Which, Known>,
    work: u64,
    /// Those of modes, in doubles, for one output.
    products: u64,
}

/// Products of balls that may be spent on one input.
const MOST_WORK: u64 = 20_000_000;

/// Products of doubles that may be spent on one output.
const MOST_PRODUCTS: u64 = 300_000_000;

/// One function, in Ω or in 1/Ω.
struct Axis<'a> {
    /// Where series by modes answer, and up to where none does.
    modes: Option<(&'a ModalFunctions<'a>, f64)>,
    /// In 1/Ω.
    backward: bool,
    /// The first odd powers of x that |h|² and |1/h|² may have, if any.
    odd: [Option<usize>; 2],
    /// Whether h is real, or imaginary.
    is_real: bool,
    /// The number of coordinates; the equations have one more row and column, for output and input.
    n: usize,
    entries: Vec<Entry>,
    /// h is H times so many powers of x.
    power: i32,
    /// The powers that rows were divided by in Ω, or multiplied by in 1/Ω, without and with the row of the output.
    shifts: [usize; 2],
    orders: Rc<Orders>,
    /// The columns that were divided by powers of Ω, with the powers.
    lowered: Vec<(usize, usize)>,
}

/// The turns of what one input does to one output; `None` where they are not proved to be all. Modes, where they serve,
/// answer between the slowest and the fastest of them, at a hundredth of the time that a factor takes; else the axes meet at `middle`.
pub(super) fn turns(
    block: &Block,
    pushes: &[Push],
    reading: &Reading,
    middle: f64,
    modes: Option<&ModalFunctions<'_>>,
    centers: &mut Centers,
) -> Option<Turns> {
    /// So much slower and faster than all modes one series is enough, to 0 and to ∞.
    const BEYOND: f64 = 16.0;
    centers.products = 0;
    let mut axes = Axis::both(block, pushes, reading)?;
    let modes = modes.and_then(|modes| Some((modes, modes.rates()?)));
    // Where nothing that is read is reached they have nothing to add.
    let modes = modes.filter(|(modes, [_, most])| axes[0].n > 0 && modes.serve_up_to(*most));
    let mut middle = middle;
    if let Some((modes, [least, most])) = modes {
        middle = f64::exp2((most * BEYOND).log2().ceil());
        axes[0].modes = Some((modes, least / BEYOND));
    }
    covered(&axes, middle, centers).or_else(|| {
        // What is 0 everywhere as its parts cancel, which no digits show.
        axes[0].orders.is_zero().then(|| Turns {
            each: Vec::new(),
            falls_at_first: false,
            rises_at_last: true,
            is_real: axes[0].is_real,
            start: Some((0.0, 0.0)),
            limit: Some((0.0, 0.0)),
        })
    })
}

/// The same of the function in Ω and in 1/Ω.
fn covered(
    [forward, backward]: &[Axis<'_>; 2],
    middle: f64,
    centers: &mut Centers,
) -> Option<Turns> {
    let low = forward.cover(middle, centers)?;
    let high = backward.cover(middle.recip(), centers)?;
    let mut each = low.turns;
    // In 1/Ω no modes are asked for poles.
    each.extend(high.turns.into_iter().rev().map(|turn| Turn {
        ends: [turn.ends[1].recip(), turn.ends[0].recip()],
        pole: None,
    }));
    Some(Turns {
        each,
        falls_at_first: !low.rises_at_zero,
        rises_at_last: !high.rises_at_zero,
        is_real: forward.is_real,
        start: forward.at_zero(centers),
        limit: backward.at_zero(centers),
    })
}

/// What is known of one axis.
struct Cover {
    turns: Vec<Turn>,
    /// With x, from x = 0.
    rises_at_zero: bool,
}

impl Axis<'_> {
    /// In Ω, and in 1/Ω; `None` for powers that no quantity has.
    fn both(block: &Block, pushes: &[Push], reading: &Reading) -> Option<[Self; 2]> {
        let coordinates = block.coordinates();
        let place = |coordinate: usize| coordinates.binary_search(&coordinate).ok();
        let own = reading.of.iter();
        let own = own.filter_map(|(coordinate, part)| Some((place(*coordinate)?, part)));
        let own: Vec<(usize, &Part)> = own.collect();
        // What moves with its support alone has no equations.
        let (n, own, pushes) = match own.is_empty() || pushes.is_empty() {
            true => (0, Vec::new(), &[][..]),
            false => (coordinates.len(), own, pushes),
        };
        let mut entries: BTreeMap<(usize, usize), Polynomial> = BTreeMap::new();
        if n > 0 {
            let all = block.polynomials().into_iter();
            entries.extend(all.map(|(row, column, polynomial)| ((row, column), polynomial)));
        }
        let mut put = |at: (usize, usize), part: &Part, sign: f64| {
            let (power, value) = part.coefficient();
            let entry = entries.entry(at).or_insert([Number::ZERO; 3]);
            let slot = entry.get_mut(usize::try_from(power).ok()?)?;
            let value = value * sign;
            *slot = match slot.is_zero() {
                true => value,
                false => *slot + value,
            };
            Some(())
        };
        for push in pushes {
            put((place(push.coordinate)?, n), &push.part, 1.0)?;
        }
        for &(column, part) in &own {
            put((n, column), part, 1.0)?;
        }
        for part in &reading.more {
            put((n, n), part, -1.0)?;
        }
        let parts = pushes.iter().map(|push| &push.part);
        let parts: Vec<&Part> = parts
            .chain(own.iter().map(|(_, part)| *part))
            .chain(&reading.more)
            .collect();
        let lossless = !block.has_losses() && parts.iter().all(|part| part.is_real());
        // Where losses are: row, column and power of Ω.
        let within = block.losses().filter(|_| n > 0);
        let mut lost: Vec<(usize, usize, u32)> =
            within.map(|((row, column), _)| (row, column, 0)).collect();
        let read = own.iter().map(|(column, part)| (n, *column, *part));
        let read = read.chain(reading.more.iter().map(|part| (n, n, part)));
        let acts = pushes.iter();
        let acts = acts.filter_map(|push| Some((place(push.coordinate)?, n, &push.part)));
        let others = read.chain(acts).filter(|(_, _, part)| !part.is_real());
        lost.extend(others.map(|(row, column, part)| (row, column, part.power().unsigned_abs())));
        let exact = || -> Option<Equations> {
            let mut equations = Equations {
                real: block.terms().collect(),
                ..Equations::default()
            };
            let own = own.iter().map(|(column, part)| ((n, *column), *part, 1.0));
            let acts = pushes.iter().map(|push| (push.coordinate, &push.part));
            let acts = acts.filter_map(|(at, part)| Some(((place(at)?, n), part, 1.0)));
            let more = reading.more.iter().map(|part| ((n, n), part, -1.0));
            let all = own.chain(acts).chain(more);
            let all = all.map(|(place, part, sign)| (place, *part, sign));
            for (place, part, sign) in block
                .losses()
                .map(|(place, part)| (place, part, 1.0))
                .chain(all)
            {
                let (power, turns, product) = part.exact()?;
                let product = product.into_iter().map(|value| sign * value);
                equations.add(place, (power, turns), product)?;
            }
            Some(equations)
        };
        let exact = if n > 0 { exact() } else { None };
        let split = exact.as_ref().and_then(|exact| match block.free() {
            // The first power of what a support carries along may vanish in |h|².
            [] if !lost.is_empty() => Split::of(n, exact, &exact.carried(n)),
            [] => None,
            free => Split::of(n, exact, free),
        });
        let orders = Rc::new(Orders::of(n, exact));
        let powers = |polynomial: &Polynomial| {
            let known = polynomial.each_ref().map(|part| !part.is_zero());
            (0..3usize).filter(move |power| known[*power])
        };
        // Without dampers all is a function of Ω² too, if all powers of a row are even or all odd.
        let undamped = (0..=n).all(|row| {
            let own = entries.range((row, 0)..(row + 1, 0));
            let mut kinds =
                own.flat_map(|(_, polynomial)| powers(polynomial).map(|power| power % 2));
            let first = kinds.next();
            kinds.all(|kind| Some(kind) == first)
        });
        let axis = |backward: bool,
                    entries: &BTreeMap<(usize, usize), Polynomial>,
                    lowered: Vec<(usize, usize)>| {
            // The least and the largest power in each row.
            let mut spans: Vec<Option<(usize, usize)>> = vec![None; n + 1];
            for ((row, _), polynomial) in entries {
                for power in powers(polynomial) {
                    let (least, most) = spans[*row].unwrap_or((power, power));
                    spans[*row] = Some((least.min(power), most.max(power)));
                }
            }
            let spans: Vec<(usize, usize)> =
                spans.into_iter().map(Option::unwrap_or_default).collect();
            // Without the powers that all of a row have.
            let turned = |row: usize, polynomial: &Polynomial| {
                let (least, most) = spans[row];
                let mut turned = [Number::ZERO; 3];
                let own = polynomial.iter().enumerate().take(most + 1);
                for (power, part) in own.skip(least) {
                    turned[if backward {
                        most - power
                    } else {
                        power - least
                    }] = *part;
                }
                turned
            };
            let divided: usize = lowered.iter().map(|(_, power)| power).sum();
            let entries = entries
                .iter()
                .map(|(&(row, column), polynomial)| (row, column, turned(row, polynomial)));
            let entries: Vec<Entry> = entries.collect();
            // Those of sums of columns are not known.
            let lost = backward.then(|| {
                let each = lost.iter().map(|(row, column, power)| {
                    (*row, *column, spans[*row].1.saturating_sub(*power as usize))
                });
                each.collect::<Vec<Place>>()
            });
            Axis {
                modes: None,
                backward,
                odd: match lossless || undamped {
                    true => [None; 2],
                    false => first_odd(n, &entries, lost.as_deref()).map(Some),
                },
                is_real: lossless && undamped,
                n,
                entries,
                power: match backward {
                    true => spans[n].1 as i32,
                    false => -(spans[n].0 as i32),
                },
                shifts: [n, n + 1].map(|rows| {
                    let powers = spans[..rows].iter();
                    let powers = powers.map(|span| if backward { span.1 } else { span.0 });
                    powers.sum::<usize>() + divided
                }),
                orders: orders.clone(),
                lowered,
            }
        };
        let backward = axis(true, &entries, Vec::new());
        let forward = match split {
            Some(split) => axis(false, &split.entries, split.lowered),
            None => axis(false, &entries, Vec::new()),
        };
        Some([forward, backward])
    }

    /// From 0 to `end`.
    fn cover(&self, end: f64, centers: &mut Centers) -> Option<Cover> {
        /// What is narrower than this share of its place stays undecided.
        const NARROW: f64 = 1e-13;
        /// So near to 0 there is no use in looking.
        const NEAR: f64 = 1e-24;
        /// Where modes have no digits, narrower parts have none either.
        const BLIND: f64 = 1e-4;
        /// Where intervals are divided: no place of its own.
        const SHARE: f64 = 0.487_139;
        let mut cover = Cover {
            turns: Vec::new(),
            rises_at_zero: false,
        };
        let mut open = vec![[0.0, end]];
        while let Some([low, high]) = open.pop() {
            let undecided = match self.decide(low, high, centers) {
                Ok(decided) => {
                    if low == 0.0 {
                        cover.rises_at_zero = decided.rises_at_zero;
                    }
                    cover.turns.extend(decided.turns);
                    continue;
                }
                Err(undecided) => undecided,
            };
            // A wider part at 0 than up to there is not decided.
            let (narrow, reach) = match undecided {
                Undecided::Wide => (NARROW, high),
                Undecided::Blind => (BLIND, high),
                Undecided::Beyond(reach) => (NARROW, reach),
            };
            let hopeless = high - low < narrow * high || reach < NEAR * end;
            // Modes need few centres, but at 0 and ∞.
            let spent = match self.modes {
                Some(_) => centers.products > MOST_PRODUCTS || centers.work > 5 * MOST_WORK,
                None => centers.work > MOST_WORK,
            };
            if hopeless || spent {
                return None;
            }
            let between = (low + SHARE * (high - low)).min(reach);
            open.push([between, high]);
            open.push([low, between]);
        }
        Some(cover)
    }

    /// One interval.
    fn decide(&self, low: f64, high: f64, centers: &mut Centers) -> Result<Cover, Undecided> {
        /// Poles so near to the axis are not stepped around: by factors, and by modes, whose steps take hardly any time.
        const SHARP: [f64; 2] = [0.02, 1e-7];
        // Modes answer away from 0, as far as their digits go.
        let mut undecided = Undecided::Blind;
        if let Some((modes, first)) = self.modes {
            if low == 0.0 && high > first {
                return Err(Undecided::Wide);
            }
            if low > 0.0 {
                let mut decided = by_modes::<f64>(modes, low, high, self.is_real, centers);
                if decided.as_ref().is_err_and(|why| *why == Undecided::Blind) {
                    decided = by_modes::<DoubleDouble>(modes, low, high, self.is_real, centers);
                }
                match decided {
                    Ok(cover) => return Ok(cover),
                    Err(why) => undecided = why,
                }
            }
        }
        // How far series at 0 may reach.
        let mut reach = 0.0f64;
        if undecided == Undecided::Blind {
            match self.direct(low, high, centers) {
                Ok(center) => match self.by_series(&center, false, low, high, centers) {
                    Ok(cover) => return Ok(cover),
                    Err(Undecided::Beyond(to)) => reach = to,
                    Err(_) => reach = high,
                },
                Err(NoCenter::TooWide(radius)) => reach = REACH * radius,
                Err(NoCenter::Singular) => {}
            }
        }
        if self.modes.is_none() || low == 0.0 {
            undecided = Undecided::Wide;
        }
        let sharp = SHARP[usize::from(self.modes.is_some())];
        if low > 0.0 && high - low > sharp * high {
            return Err(undecided);
        }
        let (x, least) = about(low, high);
        let (center, work) = Center::of(self.n + 1, &self.entries, x, least);
        centers.work += work;
        let center = match center {
            Ok(center) => center,
            Err(_) if low > 0.0 => return Err(undecided),
            Err(NoCenter::TooWide(radius)) => {
                return Err(Undecided::Beyond(reach.max(REACH * radius)));
            }
            Err(NoCenter::Singular) => return Err(Undecided::Beyond(reach)),
        };
        let found = self.by_series(&center, true, low, high, centers);
        found.map_err(|why| match why {
            Undecided::Beyond(to) => Undecided::Beyond(reach.max(to)),
            _ => undecided,
        })
    }

    /// The equations of the system alone, which all outputs share.
    fn direct(&self, low: f64, high: f64, centers: &mut Centers) -> Result<Rc<Center>, NoCenter> {
        let lowered = self.lowered.clone();
        let key = (
            self.n,
            self.backward,
            low.to_bits(),
            high.to_bits(),
            lowered,
        );
        if let Some(known) = centers.known.get(&key) {
            return known.clone();
        }
        let own = self.entries.iter();
        let own: Vec<Entry> = own
            .filter(|(row, column, _)| *row < self.n && *column < self.n)
            .copied()
            .collect();
        let (x, least) = about(low, high);
        let (center, work) = Center::of(self.n, &own, x, least);
        centers.work += work;
        let center = center.map(Rc::new);
        centers.known.insert(key, center.clone());
        center
    }

    /// h, or 1/h up to its sign.
    fn series(&self, center: &Center, inverse: bool, count: usize, half: f64) -> PowerSeries {
        let n = self.n;
        if inverse {
            let one = [real(1.0), Number::ZERO, Number::ZERO];
            return center.series(&[(n, one)], &[(n, one)], &[Number::ZERO; 3], count, half);
        }
        let own = self.entries.iter();
        let right: Vec<(usize, Polynomial)> = own
            .clone()
            .filter(|(row, column, _)| *column == n && *row < n)
            .map(|(row, _, polynomial)| (*row, *polynomial))
            .collect();
        let output: Vec<(usize, Polynomial)> = own
            .clone()
            .filter(|(row, column, _)| *row == n && *column < n)
            .map(|(_, column, polynomial)| (*column, *polynomial))
            .collect();
        let direct = own
            .clone()
            .find(|(row, column, _)| *row == n && *column == n);
        let direct = direct.map_or([Number::ZERO; 3], |entry| entry.2.map(|part| -part));
        center.series(&right, &output, &direct, count, half)
    }

    /// One interval, by a series of h or 1/h.
    fn by_series(
        &self,
        center: &Center,
        inverse: bool,
        low: f64,
        high: f64,
        centers: &mut Centers,
    ) -> Result<Cover, Undecided> {
        /// At 0 the first powers may be missing, four for each mass on the way.
        const COUNTS: [usize; 4] = [20, 40, 80, 160];
        let counts = if low == 0.0 {
            &COUNTS[..]
        } else {
            &COUNTS[..1]
        };
        let x = center.place();
        for &count in counts {
            centers.work += (count * self.entries.len() * 2 + count * count) as u64;
            let mut series = self.series(center, inverse, count, high - x);
            let radius = series.radius;
            if x == 0.0 {
                self.clear(&mut series, inverse);
            }
            let power = if inverse { -self.power } else { self.power };
            let slope = Slope::of(&series, power, self.odd[usize::from(inverse)], x)
                .ok_or(Undecided::Wide)?;
            if low == 0.0 && slope.is_hidden() {
                return Err(Undecided::Beyond(0.0));
            }
            // |h|² is a ratio of polynomials of degree 4n + 4 or less: it is constant if it is for so many coefficients.
            if slope.is_zero() && count < 8 * self.n + 20 {
                continue;
            }
            let Some(turns) = slope.turns_between(low, high, x, radius) else {
                if 2 * slope.coefficients.len() > count {
                    return Err(Undecided::Wide);
                }
                continue;
            };
            return Ok(Cover {
                turns,
                rises_at_zero: slope.rises_at_zero() != inverse,
            });
        }
        Err(Undecided::Wide)
    }

    /// Makes the first coefficients at 0 what they are exactly, where they might be 0.
    fn clear(&self, series: &mut PowerSeries, inverse: bool) {
        let mut known = series.coefficients.iter();
        let first = known.find(|coefficient| !coefficient.is_zero());
        if first.is_none_or(|coefficient| !coefficient.contains_zero()) {
            return;
        }
        // The divisor is regular, or there would be no series.
        let at = usize::from(!inverse);
        let Some(order) = self.orders.get()[at] else {
            return;
        };
        let zeros = match self.backward {
            true => self.shifts[at].saturating_sub(order.most),
            false => order.least.saturating_sub(self.shifts[at]),
        };
        let count = series.coefficients.len();
        series.coefficients[..zeros.min(count)].fill(Number::ZERO);
    }

    /// The limit of |H| for x → 0.
    fn at_zero(&self, centers: &mut Centers) -> Option<(f64, f64)> {
        let found = centers.known.iter();
        let mut found = found.filter(|((n, backward, low, _, lowered), _)| {
            (*n, *backward, *low) == (self.n, self.backward, 0) && *lowered == self.lowered
        });
        let center = found.find_map(|(_, center)| center.clone().ok())?;
        if self.power < 0 {
            // h is finite there.
            return Some((0.0, 0.0));
        }
        let power = usize::try_from(self.power).ok()?;
        let mut series = self.series(&center, false, power + 1, f64::INFINITY);
        self.clear(&mut series, false);
        let (before, own) = series.coefficients.split_at(power);
        if before.iter().any(|coefficient| !coefficient.is_zero()) {
            return None;
        }
        let size = own.first()?.middle().norm();
        let unit = series.radius.powi(self.power);
        let (value, off) = (size / unit, own.first()?.radius().to_f64() / unit);
        let bound = off + value * 4.0 * f64::EPSILON;
        (value.is_finite() && bound.is_finite()).then_some((value, bound))
    }
}

/// Why an interval is not decided.
#[derive(Clone, Copy, PartialEq)]
enum Undecided {
    /// A narrower one may be.
    Wide,
    /// What is lost in the digits of modes hides the slope and its derivative at the centre, as where a function falls steeply.
    Blind,
    /// One at 0; none is that goes beyond this.
    Beyond(f64),
}

/// One interval away from 0, by modes in the precision of T: a series of H, or a pole of a function that is real.
fn by_modes<T: Real>(
    modes: &ModalFunctions<'_>,
    low: f64,
    high: f64,
    is_real: bool,
    centers: &mut Centers,
) -> Result<Cover, Undecided> {
    // What digits do not hide, the rest would.
    let count = if T::UNIT_LOG2 < -53 { 40 } else { 20 };
    let (x, least) = about(low, high);
    centers.products += modes.products(count);
    let mut undecided = Undecided::Wide;
    let mut by_series = || {
        let series = modes.series::<T>(x.into(), least, count)?.pop()?;
        let slope = Slope::of(&series, 0, Some(1), x)?;
        if slope.is_blind((high - x) / series.radius) {
            undecided = Undecided::Blind;
        }
        slope.turns_between(low, high, x, series.radius)
    };
    let turns = by_series();
    let by_pole = || {
        let pole = is_real.then(|| modes.pole(low, high))??;
        let is_within = low < pole.0 && pole.0 < high;
        let turn = Turn {
            ends: [low, high],
            pole: Some(pole),
        };
        Some(is_within.then_some(turn).into_iter().collect())
    };
    let turns = turns.or_else(by_pole).ok_or(undecided)?;
    Ok(Cover {
        turns,
        rises_at_zero: false,
    })
}

/// The point about which an interval is looked at, and the least ρ.
fn about(low: f64, high: f64) -> (f64, f64) {
    let x = if low == 0.0 {
        0.0
    } else {
        f64::midpoint(low, high)
    };
    (x, (high - x) / REACH)
}

/// A polynomial with the sign of d|h|²/dt, or of what it is for powers of x times h.
struct Slope {
    /// Coefficients with bounds, from the first that is not 0.
    coefficients: Vec<(f64, f64)>,
    /// A bound of the coefficient that follows the last; those beyond grow at most by (1 + 1/N)² each.
    next: f64,
    /// N.
    count: f64,
}

impl Slope {
    /// With a = |h|²: (x₀/ρ + t) a′ − 2P a, as |H|², or its inverse, is a divided by 2P powers of x; `odd` is the first odd power of
    /// x that a may have, if any.
    fn of(series: &PowerSeries, power: i32, odd: Option<usize>, x: f64) -> Option<Slope> {
        let down = series.largest.exponent();
        let sized = |value: Number| super::elimination::scaled(value, -down);
        let h: Vec<Number> = series.coefficients.iter().copied().map(sized).collect();
        let conj = |value: Number| Ball::new(value.middle().conj(), value.radius());
        let count = h.len();
        // The square of the bound holds for what |h|² is at complex t too.
        let largest = series.largest * Magnitude::power_of_two(-down);
        let square = |k: usize| {
            let pairs = (0..=k).filter(|i| !h[*i].is_zero() && !h[k - i].is_zero());
            let sum = pairs.fold(Number::ZERO, |sum, i| sum + h[i] * conj(h[k - i]));
            at_most(sum, largest * largest)
        };
        let squares: Vec<Number> = (0..count)
            .map(|k| {
                let is_odd = x == 0.0 && k % 2 == 1;
                match is_odd && odd.is_none_or(|first| k < first) {
                    true => Number::ZERO,
                    false => square(k),
                }
            })
            .collect();
        let power = f64::from(power);
        let far = x / series.radius;
        let slope = (0..count - 1).map(|k| {
            let at = k as f64;
            let own = times(squares[k], at - 2.0 * power);
            match far == 0.0 {
                true => own,
                false => own + times(squares[k + 1], (at + 1.0) * far),
            }
        });
        let slope: Vec<Number> = slope.collect();
        let first = slope.iter().position(|value| !value.is_zero());
        // Powers of t divide it where t ≥ 0.
        let first = if x == 0.0 { first } else { first.map(|_| 0) };
        let double = |value: &Number| {
            let middle: DoubleDouble = value.middle().re;
            let value_of = middle.to_f64();
            (
                value_of,
                value.radius().to_f64() + value_of.abs() * f64::EPSILON,
            )
        };
        let coefficients: Vec<(f64, f64)> = slope[first.unwrap_or(slope.len())..]
            .iter()
            .map(double)
            .collect();
        let count = (count - 1) as f64;
        let largest = largest.to_f64() * largest.to_f64() * UPWARD;
        let next = largest * (far.abs() * (count + 1.0) + count + 2.0 * power.abs());
        let known = coefficients
            .iter()
            .all(|(value, off)| value.is_finite() && off.is_finite());
        (known && next.is_finite()).then_some(Slope {
            coefficients,
            next,
            count,
        })
    }

    /// Whether all that is known of it is 0.
    fn is_zero(&self) -> bool {
        self.coefficients.is_empty()
    }

    /// Whether its sign at the centre is not known.
    fn is_hidden(&self) -> bool {
        let mut first = self.coefficients.iter();
        first.next().is_some_and(|(value, off)| value.abs() <= *off)
    }

    /// Whether a narrower interval than |t| ≤ `reach` does not help: its value at 0 is hidden, and so is its derivative, or what
    /// that changes on the way to the ends.
    fn is_blind(&self, reach: f64) -> bool {
        /// With hardly any digits only very narrow intervals are decided.
        const KNOWN: f64 = 4.0;
        let mut first = self.coefficients.iter();
        let (Some((value, off)), change) = (first.next(), first.next()) else {
            return false;
        };
        let changes = |(change, unknown): &(f64, f64)| {
            change.abs() > KNOWN * unknown && change.abs() * reach > KNOWN * off
        };
        value.abs() <= KNOWN * off && !change.is_some_and(changes)
    }

    /// Its sign at 0, if it was decided there.
    fn rises_at_zero(&self) -> bool {
        self.coefficients
            .first()
            .is_some_and(|(value, _)| *value > 0.0)
    }

    /// Bounds of the rest and of its derivative within |t| ≤ `reach`.
    fn rest(&self, reach: f64) -> [f64; 2] {
        let terms = self.coefficients.len() as i32;
        let grows = 1.0 + 1.0 / self.count;
        let sum = self.next / (1.0 - reach * grows * grows) * UPWARD;
        [
            sum * reach.powi(terms),
            sum * self.count * reach.powi(terms - 1),
        ]
    }

    /// Coefficients about another point, with bounds, rounding included.
    fn shifted(&self, to: f64) -> Vec<(f64, f64)> {
        let count = self.coefficients.len();
        let rounding = 4.0 * (count + 2) as f64 * f64::EPSILON;
        let mut shifted = self.coefficients.clone();
        for (value, off) in &mut shifted {
            *off += value.abs() * rounding;
        }
        for start in 0..count {
            for k in (start..count - 1).rev() {
                shifted[k].0 += to * shifted[k + 1].0;
                shifted[k].1 += to.abs() * shifted[k + 1].1;
            }
        }
        shifted
    }

    /// Its sign at a point.
    fn sign(&self, at: f64) -> Option<bool> {
        let (value, off) = *self.shifted(at).first()?;
        let off = (off + self.rest(at.abs())[0]) * UPWARD;
        (value.abs() > off).then_some(value > 0.0)
    }

    /// The turns between two frequencies, of a slope about x in parts of ρ.
    fn turns_between(&self, low: f64, high: f64, x: f64, radius: f64) -> Option<Vec<Turn>> {
        let ends = [low, high].map(|end| (end - x) / radius);
        // What the ends were rounded by.
        let spare = |end: f64| end.abs() * 1e-14;
        let low_end = if low == 0.0 {
            0.0
        } else {
            ends[0] - spare(ends[0])
        };
        let high_end = ends[1] + spare(ends[1]);
        let place = |t: f64| match t {
            _ if t <= low_end => low,
            _ if t >= high_end => high,
            _ => (x + radius * t).clamp(low, high),
        };
        let found = self.turns(low_end, high_end)?.into_iter();
        let turn = |ends: [f64; 2]| Turn {
            ends: ends.map(place),
            pole: None,
        };
        Some(found.map(turn).collect())
    }

    /// Intervals with one turn each, and none elsewhere between the ends; `None` where that is not decided.
    fn turns(&self, low: f64, high: f64) -> Option<Vec<[f64; 2]>> {
        /// How narrow a part may become.
        const NARROW: f64 = 1e-3;
        /// No place of its own.
        const SHARE: f64 = 0.513_872;
        let least = NARROW * (high - low);
        if self.is_zero() {
            return Some(Vec::new());
        }
        let mut found = Vec::new();
        let mut open = vec![[low, high]];
        while let Some([low, high]) = open.pop() {
            let middle = f64::midpoint(low, high);
            let width = (high - middle).max(middle - low);
            let shifted = self.shifted(middle);
            let [rest, change_rest] = self.rest(low.abs().max(high.abs()));
            let (mut off, mut change_off, mut power) = (rest, change_rest, 1.0);
            for (j, (value, error)) in shifted.iter().enumerate() {
                let size = if j == 0 { *error } else { value.abs() + error };
                let change = if j == 1 { *error } else { value.abs() + error };
                if j > 0 {
                    change_off += j as f64 * change * power;
                    power *= width;
                }
                off += size * power;
            }
            if shifted.first()?.0.abs() > off * UPWARD {
                continue;
            }
            let change = shifted.get(1).map_or(0.0, |(change, _)| change.abs());
            // At 0 it is not what a look says there.
            if change > change_off * UPWARD && low != 0.0 {
                match (self.sign(low)?, self.sign(high)?) {
                    (before, after) if before != after => found.push([low, high]),
                    _ => {}
                }
                continue;
            }
            if high - low < least {
                return None;
            }
            let between = low + SHARE * (high - low);
            open.push([between, high]);
            open.push([low, between]);
        }
        Some(found)
    }
}

#[cfg(test)]
mod tests {
    use eigentone_modes::{GROUND, System};

    use super::super::dynamic_stiffness::DynamicStiffness;
    use super::super::modal_sum::ModalSum;
    use super::super::phasor::Phase;
    use super::super::random::Random;
    use super::*;

    /// Every mass joined to every other, with dampers between some of them.
    fn full(n: usize, seed: u64, is_damped: bool) -> System {
        let mut numbers = Random(seed);
        let mut random = || 0.5 * (numbers.signed() + 1.0);
        let mut builder = System::builder();
        for i in 0..n {
            let name = format!("m{i}");
            builder = builder.mass(&name, 0.2 + random());
            builder = builder.spring(GROUND, &name, 1.0 + 9.0 * random());
            for j in 0..i {
                let other = format!("m{j}");
                builder = builder.spring(&name, &other, random());
                if is_damped && (i + j) % 2 == 0 {
                    builder = builder.damper(&name, &other, 0.1 * random());
                }
            }
        }
        if is_damped {
            builder = builder.damper(GROUND, "m0", 0.3);
        }
        builder.build().expect("a system")
    }

    /// As many turns at the same places as without modes, and series that are the same within their bounds.
    #[test]
    fn modes_and_factors_show_the_same_turns() {
        let systems = [(2, 1), (4, 2), (6, 3), (9, 4), (9, 5), (12, 6)];
        let systems = systems.map(|(n, seed)| [true, false].map(|is_damped| (n, seed, is_damped)));
        for (n, seed, is_damped) in systems.into_iter().flatten() {
            let system = full(n, seed, is_damped);
            let stiffness = DynamicStiffness::of(&system, &[]);
            let block = stiffness.block(&stiffness.reached(0..n));
            let sum = ModalSum::of(&system, stiffness).expect("modes");
            let pushes = [Push {
                coordinate: 0,
                part: Part::of(0, [1.0; 2]),
                phase: Phase::Zero,
            }];
            for (coordinate, power) in [(0, 0), (n - 1, 0), (n / 2, 1), (1, 2)] {
                let reading = Reading {
                    of: vec![(coordinate, Part::of(power, [1.0; 2]))],
                    more: Vec::new(),
                };
                let modes = ModalFunctions::of(&sum, &pushes, std::slice::from_ref(&reading));
                let modes = modes.expect("lengths");
                let [least, most] = modes.rates().expect("modes");
                let plain = || Axis::both(&block, &pushes, &reading).expect("quantities");
                let mut axes = plain();
                axes[0].modes = Some((&modes, least / 16.0));
                let mut centers = Centers::default();
                let by_modes = covered(&axes, 32.0 * most, &mut centers).expect("proven");
                let axes = plain();
                let by_factors = covered(&axes, 4.0, &mut Centers::default()).expect("proven");
                assert_eq!(by_modes.each.len(), by_factors.each.len());
                for (a, b) in by_modes.each.iter().zip(&by_factors.each) {
                    let (a, b) = (a.ends, b.ends);
                    assert!(a[0] <= b[1] && b[0] <= a[1], "{a:?} {b:?}");
                }
                assert_eq!(by_modes.falls_at_first, by_factors.falls_at_first);
                assert_eq!(by_modes.rises_at_last, by_factors.rises_at_last);
                // Without damping poles may be near.
                for x in [0.37, 1.9, 3.1].into_iter().filter(|_| is_damped) {
                    let one = modes.series::<f64>(x.into(), 1e-3, 12);
                    let one = one.and_then(|mut all| all.pop()).expect("regular");
                    let center = axes[0].direct(x - 4e-4, x + 4e-4, &mut centers);
                    let center = center.ok().expect("regular");
                    assert_eq!(center.place(), x);
                    let other = axes[0].series(&center, false, 12, 4e-4);
                    let (radius, own) = (one.radius, other.radius);
                    let (mut unit, mut shared) = (1.0, 1.0);
                    for (a, b) in one.coefficients.iter().zip(&other.coefficients) {
                        // The other function is divided by the power of Ω that its row has.
                        if power == 0 {
                            let off = (a.middle().re.to_f64() * shared
                                - b.middle().re.to_f64() * unit)
                                .hypot(
                                    a.middle().im.to_f64() * shared - b.middle().im.to_f64() * unit,
                                );
                            let [a, b] = [a, b].map(|value| value.radius().to_f64());
                            let bound = a * shared + b * unit;
                            assert!(off <= bound * UPWARD, "{off:e} {bound:e}");
                            let size = one.largest.to_f64();
                            assert!(a <= 1e-10 * size, "{a:e} {size:e}");
                        }
                        (unit, shared) = (unit / own, shared / radius);
                    }
                }
            }
        }
    }
}
